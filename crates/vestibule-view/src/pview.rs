//! The portal traversal: which cells are seen from a cell, and through which regions (`visibility.md` 5-7, 12-14).
//!
//! A best-first worklist hands views from cell to cell through the openings the eye is in front of; a cell that was
//! finished before a further view reached it is repaired at once. Nothing is allocated once the scratch has met its
//! largest landblock, and the order of the data decides all ties.

pub(crate) mod clip;
mod repair;
mod result;
mod views;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec3;
use vestibule_world::{CellId, World};

use self::clip::is_in;
use crate::camera::{Camera, FARTHEST_EYE};
use crate::constants::{EPSILON, MAX_EDGES_RETAIL, MAX_VIEWS, WRONG_CELL_MARGIN};
use crate::flood::{Flood, FloodArena, FloodCounters, FloodRecord, FloodSettings};
use crate::openings::{BlockOpenings, NONE, Openings, Target};
use crate::view::{ClipPolygon, Edge, full_view, upper};

/// Stands for the outside where a room is expected.
const OUTSIDE: u32 = NONE - 1;

/// Moves in the list of one flood; the order is a heuristic, a list that long is left as it is.
const MAX_MOVES: u32 = 4096;
/// Repairs nested deeper than this wait in the todo list instead.
const MAX_REPAIR_DEPTH: u32 = 64;

// Flags of a portal during a flood (`visibility.md` 2.5).
const IN: u8 = 1;
const SEEN_IN: u8 = 2;
const DEAD_COUNTED: u8 = 4;
const ON_PLANE_COUNTED: u8 = 8;
const ON_PLANE_INSIDE: u8 = 16;

/// A view while the flood runs.
#[derive(Clone, Copy, Debug)]
struct View {
    room: u32,
    parent: u32,
    /// Portal it came through, among all portals of the landblock.
    portal: u32,
    /// Next view of the same room.
    next: u32,
    first_edge: u32,
    edge_count: u16,
    hops: u16,
}

/// Views of one room or of the outside, in order of arrival.
#[derive(Clone, Copy, Debug)]
struct ViewList {
    head: u32,
    tail: u32,
    count: u32,
    saturated: bool,
}

const NO_VIEWS: ViewList = ViewList {
    head: NONE,
    tail: NONE,
    count: 0,
    saturated: false,
};

/// A room during a flood (retail `portal_view`).
#[derive(Clone, Copy, Debug)]
struct RoomState {
    stamp: u32,
    views: ViewList,
    /// First view not yet handed on.
    pending: u32,
    /// Whether a view came since neighbours last told this room of theirs (retail `update_count != view_count`).
    /// A room in the queue can have views to hand on and yet none of them new.
    news: bool,
    scheduled: bool,
    done: bool,
    key: f32,
    position: u32,
    reached_from: u32,
    /// The repair in which the room was moved last.
    moved_in: u32,
}

const UNTOUCHED: RoomState = RoomState {
    stamp: 0,
    views: NO_VIEWS,
    pending: NONE,
    news: false,
    scheduled: false,
    done: false,
    key: 0.0,
    position: NONE,
    reached_from: NONE,
    moved_in: 0,
};

#[derive(Clone, Copy, Debug, Default)]
struct PortalState {
    flags: u8,
    /// Signed distance of the eye from the plane, metres.
    dist: f32,
}

/// Rays from the eye to the corners of a piece.
#[derive(Clone, Copy, Debug, Default)]
struct PieceState {
    stamp: u32,
    first: u32,
    count: u16,
    has_normals: bool,
}

/// Working memory of the traversal (retail `PView`): owned by the caller, one per thread, reused from frame to
/// frame.
///
/// [`PView::look`] is the whole of it for a viewer in a room. The frame of a viewer anywhere, with looks into
/// buildings, is [`crate::FrameView`].
#[derive(Debug)]
pub struct PView {
    settings: FloodSettings,
    stamp: u32,
    repair: u32,
    /// Repairs of finished rooms under way, one inside the other.
    depth: u32,
    rooms: Vec<RoomState>,
    portals: Vec<PortalState>,
    pieces: Vec<PieceState>,
    /// Corners and sides of the pieces met so far.
    rays: Vec<Edge>,
    door_rays: Vec<Edge>,
    views: Vec<View>,
    edges: Vec<Edge>,
    outside: ViewList,
    todo: BinaryHeap<Reverse<(u32, u32, u32)>>,
    inserted: u32,
    list: Vec<u32>,
    /// Moves in the list still to make: before which room, and which.
    moves: Vec<(u32, u32)>,
    polygon: Box<ClipPolygon>,
    far: Box<ClipPolygon>,
    /// Where each view went in the result.
    placed: Vec<u32>,
    counters: FloodCounters,
    truncated: bool,
    results: FloodArena,
}

impl Default for PView {
    fn default() -> Self {
        Self::new(FloodSettings::default())
    }
}

/// Where a flood starts.
pub(crate) struct Start<'a> {
    pub(crate) room: u32,
    /// The portal by which the view came in, among all portals of the landblock, or [`NONE`].
    pub(crate) entry: u32,
    /// The first view of the room; none for a viewer who looks everywhere.
    pub(crate) view: &'a [Edge],
    /// Whether exits add to the outside (retail `draw_landscape`).
    pub(crate) to_outside: bool,
    /// Rooms the stab gate lets in besides the start; ascending.
    pub(crate) stabs: &'a [u32],
}

/// What a flood needs to know and does not change.
struct Scene<'a> {
    openings: &'a BlockOpenings,
    /// Landblock frame.
    eye: Vec3,
    camera: Option<&'a Camera>,
    start: &'a Start<'a>,
}

impl PView {
    /// Working memory for traversals with these settings.
    pub fn new(settings: FloodSettings) -> Self {
        let mut settings = settings;
        settings.max_edges = settings.max_edges.clamp(4, MAX_EDGES_RETAIL);
        if !(settings.min_px >= 0.0 && settings.min_px.is_finite()) {
            settings.min_px = 0.0;
        }
        PView {
            settings,
            stamp: 0,
            repair: 0,
            depth: 0,
            rooms: Vec::new(),
            portals: Vec::new(),
            pieces: Vec::new(),
            rays: Vec::new(),
            door_rays: Vec::new(),
            views: Vec::with_capacity(MAX_VIEWS),
            edges: Vec::with_capacity(MAX_VIEWS * settings.max_edges),
            outside: NO_VIEWS,
            todo: BinaryHeap::new(),
            inserted: 0,
            list: Vec::new(),
            moves: Vec::new(),
            polygon: Box::default(),
            far: Box::default(),
            placed: Vec::with_capacity(MAX_VIEWS),
            counters: FloodCounters::default(),
            truncated: false,
            results: FloodArena::default(),
        }
    }

    /// The settings in use.
    pub fn settings(&self) -> &FloodSettings {
        &self.settings
    }

    /// What a camera in a room sees (retail `DrawInside`'s `ConstructView`, `visibility.md` 5, 9.1).
    ///
    /// The result lists the camera's cell first. A camera whose cell is outdoors or not loaded sees nothing, which
    /// [`FloodCounters::missing_root`] tells.
    pub fn look(&mut self, world: &World, openings: &Openings, camera: &Camera) -> Flood<'_> {
        self.look_in_block(openings.block(world, camera.cell().block()), camera)
    }

    /// As [`PView::look`], in the compiled openings of one landblock.
    pub fn look_in_block(&mut self, openings: Option<&BlockOpenings>, camera: &Camera) -> Flood<'_> {
        let full = full_view(camera);
        self.root_flood(openings, camera.cell(), camera.eye(), &full, Some(camera))
    }

    /// What can be seen from a point in a room in any direction: for servers and tools that have no camera.
    /// `eye` is in the frame of the cell's landblock, metres. A point that is not finite sees nothing.
    pub fn look_around(&mut self, openings: Option<&BlockOpenings>, cell: CellId, eye: Vec3) -> Flood<'_> {
        let openings = openings.filter(|_| eye.is_finite() && eye.abs().max_element() <= FARTHEST_EYE);
        self.root_flood(openings, cell, eye, &[], None)
    }

    fn root_flood(
        &mut self,
        openings: Option<&BlockOpenings>,
        cell: CellId,
        eye: Vec3,
        view: &[Edge],
        camera: Option<&Camera>,
    ) -> Flood<'_> {
        let mut results = core::mem::take(&mut self.results);
        results.clear();
        self.flood_from_cell(openings, cell, eye, view, camera, &mut results);
        self.results = results;
        self.results.last()
    }

    /// Floods from a cell and appends the result, an empty one when the cell is not loaded.
    pub(crate) fn flood_from_cell(
        &mut self,
        openings: Option<&BlockOpenings>,
        cell: CellId,
        eye: Vec3,
        view: &[Edge],
        camera: Option<&Camera>,
        results: &mut FloodArena,
    ) {
        self.counters = FloodCounters::default();
        let found = openings.and_then(|o| Some((o, o.room_of(cell)?)));
        let Some((openings, mut room)) = found else {
            let counters = FloodCounters {
                missing_root: 1,
                ..FloodCounters::default()
            };
            results.floods.push(FloodRecord {
                cells: (results.cells.len() as u32, 0),
                views: (results.views.len() as u32, 0),
                outside: (0, 0),
                seals: (results.seals.len() as u32, 0),
                counters,
                truncated: false,
            });
            return;
        };
        if self.settings.guard_wrong_cell
            && let Some(other) = better_root(openings, room, eye)
        {
            room = other;
            self.counters.wrong_cell += 1;
        }
        let stabs = &openings.rooms[room as usize].stabs;
        let start = Start {
            room,
            entry: NONE,
            view,
            to_outside: true,
            stabs,
        };
        self.flood(openings, eye, camera, &start, results);
    }

    /// The flood of `visibility.md` 5. Appends the result to `results`. Counters of the caller, set beforehand, are
    /// kept.
    pub(crate) fn flood(
        &mut self,
        openings: &BlockOpenings,
        eye: Vec3,
        camera: Option<&Camera>,
        start: &Start<'_>,
        results: &mut FloodArena,
    ) {
        self.begin(openings);
        let scene = Scene {
            openings,
            eye,
            camera,
            start,
        };
        let first_edge = self.push_edges(start.view);
        let view = View {
            room: start.room,
            parent: NONE,
            portal: NONE,
            next: NONE,
            first_edge,
            edge_count: start.view.len() as u16,
            hops: 0,
        };
        self.touch(&scene, start.room);
        self.append(start.room, view);
        self.schedule(&scene, start.room, start.entry, NONE);
        while let Some(Reverse((_, _, room))) = self.todo.pop() {
            let state = &mut self.rooms[room as usize];
            if !state.done {
                state.done = true;
                state.position = self.list.len() as u32;
                self.list.push(room);
            }
            if self.clip_portals(&scene, room) {
                self.add_view_to_portals(&scene, room);
            }
        }
        self.write_result(&scene, results);
    }

    fn begin(&mut self, openings: &BlockOpenings) {
        if self.stamp == u32::MAX {
            // Stamps of old floods must not come round again.
            self.rooms.fill(UNTOUCHED);
            self.pieces.fill(PieceState::default());
            self.stamp = 0;
        }
        self.stamp += 1;
        self.repair = 0;
        self.depth = 0;
        let rooms = openings.rooms.len();
        if self.rooms.len() < rooms {
            self.rooms.resize(rooms, UNTOUCHED);
        }
        if self.portals.len() < openings.portals.len() {
            self.portals
                .resize(openings.portals.len(), PortalState::default());
        }
        if self.pieces.len() < openings.pieces.len() {
            self.pieces.resize(openings.pieces.len(), PieceState::default());
        }
        self.rays.clear();
        // Retail's cut ahead of the eye adds at most one corner to a piece.
        self.rays.reserve(openings.vertices.len() + openings.pieces.len());
        self.views.clear();
        // Beyond the limit each room may still get one widened view, and so may the outside.
        self.views.reserve(MAX_VIEWS + rooms + 1);
        self.edges.clear();
        self.edges
            .reserve(MAX_VIEWS * self.settings.max_edges + 4 * (rooms + 1));
        self.list.clear();
        self.list.reserve(rooms);
        self.moves.reserve(openings.portals.len() + 1);
        self.todo.clear();
        self.todo.reserve(rooms);
        self.inserted = 0;
        self.outside = NO_VIEWS;
        self.truncated = false;
    }

    fn push_edges(&mut self, edges: &[Edge]) -> u32 {
        let first = self.edges.len() as u32;
        self.edges.extend_from_slice(edges);
        first
    }

    /// Clears what an earlier flood left on a room (`visibility.md` 2.7) and measures where the eye is.
    fn touch(&mut self, scene: &Scene<'_>, room: u32) {
        let state = &mut self.rooms[room as usize];
        if state.stamp == self.stamp {
            return;
        }
        *state = RoomState {
            stamp: self.stamp,
            ..UNTOUCHED
        };
        let compiled = &scene.openings.rooms[room as usize];
        let eye = compiled.frame.global_to_local(scene.eye);
        for p in scene.openings.portals_of(room) {
            let dist = scene.openings.portals[p as usize].plane.dist(eye);
            self.portals[p as usize] = PortalState { flags: 0, dist };
        }
    }

    /// InitCell and the insertion into the todo list (`visibility.md` 5.3, 5.4).
    fn schedule(&mut self, scene: &Scene<'_>, room: u32, entry: u32, from: u32) {
        let mut farthest = 0.0f32;
        for p in scene.openings.portals_of(room) {
            let portal = &scene.openings.portals[p as usize];
            let state = &mut self.portals[p as usize];
            if p == entry {
                state.flags |= IN | SEEN_IN;
            } else if is_in(state.dist, portal.interior_is_negative) {
                state.flags |= IN;
            }
            if state.flags & IN != 0 {
                for piece in portal.first_piece..portal.first_piece + portal.piece_count {
                    for &v in scene.openings.piece_vertices(piece) {
                        let gap = v - scene.eye;
                        farthest = upper(farthest, gap.dot(gap));
                    }
                }
            }
        }
        let state = &mut self.rooms[room as usize];
        let key = if room == scene.start.room { 0.0 } else { farthest };
        state.key = key;
        state.scheduled = true;
        state.news = false;
        state.reached_from = from;
        // Bits of non-negative floats sort as the floats do; equal keys leave in order of insertion.
        self.todo.push(Reverse((key.to_bits(), self.inserted, room)));
        self.inserted += 1;
    }
}

/// The region that goes to a neighbour: the polygon at hand, or the edges of an earlier view.
#[derive(Clone, Copy)]
enum Shape {
    Polygon,
    Shared(u32, u16),
}

/// The neighbour that holds the eye when the room does not (`visibility.md` 12.3).
fn better_root(openings: &BlockOpenings, room: u32, eye: Vec3) -> Option<u32> {
    let outside_by = |room: u32| {
        let r = &openings.rooms[room as usize];
        let local = r.frame.global_to_local(eye);
        r.bsp
            .planes()
            .iter()
            .fold(0.0f32, |worst, plane| upper(worst, -plane.dist(local)))
    };
    if outside_by(room) <= WRONG_CELL_MARGIN {
        return None;
    }
    openings
        .portals_of(room)
        .find_map(|p| match openings.portals[p as usize].target {
            Target::Room(other) if other != room && outside_by(other) <= EPSILON => Some(other),
            _ => None,
        })
}
