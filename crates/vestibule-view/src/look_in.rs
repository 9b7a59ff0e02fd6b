//! Looking into buildings from outdoors (`visibility.md` 8): doors that face the eye, punches and floods.

use glam::Vec3;
use vestibule_world::{BlockId, CellId};

use crate::camera::Camera;
use crate::constants::{EPSILON, ON_PLANE_MARGIN};
use crate::flood::{FloodArena, FloodCounters};
use crate::openings::{BlockOpenings, Door, House, Target};
use crate::pview::clip::{fill_normals, is_in_grown_polygon, push_rays};
use crate::pview::{PView, Start};
use crate::view::{Edge, Region};

/// One door of a building seen through one view of the landscape: the hole to punch into the depth buffer and what
/// is seen through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookIn {
    /// Landblock of the building.
    pub block: BlockId,
    /// Position among [`vestibule_world::Landblock::buildings`].
    pub building: u32,
    /// Position of the portal in the building.
    pub portal: u16,
    /// The room behind the door.
    pub entry: CellId,
    /// Which of the active views it is seen through.
    pub view: u32,
    /// The flood behind it, by index for [`FloodArena::get`].
    pub flood: u32,
    /// The door lies on a border of a 24 m piece: its punch is never drawn (`rendering.md` 7.3).
    pub on_block_border: bool,
    pub(crate) first_edge: u32,
    pub(crate) edge_count: u32,
}

/// Reused memory for looking in, and what was seen (`visibility.md` 15.2).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LookIns {
    pub(crate) list: Vec<LookIn>,
    pub(crate) edges: Vec<Edge>,
    order: Vec<(u32, u32)>,
    stack: Vec<u32>,
    /// Doors in view whose room is not loaded.
    pub dead_doors: u32,
}

impl LookIns {
    /// Nothing seen yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets everything, keeping the memory.
    pub fn clear(&mut self) {
        self.list.clear();
        self.edges.clear();
        self.dead_doors = 0;
    }

    /// What was seen: per building the doors of the first view back to front, then those of the next.
    pub fn list(&self) -> &[LookIn] {
        &self.list
    }

    /// The clipped door polygon, the shape to punch. Empty when the eye is in the door's plane.
    pub fn punch(&self, look_in: &LookIn) -> Region<'_> {
        let first = look_in.first_edge as usize;
        Region::new(
            self.edges
                .get(first..first + look_in.edge_count as usize)
                .unwrap_or(&[]),
        )
    }
}

impl PView {
    /// Looks into every building of a landblock through every active view (`visibility.md` 8.2-8.4). Appends to
    /// `out` and the floods to `floods`. Exits met inside add nothing.
    pub fn look_into_block<'v>(
        &mut self,
        openings: &BlockOpenings,
        camera: &Camera,
        views: impl ExactSizeIterator<Item = Region<'v>> + Clone,
        out: &mut LookIns,
        floods: &mut FloodArena,
    ) {
        for building in 0..openings.houses.len() as u32 {
            self.look_into(openings, building, camera, views.clone(), out, floods);
        }
    }

    /// Looks into one building, by its position among the landblock's buildings. Returns how many looks were added.
    pub fn look_into<'v>(
        &mut self,
        openings: &BlockOpenings,
        building: u32,
        camera: &Camera,
        views: impl ExactSizeIterator<Item = Region<'v>> + Clone,
        out: &mut LookIns,
        floods: &mut FloodArena,
    ) -> usize {
        let before = out.list.len();
        let Some(house) = openings.houses.get(building as usize) else {
            return 0;
        };
        let eye = camera.eye_in(openings.block());
        order_doors(openings, house, eye, &mut out.stack, &mut out.order);
        for (view, region) in (0u32..).zip(views) {
            for at in 0..out.order.len() {
                let (_, index) = out.order[at];
                let door = &openings.doors[index as usize];
                let local = house.frame.global_to_local(eye);
                let side = door.plane.dist(local);
                let on_plane = side.abs() <= EPSILON;
                if on_plane && !self.settings().admit_on_plane
                    || !on_plane && (side < 0.0) != door.interior_is_negative
                {
                    continue;
                }
                let looks =
                    self.look_through(openings, door, camera, eye, (side, on_plane), region, out, floods);
                for look in &mut out.list[looks..] {
                    (look.building, look.view) = (building, view);
                }
            }
        }
        out.list.len() - before
    }

    /// One door through one view; returns where its looks begin in the list.
    #[expect(
        clippy::too_many_arguments,
        reason = "one step of look_into, split for reading"
    )]
    fn look_through(
        &mut self,
        openings: &BlockOpenings,
        door: &Door,
        camera: &Camera,
        eye: Vec3,
        (side, on_plane): (f32, bool),
        region: Region<'_>,
        out: &mut LookIns,
        floods: &mut FloodArena,
    ) -> usize {
        let before = out.list.len();
        let pieces = door.first_piece..door.first_piece + door.piece_count;
        let inside = on_plane
            && pieces
                .clone()
                .any(|p| is_in_grown_polygon(openings.piece_vertices(p), eye, ON_PLANE_MARGIN));
        for piece in pieces {
            let seen = self.clip_door(openings.piece_vertices(piece), camera, eye, side < 0.0, region);
            if !(seen || inside) {
                continue;
            }
            let Target::Room(room) = door.target else {
                out.dead_doors += 1;
                break;
            };
            let first_edge = out.edges.len() as u32;
            if seen {
                out.edges.extend_from_slice(self.clipped());
            }
            let edge_count = out.edges.len() as u32 - first_edge;
            let view = if inside {
                region.edges()
            } else {
                &out.edges[first_edge as usize..]
            };
            let start = Start {
                room,
                entry: door.other_portal,
                view,
                to_outside: false,
                stabs: &door.stabs,
            };
            self.set_counters(FloodCounters {
                on_plane: u32::from(inside),
                ..FloodCounters::default()
            });
            self.flood(openings, eye, Some(camera), &start, floods);
            out.list.push(LookIn {
                block: openings.block(),
                building: 0,
                portal: door.portal,
                entry: door.target_id,
                view: 0,
                flood: floods.len() as u32 - 1,
                on_block_border: door.on_block_border,
                first_edge,
                edge_count,
            });
            if inside {
                break;
            }
        }
        before
    }

    fn clip_door(
        &mut self,
        vertices: &[Vec3],
        camera: &Camera,
        eye: Vec3,
        negative: bool,
        view: Region<'_>,
    ) -> bool {
        let mut rays = core::mem::take(self.door_rays());
        rays.clear();
        let ahead = (!self.settings().admit_on_plane).then(|| camera.forward());
        push_rays(&mut rays, vertices, eye, negative, ahead);
        fill_normals(&mut rays);
        let seen = self.clip_start(&rays, view.edges(), camera);
        *self.door_rays() = rays;
        seen
    }
}

/// The doors of a house back to front from the eye, as the shell's drawing BSP hands them out (`visibility.md` 8.2);
/// without one by the distance of their middles, ties by portal.
fn order_doors(
    openings: &BlockOpenings,
    house: &House,
    eye: Vec3,
    stack: &mut Vec<u32>,
    order: &mut Vec<(u32, u32)>,
) {
    order.clear();
    let doors = house.first_door..house.first_door + house.door_count;
    if !house.tree.is_empty() {
        let local = house.frame.global_to_local(eye);
        house.tree.back_to_front(local, stack, |portal| {
            // Doors are in the order of the portals, one each.
            let index = house.first_door + u32::from(portal);
            if doors.contains(&index) {
                order.push((0, index));
            }
        });
        return;
    }
    for index in doors {
        let gap = openings.doors[index as usize].middle - eye;
        // Bits of non-negative floats sort as the floats do.
        order.push((gap.dot(gap).to_bits(), index));
    }
    order.sort_unstable_by_key(|&(dist, index)| (core::cmp::Reverse(dist), index));
}
