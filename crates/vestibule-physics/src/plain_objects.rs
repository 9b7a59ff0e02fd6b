//! The usual step down where static objects are stood on, worked out without a transition (`transition.md` 5.8, 6.11.1,
//! 7.1, 8.2); see [`crate::plain_step`].

use vestibule_world::{CellId, EnvCell, Face, Frame, Lanes, PhysicsBsp, StaticObject};

use crate::bsp_tree::{self, WalkableSearch};
use crate::candidate::Candidate;
use crate::constants::{FLOOR_Z, STEP_DOWN_ATTEMPTS};
use crate::flags::ObjectState;
use crate::plain_step::{PlainStep, has_ground_below};
use crate::polygon;
use crate::statics_around::clears_object;

/// What has lifted a candidate.
struct Ground<'b> {
    bsp: &'b PhysicsBsp,
    face: &'b Face,
    /// The foot sphere on it, and what is up, in the frame of the tree.
    sphere: Lanes,
    up: Lanes,
    /// Its plane in the landblock's frame.
    plane: Lanes,
}

/// A candidate on its way back up.
struct Lowered<'a> {
    pose: &'a mut Candidate,
    /// How far it was lowered, metres, and what is left of that.
    depth: f32,
    interp: f32,
}

impl PlainStep<'_> {
    /// Where a lowered pose comes to rest among the floors of a room and the static objects in it: the plane stood on.
    /// The pose then touches no ground of either. `None` where it does not, or something else is touched.
    #[inline(never)]
    pub(crate) fn rest_on_objects(&self, cell: &EnvCell, pose: &mut Candidate, depth: f32) -> Option<Lanes> {
        if self.world.shadow_lists(self.block).is_empty_in(cell.id) {
            return None;
        }
        let mut lowered = Lowered {
            pose,
            depth,
            interp: 1.0,
        };
        let mut ground = None;
        for _ in 0..STEP_DOWN_ATTEMPTS {
            let room = cell.structure.physics.as_ref();
            let lifted = match room.and_then(|bsp| self.lift_onto(bsp, &cell.frame, &mut lowered)) {
                Some(floor) => Some(floor),
                None => self.lift_onto_an_object(cell.id, &mut lowered)?,
            };
            if lifted.is_none() {
                return self.supported_by(&ground?, cell, lowered.pose, depth);
            }
            ground = lifted;
        }
        None
    }

    /// The ground's plane, if it is level enough and holds the foot.
    fn supported_by(
        &self,
        ground: &Ground<'_>,
        cell: &EnvCell,
        pose: &Candidate,
        depth: f32,
    ) -> Option<Lanes> {
        let half = self.shape.arms[0].fourth() * 0.5;
        let edges = ground.bsp.edges(ground.face);
        let holds = !self.mover.state.has(ObjectState::EDGE_SLIDE)
            || polygon::check_walkable(ground.face, edges, ground.sphere, half, ground.up)
            || has_ground_below(cell, self.shape, *pose, depth, FLOOR_Z);
        (holds && !(ground.plane.z() < FLOOR_Z)).then_some(ground.plane)
    }

    /// The first object of a cell that lifts the pose, in the order in which they are asked; the outer `None` where
    /// that is not easily told.
    fn lift_onto_an_object(&self, cell: CellId, lowered: &mut Lowered<'_>) -> Option<Option<Ground<'_>>> {
        let lists = self.world.shadow_lists(self.block);
        for (refs, quad) in lists.of(cell).chunks(4).zip(lists.quads(cell)) {
            let distances = quad.distances(lowered.pose.spheres, self.shape.larger_radius());
            let mut near = !Lanes::ZERO.less(distances) & 0b1111;
            while near != 0 {
                let k = near.trailing_zeros() as usize;
                near &= near - 1;
                let Some(object) = refs.get(k).and_then(|&r| self.world.static_object(r)) else {
                    continue;
                };
                if object.cell.block() != cell.block() {
                    return None;
                }
                if object.shape.has_physics_bsp {
                    if let Some(ground) = self.lift_onto_parts(object, lowered)? {
                        return Some(Some(ground));
                    }
                } else if !clears_object(object, &self.shape, lowered.pose, false) {
                    // Spheres and cylinders lift in their own ways.
                    return None;
                }
            }
        }
        Some(None)
    }

    fn lift_onto_parts<'b>(
        &self,
        object: &'b StaticObject,
        lowered: &mut Lowered<'_>,
    ) -> Option<Option<Ground<'b>>> {
        for (part, frame) in object.shape.parts.iter().zip(&object.part_frames) {
            let model = part.model.as_ref();
            let Some((bsp, bound)) = model.and_then(|m| Some((m.physics.as_ref()?, m.physics_sphere?)))
            else {
                continue;
            };
            if part.scale.z != 1.0 {
                return None;
            }
            let is_reached = |i| {
                let sphere = lowered.pose.local(&self.shape, frame, i);
                bsp_tree::spheres_overlap(&bound, &sphere.into())
            };
            if !(is_reached(0) || (self.shape.two && is_reached(1))) {
                continue;
            }
            if let Some(ground) = self.lift_onto(bsp, frame, lowered) {
                return Some(Some(ground));
            }
        }
        Some(None)
    }

    /// Lifts the pose onto what it can stand on of a tree, back along the way it was lowered (6.11.1).
    fn lift_onto<'b>(
        &self,
        bsp: &'b PhysicsBsp,
        frame: &Frame,
        lowered: &mut Lowered<'_>,
    ) -> Option<Ground<'b>> {
        let foot = lowered.pose.local(&self.shape, frame, 0);
        if bsp.certainly_clear(foot) {
            return None;
        }
        let up = frame.up();
        let mut search = WalkableSearch {
            sphere: foot,
            movement: up * -(lowered.depth * lowered.interp),
            up,
            walkable_allowance: FLOOR_Z,
            walk_interp: lowered.interp,
            found: None,
        };
        bsp_tree::find_walkable(bsp, &mut search);
        let face = search.found?;
        lowered.interp = search.walk_interp;
        lowered.pose.shift(frame.turned_out(search.sphere - foot));
        Some(Ground {
            bsp,
            face,
            sphere: search.sphere,
            up,
            plane: frame.plane_out(&face.plane),
        })
    }
}
