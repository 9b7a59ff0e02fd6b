//! Shapes of objects: models and setups compiled for collision and cell tests, shared by all that use them.

use std::sync::Arc;

use glam::Vec3;

use crate::aperture_tree::ApertureTree;
use crate::frame::Frame;
use crate::geometry::{BoundingBox, CylSphere, Sphere};
use crate::ids::{BlockId, CellId};
use crate::physics_bsp::PhysicsBsp;
use crate::polygon::PolygonSet;

/// An opening in a building's shell, found through the drawing BSP's PORT nodes (`dat-format.md` G12).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Aperture {
    /// Position of the aperture polygon in [`Model::polygons`].
    pub polygon: u32,
    /// Index into the building's portal list.
    pub portal: u16,
}

/// A GfxObj: what collides, what it occupies, and where its openings are. Model-local metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Record id (0x01…).
    pub id: u32,
    /// Collision tree, if the record has one.
    pub physics: Option<PhysicsBsp>,
    /// Sphere of the physics tree's root (`dat-format.md` G11).
    pub physics_sphere: Option<Sphere>,
    /// Sphere of the drawing tree's root; radius 0 at the origin when the root is a leaf.
    pub drawing_sphere: Option<Sphere>,
    /// Box of all vertices (`dat-format.md` X1); zero when there are none.
    pub bounds: BoundingBox,
    /// Drawn polygons.
    pub polygons: PolygonSet,
    /// Openings, ascending by portal index.
    pub apertures: Box<[Aperture]>,
    /// In which order the openings are met (`visibility.md` 8.2).
    pub aperture_tree: ApertureTree,
}

impl Model {
    /// The sphere the cell tests use: the physics sphere first, else the drawing sphere (`world.md` 10.2).
    pub fn cell_sphere(&self) -> Option<Sphere> {
        self.physics_sphere.or(self.drawing_sphere)
    }
}

/// One part of a [`Shape`].
#[derive(Clone, Debug, PartialEq)]
pub struct ShapePart {
    /// The model, `None` when its record is missing or damaged.
    pub model: Option<Arc<Model>>,
    /// Record id of the model (0x01…).
    pub model_id: u32,
    /// Part to object frame in the placement a world object takes (`dat-format.md` X4), unscaled.
    pub frame: Frame,
    /// Default scale of the part.
    pub scale: Vec3,
}

/// A Setup, or a GfxObj seen as a Setup of one part (`dat-format.md` X5). Object-local metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Record id (0x02… or 0x01…).
    pub id: u32,
    /// Parts in record order.
    pub parts: Box<[ShapePart]>,
    /// Collision cylinders.
    pub cylspheres: Box<[CylSphere]>,
    /// Collision spheres.
    pub spheres: Box<[Sphere]>,
    /// Some part's model has a physics BSP, which then is what collides (`world.md` B2).
    pub has_physics_bsp: bool,
    /// May turn without changing its frame of movement (Setup flag 4).
    pub allow_free_heading: bool,
    /// Height, metres.
    pub height: f32,
    /// Radius, metres.
    pub radius: f32,
    /// How high it steps up, metres.
    pub step_up_height: f32,
    /// How far it steps down, metres.
    pub step_down_height: f32,
    /// Sphere for sorting and for cell tests of moving objects.
    pub sorting_sphere: Sphere,
    /// Sphere for picking.
    pub selection_sphere: Sphere,
}

/// A static object of a landblock or env cell, placed (`world.md` B2, H7).
#[derive(Clone, Debug, PartialEq)]
pub struct StaticObject {
    /// What it is: GfxObj or Setup.
    pub shape: Arc<Shape>,
    /// Object to landblock frame, as stored.
    pub frame: Frame,
    /// The cell it was put into.
    pub cell: CellId,
    /// Part to landblock frame, one per part of the shape.
    pub part_frames: Box<[Frame]>,
    /// Around its parts, landblock frame; see [`bounding_sphere`].
    pub bounds: Sphere,
}

impl StaticObject {
    /// Places a shape of scale 1.
    pub fn new(shape: Arc<Shape>, frame: Frame, cell: CellId) -> Self {
        let part_frames: Box<[Frame]> = shape.parts.iter().map(|p| frame.combine(&p.frame)).collect();
        StaticObject {
            bounds: bounding_sphere(&shape, &frame, &part_frames, 1.0),
            shape,
            frame,
            cell,
            part_frames,
        }
    }
}

/// A sphere around the parts of a shape placed at a scale, in the frame its part frames lead to; around the sorting
/// sphere and the spheres of a shape without models.
pub fn bounding_sphere(shape: &Shape, frame: &Frame, part_frames: &[Frame], scale: f32) -> Sphere {
    let mut hull: Option<BoundingBox> = None;
    for (part, placed) in shape.parts.iter().zip(part_frames) {
        let Some(model) = &part.model else { continue };
        for corner in model.bounds.corners() {
            let p = placed.local_to_global(corner * part.scale * scale);
            match &mut hull {
                Some(hull) => hull.grow(p),
                None => hull = Some(BoundingBox { min: p, max: p }),
            }
        }
    }
    match hull {
        Some(hull) => {
            let half: Vec3 = (hull.max - hull.min) * 0.5;
            Sphere::new(hull.min + half, half.length())
        }
        None => {
            let all = shape
                .spheres
                .iter()
                .fold(shape.sorting_sphere, |a, b| a.around(b));
            Sphere::new(frame.local_to_global(all.center * scale), all.radius * scale)
        }
    }
}

/// A box around the origin of a building and the parts of its shell, in the frame its part frames lead to.
pub(crate) fn building_bounds(shape: &Shape, frame: &Frame, part_frames: &[Frame]) -> BoundingBox {
    let mut out = BoundingBox {
        min: frame.origin,
        max: frame.origin,
    };
    for (part, frame) in shape.parts.iter().zip(part_frames) {
        if let Some(model) = &part.model {
            let b = model.bounds.mapped(|p| frame.local_to_global(p * part.scale));
            out.grow(b.min);
            out.grow(b.max);
        }
    }
    out
}

/// An opening that leads from the landscape into a building (retail `CBldPortal`, `world.md` C3).
#[derive(Clone, Debug, PartialEq)]
pub struct BuildingPortal {
    /// The env cell behind it.
    pub other: CellId,
    /// Index of the matching portal in that cell; `None` when the record's signed value is below zero.
    pub other_portal: Option<u16>,
    /// `true` (retail `portal_side` 1): a viewer looks in from the negative side of the aperture polygon.
    pub interior_is_negative: bool,
    /// Both polygons coincide exactly.
    pub exact_match: bool,
    /// Cells that must be resident with this portal.
    pub stab_list: Box<[CellId]>,
}

/// A building: a one-part object that owns portals (`world.md` 7).
#[derive(Clone, Debug, PartialEq)]
pub struct Building {
    /// The shell's model record (0x01… or a Setup).
    pub model_id: u32,
    /// The shell; collision uses part 0 (`transition.md` 7.6).
    pub shape: Arc<Shape>,
    /// Building to landblock frame, as stored.
    pub frame: Frame,
    /// Part to landblock frame, one per part of the shape.
    pub part_frames: Box<[Frame]>,
    /// The one land cell it is registered with (`world.md` C1).
    pub cell: CellId,
    /// Its portals in record order.
    pub portals: Box<[BuildingPortal]>,
    /// Around its origin and its parts, landblock frame.
    pub bounds: BoundingBox,
}

/// Names one static object of a world: its landblock and its position in [`crate::Landblock::statics`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StaticRef {
    /// Landblock that loads it.
    pub block: BlockId,
    /// Position among the block's statics.
    pub index: u32,
}
