//! Saving and restoring bodies whole. The types are plain numbers; with the feature `serde` they (de)serialise.

use std::sync::Arc;

use glam::{Quat, Vec3};
use vestibule_world::{CellId, Frame, Plane, Position, Shape, Sphere};

use crate::body::{Body, sphere_shape};
use crate::error::SweepError;
use crate::flags::{ObjectKind, PhysicsState, TransientState};
use crate::locomotion::Locomotion;
use crate::obj_collisions::ObjectRef;
use crate::population::{BodyId, CellLists, Population, Slot};
use crate::settings::Settings;
use crate::sweep::ContactPlane;

/// A position as numbers: cell id, origin, quaternion (w, x, y, z).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedPosition {
    /// Cell id.
    pub cell: u32,
    /// Origin in the frame of the cell's landblock, metres.
    pub origin: [f32; 3],
    /// Quaternion w, x, y, z.
    pub rotation: [f32; 4],
}

impl From<&Position> for SavedPosition {
    fn from(p: &Position) -> Self {
        let q = p.frame.rotation();
        SavedPosition {
            cell: p.cell.0,
            origin: p.origin().to_array(),
            rotation: [q.w, q.x, q.y, q.z],
        }
    }
}

impl From<&SavedPosition> for Position {
    fn from(p: &SavedPosition) -> Self {
        let [w, x, y, z] = p.rotation;
        let frame = Frame::new(Vec3::from_array(p.origin), Quat::from_xyzw(x, y, z, w));
        Position {
            cell: CellId(p.cell),
            frame,
        }
    }
}

/// The whole state of a body.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedBody {
    /// Record id of its shape; 0 for a body made of spheres.
    pub shape: u32,
    /// The spheres (x, y, z, radius) and step heights of a body without a record.
    pub spheres: Vec<[f32; 4]>,
    /// Scale.
    pub scale: f32,
    /// Place.
    pub position: SavedPosition,
    /// The cell it is in, if any.
    pub cell: Option<u32>,
    /// Physics state.
    pub state: PhysicsState,
    /// What the last move left.
    pub transient: TransientState,
    /// What the game says of it.
    pub kind: ObjectKind,
    /// Velocity, m/s.
    pub velocity: [f32; 3],
    /// Acceleration, m/s².
    pub acceleration: [f32; 3],
    /// Angular velocity, radians per second.
    pub omega: [f32; 3],
    /// Friction.
    pub friction: f32,
    /// Elasticity.
    pub elasticity: f32,
    /// Contact plane (normal, distance), cell, water.
    pub contact: Option<([f32; 4], u32, bool)>,
    /// Sliding normal.
    pub sliding_normal: [f32; 3],
    /// Velocity over the last quantum.
    pub cached_velocity: [f32; 3],
    /// Velocity has been set since the last quantum.
    pub jumped_this_frame: bool,
    /// Clock.
    pub update_time: f64,
    /// Target of a missile.
    pub target: Option<BodyId>,
    /// Legs.
    pub locomotion: Option<Locomotion>,
    /// Cells that name it.
    pub shadow_cells: Vec<u32>,
    /// What it touches.
    pub touching: Vec<BodyId>,
    /// It is pressed against its surroundings.
    pub colliding_with_environment: bool,
    /// What it is attached to, and its frame there.
    pub parent: Option<(BodyId, SavedPosition)>,
    /// What is attached to it.
    pub children: Vec<BodyId>,
}

/// A population: bodies under their ids and the order in which they entered each cell.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedPopulation {
    /// Settings of sweeps.
    pub settings: Settings,
    /// Generation and body of each slot.
    pub slots: Vec<(u32, Option<SavedBody>)>,
    /// Slots to use next, last first.
    pub free: Vec<u32>,
    /// Cell id, bodies in it, bodies that reach into it; ascending by cell.
    pub cells: Vec<(u32, Vec<BodyId>, Vec<BodyId>)>,
    /// Whom the others rest far from.
    pub observer: Option<BodyId>,
}

impl Body {
    /// The whole state of the body.
    pub fn save(&self) -> SavedBody {
        let own = self.shape().id == 0;
        let spheres = if own { &self.shape().spheres[..] } else { &[] };
        SavedBody {
            shape: self.shape().id,
            spheres: spheres
                .iter()
                .map(|s| [s.center.x, s.center.y, s.center.z, s.radius])
                .collect(),
            scale: self.scale(),
            position: self.position().into(),
            cell: self.cell.map(|c| c.0),
            state: self.state,
            transient: self.transient,
            kind: self.kind,
            velocity: self.velocity.to_array(),
            acceleration: self.acceleration.to_array(),
            omega: self.omega.to_array(),
            friction: self.friction,
            elasticity: self.elasticity(),
            contact: self.contact.map(|c| {
                let n = c.plane.normal;
                ([n.x, n.y, n.z, c.plane.d], c.cell.0, c.is_water)
            }),
            sliding_normal: self.sliding_normal.to_array(),
            cached_velocity: self.cached_velocity.to_array(),
            jumped_this_frame: self.jumped_this_frame,
            update_time: self.update_time,
            target: self.target,
            locomotion: self.locomotion,
            shadow_cells: self.shadow_cells.iter().map(|c| c.0).collect(),
            touching: self
                .touching
                .iter()
                .filter_map(|t| {
                    if let ObjectRef::Body(id) = t {
                        Some(*id)
                    } else {
                        None
                    }
                })
                .collect(),
            colliding_with_environment: self.colliding_with_environment,
            parent: self.parent.map(|id| {
                let at = Position {
                    cell: CellId::NONE,
                    frame: self.attached,
                };
                (id, (&at).into())
            }),
            children: self.children.clone(),
        }
    }

    /// A body as it was saved. `shapes` finds the shape of a record, as [`vestibule_world::World::shape`] does.
    ///
    /// # Errors
    /// The shape is not to be had, or the scale is unusable.
    pub fn restore(
        saved: &SavedBody,
        shapes: impl Fn(u32) -> Option<Arc<Shape>>,
    ) -> Result<Self, SweepError> {
        let shape = if saved.shape == 0 {
            let spheres: Vec<Sphere> = saved
                .spheres
                .iter()
                .map(|&[x, y, z, r]| Sphere::new(Vec3::new(x, y, z), r))
                .collect();
            Arc::new(sphere_shape(&spheres))
        } else {
            shapes(saved.shape).ok_or(SweepError::NoShape { id: saved.shape })?
        };
        let mut body = Body::new(shape, saved.scale)?;
        let position = Position::from(&saved.position);
        if !position.is_finite() {
            return Err(SweepError::NotFinite {
                what: "saved position",
            });
        }
        body.position.cell = position.cell;
        body.set_frame(position.frame);
        body.cell = saved.cell.map(CellId);
        body.state = saved.state;
        body.transient = saved.transient;
        body.kind = saved.kind;
        body.velocity = Vec3::from_array(saved.velocity);
        body.acceleration = Vec3::from_array(saved.acceleration);
        body.omega = Vec3::from_array(saved.omega);
        body.friction = saved.friction;
        body.set_elasticity(saved.elasticity);
        body.contact = saved.contact.map(|([x, y, z, d], cell, is_water)| ContactPlane {
            plane: Plane {
                normal: Vec3::new(x, y, z),
                d,
            },
            cell: CellId(cell),
            is_water,
        });
        body.sliding_normal = Vec3::from_array(saved.sliding_normal);
        body.cached_velocity = Vec3::from_array(saved.cached_velocity);
        body.jumped_this_frame = saved.jumped_this_frame;
        body.update_time = saved.update_time;
        body.target = saved.target;
        body.locomotion = saved.locomotion;
        body.shadow_cells = saved.shadow_cells.iter().map(|&c| CellId(c)).collect();
        body.touching = saved.touching.iter().map(|&id| ObjectRef::Body(id)).collect();
        body.colliding_with_environment = saved.colliding_with_environment;
        if let Some((id, at)) = &saved.parent {
            body.parent = Some(*id);
            body.attached = Position::from(at).frame;
        }
        body.children = saved.children.clone();
        Ok(body)
    }
}

impl Population {
    /// All bodies and lists. Restrictions are the caller's and are not saved.
    pub fn save(&self) -> SavedPopulation {
        let mut cells: Vec<_> = self
            .cells
            .iter()
            .filter(|(_, lists)| !lists.objects.is_empty() || !lists.shadows.is_empty())
            .map(|(cell, lists)| (cell.0, lists.objects.clone(), lists.shadows.clone()))
            .collect();
        cells.sort_by_key(|&(cell, ..)| cell);
        SavedPopulation {
            settings: self.settings,
            slots: self
                .slots
                .iter()
                .map(|s| (s.generation, s.body.as_ref().map(|b| b.save())))
                .collect(),
            free: self.free.clone(),
            cells,
            observer: self.observer,
        }
    }

    /// A population as it was saved. `shapes` finds the shape of a record.
    ///
    /// # Errors
    /// As [`Body::restore`].
    pub fn restore(
        saved: &SavedPopulation,
        shapes: impl Fn(u32) -> Option<Arc<Shape>>,
    ) -> Result<Self, SweepError> {
        let mut population = Population::with_settings(saved.settings);
        for (generation, body) in &saved.slots {
            let body = body.as_ref().map(|b| Body::restore(b, &shapes)).transpose()?;
            population.slots.push(Slot {
                generation: *generation,
                body: body.map(Box::new),
            });
        }
        population.free = saved
            .free
            .iter()
            .copied()
            .filter(|&i| (i as usize) < saved.slots.len())
            .collect();
        for (cell, objects, shadows) in &saved.cells {
            let lists = CellLists {
                objects: objects.clone(),
                shadows: shadows.clone(),
            };
            population.cells.insert(CellId(*cell), lists);
        }
        population.observer = saved.observer;
        Ok(population)
    }
}
