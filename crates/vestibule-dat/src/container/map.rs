//! The memory map: the only unsafe code of the workspace.

use std::{fs::File, io};

/// The first bytes of a file, mapped read-only.
pub(crate) struct Map(memmap2::Mmap);

impl Map {
    /// Maps the first `len` bytes of `file`. `len` must be above 0 and not beyond the end of the file.
    ///
    /// Only bytes that the header commits (`file_size`) may be asked for, never an uncommitted tail (W3).
    pub(crate) fn first_bytes(file: &File, len: usize) -> io::Result<Map> {
        if len == 0 || file.metadata()?.len() < len as u64 {
            return Err(io::Error::new(
                io::ErrorKind::UnexpectedEof,
                "the file is shorter than its header says",
            ));
        }
        // SAFETY: a map is sound while nobody shortens the file below it and nobody rewrites bytes that a borrow shows.
        // - Writers of this crate never shorten a file below the `file_size` of a committed header: they cut off only the
        //   tail beyond it (W3), which is never mapped, and file_size never shrinks in place. Whole-file writes go to a new
        //   file and rename it over the old one (W1), which leaves the mapped file as it is.
        // - In place they change the header (copied out before use, never borrowed) and the links of blocks that a newer
        //   tree no longer uses (W2 step 5); payload is written only to blocks beyond every committed file_size. Reusing
        //   free blocks (W4) is off unless the caller vouches that no reader has the file open.
        // - Programs that shorten or overwrite DAT files under a reader break this, as they break every reader that maps
        //   them. `DatFile::open` documents it, and `DatFile::open_in_memory` does without a map.
        #[expect(unsafe_code, reason = "a memory map cannot be had otherwise")]
        let map = unsafe { memmap2::MmapOptions::new().len(len).map(file)? };
        Ok(Map(map))
    }

    /// The mapped bytes.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Seek, SeekFrom, Write};

    #[test]
    fn w3_cutting_off_the_tail_does_not_touch_the_map() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[7; 5000]).unwrap();
        let map = Map::first_bytes(&file, 3000).unwrap();
        file.set_len(3000).unwrap();
        assert_eq!(map.bytes(), &[7; 3000][..]);
        file.seek(SeekFrom::Start(3000)).unwrap();
        file.write_all(&[9; 9000]).unwrap();
        assert_eq!(
            map.bytes(),
            &[7; 3000][..],
            "growth is not part of the map either"
        );
    }

    #[test]
    fn a_map_never_reaches_beyond_the_file() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[7; 100]).unwrap();
        assert!(Map::first_bytes(&file, 101).is_err());
        assert!(Map::first_bytes(&file, 0).is_err());
    }
}
