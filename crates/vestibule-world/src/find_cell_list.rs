//! `find_cell_list` (`world.md` 13): which cells spheres touch, and which cell holds the first centre.

use glam::Vec3;

use crate::cell_array::CellArray;
use crate::env_cell::EnvCell;
use crate::geometry::{CylSphere, Sphere};
use crate::ids::{CellId, block_offset};
use crate::position::Position;
use crate::transit::{add_all_outside_cells, find_transit_cells, from_env_cell};
use crate::world::World;

/// At most this many cylinders of an object are looked at (`world.md` 13, overloads).
pub const MAX_CELL_LIST_CYLSPHERES: usize = 10;

/// What [`find_cell_list`] found besides the array.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellList {
    /// The cell that contains the first sphere's centre: the first env cell in array order, else the last land
    /// cell (`world.md` S1). `None` when no resident cell does, or when it was not asked for.
    pub containing: Option<CellId>,
    /// An env cell was the seed, was entered by way of a building, or is the containing cell
    /// (retail `SPHEREPATH::hits_interior_cell`).
    pub hits_interior: bool,
}

/// Rebuilds `array` with the cells that `spheres` touch, seeded from the cell `seed`, and picks the one that
/// contains the centre of sphere 0 if `want_cell`.
///
/// `spheres` are in the frame of `seed`'s landblock, metres; `origin` is the position's origin in that frame,
/// used only when there are no spheres. The order of the array is retail's and is part of the result
/// (`world.md` S2): the seed cell first indoors, the land cell under sphere 0 first outdoors, then the flood.
/// Nothing is re-derived from coordinates indoors: a cell is reached from the seed through portals or not at all.
///
/// Retail: `CObjCell::find_cell_list`, `world.md` 13.
#[inline]
pub fn find_cell_list(
    world: &World,
    seed: CellId,
    origin: Vec3,
    spheres: &[Sphere],
    array: &mut CellArray,
    want_cell: bool,
) -> CellList {
    if let Some(cell) = world.env_cell(seed)
        && !spheres.is_empty()
    {
        return from_resident_env_cell(world, cell, origin, spheres, array, want_cell);
    }
    array.clear();
    let mut list = CellList::default();
    let visible = world.is_resident(seed);
    if seed.is_indoor() {
        list.hits_interior = true;
        array.add(seed, visible);
    } else {
        add_all_outside_cells(world, seed, origin, spheres, array);
    }
    if visible && !spheres.is_empty() {
        // The array grows while it is walked: this is the flood.
        let mut i = 0;
        while let Some(entry) = array.get(i) {
            if entry.resident {
                list.hits_interior |= find_transit_cells(world, entry.id, seed, origin, spheres, array);
            }
            i += 1;
        }
        if want_cell && let Some(cell) = containing_cell(world, seed, spheres, array) {
            list.hits_interior |= cell.is_indoor();
            list.containing = Some(cell);
        }
    }
    if array.do_not_load_cells && seed.is_indoor() && visible {
        prune_to_stab_list(world, seed, array);
    }
    list
}

/// The usual case indoors: the seed is resident. The order of the work is that of [`find_cell_list`].
#[inline]
fn from_resident_env_cell(
    world: &World,
    cell: &EnvCell,
    origin: Vec3,
    spheres: &[Sphere],
    array: &mut CellArray,
    want_cell: bool,
) -> CellList {
    let seed = cell.id;
    array.start(seed, true);
    from_env_cell(world, cell, seed, origin, spheres, array);
    let mut i = 1;
    while let Some(entry) = array.get(i) {
        if entry.resident {
            find_transit_cells(world, entry.id, seed, origin, spheres, array);
        }
        i += 1;
    }
    let mut list = CellList {
        containing: None,
        hits_interior: true,
    };
    if want_cell {
        let certain = spheres
            .first()
            .is_some_and(|s| cell.hints.certainly_contains(s.center));
        list.containing = if certain {
            Some(seed)
        } else {
            containing_cell(world, seed, spheres, array)
        };
    }
    if array.do_not_load_cells {
        prune_to_stab_list(world, seed, array);
    }
    list
}

/// The overload for cylinders: spheres at their low points, at most ten (`world.md` 13).
pub fn find_cell_list_of_cylspheres(
    world: &World,
    position: &Position,
    cylspheres: &[CylSphere],
    array: &mut CellArray,
) -> CellList {
    let mut spheres = [Sphere::default(); MAX_CELL_LIST_CYLSPHERES];
    let count = cylspheres.len().min(MAX_CELL_LIST_CYLSPHERES);
    for (sphere, cyl) in spheres.iter_mut().zip(cylspheres) {
        *sphere = Sphere::new(position.frame.local_to_global(cyl.low_point), cyl.radius);
    }
    find_cell_list(
        world,
        position.cell,
        position.origin(),
        &spheres[..count],
        array,
        false,
    )
}

/// First containing env cell, else last containing land cell, in array order (`world.md` 13.4b).
#[inline]
fn containing_cell(world: &World, seed: CellId, spheres: &[Sphere], array: &CellArray) -> Option<CellId> {
    let center = spheres.first()?.center;
    let mut found = None;
    for entry in array.entries() {
        if !entry.resident {
            continue;
        }
        let q = center - block_offset(seed.block(), entry.id.block());
        if entry.id.is_indoor() {
            if world.env_cell(entry.id).is_some_and(|cell| holds(cell, q)) {
                return Some(entry.id);
            }
        } else if world.point_in_cell(entry.id, q) {
            found = Some(entry.id);
        }
    }
    found
}

/// As [`EnvCell::contains_point`], mostly by hints.
#[inline(always)]
fn holds(cell: &EnvCell, q: Vec3) -> bool {
    cell.hints.certainly_contains(q) || (!cell.hints.certainly_outside(q, 0.0) && cell.contains_point(q))
}

/// Keeps the seed cell and its stab list only (`world.md` 13.5, S5, S6).
fn prune_to_stab_list(world: &World, seed: CellId, array: &mut CellArray) {
    let Some(cell) = world.env_cell(seed) else { return };
    let mut i = 0;
    while let Some(entry) = array.get(i) {
        if entry.id == seed || cell.stab_list.contains(&entry.id) {
            i += 1;
        } else {
            array.remove(i);
        }
    }
}
