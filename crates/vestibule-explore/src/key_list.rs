//! The list of keys in the window.

use egui::{Align2, Context, RichText, Ui};

use crate::explorer::Explorer;
use crate::keys::{Group, KEYS};
use crate::panels::{DIM, GOLD};

/// Keys and what they do.
pub(crate) fn show(context: &Context, explorer: &mut Explorer) {
    let mut open = true;
    let size = context.content_rect().size();
    let window = egui::Window::new("Keys").anchor(Align2::CENTER_CENTER, [0.0, 0.0]);
    let window = window.resizable(false).collapsible(false).open(&mut open);
    // Two columns where there is room for them.
    let two = size.x >= 860.0;
    let most = size.x - 30.0;
    let whole = if two { 800.0 } else { 400.0 };
    let width = if whole < most { whole } else { most };
    window.default_size([width, size.y]).show(context, |ui| {
        ui.set_width(width);
        let height = size.y - 80.0;
        egui::ScrollArea::vertical()
            .max_height(if height > 40.0 { height } else { 40.0 })
            .show(ui, |ui| {
                ui.set_width(width);
                if two {
                    ui.columns(2, |columns| {
                        if let [left, right] = columns {
                            keys_of(left, &[Group::Move, Group::Window]);
                            keys_of(right, &[Group::Why, Group::Go]);
                        }
                    });
                } else {
                    keys_of(ui, &Group::ALL);
                }
            });
    });
    explorer.show_help &= open;
}

fn keys_of(ui: &mut Ui, groups: &[Group]) {
    for group in groups {
        ui.label(RichText::new(group.name()).color(DIM).strong());
        let grid = egui::Grid::new(group.name()).num_columns(2).min_col_width(104.0);
        grid.show(ui, |ui| {
            for (_, keys, what) in KEYS.iter().filter(|k| k.0 == *group) {
                ui.label(RichText::new(*keys).color(GOLD));
                ui.label(*what);
                ui.end_row();
            }
        });
        ui.add_space(6.0);
    }
}
