//! Renders a few shapes with analytic fields into a folder (by default `target/gallery`), for
//! visual inspection.
//!
//! Usage: `cargo run -p eikona-render --example gallery [folder] [mesh.obj]`. If a triangle mesh in
//! OBJ format is given, renders it instead.

use eikona_mesh::TriangleMesh;
use eikona_render::{
    Background, Coloring, CurveStyle, Drawing, GlyphStyle, Isolines, Outline, PointStyle, Projection,
    RenderError, RenderOptions, ScalarField, Scene, UpAxis, Values, Wireframe, render,
};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::time::Instant;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().unwrap_or_else(|| "target/gallery".to_owned()));
    std::fs::create_dir_all(&folder)?;
    if let Some(file) = arguments.next() {
        return from_file(&folder, Path::new(&file));
    }
    torus_with_a_knot(&folder)?;
    sphere_with_a_signed_distance(&folder)?;
    flat_disk_with_a_jump(&folder)?;
    labels_on_a_cube(&folder)?;
    clay_with_edges(&folder)?;
    glyphs_and_streamlines(&folder)?;
    many_faces(&folder)
}

fn save(scene: &Scene, options: &RenderOptions, folder: &Path, name: &str) -> Result<(), RenderError> {
    let start = Instant::now();
    let image = render(scene, options)?;
    println!("{name}: {:.2} s", start.elapsed().as_secs_f64());
    image.write_png(folder.join(name))
}

fn field_with_isolines<'a>(mesh: &'a TriangleMesh, values: Values<'a>, title: &'a str) -> Scene<'a> {
    let field = ScalarField { title: Some(title), ..ScalarField::new(values) };
    Scene::new(mesh, Coloring::Field(field)).with(Drawing::Isolines(Isolines::default()))
}

/// Grid of `n` by `m` cells wrapped over a surface parametrised by two angles.
fn wrapped(n: usize, m: usize, position: impl Fn(f64, f64) -> [f64; 3]) -> Result<TriangleMesh, Failure> {
    let positions = (0..n * m)
        .map(|i| position(TAU * (i / m) as f64 / n as f64, TAU * (i % m) as f64 / m as f64))
        .collect();
    let vertex = |i: usize, j: usize| ((i % n) * m + j % m) as u32;
    let faces = (0..n * m)
        .flat_map(|c| {
            let (i, j) = (c / m, c % m);
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    Ok(TriangleMesh::new(positions, faces)?)
}

fn torus_point(u: f64, v: f64) -> [f64; 3] {
    let r = 1.0 + 0.42 * v.cos();
    [r * u.cos(), r * u.sin(), 0.42 * v.sin()]
}

/// Latitude-longitude sphere.
fn sphere(rings: usize, sides: usize) -> Result<TriangleMesh, Failure> {
    let mut positions = vec![[0.0, 1.0, 0.0]];
    for i in 1..rings {
        let (s, c) = (TAU / 2.0 * i as f64 / rings as f64).sin_cos();
        positions.extend((0..sides).map(|j| {
            let a = TAU * j as f64 / sides as f64;
            [s * a.sin(), c, s * a.cos()]
        }));
    }
    positions.push([0.0, -1.0, 0.0]);
    let last = positions.len() as u32 - 1;
    let at = |i: usize, j: usize| (1 + (i - 1) * sides + j % sides) as u32;
    let mut faces = Vec::new();
    for j in 0..sides {
        faces.push([0, at(1, j), at(1, j + 1)]);
        faces.push([last, at(rings - 1, j + 1), at(rings - 1, j)]);
        for i in 1..rings - 1 {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Ok(TriangleMesh::new(positions, faces)?)
}

fn torus_with_a_knot(folder: &Path) -> Result<(), Failure> {
    let mesh = wrapped(240, 120, torus_point)?;
    let values: Vec<f64> = (0..mesh.vertex_count())
        .map(|i| {
            let (u, v) = (TAU * (i / 120) as f64 / 240.0, TAU * (i % 120) as f64 / 120.0);
            0.5 * (2.0 * u - 3.0 * v).sin()
        })
        .collect();
    let knot: Vec<[f64; 3]> =
        (0..=720).map(|i| TAU * i as f64 / 720.0).map(|t| torus_point(3.0 * t + 0.5, 2.0 * t)).collect();
    let style = CurveStyle {
        color: [30, 30, 36],
        width: 4.5,
        outline: Some(Outline { color: [255; 3], width: 1.4 }),
        arrow_spacing: Some(160.0),
    };
    let scene = field_with_isolines(&mesh, Values::PerVertex(&values), "signed distance")
        .with(Drawing::Curve { points: knot.into(), style });
    save(&scene, &RenderOptions::default(), folder, "torus.png")?;
    Ok(())
}

fn sphere_with_a_signed_distance(folder: &Path) -> Result<(), Failure> {
    let mesh = sphere(80, 160)?;
    let pole: [f64; 3] = [0.48, 0.6, 0.64];
    let values: Vec<f64> = mesh
        .positions()
        .iter()
        .map(|p| (0..3).map(|k| p[k] * pole[k]).sum::<f64>().clamp(-1.0, 1.0).acos() - 0.7)
        .collect();
    let positions = vec![pole, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].into();
    let scene = field_with_isolines(&mesh, Values::PerVertex(&values), "distance")
        .with(Drawing::Points { positions, style: PointStyle::default() });
    let options = RenderOptions { background: Background::Transparent, ..Default::default() };
    save(&scene, &options, folder, "sphere.png")?;
    Ok(())
}

/// Angle about the centre over 2 pi, which jumps by 1 along a ray; with missing values.
fn flat_disk_with_a_jump(folder: &Path) -> Result<(), Failure> {
    let (rings, sides) = (24usize, 96usize);
    let mut positions = Vec::new();
    let mut angle = Vec::new();
    for i in 0..=rings {
        for j in 0..=sides {
            let (r, a) = (0.15 + i as f64 / rings as f64, TAU * j as f64 / sides as f64);
            positions.push([r * a.cos(), r * a.sin(), 0.0]);
            angle.push(a / TAU);
        }
    }
    let mut faces = Vec::new();
    for i in 0..rings {
        for j in 0..sides {
            let [a, b] = [i * (sides + 1) + j, (i + 1) * (sides + 1) + j].map(|v| v as u32);
            faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    let mesh = TriangleMesh::new(positions, faces)?;
    let corners: Vec<f64> = mesh
        .triangles()
        .iter()
        .enumerate()
        .flat_map(|(f, t)| {
            t.map(|v| if f % (2 * sides) < 8 && f / (2 * sides) < 9 { f64::NAN } else { angle[v as usize] })
        })
        .collect();
    let scene = field_with_isolines(&mesh, Values::PerCorner(&corners), "winding number");
    save(&scene, &RenderOptions { width: 900, ..Default::default() }, folder, "disk.png")?;
    Ok(())
}

fn labels_on_a_cube(folder: &Path) -> Result<(), Failure> {
    let positions = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    let mesh = TriangleMesh::new(positions, faces)?;
    let labels: Vec<i64> = (0..12).map(|f| f / 2 - 1).collect();
    let mut options = RenderOptions { wireframe: Some(Wireframe::default()), ..Default::default() };
    options.camera.up = UpAxis::Z;
    options.camera.projection = Projection::Orthographic;
    let coloring = Coloring::Labels { labels: &labels, title: Some("component") };
    save(&Scene::new(&mesh, coloring), &options, folder, "cube.png")?;
    Ok(())
}

fn clay_with_edges(folder: &Path) -> Result<(), Failure> {
    let mesh = wrapped(64, 32, torus_point)?;
    let options = RenderOptions { wireframe: Some(Wireframe::default()), ..Default::default() };
    save(&Scene::new(&mesh, Coloring::default()), &options, folder, "clay.png")?;
    Ok(())
}

/// Direction field on a torus that turns with the angle, as arrows, with some of its streamlines.
fn glyphs_and_streamlines(folder: &Path) -> Result<(), Failure> {
    let mesh = wrapped(240, 120, torus_point)?;
    let ends: Vec<[[f64; 3]; 2]> = (0..72 * 28)
        .map(|i| (TAU * (i / 28) as f64 / 72.0, TAU * (i % 28) as f64 / 28.0))
        .map(|(u, v)| {
            // Tangents along both angles, combined at the angle 2 u.
            let (a, b) = (2.0 * u).sin_cos();
            let along_u = [-u.sin(), u.cos(), 0.0];
            let along_v = [-v.sin() * u.cos(), -v.sin() * u.sin(), v.cos()];
            let p = torus_point(u, v);
            [-0.035, 0.035].map(|t| [0, 1, 2].map(|k| p[k] + t * (b * along_u[k] + a * along_v[k])))
        })
        .collect();
    let mut scene = Scene::new(&mesh, Coloring::Plain([222, 228, 234]))
        .with(Drawing::Glyphs { ends: ends.into(), style: GlyphStyle::default() });
    for start in 0..5 {
        // Each step goes along the field at unit speed.
        let (mut u, mut v) = (4.2 + 0.3 * start as f64, 0.6);
        let mut line = Vec::new();
        for _ in 0..400 {
            line.push(torus_point(u, v));
            let (a, b) = (2.0 * u).sin_cos();
            u += 0.004 * b / (1.0 + 0.42 * v.cos());
            v += 0.004 * a / 0.42;
        }
        let style = CurveStyle {
            color: [196, 46, 46],
            width: 3.0,
            outline: Some(Outline { color: [255; 3], width: 1.2 }),
            arrow_spacing: Some(120.0),
        };
        scene = scene.with(Drawing::Curve { points: line.into(), style });
    }
    save(&scene, &RenderOptions::default(), folder, "directions.png")?;
    Ok(())
}

fn many_faces(folder: &Path) -> Result<(), Failure> {
    let mesh = wrapped(1000, 500, torus_point)?;
    let height: Vec<f64> = mesh.positions().iter().map(|p| p[0] + p[2]).collect();
    let options = RenderOptions { width: 1600, height: 1200, ..Default::default() };
    save(&field_with_isolines(&mesh, Values::PerVertex(&height), ""), &options, folder, "million.png")?;
    Ok(())
}

fn from_file(folder: &Path, file: &Path) -> Result<(), Failure> {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for line in std::fs::read_to_string(file)?.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f64> = words.map(str::parse).collect::<Result<_, _>>()?;
                positions.push(<[f64; 3]>::try_from(p.get(..3).ok_or("a vertex needs three numbers")?)?);
            }
            Some("f") => {
                let corners: Vec<u32> =
                    words.filter_map(|w| w.split('/').next()?.parse::<u32>().ok()?.checked_sub(1)).collect();
                faces.extend(
                    (1..corners.len().saturating_sub(1)).map(|k| [corners[0], corners[k], corners[k + 1]]),
                );
            }
            _ => {}
        }
    }
    let mesh = TriangleMesh::new(positions, faces)?;
    let name = file.file_stem().and_then(|s| s.to_str()).unwrap_or("mesh");
    let clay = Scene::new(&mesh, Coloring::default());
    save(&clay, &RenderOptions::default(), folder, &format!("{name}-clay.png"))?;
    let (low, high) = mesh
        .positions()
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |r, p| (r.0.min(p[1]), r.1.max(p[1])));
    let values: Vec<f64> = mesh.positions().iter().map(|p| p[1] - 0.5 * (low + high)).collect();
    let scene = field_with_isolines(&mesh, Values::PerVertex(&values), "height");
    save(&scene, &RenderOptions::default(), folder, &format!("{name}.png"))?;
    Ok(())
}
