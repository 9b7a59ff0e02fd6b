//! `evidence.md` E1: a doorway recorded from the retail client.

use glam::{Quat, Vec3};
use vestibule_dat::primitive::Frame;
use vestibule_world::CellId;

use crate::records::{Builder, Room, box_planes, plane};

/// Landblock of the doorway.
pub const BLOCK: u16 = 0xA9B4;
/// Height of the doorway's floor as recorded, metres.
pub const FLOOR: f32 = 94.005;

/// A row of the recording: where the body was, as which cell it began, and which one was picked.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Cell before.
    pub seed: CellId,
    /// Feet of the body, in the frame of the landblock.
    pub feet: Vec3,
    /// Cell that the client picked.
    pub picked: CellId,
}

/// The nineteen rows in order. Between the sixteenth and the seventeenth a change of cell is missing from the log.
pub fn rows() -> [Row; 19] {
    let rows: [(u32, f32, f32, u32); 19] = [
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
    let full = |low| CellId(u32::from(BLOCK) << 16 | low);
    rows.map(|(seed, x, y, picked)| Row {
        seed: full(seed),
        feet: Vec3::new(x, y, FLOOR),
        picked: full(picked),
    })
}

/// The doorway's world, from the figures of E1: cell 0x170 is the vestibule, 0x171 the room behind it, and rooms without
/// openings stand for the other cells of the landblock. The ground lies at `2 * height` metres: at 47 where the floor
/// is, lower to have it play no part.
pub fn doorway(height: u8) -> Builder {
    let (x0, x1) = (5.547_31_f32, 7.451_89_f32);
    let (inner, floor_edge, top_edge) = (-7.65_f32, -8.609_f32, -8.346_16_f32);
    // Half a turn about z.
    let turned = Frame {
        origin: Vec3::new(161.929, 7.503_15, 94.0),
        rotation: Quat::from_xyzw(0.0, 0.0, 1.0, 0.0),
    };
    let mut planes = vec![
        plane(1.0, 0.0, 0.0, -x0),
        plane(-1.0, 0.0, 0.0, x1),
        plane(0.0, 0.0, 1.0, 0.0),
        plane(0.0, 0.0, -1.0, 2.5),
        plane(0.0, -1.0, 0.0, inner),
    ];
    // The exit's plane as recorded faces outward; the cell's own is its reverse.
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
        .opening(Some(0x171), 0, false, &to_room)
        .stabs(&[0x171]);
    (vestibule.frame, vestibule.planes, vestibule.seen_outside) = (turned, planes, true);
    let (min, max) = (Vec3::new(0.0, inner, 0.0), Vec3::new(12.0, 0.0, 4.0));
    let mut room = Room::of_box(0x171, min, max).opening(Some(0x170), 1, true, &to_room);
    (room.frame, room.planes) = (turned, box_planes(min, max));
    let mut builder = Builder::new(BLOCK);
    builder.heights = [height; 81];
    for low in 0x100..0x170 {
        builder.room(Room::of_box(low, Vec3::splat(-1.0), Vec3::splat(-0.5)));
    }
    builder
        .room(vestibule)
        .room(room)
        .building(Vec3::new(160.0, 10.0, 94.0), &[(0x170, 0)]);
    builder
}
