//! A loaded landblock (`world.md` 6): terrain, land cells, buildings, static objects and env cells.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use crate::constants::BLOCK_SIDE_CELLS;
use crate::env_cell::EnvCell;
use crate::ids::{BlockId, CellId};
use crate::lanes::Lanes;
use crate::shadow::{Reach, ShadowLists};
use crate::shape::{Building, StaticObject};
use crate::terrain::{LandCell, TerrainWord, Water};
use crate::world::World;

/// A landblock as loaded: immutable, shared by reference between threads. Its frame has its origin in the
/// south-west corner, metres.
#[derive(Debug)]
pub struct Landblock {
    /// Which block this is.
    pub id: BlockId,
    /// Terrain; `None` when the LandBlock record is missing: nothing can then be outdoors here (`world.md` B5).
    pub land: Option<Land>,
    /// Buildings in record order.
    pub buildings: Box<[Building]>,
    /// Static objects: the landblock's in record order, then those of its env cells by ascending cell
    /// (`world.md` H7).
    pub statics: Box<[StaticObject]>,
    /// How many of `statics` belong to the landblock itself.
    pub land_statics: u32,
    /// Env cells by low word from 0x0100; `None` where the record is missing or unusable.
    pub env_cells: Box<[Option<EnvCell>]>,
    pub(crate) reach: OnceLock<Reach>,
    pub(crate) shadows: OnceLock<ShadowLists>,
}

/// Landblocks are moved about by their address: they are large.
pub(crate) type BoxedBlock = Box<Landblock>;

/// The terrain of a landblock.
#[derive(Clone, Debug, PartialEq)]
pub struct Land {
    /// Heights of the 81 vertices, x-major, metres.
    pub heights: Box<[f32; 81]>,
    /// Terrain words of the 81 vertices, x-major.
    pub words: Box<[TerrainWord; 81]>,
    /// The 64 land cells in order of their ids.
    pub cells: Box<[LandCell]>,
    /// Water of the whole block (`world.md` A4).
    pub water: Water,
    /// Lowest and highest ground with retail's margins, metres: culling only (`world.md` B4).
    pub z_limits: (f32, f32),
}

impl Landblock {
    /// The land cell with this id; `None` for other ids or without terrain.
    #[inline]
    pub fn land_cell(&self, id: CellId) -> Option<&LandCell> {
        let index = usize::from(id.low().wrapping_sub(1));
        self.land.as_ref()?.cells.get(index)
    }

    /// The land cell over which a point of the block's frame lies; the larger coordinate wins on edges.
    pub fn land_cell_at(&self, p: glam::Vec3) -> Option<(CellId, &LandCell)> {
        let (id, _) = CellId::new(self.id, 0xFFFF).adjust_to_outside(p)?;
        if id.block() != self.id {
            return None;
        }
        self.land_cell(id).map(|cell| (id, cell))
    }

    /// The env cell with this id, if it is resident.
    #[inline]
    pub fn env_cell(&self, id: CellId) -> Option<&EnvCell> {
        let index = usize::from(id.low()).wrapping_sub(0x100);
        self.env_cells.get(index)?.as_ref()
    }

    /// All resident env cells in order of their ids.
    pub fn env_cells(&self) -> impl Iterator<Item = &EnvCell> {
        self.env_cells.iter().flatten()
    }

    /// The block's land cells with their ids.
    pub fn land_cells(&self) -> impl Iterator<Item = (CellId, &LandCell)> {
        let id = self.id;
        let cells = self.land.as_ref().map_or(&[][..], |land| &land.cells);
        cells
            .iter()
            .zip(1u16..)
            .map(move |(cell, low)| (CellId::new(id, low), cell))
    }

    /// Whether spheres that a land cell of this block certainly holds are known to be over ground with nothing else on it:
    /// no static object, building or restriction is near. Known once the shadow lists have been asked for. Radii are in the
    /// fourth lanes.
    #[inline(always)]
    pub fn is_known_open(&self, id: CellId, cell: &LandCell, spheres: [Lanes; 2]) -> bool {
        let lists = self.shadows.get();
        lists.is_some_and(|lists| lists.open_ground.holds(id, cell, spheres))
    }

    /// The building registered with a land cell.
    #[inline]
    pub fn building_on(&self, id: CellId) -> Option<&Building> {
        let index = self.land_cell(id)?.building?;
        self.buildings.get(usize::from(index))
    }

    /// Every env cell named by a portal of a building, in order of first occurrence (`world.md` C4).
    pub fn stab_list(&self) -> Vec<CellId> {
        let mut seen = BTreeSet::new();
        let portals = self.buildings.iter().flat_map(|b| &b.portals);
        let mut out: Vec<CellId> = portals.flat_map(|p| &p.stab_list).copied().collect();
        out.retain(|&id| seen.insert(id));
        out
    }

    /// A landblock with terrain and nothing else.
    pub(crate) fn of_land(id: BlockId, land: Option<Land>) -> Self {
        Landblock {
            id,
            land,
            buildings: [].into(),
            statics: [].into(),
            land_statics: 0,
            env_cells: [].into(),
            reach: OnceLock::new(),
            shadows: OnceLock::new(),
        }
    }

    pub(crate) fn reach(&self, world: &World) -> &Reach {
        self.reach.get_or_init(|| Reach::build(world, self))
    }

    /// Memory the landblock takes, bytes, about: without the assets it shares with others.
    pub fn memory(&self) -> usize {
        let land =
            |land: &Land| size_of_val(&*land.heights) + size_of_val(&*land.words) + size_of_val(&*land.cells);
        let building = |b: &Building| {
            let stabs: usize = b.portals.iter().map(|p| size_of_val(&*p.stab_list)).sum();
            size_of_val(&*b.part_frames) + size_of_val(&*b.portals) + stabs
        };
        size_of::<Self>()
            + self.land.as_ref().map_or(0, land)
            + size_of_val(&*self.buildings)
            + self.buildings.iter().map(building).sum::<usize>()
            + size_of_val(&*self.statics)
            + self
                .statics
                .iter()
                .map(|s| size_of_val(&*s.part_frames))
                .sum::<usize>()
            + size_of_val(&*self.env_cells)
            + self.env_cells().map(EnvCell::memory).sum::<usize>()
            + self.reach.get().map_or(0, Reach::bytes)
            + self.shadows.get().map_or(0, ShadowLists::bytes)
    }

    /// Whether tools should call this a dungeon: env cells and no buildings (`world.md` U4). The engine never
    /// asks.
    pub fn looks_like_a_dungeon(&self) -> bool {
        self.env_cells().next().is_some() && self.buildings.is_empty()
    }
}

/// Number of land cells of a landblock.
pub const LAND_CELLS: usize = (BLOCK_SIDE_CELLS * BLOCK_SIDE_CELLS) as usize;
