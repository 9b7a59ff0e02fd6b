//! Which level of a model is drawn at which distance (`rendering.md` 17.1, 17.2).

use glam::{Mat3, Quat, Vec3};
use vestibule_dat::record::Degrade;
use vestibule_physics::Population;
use vestibule_view::{FrameObject, FrameSource, WorldObjects};
use vestibule_world::{BlockId, Building, CellId, Frame, World};

use crate::assets::Assets;

/// Nearer than this everything is drawn in full, metres.
const BIAS: f32 = 50.0;

/// The level of a model for a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelLevel {
    /// The model (0x01…) to draw; `None` draws nothing.
    pub model: Option<u32>,
    /// How it is turned: 2 towards the viewer, 3, 4, 5 about its x, y, z axis; otherwise not.
    pub mode: u32,
}

/// Picks the level for a distance in metres, already divided by the part's scale along z. `quality` is -1…1: 0 is
/// retail's default, 1 keeps detail as far as the record allows. `model` is drawn where there are no levels.
pub fn model_level(model: u32, levels: &[Degrade], distance: f32, quality: f32) -> ModelLevel {
    match level_at(levels, distance, quality).and_then(|at| levels.get(at)) {
        Some(level) => ModelLevel {
            model: (level.gfx_obj != 0).then_some(level.gfx_obj),
            mode: level.degrade_mode,
        },
        None => ModelLevel {
            model: Some(model),
            mode: 1,
        },
    }
}

/// The position of the level that [`model_level`] picks; `None` where there are no levels.
pub(crate) fn level_at(levels: &[Degrade], distance: f32, quality: f32) -> Option<usize> {
    let far = distance - BIAS;
    let far = if far > 0.0 { far } else { 0.0 };
    let limit = |d: &Degrade| {
        if quality >= 0.0 {
            d.ideal_dist + quality * (d.max_dist - d.ideal_dist)
        } else {
            d.ideal_dist + quality * (d.ideal_dist - d.min_dist)
        }
    };
    let nearer = levels.iter().position(|d| far < limit(d));
    nearer.or(levels.len().checked_sub(1))
}

/// A part's frame turned to a viewer at `eye`, both in one frame, as the mode of its level says. What is turned to the
/// viewer is the part's front, its y axis.
pub fn turned(frame: &Frame, eye: Vec3, mode: u32) -> Frame {
    let gap = eye - frame.origin;
    let rotation = match mode {
        2 => {
            let forward = gap.normalize_or_zero();
            let right = forward.cross(Vec3::Z).normalize_or_zero();
            if right == Vec3::ZERO {
                return *frame;
            }
            Quat::from_mat3(&Mat3::from_cols(right, forward, right.cross(forward)))
        }
        3..=5 => {
            let local = frame.global_to_local(eye);
            let (turn, angle): (fn(f32) -> Quat, f32) = match mode {
                3 => (Quat::from_rotation_x, libm::atan2f(local.z, local.y)),
                4 => (Quat::from_rotation_y, libm::atan2f(local.x, local.z)),
                _ => (Quat::from_rotation_z, libm::atan2f(-local.x, local.y)),
            };
            if !angle.is_finite() {
                return *frame;
            }
            frame.rotation() * turn(angle)
        }
        _ => return *frame,
    };
    Frame::new(frame.origin, rotation)
}

/// The objects of a world for [`FrameView::update`](vestibule_view::FrameView::update), with the shells of buildings
/// in the level of detail that their distance asks for.
#[derive(Clone, Copy, Debug)]
pub struct DetailedObjects<'a> {
    objects: WorldObjects<'a>,
    world: &'a World,
    assets: &'a Assets,
    /// As [`RenderSettings::detail`](crate::RenderSettings::detail).
    pub quality: f32,
}

impl<'a> DetailedObjects<'a> {
    /// The static objects of a world, in retail's default quality.
    pub fn new(world: &'a World, assets: &'a Assets) -> Self {
        DetailedObjects {
            objects: WorldObjects::new(world),
            world,
            assets,
            quality: 0.0,
        }
    }

    /// And the bodies of `population`.
    #[must_use]
    pub fn with_population(mut self, population: &'a Population) -> Self {
        self.objects = self.objects.with_population(population);
        self
    }
}

impl FrameSource for DetailedObjects<'_> {
    fn objects_in(&self, cell: CellId, each: &mut dyn FnMut(FrameObject)) {
        self.objects.objects_in(cell, each);
    }

    fn land_cells_with_objects(&self, block: BlockId) -> u64 {
        self.objects.land_cells_with_objects(block)
    }

    fn building_model(&self, building: &Building, distance: f32) -> Option<u32> {
        let model = self.objects.building_model(building, distance)?;
        let scale = building.shape.parts.first().map_or(1.0, |p| p.scale.z);
        self.assets
            .model_level(self.world, model, distance / scale, self.quality)
            .model
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels() -> [Degrade; 3] {
        let level = |gfx_obj, degrade_mode, min_dist, ideal_dist, max_dist| Degrade {
            gfx_obj,
            degrade_mode,
            min_dist,
            ideal_dist,
            max_dist,
        };
        [
            level(0x0100_0001, 1, 10.0, 20.0, 40.0),
            level(0x0100_0002, 2, 30.0, 60.0, 90.0),
            level(0, 1, 0.0, 0.0, 0.0),
        ]
    }

    #[test]
    fn r17_1_levels_by_distance_and_quality() {
        let at = |d: f32, quality: f32| model_level(7, &levels(), d, quality).model;
        assert_eq!(at(0.0, 0.0), Some(0x0100_0001));
        // 50 m are free.
        assert_eq!(at(69.9, 0.0), Some(0x0100_0001));
        assert_eq!(at(70.0, 0.0), Some(0x0100_0002), "strictly nearer");
        assert_eq!(at(109.9, 0.0), Some(0x0100_0002));
        assert_eq!(at(110.0, 0.0), None, "past the end the last");
        assert_eq!(at(89.9, 1.0), Some(0x0100_0001));
        assert_eq!(at(60.0, -1.0), Some(0x0100_0002));
        assert_eq!(at(65.0, 0.5), Some(0x0100_0001));
        assert_eq!(
            model_level(7, &[], 1.0e6, 0.0).model,
            Some(7),
            "no record: the model itself"
        );
    }

    #[test]
    fn r17_2_parts_that_turn_to_the_viewer() {
        let frame = Frame::at(Vec3::new(1.0, 2.0, 3.0));
        let eye = Vec3::new(4.0, 6.0, 8.0);
        let gap = (eye - frame.origin).normalize();
        let front = |mode| turned(&frame, eye, mode).axes()[1];
        assert!((front(2) - gap).length() < 1e-5);
        assert!((front(5) - Vec3::new(0.6, 0.8, 0.0)).length() < 1e-5);
        assert!(front(3).x.abs() < 1e-6 && front(3).dot(gap) > 0.0);
        assert!((front(4) - Vec3::Y).length() < 1e-6);
        assert_eq!(turned(&frame, eye, 1).axes(), frame.axes());
        assert_eq!(turned(&frame, frame.origin, 2).axes(), frame.axes());
    }
}
