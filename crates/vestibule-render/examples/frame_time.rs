//! Measures the time of a 640 x 480 frame of the reference renderer, over 20 places of the built-in world.
//!
//! ```text
//! cargo run --release -p vestibule-render --example frame_time
//! ```
//!
//! Each place is drawn many times by one thread and its fastest time counts. On Linux that is the time a processor
//! spent on it, so that other programs disturb little.

use std::io::Write as _;
use std::time::Duration;

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Random, Rooms, Stage, camera, mixed_camera};
use glam::Vec3;
use vestibule_render::{RenderSettings, render, render_ids};
use vestibule_view::{Camera, FrameView};
use vestibule_world::CellId;

/// Time spent so far, by this thread where the system tells.
fn now() -> Duration {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanos = told.and_then(|t| t.split(' ').next()?.parse().ok());
    nanos.map_or_else(
        || START.get_or_init(std::time::Instant::now).elapsed(),
        Duration::from_nanos,
    )
}

const SIZE: (u32, u32) = (640, 480);
const REPEATS: usize = 15;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut stage, _) = Stage::hollow(0xA9B4);
    stage.frame = FrameView::default();
    let rooms = Rooms::new(&stage);
    let mut random = Random(5);
    let look = |cell: u32, eye: [f32; 3], at: [f32; 3]| {
        let (eye, at) = (Vec3::from_array(eye), Vec3::from_array(at));
        camera(CellId(cell), eye, at - eye, SIZE, 1.0)
    };
    let mut cameras: Vec<Camera> = vec![
        look(0xA9B4_0031, [152.0, 27.0, 95.8], [155.6, 14.0, 95.6]),
        look(0xA9B4_0034, [130.0, 40.0, 99.0], [70.0, 90.0, 93.0]),
        look(0xA9B4_0101, [156.4, 12.9, 95.7], [153.5, 30.0, 95.3]),
        look(0xA9B4_010E, [110.8, 81.2, 94.4], [103.0, 84.6, 94.4]),
        look(0xA9B4_011D, [-4.5, 117.5, 92.9], [0.0, 125.0, 92.4]),
    ];
    while cameras.len() < 20 {
        cameras.push(mixed_camera(&stage, &rooms, &mut random, SIZE));
    }
    let mut out = std::io::stdout().lock();
    let settings = RenderSettings {
        threads: 1,
        ..RenderSettings::default()
    };
    let mut all: [Vec<Duration>; 3] = Default::default();
    for camera in cameras {
        let mut best = [Duration::MAX; 3];
        for _ in 0..REPEATS {
            let started = now();
            stage.update(camera);
            best[0] = best[0].min(now() - started);
            let started = now();
            render(&stage.scene(), &stage.frame, &settings)?;
            best[1] = best[1].min(now() - started);
            let started = now();
            render_ids(&stage.scene(), &stage.frame, &settings)?;
            best[2] = best[2].min(now() - started);
        }
        let [view, color, ids] = best.map(|d| d.as_secs_f64() * 1000.0);
        writeln!(
            out,
            "{:?} {}: frame {view:.2} ms, picture {color:.2} ms, ids {ids:.2} ms, {} commands",
            camera.cell(),
            camera.eye(),
            stage.frame.commands().len()
        )?;
        for (list, time) in all.iter_mut().zip(best) {
            list.push(time);
        }
    }
    for (name, list) in ["frame", "picture", "ids"].into_iter().zip(&mut all) {
        list.sort_unstable();
        let ms = |d: Duration| d.as_secs_f64() * 1000.0;
        let (low, middle, high) = (list[0], list[list.len() / 2], list[list.len() - 1]);
        writeln!(
            out,
            "{name}: median {:.2} ms, {:.2} to {:.2} ms",
            ms(middle),
            ms(low),
            ms(high)
        )?;
    }
    Ok(())
}
