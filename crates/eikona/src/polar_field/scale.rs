//! The scale at each corner (PLPF section 4.4): only ratios matter, and they place the singular
//! points inside faces and edges.

use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation};
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::singularity::{Prescribed, name};
use crate::polar_field::smoothness::CornerLaplacian;
use eikona_mesh::{Face, FaceField, Halfedge, Located};
use eikona_numeric::NumericError;
use std::f64::consts::PI;

/// Logarithms of the scales that place a singular point, up to a constant, at corners of one face.
#[derive(Debug)]
pub(crate) struct Tie {
    pub face: Face,
    pub cycle: Cycle,
    pub logs: Vec<(Halfedge, f64)>,
}

/// Largest difference of logarithms of scales in a tie.
const MOST_SPREAD: f64 = 100.0;

impl Tie {
    fn spread(&self) -> f64 {
        let logs = || self.logs.iter().map(|(_, log)| *log);
        logs().fold(f64::NEG_INFINITY, f64::max) - logs().fold(f64::INFINITY, f64::min)
    }
}

/// The ties of all singular faces and edges, and those of them in which no scale places the
/// singular point.
#[derive(Debug, Default)]
pub(crate) struct Ties {
    pub ties: Vec<Tie>,
    pub unplaced: Vec<Cycle>,
}

/// Returns the ties of the singularities inside faces and edges, in closed form by the law of
/// sines.
pub(crate) fn ties(
    bevel: &BeveledMesh,
    singularities: &[Prescribed],
    theta: &Rotation,
    powers: &FaceField<u32>,
) -> Ties {
    let mut ties = Ties::default();
    for s in singularities.iter().filter(|s| s.turns != 0) {
        match (s.cycle, s.point) {
            (Cycle::Face(f), Some(Located::Face(_, weights))) => {
                let m = f64::from(powers[f]);
                let sign = s.turns.signum() as f64;
                // The linear field has a zero inside if its corners surround the origin.
                let surrounds =
                    |k: usize| (f64::MIN_POSITIVE..m * PI).contains(&(sign * theta.split[f.halfedge(k)]));
                if !(0..3).all(surrounds) {
                    ties.unplaced.push(s.cycle);
                    continue;
                }
                // Weight and opposite side of each corner.
                let log = |k: usize| {
                    let opposite = theta.split[f.halfedge((k + 1) % 3)];
                    m * ((opposite / m).sin().abs() / weights[k]).ln()
                };
                let logs = (0..3).map(|k| (f.halfedge(k), log(k))).collect();
                ties.place(s.cycle, vec![Tie { face: f, cycle: s.cycle, logs }]);
            }
            (Cycle::Edge(e), Some(Located::Edge(_, t))) => {
                let h = bevel.mesh.edge_halfedges(e)[0];
                let t = if bevel.mesh.follows_edge(h) { t } else { 1.0 - t };
                ties.place_on_edge(bevel, h, t, s, theta, powers);
            }
            _ => {}
        }
    }
    ties
}

impl Ties {
    /// Adds the ties of a point inside an edge, at `t` along `h`: one in each face.
    fn place_on_edge(
        &mut self,
        bevel: &BeveledMesh,
        h: Halfedge,
        t: f64,
        s: &Prescribed,
        theta: &Rotation,
        powers: &FaceField<u32>,
    ) {
        let twin = bevel.twin[h].expect("singular edges are inside the surface");
        // Phases at the ends of the edge, first end and second end, as the quad around the edge is
        // walked from the second end in the face of `h`.
        let own = [-theta.split[h], 0.0];
        let first = own[0] - theta.jump[h];
        let turn = PI * s.turns as f64;
        let other = [first - turn, first - theta.split[twin] - turn];
        let within = |[a, b]: [f64; 2]| (a.min(b), a.max(b));
        let (low, high) = (within(own).0.max(within(other).0), within(own).1.min(within(other).1));
        if low >= high {
            self.unplaced.push(s.cycle);
            return;
        }
        let phase = 0.5 * (low + high);
        let corners = [([h, h.next()], own), ([twin.next(), twin], other)];
        let ties = corners.map(|([at_first, at_second], [p, q])| {
            let face = at_first.face();
            let m = f64::from(powers[face]);
            let log = |angle: f64, weight: f64| m * ((angle / m).sin().abs() / weight).ln();
            let logs = vec![(at_first, log(q - phase, 1.0 - t)), (at_second, log(p - phase, t))];
            Tie { face, cycle: s.cycle, logs }
        });
        self.place(s.cycle, ties.into());
    }

    /// Adds the ties of a singularity, unless scales would overflow.
    fn place(&mut self, cycle: Cycle, ties: Vec<Tie>) {
        if ties.iter().all(|tie| tie.spread() < MOST_SPREAD) {
            self.ties.extend(ties);
        } else {
            self.unplaced.push(cycle);
        }
    }
}

/// How the scales were found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ScaleSearch {
    /// Number of rounds of the active set.
    pub rounds: usize,
    /// Number of corners at the bound.
    pub active: usize,
    /// Whether the rounds did not end, so that the scales are feasible but not the smoothest.
    pub gave_up: bool,
}

/// Most rounds of the active set.
const MOST_ROUNDS: usize = 60;
/// Most corners that join the active set in one round.
const MOST_JOINING: usize = 8;
/// Rounds in which the one active corner may move to the lowest place.
const FIRST_ROUNDS: usize = 2;
/// Scales below the bound by less count as equal to it; forces are compared with the largest one.
const TOLERANCE: f64 = 1e-9;
/// Relative rounding errors of scales. High powers need scales up to 1e10.
const ROUNDING: f64 = 1e-12;

/// The scale of a corner in terms of the smallest one tied to it.
struct Groups {
    /// The corner with the smallest scale of the group.
    leader: Vec<u32>,
    /// Its scale relative to the leader's, at least 1.
    factor: Vec<f64>,
}

/// Returns the smoothest scales of at least 1 with these ties.
///
/// The scales minimise the energy of the rotations. An active set holds the corners at which the
/// bound is attained; each round takes a back-substitution, and one restricted to the tied corners
/// for each new one.
pub(crate) fn smoothest_scales(
    bevel: &BeveledMesh,
    laplacian: &CornerLaplacian,
    ties: &[Tie],
) -> Result<(Vec<f64>, ScaleSearch), PolarFieldError> {
    let corners = bevel.mesh.halfedge_count();
    let mut search = ScaleSearch::default();
    if ties.is_empty() {
        return Ok((vec![1.0; corners], search));
    }
    let groups = Groups::of(ties, corners)?;
    let mut system = Saddle::new(bevel, laplacian, &groups, ties)?;
    let component = |c: usize| bevel.topology.component_of_face[Halfedge(c as u32).face()] as usize;
    let concerned: Vec<bool> = {
        let mut concerned = vec![false; bevel.topology.components.len()];
        ties.iter().for_each(|tie| concerned[component(tie.logs[0].0.index())] = true);
        concerned
    };
    // One corner per component fixes the scale, until the smallest one is known.
    for (c, _) in concerned.iter().enumerate().filter(|(_, concerned)| **concerned) {
        let tie = ties.iter().find(|tie| component(tie.logs[0].0.index()) == c).expect("it is concerned");
        system.activate(groups.leader[tie.logs[0].0.index()] as usize)?;
    }
    let mut scales = Vec::new();
    for round in 1..=MOST_ROUNDS {
        search.rounds = round;
        scales = system.solve()?;
        let mut changed = false;
        let pulling: Vec<usize> =
            system.active.iter().copied().filter(|&a| system.force_at(a) < -TOLERANCE).collect();
        for c in (0..concerned.len()).filter(|c| concerned[*c]) {
            let active: Vec<usize> = system.active.iter().copied().filter(|a| component(*a) == c).collect();
            let leaving: Vec<usize> = pulling.iter().copied().filter(|a| component(*a) == c).collect();
            let leaders = || (0..corners).filter(|&i| groups.leader[i] as usize == i && component(i) == c);
            let tolerance = scales.iter().fold(TOLERANCE, |m, x| m.max(ROUNDING * x));
            let is_free = |i: &usize| !active.contains(i);
            let mut below: Vec<usize> =
                leaders().filter(|&i| scales[i] < 1.0 - tolerance).filter(is_free).collect();
            below.sort_by(|a, b| scales[*a].total_cmp(&scales[*b]));
            let mut joining: Vec<usize> = Vec::new();
            for i in below {
                let near = |j: &usize| bevel.are_near(Halfedge(i as u32).face(), Halfedge(*j as u32).face());
                if joining.len() < MOST_JOINING && !joining.iter().any(near) {
                    joining.push(i);
                }
            }
            if round <= FIRST_ROUNDS && active.len() == 1 && !joining.is_empty() {
                // Any corner may be the first. The lowest one is a far better guess.
                system.deactivate(active[0]);
                joining.truncate(1);
            }
            changed |= !leaving.is_empty() || !joining.is_empty();
            leaving.into_iter().for_each(|a| system.deactivate(a));
            for i in joining {
                system.activate(i)?;
            }
        }
        search.active = system.active.len();
        if !changed {
            return Ok((groups.feasible(&scales), search));
        }
    }
    search.gave_up = true;
    Ok((groups.feasible(&scales), search))
}

impl BeveledMesh {
    /// Whether two faces are the same or share an edge.
    fn are_near(&self, f: Face, g: Face) -> bool {
        f == g || (0..3).any(|k| self.twin[f.halfedge(k)].is_some_and(|h| h.face() == g))
    }
}

impl Groups {
    /// Joins tied corners. Ties stay within faces, so a face with ties that form a cycle is a
    /// conflict.
    fn of(ties: &[Tie], corners: usize) -> Result<Groups, PolarFieldError> {
        let mut groups = Groups { leader: (0..corners as u32).collect(), factor: vec![1.0; corners] };
        for tie in ties {
            let (first, base) = tie.logs[0];
            for &(corner, log) in &tie.logs[1..] {
                let [a, b] = [first, corner].map(|c| c.index());
                if groups.leader[a] == groups.leader[b] {
                    return Err(PolarFieldError::Conflict { face: tie.face, element: name(tie.cycle) });
                }
                // Relative to the scale of `a`'s leader.
                let shift = (log - base).exp() * groups.factor[a] / groups.factor[b];
                let (from, to) = (groups.leader[b], groups.leader[a]);
                for c in (0..3).map(|k| tie.face.halfedge(k).index()) {
                    if groups.leader[c] == from {
                        groups.factor[c] *= shift;
                        groups.leader[c] = to;
                    }
                }
                groups.lead_by_the_smallest(tie.face);
            }
        }
        Ok(groups)
    }

    /// Returns the scales with exact ties, none below the bound.
    fn feasible(&self, scales: &[f64]) -> Vec<f64> {
        let of_leader = self.leader.iter().map(|&leader| scales[leader as usize].max(1.0));
        of_leader.zip(&self.factor).map(|(scale, factor)| scale * factor).collect()
    }

    fn lead_by_the_smallest(&mut self, face: Face) {
        let corners = [0, 1, 2].map(|k| face.halfedge(k).index());
        let leaders = corners.map(|c| self.leader[c]);
        for leader in leaders {
            let members: Vec<usize> = corners.into_iter().filter(|&c| self.leader[c] == leader).collect();
            let Some(&lowest) = members.iter().min_by(|a, b| self.factor[**a].total_cmp(&self.factor[**b]))
            else {
                continue;
            };
            let smallest = self.factor[lowest];
            for c in members {
                self.factor[c] /= smallest;
                self.leader[c] = lowest as u32;
            }
        }
    }
}

/// The equations of the smoothest scales with some corners at the bound: one row per tie and per
/// active corner, one constant per component.
struct Saddle<'a> {
    bevel: &'a BeveledMesh,
    laplacian: &'a CornerLaplacian,
    /// Ties: a fraction of a corner's scale less the scale of its leader.
    ties: Vec<[(usize, f64); 2]>,
    active: Vec<usize>,
    /// The response at the used corners to a unit force at each of them.
    used: Vec<usize>,
    place: Vec<u32>,
    response: Vec<Vec<f64>>,
    forces: Vec<f64>,
}

impl<'a> Saddle<'a> {
    fn new(
        bevel: &'a BeveledMesh,
        laplacian: &'a CornerLaplacian,
        groups: &Groups,
        ties: &[Tie],
    ) -> Result<Saddle<'a>, NumericError> {
        let mut rows = Vec::new();
        for tie in ties {
            for c in (0..3).map(|k| tie.face.halfedge(k).index()) {
                let leader = groups.leader[c] as usize;
                // Factors of high powers are large; the row is not.
                let row = [(c, 1.0 / groups.factor[c]), (leader, -1.0)];
                if leader != c && !rows.contains(&row) {
                    rows.push(row);
                }
            }
        }
        let mut system = Saddle {
            bevel,
            laplacian,
            active: Vec::new(),
            used: Vec::new(),
            place: vec![u32::MAX; bevel.mesh.halfedge_count()],
            response: Vec::new(),
            forces: Vec::new(),
            ties: rows,
        };
        let mut corners: Vec<usize> = system.ties.iter().flatten().map(|(c, _)| *c).collect();
        corners.sort_unstable();
        corners.dedup();
        corners.iter().for_each(|&c| system.place[c] = 0);
        for &c in &corners {
            system.add_used(c)?;
        }
        // The first columns miss the corners that came later: responses are symmetric.
        for j in 0..system.used.len() {
            for i in j + 1..system.used.len() {
                let value = system.response[i][j];
                system.response[j].push(value);
            }
        }
        Ok(system)
    }

    /// Adds a corner with the responses at the corners used so far and at itself.
    fn add_used(&mut self, corner: usize) -> Result<(), NumericError> {
        let place = self.used.len();
        self.used.push(corner);
        self.place[corner] = place as u32;
        let mut needed = vec![false; self.place.len()];
        self.used.iter().for_each(|&c| needed[c] = true);
        let mut force = vec![0.0; self.place.len()];
        force[corner] = 1.0;
        let x = self.laplacian.factor.solve_where(&force, |c| needed[c])?;
        self.response.push(self.used.iter().map(|&c| x[c]).collect());
        Ok(())
    }

    fn activate(&mut self, corner: usize) -> Result<(), NumericError> {
        if self.place[corner] == u32::MAX {
            self.add_used(corner)?;
            let last = self.used.len() - 1;
            for j in 0..last {
                let value = self.response[last][j];
                self.response[j].push(value);
            }
        }
        self.active.push(corner);
        Ok(())
    }

    fn deactivate(&mut self, corner: usize) {
        self.active.retain(|&a| a != corner);
    }

    /// The force that holds an active corner up, in the last solution, relative to the largest one.
    fn force_at(&self, corner: usize) -> f64 {
        let conditions = self.ties.len() + self.active.len();
        let largest = self.forces[..conditions].iter().fold(f64::MIN_POSITIVE, |m, f| m.max(f.abs()));
        let at = self.active.iter().position(|&a| a == corner);
        at.map_or(0.0, |i| self.forces[self.ties.len() + i] / largest)
    }

    fn solve(&mut self) -> Result<Vec<f64>, NumericError> {
        let active = self.active.iter().map(|&a| vec![(a, 1.0)]);
        let rows: Vec<Vec<(usize, f64)>> = self.ties.iter().map(|row| row.to_vec()).chain(active).collect();
        let components = self.bevel.topology.components.len();
        let component = |c: usize| self.bevel.topology.component_of_face[Halfedge(c as u32).face()] as usize;
        let mut number = vec![usize::MAX; components];
        let mut count = rows.len();
        for &(c, _) in rows.iter().flatten() {
            let number = &mut number[component(c)];
            if *number == usize::MAX {
                *number = count;
                count += 1;
            }
        }
        let mut matrix = vec![vec![0.0; count]; count];
        let mut rhs = vec![0.0; count];
        for (r, row) in rows.iter().enumerate() {
            for (s, other) in rows.iter().enumerate() {
                for &(a, x) in row {
                    for &(b, y) in other {
                        let [a, b] = [a, b].map(|c| self.place[c] as usize);
                        matrix[r][s] += x * y * self.response[b][a];
                    }
                }
            }
            for &(a, x) in row {
                matrix[r][number[component(a)]] += x;
                matrix[number[component(a)]][r] += x;
            }
            rhs[r] = if r < self.ties.len() { 0.0 } else { 1.0 };
        }
        let solution = eliminated(matrix, rhs);
        let mut force = vec![0.0; self.place.len()];
        for (row, f) in rows.iter().zip(&solution) {
            row.iter().for_each(|&(c, x)| force[c] += x * f);
        }
        let mut scales = self.laplacian.factor.solve(&force)?;
        for (c, scale) in scales.iter_mut().enumerate() {
            match number[component(c)] {
                usize::MAX => *scale = 1.0,
                i => *scale += solution[i],
            }
        }
        self.forces = solution;
        Ok(scales)
    }
}

/// Solves a small dense system by elimination with partial pivoting. Directions without a pivot get
/// zero.
fn eliminated(mut matrix: Vec<Vec<f64>>, mut rhs: Vec<f64>) -> Vec<f64> {
    let n = rhs.len();
    let largest = matrix.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| matrix[a][k].abs().total_cmp(&matrix[b][k].abs())).unwrap_or(k);
        matrix.swap(k, pivot);
        rhs.swap(k, pivot);
        if matrix[k][k].abs() <= 1e-14 * largest {
            continue;
        }
        for i in k + 1..n {
            let factor = matrix[i][k] / matrix[k][k];
            if factor != 0.0 {
                let (above, below) = matrix.split_at_mut(i);
                (k..n).for_each(|j| below[0][j] -= factor * above[k][j]);
                rhs[i] -= factor * rhs[k];
            }
        }
    }
    for k in (0..n).rev() {
        if matrix[k][k].abs() <= 1e-14 * largest {
            rhs[k] = 0.0;
            continue;
        }
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * rhs[j]).sum();
        rhs[k] = (rhs[k] - known) / matrix[k][k];
    }
    rhs
}
