//! Drawing rooms: `DrawInside` and `DrawCells` (`rendering.md` 5).

use glam::Vec3;
use vestibule_world::{CellId, World};

use super::{
    Command, FrameInput, FramePath, FrameView, LightSet, PolygonRef, SealDepth, Views, active_regions,
};
use crate::camera::Camera;
use crate::frame_source::FrameSource;
use crate::openings::{BlockOpenings, Openings};
use crate::view::{Edge, Region, full_view};

impl FrameView {
    pub(super) fn draw_inside(
        &mut self,
        world: &World,
        openings: &Openings,
        source: &dyn FrameSource,
        input: &FrameInput,
        camera: &Camera,
    ) {
        let marked = world.env_cell(camera.cell()).is_some_and(|c| c.seen_outside);
        self.path = if marked {
            FramePath::SeesOut
        } else {
            FramePath::Sealed
        };
        let block = openings.block(world, camera.cell().block());
        let full = full_view(camera);
        let (cell, eye) = (camera.cell(), camera.eye());
        self.pview
            .flood_from_cell(block, cell, eye, &full, Some(camera), &mut self.floods);
        self.has_interior = true;
        let Some(interior) = self.floods.get(0) else {
            return;
        };
        if interior.sees_outside() {
            self.counters.unmarked_exits += u32::from(!marked);
            for region in interior.outside() {
                self.active
                    .push((self.active_edges.len() as u32, region.edges().len() as u32));
                self.active_edges.extend_from_slice(region.edges());
            }
            self.commands.push(Command::Light(LightSet::Sun));
            self.draw_landscape(world, openings, source, input, camera);
            self.commands.push(Command::FlushAlpha);
            self.scratch.next_stamp();
            self.commands.push(Command::NextStamp);
            self.commands.push(Command::ClearDepth);
            if let Some(block) = block {
                self.draw_seals(block, camera);
            }
        }
        self.draw_cells(0, source, camera);
    }

    /// Step 7 of `rendering.md` 5.2: for each room far to near, each of its views, each of its exits.
    fn draw_seals(&mut self, openings: &BlockOpenings, camera: &Camera) {
        let Some(flood) = self.floods.get(0) else { return };
        let (near, forward) = (Self::near(camera), camera.forward());
        let mut clip = core::mem::take(&mut self.scratch.clip);
        let mut spare = core::mem::take(&mut self.scratch.clip_spare);
        let seals = flood.seals();
        let mut end = seals.len();
        // Seals are listed by cell, near to far; walk the cells from the end and each cell's exits in order.
        while end > 0 {
            let cell = seals[end - 1].cell;
            let start = seals[..end]
                .iter()
                .rposition(|s| s.cell != cell)
                .map_or(0, |at| at + 1);
            let Some(seen) = flood.cells().get(cell as usize) else {
                break;
            };
            for region in flood.regions(seen) {
                for seal in seals[start..end].iter().filter(|s| !s.on_block_border) {
                    for piece in openings.portal_pieces(seen.id, seal.portal) {
                        clip_to_view(piece, camera.eye(), region.edges(), &mut clip, &mut spare);
                        let mut emit = |far: bool, depth: SealDepth, clip: &mut Vec<Vec3>| {
                            let (normal, offset) = if far { (forward, -near) } else { (-forward, near) };
                            clip_plane(clip, &mut spare, normal, offset);
                            let first = self.points.len() as u32;
                            if spare.len() >= 3 {
                                self.points.extend_from_slice(&spare);
                                let polygon = PolygonRef {
                                    first,
                                    count: spare.len() as u32,
                                };
                                let (cell, portal) = (seen.id, seal.portal);
                                self.commands.push(Command::Seal {
                                    polygon,
                                    depth,
                                    cell,
                                    portal,
                                });
                            }
                        };
                        if clip.len() >= 3 {
                            emit(true, SealDepth::True, &mut clip);
                            emit(false, SealDepth::Nearest, &mut clip);
                        }
                    }
                }
            }
            end = start;
        }
        (self.scratch.clip, self.scratch.clip_spare) = (clip, spare);
    }

    /// Steps 8-11 of `rendering.md` 5.2 for one traversal: rooms far to near, then their objects far to near.
    pub(super) fn draw_cells(&mut self, flood: u32, source: &dyn FrameSource, camera: &Camera) {
        self.commands.push(Command::Light(LightSet::Indoor));
        let count = self
            .floods
            .get(flood as usize)
            .map_or(0, |f| f.cells().len() as u32);
        for at in (0..count).rev() {
            let Some(cell) = self.cell_of(flood, at) else {
                continue;
            };
            if self.scratch.first_room(cell) {
                self.commands.push(Command::Room {
                    cell,
                    views: Views::Cell { flood, cell: at },
                });
            }
        }
        for at in (0..count).rev() {
            let Some(cell) = self.cell_of(flood, at) else {
                continue;
            };
            let eye = camera.eye_in(cell.block());
            self.draw_objects(cell, Views::Cell { flood, cell: at }, source, camera, eye);
        }
        self.commands.push(Command::Light(LightSet::Sun));
    }

    fn cell_of(&self, flood: u32, at: u32) -> Option<CellId> {
        self.floods
            .get(flood as usize)?
            .cells()
            .get(at as usize)
            .map(|c| c.id)
    }

    /// The objects of a cell, far to near, that one of the views shows (`visibility.md` 11), once per stamp. The eye is in
    /// the frame of the cell's landblock.
    pub(super) fn draw_objects(
        &mut self,
        cell: CellId,
        views: Views,
        source: &dyn FrameSource,
        camera: &Camera,
        eye: Vec3,
    ) {
        let mut shown = core::mem::take(&mut self.scratch.sorted);
        source.objects_in(cell, &mut |object| {
            let (center, radius) = (object.sphere.center - eye, object.sphere.radius);
            let distance = center.dot(center);
            if distance.is_finite() && self.shows_sphere(views, center, radius, camera) {
                shown.push((distance.to_bits(), shown.len() as u32, object.id));
            }
        });
        if shown.len() > 1 {
            // Far to near, stable: bits of non-negative floats sort as the floats do.
            shown.sort_unstable_by_key(|&(distance, at, _)| (core::cmp::Reverse(distance), at));
        }
        for (_, _, id) in shown.drain(..) {
            if self.scratch.first_object(id) {
                self.commands.push(Command::Object { id, cell, views });
            }
        }
        self.scratch.sorted = shown;
    }

    /// Whether a sphere around something, its centre relative to the eye, shows through one of the views.
    fn shows_sphere(&self, views: Views, center: Vec3, radius: f32, camera: &Camera) -> bool {
        let shows = |r: Region<'_>| r.shows_sphere(center, radius, camera.forward(), camera.near());
        match views {
            Views::Landscape => active_regions(&self.active_edges, &self.active).any(shows),
            Views::Cell { .. } => self.regions(views).any(shows),
        }
    }
}

/// Clips a polygon of the landblock frame to the sides of a view, into eye-relative metres.
fn clip_to_view(vertices: &[Vec3], eye: Vec3, view: &[Edge], out: &mut Vec<Vec3>, spare: &mut Vec<Vec3>) {
    out.clear();
    out.extend(vertices.iter().map(|&p| p - eye));
    for side in view {
        clip_plane(out, spare, side.normal, 0.0);
        core::mem::swap(out, spare);
        if out.len() < 3 {
            out.clear();
            return;
        }
    }
}

/// Writes the part of `from` with `normal · p + offset >= 0` to `out`.
fn clip_plane(from: &[Vec3], out: &mut Vec<Vec3>, normal: Vec3, offset: f32) {
    out.clear();
    for (k, &a) in from.iter().enumerate() {
        let b = from[if k + 1 == from.len() { 0 } else { k + 1 }];
        let (da, db) = (normal.dot(a) + offset, normal.dot(b) + offset);
        if da >= 0.0 {
            out.push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            out.push(a + (b - a) * (da / (da - db)));
        }
    }
}
