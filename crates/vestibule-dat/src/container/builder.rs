//! Writing a whole file in canonical form (`dat-format.md` 5.1, 5.4 W1, W6, W7).

use super::chain_writer::ChainWriter;
use super::compress::deflate;
use super::dat_file::DatFile;
use super::header::{DATA_START, DatKind, Header, MAX_WRITE_BLOCK, TRANSACTION_CLEAN};
use super::iteration::{ITERATION_ID, IterationRecord};
use super::node::{Entry, MAX_ENTRIES, node_bytes};
use super::storage::{NewFile, Storage};
use crate::error::{Error, ErrorKind, Fault, Result};
use std::path::Path;

/// What a writer puts into the directory beside the bytes; `None` is what [`DatBuilder`] or [`crate::DatEditor`] say it is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Pack version of the record.
    pub version: Option<u16>,
    /// Seconds since 1970-01-01 UTC.
    pub date: Option<u32>,
    /// Patch iteration that writes the record.
    pub iteration: Option<i32>,
    /// Stores the record compressed if that is shorter (B9). The retail client cannot load such records.
    pub compress: bool,
}

/// Writes a whole file in one go: records in ascending id order, then the directory.
///
/// The output is canonical (W7): the same input gives the same bytes. What is not given: version 2 (1 for the iteration
/// record), date 0, iteration 1. The iteration record is added unless it is given; its total is the highest iteration pushed.
///
/// # Example
/// ```
/// use vestibule_dat::{DatBuilder, DatFile, DatKind, Header, WriteOptions};
///
/// let mut dat = DatBuilder::new("cell", Vec::new(), Header::new(DatKind::Cell))?;
/// dat.push(0xA9B4_FFFF, &[1, 2, 3], &WriteOptions::default())?;
/// let bytes = dat.finish()?;
///
/// let dat = DatFile::from_bytes("cell", bytes)?;
/// assert_eq!(dat.get(0xA9B4_FFFF)?.as_deref(), Some(&[1, 2, 3][..]));
/// # Ok::<(), vestibule_dat::Error>(())
/// ```
pub struct DatBuilder<S: Storage> {
    name: String,
    out: ChainWriter<S>,
    header: Header,
    entries: Vec<Entry>,
    iteration: Iteration,
    /// Highest iteration pushed, at least 1.
    total: i32,
}

/// What becomes of the iteration record.
enum Iteration {
    /// It is added where its id belongs.
    Add,
    /// It is added already; its bytes are written when the total is known.
    AddedAt(u32),
    /// The caller has given it, or wants none.
    Given,
}

impl Header {
    /// The header of a new file of a kind: its block size and data set, clean transaction record, everything else 0 (5.1).
    pub fn new(kind: DatKind) -> Header {
        let (block_size, data_set, data_subset) = match kind {
            DatKind::Portal => (1024, 1, 0),
            DatKind::Cell => (256, 2, 1),
            DatKind::Local => (1024, 3, 1),
            DatKind::HighRes => (1024, 1, 0x6946_6948),
        };
        Header {
            version_string: [0; 256],
            transaction: TRANSACTION_CLEAN,
            block_size,
            file_size: 0,
            data_set,
            data_subset,
            first_free: 0,
            final_free: 0,
            free_count: 0,
            btree_root: 0,
            young_lru: 0,
            old_lru: 0,
            use_lru: 0,
            master_map_id: 0,
            engine_pack_version: 0,
            game_pack_version: 0,
            version_major: [0; 16],
            version_minor: 0,
        }
    }
}

impl DatBuilder<NewFile> {
    /// Starts a file that replaces `path` when it is finished (W1). Dropped before that, it leaves `path` as it was.
    ///
    /// # Errors
    /// Another writer holds `path`, its folder cannot be written, or the header's block size cannot be used.
    pub fn create(path: impl AsRef<Path>, header: Header) -> Result<DatBuilder<NewFile>> {
        let path = path.as_ref();
        DatBuilder::new(path.display().to_string(), NewFile::create(path)?, header)
    }
}

impl<S: Storage> DatBuilder<S> {
    /// Starts a file in `storage`, which must be empty. `name` stands for it in errors. Of the header, the sizes and the free
    /// list are filled in by the builder; all else is taken as it is.
    ///
    /// # Errors
    /// The header's block size cannot be used: below 16, above 1 MiB, or no multiple of 4.
    pub fn new(name: impl Into<String>, storage: S, header: Header) -> Result<DatBuilder<S>> {
        let name = name.into();
        let size = header.block_size;
        if !(16..=MAX_WRITE_BLOCK).contains(&size) || size % 4 != 0 {
            return Err(Error::new(name, "block_size", ErrorKind::BadBlockSize(size)));
        }
        Ok(DatBuilder {
            out: ChainWriter::new(storage, size as u32, u64::from(DATA_START)),
            name,
            header,
            entries: Vec::new(),
            iteration: Iteration::Add,
            total: 1,
        })
    }

    /// Adds a record.
    ///
    /// # Errors
    /// The id is not above the one before ([`ErrorKind::NotAscending`]), the file would pass 2 GiB, or it cannot be written.
    pub fn push(&mut self, id: u32, bytes: &[u8], options: &WriteOptions) -> Result<()> {
        let compressed = if options.compress { deflate(bytes) } else { None };
        let entry = Entry {
            id,
            flags: u16::from(compressed.is_some()),
            version: options.version.unwrap_or(default_version(id)),
            offset: 0,
            size: 0,
            date: options.date.unwrap_or(0),
            iteration: options.iteration.unwrap_or(1),
        };
        self.push_stored(&entry, compressed.as_deref().unwrap_or(bytes))
    }

    /// Adds a record whose stored bytes and directory entry are taken over from elsewhere (W6); offset and size are filled in.
    ///
    /// # Errors
    /// As [`DatBuilder::push`].
    pub fn push_stored(&mut self, entry: &Entry, stored: &[u8]) -> Result<()> {
        if entry.id == ITERATION_ID && matches!(self.iteration, Iteration::Add) {
            self.iteration = Iteration::Given;
        } else if entry.id > ITERATION_ID {
            self.add_iteration()?;
        }
        self.total = self.total.max(entry.iteration);
        self.append(entry, stored)
    }

    /// Adds every record of `from`, byte for byte, with version, flags, iteration and date (W6).
    ///
    /// # Errors
    /// As [`DatBuilder::push`], and if `from` is damaged: what cannot be read cannot be kept.
    pub fn push_all(&mut self, from: &DatFile) -> Result<()> {
        for entry in from {
            let entry = entry?;
            self.push_stored(&entry, &from.read_stored(&entry)?)?;
        }
        Ok(())
    }

    /// Adds no iteration record. Without this one is added unless it is pushed.
    pub fn without_iteration_record(&mut self) {
        if let Iteration::Add = self.iteration {
            self.iteration = Iteration::Given;
        }
    }

    /// Makes the total of the added iteration record at least `total`.
    pub fn raise_iteration(&mut self, total: i32) {
        self.total = self.total.max(total);
    }

    /// Number of records so far.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are no records yet.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Writes the directory and the header, and publishes the file. Gives the storage back.
    ///
    /// # Errors
    /// The file would pass 2 GiB, it cannot be written, or the file it replaces is in use. The old file then stays.
    pub fn finish(mut self) -> Result<S> {
        self.add_iteration()?;
        let io = |e: std::io::Error| Error::new(self.name.clone(), "file", e.into());
        let entries = std::mem::take(&mut self.entries);
        self.header.btree_root =
            write_tree(&mut self.out, entries).map_err(|fault| fault.named(&self.name, None))? as i32;
        self.header.file_size = self.out.end() as u32;
        (
            self.header.first_free,
            self.header.final_free,
            self.header.free_count,
        ) = (0, 0, 0);
        let (mut storage, _) = self.out.finish().map_err(io)?;
        if let Iteration::AddedAt(block) = self.iteration {
            let bytes = IterationRecord::complete(self.total).bytes();
            storage.write_at(u64::from(block) + 4, &bytes).map_err(io)?;
        }
        let mut first = self.header.bytes().to_vec();
        first.resize(DATA_START as usize, 0);
        storage.write_at(0, &first).map_err(io)?;
        storage.publish().map_err(|e| match e.kind() {
            std::io::ErrorKind::PermissionDenied | std::io::ErrorKind::ResourceBusy => {
                Error::new(self.name.clone(), "rename", ErrorKind::InUse)
            }
            _ => Error::new(self.name.clone(), "rename", e.into()),
        })?;
        Ok(storage)
    }

    fn add_iteration(&mut self) -> Result<()> {
        if !matches!(self.iteration, Iteration::Add) {
            return Ok(());
        }
        let entry = Entry {
            id: ITERATION_ID,
            flags: 0,
            version: default_version(ITERATION_ID),
            offset: 0,
            size: 0,
            date: 0,
            iteration: 1,
        };
        self.append(&entry, &IterationRecord::complete(1).bytes())?;
        if let Some(last) = self.entries.last() {
            self.iteration = Iteration::AddedAt(last.offset);
        }
        Ok(())
    }

    fn append(&mut self, entry: &Entry, stored: &[u8]) -> Result<()> {
        if let Some(last) = self.entries.last()
            && last.id >= entry.id
        {
            let kind = ErrorKind::NotAscending { previous: last.id };
            return Err(Error::new(self.name.clone(), "id", kind).with_id(entry.id));
        }
        let offset = self
            .out
            .chain(stored)
            .map_err(|fault| fault.named(&self.name, Some(entry.id)))?;
        self.entries.push(Entry {
            offset,
            size: stored.len() as u32,
            ..*entry
        });
        Ok(())
    }
}

/// Pack version of a new record (B1).
pub(crate) fn default_version(id: u32) -> u16 {
    if id == ITERATION_ID { 1 } else { 2 }
}

/// Writes the tree of W7 bottom-up and gives the offset of its root.
fn write_tree<S: Storage>(out: &mut ChainWriter<S>, entries: Vec<Entry>) -> Result<u32, Fault> {
    let mut entries = entries;
    let mut children: Vec<u32> = Vec::new();
    loop {
        let mut separators = Vec::new();
        let mut nodes = Vec::new();
        let (mut entry_at, mut child_at) = (0, 0);
        for size in level_sizes(entries.len()) {
            let own = entries.get(entry_at..entry_at + size).unwrap_or_default();
            let below = children.get(child_at..child_at + size + 1).unwrap_or_default();
            nodes.push(out.chain(&node_bytes(own, below))?);
            separators.extend(entries.get(entry_at + size));
            entry_at += size + 1;
            child_at += size + 1;
        }
        match nodes[..] {
            [root] => return Ok(root),
            _ => (entries, children) = (separators, nodes),
        }
    }
}

/// How many of `n` entries each node of a level takes (W7).
fn level_sizes(n: usize) -> Vec<usize> {
    if n <= MAX_ENTRIES {
        return vec![n];
    }
    let nodes = (n + 1).div_ceil(MAX_ENTRIES + 1);
    let mut sizes = vec![MAX_ENTRIES; nodes - 2];
    let rest = n - (nodes - 1) - MAX_ENTRIES * (nodes - 2);
    sizes.extend([rest.div_ceil(2), rest / 2]);
    sizes
}

/// Writes the file at `path` anew without gaps, free blocks or slack, and puts it in place of the old one (W1).
///
/// Every record, known or not, is kept byte for byte with its version, flags, iteration and date, and so are the header's
/// version fields (W6). Gives the sizes in bytes before and after.
///
/// # Errors
/// The file is damaged, another writer holds it, or it cannot be replaced. The old file then stays.
pub fn compact(path: impl AsRef<Path>) -> Result<(u64, u64)> {
    let path = path.as_ref();
    let storage = NewFile::create(path)?;
    let old = DatFile::open(path)?;
    let before = u64::from(old.header().file_size);
    let mut header = old.header().clone();
    header.transaction = TRANSACTION_CLEAN;
    (header.young_lru, header.old_lru) = (0, 0);
    let mut new = DatBuilder::new(path.display().to_string(), storage, header)?;
    new.without_iteration_record();
    new.push_all(&old)?;
    // Our own handle must not be in the way of the rename.
    drop(old);
    new.finish()?;
    Ok((before, u64::from(DatFile::open(path)?.header().file_size)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(n: u32, size: usize) -> Vec<u8> {
        let mut dat = DatBuilder::new("test", Vec::new(), Header::new(DatKind::Portal)).unwrap();
        for i in 0..n {
            dat.push(0x0100_0000 + i, &vec![i as u8; size], &WriteOptions::default())
                .unwrap();
        }
        dat.finish().unwrap()
    }

    #[test]
    fn w7_level_sizes() {
        assert_eq!(level_sizes(0), [0]);
        assert_eq!(level_sizes(61), [61]);
        assert_eq!(level_sizes(62), [31, 30]);
        assert_eq!(level_sizes(123), [61, 61]);
        assert_eq!(level_sizes(124), [61, 31, 30]);
        for n in 62..20_000 {
            let sizes = level_sizes(n);
            assert_eq!(sizes.iter().sum::<usize>() + sizes.len() - 1, n);
            assert!(sizes.iter().all(|s| (30..=61).contains(s)), "{n}");
        }
    }

    #[test]
    fn w7_layout_records_then_leaves_then_root() {
        let bytes = build(200, 1500);
        let dat = DatFile::from_bytes("test", bytes.clone()).unwrap();
        let entries: Vec<_> = dat.iter().map(|e| e.unwrap()).collect();
        assert_eq!(entries.len(), 201);
        // Each record has two blocks of 1024, the iteration record one; no gaps from 1024 on.
        for (i, e) in entries[..200].iter().enumerate() {
            assert_eq!(
                (e.offset as usize, e.size, e.version, e.date),
                (1024 + 2048 * i, 1500, 2, 0)
            );
        }
        assert_eq!(
            (entries[200].offset as usize, entries[200].version),
            (1024 + 2048 * 200, 1)
        );
        // 201 entries make 4 leaves and a root of two blocks each.
        let leaves = 1024 + 2048 * 200 + 1024;
        assert_eq!(dat.header().btree_root as usize, leaves + 4 * 2048);
        assert_eq!(dat.header().file_size as usize, leaves + 5 * 2048);
        assert_eq!(dat.header().file_size as usize, bytes.len());
        assert_eq!(
            (
                dat.header().first_free,
                dat.header().final_free,
                dat.header().free_count
            ),
            (0, 0, 0)
        );
        assert!(dat.header().closed_cleanly());
    }

    #[test]
    fn w7_two_builds_are_identical() {
        assert_eq!(build(1000, 70), build(1000, 70));
    }

    #[test]
    fn section_5_1_an_empty_file_has_its_iteration_record() {
        let dat = DatFile::from_bytes("test", build(0, 0)).unwrap();
        assert_eq!(dat.iteration().unwrap(), Some(IterationRecord::complete(1)));
        assert_eq!(dat.iter().count(), 1);
        assert_eq!(dat.find(ITERATION_ID).unwrap().unwrap().version, 1);
    }

    #[test]
    fn v4_the_iteration_record_has_the_highest_iteration_and_stands_at_its_id() {
        let mut dat = DatBuilder::new("test", Vec::new(), Header::new(DatKind::Cell)).unwrap();
        let options = WriteOptions {
            iteration: Some(982),
            ..WriteOptions::default()
        };
        dat.push(0x0001_FFFF, b"a", &WriteOptions::default()).unwrap();
        dat.push(0xFFFF_FFFF, b"b", &options).unwrap();
        let dat = DatFile::from_bytes("test", dat.finish().unwrap()).unwrap();
        let ids: Vec<_> = dat.iter().map(|e| e.unwrap().id).collect();
        assert_eq!(ids, [0x0001_FFFF, ITERATION_ID, 0xFFFF_FFFF]);
        assert_eq!(dat.iteration().unwrap(), Some(IterationRecord::complete(982)));
    }

    #[test]
    fn b2_ids_must_ascend() {
        let mut dat = DatBuilder::new("test", Vec::new(), Header::new(DatKind::Cell)).unwrap();
        let plain = WriteOptions::default();
        dat.push(5, b"a", &plain).unwrap();
        for id in [5, 4] {
            let e = dat.push(id, b"b", &plain).unwrap_err();
            assert!(matches!(e.kind(), ErrorKind::NotAscending { previous: 5 }));
        }
        dat.push(6, b"b", &plain).unwrap();
    }

    #[test]
    fn c12_an_empty_record_owns_a_block() {
        let dat = DatFile::from_bytes("test", build(3, 0)).unwrap();
        let offsets: Vec<_> = dat.iter().map(|e| e.unwrap().offset).collect();
        assert_eq!(offsets, [1024, 2048, 3072, 4096]);
        assert_eq!(dat.get(0x0100_0000).unwrap().as_deref(), Some(&[][..]));
    }

    #[test]
    fn b9_compressed_on_request_and_when_shorter() {
        let mut dat = DatBuilder::new("test", Vec::new(), Header::new(DatKind::Portal)).unwrap();
        let options = WriteOptions {
            compress: true,
            ..WriteOptions::default()
        };
        dat.push(1, &[7; 5000], &options).unwrap();
        dat.push(2, b"short", &options).unwrap();
        let dat = DatFile::from_bytes("test", dat.finish().unwrap()).unwrap();
        let (long, short) = (dat.find(1).unwrap().unwrap(), dat.find(2).unwrap().unwrap());
        assert!(long.is_compressed() && long.size < 100);
        assert!(!short.is_compressed() && short.size == 5);
        assert_eq!(dat.get(1).unwrap().unwrap(), vec![7; 5000]);
        assert_eq!(dat.read_stored(&long).unwrap().len(), long.size as usize);
        let mut buffer = Vec::new();
        dat.read_into(1, &mut buffer).unwrap();
        assert_eq!(buffer, [7; 5000]);
        assert_eq!(dat.get(2).unwrap().unwrap(), &b"short"[..]);
    }

    #[test]
    fn c10_a_file_never_passes_2_gib() {
        /// Takes everything and keeps nothing.
        struct Sink;
        impl Storage for Sink {
            fn size(&self) -> std::io::Result<u64> {
                Ok(0)
            }
            fn read_at(&self, _: u64, _: &mut [u8]) -> std::io::Result<()> {
                Ok(())
            }
            fn write_at(&mut self, _: u64, _: &[u8]) -> std::io::Result<()> {
                Ok(())
            }
            fn set_size(&mut self, _: u64) -> std::io::Result<()> {
                Ok(())
            }
            fn sync(&mut self) -> std::io::Result<()> {
                Ok(())
            }
        }
        let mut header = Header::new(DatKind::Portal);
        header.block_size = 1 << 20;
        let mut dat = DatBuilder::new("test", Sink, header).unwrap();
        let mut last = Ok(());
        for id in 0..2048 {
            last = dat.push(id, &[], &WriteOptions::default());
        }
        assert!(
            matches!(last.unwrap_err().kind(), ErrorKind::FileFull),
            "2047 MiB and 1 KiB are the most"
        );
        assert_eq!(dat.len(), 2047);
    }
}
