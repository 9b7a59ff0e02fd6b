//! Pictures in memory, and writing them as PNG and animated PNG.

use std::io::Write;

use crate::error::RenderError;

/// Longest side of a picture, pixels.
pub const MAX_SIDE: u32 = 8192;

/// A picture: rows from top to bottom, red, green, blue, alpha, one byte each, as stored in a PNG (no colour
/// conversion, `rendering.md` 9.7).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 4]>,
}

impl Image {
    /// A picture of one colour.
    ///
    /// # Errors
    /// When a side is 0 or longer than [`MAX_SIDE`].
    pub fn new(width: u32, height: u32, color: [u8; 4]) -> Result<Self, RenderError> {
        check_size(width, height)?;
        Ok(Image {
            width,
            height,
            pixels: vec![color; width as usize * height as usize],
        })
    }

    /// Width, pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// All pixels, to be changed.
    pub fn pixels_mut(&mut self) -> &mut [[u8; 4]] {
        &mut self.pixels
    }

    /// The pixel at column `x`, row `y`; `None` outside.
    pub fn get(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        if x >= self.width {
            return None;
        }
        self.pixels
            .get(y as usize * self.width as usize + x as usize)
            .copied()
    }

    /// Sets a pixel; outside the picture nothing happens.
    pub fn set(&mut self, x: u32, y: u32, color: [u8; 4]) {
        if x < self.width
            && let Some(p) = self.pixels.get_mut(y as usize * self.width as usize + x as usize)
        {
            *p = color;
        }
    }

    /// Copies another picture to column `x`, row `y`, cut at the edges.
    pub fn blit(&mut self, from: &Image, x: u32, y: u32) {
        for row in 0..from.height.min(self.height.saturating_sub(y)) {
            for column in 0..from.width.min(self.width.saturating_sub(x)) {
                if let Some(p) = from.get(column, row) {
                    self.set(x + column, y + row, p);
                }
            }
        }
    }

    /// The picture as the bytes of a PNG file.
    ///
    /// # Errors
    /// When it cannot be encoded.
    pub fn to_png(&self) -> Result<Vec<u8>, RenderError> {
        let mut out = Vec::new();
        self.write_png(&mut out)?;
        Ok(out)
    }

    /// Writes the picture as PNG.
    ///
    /// # Errors
    /// When it cannot be encoded or `out` refuses it.
    pub fn write_png(&self, out: impl Write) -> Result<(), RenderError> {
        let mut encoder = png::Encoder::new(out, self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        Ok(writer.finish()?)
    }

    /// Writes the picture to a PNG file.
    ///
    /// # Errors
    /// When the file cannot be made or written.
    pub fn save_png(&self, path: impl AsRef<std::path::Path>) -> Result<(), RenderError> {
        let file = std::fs::File::create(path)?;
        let mut out = std::io::BufWriter::new(file);
        self.write_png(&mut out)?;
        Ok(out.flush()?)
    }
}

/// Writes pictures of one size as an animated PNG, endlessly repeated, each shown for `delay_ms` milliseconds.
///
/// # Errors
/// When there is no picture, the sizes differ, or the file cannot be encoded.
pub fn write_apng(frames: &[Image], delay_ms: u16, out: impl Write) -> Result<(), RenderError> {
    let first = frames.first().ok_or(RenderError::Frames)?;
    if frames
        .iter()
        .any(|f| (f.width, f.height) != (first.width, first.height))
    {
        return Err(RenderError::Frames);
    }
    let count = u32::try_from(frames.len()).map_err(|_| RenderError::Frames)?;
    let mut encoder = png::Encoder::new(out, first.width, first.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_animated(count, 0)?;
    encoder.set_frame_delay(delay_ms, 1000)?;
    let mut writer = encoder.write_header()?;
    let mut bytes = Vec::with_capacity(first.pixels.len() * 3);
    for frame in frames {
        bytes.clear();
        bytes.extend(frame.pixels.iter().flat_map(|p| [p[0], p[1], p[2]]));
        writer.write_image_data(&bytes)?;
    }
    Ok(writer.finish()?)
}

pub(crate) fn check_size(width: u32, height: u32) -> Result<(), RenderError> {
    if (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height) {
        Ok(())
    } else {
        Err(RenderError::Size { width, height })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_without_pixels_is_an_error() {
        assert!(matches!(
            Image::new(0, 5, [0; 4]),
            Err(RenderError::Size { width: 0, height: 5 })
        ));
        assert!(Image::new(MAX_SIDE + 1, 5, [0; 4]).is_err());
    }

    #[test]
    fn a_png_holds_the_stored_bytes() {
        let mut image = Image::new(3, 2, [1, 2, 3, 255]).unwrap();
        image.set(2, 1, [200, 100, 50, 255]);
        let bytes = image.to_png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, image.pixels().as_flattened());
    }

    #[test]
    fn an_animation_needs_pictures_of_one_size() {
        let a = Image::new(3, 2, [1; 4]).unwrap();
        let b = Image::new(2, 2, [1; 4]).unwrap();
        assert!(write_apng(&[], 40, Vec::new()).is_err());
        assert!(write_apng(&[a.clone(), b], 40, Vec::new()).is_err());
        let mut out = Vec::new();
        write_apng(&[a.clone(), a], 40, &mut out).unwrap();
        assert!(out.windows(4).any(|w| w == b"acTL"));
    }
}
