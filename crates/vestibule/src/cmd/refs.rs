//! `vestibule refs`: who uses a record.

use std::io::Write;

use serde_json::json;
use vestibule::dat::{DatKind, RecordKind};
use vestibule::references::{of_record, users_of};
use vestibule::world::Store;

use super::id::{hex, parse_record_id};
use super::inspect::{FileArg, locate};
use crate::ui::{Align, Context, Progress, Table, count, style};

/// Show who uses a record, and what it uses
///
/// Looks through every record that can name others: cells, landblocks, models, setups, surfaces, textures, scenes and
/// the region.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule refs 0xA9B40101
  vestibule refs 0x0D000001
  vestibule refs 0x01000001 --json")]
pub(crate) struct Args {
    /// Record id, eight hexadecimal digits
    #[arg(value_parser = parse_record_id)]
    id: u32,
    /// Take the id as one of this file, where it could be of two
    #[arg(long, value_enum)]
    file: Option<FileArg>,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let dats = context.dats()?;
    let found = locate(&dats, args.id, args.file, &context.world_name());
    // A record that is absent may still be named, which is what one would want to know.
    let file = match (&found, args.file) {
        (Ok(found), _) => found.file,
        (Err(_), Some(file)) => file.kind(),
        (Err(_), None) if RecordKind::of_asset_id(args.id) == RecordKind::Unknown => DatKind::Cell,
        (Err(_), None) => DatKind::Portal,
    };
    let store = if file == DatKind::Cell {
        Store::Cell
    } else {
        Store::Portal
    };
    let uses = match &found {
        Ok(found) => found.parse().map(|record| of_record(&record)).unwrap_or_default(),
        Err(_) => Vec::new(),
    };
    let total: u64 = dats
        .files()
        .map(|(_, file)| u64::from(file.header().file_size) / 1024)
        .sum();
    let mut progress = Progress::new("records", total);
    let result = users_of(&dats, store, args.id, &mut |done| progress.set(done));
    drop(progress);
    if context.json {
        let users: Vec<_> = result.users.iter().map(|u| {
            json!({"file": u.file.to_string(), "id": hex(u.id), "type": u.kind.name(), "fields": u.fields})
        }).collect();
        let uses: Vec<_> = uses
            .iter()
            .map(|r| json!({"field": r.field, "id": hex(r.id)}))
            .collect();
        return context.print_json(&json!({
            "id": hex(args.id), "exists": found.is_ok(), "used_by": users, "uses": uses, "unreadable": result.unreadable,
        }));
    }
    let out = &mut context.out;
    let cell = style::CELL;
    let kind = RecordKind::of(file, args.id);
    let state = if found.is_ok() { "" } else { " (does not exist)" };
    writeln!(
        out,
        "{kind} {cell}{}{cell:#}{state} is used by {}",
        hex(args.id),
        count(result.users.len(), "record")
    )?;
    let mut table = Table::new(&[
        ("id", Align::Left),
        ("type", Align::Left),
        ("file", Align::Left),
        ("by", Align::Left),
    ]);
    for user in &result.users {
        table.row([
            hex(user.id),
            user.kind.name().to_owned(),
            user.file.to_string(),
            shorten(&user.fields),
        ]);
    }
    if !result.users.is_empty() {
        table.write(out)?;
    }
    if !uses.is_empty() {
        let mut table = Table::new(&[("uses", Align::Left), ("by", Align::Left)]);
        let mut ids: Vec<u32> = Vec::new();
        for r in &uses {
            if !ids.contains(&r.id) {
                ids.push(r.id);
            }
        }
        for id in ids {
            let fields: Vec<String> = uses
                .iter()
                .filter(|r| r.id == id)
                .map(|r| r.field.to_owned())
                .collect();
            table.row([hex(id), shorten(&fields)]);
        }
        writeln!(out)?;
        table.write(out)?;
    }
    for problem in &result.unreadable {
        anstream::eprintln!("{}warning{:#}: {problem}", style::WARN, style::WARN);
    }
    Ok(())
}

/// Field names on one line: repeated ones once with their number.
fn shorten(fields: &[String]) -> String {
    let mut out: Vec<(String, usize)> = Vec::new();
    for field in fields {
        match out.iter_mut().find(|(known, _)| known == field) {
            Some((_, n)) => *n += 1,
            None => out.push((field.clone(), 1)),
        }
    }
    let more = out.len().saturating_sub(6);
    let mut text: Vec<String> = out
        .into_iter()
        .take(6)
        .map(|(field, n)| {
            if n == 1 {
                field
            } else {
                format!("{field} ({n} times)")
            }
        })
        .collect();
    if more > 0 {
        text.push(format!("and {more} more"));
    }
    text.join(", ")
}
