//! Continuous collision detection against closed formulas and dense sampling.

use eikona::mesh::random::Random;
use eikona::mesh::{TriangleMesh, shapes};
use eikona::spatial::{Contact, safe_motion, segment_distance, self_distance};

type Vec3 = [f64; 3];

fn pair(first: [Vec3; 3], second: [Vec3; 3]) -> TriangleMesh {
    TriangleMesh::new([first, second].concat(), vec![[0, 1, 2], [3, 4, 5]]).unwrap()
}

#[test]
fn threads_do_not_matter() {
    let mesh = shapes::linked_rings(2, 0.3, 100, 40).unwrap();
    let wave = |v: usize| [1.0, 2.0, 3.0].map(|k: f64| 0.4 * (1.7 * k + 0.01 * k * v as f64).sin());
    let motion: Vec<Vec3> = (0..mesh.vertex_count()).map(wave).collect();
    let all =
        |threads| (safe_motion(&mesh, &motion, threads).unwrap(), self_distance(&mesh, threads).unwrap());
    let (safe, distance) = all(1);
    assert!(safe.share < 1.0 && safe.contact.is_some() && distance > 0.0);
    for threads in [2, 3, 7] {
        assert_eq!(all(threads), (safe, distance));
    }
}

#[test]
fn known_contacts_are_found_at_their_times() {
    // A corner onto a face.
    let mesh = pair([[0., 0., 0.], [9., 0., 0.], [0., 9., 0.]], [[2., 2., 1.], [3., 2., 4.], [2., 3., 4.]]);
    let fall = |by: f64| [[[0.0; 3]; 3], [[0.0, 0.0, -by]; 3]].concat();
    let safe = safe_motion(&mesh, &fall(2.0), 1).unwrap();
    assert!(safe.share > 0.42 && safe.share < 0.5, "{safe:?}");
    assert!(matches!(safe.contact, Some(Contact::VertexFace(v, f)) if v.0 == 3 && f.0 == 0), "{safe:?}");
    assert_eq!(safe_motion(&mesh, &fall(0.85), 1).unwrap().share, 1.0);
    assert_eq!(safe_motion(&mesh, &fall(-5.0), 1).unwrap().share, 1.0);
    // The same motion of both moves nothing.
    assert_eq!(safe_motion(&mesh, &[[3.0, 1.0, -50.0]; 6], 1).unwrap().share, 1.0);
    // Two crossed edges.
    let mesh =
        pair([[-5., 0., 0.], [5., 0., 0.], [0., 0., -9.]], [[0., -5., 1.], [0., 5., 1.], [0., 0., 9.]]);
    let safe = safe_motion(&mesh, &fall(4.0), 1).unwrap();
    assert!(safe.share > 0.2 && safe.share < 0.25, "{safe:?}");
    assert!(matches!(safe.contact, Some(Contact::EdgeEdge(..))), "{safe:?}");
    // A fast motion straight through, which ends apart.
    assert!(safe_motion(&mesh, &fall(400.0), 1).unwrap().share < 0.0025);
    // A fold: a face turns about its edge onto its neighbour.
    let square = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.2]];
    let fan = TriangleMesh::new(square, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let fold = [[0.0; 3], [0.0; 3], [0.0; 3], [0.9, -0.9, -0.3]];
    let share = safe_motion(&fan, &fold, 1).unwrap().share;
    assert!(share > 0.4 && share < 2.0 / 3.0, "{share}");
}

/// Found by fuzzing: elements that slide along each other at a tiny distance took steps without
/// end.
#[test]
fn sliding_at_a_tiny_distance_ends() {
    let slope = [[-9., -9., -9.], [9., -9., 9.], [0., 9., 0.]];
    for gap in [1e-16, 1e-200, 0.0] {
        let mesh = pair(slope, [[0., 0., gap], [1., 0., 3.], [0., 1., 3.]]);
        let slide = [[[0.0; 3]; 3], [[1.0, 1.0, 1.0]; 3]].concat();
        let safe = safe_motion(&mesh, &slide, 1).unwrap();
        assert!(safe.share < 1e-10 && safe.contact.is_some(), "{gap}: {safe:?}");
    }
    let base = [[-9., -9., 0.], [9., -9., 0.], [0., 9., 0.]];
    let mesh = pair(base, [[0., 0., 1.], [1., 0., 3.], [0., 1., 3.]]);
    let far = [[[0.0; 3]; 3], [[1e300, 0.0, 1e300]; 3]].concat();
    assert!((0.0..=1.0).contains(&safe_motion(&mesh, &far, 1).unwrap().share));
    let wide =
        pair(base.map(|p| p.map(|x| 1e200 * x)), [[0., 0., 1e190], [1e200, 0., 3e200], [0., 1e200, 3e200]]);
    let fall = [[[0.0; 3]; 3], [[0.0, 0.0, -2e200]; 3]].concat();
    assert!(safe_motion(&wide, &fall, 1).unwrap().share < 1e-9);
}

#[test]
fn random_motions_are_safe_as_far_as_they_are_said_to_be() {
    let mut random = Random::from_seed(4);
    let one = shapes::icosphere(1).unwrap();
    let other = one.positions().iter().map(|p| [p[0] + 2.3, p[1] + 0.1, p[2] - 0.2]);
    let count = one.vertex_count() as u32;
    let faces = one.triangles().iter().map(|t| t.map(|v| v + count));
    let mesh = TriangleMesh::new(
        one.positions().iter().copied().chain(other).collect(),
        one.triangles().iter().copied().chain(faces).collect(),
    )
    .unwrap();
    let mut limited = 0;
    for _ in 0..40 {
        let motion: Vec<Vec3> =
            (0..mesh.vertex_count()).map(|_| random.in_unit_ball().map(|x| 0.8 * x)).collect();
        let safe = safe_motion(&mesh, &motion, 1).unwrap();
        assert_eq!(safe, safe_motion(&mesh, &motion, 3).unwrap());
        limited += usize::from(safe.contact.is_some());
        let before = self_distance(&mesh, 1).unwrap();
        for k in 0..=20 {
            let t = safe.share * f64::from(k) / 20.0;
            let at = mesh.positions().iter().zip(&motion).map(|(p, m)| [0, 1, 2].map(|k| p[k] + t * m[k]));
            let distance = self_distance(&mesh.with_positions(at.collect()).unwrap(), 1).unwrap();
            assert!(distance > 0.05 * before, "{distance}");
        }
    }
    assert!(limited > 10, "{limited}");
}

#[test]
fn distances_of_segments() {
    let distance = |a: [Vec3; 2], b: [Vec3; 2]| segment_distance(a, b);
    let along = [[0., 0., 0.], [2., 0., 0.]];
    assert_eq!(distance(along, [[1., -1., 3.], [1., 1., 3.]]), 3.0);
    assert_eq!(distance(along, [[3., 1., 0.], [5., 9., 0.]]), 2f64.sqrt());
    assert_eq!(distance(along, [[-1., 2., 0.], [3., 2., 0.]]), 2.0);
    assert_eq!(distance(along, [[1., 0., 0.], [1., 5., 0.]]), 0.0);
    assert_eq!(distance(along, [[1., 4., 0.]; 2]), 4.0);
    assert_eq!(distance([[0.; 3]; 2], [[0., 3., 4.]; 2]), 5.0);
    let mut random = Random::from_seed(9);
    for _ in 0..200 {
        let [a, b, c, d] = [(); 4].map(|()| random.in_unit_ball());
        let found = distance([a, b], [c, d]);
        let at = |p: Vec3, q: Vec3, t: f64| [0, 1, 2].map(|k| p[k] + t * (q[k] - p[k]));
        let mut sampled = f64::INFINITY;
        for i in 0..=60 {
            for j in 0..=60 {
                let (p, q) = (at(a, b, f64::from(i) / 60.0), at(c, d, f64::from(j) / 60.0));
                sampled = sampled.min((0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt());
            }
        }
        assert!(found <= sampled + 1e-12 && found > sampled - 0.04, "{found} {sampled}");
    }
}
