//! Editing a file in place, so that it is wholly old or wholly new at any moment (`dat-format.md` 5.4 W2 to W6).

use super::builder::{DatBuilder, WriteOptions, default_version};
use super::chain::{Geometry, ReadAt, walk_chain};
use super::chain_writer::ChainWriter;
use super::compress::{deflate, inflate};
use super::header::{
    DATA_START, HEADER_SIZE, Header, MAX_OFFSET, MAX_WRITE_BLOCK, TRANSACTION_CLEAN, TRANSACTION_OFFSET,
};
use super::iteration::{ITERATION_ID, IterationRecord};
use super::node::{Entry, NODE_SIZE, node_bytes};
use super::storage::{FileStorage, Storage};
use super::tree::{Origin, Tree};
use super::window::Window;
use crate::error::{Error, ErrorKind, Fault, Limits, Result};
use std::collections::BTreeMap;
use std::path::Path;

mod freeing;

pub use freeing::CloseReport;

/// How a [`DatEditor`] works.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct EditOptions {
    /// Writes into free blocks before the file is extended (W4). Only for files that nobody reads meanwhile: a reader that
    /// opened before could take new bytes for old ones.
    pub reuse_free: bool,
    /// Edits also files that are incompletely patched (V2) and lets older iterations replace newer ones (V4).
    pub force: bool,
}

/// Edits a DAT file in place, one batch after the other.
///
/// Changes are gathered in memory until [`DatEditor::commit`] writes them beside what is there and then switches over with
/// one write of 80 bytes (W2). A writer that is killed at any moment leaves the file wholly as before the batch or wholly as
/// after it. Replaced blocks go to the free list when the editor is closed; dropped without that, they are merely lost until
/// the file is compacted.
///
/// One editor at a time holds the file's lock (W5). Readers may have it open meanwhile.
///
/// # Example
/// ```no_run
/// use vestibule_dat::{DatEditor, WriteOptions};
///
/// let mut dat = DatEditor::open("client_cell_1.dat")?;
/// dat.put(0xA9B4_0170, b"the bytes of an EnvCell", &WriteOptions::default())?;
/// dat.delete(0xA9B4_0171)?;
/// dat.commit()?;
/// dat.close()?;
/// # Ok::<(), vestibule_dat::Error>(())
/// ```
pub struct DatEditor<S: Storage = FileStorage> {
    name: String,
    storage: S,
    header: Header,
    options: EditOptions,
    tree: Tree,
    /// Records of this batch: their bytes as they will be stored.
    pending: BTreeMap<u32, Vec<u8>>,
    /// Chains of this batch's replaced and deleted records: first block and size.
    replaced_records: Vec<(u32, u32)>,
    /// Blocks that committed batches have replaced (W2 step 5).
    to_free: Vec<u32>,
    /// The free list, once it is checked (R4); first to be used first.
    free: Option<Vec<u32>>,
    changed: bool,
    /// Total of the iteration record, if the file has a complete one.
    iteration: Option<i32>,
    /// Highest iteration written.
    highest: i32,
    ended: bool,
}

impl DatEditor<FileStorage> {
    /// Opens a file for editing, locks it, and cuts off what a stopped writer has left behind its end (W3).
    ///
    /// # Errors
    /// The file cannot be opened, is no DAT file (C1), is incompletely patched (V2), or another writer holds it
    /// ([`ErrorKind::InUse`]).
    pub fn open(path: impl AsRef<Path>) -> Result<DatEditor> {
        DatEditor::open_with(path, EditOptions::default())
    }

    /// [`DatEditor::open`] with options.
    ///
    /// # Errors
    /// As [`DatEditor::open`].
    pub fn open_with(path: impl AsRef<Path>, options: EditOptions) -> Result<DatEditor> {
        let path = path.as_ref();
        DatEditor::edit(path.display().to_string(), FileStorage::open(path)?, options)
    }

    /// Makes a file with an iteration record and nothing else (5.1), in place of one that may be there, and opens it.
    ///
    /// # Errors
    /// The file cannot be written, or another writer holds the one that is there.
    pub fn create(path: impl AsRef<Path>, header: Header) -> Result<DatEditor> {
        let path = path.as_ref();
        DatBuilder::create(path, header)?.finish()?;
        DatEditor::open(path)
    }
}

impl<S: Storage> DatEditor<S> {
    /// Edits what is in `storage`. `name` stands for it in errors.
    ///
    /// # Errors
    /// As [`DatEditor::open`].
    pub fn edit(name: impl Into<String>, mut storage: S, options: EditOptions) -> Result<DatEditor<S>> {
        let name = name.into();
        let header = open_header(&mut storage).map_err(|fault| fault.named(&name, None))?;
        let mut editor = DatEditor {
            tree: Tree::new(header.btree_root as u32),
            name,
            storage,
            header,
            options,
            pending: BTreeMap::new(),
            replaced_records: Vec::new(),
            to_free: Vec::new(),
            free: None,
            changed: false,
            iteration: None,
            highest: 0,
            ended: false,
        };
        let record = match editor.get(ITERATION_ID) {
            Ok(bytes) => bytes.as_deref().and_then(IterationRecord::parse),
            // V3: the file stays usable without it.
            Err(_) => None,
        };
        if let Some(record) = record {
            if record.is_complete() {
                editor.iteration = Some(record.total);
            } else if !options.force {
                return Err(editor
                    .error("iteration", ErrorKind::Incomplete)
                    .with_id(ITERATION_ID));
            }
        }
        Ok(editor)
    }

    /// The path it was opened by, or the name it was given.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The header as of the last commit.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The directory entry of `id`, with the changes of this batch. The offset of a record that is not committed yet is 0.
    ///
    /// # Errors
    /// A node on the way is damaged (B8).
    pub fn find(&mut self, id: u32) -> Result<Option<Entry>> {
        let from = Origin {
            bytes: &Window::small(&self.storage),
            geometry: Geometry::of(&self.header),
        };
        self.tree
            .find(&from, id)
            .map_err(|fault| fault.named(&self.name, Some(id)))
    }

    /// The bytes of record `id`, with the changes of this batch. `Ok(None)` means that the file does not have it.
    ///
    /// # Errors
    /// As [`crate::DatFile::get`].
    pub fn get(&mut self, id: u32) -> Result<Option<Vec<u8>>> {
        let Some(entry) = self.find(id)? else {
            return Ok(None);
        };
        self.read(&entry)
            .map(Some)
            .map_err(|fault| fault.named(&self.name, Some(id)))
    }

    fn read(&self, entry: &Entry) -> Result<Vec<u8>, Fault> {
        let stored = match self.pending.get(&entry.id) {
            Some(stored) => stored.clone(),
            None => {
                let g = Geometry::of(&self.header);
                g.check_size(entry.offset, entry.size)?;
                let mut stored = vec![0; entry.size as usize];
                super::chain::read_chain(&Window::small(&self.storage), g, entry.offset, &mut stored)?;
                stored
            }
        };
        if !entry.is_compressed() {
            return Ok(stored);
        }
        let mut plain = Vec::new();
        inflate(&stored, Limits::default(), &mut plain)?;
        Ok(plain)
    }

    /// Inserts record `id` or replaces it. What is not given in `options`: of a record that is there, version, date and iteration
    /// stay (W6); of a new one, the version is 2 (1 for the iteration record), the date 0, the iteration 1.
    ///
    /// # Errors
    /// The record that is there has a higher iteration (V4), a node on the way is damaged (B8), or the record is too large.
    pub fn put(&mut self, id: u32, bytes: &[u8], options: &WriteOptions) -> Result<()> {
        let old = self.find(id)?;
        self.put_over(old, id, bytes, options)
    }

    /// Inserts record `id`.
    ///
    /// # Errors
    /// As [`DatEditor::put`], and if the record is there already ([`ErrorKind::Exists`]).
    pub fn insert(&mut self, id: u32, bytes: &[u8], options: &WriteOptions) -> Result<()> {
        match self.find(id)? {
            Some(_) => Err(self.error("id", ErrorKind::Exists).with_id(id)),
            None => self.put_over(None, id, bytes, options),
        }
    }

    /// Replaces record `id`.
    ///
    /// # Errors
    /// As [`DatEditor::put`], and if there is no such record ([`ErrorKind::Absent`]).
    pub fn replace(&mut self, id: u32, bytes: &[u8], options: &WriteOptions) -> Result<()> {
        match self.find(id)? {
            None => Err(self.error("id", ErrorKind::Absent).with_id(id)),
            old => self.put_over(old, id, bytes, options),
        }
    }

    fn put_over(&mut self, old: Option<Entry>, id: u32, bytes: &[u8], options: &WriteOptions) -> Result<()> {
        self.check_usable()?;
        let present = old.map(|e| e.iteration);
        let iteration = options.iteration.or(present).unwrap_or(1);
        if let Some(present) = present
            && present > iteration
            && !self.options.force
        {
            let kind = ErrorKind::OlderIteration {
                present,
                given: iteration,
            };
            return Err(self.error("iteration", kind).with_id(id));
        }
        let compressed = if options.compress { deflate(bytes) } else { None };
        let flags = u16::from(compressed.is_some());
        let stored = compressed.unwrap_or_else(|| bytes.to_vec());
        if stored.len() as u64 > MAX_OFFSET {
            return Err(self.error("size", ErrorKind::FileFull).with_id(id));
        }
        let entry = Entry {
            id,
            flags,
            version: options
                .version
                .or(old.map(|e| e.version))
                .unwrap_or(default_version(id)),
            offset: 0,
            size: stored.len() as u32,
            date: options.date.or(old.map(|e| e.date)).unwrap_or(0),
            iteration,
        };
        let from = Origin {
            bytes: &Window::small(&self.storage),
            geometry: Geometry::of(&self.header),
        };
        let done = match old {
            Some(_) => self.tree.replace(&from, entry),
            None => self.tree.insert(&from, entry),
        };
        done.map_err(|fault| fault.named(&self.name, Some(id)))?;
        self.forget(id, old);
        self.pending.insert(id, stored);
        if id == ITERATION_ID {
            self.iteration = IterationRecord::parse(bytes)
                .filter(IterationRecord::is_complete)
                .map(|r| r.total);
        } else {
            self.highest = self.highest.max(iteration);
        }
        self.changed = true;
        Ok(())
    }

    /// Deletes record `id`; says whether it was there.
    ///
    /// # Errors
    /// A node on the way, or beside it, is damaged (B8): nothing is deleted then.
    pub fn delete(&mut self, id: u32) -> Result<bool> {
        self.check_usable()?;
        let from = Origin {
            bytes: &Window::small(&self.storage),
            geometry: Geometry::of(&self.header),
        };
        let removed = self
            .tree
            .remove(&from, id)
            .map_err(|fault| fault.named(&self.name, Some(id)))?;
        if removed.is_none() {
            return Ok(false);
        }
        self.forget(id, removed);
        if id == ITERATION_ID {
            self.iteration = None;
        }
        self.changed = true;
        Ok(true)
    }

    /// The bytes of a record's older form are out of use: those of this batch at once, those in the file after the commit.
    fn forget(&mut self, id: u32, old: Option<Entry>) {
        if self.pending.remove(&id).is_none()
            && let Some(old) = old
        {
            self.replaced_records.push((old.offset, old.size));
        }
    }

    /// Number of records that this batch will write.
    pub fn pending(&self) -> usize {
        self.pending.len()
    }

    /// Makes the batch permanent (W2 steps 1 to 4): writes records and nodes, flushes, switches over, flushes.
    ///
    /// # Errors
    /// The file would pass 2 GiB, or it cannot be written. The file is then as it was before the batch (or, if the very last flush
    /// failed, maybe as after it), and this editor can only be dropped.
    pub fn commit(&mut self) -> Result<()> {
        self.check_usable()?;
        if let Some(total) = self.iteration
            && self.highest > total
        {
            // V4
            let bytes = IterationRecord::complete(self.highest).bytes();
            self.put(ITERATION_ID, &bytes, &WriteOptions::default())?;
        }
        if !self.changed {
            return Ok(());
        }
        self.write_batch().map_err(|fault| {
            self.ended = true;
            fault.named(&self.name, None)
        })
    }

    fn write_batch(&mut self) -> Result<(), Fault> {
        let io = |field| move |e: std::io::Error| Fault::new(field, e.into());
        if !self.header.closed_cleanly() {
            // Retail would finish its own interrupted change after ours. What we read is the tree as it is.
            self.header.transaction = TRANSACTION_CLEAN;
            self.storage
                .write_at(TRANSACTION_OFFSET as u64, &TRANSACTION_CLEAN)
                .map_err(io("transaction"))?;
            self.storage.sync().map_err(io("transaction"))?;
        }
        let mut replaced = Vec::new();
        let g = Geometry::of(&self.header);
        for (start, size) in self.replaced_records.drain(..) {
            collect_blocks(&Window::small(&self.storage), g, start, size, &mut replaced);
        }

        let reusable = self.take_free_blocks()?;
        let (size, block_size) = (u64::from(self.header.file_size), self.header.block_size as u32);
        let mut out = ChainWriter::new(&mut self.storage, block_size, size).into_free_blocks(reusable);
        out.fill_to(next_block(&self.header));
        for (id, stored) in &self.pending {
            let offset = out.chain(stored)?;
            self.tree.set_offset(*id, offset);
        }
        let root = self
            .tree
            .write(|entries, children| out.chain(&node_bytes(entries, children)))?;
        let end = out.end();
        let (_, mut left_over) = out.finish().map_err(io("file"))?;
        self.storage.sync().map_err(io("file"))?;

        if let Some(mut rest) = self.free.take() {
            // What was taken and not needed is as it was: its links lead to the rest.
            left_over.append(&mut rest);
            self.set_free_list(&left_over);
            self.free = Some(left_over);
        }
        self.header.btree_root = root as i32;
        self.header.file_size = end as u32;
        self.write_info().map_err(io("header"))?;

        self.changed = false;
        self.pending.clear();
        for offset in std::mem::take(&mut self.tree.replaced) {
            collect_blocks(
                &Window::small(&self.storage),
                Geometry::of(&self.header),
                offset,
                NODE_SIZE as u32,
                &mut replaced,
            );
        }
        self.to_free.append(&mut replaced);
        Ok(())
    }

    fn check_usable(&self) -> Result<()> {
        match self.ended {
            true => Err(self.error("editor", ErrorKind::Ended)),
            false => Ok(()),
        }
    }

    fn error(&self, field: &'static str, kind: ErrorKind) -> Error {
        Error::new(self.name.clone(), field, kind)
    }
}

/// Reads the header and cuts off the uncommitted tail (W3).
fn open_header<S: Storage>(storage: &mut S) -> Result<Header, Fault> {
    let io = |e: std::io::Error| Fault::new("header", e.into());
    let len = storage.size().map_err(io)?;
    if len < HEADER_SIZE as u64 {
        return Err(Fault::new(
            "header",
            ErrorKind::TooShort {
                need: HEADER_SIZE as u64,
                have: len,
            },
        ));
    }
    let mut bytes = [0; HEADER_SIZE];
    storage.read_at(0, &mut bytes).map_err(io)?;
    let header = Header::parse(&bytes, len)?;
    if header.block_size > MAX_WRITE_BLOCK {
        return Err(Fault::at(
            0x144,
            "block_size",
            ErrorKind::BadBlockSize(header.block_size),
        ));
    }
    if len > u64::from(header.file_size) {
        storage.set_size(u64::from(header.file_size)).map_err(io)?;
    }
    Ok(header)
}

/// Notes the blocks of a chain that is out of use. Of a damaged chain nothing is freed: what it names may be anyone's.
fn collect_blocks<R: ReadAt>(bytes: &R, g: Geometry, start: u32, size: u32, blocks: &mut Vec<u32>) {
    let before = blocks.len();
    // An empty record owns a block too (C12).
    let walked = walk_chain(bytes, g, start, size.max(1), |at, _| {
        blocks.push(at);
        Ok(())
    });
    if walked.is_err() {
        blocks.truncate(before);
    }
}

/// Where new blocks go: behind everything, on the grid on which the blocks of the file stand (C11).
fn next_block(header: &Header) -> u64 {
    let block_size = u64::from(header.block_size as u32);
    let origin = match header.btree_root as u32 {
        0 => u64::from(DATA_START),
        root => u64::from(root),
    };
    let end = u64::from(header.file_size.max(DATA_START));
    let past = (end % block_size + block_size - origin % block_size) % block_size;
    if past == 0 { end } else { end + block_size - past }
}
