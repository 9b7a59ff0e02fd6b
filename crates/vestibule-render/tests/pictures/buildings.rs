//! Houses, cellars and the ground around them.

use crate::*;

#[test]
fn r7_holes_rooms_and_shells_in_the_order_of_distance() {
    let mut stage = village();
    let (rooms, oracle) = (Rooms::new(&stage), stage.oracle());
    let mut random = Random(3);
    for _ in 0..poses(30) {
        let camera = loop {
            let camera = mixed_camera(&stage, &rooms, &mut random, SMALL);
            if !camera.cell().is_indoor() {
                break camera;
            }
        };
        assert_eq!(wrong(&stage.ids(camera), &oracle, &camera), 0);
    }
}

#[test]
fn r8_a_sunken_shop_is_not_filled_with_grass() {
    let mut stage = village();
    let oracle = stage.oracle();
    let camera = before_shop((96, 96));
    let picture = stage.ids(camera);
    assert_eq!(wrong(&picture, &oracle, &camera), 0);
    let shop = CellId(0xA9B4_010E);
    assert!(picture.count_cell(shop) > 100);
    // Ground is drawn around the doorway, uncut.
    assert!(picture.count(PixelKind::Building) > 1000);
    let flat = without(&stage, |c| matches!(c, Command::Punch { .. }));
    let filled = ids_of(&stage, &flat);
    assert!(
        filled.count_cell(shop) < picture.count_cell(shop),
        "without the punch the ground stands in the doorway"
    );
    assert!(wrong(&filled, &oracle, &camera) > 0);
}

#[test]
fn r9_no_grass_in_the_shop_seen_from_inside_even_in_the_first_frame() {
    let mut stage = village();
    let oracle = stage.oracle();
    let camera = in_shop(SMALL);
    let first = stage.ids(camera);
    assert_eq!(wrong(&first, &oracle, &camera), 0);
    assert_eq!(first, stage.ids(camera), "the first frame is like the second");
    let kept = without(&stage, |c| matches!(c, Command::ClearDepth));
    assert!(ids_of(&stage, &kept).count(PixelKind::Terrain) > first.count(PixelKind::Terrain));
}

#[test]
fn r10_floors_at_ground_height_win() {
    assert_eq!(fights(&mut slab(), &RenderSettings::default()), 0);
}

#[test]
fn r11_a_room_and_its_rear_window_through_the_door() {
    let mut stage = village();
    let oracle = stage.oracle();
    // Through both doors of the barn.
    let camera = look(0xA9B4_001B, [72.0, 62.4, 95.6], [60.0, 60.0, 95.6], (96, 96));
    let picture = stage.ids(camera);
    assert_eq!(wrong(&picture, &oracle, &camera), 0);
    assert!(picture.count_cell(CellId(0xA9B4_010C)) > 50);
    let sees_through = picture
        .ids()
        .iter()
        .any(|id| id.kind() == PixelKind::Terrain && id.cell().is_some_and(|c| c.low() < 0x11));
    assert!(sees_through, "the land behind the barn shows through it");
    assert_eq!(picture.count(PixelKind::Background), 0);

    // Without its entry cell the door shows the land behind the house: neither hole nor room.
    let door = CellId(0xA9B4_010A);
    let mut stage = Stage::edited(VILLAGE, |records| {
        assert!(records.remove(vestibule_world::Store::Cell, door.0));
    });
    let closed = stage.ids(camera);
    let entry =
        |c: &Command| matches!(c, Command::Room { cell, .. } if (0x10A..=0x10C).contains(&cell.low()));
    assert!(
        !stage.frame.commands().iter().any(entry),
        "{:?}",
        stage.frame.look_ins().list()
    );
    assert_eq!(closed.count(PixelKind::Background), 0);
    assert!(closed.count(PixelKind::Terrain) > picture.count(PixelKind::Terrain));
}
