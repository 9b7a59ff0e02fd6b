//! Nodes and entries of the B-tree directory (`dat-format.md` 3.1 to 3.3).

use super::chain::{Geometry, ReadAt, read_chain};
use super::header::HEADER_SIZE;
use crate::error::{ErrorKind, Fault};
use std::ops::Range;

/// Bytes of a node.
pub(crate) const NODE_SIZE: usize = 1716;
/// Most entries of a node (B7).
pub(crate) const MAX_ENTRIES: usize = 61;
/// Fewest entries of a node that is not the root, in trees that we write (B7).
pub(crate) const MIN_ENTRIES: usize = 30;
/// Most levels of a tree (B8).
pub(crate) const MAX_DEPTH: usize = 8;
/// Bytes of an entry.
pub(crate) const ENTRY_SIZE: usize = 24;
const COUNT_AT: usize = 0xF8;
/// Where the entries start.
pub(crate) const ENTRIES_AT: usize = 0xFC;
/// What other tools write into unused branches (B4).
const UNUSED_BRANCH: u32 = 0xCDCD_CDCD;

/// The ids that the parents leave to a node (B3); ends are `u64` so that the whole range can be said.
pub(crate) type Interval = Range<u64>;

/// The interval of the root.
pub(crate) const ALL_IDS: Interval = 0..1 << 32;

/// A directory entry: where a record lies and what is known about it (`dat-format.md` 3.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Entry {
    /// Data id, the key.
    pub id: u32,
    /// Bit 0: the record is compressed with zlib; other bits are reserved.
    pub flags: u16,
    /// Pack version of the record, usually 2.
    pub version: u16,
    /// File offset of the first block.
    pub offset: u32,
    /// Bytes stored in the chain (of the compressed form, if it is compressed).
    pub size: u32,
    /// Seconds since 1970-01-01 UTC.
    pub date: u32,
    /// Patch iteration that last wrote the record.
    pub iteration: i32,
}

impl Entry {
    /// Whether the stored bytes are compressed (flags bit 0, B9).
    pub fn is_compressed(&self) -> bool {
        self.flags & 1 != 0
    }

    /// Reads the 24 bytes of an entry.
    pub(crate) fn parse(b: &[u8; ENTRY_SIZE]) -> Entry {
        let word = |at: usize| u32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]]);
        Entry {
            flags: word(0) as u16,
            version: (word(0) >> 16) as u16,
            id: word(4),
            offset: word(8),
            size: word(12),
            date: word(16),
            iteration: word(20) as i32,
        }
    }

    /// The 24 bytes of the entry.
    pub(crate) fn bytes(&self) -> [u8; ENTRY_SIZE] {
        let words = [
            u32::from(self.flags) | u32::from(self.version) << 16,
            self.id,
            self.offset,
            self.size,
            self.date,
            self.iteration as u32,
        ];
        let mut out = [0; ENTRY_SIZE];
        for (to, from) in out.chunks_exact_mut(4).zip(words) {
            to.copy_from_slice(&from.to_le_bytes());
        }
        out
    }
}

/// A node as read and checked (B8).
#[derive(Clone)]
pub(crate) struct Node {
    bytes: [u8; NODE_SIZE],
    count: usize,
    leaf: bool,
    /// Where the node starts in the file.
    pub(crate) offset: u32,
}

impl Node {
    /// Reads the node at `offset` and checks it against what its parents say (B8). `depth` of the root is 0.
    pub(crate) fn read<R: ReadAt>(
        bytes: &R,
        g: Geometry,
        offset: u32,
        depth: usize,
        interval: &Interval,
    ) -> Result<Node, Fault> {
        let here = u64::from(offset);
        if depth >= MAX_DEPTH {
            return Err(Fault::at(here, "branches", ErrorKind::TooDeep));
        }
        let mut node = Node {
            bytes: [0; NODE_SIZE],
            count: 0,
            leaf: false,
            offset,
        };
        read_chain(bytes, g, offset, &mut node.bytes)?;
        let count = node.word(COUNT_AT);
        if count > MAX_ENTRIES as u32 {
            return Err(Fault::at(here, "entry_count", ErrorKind::TooManyEntries(count)));
        }
        if count == 0 && depth > 0 {
            return Err(Fault::at(here, "entry_count", ErrorKind::EmptyNode));
        }
        node.count = count as usize;
        node.leaf = matches!(node.branch(0), 0 | UNUSED_BRANCH);
        node.check(g, interval)?;
        Ok(node)
    }

    fn check(&self, g: Geometry, interval: &Interval) -> Result<(), Fault> {
        let mut low = interval.start;
        for i in 0..self.count {
            let id = u64::from(self.id(i));
            if id < low || id >= interval.end {
                let kind = ErrorKind::IdOutOfOrder { id: self.id(i) };
                return Err(Fault::at(u64::from(self.offset), "entry.id", kind));
            }
            low = id + 1;
        }
        if !self.leaf {
            for i in 0..=self.count {
                let child = self.branch(i);
                if child < HEADER_SIZE as u32 || u64::from(child) + 4 > g.file_size || child == self.offset {
                    let kind = ErrorKind::OutsideFile {
                        value: u64::from(child),
                        file_size: g.file_size,
                    };
                    return Err(Fault::at(u64::from(self.offset), "branches", kind));
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn word(&self, at: usize) -> u32 {
        let b = &self.bytes;
        u32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]])
    }

    /// Number of entries.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    #[inline]
    pub(crate) fn is_leaf(&self) -> bool {
        self.leaf
    }

    /// Child at position `i`, 0 to `len()`.
    #[inline]
    pub(crate) fn branch(&self, i: usize) -> u32 {
        self.word(4 * i)
    }

    /// Id of the entry at position `i`.
    #[inline]
    pub(crate) fn id(&self, i: usize) -> u32 {
        self.word(ENTRIES_AT + ENTRY_SIZE * i + 4)
    }

    /// Entry at position `i`.
    pub(crate) fn entry(&self, i: usize) -> Entry {
        let at = ENTRIES_AT + ENTRY_SIZE * i;
        let mut b = [0; ENTRY_SIZE];
        b.copy_from_slice(&self.bytes[at..at + ENTRY_SIZE]);
        Entry::parse(&b)
    }

    /// Position of the first entry whose id is at or above `key` (B5).
    pub(crate) fn position(&self, key: u32) -> usize {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let mid = (low + high) / 2;
            if self.id(mid) < key {
                low = mid + 1;
            } else {
                high = mid;
            }
        }
        low
    }

    /// The ids that this node leaves to its child at position `i` (B3).
    pub(crate) fn child_interval(&self, i: usize, own: &Interval) -> Interval {
        let start = if i == 0 {
            own.start
        } else {
            u64::from(self.id(i - 1)) + 1
        };
        let end = if i == self.count {
            own.end
        } else {
            u64::from(self.id(i))
        };
        start..end
    }
}

/// The 1716 bytes of a node. Unused slots are 0, so that every reader takes a leaf for a leaf (B4).
pub(crate) fn node_bytes(entries: &[Entry], branches: &[u32]) -> [u8; NODE_SIZE] {
    debug_assert!(
        entries.len() <= MAX_ENTRIES && (branches.is_empty() || branches.len() == entries.len() + 1)
    );
    let mut out = [0; NODE_SIZE];
    for (to, from) in out.chunks_exact_mut(4).zip(branches) {
        to.copy_from_slice(&from.to_le_bytes());
    }
    out[COUNT_AT..ENTRIES_AT].copy_from_slice(&(entries.len() as u32).to_le_bytes());
    for (to, from) in out[ENTRIES_AT..].chunks_exact_mut(ENTRY_SIZE).zip(entries) {
        to.copy_from_slice(&from.bytes());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: Geometry = Geometry {
        block_size: 2048,
        file_size: 0x4000,
    };

    fn entry(id: u32) -> Entry {
        Entry {
            id,
            flags: 0,
            version: 2,
            offset: 0x400,
            size: 4,
            date: 0,
            iteration: 1,
        }
    }

    fn at_0x400(node: [u8; NODE_SIZE]) -> Vec<u8> {
        let mut b = vec![0; 0x4000];
        b[0x404..0x404 + NODE_SIZE].copy_from_slice(&node);
        b
    }

    fn read(b: &[u8], depth: usize, interval: Interval) -> Result<Node, Fault> {
        Node::read(&b, G, 0x400, depth, &interval)
    }

    #[test]
    fn example_12_4_directory_entry() {
        let b = [
            0, 0, 2, 0, 0xFF, 0xFF, 0xB4, 0xA9, 0, 0x14, 0, 0, 0xFC, 0, 0, 0, //
            0, 0xF1, 0x53, 0x65, 1, 0, 0, 0,
        ];
        let e = Entry::parse(&b);
        let expected = Entry {
            id: 0xA9B4_FFFF,
            flags: 0,
            version: 2,
            offset: 0x1400,
            size: 252,
            date: 1_700_000_000,
            iteration: 1,
        };
        assert_eq!(e, expected);
        assert_eq!(e.bytes(), b);
    }

    #[test]
    fn example_12_5_search() {
        let ids = [0x0001_FFFF, 0x7F00_FFFE, 0xC0A8_0100].map(entry);
        let b = at_0x400(node_bytes(&ids, &[0x1000, 0x1800, 0x2000, 0x2800]));
        let n = read(&b, 0, ALL_IDS).unwrap();
        assert!(n.position(0xA9B4_0170) == 2 && n.id(2) != 0xA9B4_0170);
        assert!(n.position(0xFFFF_0001) == 3);
        assert!(n.position(0x7F00_FFFE) == 1 && n.id(1) == 0x7F00_FFFE);
        assert_eq!(
            n.branch(2),
            u32::from_le_bytes(b[0x404 + 8..0x404 + 12].try_into().unwrap())
        );
        assert_eq!(n.entry(2).bytes(), b[0x404 + 0xFC + 48..][..24]);
    }

    #[test]
    fn b4_leaf_by_the_first_branch_only() {
        let mut node = node_bytes(&[entry(1)], &[]);
        assert!(read(&at_0x400(node), 0, ALL_IDS).unwrap().is_leaf());
        node[..248].fill(0xCD);
        assert!(read(&at_0x400(node), 0, ALL_IDS).unwrap().is_leaf());
        assert!(
            !read(&at_0x400(node_bytes(&[entry(1)], &[0x1000, 0x1000])), 0, ALL_IDS)
                .unwrap()
                .is_leaf()
        );
        assert_eq!(
            node_bytes(&[entry(1)], &[])[..248],
            [0; 248],
            "unused slots are written as 0"
        );
    }

    #[test]
    fn b8_each_check_of_a_node() {
        let field = |node, depth, interval| {
            read(&at_0x400(node), depth, interval)
                .map(|_| ())
                .unwrap_err()
                .field
        };
        let mut counts = node_bytes(&[entry(1)], &[]);
        counts[0xF8] = 62;
        assert_eq!(field(counts, 0, ALL_IDS), "entry_count");
        assert_eq!(field(node_bytes(&[], &[]), 1, ALL_IDS), "entry_count");
        assert!(
            read(&at_0x400(node_bytes(&[], &[])), 0, ALL_IDS).is_ok(),
            "an empty root is legal"
        );
        assert_eq!(
            field(node_bytes(&[entry(2), entry(2)], &[]), 0, ALL_IDS),
            "entry.id"
        );
        assert_eq!(
            field(node_bytes(&[entry(3), entry(2)], &[]), 0, ALL_IDS),
            "entry.id"
        );
        assert_eq!(field(node_bytes(&[entry(3)], &[]), 1, 4..9), "entry.id");
        assert_eq!(field(node_bytes(&[entry(9)], &[]), 1, 4..9), "entry.id");
        assert_eq!(
            field(node_bytes(&[entry(3)], &[0x100, 0x1000]), 0, ALL_IDS),
            "branches"
        );
        assert_eq!(
            field(node_bytes(&[entry(3)], &[0x1000, 0x4000]), 0, ALL_IDS),
            "branches"
        );
        assert_eq!(
            field(node_bytes(&[entry(3)], &[0x400, 0x1000]), 0, ALL_IDS),
            "branches",
            "points to itself"
        );
        assert_eq!(
            field(node_bytes(&[entry(3)], &[]), 8, ALL_IDS),
            "branches",
            "too deep"
        );
    }
}
