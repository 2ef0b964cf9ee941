//! Bad input gives an error that names the element, or a correct result; never a panic, never a
//! silent NaN.

mod exact;

use eikona::numeric::NumericError;
use eikona::signed_heat::{DiffusionTime, LevelSets, SignedHeatError, SolveOptions, Solver, SolverOptions};
use eikona_mesh::{
    Curve, CurveError, MeshError, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex,
    shapes::{self, Diagonal},
};
use exact::*;

/// 4 x 2 squares; vertex 3 x + y is at (x, y), and diagonals rise.
fn plate() -> TriangleMesh {
    shapes::grid(4, 2, 4.0, 2.0, Diagonal::Uniform).unwrap()
}

fn refusal(source: SurfaceCurves) -> SignedHeatError {
    solver(&plate(), PAPER_TIME).solve(&source, &SolveOptions::default()).unwrap_err()
}

/// Returns the curve and node of an error, and the fault.
fn at_node(error: &SignedHeatError) -> (usize, usize, &CurveError) {
    match error {
        SignedHeatError::Curve(CurveError::AtNode { curve, node, fault }) => (*curve, *node, fault),
        other => panic!("{other:?}"),
    }
}

fn two_curves(second: Curve) -> SurfaceCurves {
    SurfaceCurves { curves: vec![Curve::signed([3, 4, 5].map(Vertex)), second], points: Vec::new() }
}

#[test]
fn vertex_out_of_range() {
    let error = refusal(two_curves(Curve::signed([6, 7, 99].map(Vertex))));
    let (curve, node, fault) = at_node(&error);
    assert_eq!((curve, node), (1, 2));
    assert_eq!(*fault, CurveError::VertexOutOfRange { vertex: 99, vertices: 15 });
    let message = error.to_string();
    assert!(
        message.contains("curve 1, node 2") && message.contains("99") && message.contains("15"),
        "{message}"
    );

    let mut point = SurfaceCurves::from_point(Vertex(4));
    point.points.push(Vertex(u32::MAX).into());
    let error = refusal(point);
    assert!(matches!(&error, SignedHeatError::Curve(CurveError::AtPoint { point: 1, .. })), "{error:?}");
    assert!(error.to_string().contains("point 1"), "{error}");
}

#[test]
fn curve_of_one_node_or_none() {
    for nodes in [vec![], vec![Vertex(4)]] {
        let n = nodes.len();
        let error = refusal(two_curves(Curve::signed(nodes)));
        assert_eq!(error, SignedHeatError::Curve(CurveError::TooFewNodes { curve: 1, nodes: n }));
        assert!(error.to_string().contains("curve 1"), "{error}");
    }
}

#[test]
fn segment_across_faces() {
    let error = refusal(two_curves(Curve::signed([6, 7, 14].map(Vertex))));
    let (curve, node, fault) = at_node(&error);
    assert_eq!((curve, node, fault), (1, 1, &CurveError::SegmentAcrossFaces));
    assert!(error.to_string().contains("curve 1, node 1") && error.to_string().contains("trace"), "{error}");
    // The diagonal that is not an edge: both ends lie in one square but not in a common face.
    assert!(matches!(refusal(two_curves(Curve::signed([1, 3].map(Vertex)))), SignedHeatError::Curve(_)));
}

#[test]
fn empty_source() {
    let error = refusal(SurfaceCurves::default());
    assert_eq!(error, SignedHeatError::Curve(CurveError::Empty));
}

#[test]
fn zero_length_curve() {
    let error = refusal(two_curves(Curve::signed([4, 4, 4].map(Vertex))));
    assert_eq!(error, SignedHeatError::Curve(CurveError::ZeroLength { curve: 1 }));
    assert!(error.to_string().contains("curve 1"), "{error}");
    // One repeated node is harmless.
    let mesh = plate();
    let curve = Curve::signed([3, 4, 4, 5].map(Vertex));
    let values = zero(&mesh, &SurfaceCurves::from_curve(curve));
    assert!(errors(&mesh, &values, |p| p[0] - 1.0).largest < 1e-9);
}

#[test]
fn weights_outside_the_edge_or_face() {
    let on_edge = |t: f64| SurfacePoint::Edge { vertices: [4, 5], t };
    let in_face = |bary: [f64; 3]| SurfacePoint::Face { vertices: [0, 3, 4], bary };
    for t in [f64::NAN, f64::INFINITY, -0.1, 1.1] {
        let error = refusal(two_curves(Curve::signed([Vertex(4).into(), on_edge(t)])));
        let (curve, node, fault) = at_node(&error);
        assert_eq!((curve, node), (1, 1));
        assert!(matches!(fault, CurveError::ParameterOutOfRange { .. }), "{t}: {fault:?}");
    }
    for bary in [[f64::NAN, 0.5, 0.5], [0.5, 0.5, 0.5], [-0.2, 0.6, 0.6], [0.0; 3], [f64::INFINITY, 0.0, 0.0]]
    {
        let error = refusal(two_curves(Curve::signed([Vertex(0).into(), in_face(bary)])));
        let (curve, node, fault) = at_node(&error);
        assert_eq!((curve, node), (1, 1));
        assert!(matches!(fault, CurveError::WeightsOutOfRange { .. }), "{bary:?}: {fault:?}");
        let error = refusal(SurfaceCurves::from_point(in_face(bary)));
        assert!(matches!(error, SignedHeatError::Curve(CurveError::AtPoint { point: 0, .. })), "{error:?}");
    }
}

#[test]
fn nonexistent_edges_and_faces() {
    let error = refusal(two_curves(Curve::signed([
        Vertex(4).into(),
        SurfacePoint::Edge { vertices: [0, 14], t: 0.5 },
    ])));
    assert_eq!(at_node(&error).2, &CurveError::NoSuchEdge { vertices: [0, 14] });
    assert!(error.to_string().contains("0 and 14"), "{error}");
    let face = SurfacePoint::Face { vertices: [0, 1, 14], bary: [0.3, 0.3, 0.4] };
    let error = refusal(two_curves(Curve::signed([Vertex(4).into(), face])));
    assert_eq!(at_node(&error).2, &CurveError::NoSuchFace { vertices: [0, 1, 14] });
    // The same vertex twice.
    let edge = SurfacePoint::Edge { vertices: [4, 4], t: 0.5 };
    assert!(matches!(refusal(SurfaceCurves::from_point(edge)), SignedHeatError::Curve(_)));
}

#[test]
fn options_out_of_range() {
    let mesh = plate();
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let options = SolverOptions::default().with_time(DiffusionTime::Coefficient(value));
        let error = Solver::new(&mesh, &options).unwrap_err();
        let SignedHeatError::Option { name, value: named, .. } = &error else { panic!("{error:?}") };
        assert_eq!((*name, named.to_bits()), ("time coefficient", value.to_bits()));
        assert!(error.to_string().contains("time coefficient"), "{error}");

        let source = SurfaceCurves::from_curve(Curve::signed([3, 4, 5].map(Vertex)));
        let error = solver(&mesh, PAPER_TIME).solve(&source, &levels(LevelSets::Soft(value))).unwrap_err();
        let SignedHeatError::Option { name, value: named, .. } = &error else { panic!("{error:?}") };
        assert_eq!((*name, named.to_bits()), ("soft weight", value.to_bits()));
    }
}

/// Positive but extreme times give a correct result or an error, not a silent NaN.
#[test]
fn extreme_times() {
    let mesh = plate();
    let source = SurfaceCurves::from_curve(Curve::signed([6, 7, 8].map(Vertex)));
    for coefficient in [1e-300, 1e-30, 1e-12, 1e12, 1e30, 1e300] {
        let time = DiffusionTime::Coefficient(coefficient);
        match Solver::new(&mesh, &SolverOptions::default().with_time(time)) {
            Err(error) => println!("coefficient {coefficient:e}: {error}"),
            Ok(solver) => match solver.solve(&source, &SolveOptions::default()) {
                Err(error) => println!("coefficient {coefficient:e}: {error}"),
                Ok(solution) if solution.distance.as_slice().iter().any(|d| d.is_nan()) => {
                    let warnings: Vec<_> = solution.report.all_warnings().collect();
                    println!("coefficient {coefficient:e}: NaN, {warnings:?}");
                    assert!(
                        warnings.iter().any(|w| w.to_string().contains("NaN")),
                        "{coefficient:e}: silent NaN"
                    );
                }
                Ok(solution) => {
                    let e = errors(&mesh, solution.distance.as_slice(), |p| p[0] - 2.0);
                    println!("coefficient {coefficient:e}: {e:?}");
                    assert!(e.largest < 1e-3, "{coefficient:e}: {e:?}");
                }
            },
        }
    }
}

#[test]
fn extreme_soft_weights() {
    let mesh = plate();
    let source = SurfaceCurves::from_curve(Curve::signed([6, 7, 8].map(Vertex)));
    for weight in [1e-300, 1e-30, 1e-12, 1e12, 1e30, 1e300] {
        match solver(&mesh, PAPER_TIME).solve(&source, &levels(LevelSets::Soft(weight))) {
            Err(error) => assert!(error.to_string().contains(&format!("{weight:e}")), "{error}"),
            Ok(solution) => {
                let e = errors(&mesh, solution.distance.as_slice(), |p| p[0] - 2.0);
                println!("weight {weight:e}: {e:?}");
                assert!(e.largest < 1e-3, "{weight:e}: {e:?}");
            }
        }
    }
}

#[test]
fn meshes_without_a_surface() {
    let none = TriangleMesh::new(vec![[0.0; 3]; 4], Vec::new()).unwrap();
    assert_eq!(Solver::new(&none, &SolverOptions::default()).unwrap_err(), SignedHeatError::NoFaces);
    let nothing = TriangleMesh::new(Vec::new(), Vec::new()).unwrap();
    assert_eq!(Solver::new(&nothing, &SolverOptions::default()).unwrap_err(), SignedHeatError::NoFaces);
    let line = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
    let flat = TriangleMesh::new(line, vec![[0, 1, 2], [1, 3, 2]]).unwrap();
    assert_eq!(Solver::new(&flat, &SolverOptions::default()).unwrap_err(), SignedHeatError::NoArea);
    let point = TriangleMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    assert_eq!(Solver::new(&point, &SolverOptions::default()).unwrap_err(), SignedHeatError::NoArea);
}

#[test]
fn invalid_vertices_and_faces_are_named() {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f64::NAN, 0.0, 0.0]];
    let error = TriangleMesh::new(positions, vec![[0, 1, 2], [0, 1, 9], [1, 1, 2]]).unwrap_err();
    let MeshError::Invalid(faults) = &error else { panic!("{error:?}") };
    assert_eq!(faults.len(), 3);
    let message = error.to_string();
    assert!(["vertex 3", "face 1", "vertex 9", "face 2"].iter().all(|id| message.contains(id)), "{message}");
}

#[test]
fn memory_limit() {
    let mesh = shapes::geodesic_sphere(20).unwrap();
    let with = |limit| Solver::new(&mesh, &SolverOptions::default().with_memory_limit(limit));
    let needed = match with(Some(1000)).unwrap_err() {
        SignedHeatError::Numeric(NumericError::MemoryLimit { needed_bytes, limit_bytes: 1000 }) => {
            needed_bytes
        }
        other => panic!("{other:?}"),
    };
    assert!(needed > 1_000_000, "{needed} bytes for {} edges", mesh.edge_count());
    assert!(with(Some(1000)).unwrap_err().to_string().contains(&needed.to_string()));
    assert!(with(Some(needed)).is_ok());
    assert!(with(Some(needed - 1)).is_err());
}

/// The factor for level set constraints counts, too. On a strip the fronts are small, so the memory
/// that is kept is nearly all that the solver needs, and one more factor exceeds the limit.
#[test]
fn memory_limit_of_a_solve() {
    let mesh = shapes::grid(2000, 2, 2000.0, 2.0, Diagonal::Alternating).unwrap();
    let source = SurfaceCurves::from_curve(through_vertices(&mesh, |p| p[0] == 7.0, |p| p[1]));
    let with = |limit| Solver::new(&mesh, &SolverOptions::default().with_memory_limit(limit));
    let SignedHeatError::Numeric(NumericError::MemoryLimit { needed_bytes, .. }) =
        with(Some(1000)).unwrap_err()
    else {
        panic!()
    };
    let tight = with(Some(needed_bytes)).unwrap();
    let roomy = with(Some(2 * needed_bytes)).unwrap();
    assert!(tight.solve(&source, &levels(LevelSets::Free)).is_ok());
    for level_sets in [LevelSets::Zero, LevelSets::PerComponent, LevelSets::Soft(1.0)] {
        let refused = tight.solve(&source, &levels(level_sets)).unwrap_err();
        assert!(
            matches!(refused, SignedHeatError::Numeric(NumericError::MemoryLimit { .. })),
            "{level_sets:?}: {refused}"
        );
        assert!(roomy.solve(&source, &levels(level_sets)).is_ok(), "{level_sets:?}");
    }
}

#[test]
fn lengths_beyond_double_precision() {
    let mesh = plate();
    let source = SurfaceCurves::from_curve(Curve::signed([6, 7, 8].map(Vertex)));
    for scale in [1e-300, 1e-200, 1e-170, 1e-120, 1e-60, 1e60, 1e120, 1e200, 1e300] {
        let positions = mesh.positions().iter().map(|p| p.map(|x| scale * x)).collect();
        let scaled = mesh.with_positions(positions).unwrap();
        match Solver::new(&scaled, &SolverOptions::default())
            .map(|s| s.solve(&source, &SolveOptions::default()))
        {
            Err(error) | Ok(Err(error)) => {
                println!("scale {scale:e}: {error}");
                assert!(!(1e-60..=1e60).contains(&scale), "scale {scale:e} is in range");
            }
            Ok(Ok(solution)) => {
                let relative: Vec<f64> = solution.distance.as_slice().iter().map(|d| d / scale).collect();
                let e = errors(&mesh, &relative, |p| p[0] - 2.0);
                println!("scale {scale:e}: {e:?}");
                assert!(e.largest < 1e-6, "scale {scale:e}: {e:?}");
            }
        }
    }
}
