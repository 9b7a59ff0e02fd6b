//! Collision with a physics BSP: cell structures, building shells and object parts (`transition.md` 6.9 to
//! 6.11).

use vestibule_world::{Face, Lanes, PhysicsBsp, Plane, Sphere};

use crate::bsp_solid::{self, SolidPoly};
use crate::bsp_tree::{self, WalkableSearch};
use crate::constants::{PLACEMENT_INSERT_BUDGET, Z_FOR_LANDING};
use crate::flags::ObjectState;
use crate::polygon::adjust_to_placement_poly;
use crate::transition::{InsertType, Transition, TransitionState};

impl<'w> Transition<'w, '_> {
    /// The dispatcher (6.10). `cache_localspace_sphere` has been called for the tree's frame.
    pub(crate) fn find_collisions_with_bsp(&mut self, bsp: &'w PhysicsBsp) -> TransitionState {
        let path = &self.path;
        let two = path.num_sphere > 1;
        let foot = path.localspace_foot;
        if path.insert_type == InsertType::Placement || path.obstruction_ethereal {
            let center_check = !(path.bldg_check && path.hits_interior_cell);
            let hit = bsp_solid::sphere_intersects_solid(bsp, foot, center_check)
                || (two && bsp_solid::sphere_intersects_solid(bsp, path.localspace_head(), center_check));
            return if hit {
                TransitionState::Collided
            } else {
                TransitionState::Ok
            };
        }
        if path.check_walkable {
            let hit = bsp_tree::hits_walkable(
                bsp,
                &foot.into(),
                path.localspace_z.xyz(),
                path.walkable_allowance,
            );
            return if hit {
                TransitionState::Collided
            } else {
                TransitionState::Ok
            };
        }
        if path.step_down {
            return self.step_sphere_down(bsp);
        }
        if !path.collide && bsp.certainly_clear(foot) && (!two || self.is_head_clear(bsp)) {
            return TransitionState::Ok;
        }
        let path = &self.path;
        let movement = foot.xyz() - path.localspace_curr_foot();
        if path.collide {
            return self.rest_on_walkable(bsp, movement.into());
        }
        let mut foot_poly = None;
        let foot_hit = bsp_tree::sphere_intersects_poly(bsp, foot, movement.into(), &mut foot_poly);
        if self.object.is(ObjectState::CONTACT) {
            if let (true, Some(face)) = (foot_hit, foot_poly) {
                return self.step_sphere_up(face);
            }
            if two {
                let mut head_poly = None;
                let head_hit = bsp_tree::sphere_intersects_poly(
                    bsp,
                    self.path.localspace_head(),
                    movement.into(),
                    &mut head_poly,
                );
                match (head_hit, head_poly, foot_poly) {
                    (true, Some(face), _) => {
                        let n = self.path.localspace_vec_to_global(face.plane.normal);
                        return self.slide_foot_sphere(n);
                    }
                    (false, Some(face), _) => self.neg_poly_hit(false, face),
                    (_, None, Some(face)) => self.neg_poly_hit(true, face),
                    (_, None, None) => {}
                }
            }
            return TransitionState::Ok;
        }
        if self.object.is(ObjectState::PATH_CLIPPED) {
            return match foot_poly {
                Some(face) => self.collide_with_pt(bsp, face),
                None => TransitionState::Ok,
            };
        }
        if let Some(face) = foot_poly {
            let n = self.path.localspace_vec_to_global(face.plane.normal);
            self.path.set_collide(n);
            self.path.walkable_allowance = Z_FOR_LANDING;
            return TransitionState::Adjusted;
        }
        if two {
            let mut head_poly = None;
            let head = self.path.localspace_head();
            bsp_tree::sphere_intersects_poly(bsp, head, movement.into(), &mut head_poly);
            if let Some(face) = head_poly {
                let n = self.path.localspace_vec_to_global(face.plane.normal);
                self.info.set_collision_normal(n);
                return TransitionState::Collided;
            }
        }
        TransitionState::Ok
    }

    #[inline(always)]
    fn is_head_clear(&self, bsp: &PhysicsBsp) -> bool {
        bsp.certainly_clear(self.path.localspace_head())
    }

    fn neg_poly_hit(&mut self, step_up: bool, face: &Face) {
        let n = self.path.localspace_vec_to_global(face.plane.normal);
        self.path.set_neg_poly_hit(step_up, n);
    }

    /// Lowers the foot sphere onto what it can stand on (6.11.1).
    fn step_sphere_down(&mut self, bsp: &'w PhysicsBsp) -> TransitionState {
        self.rest_on_walkable(bsp, self.step_down_movement())
    }

    fn step_down_movement(&self) -> Lanes {
        let path = &self.path;
        let depth = -(path.step_down_amt * path.walk_interp);
        path.localspace_z * depth / path.localspace.scale
    }

    /// Whether there is anything that the foot sphere can be lowered onto.
    pub(crate) fn finds_walkable(&self, bsp: &'w PhysicsBsp) -> bool {
        self.search_walkable(bsp, self.step_down_movement())
            .found
            .is_some()
    }

    #[inline(always)]
    fn search_walkable(&self, bsp: &'w PhysicsBsp, movement: Lanes) -> WalkableSearch<'w> {
        let path = &self.path;
        let mut search = WalkableSearch {
            sphere: path.localspace_foot,
            movement,
            up: path.localspace_z,
            walkable_allowance: path.walkable_allowance,
            walk_interp: path.walk_interp,
            found: None,
        };
        if !bsp.certainly_clear(search.sphere) {
            bsp_tree::find_walkable(bsp, &mut search);
        }
        search
    }

    /// Moves the candidate back along `movement` onto the last polygon it can stand on (6.10.4, 6.11.1).
    fn rest_on_walkable(&mut self, bsp: &'w PhysicsBsp, movement: Lanes) -> TransitionState {
        let before = self.path.localspace_foot;
        let search = self.search_walkable(bsp, movement);
        let Some(face) = search.found else {
            return TransitionState::Ok;
        };
        self.path.walk_interp = search.walk_interp;
        let scale = self.path.localspace.scale;
        let rested = Sphere::from(search.sphere);
        let moved = rested.center - before.xyz();
        let offset = self.path.localspace_vec_to_global(moved) * scale;
        let plane = self.contact_plane_of(bsp, face);
        self.path.add_offset_to_check_pos(offset);
        let cell = self.path.check_pos.cell;
        self.info.set_contact(plane, false, cell);
        self.path.set_walkable(rested, bsp, face);
        TransitionState::Adjusted
    }

    /// The plane of a polygon of the geometry being tested, in the frame of the candidate's landblock (1.5.9).
    fn contact_plane_of(&self, bsp: &PhysicsBsp, face: &Face) -> Plane {
        let path = &self.path;
        let space = path.localspace;
        let normal = path.localspace_vec_to_global(face.plane.normal);
        let offset = self.blk(path.check_pos.cell, space.cell);
        let to_global = |p| offset + space.frame.local_to_global(p);
        let from_vertex = space.scale != 1.0 && !self.settings.retail_scale_quirk;
        if let (true, Some(edge)) = (from_vertex, bsp.edges(face).first()) {
            let point = to_global(edge.start * space.scale);
            return Plane {
                normal,
                d: -normal.dot(point),
            };
        }
        let point = to_global(face.plane.normal * -face.plane.d);
        Plane {
            normal,
            d: -normal.dot(point) * space.scale,
        }
    }

    /// Steps up onto what was hit, or slides along it (6.11.2).
    fn step_sphere_up(&mut self, face: &Face) -> TransitionState {
        let n = self.path.localspace_vec_to_global(face.plane.normal);
        if self.step_up(n) {
            TransitionState::Ok
        } else {
            self.step_up_slide()
        }
    }

    /// A path-clipped mover hit a polygon (6.11.4).
    fn collide_with_pt(&mut self, bsp: &PhysicsBsp, face: &Face) -> TransitionState {
        let n = self.path.localspace_vec_to_global(face.plane.normal);
        if !self.object.is(ObjectState::PERFECT_CLIP) {
            self.info.set_collision_normal(n);
            return TransitionState::Collided;
        }
        let sphere = Sphere::from(self.path.localspace_foot);
        let curr = self.path.localspace_curr_foot();
        let Some(center) = bsp_tree::adjust_to_plane(bsp, &sphere, curr, face) else {
            return TransitionState::Collided;
        };
        self.info.set_collision_normal(n);
        let scale = self.path.localspace.scale;
        let offset = self.path.localspace_vec_to_global(center - sphere.center) * scale;
        self.path.add_offset_to_check_pos(offset);
        TransitionState::Adjusted
    }

    /// Moves a mover that is being placed out of what is solid (6.9).
    pub(crate) fn placement_insert_into_bsp(&mut self, bsp: &'w PhysicsBsp) -> TransitionState {
        let path = &self.path;
        let two = path.num_sphere > 1;
        let check_center = !(path.bldg_check && path.hits_interior_cell);
        let mut foot = Sphere::from(path.localspace_foot);
        let start = foot.center;
        let mut head = if two { path.localspace_head().into() } else { foot };
        let mut radius = foot.radius;
        let mut found = SolidPoly::default();
        for round in 0..PLACEMENT_INSERT_BUDGET {
            found.center_solid = false;
            let solid = |s: &Sphere, found: &mut SolidPoly<'w>| {
                bsp_solid::sphere_intersects_solid_poly(bsp, s, radius, found, check_center)
            };
            let struck = if solid(&foot, &mut found) {
                foot
            } else if two && solid(&head, &mut found) {
                head
            } else if round == 0 {
                return TransitionState::Ok;
            } else {
                let offset = self.path.localspace_vec_to_global(foot.center - start);
                self.path.add_offset_to_check_pos(offset);
                return TransitionState::Adjusted;
            };
            match found.hit.take() {
                Some(face) => {
                    let shift = adjust_to_placement_poly(
                        &face.plane,
                        &struck,
                        radius,
                        found.center_solid,
                        check_center,
                    );
                    foot.center += face.plane.normal * shift;
                    head.center += face.plane.normal * shift;
                    radius = foot.radius;
                }
                None => radius *= 2.0,
            }
        }
        TransitionState::Collided
    }
}
