//! Where on a landblock's land there is nothing but ground: squares that spheres of the usual sizes may be in at any
//! height without touching a static object, a building's shell or a room behind its portals, worked out with the shadow
//! lists.

use glam::{Vec2, Vec3};

use crate::constants::SQUARE_LENGTH;
use crate::geometry::BoundingBox;
use crate::ids::CellId;
use crate::landblock::{LAND_CELLS, Landblock};
use crate::lanes::Lanes;
use crate::shadow::{StaticReach, box_around, corners_of};
use crate::shape::Building;
use crate::terrain::{LandCell, Water};
use crate::world::World;

/// Radius of the spheres that squares are for, metres.
const RADIUS: f32 = 0.5;
/// Squares to a side of a land cell: a bit each makes 64.
const SIDE: usize = 8;
/// Length of a square, metres.
const LENGTH: f32 = SQUARE_LENGTH / SIDE as f32;
/// Many times the rounding of coordinates inside a landblock, metres.
const SLACK: f32 = 0.02;

/// Open ground of a landblock.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct OpenGround {
    /// Land cells that are open all over, for spheres of any size, one bit each.
    bare: u64,
    /// For each land cell its open squares, one bit each, x-major from the south-west.
    squares: Box<[u64]>,
}

impl OpenGround {
    /// Whether spheres that the land cell certainly holds are over open ground. Radii are in the fourth lanes.
    #[inline(always)]
    pub(crate) fn holds(&self, id: CellId, cell: &LandCell, [foot, head]: [Lanes; 2]) -> bool {
        let index = u32::from(id.low()).wrapping_sub(1);
        let Some(bare) = self.bare.checked_shr(index) else {
            return false;
        };
        if bare & 1 != 0 {
            return true;
        }
        let usual = foot.fourth() <= RADIUS && head.fourth() <= RADIUS && head.has_xy_of(foot);
        let Some(squares) = self.squares.get(index as usize) else {
            return false;
        };
        let at = cell.in_square(foot);
        let square = |k: usize| (at.lane(k) / LENGTH) as u32 & (SIDE as u32 - 1);
        usual && squares >> (SIDE as u32 * square(0) + square(1)) & 1 != 0
    }

    /// `reaches` has the static objects of a land cell.
    pub(crate) fn build<'l>(
        world: &World,
        block: &Landblock,
        reaches: impl Fn(CellId) -> &'l [StaticReach],
    ) -> Self {
        let mut found = OpenGround {
            bare: 0,
            squares: [0; LAND_CELLS].into(),
        };
        let Some(land) = block.land.as_ref().filter(|land| land.water != Water::Entirely) else {
            return found;
        };
        let cells = (1u16..).map(|low| CellId::new(block.id, low)).zip(&land.cells);
        for ((id, cell), (index, squares)) in cells.zip(found.squares.iter_mut().enumerate()) {
            let reaches = reaches(id);
            let building = cell.building.map(|i| block.buildings.get(usize::from(i)));
            if cell.restriction.is_some() {
                continue;
            }
            if building.is_none() && reaches.is_empty() {
                found.bare |= 1 << index;
                *squares = u64::MAX;
                continue;
            }
            *squares = squares_of(cell, |square| {
                reaches.iter().all(|reach| {
                    let r = reach.sphere.radius;
                    let around = r + reach.stretch * RADIUS;
                    r < 0.0
                        || square.is_beyond(reach.sphere.center, around)
                        || square.is_beside(&reach.bounds, RADIUS)
                }) && building.is_none_or(|b| b.is_some_and(|b| is_beyond_building(world, &square, b)))
            });
        }
        found
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.squares)
    }
}

/// A square of a land cell with the room for rounding around it, in the frame of the landblock.
struct Square {
    min: Vec2,
    max: Vec2,
}

impl Square {
    /// Whether all of it is farther than `distance` from a point, seen from above.
    fn is_beyond(&self, p: Vec3, distance: f32) -> bool {
        let p = p.truncate();
        let away = p - p.clamp(self.min, self.max);
        away.dot(away) > distance * distance
    }

    /// Whether all of it is farther than `distance` from a box, seen from above.
    fn is_beside(&self, b: &BoundingBox, distance: f32) -> bool {
        let (min, max) = (b.min.truncate() - distance, b.max.truncate() + distance);
        self.max.cmplt(min).any() || self.min.cmpgt(max).any()
    }
}

/// The squares of a land cell that pass a test.
fn squares_of(cell: &LandCell, is_open: impl Fn(Square) -> bool) -> u64 {
    let corner = cell.polygons[0].vertices[0].truncate();
    let mut bits = 0;
    for i in 0..SIDE {
        for j in 0..SIDE {
            let min = corner + Vec2::new(i as f32, j as f32) * LENGTH;
            let square = Square {
                min: min - Vec2::splat(SLACK),
                max: min + Vec2::splat(LENGTH + SLACK),
            };
            bits |= u64::from(is_open(square)) << (SIDE * i + j);
        }
    }
    bits
}

/// Whether spheres in a square touch neither a building's shell nor a room behind one of its portals.
fn is_beyond_building(world: &World, square: &Square, building: &Building) -> bool {
    let (min, max) = (square.min, square.max);
    let corners = [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)];
    let rooms = building.portals.iter().all(|portal| {
        let room = world.env_cell(portal.other);
        room.is_some_and(|room| room.hints.keeps_away_columns(&corners, RADIUS))
    });
    let (Some(part), Some(frame)) = (building.shape.parts.first(), building.part_frames.first()) else {
        return rooms;
    };
    let model = part.model.as_ref();
    let Some((bsp, bound)) = model.and_then(|m| m.physics.as_ref().zip(m.physics_sphere)) else {
        return rooms;
    };
    let reach = bound.radius + RADIUS + SLACK;
    let shell = box_around(&corners_of(bsp, frame, 1.0), Vec3::ZERO);
    let beyond =
        square.is_beyond(frame.local_to_global(bound.center), reach) || square.is_beside(&shell, RADIUS);
    rooms && part.scale.z == 1.0 && beyond
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Sphere;
    use crate::ids::LandCoord;
    use crate::terrain::{TerrainWord, build_land_cells};

    #[test]
    fn squares_near_an_object_are_not_open() {
        let cells = build_land_cells(LandCoord { x: 0, y: 0 }, &[0.0; 81], &[TerrainWord(1); 81]);
        let (id, cell) = (CellId(0x0000_000A), &cells[9]);
        let object = Vec3::new(34.0, 30.0, 5.0);
        let ground = OpenGround {
            bare: 1,
            squares: cells
                .iter()
                .map(|c| squares_of(c, |square| square.is_beyond(object, 1.0 + RADIUS)))
                .collect(),
        };
        let at = |x: f32, y: f32, r: f32| Sphere::new(Vec3::new(x, y, 700.0), r).into();
        let mut open = 0;
        for i in 0..96 {
            for j in 0..96 {
                let (x, y) = (24.1 + 0.25 * i as f32, 24.1 + 0.25 * j as f32);
                let holds = ground.holds(id, cell, [at(x, y, 0.5); 2]);
                let away = (Vec2::new(x, y) - object.truncate()).length();
                assert!(!holds || away > 1.5, "{x} {y}");
                assert!(holds || away < 1.5 + 2.0 * LENGTH, "{x} {y}");
                open += u32::from(holds);
                assert!(!ground.holds(id, cell, [at(x, y, 0.5), at(x, y, 0.6)]));
                assert!(!ground.holds(id, cell, [at(x, y, 0.5), at(x + 0.1, y, 0.5)]));
            }
        }
        assert!(open > 6000, "{open}");
        // Where there is nothing at all, size does not matter.
        assert!(ground.holds(CellId(1), &cells[0], [at(12.0, 12.0, 5.0), at(9.0, 12.0, 6.0)]));
        assert!(!ground.holds(CellId(0x0000_0100), cell, [at(24.1, 24.1, 0.5); 2]));
    }
}
