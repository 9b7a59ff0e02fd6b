//! Walking through every opening in small steps, and telling a moving edge from a flash.

use glam::Vec3;
use vestibule_render::IdImage;
use vestibule_view::Camera;
use vestibule_world::{CellId, PortalTarget};

use super::eyes::Rooms;
use super::stage::{Stage, camera};

/// An opening to walk through.
#[derive(Clone, Copy, Debug)]
pub struct Threshold {
    /// The room it leaves.
    pub from: CellId,
    /// The room it leads to; `None` for the outside.
    pub to: Option<CellId>,
    /// Where the eye passes it, landblock frame.
    pub middle: Vec3,
    /// The way out of the room, unit.
    pub out: Vec3,
}

/// One opening of every pair between rooms, and every exit, of the stage's landblock.
pub fn thresholds(stage: &Stage) -> Vec<Threshold> {
    let mut all = Vec::new();
    for cell in stage.world.block(stage.block).unwrap().env_cells() {
        for portal in &cell.portals {
            let to = match portal.other {
                PortalTarget::Cell(other) if other < cell.id => continue,
                PortalTarget::Cell(other) => Some(other),
                PortalTarget::Outside => None,
            };
            let out = portal.plane.normal * if portal.interior_is_negative { 1.0 } else { -1.0 };
            let corners = cell.portal_vertices(portal);
            let low = corners.iter().map(|c| c.z).fold(f32::INFINITY, f32::min);
            let mut middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
            if out.z.abs() < 0.5 {
                // As high as an eye is, if the opening is that high.
                middle.z = (low + 1.5).min(middle.z + 0.2);
            }
            all.push(Threshold {
                from: cell.id,
                to,
                middle: cell.frame.local_to_global(middle),
                out: cell.frame.local_to_global_vec(out),
            });
        }
    }
    all
}

/// What breaks the rule on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walk {
    /// Nothing: the camera's cell is the one its eye is in.
    Right,
    /// The camera keeps the cell it started in.
    StaticCell,
    /// The camera is thought to be in the cell of a point 6 cm to and fro: derived anew from coordinates.
    Jitter,
}

impl Threshold {
    /// The cell of a point: one of the two rooms, or the land.
    pub fn cell_at(&self, stage: &Stage, eye: Vec3) -> Option<CellId> {
        let rooms = [Some(self.from), self.to];
        let room = rooms
            .into_iter()
            .flatten()
            .find(|&c| stage.world.env_cell(c).is_some_and(|c| c.contains_point(eye)));
        if room.is_some() || self.to.is_some() {
            return room;
        }
        let ground = stage.world.ground_at(CellId::new(stage.block, 1), eye)?;
        let inside = stage
            .world
            .block(stage.block)
            .is_some_and(|b| b.env_cells().any(|c| c.contains_point(eye)));
        (ground.cell.block() == stage.block && eye.z > ground.z + 0.2 && !inside).then_some(ground.cell)
    }

    /// The camera `at` metres beyond the opening; `None` where walls, furniture or ground are too near.
    pub fn camera(
        &self,
        stage: &Stage,
        rooms: &Rooms,
        at: f32,
        size: (u32, u32),
        walk: Walk,
    ) -> Option<Camera> {
        let eye = self.middle + self.out * at;
        let own = self.cell_at(stage, eye)?;
        let clear = if own.is_indoor() {
            rooms.is_clear(own, eye, 0.11)
        } else {
            stage.clear_of_shells(eye) && rooms.is_clear(self.from, eye, 0.11)
        };
        if !clear {
            return None;
        }
        // A little aside, so that nothing stands edge-on; hatches are passed looking ahead, not down.
        let level = self.out.z.abs() < 0.5;
        let forward = if level { self.out } else { Vec3::Y } + Vec3::new(0.05, 0.03, -0.02);
        let cell = match walk {
            Walk::Right => own,
            Walk::StaticCell => self.from,
            Walk::Jitter => {
                let step = (at * 100.0).floor() as i32;
                let aside = if step & 1 == 0 { 0.06 } else { -0.06 };
                self.cell_at(stage, eye + self.out * aside)?
            }
        };
        Some(camera(cell, eye, forward, size, 1.2))
    }
}

/// How far an edge may move between two frames, pixels.
const REACH: i32 = 4;

/// The pixels that change although neither what they show now was near them before, nor what they showed before is
/// near them now: more than an edge has moved.
pub fn flash(before: &IdImage, after: &IdImage) -> usize {
    let (w, h) = (before.width() as i32, before.height() as i32);
    let near = |image: &IdImage, x: i32, y: i32, id| {
        let (xs, ys) = (
            (x - REACH).max(0)..=(x + REACH).min(w - 1),
            (y - REACH).max(0)..=(y + REACH).min(h - 1),
        );
        ys.into_iter()
            .any(|y| xs.clone().any(|x| image.get(x as u32, y as u32) == Some(id)))
    };
    let mut count = 0;
    for y in 0..h {
        for x in 0..w {
            let pair = (before.get(x as u32, y as u32), after.get(x as u32, y as u32));
            if let (Some(a), Some(b)) = pair
                && a != b
                && !near(before, x, y, b)
                && !near(after, x, y, a)
            {
                count += 1;
            }
        }
    }
    count
}

/// What a walk over all thresholds of a stage met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Walked {
    /// Pictures compared with the one before.
    pub pictures: usize,
    /// The most pixels that flashed at once.
    pub worst: usize,
    /// Pictures in which any did.
    pub flashes: usize,
    /// Thresholds passed from one side to the other.
    pub crossed: usize,
    /// Of these: to the outside.
    pub exits: usize,
    /// Thresholds in all.
    pub all: usize,
}

impl Walked {
    pub fn add(&mut self, o: Walked) {
        self.pictures += o.pictures;
        self.worst = self.worst.max(o.worst);
        self.flashes += o.flashes;
        self.crossed += o.crossed;
        self.exits += o.exits;
        self.all += o.all;
    }
}

/// Walks every `every`-th threshold from `steps` cm before to as much behind it; `draw` makes the picture of a camera.
pub fn walk(
    stage: &mut Stage,
    size: (u32, u32),
    (steps, every): (i32, usize),
    how: Walk,
    mut draw: impl FnMut(&mut Stage, Camera) -> IdImage,
) -> Walked {
    let mut out = Walked::default();
    let rooms = Rooms::new(stage);
    for threshold in thresholds(stage).into_iter().step_by(every) {
        let mut before: Option<IdImage> = None;
        let mut sides = [false; 2];
        for k in -steps..=steps {
            // Not on the plane itself: that is R14.
            let at = k as f32 * 0.01 + 0.0013;
            let Some(camera) = threshold.camera(stage, &rooms, at, size, how) else {
                before = None;
                continue;
            };
            let picture = draw(stage, camera);
            if let Some(before) = &before {
                let flashed = flash(before, &picture);
                out.pictures += 1;
                out.worst = out.worst.max(flashed);
                out.flashes += usize::from(flashed > 0);
                sides[usize::from(k > 0)] = true;
                if flashed > 0 && std::env::var_os("FLASHES").is_some() {
                    use std::io::Write as _;
                    let _ = writeln!(std::io::stderr(), "{flashed} flash: {camera:?}");
                }
            }
            before = Some(picture);
        }
        out.all += 1;
        if sides != [true; 2] && std::env::var_os("FLASHES").is_some() {
            use std::io::Write as _;
            let _ = writeln!(std::io::stderr(), "not walked: {threshold:?}");
        }
        out.crossed += usize::from(sides == [true; 2]);
        out.exits += usize::from(sides == [true; 2] && threshold.to.is_none());
    }
    out
}
