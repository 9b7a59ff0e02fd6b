//! The walk over a picture's commands (`rendering.md` 5, 6): what is drawn, where it lies for the eye and what lights
//! it. Every renderer walks this way and only draws.

use std::sync::Arc;

use glam::{DVec3, Quat, Vec3};
use vestibule_physics::{BodyId, ObjectRef};
use vestibule_view::{Command, LightSet, PolygonRef, SealDepth, Views};
use vestibule_world::{BlockId, CellId, Frame, StaticRef};

use crate::detail::turned;
use crate::figure::{FIGURE_HEIGHT, figure};
use crate::lighting::{Lamp, MAX_OBJECT_LAMPS, OBJECT_RANGE};
use crate::mesh::Mesh;
use crate::overlaps::overlapping_cells;
use crate::picture::Picture;
use crate::place::{EyeFrame, Placed};
use crate::raster::PixelKind;
use crate::scene::{LightDetail, RenderSettings, Scene};
use crate::sky::SkyThing;

/// Item of every body in the ids of a picture.
const BODY_ITEM: u32 = 0x0800_0000;

/// Who a mesh belongs to, for its ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    /// What it is.
    pub kind: PixelKind,
    /// Its cell: see [`PixelId::cell`](crate::PixelId::cell).
    pub cell: CellId,
    /// The item of every face; `None` takes the polygon's key.
    pub item: Option<u32>,
}

/// What lights a mesh; lamps in camera axes (`rendering.md` 12).
#[derive(Clone, Copy, Debug)]
pub enum PieceLight<'p> {
    /// Sun and outdoor ambient.
    Sun,
    /// A shell: ambient, baked lamps and the viewer's.
    Shell {
        /// Whose lamps they are; the same throughout a picture.
        cell: CellId,
        /// All of them.
        lamps: &'p [Lamp],
    },
    /// An object indoors: ambient, the nearest lamps and the viewer's.
    Indoor {
        /// Whose lamps they are.
        cell: CellId,
        /// All of the cell's.
        lamps: &'p [Lamp],
        /// Positions of those that reach the object, nearest first; [`MAX_OBJECT_LAMPS`] at most.
        near: &'p [u8],
    },
}

/// A mesh to draw.
#[derive(Clone, Copy, Debug)]
pub struct Piece<'p> {
    /// Its polygons.
    pub mesh: &'p Arc<Mesh>,
    /// Where it lies.
    pub placed: &'p Placed,
    /// Whose it is.
    pub owner: Owner,
    /// What lights it.
    pub light: PieceLight<'p>,
    /// Below 1 all of it fades.
    pub opacity: f32,
    /// It shows only where all of these, normals of planes through the eye in camera axes, point; none for everywhere
    /// (`rendering.md` 9.5).
    pub edges: &'p [DVec3],
}

/// What a punch or a seal writes (`rendering.md` 7.2, 7.6a).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortalDepth {
    /// [`PUNCH_DEPTH`](crate::PUNCH_DEPTH).
    Punch,
    /// The polygon's own.
    Own,
    /// The nearest there is.
    Nearest,
}

/// What a walk draws on. Points are in camera axes, metres from the eye; polygons are convex.
pub trait Canvas {
    /// The landscape begins: sky in these columns and rows (from, to, from, to).
    fn sky(&mut self, bounds: [u32; 4]);
    /// A thing in the sky: over everything, without depth or fog.
    fn sky_thing(&mut self, mesh: &Arc<Mesh>, placed: &Placed, thing: &SkyThing);
    /// The two triangles of a land cell. Returns whether there was any ground.
    fn land_cell(&mut self, cell: CellId) -> bool;
    /// The ground of a landblock, every `stride`-th vertex of it. Returns whether there was any.
    fn land_block(&mut self, block: BlockId, stride: u8) -> bool;
    /// Until depth is cleared, nothing is drawn that lies before one of these exits.
    fn behind_exit(&mut self, points: &[DVec3]);
    /// A punch or a seal: depth, whatever is there.
    fn portal(&mut self, points: &[DVec3], depth: PortalDepth);
    /// A mesh.
    fn piece(&mut self, piece: &Piece<'_>);
    /// What was put aside as see-through (`rendering.md` 14.7).
    fn flush(&mut self);
    /// The depth buffer is cleared, the colours stay; what follows are the viewer's own rooms.
    fn clear_depth(&mut self);
}

/// What a walk met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WalkCounters {
    /// Things a command names that the world or the assets do not have.
    pub missing: u32,
    /// Rooms confined to their regions because they overlap another.
    pub confined: u32,
}

/// A walk over a picture's commands from first to last.
#[derive(Debug)]
pub struct Walk<'a> {
    scene: &'a Scene<'a>,
    settings: &'a RenderSettings,
    picture: &'a Picture<'a>,
    eye: EyeFrame,
    light: LightSet,
    lit: bool,
    counters: WalkCounters,
    /// Per traversal the rooms that overlap others.
    overlaps: Vec<Vec<CellId>>,
    /// Lamps of the cells met so far, camera axes, and where each cell's are.
    lamps: Vec<Lamp>,
    known: Vec<(CellId, (usize, usize))>,
    points: Vec<DVec3>,
}

impl<'a> Walk<'a> {
    /// A walk that has not begun.
    pub fn new(scene: &'a Scene<'a>, settings: &'a RenderSettings, picture: &'a Picture<'a>) -> Self {
        let floods = picture.frame.filter(|_| settings.confine_overlaps).into_iter();
        let floods = floods.flat_map(|frame| frame.floods().iter());
        Walk {
            scene,
            settings,
            picture,
            eye: EyeFrame::new(picture.camera),
            light: LightSet::Sun,
            lit: true,
            counters: WalkCounters::default(),
            overlaps: floods.map(|f| overlapping_cells(scene.world, &f)).collect(),
            lamps: Vec::new(),
            known: Vec::new(),
            points: Vec::new(),
        }
    }

    /// Without looking for lamps: for pictures of ids.
    #[must_use]
    pub fn unlit(mut self) -> Self {
        self.lit = false;
        self
    }

    /// The light the viewer carries, camera axes (`rendering.md` 12.7); `None` when it is off.
    pub fn viewer_lamp(&self) -> Option<Lamp> {
        if !self.settings.viewer_light {
            return None;
        }
        let player = self.scene.player.zip(self.scene.population);
        let body = player.and_then(|(id, population)| population.body(id));
        let position = body.map_or(DVec3::ZERO, |body| {
            let p = body.position();
            let placed = self.eye.place_block(p.cell.block());
            placed.point(p.frame.origin + Vec3::new(0.0, 0.0, 2.0))
        });
        let mut lamp = Lamp::of_viewer(position.as_vec3());
        if self.settings.light == LightDetail::PerPixel && !self.picture.sealed {
            // By daylight it would drown what the room's own lamps do.
            lamp.intensity *= 0.3;
        }
        Some(lamp)
    }

    /// Walks, and flushes at the end.
    pub fn run(mut self, canvas: &mut impl Canvas) -> WalkCounters {
        let picture = self.picture;
        if self.settings.only_behind_exits && picture.frame.is_some_and(|f| f.interior().is_some()) {
            for command in picture.commands {
                if let Command::Seal {
                    polygon,
                    depth: SealDepth::True,
                    ..
                } = *command
                {
                    self.see(polygon);
                    canvas.behind_exit(&self.points);
                }
            }
        }
        for command in picture.commands {
            self.command(command, canvas);
        }
        canvas.flush();
        self.counters
    }

    fn missing(&mut self) {
        self.counters.missing += 1;
    }

    fn command(&mut self, command: &Command, canvas: &mut impl Canvas) {
        match *command {
            Command::Light(light) => self.light = light,
            Command::Sky => {
                canvas.sky(self.picture.sky_bounds());
                self.sky_things(false, canvas);
            }
            Command::Terrain(cell) => {
                if !canvas.land_cell(cell) {
                    self.missing();
                }
            }
            Command::TerrainBlock { block, stride } => {
                if !canvas.land_block(block, stride.clamp(1, 8)) {
                    self.missing();
                }
            }
            Command::FlushAlpha => canvas.flush(),
            Command::Punch { polygon, .. } => {
                self.see(polygon);
                canvas.portal(&self.points, PortalDepth::Punch);
            }
            Command::Seal { polygon, depth, .. } => {
                self.see(polygon);
                let depth = match depth {
                    SealDepth::Nearest => PortalDepth::Nearest,
                    SealDepth::True => PortalDepth::Own,
                };
                canvas.portal(&self.points, depth);
            }
            Command::Building {
                block,
                building,
                model,
            } => self.building(block, building, model, canvas),
            Command::Room { cell, views } => match self.confined(cell, views) {
                Some(regions) => {
                    self.counters.confined += 1;
                    for region in regions {
                        self.room(cell, &region, canvas);
                    }
                }
                None => self.room(cell, &[], canvas),
            },
            Command::Object { id, cell, views } => match self.confined(cell, views) {
                Some(regions) => {
                    for region in regions {
                        self.object(id, cell, &region, canvas);
                    }
                }
                None => self.object(id, cell, &[], canvas),
            },
            Command::NextStamp => {}
            Command::ClearDepth => canvas.clear_depth(),
            Command::Weather => self.sky_things(true, canvas),
        }
    }

    /// Puts a polygon of the frame, in camera axes, into the points.
    fn see(&mut self, polygon: PolygonRef) {
        self.points.clear();
        let Some(frame) = self.picture.frame else { return };
        let seen = frame.polygon(polygon).iter();
        self.points.extend(seen.map(|p| self.eye.turn(p.as_dvec3())));
    }

    /// The regions of a room that overlaps others (`rendering.md` 9.5).
    fn confined(&self, cell: CellId, views: Views) -> Option<Vec<Vec<DVec3>>> {
        let (Views::Cell { flood, .. }, Some(frame)) = (views, self.picture.frame) else {
            return None;
        };
        if !self.overlaps.get(flood as usize)?.contains(&cell) {
            return None;
        }
        let edges = frame.regions(views).map(|region| {
            let edges = region.edges().iter();
            edges.map(|e| self.eye.turn(e.normal.as_dvec3())).collect()
        });
        Some(edges.collect())
    }

    fn sky_things(&mut self, after: bool, canvas: &mut impl Canvas) {
        let (scene, camera) = (self.scene, self.picture.camera);
        let table = scene.assets.sky(scene.world);
        for thing in table.things(scene.day_group, scene.time_of_day) {
            if thing.after != after {
                continue;
            }
            let Some(mesh) = scene.assets.model(scene.world, thing.model, None) else {
                self.missing();
                continue;
            };
            let rotation = Quat::from_rotation_z(-thing.heading) * Quat::from_rotation_y(-thing.angle);
            // Around the eye: endlessly far away.
            let frame = Frame::new(camera.eye(), rotation);
            let placed = self.eye.place(camera.cell().block(), &frame, Vec3::ONE);
            canvas.sky_thing(&mesh, &placed, &thing);
        }
    }

    fn building(&mut self, block: BlockId, index: u32, model: u32, canvas: &mut impl Canvas) {
        let scene = self.scene;
        let found = scene.world.loaded_block(block);
        let Some(building) = found.and_then(|b| b.buildings.get(index as usize)) else {
            self.missing();
            return;
        };
        let part = building.shape.parts.first();
        let shell = part.and_then(|p| p.model.as_deref());
        let Some((mesh, part)) = shell
            .and_then(|s| scene.assets.model(scene.world, model, Some(s)))
            .zip(part)
        else {
            self.missing();
            return;
        };
        let frame = building.part_frames.first().copied().unwrap_or(building.frame);
        canvas.piece(&Piece {
            mesh: &mesh,
            placed: &self.eye.place(block, &frame, part.scale),
            owner: Owner {
                kind: PixelKind::Building,
                cell: building.cell,
                item: None,
            },
            light: PieceLight::Sun,
            opacity: 1.0,
            edges: &[],
        });
    }

    /// Where the lamps of a cell are in the list.
    fn lamps_of(&mut self, id: CellId) -> (usize, usize) {
        if let Some(&(_, range)) = self.known.iter().rev().find(|(known, _)| *known == id) {
            return range;
        }
        let first = self.lamps.len();
        if let Some(cell) = self.scene.world.env_cell(id).filter(|_| self.lit) {
            let placed = self.eye.place_block(id.block());
            let lamps = self.scene.assets.lamps(self.scene.world, cell);
            self.lamps.extend(lamps.iter().map(|l| Lamp {
                position: placed.point(l.position).as_vec3(),
                ..*l
            }));
        }
        let range = (first, self.lamps.len());
        self.known.push((id, range));
        range
    }

    fn room(&mut self, id: CellId, edges: &[DVec3], canvas: &mut impl Canvas) {
        let scene = self.scene;
        let cell = scene.world.env_cell(id);
        let shell = cell.and_then(|c| Some((c, scene.assets.cell_shell(scene.world, c)?)));
        let Some((cell, mesh)) = shell else {
            self.missing();
            return;
        };
        let (first, end) = self.lamps_of(id);
        canvas.piece(&Piece {
            mesh: &mesh,
            placed: &self.eye.place(id.block(), &cell.frame, Vec3::ONE),
            owner: Owner {
                kind: PixelKind::Room,
                cell: id,
                item: None,
            },
            light: PieceLight::Shell {
                cell: id,
                lamps: &self.lamps[first..end],
            },
            opacity: 1.0,
            edges,
        });
    }

    fn object(&mut self, id: ObjectRef, cell: CellId, edges: &[DVec3], canvas: &mut impl Canvas) {
        match id {
            ObjectRef::Static(id) => self.static_object(id, cell, edges, canvas),
            ObjectRef::Body(id) => self.body(id, cell, edges, canvas),
        }
    }

    fn static_object(&mut self, id: StaticRef, cell: CellId, edges: &[DVec3], canvas: &mut impl Canvas) {
        let Some(object) = self.scene.world.static_object(id) else {
            self.missing();
            return;
        };
        let thing = Thing {
            owner: Owner {
                kind: PixelKind::Object,
                cell: object.cell,
                item: Some(id.index),
            },
            block: object.cell.block(),
            listed_in: cell,
            opacity: 1.0,
            edges,
        };
        for (part, frame) in object.shape.parts.iter().zip(&object.part_frames) {
            self.part(&thing, part.model_id, frame, part.scale, canvas);
        }
    }

    fn body(&mut self, id: BodyId, cell: CellId, edges: &[DVec3], canvas: &mut impl Canvas) {
        let scene = self.scene;
        let Some(body) = scene.population.and_then(|p| p.body(id)) else {
            self.missing();
            return;
        };
        let opacity = if scene.player == Some(id) {
            scene.player_opacity
        } else {
            1.0
        };
        if !(opacity > 0.0) {
            return;
        }
        let position = body.position();
        let thing = Thing {
            owner: Owner {
                kind: PixelKind::Object,
                cell: body.cell().unwrap_or(position.cell),
                item: Some(BODY_ITEM),
            },
            block: position.cell.block(),
            listed_in: cell,
            opacity,
            edges,
        };
        let shape = body.shape();
        let mut parts = shape.parts.iter().zip(body.part_frames()).peekable();
        if parts.peek().is_some() {
            for (part, frame) in parts {
                self.part(&thing, part.model_id, frame, part.scale * body.scale(), canvas);
            }
            return;
        }
        let tops = shape.spheres.iter().map(|s| s.center.z + s.radius);
        let tallest = tops.fold(shape.height, |a, b| if b > a { b } else { a });
        let height = if tallest > 0.1 { tallest } else { FIGURE_HEIGHT };
        let scale = Vec3::splat(height / FIGURE_HEIGHT * body.scale());
        let placed = self.eye.place(thing.block, &position.frame, scale);
        self.lit(&thing, &figure(), &placed, canvas);
    }

    /// Draws a part of an object at the level for its distance, turned to the viewer if the level says so
    /// (`rendering.md` 17.1).
    fn part(&mut self, thing: &Thing<'_>, model: u32, frame: &Frame, scale: Vec3, canvas: &mut impl Canvas) {
        let eye = self.eye.eye_in(thing.block).as_vec3();
        // Within the 50 m in which parts have distances of their own everything is drawn in full.
        let gap = frame.origin - eye;
        let distance = libm::sqrtf(gap.dot(gap)) / scale.z;
        let (scene, quality) = (self.scene, self.settings.detail);
        let level = scene.assets.model_level(scene.world, model, distance, quality);
        let Some(model) = level.model else { return };
        let Some(mesh) = scene.assets.model(scene.world, model, None) else {
            self.missing();
            return;
        };
        let frame = turned(frame, eye, level.mode);
        let placed = self.eye.place(thing.block, &frame, scale);
        self.lit(thing, &mesh, &placed, canvas);
    }

    fn lit(&mut self, thing: &Thing<'_>, mesh: &Arc<Mesh>, placed: &Placed, canvas: &mut impl Canvas) {
        let mut near = [0u8; MAX_OBJECT_LAMPS];
        let light = if self.light == LightSet::Sun {
            PieceLight::Sun
        } else {
            let (first, end) = self.lamps_of(thing.listed_in);
            let lamps = &self.lamps[first..end];
            let count = nearest(lamps, mesh, placed, &mut near);
            PieceLight::Indoor {
                cell: thing.listed_in,
                lamps,
                near: &near[..count],
            }
        };
        canvas.piece(&Piece {
            mesh,
            placed,
            owner: thing.owner,
            light,
            opacity: thing.opacity,
            edges: thing.edges,
        });
    }
}

/// An object whose parts are being drawn.
struct Thing<'t> {
    owner: Owner,
    block: BlockId,
    /// The cell whose lamps light it.
    listed_in: CellId,
    opacity: f32,
    edges: &'t [DVec3],
}

/// The lamps that reach a mesh, nearest first (`rendering.md` 12.1); returns how many.
fn nearest(lamps: &[Lamp], mesh: &Mesh, placed: &Placed, out: &mut [u8; MAX_OBJECT_LAMPS]) -> usize {
    let middle = placed.point(mesh.sphere.center).as_vec3();
    let mut found = [0.0f32; MAX_OBJECT_LAMPS];
    let mut count = 0;
    for (k, lamp) in lamps.iter().enumerate().take(usize::from(u8::MAX)) {
        let gap = lamp.position - middle;
        let square = gap.dot(gap);
        let reach = lamp.falloff * OBJECT_RANGE + mesh.sphere.radius;
        if !(square < reach * reach) {
            continue;
        }
        let at = found[..count]
            .iter()
            .position(|&other| square < other)
            .unwrap_or(count);
        if at == MAX_OBJECT_LAMPS {
            continue;
        }
        count = (count + 1).min(MAX_OBJECT_LAMPS);
        found[at..count].rotate_right(1);
        out[at..count].rotate_right(1);
        (found[at], out[at]) = (square, k as u8);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use vestibule_view::Camera;

    #[test]
    fn r12_1_the_eight_nearest_lamps_that_reach() {
        let camera = Camera::new(
            CellId(0xA9B4_0101),
            Vec3::ZERO,
            Vec3::Y,
            Vec3::Z,
            1.0,
            glam::Vec2::splat(64.0),
        )
        .unwrap();
        let eye = EyeFrame::new(&camera);
        let placed = eye.place_block(BlockId(0xA9B4));
        let mesh = Mesh {
            sphere: vestibule_world::Sphere {
                center: Vec3::ZERO,
                radius: 1.0,
            },
            ..Mesh::default()
        };
        let lamp = |x: f32, falloff: f32| Lamp {
            position: Vec3::new(x, 0.0, 0.0),
            color: Vec3::ONE,
            intensity: 1.0,
            falloff,
        };
        let mut lamps: Vec<Lamp> = (0..10).map(|k| lamp(11.0 - k as f32, 20.0)).collect();
        lamps.push(lamp(0.5, 20.0));
        // Reaches 1.5 * 2 + 1 m.
        lamps.push(lamp(4.0, 2.0));
        let mut near = [0; MAX_OBJECT_LAMPS];
        assert_eq!(nearest(&lamps, &mesh, &placed, &mut near), 8);
        assert_eq!(near, [10, 9, 8, 7, 6, 5, 4, 3]);
        assert_eq!(
            nearest(&lamps[11..], &mesh, &placed, &mut near),
            0,
            "strictly nearer"
        );
    }
}
