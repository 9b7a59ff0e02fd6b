//! The ground of a landblock as it is drawn: corner normals and paint (`rendering.md` 11, 12.4).

use glam::Vec3;
use vestibule_world::constants::SQUARE_LENGTH;
use vestibule_world::terrain::vertex_index;
use vestibule_world::texture_code::texture_code_of;
use vestibule_world::{BlockId, World};

use crate::assets::Assets;
use crate::terrain_paint::CellPaint;

/// How much lower than it is the ground is drawn, metres (`rendering.md` 6.6).
pub const TERRAIN_OFFSET: f32 = 0.01;

/// What is drawn of a landblock's ground; the triangles themselves are the world's.
#[derive(Clone, Debug)]
pub struct LandMesh {
    /// Unit normals of the 81 vertices, x-major.
    pub normals: [Vec3; 81],
    /// Paint of the 64 land cells in order of their ids.
    pub paint: Vec<CellPaint>,
}

const AROUND: [(i32, i32); 8] = [
    (-1, -1),
    (-1, 0),
    (-1, 1),
    (0, -1),
    (0, 1),
    (1, -1),
    (1, 0),
    (1, 1),
];

/// Which of the eight landblocks around are loaded, one bit each.
pub(crate) fn loaded_neighbours(world: &World, block: BlockId) -> u16 {
    AROUND.iter().enumerate().fold(0, |bits, (k, &(dx, dy))| {
        let loaded = block
            .neighbour(dx, dy)
            .and_then(|id| world.loaded_block(id))
            .is_some();
        bits | u16::from(loaded) << k
    })
}

impl LandMesh {
    pub(crate) fn build(assets: &Assets, world: &World, id: BlockId) -> Option<Self> {
        let land = world.loaded_block(id)?.land.as_ref()?;
        let mut sums = [Vec3::ZERO; 81];
        for (dx, dy) in AROUND.into_iter().chain([(0, 0)]) {
            let block = id.neighbour(dx, dy).and_then(|n| world.loaded_block(n));
            let Some(near) = block.and_then(|b| b.land.as_ref()) else {
                continue;
            };
            for polygon in near.cells.iter().flat_map(|c| &c.polygons) {
                for v in polygon.vertices {
                    let i = libm::roundf(v.x / SQUARE_LENGTH) as i32 + 8 * dx;
                    let j = libm::roundf(v.y / SQUARE_LENGTH) as i32 + 8 * dy;
                    if (0..=8).contains(&i) && (0..=8).contains(&j) {
                        sums[vertex_index(i as usize, j as usize)] += polygon.plane.normal;
                    }
                }
            }
        }
        let normals = sums.map(|n| {
            let length = libm::sqrtf(n.dot(n));
            if length < 0.0002 { Vec3::Z } else { n / length }
        });
        let terrain = assets.terrain(world);
        let paint = (0..64)
            .map(|k| terrain.cell(texture_code_of(land, k / 8, k % 8).unwrap_or(1 << 28)))
            .collect();
        Some(LandMesh { normals, paint })
    }
}
