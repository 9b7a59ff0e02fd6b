//! The files of a small world with bytes changed as the input tells (four a change: where in 3 bytes, what in 1;
//! the top bit of the place selects the file): opened, loaded, swept through and looked at.
#![no_main]

#[path = "../../crates/vestibule/tests/hostile/mod.rs"]
mod hostile;

use std::sync::LazyLock;

use vestibule_dat::DatSet;
use vestibule_world::{CellId, World};

static FILES: LazyLock<(Vec<u8>, Vec<u8>)> = LazyLock::new(hostile::embedded_files);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let (mut portal, mut cell) = FILES.clone();
    for change in bytes.chunks_exact(4).take(256) {
        let place = u32::from_le_bytes([change[0], change[1], change[2], 0]) as usize;
        let file = if place & 0x80_0000 != 0 { &mut portal } else { &mut cell };
        let at = (place & 0x7F_FFFF) % file.len();
        file[at] = change[3];
    }
    let Ok(dats) = DatSet::from_bytes(portal, cell) else { return };
    let mut blocks: Vec<_> = dats.cell().iter().take(500).flatten().map(|e| CellId(e.id).block()).collect();
    blocks.dedup();
    blocks.truncate(3);
    if let Ok(world) = World::open(dats) {
        hostile::load_and_walk(&world, &blocks);
    }
});
