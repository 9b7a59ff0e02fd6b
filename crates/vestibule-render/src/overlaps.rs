//! Rooms that occupy the same space without being linked (`rendering.md` 9.5).

use glam::Vec3;
use vestibule_view::Flood;
use vestibule_world::{BoundingBox, CellId, EnvCell, PortalTarget, World};

/// Two boxes that share more than this, cubic metres, overlap.
const MIN_SHARED: f32 = 0.1;

/// The rooms of a list that overlap another of the list to which they are not linked.
pub fn overlapping_cells(world: &World, flood: &Flood<'_>) -> Vec<CellId> {
    if flood.cells().len() < 2 {
        return Vec::new();
    }
    let rooms: Vec<(&EnvCell, BoundingBox)> = flood
        .cells()
        .iter()
        .filter_map(|c| {
            let cell = world.env_cell(c.id)?;
            let bounds = cell.structure.bounds?;
            Some((cell, bounds.mapped(|p| cell.frame.local_to_global(p))))
        })
        .collect();
    let mut out = Vec::new();
    for (k, (a, box_a)) in rooms.iter().enumerate() {
        for (b, box_b) in rooms.iter().skip(k + 1) {
            if shared(box_a, box_b) > MIN_SHARED && !linked(a, b) && !linked(b, a) && really_overlap(a, b) {
                for id in [a.id, b.id] {
                    if !out.contains(&id) {
                        out.push(id);
                    }
                }
            }
        }
    }
    out
}

fn shared(a: &BoundingBox, b: &BoundingBox) -> f32 {
    let side = |a0: f32, a1: f32, b0: f32, b1: f32| {
        let low = if a0 > b0 { a0 } else { b0 };
        let high = if a1 < b1 { a1 } else { b1 };
        if high > low { high - low } else { 0.0 }
    };
    side(a.min.x, a.max.x, b.min.x, b.max.x)
        * side(a.min.y, a.max.y, b.min.y, b.max.y)
        * side(a.min.z, a.max.z, b.min.z, b.max.z)
}

fn linked(a: &EnvCell, b: &EnvCell) -> bool {
    a.portals.iter().any(|p| p.other == PortalTarget::Cell(b.id))
}

/// Whether some of a grid of points in one's box lies inside both: boxes of turned or bent rooms meet more often than
/// the rooms do.
fn really_overlap(a: &EnvCell, b: &EnvCell) -> bool {
    let Some(bounds) = a.structure.bounds else {
        return false;
    };
    const STEPS: i32 = 6;
    let size = bounds.max - bounds.min;
    (0..STEPS * STEPS * STEPS).any(|k| {
        let at = |i: i32| (i as f32 + 0.5) / STEPS as f32;
        let share = Vec3::new(at(k % STEPS), at(k / STEPS % STEPS), at(k / (STEPS * STEPS)));
        let p = a.frame.local_to_global(bounds.min + size * share);
        a.contains_point(p) && b.contains_point(p)
    })
}
