//! A map of the landblock the player is in: rooms and openings from above, and clicks that go there.

use egui::{Align2, Color32, Context, Pos2, Stroke};
use glam::{Vec2, Vec3};
use vestibule_world::{CellId, EnvCell, PortalTarget, Position};

use crate::explorer::Explorer;
use crate::overlays::cell_color;

/// Metres across the map before it is zoomed, and the least and most of them.
const ACROSS: (f32, f32, f32) = (26.0, 8.0, 400.0);
/// Rooms this far above or below the player are drawn faintly, metres.
const STOREY: f32 = 2.6;

/// A room as the map shows it: the outline of its box, landblock metres.
fn outline(cell: &EnvCell) -> Option<([Vec2; 4], f32, f32)> {
    let b = cell.structure.bounds?;
    let corner = |x: f32, y: f32| cell.frame.local_to_global(Vec3::new(x, y, b.min.z));
    let corners = [
        corner(b.min.x, b.min.y),
        corner(b.max.x, b.min.y),
        corner(b.max.x, b.max.y),
        corner(b.min.x, b.max.y),
    ];
    let low = corners[0].z;
    Some((corners.map(|c| c.truncate()), low, low + b.max.z - b.min.z))
}

/// The room whose outline holds a point, the one nearest in height to `z`.
pub(crate) fn room_at<'a>(cells: impl Iterator<Item = &'a EnvCell>, at: Vec2, z: f32) -> Option<CellId> {
    let mut best: Option<(f32, CellId)> = None;
    for cell in cells {
        let Some((corners, low, high)) = outline(cell) else {
            continue;
        };
        let inside = (0..4).all(|k| (corners[(k + 1) % 4] - corners[k]).perp_dot(at - corners[k]) >= 0.0);
        let gap = if z < low {
            low - z
        } else if z > high {
            z - high
        } else {
            0.0
        };
        if inside && best.is_none_or(|b| gap < b.0) {
            best = Some((gap, cell.id));
        }
    }
    best.map(|b| b.1)
}

/// The map.
pub(crate) fn show(context: &Context, explorer: &mut Explorer, side: f32) {
    let kept = egui::Id::unique("metres across the map");
    let mut across: f32 = context.data(|d| d.get_temp(kept)).unwrap_or(ACROSS.0);
    let mut go: Option<Position> = None;
    let mut open = true;
    let window = egui::Window::new("Map").anchor(Align2::RIGHT_BOTTOM, [-10.0, -10.0]);
    let window = window.resizable(false).default_size([side, side]);
    window.open(&mut open).show(context, |ui| {
        ui.set_max_width(side);
        let size = egui::vec2(side, side);
        let (response, painter) = ui.allocate_painter(size, egui::Sense::click());
        let rect = response.rect;
        painter.rect_filled(rect, 3.0, Color32::from_rgb(34, 40, 32));
        let Some(body) = explorer.body() else { return };
        let (at, block_id) = (body.position().origin(), body.position().cell.block());
        let world = explorer.world().clone();
        let Some(block) = world.loaded_block(block_id) else {
            return;
        };
        if response.hovered() {
            let wheel = ui.input(|i| i.smooth_scroll_delta().y);
            across = (across * libm::powf(1.01, -wheel)).clamp(ACROSS.1, ACROSS.2);
        }
        // Around the player; north is up.
        let scale = side / across;
        let to = |p: Vec2| -> Pos2 {
            let d = (p - at.truncate()) * scale;
            rect.center() + egui::vec2(d.x, -d.y)
        };
        let back = |p: Pos2| -> Vec2 {
            let d = p - rect.center();
            at.truncate() + Vec2::new(d.x, -d.y) / scale
        };
        for k in 0..=8 {
            let line = k as f32 * 24.0;
            let stroke = Stroke::new(0.5, Color32::from_rgb(56, 62, 52));
            painter.line_segment([to(Vec2::new(line, 0.0)), to(Vec2::new(line, 192.0))], stroke);
            painter.line_segment([to(Vec2::new(0.0, line)), to(Vec2::new(192.0, line))], stroke);
        }
        let mut rooms: Vec<(&EnvCell, [Vec2; 4], f32, f32)> = block
            .env_cells()
            .filter_map(|c| outline(c).map(|(o, low, high)| (c, o, low, high)))
            .collect();
        rooms.sort_by(|a, b| a.2.total_cmp(&b.2));
        let level = at.z + 0.9;
        for (cell, corners, low, high) in &rooms {
            let near = *low - STOREY * 0.4 < level && level < *high + STOREY * 0.4;
            let seen = explorer.frame().floods().iter().any(|f| f.sees(cell.id));
            let [r, g, b] = cell_color(cell.id);
            let alpha = if near { 120 } else { 24 };
            let fill = Color32::from_rgba_unmultiplied(r, g, b, if seen { alpha + 60 } else { alpha });
            let line = Color32::from_rgba_unmultiplied(r, g, b, if near { 255 } else { 70 });
            let points = corners.iter().map(|c| to(*c)).collect();
            painter.add(egui::Shape::convex_polygon(points, fill, Stroke::new(1.0, line)));
            if !near {
                continue;
            }
            let middle = (corners[0] + corners[2]) * 0.5;
            let wide = (corners[2] - corners[0]).abs().min_element() * scale;
            if wide > 46.0 {
                let word = explorer.name_of(cell.id).and_then(|n| n.rsplit('.').next());
                let word = word.map_or_else(|| format!("{:04X}", cell.id.low()), str::to_owned);
                let font = egui::FontId::proportional(12.0);
                painter.text(to(middle), Align2::CENTER_CENTER, word, font, Color32::WHITE);
            }
            for portal in &cell.portals {
                let corners: Vec<Vec2> = cell
                    .portal_vertices(portal)
                    .iter()
                    .map(|v| cell.frame.local_to_global(*v).truncate())
                    .collect();
                let color = match portal.other {
                    PortalTarget::Outside => Color32::from_rgb(80, 190, 255),
                    PortalTarget::Cell(_) => Color32::WHITE,
                };
                if let (Some(a), Some(b)) = farthest(&corners) {
                    painter.line_segment([to(a), to(b)], Stroke::new(2.0, color));
                }
            }
        }
        let forward = body.position().frame.local_to_global_vec(Vec3::Y).truncate();
        let side = Vec2::new(forward.y, -forward.x);
        let me = at.truncate();
        let size = 7.0 / scale;
        let points = [me + forward * size * 1.6, me + side * size, me - side * size];
        let points = points.iter().map(|p| to(*p)).collect();
        painter.add(egui::Shape::convex_polygon(
            points,
            Color32::from_rgb(255, 214, 90),
            Stroke::new(1.0, Color32::BLACK),
        ));
        if let Some(viewer) = explorer.viewer() {
            let eye = at + body.position().offset_to(&viewer.position);
            painter.circle_stroke(to(eye.truncate()), 3.0, Stroke::new(1.5, Color32::WHITE));
        }
        if let Some(pointer) = response.hover_pos() {
            let place = back(pointer);
            let room = room_at(block.env_cells(), place, at.z);
            let land = block.land_cell_at(place.extend(0.0)).map(|(id, _)| id);
            if let Some(cell) = room.or(land) {
                let name = explorer
                    .name_of(cell)
                    .map(|n| format!("  {n}"))
                    .unwrap_or_default();
                let line =
                    egui::Rect::from_min_max(rect.left_bottom() - egui::vec2(0.0, 22.0), rect.right_bottom());
                painter.rect_filled(line, 0.0, Color32::from_black_alpha(170));
                painter.text(
                    rect.left_bottom() + egui::vec2(6.0, -6.0),
                    Align2::LEFT_BOTTOM,
                    format!("{cell}{name}"),
                    egui::FontId::proportional(12.0),
                    Color32::WHITE,
                );
                if response.clicked() {
                    go = match room {
                        Some(room) => crate::places::middle_of(&world, room),
                        None => {
                            let z = world.ground_at(cell, place.extend(0.0)).map_or(at.z, |g| g.z);
                            Some(Position::new(cell, place.extend(z)))
                        }
                    };
                }
            }
        }
    });
    context.data_mut(|d| d.insert_temp(kept, across));
    if let Some(position) = go {
        explorer.go_to(&position);
    }
    explorer.show_map &= open;
}

/// The two points of a set that lie farthest apart.
fn farthest(points: &[Vec2]) -> (Option<Vec2>, Option<Vec2>) {
    let mut best = (0.0, None, None);
    for (k, &a) in points.iter().enumerate() {
        for &b in &points[k + 1..] {
            let d = (b - a).length_squared();
            if d > best.0 {
                best = (d, Some(a), Some(b));
            }
        }
    }
    (best.1, best.2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hollow;

    #[test]
    fn a_click_finds_the_room_of_the_players_storey() {
        let (world, names) = hollow();
        let block = world.block(vestibule_world::BlockId(0xA9B4)).unwrap();
        for name in ["cottage.cellar", "cottage.hall"] {
            let place = names.iter().find(|n| n.name == name).unwrap().position;
            let found = room_at(
                block.env_cells(),
                place.origin().truncate(),
                place.origin().z + 0.5,
            );
            assert_eq!(found, Some(place.cell), "{name}");
        }
        assert_eq!(room_at(block.env_cells(), Vec2::new(-50.0, -50.0), 94.0), None);
    }
}
