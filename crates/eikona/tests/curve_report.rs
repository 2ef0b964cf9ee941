//! Reports on curves with known defects.

mod shapes;
use eikona::contour::plane_cut;
use eikona::curves::{CurveReport, MeetingKind, SegmentId, trace_polyline};
use eikona::spatial::Bvh;
use eikona_mesh::{Curve, CurveKind, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex, read_curves};
use shapes::{DATA, flat_grid, moebius, read_mesh, sphere};

fn edge(a: u32, b: u32, t: f64) -> SurfacePoint {
    SurfacePoint::Edge { vertices: [a, b], t }
}

fn vertices(of: &[u32]) -> Vec<Vertex> {
    of.iter().map(|&v| Vertex(v)).collect()
}

fn report(mesh: &TriangleMesh, curves: Vec<Curve>) -> CurveReport {
    CurveReport::of(mesh, &SurfaceCurves { curves, points: Vec::new() }).unwrap()
}

#[test]
fn lengths_and_open_ends() {
    let mesh = flat_grid(4);
    // A square of side 1/2 with a gap of one edge, and a line.
    let curves =
        vec![Curve::signed(vertices(&[6, 7, 8, 13, 18, 17, 16, 11])), Curve::signed(vertices(&[0, 1, 2]))];
    let found = report(&mesh, curves);
    assert_eq!(found.curves[0].length, 1.75);
    assert!(!found.curves[0].closed);
    let nearest: Vec<_> = found.open_ends.iter().map(|e| e.nearest.unwrap()).collect();
    assert_eq!(nearest[1], (0, 0.25), "the end of the square is nearest to its own start");
    assert_eq!((found.meetings.len(), found.overlaps.len()), (0, 0));
    let closed = report(&mesh, vec![Curve::signed(vertices(&[6, 7, 12, 6]))]);
    assert!(closed.curves[0].closed && closed.open_ends.is_empty() && closed.meetings.is_empty());
}

#[test]
fn crossings_inside_faces_and_at_nodes() {
    let mesh = TriangleMesh::new(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], vec![[0, 1, 2]]).unwrap();
    let a = Curve::signed([edge(0, 1, 0.25), edge(1, 2, 0.5)]);
    let b = Curve::signed([edge(0, 1, 0.5), edge(0, 2, 0.5)]);
    let c = Curve::signed([edge(0, 1, 0.125), edge(0, 2, 0.125)]);
    let found = report(&mesh, vec![a, b, c]);
    assert_eq!(found.meetings.len(), 1);
    assert_eq!(found.meetings[0].kind, MeetingKind::Crossing);
    // y = 2 (x - 1/4) meets x + y = 1/2.
    let p = found.meetings[0].position;
    assert!((p[0] - 1.0 / 3.0).abs() < 1e-15 && (p[1] - 1.0 / 6.0).abs() < 1e-15, "{p:?}");

    let mesh = flat_grid(2);
    let across = [Curve::signed(vertices(&[3, 4, 5])), Curve::signed(vertices(&[1, 4, 7]))];
    let found = report(&mesh, across.to_vec());
    assert_eq!((found.meetings.len(), found.meetings[0].kind), (1, MeetingKind::SharedNode));
    // A curve that ends on another touches it; one that ends where another starts continues it.
    let touching = report(&mesh, vec![across[0].clone(), Curve::signed(vertices(&[1, 4]))]);
    assert_eq!((touching.meetings.len(), touching.meetings[0].kind), (1, MeetingKind::Touching));
    assert!(report(&mesh, vec![across[0].clone(), Curve::signed(vertices(&[5, 8]))]).meetings.is_empty());
    // A figure eight meets itself.
    assert_eq!(report(&mesh, vec![Curve::signed(vertices(&[0, 1, 4, 5, 8, 4, 0]))]).meetings.len(), 1);
}

#[test]
fn doubled_pieces_and_segments_across_faces() {
    let mesh = flat_grid(2);
    let curves = vec![
        Curve::signed(vertices(&[0, 1, 2])),
        Curve::signed(vertices(&[1, 0])),
        Curve::signed([edge(1, 2, 0.25), edge(1, 2, 0.75)]),
        Curve::signed(vertices(&[0, 8, 8])),
    ];
    let set = SurfaceCurves { curves, points: Vec::new() };
    let found = CurveReport::of(&mesh, &set).unwrap();
    let id = |curve, node| SegmentId { curve, node };
    assert_eq!(found.overlaps.len(), 2);
    assert_eq!(found.overlaps[0].segments, [id(0, 0), id(1, 0)]);
    assert_eq!((found.overlaps[0].same_direction, found.overlaps[0].length), (false, 0.5));
    assert_eq!(found.overlaps[1].segments, [id(0, 1), id(2, 0)]);
    assert_eq!((found.overlaps[1].same_direction, found.overlaps[1].length), (true, 0.25));
    assert_eq!(found.curves[3].across_faces, [0]);
    assert_eq!(found.curves[3].zero_length, [1]);
    assert_eq!(found.warnings(&set).len(), 3);
}

#[test]
fn the_core_of_a_moebius_strip_is_one_sided() {
    let mesh = moebius(24, 4);
    let round: Vec<Vertex> = (0..=24).map(|i| Vertex((i % 24) * 5 + 2)).collect();
    let found = report(&mesh, vec![Curve::signed(round)]);
    assert!(found.curves[0].closed && found.curves[0].one_sided);
    // Once around beside the middle and once more: two sides, whatever the order of the corners.
    let twice: Vec<Vertex> =
        (0..=48).map(|i| Vertex((i % 24) * 5 + if i / 24 % 2 == 0 { 1 } else { 3 })).collect();
    for mesh in [&mesh, &mesh.with_flipped_faces(|f| f.0 % 7 < 3)] {
        let found = report(mesh, vec![Curve::signed(twice.clone())]);
        assert!(found.curves[0].closed && !found.curves[0].one_sided);
        assert!(found.curves[0].across_faces.is_empty());
    }
    let mixed = sphere(3).with_flipped_faces(|f| f.0 % 3 == 0);
    let cut = plane_cut(&mixed, [0.0, 0.0, 0.1], [0.1, 0.2, 1.0]).unwrap();
    assert!(!report(&mixed, cut).curves[0].one_sided);
}

#[test]
fn crossings_of_a_traced_pentagram_are_counted() {
    // A pentagram crosses itself five times.
    let mesh = flat_grid(50);
    let star: Vec<[f64; 3]> = (0..5)
        .map(|i| {
            let a = 0.1 + 2.0 * i as f64 * std::f64::consts::TAU / 5.0;
            [0.5 + 0.4 * a.cos(), 0.5 + 0.4 * a.sin(), 0.0]
        })
        .collect();
    let traced = trace_polyline(&mesh, &Bvh::new(&mesh), &star, true, CurveKind::Signed, 1e-6).unwrap();
    let found = report(&mesh, vec![traced.curve]);
    assert_eq!(found.meetings.len(), 5);
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn curves_of_the_data_folder_are_reported() {
    let mut run = 0;
    for (name, host) in [
        ("swn/bunny-heart", "closed/bunny"),
        ("swn/bunny-brokenheart", "closed/bunny"),
        ("shm/mobius-orientable-curve", "nonorientable/mobius-orientable-curve"),
        ("shm/bumpy-sphere", "curves/shm/bumpy-sphere"),
        ("swn/asymmetric-torus", "curves/swn/asymmetric-torus"),
        ("shm/screwdriver", "nonmanifold/screwdriver"),
    ] {
        let mesh = read_mesh(format!("{DATA}/{host}.obj")).expect(host);
        let file = read_curves(format!("{DATA}/curves/{name}.txt"), &mesh).unwrap();
        let found = CurveReport::of(&mesh, &file.curves).unwrap();
        run += 1;
        println!(
            "{name}: length {:.4}, {} open ends, {} meetings, {} doubled, {:?}",
            found.length(),
            found.open_ends.len(),
            found.meetings.len(),
            found.overlaps.len(),
            found.warnings(&file.curves)
        );
        assert!(found.curves.iter().all(|c| c.across_faces.is_empty()));
        match name {
            "swn/bunny-heart" => assert!(found.open_ends.is_empty() && found.meetings.is_empty()),
            "swn/bunny-brokenheart" => assert_eq!(found.open_ends.len(), 2),
            _ => {}
        }
    }
    println!("reports on {run} files");
}

/// A curve that passes a vertex of 20,000 faces 20,000 times, on a consistently oriented fan and on
/// one with a flipped face.
#[test]
fn a_hub_passed_many_times_is_fast() {
    let n = 20_000u32;
    let rim = |i: u32| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        [angle.cos(), angle.sin(), 0.0]
    };
    let positions: Vec<[f64; 3]> = std::iter::once([0.0; 3]).chain((0..n).map(rim)).collect();
    for turned in [n, 7] {
        let face = |i: u32| {
            let (a, b) = (1 + i, 1 + (i + 1) % n);
            if i == turned { [0, b, a] } else { [0, a, b] }
        };
        let fan = TriangleMesh::new(positions.clone(), (0..n).map(face).collect()).unwrap();
        let there_and_back = (0..n).flat_map(|i| [0, 1 + i * 7919 % n]).chain([0]);
        let found = report(&fan, vec![Curve::signed(there_and_back.map(Vertex))]);
        assert!(found.curves[0].closed && !found.curves[0].one_sided);
        assert!(found.truncated && found.overlaps.iter().all(|d| !d.same_direction));
    }
}
