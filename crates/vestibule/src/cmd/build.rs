//! `vestibule build`: a scene, or a number, to DAT files.

mod synthetic;

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use serde_json::json;
use vestibule::forge::{Diagnostic, SceneError, Severity, compile_scene_path};

use crate::ui::{Context, Failed, Spinner, Usage, hinted, style};

/// Compile a scene to DAT files, or make a large world from a number
///
/// SCENE is a .scene file, or a folder of them that are read in the order of their names. With --synthetic the world
/// follows from --seed instead, as large as retail's, to try things out at full size. Every other command can then open
/// the result with --dat.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule build crates/vestibule-forge/worlds/hollow --out hollow
  vestibule tour --dat hollow
  vestibule build room.scene --check
  vestibule build --synthetic small --seed 7 --out plain

The same scene, or the same seed, always gives the same bytes. --synthetic retail takes 180 MB and a minute or less.")]
pub(crate) struct Args {
    /// Scene file, or folder of scene files
    #[arg(required_unless_present = "synthetic", conflicts_with = "synthetic")]
    scene: Option<PathBuf>,
    /// Make a world from a number instead
    #[arg(long, value_name = "SIZE", value_enum, conflicts_with = "check")]
    synthetic: Option<synthetic::Size>,
    /// The number a synthetic world follows from [default: 1]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Folder to write client_portal.dat and client_cell_1.dat to
    #[arg(short, long, value_name = "DIR", required_unless_present = "check")]
    out: Option<PathBuf>,
    /// Only check the scene, write nothing
    #[arg(long)]
    check: bool,
}

/// A message of the compiler, for machines.
fn message(diagnostic: &Diagnostic) -> serde_json::Value {
    let severity = match diagnostic.severity {
        Severity::Warning => "warning",
        Severity::Error => "error",
    };
    json!({
        "severity": severity, "file": diagnostic.file, "line": diagnostic.line, "column": diagnostic.column,
        "message": diagnostic.message, "help": diagnostic.help,
    })
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    if let (Some(size), Some(out)) = (args.synthetic, &args.out) {
        return synthetic::run(size, args.seed.unwrap_or(1), out, context);
    }
    if args.seed.is_some() {
        return Err(Usage("--seed goes with --synthetic; a scene says everything itself".to_owned()).into());
    }
    let Some(scene) = &args.scene else {
        return Err(Usage("build takes a scene, or --synthetic and --out".to_owned()).into());
    };
    let started = Instant::now();
    let spinner = Spinner::new("compiling");
    let compiled = compile_scene_path(scene);
    drop(spinner);
    let world = match compiled {
        Ok(world) => world,
        Err(SceneError::Scene(diagnostics)) => {
            if context.json {
                let messages: Vec<_> = diagnostics.0.iter().map(message).collect();
                context.print_json(&json!({ "messages": messages }))?;
            } else {
                // What is wrong and how to mend it, with file and line.
                anstream::eprintln!("{diagnostics}");
            }
            return Err(Failed.into());
        }
        Err(error) => return Err(hinted(error, "build takes a .scene file or a folder of them")),
    };
    let took = started.elapsed().as_secs_f64() * 1e3;
    if let Some(out) = args.out.as_ref().filter(|_| !args.check) {
        world.write_to(out)?;
    }
    let stats = &world.stats;
    if context.json {
        let warnings: Vec<String> = world.warnings.iter().map(ToString::to_string).collect();
        return context.print_json(&json!({
            "name": world.name, "landblocks": stats.landblocks, "cells": stats.cells, "structures": stats.structures,
            "buildings": stats.buildings, "statics": stats.statics, "records": world.portal.len() + world.cell.len(),
            "milliseconds": took, "warnings": warnings, "out": args.out.as_ref().filter(|_| !args.check),
        }));
    }
    for warning in &world.warnings {
        anstream::eprintln!("{}{warning}{:#}", style::WARN, style::WARN);
    }
    let out = &mut context.out;
    writeln!(
        out,
        "{}: {} landblocks, {} env cells of {} structures, {} buildings, {} static objects; compiled in {took:.0} ms",
        world.name, stats.landblocks, stats.cells, stats.structures, stats.buildings, stats.statics
    )?;
    if let Some(folder) = args.out.as_ref().filter(|_| !args.check) {
        writeln!(
            out,
            "written {} records to {}",
            world.portal.len() + world.cell.len(),
            folder.display()
        )?;
    }
    Ok(())
}
