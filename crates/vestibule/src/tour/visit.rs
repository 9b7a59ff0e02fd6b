//! Visiting: in and out through every opening that can be walked through.

use glam::{Vec2, Vec3};
use vestibule_world::{CellId, PortalTarget, World};

use super::{STEP, Tour, Unpassed};
use crate::route::{self, Opening};
use crate::walker::{Footing, TICK};

/// Ticks that a fall may take.
const FALL_TICKS: u32 = 450;
/// Speed of a jump off an edge, m/s: upwards, and over the ground.
const JUMP: (f32, f32) = (2.0, 2.5);
/// Openings higher than this above the floor are windows, metres: a little more than a player steps up.
const REACH: f32 = 0.65;
/// Rooms that are remembered for trials.
const ROOMS: usize = 64;

impl Tour<'_, '_> {
    /// Walks to the entrances around, nearest first, and through all that is behind each.
    pub(super) fn visit_entrances(&mut self) {
        let home = self.footing.at.cell.block();
        let mut left = Vec::new();
        let radius = i32::from(self.options.radius);
        for dx in -radius..=radius {
            for dy in -radius..=radius {
                if let Some(block) = home.neighbour(dx, dy) {
                    left.extend(route::entrances(self.walker.world(), block));
                }
            }
        }
        while !left.is_empty() && self.summary.ended_early.is_none() {
            let at = self.footing.at;
            let distance = |o: &Opening| route::distance_to(o, at.cell.block(), at.origin());
            let nearest = (0..left.len()).min_by(|&a, &b| distance(&left[a]).total_cmp(&distance(&left[b])));
            let Some(nearest) = nearest else { break };
            let opening = left.swap_remove(nearest);
            if self.done.contains(&opening.id) {
                continue;
            }
            self.done.insert(opening.id);
            if window_from_outside(self.walker.world(), &opening) {
                self.summary.out_of_reach += 1;
                continue;
            }
            self.outside = self.footing;
            let way = route::in_through(&mut self.walker, &self.footing, &opening);
            let passed = way.is_some_and(|way| self.follow(&way, |cell| cell == opening.id.cell));
            if !passed {
                let unpassed = self.unpassed(&opening);
                self.summary.unreached_entrances.push(unpassed);
                continue;
            }
            let outside = self.outside;
            self.visit(opening.id.cell);
            let back = route::out_through(&mut self.walker, &self.footing, &opening);
            if !back.is_some_and(|way| self.follow(&way, |cell| !cell.is_indoor())) {
                self.teleport(outside);
            }
        }
    }

    /// Goes through every opening of a cell and of what is behind it, and comes back into the cell; then down the drops
    /// that were passed by.
    pub(super) fn visit(&mut self, cell: CellId) {
        self.visit_on_foot(cell);
        while let Some((footing, opening)) = self.drops.pop() {
            if self.summary.ended_early.is_some() {
                return;
            }
            let PortalTarget::Cell(below) = opening.to else {
                continue;
            };
            if self.visited.contains(&below) {
                continue;
            }
            self.teleport(footing);
            if self.drop_through(&opening) {
                self.summary.falls += 1;
                self.visit_on_foot(self.footing.at.cell);
            } else {
                let unpassed = self.unpassed(&opening);
                self.summary.not_passed.push(unpassed);
            }
        }
    }

    fn visit_on_foot(&mut self, cell: CellId) {
        struct Level {
            openings: Vec<Opening>,
            /// The opening by which the cell was entered, and where the player stood before it.
            way_in: Option<(Opening, Footing)>,
        }
        self.visited.insert(cell);
        let mut levels = vec![Level {
            openings: self.openings_of(cell),
            way_in: None,
        }];
        self.go_to_the_middle(cell);
        while self.summary.ended_early.is_none() {
            let Some(level) = levels.last_mut() else { break };
            let Some(opening) = level.openings.pop() else {
                // Everything here is done: back through the opening by which the cell was entered.
                let way_in = levels.pop().and_then(|level| level.way_in);
                if let Some((opening, before)) = way_in {
                    self.back_through(&opening, before);
                }
                continue;
            };
            if self.done.contains(&opening.id) {
                continue;
            }
            self.done.insert(opening.id);
            self.done.extend(opening.opposite);
            let before = self.footing;
            if out_of_reach(&opening, &before) && !self.may_climb_to(&opening) {
                self.summary.out_of_reach += 1;
                continue;
            }
            let way = route::out_through(&mut self.walker, &before, &opening);
            let to = opening.to;
            let arrived = move |cell: CellId| match to {
                PortalTarget::Outside => !cell.is_indoor(),
                PortalTarget::Cell(other) => cell == other,
            };
            if !way.is_some_and(|way| self.follow(&way, arrived)) {
                if self.footing.at.cell != before.at.cell {
                    self.teleport(before);
                }
                match opening.to {
                    PortalTarget::Cell(other)
                        if !self.visited.contains(&other) && !out_of_reach(&opening, &before) =>
                    {
                        self.drops.push((before, opening));
                    }
                    _ => {
                        let unpassed = self.unpassed(&opening);
                        self.summary.not_passed.push(unpassed);
                    }
                }
                continue;
            }
            match opening.to {
                PortalTarget::Cell(other) if self.visited.insert(other) => {
                    self.go_to_the_middle(other);
                    let way_in = Some((opening, before));
                    levels.push(Level {
                        openings: self.openings_of(other),
                        way_in,
                    });
                }
                _ => self.back_through(&opening, before),
            }
        }
    }

    /// Whether the cell has a floor within a step of the opening, at the opening's place.
    fn may_climb_to(&self, opening: &Opening) -> bool {
        let Some(cell) = self.walker.world().env_cell(opening.id.cell) else {
            return false;
        };
        let structure = &cell.structure;
        let Some(physics) = &structure.physics else {
            return false;
        };
        let lowest = lowest(opening);
        // A stair or a ramp that comes up to the opening has a walkable face that high.
        physics.faces().iter().any(|face| {
            let normal = cell.frame.local_to_global_vec(face.plane.normal);
            let corners = physics
                .edges(face)
                .iter()
                .map(|edge| cell.frame.local_to_global(edge.start));
            let near = |c: Vec3| {
                opening
                    .corners
                    .iter()
                    .any(|o| o.truncate().distance(c.truncate()) < 1.5)
            };
            let mut corners = corners.into_iter();
            normal.z >= vestibule_world::constants::FLOOR_Z
                && corners.any(|c| c.z > lowest - REACH && near(c))
        })
    }

    /// Over an edge: walks towards the middle of an opening, jumps where the ground ends, and falls. Says whether the
    /// player came to rest in another cell.
    fn drop_through(&mut self, opening: &Opening) -> bool {
        let from = self.footing.at.cell;
        let mut stuck = 0;
        let mut jumped = 0;
        let offset = self.walker.local(opening.id.cell.block(), Vec3::ZERO);
        let middle = (opening.middle - offset).truncate();
        let mut heading = Vec2::ZERO;
        for _ in 0..FALL_TICKS {
            let here = self.walker.point(&self.footing.at).truncate();
            let left = middle - here;
            if left.length() > 2.0 * STEP {
                heading = left.normalize_or_zero();
            }
            let standing = self.footing.is_standing();
            if standing && self.footing.at.cell != from {
                return !self.visited.contains(&self.footing.at.cell);
            }
            let pace = if standing { STEP } else { JUMP.1 * TICK };
            // Over a hole in the floor straight down; through an upright opening on and on.
            let onward = !opening.is_flat() || left.length() > 2.0 * STEP;
            if !self.tick(if onward { heading * pace } else { Vec2::ZERO }) {
                return false;
            }
            let moved = self.walker.point(&self.footing.at).truncate().distance(here);
            stuck = if standing && moved < 0.2 * STEP {
                stuck + 1
            } else {
                0
            };
            if stuck >= 5 {
                jumped += 1;
                stuck = 0;
                if jumped > 3 {
                    return false;
                }
                self.footing = self.walker.jump(&self.footing, JUMP.0);
            }
        }
        false
    }

    /// The openings of a cell, to be taken from the end: the nearest one last.
    fn openings_of(&self, cell: CellId) -> Vec<Opening> {
        let mut out = route::openings(self.walker.world(), cell);
        let (block, at) = (self.footing.at.cell.block(), self.footing.at.origin());
        let distance = |o: &Opening| route::distance_to(o, block, at);
        out.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
        out
    }

    /// Back into the cell that the opening belongs to; put back to `before` where there is no way.
    fn back_through(&mut self, opening: &Opening, before: Footing) {
        let own = opening.id.cell;
        let way = route::in_through(&mut self.walker, &self.footing, opening);
        if !way.is_some_and(|way| self.follow(&way, |cell| cell == own)) && self.summary.ended_early.is_none()
        {
            self.teleport(before);
        }
    }

    /// Some steps into a cell, towards the middle of its floor, if nothing is in the way.
    fn go_to_the_middle(&mut self, id: CellId) {
        let world = self.walker.world();
        let Some(bounds) = world.env_cell(id).and_then(|cell| {
            let bounds = cell.structure.bounds?;
            Some(bounds.mapped(|p| cell.frame.local_to_global(p)))
        }) else {
            return;
        };
        let middle = (bounds.min + bounds.max) / 2.0;
        let middle = middle - self.walker.local(id.block(), Vec3::ZERO);
        let here = self.walker.point(&self.footing.at).truncate();
        if here.distance(middle.truncate()) >= 0.5
            && self
                .walker
                .straight(&self.footing, middle.truncate(), &|cell| cell == id)
                .is_some()
        {
            self.follow(&[middle.truncate()], |cell| cell == id);
        }
        if self.rooms.len() < ROOMS && self.footing.at.cell == id {
            self.rooms.push(self.footing);
        }
    }

    fn unpassed(&self, opening: &Opening) -> Unpassed {
        let low = opening.corners.iter().map(|c| c.z).fold(f32::INFINITY, f32::min);
        let block = opening.id.cell.block();
        let above = low - (self.footing.at.origin().z);
        let mut what = opening.in_words();
        if above > 0.3 {
            what.push_str(&format!(", {above:.1} m above the floor"));
        } else if above < -0.6 {
            what.push_str(&format!(", {:.1} m below", -above));
        }
        if block != self.footing.at.cell.block() {
            what.push_str(", in another landblock");
        }
        Unpassed {
            cell: opening.id.cell.to_string(),
            portal: opening.id.portal,
            to: match opening.to {
                PortalTarget::Outside => "outside".to_owned(),
                PortalTarget::Cell(cell) => cell.to_string(),
            },
            what,
        }
    }
}

/// Height of an opening's lowest corner in the frame of its landblock, metres.
fn lowest(opening: &Opening) -> f32 {
    opening.corners.iter().map(|c| c.z).fold(f32::INFINITY, f32::min)
}

/// Whether an opening lies higher than one could step.
fn out_of_reach(opening: &Opening, from: &Footing) -> bool {
    lowest(opening) > from.at.origin().z + REACH
}

/// Whether the ground before an opening lies too low to step in.
fn window_from_outside(world: &World, opening: &Opening) -> bool {
    let front = opening.middle + opening.outward.with_z(0.0).normalize_or_zero() * 0.6;
    let Some(ground) = world.ground_at(opening.id.cell, front) else {
        return false;
    };
    // A porch or steps of the building's shell may bring one nearer than the ground does.
    let steps = world.block(opening.id.cell.block()).is_some_and(|block| {
        block.buildings.iter().any(|b| {
            b.shape
                .parts
                .iter()
                .any(|p| p.model.as_ref().is_some_and(|m| m.physics.is_some()))
        })
    });
    lowest(opening) > ground.z + if steps { 2.0 * REACH } else { REACH }
}
