//! Compiles a folder of scene files, or one file, and reports; with a second argument writes the DAT files there.

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let scene = args.next().ok_or("usage: build_scene SCENE [OUT]")?;
    let started = std::time::Instant::now();
    let world = vestibule_forge::compile_scene_path(&scene)?;
    println!(
        "{}: {:?} in {:.1} ms",
        world.name,
        world.stats,
        started.elapsed().as_secs_f64() * 1e3
    );
    for warning in &world.warnings {
        println!("{warning}");
    }
    if let Some(out) = args.next() {
        world.write_to(&out)?;
    }
    Ok(())
}
