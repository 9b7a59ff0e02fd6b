//! Player locomotion (`transition.md` 9.5).

use glam::Vec3;
use vestibule_world::Sphere;

/// Step up height of players, metres.
pub const PLAYER_STEP_UP: f32 = 0.6;
/// Step down height of players, metres.
pub const PLAYER_STEP_DOWN: f32 = 1.5;
/// Collision spheres of players, relative to the feet, metres (`evidence.md` E4).
pub const PLAYER_SPHERES: [Sphere; 2] = [
    Sphere::new(Vec3::new(0.0, 0.0, 0.475), 0.48),
    Sphere::new(Vec3::new(0.0, 0.0, 1.35), 0.48),
];
