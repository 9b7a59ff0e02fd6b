//! How players and creatures move by themselves (`transition.md` 9.5).

use glam::Vec3;
use vestibule_world::{Frame, Sphere};

use crate::body::root_motion;
use crate::constants::EPSILON;

/// Step up height of players, metres.
pub const PLAYER_STEP_UP: f32 = 0.6;
/// Step down height of players, metres.
pub const PLAYER_STEP_DOWN: f32 = 1.5;
/// Collision spheres of players, relative to the feet, metres (`evidence.md` E4).
pub const PLAYER_SPHERES: [Sphere; 2] = [
    Sphere::new(Vec3::new(0.0, 0.0, 0.475), 0.48),
    Sphere::new(Vec3::new(0.0, 0.0, 1.35), 0.48),
];
/// Walking speed, m/s.
pub const WALK_SPEED: f32 = 3.12;
/// Running speed at run rate 1, m/s.
pub const RUN_SPEED: f32 = 4.0;
/// Side-stepping speed at rate 1, m/s.
pub const SIDESTEP_SPEED: f32 = 1.25;
/// Turning speed, radians per second. Ours: the chapter gives none.
pub const TURN_SPEED: f32 = core::f32::consts::FRAC_PI_2;
/// Run rate of skills that go off the scale.
pub const MAX_RUN_RATE: f32 = 4.5;

/// What a walker is told to do. Each is a share of the full speed, -1 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Motion {
    /// Forwards; negative walks backwards.
    pub forward: f32,
    /// To the right.
    pub sidestep: f32,
    /// Turns to the right, clockwise seen from above.
    pub turn: f32,
    /// Runs instead of walking.
    pub run: bool,
}

/// The legs of a player or creature: skills and what they are told to do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Locomotion {
    /// What it is told to do.
    pub motion: Motion,
    /// Multiplies the running speed, see [`run_rate`].
    pub run_rate: f32,
    /// Multiplies the side-stepping speed.
    pub side_rate: f32,
    /// Jump skill.
    pub jump_skill: f32,
    /// Share of jumping and running left by what it carries, 0 to 1.
    pub load: f32,
    /// Strength of the jump that is about to begin, 0 to 1.
    pub(crate) jump_extent: f32,
}

impl Default for Locomotion {
    /// A player without skills: run rate 1, jumps 0.35 m.
    fn default() -> Self {
        Locomotion {
            motion: Motion::default(),
            run_rate: 1.0,
            side_rate: 1.0,
            jump_skill: 0.0,
            load: 1.0,
            jump_extent: 0.0,
        }
    }
}

impl Locomotion {
    /// A player with these run and jump skills and nothing to carry.
    pub fn with_skills(run: f32, jump: f32) -> Self {
        Locomotion {
            run_rate: run_rate(run, 1.0),
            jump_skill: jump,
            ..Locomotion::default()
        }
    }

    /// Velocity of the motion it is told, body-local, m/s: x right, y forwards.
    pub fn state_velocity(&self) -> Vec3 {
        let m = &self.motion;
        let forward = if m.run {
            RUN_SPEED * self.run_rate
        } else {
            WALK_SPEED
        };
        let v = Vec3::new(
            m.sidestep * SIDESTEP_SPEED * self.side_rate,
            m.forward * forward,
            0.0,
        );
        if v.is_finite() { v } else { Vec3::ZERO }
    }

    /// Displacement and turn of `q` seconds of motion, body-local.
    pub fn root_motion(&self, q: f32) -> Frame {
        let turn = -self.motion.turn * TURN_SPEED * q;
        root_motion(
            self.state_velocity() * q,
            if turn.is_finite() { turn } else { 0.0 },
        )
    }

    /// Velocity with which it leaves the ground, body-local: its motion, at most at running speed, and the jump.
    pub(crate) fn leave_ground_velocity(&self) -> Vec3 {
        let mut v = self.state_velocity();
        let limit = RUN_SPEED * self.run_rate;
        let speed = crate::math::length(v);
        if speed > limit && speed > 0.0 {
            v = v / speed * limit;
        }
        Vec3::new(v.x, v.y, jump_speed(self.jump_skill, self.load, self.jump_extent))
    }
}

/// Multiplier of the running speed for a run skill and the share of strength that burden leaves.
pub fn run_rate(skill: f32, load: f32) -> f32 {
    if skill >= 800.0 {
        MAX_RUN_RATE
    } else {
        (load * (skill / (skill + 200.0)) * 11.0 + 4.0) / 4.0
    }
}

/// Height of a jump, metres, for a jump skill, the share that burden leaves and the power 0…1.
pub fn jump_height(skill: f32, load: f32, power: f32) -> f32 {
    let height = load * (skill / (skill + 1300.0) * 22.2 + 0.05) * power;
    if height > 0.35 { height } else { 0.35 }
}

/// Upward speed of a jump, m/s; none without extent.
pub fn jump_speed(skill: f32, load: f32, extent: f32) -> f32 {
    if extent < EPSILON {
        return 0.0;
    }
    let extent = if extent > 1.0 { 1.0 } else { extent };
    (19.6 * jump_height(skill, load, extent)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn w56_jump_speeds() {
        let speed = |h: f32| (19.6 * h).sqrt();
        assert!((speed(1.0) - 4.427_189).abs() < 1e-5 && (speed(2.0) - 6.260_99).abs() < 1e-5);
        assert!((jump_speed(0.0, 1.0, 1.0) - 2.619_160_2).abs() < 1e-5);
        assert_eq!(jump_speed(300.0, 1.0, 0.0), 0.0);
    }

    #[test]
    fn w57_skills() {
        assert!((jump_height(300.0, 1.0, 1.0) - 4.2125).abs() < 1e-4);
        assert!((jump_speed(300.0, 1.0, 1.0) - 9.086_529).abs() < 1e-4);
        assert!((run_rate(200.0, 1.0) - 2.375).abs() < 1e-6);
        assert_eq!(run_rate(800.0, 0.1), 4.5);
    }

    #[test]
    fn s9_5_speeds() {
        let mut legs = Locomotion::with_skills(200.0, 0.0);
        legs.motion = Motion {
            forward: 1.0,
            run: true,
            ..Motion::default()
        };
        assert!((legs.state_velocity().y - 9.5).abs() < 1e-5);
        legs.motion.run = false;
        assert!((legs.state_velocity().y - 3.12).abs() < 1e-6);
        legs.motion.sidestep = 1.0;
        assert!((legs.state_velocity().x - 1.25).abs() < 1e-6);
    }
}
