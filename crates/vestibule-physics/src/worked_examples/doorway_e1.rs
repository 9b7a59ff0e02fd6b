//! `evidence.md` E1 as a walk: the recorded doorway.

use glam::Vec3;
use vestibule_world::CellId;

use crate::rig::*;
use crate::sweep::Carried;

/// The doorway of `evidence.md` E1, from its figures: 0x170 the vestibule, 0x171 the room.
fn evidence_doorway() -> Rig {
    use records::{Builder, Room, box_planes, plane};
    let (x0, x1) = (5.547_31_f32, 7.451_89_f32);
    let (inner, floor_edge, top_edge) = (-7.65_f32, -8.609_f32, -8.346_16_f32);
    let turned = vestibule_dat::primitive::Frame {
        origin: v(161.929, 7.503_15, 94.0),
        rotation: glam::Quat::from_xyzw(0.0, 0.0, 1.0, 0.0),
    };
    let mut planes = box_planes(v(x0, -100.0, 0.0), v(x1, inner, 2.5));
    planes.push(plane(0.0, 0.994_518_64, -0.104_559_82, 8.561_810_5));
    let exit = [
        [x0, floor_edge, 0.0],
        [x0, top_edge, 2.5],
        [x1, top_edge, 2.5],
        [x1, floor_edge, 0.0],
    ];
    let to_room = [
        [x0, inner, 0.0],
        [x0, inner, 2.5],
        [x1, inner, 2.5],
        [x1, inner, 0.0],
    ];
    let mut vestibule = Room::of_box(0x170, Vec3::ZERO, Vec3::ONE)
        .opening(None, -1, true, &exit)
        .opening(Some(0x171), 0, false, &to_room);
    (vestibule.frame, vestibule.planes, vestibule.seen_outside) = (turned, planes, true);
    let mut room =
        Room::of_box(0x171, v(0.0, inner, 0.0), v(12.0, 0.0, 4.0)).opening(Some(0x170), 1, true, &to_room);
    room.frame = turned;
    let mut b = Builder::new(BLOCK);
    // Two metres lower than in the game, so that the ground plays no part.
    b.heights = [46; 81];
    b.room(vestibule)
        .room(room)
        .building(v(160.0, 10.0, 94.0), &[(0x170, 0)]);
    Rig::of(b)
}

#[test]
fn e1_walking_between_the_rows_of_the_recording_gives_their_cells() {
    const ROWS: [(u16, f32, f32, u16); 19] = [
        (0x31, 155.3717, 16.0283, 0x170),
        (0x170, 155.3438, 15.1343, 0x171),
        (0x171, 155.3463, 15.2186, 0x170),
        (0x170, 155.3742, 16.1126, 0x31),
        (0x31, 155.3723, 16.0516, 0x170),
        (0x170, 155.3431, 15.1187, 0x171),
        (0x171, 155.3445, 15.1641, 0x170),
        (0x170, 155.3748, 16.1358, 0x31),
        (0x31, 155.3692, 15.9583, 0x170),
        (0x170, 155.3437, 15.1420, 0x171),
        (0x171, 155.3451, 15.1874, 0x170),
        (0x170, 155.373, 16.0814, 0x31),
        (0x31, 155.3721, 16.0571, 0x170),
        (0x170, 155.3418, 15.0854, 0x171),
        (0x171, 155.3456, 15.2085, 0x170),
        (0x170, 155.3735, 16.1025, 0x31),
        (0x170, 155.3435, 15.1454, 0x171),
        (0x171, 155.3461, 15.2296, 0x170),
        (0x170, 155.374, 16.1236, 0x31),
    ];
    let full = |low: u16| CellId(0xA9B4_0000 | u32::from(low));
    let mut rig = evidence_doorway();
    // The rooms have no floors: each move is made without contact, level.
    let player = crate::sweep::Mover::player();
    let mut at = vestibule_world::Position::new(full(0x31), v(155.375, 17.0, 94.0050));
    for (i, &(seed, x, y, picked)) in ROWS.iter().enumerate() {
        // Between rows 16 and 17 a change is missing from the log: the walk goes through it.
        if i != 16 {
            assert_eq!(at.cell, full(seed), "before row {}", i + 1);
        }
        let to = vestibule_world::Position::new(at.cell, v(x, y, 94.0050));
        let swept = crate::sweep::sweep(
            &rig.world,
            &rig.population,
            &mut rig.scratch,
            &player,
            &Carried::default(),
            &at,
            &to,
        )
        .unwrap();
        assert_eq!(
            (swept.ok, swept.cell),
            (true, Some(full(picked))),
            "row {}",
            i + 1
        );
        assert!((swept.position.origin() - to.origin()).length() < 1e-4);
        at = swept.position;
    }
}
