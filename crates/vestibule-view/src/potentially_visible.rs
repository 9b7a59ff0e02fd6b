//! What could be seen from anywhere in a room, without a camera: for servers that decide whom to tell about what,
//! and for baking stab lists.
//!
//! A line of sight that leaves a room and passes a chain of openings lies in the wedge that the first opening and the
//! latest one leave between them. The chain is followed while every further opening has a part beyond the last one
//! and inside that wedge. The answer is a superset of what an eye in the room can see.

use glam::Vec3;
use vestibule_world::CellId;

use crate::constants::{EPSILON, MAX_HOPS};
use crate::openings::{BlockOpenings, Target};

/// Chains followed from one room before the rest is taken for visible. Real rooms need a few hundred.
const MAX_CHAINS: usize = 50_000;

/// What could be seen from a room.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PotentiallyVisible {
    /// Rooms, ascending by id, the room itself among them. Empty when the room is not loaded.
    pub cells: Vec<CellId>,
    /// Whether the outside could be seen.
    pub outside: bool,
    /// Too many ways to look: every room that can be reached at all is listed.
    pub truncated: bool,
}

/// The rooms of a landblock that an eye anywhere in `cell` could see through openings. Occluders inside rooms are
/// ignored; the answer holds every room that a line of sight from `cell` reaches. ([`crate::PView`] may list more from
/// rooms that are not convex, where it also follows openings nearer than the one it came through.)
pub fn potentially_visible(openings: &BlockOpenings, cell: CellId) -> PotentiallyVisible {
    let mut out = PotentiallyVisible::default();
    let Some(root) = openings.room_of(cell) else {
        return out;
    };
    let mut search = Search {
        openings,
        seen: vec![false; openings.rooms.len()],
        on_chain: vec![false; openings.rooms.len()],
        outside: false,
        chains: 0,
    };
    search.seen[root as usize] = true;
    search.on_chain[root as usize] = true;
    for p in openings.portals_of(root) {
        for source in search.polygons(p) {
            search.follow(p, &source, &source, 1);
        }
    }
    if search.chains >= MAX_CHAINS {
        out.truncated = true;
        search.flood_all(root);
    }
    out.outside = search.outside;
    let rooms = openings.rooms.iter().zip(&search.seen).filter(|(_, seen)| **seen);
    out.cells = rooms.map(|(room, _)| room.id).collect();
    out.cells.sort_unstable();
    out
}

struct Search<'a> {
    openings: &'a BlockOpenings,
    seen: Vec<bool>,
    on_chain: Vec<bool>,
    outside: bool,
    chains: usize,
}

/// A polygon with its plane, the positive side of which is where the view goes on.
#[derive(Clone, Debug)]
struct Opening {
    points: Vec<Vec3>,
    normal: Vec3,
    d: f32,
}

impl Search<'_> {
    /// The pieces of a portal as seen from its room.
    fn polygons(&self, p: u32) -> Vec<Opening> {
        let portal = &self.openings.portals[p as usize];
        (portal.first_piece..portal.first_piece + portal.piece_count)
            .filter_map(|piece| {
                let points = self.openings.piece_vertices(piece).to_vec();
                let plane = vestibule_world::Plane::of_polygon(&points);
                let way = if portal.interior_is_negative { 1.0 } else { -1.0 };
                let usable = plane.normal.length_squared() > 0.5;
                usable.then(|| Opening {
                    points,
                    normal: plane.normal * way,
                    d: plane.d * way,
                })
            })
            .collect()
    }

    /// The view has come through portal `p`, of which `last` is open, from `source`.
    fn follow(&mut self, p: u32, source: &Opening, last: &Opening, hops: u16) {
        self.chains += 1;
        if self.chains >= MAX_CHAINS {
            return;
        }
        let room = match self.openings.portals[p as usize].target {
            Target::Outside => {
                self.outside = true;
                return;
            }
            Target::Missing => return,
            Target::Room(room) => room,
        };
        // A view that comes back shows nothing new (`visibility.md` 6.5).
        if self.on_chain[room as usize] || hops > MAX_HOPS {
            return;
        }
        self.seen[room as usize] = true;
        self.on_chain[room as usize] = true;
        for next in self.openings.portals_of(room) {
            for opening in self.polygons(next) {
                if let Some((source, rest)) = narrow(source, last, opening, hops) {
                    self.follow(next, &source, &rest, hops + 1);
                }
            }
        }
        self.on_chain[room as usize] = false;
    }

    /// Everything that can be reached.
    fn flood_all(&mut self, root: u32) {
        let mut todo = vec![root];
        let mut reached = vec![false; self.seen.len()];
        reached[root as usize] = true;
        while let Some(room) = todo.pop() {
            self.seen[room as usize] = true;
            for p in self.openings.portals_of(room) {
                match self.openings.portals[p as usize].target {
                    Target::Outside => self.outside = true,
                    Target::Missing => {}
                    Target::Room(next) if !reached[next as usize] => {
                        reached[next as usize] = true;
                        todo.push(next);
                    }
                    Target::Room(_) => {}
                }
            }
        }
    }
}

/// What is left of the source and of a further opening for lines that pass source, last and it in turn.
fn narrow(source: &Opening, last: &Opening, next: Opening, hops: u16) -> Option<(Opening, Opening)> {
    let mut next = next;
    // Beyond the openings already passed, in the direction of the view. Touching counts: keep when in doubt.
    next.points = clip(&next.points, last.normal, last.d + EPSILON)?;
    next.points = clip(&next.points, source.normal, source.d + EPSILON)?;
    let mut source = source.clone();
    // And the source before the opening, else it is looked at from behind.
    source.points = clip(&source.points, -next.normal, -next.d + EPSILON)?;
    if hops >= 2 {
        // Planes through an edge of one and a corner of the other that have them on opposite sides bound every line
        // through both.
        for (a, b, flip) in [
            (&source.points, &last.points, 1.0),
            (&last.points, &source.points, -1.0),
        ] {
            for (normal, d) in separators(a, b) {
                next.points = clip(&next.points, normal * flip, d * flip + EPSILON)?;
            }
        }
    }
    Some((source, next))
}

/// Planes through an edge of `a` and a corner of `b` with all of `a` behind and all of `b` in front.
fn separators(a: &[Vec3], b: &[Vec3]) -> Vec<(Vec3, f32)> {
    let mut out = Vec::new();
    for (k, &p) in a.iter().enumerate() {
        let q = a[(k + 1) % a.len()];
        for &r in b {
            let normal = (q - p).cross(r - p);
            let length = normal.length();
            if length < EPSILON * EPSILON {
                continue;
            }
            let (mut normal, mut d) = (normal / length, -normal.dot(p) / length);
            let side = |n: Vec3, d: f32, v: Vec3| n.dot(v) + d;
            let (mut front, mut behind) = (false, false);
            for &v in a {
                front |= side(normal, d, v) > EPSILON;
                behind |= side(normal, d, v) < -EPSILON;
            }
            if front == behind {
                continue;
            }
            if front {
                (normal, d) = (-normal, -d);
            }
            let mut parted = false;
            let mut clear = true;
            for &v in b {
                parted |= side(normal, d, v) > EPSILON;
                clear &= side(normal, d, v) >= -EPSILON;
            }
            if parted && clear {
                out.push((normal, d));
            }
        }
    }
    out
}

/// The part of a polygon with `normal · p + d >= 0`; `None` when less than a triangle is left.
fn clip(points: &[Vec3], normal: Vec3, d: f32) -> Option<Vec<Vec3>> {
    let dist = |p: Vec3| normal.dot(p) + d;
    if points.iter().all(|&p| dist(p) >= 0.0) {
        return Some(points.to_vec());
    }
    let mut out = Vec::with_capacity(points.len() + 1);
    for (k, &a) in points.iter().enumerate() {
        let b = points[(k + 1) % points.len()];
        let (da, db) = (dist(a), dist(b));
        if da >= 0.0 {
            out.push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            out.push(a + (b - a) * (da / (da - db)));
        }
    }
    (out.len() >= 3).then_some(out)
}
