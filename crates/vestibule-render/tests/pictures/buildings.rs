//! Houses, cellars and the ground around them.

use crate::*;

#[test]
fn r7_holes_rooms_and_shells_in_the_order_of_distance() {
    let mut stage = village();
    let (rooms, oracle) = (Rooms::new(&stage), stage.oracle());
    let mut random = Random(3);
    let (mut late_punches, mut early_shells, mut cleared) = (0, 0, 0);
    for _ in 0..poses(60) {
        let camera = loop {
            let camera = mixed_camera(&stage, &rooms, &mut random, SMALL);
            if !camera.cell().is_indoor() {
                break camera;
            }
        };
        assert_eq!(wrong(&stage.ids(camera), &oracle, &camera), 0);
        let is_shell = |c: &Command| matches!(c, Command::Building { .. });
        // One punch pass for all buildings after the whole world, rooms after it: they show through walls.
        let rooms_or_holes = |c: &Command| matches!(c, Command::Punch { .. } | Command::Room { .. });
        let mut late = without(&stage, rooms_or_holes);
        late.extend(
            stage
                .frame
                .commands()
                .iter()
                .filter(|c| matches!(c, Command::Punch { .. })),
        );
        late.extend(
            stage
                .frame
                .commands()
                .iter()
                .filter(|c| matches!(c, Command::Room { .. })),
        );
        late_punches += wrong(&ids_of(&stage, &late), &oracle, &camera);
        // All shells first: nothing closes the rooms in front.
        let mut shells: Vec<Command> = stage
            .frame
            .commands()
            .iter()
            .filter(|c| is_shell(c))
            .copied()
            .collect();
        shells.extend(without(&stage, is_shell));
        early_shells += wrong(&ids_of(&stage, &shells), &oracle, &camera);
        // Depth cleared before every room, as for an interior: cellars show through hills and roofs.
        let clear = stage.frame.commands().iter().flat_map(|c| match c {
            Command::Room { .. } => vec![Command::ClearDepth, *c],
            _ => vec![*c],
        });
        cleared += wrong(&ids_of(&stage, &clear.collect::<Vec<_>>()), &oracle, &camera);
    }
    assert!(
        late_punches > 0 && early_shells > 0 && cleared > 0,
        "{late_punches} {early_shells} {cleared}"
    );
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
    let compiled = vestibule_forge::compile_scene(
        "floor",
        "scene \"floor\"\nland 0xA9B4 0xA9B4 origin 0xA9B4\nheights 1\nstart at (20 20 ~0)\n\
         terrain { base 94; paint grassland everywhere }\n\
         material boards planks color 148 110 70 second 78 54 34 size 1.6\n\
         model slab { box (-6 -6 -0.5) (6 6 0); material boards }\nstatic slab at (72 72 94)\n",
    )
    .unwrap();
    let world = vestibule_world::World::open(compiled.memory_records()).unwrap();
    let mut stage = Stage::new(world, vestibule_world::BlockId(0xA9B4));
    let mut random = Random(17);
    let flat = RenderSettings {
        terrain_offset: 0.0,
        ..RenderSettings::default()
    };
    let (mut lost, mut fought) = (0, 0);
    for _ in 0..100 {
        let turn = random.between(0.0, core::f32::consts::TAU);
        let reach = random.between(8.0, 40.0);
        let (s, c) = libm::sincosf(turn);
        let eye = Vec3::new(
            72.0 + s * reach,
            72.0 + c * reach,
            94.0 + random.between(0.5, 6.0),
        );
        let cell = stage.world.ground_at(CellId(0xA9B4_0001), eye).unwrap().cell;
        let camera = camera(cell, eye, Vec3::new(72.0, 72.0, 94.0) - eye, SMALL, 1.0);
        let picture = stage.ids(camera);
        let fights = render_ids(&stage.scene(), &stage.frame, &flat).unwrap();
        for y in 0..SMALL.1 {
            for x in 0..SMALL.0 {
                let ray = camera.ray_through(glam::Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
                let on = eye + ray * ((94.0 - eye.z) / ray.z);
                let inside = ray.z < 0.0 && (on.x - 72.0).abs() < 5.9 && (on.y - 72.0).abs() < 5.9;
                if inside {
                    lost += usize::from(picture.get(x, y).unwrap().kind() == PixelKind::Terrain);
                    fought += usize::from(fights.get(x, y).unwrap().kind() == PixelKind::Terrain);
                }
            }
        }
    }
    assert_eq!(lost, 0);
    assert!(fought > 0, "without the offset ground and floor fight");
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
}
