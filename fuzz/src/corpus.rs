//! Writes the corpora that fuzzing starts from, out of the built-in world and folders of DAT files:
//! `cargo run --release --example corpus -- OUT [FOLDER...]`.

#[path = "../../crates/vestibule/tests/hostile/mod.rs"]
mod hostile;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use vestibule_dat::{DatBuilder, DatKind, DatSet, Header, RecordKind, WriteOptions};
use vestibule_world::Store;

type Failure = Box<dyn std::error::Error>;

/// Seeds of one record type from one world.
const PER_KIND: usize = 6;
/// Longer records make slow seeds.
const MAX_SEED: usize = 16 << 10;

fn write(out: &Path, target: &str, name: &str, bytes: &[u8]) -> Result<(), Failure> {
    let folder = out.join(target);
    std::fs::create_dir_all(&folder)?;
    Ok(std::fs::write(folder.join(name), bytes)?)
}

fn seeds_of(out: &Path, name: &str, dats: &DatSet) -> Result<(), Failure> {
    let records = hostile::records_of(dats);
    let mut counts: HashMap<RecordKind, usize> = HashMap::new();
    for kind in [DatKind::Portal, DatKind::Cell] {
        let store = if kind == DatKind::Cell { Store::Cell } else { Store::Portal };
        let mut small = DatBuilder::new("seed", Vec::new(), Header::new(kind))?;
        for (_, id, bytes) in records.iter().filter(|r| r.0 == store) {
            let kind = RecordKind::of(kind, id);
            let count = counts.entry(kind).or_default();
            if *count == PER_KIND || bytes.len() > MAX_SEED {
                continue;
            }
            *count += 1;
            let options = WriteOptions { compress: *count == 2, ..WriteOptions::default() };
            small.push(id, bytes, &options)?;
            let selector = RecordKind::ALL.iter().position(|&k| k == kind).unwrap_or(0);
            let mut seed = vec![selector as u8];
            seed.extend_from_slice(bytes);
            write(out, "record", &format!("{name}-{id:08X}-{selector}"), &seed)?;
        }
        write(out, "container", &format!("{name}-{}", kind.file_name()), &small.finish()?)?;
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let out = arguments.next().ok_or("usage: corpus OUT [FOLDER...]")?;
    seeds_of(&out, "embedded", &*vestibule::open_dats(None)?)?;
    for folder in arguments {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        seeds_of(&out, &name, &DatSet::open(&folder)?)?;
    }
    let texts = [
        "0xA9B40031 [155.372 16.028 94.005]",
        "0xA9B40031 [155.372 16.028 94.005] 1 0 0 0",
        "42.1N, 33.6E",
        "0.0S, 102.0W",
        "A9B40100",
        r#"{"id":"a","world":"b","op":"sweep","tags":["x"],"in":{"cell":1,"pos":[1,2,3]},"expect":{"ok":true}}"#,
    ];
    for (i, text) in texts.iter().enumerate() {
        write(&out, "text", &i.to_string(), text.as_bytes())?;
    }
    for (path, text) in vestibule_forge::EMBEDDED_SCENE {
        let name = path.rsplit('/').next().unwrap_or(path);
        write(&out, "scene", name, text.as_bytes())?;
    }
    let mut draws = hostile::Draws(7);
    for i in 0..40 {
        let script = draws.bytes(1 + 7 * (1 + i % 9));
        write(&out, "world", &i.to_string(), &script)?;
        let changes = draws.bytes(4 * (1 + i % 9));
        write(&out, "world_file", &i.to_string(), &changes)?;
    }
    Ok(())
}
