//! The files of one installation together (`dat-format.md` 1.1, F1 to F3).

use crate::container::{DatFile, DatKind};
use crate::error::{Error, ErrorKind, Result};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The DAT files of one installation: portal and cell, and highres and local where there are any.
///
/// Shared between threads by reference.
///
/// **Two id spaces.** The ids of the cell file (landblocks and what is in them) and those of the other files overlap:
/// `0x01000100` is both a GfxObj and the first cell of landblock (1, 0). Ask [`DatSet::get_cell`] for the one and
/// [`DatSet::get_asset`] for the other; [`DatSet::get`] guesses, for ids typed by a person.
///
/// # Example
/// ```no_run
/// let dats = vestibule_dat::DatSet::open("/path/to/ac")?;
/// let landblock = dats.get_cell(0xA9B4_FFFF)?;
/// let surface = dats.get_asset(0x0800_0034)?;
/// # Ok::<(), vestibule_dat::Error>(())
/// ```
#[derive(Debug)]
pub struct DatSet {
    portal: DatFile,
    cell: DatFile,
    highres: Option<DatFile>,
    local: Option<DatFile>,
}

impl DatSet {
    /// Opens the files of a folder. Names are matched without regard to case; of local files the English one is preferred.
    ///
    /// # Errors
    /// The folder cannot be read, `client_portal.dat` or `client_cell_1.dat` is not in it, or a file that is there is damaged or
    /// is another one of the four than its name says. The error names the file.
    pub fn open(folder: impl AsRef<Path>) -> Result<DatSet> {
        DatSet::open_by(folder.as_ref(), |path| DatFile::open(path))
    }

    /// Opens the files of a folder by reading all of them into memory.
    ///
    /// # Errors
    /// As [`DatSet::open`].
    pub fn open_in_memory(folder: impl AsRef<Path>) -> Result<DatSet> {
        DatSet::open_by(folder.as_ref(), |path| DatFile::open_in_memory(path))
    }

    fn open_by(folder: &Path, open: impl Fn(&Path) -> Result<DatFile>) -> Result<DatSet> {
        let found = find_files(folder)?;
        let open_if_there = |kind| match found.path(kind) {
            Some(path) => open(path).and_then(|file| of_kind(file, kind)).map(Some),
            None => Ok(None),
        };
        let needed = |kind: DatKind| {
            open_if_there(kind)?.ok_or_else(|| {
                Error::new(
                    folder.join(kind.file_name()).display().to_string(),
                    "file",
                    ErrorKind::MissingFile,
                )
            })
        };
        Ok(DatSet {
            portal: needed(DatKind::Portal)?,
            cell: needed(DatKind::Cell)?,
            highres: open_if_there(DatKind::HighRes)?,
            local: open_if_there(DatKind::Local)?,
        })
    }

    /// Puts together files that are open already, from disk or from memory.
    ///
    /// # Errors
    /// A file's header says that it is another one of the four (F1).
    pub fn from_files(
        portal: DatFile,
        cell: DatFile,
        highres: Option<DatFile>,
        local: Option<DatFile>,
    ) -> Result<DatSet> {
        Ok(DatSet {
            portal: of_kind(portal, DatKind::Portal)?,
            cell: of_kind(cell, DatKind::Cell)?,
            highres: highres.map(|file| of_kind(file, DatKind::HighRes)).transpose()?,
            local: local.map(|file| of_kind(file, DatKind::Local)).transpose()?,
        })
    }

    /// Takes a portal and a cell file that are in memory.
    ///
    /// # Errors
    /// Either is no DAT file or the wrong one.
    pub fn from_bytes(
        portal: impl Into<std::sync::Arc<[u8]>>,
        cell: impl Into<std::sync::Arc<[u8]>>,
    ) -> Result<DatSet> {
        let portal = DatFile::from_bytes(DatKind::Portal.file_name(), portal)?;
        let cell = DatFile::from_bytes(DatKind::Cell.file_name(), cell)?;
        DatSet::from_files(portal, cell, None, None)
    }

    /// The portal file.
    pub fn portal(&self) -> &DatFile {
        &self.portal
    }

    /// The cell file.
    pub fn cell(&self) -> &DatFile {
        &self.cell
    }

    /// The highres file, if there is one.
    pub fn highres(&self) -> Option<&DatFile> {
        self.highres.as_ref()
    }

    /// The local file, if there is one.
    pub fn local(&self) -> Option<&DatFile> {
        self.local.as_ref()
    }

    /// One of the four, if it is there.
    pub fn file(&self, kind: DatKind) -> Option<&DatFile> {
        match kind {
            DatKind::Portal => Some(&self.portal),
            DatKind::Cell => Some(&self.cell),
            DatKind::Local => self.local.as_ref(),
            DatKind::HighRes => self.highres.as_ref(),
        }
    }

    /// The files that are there: portal, cell, local, highres.
    pub fn files(&self) -> impl Iterator<Item = (DatKind, &DatFile)> {
        DatKind::ALL
            .into_iter()
            .filter_map(|kind| Some((kind, self.file(kind)?)))
    }

    /// The record of a landblock, its info or an env cell, from the cell file. `Ok(None)` means that it is not there.
    ///
    /// # Errors
    /// As [`DatFile::get`].
    pub fn get_cell(&self, id: u32) -> Result<Option<Cow<'_, [u8]>>> {
        self.cell.get(id)
    }

    /// The record of any other type, from the file that F3 names: `0x21`, `0x23`-`0x24` and `0x41` from local, `0x06` and `0x07`
    /// from portal, then highres, everything else from portal. `Ok(None)` means that it is not there.
    ///
    /// # Errors
    /// As [`DatFile::get`].
    pub fn get_asset(&self, id: u32) -> Result<Option<Cow<'_, [u8]>>> {
        for file in self.asset_files(id) {
            if let Some(bytes) = file.get(id)? {
                return Ok(Some(bytes));
            }
        }
        Ok(None)
    }

    /// The record of an id of which only the number is known: an asset if there is one (see [`DatSet::get_asset`]), else a
    /// record of the cell file. `Ok(None)` means that it is in neither.
    ///
    /// # Errors
    /// As [`DatFile::get`].
    pub fn get(&self, id: u32) -> Result<Option<Cow<'_, [u8]>>> {
        match self.get_asset(id)? {
            Some(bytes) => Ok(Some(bytes)),
            None => self.get_cell(id),
        }
    }

    /// Every file that has `id`, in the order in which they are asked: assets first, then the cell file.
    ///
    /// # Errors
    /// As [`DatFile::find`].
    pub fn files_with(&self, id: u32) -> Result<Vec<DatKind>> {
        let mut found = Vec::new();
        for file in self.asset_files(id).chain([&self.cell]) {
            if file.contains(id)? {
                found.extend(file.kind());
            }
        }
        Ok(found)
    }

    pub(crate) fn asset_files(&self, id: u32) -> impl Iterator<Item = &DatFile> {
        let (first, second) = match id >> 24 {
            0x21 | 0x23 | 0x24 | 0x41 => (self.local.as_ref(), None),
            0x06 | 0x07 => (Some(&self.portal), self.highres.as_ref()),
            _ => (Some(&self.portal), None),
        };
        first.into_iter().chain(second)
    }
}

/// F1: the header must say what the name or the caller says.
fn of_kind(file: DatFile, expected: DatKind) -> Result<DatFile> {
    if file.kind() == Some(expected) {
        return Ok(file);
    }
    let found = match file.kind() {
        Some(kind) => kind.in_words().to_owned(),
        None => format!("a file of data set {}", file.header().data_set),
    };
    let kind = ErrorKind::WrongKind {
        expected: expected.in_words(),
        found,
    };
    Err(Error::new(file.name(), "data_set", kind).with_offset(0x14C))
}

struct Found {
    portal: Option<PathBuf>,
    cell: Option<PathBuf>,
    highres: Option<PathBuf>,
    local: Option<PathBuf>,
}

impl Found {
    fn path(&self, kind: DatKind) -> Option<&Path> {
        match kind {
            DatKind::Portal => self.portal.as_deref(),
            DatKind::Cell => self.cell.as_deref(),
            DatKind::HighRes => self.highres.as_deref(),
            DatKind::Local => self.local.as_deref(),
        }
    }
}

fn find_files(folder: &Path) -> Result<Found> {
    let io = |e: std::io::Error| Error::new(folder.display().to_string(), "folder", e.into());
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let name = entry.map_err(io)?.file_name();
        if let Some(text) = name.to_str() {
            names.push((text.to_ascii_lowercase(), folder.join(&name)));
        }
    }
    // Sorted, so that the same folder always gives the same files.
    names.sort();
    let named = |want: &str| {
        let want = want.to_ascii_lowercase();
        names
            .iter()
            .find(|(name, _)| *name == want)
            .map(|(_, path)| path.clone())
    };
    let any_local = || {
        let is_local = |name: &str| name.starts_with("client_local_") && name.ends_with(".dat");
        names
            .iter()
            .find(|(name, _)| is_local(name))
            .map(|(_, path)| path.clone())
    };
    Ok(Found {
        portal: named(DatKind::Portal.file_name()),
        cell: named(DatKind::Cell.file_name()),
        highres: named(DatKind::HighRes.file_name()),
        local: named(DatKind::Local.file_name()).or_else(any_local),
    })
}
