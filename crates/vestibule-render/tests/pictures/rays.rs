//! Pictures against the rays of the oracle.

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
