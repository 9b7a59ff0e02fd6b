//! A world with everything drawing it needs.

use glam::{Vec2, Vec3};
use vestibule_dat::DatSet;
use vestibule_forge::CompiledWorld;
use vestibule_render::{
    Assets, Everything, IdImage, Oracle, RenderSettings, Scene, render_everything_ids, render_ids,
};
use vestibule_view::{Camera, FrameInput, FrameSettings, FrameView, Openings, WorldObjects};
use vestibule_world::{BlockId, CellId, MemoryRecords, RecordSource as _, Store, World};

/// The records of the built-in world, compiled once.
pub fn hollow_records() -> &'static CompiledWorld {
    static COMPILED: std::sync::OnceLock<CompiledWorld> = std::sync::OnceLock::new();
    COMPILED.get_or_init(|| vestibule_forge::embedded_world().unwrap())
}

/// A world with everything drawing it needs.
pub struct Stage {
    pub world: World,
    pub openings: Openings,
    pub assets: Assets,
    pub frame: FrameView,
    pub block: BlockId,
}

impl Stage {
    pub fn new(world: World, block: BlockId) -> Self {
        // Full detail everywhere, as the oracle and the picture of everything have it.
        let settings = FrameSettings {
            block_radius: 2,
            full_detail_rings: 2,
            ..FrameSettings::default()
        };
        Stage {
            world,
            openings: Openings::new(),
            assets: Assets::new(),
            frame: FrameView::new(settings),
            block,
        }
    }

    /// The built-in world, with the names of its cells.
    pub fn hollow(block: u16) -> (Self, std::collections::BTreeMap<CellId, String>) {
        (Self::edited(block, |_| {}), hollow_records().cell_names.clone())
    }

    /// The built-in world with other records.
    pub fn edited(block: u16, edit: impl FnOnce(&mut MemoryRecords)) -> Self {
        let mut records = hollow_records().memory_records();
        edit(&mut records);
        Stage::new(World::open(records).unwrap(), BlockId(block))
    }

    /// A scene of one landblock.
    pub fn scene_text(block: u16, text: &str) -> (Self, CompiledWorld) {
        let compiled = vestibule_forge::compile_scene("test", text).unwrap_or_else(|e| panic!("{e}"));
        let world = World::open(compiled.memory_records()).unwrap();
        (Stage::new(world, BlockId(block)), compiled)
    }

    /// A world of the test vectors; `None`, with a notice, where they are absent.
    pub fn vectors(name: &str) -> Option<Self> {
        Self::vectors_edited(name, |_| {})
    }

    /// A world of the test vectors with other records.
    pub fn vectors_edited(name: &str, edit: impl FnOnce(&mut MemoryRecords)) -> Option<Self> {
        let folder =
            concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/vectors/worlds/").to_owned() + name;
        if !std::path::Path::new(&folder).is_dir() {
            use std::io::Write as _;
            let _ = writeln!(std::io::stderr(), "skipped: no test vectors at {folder}");
            return None;
        }
        let dats = DatSet::open(&folder).unwrap();
        let mut records = MemoryRecords::new();
        let mut block = None;
        for (store, file) in [(Store::Cell, dats.cell()), (Store::Portal, dats.portal())] {
            for entry in file.iter() {
                let id = entry.unwrap().id;
                let bytes = dats.record(store, id).unwrap().unwrap().into_owned();
                if store == Store::Cell && id & 0xFFFF == 0x0100 {
                    block = block.or(Some(BlockId((id >> 16) as u16)));
                }
                records.insert(store, id, bytes);
            }
        }
        edit(&mut records);
        Some(Stage::new(World::open(records).unwrap(), block.unwrap()))
    }

    pub fn update(&mut self, camera: Camera) {
        self.frame.update(
            &self.world,
            &self.openings,
            &WorldObjects::new(&self.world),
            &FrameInput::new(camera),
        );
    }

    pub fn scene(&self) -> Scene<'_> {
        Scene::new(&self.world, &self.assets)
    }

    /// The id picture of a camera, by the traversal.
    pub fn ids(&mut self, camera: Camera) -> IdImage {
        self.update(camera);
        render_ids(&self.scene(), &self.frame, &RenderSettings::default()).unwrap()
    }

    /// The id picture of a camera, by depth alone: rooms and what is in them (the mazes have ground among their rooms).
    pub fn everything(&self, camera: &Camera) -> IdImage {
        let rooms = Everything {
            radius: 0,
            outdoors: false,
        };
        render_everything_ids(&self.scene(), camera, rooms, &RenderSettings::default()).unwrap()
    }

    pub fn oracle(&self) -> Oracle {
        Oracle::new(&self.world, &self.assets, self.block, 1)
    }
}

pub fn camera(cell: CellId, eye: Vec3, forward: Vec3, size: (u32, u32), fov: f32) -> Camera {
    let viewport = Vec2::new(size.0 as f32, size.1 as f32);
    Camera::new(cell, eye, forward, Vec3::Z, fov, viewport).unwrap()
}
