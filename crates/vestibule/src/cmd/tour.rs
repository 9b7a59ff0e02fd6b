//! `vestibule tour`: a walk in and out of everything.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Instant;

use anyhow::Context as _;
use serde_json::json;
use vestibule::film;
use vestibule::map_svg::{TrailPoint, plan};
use vestibule::render::write_apng;
use vestibule::studio::Studio;
use vestibule::tour::{
    Change, Guide, Membership, MembershipCount, Seen, Tour, TourOptions, TourRecord, TourSummary, TrailStep,
    Trial, write_trail,
};
use vestibule::world::{BlockId, World};

use super::place::{Place, parse_place};
use super::render::{parse_size, png_file};
use crate::ui::{Align, Context, Failed, Progress, Table, count, hinted, style};

/// Walk through every cell that can be reached on foot, and print each change of cell
///
/// The route is planned from the world itself, so it works on any DAT files: from a meadow to the nearest entrance,
/// through every opening behind it and back, then to the next entrance; in a dungeon, from its first cell through all
/// others. Steps are 5 cm. The player's cell is what the sweep carries it into and is never derived from where it
/// rests; in every doorway the player stands still for 100 ticks to show that it does not change. Then it runs into
/// everything: walls, stairs, ramps, an edge, a pit, a door that is shut and then open, a ridge too steep to walk, and is
/// teleported to a dungeon. What deriving the cell from the resting position would have said is counted beside it.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule tour
  vestibule tour --dat ~/ac --start 42.1N,33.6E
  vestibule tour --start \"0xA9B40101 [155.4 14.2 94.005]\" --out indoors
  vestibule tour --membership static --out derived
  vestibule tour --film tour.png
  vestibule tour --json

Writes to the folder of --out:
  trail.jsonl    one object a tick: t, cell, pos; of the camera viewer (its cell) and eye,
                 and rooms (the draw list) whenever it is another
  map.svg        the way from above; map-XXXX.svg for further landblocks
  filmstrip.png  every threshold: before, as the player crosses, as the camera has followed
Exit code 1 if the cell changed while standing, or a trial did not go as expected.")]
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
    /// Do not draw filmstrip.png
    #[arg(long)]
    no_pictures: bool,
    /// Write a film of the tour, an animated PNG that browsers show
    #[arg(long, value_name = "FILE.png", value_parser = png_file(), conflicts_with = "no_look")]
    film: Option<PathBuf>,
    /// Size of the film, pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "200x150", requires = "film")]
    film_size: (u32, u32),
    /// Folder for the trail, maps and pictures
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

/// Whether results can go to a folder, which need not be there yet.
fn can_be_a_folder(path: &std::path::Path) -> anyhow::Result<()> {
    for path in path.ancestors().filter(|p| !p.as_os_str().is_empty()) {
        if path.is_dir() {
            break;
        }
        if path.exists() {
            let error = anyhow::anyhow!("cannot create {}: it is a file", path.display());
            return Err(hinted(error, "--out takes a folder"));
        }
    }
    Ok(())
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let begun = Instant::now();
    // Before a walk that may take minutes, not after it.
    can_be_a_folder(&args.out)?;
    if let Some(folder) = args.film.as_ref().and_then(|film| film.parent()) {
        anyhow::ensure!(
            folder.as_os_str().is_empty() || folder.is_dir() || folder == args.out,
            "there is no folder {}",
            folder.display()
        );
    }
    let dats = context.dats()?;
    let world = World::open(dats.clone())?;
    context.warn_of_damage("");
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
    written.extend(write_pictures(&world, &Guide::of(&dats), &record, args)?);
    if json {
        context.print_json(&json!({ "changes": changes, "summary": summary, "written": written }))?;
    } else {
        print_summary(summary, context)?;
        for path in &written {
            writeln!(context.out, "written {}", path.display())?;
        }
        writeln!(
            context.out,
            "{}in {:.1} s{:#}",
            style::DIM,
            begun.elapsed().as_secs_f64(),
            style::DIM
        )?;
        for problem in world.problems() {
            anstream::eprintln!("{}warning{:#}: {problem}", style::WARN, style::WARN);
        }
    }
    let failed = summary.trials.iter().any(|trial| trial.passed == Some(false));
    if summary.changes_while_standing > 0 || failed {
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
    print_membership(summary, context)?;
    let out = &mut context.out;
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
            "{head}falls{head:#}        {}; put somewhere {}, for trials or where there was no way back",
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
    if let Some(seen) = &summary.seen {
        print_seen(seen, out)?;
    }
    if let Some(why) = &summary.ended_early {
        writeln!(out, "{}ended early{:#}  {why}", style::WARN, style::WARN)?;
    }
    print_trials(&summary.trials, out)
}

/// Both ways of telling the cell, side by side.
fn print_membership(summary: &TourSummary, context: &mut Context) -> anyhow::Result<()> {
    let out = &mut context.out;
    let (sweep, derived) = (&summary.by_sweep, &summary.by_position);
    let mut table = Table::new(&[
        ("membership", Align::Left),
        ("by sweep", Align::Right),
        ("static", Align::Right),
    ]);
    let ticks = |n: &MembershipCount| format!("{} of {}", n.ticks_off, summary.steps);
    for (what, a, b) in [
        (
            "  changes of cell",
            sweep.changes.to_string(),
            derived.changes.to_string(),
        ),
        (
            "  flickers",
            sweep.flickers.to_string(),
            derived.flickers.to_string(),
        ),
        (
            "  changes through walls or floors",
            sweep.through_walls.to_string(),
            derived.through_walls.to_string(),
        ),
        (
            "  ticks in another cell than the sweep's",
            ticks(sweep),
            ticks(derived),
        ),
    ] {
        table.row([what.to_owned(), a, b]);
    }
    table.write(out)?;
    let dim = style::DIM;
    for d in summary.disagreements.iter().take(5) {
        let [x, y, z] = d.first_at;
        writeln!(
            out,
            "    {dim}{:>4} ticks in {} were {} to static, first at [{x:.2} {y:.2} {z:.2}]{dim:#}",
            d.ticks, d.cell, d.derived
        )?;
    }
    if summary.disagreements.len() > 5 {
        writeln!(
            out,
            "    {dim}... and {} more pairs (--json lists them){dim:#}",
            summary.disagreements.len() - 5
        )?;
    }
    Ok(())
}

fn print_seen(seen: &Seen, out: &mut impl Write) -> anyhow::Result<()> {
    let head = style::HEAD;
    writeln!(
        out,
        "{head}seen{head:#}         {} to {} rooms a tick, {} in the median, {} draw lists; the landscape in {} of {} ticks",
        seen.rooms_min, seen.rooms_max, seen.rooms_median, seen.lists, seen.with_outside, seen.ticks
    )?;
    writeln!(
        out,
        "{head}camera{head:#}       in another cell than the player for {} ticks, on the other side of a wall to outdoors \
         for {}, in none for {}",
        seen.viewer_elsewhere, seen.viewer_on_other_side, seen.viewer_lost
    )?;
    if seen.landscape_in_sealed > 0 {
        let bad = style::BAD;
        writeln!(
            out,
            "{bad}landscape drawn in sealed rooms: {} ticks{bad:#}",
            seen.landscape_in_sealed
        )?;
    }
    Ok(())
}

fn print_trials(trials: &[Trial], out: &mut impl Write) -> anyhow::Result<()> {
    if trials.is_empty() {
        return Ok(());
    }
    writeln!(out)?;
    let mut table = Table::new(&[
        ("", Align::Left),
        ("trial", Align::Left),
        ("expected", Align::Left),
        ("outcome", Align::Left),
        ("cell", Align::Left),
    ]);
    for trial in trials {
        let mark = match trial.passed {
            Some(true) => "ok",
            Some(false) => "NO",
            None => "-",
        };
        let cell = if trial.passed.is_none() {
            String::new()
        } else {
            trial.cell.clone()
        };
        table.row([
            mark.to_owned(),
            trial.trial.clone(),
            trial.expected.clone(),
            trial.outcome.clone(),
            cell,
        ]);
    }
    table.write(out)?;
    let tried = trials.iter().filter(|trial| trial.passed.is_some()).count();
    let good = trials.iter().filter(|trial| trial.passed == Some(true)).count();
    let style = if good == tried { style::GOOD } else { style::BAD };
    writeln!(out, "{style}trials: {good} of {tried} as expected{style:#}\n")?;
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
        super::write_whole(&path, svg.as_bytes())?;
        written.push(path);
    }
    Ok(written)
}

/// The filmstrip, and the film if one is wanted.
fn write_pictures(
    world: &World,
    guide: &Option<Guide>,
    record: &TourRecord,
    args: &Args,
) -> anyhow::Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    if record.eyes.is_empty() {
        return Ok(written);
    }
    let studio = Studio::new(world);
    let shown = film::thresholds(record).len().min(film::MAX_THRESHOLDS);
    if !args.no_pictures && shown > 0 {
        let progress = Mutex::new(Progress::new("pictures", shown as u64 * 3));
        let strip = film::strip(&studio, record, guide.as_ref(), &|done| advance(&progress, done))?;
        let path = args.out.join("filmstrip.png");
        super::render::write(&strip, &path)?;
        written.push(path);
    }
    if let Some(path) = &args.film {
        let count = film::film_ticks(record).len() as u64;
        let progress = Mutex::new(Progress::new("pictures of the film", count));
        let images = film::film(&studio, record, guide.as_ref(), args.film_size, &|done| {
            advance(&progress, done)
        })?;
        drop(progress);
        let mut bytes = Vec::new();
        write_apng(&images, film::FILM_DELAY_MS, &mut bytes)?;
        super::write_whole(path, &bytes)?;
        written.push(path.clone());
    }
    Ok(written)
}

fn advance(progress: &Mutex<Progress>, done: usize) {
    if let Ok(mut progress) = progress.lock() {
        progress.set(done as u64);
    }
}

fn write_trail_file(record: &TourRecord, path: &std::path::Path) -> anyhow::Result<()> {
    super::write_whole_by(path, |file| write_trail(record, file))
        .with_context(|| format!("cannot write {}", path.display()))
}
