//! The screen as a picture: the regions through which each cell is seen, labelled.

use std::fmt::Write;

use glam::Vec2;
use vestibule_view::{Camera, Command, FrameView, Region};
use vestibule_world::CellId;

/// Regions smaller than this get no label, pixels.
const SMALLEST_LABELLED: f32 = 120.0;
/// Places tried along each side of a region for its label.
const SAMPLES: u32 = 24;

/// Draws the regions of a frame's rooms and of the outside over one another.
///
/// The camera must be the one of the frame. Rooms seen by way of buildings are drawn like all others.
pub fn picture(frame: &FrameView, camera: &Camera) -> String {
    let Vec2 { x: width, y: height } = camera.viewport();
    let mut body = String::new();
    let polygon = |body: &mut String, region: Region<'_>, style: &str, title: &str| {
        let points = corners(region, camera);
        if points.len() > 2 {
            let mut list = String::new();
            for p in &points {
                let _ = write!(list, "{:.1},{:.1} ", p.x, p.y);
            }
            let list = list.trim_end();
            let _ = writeln!(
                body,
                r#"<polygon points="{list}" {style}><title>{title}</title></polygon>"#
            );
        }
    };
    // Large regions first: what shows through them then lies on top.
    let mut regions: Vec<(f32, Option<CellId>, Region<'_>)> = frame
        .landscape_views()
        .map(|region| (region.pixel_area(camera), None, region))
        .collect();
    for command in frame.commands() {
        if let Command::Room { cell, views } = command {
            regions.extend(
                frame
                    .regions(*views)
                    .map(|region| (region.pixel_area(camera), Some(*cell), region)),
            );
        }
    }
    regions.sort_by(|a, b| b.0.total_cmp(&a.0));
    let shapes: Vec<Vec<Vec2>> = regions
        .iter()
        .map(|&(_, _, region)| corners(region, camera))
        .collect();
    // One label a cell, where the largest part of it lies open.
    let mut labels: Vec<(Vec2, f32, Option<CellId>)> = Vec::new();
    for (i, &(area, cell, _)) in regions.iter().enumerate() {
        if area < SMALLEST_LABELLED || labels.iter().any(|&(_, _, known)| known == cell) {
            continue;
        }
        if let Some(at) = open_place(&shapes, i) {
            labels.push((at, area, cell));
        }
    }
    for (_, cell, region) in regions {
        match cell {
            None => {
                let style = r##"fill="#bfe3ff" fill-opacity="0.8" stroke="#e07b00" stroke-width="3""##;
                polygon(&mut body, region, style, "the outside");
            }
            Some(cell) => {
                let hue = u32::from(cell.low()) * 137 % 360;
                let style = format!(
                    r#"fill="hsl({hue},55%,80%)" fill-opacity="0.7" stroke="hsl({hue},70%,28%)" stroke-width="1.5""#
                );
                polygon(&mut body, region, &style, &cell.to_string());
            }
        }
    }
    // Where regions cover one another, labels would too: each goes a line lower.
    let mut placed: Vec<Vec2> = Vec::new();
    for (at, area, cell) in labels {
        let size = (area.sqrt() / 8.0).clamp(9.0, 18.0);
        let mut at = at.clamp(Vec2::splat(20.0), camera.viewport() - 20.0);
        while placed
            .iter()
            .any(|p| (p.x - at.x).abs() < 60.0 && (p.y - at.y).abs() < 18.0)
        {
            at.y += 18.0;
        }
        placed.push(at);
        let text = cell.map_or_else(|| "outside".to_owned(), |cell| format!("{:04X}", cell.low()));
        let _ = writeln!(
            body,
            r##"<text x="{:.0}" y="{:.0}" font-size="{size:.0}" text-anchor="middle" fill="#222" stroke="#fff" stroke-width="3" paint-order="stroke">{text}</text>"##,
            at.x, at.y
        );
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} \
         {height:.0}\" font-family=\"Helvetica,Arial,sans-serif\" font-weight=\"bold\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#2b2b30\"/>\n{body}</svg>\n"
    )
}

/// The point of a shape that is farthest from its edges and from those of the shapes drawn over it, and not under
/// them; `None` where it does not show.
fn open_place(shapes: &[Vec<Vec2>], index: usize) -> Option<Vec2> {
    let (own, over) = (shapes.get(index)?, shapes.get(index + 1..)?);
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for &corner in own {
        (low, high) = (low.min(corner), high.max(corner));
    }
    let mut best: Option<(f32, Vec2)> = None;
    for (u, v) in (0..SAMPLES).flat_map(|u| (0..SAMPLES).map(move |v| (u, v))) {
        let share = (Vec2::new(u as f32, v as f32) + 0.5) / SAMPLES as f32;
        let at = low + (high - low) * share;
        if !holds(own, at) || over.iter().any(|shape| holds(shape, at)) {
            continue;
        }
        let room = core::iter::once(own)
            .chain(over)
            .map(|shape| distance_to_edges(shape, at))
            .fold(f32::INFINITY, f32::min);
        if best.is_none_or(|(most, _)| room > most) {
            best = Some((room, at));
        }
    }
    best.map(|(_, at)| at)
}

fn edges(shape: &[Vec2]) -> impl Iterator<Item = (Vec2, Vec2)> + '_ {
    let next = shape.iter().cycle().skip(1);
    shape.iter().copied().zip(next.copied())
}

/// Whether a polygon holds a point, by the crossings of a ray.
fn holds(shape: &[Vec2], at: Vec2) -> bool {
    let crossed = edges(shape).filter(|(a, b)| {
        (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossed.count() % 2 == 1
}

fn distance_to_edges(shape: &[Vec2], at: Vec2) -> f32 {
    let distance = |(a, b): (Vec2, Vec2)| {
        let along = ((at - a).dot(b - a) / (b - a).length_squared().max(1e-6)).clamp(0.0, 1.0);
        at.distance(a + (b - a) * along)
    };
    edges(shape).map(distance).fold(f32::INFINITY, f32::min)
}

/// A region's corners on the screen; the whole screen where it has none.
fn corners(region: Region<'_>, camera: &Camera) -> Vec<Vec2> {
    if region.edges().is_empty() {
        let v = camera.viewport();
        return vec![Vec2::ZERO, Vec2::new(v.x, 0.0), v, Vec2::new(0.0, v.y)];
    }
    region.pixels(camera).collect()
}
