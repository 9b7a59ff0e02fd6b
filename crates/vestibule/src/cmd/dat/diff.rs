//! `vestibule dat diff`.

use std::io::Write;
use std::path::PathBuf;

use serde_json::json;
use vestibule::dat::{DatFile, DatKind, DatSet, Entry, RecordKind};

use super::super::id::hex;
use crate::ui::{Align, Context, Failed, Progress, Table, open_dats, style};

/// Compare the records of two folders of DAT files
///
/// Records are compared by what they hold, not by where they lie or when they were written.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule dat diff old new
  vestibule dat diff ~/ac patched --json

Exit code 0 if all records are the same, 1 if not.")]
pub(crate) struct Args {
    /// Folder of the old files
    old: PathBuf,
    /// Folder of the new files
    new: PathBuf,
}

/// How a record differs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Change {
    Removed,
    Added,
    Changed { at: usize },
    Unreadable,
}

impl Change {
    fn name(self) -> &'static str {
        match self {
            Change::Removed => "removed",
            Change::Added => "added",
            Change::Changed { .. } => "changed",
            Change::Unreadable => "unreadable",
        }
    }
}

struct Row {
    file: DatKind,
    id: u32,
    change: Change,
    sizes: [Option<usize>; 2],
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let (old, new) = (open_dats(Some(&args.old))?, open_dats(Some(&args.new))?);
    let mut rows = Vec::new();
    let mut same = 0u64;
    for kind in DatKind::ALL {
        compare(kind, &old, &new, &mut rows, &mut same);
    }
    if context.json {
        let changes: Vec<_> = rows
            .iter()
            .map(|row| {
                json!({
                    "file": row.file.to_string(), "id": hex(row.id), "type": RecordKind::of(row.file, row.id).name(),
                    "change": row.change.name(), "old_bytes": row.sizes[0], "new_bytes": row.sizes[1],
                })
            })
            .collect();
        context.print_json(&json!({ "same": same, "differ": rows.len(), "changes": changes }))?;
    } else {
        print(&rows, same, context)?;
    }
    if rows.is_empty() {
        Ok(())
    } else {
        Err(Failed.into())
    }
}

fn print(rows: &[Row], same: u64, context: &mut Context) -> anyhow::Result<()> {
    let out = &mut context.out;
    let mut table = Table::new(&[
        ("change", Align::Left),
        ("id", Align::Left),
        ("type", Align::Left),
        ("file", Align::Left),
        ("bytes", Align::Left),
    ]);
    for row in rows {
        let sizes = match (row.sizes, row.change) {
            ([Some(old), Some(new)], Change::Changed { at }) => {
                format!("{old} to {new}, from byte 0x{at:X} on")
            }
            ([Some(old), _], Change::Removed) => old.to_string(),
            ([_, Some(new)], _) => new.to_string(),
            _ => String::new(),
        };
        let kind = RecordKind::of(row.file, row.id);
        table.row([
            row.change.name().to_owned(),
            hex(row.id),
            kind.to_string(),
            row.file.to_string(),
            sizes,
        ]);
    }
    if rows.is_empty() {
        writeln!(
            out,
            "{}all {same} records are the same{:#}",
            style::GOOD,
            style::GOOD
        )?;
        return Ok(());
    }
    table.write(out)?;
    let number = |wanted: &str| rows.iter().filter(|row| row.change.name() == wanted).count();
    writeln!(
        out,
        "{same} the same, {} changed, {} added, {} removed, {} unreadable",
        number("changed"),
        number("added"),
        number("removed"),
        number("unreadable")
    )?;
    Ok(())
}

/// Walks two directories side by side: both ascend by id.
fn compare(kind: DatKind, old: &DatSet, new: &DatSet, rows: &mut Vec<Row>, same: &mut u64) {
    let entries = |file: Option<&DatFile>| -> Vec<Entry> {
        file.into_iter()
            .flat_map(|file| file.iter())
            .filter_map(|entry| {
                entry
                    .inspect_err(|e| anstream::eprintln!("{}warning{:#}: {e}", style::WARN, style::WARN))
                    .ok()
            })
            .collect()
    };
    let (old_file, new_file) = (old.file(kind), new.file(kind));
    let (olds, news) = (entries(old_file), entries(new_file));
    let mut progress = Progress::new("records", olds.len() as u64);
    let (mut i, mut j) = (0, 0);
    loop {
        progress.set(i as u64);
        let row = |id, change, sizes| Row {
            file: kind,
            id,
            change,
            sizes,
        };
        match (olds.get(i), news.get(j)) {
            (None, None) => break,
            (Some(a), b) if b.is_none_or(|b| a.id < b.id) => {
                rows.push(row(a.id, Change::Removed, [Some(a.size as usize), None]));
                i += 1;
            }
            (a, Some(b)) if a.is_none_or(|a| b.id < a.id) => {
                rows.push(row(b.id, Change::Added, [None, Some(b.size as usize)]));
                j += 1;
            }
            (Some(a), Some(b)) => {
                let read = |file: Option<&DatFile>, entry: &Entry| {
                    file.and_then(|f| f.read(entry).ok().map(|bytes| bytes.into_owned()))
                };
                match (read(old_file, a), read(new_file, b)) {
                    (Some(x), Some(y)) if x == y => *same += 1,
                    (Some(x), Some(y)) => {
                        let at = x
                            .iter()
                            .zip(&y)
                            .position(|(p, q)| p != q)
                            .unwrap_or(x.len().min(y.len()));
                        rows.push(row(a.id, Change::Changed { at }, [Some(x.len()), Some(y.len())]));
                    }
                    (x, y) => {
                        let sizes = [x.map(|b| b.len()), y.map(|b| b.len())];
                        rows.push(row(a.id, Change::Unreadable, sizes));
                    }
                }
                i += 1;
                j += 1;
            }
            // Covered by the guards above.
            _ => break,
        }
    }
}
