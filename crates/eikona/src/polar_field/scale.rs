//! The scale at each corner (PLPF section 4.4): only ratios matter, and they place the singular
//! points inside faces and edges.

use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation};
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::responses::{Condition, Responses};
use crate::polar_field::singularity::{Prescribed, name};
use crate::polar_field::smoothness::CornerLaplacian;
use eikona_mesh::{Face, FaceField, Halfedge, Located};
use eikona_numeric::{Cholesky, NumericError};
use std::collections::{BTreeMap, BTreeSet};
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
                    log_scale((opposite / m).sin(), weights[k], m)
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

/// Returns the logarithm of the scale of a corner with this weight, from the sine of the angle that
/// is opposite.
fn log_scale(sine: f64, weight: f64, power: f64) -> f64 {
    power * (sine.abs() / weight).ln()
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
            let log = |angle: f64, weight: f64| log_scale((angle / m).sin(), weight, m);
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
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ScaleSearch {
    /// Number of rounds of the active set.
    pub rounds: usize,
    /// The corners at the bound.
    pub active: Vec<u32>,
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

impl Groups {
    /// Returns the corner of a leader's group with the largest scale.
    fn largest(&self, leader: u32) -> u32 {
        let face = Halfedge(leader).face();
        let members = (0..3).map(|k| face.halfedge(k).0).filter(|c| self.leader[*c as usize] == leader);
        let factor = |c: &u32| self.factor[*c as usize];
        members.max_by(|a, b| factor(a).total_cmp(&factor(b))).unwrap_or(leader)
    }
}

/// Returns the smoothest scales of at least 1 with these ties.
///
/// The scales minimise the energy of the rotations. An active set holds the corners at which the
/// bound is attained, `guess` at first; each round takes a backward sweep, and a half solution for
/// each new corner. The result depends on the guess in its last digits only.
pub(crate) fn smoothest_scales(
    bevel: &BeveledMesh,
    laplacian: &CornerLaplacian,
    ties: &[Tie],
    guess: &[u32],
) -> Result<(Vec<f64>, ScaleSearch), PolarFieldError> {
    let corners = bevel.mesh.halfedge_count();
    let mut search = ScaleSearch::default();
    if ties.is_empty() {
        return Ok((vec![1.0; corners], search));
    }
    let groups = Groups::of(ties, corners)?;
    let mut system = Saddle::new(bevel, laplacian, &groups, ties)?;
    system.activate(&first_guess(bevel, &groups, ties, guess))?;
    let mut scales = Vec::new();
    for round in 1..=MOST_ROUNDS {
        search.rounds = round;
        scales = system.solve()?;
        let leaving: Vec<u32> =
            system.active.iter().copied().filter(|&a| system.force_at(a) < -TOLERANCE).collect();
        let mut joining = lowest(bevel, &groups, &scales, &system.active);
        if leaving.is_empty() && joining.is_empty() {
            search.active = system.active;
            return Ok((groups.feasible(&scales), search));
        }
        leaving.into_iter().for_each(|a| system.deactivate(a));
        for (&component, lowest) in &mut joining {
            let mut active = system.active.iter().filter(|a| bevel.component_of_corner(**a) == component);
            if let (Some(&only), None) = (active.next(), active.next())
                && round <= FIRST_ROUNDS
            {
                // Any corner may be the first. The lowest one is a far better guess.
                system.deactivate(only);
                lowest.truncate(1);
            }
            system.activate(lowest)?;
        }
    }
    search.gave_up = true;
    search.active = system.active;
    Ok((groups.feasible(&scales), search))
}

/// Returns the corners to start with: the guess, and one in each other component with ties, which
/// fixes the scale there until the smallest one is known.
fn first_guess(bevel: &BeveledMesh, groups: &Groups, ties: &[Tie], guess: &[u32]) -> Vec<u32> {
    let mut waiting: BTreeMap<usize, u32> = BTreeMap::new();
    for corner in ties.iter().rev().map(|tie| tie.logs[0].0.0) {
        waiting.insert(bevel.component_of_corner(corner), groups.leader[corner as usize]);
    }
    let of_guess = guess.iter().map(|&corner| groups.leader[corner as usize]);
    let mut first: Vec<u32> =
        of_guess.filter(|leader| waiting.contains_key(&bevel.component_of_corner(*leader))).collect();
    first.sort_unstable();
    first.dedup();
    first.iter().for_each(|&leader| _ = waiting.remove(&bevel.component_of_corner(leader)));
    first.extend(waiting.values());
    first
}

/// Returns the corners with the lowest scales below the bound, apart from each other, for each
/// component that has some.
fn lowest(bevel: &BeveledMesh, groups: &Groups, scales: &[f64], active: &[u32]) -> BTreeMap<usize, Vec<u32>> {
    let tolerance = scales.iter().fold(TOLERANCE, |m, x| m.max(ROUNDING * x));
    // Rounding may leave active corners below the bound.
    let is_below = |&c: &u32| {
        groups.leader[c as usize] == c && scales[c as usize] < 1.0 - tolerance && !active.contains(&c)
    };
    let mut below: Vec<u32> = (0..scales.len() as u32).filter(is_below).collect();
    below.sort_by(|a, b| scales[*a as usize].total_cmp(&scales[*b as usize]));
    let mut chosen: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    for corner in below {
        let chosen = chosen.entry(bevel.component_of_corner(corner)).or_default();
        let near = |other: &u32| bevel.are_near(Halfedge(corner).face(), Halfedge(*other).face());
        if chosen.len() < MOST_JOINING && !chosen.iter().any(near) {
            chosen.push(corner);
        }
    }
    chosen
}

impl BeveledMesh {
    fn component_of_corner(&self, corner: u32) -> usize {
        self.component_of(Cycle::Face(Halfedge(corner).face()))
    }

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

/// The equations of the smoothest scales with some corners at the bound: a condition per tie and
/// per active corner, one constant per component.
struct Saddle<'a> {
    bevel: &'a BeveledMesh,
    factor: &'a Cholesky<f64>,
    responses: Responses<'a>,
    groups: &'a Groups,
    /// Ties: the scale of a corner, divided by its factor, less that of its leader.
    ties: Vec<Condition>,
    active: Vec<u32>,
    forces: Vec<f64>,
}

impl<'a> Saddle<'a> {
    fn new(
        bevel: &'a BeveledMesh,
        laplacian: &'a CornerLaplacian,
        groups: &'a Groups,
        ties: &[Tie],
    ) -> Result<Saddle<'a>, NumericError> {
        let corners = ties.iter().flat_map(|tie| (0..3).map(|k| tie.face.halfedge(k).0));
        let tied: BTreeSet<u32> = corners.filter(|&c| groups.leader[c as usize] != c).collect();
        let tie = |c: u32| {
            let (leader, factor) = (groups.leader[c as usize], groups.factor[c as usize]);
            Condition { row: vec![(c, 1.0 / factor), (leader, -1.0)], ..Condition::default() }
        };
        let rows: Vec<Condition> = tied.into_iter().map(tie).collect();
        let mut responses = laplacian.responses();
        responses.include(rows.iter().flat_map(|tie| &tie.row).map(|&(c, _)| c))?;
        Ok(Saddle {
            bevel,
            factor: &laplacian.factor,
            responses,
            groups,
            ties: rows,
            active: Vec::new(),
            forces: Vec::new(),
        })
    }

    fn activate(&mut self, corners: &[u32]) -> Result<(), NumericError> {
        self.active.extend_from_slice(corners);
        self.responses.include(corners.iter().map(|&leader| self.groups.largest(leader)))
    }

    fn deactivate(&mut self, corner: u32) {
        self.active.retain(|&a| a != corner);
    }

    /// The force that holds an active corner up, in the last solution, relative to the largest one.
    fn force_at(&self, corner: u32) -> f64 {
        let largest = self.forces.iter().fold(f64::MIN_POSITIVE, |m, f| m.max(f.abs()));
        let at = self.active.iter().position(|&a| a == corner);
        at.map_or(0.0, |i| self.forces[self.ties.len() + i] / largest)
    }

    /// The condition that a group is at the bound, in terms of its largest scale: that of its
    /// leader hardly differs from the ties if the factor is large.
    fn bound(&self, leader: u32) -> Condition {
        let corner = self.groups.largest(leader);
        let row = vec![(corner, 1.0 / self.groups.factor[corner as usize])];
        Condition { row, wanted: 1.0, compliance: 0.0 }
    }

    fn solve(&mut self) -> Result<Vec<f64>, NumericError> {
        let active = self.active.iter().map(|&leader| self.bound(leader));
        let conditions: Vec<Condition> = self.ties.iter().cloned().chain(active).collect();
        // The forces on a component add up to zero, which determines its constant.
        let at_constant: Vec<f64> =
            conditions.iter().map(|condition| condition.row.iter().map(|(_, x)| x).sum()).collect();
        let wanted: Vec<f64> = conditions.iter().map(|condition| condition.wanted).collect();
        let matrix = self.responses.matrix(&conditions)?.factor()?;
        let (wanted, of_constants) = (matrix.solve(&wanted)?, matrix.solve(&at_constant)?);
        let component = |corner: u32| self.bevel.component_of_corner(corner);
        let mut sums = vec![[0.0; 2]; self.bevel.topology.components.len()];
        for (r, condition) in conditions.iter().enumerate() {
            let sums = &mut sums[component(condition.row[0].0)];
            sums[0] += at_constant[r] * wanted[r];
            sums[1] += at_constant[r] * of_constants[r];
        }
        // Components without conditions keep the scale 1.
        let constants: Vec<f64> = sums.iter().map(|[a, b]| if *b > 0.0 { a / b } else { 1.0 }).collect();
        let force = |(r, condition): (usize, &Condition)| {
            wanted[r] - constants[component(condition.row[0].0)] * of_constants[r]
        };
        self.forces = conditions.iter().enumerate().map(force).collect();
        let mut half = self.factor.half_solve(&vec![0.0; self.bevel.mesh.halfedge_count()])?;
        self.responses.push(&conditions, self.forces.iter().copied(), &mut half);
        let mut scales = self.factor.complete(&half)?;
        for (c, scale) in scales.iter_mut().enumerate() {
            *scale += constants[component(c as u32)];
        }
        // Small scales are lost in the rounding of large ones.
        for tie in &self.ties {
            let ([(c, _), (leader, _)], factor) = ([tie.row[0], tie.row[1]], &self.groups.factor);
            let largest = self.groups.largest(leader) as usize;
            let smallest = scales[largest] / factor[largest];
            scales[leader as usize] = smallest;
            scales[c as usize] = smallest * factor[c as usize];
        }
        Ok(scales)
    }
}
