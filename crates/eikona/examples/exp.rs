//! experiments
use eikona::signed_heat::*;
use eikona_mesh::*;
use std::time::Instant;

/// each crossing a 2-node curve; smaller values on the left
fn level(mesh: &TriangleMesh, f: impl Fn([f64; 3]) -> f64, keep: impl Fn([f64; 3]) -> bool) -> SurfaceCurves {
    let mut out = SurfaceCurves::default();
    let val: Vec<f64> = mesh.positions().iter().map(|p| f(*p)).collect();
    for t in mesh.triangles() {
        let mut pts = vec![];
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let (x, y) = (val[a as usize], val[b as usize]);
            if (x < 0.0) != (y < 0.0) {
                let s = x / (x - y);
                // entering the positive side: ccw walk from neg to pos
                pts.push((
                    x < 0.0,
                    SurfacePoint::Edge { vertices: [a, b], t: s },
                    [0, 1, 2].map(|i| {
                        (1.0 - s) * mesh.positions()[a as usize][i] + s * mesh.positions()[b as usize][i]
                    }),
                ));
            }
        }
        if pts.len() == 2 {
            // neg on left: walking from the crossing pos->neg ... to neg->pos
            let (up, down) =
                if pts[0].0 { (pts[0].clone(), pts[1].clone()) } else { (pts[1].clone(), pts[0].clone()) };
            let m = [0, 1, 2].map(|i| 0.5 * (up.2[i] + down.2[i]));
            if keep(m) {
                out.curves.push(Curve::signed([up.1, down.1]));
            }
        }
    }
    out
}
fn l2(mesh: &TriangleMesh, sol: &[f64], truth: impl Fn([f64; 3]) -> f64) -> (f64, f64) {
    let mut a = vec![0.0; mesh.vertex_count()];
    for t in mesh.triangles() {
        let p = t.map(|v| mesh.positions()[v as usize]);
        let u = [0, 1, 2].map(|k| p[1][k] - p[0][k]);
        let v = [0, 1, 2].map(|k| p[2][k] - p[0][k]);
        let c = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let ar = 0.5 * (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt();
        for k in 0..3 {
            a[t[k] as usize] += ar / 3.0;
        }
    }
    let tr: Vec<f64> = mesh.positions().iter().map(|p| truth(*p)).collect();
    let (lo, hi) = tr.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    let tot: f64 = a.iter().sum();
    let s: f64 = a.iter().zip(sol).zip(&tr).map(|((a, s), t)| a * (s - t) * (s - t)).sum();
    let linf = sol.iter().zip(&tr).map(|(s, t)| (s - t).abs()).fold(0.0, f64::max);
    ((s / tot).sqrt() / (hi - lo), linf)
}
fn run(
    name: &str,
    mesh: &TriangleMesh,
    src: &SurfaceCurves,
    time: DiffusionTime,
    ls: LevelSets,
    truth: impl Fn([f64; 3]) -> f64,
) {
    let t0 = Instant::now();
    let s = Solver::new(mesh, &SolverOptions { time, ..Default::default() }).unwrap();
    let t1 = t0.elapsed().as_secs_f64();
    let t0 = Instant::now();
    let sol = s.solve(src, &SolveOptions { level_sets: ls, ..Default::default() }).unwrap();
    let t2 = t0.elapsed().as_secs_f64();
    let (e, i) = l2(mesh, sol.distance.as_slice(), truth);
    let ph = |p: &Phases| {
        p.0.iter().map(|(n, d)| format!("{n} {:.3}", d.as_secs_f64())).collect::<Vec<_>>().join(" ")
    };
    println!(
        "{name:28} F {:7} c {:8.1} {:?} new {t1:.3} solve {t2:.3} L2 {e:.2e} Linf {i:.2e} stages {} res {:.0e} {:.0e} viol {:.0e} MB {} [{}] [{}] {:?}",
        mesh.face_count(),
        sol.report.time.coefficient,
        ls,
        sol.report.stages,
        sol.report.diffusion_residual,
        sol.report.integration_residual,
        sol.report.constraint_violation,
        sol.report.preparation.factor_bytes / 1000000,
        ph(&sol.report.preparation.phases),
        ph(&sol.report.phases),
        sol.report.all_warnings().map(|s| &s[..s.len().min(60)]).collect::<Vec<_>>()
    );
}
fn main() {
    let arg = std::env::args().nth(1).unwrap_or("sphere".into());
    let truth = |p: [f64; 3]| {
        let r = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        (0.3f64).acos() - (p[2] / r).acos()
    };
    // negative below? phi = angle: positive where z > .3 : field f=z-.3 -> smaller values on left
    match arg.as_str() {
        "strip" => {
            for n in [1000, 5000, 20000] {
                let m = shapes::grid(n, 10, n as f64, 10.0, shapes::Diagonal::Uniform).unwrap();
                let c = SurfaceCurves::from_curve(Curve::signed(
                    m.vertices().filter(|v| m.position(*v)[0] == 2.0),
                ));
                for ls in [LevelSets::Free, LevelSets::Zero] {
                    run("strip", &m, &c, DiffusionTime::Coefficient(1.0), ls, |p| p[0] - 2.0);
                }
            }
        }
        "sphere" => {
            for f in [8, 16, 32, 71] {
                let m = shapes::geodesic_sphere(f).unwrap();
                let c = level(&m, |p| p[2] - 0.3, |_| true);
                let b = level(
                    &m,
                    |p| p[2] - 0.3,
                    |p| {
                        let a = p[1].atan2(p[0]) / std::f64::consts::TAU + 0.5;
                        (a / 0.15).fract() < 2.0 / 3.0
                    },
                );
                for tc in [1.0, 10.0, 100.0] {
                    for ls in [LevelSets::Free, LevelSets::Zero] {
                        run("sphere", &m, &c, DiffusionTime::Coefficient(tc), ls, truth);
                    }
                    run("sphere broken", &m, &b, DiffusionTime::Coefficient(tc), LevelSets::Free, truth);
                }
            }
        }
        "auto" => {
            for f in [8, 16, 32, 71] {
                let m = shapes::geodesic_sphere(f).unwrap();
                let c = level(&m, |p| p[2] - 0.3, |_| true);
                for tc in [3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0] {
                    run("sphere", &m, &c, DiffusionTime::Coefficient(tc), LevelSets::Free, truth);
                }
            }
        }
        "big" => {
            let f: usize = std::env::args().nth(2).unwrap().parse().unwrap();
            let m = shapes::geodesic_sphere(f).unwrap();
            let c = level(&m, |p| p[2] - 0.3, |_| true);
            for ls in [LevelSets::Free, LevelSets::Zero, LevelSets::Soft(100.0)] {
                run(
                    "sphere",
                    &m,
                    &c,
                    DiffusionTime::Coefficient(std::env::args().nth(3).map_or(1.0, |s| s.parse().unwrap())),
                    ls,
                    truth,
                );
            }
        }
        _ => {}
    }
}
