//! Observers receive the phases of every solver, and can stop it in each.

use eikona::contour::plane_cut;
use eikona::mesh::{SurfaceCurves, TriangleMesh, shapes};
use eikona::numeric::{NumericError, observed};
use eikona::signed_heat::{self, SignedHeatError};
use eikona::winding::{self, WindingError};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

fn broken_cut(mesh: &TriangleMesh) -> SurfaceCurves {
    let cut = plane_cut(mesh, [0.0, 0.0, 0.05], [0.1, 0.2, 1.0]).unwrap();
    let pieces = cut.iter().flat_map(|c| c.nodes.chunks(8).step_by(2)).filter(|nodes| nodes.len() > 1);
    let curves = pieces.map(|nodes| eikona::mesh::Curve::signed(nodes.iter().copied())).collect();
    SurfaceCurves { curves, points: Vec::new() }
}

/// Runs some work and stops it when this phase begins. Returns the result and the phases that
/// began.
fn stopped_in<R>(phase: Option<&'static str>, work: impl FnOnce() -> R) -> (R, Vec<&'static str>) {
    let begun = Arc::new(Mutex::new(Vec::new()));
    let observer = {
        let begun = begun.clone();
        move |name: &'static str, fraction: Option<f64>| {
            assert!(fraction.is_none_or(|f| (0.0..=1.0).contains(&f)), "{name}: {fraction:?}");
            let mut begun = begun.lock().unwrap();
            if begun.last() != Some(&name) {
                begun.push(name);
            }
            if Some(name) == phase { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    };
    let result = observed(observer, work);
    let begun = begun.lock().unwrap().clone();
    (result, begun)
}

#[test]
fn signed_heat_can_be_stopped_in_every_phase() {
    let torus = shapes::torus(1.0, 0.4, 60, 24).unwrap();
    let source = broken_cut(&torus);
    for threads in [1, 2] {
        let solve = || {
            let options = signed_heat::SolverOptions::default().with_threads(threads);
            signed_heat::Solver::new(&torus, &options)?.solve(&source, &Default::default())
        };
        let expected = solve().unwrap().distance;
        let (observed, phases) = stopped_in(None, solve);
        assert_eq!(observed.unwrap().distance, expected);
        let all =
            ["geometry", "analysis", "factorisation", "source", "diffusion", "integration", "confidence"];
        assert!(all.iter().all(|name| phases.contains(name)), "{phases:?}");
        for name in all {
            let (stopped, phases) = stopped_in(Some(name), solve);
            assert_eq!(phases.last(), Some(&name));
            assert!(
                matches!(stopped, Err(SignedHeatError::Numeric(NumericError::Stopped))),
                "{name}: {:?}",
                stopped.err()
            );
        }
    }
}

/// A solver that was stopped can be used again.
#[test]
fn a_stopped_solver_still_works() {
    let torus = shapes::torus(1.0, 0.4, 60, 24).unwrap();
    let source = broken_cut(&torus);
    let solver = signed_heat::Solver::new(&torus, &Default::default()).unwrap();
    for name in ["factorisation", "integration"] {
        let (stopped, _) = stopped_in(Some(name), || solver.solve(&source, &Default::default()));
        assert!(stopped.is_err());
    }
    let expected = signed_heat::Solver::new(&torus, &Default::default()).unwrap();
    let expected = expected.solve(&source, &Default::default()).unwrap();
    assert_eq!(solver.solve(&source, &Default::default()).unwrap().distance, expected.distance);

    let solver = winding::Solver::new(&torus, &Default::default()).unwrap();
    let (stopped, _) = stopped_in(Some("linear program"), || solver.solve(&source, &Default::default()));
    assert!(stopped.is_err());
    let again = solver.solve(&source, &Default::default()).unwrap();
    let expected = winding::Solver::new(&torus, &Default::default())
        .unwrap()
        .solve(&source, &Default::default())
        .unwrap();
    assert_eq!(again.labels, expected.labels);
}

#[test]
fn winding_numbers_can_be_stopped_in_every_phase() {
    let torus = shapes::torus(1.0, 0.4, 60, 24).unwrap();
    let source = broken_cut(&torus);
    let solve = || winding::Solver::new(&torus, &Default::default())?.solve(&source, &Default::default());
    let bits = |w: winding::Winding| w.values.as_slice().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let expected = bits(solve().unwrap());
    let (observed, phases) = stopped_in(None, solve);
    assert!(bits(observed.unwrap()) == expected, "an observer changes the digits");
    let all = [
        "check",
        "cut",
        "chain",
        "factorisation",
        "jump equation",
        "harmonic part",
        "linear program",
        "second jump equation",
        "labels",
        "orientation",
        "loops",
        "straightening",
    ];
    assert!(all.iter().all(|name| phases.contains(name)), "{phases:?}");
    for name in all {
        let (stopped, phases) = stopped_in(Some(name), solve);
        assert_eq!(phases.last(), Some(&name));
        assert!(
            matches!(stopped, Err(WindingError::Numeric(NumericError::Stopped))),
            "{name}: {:?}",
            stopped.err()
        );
    }
}
