//! One sweep (retail `CTransition`, `transition.md` 2.5, 3.3 to 3.5).

use glam::{Quat, Vec3};
use vestibule_world::ids::block_offset;
use vestibule_world::{CellArray, CellEntry, CellId, Lanes, World, certain_cells, find_cell_list};

use crate::candidate::Candidate;
use crate::collision_info::CollisionInfo;
use crate::constants::{EPSILON, MOVE_ATTEMPTS};
use crate::flags::ObjectState;
use crate::math::{interpolate_rotation, length};
use crate::near_statics::NearStatics;
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

/// What the cell array was built for, and what was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BuiltArray {
    seed: CellId,
    /// Of the spheres.
    centers: [Lanes; 2],
    /// How far the spheres may be shifted together without changing anything, squared.
    reach: f32,
    /// The array lists the seed only.
    alone: bool,
    want_cell: bool,
    containing: Option<CellId>,
    hits_interior: bool,
    /// The seed that nothing was certain around at `centers`: then nothing is a little farther on.
    failed_in: CellId,
}

impl BuiltArray {
    /// Nothing has been built.
    pub(crate) const NONE: BuiltArray = BuiltArray {
        seed: CellId::NONE,
        centers: [Lanes::splat(f32::NAN); 2],
        reach: 0.0,
        alone: false,
        want_cell: false,
        containing: None,
        hits_interior: false,
        failed_in: CellId::NONE,
    };

    /// The array that [`vestibule_world::certain_cells`] left, good for shifts of less than `distance`.
    #[inline(always)]
    pub(crate) fn certain(seed: CellId, centers: [Lanes; 2], distance: f32, array: &CellArray) -> Self {
        if !(distance > 0.0) {
            return BuiltArray {
                failed_in: seed,
                centers,
                ..BuiltArray::NONE
            };
        }
        BuiltArray {
            seed,
            centers,
            reach: distance * distance,
            alone: array.len() == 1,
            want_cell: true,
            containing: Some(seed),
            hits_interior: seed.is_indoor(),
            failed_in: CellId::NONE,
        }
    }

    /// Whether it makes sense to look for what is certain around a candidate in the cell `seed` whose foot sphere is at
    /// `foot`.
    #[inline(always)]
    pub(crate) fn may_be_certain(&self, seed: CellId, foot: Lanes) -> bool {
        /// Of shifts, squared: longer ones are those of steps up and down, metres.
        const FAR: f32 = 0.3 * 0.3;
        let shift = foot - self.centers[0];
        self.failed_in != seed || !(shift.dot(shift) < FAR)
    }

    /// Whether the array is certainly right for a candidate in the cell `seed` whose foot sphere is at `foot`.
    #[inline(always)]
    pub(crate) fn holds(&self, seed: CellId, foot: Lanes) -> bool {
        let shift = foot - self.centers[0];
        self.seed == seed && shift.dot(shift) < self.reach
    }
}

/// A sweep in progress. It reads the world and the population and writes only what it owns.
pub(crate) struct Transition<'w, 's> {
    pub(crate) world: &'w World,
    pub(crate) population: &'w Population,
    pub(crate) settings: &'w Settings,
    pub(crate) object: ObjectInfo,
    pub(crate) path: SpherePath<'w>,
    pub(crate) info: CollisionInfo,
    /// Shared by all nested insertions; the cell found is not (5.3).
    pub(crate) cell_array: &'s mut CellArray,
    pub(crate) built: BuiltArray,
    /// In the own cell and in another.
    pub(crate) near_statics: [NearStatics<'w>; 2],
    /// The mover does not turn during the sweep.
    pub(crate) keeps_shape: bool,
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
    pub(crate) end_rotation: Quat,
}

impl StepPlan {
    /// A move in one step.
    pub(crate) fn whole(offset: Vec3, end_rotation: Quat) -> Self {
        StepPlan {
            offset,
            last_offset: None,
            steps: 1,
            end_rotation,
        }
    }
}

/// Divides the move `d` of a mover with foot radius `r` into steps (3.4).
pub(crate) fn calc_num_steps(d: Vec3, r: f32, viewer: bool, end_rotation: Quat) -> StepPlan {
    let r = if r <= EPSILON { EPSILON } else { r };
    let l = length(d);
    let plan = |offset, steps: f32, last_offset| StepPlan {
        offset,
        last_offset,
        steps: steps as u32,
        end_rotation,
    };
    if viewer {
        if l <= EPSILON {
            return plan(Vec3::ZERO, 0.0, None);
        }
        let n = (l / r).floor() + 1.0;
        let last = d * (l - r * (n - 1.0)) / l;
        plan(d * (r / l), n, Some(last))
    } else if l / r > 1.0 {
        let n = (l / r).ceil();
        plan(Vec3::new(d.x / n, d.y / n, d.z / n), n, None)
    } else if d != Vec3::ZERO {
        plan(d, 1.0, None)
    } else {
        plan(Vec3::ZERO, 0.0, None)
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

    /// Whether the cell array is certainly right for the candidate.
    #[inline(always)]
    pub(crate) fn is_array_certain(&self) -> bool {
        self.built
            .holds(self.path.check_pos.cell, self.path.global_sphere[0])
    }

    /// Whether the candidate certainly touches its own cell only.
    #[inline(always)]
    pub(crate) fn is_calm(&self) -> bool {
        self.built.alone && self.is_array_certain()
    }

    /// The cells that the candidate touches besides its own, if the array is certain: rooms of the same landblock.
    #[inline(always)]
    pub(crate) fn other_rooms(&self) -> &[CellEntry] {
        self.cell_array.entries().get(1..).unwrap_or(&[])
    }

    /// Rebuilds the cell array for the candidate; the cell that holds the foot sphere's centre if `want_cell`.
    #[inline(always)]
    pub(crate) fn build_cell_array(&mut self, want_cell: bool) -> Option<CellId> {
        if !self.is_array_certain() {
            self.build_any_cell_array(want_cell);
        }
        self.path.hits_interior_cell = self.built.hits_interior;
        self.built.containing
    }

    /// An array that was built for the same candidate is the same again.
    #[inline(never)]
    fn build_any_cell_array(&mut self, want_cell: bool) {
        let at = self.path.candidate();
        let (seed, centers) = (self.path.check_pos.cell, at.spheres);
        let built = &self.built;
        let same = built.seed == seed && built.centers == centers && (built.want_cell || !want_cell);
        if same && !self.world.settings().exact {
            return;
        }
        if self.keeps_shape && built.may_be_certain(seed, centers[0]) && self.know_cells_at(seed, &at) {
            return;
        }
        let spheres = at.spheres();
        let spheres = spheres.get(..self.path.num_sphere).unwrap_or(&spheres);
        let found = find_cell_list(
            self.world,
            seed,
            at.origin.xyz(),
            spheres,
            self.cell_array,
            want_cell,
        );
        self.built = BuiltArray {
            seed,
            centers,
            reach: 0.0,
            alone: false,
            want_cell,
            containing: found.containing,
            hits_interior: found.hits_interior,
            failed_in: seed,
        };
    }

    /// Builds the array of a pose of a mover that keeps its shape; `false` when it is not certain.
    pub(crate) fn know_cells_at(&mut self, seed: CellId, at: &Candidate) -> bool {
        let spheres = at.spheres();
        let spheres = spheres.get(..self.path.num_sphere).unwrap_or(&spheres);
        let distance = certain_cells(self.world, seed, spheres, self.cell_array);
        self.built = BuiltArray::certain(seed, at.spheres, distance, self.cell_array);
        distance > 0.0
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
        let (begin, end) = (self.path.curr_rotation, plan.end_rotation);
        let turns = !Lanes::of_rotation(begin).all_equal(Lanes::of_rotation(end));
        if free_rotate || plan.steps == 0 {
            self.path.set_curr_rotation(end);
            self.path.set_check_to_curr();
        }
        if plan.steps == 0 {
            self.build_cell_array(false);
            return true;
        }
        // A mover that turns on the way does not keep its spheres where they were to each other.
        self.keeps_shape = free_rotate || !turns;
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
            if !free_rotate && turns {
                self.turn_on_the_way(begin, end, (i + 1) as f32 / plan.steps as f32);
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

    // Out of line, as most movers do not turn.
    #[inline(never)]
    fn turn_on_the_way(&mut self, begin: Quat, end: Quat, t: f32) {
        self.path.set_check_rotation(interpolate_rotation(begin, end, t));
    }
}

/// The resident cell with this id.
#[inline]
pub(crate) fn cell_ref(world: &World, id: CellId) -> Option<CellRef<'_>> {
    let block = world.block(id.block())?;
    if id.is_indoor() {
        let cell = block.env_cell(id)?;
        Some(CellRef::Env { cell, block })
    } else {
        let cell = block.land_cell(id)?;
        Some(CellRef::Land { id, cell, block })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(l: f32, r: f32, viewer: bool) -> StepPlan {
        calc_num_steps(Vec3::new(0.0, l, 0.0), r, viewer, Quat::IDENTITY)
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
