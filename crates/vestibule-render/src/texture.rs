//! Textures: pixels of RenderSurface records decoded to RGBA, with mip maps (`rendering.md` 15).

use vestibule_dat::record::{Palette, PixelFormat, RenderSurface};

use crate::dxt::{self, Dxt};

/// Longest side of a texture that is decoded (`dat-format.md` X15).
pub(crate) const MAX_TEXTURE_SIDE: u32 = 8192;
/// Most pixels of a texture that is decoded: 64 MB decoded.
pub(crate) const MAX_TEXTURE_PIXELS: u64 = 1 << 24;

/// How a surface wants its picture decoded: the same record gives different pixels (`rendering.md` 15.1c).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DecodeAs {
    /// Palette indices 0 to 7, and DXT texels that are pure black, are transparent (15.1, 15.1a).
    pub clip_map: bool,
    /// An A8 picture gives its value to all four channels (15.1b).
    pub additive: bool,
}

/// Why pixels could not be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// A format that this renderer does not read.
    #[error("pixel format {0:#x} is not supported")]
    Format(u32),
    /// Sides that are zero, negative or absurdly long.
    #[error("a texture of {0} x {1} pixels cannot be used")]
    Size(i32, i32),
    /// The record has fewer pixel bytes than its size and format need.
    #[error("{present} pixel bytes where {needed} are needed")]
    Short {
        /// Bytes that the size and format need.
        needed: usize,
        /// Bytes that are there.
        present: usize,
    },
    /// The bytes are no JPEG file of the record's size.
    #[error("the JPEG file of a texture is damaged or of another size")]
    Jpeg,
    /// A picture of palette indices without a palette.
    #[error("the palette of an indexed texture is missing")]
    NoPalette,
}

/// A decoded texture and its mip maps, largest first. Rows from top to bottom; u runs right, v down.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    levels: Vec<Level>,
}

/// One mip level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// RGBA, row by row from the top.
    pub pixels: Vec<[u8; 4]>,
}

impl Texture {
    /// A texture from its largest level; smaller ones are made of it. `cutout` keeps the share of pixels that pass
    /// an alpha test the same on every level (`rendering.md` 15.3).
    pub fn new(width: u32, height: u32, pixels: Vec<[u8; 4]>, cutout: bool) -> Self {
        let mut levels = vec![Level {
            width,
            height,
            pixels,
        }];
        while let Some(last) = levels.last() {
            if last.width <= 1 && last.height <= 1 {
                break;
            }
            let mut next = last.halved();
            if cutout {
                keep_coverage(&levels[0], &mut next);
            }
            levels.push(next);
        }
        Texture { levels }
    }

    /// One pixel of one colour.
    pub fn solid(color: [u8; 4]) -> Self {
        Texture::new(1, 1, vec![color], false)
    }

    /// The magenta checker that stands for what could not be had (`rendering.md` 15.4).
    pub fn placeholder() -> Self {
        let pixels = (0..64)
            .map(|i| {
                if (i % 8 / 4 + i / 8 / 4) % 2 == 0 {
                    [255, 0, 255, 255]
                } else {
                    [30, 0, 30, 255]
                }
            })
            .collect();
        Texture::new(8, 8, pixels, false)
    }

    /// The mip levels, largest first; at least one.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Width of the largest level, pixels.
    pub fn width(&self) -> u32 {
        self.levels[0].width
    }

    /// Height of the largest level, pixels.
    pub fn height(&self) -> u32 {
        self.levels[0].height
    }

    /// The colour at (u, v), each channel 0…255: bilinear, from the level nearest to `lod` (0 the largest),
    /// repeated beyond 0…1 if `wrap`, else clamped.
    #[inline]
    pub fn sample(&self, u: f32, v: f32, lod: f32, wrap: bool) -> [f32; 4] {
        let last = self.levels.len() - 1;
        let level = if lod > 0.5 {
            ((lod + 0.5) as usize).min(last)
        } else {
            0
        };
        self.levels[level].sample(u, v, wrap)
    }
}

impl Level {
    #[inline]
    fn sample(&self, u: f32, v: f32, wrap: bool) -> [f32; 4] {
        if self.pixels.len() == 1 {
            return self.pixels[0].map(f32::from);
        }
        let (w, h) = (self.width as i32, self.height as i32);
        let axis = |t: f32, n: i32| -> (i32, i32, f32) {
            let t = if wrap {
                t - libm::floorf(t)
            } else if t > 1.0 {
                1.0
            } else if t > 0.0 {
                t
            } else {
                0.0
            };
            let x = t * n as f32 - 0.5;
            let x0 = libm::floorf(x);
            let (a, b) = (x0 as i32, x0 as i32 + 1);
            let place = |i: i32| {
                if wrap {
                    if i < 0 {
                        i + n
                    } else if i >= n {
                        i - n
                    } else {
                        i
                    }
                } else {
                    i.clamp(0, n - 1)
                }
            };
            // A coordinate that is not a number must not lead outside.
            (place(a).clamp(0, n - 1), place(b).clamp(0, n - 1), x - x0)
        };
        let (x0, x1, fx) = axis(u, w);
        let (y0, y1, fy) = axis(v, h);
        let at = |x: i32, y: i32| self.pixels[(y * w + x) as usize];
        let (p, q, r, s) = (at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1));
        core::array::from_fn(|k| {
            let top = f32::from(p[k]) + (f32::from(q[k]) - f32::from(p[k])) * fx;
            let bottom = f32::from(r[k]) + (f32::from(s[k]) - f32::from(r[k])) * fx;
            top + (bottom - top) * fy
        })
    }

    fn halved(&self) -> Level {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0u32; 4];
                let mut weight = 0u32;
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let sx = (2 * x + dx).min(self.width - 1);
                    let sy = (2 * y + dy).min(self.height - 1);
                    let p = self.pixels[(sy * self.width + sx) as usize];
                    // Transparent texels must not bleed their colour; a little weight keeps the sum above zero.
                    let a = u32::from(p[3]) * 8 + 1;
                    weight += a;
                    for k in 0..3 {
                        sum[k] += u32::from(p[k]) * a;
                    }
                    sum[3] += u32::from(p[3]);
                }
                let c = |k: usize| ((sum[k] + weight / 2) / weight) as u8;
                pixels.push([c(0), c(1), c(2), ((sum[3] + 2) / 4) as u8]);
            }
        }
        Level {
            width,
            height,
            pixels,
        }
    }
}

/// Scales the alpha of a level so that as many texels pass the middle as on the largest level.
fn keep_coverage(full: &Level, level: &mut Level) {
    let wanted = full.pixels.iter().filter(|p| p[3] >= 128).count() as f32 / full.pixels.len() as f32;
    let mut alphas: Vec<u8> = level.pixels.iter().map(|p| p[3]).collect();
    alphas.sort_unstable();
    let cut = ((1.0 - wanted) * alphas.len() as f32) as usize;
    let Some(&threshold) = alphas.get(cut.min(alphas.len().saturating_sub(1))) else {
        return;
    };
    let scale = 128.0 / f32::from(threshold.max(1));
    for p in &mut level.pixels {
        p[3] = (f32::from(p[3]) * scale).clamp(0.0, 255.0) as u8;
    }
}

/// Decodes a RenderSurface (`rendering.md` 15). `palette` is the one to use for indexed formats.
///
/// # Errors
/// When the format is unknown, the size absurd, bytes or the palette missing.
pub fn decode(
    record: &RenderSurface,
    palette: Option<&Palette>,
    how: DecodeAs,
) -> Result<Texture, TextureError> {
    let (w, h) = (record.width, record.height);
    let size_error = TextureError::Size(w, h);
    let (width, height) = match (u32::try_from(w), u32::try_from(h)) {
        (Ok(w), Ok(h)) if (1..=MAX_TEXTURE_SIDE).contains(&w) && (1..=MAX_TEXTURE_SIDE).contains(&h) => {
            (w, h)
        }
        _ => return Err(size_error),
    };
    if u64::from(width) * u64::from(height) > MAX_TEXTURE_PIXELS {
        return Err(size_error);
    }
    let format = record.pixel_format().ok_or(TextureError::Format(record.format))?;
    if format == PixelFormat::RawJpeg {
        let pixels = crate::jpeg::decode(&record.pixels, width, height).ok_or(TextureError::Jpeg)?;
        return Ok(Texture::new(width, height, pixels, how.clip_map));
    }
    let needed = format
        .byte_length(width, height)
        .ok_or(TextureError::Format(record.format))?;
    let bytes = record.pixels.get(..needed).ok_or(TextureError::Short {
        needed,
        present: record.pixels.len(),
    })?;
    let word = |b: &[u8]| u16::from_le_bytes([b[0], b[1]]);
    let index = |i: usize| -> [u8; 4] {
        if how.clip_map && i < 8 {
            return [0; 4];
        }
        let color = palette.and_then(|p| p.colors.get(i));
        color.map_or([0, 0, 0, 255], |c| [c.red(), c.green(), c.blue(), c.alpha()])
    };
    if format.is_paletted() && palette.is_none() {
        return Err(TextureError::NoPalette);
    }
    let (wu, hu) = (width as usize, height as usize);
    let block = |kind| {
        let mut pixels = dxt::decode(kind, bytes, wu, hu, [0; 4]);
        if how.clip_map {
            for p in &mut pixels {
                if p[..3] == [0, 0, 0] {
                    *p = [0; 4];
                }
            }
        }
        pixels
    };
    let pixels: Vec<[u8; 4]> = match format {
        PixelFormat::R8G8B8 => bytes.chunks_exact(3).map(|b| [b[2], b[1], b[0], 255]).collect(),
        PixelFormat::A8R8G8B8 => bytes.chunks_exact(4).map(|b| [b[2], b[1], b[0], b[3]]).collect(),
        PixelFormat::X8R8G8B8 => bytes.chunks_exact(4).map(|b| [b[2], b[1], b[0], 255]).collect(),
        PixelFormat::R5G6B5 => bytes
            .chunks_exact(2)
            .map(|b| {
                let v = word(b);
                let (r, g, b) = (v >> 11, v >> 5 & 63, v & 31);
                [
                    (r << 3 | r >> 2) as u8,
                    (g << 2 | g >> 4) as u8,
                    (b << 3 | b >> 2) as u8,
                    255,
                ]
            })
            .collect(),
        PixelFormat::A4R4G4B4 => bytes
            .chunks_exact(2)
            .map(|b| {
                let v = word(b);
                let nibble = |shift: u16| (v >> shift & 15) as u8 * 17;
                [nibble(8), nibble(4), nibble(0), nibble(12)]
            })
            .collect(),
        PixelFormat::A8 if how.additive => bytes.iter().map(|&a| [a; 4]).collect(),
        PixelFormat::A8 => bytes.iter().map(|&a| [255, 255, 255, a]).collect(),
        PixelFormat::P8 => bytes.iter().map(|&i| index(usize::from(i))).collect(),
        PixelFormat::Index16 => bytes
            .chunks_exact(2)
            .map(|b| index(usize::from(word(b))))
            .collect(),
        PixelFormat::LscapeR8G8B8 => bytes.chunks_exact(3).map(|b| [b[0], b[1], b[2], 255]).collect(),
        PixelFormat::LscapeAlpha => bytes.iter().map(|&a| [255, 255, 255, a]).collect(),
        PixelFormat::Dxt1 => block(Dxt::One),
        PixelFormat::Dxt3 => block(Dxt::Three),
        PixelFormat::Dxt5 => block(Dxt::Five),
        PixelFormat::RawJpeg => return Err(TextureError::Jpeg),
    };
    Ok(Texture::new(width, height, pixels, how.clip_map))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vestibule_dat::primitive::Argb;

    fn surface(format: PixelFormat, width: i32, height: i32, pixels: Vec<u8>) -> RenderSurface {
        RenderSurface {
            width,
            height,
            format: format as u32,
            pixels,
            palette: format.is_paletted().then_some(0x0400_0001),
            ..RenderSurface::default()
        }
    }

    fn first(format: PixelFormat, bytes: &[u8]) -> [u8; 4] {
        let palette = Palette {
            id: 0x0400_0001,
            colors: (0..300).map(|i| Argb(0x8011_2200 | i)).collect(),
        };
        let t = decode(
            &surface(format, 1, 1, bytes.to_vec()),
            Some(&palette),
            DecodeAs::default(),
        );
        t.unwrap().levels()[0].pixels[0]
    }

    #[test]
    fn r15_pixel_formats() {
        assert_eq!(first(PixelFormat::R8G8B8, &[1, 2, 3]), [3, 2, 1, 255]);
        assert_eq!(first(PixelFormat::A8R8G8B8, &[1, 2, 3, 4]), [3, 2, 1, 4]);
        assert_eq!(first(PixelFormat::X8R8G8B8, &[1, 2, 3, 4]), [3, 2, 1, 255]);
        assert_eq!(first(PixelFormat::R5G6B5, &[0x1F, 0xF8]), [255, 0, 255, 255]);
        assert_eq!(first(PixelFormat::A4R4G4B4, &[0x34, 0x12]), [34, 51, 68, 17]);
        assert_eq!(first(PixelFormat::A8, &[9]), [255, 255, 255, 9]);
        assert_eq!(first(PixelFormat::P8, &[9]), [0x11, 0x22, 9, 0x80]);
        assert_eq!(first(PixelFormat::Index16, &[0x2B, 1]), [0x11, 0x23, 0x2B, 0x80]);
        assert_eq!(first(PixelFormat::LscapeR8G8B8, &[1, 2, 3]), [1, 2, 3, 255]);
        assert_eq!(first(PixelFormat::LscapeAlpha, &[77]), [255, 255, 255, 77]);
    }

    #[test]
    fn r15_1_a_clip_map_is_transparent_below_index_8() {
        let palette = Palette {
            id: 1,
            colors: vec![Argb(0xFF11_2233); 16],
        };
        let clip = DecodeAs {
            clip_map: true,
            additive: false,
        };
        let record = surface(PixelFormat::P8, 2, 1, vec![7, 8]);
        let t = decode(&record, Some(&palette), clip).unwrap();
        assert_eq!(t.levels()[0].pixels, [[0; 4], [0x11, 0x22, 0x33, 255]]);
        let plain = decode(&record, Some(&palette), DecodeAs::default()).unwrap();
        assert_eq!(plain.levels()[0].pixels[0], [0x11, 0x22, 0x33, 255]);
    }

    #[test]
    fn r15_dxt_blocks() {
        // Red and blue, codes 0 1 2 3 in the first row.
        let block = [0x00, 0xF8, 0x1F, 0x00, 0b1110_0100, 0, 0, 0];
        let record = surface(PixelFormat::Dxt1, 4, 4, block.to_vec());
        let t = decode(&record, None, DecodeAs::default()).unwrap();
        let row = &t.levels()[0].pixels[..4];
        assert_eq!(
            row,
            [
                [255, 0, 0, 255],
                [0, 0, 255, 255],
                [170, 0, 85, 255],
                [85, 0, 170, 255]
            ]
        );
        // First colour not above the second: code 3 is transparent.
        let swapped = [0x1F, 0x00, 0x00, 0xF8, 0b1110_0100, 0, 0, 0];
        let record = surface(PixelFormat::Dxt1, 4, 4, swapped.to_vec());
        let t = decode(&record, None, DecodeAs::default()).unwrap();
        assert_eq!(t.levels()[0].pixels[3], [0; 4]);
        let mut dxt5 = vec![200, 100, 0b0000_1000, 0, 0, 0, 0, 0];
        dxt5.extend(block);
        let t = decode(&surface(PixelFormat::Dxt5, 4, 4, dxt5), None, DecodeAs::default()).unwrap();
        assert_eq!(t.levels()[0].pixels[0][3], 200);
        assert_eq!(t.levels()[0].pixels[1][3], 100);
        let mut dxt3 = vec![0x2F, 0, 0, 0, 0, 0, 0, 0];
        dxt3.extend(block);
        let t = decode(&surface(PixelFormat::Dxt3, 3, 2, dxt3), None, DecodeAs::default()).unwrap();
        assert_eq!(
            (t.levels()[0].pixels[0][3], t.levels()[0].pixels[1][3]),
            (255, 34)
        );
    }

    #[test]
    fn r15_jpeg_files() {
        let file = crate::jpeg::tests::file(&[72, -72, 72]);
        let record = surface(PixelFormat::RawJpeg, 8, 8, file);
        let t = decode(&record, None, DecodeAs::default()).unwrap();
        assert_eq!((t.width(), t.levels()[0].pixels.len()), (8, 64));
        let wrong_size = surface(PixelFormat::RawJpeg, 16, 8, record.pixels.clone());
        let how = DecodeAs::default();
        assert_eq!(decode(&wrong_size, None, how), Err(TextureError::Jpeg));
        for cut in 0..record.pixels.len() {
            // Cut off anywhere: an error or a picture, never a panic.
            let _ = decode(
                &surface(PixelFormat::RawJpeg, 8, 8, record.pixels[..cut].to_vec()),
                None,
                how,
            );
        }
    }

    #[test]
    fn bad_records_are_errors() {
        let how = DecodeAs::default();
        let mut record = surface(PixelFormat::R8G8B8, 4, 4, vec![0; 10]);
        assert_eq!(
            decode(&record, None, how),
            Err(TextureError::Short {
                needed: 48,
                present: 10
            })
        );
        record.width = 1 << 30;
        assert!(matches!(decode(&record, None, how), Err(TextureError::Size(..))));
        record.width = -1;
        assert!(matches!(decode(&record, None, how), Err(TextureError::Size(..))));
        record.format = 9999;
        record.width = 4;
        assert_eq!(decode(&record, None, how), Err(TextureError::Format(9999)));
        let indexed = surface(PixelFormat::P8, 1, 1, vec![0]);
        assert_eq!(decode(&indexed, None, how), Err(TextureError::NoPalette));
    }

    #[test]
    fn sampling_stays_inside_whatever_the_coordinates() {
        let t = Texture::placeholder();
        for u in [f32::NAN, f32::INFINITY, -1e30, 1e30, 0.999_999_94, -0.0] {
            t.sample(u, u, 0.0, true);
            t.sample(u, u, 99.0, false);
            t.sample(u, u, f32::NAN, true);
        }
    }
}
