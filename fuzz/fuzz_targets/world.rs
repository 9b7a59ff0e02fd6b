//! A small world with records changed as the input tells: loaded, swept through and looked at.
#![no_main]

#[path = "../../crates/vestibule/tests/hostile/mod.rs"]
mod hostile;

use std::sync::LazyLock;

use vestibule_world::{MemoryRecords, World};

static WORLDS: LazyLock<Vec<MemoryRecords>> = LazyLock::new(|| {
    let embedded = vestibule::open_dats(None).expect("the embedded world opens");
    let mut worlds = vec![hostile::records_of(&embedded)];
    // More worlds, where there are any: folders of DAT files, one a line.
    for folder in std::env::var("VESTIBULE_FUZZ_WORLDS").unwrap_or_default().split(':') {
        if let Ok(dats) = vestibule_dat::DatSet::open(folder) {
            worlds.push(hostile::records_of(&dats));
        }
    }
    worlds
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&which, script)) = bytes.split_first() else { return };
    let mut records = WORLDS[usize::from(which) % WORLDS.len()].clone();
    hostile::mutate(&mut records, script);
    let blocks = hostile::blocks_of(&records, 3);
    if let Ok(world) = World::open(records) {
        hostile::load_and_walk(&world, &blocks);
    }
});
