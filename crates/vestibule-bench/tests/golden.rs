//! The outcome of the golden scenario is the same everywhere: in debug and release, on one thread and on two.

use vestibule_bench::golden;

#[test]
fn the_golden_hash_on_one_thread() {
    let hash = golden::whole(1).expect("the scenario");
    assert_eq!(hash, golden::HASH, "0x{hash:016X}");
}

#[test]
fn the_golden_hash_on_two_threads() {
    let hash = golden::whole(2).expect("the scenario");
    assert_eq!(hash, golden::HASH, "0x{hash:016X}");
}
