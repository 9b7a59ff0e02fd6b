//! Walks a player to a place or by a script, tick by tick.

use vestibule_physics::{Body, BodyId, Motion, Placement, Population, Scratch, SweepError, TransientState};
use vestibule_world::{Position, World};

use crate::route::{self, PortalId, Steer, Steering};
use crate::tour::{STEP, TrailStep};
use crate::walker::{Footing, TICK, Walker};

/// Ways that are tried before a target is given up.
const TRIES: usize = 24;
/// Ticks that a stretch of a script gets at most.
const STRETCH_TICKS: u32 = 30 * 120;
/// Ticks without progress after which a stretch ends.
const STUCK_TICKS: u32 = 20;

/// Why a walk cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WalkError {
    /// Nobody can stand at the start.
    #[error("nobody can stand at {0}: it is in no cell, inside something, or nothing is below it")]
    BadStart(Position),
    /// The target is in no cell, or one cannot stand there.
    #[error("nobody can stand at the target {0}")]
    BadTarget(Position),
    /// No way leads there on foot.
    #[error("no way on foot leads from {from} to {to}")]
    NoWay {
        /// Where the walk came to.
        from: String,
        /// Where it should have led.
        to: String,
    },
    /// A line of a script cannot be read.
    #[error("line {line}, column {column}: {problem}")]
    Script {
        /// Line, from 1.
        line: usize,
        /// Column of the first wrong character, from 1.
        column: usize,
        /// What is wrong there.
        problem: String,
    },
    /// The body cannot be swept.
    #[error(transparent)]
    Sweep(#[from] SweepError),
}

/// Walks to a place on foot, through as few openings as lead there, in steps of 5 cm.
///
/// # Errors
/// Start or target are nowhere to stand, or no way leads from one to the other.
pub fn to_target(world: &World, from: &Position, to: &Position) -> Result<Vec<TrailStep>, WalkError> {
    let mut walker = Walker::new(world, from.cell.block());
    let mut footing = walker.put(from).ok_or(WalkError::BadStart(*from))?;
    let target = walker.put(to).ok_or(WalkError::BadTarget(*to))?;
    let mut trail = vec![step_of(&footing, 0)];
    let mut barred: Vec<PortalId> = Vec::new();
    let lost = |footing: &Footing| WalkError::NoWay {
        from: footing.at.to_string(),
        to: to.to_string(),
    };
    'tries: for _ in 0..TRIES {
        let passages = route::passages(world, footing.at.cell, target.at.cell, &barred);
        for passage in passages.ok_or_else(|| lost(&footing))? {
            let way = passage.way(&mut walker, &footing);
            let arrived = |cell| passage.leads_to(cell);
            if !way.is_some_and(|way| follow(&mut walker, &mut footing, &way, &mut trail, &arrived)) {
                barred.push(passage.opening.id);
                continue 'tries;
            }
        }
        let goal = walker.point(&target.at);
        let way = route::to_point(&mut walker, &footing, goal.truncate());
        let cell = target.at.cell;
        let arrived = |other| route::same_side(cell, other);
        if way.is_some_and(|way| follow(&mut walker, &mut footing, &way, &mut trail, &arrived)) {
            return Ok(trail);
        }
        break;
    }
    Err(lost(&footing))
}

fn step_of(footing: &Footing, ticks: usize) -> TrailStep {
    let at = &footing.at;
    TrailStep {
        t: ticks as f32 * TICK,
        cell: at.cell,
        pos: at.origin(),
        standing: false,
        teleported: false,
    }
}

fn follow(
    walker: &mut Walker<'_>,
    footing: &mut Footing,
    way: &[glam::Vec2],
    trail: &mut Vec<TrailStep>,
    arrived: &dyn Fn(vestibule_world::CellId) -> bool,
) -> bool {
    let mut steering = Steering::new(way, STEP);
    loop {
        let here = walker.point(&footing.at).truncate();
        match steering.next(here, arrived(footing.at.cell)) {
            Steer::Arrived => return true,
            Steer::Lost => return false,
            Steer::Go(offset) => {
                *footing = walker.step(footing, offset);
                trail.push(step_of(footing, trail.len()));
            }
        }
    }
}

/// A line of a script.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stretch {
    /// Moves on: how, and how far over the ground, metres.
    Move(Motion, f32),
    /// Turns to the right by this many degrees.
    Turn(f32),
    /// Jumps with 0 to 1 of its strength, keeping its motion, and goes on until it stands.
    Jump(f32),
    /// Does nothing for some seconds.
    Wait(f32),
}

/// Reads a script: a command a line, `#` begins a remark.
///
/// `walk 3`, `run 3`, `back 1`, `left 1`, `right 1` go some metres; `turn 90` turns to the right by degrees; `jump 0.5`
/// jumps; `wait 2` waits some seconds.
///
/// ```
/// let script = vestibule::walk::read_script("walk 3\nturn 90 # to the right\njump 1").unwrap();
/// assert_eq!(script.len(), 3);
/// assert!(vestibule::walk::read_script("fly 3").unwrap_err().to_string().starts_with("line 1, column 1"));
/// ```
///
/// # Errors
/// Names line and column of what is not understood.
pub fn read_script(text: &str) -> Result<Vec<Stretch>, WalkError> {
    let mut out = Vec::new();
    for (line, full) in (1..).zip(text.lines()) {
        let body = full.split('#').next().unwrap_or("");
        let mut words = body.split_whitespace();
        let Some(verb) = words.next() else { continue };
        let column_of = |word: &str| {
            let offset = word.as_ptr() as usize - full.as_ptr() as usize;
            full.get(..offset).map_or(1, |before| before.chars().count() + 1)
        };
        let fail = |word: &str, problem: String| WalkError::Script {
            line,
            column: column_of(word),
            problem,
        };
        let forward = Motion {
            forward: 1.0,
            ..Motion::default()
        };
        let motion = match verb {
            "walk" => Some(forward),
            "run" => Some(Motion { run: true, ..forward }),
            "back" => Some(Motion {
                forward: -1.0,
                ..Motion::default()
            }),
            "left" => Some(Motion {
                sidestep: -1.0,
                ..Motion::default()
            }),
            "right" => Some(Motion {
                sidestep: 1.0,
                ..Motion::default()
            }),
            "turn" | "jump" | "wait" => None,
            _ => {
                let problem =
                    format!("'{verb}' is no command; walk, run, back, left, right, turn, jump and wait are");
                return Err(fail(verb, problem));
            }
        };
        let Some(word) = words.next() else {
            return Err(fail(verb, format!("'{verb}' needs a number after it")));
        };
        let number: f32 = match word.parse::<f32>() {
            Ok(number)
                if number.is_finite() && (verb == "turn" || number >= 0.0) && number.abs() <= 10_000.0 =>
            {
                number
            }
            _ => {
                return Err(fail(
                    word,
                    format!("'{word}' is no number that '{verb}' can take"),
                ));
            }
        };
        if let Some(extra) = words.next() {
            return Err(fail(extra, format!("unexpected '{extra}'")));
        }
        out.push(match (motion, verb) {
            (Some(motion), _) => Stretch::Move(motion, number),
            (None, "turn") => Stretch::Turn(number),
            (None, "jump") => Stretch::Jump(number),
            _ => Stretch::Wait(number),
        });
    }
    Ok(out)
}

/// Moves a player's body by a script, with gravity and everything else that moves a body, thirty ticks a second.
///
/// # Errors
/// The player cannot be placed at the start.
pub fn by_script(world: &World, from: &Position, script: &[Stretch]) -> Result<Vec<TrailStep>, WalkError> {
    let mut run = Run::start(world, from)?;
    for stretch in script {
        run.stretch(stretch)?;
    }
    Ok(run.trail)
}

struct Run<'w> {
    world: &'w World,
    population: Population,
    scratch: Scratch,
    id: BodyId,
    ticks: u32,
    trail: Vec<TrailStep>,
}

impl<'w> Run<'w> {
    fn start(world: &'w World, from: &Position) -> Result<Self, WalkError> {
        let (mut population, mut scratch) = (Population::new(), Scratch::new());
        let id = population.add(Body::player());
        let placed = population.set_position(world, &mut scratch, id, &Placement::at(*from))?;
        if placed.is_err() || population.body(id).is_none_or(|body| body.cell().is_none()) {
            return Err(WalkError::BadStart(*from));
        }
        let mut run = Run {
            world,
            population,
            scratch,
            id,
            ticks: 0,
            trail: Vec::new(),
        };
        run.record();
        Ok(run)
    }

    fn position(&self) -> Option<Position> {
        self.population.body(self.id).map(|body| *body.position())
    }

    fn record(&mut self) {
        let Some(body) = self.population.body(self.id) else {
            return;
        };
        let (cell, pos) = (body.cell().unwrap_or_default(), body.position().origin());
        self.trail.push(TrailStep {
            t: self.ticks as f32 * TICK,
            cell,
            pos,
            standing: false,
            teleported: false,
        });
    }

    fn set_motion(&mut self, motion: Motion) {
        if let Some(body) = self.population.body_mut(self.id) {
            if let Some(legs) = &mut body.locomotion {
                legs.motion = motion;
            }
            body.transient.set(TransientState::ACTIVE, true);
        }
    }

    /// One tick; answers how far the body came over the ground, metres.
    fn tick(&mut self) -> Result<f32, WalkError> {
        let before = self.position().unwrap_or_default();
        self.ticks += 1;
        let now = f64::from(self.ticks) * f64::from(TICK);
        self.population
            .update(self.world, &mut self.scratch, self.id, now)?;
        self.record();
        let after = self.position().unwrap_or_default();
        Ok(before.offset_to(&after).with_z(0.0).length())
    }

    fn on_ground(&self) -> bool {
        self.population.body(self.id).is_some_and(Body::is_on_walkable)
    }

    fn stretch(&mut self, stretch: &Stretch) -> Result<(), WalkError> {
        match *stretch {
            Stretch::Move(motion, metres) => {
                self.set_motion(motion);
                let (mut gone, mut stuck) = (0.0, 0);
                for _ in 0..STRETCH_TICKS {
                    if gone >= metres || stuck >= STUCK_TICKS {
                        break;
                    }
                    let moved = self.tick()?;
                    stuck = if moved < 0.002 { stuck + 1 } else { 0 };
                    gone += moved;
                }
            }
            Stretch::Turn(degrees) => {
                let speed = vestibule_physics::locomotion::TURN_SPEED;
                let ticks = libm::roundf(degrees.to_radians().abs() / (speed * TICK)) as u32;
                self.set_motion(Motion {
                    turn: if degrees < 0.0 { -1.0 } else { 1.0 },
                    ..Motion::default()
                });
                for _ in 0..ticks.min(STRETCH_TICKS) {
                    self.tick()?;
                }
            }
            Stretch::Jump(extent) => {
                let now = f64::from(self.ticks) * f64::from(TICK);
                if let Some(body) = self.population.body_mut(self.id) {
                    body.jump(extent, now);
                }
                for tick in 0..STRETCH_TICKS {
                    self.tick()?;
                    if tick > 2 && self.on_ground() {
                        break;
                    }
                }
            }
            Stretch::Wait(seconds) => {
                self.set_motion(Motion::default());
                for _ in 0..(seconds / TICK) as u32 {
                    self.tick()?;
                }
            }
        }
        self.set_motion(Motion::default());
        Ok(())
    }
}
