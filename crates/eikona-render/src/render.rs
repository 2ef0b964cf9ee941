//! Rendering pipeline.

use crate::albedo::Albedo;
use crate::camera::{Normalization, Projected, View};
use crate::canvas::Canvas;
use crate::color::linear_to_srgb;
use crate::error::RenderError;
use crate::image::Image;
use crate::legend::Legend;
use crate::normals::{corner_normals, face_normals, front_sides};
use crate::occlusion::Occlusion;
use crate::options::{Lighting, RenderOptions};
use crate::raster::Visibility;
use crate::scene::Scene;
use crate::shade::{Surface, shade};
use crate::shadow::GroundShadow;
use eikona_mesh::vector::Vec3;
use rayon::prelude::*;

/// Renders a scene.
///
/// The same input gives the same bytes for any number of threads (rayon's global pool). Coordinates
/// are normalised first, so meshes may have any size and position. A mesh without faces gives the
/// background.
///
/// ```
/// use eikona_mesh::TriangleMesh;
/// use eikona_render::{Coloring, Lighting, RenderOptions, Scene, render};
/// let mesh = TriangleMesh::new(vec![[0., 0., 0.], [1., 0., 0.], [0.5, 1., 0.]], vec![[0, 1, 2]])?;
/// let scene = Scene::new(&mesh, Coloring::Plain([200, 100, 50]));
/// let unlit = RenderOptions { lighting: Lighting::Unlit, ..Default::default() };
/// let options = RenderOptions { width: 64, height: 64, ..unlit };
/// let image = render(&scene, &options)?;
/// assert_eq!(image.pixel(32, 40), Some([200, 100, 50, 255]));
/// assert_eq!(image.pixel(0, 0), Some([255, 255, 255, 255]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`RenderOptions::validate`] and [`Scene::validate`].
///
/// # Cost
/// O(V + F + samples), and O(segments x width^2) per drawing. A million faces at 1600 x 1200 with 2
/// x 2 samples take a few seconds and about 0.5 GB.
pub fn render(scene: &Scene, options: &RenderOptions) -> Result<Image, RenderError> {
    options.validate()?;
    scene.validate()?;
    let samples = options.supersampling as usize;
    let albedo = Albedo::new(scene);
    let legend = Legend::new(&scene.coloring, &albedo, options);

    let normalization = Normalization::of(scene);
    let normalized = |points: &[Vec3]| points.iter().map(|&p| normalization.apply(p)).collect::<Vec<_>>();
    let positions = normalized(scene.mesh.positions());
    let triangles = scene.mesh.triangles();
    let mut fitted = used_positions(&positions, triangles);
    fitted.extend(scene.drawings.iter().flat_map(|drawing| normalized(drawing.positions())));
    let free_width = legend.as_ref().map_or(options.width as f64, Legend::free_width);
    let view = View::fit(&fitted, triangles, &positions, &normalization, options, free_width);

    let projected: Vec<Projected> = positions.iter().map(|&p| view.project(p)).collect();
    let mut visibility = Visibility::new(options.width as usize * samples, options.height as usize * samples);
    visibility.draw(&projected, triangles, view.perspective);

    let face_normals = face_normals(scene.mesh, &positions);
    let corner_normals = corner_normals(scene.mesh, &positions, &face_normals, options.crease_angle);
    let lit = options.lighting == Lighting::Studio;
    let front_sides = if lit && options.tint_back_faces { front_sides(scene.mesh) } else { Vec::new() };
    let surface = Surface {
        view: &view,
        triangles,
        positions: &positions,
        projected: &projected,
        face_normals: &face_normals,
        corner_normals: &corner_normals,
        front_sides: &front_sides,
        visibility: &visibility,
    };
    let occlusion = (lit && options.ambient_occlusion > 0.0).then(|| Occlusion::compute(&surface, samples));
    let shadow =
        if lit { GroundShadow::new(&view, &positions, triangles, options.ground_shadow) } else { None };
    let mut colors = shade(&surface, &albedo, occlusion.as_ref(), shadow.as_ref(), options);

    let mut canvas = Canvas::new(&normalization, &view, &visibility, &mut colors, options);
    for drawing in &scene.drawings {
        canvas.draw(drawing);
    }
    let mut image = resolve(&colors, options);
    if let Some(legend) = legend {
        legend.draw(&mut image);
    }
    Ok(image)
}

/// Returns the positions of all corners of faces.
fn used_positions(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut used = vec![false; positions.len()];
    for &v in triangles.iter().flatten() {
        used[v as usize] = true;
    }
    positions.iter().zip(&used).filter(|(_, used)| **used).map(|(p, _)| *p).collect()
}

/// Half width of the tent filter, in pixels.
const FILTER_RADIUS: f64 = 0.8;

/// Filters samples to pixels in linear light.
fn resolve(colors: &[[f32; 4]], options: &RenderOptions) -> Image {
    let samples = options.supersampling as usize;
    let (width, height) = (options.width as usize, options.height as usize);
    // Weights of the samples around a pixel, by their distance from its centre along one axis.
    let reach = samples as i64; // one pixel more on each side
    let weights: Vec<(i64, f32)> = (-reach..2 * reach)
        .map(|i| (i, FILTER_RADIUS - ((i as f64 + 0.5) / samples as f64 - 0.5).abs()))
        .filter(|w| w.1 > 0.0)
        .map(|(i, w)| (i, w as f32))
        .collect();
    let mut rgba = vec![0u8; 4 * width * height];
    rgba.par_chunks_mut(4 * width).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
            let mut sum = [0.0f32; 4];
            let mut total = 0.0;
            for &(j, wy) in &weights {
                let sy = (y * samples) as i64 + j;
                if sy < 0 || sy >= (height * samples) as i64 {
                    continue;
                }
                for &(i, wx) in &weights {
                    let sx = (x * samples) as i64 + i;
                    if sx < 0 || sx >= (width * samples) as i64 {
                        continue;
                    }
                    let c = &colors[sy as usize * width * samples + sx as usize];
                    let w = wx * wy;
                    total += w;
                    for k in 0..4 {
                        sum[k] += w * c[k];
                    }
                }
            }
            let alpha = sum[3] / total;
            for k in 0..3 {
                pixel[k] = if sum[3] > 0.0 { linear_to_srgb(sum[k] / sum[3]) } else { 0 };
            }
            pixel[3] = (255.0 * alpha).round().clamp(0.0, 255.0) as u8;
        }
    });
    Image { width: options.width, height: options.height, rgba }
}
