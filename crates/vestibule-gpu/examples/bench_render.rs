//! What a frame costs: deciding it, building and submitting it, and drawing it on the adapter at hand, by traversal and
//! without. `vestibule bench render` tells the same.
//!
//! `cargo run --release -p vestibule-gpu --example bench_render [-- --software --small --traversed VIEW]`: VIEW is
//! a part of the name of the views to time, `--traversed` leaves out what is drawn without a traversal.

use vestibule_gpu::{AdapterChoice, FrameTimer, Gpu, cost_views};
use vestibule_world::World;

/// What figures are stated for; the processor's share hardly depends on it.
const SIZE: (u32, u32) = (1280, 720);
/// With `--small`: an adapter that draws in software has little to do, and leaves caches and cores to what is timed.
const SMALL: (u32, u32) = (64, 36);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given = |name: &str| std::env::args().any(|a| a == name);
    let software = given("--software");
    let wanted = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    let ways: &[bool] = if given("--traversed") {
        &[true]
    } else {
        &[true, false]
    };
    let size = if given("--small") { SMALL } else { SIZE };
    let choice = if software {
        AdapterChoice::Software
    } else {
        AdapterChoice::Best
    };
    let gpu = Gpu::headless(choice)?;
    println!("{}, {} x {}", gpu.name(), size.0, size.1);
    let compiled = vestibule_forge::embedded_world()?;
    let world = World::open(compiled.memory_records())?;
    let mut timer = FrameTimer::new(&gpu, &world, size)?;
    let frames = if gpu.is_software() && size == SIZE {
        40
    } else {
        400
    };
    println!(
        "{:<20} {:>9} {:>9} {:>9} {:>7} {:>9} {:>9}   (medians)",
        "", "ms", "traversal", "submit", "draws", "triangles", "frames/s"
    );
    for (name, camera) in cost_views(size)? {
        if wanted.as_ref().is_some_and(|part| !name.contains(part.as_str())) {
            continue;
        }
        for &traversal in ways {
            let cost = timer.time(&camera, traversal, frames)?;
            println!(
                "{:<20} {:>9.3} {:>9.3} {:>9.3} {:>7} {:>9} {:>9.1}",
                if traversal { name } else { "  everything" },
                cost.processor_ms,
                cost.traversal_ms,
                cost.submit_ms,
                cost.stats.draws,
                cost.stats.triangles,
                cost.frames_per_second
            );
        }
    }
    let up = timer.renderer().uploaded();
    println!(
        "on the GPU: {} meshes, {} textures ({} KiB), {} landblocks",
        up.meshes,
        up.textures,
        up.texture_bytes / 1024,
        up.lands
    );
    Ok(())
}
