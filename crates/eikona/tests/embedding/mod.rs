//! Properties of every mesh cut along curves, and small meshes to cut.

use eikona::cut::{Embedded, embed_curves};
use eikona_mesh::{
    Curve, Face, FaceField, Located, SurfaceCurves, SurfacePoint, Topology, TriangleMesh, Vertex,
};
use std::collections::{BTreeMap, BTreeSet};

pub type Vec3 = [f64; 3];

pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [0, 1, 2].map(|k| a[k] - b[k])
}
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}
pub fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}
pub fn normal(mesh: &TriangleMesh, f: Face) -> Vec3 {
    let [a, b, c] = mesh.face_positions(f);
    let (u, v) = (sub(b, a), sub(c, a));
    [0, 1, 2].map(|k| 0.5 * (u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]))
}
pub fn largest_coordinate(mesh: &TriangleMesh) -> f64 {
    mesh.positions().iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()))
}
pub fn longest_side(mesh: &TriangleMesh, f: Face) -> f64 {
    let p = mesh.face_positions(f);
    (0..3).map(|k| norm(sub(p[k], p[(k + 1) % 3]))).fold(0.0, f64::max)
}

/// Returns invariants of a surface under cutting into smaller faces.
pub fn shape_of_surface(mesh: &TriangleMesh) -> impl PartialEq + std::fmt::Debug {
    let t = Topology::of(mesh);
    let of_component = |c: &eikona_mesh::Component| {
        (c.euler_characteristic, c.manifold, c.orientable, c.genus, c.nonorientable_genus)
    };
    let components: Vec<_> = t.components.iter().map(of_component).collect();
    let fans: Vec<_> =
        t.nonmanifold_vertices.iter().filter(|v| v.fans > 2).map(|v| (v.vertex, v.fans)).collect();
    let loops = if t.nonmanifold_edges.is_empty() { t.boundary_loops.len() } else { 0 };
    (
        t.euler_characteristic,
        t.sheet_count,
        components,
        t.boundary_component_count,
        loops,
        fans,
        t.unreferenced_vertices,
    )
}

/// Returns the total lengths of the edges with one face, and with more than two.
pub fn lengths_of_odd_edges(mesh: &TriangleMesh) -> [f64; 2] {
    let mut lengths = [0.0; 2];
    for e in mesh.edges() {
        let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
        match mesh.edge_halfedges(e).len() {
            1 => lengths[0] += norm(sub(a, b)),
            2 => {}
            _ => lengths[1] += norm(sub(a, b)),
        }
    }
    lengths
}

/// Checks the properties of every cut mesh. `merged` is how far nodes may have moved, as a share of
/// the mesh.
pub fn check(name: &str, input: &TriangleMesh, curves: &SurfaceCurves, cut: &Embedded, merged: f64) {
    let (mesh, size) = (&cut.mesh, largest_coordinate(input));
    let close = 1e-12 * size;
    // Vertices.
    assert_eq!(mesh.positions()[..input.vertex_count()], *input.positions(), "{name}");
    for v in mesh.vertices() {
        let place = cut.provenance.vertex_place(v).unwrap().locate(input).unwrap();
        if v.index() < input.vertex_count() {
            assert_eq!(place, Located::Vertex(v));
        }
        let off = norm(sub(place.position(input), mesh.position(v)));
        assert!(off <= close, "{name}: {v} lies {off} from its place");
    }
    // Faces.
    let parents: Vec<Face> = cut.provenance.face_parents().collect();
    assert_eq!(parents.len(), mesh.face_count());
    let inside: BTreeSet<[Vertex; 3]> = mesh
        .vertices()
        .filter_map(|v| match cut.provenance.vertex_place(v).unwrap().locate(input).unwrap() {
            Located::Face(f, _) => Some(input.face_vertices(f)),
            _ => None,
        })
        .collect();
    let mut first = 0;
    for (i, pieces) in parents.chunk_by(|a, b| a == b).enumerate() {
        let parent = Face(i as u32);
        assert_eq!(pieces[0], parent, "{name}: every face has pieces, in order");
        let of_parent = normal(input, parent);
        let (area, side) = (norm(of_parent), longest_side(input, parent));
        let mut sum = 0.0;
        for piece in first..first + pieces.len() {
            let piece = Face(piece as u32);
            let of_piece = normal(mesh, piece);
            sum += norm(of_piece);
            let signed = dot(of_piece, of_parent) / area.max(f64::MIN_POSITIVE);
            assert!(
                signed >= -1e-14 * side * size || area < 1e-8 * side * side,
                "{name}: {piece} of {parent}"
            );
        }
        if pieces.len() == 1 {
            assert_eq!(mesh.triangles()[first], input.triangles()[parent.index()], "{name}: untouched");
            assert!(!inside.contains(&input.face_vertices(parent)));
        }
        // Coordinates have an error of 1e-16 of the mesh, which accumulates along the sides.
        let allowed = 1e-12 * area + 4e-16 * size * side * pieces.len() as f64;
        let flat = area < 1e-6 * side * side;
        assert!((sum - area).abs() <= allowed || flat, "{name}: {parent} has area {area}, its pieces {sum}");
        first += pieces.len();
    }
    assert_eq!(parents.last().map_or(0, |f| f.index() + 1), input.face_count());
    assert_eq!(
        format!("{:?}", shape_of_surface(mesh)),
        format!("{:?}", shape_of_surface(input)),
        "{name}: the surface has changed"
    );
    let (a, b) = (lengths_of_odd_edges(mesh), lengths_of_odd_edges(input));
    assert!((0..2).all(|k| (a[k] - b[k]).abs() <= 1e-11 * b[k]), "{name}: boundary {a:?} {b:?}");
    // Curves.
    assert_eq!(cut.curves.len(), curves.curves.len());
    let mut multiplicity: BTreeMap<[Vertex; 2], i64> = BTreeMap::new();
    for (c, (path, curve)) in cut.curves.iter().zip(&curves.curves).enumerate() {
        let at = |p: &SurfacePoint| p.locate(input).unwrap().position(input);
        let moved = merged * size + close;
        let nodes: Vec<Vec3> = curve.nodes.iter().map(at).collect();
        assert_eq!(path.segments.len() + 1, path.vertices.len());
        assert!(path.segments.is_sorted(), "{name}, curve {c}");
        let ends = [path.vertices[0], path.vertices[path.vertices.len() - 1]].map(|v| mesh.position(v));
        assert!(norm(sub(ends[0], nodes[0])) <= moved && norm(sub(ends[1], nodes[nodes.len() - 1])) <= moved);
        if curve.is_closed() && path.vertices.len() > 1 {
            assert!(path.is_closed(), "{name}, curve {c}");
        }
        let mut walked = vec![0.0; nodes.len()];
        for (step, &segment) in path.vertices.windows(2).zip(&path.segments) {
            let edge = mesh.find_edge(step[0], step[1]);
            let edge = edge.unwrap_or_else(|| panic!("{name}, curve {c}: {step:?} is no edge"));
            let forward = mesh.edge_vertices(edge)[0] == step[0];
            *multiplicity.entry(mesh.edge_vertices(edge)).or_default() += if forward { 1 } else { -1 };
            let [p, q] = [step[0], step[1]].map(|v| mesh.position(v));
            walked[segment] += norm(sub(p, q));
            // On the segment: the distances to both ends sum to its length.
            let (a, b) = (nodes[segment], nodes[segment + 1]);
            let detour = norm(sub(a, q)) + norm(sub(q, b)) - norm(sub(a, b));
            assert!(detour <= close + 2.0 * moved, "{name}, curve {c}, segment {segment}: {detour}");
        }
        for (segment, pair) in nodes.windows(2).enumerate() {
            let length = norm(sub(pair[0], pair[1]));
            let off = (walked[segment] - length).abs();
            let allowed = 1e-12 * length + 1e-15 * size * 8.0 + 4.0 * merged * size;
            assert!(
                off <= allowed,
                "{name}, curve {c}, segment {segment}: {length}, walked {}",
                walked[segment]
            );
        }
        let (length, total): (f64, f64) =
            (nodes.windows(2).map(|p| norm(sub(p[0], p[1]))).sum(), walked.iter().sum());
        let allowed = 1e-12 * length.max(size) + 4.0 * merged * size * nodes.len() as f64;
        assert!((length - total).abs() <= allowed, "{name}, curve {c}: {length}, walked {total}");
    }
    // The chain.
    let chain = cut.chain();
    for e in mesh.edges() {
        let expected = multiplicity.get(&mesh.edge_vertices(e)).copied().unwrap_or(0);
        assert_eq!(chain.multiplicities[e], expected, "{name}");
    }
    assert_eq!(chain.edges.len(), multiplicity.len());
    let walks: usize = chain.edges.iter().map(|e| e.walks.len()).sum();
    assert_eq!(walks, cut.curves.iter().map(|c| c.segments.len()).sum::<usize>());
    // Its boundary is that of the curves.
    let mut degree: BTreeMap<Vertex, i64> = BTreeMap::new();
    for e in &chain.edges {
        let [a, b] = mesh.edge_vertices(e.edge);
        *degree.entry(a).or_default() -= e.multiplicity;
        *degree.entry(b).or_default() += e.multiplicity;
    }
    for path in &cut.curves {
        *degree.entry(path.vertices[0]).or_default() += 1;
        *degree.entry(path.vertices[path.vertices.len() - 1]).or_default() -= 1;
    }
    assert!(degree.values().all(|&d| d == 0), "{name}");
    // Isolated points.
    assert_eq!(cut.points.len(), curves.points.len());
    for (v, point) in cut.points.iter().zip(&curves.points) {
        let off = norm(sub(mesh.position(*v), point.locate(input).unwrap().position(input)));
        assert!(off <= merged * size + close);
    }
    // Fields.
    let ones = cut.field_to_input_faces(&FaceField::constant(mesh.face_count(), 3.0)).unwrap();
    assert!(ones.as_slice().iter().all(|x| (x - 3.0).abs() < 1e-11));
    assert_eq!(ones.len(), input.face_count());
    assert_eq!(cut.labels_to_input_faces(&parents.into()).unwrap(), input.faces().collect::<Vec<_>>().into());
}

pub fn embed(name: &str, mesh: &TriangleMesh, curves: Vec<Curve>) -> Embedded {
    embed_with(name, mesh, &SurfaceCurves { curves, points: Vec::new() }, 0.0)
}

pub fn embed_with(name: &str, mesh: &TriangleMesh, curves: &SurfaceCurves, merged: f64) -> Embedded {
    let cut = embed_curves(mesh, curves).unwrap_or_else(|e| panic!("{name}: {e}"));
    check(name, mesh, curves, &cut, merged);
    cut
}

pub fn edge(a: u32, b: u32, t: f64) -> SurfacePoint {
    SurfacePoint::Edge { vertices: [a, b], t }
}
pub fn inside(vertices: [u32; 3], b: f64, c: f64) -> SurfacePoint {
    SurfacePoint::Face { vertices, bary: [1.0 - b - c, b, c] }
}

/// Two triangles over the unit square, 0 1 2 and 0 2 3.
pub fn square() -> TriangleMesh {
    flat_square([[0, 1, 2], [0, 2, 3]])
}
pub fn flat_square(faces: [[u32; 3]; 2]) -> TriangleMesh {
    let corners = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    TriangleMesh::new(corners, faces.to_vec()).unwrap()
}

/// Two faces with the same corners: a sphere of two triangles.
pub fn pillow() -> TriangleMesh {
    let corners = vec![[0., 0., 0.], [1., 0., 0.], [0.2, 1., 0.]];
    TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 1]]).unwrap()
}

/// Returns the lowest height of a new face, in an equilateral parent with sides of length 1.
pub fn lowest_height(mesh: &TriangleMesh, cut: &Embedded) -> f64 {
    let mut lowest = f64::INFINITY;
    for f in cut.mesh.faces() {
        let parent = cut.provenance.face_parent(f);
        let weights = cut.mesh.face_vertices(f).map(|v| {
            cut.provenance.vertex_place(v).unwrap().locate(mesh).unwrap().weights_in_face(mesh, parent)
        });
        // A place inside one of two faces with the same corners is located in the first.
        let [Some(a), Some(b), Some(c)] = weights else { continue };
        let flat = |w: Vec3| [w[1] + 0.5 * w[2], 0.75f64.sqrt() * w[2], 0.0];
        let p = [a, b, c].map(flat);
        let (u, v) = (sub(p[1], p[0]), sub(p[2], p[0]));
        let longest = (0..3).map(|k| norm(sub(p[k], p[(k + 1) % 3]))).fold(0.0, f64::max);
        lowest = lowest.min((u[0] * v[1] - u[1] * v[0]).abs() / longest);
    }
    lowest
}
