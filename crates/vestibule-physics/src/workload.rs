//! The walking workload (`bench/README.md` of the vectors): a closed loop of sweeps that any implementation can
//! run, so that costs can be compared on the same work.

use glam::Vec3;
use vestibule_world::constants::BLOCK_LENGTH;
use vestibule_world::{Position, World};

use crate::constants::EPSILON;
use crate::error::SweepError;
use crate::population::Population;
use crate::sweep::{Carried, Mover, Scratch, sweep};

/// A body of the workload as it starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkloadBody {
    /// Spheres and step heights; no rotation, edge sliding on.
    pub mover: Mover,
    /// Where it starts.
    pub start: Position,
    /// What it carries at the start.
    pub carried: Carried,
}

/// The random numbers of the workload: 64-bit xorshift.
#[derive(Clone, Copy, Debug)]
struct Draws(u64);

impl Draws {
    #[inline]
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[derive(Clone, Copy, Debug)]
struct Walker {
    position: Position,
    carried: Carried,
    heading: f32,
    /// The unit vector of `heading`.
    direction: (f32, f32),
    vz: f32,
}

impl Walker {
    fn turn(&mut self, by: f32) {
        self.heading += by;
        self.direction = (libm::cosf(self.heading), libm::sinf(self.heading));
    }
}

/// What a number of steps came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorkloadTotals {
    /// Steps made.
    pub steps: u64,
    /// Steps that set a collision normal.
    pub collided: u64,
    /// Steps that changed the cell.
    pub changed_cell: u64,
    /// Sum of all positions reached, so that the work cannot be left out and two runs can be compared.
    pub checksum: f64,
}

impl WorkloadTotals {
    /// Share of steps with a collision normal.
    pub fn collided_share(&self) -> f64 {
        self.collided as f64 / self.steps.max(1) as f64
    }

    /// Share of steps that changed the cell.
    pub fn changed_cell_share(&self) -> f64 {
        self.changed_cell as f64 / self.steps.max(1) as f64
    }
}

/// The workload in progress.
#[derive(Debug)]
pub struct Workload<'w> {
    world: &'w World,
    population: Population,
    scratch: Scratch,
    bodies: Vec<WorkloadBody>,
    walkers: Vec<Walker>,
    draws: Draws,
    next: usize,
    totals: WorkloadTotals,
}

impl<'w> Workload<'w> {
    /// The workload over these bodies, usually 100. Without any, steps do nothing.
    pub fn new(world: &'w World, bodies: Vec<WorkloadBody>) -> Self {
        let mut draws = Draws(88_172_645_463_325_252);
        let walkers = bodies
            .iter()
            .map(|body| {
                let mut walker = Walker {
                    position: body.start,
                    carried: body.carried,
                    heading: 0.0,
                    direction: (1.0, 0.0),
                    vz: 0.0,
                };
                walker.turn((2.0 * core::f64::consts::PI * draws.next()) as f32);
                walker
            })
            .collect();
        Workload {
            world,
            population: Population::new(),
            scratch: Scratch::new(),
            bodies,
            walkers,
            draws,
            next: 0,
            totals: WorkloadTotals::default(),
        }
    }

    /// Makes `count` steps.
    ///
    /// # Errors
    /// A body whose numbers cannot be swept.
    pub fn run(&mut self, count: u64) -> Result<(), SweepError> {
        if self.bodies.is_empty() {
            return Ok(());
        }
        for _ in 0..count {
            self.step()?;
        }
        Ok(())
    }

    /// What all steps so far came to.
    pub fn totals(&self) -> WorkloadTotals {
        self.totals
    }

    fn step(&mut self) -> Result<(), SweepError> {
        let index = self.next;
        self.next = if index + 1 == self.bodies.len() {
            0
        } else {
            index + 1
        };
        let body = &self.bodies[index];
        let walker = &mut self.walkers[index];
        if self.draws.next() < 0.1 {
            walker.turn(((self.draws.next() - 0.5) * 3.0) as f32);
        }
        let d = (0.1 + 0.2 * self.draws.next()) as f32;
        let mut offset = Vec3::new(walker.direction.0 * d, walker.direction.1 * d, 0.0);
        if walker.carried.contact.is_some() && walker.carried.on_walkable {
            walker.vz = 0.0;
        } else {
            walker.vz -= 9.8 / 30.0;
            offset.z = walker.vz / 30.0;
        }
        self.totals.steps += 1;
        let mut to = walker.position;
        to.frame.origin += offset;
        let moved = (to.origin() - walker.position.origin()).abs();
        let mut lost = false;
        if moved.x >= EPSILON || moved.y >= EPSILON || moved.z >= EPSILON {
            // Looked at where it is: a result is large.
            let result = sweep(
                self.world,
                &self.population,
                &mut self.scratch,
                &body.mover,
                &walker.carried,
                &walker.position,
                &to,
            );
            let swept = match &result {
                Ok(swept) => swept,
                Err(e) => return Err(*e),
            };
            if swept.ok {
                match swept.cell {
                    Some(cell) => {
                        self.totals.changed_cell += u64::from(cell != walker.position.cell);
                        walker.position = swept.position;
                        walker.position.cell = cell;
                        walker.carried = swept.carried();
                    }
                    None => lost = true,
                }
            }
            if swept.collision_normal.is_some() {
                self.totals.collided += 1;
                walker.turn((2.0 * self.draws.next()) as f32);
            }
        }
        let p = walker.position.origin();
        self.totals.checksum += f64::from(p.x) + f64::from(p.y) + f64::from(p.z);
        if lost || p.z < -100.0 || strays(&walker.position, &body.start) {
            walker.position = body.start;
            walker.carried = body.carried;
            walker.vz = 0.0;
        }
        Ok(())
    }
}

/// Outdoors and out of the starting landblock, or within 8 m of its border.
fn strays(at: &Position, start: &Position) -> bool {
    const MARGIN: f32 = 8.0;
    let inside = MARGIN..BLOCK_LENGTH - MARGIN;
    let p = at.origin();
    !at.cell.is_indoor()
        && (at.cell.block() != start.cell.block() || !inside.contains(&p.x) || !inside.contains(&p.y))
}
