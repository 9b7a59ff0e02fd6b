//! The camera: an eye in a cell, the directions it looks and the screen (`rendering.md` 2.5-2.6).

use core::cmp::Ordering;

use glam::{Quat, Vec2, Vec3};
use vestibule_world::ids::block_offset;
use vestibule_world::{BlockId, CellId, Frame};

use crate::constants::NEAR_PLANE;

/// Eyes farther than this from their landblock's corner are refused, metres: the whole map measures 49 km.
pub(crate) const FARTHEST_EYE: f32 = 1.0e6;

/// Why a camera cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// The eye has a coordinate that is not finite, or lies a thousand kilometres away.
    #[error("the eye position is not finite or lies far outside any world")]
    Eye,
    /// The view or up direction is not finite, zero, or both are parallel.
    #[error("the view direction and the up direction must be finite, not zero and not parallel")]
    Direction,
    /// The vertical field of view is not inside 0…π.
    #[error("the vertical field of view must lie between 0 and 180 degrees, both excluded")]
    FieldOfView,
    /// The viewport has no area.
    #[error("the viewport must be at least one pixel wide and high")]
    Viewport,
}

/// An eye, the directions it looks, and the screen it fills.
///
/// Camera axes are x right, y forward, z up (`rendering.md` 2.6); the identity looks north. The eye is in metres
/// in the frame of the landblock of [`Camera::cell`], the cell the traversal starts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    cell: CellId,
    eye: Vec3,
    axes: [Vec3; 3],
    slopes: Vec2,
    viewport: Vec2,
    near: f32,
}

impl Camera {
    /// A camera at `eye`, in the frame of the landblock of `cell`, looking along `forward` with `up` upwards on
    /// the screen (they need be neither unit nor at right angles). `fov_y` is the whole vertical angle of view in
    /// radians, `viewport` the width and height of the screen in pixels; the aspect follows from it.
    ///
    /// # Errors
    /// When a number is not finite, the directions do not span a plane, the angle is not inside 0…π, or the
    /// viewport is empty.
    pub fn new(
        cell: CellId,
        eye: Vec3,
        forward: Vec3,
        up: Vec3,
        fov_y: f32,
        viewport: Vec2,
    ) -> Result<Self, CameraError> {
        if !(eye.is_finite() && eye.abs().max_element() <= FARTHEST_EYE) {
            return Err(CameraError::Eye);
        }
        let forward = unit(forward).ok_or(CameraError::Direction)?;
        let right =
            unit(forward.cross(unit(up).ok_or(CameraError::Direction)?)).ok_or(CameraError::Direction)?;
        let up = right.cross(forward);
        if !(fov_y > 0.0 && fov_y < core::f32::consts::PI) {
            return Err(CameraError::FieldOfView);
        }
        if !(viewport.x >= 1.0 && viewport.y >= 1.0 && viewport.is_finite()) {
            return Err(CameraError::Viewport);
        }
        let slope_z = libm::tanf(fov_y * 0.5);
        let slope_x = slope_z * (viewport.x / viewport.y);
        if !(slope_x > 1.0e-6 && slope_z > 1.0e-6 && slope_x < 1.0e6 && slope_z < 1.0e6) {
            return Err(CameraError::FieldOfView);
        }
        Ok(Camera {
            cell,
            eye,
            axes: [right, forward, up],
            slopes: Vec2::new(slope_x, slope_z),
            viewport,
            near: NEAR_PLANE,
        })
    }

    /// A camera in the pose of a frame: its y axis is forward, its z axis up.
    ///
    /// # Errors
    /// As [`Camera::new`].
    pub fn from_frame(cell: CellId, frame: &Frame, fov_y: f32, viewport: Vec2) -> Result<Self, CameraError> {
        let [_, forward, up] = frame.axes();
        Camera::new(cell, frame.origin, forward, up, fov_y, viewport)
    }

    /// The same camera in another cell: `eye` is re-expressed in the frame of that cell's landblock.
    #[must_use]
    pub fn in_cell(&self, cell: CellId) -> Self {
        Camera {
            cell,
            eye: self.eye_in(cell.block()),
            ..*self
        }
    }

    /// The same camera with another near plane, metres. Used for drawing and sphere tests, never for portals.
    #[must_use]
    pub fn with_near(mut self, near: f32) -> Self {
        if near > 0.0 && near.is_finite() {
            self.near = near;
        }
        self
    }

    /// The viewer's cell.
    pub fn cell(&self) -> CellId {
        self.cell
    }

    /// The eye in the frame of the landblock of [`Camera::cell`], metres.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// The eye in the frame of another landblock, metres (`visibility.md` 14.2).
    pub fn eye_in(&self, block: BlockId) -> Vec3 {
        // Offsets are whole multiples of 192 m, exact in f32; the sum is rounded once.
        self.eye + block_offset(block, self.cell.block())
    }

    /// Right, forward and up, unit vectors.
    pub fn axes(&self) -> &[Vec3; 3] {
        &self.axes
    }

    /// The direction the camera looks, unit.
    pub fn forward(&self) -> Vec3 {
        self.axes[1]
    }

    /// Tangents of the half angles of view: horizontal and vertical.
    pub fn slopes(&self) -> Vec2 {
        self.slopes
    }

    /// Width and height of the screen, pixels.
    pub fn viewport(&self) -> Vec2 {
        self.viewport
    }

    /// Distance of the near plane, metres.
    pub fn near(&self) -> f32 {
        self.near
    }

    /// The rotation from camera to landblock axes.
    pub fn rotation(&self) -> Quat {
        Quat::from_mat3(&glam::Mat3::from_cols(self.axes[0], self.axes[1], self.axes[2]))
    }

    /// An eye-relative direction (landblock axes) in camera axes: x right, y forward, z up.
    #[inline]
    pub fn to_camera(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.axes[0].dot(v), self.axes[1].dot(v), self.axes[2].dot(v))
    }

    /// The direction (camera axes) as an eye-relative direction in landblock axes.
    #[inline]
    pub fn from_camera(&self, v: Vec3) -> Vec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    /// Where an eye-relative direction falls on the screen: pixels from the top left corner, y down
    /// (`rendering.md` 2.6). `None` for directions that do not point forward.
    #[inline]
    pub fn project(&self, v: Vec3) -> Option<Vec2> {
        let c = self.to_camera(v);
        if c.y.partial_cmp(&0.0) != Some(Ordering::Greater) {
            return None;
        }
        let x = c.x / (c.y * self.slopes.x);
        let z = c.z / (c.y * self.slopes.y);
        Some(Vec2::new(
            (1.0 + x) * 0.5 * self.viewport.x,
            (1.0 - z) * 0.5 * self.viewport.y,
        ))
    }

    /// The eye-relative direction, not normalised, through a point of the screen in pixels.
    pub fn ray_through(&self, pixel: Vec2) -> Vec3 {
        let x = (2.0 * pixel.x / self.viewport.x - 1.0) * self.slopes.x;
        let z = (1.0 - 2.0 * pixel.y / self.viewport.y) * self.slopes.y;
        self.from_camera(Vec3::new(x, 1.0, z))
    }
}

/// Retail's vertical field of view for an aspect (width by height): `game_fov / (aspect - 0.1)`, clamped to
/// 0.1…2.8 radians (`rendering.md` 2.5). `game_fov` is π/2 by default.
pub fn retail_fov_y(game_fov: f32, aspect: f32) -> f32 {
    let fov = game_fov / (aspect - 0.1);
    if fov >= 0.1 {
        if fov > 2.8 { 2.8 } else { fov }
    } else if fov > 0.0 {
        0.1
    } else {
        // An aspect of 0.1 or less (or no number) asks for the widest view.
        2.8
    }
}

/// The vector at unit length; `None` when it has no direction.
pub(crate) fn unit(v: Vec3) -> Option<Vec3> {
    // Scaled first, so that neither tiny nor huge vectors over- or underflow.
    let largest = v.abs().max_element();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let v = v / largest;
    let length = v.dot(v).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(fov: f32) -> Result<Camera, CameraError> {
        Camera::new(
            CellId(0xA9B4_0100),
            Vec3::new(0.0, 0.0, 1.5),
            Vec3::Y,
            Vec3::Z,
            fov,
            Vec2::splat(512.0),
        )
    }

    #[test]
    fn a_90_degree_camera_projects_as_the_worked_examples_say() {
        let camera = camera(core::f32::consts::FRAC_PI_2).unwrap();
        let p = camera.project(Vec3::new(0.2, 1.0, -0.3)).unwrap();
        assert!((p - Vec2::new(307.2, 332.8)).length() < 1e-3, "{p}");
        assert!((camera.ray_through(p) - Vec3::new(0.2, 1.0, -0.3)).length() < 1e-5);
        assert_eq!(camera.project(-Vec3::Y), None);
    }

    #[test]
    fn bad_numbers_are_errors_not_cameras() {
        assert_eq!(camera(0.0), Err(CameraError::FieldOfView));
        assert_eq!(camera(core::f32::consts::PI), Err(CameraError::FieldOfView));
        assert_eq!(camera(f32::NAN), Err(CameraError::FieldOfView));
        let make = |eye, forward, up| Camera::new(CellId(1), eye, forward, up, 1.0, Vec2::splat(64.0));
        assert_eq!(make(Vec3::NAN, Vec3::Y, Vec3::Z), Err(CameraError::Eye));
        assert_eq!(make(Vec3::ZERO, Vec3::NAN, Vec3::Z), Err(CameraError::Direction));
        assert_eq!(make(Vec3::ZERO, Vec3::Z, Vec3::Z), Err(CameraError::Direction));
        assert_eq!(make(Vec3::ZERO, Vec3::ZERO, Vec3::Z), Err(CameraError::Direction));
        let small = Camera::new(CellId(1), Vec3::ZERO, Vec3::Y, Vec3::Z, 1.0, Vec2::ZERO);
        assert_eq!(small, Err(CameraError::Viewport));
    }

    #[test]
    fn r2_5_field_of_view_of_a_wide_screen() {
        let fov = retail_fov_y(core::f32::consts::FRAC_PI_2, 16.0 / 9.0);
        assert!((fov - 0.936).abs() < 1e-3);
        assert_eq!(retail_fov_y(core::f32::consts::FRAC_PI_2, 0.1), 2.8);
    }

    #[test]
    fn the_eye_moves_between_blocks_by_whole_offsets() {
        let a = Camera::new(
            CellId(0xA9B4_0001),
            Vec3::new(191.0, 5.0, 2.0),
            Vec3::Y,
            Vec3::Z,
            1.0,
            Vec2::splat(8.0),
        );
        let there = a.unwrap().in_cell(CellId(0xAAB4_0001));
        assert_eq!(there.eye(), Vec3::new(-1.0, 5.0, 2.0));
    }
}
