//! What a walk keeps for the next one changes nothing (`rendering.md` 5, 6).

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use vestibule_render::{
    Assets, Canvas, Mesh, Picture, Piece, Placed, PortalDepth, RenderSettings, Scene, SkyThing, Walk,
    WalkCounters, WalkMemory,
};
use vestibule_view::{Camera, FrameInput, FrameView, Openings, WorldObjects};
use vestibule_world::{BlockId, CellId, CellManager, Frame, Position, ResidencySettings, World};

/// Writes down what is drawn, the mesh by its size and the light by its kind and number of lamps.
#[derive(Default, PartialEq, Debug)]
struct Notes(Vec<String>);

impl Canvas for Notes {
    fn sky(&mut self, bounds: [u32; 4]) {
        self.0.push(format!("sky {bounds:?}"));
    }

    fn sky_thing(&mut self, _: &Arc<Mesh>, placed: &Placed, _: &SkyThing) {
        self.0.push(format!("sky thing {placed:?}"));
    }

    fn land_cell(&mut self, cell: CellId) -> bool {
        self.0.push(format!("ground {cell}"));
        true
    }

    fn land_block(&mut self, block: BlockId, stride: u8) -> bool {
        self.0.push(format!("ground {} {stride}", block.0));
        true
    }

    fn behind_exit(&mut self, points: &[DVec3]) {
        self.0.push(format!("exit {points:?}"));
    }

    fn portal(&mut self, points: &[DVec3], depth: PortalDepth) {
        self.0.push(format!("portal {points:?} {depth:?}"));
    }

    fn piece(&mut self, piece: &Piece<'_>) {
        let mesh = (piece.mesh.vertices.len(), piece.mesh.sphere);
        self.0.push(format!(
            "{mesh:?} {:?} {:?} {:?} {} {:?}",
            piece.placed, piece.owner, piece.light, piece.opacity, piece.edges
        ));
    }

    fn flush(&mut self) {
        self.0.push("flush".to_owned());
    }

    fn clear_depth(&mut self) {
        self.0.push("clear".to_owned());
    }
}

/// From the green over the village, before and in the cottage, in the shop.
const VIEWS: [(u32, [f32; 3], [f32; 3]); 4] = [
    (0xA9B4_0029, [130.0, 20.0, 104.0], [110.0, 90.0, 94.0]),
    (0xA9B4_0031, [155.4, 24.0, 95.6], [155.4, 12.0, 95.2]),
    (0xA9B4_0101, [155.4, 11.0, 95.6], [155.4, 30.0, 95.4]),
    (0xA9B4_010E, [109.5, 82.5, 93.9], [103.0, 84.2, 94.6]),
];

fn walk(world: &World, assets: &Assets, detail: f32, memory: &mut WalkMemory) -> Vec<(Notes, WalkCounters)> {
    let settings = RenderSettings {
        detail,
        ..RenderSettings::default()
    };
    let openings = Openings::new();
    let mut frame = FrameView::default();
    let mut out = Vec::new();
    for (cell, eye, at) in VIEWS {
        let (eye, at) = (Vec3::from_array(eye), Vec3::from_array(at));
        let camera = Camera::new(
            CellId(cell),
            eye,
            at - eye,
            Vec3::Z,
            0.94,
            Vec2::new(640.0, 360.0),
        )
        .unwrap();
        let objects = WorldObjects::new(world);
        frame.update(world, &openings, &objects, &FrameInput::new(camera));
        let (scene, picture) = (Scene::new(world, assets), Picture::of(&frame).unwrap());
        let mut notes = Notes::default();
        let met = Walk::new(&scene, &settings, &picture, memory).run(&mut notes);
        out.push((notes, met));
    }
    out
}

fn open() -> World {
    World::open(vestibule_forge::embedded_world().unwrap().memory_records()).unwrap()
}

#[test]
fn r17_1_what_is_kept_changes_nothing() {
    let (world, assets) = (open(), Assets::new());
    let mut memory = WalkMemory::new();
    for detail in [0.0, -1.0, 1.0, 0.0] {
        let kept = walk(&world, &assets, detail, &mut memory);
        assert!(kept.iter().all(|(notes, _)| notes.0.len() > 40));
        assert!(
            kept == walk(&world, &assets, detail, &mut WalkMemory::new()),
            "{detail}"
        );
    }
}

#[test]
fn what_is_kept_is_forgotten_with_the_assets() {
    let (world, assets) = (open(), Assets::new());
    let mut memory = WalkMemory::new();
    let one = walk(&world, &assets, 0.0, &mut memory);
    drop((world, assets));
    let (world, assets) = (open(), Assets::new());
    assert!(walk(&world, &assets, 0.0, &mut memory) == one);
}

#[test]
fn w12_what_is_kept_follows_residency() {
    let (mut world, assets) = (open(), Assets::new());
    let settings = ResidencySettings {
        threaded: false,
        ..ResidencySettings::default()
    };
    let mut cells = CellManager::new(&mut world, settings);
    let mut memory = WalkMemory::new();
    let home = Position {
        cell: CellId(0xA9B4_0029),
        frame: Frame::at(Vec3::new(130.0, 20.0, 104.0)),
    };
    let away = Position {
        cell: CellId(0xC7B4_0001),
        frame: Frame::at(Vec3::new(3.0, 3.0, 0.0)),
    };
    let mut there = Vec::new();
    for to in [&home, &away, &home] {
        cells.change_position(&mut world, to);
        cells.finish(&mut world);
        let kept = walk(&world, &assets, 0.0, &mut memory);
        assert!(kept == walk(&world, &assets, 0.0, &mut WalkMemory::new()));
        there.push(kept);
    }
    assert!(there[0] == there[2] && there[0] != there[1]);
}
