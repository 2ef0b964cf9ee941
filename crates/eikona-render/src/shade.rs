//! Colours and lights every sample of the visibility buffer.

use crate::albedo::Albedo;
use crate::camera::{Projected, View};
use crate::color::{Linear, MISSING, mix, to_linear};
use crate::occlusion::Occlusion;
use crate::options::{Background, Lighting, RenderOptions};
use crate::raster::{FacePoint, NONE, Visibility};
use crate::shadow::GroundShadow;
use eikona_mesh::vector::{Vec3, add, cross, dot, scale, sub, unit};
use rayon::prelude::*;

/// Mesh with everything needed to shade it.
pub(crate) struct Surface<'a> {
    pub(crate) view: &'a View,
    pub(crate) triangles: &'a [[u32; 3]],
    pub(crate) positions: &'a [Vec3],
    pub(crate) projected: &'a [Projected],
    pub(crate) face_normals: &'a [Vec3],
    pub(crate) corner_normals: &'a [[f32; 3]],
    /// Front side of each face: see [`crate::normals::front_sides`]. Empty if not needed.
    pub(crate) front_sides: &'a [i8],
    pub(crate) visibility: &'a Visibility,
}

/// Surface point at a sample.
pub(crate) struct Hit {
    pub(crate) face: usize,
    pub(crate) point: Option<FacePoint>,
    pub(crate) depth: f64,
    /// Shading normal in the camera's frame (right, up, towards the camera), facing the camera.
    pub(crate) normal: Vec3,
    /// Whether the surface is seen from its back; never on nonorientable surfaces.
    pub(crate) back: bool,
}

impl Surface<'_> {
    /// Returns the nearest surface point at a sample.
    pub(crate) fn hit(&self, x: usize, y: usize) -> Option<Hit> {
        let sample = y * self.visibility.width + x;
        let face = self.visibility.face[sample];
        if face == NONE {
            return None;
        }
        let face = face as usize;
        let vertices = self.triangles[face].map(|v| v as usize);
        let point = FacePoint::at(vertices.map(|v| self.projected[v].h), x as f64 + 0.5, y as f64 + 0.5);
        let weights = point.map_or([1.0 / 3.0; 3], |p| p.weights);
        let mut position = [0.0; 3];
        let mut normal = [0.0; 3];
        for k in 0..3 {
            position = add(position, scale(self.positions[vertices[k]], weights[k]));
            normal = add(normal, scale(self.corner_normals[3 * face + k].map(f64::from), weights[k]));
        }
        let toward = self.view.toward_camera(position);
        // The corner normals of a face agree in sign. Flipping them all towards the camera makes
        // shading independent of orientation, without seams.
        let away = dot(self.face_normals[face], toward) < 0.0;
        normal = unit(if away { scale(normal, -1.0) } else { normal });
        let back = self.front_sides.get(face).is_some_and(|&side| side == if away { 1 } else { -1 });
        if normal == [0.0; 3] {
            normal = toward;
        }
        // An interpolated normal may face away near the silhouette; project it to the silhouette
        // there.
        let facing = dot(normal, toward);
        if facing < 0.0 {
            normal = unit(sub(normal, scale(toward, facing)));
        }
        let frame = [dot(normal, self.view.right), dot(normal, self.view.up), dot(normal, self.view.back)];
        let depth = self.view.depth_of_key(self.visibility.key[sample] as f64);
        Some(Hit { face, point, depth, normal: frame, back })
    }
}

/// Studio lighting (ambient, key and rim light) in the camera's frame, scaled so that a face turned
/// to the camera keeps its colour.
pub(crate) fn studio(albedo: Linear, n: Vec3, open: f64) -> Linear {
    let key = unit([-0.50, 0.70, 0.75]);
    let fill = unit([0.85, 0.10, 0.55]);
    let above = 0.5 + 0.5 * n[1];
    let ambient = (0.30 + 0.24 * above) * open;
    let key_share = ((dot(n, key) + 0.18) / 1.18).max(0.0);
    let light = ambient + 0.66 * key_share * (0.55 + 0.45 * open) + 0.10 * dot(n, fill).max(0.0);
    // `light` at n = (0, 0, 1) and open = 1.
    let level = light / 0.942;
    let half = unit([key[0], key[1], key[2] + 1.0]);
    let gloss = 0.055 * dot(n, half).max(0.0).powi(36) * open;
    let grazing = (1.0 - n[2].clamp(0.0, 1.0)).powi(3);
    let rim = 0.16 * grazing * (0.35 + 0.65 * above) * open;
    albedo.map(|a| {
        let a = a as f64;
        let lit = a * level.min(1.0) + (level - 1.0).max(0.0) * a * (1.0 - a);
        (lit + gloss * (1.0 - lit).max(0.0) + rim * (0.3 + 0.7 * a) * (1.0 - lit).max(0.0)).clamp(0.0, 1.0)
            as f32
    })
}

/// Computes the colours of all samples, in linear light with premultiplied alpha.
pub(crate) fn shade(
    surface: &Surface,
    albedo: &Albedo,
    occlusion: Option<&Occlusion>,
    shadow: Option<&GroundShadow>,
    options: &RenderOptions,
) -> Vec<[f32; 4]> {
    let (width, height) = (surface.visibility.width, surface.visibility.height);
    let samples = options.supersampling as f64;
    let background = match options.background {
        Background::Solid(c) => Some(to_linear(c)),
        Background::Transparent => None,
    };
    let missing = to_linear(MISSING);
    let mut colors = vec![[0.0f32; 4]; width * height];
    let wire = options.wireframe.map(|w| (w, to_linear(w.color)));
    colors.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            let Some(hit) = surface.hit(x, y) else {
                let dark = shadow.map_or(0.0, |s| s.at(surface.view, x as f64 + 0.5, y as f64 + 0.5)) as f32;
                *out = match background {
                    Some([r, g, b]) => {
                        // Slightly cool shadows look natural on a light background.
                        [r * (1.0 - dark), g * (1.0 - 0.97 * dark), b * (1.0 - 0.92 * dark), 1.0]
                    }
                    None => [0.0, 0.0, 0.0, dark],
                };
                continue;
            };
            let mut color = albedo.at(hit.face, hit.point.as_ref(), samples).unwrap_or_else(|| {
                // Diagonal stripes, 9 pixels apart along each axis.
                let along = (x as f64 + y as f64) / samples / 9.0;
                let stripe = along - along.floor();
                if stripe < 0.28 { missing.map(|c| 0.62 * c) } else { missing }
            });
            if let Some((wire, wire_color)) = &wire {
                let distance = hit.point.as_ref().map_or(f64::INFINITY, edge_distance);
                let cover = ((wire.width / 2.0 - distance / samples) * samples + 0.5).clamp(0.0, 1.0);
                color = mix(color, *wire_color, (cover * wire.opacity) as f32);
            }
            if options.lighting == Lighting::Studio {
                if hit.back && options.tint_back_faces {
                    color = [0.78 * color[0], 0.80 * color[1], 0.84 * color[2]];
                }
                let open = occlusion.map_or(1.0, |o| o.at(x, y, hit.depth));
                color = studio(color, hit.normal, 1.0 - options.ambient_occlusion * (1.0 - open));
            }
            *out = [color[0], color[1], color[2], 1.0];
        }
    });
    colors
}

/// Distance to the nearest edge of the face, in samples.
fn edge_distance(point: &FacePoint) -> f64 {
    (0..3).map(|k| point.e[k].max(0.0) / point.dx[k].hypot(point.dy[k])).fold(f64::INFINITY, f64::min)
}

/// Two unit vectors that form an orthogonal frame with `n`.
pub(crate) fn tangent_frame(n: Vec3) -> (Vec3, Vec3) {
    let axis = if n[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let u = unit(cross(n, axis));
    (u, cross(n, u))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_turned_to_the_camera_keeps_its_color() {
        let lit = studio([0.5; 3], [0.0, 0.0, 1.0], 1.0);
        assert!((lit[0] - 0.5).abs() < 0.02, "{lit:?}");
        let below = studio([0.5; 3], [0.0, -1.0, 0.0], 1.0);
        assert!(below[0] < 0.3, "{below:?}");
    }
}
