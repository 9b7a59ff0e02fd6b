//! Reading the worlds of the shared vectors, where they are present.

use std::io::Write;
use std::path::{Path, PathBuf};
use vestibule_dat::{DatBuilder, DatFile, DatKind, DatSet};

fn worlds() -> Vec<PathBuf> {
    let folder = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/vectors/worlds"
    ));
    let Ok(entries) = std::fs::read_dir(folder) else {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: no shared vectors at {}",
            folder.display()
        );
        return Vec::new();
    };
    let mut worlds: Vec<_> = entries
        .filter_map(|e| Some(e.ok()?.path()))
        .filter(|p| p.is_dir())
        .collect();
    worlds.sort();
    worlds
}

#[test]
fn b6_every_world_lists_ascending_ids_and_reads_them_both_ways() {
    for world in worlds() {
        for set in [
            DatSet::open(&world).unwrap(),
            DatSet::open_in_memory(&world).unwrap(),
        ] {
            assert!(set.highres().is_none() && set.local().is_none());
            for (kind, file) in set.files() {
                assert_eq!(file.kind(), Some(kind));
                assert!(
                    file.iteration().unwrap().unwrap().is_complete(),
                    "{}",
                    file.name()
                );
                let entries: Vec<_> = file.iter().collect::<Result<_, _>>().unwrap();
                assert!(entries.len() > 3 && entries.windows(2).all(|w| w[0].id < w[1].id));
                let mut buffer = Vec::new();
                for entry in &entries {
                    assert_eq!(file.find(entry.id).unwrap().as_ref(), Some(entry));
                    let bytes = file.read(entry).unwrap();
                    assert_eq!(bytes.len(), entry.size as usize);
                    assert_eq!(file.get(entry.id).unwrap().unwrap(), bytes);
                    assert_eq!(
                        file.read_into(entry.id, &mut buffer).unwrap().as_ref(),
                        Some(entry)
                    );
                    assert_eq!(*buffer, *bytes);
                }
                let (low, high) = (entries[1].id, entries[entries.len() - 2].id);
                let within: Vec<_> = file.range(low..=high).map(|e| e.unwrap()).collect();
                assert_eq!(within, entries[1..entries.len() - 1]);
                assert_eq!(file.range(low..high).count(), entries.len() - 3);
                assert_eq!(file.range(high + 1..=low).count(), 0);
            }
            assert_eq!(set.cell().kind(), Some(DatKind::Cell));
        }
    }
}

#[test]
fn every_world_is_whole_and_survives_being_written_anew() {
    for world in worlds() {
        for (kind, file) in DatSet::open(&world).unwrap().files() {
            let report = file.verify();
            assert!(report.is_clean(), "{}: {:?}", file.name(), report.errors);
            assert!(
                report.warnings.is_empty(),
                "{}: {:?}",
                file.name(),
                report.warnings
            );
            let mut dat = DatBuilder::new("again", Vec::new(), file.header().clone()).unwrap();
            dat.push_all(file).unwrap();
            let bytes = dat.finish().unwrap();
            // W7: these files are canonical, but a larger directory is spread over its nodes in another way.
            if report.depth == 1 {
                assert!(bytes == std::fs::read(file.name()).unwrap(), "{}", file.name());
            }
            let again = DatFile::from_bytes("again", bytes).unwrap();
            assert_eq!(again.kind(), Some(kind));
            for (a, b) in file.iter().zip(again.iter()) {
                let (a, b) = (a.unwrap(), b.unwrap());
                assert_eq!(
                    (a.id, a.flags, a.version, a.date, a.iteration),
                    (b.id, b.flags, b.version, b.date, b.iteration)
                );
                assert_eq!(file.read_stored(&a).unwrap(), again.read_stored(&b).unwrap());
            }
            assert_eq!(file.iter().count(), again.iter().count());
        }
    }
}
