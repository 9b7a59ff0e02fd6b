//! One DAT file, open for reading.

use super::chain::{Geometry, read_chain};
use super::compress::inflate;
use super::entries::Entries;
use super::header::{DatKind, HEADER_SIZE, Header};
use super::index::Index;
use super::iteration::{ITERATION_ID, IterationRecord};
use super::node::{ALL_IDS, Entry};
use crate::error::{ErrorKind, Fault, Limits, Result};
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::{Bound, RangeBounds};
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// One DAT file, open for reading; shared between threads by reference.
///
/// Opening reads the 400 bytes of the header and nothing else. Every node of the directory is checked when a look-up comes by
/// it, so a damaged file answers for all ids that its damage does not touch.
///
/// A file opened from disk may be edited meanwhile by one [`crate::DatEditor`]. Reads then show either state; when a read meets
/// a block that the edit has freed, the file is looked at again and the read repeated (`dat-format.md` W5).
///
/// # Example
/// ```no_run
/// let cell = vestibule_dat::DatFile::open("client_cell_1.dat")?;
/// if let Some(bytes) = cell.get(0xA9B4_FFFF)? {
///     println!("{} bytes", bytes.len());
/// }
/// # Ok::<(), vestibule_dat::Error>(())
/// ```
pub struct DatFile {
    name: Arc<str>,
    limits: Limits,
    disk: Option<Disk>,
    first: View,
}

/// The open file behind a [`DatFile`], kept to look at the header again (W5).
struct Disk {
    file: Mutex<File>,
    mapped: bool,
}

/// The bytes that one committed header stands for. A newer state is appended behind it, so that borrows of the older live on.
pub(crate) struct View {
    bytes: Bytes,
    pub(crate) header: Header,
    index: Index,
    next: OnceLock<Box<View>>,
}

enum Bytes {
    Memory(Arc<[u8]>),
    #[cfg(feature = "mmap")]
    Map(super::map::Map),
}

impl Bytes {
    fn as_slice(&self) -> &[u8] {
        match self {
            Bytes::Memory(b) => b,
            #[cfg(feature = "mmap")]
            Bytes::Map(map) => map.bytes(),
        }
    }
}

impl View {
    fn new(bytes: Bytes, header: Header) -> View {
        View {
            bytes,
            header,
            index: Index::default(),
            next: OnceLock::new(),
        }
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        let all = self.bytes.as_slice();
        all.get(..self.header.file_size as usize).unwrap_or(all)
    }

    pub(crate) fn geometry(&self) -> Geometry {
        Geometry::of(&self.header)
    }

    /// The entry of `id` (B5, B8).
    fn find(&self, id: u32) -> Result<Option<Entry>, Fault> {
        match self.header.btree_root as u32 {
            0 => Ok(None),
            root => self.index.find(self.bytes(), self.geometry(), root, id),
        }
    }

    /// The bytes of a record as stored, borrowed when one block holds them all.
    pub(crate) fn stored(&self, entry: &Entry) -> Result<Cow<'_, [u8]>, Fault> {
        let (bytes, g) = (self.bytes(), self.geometry());
        if entry.size == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        if entry.size <= g.payload() {
            // The walk checks the one block; its payload is what is wanted.
            read_chain_in_place(bytes, g, entry).map(Cow::Borrowed)
        } else {
            let mut out = Vec::new();
            gather(bytes, g, entry, &mut out)?;
            Ok(Cow::Owned(out))
        }
    }
}

fn read_chain_in_place<'a>(bytes: &'a [u8], g: Geometry, entry: &Entry) -> Result<&'a [u8], Fault> {
    let mut found = None;
    super::chain::walk_chain(&bytes, g, entry.offset, entry.size, |at, take| {
        let from = at as usize + 4;
        found = bytes.get(from..from + take as usize);
        Ok(())
    })?;
    let cut = ErrorKind::ChainTooShort {
        missing: u64::from(entry.size),
    };
    found.ok_or_else(|| Fault::at(u64::from(entry.offset), "offset", cut))
}

/// Replaces what is in `out` by the stored bytes of a record.
fn gather(bytes: &[u8], g: Geometry, entry: &Entry, out: &mut Vec<u8>) -> Result<(), Fault> {
    g.check_size(entry.offset, entry.size)?;
    out.clear();
    out.resize(entry.size as usize, 0);
    let done = read_chain(&bytes, g, entry.offset, out);
    if done.is_err() {
        out.clear();
    }
    done
}

impl Drop for View {
    fn drop(&mut self) {
        // One after the other: a long chain of views must not be dropped by recursion.
        let mut next = self.next.take();
        while let Some(mut view) = next {
            next = view.next.take();
        }
    }
}

impl DatFile {
    /// Opens a file, by memory map where the feature `mmap` is on, without scanning it.
    ///
    /// While it is open, other programs must not shorten or overwrite the file; editing it by this crate is safe. Where that
    /// cannot be promised use [`DatFile::open_in_memory`].
    ///
    /// # Errors
    /// The file cannot be read, is shorter than its header says, or is no DAT file (C1).
    pub fn open(path: impl AsRef<Path>) -> Result<DatFile> {
        DatFile::open_with(path.as_ref(), Limits::default(), cfg!(feature = "mmap"))
    }

    /// Opens a file by reading all of it into memory.
    ///
    /// # Errors
    /// As [`DatFile::open`].
    pub fn open_in_memory(path: impl AsRef<Path>) -> Result<DatFile> {
        DatFile::open_with(path.as_ref(), Limits::default(), false)
    }

    fn open_with(path: &Path, limits: Limits, mapped: bool) -> Result<DatFile> {
        let name: Arc<str> = path.display().to_string().into();
        let named = |fault: Fault| fault.named(&name, None);
        let mut file = File::open(path).map_err(|e| named(Fault::new("open", e.into())))?;
        let header = read_header(&mut file).map_err(named)?;
        let first = load(&mut file, header, mapped).map_err(named)?;
        let disk = Some(Disk {
            file: Mutex::new(file),
            mapped,
        });
        Ok(DatFile {
            name,
            limits,
            disk,
            first,
        })
    }

    /// Takes a file that is in memory. `name` stands for it in errors.
    ///
    /// # Errors
    /// The bytes are no DAT file, or fewer than the header says (C1).
    pub fn from_bytes(name: impl Into<Arc<str>>, bytes: impl Into<Arc<[u8]>>) -> Result<DatFile> {
        let (name, bytes) = (name.into(), bytes.into());
        let header = first_bytes(&bytes)
            .and_then(|b| Header::parse(b, bytes.len() as u64))
            .map_err(|fault| fault.named(&name, None))?;
        let first = View::new(Bytes::Memory(bytes), header);
        Ok(DatFile {
            name,
            limits: Limits::default(),
            disk: None,
            first,
        })
    }

    /// The same file with other budgets.
    #[must_use]
    pub fn with_limits(mut self, limits: Limits) -> DatFile {
        self.limits = limits;
        self
    }

    /// The budgets in force.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// The path it was opened by, or the name it was given.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The header, as of the newest state this reader has seen.
    pub fn header(&self) -> &Header {
        &self.view().header
    }

    /// Which of the four files it is (F1).
    pub fn kind(&self) -> Option<DatKind> {
        self.header().kind()
    }

    /// Looks up the directory entry of `id`. `Ok(None)` means that the file does not have it.
    ///
    /// # Errors
    /// A node on the way is damaged (B8): the ids it stood for cannot be had.
    pub fn find(&self, id: u32) -> Result<Option<Entry>> {
        self.retry(Some(id), |view| view.find(id))
    }

    /// Whether the file has `id`.
    ///
    /// # Errors
    /// As [`DatFile::find`].
    pub fn contains(&self, id: u32) -> Result<bool> {
        Ok(self.find(id)?.is_some())
    }

    /// The bytes of record `id`, inflated if they are compressed. `Ok(None)` means that the file does not have it.
    ///
    /// Borrows from the file when the record lies in one block, else gathers the chain into a new buffer. To reuse a buffer
    /// call [`DatFile::read_into`].
    ///
    /// # Errors
    /// A node on the way or the record's chain is damaged (B8, C7 to C9), or the record does not inflate (B10).
    pub fn get(&self, id: u32) -> Result<Option<Cow<'_, [u8]>>> {
        self.retry(Some(id), |view| {
            let Some(entry) = view.find(id)? else {
                return Ok(None);
            };
            self.plain(view, &entry).map(Some)
        })
    }

    /// The bytes of the record that `entry` (of this file) stands for, inflated if they are compressed.
    ///
    /// # Errors
    /// As [`DatFile::get`]; also if the file was edited meanwhile and the record is gone.
    pub fn read(&self, entry: &Entry) -> Result<Cow<'_, [u8]>> {
        self.read_by(entry, |view, entry| self.plain(view, entry))
    }

    /// The bytes of the record that `entry` stands for as they are stored, compressed or not.
    ///
    /// # Errors
    /// As [`DatFile::read`], except that nothing is inflated.
    pub fn read_stored(&self, entry: &Entry) -> Result<Cow<'_, [u8]>> {
        self.read_by(entry, |view, entry| view.stored(entry))
    }

    /// Puts the bytes of record `id` into `out` and says what the directory knows about it. `Ok(None)`, and `out` empty, means
    /// that the file does not have it.
    ///
    /// # Errors
    /// As [`DatFile::get`]; `out` is then empty.
    pub fn read_into(&self, id: u32, out: &mut Vec<u8>) -> Result<Option<Entry>> {
        out.clear();
        self.retry(Some(id), |view| {
            let Some(entry) = view.find(id)? else {
                return Ok(None);
            };
            let done = if entry.is_compressed() {
                inflate(&view.stored(&entry)?, self.limits, out)
            } else {
                gather(view.bytes(), view.geometry(), &entry, out)
            };
            match done {
                Ok(()) => Ok(Some(entry)),
                Err(fault) => {
                    out.clear();
                    Err(fault)
                }
            }
        })
    }

    /// All entries, by ascending id (B6).
    pub fn iter(&self) -> Entries<'_> {
        self.range(..)
    }

    /// The entries whose ids are in `ids`, ascending; branches that cannot hold one are not read (B6).
    pub fn range(&self, ids: impl RangeBounds<u32>) -> Entries<'_> {
        let low = match ids.start_bound() {
            Bound::Included(&low) => u64::from(low),
            Bound::Excluded(&low) => u64::from(low) + 1,
            Bound::Unbounded => 0,
        };
        let high = match ids.end_bound() {
            Bound::Included(&high) => u64::from(high) + 1,
            Bound::Excluded(&high) => u64::from(high),
            Bound::Unbounded => ALL_IDS.end,
        };
        Entries::new(self, low, high)
    }

    /// The iteration record (V1). `Ok(None)` if the file has none: then its iteration is unknown (V3).
    ///
    /// # Errors
    /// As [`DatFile::get`], and if the record has another shape (V3). The file stays readable.
    pub fn iteration(&self) -> Result<Option<IterationRecord>> {
        let Some(bytes) = self.get(ITERATION_ID)? else {
            return Ok(None);
        };
        IterationRecord::parse_fault(&bytes)
            .map(Some)
            .map_err(|fault| fault.named(&self.name, Some(ITERATION_ID)))
    }

    fn plain<'a>(&self, view: &'a View, entry: &Entry) -> Result<Cow<'a, [u8]>, Fault> {
        let stored = view.stored(entry)?;
        if !entry.is_compressed() {
            return Ok(stored);
        }
        let mut out = Vec::new();
        inflate(&stored, self.limits, &mut out)?;
        Ok(Cow::Owned(out))
    }

    /// Reads by an entry that the caller has. If that fails and the file has been edited since, by the entry the id has now.
    fn read_by<'a, T>(
        &'a self,
        entry: &Entry,
        read: impl Fn(&'a View, &Entry) -> Result<T, Fault>,
    ) -> Result<T> {
        self.retry(Some(entry.id), |view| {
            read(view, entry).or_else(|fault| match view.find(entry.id)? {
                Some(now) if now != *entry => read(view, &now),
                Some(_) => Err(fault),
                None => Err(Fault::new("id", ErrorKind::Absent)),
            })
        })
    }

    /// The newest state seen so far.
    pub(crate) fn view(&self) -> &View {
        let mut view = &self.first;
        while let Some(next) = view.next.get() {
            view = next;
        }
        view
    }

    /// W5: a read that fails is repeated if the file has been committed anew.
    fn retry<'a, T>(
        &'a self,
        id: Option<u32>,
        mut read: impl FnMut(&'a View) -> Result<T, Fault>,
    ) -> Result<T> {
        let mut view = self.view();
        loop {
            match read(view) {
                Ok(value) => return Ok(value),
                Err(fault) => match self.newer(view) {
                    Some(newer) => view = newer,
                    None => return Err(fault.named(&self.name, id)),
                },
            }
        }
    }

    /// The state after `view`, if the file on disk has one: another root or another size (W5).
    pub(crate) fn newer<'a>(&'a self, view: &'a View) -> Option<&'a View> {
        let disk = self.disk.as_ref()?;
        let mut file = disk.file.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(next) = view.next.get() {
            return Some(next);
        }
        // A header that cannot be read or mapped now leaves the reader with the state it has.
        let header = settled_header(&mut file)?;
        if header.btree_root == view.header.btree_root && header.file_size == view.header.file_size {
            return None;
        }
        let next = load(&mut file, header, disk.mapped).ok()?;
        Some(view.next.get_or_init(|| Box::new(next)))
    }
}

impl<'a> IntoIterator for &'a DatFile {
    type Item = Result<Entry>;
    type IntoIter = Entries<'a>;

    fn into_iter(self) -> Entries<'a> {
        self.iter()
    }
}

impl std::fmt::Debug for DatFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DatFile")
            .field("name", &self.name)
            .field("kind", &self.kind())
            .finish_non_exhaustive()
    }
}

fn first_bytes(bytes: &[u8]) -> Result<&[u8; HEADER_SIZE], Fault> {
    bytes.first_chunk().ok_or_else(|| {
        Fault::new(
            "header",
            ErrorKind::TooShort {
                need: HEADER_SIZE as u64,
                have: bytes.len() as u64,
            },
        )
    })
}

/// The header once it reads the same twice: a commit may be under way.
fn settled_header(file: &mut File) -> Option<Header> {
    let mut last = read_header(file).ok();
    for _ in 0..16 {
        let now = read_header(file).ok();
        if now.is_some() && now == last {
            return now;
        }
        last = now;
        std::thread::yield_now();
    }
    last
}

fn read_header(file: &mut File) -> Result<Header, Fault> {
    let io = |e: io::Error| Fault::new("header", e.into());
    let len = file.seek(SeekFrom::End(0)).map_err(io)?;
    if len < HEADER_SIZE as u64 {
        return Err(Fault::new(
            "header",
            ErrorKind::TooShort {
                need: HEADER_SIZE as u64,
                have: len,
            },
        ));
    }
    let mut b = [0; HEADER_SIZE];
    file.seek(SeekFrom::Start(0)).map_err(io)?;
    file.read_exact(&mut b).map_err(io)?;
    Header::parse(&b, len)
}

/// The bytes that `header` commits; what lies beyond them is an uncommitted tail (W3).
fn load(file: &mut File, header: Header, mapped: bool) -> Result<View, Fault> {
    let io = |e: io::Error| Fault::new("file", e.into());
    #[cfg(feature = "mmap")]
    if mapped {
        let map = super::map::Map::first_bytes(file, header.file_size as usize).map_err(io)?;
        return Ok(View::new(Bytes::Map(map), header));
    }
    let _ = mapped;
    let mut all = Vec::new();
    all.try_reserve_exact(header.file_size as usize)
        .map_err(|_| io(io::ErrorKind::OutOfMemory.into()))?;
    file.seek(SeekFrom::Start(0)).map_err(io)?;
    file.take(u64::from(header.file_size))
        .read_to_end(&mut all)
        .map_err(io)?;
    if all.len() < header.file_size as usize {
        return Err(io(io::ErrorKind::UnexpectedEof.into()));
    }
    Ok(View::new(Bytes::Memory(all.into()), header))
}
