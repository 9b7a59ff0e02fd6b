//! Env cells of a plan, level by level.

use std::collections::BTreeSet;

use glam::{Vec2, Vec3};
use vestibule_world::constants::FLOOR_Z;
use vestibule_world::{CellId, EnvCell, Landblock, PortalTarget, World};

use super::svg::Svg;
use super::{draw_statics, draw_trail};
use crate::count;
use crate::route::{self, Opening};

/// Cells whose lowest points are at most this much apart are on one level, metres.
const LEVEL_HEIGHT: f32 = 1.6;
/// Cells farther apart than this over the ground go to panels of their own, metres.
const APART: f32 = 12.0;

/// Cells with less floor than this go with a larger neighbour, square metres.
const NICHE: f32 = 3.0;

/// A cell with what is drawn of it, in the frame of its landblock.
struct Room<'w> {
    cell: &'w EnvCell,
    floors: Vec<Vec<Vec2>>,
    /// Faces that look up and cannot be stood on.
    slopes: Vec<Vec<Vec2>>,
    walls: Vec<[Vec2; 2]>,
    openings: Vec<Opening>,
    low: Vec3,
    high: Vec3,
    label: Vec2,
    /// Area of the floors, square metres.
    area: f32,
    /// Height that decides on which level it is drawn, metres.
    level: f32,
}

pub(super) fn draw(svg: &mut Svg, world: &World, block: &Landblock, trail: &[(CellId, Vec3)]) {
    let mut rooms: Vec<Room<'_>> = block.env_cells().filter_map(|cell| room(world, cell)).collect();
    attach_niches(&mut rooms);
    rooms.sort_by(|a, b| a.level.total_cmp(&b.level).then(a.cell.id.cmp(&b.cell.id)));
    let mut levels: Vec<Vec<Room<'_>>> = Vec::new();
    for room in rooms {
        let fits = levels
            .last()
            .and_then(|l| l.first())
            .is_some_and(|first| room.level - first.level <= LEVEL_HEIGHT);
        match levels.last_mut() {
            Some(level) if fits => level.push(room),
            _ => levels.push(vec![room]),
        }
    }
    let total = levels.len();
    // From the top down, as one goes down into a cellar.
    for (number, level) in levels.into_iter().enumerate().rev() {
        for group in apart(level) {
            draw_group(svg, block, &group, number + 1, total, trail);
        }
    }
}

/// Windows and other niches are drawn with the room they belong to.
fn attach_niches(rooms: &mut [Room<'_>]) {
    let known: Vec<(CellId, f32, f32, f32)> = rooms
        .iter()
        .map(|room| (room.cell.id, room.area, room.low.z, room.high.z))
        .collect();
    for room in rooms.iter_mut().filter(|room| room.area < NICHE) {
        let host = room.openings.iter().find_map(|opening| match opening.to {
            PortalTarget::Cell(other) => known.iter().find(|(id, area, low, high)| {
                *id == other && *area > NICHE && (*low..*high).contains(&room.low.z)
            }),
            PortalTarget::Outside => None,
        });
        if let Some((_, _, low, _)) = host {
            room.level = *low;
        }
    }
}

/// Splits cells into groups with room between them.
fn apart(rooms: Vec<Room<'_>>) -> Vec<Vec<Room<'_>>> {
    let near = |a: &Room<'_>, b: &Room<'_>| {
        a.low.x - b.high.x < APART
            && b.low.x - a.high.x < APART
            && a.low.y - b.high.y < APART
            && b.low.y - a.high.y < APART
    };
    let mut groups: Vec<Vec<Room<'_>>> = Vec::new();
    for room in rooms {
        let (touching, mut rest): (Vec<_>, Vec<_>) = groups
            .into_iter()
            .partition(|group| group.iter().any(|other| near(&room, other)));
        let mut joined: Vec<Room<'_>> = touching.into_iter().flatten().collect();
        joined.push(room);
        rest.push(joined);
        groups = rest;
    }
    for group in &mut groups {
        group.sort_by_key(|room| room.cell.id);
    }
    groups.sort_by_key(|group| group.first().map(|room| room.cell.id));
    groups
}

fn draw_group(
    svg: &mut Svg,
    block: &Landblock,
    rooms: &[Room<'_>],
    number: usize,
    total: usize,
    trail: &[(CellId, Vec3)],
) {
    let mut low = Vec3::splat(f32::INFINITY);
    let mut high = Vec3::splat(f32::NEG_INFINITY);
    for room in rooms {
        low = low.min(room.low);
        high = high.max(room.high);
    }
    let floor_low = rooms.iter().map(|room| room.level).fold(f32::INFINITY, f32::min);
    let floor_high = rooms.iter().map(|room| room.level).fold(floor_low, f32::max);
    let floors = if floor_high - floor_low < 0.1 {
        format!("{floor_low:.2} m")
    } else {
        format!("{floor_low:.2} to {floor_high:.2} m")
    };
    let heading = format!(
        "Level {number} of {total}: floor at {floors}, {}",
        count(rooms.len(), "cell")
    );
    let edge = Vec2::splat(1.2);
    let mut panel = svg.panel(&heading, low.truncate() - edge, high.truncate() + edge, 46.0);
    let ids: BTreeSet<CellId> = rooms.iter().map(|room| room.cell.id).collect();
    for room in rooms {
        // Neighbouring numbers get colours far apart.
        let hue = u32::from(room.cell.id.low()) * 137 % 360;
        let light = if room.cell.seen_outside { 90 } else { 82 };
        let sees = if room.cell.seen_outside {
            "sees the outside"
        } else {
            "sealed"
        };
        let title = format!("{}, {sees}", room.cell.id);
        for slope in &room.slopes {
            panel.filled(
                slope,
                "fl",
                &format!("hsl({hue},30%,72%)"),
                &format!("{title}, too steep to stand on"),
            );
        }
        for floor in &room.floors {
            panel.filled(floor, "fl", &format!("hsl({hue},45%,{light}%)"), &title);
        }
    }
    for room in rooms {
        for wall in &room.walls {
            panel.line(wall, "wa", "");
        }
        let range = room.cell.statics.start as usize..room.cell.statics.end as usize;
        draw_statics(&mut panel, block.statics.get(range).unwrap_or(&[]).iter());
    }
    for room in rooms {
        for opening in &room.openings {
            let outside = opening.to == PortalTarget::Outside;
            let corners: Vec<Vec2> = opening.corners.iter().map(|c| c.truncate()).collect();
            let to = match opening.to {
                PortalTarget::Outside => "the outside".to_owned(),
                PortalTarget::Cell(cell) => cell.to_string(),
            };
            let title = format!(
                "{} portal {} to {to}: {}",
                opening.id.cell,
                opening.id.portal,
                opening.in_words()
            );
            if opening.is_flat() {
                panel.polygon(&corners, if outside { "skylight" } else { "hole" }, &title);
            } else if let Some(ends) = ends_of(&corners) {
                panel.line(&ends, if outside { "ex" } else { "po" }, &title);
            }
        }
    }
    draw_trail(&mut panel, trail, |cell, pos| {
        let near = pos.truncate().cmpge(low.truncate() - edge).all()
            && pos.truncate().cmple(high.truncate() + edge).all();
        let outdoors_here = !cell.is_indoor() && near && pos.z > low.z - 1.0 && pos.z < low.z + 2.5;
        ids.contains(&cell) || outdoors_here
    });
    let size = (panel.scale() * 0.55).clamp(6.5, 15.0);
    for room in rooms {
        panel.text(room.label, "id", size, &format!("{:04X}", room.cell.id.low()));
    }
    panel.furniture();
}

fn room<'w>(world: &World, cell: &'w EnvCell) -> Option<Room<'w>> {
    let structure = &cell.structure;
    let bounds = structure.bounds?.mapped(|p| cell.frame.local_to_global(p));
    let mut floors: Vec<Vec<Vec2>> = Vec::new();
    let mut slopes: Vec<Vec<Vec2>> = Vec::new();
    let mut walls = Vec::new();
    for polygon in structure.polygons.polygons() {
        if structure.portal_polygons.contains(&polygon.id) {
            continue;
        }
        let normal = cell.frame.local_to_global_vec(polygon.plane.normal);
        let corners = structure.polygons.vertices(polygon).iter();
        let corners: Vec<Vec2> = corners
            .map(|&v| cell.frame.local_to_global(v).truncate())
            .collect();
        if normal.z >= FLOOR_Z {
            floors.push(corners);
        } else if normal.z > 0.05 {
            slopes.push(corners);
        } else if normal.z.abs() < 0.3 {
            walls.extend(ends_of(&corners));
        }
    }
    let middle = ((bounds.min + bounds.max) / 2.0).truncate();
    let area = |points: &[Vec2]| {
        let mut sum = 0.0;
        for (i, a) in points.iter().enumerate() {
            let b = points.get((i + 1) % points.len()).copied().unwrap_or(*a);
            sum += a.perp_dot(b);
        }
        sum.abs() / 2.0
    };
    let largest = floors.iter().max_by(|a, b| area(a).total_cmp(&area(b)));
    let label = largest.map_or(middle, |f| {
        f.iter().copied().sum::<Vec2>() / f.len().max(1) as f32
    });
    let openings = route::openings(world, cell.id);
    let (area, level) = (floors.iter().map(|f| area(f)).sum(), bounds.min.z);
    Some(Room {
        cell,
        floors,
        slopes,
        walls,
        openings,
        low: bounds.min,
        high: bounds.max,
        label,
        area,
        level,
    })
}

/// The two corners that are farthest apart, if they are apart at all.
fn ends_of(corners: &[Vec2]) -> Option<[Vec2; 2]> {
    let mut best: Option<([Vec2; 2], f32)> = None;
    for (i, &a) in corners.iter().enumerate() {
        for &b in corners.iter().skip(i + 1) {
            let length = a.distance_squared(b);
            if length > 1e-4 && best.is_none_or(|(_, most)| length > most) {
                best = Some(([a, b], length));
            }
        }
    }
    best.map(|(ends, _)| ends)
}
