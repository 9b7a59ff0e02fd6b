//! `vestibule map`: a plan of a landblock.

use std::io::{BufRead, Write};
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use serde::Deserialize;
use vestibule::map_svg::{TrailPoint, plan};
use vestibule::world::{BlockId, CellId, World};

use super::id::parse_block;
use crate::ui::{Context, Usage, hinted};

/// Draw the plan of a landblock as SVG
///
/// The land with its buildings, then the env cells level by level: floors, walls, openings, static objects, and a
/// trail as tour and walk write them.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule map A9B4 -o town.svg
  vestibule map 0xA9B4FFFF --trail tour/trail.jsonl -o walk.svg
  vestibule map A9B4 > town.svg")]
pub(crate) struct Args {
    /// Landblock, four hexadecimal digits (or the id of a cell in it)
    #[arg(value_parser = parse_block)]
    landblock: BlockId,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw this trail: JSON lines with cell and pos
    #[arg(long, value_name = "FILE")]
    trail: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    if context.json && args.output.is_none() {
        return Err(Usage("--json goes with -o FILE: the plan itself is SVG".to_owned()).into());
    }
    let world: World = context.world()?;
    let trail = match &args.trail {
        Some(path) => read_trail(path)?,
        None => Vec::new(),
    };
    let svg = plan(&world, args.landblock, &trail).ok_or_else(|| {
        let error = anyhow::anyhow!(
            "there is no landblock {} in {}",
            args.landblock,
            context.world_name()
        );
        hinted(error, "`vestibule ls LandBlock` lists them")
    })?;
    match &args.output {
        Some(path) => {
            super::write_whole(path, svg.as_bytes())?;
            if context.json {
                context.print_json(&serde_json::json!({ "written": path }))?;
            } else {
                writeln!(context.out, "written {}", path.display())?;
            }
        }
        None => context.out.write_all(svg.as_bytes())?,
    }
    Ok(())
}

/// Reads a trail of JSON lines.
pub(crate) fn read_trail(path: &Path) -> anyhow::Result<Vec<TrailPoint>> {
    #[derive(Deserialize)]
    struct Row {
        cell: String,
        pos: [f32; 3],
    }
    let file = std::fs::File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut out = Vec::new();
    for (line, text) in (1..).zip(std::io::BufReader::new(file).lines()) {
        let place = || format!("line {line} of {}", path.display());
        let text = text.with_context(place)?;
        if text.trim().is_empty() {
            continue;
        }
        let row: Row = serde_json::from_str(&text).with_context(place)?;
        let cell: CellId = row.cell.parse().with_context(place)?;
        out.push(TrailPoint {
            cell,
            pos: row.pos.into(),
        });
    }
    Ok(out)
}
