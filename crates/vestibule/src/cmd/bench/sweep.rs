//! `vestibule bench sweep`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use serde_json::json;
use vestibule::conform::BodyInput;
use vestibule::physics::workload::{Workload, WorkloadBody, WorkloadTotals};
use vestibule::world::World;

use crate::ui::{Context, open_dats, style};

/// Time sweeps on the walking workload of the vectors
///
/// Makes exactly N steps of the closed loop that bench/README.md of the vectors describes, once, and prints sweeps per
/// second, nanoseconds per sweep, and the shares of steps that collided and that changed cell.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule bench sweep --vectors vectors --world cottage-1
  vestibule bench sweep --vectors vectors --world maze-424 -n 1000000 --json")]
pub(crate) struct Args {
    /// Folder of the vectors
    #[arg(long, value_name = "DIR")]
    vectors: PathBuf,
    /// World and file of starting bodies
    #[arg(long, value_name = "NAME")]
    world: String,
    /// Steps; the workload's expected shares are those of 25,000
    #[arg(short, value_name = "N", default_value_t = 25_000, value_parser = clap::value_parser!(u64).range(1..))]
    n: u64,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let measured = measure(&args.vectors, &args.world, args.n)?;
    let Measured { totals, seconds } = &measured;
    let steps = totals.steps.max(1) as f64;
    let (per_second, nanoseconds) = (steps / seconds.max(1e-9), seconds * 1e9 / steps);
    if context.json {
        return context.print_json(&json!({
            "world": args.world, "steps": totals.steps, "sweeps_per_second": per_second, "ns_per_sweep": nanoseconds,
            "collided": totals.collided_share(), "changed_cell": totals.changed_cell_share(),
            "checksum": totals.checksum,
        }));
    }
    let head = style::HEAD;
    let out = &mut context.out;
    writeln!(out, "{head}{}{head:#}, {} steps", args.world, totals.steps)?;
    writeln!(out, "sweeps per second  {per_second:.0}")?;
    writeln!(out, "ns per sweep       {nanoseconds:.0}")?;
    writeln!(out, "share collided     {:.4}", totals.collided_share())?;
    writeln!(out, "share changed cell {:.4}", totals.changed_cell_share())?;
    Ok(())
}

/// What sweeps took.
pub(super) struct Measured {
    pub(super) totals: WorkloadTotals,
    pub(super) seconds: f64,
}

/// Times `n` sweeps of the workload on a world of the vectors.
pub(super) fn measure(vectors: &Path, name: &str, n: u64) -> anyhow::Result<Measured> {
    let world = World::open(open_dats(Some(&super::vectors_world(vectors, name)?))?)?;
    let bodies = read_bodies(&vectors.join("bench").join(format!("{name}.jsonl")))?;
    let mut workload = Workload::new(&world, bodies);
    let started = Instant::now();
    workload.run(n)?;
    Ok(Measured {
        totals: workload.totals(),
        seconds: started.elapsed().as_secs_f64(),
    })
}

fn read_bodies(path: &Path) -> anyhow::Result<Vec<WorkloadBody>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    (1..)
        .zip(text.lines())
        .filter(|(_, text)| !text.trim().is_empty())
        .map(|(line, text)| {
            let place = || format!("line {line} of {}", path.display());
            let body: BodyInput = serde_json::from_str(text).with_context(place)?;
            let mover = body.mover().with_context(place)?;
            Ok(WorkloadBody {
                mover,
                start: body.start(),
                carried: body.carried(),
            })
        })
        .collect()
}
