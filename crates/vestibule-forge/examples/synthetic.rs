//! Builds a synthetic world of retail size: `cargo run --release --example synthetic -- OUT [SEED]`.

use vestibule_forge::synthetic::SyntheticWorld;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().ok_or("usage: synthetic OUT [SEED]")?;
    let seed = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let begun = std::time::Instant::now();
    let report = SyntheticWorld::retail(seed).build(&out, &mut |progress| {
        if progress.done % 5_000 == 0 {
            eprintln!("{} of {} landblocks", progress.done, progress.all);
        }
    })?;
    let (dungeons, towns) = (report.dungeons.len(), report.towns.len());
    let first = report.dungeons.first();
    println!("built in {:.1} s", begun.elapsed().as_secs_f64());
    println!("{dungeons} dungeons, the largest {first:?}; {towns} landblocks with buildings");
    println!(
        "{:?}",
        vestibule_forge::synthetic::SyntheticReport {
            dungeons: Vec::new(),
            towns: Vec::new(),
            ..report
        }
    );
    Ok(())
}
