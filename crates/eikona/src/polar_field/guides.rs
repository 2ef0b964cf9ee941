//! What a field follows: curves, boundaries and creases, as straight pieces in faces.

use crate::Warning;
use crate::geometry::vector::{Vec3, cross, dot, norm, normalize, sub};
use crate::polar_field::bevel::BeveledMesh;
use crate::polar_field::error::PolarFieldError;
use eikona_mesh::{Edge, Face, Halfedge, SegmentHost, SurfaceCurves, Vertex, VertexField};
use eikona_numeric::{Complex, Scalar};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Something for a field to follow: one of its N directions is tangent to it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Guide {
    /// All boundary loops.
    Boundary,
    /// The edges inside the surface at which the normals of the two faces differ by more than this
    /// angle, in degrees. Creases have no direction, so they guide fields of even degree only.
    Creases {
        /// The angle, in degrees.
        degrees: f64,
    },
    /// Curves, in their direction if N is odd.
    Curves(SurfaceCurves),
}

/// Angle of creases, in degrees, where none is given.
pub const CREASE_DEGREES: f64 = 30.0;

/// A straight piece of a guide in a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    pub face: Face,
    /// Barycentric weights of its ends.
    pub ends: [[f64; 3]; 2],
    /// Its direction in the layout of the face.
    pub direction: Complex,
    pub length: f64,
}

/// A path of a guide: its stretches in order. Along an edge, those in both of its faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Path {
    pub stretches: Vec<Stretch>,
    pub is_closed: bool,
    /// The guide in words, for messages.
    pub name: String,
}

/// Returns the paths of all guides.
pub(crate) fn paths(
    bevel: &BeveledMesh,
    guides: &[Guide],
    degree: u32,
) -> Result<Vec<Path>, PolarFieldError> {
    let mut paths = Vec::new();
    for guide in guides {
        match guide {
            Guide::Boundary if bevel.topology.boundary_loops.is_empty() => {
                return Err(PolarFieldError::NoBoundary);
            }
            Guide::Boundary => paths.extend(boundary(bevel)),
            Guide::Creases { degrees } => {
                if !(*degrees > 0.0 && *degrees < 180.0) {
                    return Err(PolarFieldError::CreaseAngle { degrees: *degrees });
                }
                if !degree.is_multiple_of(2) {
                    return Err(PolarFieldError::CreasesWithOddDegree { degree });
                }
                paths.extend(creases(bevel, *degrees));
            }
            Guide::Curves(curves) => paths.extend(of_curves(bevel, curves)?),
        }
    }
    Ok(paths)
}

fn boundary(bevel: &BeveledMesh) -> impl Iterator<Item = Path> + '_ {
    bevel.topology.boundary_loops.iter().enumerate().map(|(b, boundary)| Path {
        stretches: boundary.halfedges.iter().map(|&h| along_side(bevel, h, false)).collect(),
        is_closed: boundary.is_closed(),
        name: format!("boundary loop {b}"),
    })
}

/// The stretch along a side of a face, or against it.
fn along_side(bevel: &BeveledMesh, h: Halfedge, against: bool) -> Stretch {
    let triangle = &bevel.triangles[h.face().index()];
    let corner = |k: usize| {
        let mut weights = [0.0; 3];
        weights[k % 3] = 1.0;
        weights
    };
    let mut ends = [corner(h.side()), corner(h.side() + 1)];
    let mut direction = triangle.directions()[h.side()];
    if against {
        ends.reverse();
        direction = -direction;
    }
    Stretch { face: h.face(), ends, direction, length: triangle.lengths[h.side()] }
}

/// The stretches along an edge in each of its faces, from one of its vertices.
fn along_edge(bevel: &BeveledMesh, e: Edge, from: Vertex) -> impl Iterator<Item = Stretch> + '_ {
    let halfedges = bevel.mesh.edge_halfedges(e).iter();
    halfedges.map(move |&h| along_side(bevel, h, bevel.mesh.origin(h) != from))
}

fn of_curves(bevel: &BeveledMesh, curves: &SurfaceCurves) -> Result<Vec<Path>, PolarFieldError> {
    if curves.curves.is_empty() {
        return Err(PolarFieldError::NoCurve);
    }
    let mut paths: Vec<Path> = curves
        .curves
        .iter()
        .enumerate()
        .map(|(c, curve)| Path {
            stretches: Vec::new(),
            is_closed: curve.is_closed(),
            name: format!("curve {c}"),
        })
        .collect();
    for segment in curves.segments(&bevel.mesh)? {
        let stretches = &mut paths[segment.curve].stretches;
        match segment.host {
            SegmentHost::Face(face, ends) => {
                let triangle = &bevel.triangles[face.index()];
                let [from, to] = ends.map(|weights| triangle.point(weights));
                let length = (to - from).norm();
                if length > 0.0 {
                    let direction = (to - from) * (1.0 / length);
                    stretches.push(Stretch { face, ends, direction, length });
                }
            }
            SegmentHost::Edge(e, [from, to]) => {
                let [a, b] = bevel.mesh.edge_vertices(e);
                for whole in along_edge(bevel, e, if from <= to { a } else { b }) {
                    let part = |t: f64| {
                        let s = if from <= to { t } else { 1.0 - t };
                        [0, 1, 2].map(|k| (1.0 - s) * whole.ends[0][k] + s * whole.ends[1][k])
                    };
                    let length = whole.length * (to - from).abs();
                    stretches.push(Stretch { ends: [part(from), part(to)], length, ..whole });
                }
            }
        }
    }
    Ok(paths)
}

/// Returns a warning for each kind of crease of which there is none.
pub(crate) fn missing_creases(bevel: &BeveledMesh, guides: &[Guide]) -> Vec<Warning> {
    let angle = |guide: &Guide| match guide {
        Guide::Creases { degrees } => Some(*degrees),
        Guide::Boundary | Guide::Curves(_) => None,
    };
    let angles: Vec<f64> = guides.iter().filter_map(angle).collect();
    if angles.is_empty() {
        return Vec::new();
    }
    let bends = bevel.edges().map(|(h, twin)| bend(bevel, h, twin).abs().to_degrees());
    let sharpest = bends.fold(0.0, f64::max);
    let missing = angles.into_iter().filter(|degrees| sharpest <= *degrees);
    missing.map(|degrees| Warning::NoCreases { degrees, sharpest }).collect()
}

/// Joins the sharp edges to paths, which end where three or more of them meet.
fn creases(bevel: &BeveledMesh, degrees: f64) -> Vec<Path> {
    let mesh = &bevel.mesh;
    let mut at: VertexField<Vec<Edge>> = VertexField::constant(mesh.vertex_count(), Vec::new());
    let mut waiting: BTreeSet<u32> = BTreeSet::new();
    for (h, twin) in bevel.edges() {
        if bend(bevel, h, twin).abs().to_degrees() > degrees {
            let e = mesh.edge(h);
            waiting.insert(e.0);
            mesh.edge_vertices(e).into_iter().for_each(|v| at[v].push(e));
        }
    }
    let mut starts: Vec<(Vertex, Edge)> = Vec::new();
    for v in mesh.vertices().filter(|v| at[*v].len() != 2) {
        starts.extend(at[v].iter().map(|&e| (v, e)));
    }
    // Closed paths are left to the end.
    let on_loops: Vec<(Vertex, Edge)> =
        waiting.iter().map(|&e| (mesh.edge_vertices(Edge(e))[0], Edge(e))).collect();
    let mut paths = Vec::new();
    for (start, first) in starts.into_iter().chain(on_loops) {
        let (mut v, mut e) = (start, first);
        let mut path = Path { name: format!("the crease at {first}"), ..Path::default() };
        while waiting.remove(&e.0) {
            path.stretches.extend(along_edge(bevel, e, v));
            let [a, b] = mesh.edge_vertices(e);
            v = if v == a { b } else { a };
            if let &[p, q] = at[v].as_slice() {
                e = if p == e { q } else { p };
            }
        }
        path.is_closed = v == start;
        if !path.stretches.is_empty() {
            paths.push(path);
        }
    }
    paths
}

/// Returns the angle between the normals of two faces, positive where the edge is convex.
pub(crate) fn bend(bevel: &BeveledMesh, h: Halfedge, twin: Halfedge) -> f64 {
    let mesh = &bevel.mesh;
    let normal = |h: Halfedge| -> Vec3 {
        let [a, b, c] = mesh.face_positions(h.face());
        let unit = |v: Vec3| normalize(v).unwrap_or(v);
        cross(unit(sub(b, a)), unit(sub(c, a)))
    };
    let [n, m] = [h, twin].map(normal);
    let along = sub(mesh.position(mesh.tip(h)), mesh.position(mesh.origin(h)));
    let (sine, length) = (dot(cross(n, m), along), norm(along));
    if length > 0.0 { (sine / length).atan2(dot(n, m)) } else { 0.0 }
}

/// Returns the direction of the N-th power along each stretch, added up by length per face.
pub(crate) fn directions_in_faces(paths: &[Path], degree: u32) -> Vec<(Face, Complex)> {
    let mut sums: Vec<(Face, Complex)> = Vec::new();
    for stretch in paths.iter().flat_map(|path| &path.stretches) {
        sums.push((stretch.face, power(stretch.direction, degree) * stretch.length));
    }
    sums.sort_by_key(|(face, _)| *face);
    sums.chunk_by(|a, b| a.0 == b.0)
        .map(|same| (same[0].0, same.iter().fold(Complex::ZERO, |sum, (_, z)| sum + *z)))
        .filter(|(_, sum)| sum.norm() > 0.0)
        .map(|(face, sum)| (face, sum * (1.0 / sum.norm())))
        .collect()
}

/// Returns the N-th power of a direction, of length 1.
pub(crate) fn power(direction: Complex, degree: u32) -> Complex {
    let angle = (f64::from(degree) * direction.arg()) % TAU;
    Complex { re: angle.cos(), im: angle.sin() }
}
