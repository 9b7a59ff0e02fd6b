//! Writing chains: behind everything that is there, in large writes, or into free blocks first.

use super::chain::Geometry;
use super::header::MAX_OFFSET;
use super::storage::Storage;
use crate::error::{ErrorKind, Fault};
use std::io;

/// Bytes of one write.
const WRITE: usize = 1 << 20;

/// Places chains and writes them.
pub(crate) struct ChainWriter<S: Storage> {
    storage: S,
    block_size: u32,
    /// Free blocks, the first to be used last.
    reusable: Vec<u32>,
    /// Where `buffer` goes.
    at: u64,
    buffer: Vec<u8>,
}

impl<S: Storage> ChainWriter<S> {
    /// A writer that starts at offset `at`.
    pub(crate) fn new(storage: S, block_size: u32, at: u64) -> Self {
        ChainWriter {
            storage,
            block_size,
            reusable: Vec::new(),
            at,
            buffer: Vec::new(),
        }
    }

    /// The same, but into these blocks before others (W4), given in list order.
    pub(crate) fn into_free_blocks(mut self, mut free: Vec<u32>) -> Self {
        free.reverse();
        self.reusable = free;
        self
    }

    /// Zeros up to offset `to`, where the next block starts.
    pub(crate) fn fill_to(&mut self, to: u64) {
        let n = to.saturating_sub(self.end()) as usize;
        self.buffer.resize(self.buffer.len() + n, 0);
    }

    /// Where the next block goes if no free one is left: the end of the file.
    pub(crate) fn end(&self) -> u64 {
        self.at + self.buffer.len() as u64
    }

    /// Writes the chain of `bytes` and gives its offset.
    ///
    /// # Errors
    /// A block would pass 2 GiB (C10); then nothing of the chain is written. Or the storage fails.
    pub(crate) fn chain(&mut self, bytes: &[u8]) -> Result<u32, Fault> {
        let g = Geometry {
            block_size: self.block_size,
            file_size: MAX_OFFSET,
        };
        let full = || Fault::new("size", ErrorKind::FileFull);
        let blocks = g.blocks_for(u32::try_from(bytes.len()).map_err(|_| full())?);
        let free = self
            .reusable
            .split_off(self.reusable.len().saturating_sub(blocks as usize));
        let appended = u64::from(blocks) - free.len() as u64;
        if self.end() + appended * u64::from(self.block_size) > MAX_OFFSET {
            return Err(full());
        }
        // Each block names the next, so the places are known before anything is written.
        let end = self.end() as u32;
        let reused = free.len() as u32;
        let place = |block: u32| match free.len().checked_sub(block as usize + 1) {
            Some(i) => free.get(i).copied().unwrap_or_default(),
            None => end + (block - reused) * self.block_size,
        };
        let (first, last) = (place(0), blocks - 1);
        let links: Vec<_> = (0..reused)
            .map(|block| (place(block), if block < last { place(block + 1) } else { 0 }))
            .collect();
        let mut parts = bytes.chunks(g.payload() as usize);
        let mut block = Vec::new();
        for (at, link) in links {
            block.clear();
            fill_block(&mut block, link, parts.next(), self.block_size);
            let failed = |e: io::Error| Fault::at(u64::from(at), "file", e.into());
            self.storage.write_at(u64::from(at), &block).map_err(failed)?;
        }
        for number in reused..blocks {
            let next = end + (number + 1 - reused) * self.block_size;
            let link = if number < last { next } else { 0 };
            fill_block(&mut self.buffer, link, parts.next(), self.block_size);
            if self.buffer.len() >= WRITE {
                self.flush().map_err(|e| Fault::at(self.at, "file", e.into()))?;
            }
        }
        Ok(first)
    }

    fn flush(&mut self) -> io::Result<()> {
        if !self.buffer.is_empty() {
            self.storage.write_at(self.at, &self.buffer)?;
            self.at += self.buffer.len() as u64;
            self.buffer.clear();
        }
        Ok(())
    }

    /// Writes what is left. Gives the storage and the free blocks that were not needed, in list order.
    pub(crate) fn finish(mut self) -> io::Result<(S, Vec<u32>)> {
        self.flush()?;
        self.reusable.reverse();
        Ok((self.storage, self.reusable))
    }
}

/// Appends a block to `out`: link, payload, zeros (W7).
fn fill_block(out: &mut Vec<u8>, link: u32, payload: Option<&[u8]>, block_size: u32) {
    let end = out.len() + block_size as usize;
    out.extend_from_slice(&link.to_le_bytes());
    out.extend_from_slice(payload.unwrap_or_default());
    out.resize(end, 0);
}

#[cfg(test)]
mod tests {
    use super::super::chain::read_chain;
    use super::*;

    #[test]
    fn example_12_2_written() {
        let bytes: Vec<u8> = (0..600).map(|i| i as u8).collect();
        let mut out = ChainWriter::new(vec![0; 0x1400], 256, 0x2000).into_free_blocks(vec![0x1400, 0x1500]);
        assert_eq!(out.chain(&bytes).unwrap(), 0x1400);
        let (file, rest) = out.finish().unwrap();
        assert!(rest.is_empty());
        assert_eq!(file[0x1400..0x1404], [0, 0x15, 0, 0]);
        assert_eq!(file[0x1500..0x1504], [0, 0x20, 0, 0]);
        assert_eq!(file[0x2000..0x2004], [0, 0, 0, 0]);
        assert_eq!(file[0x2004..0x2004 + 96], bytes[504..]);
        assert_eq!(file.len(), 0x2100);
        let mut back = vec![0; 600];
        let g = Geometry {
            block_size: 256,
            file_size: 0x2100,
        };
        read_chain(&&file[..], g, 0x1400, &mut back).unwrap();
        assert_eq!(back, bytes);
    }

    #[test]
    fn example_12_3_free_blocks_are_taken_by_link() {
        let mut out =
            ChainWriter::new(Vec::new(), 256, 0x6000).into_free_blocks(vec![0x3000, 0x2100, 0x5000]);
        assert_eq!(out.chain(b"one block").unwrap(), 0x3000);
        let (_, rest) = out.finish().unwrap();
        assert_eq!(rest, [0x2100, 0x5000], "first_free is now 0x2100, not 0x3100");
    }
}
