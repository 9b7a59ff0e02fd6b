//! What keys do, without a window.

use std::io::Write as _;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use vestibule_explore::{Action, Explorer, Held, NamedPlace, Overlay, Show, Verdict, middle_of};
use vestibule_view::{CameraMode, Command, FramePath};
use vestibule_world::{CellId, Position, World};

const SIZE: Vec2 = Vec2::new(320.0, 180.0);

fn explorer() -> Explorer {
    let compiled = vestibule_forge::embedded_world().unwrap();
    let world = World::open(compiled.memory_records()).unwrap();
    let names = compiled.cell_names.iter().filter_map(|(&cell, name)| {
        Some(NamedPlace {
            name: name.clone(),
            position: middle_of(&world, cell)?,
        })
    });
    let names = names.collect();
    Explorer::new(Arc::new(world), names, compiled.start.unwrap()).unwrap()
}

fn hold(explorer: &mut Explorer, held: Held, seconds: f32) {
    for _ in 0..(seconds * 30.0) as u32 {
        explorer.tick(&held, 1.0 / 30.0, SIZE);
    }
}

const FORWARD: Held = Held {
    forward: true,
    back: false,
    left: false,
    right: false,
    turn_left: false,
    turn_right: false,
    slow: false,
    jump: false,
    down: false,
};

#[test]
fn the_forward_key_walks_through_the_cottage_door() {
    let mut e = explorer();
    hold(&mut e, Held::default(), 0.5);
    assert_eq!(e.frame().path(), FramePath::Outdoors);
    let mut seen = vec![e.player_cell()];
    for _ in 0..30 {
        hold(&mut e, FORWARD, 0.1);
        if seen.last() != Some(&e.player_cell()) {
            seen.push(e.player_cell());
        }
    }
    let indoors: Vec<_> = seen.iter().filter(|c| c.is_indoor()).collect();
    assert!(indoors.len() >= 2, "vestibule, then hall: {seen:?}");
    assert_ne!(e.frame().path(), FramePath::Outdoors);
    assert!(e.viewer().is_some_and(|v| v.cell.is_some()));
}

#[test]
fn a_closed_door_stops_the_player_and_an_open_one_does_not() {
    let mut e = explorer();
    e.teleport("0xA9B40101 [155.4 13.0 94.0]");
    hold(&mut e, Held::default(), 0.3);
    e.act(Action::Door);
    assert_eq!(e.message(), Some("the door is closed"));
    hold(&mut e, Held::default(), 0.1);
    // The static leaf that stands open is hidden, the body is drawn.
    assert_eq!(e.population().len(), 2);
    let before = e.player_cell();
    let mut north = *e.body().unwrap().position();
    north.frame.set_rotation(glam::Quat::IDENTITY);
    e.go_to(&north);
    assert!(e.body().unwrap().position().same_as(&north), "{:?}", e.message());
    hold(&mut e, FORWARD, 1.5);
    assert_eq!(e.player_cell(), before, "held by the door");
    e.act(Action::Door);
    assert_eq!(e.message(), Some("the door is open"));
    // Who pushes straight against something keeps sliding along it until it steps back (`transition.md` 4).
    let back = Held {
        back: true,
        ..Held::default()
    };
    hold(&mut e, back, 0.3);
    hold(&mut e, FORWARD, 2.5);
    assert!(
        !e.player_cell().is_indoor(),
        "out on the meadow: {} {:?}",
        e.player_cell(),
        e.body().map(|b| b.position().to_string())
    );
}

#[test]
fn nowhere_is_a_message_and_changes_nothing() {
    let mut e = explorer();
    let before = *e.body().unwrap().position();
    for text in [
        "nowhere at all",
        "0x00010001 [1 2 3]",
        "0xA9B40031 [1e30 0 0]",
        "999N, 999E",
        "",
    ] {
        e.teleport(text);
        assert!(e.message().is_some(), "{text}");
        assert!(e.body().unwrap().position().same_as(&before), "{text}");
    }
    e.go_to(&Position::new(CellId(0xA9B4_FFF0), Vec3::ZERO));
    assert!(e.body().unwrap().position().same_as(&before));
}

#[test]
fn absurd_screens_times_and_mice_are_survived() {
    let mut e = explorer();
    for size in [
        Vec2::ZERO,
        Vec2::new(0.0, 900.0),
        Vec2::NAN,
        Vec2::new(1.0, 1.0),
        Vec2::new(30_000.0, 2.0),
        Vec2::new(f32::INFINITY, 1.0),
    ] {
        for dt in [0.0, -1.0, f32::NAN, 1.0e9] {
            e.tick(&FORWARD, dt, size);
        }
        e.look(Vec2::NAN);
        e.look(Vec2::splat(1.0e6));
        e.zoom(f32::NAN);
        e.pick(Vec2::splat(-5.0));
        e.marks();
    }
    e.tick(&Held::default(), 0.03, SIZE);
    assert!(e.camera().is_some());
}

#[test]
fn zooming_in_ends_in_the_head_and_out_again_behind_it() {
    let mut e = explorer();
    hold(&mut e, Held::default(), 0.1);
    for _ in 0..20 {
        e.zoom(1.0);
    }
    hold(&mut e, Held::default(), 0.5);
    assert_eq!(e.scene().player_opacity, 0.0);
    e.zoom(-1.0);
    hold(&mut e, Held::default(), 0.5);
    assert!(e.scene().player_opacity > 0.5);
    assert_eq!(CameraMode::default(), CameraMode::Chase);
}

#[test]
fn a_held_traversal_stays_while_the_camera_flies() {
    let mut e = explorer();
    e.teleport("cottage.hall");
    hold(&mut e, Held::default(), 0.5);
    let listed = e.frame().commands().len();
    e.act(Action::Freeze);
    assert!(e.is_frozen());
    let before = e.camera().unwrap().eye();
    let back = Held {
        back: true,
        jump: true,
        ..Held::default()
    };
    hold(&mut e, back, 1.0);
    assert!((e.camera().unwrap().eye() - before).length() > 3.0);
    assert_eq!(e.frame().commands().len(), listed);
    let bound = |c: &&Command| {
        matches!(
            c,
            Command::Seal { .. } | Command::Punch { .. } | Command::ClearDepth
        )
    };
    assert_eq!(e.commands().iter().filter(bound).count(), 0);
    for k in 0..5 {
        e.act(Action::Overlay(k));
        assert!(!e.marks().is_empty(), "{}", Overlay::ALL[k].name());
    }
    e.act(Action::Freeze);
    assert!(!e.is_frozen());
}

#[test]
fn every_way_of_showing_has_commands() {
    let mut e = explorer();
    e.teleport("cottage.hall");
    hold(&mut e, Held::default(), 0.2);
    let rooms = |e: &Explorer| {
        let room = |c: &&Command| matches!(c, Command::Room { .. });
        e.commands().iter().filter(room).count()
    };
    let reached = rooms(&e);
    e.act(Action::SingleCell);
    hold(&mut e, Held::default(), 0.1);
    assert_eq!((e.show, rooms(&e)), (Show::SingleCell, 1));
    e.act(Action::Everything);
    hold(&mut e, Held::default(), 0.1);
    assert!(rooms(&e) > reached);
    e.act(Action::Everything);
    assert_eq!(e.show, Show::Reached);
}

#[test]
fn hours_go_round_and_escape_leaves_step_by_step() {
    let mut e = explorer();
    for _ in 0..24 {
        e.act(Action::Time(1));
    }
    assert!((e.time_of_day - 0.5).abs() < 1.0e-4);
    e.act(Action::Help);
    e.act(Action::Teleport);
    for _ in 0..2 {
        e.act(Action::Escape);
        assert!(!e.wants_to_leave);
    }
    e.act(Action::Escape);
    assert!(e.wants_to_leave);
}

#[test]
fn a_walk_does_not_depend_on_how_fast_pictures_are_drawn() {
    let walk = |dt: f32| {
        let mut e = explorer();
        // To rest, then north through the door and along a wall of the hall.
        let mut walked = Vec::new();
        let script = [
            (Held::default(), 0.5f64),
            (FORWARD, 6.0),
            (
                Held {
                    left: true,
                    ..FORWARD
                },
                8.0,
            ),
        ];
        for (held, until) in script {
            // Keys change with a step, whatever the frames are.
            while e.clock() < until {
                let due = (until - e.clock()) as f32;
                e.tick(&held, if due < dt { due.max(0.001) } else { dt }, SIZE);
                walked.extend(e.trail().iter().map(|s| (s.cell, s.position.origin().to_array())));
            }
        }
        walked
    };
    let reference = walk(1.0 / 30.0);
    assert!(reference.iter().any(|s| s.0.is_indoor()), "it leads indoors");
    for dt in [1.0 / 240.0, 1.0 / 60.0, 0.05] {
        let other = walk(dt);
        let steps = reference.len().min(other.len());
        assert!(steps > 200);
        // A change of keys falls on the same step, or on the next where a frame spans it.
        let apart = reference
            .iter()
            .zip(&other)
            .position(|(a, b)| a != b)
            .unwrap_or(steps);
        assert!(apart >= 179, "frames of {dt} s: apart from step {apart} on");
    }
}

#[test]
fn a_long_frame_is_walked_through_in_short_steps() {
    let mut e = explorer();
    hold(&mut e, Held::default(), 0.5);
    let mut cells = Vec::new();
    for _ in 0..4 {
        e.tick(&FORWARD, 1.0, SIZE);
        assert!(e.trail().len() >= 29, "{}", e.trail().len());
        cells.extend(e.trail().iter().map(|s| s.cell));
    }
    cells.dedup();
    assert!(cells.iter().filter(|c| c.is_indoor()).count() >= 2, "{cells:?}");
}

#[test]
fn a_tap_counts_for_a_step_though_it_is_over_before_the_frame() {
    let mut e = explorer();
    hold(&mut e, Held::default(), 0.5);
    let facing = |e: &Explorer| e.body().unwrap().position().frame.rotation();
    let before = facing(&e);
    let turn = Held {
        turn_left: true,
        ..Held::default()
    };
    e.tap(turn);
    e.tick(&Held::default(), 0.5, SIZE);
    let turned = before.angle_between(facing(&e)).to_degrees();
    assert!(
        turned > 0.5 && turned < 10.0,
        "{turned} degrees: one step of many"
    );
    // Taps while the traversal is held are the flying camera's.
    let stood = facing(&e);
    e.act(Action::Freeze);
    e.tap(turn);
    e.tick(&Held::default(), 0.2, SIZE);
    e.act(Action::Freeze);
    e.tick(&Held::default(), 0.2, SIZE);
    assert_eq!(facing(&e), stood);
}

#[test]
fn a_world_unloaded_while_it_is_drawn_is_survived() {
    let mut e = explorer();
    hold(&mut e, Held::default(), 0.5);
    assert!(e.commands().len() > 50);
    // Another world with the same records, of which nothing is loaded: every command names what is gone.
    let compiled = vestibule_forge::embedded_world().unwrap();
    let bare = World::open(compiled.memory_records()).unwrap();
    let assets = vestibule_render::Assets::new();
    let scene = vestibule_render::Scene::new(&bare, &assets);
    let settings = vestibule_render::RenderSettings::default();
    let drawn = vestibule_render::render_commands(&scene, e.frame(), e.commands(), &settings);
    assert!(drawn.is_ok());
    let Ok(gpu) = vestibule_gpu::Gpu::headless(vestibule_gpu::AdapterChoice::Software) else {
        writeln!(std::io::stderr(), "skipped: no software adapter").unwrap();
        return;
    };
    let mut renderer = vestibule_gpu::Renderer::new(&gpu, vestibule_gpu::RendererOptions::default());
    let target = renderer.target(&gpu, SIZE.x as u32, SIZE.y as u32).unwrap();
    let camera = e.camera().unwrap();
    let picture = vestibule_gpu::Picture {
        camera: &camera,
        commands: e.commands(),
        frame: e.regions_frame(),
        sealed: false,
    };
    for scene in [&e.scene(), &scene, &e.scene()] {
        renderer.draw(&gpu, &target, scene, &picture, &settings).unwrap();
    }
    assert_eq!(gpu.lost(), None);
}

#[test]
fn a_lost_device_is_told_and_a_new_one_draws_the_same() {
    let mut e = explorer();
    hold(&mut e, Held::default(), 0.5);
    let camera = e.camera().unwrap();
    let draw = |lose: bool| {
        let gpu = vestibule_gpu::Gpu::headless(vestibule_gpu::AdapterChoice::Software).ok()?;
        let mut renderer = vestibule_gpu::Renderer::new(&gpu, vestibule_gpu::RendererOptions::default());
        let target = renderer.target(&gpu, SIZE.x as u32, SIZE.y as u32).unwrap();
        let picture = vestibule_gpu::Picture {
            camera: &camera,
            commands: e.commands(),
            frame: e.regions_frame(),
            sealed: e.is_sealed(),
        };
        let settings = vestibule_render::RenderSettings::default();
        if lose {
            gpu.device.destroy();
            // It may be noticed when it is used, or when the picture is asked for; but it is.
            let drawn = renderer.draw(&gpu, &target, &e.scene(), &picture, &settings);
            let image = target.image(&gpu);
            assert!(drawn.is_err() || image.is_err());
            return None;
        }
        renderer
            .draw(&gpu, &target, &e.scene(), &picture, &settings)
            .unwrap();
        target.image(&gpu).ok()
    };
    let Some(before) = draw(false) else {
        writeln!(std::io::stderr(), "skipped: no software adapter").unwrap();
        return;
    };
    draw(true);
    assert!(draw(false) == Some(before));
}

#[test]
fn a_click_tells_which_portals_it_went_through() {
    let mut e = explorer();
    e.teleport("0xA9B40101 [155.4 12.9 94.005] 1 0 0 0");
    hold(&mut e, Held::default(), 1.0);
    e.pick(SIZE * Vec2::new(0.5, 0.4));
    let picked = e.picked.as_ref().unwrap();
    let verdicts: Vec<_> = picked.portals.iter().map(|p| p.verdict).collect();
    assert_eq!(verdicts, [Verdict::Passed, Verdict::Outside], "{picked:?}");
}

#[test]
fn everything_loads_what_is_near_bit_by_bit() {
    let mut e = explorer();
    let centre = e.player_cell().block();
    let loaded = |e: &Explorer| {
        let around = (-2..=2).flat_map(|dx| (-2..=2).map(move |dy| (dx, dy)));
        let blocks = around.filter_map(|(dx, dy)| e.world().loaded_block(centre.neighbour(dx, dy)?));
        blocks.count()
    };
    hold(&mut e, Held::default(), 0.1);
    e.act(Action::Everything);
    let before = loaded(&e);
    e.tick(&Held::default(), 0.03, SIZE);
    assert!(loaded(&e) <= before + 2, "not all at once");
    hold(&mut e, Held::default(), 1.0);
    let full = loaded(&e);
    let there = |dx: i32, dy: i32| {
        centre
            .neighbour(dx, dy)
            .and_then(|b| e.world().block(b))
            .is_some()
    };
    let all = (-2..=2).flat_map(|dx| (-2..=2).map(move |dy| (dx, dy)));
    assert_eq!(full, all.filter(|(dx, dy)| there(*dx, *dy)).count());
}
