//! Drawing the landscape: blocks and land cells far to near, buildings with their doors, objects
//! (`rendering.md` 6, `visibility.md` 8, 10).

use glam::Vec3;
use vestibule_world::{BlockId, BoundingBox, Building, CellId, Landblock, World};

use super::{Command, FrameInput, FrameView, LightSet, Views, active_regions};
use crate::camera::Camera;
use crate::frame_source::FrameSource;
use crate::land_outline::{block_bounds, cell_bounds, quarter_of};
use crate::openings::{BlockOpenings, Openings};
use crate::ring_order::{cells_far_to_near, nearest_cell, rings};
use crate::view::InView;

impl FrameView {
    /// The landscape under the active views (`rendering.md` 6.2).
    pub(super) fn draw_landscape(
        &mut self,
        world: &World,
        openings: &Openings,
        source: &dyn FrameSource,
        input: &FrameInput,
        camera: &Camera,
    ) {
        self.commands.push(Command::Sky);
        // The outdoor cell under the eye; off the map there is sky only.
        let Some((viewpoint, _)) = camera.cell().adjust_to_outside(camera.eye()) else {
            return;
        };
        self.viewpoint = Some(viewpoint);
        let centre = viewpoint.block();
        let low = i32::from(viewpoint.low()) - 1;
        let viewer = (low >> 3, low & 7);
        let mut blocks = core::mem::take(&mut self.scratch.block_rings);
        let mut orders = core::mem::take(&mut self.scratch.cell_orders);
        if orders.is_empty() {
            rings(7, &mut blocks);
            orders.extend((0..64).map(|k| cells_far_to_near((k / 8, k % 8), &blocks)));
        }
        rings(self.settings.block_radius, &mut blocks);
        for &(dx, dy) in blocks.iter().rev() {
            let Some(id) = centre.neighbour(dx, dy) else {
                continue;
            };
            let found = if self.settings.load_blocks {
                world.block(id)
            } else {
                world.loaded_block(id)
            };
            let Some(block) = found else {
                self.counters.missing_blocks += 1;
                continue;
            };
            let ring = dx.abs().max(dy.abs());
            let nearest = nearest_cell(dx, dy, viewer);
            let place = Place {
                block,
                ring,
                nearest,
                eye: camera.eye_in(id),
            };
            let (x, y) = place.nearest;
            if let Some(cells) = orders.get((8 * x + y) as usize) {
                self.draw_block(world, openings, source, camera, &place, cells);
            }
        }
        (self.scratch.block_rings, self.scratch.cell_orders) = (blocks, orders);
        let player_outdoors = input.player_cell.is_some_and(|c| !c.0.is_indoor());
        if input.weather && player_outdoors {
            self.commands.push(Command::Weather);
        }
    }

    fn draw_block(
        &mut self,
        world: &World,
        openings: &Openings,
        source: &dyn FrameSource,
        camera: &Camera,
        place: &Place<'_>,
        cells: &[(u8, u8); 64],
    ) {
        let Some(land) = &place.block.land else { return };
        let id = place.block.id;
        let with_objects = place.ring <= self.settings.object_rings.max(self.settings.full_detail_rings);
        let doors = if with_objects {
            openings.block(world, id)
        } else {
            None
        };
        let outline = doors.and_then(|d| d.outline.as_ref());
        let bounds = outline.map_or_else(|| block_bounds(place.block, land), |o| o.bounds);
        let seen = self.box_in_view(&bounds, place.eye, camera);
        if seen == InView::Outside {
            return;
        }
        let full = place.ring <= self.settings.full_detail_rings;
        if !full {
            let stride = match place.ring {
                0..=2 => 2,
                3..=4 => 4,
                _ => 8,
            };
            self.commands.push(Command::TerrainBlock { block: id, stride });
        }
        if !with_objects {
            return;
        }
        let quarters = outline
            .filter(|_| full && seen == InView::Partial)
            .map(|o| o.quarters().map(|b| self.box_in_view(&b, place.eye, camera)));
        let with_any = source.land_cells_with_objects(id);
        for &(x, y) in cells {
            let k = 8 * usize::from(x) + usize::from(y);
            let cell = CellId::new(id, (1 + k) as u16);
            let seen = quarters.map_or(seen, |q| q[quarter_of(k)]);
            let bounds = || outline.map_or_else(|| cell_bounds(land, k), |o| o.cell_bounds(k));
            let shows = match seen {
                InView::Outside => false,
                InView::Partial => full && self.shows_box(&bounds(), place.eye, camera),
                InView::Inside => true,
            };
            if full && shows {
                self.commands.push(Command::Terrain(cell));
            }
            let building = match outline {
                Some(outline) => outline.building(k),
                None => place.block.land_cell(cell).and_then(|c| c.building),
            };
            if let Some((index, building)) =
                building.and_then(|i| Some((u32::from(i), place.block.buildings.get(usize::from(i))?)))
            {
                self.draw_building(doors, source, camera, place, index, building);
            }
            if with_any >> k & 1 != 0 {
                self.draw_objects(cell, Views::Landscape, source, camera, place.eye);
            }
        }
    }

    /// `rendering.md` 6.3: punches, then rooms, then the shell.
    fn draw_building(
        &mut self,
        openings: Option<&BlockOpenings>,
        source: &dyn FrameSource,
        camera: &Camera,
        place: &Place<'_>,
        index: u32,
        building: &Building,
    ) {
        let distance = (building.frame.origin - place.eye).length();
        let Some(model) = source.building_model(building, distance) else {
            return;
        };
        let block: BlockId = place.block.id;
        self.commands.push(Command::FlushAlpha);
        let first = self.look_ins.list.len();
        if let Some(openings) = openings {
            let views = active_regions(&self.active_edges, &self.active);
            self.pview.look_into(
                openings,
                index,
                camera,
                views,
                &mut self.look_ins,
                &mut self.floods,
            );
        }
        for at in first..self.look_ins.list.len() {
            let look = self.look_ins.list[at];
            if look.on_block_border || look.edge_count == 0 {
                continue;
            }
            let polygon = {
                let from = look.first_edge as usize;
                let edges = from..from + look.edge_count as usize;
                let start = self.points.len() as u32;
                self.points
                    .extend(self.look_ins.edges[edges].iter().map(|e| e.corner));
                super::PolygonRef {
                    first: start,
                    count: look.edge_count,
                }
            };
            self.commands.push(Command::Punch {
                polygon,
                block,
                building: index,
                portal: look.portal,
            });
        }
        for at in first..self.look_ins.list.len() {
            let flood = self.look_ins.list[at].flood;
            self.draw_cells(flood, source, camera);
        }
        if self.shows_box(&building.bounds, place.eye, camera) {
            self.commands.push(Command::Light(LightSet::Sun));
            self.commands.push(Command::Building {
                block,
                building: index,
                model,
            });
        }
    }

    /// How a box of a block lies to the active views; the eye in the block's frame (`visibility.md` 10.1).
    fn box_in_view(&self, bounds: &BoundingBox, eye: Vec3, camera: &Camera) -> InView {
        let (low, high) = (bounds.min - eye, bounds.max - eye);
        active_regions(&self.active_edges, &self.active)
            .map(|r| r.meets_box(low, high, camera.forward(), camera.near()))
            .max()
            .unwrap_or(InView::Outside)
    }

    /// Whether a box of a block shows through any active view.
    fn shows_box(&self, bounds: &BoundingBox, eye: Vec3, camera: &Camera) -> bool {
        let (low, high) = (bounds.min - eye, bounds.max - eye);
        active_regions(&self.active_edges, &self.active)
            .any(|r| r.shows_box(low, high, camera.forward(), camera.near()))
    }
}

struct Place<'w> {
    block: &'w Landblock,
    /// Rings from the viewer's block.
    ring: i32,
    /// The land cell nearest to the viewer, by column and row.
    nearest: (i32, i32),
    /// In the block's frame.
    eye: Vec3,
}
