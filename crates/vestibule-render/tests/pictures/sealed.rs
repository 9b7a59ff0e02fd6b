//! Rooms that see nothing of the outside.

use vestibule_view::{PIVOT_OFFSET, ViewerTarget, update_viewer};

use crate::*;

#[test]
fn r1_rooms_by_traversal_equal_rooms_by_depth_alone() {
    let (mut mine, names) = Stage::hollow(VILLAGE);
    let inner: BTreeSet<CellId> = names
        .iter()
        .filter(|(id, n)| n.starts_with("mine") && mine.world.env_cell(**id).is_some_and(|c| !c.seen_outside))
        .map(|(id, _)| *id)
        .collect();
    let rooms = Rooms::only(&mine, |id| inner.contains(&id));
    let mut stages = vec![(Stage::hollow(DEEP).0, None)];
    stages.extend(
        ["dungeon-1", "maze-1"]
            .iter()
            .filter_map(|n| Some((Stage::vectors(n)?, None))),
    );
    stages.push((
        std::mem::replace(&mut mine, Stage::hollow(VILLAGE).0),
        Some(rooms),
    ));
    for (mut stage, rooms) in stages {
        let rooms = rooms.unwrap_or_else(|| Rooms::new(&stage));
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        let mut total = Difference::default();
        let mut broken = 0;
        for _ in 0..poses(40) {
            let (cell, eye) = rooms.eye(&stage, &mut random);
            let camera = camera(cell, eye, random.direction(), SMALL, 1.2);
            let all = stage.everything(&camera);
            total.add(compare(&stage.ids(camera), &all));
            // The room the eye is in is the last to be drawn: without it, the pictures differ.
            let root = stage.frame.camera().unwrap().cell();
            let cut = without(
                &stage,
                |c| matches!(c, Command::Room { cell, .. } if *cell == root),
            );
            broken += usize::from(compare(&ids_of(&stage, &cut), &all).differing > 0);
        }
        assert_eq!((total.differing, total.clear), (0, 0), "block {:?}", stage.block);
        assert!(broken * 2 > poses(40), "a missing room shows");
    }
}

#[test]
fn r2_sealed_rooms_draw_nothing_of_the_outside() {
    let mut stage = Stage::hollow(DEEP).0;
    let rooms = Rooms::new(&stage);
    let mut random = Random(7);
    for _ in 0..poses(60) {
        let (cell, eye) = rooms.eye(&stage, &mut random);
        stage.update(camera(cell, eye, random.direction(), SMALL, 1.2));
        let outside = |c: &Command| match c {
            Command::Sky
            | Command::Terrain(_)
            | Command::TerrainBlock { .. }
            | Command::Building { .. }
            | Command::Weather
            | Command::Punch { .. }
            | Command::Seal { .. } => true,
            Command::Object { cell, .. } => !cell.is_indoor(),
            _ => false,
        };
        assert!(!stage.frame.commands().iter().any(outside));
        assert_eq!(stage.frame.path(), FramePath::Sealed);
    }
}

#[test]
fn r3_no_clear_colour_in_sealed_rooms() {
    let mut stage = Stage::hollow(DEEP).0;
    let rooms = Rooms::new(&stage);
    let mut random = Random(11);
    let mut holes = 0;
    for _ in 0..poses(60) {
        let (cell, eye) = rooms.eye(&stage, &mut random);
        let camera = camera(cell, eye, random.direction(), SMALL, 1.2);
        let picture = stage.ids(camera);
        assert_eq!(picture.count(PixelKind::Background), 0, "{camera:?}");
        // A neighbour that is not drawn is a hole in the doorway.
        let root = camera.cell();
        let cut = without(
            &stage,
            |c| matches!(c, Command::Room { cell, .. } if *cell != root),
        );
        holes += ids_of(&stage, &cut).count(PixelKind::Background);
    }
    assert!(holes > 0);
}

/// The frame of a player who stands somewhere, seen by a camera behind it.
fn stand(stage: &mut Stage, cell: CellId, feet: Vec3, behind: Vec3) -> Option<IdImage> {
    let target = ViewerTarget::at(Position::new(cell, feet));
    let mut sought = target.position;
    sought.frame.origin += PIVOT_OFFSET + behind;
    let (population, mut scratch) = (Population::new(), Scratch::default());
    let viewer = update_viewer(
        &stage.world,
        &population,
        &mut scratch,
        &target,
        PIVOT_OFFSET,
        &sought,
    );
    let at = viewer.cell?.0;
    Some(stage.ids(camera(at, viewer.position.frame.origin, -behind, SMALL, 1.2)))
}

#[test]
fn study_test_4_a_player_in_a_dungeon_is_shown_no_terrain() {
    let mut stage = Stage::hollow(DEEP).0;
    let cells: Vec<_> = stage
        .world
        .block(stage.block)
        .unwrap()
        .env_cells()
        .map(|c| (c.id, c.frame, c.seen_outside, c.structure.bounds.unwrap()))
        .collect();
    let mut seen = 0;
    for (id, frame, seen_outside, bounds) in cells {
        assert!(!seen_outside);
        let middle = (bounds.min + bounds.max) * 0.5;
        let feet = frame.local_to_global(Vec3::new(middle.x, middle.y, bounds.min.z + 0.01));
        for turn in 0..8 {
            let (s, c) = libm::sincosf(turn as f32 * core::f32::consts::TAU / 8.0);
            let Some(picture) = stand(&mut stage, id, feet, Vec3::new(s * 2.0, c * 2.0, 0.6)) else {
                continue;
            };
            seen += 1;
            assert!(!stage.frame.draws_landscape());
            assert_eq!(
                picture.count(PixelKind::Terrain) + picture.count(PixelKind::Sky),
                0
            );
        }
    }
    assert!(seen >= 72, "{seen}");
}

#[test]
fn study_test_5_a_player_behind_an_exit_is_shown_terrain_clipped_to_it() {
    let mut stage = village();
    let oracle = stage.oracle();
    let hall = CellId(0xA9B4_0101);
    assert!(stage.world.env_cell(hall).unwrap().seen_outside);
    let feet = Vec3::new(155.4, 13.6, 94.0);
    // Looking out of the door.
    let picture = stand(&mut stage, hall, feet, Vec3::new(0.0, -1.0, 0.2)).unwrap();
    assert!(stage.frame.draws_landscape());
    assert!(picture.count(PixelKind::Terrain) > 100);
    let camera = *stage.frame.camera().unwrap();
    assert!(camera.cell().is_indoor());
    assert_eq!(wrong(&picture, &oracle, &camera), 0);
    // Every pixel of it lies inside a region of the outside, or on its border.
    for y in 0..SMALL.1 {
        for x in 0..SMALL.0 {
            if picture.get(x, y).unwrap().kind() != PixelKind::Terrain {
                continue;
            }
            let ray = camera.ray_through(glam::Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
            let shown = stage
                .frame
                .landscape_views()
                .any(|r| r.edges().iter().all(|e| e.normal.dot(ray) >= -0.03));
            assert!(shown, "({x}, {y})");
        }
    }
    // Looking the other way there is no terrain, though the room is the same.
    let picture = stand(&mut stage, hall, feet, Vec3::new(0.0, 1.0, 0.2)).unwrap();
    assert_eq!(picture.count(PixelKind::Terrain), 0);
}
