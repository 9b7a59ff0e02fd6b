//! Where a writer's bytes go: a locked file, a new file that replaces another, or memory.

use super::chain::ReadAt;
use crate::error::{Error, ErrorKind, Result};
use std::ffi::OsString;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Bytes that can be read and written anywhere, and flushed.
///
/// Writers go through this trait alone, so a test can record every step and stop after any of them. What is written between
/// two [`Storage::sync`] may reach the disk in any order, or in part; what was written before one is there after it.
pub trait Storage {
    /// Length in bytes.
    ///
    /// # Errors
    /// What the system reports; so for all of these.
    fn size(&self) -> io::Result<u64>;

    /// Fills `buf` from `offset`; an error if that passes the end.
    ///
    /// # Errors
    /// As [`Storage::size`].
    fn read_at(&self, offset: u64, buf: &mut [u8]) -> io::Result<()>;

    /// Writes `bytes` at `offset`. Writing past the end extends the bytes, with zeros in between.
    ///
    /// # Errors
    /// As [`Storage::size`].
    fn write_at(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()>;

    /// Cuts off or extends with zeros.
    ///
    /// # Errors
    /// As [`Storage::size`].
    fn set_size(&mut self, len: u64) -> io::Result<()>;

    /// Returns when everything written is on the disk.
    ///
    /// # Errors
    /// As [`Storage::size`].
    fn sync(&mut self) -> io::Result<()>;

    /// Ends the writing of a whole file: flushes it and, where it stands in for another, puts it in that one's place.
    ///
    /// # Errors
    /// As [`Storage::size`].
    fn publish(&mut self) -> io::Result<()> {
        self.sync()
    }
}

impl<S: Storage + ?Sized> Storage for &mut S {
    fn size(&self) -> io::Result<u64> {
        (**self).size()
    }

    fn read_at(&self, offset: u64, buf: &mut [u8]) -> io::Result<()> {
        (**self).read_at(offset, buf)
    }

    fn write_at(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        (**self).write_at(offset, bytes)
    }

    fn set_size(&mut self, len: u64) -> io::Result<()> {
        (**self).set_size(len)
    }

    fn sync(&mut self) -> io::Result<()> {
        (**self).sync()
    }

    fn publish(&mut self) -> io::Result<()> {
        (**self).publish()
    }
}

/// Bytes in memory.
impl Storage for Vec<u8> {
    fn size(&self) -> io::Result<u64> {
        Ok(self.len() as u64)
    }

    fn read_at(&self, offset: u64, buf: &mut [u8]) -> io::Result<()> {
        ReadAt::read_at(&self.as_slice(), offset, buf)
    }

    fn write_at(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        let at = usize::try_from(offset).map_err(|_| io::Error::from(io::ErrorKind::FileTooLarge))?;
        let end = at.checked_add(bytes.len()).ok_or(io::ErrorKind::FileTooLarge)?;
        if at == self.len() {
            self.extend_from_slice(bytes);
            return Ok(());
        }
        if end > self.len() {
            self.resize(end, 0);
        }
        if let Some(to) = self.get_mut(at..end) {
            to.copy_from_slice(bytes);
        }
        Ok(())
    }

    fn set_size(&mut self, len: u64) -> io::Result<()> {
        let len = usize::try_from(len).map_err(|_| io::Error::from(io::ErrorKind::FileTooLarge))?;
        self.resize(len, 0);
        Ok(())
    }

    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A file on disk, locked against other writers while it is held (W5).
#[derive(Debug)]
pub struct FileStorage {
    file: File,
}

impl FileStorage {
    /// Opens an existing file for reading and writing and locks it.
    ///
    /// # Errors
    /// The file cannot be opened, or another writer holds it ([`ErrorKind::InUse`]).
    pub fn open(path: impl AsRef<Path>) -> Result<FileStorage> {
        let path = path.as_ref();
        let error = |field, kind| Error::new(path.display().to_string(), field, kind);
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .open(path)
            .map_err(|e| error("open", e.into()))?;
        lock(&file).map_err(|kind| error("lock", kind))?;
        // A whole-file write may have put another file in place between opening and locking.
        if !is_at(&file, path).map_err(|e| error("lock", e.into()))? {
            return Err(error("lock", ErrorKind::InUse));
        }
        Ok(FileStorage { file })
    }
}

impl Storage for FileStorage {
    fn size(&self) -> io::Result<u64> {
        Ok(self.file.metadata()?.len())
    }

    fn read_at(&self, offset: u64, buf: &mut [u8]) -> io::Result<()> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(buf)
    }

    fn write_at(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(offset))?;
        self.file.write_all(bytes)
    }

    fn set_size(&mut self, len: u64) -> io::Result<()> {
        self.file.set_len(len)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.file.sync_data()
    }
}

/// A new file beside a target, which it replaces when it is published (W1). Dropped before that, it vanishes and the target stays.
#[derive(Debug)]
pub struct NewFile {
    /// Gone once the file is published, so that no handle of ours is in the way of anyone.
    file: Option<FileStorage>,
    temporary: PathBuf,
    target: PathBuf,
    /// The lock on the file that will be replaced.
    replaced: Option<FileStorage>,
}

impl NewFile {
    /// Starts a new file for `target`, locks a file that is already there, and removes what killed writers have left.
    ///
    /// # Errors
    /// Another writer holds the target ([`ErrorKind::InUse`]), or its folder cannot be written.
    pub fn create(target: impl AsRef<Path>) -> Result<NewFile> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let target = target.as_ref();
        let error =
            |path: &Path, field, e: io::Error| Error::new(path.display().to_string(), field, e.into());
        let replaced = match target.try_exists() {
            Ok(true) => Some(FileStorage::open(target)?),
            Ok(false) => None,
            Err(e) => return Err(error(target, "open", e)),
        };
        remove_left_over(target);
        let Some(mut name) = temporary_prefix(target) else {
            return Err(error(target, "open", io::ErrorKind::InvalidFilename.into()));
        };
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        name.push(format!("{}-{number}", std::process::id()));
        let temporary = target.with_file_name(name);
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .open(&temporary)
            .map_err(|e| error(&temporary, "create", e))?;
        let locked = lock(&file).map_err(|kind| Error::new(temporary.display().to_string(), "lock", kind));
        let new = NewFile {
            file: Some(FileStorage { file }),
            temporary,
            target: target.to_owned(),
            replaced,
        };
        locked.map(|()| new)
    }

    fn inner(&self) -> io::Result<&FileStorage> {
        self.file.as_ref().ok_or_else(published)
    }

    fn inner_mut(&mut self) -> io::Result<&mut FileStorage> {
        self.file.as_mut().ok_or_else(published)
    }
}

fn published() -> io::Error {
    io::Error::other("the file is published already")
}

impl Storage for NewFile {
    fn size(&self) -> io::Result<u64> {
        self.inner()?.size()
    }

    fn read_at(&self, offset: u64, buf: &mut [u8]) -> io::Result<()> {
        self.inner()?.read_at(offset, buf)
    }

    fn write_at(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        self.inner_mut()?.write_at(offset, bytes)
    }

    fn set_size(&mut self, len: u64) -> io::Result<()> {
        self.inner_mut()?.set_size(len)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.inner_mut()?.sync()
    }

    fn publish(&mut self) -> io::Result<()> {
        self.inner_mut()?.file.sync_all()?;
        if cfg!(windows) {
            // A file that is open cannot be replaced there, not even by who opened it.
            self.replaced = None;
            self.file = None;
        }
        std::fs::rename(&self.temporary, &self.target)?;
        self.file = None;
        self.replaced = None;
        self.temporary.clear();
        sync_folder(&self.target)
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if !self.temporary.as_os_str().is_empty() {
            // Nobody is left to tell; the next write tries again.
            let _ = std::fs::remove_file(&self.temporary);
        }
    }
}

fn lock(file: &File) -> Result<(), ErrorKind> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(ErrorKind::InUse),
        // Some network file systems have no locks; writing there is as safe as its only user makes it.
        Err(TryLockError::Error(e)) if e.kind() == io::ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(e)) => Err(e.into()),
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let (a, b) = (file.metadata()?, path.metadata()?);
    Ok(a.dev() == b.dev() && a.ino() == b.ino())
}

#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> io::Result<bool> {
    // An open file cannot be replaced on these systems.
    Ok(true)
}

#[cfg(unix)]
fn sync_folder(target: &Path) -> io::Result<()> {
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

fn temporary_prefix(target: &Path) -> Option<OsString> {
    let mut name = OsString::from(".");
    name.push(target.file_name()?);
    name.push(".new-");
    Some(name)
}

/// Removes temporary files of writers that were killed: those that nobody has locked (W1).
fn remove_left_over(target: &Path) {
    let Some(prefix) = temporary_prefix(target) else {
        return;
    };
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        if !entry
            .file_name()
            .as_encoded_bytes()
            .starts_with(prefix.as_encoded_bytes())
        {
            continue;
        }
        let path = entry.path();
        let abandoned = OpenOptions::new()
            .write(true)
            .open(&path)
            .is_ok_and(|file| lock(&file).is_ok());
        if abandoned {
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn w5_one_writer_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.dat");
        std::fs::write(&path, b"old").unwrap();
        let first = FileStorage::open(&path).unwrap();
        for e in [
            FileStorage::open(&path).unwrap_err(),
            NewFile::create(&path).unwrap_err(),
        ] {
            assert!(
                matches!(e.kind(), ErrorKind::InUse) && e.file().ends_with("a.dat"),
                "{e}"
            );
        }
        drop(first);
        FileStorage::open(&path).unwrap();
    }

    #[test]
    fn w1_the_old_file_stays_until_the_new_one_is_published() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.dat");
        std::fs::write(&path, b"old").unwrap();
        let files = || std::fs::read_dir(folder.path()).unwrap().count();
        let mut new = NewFile::create(&path).unwrap();
        new.write_at(0, b"newer").unwrap();
        drop(new);
        assert_eq!(
            (std::fs::read(&path).unwrap().as_slice(), files()),
            (&b"old"[..], 1)
        );
        let mut new = NewFile::create(&path).unwrap();
        new.write_at(0, b"newer").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        new.publish().unwrap();
        assert_eq!(
            (std::fs::read(&path).unwrap().as_slice(), files()),
            (&b"newer"[..], 1)
        );
        FileStorage::open(&path).unwrap();
    }

    #[test]
    fn w1_left_over_temporary_files_are_removed_but_live_ones_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.dat");
        let dead = folder.path().join(".a.dat.new-99-0");
        std::fs::write(&dead, b"half").unwrap();
        std::fs::write(folder.path().join("b.dat"), b"other").unwrap();
        let live = NewFile::create(&path).unwrap();
        assert!(!dead.exists());
        let second = NewFile::create(&path).unwrap();
        assert!(live.temporary.exists() && second.temporary.exists());
        assert!(folder.path().join("b.dat").exists());
    }

    #[test]
    fn memory_grows_with_zeros_in_between() {
        let mut v = vec![1, 2];
        v.write_at(4, &[5]).unwrap();
        v.write_at(1, &[9, 9]).unwrap();
        assert_eq!(v, [1, 9, 9, 0, 5]);
        assert!(Storage::read_at(&v, 4, &mut [0, 0]).is_err());
    }
}
