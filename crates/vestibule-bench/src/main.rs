//! Prints every figure of `docs/performance.md`: `cargo run --release -p vestibule-bench -- FOLDER`. The folder
//! receives a world of retail size (180 MB). `crowds` or `streaming` as the second argument: the figures of that only.

use std::path::PathBuf;

fn main() -> Result<(), vestibule_bench::figures::BenchError> {
    let folder = std::env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from("retail-size"), PathBuf::from);
    let part = std::env::args().nth(2);
    let mut print = |figure: vestibule_bench::figures::Figure| {
        let target = figure.target.map(|t| format!("  [{t}]")).unwrap_or_default();
        println!("{}: {}{target}", figure.name, figure.value);
    };
    match part.as_deref() {
        Some("crowds") => vestibule_bench::figures::only_crowds(&folder, &mut print),
        Some("streaming") => vestibule_bench::figures::only_streaming(&folder, &mut print),
        _ => vestibule_bench::figures::all(&folder, &mut print),
    }
}
