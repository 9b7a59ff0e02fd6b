//! Bounding spheres.

use glam::DVec3;
use vestibule_dat::primitive::Sphere;

/// A sphere around some points: about the middle of their box, a hair larger than needed so that rounding never
/// leaves a point out. Zero for no points.
pub fn bounding_sphere(points: impl Iterator<Item = DVec3> + Clone) -> Sphere {
    let (low, high) = points
        .clone()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
    if low.x > high.x {
        return Sphere::default();
    }
    let center = ((low + high) * 0.5).as_vec3();
    let reach = points.map(|p| p.distance(center.as_dvec3())).fold(0.0, f64::max);
    Sphere {
        center,
        radius: (reach * 1.000_001 + 1.0e-5) as f32,
    }
}
