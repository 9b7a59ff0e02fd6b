//! Everything around a viewer as commands, without a traversal (`rendering.md` 10.4).

use vestibule_physics::{ObjectRef, Population};
use vestibule_view::{Command, LightSet, Views};
use vestibule_world::{BlockId, CellId, StaticRef, World};

/// Landblocks within `radius` blocks of one that could be loaded and are not, the nearest first. Some may not
/// exist.
pub(crate) fn to_load(world: &World, centre: BlockId, radius: i32) -> Vec<BlockId> {
    if !world.loads_on_touch() {
        return Vec::new();
    }
    let mut out = Vec::new();
    for ring in 0..=radius.clamp(0, 16) {
        for dx in -ring..=ring {
            for dy in -ring..=ring {
                let id = centre.neighbour(dx, dy);
                let on_ring = dx.abs() == ring || dy.abs() == ring;
                out.extend(id.filter(|id| on_ring && id.is_on_map() && world.loaded_block(*id).is_none()));
            }
        }
    }
    out
}

/// Commands that draw all loaded landblocks within `radius` blocks of one: ground, shells, rooms, objects and bodies.
pub fn commands(
    world: &World,
    population: &Population,
    centre: BlockId,
    radius: i32,
    out: &mut Vec<Command>,
) {
    let views = Views::Landscape;
    let radius = radius.clamp(0, 16);
    let around = (-radius..=radius).flat_map(|dx| (-radius..=radius).map(move |dy| (dx, dy)));
    let blocks = || {
        around
            .clone()
            .filter_map(|(dx, dy)| world.loaded_block(centre.neighbour(dx, dy)?))
    };
    out.push(Command::Light(LightSet::Sun));
    if blocks().any(|b| b.land.is_some()) {
        out.push(Command::Sky);
    }
    for block in blocks() {
        out.extend(block.land_cells().map(|(id, _)| Command::Terrain(id)));
    }
    let indoors = |cell: CellId| cell.is_indoor();
    for inside in [false, true] {
        if inside {
            out.push(Command::Light(LightSet::Indoor));
        }
        for block in blocks() {
            if inside {
                out.extend(block.env_cells().map(|c| Command::Room { cell: c.id, views }));
            } else {
                for (index, building) in block.buildings.iter().enumerate() {
                    if let Some(part) = building.shape.parts.first().filter(|p| p.model.is_some()) {
                        out.push(Command::Building {
                            block: block.id,
                            building: index as u32,
                            model: part.model_id,
                        });
                    }
                }
            }
            for (index, object) in block.statics.iter().enumerate() {
                if indoors(object.cell) == inside {
                    let id = StaticRef {
                        block: block.id,
                        index: index as u32,
                    };
                    out.push(Command::Object {
                        id: ObjectRef::Static(id),
                        cell: object.cell,
                        views,
                    });
                }
            }
        }
        for (id, body) in population.bodies() {
            let cell = body.cell().unwrap_or(body.position().cell);
            if indoors(cell) == inside {
                out.push(Command::Object {
                    id: ObjectRef::Body(id),
                    cell,
                    views,
                });
            }
        }
    }
    out.push(Command::FlushAlpha);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hollow;

    #[test]
    fn what_is_near_and_not_loaded_is_named_the_nearest_first() {
        let (world, _) = hollow();
        let centre = BlockId(0xB0C0);
        let missing = to_load(&world, centre, 2);
        assert_eq!((missing.len(), missing[0]), (25, centre));
        let far = |id: &BlockId| {
            (i32::from(id.0 >> 8) - 0xB0)
                .abs()
                .max((i32::from(id.0 & 0xFF) - 0xC0).abs())
        };
        assert!(missing.is_sorted_by_key(far));
        world.block(centre);
        assert_eq!(
            to_load(&world, centre, 2).contains(&centre),
            world.loaded_block(centre).is_none()
        );
        // At the corner of the map there is less around.
        assert!(to_load(&world, BlockId(0x0000), 2).len() <= 9);
    }
}
