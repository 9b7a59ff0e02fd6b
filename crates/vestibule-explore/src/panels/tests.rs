//! Panels in windows of many sizes, without a window.

use std::sync::Arc;

use super::*;
use crate::keys::Held;
use crate::testing::hollow;
use egui::{RawInput, Rect, pos2, vec2};
use glam::Vec2;
use vestibule_world::Position;

fn explorer() -> Explorer {
    let (world, names) = hollow();
    let start: Position = "0xA9B40101 [155.4 12.9 94.005] 1 0 0 0".parse().unwrap();
    Explorer::new(Arc::new(world), names, start).unwrap()
}

/// Draws some frames of a window and gives the rectangles of its panels.
fn draw(explorer: &mut Explorer, (x, y): (f32, f32)) -> Vec<(&'static str, Rect)> {
    let context = Context::default();
    style(&context);
    let times = FrameTimes {
        adapter: "an adapter with a long name (and a driver with a longer one, 1.2.3)".to_owned(),
        whole: vec![0.016; 120],
        ..FrameTimes::default()
    };
    for _ in 0..4 {
        explorer.tick(&Held::default(), 0.05, Vec2::new(x, y));
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(x, y))),
            ..RawInput::default()
        };
        let mut output = context.run_ui(input, |ui| show(&ui.ctx().clone(), explorer, &times));
        output.textures_delta.clear();
        context.tessellate(output.shapes, 1.0);
    }
    let titles = ["Where", "View", "Map", "What is this?", "Keys"];
    let rect = |title| {
        Some((
            title,
            context.memory(|m| m.area_rect(egui::Id::unique(Some(title))))?,
        ))
    };
    titles.into_iter().filter_map(rect).collect()
}

#[test]
fn panels_stay_in_the_window_and_off_each_other() {
    let mut e = explorer();
    e.overlays = [true; 5];
    for size in [(640.0, 480.0), (800.0, 600.0), (1280.0, 720.0), (3840.0, 2160.0)] {
        e.show_map = true;
        draw(&mut e, size);
        e.pick(Vec2::new(size.0 * 0.5, size.1 * 0.4));
        let panels = draw(&mut e, size);
        assert_eq!(panels.len(), 4, "{size:?} {panels:?}");
        for (k, (name, rect)) in panels.iter().enumerate() {
            let window = Rect::from_min_size(pos2(0.0, 0.0), vec2(size.0, size.1));
            assert!(window.contains_rect(*rect), "{name} leaves {size:?}: {rect:?}");
            for (other, over) in &panels[k + 1..] {
                assert!(
                    !rect.intersects(*over),
                    "{name} covers {other} at {size:?}: {rect:?} {over:?}"
                );
            }
        }
        e.show_help = true;
        let panels = draw(&mut e, size);
        let keys = panels.iter().find(|p| p.0 == "Keys").unwrap().1;
        assert!(
            keys.height() <= size.1 && keys.width() <= size.0,
            "{size:?} {keys:?}"
        );
        e.show_help = false;
    }
}

#[test]
fn windows_of_every_size_are_drawn() {
    let mut e = explorer();
    e.overlays = [true; 5];
    (e.show_map, e.show_help, e.typing) = (true, true, Some("cott".to_owned()));
    e.pick(Vec2::new(100.0, 100.0));
    for x in [1.0, 2.0, 40.0, 159.0, 161.0, 320.0, 5000.0] {
        for y in [1.0, 3.0, 119.0, 121.0, 240.0, 4000.0] {
            draw(&mut e, (x, y));
        }
    }
}
