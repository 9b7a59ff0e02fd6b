//! Planes in groups of four, so that a point is held against four at once.

use glam::Vec3;

use crate::geometry::Plane;
use crate::lanes::Lanes;

/// Planes in groups of four, the coefficients side by side: x, y, z of the normals, then d.
#[derive(Clone, Debug, PartialEq, Default)]
pub(crate) struct PlaneQuads(Box<[[Lanes; 4]]>);

impl PlaneQuads {
    /// Groups in the order of the planes. The last is filled up with planes of which every point is `far` away.
    pub(crate) fn new(planes: &[Plane], far: f32) -> Self {
        let filler = Plane {
            normal: Vec3::ZERO,
            d: far,
        };
        let quads = planes.chunks(4).map(|chunk| {
            let at = |i: usize| chunk.get(i).copied().unwrap_or(filler);
            Lanes::side_by_side([at(0), at(1), at(2), at(3)])
        });
        PlaneQuads(quads.collect())
    }

    /// The groups: see [`Lanes::four_distances`].
    #[inline(always)]
    pub(crate) fn quads(&self) -> &[[Lanes; 4]] {
        &self.0
    }

    /// The least distance of a point from a plane; infinite without planes.
    #[inline(always)]
    pub(crate) fn least_distance(&self, p: Lanes) -> f32 {
        let mut least = Lanes::splat(f32::INFINITY);
        for quad in &self.0 {
            least = Lanes::four_distances(quad, p).lesser(least);
        }
        least.least()
    }

    /// Memory behind it, bytes.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&*self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_of_five_distances() {
        let plane = |d| Plane { normal: Vec3::X, d };
        let quads = PlaneQuads::new(
            &[plane(4.0), plane(3.0), plane(9.0), plane(7.0), plane(5.0)],
            f32::INFINITY,
        );
        assert_eq!(quads.quads().len(), 2);
        assert_eq!(quads.least_distance(Vec3::new(0.5, 8.0, 9.0).into()), 3.5);
        assert_eq!(PlaneQuads::default().least_distance(Lanes::ZERO), f32::INFINITY);
    }
}
