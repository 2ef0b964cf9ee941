//! Domains of every kind: with boundary, disconnected, nonorientable, degenerate.

mod exact;

use eikona::contour::isolines;
use eikona::operators::CotanLaplacian;
use eikona::signed_heat::{DiffusionTime, LevelSets, Solution};
use eikona_mesh::{
    Curve, Face, Neighbour, SurfaceCurves, TriangleMesh, Vertex, damage,
    shapes::{self, Diagonal},
};
use eikona_numeric::{Cholesky, Ordering, Symbolic};
use exact::*;

/// Half of a disk with the straight side on y = 0.
fn half_disk(rings: usize) -> TriangleMesh {
    let disk = shapes::disk(rings, 6, 1.0).unwrap();
    let faces: Vec<[u32; 3]> = disk
        .triangles()
        .iter()
        .copied()
        .filter(|f| f.iter().all(|&v| disk.positions()[v as usize][1] > -1e-9))
        .collect();
    eikona_mesh::drop_unreferenced_vertices(&TriangleMesh::new(disk.positions().to_vec(), faces).unwrap())
        .mesh
}

/// Straight lines that meet the boundary: the distance is linear up to the boundary, even where the
/// diffusion reaches it.
#[test]
fn isolines_are_straight_at_the_boundary() {
    let rectangle = shapes::grid(20, 30, 2.0, 3.0, Diagonal::Alternating).unwrap();
    let holes = damage::holes(&rectangle, 4, 1, 2).unwrap().mesh;
    for (name, mesh, exact) in [
        ("half disk", half_disk(24), Box::new(|p: [f64; 3]| p[0] - 0.13) as Box<dyn Fn([f64; 3]) -> f64>),
        ("slanted on a rectangle", rectangle, Box::new(|p: [f64; 3]| 0.6 * p[0] - 0.8 * p[1] + 0.4)),
        ("rectangle with holes", holes, Box::new(|p: [f64; 3]| 0.8 * p[0] + 0.6 * p[1] - 1.7)),
    ] {
        let source = zero_level(&mesh, &exact);
        for coefficient in [1.0, 100.0, 1e4] {
            for level_sets in [LevelSets::Free, LevelSets::Zero] {
                let time = DiffusionTime::Coefficient(coefficient);
                let e = errors(&mesh, solve(&mesh, &source, time, level_sets).distance.as_slice(), &exact);
                assert!(e.largest < 1e-9, "{name}, {coefficient}, {level_sets:?}: {e:?}");
            }
        }
    }
}

/// For each face at the boundary of a plate, the angle between a field and the gradient of a
/// function.
fn angles_at_the_boundary(
    mesh: &TriangleMesh,
    field: impl Fn(Face) -> [f64; 3],
    exact: impl Fn([f64; 3]) -> [f64; 3],
) -> Vec<f64> {
    let at_boundary = |f: &Face| (0..3).any(|k| mesh.neighbour(f.halfedge(k)) == Neighbour::Boundary);
    let angle = |f: Face| {
        let [a, b, c] = mesh.face_positions(f);
        eikona::geometry::vector::angle(field(f), exact([0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)))
    };
    mesh.faces().filter(at_boundary).map(angle).collect()
}

/// Field of the unsigned heat method, not normalised: minus the gradient of heat that starts along
/// the curve and can not leave the surface.
fn unsigned_heat_field(mesh: &TriangleMesh, source: &SurfaceCurves, time: f64) -> Vec<[f64; 3]> {
    let triangles = eikona::geometry::lay_out(mesh);
    let CotanLaplacian { graph, mut matrix } = CotanLaplacian::new(mesh, &triangles);
    matrix.diagonal.iter_mut().zip(vertex_areas(mesh)).for_each(|(d, area)| *d = area + time * *d);
    matrix.off_diagonal.iter_mut().for_each(|x| *x *= time);
    let mut heat = vec![0.0; mesh.vertex_count()];
    for segment in source.segments(mesh).unwrap() {
        let [p, q] = segment.ends.map(|end| end.position(mesh));
        for (v, w) in segment.ends.iter().flat_map(|end| end.weights(mesh)) {
            heat[v.index()] += w * norm(sub(p, q));
        }
    }
    let symbolic = Symbolic::new(&graph, Ordering::MinimumDegree).unwrap();
    let u = Cholesky::new(symbolic.into(), &matrix).unwrap().solve(&heat).unwrap();
    let gradient = |f: Face| {
        let p = mesh.face_positions(f);
        let normal = cross(sub(p[1], p[0]), sub(p[2], p[0]));
        let parts = [0, 1, 2].map(|k| {
            let side = cross(normal, sub(p[(k + 2) % 3], p[(k + 1) % 3]));
            side.map(|x| -x * u[mesh.face_vertices(f)[k].index()])
        });
        [0, 1, 2].map(|c| parts[0][c] + parts[1][c] + parts[2][c])
    };
    mesh.faces().map(gradient).collect()
}

/// Figure 8 of the paper. At t = 100 h^2 (h the mean edge length), the unsigned heat method bends
/// its field along the boundary, since heat does not cross it. The field of the signed heat method
/// keeps its direction there: it is exact for a line that ends at the boundary at an angle, and
/// correct up to the smoothing at such a time for a circle.
#[test]
fn figure_8_field_is_accurate_at_the_boundary() {
    let mesh = rough_plate(48);
    let h = mean_edge_length(&mesh);
    let slanted = |p: [f64; 3]| 0.8 * p[0] + 0.6 * p[1] - 1.4;
    let round = |p: [f64; 3]| (p[0] - 1.0).hypot(p[1] - 1.0) - 0.5;
    let from_centre = |p: [f64; 3]| sub(p, [1.0, 1.0, 0.0]);
    let normal = |_: [f64; 3]| [0.8, 0.6, 0.0];
    let mean = |angles: &[f64]| angles.iter().sum::<f64>() / angles.len() as f64;
    for (name, source, exact, bound) in [
        ("slanted line", zero_level(&mesh, slanted), &normal as &dyn Fn([f64; 3]) -> [f64; 3], 1e-9),
        ("circle", zero_level(&mesh, round), &from_centre, 0.06),
    ] {
        let time = DiffusionTime::Coefficient(400.0); // of (h / 2)^2
        let solution = solve(&mesh, &source, time, LevelSets::Free);
        assert!((solution.report.time.time / (100.0 * h * h) - 1.0).abs() < 1e-12);
        let signed = angles_at_the_boundary(&mesh, |f| solution.gradient[f], exact);
        let unsigned_field = unsigned_heat_field(&mesh, &source, 100.0 * h * h);
        // The unsigned field is oriented by the known sides.
        let oriented = |f: Face| {
            let [a, b, c] = mesh.face_positions(f);
            let expected = exact([0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0));
            let y = unsigned_field[f.index()];
            if dot(y, expected) < 0.0 { y.map(|x| -x) } else { y }
        };
        let unsigned = angles_at_the_boundary(&mesh, oriented, exact);
        let (signed, unsigned, worst) = (mean(&signed), mean(&unsigned), largest(&signed));
        println!("{name}: signed {signed:.2e} (at most {worst:.2e}), unsigned {unsigned:.2e}");
        assert!(signed < bound, "{name}: {signed}");
        assert!(unsigned > 0.25 && unsigned > 5.0 * signed, "{name}: unsigned {unsigned}, signed {signed}");
    }
}

/// Two components with a line each, and one without.
fn three_components() -> (TriangleMesh, SurfaceCurves) {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    let mut source = SurfaceCurves::default();
    for (piece, line) in [(0, Some(1.0)), (1, Some(3.0)), (2, None)] {
        let grid = shapes::grid(4, 2, 4.0, 2.0, Diagonal::Uniform).unwrap();
        let base = positions.len() as u32;
        positions.extend(grid.positions().iter().map(|p| [p[0], p[1], 5.0 * piece as f64]));
        faces.extend(grid.triangles().iter().map(|f| f.map(|v| v + base)));
        if let Some(x) = line {
            let curve = through_vertices(&grid, |p| p[0] == x, |p| p[1]);
            let nodes = curve.nodes.iter().map(|n| match n {
                eikona_mesh::SurfacePoint::Vertex { vertex } => Vertex(vertex + base),
                _ => unreachable!(),
            });
            source.curves.push(Curve::signed(nodes));
        }
    }
    (TriangleMesh::new(positions, faces).unwrap(), source)
}

#[test]
fn components_have_their_own_zero() {
    let (mesh, source) = three_components();
    for level_sets in [LevelSets::Free, LevelSets::Zero, LevelSets::PerComponent, LevelSets::Soft(1e6)] {
        let solution = solve(&mesh, &source, PAPER_TIME, level_sets);
        assert_eq!(solution.distance.len(), mesh.vertex_count());
        for v in mesh.vertices() {
            let [x, _, z] = mesh.position(v);
            let d = solution.distance[v];
            match z {
                0.0 => assert!((d - (x - 1.0)).abs() < 1e-5, "{level_sets:?}, {v}: {d}"),
                5.0 => assert!((d - (x - 3.0)).abs() < 1e-5, "{level_sets:?}, {v}: {d}"),
                _ => assert!(d.is_nan(), "{level_sets:?}, {v} in a component without a source: {d}"),
            }
        }
        let warning = solution.report.all_warnings().find(|w| w.kind() == "unreached_component");
        assert!(warning.is_some_and(|w| w.to_string().contains("16 faces")), "{warning:?}");
    }
}

/// Position across a Moebius band: from its core, along the ruling.
fn across(mesh: &TriangleMesh, nv: usize, width: f64) -> Vec<f64> {
    let share = |v: Vertex| (v.index() % (nv + 1)) as f64 / nv as f64 - 0.5;
    mesh.vertices().map(|v| (width * share(v)).abs()).collect()
}

/// Rulings are geodesics, and the curves at a fixed distance from the core cross them at right
/// angles. Hence the distance to such a curve, which goes round twice and has two sides, is known.
#[test]
fn two_sided_curve_on_a_moebius_band() {
    let (nu, nv, width) = (160, 20, 0.8);
    let mesh = shapes::moebius_band(1.0, width, nu, nv).unwrap();
    let from_core = across(&mesh, nv, width);
    let exact: Vec<f64> = from_core.iter().map(|w| w - 0.19).collect();
    let curves = isolines(&mesh, &exact.clone().into(), &[0.0]).unwrap().remove(0).curves;
    assert_eq!(curves.len(), 1, "the curve goes round twice");
    let source = SurfaceCurves { curves, points: Vec::new() };
    for level_sets in [LevelSets::Free, LevelSets::Zero] {
        let solution = solve(&mesh, &source, PAPER_TIME, level_sets);
        assert!(solution.report.preparation.real_frames);
        assert!(!solution.report.all_warnings().any(|w| w.kind() == "one_sided_curve"));
        let worst = largest_difference(solution.distance.as_slice(), &exact);
        println!("two-sided on a Moebius band, {level_sets:?}: {worst:.2e}");
        assert!(worst < 0.02, "{level_sets:?}: {worst}");
    }
}

#[test]
fn one_sided_curve_raises_a_warning() {
    let (nu, nv) = (60, 8);
    let mesh = shapes::moebius_band(1.0, 0.6, nu, nv).unwrap();
    let middle = |i: usize| Vertex(((i % nu) * (nv + 1) + nv / 2) as u32);
    let core = Curve::signed((0..=nu).map(middle));
    let solution = solve(&mesh, &SurfaceCurves::from_curve(core.clone()), PAPER_TIME, LevelSets::Zero);
    assert!(solution.report.all_warnings().any(|w| w.kind() == "one_sided_curve"));
    assert!(solution.distance.as_slice().iter().all(|d| d.is_finite()));
    for i in 0..nu {
        assert!(solution.distance[middle(i)].abs() < 1e-6);
    }
    // Unsigned, the same curve is valid.
    let source = unsigned(SurfaceCurves::from_curve(core));
    let solution = solve(&mesh, &source, PAPER_TIME, LevelSets::Zero);
    let worst = largest_difference(solution.distance.as_slice(), &across(&mesh, nv, 0.6));
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn unsigned_curves_raise_no_warning_about_sides() {
    let (nu, nv) = (24, 4);
    let mesh = shapes::moebius_band(1.0, 0.6, nu, nv).unwrap();
    let core = Curve::unsigned((0..=nu).map(|i| Vertex(((i % nu) * (nv + 1) + nv / 2) as u32)));
    let solution = solve(&mesh, &SurfaceCurves::from_curve(core), PAPER_TIME, LevelSets::Zero);
    assert!(!solution.report.all_warnings().any(|w| w.kind() == "one_sided_curve"));
}

/// A short curve across the band with a given normal: the opposite normal negates the distance.
#[test]
fn given_normal_on_a_moebius_band() {
    let (nu, nv) = (60, 8);
    let mesh = shapes::moebius_band(1.0, 0.6, nu, nv).unwrap();
    let at = |i: usize, j: usize| Vertex((i * (nv + 1) + j) as u32);
    // Half a turn on, the band stands upright: its normal points to or from the axis.
    let near = [29, 31].map(|i| at(i, 4));
    let arc = |up: [f64; 3]| Curve { up: Some(up), ..Curve::signed((0..=nv).map(|j| at(30, j))) };
    let solve = |up| solve(&mesh, &SurfaceCurves::from_curve(arc(up)), PAPER_TIME, LevelSets::Zero).distance;
    let (out, inwards) = (solve([-1.0, 0.0, 0.0]), solve([1.0, 0.0, 0.0]));
    assert!(
        largest_difference(out.as_slice(), &inwards.as_slice().iter().map(|x| -x).collect::<Vec<_>>()) < 1e-7
    );
    // Upwards along z, seen from outside (x < 0): on the band, larger y is left.
    let left = near.into_iter().find(|&v| mesh.position(v)[1] > 0.0).unwrap();
    let right = near.into_iter().find(|&v| mesh.position(v)[1] < 0.0).unwrap();
    assert!(mesh.position(at(30, nv))[2] > mesh.position(at(30, 0))[2]);
    assert!(out[left] < 0.0 && out[right] > 0.0, "{} and {}", out[left], out[right]);
}

/// On a Klein bottle, the isoline of an even function of the figure eight's parameter bounds a
/// region: the signs are those of the function.
#[test]
fn klein_bottle() {
    let (nu, nv) = (80, 40);
    let mesh = shapes::klein_bottle(2.5, nu, nv).unwrap();
    let values: Vec<f64> = mesh
        .vertices()
        .map(|v| (std::f64::consts::TAU * ((v.index() % nv) as f64 + 0.5) / nv as f64).cos() - 0.2)
        .collect();
    let curves = isolines(&mesh, &values.clone().into(), &[0.0]).unwrap().remove(0).curves;
    let solution = solve(&mesh, &SurfaceCurves { curves, points: Vec::new() }, PAPER_TIME, LevelSets::Zero);
    for v in mesh.vertices() {
        let d = solution.distance[v];
        assert!(d.is_finite());
        // The function is negative on the left of its isoline.
        assert!(values[v.index()].abs() < 0.1 || (d < 0.0) == (values[v.index()] < 0.0), "{v}: {d}");
    }
    assert!(largest(solution.distance.as_slice()) > 1.0);
}

#[test]
fn unreferenced_vertices_are_nan() {
    let grid = shapes::grid(6, 3, 6.0, 3.0, Diagonal::Alternating).unwrap();
    let n = grid.vertex_count();
    for places in [vec![0], vec![n], vec![0, 7, 20, n]] {
        let mut positions = Vec::new();
        let mut number = vec![0u32; n];
        for v in 0..=n {
            if places.contains(&v) {
                positions.push([50.0, 50.0, 50.0]);
            }
            if v < n {
                number[v] = positions.len() as u32;
                positions.push(grid.positions()[v]);
            }
        }
        let faces = grid.triangles().iter().map(|f| f.map(|v| number[v as usize])).collect();
        let mesh = TriangleMesh::new(positions, faces).unwrap();
        let curve = through_vertices(&mesh, |p| p[0] == 2.0, |p| p[1]);
        for level_sets in [LevelSets::Free, LevelSets::Zero, LevelSets::PerComponent, LevelSets::Soft(1e4)] {
            let source = SurfaceCurves::from_curve(curve.clone());
            let solution = solve(&mesh, &source, PAPER_TIME, level_sets);
            assert_eq!(solution.distance.len(), n + places.len());
            for v in mesh.vertices() {
                let [x, ..] = mesh.position(v);
                let d = solution.distance[v];
                assert!(if x == 50.0 { d.is_nan() } else { (d - (x - 2.0)).abs() < 1e-6 }, "{v}: {d}");
            }
            let are = if places.len() == 1 { "vertex is" } else { "vertices are" };
            let expected = format!("{} {are} used by no face", places.len());
            assert!(solution.report.all_warnings().any(|w| w.to_string().contains(&expected)));
        }
    }
}

/// The distance to the line x = 2 on 6 x 3 squares, for variants of the mesh.
fn line_on_squares(mesh: &TriangleMesh, level_sets: LevelSets) -> (Solution, f64) {
    let curve = through_vertices(mesh, |p| p[0] == 2.0, |p| p[1]);
    let solution = solve(mesh, &SurfaceCurves::from_curve(curve), PAPER_TIME, level_sets);
    let worst = mesh.vertices().map(|v| (solution.distance[v] - (mesh.position(v)[0] - 2.0)).abs()).fold(
        0.0,
        |m, e| {
            if e.is_nan() { f64::INFINITY } else { f64::max(m, e) }
        },
    );
    (solution, worst)
}

/// The face on the rising edge from (4, 1) to (5, 2) is split, with a face of this height between
/// it and that edge.
fn with_sliver(grid: &TriangleMesh, height: f64) -> TriangleMesh {
    let (mut positions, mut faces) = (grid.positions().to_vec(), grid.triangles().to_vec());
    let [a, b, apex] = [[4.0, 1.0, 0.0], [5.0, 2.0, 0.0], [4.0, 2.0, 0.0]].map(|p| vertex_at(grid, p).0);
    let cut = faces.iter().position(|f| [a, b, apex].iter().all(|v| f.contains(v))).unwrap();
    let middle = positions.len() as u32;
    positions.push([4.5 - height * 0.5f64.sqrt(), 1.5 + height * 0.5f64.sqrt(), 0.0]);
    faces[cut] = [b, apex, middle];
    faces.push([apex, a, middle]);
    faces.push([a, b, middle]);
    TriangleMesh::new(positions, faces).unwrap()
}

#[test]
fn slivers_are_harmless() {
    let grid = shapes::grid(6, 3, 6.0, 3.0, Diagonal::Uniform).unwrap();
    for height in [0.0, 1e-12, 1e-9, 1e-6] {
        let mesh = with_sliver(&grid, height);
        for level_sets in [LevelSets::Free, LevelSets::Zero] {
            let (solution, worst) = line_on_squares(&mesh, level_sets);
            println!("sliver of height {height:e}, {level_sets:?}: {worst:.1e}");
            // Lengthening sides by 1e-8 gives a flat triangle angles of 1e-4, which turn the field
            // by as much.
            assert!(worst < 1e-4, "height {height:e}, {level_sets:?}: {worst:e}");
            let warned = solution.report.all_warnings().any(|w| w.kind() == "degenerate_faces");
            assert!(warned || height > 1e-8, "height {height:e}");
        }
    }
}

/// A height of a millionth is no problem in double precision: the values keep their digits.
#[test]
fn thin_faces_lose_no_digits() {
    let grid = shapes::grid(6, 3, 6.0, 3.0, Diagonal::Uniform).unwrap();
    for height in [1e-3, 1e-5, 1e-6] {
        let mesh = with_sliver(&grid, height);
        let (_, worst) = line_on_squares(&mesh, LevelSets::Free);
        assert!(worst < 1e-8, "height {height:e}: {worst:e}");
    }
}

/// Two coincident vertices, with degenerate faces between them.
#[test]
fn coincident_vertices_are_harmless() {
    let grid = shapes::grid(7, 3, 7.0, 3.0, Diagonal::Uniform).unwrap();
    // The column from x = 4 to x = 5 is squeezed to width 0: all its faces have two coincident
    // corners.
    let squeezed = |p: &[f64; 3]| [if p[0] > 4.5 { p[0] - 1.0 } else { p[0] }, p[1], p[2]];
    let mesh = grid.with_positions(grid.positions().iter().map(squeezed).collect()).unwrap();
    for level_sets in [LevelSets::Free, LevelSets::Zero] {
        let (_, worst) = line_on_squares(&mesh, level_sets);
        println!("coincident vertices, {level_sets:?}: {worst:.1e}");
        assert!(worst < 1e-5, "{level_sets:?}: {worst:e}");
    }
}
