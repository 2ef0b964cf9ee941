//! Length and curvature of the boundary (RS section 7.3.4).

use super::surface::Vec3;
use crate::geometry::vector::{add, angle, distance, scale, sub, unit};
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{Edge, ElementId, TriangleMesh, Vertex};

fn boundary_edges(mesh: &TriangleMesh) -> impl Iterator<Item = (Edge, [Vertex; 2])> {
    mesh.edges().filter(|&e| mesh.is_boundary_edge(e)).map(|e| (e, mesh.edge_vertices(e)))
}

/// Returns the length of the boundary: zero if there is none.
pub(super) fn length(mesh: &TriangleMesh) -> f64 {
    boundary_edges(mesh).map(|(_, [a, b])| distance(mesh.position(a), mesh.position(b))).sum()
}

/// # Errors
/// [`RepulsiveError::FlatFace`] at an edge without length, which has no derivative.
pub(super) fn length_differential(mesh: &TriangleMesh) -> Result<Vec<Vec3>, RepulsiveError> {
    check_lengths(mesh)?;
    let mut result = vec![[0.0; 3]; mesh.vertex_count()];
    for (_, [a, b]) in boundary_edges(mesh) {
        let along = unit(sub(mesh.position(b), mesh.position(a)));
        result[b.index()] = add(result[b.index()], along);
        result[a.index()] = sub(result[a.index()], along);
    }
    Ok(result)
}

fn check_lengths(mesh: &TriangleMesh) -> Result<(), RepulsiveError> {
    let short = boundary_edges(mesh).find(|(_, [a, b])| mesh.position(*a) == mesh.position(*b));
    // The face at the edge has no area.
    let halfedge = short.and_then(|(edge, _)| mesh.edge_halfedges(edge).first());
    halfedge.map_or(Ok(()), |h| Err(RepulsiveError::FlatFace { face: h.face() }))
}

/// A vertex of the boundary between its two neighbours there.
struct Bend {
    vertices: [usize; 3],
    /// The sides to it and from it.
    sides: [Vec3; 2],
    lengths: [f64; 2],
    /// The angle by which the second side turns from the first: 0 where the boundary is straight.
    turn: f64,
}

impl Bend {
    /// Half the length of both sides.
    fn dual_length(&self) -> f64 {
        0.5 * (self.lengths[0] + self.lengths[1])
    }

    /// The derivative of `turn^2 / length` by the two sides.
    fn by_sides(&self) -> [Vec3; 2] {
        let [a, b] = self.sides.map(unit);
        let length = self.dual_length();
        let (sin, cos) = self.turn.sin_cos();
        // turn / sin tends to 1 where the boundary is straight, and there are kinks at turns by pi.
        let across = [sub(scale(a, cos), b), sub(scale(b, cos), a)];
        let rate = if sin > 1e-8 { self.turn / sin } else { 1.0 };
        let by_length = -0.5 * (self.turn / length).powi(2);
        let by_side = |k: usize, own: Vec3| {
            add(scale(across[k], 2.0 * rate / (length * self.lengths[k])), scale(own, by_length))
        };
        [by_side(0, a), by_side(1, b)]
    }
}

/// # Errors
/// [`RepulsiveError::NonmanifoldVertex`] where other than two boundary edges meet;
/// [`RepulsiveError::FlatFace`].
fn bends(mesh: &TriangleMesh) -> Result<Vec<Bend>, RepulsiveError> {
    check_lengths(mesh)?;
    let mut neighbours = vec![[None; 2]; mesh.vertex_count()];
    for (_, [a, b]) in boundary_edges(mesh) {
        for (vertex, other) in [(a, b), (b, a)] {
            let free = neighbours[vertex.index()].iter_mut().find(|place| place.is_none());
            *free.ok_or(RepulsiveError::NonmanifoldVertex { vertex })? = Some(other);
        }
    }
    let bend = |(v, around): (usize, [Option<Vertex>; 2])| {
        let vertex = Vertex::from_index(v);
        match around {
            [None, None] => None,
            [Some(before), Some(after)] => {
                let [x, y, z] = [before, vertex, after].map(|v| mesh.position(v));
                let sides = [sub(y, x), sub(z, y)];
                let vertices = [before.index(), v, after.index()];
                let turn = angle(sides[0], sides[1]);
                Some(Ok(Bend { vertices, sides, lengths: [distance(x, y), distance(y, z)], turn }))
            }
            _ => Some(Err(RepulsiveError::NonmanifoldVertex { vertex })),
        }
    };
    neighbours.into_iter().enumerate().filter_map(bend).collect()
}

/// Returns the sum over boundary vertices of the squared turning angle by the dual length, which
/// tends to the integral of the squared curvature of the boundary.
pub(super) fn curvature(mesh: &TriangleMesh) -> Result<f64, RepulsiveError> {
    Ok(bends(mesh)?.iter().map(|bend| bend.turn * bend.turn / bend.dual_length()).sum())
}

pub(super) fn curvature_differential(mesh: &TriangleMesh) -> Result<Vec<Vec3>, RepulsiveError> {
    let mut result = vec![[0.0; 3]; mesh.vertex_count()];
    for bend in bends(mesh)? {
        let [before, here, after] = bend.vertices;
        let [first, second] = bend.by_sides();
        result[before] = sub(result[before], first);
        result[here] = add(result[here], sub(first, second));
        result[after] = add(result[after], second);
    }
    Ok(result)
}

/// Returns the derivative of `(length - target)^2`.
pub(super) fn length_deviation_differential(
    mesh: &TriangleMesh,
    target: f64,
) -> Result<Vec<Vec3>, RepulsiveError> {
    let slope = 2.0 * (length(mesh) - target);
    Ok(length_differential(mesh)?.into_iter().map(|v| scale(v, slope)).collect())
}
