//! Boxes of empty space in a set of polygons, worked out when a record is compiled.

use glam::Vec3;

use crate::geometry::BoundingBox;

/// A polygon counts as outside a box when it is no farther inside than this, metres.
const TOUCH: f32 = 1e-6;
/// How far an open box reaches beyond all polygons, metres.
const BEYOND: f32 = 4.0;
/// Beyond this, f32 is too coarse for the tolerance of sphere tests, metres.
const MAX_COORDINATE: f32 = 64.0;

/// A large axis-aligned box that no polygon enters, given the boxes of the polygons. `None` when there is none
/// worth having.
pub(crate) fn open_box(polygons: &[BoundingBox]) -> Option<BoundingBox> {
    let mut all = *polygons.first()?;
    for b in polygons {
        all.grow(b.min);
        all.grow(b.max);
    }
    if !(all.min.abs().max_element() < MAX_COORDINATE && all.max.abs().max_element() < MAX_COORDINATE) {
        return None;
    }
    let mut best: Option<BoundingBox> = None;
    for x in [0.5, 0.3, 0.7] {
        for y in [0.5, 0.3, 0.7] {
            for z in [0.5, 0.25, 0.75] {
                let seed = all.min + (all.max - all.min) * Vec3::new(x, y, z);
                let found = grown_around(seed, &all, polygons);
                if volume(&found, &all) > best.map_or(0.0, |b| volume(&b, &all)) {
                    best = Some(found);
                }
            }
        }
    }
    best
}

/// Volume of the part of a box that lies in `all`; none when it is thinner than a body.
fn volume(b: &BoundingBox, all: &BoundingBox) -> f32 {
    let size = b.max.min(all.max) - b.min.max(all.min);
    if size.min_element() > 0.5 {
        size.x * size.y * size.z
    } else {
        0.0
    }
}

/// Starts from everything and cuts away, for each polygon inside, the side that leaves most.
fn grown_around(seed: Vec3, all: &BoundingBox, polygons: &[BoundingBox]) -> BoundingBox {
    let mut found = BoundingBox {
        min: all.min - Vec3::splat(BEYOND),
        max: all.max + Vec3::splat(BEYOND),
    };
    for p in polygons {
        let outside = (0..3).any(|k| p.max[k] <= found.min[k] + TOUCH || p.min[k] >= found.max[k] - TOUCH);
        if outside {
            continue;
        }
        let mut choice = found;
        let mut most = -1.0;
        for k in 0..3 {
            let mut below = found;
            below.max[k] = p.min[k];
            let mut above = found;
            above.min[k] = p.max[k];
            for cut in [below, above] {
                let keeps_seed = cut.min[k] <= seed[k] && seed[k] <= cut.max[k];
                let left = volume(&cut, all);
                if keeps_seed && left > most {
                    (choice, most) = (cut, left);
                }
            }
        }
        if most < 0.0 {
            return BoundingBox { min: seed, max: seed };
        }
        found = choice;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slab(min: [f32; 3], max: [f32; 3]) -> BoundingBox {
        BoundingBox {
            min: min.into(),
            max: max.into(),
        }
    }

    #[test]
    fn a_room_with_a_pillar_keeps_the_larger_part() {
        let room = [
            slab([0.0, 0.0, 0.0], [6.0, 6.0, 0.0]),
            slab([0.0, 0.0, 3.0], [6.0, 6.0, 3.0]),
            slab([0.0, 0.0, 0.0], [0.0, 6.0, 3.0]),
            slab([6.0, 0.0, 0.0], [6.0, 6.0, 3.0]),
            slab([0.0, 0.0, 0.0], [6.0, 0.0, 3.0]),
            slab([4.0, 2.0, 0.0], [5.0, 4.0, 3.0]),
        ];
        let b = open_box(&room).unwrap();
        assert_eq!((b.min.x, b.max.x, b.min.z, b.max.z), (0.0, 4.0, 0.0, 3.0));
        // Nothing closes the room to the north.
        assert_eq!((b.min.y, b.max.y), (0.0, 10.0));
    }

    #[test]
    fn no_polygons_or_far_ones_give_no_box() {
        assert_eq!(open_box(&[]), None);
        assert_eq!(open_box(&[slab([0.0; 3], [100.0, 1.0, 1.0])]), None);
    }
}
