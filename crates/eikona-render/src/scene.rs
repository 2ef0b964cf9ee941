//! Scene: a mesh, one field on it, curves and points.

use crate::color::ColorMap;
use crate::error::RenderError;
use crate::options::in_range;
use eikona_mesh::{SurfaceCurves, TriangleMesh};
use std::borrow::Cow;

/// Mesh with a field, curves and points to draw. The last field set is shown.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    pub(crate) mesh: &'a TriangleMesh,
    pub(crate) field: SceneField<'a>,
    pub(crate) color_map: Option<ColorMap>,
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) title: Option<String>,
    pub(crate) isolines: Option<Isolines>,
    pub(crate) surface_color: Option<[u8; 3]>,
    pub(crate) curves: Vec<(Cow<'a, [[f64; 3]]>, CurveStyle)>,
    pub(crate) points: Vec<(Cow<'a, [[f64; 3]]>, PointStyle)>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum SceneField<'a> {
    None,
    Vertex(&'a [f64]),
    Face(&'a [f64]),
    Corner(&'a [f64]),
    Quotient { numerator: &'a [f64], denominator: &'a [f64] },
    Labels(&'a [i64]),
}

/// Style and levels of isolines, which have constant width in pixels. Zero isolines of a field per
/// vertex that are shorter than an edge are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Isolines {
    /// Values of the isolines.
    pub levels: Levels,
    /// Width in pixels.
    pub width: f64,
    /// Width of the zero isoline in pixels.
    pub zero_width: f64,
    /// sRGB colour.
    pub color: [u8; 3],
    /// Opacity from 0 to 1; the zero isoline is nearly opaque.
    pub opacity: f64,
}

impl Default for Isolines {
    fn default() -> Self {
        Isolines { levels: Levels::About(18), width: 1.1, zero_width: 2.6, color: [18, 22, 34], opacity: 0.5 }
    }
}

/// Values of isolines.
#[derive(Clone, Debug, PartialEq)]
pub enum Levels {
    /// About this many multiples of a round number within the colour range.
    About(u32),
    /// All multiples of this number (greater than 0).
    Spacing(f64),
    /// These values, in any order.
    Values(Vec<f64>),
}

/// Style of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveStyle {
    /// sRGB colour.
    pub color: [u8; 3],
    /// Width in pixels.
    pub width: f64,
    /// Colour and width (pixels, on each side) of an outline that sets the curve off from the
    /// background.
    pub rim: Option<([u8; 3], f64)>,
    /// Spacing in pixels of arrowheads in the direction of the curve; each curve has at least one
    /// unless its position is hidden.
    pub arrow_spacing: Option<f64>,
}

impl Default for CurveStyle {
    fn default() -> Self {
        CurveStyle { color: [24, 26, 32], width: 4.0, rim: None, arrow_spacing: None }
    }
}

/// Style of points, which are drawn as small shaded balls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointStyle {
    /// sRGB colour.
    pub color: [u8; 3],
    /// Radius in pixels.
    pub radius: f64,
}

impl Default for PointStyle {
    fn default() -> Self {
        PointStyle { color: [196, 46, 46], radius: 6.0 }
    }
}

impl<'a> Scene<'a> {
    /// Creates a scene of the mesh alone, in clay.
    pub fn new(mesh: &'a TriangleMesh) -> Self {
        Scene {
            mesh,
            field: SceneField::None,
            color_map: None,
            range: None,
            title: None,
            isolines: None,
            surface_color: None,
            curves: Vec::new(),
            points: Vec::new(),
        }
    }
    /// Shows one value per vertex, linear in each face. A face with a NaN at a corner is hatched.
    pub fn vertex_scalar(mut self, values: &'a [f64]) -> Self {
        self.field = SceneField::Vertex(values);
        self
    }
    /// Shows one value per face.
    pub fn face_scalar(mut self, values: &'a [f64]) -> Self {
        self.field = SceneField::Face(values);
        self
    }
    /// Shows one value per corner (corner `k` of face `f` is `3 f + k`), linear in each face; jumps
    /// across edges stay sharp.
    pub fn corner_scalar(mut self, values: &'a [f64]) -> Self {
        self.field = SceneField::Corner(values);
        self
    }
    /// Shows a quotient given by numerator and denominator per corner, both linear in each face and
    /// divided per sample.
    pub fn corner_quotient(mut self, numerator: &'a [f64], denominator: &'a [f64]) -> Self {
        self.field = SceneField::Quotient { numerator, denominator };
        self
    }
    /// Shows one integer per face in categorical colours: see [`label_color`](crate::label_color).
    pub fn face_labels(mut self, labels: &'a [i64]) -> Self {
        self.field = SceneField::Labels(labels);
        self
    }
    /// Sets the colour map. Default: [`ColorMap::signed`] if values of both signs occur, else
    /// [`ColorMap::viridis`].
    pub fn color_map(mut self, map: ColorMap) -> Self {
        self.color_map = Some(map);
        self
    }
    /// Sets the values at the ends of the colour map and bar. Default: the range of the field. A
    /// diverging map is extended symmetrically about 0, so that equal colours mean equal
    /// magnitudes; its bar shows only the range of the field.
    pub fn range(mut self, min: f64, max: f64) -> Self {
        self.range = Some([min, max]);
        self
    }
    /// Sets the title above the colour bar (ASCII; other characters are left out).
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into());
        self
    }
    /// Draws isolines of the field. Fields per face have none.
    pub fn isolines(mut self, isolines: Isolines) -> Self {
        self.isolines = Some(isolines);
        self
    }
    /// Sets the sRGB colour of the surface for scenes without a field.
    pub fn surface_color(mut self, color: [u8; 3]) -> Self {
        self.surface_color = Some(color);
        self
    }
    /// Adds a polyline in space, hidden where the surface is in front of it. Repeat the first point
    /// to close it.
    pub fn curve(mut self, points: impl Into<Cow<'a, [[f64; 3]]>>, style: CurveStyle) -> Self {
        self.curves.push((points.into(), style));
        self
    }
    /// Adds points in space, hidden where the surface is in front of them.
    pub fn points(mut self, points: impl Into<Cow<'a, [[f64; 3]]>>, style: PointStyle) -> Self {
        self.points.push((points.into(), style));
        self
    }
    /// Adds curves and points on the surface of this scene's mesh.
    ///
    /// # Errors
    /// [`RenderError::Curve`] with the first node that refers to an element the mesh does not have.
    pub fn surface_curves(
        self,
        curves: &SurfaceCurves,
        style: &CurveStyle,
        point_style: PointStyle,
    ) -> Result<Self, RenderError> {
        let mesh = self.mesh;
        self.surface_curves_of(mesh, curves, style, point_style)
    }
    /// Adds curves and points given on another mesh of the same surface, such as the one from which
    /// this scene's mesh was cut.
    ///
    /// # Errors
    /// [`RenderError::Curve`] with the first node that refers to an element `mesh` does not have.
    pub fn surface_curves_of(
        mut self,
        mesh: &TriangleMesh,
        curves: &SurfaceCurves,
        style: &CurveStyle,
        point_style: PointStyle,
    ) -> Result<Self, RenderError> {
        for (c, curve) in curves.curves.iter().enumerate() {
            let mut line = Vec::with_capacity(curve.nodes.len());
            for (n, node) in curve.nodes.iter().enumerate() {
                line.push(node.locate(mesh).map_err(|e| e.at(c, n))?.position(mesh));
            }
            self.curves.push((line.into(), style.clone()));
        }
        let points = curves.located_points(mesh)?;
        if !points.is_empty() {
            let positions: Vec<[f64; 3]> = points.iter().map(|p| p.position(mesh)).collect();
            self.points.push((positions.into(), point_style));
        }
        Ok(self)
    }

    /// Checks lengths and values of everything in the scene.
    ///
    /// # Errors
    /// [`RenderError`] for the first field, curve, point, style or range that cannot be drawn.
    pub fn validate(&self) -> Result<(), RenderError> {
        let (vertices, faces) = (self.mesh.vertex_count(), self.mesh.face_count());
        match self.field {
            SceneField::None => {}
            SceneField::Vertex(v) => check_values(v, vertices, "values per vertex", "value of vertex")?,
            SceneField::Face(v) => check_values(v, faces, "values per face", "value of face")?,
            SceneField::Corner(v) => check_values(v, 3 * faces, "values per corner", "value of corner")?,
            SceneField::Quotient { numerator, denominator } => {
                check_values(numerator, 3 * faces, "numerators per corner", "numerator of corner")?;
                check_values(denominator, 3 * faces, "denominators per corner", "denominator of corner")?;
            }
            SceneField::Labels(labels) => check_length(labels.len(), faces, "labels per face")?,
        }
        if let Some([min, max]) = self.range
            && !(min < max && min.is_finite() && max.is_finite())
        {
            return Err(RenderError::Range { min, max });
        }
        let width = |name, w| in_range(name, w, |x| (0.0..=1000.0).contains(&x), "0 to 1000 pixels");
        if let Some(lines) = &self.isolines {
            width("isolines.width", lines.width)?;
            width("isolines.zero_width", lines.zero_width)?;
            in_range("isolines.opacity", lines.opacity, |x| (0.0..=1.0).contains(&x), "0 to 1")?;
            match &lines.levels {
                Levels::About(_) => {}
                Levels::Spacing(s) => {
                    in_range("isolines.levels", *s, |x| x > 0.0, "a spacing greater than 0")?
                }
                Levels::Values(values) => {
                    for &v in values {
                        in_range("isolines.levels", v, |_| true, "finite values")?;
                    }
                }
            }
        }
        for (c, (points, style)) in self.curves.iter().enumerate() {
            check_points(points, || format!("point of curve {c},"))?;
            width("curve width", style.width)?;
            width("curve rim", style.rim.map_or(0.0, |r| r.1))?;
            in_range("arrow_spacing", style.arrow_spacing.unwrap_or(1.0), |x| x >= 1.0, "at least 1 pixel")?;
        }
        for (points, style) in &self.points {
            check_points(points, || "isolated point".to_owned())?;
            width("point radius", style.radius)?;
        }
        Ok(())
    }
}

fn check_length(found: usize, expected: usize, what: &'static str) -> Result<(), RenderError> {
    if found == expected { Ok(()) } else { Err(RenderError::WrongLength { what, found, expected }) }
}

fn check_values(
    values: &[f64],
    expected: usize,
    what: &'static str,
    element: &'static str,
) -> Result<(), RenderError> {
    check_length(values.len(), expected, what)?;
    match values.iter().position(|v| v.is_infinite()) {
        Some(index) => Err(RenderError::NonFinite { what: element.to_owned(), index, value: values[index] }),
        None => Ok(()),
    }
}

fn check_points(points: &[[f64; 3]], what: impl Fn() -> String) -> Result<(), RenderError> {
    for (index, p) in points.iter().enumerate() {
        if let Some(&value) = p.iter().find(|x| !x.is_finite()) {
            return Err(RenderError::NonFinite { what: what(), index, value });
        }
    }
    Ok(())
}
