//! Reading a storage through a window, so that neighbouring blocks cost one read.

use super::chain::ReadAt;
use super::storage::Storage;
use std::cell::RefCell;
use std::io;

/// A reader of `storage` that remembers the bytes around the last read. It is for a time in which nothing is written.
pub(crate) struct Window<'a, S> {
    storage: &'a S,
    size: u64,
    seen: RefCell<(u64, Vec<u8>)>,
}

impl<'a, S: Storage> Window<'a, S> {
    /// For look-ups here and there.
    pub(crate) fn small(storage: &'a S) -> Self {
        Window {
            storage,
            size: 2 << 10,
            seen: RefCell::default(),
        }
    }

    /// For a walk over everything.
    pub(crate) fn large(storage: &'a S) -> Self {
        Window {
            storage,
            size: 128 << 10,
            seen: RefCell::default(),
        }
    }
}

impl<S: Storage> ReadAt for Window<'_, S> {
    fn read_at(&self, offset: u64, buf: &mut [u8]) -> io::Result<()> {
        let mut seen = self.seen.borrow_mut();
        let (start, bytes) = &mut *seen;
        let within = |start: u64, bytes: &[u8]| {
            let at = usize::try_from(offset.checked_sub(start)?).ok()?;
            bytes.get(at..)?.get(..buf.len()).map(|_| at)
        };
        let at = match within(*start, bytes) {
            Some(at) => at,
            None => {
                let len = self.storage.size()?;
                // Aligned, so that a walk that goes back a little stays inside.
                *start = offset / self.size * self.size;
                let end = (*start + 2 * self.size).max(offset + buf.len() as u64).min(len);
                bytes.clear();
                bytes.resize(end.saturating_sub(*start) as usize, 0);
                if let Err(e) = self.storage.read_at(*start, bytes) {
                    bytes.clear();
                    return Err(e);
                }
                within(*start, bytes).ok_or(io::ErrorKind::UnexpectedEof)?
            }
        };
        match bytes.get(at..at + buf.len()) {
            Some(from) => buf.copy_from_slice(from),
            None => return Err(io::ErrorKind::UnexpectedEof.into()),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_shows_what_is_there() {
        let bytes: Vec<u8> = (0..300_000u32).map(|i| (i / 7) as u8).collect();
        for window in [Window::small(&bytes), Window::large(&bytes)] {
            for (at, n) in [
                (0, 4),
                (131_070, 4),
                (65_535, 2),
                (200_000, 90_000),
                (299_996, 4),
                (5, 0),
                (131_071, 1),
            ] {
                let mut buf = vec![0; n];
                window.read_at(at as u64, &mut buf).unwrap();
                assert_eq!(buf, bytes[at..at + n]);
            }
            assert!(window.read_at(299_997, &mut [0; 4]).is_err());
            assert!(window.read_at(900_000, &mut [0; 4]).is_err());
        }
    }
}
