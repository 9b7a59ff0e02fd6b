//! Walking bodies, many of them.

use glam::Vec3;
use vestibule_physics::{Body, Locomotion, Motion, Placement, Simulation};
use vestibule_world::{BlockId, CellId, Position, World};

/// A hash of two numbers, the same everywhere.
fn mix(a: u64, b: u64) -> u64 {
    let mut z = a.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ b.wrapping_mul(0xD1B5_4A32_D192_ED03);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A body that can walk.
pub fn walker() -> Body {
    let mut body = Body::player();
    body.locomotion = Some(Locomotion::with_skills(100.0, 100.0));
    body
}

/// On the ground of a landblock, at a place that follows from `salt`; `None` without terrain.
pub fn on_the_ground(world: &World, block: BlockId, salt: u64) -> Option<Position> {
    let draw = mix(u64::from(block.0), salt);
    let (x, y) = (8.0 + (draw % 176) as f32, 8.0 + (draw >> 20 & 0xFF) as f32 * 0.68);
    let ground = world.ground_at(CellId::new(block, 1), Vec3::new(x, y, 0.0))?;
    Some(Position::new(ground.cell, Vec3::new(x, y, ground.z + 0.005)))
}

/// On the floor in the middle of a room.
pub fn in_the_room(world: &World, cell: CellId) -> Option<Position> {
    let room = world.env_cell(cell)?;
    let bounds = room.structure.bounds?;
    let middle = (bounds.min + bounds.max) * 0.5;
    let floor = Vec3::new(middle.x, middle.y, bounds.min.z + 0.005);
    Some(Position::new(cell, room.frame.local_to_global(floor)))
}

/// Adds a walker for each place, with keys from 0.
pub fn populate(simulation: &mut Simulation, places: &[Position]) {
    for (key, place) in (0u64..).zip(places) {
        simulation.add(key, walker(), Placement::at(*place));
    }
}

/// Tells every body to run on and, now and then, to turn.
pub fn direct(simulation: &mut Simulation, tick: u64) {
    simulation.for_each_body(|key, body| {
        let draw = mix(key, tick / 16);
        let turn = match draw % 5 {
            0 => 1.0,
            1 => -1.0,
            _ => 0.0,
        };
        body.set_motion(Motion {
            forward: 1.0,
            turn,
            run: !draw.is_multiple_of(3),
            ..Motion::default()
        });
    });
}
