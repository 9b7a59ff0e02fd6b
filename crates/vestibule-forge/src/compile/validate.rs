//! What can be wrong with a scene whose statements are all right: places, ids, overlaps, ground in doorways.

use glam::{DVec2, DVec3};

use super::cells::Target;
use super::land::Land;
use super::room::written;
use super::site::PlacedSite;
use crate::geometry::Polytope;
use crate::scene::{Kind, Scene};
use crate::text::{Messages, Span};

/// Cells that share less than this deep a layer are taken to touch, metres.
const OVERLAP: f64 = 2.0e-3;
/// How high a body steps up, metres.
const STEP_UP: f64 = 0.6;
/// How far from an exit its ground is felt, metres: the radius of a body and a little.
const EXIT_REACH: f64 = 0.55;

pub(crate) fn check(scene: &Scene, land: &Land, sites: &[PlacedSite<'_>], messages: &mut Messages) {
    overlaps(sites, messages);
    // What lacks openings or stands wrong because of an error needs no second message.
    let complete = !messages.has_errors();
    for (k, site) in sites.iter().enumerate() {
        if complete {
            portals(site, messages);
        }
        statics(site, messages);
        if site.def.kind == Kind::Building {
            footprint(site, messages);
            let same_cell = |other: &&PlacedSite<'_>| {
                let cell = |s: &PlacedSite<'_>| (s.on_map.origin.truncate() / 24.0).floor();
                other.def.kind == Kind::Building && cell(other) == cell(site)
            };
            if let Some(other) = sites[..k].iter().find(same_cell) {
                let message = format!(
                    "`{}` stands on the same land cell as `{}`",
                    site.def.name.text, other.def.name.text
                );
                let help = "a land cell (24 m square) knows one building only; move it to another cell";
                messages.error(site.def.name.span, message, help);
            }
            ground(site, land, messages);
        }
    }
    let on_land = |at: DVec2, span: Span, messages: &mut Messages| {
        if !land.contains(at) {
            let help = "place it inside the land, or enlarge `land`";
            messages.error(span, "this stands outside the land", help);
        }
    };
    for object in &scene.statics {
        on_land(object.place.at, object.span, messages);
    }
}

/// Cells of one landblock that share space.
fn overlaps(sites: &[PlacedSite<'_>], messages: &mut Messages) {
    let mut all: Vec<(&PlacedSite<'_>, usize, Polytope, (DVec3, DVec3))> = Vec::new();
    for site in sites {
        for (k, cell) in site.cells.cells.iter().enumerate() {
            let Some(space) = cell.space.mapped(|p| site.place.to_outer(p)) else {
                continue;
            };
            let bounds = space.bounds();
            for (other, j, there, (low, high)) in &all {
                let apart = (bounds.0 + OVERLAP).cmpgt(*high).any() || (*low + OVERLAP).cmpgt(bounds.1).any();
                if other.block != site.block || apart {
                    continue;
                }
                let shared = space
                    .shrunk(OVERLAP / 2.0)
                    .and_then(|s| s.intersection(&there.shrunk(OVERLAP / 2.0)?));
                if let Some(shared) = shared.and_then(|_| space.intersection(there)) {
                    let here = site.place.to_inner(shared.center());
                    let message = format!(
                        "`{}.{}` and `{}.{}` overlap",
                        other.def.name.text, other.cells.cells[*j].name, site.def.name.text, cell.name
                    );
                    let help = format!(
                        "around {} both claim {:.3} m³; make their walls meet",
                        written(here),
                        shared.volume()
                    );
                    messages.error(cell.span, message, help);
                }
            }
            all.push((site, k, space, bounds));
        }
    }
}

fn portals(site: &PlacedSite<'_>, messages: &mut Messages) {
    for cell in &site.cells.cells {
        if cell.holes.is_empty() {
            let message = format!(
                "room `{}` has no opening: the engine takes no point to be inside",
                cell.name
            );
            messages.warning(
                cell.span,
                message,
                "add an `opening` or an `exit`, or remove the room",
            );
        }
        if cell.holes.len() > 255 {
            let message = format!("room `{}` has {} openings", cell.name, cell.holes.len());
            messages.error(cell.span, message, "a cell has at most 255; split the room");
        }
        for hole in cell.holes.iter().filter(|h| matches!(h.to, Target::Outside(_))) {
            let on = |get: fn(&DVec3) -> f64| {
                let points = || hole.polygon.points.iter().map(|p| get(&cell.place.to_inner(*p)));
                points().all(|n| n == 12.0) || points().all(|n| n == -12.0)
            };
            if on(|p| p.x) || on(|p| p.y) {
                let help = "move it by a centimetre: clients neither cut nor seal openings at exactly 12 m";
                messages.warning(
                    hole.span,
                    "this exit lies exactly 12 m from the origin of its room",
                    help,
                );
            }
        }
    }
}

fn statics(site: &PlacedSite<'_>, messages: &mut Messages) {
    for object in &site.def.statics {
        let p = object.place.resolve(|_| 0.0).origin;
        let room = object.room.as_ref();
        if let Some(name) = room
            && !site.def.rooms.iter().any(|r| r.name.text == name.text)
        {
            let message = format!("`{}` has no room `{}`", site.def.name.text, name.text);
            messages.error(name.span, message, "name the room in which the object stands");
            continue;
        }
        let Some(cell) = site.cell_of(room.map(|r| r.text.as_str()), p) else {
            let message = format!("`{}` has no rooms for this object", site.def.name.text);
            messages.error(
                object.span,
                message,
                "place it with `static` outside of the site, on the land",
            );
            continue;
        };
        let cell = &site.cells.cells[cell];
        if !cell.space.contains(p + DVec3::Z * 0.05, 0.3) {
            let (low, high) = cell.space.bounds();
            let message = format!("this object stands outside of room `{}`", cell.name);
            let help = format!(
                "the room reaches from {} to {} in site coordinates",
                written(low),
                written(high)
            );
            messages.warning(object.span, message, help);
        }
    }
}

/// A building collides only with bodies in the land cell of its origin.
fn footprint(site: &PlacedSite<'_>, messages: &mut Messages) {
    let cell = (site.place.origin.truncate() / 24.0).floor() * 24.0;
    let points = site.cells.shell.iter().flat_map(|f| &f.polygon.points);
    let mut beyond: f64 = 0.0;
    for p in points {
        let p = site.place.to_outer(*p).truncate();
        beyond = beyond
            .max((cell - p).max_element())
            .max((p - cell - 24.0).max_element());
    }
    if beyond > 0.01 {
        let message = format!(
            "`{}` reaches {beyond:.1} m over the border of its land cell: no one collides with it there",
            site.def.name.text
        );
        let help = format!(
            "keep it between x {} and {}, y {} and {} of landblock {}",
            cell.x,
            cell.x + 24.0,
            cell.y,
            cell.y + 24.0,
            site.block
        );
        messages.warning(site.def.name.span, message, help);
    }
}

/// The ground before and in the exits of a building.
fn ground(site: &PlacedSite<'_>, land: &Land, messages: &mut Messages) {
    for hole in site.cells.shell_holes.iter().filter(|h| !h.pane) {
        let span = site.cells.cells[hole.cell].holes[hole.hole].span;
        let normal = hole.polygon.plane.normal;
        if normal.z.abs() > 0.7 {
            continue;
        }
        let sill = hole
            .polygon
            .points
            .iter()
            .map(|p| p.z)
            .fold(f64::INFINITY, f64::min);
        let feet: Vec<DVec3> = hole
            .polygon
            .points
            .iter()
            .filter(|p| p.z < sill + 0.01)
            .copied()
            .collect();
        let (Some(a), Some(b)) = (feet.first(), feet.last()) else {
            continue;
        };
        let level = DVec3::new(normal.x, normal.y, 0.0).normalize_or_zero();
        let (mut above, mut below): (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
        for across in 0..=8 {
            for out in [-EXIT_REACH, 0.0, EXIT_REACH] {
                let p = a.lerp(*b, f64::from(across) / 8.0) + level * out;
                let p = site.on_map.to_outer(p);
                let over = land.ground(p.truncate()) - p.z;
                above = above.max(over);
                if out > 0.0 {
                    below = below.min(over);
                }
            }
        }
        let room = &site.cells.cells[hole.cell].name;
        if above > 0.02 {
            let message = format!("the ground lies {above:.2} m above the sill of the exit of `{room}`");
            let help = "raise the building, or level the terrain: a body in the doorway would be lifted onto the ground";
            messages.warning(span, message, help);
        } else if below < -STEP_UP {
            let message = format!(
                "the sill of the exit of `{room}` is {:.2} m above the ground: too high to step in",
                -below
            );
            let help = "lower the building, raise the terrain, or write `window` if nobody shall pass";
            messages.warning(span, message, help);
        }
    }
}
