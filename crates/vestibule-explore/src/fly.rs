//! A camera that flies where it likes, to look at a traversal that is held.

use glam::{Quat, Vec2, Vec3};
use vestibule_view::Camera;
use vestibule_world::{CellId, Frame};

use crate::keys::Held;

/// A free camera. It keeps the cell it set out from, whose landblock its numbers belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyCamera {
    cell: CellId,
    eye: Vec3,
    /// Radians to the left of north.
    turn: f32,
    /// Radians upwards.
    pitch: f32,
    /// Metres a second.
    speed: f32,
}

impl From<&Camera> for FlyCamera {
    fn from(camera: &Camera) -> Self {
        let f = camera.forward();
        FlyCamera {
            cell: camera.cell(),
            eye: camera.eye(),
            turn: libm::atan2f(-f.x, f.y),
            pitch: libm::asinf(f.z.clamp(-1.0, 1.0)),
            speed: 6.0,
        }
    }
}

impl FlyCamera {
    fn rotation(&self) -> Quat {
        Quat::from_rotation_z(self.turn) * Quat::from_rotation_x(self.pitch)
    }

    /// Turns by radians to the right and down.
    pub fn look(&mut self, delta: Vec2) {
        self.turn -= delta.x;
        self.pitch = (self.pitch - delta.y).clamp(-1.55, 1.55);
    }

    /// Flies faster by steps of the wheel.
    pub fn faster(&mut self, steps: f32) {
        if steps.is_finite() {
            let factor = libm::powf(1.25, steps.clamp(-8.0, 8.0));
            self.speed = (self.speed * factor).clamp(0.5, 200.0);
        }
    }

    /// Flies for `dt` seconds.
    pub fn tick(&mut self, held: &Held, dt: f32) {
        let axis = |plus: bool, minus: bool| f32::from(i8::from(plus) - i8::from(minus));
        let ahead = Vec3::new(axis(held.right, held.left), axis(held.forward, held.back), 0.0);
        let up = Vec3::Z * axis(held.jump, held.down);
        let speed = if held.slow { self.speed * 0.25 } else { self.speed };
        self.turn += axis(held.turn_left, held.turn_right) * 1.6 * dt;
        self.eye += (self.rotation() * ahead + up) * speed * dt;
        // A camera a thousand kilometres away would be refused.
        self.eye = self.eye.clamp(Vec3::splat(-20_000.0), Vec3::splat(20_000.0));
    }

    /// The camera; `None` for a screen without area.
    pub fn camera(&self, fov_y: f32, viewport: Vec2) -> Option<Camera> {
        let frame = Frame::new(self.eye, self.rotation());
        Camera::from_frame(self.cell, &frame, fov_y, viewport).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_sets_out_where_the_other_camera_is_and_flies_ahead() {
        let at = CellId(0xA9B4_0001);
        let size = Vec2::new(200.0, 100.0);
        let forward = Vec3::new(0.6, 0.7, -0.2).normalize();
        let held_camera = Camera::new(at, Vec3::new(3.0, 4.0, 5.0), forward, Vec3::Z, 1.0, size).unwrap();
        let mut fly = FlyCamera::from(&held_camera);
        let camera = fly.camera(1.0, size).unwrap();
        assert!((camera.forward() - forward).length() < 1e-5 && camera.eye() == held_camera.eye());
        let held = Held {
            forward: true,
            ..Held::default()
        };
        fly.tick(&held, 0.5);
        let gone = fly.camera(1.0, size).unwrap().eye() - held_camera.eye();
        assert!((gone - forward * 3.0).length() < 1e-4, "{gone}");
        fly.look(Vec2::new(0.0, 100.0));
        assert!(fly.camera(1.0, size).is_some(), "straight down is not reached");
    }
}
