//! What a solve gives.

use crate::geometry::Triangle;
use crate::phases::Phases;
use eikona_mesh::{CornerField, Edge, EdgeField, Face, FaceField, TriangleMesh, Vertex};
use eikona_numeric::{Certificate, JumpStatistics};
use std::collections::BTreeMap;

/// The winding number of curves on a surface, and what follows from it. All fields are on [`mesh`](Winding::mesh).
#[derive(Clone, Debug)]
pub struct Winding {
    /// The surface of the result: the input with its faces wound alike where that is possible, and cut along the curves where
    /// these cross faces.
    pub mesh: TriangleMesh,
    /// For a mesh that was cut, the face of the input that each face lies in.
    pub face_parent: Option<Vec<Face>>,
    /// The winding number `w` at each corner; it jumps across the curve, and is smooth elsewhere. One constant a connected
    /// component is arbitrary: [`shift`](Winding::shift) fixes it. NaN at endpoints of the curve, around which it depends on the
    /// direction: see [`value_at`](Winding::value_at).
    pub values: CornerField<f64>,
    /// The whole number of each face: how often the curve winds around it. 1 higher on the left of the curve than on its right.
    pub labels: FaceField<i32>,
    /// How certain each label is: 0.5 where the value is a whole number, 0 where it lies halfway between two.
    pub margin: FaceField<f64>,
    /// For each connected component what makes its values whole numbers where the curve is whole: `label = round(w + shift)`.
    pub shift: Vec<f64>,
    /// Component of each face.
    pub component: FaceField<u32>,
    /// The input as a jump at each edge: the value in the face of its first halfedge minus that of its second. Multiplicities
    /// are added, opposite directions cancel.
    pub curve: EdgeField<i32>,
    /// The jump `t` of the nonbounding part at each edge, completed to closed loops; whole numbers if the curve is closed.
    pub nonbounding: EdgeField<f64>,
    /// The residual function `v` at each corner, which jumps by [`nonbounding`](Winding::nonbounding).
    pub residual_function: CornerField<f64>,
    /// Inner vertices at which the curve ends.
    pub endpoints: Vec<Vertex>,
    /// For each curve and each of its segments (those of zero length left out) whether it bounds.
    pub bounds: Vec<Vec<bool>>,
    /// The completed boundary of the regions: closed polylines of vertices (or from boundary to boundary) between faces of
    /// different labels, with the higher one on the left.
    pub bounding_loops: Vec<Vec<Vertex>>,
    /// The completed nonbounding loops.
    pub nonbounding_loops: Vec<Vec<Vertex>>,
    /// What was done and noticed.
    pub report: WindingReport,
}

/// What the solver did, measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindingReport {
    /// Phases of the solve.
    pub phases: Phases,
    /// Largest relative residual of the linear solves.
    pub residual: f64,
    /// The linear program, if there was need for it.
    pub program: Option<ProgramReport>,
    /// The largest nonbounding jump, and how far such jumps are from whole numbers: 0 for closed curves, up to 0.5 for broken
    /// ones.
    pub largest_nonbounding: f64,
    /// See [`largest_nonbounding`](WindingReport::largest_nonbounding).
    pub farthest_from_whole: f64,
    /// Sentences for the user.
    pub warnings: Vec<String>,
}

/// How the linear program was solved, and how well.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramReport {
    /// The cost of the nonbounding part: lengths, those along the curve times epsilon.
    pub objective: f64,
    /// Value, bound and gap, computed from the answer alone.
    pub certificate: Certificate,
    /// Method and work.
    pub statistics: JumpStatistics,
}

impl Winding {
    /// The winding number at a point of a face (barycentric weights of its corners), shifted so that it is a whole number where
    /// the curve is whole; NaN where all corners of the face are endpoints, or at an endpoint itself.
    ///
    /// Near an endpoint the value depends on the direction from it: corners without value have no weight (eq. 4).
    pub fn value_at(&self, face: Face, weights: [f64; 3]) -> f64 {
        let (mut sum, mut total) = (0.0, 0.0);
        for (k, weight) in weights.into_iter().enumerate() {
            let value = self.values.as_slice()[3 * face.index() + k];
            if !value.is_nan() {
                sum += weight * value;
                total += weight;
            }
        }
        if total == 0.0 { f64::NAN } else { sum / total + self.shift[self.component[face] as usize] }
    }

    /// The whole number nearest to [`value_at`](Winding::value_at) inside a face: its label, but near the curve's gaps, where the
    /// value changes inside faces, that of the point. `None` at an endpoint.
    pub fn label_at(&self, face: Face, weights: [f64; 3]) -> Option<i32> {
        let value = self.value_at(face, weights);
        (!value.is_nan()).then(|| value.round() as i32)
    }

    /// What is left of the jump at an edge when the nonbounding part is taken off.
    pub fn bounding_jump(&self, edge: Edge) -> f64 {
        f64::from(self.curve[edge]) - self.nonbounding[edge]
    }
    /// The label of each face of the input: where the mesh was cut, the one that covers most of the face; of labels that cover the
    /// same area the smallest. (Equally many pieces stand for equal areas where a face has none.)
    ///
    /// # Cost
    /// O(F log n) for n pieces of a face.
    ///
    /// ```
    /// use eikona::mesh::{Curve, SurfaceCurves, SurfacePoint, shapes};
    /// use eikona::winding::{WindingOptions, surface_winding_number};
    /// // Two triangles; a closed curve around most of the first, across its inside.
    /// let square = shapes::grid(1, 1, 1.0, 1.0, shapes::Diagonal::Alternating)?;
    /// let [a, b, c] = square.triangles()[0];
    /// let at = |bary| SurfacePoint::Face { vertices: [a, b, c], bary };
    /// let corners = [[0.98, 0.01, 0.01], [0.01, 0.98, 0.01], [0.01, 0.01, 0.98], [0.98, 0.01, 0.01]];
    /// let curve = SurfaceCurves::from_curve(Curve::signed(corners.map(at)));
    /// let winding = surface_winding_number(&square, &curve, &WindingOptions::default())?;
    /// assert!(winding.mesh.face_count() > 2);
    /// let labels = winding.input_labels();
    /// assert_eq!(labels.as_slice(), [1, 0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn input_labels(&self) -> FaceField<i32> {
        let Some(parents) = &self.face_parent else { return self.labels.clone() };
        let pieces: Vec<(Face, Face)> = parents.iter().copied().zip(self.mesh.faces()).collect();
        // The pieces of a face follow each other.
        let of_parents = pieces.chunk_by(|a, b| a.0 == b.0).map(|pieces| self.largest_label(pieces));
        of_parents.collect::<Vec<i32>>().into()
    }

    /// The label with the largest area among faces (the second of each pair).
    fn largest_label(&self, pieces: &[(Face, Face)]) -> i32 {
        let area = |f: Face| Triangle::of_face(&self.mesh, f).area;
        let has_area = pieces.iter().any(|p| area(p.1) > 0.0);
        let mut covered: BTreeMap<i32, f64> = BTreeMap::new();
        for &(_, f) in pieces {
            *covered.entry(self.labels[f]).or_default() += if has_area { area(f) } else { 1.0 };
        }
        let larger = |a: &(i32, f64), b: &(i32, f64)| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0));
        covered.into_iter().max_by(larger).map_or(0, |(label, _)| label)
    }
}
