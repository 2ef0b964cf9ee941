//! Keeps operations from letting the surface touch or pass through itself: a grid of its faces,
//! and exact tests of the faces that an operation replaces.

use super::changing::{Changing, Vec3};
use crate::spatial::{is_in_tetrahedron, triangles_intersect};
use eikona_mesh::TriangleMesh;

/// A grid whose cells list the faces that meet them. Faces are only ever added: what a face was
/// before costs a test, and no more.
pub(super) struct Guard {
    cell: f64,
    /// Faces by the hash of the cell; a power of two of them.
    buckets: Vec<Vec<u32>>,
    /// Faces that meet too many cells: they are candidates everywhere.
    large: Vec<u32>,
    /// The faces of the obstacle, numbered from [`OBSTACLE`].
    obstacle: Vec<[Vec3; 3]>,
}

/// A face much larger than the others would fill the grid alone.
const MOST_CELLS: f64 = 512.0;

/// Meshes have fewer faces than that.
const OBSTACLE: u32 = 1 << 31;

/// What an operation does to the surface.
#[derive(Default)]
pub(super) struct Replacement {
    /// The faces that go.
    pub removed: Vec<u32>,
    /// The triangles that take their place.
    pub added: Vec<[Vec3; 3]>,
    /// Tetrahedra that cover what lies between both.
    pub between: Vec<[Vec3; 4]>,
}

impl Replacement {
    pub fn clear(&mut self) {
        self.removed.clear();
        self.added.clear();
        self.between.clear();
    }
}

impl Guard {
    pub fn new(mesh: &Changing, obstacle: Option<&TriangleMesh>) -> Guard {
        let alive = || (0..mesh.faces.len() as u32).filter(|f| mesh.is_alive(*f));
        let widths = alive().map(|f| {
            let (low, high) = bounds(&mesh.triangle(f));
            (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)
        });
        let cell = widths.sum::<f64>() / alive().count().max(1) as f64;
        let buckets = vec![Vec::new(); (2 * mesh.faces.len()).next_power_of_two()];
        let obstacle = obstacle.map_or(Vec::new(), |o| o.faces().map(|f| o.face_positions(f)).collect());
        let cell = cell.max(f64::MIN_POSITIVE);
        let mut guard = Guard { cell, buckets, large: Vec::new(), obstacle: Vec::new() };
        alive().for_each(|f| guard.insert(f, &mesh.triangle(f)));
        obstacle.iter().zip(OBSTACLE..).for_each(|(triangle, f)| guard.insert(f, triangle));
        Guard { obstacle, ..guard }
    }

    /// A face of the mesh or of the obstacle; `None` if it is gone.
    fn triangle(&self, mesh: &Changing, face: u32) -> Option<[Vec3; 3]> {
        match face.checked_sub(OBSTACLE) {
            Some(of_obstacle) => Some(self.obstacle[of_obstacle as usize]),
            None => mesh.is_alive(face).then(|| mesh.triangle(face)),
        }
    }

    /// Notes where a face is now.
    pub fn insert(&mut self, face: u32, triangle: &[Vec3; 3]) {
        let place = bounds(triangle);
        if self.fills_grid(place) {
            self.large.push(face);
            return;
        }
        for bucket in self.cells(place) {
            let list = &mut self.buckets[bucket];
            if list.last() != Some(&face) {
                list.push(face);
            }
        }
    }

    /// Whether a box meets too many cells.
    fn fills_grid(&self, (low, high): Bounds) -> bool {
        let cells: f64 = (0..3).map(|k| (high[k] - low[k]) / self.cell + 1.0).product();
        cells > MOST_CELLS || cells.is_nan()
    }

    /// The faces that may meet a box, some of them several times.
    fn candidates(&self, place: Bounds) -> impl Iterator<Item = u32> {
        let fills = self.fills_grid(place);
        let all = fills.then(|| self.buckets.iter()).into_iter().flatten();
        let near = (!fills).then(|| self.cells(place).map(|bucket| &self.buckets[bucket]));
        all.chain(near.into_iter().flatten()).flatten().chain(&self.large).copied()
    }

    /// Whether the surface can go over from the removed to the added faces without touching others
    /// or itself.
    pub fn allows(&self, mesh: &Changing, replacement: &Replacement) -> bool {
        let Replacement { removed, added, between } = replacement;
        let itself = |(i, s): (usize, &[Vec3; 3])| added[..i].iter().any(|t| triangles_intersect(*s, *t));
        if added.iter().enumerate().any(itself) {
            return false;
        }
        let added: Vec<_> = added.iter().map(|t| (t, bounds(t))).collect();
        let between: Vec<_> = between.iter().map(|t| (t, bounds(t))).collect();
        let places = added.iter().map(|own| own.1).chain(between.iter().map(|own| own.1));
        let whole = places.fold(NOWHERE, joined);
        let mut seen = Vec::new();
        self.candidates(whole).all(|face| {
            if removed.contains(&face) {
                return true;
            }
            let Some(other) = self.triangle(mesh, face) else { return true };
            let place = bounds(&other);
            // Most candidates are not near; the others are few.
            if !meet(place, whole) || seen.contains(&face) {
                return true;
            }
            seen.push(face);
            let holds = |t: &[Vec3; 4]| other.iter().any(|p| !t.contains(p) && is_in_tetrahedron(*p, *t));
            let touches = |t: &[Vec3; 3]| triangles_intersect(*t, other);
            !added.iter().any(|(t, own)| meet(*own, place) && touches(t))
                && !between.iter().any(|(t, own)| meet(*own, place) && holds(t))
        })
    }

    /// The buckets of the cells that meet a box.
    fn cells(&self, (low, high): Bounds) -> impl Iterator<Item = usize> + use<> {
        let cell = self.cell;
        let mask = self.buckets.len() - 1;
        let [first, last] = [low, high].map(|p| p.map(|x| (x / cell).floor() as i64));
        (first[0]..=last[0]).flat_map(move |x| {
            (first[1]..=last[1]).flat_map(move |y| {
                (first[2]..=last[2]).map(move |z| {
                    let mixed = [x, y, z].iter().fold(0u64, |hash, k| {
                        (hash.rotate_left(23) ^ *k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
                    });
                    (mixed >> 20) as usize & mask
                })
            })
        })
    }
}

/// The lowest and the highest corner of a box.
type Bounds = (Vec3, Vec3);

const NOWHERE: Bounds = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);

fn bounds(points: &[Vec3]) -> Bounds {
    points.iter().map(|p| (*p, *p)).fold(NOWHERE, joined)
}

fn joined(a: Bounds, b: Bounds) -> Bounds {
    ([0, 1, 2].map(|k| a.0[k].min(b.0[k])), [0, 1, 2].map(|k| a.1[k].max(b.1[k])))
}

fn meet(a: Bounds, b: Bounds) -> bool {
    (0..3).all(|k| a.0[k] <= b.1[k] && b.0[k] <= a.1[k])
}
