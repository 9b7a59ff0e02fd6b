//! `vestibule replay`: a recording against a world.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Context as _;
use vestibule::replay::{read, run as replay};
use vestibule::world::BlockId;

use super::id::parse_block;
use crate::ui::{Align, Context, Failed, Progress, Table, hinted, style};

/// Hold a recorded trail, or a log of cell look-ups, against a world
///
/// FILE is a trail as tour and walk write it, or a log of look-ups with the columns number, seed, x, y, z, picked.
/// Each row is looked up afresh from its seed (a trail's seed is the cell of the row before), and a trail's rows are
/// walked too: a row agrees if either gives its cell. Rows after a teleport are left out.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule replay tour/trail.jsonl
  vestibule replay doorway.log --block A9B4 --dat ~/ac
  vestibule replay tour/trail.jsonl --json

Exit code 1 if a row differs.")]
pub(crate) struct Args {
    /// Trail or log
    file: PathBuf,
    /// Landblock of cell ids that have four digits only
    #[arg(long, value_parser = parse_block, default_value = "A9B4")]
    block: BlockId,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let text = std::fs::read_to_string(&args.file)
        .with_context(|| format!("cannot read {}", args.file.display()))?;
    let hint = "replay reads JSON lines with cell and pos, or rows of number, seed, x, y, z, picked cell";
    let rows = read(&text, args.block.0).map_err(|e| {
        let error = anyhow::Error::from(e).context(format!("cannot understand {}", args.file.display()));
        hinted(error, hint)
    })?;
    if rows.is_empty() {
        return Err(hinted(
            anyhow::anyhow!("there are no rows in {}", args.file.display()),
            hint,
        ));
    }
    let world = context.world()?;
    let progress = Progress::new("rows", rows.len() as u64);
    let report = replay(&world, &rows);
    drop(progress);
    if report.rows == 0 {
        let text = format!(
            "there is nothing to hold against the world in {}",
            args.file.display()
        );
        let hint = "a trail's first row, and rows after a teleport, have no cell to start from";
        return Err(hinted(anyhow::anyhow!(text), hint));
    }
    let good = report.differences.is_empty();
    if context.json {
        context.print_json(&report)?;
    } else {
        let out = &mut context.out;
        if !good {
            let mut table = Table::new(&[
                ("line", Align::Right),
                ("seed", Align::Left),
                ("position", Align::Left),
                ("recorded", Align::Left),
                ("found", Align::Left),
            ]);
            for d in &report.differences {
                let [x, y, z] = d.pos;
                let position = format!("[{x:.4} {y:.4} {z:.4}]");
                table.row([
                    d.line.to_string(),
                    d.seed.clone(),
                    position,
                    d.recorded.clone(),
                    d.found.clone(),
                ]);
            }
            table.write(out)?;
        }
        let style = if good { style::GOOD } else { style::BAD };
        writeln!(
            out,
            "{style}replay: {} of {} rows agree{style:#}",
            report.agree, report.rows
        )?;
    }
    if good { Ok(()) } else { Err(Failed.into()) }
}
