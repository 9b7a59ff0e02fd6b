//! `vestibule build --synthetic`: a world from a number.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use serde_json::json;
use vestibule::forge::synthetic::{SyntheticReport, SyntheticWorld};

use crate::ui::{Align, Context, Progress, Table};

/// How large a world from a number is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Size {
    /// As retail: 65,025 landblocks, 5,464 buildings, 540,000 env cells (180 MB)
    Retail,
    /// The same things on 12 by 12 landblocks, 3,000 env cells
    Small,
}

pub(super) fn run(size: Size, seed: u64, out: &Path, context: &mut Context) -> anyhow::Result<()> {
    let plan = match size {
        Size::Retail => SyntheticWorld::retail(seed),
        Size::Small => SyntheticWorld::small(seed),
    };
    let begun = Instant::now();
    let part = Part::beside(out)?;
    let side = u64::from(plan.side);
    let mut progress = Progress::new("landblocks", side * side);
    let report = plan
        .build(&part.folder, &mut |step| progress.set(u64::from(step.done)))
        .with_context(|| format!("cannot build a world in {}", out.display()))?;
    drop(progress);
    let files = part.move_to(out)?;
    let seconds = begun.elapsed().as_secs_f64();
    print(&report, &files, seconds, out, context)
}

/// A folder that is built in, beside the one that is wanted; gone when it is dropped.
struct Part {
    folder: PathBuf,
}

impl Part {
    fn beside(out: &Path) -> anyhow::Result<Part> {
        anyhow::ensure!(
            !out.is_file(),
            "--out takes a folder; there is a file {}",
            out.display()
        );
        let mut name = out.file_name().unwrap_or("world".as_ref()).to_owned();
        name.push(format!(".{}.part", std::process::id()));
        let folder = out.with_file_name(name);
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
        Ok(Part { folder })
    }

    /// Renames the finished files into the folder. Names and sizes, in the order of names.
    fn move_to(&self, out: &Path) -> anyhow::Result<Vec<(String, u64)>> {
        std::fs::create_dir_all(out).with_context(|| format!("cannot create {}", out.display()))?;
        let mut files = Vec::new();
        for entry in std::fs::read_dir(&self.folder)? {
            let entry = entry?;
            let name = entry.file_name();
            let bytes = entry.metadata()?.len();
            std::fs::rename(entry.path(), out.join(&name))
                .with_context(|| format!("cannot write {}", out.join(&name).display()))?;
            files.push((name.to_string_lossy().into_owned(), bytes));
        }
        files.sort();
        Ok(files)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Most memory that this process has had so far, bytes; `None` where the system does not tell.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

fn print(
    report: &SyntheticReport,
    files: &[(String, u64)],
    seconds: f64,
    out: &Path,
    context: &mut Context,
) -> anyhow::Result<()> {
    let peak = peak_memory();
    let largest = report.dungeons.first().map_or(0, |&(_, cells)| cells);
    if context.json {
        let files: Vec<_> = files
            .iter()
            .map(|(name, bytes)| json!({ "name": name, "bytes": bytes }))
            .collect();
        return context.print_json(&json!({
            "out": out, "files": files, "seconds": seconds, "peak_memory": peak, "start": report.start.to_string(),
            "landblocks": report.landblocks, "buildings": report.buildings,
            "building_portals": report.building_portals, "env_cells": report.env_cells,
            "cell_portals": report.cell_portals, "portals_outside": report.portals_outside,
            "statics": report.statics, "records": report.records, "dungeons": report.dungeons.len(),
            "largest_dungeon": largest, "towns": report.towns.len(),
        }));
    }
    let mut table = Table::new(&[("a world", Align::Left), ("", Align::Right)]);
    let number = |n: u64| {
        let digits = n.to_string();
        let mut out = String::new();
        for (i, digit) in digits.chars().enumerate() {
            if i > 0 && (digits.len() - i).is_multiple_of(3) {
                out.push(',');
            }
            out.push(digit);
        }
        out
    };
    for (what, n) in [
        ("landblocks", u64::from(report.landblocks)),
        ("landblocks with buildings", report.towns.len() as u64),
        ("buildings", u64::from(report.buildings)),
        ("portals of buildings", u64::from(report.building_portals)),
        ("dungeons", report.dungeons.len() as u64),
        ("cells of the largest", u64::from(largest)),
        ("env cells", u64::from(report.env_cells)),
        ("portals of env cells", report.cell_portals),
        ("of them to the outside", report.portals_outside),
        ("static objects", report.statics),
        ("records", report.records),
    ] {
        table.row([what.to_owned(), number(n)]);
    }
    for (name, bytes) in files {
        table.row([name.clone(), megabytes(*bytes)]);
    }
    table.row(["seconds".to_owned(), format!("{seconds:.1}")]);
    if let Some(peak) = peak {
        table.row(["most memory".to_owned(), megabytes(peak)]);
    }
    table.write(&mut context.out)?;
    writeln!(
        context.out,
        "\nwritten to {}; a place to begin: {}",
        out.display(),
        report.start
    )?;
    Ok(())
}
