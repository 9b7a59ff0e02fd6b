//! The frame: what to draw and in which order, as a value (`rendering.md` 2, 5, 6; `visibility.md` 15.2a).
//!
//! [`FrameView`] holds the decision of one frame for one viewer. A renderer walks [`FrameView::commands`] from first
//! to last and needs to know no rule: each command names what to draw, in ids, and the value has the regions and
//! polygons that go with it. `examples/print_frame.rs` prints one.
//!
//! All polygons and regions are relative to the eye, in the axes of the landscape (x east, y north, z up), metres.

mod interior;
mod landscape;

use glam::Vec3;
use vestibule_physics::ObjectRef;
use vestibule_world::{BlockId, CellId, World};

use crate::camera::{Camera, CameraError};
use crate::constants::{MAX_EDGES, NEAR_PLANE};
use crate::flood::{Flood, FloodArena, FloodCounters, FloodSettings};
use crate::frame_source::FrameSource;
use crate::look_in::LookIns;
use crate::number_map::NumberMap;
use crate::openings::Openings;
use crate::pview::PView;
use crate::view::{Edge, Region, full_view};
use crate::viewer::{PlayerCell, ViewerCell};

/// Which way a frame is drawn (retail `RenderNormalMode`, `rendering.md` 2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FramePath {
    /// From outdoors: the landscape through the whole screen, looks into buildings.
    Outdoors,
    /// From a room that is marked to see the outside: the rooms, and the landscape through the exits in view.
    SeesOut,
    /// From a sealed room: the rooms; the landscape only if an exit is in view all the same.
    Sealed,
    /// There is nothing to draw but sky and fog colour, and why.
    #[default]
    Nothing,
}

/// The light that what follows is drawn with (`rendering.md` 1.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSet {
    /// Sun and ambient light, no lamps.
    Sun,
    /// Lamps and ambient light, no sun.
    Indoor,
}

/// The regions that confine what a command draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Views {
    /// The active views of the landscape: the whole screen from outdoors, else the regions of the outside.
    Landscape,
    /// The views of a cell in one traversal.
    Cell {
        /// The traversal, for [`FrameView::floods`].
        flood: u32,
        /// Position of the cell in it.
        cell: u32,
    },
}

/// A convex polygon of the frame, for [`FrameView::polygon`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolygonRef {
    first: u32,
    count: u32,
}

/// What a seal writes to the depth buffer (`rendering.md` 7.6a).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SealDepth {
    /// The depth of the polygon itself.
    True,
    /// The nearest depth there is: this part lies before the near plane.
    Nearest,
}

/// One step of drawing a frame. Opaque by default: test "nearer or equal", depth write on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Use this light set from here on.
    Light(LightSet),
    /// Draw the sky: depth test always, no depth writes (`rendering.md` 16.4).
    Sky,
    /// Draw the two triangles of a land cell, 0.01 m lower than they are (`rendering.md` 6.6).
    Terrain(CellId),
    /// Draw the terrain of a distant landblock from every `stride`-th vertex (`world.md` 4.4).
    TerrainBlock {
        /// The landblock.
        block: BlockId,
        /// 2, 4 or 8.
        stride: u8,
    },
    /// Draw what was put aside as see-through: cut-outs, then blended (`rendering.md` 14.7).
    FlushAlpha,
    /// Fill a door's opening with the farthest depth but one, no colour, depth test always (`rendering.md` 7.2).
    Punch {
        /// The opening as seen.
        polygon: PolygonRef,
        /// Landblock of the building.
        block: BlockId,
        /// Position among the landblock's buildings.
        building: u32,
        /// The portal.
        portal: u16,
    },
    /// Draw a building's shell, sun lit.
    Building {
        /// Landblock of the building.
        block: BlockId,
        /// Position among the landblock's buildings.
        building: u32,
        /// The model chosen for its distance.
        model: u32,
    },
    /// Draw a room's own polygons, whole (`rendering.md` 5.5). A room is drawn once between two
    /// [`Command::NextStamp`].
    Room {
        /// The room.
        cell: CellId,
        /// Where it shows.
        views: Views,
    },
    /// Draw an object, whole.
    Object {
        /// The object.
        id: ObjectRef,
        /// The cell it is listed in.
        cell: CellId,
        /// Where it shows.
        views: Views,
    },
    /// What was drawn before may be drawn again from here on (`rendering.md` 5.3).
    NextStamp,
    /// Clear the depth buffer, keep the colours (`rendering.md` 5.2 step 6).
    ClearDepth,
    /// Write an exit's depth, no colour, depth test always, so that rooms behind it do not cover the landscape
    /// (`rendering.md` 7.5).
    Seal {
        /// The part of the opening to write.
        polygon: PolygonRef,
        /// With which depth.
        depth: SealDepth,
        /// The room.
        cell: CellId,
        /// Record index of the portal.
        portal: u16,
    },
    /// Draw weather: only when it is on and the **player** is outdoors (`rendering.md` 16.4).
    Weather,
}

/// How frames are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameSettings {
    /// How the traversal decides.
    pub flood: FloodSettings,
    /// Rings of landblocks around the viewer's that are drawn (`world.md` L1). 0…32.
    pub block_radius: i32,
    /// Rings of landblocks in full detail: land cells one by one (`world.md` 4.4; retail 1).
    pub full_detail_rings: i32,
    /// Rings whose buildings and objects are drawn (`rendering.md` 11.3).
    pub object_rings: i32,
    /// Load landblocks that are in reach but not loaded. Off, they are left out and counted.
    pub load_blocks: bool,
}

impl Default for FrameSettings {
    fn default() -> Self {
        FrameSettings {
            flood: FloodSettings::default(),
            block_radius: 5,
            full_detail_rings: 1,
            object_rings: 4,
            load_blocks: true,
        }
    }
}

/// Who looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInput {
    /// The eye. Its cell is that of the viewer's position and is tested for being indoors.
    pub camera: Camera,
    /// The cell the viewer's sweep ended in; `None` when it was lost. Decides the frame together with the camera's
    /// cell, never the player's (`rendering.md` 2.4).
    pub viewer_cell: Option<ViewerCell>,
    /// The player's cell: for weather, and to fall back on when the viewer's is lost.
    pub player_cell: Option<PlayerCell>,
    /// Whether weather is on.
    pub weather: bool,
}

impl FrameInput {
    /// A viewer whose cell is the camera's, without a player.
    pub fn new(camera: Camera) -> Self {
        FrameInput {
            camera,
            viewer_cell: Some(ViewerCell(camera.cell())),
            player_cell: None,
            weather: false,
        }
    }
}

/// What happened while a frame was made, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameCounters {
    /// All traversals of the frame together.
    pub flood: FloodCounters,
    /// Traversals that reached a limit.
    pub truncated: u32,
    /// The viewer's cell was lost and the player's was used (`rendering.md` 2.2).
    pub fell_back_to_player: u32,
    /// The viewer's and the player's cell were lost and the last frame's was used.
    pub fell_back_to_last: u32,
    /// No cell was left to start from: sky and fog colour only.
    pub nothing_to_draw: u32,
    /// Exits in view from a room that is not marked to see the outside (`visibility.md` 7.5).
    pub unmarked_exits: u32,
    /// Doors in view whose room is not loaded.
    pub dead_doors: u32,
    /// Landblocks in reach that are not loaded or do not exist.
    pub missing_blocks: u32,
    /// Cameras that could not be made; the frame before is kept ([`FrameView::keep`]).
    pub kept: u32,
}

/// The frame of one viewer: the order of drawing and everything it refers to. Reused from frame to frame; nothing
/// is allocated once it has met its largest frame. For several viewers keep one each.
///
/// ```no_run
/// use vestibule_view::{Command, FrameInput, FrameView, Openings, WorldObjects};
/// # fn demo(world: vestibule_world::World, camera: vestibule_view::Camera) {
/// let openings = Openings::new();
/// let mut frame = FrameView::default();
/// frame.update(&world, &openings, &WorldObjects::new(&world), &FrameInput::new(camera));
/// for command in frame.commands() {
///     match command {
///         Command::Room { cell, .. } => println!("room {cell}"),
///         other => println!("{other:?}"),
///     }
/// }
/// # }
/// ```
#[derive(Debug)]
pub struct FrameView {
    settings: FrameSettings,
    pview: PView,
    path: FramePath,
    camera: Option<Camera>,
    last_cell: Option<CellId>,
    viewpoint: Option<CellId>,
    has_interior: bool,
    floods: FloodArena,
    look_ins: LookIns,
    /// Edges of the active views of the landscape, and where each begins.
    active_edges: Vec<Edge>,
    active: Vec<(u32, u32)>,
    commands: Vec<Command>,
    points: Vec<Vec3>,
    counters: FrameCounters,
    scratch: Scratch,
}

/// Reused lists.
#[derive(Debug, Default)]
struct Scratch {
    stamp: u32,
    /// Stamp with which each room and object was last drawn. Only looked up, never walked.
    rooms: NumberMap<CellId, u32>,
    objects: NumberMap<ObjectRef, u32>,
    sorted: Vec<(u32, u32, ObjectRef)>,
    block_rings: Vec<(i32, i32)>,
    /// For each land cell that may be the nearest of its block, the block's cells far to near; made with the first frame.
    cell_orders: Vec<[(u8, u8); 64]>,
    clip: Vec<Vec3>,
    clip_spare: Vec<Vec3>,
}

impl Default for FrameView {
    fn default() -> Self {
        Self::new(FrameSettings::default())
    }
}

impl FrameView {
    /// An empty frame.
    pub fn new(settings: FrameSettings) -> Self {
        let mut settings = settings;
        settings.block_radius = settings.block_radius.clamp(0, 32);
        FrameView {
            settings,
            pview: PView::new(settings.flood),
            path: FramePath::Nothing,
            camera: None,
            last_cell: None,
            viewpoint: None,
            has_interior: false,
            floods: FloodArena::new(),
            look_ins: LookIns::new(),
            active_edges: Vec::with_capacity(16 * MAX_EDGES),
            active: Vec::new(),
            commands: Vec::new(),
            points: Vec::new(),
            counters: FrameCounters::default(),
            scratch: Scratch::default(),
        }
    }

    /// Decides the frame of a viewer (retail `RenderNormalMode`). Returns the path taken; everything else is read
    /// from the value.
    pub fn update(
        &mut self,
        world: &World,
        openings: &Openings,
        source: &dyn FrameSource,
        input: &FrameInput,
    ) -> FramePath {
        self.begin(input);
        let indoors = input.camera.cell().is_indoor();
        let root = if indoors {
            self.root_cell(world, input)
        } else {
            Some(input.camera.cell())
        };
        match root {
            None => self.draw_nothing(),
            Some(root) => {
                let camera = input.camera.in_cell(root);
                self.camera = Some(camera);
                self.last_cell = Some(root);
                if root.is_indoor() {
                    self.draw_inside(world, openings, source, input, &camera);
                } else {
                    self.draw_outdoors(world, openings, source, input, &camera);
                }
            }
        }
        self.commands.push(Command::FlushAlpha);
        for flood in self.floods.iter() {
            self.counters.flood.add(flood.counters());
            self.counters.truncated += u32::from(flood.truncated());
        }
        self.counters.dead_doors = self.look_ins.dead_doors;
        self.path
    }

    /// Keeps the last frame because no camera could be made, and counts it (`visibility.md` 14.9).
    pub fn keep(&mut self, _reason: CameraError) -> FramePath {
        self.counters.kept += 1;
        self.path
    }

    fn begin(&mut self, input: &FrameInput) {
        self.path = FramePath::Nothing;
        self.camera = Some(input.camera);
        self.viewpoint = None;
        self.has_interior = false;
        self.floods.clear();
        self.look_ins.clear();
        self.active_edges.clear();
        self.active.clear();
        self.commands.clear();
        self.points.clear();
        self.counters = FrameCounters::default();
        self.scratch.next_stamp();
    }

    /// The cell an indoor viewer's frame starts from (`rendering.md` 2.2).
    fn root_cell(&mut self, world: &World, input: &FrameInput) -> Option<CellId> {
        let usable = |id: CellId| world.is_resident(id).then_some(id);
        if let Some(found) = input.viewer_cell.and_then(|c| usable(c.0)) {
            return Some(found);
        }
        if let Some(found) = input.player_cell.and_then(|c| usable(c.0)) {
            self.counters.fell_back_to_player += 1;
            return Some(found);
        }
        if let Some(found) = self.last_cell.and_then(usable) {
            self.counters.fell_back_to_last += 1;
            return Some(found);
        }
        None
    }

    fn draw_nothing(&mut self) {
        self.counters.nothing_to_draw += 1;
        self.commands.push(Command::Light(LightSet::Sun));
        self.commands.push(Command::Sky);
    }

    fn draw_outdoors(
        &mut self,
        world: &World,
        openings: &Openings,
        source: &dyn FrameSource,
        input: &FrameInput,
        camera: &Camera,
    ) {
        self.path = FramePath::Outdoors;
        self.add_active(&full_view(camera));
        self.commands.push(Command::Light(LightSet::Sun));
        self.draw_landscape(world, openings, source, input, camera);
    }

    fn add_active(&mut self, edges: &[Edge]) {
        self.active
            .push((self.active_edges.len() as u32, edges.len() as u32));
        self.active_edges.extend_from_slice(edges);
    }

    /// Which way the frame is drawn.
    pub fn path(&self) -> FramePath {
        self.path
    }

    /// The camera, in the cell the frame was drawn from. `None` before the first frame.
    pub fn camera(&self) -> Option<&Camera> {
        self.camera.as_ref()
    }

    /// The steps of drawing, in order. The screen is to be cleared first.
    pub fn commands(&self) -> &[Command] {
        &self.commands
    }

    /// The rooms seen from a room; `None` from outdoors.
    pub fn interior(&self) -> Option<Flood<'_>> {
        if self.has_interior {
            self.floods.get(0)
        } else {
            None
        }
    }

    /// All traversals: the interior first if there is one, then those behind the doors of buildings.
    pub fn floods(&self) -> &FloodArena {
        &self.floods
    }

    /// The doors that are looked into, with their punches.
    pub fn look_ins(&self) -> &LookIns {
        &self.look_ins
    }

    /// The views the landscape is drawn through; none when it is not drawn.
    pub fn landscape_views(&self) -> impl ExactSizeIterator<Item = Region<'_>> + Clone {
        active_regions(&self.active_edges, &self.active)
    }

    /// The land cell the landscape is drawn around, when it is drawn.
    pub fn viewpoint(&self) -> Option<CellId> {
        self.viewpoint
    }

    /// Whether the landscape is drawn.
    pub fn draws_landscape(&self) -> bool {
        self.viewpoint.is_some()
    }

    /// The regions a command is confined to.
    pub fn regions(&self, views: Views) -> impl Iterator<Item = Region<'_>> + Clone {
        let (landscape, cell) = match views {
            Views::Landscape => (Some(self.landscape_views()), None),
            Views::Cell { flood, cell } => {
                let flood = self.floods.get(flood as usize);
                let regions = flood.and_then(|f| f.cells().get(cell as usize).map(|c| f.regions(c)));
                (None, regions)
            }
        };
        landscape.into_iter().flatten().chain(cell.into_iter().flatten())
    }

    /// The corners of a convex polygon, relative to the eye, metres. Draw both faces: its winding says nothing. A
    /// punch has the direction of each corner at 1 m instead: its depth is constant.
    pub fn polygon(&self, polygon: PolygonRef) -> &[Vec3] {
        let first = polygon.first as usize;
        self.points
            .get(first..first + polygon.count as usize)
            .unwrap_or(&[])
    }

    /// What was counted.
    pub fn counters(&self) -> &FrameCounters {
        &self.counters
    }

    /// The settings in use.
    pub fn settings(&self) -> &FrameSettings {
        &self.settings
    }

    /// The distance of the near plane seals are cut at, metres.
    fn near(camera: &Camera) -> f32 {
        if camera.near() > 0.0 {
            camera.near()
        } else {
            NEAR_PLANE
        }
    }
}

impl Scratch {
    fn next_stamp(&mut self) {
        if self.stamp == u32::MAX || self.rooms.len() > MAX_REMEMBERED || self.objects.len() > MAX_REMEMBERED
        {
            self.rooms.clear();
            self.objects.clear();
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// Marks a room as drawn; false when it was already drawn with this stamp.
    fn first_room(&mut self, cell: CellId) -> bool {
        self.rooms.insert(cell, self.stamp) != Some(self.stamp)
    }

    fn first_object(&mut self, id: ObjectRef) -> bool {
        self.objects.insert(id, self.stamp) != Some(self.stamp)
    }
}

/// Rooms and objects whose stamps are kept; beyond that all are forgotten, which costs nothing but memory.
const MAX_REMEMBERED: usize = 1 << 16;

fn active_regions<'a>(
    edges: &'a [Edge],
    active: &'a [(u32, u32)],
) -> impl ExactSizeIterator<Item = Region<'a>> + Clone + use<'a> {
    active.iter().map(move |&(first, count)| {
        Region::new(edges.get(first as usize..(first + count) as usize).unwrap_or(&[]))
    })
}
