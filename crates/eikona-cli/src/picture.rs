//! Pictures: camera and style options, and the drawing shared by all commands.

use crate::exit::Failure;
use crate::number::finite;
use clap::Args;
use eikona_mesh::{SurfaceCurves, TriangleMesh};
use eikona_render::{
    Background, Camera, ColorMap, CurveStyle, Isolines, Levels, PointStyle, Projection, RenderOptions, Scene,
    UpAxis, Wireframe, render,
};
use std::path::Path;

/// Camera and style.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Picture")]
pub struct PictureArguments {
    /// Width and height in pixels [default: 1200x900]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Rotate the camera to the right, in degrees [default: 30; 0 for a planar mesh]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = finite)]
    pub azimuth: Option<f64>,
    /// Raise the camera, in degrees [default: 20; 38 for a mesh that lies flat, 0 for a planar one]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = finite)]
    pub elevation: Option<f64>,
    /// Magnification relative to the fitted view [default: 1]
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = parse_zoom)]
    pub zoom: Option<f64>,
    /// Axis that points up [default: y; z for a nonplanar mesh that is thin along z]
    #[arg(long, value_name = "x|y|z", value_parser = parse_up)]
    pub up: Option<UpAxis>,
    /// Use an orthographic projection
    #[arg(long)]
    pub ortho: bool,
    /// Leave the background transparent
    #[arg(long)]
    pub transparent: bool,
    /// Omit the colour bar
    #[arg(long)]
    pub no_bar: bool,
    /// Draw the mesh edges
    #[arg(long)]
    pub wireframe: bool,
    /// Colour map: signed, viridis, magma, lagoon, phase, gray
    #[arg(long, value_name = "NAME", value_parser = parse_map)]
    pub map: Option<String>,
    /// Values at the ends of the colour map
    #[arg(long, value_name = "A,B", allow_hyphen_values = true, value_parser = parse_range)]
    pub range: Option<(f64, f64)>,
}

impl PictureArguments {
    /// The first picture option given.
    pub fn given(&self) -> Option<&'static str> {
        let flags = [
            (self.size.is_some(), "--size"),
            (self.azimuth.is_some(), "--azimuth"),
            (self.elevation.is_some(), "--elevation"),
            (self.zoom.is_some(), "--zoom"),
            (self.up.is_some(), "--up"),
            (self.ortho, "--ortho"),
            (self.transparent, "--transparent"),
            (self.no_bar, "--no-bar"),
            (self.wireframe, "--wireframe"),
        ];
        flags.into_iter().find(|(given, _)| *given).map(|(_, flag)| flag).or(self.about_values())
    }

    /// The first option given that maps values to colours.
    pub fn about_values(&self) -> Option<&'static str> {
        self.map.as_ref().map(|_| "--map").or(self.range.map(|_| "--range"))
    }
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let (width, height) = sides.ok_or("expected two whole numbers such as 1200x900")?;
    let options = RenderOptions { width, height, ..RenderOptions::default() };
    options.validate().map(|()| (width, height)).map_err(|e| e.to_string())
}

fn parse_zoom(text: &str) -> Result<f64, String> {
    let zoom = finite(text)?;
    let camera = Camera { zoom, ..Camera::default() };
    let options = RenderOptions { camera, ..RenderOptions::default() };
    options.validate().map(|()| zoom).map_err(|e| e.to_string())
}

/// Fails if a picture's name does not end in .png.
pub fn check_picture_path(path: &Path) -> Result<(), Failure> {
    if path == Path::new("-") || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{}: pictures are PNG files; name it {}",
        path.display(),
        path.with_extension("png").display()
    )))
}

fn parse_up(text: &str) -> Result<UpAxis, String> {
    match text {
        "x" | "X" => Ok(UpAxis::X),
        "y" | "Y" => Ok(UpAxis::Y),
        "z" | "Z" => Ok(UpAxis::Z),
        "auto" => Ok(UpAxis::Auto),
        _ => Err("expected x, y, z or auto".into()),
    }
}

fn parse_map(text: &str) -> Result<String, String> {
    ColorMap::by_name(text).map(|map| map.name().to_string()).map_err(|e| e.to_string())
}

fn parse_range(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(',').and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    ends.filter(|(a, b): &(f64, f64)| a < b && a.is_finite() && b.is_finite())
        .ok_or_else(|| "expected two finite numbers such as -1,1, the smaller first".into())
}

/// Fields and curves to draw on the mesh.
#[derive(Clone, Default)]
pub struct Drawing<'a> {
    /// Values per vertex, and the title of the colour bar.
    pub field: Option<(&'a [f64], &'a str)>,
    /// Values per face and their title; drawn if there are none per vertex.
    pub face_field: Option<(&'a [f64], &'a str)>,
    /// Numerators and denominators per corner, and the title of the quotient; drawn if there are no
    /// values per vertex or face.
    pub quotient: Option<([&'a [f64]; 2], &'a str)>,
    /// Integers per face, drawn as regions; drawn if there are no other values.
    pub labels: Option<&'a [i64]>,
    /// Isolines of the field.
    pub levels: Option<Levels>,
    /// Curves and points on the mesh.
    pub curves: Option<&'a SurfaceCurves>,
    /// The mesh that the curves lie on, if it is not the one drawn.
    pub curves_of: Option<&'a TriangleMesh>,
    /// Borders of regions, drawn thinner and below the curves.
    pub borders: Option<&'a SurfaceCurves>,
    /// Default colour map. `None` chooses one by the signs of the values.
    pub map: Option<ColorMap>,
}

const CURVE: CurveStyle =
    CurveStyle { color: [30, 30, 36], width: 4.6, rim: Some(([255, 255, 255], 1.5)), arrow_spacing: None };

const BORDER: CurveStyle =
    CurveStyle { color: [176, 24, 62], width: 2.4, rim: Some(([255, 255, 255], 1.0)), arrow_spacing: None };

/// Scales the widths of a style.
fn scaled(style: &CurveStyle, scale: f64) -> CurveStyle {
    let rim = style.rim.map(|(color, width)| (color, width * scale));
    CurveStyle { width: style.width * scale, rim, ..style.clone() }
}

/// Draws a PNG file.
pub fn draw(
    mesh: &TriangleMesh,
    drawing: &Drawing,
    arguments: &PictureArguments,
) -> Result<Vec<u8>, Failure> {
    let mut options = RenderOptions { color_bar: !arguments.no_bar, ..RenderOptions::default() };
    if let Some((width, height)) = arguments.size {
        (options.width, options.height) = (width, height);
    }
    options.camera = Camera {
        up: arguments.up.unwrap_or_default(),
        azimuth: arguments.azimuth.map(f64::to_radians),
        elevation: arguments.elevation.map(f64::to_radians),
        zoom: arguments.zoom.unwrap_or(1.0),
        ..Camera::default()
    };
    if arguments.ortho {
        options.camera.projection = Projection::Orthographic;
    }
    if arguments.transparent {
        options.background = Background::Transparent;
    }
    if arguments.wireframe {
        options.wireframe = Some(Wireframe::default());
    }
    // Widths are in pixels: scale those of curves with the picture.
    let scale = f64::from(options.height) / 900.0;
    let mut scene = Scene::new(mesh);
    if let Some((values, title)) = drawing.field {
        scene = scene.vertex_scalar(values).title(title);
    } else if let Some((values, title)) = drawing.face_field {
        scene = scene.face_scalar(values).title(title);
    } else if let Some(([numerator, denominator], title)) = drawing.quotient {
        scene = scene.corner_quotient(numerator, denominator).title(title);
    } else if let Some(labels) = drawing.labels {
        scene = scene.face_labels(labels).title("winding number");
    }
    if let Some(levels) = drawing.levels.clone() {
        let lines = Isolines::default();
        let (width, zero_width) = (lines.width * scale.max(0.5), lines.zero_width * scale.max(0.5));
        scene = scene.isolines(Isolines { levels, width, zero_width, ..lines });
    }
    if let Some(name) = &arguments.map {
        scene = scene.color_map(ColorMap::by_name(name)?);
    } else if let Some(map) = &drawing.map {
        scene = scene.color_map(map.clone());
    }
    if let Some((min, max)) = arguments.range {
        scene = scene.range(min, max);
    }
    let points = PointStyle::default();
    let points = PointStyle { radius: points.radius * scale, ..points };
    if let Some(borders) = drawing.borders {
        scene = scene.surface_curves(borders, &scaled(&BORDER, scale), points)?;
    }
    if let Some(curves) = drawing.curves {
        let of = drawing.curves_of.unwrap_or(mesh);
        scene = scene.surface_curves_of(of, curves, &scaled(&CURVE, scale), points)?;
    }
    Ok(render(&scene, &options)?.to_png_bytes()?)
}

/// Colour-maps values, for formats that show colours only.
pub fn colours(values: &[f64]) -> Vec<[u8; 3]> {
    const NO_VALUE: [u8; 3] = [128, 128, 128];
    let finite = values.iter().filter(|x| x.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
    let signed = low < 0.0 && high > 0.0;
    let map = if signed { ColorMap::signed() } else { ColorMap::viridis() };
    let (low, high) = if signed { (-high.max(-low), high.max(-low)) } else { (low, high) };
    let share = |x: f64| if high > low { (0.5 * x - 0.5 * low) / (0.5 * high - 0.5 * low) } else { 0.5 };
    values.iter().map(|&x| if x.is_finite() { map.color(share(x)) } else { NO_VALUE }).collect()
}
