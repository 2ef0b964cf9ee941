//! Isolines of a piecewise linear function.
//!
//! A vertex value that equals the level counts as above it. Under this rule at most one segment
//! crosses a face, and the segments of neighbouring faces meet in a point of their common edge: no
//! curve is torn, and vertices or faces on the level need no special case. Nodes at vertices are
//! then moved onto them, which merges the nodes of all edges at that vertex.

use super::ContourError;
use crate::geometry::vector::{cross, normalize, scale, sub};
use eikona_mesh::{
    Curve, CurveKind, Edge, Face, Located, Neighbour, SNAP_TOLERANCE, TriangleMesh, VertexField,
};

/// Isolines of one level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelSet {
    /// The level.
    pub level: f64,
    /// The curves, signed, with the smaller values on the left. Closed ones repeat their first node
    /// at the end.
    pub curves: Vec<Curve>,
    /// Number of faces without isolines because the field is not finite at a corner.
    pub undefined_faces: usize,
}

/// Computes the isolines of a vertex field, level by level.
///
/// Each curve has the smaller values on its left, so an isoline of a distance that is negative on
/// the left of its source can serve as a source again. Curves end at the boundary, at nonmanifold
/// edges and at faces with a nonfinite value. A region exactly on the level counts as above it.
/// Where the field touches the level from below there is no curve; only a ridge on the level from
/// boundary to boundary gives two, which run in opposite directions. Across inconsistently oriented
/// faces a curve continues with the smaller values on the same side, and its `up` says from which
/// side of the surface that is seen.
///
/// ```
/// use eikona::contour::{isolines, polylines};
/// use eikona_mesh::TriangleMesh;
/// let mesh = TriangleMesh::new(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], vec![[0, 1, 2]])?;
/// let x = vec![0.0, 1.0, 0.0].into();
/// let points = polylines(&mesh, &isolines(&mesh, &x, &[0.25])?[0].curves)?;
/// // Upwards, so that smaller values are on the left.
/// assert_eq!(points, [[[0.25, 0.0, 0.0], [0.25, 0.75, 0.0]]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ContourError::WrongLength`], and [`ContourError::Parameter`] for a level that is not finite.
///
/// # Cost
/// O(F) per level.
pub fn isolines(
    mesh: &TriangleMesh,
    field: &VertexField<f64>,
    levels: &[f64],
) -> Result<Vec<LevelSet>, ContourError> {
    if field.len() != mesh.vertex_count() {
        return Err(ContourError::WrongLength { found: field.len(), expected: mesh.vertex_count() });
    }
    levels.iter().map(|&level| level_set(mesh, field.as_slice(), level)).collect()
}

fn level_set(mesh: &TriangleMesh, values: &[f64], level: f64) -> Result<LevelSet, ContourError> {
    if !level.is_finite() {
        return Err(ContourError::Parameter { name: "level", value: level, bound: "it must be finite" });
    }
    let mut undefined_faces = 0;
    // The crossed sides of each crossed face: where its boundary, walked around, rises through the
    // level, and where it falls.
    let mut crossing: Vec<Option<[u8; 2]>> = Vec::with_capacity(mesh.face_count());
    for face in mesh.triangles() {
        let v = face.map(|i| values[i as usize]);
        if !v.iter().all(|x| x.is_finite()) {
            undefined_faces += 1;
            crossing.push(None);
            continue;
        }
        let above = v.map(|x| x >= level);
        let side = |from: bool| (0..3).find(|&k| above[k] == from && above[(k + 1) % 3] != from);
        crossing.push(side(false).zip(side(true)).map(|(up, down)| [up as u8, down as u8]));
    }
    let mut curves = Vec::new();
    let mut visited = vec![false; mesh.face_count()];
    for seed in mesh.faces() {
        let Some([up, down]) = crossing[seed.index()] else { continue };
        if visited[seed.index()] {
            continue;
        }
        visited[seed.index()] = true;
        // Follow the curve forward from the seed face, out of its falling side, and backward unless
        // that closes the curve.
        let forward = follow(mesh, &crossing, &mut visited, seed, down);
        let mut edges = vec![mesh.face_edges(seed)[up as usize]];
        let mut turned = forward.turned;
        let mut first = (seed, false);
        if !forward.closed {
            let backward = follow(mesh, &crossing, &mut visited, seed, up);
            edges = backward.edges;
            edges.reverse();
            turned |= backward.turned;
            first = backward.last;
        }
        edges.extend(forward.edges);
        let nodes = merge_nodes(edges.into_iter().map(|e| node_on_edge(mesh, values, level, e)));
        if nodes.len() < 2 {
            continue;
        }
        let up = if turned {
            face_normal(mesh, first.0).map(|n| if first.1 { scale(n, -1.0) } else { n })
        } else {
            None
        };
        let nodes = nodes.iter().map(|p| p.to_surface_point(mesh)).collect();
        curves.push(Curve { kind: CurveKind::Signed, nodes, up });
    }
    Ok(LevelSet { level, curves, undefined_faces })
}

/// A sequence of crossed edges, starting at a face.
struct Run {
    /// The edges in order, including the one on which the run leaves its first face.
    edges: Vec<Edge>,
    /// Whether it returned to its first face.
    closed: bool,
    /// Whether it crossed an edge between inconsistently oriented faces.
    turned: bool,
    /// The last face, and whether it is oriented against the first.
    last: (Face, bool),
}

fn follow(
    mesh: &TriangleMesh,
    crossing: &[Option<[u8; 2]>],
    visited: &mut [bool],
    seed: Face,
    exit: u8,
) -> Run {
    let mut halfedge = seed.halfedge(exit as usize);
    let mut run = Run { edges: vec![mesh.edge(halfedge)], closed: false, turned: false, last: (seed, false) };
    while let Neighbour::Twin(entry) = mesh.neighbour(halfedge) {
        let face = entry.face();
        if face == seed {
            run.closed = true;
            break;
        }
        let Some([up, down]) = crossing[face.index()] else { break };
        if visited[face.index()] {
            break;
        }
        visited[face.index()] = true;
        let against = mesh.origin(entry) == mesh.origin(halfedge);
        run.turned |= against;
        run.last = (face, run.last.1 != against);
        halfedge = face.halfedge(usize::from(if entry.side() == up as usize { down } else { up }));
        run.edges.push(mesh.edge(halfedge));
    }
    run
}

fn node_on_edge(mesh: &TriangleMesh, values: &[f64], level: f64, edge: Edge) -> Located {
    let [a, b] = mesh.edge_vertices(edge);
    // Halving keeps the difference of two huge values finite.
    let (va, vb) = (0.5 * values[a.index()], 0.5 * values[b.index()]);
    let t = (0.5 * level - va) / (vb - va);
    if t.is_nan() || t <= SNAP_TOLERANCE {
        Located::Vertex(a)
    } else if t >= 1.0 - SNAP_TOLERANCE {
        Located::Vertex(b)
    } else {
        Located::Edge(edge, t)
    }
}

/// Removes repeated nodes, and pieces that run out and straight back, where the field touches the
/// level.
fn merge_nodes(nodes: impl Iterator<Item = Located>) -> Vec<Located> {
    let mut merged: Vec<Located> = Vec::new();
    for node in nodes {
        if merged.last() == Some(&node) {
            continue;
        }
        if merged.len() >= 2 && merged[merged.len() - 2] == node {
            merged.pop();
            continue;
        }
        merged.push(node);
    }
    // The same across the start of a closed curve.
    let mut trim = 0;
    while merged.len() >= 2 * trim + 4
        && merged[trim] == merged[merged.len() - 1 - trim]
        && merged[trim + 1] == merged[merged.len() - 2 - trim]
    {
        trim += 1;
    }
    let end = merged.len() - trim;
    let kept = merged[trim..end].to_vec();
    if kept.len() == 3 && kept.first() == kept.last() { Vec::new() } else { kept }
}

pub(super) fn face_normal(mesh: &TriangleMesh, face: Face) -> Option<[f64; 3]> {
    let [a, b, c] = mesh.face_positions(face);
    normalize(cross(sub(b, a), sub(c, a)))
}
