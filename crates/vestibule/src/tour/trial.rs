//! Trials: running into things on purpose.

use glam::{Vec2, Vec3};
use serde::Serialize;
use vestibule_dat::DatSet;
use vestibule_world::{CellId, Position};

use super::Tour;
use crate::walker::{Footing, TICK};

/// Something that was tried, and what came of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// What was tried.
    pub trial: String,
    /// What should happen.
    pub expected: String,
    /// What happened.
    pub outcome: String,
    /// The cell the player was in afterwards.
    pub cell: String,
    /// When it ended, seconds since the start of the tour.
    pub t: f32,
    /// Whether it went as expected; `None` where the world has no such thing.
    pub passed: Option<bool>,
}

/// How fast the player walks in trials, metres a tick: a run.
pub(super) const PACE: f32 = 4.0 * TICK;
/// Ticks without progress after which a stretch has come to an end.
const IDLE_TICKS: u32 = 12;
/// A tick with less than this is one without progress, metres.
const IDLE: f32 = 0.002;
/// Ticks after which a fall or a jump is given up.
const AIR_TICKS: u32 = 300;

/// A stretch that was walked.
#[derive(Clone, Debug)]
pub(super) struct Walked {
    /// Where it began and ended, in the frame of the walker's routes, metres.
    pub(super) from: Vec3,
    /// Where it ended.
    pub(super) to: Vec3,
    /// Highest and lowest point of the foot.
    pub(super) highest: f32,
    /// Lowest point.
    pub(super) lowest: f32,
    /// Length of the way over the ground.
    pub(super) path: f32,
    /// The cells, in order.
    pub(super) cells: Vec<CellId>,
    /// It came to a stop before its time.
    pub(super) stopped: bool,
}

impl Walked {
    /// How far it led into a direction, metres.
    pub(super) fn along(&self, direction: Vec2) -> f32 {
        (self.to - self.from)
            .truncate()
            .dot(direction.normalize_or_zero())
    }

    /// How much higher it ended, metres.
    pub(super) fn rise(&self) -> f32 {
        self.to.z - self.from.z
    }

    /// The player never left the cell it started in.
    pub(super) fn one_cell(&self) -> bool {
        self.cells.len() == 1
    }

    /// All cells were outdoors.
    pub(super) fn outdoors(&self) -> bool {
        self.cells.iter().all(|cell| !cell.is_indoor())
    }

    /// Another stretch after it.
    pub(super) fn then(mut self, next: Walked) -> Walked {
        self.to = next.to;
        self.highest = self.highest.max(next.highest);
        self.lowest = self.lowest.min(next.lowest);
        self.path += next.path;
        self.stopped = next.stopped;
        for cell in next.cells {
            if self.cells.last() != Some(&cell) {
                self.cells.push(cell);
            }
        }
        self
    }
}

impl Tour<'_, '_> {
    /// Runs into everything there is to run into.
    pub(super) fn run_trials(&mut self, dats: &DatSet) {
        self.stops = false;
        match self.guide.clone() {
            Some(guide) => self.try_hollow(&guide),
            None => self.try_somewhere(dats),
        }
        self.stops = true;
    }

    /// One trial, from a place. `run` says whether it went as expected, and how it went.
    pub(super) fn attempt(
        &mut self,
        trial: &str,
        expected: &str,
        from: Option<Position>,
        run: impl FnOnce(&mut Self) -> (bool, String),
    ) {
        if self.summary.ended_early.is_some() {
            return;
        }
        let place = from.and_then(|from| self.walker.put(&from));
        let (passed, outcome) = match (from, place) {
            (Some(from), None) => (false, format!("nobody can stand at {from}")),
            (None, None) => (false, "the place is not in this world".to_owned()),
            (_, Some(place)) => {
                self.teleport(place);
                run(self)
            }
        };
        self.report(trial, expected, outcome, Some(passed));
    }

    /// Notes that the world has nothing to try this with.
    pub(super) fn not_present(&mut self, trial: &str, expected: &str, why: &str) {
        self.report(trial, expected, why.to_owned(), None);
    }

    /// Notes the outcome of what was tried without [`Tour::attempt`].
    pub(super) fn report_after(&mut self, trial: &str, expected: &str, outcome: String, passed: bool) {
        self.report(trial, expected, outcome, Some(passed));
    }

    fn report(&mut self, trial: &str, expected: &str, outcome: String, passed: Option<bool>) {
        let cell = self.footing.at.cell;
        let name = self
            .guide
            .as_ref()
            .map_or_else(|| cell.to_string(), |guide| guide.name(cell));
        self.summary.trials.push(Trial {
            trial: trial.to_owned(),
            expected: expected.to_owned(),
            outcome,
            cell: name,
            t: self.time(),
            passed,
        });
    }

    /// Walks by `offset` a tick, until it gets nowhere or the ticks are over.
    pub(super) fn push(&mut self, offset: Vec2, ticks: u32) -> Walked {
        self.stretch(ticks, |_| Some(offset))
    }

    /// Walks to a point of the routes' frame, until it is there, gets nowhere, or the ticks are over.
    pub(super) fn walk_to(&mut self, point: Vec2, ticks: u32) -> Walked {
        self.stretch(ticks, |here| {
            let left = point - here.truncate();
            (left.length() > 0.03).then(|| left.clamp_length_max(PACE))
        })
    }

    /// In the air until it stands again; goes on by `offset` a tick.
    pub(super) fn land(&mut self, offset: Vec2) -> Walked {
        let mut walked = self.begin();
        for _ in 0..AIR_TICKS {
            if !self.tick(offset) {
                break;
            }
            self.note(&mut walked);
            if self.footing.is_standing() {
                walked.stopped = true;
                break;
            }
        }
        walked
    }

    /// Jumps off at `up` m/s, goes on by `offset` a tick, and lands.
    pub(super) fn leap(&mut self, up: f32, offset: Vec2) -> Walked {
        self.footing = self.walker.jump(&self.footing, up);
        self.land(offset)
    }

    /// Stands for some ticks.
    pub(super) fn wait(&mut self, ticks: u32) -> Walked {
        let mut walked = self.begin();
        for _ in 0..ticks {
            if !self.tick(Vec2::ZERO) {
                break;
            }
            self.note(&mut walked);
        }
        walked
    }

    fn stretch(&mut self, ticks: u32, mut next: impl FnMut(Vec3) -> Option<Vec2>) -> Walked {
        let mut walked = self.begin();
        let mut idle = 0;
        for _ in 0..ticks {
            let here = self.walker.point(&self.footing.at);
            let Some(offset) = next(here) else { break };
            if !self.tick(offset) {
                break;
            }
            let there = self.note(&mut walked);
            idle = if there.distance(here) < IDLE { idle + 1 } else { 0 };
            if idle >= IDLE_TICKS {
                walked.stopped = true;
                break;
            }
        }
        walked
    }

    fn begin(&self) -> Walked {
        let here = self.walker.point(&self.footing.at);
        Walked {
            from: here,
            to: here,
            highest: here.z,
            lowest: here.z,
            path: 0.0,
            cells: vec![self.footing.at.cell],
            stopped: false,
        }
    }

    fn note(&self, walked: &mut Walked) -> Vec3 {
        let here = self.walker.point(&self.footing.at);
        walked.path += here.truncate().distance(walked.to.truncate());
        walked.to = here;
        walked.highest = walked.highest.max(here.z);
        walked.lowest = walked.lowest.min(here.z);
        let cell = self.footing.at.cell;
        if walked.cells.last() != Some(&cell) {
            walked.cells.push(cell);
        }
        here
    }

    /// Whether a stretch in a direction would end in a stop within the cell, tried without taking it: how far it leads.
    pub(super) fn would_stop(&mut self, from: &Footing, offset: Vec2, ticks: u32) -> Option<f32> {
        let mut now = *from;
        let start = self.walker.point(&now.at);
        let mut idle = 0;
        for _ in 0..ticks {
            let here = self.walker.point(&now.at);
            now = self.walker.step(&now, offset);
            let there = self.walker.point(&now.at);
            if now.at.cell != from.at.cell || !now.is_standing() {
                return None;
            }
            idle = if there.distance(here) < IDLE { idle + 1 } else { 0 };
            if idle >= IDLE_TICKS {
                return Some(there.distance(start));
            }
        }
        None
    }
}
