//! Prints every figure of `docs/performance.md`: `cargo run --release -p vestibule-bench -- FOLDER`. The folder
//! receives a world of retail size (180 MB).

use std::path::PathBuf;

fn main() -> Result<(), vestibule_bench::figures::BenchError> {
    let folder = std::env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from("retail-size"), PathBuf::from);
    vestibule_bench::figures::all(&folder, &mut |figure| {
        let target = figure.target.map(|t| format!("  [{t}]")).unwrap_or_default();
        println!("{}: {}{target}", figure.name, figure.value);
    })
}
