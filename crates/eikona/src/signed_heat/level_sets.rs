//! Level set constraints (SHM section 7.1): fits that are zero or constant along the curves,
//! exactly or by a penalty.
//!
//! Each of these fits factors the Laplacian again, with terms at the curves: 65 ms of 140 ms per
//! solve on 100,820 faces. Conjugate gradients preconditioned by the factor of the free fit, which
//! every source could share, are slower. One of its back-substitutions takes 9.7 ms, so the error
//! would have to fall to 1e-9 within six iterations, which by the usual bound needs a condition
//! number below 1.12. Measured with that factor alone: 14 iterations for a weight of 100 on a
//! closed circle; for 1e6, which is as good as exact, an error of 3e-6 after 400 iterations, and
//! 2e-3 with the curve in 200 pieces. An additional scaling along the curves was not tried: it
//! would have to be nearly exact, also at the ends of open curves.

use crate::Warning;
use crate::geometry::Triangle;
use crate::geometry::vector::distance;
use crate::operators::CotanLaplacian;
use crate::signed_heat::automatic::ChosenLevelSets;
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::integration::{
    Ground, Integrated, Integration, at_vertex, grounded_matrix, largest, relative_residual,
};
use crate::signed_heat::options::LevelSets;
use crate::signed_heat::refinement::refined;
use crate::signed_heat::source::Source;
use eikona_mesh::{Located, Segment, SegmentHost, TriangleMesh, UnionFind};
use eikona_numeric::{
    Cholesky, ConjugateGradient, NumericError, Ordering, Symbolic, SymmetricMatrix, check_stopped,
};
use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// An isolated point has the weight of a curve of this length, relative to the surface's size.
const POINT_LENGTH: f64 = 0.01;

/// Constraint on the curves and points of one connected component of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Constraint {
    /// Zero: exactly at vertices and isolated points, up to the square of the edge length along
    /// curves inside edges and faces.
    Zero,
    /// The same, but with one level per connected piece of the curves, determined by the fit.
    OwnLevels,
    /// Near zero: the penalty is half this weight times the integral of the squared distance along
    /// the curves. Unit: one over length.
    Soft(f64),
}

/// Constrained place: a linear combination of vertex values.
///
/// Vertices and isolated points are constrained exactly, by the penalty and a multiplier. Curves
/// inside edges and faces are constrained by a penalty only: [`ALONG_CURVES`] times the integral of
/// the squared distance along the curve, over the size of the edge or face.
///
/// Deviation: section 7.1 constrains all nodes exactly. A curve that crosses `n` edges touches only
/// about `n` vertices, so exact rows leave the function no freedom there. Unless the curve happens
/// to be an isoline of a function that is linear in every face, the distance becomes flat along the
/// whole strip of crossed faces, and is off by the width of the strip (test
/// `zero_does_not_lock_on_a_polyline`).
pub(super) struct Row {
    pub place: Place,
    pub weight: f64,
    exact: bool,
    /// Connected piece of the curves that the row belongs to.
    pub group: u32,
    /// Unknown that holds the level; `None` if the level is zero.
    level: Option<u32>,
}

impl Row {
    /// Returns the constraint violation: the value at the place minus its level.
    fn violation(&self, unknowns: &[f64]) -> f64 {
        self.place.value(unknowns) - self.level.map_or(0.0, |level| unknowns[level as usize])
    }
    /// Adds a multiple of the row to a vector of unknowns.
    fn add_to(&self, unknowns: &mut [f64], factor: f64) {
        self.place.weights().iter().for_each(|&(v, w)| unknowns[v as usize] += w * factor);
        if let Some(level) = self.level {
            unknowns[level as usize] -= factor;
        }
    }
}

/// Point as a linear combination of the vertices of its face.
#[derive(Clone, Copy)]
pub(super) struct Place {
    weights: [(u32, f64); 3],
    count: usize,
}

impl Place {
    fn of(mesh: &TriangleMesh, point: Located) -> Place {
        let mut place = Place { weights: [(0, 0.0); 3], count: 0 };
        for (v, w) in point.weights(mesh) {
            place.weights[place.count] = (v.0, w);
            place.count += 1;
        }
        place
    }
    fn weights(&self) -> &[(u32, f64)] {
        &self.weights[..self.count]
    }
    pub fn value(&self, phi: &[f64]) -> f64 {
        self.weights().iter().map(|&(v, w)| w * phi[v as usize]).sum()
    }
    fn some_vertex(&self) -> usize {
        self.weights[0].0 as usize
    }
}

/// Penalty of the augmented Lagrangian. Rows and operator are dimensionless, with entries of order
/// one. A larger penalty needs fewer iterations, and loses as many of the sixteen digits as it has
/// zeros.
const PENALTY: f64 = 1e6;
/// Dimensionless penalty along curves inside edges and faces. The fit then deviates from the curve
/// by the square of the edge length, as interpolation does. Measured: 3 to 30 give the same errors.
const ALONG_CURVES: f64 = 10.0;
/// Tolerance on constraint violations, relative to the largest value.
const CONSTRAINT_TOLERANCE: f64 = 1e-10;
/// Most conjugate gradient iterations, of one back-substitution each. Three are typical.
const CONSTRAINT_ITERATIONS: usize = 50;
/// Larger violations of exact constraints raise a warning, relative to the largest value.
const CONSTRAINT_WARNING: f64 = 1e-8;
/// Smaller violations are rounding errors, relative to the surface's size.
const CONSTRAINT_ROUNDING: f64 = 1e-14;

impl Integration {
    /// Returns the same constraint for all components; `None` for [`LevelSets::Free`] and
    /// [`LevelSets::Automatic`].
    ///
    /// Deviation: the penalty of section 7.1 is an integral along the curves here, and so
    /// independent of the resolution. The paper prints `C - lambda A^T A`, but the penalty must be
    /// added.
    pub fn constraints(&self, level_sets: LevelSets) -> Option<Vec<Constraint>> {
        let all = |constraint| Some(vec![constraint; self.component_count]);
        match level_sets {
            LevelSets::Automatic | LevelSets::Free => None,
            LevelSets::Zero => all(Constraint::Zero),
            LevelSets::PerComponent => all(Constraint::OwnLevels),
            LevelSets::Soft(weight) => {
                Some(self.size_of_component.iter().map(|size| Constraint::Soft(weight / size)).collect())
            }
        }
    }

    /// Computes the fit with one constraint per component.
    ///
    /// Augmented Lagrangian: each row of the constraints `A` touches only the vertices of one face,
    /// so `C + A^T W A` has the pattern of `C`. Its factor costs one numeric factorisation with the
    /// existing symbolic analysis, needs no grounding in components with a row, and allows linearly
    /// dependent rows (several nodes in one face, duplicated curves), which make the saddle point
    /// system of eq. 14 singular. Conjugate gradients find the multipliers: thanks to the penalty,
    /// all but the nearly dependent rows have eigenvalues close to `1 / w`, so a handful of
    /// iterations suffices. A free level is one more unknown, see
    /// [`penalised`](Integration::penalised).
    pub fn constrained(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        b: &[f64],
        source: &Source,
        constraints: &[Constraint],
    ) -> Result<Integrated, SignedHeatError> {
        let (mut rows, groups) = self.rows(mesh, triangles, source, constraints);
        check_stopped()?;
        let levels = self.free_levels(&mut rows, groups, constraints);
        let at_vertex = |fault| at_vertex(at_piece(fault, &rows));
        let (symbolic, matrix) = self.penalised(mesh, &rows, levels).map_err(at_vertex)?;
        check_stopped()?;
        self.memory.check(symbolic.predicted_bytes::<f64>(self.memory.resources.threads))?;
        let factor =
            Cholesky::on_threads(symbolic, &matrix, self.memory.resources.threads).map_err(at_vertex)?;
        let mut rhs = b.to_vec();
        rhs.resize(factor.symbolic().unknowns(), 0.0);
        let violations_of = |x: &[f64]| -> Vec<f64> {
            rows.iter().map(|r| if r.exact { r.violation(x) } else { 0.0 }).collect()
        };
        let correction = Cell::new(0.0f64);
        let solve = |rhs: &[f64]| {
            if self.slivers.is_none() {
                return factor.solve(rhs).map_err(at_vertex);
            }
            let refined = refined(&factor, rhs, |x| self.penalised_applied(&rows, x)).map_err(at_vertex)?;
            correction.set(correction.get().max(refined.correction));
            Ok(refined.values)
        };
        let mut x = solve(&rhs)?;
        let target = CONSTRAINT_TOLERANCE * largest(&x);
        let unconditioned = |r: &[f64]| Ok::<_, SignedHeatError>(r.to_vec());
        let mut iteration = ConjugateGradient::new(violations_of(&x), unconditioned)?;
        while iteration.iterations() < CONSTRAINT_ITERATIONS && largest(iteration.residual()) > target {
            let mut change = Vec::new();
            let step = iteration.step(|direction| {
                let mut force = vec![0.0; x.len()];
                rows.iter().zip(direction).for_each(|(row, d)| row.add_to(&mut force, *d));
                change = solve(&force)?;
                Ok(violations_of(&change))
            })?;
            let Some(step) = step else { break };
            x.iter_mut().zip(&change).for_each(|(x, c)| *x -= step * c);
        }
        check_stopped()?;
        let mut multipliers = iteration.into_solution();
        // Adds the force of the penalty to the multipliers, so that the residual includes it.
        for (m, row) in multipliers.iter_mut().zip(&rows) {
            *m += row.weight * row.violation(&x);
        }
        self.subtract_mean(&rows, constraints, &mut x);
        let violation = Some(largest_violation(&rows, &x));
        let residual = self.multiplier_residual(&x, b, &rows, &multipliers);
        let worst = largest(&violations_of(&x));
        // If all values are constrained to zero, the surface's size is the only scale to compare
        // with.
        let allowed =
            (CONSTRAINT_WARNING * largest(&x)).max(CONSTRAINT_ROUNDING * largest(&self.size_of_component));
        let not_held = (worst > allowed).then_some(Warning::ViolatedConstraints { violation: worst });
        let lost_digits = self.slivers.and_then(|slivers| slivers.warning(correction.get(), largest(&x)));
        x.truncate(b.len());
        let mut result = Integrated {
            values: x,
            residual,
            constraint_violation: violation,
            warnings: not_held.into_iter().chain(lost_digits).collect(),
            chosen: ChosenLevelSets::given(LevelSets::Zero),
        };
        if constraints.contains(&Constraint::OwnLevels) {
            let mut shift = self.mean_at_source(mesh, &result.values, source);
            let zeroed = shift
                .iter_mut()
                .zip(constraints)
                .filter(|(_, constraint)| **constraint != Constraint::OwnLevels);
            zeroed.for_each(|(shift, _)| *shift = 0.0);
            self.subtract(&mut result.values, &shift);
        }
        self.clamp_unsigned(mesh, source, &mut result.values);
        Ok(result)
    }

    /// Assembles and analyses the Laplacian with the penalties of the rows. Free levels follow the
    /// vertices as unknowns.
    ///
    /// A level is coupled to every vertex that its piece of curve touches. Eliminated right after
    /// the last of these, it adds one row to each front on the way, as one more vertex of a
    /// separator would. Many small pieces thus cost almost nothing, and a long piece costs in
    /// proportion to its length. The order is the existing one with these insertions; its symbolic
    /// analysis is repeated for each source.
    ///
    /// Alternatives for the levels, on 100,820 faces with 21, 212 and 2,136 pieces. Times are for
    /// the whole integration (0.09 s without levels); memory is the peak of the process (208 MB
    /// without levels). The first and the last are measured, the others estimated from their
    /// back-substitutions.
    /// * Vertices first, then the levels: one response per piece (one back-substitution, one full
    ///   vector) and a dense system, factored again in each fit: 0.23 s, 1.5 s and 20 s, up to
    ///   1,146 MB.
    /// * The same, keeping only the entries of the responses that the rows read: no extra memory,
    ///   but still a back-substitution of 8 ms per piece, 17 s for 2,136.
    /// * Conjugate gradients on the levels, preconditioned by the factor without levels: 8 ms per
    ///   iteration, so that ten cost as much as the whole present integration.
    /// * Levels as unknowns, as here: 0.13 s, 0.14 s and 0.18 s, up to 224 MB.
    fn penalised(
        &self,
        mesh: &TriangleMesh,
        rows: &[Row],
        levels: usize,
    ) -> Result<(Arc<Symbolic>, SymmetricMatrix<f64>), NumericError> {
        let vertices = mesh.vertex_count();
        let mut matrix = grounded_matrix(&self.laplacian, self.ungrounded_by(rows).iter());
        check_stopped()?;
        matrix.diagonal.resize(vertices + levels, 0.0);
        let mut meetings = Vec::new();
        for row in rows {
            add_outer_product(&mut matrix, &self.laplacian, mesh, &row.place, row.weight);
            if let Some(level) = row.level {
                matrix.diagonal[level as usize] += row.weight;
                for &(v, w) in row.place.weights() {
                    meetings.push([v, level]);
                    matrix.off_diagonal.push(-row.weight * w);
                }
            }
        }
        let symbolic = if levels == 0 {
            self.factor.symbolic().clone()
        } else {
            let order = self.order_with_levels(&meetings, levels);
            let mut graph = self.laplacian.graph.clone();
            graph.unknowns += levels;
            graph.pairs.extend(meetings);
            Symbolic::new(&graph, Ordering::Given(&order))?.into()
        };
        Ok((symbolic, matrix))
    }

    /// Subtracts the weighted mean over the rows in each component that only penalties draw to
    /// zero. In exact arithmetic this mean is zero, since the right-hand side sums to zero there;
    /// with a small weight, rounding would determine the constant.
    fn subtract_mean(&self, rows: &[Row], constraints: &[Constraint], values: &mut [f64]) {
        let mut sums = vec![[0.0; 2]; self.component_count];
        let mut exact: Vec<bool> =
            constraints.iter().map(|constraint| *constraint == Constraint::OwnLevels).collect();
        for row in rows {
            if let Some(c) = self.component_of_row(row) {
                exact[c] |= row.exact;
                sums[c][0] += row.weight * row.place.value(values);
                sums[c][1] += row.weight;
            }
        }
        let mean = |([sum, weight], exact): (&[f64; 2], bool)| {
            if *weight > 0.0 && !exact { sum / weight } else { 0.0 }
        };
        let shift: Vec<f64> = sums.iter().zip(exact).map(mean).collect();
        self.subtract(values, &shift);
    }

    pub(super) fn component_of_row(&self, row: &Row) -> Option<usize> {
        self.component_of_vertex[row.place.some_vertex()].map(|c| c as usize)
    }

    /// Returns the elimination order of the vertices, with each level after the last vertex that it
    /// is coupled to.
    fn order_with_levels(&self, meetings: &[[u32; 2]], levels: usize) -> Vec<u32> {
        let vertices = self.vertex_order.len();
        let mut turn = vec![0u32; vertices];
        for (t, &v) in self.vertex_order.iter().enumerate() {
            turn[v as usize] = t as u32;
        }
        let mut turn_of_level = vec![0u32; levels];
        for &[v, level] in meetings {
            let last = &mut turn_of_level[level as usize - vertices];
            *last = turn[v as usize].max(*last);
        }
        let mut by_turn: Vec<u32> = (0..levels as u32).collect();
        by_turn.sort_by_key(|&level| turn_of_level[level as usize]);
        let mut order = Vec::with_capacity(vertices + levels);
        let mut waiting = by_turn.into_iter().peekable();
        for (t, &v) in self.vertex_order.iter().enumerate() {
            order.push(v);
            while let Some(level) = waiting.next_if(|&level| turn_of_level[level as usize] == t as u32) {
                order.push(vertices as u32 + level);
            }
        }
        order
    }

    /// Assigns a level to the rows of each group, in components where each piece has its own. Rows
    /// that are alone in their group are dropped there, since they would not constrain anything.
    /// The first group of each component stays at zero, since only differences of levels are
    /// determined. Returns the number of levels; their unknowns follow those of the vertices.
    fn free_levels(&self, rows: &mut Vec<Row>, groups: usize, constraints: &[Constraint]) -> usize {
        let mut size = vec![0usize; groups];
        rows.iter().for_each(|row| size[row.group as usize] += 1);
        let own_levels =
            |row: &Row| self.component_of_row(row).is_some_and(|c| constraints[c] == Constraint::OwnLevels);
        rows.retain(|row| size[row.group as usize] > 1 || !own_levels(row));
        let mut has_first = vec![false; self.component_count];
        let mut seen = vec![false; groups];
        let mut levels = vec![None; groups];
        let first = self.component_of_vertex.len() as u32;
        let mut next = first;
        for row in rows.iter_mut().filter(|row| own_levels(row)) {
            let group = row.group as usize;
            if !std::mem::replace(&mut seen[group], true)
                && let Some(c) = self.component_of_row(row)
                && std::mem::replace(&mut has_first[c], true)
            {
                levels[group] = Some(next);
                next += 1;
            }
            row.level = levels[group];
        }
        (next - first) as usize
    }

    /// Multiplies the unknowns by the matrix of [`penalised`](Integration::penalised), term by
    /// term.
    fn penalised_applied(&self, rows: &[Row], unknowns: &[f64]) -> Vec<f64> {
        let mut product = self.applied(unknowns);
        rows.iter().for_each(|row| row.add_to(&mut product, row.weight * row.violation(unknowns)));
        product
    }

    /// Returns the residual of the constrained fit relative to the right-hand side.
    fn multiplier_residual(&self, x: &[f64], b: &[f64], rows: &[Row], multipliers: &[f64]) -> f64 {
        let mut error = self.applied(x);
        for (row, m) in rows.iter().zip(multipliers) {
            for &(v, w) in row.place.weights() {
                error[v as usize] += w * m;
            }
        }
        relative_residual(&error, b)
    }

    /// Returns one row per node of the curves and per point, each with its connected piece.
    pub(super) fn rows(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        source: &Source,
        constraints: &[Constraint],
    ) -> (Vec<Row>, usize) {
        let mut index: HashMap<_, u32> = HashMap::new();
        let mut places: Vec<Located> = Vec::new();
        let mut number = |point: Located| {
            *index.entry(point.key()).or_insert_with(|| {
                places.push(point);
                places.len() as u32 - 1
            })
        };
        let links: Vec<[u32; 2]> = source.segments.iter().map(|s| s.ends.map(&mut number)).collect();
        let points: Vec<u32> = source.points.iter().map(|p| number(*p)).collect();
        let soft_weight = |place: Located| {
            self.component_of(mesh, place).and_then(|c| match constraints[c] {
                Constraint::Soft(weight) => Some((weight, self.size_of_component[c])),
                _ => None,
            })
        };
        let mut exact: Vec<bool> =
            places.iter().map(|p| matches!(p, Located::Vertex(_)) && soft_weight(*p).is_none()).collect();
        points.iter().for_each(|&i| exact[i as usize] |= soft_weight(places[i as usize]).is_none());
        // At a crossing both curves have the same value, so they must share a level.
        let met = source.crossings.iter().map(|pair| pair.map(|s| links[s][0]));
        let joined: Vec<[u32; 2]> = links.iter().copied().chain(met).collect();
        let group = connected_pieces(places.len(), &joined);
        let groups = group.iter().max().map_or(0, |g| *g as usize + 1);
        let row = |point: Located, exact: bool, weight: f64, group: u32| Row {
            place: Place::of(mesh, point),
            weight,
            exact,
            group,
            level: None,
        };
        let mut rows: Vec<Row> = places
            .iter()
            .zip(exact.iter().zip(&group))
            .map(|(&place, (&exact, &group))| row(place, exact, if exact { PENALTY } else { 0.0 }, group))
            .collect();
        // Simpson's rule is exact for the square of a linear function, so splitting a segment
        // changes nothing. Each segment counts once, so duplicating it changes nothing either.
        let mut seen = HashSet::new();
        for (segment, &[a, b]) in source.segments.iter().zip(&links) {
            if (exact[a as usize] && exact[b as usize]) || !seen.insert((a.min(b), a.max(b))) {
                continue;
            }
            let [p, q] = segment.ends.map(|p| p.position(mesh));
            let weight = distance(p, q)
                * match soft_weight(segment.ends[0]) {
                    Some((weight, _)) => weight,
                    None => ALONG_CURVES / host_size(mesh, triangles, segment),
                };
            for i in [a, b].into_iter().filter(|&i| !exact[i as usize]) {
                rows[i as usize].weight += weight / 6.0;
            }
            rows.push(row(middle(mesh, segment), false, weight * 4.0 / 6.0, group[a as usize]));
        }
        for i in points {
            if let Some((weight, size)) = soft_weight(places[i as usize]) {
                rows[i as usize].weight += weight * size * POINT_LENGTH;
            }
        }
        (rows, groups)
    }

    /// Returns the grounded vertices of the components without rows.
    fn ungrounded_by(&self, rows: &[Row]) -> Vec<Ground> {
        let mut held = vec![false; self.component_count];
        for row in rows {
            if let Some(c) = self.component_of_vertex[row.place.some_vertex()] {
                held[c as usize] = true;
            }
        }
        self.grounded.iter().filter(|g| !held[g.component as usize]).copied().collect()
    }
}

/// Attributes a fault at the level of a piece of curve to a vertex of the piece.
fn at_piece(mut fault: NumericError, rows: &[Row]) -> NumericError {
    if let NumericError::NonPositivePivot { unknown } | NumericError::NonFinite { unknown, .. } = &mut fault
        && let Some(row) = rows.iter().find(|row| row.level.is_some_and(|level| level as usize == *unknown))
    {
        *unknown = row.place.some_vertex();
    }
    fault
}

fn largest_violation(rows: &[Row], unknowns: &[f64]) -> f64 {
    rows.iter().map(|row| row.violation(unknowns).abs()).fold(0.0, f64::max)
}

/// Returns the length of the edge that contains a segment, or of the longest edge of its face.
fn host_size(mesh: &TriangleMesh, triangles: &[Triangle], segment: &Segment) -> f64 {
    match segment.host {
        SegmentHost::Edge(edge, _) => {
            let h = mesh.edge_halfedges(edge)[0];
            triangles[h.face().index()].lengths[h.side()]
        }
        SegmentHost::Face(face, _) => triangles[face.index()].lengths.iter().fold(0.0, |m, &l| m.max(l)),
    }
}

fn middle(mesh: &TriangleMesh, segment: &Segment) -> Located {
    match segment.host {
        SegmentHost::Edge(edge, [s, t]) => Located::Edge(edge, 0.5 * (s + t)),
        SegmentHost::Face(face, [a, b]) => {
            Located::in_face(mesh, face, [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])))
        }
    }
}

/// Adds `weight a a^T` for the row `a` of a place. The pattern already has every entry, since the
/// vertices of the row lie in one face.
fn add_outer_product(
    matrix: &mut SymmetricMatrix<f64>,
    laplacian: &CotanLaplacian,
    mesh: &TriangleMesh,
    place: &Place,
    weight: f64,
) {
    for (m, &(i, wi)) in place.weights().iter().enumerate() {
        matrix.diagonal[i as usize] += weight * wi * wi;
        for &(j, wj) in &place.weights()[m + 1..] {
            if let Some(entry) = laplacian.entry(mesh, i, j) {
                matrix.off_diagonal[entry] += weight * wi * wj;
            }
        }
    }
}

/// Labels the connected components of a graph of items and links, from 0 in the order of their
/// first items.
fn connected_pieces(items: usize, links: &[[u32; 2]]) -> Vec<u32> {
    let mut pieces = UnionFind::new(items);
    links.iter().for_each(|&[a, b]| pieces.join(a, b));
    pieces.numbers().0
}
