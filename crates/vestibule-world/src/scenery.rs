//! Scenery: trees, rocks and grass placed by formula from the terrain (`world.md` 21, optional in the engine).

use std::sync::Arc;

use glam::{Quat, Vec3};
use vestibule_dat::record::{ObjectDesc, Scene};

use crate::constants::{BLOCK_LENGTH, BLOCK_SIDE_CELLS, BLOCK_SIDE_VERTICES, SQUARE_LENGTH};
use crate::frame::{Frame, normalise};
use crate::ids::{BlockId, LandCoord};
use crate::landblock::Landblock;
use crate::position::heading_of;
use crate::shape::Shape;
use crate::terrain::{TerrainWord, vertex_index};
use crate::world::World;

/// What turns a 32-bit hash into a number from 0 to 1 (`world.md` 21).
const HASH_TO_UNIT: f64 = 2.328_306_4e-10;

/// A hash as a number from 0 to 1.
pub fn unit(hash: u32) -> f64 {
    f64::from(hash) * HASH_TO_UNIT
}

/// Hashes of one terrain vertex; `at` is its global coordinate, one per land cell (`world.md` 21).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneryHash {
    x: u32,
    y: u32,
}

impl SceneryHash {
    /// Hashes for the vertex at `at`.
    pub fn new(at: LandCoord) -> Self {
        SceneryHash {
            x: at.x as u32,
            y: at.y as u32,
        }
    }

    /// Picks the scene (`world.md` 21.2).
    pub fn scene(self) -> u32 {
        let SceneryHash { x, y } = self;
        y.wrapping_mul(x.wrapping_mul(712_977_289).wrapping_add(1_813_693_831))
            .wrapping_sub(x.wrapping_mul(1_109_124_029))
            .wrapping_add(2_139_937_281)
    }

    /// Index of the scene among `count`.
    pub fn scene_index(self, count: usize) -> usize {
        let index = libm::floor(unit(self.scene()) * count as f64) as usize;
        if count == 1 || index >= count { 0 } else { index }
    }

    /// The hash of object `k` for purpose `c` (`world.md` 21.3).
    pub fn object(self, k: u32, c: u32) -> u32 {
        let SceneryHash { x, y } = self;
        let xy = x
            .wrapping_mul(y)
            .wrapping_mul(1_360_117_743)
            .wrapping_add(1_888_038_839);
        y.wrapping_mul(1_813_693_831)
            .wrapping_sub(k.wrapping_add(c).wrapping_mul(xy))
            .wrapping_sub(x.wrapping_mul(1_109_124_029))
    }

    /// Picks the quadrant an object is turned into (`world.md` 21.3c).
    pub fn quadrant(self) -> u32 {
        let SceneryHash { x, y } = self;
        y.wrapping_mul(1_813_693_831)
            .wrapping_sub(x.wrapping_mul(y.wrapping_mul(1_870_387_557).wrapping_add(1_109_124_029)))
            .wrapping_sub(402_451_965)
    }

    /// Where object `k` stands relative to the vertex, metres (`world.md` 21.3b-c).
    pub fn displacement(self, k: u32, desc: &ObjectDesc) -> Vec3 {
        let base = desc.base_loc.origin;
        let along = |base: f32, displace: f32, c: u32| {
            if displace <= 0.0 {
                base
            } else {
                base + (unit(self.object(k, c)) * f64::from(displace)) as f32
            }
        };
        let dx = along(base.x, desc.displace_x, DISPLACE_X);
        let dy = along(base.y, desc.displace_y, DISPLACE_Y);
        let quadrant = unit(self.quadrant());
        let (x, y) = if quadrant < 0.25 {
            (dx, dy)
        } else if quadrant < 0.5 {
            (-dy, dx)
        } else if quadrant < 0.75 {
            (-dx, -dy)
        } else {
            (dy, -dx)
        };
        Vec3::new(x, y, base.z)
    }
}

const FREQUENCY: u32 = 23399;
const DISPLACE_X: u32 = 45773;
const DISPLACE_Y: u32 = 72719;
const ROTATION: u32 = 63127;
const SCALE: u32 = 32593;

/// A piece of scenery.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneryObject {
    /// What it is.
    pub shape: Arc<Shape>,
    /// Object to landblock frame, unscaled.
    pub frame: Frame,
    /// Its scale on all axes.
    pub scale: f32,
}

/// Whether a point of a landblock lies on a road, metres in the block's frame (`world.md` A7).
pub fn on_road(words: &[TerrainWord; 81], p: Vec3, road_width: f32) -> bool {
    let index = |v: f32| libm::floorf(v / SQUARE_LENGTH);
    let (ci, cj) = (index(p.x), index(p.y));
    let cells = 0.0..BLOCK_SIDE_CELLS as f32;
    if !(cells.contains(&ci) && cells.contains(&cj)) {
        return false;
    }
    let (i, j) = (ci as usize, cj as usize);
    let road = |i: usize, j: usize| words[vertex_index(i, j)].road() != 0;
    let (sw, nw, se, ne) = (road(i, j), road(i, j + 1), road(i + 1, j), road(i + 1, j + 1));
    let (dx, dy) = (p.x - ci * SQUARE_LENGTH, p.y - cj * SQUARE_LENGTH);
    let (w, m) = (road_width, SQUARE_LENGTH - road_width);
    let (west, east, south, north) = (dx < w, dx > m, dy < w, dy > m);
    let (ex, ey) = (SQUARE_LENGTH - dx, SQUARE_LENGTH - dy);
    match (sw, se, ne, nw) {
        (true, true, true, true) => true,
        (false, false, false, false) => false,
        (true, false, false, false) => dx + dy < w,
        (false, true, false, false) => ex + dy < w,
        (false, false, true, false) => ex + ey < w,
        (false, false, false, true) => dx + ey < w,
        (true, true, false, false) => south,
        (false, true, true, false) => east,
        (false, false, true, true) => north,
        (true, false, false, true) => west,
        (true, false, true, false) => (dx - dy).abs() < w,
        (false, true, false, true) => (dx + dy - SQUARE_LENGTH).abs() < w,
        // Three corners: near either side that joins them.
        (false, true, true, true) => east || north,
        (true, false, true, true) => north || west,
        (true, true, false, true) => west || south,
        (true, true, true, false) => south || east,
    }
}

/// All scenery of a landblock, in retail's order: vertex by vertex, x-major (`world.md` 21). Reads Scene
/// records, so ask once and keep the answer.
pub fn place_scenery(world: &World, block: &Landblock) -> Vec<SceneryObject> {
    let Some(land) = &block.land else {
        return Vec::new();
    };
    let mut out = Vec::new();
    for i in 0..BLOCK_SIDE_VERTICES {
        for j in 0..BLOCK_SIDE_VERTICES {
            let word = land.words[vertex_index(i, j)];
            let scenes = world.region().scenes(word.terrain_type(), word.scene());
            if scenes.is_empty() {
                continue;
            }
            let hash = SceneryHash::new(vertex_coord(block.id, i, j));
            let Some(&id) = scenes.get(hash.scene_index(scenes.len())) else {
                continue;
            };
            let Some(scene) = world.scene(id) else { continue };
            for (k, desc) in (0u32..).zip(&scene.objects) {
                out.extend(place(world, block, hash, (i, j), k, desc));
            }
        }
    }
    out
}

fn vertex_coord(block: BlockId, i: usize, j: usize) -> LandCoord {
    let corner = block.corner();
    LandCoord {
        x: corner.x + i as i32,
        y: corner.y + j as i32,
    }
}

fn place(
    world: &World,
    block: &Landblock,
    hash: SceneryHash,
    (i, j): (usize, usize),
    k: u32,
    desc: &ObjectDesc,
) -> Option<SceneryObject> {
    if desc.weenie_obj != 0 || unit(hash.object(k, FREQUENCY)) >= f64::from(desc.frequency) {
        return None;
    }
    let offset = hash.displacement(k, desc);
    let mut p = Vec3::new(
        i as f32 * SQUARE_LENGTH + offset.x,
        j as f32 * SQUARE_LENGTH + offset.y,
        offset.z,
    );
    let inside = 0.0..BLOCK_LENGTH;
    let land = block.land.as_ref()?;
    if !(inside.contains(&p.x) && inside.contains(&p.y)) || on_road(&land.words, p, world.region().road_width)
    {
        return None;
    }
    let (_, cell) = block.land_cell_at(p)?;
    let polygon = cell.find_terrain_poly(p).filter(|_| cell.building.is_none())?;
    let normal = polygon.plane.normal;
    if normal.z < desc.min_slope || normal.z > desc.max_slope {
        return None;
    }
    p.z = polygon.height_at(p)?;
    let mut frame = Frame::new(p, desc.base_loc.rotation);
    if desc.align != 0 {
        frame.set_rotation(upright(heading_of(-normal)));
    } else if desc.max_rotation > 0.0 {
        let degrees = unit(hash.object(k, ROTATION)) * f64::from(desc.max_rotation);
        frame.set_rotation(normalise(upright(degrees as f32) * desc.base_loc.rotation));
    }
    let shape = world.shape(desc.object_id, desc.object_id)?;
    if !lies_within_block(&shape, &frame) {
        return None;
    }
    Some(SceneryObject {
        shape,
        frame,
        scale: scale(hash.object(k, SCALE), desc),
    })
}

/// A turn about z to a heading in degrees (`world.md` J1, upright bases).
fn upright(degrees: f32) -> Quat {
    let half = -degrees * (core::f32::consts::PI / 360.0);
    Quat::from_xyzw(0.0, 0.0, libm::sinf(half), libm::cosf(half))
}

fn scale(hash: u32, desc: &ObjectDesc) -> f32 {
    let (min, max) = (desc.min_scale, desc.max_scale);
    if min == max {
        max
    } else {
        min * libm::powf(max / min, unit(hash) as f32)
    }
}

/// `world.md` 21.3f, before scaling.
fn lies_within_block(shape: &Shape, frame: &Frame) -> bool {
    let fits = |p: Vec3, r: f32| {
        let span = r..BLOCK_LENGTH - r;
        span.contains(&p.x) && span.contains(&p.y)
    };
    if shape.has_physics_bsp || (shape.cylspheres.is_empty() && !shape.spheres.is_empty()) {
        let sphere = &shape.sorting_sphere;
        fits(frame.local_to_global(sphere.center), sphere.radius)
    } else if !shape.cylspheres.is_empty() {
        shape
            .cylspheres
            .iter()
            .all(|c| fits(frame.local_to_global(c.low_point), c.radius))
    } else {
        fits(frame.origin, 0.0)
    }
}

impl World {
    fn scene(&self, id: u32) -> Option<Scene> {
        self.parse(
            crate::source::Store::Portal,
            id,
            crate::region::REGION_RECORD,
            Scene::parse,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(hash: u32, expected: u32, as_unit: f64) {
        assert_eq!(hash, expected, "{hash:08X}");
        assert!((unit(hash) - as_unit).abs() < 1e-6);
    }

    #[test]
    fn example_22_36_scenery_hashes() {
        let hash = SceneryHash::new(LandCoord { x: 1352, y: 1440 });
        close(hash.scene(), 0x4B26_1039, 0.293_550);
        assert_eq!(hash.scene_index(5), 1);
        close(hash.object(0, FREQUENCY), 0x16DC_1C97, 0.089_296);
        close(hash.object(1, FREQUENCY), 0x5B8B_F1E0, 0.357_604);
        close(hash.object(0, DISPLACE_X), 0x3666_E6AD, 0.212_508);
        close(hash.object(0, DISPLACE_Y), 0x0A36_D47F, 0.039_899);
        close(hash.object(0, ROTATION), 0x6DF7_4D47, 0.429_555);
        close(hash.object(0, SCALE), 0xE9BE_0C51, 0.913_056);
        close(hash.quadrant(), 0xAA2A_023B, 0.664_703);
        let desc = ObjectDesc {
            displace_x: 6.0,
            displace_y: 6.0,
            ..Default::default()
        };
        let d = hash.displacement(0, &desc);
        assert!(
            (d - Vec3::new(-1.275_046, -0.239_395, 0.0)).length() < 1e-5,
            "{d}"
        );
    }

    #[test]
    fn example_22_37_scenery_hashes_elsewhere() {
        let corner = SceneryHash::new(LandCoord { x: 0, y: 0 });
        close(corner.scene(), 0x7F8C_DA01, 0.498_243);
        assert_eq!(corner.scene_index(5), 2);
        close(corner.object(0, FREQUENCY), 0xF4D7_C05F, 0.956_417);
        let far = SceneryHash::new(LandCoord { x: 1000, y: 1 });
        assert_eq!((far.scene(), far.scene_index(5)), (0xAF78_1468, 3));
        close(far.object(1, FREQUENCY), 0xCE3D_AE27, 0.805_629);
    }

    #[test]
    fn a7_roads_by_their_corners() {
        let with = |corners: [u16; 4]| {
            let mut words = [TerrainWord(0); 81];
            for (k, (i, j)) in [(0, 0), (1, 0), (1, 1), (0, 1)].into_iter().enumerate() {
                words[vertex_index(i, j)] = TerrainWord(corners[k]);
            }
            move |x: f32, y: f32| on_road(&words, Vec3::new(x, y, 0.0), 5.0)
        };
        let one = with([1, 0, 0, 0]);
        assert!(one(2.0, 2.9) && !one(2.0, 3.0) && !one(20.0, 20.0));
        let south = with([1, 1, 0, 0]);
        assert!(south(12.0, 4.9) && !south(12.0, 5.0));
        let diagonal = with([1, 0, 1, 0]);
        assert!(diagonal(12.0, 16.9) && !diagonal(12.0, 17.0));
        let other = with([0, 1, 0, 1]);
        assert!(other(12.0, 16.9) && !other(12.0, 17.0) && !other(2.0, 2.0));
        let three = with([1, 1, 0, 1]);
        assert!(three(4.9, 20.0) && three(20.0, 4.9) && !three(20.0, 20.0));
        assert!(with([1; 4])(12.0, 12.0) && !with([0; 4])(12.0, 12.0));
    }
}
