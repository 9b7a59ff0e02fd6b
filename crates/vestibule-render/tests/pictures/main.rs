//! The rules of the pictures, each with the defect that appears when it is broken (`rendering.md` 18, 19).
//!
//! `VESTIBULE_POSES` sets how many random poses the comparisons take (the default is small).

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod buildings;
mod defects_indoors;
mod defects_outdoors;
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

/// A slab whose top lies at the height of the ground.
fn slab() -> Stage {
    let text = "scene \"floor\"\nland 0xA9B4 0xA9B4 origin 0xA9B4\nheights 1\nstart at (20 20 ~0)\n\
         terrain { base 94; paint grassland everywhere }\n\
         material boards planks color 148 110 70 second 78 54 34 size 1.6\n\
         model slab { box (-6 -6 -0.5) (6 6 0); material boards }\nstatic slab at (72 72 94)\n";
    Stage::scene_text(VILLAGE, text).0
}

/// The pixels on the slab, from 100 sides, that show ground.
fn fights(stage: &mut Stage, settings: &RenderSettings) -> usize {
    let mut random = Random(17);
    let mut lost = 0;
    for _ in 0..100 {
        let turn = random.between(0.0, core::f32::consts::TAU);
        let reach = random.between(8.0, 40.0);
        let (s, c) = libm::sincosf(turn);
        let over = random.between(0.5, 6.0);
        let eye = Vec3::new(72.0 + s * reach, 72.0 + c * reach, 94.0 + over);
        let cell = stage.world.ground_at(CellId(0xA9B4_0001), eye).unwrap().cell;
        let camera = camera(cell, eye, Vec3::new(72.0, 72.0, 94.0) - eye, SMALL, 1.0);
        stage.update(camera);
        let picture = render_ids(&stage.scene(), &stage.frame, settings).unwrap();
        for y in 0..SMALL.1 {
            for x in 0..SMALL.0 {
                let ray = camera.ray_through(glam::Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
                let on = eye + ray * ((94.0 - eye.z) / ray.z);
                let inside = ray.z < 0.0 && (on.x - 72.0).abs() < 5.9 && (on.y - 72.0).abs() < 5.9;
                let ground = picture.get(x, y).unwrap().kind() == PixelKind::Terrain;
                lost += usize::from(inside && ground);
            }
        }
    }
    lost
}

/// A house whose second room stands behind what the window of the first one shows, and that second room.
fn hook() -> (Stage, CellId) {
    let (stage, compiled) = Stage::scene_text(
        VILLAGE,
        "scene \"hook\"\nland 0xA9B4 0xA9B4 origin 0xA9B4\nheights 1\nstart at (20 20 ~0)\n\
         terrain { base 94; paint grassland everywhere }\n\
         material brick bricks color 150 92 70 second 150 140 126 size 1.6\n\
         building hook at (60 60 94) {\n\
         shell { prism z -0.6 3.2 (-0.3 -0.3) (6.3 -0.3) (6.3 2.2) (4.2 4.3) (-0.3 4.3)\n\
         prism z -0.6 3.2 (5.88 1.7) (12.3 1.7) (12.3 10.3) (0.7 10.3) (0.7 6.88)\nmaterial brick }\n\
         room main { prism z 0 2.6 (0 0) (6 0) (6 2) (4 4) (0 4); material brick }\n\
         room side { prism z 0 2.6 (6 2) (12 2) (12 10) (1 10) (1 7); material brick }\n\
         room gap { box (1 4 0.4) (3 4.3 2.4); material brick }\n\
         opening main side\nopening main gap\nwindow gap\n}\n",
    );
    let side = compiled.cell_named("hook.side").unwrap();
    assert_eq!(compiled.cell_named("hook.main"), Some(CellId(HOOK_CAMERA.0)));
    (stage, side)
}

/// In the hook's first room, looking at the window: cell, eye, point looked at.
const HOOK_CAMERA: (u32, [f32; 3], [f32; 3]) = (0xA9B4_0100, [61.2, 61.0, 95.5], [66.2, 66.0, 95.4]);

/// Two rooms partly in the same place, behind two doors of a third (`visibility.md` V30).
fn overlap() -> Stage {
    let text = "dungeon d 0x0101 at (50 50 0) {\n\
         room a { box (-5 -5 0) (5 5 3) }\n\
         room b { box (-10 5 0) (0 15 3) }\nroom c { box (0 5 0) (10 15 3) }\n\
         opening a b rect (-3 5 0) (-1 5 2.5)\nopening a c rect (1 5 0.25) (3 5 2.75)\n}\n";
    let compiled = vestibule_forge::compile_scene("test", text).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(compiled.cell_named("d.a"), Some(CellId(OVERLAP.0)));
    let mut records = compiled.memory_records();
    // Half a turn of the second room about the axis through the middle of its door: the door stays where it is, the
    // room now reaches over to the first one's side.
    let id = compiled.cell_named("d.c").unwrap().0;
    let mut cell = vestibule_dat::record::EnvCell::parse(id, &compiled.cell[&id]).unwrap();
    let middle = Vec3::new(52.0, 55.0, 1.5);
    let gap = cell.frame.origin - middle;
    cell.frame.origin = middle + Vec3::new(-gap.x, gap.y, -gap.z);
    let turn = glam::Quat::from_xyzw(0.0, 1.0, 0.0, 0.0);
    cell.frame.rotation = turn * cell.frame.rotation;
    records.insert(vestibule_world::Store::Cell, id, cell.encode().unwrap());
    let world = vestibule_world::World::open(records).unwrap();
    Stage::new(world, vestibule_world::BlockId(0x0101))
}

/// Its first room: cell, middle of its floor.
const OVERLAP: (u32, [f32; 3]) = (0x0101_0100, [50.0, 50.0, 0.0]);

/// A room of the built-in world by its name.
fn cell(name: &str) -> CellId {
    common::hollow_records().cell_named(name).unwrap()
}
