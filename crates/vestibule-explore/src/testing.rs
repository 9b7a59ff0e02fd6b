//! The built-in world for tests.

use vestibule_world::World;

use crate::places::{NamedPlace, middle_of};

pub(crate) fn hollow() -> (World, Vec<NamedPlace>) {
    let compiled = vestibule_forge::embedded_world().unwrap();
    let world = World::open(compiled.memory_records()).unwrap();
    let names = compiled
        .cell_names
        .iter()
        .filter_map(|(&id, name)| {
            Some(NamedPlace {
                name: name.clone(),
                position: middle_of(&world, id)?,
            })
        })
        .collect();
    (world, names)
}
