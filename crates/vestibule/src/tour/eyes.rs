//! What the chase camera sees on a tour: the viewer's cell and the draw list of every tick.

use std::collections::BTreeMap;

use glam::{Quat, Vec2, Vec3};
use serde::Serialize;
use vestibule_physics::{Population, Scratch};
use vestibule_view::{
    CameraRig, ChaseCamera, Command, FrameView, Openings, PlayerCell, ViewerTarget, WorldObjects,
    retail_fov_y,
};
use vestibule_world::{CellId, Frame, Position, World};

use crate::walker::{Footing, TICK};

/// Size of the screen that draw lists are made for, pixels.
const SCREEN: Vec2 = Vec2::new(640.0, 480.0);
/// How fast the player turns to where it walks, radians a second.
const TURN_RATE: f32 = 3.0;

/// What a tick's frame draws.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct DrawList {
    /// The rooms in drawing order.
    pub rooms: Vec<CellId>,
    /// The landscape is drawn.
    pub outside: bool,
}

/// Where the camera was at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// The eye and its rotation: y forward, z up.
    pub position: Position,
    /// The viewer's cell: the one the camera's own sweep ended in.
    pub cell: Option<CellId>,
    /// Where the player faces: counter-clockwise from north, radians.
    pub heading: f32,
    /// Which of [`Eyes::lists`] was drawn.
    pub list: usize,
}

/// Summary of what was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Seen {
    /// Ticks at which the camera looked.
    pub ticks: usize,
    /// Rooms drawn at a tick: fewest.
    pub rooms_min: usize,
    /// Rooms drawn at a tick: as many or fewer in half of the ticks.
    pub rooms_median: usize,
    /// Rooms drawn at a tick: most.
    pub rooms_max: usize,
    /// Different draw lists.
    pub lists: usize,
    /// Ticks at which the viewer's cell was not the player's.
    pub viewer_elsewhere: usize,
    /// Of these, ticks at which one was indoors and the other outdoors.
    pub viewer_on_other_side: usize,
    /// Ticks at which the camera was in no cell.
    pub viewer_lost: usize,
    /// Ticks at which the landscape was drawn.
    pub with_outside: usize,
    /// Ticks at which the player was in a cell that cannot see the outside and the landscape was drawn all the same,
    /// with the camera in such a cell too: 0 where visibility is right.
    pub landscape_in_sealed: usize,
}

/// The camera of a tour.
pub struct Eyes {
    rig: CameraRig,
    openings: Openings,
    frame: FrameView,
    scratch: Scratch,
    fov: f32,
    heading: f32,
    known: BTreeMap<DrawList, usize>,
    lists: Vec<DrawList>,
    counts: Vec<usize>,
    seen: Seen,
}

/// A rotation about the vertical that turns north to `heading`, counter-clockwise, radians.
pub fn facing(heading: f32) -> Quat {
    let (sin, cos) = libm::sincosf(heading * 0.5);
    Quat::from_xyzw(0.0, 0.0, sin, cos)
}

/// The heading of a direction over the ground; `None` without one.
pub fn heading_of(direction: Vec2) -> Option<f32> {
    (direction.length_squared() > 0.0).then(|| libm::atan2f(-direction.x, direction.y))
}

impl Eyes {
    /// A camera behind a player who faces `heading`.
    pub fn new(heading: f32) -> Self {
        Eyes {
            rig: CameraRig::new(ChaseCamera::new(1.0)),
            openings: Openings::new(),
            frame: FrameView::default(),
            scratch: Scratch::new(),
            fov: retail_fov_y(core::f32::consts::FRAC_PI_2, SCREEN.x / SCREEN.y),
            heading,
            known: BTreeMap::new(),
            lists: Vec::new(),
            counts: Vec::new(),
            seen: Seen::default(),
        }
    }

    /// The draw lists met so far.
    pub fn lists(&self) -> &[DrawList] {
        &self.lists
    }

    /// One tick: the player turns to where it went, the camera follows and looks.
    pub fn look(
        &mut self,
        world: &World,
        population: &Population,
        footing: &Footing,
        went: Vec3,
        teleported: bool,
    ) -> Eye {
        let wanted = heading_of(went.truncate()).filter(|_| went.truncate().length() > 0.002);
        if let Some(wanted) = wanted.filter(|_| !teleported) {
            let tau = core::f32::consts::TAU;
            let left = libm::remainderf(wanted - self.heading, tau);
            let most = TURN_RATE * TICK;
            self.heading = libm::remainderf(self.heading + left.clamp(-most, most), tau);
        }
        let at = footing.at;
        let position = Position {
            cell: at.cell,
            frame: Frame::new(at.origin(), facing(self.heading)),
        };
        let mut target = ViewerTarget::at(position);
        target.velocity = if teleported { Vec3::ZERO } else { went / TICK };
        target.contact_normal = footing.carried.contact.map(|c| c.plane.normal);
        if teleported {
            // As after a portal: the camera starts behind the player anew.
            self.rig = CameraRig::new(ChaseCamera::new(1.0));
        }
        let viewer = self
            .rig
            .update(world, population, &mut self.scratch, Some(&target), TICK)
            .copied();
        let Some(viewer) = viewer else {
            return Eye {
                position,
                cell: None,
                heading: self.heading,
                list: self.note(DrawList::default()),
            };
        };
        let cell = viewer.cell.map(|cell| cell.0);
        let mut list = DrawList::default();
        match viewer.frame_input(Some(PlayerCell(at.cell)), self.fov, SCREEN) {
            Ok(input) => {
                let objects = WorldObjects::new(world).with_population(population);
                self.frame.update(world, &self.openings, &objects, &input);
            }
            Err(error) => {
                self.frame.keep(error);
            }
        }
        for command in self.frame.commands() {
            if let Command::Room { cell, .. } = command
                && !list.rooms.contains(cell)
            {
                list.rooms.push(*cell);
            }
        }
        list.outside = self.frame.draws_landscape();
        self.count(world, at.cell, cell, &list);
        Eye {
            position: viewer.position,
            cell,
            heading: self.heading,
            list: self.note(list),
        }
    }

    fn note(&mut self, list: DrawList) -> usize {
        if let Some(&known) = self.known.get(&list) {
            return known;
        }
        let index = self.lists.len();
        self.known.insert(list.clone(), index);
        self.lists.push(list);
        index
    }

    fn count(&mut self, world: &World, player: CellId, viewer: Option<CellId>, list: &DrawList) {
        let seen = &mut self.seen;
        seen.ticks += 1;
        seen.with_outside += usize::from(list.outside);
        match viewer {
            None => seen.viewer_lost += 1,
            Some(cell) => {
                seen.viewer_elsewhere += usize::from(cell != player);
                seen.viewer_on_other_side += usize::from(cell.is_indoor() != player.is_indoor());
                let sealed = |id: CellId| world.env_cell(id).is_some_and(|cell| !cell.seen_outside);
                seen.landscape_in_sealed += usize::from(list.outside && sealed(player) && sealed(cell));
            }
        }
        self.counts.push(list.rooms.len());
    }

    /// What was seen, summed up, and the draw lists.
    pub fn finish(mut self) -> (Seen, Vec<DrawList>) {
        self.counts.sort_unstable();
        let at = |i: usize| self.counts.get(i).copied().unwrap_or(0);
        let seen = Seen {
            rooms_min: at(0),
            rooms_median: at(self.counts.len().saturating_sub(1) / 2),
            rooms_max: at(self.counts.len().saturating_sub(1)),
            lists: self.lists.len(),
            ..self.seen
        };
        (seen, self.lists)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_turns_north_to_where_it_points() {
        for direction in [Vec2::X, Vec2::Y, -Vec2::X, -Vec2::Y, Vec2::new(0.6, -0.8)] {
            let heading = heading_of(direction).unwrap();
            let ahead = facing(heading) * Vec3::Y;
            assert!(
                ahead.truncate().distance(direction) < 1e-5,
                "{direction} became {ahead}"
            );
        }
        assert_eq!(heading_of(Vec2::ZERO), None);
    }
}
