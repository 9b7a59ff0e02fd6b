//! Worlds of any size from a number, up to retail's: for measuring, and for finding what breaks when there is much.
//!
//! Geometry is not made anew for every cell. A small scene with a few kinds of houses and a palette of dungeon rooms
//! is compiled once; the world is made of copies, as retail's is. Everything follows from the seed, landblock by
//! landblock, so that memory does not grow with the world but for the directory of the files.

mod dungeon;
mod land;
mod palette;
mod stamp;

use std::collections::BTreeMap;
use std::path::Path;

use vestibule_dat::primitive::Bool32;
use vestibule_dat::record::{LandBlock, LandBlockInfo, RecordError};
use vestibule_dat::{DatBuilder, DatKind, Header, NewFile, Storage, WriteOptions};
use vestibule_world::{BlockId, CellId, Position};

use self::dungeon::Dungeon;
use self::palette::{HOUSES, Palette};
use crate::text::Diagnostics;

/// What a synthetic world is to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyntheticWorld {
    /// Everything follows from it.
    pub seed: u64,
    /// Landblocks along each side, 8 to 255, from the south-west corner of the map.
    pub side: u16,
    /// Buildings with portals.
    pub buildings: u32,
    /// Env cells, those of the buildings included.
    pub env_cells: u32,
    /// Cells of the largest dungeon.
    pub largest_dungeon: u16,
}

/// How far a build has come, in landblocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Landblocks written.
    pub done: u32,
    /// Landblocks there will be.
    pub all: u32,
}

/// What was built, and places to begin a visit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SyntheticReport {
    /// Landblocks with terrain.
    pub landblocks: u32,
    /// Buildings.
    pub buildings: u32,
    /// Portals of buildings.
    pub building_portals: u32,
    /// Env cells.
    pub env_cells: u32,
    /// Portals of env cells, each direction by itself.
    pub cell_portals: u64,
    /// Of them those that lead outside.
    pub portals_outside: u64,
    /// Of them those whose polygon has not four corners.
    pub portals_not_quads: u64,
    /// Static objects.
    pub statics: u64,
    /// Records of both files.
    pub records: u64,
    /// The first cell of each dungeon with the number of its cells, the largest first.
    pub dungeons: Vec<(CellId, u16)>,
    /// The first cell of each landblock with buildings.
    pub towns: Vec<CellId>,
    /// A place in the open, in the middle of the map.
    pub start: Position,
}

/// Why a synthetic world was not built.
#[derive(Debug, thiserror::Error)]
pub enum SyntheticError {
    /// A file could not be written.
    #[error(transparent)]
    Dat(#[from] vestibule_dat::Error),
    /// The numbers contradict each other.
    #[error("{0}")]
    Plan(&'static str),
    /// The palette's scene is wrong: a mistake of this crate.
    #[error("the palette does not compile: {0}")]
    Palette(#[from] Diagnostics),
    /// The palette's records are not as expected: a mistake of this crate.
    #[error("the palette lacks {0}")]
    Incomplete(String),
    /// A record could not be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// What there is in a landblock besides terrain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Site {
    /// So many buildings.
    Town(u8),
    /// So many cells.
    Dungeon(u16),
}

impl SyntheticWorld {
    /// As large as retail (`evidence.md` E3): 65,025 landblocks, 5,464 buildings, 540,000 env cells.
    pub fn retail(seed: u64) -> Self {
        SyntheticWorld {
            seed,
            side: 255,
            buildings: 5_464,
            env_cells: 540_000,
            largest_dungeon: 1_000,
        }
    }

    /// A small world with the same things in it, for tests.
    pub fn small(seed: u64) -> Self {
        SyntheticWorld {
            seed,
            side: 12,
            buildings: 40,
            env_cells: 3_000,
            largest_dungeon: 300,
        }
    }

    /// Writes `client_portal.dat` and `client_cell_1.dat` into a folder, which is made if need be. `progress` is
    /// called for each landblock. The same plan always gives the same bytes.
    ///
    /// # Errors
    /// When the plan cannot be met or a file cannot be written.
    pub fn build(
        &self,
        folder: impl AsRef<Path>,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<SyntheticReport, SyntheticError> {
        let folder = folder.as_ref();
        // A folder that cannot be made shows when the first file is created in it.
        let _ = std::fs::create_dir_all(folder);
        let file = |kind: DatKind| NewFile::create(folder.join(kind.file_name()));
        let (_, _, report) = self.build_into(file(DatKind::Portal)?, file(DatKind::Cell)?, progress)?;
        Ok(report)
    }

    /// Writes the portal and the cell file into storages, which are given back.
    ///
    /// # Errors
    /// As [`SyntheticWorld::build`].
    pub fn build_into<S: Storage>(
        &self,
        portal: S,
        cell: S,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(S, S, SyntheticReport), SyntheticError> {
        let palette = Palette::compile()?;
        let sites = self.sites(&palette)?;
        let mut report = SyntheticReport::default();
        let options = WriteOptions::default();

        let mut out = DatBuilder::new(DatKind::Portal.file_name(), portal, Header::new(DatKind::Portal))?;
        for (id, bytes) in &palette.portal {
            out.push(*id, bytes, &options)?;
        }
        report.records += out.len() as u64;
        let portal = out.finish()?;

        let mut out = DatBuilder::new(DatKind::Cell.file_name(), cell, Header::new(DatKind::Cell))?;
        let all = u32::from(self.side) * u32::from(self.side);
        let mut done = 0;
        for x in 0..self.side as u8 {
            for y in 0..self.side as u8 {
                let id = BlockId::new(x, y);
                let block = Block {
                    plan: self,
                    palette: &palette,
                    id,
                };
                block.write(sites.get(&id).copied(), &mut out, &mut report)?;
                done += 1;
                progress(Progress { done, all });
            }
        }
        report.records += out.len() as u64;
        let cell = out.finish()?;
        report
            .dungeons
            .sort_by_key(|&(cell, count)| (core::cmp::Reverse(count), cell));
        let middle = BlockId::new((self.side / 2) as u8, (self.side / 2) as u8);
        let ground = f32::from(land::height_index(self.seed, land::vertex(middle, 3, 3))) * land::STEP;
        let origin = glam::Vec3::new(72.0, 72.0, ground + 0.005);
        report.start = Position::new(CellId::new(middle, 28), origin);
        Ok((portal, cell, report))
    }

    /// Which landblocks have buildings and which are dungeons.
    fn sites(&self, palette: &Palette) -> Result<BTreeMap<BlockId, Site>, SyntheticError> {
        if !(8..=255).contains(&self.side) {
            return Err(SyntheticError::Plan(
                "a synthetic world has 8 to 255 landblocks on a side",
            ));
        }
        let mut draws = Draws::new(self.seed, 0x5175_2D63);
        let mut free: Vec<BlockId> = (1..self.side - 1)
            .flat_map(|x| (1..self.side - 1).map(move |y| BlockId::new(x as u8, y as u8)))
            .collect();
        for i in (1..free.len()).rev() {
            free.swap(i, draws.below(i as u32 + 1) as usize);
        }
        let mut sites = BTreeMap::new();
        let mut next = || {
            free.pop().ok_or(SyntheticError::Plan(
                "more buildings and dungeons than landblocks",
            ))
        };
        let (mut buildings, mut cells) = (self.buildings, self.env_cells);
        while buildings > 0 {
            // Most stand alone; few are towns (`evidence.md` E3: median 17 cells, 122 in a tenth, 277 at most).
            let count = match draws.below(100) {
                0..48 => 1,
                48..80 => 2 + draws.below(2),
                _ => 5 + draws.below(5),
            };
            let count = count.min(buildings);
            let block = next()?;
            for k in 0..count {
                let kind = house_kind(self.seed, block, k as u8);
                let size = palette.houses[kind].cells.len() as u32;
                cells = cells.checked_sub(size).ok_or(SyntheticError::Plan(
                    "the buildings have more env cells than the world may have",
                ))?;
            }
            sites.insert(block, Site::Town(count as u8));
            buildings -= count;
        }
        let largest = u32::from(self.largest_dungeon.clamp(1, 0xFE00));
        let mut first = true;
        while cells > 0 {
            let count = if first || draws.below(100) < 3 {
                largest
            } else {
                let share = draws.below(1_000) * draws.below(1_000) / 1_000;
                4 + largest * share / 1_600
            };
            first = false;
            let count = count.min(cells).min(largest);
            sites.insert(next()?, Site::Dungeon(count as u16));
            cells -= count;
        }
        Ok(sites)
    }
}

/// Which kind of house the `k`-th of a landblock is.
fn house_kind(seed: u64, block: BlockId, k: u8) -> usize {
    let share = Draws::new(seed, u64::from(block.0) << 8 | u64::from(k)).below(100);
    let mut below = 0;
    HOUSES
        .iter()
        .position(|house| {
            below += house.percent;
            share < below
        })
        .unwrap_or(0)
}

/// Random numbers that are the same everywhere.
pub(crate) struct Draws(u64);

impl Draws {
    fn new(seed: u64, stream: u64) -> Self {
        let mut z = seed.wrapping_add(stream.wrapping_mul(0x9E37_79B9_7F4A_7C15)) ^ 0x6A09_E667_F3BC_C909;
        for _ in 0..2 {
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            z ^= z >> 31;
        }
        Draws(z | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// A number below `n`.
    fn below(&mut self, n: u32) -> u32 {
        (((self.next() >> 32) * u64::from(n.max(1))) >> 32) as u32
    }
}

/// A landblock being written.
struct Block<'a> {
    plan: &'a SyntheticWorld,
    palette: &'a Palette,
    id: BlockId,
}

impl Block<'_> {
    fn write<S: Storage>(
        &self,
        site: Option<Site>,
        out: &mut DatBuilder<S>,
        report: &mut SyntheticReport,
    ) -> Result<(), SyntheticError> {
        let seed = self.plan.seed;
        let mut draws = Draws::new(seed, 0x1_0000_0000 | u64::from(self.id.0));
        let mut land = land::block(seed, self.id, self.plan.side);
        let mut info = LandBlockInfo {
            id: self.id.info_record(),
            ..LandBlockInfo::default()
        };
        let mut cells = Vec::new();
        match site {
            Some(Site::Town(count)) => {
                for (k, &(cx, cy)) in (0..count).zip(&TOWN_CELLS) {
                    let z = land::level(&mut land, cx, cy);
                    let house = &self.palette.houses[house_kind(seed, self.id, k)];
                    let turn = draws.below(4);
                    let center = glam::DVec2::new(f64::from(cx) * 24.0 + 12.0, f64::from(cy) * 24.0 + 12.0);
                    house.stamp(self.id, center, z, turn, &mut info, &mut cells);
                }
                report.towns.push(CellId::new(self.id, 0x100));
            }
            Some(Site::Dungeon(count)) => {
                let dungeon = Dungeon::grow(usize::from(count), &mut draws);
                self.palette
                    .stamp_dungeon(self.id, &dungeon, &mut draws, &mut cells);
                info.num_cells = cells.len() as u32;
                report.dungeons.push((CellId::new(self.id, 0x100), count));
            }
            None => {}
        }
        self.scatter(&land, site, &mut draws, &mut info);

        report.landblocks += 1;
        report.buildings += info.buildings.len() as u32;
        report.building_portals += info.buildings.iter().map(|b| b.portals.len() as u32).sum::<u32>();
        report.env_cells += cells.len() as u32;
        report.statics += info.objects.len() as u64;
        let options = WriteOptions::default();
        for cell in &cells {
            report.statics += cell.statics.len() as u64;
            for portal in &cell.portals {
                report.cell_portals += 1;
                report.portals_outside += u64::from(portal.leads_outside());
                let quad = self
                    .palette
                    .is_quad(cell.environment, cell.cell_struct, portal.polygon_id);
                report.portals_not_quads += u64::from(!quad);
            }
            out.push(cell.id, &cell.encode()?, &options)?;
        }
        let has_objects = info.num_cells > 0 || !info.objects.is_empty() || !info.buildings.is_empty();
        if has_objects {
            out.push(info.id, &info.encode()?, &options)?;
        }
        let record = LandBlock {
            id: self.id.land_block_record(),
            has_objects: Bool32::from(has_objects),
            terrain: land.terrain,
            height: land.heights,
        };
        out.push(record.id, &record.encode()?, &options)?;
        Ok(())
    }

    /// Trees and rocks, on vertices, where the ground's height is known.
    fn scatter(&self, land: &land::Land, site: Option<Site>, draws: &mut Draws, info: &mut LandBlockInfo) {
        let count = match site {
            Some(Site::Town(_)) => 4 + draws.below(8),
            Some(Site::Dungeon(_)) => 0,
            None if draws.below(100) < 30 => 1 + draws.below(12),
            None => 0,
        };
        let mut taken = [false; 81];
        for _ in 0..count {
            // Even vertices: buildings stand between odd ones.
            let (i, j) = (
                2 * draws.below(4) as usize + 2 * usize::from(site.is_none()),
                2 * draws.below(5) as usize,
            );
            let (i, j) = (i.min(8), j.min(8));
            let model = self.palette.outdoors[draws.below(self.palette.outdoors.len() as u32) as usize];
            let inside = (1..8).contains(&i) && (1..8).contains(&j);
            if inside && !core::mem::replace(&mut taken[i * 9 + j], true) {
                let z = f32::from(land.heights[i * 9 + j]) * land::STEP;
                info.objects.push(stamp::object(
                    model,
                    glam::Vec3::new(i as f32 * 24.0, j as f32 * 24.0, z),
                ));
            }
        }
    }
}

/// Land cells of a landblock that buildings stand on: no two share a vertex, none touches the border.
const TOWN_CELLS: [(u8, u8); 9] = [
    (3, 3),
    (5, 3),
    (3, 5),
    (1, 3),
    (5, 5),
    (3, 1),
    (1, 1),
    (1, 5),
    (5, 1),
];

#[cfg(test)]
mod tests;
