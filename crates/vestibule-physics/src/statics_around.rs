//! Objects near a candidate of the usual steps: how far they are, and whether it certainly touches none of them
//! (`transition.md` 8.2).

use glam::Vec3;
use vestibule_world::{CellId, CylSphere, Lanes, ReachQuad, ShadowLists, Sphere, StaticObject};

use crate::candidate::{Candidate, Shape};
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
        let quads = lists.quads(cell);
        if quads.is_empty() {
            return Some(f32::INFINITY);
        }
        let distance = distance_to_statics(quads, pose.spheres, self.shape.larger_radius());
        if distance > 0.0 {
            return Some(distance);
        }
        self.look_at_statics(lists, cell, *pose, placing)
    }

    /// As [`PlainStep::objects_around`] where some static object may be in reach: looking at it closely.
    #[inline(never)]
    pub(crate) fn look_at_statics(
        &self,
        lists: &ShadowLists,
        cell: CellId,
        pose: Candidate,
        placing: bool,
    ) -> Option<f32> {
        let mut least = Lanes::splat(f32::INFINITY);
        for (refs, quad) in lists.of(cell).chunks(4).zip(lists.quads(cell)) {
            let mut distances = quad.distances(pose.spheres, self.shape.larger_radius());
            let mut near = !Lanes::ZERO.less(distances) & 0b1111;
            while near != 0 {
                let k = near.trailing_zeros() as usize;
                near &= near - 1;
                let object = refs.get(k).and_then(|&r| self.world.static_object(r));
                let distance = match object {
                    Some(object) if object.cell.block() == cell.block() => {
                        distance_to_object(object, &self.shape, &pose, placing)?
                    }
                    Some(_) => return None,
                    None => f32::INFINITY,
                };
                distances.set_lane(k, distance);
            }
            least = distances.lesser(least);
        }
        Some(least.least())
    }
}

/// How far spheres may be shifted before one comes near a static object, metres.
#[inline(never)]
pub(crate) fn distance_to_statics(quads: &[ReachQuad], spheres: [Lanes; 2], larger: f32) -> f32 {
    let mut least = Lanes::splat(f32::INFINITY);
    for quad in quads {
        least = quad.distances(spheres, larger).lesser(least);
    }
    least.least()
}

/// As [`clears_object`]; how far the pose may be shifted and still does, metres, as far as that is known.
fn distance_to_object(object: &StaticObject, shape: &Shape, pose: &Candidate, placing: bool) -> Option<f32> {
    if !object.shape.has_physics_bsp || placing {
        return clears_object(object, shape, pose, placing).then_some(0.0);
    }
    let mut least = f32::INFINITY;
    for (part, frame) in object.shape.parts.iter().zip(&object.part_frames) {
        let model = part.model.as_ref();
        let Some((bsp, bound)) = model.and_then(|m| Some((m.physics.as_ref()?, m.physics_sphere?))) else {
            continue;
        };
        if part.scale.z != 1.0 {
            return None;
        }
        let distance = pose.distance_to_part(shape, frame, bsp, &bound);
        if distance < 0.0 {
            return None;
        }
        least = if distance < least { distance } else { least };
    }
    Some(least)
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
