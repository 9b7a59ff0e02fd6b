//! Any bytes as a DAT container: opened, verified, read record by record, edited.
#![no_main]

#[path = "../../crates/vestibule/tests/hostile/mod.rs"]
mod hostile;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::container(bytes));
