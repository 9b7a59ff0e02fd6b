//! Models with their levels of detail and meshes, at positions of their own: a walk asks the assets once a model, not
//! once a part.

use std::sync::Arc;

use vestibule_dat::record::Degrade;
use vestibule_view::NumberMap;

use crate::detail::level_at;
use crate::mesh::Mesh;
use crate::scene::Scene;

/// The models that walks have met.
#[derive(Debug, Default)]
pub(crate) struct ModelTable {
    positions: NumberMap<u32, u32>,
    models: Vec<Model>,
}

#[derive(Debug)]
struct Model {
    id: u32,
    /// Asked for when it is first drawn.
    levels: Option<Arc<[Degrade]>>,
    /// One a level, or one without levels.
    meshes: Vec<Asked>,
}

#[derive(Clone, Debug)]
enum Asked {
    NotYet,
    Missing,
    Mesh(Arc<Mesh>),
}

/// What is drawn of a model at a distance.
pub(crate) enum Level<'m> {
    /// The level draws nothing.
    Nothing,
    /// The assets do not have it.
    Missing,
    /// This, turned as [`ModelLevel::mode`](crate::ModelLevel::mode) says.
    Mesh(&'m Arc<Mesh>, u32),
}

impl ModelTable {
    /// The position of a model (0x01…).
    pub(crate) fn position(&mut self, id: u32) -> u32 {
        *self.positions.entry(id).or_insert_with(|| {
            self.models.push(Model {
                id,
                levels: None,
                meshes: Vec::new(),
            });
            self.models.len() as u32 - 1
        })
    }

    /// The level of a model for a distance in metres, divided by the part's scale along z (`rendering.md` 17.1).
    pub(crate) fn level(
        &mut self,
        scene: &Scene<'_>,
        position: u32,
        distance: f32,
        quality: f32,
    ) -> Level<'_> {
        let Some(model) = self.models.get_mut(position as usize) else {
            return Level::Missing;
        };
        let levels = model
            .levels
            .get_or_insert_with(|| scene.assets.levels(scene.world, model.id));
        let found = level_at(levels, distance, quality);
        let (at, id, mode) = match found.and_then(|at| Some((at, levels.get(at)?))) {
            Some((_, level)) if level.gfx_obj == 0 => return Level::Nothing,
            Some((at, level)) => (at, level.gfx_obj, level.degrade_mode),
            None => (0, model.id, 1),
        };
        if model.meshes.len() <= at {
            model.meshes.resize(at + 1, Asked::NotYet);
        }
        let slot = &mut model.meshes[at];
        if let Asked::NotYet = slot {
            *slot = match scene.assets.model(scene.world, id, None) {
                Some(mesh) => Asked::Mesh(mesh),
                None => Asked::Missing,
            };
        }
        match slot {
            Asked::Mesh(mesh) => Level::Mesh(mesh, mode),
            _ => Level::Missing,
        }
    }
}
