//! Pictures as they are to look: compared with PNG files beside this test.
//!
//! `VESTIBULE_BLESS=1 cargo test -p vestibule-gpu --test goldens` writes them anew.

mod common;

use std::path::PathBuf;

use common::{Stage, camera, leave, software};
use vestibule_gpu::{Renderer, RendererOptions};
use vestibule_render::{Image, RenderSettings};
use vestibule_view::Camera;

const SIZE: (u32, u32) = (320, 200);
/// Steps of 256 a channel may differ by.
const TOLERANCE: u8 = 5;
/// Share of pixels that may differ by more: edges, on another version of the adapter.
const ALLOWED: f32 = 0.003;

fn views() -> Vec<(&'static str, Camera, f32)> {
    vec![
        (
            "cottage-door",
            camera(0xA9B4_0031, [155.4, 24.0, 95.6], [155.4, 12.0, 95.2], SIZE),
            0.5,
        ),
        (
            "out-of-the-cottage",
            camera(0xA9B4_0101, [155.4, 11.0, 95.6], [155.4, 30.0, 95.4], SIZE),
            0.5,
        ),
        (
            "sunken-shop",
            camera(0xA9B4_0024, [99.5, 84.0, 95.6], [108.0, 84.0, 93.6], SIZE),
            0.5,
        ),
        (
            "dusk",
            camera(0xA9B4_0031, [140.0, 40.0, 99.0], [165.0, 5.0, 96.0], SIZE),
            0.74,
        ),
    ]
}

fn folder() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/goldens"))
}

fn load(path: &std::path::Path) -> Option<Image> {
    let file = std::fs::File::open(path).ok()?;
    let mut reader = png::Decoder::new(std::io::BufReader::new(file))
        .read_info()
        .ok()?;
    let mut bytes = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut bytes).ok()?;
    let mut image = Image::new(info.width, info.height, [0; 4]).ok()?;
    for (p, c) in image.pixels_mut().iter_mut().zip(bytes.chunks_exact(4)) {
        *p = [c[0], c[1], c[2], c[3]];
    }
    Some(image)
}

#[test]
fn goldens_look_as_blessed() {
    let Some(gpu) = software() else { return };
    let bless = std::env::var_os("VESTIBULE_BLESS").is_some_and(|v| v == "1");
    let mut stage = Stage::new();
    let options = RendererOptions {
        samples: 4,
        ..RendererOptions::default()
    };
    let mut renderer = Renderer::new(&gpu, options);
    let mut bad = Vec::new();
    for (name, camera, time) in views() {
        stage.look(camera);
        let scene = stage.scene().at_time(time);
        let actual = renderer
            .image(&gpu, &scene, &stage.frame, &RenderSettings::default())
            .unwrap();
        let path = folder().join(format!("{name}.png"));
        if bless {
            std::fs::create_dir_all(folder()).unwrap();
            actual.save_png(&path).unwrap();
            continue;
        }
        let Some(expected) = load(&path) else {
            bad.push(format!("{}: no picture, bless one", path.display()));
            continue;
        };
        let apart = |a: &[u8; 4], b: &[u8; 4]| (0..3).any(|k| a[k].abs_diff(b[k]) > TOLERANCE);
        let pairs = expected.pixels().iter().zip(actual.pixels());
        let differing = pairs.filter(|(a, b)| apart(a, b)).count();
        let share = differing as f32 / expected.pixels().len() as f32;
        if share > ALLOWED || (expected.width(), expected.height()) != SIZE {
            let left = leave(name, &expected, &actual);
            bad.push(format!(
                "{name}: {:.2} % differ, see {}",
                share * 100.0,
                left.display()
            ));
        }
    }
    let adapter = folder().join("adapter.txt");
    if bless {
        std::fs::write(&adapter, format!("{}\n", gpu.name())).unwrap();
    }
    let blessed_on = std::fs::read_to_string(&adapter).unwrap_or_default();
    assert!(
        bad.is_empty(),
        "drawn on {}, blessed on {blessed_on}: {bad:#?}",
        gpu.name()
    );
}
