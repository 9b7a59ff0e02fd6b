//! Many bodies at once: a [`Population`] stepped on several threads, with one outcome whatever their number.

use std::collections::{BTreeMap, HashMap};
use std::hash::BuildHasherDefault;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use glam::Vec3;
use vestibule_world::constants::SQUARE_LENGTH;
use vestibule_world::{CellEntry, CellId, LandCoord, Position, World};

use crate::body::Body;
use crate::error::SweepError;
use crate::population::{BodyId, CellHasher, Event, Population};
use crate::set_position::Placement;
use crate::sweep::{Scratch, Swept, Touch};
use crate::update::Motive;

/// Names a body of a [`Simulation`]: the caller's choice, any number that is used once.
pub type BodyKey = u64;

/// Sweeps that one thread takes on at a time.
const CHUNK: usize = 64;
/// Side of the squares in which moved bodies are remembered, metres.
const SQUARE: f32 = 4.0;
/// What a sweep may feel beyond its spheres, metres: a step aside from ledges, and rounding.
const SLACK: f32 = 0.6;

/// Bodies that move on together.
///
/// A step has three parts. First every body integrates its own motion; then all sweeps are made, on as many threads
/// as wanted, through the world as it was; then, in the order of their keys, bodies are written back. A sweep that
/// passed near a body which has been written back in the same step is made again first. So the outcome is that of
/// one body after the other, in the order of their keys, whatever the number of threads and the order in which the
/// bodies were added.
///
/// ```no_run
/// use vestibule_physics::{Body, Placement, Simulation};
/// # fn demo(world: &vestibule_world::World, start: vestibule_world::Position) -> Result<(), Box<dyn std::error::Error>> {
/// let mut simulation = Simulation::new(2);
/// simulation.add(7, Body::player(), Placement::at(start));
/// for _ in 0..30 {
///     simulation.step(world, 1.0 / 30.0);
/// }
/// println!("{:?}", simulation.body(7).map(|body| body.position()));
/// # Ok(()) }
/// ```
#[derive(Debug, Default)]
pub struct Simulation {
    population: Population,
    threads: usize,
    ids: BTreeMap<BodyKey, BodyId>,
    keys: BTreeMap<BodyId, BodyKey>,
    arriving: BTreeMap<BodyKey, (Body, Placement)>,
    leaving: Vec<BodyKey>,
    now: f64,
    scratch: Scratch,
    events: Vec<Event>,
    problems: Vec<(BodyKey, SweepError)>,
    moved: MovedBodies,
    reach: Reach,
}

/// What a step came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepReport {
    /// Sweeps made on all threads.
    pub sweeps: usize,
    /// Sweeps made again, because a body nearby had moved.
    pub again: usize,
    /// Bodies in more than one piece of time, which were stepped one after the other.
    pub alone: usize,
}

/// A body about to be swept.
#[derive(Clone, Copy, Debug)]
struct Move {
    id: BodyId,
    motive: Motive,
}

/// What a sweep found, with what it left in its scratch.
#[derive(Debug)]
struct Found {
    swept: Result<Swept, SweepError>,
    cells: core::ops::Range<u32>,
    touched: core::ops::Range<u32>,
}

/// The finds of one chunk of moves.
#[derive(Debug, Default)]
struct Chunk {
    first: usize,
    found: Vec<Found>,
    cells: Vec<CellEntry>,
    touched: Vec<Touch>,
}

impl Simulation {
    /// No bodies. `threads`: how many make sweeps, the caller's among them; at least one.
    pub fn new(threads: usize) -> Self {
        Self::with_population(Population::new(), threads)
    }

    /// Over an empty population with settings of its own.
    pub fn with_population(population: Population, threads: usize) -> Self {
        Simulation {
            population,
            threads: threads.max(1),
            scratch: Scratch::new(),
            ..Self::default()
        }
    }

    /// How many threads make sweeps.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Makes sweeps on so many threads from now on. The outcome does not change.
    pub fn set_threads(&mut self, threads: usize) {
        self.threads = threads.max(1);
    }

    /// The time that steps have reached, seconds.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// Adds a body, which is placed when the next step begins. A key that is in use replaces its body.
    pub fn add(&mut self, key: BodyKey, body: Body, placement: Placement) {
        self.arriving.insert(key, (body, placement));
    }

    /// Takes a body out when the next step begins.
    pub fn remove(&mut self, key: BodyKey) {
        self.arriving.remove(&key);
        self.leaving.push(key);
    }

    /// The body with this key, once it has been placed.
    pub fn body(&self, key: BodyKey) -> Option<&Body> {
        self.population.body(*self.ids.get(&key)?)
    }

    /// The body with this key, to change how it moves.
    pub fn body_mut(&mut self, key: BodyKey) -> Option<&mut Body> {
        self.population.body_mut(*self.ids.get(&key)?)
    }

    /// All placed bodies in the order of their keys.
    pub fn bodies(&self) -> impl Iterator<Item = (BodyKey, &Body)> {
        self.ids
            .iter()
            .filter_map(|(&key, &id)| Some((key, self.population.body(id)?)))
    }

    /// All placed bodies, to tell each how to move on, in the order of their keys.
    pub fn for_each_body(&mut self, mut act: impl FnMut(BodyKey, &mut Body)) {
        for (&key, &id) in &self.ids {
            if let Some(body) = self.population.body_mut(id) {
                act(key, body);
            }
        }
    }

    /// Number of placed bodies.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether no body has been placed.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// The population behind it.
    pub fn population(&self) -> &Population {
        &self.population
    }

    /// The key of a body that an [`Event`] names.
    pub fn key(&self, id: BodyId) -> Option<BodyKey> {
        self.keys.get(&id).copied()
    }

    /// What happened in the last step, body after body in the order of their keys.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Bodies that could not be placed or moved in the last step.
    pub fn problems(&self) -> &[(BodyKey, SweepError)] {
        &self.problems
    }

    /// Moves all bodies on by `seconds`.
    pub fn step(&mut self, world: &World, seconds: f64) -> StepReport {
        self.events.clear();
        self.problems.clear();
        self.admit(world);
        self.now += seconds;
        let mut report = StepReport::default();
        let mut moves = Vec::with_capacity(self.ids.len());
        let mut alone = Vec::new();
        for (&key, &id) in &self.ids {
            match self.population.begin_update(&mut self.scratch, id, self.now) {
                Ok(Some(Motive::Alone)) => alone.push(id),
                Ok(Some(motive)) => moves.push(Move { id, motive }),
                Ok(None) => {}
                Err(e) => self.problems.push((key, e)),
            }
        }
        report.sweeps = moves.len();
        let chunks = self.sweep_all(world, &moves);
        self.moved.clear();
        for chunk in &chunks {
            for (k, found) in chunk.found.iter().enumerate() {
                if let Some(m) = moves.get(chunk.first + k) {
                    report.again += usize::from(self.write_back(world, m, chunk, found));
                }
            }
        }
        for id in alone {
            report.alone += 1;
            let done = self.population.update(world, &mut self.scratch, id, self.now);
            self.events.extend_from_slice(self.scratch.events());
            self.note(id, done.err());
        }
        report
    }

    /// A number that tells two states apart: of every body its key, cell, position, rotation, velocity, contact and
    /// shadow cells, to the bit.
    pub fn hash(&self) -> u64 {
        let mut hash = Fnv(0xCBF2_9CE4_8422_2325);
        for (key, body) in self.bodies() {
            hash.add(key as u32);
            hash.add((key >> 32) as u32);
            hash.add(body.cell().map_or(0, |c| c.0));
            hash.add(body.position().cell.0);
            let rotation = body.position().frame.rotation();
            hash.vec(body.position().origin());
            for n in [rotation.x, rotation.y, rotation.z, rotation.w] {
                hash.add(n.to_bits());
            }
            hash.vec(body.velocity);
            hash.vec(body.sliding_normal);
            hash.add(u32::from(body.is_on_walkable()));
            if let Some(contact) = body.contact {
                hash.vec(contact.plane.normal);
                hash.add(contact.plane.d.to_bits());
                hash.add(contact.cell.0);
            }
            for cell in body.shadow_cells() {
                hash.add(cell.0);
            }
        }
        hash.0
    }

    /// Lets bodies in and out, in the order of their keys.
    fn admit(&mut self, world: &World) {
        self.leaving.sort_unstable();
        for key in core::mem::take(&mut self.leaving) {
            self.take_out(key);
        }
        for (key, (body, placement)) in core::mem::take(&mut self.arriving) {
            self.take_out(key);
            self.reach.widen(&body);
            let id = self.population.add(body);
            if let Some(body) = self.population.body_mut(id) {
                body.update_time = self.now;
            }
            self.ids.insert(key, id);
            self.keys.insert(id, key);
            let placed = self
                .population
                .set_position(world, &mut self.scratch, id, &placement);
            self.events.extend_from_slice(self.scratch.events());
            self.note(id, placed.err());
        }
    }

    fn take_out(&mut self, key: BodyKey) {
        if let Some(id) = self.ids.remove(&key) {
            self.keys.remove(&id);
            self.population.remove(id);
        }
    }

    fn note(&mut self, id: BodyId, problem: Option<SweepError>) {
        if let (Some(problem), Some(&key)) = (problem, self.keys.get(&id)) {
            self.problems.push((key, problem));
        }
    }

    /// Makes all sweeps, each through the population as it is.
    fn sweep_all(&self, world: &World, moves: &[Move]) -> Vec<Chunk> {
        let count = moves.len().div_ceil(CHUNK);
        let threads = self.threads.min(count);
        if threads <= 1 {
            let mut scratch = Scratch::new();
            let chunk = |k: usize| k * CHUNK;
            return (0..count)
                .map(|k| self.sweep_chunk(world, moves, chunk(k), &mut scratch))
                .collect();
        }
        let next = AtomicUsize::new(0);
        let done: Mutex<Vec<Chunk>> = Mutex::new(Vec::with_capacity(count));
        let work = || {
            let mut scratch = Scratch::new();
            let mut own = Vec::new();
            loop {
                let k = next.fetch_add(1, Ordering::Relaxed);
                if k >= count {
                    break;
                }
                own.push(self.sweep_chunk(world, moves, k * CHUNK, &mut scratch));
            }
            done.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .append(&mut own);
        };
        std::thread::scope(|scope| {
            for _ in 1..threads {
                scope.spawn(work);
            }
            work();
        });
        let mut chunks = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        chunks.sort_unstable_by_key(|chunk| chunk.first);
        chunks
    }

    fn sweep_chunk(&self, world: &World, moves: &[Move], first: usize, scratch: &mut Scratch) -> Chunk {
        let mut chunk = Chunk {
            first,
            ..Chunk::default()
        };
        for m in moves.iter().skip(first).take(CHUNK) {
            let (cells, touched) = (chunk.cells.len() as u32, chunk.touched.len() as u32);
            scratch.touched.clear();
            let swept = match m.motive {
                Motive::Sweep { to, .. } => self.population.sweep(world, scratch, m.id, &to),
                Motive::Alone => Err(SweepError::NoSuchBody),
            };
            chunk.cells.extend_from_slice(scratch.cells());
            chunk.touched.extend_from_slice(scratch.touched());
            chunk.found.push(Found {
                swept,
                cells: cells..chunk.cells.len() as u32,
                touched: touched..chunk.touched.len() as u32,
            });
        }
        chunk
    }

    /// Writes a body back. Returns whether its sweep had to be made again.
    fn write_back(&mut self, world: &World, m: &Move, chunk: &Chunk, found: &Found) -> bool {
        let Motive::Sweep { from, to, q } = m.motive else {
            return false;
        };
        // A sweep ends no farther from its start than it was asked to go, but for steps up and down.
        let asked = from.offset_to(&to);
        let asked = libm::sqrtf(asked.dot(asked));
        let across = asked + 2.0 * self.reach.across + SLACK;
        let along = asked + 2.0 * self.reach.along + SLACK + self.reach.step;
        let again = self.moved.any_near(&from, across, along);
        let swept = if again {
            self.population.sweep(world, &mut self.scratch, m.id, &to)
        } else {
            let cells = found.cells.start as usize..found.cells.end as usize;
            let touched = found.touched.start as usize..found.touched.end as usize;
            self.scratch.resume(
                chunk.cells.get(cells).unwrap_or(&[]),
                chunk.touched.get(touched).unwrap_or(&[]),
            );
            found.swept
        };
        self.scratch.events.clear();
        match swept {
            Ok(swept) => {
                self.population
                    .end_update(world, &mut self.scratch, m.id, &from, &to, q, &swept);
                if let Some(body) = self.population.body(m.id) {
                    let now = *body.position();
                    self.moved.add(&from);
                    self.moved.add(&now);
                }
            }
            Err(e) => {
                // As `Population::update` does.
                if let Some(body) = self.population.body_mut(m.id) {
                    body.halt();
                }
                self.note(m.id, Some(e));
            }
        }
        self.events.extend_from_slice(self.scratch.events());
        again
    }
}

/// How far the largest bodies reach from their origins, metres.
#[derive(Clone, Copy, Debug, Default)]
struct Reach {
    across: f32,
    along: f32,
    /// How far they step up or down.
    step: f32,
}

impl Reach {
    fn widen(&mut self, body: &Body) {
        let (shape, scale) = (body.shape(), body.scale());
        let mut add = |center: Vec3, radius: f32, height: f32| {
            let across = libm::sqrtf(center.x * center.x + center.y * center.y) + radius;
            self.across = larger(self.across, across * scale);
            self.along = larger(self.along, (center.z.abs() + radius + height) * scale);
        };
        let sorting = shape.sorting_sphere;
        add(sorting.center, sorting.radius, 0.0);
        for sphere in &shape.spheres {
            add(sphere.center, sphere.radius, 0.0);
        }
        for cylinder in &shape.cylspheres {
            add(cylinder.low_point, cylinder.radius, cylinder.height);
        }
        for part in &shape.parts {
            if let Some(sphere) = part.model.as_ref().and_then(|model| model.physics_sphere) {
                // Parts may be turned by their body's frame.
                let center = part.frame.local_to_global(sphere.center);
                let far = libm::sqrtf(center.dot(center)) + sphere.radius;
                add(Vec3::ZERO, far * larger(1.0, part.scale.abs().max_element()), 0.0);
            }
        }
        let step = larger(shape.step_up_height, shape.step_down_height);
        self.step = larger(self.step, step * scale);
    }
}

fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Where bodies have moved in this step, by squares of the map.
#[derive(Debug, Default)]
struct MovedBodies {
    /// For each square the places in it that bodies left or came to, as a chain through `places`.
    squares: HashMap<CellId, u32, BuildHasherDefault<CellHasher>>,
    places: Vec<(Vec3, Option<u32>)>,
}

impl MovedBodies {
    fn clear(&mut self) {
        self.squares.clear();
        self.places.clear();
    }

    fn add(&mut self, at: &Position) {
        let place = global(at);
        let index = self.places.len() as u32;
        let before = self.squares.insert(square(place.x, place.y), index);
        self.places.push((place, before));
    }

    /// Whether a body has moved within `across` of a place sideways and `along` up or down.
    fn any_near(&self, at: &Position, across: f32, along: f32) -> bool {
        if self.places.is_empty() {
            return false;
        }
        let p = global(at);
        let (mut x, end_x, end_y) = (p.x - across, p.x + across + SQUARE, p.y + across + SQUARE);
        while x < end_x {
            let mut y = p.y - across;
            while y < end_y {
                let mut next = self.squares.get(&square(x, y)).copied();
                while let Some(&(place, before)) = next.and_then(|i| self.places.get(i as usize)) {
                    let apart = (place - p).abs();
                    if apart.x < across && apart.y < across && apart.z < along {
                        return true;
                    }
                    next = before;
                }
                y += SQUARE;
            }
            x += SQUARE;
        }
        false
    }
}

/// Metres from the south-west corner of the map.
fn global(at: &Position) -> Vec3 {
    let LandCoord { x, y } = at.cell.block().corner();
    at.origin() + Vec3::new(x as f32 * SQUARE_LENGTH, y as f32 * SQUARE_LENGTH, 0.0)
}

/// The square of a place, as a number that hashes well.
fn square(x: f32, y: f32) -> CellId {
    let at = |v: f32| libm::floorf(v / SQUARE) as i32 as u32 & 0xFFFF;
    CellId(at(x) << 16 | at(y))
}

/// The hash of Fowler, Noll and Vo.
struct Fnv(u64);

impl Fnv {
    fn add(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }

    fn vec(&mut self, v: Vec3) {
        for n in v.to_array() {
            self.add(n.to_bits());
        }
    }
}
