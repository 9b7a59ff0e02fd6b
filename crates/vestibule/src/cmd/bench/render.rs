//! `vestibule bench render`.

use std::io::Write;
use std::sync::Arc;
use std::time::Instant;

use glam::{Vec2, Vec3};
use serde_json::json;
use vestibule::dat::DatSet;
use vestibule::studio::Studio;
use vestibule::tour::Guide;
use vestibule::view::{Camera, retail_fov_y};
use vestibule::world::World;

use super::view::{cameras, cells_of};
use crate::cmd::render::parse_size;
use crate::ui::{Align, Context, Progress, Table, style};

/// Time pictures of the reference renderer, on one thread
///
/// Indoors from random eyes as `bench view` has them, outdoors from the place where visitors of the embedded world
/// begin, all around. Each picture is drawn once to load what it needs, then timed.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule bench render
  vestibule bench render --size 320x240 --eyes 20 --json")]
pub(crate) struct Args {
    /// Size of the pictures, pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "640x480")]
    size: (u32, u32),
    /// Number of eyes indoors
    #[arg(long, value_name = "N", default_value_t = 50)]
    eyes: usize,
    /// Seed of the eyes
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Times of a group of pictures, milliseconds, in order.
pub(super) struct Times {
    pub(super) group: &'static str,
    sorted: Vec<f64>,
}

impl Times {
    pub(super) fn median(&self) -> f64 {
        self.sorted.get(self.sorted.len() / 2).copied().unwrap_or(0.0)
    }

    pub(super) fn most(&self) -> f64 {
        self.sorted.last().copied().unwrap_or(0.0)
    }

    pub(super) fn count(&self) -> usize {
        self.sorted.len()
    }
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let name = context.world_name();
    let all = measure(context.dats()?, &name, args.size, args.eyes, args.seed)?;
    let (w, h) = args.size;
    if context.json {
        let groups: Vec<_> = all
            .iter()
            .map(|t| json!({ "eyes": t.group, "pictures": t.count(), "median_ms": t.median(), "most_ms": t.most() }))
            .collect();
        return context.print_json(&json!({ "width": w, "height": h, "renderer": "cpu", "groups": groups }));
    }
    let out = &mut context.out;
    writeln!(
        out,
        "{}{w} x {h}{:#} on the processor, one thread, {name}",
        style::HEAD,
        style::HEAD
    )?;
    let mut table = Table::new(&[
        ("eyes", Align::Left),
        ("pictures", Align::Right),
        ("median ms", Align::Right),
        ("most ms", Align::Right),
    ]);
    for t in &all {
        let ms = |v: f64| format!("{v:.1}");
        table.row([
            t.group.to_owned(),
            t.count().to_string(),
            ms(t.median()),
            ms(t.most()),
        ]);
    }
    table.write(out)?;
    Ok(())
}

/// Times pictures indoors, and outdoors where a place for that is known.
pub(super) fn measure(
    dats: Arc<DatSet>,
    name: &str,
    size: (u32, u32),
    eyes: usize,
    seed: u64,
) -> anyhow::Result<Vec<Times>> {
    let guide = Guide::of(&dats);
    let (world, cells) = cells_of(dats, name)?;
    let viewport = Vec2::new(size.0 as f32, size.1 as f32);
    let mut groups = vec![("indoors", cameras(&world, &cells, eyes, seed, viewport))];
    if let Some(start) = guide.and_then(|guide| guide.start) {
        let fov = retail_fov_y(core::f32::consts::FRAC_PI_2, viewport.x / viewport.y);
        let eye = start.origin() + Vec3::new(0.0, 0.0, 1.6);
        let around = (0..8).filter_map(|k| {
            let (sin, cos) = libm::sincosf(k as f32 * core::f32::consts::FRAC_PI_4);
            Camera::new(start.cell, eye, Vec3::new(cos, sin, 0.0), Vec3::Z, fov, viewport).ok()
        });
        groups.push(("outdoors", around.collect()));
    }
    let count = groups.iter().map(|(_, cameras)| cameras.len() as u64).sum();
    let mut progress = Progress::new("pictures", count);
    let mut done = 0;
    let mut out = Vec::new();
    for (group, cameras) in groups {
        out.push(time(&world, group, &cameras, &mut || {
            done += 1;
            progress.set(done);
        })?);
    }
    Ok(out)
}

fn time(
    world: &World,
    group: &'static str,
    cameras: &[Camera],
    done: &mut dyn FnMut(),
) -> anyhow::Result<Times> {
    let studio = Studio::new(world);
    let mut sorted = Vec::with_capacity(cameras.len());
    for &camera in cameras {
        studio.picture(&studio.shot(camera))?;
        let started = Instant::now();
        studio.picture(&studio.shot(camera))?;
        sorted.push(started.elapsed().as_secs_f64() * 1e3);
        done();
    }
    sorted.sort_by(f64::total_cmp);
    Ok(Times { group, sorted })
}
