//! Nothing that a bad file says can panic, hang or fill the memory: a short run of what the fuzz targets do, the
//! same on every machine. `fuzz/README.md` has the long one.

mod hostile;

use std::path::PathBuf;

use hostile::Draws;
use vestibule_dat::{DatSet, RecordKind};
use vestibule_world::{MemoryRecords, Store, World};

/// The built-in world, and small worlds of the shared vectors where they are there.
fn worlds() -> Vec<MemoryRecords> {
    let embedded = vestibule::open_dats(None).expect("the embedded world opens");
    let mut worlds = vec![hostile::records_of(&embedded)];
    let shared = PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/vectors/worlds"
    ));
    for name in ["dungeon-1", "gallery-1", "cottage-1-cyl2", "maze-1-sph0"] {
        if let Ok(dats) = DatSet::open(shared.join(name)) {
            worlds.push(hostile::records_of(&dats));
        }
    }
    worlds
}

#[test]
fn mutated_worlds_load_and_can_be_walked() {
    for (seed, records) in (1u64..).zip(worlds()) {
        let mut draws = Draws(0x9E37_79B9 + seed);
        for _ in 0..120 {
            let mut mutated = records.clone();
            let changes = 1 + draws.below(12);
            let script = draws.bytes(7 * changes);
            hostile::mutate(&mut mutated, &script);
            let blocks = hostile::blocks_of(&mutated, 4);
            if let Ok(world) = World::open(mutated) {
                hostile::load_and_walk(&world, &blocks);
            }
        }
    }
}

#[test]
fn mutated_records_of_every_type_parse_or_fail_cleanly() {
    let mut draws = Draws(77);
    for records in worlds() {
        for (store, id, bytes) in records.iter() {
            let kind = match store {
                Store::Cell => RecordKind::of_cell_id(id),
                Store::Portal => RecordKind::of_asset_id(id),
            };
            let Some(selector) = RecordKind::ALL.iter().position(|&other| other == kind) else {
                continue;
            };
            let mut input = vec![selector as u8];
            input.extend_from_slice(bytes);
            hostile::record(&input);
            for _ in 0..60 {
                let mut mutated = input.clone();
                for _ in 0..1 + draws.below(4) {
                    let at = 1 + draws.below(mutated.len() - 1);
                    match draws.below(4) {
                        0 => mutated.truncate(at),
                        1 => mutated[at.min(input.len() - 1)] = draws.below(256) as u8,
                        2 => mutated.splice(at..at, [0xFF; 4]).for_each(drop),
                        _ => mutated[at] ^= 1 << draws.below(8),
                    }
                    if mutated.len() < 2 {
                        break;
                    }
                }
                hostile::record(&mutated);
            }
        }
    }
}

#[test]
fn mutated_containers_can_be_read_and_edited() {
    let mut draws = Draws(4_242);
    let (portal, cell) = hostile::embedded_files();
    for bytes in [portal, cell] {
        for round in 0..150 {
            let mut mutated = bytes.clone();
            for _ in 0..1 + draws.below(6) {
                // The header and the tail, where the directory lies, matter most.
                let at = match round % 3 {
                    0 => 0x140 + draws.below(0x50),
                    1 => mutated.len() - 1 - draws.below(4_096.min(mutated.len() - 1)),
                    _ => draws.below(mutated.len()),
                };
                mutated[at] = if draws.below(2) == 0 {
                    draws.below(256) as u8
                } else {
                    0xFF
                };
            }
            if draws.below(8) == 0 {
                mutated.truncate(draws.below(bytes.len()));
            }
            hostile::container(&mutated);
        }
    }
}

#[test]
fn mutated_text_is_read_or_refused() {
    let seeds = [
        "0xA9B40031 [155.372 16.028 94.005]",
        "0xA9B40031 [155.372 16.028 94.005] 1 0 0 0",
        "42.1N, 33.6E",
        "0.0S, 102.0W",
        "0xA9B40100",
        r#"{"id":"a","world":"b","op":"sweep","in":{"cell":1},"expect":{}}"#,
    ];
    let mut draws = Draws(99);
    for seed in seeds {
        hostile::text(seed.as_bytes());
        for _ in 0..4_000 {
            let mut text = seed.as_bytes().to_vec();
            for _ in 0..1 + draws.below(4) {
                let at = draws.below(text.len());
                match draws.below(4) {
                    0 if text.len() > 1 => drop(text.remove(at)),
                    1 => text.insert(at, b"0123456789.-+eExXNnSsWwaninf[], "[draws.below(32)]),
                    2 => text
                        .splice(at..at, "9".repeat(draws.below(60)).bytes())
                        .for_each(drop),
                    _ => text[at] = 32 + draws.below(95) as u8,
                }
            }
            hostile::text(&text);
        }
    }
}
