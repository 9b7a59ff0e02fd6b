//! Pictures against the rays of the oracle.

use vestibule_dat::record::EnvCell;
use vestibule_world::Store;

use crate::*;

#[test]
fn r10_5_pictures_equal_the_rays_that_walk_from_cell_to_cell() {
    let mut stages = vec![village()];
    stages.extend(
        ["cottage-1", "gallery-1"]
            .iter()
            .filter_map(|n| Stage::vectors(n)),
    );
    for mut stage in stages {
        let (rooms, oracle) = (Rooms::new(&stage), stage.oracle());
        let mut random = Random(0x2545_F491_4F6C_DD1D);
        let mut total = Difference::default();
        for _ in 0..poses(40) {
            let camera = mixed_camera(&stage, &rooms, &mut random, SMALL);
            let picture = stage.ids(camera);
            total.add(compare_with_oracle(
                &picture,
                &oracle,
                &camera,
                |x, y, shown, truth| {
                    panic!("{camera:?} ({x}, {y}) shows {shown:?}, rays meet {truth:?}");
                },
            ));
        }
        assert_eq!(total.unexplained(), 0);
        assert_eq!(total.clear, total.clear_disputed);
        assert!(
            total.at_edges + total.at_seams < total.pixels / 10_000,
            "{total:?}"
        );
    }
}

#[test]
fn r17_overlapping_rooms_show_only_inside_their_own_openings() {
    let Some(mut stage) = Stage::vectors("gallery-1") else {
        return;
    };
    let (rooms, oracle) = (Rooms::new(&stage), stage.oracle());
    let mut random = Random(23);
    let loose = RenderSettings {
        confine_overlaps: false,
        ..RenderSettings::default()
    };
    let (mut confined, mut wrong_loose) = (0, 0);
    for _ in 0..poses(60) {
        let (cell, eye) = rooms.eye(&stage, &mut random);
        let camera = camera(cell, eye, random.direction(), SMALL, 1.2);
        assert_eq!(wrong(&stage.ids(camera), &oracle, &camera), 0);
        let commands = stage.frame.commands();
        let settings = RenderSettings::default();
        confined += render_commands_ids(&stage.scene(), &stage.frame, commands, &settings)
            .unwrap()
            .1
            .confined;
        let picture = render_ids(&stage.scene(), &stage.frame, &loose).unwrap();
        wrong_loose += wrong(&picture, &oracle, &camera);
    }
    if confined > 0 {
        assert!(wrong_loose > 0, "{confined} confined rooms made no difference");
    }
}

#[test]
fn r18_a_room_of_another_house_through_a_door() {
    let mut stage = village();
    let oracle = stage.oracle();
    // From the barn through its east door to the shop's west door.
    let mut seen = 0;
    for k in 0..40 {
        let x = 58.0 + (k % 8) as f32;
        let y = 58.5 + (k / 8) as f32;
        let camera = look(0xA9B4_010C, [x, y, 95.6], [104.0, 84.0, 94.8], (160, 120));
        let picture = stage.ids(camera);
        assert_eq!(wrong(&picture, &oracle, &camera), 0);
        seen += picture.count_cell(CellId(0xA9B4_010D)) + picture.count_cell(CellId(0xA9B4_010E));
    }
    let looked_in = stage.frame.look_ins().list().len();
    assert!(seen > 0 || looked_in == 0, "{looked_in} looks, {seen} pixels");
}

#[test]
fn links_made_exact_leave_nothing_to_dispute() {
    // Where the two rooms of an inexact link draw their opening differently, the opening is what both have
    // (`visibility.md` 3.4); in the rest of a room's own opening nobody has a surface. That, not the traversal, is what
    // shows there: with the same links taken as exact, pictures and rays agree everywhere.
    let exact = Stage::vectors_edited("gallery-1", |records| {
        let cells: Vec<(u32, Vec<u8>)> = records
            .iter()
            .filter(|(store, id, _)| *store == Store::Cell && (0x0100..0xFFFE).contains(&(id & 0xFFFF)))
            .map(|(_, id, bytes)| (id, bytes.to_vec()))
            .collect();
        for (id, bytes) in cells {
            let mut cell = EnvCell::parse(id, &bytes).unwrap();
            for portal in &mut cell.portals {
                portal.flags |= 1;
            }
            records.insert(Store::Cell, id, cell.encode().unwrap());
        }
    });
    let (Some(mut exact), Some(mut stage)) = (exact, Stage::vectors("gallery-1")) else {
        return;
    };
    let (rooms, oracle, as_stored) = (Rooms::new(&stage), exact.oracle(), stage.oracle());
    let mut random = Random(0x2545_F491_4F6C_DD1D);
    let (mut total, mut stored) = (Difference::default(), Difference::default());
    for _ in 0..poses(60) {
        let camera = mixed_camera(&stage, &rooms, &mut random, SMALL);
        let picture = exact.ids(camera);
        total.add(compare_with_oracle(&picture, &oracle, &camera, |_, _, _, _| {}));
        let picture = stage.ids(camera);
        stored.add(compare_with_oracle(
            &picture,
            &as_stored,
            &camera,
            |_, _, _, _| {},
        ));
    }
    assert_eq!(
        (total.unexplained(), total.disputed, total.clear),
        (0, 0, 0),
        "{total:?}"
    );
    assert!(stored.disputed > 0 && stored.unexplained() == 0, "{stored:?}");
}
