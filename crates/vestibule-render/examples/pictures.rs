//! Draws the built-in world: a picture per place, a filmstrip across a threshold and an animation of it.
//!
//! ```text
//! cargo run --release -p vestibule-render --example pictures -- FOLDER
//! ```

use std::path::PathBuf;

use glam::{Vec2, Vec3};
use vestibule_render::{Assets, Filmstrip, RenderSettings, Scene, render, write_apng};
use vestibule_view::{Camera, FrameInput, FrameView, Openings, WorldObjects};
use vestibule_world::{CellId, World};

/// Places: name, cell, eye, point looked at, time of day.
const PLACES: [(&str, u32, [f32; 3], [f32; 3], f32); 9] = [
    (
        "cottage",
        0xA9B4_0031,
        [152.0, 27.0, 95.8],
        [155.6, 14.0, 95.6],
        0.5,
    ),
    (
        "village",
        0xA9B4_0034,
        [130.0, 40.0, 99.0],
        [70.0, 90.0, 93.0],
        0.5,
    ),
    (
        "doorway",
        0xA9B4_0101,
        [156.4, 12.9, 95.7],
        [153.5, 30.0, 95.3],
        0.5,
    ),
    ("shop", 0xA9B4_0024, [98.0, 82.6, 95.8], [108.0, 84.4, 93.8], 0.5),
    (
        "shop-inside",
        0xA9B4_010E,
        [110.8, 81.2, 94.4],
        [103.0, 84.6, 94.4],
        0.5,
    ),
    ("barn", 0xA9B4_001B, [74.0, 63.4, 95.8], [60.0, 60.0, 95.8], 0.5),
    (
        "lookout",
        0xA9B4_0113,
        [157.5, 107.0, 104.3],
        [140.0, 107.6, 101.5],
        0.5,
    ),
    ("mine", 0xA9B4_011D, [-4.5, 117.5, 92.9], [0.0, 125.0, 92.4], 0.5),
    (
        "evening",
        0xA9B4_0034,
        [130.0, 40.0, 99.0],
        [70.0, 90.0, 93.0],
        0.745,
    ),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: pictures FOLDER")?);
    std::fs::create_dir_all(&folder)?;
    let compiled = vestibule_forge::embedded_world()?;
    let world = World::open(compiled.memory_records())?;
    let (openings, assets) = (Openings::new(), Assets::new());
    let mut frame = FrameView::default();
    let settings = RenderSettings::default();
    let mut draw = |cell: u32, eye: Vec3, at: Vec3, time: f32, size: Vec2| {
        let camera = Camera::new(CellId(cell), eye, at - eye, Vec3::Z, 0.95, size)?;
        frame.update(
            &world,
            &openings,
            &WorldObjects::new(&world),
            &FrameInput::new(camera),
        );
        let scene = Scene::new(&world, &assets).at_time(time);
        Ok::<_, Box<dyn std::error::Error>>(render(&scene, &frame, &settings)?)
    };
    for (name, cell, eye, at, time) in PLACES {
        let (eye, at) = (Vec3::from_array(eye), Vec3::from_array(at));
        draw(cell, eye, at, time, Vec2::new(960.0, 540.0))?.save_png(folder.join(format!("{name}.png")))?;
    }
    // In through the cottage's door.
    let (mut strip, mut film) = (Filmstrip::new(4), Vec::new());
    for k in 0..48 {
        let y = 21.0 - k as f32 * 0.17;
        let eye = Vec3::new(155.4, y, 95.6);
        let rooms = [0xA9B4_0100, 0xA9B4_0101];
        let inside = rooms
            .into_iter()
            .find(|&id| world.env_cell(CellId(id)).is_some_and(|c| c.contains_point(eye)));
        let cell = inside.unwrap_or(0xA9B4_0031);
        let picture = draw(
            cell,
            eye,
            Vec3::new(155.2, y - 10.0, 95.4),
            0.5,
            Vec2::new(320.0, 240.0),
        )?;
        if k % 4 == 0 {
            strip.push(&format!("{} y {y:.2}", CellId(cell)), picture.clone());
        }
        film.push(picture);
    }
    strip.to_image()?.save_png(folder.join("filmstrip.png"))?;
    let file = std::fs::File::create(folder.join("door.png"))?;
    write_apng(&film, 80, std::io::BufWriter::new(file))?;
    Ok(())
}
