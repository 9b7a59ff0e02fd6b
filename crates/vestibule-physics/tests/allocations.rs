//! A sweep allocates nothing once its scratch is warm.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use common::*;
use vestibule_physics::{Population, Scratch, sweep};
use vestibule_world::Position;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is handed on to the system's allocator unchanged.
#[allow(unsafe_code, reason = "a global allocator cannot be written without")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_warm_sweep_allocates_nothing() {
    let mut worlds = Worlds::default();
    let (population, mut scratch) = (Population::new(), Scratch::new());
    let cases = cases("sweep.jsonl");
    let mut run = |count: bool| {
        let mut made = 0;
        for case in &cases {
            let input = &case["in"];
            let from = start(input);
            let to = Position::new(from.cell, vec3(&input["to"]));
            let (mover, state) = (mover(input), carried(&input["state"]));
            let world = worlds.get(case["world"].as_str().unwrap());
            let before = ALLOCATIONS.get();
            let swept = sweep(world, &population, &mut scratch, &mover, &state, &from, &to);
            made += ALLOCATIONS.get() - before;
            assert!(swept.is_ok());
        }
        if count {
            assert_eq!(made, 0);
        }
    };
    // The first round loads landblocks and grows the scratch.
    run(false);
    run(true);
}
