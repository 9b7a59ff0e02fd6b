//! The header block at file offset 0 (`dat-format.md` 2.1, 5.5).

use crate::error::{ErrorKind, Fault};
use std::fmt;

/// Bytes of the header block; no block of data starts before it ends.
pub(crate) const HEADER_SIZE: usize = 0x190;
/// Where the 80 bytes of the disk file info start (C2).
pub(crate) const INFO_OFFSET: usize = 0x140;
/// Bytes of the disk file info.
pub(crate) const INFO_SIZE: usize = HEADER_SIZE - INFO_OFFSET;
/// Where the transaction record starts (5.5).
pub(crate) const TRANSACTION_OFFSET: usize = 0x100;
/// The word at 0x140 ("BT").
pub(crate) const MAGIC: u32 = 0x0000_5442;
/// Where the first block of a new file starts, whatever its block size (5.1).
pub(crate) const DATA_START: u32 = 1024;
/// Blocks start below this offset, because bit 31 of a link is taken (C10).
pub(crate) const MAX_OFFSET: u64 = 0x8000_0000;
/// Largest block size that this library writes; it reads any.
pub(crate) const MAX_WRITE_BLOCK: i32 = 1 << 20;

/// The cleared transaction record of retail files (5.5).
pub const TRANSACTION_CLEAN: [u8; 64] = {
    let mut t = [0; 64];
    t[1] = 0x50;
    t[2] = 0x4C;
    t
};

/// Which of the four files one is (`dat-format.md` 1.1, F1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DatKind {
    /// `client_portal.dat`: data set 1, subset 0.
    Portal,
    /// `client_cell_1.dat`: data set 2.
    Cell,
    /// `client_local_English.dat`: data set 3.
    Local,
    /// `client_highres.dat`: data set 1 with another subset.
    HighRes,
}

impl DatKind {
    /// All four, in the order of the table.
    pub const ALL: [DatKind; 4] = [DatKind::Portal, DatKind::Cell, DatKind::Local, DatKind::HighRes];

    /// The name retail gives the file.
    pub fn file_name(self) -> &'static str {
        match self {
            DatKind::Portal => "client_portal.dat",
            DatKind::Cell => "client_cell_1.dat",
            DatKind::Local => "client_local_English.dat",
            DatKind::HighRes => "client_highres.dat",
        }
    }

    /// What the data set and subset of a header say (F1), `None` for sets that retail does not have.
    pub fn from_data_set(data_set: u32, data_subset: u32) -> Option<DatKind> {
        match (data_set, data_subset) {
            (1, 0) => Some(DatKind::Portal),
            (1, _) => Some(DatKind::HighRes),
            (2, _) => Some(DatKind::Cell),
            (3, _) => Some(DatKind::Local),
            _ => None,
        }
    }

    /// In words, for messages: "a cell file".
    pub fn in_words(self) -> &'static str {
        match self {
            DatKind::Portal => "a portal file",
            DatKind::Cell => "a cell file",
            DatKind::Local => "a local file",
            DatKind::HighRes => "a highres file",
        }
    }
}

impl fmt::Display for DatKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            DatKind::Portal => "portal",
            DatKind::Cell => "cell",
            DatKind::Local => "local",
            DatKind::HighRes => "highres",
        })
    }
}

/// The header block, field by field (`dat-format.md` 2.1).
///
/// Every byte is kept, so that writing a header back changes only what was meant to change (W6).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// Free text, NUL-padded; nothing reads it.
    pub version_string: [u8; 256],
    /// The write-ahead record of one tree operation (5.5), see [`Header::closed_cleanly`].
    pub transaction: [u8; 64],
    /// Bytes of a block, including its 4-byte link.
    pub block_size: i32,
    /// Length of the file in bytes.
    pub file_size: u32,
    /// 1 portal and highres, 2 cell, 3 local.
    pub data_set: u32,
    /// 0 portal, the region number, the language or the highres mark.
    pub data_subset: u32,
    /// Offset of the first free block, 0 for none.
    pub first_free: i32,
    /// Offset of the last free block.
    pub final_free: i32,
    /// Number of free blocks.
    pub free_count: i32,
    /// Offset of the root node's first block, 0 for an empty tree.
    pub btree_root: i32,
    /// Head of the LRU list, 0 in retail files.
    pub young_lru: i32,
    /// Tail of the LRU list, 0 in retail files.
    pub old_lru: i32,
    /// Four bytes of which the low one counts (C3).
    pub use_lru: u32,
    /// Id of the root map from enums to ids, may be 0.
    pub master_map_id: u32,
    /// Engine pack version (C5).
    pub engine_pack_version: i32,
    /// Game pack version; retail wants 0 in portal (C5).
    pub game_pack_version: i32,
    /// A GUID.
    pub version_major: [u8; 16],
    /// Minor version.
    pub version_minor: u32,
}

impl Header {
    /// Which of the four files this is, by data set and subset (F1).
    pub fn kind(&self) -> Option<DatKind> {
        DatKind::from_data_set(self.data_set, self.data_subset)
    }

    /// Whether the transaction record is clear (5.5): retail's cleared form, or 64 zero bytes.
    ///
    /// When it is not, retail was stopped in the middle of a change. Reading goes on, since every node is checked anyway.
    pub fn closed_cleanly(&self) -> bool {
        self.transaction == TRANSACTION_CLEAN || self.transaction == [0; 64]
    }

    /// Reads the header of a file of `file_len` bytes and applies C1.
    pub(crate) fn parse(b: &[u8; HEADER_SIZE], file_len: u64) -> Result<Header, Fault> {
        let h = Header::fields(b);
        let magic = word(b, INFO_OFFSET);
        if magic != MAGIC {
            return Err(Fault::at(0x140, "magic", ErrorKind::BadMagic { found: magic }));
        }
        if h.block_size < 16 || h.block_size % 4 != 0 {
            return Err(Fault::at(
                0x144,
                "block_size",
                ErrorKind::BadBlockSize(h.block_size),
            ));
        }
        let size = u64::from(h.file_size);
        if file_len < size {
            return Err(Fault::at(
                0x148,
                "file_size",
                ErrorKind::TooShort {
                    need: size,
                    have: file_len,
                },
            ));
        }
        if size < HEADER_SIZE as u64 {
            let kind = ErrorKind::TooShort {
                need: HEADER_SIZE as u64,
                have: size,
            };
            return Err(Fault::at(0x148, "file_size", kind));
        }
        let root = h.btree_root as u32;
        if root != 0 && !(HEADER_SIZE as u32..h.file_size).contains(&root) {
            let kind = ErrorKind::OutsideFile {
                value: u64::from(root),
                file_size: size,
            };
            return Err(Fault::at(0x160, "btree_root", kind));
        }
        Ok(h)
    }

    fn fields(b: &[u8; HEADER_SIZE]) -> Header {
        let at = |offset| word(b, offset);
        let mut version_string = [0; 256];
        version_string.copy_from_slice(&b[..256]);
        let mut transaction = [0; 64];
        transaction.copy_from_slice(&b[TRANSACTION_OFFSET..INFO_OFFSET]);
        let mut version_major = [0; 16];
        version_major.copy_from_slice(&b[0x17C..0x18C]);
        Header {
            version_string,
            transaction,
            block_size: at(0x144) as i32,
            file_size: at(0x148),
            data_set: at(0x14C),
            data_subset: at(0x150),
            first_free: at(0x154) as i32,
            final_free: at(0x158) as i32,
            free_count: at(0x15C) as i32,
            btree_root: at(0x160) as i32,
            young_lru: at(0x164) as i32,
            old_lru: at(0x168) as i32,
            use_lru: at(0x16C),
            master_map_id: at(0x170),
            engine_pack_version: at(0x174) as i32,
            game_pack_version: at(0x178) as i32,
            version_major,
            version_minor: at(0x18C),
        }
    }

    /// The 80 bytes at 0x140, which one write commits (C2, W2).
    pub(crate) fn info_bytes(&self) -> [u8; INFO_SIZE] {
        let mut out = [0; INFO_SIZE];
        let words = [
            MAGIC,
            self.block_size as u32,
            self.file_size,
            self.data_set,
            self.data_subset,
            self.first_free as u32,
            self.final_free as u32,
            self.free_count as u32,
            self.btree_root as u32,
            self.young_lru as u32,
            self.old_lru as u32,
            self.use_lru,
            self.master_map_id,
            self.engine_pack_version as u32,
            self.game_pack_version as u32,
        ];
        for (to, from) in out.chunks_exact_mut(4).zip(words) {
            to.copy_from_slice(&from.to_le_bytes());
        }
        out[60..76].copy_from_slice(&self.version_major);
        out[76..80].copy_from_slice(&self.version_minor.to_le_bytes());
        out
    }

    /// All 400 bytes.
    pub(crate) fn bytes(&self) -> [u8; HEADER_SIZE] {
        let mut out = [0; HEADER_SIZE];
        out[..256].copy_from_slice(&self.version_string);
        out[TRANSACTION_OFFSET..INFO_OFFSET].copy_from_slice(&self.transaction);
        out[INFO_OFFSET..].copy_from_slice(&self.info_bytes());
        out
    }
}

fn word(b: &[u8; HEADER_SIZE], offset: usize) -> u32 {
    u32::from_le_bytes([b[offset], b[offset + 1], b[offset + 2], b[offset + 3]])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes of example 12.1.
    const EXAMPLE: [u8; 80] = [
        0x42, 0x54, 0, 0, 0, 1, 0, 0, 0, 0x10, 0, 0, 2, 0, 0, 0, // magic, block 256, size 0x1000, set 2
        1, 0, 0, 0, 0, 0x0F, 0, 0, 0, 0x0F, 0, 0, 1, 0, 0,
        0, // subset 1, first and final free 0xF00, 1 free
        0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // root 0x400, no LRU
        0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0, 0, 0, 0, 0, // map 0, engine -1, game 0
        0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, // minor 1
    ];

    fn example() -> [u8; HEADER_SIZE] {
        let mut b = [0; HEADER_SIZE];
        b[INFO_OFFSET..].copy_from_slice(&EXAMPLE);
        b
    }

    fn fault_field(b: &[u8; HEADER_SIZE], len: u64) -> &'static str {
        Header::parse(b, len).expect_err("accepted").field
    }

    #[test]
    fn example_12_1_disk_file_info() {
        let h = Header::parse(&example(), 0x1000).unwrap();
        assert_eq!(
            (h.block_size, h.file_size, h.data_set, h.data_subset),
            (256, 0x1000, 2, 1)
        );
        assert_eq!(
            (h.first_free, h.final_free, h.free_count, h.btree_root),
            (0xF00, 0xF00, 1, 0x400)
        );
        assert_eq!(
            (h.engine_pack_version, h.game_pack_version, h.version_minor),
            (-1, 0, 1)
        );
        assert_eq!(h.kind(), Some(DatKind::Cell));
        assert_eq!(h.info_bytes(), EXAMPLE);
        assert_eq!(h.bytes(), example());
    }

    #[test]
    fn f1_subset_tells_highres_from_portal() {
        assert_eq!(DatKind::from_data_set(1, 0), Some(DatKind::Portal));
        assert_eq!(DatKind::from_data_set(1, 0x6946_6948), Some(DatKind::HighRes));
        assert_eq!(DatKind::from_data_set(4, 0), None);
    }

    #[test]
    fn c1_rejects_magic_block_size_root_and_length() {
        let mut b = example();
        b[0x140] = 0;
        assert_eq!(fault_field(&b, 0x1000), "magic");
        for bad in [0i32, 12, 18, -256] {
            let mut b = example();
            b[0x144..0x148].copy_from_slice(&bad.to_le_bytes());
            assert_eq!(fault_field(&b, 0x1000), "block_size", "{bad}");
        }
        for bad in [1u32, 0x18F, 0x1000, 0x8000_0400] {
            let mut b = example();
            b[0x160..0x164].copy_from_slice(&bad.to_le_bytes());
            assert_eq!(fault_field(&b, 0x1000), "btree_root", "{bad:X}");
        }
        assert_eq!(fault_field(&example(), 0xFFF), "file_size");
        assert!(
            Header::parse(&example(), 0x1001).is_ok(),
            "a longer file is tolerated"
        );
    }

    #[test]
    fn c3_only_the_low_byte_of_use_lru_counts_and_all_are_kept() {
        let mut b = example();
        b[0x16C..0x170].copy_from_slice(&[0, 0xCD, 0xCD, 0xCD]);
        assert_eq!(Header::parse(&b, 0x1000).unwrap().bytes(), b);
    }

    #[test]
    fn transaction_5_5_clean_forms() {
        let mut b = example();
        assert!(
            Header::parse(&b, 0x1000).unwrap().closed_cleanly(),
            "64 zero bytes are clean"
        );
        b[0x100..0x104].copy_from_slice(&[0, 0x50, 0x4C, 0]);
        assert!(
            Header::parse(&b, 0x1000).unwrap().closed_cleanly(),
            "retail's cleared form is clean"
        );
        b[0x110] = 1;
        assert!(!Header::parse(&b, 0x1000).unwrap().closed_cleanly());
    }
}
