//! The lamps of the cells that a walk has met, in camera axes.

use core::ops::Range;

use vestibule_world::CellId;

use crate::lighting::{Lamp, MAX_OBJECT_LAMPS, OBJECT_RANGE};
use crate::mesh::Mesh;
use crate::place::{EyeFrame, Placed};
use crate::scene::Scene;

/// Lamps of the cells met so far and where each cell's are.
#[derive(Debug, Default)]
pub(crate) struct CellLamps {
    lamps: Vec<Lamp>,
    known: Vec<(CellId, Range<usize>)>,
}

impl CellLamps {
    pub(crate) fn clear(&mut self) {
        self.lamps.clear();
        self.known.clear();
    }

    /// The lamps of a cell.
    pub(crate) fn of(&mut self, scene: &Scene<'_>, eye: &EyeFrame, id: CellId) -> &[Lamp] {
        let known = self.known.iter().rev().find(|(known, _)| *known == id);
        let range = match known {
            Some((_, range)) => range.clone(),
            None => self.add(scene, eye, id),
        };
        &self.lamps[range]
    }

    fn add(&mut self, scene: &Scene<'_>, eye: &EyeFrame, id: CellId) -> Range<usize> {
        let first = self.lamps.len();
        if let Some(cell) = scene.world.env_cell(id) {
            let placed = eye.place_block(id.block());
            let lamps = scene.assets.lamps(scene.world, cell);
            self.lamps.extend(lamps.iter().map(|l| Lamp {
                position: placed.point(l.position).as_vec3(),
                ..*l
            }));
        }
        let range = first..self.lamps.len();
        self.known.push((id, range.clone()));
        range
    }
}

/// The lamps that reach a mesh, nearest first (`rendering.md` 12.1); returns how many.
pub(crate) fn nearest(
    lamps: &[Lamp],
    mesh: &Mesh,
    placed: &Placed,
    out: &mut [u8; MAX_OBJECT_LAMPS],
) -> usize {
    let middle = placed.point(mesh.sphere.center).as_vec3();
    let mut found = [0.0f32; MAX_OBJECT_LAMPS];
    let mut count = 0;
    for (k, lamp) in lamps.iter().enumerate().take(usize::from(u8::MAX)) {
        let gap = lamp.position - middle;
        let square = gap.dot(gap);
        let reach = lamp.falloff * OBJECT_RANGE + mesh.sphere.radius;
        if !(square < reach * reach) {
            continue;
        }
        let at = found[..count]
            .iter()
            .position(|&other| square < other)
            .unwrap_or(count);
        if at == MAX_OBJECT_LAMPS {
            continue;
        }
        count = (count + 1).min(MAX_OBJECT_LAMPS);
        found[at..count].rotate_right(1);
        out[at..count].rotate_right(1);
        (found[at], out[at]) = (square, k as u8);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use vestibule_view::Camera;
    use vestibule_world::BlockId;

    #[test]
    fn r12_1_the_eight_nearest_lamps_that_reach() {
        let camera = Camera::new(
            CellId(0xA9B4_0101),
            Vec3::ZERO,
            Vec3::Y,
            Vec3::Z,
            1.0,
            glam::Vec2::splat(64.0),
        )
        .unwrap();
        let eye = EyeFrame::new(&camera);
        let placed = eye.place_block(BlockId(0xA9B4));
        let mesh = Mesh {
            sphere: vestibule_world::Sphere {
                center: Vec3::ZERO,
                radius: 1.0,
            },
            ..Mesh::default()
        };
        let lamp = |x: f32, falloff: f32| Lamp {
            position: Vec3::new(x, 0.0, 0.0),
            color: Vec3::ONE,
            intensity: 1.0,
            falloff,
        };
        let mut lamps: Vec<Lamp> = (0..10).map(|k| lamp(11.0 - k as f32, 20.0)).collect();
        lamps.push(lamp(0.5, 20.0));
        // Reaches 1.5 * 2 + 1 m.
        lamps.push(lamp(4.0, 2.0));
        let mut near = [0; MAX_OBJECT_LAMPS];
        assert_eq!(nearest(&lamps, &mesh, &placed, &mut near), 8);
        assert_eq!(near, [10, 9, 8, 7, 6, 5, 4, 3]);
        assert_eq!(
            nearest(&lamps[11..], &mesh, &placed, &mut near),
            0,
            "strictly nearer"
        );
    }
}
