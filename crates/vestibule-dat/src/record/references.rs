//! Which other records a record names.

use super::{Paint, Record};
use crate::data_id::RecordKind;

/// One mention of another record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Reference {
    /// The type of the record named, from its id; says also which file it is in.
    pub kind: RecordKind,
    /// Its data id.
    pub id: u32,
    /// The field that names it.
    pub field: &'static str,
}

/// Collects mentions; ids that mean "none" are left out.
#[derive(Default)]
struct References(Vec<Reference>);

impl References {
    fn asset(&mut self, field: &'static str, id: u32) {
        if id != 0 {
            self.0.push(Reference {
                kind: RecordKind::of_asset_id(id),
                id,
                field,
            });
        }
    }

    fn assets<'a>(&mut self, field: &'static str, ids: impl IntoIterator<Item = &'a u32>) {
        ids.into_iter().for_each(|&id| self.asset(field, id));
    }

    fn cell(&mut self, field: &'static str, id: u32) {
        self.0.push(Reference {
            kind: RecordKind::of_cell_id(id),
            id,
            field,
        });
    }
}

impl Record {
    /// Every mention of another record, in the order of the fields; a record named twice is listed twice.
    ///
    /// Raw records name nothing, and neither does the object that restricts a cell: it is the server's.
    pub fn references(&self) -> Vec<Reference> {
        let mut found = References::default();
        match self {
            Self::LandBlock(block) => {
                if block.has_objects.is_true() {
                    found.cell("has_objects", block.id & 0xFFFF_0000 | 0xFFFE);
                }
            }
            Self::LandBlockInfo(info) => {
                info.objects
                    .iter()
                    .for_each(|object| found.asset("objects", object.id));
                for building in &info.buildings {
                    found.asset("buildings.model_id", building.model_id);
                    for portal in &building.portals {
                        found.cell("buildings.portals.other_cell_id", portal.other_cell_id);
                        portal
                            .stabs
                            .iter()
                            .for_each(|&id| found.cell("buildings.portals.stabs", id));
                    }
                }
            }
            Self::EnvCell(cell) => {
                found.assets("surfaces", &cell.surfaces);
                found.asset("environment", cell.environment);
                for portal in cell.portals.iter().filter(|portal| !portal.leads_outside()) {
                    found.cell("portals.other_cell_id", portal.other_cell_id);
                }
                cell.stabs.iter().for_each(|&id| found.cell("stabs", id));
                cell.statics
                    .iter()
                    .for_each(|object| found.asset("statics", object.id));
            }
            Self::GfxObj(model) => {
                found.assets("surfaces", &model.surfaces);
                found.assets("degrade_id", &model.degrade_id);
            }
            Self::Setup(setup) => {
                found.assets("parts", &setup.parts);
                found.asset("default_animation", setup.default_animation);
                found.asset("default_script", setup.default_script);
                found.asset("default_motion_table", setup.default_motion_table);
                found.asset("default_sound_table", setup.default_sound_table);
                found.asset("default_script_table", setup.default_script_table);
            }
            Self::Region(region) => {
                for group in region.sky.iter().flat_map(|sky| &sky.day_groups) {
                    for object in &group.sky_objects {
                        found.asset("sky.day_groups.sky_objects.gfx_obj", object.gfx_obj);
                        found.asset("sky.day_groups.sky_objects.pes", object.pes);
                    }
                    for replace in group.sky_times.iter().flat_map(|time| &time.replaces) {
                        found.asset("sky.day_groups.sky_times.replaces.gfx_obj", replace.gfx_obj);
                    }
                }
                for table in region.sound.iter().flat_map(|sound| &sound.tables) {
                    found.asset("sound.tables.sound_table", table.sound_table);
                }
                for scene_type in region.scene.iter().flat_map(|scene| &scene.scene_types) {
                    found.assets("scene.scene_types.scenes", &scene_type.scenes);
                }
                let merge = &region.terrain.tex_merge;
                for map in merge.corner_maps.iter().chain(&merge.side_maps) {
                    found.asset("terrain.tex_merge.texture", map.texture);
                }
                for map in &merge.road_maps {
                    found.asset("terrain.tex_merge.road_maps.texture", map.texture);
                }
                for texture in &merge.textures {
                    found.asset("terrain.tex_merge.textures.texture", texture.texture);
                    found.asset(
                        "terrain.tex_merge.textures.detail_texture",
                        texture.detail_texture,
                    );
                }
                if let Some(misc) = &region.misc {
                    found.asset("misc.game_map", misc.game_map);
                    found.asset("misc.autotest_map", misc.autotest_map);
                    found.asset("misc.clear_cell", misc.clear_cell);
                    found.asset("misc.clear_monster", misc.clear_monster);
                }
            }
            Self::Surface(surface) => {
                if let Paint::Image { texture, palette } = surface.paint {
                    found.asset("texture", texture);
                    found.asset("palette", palette);
                }
            }
            Self::SurfaceTexture(texture) => found.assets("textures", &texture.textures),
            Self::RenderSurface(texture) => found.assets("palette", &texture.palette),
            Self::Scene(scene) => {
                scene
                    .objects
                    .iter()
                    .for_each(|object| found.asset("objects.object_id", object.object_id));
            }
            Self::GfxObjDegradeInfo(info) => {
                info.degrades
                    .iter()
                    .for_each(|degrade| found.asset("degrades.gfx_obj", degrade.gfx_obj));
            }
            Self::Environment(_) | Self::Palette(_) | Self::Iteration(_) | Self::Raw { .. } => {}
        }
        found.0
    }
}
