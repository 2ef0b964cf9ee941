//! Seeded damage to a mesh, with a record of what was done: for tests of robustness and repair.
//!
//! The same mesh, amount and seed give the same damage. `share` is the fraction of faces hit:
//! `share` times the number of faces, rounded, drawn without repetition.
//! `share` times the number of faces, rounded, drawn without repetition.

use crate::error::MeshError;
use crate::field::{CornerField, VertexField};
use crate::id::{Corner, Face, Vertex};
use crate::mesh::TriangleMesh;
use crate::random::Random;
use crate::shapes::parameter::{require, require_share};
use crate::shapes::vector::{add, distance, lerp, scale, sub};

/// A damaged mesh and the origin of its elements.
#[derive(Clone, Debug)]
pub struct Damaged {
    /// The damaged mesh.
    pub mesh: TriangleMesh,
    /// The faces of the input that were hit (removed, flipped, copied, flattened), in increasing
    /// order; empty if the damage singles out no faces.
    pub hit: Vec<Face>,
    /// The input vertex of each vertex.
    pub source_vertex: VertexField<Vertex>,
    /// The input corner of each corner.
    pub source_corner: CornerField<Corner>,
}

impl Damaged {
    /// Returns the input face of a face.
    pub fn source_face(&self, face: Face) -> Face {
        self.source_corner[face.corner(0)].face()
    }
}

/// Moves each vertex at random by up to `amount` times its shortest edge.
///
/// The displacement is uniform in a ball. Below `amount` = 0.5 two neighbours cannot meet;
/// triangles may still flip. Isolated vertices stay.
///
/// # Errors
/// [`MeshError::Parameter`] if `amount` is not in [0, 100].
///
/// ```
/// use eikona_mesh::{damage::jitter, shapes::icosphere};
/// let sphere = icosphere(2)?;
/// let noisy = jitter(&sphere, 0.1, 1)?;
/// assert_ne!(noisy.positions(), sphere.positions());
/// assert_eq!(noisy.positions(), jitter(&sphere, 0.1, 1)?.positions());
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn jitter(mesh: &TriangleMesh, amount: f64, seed: u64) -> Result<TriangleMesh, MeshError> {
    jitter_with(mesh, amount, seed, &|p| p)
}

/// Jitters like [`jitter`], then applies `project` to each vertex, moved or not: for example back
/// onto the sphere, for noise along it.
///
/// As for [`jitter`]; [`MeshError::Invalid`] if `project` returns a position that is not finite.
///
/// ```
/// use eikona_mesh::{damage::jitter_with, shapes::icosphere};
/// let to_sphere = |p: [f64; 3]| p.map(|x| x / p[0].hypot(p[1]).hypot(p[2]));
/// let noisy = jitter_with(&icosphere(2)?, 0.2, 1, &to_sphere)?;
/// assert!(noisy.positions().iter().all(|p| (p[0].hypot(p[1]).hypot(p[2]) - 1.0).abs() < 1e-15));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn jitter_with(
    mesh: &TriangleMesh,
    amount: f64,
    seed: u64,
    project: &dyn Fn([f64; 3]) -> [f64; 3],
) -> Result<TriangleMesh, MeshError> {
    require((0.0..=100.0).contains(&amount), "amount", amount, "it must lie between 0 and 100 edge lengths")?;
    let mut shortest = vec![f64::INFINITY; mesh.vertex_count()];
    for e in mesh.edges() {
        let ends = mesh.edge_vertices(e);
        let length = distance(mesh.position(ends[0]), mesh.position(ends[1]));
        for v in ends {
            shortest[v.index()] = shortest[v.index()].min(length);
        }
    }
    let mut random = Random::from_seed(seed);
    let moved = mesh.positions().iter().zip(&shortest).map(|(&p, &edge)| {
        // Drawn for every vertex, so that isolated vertices do not change the noise of the others.
        let step = random.in_unit_ball();
        project(if edge.is_finite() { add(p, scale(step, amount * edge)) } else { p })
    });
    mesh.with_positions(moved.collect())
}

/// Removes a share of the faces, and the vertices that only those used.
///
/// # Errors
/// [`MeshError::Parameter`] if `share` is not in [0, 1].
///
/// ```
/// use eikona_mesh::{damage::remove_faces, shapes::icosphere};
/// let torn = remove_faces(&icosphere(2)?, 0.1, 1)?;
/// assert_eq!((torn.mesh.face_count(), torn.hit.len()), (288, 32));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn remove_faces(mesh: &TriangleMesh, share: f64, seed: u64) -> Result<Damaged, MeshError> {
    let hit = choose_faces(mesh, share, seed)?;
    without_faces(mesh, hit)
}

/// Removes `count` round patches: each a random face with all faces within `rings` steps across
/// shared vertices.
///
/// Patches may touch or overlap, so the boundary gains at most `count` loops.
///
/// # Errors
/// [`MeshError::Parameter`] if there are fewer faces than holes.
///
/// ```
/// use eikona_mesh::{damage::holes, shapes::icosphere};
/// let torn = holes(&icosphere(3)?, 1, 1, 5)?;
/// assert!((12..=13).contains(&torn.hit.len())); // a face and those that share a vertex with it
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn holes(mesh: &TriangleMesh, count: usize, rings: usize, seed: u64) -> Result<Damaged, MeshError> {
    require(count <= mesh.face_count(), "count", count, "there cannot be more holes than faces")?;
    let mut removed = vec![false; mesh.face_count()];
    let mut front: Vec<Face> = Vec::new();
    for i in Random::from_seed(seed).choose(count, mesh.face_count()) {
        removed[i] = true;
        front.push(Face(i as u32));
    }
    let mut visited = vec![false; mesh.vertex_count()];
    for _ in 0..rings {
        let mut next = Vec::new();
        for v in front.iter().flat_map(|&f| mesh.face_vertices(f)) {
            if std::mem::replace(&mut visited[v.index()], true) {
                continue;
            }
            for f in mesh.vertex_corners(v).iter().map(|c| c.face()) {
                if !std::mem::replace(&mut removed[f.index()], true) {
                    next.push(f);
                }
            }
        }
        if next.is_empty() {
            break;
        }
        front = next;
    }
    without_faces(mesh, mesh.faces().filter(|f| removed[f.index()]).collect())
}

/// Flips a share of the faces: swaps their second and third corners.
///
/// # Errors
/// [`MeshError::Parameter`] if `share` is not in [0, 1].
///
/// ```
/// use eikona_mesh::{damage::flip_faces, shapes::icosphere};
/// let sphere = icosphere(1)?;
/// let mixed = flip_faces(&sphere, 0.25, 1)?;
/// let pairs = mixed.mesh.triangles().iter().zip(sphere.triangles());
/// let flipped = pairs.filter(|(a, b)| a != b).count();
/// assert_eq!(flipped, 20);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn flip_faces(mesh: &TriangleMesh, share: f64, seed: u64) -> Result<Damaged, MeshError> {
    let hit = choose_faces(mesh, share, seed)?;
    let mut corners = all_corners(mesh);
    for &f in &hit {
        corners.swap(f.corner(1).index(), f.corner(2).index());
    }
    with_corners(mesh, corners, hit)
}

/// Duplicates a share of the faces. The copies follow all other faces, in the order of `hit`, with
/// the same orientation.
///
/// # Errors
/// [`MeshError::Parameter`] if `share` is not in [0, 1].
///
/// ```
/// use eikona_mesh::{damage::duplicate_faces, shapes::icosphere};
/// let doubled = duplicate_faces(&icosphere(1)?, 0.5, 1)?;
/// assert_eq!(doubled.mesh.face_count(), 80 + 40);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn duplicate_faces(mesh: &TriangleMesh, share: f64, seed: u64) -> Result<Damaged, MeshError> {
    let hit = choose_faces(mesh, share, seed)?;
    let mut corners = all_corners(mesh);
    corners.extend(hit.iter().flat_map(|f| [0, 1, 2].map(|k| f.corner(k))));
    with_corners(mesh, corners, hit)
}

/// Renumbers the vertices, the faces, and the corners within each face at random. The surface and
/// its orientation stay the same.
///
/// # Errors
/// None for a mesh that exists.
///
/// ```
/// use eikona_mesh::{damage::shuffle, shapes::icosphere, Face, Vertex};
/// let sphere = icosphere(1)?;
/// let shuffled = shuffle(&sphere, 1)?;
/// let old = shuffled.source_vertex[Vertex(5)];
/// assert_eq!(shuffled.mesh.position(Vertex(5)), sphere.position(old));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn shuffle(mesh: &TriangleMesh, seed: u64) -> Result<Damaged, MeshError> {
    let mut random = Random::from_seed(seed);
    let mut source_vertex: Vec<Vertex> = mesh.vertices().collect();
    random.shuffle(&mut source_vertex);
    let mut number = vec![0u32; mesh.vertex_count()];
    for (new, old) in source_vertex.iter().enumerate() {
        number[old.index()] = new as u32;
    }
    let mut order: Vec<Face> = mesh.faces().collect();
    random.shuffle(&mut order);
    let mut source_corner = Vec::with_capacity(mesh.halfedge_count());
    for f in order {
        let turn = random.below(3);
        source_corner.extend([0, 1, 2].map(|k| f.corner((k + turn) % 3)));
    }
    let faces = triples(&source_corner, |c| number[mesh.corner_vertex(c).index()]);
    let positions = source_vertex.iter().map(|&v| mesh.position(v)).collect();
    Ok(Damaged {
        mesh: TriangleMesh::new(positions, faces)?,
        hit: Vec::new(),
        source_vertex: source_vertex.into(),
        source_corner: source_corner.into(),
    })
}

/// Separates all faces into a triangle soup: corner k of face f gets its own vertex 3 f + k.
/// Unreferenced vertices are dropped.
///
/// # Errors
/// [`MeshError::TooLarge`] if there are more corners than vertex indices.
///
/// ```
/// use eikona_mesh::{damage::unweld, shapes::icosphere};
/// let soup = unweld(&icosphere(1)?)?;
/// assert_eq!((soup.mesh.vertex_count(), soup.mesh.edge_count()), (240, 240));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn unweld(mesh: &TriangleMesh) -> Result<Damaged, MeshError> {
    let source_corner = all_corners(mesh);
    let source_vertex: Vec<Vertex> = source_corner.iter().map(|&c| mesh.corner_vertex(c)).collect();
    let positions = source_vertex.iter().map(|&v| mesh.position(v)).collect();
    let faces = triples(&source_corner, |c| c.0);
    Ok(Damaged {
        mesh: TriangleMesh::new(positions, faces)?,
        hit: Vec::new(),
        source_vertex: source_vertex.into(),
        source_corner: source_corner.into(),
    })
}

/// Makes slivers: in each face hit, moves a random corner towards a point in the middle half of the
/// opposite edge, so that its height shrinks by the factor `height` (0.001, say; 0 makes faces of
/// zero area).
///
/// The other faces at the moved vertex grow. No two faces hit share a vertex, so fewer faces are
/// hit than a large `share` asks for; `hit` lists them.
///
/// # Errors
/// [`MeshError::Parameter`] if `share` or `height` is not in [0, 1].
///
/// ```
/// use eikona_mesh::{damage::sliver_faces, shapes::icosphere};
/// let thin = sliver_faces(&icosphere(3)?, 0.01, 1e-4, 1)?;
/// assert_eq!(thin.hit.len(), 13);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn sliver_faces(mesh: &TriangleMesh, share: f64, height: f64, seed: u64) -> Result<Damaged, MeshError> {
    require_share("share", share)?;
    require_share("height", height)?;
    let wanted = share_of(mesh, share);
    let mut random = Random::from_seed(seed);
    let mut order: Vec<Face> = mesh.faces().collect();
    random.shuffle(&mut order);
    let mut taken = vec![false; mesh.vertex_count()];
    let mut positions = mesh.positions().to_vec();
    let mut hit = Vec::with_capacity(wanted);
    for f in order {
        if hit.len() == wanted {
            break;
        }
        let vertices = mesh.face_vertices(f);
        if vertices.iter().any(|v| taken[v.index()]) {
            continue;
        }
        for v in vertices {
            taken[v.index()] = true;
        }
        let p = mesh.face_positions(f);
        let k = random.below(3);
        let foot = lerp(p[(k + 1) % 3], p[(k + 2) % 3], random.range(0.25, 0.75));
        positions[vertices[k].index()] = add(foot, scale(sub(p[k], foot), height));
        hit.push(f);
    }
    hit.sort_unstable();
    Ok(Damaged {
        mesh: mesh.with_positions(positions)?,
        hit,
        source_vertex: mesh.vertices().collect::<Vec<_>>().into(),
        source_corner: all_corners(mesh).into(),
    })
}

fn share_of(mesh: &TriangleMesh, share: f64) -> usize {
    (share * mesh.face_count() as f64).round() as usize
}

fn choose_faces(mesh: &TriangleMesh, share: f64, seed: u64) -> Result<Vec<Face>, MeshError> {
    require_share("share", share)?;
    let chosen = Random::from_seed(seed).choose(share_of(mesh, share), mesh.face_count());
    Ok(chosen.into_iter().map(|i| Face(i as u32)).collect())
}

fn all_corners(mesh: &TriangleMesh) -> Vec<Corner> {
    (0..mesh.halfedge_count() as u32).map(Corner).collect()
}

/// Groups corners three at a time into faces.
fn triples(corners: &[Corner], number: impl Fn(Corner) -> u32) -> Vec<[u32; 3]> {
    corners.chunks_exact(3).map(|c| [number(c[0]), number(c[1]), number(c[2])]).collect()
}

/// Builds the mesh with the same vertices whose corners are these corners of the input.
fn with_corners(mesh: &TriangleMesh, corners: Vec<Corner>, hit: Vec<Face>) -> Result<Damaged, MeshError> {
    let faces = triples(&corners, |c| mesh.corner_vertex(c).0);
    Ok(Damaged {
        mesh: TriangleMesh::new(mesh.positions().to_vec(), faces)?,
        hit,
        source_vertex: mesh.vertices().collect::<Vec<_>>().into(),
        source_corner: corners.into(),
    })
}

/// Removes these faces and the vertices that only they used.
fn without_faces(mesh: &TriangleMesh, hit: Vec<Face>) -> Result<Damaged, MeshError> {
    let mut removed = vec![false; mesh.face_count()];
    for f in &hit {
        removed[f.index()] = true;
    }
    let corners: Vec<Corner> = all_corners(mesh).into_iter().filter(|c| !removed[c.face().index()]).collect();
    let stays = |v: &Vertex| {
        let mut faces = mesh.vertex_corners(*v).iter().map(|c| c.face().index());
        mesh.vertex_corners(*v).is_empty() || faces.any(|f| !removed[f])
    };
    let source_vertex: Vec<Vertex> = mesh.vertices().filter(stays).collect();
    let mut number = vec![0u32; mesh.vertex_count()];
    for (new, old) in source_vertex.iter().enumerate() {
        number[old.index()] = new as u32;
    }
    let faces = triples(&corners, |c| number[mesh.corner_vertex(c).index()]);
    let positions = source_vertex.iter().map(|&v| mesh.position(v)).collect();
    Ok(Damaged {
        mesh: TriangleMesh::new(positions, faces)?,
        hit,
        source_vertex: source_vertex.into(),
        source_corner: corners.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::vector::{cross, norm};
    use crate::shapes::{icosphere, torus};

    fn area(mesh: &TriangleMesh, f: Face) -> f64 {
        let [a, b, c] = mesh.face_positions(f);
        0.5 * norm(cross(sub(b, a), sub(c, a)))
    }

    fn check(f: fn(&TriangleMesh, u64) -> Result<Damaged, MeshError>) -> [Damaged; 2] {
        let mesh = torus(1.0, 0.4, 30, 12).unwrap();
        let [one, again, other] = [5, 5, 6].map(|seed| f(&mesh, seed).unwrap());
        assert_eq!(one.mesh.positions(), again.mesh.positions());
        assert_eq!(one.mesh.triangles(), again.mesh.triangles());
        let differs =
            one.mesh.triangles() != other.mesh.triangles() || one.mesh.positions() != other.mesh.positions();
        assert!(differs, "another seed gives the same damage");
        for damaged in [&one, &other] {
            assert_eq!(damaged.source_vertex.len(), damaged.mesh.vertex_count());
            assert_eq!(damaged.source_corner.len(), damaged.mesh.halfedge_count());
            for (c, &source) in damaged.source_corner.iter() {
                // The maps of corners and of vertices agree.
                assert_eq!(damaged.source_vertex[damaged.mesh.corner_vertex(c)], mesh.corner_vertex(source));
            }
            assert!(damaged.hit.windows(2).all(|w| w[0] < w[1]));
        }
        [one, other]
    }

    #[test]
    fn damage_depends_on_the_seed_and_its_maps_are_correct() {
        for d in check(|m, s| remove_faces(m, 0.4, s)) {
            assert_eq!((d.hit.len(), d.mesh.face_count()), (288, 432));
            assert!(d.mesh.vertices().all(|v| !d.mesh.vertex_corners(v).is_empty()));
            assert!(d.mesh.faces().all(|f| d.hit.binary_search(&d.source_face(f)).is_err()));
        }
        for d in check(|m, s| flip_faces(m, 0.1, s)) {
            let flipped = |f: Face| d.source_corner[f.corner(1)] != f.corner(1);
            assert_eq!(d.mesh.faces().filter(|&f| flipped(f)).collect::<Vec<_>>(), d.hit);
            assert_eq!(d.hit.len(), 72);
        }
        for d in check(|m, s| duplicate_faces(m, 0.1, s)) {
            assert_eq!(d.mesh.face_count(), 720 + 72);
            let copies: Vec<Face> = d.mesh.faces().skip(720).map(|f| d.source_face(f)).collect();
            assert_eq!(copies, d.hit);
        }
        for d in check(|m, s| holes(m, 3, 2, s)) {
            assert!(d.hit.len() > 30 && d.mesh.face_count() + d.hit.len() == 720);
        }
        check(shuffle);
        check(|m, s| sliver_faces(m, 0.02, 0.01, s));
    }

    #[test]
    fn maps_undo_a_shuffle() {
        let mesh = torus(1.0, 0.4, 9, 7).unwrap();
        let d = shuffle(&mesh, 11).unwrap();
        let mut positions = vec![[f64::NAN; 3]; mesh.vertex_count()];
        for (new, old) in d.source_vertex.iter() {
            positions[old.index()] = d.mesh.position(new);
        }
        assert_eq!(positions, mesh.positions());
        let mut faces = vec![[u32::MAX; 3]; mesh.face_count()];
        for (new, old) in d.source_corner.iter() {
            let place = old.halfedge();
            faces[place.face().index()][place.side()] = d.source_vertex[d.mesh.corner_vertex(new)].0;
        }
        assert_eq!(faces, mesh.triangles());
        assert_eq!(d.mesh.edge_count(), mesh.edge_count());
    }

    #[test]
    fn jitter_moves_every_vertex_within_its_bound() {
        let sphere = icosphere(3).unwrap();
        let noisy = jitter(&sphere, 0.2, 4).unwrap();
        for v in sphere.vertices() {
            let shortest = sphere
                .vertex_corners(v)
                .iter()
                .map(|c| distance(sphere.position(v), sphere.position(sphere.tip(c.halfedge()))))
                .fold(f64::MAX, f64::min);
            let step = distance(sphere.position(v), noisy.position(v));
            assert!(step > 0.0 && step <= 0.2 * shortest * (1.0 + 1e-12));
        }
        assert_ne!(noisy.positions(), jitter(&sphere, 0.2, 5).unwrap().positions());
        assert_eq!(sphere.positions(), jitter(&sphere, 0.0, 5).unwrap().positions());
        assert!(jitter_with(&sphere, 0.1, 1, &|_| [f64::NAN; 3]).is_err());
    }

    #[test]
    fn slivers_have_the_requested_height() {
        let sphere = icosphere(3).unwrap();
        let d = sliver_faces(&sphere, 0.02, 1e-3, 9).unwrap();
        assert_eq!(d.hit.len(), 26);
        for &f in &d.hit {
            assert!((area(&d.mesh, f) / area(&sphere, f) - 1e-3).abs() < 1e-9);
        }
        let all = sliver_faces(&sphere, 1.0, 0.0, 9).unwrap();
        assert!(all.hit.len() < 1280 / 3 && all.hit.iter().all(|&f| area(&all.mesh, f) < 1e-15));
    }

    #[test]
    fn shares_out_of_range_are_errors_and_empty_meshes_are_not() {
        let empty = TriangleMesh::new(vec![], vec![]).unwrap();
        let sphere = icosphere(0).unwrap();
        for share in [-0.1, 1.1, f64::NAN] {
            assert!(remove_faces(&sphere, share, 0).is_err());
            assert!(flip_faces(&sphere, share, 0).is_err());
            assert!(duplicate_faces(&sphere, share, 0).is_err());
            assert!(sliver_faces(&sphere, share, 0.1, 0).is_err());
            assert!(sliver_faces(&sphere, 0.1, share, 0).is_err());
            assert!(jitter(&sphere, -share.abs(), 0).is_err());
        }
        assert!(holes(&sphere, 21, 1, 0).is_err());
        assert_eq!(holes(&sphere, 20, usize::MAX, 0).unwrap().mesh.vertex_count(), 0);
        for result in [
            remove_faces(&empty, 1.0, 0),
            flip_faces(&empty, 1.0, 0),
            duplicate_faces(&empty, 1.0, 0),
            sliver_faces(&empty, 1.0, 0.0, 0),
            shuffle(&empty, 0),
            unweld(&empty),
            holes(&empty, 0, 3, 0),
        ] {
            assert_eq!(result.unwrap().mesh.face_count(), 0);
        }
        let all_gone = remove_faces(&sphere, 1.0, 0).unwrap();
        assert_eq!((all_gone.mesh.vertex_count(), all_gone.mesh.face_count()), (0, 0));
    }
}
