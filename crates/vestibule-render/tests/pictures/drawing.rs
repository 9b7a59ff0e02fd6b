//! Order, see-through things, bodies, determinism.

use crate::*;

#[test]
fn r15_a_body_in_a_dungeon_is_drawn_in_its_room() {
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
