//! Meshes, materials, textures and lights of a world, made from its records once and shared (`rendering.md` 14, 15).

use core::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::Vec3;
use vestibule_dat::record::{
    self, Degrade, Environment, GfxObj, GfxObjDegradeInfo, Paint, Palette, RecordError, RenderSurface, Setup,
    Surface, SurfaceTexture,
};
use vestibule_view::NumberMap;
use vestibule_world::{EnvCell, Model, Store, World};

use crate::material::Material;
use crate::mesh::{Mesh, MeshInput};
use crate::sky::SkyTable;
use crate::terrain_paint::TerrainPaint;
use crate::texture::{DecodeAs, Texture, decode};

/// What could not be had or was odd, counted while assets were made: every placeholder in a picture is in here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct AssetCounters {
    /// Surfaces that are missing or damaged; drawn as a magenta checker.
    pub missing_surfaces: u32,
    /// Textures that are missing or damaged; drawn as a magenta checker.
    pub missing_textures: u32,
    /// Textures in a format that is not read, or of absurd size; drawn as a magenta checker.
    pub unusable_textures: u32,
    /// Models that are missing or damaged; not drawn.
    pub missing_models: u32,
    /// Cell structures that are missing or damaged; not drawn.
    pub missing_structures: u32,
    /// Portal polygons with a real surface, drawn (`rendering.md` 14.5).
    pub drawn_portals: u32,
    /// Textured sides without texture coordinates, not drawn (14.4).
    pub sides_without_uvs: u32,
    /// Corners that name no vertex, or one that is not finite; left out.
    pub bad_vertices: u32,
    /// Surface indices outside their list; the side is not drawn.
    pub bad_surfaces: u32,
}

impl AssetCounters {
    /// How many placeholders and left-out things there are in all.
    pub fn total(&self) -> u32 {
        self.missing_surfaces
            + self.missing_textures
            + self.unusable_textures
            + self.missing_models
            + self.missing_structures
            + self.drawn_portals
            + self.sides_without_uvs
            + self.bad_vertices
            + self.bad_surfaces
    }
}

/// A light of an object, in the object's frame (`rendering.md` 12.8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectLight {
    /// Where, metres.
    pub position: Vec3,
    /// Red, green, blue, 0…1.
    pub color: Vec3,
    /// Brightness.
    pub intensity: f32,
    /// Metres.
    pub falloff: f32,
}

type Cache<K, V> = Mutex<NumberMap<K, V>>;

/// The assets of one world, made when first asked for, from any thread. One value belongs to one [`World`]; share it
/// by reference.
pub struct Assets {
    /// Different for each value.
    serial: u64,
    materials: Cache<u32, Arc<Material>>,
    textures: Cache<(u32, u32, DecodeAs), (Arc<Texture>, bool)>,
    models: Cache<(u32, bool), Option<Arc<Mesh>>>,
    cells: Cache<(u32, u16, Box<[u32]>), Option<Arc<Mesh>>>,
    /// The same by the id of the cell.
    shells: Cache<u32, Option<Arc<Mesh>>>,
    levels: Cache<u32, Arc<[Degrade]>>,
    lights: Cache<u32, Arc<[ObjectLight]>>,
    lamps: Cache<u32, Arc<[crate::lighting::Lamp]>>,
    lands: Cache<(u16, u16), Option<Arc<crate::land::LandMesh>>>,
    terrain: OnceLock<Arc<TerrainPaint>>,
    sky: OnceLock<Arc<SkyTable>>,
    textured: OnceLock<bool>,
    counters: Mutex<AssetCounters>,
}

fn cached<K: core::hash::Hash + Eq, V: Clone>(cache: &Cache<K, V>, key: K, make: impl FnOnce() -> V) -> V {
    let lock = || cache.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = lock().get(&key) {
        return found.clone();
    }
    let made = make();
    lock().entry(key).or_insert(made).clone()
}

impl core::fmt::Debug for Assets {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Assets")
            .field("counters", &self.counters())
            .finish_non_exhaustive()
    }
}

impl Default for Assets {
    fn default() -> Self {
        static MADE: AtomicU64 = AtomicU64::new(0);
        Assets {
            serial: MADE.fetch_add(1, Ordering::Relaxed) + 1,
            materials: Cache::default(),
            textures: Cache::default(),
            models: Cache::default(),
            cells: Cache::default(),
            shells: Cache::default(),
            levels: Cache::default(),
            lights: Cache::default(),
            lamps: Cache::default(),
            lands: Cache::default(),
            terrain: OnceLock::new(),
            sky: OnceLock::new(),
            textured: OnceLock::new(),
            counters: Mutex::default(),
        }
    }
}

impl Assets {
    /// Nothing made yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A number that no other value of this process has, never 0.
    pub(crate) fn serial(&self) -> u64 {
        self.serial
    }

    /// What was missing or odd so far.
    pub fn counters(&self) -> AssetCounters {
        *self.counters.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn count(&self, what: impl FnOnce(&mut AssetCounters)) {
        what(&mut self.counters.lock().unwrap_or_else(PoisonError::into_inner));
    }

    pub(crate) fn record<T>(
        &self,
        world: &World,
        id: u32,
        parse: impl FnOnce(u32, &[u8]) -> Result<T, RecordError>,
    ) -> Option<T> {
        let bytes = world.source().record(Store::Portal, id).ok()??;
        parse(id, &bytes).ok()
    }

    /// Whether the world's files hold textures: those of the terrain are looked for. In a world without any,
    /// coloured polygons of shells are drawn (`rendering.md` 14.4a).
    pub fn has_textures(&self, world: &World) -> bool {
        *self
            .textured
            .get_or_init(|| self.terrain(world).has_textures() || any_surface_texture(world))
    }

    /// The terrain textures of the region.
    pub fn terrain(&self, world: &World) -> Arc<TerrainPaint> {
        self.terrain
            .get_or_init(|| Arc::new(TerrainPaint::read(self, world)))
            .clone()
    }

    /// Sky, light and fog of the region.
    pub fn sky(&self, world: &World) -> Arc<SkyTable> {
        self.sky.get_or_init(|| Arc::new(SkyTable::read(world))).clone()
    }

    /// The picture of a SurfaceTexture (0x05…) or RenderSurface (0x06…), and whether it has a palette. `palette` 0
    /// takes the texture's own (`rendering.md` 15.1). What cannot be had is a magenta checker.
    pub fn texture(&self, world: &World, id: u32, palette: u32, how: DecodeAs) -> (Arc<Texture>, bool) {
        cached(&self.textures, (id, palette, how), || {
            self.try_texture(world, id, palette, how)
                .unwrap_or_else(|| (Arc::new(Texture::placeholder()), false))
        })
    }

    /// As [`Assets::texture`]; `None` when it cannot be had.
    pub(crate) fn try_texture(
        &self,
        world: &World,
        id: u32,
        palette: u32,
        how: DecodeAs,
    ) -> Option<(Arc<Texture>, bool)> {
        let Some(surface) = self.render_surface(world, id) else {
            self.count(|c| c.missing_textures += 1);
            return None;
        };
        let paletted = surface.palette.is_some();
        let palette = surface
            .palette
            .map(|own| if palette != 0 { palette } else { own })
            .and_then(|id| self.record(world, id, Palette::parse));
        match decode(&surface, palette.as_ref(), how) {
            Ok(texture) => Some((Arc::new(texture), paletted)),
            Err(_) => {
                self.count(|c| c.unusable_textures += 1);
                None
            }
        }
    }

    fn render_surface(&self, world: &World, id: u32) -> Option<RenderSurface> {
        if id >> 24 == 0x06 {
            return self.record(world, id, RenderSurface::parse);
        }
        let texture = self.record(world, id, SurfaceTexture::parse)?;
        // The first may exist only in the highres file (`dat-format.md` X11).
        texture
            .textures
            .iter()
            .find_map(|&id| self.record(world, id, RenderSurface::parse))
    }

    /// The material of a Surface (0x08…).
    pub fn material(&self, world: &World, id: u32) -> Arc<Material> {
        cached(&self.materials, id, || {
            let Some(surface) = self.record(world, id, Surface::parse) else {
                self.count(|c| c.missing_surfaces += 1);
                return Arc::new(Material::placeholder());
            };
            let (texture, paletted) = match surface.paint {
                Paint::Image { texture, palette } => {
                    let how = DecodeAs {
                        clip_map: surface.surface_type & Surface::CLIP_MAP != 0,
                        additive: surface.surface_type & Surface::ADDITIVE != 0,
                    };
                    self.texture(world, texture, palette, how)
                }
                Paint::Color(c) => (
                    Arc::new(Texture::solid([c.red(), c.green(), c.blue(), c.alpha()])),
                    false,
                ),
            };
            Arc::new(Material::new(&surface, texture, paletted))
        })
    }

    fn materials(&self, world: &World, ids: &[u32]) -> Vec<Arc<Material>> {
        ids.iter().map(|&id| self.material(world, id)).collect()
    }

    fn build(&self, input: MeshInput<'_>) -> Arc<Mesh> {
        let (mesh, odd) = Mesh::build(input);
        self.count(|c| {
            c.drawn_portals += odd.drawn_portals;
            c.sides_without_uvs += odd.without_uvs;
            c.bad_vertices += odd.bad_vertices;
            c.bad_surfaces += odd.bad_surfaces;
        });
        Arc::new(mesh)
    }

    /// The mesh of a GfxObj (0x01…). `shell`: it is drawn as a building's shell, whose colours stay open (14.4).
    pub fn model(&self, world: &World, id: u32, shell: Option<&Model>) -> Option<Arc<Mesh>> {
        cached(&self.models, (id, shell.is_some()), || {
            let Some(record) = self.record(world, id, GfxObj::parse) else {
                self.count(|c| c.missing_models += 1);
                return None;
            };
            let is_portal = |polygon: u16| {
                shell.is_some_and(|model| {
                    let named = |a: &vestibule_world::Aperture| {
                        model
                            .polygons
                            .get(a.polygon as usize)
                            .is_some_and(|p| p.id == polygon)
                    };
                    model.apertures.iter().any(named)
                })
            };
            Some(self.build(MeshInput {
                vertices: &record.vertices,
                polygons: record.drawing.as_ref().map_or(&[], |d| &d.polygons),
                materials: self.materials(world, &record.surfaces),
                shell: shell.is_some(),
                untextured_world: !self.has_textures(world),
                is_portal: &is_portal,
            }))
        })
    }

    /// The levels of detail of a GfxObj (0x01…), near to far; none for most (`rendering.md` 17.1).
    pub fn levels(&self, world: &World, model: u32) -> Arc<[Degrade]> {
        cached(&self.levels, model, || {
            let id = self
                .record(world, model, GfxObj::parse)
                .and_then(|m| m.degrade_id);
            let info = id.and_then(|id| self.record(world, id, GfxObjDegradeInfo::parse));
            info.map_or_else(|| [].into(), |i| i.degrades.into())
        })
    }

    /// The level of a model for a distance in metres, divided by the part's scale along z; see
    /// [`model_level`](crate::model_level).
    pub fn model_level(&self, world: &World, model: u32, distance: f32, quality: f32) -> crate::ModelLevel {
        crate::detail::model_level(model, &self.levels(world, model), distance, quality)
    }

    /// The mesh of an env cell's shell, cell-local.
    pub fn cell_shell(&self, world: &World, cell: &EnvCell) -> Option<Arc<Mesh>> {
        cached(&self.shells, cell.id.0, || self.structure_shell(world, cell))
    }

    fn structure_shell(&self, world: &World, cell: &EnvCell) -> Option<Arc<Mesh>> {
        let structure = &cell.structure;
        let key = (structure.environment, structure.key, cell.surfaces.clone());
        cached(&self.cells, key, || {
            let environment = self.record(world, structure.environment, Environment::parse);
            let found = environment
                .as_ref()
                .and_then(|e| e.cell_struct(u32::from(structure.key)));
            let Some(found): Option<&record::CellStruct> = found else {
                self.count(|c| c.missing_structures += 1);
                return None;
            };
            Some(self.build(MeshInput {
                vertices: &found.vertices,
                polygons: &found.polygons,
                materials: self.materials(world, &cell.surfaces),
                shell: true,
                untextured_world: !self.has_textures(world),
                is_portal: &|polygon| found.portals.contains(&polygon),
            }))
        })
    }

    /// The lights of a Setup (0x02…); none for a GfxObj.
    pub fn lights(&self, world: &World, shape: u32) -> Arc<[ObjectLight]> {
        if shape >> 24 != 0x02 {
            return [].into();
        }
        cached(&self.lights, shape, || {
            let setup = self.record(world, shape, Setup::parse);
            let lights = setup.iter().flat_map(|s| &s.lights);
            lights
                .map(|l| ObjectLight {
                    position: l.frame.origin,
                    color: rgb(l.color),
                    intensity: l.intensity,
                    falloff: l.falloff,
                })
                .filter(|l| l.position.is_finite() && l.intensity.is_finite() && l.falloff.is_finite())
                .collect()
        })
    }
}

/// Whether a texture is among the first records that a file with textures would have.
fn any_surface_texture(world: &World) -> bool {
    (0x0600_0000..0x0600_0100u32).any(|id| matches!(world.source().record(Store::Portal, id), Ok(Some(_))))
}

/// A colour as red, green, blue, 0…1 (`rendering.md` 12.2).
pub(crate) fn rgb(c: vestibule_dat::primitive::Argb) -> Vec3 {
    Vec3::new(f32::from(c.red()), f32::from(c.green()), f32::from(c.blue())) / 255.0
}

impl Assets {
    /// The lights that an env cell's shell is lit by: those of the static objects of the cell and of its stab list,
    /// in the frame of its landblock (`rendering.md` 12.6).
    pub fn lamps(&self, world: &World, cell: &EnvCell) -> Arc<[crate::lighting::Lamp]> {
        cached(&self.lamps, cell.id.0, || {
            crate::lighting::lamps_of(self, world, cell)
        })
    }

    /// The ground of a landblock. `neighbours` tells, bit by bit, which of the eight blocks around it are loaded:
    /// the light on its border depends on them.
    pub fn land(&self, world: &World, block: vestibule_world::BlockId) -> Option<Arc<crate::land::LandMesh>> {
        let key = (block.0, crate::land::loaded_neighbours(world, block));
        cached(&self.lands, key, || {
            crate::land::LandMesh::build(self, world, block).map(Arc::new)
        })
    }
}
