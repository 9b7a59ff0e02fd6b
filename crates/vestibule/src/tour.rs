//! A walk through every cell that can be reached on foot, in and out of everything.
//!
//! [`Tour::run`] plans its route as it goes: from the start over land to the nearest entrance, through the openings of
//! every cell behind it and back, then to the next entrance. The player's cell is carried by the sweeps and never derived
//! from where it rests; what would have come of deriving it is counted beside it ([`MembershipCount`]). In every doorway
//! the player stands still for a while, to show that the cell does not change. Afterwards it runs into everything that
//! there is to run into ([`Trial`]). The chase camera follows and looks at every tick ([`Eye`]).

mod eyes;
mod guide;
mod hollow;
mod membership;
mod somewhere;
mod start;
mod trail;
mod trial;
mod visit;

pub use eyes::{DrawList, Eye, Eyes, Seen, facing, heading_of};
pub use guide::Guide;
pub use membership::{Disagreement, FLICKER_TICKS, Membership, MembershipCount, derive_cell};
pub use trail::{Change, TrailStep, write_trail};
pub use trial::Trial;

use std::collections::BTreeSet;

use glam::{Vec2, Vec3};
use serde::Serialize;
use vestibule_dat::DatSet;
use vestibule_world::ids::block_offset;
use vestibule_world::{CellId, PortalTarget, Position, World};

use self::membership::{Disagreements, Tick};
use self::start::find_start;
use self::trail::{crossed, short};
use crate::route::{self, Opening, PortalId, Steer, Steering};
use crate::walker::{Footing, TICK, Walker};

/// Length of a step, metres.
pub const STEP: f32 = 0.05;

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
    /// Run into things afterwards.
    pub trials: bool,
    /// Look through the chase camera at every tick.
    pub look: bool,
}

impl Default for TourOptions {
    fn default() -> Self {
        TourOptions {
            start: None,
            radius: 1,
            stand_ticks: 100,
            max_steps: 3_000_000,
            membership: Membership::Sweep,
            trials: true,
            look: true,
        }
    }
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
    /// Where the two differ, most frequent first.
    pub disagreements: Vec<Disagreement>,
    /// What the chase camera saw, if it looked.
    pub seen: Option<Seen>,
    /// What was run into, and what came of it.
    pub trials: Vec<Trial>,
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

/// What a tour brings back.
#[derive(Clone, Debug, Default)]
pub struct TourRecord {
    /// Every tick.
    pub trail: Vec<TrailStep>,
    /// The camera at every tick; empty when it did not look.
    pub eyes: Vec<Eye>,
    /// The draw lists that eyes refer to.
    pub lists: Vec<DrawList>,
    /// Counts and outcomes.
    pub summary: TourSummary,
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
    /// Whether to stop in doorways that are new.
    stops: bool,
    eyes: Option<Eyes>,
    looks: Vec<Eye>,
    last_point: Vec3,
    disagreements: Disagreements,
    guide: Option<Guide>,
    /// A place in each of the first env cells visited.
    rooms: Vec<Footing>,
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
    ) -> Result<TourRecord, TourError> {
        let guide = Guide::of(dats);
        let start = options
            .start
            .or_else(|| guide.as_ref().and_then(|guide| guide.start));
        let (walker, footing) = match start {
            Some(start) => {
                let mut walker = Walker::new(world, start.cell.block());
                let footing = walker.put(&start).ok_or(TourError::BadStart(start))?;
                (walker, footing)
            }
            None => find_start(world, dats).ok_or(TourError::NoStart)?,
        };
        let facing = start.map_or(0.0, |start| {
            let ahead = start.frame.local_to_global_vec(Vec3::Y);
            heading_of(ahead.truncate()).unwrap_or(0.0)
        });
        let last_point = walker.point(&footing.at);
        let mut tour = Tour {
            eyes: options.look.then(|| Eyes::new(facing)),
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
            stops: true,
            looks: Vec::new(),
            last_point,
            disagreements: Disagreements::default(),
            guide,
            rooms: Vec::new(),
        };
        tour.record(false);
        if footing.at.cell.is_indoor() {
            tour.visit(footing.at.cell);
        } else {
            tour.visit_entrances();
        }
        if tour.options.trials && tour.summary.ended_early.is_none() {
            tour.run_trials(dats);
        }
        Ok(tour.finish())
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
            if portal && self.stops && self.footing.is_standing() && self.stood_in.insert(pair) {
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
        let number = self.trail.len();
        let world = self.walker.world();
        let derived = derive_cell(world, &at);
        let teleported = std::mem::take(&mut self.teleported);
        let tick = Tick {
            number,
            standing,
            teleported,
        };
        self.summary.by_sweep.count(world, at.cell, at.cell, tick);
        let before = self.summary.by_position.now();
        self.summary.by_position.count(world, derived, at.cell, tick);
        self.disagreements.note(&at, derived);
        let is_static = self.options.membership == Membership::Static;
        let (cell, pos) = if is_static {
            (
                derived,
                at.origin() + block_offset(derived.block(), at.cell.block()),
            )
        } else {
            (at.cell, at.origin())
        };
        self.trail.push(TrailStep {
            t: number as f32 * TICK,
            cell,
            pos,
            standing,
            teleported,
        });
        let point = self.walker.point(&at);
        let went = point - std::mem::replace(&mut self.last_point, point);
        if let Some(eyes) = &mut self.eyes {
            let eye = eyes.look(world, self.walker.population(), &self.footing, went, teleported);
            self.looks.push(eye);
        }
        if let Some(before) = before.filter(|&before| is_static && before != derived) {
            let by = if teleported {
                "teleport"
            } else {
                "derived from the resting position"
            };
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

    fn finish(mut self) -> TourRecord {
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
        summary.disagreements = self.disagreements.list();
        let mut lists = Vec::new();
        if let Some(eyes) = self.eyes {
            let (seen, met) = eyes.finish();
            summary.seen = Some(seen);
            lists = met;
        }
        TourRecord {
            trail: self.trail,
            eyes: self.looks,
            lists,
            summary: self.summary,
        }
    }
}
