//! Plans of dungeons: rooms on a grid of several levels, joined by doors and ramps.

use std::collections::BTreeMap;

use super::Draws;

/// Directions of doors: north, east, south, west.
pub(super) const SIDES: [(i32, i32); 4] = [(0, 1), (1, 0), (0, -1), (-1, 0)];
/// Doors for every hundred cells, each counted once (`evidence.md` E3: 2.55 portals a cell).
const LINKS_PER_100: usize = 127;

/// What a cell is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// A room; its doors follow from its links.
    Room,
    /// A passage that rises one level towards a side.
    Ramp(u8),
}

/// A cell of the plan.
#[derive(Clone, Debug)]
pub(super) struct Spot {
    /// Column, row, level.
    pub(super) at: (i32, i32, i32),
    pub(super) shape: Shape,
    /// The cell behind the door of each side.
    pub(super) links: [Option<u16>; 4],
}

impl Spot {
    /// The sides with doors as bits.
    pub(super) fn doors(&self) -> u8 {
        (0..4)
            .map(|side| u8::from(self.links[side].is_some()) << side)
            .sum()
    }

    /// Position of a side's door among the cell's portals.
    pub(super) fn portal(&self, side: usize) -> Option<i16> {
        self.links[side].map(|_| self.links[..side].iter().flatten().count() as i16)
    }

    /// The side that leads to a cell.
    pub(super) fn side_to(&self, other: u16) -> Option<usize> {
        self.links.iter().position(|&link| link == Some(other))
    }
}

/// A plan.
pub(super) struct Dungeon {
    pub(super) spots: Vec<Spot>,
}

impl Dungeon {
    /// Grows a plan of exactly `count` cells (at least one).
    pub(super) fn grow(count: usize, draws: &mut Draws) -> Self {
        let mut grid: BTreeMap<(i32, i32, i32), u16> = BTreeMap::new();
        let room = |at| Spot {
            at,
            shape: Shape::Room,
            links: [None; 4],
        };
        let mut spots = vec![room((0, 0, 0))];
        grid.insert((0, 0, 0), 0);
        while spots.len() < count {
            let newest = draws.below(100) < 55;
            let span = if newest { spots.len().min(6) } else { spots.len() };
            let from = spots.len() - 1 - draws.below(span as u32) as usize;
            if spots[from].shape != Shape::Room {
                continue;
            }
            let side = draws.below(4) as usize;
            let (dx, dy) = SIDES[side];
            let (x, y, z) = spots[from].at;
            let (near, far) = ((x + dx, y + dy), (x + 2 * dx, y + 2 * dy));
            if count - spots.len() >= 2 && draws.below(100) < 6 {
                // A ramp stands on its lower level and reaches into the upper.
                let up = draws.below(2) == 0;
                let low = if up { z } else { z - 1 };
                let end = (far.0, far.1, if up { z + 1 } else { z - 1 });
                let body = [(near.0, near.1, low), (near.0, near.1, low + 1)];
                if body.iter().chain([&end]).any(|at| grid.contains_key(at)) {
                    continue;
                }
                let index = spots.len() as u16;
                for at in body {
                    grid.insert(at, index);
                }
                grid.insert(end, index + 1);
                let rises = if up { side } else { (side + 2) % 4 };
                spots.push(Spot {
                    at: body[0],
                    shape: Shape::Ramp(rises as u8),
                    links: [None; 4],
                });
                spots.push(room(end));
                link(&mut spots, from, side, usize::from(index));
                link(&mut spots, usize::from(index), side, usize::from(index) + 1);
            } else if let std::collections::btree_map::Entry::Vacant(e) = grid.entry((near.0, near.1, z)) {
                let index = spots.len();
                e.insert(index as u16);
                spots.push(room((near.0, near.1, z)));
                link(&mut spots, from, side, index);
            }
        }
        // Loops: doors between rooms that are neighbours already.
        let mut loops: Vec<(usize, usize, usize)> = Vec::new();
        for (a, spot) in spots.iter().enumerate() {
            for side in 0..2 {
                let (x, y, z) = spot.at;
                let next = (x + SIDES[side].0, y + SIDES[side].1, z);
                if let (Shape::Room, None, Some(&b)) = (spot.shape, spot.links[side], grid.get(&next))
                    && spots[usize::from(b)].shape == Shape::Room
                {
                    loops.push((a, side, usize::from(b)));
                }
            }
        }
        let wanted = (count * LINKS_PER_100 / 100).saturating_sub(count - 1);
        for _ in 0..wanted.min(loops.len()) {
            let (a, side, b) = loops.swap_remove(draws.below(loops.len() as u32) as usize);
            link(&mut spots, a, side, b);
        }
        Dungeon { spots }
    }

    /// The cells within three doors of a cell, nearest first, at most forty.
    pub(super) fn near(&self, from: usize) -> Vec<u16> {
        let mut out = vec![from as u16];
        let mut start = 0;
        for _ in 0..3 {
            let end = out.len();
            for i in start..end {
                for &next in self.spots[usize::from(out[i])].links.iter().flatten() {
                    if !out.contains(&next) && out.len() <= 40 {
                        out.push(next);
                    }
                }
            }
            start = end;
        }
        out.remove(0);
        out
    }
}

fn link(spots: &mut [Spot], a: usize, side: usize, b: usize) {
    spots[a].links[side] = Some(b as u16);
    spots[b].links[(side + 2) % 4] = Some(a as u16);
}
