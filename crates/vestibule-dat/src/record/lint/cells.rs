//! Records of the cell file.

use super::Lints;
use crate::record::{EnvCell, LandBlockInfo};

/// Side of a landblock, metres.
const LANDBLOCK_SIDE: f32 = 192.0;
/// Low words from 0x0100 to 0xFFFD.
pub(super) const MAX_CELLS: u32 = 0xFEFE;
/// Pack-mask bits that occur in client files.
const KNOWN_PACK_MASK: u16 = 1;

impl Lints {
    pub(super) fn land_block_info(&mut self, info: &LandBlockInfo) {
        if info.num_cells > MAX_CELLS {
            let most = format_args!("{} cells, ids end after {MAX_CELLS}", info.num_cells);
            self.add("D3", format_args!("num_cells"), most);
        }
        for (i, object) in info.objects.iter().enumerate() {
            self.object_id(format_args!("objects[{i}].id"), object.id);
            self.frame(format_args!("objects[{i}].frame"), &object.frame);
        }
        if info.pack_mask & !KNOWN_PACK_MASK != 0 {
            let bits = format_args!("has unknown bits: {:#06x}", info.pack_mask);
            self.add("9.2", format_args!("pack_mask"), bits);
        }
        for (i, building) in info.buildings.iter().enumerate() {
            self.object_id(format_args!("buildings[{i}].model_id"), building.model_id);
            self.frame(format_args!("buildings[{i}].frame"), &building.frame);
            let inside = |value| (0.0..LANDBLOCK_SIDE).contains(&value);
            let origin = building.frame.origin;
            if origin.is_finite() && !(inside(origin.x) && inside(origin.y)) {
                let field = format_args!("buildings[{i}].frame.origin");
                self.add("D4", field, format_args!("{origin} is outside the landblock"));
            }
            for (k, portal) in building.portals.iter().enumerate() {
                if portal.other_portal().is_none() {
                    let field = format_args!("buildings[{i}].portals[{k}].other_portal_id");
                    self.add("L5", field, format_args!("names no portal"));
                }
                if !portal.stabs.contains(&portal.other_cell_id) {
                    let cell = portal.other_cell_id;
                    let field = format_args!("buildings[{i}].portals[{k}].stabs");
                    self.add(
                        "L5",
                        field,
                        format_args!("lack the cell behind the portal, {cell:08X}"),
                    );
                }
            }
        }
    }

    pub(super) fn env_cell(&mut self, cell: &EnvCell) {
        if cell.id_again != cell.id {
            let ids = format_args!("is {:08X}, id is {:08X}", cell.id_again, cell.id);
            self.add("D4", format_args!("id_again"), ids);
        }
        if !(0x0100..=0xFFFD).contains(&(self.id & 0xFFFF)) {
            self.add(
                "D3",
                format_args!("id"),
                format_args!("is no EnvCell's: low words run from 0100 to FFFD"),
            );
        }
        self.frame(format_args!("frame"), &cell.frame);
        for (i, portal) in cell.portals.iter().enumerate() {
            let flag = portal.flags & crate::record::CellPortal::OUTSIDE != 0;
            let sentinel = portal.other_cell_id as u16 == crate::record::CellPortal::OUTSIDE_CELL;
            if flag != sentinel {
                let field = format_args!("portals[{i}]");
                self.add(
                    "L8",
                    field,
                    format_args!("flag and cell id disagree on whether it leads outside"),
                );
            }
        }
        for (i, object) in cell.statics.iter().enumerate() {
            self.object_id(format_args!("statics[{i}].id"), object.id);
            self.frame(format_args!("statics[{i}].frame"), &object.frame);
        }
    }
}
