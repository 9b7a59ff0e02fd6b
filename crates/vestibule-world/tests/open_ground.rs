//! Ground that is said to be open has nothing near it: neither rooms, shells, static objects nor restrictions.

use glam::{Quat, Vec2, Vec3};
use vestibule_dat::primitive::{CylSphere, Frame, PackedHashTable};
use vestibule_dat::record::{Setup, Stab};
use vestibule_testing::records::{Builder, Room};
use vestibule_world::{CellArray, CellId, Lanes, ReachQuad, Sphere, World, find_cell_list};

const HOUSE: CellId = CellId(0xA9B4_0001);
const TREE: CellId = CellId(0xA9B4_0013);
const BARE: CellId = CellId(0xA9B4_0020);
const WATCHED: CellId = CellId(0xA9B4_0040);
/// Where the tree stands.
const STEM: Vec2 = Vec2::new(61.8, 60.0);

/// A house with a wall that stands off it, a tree and a land cell that is watched over.
fn world() -> World {
    let mut b = Builder::new(0xA9B4);
    let door = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, 2.0], [1.0, 0.0, 2.0]];
    b.room(Room::of_box(0x100, Vec3::ZERO, Vec3::new(5.0, 5.0, 3.0)).opening(None, -1, true, &door));
    b.building(Vec3::new(2.0, 2.0, 0.0), &[(0x100, 0)]);
    let wall = [[6.0, 0.0, 0.0], [6.0, 5.0, 0.0], [6.0, 5.0, 3.0], [6.0, 0.0, 3.0]];
    b.model(0x0100_0001, &[wall.map(Vec3::from_array).to_vec()], true);
    b.setup(&Setup {
        id: 0x0200_0001,
        cyl_spheres: vec![CylSphere {
            low_point: Vec3::ZERO,
            radius: 1.0,
            height: 5.0,
        }],
        ..Default::default()
    });
    b.info.objects.push(Stab {
        id: 0x0200_0001,
        frame: Frame {
            origin: STEM.extend(0.0),
            rotation: Quat::IDENTITY,
        },
    });
    b.info.pack_mask |= 1;
    b.info.restrictions = Some(PackedHashTable::new(vec![(WATCHED.0, 0x7526_200C)]));
    b.world()
}

/// The points of a grid over a land cell where a body of two spheres is over open ground.
fn open_points(world: &World, id: CellId) -> Vec<Vec2> {
    let block = world.block(id.block()).unwrap();
    let (cell, low) = (block.land_cell(id).unwrap(), id.low() - 1);
    let corner = Vec2::new(f32::from(low >> 3), f32::from(low & 7)) * 24.0;
    let mut found = Vec::new();
    for i in 0..80 {
        for j in 0..80 {
            let p = corner + Vec2::new(i as f32, j as f32) * 0.3;
            let body = [0.5, 1.5].map(|z| Lanes::new(p.extend(z), 0.5));
            if cell.certainly_holds(body) && block.is_known_open(id, cell, body) {
                found.push(p);
            }
        }
    }
    found
}

#[test]
fn open_ground_is_known_once_shadow_lists_are() {
    let world = world();
    assert_eq!(open_points(&world, BARE), []);
    assert!(world.statics_in(BARE).is_empty());
    assert_eq!(open_points(&world, BARE).len(), 77 * 77);
    assert_eq!(open_points(&world, WATCHED), []);
}

#[test]
fn nothing_is_near_open_ground() {
    let world = world();
    let lists = world.shadow_lists(world.block(HOUSE.block()).unwrap());
    let mut array = CellArray::new();
    for (id, least) in [(HOUSE, 3000), (TREE, 4000)] {
        let open = open_points(&world, id);
        assert!(open.len() > least, "{}", open.len());
        for p in open {
            for z in [-2.0, 0.5, 1.5, 4.0] {
                let sphere = Sphere::new(p.extend(z), 0.5);
                find_cell_list(&world, id, sphere.center, &[sphere], &mut array, true);
                assert_eq!(array.entries().len(), 1, "{p}");
                let clears = |quad: &ReachQuad| quad.distances([sphere.into(); 2], 0.5).least() > 0.0;
                assert!(lists.quads(id).iter().all(clears), "{p}");
            }
            let from_wall = p - p.clamp(Vec2::new(8.0, 2.0), Vec2::new(8.0, 7.0));
            assert!(from_wall.length() > 0.5 && (p - STEM).length() > 1.5, "{p}");
        }
    }
}
