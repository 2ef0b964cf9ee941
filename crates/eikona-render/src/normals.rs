//! Corner normals: angle-weighted averages over smoothly connected faces, split at creases.

use eikona_mesh::vector::{Vec3, add, cross, dot, norm, scale, sub, unit};
use eikona_mesh::{Orientation, TriangleMesh};

/// Returns unit face normals; zero for degenerate faces.
pub(crate) fn face_normals(mesh: &TriangleMesh, positions: &[Vec3]) -> Vec<Vec3> {
    mesh.triangles()
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            unit(cross(sub(b, a), sub(c, a)))
        })
        .collect()
}

/// Returns the front side of each face as a factor of its normal: +1 or -1, consistent between
/// neighbours, or 0 on nonorientable patches.
pub(crate) fn front_sides(mesh: &TriangleMesh) -> Vec<i8> {
    let orientation = Orientation::of(mesh);
    mesh.faces()
        .map(|face| {
            let patch = &orientation.patches[orientation.patch_of_face[face] as usize];
            if patch.is_orientable() { orientation.sign_of_face[face] } else { 0 }
        })
        .collect()
}

/// Returns three normals per face. Corners at a vertex share a normal if they are connected by
/// edges whose faces differ by at most `crease`. Faces of opposite orientation are connected too,
/// with opposite sign.
pub(crate) fn corner_normals(
    mesh: &TriangleMesh,
    positions: &[Vec3],
    face_normal: &[Vec3],
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
            let (root, flipped) = groups.find(3 * f + k);
            let weight = if flipped { -angle } else { angle };
            sum[root] = add(sum[root], scale(face_normal[f], weight));
        }
    }
    (0..mesh.halfedge_count())
        .map(|c| {
            let (root, flipped) = groups.find(c);
            let n = unit(sum[root]);
            let n = if n == [0.0; 3] { face_normal[c / 3] } else { n };
            n.map(|x| if flipped { -x } else { x } as f32)
        })
        .collect()
}

/// Union-find with a relative sign between each member and its root.
struct SignedGroups {
    parent: Vec<u32>,
    flipped: Vec<bool>,
}

impl SignedGroups {
    fn new(count: usize) -> Self {
        SignedGroups { parent: (0..count as u32).collect(), flipped: vec![false; count] }
    }
    fn find(&mut self, mut i: usize) -> (usize, bool) {
        let mut flipped = false;
        while self.parent[i] as usize != i {
            let p = self.parent[i] as usize;
            // Path halving: point to the grandparent.
            let (grandparent, parent_flipped) = (self.parent[p], self.flipped[p]);
            if grandparent as usize != p {
                self.parent[i] = grandparent;
                self.flipped[i] ^= parent_flipped;
            }
            flipped ^= self.flipped[i];
            i = self.parent[i] as usize;
        }
        (i, flipped)
    }
    fn join(&mut self, a: usize, b: usize, against: bool) {
        let ((ra, ta), (rb, tb)) = (self.find(a), self.find(b));
        if ra != rb {
            let (low, high) = (ra.min(rb), ra.max(rb));
            self.parent[high] = low as u32;
            self.flipped[high] = ta ^ tb ^ against;
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
    fn creases_split_normals() {
        let mesh = cube();
        let sharp = normals(&mesh, 1.0);
        let faces = face_normals(&mesh, mesh.positions());
        for (c, n) in sharp.iter().enumerate() {
            assert!((0..3).all(|k| (n[k] as f64 - faces[c / 3][k]).abs() < 1e-6));
        }
        for (c, n) in normals(&mesh, 3.0).iter().enumerate() {
            let p = mesh.position(eikona_mesh::Vertex(mesh.triangles()[c / 3][c % 3]));
            // The corner angles of each side add up to a right angle, however it is triangulated,
            // so the normal is the diagonal.
            for k in 0..3 {
                assert!((n[k] as f64 - (p[k] * 2.0 - 1.0) / 3f64.sqrt()).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn flipping_a_face_flips_its_normals_only() {
        let mesh = cube();
        let mesh_flipped = mesh.with_flipped_faces(|f| f == Face(5));
        let (straight, flipped) = (normals(&mesh, 3.0), normals(&mesh_flipped, 3.0));
        // Flipping keeps corner 0 in place.
        assert!((0..3).all(|k| (straight[15][k] + flipped[15][k]).abs() < 1e-6));
        assert!((0..3).all(|k| (straight[0][k] - flipped[0][k]).abs() < 1e-6));
    }
}
