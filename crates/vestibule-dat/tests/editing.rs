//! Editing in place: what a batch does, what it keeps, and what happens to the blocks it replaces.

mod common;

use common::{build, cell_file, contents, open, record, set_word, word};
use proptest::prelude::*;
use std::collections::BTreeMap;
use vestibule_dat::{
    DatBuilder, DatEditor, DatFile, DatKind, EditOptions, ErrorKind, Header, ITERATION_ID, IterationRecord,
    TRANSACTION_CLEAN, WriteOptions, compact,
};

const PLAIN: WriteOptions = WriteOptions {
    version: None,
    date: None,
    iteration: None,
    compress: false,
};

fn edit(bytes: Vec<u8>) -> DatEditor<Vec<u8>> {
    DatEditor::edit("test.dat", bytes, EditOptions::default()).unwrap()
}

fn close(dat: DatEditor<Vec<u8>>) -> Vec<u8> {
    dat.close_with().unwrap().1
}

/// One batch.
fn edited(bytes: Vec<u8>, edit_it: impl FnOnce(&mut DatEditor<Vec<u8>>)) -> Vec<u8> {
    let mut dat = edit(bytes);
    edit_it(&mut dat);
    dat.commit().unwrap();
    close(dat)
}

#[test]
fn edits_show_before_and_after_the_commit() {
    let mut dat = edit(cell_file(300));
    dat.put(0x0100_0100, b"new", &PLAIN).unwrap();
    dat.put(0x0200_0100, &record(9, 3000), &PLAIN).unwrap();
    assert!(dat.delete(0x0100_0101).unwrap());
    assert!(!dat.delete(0x0100_0101).unwrap());
    for _ in 0..2 {
        assert_eq!(dat.get(0x0100_0100).unwrap().unwrap(), b"new");
        assert_eq!(dat.get(0x0200_0100).unwrap().unwrap(), record(9, 3000));
        assert_eq!(dat.get(0x0100_0101).unwrap(), None);
        assert_eq!(dat.get(0x0100_0102).unwrap().unwrap(), record(2, 220));
        dat.commit().unwrap();
    }
    let dat = open(&close(dat));
    assert_eq!(dat.iter().count(), 301);
    assert_eq!(dat.get(0x0100_0100).unwrap().unwrap(), &b"new"[..]);
    assert_eq!(dat.get(0x0200_0100).unwrap().unwrap(), record(9, 3000));
    assert_eq!(dat.get(0x0100_0101).unwrap(), None);
    let report = dat.verify();
    assert!(report.is_clean(), "{:?}", report.errors);
    assert_eq!(report.leaked_blocks, 0);
}

#[test]
fn insert_and_replace_insist() {
    let mut dat = edit(cell_file(3));
    let e = dat.insert(0x0100_0100, b"x", &PLAIN).unwrap_err();
    assert!(matches!(e.kind(), ErrorKind::Exists) && e.id() == Some(0x0100_0100));
    let e = dat.replace(0x0300_0100, b"x", &PLAIN).unwrap_err();
    assert!(matches!(e.kind(), ErrorKind::Absent) && e.file() == "test.dat");
    dat.insert(0x0300_0100, b"x", &PLAIN).unwrap();
    dat.replace(0x0300_0100, b"y", &PLAIN).unwrap();
    assert_eq!(dat.pending(), 1);
}

#[test]
fn without_a_commit_nothing_is_written() {
    let bytes = cell_file(100);
    let mut dat = edit(bytes.clone());
    dat.put(1, b"x", &PLAIN).unwrap();
    dat.delete(0x0100_0100).unwrap();
    assert_eq!(close(dat), bytes);
    let mut dat = edit(bytes.clone());
    dat.commit().unwrap();
    assert_eq!(close(dat), bytes, "an empty batch changes nothing");
}

#[test]
fn w2_new_blocks_extend_the_file_and_old_payload_stays() {
    let bytes = cell_file(100);
    let end = bytes.len();
    let mut dat = edit(bytes.clone());
    dat.put(0x0100_0103, &record(1, 900), &PLAIN).unwrap();
    dat.commit().unwrap();
    let (_, after) = {
        // Dropped without closing: only the header and the tail differ.
        let storage = dat.close_with().unwrap();
        (storage.0, storage.1)
    };
    let entry = open(&after).find(0x0100_0103).unwrap().unwrap();
    assert!(entry.offset as usize >= end && word(&after, 0x160) as usize >= end);
    for at in (1024..end).step_by(256) {
        assert_eq!(
            after[at + 4..at + 256],
            bytes[at + 4..at + 256],
            "payload at {at:X}"
        );
    }
}

#[test]
fn w2_5_replaced_blocks_go_behind_the_free_list() {
    let once = edited(cell_file(100), |dat| {
        dat.put(0x0100_0103, &record(1, 900), &PLAIN).unwrap()
    });
    let header = open(&once).header().clone();
    // The record had 2 blocks, the leaf and the root 7 each.
    assert_eq!(header.free_count, 16);
    let first = header.first_free;
    let twice = edited(once, |dat| dat.put(0x0100_0104, &record(1, 5), &PLAIN).unwrap());
    let header = open(&twice).header().clone();
    assert_eq!(header.first_free, first, "the list grows at its end");
    assert_eq!(header.free_count, 16 + 2 + 14);
    let report = open(&twice).verify();
    assert!(
        report.is_clean() && report.leaked_blocks == 0 && report.free_blocks == 32,
        "{report:?}"
    );
}

#[test]
fn w3_an_uncommitted_tail_is_ignored_and_cut_off() {
    let bytes = cell_file(30);
    let mut with_tail = bytes.clone();
    with_tail.extend_from_slice(&[0xAB; 5000]);
    assert_eq!(contents(&open(&with_tail)), contents(&open(&bytes)));
    assert_eq!(close(edit(with_tail)), bytes);
}

#[test]
fn w4_free_blocks_are_reused_on_request_and_by_link() {
    let mut bytes = edited(cell_file(100), |dat| {
        dat.put(0x0100_0103, &record(1, 900), &PLAIN).unwrap()
    });
    let options = EditOptions {
        reuse_free: true,
        ..EditOptions::default()
    };
    let (size, free) = (bytes.len(), open(&bytes).header().free_count);
    // One record block and two nodes of 7 fit into the 16 free ones.
    let mut dat = DatEditor::edit("test.dat", bytes, options).unwrap();
    dat.put(0x0100_0104, b"short", &PLAIN).unwrap();
    dat.commit().unwrap();
    bytes = close(dat);
    assert_eq!(bytes.len(), size, "the file has not grown");
    assert_eq!(open(&bytes).header().free_count, free - 15 + 2 + 14);
    assert_eq!(open(&bytes).get(0x0100_0104).unwrap().unwrap(), &b"short"[..]);
    let report = open(&bytes).verify();
    assert!(report.is_clean() && report.leaked_blocks == 0, "{report:?}");
}

#[test]
fn r4_a_broken_free_list_is_rebuilt_before_it_is_used() {
    let bytes = edited(cell_file(100), |dat| {
        dat.put(0x0100_0103, &record(1, 900), &PLAIN).unwrap()
    });
    let expected = contents(&open(&bytes));
    let live = open(&bytes).find(0x0100_0110).unwrap().unwrap().offset;
    type Break<'a> = &'a dyn Fn(&mut Vec<u8>);
    let breaks: [Break<'_>; 4] = [
        &|b| set_word(b, 0x154, live),
        &|b| set_word(b, 0x15C, 5),
        &|b| {
            let first = word(b, 0x154) as usize;
            set_word(b, first, 0x8000_0000 | live);
        },
        &|b| set_word(b, 0x158, 1024),
    ];
    for (i, break_it) in breaks.iter().enumerate() {
        for reuse_free in [false, true] {
            let mut broken = bytes.clone();
            break_it(&mut broken);
            assert!(!open(&broken).verify().is_clean());
            let options = EditOptions {
                reuse_free,
                ..EditOptions::default()
            };
            let mut dat = DatEditor::edit("test.dat", broken, options).unwrap();
            dat.put(0x0100_0101, &record(1, 120), &PLAIN).unwrap();
            dat.commit().unwrap();
            let (report, bytes) = dat.close_with().unwrap();
            assert_eq!(report.rebuilt, !reuse_free, "break {i}");
            let mut got = contents(&open(&bytes));
            got.insert(0x0100_0101, expected[&0x0100_0101].clone());
            assert_eq!(got, expected, "break {i}, reuse {reuse_free}");
            let report = open(&bytes).verify();
            assert!(
                report.is_clean() && report.leaked_blocks == 0,
                "break {i}: {report:?}"
            );
        }
    }
}

#[test]
fn r4_nothing_is_freed_while_the_tree_is_damaged() {
    let mut bytes = cell_file(300);
    // The last leaf claims too many entries.
    let dat = open(&bytes);
    let root = dat.header().btree_root as usize;
    let leaf = word(&bytes, root + 4 + 4 * 2) as usize;
    set_word(&mut bytes, leaf + 4 + 0xF8, 62);
    let before = bytes.clone();
    let mut dat = edit(bytes);
    dat.put(0x0100_0101, b"x", &PLAIN).unwrap();
    dat.commit().unwrap();
    let (report, bytes) = dat.close_with().unwrap();
    assert!(report.damaged && report.freed == 0);
    assert_eq!(
        bytes[1024..before.len()],
        before[1024..],
        "nothing is marked free"
    );
    assert_eq!(open(&bytes).get(0x0100_0101).unwrap().unwrap(), &b"x"[..]);
}

#[test]
fn a_block_that_another_record_uses_is_never_freed() {
    // Record 6 shares the blocks of record 5 from its second on.
    let mut bytes = cell_file(50);
    let dat = open(&bytes);
    let at = |id| dat.find(id).unwrap().unwrap().offset as usize;
    let (five, six) = (at(0x0100_0105), at(0x0100_0106));
    let second = word(&bytes, five);
    set_word(&mut bytes, six, second);
    let expected = open(&bytes).get(0x0100_0106).unwrap().unwrap().into_owned();
    let bytes = edited(bytes, |dat| {
        dat.put(0x0100_0105, b"x", &PLAIN).unwrap();
    });
    assert_eq!(open(&bytes).get(0x0100_0106).unwrap().unwrap(), expected);
    assert!(open(&bytes).verify().is_clean());
    let bytes = edited(bytes, |dat| assert!(dat.delete(0x0100_0106).unwrap()));
    assert!(open(&bytes).verify().is_clean());
}

#[test]
fn section_5_5_an_interrupted_transaction_is_cleared_before_the_first_commit() {
    let mut bytes = cell_file(10);
    bytes[0x104] = 3;
    assert!(!open(&bytes).header().closed_cleanly());
    assert_eq!(open(&bytes).verify().warnings.len(), 1);
    let bytes = edited(bytes, |dat| dat.put(7, b"x", &PLAIN).unwrap());
    assert_eq!(bytes[0x100..0x140], TRANSACTION_CLEAN);
}

#[test]
fn w6_untouched_and_unknown_things_stay() {
    let mut header = Header::new(DatKind::Portal);
    header.version_string[..3].copy_from_slice(b"abc");
    header.version_major = [7; 16];
    (
        header.engine_pack_version,
        header.game_pack_version,
        header.version_minor,
    ) = (1, 1, 5);
    header.use_lru = 0xCDCD_CD00;
    let mut dat = DatBuilder::new("w6", Vec::new(), header.clone()).unwrap();
    let odd = WriteOptions {
        version: Some(9),
        date: Some(77),
        iteration: Some(12),
        compress: true,
    };
    dat.push(0x5500_0000, &[4; 999], &odd).unwrap();
    dat.push(0x7711_0000, b"unknown", &odd).unwrap();
    let bytes = dat.finish().unwrap();
    let old = contents(&open(&bytes));

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w6.dat");
    let edited = edited(bytes, |dat| dat.put(0x7711_0000, b"changed", &PLAIN).unwrap());
    std::fs::write(&path, &edited).unwrap();
    let (before, after) = compact(&path).unwrap();
    assert!(after < before);

    for dat in [open(&edited), DatFile::open(&path).unwrap()] {
        let mut now = contents(&dat);
        let changed = now.insert(0x7711_0000, old[&0x7711_0000].clone()).unwrap();
        assert_eq!(
            changed,
            (b"changed".to_vec(), 0, 9, 77, 12),
            "version, date and iteration stay with the record"
        );
        assert_eq!(now, old);
        let h = dat.header();
        assert_eq!(
            (h.version_string, h.version_major),
            (header.version_string, header.version_major)
        );
        assert_eq!(
            (h.engine_pack_version, h.game_pack_version, h.version_minor),
            (1, 1, 5)
        );
        assert_eq!(h.use_lru, 0xCDCD_CD00);
    }
}

#[test]
fn w1_compact_is_canonical() {
    let fresh = cell_file(500);
    let mut bytes = fresh.clone();
    for i in 0..5 {
        bytes = edited(bytes, |dat| {
            dat.delete(0x0100_0100 + i).unwrap();
            dat.put(0x0200_0100, &record(i, 4000), &PLAIN).unwrap();
        });
    }
    bytes = edited(bytes, |dat| {
        dat.delete(0x0200_0100).unwrap();
        for i in 0..5u32 {
            dat.put(0x0100_0100 + i, &record(i, 20 + (i as usize % 7) * 100), &PLAIN)
                .unwrap();
        }
    });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.dat");
    std::fs::write(&path, &bytes).unwrap();
    compact(&path).unwrap();
    assert_eq!(
        std::fs::read(&path).unwrap(),
        fresh,
        "the same records give the same bytes"
    );
}

#[test]
fn w1_a_failed_compact_leaves_the_old_file() {
    let mut bytes = cell_file(50);
    let at = open(&bytes).find(0x0100_0106).unwrap().unwrap().offset as usize;
    set_word(&mut bytes, at, 0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.dat");
    std::fs::write(&path, &bytes).unwrap();
    let e = compact(&path).unwrap_err();
    assert_eq!(e.id(), Some(0x0100_0106));
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        1,
        "no temporary file stays"
    );
}

#[test]
fn v2_incomplete_files_are_not_edited_unless_forced() {
    let record = IterationRecord {
        total: 12,
        runs: vec![(1, 10), (15, 2)],
    };
    let bytes = build(DatKind::Cell, [(5, vec![1]), (ITERATION_ID, record.bytes())]);
    let e = DatEditor::edit("test.dat", bytes.clone(), EditOptions::default())
        .err()
        .unwrap();
    assert!(matches!(e.kind(), ErrorKind::Incomplete));
    let mut dat = DatEditor::edit(
        "test.dat",
        bytes,
        EditOptions {
            force: true,
            ..EditOptions::default()
        },
    )
    .unwrap();
    dat.put(
        6,
        b"x",
        &WriteOptions {
            iteration: Some(99),
            ..PLAIN
        },
    )
    .unwrap();
    dat.commit().unwrap();
    assert_eq!(
        open(&close(dat)).iteration().unwrap(),
        Some(record),
        "and its record is left alone"
    );
}

#[test]
fn v3_a_file_without_a_usable_iteration_record_stays_usable() {
    let bytes = build(DatKind::Cell, [(5, vec![1]), (ITERATION_ID, vec![1, 2, 3])]);
    assert!(matches!(
        open(&bytes).iteration().unwrap_err().kind(),
        ErrorKind::Iteration(_)
    ));
    let bytes = edited(bytes, |dat| {
        dat.put(
            6,
            b"x",
            &WriteOptions {
                iteration: Some(4),
                ..PLAIN
            },
        )
        .unwrap();
    });
    assert_eq!(open(&bytes).get(ITERATION_ID).unwrap().unwrap(), &[1, 2, 3][..]);
    let bytes = edited(bytes, |dat| assert!(dat.delete(ITERATION_ID).unwrap()));
    assert_eq!(open(&bytes).iteration().unwrap(), None);
}

#[test]
fn v4_the_total_follows_the_highest_iteration_and_older_ones_do_not_replace_newer() {
    let at = |iteration| WriteOptions {
        iteration: Some(iteration),
        ..PLAIN
    };
    let bytes = edited(cell_file(5), |dat| dat.put(9, b"new", &at(40)).unwrap());
    assert_eq!(
        open(&bytes).iteration().unwrap(),
        Some(IterationRecord::complete(40))
    );
    assert_eq!(open(&bytes).find(ITERATION_ID).unwrap().unwrap().version, 1);
    let mut dat = edit(bytes);
    let e = dat.put(9, b"older", &at(39)).unwrap_err();
    assert!(matches!(
        e.kind(),
        ErrorKind::OlderIteration {
            present: 40,
            given: 39
        }
    ));
    dat.put(9, b"same", &at(40)).unwrap();
    dat.put(10, b"lower", &at(7)).unwrap();
    dat.commit().unwrap();
    let dat = open(&close(dat));
    assert_eq!(dat.iteration().unwrap(), Some(IterationRecord::complete(40)));
    assert_eq!(dat.get(9).unwrap().unwrap(), &b"same"[..]);
}

#[test]
fn a_file_without_a_tree_is_an_empty_one() {
    let mut bytes = vec![0; 1024];
    let mut header = cell_file(0);
    header.truncate(0x190);
    bytes[..0x190].copy_from_slice(&header);
    set_word(&mut bytes, 0x148, 1024);
    set_word(&mut bytes, 0x160, 0);
    assert_eq!(open(&bytes).iter().count(), 0);
    assert_eq!(open(&bytes).get(5).unwrap(), None);
    let bytes = edited(bytes, |dat| dat.put(5, b"first", &PLAIN).unwrap());
    assert_eq!(open(&bytes).get(5).unwrap().unwrap(), &b"first"[..]);
    // Emptied again, it has a root without entries.
    let bytes = edited(bytes, |dat| assert!(dat.delete(5).unwrap()));
    assert_eq!(open(&bytes).iter().count(), 0);
    assert_ne!(open(&bytes).header().btree_root, 0);
    assert!(open(&bytes).verify().is_clean());
}

#[test]
fn c11_new_blocks_stand_on_the_grid_of_the_file() {
    // The file ends within its last block, behind the 204 bytes that it holds.
    let mut bytes = cell_file(1);
    let (dat, end) = (open(&bytes), bytes.len() as u32);
    let root = dat.header().btree_root as u32;
    set_word(&mut bytes, 0x148, end - 40);
    bytes.truncate(end as usize - 40);
    let bytes = edited(bytes, |dat| dat.put(5, b"x", &PLAIN).unwrap());
    assert_eq!((open(&bytes).find(5).unwrap().unwrap().offset - root) % 256, 0);
    let report = open(&bytes).verify();
    assert!(report.is_clean(), "{:?}", report.errors);
}

#[test]
fn the_same_on_disk_and_one_editor_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.dat");
    let mut dat = DatEditor::create(&path, Header::new(DatKind::Cell)).unwrap();
    let e = DatEditor::open(&path).err().unwrap();
    assert!(matches!(e.kind(), ErrorKind::InUse) && e.file().ends_with("cell.dat"));
    assert!(matches!(compact(&path).unwrap_err().kind(), ErrorKind::InUse));
    dat.put(0x0001_FFFF, &record(1, 252), &PLAIN).unwrap();
    dat.commit().unwrap();
    drop(dat);
    let mut dat = DatEditor::open(&path).unwrap();
    assert!(dat.delete(0x0001_FFFF).unwrap());
    dat.put(0x0002_FFFF, &record(2, 252), &PLAIN).unwrap();
    dat.commit().unwrap();
    dat.close().unwrap();
    let dat = DatFile::open(&path).unwrap();
    assert_eq!(
        contents(&dat).keys().copied().collect::<Vec<_>>(),
        [0x0002_FFFF, ITERATION_ID]
    );
    assert_eq!(contents(&DatFile::open_in_memory(&path).unwrap()), contents(&dat));
}

#[derive(Debug, Clone)]
enum Edit {
    Put(u32, usize, bool),
    Delete(u32),
    Commit,
    Reopen,
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let edit = prop_oneof![
        6 => (0u32..400, 0usize..900, any::<bool>()).prop_map(|(id, len, z)| Edit::Put(id, len, z)),
        5 => (0u32..400).prop_map(Edit::Delete),
        1 => Just(Edit::Commit),
        1 => Just(Edit::Reopen),
    ];
    proptest::collection::vec(edit, 0..250)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any edits give the file that a map would give, whole and without lost blocks, in any block size.
    #[test]
    fn any_edits_agree_with_a_map(edits in edits(), block in 4i32..80, reuse_free in any::<bool>(), start in 0u32..300) {
        let mut header = Header::new(DatKind::Cell);
        header.block_size = block * 4;
        let mut model = BTreeMap::new();
        let mut dat = DatBuilder::new("test.dat", Vec::new(), header).unwrap();
        for id in 0..start {
            dat.push(id, &record(id, 30), &PLAIN).unwrap();
            model.insert(id, record(id, 30));
        }
        let options = EditOptions { reuse_free, ..EditOptions::default() };
        let open_it = |bytes| DatEditor::edit("test.dat", bytes, options).unwrap();
        let mut dat = open_it(dat.finish().unwrap());
        for (step, edit) in edits.into_iter().enumerate() {
            match edit {
                Edit::Put(id, len, compress) => {
                    let bytes = record(step as u32, len);
                    dat.put(id, &bytes, &WriteOptions { compress, ..PLAIN }).unwrap();
                    model.insert(id, bytes);
                }
                Edit::Delete(id) => prop_assert_eq!(dat.delete(id).unwrap(), model.remove(&id).is_some()),
                Edit::Commit => dat.commit().unwrap(),
                Edit::Reopen => {
                    dat.commit().unwrap();
                    dat = open_it(close(dat));
                }
            }
        }
        dat.commit().unwrap();
        let bytes = close(dat);
        let dat = open(&bytes);
        let report = dat.verify();
        prop_assert!(report.is_clean(), "{:?}", report.errors);
        prop_assert_eq!(report.leaked_blocks, 0);
        let mut got: BTreeMap<u32, Vec<u8>> = contents(&dat).into_iter().map(|(id, r)| (id, r.0)).collect();
        prop_assert_eq!(got.remove(&ITERATION_ID), Some(IterationRecord::complete(1).bytes()));
        prop_assert_eq!(got, model);
    }
}
