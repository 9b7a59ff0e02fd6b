//! The rules of the pictures, each with the defect that appears when it is broken (`rendering.md` 18, 19).
//!
//! `VESTIBULE_POSES` sets how many random poses the comparisons take (the default is small).

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod buildings;
mod doorways;
mod drawing;
mod rays;
mod sealed;
mod thresholds;
mod viewer;

use std::collections::BTreeSet;

use common::{Difference, Random, Rooms, Stage, camera, compare, compare_with_oracle, mixed_camera};
use glam::Vec3;
use vestibule_physics::{Body, ObjectRef, Population, Scratch};
use vestibule_render::{
    IdImage, Oracle, PixelKind, RenderSettings, Scene, render, render_commands, render_commands_ids,
    render_ids,
};
use vestibule_view::{
    Camera, Command, FrameInput, FramePath, FrameView, PlayerCell, ViewerCell, WorldObjects,
};
use vestibule_world::{CellId, Frame, PortalTarget, Position};

const VILLAGE: u16 = 0xA9B4;
const DEEP: u16 = 0x0107;
const SMALL: (u32, u32) = (64, 48);

fn poses(default: usize) -> usize {
    let set = std::env::var("VESTIBULE_POSES").ok();
    set.and_then(|v| v.parse().ok()).unwrap_or(default)
}

fn village() -> Stage {
    Stage::hollow(VILLAGE).0
}

/// The id picture of other commands than the frame's own.
fn ids_of(stage: &Stage, commands: &[Command]) -> IdImage {
    let settings = RenderSettings::default();
    render_commands_ids(&stage.scene(), &stage.frame, commands, &settings)
        .unwrap()
        .0
}

fn without(stage: &Stage, drop: impl Fn(&Command) -> bool) -> Vec<Command> {
    stage
        .frame
        .commands()
        .iter()
        .filter(|c| !drop(c))
        .copied()
        .collect()
}

/// Pixels that neither rays nor the meeting of surfaces explain.
fn wrong(picture: &IdImage, oracle: &Oracle, camera: &Camera) -> usize {
    compare_with_oracle(picture, oracle, camera, |_, _, _, _| {}).unexplained()
}

/// A camera in the village, looking from one point at another.
fn look(cell: u32, eye: [f32; 3], at: [f32; 3], size: (u32, u32)) -> Camera {
    let (eye, at) = (Vec3::from_array(eye), Vec3::from_array(at));
    camera(CellId(cell), eye, at - eye, size, 1.2)
}

// Places of the village.
fn before_cottage(size: (u32, u32)) -> Camera {
    look(0xA9B4_0031, [155.4, 24.0, 95.6], [155.4, 12.0, 95.2], size)
}

fn in_cottage(size: (u32, u32)) -> Camera {
    look(0xA9B4_0101, [155.4, 13.4, 95.6], [155.4, 30.0, 95.4], size)
}

fn before_shop(size: (u32, u32)) -> Camera {
    look(0xA9B4_0024, [99.5, 84.0, 95.6], [108.0, 84.0, 93.6], size)
}

fn in_shop(size: (u32, u32)) -> Camera {
    look(0xA9B4_010E, [109.5, 82.5, 93.9], [103.0, 84.2, 94.6], size)
}

/// The share of pixels that change class between two pictures, 0…1.
fn changed(a: &IdImage, b: &IdImage) -> f32 {
    compare(a, b).differing as f32 / a.ids().len() as f32
}
