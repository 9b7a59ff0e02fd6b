//! Walks through physics BSPs (`transition.md` 6.1, 6.3, 6.4, 6.6, 6.8, 6.9). Everything is in the tree's space.
//!
//! All walks share a skeleton: prune by the node's bounding sphere, follow one side while the sphere does not
//! straddle the plane, both sides in the order of the rule where it does. They loop along the single side and
//! recurse only where the sphere straddles.

use glam::Vec3;
use vestibule_world::{Child, ChildKind, Face, Lanes, PhysicsBsp, PhysicsNode, SURE_OVERLAP, Sphere};

use crate::constants::{ADJUST_TO_PLANE_BUDGET, BISECTION_STOP, EPSILON};
use crate::polygon::{self, Overlap};

/// Whether two spheres overlap as the walks see it: grazing ones do (6.1).
#[inline]
pub(crate) fn spheres_overlap(a: &Sphere, b: &Sphere) -> bool {
    let between = a.center - b.center;
    let reach = a.radius + b.radius;
    between.dot(between) - reach * reach < EPSILON
}

/// Which children of a node a sphere reaches.
pub(crate) enum Reach {
    /// Neither: the node is pruned.
    None,
    /// In front only.
    Positive,
    /// Behind only.
    Negative,
    /// Both; the distance of the centre from the plane.
    Both(f32),
}

/// `radius` is the sphere's own except where a rule says otherwise; the prune always uses the sphere.
#[inline]
pub(crate) fn reach(node: &PhysicsNode, s: &Sphere, radius: f32) -> Reach {
    // A PORT node has no sphere and is not pruned.
    if node.sphere.is_some_and(|bound| !spheres_overlap(&bound, s)) {
        return Reach::None;
    }
    let dist = node.plane.dist(s.center);
    let reach = radius - EPSILON;
    if dist >= reach {
        Reach::Positive
    } else if dist <= -reach {
        Reach::Negative
    } else {
        Reach::Both(dist)
    }
}

/// The faces of a leaf that the sphere may touch: none when there are none or its bounding sphere is missed.
#[inline]
pub(crate) fn reached_faces<'b>(bsp: &'b PhysicsBsp, leaf: usize, s: &Sphere) -> &'b [Face] {
    match bsp.leaves().get(leaf) {
        Some(leaf) if leaf.count != 0 && spheres_overlap(&leaf.sphere, s) => bsp.faces_of(leaf),
        _ => &[],
    }
}

/// The first polygon that the sphere overlaps and moves into (6.4). `named` is left at the last polygon it
/// overlapped, moved into or not (6.5.3).
#[inline(always)]
pub(crate) fn sphere_intersects_poly<'b>(
    bsp: &'b PhysicsBsp,
    s: Lanes,
    movement: Lanes,
    named: &mut Option<&'b Face>,
) -> bool {
    !bsp.certainly_clear(s) && finds_poly(bsp, s, movement, named)
}

#[inline(never)]
fn finds_poly<'b>(bsp: &'b PhysicsBsp, s: Lanes, movement: Lanes, named: &mut Option<&'b Face>) -> bool {
    let mut hits = SureHits::default();
    let unsure = bsp.any_face_near(s, false, |face, distance| {
        let overlap = polygon::overlap_at(face, bsp.edge_quads(face), s, distance);
        overlap != Overlap::None && !(is_sure(bsp, face, overlap, s) && hits.add(face))
    });
    if unsure != Some(false) {
        return intersects_poly(bsp, bsp.root, &s.into(), movement.xyz(), named);
    }
    for face in hits.in_order() {
        *named = Some(face);
        if movement.dot(Lanes::of_plane(&face.plane)) < 0.0 {
            return true;
        }
    }
    false
}

/// A few polygons that a walk is certain to find, in the order in which it finds them.
#[derive(Default)]
struct SureHits<'b> {
    faces: [Option<&'b Face>; 6],
    count: usize,
}

impl<'b> SureHits<'b> {
    /// `false`: there is no room, or the order is not certain.
    #[inline]
    fn add(&mut self, face: &'b Face) -> bool {
        let mut i = self.count;
        if i == self.faces.len() {
            return false;
        }
        while let Some(Some(before)) = i.checked_sub(1).map(|k| self.faces[k]) {
            if before.is_met_before(face) {
                break;
            }
            if !face.is_met_before(before) {
                return false;
            }
            self.faces[i] = Some(before);
            i -= 1;
        }
        self.faces[i] = Some(face);
        self.count += 1;
        true
    }

    fn in_order(&self) -> impl Iterator<Item = &'b Face> {
        self.faces.iter().map_while(|face| *face)
    }
}

/// The polygons that a sphere overlaps, found without a walk.
enum Hits<'b> {
    None,
    One(&'b Face, Overlap),
    /// More than one, or the tree is too large to tell quickly.
    Several,
}

/// The polygons that pass `filter` and overlap the sphere. With `only_up` those that hardly look up may be left
/// out.
#[inline]
fn hits<'b>(bsp: &'b PhysicsBsp, s: Lanes, only_up: bool, filter: impl Fn(&Face) -> bool) -> Hits<'b> {
    let mut hit = None;
    let several = bsp.any_face_near(s, only_up, |face, distance| {
        if !filter(face) {
            return false;
        }
        let overlap = polygon::overlap_at(face, bsp.edge_quads(face), s, distance);
        overlap != Overlap::None && hit.replace((face, overlap)).is_some()
    });
    match (several, hit) {
        (Some(false), None) => Hits::None,
        (Some(false), Some((face, overlap))) => Hits::One(face, overlap),
        _ => Hits::Several,
    }
}

/// Whether a walk is certain to reach a polygon that the sphere overlaps: when the overlap is deep enough.
#[inline(always)]
pub(crate) fn is_sure(bsp: &PhysicsBsp, face: &Face, overlap: Overlap, s: Lanes) -> bool {
    face.sound
        && match overlap {
            Overlap::Inside(dist) => dist <= s.fourth() - (SURE_OVERLAP + EPSILON),
            _ => polygon::hits_deeper(face, bsp.edge_quads(face), s, SURE_OVERLAP),
        }
}

fn intersects_poly<'b>(
    bsp: &'b PhysicsBsp,
    mut at: Child,
    s: &Sphere,
    movement: Vec3,
    named: &mut Option<&'b Face>,
) -> bool {
    loop {
        match at.kind() {
            ChildKind::Absent => return false,
            ChildKind::Leaf(leaf) => {
                for face in reached_faces(bsp, leaf, s) {
                    if polygon::polygon_hits_sphere(face, bsp.edges(face), s) {
                        *named = Some(face);
                        if movement.dot(face.plane.normal) < 0.0 {
                            return true;
                        }
                    }
                }
                return false;
            }
            ChildKind::Node(index) => {
                let Some(node) = bsp.nodes().get(index) else {
                    return false;
                };
                match reach(node, s, s.radius) {
                    Reach::None => return false,
                    Reach::Positive => at = node.positive,
                    Reach::Negative => at = node.negative,
                    Reach::Both(_) => {
                        if intersects_poly(bsp, node.positive, s, movement, named) {
                            return true;
                        }
                        at = node.negative;
                    }
                }
            }
        }
    }
}

/// What [`find_walkable`] works on.
pub(crate) struct WalkableSearch<'b> {
    /// Its radius in the fourth lane.
    pub(crate) sphere: Lanes,
    pub(crate) movement: Lanes,
    pub(crate) up: Lanes,
    pub(crate) walkable_allowance: f32,
    pub(crate) walk_interp: f32,
    /// The last polygon the sphere was moved onto.
    pub(crate) found: Option<&'b Face>,
}

/// What [`find_floor`] finds.
pub(crate) struct Floor<'b> {
    pub(crate) face: &'b Face,
    /// It is the only one that looks up.
    pub(crate) only: bool,
    /// The sphere, moved.
    pub(crate) sphere: Lanes,
    pub(crate) walk_interp: f32,
}

/// As [`find_walkable`] for a whole movement.
#[inline(always)]
pub(crate) fn find_floor<'b>(
    bsp: &'b PhysicsBsp,
    sphere: Lanes,
    movement: Lanes,
    up: Lanes,
    walkable_allowance: f32,
) -> Option<Floor<'b>> {
    // Most rooms have one floor only.
    if let Some(face) = bsp.only_face_up()
        && looks_up_only(up, walkable_allowance)
    {
        let edges = bsp.edge_quads(face);
        if !(up.dot(Lanes::of_plane(&face.plane)) > walkable_allowance) {
            return None;
        }
        let overlap = polygon::overlap(face, edges, sphere);
        if overlap == Overlap::None {
            return None;
        }
        let (mut moved, mut walk_interp) = (sphere, 1.0);
        if !polygon::adjust_sphere_to_plane(&face.plane, &mut moved, movement, &mut walk_interp) {
            return None;
        }
        // A walk reaches the face for certain; it finds no more if the moved sphere hits nothing.
        if polygon::overlap(face, edges, moved) == Overlap::None && is_sure(bsp, face, overlap, sphere) {
            return Some(Floor {
                face,
                only: true,
                sphere: moved,
                walk_interp,
            });
        }
    }
    find_floor_among(bsp, sphere, movement, up, walkable_allowance)
}

#[inline(never)]
fn find_floor_among<'b>(
    bsp: &'b PhysicsBsp,
    sphere: Lanes,
    movement: Lanes,
    up: Lanes,
    walkable_allowance: f32,
) -> Option<Floor<'b>> {
    let mut search = WalkableSearch {
        sphere,
        movement,
        up,
        walkable_allowance,
        walk_interp: 1.0,
        found: None,
    };
    find_walkable(bsp, &mut search);
    search.found.map(|face| Floor {
        face,
        only: false,
        sphere: search.sphere,
        walk_interp: search.walk_interp,
    })
}

/// Moves the sphere back along its movement onto every polygon level enough to stand on, one after the other
/// (6.6.2). Never stops early: the last success wins, and each polygon sees the sphere as the last one left it.
pub(crate) fn find_walkable<'b>(bsp: &'b PhysicsBsp, search: &mut WalkableSearch<'b>) {
    match walkable_hits(bsp, search) {
        Hits::None => {}
        Hits::One(face, overlap) => {
            let before = (search.sphere, search.walk_interp);
            if !rest_on(face, search) {
                return;
            }
            // A walk reaches the face for certain; it finds no more if the moved sphere hits nothing.
            let clear =
                bsp.certainly_clear(search.sphere) || matches!(walkable_hits(bsp, search), Hits::None);
            if !(clear && is_sure(bsp, face, overlap, before.0)) {
                walk_again(bsp, search, before);
            }
        }
        Hits::Several => walkable_below(bsp, bsp.root, search),
    }
}

/// What is certain was not enough: the search by a walk, from where it began.
#[inline(never)]
fn walk_again<'b>(bsp: &'b PhysicsBsp, search: &mut WalkableSearch<'b>, before: (Lanes, f32)) {
    (search.sphere, search.walk_interp) = before;
    search.found = None;
    walkable_below(bsp, bsp.root, search);
}

/// Whether faces that hardly look up are too steep for certain.
#[inline(always)]
fn looks_up_only(up: Lanes, walkable_allowance: f32) -> bool {
    up.z() > 0.9999 && walkable_allowance > 0.08
}

/// The polygons level enough to stand on that the sphere of a search overlaps.
fn walkable_hits<'b>(bsp: &'b PhysicsBsp, search: &WalkableSearch<'b>) -> Hits<'b> {
    let (up, allowance) = (search.up, search.walkable_allowance);
    let only_up = looks_up_only(up, allowance);
    hits(bsp, search.sphere, only_up, |face| {
        up.dot(Lanes::of_plane(&face.plane)) > allowance
    })
}

/// Moves the sphere back onto a polygon (6.6.1).
#[inline]
fn rest_on<'b>(face: &'b Face, search: &mut WalkableSearch<'b>) -> bool {
    let (sphere, interp) = (&mut search.sphere, &mut search.walk_interp);
    let moved = polygon::adjust_sphere_to_plane(&face.plane, sphere, search.movement, interp);
    if moved {
        search.found = Some(face);
    }
    moved
}

fn walkable_below<'b>(bsp: &'b PhysicsBsp, mut at: Child, search: &mut WalkableSearch<'b>) {
    loop {
        match at.kind() {
            ChildKind::Absent => return,
            ChildKind::Leaf(leaf) => {
                for face in reached_faces(bsp, leaf, &search.sphere.into()) {
                    let edges = bsp.edges(face);
                    let (up, allowance) = (search.up.xyz(), search.walkable_allowance);
                    if polygon::walkable_hits_sphere(face, edges, &search.sphere.into(), up, allowance) {
                        rest_on(face, search);
                    }
                }
                return;
            }
            ChildKind::Node(index) => {
                let Some(node) = bsp.nodes().get(index) else {
                    return;
                };
                match reach(node, &search.sphere.into(), search.sphere.fourth()) {
                    Reach::None => return,
                    Reach::Positive => at = node.positive,
                    Reach::Negative => at = node.negative,
                    Reach::Both(_) => {
                        walkable_below(bsp, node.positive, search);
                        at = node.negative;
                    }
                }
            }
        }
    }
}

/// Whether some polygon level enough to stand on supports the sphere (6.6.3).
pub(crate) fn hits_walkable(bsp: &PhysicsBsp, s: &Sphere, up: Vec3, walkable_allowance: f32) -> bool {
    let sphere = Lanes::from(*s);
    let mut hit = false;
    let only_up = looks_up_only(up.into(), walkable_allowance);
    let sure = bsp.any_face_near(sphere, only_up, |face, distance| {
        if !(up.dot(face.plane.normal) > walkable_allowance) {
            return false;
        }
        let overlap = polygon::overlap_at(face, bsp.edge_quads(face), sphere, distance);
        if overlap == Overlap::None || !polygon::check_small_walkable(face, bsp.edges(face), s, up) {
            return false;
        }
        hit = true;
        is_sure(bsp, face, overlap, sphere)
    });
    match sure {
        Some(true) => true,
        Some(false) if !hit => false,
        _ => walkable_hit(bsp, bsp.root, s, up, walkable_allowance),
    }
}

fn walkable_hit(bsp: &PhysicsBsp, mut at: Child, s: &Sphere, up: Vec3, allowance: f32) -> bool {
    loop {
        match at.kind() {
            ChildKind::Absent => return false,
            ChildKind::Leaf(leaf) => {
                return reached_faces(bsp, leaf, s).iter().any(|face| {
                    let edges = bsp.edges(face);
                    polygon::walkable_hits_sphere(face, edges, s, up, allowance)
                        && polygon::check_small_walkable(face, edges, s, up)
                });
            }
            ChildKind::Node(index) => {
                let Some(node) = bsp.nodes().get(index) else {
                    return false;
                };
                match reach(node, s, s.radius) {
                    Reach::None => return false,
                    Reach::Positive => at = node.positive,
                    Reach::Negative => at = node.negative,
                    Reach::Both(_) => {
                        if walkable_hit(bsp, node.positive, s, up, allowance) {
                            return true;
                        }
                        at = node.negative;
                    }
                }
            }
        }
    }
}

/// Moves `check` back towards `curr` until it just does not touch (6.8). `None` when the budget runs out.
pub(crate) fn adjust_to_plane(bsp: &PhysicsBsp, check: &Sphere, curr: Vec3, struck: &Face) -> Option<Vec3> {
    let m = check.center - curr;
    let at = |t: f64| {
        let t = t as f32;
        Sphere::new(curr + m * t, check.radius)
    };
    let (mut lower, mut upper) = (0.0f64, 1.0f64);
    let mut poly = Some(struck);
    let mut i = 0;
    while let Some(face) = poly {
        let t = polygon::adjust_sphere_to_poly(&face.plane, check.radius, curr, m);
        if t == 1.0 {
            break;
        }
        if !sphere_intersects_poly(bsp, at(t).into(), m.into(), &mut poly) {
            lower = t;
            break;
        }
        upper = t;
        i += 1;
        if i >= ADJUST_TO_PLANE_BUDGET {
            return None;
        }
    }
    while i < ADJUST_TO_PLANE_BUDGET {
        let mid = (lower + upper) / 2.0;
        if sphere_intersects_poly(bsp, at(mid).into(), m.into(), &mut poly) {
            upper = mid;
        } else {
            lower = mid;
        }
        if upper - lower < BISECTION_STOP {
            break;
        }
        i += 1;
    }
    Some(at(lower).center)
}
