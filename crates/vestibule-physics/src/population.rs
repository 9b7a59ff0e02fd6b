//! Bodies, and the lists of what is in which cell (`transition.md` 9.1, `world.md` 14).

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::Arc;

use vestibule_world::{
    CellArray, CellId, Frame, PartBounds, Position, Sphere, World, find_bbox_cell_list, find_cell_list,
    find_cell_list_of_cylspheres,
};

use crate::body::{Body, GroundChange};
use crate::error::SweepError;
use crate::flags::{ObjectKind, PhysicsState, TransientState};
use crate::obj_collisions::{ObjectRef, Target};
use crate::settings::Settings;
use crate::sweep::{Mover, Scratch, Swept, sweep};

/// Names a body of a [`Population`]. Ids of bodies that were removed are not used again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyId {
    pub(crate) index: u32,
    pub(crate) generation: u32,
}

/// Decides who may enter restricted cells (`transition.md` 7.5, `world.md` 19).
pub trait EntryRestrictions: core::fmt::Debug + Send + Sync {
    /// Whether the player `body` may be in `cell`, which the object with id `object` watches over.
    fn may_enter(&self, body: Option<BodyId>, cell: CellId, object: u32) -> bool;
}

/// What happened to a body, in order. Read them from [`Scratch::events`] after a call that moves bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Left one cell for another; `None` stands for nowhere.
    ChangedCell {
        /// Who.
        body: BodyId,
        /// The cell it was in.
        from: Option<CellId>,
        /// The cell it is in.
        to: Option<CellId>,
    },
    /// Came onto walkable ground.
    HitGround {
        /// Who.
        body: BodyId,
    },
    /// Left walkable ground.
    LeftGround {
        /// Who.
        body: BodyId,
    },
    /// Ran into the surroundings or a static object.
    HitEnvironment {
        /// Who.
        body: BodyId,
    },
    /// Began to touch another body.
    HitObject {
        /// Who.
        body: BodyId,
        /// What it touches.
        other: BodyId,
    },
    /// Stopped touching another body.
    EndedTouch {
        /// Who.
        body: BodyId,
        /// What it touched.
        other: BodyId,
    },
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Slot {
    pub(crate) generation: u32,
    pub(crate) body: Option<Box<Body>>,
}

/// What is in a cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellLists {
    /// Bodies whose cell this is, in order of entry.
    pub(crate) objects: Vec<BodyId>,
    /// Bodies that reach into the cell, in order of entry.
    pub(crate) shadows: Vec<BodyId>,
}

/// Cell ids are spread well enough by a multiplication.
#[derive(Clone, Default)]
pub(crate) struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.write_u32(u32::from(b));
        }
    }

    fn write_u32(&mut self, id: u32) {
        self.0 = (self.0 ^ u64::from(id))
            .wrapping_mul(0x9E37_79B9_7F4A_7C15)
            .rotate_left(26);
    }
}

pub(crate) type CellMap = HashMap<CellId, CellLists, BuildHasherDefault<CellHasher>>;

/// Bodies and which of them are in which cell. Sweeps only read it; [`Population::commit`] and the calls built on
/// it write. Iteration is by age of the slot or by order of entry, never by hash.
#[derive(Clone, Debug, Default)]
pub struct Population {
    pub(crate) settings: Settings,
    pub(crate) slots: Vec<Slot>,
    pub(crate) free: Vec<u32>,
    pub(crate) cells: CellMap,
    pub(crate) restrictions: Option<Arc<dyn EntryRestrictions>>,
    /// Bodies far from this one are not integrated (`transition.md` 9.8).
    pub(crate) observer: Option<BodyId>,
}

impl Population {
    /// No bodies, retail settings.
    pub fn new() -> Self {
        Self::default()
    }

    /// No bodies, and sweeps that differ from retail.
    pub fn with_settings(settings: Settings) -> Self {
        Population {
            settings,
            ..Self::default()
        }
    }

    /// The settings of sweeps.
    #[inline]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Changes the settings of sweeps.
    pub fn set_settings(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Asks `restrictions` who may enter restricted cells; without, everyone may.
    pub fn set_restrictions(&mut self, restrictions: Option<Arc<dyn EntryRestrictions>>) {
        self.restrictions = restrictions;
    }

    /// Bodies more than 96 m from `observer` rest; without one, none does (`transition.md` 9.8).
    pub fn set_observer(&mut self, observer: Option<BodyId>) {
        self.observer = observer;
    }

    /// Adds a body, which is nowhere until it is placed: see [`Population::set_position`].
    pub fn add(&mut self, body: Body) -> BodyId {
        let index = self.free.pop().unwrap_or_else(|| {
            self.slots.push(Slot::default());
            (self.slots.len() - 1) as u32
        });
        let slot = &mut self.slots[index as usize];
        slot.body = Some(Box::new(body));
        BodyId {
            index,
            generation: slot.generation,
        }
    }

    /// Takes a body out of the world and of the population. What was attached to it is detached.
    pub fn remove(&mut self, id: BodyId) -> Option<Body> {
        self.body(id)?;
        self.detach(id);
        for child in self.body(id).map(|b| b.children.clone()).unwrap_or_default() {
            self.detach(child);
        }
        self.leave_world(id);
        let slot = self.slots.get_mut(id.index as usize)?;
        let body = slot.body.take()?;
        slot.generation = slot.generation.wrapping_add(1);
        self.free.push(id.index);
        Some(*body)
    }

    /// The body with this id.
    #[inline]
    pub fn body(&self, id: BodyId) -> Option<&Body> {
        let slot = self.slots.get(id.index as usize)?;
        if slot.generation == id.generation {
            slot.body.as_deref()
        } else {
            None
        }
    }

    /// The body with this id, to change what it is or how it moves.
    #[inline]
    pub fn body_mut(&mut self, id: BodyId) -> Option<&mut Body> {
        let slot = self.slots.get_mut(id.index as usize)?;
        if slot.generation == id.generation {
            slot.body.as_deref_mut()
        } else {
            None
        }
    }

    /// All bodies with their ids.
    pub fn bodies(&self) -> impl Iterator<Item = (BodyId, &Body)> {
        self.slots.iter().zip(0u32..).filter_map(|(slot, index)| {
            slot.body.as_deref().map(|body| {
                (
                    BodyId {
                        index,
                        generation: slot.generation,
                    },
                    body,
                )
            })
        })
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.slots.len() - self.free.len()
    }

    /// Whether there may be a body.
    #[inline(always)]
    pub(crate) fn has_bodies(&self) -> bool {
        !self.slots.is_empty()
    }

    /// Whether no body but `body` reaches into a cell.
    pub(crate) fn is_alone_in(&self, cell: CellId, body: Option<BodyId>) -> bool {
        self.shadows_in(cell).iter().all(|&id| Some(id) == body)
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The bodies whose cell this is, in order of entry.
    pub fn objects_in(&self, cell: CellId) -> &[BodyId] {
        self.cells.get(&cell).map_or(&[], |lists| &lists.objects)
    }

    /// The bodies that reach into a cell, in order of entry: its shadow list (`world.md` 14).
    #[inline]
    pub fn shadows_in(&self, cell: CellId) -> &[BodyId] {
        if self.cells.is_empty() {
            return &[];
        }
        self.cells.get(&cell).map_or(&[], |lists| &lists.shadows)
    }

    /// A body as others run into it; attached ones are not run into.
    #[inline]
    pub(crate) fn target(&self, id: BodyId) -> Option<Target<'_>> {
        let body = self.body(id)?;
        if body.parent.is_some() {
            return None;
        }
        Some(Target {
            object: ObjectRef::Body(id),
            cell: body.position.cell,
            frame: &body.position.frame,
            scale: body.scale(),
            state: body.state,
            kind: body.kind,
            shape: body.shape(),
            part_frames: &body.part_frames,
        })
    }

    pub(crate) fn may_enter(&self, body: Option<BodyId>, cell: CellId, object: u32) -> bool {
        self.restrictions
            .as_ref()
            .is_none_or(|r| r.may_enter(body, cell, object))
    }

    /// Sweeps a body to a position, without moving it.
    ///
    /// # Errors
    /// No such body, a position that is not finite, or a move of too many steps.
    pub fn sweep(
        &self,
        world: &World,
        scratch: &mut Scratch,
        id: BodyId,
        to: &Position,
    ) -> Result<Swept, SweepError> {
        let body = self.body(id).ok_or(SweepError::NoSuchBody)?;
        let mut from = body.position;
        from.cell = body.cell.unwrap_or(CellId::NONE);
        let to = Position {
            cell: to.cell,
            frame: to.frame,
        };
        if from.cell.is_none() {
            // In no cell: the sweep cannot start (`transition.md` I10).
            return sweep(
                world,
                self,
                scratch,
                &body.mover(Some(id)),
                &body.carried(),
                &from,
                &from,
            );
        }
        sweep(
            world,
            self,
            scratch,
            &body.mover(Some(id)),
            &body.carried(),
            &from,
            &to,
        )
    }

    /// Sweeps a body to a position and, when the sweep is ok, moves it there.
    ///
    /// # Errors
    /// As [`Population::sweep`]; the body is then unchanged.
    pub fn move_to(
        &mut self,
        world: &World,
        scratch: &mut Scratch,
        id: BodyId,
        to: &Position,
    ) -> Result<Swept, SweepError> {
        let swept = self.sweep(world, scratch, id, to)?;
        scratch.events.clear();
        if swept.ok {
            self.commit(world, scratch, id, &swept);
        }
        Ok(swept)
    }

    /// Writes what a sweep found into the body: place, cell, contact, bounce, and the lists of who is where
    /// (retail `SetPositionInternal`, `transition.md` 9.1). `scratch` must be the one of that sweep. Returns
    /// whether a collision was reported.
    pub fn commit(&mut self, world: &World, scratch: &mut Scratch, id: BodyId, swept: &Swept) -> bool {
        let Some(body) = self.body_mut(id) else {
            return false;
        };
        let now = body.update_time;
        if swept.velocity_killed {
            body.velocity = glam::Vec3::ZERO;
        }
        let prev_on_walkable = body.is_on_walkable();
        let Some(new_cell) = swept.cell else {
            let mut lost = swept.position;
            if !lost.cell.is_indoor() {
                lost = lost.adjusted_to_outside().unwrap_or(lost);
            }
            self.lose(id, &lost, scratch);
            return false;
        };
        if body.cell == Some(new_cell) {
            body.position.cell = swept.position.cell;
        } else {
            self.change_cell(id, Some(new_cell), scratch);
        }
        let Some(body) = self.body_mut(id) else {
            return false;
        };
        body.set_frame(swept.position.frame);
        match body.take_contact(swept, now) {
            GroundChange::None => {}
            GroundChange::Hit => scratch.events.push(Event::HitGround { body: id }),
            GroundChange::Left => scratch.events.push(Event::LeftGround { body: id }),
        }
        let reported = self.handle_all_collisions(scratch, id, swept, prev_on_walkable);
        let Some(body) = self.body(id) else {
            return reported;
        };
        if body.state.has(PhysicsState::HAS_PHYSICS_BSP) {
            self.calc_cross_cells(world, id, scratch);
        } else if !scratch.cell_array.is_empty() {
            self.set_shadows(id, &scratch.cell_array);
        }
        self.move_children(id);
        reported
    }

    /// Reports what the sweep ran into, and bounces (retail `handle_all_collisions`, `transition.md` 9.2).
    pub(crate) fn handle_all_collisions(
        &mut self,
        scratch: &mut Scratch,
        id: BodyId,
        swept: &Swept,
        prev_on_walkable: bool,
    ) -> bool {
        let mut reported = false;
        for i in 0..scratch.touched.len() {
            let object = scratch.touched[i].object;
            reported |= match object {
                ObjectRef::Static(_) => self.report_environment_collision(scratch, id),
                ObjectRef::Body(other) => self.track_object_collision(scratch, id, other),
            };
        }
        self.end_touches(scratch, id);
        let Some(body) = self.body_mut(id) else {
            return reported;
        };
        let landed = !prev_on_walkable && body.is_on_walkable();
        if body.colliding_with_environment {
            body.colliding_with_environment = swept.collided_with_environment;
        } else if swept.collided_with_environment || landed {
            reported |= self.report_environment_collision(scratch, id);
        }
        if let Some(body) = self.body_mut(id) {
            body.bounce(swept, prev_on_walkable);
        }
        reported
    }

    fn report_environment_collision(&mut self, scratch: &mut Scratch, id: BodyId) -> bool {
        let Some(body) = self.body_mut(id) else {
            return false;
        };
        if body.colliding_with_environment {
            return false;
        }
        body.colliding_with_environment = true;
        body.strip_missile();
        let reports =
            body.state.has(PhysicsState::REPORT_COLLISIONS) && body.kind.has(ObjectKind::HAS_GAME_OBJECT);
        if reports {
            scratch.events.push(Event::HitEnvironment { body: id });
        }
        reports
    }

    /// A touch is reported when it begins, in both directions.
    fn track_object_collision(&mut self, scratch: &mut Scratch, id: BodyId, other: BodyId) -> bool {
        let Some(target) = self.body(other) else {
            return false;
        };
        let target_state = target.state;
        if target_state.has(PhysicsState::STATIC)
            || target_state.has(PhysicsState::REPORT_COLLISIONS_AS_ENVIRONMENT)
        {
            return self.report_environment_collision(scratch, id);
        }
        let Some(body) = self.body_mut(id) else {
            return false;
        };
        if !target_state.has(PhysicsState::IGNORE_COLLISIONS) {
            body.strip_missile();
        }
        let known = body.touching.contains(&ObjectRef::Body(other));
        if known {
            return false;
        }
        body.touching.push(ObjectRef::Body(other));
        let both = [(id, other), (other, id)];
        let mut reported = false;
        for (who, what) in both {
            let reports = self.body(who).is_some_and(|b| {
                b.state.has(PhysicsState::REPORT_COLLISIONS) && b.kind.has(ObjectKind::HAS_GAME_OBJECT)
            });
            if reports {
                scratch.events.push(Event::HitObject {
                    body: who,
                    other: what,
                });
                reported |= who == id;
            }
        }
        reported
    }

    /// Touches that the last move did not refresh are over.
    fn end_touches(&mut self, scratch: &mut Scratch, id: BodyId) {
        let Some(body) = self.body_mut(id) else { return };
        let (touched, events) = (&scratch.touched, &mut scratch.events);
        body.touching.retain(|object| {
            let still = touched.iter().any(|t| t.object == *object);
            if let (false, ObjectRef::Body(other)) = (still, *object) {
                events.push(Event::EndedTouch { body: id, other });
            }
            still
        });
    }

    /// The body is in no cell any more: it keeps its position and waits (`world.md` Z1).
    pub(crate) fn lose(&mut self, id: BodyId, at: &Position, scratch: &mut Scratch) {
        self.remove_shadows(id);
        self.change_cell(id, None, scratch);
        if let Some(body) = self.body_mut(id) {
            body.position.cell = at.cell;
            body.set_frame(at.frame);
            body.transient.set(TransientState::ACTIVE, false);
        }
    }

    /// Takes a body out of its cell and all shadow lists; it keeps its position.
    pub fn leave_world(&mut self, id: BodyId) {
        self.remove_shadows(id);
        let mut scratch = Scratch::default();
        self.change_cell(id, None, &mut scratch);
    }

    /// The bodies that left the known world, with the cell id each waits for (`world.md` Z1). When that cell
    /// becomes resident, place them again with [`Population::set_position`].
    pub fn lost(&self) -> impl Iterator<Item = (BodyId, CellId)> {
        self.bodies()
            .filter(|(_, body)| body.cell.is_none() && !body.position.cell.is_none() && body.parent.is_none())
            .map(|(id, body)| (id, body.position.cell))
    }

    /// Leaves the old cell and enters the new one, with what is attached (`transition.md` 9.1).
    pub(crate) fn change_cell(&mut self, id: BodyId, to: Option<CellId>, scratch: &mut Scratch) {
        let Some(body) = self.body_mut(id) else { return };
        let from = body.cell;
        body.cell = to;
        body.position.cell = to.unwrap_or(body.position.cell);
        if from == to {
            return;
        }
        if let Some(from) = from {
            self.edit_lists(from, |lists| lists.objects.retain(|&other| other != id));
        }
        if let Some(to) = to {
            self.cells.entry(to).or_default().objects.push(id);
        }
        scratch.events.push(Event::ChangedCell { body: id, from, to });
        let count = self.body(id).map_or(0, |body| body.children.len());
        for i in 0..count {
            if let Some(&child) = self.body(id).and_then(|body| body.children.get(i)) {
                self.change_cell(child, to, scratch);
            }
        }
    }

    /// Changes a cell's lists. Empty ones are kept: bodies come back.
    fn edit_lists(&mut self, cell: CellId, edit: impl FnOnce(&mut CellLists)) {
        if let Some(lists) = self.cells.get_mut(&cell) {
            edit(lists);
        }
    }

    fn remove_shadows(&mut self, id: BodyId) {
        let Some(body) = self.body_mut(id) else { return };
        let cells = core::mem::take(&mut body.shadow_cells);
        for &cell in &cells {
            self.edit_lists(cell, |lists| lists.shadows.retain(|&other| other != id));
        }
        // Keep the memory.
        if let Some(body) = self.body_mut(id) {
            body.shadow_cells = cells;
            body.shadow_cells.clear();
        }
    }

    /// The body reaches into the cells of `array`, and no others.
    pub(crate) fn set_shadows(&mut self, id: BodyId, array: &CellArray) {
        let Some(body) = self.body(id) else { return };
        let unchanged = body.shadow_cells.len() == array.len()
            && body
                .shadow_cells
                .iter()
                .zip(array.entries())
                .all(|(a, b)| *a == b.id);
        if body.parent.is_some() {
            return;
        }
        if unchanged {
            // Retail takes the body off every list and adds it again, so it moves to the end.
            for i in 0..array.len() {
                let Some(entry) = array.get(i) else { continue };
                if let Some(lists) = self.cells.get_mut(&entry.id)
                    && lists.shadows.last() != Some(&id)
                {
                    lists.shadows.retain(|&other| other != id);
                    lists.shadows.push(id);
                }
            }
            return;
        }
        self.remove_shadows(id);
        for entry in array.entries() {
            self.cells.entry(entry.id).or_default().shadows.push(id);
        }
        if let Some(body) = self.body_mut(id) {
            body.shadow_cells.extend(array.entries().iter().map(|e| e.id));
        }
    }

    /// The cells a body reaches by its own geometry (retail `calc_cross_cells`, `world.md` H1).
    pub(crate) fn calc_cross_cells(&mut self, world: &World, id: BodyId, scratch: &mut Scratch) {
        let Some(body) = self.body(id) else { return };
        let shape = body.shape();
        let array = &mut scratch.cell_array;
        array.do_not_load_cells = false;
        let position = body.position;
        if body.state.has(PhysicsState::HAS_PHYSICS_BSP) {
            let placed = shape.parts.iter().zip(&body.part_frames);
            let parts: Vec<PartBounds> = placed
                .filter_map(|(part, frame)| {
                    let model = part.model.as_ref()?;
                    Some(PartBounds {
                        frame: *frame,
                        sphere: model.cell_sphere(),
                        bounds: model.bounds,
                    })
                })
                .collect();
            find_bbox_cell_list(world, position.cell, &parts, array);
        } else if !shape.cylspheres.is_empty() {
            find_cell_list_of_cylspheres(world, &position, &shape.cylspheres, array);
        } else {
            let s = shape.sorting_sphere;
            let s = Sphere::new(position.frame.local_to_global(s.center), s.radius);
            find_cell_list(world, position.cell, position.origin(), &[s], array, false);
        }
        self.set_shadows(id, &scratch.cell_array);
    }

    /// Puts a body somewhere without asking whether there is room: doors, corpses, storage (retail
    /// `ForceIntoCell`, `world.md` 16.3b). `false` when there is no such body or its cell is not resident; the
    /// body then waits there as a lost one.
    pub fn force_into_cell(
        &mut self,
        world: &World,
        scratch: &mut Scratch,
        id: BodyId,
        at: &Position,
    ) -> bool {
        scratch.events.clear();
        if self.body(id).is_none() || !at.is_finite() {
            return false;
        }
        if !world.is_resident(at.cell) {
            self.lose(id, at, scratch);
            return false;
        }
        self.change_cell(id, Some(at.cell), scratch);
        if let Some(body) = self.body_mut(id) {
            body.set_frame(at.frame);
        }
        self.calc_cross_cells(world, id, scratch);
        self.move_children(id);
        true
    }

    /// Attaches a body to another: it follows, at `frame` in the parent's, and is not run into.
    pub fn attach(&mut self, child: BodyId, parent: BodyId, frame: Frame) -> bool {
        let ancestor_is_child = core::iter::successors(Some(parent), |&id| self.body(id)?.parent);
        if ancestor_is_child.take(self.slots.len() + 1).any(|id| id == child) || self.body(parent).is_none() {
            return false;
        }
        self.detach(child);
        self.remove_shadows(child);
        let Some(body) = self.body_mut(child) else {
            return false;
        };
        body.parent = Some(parent);
        body.attached = frame;
        if let Some(body) = self.body_mut(parent) {
            body.children.push(child);
        }
        let cell = self.body(parent).and_then(|b| b.cell);
        let mut scratch = Scratch::default();
        self.change_cell(child, cell, &mut scratch);
        self.move_children(parent);
        true
    }

    /// Detaches a body from its parent. It stays where it is, in its parent's cell.
    pub fn detach(&mut self, child: BodyId) {
        let Some(parent) = self.body_mut(child).and_then(|body| body.parent.take()) else {
            return;
        };
        if let Some(body) = self.body_mut(parent) {
            body.children.retain(|&other| other != child);
        }
    }

    pub(crate) fn move_children(&mut self, id: BodyId) {
        let Some(body) = self.body(id) else { return };
        let (position, count) = (body.position, body.children.len());
        for i in 0..count {
            let Some(&child) = self.body(id).and_then(|body| body.children.get(i)) else {
                continue;
            };
            if let Some(body) = self.body_mut(child) {
                body.position.cell = position.cell;
                let frame = position.frame.combine(&body.attached);
                body.set_frame(frame);
            }
            self.move_children(child);
        }
    }

    /// Opens a body for others to pass, or closes it again: doors. A door closes only once nothing is in it; it
    /// tries again in every [`Population::update`] (`transition.md` 9.3.1). Returns whether it is now in the
    /// state asked for.
    pub fn set_ethereal(&mut self, world: &World, scratch: &mut Scratch, id: BodyId, ethereal: bool) -> bool {
        let Some(body) = self.body_mut(id) else {
            return false;
        };
        if ethereal {
            body.state.set(PhysicsState::ETHEREAL, true);
            body.transient.set(TransientState::CHECK_ETHEREAL, false);
            return true;
        }
        self.try_end_ethereal(world, scratch, id)
    }

    /// Ends being ethereal if no body of the cells it reaches overlaps it.
    pub(crate) fn try_end_ethereal(&mut self, world: &World, scratch: &mut Scratch, id: BodyId) -> bool {
        let Some(body) = self.body_mut(id) else {
            return false;
        };
        body.state.set(PhysicsState::ETHEREAL, false);
        let free = !self.is_obstructed(world, scratch, id);
        if let Some(body) = self.body_mut(id) {
            body.state.set(PhysicsState::ETHEREAL, !free);
            body.transient.set(TransientState::CHECK_ETHEREAL, !free);
        }
        free
    }

    /// Whether a body overlaps this one (retail `check_collision` of each object in its cells).
    fn is_obstructed(&self, world: &World, scratch: &mut Scratch, id: BodyId) -> bool {
        let Some(body) = self.body(id) else { return false };
        let others = body.shadow_cells.iter().flat_map(|&cell| self.shadows_in(cell));
        for &other in others {
            let Some(target) = self.target(id) else {
                return false;
            };
            if other != id && self.overlaps(world, scratch, other, &target) {
                return true;
            }
        }
        false
    }

    fn overlaps(&self, world: &World, scratch: &mut Scratch, other: BodyId, target: &Target<'_>) -> bool {
        let Some(body) = self.body(other) else {
            return false;
        };
        if body.parent.is_some() || body.cell.is_none() {
            return false;
        }
        let mover: Mover = body.mover(Some(other));
        crate::sweep::overlaps(world, self, scratch, &mover, &body.position, target)
    }
}
