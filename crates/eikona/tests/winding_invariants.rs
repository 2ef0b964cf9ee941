//! Identities of surface winding numbers on shapes with known answers.

mod regions;
use eikona::mesh::{Curve, Face, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex, shapes};
use eikona::winding::{
    Completion, CompletionShape, Part, Solver, Winding, WindingOptions, surface_winding_number,
};
use regions::{area, boundary_of, centre};

fn solve(mesh: &TriangleMesh, curves: &[Curve]) -> Winding {
    let curves = SurfaceCurves { curves: curves.to_vec(), points: Vec::new() };
    surface_winding_number(mesh, &curves, &WindingOptions::default()).unwrap()
}

/// A torus whose vertex (i, j) has number i * nv + j, slightly perturbed so that no two loops have
/// equal length.
fn torus(nu: usize, nv: usize) -> TriangleMesh {
    let torus = shapes::torus(1.0, 0.4, nu, nv).unwrap();
    eikona::mesh::damage::jitter(&torus, 0.15, 5).unwrap()
}

fn around_tube(nv: usize, i: usize) -> Curve {
    Curve::signed((0..=nv).map(|j| Vertex((i * nv + j % nv) as u32)))
}

/// Returns the largest deviation of the values from label minus shift.
fn roughness(w: &Winding) -> f64 {
    w.mesh
        .faces()
        .flat_map(|f| (0..3).map(move |k| (f, k)))
        .map(|(f, k)| {
            let value = w.values.as_slice()[3 * f.index() + k] + w.shift[w.island[f] as usize];
            (value - f64::from(w.labels[f])).abs()
        })
        .fold(0.0, f64::max)
}

#[test]
fn a_region_of_the_sphere_is_one_and_the_rest_zero() {
    let sphere = shapes::geodesic_sphere(16).unwrap();
    let cap = |f: Face| centre(&sphere, f)[2] > 0.4;
    let w = solve(&sphere, &boundary_of(&sphere, cap));
    assert!(w.endpoints.is_empty() && w.report.program.is_none());
    assert!(roughness(&w) < 1e-12, "{}", roughness(&w));
    for f in sphere.faces() {
        assert_eq!(w.labels[f], i32::from(cap(f)));
        assert!(w.margin[f] > 0.5 - 1e-12);
    }
    assert_eq!(w.bounding_loops.len(), 1);
    assert!(w.nonbounding_loops.is_empty());
    assert!(w.parts.iter().flatten().all(|part| *part == Part::Bounding));
}

#[test]
fn crossing_loops_add_up() {
    let sphere = shapes::geodesic_sphere(16).unwrap();
    let a = |f: Face| centre(&sphere, f)[2] > 0.6;
    let b = |f: Face| centre(&sphere, f)[0] > 0.3;
    let w = solve(&sphere, &[boundary_of(&sphere, a), boundary_of(&sphere, b)].concat());
    assert!(roughness(&w) < 1e-12);
    assert!(sphere.faces().all(|f| w.labels[f] == i32::from(a(f)) + i32::from(b(f))));
}

#[test]
fn a_loop_around_the_tube_of_a_torus_bounds_nothing() {
    let torus = torus(40, 20);
    let w = solve(&torus, &[around_tube(20, 7)]);
    for e in torus.edges() {
        assert!((w.nonbounding[e] - f64::from(w.jump[e])).abs() < 1e-9);
    }
    assert!(w.labels.iter().all(|(_, l)| *l == 0));
    let (low, high) = w.values.iter().fold((f64::MAX, f64::MIN), |(l, h), (_, v)| (l.min(*v), h.max(*v)));
    assert!(high - low < 1e-9, "constant except for rounding");
    assert!(w.parts[0].iter().all(|part| *part == Part::Nonbounding));
    assert!(w.bounding_loops.is_empty());
    assert_eq!(w.nonbounding_loops.len(), 1);
    assert_eq!(w.nonbounding_loops[0].vertices.len(), 21);
    assert_eq!(w.nonbounding_loops[0].vertices.first(), w.nonbounding_loops[0].vertices.last());
    let program = w.report.program.unwrap();
    assert!(program.certificate.gap.abs() < 1e-9, "{:?}", program.certificate);
}

#[test]
fn opposite_loops_bound_a_band_and_parallel_ones_do_not() {
    let torus = torus(40, 20);
    let w = solve(&torus, &[around_tube(20, 7), around_tube(20, 15).reversed()]);
    assert!(w.report.largest_nonbounding < 1e-9, "{}", w.report.largest_nonbounding);
    assert!(roughness(&w) < 1e-9);
    let band: Vec<Face> = torus.faces().filter(|&f| w.labels[f] != 0).collect();
    assert_eq!(band.len(), 2 * 8 * 20, "eight columns of twenty quads");
    assert_eq!(w.bounding_loops.len(), 2);

    let w = solve(&torus, &[around_tube(20, 7), around_tube(20, 15)]);
    for e in torus.edges() {
        assert!((w.nonbounding[e] - f64::from(w.jump[e])).abs() < 1e-9, "neither moves onto the other");
    }
}

#[test]
fn a_nonbounding_loop_does_not_affect_a_disk() {
    let torus = torus(48, 24);
    let disk = |f: Face| {
        let [x, y, z] = centre(&torus, f);
        ((x - 1.0).powi(2) + y.powi(2) + (z - 0.35).powi(2)).sqrt() < 0.2
    };
    let mut curves = boundary_of(&torus, disk);
    curves.push(around_tube(24, 24));
    let w = solve(&torus, &curves);
    for f in torus.faces() {
        assert_eq!(w.labels[f], i32::from(disk(f)));
    }
    assert!(roughness(&w) < 1e-9);
    let (last, rest) = w.parts.split_last().unwrap();
    assert!(
        last.iter().all(|part| *part == Part::Nonbounding)
            && rest.iter().flatten().all(|part| *part == Part::Bounding)
    );
}

#[test]
fn reversal_negates_values_and_labels() {
    let torus = torus(30, 15);
    let disk = |f: Face| centre(&torus, f)[0] > 1.2;
    let mut curves = boundary_of(&torus, disk);
    curves.push(around_tube(15, 12));
    let reversed: Vec<Curve> = curves.iter().cloned().map(Curve::reversed).collect();
    let (w, r) = (solve(&torus, &curves), solve(&torus, &reversed));
    for e in torus.edges() {
        assert!((w.nonbounding[e] + r.nonbounding[e]).abs() < 1e-9);
    }
    for f in torus.faces() {
        assert_eq!(w.labels[f], -r.labels[f]);
    }
}

#[test]
fn values_jump_as_prescribed() {
    let torus = torus(40, 20);
    let mut broken = around_tube(20, 7);
    broken.nodes.truncate(15);
    let disk = |f: Face| centre(&torus, f)[0] > 1.25;
    let mut curves = boundary_of(&torus, disk);
    curves.truncate(curves.len() * 4 / 5);
    curves.push(broken);
    let input = SurfaceCurves { curves, points: Vec::new() };
    for completion in [Completion::Full, Completion::Curve] {
        let w =
            surface_winding_number(&torus, &input, &WindingOptions::default().with_completion(completion))
                .unwrap();
        assert!(!w.endpoints.is_empty());
        // Short pieces were split.
        let mesh = &w.mesh;
        assert!(mesh.face_count() > torus.face_count());
        let program = w.report.program.as_ref().unwrap();
        assert!(program.certificate.gap.abs() < 1e-9);
        let mut touched = vec![false; mesh.vertex_count()];
        for e in mesh.edges().filter(|&e| w.jump[e] != 0) {
            mesh.edge_vertices(e).into_iter().for_each(|v| touched[v.index()] = true);
        }
        for e in mesh.edges() {
            let &[a, b] = mesh.edge_halfedges(e) else { panic!("the torus is closed") };
            for v in mesh.edge_vertices(e) {
                if completion == Completion::Curve && !touched[v.index()] {
                    continue;
                }
                let at = |h: eikona::mesh::Halfedge| {
                    let k = (0..3).find(|&k| mesh.face_vertices(h.face())[k] == v).unwrap();
                    w.values.as_slice()[3 * h.face().index() + k]
                };
                let jump = at(a) - at(b);
                assert!(jump.is_nan() || (jump - w.bounding_jump(e)).abs() < 1e-12, "{jump} at {e:?}");
            }
            // Between zero and the curve.
            let (t, c) = (w.nonbounding[e], f64::from(w.jump[e]));
            assert!(c == 0.0 || (t / c >= -1e-9 && t / c <= 1.0 + 1e-9));
        }
        // Closed: around every vertex the nonbounding jumps sum to zero.
        let mut sum = vec![0.0; mesh.vertex_count()];
        for e in mesh.edges() {
            let first = mesh.edge_halfedges(e)[0];
            sum[mesh.origin(first).index()] += w.nonbounding[e];
            sum[mesh.tip(first).index()] -= w.nonbounding[e];
        }
        assert!(sum.iter().all(|s| s.abs() < 1e-9));
    }
}

#[test]
fn a_broken_circle_on_the_sphere_labels_almost_all_faces_correctly() {
    let sphere = shapes::geodesic_sphere(40).unwrap();
    let cap = |f: Face| centre(&sphere, f)[2] > 0.3;
    let whole = boundary_of(&sphere, cap);
    // A quarter is missing, in three gaps selected by angle.
    let kept: Vec<Curve> = whole
        .into_iter()
        .filter(|c| {
            let nodes = eikona::contour::polylines(&sphere, [c]).unwrap().remove(0);
            let (p, q) = (nodes[0], nodes[1]);
            let turn = ((p[1] + q[1]).atan2(p[0] + q[0]) / std::f64::consts::TAU * 3.0).rem_euclid(1.0);
            turn > 0.25
        })
        .collect();
    let w = solve(&sphere, &kept);
    assert_eq!(w.endpoints.len(), 6);
    let area = |f: Face| area(&w.mesh, f);
    let total: f64 = w.mesh.faces().map(area).sum();
    let is_wrong = |f: &Face| w.labels[*f] != i32::from(cap(w.provenance.face_parent(*f)));
    let wrong: f64 = w.mesh.faces().filter(is_wrong).map(area).sum();
    assert!(wrong < 0.01 * total, "{:.2} % of the area is wrong", 100.0 * wrong / total);
}

#[test]
fn a_reused_solver_agrees_with_fresh_ones() {
    let torus = torus(30, 15);
    let solver = Solver::new(&torus, &Default::default()).unwrap();
    let mut open = around_tube(15, 3);
    open.nodes.truncate(9);
    for curve in [around_tube(15, 5), open, around_tube(15, 20)] {
        let input = SurfaceCurves::from_curve(curve.clone());
        let kept = solver.solve(&input, &WindingOptions::default()).unwrap();
        let fresh = solve(&torus, &[curve]);
        assert_eq!(kept.labels, fresh.labels);
        assert_eq!(kept.nonbounding, fresh.nonbounding);
    }
}

/// The degree of an endpoint is the number of departures minus arrivals; all degrees sum to zero,
/// like the boundary of a chain.
#[test]
fn degrees_of_endpoints_sum_to_zero() {
    let sphere = shapes::geodesic_sphere(12).unwrap();
    // Three arms from one vertex, one of them double, and one that leads back.
    let path = |from: u32, to: u32| {
        Curve::signed(eikona::curves::shortest_vertex_path(&sphere, &[Vertex(from), Vertex(to)]).unwrap())
    };
    let curves = [path(700, 20), path(700, 350), path(700, 350), path(1100, 700)];
    let completion_shape = CompletionShape::Edges;
    let options = WindingOptions::default().with_split_short(false).with_completion_shape(completion_shape);
    let input = SurfaceCurves { curves: curves.to_vec(), points: Vec::new() };
    let w = surface_winding_number(&sphere, &input, &options).unwrap();
    // The sum of the jumps around a vertex.
    let degree = |v: Vertex| -> i32 {
        let edges = sphere.edges().filter(|&e| sphere.edge_vertices(e).contains(&v));
        edges.map(|e| if sphere.edge_vertices(e)[0] == v { w.jump[e] } else { -w.jump[e] }).sum()
    };
    let mut endpoints = w.endpoints.clone();
    endpoints.sort_unstable();
    assert_eq!(endpoints, [20, 350, 700, 1100].map(Vertex));
    assert_eq!([20, 350, 700, 1100].map(|v| degree(Vertex(v))), [-1, -2, 2, 1]);
    assert_eq!(sphere.vertices().map(degree).sum::<i32>(), 0);
    assert_eq!(sphere.vertices().filter(|&v| degree(v) != 0).count(), 4);
}

/// A bounding loop around a disk adds the disk's indicator, whatever else is there.
#[test]
fn a_bounding_loop_adds_its_indicator() {
    let torus = torus(48, 24);
    let disk = |f: Face| {
        let [x, y, z] = centre(&torus, f);
        ((x + 1.0).powi(2) + y.powi(2) + (z - 0.35).powi(2)).sqrt() < 0.25
    };
    // A nonbounding loop, and a region that overlaps the disk.
    let mut curves = boundary_of(&torus, |f| centre(&torus, f)[1] > 0.1 && centre(&torus, f)[0] < 0.0);
    curves.push(around_tube(24, 2));
    let before = solve(&torus, &curves);
    curves.extend(boundary_of(&torus, disk));
    let after = solve(&torus, &curves);
    assert!(before.endpoints.is_empty() && before.report.largest_nonbounding > 0.9);
    for f in torus.faces() {
        assert_eq!(after.labels[f], before.labels[f] + i32::from(disk(f)));
    }
    let moved = |f: Face, k: usize| {
        let corner = 3 * f.index() + k;
        after.values.as_slice()[corner] + after.shift[0] - before.values.as_slice()[corner] - before.shift[0]
    };
    for f in torus.faces() {
        assert!((0..3).all(|k| (moved(f, k) - f64::from(i32::from(disk(f)))).abs() < 1e-9));
    }
    for e in torus.edges() {
        assert!((after.nonbounding[e] - before.nonbounding[e]).abs() < 1e-9);
    }
}

/// The numbering of vertices and faces, the first corner of a face and the direction of an edge do
/// not matter.
#[test]
fn numbering_changes_nothing() {
    let torus = torus(30, 15);
    let mut open = around_tube(15, 7);
    open.nodes.truncate(12);
    let mut curves = boundary_of(&torus, |f| centre(&torus, f)[0] > 1.15);
    curves.push(open);
    curves.push(Curve::signed((4..20).map(|i| Vertex(15 * i + 3))));
    let (n, m) = (torus.vertex_count(), torus.face_count());
    // Multiplication by a coprime number permutes.
    let vertex = |v: u32| (v as usize * 101 % n) as u32;
    let face = |f: usize| f * 103 % m;
    assert!(n % 101 != 0 && m % 103 != 0);
    let mut positions = vec![[0.0; 3]; n];
    torus.vertices().for_each(|v| positions[vertex(v.0) as usize] = torus.position(v));
    let mut triangles = vec![[0; 3]; m];
    for (f, corners) in torus.triangles().iter().enumerate() {
        triangles[face(f)] = corners.map(vertex);
        triangles[face(f)].rotate_left(f % 3);
    }
    let renumbered = TriangleMesh::new(positions, triangles).unwrap();
    let moved: Vec<Curve> = curves
        .iter()
        .map(|c| {
            Curve::signed(c.nodes.iter().map(|node| {
                let SurfacePoint::Vertex { vertex: v } = node else { panic!("nodes are vertices") };
                Vertex(vertex(*v))
            }))
        })
        .collect();
    let (w, r) = (solve(&torus, &curves), solve(&renumbered, &moved));
    let by_place = |w: &Winding, map: &dyn Fn(usize) -> usize| -> Vec<i32> {
        let labels = w.input_labels();
        (0..m).map(|f| labels.as_slice()[map(f)]).collect()
    };
    assert_eq!(by_place(&w, &|f| f), by_place(&r, &face));
    let objective = |w: &Winding| w.report.program.as_ref().unwrap().objective;
    assert!((objective(&w) / objective(&r) - 1.0).abs() < 1e-9, "{} {}", objective(&w), objective(&r));
    // Values at face centres, near endpoints and far from them.
    for f in 0..m {
        let one = w.value_at(Face(f as u32), [1.0 / 3.0; 3]);
        let other = r.value_at(Face(face(f) as u32), [1.0 / 3.0; 3]);
        assert!((one - other).abs() < 1e-6, "face {f}: {one} and {other}");
    }
}
