//! `vestibule bench all`.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context as _;
use serde_json::json;
use vestibule::conform;
use vestibule::tour::{Tour, TourOptions};
use vestibule::world::World;
use vestibule_bench::figures::{self, Figure};

use super::{render, sweep, view};
use crate::cmd::gpu_cost::Costs;
use crate::ui::{Context, Spinner, open_dats, style};

/// Worlds of the vectors that have a walking workload.
const SWEEP_WORLDS: [&str; 3] = ["cottage-1", "dungeon-1", "maze-424"];
/// Steps of each workload.
const SWEEPS: u64 = 200_000;

/// Measure every figure that the project states, on this machine
///
/// The machine first; then opening, touring and drawing the embedded world, on the graphics card too where that is
/// built in; with --vectors sweeps, traversals and the
/// score on the vectors' worlds; last a world of retail size, which is built into a folder (180 MB), opened, walked,
/// streamed and filled with crowds. That takes minutes; --quick leaves it out.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule bench all --quick
  vestibule bench all --quick --json
  vestibule bench all --quick --vectors vectors

What was measured when, and how each figure is taken: docs/performance.md")]
pub(crate) struct Args {
    /// Leave out the world of retail size
    #[arg(long)]
    quick: bool,
    /// Folder of the vectors, for the figures that need them
    #[arg(long, value_name = "DIR")]
    vectors: Option<PathBuf>,
    /// Folder to build the world of retail size in; kept afterwards [default: a temporary one]
    #[arg(long, value_name = "DIR", conflicts_with = "quick")]
    folder: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    if let Some(vectors) = &args.vectors {
        // Before anything is measured.
        for world in SWEEP_WORLDS {
            super::vectors_world(vectors, world)?;
        }
    }
    let mut all: Vec<(&'static str, Figure)> = Vec::new();
    let mut group = "";
    {
        let json = context.json;
        let out = &mut context.out;
        let mut broken = None;
        let mut found = |name: &'static str, figure: Figure| {
            if !json && broken.is_none() {
                broken = print(out, &mut group, name, &figure).err();
            }
            all.push((name, figure));
        };
        machine(&mut found);
        embedded(&mut found)?;
        if let Some(vectors) = &args.vectors {
            with_vectors(vectors, &mut found)?;
        }
        if !args.quick {
            let temporary = std::env::temp_dir().join(format!("vestibule-bench-{}", std::process::id()));
            let folder = args.folder.as_ref().unwrap_or(&temporary);
            let spinner = Spinner::new("a world of retail size");
            let done = figures::all(folder, &mut |figure| {
                if figure.name != "machine" {
                    found("retail size", figure);
                }
            });
            drop(spinner);
            if args.folder.is_none() {
                let _ = std::fs::remove_dir_all(&temporary);
            }
            done.with_context(|| format!("the world of retail size in {}", folder.display()))?;
        }
        if let Some(error) = broken {
            return Err(error.into());
        }
    }
    if context.json {
        let rows: Vec<_> = all
            .iter()
            .map(|(group, f)| json!({ "group": group, "name": f.name, "value": f.value, "target": f.target }))
            .collect();
        return context.print_json(&json!({ "figures": rows }));
    }
    if cfg!(debug_assertions) {
        anstream::eprintln!(
            "{}warning{:#}: this is a debug build; time a release build",
            style::WARN,
            style::WARN
        );
    }
    Ok(())
}

fn print(
    out: &mut impl Write,
    group: &mut &'static str,
    name: &'static str,
    f: &Figure,
) -> std::io::Result<()> {
    if *group != name {
        let gap = if group.is_empty() { "" } else { "\n" };
        writeln!(out, "{gap}{}{name}{:#}", style::HEAD, style::HEAD)?;
        *group = name;
    }
    let target = f
        .target
        .map_or_else(String::new, |t| format!("  {}[{t}]{:#}", style::DIM, style::DIM));
    writeln!(out, "  {:<48}  {}{target}", f.name, f.value)?;
    out.flush()
}

fn figure(name: &str, value: String, target: Option<&'static str>) -> Figure {
    Figure {
        name: name.to_owned(),
        value,
        target,
    }
}

fn machine(found: &mut dyn FnMut(&'static str, Figure)) {
    let group = "machine";
    found(group, figure("processor", figures::machine(), None));
    let memory = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let total = memory.lines().find_map(|line| line.strip_prefix("MemTotal:"));
    let kib = total.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    if let Some(kib) = kib {
        found(
            group,
            figure("memory", format!("{:.1} GiB", kib / (1024.0 * 1024.0)), None),
        );
    }
    let system = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
    let system = format!(
        "{} {} {}",
        std::env::consts::OS,
        system.trim(),
        std::env::consts::ARCH
    );
    found(group, figure("system", system, None));
    let build = if cfg!(debug_assertions) {
        "debug"
    } else {
        "release"
    };
    found(
        group,
        figure(
            "build",
            format!("vestibule {} {build}", env!("CARGO_PKG_VERSION")),
            None,
        ),
    );
}

fn embedded(found: &mut dyn FnMut(&'static str, Figure)) -> anyhow::Result<()> {
    let group = "embedded world";
    let begun = Instant::now();
    let dats = open_dats(None)?;
    let world = World::open(dats.clone())?;
    let took = begun.elapsed().as_secs_f64() * 1e3;
    found(
        group,
        figure("compile its scene and open it", format!("{took:.0} ms"), None),
    );
    for (name, look) in [("tour", false), ("tour with the camera looking", true)] {
        let options = TourOptions {
            look,
            ..TourOptions::default()
        };
        let begun = Instant::now();
        let record = Tour::run(&world, &dats, options, &mut |_| {}, &mut |_| {})?;
        let seconds = begun.elapsed().as_secs_f64();
        let summary = &record.summary;
        let value = format!(
            "{} ticks in {seconds:.2} s, route planning included",
            summary.steps
        );
        found(group, figure(name, value, None));
        if let Some(seen) = &summary.seen {
            let value = format!(
                "{} to {}, median {}",
                seen.rooms_min, seen.rooms_max, seen.rooms_median
            );
            found(group, figure("rooms drawn a tick", value, None));
            let flickers = format!(
                "{} by the sweep, {} static",
                summary.by_sweep.flickers, summary.by_position.flickers
            );
            found(
                group,
                figure("flickers of the cell", flickers, Some("0 by the sweep")),
            );
            let off = format!("{} of {}", summary.by_position.ticks_off, summary.steps);
            found(
                group,
                figure("ticks that static puts into another cell", off, None),
            );
        }
    }
    let m = view::measure(dats.clone(), "it", 1000, 20, 1)?;
    found(
        group,
        figure(
            "traversal",
            format!("{:.2} us, {:.0} ns a cell", m.us_per_view, m.ns_per_cell),
            None,
        ),
    );
    for times in render::measure(dats.clone(), "it", (640, 480), 50, 1)? {
        let name = format!("640 x 480 on the processor, {}", times.group);
        let value = format!("{:.1} ms median, {:.1} ms most", times.median(), times.most());
        found(group, figure(&name, value, None));
    }
    match render::on_graphics(dats, "it", true, (1280, 720), 1)? {
        Ok(costs) => with_costs(&costs, found),
        Err(why) => found(group, figure("frames by the graphics card", why, None)),
    }
    Ok(())
}

fn with_costs(costs: &Costs, found: &mut dyn FnMut(&'static str, Figure)) {
    let group = "graphics card";
    let drawn = if costs.software { " in software" } else { "" };
    found(
        group,
        figure("adapter", format!("{}{drawn}", costs.adapter), None),
    );
    for v in &costs.views {
        let value = format!(
            "{:.2} ms of the processor, {} draws, {:.1} frames/s; everything {:.2} ms, {} draws, {:.1} frames/s",
            v.processor_ms,
            v.draws,
            v.frames_per_second,
            v.everything_ms,
            v.everything_draws,
            v.everything_frames_per_second
        );
        found(group, figure(&v.name, value, Some("0.5 ms")));
    }
}

fn with_vectors(
    vectors: &std::path::Path,
    found: &mut dyn FnMut(&'static str, Figure),
) -> anyhow::Result<()> {
    let group = "vectors";
    for world in SWEEP_WORLDS {
        let m = sweep::measure(vectors, world, SWEEPS)?;
        let each = m.seconds * 1e9 / m.totals.steps.max(1) as f64;
        let shares = format!(
            "{each:.0} ns, {:.2} % collided, {:.2} % changed cell",
            m.totals.collided_share() * 100.0,
            m.totals.changed_cell_share() * 100.0
        );
        found(group, figure(&format!("sweep, {world}"), shares, None));
    }
    let maze = open_dats(Some(&super::vectors_world(vectors, "maze-424")?))?;
    let m = view::measure(maze, "maze-424", 1000, 20, 1)?;
    let value = format!("{:.2} us, {:.0} ns a cell", m.us_per_view, m.ns_per_cell);
    found(group, figure("traversal, maze-424", value, Some("50 us")));
    let cases = conform::read_folder(vectors)?;
    let report = conform::run(vectors, &cases, &mut |_| {})?;
    let value = format!("{} of {}", report.agree(), report.counted());
    found(group, figure("cases that agree", value, Some("all")));
    Ok(())
}
