//! Cheap tests, worked out when a landblock is loaded, that answer most cell look-ups without the exact ones
//! (`world.md` 10.1, 13). They only ever say "certainly": the answer of the exact test is never changed.

use glam::{Vec2, Vec3};

use crate::constants::{CELL_BSP_SPHERE_FUDGE, EPSILON};
use crate::env_cell::{CellPortal, EnvCell, PortalTarget};
use crate::frame::Frame;
use crate::geometry::{BoundingBox, Plane};
use crate::lanes::{LaneBox, Lanes};
use crate::level_floor::LevelFloor;
use crate::physics_bsp::LEAST_CLEAR_RADIUS;
use crate::plane_quads::PlaneQuads;

/// How far a hint stays away from the exact answer, metres: many times the rounding of coordinates up to
/// [`MAX_COORDINATE`].
const SLACK: f32 = 0.004;
/// Beyond this, f32 is too coarse for the slack, metres.
const MAX_COORDINATE: f32 = 1024.0;

/// Hints of an env cell, in the frame of its landblock.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TransitHints {
    core: Option<LaneBox>,
    /// For each portal, a plane behind which spheres do not touch what it leads to.
    away: Box<[Plane]>,
    /// The same, side by side.
    away_quads: PlaneQuads,
    /// The planes of the cell BSP.
    planes: PlaneQuads,
    /// They are all of them, and the cell holds points at all.
    is_walled: bool,
    /// See [`TransitHints::are_calm`]; inside out when there is none.
    calm: CalmBox,
    /// See [`TransitHints::keeps_lengths`].
    keeps_lengths: bool,
    /// See [`TransitHints::only_floor`].
    only_floor: Option<Lanes>,
    level_floor: LevelFloor,
    /// No polygon of the physics BSP enters this box; inside out when there is none.
    open: OpenSpace,
}

/// Larger spheres are not said to be calm, metres.
const CALM_RADIUS: f32 = 0.5;
/// What of a sphere may be in a polygon and does not overlap it: an overlap must be deeper than epsilon. A quarter of
/// it is for bodies at rest, the rest for rounding, metres.
const SKIN: f32 = 0.25 * EPSILON;

/// A box that is empty unless something else is known.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CalmBox(LaneBox);

impl Default for CalmBox {
    fn default() -> Self {
        CalmBox(LaneBox::NOTHING)
    }
}

/// Open space of a cell in the frame of its landblock.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OpenSpace {
    bounds: LaneBox,
    is_hollow: bool,
}

impl Default for OpenSpace {
    fn default() -> Self {
        OpenSpace {
            bounds: LaneBox::NOTHING,
            is_hollow: false,
        }
    }
}

impl TransitHints {
    /// Memory behind the hints, bytes.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&*self.away) + self.away_quads.memory() + self.planes.memory()
    }

    /// Whether a sphere in the frame of the cell's landblock certainly overlaps no polygon of the cell's physics
    /// BSP, by the tolerance of sphere tests: one that rests on a floor does not.
    #[inline(always)]
    pub fn certainly_clear(&self, center: Lanes, radius: f32) -> bool {
        radius > LEAST_CLEAR_RADIUS && self.open.bounds.holds_cube(center, radius - SKIN)
    }

    /// Whether the cell's rotation keeps lengths, but for a thousandth: stored ones need not.
    #[inline(always)]
    pub fn keeps_lengths(&self) -> bool {
        self.keeps_lengths
    }

    /// The plane, in the frame of the cell's landblock, of the only polygon that looks up, if there is only one: normal
    /// z at least 0.05 in the cell's frame. Its `d` is in the fourth lane.
    #[inline(always)]
    pub fn only_floor(&self) -> Option<Lanes> {
        self.only_floor
    }

    /// The cell's only floor, if it is level.
    #[inline(always)]
    pub fn level_floor(&self) -> &LevelFloor {
        &self.level_floor
    }

    /// Whether no centre of a sphere that is certainly clear is in a leaf that is solid and has polygons.
    #[inline(always)]
    pub fn open_is_hollow(&self) -> bool {
        self.open.is_hollow
    }

    /// Whether `q` is certainly inside the cell.
    #[inline]
    pub(crate) fn certainly_contains(&self, q: Vec3) -> bool {
        match &self.core {
            Some(core) => core.holds(q.into()),
            None => self.is_walled && self.planes.least_distance(q.into()) > SLACK + EPSILON,
        }
    }

    /// Whether two spheres in the frame of the cell's landblock, radii in the fourth lanes, certainly touch no other
    /// cell and overlap no polygon of this one's physics BSP, their centres inside the cell and in nothing solid.
    /// Nobody may be kept out of the cell. Never so for spheres larger than 0.5 m.
    #[inline(always)]
    pub fn are_calm(&self, spheres: [Lanes; 2]) -> bool {
        self.calm.0.hold_upright(spheres, SKIN)
    }

    /// How far two spheres may be shifted together and certainly stay away from each portal and what it leads to,
    /// metres, four portals at a time; those there are not are infinitely far. Zero or less: nothing is certain.
    /// Nothing where the cell has no hints.
    #[inline(always)]
    pub(crate) fn distances_away(&self, [a, b]: [Lanes; 2]) -> impl Iterator<Item = Lanes> {
        let reach = |s: Lanes| Lanes::splat(-(s.fourth() + (CELL_BSP_SPHERE_FUDGE + SLACK)));
        let (reach_a, reach_b) = (reach(a), reach(b));
        let quads = self.away_quads.quads().iter();
        quads.map(move |quad| {
            let to_a = reach_a - Lanes::four_distances(quad, a);
            let to_b = reach_b - Lanes::four_distances(quad, b);
            to_a.lesser(to_b)
        })
    }

    /// Whether one of two spheres touches the cell, and how far they may be shifted together without changing it,
    /// metres. Zero or less: nothing is certain.
    #[inline(always)]
    pub(crate) fn distance_to_change(&self, [a, b]: [Lanes; 2]) -> (bool, f32) {
        // How deep each is inside the plane it is least inside of; the deeper counts.
        let depth = |s: Lanes| self.planes.least_distance(s) + (s.fourth() + CELL_BSP_SPHERE_FUDGE);
        let (depth_a, depth_b) = (depth(a), depth(b));
        let deepest = if depth_b > depth_a { depth_b } else { depth_a };
        if deepest < 0.0 {
            (false, -deepest - SLACK)
        } else if self.is_walled {
            (true, deepest - SLACK)
        } else {
            // Planes that are not known may keep the spheres out.
            (true, 0.0)
        }
    }

    /// How far a point may be shifted and certainly stays inside the cell, metres. Zero or less: nothing is certain.
    #[inline(always)]
    pub(crate) fn distance_inside(&self, p: Lanes) -> f32 {
        if let Some(core) = &self.core {
            return core.depth(p);
        }
        if !self.is_walled {
            return 0.0;
        }
        self.planes.least_distance(p) - (SLACK + EPSILON)
    }

    /// Whether a point is certainly not inside the cell.
    #[inline(always)]
    pub(crate) fn certainly_lacks(&self, p: Lanes) -> bool {
        self.planes.least_distance(p) < -(SLACK + EPSILON)
    }

    /// How far spheres may be shifted together and certainly stay outside the cell, metres. Zero or less: nothing
    /// is certain.
    #[inline]
    pub(crate) fn outside_distance(&self, spheres: [Lanes; 2]) -> f32 {
        let mut least = f32::INFINITY;
        for s in spheres {
            let d = -(s.fourth() + (CELL_BSP_SPHERE_FUDGE + SLACK)) - self.planes.least_distance(s);
            let d = if d > 0.0 { d } else { 0.0 };
            least = if d < least { d } else { least };
        }
        least * UNIT_TOLERANCE
    }

    /// Whether a sphere is certainly out of reach of portal `index` and what it leads to.
    #[inline]
    pub(crate) fn certainly_away(&self, index: usize, center: Vec3, radius: f32) -> bool {
        match self.away.get(index) {
            Some(plane) => plane.dist(center) < -(radius + (CELL_BSP_SPHERE_FUDGE + SLACK)),
            None => false,
        }
    }

    /// Whether spheres of a radius with centres between these upright columns certainly do not touch the cell.
    pub(crate) fn keeps_away_columns(&self, corners: &[Vec2; 4], radius: f32) -> bool {
        let reach = Lanes::splat(-(radius + (CELL_BSP_SPHERE_FUDGE + SLACK)));
        self.planes.quads().iter().any(|quad| {
            let mut beyond = Lanes::splat(0.0).equal(quad[2]);
            for corner in corners {
                beyond &= Lanes::four_distances(quad, corner.extend(0.0).into()).less(reach);
            }
            beyond != 0
        })
    }

    /// Whether a sphere certainly does not touch the cell.
    #[inline]
    pub(crate) fn certainly_outside(&self, center: Vec3, radius: f32) -> bool {
        self.planes.least_distance(center.into()) < -(radius + (CELL_BSP_SPHERE_FUDGE + SLACK))
    }
}

/// Normals that count as unit vectors may be this much longer.
pub(crate) const UNIT_TOLERANCE: f32 = 0.999;

/// A plane of a cell in the frame of its landblock; without effect when it cannot be trusted.
fn in_landblock(frame: &Frame, plane: &Plane) -> Plane {
    let normal = frame.local_to_global_vec(plane.normal);
    let d = plane.d - normal.dot(frame.origin);
    let length = normal.dot(normal);
    let sound = (length - 1.0).abs() < 1e-3 && d.abs() < 2.0 * MAX_COORDINATE;
    if sound { Plane { normal, d } } else { NO_HINT }
}

/// A plane that no sphere is behind.
const NO_HINT: Plane = Plane {
    normal: Vec3::ZERO,
    d: f32::INFINITY,
};

/// Whether a cell lies where hints can be trusted.
fn is_near(cell: &EnvCell) -> bool {
    let box_ = cell
        .structure
        .bounds
        .map(|b| b.mapped(|p| cell.frame.local_to_global(p)));
    box_.is_some_and(|b| {
        b.min.abs().max_element() < MAX_COORDINATE && b.max.abs().max_element() < MAX_COORDINATE
    })
}

/// Whether a cell has so many portals or planes, by the thousand, that hints would take longer than they save.
/// Retail's have 27 portals at most.
fn is_overgrown(cell: &EnvCell) -> bool {
    cell.portals.len() > 256 || cell.structure.cell_bsp.planes().len() > 256
}

/// Works out the hints of all env cells of a landblock.
pub(crate) fn set_hints(cells: &mut [Option<EnvCell>]) {
    let hints: Vec<Option<TransitHints>> = cells
        .iter()
        .map(|cell| cell.as_ref().map(|cell| hints_of(cell, cells)))
        .collect();
    for (cell, hints) in cells.iter_mut().zip(hints) {
        if let (Some(cell), Some(hints)) = (cell, hints) {
            cell.hints = hints;
        }
    }
}

/// Works the hints of cell `index` about its neighbours out again, after some became resident or ceased to be.
pub(crate) fn refresh_away(cells: &mut [Option<EnvCell>], index: usize) {
    let Some(Some(cell)) = cells.get(index) else {
        return;
    };
    if cell.hints.away.is_empty() {
        return;
    }
    let away: Box<[Plane]> = cell
        .portals
        .iter()
        .map(|portal| away_from(cell, portal, cells))
        .collect();
    if let Some(Some(cell)) = cells.get_mut(index) {
        cell.hints.calm = calm_box(cell, cell.hints.core, &cell.hints.open, &away);
        cell.hints.away_quads = PlaneQuads::new(&away, f32::NEG_INFINITY);
        cell.hints.away = away;
    }
}

fn hints_of(cell: &EnvCell, cells: &[Option<EnvCell>]) -> TransitHints {
    if !is_near(cell) || is_overgrown(cell) {
        return TransitHints::default();
    }
    let planes = global_planes(cell);
    let core = core_of(cell);
    let away: Box<[Plane]> = cell
        .portals
        .iter()
        .map(|portal| away_from(cell, portal, cells))
        .collect();
    let open = open_space_of(cell);
    TransitHints {
        calm: calm_box(cell, core, &open, &away),
        core,
        is_walled: !cell.portals.is_empty() && planes.len() == cell.structure.cell_bsp.planes().len(),
        away_quads: PlaneQuads::new(&away, f32::NEG_INFINITY),
        away,
        planes: PlaneQuads::new(&planes, f32::INFINITY),
        keeps_lengths: (Lanes::of_rotation(cell.frame.rotation()).squared_length() - 1.0).abs() < 2e-4,
        only_floor: only_floor_of(cell),
        level_floor: LevelFloor::of(cell),
        open,
    }
}

fn only_floor_of(cell: &EnvCell) -> Option<Lanes> {
    let face = cell.structure.physics.as_ref()?.only_face_up()?;
    Some(cell.frame.plane_out(&face.plane))
}

/// The open space of the cell's physics BSP, or a part of it that is square to the landblock.
fn open_space_of(cell: &EnvCell) -> OpenSpace {
    /// Beyond this, rounding eats up the tolerance of sphere tests, metres.
    const MAX_OPEN_COORDINATE: f32 = 256.0;
    /// Quarter turns as stored are this exact over the size of a room, metres.
    const TURN: f32 = 2e-5;
    let Some(physics) = &cell.structure.physics else {
        return OpenSpace::default();
    };
    let local = physics.open_box();
    if !(local.min.is_finite() && local.max.is_finite()) {
        return OpenSpace::default();
    }
    let hull = local.mapped(|p| cell.frame.local_to_global(p));
    let (center, half) = ((hull.min + hull.max) * 0.5, (hull.max - hull.min) * 0.5);
    let outer = BoundingBox {
        min: local.min - Vec3::splat(TURN),
        max: local.max + Vec3::splat(TURN),
    };
    let fits = |b: &BoundingBox| {
        let near = |v: Vec3| v.abs().max_element() < MAX_OPEN_COORDINATE;
        near(b.min)
            && near(b.max)
            && b.corners().iter().all(|&c| {
                let p = cell.frame.global_to_local(c);
                p.cmpge(outer.min).all() && p.cmple(outer.max).all()
            })
    };
    let shrunk = |k: f32| BoundingBox {
        min: center - Vec3::new(half.x * k, half.y * k, half.z),
        max: center + Vec3::new(half.x * k, half.y * k, half.z),
    };
    let exact = BoundingBox {
        min: hull.min,
        max: hull.max,
    };
    let candidates = [
        exact,
        shrunk(0.9),
        shrunk(0.8),
        shrunk(0.7),
        shrunk(0.6),
        shrunk(0.5),
    ];
    match candidates.iter().find(|b| fits(b)) {
        Some(&bounds) => OpenSpace {
            bounds: LaneBox::new(&bounds),
            is_hollow: physics.open_is_hollow(),
        },
        None => OpenSpace::default(),
    }
}

/// See [`TransitHints::are_calm`]: the part of a cell's core that is far from all it leads to, and in its open space.
fn calm_box(cell: &EnvCell, core: Option<LaneBox>, open: &OpenSpace, away: &[Plane]) -> CalmBox {
    if !open.is_hollow || cell.restriction.is_some() {
        return CalmBox::default();
    }
    let Some(mut found) = lonely_box(core, away) else {
        return CalmBox::default();
    };
    let open = open.bounds.bounds();
    for k in 0..2 {
        found.min[k] = greater(found.min[k], open.min[k] + CALM_RADIUS);
        found.max[k] = lesser(found.max[k], open.max[k] - CALM_RADIUS);
    }
    // Along z all of a sphere is held against the box: no centre comes nearer to the open space's sides.
    let inset = LEAST_CLEAR_RADIUS - EPSILON;
    if found.min.z < open.min.z + inset {
        found.min.z = open.min.z;
    }
    if found.max.z > open.max.z - inset {
        found.max.z = open.max.z;
    }
    CalmBox(LaneBox::new(&found).with_fourth(LEAST_CLEAR_RADIUS, CALM_RADIUS.next_up()))
}

fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Where the centres of spheres of up to [`CALM_RADIUS`] are inside a cell and touch nothing that it leads to.
fn lonely_box(core: Option<LaneBox>, away: &[Plane]) -> Option<BoundingBox> {
    const REACH: f32 = CALM_RADIUS + CELL_BSP_SPHERE_FUDGE + SLACK;
    let mut found = core?.bounds();
    for plane in away {
        let n = plane.normal;
        let k = (0..3).fold(0, |k, i| if n[i].abs() > n[k].abs() { i } else { k });
        // Where the plane is crossed, a little on the safe side: it may be tilted by rounding.
        let limit = (-(REACH + SLACK) - plane.d) / n[k];
        if n[k] > 0.0 && limit < found.max[k] {
            found.max[k] = limit;
        } else if n[k] < 0.0 && limit > found.min[k] {
            found.min[k] = limit;
        }
    }
    let is_far = |c: &Vec3| away.iter().all(|plane| plane.dist(*c) <= -REACH);
    ((found.max - found.min).min_element() > 0.0 && found.corners().iter().all(is_far)).then_some(found)
}

fn global_planes(cell: &EnvCell) -> Box<[Plane]> {
    let planes = cell.structure.cell_bsp.planes();
    planes
        .iter()
        .map(|plane| in_landblock(&cell.frame, plane))
        .filter(|p| *p != NO_HINT)
        .collect()
}

/// A box inside which a point is certainly in the cell.
fn core_of(cell: &EnvCell) -> Option<LaneBox> {
    if cell.portals.is_empty() {
        return None;
    }
    let bounds = cell.structure.bounds?.mapped(|p| cell.frame.local_to_global(p));
    let (center, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
    let inside = |b: &BoundingBox| {
        b.corners().iter().all(|&c| {
            let local = cell.frame.global_to_local(c);
            cell.structure
                .cell_bsp
                .planes()
                .iter()
                .all(|plane| plane.dist(local) > SLACK + EPSILON)
        })
    };
    let shrunk = |by: Vec3| BoundingBox {
        min: center - by,
        max: center + by,
    };
    let margin = Vec3::splat(SLACK * 2.0);
    let candidates = [
        half - margin,
        half * 0.9,
        half * 0.8,
        half * 0.7,
        half * 0.6,
        half * 0.5,
    ];
    candidates
        .into_iter()
        .filter(|by| by.min_element() > 0.0)
        .map(shrunk)
        .find(inside)
        .map(|b| LaneBox::new(&b))
}

/// The plane that best keeps the cell apart from what a portal leads to: it points to the far side.
fn away_from(cell: &EnvCell, portal: &CellPortal, cells: &[Option<EnvCell>]) -> Plane {
    let own = if portal.interior_is_negative {
        portal.plane
    } else {
        Plane {
            normal: -portal.plane.normal,
            d: -portal.plane.d,
        }
    };
    let neighbour = match portal.other {
        PortalTarget::Outside => None,
        PortalTarget::Cell(id) if id.block() != cell.id.block() => return NO_HINT,
        PortalTarget::Cell(id) => cells
            .get(usize::from(id.low()).wrapping_sub(0x100))
            .and_then(Option::as_ref),
    };
    let Some(neighbour) = neighbour else {
        return in_landblock(&cell.frame, &own);
    };
    if !is_near(neighbour) || is_overgrown(neighbour) {
        return NO_HINT;
    }
    let Some(bounds) = cell.structure.bounds else {
        return NO_HINT;
    };
    let center = cell.frame.local_to_global((bounds.min + bounds.max) * 0.5);
    let mut best = NO_HINT;
    let mut least = f32::INFINITY;
    for plane in global_planes(neighbour) {
        let dist = plane.dist(center);
        if dist < least {
            (best, least) = (plane, dist);
        }
    }
    best
}
