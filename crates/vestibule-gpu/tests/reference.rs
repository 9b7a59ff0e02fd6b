//! The GPU's pictures are the CPU renderer's (`rendering.md` 19, R25).

mod common;

use std::io::Write as _;

use common::{DEEP, Random, Stage, VILLAGE, camera, compare, indoors, leave, outdoors, software};
use vestibule_gpu::{Filtering, Renderer, RendererOptions};
use vestibule_render::{RenderSettings, render, render_ids};
use vestibule_view::Camera;

const SIZE: (u32, u32) = (320, 240);
/// Steps of 256 a channel may differ by before a pixel counts: textures are blended with 8-bit weights on the GPU.
const TOLERANCE: u8 = 8;
/// Of a picture's pixels (R25).
const ALLOWED: f32 = 0.001;
/// Pixels of a picture that may differ away from borders of ids: where one mip level borders on the next, and where faces of
/// one thing meet, which have the same id; rounding decides there.
const WITHIN_IDS: usize = 4;

fn poses(stage: &Stage) -> Vec<Camera> {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut out = vec![
        camera(0xA9B4_0031, [155.4, 24.0, 95.6], [155.4, 12.0, 95.2], SIZE),
        camera(0xA9B4_0101, [155.4, 13.4, 95.6], [155.4, 30.0, 95.4], SIZE),
        camera(0xA9B4_0024, [99.5, 84.0, 95.6], [108.0, 84.0, 93.6], SIZE),
        camera(0xA9B4_010E, [109.5, 82.5, 93.9], [103.0, 84.2, 94.6], SIZE),
    ];
    while out.len() < 20 {
        out.push(outdoors(stage, VILLAGE, &mut random, SIZE));
    }
    while out.len() < 40 {
        out.push(indoors(stage, VILLAGE, &mut random, SIZE));
    }
    while out.len() < 50 {
        out.push(indoors(stage, DEEP, &mut random, SIZE));
    }
    out
}

/// A software adapter with a stage and a renderer to be held against the reference, and settings to do so; `None` without
/// one.
fn start() -> Option<(vestibule_gpu::Gpu, Stage, Renderer, RenderSettings)> {
    let gpu = software()?;
    let options = RendererOptions {
        filtering: Filtering::Reference,
        samples: 1,
    };
    let renderer = Renderer::new(&gpu, options);
    let settings = RenderSettings {
        exact: true,
        ..RenderSettings::default()
    };
    Some((gpu, Stage::new(), renderer, settings))
}

#[test]
fn r25_pictures_equal_the_reference_but_for_edges() {
    let Some((gpu, mut stage, mut renderer, settings)) = start() else {
        return;
    };
    let (mut worst, mut bad) = ((0, 0), Vec::new());
    for (k, camera) in poses(&stage).into_iter().enumerate() {
        stage.look(camera);
        let expected = render(&stage.scene(), &stage.frame, &settings).unwrap();
        let ids = render_ids(&stage.scene(), &stage.frame, &settings).unwrap();
        let actual = renderer
            .image(&gpu, &stage.scene(), &stage.frame, &settings)
            .unwrap();
        let d = compare(&expected, &actual, &ids, TOLERANCE);
        let share = d.differing as f32 / ids.ids().len() as f32;
        if d.differing > worst.0 {
            worst = (d.differing, k);
        }
        if share > ALLOWED || d.away_from_edges > WITHIN_IDS {
            leave(&format!("pose-{k}"), &expected, &actual);
            bad.push((k, d));
        }
    }
    let pixels = (SIZE.0 * SIZE.1) as f32;
    let _ = writeln!(
        std::io::stderr(),
        "R25: worst pose {}: {} pixels differ by more than {TOLERANCE}, {:.3} %",
        worst.1,
        worst.0,
        worst.0 as f32 / pixels * 100.0
    );
    assert!(bad.is_empty(), "see {}: {bad:#?}", common::failures().display());
}

#[test]
fn r25_ids_equal_the_reference_but_for_edges() {
    let Some((gpu, mut stage, mut renderer, settings)) = start() else {
        return;
    };
    let (mut worst, mut bad) = (0, Vec::new());
    for (k, camera) in poses(&stage).into_iter().enumerate() {
        stage.look(camera);
        let expected = render_ids(&stage.scene(), &stage.frame, &settings).unwrap();
        let actual = renderer
            .ids(&gpu, &stage.scene(), &stage.frame, &settings)
            .unwrap();
        let (mut differing, mut away) = (0, 0);
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                let got = actual.get(x, y);
                if got == expected.get(x, y) {
                    continue;
                }
                differing += 1;
                // An edge runs through the pixel or beside it.
                let own = expected.get(x, y);
                let near = |k: u32| expected.get((x + k % 3).wrapping_sub(1), (y + k / 3).wrapping_sub(1));
                away += usize::from((0..9).all(|k| near(k).is_none_or(|n| Some(n) == own)));
            }
        }
        worst = worst.max(differing);
        let share = differing as f32 / expected.ids().len() as f32;
        if share > ALLOWED || away > 0 {
            leave(
                &format!("ids-{k}"),
                &expected.to_image().unwrap(),
                &actual.to_image().unwrap(),
            );
            bad.push((k, differing, away));
        }
    }
    let _ = writeln!(std::io::stderr(), "R25 ids: worst pose: {worst} pixels differ");
    assert!(bad.is_empty(), "see {}: {bad:?}", common::failures().display());
}

#[test]
fn r25_bodies_in_lamplight_equal_the_reference_and_are_not_black() {
    use vestibule_physics::{Body, Population, Scratch};
    use vestibule_render::{PixelKind, Scene};
    use vestibule_world::{CellId, Frame, Position};
    let Some((gpu, mut stage, mut renderer, settings)) = start() else {
        return;
    };
    // A hall of the mine, a lantern over its middle, someone seen from behind right under it.
    let feet = glam::Vec3::new(74.0, -80.0, -20.0);
    let cell = CellId(0x0107_0102);
    let mut population = Population::new();
    let id = population.add(Body::player());
    let position = Position {
        cell,
        frame: Frame::at(feet),
    };
    population.force_into_cell(&stage.world, &mut Scratch::new(), id, &position);
    let eye = feet + glam::Vec3::new(0.0, -2.5, 1.5);
    let camera = camera(cell.0, eye.to_array(), (feet + glam::Vec3::Z).to_array(), SIZE);
    let objects = vestibule_view::WorldObjects::new(&stage.world).with_population(&population);
    let input = vestibule_view::FrameInput::new(camera);
    stage
        .frame
        .update(&stage.world, &stage.openings, &objects, &input);
    let scene = Scene::new(&stage.world, &stage.assets)
        .with_population(&population)
        .with_player(id, 1.0);
    let expected = render(&scene, &stage.frame, &settings).unwrap();
    let ids = render_ids(&scene, &stage.frame, &settings).unwrap();
    let actual = renderer.image(&gpu, &scene, &stage.frame, &settings).unwrap();
    let d = compare(&expected, &actual, &ids, TOLERANCE);
    if d.differing as f32 > ALLOWED * ids.ids().len() as f32 {
        leave("body", &expected, &actual);
        panic!("see {}: {d:?}", common::failures().display());
    }
    let body = ids.ids().iter().zip(actual.pixels());
    let body: Vec<_> = body.filter(|(id, _)| id.kind() == PixelKind::Object).collect();
    assert!(body.len() > 2000, "{}", body.len());
    let bright = |p: &[u8; 4]| p[..3].iter().map(|&c| u32::from(c)).max().unwrap();
    let dark = body.iter().filter(|(_, p)| bright(p) < 18).count();
    assert!(
        dark * 20 < body.len(),
        "{dark} of {} pixels are nearly black",
        body.len()
    );
}
