//! Plans routes on foot: through a portal into the next cell, or over land to a place.
//!
//! Ways are tried out with the same sweeps that walk them, so what is planned can be walked: straight through the middle
//! of an opening where that works, else along a lattice searched nearest first. Only ways that can be walked in both
//! directions count; drops do not.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::{Vec2, Vec3};
use vestibule_world::ids::block_offset;
use vestibule_world::{BlockId, CellId, CellPortal, EnvCell, PortalTarget, World};

use crate::walker::{Footing, Walker};

/// Spacing of the lattice inside cells, metres: finds ways through openings 1.2 m wide.
const FINE: f32 = 0.2;
/// Spacing of the lattice over land, metres.
const COARSE: f32 = 1.0;
/// Lattice points looked at before a way is given up.
const MAX_NODES: usize = 12_000;
/// Distances before and behind an opening that straight ways aim at, metres.
const ANCHORS: [f32; 3] = [0.8, 0.45, 0.25];

/// An opening of an env cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PortalId {
    /// The cell.
    pub cell: CellId,
    /// Index of the portal in the cell's record.
    pub portal: u16,
}

/// An opening, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Which one.
    pub id: PortalId,
    /// Where it leads.
    pub to: PortalTarget,
    /// The same opening as the cell behind it has it.
    pub opposite: Option<PortalId>,
    /// Its corners in the frame of the cell's landblock, metres.
    pub corners: Vec<Vec3>,
    /// Middle of the corners.
    pub middle: Vec3,
    /// Unit vector out of the cell.
    pub outward: Vec3,
    /// Exact match of both portal polygons.
    pub exact: bool,
}

impl Opening {
    /// The opening of a portal.
    pub fn of(cell: &EnvCell, portal: &CellPortal) -> Self {
        let corners: Vec<Vec3> = cell
            .portal_vertices(portal)
            .iter()
            .map(|&v| cell.frame.local_to_global(v))
            .collect();
        let middle = corners.iter().copied().sum::<Vec3>() / corners.len().max(1) as f32;
        let normal = cell.frame.local_to_global_vec(portal.plane.normal);
        let opposite = match (portal.other, portal.other_portal) {
            (PortalTarget::Cell(cell), Some(portal)) => Some(PortalId { cell, portal }),
            _ => None,
        };
        Opening {
            id: PortalId {
                cell: cell.id,
                portal: portal.record_index,
            },
            to: portal.other,
            opposite,
            corners,
            middle,
            outward: if portal.interior_is_negative {
                normal
            } else {
                -normal
            },
            exact: portal.exact_match,
        }
    }

    /// Width over the ground and height, metres.
    pub fn size(&self) -> (f32, f32) {
        let mut width = 0.0f32;
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for (i, a) in self.corners.iter().enumerate() {
            for b in self.corners.iter().skip(i + 1) {
                width = width.max(a.truncate().distance(b.truncate()));
            }
            low = low.min(a.z);
            high = high.max(a.z);
        }
        (width, if high > low { high - low } else { 0.0 })
    }

    /// Whether it lies flat, as a hole in a floor does.
    pub fn is_flat(&self) -> bool {
        self.outward.z.abs() > 0.7
    }

    /// In a few words: `opening 1.6 x 2.5 m`.
    pub fn in_words(&self) -> String {
        let (width, height) = self.size();
        if self.is_flat() {
            format!("floor opening {width:.1} m wide")
        } else {
            format!("opening {width:.1} x {height:.1} m")
        }
    }
}

/// The openings of a cell in record order.
pub fn openings(world: &World, cell: CellId) -> Vec<Opening> {
    let Some(cell) = world.env_cell(cell) else {
        return Vec::new();
    };
    cell.portals
        .iter()
        .map(|portal| Opening::of(cell, portal))
        .collect()
}

/// The openings by which buildings of a landblock can be entered from the land.
pub fn entrances(world: &World, block: BlockId) -> Vec<Opening> {
    let Some(block) = world.block(block) else {
        return Vec::new();
    };
    let portals = block.buildings.iter().flat_map(|building| &building.portals);
    portals
        .filter_map(|portal| {
            let cell = world.env_cell(portal.other)?;
            let inner = cell.portal(portal.other_portal?)?;
            Some(Opening::of(cell, inner))
        })
        .collect()
}

/// A planned way: points over the ground in the frame of the walker's routes.
pub type Way = Vec<Vec2>;

/// What to do next along a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steer {
    /// Go by this over the ground, metres.
    Go(Vec2),
    /// The way has led where it should.
    Arrived,
    /// There is no progress, or the way has ended elsewhere.
    Lost,
}

/// Follows a way in short steps.
#[derive(Clone, Debug)]
pub struct Steering<'w> {
    way: &'w [Vec2],
    next: usize,
    step: f32,
    last: Option<Vec2>,
    heading: Vec2,
    stuck: u32,
    overshoot: u32,
}

/// Steps without progress after which a way is given up.
const STUCK_STEPS: u32 = 15;
/// Steps taken beyond the end of a way that has not yet led into its cell.
const OVERSHOOT_STEPS: u32 = 8;
/// How near a point of the way counts as there, metres.
const NEAR: f32 = 0.04;

impl<'w> Steering<'w> {
    /// Steers along `way` in steps of `step` metres.
    pub fn new(way: &'w [Vec2], step: f32) -> Self {
        Steering {
            way,
            next: 0,
            step,
            last: None,
            heading: Vec2::ZERO,
            stuck: 0,
            overshoot: 0,
        }
    }

    /// The next step from `here`; `arrived` says whether the player is where the way should lead.
    pub fn next(&mut self, here: Vec2, arrived: bool) -> Steer {
        if let Some(last) = self.last.replace(here) {
            let moved = last.distance(here) >= 0.2 * self.step;
            self.stuck = if moved { 0 } else { self.stuck + 1 };
            if self.stuck >= STUCK_STEPS {
                return Steer::Lost;
            }
        }
        while let Some(&point) = self.way.get(self.next) {
            let left = point - here;
            if left.length() > NEAR {
                self.heading = left.normalize_or_zero();
                return Steer::Go(left.clamp_length_max(self.step));
            }
            self.next += 1;
            self.stuck = 0;
        }
        if arrived {
            return Steer::Arrived;
        }
        // The way may end on the very edge of the cell it leads to.
        if self.overshoot >= OVERSHOOT_STEPS {
            return Steer::Lost;
        }
        self.overshoot += 1;
        Steer::Go(self.heading * self.step)
    }
}

/// A step from cell to cell: an opening, and whether it is gone through into its cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    /// The opening.
    pub opening: Opening,
    /// Into the opening's cell, rather than out of it.
    pub inward: bool,
}

impl Passage {
    /// A way through it on foot.
    pub fn way(&self, walker: &mut Walker<'_>, from: &Footing) -> Option<Way> {
        through(walker, from, &self.opening, self.inward)
    }

    /// Whether a cell is on its far side.
    pub fn leads_to(&self, cell: CellId) -> bool {
        if self.inward {
            return cell == self.opening.id.cell;
        }
        match self.opening.to {
            PortalTarget::Outside => !cell.is_indoor(),
            PortalTarget::Cell(other) => cell == other,
        }
    }
}

/// The fewest passages from one cell to another, by portals alone, without those that are `barred`. All land cells count
/// as one place; entrances are those of the landblocks around both cells.
pub fn passages(world: &World, from: CellId, to: CellId, barred: &[PortalId]) -> Option<Vec<Passage>> {
    let place = |cell: CellId| if cell.is_indoor() { cell } else { CellId::NONE };
    let (start, goal) = (place(from), place(to));
    let mut blocks: Vec<BlockId> = Vec::new();
    for home in [from.block(), to.block()] {
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
            blocks.extend(home.neighbour(dx, dy).filter(|b| !blocks.contains(b)));
        }
    }
    let mut reached: HashMap<CellId, Option<(CellId, Passage)>> = HashMap::from([(start, None)]);
    let mut queue = std::collections::VecDeque::from([start]);
    while let Some(here) = queue.pop_front() {
        if here == goal {
            let mut out = Vec::new();
            let mut at = goal;
            while let Some(Some((before, passage))) = reached.get(&at) {
                out.push(passage.clone());
                at = *before;
            }
            out.reverse();
            return Some(out);
        }
        let next: Vec<Passage> = if here.is_none() {
            let entrances = blocks.iter().flat_map(|&block| entrances(world, block));
            entrances
                .map(|opening| Passage {
                    opening,
                    inward: true,
                })
                .collect()
        } else {
            openings(world, here)
                .into_iter()
                .map(|opening| Passage {
                    opening,
                    inward: false,
                })
                .collect()
        };
        for passage in next.into_iter().filter(|p| !barred.contains(&p.opening.id)) {
            let there = match (passage.inward, passage.opening.to) {
                (true, _) => passage.opening.id.cell,
                (false, PortalTarget::Outside) => CellId::NONE,
                (false, PortalTarget::Cell(cell)) => cell,
            };
            if !reached.contains_key(&there) && (there.is_none() || world.env_cell(there).is_some()) {
                reached.insert(there, Some((here, passage)));
                queue.push_back(there);
            }
        }
    }
    None
}

/// A way through an opening, out of its cell, ending in what is behind it.
pub fn out_through(walker: &mut Walker<'_>, from: &Footing, opening: &Opening) -> Option<Way> {
    through(walker, from, opening, false)
}

/// A way through an opening into its cell, from what is behind it.
pub fn in_through(walker: &mut Walker<'_>, from: &Footing, opening: &Opening) -> Option<Way> {
    through(walker, from, opening, true)
}

fn through(walker: &mut Walker<'_>, from: &Footing, opening: &Opening, inward: bool) -> Option<Way> {
    let own = opening.id.cell;
    let arrived = |cell: CellId| {
        if inward {
            cell == own
        } else {
            match opening.to {
                PortalTarget::Outside => !cell.is_indoor(),
                PortalTarget::Cell(other) => cell == other,
            }
        }
    };
    if let Some(way) = straight_through(walker, from, opening, inward, &arrived) {
        return Some(way);
    }
    // Over land to the front of the opening first, where that is far.
    let front = front_of(walker, opening, if inward { 1.2 } else { -1.2 });
    let mut start = *from;
    let mut way = Way::new();
    let here = walker.point(&from.at).truncate();
    if !from.at.cell.is_indoor() && front.distance(here) > 3.0 {
        let near = |_: &Footing, p: Vec3| front.distance(p.truncate()) <= 1.5 * COARSE;
        let (first, end) = search(walker, from, front, COARSE, &|cell| !cell.is_indoor(), &near)?;
        way.extend(first);
        start = end;
        if let Some(rest) = straight_through(walker, &start, opening, inward, &arrived) {
            way.extend(rest);
            return Some(way);
        }
    }
    let middle = middle_of(walker, opening);
    let started_in = start.at.cell;
    let allowed = |cell: CellId| cell == own || arrived(cell) || same_side(cell, started_in);
    let goal = |footing: &Footing, _: Vec3| arrived(footing.at.cell);
    let (rest, _) = search(walker, &start, middle, FINE, &allowed, &goal)?;
    way.extend(rest);
    Some(way)
}

/// Middle of an opening over the ground, in the frame of the routes.
fn middle_of(walker: &Walker<'_>, opening: &Opening) -> Vec2 {
    let offset = walker.local(opening.id.cell.block(), Vec3::ZERO);
    (opening.middle - offset).truncate()
}

/// A point before the opening, seen from outside its cell (behind it where `distance` is negative).
fn front_of(walker: &Walker<'_>, opening: &Opening, distance: f32) -> Vec2 {
    middle_of(walker, opening) + opening.outward.truncate().normalize_or_zero() * distance
}

fn straight_through(
    walker: &mut Walker<'_>,
    from: &Footing,
    opening: &Opening,
    inward: bool,
    arrived: &dyn Fn(CellId) -> bool,
) -> Option<Way> {
    if opening.is_flat() {
        return None;
    }
    let before = |cell: CellId| same_side(from.at.cell, cell);
    let both = |cell: CellId| before(cell) || arrived(cell);
    let sign = if inward { 1.0 } else { -1.0 };
    // Straight through the middle, from as far before as there is room.
    for distance in ANCHORS {
        let first = front_of(walker, opening, sign * distance);
        let Some(at_first) = walker.straight(from, first, &before) else {
            continue;
        };
        for behind in ANCHORS {
            let second = front_of(walker, opening, -sign * behind);
            if walker
                .straight(&at_first, second, &both)
                .is_some_and(|end| arrived(end.at.cell))
            {
                return Some(vec![first, second]);
            }
        }
    }
    // From where the player is, as out of a cell that is only as deep as a wall.
    for behind in ANCHORS {
        let second = front_of(walker, opening, -sign * behind);
        if walker
            .straight(from, second, &both)
            .is_some_and(|end| arrived(end.at.cell))
        {
            return Some(vec![second]);
        }
    }
    None
}

/// Whether going from one cell to the other needs no opening: they are the same, or both outdoors.
pub fn same_side(a: CellId, b: CellId) -> bool {
    a == b || !a.is_indoor() && !b.is_indoor()
}

/// A way over the ground of one cell, or over land, to a point: straight, else along the lattice.
pub fn to_point(walker: &mut Walker<'_>, from: &Footing, to: Vec2) -> Option<Way> {
    let cell = from.at.cell;
    let allowed = |other: CellId| same_side(cell, other);
    if walker.straight(from, to, &allowed).is_some() {
        return Some(vec![to]);
    }
    let grid = if cell.is_indoor() { FINE } else { COARSE };
    let near = |_: &Footing, p: Vec3| to.distance(p.truncate()) <= grid;
    search(walker, from, to, grid, &allowed, &near).map(|(way, _)| way)
}

/// A lattice point that has been reached.
struct Node {
    footing: Footing,
    parent: usize,
    cost: f32,
}

/// Searches the lattice, nearest to `target` first. Answers the way, with corners that can be cut cut, and where it ends.
fn search(
    walker: &mut Walker<'_>,
    from: &Footing,
    target: Vec2,
    grid: f32,
    allowed: &dyn Fn(CellId) -> bool,
    goal: &dyn Fn(&Footing, Vec3) -> bool,
) -> Option<(Way, Footing)> {
    let key = |p: Vec3, cell: CellId| {
        let at = |v: f32| (v / grid).round() as i32;
        // Two floors over one another in one cell are more than this apart.
        (
            at(p.x),
            at(p.y),
            (p.z / 1.5).round() as i32,
            if cell.is_indoor() { cell.0 } else { 0 },
        )
    };
    let mut nodes = vec![Node {
        footing: *from,
        parent: 0,
        cost: 0.0,
    }];
    let mut known: HashMap<(i32, i32, i32, u32), usize> = HashMap::new();
    known.insert(key(walker.point(&from.at), from.at.cell), 0);
    // Ordered by estimated cost in millimetres, then by age: the same world gives the same way.
    let mut open = BinaryHeap::new();
    open.push(Reverse((0u32, 0usize)));
    while let Some(Reverse((_, index))) = open.pop() {
        let footing = nodes.get(index)?.footing;
        let cost = nodes.get(index)?.cost;
        let here = walker.point(&footing.at);
        if goal(&footing, here) {
            return Some((cut_corners(walker, &nodes, index, allowed), footing));
        }
        if nodes.len() > MAX_NODES {
            return None;
        }
        let (ix, iy, ..) = key(here, footing.at.cell);
        for (dx, dy) in [
            (1, 0),
            (0, 1),
            (-1, 0),
            (0, -1),
            (1, 1),
            (-1, 1),
            (-1, -1),
            (1, -1),
        ] {
            let next = Vec2::new((ix + dx) as f32, (iy + dy) as f32) * grid;
            let Some(reached) = walker.straight(&footing, next, allowed) else {
                continue;
            };
            let there = walker.point(&reached.at);
            let length = cost + here.distance(there);
            let key = key(there, reached.at.cell);
            if known
                .get(&key)
                .and_then(|&i| nodes.get(i))
                .is_some_and(|old| old.cost <= length + 1e-3)
            {
                continue;
            }
            let estimate = length + there.truncate().distance(target);
            known.insert(key, nodes.len());
            open.push(Reverse(((estimate * 1000.0) as u32, nodes.len())));
            nodes.push(Node {
                footing: reached,
                parent: index,
                cost: length,
            });
        }
    }
    None
}

/// The points from the start to node `end`, less those that a straight walk can leave out.
fn cut_corners(walker: &mut Walker<'_>, nodes: &[Node], end: usize, allowed: &dyn Fn(CellId) -> bool) -> Way {
    let mut chain = vec![end];
    let mut at = end;
    while let Some(node) = nodes.get(at).filter(|_| at != 0) {
        at = node.parent;
        chain.push(at);
    }
    chain.reverse();
    let footings: Vec<Footing> = chain
        .iter()
        .filter_map(|&i| nodes.get(i))
        .map(|n| n.footing)
        .collect();
    let mut way = Way::new();
    let mut i = 0;
    while i + 1 < footings.len() {
        let mut j = i + 1;
        // Leaps of at most 32 points keep this linear.
        for far in (i + 2..footings.len().min(i + 32)).rev() {
            let (Some(a), Some(b)) = (footings.get(i), footings.get(far)) else {
                break;
            };
            let to = walker.point(&b.at);
            let reached = walker.straight(a, to.truncate(), allowed);
            if reached.is_some_and(|r| r.at.cell == b.at.cell && (walker.point(&r.at).z - to.z).abs() < 0.3) {
                j = far;
                break;
            }
        }
        if let Some(footing) = footings.get(j) {
            way.push(walker.point(&footing.at).truncate());
        }
        i = j;
    }
    way
}

/// A point's distance over the ground to the middle of an opening, both in landblock frames.
pub fn distance_to(opening: &Opening, block: BlockId, point: Vec3) -> f32 {
    let middle = opening.middle + block_offset(block, opening.id.cell.block());
    middle.truncate().distance(point.truncate())
}
