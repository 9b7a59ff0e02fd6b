//! `vestibule dat extract`.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Context as _;
use serde_json::json;
use vestibule::dat::{DatKind, RecordKind};

use super::super::id::{hex, parse_record_id};
use super::super::inspect::{FileArg, locate};
use crate::ui::{Context, Progress, Usage};

/// Write the bytes of records to files
///
/// One record goes to FILE, or to standard output; with --all every record goes to a file of its own in a folder.
/// Compressed records are written inflated.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule dat extract 0xA9B40100 -o cell.bin
  vestibule dat extract 0x0D000001 | od -A x -t x1z | head
  vestibule dat extract --all -o records
  vestibule dat extract --all --type EnvCell -o cells")]
pub(crate) struct Args {
    /// Record id, eight hexadecimal digits
    #[arg(value_parser = parse_record_id, required_unless_present = "all", conflicts_with = "all")]
    id: Option<u32>,
    /// Every record, each to DIR/FILE/ID.TYPE
    #[arg(long, requires = "output")]
    all: bool,
    /// With --all: only records of this type
    #[arg(long = "type", value_name = "TYPE", requires = "all")]
    kind: Option<String>,
    /// File to write, or folder with --all
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
    /// Take the id as one of this file, or only records of this file
    #[arg(long, value_enum)]
    file: Option<FileArg>,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    if context.json && args.output.is_none() {
        return Err(Usage("--json goes with -o PATH: a record itself is bytes".to_owned()).into());
    }
    let dats = context.dats()?;
    if let Some(id) = args.id {
        let found = locate(&dats, id, args.file, &context.world_name())?;
        match &args.output {
            Some(path) => {
                super::super::write_whole(path, &found.bytes)?;
                let (id, bytes) = (hex(id), found.bytes.len());
                if context.json {
                    return context.print_json(&json!({ "id": id, "bytes": bytes, "written": path }));
                }
                writeln!(context.out, "{id}: {bytes} bytes to {}", path.display())?;
            }
            // Past the colour filter of the context's output, which would take bytes away.
            None => std::io::stdout().write_all(&found.bytes)?,
        }
        return Ok(());
    }
    let Some(folder) = &args.output else {
        return Err(Usage("--all needs -o DIR".to_owned()).into());
    };
    let wanted = match &args.kind {
        Some(name) => {
            let kind = RecordKind::ALL
                .iter()
                .find(|kind| kind.name().eq_ignore_ascii_case(name));
            let kind = kind.ok_or_else(|| Usage(format!("no type '{name}'; `vestibule ls` names them")))?;
            Some(*kind)
        }
        None => None,
    };
    let (mut written, mut failed) = (0u64, 0u64);
    for (file_kind, file) in dats.files() {
        if args.file.is_some_and(|f| f.kind() != file_kind) {
            continue;
        }
        let folder = folder.join(folder_name(file_kind));
        let mut progress = Progress::new("records", u64::from(file.header().file_size) / 1024);
        for (done, entry) in (1..).zip(file.iter()) {
            progress.set(done);
            let read = entry.and_then(|entry| {
                let kind = RecordKind::of(file_kind, entry.id);
                if wanted.is_some_and(|w| w != kind) {
                    Ok(None)
                } else {
                    Ok(Some((entry, kind, file.read(&entry)?)))
                }
            });
            match read {
                Ok(None) => {}
                Ok(Some((entry, kind, bytes))) => {
                    if !folder.is_dir() {
                        std::fs::create_dir_all(&folder)
                            .with_context(|| format!("cannot create {}", folder.display()))?;
                    }
                    let path = folder.join(format!("{:08X}.{kind}", entry.id));
                    std::fs::write(&path, &bytes)
                        .with_context(|| format!("cannot write {}", path.display()))?;
                    written += 1;
                }
                Err(e) => {
                    failed += 1;
                    anstream::eprintln!("warning: {e}");
                }
            }
        }
    }
    if context.json {
        context.print_json(&json!({ "records": written, "failed": failed, "written": folder }))?;
    } else {
        writeln!(context.out, "{written} records to {}", folder.display())?;
    }
    anyhow::ensure!(failed == 0, "{failed} records could not be read");
    Ok(())
}

fn folder_name(kind: DatKind) -> &'static str {
    match kind {
        DatKind::Portal => "portal",
        DatKind::Cell => "cell",
        DatKind::Local => "local",
        DatKind::HighRes => "highres",
    }
}
