//! Objects made of upright cylinders (`transition.md` 8.4).

use glam::Vec3;
use vestibule_world::{CylSphere, Frame, Plane, Sphere};

use crate::constants::{EPSILON, SHAPE_INTERP_LIMIT};
use crate::flags::ObjectState;
use crate::math::{UP, normalised};
use crate::transition::{InsertType, Transition, TransitionState};

/// The tests of one mover against one cylinder share these.
#[derive(Clone, Copy)]
struct Cylinder {
    low: Vec3,
    height: f32,
    /// Radius of the cylinder and the foot sphere together, less epsilon.
    sum: f32,
}

/// Whether a mover with these spheres, `count` of them, overlaps a cylinder given in their frame (8.4): without that
/// nothing happens.
pub(crate) fn overlaps_cylinder(target: &CylSphere, spheres: &[Sphere; 2], count: usize) -> bool {
    let (_, [foot, head]) = Cylinder::of(target, spheres).overlapped_by(spheres, count);
    foot || head
}

impl Cylinder {
    #[inline]
    fn of(target: &CylSphere, spheres: &[Sphere; 2]) -> Self {
        Cylinder {
            low: target.low_point,
            height: target.height,
            sum: target.radius + spheres[0].radius - EPSILON,
        }
    }

    /// Where the spheres are relative to the low point, and which of them overlap.
    #[inline]
    fn overlapped_by(&self, spheres: &[Sphere; 2], count: usize) -> ([Vec3; 2], [bool; 2]) {
        let disp = [spheres[0].center - self.low, spheres[1].center - self.low];
        let foot = self.overlaps(spheres[0].radius, disp[0]);
        let head = count > 1 && self.overlaps(spheres[1].radius, disp[1]);
        (disp, [foot, head])
    }

    /// Whether a sphere of this radius overlaps, given its centre relative to the low point.
    #[inline]
    fn overlaps(&self, radius: f32, disp: Vec3) -> bool {
        self.sum * self.sum >= disp.x * disp.x + disp.y * disp.y && self.beside(radius, disp.z)
    }

    /// Whether a sphere of this radius at this height is beside the cylinder, not above or below it.
    #[inline]
    fn beside(&self, radius: f32, z: f32) -> bool {
        let half = self.height / 2.0;
        radius - EPSILON + half >= (half - z).abs()
    }

    /// The side of the cylinder that a sphere came from (8.4.6), and whether that is certain. `before` and `now`
    /// are its centres relative to the low point.
    fn normal_of_collision(&self, radius: f32, before: Vec3, now: Vec3) -> (Vec3, bool) {
        if self.sum * self.sum < before.x * before.x + before.y * before.y {
            let definite = self.beside(radius, before.z) || (before.z - now.z).abs() <= EPSILON;
            return (Vec3::new(before.x, before.y, 0.0), definite);
        }
        (if now.z - before.z <= 0.0 { UP } else { -UP }, true)
    }
}

impl Transition<'_, '_> {
    /// A cylinder of an object, its low point in the frame of the candidate's landblock. `frame` is the
    /// object's own.
    pub(crate) fn intersects_cylsphere(&mut self, target: &CylSphere, frame: &Frame) -> TransitionState {
        let path = &self.path;
        let spheres = path.spheres();
        let cylinder = Cylinder::of(target, &spheres);
        let (disp, [foot, head]) = cylinder.overlapped_by(&spheres, path.num_sphere);
        let overlap = foot || head;
        let placing = path.insert_type == InsertType::Placement || path.obstruction_ethereal;
        if !overlap {
            return TransitionState::Ok;
        }
        if placing {
            return TransitionState::Collided;
        }
        if path.step_down {
            return self.step_down_onto_cylinder(&cylinder, disp[0]);
        }
        if path.check_walkable {
            return TransitionState::Collided;
        }
        if path.collide {
            return self.rewind_onto_cylinder(&cylinder, disp[0]);
        }
        if self.object.is(ObjectState::CONTACT | ObjectState::ON_WALKABLE) {
            return if foot {
                self.step_up_cylinder(&cylinder, disp[0], frame)
            } else {
                self.slide_along_cylinder(&cylinder, 1, disp[1])
            };
        }
        if self.object.is(ObjectState::PATH_CLIPPED) {
            return if foot {
                self.collide_with_cylinder(&cylinder, 0, disp[0])
            } else {
                TransitionState::Ok
            };
        }
        if foot {
            let (n, _) = self.cylinder_normal(&cylinder, 0, disp[0]);
            return self.land_on(n);
        }
        self.collide_with_cylinder(&cylinder, 1, disp[1])
    }

    fn cylinder_normal(&self, cylinder: &Cylinder, i: usize, disp: Vec3) -> (Vec3, bool) {
        let before = self.curr_center_for_objects(i) - cylinder.low;
        cylinder.normal_of_collision(self.path.global_sphere[i].fourth(), before, disp)
    }

    /// 8.4.5.
    fn step_up_cylinder(&mut self, cylinder: &Cylinder, disp: Vec3, frame: &Frame) -> TransitionState {
        if self.object.step_up_height < self.path.foot_radius() + cylinder.height - disp.z {
            return self.slide_along_cylinder(cylinder, 0, disp);
        }
        let (n, _) = self.cylinder_normal(cylinder, 0, disp);
        let Some(mut n) = normalised(n) else {
            return TransitionState::Collided;
        };
        if self.settings.rotated_cylinder_step_up {
            n = frame.local_to_global_vec(n);
        }
        if self.step_up(n) {
            TransitionState::Ok
        } else {
            self.step_up_slide()
        }
    }

    /// 8.4.6.
    fn slide_along_cylinder(&mut self, cylinder: &Cylinder, i: usize, disp: Vec3) -> TransitionState {
        let (n, _) = self.cylinder_normal(cylinder, i, disp);
        match normalised(n) {
            Some(n) => self.slide_sphere(i, n),
            None => TransitionState::Collided,
        }
    }

    /// 8.4.7.
    fn step_down_onto_cylinder(&mut self, cylinder: &Cylinder, disp: Vec3) -> TransitionState {
        let interp = self.path.walk_interp;
        let v = self.path.step_down_amt * interp;
        if v.abs() < EPSILON {
            return TransitionState::Collided;
        }
        let foot = Sphere::from(self.path.global_sphere[0]);
        let f = cylinder.height + foot.radius - disp.z;
        let w = (1.0 - f / v) * interp;
        if w >= interp || w < SHAPE_INTERP_LIMIT {
            return TransitionState::Collided;
        }
        let top = Vec3::new(foot.center.x, foot.center.y, foot.center.z + f - foot.radius);
        self.rest_on_object(Plane::through(UP, top), w, Vec3::new(0.0, 0.0, f))
    }

    /// 8.4.8.
    fn rewind_onto_cylinder(&mut self, cylinder: &Cylinder, disp: Vec3) -> TransitionState {
        let foot = Sphere::from(self.path.global_sphere[0]);
        let m = -self.path.foot_displacement();
        if m.z.abs() < EPSILON {
            return TransitionState::Collided;
        }
        let t = (cylinder.height + foot.radius - disp.z) / m.z;
        let o = t * m;
        let (x, y) = (o.x + disp.x, o.y + disp.y);
        if cylinder.sum * cylinder.sum < x * x + y * y {
            return TransitionState::Ok;
        }
        let interp = self.path.walk_interp;
        let w = (1.0 - t) * interp;
        if w >= interp || w < SHAPE_INTERP_LIMIT {
            return TransitionState::Collided;
        }
        let top = foot.center + o - Vec3::new(0.0, 0.0, foot.radius);
        self.rest_on_object(Plane::through(UP, top), w, o)
    }

    /// 8.4.9.
    fn collide_with_cylinder(&mut self, cylinder: &Cylinder, i: usize, disp: Vec3) -> TransitionState {
        let (n, definite) = self.cylinder_normal(cylinder, i, disp);
        let Some(unit) = normalised(n) else {
            return TransitionState::Collided;
        };
        if !self.object.is(ObjectState::PERFECT_CLIP) {
            self.info.set_collision_normal(unit);
            return TransitionState::Collided;
        }
        let sphere = Sphere::from(self.path.global_sphere[i]);
        // Always the foot sphere's accepted centre.
        let curr = self.curr_center_for_objects(0);
        let m = self.path.block_offset_curr_check() + sphere.center - self.path.curr_center(0);
        let d = curr - cylinder.low;
        let r = cylinder.sum + EPSILON;
        let a = m.x * m.x + m.y * m.y;
        let b = -(m.x * d.x + m.y * d.y);
        let delta = b * b - (d.x * d.x + d.y * d.y - r * r) * a;
        let side_time = || {
            let root = delta.sqrt();
            if b - root < 0.0 {
                (root + b) / a
            } else {
                (b - root) / a
            }
        };
        let cap_time = || {
            if m.z > 0.0 {
                -((d.z + sphere.radius) / m.z)
            } else {
                (sphere.radius + cylinder.height - d.z) / m.z
            }
        };
        let side_normal = |t: f32| {
            let p = curr + m * t - cylinder.low;
            Vec3::new(p.x, p.y, 0.0) / r
        };
        let (t, n) = if !definite {
            if m.z.abs() < EPSILON {
                return TransitionState::Collided;
            }
            let mut t = cap_time();
            let mut n = if m.z > 0.0 { -UP } else { UP };
            let p = d + m * t;
            if p.x * p.x + p.y * p.y >= r * r {
                if a < EPSILON {
                    return TransitionState::Collided;
                }
                if delta >= 0.0 && a > EPSILON {
                    t = side_time();
                }
                n = side_normal(t);
            }
            (t, n)
        } else if n.z != 0.0 {
            if m.z.abs() < EPSILON {
                return TransitionState::Collided;
            }
            (cap_time(), n)
        } else {
            if delta < 0.0 || a < EPSILON {
                return TransitionState::Collided;
            }
            let t = side_time();
            (t, side_normal(t))
        };
        if !(0.0..=1.0).contains(&t) {
            return TransitionState::Collided;
        }
        let offset = curr + m * t - sphere.center;
        self.info.set_collision_normal(n);
        self.path.add_offset_to_check_pos(offset);
        TransitionState::Adjusted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POST: Cylinder = Cylinder {
        low: Vec3::ZERO,
        height: 2.0,
        sum: 0.9798,
    };

    #[test]
    fn w50_normals_of_collision() {
        let normal = |before: Vec3, now: Vec3| POST.normal_of_collision(0.48, before, now);
        let (n, definite) = normal(Vec3::new(1.2, 0.0, 0.5), Vec3::new(0.9, 0.0, 0.5));
        assert_eq!((n.normalize(), definite), (Vec3::X, true));
        let over = Vec3::new(0.3, 0.0, 2.6);
        assert_eq!(normal(over, over - 0.3 * UP), (UP, true));
        assert_eq!(normal(over, over), (UP, true));
        assert_eq!(normal(over, over + 0.3 * UP), (-UP, true));
    }

    #[test]
    fn s8_4_6_coming_from_above_and_outside_is_uncertain() {
        let before = Vec3::new(1.2, 0.0, 3.0);
        assert!(!POST.normal_of_collision(0.48, before, Vec3::new(0.9, 0.0, 2.4)).1);
        // Level movement is certain all the same.
        assert!(POST.normal_of_collision(0.48, before, Vec3::new(0.9, 0.0, 3.0)).1);
    }

    #[test]
    fn s8_4_overlap_is_a_round_flat_topped_region() {
        assert!(POST.overlaps(0.48, Vec3::new(0.9797, 0.0, 1.0)));
        assert!(!POST.overlaps(0.48, Vec3::new(0.9799, 0.0, 1.0)));
        assert!(POST.overlaps(0.48, Vec3::new(0.0, 0.0, 2.4797)));
        assert!(!POST.overlaps(0.48, Vec3::new(0.0, 0.0, 2.4799)));
        assert!(POST.overlaps(0.48, Vec3::new(0.0, 0.0, -0.4797)));
        assert!(!POST.overlaps(0.48, Vec3::new(0.0, 0.0, -0.4799)));
    }
}
