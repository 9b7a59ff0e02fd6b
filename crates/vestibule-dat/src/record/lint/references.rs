//! What a record says about others, held against them.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{Lint, Lints};
use crate::data_id::RecordKind;
use crate::record::{BspNode, EnvCell, LandBlock, LandBlockInfo, OtherCell, Record};

/// Finds a record by kind and id; the kind also says which file it is in. `None`: missing or unreadable.
pub type LookUp<'a> = dyn FnMut(RecordKind, u32) -> Option<Arc<Record>> + 'a;

/// Checks what a record says about others: that those it names exist, and that they agree (D4, L3, G12, E3).
///
/// `look_up` is asked for each of them, often for the same again: let it remember.
pub fn lint_references(id: u32, record: &Record, look_up: &mut LookUp<'_>) -> Vec<Lint> {
    let mut lints = Lints::new(id);
    let mut missing = BTreeSet::new();
    for reference in record.references() {
        if missing.contains(&reference.id) {
            continue;
        }
        if look_up(reference.kind, reference.id).is_none() {
            missing.insert(reference.id);
            let rule = if matches!(record, Record::LandBlock(_)) {
                "L3"
            } else {
                "D4"
            };
            let (kind, id) = (reference.kind, reference.id);
            lints.add(
                rule,
                format_args!("{}", reference.field),
                format_args!("{kind} {id:08X} is missing"),
            );
        }
    }
    match record {
        Record::LandBlock(block) => lints.unused_info(block, look_up),
        Record::LandBlockInfo(info) => lints.building_portals(info, look_up),
        Record::EnvCell(cell) => lints.cell_neighbours(cell, look_up),
        _ => {}
    }
    lints.list
}

impl Lints {
    fn unused_info(&mut self, block: &LandBlock, look_up: &mut LookUp<'_>) {
        let info = self.id & 0xFFFF_0000 | 0xFFFE;
        if !block.has_objects.is_true() && look_up(RecordKind::LandBlockInfo, info).is_some() {
            let unused = format_args!("is false, so that LandBlockInfo {info:08X} is ignored");
            self.add("L3", format_args!("has_objects"), unused);
        }
    }

    fn building_portals(&mut self, info: &LandBlockInfo, look_up: &mut LookUp<'_>) {
        let cells = info.num_cells.min(super::cells::MAX_CELLS);
        let first = self.id & 0xFFFF_0000 | 0x0100;
        for cell in first..first + cells {
            if look_up(RecordKind::EnvCell, cell).is_none() {
                self.add(
                    "9.2",
                    format_args!("num_cells"),
                    format_args!("EnvCell {cell:08X} is missing"),
                );
            }
        }
        for (i, building) in info.buildings.iter().enumerate() {
            for (k, portal) in building.portals.iter().enumerate() {
                let Some(other) = look_up(RecordKind::EnvCell, portal.other_cell_id) else {
                    continue;
                };
                let (Record::EnvCell(cell), Some(index)) = (&*other, portal.other_portal()) else {
                    continue;
                };
                let back = cell.portals.get(usize::from(index));
                if !back.is_some_and(|back| back.leads_outside()) {
                    let field = format_args!("buildings[{i}].portals[{k}]");
                    let id = portal.other_cell_id;
                    self.add(
                        "D4",
                        field,
                        format_args!("portal {index} of {id:08X} does not lead outside"),
                    );
                }
            }
            let kind = RecordKind::of_asset_id(building.model_id);
            if let (RecordKind::GfxObj, Some(model)) = (kind, look_up(kind, building.model_id))
                && let Record::GfxObj(model) = &*model
            {
                let nodes = model.drawing.iter().flat_map(|drawing| &drawing.bsp.nodes);
                let named: BTreeSet<usize> = nodes
                    .filter_map(|node| match node {
                        BspNode::Portal { portal_polys, .. } => Some(portal_polys),
                        _ => None,
                    })
                    .flatten()
                    .map(|&(_, portal)| usize::from(portal))
                    .collect();
                if !named.iter().copied().eq(0..building.portals.len()) {
                    let field = format_args!("buildings[{i}].portals");
                    let count = building.portals.len();
                    let text =
                        format_args!("are {count}, but the model's drawing tree has openings {named:?}");
                    self.add("G12", field, text);
                }
            }
        }
    }

    fn cell_neighbours(&mut self, cell: &EnvCell, look_up: &mut LookUp<'_>) {
        for (i, portal) in cell.portals.iter().enumerate() {
            let OtherCell::Cell(other_id) = portal.other_cell() else {
                continue;
            };
            let Some(other) = look_up(RecordKind::EnvCell, other_id) else {
                continue;
            };
            let Record::EnvCell(other) = &*other else { continue };
            let back = portal
                .other_portal()
                .and_then(|index| other.portals.get(usize::from(index)));
            let points_back = back.is_some_and(|back| {
                back.other_cell() == OtherCell::Cell(self.id)
                    && back.other_portal().map(usize::from) == Some(i)
            });
            if !points_back {
                let index = portal.other_portal_id;
                let field = format_args!("portals[{i}]");
                self.add(
                    "D4",
                    field,
                    format_args!("portal {index} of {other_id:08X} does not point back"),
                );
            }
        }
        let Some(environment) = look_up(RecordKind::Environment, cell.environment) else {
            return;
        };
        let Record::Environment(environment) = &*environment else {
            return;
        };
        let Some(shape) = environment.cell_struct(u32::from(cell.cell_struct)) else {
            let missing = format_args!("{:08X} has no structure {}", cell.environment, cell.cell_struct);
            return self.add("E2", format_args!("cell_struct"), missing);
        };
        for (i, portal) in cell.portals.iter().enumerate() {
            if shape.polygon(portal.polygon_id).is_none() {
                let missing = format_args!("the structure has no polygon {}", portal.polygon_id);
                self.add("E3", format_args!("portals[{i}].polygon_id"), missing);
            }
        }
        for polygon in &shape.polygons {
            let (id, count) = (polygon.id, cell.surfaces.len());
            self.surface_index(format_args!("surfaces, polygon {id}"), polygon.pos_surface, count);
            if polygon.negative_surface() != polygon.pos_surface {
                self.surface_index(
                    format_args!("surfaces, polygon {id}"),
                    polygon.negative_surface(),
                    count,
                );
            }
        }
    }
}
