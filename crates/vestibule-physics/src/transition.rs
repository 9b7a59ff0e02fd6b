//! One sweep (retail `CTransition`, `transition.md` 2.5, 3.3 to 3.5).

use glam::Vec3;
use vestibule_world::ids::block_offset;
use vestibule_world::{CellArray, CellId, World, find_cell_list};

use crate::collision_info::CollisionInfo;
use crate::constants::{EPSILON, MOVE_ATTEMPTS};
use crate::flags::ObjectState;
use crate::math::{interpolate_rotation, length};
use crate::object_info::ObjectInfo;
use crate::population::Population;
use crate::settings::Settings;
use crate::sphere_path::{CellRef, SpherePath};
use crate::sweep::Touch;

/// What an insertion says of the candidate pose (`transition.md` 2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TransitionState {
    /// Nothing was done.
    Invalid,
    /// The candidate is acceptable.
    Ok,
    /// The candidate is rejected.
    Collided,
    /// The candidate was moved onto a surface: try again.
    Adjusted,
    /// The candidate was moved along an obstacle and lost its contact plane: try again.
    Slid,
}

/// How the candidate is inserted (`transition.md` 2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InsertType {
    Transition,
    Placement,
    InitialPlacement,
}

/// A sweep in progress. It reads the world and the population and writes only what it owns.
pub(crate) struct Transition<'w, 's> {
    pub(crate) world: &'w World,
    pub(crate) population: &'w Population,
    pub(crate) settings: Settings,
    pub(crate) object: ObjectInfo,
    pub(crate) path: SpherePath<'w>,
    pub(crate) info: CollisionInfo,
    /// Shared by all nested insertions; the cell found is not (5.3).
    pub(crate) cell_array: &'s mut CellArray,
    pub(crate) touched: &'s mut Vec<Touch>,
    /// Nesting of `transitional_insert`.
    pub(crate) depth: u32,
}

/// How a move is divided into steps (3.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StepPlan {
    pub(crate) offset: Vec3,
    /// Replaces `offset` in the last step of a viewer.
    pub(crate) last_offset: Option<Vec3>,
    pub(crate) steps: u32,
}

/// Divides the move `d` of a mover with foot radius `r` into steps (3.4).
pub(crate) fn calc_num_steps(d: Vec3, r: f32, viewer: bool) -> StepPlan {
    let r = if r <= EPSILON { EPSILON } else { r };
    let l = length(d);
    let ratio = l / r;
    if viewer {
        if l <= EPSILON {
            return StepPlan {
                offset: Vec3::ZERO,
                last_offset: None,
                steps: 0,
            };
        }
        let n = ratio.floor() + 1.0;
        let last = d * (l - r * (n - 1.0)) / l;
        StepPlan {
            offset: d * (r / l),
            last_offset: Some(last),
            steps: n as u32,
        }
    } else if ratio > 1.0 {
        let n = ratio.ceil();
        StepPlan {
            offset: Vec3::new(d.x / n, d.y / n, d.z / n),
            last_offset: None,
            steps: n as u32,
        }
    } else if d != Vec3::ZERO {
        StepPlan {
            offset: d,
            last_offset: None,
            steps: 1,
        }
    } else {
        StepPlan {
            offset: Vec3::ZERO,
            last_offset: None,
            steps: 0,
        }
    }
}

impl<'w> Transition<'w, '_> {
    /// What to add to a point in the frame of `b`'s landblock to express it in that of `a`'s (1.5.2).
    #[inline]
    pub(crate) fn blk(&self, a: CellId, b: CellId) -> Vec3 {
        block_offset(a.block(), b.block())
    }

    /// The resident cell with this id.
    #[inline]
    pub(crate) fn cell_ref(&self, id: CellId) -> Option<CellRef<'w>> {
        cell_ref(self.world, id)
    }

    /// Rebuilds the cell array for the candidate; the cell that holds the foot sphere's centre if `want_cell`.
    #[inline]
    pub(crate) fn build_cell_array(&mut self, want_cell: bool) -> Option<CellId> {
        let path = &mut self.path;
        path.cell_array_valid = true;
        let found = find_cell_list(
            self.world,
            path.check_pos.cell,
            path.check_pos.frame.origin,
            &path.global_sphere[..path.num_sphere],
            self.cell_array,
            want_cell,
        );
        path.hits_interior_cell = found.hits_interior;
        found.containing
    }

    /// Runs the sweep (3.3). `plan` comes from [`calc_num_steps`] and is not used by placements.
    pub(crate) fn find_valid_position(&mut self, plan: &StepPlan) -> bool {
        if self.path.insert_type == InsertType::Transition {
            self.find_transitional_position(plan)
        } else {
            self.find_placement_position()
        }
    }

    /// Moves in steps, each accepted or rejected as a whole (3.5).
    fn find_transitional_position(&mut self, plan: &StepPlan) -> bool {
        if self.path.curr_cell.is_none() {
            return false;
        }
        let viewer = self.object.is(ObjectState::IS_VIEWER);
        let free_rotate = self.object.is(ObjectState::FREE_ROTATE);
        let (begin, end) = (
            self.path.curr_pos.frame.rotation(),
            self.path.end_pos.frame.rotation(),
        );
        if free_rotate || plan.steps == 0 {
            self.path.curr_pos.frame.set_rotation(end);
        }
        self.path.set_check_to_curr();
        if plan.steps == 0 {
            self.build_cell_array(false);
            return true;
        }
        let mut ts = TransitionState::Ok;
        for i in 0..plan.steps {
            let offset = match plan.last_offset {
                Some(last) if i + 1 == plan.steps => last,
                _ => plan.offset,
            };
            let offset = self.adjust_offset(offset);
            if !viewer && EPSILON * EPSILON > offset.dot(offset) {
                return i != 0 && ts == TransitionState::Ok;
            }
            if !free_rotate && begin != end {
                let t = (i + 1) as f32 / plan.steps as f32;
                self.path
                    .check_pos
                    .frame
                    .set_rotation(interpolate_rotation(begin, end, t));
            }
            self.info.sliding.valid = false;
            self.info.clear_contact_plane();
            self.path.add_offset_to_check_pos(offset);
            ts = self.transitional_insert(MOVE_ATTEMPTS);
            ts = self.validate_transition(ts);
            if self.info.frames_stationary_fall != 0 {
                break;
            }
            if self.info.collision.valid && self.object.is(ObjectState::PATH_CLIPPED) {
                break;
            }
        }
        ts == TransitionState::Ok
    }
}

/// The resident cell with this id.
#[inline]
pub(crate) fn cell_ref(world: &World, id: CellId) -> Option<CellRef<'_>> {
    if id.is_indoor() {
        world.env_cell(id).map(CellRef::Env)
    } else {
        let block = world.block(id.block())?;
        let cell = block.land_cell(id)?;
        Some(CellRef::Land { id, cell, block })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(l: f32, r: f32, viewer: bool) -> StepPlan {
        calc_num_steps(Vec3::new(0.0, l, 0.0), r, viewer)
    }

    #[test]
    fn w1_to_w5_steps_of_a_walker() {
        for (l, steps, each) in [
            (0.30, 1, 0.30),
            (0.48, 1, 0.48),
            (1.00, 3, 0.333_333),
            (1.50, 4, 0.375),
            (1.90, 4, 0.475),
        ] {
            let p = plan(l, 0.48, false);
            assert_eq!(p.steps, steps, "{l}");
            assert!((p.offset.y - each).abs() < 1e-5, "{l}");
            assert_eq!(p.last_offset, None);
        }
        assert_eq!(plan(0.0, 0.48, false).steps, 0);
        // A tiny move of a walker is a step all the same.
        assert_eq!(plan(0.0001, 0.48, false).steps, 1);
    }

    #[test]
    fn w6_steps_of_the_viewer() {
        assert_eq!(plan(0.0001, 0.3, true).steps, 0);
        for (l, steps, last) in [(0.20, 1, 0.20), (1.00, 4, 0.1), (2.50, 9, 0.1)] {
            let p = plan(l, 0.3, true);
            assert_eq!(p.steps, steps, "{l}");
            assert!((p.offset.y - 0.3).abs() < 1e-5);
            assert!((p.last_offset.unwrap().y - last).abs() < 1e-5, "{l}");
        }
    }

    #[test]
    fn s3_4_a_foot_without_radius_steps_by_epsilon() {
        assert_eq!(plan(0.001, 0.0, false).steps, 6);
    }
}
