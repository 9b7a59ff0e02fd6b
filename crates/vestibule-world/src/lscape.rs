//! The landscape window around a load point (`world.md` 4.4 and 17.2, retail `LScape`).

use crate::ids::BlockId;

/// Blocks on each side of the load point's block that retail keeps by default (`world.md` 17.2 L1).
pub const DEFAULT_RADIUS: u8 = 5;

/// A square of landblocks around the block of the load point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LandscapeWindow {
    /// The load point's block, in the middle.
    pub center: BlockId,
    /// Blocks on each side of it, at least 1.
    pub radius: u8,
}

impl LandscapeWindow {
    /// A window of retail's default size.
    pub fn new(center: BlockId) -> Self {
        LandscapeWindow {
            center,
            radius: DEFAULT_RADIUS,
        }
    }

    /// Blocks along one side.
    pub fn side(&self) -> usize {
        2 * usize::from(self.radius) + 1
    }

    /// Column, row and slot of a block; `None` outside the window (`world.md` 17.2 L4).
    pub fn slot_of(&self, block: BlockId) -> Option<(usize, usize, usize)> {
        let place = |b: u8, c: u8| usize::try_from(i32::from(b) - i32::from(c) + i32::from(self.radius)).ok();
        let (column, row) = (
            place(block.x(), self.center.x())?,
            place(block.y(), self.center.y())?,
        );
        let side = self.side();
        (column < side && row < side).then_some((column, row, column * side + row))
    }

    /// The blocks of the window that are on the map, column by column.
    pub fn blocks(&self) -> impl Iterator<Item = BlockId> + '_ {
        let r = i32::from(self.radius);
        (-r..=r).flat_map(move |dx| (-r..=r).filter_map(move |dy| self.center.neighbour(dx, dy)))
    }

    /// The detail scale of a block of the window.
    pub fn detail_scale_of(&self, block: BlockId) -> u32 {
        let apart = |a: u8, b: u8| u32::from(a.abs_diff(b));
        detail_scale(apart(block.x(), self.center.x()).max(apart(block.y(), self.center.y())))
    }
}

/// Every how many vertices a block `blocks_away` is drawn (`world.md` 4.4); 1 is full detail, which alone has
/// land cells with ids, objects and buildings.
pub fn detail_scale(blocks_away: u32) -> u32 {
    match blocks_away {
        0 | 1 => 1,
        2 => 2,
        3 | 4 => 4,
        _ => 8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn example_22_34_slots() {
        let window = LandscapeWindow::new(BlockId(0xA9B4));
        assert_eq!(window.slot_of(BlockId(0xA9B4)), Some((5, 5, 60)));
        assert_eq!(window.slot_of(BlockId(0xAEB9)), Some((10, 10, 120)));
        assert_eq!(window.slot_of(BlockId(0xA4AF)), Some((0, 0, 0)));
        assert_eq!(window.slot_of(BlockId(0xAFB4)), None);
        assert_eq!(window.blocks().count(), 121);
        assert_eq!(
            LandscapeWindow::new(BlockId(0x0000)).blocks().count(),
            36,
            "off the map stays empty"
        );
    }

    #[test]
    fn example_22_35_detail_scale() {
        assert_eq!([0, 1, 2, 3, 4, 5, 6].map(detail_scale), [1, 1, 2, 4, 4, 8, 8]);
    }
}
