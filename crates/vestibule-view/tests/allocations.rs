//! No allocation in steady state (`visibility.md` 14.5, 17.7).
#![allow(unsafe_code, reason = "a global allocator cannot be written without it")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use common::maze::{Maze, Random};
use vestibule_view::PView;

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    // A thread that is going away has no counter any more, and nothing to count.
    let _ = COUNT.try_with(|c| c.set(c.get() + 1));
}

// SAFETY: every call is handed to the system allocator unchanged; counting neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(ptr, layout) }
    }

    unsafe fn realloc(&self, ptr: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.realloc(ptr, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(work: impl FnOnce()) -> usize {
    let before = COUNT.with(Cell::get);
    work();
    COUNT.with(Cell::get) - before
}

#[test]
fn s14_5_a_warm_traversal_does_not_allocate() {
    let mut random = Random(7);
    let mut maze = Maze::random(&mut random, false);
    while maze.rooms.specs.len() < 20 {
        maze = Maze::random(&mut random, false);
    }
    let openings = maze.rooms.build();
    let cameras: Vec<_> = (0..500).map(|_| maze.camera(&mut random)).collect();
    let mut pview = PView::default();
    let mut seen = 0;
    let mut run = |pview: &mut PView| {
        for camera in &cameras {
            seen += pview.look_in_block(Some(&openings), camera).cells().len();
        }
    };
    assert!(
        allocations(|| run(&mut pview)) > 0,
        "the first run warms up, or the counter does not count"
    );
    assert_eq!(allocations(|| run(&mut pview)), 0);
    assert!(seen > 1_000);
}

#[test]
fn s14_5_a_warm_frame_does_not_allocate() {
    let folder =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/vectors/worlds/cottage-2");
    if !folder.exists() {
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("skipped: no test vectors\n"));
        return;
    }
    let world = vestibule_world::World::open(vestibule_dat::DatSet::open(folder).unwrap()).unwrap();
    let openings = vestibule_view::Openings::new();
    let objects = vestibule_view::WorldObjects::new(&world);
    let block = vestibule_world::BlockId(0xA9B4);
    let mut cameras = Vec::new();
    let mut random = Random(3);
    for cell in world.block(block).unwrap().env_cells() {
        let bounds = cell.structure.bounds.unwrap();
        let eye = cell.frame.local_to_global((bounds.min + bounds.max) * 0.5);
        let (out, outside) = cell.id.adjust_to_outside(eye - glam::Vec3::Y * 14.0).unwrap();
        for (id, eye) in [(cell.id, eye), (out, outside)] {
            for _ in 0..8 {
                let yaw = random.within(0.0, 6.3);
                let look = glam::Vec3::new(libm::sinf(yaw), libm::cosf(yaw), 0.0);
                let screen = glam::Vec2::new(800.0, 600.0);
                cameras.push(vestibule_view::Camera::new(id, eye, look, glam::Vec3::Z, 1.2, screen).unwrap());
            }
        }
    }
    let mut frame = vestibule_view::FrameView::default();
    let mut commands = 0;
    let mut run = |frame: &mut vestibule_view::FrameView| {
        for camera in &cameras {
            frame.update(
                &world,
                &openings,
                &objects,
                &vestibule_view::FrameInput::new(*camera),
            );
            commands += frame.commands().len();
        }
    };
    assert!(allocations(|| run(&mut frame)) > 0);
    assert_eq!(allocations(|| run(&mut frame)), 0);
    assert!(commands > 1_000);
}
