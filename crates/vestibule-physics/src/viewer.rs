//! The camera as a mover (`transition.md` 3.8). Its sweep from the player's head, with what to do when that fails, is
//! `vestibule_view::update_viewer`.

use glam::Vec3;
use vestibule_world::Sphere;

use crate::constants::VIEWER_SPHERE_RADIUS;
use crate::flags::ObjectState;
use crate::sweep::Mover;

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
