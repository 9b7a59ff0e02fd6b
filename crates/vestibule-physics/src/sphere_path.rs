//! The moving spheres: last accepted pose, candidate pose and sub-modes (retail `SPHEREPATH`,
//! `transition.md` 2.2).

use glam::{Quat, Vec3};
use vestibule_world::ids::block_offset;
use vestibule_world::{
    CellId, EnvCell, Face, Frame, LandCell, Landblock, Lanes, PhysicsBsp, Position, Sphere,
};

use crate::candidate::{Candidate, Shape};
use crate::constants::EPSILON;
use crate::math::UP;
use crate::transition::InsertType;

/// A resident cell.
#[derive(Clone, Copy, Debug)]
pub(crate) enum CellRef<'w> {
    Env {
        cell: &'w EnvCell,
        block: &'w Landblock,
    },
    Land {
        id: CellId,
        cell: &'w LandCell,
        block: &'w Landblock,
    },
}

impl CellRef<'_> {
    #[inline]
    pub(crate) fn id(&self) -> CellId {
        match self {
            CellRef::Env { cell, .. } => cell.id,
            CellRef::Land { id, .. } => *id,
        }
    }
}

/// The frame of the geometry being tested.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalSpace<'w> {
    pub(crate) cell: CellId,
    pub(crate) frame: &'w Frame,
    pub(crate) scale: f32,
}

/// The polygon last stood on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walkable<'w> {
    pub(crate) bsp: &'w PhysicsBsp,
    pub(crate) face: &'w Face,
    /// The foot sphere when the polygon was chosen, in its space.
    pub(crate) check_pos: Sphere,
    /// Global up in its space.
    pub(crate) up: Vec3,
    pub(crate) space: LocalSpace<'w>,
}

/// An overlap with a surface that is not moved into (5.5).
#[derive(Clone, Copy, Debug)]
pub(crate) struct NegPolyHit {
    /// It was the foot sphere.
    pub(crate) step_up: bool,
    /// The negated normal of the surface.
    pub(crate) normal: Vec3,
}

/// A cell and an origin in the frame of its landblock. Rotations are kept apart: within a step they are constant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub(crate) cell: CellId,
    pub(crate) origin: Lanes,
}

impl Pose {
    #[inline(always)]
    pub(crate) fn origin(&self) -> Vec3 {
        self.origin.xyz()
    }
}

/// The local points of the mover, rotated: what to add to an origin to place them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arms {
    /// The spheres' centres, radii in the fourth lanes.
    pub(crate) center: [Lanes; 2],
    pub(crate) low: Lanes,
}

impl Arms {
    #[inline(always)]
    pub(crate) fn of(frame: &Frame, spheres: &[Sphere; 2]) -> Self {
        let [foot, head] = spheres.map(Lanes::from);
        let low = foot.with_fourth(0.0) - Lanes::from(Vec3::new(0.0, 0.0, spheres[0].radius));
        if Lanes::of_rotation(frame.rotation()).all_equal(Lanes::of_rotation(Quat::IDENTITY)) {
            return Arms {
                center: [foot, head],
                low,
            };
        }
        let rotated = |s: Lanes| frame.turned_out(s).with_fourth(s.fourth());
        Arms {
            center: [rotated(foot), rotated(head)],
            low: frame.turned_out(low),
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct SpherePath<'w> {
    pub(crate) num_sphere: usize,
    pub(crate) local_sphere: [Sphere; 2],
    /// Centres, radii in the fourth lanes.
    pub(crate) global_sphere: [Lanes; 2],
    pub(crate) global_low_point: Lanes,
    /// The foot sphere in the space of the geometry being tested, its radius in the fourth lane.
    pub(crate) localspace_foot: Lanes,
    pub(crate) localspace: LocalSpace<'w>,
    pub(crate) localspace_z: Lanes,
    /// The candidate that `localspace_foot` was worked out for.
    localspace_key: Pose,
    /// The sweep has a begin position, and it is indoors.
    pub(crate) began_indoors: bool,
    pub(crate) curr_cell: Option<CellRef<'w>>,
    pub(crate) curr_pos: Pose,
    pub(crate) curr_rotation: Quat,
    /// The spheres of the accepted pose.
    global_curr_sphere: [Lanes; 2],
    pub(crate) check_cell: Option<CellRef<'w>>,
    pub(crate) check_pos: Pose,
    pub(crate) check_rotation: Quat,
    curr_arms: Arms,
    check_arms: Arms,
    pub(crate) insert_type: InsertType,
    pub(crate) step_down: bool,
    pub(crate) step_up: bool,
    pub(crate) collide: bool,
    pub(crate) hits_interior_cell: bool,
    pub(crate) bldg_check: bool,
    pub(crate) obstruction_ethereal: bool,
    backup_cell: Option<CellRef<'w>>,
    backup_check_pos: Pose,
    pub(crate) step_up_normal: Vec3,
    pub(crate) walkable_allowance: f32,
    pub(crate) walk_interp: f32,
    pub(crate) step_down_amt: f32,
    pub(crate) walkable: Option<Walkable<'w>>,
    pub(crate) check_walkable: bool,
    pub(crate) neg_poly_hit: Option<NegPolyHit>,
    pub(crate) placement_allows_sliding: bool,
}

/// No candidate: not equal to any.
const NO_KEY: Pose = Pose {
    cell: CellId::NONE,
    origin: Lanes::splat(f32::NAN),
};

impl<'w> SpherePath<'w> {
    /// A path for a mover of one or two spheres at `at`, in `cell`, that has begun a move (or is to be placed
    /// there) (retail `init_sphere` and `init_path`).
    #[inline(always)]
    pub(crate) fn new(
        num_sphere: usize,
        local_sphere: &[Sphere; 2],
        cell: Option<CellRef<'w>>,
        at: &Position,
        insert_type: InsertType,
    ) -> Self {
        let arms = Arms::of(&at.frame, local_sphere);
        let pose = Pose {
            cell: at.cell,
            origin: at.frame.origin.into(),
        };
        let space = LocalSpace {
            cell: CellId::NONE,
            frame: &Frame::IDENTITY,
            scale: 1.0,
        };
        let began_indoors = insert_type == InsertType::Transition && at.cell.is_indoor();
        let spheres = arms.center.map(|arm| pose.origin + arm);
        SpherePath {
            num_sphere,
            local_sphere: *local_sphere,
            global_sphere: spheres,
            global_low_point: pose.origin + arms.low,
            localspace_foot: Lanes::ZERO,
            localspace: space,
            localspace_z: UP.into(),
            localspace_key: NO_KEY,
            began_indoors,
            curr_cell: cell,
            curr_pos: pose,
            curr_rotation: at.frame.rotation(),
            global_curr_sphere: spheres,
            check_cell: cell,
            check_pos: pose,
            check_rotation: at.frame.rotation(),
            curr_arms: arms,
            check_arms: arms,
            insert_type,
            step_down: false,
            step_up: false,
            collide: false,
            hits_interior_cell: false,
            bldg_check: false,
            obstruction_ethereal: false,
            backup_cell: cell,
            backup_check_pos: pose,
            step_up_normal: Vec3::ZERO,
            walkable_allowance: 0.0,
            walk_interp: 0.0,
            step_down_amt: 0.0,
            walkable: None,
            check_walkable: false,
            neg_poly_hit: None,
            placement_allows_sliding: true,
        }
    }

    /// Turns the accepted pose without moving it.
    pub(crate) fn set_curr_rotation(&mut self, rotation: Quat) {
        if rotation != self.curr_rotation {
            self.curr_rotation = rotation;
            self.curr_arms = Arms::of(&Frame::new(Vec3::ZERO, rotation), &self.local_sphere);
        }
    }

    /// Turns the candidate. Its spheres follow when it is next set (3.5.4).
    pub(crate) fn set_check_rotation(&mut self, rotation: Quat) {
        self.localspace_key = NO_KEY;
        self.check_rotation = rotation;
        self.check_arms = Arms::of(&Frame::new(Vec3::ZERO, rotation), &self.local_sphere);
    }

    /// Sets the candidate and its spheres. Its rotation stays: it is constant within a step.
    #[inline]
    pub(crate) fn set_check_pos(&mut self, pos: Pose, cell: Option<CellRef<'w>>) {
        self.check_pos = pos;
        self.check_cell = cell;
        self.global_sphere = self.check_arms.center.map(|arm| pos.origin + arm);
        self.global_low_point = pos.origin + self.check_arms.low;
    }

    /// Puts the candidate back to the accepted pose.
    #[inline]
    pub(crate) fn set_check_to_curr(&mut self) {
        if self.check_rotation != self.curr_rotation {
            self.localspace_key = NO_KEY;
            self.check_rotation = self.curr_rotation;
            self.check_arms = self.curr_arms;
        }
        self.set_check_pos(self.curr_pos, self.curr_cell);
    }

    /// The candidate becomes the accepted pose; its spheres are placed anew from it.
    #[inline]
    pub(crate) fn accept(&mut self) {
        self.curr_pos = self.check_pos;
        self.curr_cell = self.check_cell;
        self.curr_rotation = self.check_rotation;
        self.curr_arms = self.check_arms;
        self.global_curr_sphere = self.curr_arms.center.map(|arm| self.curr_pos.origin + arm);
    }

    /// Whether candidate and accepted pose are equal within epsilon (1.3.3).
    #[inline]
    pub(crate) fn is_check_at_curr(&self) -> bool {
        let close = |a: Lanes, b: Lanes| (a - b).abs().less(Lanes::splat(EPSILON)) == 0b1111;
        let (p, q) = (self.check_rotation, self.curr_rotation);
        self.check_pos.cell == self.curr_pos.cell
            && close(self.check_pos.origin, self.curr_pos.origin)
            && close(Lanes::of_rotation(p), Lanes::of_rotation(q))
    }

    #[inline]
    pub(crate) fn add_offset_to_check_pos(&mut self, v: Vec3) {
        self.shift(v.into());
    }

    /// As [`SpherePath::add_offset_to_check_pos`]; the fourth lane is zero.
    #[inline(always)]
    pub(crate) fn shift(&mut self, v: Lanes) {
        self.check_pos.origin += v;
        self.global_sphere[0] += v;
        self.global_sphere[1] += v;
        self.global_low_point += v;
    }

    /// Centre of sphere `i` of the candidate.
    #[inline(always)]
    pub(crate) fn center(&self, i: usize) -> Vec3 {
        self.global_sphere[i].xyz()
    }

    /// Centre of sphere `i` of the accepted pose.
    #[inline(always)]
    pub(crate) fn curr_center(&self, i: usize) -> Vec3 {
        self.global_curr_sphere[i].xyz()
    }

    /// The candidate's spheres.
    #[inline(always)]
    pub(crate) fn spheres(&self) -> [Sphere; 2] {
        self.global_sphere.map(Sphere::from)
    }

    /// The radius of the foot sphere, metres.
    #[inline(always)]
    pub(crate) fn foot_radius(&self) -> f32 {
        self.global_sphere[0].fourth()
    }

    /// Names the candidate's cell, re-basing the candidate to the cell's landblock when the cell is outdoors.
    #[inline]
    pub(crate) fn adjust_check_pos(&mut self, cell: CellId) {
        if !cell.is_indoor() && cell.block() != self.check_pos.cell.block() {
            self.add_offset_to_check_pos(block_offset(cell.block(), self.check_pos.cell.block()));
        }
        self.check_pos.cell = cell;
    }

    #[inline]
    pub(crate) fn save_check_pos(&mut self) {
        self.backup_cell = self.check_cell;
        self.backup_check_pos = self.check_pos;
    }

    #[inline]
    pub(crate) fn restore_check_pos(&mut self) {
        self.set_check_pos(self.backup_check_pos, self.backup_cell);
    }

    #[inline]
    pub(crate) fn set_collide(&mut self, n: Vec3) {
        self.collide = true;
        self.save_check_pos();
        self.step_up_normal = n;
        self.walk_interp = 1.0;
    }

    #[inline]
    pub(crate) fn set_neg_poly_hit(&mut self, step_up: bool, n: Vec3) {
        self.neg_poly_hit = Some(NegPolyHit { step_up, normal: -n });
    }

    #[inline]
    pub(crate) fn is_walkable_allowable(&self, z: f32) -> bool {
        z > self.walkable_allowance
    }

    /// The landblock offset from the accepted to the candidate pose: what to add to candidate coordinates.
    #[inline]
    pub(crate) fn block_offset_curr_check(&self) -> Vec3 {
        block_offset(self.curr_pos.cell.block(), self.check_pos.cell.block())
    }

    /// How far sphere 0 has moved since the accepted pose.
    #[inline]
    pub(crate) fn foot_displacement(&self) -> Vec3 {
        self.block_offset_curr_check() + self.center(0) - self.curr_center(0)
    }

    /// Goes to the space of some geometry and expresses the foot sphere in it (retail
    /// `cache_localspace_sphere`). What else is needed there is worked out when it is.
    #[inline(always)]
    pub(crate) fn cache_localspace_sphere(&mut self, space: LocalSpace<'w>) {
        let (key, now) = (self.localspace_key, self.check_pos);
        let same_candidate = key.cell == now.cell && key.origin.all_equal(now.origin);
        let same_space = core::ptr::eq(self.localspace.frame, space.frame)
            && self.localspace.cell == space.cell
            && self.localspace.scale == space.scale;
        if same_space && same_candidate {
            return;
        }
        self.localspace_key = now;
        if !same_space {
            self.localspace = space;
            self.localspace_z = space.frame.up();
        }
        self.localspace_foot = self.localspace_check_sphere(0);
    }

    /// Sphere `i` of the candidate in the space of the geometry being tested, divided by its scale.
    #[inline(always)]
    fn localspace_check_sphere(&self, i: usize) -> Lanes {
        let center = self.to_localspace(self.check_pos, self.check_arms.center[i]);
        let radius = self.local_sphere[i].radius;
        let scale = self.localspace.scale;
        center.with_fourth(if scale == 1.0 {
            radius
        } else {
            1.0 / scale * radius
        })
    }

    /// The head sphere in the space of the geometry being tested.
    #[inline(always)]
    pub(crate) fn localspace_head(&self) -> Lanes {
        self.localspace_check_sphere(1)
    }

    /// The foot sphere's centre at the accepted pose, in the space of the geometry being tested.
    #[inline(always)]
    pub(crate) fn localspace_curr_foot(&self) -> Vec3 {
        self.to_localspace(self.curr_pos, self.curr_arms.center[0]).xyz()
    }

    #[inline(always)]
    fn to_localspace(&self, pose: Pose, arm: Lanes) -> Lanes {
        let space = &self.localspace;
        if pose.cell.block() != space.cell.block() || space.scale != 1.0 {
            return self.to_other_localspace(pose, arm);
        }
        space
            .frame
            .turned_in(pose.origin + arm - Lanes::from(space.frame.origin))
    }

    /// The rarer case: of another landblock, or scaled.
    #[inline(never)]
    fn to_other_localspace(&self, pose: Pose, arm: Lanes) -> Lanes {
        let space = &self.localspace;
        let p = block_offset(space.cell.block(), pose.cell.block()) + (pose.origin + arm).xyz();
        let local = Lanes::from(space.frame.global_to_local(p));
        if space.scale == 1.0 {
            local
        } else {
            local * (1.0 / space.scale)
        }
    }

    /// The candidate by itself.
    #[inline]
    pub(crate) fn candidate(&self) -> Candidate {
        Candidate {
            origin: self.check_pos.origin,
            spheres: self.global_sphere,
        }
    }

    /// The candidate's spheres, as it is turned.
    #[inline]
    pub(crate) fn shape(&self) -> Shape {
        Shape {
            arms: self.check_arms.center,
            two: self.num_sphere > 1,
        }
    }

    /// A direction of the geometry being tested, global.
    #[inline]
    pub(crate) fn localspace_vec_to_global(&self, v: Vec3) -> Vec3 {
        self.localspace.frame.local_to_global_vec(v)
    }

    #[inline]
    pub(crate) fn set_walkable(&mut self, sphere: Sphere, bsp: &'w PhysicsBsp, face: &'w Face) {
        self.walkable = Some(Walkable {
            bsp,
            face,
            check_pos: sphere,
            up: self.localspace_z.xyz(),
            space: self.localspace,
        });
    }
}
