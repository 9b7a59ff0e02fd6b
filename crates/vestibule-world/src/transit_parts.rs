//! Which cells the parts of an object reach (`world.md` 10.2, 11.2, 12 D2 and H3).

use glam::Vec3;

use crate::cell_array::CellArray;
use crate::constants::{EPSILON, SQUARE_LENGTH};
use crate::env_cell::{CellPortal, EnvCell, PortalTarget};
use crate::frame::Frame;
use crate::geometry::{BoundingBox, Side, Sphere};
use crate::ids::{BlockId, CellId, block_offset};
use crate::transit::add_outside_cell;
use crate::world::World;

/// A part of an object as the cell tests see it. Box and sphere are part-local and **unscaled**, whatever the
/// part's scale (`world.md` Q2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartBounds {
    /// Part to landblock frame of the object's cell.
    pub frame: Frame,
    /// Physics sphere of the part, else its drawing sphere; parts without one are skipped by portal tests.
    pub sphere: Option<Sphere>,
    /// Box of the part's vertices.
    pub bounds: BoundingBox,
}

impl PartBounds {
    /// Centre of the sphere in `target`'s local frame. `offset` re-bases the part to the target's landblock.
    fn center_in(&self, sphere: &Sphere, offset: Vec3, target: &Frame) -> Vec3 {
        target.global_to_local(self.frame.local_to_global(sphere.center) + offset)
    }

    fn box_in(&self, offset: Vec3, target: &Frame) -> BoundingBox {
        self.bounds
            .mapped(|p| target.global_to_local(self.frame.local_to_global(p) + offset))
    }

    fn box_in_block(&self, offset: Vec3) -> BoundingBox {
        self.bounds.mapped(|p| self.frame.local_to_global(p) + offset)
    }
}

/// Rebuilds `array` with the cells the parts of an object in `own` reach (retail `find_bbox_cell_list`,
/// `world.md` H3): no spheres, no prune. Part frames are in the frame of `own`'s landblock.
pub fn find_bbox_cell_list(world: &World, own: CellId, parts: &[PartBounds], array: &mut CellArray) {
    array.clear();
    array.add(own, world.is_resident(own));
    let mut i = 0;
    while let Some(entry) = array.get(i) {
        if entry.resident {
            if let Some(cell) = world.env_cell(entry.id) {
                from_env_cell(world, cell, own, parts, array);
            } else if entry.id.is_land_cell() {
                add_all_outside_cells_of_parts(world, own, parts, array);
                into_building(world, entry.id, own, parts, array);
            }
        }
        i += 1;
    }
}

/// `world.md` 10.2.
fn from_env_cell(world: &World, cell: &EnvCell, own: CellId, parts: &[PartBounds], array: &mut CellArray) {
    let offset = block_offset(cell.id.block(), own.block());
    let mut check_outside = false;
    for portal in &cell.portals {
        for part in parts {
            let Some(sphere) = &part.sphere else { continue };
            let reach = sphere.radius + EPSILON;
            let dist = portal.plane.dist(part.center_in(sphere, offset, &cell.frame));
            if if portal.interior_is_negative {
                dist < -reach
            } else {
                dist > reach
            } {
                continue;
            }
            let side = part.box_in(offset, &cell.frame).side_of(&portal.plane);
            if side == interior_side(portal) {
                continue;
            }
            match portal.other {
                PortalTarget::Outside => check_outside = true,
                PortalTarget::Cell(id) => match world.env_cell(id) {
                    None => array.add(id, false),
                    Some(other) if part_meets(part, own.block(), other) => array.add(id, true),
                    Some(_) => continue,
                },
            }
            break;
        }
    }
    if check_outside {
        add_all_outside_cells_of_parts(world, own, parts, array);
    }
}

fn interior_side(portal: &CellPortal) -> Side {
    if portal.interior_is_negative {
        Side::Negative
    } else {
        Side::Positive
    }
}

/// The box test of `world.md` 9.3 in the frame of `cell`.
fn part_meets(part: &PartBounds, from: BlockId, cell: &EnvCell) -> bool {
    let offset = block_offset(cell.id.block(), from);
    cell.structure
        .cell_bsp
        .meets_box(&part.box_in(offset, &cell.frame).corners())
}

/// `world.md` 11.2: a block of land cells around the first part.
fn add_all_outside_cells_of_parts(world: &World, own: CellId, parts: &[PartBounds], array: &mut CellArray) {
    if array.added_outside {
        return;
    }
    array.added_outside = true;
    let Some(first) = parts.first() else { return };
    let Some((base, _)) = own.adjust_to_outside(first.frame.origin) else {
        return;
    };
    let Some(coord) = base.land_coord() else { return };
    if !world.is_resident(base) {
        return;
    }
    let offset = block_offset(base.block(), own.block());
    let (bx, by) = (coord.x & 7, coord.y & 7);
    let (mut min, mut max) = ((0, 0), (0, 0));
    for part in parts {
        let hull = part.box_in_block(offset);
        // A box of a damaged model may lie at the end of the numbers.
        let cell = |v: f32, base: i32| (libm::floorf(v / SQUARE_LENGTH) as i32).saturating_sub(base);
        min = (min.0.min(cell(hull.min.x, bx)), min.1.min(cell(hull.min.y, by)));
        max = (max.0.max(cell(hull.max.x, bx)), max.1.max(cell(hull.max.y, by)));
    }
    // A box wider than the map reaches every cell there is and no more.
    let span = |lo: i32, hi: i32, at: i32| (at.saturating_add(lo).max(0), at.saturating_add(hi).min(2039));
    let (x0, x1) = span(min.0, max.0, coord.x);
    let (y0, y1) = span(min.1, max.1, coord.y);
    if i64::from(x1 - x0) * i64::from(y1 - y0) > MAX_LAND_CELLS_OF_ONE_OBJECT {
        add_outside_cell(world, coord.x, coord.y, array);
        return;
    }
    for x in x0..=x1 {
        for y in y0..=y1 {
            add_outside_cell(world, x, y, array);
        }
    }
}

/// A model that covers more land cells than this is damaged: it is then listed in its own cell only. Retail's
/// largest models cover a few landblocks at most.
const MAX_LAND_CELLS_OF_ONE_OBJECT: i64 = 4096;

/// `world.md` 12 D2.
fn into_building(world: &World, from: CellId, own: CellId, parts: &[PartBounds], array: &mut CellArray) {
    let Some(building) = world.building_on(from) else {
        return;
    };
    for building_portal in &building.portals {
        let Some(index) = building_portal.other_portal else {
            continue;
        };
        let Some(cell) = world.env_cell(building_portal.other) else {
            continue;
        };
        let Some(portal) = cell.portal(index) else {
            continue;
        };
        let offset = block_offset(cell.id.block(), own.block());
        for part in parts {
            let Some(sphere) = &part.sphere else { continue };
            let reach = sphere.radius + EPSILON;
            let dist = portal.plane.dist(part.center_in(sphere, offset, &cell.frame));
            if if portal.interior_is_negative {
                dist > reach
            } else {
                dist < -reach
            } {
                continue;
            }
            let side = part.box_in(offset, &cell.frame).side_of(&portal.plane);
            if side != Side::Crossing && side != interior_side(portal) {
                continue;
            }
            if part_meets(part, own.block(), cell) {
                array.add(cell.id, true);
                from_env_cell(world, cell, own, parts, array);
                break;
            }
        }
    }
}
