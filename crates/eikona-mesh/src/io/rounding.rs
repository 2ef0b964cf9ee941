//! Rounding of coordinates to the 32-bit floats of STL, GLB and glTF.

use super::MeshFormat;
use super::MeshOut;
use crate::polygon::PolygonMesh;
use crate::warning::FileWarning;
use std::collections::HashSet;

/// Significant bits of a 32-bit float.
const BITS: i32 = 24;

/// An axis-aligned bounding box.
#[derive(Clone, Copy)]
struct Bounds {
    least: [f64; 3],
    most: [f64; 3],
}

impl Bounds {
    /// Returns `None` without points.
    fn of(positions: &[[f64; 3]]) -> Option<Bounds> {
        let &first = positions.first()?;
        let join = |b: Bounds, p: &[f64; 3]| Bounds {
            least: [0, 1, 2].map(|k| b.least[k].min(p[k])),
            most: [0, 1, 2].map(|k| b.most[k].max(p[k])),
        };
        Some(positions.iter().fold(Bounds { least: first, most: first }, join))
    }
    /// Returns the longest side.
    fn size(&self) -> f64 {
        (0..3).map(|k| self.most[k] - self.least[k]).fold(0.0, f64::max)
    }
    /// Returns the largest absolute coordinate.
    fn reach(&self) -> f64 {
        self.least.iter().chain(&self.most).fold(0.0, |m, x| m.max(x.abs()))
    }
}

/// Returns the offset to subtract before coordinates are rounded to 32-bit floats.
///
/// It is zero along an axis on which the centre of the mesh is within 8 times its size of the
/// origin. Otherwise it is the centre rounded to a multiple of a power of two near the size, so
/// that the subtraction is exact.
pub(super) fn offset(positions: &[[f64; 3]]) -> [f64; 3] {
    const FAR: f64 = 8.0;
    let Some(bounds) = Bounds::of(positions) else { return [0.0; 3] };
    let size = bounds.size();
    [0, 1, 2].map(|k| {
        let centre = bounds.least[k] + 0.5 * (bounds.most[k] - bounds.least[k]);
        if !centre.is_finite() || centre.abs() <= FAR * size {
            return 0.0;
        }
        // A mesh of size zero is a single point, which is its own offset.
        let step = if size > 0.0 { size.log2().floor().exp2() } else { 0.0 };
        if step > 0.0 { (centre / step).round() * step } else { centre }
    })
}

/// Warns if rounding to 32-bit floats moves a vertex by more than a hundredth of the shortest edge.
///
/// `offset` is what the file stores at full precision.
///
/// # Cost
/// O(V + F), with a hash table of the positions only if there is a warning.
pub(super) fn warning(mesh: &MeshOut, offset: [f64; 3], format: MeshFormat) -> Option<FileWarning> {
    const HARMLESS: f64 = 0.01;
    let positions = mesh.positions();
    let stored = |p: &[f64; 3]| [0, 1, 2].map(|k| f64::from((p[k] - offset[k]) as f32) + offset[k]);
    let shift = |p: &[f64; 3]| stored(p).iter().zip(p).fold(0.0, |m: f64, (s, x)| m.max((s - x).abs()));
    let moved = positions.iter().map(shift).fold(0.0, f64::max);
    if moved == 0.0 {
        return None;
    }
    let length = |a: u32, b: u32| {
        let (p, q) = (positions[a as usize], positions[b as usize]);
        p.iter().zip(q).map(|(p, q)| (p - q) * (p - q)).sum::<f64>().sqrt()
    };
    let sides = mesh.faces().flat_map(|f| f.iter().zip(f.iter().cycle().skip(1)).map(|(&a, &b)| (a, b)));
    let lines = mesh.lines.iter().flat_map(|l| l.windows(2).map(|w| (w[0], w[1])));
    let shortest =
        sides.chain(lines).map(|(a, b)| length(a, b)).filter(|&l| l > 0.0).fold(f64::INFINITY, f64::min);
    let scale = if shortest.is_finite() { shortest } else { Bounds::of(positions)?.size() };
    if moved <= HARMLESS * scale {
        return None;
    }
    // 0 and -0 are the same position.
    let key = |p: [f64; 3]| p.map(|x| (x + 0.0).to_bits());
    let before: HashSet<[u64; 3]> = positions.iter().map(|&p| key(p)).collect();
    let after: HashSet<[u64; 3]> = positions.iter().map(|p| key(stored(p))).collect();
    Some(FileWarning::RoundedCoordinates {
        format,
        change: moved,
        shortest_edge: scale,
        collapsed: before.len() - after.len(),
        of: before.len(),
    })
}

/// Warns of faces whose corners coincide because the coordinates were rounded to 32-bit floats.
///
/// This is assumed if all coordinates are such floats and their spacing is coarse for the size of
/// the mesh.
///
/// # Cost
/// O(V), and O(F) more if the spacing is coarse.
pub(super) fn lost_digits(mesh: &PolygonMesh) -> Option<FileWarning> {
    const COARSE: f64 = 1e-4;
    let bounds = Bounds::of(&mesh.positions)?;
    let spacing = (bounds.reach().log2().floor() - f64::from(BITS - 1)).exp2();
    let size = bounds.size();
    if !(spacing > COARSE * size && size.is_finite()) {
        return None;
    }
    if mesh.positions.iter().flatten().any(|&x| f64::from(x as f32) != x) {
        return None;
    }
    let place = |v: u32| mesh.positions[v as usize];
    let collapsed = |face: &[u32]| {
        (0..face.len()).any(|k| {
            let (a, b) = (face[k], face[(k + 1) % face.len()]);
            a != b && place(a) == place(b)
        })
    };
    match mesh.faces().filter(|f| collapsed(f)).count() {
        0 => None,
        faces => {
            Some(FileWarning::LostDigits { faces, of: mesh.face_count(), spacing, reach: bounds.reach() })
        }
    }
}
