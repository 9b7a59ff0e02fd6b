//! Shared assets: models, shapes and cell structures, compiled once per record.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use glam::Vec3;
use vestibule_dat::record;

use crate::compile;
use crate::env_cell::CellStruct;
use crate::error::ProblemKind;
use crate::frame::Frame;
use crate::geometry::Sphere;
use crate::records::Records;
use crate::shape::{Model, Shape, ShapePart};
use crate::source::Store;

/// Compiled records by id. Only loading looks in here.
#[derive(Default)]
pub(crate) struct Assets {
    models: Cache<u32, Model>,
    shapes: Cache<u32, Shape>,
    structs: Cache<(u32, u16), CellStruct>,
    /// Memory of all of them, about.
    bytes: AtomicUsize,
}

impl Assets {
    /// Memory of what is kept, bytes, about.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Forgets what nothing uses.
    pub(crate) fn prune(&self) {
        prune(&self.shapes, &self.bytes);
        prune(&self.models, &self.bytes);
        prune(&self.structs, &self.bytes);
    }
}

/// What an asset takes in memory.
pub(crate) trait Memory {
    /// Bytes, about, without what it shares with others.
    fn memory(&self) -> usize;
}

fn prune<K: core::hash::Hash + Eq, V: Memory>(cache: &Cache<K, V>, bytes: &AtomicUsize) {
    let mut cache = cache.lock().unwrap_or_else(PoisonError::into_inner);
    cache.retain(|_, asset| match asset {
        Some(asset) if Arc::strong_count(asset) == 1 => {
            bytes.fetch_sub(asset.memory(), Ordering::Relaxed);
            false
        }
        // That a record is missing is remembered, so that it is reported once.
        _ => true,
    });
}

type Cache<K, V> = Mutex<HashMap<K, Option<Arc<V>>>>;

/// The cached value, made on first use. Two threads may make the same one; both are equal and one is kept.
fn cached<K: core::hash::Hash + Eq + Copy, V: Memory>(
    cache: &Cache<K, V>,
    bytes: &AtomicUsize,
    key: K,
    make: impl FnOnce() -> Option<V>,
) -> Option<Arc<V>> {
    let lock = || cache.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = lock().get(&key) {
        return found.clone();
    }
    let made = make().map(Arc::new);
    match lock().entry(key) {
        Entry::Occupied(there) => there.get().clone(),
        Entry::Vacant(free) => {
            bytes.fetch_add(made.as_ref().map_or(0, |asset| asset.memory()), Ordering::Relaxed);
            free.insert(made).clone()
        }
    }
}

impl Records {
    /// The model of a GfxObj record (0x01…).
    pub(crate) fn model(&self, id: u32, needed_by: u32) -> Option<Arc<Model>> {
        cached(&self.assets.models, &self.assets.bytes, id, || {
            self.parse(Store::Portal, id, needed_by, record::GfxObj::parse)
                .map(|record| {
                    let mut model = compile::model(id, &record);
                    if let (true, Some(physics)) = (self.exact, &mut model.physics) {
                        physics.forget_hints();
                    }
                    model
                })
        })
    }

    /// The shape of a Setup record (0x02…), or of a GfxObj (0x01…) as a setup of one part.
    pub(crate) fn shape(&self, id: u32, needed_by: u32) -> Option<Arc<Shape>> {
        cached(&self.assets.shapes, &self.assets.bytes, id, || match id >> 24 {
            0x01 => Some(self.one_part_shape(id, needed_by)),
            _ => self
                .parse(Store::Portal, id, needed_by, record::Setup::parse)
                .map(|setup| self.setup_shape(id, &setup)),
        })
    }

    fn one_part_shape(&self, id: u32, needed_by: u32) -> Shape {
        let model = self.model(id, needed_by);
        let sphere = model.as_ref().and_then(|m| m.cell_sphere()).unwrap_or_default();
        Shape {
            id,
            has_physics_bsp: model.as_ref().is_some_and(|m| m.physics.is_some()),
            parts: [ShapePart {
                model,
                model_id: id,
                frame: Frame::IDENTITY,
                scale: Vec3::ONE,
            }]
            .into(),
            cylspheres: [].into(),
            spheres: [].into(),
            allow_free_heading: true,
            height: 0.0,
            radius: 0.0,
            step_up_height: 0.0,
            step_down_height: 0.0,
            sorting_sphere: sphere,
            selection_sphere: sphere,
        }
    }

    fn setup_shape(&self, id: u32, setup: &record::Setup) -> Shape {
        let pose = setup.resting_frame();
        let parts: Box<[ShapePart]> = setup
            .parts
            .iter()
            .enumerate()
            .map(|(i, &model_id)| ShapePart {
                model: self.model(model_id, id),
                model_id,
                frame: pose
                    .and_then(|p| p.frames.get(i))
                    .map(Frame::from)
                    .unwrap_or_default(),
                scale: setup
                    .default_scales
                    .as_ref()
                    .and_then(|s| s.get(i))
                    .copied()
                    .unwrap_or(Vec3::ONE),
            })
            .collect();
        Shape {
            id,
            has_physics_bsp: parts
                .iter()
                .any(|p| p.model.as_ref().is_some_and(|m| m.physics.is_some())),
            parts,
            cylspheres: setup.cyl_spheres.iter().map(Into::into).collect(),
            spheres: setup.spheres.iter().map(Sphere::from).collect(),
            allow_free_heading: setup.allow_free_heading(),
            height: setup.height,
            radius: setup.radius,
            step_up_height: setup.step_up_height,
            step_down_height: setup.step_down_height,
            sorting_sphere: (&setup.sorting_sphere).into(),
            selection_sphere: (&setup.selection_sphere).into(),
        }
    }

    /// A cell structure of an Environment record (0x0D…). The first one asked for makes all of its record's, since
    /// finding one means reading them all.
    pub(crate) fn cell_struct(&self, environment: u32, key: u16, cell: u32) -> Option<Arc<CellStruct>> {
        let Assets { structs, bytes, .. } = &self.assets;
        let known = |key: u16| {
            let cache = structs.lock().unwrap_or_else(PoisonError::into_inner);
            cache.get(&(environment, key)).cloned()
        };
        if let Some(found) = known(key) {
            return found;
        }
        if let Some(record) = self.parse(Store::Portal, environment, cell, record::Environment::parse) {
            for shape in &record.cell_structs {
                if let Ok(key) = u16::try_from(shape.id) {
                    let make = || {
                        let mut made = compile::cell_struct(environment, key, shape);
                        if let (true, Some(physics)) = (self.exact, &mut made.physics) {
                            physics.forget_hints();
                        }
                        Some(made)
                    };
                    cached(structs, bytes, (environment, key), make);
                }
            }
            if known(key).is_none() {
                self.report_in(Store::Cell, cell, ProblemKind::NoCellStruct { environment, key });
            }
        }
        cached(structs, bytes, (environment, key), || None)
    }
}

impl Memory for Model {
    fn memory(&self) -> usize {
        size_of::<Self>()
            + self.physics.as_ref().map_or(0, |p| p.memory())
            + self.polygons.memory()
            + size_of_val(&*self.apertures)
            + self.aperture_tree.memory()
    }
}

impl Memory for Shape {
    fn memory(&self) -> usize {
        size_of::<Self>()
            + size_of_val(&*self.parts)
            + size_of_val(&*self.cylspheres)
            + size_of_val(&*self.spheres)
    }
}

impl Memory for CellStruct {
    fn memory(&self) -> usize {
        size_of::<Self>()
            + size_of_val(self.cell_bsp.planes())
            + self.physics.as_ref().map_or(0, |p| p.memory())
            + self.polygons.memory()
            + size_of_val(&*self.portal_polygons)
    }
}
