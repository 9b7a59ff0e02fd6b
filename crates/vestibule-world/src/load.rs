//! Loading a landblock (`world.md` 6 B1-B5, 7, 8): records in, immutable arrays out.

use std::sync::OnceLock;

use glam::Vec3;
use vestibule_dat::record;

use crate::env_cell::{CellPortal, EnvCell, PortalTarget};
use crate::error::ProblemKind;
use crate::frame::Frame;
use crate::ids::{BlockId, CellId};
use crate::landblock::{Land, Landblock};
use crate::records::Records;
use crate::region::Region;
use crate::shape::{Building, BuildingPortal, StaticObject};
use crate::source::Store;
use crate::terrain::{TerrainWord, block_water, build_land_cells};
use crate::transit_hints::{TransitHints, set_hints};

/// Loads a landblock; `None` when it has no LandBlock record and no env cells.
pub(crate) fn landblock(records: &Records, id: BlockId) -> Option<Landblock> {
    let loader = Loader { records, id };
    let land_record = loader.land_record();
    let has_objects = land_record.as_ref().is_some_and(|r| r.has_objects.is_true());
    let info = if has_objects { loader.info() } else { None };
    let mut land = land_record.map(|r| loader.land(&r));
    let buildings = info
        .as_ref()
        .map(|i| loader.buildings(i, land.as_mut()))
        .unwrap_or_default();
    let mut statics = info.as_ref().map(|i| loader.land_statics(i)).unwrap_or_default();
    let land_statics = statics.len() as u32;
    let mut env_cells: Box<[_]> = match &info {
        Some(info) => loader.env_cells(info, &mut statics),
        None => [].into(),
    };
    if let (Some(info), Some(land)) = (&info, &mut land) {
        for &(cell, object) in info.restrictions.iter().flat_map(|t| &t.entries) {
            let cell = CellId(cell);
            if cell.block() == id
                && cell.is_land_cell()
                && let Some(cell) = land.cells.get_mut(usize::from(cell.low()) - 1)
            {
                cell.restriction = Some(object);
            }
        }
    }
    if land.is_none() && env_cells.is_empty() {
        return None;
    }
    if !records.exact {
        set_hints(&mut env_cells);
    }
    let block = Landblock {
        id,
        land,
        buildings: buildings.into(),
        statics: statics.into(),
        land_statics,
        env_cells,
        reach: OnceLock::new(),
        shadows: OnceLock::new(),
    };
    loader.check_building_portals(&block);
    Some(block)
}

/// Loads the terrain of a landblock only, as far landscape needs it (`world.md` 4.4).
pub(crate) fn landscape(records: &Records, id: BlockId) -> Option<Landblock> {
    let loader = Loader { records, id };
    let land = loader.land(&loader.land_record()?);
    Some(Landblock::of_land(id, Some(land)))
}

struct Loader<'w> {
    records: &'w Records,
    id: BlockId,
}

impl Loader<'_> {
    fn report(&self, id: u32, kind: ProblemKind) {
        self.records.report_in(Store::Cell, id, kind);
    }

    fn land_record(&self) -> Option<record::LandBlock> {
        let id = self.id.land_block_record();
        if self.records.is_absent(Store::Cell, id) {
            return None;
        }
        self.records.parse(Store::Cell, id, id, record::LandBlock::parse)
    }

    fn info(&self) -> Option<record::LandBlockInfo> {
        let id = self.id.info_record();
        if self.records.is_absent(Store::Cell, id) {
            self.report(self.id.land_block_record(), ProblemKind::NoInfo);
            return None;
        }
        self.records.parse(
            Store::Cell,
            id,
            self.id.land_block_record(),
            record::LandBlockInfo::parse,
        )
    }

    fn land(&self, record: &record::LandBlock) -> Land {
        let region: &Region = &self.records.region;
        let mut heights = Box::new([0.0f32; 81]);
        for (metres, &index) in heights.iter_mut().zip(&record.height) {
            *metres = region.heights[usize::from(index)];
        }
        let words = Box::new(record.terrain.map(TerrainWord));
        let cells = build_land_cells(self.id.corner(), &heights, &words);
        let lowest = heights
            .iter()
            .copied()
            .fold(f32::INFINITY, |a, b| if b < a { b } else { a });
        let highest = heights
            .iter()
            .copied()
            .fold(f32::NEG_INFINITY, |a, b| if b > a { b } else { a });
        Land {
            water: block_water(&cells),
            cells: cells.into(),
            z_limits: (lowest - 1.0, highest + region.max_object_height),
            heights,
            words,
        }
    }

    /// The land cell of this block that an origin lies over (`world.md` B2, C1).
    fn land_cell_of(&self, origin: Vec3) -> Option<CellId> {
        let (cell, _) = CellId::new(self.id, 0xFFFF).adjust_to_outside(origin)?;
        (cell.block() == self.id).then_some(cell)
    }

    fn buildings(&self, info: &record::LandBlockInfo, mut land: Option<&mut Land>) -> Vec<Building> {
        let mut out: Vec<Building> = Vec::new();
        for (index, record) in (0u32..).zip(&info.buildings) {
            let frame = Frame::from(&record.frame);
            if !frame.is_finite() {
                self.report(info.id, ProblemKind::NotFinite("building frame"));
                continue;
            }
            let Some(cell) = self.land_cell_of(frame.origin) else {
                let kind = ProblemKind::OutsideBlock {
                    what: "building",
                    index,
                    block: self.id,
                };
                self.report(info.id, kind);
                continue;
            };
            let Some(shape) = self.records.shape(record.model_id, info.id) else {
                continue;
            };
            let Ok(position) = u16::try_from(out.len()) else {
                break;
            };
            if let Some(land_cell) = land
                .as_mut()
                .and_then(|land| land.cells.get_mut(usize::from(cell.low()) - 1))
            {
                if land_cell.building.is_some() {
                    self.report(info.id, ProblemKind::SecondBuilding { index, cell: cell.0 });
                } else {
                    land_cell.building = Some(position);
                }
            }
            let portals = record.portals.iter().map(|p| self.building_portal(p)).collect();
            let part_frames: Box<[Frame]> = shape.parts.iter().map(|p| frame.combine(&p.frame)).collect();
            out.push(Building {
                model_id: record.model_id,
                bounds: crate::shape::building_bounds(&shape, &frame, &part_frames),
                shape,
                frame,
                part_frames,
                cell,
                portals,
            });
        }
        out
    }

    fn building_portal(&self, record: &record::BuildingPortal) -> BuildingPortal {
        BuildingPortal {
            other: CellId(record.other_cell_id),
            other_portal: record.other_portal(),
            interior_is_negative: record.portal_side() == 1,
            exact_match: record.exact_match(),
            stab_list: record.stabs.iter().map(|&id| CellId(id)).collect(),
        }
    }

    fn land_statics(&self, info: &record::LandBlockInfo) -> Vec<StaticObject> {
        let mut out = Vec::with_capacity(info.objects.len());
        for (index, stab) in (0u32..).zip(&info.objects) {
            let frame = Frame::from(&stab.frame);
            if !frame.is_finite() {
                self.report(info.id, ProblemKind::NotFinite("static object frame"));
                continue;
            }
            let Some(cell) = self.land_cell_of(frame.origin) else {
                let kind = ProblemKind::OutsideBlock {
                    what: "static object",
                    index,
                    block: self.id,
                };
                self.report(info.id, kind);
                continue;
            };
            if let Some(shape) = self.records.shape(stab.id, info.id) {
                out.push(StaticObject::new(shape, frame, cell));
            }
        }
        out
    }

    fn env_cells(
        &self,
        info: &record::LandBlockInfo,
        statics: &mut Vec<StaticObject>,
    ) -> Box<[Option<EnvCell>]> {
        // Ids run without gaps from 0x0100 (`world.md` 1); a larger count than there are ids is damage.
        let count = info.num_cells.min(0xFFFD - 0x0100 + 1) as u16;
        let mut out = Vec::new();
        for low in 0x0100..0x0100 + count {
            out.push(self.env_cell(CellId::new(self.id, low), info.id, statics));
        }
        // A damaged count leaves a tail of absent cells that nothing needs to remember.
        while let Some(None) = out.last() {
            out.pop();
        }
        out.into()
    }

    fn env_cell(&self, id: CellId, needed_by: u32, statics: &mut Vec<StaticObject>) -> Option<EnvCell> {
        let record = self
            .records
            .parse(Store::Cell, id.0, needed_by, record::EnvCell::parse)?;
        let frame = Frame::from(&record.frame);
        if !frame.is_finite() {
            self.report(id.0, ProblemKind::NotFinite("cell frame"));
            return None;
        }
        let structure = self
            .records
            .cell_struct(record.environment, record.cell_struct, id.0)?;
        let mut portals = Vec::with_capacity(record.portals.len());
        for (index, portal) in (0u16..).zip(&record.portals) {
            let Some(polygon) = structure.polygons.index_of(portal.polygon_id) else {
                let kind = ProblemKind::NoPortalPolygon {
                    portal: index,
                    polygon: portal.polygon_id,
                };
                self.report(id.0, kind);
                continue;
            };
            portals.push(CellPortal {
                other: match portal.other_cell() {
                    record::OtherCell::Outside => PortalTarget::Outside,
                    record::OtherCell::Cell(other) => PortalTarget::Cell(CellId(other)),
                },
                other_portal: portal.other_portal(),
                polygon: polygon as u32,
                plane: structure
                    .polygons
                    .get(polygon)
                    .map(|p| p.plane)
                    .unwrap_or_default(),
                interior_is_negative: portal.portal_side() == 1,
                exact_match: portal.exact_match(),
                record_index: index,
            });
        }
        let first = statics.len() as u32;
        for stab in &record.statics {
            let frame = Frame::from(&stab.frame);
            if !frame.is_finite() {
                self.report(id.0, ProblemKind::NotFinite("static object frame"));
            } else if let Some(shape) = self.records.shape(stab.id, id.0) {
                statics.push(StaticObject::new(shape, frame, id));
            }
        }
        Some(EnvCell {
            id,
            frame,
            structure,
            surfaces: record.surfaces.as_slice().into(),
            portals: portals.into(),
            stab_list: record.stabs.iter().map(|&stab| CellId(stab)).collect(),
            seen_outside: record.seen_outside(),
            restriction: record.restriction,
            statics: first..statics.len() as u32,
            hints: TransitHints::default(),
        })
    }

    /// `world.md` 20: an opposite portal that does not exist is skipped by those who need it, and reported.
    fn check_building_portals(&self, block: &Landblock) {
        for (building, b) in (0u16..).zip(&block.buildings) {
            for (portal, p) in (0u16..).zip(&b.portals) {
                if let (Some(index), Some(cell)) = (p.other_portal, block.env_cell(p.other))
                    && cell.portal(index).is_none()
                {
                    let kind = ProblemKind::NoOppositePortal {
                        building,
                        portal,
                        cell: p.other.0,
                    };
                    self.report(self.id.info_record(), kind);
                }
            }
        }
    }
}
