//! `vestibule tour`: a walk in and out of everything.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use anyhow::Context as _;
use serde_json::json;
use vestibule::map_svg::{TrailPoint, plan};
use vestibule::tour::{Change, Membership, MembershipCount, Tour, TourOptions, TourRecord, TourSummary, TrailStep, write_trail};
use vestibule::world::{BlockId, World};

use super::place::{Place, parse_place};
use crate::ui::{Context, Failed, Progress, count, hinted, style};

/// Walk through every cell that can be reached on foot, and print each change of cell
///
/// The route is planned from the world itself, so it works on any DAT files: from a meadow to the nearest entrance,
/// through every opening behind it and back, then to the next entrance; in a dungeon, from its first cell through all
/// others. Steps are 5 cm. The player's cell is what the sweep carries it into and is never derived from where it
/// rests; in every doorway the player stands still for 100 ticks to show that it does not change.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule tour
  vestibule tour --dat ~/ac --start 42.1N,33.6E
  vestibule tour --start \"0xA9B40101 [155.4 14.2 94.005]\" --out indoors
  vestibule tour --membership static --out derived
  vestibule tour --json

Writes trail.jsonl (one object a step: t, cell, pos) and map.svg to the folder of --out.
Exit code 1 if the cell changed while standing.")]
pub(crate) struct Args {
    /// Where to start: a position or map coordinates [default: before the first entrance found]
    #[arg(long, value_name = "POS", value_parser = parse_place)]
    start: Option<Place>,
    /// Visit entrances of landblocks up to this many blocks away
    #[arg(long, value_name = "BLOCKS", default_value_t = 1)]
    radius: u8,
    /// Ticks to stand still in each doorway
    #[arg(long, value_name = "TICKS", default_value_t = 100)]
    stand: u32,
    /// Stop after this many steps
    #[arg(long, value_name = "N", default_value_t = 3_000_000)]
    max_steps: usize,
    /// How the cell is told: by the sweep as in retail, or derived from the resting position as other clients did
    #[arg(long, value_enum, default_value_t = MembershipArg::Sweep)]
    membership: MembershipArg,
    /// Do not run into things after the walk
    #[arg(long)]
    no_trials: bool,
    /// Do not look through the chase camera, which takes half of the time
    #[arg(long)]
    no_look: bool,
    /// Folder for trail.jsonl and map.svg
    #[arg(short, long, value_name = "DIR", default_value = "tour")]
    out: PathBuf,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum MembershipArg {
    /// The cell that the last accepted sweep ended in
    Sweep,
    /// The first cell that holds the foot point
    Static,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let dats = context.dats()?;
    let world = World::open(dats.clone())?;
    let start = args.start.map(|place| place.position(&world)).transpose()?;
    let options = TourOptions {
        start,
        radius: args.radius,
        stand_ticks: args.stand,
        max_steps: args.max_steps,
        membership: match args.membership {
            MembershipArg::Sweep => Membership::Sweep,
            MembershipArg::Static => Membership::Static,
        },
        trials: !args.no_trials,
        look: !args.no_look,
    };
    let mut changes: Vec<Change> = Vec::new();
    let mut broken: Option<std::io::Error> = None;
    let json = context.json;
    if !json {
        let name = context.world_name();
        writeln!(context.out, "A tour of {name}\n")?;
        let (head, dim) = (style::HEAD, style::DIM);
        writeln!(
            context.out,
            "{head}   time  cell                        position                   by{head:#}{dim}{dim:#}"
        )?;
    }
    let result = {
        let out = &mut context.out;
        let mut on_change = |change: &Change| {
            if json {
                changes.push(change.clone());
            } else if broken.is_none() {
                broken = print_change(change, out).err();
            }
        };
        // How long it will be is not known beforehand.
        let mut progress = Progress::spinner("steps");
        Tour::run(&world, &dats, options, &mut on_change, &mut |steps| {
            progress.set(steps as u64)
        })
    };
    if let Some(error) = broken {
        return Err(error.into());
    }
    let record =
        result.map_err(|e| hinted(e, "--start takes a position as `vestibule where` explains them"))?;
    std::fs::create_dir_all(&args.out).with_context(|| format!("cannot create {}", args.out.display()))?;
    let trail_path = args.out.join("trail.jsonl");
    write_trail_file(&record, &trail_path)?;
    let (trail, summary) = (&record.trail, &record.summary);
    let mut written = vec![trail_path];
    written.extend(write_maps(&world, trail, &args.out)?);
    if json {
        context.print_json(&json!({ "changes": changes, "summary": summary, "written": written }))?;
    } else {
        print_summary(summary, context)?;
        for path in &written {
            writeln!(context.out, "written {}", path.display())?;
        }
        for problem in world.problems() {
            anstream::eprintln!("{}warning{:#}: {problem}", style::WARN, style::WARN);
        }
    }
    if summary.changes_while_standing > 0 {
        Err(Failed.into())
    } else {
        Ok(())
    }
}

fn print_change(change: &Change, out: &mut impl Write) -> std::io::Result<()> {
    let (cell, dim) = (style::CELL, style::DIM);
    let (_, position) = change.position.split_once(' ').unwrap_or(("", ""));
    let mark = if change.standing { " (standing still!)" } else { "" };
    writeln!(
        out,
        "{:7.2}  {dim}{} to{dim:#} {cell}{}{cell:#}  {position:<25}  {}{mark}",
        change.t, change.from, change.to, change.by
    )?;
    out.flush()
}

fn print_summary(summary: &TourSummary, context: &mut Context) -> anyhow::Result<()> {
    let out = &mut context.out;
    let head = style::HEAD;
    writeln!(out)?;
    writeln!(out, "{head}started{head:#}      {}", summary.start)?;
    writeln!(
        out,
        "{head}cells{head:#}        {} of {} connected ones, {}",
        count(summary.env_cells, "env cell"),
        summary.env_cells_connected,
        count(summary.land_cells, "land cell")
    )?;
    writeln!(
        out,
        "{head}transitions{head:#}  {}, {} through portals",
        summary.transitions, summary.through_portals
    )?;
    let good = summary.changes_while_standing == 0 && summary.look_ups_that_differ == 0;
    let verdict = if good { style::GOOD } else { style::BAD };
    writeln!(
        out,
        "{head}standing{head:#}     {} in {}, {verdict}changes while standing: {}{verdict:#}",
        count(summary.standing_ticks as usize, "tick"),
        count(summary.doorways, "doorway"),
        summary.changes_while_standing
    )?;
    let mut counts = |title: &str, what: &str, n: &MembershipCount| {
        writeln!(
            out,
            "{head}{title:<13}{head:#}{what}: {} changes, {} taken back at once, {} while standing, {} ticks in another cell",
            n.changes, n.flickers, n.while_standing, n.ticks_off
        )
    };
    counts("membership", "by the sweep", &summary.by_sweep)?;
    counts("", "by resting position", &summary.by_position)?;
    writeln!(
        out,
        "{head}walked{head:#}       {:.1} m in {:.1} s, {}",
        summary.metres,
        summary.seconds,
        count(summary.steps, "step")
    )?;
    if summary.falls > 0 || summary.teleports > 0 {
        writeln!(
            out,
            "{head}falls{head:#}        {}, put back {} where there was no way back on foot",
            summary.falls,
            count(summary.teleports, "time")
        )?;
    }
    if summary.out_of_reach > 0 {
        writeln!(
            out,
            "{head}out of reach{head:#} {}, more than a step above floor or ground",
            count(summary.out_of_reach, "opening")
        )?;
    }
    for (title, list) in [
        ("not passed", &summary.not_passed),
        ("not reached", &summary.unreached_entrances),
    ] {
        for (i, opening) in list.iter().enumerate().take(12) {
            let title = if i == 0 { title } else { "" };
            writeln!(
                out,
                "{head}{title:<13}{head:#}portal {} of {} to {}: {}",
                opening.portal, opening.cell, opening.to, opening.what
            )?;
        }
        if list.len() > 12 {
            writeln!(
                out,
                "{:13}... and {} more (--json lists them)",
                "",
                list.len() - 12
            )?;
        }
    }
    if !summary.not_entered.is_empty() {
        let shown: Vec<&str> = summary.not_entered.iter().take(8).map(String::as_str).collect();
        let more = if summary.not_entered.len() > 8 { " ..." } else { "" };
        writeln!(out, "{head}not entered{head:#}  {}{more}", shown.join(" "))?;
    }
    if let Some(why) = &summary.ended_early {
        writeln!(out, "{}ended early{:#}  {why}", style::WARN, style::WARN)?;
    }
    Ok(())
}

/// A map of the landblock in which the tour spent most of its time, and of the others it came through.
fn write_maps(world: &World, trail: &[TrailStep], folder: &std::path::Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut blocks: std::collections::BTreeMap<BlockId, usize> = std::collections::BTreeMap::new();
    for step in trail {
        *blocks.entry(step.cell.block()).or_default() += 1;
    }
    let points: Vec<TrailPoint> = trail
        .iter()
        .map(|s| TrailPoint {
            cell: s.cell,
            pos: s.pos,
        })
        .collect();
    let main = blocks
        .iter()
        .max_by_key(|(_, steps)| **steps)
        .map(|(block, _)| *block);
    let mut written = Vec::new();
    for &block in blocks.keys() {
        let Some(svg) = plan(world, block, &points) else {
            continue;
        };
        let name = if Some(block) == main {
            "map.svg".to_owned()
        } else {
            format!("map-{:04X}.svg", block.0)
        };
        let path = folder.join(name);
        std::fs::write(&path, svg).with_context(|| format!("cannot write {}", path.display()))?;
        written.push(path);
    }
    Ok(written)
}

fn write_trail_file(record: &TourRecord, path: &std::path::Path) -> anyhow::Result<()> {
    let write = || -> std::io::Result<()> {
        let mut file = BufWriter::new(File::create(path)?);
        write_trail(record, &mut file)?;
        file.flush()
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}
