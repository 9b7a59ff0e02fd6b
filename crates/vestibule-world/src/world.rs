//! The world: landblocks loaded on first touch, and the look-ups everything else stands on (`world.md` 15, 17).

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use glam::Vec3;
use vestibule_dat::record;

use crate::constants::BLOCK_LENGTH;
use crate::env_cell::EnvCell;
use crate::error::{LoadProblem, WorldError};
use crate::ids::{BlockId, CellId};
use crate::landblock::{BoxedBlock, Landblock};
use crate::load;
use crate::records::Records;
use crate::region::Region;
use crate::shadow::ShadowLists;
use crate::shape::{Building, Model, Shape, StaticObject, StaticRef};
use crate::source::{RecordSource, Store};
use crate::terrain::{LandCell, Water};

/// Landblock slots: one for every high word.
const BLOCK_SLOTS: usize = 1 << 16;

/// How a world answers where prior art and retail differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorldSettings {
    /// Apply the block offset when spheres enter a building of a neighbouring landblock (`world.md` D4). Retail
    /// does not: such a building is entered one step later, once the position has crossed the border.
    pub offset_building_transit: bool,
    /// Work out none of the hints that spare most look-ups and collisions their exact tests. Answers are the same
    /// to the bit, only slower: this is what shortcuts are held against.
    pub exact: bool,
}

/// What the DAT files say, compiled for look-ups. Landblocks load when first touched, from any thread; once
/// loaded they do not change. Share it by reference.
///
/// With a [`crate::CellManager`] nothing loads when touched; what is resident follows one viewer by retail's rules.
pub struct World {
    records: Arc<Records>,
    settings: WorldSettings,
    blocks: Box<[OnceLock<Option<Box<Landblock>>>]>,
    distant: BTreeMap<BlockId, Box<Landblock>>,
    loads_on_touch: bool,
}

impl World {
    /// Opens a world over `source`. Reads the Region record only.
    ///
    /// # Errors
    /// When the Region record (0x13000000) is missing or damaged.
    pub fn open(source: impl RecordSource + 'static) -> Result<Self, WorldError> {
        Self::with_settings(source, WorldSettings::default())
    }

    /// As [`World::open`], with settings other than retail's.
    ///
    /// # Errors
    /// As [`World::open`].
    pub fn with_settings(
        source: impl RecordSource + 'static,
        settings: WorldSettings,
    ) -> Result<Self, WorldError> {
        let region = Region::read(&source)?;
        let blocks = (0..BLOCK_SLOTS).map(|_| OnceLock::new()).collect();
        Ok(World {
            records: Arc::new(Records::new(Box::new(source), region, settings.exact)),
            settings,
            blocks,
            distant: BTreeMap::new(),
            loads_on_touch: true,
        })
    }

    /// The settings the world was opened with.
    #[inline]
    pub fn settings(&self) -> &WorldSettings {
        &self.settings
    }

    /// The land definitions of the Region record.
    pub fn region(&self) -> &Region {
        &self.records.region
    }

    /// Where the records come from.
    pub fn source(&self) -> &dyn RecordSource {
        &*self.records.source
    }

    /// The landblock, loaded if it was not. `None` when neither terrain nor env cells can be had there.
    #[inline(always)]
    pub fn block(&self, id: BlockId) -> Option<&Landblock> {
        let slot = &self.blocks[usize::from(id.0)];
        match slot.get() {
            Some(block) => block.as_deref(),
            None => self.load_block(id),
        }
    }

    #[cold]
    fn load_block(&self, id: BlockId) -> Option<&Landblock> {
        if !self.loads_on_touch {
            return None;
        }
        let slot = &self.blocks[usize::from(id.0)];
        slot.get_or_init(|| {
            if id.is_on_map() {
                load::landblock(&self.records, id).map(Box::new)
            } else {
                None
            }
        })
        .as_deref()
    }

    /// The landblock if it has been loaded already. Of a world with a [`crate::CellManager`] also distant
    /// landscape, which is drawn but which physics does not know.
    pub fn loaded_block(&self, id: BlockId) -> Option<&Landblock> {
        match self.blocks[usize::from(id.0)].get() {
            Some(block) => block.as_deref(),
            None => self.distant.get(&id).map(|block| &**block),
        }
    }

    /// Whether landblocks load when they are first touched. Not so in a world with a [`crate::CellManager`].
    pub fn loads_on_touch(&self) -> bool {
        self.loads_on_touch
    }

    /// The env cell if it is resident (retail `CEnvCell::GetVisible`).
    #[inline]
    pub fn env_cell(&self, id: CellId) -> Option<&EnvCell> {
        if !id.is_indoor() {
            return None;
        }
        self.block(id.block())?.env_cell(id)
    }

    /// The land cell if its landblock is loaded (retail `CLandCell::GetVisible`).
    #[inline]
    pub fn land_cell(&self, id: CellId) -> Option<&LandCell> {
        if !id.is_land_cell() {
            return None;
        }
        self.block(id.block())?.land_cell(id)
    }

    /// Whether the cell is resident (retail `GetVisible` finds one, `world.md` V1).
    #[inline]
    pub fn is_resident(&self, id: CellId) -> bool {
        if id.is_indoor() {
            self.env_cell(id).is_some()
        } else {
            self.land_cell(id).is_some()
        }
    }

    /// The building registered with a land cell.
    #[inline]
    pub fn building_on(&self, id: CellId) -> Option<&Building> {
        self.block(id.block())?.building_on(id)
    }

    /// Whether `q`, in the frame of the cell's landblock, is inside the cell (retail `point_in_cell`,
    /// `world.md` P4). False for cells that are not resident.
    #[inline]
    pub fn point_in_cell(&self, id: CellId, q: Vec3) -> bool {
        if id.is_indoor() {
            self.env_cell(id).is_some_and(|cell| cell.contains_point(q))
        } else {
            self.land_cell(id)
                .is_some_and(|cell| cell.find_terrain_poly(q).is_some())
        }
    }

    /// Static objects found in a cell, its shadow list (`world.md` 14), in retail's order.
    #[inline]
    pub fn statics_in(&self, cell: CellId) -> &[StaticRef] {
        match self.block(cell.block()) {
            Some(block) => self.shadow_lists(block).of(cell),
            None => &[],
        }
    }

    /// The shadow lists of a landblock of this world.
    #[inline]
    pub fn shadow_lists<'w>(&'w self, block: &'w Landblock) -> &'w ShadowLists {
        match block.shadows.get() {
            Some(lists) => lists,
            None => block.shadows.get_or_init(|| ShadowLists::build(self, block)),
        }
    }

    /// The static object a reference names.
    #[inline]
    pub fn static_object(&self, r: StaticRef) -> Option<&StaticObject> {
        self.block(r.block)?.statics.get(r.index as usize)
    }

    /// Water of the landblock; [`Water::Not`] without terrain.
    pub fn block_water(&self, id: BlockId) -> Water {
        self.block(id)
            .and_then(|b| b.land.as_ref())
            .map_or(Water::Not, |land| land.water)
    }

    /// The ground over or under a point: land cell, height in metres. `p` is in the frame of `cell`'s landblock
    /// and may lie outside it.
    pub fn ground_at(&self, cell: CellId, p: Vec3) -> Option<Ground<'_>> {
        let (id, q) = cell.adjust_to_outside(p)?;
        let land_cell = self.land_cell(id)?;
        let polygon = land_cell.find_terrain_poly(q)?;
        Some(Ground {
            cell: id,
            point: q,
            z: polygon.height_at(q)?,
            land_cell,
            polygon,
        })
    }

    /// What could not be loaded so far, oldest first.
    pub fn problems(&self) -> Vec<LoadProblem> {
        self.records.problems()
    }

    /// Number of load problems so far, also those no longer kept.
    pub fn problem_count(&self) -> usize {
        self.records.problem_count()
    }

    /// The model of a GfxObj record (0x01…), compiled on first use. `needed_by` is named when it is missing.
    pub fn model(&self, id: u32, needed_by: u32) -> Option<Arc<Model>> {
        self.records.model(id, needed_by)
    }

    /// The shape of a Setup record (0x02…), or of a GfxObj (0x01…) as a setup of one part.
    pub fn shape(&self, id: u32, needed_by: u32) -> Option<Arc<Shape>> {
        self.records.shape(id, needed_by)
    }

    /// Reads and parses a portal record that `needed_by` refers to; problems are reported and answer `None`.
    pub(crate) fn parse<T>(
        &self,
        store: Store,
        id: u32,
        needed_by: u32,
        parse: impl FnOnce(u32, &[u8]) -> Result<T, record::RecordError>,
    ) -> Option<T> {
        self.records.parse(store, id, needed_by, parse)
    }
}

/// What a [`crate::CellManager`] does to its world.
impl World {
    pub(crate) fn records(&self) -> &Arc<Records> {
        &self.records
    }

    /// From now on nothing loads when it is touched. Returns the blocks that were loaded.
    pub(crate) fn stop_loading_on_touch(&mut self) -> Vec<BoxedBlock> {
        self.loads_on_touch = false;
        self.blocks
            .iter_mut()
            .filter_map(|slot| slot.take().flatten())
            .collect()
    }

    /// Makes a block known, or unknown, to physics. Returns what was there.
    pub(crate) fn set_block(&mut self, id: BlockId, block: Option<Box<Landblock>>) -> Option<Box<Landblock>> {
        let slot = &mut self.blocks[usize::from(id.0)];
        let old = slot.take().flatten();
        if let Some(block) = block {
            // The slot was emptied above.
            let _ = slot.set(Some(block));
        }
        old
    }

    pub(crate) fn block_mut(&mut self, id: BlockId) -> Option<&mut Landblock> {
        self.blocks[usize::from(id.0)].get_mut()?.as_deref_mut()
    }

    /// Blocks of the landscape window that physics does not know.
    pub(crate) fn distant(&mut self) -> &mut BTreeMap<BlockId, Box<Landblock>> {
        &mut self.distant
    }
}

/// Terrain under a point, from [`World::ground_at`].
#[derive(Clone, Copy, Debug)]
pub struct Ground<'w> {
    /// The land cell.
    pub cell: CellId,
    /// The point in the frame of the land cell's landblock.
    pub point: Vec3,
    /// Height of the ground there, metres.
    pub z: f32,
    /// The land cell's data.
    pub land_cell: &'w LandCell,
    /// The triangle.
    pub polygon: &'w crate::terrain::TerrainPolygon,
}

impl Ground<'_> {
    /// How far a body sinks in here, metres (`world.md` A5).
    pub fn water_depth(&self) -> f32 {
        self.land_cell.water_depth(self.point)
    }
}

impl core::fmt::Debug for World {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let loaded = self
            .blocks
            .iter()
            .filter(|b| b.get().is_some_and(Option::is_some))
            .count();
        f.debug_struct("World")
            .field("loaded_blocks", &loaded)
            .field("problems", &self.problem_count())
            .finish()
    }
}

/// Whether a landblock-frame point lies over the landblock's own square.
pub fn is_over_block(p: Vec3) -> bool {
    (0.0..BLOCK_LENGTH).contains(&p.x) && (0.0..BLOCK_LENGTH).contains(&p.y)
}
