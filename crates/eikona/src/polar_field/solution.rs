//! Result of a solve: the field, evaluated anywhere, and its report.

use crate::Warning;
use crate::geometry::vector::{add, scale};
use crate::phases::Phases;
use crate::polar_field::alignment::Followed;
use crate::polar_field::bevel::wrapped;
use crate::polar_field::domain::Domain;
use crate::polar_field::field::{Values, polar};
use crate::polar_field::inspection::Match;
use crate::polar_field::singularity::Prescribed;
use eikona_mesh::{CurveError, Face, Halfedge, Located, SurfacePoint, TriangleMesh};
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
    /// Warnings of the preparation.
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
        let mesh = self.mesh();
        let (face, weights) = match point.locate(mesh)? {
            Located::Face(f, weights) => (f, weights),
            Located::Edge(e, t) => {
                let h = mesh.edge_halfedges(e)[0];
                let t = if mesh.follows_edge(h) { t } else { 1.0 - t };
                let mut weights = [0.0; 3];
                weights[h.side()] = 1.0 - t;
                weights[(h.side() + 1) % 3] = t;
                (h.face(), weights)
            }
            Located::Vertex(v) => match mesh.vertex_corners(v).first() {
                Some(corner) => {
                    let mut weights = [0.0; 3];
                    weights[corner.halfedge().side()] = 1.0;
                    (corner.face(), weights)
                }
                None => return Ok(vec![[0.0; 3]; self.degree as usize]),
            },
        };
        let power = self.power_at(face, weights);
        if power.norm() == 0.0 {
            return Ok(vec![[0.0; 3]; self.degree as usize]);
        }
        let first = power.arg() / f64::from(self.degree);
        let [along, across, _] = self.domain.bevel.frame(face);
        let vector = |k: u32| {
            let z = polar(1.0, first + TAU * f64::from(k) / f64::from(self.degree));
            add(scale(along, z.re), scale(across, z.im))
        };
        Ok((0..self.degree).map(vector).collect())
    }

    /// Returns how the vectors at the centroids of neighbouring faces continue each other, for each
    /// edge of two faces, in the order of [`vectors_at`](Self::vectors_at). Shifts are from 0 to N
    /// - 1.
    ///
    /// The field is followed from centroid to centroid through the middle of the edge, with the
    /// rotations that were solved for, so they are counted right however large they are.
    pub fn matching(&self) -> Vec<Match> {
        let Domain { bevel, connection, .. } = &*self.domain;
        let n = f64::from(self.degree);
        let mut matching = Vec::new();
        for (h, twin) in bevel.edges() {
            let middle = |h: Halfedge| {
                let mut weights = [0.5; 3];
                weights[(h.side() + 2) % 3] = 0.0;
                weights
            };
            let third = [1.0 / 3.0; 3];
            let centroid = |h: Halfedge| self.power_at(h.face(), third);
            // Turns of the power: inside the first face, across the edge, inside the second face.
            let own = -self.values.turn_between(h.face(), middle(h), third);
            let other = self.values.turn_between(twin.face(), middle(twin), third);
            let [p, q] = [h, twin].map(|h| self.power_at(h.face(), middle(h)).arg());
            let across = wrapped(q - p + n * connection.jump[h]);
            let solved = 0.5 * (self.values.jump[twin] - self.values.jump[h]);
            let across = across + TAU * ((solved - across) / TAU).round();
            let arrived = centroid(h).arg() + own + across + other - n * connection.jump[h];
            let shift = ((arrived - centroid(twin).arg()) / TAU).round() as i64;
            matching.push(Match {
                faces: [h.face(), twin.face()],
                vertices: Some([bevel.mesh.origin(h), bevel.mesh.tip(h)]),
                shift: shift.rem_euclid(i64::from(self.degree)),
            });
        }
        matching
    }

    /// Returns the N-th power of the field at a point of a face, in the frame whose first axis runs
    /// along the face's first side. Its length is that of the interpolation, not 1.
    pub fn power_at(&self, face: Face, weights: [f64; 3]) -> Complex {
        self.values.power_at(face, weights)
    }
}
