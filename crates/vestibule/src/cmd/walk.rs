//! `vestibule walk`: a player by script or to a target.

use std::io::{Read, Write};
use std::path::PathBuf;

use anyhow::Context as _;
use serde_json::json;
use vestibule::tour::TrailStep;
use vestibule::walk::{by_script, read_script, to_target};
use vestibule::world::Position;

use super::place::{Place, parse_place};
use crate::ui::{Context, hinted, style};

/// Walk a player from a position to a target, or by a script
///
/// To a target the way is found through the portals and walked in steps of 5 cm. By a script a body is moved with
/// gravity, thirty ticks a second. Commands of scripts, one a line: walk, run, back, left, right METRES; turn DEGREES
/// to the right; jump STRENGTH; wait SECONDS; # begins a remark.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("way").args(["to", "script"]).required(true))]
#[command(after_help = "\
Examples:
  vestibule walk --from \"0xA9B40031 [155.5 24 94.1]\" --to \"0xA9B40101 [155.4 14.2 94.1]\"
  vestibule walk --from \"0xA9B40031 [155.5 24 94.1]\" --script steps.txt -o trail.jsonl
  printf 'turn 180\\nwalk 8\\n' | vestibule walk --from \"0xA9B40031 [155.5 24 94.1]\" --script -

The trail is JSON lines, one object a tick: t, cell, pos; `vestibule map --trail` draws it.")]
pub(crate) struct Args {
    /// Where to start: a position or map coordinates
    #[arg(long, value_name = "POS", value_parser = parse_place)]
    from: Place,
    /// Where to go
    #[arg(long, value_name = "POS", value_parser = parse_place)]
    to: Option<Place>,
    /// Script to follow; - for standard input
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    /// File for the trail [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let world = context.world()?;
    let from: Position = args.from.position(&world)?;
    let trail = match (&args.to, &args.script) {
        (Some(to), _) => {
            let to = to.position(&world)?;
            to_target(&world, &from, &to)
                .map_err(|e| hinted(e, "`vestibule where` tells what is at a place"))?
        }
        (None, Some(path)) => {
            let mut text = String::new();
            if path.as_os_str() == "-" {
                std::io::stdin()
                    .read_to_string(&mut text)
                    .context("cannot read standard input")?;
            } else {
                text = std::fs::read_to_string(path)
                    .with_context(|| format!("cannot read {}", path.display()))?;
            }
            let script = read_script(&text).with_context(|| format!("script {}", path.display()))?;
            by_script(&world, &from, &script)
                .map_err(|e| hinted(e, "`vestibule where` tells what is at a place"))?
        }
        (None, None) => Vec::new(),
    };
    if let (Some(to), Some(end)) = (&args.to, trail.last())
        && let Place::Position(asked) = to
        && asked.cell != end.cell
    {
        let (note, from, to) = (style::WARN, asked.cell, end.cell);
        anstream::eprintln!(
            "{note}note{note:#}: {from} does not hold the target; the walk ended in {to}, which does"
        );
    }
    let changes = trail
        .windows(2)
        .filter(|pair| pair[0].cell != pair[1].cell)
        .count();
    let last = trail.last().map(|step| Position::new(step.cell, step.pos));
    let seconds = trail.last().map_or(0.0, |step| step.t);
    match &args.output {
        Some(path) => {
            super::write_whole_by(path, |file| write_rows(&trail, file))
                .with_context(|| format!("cannot write {}", path.display()))?;
            if context.json {
                return context.print_json(&json!({
                    "written": path, "steps": trail.len(), "changes": changes, "seconds": seconds,
                    "end": last.map(|p| p.to_string()),
                }));
            }
            let end = last.map(|p| p.to_string()).unwrap_or_default();
            writeln!(
                context.out,
                "{} ticks, {seconds:.1} s, {changes} changes of cell",
                trail.len()
            )?;
            writeln!(context.out, "{}end{:#} {end}", style::HEAD, style::HEAD)?;
            writeln!(context.out, "written {}", path.display())?;
        }
        None => write_rows(&trail, &mut context.out)?,
    }
    Ok(())
}

fn write_rows(trail: &[TrailStep], out: &mut impl Write) -> std::io::Result<()> {
    for step in trail {
        serde_json::to_writer(&mut *out, step)?;
        writeln!(out)?;
    }
    Ok(())
}
