//! The portal traversal: which cells are seen from a cell, and through which regions (`visibility.md` 5-7, 12-14).
//!
//! A best-first worklist hands views from cell to cell through the openings the eye is in front of; a cell that was
//! finished before a further view reached it is repaired at once. Nothing is allocated once the scratch has met its
//! largest landblock, and the order of the data decides all ties.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{Vec2, Vec3};
use vestibule_world::{CellId, World};

use crate::camera::{Camera, FARTHEST_EYE};
use crate::constants::{
    EPSILON, MAX_EDGES_RETAIL, MAX_HOPS, MAX_VIEWS, MAX_VIEWS_PER_CELL, ON_PLANE_MARGIN, WRONG_CELL_MARGIN,
};
use crate::flood::{Flood, FloodArena, FloodCounters, FloodRecord, FloodSettings, Seal, SeenCell, SeenView};
use crate::openings::{BlockOpenings, NONE, Openings, Target};
use crate::view::{ClipPolygon, Edge, edge_normal, full_view, lower, rectangle, upper};

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
        // One result was just written.
        let record = self.results.floods.last().copied().unwrap_or_default();
        debug_assert_eq!(self.results.len(), 1);
        self.results
            .get(0)
            .unwrap_or_else(|| unreachable!("a flood leaves a result: {record:?}"))
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
        if self.settings.guard_wrong_cell {
            if let Some(other) = better_root(openings, room, eye) {
                room = other;
                self.counters.wrong_cell += 1;
            }
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
        self.rays.reserve(openings.vertices.len());
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
        state.reached_from = from;
        // Bits of non-negative floats sort as the floats do; equal keys leave in order of insertion.
        self.todo.push(Reverse((key.to_bits(), self.inserted, room)));
        self.inserted += 1;
    }

    /// ClipPortals for the views not handed on yet (`visibility.md` 5.5). False when no portal is usable.
    fn clip_portals(&mut self, scene: &Scene<'_>, room: u32) -> bool {
        let mut view = core::mem::replace(&mut self.rooms[room as usize].pending, NONE);
        let portals = scene.openings.portals_of(room);
        let usable = portals.clone().any(|p| {
            self.portals[p as usize].flags & IN == 0
                && scene.openings.portals[p as usize].target != Target::Missing
        });
        while view != NONE {
            for p in portals.clone() {
                if self.portals[p as usize].flags & IN == 0 {
                    self.clip_portal(scene, view, p);
                }
            }
            view = self.views[view as usize].next;
        }
        usable
    }

    /// One view through one opening.
    fn clip_portal(&mut self, scene: &Scene<'_>, view: u32, p: u32) {
        let portal = &scene.openings.portals[p as usize];
        let to = match portal.target {
            Target::Outside if scene.start.to_outside => OUTSIDE,
            Target::Outside => return,
            Target::Missing if self.portals[p as usize].flags & DEAD_COUNTED != 0 => return,
            Target::Missing => NONE,
            Target::Room(other) => {
                if self.settings.stab_gate
                    && other != scene.start.room
                    && scene.start.stabs.binary_search(&other).is_err()
                {
                    return;
                }
                other
            }
        };
        if self.eye_is_in_opening(scene, p) {
            // `visibility.md` 12.2: the whole view is handed on, its edges shared.
            let (first, count) = (
                self.views[view as usize].first_edge,
                self.views[view as usize].edge_count,
            );
            self.deliver(scene, to, view, p, Shape::Shared(first, count));
            return;
        }
        let reciprocal = if portal.exact_match || to >= OUTSIDE {
            NONE
        } else {
            portal.other_portal
        };
        for piece in portal.first_piece..portal.first_piece + portal.piece_count {
            if !self.clip_piece(scene, view, p, piece) {
                continue;
            }
            if reciprocal == NONE {
                if self.tidy(scene) {
                    self.deliver(scene, to, view, p, Shape::Polygon);
                }
            } else {
                self.other_portal_clip(scene, to, view, p, reciprocal);
            }
        }
    }

    /// GetClip: one piece of an opening against a view, into `self.polygon` (`visibility.md` 14.3-14.6).
    fn clip_piece(&mut self, scene: &Scene<'_>, view: u32, p: u32, piece: u32) -> bool {
        let v = self.views[view as usize];
        let planes = v.first_edge as usize..v.first_edge as usize + usize::from(v.edge_count);
        let (first, count) = self.corner_rays(scene, p, piece);
        let rays = &self.rays[first..first + count];
        let planes = &self.edges[planes];
        if planes.iter().any(|e| {
            rays.iter()
                .all(|r| e.normal.dot(r.corner) < -crate::constants::CLIP_TOLERANCE)
        }) {
            return false;
        }
        side_normals(&mut self.pieces[piece as usize], &mut self.rays);
        self.polygon.set(&self.rays[first..first + count]);
        self.polygon.clip(planes) && self.polygon.finish()
    }

    /// OtherPortalClip: what is left is clipped by the far cell's own polygon (`visibility.md` 3.4).
    fn other_portal_clip(&mut self, scene: &Scene<'_>, to: u32, view: u32, p: u32, reciprocal: u32) {
        self.touch(scene, to);
        if !self.tidy(scene) {
            return;
        }
        if self.eye_is_in_opening(scene, reciprocal) {
            self.deliver(scene, to, view, p, Shape::Polygon);
            return;
        }
        let portal = &scene.openings.portals[reciprocal as usize];
        core::mem::swap(&mut self.polygon, &mut self.far);
        for piece in portal.first_piece..portal.first_piece + portal.piece_count {
            let (first, count) = self.corner_rays(scene, reciprocal, piece);
            side_normals(&mut self.pieces[piece as usize], &mut self.rays);
            self.polygon.set(&self.rays[first..first + count]);
            if self.polygon.clip(self.far.edges()) && self.polygon.finish() && self.tidy(scene) {
                self.deliver(scene, to, view, p, Shape::Polygon);
            }
        }
        core::mem::swap(&mut self.polygon, &mut self.far);
    }

    /// Brings the clipped polygon to at most the allowed number of edges; in retail mode cleans it up in pixels.
    fn tidy(&mut self, scene: &Scene<'_>) -> bool {
        let max = self.settings.max_edges;
        if let (Some(camera), true) = (scene.camera, self.settings.min_px > 0.0) {
            return self.polygon.clean_pixels(camera, self.settings.min_px, max);
        }
        if self.polygon.edges().len() > max && self.polygon.simplify(max, scene.start.view) {
            self.counters.simplified_views += 1;
        }
        true
    }

    /// Clips a door given by its rays against a view of the landscape, for a look in. False when nothing is left.
    pub(crate) fn clip_start(&mut self, rays: &[Edge], view: &[Edge], camera: &Camera) -> bool {
        self.polygon.set(rays);
        if !(self.polygon.clip(view) && self.polygon.finish()) {
            return false;
        }
        let max = self.settings.max_edges;
        if self.settings.min_px > 0.0 {
            return self.polygon.clean_pixels(camera, self.settings.min_px, max);
        }
        self.polygon.simplify(max, view);
        true
    }

    /// What the last clip left.
    pub(crate) fn clipped(&self) -> &[Edge] {
        self.polygon.edges()
    }

    pub(crate) fn set_counters(&mut self, counters: FloodCounters) {
        self.counters = counters;
    }

    pub(crate) fn door_rays(&mut self) -> &mut Vec<Edge> {
        &mut self.door_rays
    }

    /// Whether the eye is on the plane of an opening and inside it (`visibility.md` 12.2).
    fn eye_is_in_opening(&mut self, scene: &Scene<'_>, p: u32) -> bool {
        let state = self.portals[p as usize];
        if !(state.dist.abs() <= EPSILON) || !self.settings.admit_on_plane {
            return false;
        }
        if state.flags & ON_PLANE_COUNTED == 0 {
            let portal = &scene.openings.portals[p as usize];
            let range = portal.first_piece..portal.first_piece + portal.piece_count;
            let inside = range.into_iter().any(|piece| {
                is_in_grown_polygon(scene.openings.piece_vertices(piece), scene.eye, ON_PLANE_MARGIN)
            });
            self.portals[p as usize].flags |= ON_PLANE_COUNTED | if inside { ON_PLANE_INSIDE } else { 0 };
            self.counters.on_plane += u32::from(inside);
        }
        self.portals[p as usize].flags & ON_PLANE_INSIDE != 0
    }

    /// Unit rays to the corners of a piece, counter-clockwise as seen from the eye; computed once per flood.
    /// Normals are still missing on first sight.
    fn corner_rays(&mut self, scene: &Scene<'_>, p: u32, piece: u32) -> (usize, usize) {
        let state = self.pieces[piece as usize];
        if state.stamp == self.stamp {
            return (state.first as usize, usize::from(state.count));
        }
        let portal = &scene.openings.portals[p as usize];
        let dist = self.portals[p as usize].dist;
        let negative = if dist == 0.0 {
            portal.interior_is_negative
        } else {
            dist < 0.0
        };
        let first = self.rays.len();
        let vertices = scene.openings.piece_vertices(piece);
        let count = push_rays(&mut self.rays, vertices, scene.eye, negative);
        self.pieces[piece as usize] = PieceState {
            stamp: self.stamp,
            first: first as u32,
            count: count as u16,
            has_normals: false,
        };
        (first, count)
    }

    /// Adds what was clipped to a neighbour or to the outside, or counts why not.
    fn deliver(&mut self, scene: &Scene<'_>, to: u32, parent: u32, p: u32, shape: Shape) {
        if to == NONE {
            self.portals[p as usize].flags |= DEAD_COUNTED;
            self.counters.dead_portals += 1;
            return;
        }
        // The ancestor rule (`visibility.md` 6.5). The root is an ancestor of everything, also of widened views.
        let mut ancestor = parent;
        let mut rejected = to == scene.start.room;
        while ancestor != NONE && !rejected {
            let v = &self.views[ancestor as usize];
            rejected = v.room == to;
            ancestor = v.parent;
        }
        if rejected {
            self.counters.ancestor_rejections += 1;
            return;
        }
        let list = if to == OUTSIDE {
            self.outside
        } else {
            self.touch(scene, to);
            self.rooms[to as usize].views
        };
        if list.saturated {
            return;
        }
        let hops = self.views[parent as usize].hops + 1;
        if hops > MAX_HOPS || self.views.len() >= MAX_VIEWS {
            self.truncated = true;
            self.saturate(scene, to, None);
        } else if list.count >= MAX_VIEWS_PER_CELL {
            let bounds = self.bounds_with_polygon(scene, &list, &shape);
            self.saturate(scene, to, bounds);
        } else {
            let (first_edge, edge_count) = match shape {
                Shape::Shared(first, count) => (first, count),
                Shape::Polygon => {
                    let first = self.edges.len() as u32;
                    self.edges.extend_from_slice(self.polygon.edges());
                    (first, self.polygon.edges().len() as u16)
                }
            };
            self.append(
                to,
                View {
                    room: to,
                    parent,
                    portal: p,
                    next: NONE,
                    first_edge,
                    edge_count,
                    hops,
                },
            );
        }
    }

    fn append(&mut self, to: u32, view: View) {
        let at = self.views.len() as u32;
        self.views.push(view);
        let list = if to == OUTSIDE {
            &mut self.outside
        } else {
            let state = &mut self.rooms[to as usize];
            if state.pending == NONE {
                state.pending = at;
            }
            &mut state.views
        };
        if list.tail == NONE {
            list.head = at;
        } else {
            self.views[list.tail as usize].next = at;
        }
        list.tail = at;
        list.count += 1;
    }

    /// Replaces the views of a room by one that bounds them, and accepts no more (`visibility.md` 13.4). Without
    /// bounds it is the view the flood started with, which holds all others.
    fn saturate(&mut self, scene: &Scene<'_>, to: u32, bounds: Option<[Edge; 4]>) {
        self.counters.saturated_cells += 1;
        let (first_edge, edge_count) = match bounds {
            Some(edges) => (self.push_edges(&edges), 4),
            None => (0, scene.start.view.len() as u16),
        };
        let replaced = ViewList {
            saturated: true,
            ..NO_VIEWS
        };
        if to == OUTSIDE {
            self.outside = replaced;
        } else {
            self.rooms[to as usize].views = replaced;
            self.rooms[to as usize].pending = NONE;
        }
        let view = View {
            room: to,
            parent: NONE,
            portal: NONE,
            next: NONE,
            first_edge,
            edge_count,
            hops: 0,
        };
        self.append(to, view);
    }

    /// The rectangle of the screen around all views of a list and the polygon at hand.
    fn bounds_with_polygon(&self, scene: &Scene<'_>, list: &ViewList, shape: &Shape) -> Option<[Edge; 4]> {
        let camera = scene.camera?;
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let mut grow = |edges: &[Edge]| {
            edges.iter().all(|e| {
                let c = camera.to_camera(e.corner);
                let slope = Vec2::new(c.x / c.y, c.z / c.y);
                low = Vec2::new(lower(low.x, slope.x), lower(low.y, slope.y));
                high = Vec2::new(upper(high.x, slope.x), upper(high.y, slope.y));
                c.y > 0.0 && slope.is_finite()
            })
        };
        let edges_of =
            |first: u32, count: u16| &self.edges[first as usize..first as usize + usize::from(count)];
        let mut at = list.head;
        while at != NONE {
            let v = &self.views[at as usize];
            if !grow(edges_of(v.first_edge, v.edge_count)) {
                return None;
            }
            at = v.next;
        }
        let ahead = match *shape {
            Shape::Shared(first, count) => grow(edges_of(first, count)),
            Shape::Polygon => grow(self.polygon.edges()),
        };
        ahead.then(|| rectangle(camera, low, high))
    }

    /// Hands new views on to the neighbours' places in the todo list, or repairs finished ones
    /// (`visibility.md` 5.6).
    fn add_view_to_portals(&mut self, scene: &Scene<'_>, room: u32) {
        for p in scene.openings.portals_of(room) {
            let portal = &scene.openings.portals[p as usize];
            let Target::Room(other) = portal.target else {
                continue;
            };
            if self.portals[p as usize].flags & IN != 0 {
                continue;
            }
            let state = &self.rooms[other as usize];
            if state.stamp != self.stamp || state.views.count == 0 {
                continue;
            }
            if !state.scheduled {
                self.schedule(scene, other, portal.other_portal, room);
            } else if state.pending != NONE {
                let done = state.done;
                if portal.other_portal != NONE {
                    self.portals[portal.other_portal as usize].flags |= IN;
                }
                if done {
                    self.fix_cell_list(scene, other, room);
                }
            } else {
                continue;
            }
            if portal.other_portal != NONE {
                let back = &mut self.portals[portal.other_portal as usize].flags;
                if *back & IN != 0 {
                    *back |= SEEN_IN;
                }
            }
        }
    }

    /// A finished room received a new view (`visibility.md` 6.1, 6.3).
    fn fix_cell_list(&mut self, scene: &Scene<'_>, done: u32, finder: u32) {
        self.adjust_cell_place(scene, done, finder);
        self.counters.incremental_clips += 1;
        if self.depth >= MAX_REPAIR_DEPTH {
            // Too deep for the stack: it gets its turn again before anything new.
            self.todo.push(Reverse((0, self.inserted, done)));
            self.inserted += 1;
            return;
        }
        self.depth += 1;
        if self.clip_portals(scene, done) {
            self.add_view_to_portals(scene, done);
        }
        self.depth -= 1;
    }

    /// Moves `finder` before `done` in the list, and before it whatever it is seen through (`visibility.md` 6.2).
    /// Each room moves at most once a repair, and none before the root (6.4).
    fn adjust_cell_place(&mut self, scene: &Scene<'_>, done: u32, finder: u32) {
        self.repair += 1;
        self.moves.clear();
        self.moves.push((done, finder));
        while let Some((before, mover)) = self.moves.pop() {
            let (to, from) = (
                self.rooms[before as usize].position,
                self.rooms[mover as usize].position,
            );
            let state = &mut self.rooms[mover as usize];
            let stuck = to == 0 || from == NONE || from <= to || state.moved_in == self.repair;
            if stuck || self.counters.moves >= MAX_MOVES {
                continue;
            }
            state.moved_in = self.repair;
            self.counters.moves += 1;
            self.list[to as usize..=from as usize].rotate_right(1);
            for at in to..=from {
                let room = self.list[at as usize];
                self.rooms[room as usize].position = at;
            }
            for p in scene.openings.portals_of(mover).rev() {
                if self.portals[p as usize].flags & (IN | SEEN_IN) != IN | SEEN_IN {
                    continue;
                }
                if let Target::Room(behind) = scene.openings.portals[p as usize].target {
                    if self.rooms[behind as usize].stamp == self.stamp {
                        self.moves.push((mover, behind));
                    }
                }
            }
        }
    }

    fn write_result(&mut self, scene: &Scene<'_>, out: &mut FloodArena) {
        let openings = scene.openings;
        let (cells, seals) = (out.cells.len() as u32, out.seals.len() as u32);
        let (views, edges) = (out.views.len() as u32, out.edges.len() as u32);
        out.edges.extend_from_slice(&self.edges);
        self.placed.clear();
        self.placed.resize(self.views.len(), NONE);
        let place = |list: &ViewList, out: &mut FloodArena, placed: &mut [u32]| -> (u32, u32) {
            let first = out.views.len() as u32 - views;
            let mut at = list.head;
            while at != NONE {
                let v = &self.views[at as usize];
                placed[at as usize] = out.views.len() as u32 - views;
                out.views.push(SeenView {
                    parent: (v.parent != NONE).then_some(v.parent),
                    portal: (v.portal != NONE).then(|| openings.portals[v.portal as usize].record_index),
                    first_edge: edges + v.first_edge,
                    edge_count: u32::from(v.edge_count),
                });
                at = v.next;
            }
            (first, out.views.len() as u32 - views - first)
        };
        for (&room, at) in self.list.iter().zip(0u32..) {
            let state = &self.rooms[room as usize];
            let (first_view, view_count) = place(&state.views, out, &mut self.placed);
            let from = (state.reached_from != NONE).then(|| self.rooms[state.reached_from as usize].position);
            let compiled = &openings.rooms[room as usize];
            out.cells.push(SeenCell {
                id: compiled.id,
                reached_from: from,
                key: state.key,
                saturated: state.views.saturated,
                first_view,
                view_count,
            });
            for p in openings.portals_of(room) {
                let portal = &openings.portals[p as usize];
                if portal.target == Target::Outside {
                    let on_block_border = portal.on_block_border;
                    out.seals.push(Seal {
                        cell: at,
                        portal: portal.record_index,
                        on_block_border,
                    });
                }
            }
            if room != scene.start.room && scene.start.stabs.binary_search(&room).is_err() {
                self.counters.entered_outside_stab += 1;
            }
        }
        let outside = place(&self.outside, out, &mut self.placed);
        for v in &mut out.views[views as usize..] {
            if let Some(parent) = v.parent {
                let at = self.placed[parent as usize];
                // A view that was replaced when its room saturated lives on in the one that bounds it.
                let room = self.views[parent as usize].room;
                let stand_in = if at == NONE {
                    self.rooms[room as usize].views.head
                } else {
                    parent
                };
                v.parent = self
                    .placed
                    .get(stand_in as usize)
                    .copied()
                    .filter(|&at| at != NONE);
            }
        }
        out.floods.push(FloodRecord {
            cells: (cells, self.list.len() as u32),
            views: (views, out.views.len() as u32 - views),
            outside,
            seals: (seals, out.seals.len() as u32 - seals),
            counters: self.counters,
            truncated: self.truncated,
        });
        self.counters = FloodCounters::default();
    }
}

/// The region that goes to a neighbour: the polygon at hand, or the edges of an earlier view.
#[derive(Clone, Copy)]
enum Shape {
    Polygon,
    Shared(u32, u16),
}

/// `visibility.md` 4.2: the eye is on the far side of the portal, which then only lets views in.
#[inline]
fn is_in(dist: f32, interior_is_negative: bool) -> bool {
    if interior_is_negative {
        dist > EPSILON
    } else {
        dist < -EPSILON
    }
}

/// Appends the unit rays to some vertices, reversed when `negative`. A vertex at the eye has no ray.
pub(crate) fn push_rays(rays: &mut Vec<Edge>, vertices: &[Vec3], eye: Vec3, negative: bool) -> usize {
    let before = rays.len();
    let mut push = |p: &Vec3| {
        let v = *p - eye;
        let length = v.dot(v).sqrt();
        if length > 1.0e-12 {
            rays.push(Edge {
                corner: v / length,
                normal: Vec3::ZERO,
            });
        }
    };
    if negative {
        vertices.iter().rev().for_each(&mut push);
    } else {
        vertices.iter().for_each(&mut push);
    }
    rays.len() - before
}

/// Fills in the planes of the sides between rays.
pub(crate) fn fill_normals(rays: &mut [Edge]) {
    let n = rays.len();
    for k in 0..n {
        let next = rays[if k + 1 == n { 0 } else { k + 1 }].corner;
        rays[k].normal = edge_normal(rays[k].corner, next);
    }
}

fn side_normals(piece: &mut PieceState, rays: &mut [Edge]) {
    if !piece.has_normals {
        piece.has_normals = true;
        let first = piece.first as usize;
        fill_normals(&mut rays[first..first + usize::from(piece.count)]);
    }
}

/// Whether `p`, near the plane of a convex polygon, lies inside it grown by `margin` metres.
pub(crate) fn is_in_grown_polygon(vertices: &[Vec3], p: Vec3, margin: f32) -> bool {
    let Some(&first) = vertices.first() else {
        return false;
    };
    let mut normal = Vec3::ZERO;
    for pair in vertices.windows(2) {
        normal += (pair[0] - first).cross(pair[1] - first);
    }
    vertices.iter().enumerate().all(|(k, &a)| {
        let b = vertices[if k + 1 == vertices.len() { 0 } else { k + 1 }];
        let inward = normal.cross(b - a);
        let length = inward.length();
        length <= 0.0 || inward.dot(p - a) >= -margin * length
    })
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
    if !(outside_by(room) > WRONG_CELL_MARGIN) {
        return None;
    }
    openings
        .portals_of(room)
        .find_map(|p| match openings.portals[p as usize].target {
            Target::Room(other) if other != room && outside_by(other) <= EPSILON => Some(other),
            _ => None,
        })
}
