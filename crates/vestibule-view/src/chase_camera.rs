//! The chase camera: where the viewer wants to be (`rendering.md` 4).

use glam::{Quat, Vec2, Vec3};
use vestibule_physics::{Population, Scratch, interpolate_rotation};
use vestibule_world::{Frame, Position, World, normalise};

use crate::camera::unit;
use crate::constants::EPSILON;
use crate::update_viewer::{PIVOT_OFFSET, Viewer, ViewerSource, ViewerTarget, update_viewer};

/// Keyboard steps of zoom, turn and raise in a second (`rendering.md` 4.1).
const ADJUSTMENT_SPEED: f32 = 40.0;
/// A viewer that moved less and turned less stays exactly where it is, metres (`rendering.md` 4.4).
const SNAP_DISTANCE: f32 = 0.0004;
/// The same for each component of its rotation.
const SNAP_ROTATION: f32 = 0.0002;
/// Above this stiffness the camera is rigid.
const RIGID: f32 = 0.9998;
/// A jump of the target farther than this is followed at once, metres (`rendering.md` 4.9).
const TELEPORT_DISTANCE: f32 = 50.0;
/// Shortest boom that zooming in accepts, metres.
const SHORTEST_BOOM: f32 = 0.5;

/// How the camera looks at its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CameraMode {
    /// Behind and above the character.
    #[default]
    Chase,
    /// In the character's head.
    FirstPerson,
    /// Down on the character, 2 m away.
    LookDown,
    /// Down on the land, 450 m away.
    Map,
}

/// The chase camera (retail `CameraManager`): turns the player's pose and the camera controls into a sought position
/// for [`update_viewer`].
#[derive(Clone, Debug, PartialEq)]
pub struct ChaseCamera {
    /// The eye relative to the pivot, in the heading frame (y along the heading), metres.
    pub viewer_offset: Vec3,
    /// The pivot in the character's frame, metres.
    pub pivot_offset: Vec3,
    /// What is looked along when [`ChaseCamera::look_in_direction`] is set, in the character's frame.
    pub direction: Vec3,
    /// How stiffly the eye follows, 0…1; 1 is rigid.
    pub translational_stiffness: f32,
    /// How stiffly the gaze follows, 0…1.
    pub rotational_stiffness: f32,
    /// Follow the slope the character walks on.
    pub align_with_plane: bool,
    /// Look along [`ChaseCamera::direction`].
    pub look_in_direction: bool,
    /// Turn towards the pivot instead of along the heading.
    pub look_at_pivot: bool,
    /// Keep this point in front: a target, in landblock metres of the player's landblock.
    pub target_object: Option<Vec3>,
    mode: CameraMode,
    saved: Option<Saved>,
    velocities: [Vec3; 5],
    velocity_count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Saved {
    viewer_offset: Vec3,
    direction: Vec3,
    translational_stiffness: f32,
    align_with_plane: bool,
    look_in_direction: bool,
    look_at_pivot: bool,
}

impl Default for ChaseCamera {
    fn default() -> Self {
        Self::new(1.0)
    }
}

impl ChaseCamera {
    /// The retail defaults for a character of this scale (`rendering.md` 4.1): 2.61 m away, 17 degrees up.
    pub fn new(character_scale: f32) -> Self {
        let scale = if character_scale.is_finite() && character_scale > 0.0 {
            character_scale
        } else {
            1.0
        };
        ChaseCamera {
            viewer_offset: Vec3::new(0.0, -2.5, 0.75) * scale,
            pivot_offset: PIVOT_OFFSET,
            direction: Vec3::Y,
            translational_stiffness: 0.45,
            rotational_stiffness: 0.45,
            align_with_plane: true,
            look_in_direction: false,
            look_at_pivot: true,
            target_object: None,
            mode: CameraMode::Chase,
            saved: None,
            velocities: [Vec3::ZERO; 5],
            velocity_count: 0,
        }
    }

    /// How the camera looks at its target.
    pub fn mode(&self) -> CameraMode {
        self.mode
    }

    /// Changes the way of looking. Leaving look-down or map restores the view before; leaving first person starts
    /// close behind the head (`rendering.md` 4.1).
    pub fn set_mode(&mut self, mode: CameraMode) {
        if mode == self.mode {
            return;
        }
        let left = self.mode;
        if let Some(saved) = self.saved.take() {
            self.viewer_offset = saved.viewer_offset;
            self.direction = saved.direction;
            self.translational_stiffness = saved.translational_stiffness;
            self.align_with_plane = saved.align_with_plane;
            self.look_in_direction = saved.look_in_direction;
            self.look_at_pivot = saved.look_at_pivot;
        }
        self.mode = mode;
        if mode == CameraMode::Chase {
            if left == CameraMode::FirstPerson {
                self.viewer_offset = Vec3::new(0.0, -0.6, 0.5);
            }
            return;
        }
        self.saved = Some(Saved {
            viewer_offset: self.viewer_offset,
            direction: self.direction,
            translational_stiffness: self.translational_stiffness,
            align_with_plane: self.align_with_plane,
            look_in_direction: self.look_in_direction,
            look_at_pivot: self.look_at_pivot,
        });
        self.align_with_plane = false;
        self.look_in_direction = true;
        self.look_at_pivot = false;
        match mode {
            CameraMode::FirstPerson => {
                self.viewer_offset = Vec3::new(0.0, 0.18, 0.0);
                self.direction = Vec3::Y;
                self.translational_stiffness = 1.0;
            }
            CameraMode::LookDown | CameraMode::Map => {
                let distance = if mode == CameraMode::Map { 450.0 } else { 2.0 };
                self.direction = unit(Vec3::new(0.0, 0.5, -1.8)).unwrap_or(Vec3::NEG_Z);
                self.viewer_offset = Vec3::new(0.0, -distance, 0.0);
            }
            CameraMode::Chase => {}
        }
    }

    /// Steps of a held key in `dt` seconds, for the controls below.
    pub fn key_steps(dt: f32) -> f32 {
        dt * ADJUSTMENT_SPEED
    }

    /// Brings the eye closer by `steps`; refused when the boom would get shorter than 0.5 m (`rendering.md` 4.5).
    /// Returns whether it was done; a refusal is the moment to enter first person if that is wanted.
    pub fn zoom_in(&mut self, steps: f32) -> bool {
        let closer = self.viewer_offset * (1.0 - 0.2 * steps);
        if !closer.is_finite() || closer.length() < SHORTEST_BOOM || closer.dot(self.viewer_offset) <= 0.0 {
            return false;
        }
        self.viewer_offset = closer;
        true
    }

    /// Takes the eye farther away by `steps`; refused beyond 10 m to the side or back and 450 m up.
    pub fn zoom_out(&mut self, steps: f32) -> bool {
        let farther = self.viewer_offset * (1.0 + 0.2 * steps);
        if !(farther.x.abs() <= 10.0 && farther.y.abs() <= 10.0 && farther.z <= 450.0) {
            return false;
        }
        self.viewer_offset = farther;
        true
    }

    /// Turns the boom around the pivot's up axis by `steps` of 8 degrees, counter-clockwise seen from above.
    pub fn turn(&mut self, steps: f32) {
        let angle = (8.0 * steps).to_radians();
        let (s, c) = (libm::sinf(angle), libm::cosf(angle));
        let o = self.viewer_offset;
        let turned = Vec3::new(o.x * c - o.y * s, o.x * s + o.y * c, o.z);
        if turned.is_finite() {
            self.viewer_offset = turned;
        }
    }

    /// Raises the eye along its arc by `steps` of 8 degrees, lowers it with negative steps; refused when it would go
    /// over the top. In first person looks up or down instead (`rendering.md` 4.6).
    pub fn raise(&mut self, steps: f32) -> bool {
        if self.mode == CameraMode::FirstPerson {
            let z = self.direction.z + 0.2 * steps;
            if !z.is_finite() {
                return false;
            }
            self.direction.z = z.clamp(-0.8, 0.8);
            return true;
        }
        let o = self.viewer_offset;
        let level = libm::sqrtf(o.x * o.x + o.y * o.y);
        if level < EPSILON {
            return false;
        }
        let angle = (8.0 * steps).to_radians();
        let (s, c) = (libm::sinf(angle), libm::cosf(angle));
        let new_level = level * c - o.z * s;
        if !(new_level > 0.0 && new_level.is_finite()) {
            return false;
        }
        let k = new_level / level;
        self.viewer_offset = Vec3::new(o.x * k, o.y * k, level * s + o.z * c);
        true
    }

    /// Where the camera would be without damping (`rendering.md` 4.2). In the landblock of the target's position.
    pub fn desired(&self, target: &ViewerTarget) -> Position {
        let pivot = target.pivot(self.pivot_offset);
        let forward = pivot.local_to_global_vec(Vec3::Y);
        let mut heading = Vec3::ZERO;
        if let Some(point) = self.target_object {
            heading += unit(point - pivot.origin).unwrap_or(Vec3::ZERO);
        }
        if self.align_with_plane {
            heading += self.aligned_forward(target, forward);
        }
        if self.look_in_direction {
            heading += unit(pivot.local_to_global_vec(self.direction)).unwrap_or(Vec3::ZERO);
        }
        let heading = unit(heading).or(unit(forward)).unwrap_or(Vec3::Y);
        let frame = Frame::new(pivot.origin, facing(heading, forward));
        let eye = frame.local_to_global(self.viewer_offset);
        let gaze = if self.look_at_pivot {
            unit(pivot.origin - eye).unwrap_or(heading)
        } else {
            heading
        };
        Position {
            cell: target.position.cell,
            frame: Frame::new(eye, facing(gaze, heading)),
        }
    }

    /// The character's forward, along the slope it walks on (`rendering.md` 4.3).
    fn aligned_forward(&self, target: &ViewerTarget, forward: Vec3) -> Vec3 {
        let count = self.velocity_count.min(self.velocities.len());
        if count == 0 {
            return forward;
        }
        let sum: Vec3 = self.velocities[..count].iter().copied().sum();
        let Some(along) = unit(sum / count as f32) else {
            return forward;
        };
        if along.x.abs() < EPSILON || along.y.abs() < EPSILON {
            return forward;
        }
        let normal = match target.contact_normal.and_then(unit) {
            Some(normal) => normal,
            None => {
                let flat = unit(Vec3::new(along.x, along.y, along.z * 0.1)).unwrap_or(along);
                facing(flat, forward) * Vec3::Z
            }
        };
        unit(forward - normal * normal.dot(forward)).unwrap_or(forward)
    }

    /// The sought position after `dt` seconds: from where the viewer is now, part of the way to where it is wanted
    /// (`rendering.md` 4.4). Call it once a frame, after the player's physics.
    pub fn seek(&mut self, target: &ViewerTarget, viewer: Option<&Position>, dt: f32) -> Position {
        if target.velocity.is_finite() {
            let slot = self.velocity_count % self.velocities.len();
            self.velocities[slot] = target.velocity;
            self.velocity_count += 1;
            if self.velocity_count >= 2 * self.velocities.len() {
                self.velocity_count -= self.velocities.len();
            }
        }
        let desired = self.desired(target);
        let Some(viewer) = viewer.filter(|v| v.is_finite()) else {
            return desired;
        };
        // The viewer in the target's landblock.
        let from = desired.frame.origin + desired.offset_to(viewer);
        if (from - desired.frame.origin).length() > TELEPORT_DISTANCE && self.mode != CameraMode::Map {
            return desired;
        }
        // Under the feet the camera is rigid (4.5).
        let under = self.viewer_offset.z <= -1.8;
        let share = |stiffness: f32| {
            if stiffness > RIGID || under {
                1.0
            } else {
                (stiffness * dt * 10.0).clamp(0.0, 1.0)
            }
        };
        let (ft, fr) = (
            share(self.translational_stiffness),
            share(self.rotational_stiffness),
        );
        let origin = from + (desired.frame.origin - from) * ft;
        let now = viewer.frame.rotation();
        let rotation = interpolate_rotation(now, desired.frame.rotation(), fr);
        let rigid = ft >= 1.0 && fr >= 1.0;
        let turned = |a: f32, b: f32| (a - b).abs() >= SNAP_ROTATION;
        let same_rotation = !(turned(now.x, rotation.x)
            || turned(now.y, rotation.y)
            || turned(now.z, rotation.z)
            || turned(now.w, rotation.w));
        if !rigid && (origin - from).length() < SNAP_DISTANCE && same_rotation {
            return *viewer;
        }
        Position {
            cell: target.position.cell,
            frame: Frame::new(origin, rotation),
        }
    }

    /// How opaque the player's body is drawn for a viewer at this distance from the pivot, 0…1 (`rendering.md` 4.8).
    pub fn body_opacity(&self, distance: f32) -> f32 {
        if self.mode == CameraMode::FirstPerson {
            0.0
        } else {
            ((distance - 0.2) / (0.45 - 0.2)).clamp(0.0, 1.0)
        }
    }
}

/// A camera and the viewer it moves: the two steps of a frame in one (`rendering.md` 1.1).
#[derive(Clone, Debug, Default)]
pub struct CameraRig {
    /// The controls.
    pub camera: ChaseCamera,
    /// A scripted camera: the viewer stays where it was put (`rendering.md` 3.3).
    pub is_static: bool,
    viewer: Option<Viewer>,
}

impl CameraRig {
    /// A rig whose viewer starts at its desired place.
    pub fn new(camera: ChaseCamera) -> Self {
        CameraRig {
            camera,
            is_static: false,
            viewer: None,
        }
    }

    /// Where the eye is; `None` before the first update.
    pub fn viewer(&self) -> Option<&Viewer> {
        self.viewer.as_ref()
    }

    /// Puts the viewer somewhere: scripted cameras, and tests.
    pub fn set_viewer(&mut self, viewer: Viewer) {
        self.viewer = Some(viewer);
    }

    /// One frame: seeks, then sweeps. Without a target the viewer stays (`rendering.md` 3.2, 3.3).
    pub fn update(
        &mut self,
        world: &World,
        population: &Population,
        scratch: &mut Scratch,
        target: Option<&ViewerTarget>,
        dt: f32,
    ) -> Option<&Viewer> {
        if let Some(target) = target.filter(|_| !self.is_static) {
            // A viewer that fell back to the player's feet has nothing to glide from.
            let from = self
                .viewer
                .filter(|v| v.source != ViewerSource::Player)
                .map(|v| v.position);
            let sought = self.camera.seek(target, from.as_ref(), dt);
            let pivot = self.camera.pivot_offset;
            let mut next = update_viewer(world, population, scratch, target, pivot, &sought);
            // A sweep that ends where the eye already is, but for its rounding, must not let the eye creep (3.7b).
            if let Some(last) = self.viewer
                && (last.cell, last.source) == (next.cell, next.source)
                && is_at_rest(&last.position, &next.position)
            {
                next.position = last.position;
            }
            self.viewer = Some(next);
        }
        self.viewer.as_ref()
    }
}

/// Mouse look, smoothed over two events (`rendering.md` 4.7).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MouseSmoothing {
    /// How much of the average goes into the result, 0…1.
    pub weight: f32,
    last: Vec2,
    last_time: Option<f64>,
}

impl MouseSmoothing {
    /// Smoothing with this weight, 0…1.
    pub fn new(weight: f32) -> Self {
        MouseSmoothing {
            weight,
            ..Self::default()
        }
    }

    /// The smoothed movement for a raw one at a time in seconds.
    pub fn filter(&mut self, raw: Vec2, time: f64) -> Vec2 {
        let recent = self.last_time.is_some_and(|t| time - t < 0.25);
        let average = if recent { (self.last + raw) * 0.5 } else { raw };
        self.last = raw;
        self.last_time = Some(time);
        raw * (1.0 - self.weight) + average * self.weight
    }
}

/// Whether two poses are the same within the snap band (`rendering.md` 4.4).
fn is_at_rest(a: &Position, b: &Position) -> bool {
    let (p, q) = (a.frame.rotation().to_array(), b.frame.rotation().to_array());
    a.offset_to(b).length() < SNAP_DISTANCE && p.iter().zip(&q).all(|(p, q)| (p - q).abs() < SNAP_ROTATION)
}

/// The rotation that looks along `forward` without roll; straight up or down keeps the right hand of `fallback`.
fn facing(forward: Vec3, fallback: Vec3) -> Quat {
    let level = |v: Vec3| unit(v.cross(Vec3::Z)).filter(|_| v.x * v.x + v.y * v.y > 1.0e-10);
    let right = level(forward).or_else(|| level(fallback)).unwrap_or(Vec3::X);
    let up = right.cross(forward);
    normalise(Quat::from_mat3(&glam::Mat3::from_cols(right, forward, up)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vestibule_world::CellId;

    fn target() -> ViewerTarget {
        ViewerTarget::at(Position::new(CellId(0xA9B4_0001), Vec3::new(10.0, 10.0, 5.0)))
    }

    #[test]
    fn r4_1_the_default_boom() {
        let camera = ChaseCamera::default();
        let desired = camera.desired(&target());
        let eye = desired.frame.origin;
        assert!((eye - Vec3::new(10.0, 7.5, 7.25)).length() < 1e-5, "{eye}");
        assert!((camera.viewer_offset.length() - 2.61).abs() < 0.001);
        // Looks at the pivot, 0.291 rad down.
        let forward = desired.frame.axes()[1];
        assert!((libm::asinf(-forward.z) - 0.291).abs() < 1e-3);
        assert!(desired.frame.axes()[0].z.abs() < 1e-6, "no roll");
        assert_eq!(ChaseCamera::new(2.0).viewer_offset, Vec3::new(0.0, -5.0, 1.5));
    }

    #[test]
    fn r22_damping_shrinks_by_0_925_and_ends_exactly() {
        let mut camera = ChaseCamera::default();
        let target = target();
        let desired = camera.desired(&target);
        let mut viewer = desired;
        viewer.frame.origin += Vec3::new(0.0, 1.0, 0.0);
        let mut distance = 1.0;
        for _ in 0..20 {
            viewer = camera.seek(&target, Some(&viewer), 1.0 / 60.0);
            let next = (viewer.frame.origin - desired.frame.origin).length();
            assert!((next / distance - 0.925).abs() < 1e-3, "{next} {distance}");
            distance = next;
        }
        for _ in 0..200 {
            viewer = camera.seek(&target, Some(&viewer), 1.0 / 60.0);
        }
        let rest = camera.seek(&target, Some(&viewer), 1.0 / 60.0);
        assert_eq!(rest, viewer, "snaps to the viewer exactly");
        assert!((viewer.frame.origin - desired.frame.origin).length() < 0.0004 / 0.075 + 1e-4);
        camera.translational_stiffness = 1.0;
        camera.rotational_stiffness = 1.0;
        viewer.frame.origin += Vec3::new(0.0, 1.0, 0.0);
        assert_eq!(
            camera.seek(&target, Some(&viewer), 1.0 / 60.0),
            desired,
            "stiffness 1: one step"
        );
    }

    #[test]
    fn r4_5_zoom_is_multiplicative_and_bounded() {
        let mut camera = ChaseCamera::default();
        assert!(camera.zoom_in(1.0));
        assert!((camera.viewer_offset.length() - 2.61 * 0.8).abs() < 0.01);
        while camera.zoom_in(1.0) {}
        assert!(camera.viewer_offset.length() >= 0.5 && camera.viewer_offset.length() < 0.5 / 0.8 + 1e-4);
        while camera.zoom_out(1.0) {}
        assert!(camera.viewer_offset.y >= -10.0 && camera.viewer_offset.y < -8.0);
        assert!(!camera.zoom_out(f32::NAN) && !camera.zoom_in(f32::INFINITY) && !camera.zoom_in(7.0));
    }

    #[test]
    fn r4_6_turning_and_raising_the_boom() {
        let mut camera = ChaseCamera::default();
        let length = camera.viewer_offset.length();
        camera.turn(90.0 / 8.0);
        assert!((camera.viewer_offset - Vec3::new(2.5, 0.0, 0.75)).length() < 1e-4);
        assert!(camera.raise(2.0));
        assert!((camera.viewer_offset.length() - length).abs() < 1e-4 && camera.viewer_offset.z > 0.75);
        for _ in 0..20 {
            camera.raise(1.0);
        }
        assert!(camera.viewer_offset.x > 0.0, "refused at the top");
        camera.set_mode(CameraMode::FirstPerson);
        for _ in 0..9 {
            camera.raise(1.0);
        }
        assert_eq!(camera.direction.z, 0.8);
    }

    #[test]
    fn r4_1_modes_and_back() {
        let mut camera = ChaseCamera::default();
        let before = camera.clone();
        camera.set_mode(CameraMode::Map);
        let eye = camera.desired(&target()).frame.origin;
        assert!((eye - Vec3::new(10.0, 10.0, 6.5)).length() > 449.0 && eye.z > 400.0);
        camera.set_mode(CameraMode::Chase);
        assert_eq!(camera, before);
        camera.set_mode(CameraMode::FirstPerson);
        let desired = camera.desired(&target());
        assert!((desired.frame.origin - Vec3::new(10.0, 10.18, 6.5)).length() < 1e-5);
        assert!((desired.frame.axes()[1] - Vec3::Y).length() < 1e-5);
        assert_eq!(camera.body_opacity(5.0), 0.0);
        camera.set_mode(CameraMode::Chase);
        assert_eq!(camera.viewer_offset, Vec3::new(0.0, -0.6, 0.5));
        assert_eq!((camera.body_opacity(0.1), camera.body_opacity(0.5)), (0.0, 1.0));
        assert!((camera.body_opacity(0.325) - 0.5).abs() < 1e-5);
    }

    #[test]
    fn r4_3_the_heading_follows_the_slope_while_walking() {
        let mut camera = ChaseCamera::default();
        let mut target = target();
        target
            .position
            .frame
            .set_rotation(vestibule_physics::heading_to_rotation(45.0));
        target.velocity = Vec3::new(2.0, 2.0, 2.0);
        target.contact_normal = Vec3::new(-0.5, -0.5, 1.0).try_normalize();
        camera.seek(&target, None, 0.03);
        let uphill = camera.desired(&target);
        target.velocity = Vec3::ZERO;
        let mut standing = ChaseCamera::default();
        standing.seek(&target, None, 0.03);
        let level = standing.desired(&target);
        assert!(
            uphill.frame.origin.z < level.frame.origin.z - 0.5,
            "{} {}",
            uphill.frame.origin,
            level.frame.origin
        );
    }

    #[test]
    fn r4_9_a_teleport_is_followed_at_once() {
        let mut camera = ChaseCamera::default();
        let target = target();
        let far = Position::new(CellId(0xA9B4_0001), Vec3::new(150.0, 10.0, 5.0));
        assert_eq!(camera.seek(&target, Some(&far), 0.01), camera.desired(&target));
        let next_block = Position::new(CellId(0xA8B4_0039), Vec3::new(191.0, 10.0, 5.0));
        let sought = camera.seek(&target, Some(&next_block), 0.01);
        assert!(sought.frame.origin.x < 0.0, "across a border it glides");
    }

    #[test]
    fn r4_7_mouse_smoothing_averages_recent_events() {
        let mut mouse = MouseSmoothing::new(1.0);
        assert_eq!(mouse.filter(Vec2::new(4.0, 0.0), 1.0), Vec2::new(4.0, 0.0));
        assert_eq!(mouse.filter(Vec2::new(8.0, 0.0), 1.1), Vec2::new(6.0, 0.0));
        assert_eq!(mouse.filter(Vec2::new(2.0, 0.0), 2.0), Vec2::new(2.0, 0.0));
    }
}
