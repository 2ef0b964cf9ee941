//! Colour bar with ticks at round numbers, or a legend with one swatch per label.

use crate::albedo::{Albedo, MappedField};
use crate::color::label_color;
use crate::font::{stroke_radius, text_segments, text_width};
use crate::image::Image;
use crate::options::{Background, RenderOptions};
use crate::scene::Coloring;
use eikona_mesh::round_step;
use std::collections::BTreeSet;

/// Largest number of labels with a legend: the colours of more would be hard to tell apart.
const MAX_LABELS: usize = 16;

/// Contents and layout of the legend, in pixels.
pub(crate) struct Legend<'a> {
    entries: Entries<'a>,
    title: Option<&'a str>,
    /// Height of capitals.
    text: f64,
    left: f64,
    bar_width: f64,
    right: f64,
    ink: [u8; 3],
}

enum Entries<'a> {
    /// The field of a colour bar, and its ticks: fraction of the bar from its lower end, and text.
    Bar(&'a MappedField<'a>, Vec<(f64, String)>),
    /// Labels from top to bottom, the largest first, as in a bar.
    Swatches(Vec<i64>),
}

impl<'a> Legend<'a> {
    /// Lays out the legend; `None` if there is nothing to explain or too little space.
    pub(crate) fn new(
        coloring: &Coloring<'a>,
        albedo: &'a Albedo,
        options: &RenderOptions,
    ) -> Option<Legend<'a>> {
        if !options.color_bar {
            return None;
        }
        let (entries, title) = match (coloring, albedo) {
            (Coloring::Field(field), Albedo::Field(mapped)) => {
                (Entries::Bar(mapped, ticks(mapped)), field.title)
            }
            (Coloring::Labels { labels, title }, _) => (Entries::Swatches(few_labels(labels)?), *title),
            _ => return None,
        };
        let (width, height) = (options.width as f64, options.height as f64);
        let text = (0.0145 * height).max(7.0);
        let widest = match &entries {
            Entries::Bar(_, t) => t.iter().map(|(_, s)| text_width(s, text)).fold(0.0, f64::max),
            Entries::Swatches(l) => l.iter().map(|l| text_width(&l.to_string(), text)).fold(0.0, f64::max),
        };
        let bar_width = 1.5 * text;
        let strip = bar_width + 1.3 * text + widest + 2.6 * text;
        if strip > 0.4 * width || height < 12.0 * text {
            return None;
        }
        let dark_background = match options.background {
            Background::Solid([r, g, b]) => 3 * u32::from(r) + 6 * u32::from(g) + u32::from(b) < 1100,
            Background::Transparent => false,
        };
        let ink = if dark_background { [226, 228, 232] } else { [44, 47, 56] };
        let left = width - strip;
        let right = width - 2.6 * text;
        Some(Legend { entries, title, text, left, bar_width, right, ink })
    }

    /// Width in pixels, from the left, available to the scene.
    pub(crate) fn free_width(&self) -> f64 {
        self.left.min(self.title_left() - self.text).max(0.5 * self.left)
    }

    /// Left end of the title.
    fn title_left(&self) -> f64 {
        let width = self.title.map_or(0.0, |title| text_width(title, self.text));
        (self.right - width).max(self.text).min(self.left)
    }

    pub(crate) fn draw(&self, image: &mut Image) {
        let height = image.height as f64;
        let (bar_right, text) = (self.left + self.bar_width, self.text);
        let text_left = bar_right + 1.3 * text;
        let mut top = 0.21 * height;
        match &self.entries {
            Entries::Bar(field, ticks) => {
                let bottom = height - top;
                let line = (text / 10.0).max(0.9);
                fill(
                    image,
                    [self.left - line, top - line],
                    [bar_right + line, bottom + line],
                    |_| self.ink,
                    1.0,
                );
                fill(
                    image,
                    [self.left, top],
                    [bar_right, bottom],
                    |y| field.bar_color((bottom - y) / (bottom - top)),
                    1.0,
                );
                for (fraction, label) in ticks {
                    let y = bottom - fraction * (bottom - top);
                    let end = bar_right + 0.55 * text;
                    fill(image, [bar_right, y - line / 2.0], [end, y + line / 2.0], |_| self.ink, 1.0);
                    self.write(image, label, text_left, y + 0.5 * text);
                }
            }
            Entries::Swatches(labels) => {
                let step = (2.3 * text).min(0.8 * height / labels.len().max(1) as f64);
                top = (height - step * labels.len() as f64) / 2.0;
                for (i, &label) in labels.iter().enumerate() {
                    let y = top + step * i as f64;
                    let size = 0.72 * step;
                    let color = label_color(label);
                    fill(image, [self.left, y], [bar_right, y + size], |_| color, 1.0);
                    self.write(image, &label.to_string(), text_left, y + size / 2.0 + 0.5 * text);
                }
            }
        }
        if let Some(title) = self.title {
            self.write(image, title, self.title_left(), top - 1.8 * text);
        }
    }

    fn write(&self, image: &mut Image, text: &str, x: f64, y: f64) {
        let radius = stroke_radius(self.text).max(0.55);
        let reach = radius + 0.5;
        let segments = text_segments(text, x, y, self.text);
        // Strokes within one line of text overlap: each pixel takes the largest coverage.
        let (left, right) = (x - 2.0 * reach, x + text_width(text, self.text) + 2.0 * reach);
        let (top, bottom) = (y - 1.3 * self.text - reach, y + 0.5 * self.text + reach);
        let clamp = |v: f64, most: u32| v.clamp(0.0, most as f64) as u32;
        let (x0, x1) = (clamp(left, image.width), clamp(right + 1.0, image.width));
        let (y0, y1) = (clamp(top, image.height), clamp(bottom + 1.0, image.height));
        let columns = (x1 - x0) as usize;
        let mut coverage = vec![0.0f64; columns * (y1 - y0) as usize];
        for [a, b] in segments {
            let low = [a[0].min(b[0]) - reach, a[1].min(b[1]) - reach];
            let high = [a[0].max(b[0]) + reach, a[1].max(b[1]) + reach];
            for j in clamp(low[1], image.height).max(y0)..clamp(high[1] + 1.0, image.height).min(y1) {
                for i in clamp(low[0], image.width).max(x0)..clamp(high[0] + 1.0, image.width).min(x1) {
                    let cover = (reach - distance([i as f64 + 0.5, j as f64 + 0.5], a, b)).clamp(0.0, 1.0);
                    let at = (j - y0) as usize * columns + (i - x0) as usize;
                    coverage[at] = coverage[at].max(cover);
                }
            }
        }
        for (at, &cover) in coverage.iter().enumerate().filter(|(_, c)| **c > 0.0) {
            over(image, x0 + (at % columns) as u32, y0 + (at / columns) as u32, self.ink, cover);
        }
    }
}

/// Returns the labels that occur, in decreasing order; `None` if there are too many for a legend.
fn few_labels(labels: &[i64]) -> Option<Vec<i64>> {
    let mut found = BTreeSet::new();
    for &label in labels {
        found.insert(label);
        if found.len() > MAX_LABELS {
            return None;
        }
    }
    Some(found.into_iter().rev().collect())
}

fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length_sq = dx * dx + dy * dy;
    let t = ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length_sq;
    let t = if length_sq > 0.0 { t.clamp(0.0, 1.0) } else { 0.0 };
    (p[0] - a[0] - t * dx).hypot(p[1] - a[1] - t * dy)
}

/// Fills a box with antialiased borders; `color` is evaluated at the middle of each row.
fn fill(image: &mut Image, low: [f64; 2], high: [f64; 2], color: impl Fn(f64) -> [u8; 3], alpha: f64) {
    let fraction =
        |i: u32, low: f64, high: f64| ((i as f64 + 1.0).min(high) - (i as f64).max(low)).clamp(0.0, 1.0);
    let end = |v: f64, most: u32| v.ceil().clamp(0.0, most as f64) as u32;
    for y in low[1].max(0.0) as u32..end(high[1], image.height) {
        let c = color(y as f64 + 0.5);
        for x in low[0].max(0.0) as u32..end(high[0], image.width) {
            over(image, x, y, c, alpha * fraction(x, low[0], high[0]) * fraction(y, low[1], high[1]));
        }
    }
}

/// Blends in sRGB, in which antialiased text keeps its weight.
fn over(image: &mut Image, x: u32, y: u32, color: [u8; 3], alpha: f64) {
    let start = 4 * (y as usize * image.width as usize + x as usize);
    let Some(pixel) = image.rgba.get_mut(start..start + 4) else { return };
    let below = pixel[3] as f64 / 255.0;
    let out = alpha + below * (1.0 - alpha);
    if out <= 0.0 {
        return;
    }
    for k in 0..3 {
        let mixed = (color[k] as f64 * alpha + pixel[k] as f64 * below * (1.0 - alpha)) / out;
        pixel[k] = mixed.round().clamp(0.0, 255.0) as u8;
    }
    pixel[3] = (255.0 * out).round() as u8;
}

/// Returns round numbers in the range, with their positions on the bar.
fn ticks(field: &MappedField) -> Vec<(f64, String)> {
    let [low, high] = field.bar;
    let step = round_step((high / 2.0 - low / 2.0) * 2.0, 6.0);
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    if (last - first).is_nan() || last - first > 20.0 || step < 1e-290 {
        // The range is too narrow for round numbers to resolve.
        return [low, high].map(|v| (field.bar_fraction(v), format!("{v:.3e}"))).to_vec();
    }
    let most = low.abs().max(high.abs());
    (0..=(last - first) as usize)
        .map(|i| {
            let value = (first + i as f64) * step;
            (field.bar_fraction(value), number(value, step, most))
        })
        .collect()
}

/// Formats a number to the precision of the tick step.
fn number(value: f64, step: f64, most: f64) -> String {
    let value = if value.abs() < step * 1e-6 { 0.0 } else { value };
    if value == 0.0 {
        return "0".to_owned();
    }
    let power = step.log10().floor();
    if !(1e-3..1e5).contains(&most) {
        let digits = (value.abs().log10().floor() - power).clamp(0.0, 12.0) as usize;
        return format!("{value:.digits$e}");
    }
    let digits = (-power).clamp(0.0, 12.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_of_the_step() {
        assert_eq!(number(0.4, 0.2, 1.0), "0.4");
        assert_eq!(number(-40.0, 20.0, 100.0), "-40");
        assert_eq!(number(0.05, 0.05, 0.1), "0.05");
        assert_eq!(number(3e-7, 1e-7, 5e-7), "3e-7");
        assert_eq!(number(1.2e8, 2e7, 1.4e8), "1.2e8");
        assert_eq!(number(-1e-17, 0.2, 1.0), "0");
    }
}
