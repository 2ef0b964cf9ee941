//! Implicit surfaces that repel, as barriers: which share of a motion passes none of them.
//!
//! A signed distance changes by at most 1 per length. So a piece of a moving face passes no barrier
//! in a time if the distance of its middle is larger than the piece and its way together. Pieces
//! for which that does not hold are halved, in time or in space: conservative advancement, for
//! whole faces. On one side of a plane, and inside of a sphere or cylinder, no point of a face is
//! closer than the closest corner, so that corners suffice.

use super::Potential;
use super::implicit::ImplicitSurface;
use super::surface::Vec3;
use crate::geometry::vector::{add, norm, scale, sub};
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{Face, TriangleMesh};
use eikona_numeric::{NumericError, check_stopped};

/// A face keeps this share of its distance from a barrier at the start, of which at least half is
/// known.
const KEPT: f64 = 0.1;
/// Pieces are not divided below this share of the distance at the start.
const SMALLEST: f64 = 0.3;
/// Pieces of faces are halved so often when the distance of the face is computed. What is closer
/// than about a thousandth of its size touches.
const HALVINGS: u32 = 10;
/// Observers are asked once per so many faces.
const FACES_PER_CHECK: usize = 4096;

/// The implicit surfaces that repel.
#[derive(Debug)]
pub(in crate::repulsive) struct Barriers(Vec<Barrier>);

#[derive(Debug)]
struct Barrier {
    /// With directions of unit length.
    surface: ImplicitSurface,
    /// How much the distance changes per length, at most.
    steepest: f64,
}

/// A triangle whose corners move along straight lines, from time 0 to 1.
#[derive(Clone, Copy)]
struct Moving {
    corners: [Vec3; 3],
    ways: [Vec3; 3],
}

/// A face of a mesh, or one that is only its corner.
fn pieces(corners: [Vec3; 3], ways: [Vec3; 3], corners_suffice: bool) -> Vec<Moving> {
    match corners_suffice {
        true => (0..3).map(|k| Moving { corners: [corners[k]; 3], ways: [ways[k]; 3] }).collect(),
        false => vec![Moving { corners, ways }],
    }
}

impl Barriers {
    /// # Errors
    /// [`RepulsiveError::ImplicitShape`].
    pub fn of(potentials: &[Potential]) -> Result<Barriers, RepulsiveError> {
        let barrier = |surface: &ImplicitSurface| {
            let surface = surface.checked()?;
            let steepest = match &surface {
                ImplicitSurface::Grid(samples) => samples.steepest(),
                _ => 1.0,
            };
            Ok(Barrier { surface, steepest })
        };
        potentials.iter().filter_map(Potential::barrier).map(barrier).collect::<Result<_, _>>().map(Barriers)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Refuses a surface that passes through a barrier.
    ///
    /// # Errors
    /// [`RepulsiveError::EdgeThroughBarrier`], [`RepulsiveError::FaceAtBarrier`].
    pub fn check(&self, mesh: &TriangleMesh) -> Result<(), RepulsiveError> {
        for barrier in &self.0 {
            for (f, face) in mesh.faces().enumerate() {
                if f % FACES_PER_CHECK == 0 {
                    check_stopped()?;
                }
                barrier.check(mesh, face)?;
            }
        }
        Ok(())
    }

    /// Whether a surface passes through no barrier.
    pub fn allow(&self, mesh: &TriangleMesh) -> Result<bool, NumericError> {
        match self.check(mesh) {
            Err(RepulsiveError::Numeric(stopped)) => Err(stopped),
            checked => Ok(checked.is_ok()),
        }
    }

    /// Returns a share of a motion in which no point of the surface passes through a barrier, nor
    /// comes closer to it than a part of the distance of its face at the start. 1 if that holds for
    /// the whole motion.
    ///
    /// # Cost
    /// One distance per face that is farther away than its size and its way. A face at distance d
    /// takes up to `(size / d)^2 way / d` evaluations.
    pub fn safe_share(&self, mesh: &TriangleMesh, ways: &[Vec3]) -> Result<f64, NumericError> {
        let mut share = 1.0f64;
        for barrier in &self.0 {
            for (f, corners) in mesh.triangles().iter().enumerate() {
                if f % FACES_PER_CHECK == 0 {
                    check_stopped()?;
                }
                let corners = corners.map(|v| v as usize);
                let positions = corners.map(|v| mesh.positions()[v]);
                let face = Moving { corners: positions, ways: corners.map(|v| ways[v]) };
                if !barrier.is_far(&face, share, 0.0) {
                    share = share.min(barrier.safe_share_of(face, share));
                }
            }
        }
        Ok(share)
    }
}

impl crate::remesh::Barrier for Barriers {
    fn gap(&self, triangle: [Vec3; 3]) -> f64 {
        self.0.iter().map(|barrier| barrier.gap_of(triangle)).fold(f64::INFINITY, f64::min)
    }

    fn clears(&self, corners: [Vec3; 3], ways: [Vec3; 3]) -> bool {
        let face = Moving { corners, ways };
        self.0
            .iter()
            .all(|barrier| barrier.is_far(&face, 1.0, 0.0) || barrier.safe_share_of(face, 1.0) == 1.0)
    }
}

impl Barrier {
    /// A bound of the distance of a point from the barrier, below it.
    fn clearance(&self, point: Vec3) -> f64 {
        let value = match &self.surface {
            ImplicitSurface::Grid(samples) => samples.in_box(point),
            surface => surface.at(point).0,
        };
        // A grid without slope has no surface.
        if value == 0.0 { 0.0 } else { value.abs() / self.steepest }
    }

    /// Whether faces on the side of a point are never closer than their corners, nor pass through
    /// the barrier between them: distances are linear, or convex and negative.
    fn corners_suffice(&self, point: Vec3) -> bool {
        match self.surface {
            ImplicitSurface::Plane { .. } => true,
            ImplicitSurface::Sphere { .. } | ImplicitSurface::Cylinder { .. } => {
                self.surface.at(point).0 < 0.0
            }
            ImplicitSurface::Torus { .. } | ImplicitSurface::Grid(_) => false,
        }
    }

    fn check(&self, mesh: &TriangleMesh, face: Face) -> Result<(), RepulsiveError> {
        let vertices = mesh.face_vertices(face);
        let corners = mesh.face_positions(face);
        let distances = corners.map(|p| self.surface.at(p).0);
        for k in 0..3 {
            let next = (k + 1) % 3;
            if (distances[k] < 0.0) != (distances[next] < 0.0) {
                return Err(RepulsiveError::EdgeThroughBarrier {
                    vertices: [vertices[k], vertices[next]],
                    distances: [distances[k], distances[next]],
                });
            }
        }
        if self.gap_of(corners) > 0.0 {
            return Ok(());
        }
        let middle = scale(add(add(corners[0], corners[1]), corners[2]), 1.0 / 3.0);
        Err(RepulsiveError::FaceAtBarrier { face, distance: self.surface.at(middle).0 })
    }

    /// A bound of the distance of a face.
    fn gap_of(&self, corners: [Vec3; 3]) -> f64 {
        let pieces = pieces(corners, [[0.0; 3]; 3], self.corners_suffice(corners[0]));
        pieces.iter().map(|piece| self.gap(piece.corners, HALVINGS)).fold(f64::INFINITY, f64::min)
    }

    /// A bound of the distance of a triangle from the barrier, at least half of it. Zero if it
    /// touches.
    fn gap(&self, corners: [Vec3; 3], halvings: u32) -> f64 {
        let (middle, radius) = ball(corners);
        let clearance = self.clearance(middle);
        if radius <= 0.5 * clearance || halvings == 0 {
            return (clearance - radius).max(0.0);
        }
        let mut gap = f64::INFINITY;
        for quarter in quarters(corners) {
            gap = gap.min(self.gap(quarter, halvings - 1));
            if gap == 0.0 {
                break;
            }
        }
        gap
    }

    /// Whether a whole motion up to a time stays farther from the barrier than a gap.
    fn is_far(&self, face: &Moving, until: f64, gap: f64) -> bool {
        let (middle, radius, way) = face.swept(0.0, until);
        self.clearance(middle) > radius + way + gap
    }

    fn safe_share_of(&self, face: Moving, until: f64) -> f64 {
        let pieces = pieces(face.corners, face.ways, self.corners_suffice(face.corners[0]));
        let share = pieces.into_iter().map(|piece| {
            let gap = self.gap(piece.corners, HALVINGS);
            self.first_unsafe(piece, [0.0, until], gap).unwrap_or(1.0)
        });
        share.fold(1.0, f64::min)
    }

    /// A time before which a piece stays farther than [`KEPT`] times a gap; `None` if it does so
    /// all along.
    fn first_unsafe(&self, piece: Moving, [from, to]: [f64; 2], gap: f64) -> Option<f64> {
        let (middle, radius, way) = piece.swept(from, to);
        if self.clearance(middle) > radius + way + KEPT * gap {
            return None;
        }
        if radius + way <= SMALLEST * gap || gap == 0.0 {
            return Some(from);
        }
        if way >= radius {
            let half = 0.5 * (from + to);
            let first = self.first_unsafe(piece, [from, half], gap);
            return first.or_else(|| self.first_unsafe(piece, [half, to], gap));
        }
        let (corners, ways) = (quarters(piece.corners), quarters(piece.ways));
        let mut first: Option<f64> = None;
        for (corners, ways) in corners.into_iter().zip(ways) {
            let until = first.unwrap_or(to);
            first = self.first_unsafe(Moving { corners, ways }, [from, until], gap).or(first);
        }
        first
    }
}

impl Moving {
    /// The middle of the triangle in the middle of a time, the radius of a ball around it, and how
    /// far corners move from there within the time.
    fn swept(&self, from: f64, to: f64) -> (Vec3, f64, f64) {
        let half = 0.5 * (from + to);
        let (middle, radius) = ball([0, 1, 2].map(|k| add(self.corners[k], scale(self.ways[k], half))));
        let fastest = self.ways.iter().map(|way| norm(*way)).fold(0.0, f64::max);
        (middle, radius, 0.5 * (to - from) * fastest)
    }
}

/// The centroid, and the distance of the farthest corner.
fn ball(corners: [Vec3; 3]) -> (Vec3, f64) {
    let middle = scale(add(add(corners[0], corners[1]), corners[2]), 1.0 / 3.0);
    (middle, corners.iter().map(|p| norm(sub(*p, middle))).fold(0.0, f64::max))
}

/// The four triangles between the corners and the midpoints of the sides.
fn quarters([a, b, c]: [Vec3; 3]) -> [[Vec3; 3]; 4] {
    let middle = |p, q| scale(add(p, q), 0.5);
    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

#[cfg(test)]
mod tests {
    use super::super::SampledDistance;
    use super::*;

    fn wave(k: usize) -> f64 {
        (12.9898 * k as f64 + 0.3).sin()
    }

    fn surfaces() -> Vec<ImplicitSurface> {
        let n = 17;
        let at = |i: usize| [i / (n * n), i / n % n, i % n].map(|k| 0.125 * k as f64 - 1.0);
        let values = (0..n * n * n).map(|i| norm(at(i)) - 0.5).collect();
        let grid = SampledDistance::new([-1.0; 3], [0.125; 3], [n; 3], values).unwrap();
        vec![
            ImplicitSurface::Plane { point: [0.0, 0.0, 0.1], normal: [0.3, 0.2, 2.0] },
            ImplicitSurface::Sphere { centre: [0.0; 3], radius: 0.3 },
            ImplicitSurface::Cylinder { point: [0.0; 3], axis: [0.0, 0.1, 1.0], radius: 0.02 },
            ImplicitSurface::torus([0.0; 3], 0.6, 0.05),
            ImplicitSurface::Grid(grid),
        ]
    }

    /// The smallest distance of a moving triangle at a time, by points on it, and whether it has
    /// points on both sides.
    fn sampled(surface: &ImplicitSurface, mesh: &TriangleMesh, ways: &[Vec3], time: f64) -> (f64, bool) {
        let p = [0, 1, 2].map(|k| add(mesh.positions()[k], scale(ways[k], time)));
        let n = 24;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut closest = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let weights = [i, j, n - i - j].map(|x| x as f64 / n as f64);
                let x = [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * p[c][k]).sum());
                let distance = surface.at(x).0;
                (low, high, closest) = (low.min(distance), high.max(distance), closest.min(distance.abs()));
            }
        }
        (closest, low < 0.0 && high > 0.0)
    }

    #[test]
    fn faces_pass_no_barrier_and_others_are_free() {
        let (mut cut, mut free) = (0, 0);
        for surface in surfaces() {
            let potential = Potential::repel_from(1.0, surface.clone(), 2.0);
            let barriers = Barriers::of(&[potential]).unwrap();
            let surface = surface.checked().unwrap();
            for trial in 0..250 {
                let number = |k: usize| wave(17 * trial + k);
                let middle = [0, 1, 2].map(|k| 0.9 * number(k));
                let corner = |c: usize| [0, 1, 2].map(|k| middle[k] + 0.3 * number(3 + 3 * c + k));
                let mesh = TriangleMesh::new((0..3).map(corner).collect(), vec![[0, 1, 2]]).unwrap();
                if barriers.check(&mesh).is_err() {
                    continue;
                }
                let way = |c: usize| [0, 1, 2].map(|k| 1.5 * number(12 + k) + 0.1 * number(15 + 3 * c + k));
                let ways: Vec<Vec3> = (0..3).map(way).collect();
                let share = barriers.safe_share(&mesh, &ways).unwrap();
                let side = surface.at(mesh.positions()[0]).0 < 0.0;
                let first = sampled(&surface, &mesh, &ways, 0.0).0;
                let mut closest = f64::INFINITY;
                for i in 0..=200 {
                    let time = i as f64 / 200.0;
                    let (distance, crosses) = sampled(&surface, &mesh, &ways, time);
                    let corner = add(mesh.positions()[0], scale(ways[0], time));
                    let left = (surface.at(corner).0 < 0.0) != side;
                    closest = if crosses || left { 0.0 } else { closest.min(distance) };
                    assert!(time > share || closest > 0.0, "{surface:?} {trial}: {share} {time}");
                }
                assert!(share > 0.0);
                if share < 1.0 {
                    cut += 1;
                    assert!(closest < 0.6 * first, "{surface:?} {trial}: {share} {closest} {first}");
                } else {
                    free += 1;
                }
            }
        }
        assert!(cut > 100 && free > 100, "{cut} {free}");
    }
}
