//! The verifier: everything that a container can have wrong, in one walk (`dat-format.md` B8, R4, 11).

use super::compress::inflate;
use super::dat_file::{DatFile, View};
use super::free_list::read_free_list;
use super::iteration::{ITERATION_ID, IterationRecord};
use super::scan::{Owner, Scan, scan};
use crate::error::{Error, ErrorKind, Fault};

/// Errors that a report lists; more are only counted.
const LISTED: usize = 10_000;

/// What [`DatFile::verify`] finds.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct VerifyReport {
    /// Records in the directory, where it can be read.
    pub records: usize,
    /// Nodes of the directory, where it can be read.
    pub nodes: usize,
    /// Levels of the directory.
    pub depth: usize,
    /// Blocks that nodes and records use.
    pub used_blocks: usize,
    /// Blocks on the free list, 0 if the list is broken.
    pub free_blocks: usize,
    /// Whole blocks that are neither used nor on the free list: left by a writer that was stopped, or slack (C9, W2).
    pub leaked_blocks: usize,
    /// Damage: each names file, record, byte offset and field. At most 10,000, see [`VerifyReport::error_count`].
    pub errors: Vec<Error>,
    /// How many errors there are, also those that are not listed.
    pub error_count: usize,
    /// What is odd but does no harm.
    pub warnings: Vec<String>,
}

impl VerifyReport {
    /// Whether the file has no damage.
    pub fn is_clean(&self) -> bool {
        self.error_count == 0
    }
}

impl DatFile {
    /// Checks the whole file: every node, every chain, that no block is used twice, that compressed records inflate, the
    /// iteration record and the free list. Reads everything, so it takes its time on a large file.
    pub fn verify(&self) -> VerifyReport {
        let view = self.view();
        let mut report = VerifyReport::default();
        let (bytes, block_size) = (view.bytes(), view.geometry().block_size);
        let mut buffer = Vec::new();
        let mut zero_versions = 0usize;
        let mut scan = scan(&bytes, &view.header, |entry, scan: &mut Scan| {
            zero_versions += usize::from(entry.version == 0);
            if let Err(fault) = check_contents(view, self, entry, &mut buffer, &mut report) {
                scan.faults.push((Some(entry.id), fault));
            }
        });
        report.records = scan.records;
        report.nodes = scan.nodes;
        report.depth = scan.depth;
        report.used_blocks = scan.blocks.len();

        match read_free_list(&bytes, &view.header, |_| false) {
            Ok(free) => {
                report.free_blocks = free.len();
                scan.blocks.extend(free.iter().map(|at| (*at, Owner::FreeList)));
            }
            Err(fault) => scan.faults.push((None, fault)),
        }
        scan.blocks.sort_by_key(|(at, _)| *at);
        for pair in scan.blocks.windows(2) {
            let [(first, other), (second, owner)] = pair else {
                continue;
            };
            if second - first < block_size {
                let kind = ErrorKind::BlockUsedTwice {
                    block: u64::from(*second),
                    other: other.in_words(),
                };
                scan.faults
                    .push((owner.id(), Fault::at(u64::from(*second), "block", kind)));
            }
        }
        let whole = view.geometry().file_size.saturating_sub(1024) / u64::from(block_size);
        let known = (scan.blocks.len() + scan.of_empty_records.len()) as u64;
        report.leaked_blocks = whole.saturating_sub(known) as usize;

        if zero_versions > 0 {
            report.warnings.push(format!(
                "{zero_versions} records have version 0; the retail client refuses them"
            ));
        }
        if !view.header.closed_cleanly() {
            report
                .warnings
                .push("the file was not closed cleanly: its transaction record is not clear".to_owned());
        }
        report.error_count = scan.faults.len();
        let listed = scan.faults.into_iter().take(LISTED);
        report.errors = listed.map(|(id, fault)| fault.named(self.name(), id)).collect();
        report
    }
}

fn check_contents(
    view: &View,
    file: &DatFile,
    entry: &super::node::Entry,
    buffer: &mut Vec<u8>,
    report: &mut VerifyReport,
) -> Result<(), Fault> {
    if !entry.is_compressed() && entry.id != ITERATION_ID {
        return Ok(());
    }
    let mut plain = view.stored(entry)?;
    if entry.is_compressed() {
        inflate(&plain, file.limits(), buffer)?;
        plain = buffer.as_slice().into();
    }
    if entry.id == ITERATION_ID && !IterationRecord::parse_fault(&plain)?.is_complete() {
        report
            .warnings
            .push("the file is incompletely patched: some iterations are missing".to_owned());
    }
    Ok(())
}
