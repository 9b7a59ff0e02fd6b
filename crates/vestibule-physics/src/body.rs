//! A body: what moves, with everything it carries between moves (`transition.md` 3.2, 9.3, 9.4).

use std::sync::Arc;

use glam::{Quat, Vec3};
use vestibule_world::{CellId, Frame, Position, Shape, Sphere, normalise};

use crate::constants::{
    DEFAULT_ELASTICITY, DEFAULT_FRICTION, EPSILON, GRAVITY, MAX_ELASTICITY, MAX_VELOCITY,
    SMALL_VELOCITY_SQUARED, STEP_HEIGHT_WITHOUT_SETUP,
};
use crate::error::SweepError;
use crate::flags::{ObjectKind, ObjectState, PhysicsState, TransientState};
use crate::locomotion::{Locomotion, Motion};
use crate::math::{grotate, length};
use crate::obj_collisions::ObjectRef;
use crate::population::BodyId;
use crate::sweep::{Carried, ContactPlane, Mover, Swept};

/// A body. Its place changes through [`crate::Population`], which keeps the lists of what is in which cell; what
/// it is and how it moves may be set here at any time.
#[derive(Clone, Debug)]
pub struct Body {
    shape: Arc<Shape>,
    scale: f32,
    mover: Mover,
    pub(crate) position: Position,
    pub(crate) cell: Option<CellId>,
    pub(crate) part_frames: Vec<Frame>,
    /// Cells whose shadow lists name the body, in order.
    pub(crate) shadow_cells: Vec<CellId>,
    pub(crate) touching: Vec<ObjectRef>,
    pub(crate) colliding_with_environment: bool,
    pub(crate) parent: Option<BodyId>,
    pub(crate) children: Vec<BodyId>,
    /// Frame in the parent's.
    pub(crate) attached: Frame,
    /// Physics state.
    pub state: PhysicsState,
    /// What the last move left.
    pub transient: TransientState,
    /// What the game says of it.
    pub kind: ObjectKind,
    /// Velocity, m/s, global axes. To set it as the game does use [`Body::set_velocity`].
    pub velocity: Vec3,
    /// Acceleration, m/s².
    pub acceleration: Vec3,
    /// Angular velocity, radians per second about global axes.
    pub omega: Vec3,
    /// Share of speed lost in a second on the ground.
    pub friction: f32,
    /// How much a bounce gives back, 0 to 0.1.
    elasticity: f32,
    /// The contact plane of the last move.
    pub contact: Option<ContactPlane>,
    /// Normal that the next move slides along, when [`TransientState::SLIDING`] is set.
    pub sliding_normal: Vec3,
    /// Velocity over the last quantum as it came out of the sweep, m/s.
    pub cached_velocity: Vec3,
    /// Velocity has been set since the last quantum.
    pub jumped_this_frame: bool,
    /// How far its time has come, seconds on the caller's clock.
    pub update_time: f64,
    /// What a missile is meant for.
    pub target: Option<BodyId>,
    /// How it moves by itself; `None` for things.
    pub locomotion: Option<Locomotion>,
}

impl Body {
    /// A body of this shape, nowhere yet. `scale` multiplies spheres, cylinders, parts and step heights.
    ///
    /// # Errors
    /// A scale that is not a positive number, or a shape whose spheres are not finite.
    pub fn new(shape: Arc<Shape>, scale: f32) -> Result<Self, SweepError> {
        if !scale.is_finite() {
            return Err(SweepError::NotFinite { what: "scale" });
        }
        if scale <= 0.0 {
            return Err(SweepError::BadScale { scale });
        }
        let mut spheres = [Sphere::default(); 2];
        let count = shape.spheres.len().min(2);
        for (scaled, sphere) in spheres.iter_mut().zip(&shape.spheres) {
            *scaled = Sphere::new(sphere.center * scale, sphere.radius * scale);
        }
        // A GfxObj used as a shape has no setup data.
        let step = |height: f32| {
            if shape.id >> 24 == 1 {
                STEP_HEIGHT_WITHOUT_SETUP
            } else {
                height * scale
            }
        };
        let mover = Mover::new(&spheres[..count])?
            .with_steps(step(shape.step_up_height), step(shape.step_down_height));
        Ok(Body::build(shape, scale, mover))
    }

    fn build(shape: Arc<Shape>, scale: f32, mover: Mover) -> Self {
        let mut state = PhysicsState::DEFAULT;
        state.set(PhysicsState::HAS_PHYSICS_BSP, shape.has_physics_bsp);
        let parts = shape.parts.len();
        Body {
            shape,
            scale,
            mover,
            position: Position::default(),
            cell: None,
            part_frames: vec![Frame::IDENTITY; parts],
            shadow_cells: Vec::new(),
            touching: Vec::new(),
            colliding_with_environment: false,
            parent: None,
            children: Vec::new(),
            attached: Frame::IDENTITY,
            state,
            transient: TransientState::ACTIVE,
            kind: ObjectKind::HAS_GAME_OBJECT,
            velocity: Vec3::ZERO,
            acceleration: Vec3::ZERO,
            omega: Vec3::ZERO,
            friction: DEFAULT_FRICTION,
            elasticity: DEFAULT_ELASTICITY,
            contact: None,
            sliding_normal: Vec3::ZERO,
            cached_velocity: Vec3::ZERO,
            jumped_this_frame: false,
            update_time: 0.0,
            target: None,
            locomotion: None,
        }
    }

    /// A player character of the usual size, by the figures of `transition.md` 9.5, without a Setup record.
    pub fn player() -> Self {
        let shape = sphere_shape(&crate::locomotion::PLAYER_SPHERES);
        let mut body = Body::build(Arc::new(shape), 1.0, Mover::player());
        body.kind = ObjectKind::HAS_GAME_OBJECT | ObjectKind::CREATURE | ObjectKind::PLAYER;
        body.locomotion = Some(Locomotion::default());
        body
    }

    /// A creature made of one or two spheres, relative to its feet, that steps like a player.
    ///
    /// # Errors
    /// A number is not finite, or a radius is negative.
    pub fn creature(spheres: &[Sphere], locomotion: Locomotion) -> Result<Self, SweepError> {
        let mut body = Body::new(Arc::new(sphere_shape(spheres)), 1.0)?;
        body.kind = ObjectKind::HAS_GAME_OBJECT | ObjectKind::CREATURE;
        body.locomotion = Some(locomotion);
        Ok(body)
    }

    /// What it is made of.
    pub fn shape(&self) -> &Arc<Shape> {
        &self.shape
    }

    /// Its scale.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Where it is. The origin is its feet, relative to the landblock of the cell id.
    pub fn position(&self) -> &Position {
        &self.position
    }

    /// The cell it is in: the one its last accepted sweep carried it into. `None` when it is in no resident cell
    /// ("lost cell") or has not entered the world.
    pub fn cell(&self) -> Option<CellId> {
        self.cell
    }

    /// The cells whose lists of objects name it.
    pub fn shadow_cells(&self) -> &[CellId] {
        &self.shadow_cells
    }

    /// What it overlaps or is pressed against since its last move.
    pub fn touching(&self) -> &[ObjectRef] {
        &self.touching
    }

    /// The body it is attached to.
    pub fn parent(&self) -> Option<BodyId> {
        self.parent
    }

    /// Frames of its parts in its landblock.
    pub fn part_frames(&self) -> &[Frame] {
        &self.part_frames
    }

    /// How much a bounce gives back.
    pub fn elasticity(&self) -> f32 {
        self.elasticity
    }

    /// Sets how much a bounce gives back, clamped to 0…0.1 (`transition.md` 1.2).
    pub fn set_elasticity(&mut self, elasticity: f32) {
        self.elasticity = elasticity.clamp(0.0, MAX_ELASTICITY);
    }

    /// Whether it stands on ground that can be walked on.
    pub fn is_on_walkable(&self) -> bool {
        self.transient.has(TransientState::ON_WALKABLE)
    }

    /// Whether it has collision spheres of its own.
    pub fn has_spheres(&self) -> bool {
        !self.shape.spheres.is_empty()
    }

    /// Sets the velocity as the game does: clamped to 50 m/s, and the body wakes up (`transition.md` 9.4). `now`
    /// is the time on the caller's clock, seconds.
    pub fn set_velocity(&mut self, v: Vec3, now: f64) {
        if v != self.velocity && v.is_finite() {
            self.velocity = v;
            self.clamp_velocity();
            self.jumped_this_frame = true;
        }
        if !self.state.has(PhysicsState::STATIC) {
            if !self.transient.has(TransientState::ACTIVE) {
                self.update_time = now;
            }
            self.transient.set(TransientState::ACTIVE, true);
        }
    }

    fn clamp_velocity(&mut self) {
        let speed = length(self.velocity);
        if speed > MAX_VELOCITY {
            self.velocity = self.velocity / speed * MAX_VELOCITY;
        }
    }

    /// The body as a mover of its next sweep (`transition.md` 2.4, 3.2.3). `id` is its own, so that it does not
    /// run into itself.
    pub fn mover(&self, id: Option<BodyId>) -> Mover {
        let mut mover = self.mover;
        mover.state = ObjectState::NONE;
        mover
            .state
            .set(ObjectState::EDGE_SLIDE, self.state.has(PhysicsState::EDGE_SLIDE));
        mover
            .state
            .set(ObjectState::FREE_ROTATE, self.shape.allow_free_heading);
        mover
            .state
            .set(ObjectState::PATH_CLIPPED, self.state.has(PhysicsState::MISSILE));
        mover.physics = self.state;
        mover.kind = self.kind;
        mover.body = id;
        mover.target = self.target;
        mover
    }

    /// What the body carries into its next sweep (`transition.md` 3.1.4, 3.2.2).
    pub fn carried(&self) -> Carried {
        let touching = self.transient.has(TransientState::CONTACT);
        let leaves = self
            .contact
            .is_some_and(|c| self.velocity.dot(c.plane.normal) > EPSILON);
        let plane = if touching { self.contact } else { None };
        let sliding = touching_slide(self);
        Carried {
            contact: if leaves { None } else { plane },
            on_walkable: self.is_on_walkable(),
            last_known: if leaves { plane } else { None },
            sliding_normal: sliding,
            stationary: if self.transient.has(TransientState::STATIONARY_STUCK) {
                3
            } else if self.transient.has(TransientState::STATIONARY_STOP) {
                2
            } else {
                u8::from(self.transient.has(TransientState::STATIONARY_FALL))
            },
        }
    }

    /// Puts the body's frame, and those of its parts.
    pub(crate) fn set_frame(&mut self, frame: Frame) {
        self.position.frame = frame;
        for (placed, part) in self.part_frames.iter_mut().zip(&self.shape.parts) {
            let scaled = Frame::new(part.frame.origin * self.scale, part.frame.rotation());
            *placed = frame.combine(&scaled);
        }
    }

    /// Gravity acts on what does not stand (retail `calc_acceleration`, `transition.md` 9.4).
    pub(crate) fn calc_acceleration(&mut self) {
        let stands = self
            .transient
            .has(TransientState::CONTACT | TransientState::ON_WALKABLE)
            && !self.state.has(PhysicsState::SLEDDING);
        if stands {
            self.acceleration = Vec3::ZERO;
            self.omega = Vec3::ZERO;
        } else if self.state.has(PhysicsState::GRAVITY) {
            self.acceleration = Vec3::new(0.0, 0.0, GRAVITY);
        } else {
            self.acceleration = Vec3::ZERO;
        }
    }

    /// Stops the body: its numbers have become unusable.
    pub(crate) fn halt(&mut self) {
        self.velocity = Vec3::ZERO;
        self.omega = Vec3::ZERO;
        self.calc_acceleration();
    }

    /// Sets or clears [`TransientState::ON_WALKABLE`]; a walker that leaves the ground takes its motion along
    /// (`transition.md` 9.1.8, 9.5.2). Returns whether it changed.
    pub(crate) fn set_on_walkable(&mut self, on: bool, now: f64) -> bool {
        let was = self.is_on_walkable();
        self.transient.set(TransientState::ON_WALKABLE, on);
        if was && !on {
            self.leave_ground(now);
        }
        self.calc_acceleration();
        was != on
    }

    fn leave_ground(&mut self, now: f64) {
        let Some(locomotion) = &mut self.locomotion else {
            return;
        };
        let mut v = locomotion.leave_ground_velocity();
        locomotion.jump_extent = 0.0;
        if length(v) < EPSILON {
            return;
        }
        v = self.position.frame.local_to_global_vec(v);
        self.set_velocity(v, now);
    }

    /// Tells the body how to walk, run and turn; it does so in [`crate::Population::update`]. No effect without
    /// [`Locomotion`].
    pub fn set_motion(&mut self, motion: Motion) {
        if let Some(locomotion) = &mut self.locomotion {
            locomotion.motion = motion;
        }
    }

    /// Whether the body can jump now.
    pub fn can_jump(&self) -> bool {
        self.locomotion.is_some() && self.is_on_walkable() && self.cell.is_some()
    }

    /// Jumps with `extent` 0…1 of its strength, keeping its motion (`transition.md` 9.5.2). `false` when it
    /// cannot: in the air, or without [`Locomotion`].
    pub fn jump(&mut self, extent: f32, now: f64) -> bool {
        if !self.can_jump() || !extent.is_finite() {
            return false;
        }
        if let Some(locomotion) = &mut self.locomotion {
            locomotion.jump_extent = extent;
        }
        self.set_on_walkable(false, now);
        true
    }

    /// The frame after `q` seconds by root motion and physics (`transition.md` 9.4). `motion` is the body-local
    /// displacement and turn of its animation over the quantum.
    pub(crate) fn update_position(&mut self, q: f32, motion: &Frame) -> Frame {
        let hidden = self.state.has(PhysicsState::HIDDEN);
        let mut inner = if hidden { Frame::IDENTITY } else { *motion };
        if !hidden {
            inner.origin *= if self.is_on_walkable() { self.scale } else { 0.0 };
        }
        let mut frame = self.position.frame.combine(&inner);
        if !hidden {
            self.update_physics(q, &mut frame);
        }
        frame
    }

    /// One step of the integrator (retail `UpdatePhysicsInternal`).
    fn update_physics(&mut self, q: f32, frame: &mut Frame) {
        let mut s = self.velocity.dot(self.velocity);
        if s <= 0.0 {
            if self.locomotion.is_none() && self.is_on_walkable() {
                self.transient.set(TransientState::ACTIVE, false);
            }
        } else {
            if s > MAX_VELOCITY * MAX_VELOCITY {
                self.clamp_velocity();
                s = MAX_VELOCITY * MAX_VELOCITY;
            }
            self.calc_friction(q, s);
            // The speed before friction decides.
            if s - SMALL_VELOCITY_SQUARED < EPSILON {
                self.velocity = Vec3::ZERO;
            }
            frame.origin += self.acceleration * (0.5 * q * q) + self.velocity * q;
        }
        self.velocity += self.acceleration * q;
        let turn = self.omega * q;
        if turn != Vec3::ZERO {
            frame.set_rotation(grotate(frame.rotation(), turn));
        }
    }

    /// Friction on walkable ground (`transition.md` 9.4). `s` is the square of the speed.
    fn calc_friction(&mut self, q: f32, s: f32) {
        if !self.is_on_walkable() {
            return;
        }
        let Some(contact) = self.contact else { return };
        let n = contact.plane.normal;
        let k = self.velocity.dot(n);
        if k >= 0.25 {
            return;
        }
        self.velocity -= n * k;
        let friction = if self.state.has(PhysicsState::SLEDDING) {
            sled_friction(s, n.z, self.friction)
        } else {
            self.friction
        };
        self.velocity *= libm::powf(1.0 - friction, q);
    }

    /// Takes over what a sweep says of contact and sliding; the first half of the write-back (`transition.md`
    /// 9.1, 5 to 9). Returns what the ground did.
    pub(crate) fn take_contact(&mut self, swept: &Swept, now: f64) -> GroundChange {
        let was = self.is_on_walkable();
        self.contact = swept.contact;
        self.transient
            .set(TransientState::CONTACT, swept.contact.is_some());
        self.calc_acceleration();
        let water = swept.contact.is_some_and(|c| c.is_water);
        self.transient.set(TransientState::WATER_CONTACT, water);
        self.set_on_walkable(swept.contact.is_some() && swept.on_walkable, now);
        self.sliding_normal = swept.sliding_normal.unwrap_or(Vec3::ZERO);
        self.transient
            .set(TransientState::SLIDING, swept.sliding_normal.is_some());
        match (was, self.is_on_walkable()) {
            (false, true) => GroundChange::Hit,
            (true, false) => GroundChange::Left,
            _ => GroundChange::None,
        }
    }

    /// The bounce and the stationary bits of `handle_all_collisions` (`transition.md` 9.2, 4 and 5).
    pub(crate) fn bounce(&mut self, swept: &Swept, prev_on_walkable: bool) {
        let bounce = !(prev_on_walkable && self.is_on_walkable() && !self.state.has(PhysicsState::SLEDDING));
        if swept.stationary > 1 {
            self.velocity = Vec3::ZERO;
        } else if let (true, Some(n)) = (bounce, swept.collision_normal) {
            if self.state.has(PhysicsState::INELASTIC) {
                self.velocity = Vec3::ZERO;
            } else {
                let k = self.velocity.dot(n);
                if k < 0.0 {
                    self.velocity -= n * k * (1.0 + self.elasticity);
                }
            }
        }
        let all = TransientState::STATIONARY_FALL
            | TransientState::STATIONARY_STOP
            | TransientState::STATIONARY_STUCK;
        match swept.stationary {
            1 => self.transient.set(TransientState::STATIONARY_FALL, true),
            2 => self.transient.set(TransientState::STATIONARY_STOP, true),
            _ => self.transient.set(all, false),
        }
    }

    /// A missile that hits stops being one (`transition.md` 9.2).
    pub(crate) fn strip_missile(&mut self) {
        if self.state.has(PhysicsState::MISSILE) {
            let bits = PhysicsState::MISSILE | PhysicsState::ALIGNPATH | PhysicsState::PATHCLIPPED;
            self.state.set(bits, false);
        }
    }
}

/// What a write-back did to a body's standing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GroundChange {
    None,
    Hit,
    Left,
}

fn touching_slide(body: &Body) -> Option<Vec3> {
    body.transient
        .has(TransientState::SLIDING)
        .then_some(body.sliding_normal)
}

/// Friction of a sled from the square of its speed and the slope (`transition.md` 9.4).
fn sled_friction(s: f32, slope_z: f32, friction: f32) -> f32 {
    const COS_10_DEGREES: f32 = 0.984_807_7;
    if s < 1.5625 {
        1.0
    } else if s < 6.25 || slope_z >= COS_10_DEGREES {
        friction
    } else {
        0.2
    }
}

/// A shape of collision spheres only.
pub(crate) fn sphere_shape(spheres: &[Sphere]) -> Shape {
    let foot = spheres.first().copied().unwrap_or_default();
    let top = spheres
        .iter()
        .map(|s| s.center.z + s.radius)
        .fold(0.0, |a, b| if b > a { b } else { a });
    Shape {
        id: 0,
        parts: Box::default(),
        cylspheres: Box::default(),
        spheres: spheres.into(),
        has_physics_bsp: false,
        allow_free_heading: true,
        height: top,
        radius: foot.radius,
        step_up_height: crate::locomotion::PLAYER_STEP_UP,
        step_down_height: crate::locomotion::PLAYER_STEP_DOWN,
        sorting_sphere: foot,
        selection_sphere: foot,
    }
}

/// A frame that moves by `origin` and turns by `radians` to the left about z: the root motion of a quantum.
pub fn root_motion(origin: Vec3, radians: f32) -> Frame {
    if radians == 0.0 {
        return Frame::at(origin);
    }
    let half = radians * 0.5;
    let turn = normalise(Quat::from_xyzw(0.0, 0.0, libm::sinf(half), libm::cosf(half)));
    Frame::new(origin, turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vestibule_world::Plane;

    fn falling() -> Body {
        let mut body = Body::player();
        body.calc_acceleration();
        body
    }

    fn standing() -> Body {
        let mut body = Body::player();
        body.contact = Some(ContactPlane {
            plane: Plane {
                normal: Vec3::Z,
                d: 0.0,
            },
            cell: CellId(0xA9B4_0001),
            is_water: false,
        });
        body.transient
            .set(TransientState::CONTACT | TransientState::ON_WALKABLE, true);
        body.calc_acceleration();
        body
    }

    /// Displacement of one quantum.
    fn step(body: &mut Body, q: f32) -> Vec3 {
        let mut frame = Frame::IDENTITY;
        body.update_physics(q, &mut frame);
        frame.origin
    }

    #[test]
    fn w53_free_fall_from_rest_starts_a_quantum_late() {
        let mut body = falling();
        let q = 1.0 / 30.0;
        for expected in [0.0, -0.016_333_3, -0.027_222_2] {
            assert!((step(&mut body, q).z - expected).abs() < 1e-5);
        }
        assert!((body.velocity.z + 0.98).abs() < 1e-5);
    }

    #[test]
    fn w54_a_small_velocity_is_dropped_but_gravity_acts() {
        let mut body = falling();
        body.velocity = Vec3::new(0.0, 0.0, -0.2);
        assert!((step(&mut body, 1.0 / 30.0).z + 0.005_444_4).abs() < 1e-6);
        assert!((body.velocity.z + 0.326_666_7).abs() < 1e-5);
    }

    #[test]
    fn w55_friction() {
        let mut body = standing();
        body.velocity = Vec3::new(3.0, 0.0, 0.0);
        step(&mut body, 1.0 / 30.0);
        assert!((body.velocity.x - 2.714_898_4).abs() < 1e-4);
        for _ in 1..25 {
            step(&mut body, 1.0 / 30.0);
        }
        assert!(body.velocity.x > 0.0 && body.velocity.x < 0.2504);
        step(&mut body, 1.0 / 30.0);
        assert_eq!(body.velocity, Vec3::ZERO);
        let mut body = standing();
        body.velocity = Vec3::new(3.0, 0.0, 0.0);
        step(&mut body, 0.2);
        assert!((body.velocity.x - 3.0 * 0.549_280_3).abs() < 1e-4);
    }

    #[test]
    fn s9_4_no_friction_while_leaving_the_ground_fast() {
        let mut body = standing();
        body.velocity = Vec3::new(3.0, 0.0, 0.25);
        step(&mut body, 1.0 / 30.0);
        assert_eq!(body.velocity, Vec3::new(3.0, 0.0, 0.25));
    }

    #[test]
    fn s9_4_sled_friction() {
        assert_eq!(sled_friction(1.5, 1.0, 0.95), 1.0);
        assert_eq!(sled_friction(1.5625, 0.5, 0.95), 0.95);
        assert_eq!(sled_friction(6.25, 0.99, 0.95), 0.95);
        assert_eq!(sled_friction(6.25, 0.98, 0.95), 0.2);
    }

    /// Apex and number of quanta until the start height is reached again.
    fn jump_from(forward: f32) -> (f32, u32) {
        let mut body = falling();
        body.velocity = Vec3::new(0.0, forward, 4.427_189);
        let (mut z, mut apex, mut quanta) = (0.0f32, 0.0f32, 0);
        while z > 0.0 || quanta == 0 {
            z += step(&mut body, 1.0 / 30.0).z;
            apex = apex.max(z);
            quanta += 1;
        }
        (apex, quanta)
    }

    #[test]
    fn w56_apex_of_a_jump_of_one_metre() {
        // Over the top of a running jump the body is never slow, so the arc is the plain one.
        let (apex, quanta) = jump_from(4.0);
        assert!((apex - 0.998_91).abs() < 1e-4, "{apex}");
        assert_eq!(quanta, 28);
    }

    #[test]
    fn w56_a_jump_on_the_spot_loses_its_last_speed_below_the_apex() {
        // 0.18 m/s after 13 quanta is small (9.4.2): the body turns round there.
        let (apex, quanta) = jump_from(0.0);
        assert!((apex - 0.998_34).abs() < 1e-4, "{apex}");
        assert_eq!(quanta, 27);
    }

    fn swept(n: Vec3, stationary: u8) -> Swept {
        Swept {
            ok: true,
            cell: None,
            position: Position::default(),
            contact: None,
            on_walkable: false,
            collision_normal: Some(n),
            sliding_normal: None,
            collided_with_environment: false,
            stationary,
            velocity_killed: false,
        }
    }

    #[test]
    fn w58_bounces() {
        let mut body = falling();
        body.velocity = Vec3::new(3.0, 0.0, -5.0);
        body.bounce(&swept(Vec3::Z, 0), false);
        assert!((body.velocity - Vec3::new(3.0, 0.0, 0.25)).length() < 1e-5);
        body.velocity = Vec3::new(4.0, 0.0, -1.0);
        body.bounce(&swept(-Vec3::X, 0), false);
        assert!((body.velocity - Vec3::new(-0.2, 0.0, -1.0)).length() < 1e-5);
        // Away from what was hit; inelastic; walking all along.
        body.velocity = Vec3::X;
        body.bounce(&swept(Vec3::X, 0), false);
        assert_eq!(body.velocity, Vec3::X);
        body.state.set(PhysicsState::INELASTIC, true);
        body.bounce(&swept(-Vec3::X, 0), false);
        assert_eq!(body.velocity, Vec3::ZERO);
        let mut walker = standing();
        walker.velocity = -Vec3::X;
        walker.bounce(&swept(Vec3::X, 0), true);
        assert_eq!(walker.velocity, -Vec3::X);
    }

    #[test]
    fn w59_stationary_bits_count_up_and_start_again() {
        let mut body = falling();
        body.velocity = Vec3::X;
        body.bounce(&swept(Vec3::Z, 1), false);
        assert_eq!((body.carried().stationary, body.velocity), (1, Vec3::X));
        body.bounce(&swept(Vec3::Z, 2), false);
        assert_eq!((body.carried().stationary, body.velocity), (2, Vec3::ZERO));
        body.bounce(&swept(Vec3::Z, 3), false);
        assert_eq!(body.carried().stationary, 0);
    }

    #[test]
    fn s3_2_a_body_that_moves_off_its_plane_only_remembers_it() {
        let mut body = standing();
        assert!(body.carried().contact.is_some());
        body.velocity = Vec3::new(0.0, 0.0, 1.0);
        let carried = body.carried();
        assert!(carried.contact.is_none() && carried.last_known.is_some());
        body.transient.set(TransientState::CONTACT, false);
        assert!(body.carried().last_known.is_none());
    }

    #[test]
    fn s9_4_the_speed_limit() {
        let mut body = falling();
        body.set_velocity(Vec3::new(0.0, 300.0, 400.0), 1.0);
        assert!((length(body.velocity) - 50.0).abs() < 1e-3 && body.jumped_this_frame);
        body.velocity = Vec3::new(0.0, 0.0, -80.0);
        let moved = step(&mut body, 0.1);
        assert!((moved.z + 5.0 + 0.049).abs() < 1e-3);
    }

    #[test]
    fn s9_4_root_motion_moves_on_the_ground_only() {
        let motion = Frame::at(Vec3::Y);
        assert_eq!(standing().update_position(0.1, &motion).origin, Vec3::Y);
        assert_eq!(falling().update_position(0.1, &motion).origin, Vec3::ZERO);
    }

    #[test]
    fn s1_2_elasticity_is_clamped() {
        let mut body = falling();
        body.set_elasticity(0.5);
        assert_eq!(body.elasticity(), 0.1);
    }

    #[test]
    fn what_is_drawn_of_a_body_without_a_model_lies_within_its_bounds() {
        let (body, frame) = (Body::player(), Frame::at(Vec3::new(3.0, 4.0, 5.0)));
        let bounds = vestibule_world::bounding_sphere(body.shape(), &frame, &[], 2.0);
        for s in crate::locomotion::PLAYER_SPHERES {
            let gap = length(frame.origin + s.center * 2.0 - bounds.center);
            assert!(gap + s.radius * 2.0 <= bounds.radius + 1e-5, "{gap}");
        }
    }
}
