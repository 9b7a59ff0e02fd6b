//! Finding a place to start a tour from.

use glam::{Vec2, Vec3};
use vestibule_dat::{DatSet, RecordKind};
use vestibule_world::{BlockId, CellId, EnvCell, PortalTarget, Position, World};

use crate::route::{self, Opening};
use crate::walker::{Footing, Walker};

/// A place to start from: before the entrance of a building that can be walked into, else inside a dungeon.
pub(super) fn find_start<'w>(world: &'w World, dats: &DatSet) -> Option<(Walker<'w>, Footing)> {
    // Holtburg, where everyone starts, if the files have it.
    let holtburg = BlockId(0xA9B4);
    let infos = dats.cell().iter().filter_map(Result::ok);
    let mut blocks = vec![holtburg];
    let others = infos
        .filter(|entry| RecordKind::of_cell_id(entry.id) == RecordKind::LandBlockInfo)
        .map(|entry| BlockId((entry.id >> 16) as u16))
        .filter(|&block| block != holtburg);
    let mut dungeon = None;
    for block in blocks.drain(..).chain(others) {
        let mut walker = Walker::new(world, block);
        if let Some(footing) = before_an_entrance(&mut walker, block) {
            return Some((walker, footing));
        }
        if dungeon.is_none() {
            dungeon = inside(&mut walker, block).map(|footing| (walker, footing));
        }
    }
    dungeon
}

/// A place some way before an entrance from which it can be walked into.
fn before_an_entrance(walker: &mut Walker<'_>, block: BlockId) -> Option<Footing> {
    let mut openings = route::entrances(walker.world(), block);
    // Doors before windows.
    openings.sort_by(|a, b| b.size().1.total_cmp(&a.size().1).then(a.id.cmp(&b.id)));
    for opening in openings {
        let out = opening.outward.truncate().normalize_or_zero();
        let side = Vec2::new(-out.y, out.x);
        let middle = opening.middle.truncate();
        for distance in [12.0, 9.0, 6.0, 4.0, 2.5, 1.5] {
            for turn in [0.0, 0.4, -0.4] {
                let at = middle + (out + side * turn) * distance;
                let land = CellId::new(block, 0xFFFF);
                let Some(ground) = walker.world().ground_at(land, at.extend(0.0)) else {
                    continue;
                };
                let place = Position::new(ground.cell, ground.point.truncate().extend(ground.z + 0.01));
                if is_inside_a_room(walker.world(), &place) {
                    continue;
                }
                let Some(footing) = walker.put(&place).filter(|f| !f.at.cell.is_indoor()) else {
                    continue;
                };
                if route::in_through(walker, &footing, &opening).is_some() {
                    return Some(footing);
                }
            }
        }
    }
    None
}

/// Whether an outdoor place lies within the walls of a building, where nobody can walk to.
fn is_inside_a_room(world: &World, place: &Position) -> bool {
    let center = place.origin() + Vec3::new(0.0, 0.0, crate::locate::PLAYER_SPHERE_CENTERS[0]);
    let block = world.block(place.cell.block());
    block.is_some_and(|block| block.env_cells().any(|cell| cell.contains_point(center)))
}

/// A place in an env cell of a landblock that one can stand in: in the first cell that one can walk out of, else in the
/// first at all.
pub(super) fn inside(walker: &mut Walker<'_>, block: BlockId) -> Option<Footing> {
    let block = walker.world().block(block)?;
    let mut first = None;
    for cell in block.env_cells().filter(|cell| !cell.portals.is_empty()) {
        let Some(footing) = within(walker, cell) else {
            continue;
        };
        let indoors = |opening: &Opening| opening.to != PortalTarget::Outside;
        let ways = route::openings(walker.world(), cell.id);
        if ways
            .iter()
            .filter(|o| indoors(o))
            .any(|o| route::out_through(walker, &footing, o).is_some())
        {
            return Some(footing);
        }
        first = first.or(Some(footing));
    }
    first
}

/// A place in a cell that one can stand in.
fn within(walker: &mut Walker<'_>, cell: &EnvCell) -> Option<Footing> {
    let bounds = cell.structure.bounds?.mapped(|p| cell.frame.local_to_global(p));
    let size = bounds.max - bounds.min;
    for (u, v) in [
        (0.5, 0.5),
        (0.3, 0.3),
        (0.7, 0.7),
        (0.3, 0.7),
        (0.7, 0.3),
        (0.5, 0.2),
        (0.2, 0.5),
    ] {
        // From a little above the floor upwards, for floors that are not level.
        for up in [0.02, 0.5, 1.0, 2.0, 4.0] {
            if up > size.z {
                break;
            }
            let at = bounds.min + Vec3::new(size.x * u, size.y * v, up);
            if let Some(footing) = walker.put(&Position::new(cell.id, at))
                && footing.at.cell == cell.id
            {
                return Some(footing);
            }
        }
    }
    None
}
