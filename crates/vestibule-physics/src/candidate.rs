//! A candidate pose of the usual steps: a mover's spheres, four lanes each, and what can be said of them cheaply.

use glam::Vec3;
use vestibule_world::{CellEntry, EnvCell, Frame, Landblock, Lanes, PhysicsBsp, Sphere};

use crate::bsp_solid;
use crate::bsp_tree;

/// The spheres of a mover, as it is turned.
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    /// Where they are relative to the origin, radii in the fourth lanes.
    pub(crate) arms: [Lanes; 2],
    pub(crate) two: bool,
}

impl Shape {
    /// The radius of its larger sphere, metres.
    #[inline(always)]
    pub(crate) fn larger_radius(&self) -> f32 {
        let [foot, head] = self.arms.map(Lanes::fourth);
        if self.two && head > foot { head } else { foot }
    }

    /// How many spheres it has.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        1 + usize::from(self.two)
    }
}

/// Where a candidate is: its origin and its spheres in the frame of the landblock, radii in the fourth lanes.
#[derive(Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) origin: Lanes,
    pub(crate) spheres: [Lanes; 2],
}

impl Candidate {
    /// Spheres where the origin says (retail `set_check_pos`).
    #[inline(always)]
    pub(crate) fn at(origin: Lanes, shape: &Shape) -> Self {
        Candidate {
            origin,
            spheres: shape.arms.map(|arm| origin + arm),
        }
    }

    #[inline(always)]
    pub(crate) fn shift(&mut self, v: Lanes) {
        self.origin += v;
        self.spheres[0] += v;
        self.spheres[1] += v;
    }

    /// Whether another pose is the same to the bit.
    #[inline(always)]
    pub(crate) fn has_bits_of(&self, other: &Candidate) -> bool {
        self.origin.has_bits_of(other.origin)
            && self.spheres[0].has_bits_of(other.spheres[0])
            && self.spheres[1].has_bits_of(other.spheres[1])
    }

    /// Its spheres.
    #[inline(always)]
    pub(crate) fn spheres(&self) -> [Sphere; 2] {
        self.spheres.map(Sphere::from)
    }

    /// Sphere `i` in a local frame, as polygons see it (retail `cache_localspace_sphere`).
    #[inline(always)]
    pub(crate) fn local(&self, shape: &Shape, frame: &Frame, i: usize) -> Lanes {
        local_center(self.origin, shape, frame, i).with_fourth(shape.arms[i].fourth())
    }

    /// Whether it is less than `distance` from where its foot sphere would be at `foot`.
    #[inline(always)]
    pub(crate) fn is_within(&self, foot: Lanes, distance: f32) -> bool {
        let shift = self.spheres[0] - foot;
        shift.dot(shift) < distance * distance
    }

    /// How far it may be shifted and neither a moving nor a placement insertion finds anything of a part of a static
    /// object, metres. Zero: a moving one finds nothing where it is. Below zero: it finds something.
    pub(crate) fn distance_to_part(
        &self,
        shape: &Shape,
        frame: &Frame,
        bsp: &PhysicsBsp,
        bound: &Sphere,
    ) -> f32 {
        let local = [self.local(shape, frame, 0), self.local(shape, frame, 1)];
        if !local.iter().any(|&s| bsp_tree::spheres_overlap(bound, &s.into())) {
            // Spheres that graze each other overlap (6.1); rounding is far below that.
            const GRAZE: f32 = 0.01;
            let outside = Sphere::new(bound.center, bound.radius + GRAZE);
            let distance = local.map(|s| distance_between(outside, s));
            let [foot, head] = distance;
            let least = if head < foot { head } else { foot };
            return if least > 0.0 { least } else { 0.0 };
        }
        let [foot, head] = local.map(|s| bsp_solid::clearance(bsp, s));
        let least = if head < foot { head } else { foot };
        // The frames of parts keep lengths but for rounding.
        least * 0.99
    }

    /// Whether an insertion finds nothing of a part of a static object.
    pub(crate) fn clears_part(
        &self,
        shape: &Shape,
        frame: &Frame,
        bsp: &PhysicsBsp,
        bound: &Sphere,
        placing: bool,
    ) -> bool {
        let local = [self.local(shape, frame, 0), self.local(shape, frame, 1)];
        let local = local.get(..shape.count()).unwrap_or(&local);
        let reached = local.iter().any(|&s| bsp_tree::spheres_overlap(bound, &s.into()));
        !reached
            || local
                .iter()
                .all(|&s| !bsp_solid::sphere_intersects_solid(bsp, s, placing))
    }

    /// How far it may be shifted and neither a moving nor a placement insertion into the cell finds anything, metres.
    /// Zero: a moving one finds nothing where it is. Below zero: it finds something.
    #[inline(always)]
    pub(crate) fn clearance(&self, shape: &Shape, cell: &EnvCell) -> f32 {
        if self.is_in_the_open(shape, cell) {
            0.0
        } else {
            clearance(*shape, self.origin, cell)
        }
    }

    /// Whether the cell's box of open space holds all spheres.
    #[inline(always)]
    pub(crate) fn is_in_the_open(&self, shape: &Shape, cell: &EnvCell) -> bool {
        let clear = |i: usize| {
            cell.hints
                .certainly_clear(self.spheres[i], shape.arms[i].fourth())
        };
        clear(0) && (!shape.two || clear(1))
    }

    /// Whether the rest of a step down onto a floor finds nothing of a cell: another attempt, which asks whether the
    /// foot overlaps ground, and the placement insertion, which asks whether any sphere overlaps anything.
    #[inline(always)]
    pub(crate) fn rests_in(&self, shape: &Shape, cell: &EnvCell) -> bool {
        (cell.hints.open_is_hollow() && self.is_in_the_open(shape, cell))
            || touches_nothing_solid(*shape, self.origin, cell)
    }

    /// As [`Candidate::rests_in`] for other cells that the candidate reaches, none of which keeps anyone out.
    #[inline(always)]
    pub(crate) fn rests_beside(&self, shape: &Shape, block: &Landblock, others: &[CellEntry]) -> bool {
        for entry in others {
            let Some(other) = block.env_cell(entry.id) else {
                return false;
            };
            if other.restriction.is_some() || !self.rests_in(shape, other) {
                return false;
            }
        }
        true
    }
}

/// Centre of sphere `i` in a local frame.
#[inline(always)]
pub(crate) fn local_center(origin: Lanes, shape: &Shape, frame: &Frame, i: usize) -> Lanes {
    frame.turned_in(origin + shape.arms[i] - Lanes::from(frame.origin))
}

#[inline(always)]
fn local_sphere(origin: Lanes, shape: &Shape, frame: &Frame, i: usize) -> Lanes {
    local_center(origin, shape, frame, i).with_fourth(shape.arms[i].fourth())
}

// By value, here and below: what is behind a reference is not kept in registers.
#[inline(never)]
fn clearance(shape: Shape, origin: Lanes, cell: &EnvCell) -> f32 {
    let Some(bsp) = &cell.structure.physics else {
        return f32::INFINITY;
    };
    let clearance = |i| bsp_solid::clearance(bsp, local_sphere(origin, &shape, &cell.frame, i));
    let mut least = clearance(0);
    if shape.two && least >= 0.0 {
        let head = clearance(1);
        least = if head < least { head } else { least };
    }
    if cell.hints.keeps_lengths() || least < 0.0 {
        least * 0.99
    } else {
        0.0
    }
}

#[inline(never)]
fn touches_nothing_solid(shape: Shape, origin: Lanes, cell: &EnvCell) -> bool {
    let Some(bsp) = &cell.structure.physics else {
        return true;
    };
    let solid =
        |i| bsp_solid::sphere_intersects_solid(bsp, local_sphere(origin, &shape, &cell.frame, i), true);
    !solid(0) && (!shape.two || !solid(1))
}

/// A shift down, metres.
#[inline(always)]
pub(crate) fn down(h: f32) -> Lanes {
    Lanes::from(Vec3::new(0.0, 0.0, -h))
}

/// How far two spheres are from touching, metres.
fn distance_between(a: Sphere, b: Lanes) -> f32 {
    let between = b - Lanes::from(a);
    between.dot(between).sqrt() - (a.radius + b.fourth())
}

/// How far a candidate may be shifted before one of its spheres comes near another sphere, metres: nearer than that
/// one's radius and its own, `stretch` times.
#[inline(always)]
pub(crate) fn distance_to_sphere(around: &Sphere, stretch: f32, shape: &Shape, pose: &Candidate) -> f32 {
    let center = Lanes::from(*around);
    let squared = |s: Lanes| {
        let between = s - center;
        between.dot(between)
    };
    let mut nearest = squared(pose.spheres[0]);
    if shape.two {
        let head = squared(pose.spheres[1]);
        nearest = if head < nearest { head } else { nearest };
    }
    nearest.sqrt() - (around.radius + stretch * shape.larger_radius())
}
