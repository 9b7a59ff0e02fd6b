use super::*;
use vestibule_dat::DatSet;
use vestibule_physics::{Body, Locomotion, Motion, Placement, Population, Scratch};
use vestibule_world::World;

fn small() -> (Vec<u8>, Vec<u8>, SyntheticReport) {
    let mut calls = 0;
    let built = SyntheticWorld::small(7).build_into(Vec::new(), Vec::new(), &mut |p| {
        calls += 1;
        assert_eq!((p.done, p.all), (calls, 144));
    });
    built.expect("a small world")
}

#[test]
fn what_is_asked_for_is_there_and_loads_without_problems() {
    let (portal, cell, report) = small();
    assert_eq!(
        (report.landblocks, report.buildings, report.env_cells),
        (144, 40, 3_000)
    );
    assert_eq!(report.dungeons[0].1, 300);
    let world = World::open(DatSet::from_bytes(portal, cell).expect("files")).expect("a world");
    let (mut cells, mut buildings) = (0, 0);
    for x in 0..12 {
        for y in 0..12 {
            let block = world.block(BlockId::new(x, y)).expect("a landblock");
            cells += block.env_cells().count();
            buildings += block.buildings.len();
        }
    }
    assert_eq!((cells, buildings), (3_000, 40));
    assert_eq!(world.problems(), []);
}

#[test]
fn e3_proportions_are_retails() {
    let (.., report) = small();
    let per_cell = report.cell_portals as f64 / f64::from(report.env_cells);
    assert!((2.3..2.7).contains(&per_cell), "{per_cell} portals a cell");
    let per_building = f64::from(report.building_portals) / f64::from(report.buildings);
    assert!(
        (2.6..3.6).contains(&per_building),
        "{per_building} portals a building"
    );
    assert_eq!(u64::from(report.building_portals), report.portals_outside);
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let (a, b) = (small(), small());
    assert!(a.0 == b.0 && a.1 == b.1);
    let other = SyntheticWorld {
        seed: 8,
        ..SyntheticWorld::small(8)
    };
    let c = other
        .build_into(Vec::new(), Vec::new(), &mut |_| ())
        .expect("another world");
    assert!(a.1 != c.1);
}

#[test]
fn every_portal_leads_back_and_lies_where_its_opposite_lies() {
    let (portal, cell, report) = small();
    let world = World::open(DatSet::from_bytes(portal, cell).expect("files")).expect("a world");
    let blocks = report
        .dungeons
        .iter()
        .map(|d| d.0)
        .chain(report.towns.iter().copied());
    for block in blocks.map(CellId::block) {
        for cell in world.block(block).expect("a block").env_cells() {
            for (index, portal) in (0u16..).zip(&cell.portals) {
                let vestibule_world::PortalTarget::Cell(other) = portal.other else {
                    continue;
                };
                let other = world.env_cell(other).expect("a neighbour");
                let back = other
                    .portal(portal.other_portal.expect("a way back"))
                    .expect("it exists");
                assert_eq!(back.other, vestibule_world::PortalTarget::Cell(cell.id));
                assert_eq!(back.other_portal, Some(index));
                let place = |c: &vestibule_world::EnvCell, p| {
                    let vertices = c.portal_vertices(p);
                    let sum: glam::Vec3 = vertices.iter().map(|&v| c.frame.local_to_global(v)).sum();
                    sum / vertices.len() as f32
                };
                let apart = place(cell, portal).distance(place(other, back));
                assert!(apart < 0.01, "{} and {} are {apart} m apart", cell.id, other.id);
            }
        }
    }
}

/// Bodies that walk, and turn where they are stopped, get about, through doors and up ramps, and never fall.
#[test]
fn bodies_walk_through_dungeons_and_houses() {
    let (portal, cell, report) = small();
    let world = World::open(DatSet::from_bytes(portal, cell).expect("files")).expect("a world");
    for start in report
        .dungeons
        .iter()
        .take(6)
        .map(|d| d.0)
        .chain(report.towns.iter().take(6).copied())
    {
        let room = world.env_cell(start).expect("a first cell");
        let bounds = room.structure.bounds.expect("vertices");
        let middle = (bounds.min + bounds.max) * 0.5;
        let origin = room
            .frame
            .local_to_global(glam::Vec3::new(middle.x, middle.y, bounds.min.z + 0.01));
        let mut population = Population::new();
        let mut scratch = Scratch::new();
        let id = population.add(Body::player());
        let placed = population.set_position(
            &world,
            &mut scratch,
            id,
            &Placement::at(Position::new(start, origin)),
        );
        assert!(matches!(placed, Ok(Ok(_))), "{start}: {placed:?}");
        let body = population.body_mut(id).expect("the body");
        body.locomotion = Some(Locomotion::with_skills(100.0, 100.0));
        let mut seen = std::collections::BTreeSet::new();
        let mut draws = Draws::new(1, u64::from(start.0));
        let mut turn = 0.0f32;
        for step in 1..4_000 {
            let body = population.body_mut(id).expect("the body");
            body.set_motion(Motion {
                forward: 1.0,
                turn,
                run: true,
                ..Motion::default()
            });
            if draws.below(20) == 0 {
                turn = f32::from(draws.below(3) as u8) - 1.0;
            }
            population
                .update(&world, &mut scratch, id, f64::from(step) / 20.0)
                .expect("a step");
            let body = population.body(id).expect("the body");
            let cell = body
                .cell()
                .unwrap_or_else(|| panic!("lost after {step} steps from {start}"));
            seen.insert(cell);
            assert!(body.position().origin().z > -400.0, "fell from {start}");
        }
        assert!(
            seen.len() > 5 || report.dungeons.iter().any(|d| d.0 == start && d.1 < 8),
            "{start}: {seen:?}"
        );
    }
}
