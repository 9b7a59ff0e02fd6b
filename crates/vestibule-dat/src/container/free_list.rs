//! Free blocks: the list, its check, its rebuilding (`dat-format.md` 4).

use super::chain::{FREE, Geometry, ReadAt};
use super::header::{DATA_START, Header};
use super::scan::Scan;
use crate::error::{ErrorKind, Fault};

/// Blocks that nodes and records use, ascending.
pub(crate) struct Used {
    starts: Vec<u32>,
    block_size: u32,
}

impl Used {
    pub(crate) fn of(scan: &Scan, block_size: u32) -> Used {
        let mut starts: Vec<u32> = scan.blocks.iter().map(|(at, _)| *at).collect();
        starts.extend_from_slice(&scan.of_empty_records);
        Used::new(starts, block_size)
    }

    fn new(mut starts: Vec<u32>, block_size: u32) -> Used {
        starts.sort_unstable();
        starts.dedup();
        Used { starts, block_size }
    }

    /// Whether a block at `at` would overlap a used one.
    pub(crate) fn touches(&self, at: u32) -> bool {
        let after = self.starts.partition_point(|s| *s < at);
        let next = self.starts.get(after).is_some_and(|s| s - at < self.block_size);
        let before = after.checked_sub(1).and_then(|i| self.starts.get(i));
        next || before.is_some_and(|s| at - s < self.block_size)
    }

    /// Every whole block that fits between the used ones, from the start of the data to the end of the file (R4).
    pub(crate) fn gaps(&self, g: Geometry) -> Vec<u32> {
        let mut free = Vec::new();
        let mut at = self
            .starts
            .first()
            .map_or(DATA_START, |first| DATA_START.min(*first));
        let ends = self.starts.iter().map(|s| u64::from(*s)).chain([g.file_size]);
        for end in ends {
            while u64::from(at) + u64::from(g.block_size) <= end && at < FREE {
                free.push(at);
                at += g.block_size;
            }
            if end < g.file_size {
                at = (end as u32).saturating_add(g.block_size);
            }
        }
        free
    }
}

/// Follows the free list and checks it (R1, R4). Gives its blocks in list order.
///
/// `used` is asked whether a block is reachable from the tree.
pub(crate) fn read_free_list<R: ReadAt>(
    bytes: &R,
    header: &Header,
    used: impl Fn(u32) -> bool,
) -> Result<Vec<u32>, Fault> {
    let g = Geometry::of(header);
    let broken = |at: u32, field, why| Fault::at(u64::from(at), field, ErrorKind::FreeList(why));
    let count = u64::from(header.free_count.max(0) as u32);
    if header.free_count < 0 || count * u64::from(g.block_size) > g.file_size {
        return Err(broken(
            0x15C,
            "free_count",
            "no file of this size has so many blocks",
        ));
    }
    let mut blocks = Vec::with_capacity(count as usize);
    let mut at = header.first_free as u32;
    if count == 0 {
        if at != 0 || header.final_free != 0 {
            return Err(broken(0x154, "first_free", "it is not empty, but should be"));
        }
        return Ok(blocks);
    }
    for left in (0..count).rev() {
        if !g.holds(at, 0) {
            return Err(broken(at, "link", "it leaves the file"));
        }
        if used(at) {
            return Err(broken(at, "link", "it runs through a block in use"));
        }
        let mut link = [0; 4];
        bytes
            .read_at(u64::from(at), &mut link)
            .map_err(|e| Fault::at(u64::from(at), "link", e.into()))?;
        let link = u32::from_le_bytes(link);
        if link & FREE == 0 {
            return Err(broken(at, "link", "a block on it is not marked free"));
        }
        blocks.push(at);
        let next = link & !FREE;
        if (next == 0) != (left == 0) {
            return Err(broken(at, "link", "it has not as many blocks as the header says"));
        }
        at = next;
    }
    if blocks.last() != Some(&(header.final_free as u32)) {
        return Err(broken(0x158, "final_free", "it does not end at final_free"));
    }
    let mut sorted = blocks.clone();
    sorted.sort_unstable();
    if let Some(w) = sorted.windows(2).find(|w| w[1] - w[0] < g.block_size) {
        return Err(broken(w[1], "link", "it comes by a block twice"));
    }
    Ok(blocks)
}

/// What the free list of `blocks` is to be told: each block's link.
pub(crate) fn links(blocks: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    let nexts = blocks.iter().skip(1).copied().chain([0]);
    blocks.iter().copied().zip(nexts.map(|next| FREE | next))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::header::DatKind;

    /// The list of example 12.3.
    fn example() -> (Vec<u8>, Header) {
        let mut b = vec![0u8; 0x6000];
        for (at, link) in links(&[0x3000, 0x2100, 0x5000]) {
            b[at as usize..at as usize + 4].copy_from_slice(&link.to_le_bytes());
        }
        let mut h = Header::new(DatKind::Cell);
        (h.first_free, h.final_free, h.free_count) = (0x3000, 0x5000, 3);
        h.file_size = 0x6000;
        (b, h)
    }

    fn read(b: &[u8], h: &Header) -> Result<Vec<u32>, Fault> {
        read_free_list(&b, h, |_| false)
    }

    #[test]
    fn example_12_3_free_list() {
        let (b, h) = example();
        assert_eq!(b[0x3000..0x3004], [0, 0x21, 0, 0x80]);
        assert_eq!(b[0x2100..0x2104], [0, 0x50, 0, 0x80]);
        assert_eq!(b[0x5000..0x5004], [0, 0, 0, 0x80]);
        assert_eq!(read(&b, &h).unwrap(), [0x3000, 0x2100, 0x5000]);
    }

    #[test]
    fn r4_each_way_a_list_can_be_broken() {
        let why = |change: &dyn Fn(&mut Vec<u8>, &mut Header), used: u32| {
            let (mut b, mut h) = example();
            change(&mut b, &mut h);
            match read_free_list(&&b[..], &h, |at| at == used).unwrap_err().kind {
                ErrorKind::FreeList(why) => why,
                other => panic!("{other}"),
            }
        };
        let link = |at: usize, link: u32| {
            move |b: &mut Vec<u8>, _: &mut Header| b[at..at + 4].copy_from_slice(&link.to_le_bytes())
        };
        assert!(why(&link(0x2100, 0x5000), 0).contains("not marked"));
        assert!(why(&link(0x2100, 0x8000_0000), 0).contains("as many"));
        assert!(why(&link(0x5000, 0x8000_2200), 0).contains("as many"));
        assert!(why(&link(0x2100, 0x8000_6000), 0).contains("leaves"));
        assert!(why(&|_, h| h.final_free = 0x2100, 0).contains("final_free"));
        assert!(why(&|_, h| h.free_count = -1, 0).contains("so many"));
        assert!(why(&|_, h| h.free_count = i32::MAX, 0).contains("so many"));
        assert!(why(&|_, h| h.free_count = 0, 0).contains("should be"));
        assert!(why(&|_, _| (), 0x2100).contains("in use"));
        // 0x3000 -> 0x2100 -> 0x3000 -> end: twice at 0x3000.
        let cycle = |b: &mut Vec<u8>, h: &mut Header| {
            b[0x2100..0x2104].copy_from_slice(&0x8000_3000u32.to_le_bytes());
            h.final_free = 0x3000;
        };
        assert!(why(&cycle, 0).contains("as many"));
    }

    #[test]
    fn r4_gaps_are_whole_blocks_between_the_used_ones() {
        let g = Geometry {
            block_size: 256,
            file_size: 0x1080,
        };
        let used = Used::new(vec![0x500, 0x600, 0x900, 0xD40], 256);
        // 0xA00.. up to the unaligned 0xD40, then from its end to the end of the file.
        assert_eq!(
            used.gaps(g),
            [0x400, 0x700, 0x800, 0xA00, 0xB00, 0xC00, 0xE40, 0xF40]
        );
        assert_eq!(Used::new(vec![], 256).gaps(g).len(), 12);
        for at in [0x401, 0x5FF, 0x800 + 1, 0x9FF, 0xD40] {
            assert!(used.touches(at), "{at:X}");
        }
        for at in [0x400, 0x700, 0x800, 0xA00, 0xE40] {
            assert!(!used.touches(at), "{at:X}");
        }
    }
}
