//! The operators compared with dense ones built from vectors in space, and the identities that
//! define them.

mod dense;
mod exact;

use dense::{Constraint, Dense, FaceFrame, scalar_laplacian, vector_operators};
use eikona::geometry::lay_out;
use eikona::operators::{ComplexFrames, CotanLaplacian, EdgeFrames, RealFrames, divergence};
use eikona::signed_heat::{DiffusionTime, LevelSets};
use eikona_mesh::{
    Curve, Face, Halfedge, SurfaceCurves, TriangleMesh, damage,
    random::Random,
    shapes::{self, Diagonal},
};
use eikona_numeric::{Complex, Graph, Scalar, SymmetricMatrix};
use exact::*;

/// A curved disk with boundary, a closed surface of genus 0, and one with a handle.
fn irregular_meshes() -> Vec<(&'static str, TriangleMesh)> {
    let disk = shapes::disk(4, 6, 1.0).unwrap();
    let bent = disk.positions().iter().map(|p| [p[0], p[1], 0.3 * (2.0 * p[0]).sin() * p[1]]).collect();
    let disk = damage::jitter(&disk.with_positions(bent).unwrap(), 0.2, 3).unwrap();
    let lump = damage::jitter(&shapes::icosphere(1).unwrap(), 0.2, 4).unwrap();
    let torus = damage::jitter(&shapes::torus(1.0, 0.5, 8, 6).unwrap(), 0.15, 5).unwrap();
    vec![("disk", disk), ("lump", lump), ("torus", torus)]
}

fn irregular_plate() -> TriangleMesh {
    let grid = shapes::grid(6, 5, 1.2, 1.0, Diagonal::Alternating).unwrap();
    damage::jitter_with(&grid, 0.3, 7, &|p| [p[0], p[1], 0.0]).unwrap()
}

/// A number as a 2 x 2 matrix; its first column holds the real and imaginary part.
trait Block: Scalar {
    fn block(self) -> [[f64; 2]; 2];
}

impl Block for Complex {
    fn block(self) -> [[f64; 2]; 2] {
        [[self.re, -self.im], [self.im, self.re]]
    }
}

impl Block for f64 {
    fn block(self) -> [[f64; 2]; 2] {
        [[self, 0.0], [0.0, 0.0]]
    }
}

fn full<T: Block>(graph: &Graph, matrix: &SymmetricMatrix<T>) -> Dense {
    let mut dense = Dense::zeros(2 * graph.unknowns);
    let mut put = |i: usize, j: usize, block: [[f64; 2]; 2]| {
        for (r, row) in block.into_iter().enumerate() {
            for (c, value) in row.into_iter().enumerate() {
                *dense.at(2 * i + r, 2 * j + c) += value;
            }
        }
    };
    for (i, &d) in matrix.diagonal.iter().enumerate() {
        put(i, i, T::real(d).block());
    }
    for (&[i, j], &value) in graph.pairs.iter().zip(&matrix.off_diagonal) {
        put(i as usize, j as usize, value.block());
        put(j as usize, i as usize, value.conj().block());
    }
    dense
}

fn real_full(graph: &Graph, matrix: &SymmetricMatrix<f64>) -> Dense {
    let mut dense = Dense::zeros(graph.unknowns);
    for (i, &d) in matrix.diagonal.iter().enumerate() {
        *dense.at(i, i) += d;
    }
    for (&[i, j], &value) in graph.pairs.iter().zip(&matrix.off_diagonal) {
        *dense.at(i as usize, j as usize) += value;
        *dense.at(j as usize, i as usize) += value;
    }
    dense
}

fn assert_close(name: &str, a: &Dense, b: &Dense) {
    assert_eq!(a.n, b.n);
    let scale = largest(&a.entries);
    let difference = largest_difference(&a.entries, &b.entries);
    assert!(difference < 1e-13 * scale, "{name}: difference {difference}, scale {scale}");
}

#[test]
fn assembled_operators_equal_dense_ones_from_vectors_in_space() {
    for (name, mesh) in irregular_meshes() {
        let triangles = lay_out(&mesh);
        let l = ComplexFrames::of(&mesh).unwrap().connection_laplacian(&mesh, &triangles).unwrap();
        let (mass, energy) = vector_operators(&mesh);
        assert_close(name, &full(&l.graph, &l.matrix), &energy);
        for (e, m) in l.mass.iter().enumerate() {
            assert!((m - mass.get(2 * e, 2 * e)).abs() < 1e-15, "{name}: mass of edge {e}");
        }
        let c = CotanLaplacian::new(&mesh, &triangles);
        assert_close(name, &real_full(&c.graph, &c.matrix), &scalar_laplacian(&mesh));
    }
}

#[test]
fn connection_laplacian_is_positive_semidefinite() {
    let mut meshes = irregular_meshes();
    let mut random = Random::from_seed(9);
    // Slivers and obtuse triangles give cotangents of both signs and all magnitudes.
    let grid = shapes::grid(5, 4, 1.0, 1.0, Diagonal::Uniform).unwrap();
    let thrown = grid.positions().iter().map(|_| [0; 3].map(|_| random.uniform())).collect();
    meshes.push(("thrown", grid.with_positions(thrown).unwrap()));
    for (name, mesh) in meshes {
        let complex = ComplexFrames::of(&mesh).unwrap().connection_laplacian(&mesh, &lay_out(&mesh)).unwrap();
        let real = RealFrames::of(&mesh).connection_laplacian(&mesh, &lay_out(&mesh)).unwrap();
        for mut dense in [full(&complex.graph, &complex.matrix), real_full(&real.graph, &real.matrix)] {
            let scale = largest(&dense.entries);
            for i in 0..dense.n {
                for j in 0..i {
                    assert!(
                        (dense.get(i, j) - dense.get(j, i)).abs() <= 1e-14 * scale,
                        "{name}: not Hermitian"
                    );
                }
                *dense.at(i, i) += 1e-11 * scale;
            }
            assert_eq!(dense.negative_pivots(), 0, "{name}");
            for i in 0..dense.n {
                *dense.at(i, i) -= 1e-4 * scale;
            }
            // A curved surface has no parallel fields, but some fields are nearly parallel: the
            // count must be able to fail.
            assert!(dense.negative_pivots() < dense.n, "{name}");
        }
    }
}

/// A constant vector of the plane in the frame of a halfedge: along it, and into its face.
fn seen_from(mesh: &TriangleMesh, h: Halfedge, vector: [f64; 3]) -> Complex {
    let along = sub(mesh.position(mesh.tip(h)), mesh.position(mesh.origin(h)));
    let along = along.map(|x| x / norm(along));
    let into = cross(FaceFrame::of(mesh, h.face()).normal, along);
    Complex { re: dot(vector, along), im: dot(vector, into) }
}

/// The unknowns of a constant vector of the plane, on a mesh with at most two faces per edge.
fn constant_field<F: EdgeFrames>(mesh: &TriangleMesh, frames: &F, vector: [f64; 3]) -> Vec<F::Value> {
    let mut x = frames.zeros();
    for e in mesh.edges() {
        let h = mesh.edge_halfedges(e)[0];
        frames.add(mesh, &mut x, h, seen_from(mesh, h, vector));
    }
    for f in mesh.faces() {
        for k in 0..3 {
            let (read, expected) =
                (frames.read(mesh, &x, f.halfedge(k)), seen_from(mesh, f.halfedge(k), vector));
            assert!((read - expected).norm() < 1e-13, "{f} side {k}: {read:?}, expected {expected:?}");
        }
    }
    x
}

fn assert_parallel_fields_have_no_energy<F: EdgeFrames>(name: &str, mesh: &TriangleMesh, frames: &F)
where
    F::Value: Block,
{
    let l = frames.connection_laplacian(mesh, &lay_out(mesh)).unwrap();
    let matrix = full(&l.graph, &l.matrix);
    for vector in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -2.0, 0.0]] {
        let parts = constant_field(mesh, frames, vector).into_iter().map(Block::block);
        let x: Vec<f64> = parts.flat_map(|[[re, _], [im, _]]| [re, im]).collect();
        let image = matrix.times(&x);
        assert!(largest(&image) < 1e-12, "{name}: {}", largest(&image));
    }
}

#[test]
fn parallel_fields_have_no_energy_on_flat_domains() {
    let plate = irregular_plate();
    let flipped = damage::flip_faces(&plate, 0.4, 2).unwrap().mesh;
    let holes = damage::remove_faces(&plate, 0.2, 3).unwrap().mesh;
    for (name, mesh) in [("plate", &plate), ("holes", &holes)] {
        assert_parallel_fields_have_no_energy(name, mesh, &ComplexFrames::of(mesh).unwrap());
    }
    for (name, mesh) in [("plate", &plate), ("holes", &holes), ("flipped", &flipped)] {
        assert_parallel_fields_have_no_energy(name, mesh, &RealFrames::of(mesh));
    }
    // The flips have an effect: the complex form is refused.
    assert!(ComplexFrames::of(&flipped).is_none());
}

/// The operator on a part of a mesh is that of the mesh with only these faces.
#[test]
fn part_of_a_mesh_has_the_operator_of_its_faces() {
    let plate = irregular_plate();
    let faces: Vec<Face> = plate.faces().filter(|f| f.index() % 3 != 1).collect();
    let frames = RealFrames::of_part(&plate, &faces);
    let part = frames.connection_laplacian_of(&plate, &lay_out(&plate), faces.iter().copied()).unwrap();
    let corners = faces.iter().map(|&f| plate.triangles()[f.index()]).collect();
    let alone = TriangleMesh::new(plate.positions().to_vec(), corners).unwrap();
    let whole = RealFrames::of(&alone).connection_laplacian(&alone, &lay_out(&alone)).unwrap();
    assert_eq!(part.mass.len(), whole.mass.len());
    let total = |mass: &[f64]| mass.iter().sum::<f64>();
    assert!((total(&part.mass) - total(&whole.mass)).abs() < 1e-14);
    // Edges are numbered differently, so only the traces of powers are compared.
    let [part, whole] = [&part, &whole].map(|l| real_full(&l.graph, &l.matrix));
    let trace = |m: &Dense| (0..m.n).map(|i| m.get(i, i)).sum::<f64>();
    let squares = |m: &Dense| m.entries.iter().map(|x| x * x).sum::<f64>();
    assert!((trace(&part) / trace(&whole) - 1.0).abs() < 1e-13);
    assert!((squares(&part) / squares(&whole) - 1.0).abs() < 1e-13);
}

#[test]
fn cotan_laplacian_of_linear_functions_vanishes_inside() {
    let plate = irregular_plate();
    let flipped = damage::flip_faces(&plate, 0.4, 2).unwrap().mesh;
    for mesh in [plate, flipped] {
        let c = CotanLaplacian::new(&mesh, &lay_out(&mesh));
        let values: Vec<f64> = mesh.positions().iter().map(|p| 2.0 * p[0] - 3.0 * p[1] + 1.0).collect();
        let image = real_full(&c.graph, &c.matrix).times(&values);
        let mut inside = vec![true; mesh.vertex_count()];
        for e in mesh.edges().filter(|&e| mesh.is_boundary_edge(e)) {
            mesh.edge_vertices(e).into_iter().for_each(|v| inside[v.index()] = false);
        }
        assert_eq!(inside.iter().filter(|i| **i).count(), 5 * 4);
        for v in mesh.vertices().filter(|v| inside[v.index()]) {
            assert!(image[v.index()].abs() < 1e-12, "{v}: {}", image[v.index()]);
        }
        assert!(largest(&image) > 0.1, "the boundary terms must not vanish");
    }
}

/// The gradient in a face of a function given at its corners, in the layout of the face.
fn gradient(mesh: &TriangleMesh, f: Face, values: &[f64]) -> Complex {
    let frame = FaceFrame::of(mesh, f);
    let mut g = [0.0; 3];
    for (k, v) in mesh.face_vertices(f).into_iter().enumerate() {
        (0..3).for_each(|c| g[c] += values[v.index()] * frame.barycentric[k][c]);
    }
    seen_from(mesh, f.halfedge(0), g)
}

/// C f = -div grad f for every function that is linear in each face, including at the boundary:
/// with the sign and the edges as in `divergence`, a function is the fit to its own gradient.
#[test]
fn gradient_of_linear_function_is_recovered() {
    let mut random = Random::from_seed(1);
    let mut meshes = irregular_meshes();
    meshes.push(("plate", irregular_plate()));
    meshes.push(("flipped", damage::flip_faces(&irregular_plate(), 0.4, 2).unwrap().mesh));
    for (name, mesh) in meshes {
        let triangles = lay_out(&mesh);
        let c = CotanLaplacian::new(&mesh, &triangles);
        let c = real_full(&c.graph, &c.matrix);
        let linear: Vec<f64> =
            mesh.positions().iter().map(|p| 2.0 * p[0] - 3.0 * p[1] + 0.7 * p[2] + 1.0).collect();
        let arbitrary: Vec<f64> = linear.iter().map(|_| random.uniform()).collect();
        for values in [linear, arbitrary] {
            let field: Vec<Complex> = mesh.faces().map(|f| gradient(&mesh, f, &values)).collect();
            let minus: Vec<f64> = divergence(&mesh, &triangles, &field).iter().map(|d| -d).collect();
            let image = c.times(&values);
            let difference = largest_difference(&image, &minus);
            assert!(difference < 1e-12 * largest(&image), "{name}: {difference}");
            // Conversely, the divergence determines the values up to a constant.
            let mut pinned = c.clone();
            *pinned.at(0, 0) += 1.0;
            let back = pinned.solve(&minus);
            let shifted: Vec<f64> = values.iter().map(|x| x - values[0] + back[0]).collect();
            assert!(largest_difference(&back, &shifted) < 1e-10, "{name}");
        }
    }
}

/// Two curves across faces, one of them open, and one along edges, on a mesh of about unit size.
fn curves(mesh: &TriangleMesh, along_edges: bool) -> SurfaceCurves {
    let mut source = zero_level(mesh, |p| p[0] + 0.3 * p[1] - 0.37);
    source.curves.truncate(1);
    let open = &mut source.curves[0];
    open.nodes.truncate(open.nodes.len().saturating_sub(3).max(2));
    if along_edges {
        let far =
            mesh.vertices().min_by(|a, b| mesh.position(*a)[0].total_cmp(&mesh.position(*b)[0])).unwrap();
        let h = mesh.vertex_corners(far)[0].halfedge();
        let (a, b) = (mesh.tip(h), mesh.origin(h.previous()));
        source.curves.push(Curve::signed([far, a, b]));
    }
    source
}

/// Compares the whole method with its dense twin: returns the largest difference relative to the
/// largest distance.
fn against_twin(pairs: &[(LevelSets, Constraint)], preserve_source_normals: bool) -> f64 {
    let mut worst = 0.0f64;
    for (name, mesh) in irregular_meshes() {
        for along_edges in [false, true] {
            let source = curves(&mesh, along_edges);
            for coefficient in [1.0, 7.0] {
                let solver = solver(&mesh, DiffusionTime::Coefficient(coefficient));
                for &(level_sets, constraint) in pairs {
                    let options = levels(level_sets).with_preserve_source_normals(preserve_source_normals);
                    let ours = solver.solve(&source, &options).unwrap().distance.into_vec();
                    let twin = dense::signed_distance(
                        &mesh,
                        &source,
                        coefficient,
                        constraint,
                        preserve_source_normals,
                    );
                    let difference = largest_difference(&ours, &twin) / largest(&twin);
                    println!(
                        "{name}, edges {along_edges}, t {coefficient}, {level_sets:?}: {difference:.1e}"
                    );
                    worst = worst.max(difference);
                }
            }
        }
    }
    worst
}

#[test]
fn free_and_soft_distances_equal_those_of_the_dense_twin() {
    let worst = against_twin(
        &[
            (LevelSets::Free, Constraint::Free),
            (LevelSets::Soft(0.1), Constraint::Soft(0.1)),
            (LevelSets::Soft(30.0), Constraint::Soft(30.0)),
        ],
        false,
    );
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn distances_with_preserved_normals_equal_those_of_the_dense_twin() {
    let worst = against_twin(&[(LevelSets::Free, Constraint::Free)], true);
    assert!(worst < 1e-8, "{worst:e}");
}

/// Curves along edges, constrained exactly, and across faces, by a penalty. The penalty inside the
/// constrained solves costs six of the sixteen digits, and nearly dependent rows cost some more.
#[test]
fn constrained_distances_equal_those_of_the_dense_twin() {
    let worst = against_twin(
        &[(LevelSets::Zero, Constraint::Zero), (LevelSets::PerComponent, Constraint::PerPiece)],
        false,
    );
    assert!(worst < 1e-9, "{worst:e}");
}
