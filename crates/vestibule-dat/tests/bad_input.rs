//! Damaged and hostile files: each gives an error that names file and place, and every other record stays usable.

mod common;

use common::{Random, build, cell_file, contents, open, record, set_word, word};
use proptest::prelude::*;
use vestibule_dat::{
    DatEditor, DatFile, DatKind, DatSet, EditOptions, Error, ErrorKind, Limits, WriteOptions,
};

/// Does everything that a reader can do; gives the errors met.
fn exercise(bytes: &[u8]) -> Vec<Error> {
    let dat = match DatFile::from_bytes("bad.dat", bytes) {
        Ok(dat) => dat.with_limits(Limits { inflated: 1 << 20 }),
        Err(e) => return vec![e],
    };
    let mut errors = Vec::new();
    let mut buffer = Vec::new();
    for entry in &dat {
        match entry {
            Ok(entry) => {
                errors.extend(dat.read(&entry).err());
                errors.extend(dat.read_into(entry.id, &mut buffer).err());
                errors.extend(dat.get(entry.id ^ 1).err());
            }
            Err(e) => errors.push(e),
        }
    }
    errors.extend(dat.iteration().err());
    assert!(dat.range(0x0100_0110..0x0100_0120).count() < 1000);
    let report = dat.verify();
    assert_eq!(report.errors.len(), report.error_count.min(10_000));
    errors.extend(report.errors);
    errors
}

/// Everything that an editor can do, too.
fn exercise_editor(bytes: Vec<u8>) {
    let options = EditOptions {
        reuse_free: true,
        force: true,
    };
    let Ok(mut dat) = DatEditor::edit("bad.dat", bytes, options) else {
        return;
    };
    let plain = WriteOptions::default();
    for id in 0..40u32 {
        let _ = dat.put(0x0100_0100 + 7 * id, &record(id, 300), &plain);
        let _ = dat.delete(0x0100_0101 + 5 * id);
        let _ = dat.get(0x0100_0102 + id);
    }
    let _ = dat.commit();
    let _ = dat.close();
}

fn assert_names(e: &Error, file: &str) {
    assert!(e.file().ends_with(file), "{e}");
    assert!(e.to_string().contains(file), "{e}");
    assert!(!e.field().is_empty(), "{e}");
}

#[test]
fn a_missing_file() {
    let e = DatFile::open("no/such/folder/client_portal.dat").unwrap_err();
    assert!(matches!(e.kind(), ErrorKind::Io(_)));
    assert_names(&e, "client_portal.dat");
    assert_names(&DatEditor::open("no/such/file.dat").err().unwrap(), "file.dat");
    assert_names(&DatSet::open("no/such/folder").unwrap_err(), "no/such/folder");
}

#[test]
fn an_empty_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.dat");
    std::fs::write(&path, b"").unwrap();
    let errors = [
        DatFile::open(&path).unwrap_err(),
        DatFile::open_in_memory(&path).unwrap_err(),
        DatEditor::open(&path).err().unwrap(),
    ];
    for e in errors {
        assert!(matches!(e.kind(), ErrorKind::TooShort { have: 0, .. }));
        assert_names(&e, "empty.dat");
    }
}

#[test]
fn truncated_files() {
    let bytes = cell_file(70);
    for len in (0..bytes.len()).step_by(37) {
        let e = DatFile::from_bytes("cut.dat", &bytes[..len]).unwrap_err();
        assert!(matches!(e.kind(), ErrorKind::TooShort { .. }), "{e}");
        assert_names(&e, "cut.dat");
        // A header that admits the truncation: what is left is read, or named.
        if len > 0x190 && len < bytes.len() - 256 {
            let mut cut = bytes[..len].to_vec();
            set_word(&mut cut, 0x148, len as u32);
            assert!(!exercise(&cut).is_empty(), "{len}");
            exercise_editor(cut);
        }
    }
}

#[test]
fn files_of_the_wrong_kind() {
    let e = DatFile::from_bytes("picture.png", &b"\x89PNG\r\n\x1a\n".repeat(100)[..]).unwrap_err();
    assert!(
        matches!(e.kind(), ErrorKind::BadMagic { .. }) && e.offset() == Some(0x140),
        "{e}"
    );
    let (portal, cell) = (build(DatKind::Portal, []), build(DatKind::Cell, []));
    assert!(DatSet::from_bytes(portal.clone(), cell.clone()).is_ok());
    let e = DatSet::from_bytes(cell.clone(), portal.clone()).unwrap_err();
    assert!(matches!(e.kind(), ErrorKind::WrongKind { .. }));
    assert_names(&e, "client_portal.dat");
    let e = DatSet::from_bytes(portal, build(DatKind::HighRes, [])).unwrap_err();
    assert_names(&e, "client_cell_1.dat");
    assert!(
        e.to_string().contains("a highres file") && e.to_string().contains("a cell file"),
        "{e}"
    );
}

#[test]
fn a_cyclic_chain_spoils_its_record_only() {
    let mut bytes = cell_file(100);
    let bad = open(&bytes).find(0x0100_0106).unwrap().unwrap();
    let second = word(&bytes, bad.offset as usize);
    for target in [bad.offset, second] {
        set_word(&mut bytes, second as usize, target);
        let dat = open(&bytes);
        let e = dat.get(0x0100_0106).unwrap_err();
        assert!(matches!(e.kind(), ErrorKind::ChainLoop), "{e}");
        assert_eq!(e.id(), Some(0x0100_0106));
        assert!(e.offset().is_some());
        assert_names(&e, "test.dat");
        for entry in dat.iter().map(|e| e.unwrap()).filter(|e| e.id != bad.id) {
            assert_eq!(dat.read(&entry).unwrap().len(), entry.size as usize);
        }
        let report = dat.verify();
        assert_eq!(report.error_count, 1);
        assert_eq!(report.errors[0].id(), Some(bad.id));
    }
}

#[test]
fn cross_linked_chains_are_found_by_the_verifier() {
    let mut bytes = cell_file(100);
    let dat = open(&bytes);
    let (a, b) = (
        dat.find(0x0100_0105).unwrap().unwrap(),
        dat.find(0x0100_0106).unwrap().unwrap(),
    );
    set_word(
        &mut bytes,
        a.offset as usize,
        word(&cell_file(100), b.offset as usize),
    );
    let report = open(&bytes).verify();
    assert_eq!(
        report.error_count, 2,
        "they share the second's last two blocks: {:?}",
        report.errors
    );
    for e in &report.errors {
        assert!(matches!(e.kind(), ErrorKind::BlockUsedTwice { .. }), "{e}");
        assert!(e.id() == Some(a.id) || e.id() == Some(b.id));
    }
    // Two records with all blocks in common, and a record that overlaps a block by half.
    let at = find_entry(&bytes, b.id);
    set_word(&mut bytes, at + 8, a.offset);
    assert!(open(&bytes).verify().error_count > 0);
    set_word(&mut bytes, at + 8, a.offset + 128);
    set_word(&mut bytes, at + 12, 4);
    assert!(open(&bytes).verify().error_count > 0);
}

/// Where the entry of an id lies in the file. Blocks of 256 split nodes, so words are looked for one by one.
fn find_entry(bytes: &[u8], id: u32) -> usize {
    let entry = open(bytes).find(id).unwrap().unwrap();
    let matches = |at: usize| word(bytes, at + 4) == id && word(bytes, at + 8) == entry.offset;
    (1024..bytes.len() - 24)
        .step_by(4)
        .find(|at| matches(*at))
        .unwrap()
}

#[test]
fn entries_that_point_nowhere_or_claim_too_much() {
    let good = cell_file(50);
    let at = find_entry(&good, 0x0100_0110);
    for (field, value, expected) in [
        (8, 0, "offset"),
        (8, 0x18F, "offset"),
        (8, 0x8000_0400, "offset"),
        (8, 0xFFFF_FFFF, "offset"),
        (8, good.len() as u32, "offset"),
        (12, 0xFFFF_FFFF, "size"),
        (12, good.len() as u32 + 1, "size"),
        (12, good.len() as u32 - 1, "link"),
    ] {
        let mut bytes = good.clone();
        set_word(&mut bytes, at + field, value);
        let dat = open(&bytes);
        let e = dat.get(0x0100_0110).unwrap_err();
        assert_eq!((e.field(), e.id()), (expected, Some(0x0100_0110)), "{e}");
        assert!(dat.read_into(0x0100_0110, &mut vec![1]).is_err());
        assert!(dat.get(0x0100_0111).unwrap().is_some());
        assert_eq!(dat.iter().filter(|e| e.is_ok()).count(), 51);
        assert_eq!(exercise(&bytes).iter().filter(|e| e.id().is_none()).count(), 0);
    }
}

/// A file with three levels, and the offsets of its root and of the root's middle child.
fn three_levels() -> (Vec<u8>, usize, usize) {
    let bytes = build(DatKind::Portal, (0..12_000).map(|i| (i * 2, vec![i as u8])));
    let root = open(&bytes).header().btree_root as usize;
    let child = word(&bytes, root + 4 + 4) as usize;
    (bytes, root, child)
}

#[test]
fn b8_a_node_that_points_to_itself_or_outside_or_back() {
    let (good, root, child) = three_levels();
    assert_eq!(open(&good).verify().depth, 3);
    let ids = open(&good).iter().count();
    for (target, field) in [
        (child as u32, "branches"),
        (root as u32, "entry.id"),
        (0x100, "branches"),
        (good.len() as u32, "branches"),
        (0x7FFF_FFF0, "branches"),
        (0xFFFF_FFFF, "branches"),
        // Another leaf: cross-linked.
        (word(&good, child + 4 + 8), "entry.id"),
    ] {
        let mut bytes = good.clone();
        set_word(&mut bytes, child + 4 + 4, target);
        let dat = open(&bytes);
        let errors: Vec<_> = dat.iter().filter_map(|e| e.err()).collect();
        assert_eq!(errors.len(), 1, "{target:X}: {errors:?}");
        assert_eq!(errors[0].field(), field, "{}", errors[0]);
        assert!(errors[0].offset().is_some());
        assert_names(&errors[0], "test.dat");
        // Outside of what the damage covers everything is there: one leaf, or all below the node if the node itself is bad.
        let lost = ids - dat.iter().filter(|e| e.is_ok()).count();
        assert!(lost > 0 && lost <= 62 * 62, "{lost}");
        assert!(dat.get(0).unwrap().is_some() && dat.get(23_998).unwrap().is_some());
        assert!(!exercise(&bytes).is_empty());
        exercise_editor(bytes);
    }
}

#[test]
fn b8_counts_and_orders_that_no_node_has() {
    let (good, _, child) = three_levels();
    let leaf = word(&good, child + 4 + 4) as usize;
    let first = word(&good, leaf + 4 + 0xFC + 4);
    for (at, value, field) in [
        (leaf + 4 + 0xF8, 62, "entry_count"),
        (leaf + 4 + 0xF8, u32::MAX, "entry_count"),
        (leaf + 4 + 0xF8, 0, "entry_count"),
        (leaf + 4 + 0xFC + 4, first + 2, "entry.id"),
        (leaf + 4 + 0xFC + 4, 0, "entry.id"),
        (leaf + 4 + 0xFC + 4, u32::MAX, "entry.id"),
    ] {
        let mut bytes = good.clone();
        set_word(&mut bytes, at, value);
        let dat = open(&bytes);
        let e = dat.get(first).unwrap_err();
        assert_eq!((e.field(), e.offset()), (field, Some(leaf as u64)), "{e}");
        assert_eq!(dat.iter().filter(|e| e.is_err()).count(), 1);
        assert!(dat.iter().filter(|e| e.is_ok()).count() > 11_900);
        assert!(
            dat.get(first - 2).unwrap().is_some(),
            "the entry between the leaves is the parent's"
        );
    }
}

#[test]
fn b8_a_tree_that_is_too_deep() {
    // Nine nodes, each the only child of the one before: 0 entries are legal in the root alone, so each has one.
    let mut bytes = cell_file(0);
    bytes.resize(1024 + 10 * 2048, 0);
    set_word(&mut bytes, 0x144, 2048);
    set_word(&mut bytes, 0x148, 1024 + 10 * 2048);
    set_word(&mut bytes, 0x160, 1024);
    for level in 0..10usize {
        let at = 1024 + level * 2048;
        bytes[at..at + 2048].fill(0);
        set_word(&mut bytes, at + 4 + 0xF8, 1);
        set_word(&mut bytes, at + 4 + 0xFC, 0x0002_0000);
        set_word(&mut bytes, at + 4 + 0xFC + 4, 100 - level as u32);
        if level < 9 {
            set_word(&mut bytes, at + 4, at as u32 + 2048);
            set_word(&mut bytes, at + 8, at as u32 + 2048);
        }
    }
    let dat = open(&bytes);
    assert!(dat.get(93).unwrap().is_some(), "the eighth level is legal");
    let e = dat.get(92).unwrap_err();
    assert!(matches!(e.kind(), ErrorKind::TooDeep), "{e}");
    assert!(!exercise(&bytes).is_empty());
    exercise_editor(bytes);
}

#[test]
fn b10_a_compressed_record_that_lies() {
    let mut dat =
        vestibule_dat::DatBuilder::new("z", Vec::new(), vestibule_dat::Header::new(DatKind::Portal)).unwrap();
    let compress = WriteOptions {
        compress: true,
        ..WriteOptions::default()
    };
    dat.push(1, &vec![0; 30 << 20], &compress).unwrap();
    dat.push(2, b"fine", &compress).unwrap();
    let mut bytes = dat.finish().unwrap();
    let limited = open(&bytes).with_limits(Limits { inflated: 1 << 20 });
    let e = limited.get(1).unwrap_err();
    assert!(
        matches!(e.kind(), ErrorKind::OverLimit { .. }) && e.id() == Some(1),
        "{e}"
    );
    assert_eq!(open(&bytes).get(1).unwrap().unwrap().len(), 30 << 20);
    let at = open(&bytes).find(1).unwrap().unwrap().offset as usize;
    set_word(&mut bytes, at + 4, 1000);
    for e in [
        open(&bytes).get(1).unwrap_err(),
        open(&bytes).verify().errors.remove(0),
    ] {
        assert!(
            matches!(e.kind(), ErrorKind::Compressed(_)) && e.id() == Some(1),
            "{e}"
        );
    }
    assert_eq!(open(&bytes).get(2).unwrap().unwrap(), &b"fine"[..]);
}

#[test]
fn a_failed_write_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.dat");
    let bytes = cell_file(20);
    std::fs::write(&path, &bytes).unwrap();
    let mut header = open(&bytes).header().clone();
    let mut dat = vestibule_dat::DatBuilder::create(&path, header.clone()).unwrap();
    dat.push(5, b"a", &WriteOptions::default()).unwrap();
    dat.push(4, b"b", &WriteOptions::default()).unwrap_err();
    drop(dat);
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
    header.block_size = 10;
    assert!(vestibule_dat::DatBuilder::create(&path, header).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn random_bytes_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..3000)) {
        prop_assert!(!exercise(&bytes).is_empty());
    }

    /// Random bytes behind a header that is in order: nodes and chains of noise.
    #[test]
    fn random_bytes_behind_a_good_header(seed in 1u64.., len in 1024usize..40_000, root in any::<u32>(), small in any::<bool>()) {
        let mut bytes = cell_file(0)[..0x190].to_vec();
        let mut random = Random(seed);
        // Small words make more of the noise look like counts and offsets.
        let mask = if small { 0x7FFF } else { u64::MAX };
        while bytes.len() < len {
            bytes.extend_from_slice(&((random.next() & mask) as u32).to_le_bytes());
        }
        let len = bytes.len() as u32;
        set_word(&mut bytes, 0x148, len);
        set_word(&mut bytes, 0x160, 0x190 + root % (len - 0x190));
        exercise(&bytes);
        exercise_editor(bytes);
    }

    /// A good file of which some words are changed: no panic, no hang, and all that is not touched by it stays.
    #[test]
    fn a_few_bad_words(changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u32>(), 0u8..4), 1..6)) {
        let good = cell_file(150);
        let mut bytes = good.clone();
        for (at, value, how) in changes {
            let at = 0x140 + at.index(bytes.len() - 0x144);
            let old = word(&bytes, at);
            let value = match how {
                0 => value,
                1 => value % bytes.len() as u32,
                2 => value % 64,
                _ => old ^ (1 << (value % 32)),
            };
            set_word(&mut bytes, at, value);
        }
        exercise(&bytes);
        exercise_editor(bytes);
    }

    /// One bad word anywhere in the directory or in a chain loses only what it stands for.
    #[test]
    fn one_bad_link_spoils_one_record(which in 0u32..150, value in any::<u32>()) {
        let mut bytes = cell_file(150);
        let good = contents(&open(&bytes));
        let entry = open(&bytes).find(0x0100_0100 + which).unwrap().unwrap();
        set_word(&mut bytes, entry.offset as usize, value);
        let dat = open(&bytes);
        for (id, (record, ..)) in &good {
            match dat.get(*id) {
                Ok(Some(now)) if *id != entry.id => prop_assert_eq!(&*now, &record[..]),
                Ok(now) => prop_assert!(*id == entry.id && now.is_some()),
                Err(e) => prop_assert!(*id == entry.id && e.id() == Some(*id), "{}", e),
            }
        }
    }
}
