//! Which further cells are reached from a cell by spheres (`world.md` 10.1, 11.1, 11.3, 12 D1).

use glam::Vec3;

use crate::cell_array::CellArray;
use crate::constants::{EPSILON, SQUARE_LENGTH};
use crate::env_cell::{EnvCell, PortalTarget};
use crate::geometry::Sphere;
use crate::ids::{CellId, LandCoord, block_offset};
use crate::world::World;

/// Adds what `spheres` reach from the cell `from`. Returns whether an env cell was entered by way of a building
/// (retail sets `path.hits_interior_cell` then).
///
/// `spheres` and `origin` are in the frame of `seed`'s landblock.
#[inline]
pub fn find_transit_cells(
    world: &World,
    from: CellId,
    seed: CellId,
    origin: Vec3,
    spheres: &[Sphere],
    array: &mut CellArray,
) -> bool {
    if from.is_indoor() {
        if let Some(cell) = world.env_cell(from) {
            from_env_cell(world, cell, seed, origin, spheres, array);
        }
        false
    } else {
        // The neighbouring land cells were added before the flood began (`world.md` 11.3).
        add_all_outside_cells(world, seed, origin, spheres, array);
        into_building(world, from, seed, spheres, array)
    }
}

/// From an env cell through its portals (`world.md` 10.1).
#[inline]
pub(crate) fn from_env_cell(
    world: &World,
    cell: &EnvCell,
    seed: CellId,
    origin: Vec3,
    spheres: &[Sphere],
    array: &mut CellArray,
) {
    let mut check_outside = false;
    for (index, portal) in cell.portals.iter().enumerate() {
        if spheres
            .iter()
            .all(|s| cell.hints.certainly_away(index, s.center, s.radius))
        {
            continue;
        }
        let dist = |s: &Sphere| portal.plane.dist(cell.frame.global_to_local(s.center));
        match portal.other {
            PortalTarget::Outside => {
                check_outside |= spheres.iter().any(|s| dist(s).abs() < s.radius + EPSILON);
            }
            PortalTarget::Cell(id) => {
                if array.contains(id) {
                    continue;
                }
                if let Some(other) = world.env_cell(id) {
                    if spheres.iter().any(|s| meets(other, s.center, s.radius)) {
                        array.add(id, true);
                    }
                } else {
                    let reaches = |s: &Sphere| {
                        let reach = s.radius + EPSILON;
                        if portal.interior_is_negative {
                            dist(s) > -reach
                        } else {
                            dist(s) < reach
                        }
                    };
                    if spheres.iter().any(reaches) {
                        array.add(id, false);
                    }
                }
            }
        }
    }
    if check_outside {
        add_all_outside_cells(world, seed, origin, spheres, array);
    }
}

#[inline]
fn meets(cell: &EnvCell, center: Vec3, radius: f32) -> bool {
    if cell.hints.certainly_outside(center, radius) {
        return false;
    }
    let local = Sphere::new(cell.frame.global_to_local(center), radius);
    cell.structure.cell_bsp.meets_sphere(&local)
}

/// Adds the land cells under the spheres (retail `add_all_outside_cells`, `world.md` 11.1).
#[inline]
pub fn add_all_outside_cells(
    world: &World,
    seed: CellId,
    origin: Vec3,
    spheres: &[Sphere],
    array: &mut CellArray,
) {
    if array.added_outside {
        return;
    }
    array.added_outside = true;
    if spheres.is_empty() {
        if let Some(c) = seed.adjust_to_outside(origin).and_then(|(id, _)| id.land_coord()) {
            add_outside_cell(world, c.x, c.y, array);
        }
        return;
    }
    for (i, sphere) in spheres.iter().enumerate() {
        // Above or below another that is no smaller: it reaches no further cell.
        let is_under = |s: &Sphere| {
            s.center.x == sphere.center.x && s.center.y == sphere.center.y && s.radius >= sphere.radius
        };
        if spheres.iter().take(i).any(is_under) {
            continue;
        }
        let Some((id, q)) = seed.adjust_to_outside(sphere.center) else {
            return;
        };
        let Some(LandCoord { x, y }) = id.land_coord() else {
            return;
        };
        let within = |v: f32| v - SQUARE_LENGTH * libm::floorf(v / SQUARE_LENGTH);
        let (u, v) = (within(q.x), within(q.y));
        let (lo, hi) = (sphere.radius, SQUARE_LENGTH - sphere.radius);
        let mut add = |dx: i32, dy: i32| add_outside_cell(world, x + dx, y + dy, array);
        add(0, 0);
        if u > hi {
            add(1, 0);
            if v > hi {
                add(1, 1);
            }
            if v < lo {
                add(1, -1);
            }
        }
        if u < lo {
            add(-1, 0);
            if v > hi {
                add(-1, 1);
            }
            if v < lo {
                add(-1, -1);
            }
        }
        if v > hi {
            add(0, 1);
        }
        if v < lo {
            add(0, -1);
        }
    }
}

/// Adds the land cell at a global coordinate, resident or not; ignored off the map (`world.md` 11.1 step 4).
#[inline]
pub(crate) fn add_outside_cell(world: &World, x: i32, y: i32, array: &mut CellArray) {
    if let Some(coord) = (LandCoord { x, y }).in_bounds() {
        let id = coord.cell_id();
        if !array.contains(id) {
            array.add(id, world.is_resident(id));
        }
    }
}

/// From a land cell through the portals of the building on it (`world.md` 12 D1).
#[inline]
fn into_building(
    world: &World,
    from: CellId,
    seed: CellId,
    spheres: &[Sphere],
    array: &mut CellArray,
) -> bool {
    let Some(building) = world.building_on(from) else {
        return false;
    };
    // Retail applies no block offset here (`world.md` D4); the setting does what geometry asks for.
    let offset = if world.settings().offset_building_transit {
        block_offset(seed.block(), from.block())
    } else {
        Vec3::ZERO
    };
    let mut entered = false;
    for portal in &building.portals {
        if portal.other_portal.is_none() {
            continue;
        }
        let Some(cell) = world.env_cell(portal.other) else {
            continue;
        };
        if spheres.iter().any(|s| meets(cell, s.center - offset, s.radius)) {
            entered = true;
            array.add(portal.other, true);
        }
    }
    entered
}
