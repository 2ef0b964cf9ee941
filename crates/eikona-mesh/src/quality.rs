//! Mesh quality: lengths, angles, areas and aspect ratios of the triangles.

use crate::id::Edge;
use crate::mesh::TriangleMesh;

/// A face has zero area if its area is below this share of its longest edge squared. An area is
/// computed with an error of a few 1e-16 of that square, so at 1e-14 one or two digits are left,
/// and angles and normal are meaningless.
pub const ZERO_AREA: f64 = 1e-14;

/// Two opposite angles may exceed pi by this much before an edge counts as non-Delaunay: regular
/// grids have sums of exactly pi everywhere, and rounding must not count them.
const DELAUNAY_TOLERANCE: f64 = 1e-12;

/// Minimum, mean and maximum of a set of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The smallest.
    pub min: f64,
    /// The arithmetic mean.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

/// The quality of a mesh. `None` means that there is nothing to measure. Lengths and areas are in
/// the mesh's unit (and infinite beyond 1e308); all counts and ratios are independent of scale.
///
/// ```
/// use eikona_mesh::{Quality, TriangleMesh};
/// let mesh = TriangleMesh::new(vec![[0., 0., 0.], [3., 0., 0.], [0., 4., 0.]], vec![[0, 1, 2]])?;
/// let quality = Quality::of(&mesh);
/// assert_eq!(quality.area, 6.0);
/// assert_eq!(quality.edge_length.map(|l| l.max), Some(5.0));
/// assert_eq!(quality.max_angle_deg, Some(90.0));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Lengths of the edges.
    pub edge_length: Option<Range>,
    /// The smallest angle of all faces, in degrees; 0 if a face has zero area.
    pub min_angle_deg: Option<f64>,
    /// The 1st percentile over all faces of their smallest angles, in degrees.
    pub min_angle_percentile_1_deg: Option<f64>,
    /// The largest angle, in degrees.
    pub max_angle_deg: Option<f64>,
    /// The total area of all faces.
    pub area: f64,
    /// Number of edges with two faces whose opposite angles sum to more than pi, that is, with a
    /// negative cotangent weight.
    pub non_delaunay_edges: usize,
    /// Number of faces with an area below [`ZERO_AREA`] times the square of their longest edge.
    pub zero_area_faces: usize,
    /// Aspect ratios of the faces that do not have zero area: longest edge over 2 sqrt(3) times the
    /// inradius. 1 for an equilateral triangle, larger for all others.
    pub aspect_ratio: Option<Range>,
    /// The 99th percentile of the aspect ratios.
    pub aspect_ratio_percentile_99: Option<f64>,
    /// Smallest and largest coordinates of the vertices used by faces.
    pub bounding_box: Option<[[f64; 3]; 2]>,
}

impl Quality {
    /// Measures the mesh.
    ///
    /// # Cost
    /// O(F log F); about 0.6 s per million faces.
    pub fn of(mesh: &TriangleMesh) -> Quality {
        let mut area = 0.0;
        let mut zero_area_faces = 0;
        let mut smallest_angles = Vec::with_capacity(mesh.face_count());
        let mut max_angle: Option<f64> = None;
        let mut aspect_ratios = Vec::with_capacity(mesh.face_count());
        // Sum of the opposite angles of each edge; an undefined angle adds nothing.
        let mut opposite_angles = vec![0.0; mesh.edge_count()];
        for f in mesh.faces() {
            let shape = TriangleShape::of(mesh.face_positions(f));
            area += shape.area_in(1.0);
            if shape.is_zero_area() {
                zero_area_faces += 1;
            } else {
                aspect_ratios.push(shape.aspect_ratio());
            }
            let angles = shape.angles();
            smallest_angles
                .push(angles.iter().fold(f64::INFINITY, |m, a| m.min(a.unwrap_or(0.0))).to_degrees());
            let edges = mesh.face_edges(f);
            for k in 0..3 {
                if let Some(angle) = angles[k] {
                    max_angle = Some(max_angle.map_or(angle, |m| m.max(angle)));
                    opposite_angles[edges[(k + 1) % 3].index()] += angle;
                }
            }
        }
        let non_delaunay = |e: &Edge| {
            mesh.edge_halfedges(*e).len() == 2
                && opposite_angles[e.index()] > std::f64::consts::PI + DELAUNAY_TOLERANCE
        };
        smallest_angles.sort_unstable_by(f64::total_cmp);
        aspect_ratios.sort_unstable_by(f64::total_cmp);
        Quality {
            edge_length: range(mesh.edges().map(|e| {
                let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
                distance(a, b)
            })),
            min_angle_deg: smallest_angles.first().copied(),
            min_angle_percentile_1_deg: percentile(&smallest_angles, 0.01),
            max_angle_deg: max_angle.map(f64::to_degrees),
            area,
            non_delaunay_edges: mesh.edges().filter(non_delaunay).count(),
            zero_area_faces,
            aspect_ratio: range(aspect_ratios.iter().copied()),
            aspect_ratio_percentile_99: percentile(&aspect_ratios, 0.99),
            bounding_box: bounding_box(mesh),
        }
    }
}

/// The edge vectors of a triangle in a unit of its own, so that no square overflows or underflows
/// at any size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleShape {
    /// The largest coordinate of an edge vector, in the mesh's unit; 0 if all corners coincide.
    pub(crate) unit: f64,
    /// Edge vectors from corner k to corner k + 1, divided by `unit`.
    sides: [[f64; 3]; 3],
    /// Their lengths.
    lengths: [f64; 3],
    /// Twice the area, divided by `unit` squared.
    double_area: f64,
}

impl TriangleShape {
    pub(crate) fn of(corners: [[f64; 3]; 3]) -> TriangleShape {
        let (unit, vectors) = scaled([0, 1, 2].map(|k| [corners[k], corners[(k + 1) % 3]]));
        let lengths = vectors.map(|v| dot(v, v).sqrt());
        let longest = (0..3).fold(0, |l, k| if lengths[k] > lengths[l] { k } else { l });
        // The product of the two shorter sides has the smallest rounding error.
        let normal = cross(vectors[(longest + 1) % 3], vectors[(longest + 2) % 3]);
        TriangleShape { unit, sides: vectors, lengths, double_area: dot(normal, normal).sqrt() }
    }

    /// Returns the area in units of this length squared.
    pub(crate) fn area_in(&self, length: f64) -> f64 {
        if self.double_area == 0.0 { 0.0 } else { 0.5 * self.double_area * (self.unit / length).powi(2) }
    }

    fn longest(&self) -> f64 {
        self.lengths.into_iter().fold(0.0, f64::max)
    }

    /// Returns whether the area is below [`ZERO_AREA`] times the square of the longest side.
    pub(crate) fn is_zero_area(&self) -> bool {
        let longest = self.longest();
        longest == 0.0 || 0.5 * self.double_area < ZERO_AREA * longest * longest
    }

    /// Returns the height above the longest side, divided by that side; 0 if all corners coincide.
    pub(crate) fn relative_height(&self) -> f64 {
        let longest = self.longest();
        if longest == 0.0 { 0.0 } else { self.double_area / longest / longest }
    }

    /// Returns the angles at the corners, in radians; `None` where a side has length zero.
    fn angles(&self) -> [Option<f64>; 3] {
        [0, 1, 2].map(|k| {
            let previous = (k + 2) % 3;
            let defined = self.lengths[k] > 0.0 && self.lengths[previous] > 0.0;
            defined.then(|| self.double_area.atan2(-dot(self.sides[k], self.sides[previous])))
        })
    }

    /// Returns the longest side over 2 sqrt(3) r, with the inradius r = 2 area / perimeter.
    fn aspect_ratio(&self) -> f64 {
        let perimeter: f64 = self.lengths.iter().sum();
        self.longest() * perimeter / (2.0 * 3f64.sqrt() * self.double_area)
    }
}

/// Returns the largest coordinate of the vectors from the first to the second point of each pair,
/// and the vectors divided by it.
fn scaled<const N: usize>(pairs: [[[f64; 3]; 2]; N]) -> (f64, [[f64; 3]; N]) {
    let difference = |half: f64| pairs.map(|[p, q]| [0, 1, 2].map(|k| half * q[k] - half * p[k]));
    let largest = |v: &[[f64; 3]; N]| v.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    let mut half = 1.0;
    let mut vectors = difference(half);
    if !largest(&vectors).is_finite() {
        // Near the ends of the range the difference may overflow; the difference of the halves does
        // not.
        half = 0.5;
        vectors = difference(half);
    }
    let unit = largest(&vectors);
    if unit == 0.0 {
        return (0.0, vectors);
    }
    // An infinite unit would turn ratios of units into NaN.
    ((unit / half).min(f64::MAX), vectors.map(|v| v.map(|x| x / unit)))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (unit, [v]) = scaled([[a, b]]);
    if unit == 0.0 { 0.0 } else { unit * dot(v, v).sqrt() }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn range(values: impl ExactSizeIterator<Item = f64>) -> Option<Range> {
    let count = values.len();
    let (min, sum, max) = values
        .fold((f64::INFINITY, 0.0, f64::NEG_INFINITY), |(min, sum, max): (f64, f64, f64), x| {
            (min.min(x), sum + x, max.max(x))
        });
    (count > 0).then(|| Range { min, mean: sum / count as f64, max })
}

/// Returns the value below which this share of the sorted values lies, by linear interpolation.
fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().checked_sub(1)? as f64;
    let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    Some(if low == high { low } else { low + (high - low) * place.fract() })
}

fn bounding_box(mesh: &TriangleMesh) -> Option<[[f64; 3]; 2]> {
    mesh.vertices()
        .filter(|&v| !mesh.vertex_corners(v).is_empty())
        .map(|v| mesh.position(v))
        .map(|p| [p, p])
        .reduce(|[low, high], [p, _]| {
            [0, 1].map(|side| [0, 1, 2].map(|k| if side == 0 { low[k].min(p[k]) } else { high[k].max(p[k]) }))
        })
}
