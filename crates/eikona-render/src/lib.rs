//! Software renderer for triangle meshes with a scalar field, isolines, curves and points; writes
//! PNG and needs no GPU or display.
//!
//! A [`Scene`] describes what is drawn, [`RenderOptions`] how, and [`render`] returns an [`Image`].
//! The same input gives the same bytes on any number of threads.
//!
//! ```
//! use eikona_mesh::TriangleMesh;
//! use eikona_render::{Isolines, RenderOptions, Scene, render};
//! let mesh = TriangleMesh::new(
//!     vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
//!     vec![[0, 1, 2], [0, 2, 3]],
//! )?;
//! let values = [-1.0, 1.0, 1.0, -1.0];
//! let scene = Scene::new(&mesh).vertex_scalar(&values).isolines(Isolines::default());
//! let image = render(&scene, &RenderOptions { width: 160, height: 120, ..Default::default() })?;
//! assert_eq!((image.width, image.height, image.rgba.len()), (160, 120, 160 * 120 * 4));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Stages: fit the camera ([`Camera`]); rasterise faces into a visibility buffer at a multiple of
//! the image resolution; colour and shade each sample; draw curves and points with a depth test;
//! filter samples to pixels; draw the colour bar.

mod camera;
mod color;
mod coloring;
mod error;
mod font;
mod image;
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
mod stroke;

pub use color::{ColorMap, label_color};
pub use error::RenderError;
pub use image::Image;
pub use options::{Background, Camera, Lighting, Projection, RenderOptions, UpAxis, Wireframe};
pub use render::render;
pub use scene::{CurveStyle, Isolines, Levels, PointStyle, Scene};
