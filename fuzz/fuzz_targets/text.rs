//! Any text as a position, a map coordinate, a cell id and a test vector.
#![no_main]

#[path = "../../crates/vestibule/tests/hostile/mod.rs"]
mod hostile;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::text(bytes));
