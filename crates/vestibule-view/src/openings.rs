//! The openings of a landblock compiled for the traversal: rooms, portals and building doors in flat arrays.

use std::sync::OnceLock;

use glam::Vec3;
use vestibule_world::{
    ApertureTree, BlockId, Building, CellBsp, CellId, EnvCell, Frame, Landblock, Plane, PortalTarget, World,
};

use crate::land_outline::LandOutline;
use crate::polygon_pieces::{Pieces, pieces};

/// No portal, no cell.
pub(crate) const NONE: u32 = u32::MAX;
/// First env cell of a landblock.
const FIRST_ENV_CELL: u16 = 0x0100;

/// Where an opening leads, resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// To the landscape.
    Outside,
    /// Into a room of the same landblock, by its position in the compiled rooms.
    Room(u32),
    /// To a cell that is not loaded.
    Missing,
}

/// A compiled portal of a room.
#[derive(Clone, Debug)]
pub(crate) struct Portal {
    pub(crate) target: Target,
    /// The matching portal of the other room, among all portals of the landblock; [`NONE`] when unknown.
    pub(crate) other_portal: u32,
    /// Room-local.
    pub(crate) plane: Plane,
    pub(crate) interior_is_negative: bool,
    pub(crate) exact_match: bool,
    /// All vertices lie on x = ±12 or y = ±12 of the local frame (`rendering.md` 7.3).
    pub(crate) on_block_border: bool,
    pub(crate) record_index: u16,
    pub(crate) first_piece: u32,
    pub(crate) piece_count: u32,
}

/// A compiled room.
#[derive(Clone, Debug)]
pub(crate) struct Room {
    pub(crate) id: CellId,
    pub(crate) frame: Frame,
    pub(crate) bsp: CellBsp,
    pub(crate) first_portal: u32,
    pub(crate) portal_count: u32,
    /// Rooms of the stab list that are loaded, ascending.
    pub(crate) stabs: Box<[u32]>,
}

/// A convex piece of an opening; landblock frame, counter-clockwise from the plane's positive side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// A building portal with the aperture polygon of its model.
#[derive(Clone, Debug)]
pub(crate) struct Door {
    /// Position in the building's portals.
    pub(crate) portal: u16,
    pub(crate) target: Target,
    pub(crate) target_id: CellId,
    pub(crate) other_portal: u32,
    /// In the frame of the building's part.
    pub(crate) plane: Plane,
    pub(crate) interior_is_negative: bool,
    pub(crate) on_block_border: bool,
    pub(crate) first_piece: u32,
    pub(crate) piece_count: u32,
    /// Middle of the aperture, landblock frame.
    pub(crate) middle: Vec3,
    pub(crate) stabs: Box<[u32]>,
}

/// A compiled building: its doors.
#[derive(Clone, Debug)]
pub(crate) struct House {
    pub(crate) frame: Frame,
    pub(crate) first_door: u32,
    pub(crate) door_count: u32,
    /// In which order the doors are met; empty for houses given by hand.
    pub(crate) tree: ApertureTree,
    /// Portals and apertures do not match one to one (`visibility.md` 2.3).
    pub(crate) mismatched: bool,
}

/// What was wrong with the openings of a landblock, counted when it was compiled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpeningProblems {
    /// Portals whose polygon has fewer than three distinct vertices, no area or numbers that are not finite: closed
    /// for good (`visibility.md` 12.7, 14.9).
    pub closed_portals: u32,
    /// Portals whose polygon is not convex or has too many vertices, taken as several openings.
    pub split_portals: u32,
    /// Portals that lead to a cell that is not loaded.
    pub unresolved_portals: u32,
    /// Stab list entries that name a cell that is not loaded.
    pub absent_stabs: u32,
    /// Buildings whose portals and apertures do not match one to one: nobody looks into them (`visibility.md` 2.3).
    pub mismatched_buildings: u32,
}

/// A room given by hand, for worlds that do not come from records. See [`BlockOpenings::from_rooms`].
#[derive(Clone, Debug)]
pub struct RoomSpec {
    /// Full id; its landblock must be that of the openings.
    pub id: CellId,
    /// Room-local to landblock frame.
    pub frame: Frame,
    /// What is inside the room, room-local; used only by the guard for an eye in the wrong cell.
    pub bsp: CellBsp,
    /// Its portals; other rooms refer to them by position.
    pub portals: Vec<PortalSpec>,
    /// Rooms that may be seen from here.
    pub stab_list: Vec<CellId>,
}

/// A portal of a [`RoomSpec`].
#[derive(Clone, Debug)]
pub struct PortalSpec {
    /// Where it leads.
    pub target: PortalTarget,
    /// The matching portal of the other room.
    pub other_portal: Option<u16>,
    /// The polygon, room-local metres, counter-clockwise seen from its positive side.
    pub vertices: Vec<Vec3>,
    /// The room lies on the polygon's negative side (retail `portal_side` 1).
    pub interior_is_negative: bool,
    /// The matching polygon is the same, so that one clip is enough.
    pub exact_match: bool,
}

/// A building given by hand: its openings to the landscape. They are met far to near by their middles, as there is
/// no drawing BSP to say.
#[derive(Clone, Debug)]
pub struct HouseSpec {
    /// Building-local to landblock frame.
    pub frame: Frame,
    /// Its doors.
    pub doors: Vec<DoorSpec>,
}

/// An opening of a [`HouseSpec`].
#[derive(Clone, Debug)]
pub struct DoorSpec {
    /// The room behind it.
    pub target: CellId,
    /// The matching portal of that room.
    pub other_portal: Option<u16>,
    /// The polygon, building-local metres, counter-clockwise seen from its positive side.
    pub vertices: Vec<Vec3>,
    /// A viewer looks in from the polygon's negative side (retail `portal_side` 1).
    pub interior_is_negative: bool,
    /// Rooms that may be seen through it.
    pub stab_list: Vec<CellId>,
}

/// The openings of one landblock, compiled. Coordinates are metres in the landblock's frame.
#[derive(Debug)]
pub struct BlockOpenings {
    block: BlockId,
    /// By low word from 0x0100; [`NONE`] where no cell is loaded.
    slots: Box<[u32]>,
    pub(crate) rooms: Vec<Room>,
    pub(crate) portals: Vec<Portal>,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) houses: Vec<House>,
    pub(crate) doors: Vec<Door>,
    /// `None` for rooms given by hand and without terrain.
    pub(crate) outline: Option<LandOutline>,
    problems: OpeningProblems,
}

impl BlockOpenings {
    /// Compiles the openings of a loaded landblock.
    pub fn compile(block: &Landblock) -> Self {
        let mut out = Self::empty(block.id, block.env_cells.len());
        out.outline = LandOutline::of(block);
        let mut links = Vec::new();
        for cell in block.env_cells() {
            out.add_env_cell(cell, &mut links);
        }
        out.resolve(&links, |room| {
            let id = room.id;
            block
                .env_cell(id)
                .map(|c| c.stab_list.to_vec())
                .unwrap_or_default()
        });
        for building in &block.buildings {
            out.add_building(building);
        }
        out
    }

    /// Compiles rooms given by hand. Rooms of another landblock, with ids that are no env cell's, or with an id
    /// that an earlier room has, are left out.
    pub fn from_rooms(block: BlockId, rooms: &[RoomSpec]) -> Self {
        let highest = rooms
            .iter()
            .filter(|r| r.id.block() == block && r.id.is_env_cell())
            .map(|r| r.id.low())
            .max();
        let count = highest.map_or(0, |low| usize::from(low - FIRST_ENV_CELL) + 1);
        let mut out = Self::empty(block, count);
        let mut links = Vec::new();
        for room in rooms {
            if room.id.block() != block || !room.id.is_env_cell() || out.room_of(room.id).is_some() {
                continue;
            }
            out.begin_room(room.id, room.frame, room.bsp.clone());
            for (index, portal) in (0u16..).zip(&room.portals) {
                let plane = Plane::of_polygon(&portal.vertices);
                out.add_portal(PortalInput {
                    plane,
                    interior_is_negative: portal.interior_is_negative,
                    exact_match: portal.exact_match,
                    record_index: index,
                    vertices: &portal.vertices,
                });
                links.push((portal.target, portal.other_portal));
            }
        }
        let stabs_of = |room: &Room| {
            rooms
                .iter()
                .find(|r| r.id == room.id)
                .map(|r| r.stab_list.clone())
                .unwrap_or_default()
        };
        out.resolve(&links, stabs_of);
        out
    }

    fn empty(block: BlockId, cells: usize) -> Self {
        BlockOpenings {
            block,
            slots: vec![NONE; cells].into(),
            rooms: Vec::new(),
            portals: Vec::new(),
            pieces: Vec::new(),
            vertices: Vec::new(),
            houses: Vec::new(),
            doors: Vec::new(),
            outline: None,
            problems: OpeningProblems::default(),
        }
    }

    /// The landblock.
    pub fn block(&self) -> BlockId {
        self.block
    }

    /// Number of rooms.
    pub fn room_count(&self) -> usize {
        self.rooms.len()
    }

    /// What was wrong with the data.
    pub fn problems(&self) -> &OpeningProblems {
        &self.problems
    }

    /// Whether the room is loaded.
    pub fn has_room(&self, id: CellId) -> bool {
        self.room_of(id).is_some()
    }

    /// Whether nothing can be looked into or out of here.
    pub fn is_empty(&self) -> bool {
        self.rooms.is_empty() && self.doors.is_empty()
    }

    /// Vertices of one convex piece of a room's portal (`portal` is the position in the record), landblock frame.
    pub fn portal_pieces(&self, cell: CellId, portal: u16) -> impl Iterator<Item = &[Vec3]> {
        let found = self.room_of(cell).and_then(|room| {
            self.portals_of(room)
                .find(|&p| self.portals[p as usize].record_index == portal)
        });
        let (first, count) = found.map_or((0, 0), |p| {
            (
                self.portals[p as usize].first_piece,
                self.portals[p as usize].piece_count,
            )
        });
        (first..first + count).map(|p| self.piece_vertices(p))
    }

    pub(crate) fn room_of(&self, id: CellId) -> Option<u32> {
        if id.block() != self.block || id.low() < FIRST_ENV_CELL {
            return None;
        }
        let room = *self.slots.get(usize::from(id.low() - FIRST_ENV_CELL))?;
        (room != NONE).then_some(room)
    }

    pub(crate) fn portals_of(&self, room: u32) -> core::ops::Range<u32> {
        let r = &self.rooms[room as usize];
        r.first_portal..r.first_portal + r.portal_count
    }

    #[inline]
    pub(crate) fn piece_vertices(&self, piece: u32) -> &[Vec3] {
        let p = &self.pieces[piece as usize];
        &self.vertices[p.first as usize..(p.first + p.count) as usize]
    }

    fn begin_room(&mut self, id: CellId, frame: Frame, bsp: CellBsp) {
        if let Some(slot) = self.slots.get_mut(usize::from(id.low() - FIRST_ENV_CELL)) {
            *slot = self.rooms.len() as u32;
        }
        self.rooms.push(Room {
            id,
            frame,
            bsp,
            first_portal: self.portals.len() as u32,
            portal_count: 0,
            stabs: Box::default(),
        });
    }

    fn add_env_cell(&mut self, cell: &EnvCell, links: &mut Vec<(PortalTarget, Option<u16>)>) {
        self.begin_room(cell.id, cell.frame, cell.structure.cell_bsp.clone());
        for portal in &cell.portals {
            self.add_portal(PortalInput {
                plane: portal.plane,
                interior_is_negative: portal.interior_is_negative,
                exact_match: portal.exact_match,
                record_index: portal.record_index,
                vertices: cell.portal_vertices(portal),
            });
            links.push((portal.other, portal.other_portal));
        }
    }

    fn add_portal(&mut self, input: PortalInput<'_>) {
        let Some(room) = self.rooms.last_mut() else { return };
        room.portal_count += 1;
        let frame = room.frame;
        let (first_piece, piece_count) = self.add_pieces(input.vertices, &input.plane, &frame);
        self.portals.push(Portal {
            target: Target::Missing,
            other_portal: NONE,
            plane: input.plane,
            interior_is_negative: input.interior_is_negative,
            exact_match: input.exact_match,
            on_block_border: on_block_border(input.vertices),
            record_index: input.record_index,
            first_piece,
            piece_count,
        });
    }

    fn add_pieces(&mut self, vertices: &[Vec3], plane: &Plane, frame: &Frame) -> (u32, u32) {
        let first = self.pieces.len() as u32;
        match pieces(vertices, plane) {
            Pieces::Closed => self.problems.closed_portals += 1,
            Pieces::Open(list) => {
                self.problems.split_portals += u32::from(list.len() > 1);
                for piece in list {
                    let first = self.vertices.len() as u32;
                    let before = self.vertices.len();
                    self.vertices
                        .extend(piece.iter().map(|&p| frame.local_to_global(p)));
                    if self.vertices[before..].iter().all(|v| v.is_finite()) {
                        self.pieces.push(Piece {
                            first,
                            count: piece.len() as u32,
                        });
                    }
                }
            }
        }
        (first, self.pieces.len() as u32 - first)
    }

    /// Turns ids into positions, once every room is known.
    fn resolve(&mut self, links: &[(PortalTarget, Option<u16>)], stabs_of: impl Fn(&Room) -> Vec<CellId>) {
        for (at, &(target, other_portal)) in links.iter().enumerate() {
            let (target, other) = match target {
                PortalTarget::Outside => (Target::Outside, NONE),
                PortalTarget::Cell(id) => match self.room_of(id) {
                    None => {
                        self.problems.unresolved_portals += 1;
                        (Target::Missing, NONE)
                    }
                    Some(room) => (Target::Room(room), self.portal_of(room, other_portal)),
                },
            };
            if let Some(portal) = self.portals.get_mut(at) {
                portal.target = target;
                portal.other_portal = other;
            }
        }
        for at in 0..self.rooms.len() {
            let list = stabs_of(&self.rooms[at]);
            self.rooms[at].stabs = self.resolve_stabs(&list);
        }
    }

    fn portal_of(&self, room: u32, record_index: Option<u16>) -> u32 {
        let Some(index) = record_index else { return NONE };
        let mut range = self.portals_of(room);
        let guess = range.start + u32::from(index);
        if range.contains(&guess) && self.portals[guess as usize].record_index == index {
            return guess;
        }
        range
            .find(|&p| self.portals[p as usize].record_index == index)
            .unwrap_or(NONE)
    }

    fn resolve_stabs(&mut self, list: &[CellId]) -> Box<[u32]> {
        let mut out: Vec<u32> = list.iter().filter_map(|&id| self.room_of(id)).collect();
        self.problems.absent_stabs += (list.len() - out.len()) as u32;
        out.sort_unstable();
        out.dedup();
        out.into()
    }

    /// Adds buildings given by hand, after those there are. A door to a room that is not there stays dead.
    #[must_use]
    pub fn with_houses(mut self, houses: &[HouseSpec]) -> Self {
        for spec in houses {
            let first_door = self.doors.len() as u32;
            for (portal, door) in (0u16..).zip(&spec.doors) {
                let plane = Plane::of_polygon(&door.vertices);
                self.add_door(
                    &spec.frame,
                    portal,
                    door.target,
                    door.other_portal,
                    &plane,
                    &door.vertices,
                    door.interior_is_negative,
                    &door.stab_list,
                );
            }
            self.houses.push(House {
                frame: spec.frame,
                first_door,
                door_count: self.doors.len() as u32 - first_door,
                tree: ApertureTree::default(),
                mismatched: false,
            });
        }
        self
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "the fields of a door, from two kinds of sources"
    )]
    fn add_door(
        &mut self,
        frame: &Frame,
        portal: u16,
        target_id: CellId,
        other_portal: Option<u16>,
        plane: &Plane,
        vertices: &[Vec3],
        interior_is_negative: bool,
        stab_list: &[CellId],
    ) {
        let (first_piece, piece_count) = self.add_pieces(vertices, plane, frame);
        let target = self.room_of(target_id).map_or(Target::Missing, Target::Room);
        let other_portal = match target {
            Target::Room(room) => self.portal_of(room, other_portal),
            _ => NONE,
        };
        let mut middle = Vec3::ZERO;
        for v in vertices {
            middle += *v / vertices.len() as f32;
        }
        let stabs = self.resolve_stabs(stab_list);
        self.doors.push(Door {
            portal,
            target,
            target_id,
            other_portal,
            plane: *plane,
            interior_is_negative,
            on_block_border: on_block_border(vertices),
            first_piece,
            piece_count,
            middle: frame.local_to_global(middle),
            stabs,
        });
    }

    fn add_building(&mut self, building: &Building) {
        let mut house = House {
            frame: building.part_frames.first().copied().unwrap_or(building.frame),
            first_door: self.doors.len() as u32,
            door_count: 0,
            tree: ApertureTree::default(),
            mismatched: false,
        };
        let model = building.shape.parts.first().and_then(|p| p.model.as_ref());
        let apertures = model.map_or(&[][..], |m| &m.apertures);
        // A building without portals matches an empty list.
        let matched = apertures.len() == building.portals.len()
            && apertures.iter().zip(0u16..).all(|(a, index)| a.portal == index);
        // Without the shell's model neither shell nor interior is drawn (`rendering.md` 6.5).
        house.mismatched = !matched;
        self.problems.mismatched_buildings += u32::from(house.mismatched);
        if let (Some(model), true) = (model, matched) {
            for (aperture, portal) in apertures.iter().zip(&building.portals) {
                let polygon = model.polygons.get(aperture.polygon as usize);
                let vertices = polygon.map_or(&[][..], |p| model.polygons.vertices(p));
                let plane = polygon.map(|p| p.plane).unwrap_or_default();
                self.add_door(
                    &house.frame,
                    aperture.portal,
                    portal.other,
                    portal.other_portal,
                    &plane,
                    vertices,
                    portal.interior_is_negative,
                    &portal.stab_list,
                );
            }
            house.door_count = self.doors.len() as u32 - house.first_door;
            house.tree = model.aperture_tree.clone();
        }
        self.houses.push(house);
    }
}

struct PortalInput<'a> {
    plane: Plane,
    interior_is_negative: bool,
    exact_match: bool,
    record_index: u16,
    vertices: &'a [Vec3],
}

/// `rendering.md` 7.3, compared exactly as there.
fn on_block_border(vertices: &[Vec3]) -> bool {
    let all = |f: fn(&Vec3) -> f32, v: f32| vertices.iter().all(|p| f(p) == v);
    !vertices.is_empty()
        && (all(|p| p.x, 12.0) || all(|p| p.x, -12.0) || all(|p| p.y, 12.0) || all(|p| p.y, -12.0))
}

/// The compiled openings of a world, landblock by landblock, made when first asked for, from any thread.
///
/// One value belongs to one [`World`]; share it by reference between viewers. Where landblocks come and go, call
/// [`Openings::forget`] for each whose residency changes: what has been compiled stays as it was.
#[derive(Debug)]
pub struct Openings {
    blocks: Box<[OnceLock<Option<Box<BlockOpenings>>>]>,
}

impl Default for Openings {
    fn default() -> Self {
        Self::new()
    }
}

impl Openings {
    /// Nothing compiled yet.
    pub fn new() -> Self {
        Openings {
            blocks: (0..1usize << 16).map(|_| OnceLock::new()).collect(),
        }
    }

    /// Forgets a landblock: it is compiled anew when next asked for. To be called when the landblock has been
    /// released, has been loaded after it could not be had, or knows other env cells than before
    /// ([`vestibule_world::CellManager`]); and to free memory. Returns whether there was anything to forget.
    pub fn forget(&mut self, id: BlockId) -> bool {
        self.blocks
            .get_mut(usize::from(id.0))
            .is_some_and(|slot| slot.take().is_some())
    }

    /// Forgets everything, as after [`vestibule_world::CellManager::reset`].
    pub fn clear(&mut self) {
        for slot in &mut self.blocks {
            slot.take();
        }
    }

    /// The openings of a landblock, compiled if they were not. `None` when the landblock cannot be had.
    #[inline]
    pub fn block(&self, world: &World, id: BlockId) -> Option<&BlockOpenings> {
        let slot = &self.blocks[usize::from(id.0)];
        match slot.get() {
            Some(found) => found.as_deref(),
            None => slot
                .get_or_init(|| world.block(id).map(|b| Box::new(BlockOpenings::compile(b))))
                .as_deref(),
        }
    }
}
