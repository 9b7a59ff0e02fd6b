//! Simulations come out the same whatever the number of threads and the order in which bodies are added.

use vestibule_bench::crowd;
use vestibule_dat::DatSet;
use vestibule_forge::synthetic::SyntheticWorld;
use vestibule_physics::{Placement, Population, Scratch, Simulation};
use vestibule_world::{CellId, Position, World};

/// Three bodies in each of the first rooms of the largest dungeon: they cannot but meet.
fn crowded() -> (World, Vec<Position>) {
    let built = SyntheticWorld::small(3).build_into(Vec::new(), Vec::new(), &mut |_| ());
    let (portal, cell, report) = built.expect("a world");
    let world = World::open(DatSet::from_bytes(portal, cell).expect("files")).expect("a world");
    let first = report.dungeons[0].0;
    let mut places = Vec::new();
    for k in 0..90u32 {
        let mut place = crowd::in_the_room(&world, CellId(first.0 + k / 3)).expect("a room");
        place.frame.origin += glam::Vec3::new((k % 3) as f32 * 1.5 - 1.5, 0.0, 0.3);
        places.push(place);
    }
    (world, places)
}

fn run(world: &World, simulation: &mut Simulation, ticks: u64) -> (u64, usize) {
    let mut again = 0;
    for tick in 0..ticks {
        crowd::direct(simulation, tick);
        again += simulation.step(world, 0.05).again;
    }
    (simulation.hash(), again)
}

#[test]
fn the_outcome_does_not_depend_on_the_number_of_threads() {
    let (world, places) = crowded();
    let mut outcomes = Vec::new();
    for threads in [1, 2, 3, 7] {
        let mut simulation = Simulation::new(threads);
        crowd::populate(&mut simulation, &places);
        outcomes.push(run(&world, &mut simulation, 200));
    }
    assert!(outcomes[0].1 > 0, "no two bodies met: the test shows nothing");
    assert!(outcomes.windows(2).all(|w| w[0] == w[1]), "{outcomes:x?}");
}

#[test]
fn the_outcome_does_not_depend_on_the_order_of_adding() {
    let (world, places) = crowded();
    let mut outcomes = Vec::new();
    for order in 0..3 {
        let mut simulation = Simulation::new(2);
        let mut keyed: Vec<(u64, Position)> = (0u64..).zip(places.iter().copied()).collect();
        match order {
            1 => keyed.reverse(),
            2 => keyed.rotate_left(37),
            _ => {}
        }
        for (key, place) in keyed {
            simulation.add(key, crowd::walker(), Placement::at(place));
        }
        outcomes.push(run(&world, &mut simulation, 100).0);
    }
    assert!(outcomes.windows(2).all(|w| w[0] == w[1]), "{outcomes:x?}");
}

/// The parallel step is that of one body after the other in the order of their keys, apart from all of them being
/// integrated first, which makes no difference to bodies that do not push each other.
#[test]
fn a_step_is_one_body_after_the_other() {
    let (world, places) = crowded();
    let mut simulation = Simulation::new(2);
    crowd::populate(&mut simulation, &places);
    let mut population = Population::new();
    let mut scratch = Scratch::new();
    let ids: Vec<_> = places
        .iter()
        .map(|place| {
            let id = population.add(crowd::walker());
            let placed = population.set_position(&world, &mut scratch, id, &Placement::at(*place));
            assert!(placed.is_ok());
            id
        })
        .collect();
    for tick in 0..100u64 {
        crowd::direct(&mut simulation, tick);
        simulation.step(&world, 0.05);
        for (key, &id) in (0u64..).zip(&ids) {
            let motion = simulation.body(key).and_then(|b| b.locomotion).map(|l| l.motion);
            population
                .body_mut(id)
                .expect("a body")
                .set_motion(motion.expect("legs"));
            population
                .update(&world, &mut scratch, id, simulation.now())
                .expect("a step");
        }
        for (key, &id) in (0u64..).zip(&ids) {
            let (a, b) = (
                simulation.body(key).expect("a body"),
                population.body(id).expect("a body"),
            );
            assert_eq!(a.position(), b.position(), "body {key} after tick {tick}");
            assert_eq!(a.cell(), b.cell());
        }
    }
}

#[test]
fn bodies_leave_when_told_and_keys_can_be_used_again() {
    let (world, places) = crowded();
    let mut simulation = Simulation::new(1);
    crowd::populate(&mut simulation, &places[..5]);
    simulation.step(&world, 0.05);
    assert_eq!(simulation.len(), 5);
    simulation.remove(3);
    simulation.add(1, crowd::walker(), Placement::at(places[20]));
    simulation.step(&world, 0.05);
    assert_eq!(simulation.len(), 4);
    assert!(simulation.body(3).is_none());
    assert_eq!(simulation.body(1).and_then(|b| b.cell()), Some(places[20].cell));
}
