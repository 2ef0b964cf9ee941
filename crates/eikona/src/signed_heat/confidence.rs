//! Confidence: whether each value rests on data or on extrapolation.

use crate::geometry::vector::{add, distance, dot, scale, sub};
use crate::geometry::{Triangle, fast_marching, mean_edge_length};
use crate::signed_heat::diffusion::UnitField;
use crate::signed_heat::solution::Confidence;
use crate::signed_heat::source::Source;
use eikona_mesh::{Face, SegmentHost, TriangleMesh, Vertex, VertexField};

/// Computes the [`Confidence`] of a distance.
pub(crate) fn confidence(
    mesh: &TriangleMesh,
    triangles: &[Triangle],
    source: &Source,
    field: &UnitField,
    phi: &[f64],
) -> Confidence {
    let to_data = fast_marching(mesh, triangles, &seeds(mesh, source));
    let edge = mean_edge_length(mesh, triangles);
    let agreement = vertex_agreement(mesh, triangles, field);
    let confidence = (0..mesh.vertex_count())
        .map(|v| match agreement[v] {
            Some(agreement) => ((phi[v].abs() + edge) / (to_data[v] + edge)).min(1.0) * agreement,
            // The field vanishes in the faces around: degenerate ones between coincident vertices.
            None if phi[v].is_finite() => 0.0,
            None => f64::NAN,
        })
        .collect::<Vec<f64>>();
    let to_data: Vec<f64> = to_data.into_iter().map(|d| if d.is_finite() { d } else { f64::NAN }).collect();
    Confidence { distance_to_data: VertexField::from(to_data), confidence: VertexField::from(confidence) }
}

/// Seeds for fast marching: corners of faces that contain data, with their distance to it.
fn seeds(mesh: &TriangleMesh, source: &Source) -> Vec<(Vertex, f64)> {
    let mut seeds = Vec::new();
    let mut near = |face: Face, [a, b]: [[f64; 3]; 2]| {
        let seed = |v: Vertex| (v, distance_to_segment(mesh.position(v), a, b));
        seeds.extend(mesh.face_vertices(face).map(seed));
    };
    for segment in &source.segments {
        let ends = segment.ends.map(|p| p.position(mesh));
        match segment.host {
            SegmentHost::Face(face, _) => near(face, ends),
            SegmentHost::Edge(e, _) => mesh.edge_halfedges(e).iter().for_each(|h| near(h.face(), ends)),
        }
    }
    let mut points = source.points.clone();
    points.sort_by_key(|p| p.key());
    points.dedup();
    for point in points {
        point.faces(mesh).into_iter().for_each(|face| near(face, [point.position(mesh); 2]));
    }
    seeds
}

fn distance_to_segment(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let (ab, ap) = (sub(b, a), sub(p, a));
    let length_sq = dot(ab, ab);
    let t = if length_sq > 0.0 { (dot(ap, ab) / length_sq).clamp(0.0, 1.0) } else { 0.0 };
    distance(p, add(a, scale(ab, t)))
}

/// Area-weighted agreement of the faces around each vertex; `None` where the field reaches none.
fn vertex_agreement(mesh: &TriangleMesh, triangles: &[Triangle], field: &UnitField) -> Vec<Option<f64>> {
    mesh.vertices()
        .map(|v| {
            let (mut sum, mut area) = (0.0, 0.0);
            for f in mesh.vertex_corners(v).iter().map(|c| c.face().index()).filter(|f| field.reached[*f]) {
                sum += triangles[f].area * field.agreement[f];
                area += triangles[f].area;
            }
            // Rounding may give slightly more than 1.
            (area > 0.0).then(|| (sum / area).min(1.0))
        })
        .collect()
}
