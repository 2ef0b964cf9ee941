//! Options of winding number solves: intrinsic Delaunay triangles, short pieces, the orientation
//! check; and maps back to the faces of the input.

mod regions;
use eikona::contour::plane_cut;
use eikona::curves::SegmentId;
use eikona::mesh::{Curve, Face, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex, damage, shapes};
use eikona::numeric::NumericError;
use eikona::winding::{
    CompletionShape, Diagnosis, Part, Solver, SolverOptions, Winding, WindingError, WindingOptions,
    surface_winding_number,
};
use regions::{area, boundary_of, centre};
use std::f64::consts::TAU;

fn solve(mesh: &TriangleMesh, curves: &[Curve], options: &WindingOptions) -> Winding {
    let curves = SurfaceCurves { curves: curves.to_vec(), points: Vec::new() };
    surface_winding_number(mesh, &curves, options).unwrap()
}

/// Returns the share of the area on which labels are wrong.
fn wrong(w: &Winding, right: impl Fn(Face) -> i32) -> f64 {
    let faces = || w.mesh.faces();
    let wrong: f64 = faces().filter(|&f| w.labels[f] != right(f)).map(|f| area(&w.mesh, f)).sum();
    wrong / faces().map(|f| area(&w.mesh, f)).sum::<f64>()
}

/// Four arcs of the boundary of a cap of the sphere, without a quarter of it.
fn arcs_of_a_circle(sphere: &TriangleMesh, height: f64) -> Vec<Curve> {
    let mut sides = boundary_of(sphere, |f| centre(sphere, f)[2] > height);
    let mut round = sides.swap_remove(0).nodes;
    while let Some(i) = sides.iter().position(|side| side.nodes[0] == round[round.len() - 1]) {
        round.push(sides.swap_remove(i).nodes[1]);
    }
    assert!(sides.is_empty() && round.first() == round.last());
    // Start where it is farthest along x, so that arcs of two circles lie beside each other.
    round.pop();
    let along_x = |node: &SurfacePoint| node.locate(sphere).unwrap().position(sphere)[0];
    let first = (0..round.len()).max_by(|&i, &j| along_x(&round[i]).total_cmp(&along_x(&round[j]))).unwrap();
    round.rotate_left(first);
    let n = round.len();
    (0..4)
        .map(|k| Curve {
            nodes: round[k * n / 4..=k * n / 4 + 3 * n / 16].to_vec(),
            ..Curve::signed([Vertex(0)])
        })
        .collect()
}

#[test]
fn a_reversed_arc_is_reported_with_its_effect() {
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
            w.report.warnings.iter().any(|text| text.kind() == "reversed_segments"),
            "{:?}",
            w.report.warnings
        );
        // The effect is that of reversing it, for completions along edges.
        let edges = WindingOptions::default().with_completion_shape(CompletionShape::Edges);
        let [right, turned] = [&arcs, &given].map(|arcs| solve(&sphere, arcs, &edges));
        let changed = wrong(&turned, |f| right.labels[f]);
        assert!((orientation.changed_area.unwrap() - changed).abs() < 1e-12);
    }
    let options = WindingOptions::default().with_diagnosis(Diagnosis::Never);
    assert!(solve(&sphere, &arcs, &options).report.orientation.is_none());
}

#[test]
fn too_many_stretches_are_not_compared() {
    let sphere = shapes::geodesic_sphere(40).unwrap();
    // Edges without a common vertex, each a curve of its own.
    let mut taken = vec![false; sphere.vertex_count()];
    let mut pieces: Vec<Curve> = Vec::new();
    for [a, b] in sphere.edges().map(|e| sphere.edge_vertices(e)) {
        if !taken[a.index()] && !taken[b.index()] {
            (taken[a.index()], taken[b.index()]) = (true, true);
            pieces.push(Curve::signed([a, b]));
        }
    }
    assert!(pieces.len() > 2000, "{}", pieces.len());
    let always = WindingOptions::default().with_diagnosis(Diagnosis::Always).with_split_short(false);
    let w = solve(&sphere, &pieces, &always);
    assert!(w.report.orientation.is_none());
    assert!(
        w.report.warnings.iter().any(|text| text.to_string().contains("more than the 2000")),
        "{:?}",
        w.report.warnings
    );
    // Nearly all vertices are endpoints; labels exist nevertheless.
    assert_eq!(w.labels.as_slice().len(), sphere.face_count());
    assert!(w.labels.iter().all(|(_, label)| label.abs() < 10));
    assert!(solve(&sphere, &pieces[..40], &always).report.orientation.is_some());
}

#[test]
fn loops_are_kept_as_given() {
    // Two loops in the same direction around a tube: with one reversed they would bound a band, but
    // the input may be intended.
    let torus = shapes::torus(1.0, 0.4, 40, 20).unwrap();
    let around = |i: usize| Curve::signed((0..=20).map(|j| Vertex((i * 20 + j % 20) as u32)));
    let w = solve(&torus, &[around(7), around(15)], &WindingOptions::default());
    let orientation = w.report.orientation.unwrap();
    assert_eq!((orientation.stretches, orientation.reversed.len()), (2, 0));
}

/// Deliberate curves are kept, although reversing a part would lower the energy.
#[test]
fn copies_offsets_and_cuts_are_kept_as_given() {
    let reversed = |mesh: &TriangleMesh, curves: &[Curve]| {
        let w = solve(mesh, curves, &WindingOptions::default());
        w.report.orientation.unwrap().reversed.len()
    };
    let sphere = shapes::geodesic_sphere(24).unwrap();
    let arcs = arcs_of_a_circle(&sphere, 0.3);
    // The same arc twice.
    assert_eq!(reversed(&sphere, &[arcs[0].clone(), arcs[0].clone()]), 0);
    // A circle and its offset, both broken.
    let offset = arcs_of_a_circle(&sphere, 0.2);
    assert_eq!(reversed(&sphere, &[arcs.clone(), offset.clone()].concat()), 0);
    // And one piece of both that is indeed reversed.
    let mut wrong = [arcs, offset].concat();
    wrong[2] = wrong[2].clone().reversed();
    assert_eq!(reversed(&sphere, &wrong), wrong[2].nodes.len() - 1);
    // Two cuts from boundary to boundary of an annulus, both inwards.
    let annulus = shapes::annulus(1.0, 2.0, 10, 40).unwrap();
    let nearest = |p: [f64; 3]| {
        let d = |v: &Vertex| (0..3).map(|k| (annulus.position(*v)[k] - p[k]).powi(2)).sum::<f64>();
        annulus.vertices().min_by(|a, b| d(a).total_cmp(&d(b))).unwrap()
    };
    let cut = |x: f64, y: f64| {
        let ends = [nearest([2.0 * x, 2.0 * y, 0.0]), nearest([x, y, 0.0])];
        Curve::signed(eikona::curves::shortest_vertex_path(&annulus, &ends).unwrap())
    };
    assert_eq!(reversed(&annulus, &[cut(1.0, 0.0), cut(0.0, 1.0)]), 0);
    // A bounding loop beside a group of arcs of which the longer ones are reversed: only the
    // shorter one is reported.
    let mut group = arcs_of_a_circle(&sphere, 0.3);
    for i in 1..4 {
        group[i] = group[i].clone().reversed();
    }
    let &[a, b, c] = &sphere.face_vertices(Face(9));
    let shorter = group[0].nodes.len() - 1;
    group.push(Curve::signed([a, b, c, a]));
    assert_eq!(reversed(&sphere, &group), shorter);
}

#[test]
fn delaunay_triangles_keep_exact_solutions_exact() {
    // Closed curves on badly shaped faces: a disk and a nonbounding loop.
    let torus = damage::jitter(&shapes::torus(1.0, 0.4, 40, 20).unwrap(), 0.4, 3).unwrap();
    let disk = |f: Face| centre(&torus, f)[0] > 1.25;
    let mut curves = boundary_of(&torus, disk);
    curves.push(Curve::signed((0..=20).map(|j| Vertex(20 * 20 + j % 20))));
    let options = WindingOptions::default().with_intrinsic_delaunay(true);
    let solver = Solver::new(&torus, &Default::default()).unwrap();
    let input = SurfaceCurves { curves: curves.clone(), points: Vec::new() };
    // Twice, as the second solve reuses the operators of the first.
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

/// The winding number of a cut from the centre of a disk to its boundary is the angle, exactly,
/// whatever the cut.
#[test]
fn delaunay_triangles_are_better_where_faces_are_badly_shaped() {
    // Rings of vertices joined by long, thin faces that spiral outwards, and a cut along such
    // edges.
    let (rings, around, twist) = (12u32, 72u32, 3u32);
    let number = |k: u32, j: u32| 1 + (k - 1) * around + j % around;
    let mut positions = vec![[0.0; 3]];
    for k in 1..=rings {
        for j in 0..around {
            let (r, a) = (f64::from(k) / f64::from(rings), TAU * f64::from(j) / f64::from(around));
            positions.push([r * a.cos(), r * a.sin(), 0.0]);
        }
    }
    let mut faces = Vec::new();
    for j in 0..around {
        faces.push([0, number(1, j), number(1, j + 1)]);
        for k in 1..rings {
            let (a, b) = (number(k, j), number(k, j + 1));
            let (c, d) = (number(k + 1, j + twist), number(k + 1, j + twist + 1));
            faces.extend([[a, c, d], [a, d, b]]);
        }
    }
    let disk = TriangleMesh::new(positions, faces).unwrap();
    let cut = (1..=rings).map(|k| number(k, (k - 1) * twist));
    let cut = Curve::signed(std::iter::once(0).chain(cut).map(Vertex));
    let error = |intrinsic_delaunay| {
        let completion_shape = CompletionShape::Edges;
        let options = WindingOptions::default()
            .with_intrinsic_delaunay(intrinsic_delaunay)
            .with_completion_shape(completion_shape);
        let w = solve(&disk, std::slice::from_ref(&cut), &options);
        assert_eq!(w.endpoints, [Vertex(0)]);
        // Turns by which the value differs from the angle, modulo integers and one constant.
        let [mut x, mut y] = [0.0, 0.0];
        let mut differences = Vec::new();
        for v in disk.vertices().skip(1) {
            let p = disk.position(v);
            let value = w.values.as_slice()[disk.vertex_corners(v)[0].index()];
            // The value is highest left of the cut, where the angle starts.
            let turns = value + p[1].atan2(p[0]) / TAU;
            (x, y) = (x + (TAU * turns).cos(), y + (TAU * turns).sin());
            differences.push(turns);
        }
        let mean = f64::atan2(y, x) / TAU;
        let squares = differences.iter().map(|d| (d - mean - (d - mean).round()).powi(2));
        (squares.sum::<f64>() / differences.len() as f64).sqrt()
    };
    let (with, without) = (error(true), error(false));
    println!("error in turns: {with:.5} on Delaunay triangles, {without:.5} on the faces");
    assert!(with < 1e-3 && with < 0.2 * without);
}

#[test]
fn short_pieces_take_effect_when_split() {
    let sphere = shapes::geodesic_sphere(16).unwrap();
    let cap = |f: Face| centre(&sphere, f)[2] > 0.3;
    // Every other edge of the circle.
    let every_other: Vec<Curve> = {
        let mut sides = boundary_of(&sphere, cap);
        let angle = |c: &Curve| {
            let p = eikona::contour::polylines(&sphere, [c]).unwrap().remove(0);
            (p[0][1] + p[1][1]).atan2(p[0][0] + p[1][0])
        };
        sides.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        sides.into_iter().step_by(2).collect()
    };
    let split = solve(&sphere, &every_other, &WindingOptions::default());
    assert!(split.is_cut());
    let wrong_split = wrong(&split, |f| i32::from(cap(split.provenance.face_parent(f))));
    let kept = solve(&sphere, &every_other, &WindingOptions::default().with_split_short(false));
    assert!(!kept.is_cut());
    let wrong_kept = wrong(&kept, |f| i32::from(cap(f)));
    assert!(wrong_split < 0.02 && wrong_kept > 0.1, "{wrong_split} {wrong_kept}");
    // Closed pieces need no splitting.
    let &[a, b, c] = &sphere.face_vertices(Face(7));
    let small = solve(&sphere, &[Curve::signed([a, b, c, a])], &WindingOptions::default());
    assert!(!small.is_cut());
    assert!(sphere.faces().all(|f| small.labels[f] == i32::from(f == Face(7))));
}

#[test]
fn points_of_input_faces_have_labels() {
    // A cut across faces, with half of the faces flipped.
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
fn steps_name_their_segments() {
    let torus = shapes::torus(1.0, 0.4, 30, 16).unwrap();
    let halves = plane_cut(&torus, [0.0, 0.011, 0.0], [0.0, 1.0, 0.0]).unwrap();
    let w = solve(&torus, &halves[..1], &WindingOptions::default());
    let [walk] = w.curves.as_slice() else { panic!("one curve") };
    assert_eq!(walk.vertices.len(), walk.segments.len() + 1);
    assert_eq!(w.parts[0].len(), walk.segments.len());
    assert!(w.parts[0].iter().all(|part| *part == Part::Nonbounding));
    let last = halves[0].nodes.len() - 2;
    assert_eq!((walk.segments[0], walk.segments[walk.segments.len() - 1]), (0, last));
    assert!(matches!(halves[0].nodes[0], SurfacePoint::Edge { .. }));
}

/// A third of a loop around the tube of a torus, beside two whole ones: whether it bounds is
/// undetermined, and so is the level of everything else.
#[test]
fn uncertain_labels_give_a_warning() {
    let torus = shapes::torus(1.0, 0.4, 60, 30).unwrap();
    let around = |i: u32, kept: u32| Curve::signed((0..=kept).map(|j| Vertex(30 * i + j % 30)));
    let ask = |kept: u32| {
        solve(&torus, &[around(0, kept), around(20, 30), around(40, 30)], &WindingOptions::default())
    };
    let w = ask(10);
    let total: f64 = torus.faces().map(|f| area(&torus, f)).sum();
    let guessed: f64 = w.mesh.faces().filter(|&f| w.margin[f] < 0.1).map(|f| area(&w.mesh, f)).sum();
    assert!((w.report.uncertain_area - guessed / total).abs() < 1e-12 && guessed > 0.5 * total);
    let share =
        format!("labels are uncertain (margin below 0.1) on {:.0} % of the area", 100.0 * guessed / total);
    assert!(
        w.report.warnings.iter().any(|text| text.to_string().starts_with(&share)),
        "{:?}",
        w.report.warnings
    );
    let w = ask(30);
    assert_eq!(w.report.uncertain_area, 0.0);
    assert!(w.report.warnings.is_empty(), "{:?}", w.report.warnings);
}

/// What is suggested saves energy, also where pieces run alongside each other, which is not weighed
/// at first.
#[test]
fn suggested_reversals_save_energy() {
    let torus = shapes::torus(1.0, 0.4, 40, 20).unwrap();
    let arc = |from: [u32; 2], step: [u32; 2], count: u32| {
        Curve::signed(
            (0..count).map(|n| Vertex(20 * ((from[0] + step[0] * n) % 40) + (from[1] + step[1] * n) % 20)),
        )
    };
    let mut seed = 1u64;
    let mut below = |n: u32| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 33) % u64::from(n)) as u32
    };
    let mut suggested = 0;
    for _ in 0..150 {
        let curves: Vec<Curve> = (0..2 + below(6))
            .map(|_| {
                let step = [[1, 0], [0, 1], [39, 0], [0, 19], [1, 1]][below(5) as usize];
                arc([below(40), below(20)], step, 4 + below(10))
            })
            .collect();
        let w = solve(&torus, &curves, &WindingOptions::default());
        let found = w.report.orientation.unwrap();
        if !found.reversed.is_empty() {
            suggested += 1;
            assert!(found.energy_saved > 0.0 && found.energy_saved < 1.0, "{}", found.energy_saved);
        }
    }
    assert!(suggested > 20, "{suggested}");
}

#[test]
fn threads_change_no_digit_and_the_memory_limit_is_kept() {
    let torus = shapes::torus(1.0, 0.4, 90, 36).unwrap();
    let around = |j: u32| Vertex(j % 36);
    let curves = SurfaceCurves::from_curve(Curve::signed((0..30).map(around)));
    let with = |threads, memory_limit| {
        Solver::new(&torus, &SolverOptions::default().with_threads(threads).with_memory_limit(memory_limit))
            .unwrap()
            .solve(&curves, &WindingOptions::default())
    };
    let bits = |w: Winding| w.values.as_slice().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let one = bits(with(1, None).unwrap());
    assert!([2, 3].into_iter().all(|threads| bits(with(threads, None).unwrap()) == one));
    let refused = with(1, Some(1000)).unwrap_err();
    let WindingError::Numeric(NumericError::MemoryLimit { needed_bytes, limit_bytes: 1000 }) = refused else {
        panic!("{refused:?}")
    };
    assert!(needed_bytes > 100_000, "{needed_bytes} bytes for {} vertices", torus.vertex_count());
    assert!(with(1, Some(100 * needed_bytes)).is_ok());
}
