//! What the tests of the container share.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::collections::BTreeMap;
use vestibule_dat::{DatBuilder, DatFile, DatKind, Entry, Header, WriteOptions};

/// A file's contents: everything that a reader can see of its records, except where they lie.
pub(crate) type Contents = BTreeMap<u32, (Vec<u8>, u16, u16, u32, i32)>;

/// All records of a file; panics if one cannot be read.
pub(crate) fn contents(dat: &DatFile) -> Contents {
    dat.iter()
        .map(|entry| {
            let e: Entry = entry.unwrap();
            (
                e.id,
                (
                    dat.read(&e).unwrap().into_owned(),
                    e.flags,
                    e.version,
                    e.date,
                    e.iteration,
                ),
            )
        })
        .collect()
}

/// A canonical file with these records.
pub(crate) fn build(kind: DatKind, records: impl IntoIterator<Item = (u32, Vec<u8>)>) -> Vec<u8> {
    let mut dat = DatBuilder::new("built", Vec::new(), Header::new(kind)).unwrap();
    for (id, bytes) in records {
        dat.push(id, &bytes, &WriteOptions::default()).unwrap();
    }
    dat.finish().unwrap()
}

/// Bytes of a record that tell which one it is.
pub(crate) fn record(id: u32, len: usize) -> Vec<u8> {
    id.to_le_bytes().into_iter().cycle().take(len).collect()
}

/// `n` records of a cell file, of one to three blocks.
pub(crate) fn cell_file(n: u32) -> Vec<u8> {
    build(
        DatKind::Cell,
        (0..n).map(|i| (0x0100_0100 + i, record(i, 20 + (i as usize % 7) * 100))),
    )
}

pub(crate) fn open(bytes: &[u8]) -> DatFile {
    DatFile::from_bytes("test.dat", bytes).unwrap()
}

pub(crate) fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

pub(crate) fn set_word(bytes: &mut [u8], at: usize, value: u32) {
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
}

/// A small generator of numbers that look random (xorshift).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(crate) fn below(&mut self, n: u64) -> u64 {
        (self.next() >> 11) % n.max(1)
    }
}
