//! The screen as a picture: the regions through which each cell is seen, labelled.

use std::fmt::Write;

use glam::Vec2;
use vestibule_view::{Camera, Command, FrameView, Region};
use vestibule_world::CellId;

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
    let mut labels: Vec<(Vec2, f32, CellId)> = Vec::new();
    for command in frame.commands() {
        let Command::Room { cell, views } = command else {
            continue;
        };
        for region in frame.regions(*views) {
            let area = region.pixel_area(camera);
            regions.push((area, Some(*cell), region));
            let points = corners(region, camera);
            let middle = points.iter().copied().sum::<Vec2>() / points.len().max(1) as f32;
            match labels.iter_mut().find(|(_, _, known)| known == cell) {
                Some(label) if label.1 < area => *label = (middle, area, *cell),
                Some(_) => {}
                None => labels.push((middle, area, *cell)),
            }
        }
    }
    regions.sort_by(|a, b| b.0.total_cmp(&a.0));
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
        let size = (area.sqrt() / 8.0).clamp(9.0, 22.0);
        let mut at = at.clamp(Vec2::splat(20.0), camera.viewport() - 20.0);
        while placed
            .iter()
            .any(|p| (p.x - at.x).abs() < 60.0 && (p.y - at.y).abs() < 18.0)
        {
            at.y += 18.0;
        }
        placed.push(at);
        let low = cell.low();
        let _ = writeln!(
            body,
            r##"<text x="{:.0}" y="{:.0}" font-size="{size:.0}" text-anchor="middle" fill="#222" stroke="#fff" stroke-width="3" paint-order="stroke">{low:04X}</text>"##,
            at.x, at.y
        );
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} \
         {height:.0}\" font-family=\"Helvetica,Arial,sans-serif\" font-weight=\"bold\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#2b2b30\"/>\n{body}</svg>\n"
    )
}

/// A region's corners on the screen; the whole screen where it has none.
fn corners(region: Region<'_>, camera: &Camera) -> Vec<Vec2> {
    if region.edges().is_empty() {
        let v = camera.viewport();
        return vec![Vec2::ZERO, Vec2::new(v.x, 0.0), v, Vec2::new(0.0, v.y)];
    }
    region.pixels(camera).collect()
}
