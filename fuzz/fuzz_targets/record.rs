//! Any bytes as a record of any type: the first byte selects the type.
#![no_main]

#[path = "../../crates/vestibule/tests/hostile/mod.rs"]
mod hostile;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::record(bytes));
