//! Cutting along many curves: random walks, clusters of points, thousands of segments in one face,
//! and the files of the data folder.

mod embedding;
mod shapes;
use eikona::curves::{DEFAULT_TOLERANCE, trace_curve, trace_polyline};
use eikona::cut::embed_curves;
use eikona::spatial::Bvh;
use eikona_mesh::{Curve, CurveKind, Face, Located, SurfaceCurves, TriangleMesh, Vertex, io, read_curves};
use embedding::*;
use shapes::{DATA, Random, cube, moebius, rough_grid, sphere, torus};
use std::path::{Path, PathBuf};

/// `pages` half-planes on one spine.
fn book(n: usize, pages: usize) -> TriangleMesh {
    let mut positions: Vec<Vec3> = (0..=n).map(|i| [0.0, 0.0, i as f64 / n as f64]).collect();
    let mut faces = Vec::new();
    for page in 0..pages {
        let angle = 0.3 + page as f64 * 5.0 / pages as f64;
        let start = positions.len();
        for j in 1..=n {
            let r = j as f64 / n as f64;
            positions.extend((0..=n).map(|i| [r * angle.cos(), r * angle.sin(), i as f64 / n as f64]));
        }
        let id = |i: usize, j: usize| (if j == 0 { i } else { start + (j - 1) * (n + 1) + i }) as u32;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            faces.extend(if page % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    TriangleMesh::new(positions, faces).unwrap()
}

/// A random walk over a mesh with each step in one face: to inner points, to edges (often to the
/// same places) and to vertices. Some points are moved by `jitter`.
fn random_walk(mesh: &TriangleMesh, random: &mut Random, steps: usize, jitter: f64) -> Curve {
    let mut here = Located::Vertex(Vertex((random.next() % mesh.vertex_count() as u64) as u32));
    if here.faces(mesh).is_empty() {
        here = Located::Vertex(mesh.face_vertices(Face(0))[0]);
    }
    let mut nodes = vec![here.to_surface_point(mesh)];
    while nodes.len() <= steps {
        let faces = here.faces(mesh);
        let face = faces[random.next() as usize % faces.len()];
        let corner = random.next() as usize % 3;
        let some = [0.5, 0.25, 1.0 / 3.0, random.unit(), random.unit()][random.next() as usize % 5];
        let mut w = [0.0; 3];
        match random.next() % 8 {
            0 => w[corner] = 1.0,
            1..4 => {
                w[corner] = some;
                w[(corner + 1) % 3] = 1.0 - some;
            }
            _ => {
                let other = [0.5, 0.25, random.unit()][random.next() as usize % 3];
                w[corner] = some;
                w[(corner + 1) % 3] = (1.0 - some) * other;
                w[(corner + 2) % 3] = (1.0 - some) * (1.0 - other);
            }
        }
        if jitter > 0.0 && random.next().is_multiple_of(2) {
            w[corner] = (w[corner] + jitter * random.unit()).abs();
        }
        let next = Located::in_face(mesh, face, w);
        // The point is named by vertices, so it must be located in the first of doubled faces.
        if let Ok(place) = next.to_surface_point(mesh).locate(mesh)
            && eikona_mesh::segment_host(mesh, here, place).is_some()
        {
            nodes.push(place.to_surface_point(mesh));
            here = place;
        }
    }
    Curve::signed(nodes)
}

fn some_mesh(i: u64, seed: u64) -> (&'static str, TriangleMesh) {
    match i % 10 {
        0 => ("rough grid", rough_grid(3, seed)),
        1 => ("sphere", sphere(1)),
        2 => ("torus", torus(7, 5, 0.4)),
        3 => ("cube", cube(2)),
        4 => ("moebius", moebius(9, 2)),
        5 => ("book", book(2, 3)),
        6 => ("square", square()),
        7 => ("inconsistently oriented", flat_square([[0, 1, 2], [0, 3, 2]])),
        8 => ("pillow", pillow()),
        _ => ("book of five", book(1, 5)),
    }
}

#[test]
fn random_walks_over_random_meshes() {
    let (mut faces, mut steps) = (0, 0);
    for seed in 0..200u64 {
        let mut random = Random(seed);
        let (name, mesh) = some_mesh(seed, seed);
        let count = 1 + random.next() as usize % 4;
        let curves: Vec<Curve> = (0..count)
            .map(|_| {
                let n = 3 + random.next() as usize % 20;
                random_walk(&mesh, &mut random, n, 0.0)
            })
            .collect();
        let name = format!("{name}, seed {seed}");
        let curves = SurfaceCurves { curves, points: Vec::new() };
        let cut = embed_with(&name, &mesh, &curves, 1e-15);
        faces += cut.mesh.face_count();
        steps += cut.curves.iter().map(|c| c.segments.len()).sum::<usize>();
        let finer = cut.split_short().unwrap();
        check(&format!("{name}, finer"), &mesh, &curves, &finer, 1e-15);
        // An embedded curve stays as it is.
        let again = embed_with("again", &cut.mesh, &cut.curves_on_mesh(), 0.0);
        assert_eq!(again.mesh.triangles(), cut.mesh.triangles(), "{name}");
    }
    println!("random walks: {faces} faces, {steps} steps");
}

#[test]
fn random_walks_with_near_misses() {
    let mut thinnest = f64::INFINITY;
    for seed in 0..200u64 {
        let mut random = Random(1000 + seed);
        let (name, mesh) = some_mesh(seed, seed);
        let jitter = [1e-15, 1e-12, 1e-10, 1e-9, 3e-9, 1e-8][seed as usize / 10 % 6];
        let curves: Vec<Curve> = (0..3).map(|_| random_walk(&mesh, &mut random, 20, jitter)).collect();
        let curves = SurfaceCurves { curves, points: Vec::new() };
        let cut = embed_with(&format!("{name}, seed {seed}, jitter {jitter}"), &mesh, &curves, 1e-8);
        thinnest = thinnest.min(lowest_height(&mesh, &cut));
    }
    println!("near misses: lowest height {thinnest:e} of a face of sides 1");
    assert!(thinnest > 1e-10, "{thinnest:e}");
}

#[test]
fn clusters_of_points_are_embedded_anywhere() {
    let mesh = square();
    let mut thinnest = f64::INFINITY;
    for seed in 0..120u64 {
        let mut random = Random(seed);
        let size = [1e-12, 1e-9, 2e-9, 5e-9, 2e-8, 1e-7][seed as usize % 6];
        // Inside, at a side, at both ends of a side, at a corner.
        let around: &[[f64; 3]] = match seed / 6 % 4 {
            0 => &[[0.3, 0.3, 0.4]],
            1 => &[[0.0, 0.4, 0.6], [0.5, 0.0, 0.5]],
            2 => &[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            _ => &[[0.0, 1.0, 0.0], [0.1, 0.8, 0.1]],
        };
        let nodes = (0..60).map(|_| {
            let w = around[random.next() as usize % around.len()];
            let b = w[1] + size * (random.unit() - 0.5);
            let c = w[2] + size * (random.unit() - 0.5);
            let (b, c) = (b.clamp(0.0, 1.0), c.clamp(0.0, 1.0));
            Located::in_face(&mesh, Face(0), [(1.0 - b - c).max(0.0), b, c]).to_surface_point(&mesh)
        });
        let curves = SurfaceCurves::from_curve(Curve::signed(nodes));
        let cut = embed_with(&format!("dust, seed {seed}"), &mesh, &curves, 5e-9);
        thinnest = thinnest.min(lowest_height(&mesh, &cut));
    }
    // Three points of a cluster may happen to be nearly collinear, so this is below the tolerance,
    // but far above rounding.
    println!("dust: lowest height {thinnest:e} of a face of sides 1");
    assert!(thinnest > 1e-12, "{thinnest:e}");
}

#[test]
fn random_polylines_traced_over_random_meshes() {
    let (mut run, mut faces) = (0, 0);
    for seed in 0..200u64 {
        let mut random = Random(2000 + seed);
        let (name, mesh) = match seed % 4 {
            0 => ("rough grid", rough_grid(9, seed)),
            1 => ("moebius", moebius(24, 4)),
            2 => ("book", book(5, 4)),
            _ => ("torus", torus(20, 12, 0.4)),
        };
        let bvh = Bvh::new(&mesh);
        let mut curves = Vec::new();
        for k in 0..3 {
            let points: Vec<Vec3> = (0..5).map(|_| random.point(-1.2, 1.2)).collect();
            if let Ok(t) = trace_polyline(&mesh, &bvh, &points, k == 0, CurveKind::Signed, DEFAULT_TOLERANCE)
            {
                curves.push(t.curve);
            }
        }
        run += curves.len();
        let cut = embed_with(
            &format!("{name}, seed {seed}"),
            &mesh,
            &SurfaceCurves { curves, points: Vec::new() },
            1e-15,
        );
        faces += cut.mesh.face_count();
    }
    println!("{run} traced polylines, {faces} faces");
}

#[test]
fn scale_position_and_orientation_do_not_matter() {
    let mesh = rough_grid(4, 3);
    let mut random = Random(5);
    let curves: Vec<Curve> = (0..3).map(|_| random_walk(&mesh, &mut random, 25, 0.0)).collect();
    let cut = embed("as given", &mesh, curves.clone());
    for factor in [1e-100, 1e-8, 1e8, 1e100] {
        let scaled =
            mesh.with_positions(mesh.positions().iter().map(|p| p.map(|x| factor * x)).collect()).unwrap();
        let other =
            embed_curves(&scaled, &SurfaceCurves { curves: curves.clone(), points: Vec::new() }).unwrap();
        assert_eq!(other.mesh.triangles(), cut.mesh.triangles(), "{factor}");
    }
    let back = embed("reversed", &mesh, curves.iter().cloned().map(Curve::reversed).collect());
    assert_eq!(back.mesh.vertex_count(), cut.mesh.vertex_count());
    let turned = mesh.with_flipped_faces(|f| f.0 % 3 == 0);
    let other = embed("flipped", &turned, curves);
    assert_eq!(other.mesh.face_count(), cut.mesh.face_count());
    assert_eq!(other.mesh.vertex_count(), cut.mesh.vertex_count());
}

#[test]
fn many_curves_over_many_faces() {
    for n in [100, 400] {
        let mesh = rough_grid(n, 1);
        let bvh = Bvh::new(&mesh);
        let line = |y: f64| [[0.0, y, 0.0], [0.3, 1.0 - y, 0.0], [1.0, y, 0.0]];
        let curves = (0..n / 8).map(|i| {
            let y = i as f64 / (n / 8) as f64;
            trace_polyline(&mesh, &bvh, &line(y), false, CurveKind::Signed, DEFAULT_TOLERANCE).unwrap().curve
        });
        let curves = SurfaceCurves { curves: curves.collect(), points: Vec::new() };
        let cut = embed_curves(&mesh, &curves).unwrap();
        check("many", &mesh, &curves, &cut, 1e-15);
    }
}

#[test]
fn ten_thousand_segments_in_one_face() {
    let mesh = square();
    let face = [0, 1, 2];
    let mut random = Random(11);
    let cut_along = |name: &str, curves: Vec<Curve>| {
        embed_with(name, &mesh, &SurfaceCurves { curves, points: Vec::new() }, 2e-9)
    };
    let spiral = (0..=10_000).map(|i| {
        let (a, r) = (0.05 * i as f64, 2e-5 * i as f64);
        inside(face, 0.4 + r * a.cos(), 0.3 + r * a.sin())
    });
    let cut = cut_along("spiral", vec![Curve::signed(spiral)]);
    assert!(cut.curves[0].segments.len() >= 10_000);
    let short = (0..10_000).map(|_| {
        let [x, y] = [0.05 + 0.6 * random.unit(), 0.05 + 0.2 * random.unit()];
        let [dx, dy] = [0, 1].map(|_| 0.02 * (random.unit() - 0.5));
        Curve::signed([inside(face, x, y), inside(face, x + dx, y + dy)])
    });
    cut_along("short ones", short.collect());
    let hub = (0..5_000).flat_map(|i| {
        let a = 0.001 * i as f64;
        [inside(face, 0.4, 0.3), inside(face, 0.4 + 0.2 * a.cos(), 0.3 + 0.2 * a.sin())]
    });
    cut_along("hub", vec![Curve::signed(hub)]);
    let long = (0..200).map(|_| {
        let [s, t] = [random.unit(), random.unit()];
        Curve::signed([edge(0, 1, s), edge(1, 2, t)])
    });
    cut_along("200 chords", long.collect());
    let collinear = (0..10_000).map(|_| {
        let s = 0.1 + 0.7 * random.unit();
        Curve::signed([inside(face, s, 0.1), inside(face, s + 0.01 * (random.unit() - 0.5), 0.1)])
    });
    cut_along("collinear", collinear.collect());
    let along = (0..10_000).map(|_| {
        let s = 0.1 + 0.7 * random.unit();
        Curve::signed([edge(0, 2, s), edge(0, 2, s + 0.01 * (random.unit() - 0.5))])
    });
    cut_along("along an edge", along.collect());
    let same = (0..10_000).map(|i| {
        let (a, b) = (inside(face, 0.2, 0.2), inside(face, 0.5, 0.3));
        Curve::signed(if i % 2 == 0 { [a, b] } else { [b, a] })
    });
    let cut = cut_along("one and the same", same.collect());
    assert!(cut.chain().edges.iter().all(|e| e.multiplicity == 0 && e.walks.len() == 10_000));
    // All nodes in a cluster of size 1e-12, with each segment leaving it and returning.
    let heap = (0..2_000).map(|i| match i % 2 {
        0 => inside(face, 0.4 + 1e-12 * random.unit(), 0.3 + 1e-12 * random.unit()),
        _ => inside(face, 0.1 + 0.5 * random.unit(), 0.1 + 0.3 * random.unit()),
    });
    cut_along("heap", vec![Curve::signed(heap)]);
    // All nodes about as close together as the tolerance.
    for size in [1e-9, 3e-9, 1e-8] {
        let dust = (0..300).map(|_| inside(face, 0.4 + size * random.unit(), 0.3 + size * random.unit()));
        cut_along("dust", vec![Curve::signed(dust)]);
    }
}

fn host(name: &str) -> Option<&'static str> {
    Some(match name {
        "shm/block-points" => "badquality/block.obj",
        "shm/bumpy-sphere" => "curves/shm/bumpy-sphere.obj",
        "shm/cactus" => "curves/shm/cactus.obj",
        "shm/fish-unsigned" => "curves/shm/fish-unsigned.obj",
        "shm/hemisphere-point" => "boundary/hemisphere.obj",
        "shm/mobius-orientable-curve" => "nonorientable/mobius-orientable-curve.obj",
        "shm/polygon-bear" => "polygon/polygon-bear.obj",
        "shm/screwdriver" => "nonmanifold/screwdriver.obj",
        "swn/annulus" => "curves/swn/annulus.obj",
        "swn/asymmetric-torus" => "curves/swn/asymmetric-torus.obj",
        "swn/bunny-brokenheart" | "swn/bunny-heart" => "closed/bunny.obj",
        "swn/double-torus" => "closed/double-torus.obj",
        "swn/spots-on-spot" => "curves/swn/spots-on-spot.obj",
        "swn/torus-phi" => "curves/swn/torus.obj",
        _ => return None,
    })
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn curves_of_the_data_folder() {
    let mut run = 0;
    let mut files: Vec<PathBuf> = Vec::new();
    for folder in ["curves/shm", "curves/swn"] {
        files.extend(
            std::fs::read_dir(Path::new(DATA).join(folder)).into_iter().flatten().flatten().map(|e| e.path()),
        );
    }
    files.sort();
    for path in files.iter().filter(|p| p.extension().is_some_and(|e| e == "txt")) {
        let name = path.strip_prefix(Path::new(DATA).join("curves")).unwrap().with_extension("");
        let name = name.to_string_lossy().replace('\\', "/");
        let Some(host) = host(&name) else { continue };
        let mesh = io::read_mesh(Path::new(DATA).join(host)).unwrap().mesh.triangulate().unwrap().0;
        let mut curves = read_curves(path, &mesh).unwrap().curves;
        for curve in &mut curves.curves {
            if SurfaceCurves::from_curve(curve.clone()).segments(&mesh).is_err() {
                *curve = trace_curve(&mesh, curve).unwrap().curve;
            }
        }
        let cut = embed_curves(&mesh, &curves).unwrap();
        check(&name, &mesh, &curves, &cut, 1e-15);
        let finer = cut.split_short().unwrap();
        check(&name, &mesh, &curves, &finer, 1e-15);
        println!(
            "{name}: {} curves, {} faces, cut {}, short pieces split {}",
            curves.curves.len(),
            mesh.face_count(),
            cut.mesh.face_count(),
            finer.mesh.face_count()
        );
        run += 1;
    }
    println!("curves embedded on {run} files");
    assert_eq!(run, 15);
}
