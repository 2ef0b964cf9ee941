//! Indices, turning, smoothness and curl of anybody's field of N vectors per face.

use crate::geometry::vector::{dot, norm};
use crate::polar_field::bevel::{BeveledMesh, Cycle};
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::field::polar;
use crate::polar_field::problem::check_degree;
use crate::polar_field::surface::Surface;
use eikona_mesh::{Edge, Face, FaceField, Halfedge, TriangleMesh, Vertex};
use eikona_numeric::{Complex, check_step};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// N vectors per face, face by face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceVectors {
    /// The number N of vectors per face.
    pub degree: u32,
    /// N vectors per face, in the order of the faces; in each face counter-clockwise, in the
    /// orientation of the first face of its component.
    pub vectors: Vec<[f64; 3]>,
    /// How vectors continue each other across edges. Others are matched by the smallest rotation.
    pub matching: Vec<Match>,
}

/// How the vectors of two neighbouring faces continue each other: vector `j` of the first face as
/// vector `j + shift` of the second one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Match {
    /// The faces.
    pub faces: [Face; 2],
    /// The vertices of their edge; `None` for all edges that they share.
    pub vertices: Option<[Vertex; 2]>,
    /// The shift, modulo N.
    pub shift: i64,
}

/// What a field of vectors per face does.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FieldInspection {
    /// The index of each singular vertex inside the surface, a multiple of 1/N.
    pub vertices: Vec<(Vertex, f64)>,
    /// The index of each boundary loop relative to its tangent.
    pub boundaries: Vec<f64>,
    /// The sum of all indices, and the Euler characteristic: they are equal on every field that has
    /// a direction in each face.
    pub index_sum: f64,
    /// The Euler characteristic.
    pub euler_characteristic: i64,
    /// The sum of the indices and the Euler characteristic of each component.
    pub components: Vec<(f64, i64)>,
    /// Largest rotation from face to face beyond parallel transport, in radians, and the edge.
    pub largest_rotation: (f64, Option<Edge>),
    /// Root mean square of this rotation over the edges, in radians.
    pub mean_rotation: f64,
    /// Edges with a rotation of more than 0.9 of pi/N. The true rotation may be the other one, by
    /// which the indices of both ends change: refine the mesh there, or give a matching.
    pub ambiguous: Vec<Edge>,
    /// The sum over edges of the squared rotation of the N-th power, times the squared length over
    /// the area of both faces: the Dirichlet energy of the phase, without unit.
    pub smoothness: f64,
    /// Largest curl: the difference of the projections of matched vectors to their common edge,
    /// relative to the mean length of the vectors; and the edge.
    pub largest_curl: (f64, Option<Edge>),
    /// Root mean square of the curl.
    pub mean_curl: f64,
    /// Faces with a vector that is zero.
    pub zero: Vec<Face>,
    /// Faces whose vectors are not listed counter-clockwise.
    pub disordered: Vec<Face>,
    /// Faces whose vectors are not equally long and equally spaced, to 1 percent.
    pub asymmetric: Vec<Face>,
    /// Largest angle between a vector and the plane of its face, in radians, and the face.
    pub out_of_plane: (f64, Option<Face>),
}

/// Rotations beyond this share of pi/N are ambiguous.
const AMBIGUOUS: f64 = 0.9;
/// Vectors that differ by less than this, relative to their length, are equal.
const EQUAL: f64 = 0.01;

/// Measures a field of N vectors per face.
///
/// Indices are signed. Each face turns to the next by the rotation that matches its vectors with
/// the least turn (or as the matching says), and the same rotation counts at both ends of the edge,
/// so that the indices add up to the Euler characteristic.
///
/// # Errors
/// [`PolarFieldError::Degree`]; [`PolarFieldError::FieldSize`] unless there are N vectors per face;
/// [`PolarFieldError::NonFiniteVector`]; [`PolarFieldError::Matching`]; and the errors of
/// [`Solver::new`](super::Solver::new) about the surface.
///
/// # Cost
/// O(N F).
///
/// ```
/// use eikona::mesh::shapes;
/// use eikona::polar_field::{FaceVectors, inspect_field};
/// // The same direction everywhere on a disk: it turns once relative to the boundary.
/// let disk = shapes::disk(4, 12, 1.0)?;
/// let vectors = vec![[1.0, 0.0, 0.0]; disk.face_count()];
/// let seen = inspect_field(&disk, &FaceVectors { degree: 1, vectors, ..Default::default() })?;
/// assert!(seen.vertices.is_empty() && seen.boundaries == [1.0]);
/// assert!(seen.largest_rotation.0 < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn inspect_field(mesh: &TriangleMesh, field: &FaceVectors) -> Result<FieldInspection, PolarFieldError> {
    check_degree(field.degree)?;
    let (found, expected) = (field.vectors.len(), field.degree as usize * mesh.face_count());
    if found != expected {
        let (degree, faces) = (field.degree, mesh.face_count());
        return Err(PolarFieldError::FieldSize { found, degree, faces });
    }
    let n = field.degree as usize;
    if let Some(i) = field.vectors.iter().position(|v| v.iter().any(|x| !x.is_finite())) {
        return Err(PolarFieldError::NonFiniteVector { face: Face((i / n) as u32), vector: i % n });
    }
    let Surface { bevel, .. } = Surface::of(mesh)?;
    let mut result = FieldInspection {
        euler_characteristic: bevel.topology.components.iter().map(|c| c.euler_characteristic).sum(),
        components: bevel.topology.components.iter().map(|c| (0.0, c.euler_characteristic)).collect(),
        ..FieldInspection::default()
    };
    let flat = result.flattened(&bevel, field)?;
    let matching = Matching::new(&bevel, field)?;
    result.measure(&bevel, &flat, n, &matching)?;
    Ok(result)
}

impl FieldInspection {
    /// Returns the vectors in the layouts of the faces, and notes what is wrong with them.
    fn flattened(
        &mut self,
        bevel: &BeveledMesh,
        field: &FaceVectors,
    ) -> Result<Vec<Complex>, PolarFieldError> {
        let n = field.degree as usize;
        let mut flat = Vec::with_capacity(field.vectors.len());
        for face in bevel.mesh.faces() {
            check_step(face.index())?;
            let [along, across, normal] = bevel.frame(face);
            let first = face.index() * n;
            let begin = flat.len();
            for &v in &field.vectors[first..first + n] {
                let size = norm(v);
                if size > 0.0 {
                    let angle = (dot(v, normal) / size).clamp(-1.0, 1.0).asin().abs();
                    if angle > self.out_of_plane.0 {
                        self.out_of_plane = (angle, Some(face));
                    }
                }
                flat.push(Complex { re: dot(v, along), im: dot(v, across) });
            }
            let own = &mut flat[begin..];
            if own.iter().any(|z| z.norm() == 0.0) {
                self.zero.push(face);
                continue;
            }
            let turns = (0..n).map(|j| (own[(j + 1) % n] * own[j].conj()).arg().rem_euclid(TAU));
            let whole: f64 = turns.clone().sum();
            let is_ordered = (whole - TAU).abs() <= 1e-6;
            if n > 1 && !is_ordered {
                self.disordered.push(face);
            }
            let size = own[0].norm();
            let is_even = |turn: f64| (turn - TAU / n as f64).abs() < EQUAL;
            let is_equal = |z: &Complex| (z.norm() - size).abs() < EQUAL * size;
            if !is_ordered && field.matching.is_empty() {
                let first = own[0].conj();
                own.sort_by(|a, b| {
                    let angle = |z: &Complex| (*z * first).arg().rem_euclid(TAU);
                    angle(a).total_cmp(&angle(b))
                });
            }
            let turns = (0..n).map(|j| (own[(j + 1) % n] * own[j].conj()).arg().rem_euclid(TAU));
            if n > 1 && !(turns.clone().all(is_even) && own.iter().all(is_equal)) {
                self.asymmetric.push(face);
            }
        }
        Ok(flat)
    }

    fn measure(
        &mut self,
        bevel: &BeveledMesh,
        flat: &[Complex],
        n: usize,
        matching: &Matching,
    ) -> Result<(), PolarFieldError> {
        let connection = bevel.connection()?;
        let mut jumps = bevel.zero();
        let mean_size = flat.iter().map(|z| z.norm()).sum::<f64>() / flat.len() as f64;
        // A face without directions has any: those of its layout, so that the indices add up.
        let mut directions = flat.to_vec();
        let mut has_directions = FaceField::constant(bevel.mesh.face_count(), true);
        for &face in &self.zero {
            has_directions[face] = false;
            for (j, z) in directions[face.index() * n..(face.index() + 1) * n].iter_mut().enumerate() {
                *z = polar(1.0, TAU * j as f64 / n as f64);
            }
        }
        let (mut squares, mut curls, mut count) = (0.0, 0.0, 0usize);
        for (step, (h, twin)) in bevel.edges().enumerate() {
            check_step(step)?;
            let of = |f: Face| &directions[f.index() * n..(f.index() + 1) * n];
            let (own, other) = (of(h.face()), of(twin.face()));
            // Vectors of the twin's face, carried to the layout of the own one.
            let turn = Complex { re: connection.jump[h].cos(), im: connection.jump[h].sin() };
            // The rotations if the own vectors are shifted by k against the other ones.
            let rotations =
                |k: usize| (0..n).map(move |j| (own[(j + k) % n] * (other[j] * turn).conj()).arg());
            let shift = matching.shift(h, n).unwrap_or_else(|| {
                // Squares, as half turns to both sides add up to nothing.
                let squares = |k: &usize| rotations(*k).map(|x| x * x).sum::<f64>();
                let to_first = |k: &usize| (own[*k] * (other[0] * turn).conj()).arg().abs();
                let nearest = (0..n).min_by(|a, b| to_first(a).total_cmp(&to_first(b))).unwrap_or(0);
                let beside = [nearest, (nearest + 1) % n, (nearest + n - 1) % n];
                beside.into_iter().min_by(|a, b| squares(a).total_cmp(&squares(b))).unwrap_or(nearest)
            });
            // N times the mean rotation.
            let effort: f64 = rotations(shift).sum();
            jumps.jump[h] = effort;
            jumps.jump[twin] = -effort;
            let e = bevel.mesh.edge(h);
            let rotation = effort / n as f64;
            squares += rotation * rotation;
            count += 1;
            if rotation.abs() > self.largest_rotation.0 {
                self.largest_rotation = (rotation.abs(), Some(e));
            }
            if effort.abs() > AMBIGUOUS * PI {
                self.ambiguous.push(e);
            }
            let triangles = [h, twin].map(|h| &bevel.triangles[h.face().index()]);
            let length = triangles[0].lengths[h.side()];
            self.smoothness += length * length / (triangles[0].area + triangles[1].area) * effort * effort;
            if !(has_directions[h.face()] && has_directions[twin.face()]) {
                continue;
            }
            let along = triangles[0].directions()[h.side()];
            let curl = (0..n)
                .map(|j| ((own[(j + shift) % n] - other[j] * turn) * along.conj()).re.abs())
                .fold(0.0, f64::max)
                / mean_size;
            curls += curl * curl;
            if curl > self.largest_curl.0 {
                self.largest_curl = (curl, Some(e));
            }
        }
        if count > 0 {
            self.mean_rotation = (squares / count as f64).sqrt();
            self.mean_curl = (curls / count as f64).sqrt();
        }
        let (sums, curvature) = (bevel.sums(&jumps), bevel.curvature());
        let degree = n as f64;
        for cycle in bevel.cycles() {
            let index = ((sums[cycle] + degree * curvature[cycle]) / TAU).round() / degree;
            if index != 0.0 && matches!(cycle, Cycle::Vertex(_) | Cycle::Boundary(_)) {
                self.components[bevel.component_of(cycle)].0 += index;
            }
            match cycle {
                Cycle::Vertex(v) if index != 0.0 => self.vertices.push((v, index)),
                Cycle::Boundary(_) => self.boundaries.push(index),
                _ => {}
            }
        }
        let inner: f64 = self.vertices.iter().map(|(_, index)| index).sum();
        self.index_sum = inner + self.boundaries.iter().sum::<f64>();
        Ok(())
    }
}

/// Shifts of the vectors of the face of a halfedge against those of its twin's, as given.
struct Matching(HashMap<Halfedge, i64>);

impl Matching {
    fn new(bevel: &BeveledMesh, field: &FaceVectors) -> Result<Matching, PolarFieldError> {
        let mut shifts = HashMap::new();
        for (row, matched) in field.matching.iter().enumerate() {
            let [f, g] = matched.faces;
            let mut found = false;
            let sides = (0..3).map(|k| f.halfedge(k)).filter(|_| f.index() < bevel.mesh.face_count());
            for h in sides {
                let ends = [bevel.mesh.origin(h), bevel.mesh.tip(h)];
                let is_named = |[v, w]: [Vertex; 2]| ends == [v, w] || ends == [w, v];
                if let Some(twin) = bevel.twin[h]
                    && twin.face() == g
                    && matched.vertices.is_none_or(is_named)
                {
                    // The second face's vectors come later by the shift.
                    shifts.insert(twin, matched.shift);
                    shifts.insert(h, -matched.shift);
                    found = true;
                }
            }
            if !found {
                return Err(PolarFieldError::Matching { row, faces: [f, g] });
            }
        }
        Ok(Matching(shifts))
    }

    fn shift(&self, h: Halfedge, n: usize) -> Option<usize> {
        self.0.get(&h).map(|k| k.rem_euclid(n as i64) as usize)
    }
}
