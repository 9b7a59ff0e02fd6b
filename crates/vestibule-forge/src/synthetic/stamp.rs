//! Copies of the palette's parts at other places.

use glam::{DVec2, DVec3, Quat, Vec3};
use vestibule_dat::primitive::Frame;
use vestibule_dat::record::{Building, BuildingPortal, CellPortal, EnvCell, LandBlockInfo, Stab};
use vestibule_world::{BlockId, CellId};

use super::Draws;
use super::dungeon::{Dungeon, Shape, Spot};
use super::palette::{LEVEL, PITCH, Palette, STYLES};

/// A house of the palette: its shell and its cells, from 0100 on.
pub(super) struct House {
    pub(super) building: Building,
    pub(super) cells: Vec<EnvCell>,
}

/// An object that stands upright.
pub(super) fn object(id: u32, origin: Vec3) -> Stab {
    Stab {
        id,
        frame: Frame {
            origin,
            rotation: Quat::IDENTITY,
        },
    }
}

/// A turn by quarters about z.
fn quarter(turn: u32) -> Quat {
    const HALF: f32 = core::f32::consts::FRAC_1_SQRT_2;
    match turn % 4 {
        0 => Quat::IDENTITY,
        1 => Quat::from_xyzw(0.0, 0.0, HALF, HALF),
        2 => Quat::from_xyzw(0.0, 0.0, 1.0, 0.0),
        _ => Quat::from_xyzw(0.0, 0.0, -HALF, HALF),
    }
}

/// A vector turned by quarters about z: exactly.
fn turned(turn: u32, v: Vec3) -> Vec3 {
    match turn % 4 {
        0 => v,
        1 => Vec3::new(-v.y, v.x, v.z),
        2 => Vec3::new(-v.x, -v.y, v.z),
        _ => Vec3::new(v.y, -v.x, v.z),
    }
}

impl House {
    /// Puts a copy on a level land cell, its ground at `z`.
    pub(super) fn stamp(
        &self,
        block: BlockId,
        center: DVec2,
        z: f32,
        turn: u32,
        info: &mut LandBlockInfo,
        cells: &mut Vec<EnvCell>,
    ) {
        let first = info.num_cells as u16;
        let old = self.building.frame.origin;
        // The palette's ground is at 40 m.
        let new = Vec3::new(center.x as f32, center.y as f32, z + (old.z - 40.0));
        let frame = |f: &Frame| Frame {
            origin: new + turned(turn, f.origin - old),
            rotation: quarter(turn) * f.rotation,
        };
        let id = |full: u32| match full as u16 {
            low @ 0x100..0xFFFE => CellId::new(block, low + first).0,
            low => CellId::new(block, low).0,
        };
        let portal = |p: &BuildingPortal| BuildingPortal {
            other_cell_id: id(p.other_cell_id),
            stabs: p.stabs.iter().map(|&s| id(s)).collect(),
            ..*p
        };
        info.buildings.push(Building {
            frame: frame(&self.building.frame),
            portals: self.building.portals.iter().map(portal).collect(),
            ..self.building.clone()
        });
        for cell in &self.cells {
            cells.push(EnvCell {
                id: id(cell.id),
                id_again: id(cell.id),
                frame: frame(&cell.frame),
                portals: cell
                    .portals
                    .iter()
                    .map(|p| CellPortal {
                        other_cell_id: id(p.other_cell_id),
                        ..*p
                    })
                    .collect(),
                stabs: cell.stabs.iter().map(|&s| id(s)).collect(),
                statics: cell
                    .statics
                    .iter()
                    .map(|s| Stab {
                        id: s.id,
                        frame: frame(&s.frame),
                    })
                    .collect(),
                ..cell.clone()
            });
        }
        info.num_cells += self.cells.len() as u32;
    }
}

impl Palette {
    /// Makes the cells of a dungeon.
    pub(super) fn stamp_dungeon(
        &self,
        block: BlockId,
        dungeon: &Dungeon,
        draws: &mut Draws,
        cells: &mut Vec<EnvCell>,
    ) {
        let share = draws.below(100);
        let mut below = 0;
        let style = STYLES.iter().position(|style| {
            below += style.percent;
            share < below
        });
        let style = style.unwrap_or(0);
        let id = |k: u16| CellId::new(block, 0x100 + k).0;
        for (k, spot) in dungeon.spots.iter().enumerate() {
            let found = match spot.shape {
                // A dungeon of one cell has no door; any room will do.
                Shape::Room => self.rooms[style].get(&spot.doors().max(1)),
                Shape::Ramp(side) => self.ramps[style].get(usize::from(side)),
            };
            let Some(piece) = found else { continue };
            let (x, y, level) = spot.at;
            let plan = DVec3::new(
                f64::from(x) * PITCH,
                f64::from(y) * PITCH,
                f64::from(level) * LEVEL,
            );
            let origin = (STYLES[style].turned(plan) + DVec3::new(96.0, 96.0, -100.0)).as_vec3();
            let sides = (0..4).filter_map(|side| Some((side, spot.links[side]?)));
            let portals = sides.zip(&piece.doors).map(|((_, other), &(flags, polygon_id))| {
                let back = dungeon
                    .spots
                    .get(usize::from(other))
                    .and_then(|o: &Spot| o.portal(o.side_to(k as u16)?));
                CellPortal {
                    flags,
                    polygon_id,
                    other_cell_id: id(other),
                    other_portal_id: back.unwrap_or(-1),
                }
            });
            let mut statics = Vec::new();
            if spot.shape == Shape::Room && draws.below(100) < 15 {
                let model = self.indoors[draws.below(self.indoors.len() as u32) as usize];
                let corner = STYLES[style].turned(DVec3::new(3.5, -3.5, 0.0)).as_vec3();
                statics.push(object(model, origin + corner));
            }
            cells.push(EnvCell {
                id: id(k as u16),
                id_again: id(k as u16),
                flags: if statics.is_empty() {
                    0
                } else {
                    EnvCell::HAS_STATICS
                },
                frame: Frame {
                    origin,
                    rotation: piece.cell.frame.rotation,
                },
                portals: portals.collect(),
                stabs: dungeon.near(k).into_iter().map(id).collect(),
                statics,
                ..piece.cell.clone()
            });
        }
    }
}
