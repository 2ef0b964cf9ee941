//! Winding numbers of degenerate curves on degenerate surfaces: nothing panics, and results are
//! sound.

mod regions;
mod smooth;

use eikona::curves::shortest_vertex_path;
use eikona::mesh::{
    Curve, Edge, Face, Halfedge, SurfaceCurves, SurfacePoint, Topology, TriangleMesh, Vertex, shapes,
};
use eikona::winding::{
    Completion, CompletionShape, Diagnosis, Part, Winding, WindingError, WindingOptions,
    surface_winding_number,
};
use regions::{boundary_of, centre};

fn solve_with(
    mesh: &TriangleMesh,
    curves: Vec<Curve>,
    options: &WindingOptions,
) -> Result<Winding, WindingError> {
    let curves = SurfaceCurves { curves, points: Vec::new() };
    let on_edges = options.with_completion_shape(CompletionShape::Edges);
    let w = surface_winding_number(mesh, &curves, &on_edges)?;
    check(&w, options.completion == Completion::Full, true);
    let straight = surface_winding_number(mesh, &curves, options)?;
    check(&straight, options.completion == Completion::Full, false);
    smooth::check(mesh, &w, &straight);
    Ok(w)
}

fn solve(mesh: &TriangleMesh, curves: Vec<Curve>) -> Winding {
    solve_with(mesh, curves, &WindingOptions::default()).unwrap()
}

/// Solves without splitting short pieces of the curve.
fn solve_uncut(mesh: &TriangleMesh, curves: Vec<Curve>) -> Winding {
    solve_uncut_with(mesh, curves, Diagnosis::Always)
}

fn solve_uncut_with(mesh: &TriangleMesh, curves: Vec<Curve>, diagnosis: Diagnosis) -> Winding {
    let options = WindingOptions::default().with_split_short(false).with_diagnosis(diagnosis);
    solve_with(mesh, curves, &options).unwrap()
}

fn warned(w: &Winding, of: &str) -> bool {
    w.report.warnings.iter().any(|text| text.to_string().contains(of))
}

/// Whether a vertex lies within an edge or face all of whose corners are endpoints.
fn is_between_endpoints(w: &Winding, v: Vertex) -> bool {
    let at = |v: &u32| w.endpoints.contains(&Vertex(*v));
    match w.provenance.vertex_place(v) {
        Some(SurfacePoint::Edge { vertices, .. }) => vertices.iter().all(at),
        Some(SurfacePoint::Face { vertices, .. }) => vertices.iter().all(at),
        _ => false,
    }
}

/// Checks properties of every result: a value wherever the curve does not end and the surface is
/// manifold, the prescribed jumps, labels equal to the rounded values if completions are on edges,
/// and parts that add up.
fn check(w: &Winding, full: bool, on_edges: bool) {
    let mesh = &w.mesh;
    let most = w.jump.iter().fold(1.0, |m, (_, c)| f64::from(c.abs()).max(m));
    let is_single_fan = single_fans(mesh);
    for f in mesh.faces() {
        let values = &w.values.as_slice()[3 * f.index()..3 * f.index() + 3];
        let mut mean = (0.0, 0.0);
        for (v, value) in mesh.face_vertices(f).into_iter().zip(values) {
            assert!(
                value.is_finite()
                    || w.endpoints.contains(&v)
                    || !is_single_fan[v.index()]
                    || is_between_endpoints(w, v),
                "{v}: {value}"
            );
            if value.is_finite() {
                mean = (mean.0 + value, mean.1 + 1.0);
            }
        }
        if on_edges && mean.1 > 0.0 {
            let value = mean.0 / mean.1 + w.shift[w.island[f] as usize];
            assert!((value - f64::from(w.labels[f])).abs() <= 0.5 + 1e-9 * most, "{f}: {value}");
        }
        assert!((0.0..=0.5).contains(&w.margin[f]), "{f}: {}", w.margin[f]);
    }
    for e in mesh.edges() {
        let &[a, b] = mesh.edge_halfedges(e) else { continue };
        for v in mesh.edge_vertices(e).into_iter().filter(|v| full && is_single_fan[v.index()]) {
            let jump = value_at(w, a, v) - value_at(w, b, v);
            let off = (jump - w.bounding_jump(e)).abs();
            assert!(jump.is_nan() || off < 1e-6 * most, "{e} at {v}: {jump}, not {}", w.bounding_jump(e));
        }
    }
    let assigned = w.parts.iter().flatten().filter(|part| **part != Part::LeftOut).count();
    assert_eq!(w.bounding_part().segment_count() + w.nonbounding_part().segment_count(), assigned);
    for round in w.bounding_loops.iter().chain(&w.nonbounding_loops) {
        assert!(round.vertices.windows(2).all(|v| w.mesh.find_edge(v[0], v[1]).is_some()));
    }
    assert_eq!(w.split().unwrap().mesh.face_count(), w.mesh.face_count());
    w.input_labels();
}

fn value_at(w: &Winding, h: Halfedge, v: Vertex) -> f64 {
    let f = h.face();
    let k = w.mesh.face_vertices(f).iter().position(|&x| x == v).unwrap();
    w.values.as_slice()[3 * f.index() + k]
}

fn single_fans(mesh: &TriangleMesh) -> Vec<bool> {
    let topology = Topology::of(mesh);
    let mut single = vec![true; mesh.vertex_count()];
    topology.nonmanifold_vertices.iter().for_each(|v| single[v.vertex.index()] = false);
    for e in mesh.edges().filter(|&e| mesh.edge_halfedges(e).len() > 2) {
        mesh.edge_vertices(e).into_iter().for_each(|v| single[v.index()] = false);
    }
    single
}

fn is_boundary(mesh: &TriangleMesh, e: Edge) -> bool {
    mesh.is_boundary_edge(e)
}

fn sphere() -> TriangleMesh {
    shapes::geodesic_sphere(6).unwrap()
}

#[test]
fn a_vertex_out_of_range_is_reported() {
    let mesh = sphere();
    let count = mesh.vertex_count() as u32;
    let [a, b] = mesh.edge_vertices(Edge(0));
    for far in [count, u32::MAX] {
        let curve = Curve::signed([a, b, Vertex(far)]);
        let error = solve_with(&mesh, vec![curve], &WindingOptions::default()).unwrap_err();
        let WindingError::Curve(fault) = error else { panic!("{error}") };
        assert!(fault.to_string().contains("curve 0, node 2"), "{fault}");
    }
    // A step must not lead where there is no edge or face.
    let curve = Curve::signed([Vertex(0), Vertex(count / 2)]);
    let error = solve_with(&mesh, vec![curve], &WindingOptions::default()).unwrap_err();
    assert!(matches!(error, WindingError::Curve(_) | WindingError::Embed(_)), "{error}");
}

#[test]
fn opposite_copies_leave_zero_everywhere_and_a_warning() {
    let torus = shapes::torus(1.0, 0.4, 12, 8).unwrap();
    let around = Curve::signed((0..=8).map(|j| Vertex(3 * 8 + j % 8)));
    for mesh in [sphere(), torus] {
        let there = if mesh.vertex_count() == 96 {
            vec![around.clone()]
        } else {
            boundary_of(&mesh, |f| centre(&mesh, f)[2] > 0.3)
        };
        let back = there.iter().cloned().map(Curve::reversed);
        let w = solve(&mesh, there.iter().cloned().chain(back).collect());
        assert!(w.labels.iter().all(|(_, label)| *label == 0));
        assert!(w.margin.iter().all(|(_, margin)| *margin == 0.5));
        assert!(w.jump.iter().all(|(_, c)| *c == 0) && w.endpoints.is_empty());
        assert!(w.parts.iter().flatten().all(|part| *part == Part::LeftOut));
        assert!(warned(&w, "no edge has a jump"), "{:?}", w.report.warnings);
    }
}

#[test]
fn a_thousand_copies_count_a_thousand() {
    let mesh = sphere();
    let cap = |f: Face| centre(&mesh, f)[2] > 0.3;
    let copies = boundary_of(&mesh, cap).into_iter().flat_map(|c| std::iter::repeat_n(c, 1000)).collect();
    let w = solve(&mesh, copies);
    assert!(mesh.faces().all(|f| w.labels[f] == if cap(f) { 1000 } else { 0 }));
    assert!(w.parts.iter().flatten().all(|part| *part == Part::Bounding));
    // Around the tube of a torus, where none of them bounds.
    let torus = shapes::torus(1.0, 0.4, 12, 8).unwrap();
    let around = Curve::signed((0..=8 * 1000).map(|j| Vertex(3 * 8 + j % 8)));
    let w = solve(&torus, vec![around]);
    assert!((w.report.largest_nonbounding - 1000.0).abs() < 1e-6);
    assert!(w.labels.iter().all(|(_, label)| *label == 0));
    assert!(w.parts.iter().flatten().all(|part| *part == Part::Nonbounding));
    let [round] = w.nonbounding_loops.as_slice() else { panic!("{} loops", w.nonbounding_loops.len()) };
    assert_eq!((round.jump, round.vertices.len()), (1000.0, 9));
}

#[test]
fn at_most_a_million_copies_of_an_edge_are_accepted() {
    const MOST: usize = 1_000_000;
    let mesh = shapes::octahedron().unwrap();
    let around = |rounds: usize| {
        let nodes = (0..=3 * rounds).map(|i| mesh.face_vertices(Face(0))[i % 3]);
        vec![Curve::signed(nodes)]
    };
    let w = solve(&mesh, around(MOST));
    assert!(mesh.faces().all(|f| w.labels[f] == if f == Face(0) { MOST as i32 } else { 0 }));
    let error = solve_with(&mesh, around(MOST + 1), &WindingOptions::default()).unwrap_err();
    let WindingError::Multiplicity { edge, vertices, most } = error else { panic!("{error}") };
    assert_eq!((edge, most), (mesh.face_edges(Face(0))[0], MOST as i32));
    assert_eq!(vertices, mesh.edge_vertices(edge));
    let named = format!("the edge from vertex {} to {}", vertices[0].index(), vertices[1].index());
    assert!(error.to_string().contains(&named), "{error}");
    // A single edge, which ends on both sides; short pieces are split.
    let [a, b] = mesh.edge_vertices(edge);
    let copies = |count| vec![Curve::signed([a, b]); count];
    let w = solve(&mesh, copies(MOST / 10));
    assert_eq!(w.endpoints.len(), 2);
    let error = solve_with(&mesh, copies(MOST + 1), &WindingOptions::default()).unwrap_err();
    assert!(matches!(error, WindingError::Multiplicity { .. }), "{error}");
}

#[test]
fn steps_along_nonmanifold_edges_are_ignored() {
    // Three pages; the curve runs along the spine, and across it.
    let corners = [[0., 0., 0.], [0., 0., 1.], [1., 0., 0.], [-1., 1., 0.], [-1., -1., 0.], [0., 0., 2.]];
    let mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]).unwrap();
    for curve in [vec![Vertex(0), Vertex(1)], vec![Vertex(2), Vertex(0), Vertex(1), Vertex(3)]] {
        for w in [solve(&mesh, vec![Curve::signed(curve.clone())]), {
            solve_uncut(&mesh, vec![Curve::signed(curve)])
        }] {
            assert!(warned(&w, "three or more faces"), "{:?}", w.report.warnings);
            assert!(w.labels.iter().all(|(_, label)| *label == 0));
        }
    }
}

/// Around a handle, edges of the curve are the only edges connecting the faces of a ring, and the
/// harmonic part jumps by more around it than they allow: their limits are infeasible.
#[test]
fn infeasible_limits_are_relaxed_with_a_warning() {
    let (nu, nv) = (5, 12);
    let torus = shapes::torus(1.0, 0.4, nu, nv).unwrap();
    let at = |i: usize, j: usize| Vertex(((i % nu) * nv + j % nv) as u32);
    let has = |a: Vertex, b: Vertex| torus.find_edge(a, b).is_some();
    // There and back between two circles of vertices, along every edge between them.
    let diagonal_forward = has(at(0, 0), at(1, 1));
    let mut nodes = Vec::new();
    for step in 0..=nu {
        let i = if diagonal_forward { nu - step } else { step };
        nodes.extend([at(i, 0), at(i, 1)]);
    }
    nodes.pop();
    let zigzag = Curve::signed(nodes);
    // And around the tube, but not through the ring: often.
    let broken = Curve::signed((2..nv).map(|j| at(0, j)));
    for copies in [1, 20] {
        for reversed in [false, true] {
            let broken = if reversed { broken.clone().reversed() } else { broken.clone() };
            let mut curves = vec![zigzag.clone()];
            curves.extend(std::iter::repeat_n(broken, copies));
            let w = solve(&torus, curves);
            assert!(w.report.largest_nonbounding > 0.5 * copies as f64);
            assert_eq!(warned(&w, "ring of faces"), copies == 20, "{copies}: {:?}", w.report.warnings);
            assert_eq!(w.report.program.as_ref().unwrap().relaxed > 0, copies == 20);
            assert_eq!(w.endpoints.len(), 2);
        }
    }
}

/// Edges of the curve are the only edges connecting the rings of faces around the tube; two of five
/// are reversed.
#[test]
fn infeasible_rings_are_relaxed_in_few_attempts() {
    let (rings, around) = (400, 4);
    let torus = shapes::torus(1.0, 0.4, rings, around).unwrap();
    let step = |e| {
        let [a, b] = torus.edge_vertices(e);
        let [i, j] = [a, b].map(|v| v.index() / around);
        let first = if (i + 1) % rings == j { i } else { j };
        let reversed = first * 7 % 5 < 2;
        let nodes = if (first == i) != reversed { [a, b] } else { [b, a] };
        (i != j).then(|| Curve::signed(nodes))
    };
    let w = solve_uncut_with(&torus, torus.edges().filter_map(step).collect(), Diagnosis::Never);
    let program = w.report.program.as_ref().unwrap();
    assert!((2..=5).contains(&program.attempts), "{program:?}");
    assert!(program.certificate.gap.abs() < 1e-9, "{program:?}");
    let outside = torus.edges().filter(|&e| {
        let along = w.nonbounding[e] * f64::from(w.jump[e].signum());
        w.jump[e] != 0 && !(-1e-9..=f64::from(w.jump[e].abs()) + 1e-9).contains(&along)
    });
    let outside = outside.count();
    assert!(outside > 100 && program.relaxed >= outside, "{outside} of {program:?}");
    assert!(warned(&w, &format!("{} edges of the curve are the only edges", program.relaxed)));
}

/// Costs are in the unit of the mesh, with separate bounds for the increased lengths and for the
/// true ones.
#[test]
fn the_certificate_bounds_the_cost() {
    let torus = shapes::torus(1.0, 0.4, 30, 14).unwrap();
    let around = Curve::signed((0..=14).map(|j| Vertex(3 * 14 + j % 14)));
    let broken = Curve::signed((1..9).map(|j| Vertex(9 * 14 + j % 14)));
    for size in [1e-6, 0.3, 1.0, 5e4] {
        let positions = torus.positions().iter().map(|p| p.map(|x| x * size)).collect();
        let mesh = torus.with_positions(positions).unwrap();
        for curves in [vec![around.clone()], vec![around.clone(), broken.clone()]] {
            let program = solve(&mesh, curves).report.program.unwrap();
            let (cost, certificate) = (program.objective, program.certificate);
            assert!(cost > 1e-3 * size);
            assert!(certificate.primal > cost && certificate.primal < cost * (1.0 + 1e-4), "{program:?}");
            assert!((certificate.primal - certificate.dual).abs() < 1e-9 * cost, "{program:?}");
            assert!(program.lower_bound < cost && program.lower_bound > cost * (1.0 - 1e-4), "{program:?}");
            assert_eq!((program.relaxed, program.attempts), (0, 1));
        }
    }
}

/// The nonbounding part lies on the curve, where it costs a millionth of its length, so that jumps
/// of 1e-11, the rounding of 20 copies on thin Delaunay triangles, contribute to the cost.
#[test]
fn a_tiny_cost_is_certified_beside_many_copies() {
    let torus = shapes::torus(1.0, 0.4, 6, 6).unwrap();
    let walk = [
        3, 10, 11, 10, 11, 10, 11, 10, 4, 3, 2, 1, 0, 30, 24, 23, 24, 25, 19, 20, 21, 20, 21, 28, 34, 28, 27,
        21, 22, 23, 18, 23, 29, 30, 29, 22, 29, 23, 16, 9, 2,
    ];
    let copies = vec![Curve::signed(walk.map(Vertex)); 20];
    let options =
        WindingOptions::default().with_epsilon(1e-6).with_split_short(false).with_intrinsic_delaunay(true);
    let program = solve_with(&torus, copies, &options).unwrap().report.program.unwrap();
    assert!(program.objective < 2e-4 && program.relaxed == 0, "{program:?}");
    assert!(program.lower_bound > program.objective * (1.0 - 1e-4), "{program:?}");
}

#[test]
fn curves_that_end_on_the_boundary_have_no_endpoint_there() {
    let disk = shapes::disk(6, 18, 1.0).unwrap();
    let rim: Vec<Vertex> =
        disk.edges().filter(|&e| is_boundary(&disk, e)).flat_map(|e| disk.edge_vertices(e)).collect();
    let nearest_to = |x: f64| {
        let distance = |v: &Vertex| (disk.position(*v)[0] - x).hypot(disk.position(*v)[1]);
        *rim.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    let across = shortest_vertex_path(&disk, &[nearest_to(-1.0), Vertex(0), nearest_to(1.0)]).unwrap();
    let w = solve(&disk, vec![Curve::signed(across.clone())]);
    assert!(w.endpoints.is_empty() && w.report.largest_nonbounding == 0.0);
    let ones = w.labels.iter().filter(|(_, label)| label.abs() == 1).count();
    let zeros = w.labels.iter().filter(|(_, label)| **label == 0).count();
    assert!(ones + zeros == disk.face_count() && ones > disk.face_count() / 4);
    // One end inside.
    let half = across[..=across.len() / 2].to_vec();
    assert_eq!(solve(&disk, vec![Curve::signed(half)]).endpoints.len(), 1);
}

#[test]
fn a_curve_on_the_boundary_has_no_jumps() {
    for mesh in [shapes::disk(3, 9, 1.0).unwrap(), shapes::annulus(0.5, 1.0, 2, 9).unwrap()] {
        let sides = mesh.edges().filter(|&e| is_boundary(&mesh, e));
        let curves = sides.map(|e| Curve::signed(mesh.edge_vertices(e))).collect();
        let w = solve(&mesh, curves);
        assert!(w.labels.iter().all(|(_, label)| *label == 0) && w.endpoints.is_empty());
        assert!(warned(&w, "along the boundary") && warned(&w, "no edge has a jump"));
        assert!(w.report.program.is_none());
    }
}

#[test]
fn unused_vertices_and_components_without_curve_change_nothing() {
    let sphere = sphere();
    let cap = |f: Face| f.index() < sphere.face_count() && centre(&sphere, f)[2] > 0.3;
    let plain = solve(&sphere, boundary_of(&sphere, cap));
    let mut positions = sphere.positions().to_vec();
    positions.extend([[7.0; 3], [8.0; 3]]);
    let faces = sphere.triangles().to_vec();
    let lonely = TriangleMesh::new(positions.clone(), faces.clone()).unwrap();
    let w = solve(&lonely, boundary_of(&lonely, cap));
    assert_eq!(w.labels, plain.labels);
    // A curve of one vertex without faces has no steps.
    let mut curves = boundary_of(&lonely, cap);
    let unused = Vertex(lonely.vertex_count() as u32 - 1);
    curves.push(Curve::signed([unused, unused]));
    match solve_with(&lonely, curves, &WindingOptions::default()) {
        Ok(w) => assert_eq!(w.labels, plain.labels),
        Err(fault) => assert!(matches!(fault, WindingError::Curve(_)), "{fault}"),
    }
    // A torus and a triangle beside it, without a curve.
    let torus = shapes::torus(1.0, 0.4, 9, 6).unwrap();
    let mut all = faces;
    let first = positions.len() as u32;
    positions.extend(torus.positions().iter().map(|p| [p[0] + 5.0, p[1], p[2]]));
    all.extend(torus.triangles().iter().map(|f| f.map(|v| v + first)));
    let first = positions.len() as u32;
    positions.extend([[0., 0., 9.], [1., 0., 9.], [0., 1., 9.]]);
    all.push([first, first + 1, first + 2]);
    let more = TriangleMesh::new(positions, all).unwrap();
    let w = solve(&more, boundary_of(&more, cap));
    assert!(more.faces().all(|f| w.labels[f] == i32::from(cap(f))));
    assert!(more.faces().all(|f| w.margin[f] > 0.5 - 1e-9));
}

#[test]
fn two_triangles_and_three_endpoints_in_a_face() {
    let square = shapes::grid(1, 1, 1.0, 1.0, shapes::Diagonal::Alternating).unwrap();
    let diagonal = square.edges().find(|&e| !is_boundary(&square, e)).unwrap();
    let w = solve(&square, vec![Curve::signed(square.edge_vertices(diagonal))]);
    let mut labels: Vec<i32> = w.labels.iter().map(|(_, label)| *label).collect();
    labels.sort_unstable();
    assert_eq!(w.input_labels().iter().map(|(_, l)| l.abs()).sum::<i32>(), 1, "{labels:?}");
    let back_to_back =
        TriangleMesh::new(square.positions()[..3].to_vec(), vec![[0, 1, 2], [0, 2, 1]]).unwrap();
    let w = solve(&back_to_back, vec![Curve::signed([0, 1, 2, 0].map(Vertex))]);
    assert_eq!((w.labels[Face(0)] - w.labels[Face(1)]).abs(), 1);

    // Three edges outwards from the corners of a face.
    let mesh = sphere();
    let corners = mesh.face_vertices(Face(40));
    let outwards = |v: Vertex| {
        let mut around = mesh.vertex_corners(v).iter().flat_map(|c| mesh.face_vertices(c.face()));
        let next = around.rfind(|u| !corners.contains(u)).unwrap();
        Curve::signed([v, next])
    };
    let curves: Vec<Curve> = corners.map(outwards).into();
    let w = solve_uncut(&mesh, curves.clone());
    assert!(corners.iter().all(|v| w.endpoints.contains(v)));
    assert_eq!((w.label_at(Face(40), [1.0 / 3.0; 3]), w.margin[Face(40)]), (None, 0.0));
    assert!(solve(&mesh, curves).endpoints.len() >= 3);
}

#[test]
fn curves_on_one_sided_surfaces_are_solved() {
    let band = shapes::moebius_band(1.0, 0.6, 24, 4).unwrap();
    let mut core: Vec<Vertex> = band
        .vertices()
        .filter(|&v| (band.position(v)[0].hypot(band.position(v)[1]) - 1.0).abs() < 1e-9)
        .filter(|&v| band.position(v)[2].abs() < 1e-9)
        .collect();
    let angle = |v: Vertex| band.position(v)[1].atan2(band.position(v)[0]);
    core.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
    assert_eq!(core.len(), 24);
    core.push(core[0]);
    let w = solve(&band, vec![Curve::signed(core.clone())]);
    assert!(warned(&w, "one-sided") && warned(&w, "no consistent orientation"), "{:?}", w.report.warnings);
    // Left and right switch at its first node.
    assert_eq!(w.endpoints, [core[0]]);
    // After two turns the curve closes with the same sides, but every step cancels.
    let twice: Vec<Vertex> = core[..24].iter().chain(&core).copied().collect();
    let w = solve(&band, vec![Curve::signed(twice)]);
    assert!(w.endpoints.is_empty() && w.labels.iter().all(|(_, label)| *label == 0));

    let bottle = shapes::klein_bottle(2.0, 16, 10).unwrap();
    for [a, b, c] in [[0, 40, 90], [5, 77, 140], [10, 150, 31]] {
        let path = shortest_vertex_path(&bottle, &[a, b, c, a].map(Vertex)).unwrap();
        for length in [path.len(), path.len() / 2] {
            for completion in [Completion::Full, Completion::Curve] {
                let options =
                    WindingOptions::default().with_completion(completion).with_intrinsic_delaunay(true);
                solve_with(&bottle, vec![Curve::signed(path[..length].to_vec())], &options).unwrap();
            }
        }
    }
    let plane = shapes::projective_plane(4).unwrap();
    let path = shortest_vertex_path(&plane, &[0, 9, 20, 0].map(Vertex)).unwrap();
    solve(&plane, vec![Curve::signed(path)]);
}

/// Found by fuzzing: values were NaN for lengths of 1e155 and more.
#[test]
fn labels_do_not_depend_on_the_size_of_the_mesh() {
    let torus = shapes::torus(1.0, 0.4, 24, 12).unwrap();
    let cap = |f: Face| centre(&torus, f)[0] > 1.1;
    let mut open = boundary_of(&torus, cap);
    open.truncate(open.len() * 3 / 4);
    open.push(Curve::signed((0..9).map(|j| Vertex(12 * 12 + j))));
    let [a, b, c] = torus.triangles()[7];
    let at = |bary| SurfacePoint::Face { vertices: [a, b, c], bary };
    let corners = [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8], [0.8, 0.1, 0.1]];
    let across = Curve::signed(corners.map(at));
    let cut: Vec<Curve> = open.iter().cloned().chain([across]).collect();
    for intrinsic_delaunay in [false, true] {
        let options = WindingOptions::default().with_intrinsic_delaunay(intrinsic_delaunay);
        for curves in [&open, &cut] {
            let plain = solve_with(&torus, curves.clone(), &options).unwrap();
            for size in [1e-300, 1e-150, 1e-80, 1e80, 1e150, 1e300] {
                let positions = torus.positions().iter().map(|p| p.map(|x| x * size)).collect();
                let scaled = torus.with_positions(positions).unwrap();
                let w = solve_with(&scaled, curves.clone(), &options).unwrap();
                assert_eq!(w.labels, plain.labels, "{size:e}");
                assert_eq!(w.input_labels(), plain.input_labels(), "{size:e}");
                for (a, b) in w.nonbounding.iter().zip(plain.nonbounding.iter()) {
                    assert!((a.1 - b.1).abs() < 1e-6, "{size:e}: {} {}", a.1, b.1);
                }
                let cost = [&w, &plain].map(|w| w.report.program.as_ref().unwrap().objective);
                assert!((cost[0] / size / cost[1] - 1.0).abs() < 1e-6, "{size:e}: {cost:?}");
            }
        }
    }
}
