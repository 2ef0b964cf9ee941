//! Small surfaces of every topology and random prescriptions on them, for tests.

use crate::polar_field::{Place, Singularity};
use eikona_mesh::random::Random;
use eikona_mesh::shapes::Hole;
use eikona_mesh::{Face, SurfacePoint, Topology, TriangleMesh, damage, shapes};

/// Returns surfaces of 1 to 130 faces. No two edges have the same length, except on the simplest
/// ones.
pub(crate) fn surfaces() -> Vec<(&'static str, TriangleMesh)> {
    let rough = |mesh: TriangleMesh, seed: u64| damage::jitter(&mesh, 0.15, seed).unwrap();
    let holes =
        [Hole::Disk { centre: [1.0, 1.1], radius: 0.4 }, Hole::Disk { centre: [2.1, 1.0], radius: 0.4 }];
    let sphere = rough(shapes::icosphere(1).unwrap(), 1);
    let annulus = rough(shapes::annulus(1.0, 2.0, 2, 9).unwrap(), 3);
    vec![
        (
            "triangle",
            TriangleMesh::new(vec![[0., 0., 0.], [2., 0., 0.], [0.5, 1., 0.3]], vec![[0, 1, 2]]).unwrap(),
        ),
        ("two triangles", shapes::strip(1, 1).unwrap()),
        ("strip", rough(shapes::strip(7, 1).unwrap(), 4)),
        ("tetrahedron", shapes::tetrahedron().unwrap()),
        ("disk", rough(shapes::disk(3, 6, 1.0).unwrap(), 5)),
        ("two holes", rough(shapes::grid_with_holes(9, 6, 3.0, 2.0, &holes).unwrap(), 6)),
        ("torus", rough(shapes::torus(1.0, 0.4, 8, 4).unwrap(), 2)),
        ("double torus", rough(double_torus(), 7)),
        ("sphere and annulus", together(&sphere, &annulus)),
        ("sphere", sphere),
        ("annulus", annulus),
    ]
}

/// Two meshes as components of one.
pub(crate) fn together(first: &TriangleMesh, second: &TriangleMesh) -> TriangleMesh {
    let shift = first.vertex_count() as u32;
    let moved = second.positions().iter().map(|p| [p[0] + 5.0, p[1], p[2]]);
    let faces = second.triangles().iter().map(|f| f.map(|v| v + shift));
    TriangleMesh::new(
        first.positions().iter().copied().chain(moved).collect(),
        first.triangles().iter().copied().chain(faces).collect(),
    )
    .unwrap()
}

/// A torus and its mirror image, joined by a prism in place of a face of each.
fn double_torus() -> TriangleMesh {
    let torus = shapes::torus(1.0, 0.45, 6, 3).unwrap();
    let shift = torus.vertex_count() as u32;
    let mirrored = torus.positions().iter().map(|p| [3.5 - p[0], p[1], p[2]]);
    let positions = torus.positions().iter().copied().chain(mirrored).collect();
    let mut faces = torus.triangles()[1..].to_vec();
    faces.extend(torus.triangles()[1..].iter().map(|&[a, b, c]| [b + shift, a + shift, c + shift]));
    let removed = torus.triangles()[0];
    for k in 0..3 {
        let [a, b] = [removed[k], removed[(k + 1) % 3]];
        faces.extend([[a, b, b + shift], [a, b + shift, a + shift]]);
    }
    TriangleMesh::new(positions, faces).unwrap()
}

/// Returns singularities of random kinds, places and indices that add up to the Euler
/// characteristic of each component. No two are in faces with a common vertex, unless `crowded`.
pub(crate) fn prescription(
    mesh: &TriangleMesh,
    degree: u32,
    crowded: bool,
    random: &mut Random,
) -> Vec<Singularity> {
    let topology = Topology::of(mesh);
    let mut used = vec![false; mesh.vertex_count()];
    let mut given = Vec::new();
    for (c, component) in topology.components.iter().enumerate() {
        let faces: Vec<Face> =
            mesh.faces().filter(|f| topology.component_of_face[*f] as usize == c).collect();
        let wanted = 1 + random.below(4);
        let mut places = Vec::new();
        for _ in 0..40 {
            let face = faces[random.below(faces.len())];
            let taken = mesh.face_vertices(face).iter().any(|v| used[v.index()]);
            if places.len() < wanted
                && (crowded || !taken)
                && let Some(point) = point_at(mesh, face, random)
            {
                mesh.face_vertices(face).iter().for_each(|v| used[v.index()] = true);
                places.push(Place::Point(point));
            }
        }
        let of_component = |b: &usize| topology.boundary_loops[*b].component as usize == c;
        places.extend((0..topology.boundary_loops.len()).filter(of_component).map(Place::Boundary));
        let mut missing = component.euler_characteristic * i64::from(degree);
        for (i, &place) in places.iter().enumerate() {
            let last = i + 1 == places.len();
            let turns = if last { missing } else { [1, -1, 2, -2][random.below(4)] };
            missing -= turns;
            given.push(Singularity { place, index: turns as f64 / f64::from(degree) });
        }
    }
    given
}

/// Returns a random point of a face, on one of its edges or at one of its vertices; `None` if that
/// is on the boundary.
fn point_at(mesh: &TriangleMesh, face: Face, random: &mut Random) -> Option<SurfacePoint> {
    let mut vertices = mesh.face_vertices(face);
    vertices.rotate_left(random.below(3));
    let [a, b, _] = vertices;
    let ids = vertices.map(|v| v.0);
    match random.below(3) {
        0 => (!mesh.is_boundary_vertex(a)).then_some(SurfacePoint::Vertex { vertex: a.0 }),
        1 => {
            let edge = mesh.find_edge(a, b)?;
            let t = random.range(0.15, 0.85);
            (!mesh.is_boundary_edge(edge)).then_some(SurfacePoint::Edge { vertices: [ids[0], ids[1]], t })
        }
        _ => {
            let weights = [0; 3].map(|_| random.range(0.2, 1.0));
            let sum: f64 = weights.iter().sum();
            Some(SurfacePoint::Face { vertices: ids, bary: weights.map(|w| w / sum) })
        }
    }
}
