//! Openings in a world whose landblocks come and go.

use glam::{Quat, Vec3};
use vestibule_testing::records::{Builder, Room};
use vestibule_view::Openings;
use vestibule_world::{BlockId, CellId, CellManager, Frame, Position, ResidencySettings, World};

const HOME: BlockId = BlockId(0xA9B4);
/// Thirty landblocks to the east.
const AWAY: BlockId = BlockId(0xC7B4);

fn world() -> World {
    let door = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, 2.0], [1.0, 0.0, 2.0]];
    let mut b = Builder::new(HOME.0);
    let mut room = Room::of_box(0x100, Vec3::ZERO, Vec3::splat(5.0)).opening(None, -1, true, &door);
    room.seen_outside = true;
    b.room(room);
    for x in 0xA8..=0xC9u16 {
        for y in 0xB2..=0xB6u16 {
            if x << 8 | y != HOME.0 {
                b.flat_block(x << 8 | y);
            }
        }
    }
    b.world()
}

#[test]
fn r5_openings_follow_residency_when_they_are_forgotten() {
    let mut world = world();
    let settings = ResidencySettings {
        threaded: false,
        ..ResidencySettings::default()
    };
    let mut cells = CellManager::new(&mut world, settings);
    let mut openings = Openings::new();
    let room = CellId::new(HOME, 0x100);
    let indoors = Position::new(room, Vec3::new(2.0, 2.0, 0.0));
    let away = Position {
        cell: CellId::new(AWAY, 1),
        frame: Frame::new(Vec3::new(3.0, 3.0, 0.0), Quat::IDENTITY),
    };
    let has_room = |openings: &Openings, world: &World| {
        openings
            .block(world, HOME)
            .is_some_and(|block| block.has_room(room))
    };
    let mut go = |world: &mut World, to: &Position| {
        cells.change_position(world, to);
        cells.finish(world);
    };
    // Not there yet, which is remembered.
    assert!(!has_room(&openings, &world));
    go(&mut world, &indoors);
    assert!(!has_room(&openings, &world));
    assert!(openings.forget(HOME) && !openings.forget(HOME));
    assert!(has_room(&openings, &world));
    // Gone, while what was compiled stays until it is forgotten.
    go(&mut world, &away);
    assert!(!world.is_resident(room) && has_room(&openings, &world));
    assert!(openings.forget(HOME));
    assert!(!has_room(&openings, &world));
    // And back, with all forgotten at once.
    go(&mut world, &indoors);
    openings.clear();
    assert!(has_room(&openings, &world));
}
