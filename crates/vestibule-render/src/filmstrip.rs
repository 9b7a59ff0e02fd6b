//! Filmstrips: labelled pictures side by side, and the small lettering for them.

use crate::error::RenderError;
use crate::image::Image;

/// Space between pictures, pixels.
const GAP: u32 = 6;
/// Height of a label's line, pixels.
const LABEL: u32 = 18;
/// Size of a letter's dot, pixels.
const DOT: u32 = 2;
const PAPER: [u8; 4] = [24, 24, 28, 255];
const INK: [u8; 4] = [230, 230, 220, 255];

/// Labelled pictures, laid out in rows.
///
/// ```
/// use vestibule_render::{Filmstrip, Image};
/// # fn main() -> Result<(), vestibule_render::RenderError> {
/// let mut strip = Filmstrip::new(3);
/// for step in 0..5 {
///     strip.push(&format!("step {step}"), Image::new(160, 120, [90, 120, 60, 255])?);
/// }
/// let picture = strip.to_image()?;
/// assert_eq!(picture.width(), 3 * 160 + 4 * 6);
/// # Ok(()) }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Filmstrip {
    columns: u32,
    frames: Vec<(String, Image)>,
}

impl Filmstrip {
    /// An empty strip with this many pictures in a row (at least one).
    pub fn new(columns: u32) -> Self {
        Filmstrip {
            columns: columns.max(1),
            frames: Vec::new(),
        }
    }

    /// Adds a picture with a label: letters, digits and common signs; others show as a blank.
    pub fn push(&mut self, label: &str, picture: Image) {
        self.frames.push((label.to_owned(), picture));
    }

    /// Number of pictures.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there is no picture yet.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// All pictures in one, each under its label, in cells as large as the largest.
    ///
    /// # Errors
    /// When there is no picture, or so many that the strip would exceed [`crate::MAX_SIDE`].
    pub fn to_image(&self) -> Result<Image, RenderError> {
        let width = self.frames.iter().map(|(_, f)| f.width()).max();
        let height = self.frames.iter().map(|(_, f)| f.height()).max();
        let (Some(width), Some(height)) = (width, height) else {
            return Err(RenderError::Frames);
        };
        let count = u32::try_from(self.frames.len()).map_err(|_| RenderError::Frames)?;
        let columns = self.columns.min(count);
        let rows = count.div_ceil(columns);
        let total = |n: u32, each: u32| n.saturating_mul(each).saturating_add(GAP);
        let (cell_w, cell_h) = (width + GAP, height + LABEL + GAP);
        let mut out = Image::new(total(columns, cell_w), total(rows, cell_h), PAPER)?;
        for (k, (label, picture)) in (0u32..).zip(&self.frames) {
            let (x, y) = (GAP + k % columns * cell_w, GAP + k / columns * cell_h);
            out.draw_text(label, x, y + 3, INK, width);
            out.blit(picture, x, y + LABEL);
        }
        Ok(out)
    }
}

impl Image {
    /// Writes a line of small capitals with its top left corner at (x, y), at most `width` pixels wide.
    pub fn draw_text(&mut self, text: &str, x: u32, y: u32, color: [u8; 4], width: u32) {
        let mut at = 0;
        for c in text.chars() {
            let glyph = glyph(c.to_ascii_uppercase());
            let columns = if matches!(c, 'm' | 'M' | 'w' | 'W' | 'n' | 'N') {
                5
            } else {
                3
            };
            if at + columns * DOT > width {
                break;
            }
            for (row, line) in (0u32..).zip(glyph) {
                for column in 0..columns {
                    if line >> (columns - 1 - column) & 1 == 1 {
                        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                            self.set(x + at + column * DOT + dx, y + row * DOT + dy, color);
                        }
                    }
                }
            }
            at += (columns + 1) * DOT;
        }
    }
}

/// The five rows of a letter, three dots wide (M, N and W five).
fn glyph(c: char) -> [u8; 5] {
    match c {
        'A' => [0b010, 0b101, 0b111, 0b101, 0b101],
        'B' => [0b110, 0b101, 0b110, 0b101, 0b110],
        'C' => [0b011, 0b100, 0b100, 0b100, 0b011],
        'D' => [0b110, 0b101, 0b101, 0b101, 0b110],
        'E' => [0b111, 0b100, 0b110, 0b100, 0b111],
        'F' => [0b111, 0b100, 0b110, 0b100, 0b100],
        'G' => [0b011, 0b100, 0b101, 0b101, 0b011],
        'H' => [0b101, 0b101, 0b111, 0b101, 0b101],
        'I' => [0b111, 0b010, 0b010, 0b010, 0b111],
        'J' => [0b001, 0b001, 0b001, 0b101, 0b010],
        'K' => [0b101, 0b101, 0b110, 0b101, 0b101],
        'L' => [0b100, 0b100, 0b100, 0b100, 0b111],
        'M' => [0b10001, 0b11011, 0b10101, 0b10001, 0b10001],
        'N' => [0b10001, 0b11001, 0b10101, 0b10011, 0b10001],
        'O' => [0b010, 0b101, 0b101, 0b101, 0b010],
        'P' => [0b110, 0b101, 0b110, 0b100, 0b100],
        'Q' => [0b010, 0b101, 0b101, 0b110, 0b011],
        'R' => [0b110, 0b101, 0b110, 0b101, 0b101],
        'S' => [0b011, 0b100, 0b010, 0b001, 0b110],
        'T' => [0b111, 0b010, 0b010, 0b010, 0b010],
        'U' => [0b101, 0b101, 0b101, 0b101, 0b111],
        'V' => [0b101, 0b101, 0b101, 0b101, 0b010],
        'W' => [0b10001, 0b10001, 0b10101, 0b11011, 0b10001],
        'X' => [0b101, 0b101, 0b010, 0b101, 0b101],
        'Y' => [0b101, 0b101, 0b010, 0b010, 0b010],
        'Z' => [0b111, 0b001, 0b010, 0b100, 0b111],
        '0' => [0b111, 0b101, 0b101, 0b101, 0b111],
        '1' => [0b010, 0b110, 0b010, 0b010, 0b111],
        '2' => [0b111, 0b001, 0b111, 0b100, 0b111],
        '3' => [0b111, 0b001, 0b011, 0b001, 0b111],
        '4' => [0b101, 0b101, 0b111, 0b001, 0b001],
        '5' => [0b111, 0b100, 0b111, 0b001, 0b111],
        '6' => [0b111, 0b100, 0b111, 0b101, 0b111],
        '7' => [0b111, 0b001, 0b001, 0b010, 0b010],
        '8' => [0b111, 0b101, 0b111, 0b101, 0b111],
        '9' => [0b111, 0b101, 0b111, 0b001, 0b111],
        '.' => [0, 0, 0, 0, 0b010],
        ',' => [0, 0, 0, 0b010, 0b100],
        ':' => [0, 0b010, 0, 0b010, 0],
        '-' => [0, 0, 0b111, 0, 0],
        '>' => [0b100, 0b010, 0b001, 0b010, 0b100],
        '<' => [0b001, 0b010, 0b100, 0b010, 0b001],
        '+' => [0, 0b010, 0b111, 0b010, 0],
        '/' => [0b001, 0b001, 0b010, 0b100, 0b100],
        '(' => [0b001, 0b010, 0b010, 0b010, 0b001],
        ')' => [0b100, 0b010, 0b010, 0b010, 0b100],
        '[' => [0b011, 0b010, 0b010, 0b010, 0b011],
        ']' => [0b110, 0b010, 0b010, 0b010, 0b110],
        '#' => [0b101, 0b111, 0b101, 0b111, 0b101],
        '=' => [0, 0b111, 0, 0b111, 0],
        '_' => [0, 0, 0, 0, 0b111],
        '\'' => [0b010, 0b010, 0, 0, 0],
        '!' => [0b010, 0b010, 0b010, 0, 0b010],
        '?' => [0b111, 0b001, 0b010, 0, 0b010],
        '%' => [0b101, 0b001, 0b010, 0b100, 0b101],
        _ => [0; 5],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_without_pictures_or_too_long_is_an_error() {
        assert!(Filmstrip::new(4).to_image().is_err());
        let mut long = Filmstrip::new(1000);
        for _ in 0..100 {
            long.push("x", Image::new(200, 10, [0; 4]).unwrap());
        }
        assert!(matches!(long.to_image(), Err(RenderError::Size { .. })));
    }

    #[test]
    fn labels_leave_ink_and_stay_inside() {
        let mut image = Image::new(20, 10, [0; 4]).unwrap();
        image.draw_text("0xA9B40170 door", 0, 0, [255; 4], 20);
        assert!(image.pixels().contains(&[255; 4]));
    }
}
