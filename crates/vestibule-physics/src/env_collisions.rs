//! Collision with the cells themselves: terrain, rooms, building shells (`transition.md` 7).

use glam::Vec3;
use vestibule_world::{Building, CellId, EnvCell, LandCell, Landblock, Plane, Sphere, Water};

use crate::constants::{EPSILON, SHAPE_INTERP_LIMIT};
use crate::flags::{ObjectKind, ObjectState};
use crate::object_info::is_walkable_z;
use crate::sphere_path::{CellRef, LocalSpace};
use crate::transition::{InsertType, Transition, TransitionState};

impl<'w> Transition<'w, '_> {
    /// The cell's own surroundings, then its building, then its objects; the first that objects decides (7.1,
    /// 7.4).
    #[inline(always)]
    pub(crate) fn find_collisions_in_cell(&mut self, cell: CellRef<'w>) -> TransitionState {
        match cell {
            CellRef::Env { cell, block } => match self.find_env_cell_collisions(cell) {
                TransitionState::Ok => self.find_obj_collisions(cell.id, block),
                ts => ts,
            },
            CellRef::Land { id, cell, block } => self.find_collisions_on_land(id, cell, block),
        }
    }

    #[inline(never)]
    fn find_collisions_on_land(
        &mut self,
        id: CellId,
        cell: &'w LandCell,
        block: &'w Landblock,
    ) -> TransitionState {
        let mut ts = self.find_land_cell_collisions(id, cell, block);
        if let (TransitionState::Ok, Some(index)) = (ts, cell.building)
            && let Some(building) = block.buildings.get(usize::from(index))
        {
            ts = self.find_building_collisions(building);
        }
        if ts == TransitionState::Ok {
            self.find_obj_collisions(id, block)
        } else {
            ts
        }
    }

    #[inline(always)]
    fn find_env_cell_collisions(&mut self, cell: &'w EnvCell) -> TransitionState {
        if let Some(object) = cell.restriction
            && !self.may_enter(cell.id, object)
        {
            return TransitionState::Collided;
        }
        self.path.obstruction_ethereal = false;
        if self.is_in_open_space(cell) {
            return TransitionState::Ok;
        }
        self.find_env_bsp_collisions(cell)
    }

    /// Whether the candidate certainly overlaps nothing of the cell, whatever is asked (6.10): the usual case.
    #[inline(always)]
    fn is_in_open_space(&self, cell: &EnvCell) -> bool {
        let path = &self.path;
        let clear = |i: usize| {
            let s = path.global_sphere[i];
            cell.hints.certainly_clear(s, s.fourth())
        };
        // Spheres that turn do so one step after the candidate (3.5.4): what collides is not where they are.
        if !self.keeps_shape || path.check_pos.cell.block() != cell.id.block() || !clear(0) {
            return false;
        }
        let placing = path.insert_type != InsertType::Transition;
        if placing && !cell.hints.open_is_hollow() {
            return false;
        }
        let foot_only = path.num_sphere < 2 || (path.step_down && !placing);
        foot_only || clear(1)
    }

    #[inline(never)]
    fn find_env_bsp_collisions(&mut self, cell: &'w EnvCell) -> TransitionState {
        let Some(bsp) = &cell.structure.physics else {
            return TransitionState::Ok;
        };
        self.path.cache_localspace_sphere(LocalSpace {
            cell: cell.id,
            frame: &cell.frame,
            scale: 1.0,
        });
        let ts = if self.path.insert_type == InsertType::InitialPlacement {
            self.placement_insert_into_bsp(bsp)
        } else {
            self.find_collisions_with_bsp(bsp)
        };
        self.note_environment(ts)
    }

    /// A mover that is not in contact has hit its surroundings.
    #[inline(always)]
    fn note_environment(&mut self, ts: TransitionState) -> TransitionState {
        if ts != TransitionState::Ok && !self.object.is(ObjectState::CONTACT) {
            self.info.collided_with_environment = true;
        }
        ts
    }

    fn find_building_collisions(&mut self, building: &'w Building) -> TransitionState {
        let (Some(part), Some(frame)) = (building.shape.parts.first(), building.part_frames.first()) else {
            return TransitionState::Ok;
        };
        self.path.bldg_check = true;
        let space = LocalSpace {
            cell: building.cell,
            frame,
            scale: part.scale.z,
        };
        let ts = match &part.model {
            Some(model) => self.find_part_collisions(model, space),
            None => TransitionState::Ok,
        };
        self.path.bldg_check = false;
        self.note_environment(ts)
    }

    fn find_land_cell_collisions(
        &mut self,
        id: CellId,
        cell: &LandCell,
        block: &Landblock,
    ) -> TransitionState {
        if let Some(object) = cell.restriction
            && !self.may_enter(id, object)
        {
            self.handle_move_restriction(id);
            return TransitionState::Collided;
        }
        let offset = self.blk(self.path.check_pos.cell, id);
        let low = self.path.global_low_point.xyz() - offset;
        let Some(polygon) = cell.find_terrain_poly(low) else {
            return TransitionState::Ok;
        };
        let on_the_ground = !self.object.is(ObjectState::IS_VIEWER) && !self.object.missile;
        if on_the_ground
            && block
                .land
                .as_ref()
                .is_some_and(|land| land.water == Water::Entirely)
        {
            return TransitionState::Collided;
        }
        let depth = if cell.water == Water::Not {
            0.0
        } else {
            cell.water_depth(low)
        };
        let foot = Sphere::new(self.path.center(0) - offset, self.path.foot_radius());
        self.validate_walkable(&foot, &polygon.plane, cell.water != Water::Not, depth, id)
    }

    /// How terrain answers the foot sphere `s`, given in the frame of the cell's landblock (7.3).
    fn validate_walkable(
        &mut self,
        s: &Sphere,
        plane: &Plane,
        is_water: bool,
        depth: f32,
        cell: CellId,
    ) -> TransitionState {
        if self.object.is(ObjectState::IS_VIEWER) {
            return self.keep_viewer_above(s, plane);
        }
        let n = plane.normal;
        let (step_down, contact) = (self.path.step_down, self.object.is(ObjectState::CONTACT));
        let gate = step_down || !self.object.is(ObjectState::ON_WALKABLE) || is_walkable_z(n.z);
        let low = Vec3::new(s.center.x, s.center.y, s.center.z - s.radius);
        let a = plane.dist(low) + depth;
        if a > EPSILON {
            return TransitionState::Ok;
        }
        let mut ts = TransitionState::Ok;
        if a >= -EPSILON {
            if gate {
                self.info.set_contact(*plane, is_water, cell);
            }
        } else {
            if self.path.check_walkable {
                return TransitionState::Collided;
            }
            let z = a / n.z;
            if gate {
                self.info.set_contact(*plane, is_water, cell);
                if step_down {
                    let interp = self.path.walk_interp;
                    let w = (1.0 + z / (self.path.step_down_amt * interp)) * interp;
                    if w >= interp || w < SHAPE_INTERP_LIMIT {
                        return TransitionState::Collided;
                    }
                    self.path.walk_interp = w;
                }
                self.path.add_offset_to_check_pos(Vec3::new(0.0, 0.0, -z));
                ts = TransitionState::Adjusted;
            }
        }
        if !contact && !step_down {
            self.info.set_collision_normal(n);
            self.info.collided_with_environment = true;
        }
        ts
    }

    /// The camera's sphere against terrain (7.3).
    fn keep_viewer_above(&mut self, s: &Sphere, plane: &Plane) -> TransitionState {
        let a = plane.dist(s.center) - s.radius;
        if a > -EPSILON {
            return TransitionState::Ok;
        }
        let m = if self.settings.retail_missing_block_offsets {
            s.center - self.path.curr_center(0)
        } else {
            self.path.foot_displacement()
        };
        let approach = m.dot(plane.normal);
        if approach.abs() < EPSILON {
            return TransitionState::Ok;
        }
        let t = a / approach;
        if (t <= 0.0 || t > 1.0) && self.path.began_indoors {
            return TransitionState::Ok;
        }
        self.path.add_offset_to_check_pos(m * -t);
        self.info.set_collision_normal(plane.normal);
        self.info.collided_with_environment = true;
        TransitionState::Adjusted
    }

    /// Whether the mover may be in a cell that `object` watches over (7.5).
    pub(crate) fn may_enter(&self, cell: CellId, object: u32) -> bool {
        !self.object.kind.has(ObjectKind::PLAYER)
            || self.object.kind.has(ObjectKind::BYPASSES_RESTRICTIONS)
            || self.population.may_enter(self.object.body, cell, object)
    }

    /// The wall around a land cell that may not be entered (`world.md` Y2).
    pub(crate) fn handle_move_restriction(&mut self, cell: CellId) {
        let low = cell.low().wrapping_sub(1);
        let half = vestibule_world::constants::SQUARE_LENGTH / 2.0;
        let center = |k: u16| f32::from(2 * k + 1) * half;
        let curr = self.path.curr_pos.origin() - self.blk(self.path.curr_pos.cell, cell);
        let (x, y) = (curr.x - center(low >> 3), curr.y - center(low & 7));
        let n = if y.abs() <= half {
            if x < -half { -Vec3::X } else { Vec3::X }
        } else if y > half {
            Vec3::Y
        } else {
            -Vec3::Y
        };
        self.info.set_collision_normal(n);
    }
}
