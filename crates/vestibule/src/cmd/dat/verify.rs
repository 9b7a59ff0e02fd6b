//! `vestibule dat verify`.

use std::io::Write;
use std::path::PathBuf;

use serde_json::json;
use vestibule::round_trips::{FileReport, verify_file};

use crate::ui::{Align, Context, Failed, Progress, Table, open_dats, style};

/// Check every block and every record of DAT files
///
/// Walks the directory, every block chain and the free list, then parses every record, encodes it again and compares
/// the bytes.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule dat verify
  vestibule dat verify ~/ac
  vestibule dat verify ~/ac --json

Exit code 0 only if nothing is damaged and every record comes back with the same bytes.")]
pub(crate) struct Args {
    /// Folder of DAT files [default: as --dat]
    dir: Option<PathBuf>,
    /// Print every problem, not only the first twenty of a file
    #[arg(long)]
    all: bool,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let folder = args.dir.as_deref().or(context.folder());
    let dats = open_dats(folder)?;
    let mut reports = Vec::new();
    for (kind, file) in dats.files() {
        // About as many records as there are kilobytes.
        let mut progress = Progress::new("records", u64::from(file.header().file_size) / 1024);
        reports.push(verify_file(kind, file, &mut |done| progress.set(done)));
    }
    let clean = reports.iter().all(FileReport::is_clean);
    if context.json {
        context.print_json(&json!({ "clean": clean, "files": reports }))?;
    } else {
        print(&reports, args.all, context)?;
    }
    if clean { Ok(()) } else { Err(Failed.into()) }
}

fn print(reports: &[FileReport], all: bool, context: &mut Context) -> anyhow::Result<()> {
    let out = &mut context.out;
    let mut table = Table::new(&[
        ("file", Align::Left),
        ("records", Align::Right),
        ("identical", Align::Right),
        ("padding", Align::Right),
        ("different", Align::Right),
        ("unreadable", Align::Right),
        ("blocks", Align::Right),
        ("free", Align::Right),
        ("leaked", Align::Right),
        ("damage", Align::Right),
    ]);
    for r in reports {
        let mut row = vec![r.file.clone()];
        for n in [
            r.records,
            r.identical,
            r.padding_differs,
            r.different,
            r.unreadable,
        ] {
            row.push(n.to_string());
        }
        for n in [r.blocks.used, r.blocks.free, r.blocks.leaked, r.container_errors] {
            row.push(n.to_string());
        }
        table.row(row);
    }
    table.write(out)?;
    for r in reports {
        let shown = if all { r.problems.len() } else { 20 };
        for problem in r.problems.iter().take(shown) {
            writeln!(out, "{}problem{:#}: {problem}", style::BAD, style::BAD)?;
        }
        if r.problems.len() > shown {
            writeln!(
                out,
                "... and {} more (--all shows them)",
                r.problems.len() - shown
            )?;
        }
        for warning in &r.warnings {
            writeln!(
                out,
                "{}warning{:#}: {}: {warning}",
                style::WARN,
                style::WARN,
                r.file
            )?;
        }
    }
    let records: u64 = reports.iter().map(|r| r.records).sum();
    let same: u64 = reports.iter().map(|r| r.identical + r.padding_differs).sum();
    let passed: u64 = reports.iter().map(|r| r.passed_through).sum();
    let percent = if records == 0 {
        100.0
    } else {
        same as f64 * 100.0 / records as f64
    };
    // 99.999 must not read as 100.
    let percent = if same < records && percent > 99.99 {
        99.99
    } else {
        percent
    };
    let good = reports.iter().all(FileReport::is_clean);
    let style = if good { style::GOOD } else { style::BAD };
    let passed = if passed == 0 {
        String::new()
    } else {
        format!(" ({passed} of types that are passed through)")
    };
    writeln!(
        out,
        "{style}{same} of {records} records come back byte for byte: {percent:.2} %{style:#}{passed}"
    )?;
    Ok(())
}
