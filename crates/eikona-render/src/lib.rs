//! Pictures of triangle meshes with a scalar field, isolines, curves and points, drawn to PNG
//! without GPU or display.
//!
//! A [`Scene`] says what is drawn, [`RenderOptions`] how, [`render`] gives an [`Image`]. The same
//! input gives the same bytes on any number of threads.
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
//! How a picture comes about: the camera is fitted ([`Camera`]), faces are rasterised into a buffer
//! of nearest faces at a multiple of the picture's resolution, each sample is coloured and lit,
//! curves and points are drawn over it with a depth test, samples are filtered to pixels, and the
//! colour bar is drawn last.

mod camera;
mod color;
mod coloring;
mod crumbs;
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
mod stroke;
mod vector;

pub use color::{ColorMap, label_color};
pub use error::RenderError;
pub use image::Image;
pub use options::{Background, Camera, Lighting, Projection, RenderOptions, UpAxis, Wireframe};
pub use render::render;
pub use scene::{CurveStyle, Isolines, Levels, PointStyle, Scene};
