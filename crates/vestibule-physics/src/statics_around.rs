//! Objects near a candidate of the usual steps: how far they are, and whether it certainly touches none of them
//! (`transition.md` 8.2).

use glam::Vec3;
use vestibule_world::{CellId, CylSphere, Lanes, ShadowLists, Sphere, StaticObject, StaticReach, World};

use crate::candidate::{Candidate, Shape, distance_to_statics};
use crate::cylsphere::overlaps_cylinder;
use crate::plain_step::PlainStep;
use crate::sphere::overlaps_sphere;

impl PlainStep<'_> {
    /// Whether no other body reaches into a cell.
    #[inline(always)]
    pub(crate) fn is_alone_in(&self, cell: CellId) -> bool {
        !self.population.has_bodies() || self.population.is_alone_in(cell, self.mover.body)
    }

    /// How far a pose may be shifted before it comes near an object, metres: zero when it is near some but clears
    /// them. `None` when it does not, or that is not easily told. `placing`: as a placement insertion asks.
    #[inline(always)]
    pub(crate) fn objects_around(&self, cell: CellId, pose: &Candidate, placing: bool) -> Option<f32> {
        if !self.is_alone_in(cell) {
            return None;
        }
        let lists = self.world.shadow_lists(self.block);
        if lists.is_empty_in(cell) {
            return Some(f32::INFINITY);
        }
        let (shape, pose) = (self.shape, *pose);
        statics_around(self.world, lists, cell, &shape, &pose, placing)
    }
}

impl PlainStep<'_> {
    /// How far a pose may be shifted before it comes near what is within `reach`, metres.
    pub(crate) fn distance_to_reach(&self, reach: &StaticReach, pose: &Candidate) -> f32 {
        distance_to_reach(reach, &self.shape, pose)
    }
}

fn distance_to_reach(reach: &StaticReach, shape: &Shape, pose: &Candidate) -> f32 {
    reach.distance(pose.spheres.map(Lanes::xyz), shape.larger_radius())
}

/// See [`PlainStep::objects_around`].
#[inline(never)]
fn statics_around(
    world: &World,
    lists: &ShadowLists,
    cell: CellId,
    shape: &Shape,
    pose: &Candidate,
    placing: bool,
) -> Option<f32> {
    let least = distance_to_statics(lists, cell, shape, pose);
    if least > 0.0 {
        return Some(least);
    }
    clears_statics(world, lists, cell, shape, pose, placing).then_some(0.0)
}

/// Whether a pose that is near static objects certainly touches none of them.
fn clears_statics(
    world: &World,
    lists: &ShadowLists,
    cell: CellId,
    shape: &Shape,
    pose: &Candidate,
    placing: bool,
) -> bool {
    lists.with_reaches(cell).all(|(r, reach)| {
        if distance_to_reach(reach, shape, pose) > 0.0 {
            return true;
        }
        let Some(object) = world.static_object(r) else {
            return true;
        };
        object.cell.block() == cell.block() && clears_object(object, shape, pose, placing)
    })
}

/// Whether a pose certainly does not touch a static object of its landblock: by the one kind of shape that counts
/// (8.2).
pub(crate) fn clears_object(object: &StaticObject, mover: &Shape, pose: &Candidate, placing: bool) -> bool {
    let shape = &object.shape;
    if shape.has_physics_bsp {
        return shape.parts.iter().zip(&object.part_frames).all(|(part, frame)| {
            let model = part.model.as_ref();
            let Some((bsp, bound)) = model.and_then(|m| Some((m.physics.as_ref()?, m.physics_sphere?)))
            else {
                return true;
            };
            part.scale.z == 1.0 && pose.clears_part(mover, frame, bsp, &bound, placing)
        });
    }
    let place = |p: Vec3| Vec3::ZERO + object.frame.local_to_global(p);
    if shape.cylspheres.is_empty() {
        let place = |s: &Sphere| Sphere::new(place(s.center), s.radius);
        let mut spheres = shape.spheres.iter().map(place);
        return !spheres.any(|s| overlaps_sphere(&s, &pose.spheres(), mover.count()));
    }
    let place = |c: &CylSphere| CylSphere {
        low_point: place(c.low_point),
        ..*c
    };
    let mut cylinders = shape.cylspheres.iter().map(place);
    !cylinders.any(|c| overlaps_cylinder(&c, &pose.spheres(), mover.count()))
}
