//! Cell and landblock ids (`world.md` 1) and the global land-cell grid (`world.md` 3, retail `LandDefs`).

use core::fmt;
use core::str::FromStr;

use glam::Vec3;

use crate::constants::{BLOCK_LENGTH, BLOCK_SIDE_CELLS, EPSILON, MAP_SIDE_CELLS, SQUARE_LENGTH};

/// A cell id `0xXXYYLLLL`: landblock east index, landblock north index, cell in the landblock (`world.md` 1).
///
/// The low word is 0x0001-0x0040 for the 64 land cells (x-major), 0x0100-0xFFFD for env cells, 0xFFFF for
/// "somewhere outdoors in this landblock". Id 0 as a whole means "no cell".
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct CellId(pub u32);

/// A landblock: the high word of a cell id, `0xXXYY`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct BlockId(pub u16);

/// A global land-cell coordinate (retail `lcoord`), 0…2039 on both axes when inside the map; +x east, +y north.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LandCoord {
    /// Land cells east of the map's south-west corner.
    pub x: i32,
    /// Land cells north of the map's south-west corner.
    pub y: i32,
}

impl CellId {
    /// No cell.
    pub const NONE: CellId = CellId(0);

    /// The cell `low` of landblock `block`.
    pub const fn new(block: BlockId, low: u16) -> Self {
        CellId((block.0 as u32) << 16 | low as u32)
    }

    /// The landblock the cell belongs to, and whose frame its positions use.
    #[inline]
    pub const fn block(self) -> BlockId {
        BlockId((self.0 >> 16) as u16)
    }

    /// The cell's number inside its landblock.
    #[inline]
    pub const fn low(self) -> u16 {
        self.0 as u16
    }

    /// Whether this is no cell at all.
    #[inline]
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// Whether the low word names an indoor cell (`world.md` I1): `low >= 0x100`, tested on the low word alone.
    #[inline]
    pub const fn is_indoor(self) -> bool {
        self.low() >= 0x100
    }

    /// Whether the low word is one a position may carry (`world.md` I2).
    pub const fn has_valid_low(self) -> bool {
        matches!(self.low(), 1..=0x40 | 0x100..=0xFFFD | 0xFFFF)
    }

    /// Whether this is an env cell id proper (0x0100-0xFFFD), not 0xFFFE or 0xFFFF.
    pub const fn is_env_cell(self) -> bool {
        matches!(self.low(), 0x100..=0xFFFD)
    }

    /// Whether this is one of the 64 land cells of a block.
    pub const fn is_land_cell(self) -> bool {
        matches!(self.low(), 1..=0x40)
    }

    /// Retail `inbound_valid_cellid` (`world.md` M1): a usable low word in a landblock of the map.
    pub fn is_inbound_valid(self) -> bool {
        self.has_valid_low() && self.block().is_on_map()
    }

    /// The global land-cell coordinate of an outdoor cell of the map (retail `gid_to_lcoord`), else `None`.
    #[inline]
    pub fn land_coord(self) -> Option<LandCoord> {
        if !self.is_land_cell() || !self.block().is_on_map() {
            return None;
        }
        let cell = i32::from(self.low()) - 1;
        let base = self.block().corner();
        Some(LandCoord {
            x: base.x + (cell >> 3),
            y: base.y + (cell & 7),
        })
    }

    /// The land cell that contains the landblock-frame point `p`, whose coordinates may lie outside the block
    /// (retail `get_outside_lcoord`, `world.md` M2). The low word plays no part beyond having to be valid.
    #[inline]
    pub fn outside_land_coord(self, p: Vec3) -> Option<LandCoord> {
        if !self.has_valid_low() {
            return None;
        }
        let base = self.block().corner();
        LandCoord {
            x: base.x.saturating_add(floor_cells(p.x)?),
            y: base.y.saturating_add(floor_cells(p.y)?),
        }
        .in_bounds()
    }

    /// Retail `adjust_to_outside` (`world.md` M3): the land cell under or above `p` and `p` re-based to its
    /// landblock. `p` is in the frame of this id's landblock, metres. `None` when the point is off the map or
    /// not finite.
    #[inline]
    pub fn adjust_to_outside(self, mut p: Vec3) -> Option<(CellId, Vec3)> {
        if !self.has_valid_low() {
            return None;
        }
        if p.x.abs() < EPSILON {
            p.x = 0.0;
        }
        if p.y.abs() < EPSILON {
            p.y = 0.0;
        }
        let id = self.outside_land_coord(p)?.cell_id();
        p.x -= BLOCK_LENGTH * libm::floorf(p.x / BLOCK_LENGTH);
        p.y -= BLOCK_LENGTH * libm::floorf(p.y / BLOCK_LENGTH);
        Some((id, p))
    }
}

/// Whole land cells in `metres`, towards minus infinity; `None` for what no map can hold (NaN, infinities).
#[inline]
fn floor_cells(metres: f32) -> Option<i32> {
    let cells = libm::floorf(metres / SQUARE_LENGTH);
    if cells.abs() < 1.0e7 {
        Some(cells as i32)
    } else {
        None
    }
}

impl BlockId {
    /// The landblock at east index `x` and north index `y`.
    pub const fn new(x: u8, y: u8) -> Self {
        BlockId((x as u16) << 8 | y as u16)
    }

    /// East index, 0…254 on the map.
    #[inline]
    pub const fn x(self) -> u8 {
        (self.0 >> 8) as u8
    }

    /// North index, 0…254 on the map.
    #[inline]
    pub const fn y(self) -> u8 {
        self.0 as u8
    }

    /// Whether both indices lie on the 255 x 255 map (`world.md` I3).
    pub const fn is_on_map(self) -> bool {
        self.x() != 0xFF && self.y() != 0xFF
    }

    /// The land-cell coordinate of the block's south-west cell (retail `blockid_to_lcoord`, without its bounds
    /// test: see [`BlockId::is_on_map`]).
    #[inline]
    pub const fn corner(self) -> LandCoord {
        LandCoord {
            x: self.x() as i32 * BLOCK_SIDE_CELLS,
            y: self.y() as i32 * BLOCK_SIDE_CELLS,
        }
    }

    /// Id of the block's LandBlock record.
    pub const fn land_block_record(self) -> u32 {
        (self.0 as u32) << 16 | 0xFFFF
    }

    /// Id of the block's LandBlockInfo record.
    pub const fn info_record(self) -> u32 {
        (self.0 as u32) << 16 | 0xFFFE
    }

    /// The block `dx` to the east and `dy` to the north, if it is on the map.
    pub fn neighbour(self, dx: i32, dy: i32) -> Option<BlockId> {
        let x = u8::try_from(i32::from(self.x()) + dx).ok()?;
        let y = u8::try_from(i32::from(self.y()) + dy).ok()?;
        let id = BlockId::new(x, y);
        id.is_on_map().then_some(id)
    }
}

impl LandCoord {
    /// Itself when it lies on the map (retail `in_bounds`).
    #[inline]
    pub fn in_bounds(self) -> Option<Self> {
        let range = 0..MAP_SIDE_CELLS;
        (range.contains(&self.x) && range.contains(&self.y)).then_some(self)
    }

    /// Id of the land cell here (retail `lcoord_to_gid`). Must be on the map; [`CellId::NONE`] otherwise.
    #[inline]
    pub fn cell_id(self) -> CellId {
        if self.in_bounds().is_none() {
            return CellId::NONE;
        }
        let (x, y) = (self.x as u32, self.y as u32);
        CellId((x >> 3) << 24 | (y >> 3) << 16 | (1 + ((x & 7) << 3) + (y & 7)))
    }

    /// The landblock here (retail `get_block_gid`), `None` off the map.
    pub fn block(self) -> Option<BlockId> {
        self.in_bounds()
            .map(|c| BlockId::new((c.x >> 3) as u8, (c.y >> 3) as u8))
    }
}

/// What to add to a point in the frame of `b`'s landblock to express it in the frame of `a`'s, metres
/// (retail `get_block_offset`, `world.md` 3): zero within one block, else multiples of 192 on x and y.
#[inline]
pub fn block_offset(a: BlockId, b: BlockId) -> Vec3 {
    if a == b {
        return Vec3::ZERO;
    }
    let (from, to) = (a.corner(), b.corner());
    Vec3::new(
        (to.x - from.x) as f32 * SQUARE_LENGTH,
        (to.y - from.y) as f32 * SQUARE_LENGTH,
        0.0,
    )
}

impl fmt::Display for CellId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{:08X}", self.0)
    }
}

impl fmt::Debug for CellId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for BlockId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{:04X}", self.0)
    }
}

impl fmt::Debug for BlockId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// A text that is not a cell id.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{text}' is not a cell id: write eight hexadecimal digits, as 0xA9B40170")]
pub struct ParseCellIdError {
    text: String,
}

impl FromStr for CellId {
    type Err = ParseCellIdError;

    /// Reads `0xA9B40170` or `A9B40170`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let digits = text
            .strip_prefix("0x")
            .or_else(|| text.strip_prefix("0X"))
            .unwrap_or(text);
        if digits.len() == 8
            && digits.bytes().all(|b| b.is_ascii_hexdigit())
            && let Ok(id) = u32::from_str_radix(digits, 16)
        {
            return Ok(CellId(id));
        }
        Err(ParseCellIdError {
            text: text.to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coord(x: i32, y: i32) -> LandCoord {
        LandCoord { x, y }
    }

    #[test]
    fn example_22_1_lcoord_to_gid() {
        for (x, y, id) in [
            (0, 0, 0x0000_0001),
            (2039, 2039, 0xFEFE_0040),
            (1352, 1440, 0xA9B4_0001),
            (1353, 1440, 0xA9B4_0009),
            (1359, 1447, 0xA9B4_0040),
            (2040, 0, 0),
        ] {
            assert_eq!(coord(x, y).cell_id(), CellId(id), "{x} {y}");
        }
    }

    #[test]
    fn example_22_2_gid_to_lcoord() {
        assert_eq!(CellId(0xA9B4_0008).land_coord(), Some(coord(1352, 1447)));
        for id in [0xA9B4_0100, 0xA9B4_FFFF, 0xFF00_0001, 0xA9B4_0041, 0xA9B4_0000] {
            assert_eq!(CellId(id).land_coord(), None, "{id:08X}");
        }
    }

    #[test]
    fn example_22_3_valid_low() {
        for low in [0x0001, 0x0040, 0x0100, 0xFFFD, 0xFFFF] {
            assert!(CellId(low).has_valid_low(), "{low:04X}");
        }
        for low in [0x0000, 0x0041, 0x00FF, 0xFFFE] {
            assert!(!CellId(low).has_valid_low(), "{low:04X}");
        }
    }

    fn adjust(id: u32, x: f32, y: f32) -> Option<(u32, f32, f32)> {
        CellId(id).adjust_to_outside(Vec3::new(x, y, 3.0)).map(|(id, p)| {
            assert_eq!(p.z, 3.0);
            (id.0, p.x, p.y)
        })
    }

    #[test]
    fn examples_22_4_to_22_9_adjust_to_outside() {
        assert_eq!(adjust(0xA9B4_0001, 30.0, 5.0), Some((0xA9B4_0009, 30.0, 5.0)));
        assert_eq!(adjust(0xA9B4_0001, -0.5, 5.0), Some((0xA8B4_0039, 191.5, 5.0)));
        assert_eq!(adjust(0xA9B4_0001, -0.0001, 5.0), Some((0xA9B4_0001, 0.0, 5.0)));
        assert_eq!(adjust(0xA9B4_0001, 192.0, 0.0), Some((0xAAB4_0001, 0.0, 0.0)));
        assert_eq!(
            adjust(0xA9B4_0001, 191.999, 191.999),
            Some((0xA9B4_0040, 191.999, 191.999))
        );
        assert_eq!(
            adjust(0xA9B4_0170, 155.343, 15.134),
            Some((0xA9B4_0031, 155.343, 15.134))
        );
        assert_eq!(
            adjust(0xA9B4_0100, -30.0, -200.0),
            Some((0xA8B2_0038, 162.0, 184.0))
        );
        assert_eq!(adjust(0x0000_0001, -1.0, 5.0), None);
        assert_eq!(adjust(0x00FE_0001, 10.0, 192.0), None);
        assert_eq!(adjust(0xFE01_0008, 191.9, 200.0), Some((0xFE02_0039, 191.9, 8.0)));
        assert_eq!(adjust(0xFF00_0001, -1.0, 5.0), Some((0xFE00_0039, 191.0, 5.0)));
        assert_eq!(adjust(0xFF00_0001, 1.0, 5.0), None);
        assert_eq!(adjust(0xA9B4_FFFF, 100.0, 60.0).map(|r| r.0), Some(0xA9B4_0023));
    }

    #[test]
    fn adjust_to_outside_refuses_what_is_not_a_number() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3.0e38] {
            assert_eq!(adjust(0xA9B4_0001, bad, 1.0), None);
            assert_eq!(adjust(0xA9B4_0001, 1.0, bad), None);
        }
    }

    #[test]
    fn example_22_10_block_offset() {
        let offset = |a: u32, b: u32| block_offset(CellId(a).block(), CellId(b).block());
        assert_eq!(offset(0xA9B4_0001, 0xA9B4_0170), Vec3::ZERO);
        assert_eq!(offset(0xA9B4_0001, 0xAAB4_0001), Vec3::new(192.0, 0.0, 0.0));
        assert_eq!(offset(0xAAB4_0001, 0xA9B4_0001), Vec3::new(-192.0, 0.0, 0.0));
        assert_eq!(offset(0xA9B4_0001, 0xA8B5_0040), Vec3::new(-192.0, 192.0, 0.0));
        assert_eq!(offset(0x0000_0001, 0xFEFE_0001), Vec3::new(48768.0, 48768.0, 0.0));
    }

    #[test]
    fn cell_ids_read_and_print() {
        assert_eq!("0xA9B40170".parse(), Ok(CellId(0xA9B4_0170)));
        assert_eq!(CellId(0xA9B4_0170).to_string(), "0xA9B40170");
        for bad in ["", "0x", "0xA9B4017", "0xA9B401700", "0xA9B4017g", "+A9B4017"] {
            assert!(bad.parse::<CellId>().is_err(), "{bad}");
        }
    }
}
