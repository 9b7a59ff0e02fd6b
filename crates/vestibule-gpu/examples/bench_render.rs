//! What a frame costs: deciding it, building and submitting it, and drawing it on the adapter at hand, by traversal and
//! without.
//!
//! `cargo run --release -p vestibule-gpu --example bench_render [-- --software]`

use std::time::Instant;

use glam::{Vec2, Vec3};
use vestibule_gpu::{AdapterChoice, Gpu, Picture, Renderer, RendererOptions, wgpu};
use vestibule_physics::ObjectRef;
use vestibule_render::{Assets, RenderSettings, Scene};
use vestibule_view::{Camera, Command, FrameInput, FrameView, LightSet, Openings, Views, WorldObjects};
use vestibule_world::{BlockId, CellId, StaticRef, World};

const SIZE: (u32, u32) = (1280, 720);

/// Everything in the nine landblocks around one, in the form of commands.
fn everything(world: &World, centre: BlockId) -> Vec<Command> {
    let views = Views::Landscape;
    let mut out = vec![Command::Light(LightSet::Sun), Command::Sky];
    let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy)));
    let blocks: Vec<_> = around
        .filter_map(|(dx, dy)| world.block(centre.neighbour(dx, dy)?))
        .collect();
    for block in &blocks {
        out.extend(block.land_cells().map(|(id, _)| Command::Terrain(id)));
        for (k, b) in block.buildings.iter().enumerate() {
            if let Some(part) = b.shape.parts.first().filter(|p| p.model.is_some()) {
                out.push(Command::Building {
                    block: block.id,
                    building: k as u32,
                    model: part.model_id,
                });
            }
        }
    }
    out.push(Command::Light(LightSet::Indoor));
    for block in &blocks {
        out.extend(block.env_cells().map(|c| Command::Room { cell: c.id, views }));
        out.extend(
            block
                .statics
                .iter()
                .enumerate()
                .map(|(k, object)| Command::Object {
                    id: ObjectRef::Static(StaticRef {
                        block: block.id,
                        index: k as u32,
                    }),
                    cell: object.cell,
                    views,
                }),
        );
    }
    out.push(Command::FlushAlpha);
    out
}

/// Seconds this thread has computed, which other programs do not change; by the clock where that is not told.
fn computed(start: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|t| t.split_whitespace().next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |n| n * 1e-9)
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// What threads have computed is told in coarse steps: only the mean of many frames means something.
fn mean(times: &[f64]) -> f64 {
    times.iter().sum::<f64>() / times.len().max(1) as f64
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let software = std::env::args().any(|a| a == "--software");
    let choice = if software {
        AdapterChoice::Software
    } else {
        AdapterChoice::Best
    };
    let gpu = Gpu::headless(choice)?;
    let start = Instant::now();
    println!("{}, {} x {}", gpu.name(), SIZE.0, SIZE.1);
    let compiled = vestibule_forge::embedded_world()?;
    let world = World::open(compiled.memory_records())?;
    let (openings, assets) = (Openings::new(), Assets::new());
    let scene = Scene::new(&world, &assets);
    let mut renderer = Renderer::new(&gpu, RendererOptions::default());
    let target = renderer.target(&gpu, SIZE.0, SIZE.1)?;
    let settings = RenderSettings::default();
    let size = Vec2::new(SIZE.0 as f32, SIZE.1 as f32);
    let places = [
        (
            "before the cottage",
            0xA9B4_0031,
            [155.4, 24.0, 95.6],
            [155.4, 12.0, 95.2],
        ),
        (
            "over the village",
            0xA9B4_0029,
            [130.0, 20.0, 104.0],
            [110.0, 90.0, 94.0],
        ),
        (
            "in the cottage",
            0xA9B4_0101,
            [155.4, 11.0, 95.6],
            [155.4, 30.0, 95.4],
        ),
        (
            "in the shop",
            0xA9B4_010E,
            [109.5, 82.5, 93.9],
            [103.0, 84.2, 94.6],
        ),
    ];
    println!(
        "{:<20} {:>9} {:>10} {:>7} {:>9} {:>9}   (means; frames/s by the median)",
        "", "decide ms", "submit ms", "draws", "triangles", "frames/s"
    );
    for (name, cell, eye, at) in places {
        let (eye, at) = (Vec3::from_array(eye), Vec3::from_array(at));
        let camera = Camera::new(CellId(cell), eye, at - eye, Vec3::Z, 0.94, size)?;
        let mut frame = FrameView::default();
        let all = everything(&world, CellId(cell).block());
        for traversal in [true, false] {
            let (mut decide, mut submit, mut whole) = (Vec::new(), Vec::new(), Vec::new());
            let mut stats = Default::default();
            for k in 0..if gpu.is_software() { 25 } else { 110 } {
                let (begin, at_first) = (Instant::now(), computed(start));
                let objects = WorldObjects::new(&world);
                frame.update(&world, &openings, &objects, &FrameInput::new(camera));
                let decided = computed(start) - at_first;
                let picture = if traversal {
                    Picture::of(&frame).ok_or("no camera")?
                } else {
                    Picture {
                        camera: &camera,
                        commands: &all,
                        frame: None,
                        sealed: false,
                    }
                };
                stats = renderer.draw(&gpu, &target, &scene, &picture, &settings)?;
                let submitted = computed(start) - at_first;
                gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
                // The first frames upload.
                if k >= 5 {
                    decide.push(decided);
                    submit.push(submitted - decided);
                    whole.push(begin.elapsed().as_secs_f64());
                }
            }
            let what = if traversal { name } else { "  everything" };
            let decided = if traversal {
                format!("{:.3}", mean(&decide) * 1e3)
            } else {
                "-".to_owned()
            };
            println!(
                "{what:<20} {decided:>9} {:>10.3} {:>7} {:>9} {:>9.1}",
                mean(&submit) * 1e3,
                stats.draws,
                stats.triangles,
                1.0 / median(whole)
            );
        }
    }
    let up = renderer.uploaded();
    println!(
        "on the GPU: {} meshes, {} textures ({} KiB), {} landblocks",
        up.meshes,
        up.textures,
        up.texture_bytes / 1024,
        up.lands
    );
    Ok(())
}
