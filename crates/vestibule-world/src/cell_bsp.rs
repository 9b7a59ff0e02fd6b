//! Cell BSPs: "is this inside the cell?" (`world.md` 9). A chain of planes whose positive sides are the inside.

use glam::Vec3;

use crate::constants::{CELL_BSP_SPHERE_FUDGE, EPSILON};
use crate::geometry::{Plane, Sphere};

/// How much of a sphere a cell BSP holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inside {
    /// None of it.
    Outside,
    /// Some of it, as far as the tree can tell.
    Partially,
    /// All of it.
    Entirely,
}

/// A cell BSP, flattened: only positive children are ever followed (`dat-format.md` G14), so the tree is a list
/// of planes. All coordinates are cell-local, metres.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct CellBsp {
    planes: Box<[Plane]>,
    ends_in_leaf: bool,
}

impl CellBsp {
    /// A chain of planes, inside where all are positive. `ends_in_leaf`: the last positive child is a LEAF
    /// record rather than absent, which only [`CellBsp::sphere`] can tell.
    pub fn new(planes: Vec<Plane>, ends_in_leaf: bool) -> Self {
        CellBsp {
            planes: planes.into(),
            ends_in_leaf,
        }
    }

    /// The planes, from the root down.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Whether a point is inside: not farther than epsilon behind any plane (`world.md` 9.1).
    #[inline]
    pub fn contains_point(&self, p: Vec3) -> bool {
        // Written so that a NaN distance counts as inside the plane, as `< -EPSILON` does.
        !self.planes.iter().any(|plane| plane.dist(p) < -EPSILON)
    }

    /// How a sphere, widened by 0.01 m, lies to the cell (`world.md` 9.2).
    #[inline]
    pub fn sphere(&self, sphere: &Sphere) -> Inside {
        let radius = sphere.radius + CELL_BSP_SPHERE_FUDGE;
        let mut straddles = self.ends_in_leaf;
        for plane in &self.planes {
            let dist = plane.dist(sphere.center);
            if dist <= -radius {
                return Inside::Outside;
            }
            // The nodes below a straddled plane can still answer Outside, never Entirely.
            straddles |= dist < radius;
        }
        if straddles {
            Inside::Partially
        } else {
            Inside::Entirely
        }
    }

    /// Whether a sphere touches the cell (`world.md` 9.2: all that callers ask).
    #[inline]
    pub fn meets_sphere(&self, sphere: &Sphere) -> bool {
        let reach = -(sphere.radius + CELL_BSP_SPHERE_FUDGE);
        !self.planes.iter().any(|plane| plane.dist(sphere.center) <= reach)
    }

    /// Whether a box, given by its corners in cell coordinates, may touch the cell (`world.md` 9.3).
    pub fn meets_box(&self, corners: &[Vec3; 8]) -> bool {
        !self
            .planes
            .iter()
            .any(|plane| corners.iter().all(|&c| plane.dist(c) < -EPSILON))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::BoundingBox;

    /// The tree of `dat-format.md` 12.17: 0 <= z <= 3.
    fn slab(ends_in_leaf: bool) -> CellBsp {
        let plane = |z: f32, d: f32| Plane {
            normal: Vec3::new(0.0, 0.0, z),
            d,
        };
        CellBsp::new(vec![plane(1.0, 0.0), plane(-1.0, 3.0)], ends_in_leaf)
    }

    #[test]
    fn example_22_25_points_and_spheres() {
        let bsp = slab(true);
        let point = |z: f32| bsp.contains_point(Vec3::new(0.0, 0.0, z));
        assert!(point(-0.0001) && !point(-0.0003) && point(3.0001));
        let sphere = |bsp: &CellBsp, z: f32| bsp.sphere(&Sphere::new(Vec3::new(0.0, 0.0, z), 0.5));
        assert_eq!(sphere(&bsp, -0.505), Inside::Partially);
        assert_eq!(sphere(&bsp, -0.51), Inside::Outside);
        assert_eq!(sphere(&bsp, -0.52), Inside::Outside);
        assert_eq!(sphere(&bsp, 1.5), Inside::Partially);
        assert_eq!(sphere(&slab(false), 1.5), Inside::Entirely);
    }

    #[test]
    fn example_22_26_boxes() {
        let meets = |lo: f32, hi: f32| {
            let b = BoundingBox {
                min: Vec3::new(-1.0, -1.0, lo),
                max: Vec3::new(1.0, 1.0, hi),
            };
            slab(true).meets_box(&b.corners())
        };
        assert!(!meets(-2.0, -0.1));
        assert!(meets(-2.0, -0.0001));
    }

    #[test]
    fn meets_sphere_is_sphere_not_outside() {
        for k in -120..420 {
            let s = Sphere::new(Vec3::new(0.0, 0.0, k as f32 * 0.01), 0.5);
            for bsp in [slab(true), slab(false)] {
                assert_eq!(bsp.meets_sphere(&s), bsp.sphere(&s) != Inside::Outside);
            }
        }
    }
}
