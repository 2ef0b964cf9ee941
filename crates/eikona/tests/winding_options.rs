//! What the options of winding numbers do: intrinsic Delaunay triangles, short pieces, the look at the curve's orientation; and
//! the way back to the faces of the input.

mod regions;
use eikona::contour::{SegmentId, plane_cut};
use eikona::mesh::{Curve, Face, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex, damage, shapes};
use eikona::winding::{Diagnosis, Solver, Winding, WindingOptions, surface_winding_number};
use regions::{area, boundary_of, centre};

fn solve(mesh: &TriangleMesh, curves: &[Curve], options: &WindingOptions) -> Winding {
    let curves = SurfaceCurves { curves: curves.to_vec(), points: Vec::new() };
    surface_winding_number(mesh, &curves, options).unwrap()
}

/// The share of the area on which labels are wrong.
fn wrong(w: &Winding, right: impl Fn(Face) -> i32) -> f64 {
    let faces = || w.mesh.faces();
    let wrong: f64 = faces().filter(|&f| w.labels[f] != right(f)).map(|f| area(&w.mesh, f)).sum();
    wrong / faces().map(|f| area(&w.mesh, f)).sum::<f64>()
}

/// The sides of a cap of the sphere, one curve an arc: four arcs of which three quarters are kept, and what angle each begins at.
fn arcs_of_a_circle(sphere: &TriangleMesh, height: f64) -> Vec<Curve> {
    let mut sides = boundary_of(sphere, |f| centre(sphere, f)[2] > height);
    let turn = |c: &Curve| {
        let nodes = eikona::contour::curve_points(sphere, c).unwrap();
        ((nodes[0][1] + nodes[1][1]).atan2(nodes[0][0] + nodes[1][0]) / std::f64::consts::TAU * 4.0)
            .rem_euclid(4.0)
    };
    sides.sort_by(|a, b| turn(a).total_cmp(&turn(b)));
    let mut arcs: Vec<Curve> = Vec::new();
    let mut last = usize::MAX;
    for side in sides {
        let t = turn(&side);
        if t.fract() > 0.75 {
            continue;
        }
        if t as usize == last {
            assert_eq!(arcs[last].nodes.last(), side.nodes.first());
            arcs[last].nodes.push(side.nodes[1]);
        } else {
            last = arcs.len();
            arcs.push(side);
        }
    }
    assert_eq!(arcs.len(), 4);
    arcs
}

#[test]
fn a_reversed_arc_is_found_and_its_effect_told() {
    let sphere = shapes::geodesic_sphere(24).unwrap();
    let arcs = arcs_of_a_circle(&sphere, 0.3);
    let w = solve(&sphere, &arcs, &WindingOptions::default());
    let orientation = w.report.orientation.as_ref().unwrap();
    assert_eq!((orientation.stretches, orientation.reversed.len()), (4, 0));
    assert!(w.report.warnings.is_empty(), "{:?}", w.report.warnings);
    for reversed in 0..4 {
        let mut given = arcs.clone();
        given[reversed] = given[reversed].clone().reversed();
        let w = solve(&sphere, &given, &WindingOptions::default());
        let orientation = w.report.orientation.as_ref().unwrap();
        let expected: Vec<SegmentId> =
            (0..arcs[reversed].nodes.len() - 1).map(|node| SegmentId { curve: reversed, node }).collect();
        assert_eq!(orientation.reversed, expected);
        assert!(orientation.energy_saved > 0.2, "{}", orientation.energy_saved);
        assert!(
            w.report.warnings.iter().any(|text| text.contains("look reversed")),
            "{:?}",
            w.report.warnings
        );
        // The effect is that of turning it over.
        let right = solve(&sphere, &arcs, &WindingOptions::default());
        let changed = wrong(&w, |f| right.labels[f]);
        assert!((orientation.changed_area - changed).abs() < 1e-12);
    }
    let options = WindingOptions { diagnosis: Diagnosis::Never, ..Default::default() };
    assert!(solve(&sphere, &arcs, &options).report.orientation.is_none());
}

#[test]
fn loops_are_taken_as_they_are_given() {
    // Two loops the same way around a tube: turned over, one would bound a band with the other; but it may be meant so.
    let torus = shapes::torus(1.0, 0.4, 40, 20).unwrap();
    let around = |i: usize| Curve::signed((0..=20).map(|j| Vertex((i * 20 + j % 20) as u32)));
    let w = solve(&torus, &[around(7), around(15)], &WindingOptions::default());
    let orientation = w.report.orientation.unwrap();
    assert_eq!((orientation.stretches, orientation.reversed.len()), (2, 0));
}

#[test]
fn delaunay_triangles_keep_exact_answers_exact() {
    // Closed curves on badly shaped faces: a disk and a loop that bounds nothing.
    let torus = damage::jitter(&shapes::torus(1.0, 0.4, 40, 20).unwrap(), 0.4, 3).unwrap();
    let disk = |f: Face| centre(&torus, f)[0] > 1.25;
    let mut curves = boundary_of(&torus, disk);
    curves.push(Curve::signed((0..=20).map(|j| Vertex(20 * 20 + j % 20))));
    let options = WindingOptions { intrinsic_delaunay: true, ..Default::default() };
    let solver = Solver::new(&torus).unwrap();
    let input = SurfaceCurves { curves: curves.clone(), points: Vec::new() };
    // Twice, as the second one takes what the first has made.
    for _ in 0..2 {
        let w = solver.solve(&input, &options).unwrap();
        for f in torus.faces() {
            assert_eq!(w.labels[f], i32::from(disk(f)));
            assert!(w.margin[f] > 0.5 - 1e-9);
        }
        assert!((w.report.largest_nonbounding - 1.0).abs() < 1e-9 && w.report.farthest_from_whole < 1e-9);
        assert!(w.report.residual < 1e-9);
    }
}

#[test]
fn delaunay_triangles_bring_broken_curves_nearer_to_what_a_fine_mesh_says() {
    // A flat disk with an arc of three quarters of a circle, of radius 1/2; squeezed, its faces are needles.
    let disk = |rings| shapes::disk(rings, 6, 1.0).unwrap();
    let (coarse, fine) = (disk(24), disk(96));
    // Vertex j of ring k of the coarse one is vertex 4 j of ring 4 k of the fine one.
    let number = |k: usize, j: usize| 1 + 3 * k * (k - 1) + j;
    let arc = |rings: usize| {
        let middle = rings / 2;
        Curve::signed((0..=9 * middle / 2).map(|j| Vertex((number(middle, j)) as u32)))
    };
    let squeezed = |mesh: &TriangleMesh| {
        let sheared = mesh.positions().iter().map(|p| [p[0] + 1.5 * p[1], 0.5 * p[1], p[2]]).collect();
        mesh.with_positions(sheared).unwrap()
    };
    let value = |w: &Winding, k: usize, j: usize| {
        let v = Vertex(number(k, j) as u32);
        w.values.as_slice()[w.mesh.vertex_corners(v)[0].index()] + w.shift[0]
    };
    let options = |intrinsic_delaunay| WindingOptions { intrinsic_delaunay, ..Default::default() };
    let truth = solve(&squeezed(&fine), &[arc(96)], &options(true));
    let error = |intrinsic| {
        let w = solve(&squeezed(&coarse), &[arc(24)], &options(intrinsic));
        // Rings beside the curve; it is up to a constant.
        let places = || (1..=24).filter(|k| *k != 12).flat_map(|k| (0..6 * k).map(move |j| (k, j)));
        let errors: Vec<f64> = places().map(|(k, j)| value(&w, k, j) - value(&truth, 4 * k, 4 * j)).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt()
    };
    let (with, without) = (error(true), error(false));
    println!("error: {with:.5} on Delaunay triangles, {without:.5} on the faces");
    assert!(with < 0.7 * without);
}

#[test]
fn short_pieces_are_felt_when_they_are_split() {
    let sphere = shapes::geodesic_sphere(16).unwrap();
    let cap = |f: Face| centre(&sphere, f)[2] > 0.3;
    // Every other edge of the circle.
    let every_other: Vec<Curve> = {
        let mut sides = boundary_of(&sphere, cap);
        let angle = |c: &Curve| {
            let p = eikona::contour::curve_points(&sphere, c).unwrap();
            (p[0][1] + p[1][1]).atan2(p[0][0] + p[1][0])
        };
        sides.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        sides.into_iter().step_by(2).collect()
    };
    let split = solve(&sphere, &every_other, &WindingOptions::default());
    let parents = split.face_parent.clone().unwrap();
    let wrong_split = wrong(&split, |f| i32::from(cap(parents[f.index()])));
    let kept = solve(&sphere, &every_other, &WindingOptions { split_short: false, ..Default::default() });
    assert!(kept.face_parent.is_none());
    let wrong_kept = wrong(&kept, |f| i32::from(cap(f)));
    assert!(wrong_split < 0.02 && wrong_kept > 0.1, "{wrong_split} {wrong_kept}");
    // Closed pieces need no splitting.
    let &[a, b, c] = &sphere.face_vertices(Face(7));
    let small = solve(&sphere, &[Curve::signed([a, b, c, a])], &WindingOptions::default());
    assert!(small.face_parent.is_none());
    assert!(sphere.faces().all(|f| small.labels[f] == i32::from(f == Face(7))));
}

#[test]
fn points_of_input_faces_have_labels() {
    // A cut across faces, and half of the faces wound the other way.
    let sphere = shapes::geodesic_sphere(12).unwrap();
    let circle = plane_cut(&sphere, [0.0, 0.0, 0.31], [0.0, 0.0, 1.0]).unwrap().remove(0);
    let flipped = damage::flip_faces(&sphere, 0.4, 2).unwrap().mesh;
    for mesh in [&sphere, &flipped] {
        let w = solve(mesh, std::slice::from_ref(&circle), &WindingOptions::default());
        let above = w.label_at(top(mesh), [1.0 / 3.0; 3]).unwrap();
        let mut asked = 0;
        for f in mesh.faces() {
            for weights in
                [[0.7, 0.2, 0.1], [0.1, 0.7, 0.2], [0.2, 0.1, 0.7], [0.34, 0.33, 0.33], [1.0, 0.0, 0.0]]
            {
                let corners = mesh.face_positions(f);
                let height: f64 = (0..3).map(|k| weights[k] * corners[k][2]).sum();
                if (height - 0.31).abs() > 1e-9 {
                    let expected = if height > 0.31 { above } else { 0 };
                    assert_eq!(w.label_at(f, weights), Some(expected), "{f} {weights:?} {height}");
                    asked += 1;
                }
            }
        }
        assert!(asked > 4 * mesh.face_count());
        assert_eq!(w.label_at(Face(mesh.face_count() as u32), [1.0, 0.0, 0.0]), None);
    }
}

fn top(mesh: &TriangleMesh) -> Face {
    mesh.faces().max_by(|a, b| centre(mesh, *a)[2].total_cmp(&centre(mesh, *b)[2])).unwrap()
}

#[test]
fn steps_know_the_segments_they_come_from() {
    let torus = shapes::torus(1.0, 0.4, 30, 16).unwrap();
    let halves = plane_cut(&torus, [0.0, 0.011, 0.0], [0.0, 1.0, 0.0]).unwrap();
    let w = solve(&torus, &halves[..1], &WindingOptions::default());
    let [walk] = w.curves.as_slice() else { panic!("one curve") };
    assert_eq!(walk.vertices.len(), walk.segments.len() + 1);
    assert_eq!(w.bounds[0].len(), walk.segments.len());
    assert!(w.bounds[0].iter().all(|b| !b));
    let last = halves[0].nodes.len() - 2;
    assert_eq!((walk.segments[0], walk.segments[walk.segments.len() - 1]), (0, last));
    assert!(matches!(halves[0].nodes[0], SurfacePoint::Edge { .. }));
}
