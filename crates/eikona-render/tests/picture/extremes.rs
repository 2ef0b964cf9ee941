//! Odd and invalid input: empty scenes, extreme sizes and values.

use super::*;

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
