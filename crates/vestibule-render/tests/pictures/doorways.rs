//! What shows through openings, and crossing them.

use crate::*;

#[test]
fn r4_openings_are_open() {
    for block in [DEEP, VILLAGE] {
        let mut stage = Stage::hollow(block).0;
        let cells: Vec<CellId> = stage
            .world
            .block(stage.block)
            .unwrap()
            .env_cells()
            .map(|c| c.id)
            .collect();
        let mut seen = 0;
        for id in cells {
            let cell = stage.world.env_cell(id).unwrap().clone();
            for portal in &cell.portals {
                let corners = cell.portal_vertices(portal);
                let middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
                let out = portal.plane.normal * if portal.interior_is_negative { 1.0 } else { -1.0 };
                let place = |p: Vec3| cell.frame.local_to_global(p);
                let (middle, eye) = (place(middle), place(middle - out * 0.3));
                if !cell.contains_point(eye) || out.z.abs() > 0.9 {
                    continue;
                }
                // An uneven picture has a pixel in its middle.
                let camera = camera(id, eye, middle - eye, (33, 33), 0.3);
                let shown = stage.ids(camera).get(16, 16).unwrap();
                let beyond = match portal.other {
                    PortalTarget::Outside => shown.kind() != PixelKind::Room,
                    PortalTarget::Cell(_) => shown.cell() != Some(id) || shown.kind() == PixelKind::Object,
                };
                assert!(beyond, "{id} {:?} shows {shown:?}", portal.other);
                seen += 1;
            }
        }
        assert!(seen >= 18, "{seen}");
    }
}

#[test]
fn r6_the_landscape_shows_exactly_through_exits() {
    let mut stage = village();
    let oracle = stage.oracle();
    let exit_plane = 16.11;
    for before in [2.0, 0.5, 0.09, 0.02] {
        for turn in [-0.6f32, 0.0, 0.5] {
            let y = exit_plane - before;
            let cell = if y > 15.16 { 0xA9B4_0100 } else { 0xA9B4_0101 };
            let camera = look(
                cell,
                [155.4, y, 95.3],
                [155.4 + turn * 10.0, y + 10.0, 95.0],
                SMALL,
            );
            let picture = stage.ids(camera);
            assert_eq!(wrong(&picture, &oracle, &camera), 0, "{before} m before the exit");
        }
    }
    // A window behind which another room of the house stands.
    let (mut hook, side) = hook();
    let oracle = hook.oracle();
    let camera = look(HOOK_CAMERA.0, HOOK_CAMERA.1, HOOK_CAMERA.2, (96, 72));
    let picture = hook.ids(camera);
    assert_eq!(wrong(&picture, &oracle, &camera), 0);
    assert!(picture.count_cell(side) > 100 && picture.count(PixelKind::Building) > 100);
}

#[test]
fn r13_objects_in_doorways_show_on_both_sides_and_nowhere_else() {
    let mut stage = village();
    let oracle = stage.oracle();
    // The door leaf of the cottage.
    let inside = in_cottage(SMALL);
    let outside = before_cottage(SMALL);
    for camera in [inside, outside] {
        let picture = stage.ids(camera);
        assert_eq!(wrong(&picture, &oracle, &camera), 0);
        let objects = |i: &IdImage| i.count(PixelKind::Object);
        let none = without(
            &stage,
            |c| matches!(c, Command::Object { cell, .. } if cell.is_indoor()),
        );
        assert!(objects(&ids_of(&stage, &none)) < objects(&picture));
    }
    // From the cellar nothing of the hall shows through the wall.
    let cellar = look(0xA9B4_0107, [150.5, 6.5, 93.0], [155.4, 12.0, 95.0], SMALL);
    let picture = stage.ids(cellar);
    assert!(
        picture
            .ids()
            .iter()
            .all(|id| id.cell() != Some(CellId(0xA9B4_0101)))
    );
    // Broken: objects drawn because they are near, in front of the depth of everything.
    let mut naive = stage.frame.commands().to_vec();
    naive.push(Command::ClearDepth);
    let hall = stage.world.statics_in(CellId(0xA9B4_0101)).to_vec();
    let views = naive.iter().find_map(|c| match c {
        Command::Room { views, .. } => Some(*views),
        _ => None,
    });
    naive.extend(hall.iter().map(|&r| Command::Object {
        id: ObjectRef::Static(r),
        cell: CellId(0xA9B4_0101),
        views: views.unwrap(),
    }));
    assert!(compare(&ids_of(&stage, &naive), &picture).differing > 0);
}

#[test]
fn r14_crossing_a_door_in_tenths_of_millimetres_changes_nothing_at_once() {
    let mut stage = Stage::hollow(DEEP).0;
    // From the gallery into the court, at x = 70.
    let step = |stage: &mut Stage, x: f32| {
        let cell = if x < 70.0 { 0x0107_0101 } else { 0x0107_0102 };
        let camera = look(cell, [x, -80.1, -18.3], [x + 10.0, -79.5, -18.5], (96, 72));
        stage.ids(camera)
    };
    let mut places: Vec<f32> = (-50..50).map(|k| 70.0 + k as f32 * 0.01).collect();
    places.extend((-20..=20).map(|k| 70.0 + k as f32 * 1.0e-4));
    places.sort_by(f32::total_cmp);
    let mut before: Option<IdImage> = None;
    for x in places {
        let picture = step(&mut stage, x);
        assert_eq!(picture.count(PixelKind::Background), 0, "{x}");
        if let Some(before) = &before {
            assert!(
                changed(before, &picture) < 0.01,
                "{x}: {}",
                changed(before, &picture)
            );
        }
        before = Some(picture);
    }
    // Broken: on the plane the neighbour is lost.
    let mut settings = *stage.frame.settings();
    settings.flood.admit_on_plane = false;
    settings.flood.guard_wrong_cell = false;
    stage.frame = FrameView::new(settings);
    let on_plane = look(0x0107_0101, [70.0, -80.1, -18.3], [80.0, -79.5, -18.5], (96, 72));
    assert!(stage.ids(on_plane).count(PixelKind::Background) > 1000);
}
