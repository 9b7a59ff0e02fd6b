//! Id pictures: which cell's surface won each pixel (`rendering.md` 10.1).

use vestibule_world::CellId;

use crate::error::RenderError;
use crate::image::Image;
use crate::raster::{PixelId, PixelKind};

/// A picture whose pixels say which cell's surface won them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdImage {
    width: u32,
    height: u32,
    ids: Vec<PixelId>,
}

impl IdImage {
    /// A picture from its ids, row by row from the top; `None` when their number is not `width * height`.
    pub fn from_ids(width: u32, height: u32, ids: Vec<PixelId>) -> Option<Self> {
        (ids.len() == width as usize * height as usize).then_some(IdImage { width, height, ids })
    }

    /// Width, pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The ids, row by row from the top.
    pub fn ids(&self) -> &[PixelId] {
        &self.ids
    }

    /// The id at column `x`, row `y`; `None` outside.
    pub fn get(&self, x: u32, y: u32) -> Option<PixelId> {
        if x >= self.width {
            return None;
        }
        self.ids
            .get(y as usize * self.width as usize + x as usize)
            .copied()
    }

    /// How many pixels show this kind of thing.
    pub fn count(&self, kind: PixelKind) -> usize {
        self.ids.iter().filter(|id| id.kind() == kind).count()
    }

    /// How many pixels show this cell.
    pub fn count_cell(&self, cell: CellId) -> usize {
        self.ids.iter().filter(|id| id.cell() == Some(cell)).count()
    }

    /// The ids as colours: a pixel's three channels are the low 24 bits of its cell, white is sky, black nothing.
    ///
    /// # Errors
    /// Never for a picture this crate made.
    pub fn to_image(&self) -> Result<Image, RenderError> {
        let mut image = Image::new(self.width, self.height, [0, 0, 0, 255])?;
        for (pixel, id) in image.pixels_mut().iter_mut().zip(&self.ids) {
            *pixel = id.color();
        }
        Ok(image)
    }
}
