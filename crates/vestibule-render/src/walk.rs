//! The walk over a picture's commands (`rendering.md` 5, 6): what is drawn, where it lies for the eye and what lights
//! it. Every renderer walks this way and only draws.

mod objects;

use std::sync::Arc;

use glam::{DVec3, Quat, Vec3};
use vestibule_view::{Command, LightSet, PolygonRef, SealDepth, Views};
use vestibule_world::{BlockId, CellId, Frame};

use crate::cell_lamps::CellLamps;
use crate::lighting::Lamp;
use crate::mesh::Mesh;
use crate::model_table::ModelTable;
use crate::overlaps::overlapping_cells;
use crate::picture::Picture;
use crate::place::{EyeFrame, Placed};
use crate::raster::PixelKind;
use crate::scene::{LightDetail, RenderSettings, Scene};
use crate::sky::SkyThing;
use crate::static_parts::StaticParts;

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
        /// Positions of those that reach the object, nearest first; [`MAX_OBJECT_LAMPS`](crate::MAX_OBJECT_LAMPS) at most.
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

/// What a walk keeps for the next one: static objects resolved to parts, models to meshes, and memory. Keep one beside
/// each renderer; it follows what is loaded and forgets everything when the scene has other [`Assets`](crate::Assets).
#[derive(Debug, Default)]
pub struct WalkMemory {
    /// Whose they are, by [`Assets::serial`](crate::Assets).
    assets: u64,
    statics: StaticParts,
    models: ModelTable,
    lamps: CellLamps,
    points: Vec<DVec3>,
}

impl WalkMemory {
    /// Nothing kept yet.
    pub fn new() -> Self {
        Self::default()
    }

    fn begin(&mut self, scene: &Scene<'_>) {
        if self.assets != scene.assets.serial() {
            *self = WalkMemory {
                assets: scene.assets.serial(),
                ..WalkMemory::default()
            };
        }
        self.statics.begin();
        self.lamps.clear();
        self.points.clear();
    }
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
    memory: &'a mut WalkMemory,
}

impl<'a> Walk<'a> {
    /// A walk that has not begun.
    pub fn new(
        scene: &'a Scene<'a>,
        settings: &'a RenderSettings,
        picture: &'a Picture<'a>,
        memory: &'a mut WalkMemory,
    ) -> Self {
        memory.begin(scene);
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
            memory,
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
                    canvas.behind_exit(&self.memory.points);
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
                canvas.portal(&self.memory.points, PortalDepth::Punch);
            }
            Command::Seal { polygon, depth, .. } => {
                self.see(polygon);
                let depth = match depth {
                    SealDepth::Nearest => PortalDepth::Nearest,
                    SealDepth::True => PortalDepth::Own,
                };
                canvas.portal(&self.memory.points, depth);
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
        let points = &mut self.memory.points;
        points.clear();
        let Some(frame) = self.picture.frame else { return };
        let seen = frame.polygon(polygon).iter();
        points.extend(seen.map(|p| self.eye.turn(p.as_dvec3())));
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

    fn room(&mut self, id: CellId, edges: &[DVec3], canvas: &mut impl Canvas) {
        let scene = self.scene;
        let cell = scene.world.env_cell(id);
        let shell = cell.and_then(|c| Some((c, scene.assets.cell_shell(scene.world, c)?)));
        let Some((cell, mesh)) = shell else {
            self.missing();
            return;
        };
        let lamps = match self.lit {
            true => self.memory.lamps.of(scene, &self.eye, id),
            false => &[],
        };
        canvas.piece(&Piece {
            mesh: &mesh,
            placed: &self.eye.place(id.block(), &cell.frame, Vec3::ONE),
            owner: Owner {
                kind: PixelKind::Room,
                cell: id,
                item: None,
            },
            light: PieceLight::Shell { cell: id, lamps },
            opacity: 1.0,
            edges,
        });
    }
}
