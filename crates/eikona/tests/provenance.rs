//! Provenance composes along random chains of triangulation, repairs and cuts.

mod shapes;
use eikona::cut::embed_curves;
use eikona_mesh::{
    Curve, Face, FaceField, PolygonMesh, Provenance, Repaired, SurfaceCurves, SurfacePoint, TriangleMesh,
    Vertex, VertexField, damage, drop_degenerate_faces, drop_duplicate_faces, drop_unreferenced_vertices,
    orient, shapes as mesh_shapes, split_nonmanifold_vertices, stitch, weld, weld_polygons,
};
use shapes::{Random, rough_grid};

const CHAINS: u64 = 200;
const STEPS: usize = 6;

/// The meshes of a chain, and the provenance of each from the one before.
struct Chain {
    original: PolygonMesh,
    meshes: Vec<TriangleMesh>,
    steps: Vec<Provenance>,
}

impl Chain {
    fn random(seed: u64) -> Chain {
        let mut random = Random(seed);
        let original = broken_polygons(&mut random);
        let welded = weld_polygons(&original, 0.0).unwrap();
        let (mut mesh, triangulated) = welded.mesh.triangulate().unwrap();
        let mut chain = Chain { original, meshes: Vec::new(), steps: vec![welded.provenance] };
        chain.steps.push(triangulated);
        for _ in 0..STEPS {
            let Repaired { mesh: next, provenance } = step(&mesh, &mut random);
            chain.meshes.push(std::mem::replace(&mut mesh, next));
            chain.steps.push(provenance);
        }
        chain.meshes.push(mesh);
        chain
    }

    fn whole(&self) -> Provenance {
        self.steps.iter().skip(1).fold(self.steps[0].clone(), |all, step| all.then(step))
    }

    fn last(&self) -> &TriangleMesh {
        self.meshes.last().unwrap()
    }
}

/// Returns a few polygons and triangles with gaps, copies, wrong orientations and separate corners.
fn broken_polygons(random: &mut Random) -> PolygonMesh {
    let seed = random.next();
    let whole = rough_grid(2 + (seed % 3) as usize, seed);
    let whole = damage::flip_faces(&whole, 0.3, seed).unwrap().mesh;
    let whole = damage::duplicate_faces(&whole, 0.2, seed).unwrap().mesh;
    let whole = damage::remove_faces(&whole, 0.1, seed).unwrap().mesh;
    let whole = if seed.is_multiple_of(2) { damage::unweld(&whole).unwrap().mesh } else { whole };
    let mut polygons = whole.to_polygon_mesh();
    let first = polygons.vertex_count() as u32;
    polygons.positions.extend([[2., 0., 0.], [3., 0., 0.], [3., 1., 0.], [2.1, 0.9, 0.], [1.9, 0.5, 0.]]);
    polygons.push_face(first..first + 5);
    polygons.push_face([first, first + 1, first + 1]);
    polygons
}

fn step(mesh: &TriangleMesh, random: &mut Random) -> Repaired {
    match random.next() % 8 {
        0 => weld(mesh, 0.0).unwrap(),
        1 => drop_degenerate_faces(mesh),
        2 => drop_duplicate_faces(mesh),
        3 => drop_unreferenced_vertices(mesh),
        4 => orient(mesh),
        5 => split_nonmanifold_vertices(mesh).unwrap(),
        6 => {
            let stitched = stitch(mesh, Some(0.0)).unwrap();
            Repaired { mesh: stitched.mesh, provenance: stitched.provenance }
        }
        _ => {
            let curves = (0..2).filter(|_| mesh.face_count() > 0).map(|_| chord(mesh, random)).collect();
            let cut = embed_curves(mesh, &SurfaceCurves { curves, points: Vec::new() }).unwrap();
            Repaired { mesh: cut.mesh, provenance: cut.provenance }
        }
    }
}

/// Returns a segment from a side of a face to its inside.
fn chord(mesh: &TriangleMesh, random: &mut Random) -> Curve {
    let [a, b, c] = mesh.triangles()[random.next() as usize % mesh.face_count()];
    let side = SurfacePoint::Edge { vertices: [a, b], t: 0.1 + 0.8 * random.unit() };
    let weight = 0.1 + 0.3 * random.unit();
    let inside = SurfacePoint::Face { vertices: [a, b, c], bary: [weight, weight, 1.0 - 2.0 * weight] };
    Curve::signed([side, inside])
}

/// Checks that two provenances are equal up to the rounding of places.
#[track_caller]
fn assert_same(a: &Provenance, b: &Provenance, mesh: &TriangleMesh) {
    assert!(a.face_parents().eq(b.face_parents()));
    assert_eq!(a.flipped_faces(), b.flipped_faces());
    assert_eq!(a.dropped_vertices(), b.dropped_vertices());
    for v in mesh.vertices() {
        let mut weights = [a, b].map(|p| p.vertex_weights(v).collect::<Vec<_>>());
        weights.iter_mut().for_each(|w| w.sort_by_key(|term| term.0));
        let [a, b] = weights;
        let close = |(a, b): (&(Vertex, f64), &(Vertex, f64))| a.0 == b.0 && (a.1 - b.1).abs() < 1e-12;
        assert!(a.len() == b.len() && a.iter().zip(&b).all(close), "{v}: {a:?}, {b:?}");
    }
}

#[test]
fn composition_is_associative_and_the_identity_is_neutral() {
    for seed in 0..CHAINS {
        let chain = Chain::random(seed);
        let from_left = chain.whole();
        let from_right = chain.steps.iter().rev().cloned().reduce(|all, step| step.then(&all)).unwrap();
        assert_same(&from_left, &from_right, chain.last());
        let (before, after) = (&chain.original, chain.last());
        let first = Provenance::identity(before.vertex_count(), before.face_count());
        let last = Provenance::identity(after.vertex_count(), after.face_count());
        assert!(first.is_identity());
        assert_eq!(first.then(&from_left), from_left);
        assert_eq!(from_left.then(&last), from_left);
    }
}

#[test]
fn pulled_coordinates_are_those_of_the_new_vertices() {
    let mut cut = 0;
    for seed in 0..CHAINS {
        let chain = Chain::random(seed);
        let (whole, mesh) = (chain.whole(), chain.last());
        for axis in 0..3 {
            let coordinate = |positions: &[[f64; 3]]| {
                VertexField::from(positions.iter().map(|p| p[axis]).collect::<Vec<_>>())
            };
            let pulled = whole.pull_vertices(&coordinate(&chain.original.positions)).unwrap();
            for (v, x) in pulled.iter() {
                assert!((x - mesh.position(v)[axis]).abs() < 1e-12, "chain {seed}, {v}");
                let is_exact = whole.vertex_parent(v).is_some();
                assert!(!is_exact || *x == mesh.position(v)[axis]);
                cut += usize::from(!is_exact);
            }
            let pushed = whole.push_vertices(&coordinate(mesh.positions())).unwrap();
            for (v, x) in pulled_back(&pushed) {
                assert_eq!(x, chain.original.positions[v.index()][axis], "chain {seed}, {v}");
            }
        }
    }
    assert!(cut > CHAINS as usize);
}

/// Returns the vertices that have a value.
fn pulled_back(field: &VertexField<Option<f64>>) -> impl Iterator<Item = (Vertex, f64)> {
    field.iter().filter_map(|(v, x)| x.map(|x| (v, x)))
}

#[test]
fn faces_map_there_and_back() {
    for seed in 0..CHAINS {
        let chain = Chain::random(seed);
        let (whole, mesh) = (chain.whole(), chain.last());
        let count = chain.original.face_count() as u32;
        for new in mesh.faces() {
            assert!(whole.face_parts(whole.face_parent(new)).any(|part| part == new));
        }
        let numbers: FaceField<Face> = (0..count).map(Face).collect::<Vec<_>>().into();
        let pulled = whole.pull_faces(&numbers).unwrap();
        assert!(pulled.as_slice().iter().copied().eq(whole.face_parents()));
        let parts = whole.push_faces(&pulled, |first, parents| (first, parents.to_vec())).unwrap();
        for (f, (first, parents)) in parts.iter() {
            assert!(parents.iter().all(|parent| *parent == f));
            assert!(whole.face_parts(f).eq((first.0..).map(Face).take(parents.len())));
            assert_eq!(parents.is_empty(), whole.dropped_faces().contains(&f));
        }
    }
}

#[test]
fn flips_are_those_of_the_normals() {
    let normal = |[a, b, c]: [[f64; 3]; 3]| {
        let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    };
    for seed in 0..CHAINS {
        let chain = Chain::random(seed);
        let (whole, mesh) = (chain.whole(), chain.last());
        for new in mesh.faces() {
            let corners = chain.original.face(whole.face_parent(new).index());
            let corners = [0, 1, 2].map(|k| chain.original.positions[corners[k] as usize]);
            let along: f64 =
                normal(mesh.face_positions(new)).iter().zip(normal(corners)).map(|(a, b)| a * b).sum();
            assert_eq!(along < 0.0, whole.is_flipped(new), "chain {seed}, {new}");
        }
    }
}

#[test]
fn fields_of_wrong_length_and_steps_that_do_not_meet_are_refused() {
    let sphere = mesh_shapes::icosphere(1).unwrap();
    let provenance = Provenance::identity(sphere.vertex_count(), sphere.face_count());
    let short = VertexField::constant(3, 0.0);
    assert_eq!(
        provenance.pull_vertices(&short).unwrap_err().to_string(),
        "found 3 vertex values, expected 42"
    );
    assert!(provenance.push_faces(&FaceField::constant(3, 0), |_, _| ()).is_err());
    let other = Provenance::identity(3, 1);
    assert!(std::panic::catch_unwind(|| provenance.then(&other)).is_err());
    assert_eq!((other.new_vertex(Vertex(3)), other.vertex_place(Vertex(3))), (None, None));
    assert_eq!(other.face_parts(Face(1)).len(), 0);
}
