//! The compiler: all the records of a scene.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec2, DVec3};
use vestibule_dat::primitive::Bool32;
use vestibule_dat::record::{LandBlock, LandBlockInfo, RecordError, Stab};
use vestibule_dat::{DatBuilder, DatKind, DatSet, Header, WriteOptions};
use vestibule_world::{BlockId, CellId, Frame, MemoryRecords, Position, Store};

use super::cells::SiteCells;
use super::land::Land;
use super::noise::hash01;
use super::site::{Made, PlacedSite, Structures, frame, land_frame};
use super::validate;
use crate::bsp::BspError;
use crate::scene::{self, Kind, Placement, Scene};
use crate::text::{Diagnostic, Diagnostics, Messages, Span, parse};

/// A world compiled from a scene: DAT records by id, ready to be written or used from memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CompiledWorld {
    /// The scene's name.
    pub name: String,
    /// Records of the portal file.
    pub portal: BTreeMap<u32, Vec<u8>>,
    /// Records of the cell file.
    pub cell: BTreeMap<u32, Vec<u8>>,
    /// What the compiler wants the author to look at.
    pub warnings: Vec<Diagnostic>,
    /// What each env cell is called in the scene, as `cottage.hall`; further cells of a room are numbered
    /// (`cottage.hall.2`).
    pub cell_names: BTreeMap<CellId, String>,
    /// Where visitors begin, if the scene says so.
    pub start: Option<Position>,
    /// Counts, for reports.
    pub stats: CompileStats,
}

/// How much a scene became.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CompileStats {
    /// Landblocks with terrain.
    pub landblocks: usize,
    /// Env cells.
    pub cells: usize,
    /// Cell structures; fewer than cells when equal rooms share one.
    pub structures: usize,
    /// Buildings.
    pub buildings: usize,
    /// Static objects, indoors and outdoors.
    pub statics: usize,
}

impl CompiledWorld {
    /// The records as a source for `vestibule_world::World`.
    pub fn memory_records(&self) -> MemoryRecords {
        let mut out = MemoryRecords::new();
        for (store, records) in [(Store::Portal, &self.portal), (Store::Cell, &self.cell)] {
            for (id, bytes) in records {
                out.insert(store, *id, bytes.clone());
            }
        }
        out
    }

    fn file(records: &BTreeMap<u32, Vec<u8>>, kind: DatKind) -> vestibule_dat::Result<Vec<u8>> {
        let mut builder = DatBuilder::new(kind.file_name(), Vec::new(), Header::new(kind))?;
        for (id, bytes) in records {
            builder.push(*id, bytes, &WriteOptions::default())?;
        }
        builder.finish()
    }

    /// Both files in memory.
    ///
    /// # Errors
    /// When the world is too large for a DAT file (2 GiB).
    pub fn dat_set(&self) -> vestibule_dat::Result<DatSet> {
        DatSet::from_bytes(
            Self::file(&self.portal, DatKind::Portal)?,
            Self::file(&self.cell, DatKind::Cell)?,
        )
    }

    /// Writes `client_portal.dat` and `client_cell_1.dat` into a folder, which is made if need be. The same world
    /// always gives the same bytes.
    ///
    /// # Errors
    /// When the folder cannot be made or a file cannot be written.
    pub fn write_to(&self, folder: impl AsRef<Path>) -> vestibule_dat::Result<()> {
        let folder = folder.as_ref();
        // A folder that cannot be made shows when the first file is created in it.
        let _ = std::fs::create_dir_all(folder);
        for (kind, records) in [(DatKind::Portal, &self.portal), (DatKind::Cell, &self.cell)] {
            let mut builder = DatBuilder::create(folder.join(kind.file_name()), Header::new(kind))?;
            for (id, bytes) in records {
                builder.push(*id, bytes, &WriteOptions::default())?;
            }
            builder.finish()?;
        }
        Ok(())
    }

    /// The cell of that name, as in [`CompiledWorld::cell_names`].
    pub fn cell_named(&self, name: &str) -> Option<CellId> {
        self.cell_names
            .iter()
            .find(|(_, n)| *n == name)
            .map(|(id, _)| *id)
    }
}

/// Records as they are made.
#[derive(Default)]
pub(crate) struct Records {
    pub(crate) portal: BTreeMap<u32, Vec<u8>>,
    pub(crate) cell: BTreeMap<u32, Vec<u8>>,
    next: BTreeMap<u32, u32>,
}

impl Records {
    /// The next free id, from `first` on.
    pub(crate) fn next_id(&mut self, first: u32) -> u32 {
        let next = self.next.entry(first).or_insert(first);
        *next += 1;
        *next - 1
    }

    /// Takes back the id given last.
    pub(crate) fn release_id(&mut self, first: u32) {
        if let Some(next) = self.next.get_mut(&first) {
            *next -= 1;
        }
    }
}

/// Why a part of a scene cannot be stored.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Problem {
    #[error(transparent)]
    Bsp(#[from] BspError),
    #[error(transparent)]
    Record(#[from] RecordError),
}

const NOT_STORED: &str = "make it simpler: fewer polygons, or several rooms, sites or models";

/// Compiles scene files, given as (name, text).
pub(crate) fn compile(files: &[(&str, &str)]) -> Result<CompiledWorld, Diagnostics> {
    let names = files.iter().map(|(name, _)| (*name).to_owned()).collect();
    let mut messages = Messages::new(names);
    let mut statements = Vec::new();
    for (k, (_, text)) in (0u16..).zip(files) {
        statements.extend(parse(k, text, &mut messages));
    }
    let scene = scene::read(&statements, &mut messages);
    let land = Land::build(&scene, &mut messages);
    let sites = place_sites(&scene, &land, &mut messages);
    validate::check(&scene, &land, &sites, &mut messages);
    if messages.has_errors() {
        return Err(Diagnostics(messages.finish()));
    }
    let mut out = Compiler {
        scene: &scene,
        land: &land,
        sites: &sites,
        messages: &mut messages,
    }
    .records();
    let failed = messages.has_errors();
    let found = messages.finish();
    if failed {
        return Err(Diagnostics(found));
    }
    out.warnings = found;
    Ok(out)
}

fn place_sites<'a>(scene: &'a Scene, land: &Land, messages: &mut Messages) -> Vec<PlacedSite<'a>> {
    let mut out = Vec::new();
    for def in &scene.sites {
        let on_map = def.place.resolve(|p| land.ground(p));
        let (block, corner) = match def.kind {
            Kind::Dungeon(block) => (block, DVec2::ZERO),
            Kind::Building => match land.block_at(def.place.at) {
                Some((block, _)) => (block, land.block_corner(block)),
                None => {
                    let message = format!("building `{}` stands outside the land", def.name.text);
                    messages.error(
                        def.name.span,
                        message,
                        "place it inside the land, or enlarge `land`",
                    );
                    continue;
                }
            },
        };
        let cells = SiteCells::build(def, messages);
        let place = Placement {
            origin: on_map.origin - corner.extend(0.0),
            rotation: on_map.rotation,
        };
        out.push(PlacedSite {
            def,
            cells,
            block,
            place,
            on_map,
            ids: Vec::new(),
        });
    }
    number_cells(&mut out, messages);
    out
}

/// Gives every cell its id: those asked for, the others in the order of the text, without gaps.
fn number_cells(sites: &mut [PlacedSite<'_>], messages: &mut Messages) {
    let mut taken: BTreeMap<(BlockId, u16), Span> = BTreeMap::new();
    for site in sites.iter_mut() {
        site.ids = vec![0; site.cells.cells.len()];
        for (room, def) in site.def.rooms.iter().enumerate() {
            let Some((span, id)) = def.id else { continue };
            let Some(cell) = site.cells.cells.iter().position(|c| c.room == room) else {
                continue;
            };
            if !(0x0100..=0xFFFD).contains(&id) {
                let message = format!("cell number 0x{id:04X} is outside of 0x0100 to 0xFFFD");
                messages.error(
                    span,
                    message,
                    "leave `id` out to have the room numbered, or choose one in the range",
                );
            } else if let Some(other) = taken.insert((site.block, id), span) {
                let message = format!("cell number 0x{id:04X} is taken");
                messages.error(
                    span,
                    message,
                    format!("line {} has it; choose another", other.line),
                );
            }
            site.ids[cell] = id;
        }
    }
    let mut counts: BTreeMap<BlockId, u32> = BTreeMap::new();
    for site in sites.iter_mut() {
        let block = site.block;
        *counts.entry(block).or_default() += site.cells.cells.len() as u32;
        let mut next = 0x0100;
        for id in site.ids.iter_mut().filter(|id| **id == 0) {
            while next < 0xFFFE && taken.contains_key(&(block, next)) {
                next += 1;
            }
            *id = next;
            taken.insert((block, next), site.def.name.span);
        }
    }
    for (&(block, id), &span) in &taken {
        let last = 0x00FF + counts.get(&block).copied().unwrap_or(0);
        if (0x0100..=0xFFFD).contains(&id) && u32::from(id) > last {
            let message = format!(
                "cell number 0x{id:04X} leaves a gap: landblock {block} has cells up to 0x{last:04X}"
            );
            messages.error(
                span,
                message,
                "numbers run from 0x0100 without gaps; leave `id` out or choose a lower one",
            );
        }
    }
}

struct Compiler<'a> {
    scene: &'a Scene,
    land: &'a Land,
    sites: &'a [PlacedSite<'a>],
    messages: &'a mut Messages,
}

impl Compiler<'_> {
    fn report<T>(&mut self, span: Span, result: Result<T, impl Into<Problem>>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(e) => {
                self.messages
                    .error(span, format!("this cannot be stored: {}", e.into()), NOT_STORED);
                None
            }
        }
    }

    fn records(mut self) -> CompiledWorld {
        let mut records = Records::default();
        let mut out = CompiledWorld {
            name: self.scene.name.clone(),
            ..CompiledWorld::default()
        };
        let none = Span::default();
        let mut painter = super::texture::Painter::default();
        let surfaces = super::surface::add_surfaces(&mut records, &mut painter, &self.scene.materials);
        let surfaces = self.report(none, surfaces).unwrap_or_default();
        let sizes: Vec<f64> = self.scene.materials.iter().map(|m| m.size).collect();
        let kinds = self.land.kinds_in_use();
        let region = {
            let (name, step) = (&self.scene.name, self.scene.height_step);
            super::region::add_region(&mut records, &mut painter, name, step, &kinds)
        };
        self.report(none, region);
        let mut models = Vec::new();
        for model in &self.scene.models {
            let id = super::model::add_model(&mut records, model, &surfaces, &sizes);
            models.push(self.report(model.name.span, id).unwrap_or(0));
        }
        let mut infos: BTreeMap<BlockId, LandBlockInfo> = BTreeMap::new();
        let mut structures = Structures::default();
        let made = Made {
            models: &models,
            surfaces: &surfaces,
            sizes: &sizes,
            land: self.land,
        };
        for site in self.sites {
            let info = infos.entry(site.block).or_default();
            let added = site.add(&mut records, &mut structures, info, &made);
            self.report(site.def.name.span, added);
            out.stats.statics += site.def.statics.len();
            for (cell, id) in site.cells.cells.iter().zip(&site.ids) {
                let name = format!("{}.{}", site.def.name.text, cell.name);
                out.cell_names.insert(CellId::new(site.block, *id), name);
            }
        }
        for (at, model, place) in self.land_objects() {
            if let Some((block, _)) = self.land.block_at(at) {
                let frame = land_frame(place, self.land.block_corner(block));
                infos.entry(block).or_default().objects.push(Stab {
                    id: models[model],
                    frame,
                });
                out.stats.statics += 1;
            }
        }
        self.blocks(&mut records, infos, &mut out.stats);
        out.start = self.start();
        out.stats.cells = structures.placed;
        out.stats.structures = structures.len();
        (out.portal, out.cell) = (records.portal, records.cell);
        out
    }

    /// The LandBlock and LandBlockInfo records.
    fn blocks(
        &mut self,
        records: &mut Records,
        infos: BTreeMap<BlockId, LandBlockInfo>,
        stats: &mut CompileStats,
    ) {
        let mut blocks = self.land.records();
        for (block, mut info) in infos {
            info.id = block.info_record();
            stats.buildings += info.buildings.len();
            let flat = || LandBlock {
                id: block.land_block_record(),
                has_objects: Bool32(0),
                terrain: [1 << 2; 81],
                height: [0; 81],
            };
            blocks.entry(block).or_insert_with(flat).has_objects = Bool32(1);
            if let Some(bytes) = self.report(Span::default(), info.encode()) {
                records.cell.insert(info.id, bytes);
            }
        }
        stats.landblocks = blocks.len();
        for block in blocks.values() {
            if let Some(bytes) = self.report(Span::default(), block.encode()) {
                records.cell.insert(block.id, bytes);
            }
        }
    }

    /// Where objects stand on the land: those written one by one, then those scattered.
    fn land_objects(&self) -> Vec<(DVec2, usize, Placement)> {
        let ground = |p: DVec2| self.land.ground(p);
        let mut out: Vec<(DVec2, usize, Placement)> = self
            .scene
            .statics
            .iter()
            .map(|object| (object.place.at, object.model, object.place.resolve(ground)))
            .collect();
        let sites: Vec<(DVec2, f64)> = self.sites.iter().filter_map(PlacedSite::footprint).collect();
        for scatter in &self.scene.scatters {
            let mut placed = 0;
            // Each try has its own numbers, so that the count only adds or removes at the end.
            for k in 0..scatter.count.saturating_mul(8) {
                if placed == scatter.count {
                    break;
                }
                let [u, v, turn] = [0, 1, 2].map(|n| hash01(k * 3 + n, scatter.seed));
                let at = scatter.low + (scatter.high - scatter.low) * DVec2::new(u, v);
                if self.is_free(at, &sites, scatter.clear, scatter.on) {
                    let rotation = scene::turned(turn * 360.0);
                    // A little sunk, so that slopes do not show under it.
                    let origin = at.extend(ground(at) - 0.05);
                    out.push((at, scatter.model, Placement { origin, rotation }));
                    placed += 1;
                }
            }
        }
        out
    }

    fn is_free(&self, at: DVec2, sites: &[(DVec2, f64)], clear: f64, on: Option<u8>) -> bool {
        let Some((kind, road)) = self.land.kind_at(at).filter(|_| self.land.contains(at)) else {
            return false;
        };
        let water = (16..=20).contains(&kind);
        let near_site = sites
            .iter()
            .any(|(center, reach)| center.distance(at) < reach + clear);
        let slope =
            [DVec2::X, DVec2::Y].map(|d| (self.land.ground(at + d) - self.land.ground(at - d)).abs() / 2.0);
        !water && !road && !near_site && slope[0] + slope[1] < 0.9 && on.is_none_or(|k| k == kind)
    }

    fn start(&mut self) -> Option<Position> {
        let start = self.scene.start.as_ref()?;
        let place = start.place.resolve(|p| self.land.ground(p));
        let (cell, place) = match &start.room {
            None => {
                let Some((block, _)) = self.land.block_at(start.place.at) else {
                    self.messages.error(
                        start.span,
                        "the start lies outside the land",
                        "choose a place inside it",
                    );
                    return None;
                };
                let corner = self.land.block_corner(block);
                let origin: DVec3 = place.origin - corner.extend(0.0);
                let (cell, _) = CellId::new(block, 0xFFFF).adjust_to_outside(origin.as_vec3())?;
                (
                    cell,
                    Placement {
                        origin,
                        rotation: place.rotation,
                    },
                )
            }
            Some((site, room)) => {
                let placed = self.sites.iter().find(|s| s.def.name.text == site.text);
                let inside = placed.and_then(|s| Some((s, s.cell_of(Some(&room.text), place.origin)?)));
                let Some((site, cell)) = inside else {
                    let message = format!("there is no room `{}` in a site `{}`", room.text, site.text);
                    self.messages
                        .error(room.span, message, "write: start in SITE ROOM at (x y z)");
                    return None;
                };
                (CellId::new(site.block, site.ids[cell]), place.within(site.place))
            }
        };
        let stored = frame(place);
        Some(Position {
            cell,
            frame: Frame::new(stored.origin, stored.rotation),
        })
    }
}
