//! A player on foot: moves by sweeps and owns its cell, the way routes are planned and tours are walked.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use vestibule_physics::{Body, BodyId, Carried, Mover, Population, Scratch, place, sweep};
use vestibule_world::ids::block_offset;
use vestibule_world::{BlockId, CellId, Position, Shape, World, adjust_position};

/// Length of a tick, seconds: retail's physics gate (`evidence.md` E4).
pub const TICK: f32 = 1.0 / 30.0;
/// Acceleration of a body in the air, m/s².
const GRAVITY: f32 = 9.8;
/// Falling gets no faster than this, m/s.
const TERMINAL_SPEED: f32 = 50.0;
/// Ticks that a placed body gets to come to rest.
const SETTLE_TICKS: u32 = 300;
/// Largest change of height along a step of a way that can be walked in both directions, metres: a little less than a
/// player steps up.
const MAX_RISE: f32 = 0.55;
/// Longest step of a trial walk, metres.
const TRIAL_STEP: f32 = 0.2;

/// Where a player stands, and what it takes along into its next sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footing {
    /// The cell that the last accepted sweep ended in, and the foot point in the frame of its landblock.
    pub at: Position,
    /// Contact with the ground and what else one sweep hands to the next.
    pub carried: Carried,
    /// Upward speed while in the air, m/s.
    pub rise: f32,
}

impl Footing {
    /// Whether it stands on ground that can be walked on.
    pub fn is_standing(&self) -> bool {
        self.carried.contact.is_some() && self.carried.on_walkable
    }
}

/// Moves players through a world. Cheap to keep: it holds the working memory of sweeps.
pub struct Walker<'w> {
    world: &'w World,
    population: Population,
    scratch: Scratch,
    mover: Mover,
    base: BlockId,
}

impl<'w> Walker<'w> {
    /// A walker whose routes are given in the frame of landblock `base`, metres, also beyond its square.
    pub fn new(world: &'w World, base: BlockId) -> Self {
        let (population, scratch) = (Population::new(), Scratch::new());
        Walker {
            world,
            population,
            scratch,
            mover: Mover::player(),
            base,
        }
    }

    /// The world walked in.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// The bodies that are in the way, such as doors.
    pub fn population(&self) -> &Population {
        &self.population
    }

    /// Puts a door into its frame: a body of this shape, shut. `None` where it cannot be.
    pub fn add_door(&mut self, shape: Arc<Shape>, at: &Position) -> Option<BodyId> {
        let id = self.population.add(Body::new(shape, 1.0).ok()?);
        if self
            .population
            .force_into_cell(self.world, &mut self.scratch, id, at)
        {
            return Some(id);
        }
        self.population.remove(id);
        None
    }

    /// Opens a door, or shuts it again.
    pub fn set_open(&mut self, door: BodyId, open: bool) {
        self.population
            .set_ethereal(self.world, &mut self.scratch, door, open);
    }

    /// Takes a door away.
    pub fn remove_door(&mut self, door: BodyId) {
        self.population.remove(door);
    }

    /// A position's origin in the frame of the routes.
    pub fn point(&self, at: &Position) -> Vec3 {
        block_offset(self.base, at.cell.block()) + at.origin()
    }

    /// A point in the frame of the routes, in the frame of a landblock.
    pub fn local(&self, block: BlockId, point: Vec3) -> Vec3 {
        point - block_offset(self.base, block)
    }

    /// Puts a player down at a position, as a teleport does, and lets it come to rest. `None` where it would be in no
    /// cell or does not fit.
    pub fn put(&mut self, position: &Position) -> Option<Footing> {
        let low = self.mover.spheres().first()?.center;
        let unturned = Position::new(position.cell, position.origin());
        let adjusted = adjust_position(self.world, &unturned, low, true).filter(|a| a.resident)?;
        let at = adjusted.position;
        let placed = place(
            self.world,
            &self.population,
            &mut self.scratch,
            &self.mover,
            &at,
            true,
            true,
        )
        .ok()?;
        let cell = placed.cell.filter(|_| placed.ok)?;
        let at = Position {
            cell,
            ..placed.position
        };
        let mut footing = Footing {
            at,
            carried: placed.carried(),
            rise: 0.0,
        };
        for _ in 0..SETTLE_TICKS {
            if footing.is_standing() {
                return Some(footing);
            }
            footing = self.step(&footing, Vec2::ZERO);
        }
        None
    }

    /// One tick: the player wants to go by `offset` over the ground, metres, and falls where there is none. The cell is
    /// the one the sweep carried it into; when the sweep is not accepted nothing changes.
    pub fn step(&mut self, from: &Footing, offset: Vec2) -> Footing {
        let mut next = *from;
        let mut wanted = offset.extend(0.0);
        if from.is_standing() {
            next.rise = 0.0;
        } else {
            next.rise = (next.rise - GRAVITY * TICK).max(-TERMINAL_SPEED);
            wanted.z = next.rise * TICK;
        }
        let to = Position::new(from.at.cell, from.at.origin() + wanted);
        let Some(at) = self.carry(&mut next, &to) else {
            return next;
        };
        // The head met a ceiling: what is left of the jump is spent.
        let rose = at.origin().z - from.at.origin().z;
        if wanted.z > 0.0 && rose < 0.5 * wanted.z {
            next.rise = 0.0;
        }
        next
    }

    /// Sweeps a footing to a position; where it got to, or `None`, with nothing changed, when the sweep is not accepted.
    fn carry(&mut self, footing: &mut Footing, to: &Position) -> Option<Position> {
        let (population, scratch) = (&self.population, &mut self.scratch);
        let swept = sweep(
            self.world,
            population,
            scratch,
            &self.mover,
            &footing.carried,
            &footing.at,
            to,
        );
        let swept = swept.ok().filter(|swept| swept.ok)?;
        let cell = swept.cell?;
        footing.at = Position {
            cell,
            ..swept.position
        };
        footing.carried = swept.carried();
        Some(footing.at)
    }

    /// One sweep to a point of the frame of the footing's landblock, as recorded moves are followed.
    pub fn sweep_to(&mut self, from: &Footing, to: Vec3) -> Footing {
        let to = Position::new(from.at.cell, to);
        let mut next = *from;
        self.carry(&mut next, &to);
        next
    }

    /// The player jumps: it lets go of the ground and rises at `up` m/s, keeping what it slid along.
    pub fn jump(&self, from: &Footing, up: f32) -> Footing {
        let carried = Carried {
            last_known: from.carried.contact,
            ..Carried::default()
        };
        Footing {
            carried,
            rise: up,
            ..*from
        }
    }

    /// Tries to walk straight to a point of the routes' frame. `None` if something is in the way, the ground is left, a
    /// cell is entered that is not `allowed`, or the way could not be walked back.
    pub fn straight(
        &mut self,
        from: &Footing,
        to: Vec2,
        allowed: &dyn Fn(CellId) -> bool,
    ) -> Option<Footing> {
        let mut now = *from;
        let far = to.distance(self.point(&now.at).truncate());
        let most = (far / TRIAL_STEP) as u32 * 4 + 8;
        for _ in 0..most {
            let here = self.point(&now.at);
            let left = to - here.truncate();
            if left.length() < 0.02 {
                return Some(now);
            }
            let offset = left.clamp_length_max(TRIAL_STEP);
            let next = self.step(&now, offset);
            let there = self.point(&next.at);
            let (gone, rise) = (there.truncate() - here.truncate(), there.z - here.z);
            // On a slope a step covers less ground; a wall or a pillar turns it aside.
            let ahead = gone.dot(offset) / offset.length();
            let aside = gone.perp_dot(offset).abs() / offset.length();
            let astray = ahead < 0.25 * offset.length() || aside > 0.2 * offset.length() + 0.005;
            if astray || !next.is_standing() || rise.abs() > MAX_RISE || !allowed(next.at.cell) {
                return None;
            }
            now = next;
        }
        None
    }

    /// The cell a player is in who stands at `from` and looks up its cell anew, seeded from its own: what membership by
    /// the sweep must agree with at rest.
    pub fn look_up(&mut self, from: &Footing) -> Option<CellId> {
        let mut spheres = [vestibule_world::Sphere::default(); 2];
        let own = self.mover.spheres();
        for (out, sphere) in spheres.iter_mut().zip(own) {
            *out = vestibule_world::Sphere::new(from.at.origin() + sphere.center, sphere.radius);
        }
        let spheres = spheres.get(..own.len()).unwrap_or(&spheres);
        let mut cells = vestibule_world::CellArray::new();
        let (cell, origin) = (from.at.cell, from.at.origin());
        vestibule_world::find_cell_list(self.world, cell, origin, spheres, &mut cells, true).containing
    }
}
