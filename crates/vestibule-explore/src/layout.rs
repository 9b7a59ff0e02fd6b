//! How the panels share the window.

use egui::Ui;

use crate::explorer::Explorer;

/// A window that is smaller shows the picture only, points.
const LEAST: egui::Vec2 = egui::vec2(160.0, 120.0);
/// A window that is smaller has no room for the panels at its sides, points.
const LEAST_PANELS: egui::Vec2 = egui::vec2(480.0, 320.0);

/// Whether there is room for words.
pub(crate) fn fits(window: egui::Vec2) -> bool {
    window.x >= LEAST.x && window.y >= LEAST.y
}

/// Whether there is room for the panels at the sides.
pub(crate) fn fits_panels(window: egui::Vec2) -> bool {
    window.x >= LEAST_PANELS.x && window.y >= LEAST_PANELS.y
}

/// How much of the window each panel may take, so that none covers another; points. What does not fit is scrolled to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Room {
    /// Width of the panels at the sides.
    pub(crate) side: f32,
    /// Height of what is in "Where".
    pub(crate) place: f32,
    /// Height of what is in "View".
    pub(crate) view: f32,
    /// Height of what is in "What is this?".
    pub(crate) picked: f32,
    /// Side of the map.
    pub(crate) map: f32,
}

impl Room {
    /// Height of a panel's title and borders, and of the gap to the next.
    pub(crate) const FRAME: f32 = 60.0;

    pub(crate) fn of(window: egui::Vec2, explorer: &Explorer) -> Room {
        let least = |a: f32, b: f32| if a < b { a } else { b };
        let most = |a: f32, b: f32| if a > b { a } else { b };
        let whole = most(window.y - Self::FRAME - 10.0, 20.0);
        let map = most(least(least(320.0, window.y * 0.42), window.x * 0.4), 80.0);
        let below = |open: bool, height: f32| if open { height + Self::FRAME } else { 0.0 };
        let picked = most(least(240.0, whole * 0.45), 20.0);
        Room {
            side: most(least(270.0, window.x * 0.5 - 40.0), 60.0),
            place: most(whole - below(explorer.picked.is_some(), picked), 20.0),
            view: most(whole - below(explorer.show_map, map), 20.0),
            picked,
            map,
        }
    }
}

/// What does not fit is scrolled to.
pub(crate) fn scrolled(ui: &mut Ui, width: f32, height: f32, fill: impl FnOnce(&mut Ui)) {
    ui.set_max_width(width);
    egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
        ui.set_max_width(width);
        fill(ui);
    });
}
