//! Hints and shortcuts change no answer: random sweeps in worlds with hints against the same sweeps in worlds
//! without any (`WorldSettings::exact`), bit for bit.

mod common;

use common::*;
use glam::{Quat, Vec3};
use vestibule_dat::DatSet;
use vestibule_dat::record::EnvCell;
use vestibule_physics::{
    Body, BodyId, Carried, ContactPlane, EntryRestrictions, Mover, ObjectKind, ObjectState, PhysicsState,
    Placement, Population, Scratch, Settings, sweep,
};
use vestibule_world::{BlockId, CellId, Plane, Position, Sphere, Store, World, WorldSettings};

const EXACT: WorldSettings = WorldSettings {
    offset_building_transit: false,
    exact: true,
};

struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn signed(&mut self) -> f32 {
        self.next() * 2.0 - 1.0
    }

    fn chance(&mut self, share: f32) -> bool {
        self.next() < share
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f32) as usize).min(n - 1)
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
}

/// The same world with and without hints.
struct Pair {
    quick: World,
    exact: World,
    blocks: Vec<BlockId>,
}

impl Pair {
    fn open(name: &str) -> Option<Self> {
        let dir = vectors()?.join("worlds").join(name);
        let open = |settings| World::with_settings(DatSet::open_in_memory(&dir).unwrap(), settings).unwrap();
        Some(Pair::of(open(WorldSettings::default()), open(EXACT)))
    }

    fn embedded() -> Self {
        Pair::compiled(&vestibule_forge::embedded_world().unwrap())
    }

    fn compiled(compiled: &vestibule_forge::CompiledWorld) -> Self {
        let open = |settings| World::with_settings(compiled.memory_records(), settings).unwrap();
        Pair::of(open(WorldSettings::default()), open(EXACT))
    }

    fn of(quick: World, exact: World) -> Self {
        let blocks: Vec<BlockId> = (0..=u16::MAX)
            .map(BlockId)
            .filter(|&id| quick.block(id).is_some())
            .collect();
        for &id in &blocks {
            assert!(exact.block(id).is_some());
        }
        assert!(!blocks.is_empty());
        Pair { quick, exact, blocks }
    }

    /// Somewhere in a cell: two out of three times in a room, if there are any.
    fn somewhere(&self, draws: &mut Draws) -> Option<Position> {
        let block = self.quick.block(self.blocks[draws.below(self.blocks.len())])?;
        let rooms: Vec<_> = block.env_cells().collect();
        if !rooms.is_empty() && (block.land.is_none() || draws.chance(0.67)) {
            let room = rooms[draws.below(rooms.len())];
            // One in three stands in or near a doorway, where several cells count.
            if let (true, Some(portal)) = (draws.chance(0.33), room.portals.first()) {
                let portal = room
                    .portals
                    .get(draws.below(room.portals.len()))
                    .unwrap_or(portal);
                let corners = room.portal_vertices(portal);
                if let Some(low) = corners
                    .iter()
                    .copied()
                    .reduce(|a, b| if b.z < a.z { b } else { a })
                {
                    let middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
                    let at = Vec3::new(middle.x, middle.y, low.z + 0.1) + draws.point() * 0.7;
                    return Some(Position::new(room.id, room.frame.local_to_global(at)));
                }
            }
            let bounds = room.structure.bounds?;
            let at = (bounds.min + bounds.max) * 0.5 + (bounds.max - bounds.min) * 0.5 * draws.point();
            let p = room.frame.local_to_global(at);
            return Some(Position::new(room.id, p));
        }
        // Near a building if there is one.
        let near = match block.buildings.len() {
            0 => Vec3::new(96.0, 96.0, 0.0) + draws.point() * 90.0,
            n => block.buildings[draws.below(n)].part_frames.first()?.origin + draws.point() * 14.0,
        };
        let ground = self.quick.ground_at(CellId::new(block.id, 1), near)?;
        Some(Position::new(
            ground.cell,
            Vec3::new(ground.point.x, ground.point.y, ground.z + draws.next() * 2.0),
        ))
    }
}

/// Movers of all kinds: players, creatures of odd sizes, one sphere or two, missiles, cameras.
fn some_mover(draws: &mut Draws) -> Mover {
    let mut mover = if draws.chance(0.4) {
        Mover::player()
    } else {
        let scale = 0.25 + 2.0 * draws.next() * draws.next();
        let r = 0.48 * scale;
        let foot = Sphere::new(Vec3::new(0.0, 0.0, r), r);
        let above = r * (1.0 + 2.0 * draws.next());
        let head = Sphere::new(
            Vec3::new(0.1 * draws.signed(), 0.0, r + above),
            r * (0.6 + 0.6 * draws.next()),
        );
        let spheres = [foot, head];
        let count = if draws.chance(0.4) { 1 } else { 2 };
        Mover::new(&spheres[..count])
            .unwrap()
            .with_steps(0.6 * scale, 1.5 * scale * draws.next())
    };
    if draws.chance(0.15) {
        mover.state.set(ObjectState::EDGE_SLIDE, false);
    }
    if draws.chance(0.05) {
        mover.state = ObjectState::IS_VIEWER | ObjectState::PATH_CLIPPED | ObjectState::PERFECT_CLIP;
    } else if draws.chance(0.05) {
        mover.state.set(ObjectState::PATH_CLIPPED, true);
        mover.physics.set(PhysicsState::MISSILE, true);
    }
    if draws.chance(0.05) {
        mover.physics.set(PhysicsState::GRAVITY, false);
    }
    mover
}

/// Chains of sweeps from random places, each made in both worlds. `VESTIBULE_SEED` gives other draws, for longer
/// searches.
fn compare(name: &str, pair: &Pair, chains: u32, settings: Settings) {
    let seed = std::env::var("VESTIBULE_SEED").map_or(0, |seed| seed.parse().unwrap());
    compare_seeded(name, pair, chains, settings, seed);
}

fn compare_seeded(name: &str, pair: &Pair, chains: u32, settings: Settings, seed: u64) {
    let mut draws = Draws(0x9E37_79B9_7F4A_7C15 ^ (name.len() as u64 + seed * 0x1234_5678_9ABC));
    let mut populations = [
        Population::with_settings(settings),
        Population::with_settings(settings),
    ];
    let (mut quick_scratch, mut exact_scratch) = (Scratch::new(), Scratch::new());
    let (mut made, mut stood, mut collided) = (0u32, 0u32, 0u32);
    let mut astray = Draws(0x2545_F491_4F6C_DD1D);
    for chain in 0..chains {
        // The last quarter of the chains has bodies to run into.
        let crowded = chain >= chains - chains / 4 && chain % 8 == 0;
        if let (true, Some(at)) = (crowded, pair.somewhere(&mut draws)) {
            for (population, world) in populations.iter_mut().zip([&pair.quick, &pair.exact]) {
                let id = population.add(Body::player());
                let _ = population.set_position(world, &mut quick_scratch, id, &Placement::at(at));
            }
        }
        let Some(mut at) = pair.somewhere(&mut draws) else {
            continue;
        };
        if draws.chance(0.3) {
            let half = draws.signed() * 3.2;
            at.frame
                .set_rotation(Quat::from_xyzw(0.0, 0.0, libm::sinf(half), libm::cosf(half)));
        }
        let mover = some_mover(&mut draws);
        let mut state = Carried::default();
        let (mut heading, mut fall) = (draws.next() * 6.3, 0.0);
        for _ in 0..24 {
            if draws.chance(0.15) {
                heading += draws.signed() * 3.0;
            }
            let speed = match draws.below(20) {
                0 => 6.0 * draws.next(),
                1 => 0.001 * draws.next(),
                _ => 0.05 + 0.4 * draws.next(),
            };
            let mut by = Vec3::new(libm::cosf(heading), libm::sinf(heading), 0.0) * speed;
            if state.contact.is_some() && state.on_walkable {
                fall = 0.0;
            } else {
                fall -= 0.3;
                by.z = fall / 10.0;
            }
            let mut to = at;
            to.frame.origin += by;
            if draws.chance(0.05) {
                to.frame.set_rotation(Quat::from_xyzw(
                    0.0,
                    0.0,
                    libm::sinf(heading),
                    libm::cosf(heading),
                ));
            }
            let [quick, exact] = &populations;
            // The same on ground that the mover does not quite stand on, which leads nowhere.
            if let (Some(mut contact), true) = (state.contact, astray.chance(0.2)) {
                contact.plane.d += astray.signed() * 0.1;
                contact.plane.normal = (contact.plane.normal + astray.point() * 0.3).normalize_or(Vec3::Z);
                let state = Carried {
                    contact: Some(contact),
                    ..state
                };
                let a = sweep(&pair.quick, quick, &mut quick_scratch, &mover, &state, &at, &to);
                let b = sweep(&pair.exact, exact, &mut exact_scratch, &mover, &state, &at, &to);
                let context = || format!("{name}, chain {chain}: {mover:?} {state:?} {at:?} to {to:?}");
                assert_eq!(format!("{a:?}"), format!("{b:?}"), "{}", context());
                assert_eq!(quick_scratch.cells(), exact_scratch.cells(), "{}", context());
            }
            let a = sweep(&pair.quick, quick, &mut quick_scratch, &mover, &state, &at, &to).unwrap();
            let b = sweep(&pair.exact, exact, &mut exact_scratch, &mover, &state, &at, &to).unwrap();
            let told = |swept, scratch: &Scratch| {
                // Names signed zeros too.
                format!("{swept:?} {:?} {:?}", scratch.cells(), scratch.touched())
            };
            let context = || format!("{name}, chain {chain}: {mover:?} {state:?} {at:?} to {to:?}");
            assert_eq!(told(a, &quick_scratch), told(b, &exact_scratch), "{}", context());
            made += 1;
            stood += u32::from(a.on_walkable);
            collided += u32::from(a.collision_normal.is_some());
            if a.collision_normal.is_some() {
                heading += draws.next() * 2.0;
            }
            match a.cell {
                Some(cell) if a.ok => {
                    at = Position { cell, ..a.position };
                    state = a.carried();
                }
                _ => break,
            }
        }
    }
    assert!(
        made > chains && stood * 4 > made && collided * 50 > made,
        "{name}: {made} sweeps, {stood} on the ground, {collided} collided"
    );
}

fn compare_vectors(name: &str, chains: u32) {
    if let Some(pair) = Pair::open(name) {
        compare(name, &pair, chains, Settings::default());
    }
}

#[test]
fn shortcuts_change_nothing_in_the_embedded_world() {
    let pair = Pair::embedded();
    compare("embedded", &pair, 3000, Settings::default());
    // These draws come to where a step leads from certain surroundings to uncertain ones.
    compare_seeded("embedded", &pair, 3000, Settings::default(), 8);
}

/// Rooms at odd angles, tilted and turned over, with things to step onto and to run into.
const TURNED: &str = r#"
scene "Turned"
material stone blocks color 148 142 132
model slab { box (-1 -0.6 0) (1 0.6 0.25) stone }
model step { box (-0.5 -0.5 0) (0.5 0.5 0.5) stone }
model post { box (-0.2 -0.2 0) (0.2 0.2 2) stone; collide cylinder 0.2 2 }
model globe { ball (0 0 0.4) 0.4 stone; collide sphere 0.4 0.4 }
dungeon turned 0x0101 at (60 60 0) {
    room hall turn 33 { box (0 0 0) (9 9 4); material stone }
    room wing turn 33 { box (9 3 0) (17 6 3.5); material stone }
    room north turn 90 at (-30 0 0) { box (0 0 0) (7 7 3); block { box (2 2 0) (4 4 0.4); material stone }; material stone }
    room tilted at (30 0 0) tilt 6 { box (0 0 0) (8 8 4); material stone }
    room rolled at (0 -30 0) roll 11 turn 20 { box (0 0 0) (8 8 4); material stone }
    room over at (30 -30 4) roll 180 { box (0 0 0) (8 8 4); material stone }
    opening hall wing
    static slab in hall at (2 3 0) turn 10
    static step in hall at (3.6 3.4 0) turn 45
    static post in hall at (0 6 0)
    static globe in wing at (7 9 0)
    static slab in north at (-33 3 0)
    static step in tilted at (34 3 0.4)
    static globe in tilted at (33 6 0.6)
}
start in turned hall at (2 4 0)
"#;

#[test]
fn shortcuts_change_nothing_in_rooms_at_odd_angles() {
    let compiled = vestibule_forge::compile_scene("turned.scene", TURNED).unwrap();
    compare("turned", &Pair::compiled(&compiled), 4000, Settings::default());
}

/// Keeps everybody out of what is watched over.
#[derive(Debug)]
struct Nobody;

impl EntryRestrictions for Nobody {
    fn may_enter(&self, _: Option<BodyId>, _: CellId, _: u32) -> bool {
        false
    }
}

#[test]
fn shortcuts_keep_players_out_of_rooms_that_are_watched_over() {
    let text = r#"
scene "Watched"
material stone blocks color 148 142 132
dungeon watched 0x0101 at (60 60 0) {
    room hall { box (0 0 0) (9 9 4); material stone }
    room wing { box (9 3 0) (17 6 4); material stone }
    opening hall wing
}
start in watched hall at (2 4 0)
"#;
    let compiled = vestibule_forge::compile_scene("watched.scene", text).unwrap();
    let mut records = compiled.memory_records();
    let rooms: Vec<(u32, Vec<u8>)> = records
        .iter()
        .filter(|&(store, id, _)| store == Store::Cell && (0x100..0xFFFE).contains(&(id & 0xFFFF)))
        .map(|(_, id, bytes)| (id, bytes.to_vec()))
        .collect();
    for (id, bytes) in &rooms {
        let mut room = EnvCell::parse(*id, bytes).unwrap();
        room.flags |= EnvCell::HAS_RESTRICTION;
        room.restriction = Some(7);
        records.insert(Store::Cell, *id, room.encode().unwrap());
    }
    let open = |settings| World::with_settings(records.clone(), settings).unwrap();
    let (quick, exact) = (open(WorldSettings::default()), open(EXACT));
    let mut population = Population::new();
    population.set_restrictions(Some(std::sync::Arc::new(Nobody)));
    let (mut a, mut b) = (Scratch::new(), Scratch::new());
    let mut draws = Draws(0x9E37_79B9_7F4A_7C15);
    let mut moved = 0;
    for i in 0..400 {
        // On the floor of the hall, out of everybody's way.
        let room = quick.env_cell(CellId(rooms[0].0)).unwrap();
        let bounds = room.structure.bounds.unwrap();
        let middle = (bounds.min + bounds.max) * 0.5;
        let at = middle.with_z(bounds.min.z + 0.005) + Vec3::new(draws.signed(), draws.signed(), 0.0);
        let at = Position::new(room.id, room.frame.local_to_global(at));
        let carried = Carried {
            contact: Some(ContactPlane {
                plane: Plane {
                    normal: Vec3::Z,
                    d: 0.005 - at.origin().z,
                },
                cell: at.cell,
                is_water: false,
            }),
            on_walkable: true,
            ..Carried::default()
        };
        let mut to = at;
        to.frame.origin += Vec3::new(draws.signed(), draws.signed(), 0.0) * 0.2;
        let mut mover = Mover::player();
        let is_player = i % 2 == 0;
        if is_player {
            mover.kind = ObjectKind::PLAYER;
        }
        let swept = sweep(&quick, &population, &mut a, &mover, &carried, &at, &to).unwrap();
        let by_rules = sweep(&exact, &population, &mut b, &mover, &carried, &at, &to).unwrap();
        assert_eq!(format!("{swept:?}"), format!("{by_rules:?}"), "{at:?} to {to:?}");
        let stays = swept.position.origin() == at.origin();
        assert!(stays || !is_player, "{at:?} to {to:?}");
        moved += u32::from(!stays);
    }
    assert!(moved > 100, "{moved}");
}

#[test]
fn shortcuts_change_nothing_in_a_cottage() {
    compare_vectors("cottage-1", 3000);
    compare_vectors("cottage-2", 1000);
}

#[test]
fn shortcuts_change_nothing_in_water_and_on_steep_ground() {
    for name in [
        "cottage-1-water",
        "cottage-1-sea",
        "cottage-1-steep4",
        "cottage-1-steep9",
    ] {
        compare_vectors(name, 500);
    }
}

#[test]
fn shortcuts_change_nothing_among_objects() {
    for name in [
        "cottage-1-cyl0",
        "cottage-1-sph2",
        "dungeon-1-cyl1",
        "dungeon-1-sph1",
        "maze-1-sph0",
    ] {
        compare_vectors(name, 500);
    }
}

#[test]
fn shortcuts_change_nothing_in_dungeons() {
    for name in ["dungeon-1", "dungeon-2", "gallery-1"] {
        compare_vectors(name, 2000);
    }
}

#[test]
fn shortcuts_change_nothing_in_mazes() {
    compare_vectors("maze-1", 1500);
    compare_vectors("maze-424", 1500);
}
