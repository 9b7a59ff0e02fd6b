//! `vestibule conform`: runs test vectors.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Context as _;
use serde_json::json;
use vestibule::conform::{self, Report};

use crate::ui::{Context, Failed, Progress, Usage, hinted, style};

/// Run test vectors and compare with what they expect
///
/// DIR holds *.jsonl files of cases and worlds/NAME/ with the DAT files they run on. Cases marked sensitive or suspect
/// are run and counted as flagged, but do not decide.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule conform vectors
  vestibule conform vectors --op find_cell_list --op terrain_z
  vestibule conform vectors --world cottage-1 --json

Exit code 0 only if no case differs.")]
pub(crate) struct Args {
    /// Folder of the vectors
    dir: PathBuf,
    /// Run only this operation (repeatable)
    #[arg(long, value_name = "OP")]
    op: Vec<String>,
    /// Run only cases of this world (repeatable)
    #[arg(long, value_name = "NAME")]
    world: Vec<String>,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let hint = "conform takes a folder of *.jsonl files with a folder worlds/ beside them";
    let mut cases = conform::read_folder(&args.dir).map_err(|e| hinted(e, hint))?;
    if cases.is_empty() {
        return Err(hinted(
            anyhow::anyhow!("there are no cases in {}", args.dir.display()),
            hint,
        ));
    }
    for op in &args.op {
        if !cases.iter().any(|case| case.op == *op) && !conform::supported_ops().any(|known| known == op) {
            let known: Vec<_> = conform::supported_ops().collect();
            let text = format!("no case has operation '{op}'; supported are {}", known.join(", "));
            return Err(Usage(text).into());
        }
    }
    for world in &args.world {
        if !cases.iter().any(|case| case.world == *world) {
            let known: std::collections::BTreeSet<&str> =
                cases.iter().map(|case| case.world.as_str()).collect();
            let known = known.into_iter().collect::<Vec<_>>().join(", ");
            return Err(Usage(format!("no case is about a world '{world}'; there are {known}")).into());
        }
    }
    cases.retain(|case| {
        (args.op.is_empty() || args.op.contains(&case.op))
            && (args.world.is_empty() || args.world.contains(&case.world))
    });
    anyhow::ensure!(
        !cases.is_empty(),
        "no case has both that operation and that world"
    );
    let mut progress = Progress::new("cases", cases.len() as u64);
    let report = conform::run(&args.dir, &cases, &mut |done| progress.set(done)).context("conform")?;
    drop(progress);
    if context.json {
        context.print_json(&json!({
            "ops": report.ops, "agree": report.agree(), "differ": report.differ(), "counted": report.counted(),
        }))?;
    } else {
        print(&report, context)?;
    }
    if report.differ() > 0 {
        Err(Failed.into())
    } else {
        Ok(())
    }
}

fn print(report: &Report, context: &mut Context) -> anyhow::Result<()> {
    let out = &mut context.out;
    for op in report.ops.iter().filter(|op| op.unsupported == 0) {
        writeln!(
            out,
            "{}: {} agree, {} differ, {} flagged",
            op.op, op.agree, op.differ, op.flagged
        )?;
    }
    for op in report.ops.iter().filter(|op| op.unsupported > 0) {
        let dim = style::DIM;
        writeln!(
            out,
            "{dim}{}: not supported, {} cases not counted{dim:#}",
            op.op, op.unsupported
        )?;
    }
    for op in &report.ops {
        for difference in &op.differences {
            let bad = style::BAD;
            writeln!(
                out,
                "\n{bad}{}{bad:#} on {} ({})",
                difference.id,
                difference.world,
                difference.tags.join(", ")
            )?;
            writeln!(out, "  in: {}", difference.input)?;
            for field in &difference.fields {
                writeln!(out, "  {}:", field.field)?;
                writeln!(out, "    expected {}", field.expected)?;
                writeln!(out, "    actual   {}", field.actual)?;
            }
        }
        let unseen = op.differ.saturating_sub(op.differences.len() as u64);
        if unseen > 0 {
            writeln!(out, "\n... and {unseen} more of {}", op.op)?;
        }
    }
    let style = if report.differ() == 0 {
        style::GOOD
    } else {
        style::BAD
    };
    writeln!(
        out,
        "{style}conform: {} of {} agree{style:#}",
        report.agree(),
        report.counted()
    )?;
    Ok(())
}
