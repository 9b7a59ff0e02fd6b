//! `SetPosition`: placing and teleporting bodies (`transition.md` 9.7, `world.md` 16).

use glam::Vec3;
use vestibule_world::{CellId, Position, World, adjust_position};

use crate::constants::PLACEMENT_ACCEPTANCE;
use crate::error::SweepError;
use crate::flags::{ObjectKind, ObjectState, SetPositionFlags};
use crate::population::{BodyId, Population};
use crate::sweep::{Scratch, place};

/// How `SetPosition` ended (`transition.md` 2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SetPositionError {
    /// Something was run into at the place.
    #[error("something is in the way at the place")]
    Collided,
    /// The place is taken, or the body would have been pushed away from it.
    #[error("the place is taken, or the body does not fit there")]
    NoValidPosition,
    /// The place is in no cell.
    #[error("the place is in no cell")]
    NoCell,
}

impl SetPositionError {
    /// Retail's number for it; 0 stands for success, 1 for a general failure and 0x100 for invalid arguments.
    pub const fn code(self) -> u32 {
        match self {
            SetPositionError::NoValidPosition => 2,
            SetPositionError::NoCell => 3,
            SetPositionError::Collided => 4,
        }
    }
}

/// Where a placed body went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placed {
    /// Into this cell.
    InCell(CellId),
    /// Nowhere yet: the cell is not resident, and the body waits for it ("lost cell").
    Lost,
}

/// Where and how to place a body. Start from [`Placement::at`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The position wanted; its cell names at least a cell nearby.
    pub position: Position,
    /// How.
    pub flags: SetPositionFlags,
    /// How far scattered tries go on x and y, metres.
    pub scatter_radius: (f32, f32),
    /// How many scattered tries there are.
    pub scatter_tries: u32,
    /// Seed of the scattering.
    pub scatter_seed: u64,
}

impl Placement {
    /// At a position, beside it when it is taken (retail `SetPositionSimple` with sliding).
    pub fn at(position: Position) -> Self {
        Placement {
            position,
            flags: SetPositionFlags::SEND_POSITION_EVENT
                | SetPositionFlags::TELEPORT
                | SetPositionFlags::SLIDE,
            scatter_radius: (0.0, 0.0),
            scatter_tries: 0,
            scatter_seed: 1,
        }
    }

    /// The same with other flags.
    #[must_use]
    pub fn with_flags(self, flags: SetPositionFlags) -> Self {
        Placement { flags, ..self }
    }
}

impl Population {
    /// Places a body: the cell is looked up, the body put out of what is solid and down onto the ground, and
    /// moved aside if the flags allow. On failure it stays where it was. Teleports are this too.
    ///
    /// # Errors
    /// The outer error is bad input, the inner one retail's answer.
    pub fn set_position(
        &mut self,
        world: &World,
        scratch: &mut Scratch,
        id: BodyId,
        placement: &Placement,
    ) -> Result<Result<Placed, SetPositionError>, SweepError> {
        scratch.events.clear();
        self.body(id).ok_or(SweepError::NoSuchBody)?;
        let (x, y) = placement.scatter_radius;
        if !placement.position.is_finite() || !x.is_finite() || !y.is_finite() {
            return Err(SweepError::NotFinite { what: "placement" });
        }
        let mut last = Ok(Err(SetPositionError::NoValidPosition));
        if !placement.flags.has(SetPositionFlags::RANDOMSCATTER) {
            last = self.try_position(world, scratch, id, placement, placement.position);
            let scatter = placement.flags.has(SetPositionFlags::SCATTER);
            if !(scatter && matches!(last, Ok(Err(_)))) {
                return last;
            }
        }
        let mut draw = Draws(placement.scatter_seed | 1);
        for _ in 0..placement.scatter_tries {
            let mut position = placement.position;
            position.frame.origin += Vec3::new(draw.next() * x, draw.next() * y, 0.0);
            last = self.try_position(world, scratch, id, placement, position);
            if !matches!(last, Ok(Err(_))) {
                break;
            }
        }
        last
    }

    fn try_position(
        &mut self,
        world: &World,
        scratch: &mut Scratch,
        id: BodyId,
        placement: &Placement,
        position: Position,
    ) -> Result<Result<Placed, SetPositionError>, SweepError> {
        let Some(body) = self.body(id) else {
            return Err(SweepError::NoSuchBody);
        };
        let mut mover = body.mover(Some(id));
        // Nothing of the mover's state counts (9.7.1) but what the game says of it.
        mover.state = ObjectState::NONE;
        let foot = mover.spheres().first().map_or(Vec3::ZERO, |s| s.center);
        let found = adjust_position(world, &position, foot, true);
        let Some(at) = found.filter(|a| a.resident).map(|a| a.position) else {
            let at = found.map_or(position, |a| a.position);
            self.lose(id, &at, scratch);
            return Ok(Ok(Placed::Lost));
        };
        if body.kind.has(ObjectKind::FORCED_PLACEMENT) {
            self.force_into_cell(world, scratch, id, &at);
            return Ok(Ok(Placed::InCell(at.cell)));
        }
        let slide = placement.flags.has(SetPositionFlags::SLIDE);
        let keep_cells = placement.flags.has(SetPositionFlags::DONOTCREATECELLS);
        let mut swept = place(world, self, scratch, &mover, &at, slide, keep_cells)?;
        if swept.ok && !slide {
            let pushed = swept.position.origin() - at.origin();
            let near = |d: f32| {
                let d = if self.settings().signed_placement_acceptance {
                    d
                } else {
                    d.abs()
                };
                d < PLACEMENT_ACCEPTANCE
            };
            swept.ok = near(pushed.x) && near(pushed.y) && swept.position.cell == at.cell;
        }
        if !swept.ok {
            let reported = self.handle_all_collisions(scratch, id, &swept, false);
            let error = if reported {
                SetPositionError::Collided
            } else {
                SetPositionError::NoValidPosition
            };
            return Ok(Err(error));
        }
        let Some(cell) = swept.cell else {
            return Ok(Err(SetPositionError::NoCell));
        };
        self.commit(world, scratch, id, &swept);
        Ok(Ok(Placed::InCell(cell)))
    }

    /// Tries again to place the bodies that wait for a cell which has become resident (`world.md` Z1). Returns
    /// how many came back.
    pub fn recover_lost(&mut self, world: &World, scratch: &mut Scratch) -> usize {
        let waiting: Vec<BodyId> = self
            .lost()
            .filter(|&(_, cell)| world.is_resident(cell))
            .map(|(id, _)| id)
            .collect();
        let mut recovered = 0;
        for id in waiting {
            let Some(position) = self.body(id).map(|b| b.position) else {
                continue;
            };
            let placed = self.set_position(world, scratch, id, &Placement::at(position));
            recovered += usize::from(matches!(placed, Ok(Ok(Placed::InCell(_)))));
        }
        recovered
    }
}

/// Uniform draws in -1…1 (64-bit xorshift).
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 40) as f32 / (1u64 << 23) as f32) - 1.0
    }
}
