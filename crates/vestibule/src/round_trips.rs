//! Verifies DAT files: the container, and every record against what is written back from its parsed form.

use serde::Serialize;
use vestibule_dat::record::{RoundTrip, round_trip};
use vestibule_dat::{DatFile, DatKind, RecordKind};

/// Problems that are listed; more are only counted.
const LISTED: usize = 1000;

/// What [`verify_file`] found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FileReport {
    /// Which of the four files.
    pub file: String,
    /// Path, or name of bytes in memory.
    pub path: String,
    /// Records in the directory.
    pub records: u64,
    /// Records whose encoding has the same bytes.
    pub identical: u64,
    /// Records whose encoding differs in padding only.
    pub padding_differs: u64,
    /// Records whose encoding has other bytes.
    pub different: u64,
    /// Records that cannot be read.
    pub unreadable: u64,
    /// Of the identical ones, those of types that pass through as bytes.
    pub passed_through: u64,
    /// Damage of the container.
    pub container_errors: u64,
    /// The first problems in words: damage, differences, unreadable records.
    pub problems: Vec<String>,
    /// What is odd but does no harm.
    pub warnings: Vec<String>,
    /// Blocks in use, on the free list, and neither.
    pub blocks: Blocks,
}

/// Blocks of a container.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Blocks {
    /// Used by the directory and by records.
    pub used: u64,
    /// On the free list.
    pub free: u64,
    /// Neither.
    pub leaked: u64,
}

impl FileReport {
    /// Whether the container has no damage and every record can be read and is written back with the same bytes, padding
    /// aside.
    pub fn is_clean(&self) -> bool {
        self.container_errors == 0 && self.different == 0 && self.unreadable == 0
    }

    fn problem(&mut self, text: String) {
        if self.problems.len() < LISTED {
            self.problems.push(text);
        }
    }
}

/// Checks a whole file. `progress` is called with the number of records done.
pub fn verify_file(kind: DatKind, file: &DatFile, progress: &mut dyn FnMut(u64)) -> FileReport {
    let container = file.verify();
    let mut report = FileReport {
        file: kind.to_string(),
        path: file.name().to_owned(),
        container_errors: container.error_count as u64,
        warnings: container.warnings,
        blocks: Blocks {
            used: container.used_blocks as u64,
            free: container.free_blocks as u64,
            leaked: container.leaked_blocks as u64,
        },
        ..FileReport::default()
    };
    for error in &container.errors {
        report.problem(error.to_string());
    }
    let mut bytes = Vec::new();
    for entry in file.iter() {
        // A node that cannot be read is among the container's errors already.
        let Ok(entry) = entry else { continue };
        report.records += 1;
        progress(report.records);
        match file.read_into(entry.id, &mut bytes) {
            Ok(Some(_)) => {}
            Ok(None) => continue,
            Err(_) => {
                report.unreadable += 1;
                continue;
            }
        }
        let record_kind = RecordKind::of(kind, entry.id);
        match round_trip(record_kind, entry.id, &bytes) {
            Ok(RoundTrip::Identical) => {
                report.identical += 1;
                report.passed_through += u64::from(!is_parsed(record_kind));
            }
            Ok(RoundTrip::PaddingDiffers) => report.padding_differs += 1,
            Ok(RoundTrip::Different { offset }) => {
                report.different += 1;
                report.problem(format!(
                    "{record_kind} 0x{:08X}: written back it differs from byte 0x{offset:X} on, in {}",
                    entry.id,
                    file.name()
                ));
            }
            Err(error) => {
                report.unreadable += 1;
                report.problem(format!("{record_kind}: {error}, in {}", file.name()));
            }
        }
    }
    report
}

/// Whether records of this type are parsed, rather than passed through.
fn is_parsed(kind: RecordKind) -> bool {
    use RecordKind as K;
    matches!(
        kind,
        K::LandBlock
            | K::LandBlockInfo
            | K::EnvCell
            | K::Environment
            | K::GfxObj
            | K::Setup
            | K::Region
            | K::Surface
            | K::SurfaceTexture
            | K::RenderSurface
            | K::Palette
            | K::Scene
            | K::GfxObjDegradeInfo
            | K::Iteration
    )
}
