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
use crate::cmd::gpu::Graphics;
use crate::cmd::gpu_cost::Costs;
use crate::cmd::render::parse_size;
use crate::ui::{Align, Context, Progress, Table, style};

/// Time pictures: of the reference renderer on the processor, and what a frame costs on the graphics card
///
/// On the processor indoors from random eyes as `bench view` has them, outdoors from the place where visitors of the
/// embedded world begin, all around; each picture is drawn once to load what it needs, then timed. With the graphics card
/// the processor's time a frame, from the start of the traversal to the return of the submit, and frames a second, drawing
/// what the traversal reaches and drawing everything around. A program built without the window has no such figures.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule bench render
  vestibule bench render --cpu
  vestibule bench render --size 320x240 --eyes 20 --json")]
pub(crate) struct Args {
    /// Size of the pictures, pixels [default: 640x480, on the graphics card 1280x720]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Number of eyes indoors
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..))]
    eyes: usize,
    /// Seed of the eyes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Leave out the graphics card
    #[arg(long)]
    cpu: bool,
}

/// Size of pictures by the processor, and by the graphics card.
const SIZES: [(u32, u32); 2] = [(640, 480), (1280, 720)];
/// Eyes of a world that names no views.
const OTHER_EYES: usize = 4;

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
    let size = args.size.unwrap_or(SIZES[0]);
    let all = measure(context.dats()?, &name, size, args.eyes, args.seed)?;
    let (w, h) = size;
    let graphics = if args.cpu {
        Err("left out".to_owned())
    } else {
        let embedded = context.folder().is_none();
        let size = args.size.unwrap_or(SIZES[1]);
        on_graphics(context.dats()?, &name, embedded, size, args.seed)?
    };
    if context.json {
        let groups: Vec<_> = all
            .iter()
            .map(|t| json!({ "eyes": t.group, "pictures": t.count(), "median_ms": t.median(), "most_ms": t.most() }))
            .collect();
        return context.print_json(
            &json!({ "width": w, "height": h, "renderer": "cpu", "groups": groups,
            "gpu": graphics.as_ref().ok(), "no_gpu": graphics.as_ref().err() }),
        );
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
    match graphics {
        Ok(costs) => write_costs(out, &costs)?,
        Err(_) if args.cpu => {}
        Err(why) => writeln!(out, "\nno figures of the graphics card: {why}")?,
    }
    Ok(())
}

fn write_costs(out: &mut impl Write, costs: &Costs) -> std::io::Result<()> {
    let (head, (w, h)) = (style::HEAD, costs.size);
    let software = if costs.software {
        "; it draws in software, on the processor that is timed"
    } else {
        ""
    };
    writeln!(out, "\n{head}{w} x {h}{head:#} by {}{software}", costs.adapter)?;
    let mut table = Table::new(&[
        ("view", Align::Left),
        ("processor ms", Align::Right),
        ("traversal", Align::Right),
        ("submit", Align::Right),
        ("draws", Align::Right),
        ("frames/s", Align::Right),
        ("everything ms", Align::Right),
        ("draws", Align::Right),
        ("frames/s", Align::Right),
    ]);
    for v in &costs.views {
        let ms = |v: f64| format!("{v:.2}");
        let rate = |v: f64| format!("{v:.1}");
        table.row([
            v.name.clone(),
            ms(v.processor_ms),
            ms(v.traversal_ms),
            ms(v.submit_ms),
            v.draws.to_string(),
            rate(v.frames_per_second),
            ms(v.everything_ms),
            v.everything_draws.to_string(),
            rate(v.everything_frames_per_second),
        ]);
    }
    table.write(out)
}

/// What frames cost on the graphics card, or why that is not known.
pub(super) fn on_graphics(
    dats: Arc<DatSet>,
    name: &str,
    embedded: bool,
    size: (u32, u32),
    seed: u64,
) -> anyhow::Result<Result<Costs, String>> {
    let graphics = match Graphics::open() {
        Ok(graphics) => graphics,
        Err(why) => return Ok(Err(why)),
    };
    let (world, others) = if embedded {
        (World::open(dats)?, None)
    } else {
        let (world, cells) = cells_of(dats, name)?;
        let viewport = Vec2::new(size.0 as f32, size.1 as f32);
        let cameras = cameras(&world, &cells, OTHER_EYES, seed, viewport).into_iter();
        let named = (1..).zip(cameras).map(|(k, c)| (format!("room {k}"), c));
        (world, Some(named.collect()))
    };
    let mut progress = Progress::new("frames", OTHER_EYES as u64);
    let mut done = 0;
    let costs = graphics.costs(&world, size, others, &mut || {
        done += 1;
        progress.set(done);
    });
    // An adapter that fails has no figures.
    Ok(costs.map_err(|e| format!("{}: {e}", graphics.name())))
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
