//! `vestibule build`: a scene to DAT files.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use serde_json::json;
use vestibule::forge::{SceneError, compile_scene_path};

use crate::ui::{Context, Failed, Spinner, hinted, style};

/// Compile a scene to DAT files
///
/// SCENE is a .scene file, or a folder of them that are read in the order of their names. Every other command can then
/// open the result with --dat.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule build worlds/hollow --out hollow
  vestibule tour --dat hollow
  vestibule build room.scene --check

The same scene always gives the same bytes.")]
pub(crate) struct Args {
    /// Scene file, or folder of scene files
    scene: PathBuf,
    /// Folder to write client_portal.dat and client_cell_1.dat to
    #[arg(short, long, value_name = "DIR", required_unless_present = "check")]
    out: Option<PathBuf>,
    /// Only check the scene, write nothing
    #[arg(long)]
    check: bool,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let started = Instant::now();
    let spinner = Spinner::new("compiling");
    let compiled = compile_scene_path(&args.scene);
    drop(spinner);
    let world = match compiled {
        Ok(world) => world,
        Err(SceneError::Scene(diagnostics)) => {
            // What is wrong and how to mend it, with file and line.
            anstream::eprintln!("{diagnostics}");
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
