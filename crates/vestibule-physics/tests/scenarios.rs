//! Scenarios of `transition.md` 10.2 and `study.md` D16 in the worlds of the vectors, when present.

mod common;

use common::*;
use glam::Vec3;
use vestibule_physics::{
    Body, Carried, Motion, Mover, Placed, Placement, Population, Scratch, SetPositionFlags, Swept, sweep,
    viewer_mover,
};
use vestibule_world::{CellId, Position, World};

/// A player that stands where a bench body starts.
struct Walk<'w> {
    world: &'w World,
    population: Population,
    scratch: Scratch,
    mover: Mover,
    at: Position,
    carried: Carried,
}

impl<'w> Walk<'w> {
    fn new(world: &'w World, at: Position) -> Self {
        Walk {
            world,
            population: Population::new(),
            scratch: Scratch::new(),
            mover: Mover::player(),
            at,
            carried: Carried::default(),
        }
    }

    fn step(&mut self, by: Vec3) -> Swept {
        let mut to = self.at;
        to.frame.origin += by;
        let swept = sweep(
            self.world,
            &self.population,
            &mut self.scratch,
            &self.mover,
            &self.carried,
            &self.at,
            &to,
        )
        .unwrap();
        if let (true, Some(cell)) = (swept.ok, swept.cell) {
            self.at = Position {
                cell,
                ..swept.position
            };
            self.carried = swept.carried();
        }
        swept
    }

    /// Falls until it stands.
    fn settle(&mut self) {
        for _ in 0..100 {
            if self.carried.on_walkable {
                return;
            }
            self.step(Vec3::new(0.0, 0.0, -0.1));
        }
        panic!("no ground");
    }
}

/// The cottage's doorway: outdoors at y < 79, the vestibule 0x100 from 79 to 79.6, the room 0x101 beyond.
const DOOR: Vec3 = Vec3::new(84.0, 79.0, 40.1);

fn outside_the_door() -> Position {
    let p = Vec3::new(DOOR.x, DOOR.y - 1.5, DOOR.z + 0.5);
    // World ids: landblock 0xA9B4 of the vectors' cottage.
    let block = 0xA9B4_0000;
    CellId(block | 0xFFFF)
        .adjust_to_outside(p)
        .map(|(cell, origin)| Position::new(cell, origin))
        .unwrap()
}

#[test]
fn s2_and_s5_a_doorway_is_crossed_once_each_way() {
    let Some(world) = open_world("cottage-1") else {
        return;
    };
    let mut walk = Walk::new(&world, outside_the_door());
    walk.settle();
    let mut cells = vec![walk.at.cell];
    let mut heights = Vec::new();
    for dy in [0.05f32, -0.05] {
        for _ in 0..60 {
            walk.step(Vec3::new(0.0, dy, 0.0));
            if cells.last() != Some(&walk.at.cell) {
                cells.push(walk.at.cell);
                heights.push(walk.at.origin().y);
            }
        }
    }
    let land = cells[0];
    assert!(!land.is_indoor());
    let door = CellId::new(land.block(), 0x100);
    let room = CellId::new(land.block(), 0x101);
    assert_eq!(cells, [land, door, room, door, land], "{heights:?}");
    // The frame in which the foot's centre is across, to within a step and the tolerance of the cell BSP.
    for (y, at) in heights.iter().zip([79.0, 79.6, 79.6, 79.0]) {
        assert!((y - at).abs() < 0.06, "{y} {at}");
    }
}

#[test]
fn s1_and_d16_1_standing_in_a_doorway_never_changes_the_cell() {
    let Some(world) = open_world("cottage-1") else {
        return;
    };
    let mut walk = Walk::new(&world, outside_the_door());
    walk.settle();
    while walk.at.origin().y < DOOR.y + 0.08 {
        walk.step(Vec3::new(0.0, 0.04, 0.0));
    }
    let at = walk.at;
    assert!(at.cell.is_indoor());
    for _ in 0..600 {
        let swept = walk.step(Vec3::ZERO);
        assert_eq!((swept.ok, swept.cell, walk.at), (true, Some(at.cell), at));
    }
}

#[test]
fn s3_and_d16_3_pushing_against_a_wall_beside_a_portal_is_stable() {
    let Some(world) = open_world("cottage-1") else {
        return;
    };
    let mut walk = Walk::new(&world, outside_the_door());
    walk.settle();
    while walk.at.origin().y < DOOR.y + 0.3 {
        walk.step(Vec3::new(0.0, 0.05, 0.0));
    }
    // Into the side of the door frame.
    for _ in 0..20 {
        walk.step(Vec3::new(0.2, 0.0, 0.0));
    }
    let at = walk.at;
    for _ in 0..600 {
        walk.step(Vec3::new(0.2, 0.0, 0.0));
        assert_eq!(walk.at.cell, at.cell);
        assert!((walk.at.origin() - at.origin()).length() < 1e-3);
    }
}

#[test]
fn s4_a_sealed_dungeon_never_lists_a_land_cell() {
    let Some(world) = open_world("dungeon-1") else {
        return;
    };
    let mut walk = Walk::new(
        &world,
        Position::new(CellId(30_998_784), Vec3::new(16.0, 36.0, 13.0)),
    );
    walk.settle();
    for i in 0..400 {
        let angle = i as f32 * 0.37;
        walk.step(Vec3::new(libm::cosf(angle) * 0.3, libm::sinf(angle) * 0.3, 0.0));
        assert!(walk.scratch.cells().iter().all(|c| c.id.is_indoor()));
        assert!(walk.at.cell.is_indoor());
    }
}

#[test]
fn s6_and_d16_6_a_placement_can_keep_to_visible_cells() {
    let Some(world) = open_world("cottage-1") else {
        return;
    };
    let block = world.block(outside_the_door().cell.block()).unwrap();
    let mut tested = 0;
    for cell in block.env_cells() {
        for stab_free in [true, false] {
            let mut population = Population::new();
            let mut scratch = Scratch::new();
            let id = population.add(Body::player());
            let center = cell.frame.origin + Vec3::new(0.0, 0.0, 0.3);
            let mut flags = SetPositionFlags::PLACEMENT | SetPositionFlags::SLIDE;
            flags.set(SetPositionFlags::DONOTCREATECELLS, stab_free);
            let placement = Placement::at(Position::new(cell.id, center)).with_flags(flags);
            let placed = population
                .set_position(&world, &mut scratch, id, &placement)
                .unwrap();
            let Ok(Placed::InCell(_)) = placed else { continue };
            let body = population.body(id).unwrap();
            if stab_free {
                let own = body.position().cell;
                let seen = &world
                    .env_cell(own)
                    .map(|c| c.stab_list.clone())
                    .unwrap_or_default();
                for shadow in body.shadow_cells() {
                    assert!(!own.is_indoor() || *shadow == own || seen.contains(shadow));
                }
            }
            tested += 1;
        }
    }
    assert!(tested > 0);
}

#[test]
fn s7_the_camera_has_its_own_cell() {
    let Some(world) = open_world("cottage-1") else {
        return;
    };
    let mut walk = Walk::new(&world, outside_the_door());
    walk.settle();
    while walk.at.origin().y < DOOR.y + 1.5 {
        walk.step(Vec3::new(0.0, 0.05, 0.0));
    }
    let room = walk.at.cell;
    assert!(room.is_indoor());
    let mut pivot = walk.at;
    pivot.frame.origin.z += 1.5;
    let camera = viewer_mover(&walk.mover);
    // Back through the doorway, level: outdoors. A little: still in the room.
    let mut see = |by: Vec3| {
        let mut sought = pivot;
        sought.frame.origin += by;
        let state = Carried::default();
        sweep(
            &world,
            &walk.population,
            &mut walk.scratch,
            &camera,
            &state,
            &pivot,
            &sought,
        )
        .unwrap()
    };
    let near = see(Vec3::new(0.0, -0.3, 0.0));
    assert_eq!((near.ok, near.cell), (true, Some(room)));
    let far = see(Vec3::new(0.0, -3.0, 0.0));
    let cell = far.cell.unwrap();
    assert!(!cell.is_indoor() && cell != room, "{far:?}");
    // Into the ground it stops above it.
    let down = see(Vec3::new(0.0, 0.0, -5.0));
    assert!(down.position.origin().z > walk.at.origin().z + 0.25, "{down:?}");
}

#[test]
fn a_player_walks_in_by_input_and_is_saved_and_restored_whole() {
    let Some(world) = open_world("cottage-1") else {
        return;
    };
    let mut population = Population::new();
    let mut scratch = Scratch::new();
    let player = population.add(Body::player());
    let placed = population.set_position(&world, &mut scratch, player, &Placement::at(outside_the_door()));
    assert!(matches!(placed, Ok(Ok(Placed::InCell(_)))), "{placed:?}");
    let body = population.body_mut(player).unwrap();
    body.set_motion(Motion {
        forward: 1.0,
        ..Motion::default()
    });
    let mut now = 0.0;
    for _ in 0..20 {
        now += 0.034;
        population.update(&world, &mut scratch, player, now).unwrap();
    }
    let body = population.body(player).unwrap();
    assert!(
        body.is_on_walkable() && body.cell().unwrap().is_indoor(),
        "{}",
        body.position()
    );
    assert_eq!(population.objects_in(body.cell().unwrap()), [player]);
    // The same from here on, restored or not.
    let saved = population.save();
    let mut twin = Population::restore(&saved, |_| None).unwrap();
    assert_eq!(twin.save(), saved);
    population.body_mut(player).unwrap().jump(0.5, now);
    twin.body_mut(player).unwrap().jump(0.5, now);
    for _ in 0..60 {
        now += 0.034;
        population.update(&world, &mut scratch, player, now).unwrap();
        twin.update(&world, &mut scratch, player, now).unwrap();
    }
    assert_eq!(population.save(), twin.save());
    assert!(population.body(player).unwrap().is_on_walkable());
}

#[test]
fn bodies_stand_in_each_others_way_until_one_opens() {
    let Some(world) = open_world("cottage-1") else {
        return;
    };
    let mut population = Population::new();
    let mut scratch = Scratch::new();
    let at = outside_the_door();
    let mut beside = at;
    beside.frame.origin.x += 1.5;
    let walker = population.add(Body::player());
    let mut post = Body::player();
    post.kind = vestibule_physics::ObjectKind::HAS_GAME_OBJECT;
    post.locomotion = None;
    let post = population.add(post);
    for (id, at) in [(walker, at), (post, beside)] {
        let placed = population
            .set_position(&world, &mut scratch, id, &Placement::at(at))
            .unwrap();
        assert!(matches!(placed, Ok(Placed::InCell(_))));
    }
    let walk = |population: &mut Population, scratch: &mut Scratch| {
        for _ in 0..10 {
            let mut to = *population.body(walker).unwrap().position();
            to.frame.origin.x += 0.2;
            population.move_to(&world, scratch, walker, &to).unwrap();
        }
        population.distance(walker, post).unwrap()
    };
    let blocked = walk(&mut population, &mut scratch);
    assert!((0.9..1.2).contains(&blocked), "{blocked}");
    assert!(population.set_ethereal(&world, &mut scratch, post, true));
    // Pressing on along the same wall moves nothing, open or not: the slide remembers it. A step back forgets it.
    let mut back = *population.body(walker).unwrap().position();
    back.frame.origin.x -= 0.1;
    population.move_to(&world, &mut scratch, walker, &back).unwrap();
    let through = walk(&mut population, &mut scratch);
    assert!(
        through < 2.0 && population.body(walker).unwrap().position().origin().x > beside.origin().x - 0.1
    );
    // It cannot close on the walker, but does once the way is free.
    let mut inside = *population.body(post).unwrap().position();
    inside.frame.origin.z += 0.01;
    population.force_into_cell(&world, &mut scratch, walker, &inside);
    assert!(!population.set_ethereal(&world, &mut scratch, post, false));
    population.remove(walker);
    assert!(population.set_ethereal(&world, &mut scratch, post, false));
}
