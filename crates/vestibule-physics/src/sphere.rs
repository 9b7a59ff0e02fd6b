//! Objects made of spheres (`transition.md` 8.3).

use glam::Vec3;
use vestibule_world::{Plane, Sphere};

use crate::constants::{EPSILON, SHAPE_INTERP_LIMIT, Z_FOR_LANDING};
use crate::flags::ObjectState;
use crate::math::{length, normalised};
use crate::transition::{InsertType, Transition, TransitionState};

/// Whether a mover with these spheres, `count` of them, overlaps a sphere given in their frame (8.3): without that
/// nothing happens.
pub(crate) fn overlaps_sphere(target: &Sphere, spheres: &[Sphere; 2], count: usize) -> bool {
    let (.., [foot, head]) = overlapped_by(target, spheres, count);
    foot || head
}

/// Where a mover's spheres are relative to a sphere, how near its foot may come, and which of them overlap.
#[inline]
fn overlapped_by(target: &Sphere, spheres: &[Sphere; 2], count: usize) -> ([Vec3; 2], f32, [bool; 2]) {
    let disp = [
        spheres[0].center - target.center,
        spheres[1].center - target.center,
    ];
    let sum = target.radius + spheres[0].radius - EPSILON;
    let foot = length(disp[0]) <= sum;
    let head = count > 1 && length(disp[1]) <= sum;
    (disp, sum, [foot, head])
}

impl Transition<'_, '_> {
    /// Centre of sphere `i` at the accepted pose, in the frame of the candidate's landblock.
    #[inline]
    pub(crate) fn curr_center_for_objects(&self, i: usize) -> Vec3 {
        let center = self.path.curr_center(i);
        if self.settings.retail_missing_block_offsets {
            center
        } else {
            center - self.path.block_offset_curr_check()
        }
    }

    /// A sphere of an object, in the frame of the candidate's landblock.
    pub(crate) fn intersects_sphere(&mut self, target: &Sphere, is_creature: bool) -> TransitionState {
        let path = &self.path;
        let (c, rho) = (target.center, target.radius);
        let (disp, sum, [foot, head]) = overlapped_by(target, &path.spheres(), path.num_sphere);
        let overlap = foot || head;
        let collided_if = |hit| {
            if hit {
                TransitionState::Collided
            } else {
                TransitionState::Ok
            }
        };
        if path.insert_type == InsertType::Placement || path.obstruction_ethereal {
            return collided_if(overlap);
        }
        if path.step_down {
            return if is_creature || !overlap {
                TransitionState::Ok
            } else {
                self.step_down_onto_sphere(c, rho, disp[0], sum + EPSILON)
            };
        }
        if path.check_walkable {
            return collided_if(overlap);
        }
        if path.collide {
            return if is_creature || !overlap {
                TransitionState::Ok
            } else {
                self.rewind_onto_sphere(disp[0], sum + EPSILON)
            };
        }
        if self.object.is(ObjectState::CONTACT | ObjectState::ON_WALKABLE) {
            if foot {
                return self.step_up_sphere(c, disp[0], sum + EPSILON);
            }
            if head {
                let Some(n) = normalised(self.curr_center_for_objects(1) - c) else {
                    return TransitionState::Collided;
                };
                return self.slide_sphere(1, n);
            }
            return TransitionState::Ok;
        }
        if self.object.is(ObjectState::PATH_CLIPPED) {
            return if foot {
                self.collide_with_sphere(0, c, sum + EPSILON)
            } else {
                TransitionState::Ok
            };
        }
        if foot {
            return self.land_on(self.curr_center_for_objects(0) - c);
        }
        if head {
            return self.collide_with_sphere(1, c, sum + EPSILON);
        }
        TransitionState::Ok
    }

    /// Begins a landing on what has the normal `n`.
    pub(crate) fn land_on(&mut self, n: Vec3) -> TransitionState {
        let Some(n) = normalised(n) else {
            return TransitionState::Collided;
        };
        self.path.set_collide(n);
        self.path.walkable_allowance = Z_FOR_LANDING;
        TransitionState::Adjusted
    }

    /// 8.3.6.
    fn step_up_sphere(&mut self, c: Vec3, disp: Vec3, r: f32) -> TransitionState {
        let n = self.curr_center_for_objects(0) - c;
        if self.object.step_up_height < r - disp.z {
            return self.slide_along_sphere(n, disp);
        }
        let n = if self.settings.unnormalised_sphere_step_up {
            n
        } else {
            normalised(n).unwrap_or(n)
        };
        if self.step_up(n) {
            TransitionState::Ok
        } else {
            self.step_up_slide()
        }
    }

    /// The slide of 8.3.6, which differs from `slide_sphere` where normals are parallel.
    fn slide_along_sphere(&mut self, n: Vec3, disp: Vec3) -> TransitionState {
        let Some(n) = normalised(n) else {
            return TransitionState::Collided;
        };
        self.info.set_collision_normal(n);
        let floor = self.slide_plane_normal();
        let g = self.path.foot_displacement();
        let crease = n.cross(floor);
        let squared = crease.dot(crease);
        if squared >= EPSILON {
            let along = crease * crease.dot(g) / squared;
            if along.dot(along) < EPSILON {
                return TransitionState::Collided;
            }
            self.path.add_offset_to_check_pos(along - g);
            return TransitionState::Slid;
        }
        if floor.dot(disp) < 0.0 {
            return TransitionState::Collided;
        }
        self.path.add_offset_to_check_pos(-n * n.dot(g));
        TransitionState::Slid
    }

    /// 8.3.7.
    fn step_down_onto_sphere(&mut self, c: Vec3, rho: f32, disp: Vec3, r: f32) -> TransitionState {
        let interp = self.path.walk_interp;
        let v = self.path.step_down_amt * interp;
        if v.abs() < EPSILON {
            return TransitionState::Collided;
        }
        let radicand = r * r - disp.x * disp.x - disp.y * disp.y;
        if radicand < 0.0 {
            return TransitionState::Ok;
        }
        let f = (radicand.sqrt() - disp.z) / v;
        let w = (1.0 - f) * interp;
        if w >= interp || w < SHAPE_INTERP_LIMIT {
            return TransitionState::Collided;
        }
        let n = Vec3::new(disp.x, disp.y, disp.z + f * v) / r;
        if !self.path.is_walkable_allowable(n.z) {
            return TransitionState::Ok;
        }
        let plane = Plane::through(n, c + n * rho);
        self.rest_on_object(plane, w, Vec3::new(0.0, 0.0, f * v))
    }

    /// 8.3.8.
    fn rewind_onto_sphere(&mut self, disp: Vec3, r: f32) -> TransitionState {
        let foot = Sphere::from(self.path.global_sphere[0]);
        let m = -self.path.foot_displacement();
        let l = m.dot(m);
        if l.abs() < EPSILON {
            return TransitionState::Collided;
        }
        let b = -m.dot(disp);
        let radicand = b * b - (disp.dot(disp) - r * r) * l;
        if radicand < 0.0 {
            return TransitionState::Ok;
        }
        let mut t = radicand.sqrt() + b;
        if t > 1.0 {
            t = 2.0 * b - t;
        }
        let f = t / l;
        let interp = self.path.walk_interp;
        let w = (1.0 - f) * interp;
        if w >= interp || w < SHAPE_INTERP_LIMIT {
            return TransitionState::Collided;
        }
        let n = (disp + f * m) / r;
        if !self.path.is_walkable_allowable(n.z) {
            return TransitionState::Ok;
        }
        let plane = Plane::through(n, foot.center - n * foot.radius);
        self.rest_on_object(plane, w, f * m)
    }

    /// The top of an object becomes the contact plane.
    pub(crate) fn rest_on_object(&mut self, plane: Plane, interp: f32, offset: Vec3) -> TransitionState {
        let cell = self.path.check_pos.cell;
        self.info
            .set_contact(plane, self.settings.object_tops_are_water, cell);
        self.path.walk_interp = interp;
        self.path.add_offset_to_check_pos(offset);
        TransitionState::Adjusted
    }

    /// 8.3.9.
    fn collide_with_sphere(&mut self, i: usize, c: Vec3, r: f32) -> TransitionState {
        let curr = self.curr_center_for_objects(i);
        let d = curr - c;
        if !self.object.is(ObjectState::PERFECT_CLIP) {
            if let Some(n) = normalised(d) {
                self.info.set_collision_normal(n);
            }
            return TransitionState::Collided;
        }
        let center = self.path.center(i);
        let m = self.path.block_offset_curr_check() + center - self.path.curr_center(i);
        let t = collision_time(m, d, r);
        if t < f64::from(EPSILON) || t > 1.0 {
            return TransitionState::Collided;
        }
        let o = m * t as f32 - m;
        self.info.set_collision_normal((o + center - c) / r);
        self.path.add_offset_to_check_pos(o);
        TransitionState::Adjusted
    }
}

/// When a point that starts `d` from the centre and moves by `m` meets a sphere of radius `r`, as a fraction of
/// the movement; -1 for never (8.3.9).
fn collision_time(m: Vec3, d: Vec3, r: f32) -> f64 {
    let wide = |a: Vec3, b: Vec3| {
        f64::from(a.x) * f64::from(b.x) + f64::from(a.y) * f64::from(b.y) + f64::from(a.z) * f64::from(b.z)
    };
    let l = wide(m, m);
    let b = -wide(d, m);
    let q = wide(d, d) - f64::from(r) * f64::from(r);
    let delta = b * b - q * l;
    if q < f64::from(EPSILON) || l < f64::from(EPSILON) || delta < 0.0 {
        return -1.0;
    }
    let root = delta.sqrt();
    if b - root < 0.0 {
        (root + b) / l
    } else {
        (b - root) / l
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn w43_time_of_contact() {
        let (m, d) = (Vec3::new(2.5, 0.0, 0.0), Vec3::new(-3.0, 0.0, 0.0));
        let t = collision_time(m, d, 0.98);
        assert!((t - 0.808).abs() < 1e-5);
        assert!(((m * t as f32 - m).x + 0.48).abs() < 1e-5);
    }

    #[test]
    fn s8_3_9_no_time_when_inside_unmoved_or_missing() {
        assert_eq!(collision_time(Vec3::X, Vec3::new(0.5, 0.0, 0.0), 0.98), -1.0);
        assert_eq!(collision_time(Vec3::ZERO, Vec3::new(3.0, 0.0, 0.0), 0.98), -1.0);
        assert_eq!(collision_time(Vec3::X, Vec3::new(-3.0, 2.0, 0.0), 0.98), -1.0);
    }
}
