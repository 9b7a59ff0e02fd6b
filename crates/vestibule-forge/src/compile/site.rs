//! The records of a site: env cells, environments, the building and its shell.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use vestibule_dat::primitive::Frame;
use vestibule_dat::record::{
    Building, BuildingPortal, CellPortal, EnvCell, Environment, LandBlockInfo, RecordError, Stab,
};
use vestibule_world::BlockId;

use super::cells::{SiteCells, Target};
use super::land::Land;
use super::structure::{ModelParts, build_cell};
use super::world::{Problem, Records};
use crate::scene::{Kind, Placement, SiteDef};
use crate::visibility::{Opening, Seen, seen_from_cell, seen_through};

/// A site placed in its landblock.
pub(crate) struct PlacedSite<'a> {
    pub(crate) def: &'a SiteDef,
    pub(crate) cells: SiteCells,
    pub(crate) block: BlockId,
    /// Site to landblock.
    pub(crate) place: Placement,
    /// Site to map.
    pub(crate) on_map: Placement,
    /// Low words of the cells' ids.
    pub(crate) ids: Vec<u16>,
}

/// What has been made before the sites.
pub(crate) struct Made<'a> {
    /// Ids of the models.
    pub(crate) models: &'a [u32],
    /// Ids of the materials' Surfaces.
    pub(crate) surfaces: &'a [u32],
    /// Metres that the materials cover.
    pub(crate) sizes: &'a [f64],
    pub(crate) land: &'a Land,
}

/// A placement as stored.
pub(crate) fn frame(place: Placement) -> Frame {
    let rotation = if place.rotation.w < 0.0 {
        -place.rotation
    } else {
        place.rotation
    };
    let tidy = |n: f64| if n.abs() < 1.0e-12 { 0.0 } else { n };
    let rotation = glam::DQuat::from_array(rotation.to_array().map(tidy));
    Frame {
        origin: place.origin.as_vec3(),
        rotation: rotation.as_quat(),
    }
}

/// Cell structures made so far, so that equal rooms share one.
#[derive(Default)]
pub(crate) struct Structures {
    known: BTreeMap<Vec<u8>, (u32, u16)>,
    /// Placed cells, for statistics.
    pub(crate) placed: usize,
}

impl Structures {
    pub(crate) fn len(&self) -> usize {
        self.known.len()
    }
}

impl PlacedSite<'_> {
    /// Where a building stands on the map and how far its shell reaches from there, metres.
    pub(crate) fn footprint(&self) -> Option<(DVec2, f64)> {
        let points = self.cells.shell.iter().flat_map(|f| &f.polygon.points);
        let reach = points.map(|p| p.truncate().length()).fold(0.0, f64::max);
        (self.def.kind == Kind::Building).then(|| (self.on_map.origin.truncate(), reach))
    }

    fn id(&self, cell: usize) -> u32 {
        u32::from(self.block.0) << 16 | u32::from(self.ids[cell])
    }

    fn openings(&self) -> Vec<Vec<Opening>> {
        let opening = |h: &super::cells::Hole| Opening {
            polygon: h.polygon.clone(),
            to: match h.to {
                Target::Cell(to) => Some(to),
                Target::Outside(_) => None,
            },
        };
        self.cells
            .cells
            .iter()
            .map(|c| c.holes.iter().map(opening).collect())
            .collect()
    }

    /// Cells that belong into a stab list, as ids.
    fn stabs(&self, seen: &Seen) -> Vec<u32> {
        let mut ids: Vec<u32> = seen.cells.iter().map(|&k| self.id(k)).collect();
        ids.sort_unstable();
        ids
    }

    /// Adds all records of the site but the LandBlockInfo, whose lists are extended.
    pub(crate) fn add(
        &self,
        records: &mut Records,
        structures: &mut Structures,
        info: &mut LandBlockInfo,
        made: &Made<'_>,
    ) -> Result<(), Problem> {
        let openings = self.openings();
        let mut environment = Environment {
            id: records.next_id(0x0D00_0001),
            cell_structs: Vec::new(),
        };
        let mut statics = self.statics(made.models);
        for (k, cell) in self.cells.cells.iter().enumerate() {
            let built = build_cell(cell, &self.def.rooms[cell.room], made.sizes)?;
            let (environment_id, cell_struct) = structures.place(&mut environment, built.structure)?;
            let seen = seen_from_cell(&openings, k);
            let portals = cell
                .holes
                .iter()
                .zip(&built.portal_polygons)
                .map(|(hole, &polygon_id)| {
                    // Bit 1 set: portal side 0, the interior is in front of the polygon.
                    let (to, side) = match hole.to {
                        Target::Cell(to) => (self.id(to), 2),
                        Target::Outside(_) => (u32::from(self.block.0) << 16 | 0xFFFF, CellPortal::OUTSIDE),
                    };
                    CellPortal {
                        flags: u16::from(hole.exact) | side,
                        polygon_id,
                        other_cell_id: to,
                        other_portal_id: hole.partner.map_or(-1, |p| p as i16),
                    }
                });
            let statics = statics.remove(&k).unwrap_or_default();
            let id = self.id(k);
            let record = EnvCell {
                id,
                flags: if seen.outside { EnvCell::SEEN_OUTSIDE } else { 0 }
                    | if statics.is_empty() {
                        0
                    } else {
                        EnvCell::HAS_STATICS
                    },
                id_again: id,
                surfaces: built.surfaces.iter().map(|m| made.surfaces[*m]).collect(),
                environment: environment_id,
                cell_struct,
                frame: frame(cell.place.within(self.place)),
                portals: portals.collect(),
                stabs: self.stabs(&seen),
                statics,
                restriction: None,
            };
            records.cell.insert(id, record.encode()?);
            structures.placed += 1;
        }
        if environment.cell_structs.is_empty() {
            records.release_id(0x0D00_0001);
        } else {
            records.portal.insert(environment.id, environment.encode()?);
        }
        info.num_cells += self.cells.cells.len() as u32;
        if self.def.kind == Kind::Building && self.def.shell.is_some() {
            info.buildings.push(self.building(records, &openings, made)?);
        }
        Ok(())
    }

    /// The static objects of each cell.
    fn statics(&self, models: &[u32]) -> BTreeMap<usize, Vec<Stab>> {
        let mut out: BTreeMap<usize, Vec<Stab>> = BTreeMap::new();
        for object in &self.def.statics {
            let place = object.place.resolve(|_| 0.0);
            if let Some(cell) = self.cell_of(object.room.as_ref().map(|r| r.text.as_str()), place.origin) {
                let stab = Stab {
                    id: models[object.model],
                    frame: frame(place.within(self.place)),
                };
                out.entry(cell).or_default().push(stab);
            }
        }
        out
    }

    /// The cell of a room in which a point of the site lies, or is nearest to; of any room without a name.
    pub(crate) fn cell_of(&self, room: Option<&str>, p: DVec3) -> Option<usize> {
        let in_room =
            |k: &usize| room.is_none_or(|name| self.def.rooms[self.cells.cells[*k].room].name.text == name);
        // A little above the floor it stands on.
        let p = p + DVec3::Z * 0.05;
        let outside = |k: usize| {
            let faces = &self.cells.cells[k].space.faces;
            faces
                .iter()
                .map(|f| f.polygon.plane.dist(p))
                .fold(f64::MIN, f64::max)
        };
        let all = (0..self.cells.cells.len()).filter(in_room);
        all.min_by(|&a, &b| outside(a).total_cmp(&outside(b)))
    }

    fn building(
        &self,
        records: &mut Records,
        openings: &[Vec<Opening>],
        made: &Made<'_>,
    ) -> Result<Building, Problem> {
        let id = records.next_id(0x0100_0001);
        let shell = ModelParts::of_shell(&self.cells, |p| {
            let on_map = self.on_map.to_outer(p);
            made.land.ground(on_map.truncate()) - on_map.z + p.z
        })
        .build(id, made.surfaces, made.sizes)?;
        records.portal.insert(id, shell.record.encode()?);
        let portals = self.cells.shell_holes.iter().map(|hole| {
            let mut seen = seen_through(openings, &hole.polygon.flipped(), hole.cell);
            seen.cells.insert(hole.cell);
            BuildingPortal {
                // The shell's polygon faces out: one looks in from its front.
                flags: 3,
                other_cell_id: self.id(hole.cell),
                other_portal_id: hole.hole as i16,
                stabs: self.stabs(&seen),
            }
        });
        Ok(Building {
            model_id: id,
            frame: frame(self.place),
            num_leaves: shell.leaves,
            portals: portals.collect(),
        })
    }
}

impl Structures {
    /// The environment and key of a structure: those of an equal one if there is one.
    fn place(
        &mut self,
        environment: &mut Environment,
        mut structure: vestibule_dat::record::CellStruct,
    ) -> Result<(u32, u16), RecordError> {
        structure.id = 0;
        let mut alone = Environment {
            id: 0,
            cell_structs: vec![structure],
        };
        let bytes = alone.encode()?;
        if let Some(known) = self.known.get(&bytes) {
            return Ok(*known);
        }
        let place = (environment.id, environment.cell_structs.len() as u16);
        self.known.insert(bytes, place);
        for mut structure in alone.cell_structs.drain(..) {
            structure.id = u32::from(place.1);
            environment.cell_structs.push(structure);
        }
        Ok(place)
    }
}

/// The frame of an object on the land, in the coordinates of its landblock.
pub(crate) fn land_frame(place: Placement, corner: DVec2) -> Frame {
    frame(Placement {
        origin: place.origin - corner.extend(0.0),
        rotation: place.rotation,
    })
}
