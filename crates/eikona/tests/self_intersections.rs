//! Exact self-intersections against the separating axes of integer triangles, and known cases.

use eikona::mesh::random::Random;
use eikona::mesh::{Face, TriangleMesh, shapes};
use eikona::spatial::self_intersections;

type Int3 = [i64; 3];

fn sub(a: Int3, b: Int3) -> Int3 {
    [0, 1, 2].map(|k| a[k] - b[k])
}
fn cross(a: Int3, b: Int3) -> Int3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn dot(a: Int3, b: Int3) -> i64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}
fn sides([a, b, c]: [Int3; 3]) -> [Int3; 3] {
    [sub(b, a), sub(c, b), sub(a, c)]
}

/// Whether no axis separates two triangles strictly.
fn meet_by_axes(s: [Int3; 3], t: [Int3; 3]) -> bool {
    let [n, m] = [s, t].map(|[a, b, c]| cross(sub(b, a), sub(c, a)));
    let mut axes = vec![n, m];
    for e in sides(s) {
        axes.push(cross(n, e));
        axes.extend(sides(t).map(|f| cross(e, f)));
    }
    axes.extend(sides(t).map(|f| cross(m, f)));
    axes.into_iter().filter(|axis| *axis != [0; 3]).all(|axis| {
        let [s, t] = [s, t].map(|triangle| triangle.map(|p| dot(axis, p)));
        let (least, most) = (|x: [i64; 3]| x[0].min(x[1]).min(x[2]), |x: [i64; 3]| x[0].max(x[1]).max(x[2]));
        least(s) <= most(t) && least(t) <= most(s)
    })
}

fn meet(s: [Int3; 3], t: [Int3; 3]) -> bool {
    let points = [s, t].concat().into_iter().map(|p| p.map(|x| x as f64)).collect();
    let mesh = TriangleMesh::new(points, vec![[0, 1, 2], [3, 4, 5]]).unwrap();
    let found = self_intersections(&mesh, 1).unwrap();
    assert!(found.is_empty() || found == [[Face(0), Face(1)]]);
    !found.is_empty()
}

#[test]
fn triangles_of_small_integers_meet_if_no_axis_separates_them() {
    let mut random = Random::from_seed(11);
    let (mut met, mut tested) = (0, 0);
    for round in 0..60_000 {
        // Small ranges touch and lie in planes often; every third pair lies in one.
        let range = [3, 5, 9][round % 3];
        let mut point = || [(); 3].map(|()| random.below(range) as i64);
        let [mut s, mut t] = [(); 2].map(|()| [(); 3].map(|()| point()));
        if round % 9 < 3 {
            s.iter_mut().chain(&mut t).for_each(|p| p[2] = p[0] + 2 * p[1]);
        }
        let area = |[a, b, c]: [Int3; 3]| cross(sub(b, a), sub(c, a)) != [0; 3];
        if !area(s) || !area(t) || s.iter().any(|p| t.contains(p)) {
            continue;
        }
        tested += 1;
        let expected = meet_by_axes(s, t);
        met += usize::from(expected);
        assert_eq!(meet(s, t), expected, "{s:?} {t:?}");
    }
    assert!(tested > 20_000 && met > tested / 10 && met < tested * 9 / 10, "{met} of {tested}");
}

#[test]
fn neighbours_meet_if_they_have_more_than_corners_in_common() {
    let base = [[0, 0, 0], [4, 0, 0], [0, 4, 0]];
    for (what, other, expected) in [
        ("a side", [[0, 0, 0], [4, 0, 0], [0, -4, 0]], false),
        ("a side, upright", [[0, 0, 0], [4, 0, 0], [0, 0, 4]], false),
        ("a side, folded over", [[0, 0, 0], [4, 0, 0], [1, 1, 0]], true),
        ("a side, nearly folded over", [[0, 0, 0], [4, 0, 0], [1, 1, 1]], false),
        ("a corner", [[0, 0, 0], [-1, -2, 3], [-2, -1, 3]], false),
        ("a corner, in the plane", [[0, 0, 0], [-1, -2, 0], [-2, -1, 0]], false),
        ("a corner, through the inside", [[0, 0, 0], [1, 1, 3], [2, 2, -3]], true),
        ("a corner, onto the inside", [[0, 0, 0], [1, 1, 0], [2, 2, 3]], true),
        ("a corner, over it in the plane", [[0, 0, 0], [3, 1, 0], [1, 3, 0]], true),
        ("a corner, along a side", [[0, 0, 0], [2, 0, 0], [2, 0, 3]], true),
        ("all corners", [[4, 0, 0], [0, 0, 0], [0, 4, 0]], true),
        ("no area", [[1, 1, -3], [1, 1, 0], [1, 1, 3]], false),
    ] {
        assert_eq!(meet(base, other), expected, "{what}");
        assert_eq!(meet(other, base), expected, "{what}, swapped");
        let [a, b, c] = other;
        assert_eq!(meet(base, [c, a, b]), expected, "{what}, turned");
    }
}

#[test]
fn surfaces() {
    for (what, mesh) in [
        ("sphere", shapes::icosphere(4).unwrap()),
        ("torus", shapes::torus(1.0, 0.4, 60, 25).unwrap()),
        ("plane", shapes::grid(20, 20, 1.0, 1.0, shapes::Diagonal::Uniform).unwrap()),
    ] {
        assert!(self_intersections(&mesh, 2).unwrap().is_empty(), "{what}");
    }
    // A torus whose tube is wider than its hole meets itself.
    let spindle = shapes::torus(1.0, 0.4, 80, 35).unwrap();
    let wide = spindle.positions().iter().map(|&[x, y, z]| {
        let away = x.hypot(y);
        let tube = 1.0 + 3.0 * (away - 1.0);
        [x / away * tube, y / away * tube, 3.0 * z]
    });
    let spindle = spindle.with_positions(wide.collect()).unwrap();
    let found = self_intersections(&spindle, 1).unwrap();
    assert!(!found.is_empty() && found == self_intersections(&spindle, 3).unwrap());
    assert!(found.windows(2).all(|pair| pair[0] < pair[1]) && found.iter().all(|[f, g]| f < g));
}
