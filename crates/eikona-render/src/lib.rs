//! Software renderer for triangle meshes; writes PNG and needs no GPU or display.
//!
//! A [`Scene`] describes what is drawn, [`RenderOptions`] how, and [`render`] returns an [`Image`].
//! The same input gives the same bytes on any number of threads.
//!
//! ```
//! use eikona_mesh::TriangleMesh;
//! use eikona_render::{
//!     Coloring, Drawing, Isolines, RenderOptions, ScalarField, Scene, Values, render,
//! };
//! let mesh = TriangleMesh::new(
//!     vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
//!     vec![[0, 1, 2], [0, 2, 3]],
//! )?;
//! let field = ScalarField::new(Values::PerVertex(&[-1.0, 1.0, 1.0, -1.0]));
//! let isolines = Drawing::Isolines(Isolines::default());
//! let scene = Scene::new(&mesh, Coloring::Field(field)).with(isolines);
//! let image = render(&scene, &RenderOptions { width: 160, height: 120, ..Default::default() })?;
//! assert_eq!((image.width, image.height, image.rgba.len()), (160, 120, 160 * 120 * 4));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The scope is frozen at eight kinds of things:
//!
//! | what | where |
//! |---|---|
//! | surfaces | [`Scene::mesh`], [`Coloring::Plain`] |
//! | scalar fields | [`Coloring::Field`] |
//! | labels | [`Coloring::Labels`] |
//! | isolines | [`Drawing::Isolines`] |
//! | curves | [`Drawing::Curve`] |
//! | glyphs | [`Drawing::Glyphs`] |
//! | streamlines | [`Drawing::Curve`], one per streamline |
//! | points | [`Drawing::Points`] |
//! | texts at points | [`Drawing::Texts`] |
//!
//! Stages: fit the camera ([`Camera`]); rasterise faces into a visibility buffer at a multiple of
//! the image resolution; colour and shade each sample; draw curves, glyphs and points with a depth
//! test; filter samples to pixels; draw the colour bar.

mod albedo;
mod camera;
mod canvas;
mod color;
mod drawing;
mod error;
mod font;
mod image;
mod isolines;
mod legend;
mod normals;
mod occlusion;
mod options;
mod raster;
mod render;
mod scene;
mod shade;
mod shadow;
mod short_isolines;

pub use color::{ColorMap, label_color};
pub use drawing::{CurveStyle, Drawing, GlyphStyle, Isolines, Levels, Outline, PointStyle, TextStyle};
pub use error::RenderError;
pub use image::Image;
pub use options::{Background, Camera, Lighting, Projection, RenderOptions, UpAxis, Wireframe};
pub use render::render;
pub use scene::{Coloring, ScalarField, Scene, Values};
