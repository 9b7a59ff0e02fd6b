//! Which records a record refers to, and who refers to a record.

use vestibule_dat::record::{Paint, Record, Region, Setup};
use vestibule_dat::{DatFile, DatKind, DatSet, Entry, RecordKind};
use vestibule_world::Store;

/// A field of a record that names another record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reference {
    /// The field, with indices: `buildings[0].portals[1].stabs`.
    pub field: String,
    /// Which file the record named is in.
    pub store: Store,
    /// Id of the record named.
    pub id: u32,
}

/// The records that `record` (with this id) names. Ids of 0 and -1, which mean none, are left out.
///
/// ```
/// use vestibule::dat::record::{GfxObj, Record};
///
/// let model = GfxObj { id: 0x0100_0001, surfaces: vec![0x0800_0002], ..GfxObj::default() };
/// let found = vestibule::references::of_record(&Record::GfxObj(model));
/// assert_eq!(found[0].id, 0x0800_0002);
/// assert_eq!(found[0].field, "surfaces[0]");
/// ```
pub fn of_record(record: &Record) -> Vec<Reference> {
    let mut out = Collector::default();
    match record {
        Record::LandBlock(block) => {
            if block.has_objects.is_true() {
                out.cell("has_objects", block.id & 0xFFFF_0000 | 0xFFFE);
            }
        }
        Record::LandBlockInfo(info) => {
            let cells = info.num_cells.min(0xFFFD - 0x100 + 1);
            for low in 0x100..0x100 + cells {
                out.cell("num_cells", info.id & 0xFFFF_0000 | low);
            }
            for (i, object) in info.objects.iter().enumerate() {
                out.portal(format!("objects[{i}]"), object.id);
            }
            for (i, building) in info.buildings.iter().enumerate() {
                out.portal(format!("buildings[{i}].model_id"), building.model_id);
                for (j, portal) in building.portals.iter().enumerate() {
                    out.cell(format!("buildings[{i}].portals[{j}].other_cell_id"), portal.other_cell_id);
                    for &stab in &portal.stabs {
                        out.cell(format!("buildings[{i}].portals[{j}].stabs"), stab);
                    }
                }
            }
        }
        Record::EnvCell(cell) => {
            out.portals("surfaces", &cell.surfaces);
            out.portal("environment", cell.environment);
            for (i, portal) in cell.portals.iter().enumerate() {
                if !portal.leads_outside() {
                    out.cell(format!("portals[{i}].other_cell_id"), portal.other_cell_id);
                }
            }
            for &stab in &cell.stabs {
                out.cell("stabs", stab);
            }
            for (i, object) in cell.statics.iter().enumerate() {
                out.portal(format!("statics[{i}]"), object.id);
            }
        }
        Record::GfxObj(model) => {
            out.portals("surfaces", &model.surfaces);
            out.portal("degrade_id", model.degrade_id.unwrap_or(0));
        }
        Record::Setup(setup) => setup_references(setup, &mut out),
        Record::Region(region) => region_references(region, &mut out),
        Record::Surface(surface) => {
            if let Paint::Image { texture, palette } = surface.paint {
                out.portal("texture", texture);
                out.portal("palette", palette);
            }
        }
        Record::SurfaceTexture(texture) => out.portals("textures", &texture.textures),
        Record::RenderSurface(surface) => out.portal("palette", surface.palette.unwrap_or(0)),
        Record::Scene(scene) => {
            for (i, object) in scene.objects.iter().enumerate() {
                out.portal(format!("objects[{i}].object_id"), object.object_id);
            }
        }
        Record::GfxObjDegradeInfo(info) => {
            for (i, degrade) in info.degrades.iter().enumerate() {
                out.portal(format!("degrades[{i}].gfx_obj"), degrade.gfx_obj);
            }
        }
        _ => {}
    }
    out.found
}

fn setup_references(setup: &Setup, out: &mut Collector) {
    out.portals("parts", &setup.parts);
    for (field, id) in [
        ("default_animation", setup.default_animation),
        ("default_script", setup.default_script),
        ("default_motion_table", setup.default_motion_table),
        ("default_sound_table", setup.default_sound_table),
        ("default_script_table", setup.default_script_table),
    ] {
        out.portal(field, id);
    }
}

fn region_references(region: &Region, out: &mut Collector) {
    for (i, group) in region.sky.iter().flat_map(|sky| &sky.day_groups).enumerate() {
        for (j, object) in group.sky_objects.iter().enumerate() {
            out.portal(format!("sky.day_groups[{i}].sky_objects[{j}].gfx_obj"), object.gfx_obj);
            out.portal(format!("sky.day_groups[{i}].sky_objects[{j}].pes"), object.pes);
        }
        for (j, replace) in group.sky_times.iter().flat_map(|time| &time.replaces).enumerate() {
            out.portal(format!("sky.day_groups[{i}].replaces[{j}].gfx_obj"), replace.gfx_obj);
        }
    }
    for (i, table) in region.sound.iter().flat_map(|sound| &sound.tables).enumerate() {
        out.portal(format!("sound.tables[{i}].sound_table"), table.sound_table);
    }
    for (i, scene_type) in region.scene.iter().flat_map(|scene| &scene.scene_types).enumerate() {
        out.portals(&format!("scene.scene_types[{i}].scenes"), &scene_type.scenes);
    }
    let merge = &region.terrain.tex_merge;
    for (i, map) in merge.corner_maps.iter().enumerate() {
        out.portal(format!("terrain.tex_merge.corner_maps[{i}].texture"), map.texture);
    }
    for (i, map) in merge.side_maps.iter().enumerate() {
        out.portal(format!("terrain.tex_merge.side_maps[{i}].texture"), map.texture);
    }
    for (i, map) in merge.road_maps.iter().enumerate() {
        out.portal(format!("terrain.tex_merge.road_maps[{i}].texture"), map.texture);
    }
    for (i, texture) in merge.textures.iter().enumerate() {
        out.portal(format!("terrain.tex_merge.textures[{i}].texture"), texture.texture);
        out.portal(format!("terrain.tex_merge.textures[{i}].detail_texture"), texture.detail_texture);
    }
    if let Some(misc) = &region.misc {
        for (field, id) in [
            ("misc.game_map", misc.game_map),
            ("misc.autotest_map", misc.autotest_map),
            ("misc.clear_cell", misc.clear_cell),
            ("misc.clear_monster", misc.clear_monster),
        ] {
            out.portal(field, id);
        }
    }
}

#[derive(Default)]
struct Collector {
    found: Vec<Reference>,
}

impl Collector {
    fn add(&mut self, field: impl Into<String>, store: Store, id: u32) {
        if id != 0 && id != u32::MAX {
            self.found.push(Reference { field: field.into(), store, id });
        }
    }

    fn cell(&mut self, field: impl Into<String>, id: u32) {
        self.add(field, Store::Cell, id);
    }

    fn portal(&mut self, field: impl Into<String>, id: u32) {
        self.add(field, Store::Portal, id);
    }

    fn portals(&mut self, field: &str, ids: &[u32]) {
        for (i, &id) in ids.iter().enumerate() {
            self.portal(format!("{field}[{i}]"), id);
        }
    }
}

/// A record that uses another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct User {
    /// The file it is in.
    pub file: DatKind,
    /// Its id.
    pub id: u32,
    /// What it is.
    pub kind: RecordKind,
    /// The fields that name the other record.
    pub fields: Vec<String>,
}

/// Who uses a record, from [`users_of`].
#[derive(Clone, Debug, Default)]
pub struct Users {
    /// The users, by file and id.
    pub users: Vec<User>,
    /// Records and directory nodes that could not be read, as errors.
    pub unreadable: Vec<String>,
}

/// Every record that names record `id` of `store`. Reads all records whose type can name others; `progress` is called with
/// the number of records looked at.
pub fn users_of(dats: &DatSet, store: Store, id: u32, progress: &mut dyn FnMut(u64)) -> Users {
    let mut out = Users::default();
    let mut done = 0;
    for (file_kind, file) in dats.files() {
        for entry in users_in(file_kind, store, id, file) {
            done += 1;
            progress(done);
            let entry = match entry {
                Ok(entry) => entry,
                Err(e) => {
                    out.unreadable.push(e.to_string());
                    continue;
                }
            };
            let kind = RecordKind::of(file_kind, entry.id);
            if !can_refer(kind, store) {
                continue;
            }
            match read(file, &entry, kind) {
                Ok(record) => {
                    let fields: Vec<String> = of_record(&record)
                        .into_iter()
                        .filter(|r| r.store == store && r.id == id)
                        .map(|r| r.field)
                        .collect();
                    if !fields.is_empty() {
                        out.users.push(User { file: file_kind, id: entry.id, kind, fields });
                    }
                }
                Err(e) => out.unreadable.push(e),
            }
        }
    }
    out
}

/// The entries of a file that may name the record: only those of its landblock where a cell record is named.
fn users_in<'a>(kind: DatKind, store: Store, id: u32, file: &'a DatFile) -> vestibule_dat::Entries<'a> {
    match (kind, store) {
        (DatKind::Cell, Store::Cell) => file.range(id & 0xFFFF_0000..=id | 0xFFFF),
        (DatKind::Cell, Store::Portal) | (_, Store::Portal) => file.iter(),
        (_, Store::Cell) => file.range(0..0),
    }
}

fn can_refer(kind: RecordKind, store: Store) -> bool {
    use RecordKind as K;
    match kind {
        K::LandBlock => store == Store::Cell,
        K::LandBlockInfo | K::EnvCell => true,
        K::GfxObj | K::Setup | K::Region | K::Surface | K::SurfaceTexture => store == Store::Portal,
        K::RenderSurface | K::Scene | K::GfxObjDegradeInfo => store == Store::Portal,
        _ => false,
    }
}

fn read(file: &DatFile, entry: &Entry, kind: RecordKind) -> Result<Record, String> {
    let bytes = file.read(entry).map_err(|e| e.to_string())?;
    Record::parse(kind, entry.id, &bytes).map_err(|e| format!("{e}, in {}", file.name()))
}
