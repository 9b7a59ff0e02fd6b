//! `vestibule bench view`.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use glam::{Vec2, Vec3};
use serde_json::json;
use vestibule::dat::DatSet;
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
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..))]
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
        (Some(vectors), Some(name)) => open_dats(Some(&super::vectors_world(vectors, name)?))?,
        _ => context.dats()?,
    };
    let measured = measure(dats, &context.world_name(), args.eyes, args.rounds, args.seed)?;
    if context.json {
        return context.print_json(&json!({
            "eyes": measured.eyes, "rounds": args.rounds.max(1), "us_per_traversal": measured.us_per_view,
            "ns_per_cell": measured.ns_per_cell, "cells_seen": measured.mean, "most_cells": measured.most,
            "env_cells": measured.env_cells,
        }));
    }
    let head = style::HEAD;
    let out = &mut context.out;
    writeln!(
        out,
        "{head}{} eyes{head:#} in a world of {} env cells",
        measured.eyes, measured.env_cells
    )?;
    writeln!(out, "us per traversal  {:.2}", measured.us_per_view)?;
    writeln!(out, "ns per cell seen  {:.0}", measured.ns_per_cell)?;
    writeln!(
        out,
        "cells seen        {:.1} on average, {} at most",
        measured.mean, measured.most
    )?;
    Ok(())
}

/// What traversals took.
pub(super) struct Measured {
    pub(super) eyes: usize,
    pub(super) env_cells: usize,
    pub(super) us_per_view: f64,
    pub(super) ns_per_cell: f64,
    pub(super) mean: f64,
    pub(super) most: usize,
}

/// Times traversals from random eyes.
pub(super) fn measure(
    dats: Arc<DatSet>,
    name: &str,
    eyes: usize,
    rounds: u32,
    seed: u64,
) -> anyhow::Result<Measured> {
    let (world, cells) = cells_of(dats, name)?;
    let cameras = cameras(&world, &cells, eyes, seed, Vec2::new(1280.0, 720.0));
    anyhow::ensure!(!cameras.is_empty(), "no eye could be placed");
    let openings = Openings::new();
    let mut pview = PView::default();
    // Once to load and to meet the largest result.
    let (mut seen, mut most) = (0usize, 0usize);
    for camera in &cameras {
        let flood = pview.look(&world, &openings, camera);
        seen += flood.cells().len();
        most = most.max(flood.cells().len());
    }
    let started = Instant::now();
    let mut check = 0usize;
    for _ in 0..rounds.max(1) {
        for camera in &cameras {
            check += pview.look(&world, &openings, camera).cells().len();
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    let runs = cameras.len() as f64 * f64::from(rounds.max(1));
    anyhow::ensure!(
        check == seen * rounds.max(1) as usize,
        "traversals of the same eye differ"
    );
    Ok(Measured {
        eyes: cameras.len(),
        env_cells: cells.len(),
        us_per_view: seconds * 1e6 / runs,
        ns_per_cell: seconds * 1e9 / check.max(1) as f64,
        mean: seen as f64 / cameras.len() as f64,
        most,
    })
}

/// A world and its env cells that have portals.
pub(super) fn cells_of(dats: Arc<DatSet>, name: &str) -> anyhow::Result<(World, Vec<CellId>)> {
    let mut cells: Vec<CellId> = Vec::new();
    for entry in dats.cell().iter() {
        let id = CellId(entry?.id);
        if id.is_env_cell() {
            cells.push(id);
        }
    }
    let world = World::open(dats)?;
    cells.retain(|&id| world.env_cell(id).is_some_and(|cell| !cell.portals.is_empty()));
    anyhow::ensure!(!cells.is_empty(), "there are no env cells to look from in {name}");
    Ok((world, cells))
}

/// Eyes 1.6 m above the floors of random cells, looking anywhere over the ground.
pub(super) fn cameras(
    world: &World,
    cells: &[CellId],
    eyes: usize,
    seed: u64,
    viewport: Vec2,
) -> Vec<Camera> {
    let mut random = Random(seed.max(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let fov = retail_fov_y(core::f32::consts::FRAC_PI_2, viewport.x / viewport.y);
    (0..eyes)
        .filter_map(|_| {
            let id = *cells.get((random.next() * cells.len() as f64) as usize % cells.len().max(1))?;
            let eye = floor_middle(world.env_cell(id)?)? + Vec3::new(0.0, 0.0, 1.6);
            let yaw = (random.next() * core::f64::consts::TAU) as f32;
            let forward = Vec3::new(libm::cosf(yaw), libm::sinf(yaw), 0.0);
            Camera::new(id, eye, forward, Vec3::Z, fov, viewport).ok()
        })
        .collect()
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
