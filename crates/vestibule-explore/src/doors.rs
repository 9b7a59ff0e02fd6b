//! Doors to open and close. Worlds come with their doors standing open, as static objects; closing one puts a body in
//! its opening and hides the static one. The hidden leaf is no longer drawn, but it is still bumped into where it stood:
//! static objects cannot be taken out of a world.

use glam::{Quat, Vec3};
use vestibule_physics::{Body, BodyId, ObjectRef, Population, Scratch};
use vestibule_world::{Frame, Position, StaticObject, StaticRef, World};

/// Farthest door that can be reached, metres.
const REACH: f32 = 3.0;

/// The doors that were closed at some time.
#[derive(Debug, Default)]
pub struct Doors {
    list: Vec<Door>,
}

#[derive(Debug)]
struct Door {
    leaf: StaticRef,
    body: BodyId,
    closed: bool,
}

/// What became of a door.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DoorOutcome {
    /// It is closed now.
    Closed,
    /// It is open now.
    Opened,
    /// Something stands in the way.
    Blocked,
    /// There is none within reach.
    None,
}

impl Doors {
    /// Whether an object is not drawn: the static leaf of a closed door, the body of an open one.
    pub fn hides(&self, id: ObjectRef) -> bool {
        self.list.iter().any(|d| match id {
            ObjectRef::Static(r) => d.closed && d.leaf == r,
            ObjectRef::Body(b) => !d.closed && d.body == b,
        })
    }

    /// Whether the nearest door within reach of a position is closed; `None` without one.
    pub fn within_reach(&self, world: &World, at: &Position) -> Option<bool> {
        let (id, ..) = nearest(world, at)?;
        Some(self.list.iter().any(|d| d.leaf == id && d.closed))
    }

    /// Opens or closes the nearest door within reach of a position.
    pub fn toggle(
        &mut self,
        world: &World,
        population: &mut Population,
        scratch: &mut Scratch,
        at: &Position,
    ) -> DoorOutcome {
        let Some((id, object, frame)) = nearest(world, at) else {
            return DoorOutcome::None;
        };
        if let Some(door) = self.list.iter_mut().find(|d| d.leaf == id) {
            if door.closed {
                population.set_ethereal(world, scratch, door.body, true);
                door.closed = false;
                return DoorOutcome::Opened;
            }
            door.closed = population.set_ethereal(world, scratch, door.body, false);
            if !door.closed {
                // It is not to fall shut by itself later.
                population.set_ethereal(world, scratch, door.body, true);
                return DoorOutcome::Blocked;
            }
            return DoorOutcome::Closed;
        }
        let Ok(body) = Body::new(object.shape.clone(), 1.0) else {
            return DoorOutcome::None;
        };
        let body = population.add(body);
        let position = Position {
            cell: object.cell,
            frame,
        };
        // Ethereal until it is seen that nobody stands in it (`transition.md` 9.3.1).
        population.set_ethereal(world, scratch, body, true);
        population.force_into_cell(world, scratch, body, &position);
        let closed = population.set_ethereal(world, scratch, body, false);
        if !closed {
            population.set_ethereal(world, scratch, body, true);
        }
        self.list.push(Door {
            leaf: id,
            body,
            closed,
        });
        if closed {
            DoorOutcome::Closed
        } else {
            DoorOutcome::Blocked
        }
    }
}

/// The nearest door, and where it is when closed.
fn nearest<'w>(world: &'w World, at: &Position) -> Option<(StaticRef, &'w StaticObject, Frame)> {
    let block = world.block(at.cell.block())?;
    let mut best: Option<(f32, StaticRef, &StaticObject, Frame)> = None;
    for (index, object) in block.statics.iter().enumerate() {
        if (object.frame.origin - at.origin()).length() > 2.0 * REACH {
            continue;
        }
        let (Some(middle), Some(frame)) = (leaf(object), closed(world, object)) else {
            continue;
        };
        // Who stands before an open door reaches for its doorway, who stands beside it for the leaf.
        let far = [object.frame, frame].map(|f| {
            let gap = f.local_to_global(middle) - at.origin();
            Vec3::new(gap.x, gap.y, gap.z * 0.5).length()
        });
        let far = if far[0] < far[1] { far[0] } else { far[1] };
        if far > REACH || best.as_ref().is_some_and(|b| b.0 <= far) {
            continue;
        }
        let id = StaticRef {
            block: block.id,
            index: index as u32,
        };
        best = Some((far, id, object, frame));
    }
    best.map(|(_, id, object, frame)| (id, object, frame))
}

/// The middle of an object's model when it is the leaf of a door: as high as a person, as wide as a doorway, thin, and
/// hung at one side.
fn leaf(object: &StaticObject) -> Option<Vec3> {
    let [part] = &*object.shape.parts else { return None };
    let bounds = part.model.as_ref()?.bounds;
    let size = (bounds.max - bounds.min) * part.scale;
    let (thin, wide) = if size.x < size.y {
        (size.x, size.y)
    } else {
        (size.y, size.x)
    };
    let middle = (bounds.min + bounds.max) * 0.5 * part.scale;
    let hung = middle.truncate().length() > wide * 0.4;
    let like = size.z > 1.7 && size.z < 4.0 && wide > 0.8 && wide < 2.6 && thin < 0.3;
    (like && hung).then_some(middle)
}

/// The frame of a door turned about its hinge into the nearest opening of its cell.
fn closed(world: &World, object: &StaticObject) -> Option<Frame> {
    let local = leaf(object)?;
    let cell = world.env_cell(object.cell)?;
    let hinge = object.frame.origin;
    let mut best: Option<(f32, Vec3)> = None;
    for portal in &cell.portals {
        let corners = cell.portal_vertices(portal);
        let sum: Vec3 = corners.iter().copied().sum();
        let middle = cell.frame.local_to_global(sum / corners.len().max(1) as f32);
        let gap = (middle - hinge).truncate();
        if gap.length() > 2.0 || best.is_some_and(|b| b.0 <= gap.length()) {
            continue;
        }
        let normal = cell.frame.local_to_global_vec(portal.plane.normal);
        let level = Vec3::new(normal.x, normal.y, 0.0);
        if level.length() < 0.7 {
            continue;
        }
        let level = level.normalize();
        let toward = gap.extend(0.0);
        let along = toward - level * level.dot(toward);
        if along.length() > 0.1 {
            best = Some((gap.length(), along));
        }
    }
    let along = best?.1;
    let turn = libm::atan2f(along.y, along.x) - libm::atan2f(local.y, local.x);
    Some(Frame::new(hinge, Quat::from_rotation_z(turn)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hollow;
    use vestibule_world::CellId;

    #[test]
    fn the_cottage_door_closes_and_opens() {
        let (world, _) = hollow();
        let (mut population, mut scratch) = (Population::new(), Scratch::new());
        let mut doors = Doors::default();
        let at = Position::new(CellId(0xA9B4_0101), Vec3::new(155.4, 13.0, 94.0));
        let mut toggle = |at: &Position| doors.toggle(&world, &mut population, &mut scratch, at);
        assert_eq!(toggle(&at), DoorOutcome::Closed);
        assert_eq!(toggle(&at), DoorOutcome::Opened);
        let outside = Position::new(CellId(0xA9B4_0031), Vec3::new(155.4, 17.5, 94.0));
        assert_eq!(toggle(&outside), DoorOutcome::Closed, "from the doorstep");
        assert_eq!(toggle(&outside), DoorOutcome::Opened);
        let far = Position::new(CellId(0xA9B4_0001), Vec3::new(5.0, 5.0, 94.0));
        assert_eq!(toggle(&far), DoorOutcome::None);
    }
}
