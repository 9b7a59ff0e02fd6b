//! The rules of the pictures, each with the defect that appears when it is broken (`rendering.md` 18, 19).
//!
//! `VESTIBULE_POSES` sets how many random poses the comparisons take (the default is small).

mod common;

use std::collections::BTreeSet;

use common::{Difference, Random, Rooms, Stage, camera, compare, compare_with_oracle, mixed_camera};
use glam::Vec3;
use vestibule_physics::{Body, ObjectRef, Population, Scratch};
use vestibule_render::{
    IdImage, Oracle, PixelKind, RenderSettings, Scene, render, render_commands, render_commands_ids,
    render_ids,
};
use vestibule_view::{
    Camera, Command, FrameInput, FramePath, FrameView, PlayerCell, ViewerCell, WorldObjects,
};
use vestibule_world::{CellId, Frame, PortalTarget, Position};

const VILLAGE: u16 = 0xA9B4;
const DEEP: u16 = 0x0107;
const SMALL: (u32, u32) = (64, 48);

fn poses(default: usize) -> usize {
    let set = std::env::var("VESTIBULE_POSES").ok();
    set.and_then(|v| v.parse().ok()).unwrap_or(default)
}

fn village() -> Stage {
    Stage::hollow(VILLAGE).0
}

/// The id picture of other commands than the frame's own.
fn ids_of(stage: &Stage, commands: &[Command]) -> IdImage {
    let settings = RenderSettings::default();
    render_commands_ids(&stage.scene(), &stage.frame, commands, &settings)
        .unwrap()
        .0
}

fn without(stage: &Stage, drop: impl Fn(&Command) -> bool) -> Vec<Command> {
    stage
        .frame
        .commands()
        .iter()
        .filter(|c| !drop(c))
        .copied()
        .collect()
}

/// Pixels that neither rays nor the meeting of surfaces explain.
fn wrong(picture: &IdImage, oracle: &Oracle, camera: &Camera) -> usize {
    compare_with_oracle(picture, oracle, camera, |_, _, _, _| {}).unexplained()
}

/// A camera in the village, looking from one point at another.
fn look(cell: u32, eye: [f32; 3], at: [f32; 3], size: (u32, u32)) -> Camera {
    let (eye, at) = (Vec3::from_array(eye), Vec3::from_array(at));
    camera(CellId(cell), eye, at - eye, size, 1.2)
}

// Places of the village.
fn before_cottage(size: (u32, u32)) -> Camera {
    look(0xA9B4_0031, [155.4, 24.0, 95.6], [155.4, 12.0, 95.2], size)
}
fn in_cottage(size: (u32, u32)) -> Camera {
    look(0xA9B4_0101, [155.4, 13.4, 95.6], [155.4, 30.0, 95.4], size)
}
fn before_shop(size: (u32, u32)) -> Camera {
    look(0xA9B4_0024, [99.5, 84.0, 95.6], [108.0, 84.0, 93.6], size)
}
fn in_shop(size: (u32, u32)) -> Camera {
    look(0xA9B4_010E, [109.5, 82.5, 93.9], [103.0, 84.2, 94.6], size)
}

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
fn r2_d19_d25_sealed_rooms_draw_nothing_of_the_outside() {
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
fn r3_d1_no_clear_colour_in_sealed_rooms() {
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

#[test]
fn r4_d13_openings_are_open() {
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
fn r5_d3_d4_d20_the_frame_is_the_cameras_not_the_players() {
    let mut stage = village();
    for camera in [before_cottage(SMALL), in_cottage(SMALL)] {
        let mut pictures = Vec::new();
        for player in [None, Some(0xA9B4_0031), Some(0xA9B4_0101), Some(0x0107_0100)] {
            let input = FrameInput {
                player_cell: player.map(|p| PlayerCell(CellId(p))),
                ..FrameInput::new(camera)
            };
            let source = WorldObjects::new(&stage.world);
            stage.frame.update(&stage.world, &stage.openings, &source, &input);
            pictures.push(render(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap());
        }
        assert!(pictures.windows(2).all(|p| p[0] == p[1]));
        // Broken: a camera outdoors that is drawn from the player's room loses the house it looks at, and the
        // other way round.
        let other = if camera.cell().is_indoor() {
            0xA9B4_0031
        } else {
            0xA9B4_0101
        };
        let wrong = stage.ids(camera.in_cell(CellId(other)));
        let right = stage.ids(camera);
        assert!(compare(&right, &wrong).differing > 100);
    }
}

#[test]
fn r6_d14_the_landscape_shows_exactly_through_exits() {
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
    // A house whose second room stands behind what the window of the first one shows.
    let compiled = vestibule_forge::compile_scene(
        "hook",
        "scene \"hook\"\nland 0xA9B4 0xA9B4 origin 0xA9B4\nheights 1\nstart at (20 20 ~0)\n\
         terrain { base 94; paint grassland everywhere }\n\
         material brick bricks color 150 92 70 second 150 140 126 size 1.6\n\
         building hook at (60 60 94) {\n\
         shell { prism z -0.6 3.2 (-0.3 -0.3) (6.3 -0.3) (6.3 2.2) (4.2 4.3) (-0.3 4.3)\n\
         prism z -0.6 3.2 (5.88 1.7) (12.3 1.7) (12.3 10.3) (0.7 10.3) (0.7 6.88)\nmaterial brick }\n\
         room main { prism z 0 2.6 (0 0) (6 0) (6 2) (4 4) (0 4); material brick }\n\
         room side { prism z 0 2.6 (6 2) (12 2) (12 10) (1 10) (1 7); material brick }\n\
         room gap { box (1 4 0.4) (3 4.3 2.4); material brick }\n\
         opening main side\nopening main gap\nwindow gap\n}\n",
    );
    let compiled = compiled.unwrap_or_else(|e| panic!("{e}"));
    let world = vestibule_world::World::open(compiled.memory_records()).unwrap();
    let mut hook = Stage::new(world, vestibule_world::BlockId(0xA9B4));
    let oracle = hook.oracle();
    let main = compiled.cell_named("hook.main").unwrap().0;
    let camera = look(main, [61.2, 61.0, 95.5], [66.2, 66.0, 95.4], (96, 72));
    let picture = hook.ids(camera);
    assert_eq!(wrong(&picture, &oracle, &camera), 0);
    let side = compiled.cell_named("hook.side").unwrap();
    assert!(picture.count_cell(side) > 100 && picture.count(PixelKind::Building) > 100);
    let unsealed = without(&hook, |c| matches!(c, Command::Seal { .. }));
    let broken = ids_of(&hook, &unsealed);
    assert!(
        broken.count_cell(side) > picture.count_cell(side),
        "without the seal the room beside stands in the window"
    );
}

#[test]
fn r7_d9_d10_d24_holes_rooms_and_shells_in_the_order_of_distance() {
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
fn r8_d5_d8_a_sunken_shop_is_not_filled_with_grass() {
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
fn r9_d6_d27_no_grass_in_the_shop_seen_from_inside_even_in_the_first_frame() {
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
fn r10_d7_floors_at_ground_height_win() {
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
fn r11_d11_a_room_and_its_rear_window_through_the_door() {
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

#[test]
fn r13_d18_objects_in_doorways_show_on_both_sides_and_nowhere_else() {
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

/// The share of pixels that change class between two pictures, 0…1.
fn changed(a: &IdImage, b: &IdImage) -> f32 {
    compare(a, b).differing as f32 / a.ids().len() as f32
}

#[test]
fn r14_d2_d20_crossing_a_door_in_tenths_of_millimetres_changes_nothing_at_once() {
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

#[test]
fn r15_d15_d16_a_body_in_a_dungeon_is_drawn_in_its_room() {
    let mut stage = Stage::hollow(DEEP).0;
    let mut population = Population::new();
    let mut scratch = Scratch::default();
    let cell = CellId(0x0107_0100);
    let id = population.add(Body::player());
    let position = Position {
        cell,
        frame: Frame::at(Vec3::new(60.0, -78.5, -20.0)),
    };
    population.force_into_cell(&stage.world, &mut scratch, id, &position);
    let camera = look(cell.0, [60.0, -82.5, -18.5], [60.0, -78.5, -19.0], SMALL);
    let source = WorldObjects::new(&stage.world).with_population(&population);
    stage
        .frame
        .update(&stage.world, &stage.openings, &source, &FrameInput::new(camera));
    let scene = Scene::new(&stage.world, &stage.assets).with_population(&population);
    let picture = render_ids(&scene, &stage.frame, &RenderSettings::default()).unwrap();
    let body = |i: &IdImage| i.ids().iter().filter(|id| id.item() == 0x0800_0000).count();
    assert!(body(&picture) > 50);
    // A transparent player is not there at all (`rendering.md` 4.8).
    let faded = scene.with_player(id, 0.0);
    let none = render_ids(&faded, &stage.frame, &RenderSettings::default()).unwrap();
    assert_eq!(body(&none), 0);
}

#[test]
fn r16_d17_cells_that_do_not_exist_end_in_fog_colour_and_a_count() {
    let mut stage = village();
    let camera = look(0xA9B4_0FFF, [100.0, 100.0, 96.0], [100.0, 120.0, 96.0], SMALL);
    let input = FrameInput {
        viewer_cell: Some(ViewerCell(CellId(0xA9B4_0FFF))),
        ..FrameInput::new(camera)
    };
    let source = WorldObjects::new(&stage.world);
    stage.frame.update(&stage.world, &stage.openings, &source, &input);
    assert_eq!(stage.frame.counters().nothing_to_draw, 1);
    let picture = render_ids(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap();
    assert_eq!(picture.count(PixelKind::Sky), picture.ids().len());
    // Commands that name what is not there are counted, not drawn.
    let nonsense = [
        Command::Terrain(CellId(0xA9B4_0FFF)),
        Command::Terrain(CellId(0x1234_0001)),
    ];
    let settings = RenderSettings::default();
    let (_, counters) = render_commands(&stage.scene(), &stage.frame, &nonsense, &settings).unwrap();
    assert_eq!(counters.missing, 2);
}

#[test]
fn r17_d21_overlapping_rooms_show_only_inside_their_own_openings() {
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
fn r19_r20_order_of_drawing_and_once_per_stamp() {
    let mut stage = village();
    for camera in [
        before_cottage(SMALL),
        in_cottage(SMALL),
        before_shop(SMALL),
        in_shop(SMALL),
    ] {
        stage.update(camera);
        let commands = stage.frame.commands();
        let place = |f: &dyn Fn(&Command) -> bool| commands.iter().position(f);
        let sky = place(&|c| matches!(c, Command::Sky)).unwrap();
        let terrain = place(&|c| matches!(c, Command::Terrain(_))).unwrap();
        assert!(sky < terrain);
        assert_eq!(commands.iter().filter(|c| matches!(c, Command::Sky)).count(), 1);
        if camera.cell().is_indoor() {
            let clear = place(&|c| matches!(c, Command::ClearDepth)).unwrap();
            let seal = place(&|c| matches!(c, Command::Seal { .. })).unwrap();
            let root = commands
                .iter()
                .rposition(|c| matches!(c, Command::Room { .. }))
                .unwrap();
            assert!(matches!(commands[clear - 2], Command::FlushAlpha));
            assert!(terrain < clear && clear < seal && seal < root);
        }
        let mut drawn = BTreeSet::new();
        for command in commands {
            match command {
                Command::NextStamp => drawn.clear(),
                Command::Room { cell, .. } => assert!(drawn.insert((cell.0, None))),
                Command::Object { id, .. } => assert!(drawn.insert((0, Some(*id)))),
                _ => {}
            }
        }
    }
}

#[test]
fn r27_see_through_things_outdoors_stay_behind_the_walls_inside() {
    let compiled = vestibule_forge::embedded_world().unwrap();
    let mut records = compiled.memory_records();
    // Make glass of every surface of the models that stand outdoors.
    let solid = village();
    let block = solid.world.block(solid.block).unwrap();
    let trees = block.statics[..block.land_statics as usize].iter();
    for part in trees.flat_map(|s| &s.shape.parts) {
        let model = solid
            .world
            .source()
            .record(vestibule_world::Store::Portal, part.model_id);
        let bytes = model.unwrap().unwrap();
        let model = vestibule_dat::record::GfxObj::parse(part.model_id, &bytes).unwrap();
        for id in model.surfaces {
            let bytes = solid
                .world
                .source()
                .record(vestibule_world::Store::Portal, id)
                .unwrap()
                .unwrap();
            let mut surface = vestibule_dat::record::Surface::parse(id, &bytes).unwrap();
            surface.surface_type |= vestibule_dat::record::Surface::TRANSLUCENT;
            surface.translucency = 0.3;
            let bytes = surface.encode().unwrap();
            records.insert(vestibule_world::Store::Portal, id, bytes);
        }
    }
    let world = vestibule_world::World::open(records).unwrap();
    let mut stage = Stage::new(world, vestibule_world::BlockId(VILLAGE));
    let settings = RenderSettings::default();
    let (mut deferred, mut differ) = (0, 0);
    for at in [
        [120.0, 60.0, 95.5],
        [155.4, 30.0, 95.4],
        [150.0, 40.0, 97.0],
        [165.0, 60.0, 98.0],
    ] {
        let camera = look(0xA9B4_0101, [155.4, 13.4, 95.6], at, (160, 120));
        stage.update(camera);
        let commands = stage.frame.commands();
        let (good, counters) = render_commands(&stage.scene(), &stage.frame, commands, &settings).unwrap();
        deferred += counters.deferred;
        let clear = commands
            .iter()
            .position(|c| matches!(c, Command::ClearDepth))
            .unwrap();
        let late: Vec<Command> = commands
            .iter()
            .enumerate()
            .filter(|(k, c)| *k > clear || !matches!(c, Command::FlushAlpha))
            .map(|(_, c)| *c)
            .collect();
        let (bad, _) = render_commands(&stage.scene(), &stage.frame, &late, &settings).unwrap();
        differ += good
            .pixels()
            .iter()
            .zip(bad.pixels())
            .filter(|(a, b)| a != b)
            .count();
    }
    assert!(deferred > 0);
    assert!(
        differ > 0,
        "glass flushed after the depth clear lies over the walls"
    );
}

#[test]
fn r28_the_same_scene_twice_is_the_same_picture() {
    let picture = || {
        let mut stage = village();
        stage.update(before_cottage((160, 120)));
        let image = render(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap();
        (image, stage.frame.commands().to_vec())
    };
    let (a, b) = (picture(), picture());
    assert!(a == b);
}

#[test]
fn every_threshold_in_centimetre_steps_changes_no_picture_abruptly() {
    let mut worst = 0.0f32;
    let mut walked = 0;
    let mut broken = 0.0f32;
    for block in [VILLAGE, DEEP] {
        let mut stage = Stage::hollow(block).0;
        let rooms = Rooms::new(&stage);
        let cells: Vec<CellId> = stage
            .world
            .block(stage.block)
            .unwrap()
            .env_cells()
            .map(|c| c.id)
            .collect();
        for id in cells {
            let cell = stage.world.env_cell(id).unwrap().clone();
            for portal in &cell.portals {
                let PortalTarget::Cell(other) = portal.other else {
                    continue;
                };
                // Each threshold once, level ones only.
                let out = portal.plane.normal * if portal.interior_is_negative { 1.0 } else { -1.0 };
                if other < id || out.z.abs() > 0.5 {
                    continue;
                }
                let corners = cell.portal_vertices(portal);
                let low = corners.iter().map(|c| c.z).fold(f32::INFINITY, f32::min);
                let mut middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
                middle.z = (low + middle.z) * 0.5;
                let (middle, out) = (
                    cell.frame.local_to_global(middle),
                    cell.frame.local_to_global_vec(out),
                );
                let reach = if poses(0) > 0 { 50 } else { 12 };
                let mut before: Option<IdImage> = None;
                for k in -reach..=reach {
                    let eye = middle + out * (k as f32 * 0.01 + 0.0013);
                    let Some(at) = [id, other]
                        .into_iter()
                        .find(|&c| stage.world.env_cell(c).is_some_and(|c| c.contains_point(eye)))
                    else {
                        before = None;
                        continue;
                    };
                    if !rooms.is_clear(at, eye, 0.2) {
                        before = None;
                        continue;
                    }
                    let camera = camera(at, eye, out + Vec3::new(0.05, 0.03, -0.02), SMALL, 1.2);
                    let picture = stage.ids(camera);
                    if let Some(last) = &before {
                        // A step of 1 cm with everything 0.2 m away or more moves an edge by a few pixels.
                        let change = changed(last, &picture);
                        worst = worst.max(change);
                        walked += 1;
                    }
                    if k == 1 {
                        let cut = without(&stage, |c| matches!(c, Command::Room { cell, .. } if *cell == at));
                        broken = broken.max(changed(&picture, &ids_of(&stage, &cut)));
                    }
                    before = Some(picture);
                }
            }
        }
    }
    assert!(walked > 300, "{walked}");
    assert!(worst < 0.15, "{worst}");
    assert!(broken > 0.3, "{broken}");
}

#[test]
fn bad_input_is_a_message_or_a_count_never_a_crash() {
    let mut stage = village();
    let frame = FrameView::default();
    assert!(
        render(&stage.scene(), &frame, &RenderSettings::default()).is_err(),
        "no frame yet"
    );
    let camera = |w: f32, h: f32| {
        let eye = Vec3::new(155.4, 24.0, 95.6);
        Camera::new(
            CellId(0xA9B4_0031),
            eye,
            Vec3::Y,
            Vec3::Z,
            1.0,
            glam::Vec2::new(w, h),
        )
    };
    assert!(camera(0.0, 10.0).is_err());
    for (w, h) in [(10.5, 10.0), (9000.0, 2.0), (1.0e9, 1.0e9)] {
        stage.update(camera(w, h).unwrap());
        assert!(render(&stage.scene(), &stage.frame, &RenderSettings::default()).is_err());
    }
    // Without any surface or texture records: everything is a checker, and counted.
    let compiled = vestibule_forge::embedded_world().unwrap();
    let mut records = compiled.memory_records();
    let ids: Vec<u32> = compiled
        .portal
        .keys()
        .copied()
        .filter(|id| matches!(id >> 24, 5 | 6 | 8))
        .collect();
    for id in ids {
        records.remove(vestibule_world::Store::Portal, id);
    }
    let world = vestibule_world::World::open(records).unwrap();
    let mut bare = Stage::new(world, vestibule_world::BlockId(VILLAGE));
    bare.update(before_cottage(SMALL));
    render(&bare.scene(), &bare.frame, &RenderSettings::default()).unwrap();
    assert!(bare.assets.counters().missing_surfaces > 0);
    assert!(bare.assets.counters().missing_textures > 0);
}
