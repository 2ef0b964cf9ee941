//! Draws over the shaded samples, with a depth test against the surface.

mod curve;
mod glyphs;
mod path;
mod points;
mod stroke;
mod texts;

use crate::camera::{Normalization, Projected, View};
use crate::color::Linear;
use crate::drawing::Drawing;
use crate::options::{Lighting, RenderOptions};
use crate::raster::Visibility;
use eikona_mesh::vector::Vec3;
use std::ops::Range;

/// Depth bias: how far below the surface a drawing may lie and still be visible, in units of the
/// scene's radius.
const BIAS: f64 = 0.004;

/// Samples to draw on.
pub(crate) struct Canvas<'a> {
    normalization: &'a Normalization,
    view: &'a View,
    visibility: &'a Visibility,
    colors: &'a mut [[f32; 4]],
    /// Samples along a pixel.
    samples: f64,
    lighting: Lighting,
    /// Coverage of each sample by the current stroke, so that overlapping segments count once.
    coverage: Vec<f32>,
    touched: Vec<u32>,
}

impl<'a> Canvas<'a> {
    pub(crate) fn new(
        normalization: &'a Normalization,
        view: &'a View,
        visibility: &'a Visibility,
        colors: &'a mut [[f32; 4]],
        options: &RenderOptions,
    ) -> Self {
        let coverage = vec![0.0; colors.len()];
        let (samples, lighting) = (options.supersampling as f64, options.lighting);
        Canvas { normalization, view, visibility, colors, samples, lighting, coverage, touched: Vec::new() }
    }

    pub(crate) fn draw(&mut self, drawing: &Drawing) {
        match drawing {
            Drawing::Isolines(_) => {} // part of the colour of the surface: see `Albedo`
            Drawing::Curve { points, style } => self.curve(points, style),
            Drawing::Glyphs { ends, style } => self.glyphs(ends, style),
            Drawing::Points { positions, style } => self.points(positions, style),
            Drawing::Texts { positions, texts, style } => self.texts(positions, texts, style),
        }
    }

    fn project(&self, position: &Vec3) -> Projected {
        self.view.project(self.normalization.apply(*position))
    }

    fn surface_depth(&self, sample: usize) -> f64 {
        let key = self.visibility.key[sample];
        if key == f32::NEG_INFINITY { f64::INFINITY } else { self.view.depth_of_key(key as f64) }
    }

    /// Returns whether a point of a centre line is visible, or outside the image.
    fn is_centre_visible(&self, position: [f64; 2], key: f64) -> bool {
        let (width, height) = (self.visibility.width, self.visibility.height);
        if !(position[0] >= 0.0
            && position[1] >= 0.0
            && position[0] < width as f64
            && position[1] < height as f64)
        {
            return true;
        }
        let depth = self.view.depth_of_key(key);
        let tolerance = BIAS + 3.0 * self.view.sample_size(depth);
        self.surface_depth(position[1] as usize * width + position[0] as usize) >= depth - tolerance
    }

    /// Returns the rows and columns of the samples of a box, clipped to the image.
    fn window(&self, low: [f64; 2], high: [f64; 2]) -> Option<(Range<usize>, Range<usize>)> {
        let range = |low: f64, high: f64, count: usize| {
            let start = low.floor().max(0.0);
            let end = (high.ceil() + 1.0).min(count as f64);
            (start < end).then_some(start as usize..end as usize)
        };
        Some((
            range(low[1], high[1], self.visibility.height)?,
            range(low[0], high[0], self.visibility.width)?,
        ))
    }

    /// Adds coverage by something whose middle has this depth, unless the surface hides it. The
    /// surface around the middle may be nearer to the camera: a slope of 4 over `reach` samples is
    /// tolerated.
    fn cover(&mut self, sample: usize, cover: f64, key: f64, reach: f64) {
        let depth = self.view.depth_of_key(key);
        if self.surface_depth(sample) < depth - BIAS - 4.0 * reach * self.view.sample_size(depth) {
            return;
        }
        if self.coverage[sample] == 0.0 {
            self.touched.push(sample as u32);
        }
        self.coverage[sample] = self.coverage[sample].max(cover as f32);
    }

    /// Blends a colour over the covered samples and clears the coverage.
    fn paint(&mut self, color: Linear) {
        for &sample in &self.touched {
            let sample = sample as usize;
            over(&mut self.colors[sample], color, self.coverage[sample]);
            self.coverage[sample] = 0.0;
        }
        self.touched.clear();
    }
}

fn over(below: &mut [f32; 4], color: Linear, alpha: f32) {
    for k in 0..3 {
        below[k] = below[k] * (1.0 - alpha) + color[k] * alpha;
    }
    below[3] = below[3] * (1.0 - alpha) + alpha;
}
