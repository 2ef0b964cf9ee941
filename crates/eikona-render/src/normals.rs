//! Normals at corners: angle-weighted over the faces that join smoothly, split at sharp edges.

use crate::vector::{V3, add, cross, dot, norm, scale, sub, unit};
use eikona_mesh::{Orientation, TriangleMesh};

/// Unit normals of the faces; zero for faces without area.
pub(crate) fn face_normals(mesh: &TriangleMesh, positions: &[V3]) -> Vec<V3> {
    mesh.triangles()
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            unit(cross(sub(b, a), sub(c, a)))
        })
        .collect()
}

/// The side of each face that is its front, as a factor of its normal: +1 or -1 such that
/// neighbours agree, or 0 where the surface is one-sided, so that no face has a front.
pub(crate) fn front_sides(mesh: &TriangleMesh) -> Vec<i8> {
    let orientation = Orientation::of(mesh);
    mesh.faces()
        .map(|face| {
            let patch = &orientation.patches[orientation.patch_of_face[face] as usize];
            if patch.is_orientable() { orientation.sign_of_face[face] } else { 0 }
        })
        .collect()
}

/// Three normals a face. Corners at a vertex share a normal when a chain of edges, each with an
/// angle of at most `crease` between its two faces, joins them. Faces oriented against each other
/// are joined too, with the sign turned.
pub(crate) fn corner_normals(
    mesh: &TriangleMesh,
    positions: &[V3],
    face_normal: &[V3],
    crease: f64,
) -> Vec<[f32; 3]> {
    let mut groups = SignedGroups::new(mesh.halfedge_count());
    let smallest_cosine = crease.min(std::f64::consts::PI).cos() - 1e-12;
    for e in mesh.edges() {
        let &[g, h] = mesh.edge_halfedges(e) else { continue };
        let against = mesh.origin(g) == mesh.origin(h);
        let cosine = dot(face_normal[g.face().index()], face_normal[h.face().index()]);
        if (if against { -cosine } else { cosine }) < smallest_cosine {
            continue;
        }
        let (g0, g1) = (g.corner().index(), g.next().corner().index());
        let (h0, h1) = (h.corner().index(), h.next().corner().index());
        if against {
            groups.join(g0, h0, true);
            groups.join(g1, h1, true);
        } else {
            groups.join(g0, h1, false);
            groups.join(g1, h0, false);
        }
    }
    let mut sum = vec![[0.0f64; 3]; mesh.halfedge_count()];
    for (f, t) in mesh.triangles().iter().enumerate() {
        let p = t.map(|v| positions[v as usize]);
        for k in 0..3 {
            let (u, v) = (sub(p[(k + 1) % 3], p[k]), sub(p[(k + 2) % 3], p[k]));
            let angle = norm(cross(u, v)).atan2(dot(u, v));
            let (root, turned) = groups.find(3 * f + k);
            let weight = if turned { -angle } else { angle };
            sum[root] = add(sum[root], scale(face_normal[f], weight));
        }
    }
    (0..mesh.halfedge_count())
        .map(|c| {
            let (root, turned) = groups.find(c);
            let n = unit(sum[root]);
            let n = if n == [0.0; 3] { face_normal[c / 3] } else { n };
            n.map(|x| if turned { -x } else { x } as f32)
        })
        .collect()
}

/// Union-find in which each member is turned over or not relative to its root.
struct SignedGroups {
    parent: Vec<u32>,
    turned: Vec<bool>,
}

impl SignedGroups {
    fn new(count: usize) -> Self {
        SignedGroups { parent: (0..count as u32).collect(), turned: vec![false; count] }
    }
    fn find(&mut self, mut i: usize) -> (usize, bool) {
        let mut turned = false;
        while self.parent[i] as usize != i {
            let p = self.parent[i] as usize;
            // Path halving: point to the grandparent.
            let (grandparent, parent_turned) = (self.parent[p], self.turned[p]);
            if grandparent as usize != p {
                self.parent[i] = grandparent;
                self.turned[i] ^= parent_turned;
            }
            turned ^= self.turned[i];
            i = self.parent[i] as usize;
        }
        (i, turned)
    }
    fn join(&mut self, a: usize, b: usize, against: bool) {
        let ((ra, ta), (rb, tb)) = (self.find(a), self.find(b));
        if ra != rb {
            let (low, high) = (ra.min(rb), ra.max(rb));
            self.parent[high] = low as u32;
            self.turned[high] = ta ^ tb ^ against;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eikona_mesh::Face;

    fn cube() -> TriangleMesh {
        let positions = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        TriangleMesh::new(positions, faces).unwrap()
    }

    fn normals(mesh: &TriangleMesh, crease: f64) -> Vec<[f32; 3]> {
        corner_normals(mesh, mesh.positions(), &face_normals(mesh, mesh.positions()), crease)
    }

    #[test]
    fn sharp_edges_split_and_smooth_ones_join() {
        let mesh = cube();
        let sharp = normals(&mesh, 1.0);
        let faces = face_normals(&mesh, mesh.positions());
        for (c, n) in sharp.iter().enumerate() {
            assert!((0..3).all(|k| (n[k] as f64 - faces[c / 3][k]).abs() < 1e-6));
        }
        for (c, n) in normals(&mesh, 3.0).iter().enumerate() {
            let p = mesh.position(eikona_mesh::Vertex(mesh.triangles()[c / 3][c % 3]));
            // Each side has a right angle at each corner of the cube, however it is cut: the normal
            // is the diagonal.
            for k in 0..3 {
                assert!((n[k] as f64 - (p[k] * 2.0 - 1.0) / 3f64.sqrt()).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_flipped_face_keeps_the_same_line() {
        let mesh = cube();
        let flipped = mesh.with_flipped_faces(|f| f == Face(5));
        let (straight, turned) = (normals(&mesh, 3.0), normals(&flipped, 3.0));
        // Corner 0 of the flipped face stays corner 0.
        assert!((0..3).all(|k| (straight[15][k] + turned[15][k]).abs() < 1e-6));
        assert!((0..3).all(|k| (straight[0][k] - turned[0][k]).abs() < 1e-6));
    }
}
