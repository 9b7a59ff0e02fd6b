//! The moving spheres: last accepted pose, candidate pose and sub-modes (retail `SPHEREPATH`,
//! `transition.md` 2.2).

use glam::Vec3;
use vestibule_world::ids::block_offset;
use vestibule_world::{CellId, EnvCell, Face, Frame, LandCell, Landblock, PhysicsBsp, Position, Sphere};

use crate::math::UP;
use crate::transition::InsertType;

/// A resident cell.
#[derive(Clone, Copy, Debug)]
pub(crate) enum CellRef<'w> {
    Env(&'w EnvCell),
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
            CellRef::Env(cell) => cell.id,
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

#[derive(Clone, Debug)]
pub(crate) struct SpherePath<'w> {
    pub(crate) num_sphere: usize,
    pub(crate) local_sphere: [Sphere; 2],
    pub(crate) local_low_point: Vec3,
    pub(crate) global_sphere: [Sphere; 2],
    pub(crate) global_low_point: Vec3,
    pub(crate) localspace_sphere: [Sphere; 2],
    pub(crate) localspace_curr_center: [Vec3; 2],
    pub(crate) localspace: LocalSpace<'w>,
    pub(crate) localspace_z: Vec3,
    pub(crate) begin_pos: Option<Position>,
    pub(crate) end_pos: Position,
    pub(crate) curr_cell: Option<CellRef<'w>>,
    pub(crate) curr_pos: Position,
    pub(crate) global_curr_center: [Vec3; 2],
    pub(crate) check_cell: Option<CellRef<'w>>,
    pub(crate) check_pos: Position,
    pub(crate) insert_type: InsertType,
    pub(crate) step_down: bool,
    pub(crate) step_up: bool,
    pub(crate) collide: bool,
    pub(crate) hits_interior_cell: bool,
    pub(crate) bldg_check: bool,
    pub(crate) obstruction_ethereal: bool,
    pub(crate) backup_cell: Option<CellRef<'w>>,
    pub(crate) backup_check_pos: Position,
    pub(crate) step_up_normal: Vec3,
    pub(crate) walkable_allowance: f32,
    pub(crate) walk_interp: f32,
    pub(crate) step_down_amt: f32,
    pub(crate) walkable: Option<Walkable<'w>>,
    pub(crate) check_walkable: bool,
    pub(crate) cell_array_valid: bool,
    pub(crate) neg_poly_hit: Option<NegPolyHit>,
    pub(crate) placement_allows_sliding: bool,
}

impl<'w> SpherePath<'w> {
    /// A path for a mover of one or two spheres, ready to go from `begin` (or to be placed, without one) at
    /// `end` (retail `init_sphere` and `init_path`).
    pub(crate) fn new(
        spheres: &[Sphere],
        cell: Option<CellRef<'w>>,
        begin: Option<Position>,
        end: Position,
    ) -> Self {
        let mut local_sphere = [Sphere::default(); 2];
        let num_sphere = spheres.len().min(2);
        for (slot, sphere) in local_sphere.iter_mut().zip(spheres) {
            *slot = *sphere;
        }
        let foot = local_sphere[0];
        let local_low_point = Vec3::new(foot.center.x, foot.center.y, foot.center.z - foot.radius);
        let curr_pos = begin.unwrap_or(end);
        let insert_type = if begin.is_some() {
            InsertType::Transition
        } else {
            InsertType::Placement
        };
        let space = LocalSpace {
            cell: CellId::NONE,
            frame: &Frame::IDENTITY,
            scale: 1.0,
        };
        let mut path = SpherePath {
            num_sphere,
            local_sphere,
            local_low_point,
            global_sphere: local_sphere,
            global_low_point: Vec3::ZERO,
            localspace_sphere: local_sphere,
            localspace_curr_center: [Vec3::ZERO; 2],
            localspace: space,
            localspace_z: UP,
            begin_pos: begin,
            end_pos: end,
            curr_cell: cell,
            curr_pos,
            global_curr_center: [Vec3::ZERO; 2],
            check_cell: None,
            check_pos: curr_pos,
            insert_type,
            step_down: false,
            step_up: false,
            collide: false,
            hits_interior_cell: false,
            bldg_check: false,
            obstruction_ethereal: false,
            backup_cell: None,
            backup_check_pos: curr_pos,
            step_up_normal: Vec3::ZERO,
            walkable_allowance: 0.0,
            walk_interp: 0.0,
            step_down_amt: 0.0,
            walkable: None,
            check_walkable: false,
            cell_array_valid: false,
            neg_poly_hit: None,
            placement_allows_sliding: true,
        };
        path.cache_global_curr_center();
        path
    }

    /// Recomputes the sphere centres at `curr_pos`.
    #[inline]
    pub(crate) fn cache_global_curr_center(&mut self) {
        for i in 0..2 {
            self.global_curr_center[i] = self.curr_pos.frame.local_to_global(self.local_sphere[i].center);
        }
    }

    /// Recomputes the spheres at `check_pos`.
    #[inline]
    fn cache_global_sphere(&mut self) {
        for i in 0..2 {
            self.global_sphere[i].center = self.check_pos.frame.local_to_global(self.local_sphere[i].center);
            self.global_sphere[i].radius = self.local_sphere[i].radius;
        }
        self.global_low_point = self.check_pos.frame.local_to_global(self.local_low_point);
    }

    #[inline]
    pub(crate) fn set_check_pos(&mut self, pos: &Position, cell: Option<CellRef<'w>>) {
        self.check_pos = *pos;
        self.check_cell = cell;
        self.cell_array_valid = false;
        self.cache_global_sphere();
    }

    /// Puts the candidate back to the accepted pose.
    #[inline]
    pub(crate) fn set_check_to_curr(&mut self) {
        let pos = self.curr_pos;
        self.set_check_pos(&pos, self.curr_cell);
    }

    #[inline]
    pub(crate) fn add_offset_to_check_pos(&mut self, v: Vec3) {
        self.cell_array_valid = false;
        self.shift_check(v);
    }

    #[inline]
    fn shift_check(&mut self, v: Vec3) {
        self.check_pos.frame.origin += v;
        self.global_sphere[0].center += v;
        self.global_sphere[1].center += v;
        self.global_low_point += v;
    }

    /// Names the candidate's cell, re-basing the candidate to the cell's landblock when the cell is outdoors.
    #[inline]
    pub(crate) fn adjust_check_pos(&mut self, cell: CellId) {
        if !cell.is_indoor() && cell.block() != self.check_pos.cell.block() {
            self.shift_check(block_offset(cell.block(), self.check_pos.cell.block()));
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
        let pos = self.backup_check_pos;
        self.set_check_pos(&pos, self.backup_cell);
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
        self.block_offset_curr_check() + self.global_sphere[0].center - self.global_curr_center[0]
    }

    /// Expresses the spheres in a frame, divided by its scale (retail `cache_localspace_sphere`).
    #[inline]
    pub(crate) fn cache_localspace_sphere(&mut self, space: LocalSpace<'w>) {
        let k = 1.0 / space.scale;
        let check_offset = block_offset(space.cell.block(), self.check_pos.cell.block());
        let curr_offset = block_offset(space.cell.block(), self.curr_pos.cell.block());
        for i in 0..self.num_sphere {
            let local = self.local_sphere[i];
            let check = check_offset + self.check_pos.frame.local_to_global(local.center);
            let curr = curr_offset + self.curr_pos.frame.local_to_global(local.center);
            self.localspace_sphere[i].radius = k * local.radius;
            self.localspace_sphere[i].center = k * space.frame.global_to_local(check);
            self.localspace_curr_center[i] = k * space.frame.global_to_local(curr);
        }
        self.localspace = space;
        self.localspace_z = space.frame.global_to_local_vec(UP);
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
            up: self.localspace_z,
            space: self.localspace,
        });
    }
}
