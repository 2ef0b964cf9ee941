//! Static obstacles (RS section 7.3.2): fixed surfaces and point clouds that repel the surface.

use super::far_field::{Kernel, Sources, Sum};
use super::surface::{FaceShape, Vec3, add_faces, face_shapes};
use crate::geometry::power_of_two_near;
use crate::geometry::vector::{add, cross, norm, scale, sub};
use crate::repulsive::error::RepulsiveError;
use crate::spatial::ClusterTree;
use eikona_mesh::{ElementId, Face, FaceField, TriangleMesh};
use eikona_numeric::{NumericError, check_stopped, for_chunks};
use std::sync::Arc;

/// Faces of an obstacle below this share of its area add nothing to a sum.
const NO_AREA: f64 = 1e-30;
/// Faces of the surface per unit of work.
const CHUNK: usize = 64;

/// A fixed surface or point cloud that repels, prepared for sums over it. Cheap to clone.
///
/// Far clusters of faces or points are summed as one, blended so that the potential has two
/// continuous derivatives: values and differentials are within 0.5 % of sums over all pairs.
/// Which clusters are far is decided for each face in each evaluation.
///
/// The potential is sampled at the centroids of faces, so it keeps surfaces apart only as long as
/// their distance is not much smaller than their edges; it is no collision detection.
///
/// ```
/// use eikona::mesh::shapes;
/// use eikona::repulsive::Obstacle;
/// let wall = Obstacle::of_mesh(&shapes::icosphere(2)?, 6.0)?;
/// assert_eq!((wall.exponent(), wall.point_count()), (6.0, 320));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Obstacle {
    sources: Arc<Sources>,
    exponent: f64,
    /// Coordinates of the sources are divided by it, since high powers of lengths would leave the
    /// range of numbers. A power of two changes no digits.
    unit: f64,
    /// Whether weights are areas, in squares of the unit.
    surface: bool,
}

/// The same points, weights and exponent.
impl PartialEq for Obstacle {
    fn eq(&self, other: &Obstacle) -> bool {
        let own = (self.exponent, self.unit, self.surface);
        own == (other.exponent, other.unit, other.surface) && self.sources.points().eq(other.sources.points())
    }
}

impl Obstacle {
    /// Prepares a surface. Each point x of the moving surface has the potential
    /// `sum over faces T of |x - X_T|^-p a_T`, with centroids `X_T` and areas `a_T`. `exponent` is
    /// p, usually that of the tangent-point energy: `beta - alpha`, 6 by default. Faces without
    /// area are ignored.
    ///
    /// Deviation: the published program sums the tangent-point kernel instead, with the normals of
    /// the moving surface, which lets that surface approach the obstacle edge-on.
    ///
    /// # Errors
    /// [`RepulsiveError::PotentialExponent`] unless the exponent is positive;
    /// [`RepulsiveError::FlatObstacle`] if no face has an area.
    ///
    /// # Cost
    /// O(O log O) for O faces: about 0.3 s per million. Sums over it take O(log O) per face of the
    /// moving surface: about 5 us per thread with 80,000 faces and p = 6.
    ///
    /// # Reference
    /// Yu, Brakensiek, Schumacher and Crane, *Repulsive Surfaces*, 2021, section 7.3.2.
    ///
    /// ```
    /// use eikona::mesh::shapes;
    /// use eikona::repulsive::{Obstacle, Potential, PotentialKind};
    /// // Spheres of radius r = 1 and R = 3 about one centre, p = 2:
    /// // 8 pi^2 r R ln((R + r) / (R - r)).
    /// let sphere = shapes::icosphere(4)?;
    /// let outer = sphere.positions().iter().map(|p| p.map(|x| 3.0 * x)).collect();
    /// let room = Obstacle::of_mesh(&sphere.with_positions(outer)?, 2.0)?;
    /// let value = Potential::new(1.0, PotentialKind::Obstacle(room)).value(&sphere)?;
    /// let exact = 24.0 * std::f64::consts::PI.powi(2) * 2.0f64.ln();
    /// assert!((value / exact - 1.0).abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_mesh(mesh: &TriangleMesh, exponent: f64) -> Result<Obstacle, RepulsiveError> {
        check_exponent(exponent)?;
        let unit = unit_of(mesh.positions());
        let source = |f: Face| {
            let [a, b, c] = mesh.face_positions(f).map(|p| p.map(|x| x / unit));
            let area = 0.5 * norm(cross(sub(b, a), sub(c, a)));
            (scale(add(add(a, b), c), 1.0 / 3.0), area)
        };
        let mut points: Vec<(Vec3, f64)> = mesh.faces().map(source).collect();
        let total: f64 = points.iter().map(|point| point.1).sum();
        points.retain(|point| point.1 > NO_AREA * total);
        if points.is_empty() {
            return Err(RepulsiveError::FlatObstacle { faces: mesh.face_count() });
        }
        Ok(Obstacle { sources: Arc::new(Sources::new(&points)), exponent, unit, surface: true })
    }

    /// Prepares a point cloud. Each point x of the moving surface has the potential `mean over
    /// points y of |x - y|^-p`. If the points sample a surface evenly, the potential times the area
    /// of that surface tends to that of [`of_mesh`](Self::of_mesh).
    ///
    /// Deviation: the published program sums over the points, so twice as many points repel
    /// twice as strongly.
    ///
    /// # Errors
    /// [`RepulsiveError::PotentialExponent`] unless the exponent is positive;
    /// [`RepulsiveError::NoObstaclePoints`]; [`RepulsiveError::ObstaclePoint`] if
    /// a coordinate is not finite.
    ///
    /// # Cost
    /// O(n log n).
    ///
    /// ```
    /// use eikona::mesh::shapes;
    /// use eikona::repulsive::{Obstacle, Potential, PotentialKind};
    /// // From the centre, all points of the unit sphere have distance 1.
    /// let centre = Obstacle::of_points(&[[0.0; 3]], 2.0)?;
    /// let potential = Potential::new(1.0, PotentialKind::Obstacle(centre));
    /// let value = potential.value(&shapes::icosphere(4)?)?;
    /// assert!((value / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_points(points: &[[f64; 3]], exponent: f64) -> Result<Obstacle, RepulsiveError> {
        check_exponent(exponent)?;
        if let Some(point) = points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(RepulsiveError::ObstaclePoint { point });
        }
        if points.is_empty() {
            return Err(RepulsiveError::NoObstaclePoints);
        }
        let unit = unit_of(points);
        let weight = 1.0 / points.len() as f64;
        let points: Vec<(Vec3, f64)> = points.iter().map(|p| (p.map(|x| x / unit), weight)).collect();
        Ok(Obstacle { sources: Arc::new(Sources::new(&points)), exponent, unit, surface: false })
    }

    /// Returns the exponent p of the distance.
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// Returns the number of points, or of faces with an area.
    pub fn point_count(&self) -> usize {
        self.sources.points().len()
    }

    /// The power of the unit in the potential of a point.
    fn degree(&self) -> f64 {
        if self.surface { 2.0 - self.exponent } else { -self.exponent }
    }

    /// Returns the integral of the potential over a surface, by the midpoint rule.
    pub(super) fn value(&self, mesh: &TriangleMesh, threads: usize) -> Result<f64, RepulsiveError> {
        let shapes = face_shapes(mesh)?;
        let sums = self.sums(&shapes, &Kernel::new(self.exponent), threads)?;
        let own = |(shape, sum): (&FaceShape, &Sum)| shape.area / self.unit / self.unit * sum.value;
        let sum: f64 = shapes.iter().zip(&sums).map(own).sum();
        Ok(sum * self.unit.powf(self.degree() + 2.0))
    }

    pub(super) fn differential(
        &self,
        mesh: &TriangleMesh,
        threads: usize,
    ) -> Result<Vec<Vec3>, RepulsiveError> {
        let shapes = face_shapes(mesh)?;
        let sums = self.sums(&shapes, &Kernel::new(self.exponent), threads)?;
        let mut result = vec![[0.0; 3]; mesh.vertex_count()];
        add_faces(mesh, &shapes, &mut result, |f, _, shape| {
            let Sum { value, gradient } = sums[f];
            // A corner moves the centroid by a third.
            let share = shape.area / self.unit / self.unit / 3.0;
            let by_area = value / self.unit;
            shape.area_gradient().map(|area| add(scale(gradient, share), scale(area, by_area)))
        });
        let factor = self.unit.powf(self.degree() + 1.0);
        result.iter_mut().for_each(|v| *v = scale(*v, factor));
        Ok(result)
    }

    /// Returns the sum over the faces T of the obstacle of `a_T / |X_S - X_T|^exponent`, for each
    /// face S; `None` for a point cloud, which has no areas.
    pub(super) fn row_sums(
        &self,
        mesh: &TriangleMesh,
        exponent: f64,
        threads: usize,
    ) -> Result<Option<FaceField<f64>>, RepulsiveError> {
        if !self.surface {
            return Ok(None);
        }
        let sums = self.sums_of_power(&face_shapes(mesh)?, exponent, threads)?;
        match sums.iter().position(|sum| !sum.is_finite()) {
            Some(f) => Err(RepulsiveError::FaceOnObstacle { face: Face::from_index(f) }),
            None => Ok(Some(sums.into())),
        }
    }

    /// Adds to each vertex its share of the second derivative of the integral, in the direction
    /// away from the obstacle: that of `r^-p` is `p (p + 1) r^-(p + 2)`.
    pub(super) fn add_stiffness(
        &self,
        mesh: &TriangleMesh,
        threads: usize,
        sums: &mut [f64],
    ) -> Result<(), RepulsiveError> {
        let shapes = face_shapes(mesh)?;
        let p = self.exponent;
        let powers = self.sums_of_power(&shapes, p + 2.0, threads)?;
        for ((corners, shape), power) in mesh.triangles().iter().zip(&shapes).zip(powers) {
            let share = shape.area / 3.0 * p * (p + 1.0) * power;
            corners.iter().for_each(|v| sums[*v as usize] += share);
        }
        Ok(())
    }

    /// The sum of another power of the distance at each face.
    fn sums_of_power(
        &self,
        shapes: &[FaceShape],
        exponent: f64,
        threads: usize,
    ) -> Result<Vec<f64>, RepulsiveError> {
        let sums = self.sums(shapes, &Kernel::new(exponent), threads)?;
        let factor = self.unit.powf(if self.surface { 2.0 - exponent } else { -exponent });
        Ok(sums.into_iter().map(|sum| factor * sum.value).collect())
    }

    /// Returns the sum at the centroid of each face, in the unit.
    fn sums(
        &self,
        shapes: &[FaceShape],
        kernel: &Kernel,
        threads: usize,
    ) -> Result<Vec<Sum>, RepulsiveError> {
        // Faces next to each other descend the tree of the obstacle together.
        let centroids: Vec<Vec3> =
            shapes.iter().map(|shape| shape.centroid().map(|x| x / self.unit)).collect();
        let tree = ClusterTree::on_threads(&centroids, threads);
        check_stopped()?;
        let ordered = tree.in_order(&centroids);
        let mut found = vec![Sum::default(); shapes.len()];
        for_chunks(threads, &mut found, CHUNK, |chunk, found| {
            check_stopped()?;
            self.sources.sums(kernel, &ordered[chunk * CHUNK..][..found.len()], found);
            Ok::<(), NumericError>(())
        })?;
        let mut sums = vec![Sum::default(); shapes.len()];
        found.into_iter().zip(tree.order()).for_each(|(sum, f)| sums[*f as usize] = sum);
        let finite = |sum: &Sum| sum.value.is_finite() && sum.gradient.iter().all(|x| x.is_finite());
        match sums.iter().position(|sum| !finite(sum)) {
            Some(f) => Err(RepulsiveError::FaceOnObstacle { face: Face::from_index(f) }),
            None => Ok(sums),
        }
    }
}

fn check_exponent(exponent: f64) -> Result<(), RepulsiveError> {
    let fine = exponent > 0.0 && exponent.is_finite();
    if fine { Ok(()) } else { Err(RepulsiveError::PotentialExponent { exponent, least: 0.0 }) }
}

fn unit_of(points: &[Vec3]) -> f64 {
    power_of_two_near(points.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs())))
}
