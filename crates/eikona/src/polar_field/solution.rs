//! Result of a solve: the field, evaluated anywhere, and its report.

use crate::Warning;
use crate::geometry::vector::{add, scale};
use crate::phases::Phases;
use crate::polar_field::alignment::Followed;
use crate::polar_field::domain::Domain;
use crate::polar_field::field::{Values, polar};
use crate::polar_field::singularity::Prescribed;
use eikona_mesh::{Corner, CurveError, Face, Located, SurfacePoint, TriangleMesh};
use eikona_numeric::Complex;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A field of N directions at every point of a surface: a power of a linear field in each face.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PolarField {
    pub(super) domain: Arc<Domain>,
    pub(super) values: Values,
    pub(super) degree: u32,
    /// The prescribed singularities, those of index zero included.
    pub(super) singular: Vec<Prescribed>,
    /// The corners at which the bound of the scales is attained.
    pub(super) lowest_corners: Vec<u32>,
    /// Residuals, measured indices and timings.
    pub report: FieldReport,
}

/// An element whose index, as measured from the field, differs from the prescribed one.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The element, in words.
    pub element: String,
    /// The prescribed index.
    pub prescribed: f64,
    /// The measured index.
    pub measured: f64,
}

/// Residuals, measured indices and timings of one solve.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FieldReport {
    /// Duration of each phase of the solve.
    pub phases: Phases,
    /// Duration of each phase of the preparation.
    pub preparation: Phases,
    /// Largest deviation of the rotation from the prescribed sums, in radians.
    pub residual: f64,
    /// Largest deviation of the phases from a whole number of turns, in radians.
    pub closure: f64,
    /// The smoothness energy: squared gradients plus 10 times squared jumps.
    pub energy: f64,
    /// The energy as printed in the paper, with jumps times 50 and times 1, for comparison.
    pub printed_energy: [f64; 2],
    /// The index of each prescribed singularity, measured from the field.
    pub measured: Vec<f64>,
    /// Elements at which the measured index differs from the prescribed one, zero included: the
    /// field turns by more than half a turn of its N-th power from one face to the next there.
    pub aliased: Vec<Measured>,
    /// Singular edges and faces in which no scale puts the singularity at the wanted point.
    pub unplaced: Vec<String>,
    /// How well the field follows each curve, boundary loop and crease.
    pub followed: Vec<Followed>,
    /// Largest power in a face.
    pub largest_power: u32,
    /// Rounds of the active set for the scales.
    pub scale_rounds: usize,
    /// Corners whose scale is at the bound.
    pub scales_at_bound: usize,
    /// Whether the active set did not end. The scales then place all singularities, but are not the
    /// smoothest.
    pub scales_gave_up: bool,
    /// Warnings of the preparation and of the solve.
    pub warnings: Vec<Warning>,
}

impl PolarField {
    /// Returns the mesh of the field.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.domain.bevel.mesh
    }

    /// Returns the number N of directions.
    pub fn degree(&self) -> u32 {
        self.degree
    }

    /// Returns the power of the linear field in each face.
    pub fn power_of_face(&self, face: Face) -> u32 {
        self.values.powers[face]
    }

    /// Returns the N vectors at a point, counter-clockwise, in the plane of a face that contains it
    /// (the first one at a vertex or edge). All have length 1; zero at singularities.
    ///
    /// # Errors
    /// [`CurveError`] if the point is not on the mesh.
    pub fn vectors_at(&self, point: SurfacePoint) -> Result<Vec<[f64; 3]>, CurveError> {
        let (face, weights) = self.place_in_face(point)?;
        Ok(face.map_or(vec![[0.0; 3]; self.degree as usize], |face| self.vectors_in(face, weights)))
    }

    /// Returns the N vectors at a point with the length of the interpolation, which falls to zero
    /// at singularities: [`vectors_at`](Self::vectors_at) times the N-th root of the length of
    /// [`power_at`](Self::power_at).
    ///
    /// # Errors
    /// [`CurveError`] if the point is not on the mesh.
    ///
    /// ```
    /// use eikona::mesh::{SurfacePoint, shapes};
    /// use eikona::polar_field::{FieldOptions, Place, Singularity, Solver};
    /// let disk = shapes::disk(6, 12, 1.0)?;
    /// let [i, j, k] = disk.triangles()[40];
    /// let at = |bary| SurfacePoint::Face { vertices: [i, j, k], bary };
    /// let singularities = [
    ///     Singularity { place: Place::Point(at([0.2, 0.5, 0.3])), index: 1.0 },
    ///     Singularity { place: Place::Boundary(0), index: 0.0 },
    /// ];
    /// let solver = Solver::new(&disk, &Default::default())?;
    /// let field = solver.solve(&singularities, &FieldOptions::default().with_degree(1))?;
    /// let length = |x: f64| {
    ///     let [v] = field.scaled_vectors_at(at([0.2 + x, 0.5 - x, 0.3]))?[..] else { panic!() };
    ///     Ok::<f64, Box<dyn std::error::Error>>(v[0].hypot(v[1]).hypot(v[2]))
    /// };
    /// // The field is linear in the face of its singularity.
    /// assert!((length(0.2)? - 2.0 * length(0.1)?).abs() < 1e-9 * length(0.2)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn scaled_vectors_at(&self, point: SurfacePoint) -> Result<Vec<[f64; 3]>, CurveError> {
        let (face, weights) = self.place_in_face(point)?;
        let Some(face) = face else { return Ok(vec![[0.0; 3]; self.degree as usize]) };
        let length = self.power_at(face, weights).norm().powf(1.0 / f64::from(self.degree));
        Ok(self.vectors_in(face, weights).into_iter().map(|v| scale(v, length)).collect())
    }

    /// Returns the N unit vectors at a corner, counter-clockwise, in the plane of its face.
    ///
    /// ```
    /// use eikona::mesh::{Corner, SurfacePoint, shapes};
    /// use eikona::polar_field::{FieldOptions, Solver};
    /// let torus = shapes::torus(1.0, 0.4, 16, 8)?;
    /// let solver = Solver::new(&torus, &Default::default())?;
    /// let field = solver.solve(&[], &FieldOptions::default())?;
    /// let at_corner = field.vectors_at_corner(Corner(3 * 7 + 1));
    /// // It is what points of the face come close to.
    /// let bary = [1e-7, 1.0 - 2e-7, 1e-7];
    /// let point = SurfacePoint::Face { vertices: torus.triangles()[7], bary };
    /// for (v, beside) in at_corner.iter().zip(field.vectors_at(point)?) {
    ///     assert!((0..3).all(|k| (v[k] - beside[k]).abs() < 1e-5));
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn vectors_at_corner(&self, corner: Corner) -> Vec<[f64; 3]> {
        let mut weights = [0.0; 3];
        weights[corner.halfedge().side()] = 1.0;
        self.vectors_in(corner.face(), weights)
    }

    /// Returns the N unit vectors at a point of a face, counter-clockwise; zero where the field
    /// vanishes.
    pub(super) fn vectors_in(&self, face: Face, weights: [f64; 3]) -> Vec<[f64; 3]> {
        let power = self.power_at(face, weights);
        if power.norm() == 0.0 {
            return vec![[0.0; 3]; self.degree as usize];
        }
        let first = power.arg() / f64::from(self.degree);
        let [along, across, _] = self.domain.bevel.frame(face);
        let vector = |k: u32| {
            let z = polar(1.0, first + TAU * f64::from(k) / f64::from(self.degree));
            add(scale(along, z.re), scale(across, z.im))
        };
        (0..self.degree).map(vector).collect()
    }

    /// Returns the weights of a point in a face that contains it, the first one at a vertex or
    /// edge; no face for an unused vertex.
    fn place_in_face(&self, point: SurfacePoint) -> Result<(Option<Face>, [f64; 3]), CurveError> {
        let mesh = self.mesh();
        let located = point.locate(mesh)?;
        let face = match located {
            Located::Face(f, _) => Some(f),
            Located::Edge(e, _) => Some(mesh.edge_halfedges(e)[0].face()),
            Located::Vertex(v) => mesh.vertex_corners(v).first().map(|corner| corner.face()),
        };
        let weights = face.and_then(|face| located.weights_in_face(mesh, face));
        Ok((face, weights.unwrap_or_default()))
    }

    /// Returns the N-th power of the field at a point of a face, in the frame whose first axis runs
    /// along the face's first side. Its length is that of the interpolation, not 1.
    pub fn power_at(&self, face: Face, weights: [f64; 3]) -> Complex {
        self.values.power_at(face, weights)
    }
}
