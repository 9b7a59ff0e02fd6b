//! Defects of houses and ground, each shown by switching off the rule that prevents it (`rendering.md` 18;
//! `docs/defects.md`).

use crate::common::outdoor_eye;
use crate::*;

/// Counts unexplained pixels over random views of the village's houses, as it is and with other commands.
fn random_views(n: usize, broken: impl Fn(&Stage) -> Vec<Command>) -> (usize, usize) {
    let mut stage = village();
    let oracle = stage.oracle();
    let mut random = Random(3);
    let (mut good, mut bad) = (0, 0);
    let houses: Vec<Vec3> = stage
        .world
        .block(stage.block)
        .unwrap()
        .buildings
        .iter()
        .map(|b| b.frame.origin)
        .collect();
    for k in 0..n {
        let (cell, eye) = outdoor_eye(&stage, &mut random);
        let at = houses[k % houses.len()] + Vec3::Z * 1.5;
        let camera = camera(cell, eye, at - eye, SMALL, 1.2);
        good += wrong(&stage.ids(camera), &oracle, &camera);
        let commands = broken(&stage);
        if commands != stage.frame.commands() {
            bad += wrong(&ids_of(&stage, &commands), &oracle, &camera);
        }
    }
    (good, bad)
}

fn kept(stage: &Stage, keep: impl Fn(&Command) -> bool) -> Vec<Command> {
    without(stage, |c| !keep(c))
}

#[test]
fn d03_haze_over_a_door_when_the_players_cell_is_used() {
    // The camera stands in the barn's door, the player before it.
    let mut stage = village();
    let oracle = stage.oracle();
    let player = CellId(0xA9B4_001B);
    let camera = look(0xA9B4_010C, [58.0, 59.0, 95.4], [72.0, 64.4, 95.2], SMALL);
    let right = stage.ids(camera);
    assert_eq!(wrong(&right, &oracle, &camera), 0);
    let broken = stage.ids(camera.in_cell(player));
    assert!(wrong(&broken, &oracle, &camera) > 300);
    // And a punch instead of a seal: what stands behind the door is painted into the view out.
    let (mut hook, side) = hook();
    let oracle = hook.oracle();
    let camera = look(HOOK_CAMERA.0, HOOK_CAMERA.1, HOOK_CAMERA.2, (96, 72));
    let right = hook.ids(camera);
    assert_eq!(wrong(&right, &oracle, &camera), 0);
    let punched: Vec<Command> = hook
        .frame
        .commands()
        .iter()
        .map(|c| match *c {
            Command::Seal { polygon, .. } => Command::Punch {
                polygon,
                block: hook.block,
                building: 0,
                portal: 0,
            },
            other => other,
        })
        .collect();
    let broken = ids_of(&hook, &punched);
    assert!(broken.count_cell(side) > right.count_cell(side));
    assert!(wrong(&broken, &oracle, &camera) > 0);
}

#[test]
fn d04_a_house_is_gone_when_the_players_cell_is_used() {
    // The camera stands outside, the player in the cottage.
    let mut stage = village();
    let oracle = stage.oracle();
    let camera = before_cottage(SMALL);
    assert_eq!(wrong(&stage.ids(camera), &oracle, &camera), 0);
    let broken = stage.ids(camera.in_cell(CellId(0xA9B4_0101)));
    assert!(wrong(&broken, &oracle, &camera) > 300);
}

#[test]
fn d05_grass_over_a_sunken_floor_without_punches() {
    let mut stage = village();
    let oracle = stage.oracle();
    let camera = before_shop((96, 96));
    let right = stage.ids(camera);
    assert_eq!(wrong(&right, &oracle, &camera), 0);
    let broken = ids_of(&stage, &without(&stage, |c| matches!(c, Command::Punch { .. })));
    assert!(wrong(&broken, &oracle, &camera) > 0);
    assert!(broken.count(PixelKind::Terrain) > right.count(PixelKind::Terrain));
}

#[test]
fn d06_grass_in_a_cellar_without_the_depth_clear() {
    let mut stage = village();
    let oracle = stage.oracle();
    // From above the ground outside, the window in view, over the sunken floor.
    let camera = look(0xA9B4_010E, [106.0, 84.0, 95.3], [109.3, 80.0, 94.4], SMALL);
    let right = stage.ids(camera);
    assert_eq!(wrong(&right, &oracle, &camera), 0);
    let broken = ids_of(&stage, &without(&stage, |c| matches!(c, Command::ClearDepth)));
    assert!(wrong(&broken, &oracle, &camera) > 0);
    assert!(broken.count(PixelKind::Terrain) > right.count(PixelKind::Terrain));
}

#[test]
fn d07_floors_fight_with_ground_without_the_offset() {
    let mut stage = slab();
    let right = fights(&mut stage, &RenderSettings::default());
    let flat = RenderSettings {
        terrain_offset: 0.0,
        ..RenderSettings::default()
    };
    assert_eq!(right, 0);
    assert!(fights(&mut stage, &flat) > 0);
}

#[test]
fn d08_a_hillside_is_missing_when_ground_is_cut_by_cells() {
    let mut stage = village();
    let oracle = stage.oracle();
    let camera = look(0xA9B4_000D, [30.0, 110.0, 98.5], [10.0, 108.0, 97.5], SMALL);
    assert_eq!(wrong(&stage.ids(camera), &oracle, &camera), 0);
    let block = stage.world.block(stage.block).unwrap();
    let built = |id: CellId| block.land_cell(id).is_some_and(|c| c.building.is_some());
    let broken = ids_of(
        &stage,
        &without(&stage, |c| matches!(c, Command::Terrain(id) if built(*id))),
    );
    assert!(wrong(&broken, &oracle, &camera) > 50);
}

#[test]
fn d09_rooms_show_through_roofs_when_all_holes_are_punched_at_the_end() {
    let (good, bad) = random_views(16, |stage| {
        let is_late = |c: &Command| matches!(c, Command::Punch { .. } | Command::Room { .. });
        let mut late = without(stage, is_late);
        late.extend(kept(stage, |c| matches!(c, Command::Punch { .. })));
        late.extend(kept(stage, |c| matches!(c, Command::Room { .. })));
        late
    });
    assert!(good == 0 && bad > 0, "{good} {bad}");
}

#[test]
fn d10_cellars_show_through_hills_when_depth_is_cleared_outdoors() {
    let (good, bad) = random_views(16, |stage| {
        let commands = stage.frame.commands().iter();
        let cleared = commands.flat_map(|c| match c {
            Command::Room { .. } => vec![Command::ClearDepth, *c],
            _ => vec![*c],
        });
        cleared.collect()
    });
    assert!(good == 0 && bad > 0, "{good} {bad}");
}

#[test]
fn d11_houses_are_hollow_when_rooms_are_culled_from_outdoors() {
    let mut stage = village();
    let oracle = stage.oracle();
    let camera = before_cottage((200, 150));
    let right = stage.ids(camera);
    assert_eq!(wrong(&right, &oracle, &camera), 0);
    assert!(right.count(PixelKind::Room) > 200);
    let gone = without(&stage, |c| {
        matches!(c, Command::Room { .. }) || matches!(c, Command::Object { cell, .. } if cell.is_indoor())
    });
    let hollow = wrong(&ids_of(&stage, &gone), &oracle, &camera);
    assert!(hollow > 20, "{hollow}");
}

/// The objects of a world whose first building has no shell yet.
struct NoShell<'a>(WorldObjects<'a>, Vec3);

impl vestibule_view::FrameSource for NoShell<'_> {
    fn objects_in(&self, cell: CellId, each: &mut dyn FnMut(vestibule_view::FrameObject)) {
        self.0.objects_in(cell, each);
    }
    fn building_model(&self, building: &vestibule_world::Building, distance: f32) -> Option<u32> {
        if building.frame.origin == self.1 {
            return None;
        }
        self.0.building_model(building, distance)
    }
}

#[test]
fn r12_d12_furniture_floats_when_rooms_are_drawn_without_their_shell() {
    let mut stage = village();
    let camera = before_cottage(SMALL);
    let index = 0;
    let house = &stage.world.block(stage.block).unwrap().buildings[index];
    let of_house = |id: CellId| id.is_indoor() && id.low() <= 0x109;
    let shown = |image: &IdImage| {
        image
            .ids()
            .iter()
            .filter(|id| id.cell().is_some_and(of_house))
            .count()
    };
    let source = NoShell(WorldObjects::new(&stage.world), house.frame.origin);
    stage
        .frame
        .update(&stage.world, &stage.openings, &source, &FrameInput::new(camera));
    let is_of_house = |c: &Command| match c {
        Command::Building { building, .. } | Command::Punch { building, .. } => *building as usize == index,
        Command::Room { cell, .. } | Command::Object { cell, .. } => of_house(*cell),
        _ => false,
    };
    assert!(!stage.frame.commands().iter().any(is_of_house));
    let right = render_ids(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap();
    assert_eq!((shown(&right), right.count(PixelKind::Background)), (0, 0));
    stage.update(camera);
    let shell = |c: &Command| matches!(c, Command::Building { building, .. } if *building as usize == index);
    let broken = ids_of(&stage, &without(&stage, shell));
    assert!(shown(&broken) > 50);
}

#[test]
fn d24_roofs_are_open_when_shells_are_drawn_before_rooms() {
    let (good, bad) = random_views(16, |stage| {
        let is_shell = |c: &Command| matches!(c, Command::Building { .. });
        let mut shells = kept(stage, is_shell);
        let rest = without(stage, is_shell);
        let sky = rest
            .iter()
            .position(|c| matches!(c, Command::Sky))
            .map_or(0, |k| k + 1);
        let tail = rest[sky..].to_vec();
        let mut all = rest[..sky].to_vec();
        all.append(&mut shells);
        all.extend(tail);
        all
    });
    assert!(good == 0 && bad > 0, "{good} {bad}");
}

#[test]
fn d25_sealed_rooms_under_water_show_when_they_are_drawn_without_portals() {
    // Over the land above the far dungeon.
    let mut stage = Stage::hollow(DEEP).0;
    let camera = look(0x0107_0001, [70.0, -70.0, 20.0], [78.0, -66.0, -20.0], SMALL);
    let right = stage.ids(camera);
    let rooms = |image: &IdImage| image.count(PixelKind::Room);
    assert_eq!(rooms(&right), 0);
    let mut all = vec![Command::ClearDepth];
    let views = vestibule_view::Views::Landscape;
    let cells = stage.world.block(stage.block).unwrap().env_cells();
    all.extend(cells.map(|c| Command::Room { cell: c.id, views }));
    let broken = [stage.frame.commands(), &all[..]].concat();
    assert!(rooms(&ids_of(&stage, &broken)) > 100);
}

#[test]
fn d27_the_first_frame_indoors_shows_grass_without_its_depth_clear() {
    let first = |clears_at_once: bool| {
        let mut stage = village();
        let first = stage.ids(in_shop(SMALL));
        // Retail clears only if the frame before had sealed something (`rendering.md` 5.4).
        let first = match clears_at_once {
            true => first,
            false => ids_of(&stage, &without(&stage, |c| matches!(c, Command::ClearDepth))),
        };
        compare(&first, &stage.ids(in_shop(SMALL))).differing
    };
    assert_eq!(first(true), 0);
    assert!(first(false) > 0);
}
