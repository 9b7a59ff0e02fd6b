//! What is drawn over the picture to show what is behind it: lines and areas on the screen.

use glam::{Vec2, Vec3};
use vestibule_physics::Body;
use vestibule_view::{Camera, FrameView};
use vestibule_world::{BoundingBox, CellId, EnvCell, Frame, Shape, World};

use crate::portals::{self, Verdict};

/// What can be shown over the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlay {
    /// Boxes of the cells of the draw list.
    Cells,
    /// Portals of these cells, coloured by what became of them.
    Portals,
    /// The regions of the screen through which cells are seen.
    Regions,
    /// Polygons that are collided with.
    Collision,
    /// Cells of the stab list, and whether they are listed.
    StabList,
}

impl Overlay {
    /// All, in the order of their keys.
    pub const ALL: [Overlay; 5] = [
        Overlay::Cells,
        Overlay::Portals,
        Overlay::Regions,
        Overlay::Collision,
        Overlay::StabList,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Overlay::Cells => "cell outlines",
            Overlay::Portals => "portals",
            Overlay::Regions => "clip regions",
            Overlay::Collision => "collision polygons",
            Overlay::StabList => "stab list",
        }
    }
}

/// Colours of what is collided with: rooms, objects, shells of buildings, bodies.
const ROOM_WALLS: [u8; 3] = [255, 90, 90];
const OBJECTS: [u8; 3] = [255, 190, 70];
const SHELLS: [u8; 3] = [255, 120, 200];
const BODIES: [u8; 3] = [110, 230, 255];
/// Colours of the stab list: listed by the traversal, and not.
const SEEN: [u8; 3] = [90, 230, 110];
const UNSEEN: [u8; 3] = [160, 160, 190];
/// The landscape's regions and doors of buildings that are looked into from outdoors.
const LANDSCAPE: [u8; 3] = [80, 190, 255];
const LOOK_IN: [u8; 3] = [90, 255, 220];

impl Overlay {
    /// What its colours mean.
    pub fn legend(self) -> Vec<([u8; 3], &'static str)> {
        match self {
            Overlay::Cells => vec![
                ([255, 255, 255], "thick: the cell the player is in"),
                ([190, 190, 190], "thin: other cells of the draw list"),
            ],
            Overlay::Portals => {
                let all = Verdict::ALL.iter().map(|v| (v.color(), v.text()));
                all.chain([(LOOK_IN, "door seen from outdoors")]).collect()
            }
            Overlay::Regions => vec![
                ([190, 190, 190], "a cell is drawn only within its outline"),
                (LANDSCAPE, "where the landscape shows"),
            ],
            Overlay::Collision => vec![
                (ROOM_WALLS, "rooms"),
                (OBJECTS, "objects"),
                (SHELLS, "shells of buildings"),
                (BODIES, "bodies: the player, closed doors"),
            ],
            Overlay::StabList => vec![
                ([255, 255, 255], "the viewer's cell"),
                (SEEN, "in its stab list, and seen"),
                (UNSEEN, "in its stab list only"),
            ],
        }
    }
}

fn with_alpha([r, g, b]: [u8; 3], alpha: u8) -> [u8; 4] {
    [r, g, b, alpha]
}

/// Something drawn over the picture; pixels from the top left corner.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A line.
    Line {
        /// From.
        a: Vec2,
        /// To.
        b: Vec2,
        /// Red, green, blue, alpha.
        color: [u8; 4],
        /// Pixels.
        width: f32,
    },
    /// A convex area.
    Area {
        /// Corners.
        points: Vec<Vec2>,
        /// Red, green, blue, alpha.
        color: [u8; 4],
    },
    /// A few words.
    Label {
        /// Their middle.
        at: Vec2,
        /// What they say.
        text: String,
        /// Red, green, blue.
        color: [u8; 3],
    },
}

/// Length of the pyramids of regions, metres.
const CONE: f32 = 7.0;

/// Lines of more than this many marks are left out: a screen can hold no more.
const MOST_MARKS: usize = 40_000;

/// Collects marks seen by a camera.
#[derive(Debug)]
pub struct Marks<'a> {
    camera: &'a Camera,
    /// What was collected.
    pub list: Vec<Mark>,
}

impl<'a> Marks<'a> {
    /// None yet.
    pub fn new(camera: &'a Camera) -> Self {
        Marks {
            camera,
            list: Vec::new(),
        }
    }

    /// A line between two points relative to the eye, landscape axes; what is behind the eye is cut off.
    pub fn line(&mut self, a: Vec3, b: Vec3, color: [u8; 4], width: f32) {
        let near = self.camera.near();
        let ahead = |p: Vec3| self.camera.forward().dot(p) - near;
        let (da, db) = (ahead(a), ahead(b));
        if da < 0.0 && db < 0.0 || self.list.len() >= MOST_MARKS {
            return;
        }
        let cut = a + (b - a) * (da / (da - db));
        let a = if da < 0.0 { cut } else { a };
        let b = if db < 0.0 { cut } else { b };
        if let (Some(a), Some(b)) = (self.camera.project(a), self.camera.project(b))
            && let Some((a, b)) = on_screen(a, b, self.camera.viewport())
        {
            self.list.push(Mark::Line { a, b, color, width });
        }
    }

    /// The outline of a polygon, and its area if `fill` is not clear.
    pub fn polygon(&mut self, corners: &[Vec3], line: [u8; 4], width: f32, fill: [u8; 4]) {
        if fill[3] > 0 {
            let points = self.ahead(corners);
            // An area all over the screen would only tint it.
            let size = self.camera.viewport();
            let covers = |x: f32, y: f32| {
                (0..points.len()).all(|k| {
                    let (a, b) = (points[k], points[(k + 1) % points.len()]);
                    (b - a).perp_dot(Vec2::new(x, y) - a) >= 0.0
                }) || (0..points.len()).all(|k| {
                    let (a, b) = (points[k], points[(k + 1) % points.len()]);
                    (b - a).perp_dot(Vec2::new(x, y) - a) <= 0.0
                })
            };
            // The viewer's own region ends where the screen does, but for rounding.
            let (low, high) = (Vec2::splat(2.0), size - Vec2::splat(2.0));
            let everywhere = covers(low.x, low.y)
                && covers(high.x, low.y)
                && covers(low.x, high.y)
                && covers(high.x, high.y);
            if points.len() >= 3 && !everywhere {
                self.list.push(Mark::Area { points, color: fill });
            }
        }
        for (k, &a) in corners.iter().enumerate() {
            self.line(a, corners[(k + 1) % corners.len()], line, width);
        }
    }

    /// A few words at a point.
    pub fn label(&mut self, at: Vec3, text: impl Into<String>, color: [u8; 3]) {
        if self.camera.forward().dot(at) > self.camera.near()
            && let Some(at) = self.camera.project(at)
        {
            let size = self.camera.viewport();
            if at.x >= 0.0 && at.y >= 0.0 && at.x <= size.x && at.y <= size.y {
                let text = text.into();
                self.list.push(Mark::Label { at, text, color });
            }
        }
    }

    /// The corners of what lies ahead of the eye, on the screen.
    fn ahead(&self, corners: &[Vec3]) -> Vec<Vec2> {
        let near = self.camera.near();
        let far = |p: Vec3| self.camera.forward().dot(p) - near;
        let mut out = Vec::new();
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            let (da, db) = (far(a), far(b));
            if da >= 0.0 {
                out.extend(self.camera.project(a));
            }
            if (da < 0.0) != (db < 0.0) {
                out.extend(self.camera.project(a + (b - a) * (da / (da - db))));
            }
        }
        // What lies far outside the screen would overflow a rasteriser.
        let limit = Vec2::splat(20_000.0);
        out.iter().map(|p| p.clamp(-limit, limit)).collect()
    }

    fn cell_box(&mut self, cell: &EnvCell, color: [u8; 4], width: f32) {
        let Some(bounds) = cell.structure.bounds else {
            return;
        };
        let eye = self.camera.eye_in(cell.id.block());
        let at = |p: Vec3| cell.frame.local_to_global(p) - eye;
        for (a, b) in box_edges(&bounds) {
            self.line(at(a), at(b), color, width);
        }
    }

    /// An overlay of a frame. `player` is the cell the player is in.
    pub fn overlay(&mut self, overlay: Overlay, world: &World, frame: &FrameView, player: CellId) {
        match overlay {
            Overlay::Cells => self.cells(world, frame, player),
            Overlay::Portals => self.portals(world, frame),
            Overlay::Regions => self.regions(frame),
            Overlay::Collision => self.collision(world, frame, player),
            Overlay::StabList => self.stab_list(world, frame, player),
        }
    }

    fn cells(&mut self, world: &World, frame: &FrameView, player: CellId) {
        for flood in frame.floods().iter() {
            for seen in flood.cells() {
                let Some(cell) = world.env_cell(seen.id) else {
                    continue;
                };
                let color = cell_color(seen.id);
                let width = if seen.id == player { 3.0 } else { 1.5 };
                self.cell_box(cell, [color[0], color[1], color[2], 230], width);
                if let Some(b) = cell.structure.bounds {
                    let eye = self.camera.eye_in(cell.id.block());
                    let middle = cell.frame.local_to_global((b.min + b.max) * 0.5) - eye;
                    self.label(middle, format!("{:04X}", seen.id.low()), color);
                }
            }
        }
        if !player.is_indoor()
            && let Some(land) = world.land_cell(player)
        {
            let eye = self.camera.eye_in(player.block());
            for polygon in &land.polygons {
                let corners = polygon.vertices.map(|v| v + Vec3::Z * 0.05 - eye);
                self.polygon(&corners, [255, 255, 120, 220], 2.0, [0; 4]);
            }
        }
    }

    fn portals(&mut self, world: &World, frame: &FrameView) {
        // Judged from where the traversal looked, drawn from where this camera is.
        let Some(judge) = frame.camera() else { return };
        for flood in frame.floods().iter() {
            for seen in flood.cells() {
                let Some(cell) = world.env_cell(seen.id) else {
                    continue;
                };
                for portal in &cell.portals {
                    let verdict = portals::verdict(world, judge, &flood, seen, cell, portal);
                    let corners = portals::corners(self.camera, cell, portal);
                    let [r, g, b] = verdict.color();
                    let passed = matches!(verdict, Verdict::Passed | Verdict::Outside);
                    let (width, fill) = match verdict {
                        Verdict::FacesAway => (1.0, 0),
                        _ if passed => (3.0, 40),
                        _ => (1.5, 22),
                    };
                    self.polygon(&corners, [r, g, b, 255], width, [r, g, b, fill]);
                    let sum: Vec3 = corners.iter().copied().sum();
                    // The back of a portal that was passed the other way tells nothing new.
                    if verdict == Verdict::FacesAway {
                        continue;
                    }
                    let to = portals::leads_to(portal.other);
                    let text = format!("{:04X} to {to}: {}", seen.id.low(), verdict.text());
                    self.label(sum / corners.len().max(1) as f32, text, [r, g, b]);
                }
            }
        }
        // Doors of buildings seen from outdoors.
        for look_in in frame.look_ins().list() {
            if judge.eye() == self.camera.eye() {
                let region = frame.look_ins().punch(look_in);
                let corners: Vec<Vec3> = region.edges().iter().map(|e| e.corner).collect();
                self.polygon(&corners, with_alpha(LOOK_IN, 255), 3.0, with_alpha(LOOK_IN, 30));
                let sum: Vec3 = corners.iter().copied().sum();
                let text = format!("outside to {:04X}: looked into", look_in.entry.low());
                self.label(sum / corners.len().max(1) as f32, text, LOOK_IN);
            }
        }
    }

    /// Regions are cones from the eye of the traversal: outlines on its own screen, and seen from elsewhere pyramids
    /// with the eye at their tip.
    fn regions(&mut self, frame: &FrameView) {
        let Some(judge) = frame.camera() else { return };
        let tip = judge.eye_in(self.camera.cell().block()) - self.camera.eye();
        let elsewhere = tip.length() > 1.0e-3;
        let cone = |marks: &mut Self, region: vestibule_view::Region<'_>, color, width, fill| {
            let length = if elsewhere { CONE } else { 2.0 };
            let corners: Vec<Vec3> = region.edges().iter().map(|e| tip + e.corner * length).collect();
            marks.polygon(&corners, with_alpha(color, 255), width, with_alpha(color, fill));
            if elsewhere {
                for corner in &corners {
                    marks.line(tip, *corner, with_alpha(color, 150), 1.0);
                }
            }
        };
        for flood in frame.floods().iter() {
            for seen in flood.cells() {
                for region in flood.regions(seen) {
                    cone(self, region, cell_color(seen.id), 2.0, 30);
                }
            }
        }
        for region in frame.landscape_views() {
            cone(self, region, LANDSCAPE, 2.5, 0);
        }
    }

    fn collision(&mut self, world: &World, frame: &FrameView, player: CellId) {
        let mut cells: Vec<CellId> = frame
            .floods()
            .iter()
            .flat_map(|f| f.cells().to_vec())
            .map(|c| c.id)
            .collect();
        cells.push(player);
        cells.sort_unstable();
        cells.dedup();
        for &id in &cells {
            let eye = self.camera.eye_in(id.block());
            if let Some(cell) = world.env_cell(id)
                && let Some(physics) = &cell.structure.physics
            {
                for polygon in physics.polygons().polygons() {
                    let corners: Vec<Vec3> = physics
                        .polygons()
                        .vertices(polygon)
                        .iter()
                        .map(|v| cell.frame.local_to_global(*v) - eye)
                        .collect();
                    self.polygon(&corners, with_alpha(ROOM_WALLS, 190), 1.0, [0; 4]);
                }
            }
            for &r in world.statics_in(id) {
                let Some(object) = world.static_object(r) else {
                    continue;
                };
                let eye = self.camera.eye_in(object.cell.block());
                self.shape(&object.shape, &object.part_frames, eye, with_alpha(OBJECTS, 190));
            }
        }
        let Some(block) = world.loaded_block(player.block()) else {
            return;
        };
        let eye = self.camera.eye_in(block.id);
        for building in &block.buildings {
            self.shape(
                &building.shape,
                &building.part_frames,
                eye,
                with_alpha(SHELLS, 150),
            );
        }
    }

    /// The polygons of a shape that collide.
    fn shape(&mut self, shape: &Shape, part_frames: &[Frame], eye: Vec3, color: [u8; 4]) {
        for (part, frame) in shape.parts.iter().zip(part_frames) {
            let Some(physics) = part.model.as_ref().and_then(|m| m.physics.as_ref()) else {
                continue;
            };
            for polygon in physics.polygons().polygons() {
                let vertices = physics.polygons().vertices(polygon).iter();
                let corners: Vec<Vec3> = vertices
                    .map(|v| frame.local_to_global(*v * part.scale) - eye)
                    .collect();
                self.polygon(&corners, color, 1.0, [0; 4]);
            }
        }
    }

    /// What a body collides with: its polygons, or its spheres.
    pub fn body(&mut self, body: &Body) {
        let eye = self.camera.eye_in(body.position().cell.block());
        let color = with_alpha(BODIES, 220);
        for (part, frame) in body.shape().parts.iter().zip(body.part_frames()) {
            let Some(physics) = part.model.as_ref().and_then(|m| m.physics.as_ref()) else {
                continue;
            };
            let scale = part.scale * body.scale();
            for polygon in physics.polygons().polygons() {
                let vertices = physics.polygons().vertices(polygon).iter();
                let corners: Vec<Vec3> = vertices
                    .map(|v| frame.local_to_global(*v * scale) - eye)
                    .collect();
                self.polygon(&corners, color, 1.0, [0; 4]);
            }
        }
        for sphere in &body.shape().spheres {
            let at = |p: Vec3| body.position().frame.local_to_global(p * body.scale()) - eye;
            for (a, b) in [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)] {
                let ring = core::array::from_fn::<Vec3, 20, _>(|k| {
                    let (sin, cos) = libm::sincosf(k as f32 * core::f32::consts::TAU / 20.0);
                    at(sphere.center + (a * cos + b * sin) * sphere.radius)
                });
                self.polygon(&ring, color, 1.0, [0; 4]);
            }
        }
    }

    fn stab_list(&mut self, world: &World, frame: &FrameView, player: CellId) {
        let root = frame.interior().and_then(|f| f.cells().first().map(|c| c.id));
        let root = root.unwrap_or(player);
        let Some(cell) = world.env_cell(root) else { return };
        for &id in &cell.stab_list {
            let Some(other) = world.env_cell(id) else { continue };
            let listed = frame.floods().iter().any(|f| f.sees(id));
            let color = if listed { SEEN } else { UNSEEN };
            self.cell_box(other, with_alpha(color, 220), if listed { 2.5 } else { 1.0 });
            if let Some(b) = other.structure.bounds {
                let eye = self.camera.eye_in(id.block());
                let middle = other.frame.local_to_global((b.min + b.max) * 0.5) - eye;
                let text = format!("{:04X} {}", id.low(), if listed { "seen" } else { "stab list" });
                self.label(middle, text, color);
            }
        }
        self.cell_box(cell, [255, 255, 255, 255], 2.5);
    }
}

/// A line cut to the screen and a little around it.
fn on_screen(a: Vec2, b: Vec2, size: Vec2) -> Option<(Vec2, Vec2)> {
    let (low, high) = (Vec2::splat(-50.0), size + Vec2::splat(50.0));
    let d = b - a;
    let (mut t0, mut t1) = (0.0f32, 1.0f32);
    for k in 0..2 {
        if d[k].abs() < 1.0e-6 {
            if a[k] < low[k] || a[k] > high[k] {
                return None;
            }
            continue;
        }
        let (x, y) = ((low[k] - a[k]) / d[k], (high[k] - a[k]) / d[k]);
        let (x, y) = if x < y { (x, y) } else { (y, x) };
        t0 = if x > t0 { x } else { t0 };
        t1 = if y < t1 { y } else { t1 };
    }
    (t0 <= t1).then(|| (a + d * t0, a + d * t1))
}

fn box_edges(b: &BoundingBox) -> impl Iterator<Item = (Vec3, Vec3)> + use<> {
    let (min, max) = (b.min, b.max);
    let corner = move |k: usize| {
        Vec3::new(
            if k & 1 == 0 { min.x } else { max.x },
            if k & 2 == 0 { min.y } else { max.y },
            if k & 4 == 0 { min.z } else { max.z },
        )
    };
    (0..8usize).flat_map(move |k| {
        [1, 2, 4]
            .into_iter()
            .filter(move |bit| k & bit == 0)
            .map(move |bit| (corner(k), corner(k | bit)))
    })
}

/// A colour that tells a cell from its neighbours.
pub fn cell_color(id: CellId) -> [u8; 3] {
    let h = id.0.wrapping_mul(2_654_435_761) >> 8;
    let hue = (h % 360) as f32 / 60.0;
    let x = 1.0 - (hue % 2.0 - 1.0).abs();
    let (r, g, b) = match hue as u32 {
        0 => (1.0, x, 0.0),
        1 => (x, 1.0, 0.0),
        2 => (0.0, 1.0, x),
        3 => (0.0, x, 1.0),
        4 => (x, 0.0, 1.0),
        _ => (1.0, 0.0, x),
    };
    [r, g, b].map(|v: f32| (90.0 + 165.0 * v) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        let at = CellId(0xA9B4_0001);
        Camera::new(at, Vec3::ZERO, Vec3::Y, Vec3::Z, 1.0, Vec2::new(200.0, 100.0)).unwrap()
    }

    #[test]
    fn lines_are_cut_at_the_near_plane_and_the_screen() {
        let camera = camera();
        let mut marks = Marks::new(&camera);
        marks.line(-Vec3::Y, Vec3::new(0.0, -2.0, 1.0), [255; 4], 1.0);
        assert!(marks.list.is_empty(), "behind the eye");
        marks.line(
            Vec3::new(0.0, -5.0, -1.0),
            Vec3::new(0.0, 10.0, 0.0),
            [255; 4],
            1.0,
        );
        let Some(Mark::Line { a, b, .. }) = marks.list.first() else {
            panic!()
        };
        assert!(
            a.y <= 151.0 && (*b - Vec2::new(100.0, 50.0)).length() < 1.0,
            "{a} {b}"
        );
    }

    #[test]
    fn areas_around_the_eye_have_corners_ahead_only() {
        let camera = camera();
        let mut marks = Marks::new(&camera);
        let floor = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| Vec3::new(x, y, -1.0));
        marks.polygon(&floor, [255; 4], 1.0, [9; 4]);
        let area = marks.list.iter().find_map(|m| match m {
            Mark::Area { points, .. } => Some(points.clone()),
            _ => None,
        });
        let points = area.unwrap();
        assert_eq!(points.len(), 4);
        assert!(points.iter().all(|p| p.y > 50.0 && p.is_finite()));
    }

    #[test]
    fn a_box_has_twelve_edges() {
        let b = BoundingBox::of([Vec3::ZERO, Vec3::ONE]).unwrap();
        assert_eq!(box_edges(&b).count(), 12);
    }
}
