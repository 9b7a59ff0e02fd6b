//! Prints every figure of `docs/performance.md`: `cargo run --release -p vestibule-bench -- FOLDER`. The folder
//! receives a world of retail size (180 MB). `crowds` as the second argument: the figures of crowds only.

use std::path::PathBuf;

fn main() -> Result<(), vestibule_bench::figures::BenchError> {
    let folder = std::env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from("retail-size"), PathBuf::from);
    let only_crowds = std::env::args().nth(2).is_some_and(|part| part == "crowds");
    let mut print = |figure: vestibule_bench::figures::Figure| {
        let target = figure.target.map(|t| format!("  [{t}]")).unwrap_or_default();
        println!("{}: {}{target}", figure.name, figure.value);
    };
    if only_crowds {
        vestibule_bench::figures::only_crowds(&folder, &mut print)
    } else {
        vestibule_bench::figures::all(&folder, &mut print)
    }
}
