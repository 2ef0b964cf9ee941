//! Pictures: camera and style options, and the styles shared by all commands.

use crate::exit::Failure;
use crate::number::finite;
use clap::Args;
use eikona_mesh::{SurfaceCurves, TriangleMesh};
use eikona_render::{
    Background, Camera, ColorMap, Coloring, CurveStyle, Drawing, Isolines, Levels, Outline, PointStyle,
    Projection, RenderError, RenderOptions, Scene, UpAxis, Wireframe, render,
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

    fn options(&self) -> RenderOptions {
        let defaults = RenderOptions::default();
        let (width, height) = self.size.unwrap_or((defaults.width, defaults.height));
        let camera = Camera {
            up: self.up.unwrap_or_default(),
            azimuth: self.azimuth.map(f64::to_radians),
            elevation: self.elevation.map(f64::to_radians),
            zoom: self.zoom.unwrap_or(1.0),
            projection: if self.ortho { Projection::Orthographic } else { defaults.camera.projection },
            ..defaults.camera
        };
        RenderOptions {
            width,
            height,
            camera,
            background: if self.transparent { Background::Transparent } else { defaults.background },
            wireframe: self.wireframe.then(Wireframe::default),
            color_bar: !self.no_bar,
            ..defaults
        }
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

const WHITE: [u8; 3] = [255; 3];

/// Style of the curves that a command reads, in a picture 900 pixels high.
const CURVE: CurveStyle = CurveStyle {
    color: [30, 30, 36],
    width: 4.6,
    outline: Some(Outline { color: WHITE, width: 1.5 }),
    arrow_spacing: None,
};

/// Style of the borders of regions, in a picture 900 pixels high.
const BORDER: CurveStyle = CurveStyle {
    color: [176, 24, 62],
    width: 2.4,
    outline: Some(Outline { color: WHITE, width: 1.0 }),
    arrow_spacing: None,
};

/// Drawings of curves and points, whose nodes refer to `mesh`.
pub fn curves(mesh: &TriangleMesh, curves: &SurfaceCurves) -> Result<Vec<Drawing<'static>>, RenderError> {
    Drawing::surface_curves(mesh, curves, &CURVE, PointStyle::default())
}

/// Drawings of borders of regions.
pub fn borders(mesh: &TriangleMesh, borders: &SurfaceCurves) -> Result<Vec<Drawing<'static>>, RenderError> {
    Drawing::surface_curves(mesh, borders, &BORDER, PointStyle::default())
}

/// Isolines in the default style.
pub fn isolines(levels: Levels) -> Drawing<'static> {
    Drawing::Isolines(Isolines { levels, ..Isolines::default() })
}

/// Draws a PNG file. The arguments replace the colour map and range of the scene; widths are scaled
/// with the height of the picture.
pub fn draw(mut scene: Scene, arguments: &PictureArguments) -> Result<Vec<u8>, Failure> {
    let options = arguments.options();
    if let Coloring::Field(field) = &mut scene.coloring {
        if let Some(name) = &arguments.map {
            field.color_map = Some(ColorMap::by_name(name)?);
        }
        if let Some((min, max)) = arguments.range {
            field.range = Some([min, max]);
        }
    }
    let scale = f64::from(options.height) / 900.0;
    scene.drawings.iter_mut().for_each(|drawing| scale_widths(drawing, scale));
    Ok(render(&scene, &options)?.to_png_bytes()?)
}

fn scale_widths(drawing: &mut Drawing, scale: f64) {
    let scale_outline = |outline: &mut Option<Outline>| {
        if let Some(outline) = outline {
            outline.width *= scale;
        }
    };
    match drawing {
        Drawing::Isolines(isolines) => {
            // Thinner isolines would fade out.
            isolines.width *= scale.max(0.5);
            isolines.zero_width *= scale.max(0.5);
        }
        Drawing::Curve { style, .. } => {
            style.width *= scale;
            scale_outline(&mut style.outline);
        }
        Drawing::Glyphs { style, .. } => {
            style.width *= scale;
            scale_outline(&mut style.outline);
        }
        Drawing::Points { style, .. } => style.radius *= scale,
        Drawing::Texts { style, .. } => {
            style.size *= scale;
            style.offset *= scale;
        }
    }
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
