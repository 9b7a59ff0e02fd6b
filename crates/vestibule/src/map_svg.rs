//! Plans of landblocks as SVG: the land, and the env cells level by level.
//!
//! A plan has one panel for the land with its buildings, and one for each level of env cells: rooms, walls, openings,
//! static objects, and a trail where one is given. North is up; scales are in metres.

mod land;
mod levels;
mod svg;

use glam::{Vec2, Vec3};
use vestibule_world::ids::block_offset;
use vestibule_world::{BlockId, CellId, StaticObject, World};

use svg::{Panel, Svg, convex_hull};

/// A step of a trail to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrailPoint {
    /// The cell there.
    pub cell: CellId,
    /// Foot point in the frame of the cell's landblock, metres.
    pub pos: Vec3,
}

/// Draws a landblock; steps of `trail` elsewhere are left out. Answers `None` where the world has no such landblock.
///
/// ```
/// use vestibule::world::BlockId;
///
/// let world = vestibule::open_world(None)?;
/// let svg = vestibule::map_svg::plan(&world, BlockId(0xA9B4), &[]).expect("the embedded world has this landblock");
/// assert!(svg.starts_with("<svg") && svg.contains("0100"));
/// # Ok::<(), vestibule::OpenError>(())
/// ```
pub fn plan(world: &World, block: BlockId, trail: &[TrailPoint]) -> Option<String> {
    let found = world.block(block)?;
    let trail: Vec<(CellId, Vec3)> = trail
        .iter()
        // Neighbouring landblocks are drawn to a little beyond the border.
        .map(|p| (p.cell, p.pos + block_offset(block, p.cell.block())))
        .collect();
    let mut svg = Svg::new();
    svg.title(&format!("Landblock {block}"));
    if found.land.is_some() && (!found.looks_like_a_dungeon() || trail.iter().any(|(c, _)| !c.is_indoor())) {
        land::draw(&mut svg, world, found, &trail);
    }
    levels::draw(&mut svg, world, found, &trail);
    Some(svg.finish())
}

/// Draws the static objects of a cell or of the land.
fn draw_statics<'a>(panel: &mut Panel<'_>, objects: impl Iterator<Item = &'a StaticObject>) {
    for object in objects {
        let title = format!("static object 0x{:08X}", object.shape.id);
        let shape = &object.shape;
        let mut drawn = false;
        for (part, frame) in shape.parts.iter().zip(&object.part_frames) {
            let Some(model) = &part.model else { continue };
            let points: Vec<Vec2> = model
                .polygons
                .all_vertices()
                .iter()
                .map(|&v| frame.local_to_global(v * part.scale).truncate())
                .collect();
            let hull = convex_hull(points);
            if hull.len() > 2 {
                panel.polygon(&hull, "st", &title);
                drawn = true;
            }
        }
        if !drawn {
            let round = shape.cylspheres.iter().map(|c| (c.low_point, c.radius));
            let round = round.chain(shape.spheres.iter().map(|s| (s.center, s.radius)));
            for (center, radius) in round {
                panel.circle(
                    object.frame.local_to_global(center).truncate(),
                    radius,
                    "st",
                    &title,
                );
            }
        }
    }
}

/// Draws the parts of a trail that `shown` accepts, as lines that break where it leaves.
fn draw_trail(panel: &mut Panel<'_>, trail: &[(CellId, Vec3)], shown: impl Fn(CellId, Vec3) -> bool) {
    let mut line: Vec<Vec2> = Vec::new();
    let mut last: Option<Vec3> = None;
    for &(cell, pos) in trail {
        let jumps = last.is_some_and(|l| l.distance(pos) > 2.0);
        last = Some(pos);
        if !shown(cell, pos) || jumps {
            panel.line(&line, "tr", "");
            line.clear();
            if !shown(cell, pos) {
                continue;
            }
        }
        let point = pos.truncate();
        if line.last().is_none_or(|&p| p.distance(point) > 0.15) {
            line.push(point);
        }
    }
    panel.line(&line, "tr", "");
}
