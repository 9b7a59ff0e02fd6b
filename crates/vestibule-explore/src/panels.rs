//! The panels over the picture: where the player and the viewer are, what is drawn and why, keys and controls.

use std::collections::BTreeMap;

use egui::{Align2, Color32, Context, RichText, Ui};
use vestibule_view::{Command, FramePath};
use vestibule_world::{CellId, MapCoordinates, PortalTarget};

use crate::explorer::{Explorer, Show, clock};
use crate::key_list;
use crate::keys::Action;
use crate::layout::{self, Room, scrolled};
use crate::overlays::{Mark, Overlay, cell_color};
use crate::portals;
use crate::sidemap;

/// Times of the last frames and what they drew.
#[derive(Clone, Debug, Default)]
pub(crate) struct FrameTimes {
    /// Seconds from frame to frame, the newest last.
    pub(crate) whole: Vec<f32>,
    /// Seconds of deciding what is seen.
    pub(crate) decide: f32,
    /// Seconds of building and submitting the frame.
    pub(crate) submit: f32,
    /// Draw calls.
    pub(crate) draws: u32,
    /// Triangles.
    pub(crate) triangles: u32,
    /// What draws.
    pub(crate) adapter: String,
}

impl FrameTimes {
    /// Notes a frame.
    pub(crate) fn push(&mut self, seconds: f32) {
        if self.whole.len() >= 120 {
            self.whole.remove(0);
        }
        self.whole.push(seconds);
    }

    /// Frames a second over the last frames.
    pub(crate) fn rate(&self) -> f32 {
        let sum: f32 = self.whole.iter().sum();
        if sum > 0.0 {
            self.whole.len() as f32 / sum
        } else {
            0.0
        }
    }
}

const INK: Color32 = Color32::from_rgb(226, 222, 208);
pub(crate) const DIM: Color32 = Color32::from_rgb(150, 148, 138);
pub(crate) const GOLD: Color32 = Color32::from_rgb(236, 196, 110);

/// Colours and spacing.
pub(crate) fn style(context: &Context) {
    context.all_styles_mut(|style| {
        let mut v = egui::Visuals::dark();
        v.override_text_color = Some(INK);
        let panel = Color32::from_rgba_unmultiplied(18, 18, 24, 238);
        v.window_fill = panel;
        v.panel_fill = panel;
        v.window_stroke = egui::Stroke::new(1.0, Color32::from_rgb(70, 62, 44));
        v.selection.bg_fill = Color32::from_rgb(112, 86, 34);
        v.widgets.hovered.bg_fill = Color32::from_rgb(70, 60, 40);
        v.window_shadow = egui::Shadow::NONE;
        style.visuals = v;
        style.spacing.item_spacing = egui::vec2(6.0, 3.0);
        // Panels are read while walking: nothing is to be selected by accident.
        style.interaction.selectable_labels = false;
    });
}

/// Everything over the picture.
pub(crate) fn show(context: &Context, explorer: &mut Explorer, times: &FrameTimes) {
    if let Some(camera) = explorer.camera() {
        marks(context, &explorer.marks(), camera.viewport());
    }
    let size = context.content_rect().size();
    if !layout::fits(size) {
        return;
    }
    // Keys are read better with nothing behind them.
    let covered = explorer.show_help && size.x < 1500.0;
    if !covered && layout::fits_panels(size) {
        side_panels(context, explorer, times, &Room::of(size, explorer));
    }
    if explorer.show_help {
        key_list::show(context, explorer);
    }
    typing(context, explorer);
    notices(context, explorer);
}

/// A few words in a colour, behind a patch of it.
fn patch(ui: &mut Ui, [r, g, b]: [u8; 3], text: &str) {
    ui.horizontal(|ui| {
        ui.add_space(14.0);
        let (rect, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), egui::Sense::hover());
        ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(r, g, b));
        ui.label(RichText::new(text).color(DIM).size(12.0));
    });
}

fn marks(context: &Context, marks: &[Mark], viewport: glam::Vec2) {
    let layer = egui::LayerId::new(egui::Order::Background, egui::Id::unique("overlays"));
    let painter = context.layer_painter(layer);
    // The picture may have another resolution than the window.
    let size = context.content_rect().size();
    let (sx, sy) = (size.x / viewport.x, size.y / viewport.y);
    let at = |p: &glam::Vec2| egui::pos2(p.x * sx, p.y * sy);
    let mut labels: Vec<egui::Rect> = Vec::new();
    // Words last, so that no line goes through them.
    let (words, shapes): (Vec<&Mark>, Vec<&Mark>) =
        marks.iter().partition(|m| matches!(m, Mark::Label { .. }));
    for mark in shapes.into_iter().chain(words) {
        match mark {
            Mark::Line { a, b, color, width } => {
                let [r, g, b_, a_] = *color;
                let stroke = egui::Stroke::new(*width, Color32::from_rgba_unmultiplied(r, g, b_, a_));
                painter.line_segment([at(a), at(b)], stroke);
            }
            Mark::Area { points, color } => {
                let [r, g, b, a] = *color;
                painter.add(egui::Shape::convex_polygon(
                    points.iter().map(at).collect(),
                    Color32::from_rgba_unmultiplied(r, g, b, a),
                    egui::Stroke::NONE,
                ));
            }
            Mark::Label {
                at: place,
                text,
                color,
            } => {
                let [r, g, b] = *color;
                let font = egui::FontId::proportional(13.0);
                let galley = painter.layout_no_wrap(text.clone(), font, Color32::from_rgb(r, g, b));
                let rect = Align2::CENTER_CENTER
                    .anchor_size(at(place), galley.size())
                    .expand(2.0);
                // Labels that would cover another are left out.
                if labels.iter().any(|l| l.intersects(rect)) {
                    continue;
                }
                labels.push(rect);
                painter.rect_filled(rect, 3.0, Color32::from_black_alpha(165));
                painter.galley(rect.min + egui::vec2(2.0, 2.0), galley, INK);
            }
        }
    }
}

fn side_panels(context: &Context, explorer: &mut Explorer, times: &FrameTimes, room: &Room) {
    if explorer.show_panels {
        where_panel(context, explorer, room);
        view_panel(context, explorer, times, room);
    }
    if explorer.show_map {
        sidemap::show(context, explorer, room.map);
    }
    if explorer.picked.is_some() {
        picked_panel(context, explorer, room);
    }
}

fn row(ui: &mut Ui, name: &str, value: impl Into<String>) {
    ui.label(RichText::new(name).color(DIM));
    ui.label(value.into());
    ui.end_row();
}

fn named(explorer: &Explorer, cell: CellId) -> String {
    match explorer.name_of(cell) {
        Some(name) => format!("{cell}  {name}"),
        None => cell.to_string(),
    }
}

fn heading(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).color(GOLD).strong());
}

fn where_panel(context: &Context, explorer: &Explorer, room: &Room) {
    let window = egui::Window::new("Where").anchor(Align2::LEFT_TOP, [10.0, 10.0]);
    window
        .resizable(false)
        .default_size([room.side, room.place + Room::FRAME])
        .show(context, |ui| {
            scrolled(ui, room.side, room.place, |ui| where_rows(ui, explorer));
        });
}

fn where_rows(ui: &mut Ui, explorer: &Explorer) {
    let grid = |ui: &mut Ui, id: &str, rows: &mut dyn FnMut(&mut Ui)| {
        egui::Grid::new(id).num_columns(2).show(ui, |ui| rows(ui));
    };
    heading(ui, "player");
    grid(ui, "player", &mut |ui| {
        row(ui, "cell", named(explorer, explorer.player_cell()));
        if let Some(body) = explorer.body() {
            let o = body.position().origin();
            row(ui, "position", format!("{:.3}  {:.3}  {:.3}", o.x, o.y, o.z));
            if !body.position().cell.is_indoor() {
                row(ui, "map", MapCoordinates::of(body.position()).to_string());
            }
            let v = body.velocity.length().max(body.cached_velocity.length());
            row(ui, "speed", format!("{v:.2} m/s"));
            let contact = body.contact.map(|c| c.plane.normal);
            let contact = contact.map_or("in the air".to_owned(), |n| {
                let walkable = if body.is_on_walkable() {
                    "walkable"
                } else {
                    "too steep"
                };
                format!("{:.2} {:.2} {:.2}  {walkable}", n.x, n.y, n.z)
            });
            row(ui, "contact", contact);
            let touching = body.touching().len();
            let shadows = body.shadow_cells().len();
            row(ui, "listed in", format!("{shadows} cells, touching {touching}"));
            if let Some(closed) = explorer.door_within_reach() {
                let told = if closed {
                    "closed: F opens it"
                } else {
                    "open: F closes it"
                };
                row(ui, "door", told);
            }
        }
    });
    heading(ui, "viewer");
    grid(ui, "viewer", &mut |ui| {
        if let Some(viewer) = explorer.viewer() {
            let cell = viewer.cell.map_or("lost".to_owned(), |c| named(explorer, c.0));
            row(ui, "cell", cell);
            let how = match viewer.source {
                vestibule_view::ViewerSource::Swept => "swept from the head",
                vestibule_view::ViewerSource::Adjusted => "sweep failed: adjusted",
                _ => "sweep failed: at the player",
            };
            row(ui, "found by", how);
        }
        let path = match explorer.frame().path() {
            FramePath::Outdoors => "outdoors",
            FramePath::SeesOut => "a room that sees out",
            FramePath::Sealed => "a sealed room",
            _ => "nothing to draw",
        };
        row(ui, "path", path);
    });
    cell_facts(ui, explorer);
}

fn cell_facts(ui: &mut Ui, explorer: &Explorer) {
    let Some(cell) = explorer.world().env_cell(explorer.player_cell()) else {
        return;
    };
    egui::CollapsingHeader::new("this cell").show(ui, |ui| {
        egui::Grid::new("cell").num_columns(2).show(ui, |ui| {
            let s = &cell.structure;
            row(ui, "structure", format!("0x{:08X} / {}", s.environment, s.key));
            row(ui, "sees outside", if cell.seen_outside { "yes" } else { "no" });
            row(ui, "stab list", format!("{} cells", cell.stab_list.len()));
            for portal in &cell.portals {
                let to = match portal.other {
                    PortalTarget::Outside => "outside".to_owned(),
                    PortalTarget::Cell(id) => named(explorer, id),
                };
                row(ui, &format!("portal {}", portal.record_index), to);
            }
        });
    });
}

fn view_panel(context: &Context, explorer: &mut Explorer, times: &FrameTimes, room: &Room) {
    let window = egui::Window::new("View").anchor(Align2::RIGHT_TOP, [-10.0, 10.0]);
    window
        .resizable(false)
        .default_size([room.side, room.view + Room::FRAME])
        .show(context, |ui| {
            scrolled(ui, room.side, room.view, |ui| view_rows(ui, explorer, times));
        });
}

fn view_rows(ui: &mut Ui, explorer: &mut Explorer, times: &FrameTimes) {
    heading(ui, "show");
    ui.horizontal(|ui| {
        for (show, name) in [
            (Show::Reached, "reached"),
            (Show::SingleCell, "one cell"),
            (Show::Everything, "everything"),
        ] {
            if ui.selectable_label(explorer.show == show, name).clicked() {
                explorer.show = show;
            }
        }
    });
    for (k, overlay) in Overlay::ALL.iter().enumerate() {
        ui.checkbox(
            &mut explorer.overlays[k],
            format!("{}  {}", k + 1, overlay.name()),
        );
        if explorer.overlays[k] {
            for (color, text) in overlay.legend() {
                patch(ui, color, text);
            }
        }
    }
    let frozen = explorer.is_frozen();
    if ui
        .selectable_label(frozen, "G  hold the traversal and fly")
        .clicked()
    {
        explorer.act(Action::Freeze);
    }
    ui.horizontal(|ui| {
        ui.label(RichText::new(clock(explorer.time_of_day)).color(DIM));
        ui.add(egui::Slider::new(&mut explorer.time_of_day, 0.0..=0.999).show_value(false));
    });
    draw_list(ui, explorer);
    heading(ui, "frame times");
    frame_times(ui, times);
    ui.label(RichText::new("H  all keys").color(DIM));
}

fn frame_times(ui: &mut Ui, times: &FrameTimes) {
    egui::Grid::new("times").num_columns(2).show(ui, |ui| {
        let newest = times.whole.last().copied().unwrap_or_default();
        let rate = format!("{:.0} a second, this one {:.0} ms", times.rate(), newest * 1e3);
        row(ui, "frames", rate);
        let ms = format!(
            "{:.2} ms; {:.2} ms to submit",
            times.decide * 1e3,
            times.submit * 1e3
        );
        row(ui, "decided in", ms);
        row(
            ui,
            "drawn",
            format!("{} draws, {} triangles", times.draws, times.triangles),
        );
    });
    ui.label(RichText::new(&times.adapter).color(DIM).size(11.0));
    let (rect, _) = ui.allocate_exact_size(
        egui::vec2(ui.available_width().clamp(40.0, 240.0), 24.0),
        egui::Sense::hover(),
    );
    let painter = ui.painter();
    painter.rect_filled(rect, 2.0, Color32::from_black_alpha(90));
    for (k, seconds) in times.whole.iter().rev().enumerate() {
        let height = (seconds / 0.05 * rect.height()).min(rect.height());
        let x = rect.right() - k as f32 * 2.0;
        if x < rect.left() {
            break;
        }
        let color = if *seconds < 0.020 {
            Color32::from_rgb(90, 180, 90)
        } else {
            GOLD
        };
        let line = [
            egui::pos2(x, rect.bottom()),
            egui::pos2(x, rect.bottom() - height),
        ];
        painter.line_segment(line, egui::Stroke::new(1.5, color));
    }
}

fn draw_list(ui: &mut Ui, explorer: &mut Explorer) {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for command in explorer.frame().commands() {
        let name = match command {
            Command::Terrain(_) => "land cells",
            Command::TerrainBlock { .. } => "distant blocks",
            Command::Building { .. } => "buildings",
            Command::Room { .. } => "rooms",
            Command::Object { .. } => "objects",
            Command::Punch { .. } => "punches",
            Command::Seal { .. } => "seals",
            _ => continue,
        };
        *counts.entry(name).or_default() += 1;
    }
    let summary: Vec<String> = counts.iter().map(|(name, n)| format!("{n} {name}")).collect();
    heading(ui, "draw list of the traversal");
    ui.label(RichText::new(summary.join(", ")).color(DIM));
    let path = match explorer.frame().path() {
        FramePath::Outdoors => {
            "The landscape first, then into doors: a punch makes room for what is behind one."
        }
        FramePath::SeesOut => {
            "The landscape first, within the exits; then the depth is cleared and each exit sealed."
        }
        FramePath::Sealed => "Rooms only, from the farthest to the nearest; no landscape.",
        _ => "Nothing: the eye is in no cell.",
    };
    ui.label(RichText::new(path).color(DIM).size(12.0));
    let mut wanted = None;
    egui::CollapsingHeader::new("rooms and their portals").show(ui, |ui| {
        let frame = explorer.frame();
        let Some(camera) = frame.camera() else { return };
        for (k, flood) in frame.floods().iter().enumerate() {
            for seen in flood.cells() {
                let [r, g, b] = cell_color(seen.id);
                let title = format!(
                    "{}  ({} views)",
                    named(explorer, seen.id),
                    flood.regions(seen).len()
                );
                let title = RichText::new(title).color(Color32::from_rgb(r, g, b));
                let Some(cell) = explorer.world().env_cell(seen.id) else {
                    continue;
                };
                egui::CollapsingHeader::new(title)
                    .id_salt((k, seen.id.0))
                    .show(ui, |ui| {
                        for portal in &cell.portals {
                            let v = portals::verdict(explorer.world(), camera, &flood, seen, cell, portal);
                            let [r, g, b] = v.color();
                            let text = format!("portal {}: {}", portal.record_index, v.text());
                            ui.label(RichText::new(text).color(Color32::from_rgb(r, g, b)));
                        }
                        if ui.small_button("draw only this").clicked() {
                            wanted = Some(seen.id);
                        }
                    });
            }
        }
    });
    if let Some(cell) = wanted {
        explorer.single = Some(cell);
        explorer.show = Show::SingleCell;
    }
    let c = explorer.frame().counters();
    let odd = [
        ("dead portals", c.flood.dead_portals),
        ("dead doors", c.dead_doors),
        ("truncated", c.truncated),
    ];
    let odd: Vec<String> = odd
        .iter()
        .filter(|(_, n)| *n > 0)
        .map(|(name, n)| format!("{n} {name}"))
        .collect();
    if !odd.is_empty() {
        ui.label(
            RichText::new(odd.join(", "))
                .color(Color32::from_rgb(255, 150, 90))
                .small(),
        );
    }
}

fn picked_panel(context: &Context, explorer: &mut Explorer, room: &Room) {
    let Some(picked) = explorer.picked.clone() else {
        return;
    };
    let mut open = true;
    let mut go = None;
    let window = egui::Window::new("What is this?").anchor(Align2::LEFT_BOTTOM, [10.0, -10.0]);
    window.resizable(false).open(&mut open).show(context, |ui| {
        scrolled(ui, room.side + 60.0, room.picked, |ui| {
            heading(ui, &picked.what);
            egui::Grid::new("picked").num_columns(2).show(ui, |ui| {
                for (name, value) in &picked.facts {
                    row(ui, name, value.clone());
                }
                if let Some(name) = picked.cell.and_then(|c| explorer.name_of(c)) {
                    row(ui, "called", name);
                }
            });
            if !picked.portals.is_empty() {
                heading(ui, "seen through, from the eye");
            }
            for p in &picked.portals {
                let [r, g, b] = p.verdict.color();
                let to = portals::leads_to(p.to);
                let text = format!(
                    "{:04X} to {to}, {:.1} m: {}",
                    p.from.low(),
                    p.distance,
                    p.verdict.text()
                );
                ui.label(RichText::new(text).color(Color32::from_rgb(r, g, b)));
            }
            if let Some(cell) = picked.cell
                && ui.button("go there").clicked()
            {
                go = Some(cell);
            }
        });
    });
    if let Some(cell) = go {
        explorer.teleport(&cell.to_string());
    }
    if !open {
        explorer.picked = None;
    }
}

fn typing(context: &Context, explorer: &mut Explorer) {
    let Some(mut text) = explorer.typing.take() else {
        return;
    };
    let mut wanted: Option<String> = None;
    let mut cancelled = false;
    let size = context.content_rect().size();
    let wide = size.x - 60.0;
    let high = (size.y - 180.0).clamp(20.0, 220.0);
    let window = egui::Window::new("Go to").anchor(Align2::CENTER_TOP, [0.0, 60.0]);
    window.resizable(false).collapsible(false).show(context, |ui| {
        ui.label(RichText::new("a position, 42.1N 33.6E, a cell or a name").color(DIM));
        let edit = ui.add(
            egui::TextEdit::singleline(&mut text).desired_width(if wide < 360.0 { wide } else { 360.0 }),
        );
        edit.request_focus();
        ui.input(|i| {
            if i.key_pressed(egui::Key::Enter) {
                wanted = Some(text.clone());
            }
            cancelled = i.key_pressed(egui::Key::Escape);
        });
        let lower = text.to_lowercase();
        let names = explorer
            .names
            .iter()
            .filter(|n| n.name.to_lowercase().contains(&lower));
        egui::ScrollArea::vertical().max_height(high).show(ui, |ui| {
            for place in names.take(200) {
                if ui.selectable_label(false, &place.name).clicked() {
                    wanted = Some(place.name.clone());
                }
            }
        });
    });
    match wanted {
        Some(text) => explorer.teleport(&text),
        None if !cancelled => explorer.typing = Some(text),
        None => {}
    }
}

fn notices(context: &Context, explorer: &Explorer) {
    let Some(text) = explorer.message() else { return };
    let area = egui::Area::new(egui::Id::unique("message")).anchor(Align2::CENTER_BOTTOM, [0.0, -24.0]);
    let area = area.order(egui::Order::Foreground);
    area.interactable(false).show(context, |ui| {
        egui::Frame::new()
            .fill(Color32::from_black_alpha(190))
            .corner_radius(4.0)
            .inner_margin(8.0)
            .show(ui, |ui| {
                // As wide as its words, as far as the window goes.
                let most = context.content_rect().width() - 40.0;
                let font = egui::FontId::proportional(15.0);
                let galley =
                    ui.painter()
                        .layout(text.to_owned(), font, INK, if most > 60.0 { most } else { 60.0 });
                ui.label(galley)
            });
    });
}

/// What is shown while a world is loading.
pub(crate) fn loading(context: &Context, what: &str, share: f32) {
    let size = context.content_rect().size();
    if !layout::fits(size) {
        return;
    }
    let area = egui::Area::new(egui::Id::unique("loading")).anchor(Align2::CENTER_CENTER, [0.0, 0.0]);
    area.show(context, |ui| {
        ui.set_width(if size.x < 400.0 { size.x - 40.0 } else { 360.0 });
        ui.vertical_centered(|ui| {
            ui.label(RichText::new("Vestibule").size(30.0).color(GOLD));
            ui.label(what);
            ui.add(egui::ProgressBar::new(share).fill(Color32::from_rgb(112, 86, 34)));
        });
    });
}

/// What is shown when a world cannot be explored.
pub(crate) fn failed(context: &Context, why: &str) {
    let size = context.content_rect().size();
    if !layout::fits(size) {
        return;
    }
    let area = egui::Area::new(egui::Id::unique("failed")).anchor(Align2::CENTER_CENTER, [0.0, 0.0]);
    area.show(context, |ui| {
        ui.set_width(if size.x < 600.0 { size.x - 40.0 } else { 560.0 });
        ui.vertical_centered(|ui| {
            ui.label(RichText::new("Vestibule").size(30.0).color(GOLD));
            ui.label("This world cannot be explored:");
            ui.label(why);
            ui.label(RichText::new("Esc leaves").color(DIM));
        });
    });
}

#[cfg(test)]
mod tests;
