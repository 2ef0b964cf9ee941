//! Rendering options.

use crate::error::RenderError;

/// Rendering options of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Image width in pixels, 1 to 16384.
    pub width: u32,
    /// Image height in pixels, 1 to 16384.
    pub height: u32,
    /// Samples along each side of a pixel, 1 to 4. Memory is about 28 bytes per sample.
    pub supersampling: u32,
    /// Camera position and projection.
    pub camera: Camera,
    /// Background colour or transparency.
    pub background: Background,
    /// Lighting of faces.
    pub lighting: Lighting,
    /// Strength of the ambient occlusion, from 0 (none) to 1.
    pub ambient_occlusion: f64,
    /// Strength of the soft shadow on a ground below the mesh, from 0 (none) to 1. Flat meshes have
    /// no ground, and no shadow is drawn unless the camera looks down on the ground.
    pub ground_shadow: f64,
    /// Crease angle in radians: edges whose face normals differ by more than this are drawn sharp.
    /// 0 gives flat shading, pi smooths everything.
    pub crease_angle: f64,
    /// Draws back faces slightly darker and cooler. Neighbouring faces with opposite orientation
    /// share one front side; nonorientable surfaces have none.
    pub tint_back_faces: bool,
    /// Draws the edges of the mesh.
    pub wireframe: Option<Wireframe>,
    /// Draws a colour bar with ticks, or a legend of labels, at the right if the scene has a field
    /// and there is space.
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

/// Camera. By default the whole scene fits the image with a small margin.
///
/// Angles rotate the camera about the centre of the scene, starting in front of it: the front is
/// the side of +z if x or y is up, and that of -y if z is up. A flat mesh is viewed head-on from
/// its front side, and angles start there.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Up axis of the scene.
    pub up: UpAxis,
    /// Rotation to the right in radians; by default 30 degrees (0 for a flat mesh).
    pub azimuth: Option<f64>,
    /// Rotation upwards in radians; by default 20 degrees, 38 for a mesh that lies flat (thin along
    /// the up axis), 0 for a planar mesh.
    pub elevation: Option<f64>,
    /// Rotation about the line of sight in radians; the image turns clockwise.
    pub roll: f64,
    /// Magnification of the fitted view, 1e-6 to 1e6.
    pub zoom: f64,
    /// Point at the centre of the image, in mesh coordinates; fitted by default.
    pub target: Option<[f64; 3]>,
    /// Distance of the camera from its target, in mesh units; greater than 0; fitted by default.
    pub distance: Option<f64>,
    /// Perspective or orthographic projection.
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

/// Up axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// The y axis, or the z axis for a mesh that is thin along z.
    #[default]
    Auto,
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

/// Projection from space to the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective projection.
    Perspective {
        /// Vertical angle of view in radians, from 0.001 to 3.1.
        field_of_view: f64,
    },
    /// Orthographic projection.
    Orthographic,
}

/// Background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// One sRGB colour.
    Solid([u8; 3]),
    /// Transparent (alpha 0). Shadows are black with partial alpha.
    Transparent,
}

/// Lighting of faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lighting {
    /// Soft ambient light from above, a key light from the upper left and a rim light from behind.
    #[default]
    Studio,
    /// Colours exactly as in the colour map, without shading, occlusion or shadow.
    Unlit,
}

/// Style of mesh edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wireframe {
    /// Width in pixels.
    pub width: f64,
    /// sRGB colour.
    pub color: [u8; 3],
    /// Opacity from 0 to 1.
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
    /// ```
    /// use eikona_render::RenderOptions;
    /// assert!(RenderOptions::default().validate().is_ok());
    /// let none = RenderOptions { width: 0, ..RenderOptions::default() };
    /// assert!(none.validate().unwrap_err().to_string().contains("1 to 16384"));
    /// ```
    ///
    /// # Errors
    /// [`RenderError`] for the first option out of range, with the allowed range.
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
        in_range("crease_angle", self.crease_angle, |x| x >= 0.0, "an angle in radians, at least 0")?;
        if let Some(w) = self.wireframe {
            in_range("wireframe.width", w.width, |x| (0.0..=100.0).contains(&x), "0 to 100 pixels")?;
            in_range("wireframe.opacity", w.opacity, share, "0 to 1")?;
        }
        let c = &self.camera;
        for (name, angle) in [("azimuth", c.azimuth), ("elevation", c.elevation), ("roll", Some(c.roll))] {
            in_range(name, angle.unwrap_or(0.0), |_| true, "a finite angle in radians")?;
        }
        in_range("zoom", c.zoom, |x| (1e-6..=1e6).contains(&x), "1e-6 to 1e6")?;
        in_range("distance", c.distance.unwrap_or(1.0), |x| x > 0.0, "greater than 0")?;
        for x in c.target.unwrap_or_default() {
            in_range("target", x, |_| true, "finite coordinates")?;
        }
        if let Projection::Perspective { field_of_view } = c.projection {
            in_range("field_of_view", field_of_view, |x| (1e-3..=3.1).contains(&x), "0.001 to 3.1 radians")?;
        }
        Ok(())
    }
}
