//! A world, cameras in it, and comparing pictures.
#![allow(dead_code, reason = "each binary uses a part of it")]
#![allow(unreachable_pub, reason = "shared by inclusion")]

use std::io::Write as _;
use std::path::PathBuf;

use glam::{Vec2, Vec3};
use vestibule_gpu::{AdapterChoice, Gpu};
use vestibule_render::{Assets, IdImage, Image, Scene};
use vestibule_view::{Camera, FrameInput, FrameView, Openings, WorldObjects};
use vestibule_world::{BlockId, CellId, World};

pub const VILLAGE: BlockId = BlockId(0xA9B4);
pub const DEEP: BlockId = BlockId(0x0107);

/// The built-in world with everything drawing it needs.
pub struct Stage {
    pub world: World,
    pub openings: Openings,
    pub assets: Assets,
    pub frame: FrameView,
}

impl Stage {
    pub fn new() -> Self {
        let compiled = vestibule_forge::embedded_world().unwrap();
        Stage {
            world: World::open(compiled.memory_records()).unwrap(),
            openings: Openings::new(),
            assets: Assets::new(),
            frame: FrameView::default(),
        }
    }

    pub fn look(&mut self, camera: Camera) {
        let objects = WorldObjects::new(&self.world);
        self.frame
            .update(&self.world, &self.openings, &objects, &FrameInput::new(camera));
    }

    pub fn scene(&self) -> Scene<'_> {
        Scene::new(&self.world, &self.assets)
    }
}

/// The software adapter; `None`, with a notice, where there is none.
pub fn software() -> Option<Gpu> {
    let mut err = std::io::stderr();
    match Gpu::headless(AdapterChoice::Software) {
        Ok(gpu) => {
            let _ = writeln!(err, "adapter: {}", gpu.name());
            Some(gpu)
        }
        Err(error) => {
            let _ = writeln!(err, "skipped: {error} (Debian: mesa-vulkan-drivers libvulkan1)");
            None
        }
    }
}

/// A small fixed generator.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn between(&mut self, a: f32, b: f32) -> f32 {
        a + (b - a) * ((self.next() >> 40) as f32 / (1u64 << 24) as f32)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() >> 33) as usize % n.max(1)
    }

    /// A direction, more often level than steep.
    pub fn direction(&mut self) -> Vec3 {
        let (s, c) = libm::sincosf(self.between(0.0, core::f32::consts::TAU));
        let pitch = self.between(-1.0, 1.0);
        let (sp, cp) = libm::sincosf(pitch * pitch * pitch * 1.2);
        Vec3::new(s * cp, c * cp, sp)
    }
}

pub fn camera(cell: u32, eye: [f32; 3], at: [f32; 3], size: (u32, u32)) -> Camera {
    let (eye, at) = (Vec3::from_array(eye), Vec3::from_array(at));
    let viewport = Vec2::new(size.0 as f32, size.1 as f32);
    Camera::new(CellId(cell), eye, at - eye, Vec3::Z, 1.2, viewport).unwrap()
}

/// A place somewhere in a room of the block.
pub fn indoors(stage: &Stage, block: BlockId, random: &mut Random, size: (u32, u32)) -> Camera {
    let cells: Vec<_> = stage.world.block(block).unwrap().env_cells().collect();
    loop {
        let cell = cells[random.below(cells.len())];
        let Some(b) = cell.structure.bounds else { continue };
        let share = Vec3::new(
            random.between(0.1, 0.9),
            random.between(0.1, 0.9),
            random.between(0.3, 0.8),
        );
        let eye = cell.frame.local_to_global(b.min + (b.max - b.min) * share);
        if cell.contains_point(eye) {
            let at = eye + random.direction();
            return camera(cell.id.0, eye.to_array(), at.to_array(), size);
        }
    }
}

/// A place somewhere over the ground of the block.
pub fn outdoors(stage: &Stage, block: BlockId, random: &mut Random, size: (u32, u32)) -> Camera {
    let land = stage.world.block(block).unwrap().land.as_ref().unwrap();
    let (x, y) = (random.between(20.0, 170.0), random.between(20.0, 170.0));
    let slot = vestibule_world::terrain::vertex_index((x / 24.0) as usize, (y / 24.0) as usize);
    let eye = Vec3::new(x, y, land.heights[slot] + random.between(2.5, 8.0));
    let cell = CellId::new(block, 1 + 8 * (x / 24.0) as u16 + (y / 24.0) as u16);
    let at = eye + random.direction();
    camera(cell.0, eye.to_array(), at.to_array(), size)
}

/// How two pictures differ.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difference {
    /// Pixels with a channel that differs by more than the tolerance.
    pub differing: usize,
    /// Of these: neither next to an edge between things nor where the picture changes sharply anyhow.
    pub away_from_edges: usize,
    /// Largest difference of a channel away from edges.
    pub largest: u8,
}

fn apart(a: [u8; 4], b: [u8; 4]) -> u8 {
    (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap()
}

/// Compares; `ids` tell where the edges are.
pub fn compare(expected: &Image, actual: &Image, ids: &IdImage, tolerance: u8) -> Difference {
    let mut out = Difference::default();
    for y in 0..expected.height() {
        for x in 0..expected.width() {
            let (e, a) = (expected.get(x, y).unwrap(), actual.get(x, y).unwrap());
            let gap = apart(e, a);
            let id = ids.get(x, y);
            let mut edge = false;
            for (dx, dy) in (0..9).map(|k| (k % 3, k / 3)) {
                let (nx, ny) = ((x + dx).wrapping_sub(1), (y + dy).wrapping_sub(1));
                if let Some(n) = expected.get(nx, ny) {
                    edge |= ids.get(nx, ny) != id || apart(n, e) > 2 * tolerance;
                }
            }
            if gap > tolerance {
                out.differing += 1;
                out.away_from_edges += usize::from(!edge);
            }
            if !edge && gap > out.largest {
                out.largest = gap;
            }
        }
    }
    out
}

/// Where pictures of failures go.
pub fn failures() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_TMPDIR").map(PathBuf::from);
    let folder = target
        .unwrap_or_else(|| PathBuf::from(env!("CARGO_TARGET_TMPDIR")))
        .join("gpu-failures");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Leaves expected, actual and difference (times eight) beside each other; returns the folder.
pub fn leave(name: &str, expected: &Image, actual: &Image) -> PathBuf {
    let folder = failures();
    expected
        .save_png(folder.join(format!("{name}-expected.png")))
        .unwrap();
    actual
        .save_png(folder.join(format!("{name}-actual.png")))
        .unwrap();
    let mut difference = expected.clone();
    for (p, a) in difference.pixels_mut().iter_mut().zip(actual.pixels()) {
        for k in 0..3 {
            p[k] = p[k].abs_diff(a[k]).saturating_mul(8);
        }
    }
    difference
        .save_png(folder.join(format!("{name}-difference.png")))
        .unwrap();
    folder
}
