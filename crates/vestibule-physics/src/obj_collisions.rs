//! Collision with objects: which shape decides, and what a hit means (`transition.md` 7.7, 8.1, 8.2).

use glam::Vec3;
use vestibule_world::{
    CellId, CylSphere, Frame, Landblock, Model, PhysicsBsp, Shape, Sphere, StaticObject, StaticReach,
    StaticRef,
};

use crate::bsp_tree::spheres_overlap;
use crate::flags::{ObjectKind, ObjectState, PhysicsState};
use crate::math::length;
use crate::population::BodyId;
use crate::sphere_path::LocalSpace;
use crate::sweep::Touch;
use crate::transition::{InsertType, Transition, TransitionState};

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
    /// Whether this is a creature.
    fn is_creature(&self) -> bool {
        self.kind.has(ObjectKind::CREATURE)
    }
}

impl<'w> Transition<'w, '_> {
    /// The objects that reach a cell, in the order they entered it (7.7).
    #[inline(always)]
    pub(crate) fn find_obj_collisions(&mut self, cell: CellId, block: &'w Landblock) -> TransitionState {
        if self.has_no_objects_near(cell, block, self.path.global_sphere[0]) {
            return TransitionState::Ok;
        }
        self.find_any_obj_collisions(cell, block)
    }

    #[inline(never)]
    fn find_any_obj_collisions(&mut self, cell: CellId, block: &'w Landblock) -> TransitionState {
        if self.path.insert_type == InsertType::InitialPlacement {
            return TransitionState::Ok;
        }
        if let Some(objects) = self.only_statics_near(cell, block) {
            for object in objects.into_iter().map_while(|object| object) {
                let ts = self.find_static_object_collisions(object);
                if ts != TransitionState::Ok {
                    return ts;
                }
            }
            return TransitionState::Ok;
        }
        self.find_all_obj_collisions(cell, block)
    }

    /// Everything that is not certainly out of reach.
    #[inline(never)]
    fn find_all_obj_collisions(&mut self, cell: CellId, block: &'w Landblock) -> TransitionState {
        for (r, reach) in self.world.shadow_lists(block).with_reaches(cell) {
            if self.distance_to_reach(reach, cell) > 0.0 && !self.world.settings().exact {
                continue;
            }
            let Some(object) = self.world.static_object(r) else {
                continue;
            };
            let ts = self.find_static_object_collisions(object);
            if ts != TransitionState::Ok {
                return ts;
            }
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

    /// As [`Transition::find_object_collisions`] for a static object, which nobody passes through or runs into for
    /// nothing, and which is never noted.
    #[inline(always)]
    fn find_static_object_collisions(&mut self, object: &'w StaticObject) -> TransitionState {
        self.path.obstruction_ethereal = false;
        let shape = &object.shape;
        let ts = if shape.has_physics_bsp {
            self.find_parts_collisions(shape, &object.part_frames, object.cell, 1.0)
        } else {
            self.find_simple_collisions(shape, &object.frame, object.cell, 1.0, false)
        };
        if ts != TransitionState::Ok && !self.path.step_down && !self.object.is(ObjectState::CONTACT) {
            self.info.collided_with_environment = true;
        }
        ts
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
        let (shape, cell, scale) = (target.shape, target.cell, target.scale);
        if target.state.has(PhysicsState::HAS_PHYSICS_BSP) {
            self.find_parts_collisions(shape, target.part_frames, cell, scale)
        } else {
            self.find_simple_collisions(shape, target.frame, cell, scale, is_creature)
        }
    }

    #[inline(always)]
    fn find_parts_collisions(
        &mut self,
        shape: &'w Shape,
        frames: &'w [Frame],
        cell: CellId,
        scale: f32,
    ) -> TransitionState {
        for (part, frame) in shape.parts.iter().zip(frames) {
            let Some(model) = &part.model else { continue };
            let space = LocalSpace {
                cell,
                frame,
                scale: part.scale.z * scale,
            };
            let ts = self.find_part_collisions(model, space);
            if ts != TransitionState::Ok {
                return ts;
            }
        }
        TransitionState::Ok
    }

    fn find_simple_collisions(
        &mut self,
        shape: &Shape,
        frame: &Frame,
        cell: CellId,
        scale: f32,
        is_creature: bool,
    ) -> TransitionState {
        let offset = self.blk(self.path.check_pos.cell, cell);
        let to_global = |p: Vec3| offset + frame.local_to_global(p * scale);
        for cylinder in &shape.cylspheres {
            let global = CylSphere {
                low_point: to_global(cylinder.low_point),
                radius: cylinder.radius * scale,
                height: cylinder.height * scale,
            };
            let ts = self.intersects_cylsphere(&global, frame);
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
                radius: sphere.radius * scale,
            };
            let ts = self.intersects_sphere(&global, is_creature);
            if ts != TransitionState::Ok {
                return ts;
            }
        }
        TransitionState::Ok
    }

    /// Whether the static objects of a cell certainly have nothing that the candidate can be lowered onto, nor anything
    /// else that answers a step down.
    pub(crate) fn statics_bear_nothing(&mut self, cell: CellId, block: &'w Landblock) -> bool {
        let Some(objects) = self.only_statics_near(cell, block) else {
            return false;
        };
        objects.into_iter().map_while(|object| object).all(|object| {
            let shape = &object.shape;
            shape.has_physics_bsp
                && shape.parts.iter().zip(&object.part_frames).all(|(part, frame)| {
                    let Some(model) = &part.model else { return true };
                    let space = LocalSpace {
                        cell: object.cell,
                        frame,
                        scale: part.scale.z,
                    };
                    self.reached_bsp(model, space)
                        .is_none_or(|bsp| !self.finds_walkable(bsp))
                })
        })
    }

    /// The tree of a part if any sphere of the mover overlaps its physics sphere (8.1). Goes to its space.
    #[inline(always)]
    fn reached_bsp(&mut self, model: &'w Model, space: LocalSpace<'w>) -> Option<&'w PhysicsBsp> {
        let (Some(bsp), Some(bound)) = (&model.physics, &model.physics_sphere) else {
            return None;
        };
        self.path.cache_localspace_sphere(space);
        let reached = spheres_overlap(bound, &self.path.localspace_foot.into())
            || (self.path.num_sphere > 1 && spheres_overlap(bound, &self.path.localspace_head().into()));
        reached.then_some(bsp)
    }

    /// One part: its tree is run once if any sphere of the mover overlaps its physics sphere (8.1).
    pub(crate) fn find_part_collisions(
        &mut self,
        model: &'w Model,
        space: LocalSpace<'w>,
    ) -> TransitionState {
        let Some(bsp) = self.reached_bsp(model, space) else {
            return TransitionState::Ok;
        };
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
