//! Rooms that see nothing of the outside.

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
