//! A writer that is stopped at any moment leaves the file wholly old or wholly new (`dat-format.md` 5.4 W2 to W4).
//!
//! The simulated half records every step of a writer and looks at what the disk may hold after any of them: all steps before the
//! last flush, and of those after it any part, in any order. The real half kills a writing process.

mod common;

use common::{Contents, Random, cell_file, contents, open, record};
use proptest::prelude::*;
use std::cell::RefCell;
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::rc::Rc;
use std::time::{Duration, Instant};
use vestibule_dat::{
    DatBuilder, DatEditor, DatFile, DatKind, EditOptions, Header, Storage, WriteOptions, compact,
};

const PLAIN: WriteOptions = WriteOptions {
    version: None,
    date: None,
    iteration: None,
    compress: false,
};

#[derive(Debug, Clone)]
enum Step {
    Write(u64, Vec<u8>),
    SetLen(u64),
    Sync,
}

impl Step {
    fn apply(&self, disk: &mut Vec<u8>) {
        match self {
            Step::Write(at, bytes) => disk.write_at(*at, bytes).unwrap(),
            Step::SetLen(len) => disk.resize(*len as usize, 0),
            Step::Sync => {}
        }
    }
}

/// Storage in memory that records each step.
struct Recorded {
    bytes: Vec<u8>,
    steps: Rc<RefCell<Vec<Step>>>,
}

impl Storage for Recorded {
    fn size(&self) -> io::Result<u64> {
        self.bytes.size()
    }

    fn read_at(&self, offset: u64, buf: &mut [u8]) -> io::Result<()> {
        self.bytes.read_at(offset, buf)
    }

    fn write_at(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        self.steps.borrow_mut().push(Step::Write(offset, bytes.to_vec()));
        self.bytes.write_at(offset, bytes)
    }

    fn set_size(&mut self, len: u64) -> io::Result<()> {
        self.steps.borrow_mut().push(Step::SetLen(len));
        self.bytes.set_size(len)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.steps.borrow_mut().push(Step::Sync);
        Ok(())
    }
}

/// What a writer did: its steps, and after how many of them which contents are committed.
struct Recording {
    before: Vec<u8>,
    steps: Vec<Step>,
    /// (steps done, contents), the state before the first batch first.
    commits: Vec<(usize, Contents)>,
}

fn run(before: Vec<u8>, reuse_free: bool, batches: &[Vec<(u32, Option<usize>)>], close: bool) -> Recording {
    let steps = Rc::new(RefCell::new(Vec::new()));
    let storage = Recorded {
        bytes: before.clone(),
        steps: steps.clone(),
    };
    let mut commits = vec![(0, contents(&open(&before)))];
    let options = EditOptions {
        reuse_free,
        ..EditOptions::default()
    };
    let mut dat = DatEditor::edit("test.dat", storage, options).unwrap();
    for (number, batch) in batches.iter().enumerate() {
        let mut now = commits.last().unwrap().1.clone();
        for (id, len) in batch {
            match len {
                Some(len) => {
                    let bytes = record(1000 * number as u32 + id, *len);
                    dat.put(*id, &bytes, &PLAIN).unwrap();
                    now.insert(*id, (bytes, 0, 2, 0, 1));
                }
                None => {
                    dat.delete(*id).unwrap();
                    now.remove(id);
                }
            }
        }
        dat.commit().unwrap();
        commits.push((steps.borrow().len(), now));
    }
    if close {
        dat.close().unwrap();
    }
    let steps = steps.borrow().clone();
    Recording {
        before,
        steps,
        commits,
    }
}

/// The contents must be those of the last commit before step `at`, or, while a batch is under way, of the next.
fn check(recording: &Recording, at: usize, disk: &[u8], what: &str) {
    let now = contents(&open(disk));
    let old = recording
        .commits
        .iter()
        .rposition(|(steps, _)| *steps <= at)
        .unwrap();
    let is = |i: usize| recording.commits.get(i).is_some_and(|(_, c)| *c == now);
    assert!(
        is(old) || is(old + 1),
        "step {at} of {}, {what}: neither old nor new",
        recording.steps.len()
    );
    let report = open(disk).verify();
    // While blocks are being freed the list may be broken; while a batch is written, not even that (W4).
    let freeing = recording.commits.last().is_some_and(|(steps, _)| at > *steps);
    let broken: Vec<_> = report
        .errors
        .iter()
        .filter(|e| !(freeing && free_list_only(e)))
        .collect();
    assert!(broken.is_empty(), "step {at}, {what}: {broken:?}");
}

fn free_list_only(e: &vestibule_dat::Error) -> bool {
    matches!(e.kind(), vestibule_dat::ErrorKind::FreeList(_))
}

/// The file can be edited again, and is then whole in every respect.
fn check_recovery(disk: Vec<u8>, reuse_free: bool) {
    let mut expected = contents(&open(&disk));
    let options = EditOptions {
        reuse_free,
        ..EditOptions::default()
    };
    let mut dat = DatEditor::edit("test.dat", disk, options).unwrap();
    for id in [3u32, 0x0100_0105, 0x0900_0000] {
        dat.put(id, &record(id, 700), &PLAIN).unwrap();
        expected.insert(id, (record(id, 700), 0, 2, 0, 1));
    }
    dat.commit().unwrap();
    let (_, bytes) = dat.close_with().unwrap();
    assert_eq!(contents(&open(&bytes)), expected);
    let report = open(&bytes).verify();
    assert!(report.is_clean(), "{:?}", report.errors);
}

/// A disk after `at` steps of which those behind the last flush arrived only in part.
fn torn(recording: &Recording, at: usize, random: &mut Random) -> Vec<u8> {
    let done = &recording.steps[..at];
    let flushed = done
        .iter()
        .rposition(|s| matches!(s, Step::Sync))
        .map_or(0, |i| i + 1);
    let mut disk = recording.before.clone();
    done[..flushed].iter().for_each(|s| s.apply(&mut disk));
    for step in &done[flushed..] {
        match step {
            // One sector goes in one piece.
            Step::Write(offset, bytes) if *offset + bytes.len() as u64 <= 512 => {
                if random.below(2) == 0 {
                    step.apply(&mut disk);
                }
            }
            Step::Write(offset, bytes) => {
                // Any of its sectors, and possibly the length without them.
                if random.below(2) == 0 {
                    let end = *offset as usize + bytes.len();
                    disk.resize(disk.len().max(end), 0);
                }
                let mut at = 0;
                while at < bytes.len() {
                    let sector_end = (*offset as usize + at) / 512 * 512 + 512 - *offset as usize;
                    let end = sector_end.min(bytes.len());
                    if random.below(3) > 0 {
                        disk.write_at(*offset + at as u64, &bytes[at..end]).unwrap();
                    }
                    at = end;
                }
            }
            Step::SetLen(_) => {
                if random.below(2) == 0 {
                    step.apply(&mut disk);
                }
            }
            Step::Sync => {}
        }
    }
    disk
}

fn check_everywhere(recording: &Recording, reuse_free: bool, random: &mut Random, tears: usize) {
    let mut disk = recording.before.clone();
    for at in 0..=recording.steps.len() {
        if let Some(step) = at.checked_sub(1).map(|i| &recording.steps[i]) {
            step.apply(&mut disk);
        }
        check(recording, at, &disk, "all steps done");
        check_recovery(disk.clone(), reuse_free);
        for _ in 0..tears {
            let disk = torn(recording, at, random);
            check(recording, at, &disk, "torn");
            check_recovery(disk, reuse_free);
        }
    }
}

#[test]
fn w2_every_prefix_of_the_steps_is_old_or_new() {
    let batches = vec![
        vec![(0x0100_0105, Some(900)), (0x0100_0106, None), (7, Some(0))],
        (0..40).map(|i| (0x0100_0100 + 3 * i, None)).collect(),
        (0..80).map(|i| (0x0200_0000 + i, Some(300))).collect(),
    ];
    for reuse_free in [false, true] {
        // With an uncommitted tail in front and a free list from an earlier edit.
        let mut before = run_to_the_end(cell_file(150));
        before.extend_from_slice(&[0xEE; 700]);
        let recording = run(before, reuse_free, &batches, true);
        assert!(recording.steps.len() > 30);
        check_everywhere(&recording, reuse_free, &mut Random(7), 4);
    }
}

/// A file after an edit that was closed, so that it has free blocks.
fn run_to_the_end(before: Vec<u8>) -> Vec<u8> {
    let recording = run(
        before,
        false,
        &[(0..9).map(|i| (0x0100_0100 + 16 * i, Some(50))).collect()],
        true,
    );
    let mut disk = recording.before;
    recording.steps.iter().for_each(|s| s.apply(&mut disk));
    assert!(open(&disk).header().free_count > 9);
    disk
}

#[test]
fn w4_a_crash_while_free_blocks_are_reused_never_shows_a_live_block_as_free() {
    let before = run_to_the_end(cell_file(60));
    let batches = vec![
        vec![(0x0100_0104, Some(100))],
        vec![(0x0100_0105, Some(100)), (0x0100_0104, Some(40))],
    ];
    let recording = run(before, true, &batches, true);
    check_everywhere(&recording, true, &mut Random(3), 12);
}

#[test]
fn w1_a_builder_that_is_stopped_leaves_nothing_that_opens() {
    let steps = Rc::new(RefCell::new(Vec::new()));
    let storage = Recorded {
        bytes: Vec::new(),
        steps: steps.clone(),
    };
    let mut dat = DatBuilder::new("test.dat", storage, Header::new(DatKind::Cell)).unwrap();
    for id in 0..100 {
        dat.push(id, &record(id, 300), &PLAIN).unwrap();
    }
    dat.finish().unwrap();
    let steps = steps.borrow();
    let mut disk = Vec::new();
    for (i, step) in steps.iter().enumerate() {
        let header_written = steps[..i].iter().any(|s| matches!(s, Step::Write(0, _)));
        assert_eq!(
            DatFile::from_bytes("test.dat", disk.clone()).is_ok(),
            header_written,
            "step {i}"
        );
        step.apply(&mut disk);
    }
    assert_eq!(open(&disk).iter().count(), 101);
}

fn batches() -> impl Strategy<Value = Vec<Vec<(u32, Option<usize>)>>> {
    let ids = prop_oneof![0x0100_0100u32..0x0100_0180, 0u32..40];
    let edit = (ids, proptest::option::of(0usize..1500));
    proptest::collection::vec(proptest::collection::vec(edit, 0..60), 1..4)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Any batches, stopped after any step, with unflushed steps torn apart.
    #[test]
    fn w2_any_batches_stopped_anywhere(
        batches in batches(),
        reuse_free in any::<bool>(),
        close in any::<bool>(),
        records in 0u32..130,
        seed in 1u64..,
    ) {
        let mut before = cell_file(records);
        if records > 16 * 9 - 8 {
            before = run_to_the_end(before);
        }
        let recording = run(before, reuse_free, &batches, close);
        check_everywhere(&recording, reuse_free, &mut Random(seed), 1);
    }
}

// The real half.

/// Names the file that a child of this test writes.
const CHILD: &str = "VESTIBULE_TEST_KILLED_WRITER";
/// Records that every generation rewrites.
const RECORDS: u32 = 60;

/// The child: writes one generation after the other until it is killed. Does nothing in an ordinary test run.
#[test]
fn killed_writer_child() {
    let Ok(path) = std::env::var(CHILD) else { return };
    let path = Path::new(&path);
    let mut random = Random(u64::from(std::process::id()) | 1 << 40);
    let mut generation = DatFile::open(path).map_or(0, |dat| generation_of(&dat));
    loop {
        let options = EditOptions {
            reuse_free: random.below(2) == 0,
            ..EditOptions::default()
        };
        let mut dat = DatEditor::open_with(path, options).unwrap();
        for _ in 0..1 + random.below(4) {
            generation += 1;
            write_generation(&mut dat, generation);
            dat.commit().unwrap();
            // Tells the parent that writing is under way.
            let _ = writeln!(io::stdout(), "generation {generation}");
        }
        match random.below(3) {
            0 => drop(dat),
            1 => {
                dat.close().unwrap();
            }
            _ => {
                dat.close().unwrap();
                compact(path).unwrap();
            }
        }
    }
}

/// All records tell the generation; which others exist follows from it.
fn write_generation(dat: &mut DatEditor, generation: u32) {
    for id in 0..RECORDS {
        let len = 4 + ((generation * 31 + id * 17) % 700) as usize;
        dat.put(0x0100_0100 + id, &record(generation, len), &PLAIN)
            .unwrap();
    }
    for id in extras(generation - 1) {
        dat.delete(id).unwrap();
    }
    for id in extras(generation) {
        dat.put(id, &record(generation, 10), &PLAIN).unwrap();
    }
}

fn extras(generation: u32) -> impl Iterator<Item = u32> {
    let n = if generation == 0 { 0 } else { generation % 50 };
    (0..n).map(move |i| 0x0500_0000 + generation * 100 + i)
}

fn generation_of(dat: &DatFile) -> u32 {
    let bytes = dat.get(0x0100_0100).unwrap().unwrap();
    u32::from_le_bytes(bytes[..4].try_into().unwrap())
}

fn check_generation(path: &Path) -> u32 {
    let dat = DatFile::open(path).unwrap();
    let generation = generation_of(&dat);
    let mut records = contents(&dat);
    records.remove(&vestibule_dat::ITERATION_ID);
    for id in (0..RECORDS).map(|i| 0x0100_0100 + i).chain(extras(generation)) {
        let (bytes, ..) = records
            .remove(&id)
            .unwrap_or_else(|| panic!("0x{id:08X} of generation {generation} is gone"));
        assert_eq!(
            bytes[..4],
            generation.to_le_bytes(),
            "0x{id:08X} is of another generation"
        );
    }
    assert!(
        records.is_empty(),
        "generation {generation} has records of another: {:?}",
        records.keys()
    );
    let report = dat.verify();
    let broken: Vec<_> = report.errors.iter().filter(|e| !free_list_only(e)).collect();
    assert!(broken.is_empty(), "{broken:?}");
    generation
}

#[test]
fn a_process_killed_at_200_random_moments_leaves_the_file_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("killed.dat");
    let mut dat = DatBuilder::create(&path, Header::new(DatKind::Cell)).unwrap();
    for id in 0..RECORDS {
        dat.push(0x0100_0100 + id, &record(0, 30), &PLAIN).unwrap();
    }
    dat.finish().unwrap();
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut last = 0;
    let mut kills = 0;
    while kills < 200 {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args([
                "--exact",
                "killed_writer_child",
                "--nocapture",
                "--test-threads=1",
            ])
            .env(CHILD, &path)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Most are killed while they write; some before, while they open the file.
        if random.below(8) > 0 {
            let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
            let begun = lines
                .by_ref()
                .map_while(Result::ok)
                .any(|line| line.contains("generation"));
            assert!(begun, "the child ended by itself");
            std::thread::spawn(move || lines.for_each(drop));
        }
        let wait = Duration::from_micros(random.below(12_000));
        let start = Instant::now();
        while start.elapsed() < wait {
            std::hint::spin_loop();
        }
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(!output.status.success(), "the child was killed");
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert!(!complaint.contains("panicked"), "{complaint}");
        let generation = check_generation(&path);
        assert!(generation >= last, "a committed generation is lost");
        last = generation;
        kills += 1;
    }
    assert!(last > 100, "the children have written: {last} generations");
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert!(left <= 2, "left-over files are removed at the next write");
    let (before, after) = compact(&path).unwrap();
    assert!(after <= before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert_eq!(check_generation(&path), last);
}
