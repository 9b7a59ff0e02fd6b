//! The camera's sweep (retail `update_viewer`, `transition.md` 3.8).

use glam::Vec3;
use vestibule_world::{CellId, Position, Sphere, World, adjust_position};

use crate::constants::VIEWER_SPHERE_RADIUS;
use crate::error::SweepError;
use crate::flags::ObjectState;
use crate::population::Population;
use crate::sweep::{Carried, Mover, Scratch, sweep};

/// Where the camera is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewer {
    /// Its place.
    pub position: Position,
    /// The cell its own sweep ended in: what is seen starts from here. It is not the player's cell. `None` when
    /// the camera could not be placed and sits at the player's position.
    pub cell: Option<CellId>,
}

/// Whom the camera follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewerSubject {
    /// The player as a mover, see [`crate::Body::mover`].
    pub mover: Mover,
    /// Where the player is.
    pub position: Position,
    /// The cell it is in; without one the camera stays at the player's position.
    pub cell: Option<CellId>,
    /// Where the camera starts, the player's head, in the landblock frame of `position`, metres.
    pub pivot: Vec3,
}

/// The camera as a mover: one sphere that stops exactly where it touches, in the body of `player` for what
/// concerns steps and whom it passes.
pub fn viewer_mover(player: &Mover) -> Mover {
    let sphere = Sphere::new(Vec3::ZERO, VIEWER_SPHERE_RADIUS);
    // The sphere is a constant and fine.
    let mut mover = Mover::new(&[sphere]).unwrap_or(*player);
    mover.step_up_height = player.step_up_height;
    mover.step_down_height = player.step_down_height;
    mover.physics = player.physics;
    mover.kind = player.kind;
    mover.body = player.body;
    mover.state = ObjectState::IS_VIEWER
        | ObjectState::PATH_CLIPPED
        | ObjectState::FREE_ROTATE
        | ObjectState::PERFECT_CLIP;
    mover
}

/// Pulls the camera from the player's pivot to the position sought for it, stopping at walls.
///
/// `sought` is where the camera wants to be, in any landblock.
///
/// # Errors
/// Input that is not finite, or a camera too far away.
pub fn sweep_viewer(
    world: &World,
    population: &Population,
    scratch: &mut Scratch,
    subject: &ViewerSubject,
    sought: &Position,
) -> Result<Viewer, SweepError> {
    let ViewerSubject {
        mover: player,
        position: player_position,
        cell: player_cell,
        pivot,
    } = subject;
    let at_player = Viewer {
        position: *player_position,
        cell: None,
    };
    let Some(player_cell) = *player_cell else {
        return Ok(at_player);
    };
    let mut begin = *player_position;
    begin.cell = player_cell;
    begin.frame.origin = *pivot;
    if player_cell.is_indoor()
        && let Some(adjusted) = adjust_position(world, &begin, Vec3::ZERO, true).filter(|a| a.resident)
    {
        begin = adjusted.position;
    }
    let mut end = *sought;
    end.frame.origin += vestibule_world::ids::block_offset(begin.cell.block(), sought.cell.block());
    end.cell = begin.cell;
    let mover = viewer_mover(player);
    let swept = sweep(
        world,
        population,
        scratch,
        &mover,
        &Carried::default(),
        &begin,
        &end,
    )?;
    if swept.ok {
        return Ok(Viewer {
            position: swept.position,
            cell: swept.cell,
        });
    }
    match adjust_position(world, sought, Vec3::ZERO, true) {
        Some(found) => {
            let cell = found.resident.then_some(found.position.cell);
            Ok(Viewer {
                position: found.position,
                cell,
            })
        }
        None => Ok(at_player),
    }
}
