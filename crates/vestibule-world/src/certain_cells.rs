//! Which cells spheres touch, and how far they may be shifted without changing it: one look-up then serves a whole
//! sweep (`world.md` 10.1, 11, 13). Answers are those of [`crate::find_cell_list`] or none at all.

use crate::cell_array::CellArray;
use crate::certain_land_cells::certain_land_cells;
use crate::env_cell::{CellPortal, EnvCell, PortalTarget};
use crate::geometry::Sphere;
use crate::ids::CellId;
use crate::landblock::Landblock;
use crate::lanes::Lanes;
use crate::transit_hints::UNIT_TOLERANCE;
use crate::world::World;

/// Fills `array` with what [`crate::find_cell_list`] would, if that is certain, and says how far `spheres` may be
/// shifted together so that it stays the same, metres; the containing cell is `seed`, also after such a shift. Zero
/// or less: nothing is certain, and `array` is empty.
#[inline]
pub fn certain_cells(world: &World, seed: CellId, spheres: &[Sphere], array: &mut CellArray) -> f32 {
    let Some(block) = world.block(seed.block()).filter(|_| !world.settings().exact) else {
        return 0.0;
    };
    let Some(foot) = spheres.first() else { return 0.0 };
    let pair = [*foot, *spheres.get(1).unwrap_or(foot)].map(Lanes::from);
    if seed.is_indoor() {
        block
            .env_cell(seed)
            .map_or(0.0, |cell| certain_rooms(block, cell, pair, array))
    } else {
        certain_land_cells(world, block, seed, pair, array)
    }
}

/// As [`certain_cells`] from an env cell of a landblock: rooms of the same landblock only. Radii are in the fourth
/// lanes; a mover of one sphere has it twice.
#[inline(never)]
pub fn certain_rooms(block: &Landblock, cell: &EnvCell, spheres: [Lanes; 2], array: &mut CellArray) -> f32 {
    array.start(cell.id, true);
    let inside = cell.hints.distance_inside(spheres[0]);
    let mut away = Lanes::splat(inside);
    let (mut seen, mut far) = (0, 0b1111);
    for limits in cell.hints.distances_away(spheres) {
        away = limits.lesser(away);
        far &= Lanes::splat(NEAR).less(limits);
        seen += 4;
    }
    // Away from all portals, which is usual; what is no number is not.
    if far == 0b1111 && inside > 0.0 && seen >= cell.portals.len() && !array.do_not_load_cells {
        return away.least() * UNIT_TOLERANCE;
    }
    if inside > 0.0
        && let Some(distance) = flood(block, cell, spheres, inside, array)
        && distance > 0.0
    {
        return distance;
    }
    array.clear();
    0.0
}

/// As [`certain_rooms`] where the centre of the first sphere has left the cell: the room that certainly holds it. The
/// array is that of the spheres where they are.
pub fn certain_crossing<'b>(
    block: &'b Landblock,
    cell: &EnvCell,
    spheres: [Lanes; 2],
    array: &mut CellArray,
) -> Option<&'b EnvCell> {
    array.start(cell.id, true);
    let entered = crossing(block, cell, spheres, array);
    if entered.is_none() {
        array.clear();
    }
    entered
}

fn crossing<'b>(
    block: &'b Landblock,
    cell: &EnvCell,
    spheres: [Lanes; 2],
    array: &mut CellArray,
) -> Option<&'b EnvCell> {
    let center = spheres[0];
    if !cell.hints.certainly_lacks(center) {
        return None;
    }
    flood(block, cell, spheres, f32::INFINITY, array).filter(|&distance| distance > 0.0)?;
    // The first in the array's order that holds it.
    for entry in array.entries().get(1..)? {
        let other = block.env_cell(entry.id)?;
        if other.hints.distance_inside(center) > 0.0 {
            return Some(other);
        }
        if !other.hints.certainly_lacks(center) {
            return None;
        }
    }
    None
}

/// Nearer than this, what is behind a portal is looked at closely, metres.
const NEAR: f32 = 0.1;

/// The flood of `find_cell_list` through rooms, in its order. Each test along the way limits the shift to one that
/// does not change its answer; `inside` is such a limit already.
#[inline(never)]
fn flood(
    block: &Landblock,
    seed: &EnvCell,
    spheres: [Lanes; 2],
    inside: f32,
    array: &mut CellArray,
) -> Option<f32> {
    if array.do_not_load_cells {
        return None;
    }
    let mut least = inside;
    let mut i = 0;
    while let Some(entry) = array.get(i)
        && least > 0.0
    {
        let cell = if i == 0 { seed } else { block.env_cell(entry.id)? };
        let limit = through_portals(block, cell, spheres, array)?;
        least = if limit < least { limit } else { least };
        i += 1;
    }
    Some(least * UNIT_TOLERANCE)
}

#[inline(always)]
fn through_portals(
    block: &Landblock,
    cell: &EnvCell,
    spheres: [Lanes; 2],
    array: &mut CellArray,
) -> Option<f32> {
    let mut least = Lanes::splat(f32::INFINITY);
    let mut first = 0;
    for mut limits in cell.hints.distances_away(spheres) {
        // Also what is no number.
        let mut near = !Lanes::splat(NEAR).less(limits) & 0b1111;
        while near != 0 {
            let k = near.trailing_zeros() as usize;
            near &= near - 1;
            let portal = cell.portals.get(first + k)?;
            let limit = look_behind(block, portal, limits.lane(k), spheres, array)?;
            limits.set_lane(k, limit);
        }
        least = limits.lesser(least);
        first += 4;
    }
    // A cell without hints.
    (first >= cell.portals.len()).then(|| least.least())
}

/// What limits the shift near a portal of which no more is known than `limit`; adds the room behind it if it is touched.
#[inline]
fn look_behind(
    block: &Landblock,
    portal: &CellPortal,
    limit: f32,
    spheres: [Lanes; 2],
    array: &mut CellArray,
) -> Option<f32> {
    let behind = match portal.other {
        PortalTarget::Cell(id) if array.contains(id) => return Some(f32::INFINITY),
        PortalTarget::Cell(id) if id.block() == block.id => block.env_cell(id),
        _ => None,
    };
    let Some(other) = behind else {
        return (limit > 0.0).then_some(limit);
    };
    let (touches, distance) = other.hints.distance_to_change(spheres);
    if touches {
        array.add(other.id, true);
        return Some(distance);
    }
    Some(if distance > limit { distance } else { limit })
}
