//! Whole numbers for faces (section 3.5.1).

use crate::geometry::Triangle;
use crate::winding::harmonic::tip_corner;
use crate::winding::options::Reference;
use eikona_mesh::{Components, Edge, Face, TriangleMesh};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Labels of faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Labels {
    pub label: Vec<i32>,
    /// Half minus the distance of the face's mean value, shifted, from its label: 0.5 for certain, 0 for a guess.
    pub margin: Vec<f64>,
    /// What was added to the values of each component before they were rounded.
    pub shift: Vec<f64>,
}

/// The mean of the values at the corners of a face that has any.
pub(crate) fn face_mean(values: &[f64], face: Face) -> Option<f64> {
    let corners = values[3 * face.index()..3 * face.index() + 3].iter().filter(|w| !w.is_nan());
    let (sum, count) = corners.fold((0.0, 0), |(sum, count), w| (sum + w, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// Rounds a function that jumps by `jump` (first face of an edge minus second).
///
/// Deviation: the public program shifts by the mean of |round(a) - a| over the curve, which loses the sign of the shift. Here it
/// is a circular mean: halfway between both sides of a jump lies a whole number plus half the jump.
pub(crate) fn labels(
    mesh: &TriangleMesh,
    triangles: &[Triangle],
    components: &Components,
    values: &[f64],
    jump: &[f64],
    reference: Reference,
) -> Labels {
    let component = |f: Face| components.of_face[f] as usize;
    let mut phase = vec![[0.0, 0.0]; components.count];
    let mut add = |component: usize, value: f64, weight: f64| {
        let angle = TAU * value;
        phase[component][0] += weight * angle.cos();
        phase[component][1] += weight * angle.sin();
    };
    let mut jumps_in = vec![false; components.count];
    for e in mesh.edges().filter(|e| jump[e.index()].abs() > 0.5) {
        if let Some((middle, length)) = middle_of_jump(mesh, triangles, values, e) {
            let component = component(mesh.edge_halfedges(e)[0].face());
            jumps_in[component] = true;
            add(component, middle - 0.5 * jump[e.index()].round(), length);
        }
    }
    // Without a jump the values themselves say what is whole.
    for f in mesh.faces().filter(|&f| !jumps_in[component(f)]) {
        if let Some(mean) = face_mean(values, f) {
            add(component(f), mean, triangles[f.index()].area);
        }
    }
    let shift: Vec<f64> =
        phase.iter().map(|[x, y]| if *x == 0.0 && *y == 0.0 { 0.0 } else { -y.atan2(*x) / TAU }).collect();

    let mut label = vec![0; mesh.face_count()];
    let mut margin = vec![0.0; mesh.face_count()];
    for f in mesh.faces() {
        if let Some(mean) = face_mean(values, f) {
            let value = mean + shift[component(f)];
            label[f.index()] = value.round() as i32;
            margin[f.index()] = 0.5 - (value - value.round()).abs();
        }
    }
    let zero = zero_levels(mesh, triangles, components, &label, values, reference);
    for f in mesh.faces() {
        label[f.index()] -= zero[component(f)];
    }
    let shift = shift.iter().zip(&zero).map(|(s, &z)| s - f64::from(z)).collect();
    Labels { label, margin, shift }
}

/// Halfway between the values on both sides of an edge, in its middle, and the length of the edge.
fn middle_of_jump(
    mesh: &TriangleMesh,
    triangles: &[Triangle],
    values: &[f64],
    e: Edge,
) -> Option<(f64, f64)> {
    let halfedges = mesh.edge_halfedges(e);
    let (mut sum, mut count) = (0.0, 0);
    // An end that is an endpoint has no value on either side.
    for v in mesh.edge_vertices(e) {
        let at =
            |h: &eikona_mesh::Halfedge| values[if mesh.origin(*h) == v { h.index() } else { tip_corner(*h) }];
        let mean = halfedges.iter().map(at).sum::<f64>() / halfedges.len() as f64;
        if !mean.is_nan() {
            sum += mean;
            count += 1;
        }
    }
    let first = halfedges[0];
    let length = triangles[first.face().index()].lengths[first.index() % 3];
    (count > 0).then(|| (sum / f64::from(count), length))
}

/// The label that becomes 0 in each component.
fn zero_levels(
    mesh: &TriangleMesh,
    triangles: &[Triangle],
    components: &Components,
    label: &[i32],
    values: &[f64],
    reference: Reference,
) -> Vec<i32> {
    let mut areas: Vec<BTreeMap<i32, f64>> = vec![BTreeMap::new(); components.count];
    for f in mesh.faces().filter(|&f| face_mean(values, f).is_some()) {
        *areas[components.of_face[f] as usize].entry(label[f.index()]).or_default() +=
            triangles[f.index()].area;
    }
    let most = |areas: &BTreeMap<i32, f64>| {
        let largest = areas.iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)));
        largest.map_or(0, |(&label, _)| label)
    };
    let mut zero: Vec<i32> = areas.iter().map(most).collect();
    if let Reference::Face(face) = reference {
        zero[components.of_face[face] as usize] = label[face.index()];
    }
    zero
}
