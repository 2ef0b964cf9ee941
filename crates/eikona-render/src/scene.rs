//! Scene: a surface with its colouring, and what is drawn over it.

use crate::color::{CLAY, ColorMap};
use crate::drawing::Drawing;
use crate::error::RenderError;
use eikona_mesh::TriangleMesh;

/// Surface with its colouring, and what is drawn over it.
///
/// ```
/// use eikona_mesh::TriangleMesh;
/// use eikona_render::{Coloring, CurveStyle, Drawing, PointStyle, Scene};
/// let mesh = TriangleMesh::new(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], vec![[0, 1, 2]])?;
/// let (corner, edge) = mesh.positions().split_at(1);
/// let corner = Drawing::Points { positions: corner.into(), style: PointStyle::default() };
/// let edge = Drawing::Curve { points: edge.into(), style: CurveStyle::default() };
/// let scene = Scene::new(&mesh, Coloring::default()).with(edge).with(corner);
/// assert_eq!(scene.drawings.len(), 2);
/// assert!(scene.validate().is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The surface.
    pub mesh: &'a TriangleMesh,
    /// Colouring of the surface.
    pub coloring: Coloring<'a>,
    /// What is drawn over the surface, from bottom to top.
    pub drawings: Vec<Drawing<'a>>,
}

impl<'a> Scene<'a> {
    /// Creates a scene of a surface with nothing drawn over it.
    pub fn new(mesh: &'a TriangleMesh, coloring: Coloring<'a>) -> Self {
        Scene { mesh, coloring, drawings: Vec::new() }
    }

    /// Adds a drawing on top of the others.
    pub fn with(mut self, drawing: Drawing<'a>) -> Self {
        self.drawings.push(drawing);
        self
    }

    /// Checks lengths and values of everything in the scene.
    ///
    /// # Errors
    /// [`RenderError`] for the first field, range, drawing or style that cannot be drawn.
    pub fn validate(&self) -> Result<(), RenderError> {
        let (vertices, faces) = (self.mesh.vertex_count(), self.mesh.face_count());
        match &self.coloring {
            Coloring::Plain(_) => {}
            Coloring::Field(field) => field.validate(vertices, faces)?,
            Coloring::Labels { labels, .. } => check_length(labels.len(), faces, "labels per face")?,
        }
        for (index, drawing) in self.drawings.iter().enumerate() {
            drawing.validate(index)?;
            if matches!(drawing, Drawing::Isolines(_)) && !self.coloring.has_isolines() {
                return Err(RenderError::NoIsolines);
            }
        }
        Ok(())
    }
}

/// Colouring of a surface.
///
/// ```
/// use eikona_render::Coloring;
/// assert_eq!(Coloring::default(), Coloring::Plain([214, 208, 199]));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Coloring<'a> {
    /// One sRGB colour; by default light clay.
    Plain([u8; 3]),
    /// A scalar field.
    Field(ScalarField<'a>),
    /// One integer per face, in categorical colours: see [`label_color`](crate::label_color).
    Labels {
        /// The labels.
        labels: &'a [i64],
        /// Title above the legend, as in [`ScalarField::title`].
        title: Option<&'a str>,
    },
}

impl Default for Coloring<'_> {
    fn default() -> Self {
        Coloring::Plain(CLAY)
    }
}

impl Coloring<'_> {
    fn has_isolines(&self) -> bool {
        matches!(self, Coloring::Field(field) if !matches!(field.values, Values::PerFace(_)))
    }
}

/// Scalar field on a surface, shown by a colour map. A face with a NaN at a corner is hatched.
///
/// ```
/// use eikona_render::{ColorMap, ScalarField, Values};
/// let values = Values::PerVertex(&[0.0, 1.0, 2.0]);
/// let field = ScalarField { title: Some("height"), ..ScalarField::new(values) };
/// assert_eq!((field.color_map, field.range), (None, None));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ScalarField<'a> {
    /// The values.
    pub values: Values<'a>,
    /// Colour map. By default [`ColorMap::signed`] if values of both signs occur, else
    /// [`ColorMap::viridis`].
    pub color_map: Option<ColorMap>,
    /// Values at the ends of the colour map and bar, the smaller first. By default the range of the
    /// field. A diverging map is then extended symmetrically about 0, so that equal colours mean
    /// equal magnitudes; its bar shows only the range of the field.
    pub range: Option<[f64; 2]>,
    /// Title above the colour bar (ASCII; other characters are left out).
    pub title: Option<&'a str>,
}

impl<'a> ScalarField<'a> {
    /// Creates a field with the default colour map and range, without a title.
    pub fn new(values: Values<'a>) -> Self {
        ScalarField { values, color_map: None, range: None, title: None }
    }

    fn validate(&self, vertices: usize, faces: usize) -> Result<(), RenderError> {
        match self.values {
            Values::PerVertex(v) => check_values(v, vertices, "values per vertex", "value of vertex")?,
            Values::PerFace(v) => check_values(v, faces, "values per face", "value of face")?,
            Values::PerCorner(v) => check_values(v, 3 * faces, "values per corner", "value of corner")?,
            Values::Quotient { numerator, denominator } => {
                check_values(numerator, 3 * faces, "numerators per corner", "numerator of corner")?;
                check_values(denominator, 3 * faces, "denominators per corner", "denominator of corner")?;
            }
        }
        match self.range {
            Some([min, max]) if !(min < max && min.is_finite() && max.is_finite()) => {
                Err(RenderError::Range { min, max })
            }
            _ => Ok(()),
        }
    }
}

/// Values of a scalar field. NaN means "no value".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values<'a> {
    /// One value per vertex, linear in each face.
    PerVertex(&'a [f64]),
    /// One value per face. Such a field has no isolines.
    PerFace(&'a [f64]),
    /// One value per corner (corner `k` of face `f` is `3 f + k`), linear in each face; jumps
    /// across edges stay sharp.
    PerCorner(&'a [f64]),
    /// A quotient of two fields per corner, both linear in each face and divided per sample.
    Quotient {
        /// One numerator per corner.
        numerator: &'a [f64],
        /// One denominator per corner.
        denominator: &'a [f64],
    },
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
