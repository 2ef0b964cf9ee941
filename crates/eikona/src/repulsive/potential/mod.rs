//! Penalties and potentials that are added to the tangent-point energy (RS section 7.3).
//!
//! All are integrals over the surface or its boundary: sums over vertices and faces have areas or
//! lengths as weights, so a weight means the same at every resolution. Differentials are exact
//! derivatives of the values.

mod barrier;
mod boundary;
mod far_field;
mod implicit;
mod obstacle;
mod sampled_distance;
mod start;
mod surface;
mod totals;
mod willmore;

pub(super) use barrier::Barriers;
pub use implicit::ImplicitSurface;
pub use obstacle::Obstacle;
pub use sampled_distance::SampledDistance;
pub use start::StartPositions;

use crate::repulsive::error::RepulsiveError;
use crate::repulsive::options::Exponents;
use crate::repulsive::quantity::Quantity;
use crate::setters::setters;
use eikona_mesh::{FaceField, TriangleMesh, VertexField};
use implicit::Action;
use surface::Vec3;
use totals::Deviation;

/// A term that is added to the tangent-point energy: a weight times a [`PotentialKind`].
///
/// ```
/// use eikona::mesh::shapes;
/// use eikona::repulsive::Potential;
/// let square = shapes::grid(4, 4, 2.0, 1.0, shapes::Diagonal::Uniform)?;
/// assert!((Potential::area(3.0).value(&square)? - 6.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Potential {
    /// The factor. A negative weight reverses the potential.
    pub weight: f64,
    /// What is weighted.
    pub kind: PotentialKind,
    /// Number of threads for obstacles. Default: 1. The result is the same for any number.
    pub threads: usize,
}

/// What a [`Potential`] measures. The values given here do not include the weight.
///
/// ```
/// use eikona::mesh::shapes;
/// use eikona::repulsive::{Potential, PotentialKind};
/// // Grow a cube of area 6 to area 12.
/// let grow = Potential::new(8.0, PotentialKind::AreaDeviation { from: 12.0 });
/// assert!((grow.value(&shapes::cuboid([1.0; 3], [2; 3])?)? - 2.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PotentialKind {
    /// The area A.
    Area,
    /// The signed volume V: positive for a closed surface that is oriented outwards. For a surface
    /// with boundary, that of the cone over it from the origin.
    Volume,
    /// `(A / A0 - 1)^2`.
    AreaDeviation {
        /// The area A0, positive.
        from: f64,
    },
    /// `((V - V0) / scale)^2`: with `scale = |V0|`, this is `(V / V0 - 1)^2`.
    VolumeDeviation {
        /// The volume V0.
        from: f64,
        /// What deviations are measured by, positive.
        scale: f64,
    },
    /// The integral over the surface of the potential of an obstacle.
    Obstacle(Obstacle),
    /// The integral over the surface of a power of the distance d from another surface: of
    /// `|d|^-power`, which repels from it on both sides, or of `|d|^power`, which attracts to it.
    Implicit {
        /// The other surface.
        surface: ImplicitSurface,
        /// Whether it attracts.
        attract: bool,
        /// The power: positive, and at least 1 if it attracts. With 1, the force jumps at the
        /// surface.
        power: f64,
    },
    /// `(L - target)^2` of the length L of the boundary.
    BoundaryLength {
        /// The length aimed at.
        target: f64,
    },
    /// The sum over boundary vertices of `theta^2 / l`, where theta is the angle by which the
    /// boundary turns and `l` half the length of the two boundary edges: the integral of the
    /// squared curvature of the boundary.
    BoundaryCurvature,
    /// The Willmore energy: the integral of `(2 H)^2`, where `2 H` is the sum of the principal
    /// curvatures. On a sphere, 16 pi. Boundary vertices are left out.
    Willmore,
    /// The integral over the surface at the start of the squared distance that its points moved.
    StartDistance(StartPositions),
    /// The sum over faces of `(a - a0)^2 / a0`.
    FaceArea {
        /// The area a0 of each face, positive.
        areas: FaceField<f64>,
    },
}

setters!(Potential { with_weight: weight = f64, with_threads: threads = usize });

impl Potential {
    /// Weights a kind. Numbers are checked when the potential is evaluated.
    ///
    /// ```
    /// use eikona::repulsive::{Potential, PotentialKind};
    /// assert_eq!(Potential::new(2.0, PotentialKind::Willmore), Potential::willmore(2.0));
    /// ```
    pub fn new(weight: f64, kind: PotentialKind) -> Potential {
        Potential { weight, kind, threads: 1 }
    }

    /// Returns `weight A` for the area A.
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let value = Potential::area(1.0).value(&shapes::cuboid([1.0; 3], [2; 3])?)?;
    /// assert!((value - 6.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn area(weight: f64) -> Potential {
        Potential::new(weight, PotentialKind::Area)
    }

    /// Returns `weight V` for the signed volume V.
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let value = Potential::volume(-1.0).value(&shapes::cuboid([1.0, 2.0, 3.0], [2; 3])?)?;
    /// assert!((value + 6.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn volume(weight: f64) -> Potential {
        Potential::new(weight, PotentialKind::Volume)
    }

    /// Returns `weight (A / A0 - 1)^2`, where A0 is the area of a mesh, usually that at the start.
    ///
    /// # Errors
    /// [`RepulsiveError::FlatFace`].
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let cube = |size: f64| shapes::cuboid([size; 3], [2; 3]);
    /// let from = Potential::area_deviation(5.0, &cube(1.0)?)?;
    /// assert!((from.value(&cube(2.0)?)? - 45.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn area_deviation(weight: f64, mesh: &TriangleMesh) -> Result<Potential, RepulsiveError> {
        Ok(Potential::new(
            weight,
            PotentialKind::AreaDeviation { from: totals::total(Quantity::Area, mesh)? },
        ))
    }

    /// Returns `weight (V / V0 - 1)^2`, where V0 is the signed volume of a mesh, usually that at
    /// the start. If V0 is below 1e-9 of `A0^(3/2)` with the area A0, it is zero up to rounding,
    /// and the value is `weight ((V - V0) / A0^(3/2))^2`.
    ///
    /// # Errors
    /// [`RepulsiveError::FlatFace`], [`RepulsiveError::Inconsistent`].
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let from = Potential::volume_deviation(5.0, &shapes::cuboid([1.0; 3], [2; 3])?)?;
    /// assert!((from.value(&shapes::cuboid([1.0, 1.0, 3.0], [2; 3])?)? - 20.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn volume_deviation(weight: f64, mesh: &TriangleMesh) -> Result<Potential, RepulsiveError> {
        let from = totals::total(Quantity::Volume, mesh)?;
        let scale = totals::volume_scale(from, totals::total(Quantity::Area, mesh)?);
        Ok(Potential::new(weight, PotentialKind::VolumeDeviation { from, scale }))
    }

    /// Returns the repulsion of a fixed mesh, see [`Obstacle::of_mesh`].
    ///
    /// # Errors
    /// Those of [`Obstacle::of_mesh`].
    ///
    /// ```
    /// use eikona::{mesh::TriangleMesh, repulsive::Potential};
    /// let side = 1e-3;
    /// let corners = |z: f64| vec![[0., 0., z], [side, 0., z], [0., side, z]];
    /// let at = |z: f64| TriangleMesh::new(corners(z), vec![[0, 1, 2]]);
    /// // Two small triangles at distance 2, p = 3.
    /// let value = Potential::obstacle(1.0, &at(2.0)?, 3.0)?.value(&at(0.0)?)?;
    /// assert!((value / (0.25e-12 / 8.0) - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn obstacle(weight: f64, mesh: &TriangleMesh, exponent: f64) -> Result<Potential, RepulsiveError> {
        Ok(Potential::new(weight, PotentialKind::Obstacle(Obstacle::of_mesh(mesh, exponent)?)))
    }

    /// Returns the repulsion of fixed points, see [`Obstacle::of_points`].
    ///
    /// # Errors
    /// Those of [`Obstacle::of_points`].
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let square = shapes::grid(2, 2, 1e-3, 1e-3, shapes::Diagonal::Uniform)?;
    /// // Points at distances 1 and 2 of a small square, p = 1.
    /// let potential = Potential::point_obstacle(1.0, &[[0., 0., 1.], [0., 0., 2.]], 1.0)?;
    /// assert!((potential.value(&square)? / 0.75e-6 - 1.0).abs() < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn point_obstacle(
        weight: f64,
        points: &[[f64; 3]],
        exponent: f64,
    ) -> Result<Potential, RepulsiveError> {
        Ok(Potential::new(weight, PotentialKind::Obstacle(Obstacle::of_points(points, exponent)?)))
    }

    /// Returns `weight` times the integral of `|d|^-power`, where d is the distance from an
    /// implicit surface.
    ///
    /// Deviation: the published program sums over vertices without areas, and odd powers of
    /// negative distances have negative energies there.
    ///
    /// ```
    /// use eikona::mesh::shapes;
    /// use eikona::repulsive::{ImplicitSurface, Potential};
    /// let floor = ImplicitSurface::Plane { point: [0.0, 0.0, -2.0], normal: [0.0, 0.0, 1.0] };
    /// let square = shapes::grid(3, 3, 1.0, 1.0, shapes::Diagonal::Uniform)?;
    /// let value = Potential::repel_from(1.0, floor, 3.0).value(&square)?;
    /// assert!((value - 0.125).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn repel_from(weight: f64, surface: ImplicitSurface, power: f64) -> Potential {
        Potential::new(weight, PotentialKind::Implicit { surface, attract: false, power })
    }

    /// Returns `weight` times the integral of `|d|^power`, where d is the distance from an implicit
    /// surface.
    ///
    /// ```
    /// use eikona::mesh::shapes;
    /// use eikona::repulsive::{ImplicitSurface, Potential};
    /// let floor = ImplicitSurface::Plane { point: [0.0, 0.0, -2.0], normal: [0.0, 0.0, 1.0] };
    /// let square = shapes::grid(3, 3, 1.0, 1.0, shapes::Diagonal::Uniform)?;
    /// let value = Potential::attract_to(1.0, floor, 3.0).value(&square)?;
    /// assert!((value - 8.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn attract_to(weight: f64, surface: ImplicitSurface, power: f64) -> Potential {
        Potential::new(weight, PotentialKind::Implicit { surface, attract: true, power })
    }

    /// Returns `weight (L - target)^2` for the length L of the boundary.
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let square = shapes::grid(3, 3, 1.0, 1.0, shapes::Diagonal::Uniform)?;
    /// let value = Potential::boundary_length(2.0, 5.0).value(&square)?;
    /// assert!((value - 2.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn boundary_length(weight: f64, target: f64) -> Potential {
        Potential::new(weight, PotentialKind::BoundaryLength { target })
    }

    /// Returns `weight` times the integral of the squared curvature of the boundary, see
    /// [`PotentialKind::BoundaryCurvature`].
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// // A circle of radius 2 has curvature 1/2 on a length of 4 pi.
    /// let value = Potential::boundary_curvature(1.0).value(&shapes::disk(10, 12, 2.0)?)?;
    /// assert!((value - std::f64::consts::PI).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn boundary_curvature(weight: f64) -> Potential {
        Potential::new(weight, PotentialKind::BoundaryCurvature)
    }

    /// Returns `weight f^T A M^-1 A f` with the cotan Laplacian A and the lumped mass matrix M, see
    /// [`PotentialKind::Willmore`]. The published program has a quarter of it, the integral of
    /// `H^2` with the mean of the principal curvatures.
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let value = Potential::willmore(1.0).value(&shapes::icosphere(4)?)?;
    /// assert!((value / (16.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn willmore(weight: f64) -> Potential {
        Potential::new(weight, PotentialKind::Willmore)
    }

    /// Returns `weight` times the integral over a mesh, usually that at the start, of the squared
    /// distance that its points moved.
    ///
    /// # Errors
    /// [`RepulsiveError::FlatFace`].
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let square = shapes::grid(3, 3, 1.0, 1.0, shapes::Diagonal::Uniform)?;
    /// let moved = square.positions().iter().map(|p| [p[0] + 3.0, p[1], p[2]]).collect();
    /// let value = Potential::start_distance(1.0, &square)?.value(&square.with_positions(moved)?)?;
    /// assert!((value - 9.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn start_distance(weight: f64, mesh: &TriangleMesh) -> Result<Potential, RepulsiveError> {
        Ok(Potential::new(weight, PotentialKind::StartDistance(StartPositions::of(mesh)?)))
    }

    /// Returns `weight` times the sum over faces of `(a - a0)^2 / a0`, where a0 are the face areas
    /// of a mesh, usually those at the start.
    ///
    /// # Errors
    /// [`RepulsiveError::FlatFace`].
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let cube = |size: f64| shapes::cuboid([size; 3], [2; 3]);
    /// let from = Potential::face_area(5.0, &cube(1.0)?)?;
    /// // 6 units of area, each of which grows by 3.
    /// assert!((from.value(&cube(2.0)?)? - 270.0).abs() < 1e-10);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn face_area(weight: f64, mesh: &TriangleMesh) -> Result<Potential, RepulsiveError> {
        Ok(Potential::new(weight, PotentialKind::FaceArea { areas: start::areas_of(mesh)? }))
    }

    /// Returns whether it holds a value per vertex or face of the mesh, which has to be transferred
    /// when the mesh is changed.
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let square = shapes::grid(3, 3, 1.0, 1.0, shapes::Diagonal::Uniform)?;
    /// assert!(Potential::face_area(1.0, &square)?.follows_mesh());
    /// assert!(!Potential::area_deviation(1.0, &square)?.follows_mesh());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn follows_mesh(&self) -> bool {
        matches!(self.kind, PotentialKind::StartDistance(_) | PotentialKind::FaceArea { .. })
    }

    /// Returns the potential for another mesh of the surface at the start: values per vertex or
    /// face are taken from it. Others stay as they are.
    ///
    /// # Errors
    /// [`RepulsiveError::FlatFace`].
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let square = |n| shapes::grid(n, n, 1.0, 1.0, shapes::Diagonal::Uniform);
    /// let (coarse, fine) = (square(3)?, square(6)?);
    /// let potential = Potential::start_distance(1.0, &coarse)?.on(&fine)?;
    /// assert_eq!(potential.value(&fine)?, 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn on(&self, start: &TriangleMesh) -> Result<Potential, RepulsiveError> {
        let kind = match &self.kind {
            PotentialKind::StartDistance(_) => PotentialKind::StartDistance(StartPositions::of(start)?),
            PotentialKind::FaceArea { .. } => PotentialKind::FaceArea { areas: start::areas_of(start)? },
            other => other.clone(),
        };
        Ok(Potential { kind, ..*self })
    }

    /// Computes the potential of a surface.
    ///
    /// # Errors
    /// [`RepulsiveError::NoFaces`], [`RepulsiveError::Weight`], [`RepulsiveError::PotentialRange`].
    /// [`RepulsiveError::FlatFace`] where areas matter, [`RepulsiveError::Inconsistent`] for
    /// volumes, [`RepulsiveError::NonmanifoldVertex`] for the curvature of the boundary.
    /// [`RepulsiveError::FaceOnObstacle`], [`RepulsiveError::PotentialExponent`],
    /// [`RepulsiveError::ImplicitShape`] for what repels or
    /// attracts. [`RepulsiveError::Target`], [`RepulsiveError::TargetArea`],
    /// [`RepulsiveError::WrongCount`] for values aimed at. [`RepulsiveError::Numeric`] if an
    /// observer stops it.
    ///
    /// # Cost
    /// O(F), less than 0.1 us per face; for obstacles O(F log O), see [`Obstacle`].
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::{Potential, RepulsiveError}};
    /// let sphere = shapes::icosphere(2)?;
    /// assert!(Potential::volume(1.0).value(&sphere)? < 4.0 / 3.0 * std::f64::consts::PI);
    /// let fault = Potential::volume(f64::INFINITY).value(&sphere).unwrap_err();
    /// assert!(matches!(fault, RepulsiveError::Weight { .. }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn value(&self, mesh: &TriangleMesh) -> Result<f64, RepulsiveError> {
        self.check(mesh)?;
        let value = self.weight * self.kind.value(mesh, self.threads)?;
        if value.is_finite() { Ok(value) } else { Err(self.out_of_range()) }
    }

    /// Computes the derivative of [`value`](Self::value) by each vertex. Exact; zero at vertices
    /// without faces.
    ///
    /// # Errors
    /// As for [`value`](Self::value).
    ///
    /// # Cost
    /// About that of [`value`](Self::value).
    ///
    /// ```
    /// use eikona::{mesh::shapes, repulsive::Potential};
    /// let sphere = shapes::icosphere(2)?;
    /// // By Euler: a volume is homogeneous of degree 3.
    /// let volume = Potential::volume(1.0);
    /// let differential = volume.differential(&sphere)?;
    /// let product = |v, k| differential[v][k] * sphere.position(v)[k];
    /// let sum: f64 = sphere.vertices().flat_map(|v| [0, 1, 2].map(|k| product(v, k))).sum();
    /// assert!((sum - 3.0 * volume.value(&sphere)?).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn differential(&self, mesh: &TriangleMesh) -> Result<VertexField<[f64; 3]>, RepulsiveError> {
        self.check(mesh)?;
        let of_kind = self.kind.differential(mesh, self.threads)?;
        let result: Vec<Vec3> = of_kind.into_iter().map(|v| v.map(|x| self.weight * x)).collect();
        let finite = result.iter().flatten().all(|x| x.is_finite());
        if finite { Ok(result.into()) } else { Err(self.out_of_range()) }
    }

    /// Returns what an obstacle adds to the inner product: for each face S, the sum over the faces
    /// T of the obstacle of `a_T / |X_S - X_T|^(2 s)`, where s is the order of the exponents. This
    /// is the kernel of high order, `|v|^-(2 sigma + 2)` with `sigma = s - 1`. It does not depend
    /// on the weight. `None` unless the kind is an obstacle made from a mesh.
    ///
    /// The published program adds it, divided by the areas `a_S`, to the diagonal `(H a) / a` of
    /// the term of high order, and likewise for the other two terms: a joint inner product of both
    /// surfaces, in which the obstacle does not move. Its obstacles have the tangent-point kernel
    /// instead of the one here, so whether to add the sums is the caller's choice.
    ///
    /// # Errors
    /// [`RepulsiveError::NoFaces`], [`RepulsiveError::FlatFace`],
    /// [`RepulsiveError::FaceOnObstacle`], [`RepulsiveError::Exponents`],
    /// [`RepulsiveError::Numeric`].
    ///
    /// ```
    /// use eikona::mesh::{Face, shapes};
    /// use eikona::repulsive::{Exponents, Potential};
    /// let sphere = shapes::icosphere(3)?;
    /// let far = sphere.positions().iter().map(|p| p.map(|x| 1e3 * x)).collect();
    /// let room = Potential::obstacle(1.0, &sphere.with_positions(far)?, 6.0)?;
    /// let sums = room.metric_diagonal(&sphere, Exponents::default())?.unwrap();
    /// // All of its area is at distance 1000, and 2 s = 10 / 3.
    /// assert!((sums[Face(0)] / (4e6 * std::f64::consts::PI * 1e-10) - 1.0).abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn metric_diagonal(
        &self,
        mesh: &TriangleMesh,
        exponents: Exponents,
    ) -> Result<Option<FaceField<f64>>, RepulsiveError> {
        self.check(mesh)?;
        let exponents = Exponents::new(exponents.alpha, exponents.beta)?;
        match &self.kind {
            PotentialKind::Obstacle(obstacle) => {
                obstacle.row_sums(mesh, 2.0 * exponents.order(), self.threads)
            }
            _ => Ok(None),
        }
    }

    /// Returns how stiff the potential is at each vertex: its second derivative in the stiffest
    /// direction, where that is simple and positive, that is for obstacles, attractors and the
    /// distance from the start. Zero elsewhere.
    ///
    /// The flow adds it to the inner product, times the length of a step, so that steps need not be
    /// as short as stiff terms would have them.
    ///
    /// # Errors
    /// As for [`value`](Self::value).
    ///
    /// # Cost
    /// About that of [`value`](Self::value).
    ///
    /// ```
    /// use eikona::mesh::{Vertex, shapes};
    /// use eikona::repulsive::{ImplicitSurface, Potential};
    /// // d^2 has the second derivative 2, and a vertex of a tetrahedron a quarter of its area.
    /// let tetrahedron = shapes::tetrahedron()?;
    /// let plane = ImplicitSurface::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    /// let area = Potential::area(1.0).value(&tetrahedron)?;
    /// let stiffness = Potential::attract_to(3.0, plane, 2.0).stiffness(&tetrahedron)?;
    /// assert!((stiffness[Vertex(0)] - 3.0 * 2.0 * area / 4.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn stiffness(&self, mesh: &TriangleMesh) -> Result<VertexField<f64>, RepulsiveError> {
        self.check(mesh)?;
        let mut sums = vec![0.0; mesh.vertex_count()];
        match &self.kind {
            PotentialKind::Obstacle(obstacle) => obstacle.add_stiffness(mesh, self.threads, &mut sums)?,
            PotentialKind::Implicit { surface, attract, power } => {
                let action = Action { attract: *attract, power: *power };
                implicit::add_stiffness(mesh, surface, action, &mut sums)?;
            }
            PotentialKind::StartDistance(start) => {
                sums.iter_mut().zip(start.areas.as_slice()).for_each(|(sum, area)| *sum += 2.0 * area);
            }
            _ => {}
        }
        Ok(sums.into_iter().map(|sum| (self.weight * sum).max(0.0)).collect::<Vec<_>>().into())
    }

    /// The factor of the bi-Laplacian in the second derivative: that of the Willmore energy where
    /// the Laplacian does not change. Zero for all others.
    pub(super) fn bending(&self) -> f64 {
        match self.kind {
            PotentialKind::Willmore => (2.0 * self.weight).max(0.0),
            _ => 0.0,
        }
    }

    /// The implicit surface that repels; `None` for all others.
    fn barrier(&self) -> Option<&ImplicitSurface> {
        match &self.kind {
            PotentialKind::Implicit { surface, attract: false, .. } if self.weight > 0.0 => Some(surface),
            _ => None,
        }
    }

    fn check(&self, mesh: &TriangleMesh) -> Result<(), RepulsiveError> {
        if !self.weight.is_finite() {
            return Err(RepulsiveError::Weight { weight: self.weight });
        }
        if mesh.face_count() == 0 { Err(RepulsiveError::NoFaces) } else { Ok(()) }
    }

    fn out_of_range(&self) -> RepulsiveError {
        RepulsiveError::PotentialRange { potential: self.kind.name() }
    }
}

impl PotentialKind {
    fn name(&self) -> &'static str {
        match self {
            PotentialKind::Area => "the area",
            PotentialKind::Volume => "the volume",
            PotentialKind::AreaDeviation { .. } => "the deviation of the area",
            PotentialKind::VolumeDeviation { .. } => "the deviation of the volume",
            PotentialKind::Obstacle(_) => "the potential of an obstacle",
            PotentialKind::Implicit { attract: false, .. } => "the potential of an implicit obstacle",
            PotentialKind::Implicit { attract: true, .. } => "the potential of an attractor",
            PotentialKind::BoundaryLength { .. } => "the deviation of the boundary length",
            PotentialKind::BoundaryCurvature => "the curvature of the boundary",
            PotentialKind::Willmore => "the Willmore energy",
            PotentialKind::StartDistance(_) => "the distance from the start",
            PotentialKind::FaceArea { .. } => "the deviation of face areas",
        }
    }

    fn value(&self, mesh: &TriangleMesh, threads: usize) -> Result<f64, RepulsiveError> {
        match self {
            PotentialKind::Area => totals::total(Quantity::Area, mesh),
            PotentialKind::Volume => totals::total(Quantity::Volume, mesh),
            &PotentialKind::AreaDeviation { from } => {
                let deviation = area_deviation(from)?;
                Ok(deviation.value(totals::total(Quantity::Area, mesh)?))
            }
            &PotentialKind::VolumeDeviation { from, scale } => {
                let deviation = volume_deviation(from, scale)?;
                Ok(deviation.value(totals::total(Quantity::Volume, mesh)?))
            }
            PotentialKind::Obstacle(obstacle) => obstacle.value(mesh, threads),
            PotentialKind::Implicit { surface, attract, power } => {
                implicit::value(mesh, surface, Action { attract: *attract, power: *power })
            }
            &PotentialKind::BoundaryLength { target } => {
                check_target(target)?;
                Ok((boundary::length(mesh) - target).powi(2))
            }
            PotentialKind::BoundaryCurvature => boundary::curvature(mesh),
            PotentialKind::Willmore => willmore::value(mesh),
            PotentialKind::StartDistance(start) => start.value(mesh),
            PotentialKind::FaceArea { areas } => start::area_value(mesh, areas),
        }
    }

    fn differential(&self, mesh: &TriangleMesh, threads: usize) -> Result<Vec<Vec3>, RepulsiveError> {
        match self {
            PotentialKind::Area => totals::differential(Quantity::Area, mesh),
            PotentialKind::Volume => totals::differential(Quantity::Volume, mesh),
            &PotentialKind::AreaDeviation { from } => {
                let deviation = area_deviation(from)?;
                Ok(deviation.differential(
                    totals::total(Quantity::Area, mesh)?,
                    totals::differential(Quantity::Area, mesh)?,
                ))
            }
            &PotentialKind::VolumeDeviation { from, scale } => {
                let deviation = volume_deviation(from, scale)?;
                Ok(deviation.differential(
                    totals::total(Quantity::Volume, mesh)?,
                    totals::differential(Quantity::Volume, mesh)?,
                ))
            }
            PotentialKind::Obstacle(obstacle) => obstacle.differential(mesh, threads),
            PotentialKind::Implicit { surface, attract, power } => {
                implicit::differential(mesh, surface, Action { attract: *attract, power: *power })
            }
            &PotentialKind::BoundaryLength { target } => {
                check_target(target)?;
                boundary::length_deviation_differential(mesh, target)
            }
            PotentialKind::BoundaryCurvature => boundary::curvature_differential(mesh),
            PotentialKind::Willmore => willmore::differential(mesh),
            PotentialKind::StartDistance(start) => start.differential(mesh),
            PotentialKind::FaceArea { areas } => start::area_differential(mesh, areas),
        }
    }
}

fn area_deviation(from: f64) -> Result<Deviation, RepulsiveError> {
    let deviation = Deviation { from, scale: from };
    deviation.check("the area aimed at").map(|()| deviation)
}

fn volume_deviation(from: f64, scale: f64) -> Result<Deviation, RepulsiveError> {
    let deviation = Deviation { from, scale };
    deviation.check("the volume aimed at, or its scale,").map(|()| deviation)
}

fn check_target(value: f64) -> Result<(), RepulsiveError> {
    let what = "the boundary length aimed at";
    if value.is_finite() { Ok(()) } else { Err(RepulsiveError::Target { what, value }) }
}
