//! Defects of rooms and doorways, each shown by switching off the rule that prevents it (`rendering.md` 18;
//! `docs/defects.md`).

use vestibule_dat::record::Environment;
use vestibule_render::render_distances;
use vestibule_view::{PIVOT_OFFSET, SealDepth, ViewerTarget, Views, update_viewer};
use vestibule_world::Store;

use crate::*;

/// From the arrival hall of the far dungeon through the gallery into the court.
fn in_dungeon(size: (u32, u32)) -> Camera {
    look(0x0107_0100, [57.5, -80.2, -18.4], [74.0, -79.8, -18.4], size)
}

#[test]
fn d01_holes_in_doorways_without_the_neighbour_or_the_landscape() {
    let mut deep = Stage::hollow(DEEP).0;
    let camera = in_dungeon(SMALL);
    assert_eq!(deep.ids(camera).count(PixelKind::Background), 0);
    let root = camera.cell();
    let alone = without(
        &deep,
        |c| matches!(c, Command::Room { cell, .. } if *cell != root),
    );
    assert!(ids_of(&deep, &alone).count(PixelKind::Background) > 50);
    // A neighbour that is not there is a hole nobody can fill, and counted.
    let mut torn = Stage::edited(DEEP, |records| {
        assert!(records.remove(Store::Cell, 0x0107_0101));
    });
    assert!(torn.ids(camera).count(PixelKind::Background) > 50);
    assert!(torn.frame.counters().flood.dead_portals > 0);
    // An exit whose view is dropped.
    let mut stage = village();
    assert_eq!(stage.ids(in_cottage(SMALL)).count(PixelKind::Background), 0);
    let clear = stage
        .frame
        .commands()
        .iter()
        .position(|c| matches!(c, Command::ClearDepth));
    let inside = stage.frame.commands()[clear.unwrap()..].to_vec();
    assert!(ids_of(&stage, &inside).count(PixelKind::Background) > 50);
}

#[test]
fn d02_a_hole_on_the_plane_of_a_door_without_the_rule_for_it() {
    let on_plane = look(0x0107_0101, [70.0, -80.1, -18.3], [80.0, -79.5, -18.5], SMALL);
    let holes = |admit: bool| {
        let mut stage = Stage::hollow(DEEP).0;
        let mut settings = *stage.frame.settings();
        settings.flood.admit_on_plane = admit;
        settings.flood.guard_wrong_cell = admit;
        stage.frame = FrameView::new(settings);
        stage.ids(on_plane).count(PixelKind::Background)
    };
    assert_eq!(holes(true), 0);
    assert!(holes(false) > 300);
}

#[test]
fn d13_doors_are_walled_up_when_portal_polygons_are_drawn() {
    let mut stage = Stage::edited(DEEP, |records| {
        let environments: Vec<(u32, Vec<u8>)> = records
            .iter()
            .filter(|(store, id, _)| *store == Store::Portal && id >> 24 == 0x0D)
            .map(|(_, id, bytes)| (id, bytes.to_vec()))
            .collect();
        for (id, bytes) in environments {
            let mut environment = Environment::parse(id, &bytes).unwrap();
            for structure in &mut environment.cell_structs {
                let portals = structure.portals.clone();
                for polygon in structure.polygons.iter_mut().filter(|p| portals.contains(&p.id)) {
                    (polygon.sides_type, polygon.stippling, polygon.pos_surface) = (1, 3, 0);
                    polygon.pos_uv = vec![0; polygon.vertex_ids.len()];
                }
            }
            records.insert(Store::Portal, id, environment.encode().unwrap());
        }
    });
    let camera = in_dungeon((33, 33));
    let middle = |image: &IdImage| image.get(16, 16).unwrap().cell();
    let root = Some(camera.cell());
    assert_ne!(middle(&Stage::hollow(DEEP).0.ids(camera)), root);
    assert_eq!(middle(&stage.ids(camera)), root, "the door is a wall");
    assert!(stage.assets.counters().drawn_portals > 0, "and counted");
}

#[test]
fn d14_rooms_cover_the_view_out_without_seals_or_with_seals_at_another_depth() {
    let (mut hook, side) = hook();
    let oracle = hook.oracle();
    let camera = look(HOOK_CAMERA.0, HOOK_CAMERA.1, HOOK_CAMERA.2, (96, 72));
    let right = hook.ids(camera);
    assert_eq!(wrong(&right, &oracle, &camera), 0);
    let broken = ids_of(&hook, &without(&hook, |c| matches!(c, Command::Seal { .. })));
    assert!(broken.count_cell(side) > right.count_cell(side));
    assert!(wrong(&broken, &oracle, &camera) > 0);
    // Another encoding: seals nearer than what stands before them. The lantern before the window is lost.
    let mut stage = village();
    let oracle = stage.oracle();
    let camera = look(
        0xA9B4_0113,
        [158.5, 108.02, 104.55],
        [151.4, 108.0, 103.6],
        (96, 72),
    );
    assert_eq!(wrong(&stage.ids(camera), &oracle, &camera), 0);
    let near: Vec<Command> = stage
        .frame
        .commands()
        .iter()
        .map(|c| match *c {
            Command::Seal {
                polygon,
                cell,
                portal,
                ..
            } => Command::Seal {
                polygon,
                depth: SealDepth::Nearest,
                cell,
                portal,
            },
            other => other,
        })
        .collect();
    let broken = wrong(&ids_of(&stage, &near), &oracle, &camera);
    assert!(broken > 5, "{broken}");
}

/// The cottage's hall with a body in it, seen from the hall; `again` dresses it anew before the frame is made.
fn body_in_hall(again: bool) -> (Stage, Population, Camera) {
    let mut stage = village();
    let mut population = Population::new();
    let mut scratch = Scratch::default();
    let position = Position {
        cell: CellId(0xA9B4_0101),
        frame: Frame::at(Vec3::new(157.2, 13.8, 94.0)),
    };
    let id = population.add(Body::player());
    population.force_into_cell(&stage.world, &mut scratch, id, &position);
    if again {
        population.remove(id);
        let id = population.add(Body::player());
        population.force_into_cell(&stage.world, &mut scratch, id, &position);
    }
    let camera = look(0xA9B4_0101, [155.0, 13.7, 95.2], [157.2, 13.8, 95.0], SMALL);
    let source = WorldObjects::new(&stage.world).with_population(&population);
    stage
        .frame
        .update(&stage.world, &stage.openings, &source, &FrameInput::new(camera));
    (stage, population, camera)
}

fn body_pixels(stage: &Stage, population: &Population, commands: &[Command]) -> usize {
    let scene = Scene::new(&stage.world, &stage.assets).with_population(population);
    let settings = RenderSettings::default();
    let (picture, _) = render_commands_ids(&scene, &stage.frame, commands, &settings).unwrap();
    picture.ids().iter().filter(|id| id.item() == 0x0800_0000).count()
}

/// The commands with the bodies drawn in the layer of the outdoors, before depth is cleared.
fn bodies_outdoors(stage: &Stage) -> Vec<Command> {
    let is_body = |c: &Command| {
        matches!(
            c,
            Command::Object {
                id: ObjectRef::Body(_),
                ..
            }
        )
    };
    let bodies: Vec<Command> = stage.frame.commands().iter().copied().filter(is_body).collect();
    let rest = without(stage, is_body);
    [&bodies[..], &[Command::ClearDepth], &rest[..]].concat()
}

#[test]
fn d15_what_is_drawn_with_the_outdoors_is_lost_indoors() {
    let (stage, population, _) = body_in_hall(false);
    let right = body_pixels(&stage, &population, stage.frame.commands());
    assert!(right > 50, "{right}");
    let broken = body_pixels(&stage, &population, &bodies_outdoors(&stage));
    assert_eq!(broken, 0);
}

#[test]
fn d16_a_body_dressed_anew_is_in_the_layer_of_its_cell() {
    let (stage, population, _) = body_in_hall(true);
    let (before, first, _) = body_in_hall(false);
    let right = body_pixels(&stage, &population, stage.frame.commands());
    assert_eq!(right, body_pixels(&before, &first, before.frame.commands()));
    // Its new parts in the layer they were made for, not in that of the cell.
    assert_eq!(body_pixels(&stage, &population, &bodies_outdoors(&stage)), 0);
}

#[test]
fn d17_houses_float_in_the_sky_when_a_lost_cell_has_no_fallback() {
    let mut stage = village();
    let lost = CellId(0xA9B4_0FFF);
    let camera = look(lost.0, [152.0, 27.0, 95.8], [155.6, 14.0, 95.6], SMALL);
    let mut frame = |player: Option<CellId>| {
        let input = FrameInput {
            viewer_cell: Some(ViewerCell(lost)),
            player_cell: player.map(PlayerCell),
            ..FrameInput::new(camera)
        };
        let source = WorldObjects::new(&stage.world);
        stage.frame = FrameView::default();
        stage.frame.update(&stage.world, &stage.openings, &source, &input);
        let picture = render_ids(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap();
        (picture.count(PixelKind::Terrain), *stage.frame.counters())
    };
    let (terrain, counters) = frame(Some(CellId(0xA9B4_0031)));
    assert!(terrain > 300 && counters.fell_back_to_player == 1);
    // Nothing to fall back on: no land, and counted.
    let (terrain, counters) = frame(None);
    assert!(terrain == 0 && counters.nothing_to_draw == 1);
}

#[test]
fn d18_things_shine_through_walls_when_they_are_drawn_because_they_are_near() {
    let mut stage = village();
    let hall = CellId(0xA9B4_0101);
    let cellar = look(0xA9B4_0107, [150.5, 6.5, 93.0], [157.0, 10.5, 94.6], SMALL);
    let of_hall = |image: &IdImage| image.count_cell(hall);
    assert_eq!(of_hall(&stage.ids(cellar)), 0);
    let mut naive = stage.frame.commands().to_vec();
    naive.push(Command::ClearDepth);
    naive.extend(stage.world.statics_in(hall).iter().map(|&r| Command::Object {
        id: ObjectRef::Static(r),
        cell: hall,
        views: Views::Landscape,
    }));
    assert!(of_hall(&ids_of(&stage, &naive)) > 20);
}

#[test]
fn d19_land_stands_in_sealed_rooms_when_it_is_drawn_for_the_players_landblock() {
    let (mut stage, compiled) = Stage::scene_text(
        VILLAGE,
        "scene \"vault\"\nland 0xA9B4 0xA9B4 origin 0xA9B4\nheights 1\nstart at (20 20 ~0)\n\
         terrain { base 94; paint grassland everywhere }\n\
         material brick bricks color 150 92 70 second 150 140 126 size 1.6\n\
         dungeon vault 0xA9B4 at (60 60 92) {\n\
         room hall { box (0 0 0) (12 9 5); material brick }\n\
         room side { box (12 3 0) (18 6 4); material brick }\nopening hall side\n}\n",
    );
    let hall = compiled.cell_named("vault.hall").unwrap();
    let camera = look(hall.0, [62.0, 62.0, 95.0], [75.0, 65.0, 94.0], SMALL);
    let right = stage.ids(camera);
    assert!(!stage.frame.draws_landscape());
    assert_eq!(
        (right.count(PixelKind::Terrain), right.count(PixelKind::Sky)),
        (0, 0)
    );
    let mut land: Vec<Command> = (1..=64)
        .map(|k| Command::Terrain(CellId::new(stage.block, k)))
        .collect();
    land.extend_from_slice(stage.frame.commands());
    assert!(ids_of(&stage, &land).count(PixelKind::Terrain) > 300);
}

#[test]
fn d20_a_threshold_flickers_when_the_cell_is_derived_from_coordinates() {
    // The camera rests 5 cm before a door.
    let mut stage = Stage::hollow(DEEP).0;
    let mut settings = *stage.frame.settings();
    settings.flood.guard_wrong_cell = false;
    stage.frame = FrameView::new(settings);
    let camera = look(0x0107_0101, [69.95, -80.1, -18.3], [60.0, -79.5, -18.5], SMALL);
    let right = stage.ids(camera);
    assert_eq!(compare(&right, &stage.ids(camera)).differing, 0);
    let other = stage.ids(camera.in_cell(CellId(0x0107_0102)));
    assert!(compare(&right, &other).differing > 300);
}

#[test]
fn d21_rooms_in_the_same_place_mix_without_their_regions() {
    // Two rooms in one place, each behind a door of its own (`visibility.md` V30).
    let mut stage = overlap();
    let oracle = stage.oracle();
    let loose = RenderSettings {
        confine_overlaps: false,
        ..RenderSettings::default()
    };
    let mut random = Random(23);
    let (mut right, mut mixed, mut everything) = (0, 0, 0);
    for _ in 0..20 {
        let eye = Vec3::new(random.between(-4.0, 4.0), random.between(-4.0, 4.0), 1.5);
        let camera = camera(
            CellId(OVERLAP.0),
            eye + Vec3::from_array(OVERLAP.1),
            Vec3::Y,
            SMALL,
            1.2,
        );
        right += wrong(&stage.ids(camera), &oracle, &camera);
        let picture = render_ids(&stage.scene(), &stage.frame, &loose).unwrap();
        mixed += wrong(&picture, &oracle, &camera);
        everything += wrong(&stage.everything(&camera), &oracle, &camera);
    }
    assert_eq!(right, 0);
    assert!(mixed > 0 && everything > 0, "{mixed} {everything}");
}

#[test]
fn d22_a_dark_rim_around_doorways_when_passes_are_resolved_apart() {
    // Samples are put together once, when all are drawn; where the landscape's were put together before the rooms
    // were drawn, pixels that both share mix with what neither of them is.
    const MANY: u32 = 4;
    let mut stage = village();
    let size = (SMALL.0 * MANY, SMALL.1 * MANY);
    stage.update(in_cottage(size));
    let settings = RenderSettings::default();
    let commands = stage.frame.commands();
    let clear = commands
        .iter()
        .position(|c| matches!(c, Command::ClearDepth))
        .unwrap();
    let draw = |commands: &[Command]| {
        render_commands(&stage.scene(), &stage.frame, commands, &settings)
            .unwrap()
            .0
    };
    let whole = draw(commands);
    let ids = ids_of(&stage, commands);
    let inner = |x: u32, y: u32| ids.get(x, y).unwrap().kind() == PixelKind::Room;
    let sum = |[r, g, b, _]: [u8; 4]| u32::from(r) + u32::from(g) + u32::from(b);
    let outside = draw(&commands[..clear]);
    let samples = |x: u32, y: u32| (0..MANY * MANY).map(move |k| (x * MANY + k % MANY, y * MANY + k / MANY));
    let (mut right, mut broken, mut rim) = (0, 0, 0);
    for y in 0..SMALL.1 {
        for x in 0..SMALL.0 {
            let count = samples(x, y).filter(|&(x, y)| inner(x, y)).count() as u32;
            if count == 0 || count == MANY * MANY {
                continue;
            }
            rim += 1;
            let colors = || samples(x, y).map(|(x, y)| sum(whole.get(x, y).unwrap()));
            let mean = |all: &mut dyn Iterator<Item = u32>| all.sum::<u32>() / (MANY * MANY);
            let together = mean(&mut colors());
            // Two resolved layers, one over the other: what the rooms cover is black in the landscape's pass and the
            // other way round, and each pass is a whole pixel.
            let far = mean(&mut samples(x, y).map(|(x, y)| {
                if inner(x, y) {
                    0
                } else {
                    sum(outside.get(x, y).unwrap())
                }
            }));
            let near = mean(&mut samples(x, y).map(|(x, y)| {
                if inner(x, y) {
                    sum(whole.get(x, y).unwrap())
                } else {
                    0
                }
            }));
            let apart = if near > 0 { near } else { far };
            let low = colors().min().unwrap();
            right += usize::from(together < low);
            broken += usize::from(apart < low);
        }
    }
    assert!(rim > 20, "{rim}");
    assert!(right == 0 && broken * 4 > rim, "{right} {broken} of {rim}");
}

#[test]
fn d23_haze_in_a_doorway_when_effects_read_the_depth_of_seals() {
    let mut stage = village();
    let oracle = stage.oracle();
    let camera = in_cottage(SMALL);
    let picture = stage.ids(camera);
    let distances = render_distances(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap();
    let (mut land, mut right, mut broken) = (0, 0, 0);
    for y in 0..SMALL.1 {
        for x in 0..SMALL.0 {
            let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
            let hit = oracle.pixel(&camera, px, py);
            if picture.get(x, y) != Some(hit.id) {
                continue;
            }
            let along = camera
                .ray_through(glam::Vec2::new(px, py))
                .normalize()
                .dot(camera.forward());
            let truth = hit.distance as f32 * along;
            let agrees = |d: Option<f32>| d.is_some_and(|d| d == truth || (d - truth).abs() < 0.01 * truth);
            assert!(
                agrees(distances.get(x, y)),
                "({x}, {y}): {:?} {truth}",
                distances.get(x, y)
            );
            if hit.id.kind() != PixelKind::Room && hit.id.kind() != PixelKind::Object {
                land += 1;
                right += usize::from(agrees(distances.get(x, y)));
                broken += usize::from(agrees(distances.buffer(x, y)));
            }
        }
    }
    assert!(land > 100 && right == land, "{right} of {land}");
    assert!(broken < land / 10, "{broken} of {land}");
}

#[test]
fn d26_void_behind_a_wall_when_the_camera_is_not_swept() {
    let mut stage = Stage::hollow(DEEP).0;
    let (population, mut scratch) = (Population::new(), Scratch::default());
    // In a corner of the arrival hall, the camera wants to be 2.6 m behind the player.
    let cell = CellId(0x0107_0100);
    let target = ViewerTarget::at(Position::new(cell, Vec3::new(63.2, -83.2, -20.0)));
    let mut holes = |swept: bool| {
        let mut most = 0;
        for turn in 0..12 {
            let (s, c) = libm::sincosf(turn as f32 * core::f32::consts::TAU / 12.0);
            let mut sought = target.position;
            sought.frame.origin += PIVOT_OFFSET + Vec3::new(-2.5 * s, -2.5 * c, 0.75);
            let viewer = update_viewer(
                &stage.world,
                &population,
                &mut scratch,
                &target,
                PIVOT_OFFSET,
                &sought,
            );
            let eye = if swept {
                viewer.position.frame.origin
            } else {
                sought.frame.origin
            };
            let at = if swept { viewer.cell.unwrap().0 } else { cell };
            let camera = camera(at, eye, Vec3::new(s, c, -0.3), SMALL, 1.2);
            let picture = stage.ids(camera);
            most = most.max(picture.count(PixelKind::Background));
        }
        most
    };
    assert_eq!(holes(true), 0);
    assert!(holes(false) > 300);
}
