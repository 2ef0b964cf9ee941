//! Points.

use super::{BIAS, Canvas, over};
use crate::camera::{NEAR, Projected};
use crate::color::to_linear;
use crate::drawing::PointStyle;
use crate::options::Lighting;
use crate::shade::studio;
use eikona_mesh::vector::Vec3;

impl Canvas<'_> {
    /// Draws points as balls, farthest first.
    pub(super) fn points(&mut self, positions: &[Vec3], style: &PointStyle) {
        let mut balls: Vec<Projected> = positions.iter().map(|p| self.project(p)).collect();
        balls.retain(|ball| ball.depth >= NEAR);
        balls.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        let radius = style.radius * self.samples;
        let color = to_linear(style.color);
        let border = radius + 1.0;
        for ball in balls {
            let (x, y) = (ball.h[0] / ball.h[2], ball.h[1] / ball.h[2]);
            let tolerance = BIAS + radius * 1.5 * self.view.sample_size(ball.depth);
            let Some((rows, columns)) = self.window([x - border, y - border], [x + border, y + border])
            else {
                continue;
            };
            for j in rows {
                for i in columns.clone() {
                    let (dx, dy) = (i as f64 + 0.5 - x, j as f64 + 0.5 - y);
                    let cover = (radius + 0.5 - dx.hypot(dy)).clamp(0.0, 1.0);
                    let sample = j * self.visibility.width + i;
                    if cover == 0.0 || self.surface_depth(sample) < ball.depth - tolerance {
                        continue;
                    }
                    // A ball smaller than a sample has no visible shape, and radius 0 must not
                    // divide.
                    let across = radius.max(1.0);
                    let (nx, ny) = (dx / across, -dy / across);
                    let normal = [nx, ny, (1.0 - nx * nx - ny * ny).max(0.0).sqrt()];
                    let lit = match self.lighting {
                        Lighting::Studio => studio(color, normal, 0.55 + 0.45 * normal[2]),
                        Lighting::Unlit => color,
                    };
                    over(&mut self.colors[sample], lit, cover as f32);
                }
            }
        }
    }
}
