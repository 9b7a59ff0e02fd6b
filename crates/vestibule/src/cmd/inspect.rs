//! `vestibule inspect`: one record, readable.

use std::borrow::Cow;
use std::io::Write;

use anyhow::Context as _;
use serde_json::json;
use vestibule::dat::record::Record;
use vestibule::dat::{DatFile, DatKind, DatSet, RecordKind};
use vestibule::describe;

use super::id::{hex, parse_record_id};
use crate::ui::{Context, Usage, hinted, style};

/// One of the four files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum FileArg {
    /// client_portal.dat: models, textures, environments
    Portal,
    /// client_cell_1.dat: landblocks and cells
    Cell,
    /// client_local_English.dat: texts and layouts
    Local,
    /// client_highres.dat: large textures
    Highres,
}

impl FileArg {
    pub(crate) fn kind(self) -> DatKind {
        match self {
            FileArg::Portal => DatKind::Portal,
            FileArg::Cell => DatKind::Cell,
            FileArg::Local => DatKind::Local,
            FileArg::Highres => DatKind::HighRes,
        }
    }
}

/// Show a record: its fields, or its bytes
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule inspect 0xA9B40100
  vestibule inspect A9B4FFFF
  vestibule inspect 0x0D000001 --all
  vestibule inspect 0x01000001 --json
  vestibule inspect 0xA9B40100 --hex

The same number can name a record of the cell file and one of the portal file: --file picks.")]
pub(crate) struct Args {
    /// Record id, eight hexadecimal digits
    #[arg(value_parser = parse_record_id)]
    id: u32,
    /// Show the record of this file, where several have one
    #[arg(long, value_enum)]
    file: Option<FileArg>,
    /// Show the bytes
    #[arg(long)]
    hex: bool,
    /// Show long lists in full
    #[arg(long)]
    all: bool,
}

/// A record and where it is.
pub(crate) struct Located<'a> {
    pub(crate) file: DatKind,
    pub(crate) dat: &'a DatFile,
    pub(crate) id: u32,
    pub(crate) bytes: Cow<'a, [u8]>,
    /// Other files that have a record of this id.
    pub(crate) also: Vec<DatKind>,
}

impl Located<'_> {
    pub(crate) fn kind(&self) -> RecordKind {
        RecordKind::of(self.file, self.id)
    }

    pub(crate) fn parse(&self) -> anyhow::Result<Record> {
        Record::parse(self.kind(), self.id, &self.bytes)
            .with_context(|| format!("cannot read {}", self.dat.name()))
    }
}

/// Finds a record in the file asked for, or in the first that has it.
pub(crate) fn locate<'a>(
    dats: &'a DatSet,
    id: u32,
    file: Option<FileArg>,
    world: &str,
) -> anyhow::Result<Located<'a>> {
    let mut with: Vec<DatKind> = match file {
        Some(file) => vec![file.kind()],
        None => dats.files_with(id)?,
    };
    let missing = || {
        hinted(
            anyhow::anyhow!("there is no record {} in {world}", hex(id)),
            "`vestibule ls` lists what there is, `vestibule ls --block A9B4` the cells of a landblock",
        )
    };
    if with.is_empty() {
        return Err(missing());
    }
    let kind = with.remove(0);
    let dat = dats
        .file(kind)
        .ok_or_else(|| Usage(format!("there is no {kind} file in {world}")))?;
    let bytes = dat.get(id)?.ok_or_else(missing)?;
    Ok(Located {
        file: kind,
        dat,
        id,
        bytes,
        also: with,
    })
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let dats = context.dats()?;
    let found = locate(&dats, args.id, args.file, &context.world_name())?;
    let kind = found.kind();
    if context.json {
        let mut value = json!({
            "id": hex(args.id), "type": kind.name(), "file": found.file.to_string(), "bytes": found.bytes.len(),
        });
        if args.hex {
            let digits: String = found.bytes.iter().map(|byte| format!("{byte:02x}")).collect();
            value["hex"] = digits.into();
        } else {
            value["record"] = describe::to_json(&parsed(&found)?);
        }
        return context.print_json(&value);
    }
    let (cell, dim) = (style::CELL, style::DIM);
    let out = &mut context.out;
    writeln!(
        out,
        "{kind} {cell}{}{cell:#}  {dim}{} bytes in {}{dim:#}",
        hex(args.id),
        found.bytes.len(),
        found.dat.name()
    )?;
    for other in &found.also {
        writeln!(
            out,
            "{dim}the {other} file has a record of this id too: --file {other}{dim:#}"
        )?;
    }
    if args.hex {
        return hex_dump(&found.bytes, out);
    }
    let record = parsed(&found)?;
    if let Record::Raw { .. } = record {
        writeln!(out, "this type is passed through untouched; its bytes:")?;
        return hex_dump(&found.bytes, out);
    }
    write!(out, "{}", describe::to_text(&record, args.all))?;
    Ok(())
}

fn parsed(found: &Located<'_>) -> anyhow::Result<Record> {
    found
        .parse()
        .map_err(|e| hinted(e, "--hex shows the bytes of a record that cannot be read"))
}

/// Offsets, sixteen bytes a line, and what of them is text.
fn hex_dump(bytes: &[u8], out: &mut impl Write) -> anyhow::Result<()> {
    for (line, chunk) in bytes.chunks(16).enumerate() {
        let digits: Vec<String> = chunk.iter().map(|b| format!("{b:02x}")).collect();
        let text: String = chunk
            .iter()
            .map(|&b| {
                if b.is_ascii_graphic() || b == b' ' {
                    char::from(b)
                } else {
                    '.'
                }
            })
            .collect();
        writeln!(out, "{:06x}  {:<48} {text}", line * 16, digits.join(" "))?;
    }
    Ok(())
}
