//! What can be drawn over a surface, and its styles.

use crate::error::RenderError;
use crate::options::in_range;
use eikona_mesh::{SurfaceCurves, TriangleMesh};
use std::borrow::Cow;

/// What can be drawn over a surface. All but isolines lie in space, and are hidden where the
/// surface is in front of them. Widths and radii are in pixels, 0 to 200.
#[derive(Clone, Debug, PartialEq)]
pub enum Drawing<'a> {
    /// Isolines of the scalar field that colours the surface. They are part of the surface and lie
    /// below all other drawings.
    Isolines(Isolines),
    /// A polyline in space, such as a curve on the surface or a streamline.
    Curve {
        /// Its nodes. Repeat the first one to close it.
        points: Cow<'a, [[f64; 3]]>,
        /// Its style.
        style: CurveStyle,
    },
    /// Short straight arrows or marks, such as the vectors of a direction field. A glyph whose
    /// middle is hidden is left out; ends slightly below a concave surface are drawn.
    Glyphs {
        /// Tail and tip of each glyph.
        ends: Cow<'a, [[[f64; 3]; 2]]>,
        /// Their style.
        style: GlyphStyle,
    },
    /// Points in space, as small shaded balls; the nearest is on top.
    Points {
        /// Their positions.
        positions: Cow<'a, [[f64; 3]]>,
        /// Their style.
        style: PointStyle,
    },
    /// Short texts beside points that are not hidden, such as the index of a singularity. Letters,
    /// digits and signs are those of ASCII; others are left out.
    Texts {
        /// The points.
        positions: Cow<'a, [[f64; 3]]>,
        /// A text per point.
        texts: Cow<'a, [String]>,
        /// Their style.
        style: TextStyle,
    },
}

impl Drawing<'_> {
    /// Returns drawings of curves and points on a surface. Their nodes refer to `mesh`, which may
    /// be another mesh than that of the scene, such as the one from which it was cut.
    ///
    /// ```
    /// use eikona_mesh::{Curve, SurfaceCurves, TriangleMesh, Vertex};
    /// use eikona_render::{CurveStyle, Drawing, PointStyle};
    /// let corners = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    /// let mesh = TriangleMesh::new(corners, vec![[0, 1, 2]])?;
    /// let edge = SurfaceCurves::from_curve(Curve::signed([1, 2].map(Vertex)));
    /// let style = CurveStyle::default();
    /// let drawings = Drawing::surface_curves(&mesh, &edge, &style, PointStyle::default())?;
    /// assert_eq!(drawings, [Drawing::Curve { points: mesh.positions()[1..].into(), style }]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`RenderError::Curve`] with the first node that refers to an element `mesh` does not have.
    pub fn surface_curves(
        mesh: &TriangleMesh,
        curves: &SurfaceCurves,
        style: &CurveStyle,
        point_style: PointStyle,
    ) -> Result<Vec<Drawing<'static>>, RenderError> {
        let mut drawings = Vec::with_capacity(curves.curves.len() + 1);
        for (c, curve) in curves.curves.iter().enumerate() {
            let mut points = Vec::with_capacity(curve.nodes.len());
            for (n, node) in curve.nodes.iter().enumerate() {
                points.push(node.locate(mesh).map_err(|e| e.at(c, n))?.position(mesh));
            }
            drawings.push(Drawing::Curve { points: points.into(), style: style.clone() });
        }
        let points = curves.located_points(mesh)?;
        if !points.is_empty() {
            let positions = points.iter().map(|p| p.position(mesh)).collect();
            drawings.push(Drawing::Points { positions, style: point_style });
        }
        Ok(drawings)
    }

    /// Returns all positions in space.
    pub(crate) fn positions(&self) -> &[[f64; 3]] {
        match self {
            Drawing::Isolines(_) => &[],
            Drawing::Curve { points, .. } => points,
            Drawing::Glyphs { ends, .. } => ends.as_flattened(),
            Drawing::Points { positions, .. } | Drawing::Texts { positions, .. } => positions,
        }
    }

    /// Checks positions and style of the drawing with this index in its scene.
    pub(crate) fn validate(&self, index: usize) -> Result<(), RenderError> {
        for (p, position) in self.positions().iter().enumerate() {
            if let Some(&value) = position.iter().find(|x| !x.is_finite()) {
                let (what, index) = match self {
                    Drawing::Glyphs { .. } => (format!("an end of drawing {index}, glyph"), p / 2),
                    _ => (format!("a coordinate of drawing {index}, point"), p),
                };
                return Err(RenderError::NonFinite { what, index, value });
            }
        }
        // The cost of a stroke is its number of segments times the square of its width.
        let pixels = |name, w| in_range(name, w, |x| (0.0..=200.0).contains(&x), "0 to 200 pixels");
        let outline_width =
            |outline: &Option<Outline>| pixels("outline.width", outline.map_or(0.0, |o| o.width));
        match self {
            Drawing::Isolines(isolines) => {
                pixels("isolines.width", isolines.width)?;
                pixels("isolines.zero_width", isolines.zero_width)?;
                in_range("isolines.opacity", isolines.opacity, |x| (0.0..=1.0).contains(&x), "0 to 1")?;
                isolines.levels.validate()
            }
            Drawing::Curve { style, .. } => {
                pixels("curve width", style.width)?;
                outline_width(&style.outline)?;
                in_range(
                    "arrow_spacing",
                    style.arrow_spacing.unwrap_or(1.0),
                    |x| x >= 1.0,
                    "at least 1 pixel",
                )
            }
            Drawing::Glyphs { style, .. } => {
                pixels("glyph width", style.width)?;
                outline_width(&style.outline)
            }
            Drawing::Points { style, .. } => pixels("point radius", style.radius),
            Drawing::Texts { style, .. } => {
                pixels("text size", style.size)?;
                pixels("text offset", style.offset)
            }
        }
    }
}

/// Levels and style of isolines. Zero isolines of a field per vertex that are shorter than an edge
/// are left out.
///
/// ```
/// use eikona_render::{Isolines, Levels};
/// assert_eq!(Isolines::default().levels, Levels::About(18));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Isolines {
    /// Values of the isolines.
    pub levels: Levels,
    /// Width.
    pub width: f64,
    /// Width of the zero isoline.
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

impl Levels {
    fn validate(&self) -> Result<(), RenderError> {
        match self {
            Levels::About(_) => Ok(()),
            Levels::Spacing(s) => in_range("isolines.levels", *s, |x| x > 0.0, "a spacing greater than 0"),
            Levels::Values(values) => {
                values.iter().try_for_each(|v| in_range("isolines.levels", *v, |_| true, "finite values"))
            }
        }
    }
}

/// Style of a curve.
///
/// ```
/// use eikona_render::{CurveStyle, Outline};
/// let white = Outline { color: [255; 3], width: 1.5 };
/// let style = CurveStyle { outline: Some(white), ..CurveStyle::default() };
/// assert_eq!((style.width, style.arrow_spacing), (4.0, None));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CurveStyle {
    /// sRGB colour.
    pub color: [u8; 3],
    /// Width.
    pub width: f64,
    /// Outline.
    pub outline: Option<Outline>,
    /// Spacing of arrowheads in the direction of the curve, at least their length; each curve has
    /// at least one unless its position is hidden.
    pub arrow_spacing: Option<f64>,
}

impl Default for CurveStyle {
    fn default() -> Self {
        CurveStyle { color: [24, 26, 32], width: 4.0, outline: None, arrow_spacing: None }
    }
}

/// Outline of a stroke, which sets it off from the background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// sRGB colour.
    pub color: [u8; 3],
    /// Width on each side of the stroke.
    pub width: f64,
}

/// Style of glyphs.
///
/// ```
/// use eikona_render::GlyphStyle;
/// let marks = GlyphStyle { head: false, ..GlyphStyle::default() };
/// assert_eq!((marks.width, marks.outline), (2.0, None));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlyphStyle {
    /// sRGB colour.
    pub color: [u8; 3],
    /// Width of the stroke. Arrows too short for their head are drawn thinner.
    pub width: f64,
    /// Outline.
    pub outline: Option<Outline>,
    /// Draws an arrowhead at the tip.
    pub head: bool,
}

impl Default for GlyphStyle {
    fn default() -> Self {
        GlyphStyle { color: [24, 26, 32], width: 2.0, outline: None, head: true }
    }
}

/// Style of points.
///
/// ```
/// use eikona_render::PointStyle;
/// assert_eq!(PointStyle::default(), PointStyle { color: [196, 46, 46], radius: 6.0 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointStyle {
    /// sRGB colour.
    pub color: [u8; 3],
    /// Radius.
    pub radius: f64,
}

impl Default for PointStyle {
    fn default() -> Self {
        PointStyle { color: [196, 46, 46], radius: 6.0 }
    }
}

/// Style of texts beside points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextStyle {
    /// sRGB colour.
    pub color: [u8; 3],
    /// sRGB colour of the halo, which sets the text off from the background.
    pub halo: [u8; 3],
    /// Height of a capital letter.
    pub size: f64,
    /// Distance from the point, to the right and upwards.
    pub offset: f64,
}

impl Default for TextStyle {
    fn default() -> Self {
        TextStyle { color: [24, 26, 32], halo: [255, 255, 255], size: 12.0, offset: 8.0 }
    }
}
