//! How a scene is drawn: plain data with good defaults.

use crate::error::RenderError;

/// How a scene is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Width of the picture in pixels, 1 to 16384.
    pub width: u32,
    /// Height of the picture in pixels, 1 to 16384.
    pub height: u32,
    /// Samples along each side of a pixel, 1 to 4. Memory is about 28 bytes a sample.
    pub supersampling: u32,
    /// From where the scene is seen.
    pub camera: Camera,
    /// What is behind it.
    pub background: Background,
    /// How faces are lit.
    pub lighting: Lighting,
    /// Strength of the ambient occlusion, from 0 (none) to 1.
    pub ambient_occlusion: f64,
    /// Strength of the soft shadow on a ground below the mesh, from 0 (none) to 1. Flat meshes seen
    /// from the front have none.
    pub ground_shadow: f64,
    /// Edges at which the faces' normals differ by more than this angle (radians) are drawn sharp:
    /// 0 shows every face flat, pi smooths everything.
    pub crease_angle: f64,
    /// A surface seen from its back is drawn a little darker and cooler. Faces wound against their
    /// neighbours have the front of these; a one-sided surface has none.
    pub tint_back_faces: bool,
    /// Draws the edges of the mesh.
    pub wireframe: Option<Wireframe>,
    /// Draws a colour bar with ticks at the right when the scene has a field.
    pub color_bar: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        RenderOptions {
            width: 1200,
            height: 900,
            supersampling: 2,
            camera: Camera::default(),
            background: Background::Solid([255, 255, 255]),
            lighting: Lighting::Studio,
            ambient_occlusion: 0.8,
            ground_shadow: 0.8,
            crease_angle: 50f64.to_radians(),
            tint_back_faces: true,
            wireframe: None,
            color_bar: true,
        }
    }
}

/// From where the scene is seen. Unless said otherwise the whole scene fits the picture with a
/// small margin.
///
/// Angles turn about the middle of the scene, starting in front of it: the front is the side of +z
/// when y or x is up, and that of -y when z is up. A flat mesh is seen from its front side,
/// head-on, and angles turn from there.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Which way is up.
    pub up: UpAxis,
    /// Turn to the right, in radians; 30 degrees without a value (0 for a flat mesh).
    pub azimuth: Option<f64>,
    /// Turn upwards, in radians; 20 degrees without a value, 38 for a mesh that lies flat, 0 for a
    /// flat one.
    pub elevation: Option<f64>,
    /// Turn of the camera about its line of sight, in radians; the picture turns clockwise.
    pub roll: f64,
    /// Magnification of the fitted picture; above 0.
    pub zoom: f64,
    /// The point in the middle of the picture, in the mesh's own coordinates; fitted without a
    /// value.
    pub target: Option<[f64; 3]>,
    /// Distance of the camera from its target, in the mesh's own unit; above 0; fitted without a
    /// value.
    pub distance: Option<f64>,
    /// With or without perspective.
    pub projection: Projection,
}

impl Default for Camera {
    fn default() -> Self {
        Camera {
            up: UpAxis::Auto,
            azimuth: None,
            elevation: None,
            roll: 0.0,
            zoom: 1.0,
            target: None,
            distance: None,
            projection: Projection::Perspective { field_of_view: 28f64.to_radians() },
        }
    }
}

/// Which way is up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// The y axis; for a mesh that is thin along z, the z axis.
    #[default]
    Auto,
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

/// How space is brought to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Near things are larger.
    Perspective {
        /// The vertical angle of view in radians, between 0 and pi.
        field_of_view: f64,
    },
    /// Parallel lines stay parallel.
    Orthographic,
}

/// What is behind the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// One sRGB colour.
    Solid([u8; 3]),
    /// Nothing: alpha 0. Shadows are drawn as black with some alpha.
    Transparent,
}

/// How faces are lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lighting {
    /// Soft ambient light from above, a key light from the upper left and a rim light from behind.
    #[default]
    Studio,
    /// Colours exactly as in the colour map; no shading, occlusion or shadow.
    Unlit,
}

/// How the edges of the mesh are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wireframe {
    /// Width in pixels.
    pub width: f64,
    /// sRGB colour.
    pub color: [u8; 3],
    /// From 0 to 1.
    pub opacity: f64,
}

impl Default for Wireframe {
    fn default() -> Self {
        Wireframe { width: 0.8, color: [20, 22, 28], opacity: 0.45 }
    }
}

const MAX_SIDE: u32 = 16384;
const MAX_SAMPLES: u64 = 150_000_000;

pub(crate) fn in_range(
    name: &'static str,
    value: f64,
    fine: impl Fn(f64) -> bool,
    bound: &'static str,
) -> Result<(), RenderError> {
    if value.is_finite() && fine(value) { Ok(()) } else { Err(RenderError::Option { name, value, bound }) }
}

impl RenderOptions {
    /// Checks every option.
    ///
    /// # Errors
    /// The first option that is out of its range, with the range.
    pub fn validate(&self) -> Result<(), RenderError> {
        let (width, height) = (self.width, self.height);
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(RenderError::ImageSize { width, height });
        }
        in_range("supersampling", self.supersampling as f64, |s| (1.0..=4.0).contains(&s), "1 to 4")?;
        let samples = u64::from(width) * u64::from(height) * u64::from(self.supersampling).pow(2);
        if samples > MAX_SAMPLES {
            return Err(RenderError::TooManySamples { samples, limit: MAX_SAMPLES });
        }
        let share = |x: f64| (0.0..=1.0).contains(&x);
        in_range("ambient_occlusion", self.ambient_occlusion, share, "0 to 1")?;
        in_range("ground_shadow", self.ground_shadow, share, "0 to 1")?;
        in_range("crease_angle", self.crease_angle, |x| x >= 0.0, "an angle in radians, not negative")?;
        if let Some(w) = self.wireframe {
            in_range("wireframe.width", w.width, |x| (0.0..=100.0).contains(&x), "0 to 100 pixels")?;
            in_range("wireframe.opacity", w.opacity, share, "0 to 1")?;
        }
        let c = &self.camera;
        for (name, angle) in [("azimuth", c.azimuth), ("elevation", c.elevation), ("roll", Some(c.roll))] {
            in_range(name, angle.unwrap_or(0.0), |_| true, "a finite angle in radians")?;
        }
        in_range("zoom", c.zoom, |x| (1e-6..=1e6).contains(&x), "1e-6 to 1e6")?;
        in_range("distance", c.distance.unwrap_or(1.0), |x| x > 0.0, "above 0")?;
        for x in c.target.unwrap_or_default() {
            in_range("target", x, |_| true, "finite coordinates")?;
        }
        if let Projection::Perspective { field_of_view } = c.projection {
            in_range("field_of_view", field_of_view, |x| (1e-3..=3.1).contains(&x), "0.001 to 3.1 radians")?;
        }
        Ok(())
    }
}
