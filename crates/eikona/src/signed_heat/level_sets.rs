//! Level set constraints (SHM section 7.1): fits that are zero or constant along the curves, or nearly so by weight.

use crate::geometry::Triangle;
use crate::geometry::vector::distance;
use crate::operators::CotanLaplacian;
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::integration::{Ground, Integrated, Integration, at_vertex, grounded_matrix};
use crate::signed_heat::source::Source;
use eikona_mesh::{Located, Segment, SegmentHost, TriangleMesh};
use eikona_numeric::{Cholesky, SymmetricMatrix, solve_dense};
use std::collections::{HashMap, HashSet};

/// A place whose value is constrained: a combination of vertex values.
///
/// Vertices and isolated points are held exactly, at the weight of the penalty and with a multiplier. Curves inside edges and
/// faces are held by weight only: [`ALONG_CURVES`] times the integral of the square along the curve, over the size of the edge or face.
///
/// Deviation: section 7.1 holds all nodes exactly. A curve that crosses `n` edges touches only about `n` vertices, so that
/// exact rows leave the function no freedom there: unless the curve happens to be an isoline of a function that is linear in
/// every face, the distance is flat along the whole strip of crossed faces, and off by the width of the strip
/// (test `zero_does_not_lock_on_a_polyline`).
struct Row {
    weight: f64,
    exact: bool,
    weights: [(u32, f64); 3],
    count: usize,
    /// The connected piece of the curves that it belongs to.
    group: u32,
}

impl Row {
    fn weights(&self) -> &[(u32, f64)] {
        &self.weights[..self.count]
    }
    fn value(&self, phi: &[f64]) -> f64 {
        self.weights().iter().map(|&(v, w)| w * phi[v as usize]).sum()
    }
}

/// The penalty of the augmented Lagrangian. Rows and operator have no unit and entries of order 1. Larger values need fewer
/// iterations and lose as many of the sixteen digits.
const PENALTY: f64 = 1e6;
/// How strongly curves inside edges and faces are held, without unit: the fit then leaves the curve by the square of the edge
/// length, as interpolation does. Measured: 3 to 30 give the same errors.
const ALONG_CURVES: f64 = 10.0;
/// Constrained values count as equal below this share of the largest value.
const CONSTRAINT_TOLERANCE: f64 = 1e-10;
/// Each costs a back-substitution.
const CONSTRAINT_ITERATIONS: usize = 8;

impl Integration {
    /// The fit among the functions that are constant along the curves: zero on all, or at a free level on each connected
    /// piece.
    ///
    /// Augmented Lagrangian: the rows `A` of the constraints touch only vertices of one face each, so `C + w A^T A` has the
    /// pattern of `C`; its factor costs one numeric factorisation with the kept analysis, needs no grounding where there is a
    /// row, and does not mind rows that depend on each other (several nodes in one face, doubled curves), which make the
    /// saddle system of eq. 14 singular. The multipliers are found by conjugate gradients: with the penalty inside, all but the
    /// nearly dependent rows have eigenvalues close to `1 / w`, so a handful of iterations suffices.
    pub fn constrained(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        b: &[f64],
        source: &Source,
        free_levels: bool,
    ) -> Result<Integrated, SignedHeatError> {
        let (mut rows, mut groups) = self.rows(mesh, triangles, source);
        if free_levels {
            groups = without_single_rows(&mut rows, groups);
        }
        let mut matrix = grounded_matrix(&self.laplacian, self.ungrounded_by(&rows).iter());
        for row in &rows {
            add_outer_product(&mut matrix, &self.laplacian, mesh, row, row.weight);
        }
        let factor = Cholesky::new(self.factor.symbolic().clone(), &matrix).map_err(at_vertex)?;
        let levels = if free_levels {
            Some(Levels::new(&factor, &rows, groups, &self.first_groups(&rows, groups))?)
        } else {
            None
        };
        // The fit for given right-hand side and multipliers, with its levels, and by how much it misses the constraints.
        let fit = |b: &[f64], multipliers: &[f64]| -> Result<_, SignedHeatError> {
            let mut rhs = b.to_vec();
            for (row, &m) in rows.iter().zip(multipliers) {
                for &(v, w) in row.weights() {
                    rhs[v as usize] -= w * m;
                }
            }
            let mut phi = factor.solve(&rhs).map_err(at_vertex)?;
            let level = match &levels {
                Some(levels) => levels.solve(&rows, multipliers, &mut phi)?,
                None => vec![0.0; groups],
            };
            let misses: Vec<f64> = rows
                .iter()
                .map(|r| if r.exact { r.value(&phi) - level[r.group as usize] } else { 0.0 })
                .collect();
            Ok((phi, level, misses))
        };
        let mut multipliers = vec![0.0; rows.len()];
        let (mut phi, mut level, mut misses) = fit(b, &multipliers)?;
        let scale = phi.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let target = CONSTRAINT_TOLERANCE * scale;
        let nothing = vec![0.0; b.len()];
        let mut direction = misses.clone();
        for _ in 0..CONSTRAINT_ITERATIONS {
            if misses.iter().all(|m| m.abs() <= target) {
                break;
            }
            let (phi_change, level_change, change) = fit(&nothing, &direction)?;
            let norm = dot(&misses, &misses);
            let step = -norm / dot(&direction, &change);
            if !step.is_finite() || step <= 0.0 {
                break; // only by rounding: what is left can not be told from zero
            }
            add_multiple(&mut multipliers, step, &direction);
            add_multiple(&mut phi, step, &phi_change);
            add_multiple(&mut level, step, &level_change);
            add_multiple(&mut misses, step, &change);
            let growth = dot(&misses, &misses) / norm;
            for (d, m) in direction.iter_mut().zip(&misses) {
                *d = m + growth * *d;
            }
        }
        // The penalty's own force belongs to the multipliers.
        for (m, row) in multipliers.iter_mut().zip(&rows) {
            *m += row.weight * (row.value(&phi) - level[row.group as usize]);
        }
        let violation =
            rows.iter().map(|r| (r.value(&phi) - level[r.group as usize]).abs()).fold(0.0, f64::max);
        let residual = self.multiplier_residual(&phi, b, &rows, &multipliers);
        let mut result =
            Integrated { values: phi, residual, constraint_violation: violation, levels: Vec::new() };
        if free_levels {
            let shift = self.mean_at_source(mesh, &result.values, source);
            self.subtract(&mut result.values, &shift);
            let mut component_of_group = vec![0; groups];
            for row in &rows {
                let v = row.weights[0].0 as usize;
                component_of_group[row.group as usize] = self.component_of_vertex[v].unwrap_or(0) as usize;
            }
            result.levels = level.iter().zip(component_of_group).map(|(l, c)| l - shift[c]).collect();
        }
        self.clamp_unsigned(mesh, source, &mut result.values);
        Ok(result)
    }

    /// How well the constrained fit satisfies its equations, relative to the right-hand side.
    fn multiplier_residual(&self, phi: &[f64], b: &[f64], rows: &[Row], multipliers: &[f64]) -> f64 {
        let c = &self.laplacian;
        let mut error: Vec<f64> = phi
            .iter()
            .zip(&c.matrix.diagonal)
            .zip(&self.component_of_vertex)
            .map(|((x, d), component)| if component.is_some() { x * d } else { 0.0 })
            .collect();
        for ([i, j], value) in c.graph.pairs.iter().zip(&c.matrix.off_diagonal) {
            error[*i as usize] += value * phi[*j as usize];
            error[*j as usize] += value * phi[*i as usize];
        }
        for (row, m) in rows.iter().zip(multipliers) {
            for &(v, w) in row.weights() {
                error[v as usize] += w * m;
            }
        }
        let scale = b.iter().fold(0.0f64, |s, x| s.max(x.abs()));
        let worst = error.iter().zip(b).fold(0.0f64, |s, (e, b)| s.max((e - b).abs()));
        if scale > 0.0 { worst / scale } else { worst }
    }

    /// The penalty of section 7.1, as an integral along the curves so that resolution does not matter.
    ///
    /// Deviation: the text prints `C - lambda A^T A`; the penalty must be added.
    pub fn soft(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        b: &[f64],
        source: &Source,
        weight: f64,
    ) -> Result<Integrated, SignedHeatError> {
        let (rows, _) = self.rows(mesh, triangles, source);
        let mut matrix = grounded_matrix(&self.laplacian, self.ungrounded_by(&rows).iter());
        let group = 0;
        let mut penalise = |point: Located, weight: f64| {
            let row = row_of(mesh, point, group);
            add_outer_product(&mut matrix, &self.laplacian, mesh, &row, weight);
        };
        for segment in &source.segments {
            let Some(c) = self.component_of(mesh, segment.ends[0]) else { continue };
            let [p, q] = segment.ends.map(|p| p.position(mesh));
            let w = weight * distance(p, q) / self.size_of_component[c];
            // Simpson's rule, exact for the square of a linear function.
            penalise(segment.ends[0], w / 6.0);
            penalise(segment.ends[1], w / 6.0);
            penalise(middle(mesh, segment), w * 4.0 / 6.0);
        }
        let spacing = mean_edge_length(triangles);
        for point in &source.points {
            let Some(c) = self.component_of(mesh, *point) else { continue };
            penalise(*point, weight * spacing / self.size_of_component[c]);
        }
        let factor = Cholesky::new(self.factor.symbolic().clone(), &matrix).map_err(at_vertex)?;
        let values = factor.solve(b).map_err(at_vertex)?;
        let residual = factor.residual(&values, b);
        let mut result = Integrated { values, residual, constraint_violation: 0.0, levels: Vec::new() };
        self.clamp_unsigned(mesh, source, &mut result.values);
        Ok(result)
    }

    /// One row for each node of the curves and each point, with the connected piece that it belongs to.
    fn rows(&self, mesh: &TriangleMesh, triangles: &[Triangle], source: &Source) -> (Vec<Row>, usize) {
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
        let mut exact: Vec<bool> = places.iter().map(|p| matches!(p, Located::Vertex(_))).collect();
        points.iter().for_each(|&i| exact[i as usize] = true);
        let group = connected_pieces(places.len(), &links);
        let groups = group.iter().max().map_or(0, |g| *g as usize + 1);
        let mut rows: Vec<Row> =
            places.iter().zip(&group).map(|(place, group)| row_of(mesh, *place, *group)).collect();
        for (row, exact) in rows.iter_mut().zip(&exact) {
            row.exact = *exact;
            row.weight = if *exact { PENALTY } else { 0.0 };
        }
        // Simpson's rule, exact for the square of a linear function, so that cutting a segment in two changes nothing; and
        // every segment once, so that doubling it does not either.
        let mut seen = HashSet::new();
        for (segment, &[a, b]) in source.segments.iter().zip(&links) {
            if (exact[a as usize] && exact[b as usize]) || !seen.insert((a.min(b), a.max(b))) {
                continue;
            }
            let [p, q] = segment.ends.map(|p| p.position(mesh));
            let weight = ALONG_CURVES * distance(p, q) / host_size(mesh, triangles, segment);
            for i in [a, b].into_iter().filter(|&i| !exact[i as usize]) {
                rows[i as usize].weight += weight / 6.0;
            }
            let middle = row_of(mesh, middle(mesh, segment), group[a as usize]);
            rows.push(Row { weight: weight * 4.0 / 6.0, exact: false, ..middle });
        }
        (rows, groups)
    }

    /// The grounds of the components that no row holds.
    fn ungrounded_by(&self, rows: &[Row]) -> Vec<Ground> {
        let mut held = vec![false; self.component_count];
        for row in rows {
            if let Some(c) = self.component_of_vertex[row.weights[0].0 as usize] {
                held[c as usize] = true;
            }
        }
        self.grounded.iter().filter(|g| !held[g.component as usize]).copied().collect()
    }

    /// The first group in each component: its level is zero, since only differences are determined.
    fn first_groups(&self, rows: &[Row], groups: usize) -> Vec<bool> {
        let mut has_first = vec![false; self.component_count];
        let mut seen = vec![false; groups];
        let mut first = vec![false; groups];
        for row in rows {
            let group = row.group as usize;
            let component = self.component_of_vertex[row.weights[0].0 as usize].map(|c| c as usize);
            if let (false, Some(c)) = (seen[group], component) {
                first[group] = !has_first[c];
                has_first[c] = true;
            }
            seen[group] = true;
        }
        first
    }
}

/// The free levels of groups of rows, eliminated: minimising over them too adds a small dense system.
struct Levels {
    /// For each free group, the answer to its level 1.
    responses: Vec<(usize, Vec<f64>)>,
    /// The dense system of the levels, row by row.
    system: Vec<f64>,
    groups: usize,
}

impl Levels {
    fn new(
        factor: &Cholesky<f64>,
        rows: &[Row],
        groups: usize,
        fixed: &[bool],
    ) -> Result<Levels, SignedHeatError> {
        let mut responses = Vec::new();
        for group in (0..groups).filter(|&g| !fixed[g]) {
            let mut rhs = vec![0.0; factor.symbolic().unknowns()];
            for row in rows.iter().filter(|r| r.group as usize == group) {
                for &(v, w) in row.weights() {
                    rhs[v as usize] += row.weight * w;
                }
            }
            responses.push((group, factor.solve(&rhs).map_err(at_vertex)?));
        }
        let n = responses.len();
        let mut place = vec![usize::MAX; groups];
        for (i, (group, _)) in responses.iter().enumerate() {
            place[*group] = i;
        }
        let mut system = vec![0.0; n * n];
        for row in rows {
            let i = place[row.group as usize];
            if i == usize::MAX {
                continue;
            }
            system[i * n + i] += row.weight;
            for (j, (_, response)) in responses.iter().enumerate() {
                system[i * n + j] -= row.weight * row.value(response);
            }
        }
        Ok(Levels { responses, system, groups })
    }

    /// The levels, with `phi` (the solution at level zero) brought up to them.
    fn solve(&self, rows: &[Row], multipliers: &[f64], phi: &mut [f64]) -> Result<Vec<f64>, SignedHeatError> {
        let n = self.responses.len();
        let mut place = vec![usize::MAX; self.groups];
        for (i, (group, _)) in self.responses.iter().enumerate() {
            place[*group] = i;
        }
        // d/d level: sum over the group of (weight (A phi - level) + multiplier) = 0.
        let mut rhs = vec![0.0; n];
        for (row, m) in rows.iter().zip(multipliers) {
            let i = place[row.group as usize];
            if i != usize::MAX {
                rhs[i] += row.weight * row.value(phi) + m;
            }
        }
        let solution = solve_dense(&self.system, &rhs)?;
        let mut levels = vec![0.0; self.groups];
        for ((group, response), level) in self.responses.iter().zip(solution) {
            levels[*group] = level;
            phi.iter_mut().zip(response).for_each(|(p, r)| *p += level * r);
        }
        Ok(levels)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a <- a + factor b`
fn add_multiple(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

/// The length of the edge that a segment lies in, or the longest of its face.
fn host_size(mesh: &TriangleMesh, triangles: &[Triangle], segment: &Segment) -> f64 {
    match segment.host {
        SegmentHost::Edge(edge, _) => {
            let h = mesh.edge_halfedges(edge)[0];
            triangles[h.face().index()].lengths[h.side()]
        }
        SegmentHost::Face(face, _) => triangles[face.index()].lengths.iter().fold(0.0, |m, &l| m.max(l)),
    }
}

fn row_of(mesh: &TriangleMesh, point: Located, group: u32) -> Row {
    let mut weights = [(0, 0.0); 3];
    let mut count = 0;
    for (v, w) in point.weights(mesh) {
        weights[count] = (v.0, w);
        count += 1;
    }
    Row { weight: PENALTY, exact: true, weights, count, group }
}

fn middle(mesh: &TriangleMesh, segment: &Segment) -> Located {
    match segment.host {
        SegmentHost::Edge(edge, [s, t]) => Located::Edge(edge, 0.5 * (s + t)),
        SegmentHost::Face(face, [a, b]) => {
            Located::in_face(mesh, face, [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])))
        }
    }
}

fn mean_edge_length(triangles: &[Triangle]) -> f64 {
    let sum: f64 = triangles.iter().flat_map(|t| t.lengths).sum();
    sum / (3 * triangles.len()).max(1) as f64
}

/// Adds `weight a a^T` for a row `a` whose vertices lie in one face: every entry is in the pattern already.
fn add_outer_product(
    matrix: &mut SymmetricMatrix<f64>,
    laplacian: &CotanLaplacian,
    mesh: &TriangleMesh,
    row: &Row,
    weight: f64,
) {
    for (m, &(i, wi)) in row.weights().iter().enumerate() {
        matrix.diagonal[i as usize] += weight * wi * wi;
        for &(j, wj) in &row.weights()[m + 1..] {
            if let Some(entry) = laplacian.entry(mesh, i, j) {
                matrix.off_diagonal[entry] += weight * wi * wj;
            }
        }
    }
}

/// Drops the rows that are alone in their group: at a level of their own they say nothing. Returns the number of groups left.
fn without_single_rows(rows: &mut Vec<Row>, groups: usize) -> usize {
    let mut size = vec![0usize; groups];
    rows.iter().for_each(|r| size[r.group as usize] += 1);
    let mut number = vec![0u32; groups];
    let mut next = 0;
    for (group, &size) in size.iter().enumerate() {
        number[group] = next;
        next += u32::from(size > 1);
    }
    rows.retain(|r| size[r.group as usize] > 1);
    rows.iter_mut().for_each(|r| r.group = number[r.group as usize]);
    next as usize
}

/// A number for each of the pieces that links between items make, counted from 0 in the order of their first items.
fn connected_pieces(items: usize, links: &[[u32; 2]]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..items as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for &[a, b] in links {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b) as usize] = a.min(b);
    }
    let mut number = vec![u32::MAX; items];
    let mut next = 0;
    (0..items as u32)
        .map(|i| {
            let r = root(&mut parent, i) as usize;
            if number[r] == u32::MAX {
                number[r] = next;
                next += 1;
            }
            number[r]
        })
        .collect()
}
