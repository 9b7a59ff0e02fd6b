//! The land of a plan: terrain, water, roads, buildings.

use glam::{Vec2, Vec3};
use vestibule_world::constants::BLOCK_LENGTH;
use vestibule_world::terrain::{TerrainPolygon, vertex_index};
use vestibule_world::{CellId, Land, Landblock, Water, World};

use super::svg::{Panel, Svg, convex_hull};
use super::{draw_statics, draw_trail};
use crate::count;
use crate::locate::terrain_name;
use crate::route;

/// How much of the neighbouring landblocks is shown, metres.
const BORDER: f32 = 6.0;

pub(super) fn draw(svg: &mut Svg, world: &World, block: &Landblock, trail: &[(CellId, Vec3)]) {
    let Some(land) = &block.land else { return };
    let (low, high) = range(land);
    let step = contour_step(high - low);
    let heading = format!(
        "Land: {low:.0} to {high:.0} m, contours every {step} m, {}, {}",
        count(block.buildings.len(), "building"),
        count(block.land_statics as usize, "static object")
    );
    let (a, b) = (Vec2::splat(-BORDER), Vec2::splat(BLOCK_LENGTH + BORDER));
    let mut panel = svg.panel(&heading, a, b, 8.0);
    for (id, cell) in block.land_cells() {
        let words = corner_words(land, id);
        let kinds: Vec<&str> = words.iter().map(|w| terrain_name(w.terrain_type())).collect();
        let water = match cell.water {
            Water::Not => "",
            Water::Partially => ", partly water",
            Water::Entirely => ", water",
        };
        let title = format!("{id}: {}{water}", kinds.first().copied().unwrap_or(""));
        for polygon in &cell.polygons {
            let points: Vec<Vec2> = polygon.vertices.iter().map(|v| v.truncate()).collect();
            panel.filled(&points, "gr", &colour(polygon, land), &title);
        }
    }
    for (_, cell) in block.land_cells() {
        for polygon in &cell.polygons {
            contours(&mut panel, polygon, step);
        }
    }
    roads(&mut panel, land);
    for (id, _) in block.land_cells() {
        let index = f32::from(id.low() - 1);
        let corner = Vec2::new((index / 8.0).floor(), index % 8.0) * 24.0;
        panel.text(
            corner + Vec2::new(22.0, 1.6),
            "lid",
            9.0,
            &format!("{:02X}", id.low()),
        );
    }
    for (index, building) in block.buildings.iter().enumerate() {
        let title = format!(
            "building {index}, model 0x{:08X}, on {}",
            building.model_id, building.cell
        );
        for (part, frame) in building.shape.parts.iter().zip(&building.part_frames) {
            let Some(model) = &part.model else { continue };
            let vertices = model.polygons.all_vertices().iter();
            let hull = convex_hull(vertices.map(|&v| frame.local_to_global(v).truncate()).collect());
            panel.polygon(&hull, "bu", &title);
        }
    }
    draw_statics(&mut panel, block.statics.iter().take(block.land_statics as usize));
    for opening in route::entrances(world, block.id) {
        let corners: Vec<Vec2> = opening.corners.iter().map(|c| c.truncate()).collect();
        let title = format!(
            "portal {} of {}, {}",
            opening.id.portal,
            opening.id.cell,
            opening.in_words()
        );
        panel.line(&corners, "ex", &title);
    }
    draw_trail(&mut panel, trail, |cell, pos| {
        let inside = pos.truncate().cmpge(a).all() && pos.truncate().cmple(b).all();
        inside && (!cell.is_indoor() || cell.block() == block.id)
    });
    panel.furniture();
}

fn range(land: &Land) -> (f32, f32) {
    land.heights
        .iter()
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), &h| {
            (low.min(h), high.max(h))
        })
}

fn contour_step(range: f32) -> f32 {
    [1.0, 2.0, 5.0, 10.0, 20.0, 50.0]
        .into_iter()
        .find(|step| range / step <= 16.0)
        .unwrap_or(100.0)
}

fn corner_words(land: &Land, id: CellId) -> [vestibule_world::TerrainWord; 4] {
    let index = usize::from(id.low() - 1);
    let (cx, cy) = (index / 8, index % 8);
    [(cx, cy), (cx + 1, cy), (cx + 1, cy + 1), (cx, cy + 1)]
        .map(|(i, j)| land.words.get(vertex_index(i, j)).copied().unwrap_or_default())
}

/// Colour by terrain type, darker on slopes that turn away from a light in the north-west.
fn colour(polygon: &TerrainPolygon, land: &Land) -> String {
    let mut sum = Vec3::ZERO;
    for v in &polygon.vertices {
        let at = |m: f32| ((m / 24.0).round() as usize).min(8);
        let word = land
            .words
            .get(vertex_index(at(v.x), at(v.y)))
            .copied()
            .unwrap_or_default();
        sum += type_colour(word.terrain_type());
    }
    let light = Vec3::new(-0.4, 0.5, 0.77).dot(polygon.plane.normal);
    let [r, g, b] = (sum / 3.0 * (0.35 + 0.75 * light.max(0.0)))
        .min(Vec3::splat(255.0))
        .to_array();
    format!("#{:02x}{:02x}{:02x}", r as u8, g as u8, b as u8)
}

fn type_colour(terrain_type: u8) -> Vec3 {
    let [r, g, b] = match terrain_type {
        0 | 13 | 14 => [176, 168, 156],
        1 | 3 | 9 => [176, 205, 140],
        2 | 27 => [214, 234, 242],
        4 | 28 | 29 => [140, 165, 110],
        5 | 7 | 8 | 22 => [188, 160, 122],
        6 | 25 | 26 | 30 => [120, 112, 118],
        10..=12 => [226, 210, 160],
        15 => [240, 244, 247],
        16..=19 => [126, 178, 216],
        20 => [88, 138, 190],
        21 => [126, 160, 96],
        23 => [150, 180, 140],
        _ => [196, 186, 170],
    };
    Vec3::new(r as f32, g as f32, b as f32)
}

/// Lines of equal height across a triangle.
fn contours(panel: &mut Panel<'_>, polygon: &TerrainPolygon, step: f32) {
    let z = polygon.vertices.map(|v| v.z);
    let (low, high) = (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]));
    let mut level = (low / step).ceil() * step;
    // Heights come from a file: however steep, only so many lines.
    for _ in 0..200 {
        if level > high {
            break;
        }
        let mut ends: Vec<Vec2> = Vec::new();
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (polygon.vertices[a], polygon.vertices[b]);
            if (a.z < level) != (b.z < level) {
                ends.push(a.truncate().lerp(b.truncate(), (level - a.z) / (b.z - a.z)));
            }
        }
        let major = (level / step).round() as i64 % 5 == 0;
        panel.line(&ends, if major { "ci" } else { "co" }, "");
        level += step;
    }
}

/// Roads run between neighbouring vertices that both have one.
fn roads(panel: &mut Panel<'_>, land: &Land) {
    let has = |i: usize, j: usize| land.words.get(vertex_index(i, j)).is_some_and(|w| w.road() != 0);
    let at = |i: usize, j: usize| Vec2::new(i as f32, j as f32) * 24.0;
    for i in 0..9 {
        for j in 0..9 {
            if !has(i, j) {
                continue;
            }
            if i < 8 && has(i + 1, j) {
                panel.line(&[at(i, j), at(i + 1, j)], "ro", "road");
            }
            if j < 8 && has(i, j + 1) {
                panel.line(&[at(i, j), at(i, j + 1)], "ro", "road");
            }
        }
    }
}
