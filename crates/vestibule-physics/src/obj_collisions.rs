//! Collision with objects: which shape decides, and what a hit means (`transition.md` 7.7, 8.1, 8.2).

use glam::Vec3;
use vestibule_world::{
    CellId, CylSphere, Frame, Landblock, Model, Shape, Sphere, StaticObject, StaticReach, StaticRef,
};

use crate::bsp_tree::spheres_overlap;
use crate::candidate::distance_to_statics;
use crate::flags::{ObjectKind, ObjectState, PhysicsState};
use crate::math::length;
use crate::population::BodyId;
use crate::sphere_path::LocalSpace;
use crate::sweep::Touch;
use crate::transition::{InsertType, StaticsCalm, Transition, TransitionState};

/// An object that can be run into: a static object of the world or a body of the population.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ObjectRef {
    /// A static object.
    Static(StaticRef),
    /// A body.
    Body(BodyId),
}

/// An object as the tests see it.
#[derive(Clone, Copy)]
pub(crate) struct Target<'w> {
    pub(crate) object: ObjectRef,
    pub(crate) cell: CellId,
    pub(crate) frame: &'w Frame,
    pub(crate) scale: f32,
    pub(crate) state: PhysicsState,
    pub(crate) kind: ObjectKind,
    pub(crate) shape: &'w Shape,
    pub(crate) part_frames: &'w [Frame],
}

impl<'w> Target<'w> {
    /// A static object as the world loads it (`world.md` B2).
    pub(crate) fn of_static(r: StaticRef, object: &'w StaticObject) -> Self {
        let mut state = PhysicsState::DEFAULT.with(PhysicsState::STATIC);
        state.set(PhysicsState::HAS_PHYSICS_BSP, object.shape.has_physics_bsp);
        Target {
            object: ObjectRef::Static(r),
            cell: object.cell,
            frame: &object.frame,
            scale: 1.0,
            state,
            kind: ObjectKind::NONE,
            shape: &object.shape,
            part_frames: &object.part_frames,
        }
    }

    /// Whether this is a creature.
    fn is_creature(&self) -> bool {
        self.kind.has(ObjectKind::CREATURE)
    }
}

impl<'w> Transition<'w, '_> {
    /// The objects that reach a cell, in the order they entered it (7.7).
    #[inline(always)]
    pub(crate) fn find_obj_collisions(&mut self, cell: CellId, block: &'w Landblock) -> TransitionState {
        if self.has_no_objects_near(cell, block, self.path.center(0)) {
            return TransitionState::Ok;
        }
        self.find_any_obj_collisions(cell, block)
    }

    /// Whether there certainly is no object of the cell in reach of the candidate, shifted so that its foot sphere
    /// is at `center`.
    #[inline(always)]
    pub(crate) fn has_no_objects_near(&self, cell: CellId, block: &'w Landblock, center: Vec3) -> bool {
        if self.population.has_bodies() && !self.population.is_alone_in(cell, self.object.body) {
            return false;
        }
        let shift = center - self.statics_calm.center;
        let calm = self.statics_calm.cell == cell && shift.dot(shift) < self.statics_calm.reach;
        calm || self.world.shadow_lists(block).is_empty_in(cell)
    }

    /// As [`Transition::has_no_objects_near`] at the candidate itself, looking closer.
    pub(crate) fn has_statics_afar(&mut self, cell: CellId, block: &'w Landblock) -> bool {
        let center = self.path.center(0);
        if self.has_no_objects_near(cell, block, center) {
            return true;
        }
        let alone = !self.population.has_bodies() || self.population.is_alone_in(cell, self.object.body);
        if !alone
            || !self.keeps_shape
            || self.world.settings().exact
            || cell.block() != self.path.check_pos.cell.block()
        {
            return false;
        }
        let (shape, at) = (self.path.shape(), self.path.candidate());
        let least = distance_to_statics(self.world.shadow_lists(block), cell, &shape, &at);
        if least > 0.0 {
            self.statics_calm = StaticsCalm {
                cell,
                center,
                reach: least * least,
            };
        }
        least > 0.0
    }

    #[inline(never)]
    fn find_any_obj_collisions(&mut self, cell: CellId, block: &'w Landblock) -> TransitionState {
        if self.path.insert_type == InsertType::InitialPlacement {
            return TransitionState::Ok;
        }
        let ts = self.find_static_collisions(cell, block);
        if ts != TransitionState::Ok {
            return ts;
        }
        for &id in self.population.shadows_in(cell) {
            if Some(id) == self.object.body {
                continue;
            }
            let Some(target) = self.population.target(id) else {
                continue;
            };
            let ts = self.find_object_collisions(&target);
            if ts != TransitionState::Ok {
                return ts;
            }
        }
        TransitionState::Ok
    }

    /// The static objects of a cell.
    fn find_static_collisions(&mut self, cell: CellId, block: &'w Landblock) -> TransitionState {
        let center = self.path.center(0);
        // Shifts of the candidate are measured in the frame of one landblock.
        let mut least = f32::INFINITY;
        for (r, reach) in self.world.shadow_lists(block).with_reaches(cell) {
            let distance = self.distance_to_reach(reach, cell);
            if distance > 0.0 && !self.world.settings().exact {
                least = if distance < least { distance } else { least };
                continue;
            }
            least = 0.0;
            let Some(object) = self.world.static_object(r) else {
                continue;
            };
            let ts = self.find_object_collisions(&Target::of_static(r, object));
            if ts != TransitionState::Ok {
                return ts;
            }
        }
        if self.keeps_shape && cell.block() == self.path.check_pos.cell.block() {
            self.statics_calm = StaticsCalm {
                cell,
                center,
                reach: least * least,
            };
        }
        TransitionState::Ok
    }

    /// How far the mover may be shifted before any of its spheres comes near what `reach` holds, metres; zero or
    /// less when one may be. Farther off, all tests find nothing.
    #[inline]
    fn distance_to_reach(&self, reach: &StaticReach, cell: CellId) -> f32 {
        let path = &self.path;
        let mut center = reach.sphere.center;
        if cell.block() != path.check_pos.cell.block() {
            center += self.blk(path.check_pos.cell, cell);
        }
        let [foot, head] = path.spheres();
        let larger = if head.radius > foot.radius {
            head.radius
        } else {
            foot.radius
        };
        let limit = reach.sphere.radius + reach.stretch * larger;
        let to_foot = length(foot.center - center) - limit;
        if path.num_sphere < 2 {
            return to_foot;
        }
        let to_head = length(head.center - center) - limit;
        if to_head < to_foot { to_head } else { to_foot }
    }

    /// One object (retail `FindObjCollisions`, 8.2).
    pub(crate) fn find_object_collisions(&mut self, target: &Target<'w>) -> TransitionState {
        let state = target.state;
        if state.has(PhysicsState::ETHEREAL | PhysicsState::IGNORE_COLLISIONS) {
            return TransitionState::Ok;
        }
        if self.object.is(ObjectState::IS_VIEWER) && target.is_creature() {
            return TransitionState::Ok;
        }
        let is_static = state.has(PhysicsState::STATIC);
        let ethereal = state.has(PhysicsState::ETHEREAL) || (self.object.ethereal && !is_static);
        if ethereal && self.path.step_down {
            return TransitionState::Ok;
        }
        self.path.obstruction_ethereal = ethereal;
        let is_creature = state.has(PhysicsState::MISSILE) || target.is_creature();
        let mut ts = TransitionState::Ok;
        if !self.player_passes(target) && !self.missile_ignores(target) {
            ts = self.find_shape_collisions(target, is_creature);
        }
        if ts != TransitionState::Ok && !self.path.step_down {
            if is_static {
                if !self.object.is(ObjectState::CONTACT) {
                    self.info.collided_with_environment = true;
                }
            } else if ethereal || (is_creature && self.object.is(ObjectState::IGNORE_CREATURES)) {
                ts = TransitionState::Ok;
                self.info.collision.valid = false;
                self.add_object(target.object, false);
            } else {
                self.add_object(target.object, true);
            }
        }
        self.path.obstruction_ethereal = false;
        ts
    }

    /// Players pass through each other unless both fight (8.2.5).
    fn player_passes(&self, target: &Target<'_>) -> bool {
        target.kind.has(ObjectKind::PLAYER)
            && self.object.is(ObjectState::IS_PLAYER)
            && !(self.object.is(ObjectState::IS_IMPENETRABLE)
                || target.kind.has(ObjectKind::IMPENETRABLE)
                || (self.object.is(ObjectState::IS_PK) && target.kind.has(ObjectKind::PK))
                || (self.object.is(ObjectState::IS_PKLITE) && target.kind.has(ObjectKind::PKLITE)))
    }

    /// Missiles pass through missiles, and through what they are not meant for (8.2).
    fn missile_ignores(&self, target: &Target<'_>) -> bool {
        if target.state.has(PhysicsState::MISSILE) {
            return true;
        }
        let meant = self.object.target.map(ObjectRef::Body);
        self.object.missile
            && meant != Some(target.object)
            && ((target.state.has(PhysicsState::ETHEREAL) && target.kind.has(ObjectKind::HAS_GAME_OBJECT))
                || (meant.is_some() && target.is_creature()))
    }

    /// Exactly one kind of shape is used: parts, else cylinders, else spheres.
    fn find_shape_collisions(&mut self, target: &Target<'w>, is_creature: bool) -> TransitionState {
        let shape = target.shape;
        if target.state.has(PhysicsState::HAS_PHYSICS_BSP) {
            for (part, frame) in shape.parts.iter().zip(target.part_frames) {
                let Some(model) = &part.model else { continue };
                let space = LocalSpace {
                    cell: target.cell,
                    frame,
                    scale: part.scale.z * target.scale,
                };
                let ts = self.find_part_collisions(model, space);
                if ts != TransitionState::Ok {
                    return ts;
                }
            }
            return TransitionState::Ok;
        }
        let offset = self.blk(self.path.check_pos.cell, target.cell);
        let to_global = |p: Vec3| offset + target.frame.local_to_global(p * target.scale);
        for cylinder in &shape.cylspheres {
            let global = CylSphere {
                low_point: to_global(cylinder.low_point),
                radius: cylinder.radius * target.scale,
                height: cylinder.height * target.scale,
            };
            let ts = self.intersects_cylsphere(&global, target.frame);
            if ts != TransitionState::Ok {
                return ts;
            }
        }
        if !shape.cylspheres.is_empty() {
            return TransitionState::Ok;
        }
        for sphere in &shape.spheres {
            let global = Sphere {
                center: to_global(sphere.center),
                radius: sphere.radius * target.scale,
            };
            let ts = self.intersects_sphere(&global, is_creature);
            if ts != TransitionState::Ok {
                return ts;
            }
        }
        TransitionState::Ok
    }

    /// One part: its tree is run once if any sphere of the mover overlaps its physics sphere (8.1).
    pub(crate) fn find_part_collisions(
        &mut self,
        model: &'w Model,
        space: LocalSpace<'w>,
    ) -> TransitionState {
        let (Some(bsp), Some(bound)) = (&model.physics, &model.physics_sphere) else {
            return TransitionState::Ok;
        };
        self.path.cache_localspace_sphere(space);
        let reached = spheres_overlap(bound, &self.path.localspace_foot.into())
            || (self.path.num_sphere > 1 && spheres_overlap(bound, &self.path.localspace_head().into()));
        if !reached {
            return TransitionState::Ok;
        }
        if self.path.insert_type == InsertType::InitialPlacement {
            self.placement_insert_into_bsp(bsp)
        } else {
            self.find_collisions_with_bsp(bsp)
        }
    }

    /// Notes that the mover ran into an object (retail `add_object`).
    fn add_object(&mut self, object: ObjectRef, stopped: bool) {
        if !self.touched.iter().any(|t| t.object == object) {
            self.touched.push(Touch { object, stopped });
        }
    }
}
