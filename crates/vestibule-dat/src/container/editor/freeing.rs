//! What becomes of the blocks that batches have replaced (`dat-format.md` W2 step 5, W4, R4).

use super::DatEditor;
use crate::container::chain::{FREE, Geometry};
use crate::container::free_list::{Used, links, read_free_list};
use crate::container::header::INFO_OFFSET;
use crate::container::node::NODE_SIZE;
use crate::container::scan::scan;
use crate::container::storage::Storage;
use crate::container::window::Window;
use crate::error::{Fault, Result};

/// What [`DatEditor::close`] did with the blocks that edits have replaced.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CloseReport {
    /// Blocks that were added to the free list.
    pub freed: usize,
    /// The free list was broken and has been made anew from all that is not in use (R4).
    pub rebuilt: bool,
    /// The tree is damaged somewhere, so nobody can tell what is free: the blocks were left alone.
    pub damaged: bool,
}

impl<S: Storage> DatEditor<S> {
    /// W4: blocks that this batch may write into; the header no longer lists them.
    pub(super) fn take_free_blocks(&mut self) -> Result<Vec<u32>, Fault> {
        if !self.options.reuse_free {
            return Ok(Vec::new());
        }
        let mut free = match self.free.take() {
            Some(free) => free,
            None => self.checked_free_list()?.0.unwrap_or_default(),
        };
        let g = Geometry::of(&self.header);
        let records: u64 = self
            .pending
            .values()
            .map(|b| u64::from(g.blocks_for(b.len() as u32)))
            .sum();
        // Every node that is loaded may be written: more than enough, what is over goes back on the list.
        let nodes = self.tree.nodes.len() as u64 * u64::from(g.blocks_for(NODE_SIZE as u32));
        let wanted = usize::try_from(records + nodes)
            .unwrap_or(usize::MAX)
            .min(free.len());
        let rest = free.split_off(wanted);
        self.set_free_list(&rest);
        self.free = Some(rest);
        if wanted > 0 {
            self.write_info().map_err(|e| Fault::new("header", e.into()))?;
        }
        Ok(free)
    }

    pub(super) fn set_free_list(&mut self, free: &[u32]) {
        self.header.first_free = free.first().copied().unwrap_or(0) as i32;
        self.header.final_free = free.last().copied().unwrap_or(0) as i32;
        self.header.free_count = free.len() as i32;
    }

    /// Writes the 80 bytes that commit, and flushes (C2).
    pub(super) fn write_info(&mut self) -> std::io::Result<()> {
        self.storage
            .write_at(INFO_OFFSET as u64, &self.header.info_bytes())?;
        self.storage.sync()
    }

    /// R4: the free list if it is good, else one made anew from everything that is not in use and written out. `None` for a
    /// list if the tree is damaged. Also gives what is in use and whether the list was made anew.
    fn checked_free_list(&mut self) -> Result<(Option<Vec<u32>>, Used, bool), Fault> {
        let window = Window::large(&self.storage);
        let scan = scan(&window, &self.header, |_, _| ());
        let used = Used::of(&scan, self.header.block_size as u32);
        if !scan.faults.is_empty() {
            return Ok((None, used, false));
        }
        if let Ok(free) = read_free_list(&window, &self.header, |at| used.touches(at)) {
            return Ok((Some(free), used, false));
        }
        drop(window);
        let free = used.gaps(Geometry::of(&self.header));
        self.write_links(&free)?;
        self.set_free_list(&free);
        self.write_info().map_err(|e| Fault::new("header", e.into()))?;
        Ok((Some(free), used, true))
    }

    fn write_links(&mut self, free: &[u32]) -> Result<(), Fault> {
        let io = |e: std::io::Error| Fault::new("link", e.into());
        for (at, link) in links(free) {
            self.storage
                .write_at(u64::from(at), &link.to_le_bytes())
                .map_err(io)?;
        }
        self.storage.sync().map_err(io)
    }

    /// Puts the blocks that committed batches have replaced behind the free list (W2 step 5), after checking the list (R4), and
    /// lets go of the file. Changes that are not committed are dropped.
    ///
    /// # Errors
    /// The file cannot be written. No record is touched by that.
    pub fn close(self) -> Result<CloseReport> {
        self.close_with().map(|(report, _)| report)
    }

    /// [`DatEditor::close`], and gives the storage back.
    ///
    /// # Errors
    /// As [`DatEditor::close`].
    pub fn close_with(mut self) -> Result<(CloseReport, S)> {
        let report = match self.ended || self.to_free.is_empty() {
            true => CloseReport::default(),
            false => self
                .free_replaced()
                .map_err(|fault| fault.named(&self.name, None))?,
        };
        Ok((report, self.storage))
    }

    fn free_replaced(&mut self) -> Result<CloseReport, Fault> {
        let (free, used, rebuilt) = self.checked_free_list()?;
        let Some(mut free) = free else {
            return Ok(CloseReport {
                damaged: true,
                ..CloseReport::default()
            });
        };
        if rebuilt {
            return Ok(CloseReport {
                freed: free.len(),
                rebuilt,
                damaged: false,
            });
        }
        let mut new = std::mem::take(&mut self.to_free);
        new.sort_unstable();
        new.dedup();
        // Of cross-linked chains, what another record uses must stay; and nothing may be on the list twice.
        let block_size = self.header.block_size as u32;
        let mut listed = free.clone();
        listed.sort_unstable();
        let mut end = 0u64;
        new.retain(|at| {
            let after = listed.partition_point(|l| l < at);
            let overlaps_listed = listed.get(after).is_some_and(|l| l - at < block_size)
                || after
                    .checked_sub(1)
                    .and_then(|i| listed.get(i))
                    .is_some_and(|l| at - l < block_size);
            let good = u64::from(*at) >= end
                && u64::from(*at) + u64::from(block_size) <= u64::from(self.header.file_size)
                && !used.touches(*at)
                && !overlaps_listed;
            if good {
                end = u64::from(*at) + u64::from(block_size);
            }
            good
        });
        let Some(first) = new.first().copied() else {
            return Ok(CloseReport::default());
        };
        self.write_links(&new)?;
        if let Some(last) = free.last() {
            let link = (FREE | first).to_le_bytes();
            self.storage
                .write_at(u64::from(*last), &link)
                .map_err(|e| Fault::new("link", e.into()))?;
            self.storage.sync().map_err(|e| Fault::new("link", e.into()))?;
        }
        let freed = new.len();
        free.append(&mut new);
        self.set_free_list(&free);
        self.write_info().map_err(|e| Fault::new("header", e.into()))?;
        Ok(CloseReport {
            freed,
            ..CloseReport::default()
        })
    }
}
