//! `vestibule bench view`.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use glam::{Vec2, Vec3};
use serde_json::json;
use vestibule::view::{Camera, Openings, PView, retail_fov_y};
use vestibule::world::constants::FLOOR_Z;
use vestibule::world::{CellId, EnvCell, World};

use crate::ui::{Context, open_dats, style};

/// Time portal traversals from random eyes indoors
///
/// Eyes are 1.6 m above the middle of the floor of random cells and look in random directions over the ground. Each
/// traversal is a whole one, from the eye's cell to the complete draw list.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule bench view
  vestibule bench view --vectors vectors --world maze-424
  vestibule bench view --dat ~/ac --eyes 10000 --json")]
pub(crate) struct Args {
    /// Folder of the vectors
    #[arg(long, value_name = "DIR", requires = "world")]
    vectors: Option<PathBuf>,
    /// World of the vectors [default: as --dat]
    #[arg(long, value_name = "NAME", requires = "vectors")]
    world: Option<String>,
    /// Number of eyes
    #[arg(long, value_name = "N", default_value_t = 1000)]
    eyes: usize,
    /// Times that each is run
    #[arg(long, value_name = "N", default_value_t = 20)]
    rounds: u32,
    /// Seed of the eyes
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let dats = match (&args.vectors, &args.world) {
        (Some(vectors), Some(name)) => open_dats(Some(&vectors.join("worlds").join(name)))?,
        _ => context.dats()?,
    };
    let mut cells: Vec<CellId> = Vec::new();
    for entry in dats.cell().iter() {
        let id = CellId(entry?.id);
        if id.is_env_cell() {
            cells.push(id);
        }
    }
    let world = World::open(dats)?;
    cells.retain(|&id| world.env_cell(id).is_some_and(|cell| !cell.portals.is_empty()));
    anyhow::ensure!(
        !cells.is_empty(),
        "there are no env cells to look from in {}",
        context.world_name()
    );
    let mut random = Random(args.seed.max(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let viewport = Vec2::new(1280.0, 720.0);
    let fov = retail_fov_y(core::f32::consts::FRAC_PI_2, viewport.x / viewport.y);
    let cameras: Vec<Camera> = (0..args.eyes)
        .filter_map(|_| {
            let id = cells[(random.next() * cells.len() as f64) as usize % cells.len()];
            let eye = floor_middle(world.env_cell(id)?)? + Vec3::new(0.0, 0.0, 1.6);
            let yaw = (random.next() * core::f64::consts::TAU) as f32;
            let forward = Vec3::new(libm::cosf(yaw), libm::sinf(yaw), 0.0);
            Camera::new(id, eye, forward, Vec3::Z, fov, viewport).ok()
        })
        .collect();
    anyhow::ensure!(!cameras.is_empty(), "no eye could be placed");
    let openings = Openings::new();
    let mut pview = PView::default();
    // Once to load and to meet the largest result.
    let mut seen = 0usize;
    let mut most = 0usize;
    for camera in &cameras {
        let flood = pview.look(&world, &openings, camera);
        seen += flood.cells().len();
        most = most.max(flood.cells().len());
    }
    let started = Instant::now();
    let mut check = 0usize;
    for _ in 0..args.rounds.max(1) {
        for camera in &cameras {
            check += pview.look(&world, &openings, camera).cells().len();
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    let runs = cameras.len() as f64 * f64::from(args.rounds.max(1));
    anyhow::ensure!(
        check == seen * args.rounds.max(1) as usize,
        "traversals of the same eye differ"
    );
    let (per_view, per_cell) = (seconds * 1e6 / runs, seconds * 1e9 / check.max(1) as f64);
    let mean = seen as f64 / cameras.len() as f64;
    if context.json {
        return context.print_json(&json!({
            "eyes": cameras.len(), "rounds": args.rounds.max(1), "us_per_traversal": per_view, "ns_per_cell": per_cell,
            "cells_seen": mean, "most_cells": most, "env_cells": cells.len(),
        }));
    }
    let head = style::HEAD;
    let out = &mut context.out;
    writeln!(
        out,
        "{head}{} eyes{head:#} in a world of {} env cells",
        cameras.len(),
        cells.len()
    )?;
    writeln!(out, "us per traversal  {per_view:.2}")?;
    writeln!(out, "ns per cell seen  {per_cell:.0}")?;
    writeln!(out, "cells seen        {mean:.1} on average, {most} at most")?;
    Ok(())
}

/// The middle of the largest floor of a cell, in the frame of its landblock.
fn floor_middle(cell: &EnvCell) -> Option<Vec3> {
    let polygons = &cell.structure.polygons;
    let floors = polygons.polygons().iter().filter(|polygon| {
        let portal = cell.structure.portal_polygons.contains(&polygon.id);
        !portal && cell.frame.local_to_global_vec(polygon.plane.normal).z >= FLOOR_Z
    });
    let area = |vertices: &[Vec3]| match vertices {
        [first, rest @ ..] => rest
            .windows(2)
            .map(|pair| (pair[0] - *first).cross(pair[1] - *first))
            .sum::<Vec3>()
            .length(),
        [] => 0.0,
    };
    let largest = floors
        .map(|polygon| polygons.vertices(polygon))
        .max_by(|a, b| area(a).total_cmp(&area(b)))?;
    let middle = largest.iter().copied().sum::<Vec3>() / largest.len().max(1) as f32;
    Some(cell.frame.local_to_global(middle))
}

/// 64-bit xorshift, as in the walking workload.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}
