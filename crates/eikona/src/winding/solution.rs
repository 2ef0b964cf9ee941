//! Result of a solve: winding number, labels and report.

use crate::Warning;
use crate::cut::{EmbeddedCurve, areas_of_pieces, label_of_most};
use crate::geometry::unit_of;
use crate::phases::Phases;
use crate::winding::decomposition::Part;
use crate::winding::loops::JumpLoop;
use crate::winding::orientation::Orientation;
use eikona_mesh::{
    CornerField, Curve, Edge, EdgeField, Face, FaceField, Provenance, SurfaceCurves, TriangleMesh, Vertex,
};
use eikona_numeric::{Certificate, JumpStatistics};

/// Winding number of curves on a surface, with labels and completed curves. All fields live on
/// [`mesh`](Winding::mesh).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Winding {
    /// The surface of the result: the input, with its faces consistently oriented where possible.
    /// It is cut along curves that cross faces and along straightened completions
    /// ([`CompletionShape`](super::CompletionShape)), and refined along short open pieces of the
    /// curve ([`split_short`](super::WindingOptions::split_short)); fields then have values per
    /// face of the cut mesh, not of the input. See [`provenance`](Winding::provenance),
    /// [`input_labels`](Winding::input_labels), [`label_at`](Winding::label_at).
    pub mesh: TriangleMesh,
    /// The place on the input of each vertex of [`mesh`](Winding::mesh), and the input face that
    /// contains each face, flipped or not. Input vertices come first and keep their numbers.
    pub provenance: Provenance,
    /// The winding number `w` at each corner. It jumps across the curve and is smooth elsewhere. It
    /// is determined up to one constant per island, which [`shift`](Winding::shift) fixes. NaN at
    /// endpoints of the curve, around which it depends on the direction (see
    /// [`value_at`](Winding::value_at)), and at vertices of the completed curve with more than one
    /// fan of faces (jumps below 0.01 fade out towards them instead).
    pub values: CornerField<f64>,
    /// The label of each face: the integer winding number, 1 higher on the left of the curve than
    /// on its right. Beside straightened completions it may differ from the rounded value. Faces
    /// without a value at any corner have the label of the nearest face with one.
    pub labels: FaceField<i32>,
    /// The certainty of each label: 0.5 where the value is an integer; 0 where it lies halfway
    /// between two or nearer to another one, and in faces without values.
    pub margin: FaceField<f64>,
    /// For each island, the constant that makes its values integers where the curve has no gaps:
    /// `label = round(w + shift)` for the mean `w` over the corners of a face.
    pub shift: Vec<f64>,
    /// The island of each face: the set of faces joined to it through vertices with values, usually
    /// its connected component of the mesh.
    pub island: FaceField<u32>,
    /// The input curves as walks along edges of [`mesh`](Winding::mesh); each step names the
    /// segment that it is a piece of.
    pub curves: Vec<EmbeddedCurve>,
    /// The input as a jump per edge: the value in the face of its first halfedge minus that of its
    /// second. Multiplicities add, opposite directions cancel.
    pub jump: EdgeField<i32>,
    /// The jump `t` of the nonbounding part per edge, completed to closed loops; integers if the
    /// curve is closed. Straightened loops may run along the curve and add to its own jump.
    pub nonbounding: EdgeField<f64>,
    /// The residual function `v` at each corner, which jumps by
    /// [`nonbounding`](Winding::nonbounding).
    pub residual_function: CornerField<f64>,
    /// Inner vertices at which the curve ends.
    pub endpoints: Vec<Vertex>,
    /// The part that each step of each of [`curves`](Winding::curves) belongs to.
    pub parts: Vec<Vec<Part>>,
    /// The completed boundary of the regions: loops between faces of different labels.
    pub bounding_loops: Vec<JumpLoop>,
    /// The completed nonbounding loops, those with a jump of more than 0.1.
    pub nonbounding_loops: Vec<JumpLoop>,
    /// Timings, residuals and warnings.
    pub report: WindingReport,
    /// The mesh before it was cut, if it was: the input with its faces oriented.
    pub(crate) uncut: Option<TriangleMesh>,
    /// Whether the label at a point is that of its face rather than its rounded value.
    pub(crate) follows_labels: bool,
}

/// Timings, residuals and warnings of one solve.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct WindingReport {
    /// Wall time per phase.
    pub phases: Phases,
    /// Largest relative residual of the linear solves.
    pub residual: f64,
    /// The linear program, if one was solved.
    pub program: Option<ProgramReport>,
    /// The largest nonbounding jump of the solution on edges.
    pub largest_nonbounding: f64,
    /// Largest distance of such a jump from an integer: 0 for closed curves, up to 0.5 for broken
    /// ones.
    pub farthest_from_whole: f64,
    /// The share of the area with uncertain labels: [`margin`](Winding::margin) below 0.1.
    pub uncertain_area: f64,
    /// How the completion was straightened; `None` if there is none, or if it stays on edges
    /// ([`CompletionShape`](super::CompletionShape)).
    pub completion: Option<CompletionReport>,
    /// Stretches of the curve that look reversed, if the orientation was checked.
    pub orientation: Option<Orientation>,
    /// Why the orientation was not checked, if [`Diagnosis`](super::Diagnosis) asked for it.
    pub orientation_unchecked: Option<String>,
    /// Warnings about mesh, curves and labels.
    pub warnings: Vec<Warning>,
}

/// How the completion of the curve was straightened. Its pieces run between open ends of the curve
/// and junctions of pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct CompletionReport {
    /// Number of completion pieces, of region boundaries and of nonbounding loops.
    pub pieces: usize,
    /// Number of straightened pieces. The others are single edges, are already straight, or stay on
    /// edges.
    pub straightened: usize,
    /// Number of pieces that could not be straightened: their paths would cross other parts of the
    /// completed curve, vanish, or take in regions whose label is certain.
    pub on_edges: usize,
    /// Total length of the straightened pieces along edges, in the unit of the mesh.
    pub length_before: f64,
    /// Their total length after straightening.
    pub length_after: f64,
}

/// Cost, certificate and work of the linear program. Costs are lengths in the unit of the mesh.
///
/// Deviation from eq. 11: edge lengths are increased by up to 1e-4, each by a different amount, to
/// break ties between shortest loops deterministically. [`certificate`](ProgramReport::certificate)
/// proves the solution optimal for the increased lengths;
/// [`lower_bound`](ProgramReport::lower_bound) bounds its distance from the optimum for the true
/// lengths.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ProgramReport {
    /// Cost of the nonbounding part for true lengths; edges along the curve count times epsilon.
    pub objective: f64,
    /// Lower bound on the cost of any nonbounding part for true lengths; at most 1e-4 (relative)
    /// below the objective.
    pub lower_bound: f64,
    /// Value, bound and gap of the program with increased lengths, computed from the solution
    /// alone. Its value is at most 1e-4 (relative) larger than the objective.
    pub certificate: Certificate,
    /// Method and work; the work is summed over all attempts.
    pub statistics: JumpStatistics,
    /// Number of attempts: one, plus one each time limits were raised or dropped.
    pub attempts: usize,
    /// Number of curve edges whose jump limit was raised or dropped because the limits were
    /// infeasible: there the nonbounding part need not lie between zero and the curve.
    pub relaxed: usize,
}

impl ProgramReport {
    /// Converts costs to another unit.
    pub(crate) fn in_unit(mut self, unit: f64) -> ProgramReport {
        let Certificate { primal, dual, .. } = &mut self.certificate;
        for cost in [&mut self.objective, &mut self.lower_bound, primal, dual] {
            *cost *= unit;
        }
        self
    }
}

impl Winding {
    /// Returns the winding number at a point of an input face (barycentric coordinates in the order
    /// of its corners there), shifted to an integer where the curve has no gaps. On the curve it is
    /// the value of one of the sides. NaN at an endpoint of the curve, in a face whose corners are
    /// all endpoints, and for faces that do not exist.
    ///
    /// Near an endpoint the value depends on the direction from it: corners without a value have no
    /// weight (eq. 4).
    ///
    /// # Cost
    /// O(log F) plus the number of pieces of the face.
    pub fn value_at(&self, face: Face, weights: [f64; 3]) -> f64 {
        let (face, weights) = self.piece_at(face, weights);
        let Some(values) = self.values.as_slice().get(3 * face.index()..3 * face.index() + 3) else {
            return f64::NAN;
        };
        let (mut sum, mut total) = (0.0, 0.0);
        for (value, weight) in values.iter().zip(weights).filter(|(value, _)| !value.is_nan()) {
            sum += weight * value;
            total += weight;
        }
        if total == 0.0 { f64::NAN } else { sum / total + self.shift[self.island[face] as usize] }
    }

    /// Returns the label at a point. With straightened completions it is that of the face of
    /// [`mesh`](Winding::mesh) there, so it changes across the completed boundary. With completions
    /// on edges it is [`value_at`](Winding::value_at) rounded, which changes inside faces near gaps
    /// of the curve. `None` where there is no value.
    ///
    /// ```
    /// use eikona::mesh::{Curve, Face, SurfaceCurves, Vertex, shapes};
    /// use eikona::winding::{WindingOptions, surface_winding_number};
    /// let disk = shapes::disk(20, 6, 20.0)?;
    /// let ring = Curve::signed([1, 2, 3, 4, 5, 6, 1].map(Vertex));
    /// let curve = SurfaceCurves::from_curve(ring);
    /// let winding = surface_winding_number(&disk, &curve, &WindingOptions::default())?;
    /// let middle = disk.vertex_corners(Vertex(0))[0].face();
    /// assert_eq!(winding.label_at(middle, [0.2, 0.3, 0.5]), Some(1));
    /// let nowhere = (Face(1_000_000), [1., 0., 0.]);
    /// assert_eq!(winding.labels_at(&[(middle, [1. / 3.; 3]), nowhere]), [Some(1), None]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn label_at(&self, face: Face, weights: [f64; 3]) -> Option<i32> {
        let value = self.value_at(face, weights);
        let label = || {
            let piece = self.piece_at(face, weights).0;
            if self.follows_labels { self.labels[piece] } else { value.round() as i32 }
        };
        (!value.is_nan()).then(label)
    }

    /// Returns [`label_at`](Winding::label_at) for many points.
    pub fn labels_at(&self, points: &[(Face, [f64; 3])]) -> Vec<Option<i32>> {
        points.iter().map(|&(face, weights)| self.label_at(face, weights)).collect()
    }

    /// Returns the face of [`mesh`](Winding::mesh) that contains a point of an input face, with the
    /// point's barycentric coordinates in it.
    fn piece_at(&self, face: Face, mut weights: [f64; 3]) -> (Face, [f64; 3]) {
        let parts = self.provenance.face_parts(face);
        if parts.clone().next().is_some_and(|part| self.provenance.is_flipped(part)) {
            weights.swap(1, 2);
        }
        let Some(uncut) = &self.uncut else { return (face, weights) };
        // Cuts are located by normalised barycentric coordinates.
        let sum: f64 = weights.iter().sum();
        let weights = weights.map(|w| w / sum);
        if face.index() >= uncut.face_count() {
            return (Face(u32::MAX), weights);
        }
        let corners = uncut.face_vertices(face);
        let weights_in_part = |part: Face| {
            let places = self.mesh.face_vertices(part).map(|v| self.provenance.weights_in(v, corners));
            barycentric(weights, places)
        };
        // Take the face with the least negative coordinates: rounding can leave points on sides in
        // none.
        let or_none = |x: f64| if x.is_nan() { f64::NEG_INFINITY } else { x };
        let lowest = |w: &[f64; 3]| w.iter().fold(f64::INFINITY, |m, x| m.min(or_none(*x)));
        let best = parts
            .map(|part| (part, weights_in_part(part)))
            .max_by(|a, b| lowest(&a.1).total_cmp(&lowest(&b.1)));
        best.unwrap_or((Face(u32::MAX), weights))
    }

    /// Returns the jump at an edge without its nonbounding part.
    pub fn bounding_jump(&self, edge: Edge) -> f64 {
        f64::from(self.jump[edge]) - self.nonbounding[edge]
    }

    /// Returns the bounding part of the input, as curves along edges of [`mesh`](Winding::mesh),
    /// each copy by itself. It is not completed: see [`bounding_loops`](Winding::bounding_loops).
    ///
    /// ```
    /// use eikona::mesh::{Curve, SurfaceCurves, Vertex, shapes};
    /// use eikona::winding::{WindingOptions, surface_winding_number};
    /// // Around the tube of a torus, twice.
    /// let torus = shapes::torus(1.0, 0.4, 30, 15)?;
    /// let twice = Curve::signed((0..=30).map(|j| Vertex(7 * 15 + j % 15)));
    /// let curve = SurfaceCurves::from_curve(twice);
    /// let winding = surface_winding_number(&torus, &curve, &WindingOptions::default())?;
    /// assert_eq!(winding.bounding_part().segment_count(), 0);
    /// assert_eq!(winding.nonbounding_part().segment_count(), 30);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn bounding_part(&self) -> SurfaceCurves {
        self.part(Part::Bounding)
    }

    /// Returns the nonbounding part of the input, in the form of
    /// [`bounding_part`](Winding::bounding_part).
    pub fn nonbounding_part(&self) -> SurfaceCurves {
        self.part(Part::Nonbounding)
    }

    fn part(&self, wanted: Part) -> SurfaceCurves {
        let mut part = SurfaceCurves { curves: Vec::new(), points: Vec::new() };
        for (walk, parts) in self.curves.iter().zip(&self.parts) {
            let mut first = 0;
            for run in parts.chunk_by(|a, b| a == b) {
                if run[0] == wanted {
                    let nodes = walk.vertices[first..=first + run.len()].iter().map(|&v| v.into()).collect();
                    part.curves.push(Curve { kind: walk.kind, up: walk.up, nodes });
                }
                first += run.len();
            }
        }
        part
    }

    /// Whether [`mesh`](Winding::mesh) was cut, so that its faces are not those of the input.
    pub fn is_cut(&self) -> bool {
        self.uncut.is_some()
    }

    /// Returns the label of each input face: where the mesh was cut, the label that covers the
    /// largest area of the face, on ties the smallest. (In faces of zero area pieces are counted
    /// instead.)
    ///
    /// # Cost
    /// O(F log n) for n pieces per face.
    ///
    /// ```
    /// use eikona::mesh::{Curve, SurfaceCurves, SurfacePoint, shapes};
    /// use eikona::winding::{WindingOptions, surface_winding_number};
    /// // Two triangles; a closed curve around most of the first, across its inside.
    /// let square = shapes::grid(1, 1, 1.0, 1.0, shapes::Diagonal::Alternating)?;
    /// let [a, b, c] = square.triangles()[0];
    /// let at = |bary| SurfacePoint::Face { vertices: [a, b, c], bary };
    /// let [a, b, c] = [[0.98, 0.01, 0.01], [0.01, 0.98, 0.01], [0.01, 0.01, 0.98]];
    /// let corners = [a, b, c, a];
    /// let curve = SurfaceCurves::from_curve(Curve::signed(corners.map(at)));
    /// let winding = surface_winding_number(&square, &curve, &WindingOptions::default())?;
    /// assert!(winding.mesh.face_count() > 2);
    /// let labels = winding.input_labels();
    /// assert_eq!(labels.as_slice(), [1, 0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn input_labels(&self) -> FaceField<i32> {
        if !self.is_cut() {
            return self.labels.clone();
        }
        self.labels_by(&self.provenance)
            .iter()
            .map(|(_, label)| label.unwrap_or(0))
            .collect::<Vec<_>>()
            .into()
    }

    /// Returns the labels of the faces of a mesh from which the input was derived, for instance of
    /// polygons that were triangulated, by the rule of [`input_labels`](Winding::input_labels).
    /// `derived` leads from that mesh to the input. `None` for a face that was dropped.
    ///
    /// # Cost
    /// O(F log F).
    ///
    /// # Panics
    /// If `derived` leads to another mesh.
    ///
    /// ```
    /// use eikona::mesh::{Curve, PolygonMesh, SurfaceCurves, Vertex};
    /// use eikona::winding::{WindingOptions, surface_winding_number};
    /// // Two squares, and a curve between them.
    /// let corners = [[0., 0.], [1., 0.], [2., 0.], [0., 1.], [1., 1.], [2., 1.]];
    /// let mut squares = PolygonMesh::new(corners.map(|[x, y]| [x, y, 0.]).to_vec());
    /// squares.push_face([0, 1, 4, 3]);
    /// squares.push_face([1, 2, 5, 4]);
    /// let (mesh, derived) = squares.triangulate()?;
    /// let curve = SurfaceCurves::from_curve(Curve::signed([1, 4].map(Vertex)));
    /// let winding = surface_winding_number(&mesh, &curve, &WindingOptions::default())?;
    /// assert_eq!(winding.original_labels(&derived).as_slice(), [Some(1), Some(0)]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn original_labels(&self, derived: &Provenance) -> FaceField<Option<i32>> {
        self.labels_by(&derived.then(&self.provenance))
    }

    /// Returns the label that covers most of each face of an original mesh.
    fn labels_by(&self, provenance: &Provenance) -> FaceField<Option<i32>> {
        let unit = unit_of(&self.mesh);
        let most = |first: Face, labels: &[i32]| {
            let pieces: Vec<Face> = (first.0..).map(Face).take(labels.len()).collect();
            let areas = areas_of_pieces(&self.mesh, unit, &pieces);
            label_of_most(areas.into_iter().zip(labels.iter().copied()))
        };
        provenance.push_faces(&self.labels, most).expect("each face of the result has a label")
    }
}

/// Returns the barycentric coordinates of a point in a triangle, all given by coordinates in
/// another triangle; NaN if the corners are collinear.
fn barycentric(point: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let area =
        |p: [f64; 3], q: [f64; 3], r: [f64; 3]| (q[1] - p[1]) * (r[2] - p[2]) - (q[2] - p[2]) * (r[1] - p[1]);
    let whole = area(a, b, c);
    [area(point, b, c), area(a, point, c), area(a, b, point)].map(|part| part / whole)
}
