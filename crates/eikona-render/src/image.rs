//! Finished image and its PNG encoding.

use crate::error::RenderError;
use std::io::Write;
use std::path::Path;

/// Image: rows from top to bottom, pixels from left to right, 8 bits per channel, sRGB, with
/// straight (not premultiplied) alpha.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue, alpha of each pixel: `4 * width * height` bytes.
    pub rgba: Vec<u8>,
}

impl Image {
    /// Returns the colour of the pixel in column `x` and row `y` (row 0 is the top), or `None`
    /// outside the image.
    ///
    /// ```
    /// let rgba = vec![1, 2, 3, 255, 4, 5, 6, 255];
    /// let image = eikona_render::Image { width: 2, height: 1, rgba };
    /// assert_eq!(image.pixel(1, 0), Some([4, 5, 6, 255]));
    /// assert_eq!(image.pixel(0, 1), None);
    /// ```
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        self.rgba.as_chunks().0.get(y as usize * self.width as usize + x as usize).copied()
    }

    /// Encodes the image as PNG: RGB if it is opaque, RGBA otherwise.
    ///
    /// ```
    /// let image = eikona_render::Image { width: 1, height: 1, rgba: vec![1, 2, 3, 255] };
    /// assert!(image.to_png_bytes()?.starts_with(b"\x89PNG"));
    /// # Ok::<(), eikona_render::RenderError>(())
    /// ```
    ///
    /// # Errors
    /// [`RenderError::Encoding`] if `rgba` does not have `4 * width * height` bytes or a side is 0.
    pub fn to_png_bytes(&self) -> Result<Vec<u8>, RenderError> {
        let expected = 4 * u128::from(self.width) * u128::from(self.height);
        if self.rgba.len() as u128 != expected {
            let reason = format!("the pixels are {} bytes, but {expected} are needed", self.rgba.len());
            return Err(RenderError::Encoding { reason });
        }
        let failed = |e: png::EncodingError| RenderError::Encoding { reason: e.to_string() };
        let opaque = self.rgba.chunks_exact(4).all(|p| p[3] == 255);
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
        let mut writer = encoder.write_header().map_err(failed)?;
        if opaque {
            let rgb: Vec<u8> = self.rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
            writer.write_image_data(&rgb).map_err(failed)?;
        } else {
            writer.write_image_data(&self.rgba).map_err(failed)?;
        }
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }

    /// Writes the image as a PNG file, under a temporary name in the same folder that is then
    /// renamed, so that no half-written file is visible.
    ///
    /// # Errors
    /// [`RenderError::Write`] with the path and the system's reason, [`RenderError::Encoding`] as
    /// in [`Image::to_png_bytes`].
    pub fn write_png(&self, path: impl AsRef<Path>) -> Result<(), RenderError> {
        let path = path.as_ref();
        let bytes = self.to_png_bytes()?;
        let failed = |source| RenderError::Write { path: path.display().to_string(), source };
        let Some(name) = path.file_name() else {
            return Err(failed(std::io::Error::from(std::io::ErrorKind::InvalidInput)));
        };
        let mut temporary_name = std::ffi::OsString::from(".");
        temporary_name.push(name);
        temporary_name.push(format!(".{}.part", std::process::id()));
        let temporary = path.with_file_name(temporary_name);
        let written = std::fs::File::create(&temporary)
            .and_then(|mut file| file.write_all(&bytes).and_then(|()| file.sync_all()))
            .and_then(|()| std::fs::rename(&temporary, path));
        if written.is_err() {
            // The first error is the one to report; a leftover temporary file does no harm.
            let _ = std::fs::remove_file(&temporary);
        }
        written.map_err(failed)
    }
}
