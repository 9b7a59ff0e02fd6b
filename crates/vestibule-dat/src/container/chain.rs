//! Blocks and chains (`dat-format.md` 2.2).

use super::header::{HEADER_SIZE, Header};
use crate::error::{ErrorKind, Fault};
use std::io;

/// Bit 31 of a link: this block is free (C7).
pub(crate) const FREE: u32 = 0x8000_0000;

/// Bytes that can be read at an offset: a slice, or the storage of a writer.
pub(crate) trait ReadAt {
    /// Fills `buf` from `offset`. The caller has checked that the range is inside the file.
    fn read_at(&self, offset: u64, buf: &mut [u8]) -> io::Result<()>;
}

impl ReadAt for &[u8] {
    #[inline]
    fn read_at(&self, offset: u64, buf: &mut [u8]) -> io::Result<()> {
        let from = usize::try_from(offset)
            .ok()
            .and_then(|at| self.get(at..)?.get(..buf.len()));
        match from {
            Some(from) => {
                buf.copy_from_slice(from);
                Ok(())
            }
            None => Err(io::ErrorKind::UnexpectedEof.into()),
        }
    }
}

/// What of a header decides where blocks may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Geometry {
    /// Bytes of a block including its link; 16 or more.
    pub(crate) block_size: u32,
    /// Where the file ends.
    pub(crate) file_size: u64,
}

impl Geometry {
    pub(crate) fn of(header: &Header) -> Geometry {
        Geometry {
            block_size: header.block_size as u32,
            file_size: u64::from(header.file_size),
        }
    }

    /// Bytes of a block that are not its link.
    #[inline]
    pub(crate) fn payload(self) -> u32 {
        self.block_size - 4
    }

    /// Blocks that `n` bytes need; at least one (C12).
    pub(crate) fn blocks_for(self, n: u32) -> u32 {
        n.div_ceil(self.payload()).max(1)
    }

    /// Whether `take` bytes of payload can be taken from a block at `offset` (C8, C10).
    #[inline]
    pub(crate) fn holds(self, offset: u32, take: u32) -> bool {
        offset >= HEADER_SIZE as u32
            && offset < FREE
            && u64::from(offset) + 4 + u64::from(take) <= self.file_size
    }

    /// Refuses sizes that no chain of this file can supply, before anything is allocated for them.
    pub(crate) fn check_size(self, start: u32, n: u32) -> Result<(), Fault> {
        if u64::from(n) > self.file_size {
            let missing = u64::from(n) - self.file_size;
            return Err(Fault::at(
                u64::from(start),
                "size",
                ErrorKind::ChainTooShort { missing },
            ));
        }
        Ok(())
    }
}

/// Follows the chain of `n` bytes that starts at `start` and hands each block's offset and the bytes taken from it to `visit`.
///
/// Holds C6 to C9: never follows the last block's link, never visits more blocks than the bytes need, fails on free blocks,
/// on blocks outside the file and on chains that meet themselves.
#[inline]
pub(crate) fn walk_chain<R: ReadAt>(
    bytes: &R,
    g: Geometry,
    start: u32,
    n: u32,
    mut visit: impl FnMut(u32, u32) -> Result<(), Fault>,
) -> Result<(), Fault> {
    // A chain that only ascends cannot meet itself. At the first step back the whole chain is checked once.
    let mut only_ascends = true;
    step_through(bytes, g, start, n, |at, take, next| {
        visit(at, take)?;
        let Some(next) = next else { return Ok(()) };
        if only_ascends && (next < at || next - at < g.block_size) {
            only_ascends = false;
            check_meets_itself(bytes, g, start, n)?;
        }
        Ok(())
    })
}

#[cold]
fn check_meets_itself<R: ReadAt>(bytes: &R, g: Geometry, start: u32, n: u32) -> Result<(), Fault> {
    let mut blocks = Vec::new();
    step_through(bytes, g, start, n, |at, _, _| {
        blocks.push(at);
        Ok(())
    })?;
    blocks.sort_unstable();
    match blocks.windows(2).find(|w| w[1] - w[0] < g.block_size) {
        Some(w) => Err(Fault::at(u64::from(w[1]), "link", ErrorKind::ChainLoop)),
        None => Ok(()),
    }
}

/// The walk itself; `visit` gets a block, the bytes taken from it and the block after it.
#[inline]
fn step_through<R: ReadAt>(
    bytes: &R,
    g: Geometry,
    start: u32,
    n: u32,
    mut visit: impl FnMut(u32, u32, Option<u32>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    g.check_size(start, n)?;
    let mut left = n;
    let mut at = start;
    let mut before = None;
    while left > 0 {
        let take = left.min(g.payload());
        if !g.holds(at, take) {
            let kind = ErrorKind::OutsideFile {
                value: u64::from(at),
                file_size: g.file_size,
            };
            return Err(match before {
                Some(block) => Fault::at(block, "link", kind),
                None => Fault::at(u64::from(at), "offset", kind),
            });
        }
        let mut link = [0; 4];
        bytes
            .read_at(u64::from(at), &mut link)
            .map_err(|e| Fault::at(u64::from(at), "link", e.into()))?;
        let link = u32::from_le_bytes(link);
        if link & FREE != 0 {
            return Err(Fault::at(u64::from(at), "link", ErrorKind::FreeBlock));
        }
        left -= take;
        if left > 0 && link == 0 {
            return Err(Fault::at(
                u64::from(at),
                "link",
                ErrorKind::ChainTooShort {
                    missing: u64::from(left),
                },
            ));
        }
        visit(at, take, (left > 0).then_some(link))?;
        before = Some(u64::from(at));
        at = link;
    }
    Ok(())
}

/// Fills `buf` with the bytes of the chain at `start`.
#[inline]
pub(crate) fn read_chain<R: ReadAt>(bytes: &R, g: Geometry, start: u32, buf: &mut [u8]) -> Result<(), Fault> {
    let n = buf.len() as u32;
    let mut rest = buf;
    walk_chain(bytes, g, start, n, |at, take| {
        let (to, after) = std::mem::take(&mut rest).split_at_mut(take as usize);
        rest = after;
        let from = u64::from(at) + 4;
        bytes
            .read_at(from, to)
            .map_err(|e| Fault::at(from, "payload", e.into()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: Geometry = Geometry {
        block_size: 256,
        file_size: 0x3000,
    };

    /// The chain of example 12.2, its payload numbered through.
    fn example() -> Vec<u8> {
        let mut b = vec![0xEE; 0x3000];
        let mut value = 0u32;
        for (at, link, take) in [(0x1400, 0x1500u32, 252), (0x1500, 0x2000, 252), (0x2000, 0, 96)] {
            b[at..at + 4].copy_from_slice(&link.to_le_bytes());
            for to in &mut b[at + 4..at + 4 + take] {
                *to = value as u8;
                value += 1;
            }
        }
        b
    }

    fn link(b: &mut [u8], at: usize, link: u32) {
        b[at..at + 4].copy_from_slice(&link.to_le_bytes());
    }

    fn read(b: &[u8], n: usize) -> Result<Vec<u8>, Fault> {
        let mut out = vec![0; n];
        read_chain(&b, G, 0x1400, &mut out).map(|()| out)
    }

    #[test]
    fn example_12_2_block_chain() {
        let out = read(&example(), 600).unwrap();
        assert!(out.iter().enumerate().all(|(i, v)| *v == i as u8));
        let mut blocks = Vec::new();
        walk_chain(&&example()[..], G, 0x1400, 600, |at, take| {
            blocks.push((at, take));
            Ok(())
        })
        .unwrap();
        assert_eq!(blocks, [(0x1400, 252), (0x1500, 252), (0x2000, 96)]);
    }

    #[test]
    fn example_12_2_free_block_in_the_chain() {
        let mut b = example();
        link(&mut b, 0x1500, 0x8000_2000);
        let e = read(&b, 600).unwrap_err();
        assert!(
            matches!(e.kind, ErrorKind::FreeBlock) && e.offset == Some(0x1500),
            "{e:?}"
        );
    }

    #[test]
    fn c7_free_mark_on_the_last_block_fails_too() {
        let mut b = example();
        link(&mut b, 0x2000, 0x8000_0000);
        assert!(matches!(read(&b, 600).unwrap_err().kind, ErrorKind::FreeBlock));
        assert!(
            read(&b, 504).is_ok(),
            "a block that is not needed is not looked at"
        );
    }

    #[test]
    fn c8_last_link_is_not_followed_and_truncation_is_found() {
        let mut b = example();
        link(&mut b, 0x2000, 0x7FFF_0000);
        assert!(read(&b, 600).is_ok());
        link(&mut b, 0x2000, 0);
        let e = read(&b, 505 + 252).unwrap_err();
        assert!(matches!(e.kind, ErrorKind::ChainTooShort { missing: 1 }), "{e:?}");
    }

    #[test]
    fn c8_blocks_must_lie_inside_the_file() {
        let mut b = example();
        for bad in [0x10, 0x18F, 0x2FFD, 0x3000, 0x7FFF_FF00] {
            link(&mut b, 0x1500, bad);
            let e = read(&b, 600).unwrap_err();
            assert!(
                matches!(e.kind, ErrorKind::OutsideFile { .. }) && e.offset == Some(0x1500),
                "{e:?}"
            );
        }
        // A last block that is cut off behind the bytes that are wanted is good.
        link(&mut b, 0x1500, 0x3000 - 4 - 96);
        b[0x3000 - 100..0x3000 - 96].fill(0);
        assert!(read(&b, 600).is_ok());
    }

    #[test]
    fn c8_no_bytes_visit_no_block() {
        assert!(read_chain(&&[][..], G, 0xFFFF_FFFF, &mut []).is_ok());
    }

    #[test]
    fn c9_slack_is_ignored_and_cycles_end() {
        assert!(read(&example(), 100).is_ok());
        for (at, to) in [
            (0x1400, 0x1400),
            (0x1500, 0x1400),
            (0x1500, 0x1500),
            (0x1500, 0x1480),
        ] {
            let mut b = example();
            link(&mut b, at, to);
            b[0x1480..0x1484].fill(0);
            assert!(
                matches!(read(&b, 700).unwrap_err().kind, ErrorKind::ChainLoop),
                "{at:X} -> {to:X}"
            );
        }
    }

    #[test]
    fn c9_a_chain_may_go_back_when_it_does_not_meet_itself() {
        let mut b = example();
        link(&mut b, 0x1500, 0x1000);
        b[0x1000..0x1004].fill(0);
        assert!(read(&b, 600).is_ok());
    }

    #[test]
    fn d1_a_size_beyond_the_file_is_refused_before_reading() {
        let e = walk_chain(&&example()[..], G, 0x1400, u32::MAX, |_, _| panic!("visited")).unwrap_err();
        assert_eq!(e.field, "size");
    }
}
