//! The decision of the frame and its order (`rendering.md` 2, 5, 6, tests R2, R5, R6, R16, R19, R20), in the worlds
//! of the test vectors.

use std::collections::HashSet;
use std::io::Write as _;
use std::path::Path;

use glam::{Vec2, Vec3};
use vestibule_dat::DatSet;
use vestibule_view::{
    Camera, Command, FrameInput, FramePath, FrameSource, FrameView, LightSet, Openings, PlayerCell,
    SealDepth, ViewerCell, WorldObjects,
};
use vestibule_world::{Building, CellId, World};

const VIEWPORT: Vec2 = Vec2::new(800.0, 600.0);

fn world(name: &str) -> Option<World> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/vectors/worlds")
        .join(name);
    if !folder.exists() {
        let _ = writeln!(std::io::stderr(), "skipped: no world at {}", folder.display());
        return None;
    }
    Some(World::open(DatSet::open(folder).unwrap()).unwrap())
}

/// The cottage: vestibule 0100 with the way out at y = 79, main room 0101 north of it, rooms 0102-0104 beyond.
const VESTIBULE: CellId = CellId(0xA9B4_0100);
const MAIN: CellId = CellId(0xA9B4_0101);
const CELLAR_SIDE: CellId = CellId(0xA9B4_0104);
/// South of the door, looking at it.
const YARD: Vec3 = Vec3::new(84.0, 74.0, 41.6);
const INSIDE: Vec3 = Vec3::new(84.0, 85.0, 41.6);

fn camera(cell: CellId, eye: Vec3, look: Vec3) -> Camera {
    Camera::new(cell, eye, look, Vec3::Z, 1.2, VIEWPORT).unwrap()
}

fn land_cell(eye: Vec3) -> CellId {
    MAIN.adjust_to_outside(eye).unwrap().0
}

fn frame_of(world: &World, input: &FrameInput) -> FrameView {
    let mut frame = FrameView::default();
    frame.update(world, &Openings::new(), &WorldObjects::new(world), input);
    frame
}

fn is_landscape(command: &Command) -> bool {
    matches!(
        command,
        Command::Sky
            | Command::Terrain(_)
            | Command::TerrainBlock { .. }
            | Command::Building { .. }
            | Command::Weather
    )
}

#[test]
fn r5_the_camera_decides_not_the_player() {
    let Some(world) = world("cottage-1") else { return };
    for (cell, eye, look, path) in [
        (MAIN, INSIDE, -Vec3::Y, FramePath::SeesOut),
        (land_cell(YARD), YARD, Vec3::Y, FramePath::Outdoors),
        (
            CELLAR_SIDE,
            Vec3::new(88.3, 83.2, 40.0),
            Vec3::X,
            FramePath::Sealed,
        ),
    ] {
        let camera = camera(cell, eye, look);
        let mut commands = Vec::new();
        for player in [MAIN, land_cell(YARD), VESTIBULE] {
            let input = FrameInput {
                camera,
                viewer_cell: Some(ViewerCell(cell)),
                player_cell: Some(PlayerCell(player)),
                weather: false,
            };
            let frame = frame_of(&world, &input);
            assert_eq!(frame.path(), path);
            commands.push(frame.commands().to_vec());
        }
        assert!(
            commands.iter().all(|c| *c == commands[0]),
            "independent of the player's cell"
        );
    }
}

#[test]
fn r16_4_weather_asks_the_player_not_the_camera() {
    let Some(world) = world("cottage-1") else { return };
    for (player, want) in [(MAIN, false), (land_cell(YARD), true)] {
        let input = FrameInput {
            player_cell: Some(PlayerCell(player)),
            weather: true,
            ..FrameInput::new(camera(MAIN, INSIDE, -Vec3::Y))
        };
        let frame = frame_of(&world, &input);
        assert_eq!(frame.commands().contains(&Command::Weather), want);
    }
}

#[test]
fn r2_a_sealed_dungeon_draws_no_landscape() {
    let Some(world) = world("dungeon-1") else { return };
    let block = vestibule_world::BlockId((2847146240u32 >> 16) as u16);
    let found = (0..=u16::MAX)
        .map(vestibule_world::BlockId)
        .filter(|b| *b == block || b.is_on_map())
        .find_map(|b| world.block(b).filter(|b| b.env_cells().next().is_some()));
    let block = found.unwrap();
    let openings = Openings::new();
    let mut frame = FrameView::default();
    let mut count = 0;
    for cell in block.env_cells() {
        let bounds = cell.structure.bounds.unwrap();
        let eye = cell.frame.local_to_global((bounds.min + bounds.max) * 0.5);
        for k in 0..16 {
            let yaw = k as f32 * 0.4;
            let look = Vec3::new(libm::sinf(yaw), libm::cosf(yaw), 0.2);
            let input = FrameInput::new(camera(cell.id, eye, look));
            let path = frame.update(&world, &openings, &WorldObjects::new(&world), &input);
            assert_eq!(path, FramePath::Sealed);
            assert!(!frame.commands().iter().any(is_landscape) && !frame.draws_landscape());
            assert!(!frame.commands().contains(&Command::ClearDepth));
            count += 1;
        }
    }
    assert!(count >= 300, "{count}");
}

#[test]
fn r16_lost_cells_fall_back_and_are_counted() {
    let Some(world) = world("cottage-1") else { return };
    let absent = CellId(0xA9B4_0199);
    let lost = |player: Option<CellId>| FrameInput {
        camera: camera(absent, INSIDE, -Vec3::Y),
        viewer_cell: None,
        player_cell: player.map(PlayerCell),
        weather: false,
    };
    let (openings, objects) = (Openings::new(), WorldObjects::new(&world));
    let mut frame = FrameView::default();
    assert_eq!(
        frame.update(&world, &openings, &objects, &lost(None)),
        FramePath::Nothing
    );
    assert_eq!(frame.counters().nothing_to_draw, 1);
    assert!(
        frame.commands().contains(&Command::Sky),
        "sky and fog colour, not an unexplained empty screen"
    );
    assert_eq!(
        frame.update(&world, &openings, &objects, &lost(Some(MAIN))),
        FramePath::SeesOut
    );
    assert_eq!(frame.counters().fell_back_to_player, 1);
    assert_eq!(frame.interior().unwrap().cells()[0].id, MAIN);
    assert_eq!(
        frame.update(&world, &openings, &objects, &lost(Some(absent))),
        FramePath::SeesOut
    );
    assert_eq!(frame.counters().fell_back_to_last, 1);
    let before = frame.commands().to_vec();
    let error = Camera::new(MAIN, INSIDE, Vec3::NAN, Vec3::Z, 1.0, VIEWPORT).unwrap_err();
    assert_eq!(frame.keep(error), FramePath::SeesOut);
    assert_eq!((frame.commands(), frame.counters().kept), (&before[..], 1));
    // An outdoor cell of a landblock that does not exist: sky, and the missing blocks counted.
    let nowhere = FrameInput::new(camera(CellId(0x1010_0001), INSIDE, Vec3::Y));
    assert_eq!(
        frame.update(&world, &openings, &objects, &nowhere),
        FramePath::Outdoors
    );
    assert!(frame.counters().missing_blocks > 0);
}

fn at(commands: &[Command], f: impl Fn(&Command) -> bool) -> Option<usize> {
    commands.iter().position(f)
}

#[test]
fn r19_order_from_outdoors() {
    let Some(world) = world("cottage-1") else { return };
    let frame = frame_of(&world, &FrameInput::new(camera(land_cell(YARD), YARD, Vec3::Y)));
    let c = frame.commands();
    assert_eq!(frame.look_ins().list().len(), 1, "one door faces the yard");
    let sky = at(c, |c| matches!(c, Command::Sky)).unwrap();
    let punch = at(c, |c| matches!(c, Command::Punch { .. })).unwrap();
    let room = at(c, |c| matches!(c, Command::Room { .. })).unwrap();
    let shell = at(c, |c| matches!(c, Command::Building { .. })).unwrap();
    let flush = c[..punch]
        .iter()
        .rposition(|c| matches!(c, Command::FlushAlpha))
        .unwrap();
    let first_terrain = at(c, |c| matches!(c, Command::Terrain(_))).unwrap();
    assert!(
        sky < first_terrain && flush < punch && punch < room && room < shell,
        "{c:#?}"
    );
    // Nothing lies between the flush and the punch but the door's own building.
    assert_eq!(flush + 1, punch);
    let (indoor, sun) = (Command::Light(LightSet::Indoor), Command::Light(LightSet::Sun));
    assert!(c[punch..room].contains(&indoor) && c[room..shell].contains(&sun));
    assert_eq!(c.iter().filter(|c| matches!(c, Command::Sky)).count(), 1);
    assert_eq!(c.last(), Some(&Command::FlushAlpha));
    // Terrain far to near by ring of land cells around the viewer's.
    let mut last = i32::MAX;
    for cell in c.iter().filter_map(|c| {
        if let Command::Terrain(id) = c {
            Some(*id)
        } else {
            None
        }
    }) {
        if cell.block() == MAIN.block() {
            let (here, there) = (land_cell(YARD).land_coord().unwrap(), cell.land_coord().unwrap());
            let ring = (here.x - there.x).abs().max((here.y - there.y).abs());
            assert!(ring <= last);
            last = ring;
        }
    }
    assert_eq!(last, 0);
}

#[test]
fn r19_order_from_a_room_that_sees_out() {
    let Some(world) = world("cottage-1") else { return };
    let frame = frame_of(&world, &FrameInput::new(camera(MAIN, INSIDE, -Vec3::Y)));
    let c = frame.commands();
    assert_eq!(frame.landscape_views().len(), 1);
    let sky = at(c, |c| matches!(c, Command::Sky)).unwrap();
    let stamp = at(c, |c| matches!(c, Command::NextStamp)).unwrap();
    let clear = at(c, |c| matches!(c, Command::ClearDepth)).unwrap();
    let seal = at(c, |c| matches!(c, Command::Seal { .. })).unwrap();
    let room = c[clear..]
        .iter()
        .position(|c| matches!(c, Command::Room { .. }))
        .unwrap()
        + clear;
    assert!(sky < stamp && stamp < clear && clear < seal && seal < room);
    assert!(
        c[clear..].iter().all(|c| !is_landscape(c)),
        "exactly one landscape walk, before the clear"
    );
    assert_eq!(c.iter().filter(|c| matches!(c, Command::ClearDepth)).count(), 1);
    // The nearest room comes last.
    let rooms: Vec<CellId> = c[clear..]
        .iter()
        .filter_map(|c| {
            if let Command::Room { cell, .. } = c {
                Some(*cell)
            } else {
                None
            }
        })
        .collect();
    assert_eq!(rooms.last(), Some(&MAIN));
    let listed: Vec<CellId> = frame
        .interior()
        .unwrap()
        .cells()
        .iter()
        .rev()
        .map(|c| c.id)
        .collect();
    assert_eq!(rooms, listed);
    // The seal is the opening as seen, at its own depth: the way out at y = 79.
    let Command::Seal {
        polygon, depth, cell, ..
    } = c[seal]
    else {
        unreachable!()
    };
    assert_eq!((depth, cell), (SealDepth::True, VESTIBULE));
    for p in frame.polygon(polygon) {
        assert!((p.y + INSIDE.y - 79.0).abs() < 1e-3, "{p}");
    }
}

#[test]
fn r7_6a_a_seal_before_the_near_plane_is_split() {
    let Some(world) = world("cottage-1") else { return };
    for (distance, near, far) in [(0.02, true, true), (0.09, true, true), (0.5, false, true)] {
        // Standing in the doorway, looking along the wall and out: part of the opening is nearer than 0.1 m.
        let eye = Vec3::new(84.0, 79.0 + distance, 41.6);
        let frame = frame_of(
            &world,
            &FrameInput::new(camera(VESTIBULE, eye, Vec3::new(0.9, -0.44, 0.0))),
        );
        let depths: Vec<SealDepth> = frame
            .commands()
            .iter()
            .filter_map(|c| {
                if let Command::Seal { depth, .. } = c {
                    Some(*depth)
                } else {
                    None
                }
            })
            .collect();
        assert_eq!(depths.contains(&SealDepth::Nearest), near, "{distance}");
        assert_eq!(depths.contains(&SealDepth::True), far, "{distance}");
        for c in frame.commands() {
            let Command::Seal { polygon, depth, .. } = c else {
                continue;
            };
            for p in frame.polygon(*polygon) {
                let w = frame.camera().unwrap().forward().dot(*p);
                match depth {
                    SealDepth::True => assert!(w >= 0.1 - 1e-5),
                    SealDepth::Nearest => assert!(w <= 0.1 + 1e-5),
                }
            }
        }
    }
}

#[test]
fn r20_everything_once_between_stamps() {
    let Some(world) = world("gallery-1") else { return };
    let openings = Openings::new();
    let mut frame = FrameView::default();
    let block = world.block(vestibule_world::BlockId(0xA9B4)).unwrap();
    let (mut looked, mut drawn_twice) = (0, 0);
    for cell in block.env_cells() {
        let bounds = cell.structure.bounds.unwrap();
        for k in 0..400u32 {
            // Spread over the room by whole steps.
            let part = |step: u32| (k * step % 97) as f32 / 97.0;
            let inside = Vec3::new(part(13), part(29), 0.3 + 0.4 * part(41));
            let eye = cell
                .frame
                .local_to_global(bounds.min + (bounds.max - bounds.min) * inside);
            if !cell.contains_point(eye) {
                continue;
            }
            let look = Vec3::new(libm::sinf(k as f32), libm::cosf(k as f32), 0.0);
            let input = FrameInput::new(camera(cell.id, eye, look));
            frame.update(&world, &openings, &WorldObjects::new(&world), &input);
            looked += frame.look_ins().list().len();
            let (mut rooms, mut objects) = (HashSet::new(), HashSet::new());
            let mut before = HashSet::new();
            for c in frame.commands() {
                match c {
                    Command::NextStamp => {
                        before = core::mem::take(&mut rooms);
                        rooms.clear();
                        objects.clear();
                    }
                    Command::Room { cell, .. } => {
                        assert!(rooms.insert(*cell));
                        drawn_twice += usize::from(before.contains(cell));
                    }
                    Command::Object { id, .. } => assert!(objects.insert(*id)),
                    _ => {}
                }
            }
        }
    }
    let _ = writeln!(
        std::io::stderr(),
        "{looked} looks into buildings from rooms, {drawn_twice} rooms drawn twice"
    );
    assert!(
        drawn_twice > 0,
        "the own house seen through its window, once a stamp"
    );
}

#[test]
fn s11_3_objects_of_rooms_that_are_not_listed_are_not_drawn() {
    let Some(world) = world("cottage-1") else { return };
    let frame = frame_of(&world, &FrameInput::new(camera(MAIN, INSIDE, -Vec3::Y)));
    let listed: Vec<CellId> = frame.interior().unwrap().cells().iter().map(|c| c.id).collect();
    let clear = at(frame.commands(), |c| matches!(c, Command::ClearDepth)).unwrap();
    for c in &frame.commands()[clear..] {
        if let Command::Object { cell, .. } = c {
            assert!(listed.contains(cell));
        }
    }
    for c in &frame.commands()[..clear] {
        if let Command::Object { cell, .. } = c {
            assert!(cell.is_land_cell());
        }
    }
}

#[test]
fn r12_without_a_shell_there_is_neither_punch_nor_room() {
    struct NoShells;
    impl FrameSource for NoShells {
        fn objects_in(&self, _: CellId, _: &mut dyn FnMut(vestibule_view::FrameObject)) {}
        fn building_model(&self, _: &Building, _: f32) -> Option<u32> {
            None
        }
    }
    let Some(world) = world("cottage-1") else { return };
    let mut frame = FrameView::default();
    let input = FrameInput::new(camera(land_cell(YARD), YARD, Vec3::Y));
    frame.update(&world, &Openings::new(), &NoShells, &input);
    assert!(!frame.commands().iter().any(|c| {
        matches!(
            c,
            Command::Punch { .. } | Command::Room { .. } | Command::Building { .. }
        )
    }));
}

#[test]
fn r28_the_same_input_gives_the_same_frame() {
    let Some(world) = world("cottage-2") else { return };
    let openings = Openings::new();
    let mut used = FrameView::default();
    for k in 0..40 {
        let yaw = k as f32 * 0.37;
        let look = Vec3::new(libm::sinf(yaw), libm::cosf(yaw), -0.05);
        let (cell, eye) = if k % 2 == 0 {
            (land_cell(YARD), YARD)
        } else {
            (MAIN, INSIDE)
        };
        let input = FrameInput::new(camera(cell, eye, look));
        used.update(&world, &openings, &WorldObjects::new(&world), &input);
        let fresh = frame_of(&world, &input);
        assert_eq!(used.commands(), fresh.commands());
        assert_eq!(used.floods(), fresh.floods());
        assert_eq!(used.counters(), fresh.counters());
    }
}

/// `visibility.md` 15: several viewers in one frame share openings and world, nothing else.
#[test]
fn several_viewers_do_not_disturb_each_other() {
    let Some(world) = world("cottage-1") else { return };
    let openings = Openings::new();
    let inputs = [
        FrameInput::new(camera(MAIN, INSIDE, -Vec3::Y)),
        FrameInput::new(camera(land_cell(YARD), YARD, Vec3::Y)),
    ];
    let alone: Vec<FrameView> = inputs.iter().map(|i| frame_of(&world, i)).collect();
    std::thread::scope(|scope| {
        let workers: Vec<_> = inputs
            .iter()
            .map(|input| {
                let (world, openings) = (&world, &openings);
                scope.spawn(move || {
                    let mut frame = FrameView::default();
                    for _ in 0..20 {
                        frame.update(world, openings, &WorldObjects::new(world), input);
                    }
                    frame
                })
            })
            .collect();
        for (worker, alone) in workers.into_iter().zip(&alone) {
            let together = worker.join().unwrap();
            assert_eq!(together.commands(), alone.commands());
            assert_eq!(together.floods(), alone.floods());
        }
    });
}
