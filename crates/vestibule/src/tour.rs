//! A walk through every cell that can be reached on foot, in and out of everything.
//!
//! [`Tour::run`] plans its route as it goes: from the start over land to the nearest entrance, through the openings of
//! every cell behind it and back, then to the next entrance. The player's cell is carried by the sweeps and never derived
//! from where it rests. In every doorway it stands still for a while, to show that the cell does not change.

use std::collections::BTreeSet;

use glam::{Vec2, Vec3};
use serde::Serialize;
use vestibule_dat::{DatSet, RecordKind};
use vestibule_world::ids::block_offset;
use vestibule_world::{BlockId, CellId, EnvCell, PortalTarget, Position, World};

use crate::route::{self, Opening, PortalId, Steer, Steering};
use crate::walker::{Footing, TICK, Walker};

/// Length of a step, metres.
pub const STEP: f32 = 0.05;
/// Ticks that a fall may take.
const FALL_TICKS: u32 = 450;
/// Speed of a jump off an edge, m/s: upwards, and over the ground.
const JUMP: (f32, f32) = (2.0, 2.5);
/// Openings higher than this above the floor are windows, metres: a little more than a player steps up.
const REACH: f32 = 0.65;

/// What a tour does.
#[derive(Clone, Debug)]
pub struct TourOptions {
    /// Where to begin; a sensible place is found when there is none.
    pub start: Option<Position>,
    /// Entrances of landblocks up to this far from the start's are visited.
    pub radius: u8,
    /// Ticks to stand still in each doorway.
    pub stand_ticks: u32,
    /// Steps after which the tour ends, wherever it is.
    pub max_steps: usize,
    /// Which cell the trail and the changes report.
    pub membership: Membership,
}

/// Two ways of saying which cell a body is in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Membership {
    /// Retail's: the cell that the last accepted sweep ended in.
    #[default]
    Sweep,
    /// As other clients did: derived anew from where the body rests, see [`derive_cell`].
    Static,
}

/// How often a way of saying which cell a body is in changed its mind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MembershipCount {
    /// Changes of cell.
    pub changes: usize,
    /// Changes that were taken back within a tenth of a second: flicker.
    pub flickers: usize,
    /// Changes while the body stood still.
    pub while_standing: usize,
    /// Ticks with another cell than the sweep says.
    pub ticks_off: usize,
    #[serde(skip)]
    last: Option<(CellId, CellId, usize)>,
    #[serde(skip)]
    now: Option<CellId>,
}

/// Ticks within which a change that is taken back counts as flicker.
const FLICKER_TICKS: usize = 3;

impl MembershipCount {
    fn count(&mut self, cell: CellId, swept: CellId, tick: usize, standing: bool, teleported: bool) {
        self.ticks_off += usize::from(cell != swept);
        let before = self.now.replace(cell);
        let Some(before) = before.filter(|&before| before != cell && !teleported) else { return };
        self.changes += 1;
        self.while_standing += usize::from(standing);
        let back = self.last.is_some_and(|(from, to, at)| from == cell && to == before && tick - at <= FLICKER_TICKS);
        self.flickers += usize::from(back);
        self.last = Some((before, cell, tick));
    }
}

/// The cell of a resting position without regard to where the body came from: the first env cell of its landblock that
/// holds its foot point, else the land cell under it. This is how other clients said it; retail does not.
pub fn derive_cell(world: &World, at: &Position) -> CellId {
    let inside = world.block(at.cell.block()).and_then(|block| {
        let found = block.env_cells().find(|cell| cell.contains_point(at.origin()));
        found.map(|cell| cell.id)
    });
    let outside = || at.cell.adjust_to_outside(at.origin()).map(|(cell, _)| cell);
    inside.or_else(outside).unwrap_or(at.cell)
}

impl Default for TourOptions {
    fn default() -> Self {
        TourOptions {
            start: None,
            radius: 1,
            stand_ticks: 100,
            max_steps: 3_000_000,
            membership: Membership::Sweep,
        }
    }
}

/// One tick of the walk, as in `trail.jsonl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrailStep {
    /// Seconds since the start.
    pub t: f32,
    /// The player's cell.
    pub cell: CellId,
    /// Its foot point in the frame of the cell's landblock, metres.
    pub pos: Vec3,
    /// It stands still in a doorway.
    pub standing: bool,
}

impl Serialize for TrailStep {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut out = serializer.serialize_struct("TrailStep", 4)?;
        // Ticks are thirtieths of a second: hundredths would not be even.
        out.serialize_field("t", &(f64::from((self.t * 1e4).round()) / 1e4))?;
        out.serialize_field("cell", &self.cell.to_string())?;
        out.serialize_field("pos", &self.pos.to_array())?;
        if self.standing {
            out.serialize_field("standing", &true)?;
        } else {
            out.skip_field("standing")?;
        }
        out.end()
    }
}

/// A change of cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Seconds since the start.
    pub t: f32,
    /// Where the player was after it.
    pub position: String,
    /// The cell before.
    pub from: String,
    /// The cell after.
    pub to: String,
    /// What was crossed.
    pub by: String,
    /// An opening was crossed, not a line between land cells.
    pub portal: bool,
    /// It happened while the player stood still.
    pub standing: bool,
}

/// An opening that was not walked through.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unpassed {
    /// The cell it was tried from.
    pub cell: String,
    /// Index of the portal.
    pub portal: u16,
    /// Where it leads.
    pub to: String,
    /// What it is: its size, and how high it lies.
    pub what: String,
}

/// The outcome of a tour.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TourSummary {
    /// Position it began at.
    pub start: String,
    /// Env cells entered.
    pub env_cells: usize,
    /// Env cells that portals connect with those entered, entered or not.
    pub env_cells_connected: usize,
    /// Land cells entered.
    pub land_cells: usize,
    /// Changes of cell, teleports left out.
    pub transitions: usize,
    /// Drops taken: openings that lead down and not up again.
    pub falls: usize,
    /// Times the player was put back to where a drop or a way without return began.
    pub teleports: usize,
    /// Of these, through openings.
    pub through_portals: usize,
    /// Doorways stood in.
    pub doorways: usize,
    /// Ticks stood still.
    pub standing_ticks: u32,
    /// Changes of cell while standing still: 0 where membership is right.
    pub changes_while_standing: usize,
    /// Ticks while standing at which a fresh look-up, seeded from the player's cell, named another cell.
    pub look_ups_that_differ: usize,
    /// Membership by the sweep, counted.
    pub by_sweep: MembershipCount,
    /// Membership derived from the resting position, counted on the same walk.
    pub by_position: MembershipCount,
    /// Steps, standing included.
    pub steps: usize,
    /// Metres walked.
    pub metres: f32,
    /// Seconds it took.
    pub seconds: f32,
    /// Connected env cells that were not entered.
    pub not_entered: Vec<String>,
    /// Windows and hatches that no floor, stair or ground comes near to: not tried.
    pub out_of_reach: usize,
    /// Openings not walked through: drops that cannot be taken, things in the way.
    pub not_passed: Vec<Unpassed>,
    /// Entrances that no way over land was found to.
    pub unreached_entrances: Vec<Unpassed>,
    /// Why the tour ended early, if it did.
    pub ended_early: Option<String>,
}

/// Why no tour can be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TourError {
    /// The world has nothing to stand on.
    #[error("no place to start from: no landblock has a cell that one can stand in")]
    NoStart,
    /// The start given is in no cell, or one cannot stand there.
    #[error("nobody can stand at {0}: it is in no cell, inside something, or nothing is below it")]
    BadStart(Position),
}

/// A tour under way.
pub struct Tour<'w, 'o> {
    walker: Walker<'w>,
    options: TourOptions,
    on_change: &'o mut dyn FnMut(&Change),
    on_step: &'o mut dyn FnMut(usize),
    footing: Footing,
    /// Where the player last was before it entered a building.
    outside: Footing,
    trail: Vec<TrailStep>,
    summary: TourSummary,
    entered: BTreeSet<CellId>,
    stood_in: BTreeSet<(CellId, CellId)>,
    done: BTreeSet<PortalId>,
    visited: BTreeSet<CellId>,
    drops: Vec<(Footing, Opening)>,
    teleported: bool,
}

impl<'w, 'o> Tour<'w, 'o> {
    /// Walks a tour. `on_change` is told of every change of cell as it happens, `on_step` the number of steps so far.
    ///
    /// # Errors
    /// There is no place to start from.
    pub fn run(
        world: &'w World,
        dats: &DatSet,
        options: TourOptions,
        on_change: &'o mut dyn FnMut(&Change),
        on_step: &'o mut dyn FnMut(usize),
    ) -> Result<(Vec<TrailStep>, TourSummary), TourError> {
        let (walker, footing) = match options.start {
            Some(start) => {
                let mut walker = Walker::new(world, start.cell.block());
                let footing = walker.put(&start).ok_or(TourError::BadStart(start))?;
                (walker, footing)
            }
            None => find_start(world, dats).ok_or(TourError::NoStart)?,
        };
        let mut tour = Tour {
            walker,
            options,
            on_change,
            on_step,
            footing,
            outside: footing,
            trail: Vec::new(),
            summary: TourSummary {
                start: short(&footing.at),
                ..TourSummary::default()
            },
            entered: BTreeSet::new(),
            stood_in: BTreeSet::new(),
            done: BTreeSet::new(),
            visited: BTreeSet::new(),
            drops: Vec::new(),
            teleported: false,
        };
        tour.record(false);
        if footing.at.cell.is_indoor() {
            tour.visit(footing.at.cell);
        } else {
            tour.visit_entrances();
        }
        tour.finish()
    }

    /// Walks to the entrances around, nearest first, and through all that is behind each.
    fn visit_entrances(&mut self) {
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
    fn visit(&mut self, cell: CellId) {
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

    /// Puts the player back to where it has been.
    fn teleport(&mut self, to: Footing) {
        let before = self.footing;
        self.footing = to;
        self.summary.teleports += 1;
        self.teleported = true;
        self.record(false);
        if before.at.cell != to.at.cell && self.options.membership == Membership::Sweep {
            let change = self.change(&before, "teleport".to_owned(), false, false);
            (self.on_change)(&change);
        }
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
        if here.distance(middle.truncate()) < 0.5 {
            return;
        }
        if self
            .walker
            .straight(&self.footing, middle.truncate(), &|cell| cell == id)
            .is_some()
        {
            self.follow(&[middle.truncate()], |cell| cell == id);
        }
    }

    /// Walks a way in steps. Says whether it ended in a cell that `arrived` accepts.
    fn follow(&mut self, way: &[Vec2], arrived: impl Fn(CellId) -> bool) -> bool {
        let mut steering = Steering::new(way, STEP);
        loop {
            let here = self.walker.point(&self.footing.at).truncate();
            match steering.next(here, arrived(self.footing.at.cell)) {
                Steer::Arrived => return true,
                Steer::Lost => return false,
                Steer::Go(offset) => {
                    if !self.tick(offset) {
                        return false;
                    }
                }
            }
        }
    }

    /// One step; in a doorway that is new the player then stands still. `false` when the tour is over.
    fn tick(&mut self, offset: Vec2) -> bool {
        let before = self.footing;
        self.footing = self.walker.step(&before, offset);
        self.summary.metres += self
            .walker
            .point(&before.at)
            .distance(self.walker.point(&self.footing.at));
        self.record(false);
        let (from, to) = (before.at.cell, self.footing.at.cell);
        if from != to {
            let portal = self.changed(&before, false);
            let pair = if from < to { (from, to) } else { (to, from) };
            if portal && self.footing.is_standing() && self.stood_in.insert(pair) {
                self.stand();
            }
        }
        self.summary.ended_early.is_none()
    }

    /// Stands still. Every tick is swept, and the cell is looked up afresh beside it.
    fn stand(&mut self) {
        self.summary.doorways += 1;
        for _ in 0..self.options.stand_ticks {
            let before = self.footing;
            self.footing = self.walker.step(&before, Vec2::ZERO);
            self.summary.standing_ticks += 1;
            if self.walker.look_up(&self.footing) != Some(self.footing.at.cell) {
                self.summary.look_ups_that_differ += 1;
            }
            self.record(true);
            if before.at.cell != self.footing.at.cell {
                self.summary.changes_while_standing += 1;
                self.changed(&before, true);
            }
        }
    }

    /// Notes a change of cell. Says whether an opening was crossed.
    fn changed(&mut self, before: &Footing, standing: bool) -> bool {
        let (from, to) = (before.at.cell, self.footing.at.cell);
        let crossed = crossed(self.walker.world(), from, &self.footing.at);
        let portal = crossed.is_some();
        let by = crossed.unwrap_or_else(|| match (from.is_indoor(), to.is_indoor()) {
            (false, false) if from.block() == to.block() => "land cell border".to_owned(),
            (false, false) => "landblock border".to_owned(),
            _ => "no portal between them".to_owned(),
        });
        self.summary.transitions += 1;
        self.summary.through_portals += usize::from(portal);
        if self.options.membership == Membership::Sweep {
            let change = self.change(before, by, portal, standing);
            (self.on_change)(&change);
        }
        portal
    }

    fn change(&self, before: &Footing, by: String, portal: bool, standing: bool) -> Change {
        Change {
            t: self.time(),
            position: short(&self.footing.at),
            from: before.at.cell.to_string(),
            to: self.footing.at.cell.to_string(),
            by,
            portal,
            standing,
        }
    }

    fn time(&self) -> f32 {
        self.trail.len().saturating_sub(1) as f32 * TICK
    }

    fn record(&mut self, standing: bool) {
        let at = self.footing.at;
        self.entered.insert(at.cell);
        let tick = self.trail.len();
        let derived = derive_cell(self.walker.world(), &at);
        let teleported = std::mem::take(&mut self.teleported);
        self.summary.by_sweep.count(at.cell, at.cell, tick, standing, teleported);
        let before = self.summary.by_position.now;
        self.summary.by_position.count(derived, at.cell, tick, standing, teleported);
        let is_static = self.options.membership == Membership::Static;
        let (cell, pos) = if is_static {
            (derived, at.origin() - block_offset(at.cell.block(), derived.block()))
        } else {
            (at.cell, at.origin())
        };
        self.trail.push(TrailStep { t: tick as f32 * TICK, cell, pos, standing });
        if let Some(before) = before.filter(|&before| is_static && before != derived) {
            let by = if teleported { "teleport" } else { "derived from the resting position" };
            let change = Change {
                t: self.time(),
                position: short(&Position::new(cell, pos)),
                from: before.to_string(),
                to: cell.to_string(),
                by: by.to_owned(),
                portal: false,
                standing,
            };
            (self.on_change)(&change);
        }
        (self.on_step)(self.trail.len());
        if self.trail.len() > self.options.max_steps {
            self.end(format!("{} steps are enough", self.options.max_steps));
        }
    }

    fn end(&mut self, why: String) {
        self.summary.ended_early.get_or_insert(why);
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

    fn finish(mut self) -> Result<(Vec<TrailStep>, TourSummary), TourError> {
        let world = self.walker.world();
        let indoor: BTreeSet<CellId> = self.entered.iter().copied().filter(|c| c.is_indoor()).collect();
        let mut connected = indoor.clone();
        let mut open: Vec<CellId> = indoor.iter().copied().collect();
        while let Some(cell) = open.pop() {
            for opening in route::openings(world, cell) {
                if let PortalTarget::Cell(other) = opening.to
                    && world.env_cell(other).is_some()
                    && connected.insert(other)
                {
                    open.push(other);
                }
            }
        }
        let summary = &mut self.summary;
        summary.env_cells = indoor.len();
        summary.env_cells_connected = connected.len();
        summary.land_cells = self.entered.len() - indoor.len();
        summary.not_entered = connected.difference(&indoor).map(ToString::to_string).collect();
        summary.steps = self.trail.len();
        summary.seconds = self.trail.last().map_or(0.0, |step| step.t);
        Ok((self.trail, self.summary))
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

/// A position to the centimetre, without rotation.
fn short(at: &Position) -> String {
    let p = at.origin();
    format!("{} [{:.2} {:.2} {:.2}]", at.cell, p.x, p.y, p.z)
}

/// Which opening lies between two cells, nearest to where the player is now.
fn crossed(world: &World, from: CellId, now: &Position) -> Option<String> {
    let to = now.cell;
    let nearest = |openings: Vec<Opening>, leads: &dyn Fn(&Opening) -> bool| {
        let distance = |o: &Opening| route::distance_to(o, to.block(), now.origin());
        openings
            .into_iter()
            .filter(leads)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let found = match (from.is_indoor(), to.is_indoor()) {
        (true, true) => nearest(route::openings(world, from), &|o| o.to == PortalTarget::Cell(to)),
        (true, false) => nearest(route::openings(world, from), &|o| o.to == PortalTarget::Outside),
        (false, true) => nearest(route::openings(world, to), &|o| o.to == PortalTarget::Outside),
        (false, false) => None,
    }?;
    let own = if found.id.cell == to { "its" } else { "portal" };
    let text = match own {
        "its" => format!("portal {} of {}", found.id.portal, found.id.cell),
        _ => format!("portal {}", found.id.portal),
    };
    Some(format!("{text}, {}", found.in_words()))
}

/// A place to start from: before the entrance of a building that can be walked into, else inside a dungeon.
fn find_start<'w>(world: &'w World, dats: &DatSet) -> Option<(Walker<'w>, Footing)> {
    // Holtburg, where everyone starts, if the files have it.
    let holtburg = BlockId(0xA9B4);
    let infos = dats.cell().iter().filter_map(Result::ok);
    let mut blocks = vec![holtburg];
    let others = infos
        .filter(|entry| RecordKind::of_cell_id(entry.id) == RecordKind::LandBlockInfo)
        .map(|entry| BlockId((entry.id >> 16) as u16))
        .filter(|&block| block != holtburg);
    let mut dungeon = None;
    for block in blocks.drain(..).chain(others) {
        let mut walker = Walker::new(world, block);
        if let Some(footing) = before_an_entrance(&mut walker, block) {
            return Some((walker, footing));
        }
        if dungeon.is_none() {
            dungeon = inside(&mut walker, block).map(|footing| (walker, footing));
        }
    }
    dungeon
}

/// A place some way before an entrance from which it can be walked into.
fn before_an_entrance(walker: &mut Walker<'_>, block: BlockId) -> Option<Footing> {
    let mut openings = route::entrances(walker.world(), block);
    // Doors before windows.
    openings.sort_by(|a, b| b.size().1.total_cmp(&a.size().1).then(a.id.cmp(&b.id)));
    for opening in openings {
        let out = opening.outward.truncate().normalize_or_zero();
        let side = Vec2::new(-out.y, out.x);
        let middle = opening.middle.truncate();
        for distance in [12.0, 9.0, 6.0, 4.0, 2.5, 1.5] {
            for turn in [0.0, 0.4, -0.4] {
                let at = middle + (out + side * turn) * distance;
                let land = CellId::new(block, 0xFFFF);
                let Some(ground) = walker.world().ground_at(land, at.extend(0.0)) else {
                    continue;
                };
                let place = Position::new(ground.cell, ground.point.truncate().extend(ground.z + 0.01));
                if is_inside_a_room(walker.world(), &place) {
                    continue;
                }
                let Some(footing) = walker.put(&place).filter(|f| !f.at.cell.is_indoor()) else {
                    continue;
                };
                if route::in_through(walker, &footing, &opening).is_some() {
                    return Some(footing);
                }
            }
        }
    }
    None
}

/// Whether an outdoor place lies within the walls of a building, where nobody can walk to.
fn is_inside_a_room(world: &World, place: &Position) -> bool {
    let center = place.origin() + Vec3::new(0.0, 0.0, crate::locate::PLAYER_SPHERE_CENTERS[0]);
    let block = world.block(place.cell.block());
    block.is_some_and(|block| block.env_cells().any(|cell| cell.contains_point(center)))
}

/// A place in an env cell of a landblock that one can stand in: in the first cell that one can walk out of, else in the
/// first at all.
fn inside(walker: &mut Walker<'_>, block: BlockId) -> Option<Footing> {
    let block = walker.world().block(block)?;
    let mut first = None;
    for cell in block.env_cells().filter(|cell| !cell.portals.is_empty()) {
        let Some(footing) = within(walker, cell) else {
            continue;
        };
        let indoors = |opening: &Opening| opening.to != PortalTarget::Outside;
        let ways = route::openings(walker.world(), cell.id);
        if ways
            .iter()
            .filter(|o| indoors(o))
            .any(|o| route::out_through(walker, &footing, o).is_some())
        {
            return Some(footing);
        }
        first = first.or(Some(footing));
    }
    first
}

/// A place in a cell that one can stand in.
fn within(walker: &mut Walker<'_>, cell: &EnvCell) -> Option<Footing> {
    let bounds = cell.structure.bounds?.mapped(|p| cell.frame.local_to_global(p));
    let size = bounds.max - bounds.min;
    for (u, v) in [
        (0.5, 0.5),
        (0.3, 0.3),
        (0.7, 0.7),
        (0.3, 0.7),
        (0.7, 0.3),
        (0.5, 0.2),
        (0.2, 0.5),
    ] {
        // From a little above the floor upwards, for floors that are not level.
        for up in [0.02, 0.5, 1.0, 2.0, 4.0] {
            if up > size.z {
                break;
            }
            let at = bounds.min + Vec3::new(size.x * u, size.y * v, up);
            if let Some(footing) = walker.put(&Position::new(cell.id, at))
                && footing.at.cell == cell.id
            {
                return Some(footing);
            }
        }
    }
    None
}
