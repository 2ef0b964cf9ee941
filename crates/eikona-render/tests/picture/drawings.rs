//! Isolines, curves, glyphs and points over the surface.

use super::*;

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

#[test]
fn texts_are_written_beside_visible_points_only() {
    let mesh = square(1, 0.0);
    let text = |z: f64| Drawing::Texts {
        positions: vec![[0.3, 0.4, z]].into(),
        texts: vec!["+1/4".to_string()].into(),
        style: TextStyle { size: 14.0, offset: 6.0, ..TextStyle::default() },
    };
    let options = plain(200);
    let empty = render(&clay(&mesh), &options).unwrap();
    let changed = |z: f64| {
        let image = render(&clay(&mesh).with(text(z)), &options).unwrap();
        let (mut dark, mut all) = (0, 0);
        for y in 0..200 {
            for x in 0..200 {
                let (a, b) = (image.pixel(x, y).unwrap(), empty.pixel(x, y).unwrap());
                // All letters are to the upper right of the point.
                assert!(a == b || x > 60 && y < 122, "{x} {y}");
                all += usize::from(a != b);
                dark += usize::from(darkness(a) > darkness(b) + 60);
            }
        }
        [dark, all]
    };
    let [dark, all] = changed(0.0);
    assert!(dark > 30 && all > 2 * dark, "letters {dark}, with their halo {all}");
    let hidden = render(&clay(&mesh).with(text(-0.5)), &options).unwrap();
    let is_ink = |image: &Image, x: u32, y: u32| darkness(image.pixel(x, y).unwrap()) > 180;
    let ink = |image: &Image| {
        (0..200).flat_map(|x| (0..200).map(move |y| (x, y))).filter(|&(x, y)| is_ink(image, x, y)).count()
    };
    let shown = render(&clay(&mesh).with(text(0.0)), &options).unwrap();
    assert!(ink(&shown) > 10 && ink(&hidden) == 0, "{} and {}", ink(&shown), ink(&hidden));
}
