//! Readers beside a writer, readers in many threads, and the files of an installation together.

mod common;

use common::{build, contents, open, record};
use std::path::Path;
use vestibule_dat::{
    DatBuilder, DatEditor, DatFile, DatKind, DatSet, EditOptions, ErrorKind, Header, WriteOptions, compact,
};

const PLAIN: WriteOptions = WriteOptions {
    version: None,
    date: None,
    iteration: None,
    compress: false,
};

fn write_cell_file(path: &Path, n: u32) {
    std::fs::write(path, build(DatKind::Cell, (0..n).map(|i| (i, record(i, 300))))).unwrap();
}

#[test]
fn w5_a_reader_that_meets_a_freed_block_takes_the_new_state() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.dat");
    write_cell_file(&path, 500);
    for mapped in [cfg!(feature = "mmap"), false] {
        let reader = if mapped {
            DatFile::open(&path)
        } else {
            DatFile::open_in_memory(&path)
        }
        .unwrap();
        let old = reader.get(7).unwrap().unwrap();
        let old_bytes = old.to_vec();
        let entry = reader.find(8).unwrap().unwrap();
        let mut walk = reader.iter();
        let before: Vec<_> = walk.by_ref().take(100).map(|e| e.unwrap().id).collect();
        assert_eq!(before, (0..100).collect::<Vec<_>>());

        let mut writer = DatEditor::open(&path).unwrap();
        for id in 0..500 {
            writer.put(id, &record(id + 9, 700), &PLAIN).unwrap();
        }
        writer.put(1000, b"new", &PLAIN).unwrap();
        writer.commit().unwrap();
        assert_eq!(
            reader.get(7).unwrap().unwrap(),
            old_bytes,
            "until blocks are freed, the old state is there"
        );
        writer.close().unwrap();

        // By a map the freed blocks show; in memory the old state stays for good.
        let (seven, eight) = if mapped {
            (record(16, 700), record(17, 700))
        } else {
            (record(7, 300), record(8, 300))
        };
        assert_eq!(reader.get(7).unwrap().unwrap(), seven);
        assert_eq!(
            reader.read(&entry).unwrap(),
            eight,
            "also by an entry from before"
        );
        let rest: Vec<_> = walk.map(|e| e.unwrap().id).collect();
        assert_eq!(rest[..400], (100..500).collect::<Vec<_>>());
        assert_eq!(*old, *old_bytes, "what was borrowed before is as it was");
        write_cell_file(&folder.path().join("fresh.dat"), 500);
        std::fs::rename(folder.path().join("fresh.dat"), &path).unwrap();
    }
}

#[cfg(feature = "mmap")]
#[test]
fn w5_only_if_nothing_changed_is_the_record_corrupt() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.dat");
    write_cell_file(&path, 100);
    let reader = DatFile::open(&path).unwrap();
    let size = reader.header().file_size;
    let mut writer = DatEditor::open(&path).unwrap();
    writer.replace(5, &record(77, 300), &PLAIN).unwrap();
    writer.delete(6).unwrap();
    writer.commit().unwrap();
    writer.close().unwrap();
    assert_eq!(reader.get(5).unwrap().unwrap(), record(77, 300));
    assert!(reader.header().file_size > size, "the longer file is mapped");
    assert_eq!(reader.get(6).unwrap(), None);
    drop(reader);

    // The same mark without a commit is damage.
    let mut bytes = std::fs::read(&path).unwrap();
    let at = open(&bytes).find(50).unwrap().unwrap().offset as usize;
    bytes[at + 3] |= 0x80;
    std::fs::write(&path, &bytes).unwrap();
    let e = DatFile::open(&path).unwrap().get(50).unwrap_err();
    assert!(matches!(e.kind(), ErrorKind::FreeBlock) && e.id() == Some(50) && e.offset() == Some(at as u64));
}

#[test]
fn w5_many_commits_under_one_reader() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.dat");
    write_cell_file(&path, 50);
    let reader = DatFile::open(&path).unwrap();
    for round in 0..200u32 {
        let mut writer = DatEditor::open(&path).unwrap();
        for id in 0..50 {
            writer.put(id, &record(round, 300), &PLAIN).unwrap();
        }
        writer.commit().unwrap();
        writer.close().unwrap();
        let got = reader.get(round % 50).unwrap().unwrap();
        assert_eq!(got.len(), 300);
        if cfg!(feature = "mmap") {
            assert_eq!(*got, record(round, 300));
        }
    }
}

#[test]
fn w5_readers_in_threads_beside_a_writer() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.dat");
    // All bytes of a record are equal, whatever the state.
    std::fs::write(&path, build(DatKind::Cell, (0..200).map(|i| (i, vec![0; 600])))).unwrap();
    let reader = DatFile::open(&path).unwrap();
    std::thread::scope(|scope| {
        for thread in 0..4u32 {
            let reader = &reader;
            scope.spawn(move || {
                let mut buffer = Vec::new();
                for i in 0..8000 {
                    let id = (i * 7 + thread * 13) % 200;
                    let bytes = reader.get(id).unwrap().unwrap();
                    assert!(bytes.len() == 600 && bytes.iter().all(|b| *b == bytes[0]));
                    reader.read_into(id, &mut buffer).unwrap().unwrap();
                    assert!(buffer.len() == 600 && buffer.iter().all(|b| *b == buffer[0]));
                    if i % 500 == 0 {
                        assert_eq!(
                            reader
                                .range(..200)
                                .map(|e| e.unwrap().id)
                                .collect::<Vec<_>>()
                                .len(),
                            200
                        );
                    }
                }
            });
        }
        for round in 1..20u8 {
            let mut writer = DatEditor::open(&path).unwrap();
            for id in 0..200 {
                writer.put(id, &[round; 600], &PLAIN).unwrap();
            }
            writer.commit().unwrap();
            writer.close().unwrap();
        }
    });
}

#[test]
fn w1_a_reader_keeps_the_file_that_was_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.dat");
    write_cell_file(&path, 100);
    let reader = DatFile::open(&path).unwrap();
    let mut dat = DatBuilder::create(&path, Header::new(DatKind::Cell)).unwrap();
    dat.push(3, b"other", &PLAIN).unwrap();
    dat.finish().unwrap();
    compact(&path).unwrap();
    assert_eq!(reader.iter().count(), 101);
    assert_eq!(reader.get(99).unwrap().unwrap(), record(99, 300));
    assert_eq!(DatFile::open(&path).unwrap().iter().count(), 2);
}

#[test]
fn readers_are_shared_between_threads() {
    fn shared<T: Send + Sync>() {}
    shared::<DatFile>();
    shared::<DatSet>();
    fn sent<T: Send>() {}
    sent::<DatEditor>();
    sent::<vestibule_dat::Entries<'_>>();
}

#[test]
fn zero_copy_when_a_record_lies_in_one_block() {
    let dat = open(&build(DatKind::Cell, [(1, vec![1; 252]), (2, vec![2; 253])]));
    assert!(matches!(
        dat.get(1).unwrap().unwrap(),
        std::borrow::Cow::Borrowed(_)
    ));
    assert!(matches!(dat.get(2).unwrap().unwrap(), std::borrow::Cow::Owned(_)));
}

fn save(folder: &Path, name: &str, kind: DatKind, records: &[(u32, &[u8])]) {
    let bytes = build(kind, records.iter().map(|(id, bytes)| (*id, bytes.to_vec())));
    std::fs::write(folder.join(name), bytes).unwrap();
}

#[test]
fn f3_look_up_order() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let portal: &[(u32, &[u8])] = &[
        (0x0100_0100, b"gfx"),
        (0x0600_0001, b"low"),
        (0x2100_0001, b"no"),
        (0x2200_0001, b"enum"),
    ];
    save(folder, "Client_Portal.DAT", DatKind::Portal, portal);
    save(
        folder,
        "CLIENT_CELL_1.dat",
        DatKind::Cell,
        &[(0x0100_0100, b"cell"), (0xA9B4_FFFF, b"land")],
    );
    let set = DatSet::open(folder).unwrap();
    assert!(set.highres().is_none() && set.local().is_none());
    assert_eq!(set.get_asset(0x0600_0002).unwrap(), None);
    assert_eq!(
        set.get_asset(0x2100_0001).unwrap(),
        None,
        "without a local file there are no local records"
    );

    let high: &[(u32, &[u8])] = &[
        (0x0600_0001, b"high"),
        (0x0600_0002, b"high"),
        (0x0800_0001, b"no"),
    ];
    save(folder, "client_highres.dat", DatKind::HighRes, high);
    let local: &[(u32, &[u8])] = &[
        (0x2100_0001, b"ui"),
        (0x2300_0001, b"text"),
        (0x2400_0001, b"text2"),
        (0x4100_0001, b"state"),
    ];
    save(folder, "client_local_english.dat", DatKind::Local, local);
    save(
        folder,
        "client_local_Deutsch.dat",
        DatKind::Local,
        &[(0x2100_0001, b"de")],
    );
    for set in [
        DatSet::open(folder).unwrap(),
        DatSet::open_in_memory(folder).unwrap(),
    ] {
        let asset = |id| {
            set.get_asset(id)
                .unwrap()
                .map(|b| String::from_utf8(b.into_owned()).unwrap())
        };
        assert_eq!(
            asset(0x0600_0001).as_deref(),
            Some("low"),
            "portal before highres"
        );
        assert_eq!(asset(0x0600_0002).as_deref(), Some("high"));
        assert_eq!(asset(0x0800_0001), None, "highres has textures only");
        assert_eq!(asset(0x2100_0001).as_deref(), Some("ui"));
        assert_eq!(asset(0x2300_0001).as_deref(), Some("text"));
        assert_eq!(asset(0x2400_0001).as_deref(), Some("text2"));
        assert_eq!(asset(0x4100_0001).as_deref(), Some("state"));
        assert_eq!(asset(0x2200_0001).as_deref(), Some("enum"));
        assert_eq!(asset(0x0100_0100).as_deref(), Some("gfx"));
        assert_eq!(set.get_cell(0x0100_0100).unwrap().unwrap(), &b"cell"[..]);
        assert_eq!(set.get(0x0100_0100).unwrap().unwrap(), &b"gfx"[..]);
        assert_eq!(set.get(0xA9B4_FFFF).unwrap().unwrap(), &b"land"[..]);
        assert_eq!(set.get(0x0999_0000).unwrap(), None);
        assert_eq!(
            set.files_with(0x0100_0100).unwrap(),
            [DatKind::Portal, DatKind::Cell]
        );
        assert_eq!(
            set.files_with(0x0600_0001).unwrap(),
            [DatKind::Portal, DatKind::HighRes]
        );
        assert_eq!(set.files().count(), 4);
    }
    std::fs::remove_file(folder.join("client_local_english.dat")).unwrap();
    let set = DatSet::open(folder).unwrap();
    assert_eq!(
        set.get_asset(0x2100_0001).unwrap().unwrap(),
        &b"de"[..],
        "another language is better than none"
    );
}

#[test]
fn portal_and_cell_are_needed_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let missing = |name: &str| {
        let e = DatSet::open(folder).unwrap_err();
        assert!(
            matches!(e.kind(), ErrorKind::MissingFile) && e.file().ends_with(name),
            "{e}"
        );
    };
    missing("client_portal.dat");
    save(folder, "client_portal.dat", DatKind::Portal, &[]);
    missing("client_cell_1.dat");
    save(folder, "client_cell_1.dat", DatKind::Portal, &[]);
    let e = DatSet::open(folder).unwrap_err();
    assert!(
        matches!(e.kind(), ErrorKind::WrongKind { .. }) && e.file().ends_with("client_cell_1.dat"),
        "{e}"
    );
    save(folder, "client_cell_1.dat", DatKind::Cell, &[]);
    DatSet::open(folder).unwrap();
    std::fs::write(folder.join("client_highres.dat"), b"junk").unwrap();
    assert!(
        DatSet::open(folder)
            .unwrap_err()
            .file()
            .ends_with("client_highres.dat")
    );
}

#[test]
fn an_edit_of_a_file_in_memory_is_a_file_again() {
    let bytes = build(DatKind::Cell, [(1, vec![1])]);
    let before = contents(&open(&bytes));
    let dat = DatEditor::edit("memory", bytes, EditOptions::default()).unwrap();
    let (_, bytes) = dat.close_with().unwrap();
    assert_eq!(contents(&open(&bytes)), before);
}
