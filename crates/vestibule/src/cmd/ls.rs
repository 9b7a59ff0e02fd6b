//! `vestibule ls`: records by type.

use std::collections::BTreeMap;
use std::io::Write;

use serde_json::json;
use vestibule::dat::{DatKind, Entry, RecordKind};
use vestibule::world::BlockId;

use super::id::{hex, parse_block};
use super::inspect::FileArg;
use crate::ui::{Align, Context, Progress, Table, Usage, count, style};

/// List records: how many of each type, or those that match
///
/// Without a filter prints a table of types. With a type or a landblock prints the records themselves.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule ls
  vestibule ls EnvCell
  vestibule ls --block A9B4
  vestibule ls --file portal --limit 20 GfxObj
  vestibule ls Setup --json")]
pub(crate) struct Args {
    /// Only records of this type, as the table names it
    #[arg(value_name = "TYPE", value_parser = parse_kind)]
    kind: Option<RecordKind>,
    /// Only records of this landblock
    #[arg(long, value_parser = parse_block)]
    block: Option<BlockId>,
    /// Only records of this file
    #[arg(long, value_enum)]
    file: Option<FileArg>,
    /// Print at most this many records
    #[arg(long, value_name = "N")]
    limit: Option<usize>,
}

fn parse_kind(text: &str) -> Result<RecordKind, String> {
    let found = RecordKind::ALL
        .iter()
        .find(|kind| kind.name().eq_ignore_ascii_case(text));
    found
        .copied()
        .ok_or_else(|| "no such type; `vestibule ls` names them".to_owned())
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let dats = context.dats()?;
    if let Some(file) = args.file
        && dats.file(file.kind()).is_none()
    {
        return Err(Usage(format!(
            "there is no {} file in {}",
            file.kind(),
            context.world_name()
        ))
        .into());
    }
    let list = args.kind.is_some() || args.block.is_some() || args.limit.is_some();
    let total: u64 = dats
        .files()
        .map(|(_, file)| u64::from(file.header().file_size) / 1024)
        .sum();
    let mut progress = Progress::new("records", total);
    let mut types: BTreeMap<(DatKind, RecordKind), Tally> = BTreeMap::new();
    let mut listed: Vec<(DatKind, RecordKind, Entry)> = Vec::new();
    let mut damage = Vec::new();
    let mut matching = 0usize;
    let mut done = 0;
    for (file_kind, file) in dats.files() {
        if args.file.is_some_and(|f| f.kind() != file_kind)
            || args.block.is_some() && file_kind != DatKind::Cell
        {
            continue;
        }
        let ids = match args.block {
            Some(block) => u32::from(block.0) << 16..=u32::from(block.0) << 16 | 0xFFFF,
            None => 0..=u32::MAX,
        };
        for entry in file.range(ids) {
            done += 1;
            progress.set(done);
            match entry {
                Ok(entry) => {
                    let kind = RecordKind::of(file_kind, entry.id);
                    if args.kind.is_some_and(|k| k != kind) {
                        continue;
                    }
                    matching += 1;
                    types.entry((file_kind, kind)).or_default().add(&entry);
                    if list && listed.len() < args.limit.unwrap_or(usize::MAX) {
                        listed.push((file_kind, kind, entry));
                    }
                }
                Err(e) => damage.push(e.to_string()),
            }
        }
    }
    drop(progress);
    for problem in &damage {
        anstream::eprintln!("{}warning{:#}: {problem}", style::WARN, style::WARN);
    }
    if context.json {
        return print_json(context, list, &types, &listed, matching, &damage);
    }
    let name = context.world_name();
    let out = &mut context.out;
    if list {
        let mut table = Table::new(&[
            ("id", Align::Left),
            ("type", Align::Left),
            ("file", Align::Left),
            ("bytes", Align::Right),
        ]);
        for (file, kind, entry) in &listed {
            table.row([
                hex(entry.id),
                kind.name().to_owned(),
                file.to_string(),
                entry.size.to_string(),
            ]);
        }
        table.write(out)?;
        if matching > listed.len() {
            writeln!(out, "... and {} more", matching - listed.len())?;
        }
        writeln!(out, "{}", count(matching, "record"))?;
        return Ok(());
    }
    let mut table = Table::new(&[
        ("type", Align::Left),
        ("file", Align::Left),
        ("records", Align::Right),
        ("bytes", Align::Right),
        ("first id", Align::Left),
        ("last id", Align::Left),
    ]);
    for ((file, kind), tally) in &types {
        table.row([
            kind.name().to_owned(),
            file.to_string(),
            tally.records.to_string(),
            tally.bytes.to_string(),
            hex(tally.first),
            hex(tally.last),
        ]);
    }
    table.write(out)?;
    writeln!(out, "{} in {name}", count(matching, "record"))?;
    Ok(())
}

fn print_json(
    context: &mut Context,
    list: bool,
    types: &BTreeMap<(DatKind, RecordKind), Tally>,
    listed: &[(DatKind, RecordKind, Entry)],
    matching: usize,
    damage: &[String],
) -> anyhow::Result<()> {
    let types: Vec<_> = types
        .iter()
        .map(|((file, kind), t)| {
            json!({
                "type": kind.name(), "file": file.to_string(), "records": t.records, "bytes": t.bytes,
                "first": hex(t.first), "last": hex(t.last),
            })
        })
        .collect();
    let mut value = json!({ "records": matching, "types": types, "damage": damage });
    if list {
        let records: Vec<_> = listed
            .iter()
            .map(|(file, kind, e)| {
                json!({ "id": hex(e.id), "type": kind.name(), "file": file.to_string(), "bytes": e.size })
            })
            .collect();
        value["list"] = records.into();
    }
    context.print_json(&value)
}

#[derive(Default)]
struct Tally {
    records: u64,
    bytes: u64,
    first: u32,
    last: u32,
}

impl Tally {
    fn add(&mut self, entry: &Entry) {
        if self.records == 0 {
            self.first = entry.id;
        }
        self.records += 1;
        self.bytes += u64::from(entry.size);
        self.last = entry.id;
    }
}
