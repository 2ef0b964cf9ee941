//! Renders small scenes whose pixels are known.

use eikona_mesh::{Curve, SurfaceCurves, TriangleMesh, Vertex, shapes};
use eikona_render::{
    Background, Camera, ColorMap, Coloring, CurveStyle, Drawing, GlyphStyle, Image, Isolines, Levels,
    Lighting, Outline, PointStyle, Projection, RenderError, RenderOptions, ScalarField, Scene, UpAxis,
    Values, Wireframe, label_color, render,
};

/// Unit square in the xy plane at height `z`, its cells cut from lower left to upper right.
fn square(cells: usize, z: f64) -> TriangleMesh {
    let n = cells + 1;
    let at = |i: usize| i as f64 / cells as f64;
    let positions = (0..n * n).map(|v| [at(v % n), at(v / n), z]).collect();
    let faces = (0..cells * cells)
        .flat_map(|c| {
            let a = (c / cells * n + c % cells) as u32;
            [[a, a + 1, a + 2 + cells as u32], [a, a + 2 + cells as u32, a + 1 + cells as u32]]
        })
        .collect();
    TriangleMesh::new(positions, faces).unwrap()
}

fn clay(mesh: &TriangleMesh) -> Scene<'_> {
    Scene::new(mesh, Coloring::default())
}

fn field<'a>(mesh: &'a TriangleMesh, values: Values<'a>) -> Scene<'a> {
    Scene::new(mesh, Coloring::Field(ScalarField::new(values)))
}

fn labelled<'a>(mesh: &'a TriangleMesh, labels: &'a [i64]) -> Scene<'a> {
    Scene::new(mesh, Coloring::Labels { labels, title: None })
}

fn curve(points: Vec<[f64; 3]>, style: CurveStyle) -> Drawing<'static> {
    Drawing::Curve { points: points.into(), style }
}

fn glyphs(ends: Vec<[[f64; 3]; 2]>, style: GlyphStyle) -> Drawing<'static> {
    Drawing::Glyphs { ends: ends.into(), style }
}

fn points(positions: Vec<[f64; 3]>, style: PointStyle) -> Drawing<'static> {
    Drawing::Points { positions: positions.into(), style }
}

/// Unlit orthographic view along -z: the unit square fills 0.9 of the image.
fn plain(size: u32) -> RenderOptions {
    RenderOptions {
        width: size,
        height: size,
        lighting: Lighting::Unlit,
        color_bar: false,
        camera: Camera { projection: Projection::Orthographic, ..Camera::default() },
        ..RenderOptions::default()
    }
}

/// Pixel at (x, y) of the unit square.
fn pixel(image: &Image, x: f64, y: f64) -> [u8; 4] {
    let coordinate = |t: f64| ((0.05 + 0.9 * t) * image.width as f64) as u32;
    image.pixel(coordinate(x), coordinate(1.0 - y)).unwrap()
}

fn darkness(p: [u8; 4]) -> i32 {
    255 - (p[0] as i32 + p[1] as i32 + p[2] as i32) / 3
}

#[test]
fn a_triangle_covers_its_area() {
    let mesh = TriangleMesh::new(vec![[0., 0., 0.], [1., 0.1, 0.], [0.3, 1., 0.]], vec![[0, 1, 2]]).unwrap();
    for supersampling in 1..=4 {
        let options = RenderOptions { supersampling, background: Background::Transparent, ..plain(200) };
        let image = render(&clay(&mesh), &options).unwrap();
        let covered: f64 = image.rgba.chunks(4).map(|p| p[3] as f64 / 255.0).sum();
        // The larger side, 1, is 0.9 * 200 pixels.
        let area = 0.5 * (1.0 * 1.0 - 0.1 * 0.3) * 180.0 * 180.0;
        assert!((covered / area - 1.0).abs() < 0.004, "{supersampling}: {covered} for {area}");
    }
}

#[test]
fn adjacent_faces_leave_no_gap() {
    let mesh = square(37, 0.0);
    let image = render(&Scene::new(&mesh, Coloring::Plain([10, 20, 30])), &plain(301)).unwrap();
    for i in 20..280 {
        for j in 20..280 {
            assert_eq!(image.pixel(i, j), Some([10, 20, 30, 255]));
        }
    }
}

#[test]
fn colors_match_the_map() {
    let mesh = square(4, 0.0);
    let x: Vec<f64> = mesh.positions().iter().map(|p| 2.0 * p[0] - 1.0).collect();
    let map = ColorMap::signed();
    let image = render(&field(&mesh, Values::PerVertex(&x)), &plain(400)).unwrap();
    for share in [0.1, 0.3, 0.7, 0.9] {
        let (seen, wanted) = (pixel(&image, share, 0.37), map.color(share));
        assert!((0..3).all(|k| seen[k].abs_diff(wanted[k]) <= 3), "{seen:?} {wanted:?}");
    }
    let (left, right) = (pixel(&image, 0.2, 0.5), pixel(&image, 0.8, 0.5));
    assert!(left[2] > left[0] + 40, "negative is blue");
    assert!(right[0] > right[2] + 40, "positive is orange");
}

#[test]
fn the_nearer_face_wins_in_either_order() {
    let positions = |near: f64, far: f64| {
        let corners = |z: f64| [[0., 0., z], [1., 0., z], [1., 1., z], [0., 1., z]];
        [corners(near), corners(far)].concat()
    };
    let faces = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    for (z, front) in [([0.0, -0.8], 1), ([-0.8, 0.0], 2)] {
        let mesh = TriangleMesh::new(positions(z[0], z[1]), faces.clone()).unwrap();
        for projection in [Projection::Orthographic, Projection::Perspective { field_of_view: 0.6 }] {
            let mut options = plain(100);
            options.camera = Camera {
                up: UpAxis::Y,
                azimuth: Some(0.0),
                elevation: Some(0.0),
                projection,
                ..Camera::default()
            };
            let image = render(&labelled(&mesh, &[1, 1, 2, 2]), &options).unwrap();
            let other = render(&labelled(&mesh, &[front, front, 2, 2]), &options).unwrap();
            let seen = image.pixel(50, 50).unwrap();
            let wanted = if front == 1 { other.pixel(50, 50).unwrap() } else { seen };
            assert_eq!(seen, wanted);
            let [r, g, b] = label_color(1);
            let label_one = [r, g, b, 255];
            assert_eq!(seen == label_one, front == 1);
        }
    }
}

#[test]
fn curves_behind_the_surface_are_hidden() {
    let mesh = square(3, 0.0);
    let line = |z: f64| vec![[0.1, 0.5, z], [0.9, 0.5, z]];
    let style = CurveStyle { color: [255, 0, 0], width: 6.0, ..CurveStyle::default() };
    let mut options = plain(300);
    for projection in [Projection::Orthographic, Projection::Perspective { field_of_view: 0.5 }] {
        options.camera = Camera {
            up: UpAxis::Y,
            azimuth: Some(0.3),
            elevation: Some(0.2),
            projection,
            ..Camera::default()
        };
        let red = |z: f64| {
            let scene = clay(&mesh).with(curve(line(z), style.clone()));
            let image = render(&scene, &options).unwrap();
            image.rgba.chunks(4).filter(|p| p[0] > 200 && p[1] < 60).count()
        };
        let on = red(0.0);
        // A line of length 0.8 on a square about 270 pixels wide, 6 pixels wide, rotated by 0.3
        // radians.
        assert!((700..1600).contains(&on), "{on}");
        assert!(red(0.1) >= on * 9 / 10);
        assert_eq!(red(-0.1), 0);
        let ball = PointStyle { color: [255, 0, 0], radius: 8.0 };
        let balls = |z: f64| {
            let scene = clay(&mesh).with(points(vec![[0.5, 0.5, z]], ball));
            let image = render(&scene, &options).unwrap();
            image.rgba.chunks(4).filter(|p| p[0] > 200 && p[1] < 60).count()
        };
        let area = std::f64::consts::PI * 64.0;
        assert!((balls(0.0) as f64 / area - 1.0).abs() < 0.15, "{}", balls(0.0));
        assert_eq!(balls(-0.2), 0);
    }
}

#[test]
fn curves_may_refer_to_another_mesh() {
    let (shown, coarse) = (square(3, 0.0), square(1, 0.0));
    let style = CurveStyle { color: [255, 0, 0], width: 6.0, ..CurveStyle::default() };
    let diagonal = SurfaceCurves::from_curve(Curve::signed([0, 3].map(Vertex)));
    let drawings = Drawing::surface_curves(&coarse, &diagonal, &style, PointStyle::default()).unwrap();
    let by_position = clay(&shown).with(curve(vec![[0., 0., 0.], [1., 1., 0.]], style));
    let image = render(&Scene { drawings, ..clay(&shown) }, &plain(100)).unwrap();
    assert_eq!(image.rgba, render(&by_position, &plain(100)).unwrap().rgba);
    assert_eq!(pixel(&image, 0.5, 0.5), [255, 0, 0, 255]);
}

#[test]
fn a_long_legend_title_does_not_cover_the_surface() {
    let mesh = shapes::grid(4, 1, 4.0, 1.0, shapes::Diagonal::Alternating).unwrap();
    let title = "a title longer than its swatches";
    let scene = Scene::new(&mesh, Coloring::Labels { labels: &[0; 8], title: Some(title) });
    let options = RenderOptions { width: 500, height: 300, color_bar: true, ..plain(300) };
    let image = render(&scene, &options).unwrap();
    // The only swatch is at half the image height, with the title above it.
    let columns = |rows: std::ops::Range<u32>, is: &dyn Fn([u8; 4]) -> bool| -> Vec<u32> {
        let seen = |x| rows.clone().any(|y| image.pixel(x, y).is_some_and(is));
        (0..500).filter(|&x| seen(x)).collect()
    };
    let ink = columns(0..140, &|p| darkness(p) > 130);
    let surface = columns(160..300, &|p| p == [206, 206, 203, 255]).last().copied();
    assert!(surface < ink.first().copied(), "{surface:?} {:?}", ink.first());
    assert!(surface.unwrap() > 150, "the surface keeps its space");
}

#[test]
fn isolines_have_the_right_position_and_width() {
    let mesh = square(5, 0.0);
    let x: Vec<f64> = mesh.positions().iter().map(|p| p[0]).collect();
    let lines = Isolines {
        levels: Levels::Values(vec![0.7, 0.25]),
        width: 4.0,
        color: [0, 0, 0],
        opacity: 1.0,
        ..Isolines::default()
    };
    let color_map = Some(ColorMap::by_name("lagoon").unwrap());
    let values = ScalarField { color_map, ..ScalarField::new(Values::PerVertex(&x)) };
    let scene = Scene::new(&mesh, Coloring::Field(values));
    let without = render(&scene, &plain(400)).unwrap();
    let with = render(&scene.with(Drawing::Isolines(lines)), &plain(400)).unwrap();
    let row = 200;
    let mut found: Vec<(f64, f64)> = Vec::new(); // width and first moment of each dark run
    let mut inside = false;
    for i in 0..400 {
        let (a, b) = (without.pixel(i, row).unwrap(), with.pixel(i, row).unwrap());
        let share = (darkness(b) - darkness(a)) as f64 / (255 - darkness(a)).max(1) as f64;
        if share > 0.02 {
            if !inside {
                found.push((0.0, 0.0));
            }
            let last = found.last_mut().unwrap();
            *last = (last.0 + share, last.1 + share * (i as f64 + 0.5));
        }
        inside = share > 0.02;
    }
    assert_eq!(found.len(), 2, "{found:?}");
    for ((width, moment), level) in found.into_iter().zip([0.25, 0.7]) {
        // Darkness is measured in sRGB, in which a half covered pixel is less than half dark.
        assert!((width - 4.0).abs() < 0.8, "{width}");
        assert!((moment / width - (0.05 + 0.9 * level) * 400.0).abs() < 0.5, "{}", moment / width);
    }
}

#[test]
fn corner_values_jump_at_the_edge() {
    let mesh = square(1, 0.0); // two faces, cut from lower left to upper right
    let image = render(&field(&mesh, Values::PerCorner(&[0., 0., 0., 1., 1., 1.])), &plain(200)).unwrap();
    let map = ColorMap::viridis();
    let rgb = |p: [u8; 4]| [p[0], p[1], p[2]];
    assert_eq!(rgb(pixel(&image, 0.515, 0.485)), map.color(0.0));
    assert_eq!(rgb(pixel(&image, 0.485, 0.515)), map.color(1.0));
}

#[test]
fn quotients_are_divided_per_pixel() {
    let mesh = square(1, 0.0);
    // x / (1 + x) is not linear: at x = 1/2 it is 1/3, not 1/4, the mean of its ends.
    let x: Vec<f64> = mesh.triangles().iter().flatten().map(|&v| mesh.positions()[v as usize][0]).collect();
    let below: Vec<f64> = x.iter().map(|x| 1.0 + x).collect();
    let values = Values::Quotient { numerator: &x, denominator: &below };
    let quotient = ScalarField { range: Some([0.0, 1.0]), ..ScalarField::new(values) };
    let scene = Scene::new(&mesh, Coloring::Field(quotient));
    let seen = pixel(&render(&scene, &plain(400)).unwrap(), 0.5, 0.3);
    let wanted = ColorMap::viridis().color(1.0 / 3.0);
    assert!((0..3).all(|k| seen[k].abs_diff(wanted[k]) <= 2), "{seen:?} {wanted:?}");
}

#[test]
fn missing_values_are_neutral_gray() {
    let mesh = square(1, 0.0);
    let image = render(&field(&mesh, Values::PerFace(&[f64::NAN, 1.0])), &plain(200)).unwrap();
    let [r, g, b, _] = pixel(&image, 0.8, 0.3);
    assert!(r.abs_diff(g) <= 3 && g.abs_diff(b) <= 3 && r < 200, "{r} {g} {b}");
}

#[test]
fn the_same_scene_gives_the_same_bytes_on_any_number_of_threads() {
    let mesh = bowl();
    let height: Vec<f64> = mesh.positions().iter().map(|p| p[2]).collect();
    let titled = ScalarField { title: Some("height"), ..ScalarField::new(Values::PerVertex(&height)) };
    let arrows = CurveStyle { arrow_spacing: Some(40.0), ..CurveStyle::default() };
    let scene = Scene::new(&mesh, Coloring::Field(titled))
        .with(Drawing::Isolines(Isolines::default()))
        .with(curve(vec![[-0.5, -0.5, 0.5], [0.5, 0.5, 0.5]], arrows))
        .with(glyphs(vec![[[-0.2, 0.1, 0.1], [0.2, 0.3, 0.1]]], GlyphStyle::default()))
        .with(points(vec![[0.0; 3]], PointStyle::default()));
    let options = RenderOptions {
        width: 320,
        height: 240,
        wireframe: Some(Wireframe::default()),
        ..Default::default()
    };
    let first = render(&scene, &options).unwrap().to_png_bytes().unwrap();
    let second = render(&scene, &options).unwrap().to_png_bytes().unwrap();
    assert!(first == second);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let bytes = pool.install(|| render(&scene, &options).unwrap().to_png_bytes().unwrap());
        assert!(first == bytes, "{threads} threads");
    }
}

/// Paraboloid over [-1, 1]^2.
fn bowl() -> TriangleMesh {
    let flat = square(20, 0.0);
    let positions = flat
        .positions()
        .iter()
        .map(|p| {
            let (x, y) = (2.0 * p[0] - 1.0, 2.0 * p[1] - 1.0);
            [x, y, 0.5 * (x * x + y * y)]
        })
        .collect();
    flat.with_positions(positions).unwrap()
}

#[test]
fn images_do_not_depend_on_scale_or_translation() {
    let mesh = bowl();
    let options = RenderOptions { width: 120, height: 90, color_bar: false, ..Default::default() };
    let base = render(&clay(&mesh), &options).unwrap();
    for (factor, shift) in [(1e8, 0.0), (1e-8, 0.0), (1e300, 0.0), (1e-300, 0.0), (1.0, 1e6)] {
        let moved: Vec<[f64; 3]> = mesh.positions().iter().map(|p| p.map(|x| factor * x + shift)).collect();
        let moved = mesh.with_positions(moved).unwrap();
        let image = render(&clay(&moved), &options).unwrap();
        let different = image.rgba.iter().zip(&base.rgba).filter(|(a, b)| a.abs_diff(**b) > 6).count();
        assert!(different < base.rgba.len() / 200, "{factor} {shift}: {different}");
    }
}

#[test]
fn png_decodes_to_the_same_pixels() {
    let mesh = bowl();
    for background in [Background::Transparent, Background::Solid([250, 250, 250])] {
        let options = RenderOptions { width: 97, height: 53, background, ..Default::default() };
        let image = render(&clay(&mesh), &options).unwrap();
        let bytes = image.to_png_bytes().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (97, 53));
        let channels = pixels.len() / (97 * 53);
        for (p, q) in image.rgba.chunks(4).zip(pixels.chunks(channels)) {
            assert_eq!(&p[..channels], q);
        }
    }
}

#[test]
fn files_are_written_atomically() {
    let image = Image { width: 1, height: 1, rgba: vec![1, 2, 3, 255] };
    let folder = std::env::temp_dir().join(format!("eikona-render-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    image.write_png(folder.join("one.png")).unwrap();
    let left: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["one.png"]);
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(matches!(image.write_png(folder.join("one.png")), Err(RenderError::Write { .. })));
    for side in [2, u32::MAX] {
        let broken = Image { width: side, height: side, rgba: vec![0; 4] };
        assert!(matches!(broken.to_png_bytes(), Err(RenderError::Encoding { .. })));
        assert_eq!(broken.pixel(side - 1, side - 1), None);
    }
}

#[test]
fn empty_scenes_show_the_background() {
    let empty = TriangleMesh::new(vec![[f64::MAX, 0.0, 0.0]], vec![]).unwrap();
    let options = RenderOptions { background: Background::Solid([9, 8, 7]), ..plain(40) };
    let image = render(&clay(&empty), &options).unwrap();
    assert!(image.rgba.chunks(4).all(|p| p == [9, 8, 7, 255]));
    let lit = RenderOptions { width: 50, height: 40, ..Default::default() };
    let scene = field(&empty, Values::PerVertex(&[1.0])).with(Drawing::Isolines(Isolines::default()));
    let image = render(&scene, &lit).unwrap();
    assert!(image.rgba.chunks(4).all(|p| p == [255; 4]));
}

#[test]
fn extreme_cameras_and_degenerate_faces_render() {
    let bowl = bowl();
    let height: Vec<f64> = bowl.positions().iter().map(|p| p[2]).collect();
    let slivers = TriangleMesh::new(
        vec![[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [0., 1e-13, 0.], [1., 1., 1.], [1., 1., 1.]],
        vec![[0, 1, 2], [0, 1, 3], [0, 4, 5], [3, 4, 1]],
    )
    .unwrap();
    let point = TriangleMesh::new(vec![[3.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    for (mesh, values) in
        [(&bowl, height.as_slice()), (&slivers, &[0., 1., -1., 2., 0., 5.]), (&point, &[0.0; 3])]
    {
        for distance in [None, Some(1e-300), Some(1e-4), Some(0.05), Some(1.0), Some(1e300)] {
            for (azimuth, elevation, field_of_view) in
                [(0.0, 0.0, 0.5), (1.0, std::f64::consts::FRAC_PI_2, 3.1), (-4.0, -1.2, 0.001)]
            {
                let camera = Camera {
                    distance,
                    azimuth: Some(azimuth),
                    elevation: Some(elevation),
                    target: distance.map(|_| [0.1, 0.0, 0.05]),
                    projection: Projection::Perspective { field_of_view },
                    zoom: 1.0 + azimuth.abs() * 1e3,
                    ..Camera::default()
                };
                let options = RenderOptions {
                    width: 40,
                    height: 30,
                    camera,
                    wireframe: Some(Wireframe::default()),
                    ..Default::default()
                };
                let style = CurveStyle {
                    arrow_spacing: Some(1.0),
                    outline: Some(Outline { color: [0; 3], width: 2.0 }),
                    ..CurveStyle::default()
                };
                let dense = Isolines { levels: Levels::Spacing(1e-200), ..Isolines::default() };
                let far = vec![[-1e9, 0., 0.], [1., 1., 1.], [1e9, 3., -1e9]];
                let arrows = vec![[far[0], far[2]], [[0.0; 3], [0.1, 0.0, 0.05]], [[0.1; 3]; 2]];
                let small = PointStyle { radius: 0.0, ..PointStyle::default() };
                let scene = field(mesh, Values::PerVertex(values))
                    .with(Drawing::Isolines(dense))
                    .with(curve(far, style))
                    .with(glyphs(arrows, GlyphStyle::default()))
                    .with(points(vec![[0.1, 0.0, 0.05]], small));
                assert_eq!(render(&scene, &options).unwrap().rgba.len(), 4 * 40 * 30);
            }
        }
    }
}

#[test]
fn images_of_one_pixel_and_the_widest_strokes_render() {
    let mesh = bowl();
    let height: Vec<f64> = mesh.positions().iter().map(|p| p[2]).collect();
    let corners: Vec<[f64; 3]> = mesh.positions().iter().step_by(40).copied().collect();
    let wide = CurveStyle { width: 200.0, arrow_spacing: Some(1.0), ..CurveStyle::default() };
    let scene = field(&mesh, Values::PerVertex(&height))
        .with(Drawing::Isolines(Isolines { width: 200.0, ..Isolines::default() }))
        .with(curve(corners.clone(), wide.clone()))
        .with(curve(corners.clone(), wide))
        .with(curve(vec![], CurveStyle::default()))
        .with(curve(vec![[0.0; 3]], CurveStyle::default()))
        .with(glyphs(corners.windows(2).map(|w| [w[0], w[1]]).collect(), GlyphStyle::default()))
        .with(points(corners, PointStyle { radius: 200.0, ..PointStyle::default() }));
    for (width, height) in [(1, 1), (1, 300), (300, 1)] {
        let options = RenderOptions { width, height, ..RenderOptions::default() };
        assert_eq!(render(&scene, &options).unwrap().rgba.len(), 4 * (width * height) as usize);
    }
}

#[test]
fn arrowheads_do_not_cover_one_another() {
    let mesh = square(1, 0.0);
    let spaced = |spacing: f64| {
        let style = CurveStyle { width: 5.0, arrow_spacing: Some(spacing), ..CurveStyle::default() };
        render(&clay(&mesh).with(curve(vec![[0.1, 0.5, 0.0], [0.9, 0.5, 0.0]], style)), &plain(300)).unwrap()
    };
    // The heads are 23 pixels long.
    assert!(spaced(1.0) == spaced(23.0));
    assert!(spaced(23.0) != spaced(50.0));
}

#[test]
fn a_ball_without_radius_is_not_black() {
    let mesh = square(1, 0.0);
    let ball = PointStyle { color: [255; 3], radius: 0.0 };
    for size in 30..34 {
        let lit = RenderOptions { lighting: Lighting::Studio, ambient_occlusion: 0.0, ..plain(size) };
        let options = RenderOptions { supersampling: 1, ..lit };
        let scene = clay(&mesh).with(points(vec![[0.5, 0.5, 0.0]], ball));
        let image = render(&scene, &options).unwrap();
        assert!(pixel(&image, 0.5, 0.5)[..3].iter().all(|c| *c > 150));
    }
}

#[test]
fn extreme_values_render() {
    let mesh = square(1, 0.0);
    for values in [[f64::MAX, -f64::MAX, 0., 1.], [f64::MIN_POSITIVE, 0., 0., 0.], [7.0; 4], [f64::NAN; 4]] {
        let scene = field(&mesh, Values::PerVertex(&values)).with(Drawing::Isolines(Isolines::default()));
        render(&scene, &RenderOptions { width: 300, height: 200, ..Default::default() }).unwrap();
    }
    let zero = [0.0; 6];
    let quotient = Values::Quotient { numerator: &zero, denominator: &zero };
    render(&field(&mesh, quotient), &plain(50)).unwrap();
    render(&labelled(&mesh, &[i64::MIN, i64::MAX]), &plain(60)).unwrap();
}

#[test]
fn invalid_input_is_reported() {
    let mesh = square(1, 0.0);
    let options = plain(20);
    let fault = |scene: Scene| render(&scene, &options).unwrap_err();
    assert!(matches!(
        fault(field(&mesh, Values::PerVertex(&[1.0]))),
        RenderError::WrongLength { found: 1, expected: 4, .. }
    ));
    assert!(matches!(
        fault(field(&mesh, Values::PerFace(&[0.0, f64::INFINITY]))),
        RenderError::NonFinite { index: 1, .. }
    ));
    assert!(matches!(
        fault(clay(&mesh).with(curve(vec![[0.0, f64::NAN, 0.0]], CurveStyle::default()))),
        RenderError::NonFinite { index: 0, .. }
    ));
    let error = fault(
        clay(&mesh)
            .with(glyphs(vec![[[0.0; 3]; 2], [[0.0; 3], [0.0, f64::NAN, 0.0]]], GlyphStyle::default())),
    );
    assert!(error.to_string().starts_with("an end of drawing 0, glyph 1 is NaN"), "{error}");
    let too_wide = CurveStyle { width: 200.5, ..CurveStyle::default() };
    let error = fault(clay(&mesh).with(curve(vec![[0.0; 3]; 2], too_wide)));
    assert!(matches!(error, RenderError::Option { name: "curve width", .. }));
    let no_range = ScalarField { range: Some([1.0; 2]), ..ScalarField::new(Values::PerVertex(&[0.0; 4])) };
    assert!(matches!(fault(Scene::new(&mesh, Coloring::Field(no_range))), RenderError::Range { .. }));
    for scene in [clay(&mesh), labelled(&mesh, &[0, 1]), field(&mesh, Values::PerFace(&[0.0, 1.0]))] {
        let scene = scene.with(Drawing::Isolines(Isolines::default()));
        assert!(matches!(fault(scene), RenderError::NoIsolines));
    }
    let render_with = |change: &dyn Fn(&mut RenderOptions)| {
        let mut options = plain(20);
        change(&mut options);
        render(&clay(&mesh), &options).unwrap_err()
    };
    assert!(matches!(render_with(&|o| o.width = 0), RenderError::ImageSize { .. }));
    assert!(matches!(
        render_with(&|o| o.supersampling = 9),
        RenderError::Option { name: "supersampling", .. }
    ));
    assert!(matches!(render_with(&|o| o.camera.zoom = f64::NAN), RenderError::Option { name: "zoom", .. }));
    let huge = |o: &mut RenderOptions| (o.width, o.height, o.supersampling) = (16384, 16384, 2);
    assert!(matches!(render_with(&huge), RenderError::TooManySamples { .. }));
}

/// Largest difference of a channel.
fn difference(a: &Image, b: &Image) -> u8 {
    a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn shading_does_not_depend_on_face_orientation() {
    let small = RenderOptions { width: 160, height: 120, ..RenderOptions::default() };
    let band = shapes::moebius_band(1.0, 0.6, 60, 6).unwrap();
    for (name, mesh) in [("bowl", bowl()), ("one-sided band", band)] {
        let whole = render(&clay(&mesh), &small).unwrap();
        let third = mesh.face_count() / 3;
        let some_flipped = mesh.with_flipped_faces(|f| f.index() % 5 == 1);
        let part_flipped = mesh.with_flipped_faces(|f| f.index() < third);
        for flipped in [some_flipped, part_flipped] {
            let image = render(&clay(&flipped), &small).unwrap();
            assert!(difference(&whole, &image) <= 2, "{name}: {}", difference(&whole, &image));
        }
    }
    // The back of an orientable surface is still tinted.
    let flipped = bowl().with_flipped_faces(|_| true);
    let images = [bowl(), flipped].map(|mesh| render(&clay(&mesh), &small).unwrap());
    assert!(difference(&images[0], &images[1]) > 10);
}

#[test]
fn short_zero_isolines_are_not_drawn() {
    let mesh = square(8, 0.0);
    let dip = |p: &[f64; 3], below: f64| if p[0] == 0.5 && p[1] == 0.5 { -below } else { 1.0 };
    let drawn = |below: f64| {
        let values: Vec<f64> = mesh.positions().iter().map(|p| dip(p, below)).collect();
        let lines = Isolines { levels: Levels::Values(vec![0.0]), zero_width: 4.0, ..Isolines::default() };
        let scene = field(&mesh, Values::PerVertex(&values));
        let without = render(&scene, &plain(300)).unwrap();
        difference(&without, &render(&scene.with(Drawing::Isolines(lines)), &plain(300)).unwrap())
    };
    // The loop around the vertex is 0.006 of an edge long, then several edges.
    assert_eq!(drawn(1e-3), 0);
    assert!(drawn(4.0) > 100, "{}", drawn(4.0));
}

#[test]
fn isolines_of_two_styles_are_drawn_in_order() {
    let mesh = square(5, 0.0);
    let x: Vec<f64> = mesh.positions().iter().map(|p| p[0]).collect();
    let lines = |level: f64, color: [u8; 3]| {
        let levels = Levels::Values(vec![level]);
        Drawing::Isolines(Isolines { levels, width: 8.0, color, opacity: 1.0, ..Isolines::default() })
    };
    let (red, blue) = ([255, 0, 0], [0, 0, 255]);
    let scene = field(&mesh, Values::PerVertex(&x))
        .with(lines(0.25, red))
        .with(lines(0.7, red))
        .with(lines(0.7, blue));
    let image = render(&scene, &plain(200)).unwrap();
    assert_eq!(pixel(&image, 0.25, 0.5)[..3], red);
    assert_eq!(pixel(&image, 0.7, 0.5)[..3], blue);
}

#[test]
fn later_drawings_cover_earlier_ones() {
    let mesh = square(1, 0.0);
    let line = |color| {
        curve(
            vec![[0.1, 0.5, 0.0], [0.9, 0.5, 0.0]],
            CurveStyle { color, width: 9.0, ..CurveStyle::default() },
        )
    };
    let ball = || points(vec![[0.5, 0.5, 0.0]], PointStyle { color: [255, 0, 0], radius: 6.0 });
    let middle = |scene: &Scene| pixel(&render(scene, &plain(100)).unwrap(), 0.5, 0.5);
    let blue = [0, 0, 255];
    assert_eq!(middle(&clay(&mesh).with(line(blue)).with(ball())), [255, 0, 0, 255]);
    assert_eq!(middle(&clay(&mesh).with(ball()).with(line(blue))), [0, 0, 255, 255]);
    assert_eq!(middle(&clay(&mesh).with(line(blue)).with(line([0, 255, 0]))), [0, 255, 0, 255]);
}

#[test]
fn glyphs_have_a_shaft_and_a_head_at_their_tip() {
    let mesh = square(1, 0.0);
    let color = [255, 0, 0];
    let is_red = |p: &[u8]| p[0] > 200 && p[1] < 60;
    let drawn = |x: [f64; 2], style: GlyphStyle| {
        let scene = clay(&mesh).with(glyphs(vec![[[x[0], 0.5, 0.0], [x[1], 0.5, 0.0]]], style));
        render(&scene, &plain(400)).unwrap()
    };
    let area = |image: &Image| image.rgba.chunks(4).filter(|p| is_red(p)).count() as f64;
    // 180 pixels long and 6 wide; the head is 27.6 pixels long and 24 wide.
    let style = GlyphStyle { color, width: 6.0, outline: None, head: false };
    let (mark, arrow) = (drawn([0.25, 0.75], style), drawn([0.25, 0.75], GlyphStyle { head: true, ..style }));
    assert!((area(&mark) / (180.0 * 6.0) - 1.0).abs() < 0.05, "{}", area(&mark));
    let wanted = (180.0 - 27.6) * 6.0 + 0.5 * 27.6 * 24.0;
    assert!((area(&arrow) / wanted - 1.0).abs() < 0.05, "{} for {wanted}", area(&arrow));
    // 10 pixels above the line: only the wide end of the head.
    let row = |image: &Image| (0..400).filter(|&i| is_red(&image.pixel(i, 190).unwrap())).collect::<Vec<_>>();
    assert!(row(&mark).is_empty());
    let head = row(&arrow);
    assert!(!head.is_empty() && head.iter().all(|i| (262..280).contains(i)), "{head:?}");
    // A short arrow is half head, and as long as it should be.
    let short = drawn([0.5, 0.55], GlyphStyle { head: true, ..style });
    let red: Vec<u32> = (0..400).filter(|&i| is_red(&short.pixel(i, 200).unwrap())).collect();
    assert!((15..=18).contains(&red.len()), "{red:?}");
    assert!(area(&short) < 0.5 * 18.0 * 9.0, "{}", area(&short));
    // An outline surrounds it.
    let outline = Some(Outline { color: [0, 0, 255], width: 3.0 });
    let outlined = drawn([0.25, 0.75], GlyphStyle { outline, ..style });
    assert!((area(&outlined) - area(&mark)).abs() < 20.0);
    assert_eq!(pixel(&outlined, 0.5, 0.5 + 4.5 / 360.0), [0, 0, 255, 255]);
}

#[test]
fn glyphs_are_visible_if_their_middle_is() {
    // A floor and, above half of it, a roof.
    let corners = |x: f64, z: f64| [[0., 0., z], [x, 0., z], [x, 1., z], [0., 1., z]];
    let positions = [corners(1.0, 0.0), corners(0.5, 0.5)].concat();
    let roofed = TriangleMesh::new(positions, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]).unwrap();
    let style = GlyphStyle { color: [255, 0, 0], width: 4.0, outline: None, head: false };
    let elevation = Some(std::f64::consts::FRAC_PI_2);
    let above = Camera { elevation, azimuth: Some(0.0), up: UpAxis::Z, ..plain(1).camera };
    let red = |mesh: &TriangleMesh, ends: [[f64; 3]; 2]| {
        let options = RenderOptions { camera: above.clone(), ..plain(200) };
        let image = render(&clay(mesh).with(glyphs(vec![ends], style)), &options).unwrap();
        image.rgba.chunks(4).filter(|p| p[0] > 200 && p[1] < 60).count()
    };
    let along = |from: f64, to: f64, z: f64| [[from, 0.5, z], [to, 0.5, z]];
    let whole = red(&roofed, along(0.7, 0.9, 0.0));
    assert!(whole > 100, "{whole}");
    assert_eq!(red(&roofed, along(0.1, 0.3, 0.0)), 0, "under the roof");
    assert_eq!(red(&roofed, along(0.1, 0.3, 0.5)), whole, "on the roof");
    assert_eq!(red(&roofed, along(0.38, 0.58, 0.0)), 0, "the middle is under the roof");
    let part = red(&roofed, along(0.42, 0.62, 0.0));
    assert!(part > whole / 2 && part < whole, "the roof covers an end");
    // A horizontal glyph in a valley touches it with its middle only.
    let valley = bowl();
    let flat = red(&valley, along(-0.2, 0.2, 0.125).map(|[x, _, z]| [x, -0.5, z - 0.01]));
    assert!(flat > whole / 2, "{flat}");
}
