//! Drawing the landscape: blocks and land cells far to near, buildings with their doors, objects
//! (`rendering.md` 6, `visibility.md` 8, 10).

use glam::Vec3;
use vestibule_world::{BlockId, BoundingBox, Building, CellId, Land, Landblock, World, is_over_block};

use super::{Command, FrameInput, FrameView, LightSet, Views, active_regions};
use crate::camera::Camera;
use crate::frame_source::FrameSource;
use crate::openings::{BlockOpenings, Openings};
use crate::ring_order::{nearest_cell, rings};
use crate::view::InView;

/// Side of a land cell, metres.
const SQUARE: f32 = vestibule_world::constants::SQUARE_LENGTH;
/// Side of a landblock, metres.
const BLOCK: f32 = vestibule_world::constants::BLOCK_LENGTH;

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
        let mut cells = core::mem::take(&mut self.scratch.cell_rings);
        rings(self.settings.block_radius, &mut blocks);
        rings(7, &mut cells);
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
            self.draw_block(world, openings, source, camera, &place, &cells);
        }
        (self.scratch.block_rings, self.scratch.cell_rings) = (blocks, cells);
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
        cells: &[(i32, i32)],
    ) {
        let Some(land) = &place.block.land else { return };
        let seen = self.box_in_view(&block_bounds(place.block, land), place.eye, camera);
        if seen == InView::Outside {
            return;
        }
        let id = place.block.id;
        let full = place.ring <= self.settings.full_detail_rings;
        if !full {
            let stride = match place.ring {
                0..=2 => 2,
                3..=4 => 4,
                _ => 8,
            };
            self.commands.push(Command::TerrainBlock { block: id, stride });
        }
        if place.ring > self.settings.object_rings.max(self.settings.full_detail_rings) {
            return;
        }
        let doors = openings.block(world, id);
        for &(dx, dy) in cells.iter().rev() {
            let (x, y) = (place.nearest.0 + dx, place.nearest.1 + dy);
            if !(0..8).contains(&x) || !(0..8).contains(&y) {
                continue;
            }
            let cell = CellId::new(id, (1 + 8 * x + y) as u16);
            if full && self.cell_in_view(land, x, y, seen, place.eye, camera) {
                self.commands.push(Command::Terrain(cell));
            }
            let building = place.block.land_cell(cell).and_then(|c| c.building);
            if let Some((index, building)) =
                building.and_then(|i| Some((u32::from(i), place.block.buildings.get(usize::from(i))?)))
            {
                self.draw_building(doors, source, camera, place, index, building);
            }
            self.draw_objects(cell, Views::Landscape, source, camera);
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
        if self.box_in_view(&building.bounds, place.eye, camera) != InView::Outside {
            self.commands.push(Command::Light(LightSet::Sun));
            self.commands.push(Command::Building {
                block,
                building: index,
                model,
            });
        }
    }

    /// Whether a box of the block's frame shows through any active view (`visibility.md` 10.1).
    fn box_in_view(&self, bounds: &BoundingBox, eye: Vec3, camera: &Camera) -> InView {
        let corners = bounds.corners().map(|c| c - eye);
        let test = |r: crate::view::Region<'_>| r.meets_box(&corners, camera.forward(), camera.near());
        active_regions(&self.active_edges, &self.active)
            .map(test)
            .max()
            .unwrap_or(InView::Outside)
    }

    fn cell_in_view(&self, land: &Land, x: i32, y: i32, block: InView, eye: Vec3, camera: &Camera) -> bool {
        if block == InView::Inside {
            return true;
        }
        let corner = |dx: i32, dy: i32| {
            let (x, y) = (x + dx, y + dy);
            let z = land.heights.get((x * 9 + y) as usize).copied().unwrap_or(0.0);
            Vec3::new(x as f32 * SQUARE, y as f32 * SQUARE, z)
        };
        let Some(bounds) = BoundingBox::of([corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)]) else {
            return true;
        };
        self.box_in_view(&bounds, eye, camera) != InView::Outside
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

/// The box of a block's terrain, extended by its buildings (`visibility.md` 8.1).
fn block_bounds(block: &Landblock, land: &Land) -> BoundingBox {
    let (low, high) = land.z_limits;
    let mut bounds = BoundingBox {
        min: Vec3::new(0.0, 0.0, low),
        max: Vec3::new(BLOCK, BLOCK, high),
    };
    for building in &block.buildings {
        let b = building.bounds;
        bounds.grow(b.min);
        bounds.grow(b.max);
    }
    for object in &block.statics[..(block.land_statics as usize).min(block.statics.len())] {
        // Objects may stand higher than the terrain's margin or over the border.
        if is_over_block(object.frame.origin) {
            bounds.grow(object.frame.origin);
        }
    }
    bounds
}
