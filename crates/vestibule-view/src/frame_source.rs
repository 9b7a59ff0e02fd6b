//! What a frame asks its caller: the objects of a cell and the level of detail of a building.

use vestibule_physics::{BodyId, ObjectRef, Population};
use vestibule_world::{BlockId, Building, CellId, Sphere, World, bounding_sphere};

/// An object that may have to be drawn: what names it, and a sphere around it in the frame of the landblock of
/// the cell it was asked for, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameObject {
    /// The object.
    pub id: ObjectRef,
    /// Around all of it; its centre decides the order of drawing.
    pub sphere: Sphere,
}

/// Where a frame gets its objects from. Implement it to bring your own; [`WorldObjects`] serves what the crates of
/// this project know.
pub trait FrameSource {
    /// Hands every object registered in `cell` to `each`, in a fixed order. An object that reaches into several
    /// cells is registered in each (`rendering.md` 17.4).
    fn objects_in(&self, cell: CellId, each: &mut dyn FnMut(FrameObject));

    /// The land cells of a landblock in which there may be objects, one bit each in order of their ids; the others are
    /// not asked for. All, where that is not known.
    fn land_cells_with_objects(&self, block: BlockId) -> u64 {
        let _ = block;
        u64::MAX
    }

    /// The model (0x01…) to draw a building's shell with at this distance in metres; `None` draws neither the shell
    /// nor what is inside (`rendering.md` 6.3, 6.5).
    fn building_model(&self, building: &Building, distance: f32) -> Option<u32> {
        let _ = distance;
        let part = building.shape.parts.first()?;
        part.model.is_some().then_some(part.model_id)
    }
}

/// The static objects of a world and, if given, the bodies of a population.
#[derive(Clone, Copy, Debug)]
pub struct WorldObjects<'a> {
    world: &'a World,
    population: Option<&'a Population>,
    hidden: Option<BodyId>,
}

impl<'a> WorldObjects<'a> {
    /// The static objects of `world`.
    pub fn new(world: &'a World) -> Self {
        WorldObjects {
            world,
            population: None,
            hidden: None,
        }
    }

    /// And the bodies of `population`.
    #[must_use]
    pub fn with_population(mut self, population: &'a Population) -> Self {
        self.population = Some(population);
        self
    }

    /// But not this body: the player in first person (`rendering.md` 4.8).
    #[must_use]
    pub fn without(mut self, body: Option<BodyId>) -> Self {
        self.hidden = body;
        self
    }
}

impl FrameSource for WorldObjects<'_> {
    fn objects_in(&self, cell: CellId, each: &mut dyn FnMut(FrameObject)) {
        if let Some(block) = self.world.block(cell.block()) {
            for (id, sphere) in self.world.shadow_lists(block).with_bounds(cell) {
                each(FrameObject {
                    id: ObjectRef::Static(*id),
                    sphere: *sphere,
                });
            }
        }
        let Some(population) = self.population else { return };
        for &id in population.shadows_in(cell) {
            if Some(id) == self.hidden {
                continue;
            }
            let Some(body) = population.body(id) else { continue };
            let offset = vestibule_world::ids::block_offset(cell.block(), body.position().cell.block());
            let (shape, frame) = (body.shape(), &body.position().frame);
            let sphere = bounding_sphere(shape, frame, body.part_frames(), body.scale());
            each(FrameObject {
                id: ObjectRef::Body(id),
                sphere: Sphere::new(sphere.center + offset, sphere.radius),
            });
        }
    }

    fn land_cells_with_objects(&self, block: BlockId) -> u64 {
        if self.population.is_some_and(|p| !p.is_empty()) {
            return u64::MAX;
        }
        let block = self.world.block(block);
        block.map_or(0, |b| self.world.shadow_lists(b).land_cells())
    }
}
