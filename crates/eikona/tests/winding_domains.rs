//! Winding numbers on surfaces with boundary, several components, one side, flipped faces or
//! nonmanifold edges; and bad input.

mod regions;
use eikona::contour::plane_cut;
use eikona::curves::shortest_vertex_path;
use eikona::mesh::{Curve, Face, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex, damage, shapes};
use eikona::winding::{
    Completion, Part, Reference, Winding, WindingError, WindingOptions, surface_winding_number,
};
use regions::{boundary_of, centre};

fn solve(mesh: &TriangleMesh, curves: Vec<Curve>) -> Winding {
    let curves = SurfaceCurves { curves, points: Vec::new() };
    surface_winding_number(mesh, &curves, &WindingOptions::default()).unwrap()
}

/// An annulus with radii 1 and 2.
fn annulus() -> TriangleMesh {
    shapes::annulus(1.0, 2.0, 12, 40).unwrap()
}

fn nearest(mesh: &TriangleMesh, p: [f64; 3]) -> Vertex {
    let distance = |v: &Vertex| (0..3).map(|k| (mesh.position(*v)[k] - p[k]).powi(2)).sum::<f64>();
    mesh.vertices().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
}

#[test]
fn a_circle_around_the_hole_of_an_annulus_bounds_and_a_ray_does_not() {
    let mesh = annulus();
    // The middle circle: the boundary of everything inside it.
    let inner = |f: Face| centre(&mesh, f).iter().map(|x| x * x).sum::<f64>().sqrt() < 1.5;
    let w = solve(&mesh, boundary_of(&mesh, inner));
    assert!(w.endpoints.is_empty() && w.report.largest_nonbounding < 1e-9);
    for f in mesh.faces() {
        assert_eq!(w.labels[f] - w.labels[Face(0)], i32::from(inner(f)) - i32::from(inner(Face(0))));
        assert!(w.margin[f] > 0.5 - 1e-9);
    }
    // From boundary to boundary: the curve ends there without an endpoint.
    let ends = [nearest(&mesh, [1.0, 0.0, 0.0]), nearest(&mesh, [2.0, 0.0, 0.0])];
    let ray = Curve::signed(shortest_vertex_path(&mesh, &ends).unwrap());
    let w = solve(&mesh, vec![ray]);
    assert!(w.endpoints.is_empty());
    assert!(w.labels.iter().all(|(_, label)| *label == 0));
    assert!((w.report.largest_nonbounding - 1.0).abs() < 1e-9 && w.report.farthest_from_whole < 1e-9);
    assert!(w.parts[0].iter().all(|part| *part == Part::Nonbounding));
    assert_eq!(w.nonbounding_loops.len(), 1);
}

#[test]
fn flipped_faces_change_no_label() {
    let torus = shapes::torus(1.0, 0.4, 30, 16).unwrap();
    let disk = |f: Face| centre(&torus, f)[0] > 1.15;
    let curves = boundary_of(&torus, disk);
    let whole = solve(&torus, curves.clone());
    assert!(torus.faces().all(|f| whole.labels[f] == i32::from(disk(f))));
    let flipped = damage::flip_faces(&torus, 0.3, 4).unwrap().mesh;
    let same = solve(&flipped, curves);
    assert!(torus.faces().all(|f| whole.labels[f] == same.labels[f]));
    assert!(same.report.warnings.iter().any(|w| w.kind() == "faces_flipped"), "{:?}", same.report.warnings);
}

#[test]
fn a_disk_on_a_moebius_band_has_label_one() {
    let band = shapes::moebius_band(1.0, 0.6, 80, 10).unwrap();
    // At [1, 0, 0] the orientation of the faces changes.
    for middle in [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]] {
        let distance = |p: [f64; 3]| (0..3).map(|k| (p[k] - middle[k]).powi(2)).sum::<f64>().sqrt();
        one_inside(&band, |f| distance(centre(&band, f)) < 0.22);
    }
}

#[test]
fn a_disk_on_a_klein_bottle_has_label_one() {
    let (nu, nv) = (60, 30);
    let bottle = shapes::klein_bottle(2.5, nu, nv).unwrap();
    // At column 0 the orientation of the faces changes, and row j meets row 29 - j.
    for column in [30, 0] {
        let near = |v: Vertex| {
            let (i, j) = (v.index() / nv, v.index() % nv);
            ((i + nu + nu / 2 - column) % nu).abs_diff(nu / 2) <= 4 && (10..=19).contains(&j)
        };
        one_inside(&bottle, |f| bottle.face_vertices(f).into_iter().all(near));
    }
}

/// Two curves around the tube of a Klein bottle separate it into two bands. Their normals decide
/// whether they bound one of them, or add up to a jump of two along the bottle: the orientation of
/// the faces changes somewhere.
#[test]
fn normals_determine_the_sides_of_curves_around_a_klein_bottle() {
    let (nu, nv) = (60, 30);
    let bottle = shapes::klein_bottle(2.5, nu, nv).unwrap();
    let columns = [10, 46];
    let around = |column: usize, side: f64| {
        let nodes = (0..=nv).map(|j| Vertex((nv * column + j % nv) as u32));
        let first = bottle.find_edge(Vertex((nv * column) as u32), Vertex((nv * column + 1) as u32)).unwrap();
        let up = normal(&bottle, bottle.edge_halfedges(first)[0].face()).map(|x| side * x);
        Curve { up: Some(up), ..Curve::signed(nodes) }
    };
    let between = |f: Face| {
        let column = |v: Vertex| v.index() / nv;
        bottle.face_vertices(f).into_iter().all(|v| (columns[0]..=columns[1]).contains(&column(v)))
    };
    for sides in [[1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0]] {
        let w = solve(&bottle, vec![around(columns[0], sides[0]), around(columns[1], sides[1])]);
        assert!(w.endpoints.is_empty(), "{:?}", w.endpoints);
        if sides[0] == sides[1] {
            assert!(w.parts.iter().flatten().all(|part| *part == Part::Nonbounding), "{sides:?}");
            assert!(w.labels.iter().all(|(_, label)| *label == 0));
            assert!((w.report.largest_nonbounding - 1.0).abs() < 1e-9);
        } else {
            // The wider band is 0, and left of the first curve, seen from its normal, is one higher
            // than right.
            assert!(w.parts.iter().flatten().all(|part| *part == Part::Bounding), "{sides:?}");
            let [a, b] = [0, 1].map(|j| Vertex((nv * columns[0] + j) as u32));
            let sides_of_edge = bottle.edge_halfedges(bottle.find_edge(a, b).unwrap());
            let left = sides_of_edge.iter().find(|h| bottle.origin(**h) == a).unwrap().face();
            let sign = if between(left) == (sides[0] > 0.0) { -1 } else { 1 };
            assert!(bottle.faces().all(|f| w.labels[f] == if between(f) { 0 } else { sign }));
            assert_eq!(w.bounding_loops.len(), 2);
        }
    }
}

fn normal(mesh: &TriangleMesh, f: Face) -> [f64; 3] {
    let [p, q, r] = mesh.face_positions(f);
    let (u, v) = ([0, 1, 2].map(|k| q[k] - p[k]), [0, 1, 2].map(|k| r[k] - p[k]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Checks the curve around a disk on a one-sided surface: labels, completed loop, and the side
/// given by a normal.
fn one_inside(band: &TriangleMesh, inside: impl Fn(Face) -> bool) {
    // One closed walk, so that its side is transported.
    let mut sides: Vec<[SurfacePoint; 2]> =
        boundary_of(band, &inside).into_iter().map(|c| [c.nodes[0], c.nodes[1]]).collect();
    let count = sides.len();
    let mut nodes = sides.pop().unwrap().to_vec();
    while let Some(i) = sides.iter().position(|side| side.contains(nodes.last().unwrap())) {
        let [a, b] = sides.swap_remove(i);
        nodes.push(if a == *nodes.last().unwrap() { b } else { a });
    }
    assert_eq!((nodes.len(), nodes.first()), (count + 1, nodes.last()));
    let w = solve(band, vec![Curve::signed(nodes.clone())]);
    assert!(
        w.endpoints.is_empty() && w.report.largest_nonbounding < 1e-9,
        "{}",
        w.report.largest_nonbounding
    );
    let sign = w.labels[band.faces().find(|&f| inside(f)).unwrap()];
    assert_eq!(sign.abs(), 1);
    assert!(band.faces().all(|f| w.labels[f] == if inside(f) { sign } else { 0 }));
    let [round] = w.bounding_loops.as_slice() else { panic!("{} loops", w.bounding_loops.len()) };
    assert_eq!((round.vertices.len(), round.vertices.first()), (count + 1, round.vertices.last()));
    assert_eq!(round.jump, 1.0);

    // Seen from the other side, left is right: a normal can choose the side.
    let [a, b] = [0, 1].map(|i| match nodes[i] {
        SurfacePoint::Vertex { vertex } => Vertex(vertex),
        _ => panic!("nodes are vertices"),
    });
    let first = band.edge_halfedges(band.find_edge(a, b).unwrap())[0].face();
    let normal = normal(band, first);
    for side in [1, -1] {
        let up = Some(normal.map(|x| f64::from(side) * x));
        let w = solve(band, vec![Curve { up, ..Curve::signed(nodes.clone()) }]);
        assert!(band.faces().all(|f| w.labels[f] == if inside(f) { side * sign } else { 0 }));
    }
}

/// The core of a Moebius band is one-sided: somewhere left becomes right. A warning says so, and
/// the core bounds nothing.
#[test]
fn one_sided_curves_give_a_warning() {
    let band = shapes::moebius_band(1.0, 0.6, 80, 10).unwrap();
    // Vertices in the middle of the band.
    let core: Vec<Vertex> = band
        .vertices()
        .filter(|&v| {
            let [x, y, z] = band.position(v);
            (x.hypot(y) - 1.0).abs() < 1e-9 && z.abs() < 1e-9
        })
        .collect();
    assert_eq!(core.len(), 80);
    let mut path = vec![core[0]];
    while path.len() < 80 {
        let last = path[path.len() - 1];
        let next = core.iter().find(|v| !path.contains(v) && band.find_edge(last, **v).is_some());
        path.push(*next.unwrap());
    }
    path.push(core[0]);
    let w = solve(&band, vec![Curve::signed(path)]);
    assert!(w.report.warnings.iter().any(|text| text.kind() == "one_sided_curve"), "{:?}", w.report.warnings);
    assert_eq!(w.endpoints, [core[0]], "left becomes right at its first node");
    assert!(w.values.iter().filter(|(_, v)| v.is_nan()).count() <= 6);
    assert!(w.report.residual < 1e-9);
}

/// Two spheres with one common vertex, through which a curve runs on both: each has its own
/// constant.
#[test]
fn spheres_touching_in_a_vertex_of_the_curve_have_separate_levels() {
    let sphere = shapes::geodesic_sphere(10).unwrap();
    let top =
        sphere.vertices().max_by(|a, b| sphere.position(*a)[2].total_cmp(&sphere.position(*b)[2])).unwrap();
    let n = sphere.vertex_count() as u32;
    let mut positions = sphere.positions().to_vec();
    // The other one upside down on top of the first.
    let height = 2.0 * sphere.position(top)[2];
    positions.extend(sphere.positions().iter().map(|p| [p[0], -p[1], height - p[2]]));
    let other = |v: u32| if v == top.0 { v } else { v + n };
    let mut faces = sphere.triangles().to_vec();
    faces.extend(sphere.triangles().iter().map(|f| f.map(other)));
    let both = TriangleMesh::new(positions, faces).unwrap();
    // Half of each, cut through the common vertex.
    let middle = sphere.position(top)[0];
    let half = |f: Face| centre(&both, f)[0] > middle;
    let curves = boundary_of(&both, half);
    assert!(curves.iter().any(|c| c.nodes[0] == top.into()));
    let w = solve(&both, curves);
    assert!(w.report.warnings.iter().any(|text| text.kind() == "several_fans"), "{:?}", w.report.warnings);
    assert_eq!(w.shift.len(), 2);
    let parent_half = |f: Face| half(w.provenance.face_parent(f));
    let wrong = w.mesh.faces().filter(|&f| w.labels[f] != i32::from(parent_half(f))).count();
    assert!(wrong < w.mesh.face_count() / 50, "{wrong} of {}", w.mesh.face_count());
}

#[test]
fn nonmanifold_edges_give_a_warning_even_away_from_the_curve() {
    let torus = shapes::torus(1.0, 0.4, 24, 12).unwrap();
    let mut positions = torus.positions().to_vec();
    positions.push([0.0, 0.0, 3.0]);
    let mut faces = torus.triangles().to_vec();
    faces.push([150, 151, positions.len() as u32 - 1]);
    let finned = TriangleMesh::new(positions, faces).unwrap();
    let meridian = Curve::signed((0..=12).map(|j| Vertex(3 * 12 + j % 12)));
    let w = solve(&finned, vec![meridian]);
    assert!(
        w.report.warnings.iter().any(|text| text.kind() == "nonmanifold_edges"),
        "{:?}",
        w.report.warnings
    );
    assert!((w.report.largest_nonbounding - 1.0).abs() < 1e-9);
}

#[test]
fn components_have_their_own_zero() {
    let sphere = shapes::geodesic_sphere(8).unwrap();
    let n = sphere.vertex_count() as u32;
    let mut positions = sphere.positions().to_vec();
    positions.extend(sphere.positions().iter().map(|p| [p[0] + 3.0, p[1], p[2]]));
    let mut faces = sphere.triangles().to_vec();
    faces.extend(sphere.triangles().iter().map(|f| f.map(|v| v + n)));
    let both = TriangleMesh::new(positions, faces).unwrap();
    let cap = |f: Face| centre(&both, f)[2] > 0.5 && centre(&both, f)[0] < 1.5;
    let w = solve(&both, boundary_of(&both, cap));
    assert!(both.faces().all(|f| w.labels[f] == i32::from(cap(f))));
    // A reference face moves the zero in its component only.
    let top = both.faces().find(|&f| cap(f)).unwrap();
    let options = WindingOptions::default().with_reference(Reference::Face(top));
    let curves = SurfaceCurves { curves: boundary_of(&both, cap), points: Vec::new() };
    let w = surface_winding_number(&both, &curves, &options).unwrap();
    let first = |f: Face| centre(&both, f)[0] < 1.5;
    assert!(both.faces().all(|f| w.labels[f] == if first(f) && !cap(f) { -1 } else { 0 }));
}

#[test]
fn a_fin_gives_a_warning_and_changes_little_elsewhere() {
    let sphere = shapes::geodesic_sphere(10).unwrap();
    let cap = |f: Face| centre(&sphere, f)[2] > 0.3;
    let curves = boundary_of(&sphere, cap);
    // A triangle attached to an edge of the curve.
    let &[SurfacePoint::Vertex { vertex: a }, SurfacePoint::Vertex { vertex: b }] =
        curves[0].nodes.as_slice()
    else {
        panic!("a side runs from vertex to vertex")
    };
    let mut positions = sphere.positions().to_vec();
    positions.push([0.0, 0.0, 5.0]);
    let mut faces = sphere.triangles().to_vec();
    faces.push([a, b, sphere.vertex_count() as u32]);
    let finned = TriangleMesh::new(positions, faces).unwrap();
    let w = solve(&finned, curves);
    assert!(
        w.report.warnings.iter().any(|text| text.kind() == "nonmanifold_edges"),
        "{:?}",
        w.report.warnings
    );
    assert!(
        w.values.iter().filter(|(_, v)| v.is_nan()).count() < 40,
        "all corners but those at the ends have values"
    );
    let wrong = sphere.faces().filter(|&f| w.labels[f] != i32::from(cap(f))).count();
    assert!(wrong < sphere.face_count() / 50, "{wrong} faces");
}

#[test]
fn rigid_motions_and_scaling_change_no_label() {
    let torus = damage::jitter(&shapes::torus(1.0, 0.4, 24, 12).unwrap(), 0.2, 3).unwrap();
    let mut open = boundary_of(&torus, |f| centre(&torus, f)[0] > 1.1);
    open.truncate(open.len() * 3 / 4);
    open.push(Curve::signed((0..10).map(|j| Vertex(12 * 12 + j))));
    let plain = solve(&torus, open.clone());
    let (c, s) = (0.6, 0.8);
    let turned = |[x, y, z]: [f64; 3]| [c * x - s * z, y, s * x + c * z];
    for scale in [1e-8, 1.0, 1e8] {
        let moved = torus.positions().iter().map(|&p| turned(p).map(|x| scale * (x + 3.0))).collect();
        let w = solve(&torus.with_positions(moved).unwrap(), open.clone());
        assert_eq!(w.labels, plain.labels);
        for e in torus.edges() {
            assert!((w.nonbounding[e] - plain.nonbounding[e]).abs() < 1e-6);
        }
    }
}

#[test]
fn bad_input_is_refused_with_the_reason() {
    let mesh = annulus();
    let refused = |curves: SurfaceCurves| {
        surface_winding_number(&mesh, &curves, &WindingOptions::default()).unwrap_err()
    };
    assert!(matches!(refused(SurfaceCurves::default()), WindingError::NoCurve));
    let far = SurfaceCurves::from_curve(Curve::signed([Vertex(0), Vertex(1_000_000)]));
    let WindingError::Curve(fault) = refused(far) else { panic!("the curve is not on the mesh") };
    assert!(fault.to_string().contains("curve 0, node 1"), "{fault}");
    let unsigned = SurfaceCurves::from_curve(Curve::unsigned([Vertex(0), Vertex(1)]));
    assert!(matches!(refused(unsigned), WindingError::Unsigned { curve: 0 }));
    for epsilon in [0.0, -1.0, f64::NAN, 2.0] {
        let curves = SurfaceCurves::from_curve(Curve::signed([Vertex(0), Vertex(1)]));
        let options = WindingOptions::default().with_epsilon(epsilon);
        let error = surface_winding_number(&mesh, &curves, &options).unwrap_err();
        assert!(matches!(error, WindingError::Option { name: "epsilon", .. }));
    }
    let empty = TriangleMesh::new(vec![[0.0; 3]], Vec::new()).unwrap();
    let curves = SurfaceCurves::from_curve(Curve::signed([Vertex(0), Vertex(0)]));
    let error = surface_winding_number(&empty, &curves, &WindingOptions::default()).unwrap_err();
    assert!(matches!(error, WindingError::NoFaces));
}

#[test]
fn cancelling_copies_leave_nothing_and_give_a_warning() {
    let sphere = shapes::geodesic_sphere(6).unwrap();
    let loops = boundary_of(&sphere, |f| centre(&sphere, f)[2] > 0.2);
    let back: Vec<Curve> = loops.iter().cloned().map(Curve::reversed).collect();
    let w = solve(&sphere, [loops.clone(), back].concat());
    assert!(w.labels.iter().all(|(_, label)| *label == 0));
    assert!(
        w.report.warnings.iter().any(|text| text.to_string().contains("cancel")),
        "{:?}",
        w.report.warnings
    );
    // Twice in one direction counts twice.
    let w = solve(&sphere, [loops.clone(), loops].concat());
    assert!(sphere.faces().all(|f| w.labels[f] == if centre(&sphere, f)[2] > 0.2 { 2 } else { 0 }));
}

/// A curve across faces: the mesh is cut along it.
#[test]
fn a_circle_across_the_faces_of_a_sphere_and_of_a_torus() {
    let sphere = shapes::geodesic_sphere(12).unwrap();
    let circle = plane_cut(&sphere, [0.0, 0.0, 0.3], [0.0, 0.0, 1.0]).unwrap().remove(0);
    let curves = SurfaceCurves::from_curve(circle);
    let w = surface_winding_number(&sphere, &curves, &WindingOptions::default()).unwrap();
    assert!(w.mesh.face_count() > sphere.face_count());
    let parents: Vec<Face> = w.provenance.face_parents().collect();
    assert_eq!(parents.len(), w.mesh.face_count());
    for v in w.mesh.vertices() {
        let place = w.provenance.vertex_place(v).unwrap().locate(&sphere).unwrap().position(&sphere);
        assert!((0..3).all(|k| (place[k] - w.mesh.position(v)[k]).abs() < 1e-12));
    }
    assert_eq!(w.provenance.vertex_place(Vertex(7)), Some(Vertex(7).into()));
    assert_eq!(w.provenance.vertex_place(Vertex(w.mesh.vertex_count() as u32)), None);
    let above = |f: Face| centre(&w.mesh, f)[2] > 0.3;
    let label_above = w.labels[w.mesh.faces().find(|&f| above(f)).unwrap()];
    let label_below = w.labels[w.mesh.faces().find(|&f| !above(f)).unwrap()];
    assert_eq!((label_above - label_below).abs(), 1);
    assert!(w.mesh.faces().all(|f| w.labels[f] == if above(f) { label_above } else { label_below }));
    let options = WindingOptions::default().with_reference(Reference::Face(Face(1_000_000)));
    let error = surface_winding_number(&sphere, &curves, &options).unwrap_err();
    assert!(matches!(error, WindingError::Option { name: "reference", .. }));
    // Around the tube of a torus, where it bounds nothing.
    let torus = shapes::torus(1.0, 0.4, 30, 16).unwrap();
    let halves = plane_cut(&torus, [0.0, 0.011, 0.0], [0.0, 1.0, 0.0]).unwrap();
    assert_eq!(halves.len(), 2);
    let one = SurfaceCurves::from_curve(halves[0].clone());
    let w = surface_winding_number(&torus, &one, &WindingOptions::default()).unwrap();
    assert!(w.labels.iter().all(|(_, label)| *label == 0));
    assert!((w.report.largest_nonbounding - 1.0).abs() < 1e-9);
    // The plane makes both cuts, which bound a half.
    let both = SurfaceCurves { curves: halves, points: Vec::new() };
    let w = surface_winding_number(&torus, &both, &WindingOptions::default()).unwrap();
    assert!(w.report.largest_nonbounding < 1e-9);
    let half = |f: Face| centre(&w.mesh, f)[1] > 0.011;
    assert!(
        w.mesh.faces().all(|f| (w.labels[f] != 0) == half(f))
            || w.mesh.faces().all(|f| (w.labels[f] == 0) == half(f))
    );
}

/// Only lengths along the surface matter: a sheet folded along a line of edges has the same winding
/// numbers.
#[test]
fn folding_changes_nothing() {
    let flat = shapes::grid(20, 12, 20.0, 12.0, shapes::Diagonal::Alternating).unwrap();
    let middle = flat
        .position(nearest(&flat, [0.5 * flat.position(Vertex(flat.vertex_count() as u32 - 1))[0], 0.0, 0.0]))
        [0];
    let fold = |[x, y, z]: [f64; 3]| if x > middle { [middle, y, z + x - middle] } else { [x, y, z] };
    let folded = flat.with_positions(flat.positions().iter().map(|&p| fold(p)).collect()).unwrap();
    assert!(folded.positions().iter().any(|p| p[2] > 1.0));
    // Two arcs of a circle around the middle of the fold.
    let centre_of_grid = [middle, 0.5 * flat.position(Vertex(flat.vertex_count() as u32 - 1))[1], 0.0];
    let inside = |f: Face| {
        let c = centre(&flat, f);
        (0..3).map(|k| (c[k] - centre_of_grid[k]).powi(2)).sum::<f64>() < 16.0
    };
    let mut arcs = boundary_of(&flat, inside);
    arcs.truncate(arcs.len() * 3 / 4);
    let (one, other) = (solve(&flat, arcs.clone()), solve(&folded, arcs));
    assert!(!one.endpoints.is_empty() && one.endpoints == other.endpoints);
    assert_eq!(one.labels, other.labels);
    assert!(one.labels.iter().any(|(_, label)| *label != 0));
    for (c, w) in one.values.iter().filter(|(_, w)| !w.is_nan()) {
        assert!((w - other.values[c]).abs() < 1e-9);
    }
}

/// Two vertices of a torus merged in the gap of a broken loop around the tube: the loop is
/// completed through them. The winding number is undefined there; elsewhere its jumps are the same
/// at both ends of an edge.
#[test]
fn a_completed_loop_through_a_pinched_vertex_keeps_its_jumps() {
    let torus = shapes::torus(1.0, 0.4, 30, 15).unwrap();
    let number = |i: u32, j: u32| 15 * i + j;
    let (pinched, other) = (number(7, 12), number(22, 12));
    let faces = torus.triangles().iter().map(|f| f.map(|v| if v == other { pinched } else { v })).collect();
    let mesh = TriangleMesh::new(torus.positions().to_vec(), faces).unwrap();
    let arc = SurfaceCurves::from_curve(Curve::signed((0..=10).map(|j| Vertex(number(7, j)))));
    for (completion, intrinsic_delaunay) in
        [(Completion::Full, false), (Completion::Full, true), (Completion::Curve, true)]
    {
        let options =
            WindingOptions::default().with_completion(completion).with_intrinsic_delaunay(intrinsic_delaunay);
        let w = surface_winding_number(&mesh, &arc, &options).unwrap();
        let is_full = completion == Completion::Full;
        assert_eq!(
            w.report.warnings.iter().any(|text| text.to_string().contains("(first: vertex 117)")),
            is_full
        );
        let mut most = 0.0f64;
        for e in w.mesh.edges() {
            let &[a, b] = w.mesh.edge_halfedges(e) else { continue };
            for v in w.mesh.edge_vertices(e) {
                let at = |f: Face| {
                    let k = w.mesh.face_vertices(f).iter().position(|u| *u == v).unwrap();
                    w.values.as_slice()[3 * f.index() + k]
                };
                let jump = at(a.face()) - at(b.face());
                let left_out = w.endpoints.contains(&v) || (v.0 == pinched && is_full);
                assert_eq!(jump.is_nan(), left_out, "{v}");
                if !jump.is_nan() && is_full {
                    assert!((jump - w.bounding_jump(e)).abs() < 1e-9, "{v}: {jump}");
                    most = most.max(jump.abs());
                }
            }
        }
        assert!(most > 0.2 || !is_full, "{most}");
    }
}

/// The largest part of the reference face decides, at any scale.
#[test]
fn the_reference_of_a_cut_face_does_not_depend_on_scale() {
    let square = shapes::grid(1, 1, 1.0, 1.0, shapes::Diagonal::Alternating).unwrap();
    let [a, b, c] = square.triangles()[0];
    let at = |bary| SurfacePoint::Face { vertices: [a, b, c], bary };
    let corners = [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8], [0.8, 0.1, 0.1]];
    let curve = SurfaceCurves::from_curve(Curve::signed(corners.map(at)));
    let options = WindingOptions::default().with_reference(Reference::Face(Face(0)));
    let labels = [1e-170, 1.0, 1e170].map(|scale| {
        let scaled = square.positions().iter().map(|p| p.map(|x| scale * x)).collect();
        surface_winding_number(&square.with_positions(scaled).unwrap(), &curve, &options).unwrap().labels
    });
    assert!(labels[0] == labels[1] && labels[1] == labels[2]);
    assert!(labels[1].iter().any(|(_, label)| *label == 0) && labels[1].iter().any(|(_, label)| *label != 0));
}
