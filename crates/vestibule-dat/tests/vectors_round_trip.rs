//! Every record of the worlds in `../shared/vectors` re-encodes to the same bytes (`dat-format.md` D5); embedded
//! ids equal those of the directory (F6).

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use vestibule_dat::record::{Record, RoundTrip, round_trip};
use vestibule_dat::{DatSet, RecordKind};

const WORLDS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/vectors/worlds");

#[test]
fn d5_every_record_of_every_world_round_trips() {
    let Ok(folders) = Path::new(WORLDS).read_dir() else {
        writeln!(std::io::stderr(), "skipped: {WORLDS} is not there").unwrap();
        return;
    };
    let mut counts: BTreeMap<RecordKind, usize> = BTreeMap::new();
    for folder in folders {
        let folder = folder.unwrap().path();
        let dats = DatSet::open(&folder).unwrap();
        for (file_kind, file) in dats.files() {
            for entry in file.iter() {
                let entry = entry.unwrap();
                let bytes = file.read(&entry).unwrap();
                let kind = RecordKind::of(file_kind, entry.id);
                assert_ne!(
                    kind,
                    RecordKind::Unknown,
                    "{:08X} in {}",
                    entry.id,
                    folder.display()
                );
                let result = round_trip(kind, entry.id, &bytes);
                assert_eq!(
                    result,
                    Ok(RoundTrip::Identical),
                    "{kind} {:08X} in {}",
                    entry.id,
                    folder.display()
                );
                // The worlds with a missing cell keep its record under another id.
                if !folder.to_string_lossy().ends_with("-miss") {
                    let record = Record::parse(kind, entry.id, &bytes).unwrap();
                    assert_eq!(
                        record.stored_id().unwrap_or(entry.id),
                        entry.id,
                        "{kind} in {}",
                        folder.display()
                    );
                }
                *counts.entry(kind).or_default() += 1;
            }
        }
    }
    for kind in [
        RecordKind::LandBlock,
        RecordKind::EnvCell,
        RecordKind::Environment,
        RecordKind::Region,
    ] {
        assert!(counts.contains_key(&kind), "no {kind} seen: {counts:?}");
    }
}
