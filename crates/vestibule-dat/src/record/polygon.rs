//! Polygons (`dat-format.md` 8.2).

use super::RecordError;
use crate::primitive::{CompressedForm, Reader, Writer};

/// A polygon with its id, every field as stored.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Polygon {
    /// Key of the polygon in its owner's list.
    pub id: u16,
    /// Bits: 1 positive, 2 negative, 4 no positive UVs, 8 no negative UVs, 0x10.
    pub stippling: u8,
    /// 0 single-sided, 1 both sides alike, 2 both sides different. See [`sides`](Self::sides).
    pub sides_type: i32,
    /// Index into the owner's surface list, -1 none.
    pub pos_surface: i16,
    /// The same for the back, as stored; [`negative_surface`](Self::negative_surface) applies G2.
    pub neg_surface: i16,
    /// Vertex ids, counter-clockwise seen from the front.
    pub vertex_ids: Vec<u16>,
    /// For each vertex, which of its UVs the front uses; empty when the stippling says so.
    pub pos_uv: Vec<u8>,
    /// For each vertex, which of its UVs the back uses, as stored; [`negative_uv`](Self::negative_uv) applies G2.
    pub neg_uv: Vec<u8>,
}

/// Which sides of a polygon are drawn, and with what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sides {
    /// Only the front.
    Single,
    /// Both, the back like the front.
    BothAlike,
    /// Both, the back with its own surface.
    BothDifferent,
}

impl Polygon {
    /// Stippling bit: no UV indices for the front.
    pub const NO_POS_UVS: u8 = 4;
    /// Stippling bit: no UV indices for the back.
    pub const NO_NEG_UVS: u8 = 8;
    /// The fewest points of a polygon that is used for anything (G15).
    pub const MIN_POINTS: usize = 3;
    /// Bytes of a polygon without points.
    pub(crate) const MIN_SIZE: usize = 12;

    /// Which sides there are; `None` for a value the format does not define.
    pub fn sides(&self) -> Option<Sides> {
        match self.sides_type {
            0 => Some(Sides::Single),
            1 => Some(Sides::BothAlike),
            2 => Some(Sides::BothDifferent),
            _ => None,
        }
    }

    /// The back's surface index after rule G2: the front's when both sides are alike.
    pub fn negative_surface(&self) -> i16 {
        if self.sides_type == 1 {
            self.pos_surface
        } else {
            self.neg_surface
        }
    }

    /// The back's UV indices after rule G2: the front's when both sides are alike.
    pub fn negative_uv(&self) -> &[u8] {
        if self.sides_type == 1 {
            &self.pos_uv
        } else {
            &self.neg_uv
        }
    }

    /// Whether the polygon has points enough to be drawn, collided with or used as an opening (G15).
    pub fn is_usable(&self) -> bool {
        self.vertex_ids.len() >= Self::MIN_POINTS
    }

    fn stores_pos_uv(&self) -> bool {
        self.stippling & Self::NO_POS_UVS == 0
    }

    fn stores_neg_uv(&self) -> bool {
        self.sides_type == 2 && self.stippling & Self::NO_NEG_UVS == 0
    }

    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u16("polygon.id")?;
        let [num_pts, stippling] = reader.array("polygon.num_pts")?;
        let mut polygon = Self {
            id,
            stippling,
            sides_type: reader.i32("polygon.sides_type")?,
            pos_surface: reader.i16("polygon.pos_surface")?,
            neg_surface: reader.i16("polygon.neg_surface")?,
            vertex_ids: reader.u16s(usize::from(num_pts), "polygon.vertex_ids")?,
            pos_uv: Vec::new(),
            neg_uv: Vec::new(),
        };
        if polygon.stores_pos_uv() {
            polygon.pos_uv = reader.take(usize::from(num_pts), "polygon.pos_uv")?.to_vec();
        }
        if polygon.stores_neg_uv() {
            polygon.neg_uv = reader.take(usize::from(num_pts), "polygon.neg_uv")?.to_vec();
        }
        Ok(polygon)
    }

    pub(crate) fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        let points = self.vertex_ids.len();
        writer.u16(self.id);
        writer.count8(points, "polygon.num_pts")?;
        writer.u8(self.stippling);
        writer.i32(self.sides_type);
        writer.i16(self.pos_surface);
        writer.i16(self.neg_surface);
        writer.u16s(&self.vertex_ids);
        let wanted = if self.stores_pos_uv() { points } else { 0 };
        let what = "as many UV indices as points when stippling asks for them, else none";
        writer.require(self.pos_uv.len() == wanted, "polygon.pos_uv", what)?;
        writer.bytes(&self.pos_uv);
        let wanted = if self.stores_neg_uv() { points } else { 0 };
        writer.require(self.neg_uv.len() == wanted, "polygon.neg_uv", what)?;
        writer.bytes(&self.neg_uv);
        Ok(())
    }

    /// A listc of polygons.
    pub(crate) fn read_list(
        reader: &mut Reader<'_>,
        field: &'static str,
    ) -> Result<(Vec<Self>, CompressedForm), RecordError> {
        let (count, form) = reader.count_compressed(Self::MIN_SIZE, field)?;
        Ok((reader.items(count, Self::read)?, form))
    }

    pub(crate) fn write_all(polygons: &[Self], writer: &mut Writer) -> Result<(), RecordError> {
        polygons.iter().try_for_each(|polygon| polygon.write(writer))
    }
}

/// The first polygon with this id (G10; a second one with the same id is not used, G15). A linear search: build an
/// index where many are looked up.
pub fn find_polygon(polygons: &[Polygon], id: u16) -> Option<&Polygon> {
    polygons.iter().find(|polygon| polygon.id == id)
}
