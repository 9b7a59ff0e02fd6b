//! From a room as written to the convex cells it is made of.

use std::collections::BTreeSet;

use glam::DVec3;

pub(crate) use crate::geometry::CUT;
use crate::geometry::{Face, ON_PLANE, Polygon, Polytope, carve, merge_convex};
use crate::scene::{Paint, SolidDef};
use crate::text::{Messages, Span, Word};

/// A solid's convex parts, each face tagged with its material. `room`: the faces are seen from inside.
pub(crate) fn painted(solid: &SolidDef, paint: &Paint, room: bool) -> Vec<Polytope> {
    let mut parts = solid.parts.clone();
    for face in parts.iter_mut().flat_map(|p| &mut p.faces) {
        let outwards = face.polygon.plane.normal;
        face.tag = material(solid, paint, if room { -outwards } else { outwards }) as u32;
    }
    parts
}

fn material(solid: &SolidDef, paint: &Paint, normal: DVec3) -> usize {
    let special = |n: DVec3| paint.special.iter().any(|(s, _)| s.dot(n) > 0.939);
    match (solid.all, solid.top) {
        (_, Some(top)) if normal.z > 0.5 => top,
        (Some(all), _) if !special(normal) => all,
        _ => paint.of(normal),
    }
}

/// Cuts a room into convex cells that touch but do not overlap, in room coordinates; what is wrong with its
/// polygons is reported.
pub(crate) fn cells_of(
    name: &Word,
    solids: &[SolidDef],
    paint: &Paint,
    messages: &mut Messages,
) -> Vec<Polytope> {
    let mut cells: Vec<Polytope> = Vec::new();
    let mut add = |part: Polytope| {
        let mut rest = vec![part];
        for earlier in &cells {
            rest = rest.iter().flat_map(|p| p.without(earlier, CUT)).collect();
        }
        cells.extend(rest);
    };
    for solid in solids {
        painted(solid, paint, true).into_iter().for_each(&mut add);
    }
    let soup: Vec<Wall> = solids
        .iter()
        .flat_map(|solid| {
            solid.polygons.iter().map(|(span, polygon)| Wall {
                span: *span,
                polygon: polygon.clone(),
                material: material(solid, paint, polygon.plane.normal) as u32,
            })
        })
        .collect();
    if !soup.is_empty() && is_closed(name, &soup, messages) {
        carve_room(&soup).into_iter().for_each(&mut add);
    }
    merge_convex(cells)
}

/// A polygon of a room's wall, facing the room.
struct Wall {
    span: Span,
    polygon: Polygon,
    material: u32,
}

/// Edges that no other polygon continues, as (polygon, start, end).
fn open_edges(polygons: &[Polygon]) -> Vec<(usize, DVec3, DVec3)> {
    let near = |a: DVec3, b: DVec3| a.distance_squared(b) < 1.0e-6;
    let corners: Vec<DVec3> = polygons.iter().flat_map(|p| p.points.iter().copied()).collect();
    // Edges cut at every corner that lies on them.
    let mut edges = Vec::new();
    for (k, polygon) in polygons.iter().enumerate() {
        let n = polygon.points.len();
        for i in 0..n {
            let (a, b) = (polygon.points[i], polygon.points[(i + 1) % n]);
            let along = b - a;
            let mut stops: Vec<f64> = corners
                .iter()
                .map(|c| (c, (*c - a).dot(along) / along.length_squared()))
                .filter(|(c, t)| {
                    *t > 0.0 && *t < 1.0 && near(a + along * *t, **c) && !near(**c, a) && !near(**c, b)
                })
                .map(|(_, t)| t)
                .collect();
            stops.extend([0.0, 1.0]);
            stops.sort_by(f64::total_cmp);
            stops.dedup_by(|s, t| (*s - *t).abs() * along.length() < 1.0e-3);
            edges.extend(stops.windows(2).map(|w| (k, a + along * w[0], a + along * w[1])));
        }
    }
    let mut open = Vec::new();
    let mut taken = vec![false; edges.len()];
    for i in 0..edges.len() {
        if taken[i] {
            continue;
        }
        let (_, a, b) = edges[i];
        let partner = (i + 1..edges.len()).find(|&j| !taken[j] && near(edges[j].1, b) && near(edges[j].2, a));
        match partner {
            Some(j) => taken[j] = true,
            None => open.push(edges[i]),
        }
    }
    open
}

/// At most this many polygons of a room that is not closed are tried the other way round.
const MAX_SUSPECTS: usize = 32;

fn is_closed(name: &Word, soup: &[Wall], messages: &mut Messages) -> bool {
    let mut polygons: Vec<Polygon> = soup.iter().map(|w| w.polygon.clone()).collect();
    let mut open = open_edges(&polygons);
    if open.is_empty() {
        let volume: f64 = polygons
            .iter()
            .map(|p| p.area() * -p.plane.dist(polygons[0].points[0]))
            .sum();
        if volume < 0.0 {
            return true;
        }
        let message = format!("all polygons of room `{}` face outwards", name.text);
        messages.error(
            soup[0].span,
            message,
            "list each polygon's points counter-clockwise as seen from inside",
        );
        return false;
    }
    // A polygon that, turned over, closes more edges than it leaves open is inside out.
    let suspects: BTreeSet<usize> = open.iter().map(|(k, ..)| *k).collect();
    for k in suspects.into_iter().take(MAX_SUSPECTS) {
        let flipped = polygons[k].flipped();
        let kept = core::mem::replace(&mut polygons[k], flipped);
        let mended = open_edges(&polygons);
        if mended.len() < open.len() {
            let message = format!("this polygon faces out of room `{}`", name.text);
            messages.error(
                soup[k].span,
                message,
                "reverse the order of its points: counter-clockwise as seen from inside",
            );
            open = mended;
        } else {
            polygons[k] = kept;
        }
    }
    if let Some((k, a, b)) = open.first() {
        let message = format!(
            "room `{}` has a hole: no polygon continues the edge from {} to {}",
            name.text,
            written(*a),
            written(*b)
        );
        let help = "add the missing polygon; an opening needs a wall too, `opening` or `exit` cuts it out";
        messages.error(soup[*k].span, message, help);
    }
    false
}

/// A point as it is written in scenes.
pub(crate) fn written(p: DVec3) -> String {
    let round = |n: f64| {
        let rounded = (n * 1000.0).round() / 1000.0;
        if rounded == 0.0 { 0.0 } else { rounded }
    };
    format!("({} {} {})", round(p.x), round(p.y), round(p.z))
}

/// The inside of closed walls as convex solids, faces tagged with materials.
fn carve_room(soup: &[Wall]) -> Vec<Polytope> {
    let polygons: Vec<Polygon> = soup.iter().map(|w| w.polygon.clone()).collect();
    let mut out = carve(&polygons);
    for face in out.iter_mut().flat_map(|p| &mut p.faces) {
        face.tag = wall_behind(face, soup);
    }
    out
}

/// The material of the wall that a face of a carved cell lies on, if it lies on one.
fn wall_behind(face: &Face, soup: &[Wall]) -> u32 {
    let lies_on = |w: &&Wall| {
        w.polygon.meets(&face.polygon)
            && w.polygon.plane.dist(face.polygon.center()).abs() < 2.0 * ON_PLANE
            && w.polygon.intersection(&face.polygon).is_some()
    };
    soup.iter().find(lies_on).map_or(CUT, |w| w.material)
}
