//! Holding the traversal to the `visible` test vectors: what a camera sees through openings and nothing else.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use vestibule_world::{CellId, World};

use crate::camera::{Camera, CameraError};
use crate::flood::{Flood, FloodArena};
use crate::look_in::LookIns;
use crate::openings::Openings;
use crate::pview::PView;
use crate::view::{Region, full_view};

/// Landblocks around the eye's whose buildings are looked into.
const BLOCK_RADIUS: i32 = 5;
/// Height of the screen that areas are given for, pixels.
const SCREEN_HEIGHT: f32 = 720.0;

/// The input of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleQuery {
    /// Where the eye is.
    pub cell: CellId,
    /// Metres, in the frame of the cell's landblock.
    pub eye: Vec3,
    /// Unit direction of view.
    pub forward: Vec3,
    /// Unit direction that is up on the screen.
    pub up: Vec3,
    /// Whole vertical angle of view, radians.
    pub fov_y: f32,
    /// Width by height.
    pub aspect: f32,
}

/// Cells with the summed area of their views, square pixels.
pub type CellAreas = BTreeMap<u32, f32>;

/// What a case should give.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExpectedCells {
    /// Cells that must be seen.
    pub must: Vec<u32>,
    /// Cells that may be.
    pub may: Vec<u32>,
    /// Cells of `must` that a program may lose which drops views under a pixel.
    pub thin: Vec<u32>,
    /// Areas of views.
    pub areas: CellAreas,
}

/// The expectation of a case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisibleExpect {
    /// The root cell, 0 from outdoors.
    pub first: u32,
    /// Cells of the first traversal; from outdoors those seen in any building.
    pub cells: ExpectedCells,
    /// Whether the outside is seen.
    pub outside: bool,
    /// Area of the outside views; indoors only.
    pub outside_area: Option<f32>,
    /// Cells seen in buildings through the outside views.
    pub look_in: Option<ExpectedCells>,
}

/// What the traversal answers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisibleAnswer {
    /// The root cell, 0 from outdoors.
    pub first: u32,
    /// Cells in order of their ids.
    pub cells: CellAreas,
    /// Whether the outside is seen.
    pub outside: bool,
    /// Area of the outside views, square pixels.
    pub outside_area: f32,
    /// Cells seen in buildings through the outside views; empty from outdoors.
    pub look_in: CellAreas,
}

impl VisibleQuery {
    /// The camera of the query; areas are for a screen 720 pixels high.
    ///
    /// # Errors
    /// As [`Camera::new`].
    pub fn camera(&self) -> Result<Camera, CameraError> {
        let viewport = Vec2::new(SCREEN_HEIGHT * self.aspect, SCREEN_HEIGHT);
        Camera::new(self.cell, self.eye, self.forward, self.up, self.fov_y, viewport)
    }

    /// Runs the query.
    ///
    /// # Errors
    /// As [`Camera::new`].
    pub fn answer(
        &self,
        world: &World,
        openings: &Openings,
        pview: &mut PView,
    ) -> Result<VisibleAnswer, CameraError> {
        let camera = self.camera()?;
        let mut answer = VisibleAnswer::default();
        let full = full_view(&camera);
        let mut views: Vec<Vec<crate::view::Edge>> = Vec::new();
        if self.cell.is_indoor() {
            let flood = pview.look(world, openings, &camera);
            answer.first = flood.cells().first().map_or(0, |c| c.id.0);
            add_areas(&flood, &camera, &mut answer.cells);
            answer.outside = flood.sees_outside();
            for region in flood.outside() {
                answer.outside_area += region.pixel_area(&camera);
                views.push(region.edges().to_vec());
            }
        } else {
            answer.outside = true;
            views.push(full.to_vec());
        }
        let regions = views.iter().map(|edges| Region::new(edges));
        let (mut look_ins, mut floods) = (LookIns::new(), FloodArena::new());
        for dx in -BLOCK_RADIUS..=BLOCK_RADIUS {
            for dy in -BLOCK_RADIUS..=BLOCK_RADIUS {
                let block = self.cell.block().neighbour(dx, dy);
                if let Some(found) = block.and_then(|id| openings.block(world, id)) {
                    pview.look_into_block(found, &camera, regions.clone(), &mut look_ins, &mut floods);
                }
            }
        }
        let seen = if self.cell.is_indoor() {
            &mut answer.look_in
        } else {
            &mut answer.cells
        };
        for flood in floods.iter() {
            add_areas(&flood, &camera, seen);
        }
        Ok(answer)
    }
}

fn add_areas(flood: &Flood<'_>, camera: &Camera, areas: &mut CellAreas) {
    for cell in flood.cells() {
        let area: f32 = flood.regions(cell).map(|r| r.pixel_area(camera)).sum();
        *areas.entry(cell.id.0).or_default() += area;
    }
}

impl VisibleExpect {
    /// How an answer differs from what is expected, one line a difference; empty when it agrees. With
    /// `allow_thin`, cells that only thin views show may be missing.
    pub fn differences(&self, answer: &VisibleAnswer, allow_thin: bool) -> Vec<String> {
        let mut out = Vec::new();
        if self.first != answer.first {
            out.push(format!(
                "first cell 0x{:08X}, expected 0x{:08X}",
                answer.first, self.first
            ));
        }
        if self.outside != answer.outside {
            out.push(format!(
                "outside seen: {}, expected {}",
                answer.outside, self.outside
            ));
        }
        self.cells.compare("", &answer.cells, allow_thin, &mut out);
        if let Some(look_in) = &self.look_in {
            look_in.compare("look-in ", &answer.look_in, allow_thin, &mut out);
        }
        out
    }

    /// Differences of areas by more than 2 percent and 4 pixels, thin cells left out; informative only, since a view
    /// clipped at a tiny distance from an opening can differ by more.
    pub fn area_differences(&self, answer: &VisibleAnswer) -> Vec<String> {
        let mut out = Vec::new();
        let mut test = |what: String, got: f32, want: f32| {
            if (got - want).abs() > want * 0.02 + 4.0 {
                out.push(format!("{what}: area {got:.1}, expected {want}"));
            }
        };
        let lists = [
            ("", Some(&self.cells), &answer.cells),
            ("look-in ", self.look_in.as_ref(), &answer.look_in),
        ];
        for (name, expected, got) in lists {
            let Some(expected) = expected else { continue };
            for (id, &want) in &expected.areas {
                if !expected.thin.contains(id) {
                    test(
                        format!("{name}0x{id:08X}"),
                        got.get(id).copied().unwrap_or(0.0),
                        want,
                    );
                }
            }
        }
        if let Some(want) = self.outside_area {
            test("outside".to_owned(), answer.outside_area, want);
        }
        out
    }
}

impl ExpectedCells {
    fn compare(&self, name: &str, got: &CellAreas, allow_thin: bool, out: &mut Vec<String>) {
        for id in &self.must {
            let excused = allow_thin && self.thin.contains(id);
            if !got.contains_key(id) && !excused {
                out.push(format!("{name}0x{id:08X} is missing"));
            }
        }
        for (id, area) in got {
            if !self.must.contains(id) && !self.may.contains(id) {
                out.push(format!(
                    "{name}0x{id:08X} is seen (area {area:.3}) and should not be"
                ));
            }
        }
    }
}
