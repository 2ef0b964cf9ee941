//! Renders small scenes whose pixels are known.

mod drawings;
mod extremes;

use eikona_mesh::{Curve, SurfaceCurves, TriangleMesh, Vertex, shapes};
use eikona_render::{
    Background, Camera, ColorMap, Coloring, CurveStyle, Drawing, GlyphStyle, Image, Isolines, Levels,
    Lighting, Outline, PointStyle, Projection, RenderError, RenderOptions, ScalarField, Scene, TextStyle,
    UpAxis, Values, Wireframe, label_color, render,
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
