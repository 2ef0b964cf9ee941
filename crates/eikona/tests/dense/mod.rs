//! A plain dense implementation of the signed heat method: space vectors per face, dense matrices,
//! elimination with pivoting. It shares nothing with the library but the mesh and the segments of a
//! curve.

use crate::exact::{cross, dot, norm, sub};
use eikona_mesh::{CurveKind, Face, Segment, SegmentHost, SurfaceCurves, TriangleMesh};

/// A dense matrix.
#[derive(Clone)]
pub struct Dense {
    pub n: usize,
    pub entries: Vec<f64>,
}

impl Dense {
    pub fn zeros(n: usize) -> Dense {
        Dense { n, entries: vec![0.0; n * n] }
    }
    pub fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        &mut self.entries[i * self.n + j]
    }
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.entries[i * self.n + j]
    }
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        self.entries.chunks(self.n).map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
    }

    /// Solves by elimination with column pivoting and two steps of iterative refinement.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x = self.eliminate(b);
        for _ in 0..2 {
            let residual: Vec<f64> = self.times(&x).iter().zip(b).map(|(ax, b)| b - ax).collect();
            let correction = self.eliminate(&residual);
            x.iter_mut().zip(correction).for_each(|(x, c)| *x += c);
        }
        x
    }

    fn eliminate(&self, b: &[f64]) -> Vec<f64> {
        let n = self.n;
        let (mut a, mut x) = (self.entries.clone(), b.to_vec());
        for k in 0..n {
            let p = (k..n).max_by(|&i, &j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs())).unwrap();
            for j in 0..n {
                a.swap(k * n + j, p * n + j);
            }
            x.swap(k, p);
            assert!(a[k * n + k] != 0.0, "singular at {k}");
            for i in k + 1..n {
                let factor = a[i * n + k] / a[k * n + k];
                if factor != 0.0 {
                    for j in k..n {
                        a[i * n + j] -= factor * a[k * n + j];
                    }
                    x[i] -= factor * x[k];
                }
            }
        }
        for k in (0..n).rev() {
            let sum: f64 = (k + 1..n).map(|j| a[k * n + j] * x[j]).sum();
            x[k] = (x[k] - sum) / a[k * n + k];
        }
        x
    }

    /// Returns the number of negative pivots of the symmetric elimination, which is the number of
    /// negative eigenvalues (Sylvester).
    pub fn negative_pivots(&self) -> usize {
        let n = self.n;
        let mut a = self.entries.clone();
        let mut negative = 0;
        for k in 0..n {
            negative += usize::from(a[k * n + k] < 0.0);
            for i in k + 1..n {
                let factor = a[i * n + k] / a[k * n + k];
                for j in k..n {
                    a[i * n + j] -= factor * a[k * n + j];
                }
            }
        }
        negative
    }
}

/// The constraint on the values along the curves.
#[derive(Clone, Copy, Debug)]
pub enum Constraint {
    Free,
    Zero,
    PerPiece,
    Soft(f64),
}

/// A face embedded in space.
pub struct FaceFrame {
    pub area: f64,
    pub normal: [f64; 3],
    /// For each side: its edge's unit vector (in the edge's own direction), and that vector rotated
    /// by +90 degrees in the face.
    pub along: [[f64; 3]; 3],
    pub across: [[f64; 3]; 3],
    /// Gradients of the three barycentric coordinates.
    pub barycentric: [[f64; 3]; 3],
}

impl FaceFrame {
    pub fn of(mesh: &TriangleMesh, f: Face) -> FaceFrame {
        let p = mesh.face_positions(f);
        let doubled = cross(sub(p[1], p[0]), sub(p[2], p[0]));
        let normal = doubled.map(|x| x / norm(doubled));
        let along = mesh.face_edges(f).map(|e| {
            let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
            let d = sub(b, a);
            d.map(|x| x / norm(d))
        });
        let across = along.map(|u| cross(normal, u));
        // Perpendicular to the opposite side, with length one over the height.
        let barycentric =
            [0, 1, 2].map(|k| cross(normal, sub(p[(k + 2) % 3], p[(k + 1) % 3])).map(|x| x / norm(doubled)));
        FaceFrame { area: 0.5 * norm(doubled), normal, along, across, barycentric }
    }

    /// Returns the vectors of side k for the two real unknowns of its edge.
    pub fn basis(&self, k: usize) -> [[f64; 3]; 2] {
        [self.along[k], self.across[k]]
    }
}

/// Assembles mass and Dirichlet energy of Crouzeix-Raviart vector fields on a consistently oriented
/// mesh. Unknowns 2 e and 2 e + 1 are the components along the edge and across it. The function of
/// side k is 1 - 2 (barycentric coordinate of the opposite corner).
pub fn vector_operators(mesh: &TriangleMesh) -> (Dense, Dense) {
    let n = 2 * mesh.edge_count();
    let (mut mass, mut energy) = (Dense::zeros(n), Dense::zeros(n));
    for f in mesh.faces() {
        let frame = FaceFrame::of(mesh, f);
        let edges = mesh.face_edges(f);
        for k in 0..3 {
            for part in 0..2 {
                *mass.at(2 * edges[k].index() + part, 2 * edges[k].index() + part) += frame.area / 3.0;
            }
            for l in 0..3 {
                let (g, h) = (frame.barycentric[(k + 2) % 3], frame.barycentric[(l + 2) % 3]);
                let coupling = 4.0 * frame.area * dot(g, h);
                for (i, a) in frame.basis(k).into_iter().enumerate() {
                    for (j, b) in frame.basis(l).into_iter().enumerate() {
                        *energy.at(2 * edges[k].index() + i, 2 * edges[l].index() + j) +=
                            coupling * dot(a, b);
                    }
                }
            }
        }
    }
    (mass, energy)
}

/// Assembles the Dirichlet energy of piecewise linear functions.
pub fn scalar_laplacian(mesh: &TriangleMesh) -> Dense {
    let mut c = Dense::zeros(mesh.vertex_count());
    for f in mesh.faces() {
        let frame = FaceFrame::of(mesh, f);
        let v = mesh.face_vertices(f);
        for k in 0..3 {
            for l in 0..3 {
                *c.at(v[k].index(), v[l].index()) +=
                    frame.area * dot(frame.barycentric[k], frame.barycentric[l]);
            }
        }
    }
    c
}

/// Computes the signed distance to oriented curves, negative on their left, on a connected,
/// consistently oriented mesh.
pub fn signed_distance(
    mesh: &TriangleMesh,
    source: &SurfaceCurves,
    coefficient: f64,
    constraint: Constraint,
    preserve_normals: bool,
) -> Vec<f64> {
    let segments = source.segments(mesh).unwrap();
    assert!(source.curves.iter().all(|c| c.kind == CurveKind::Signed));
    let spacing = 0.5 * crate::exact::mean_edge_length(mesh);
    let time = coefficient * spacing * spacing;

    let (mass, energy) = vector_operators(mesh);
    let mut system = mass;
    system.entries.iter_mut().zip(&energy.entries).for_each(|(m, e)| *m += time * e);
    let x0 = normals(mesh, &segments);
    let x = if preserve_normals {
        constrained(&system, &x0, &independent(tangents(mesh, &segments)))
    } else {
        system.solve(&x0)
    };

    let mut rhs = vec![0.0; mesh.vertex_count()];
    for f in mesh.faces() {
        let frame = FaceFrame::of(mesh, f);
        let edges = mesh.face_edges(f);
        let mut y = [0.0; 3];
        for k in 0..3 {
            for (part, b) in frame.basis(k).into_iter().enumerate() {
                (0..3).for_each(|c| y[c] += x[2 * edges[k].index() + part] * b[c]);
            }
        }
        let largest = y.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        let y = y.map(|c| c / largest);
        let y = y.map(|c| c / norm(y));
        for (k, v) in mesh.face_vertices(f).into_iter().enumerate() {
            rhs[v.index()] += frame.area * dot(frame.barycentric[k], y);
        }
    }
    integrate(mesh, source, &segments, &rhs, constraint)
}

fn position(mesh: &TriangleMesh, f: Face, weights: [f64; 3]) -> [f64; 3] {
    let p = mesh.face_positions(f);
    [0, 1, 2].map(|c| (0..3).map(|k| weights[k] * p[k][c]).sum())
}

/// Returns the right normals of the segments, scaled by length: in a face on all its sides, along
/// an edge on that edge.
fn normals(mesh: &TriangleMesh, segments: &[Segment]) -> Vec<f64> {
    let mut values = vec![0.0; 2 * mesh.edge_count()];
    for s in segments {
        match s.host {
            SegmentHost::Face(f, [a, b]) => {
                let frame = FaceFrame::of(mesh, f);
                let right = cross(sub(position(mesh, f, b), position(mesh, f, a)), frame.normal);
                for (k, e) in mesh.face_edges(f).into_iter().enumerate() {
                    for (part, basis) in frame.basis(k).into_iter().enumerate() {
                        values[2 * e.index() + part] += dot(right, basis);
                    }
                }
            }
            SegmentHost::Edge(e, [from, to]) => {
                let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
                // +90 degrees is left.
                values[2 * e.index() + 1] -= (to - from) * norm(sub(b, a));
            }
        }
    }
    values
}

/// Returns one row per segment: the tangential component of a field at its midpoint.
fn tangents(mesh: &TriangleMesh, segments: &[Segment]) -> Vec<Vec<f64>> {
    let tangent = |s: &Segment| {
        let mut row = vec![0.0; 2 * mesh.edge_count()];
        match s.host {
            SegmentHost::Face(f, [a, b]) => {
                let frame = FaceFrame::of(mesh, f);
                let along = sub(position(mesh, f, b), position(mesh, f, a));
                for (k, e) in mesh.face_edges(f).into_iter().enumerate() {
                    let opposite = (k + 2) % 3;
                    let value = 1.0 - 2.0 * (0.5 * (a[opposite] + b[opposite]));
                    for (part, basis) in frame.basis(k).into_iter().enumerate() {
                        row[2 * e.index() + part] += value * dot(along, basis) / norm(along);
                    }
                }
            }
            SegmentHost::Edge(e, _) => row[2 * e.index()] = 1.0,
        }
        row
    };
    segments.iter().map(tangent).collect()
}

fn integrate(
    mesh: &TriangleMesh,
    source: &SurfaceCurves,
    segments: &[Segment],
    rhs: &[f64],
    constraint: Constraint,
) -> Vec<f64> {
    let laplacian = scalar_laplacian(mesh);
    let n = mesh.vertex_count();
    let row = |place: eikona_mesh::Located| {
        let mut r = vec![0.0; n];
        place.weights(mesh).for_each(|(v, w)| r[v.index()] += w);
        r
    };
    let minus = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    let mut rows: Vec<Vec<f64>> = Vec::new();
    match constraint {
        Constraint::Free => rows.push(vec![1.0; n]), // any constant
        Constraint::Zero => return held(mesh, segments, rhs, None),
        Constraint::PerPiece => {
            let phi = held(mesh, segments, rhs, Some(source.curves.len()));
            return minus(&phi, &vec![mean_along(mesh, segments, &phi); n]);
        }
        Constraint::Soft(weight) => {
            let mut system = laplacian.clone();
            let area: f64 = mesh.faces().map(|f| FaceFrame::of(mesh, f).area).sum();
            for s in segments {
                let [p, q] = s.ends.map(|e| e.position(mesh));
                let scale = weight * norm(sub(q, p)) / area.sqrt();
                let [a, b] = s.ends.map(row);
                // The integral of the square of a linear function: (a a + a b + b b) / 3 for end
                // values a, b.
                for i in 0..n {
                    for j in 0..n {
                        let cross = 0.5 * (a[i] * b[j] + b[i] * a[j]);
                        *system.at(i, j) += scale / 3.0 * (a[i] * a[j] + cross + b[i] * b[j]);
                    }
                }
            }
            return system.solve(rhs);
        }
    }
    let phi = constrained(&laplacian, rhs, &independent(rows));
    minus(&phi, &vec![mean_along(mesh, segments, &phi); n])
}

fn mean_along(mesh: &TriangleMesh, segments: &[Segment], phi: &[f64]) -> f64 {
    let (mut sum, mut length) = (0.0, 0.0);
    for s in segments {
        let [p, q] = s.ends.map(|e| e.position(mesh));
        let [a, b] = s.ends.map(|e| e.interpolate(mesh, phi));
        sum += norm(sub(q, p)) * 0.5 * (a + b);
        length += norm(sub(q, p));
    }
    sum / length
}

/// Weight that holds curves inside edges and faces (`ALONG_CURVES` of the library).
const ALONG_CURVES: f64 = 10.0;

/// Fits with zero along the curves, or with a separate level along each (with mean zero over the
/// vertices): exactly at vertices, and by weight along segments inside edges and faces. No two
/// curves touch. The levels are unknowns like the values.
fn held(mesh: &TriangleMesh, segments: &[Segment], rhs: &[f64], curves: Option<usize>) -> Vec<f64> {
    let (laplacian, n) = (scalar_laplacian(mesh), mesh.vertex_count());
    let m = n + curves.unwrap_or(0);
    let mut system = Dense::zeros(m);
    for i in 0..n {
        for j in 0..n {
            *system.at(i, j) = laplacian.get(i, j);
        }
    }
    let mut rows: Vec<Vec<f64>> = Vec::new();
    if curves.is_some() {
        rows.push((0..m).map(|i| if i < n { 1.0 } else { 0.0 }).collect());
    }
    for s in segments {
        let [a, b] = s.ends.map(|end| {
            let mut row = vec![0.0; m];
            end.weights(mesh).for_each(|(v, w)| row[v.index()] += w);
            if curves.is_some() {
                row[n + s.curve] = -1.0;
            }
            row
        });
        let [p, q] = s.ends.map(|e| e.position(mesh));
        let host = match s.host {
            SegmentHost::Edge(e, _) => {
                let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
                norm(sub(b, a))
            }
            SegmentHost::Face(f, _) => {
                let p = mesh.face_positions(f);
                (0..3).map(|k| norm(sub(p[(k + 1) % 3], p[k]))).fold(0.0, f64::max)
            }
        };
        let weight = ALONG_CURVES * norm(sub(q, p)) / host;
        let at_vertex = s.ends.map(|end| matches!(end, eikona_mesh::Located::Vertex(_)));
        for i in (0..m).filter(|_| at_vertex != [true, true]) {
            for j in 0..m {
                let cross = 0.5 * (a[i] * b[j] + b[i] * a[j]);
                *system.at(i, j) += weight / 3.0 * (a[i] * a[j] + cross + b[i] * b[j]);
            }
        }
        rows.extend(
            [a, b].into_iter().zip(at_vertex).filter(|(_, at_vertex)| *at_vertex).map(|(row, _)| row),
        );
    }
    let mut rhs = rhs.to_vec();
    rhs.resize(m, 0.0);
    constrained(&system, &rhs, &independent(rows))[..n].to_vec()
}

/// Minimises x C x / 2 - b x subject to A x = 0, by its saddle point system.
fn constrained(c: &Dense, b: &[f64], rows: &[Vec<f64>]) -> Vec<f64> {
    let n = c.n;
    let mut system = Dense::zeros(n + rows.len());
    for i in 0..n {
        for j in 0..n {
            *system.at(i, j) = c.get(i, j);
        }
    }
    for (k, row) in rows.iter().enumerate() {
        for i in 0..n {
            *system.at(n + k, i) = row[i];
            *system.at(i, n + k) = row[i];
        }
    }
    let mut rhs = b.to_vec();
    rhs.resize(n + rows.len(), 0.0);
    system.solve(&rhs)[..n].to_vec()
}

/// Returns an orthonormal basis of the span of the rows.
fn independent(rows: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut row in rows {
        let before = row.iter().map(|x| x * x).sum::<f64>().sqrt();
        for _ in 0..2 {
            for b in &basis {
                let part: f64 = b.iter().zip(&row).map(|(x, y)| x * y).sum();
                row.iter_mut().zip(b).for_each(|(y, x)| *y -= part * x);
            }
        }
        let length = row.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 1e-9 * before {
            basis.push(row.iter().map(|x| x / length).collect());
        }
    }
    basis
}
