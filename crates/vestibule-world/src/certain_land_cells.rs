//! Which land cells spheres touch, told by the borders they reach over (`world.md` 11.1), and how far they are from the
//! rooms of the buildings there. Spheres come as a mover has them: a foot and a head, radii in the fourth lanes; one sphere
//! is given twice.

use crate::cell_array::CellArray;
use crate::constants::BLOCK_SIDE_CELLS;
use crate::geometry::Sphere;
use crate::ids::CellId;
use crate::landblock::Landblock;
use crate::lanes::Lanes;
use crate::terrain::LandCell;
use crate::transit::add_all_outside_cells;
use crate::world::World;

/// As [`crate::certain_cells`] on land: land cells of the same landblock only.
pub(crate) fn certain_land_cells(
    world: &World,
    block: &Landblock,
    seed: CellId,
    spheres: [Lanes; 2],
    array: &mut CellArray,
) -> f32 {
    array.clear();
    let Some(cell) = block.land_cell(seed) else {
        return 0.0;
    };
    let mut least = f32::INFINITY;
    for s in spheres {
        let d = cell.distance_to_change(s);
        least = if d < least { d } else { least };
    }
    if !(least > 0.0) {
        return 0.0;
    }
    if !add_land_cells(seed, cell, spheres, array) {
        let [foot, _] = spheres;
        add_all_outside_cells(world, seed, foot.xyz(), &spheres.map(Sphere::from), array);
    }
    for entry in array.entries() {
        let d = match block.land_cell(entry.id) {
            Some(cell) if entry.id.block() == block.id => distance_to_rooms(world, block, cell, spheres),
            _ => 0.0,
        };
        least = if d < least { d } else { least };
    }
    if least > 0.0 {
        return least;
    }
    array.clear();
    0.0
}

/// Fills `array` with the land cells under spheres, as [`add_all_outside_cells`] does, if their centres are certainly inside
/// the land cell `seed` and what else they touch is plain; says whether it did.
#[inline(always)]
pub fn add_land_cells(
    seed: CellId,
    cell: &LandCell,
    [foot, head]: [Lanes; 2],
    array: &mut CellArray,
) -> bool {
    let (Some([dx, dy]), of_head) = (cell.sides_crossed(foot), cell.sides_crossed(head)) else {
        return false;
    };
    let index = i32::from(seed.low()) - 1;
    let (x, y) = (index >> 3, index & 7);
    let inside = |v: i32| (0..BLOCK_SIDE_CELLS).contains(&v);
    // A head that reaches elsewhere comes second in the array: seldom.
    if of_head != Some([dx, dy]) || !inside(x + dx) || !inside(y + dy) {
        return false;
    }
    array.start(seed, true);
    array.added_outside = true;
    let mut add = |x: i32, y: i32| array.add(CellId::new(seed.block(), (8 * x + y + 1) as u16), true);
    if dx != 0 {
        add(x + dx, y);
        if dy != 0 {
            add(x + dx, y + dy);
        }
    }
    if dy != 0 {
        add(x, y + dy);
    }
    true
}

/// How far spheres may be shifted and stay out of what is behind the portals of a land cell's building, metres.
/// Zero: one may be touched.
#[inline(always)]
pub fn distance_to_rooms(world: &World, block: &Landblock, cell: &LandCell, spheres: [Lanes; 2]) -> f32 {
    let mut least = f32::INFINITY;
    if let Some(building) = cell.building.and_then(|i| block.buildings.get(usize::from(i))) {
        for portal in &building.portals {
            let Some(behind) = world.env_cell(portal.other) else {
                continue;
            };
            let d = behind.hints.outside_distance(spheres);
            least = if d < least { d } else { least };
        }
    }
    least
}
