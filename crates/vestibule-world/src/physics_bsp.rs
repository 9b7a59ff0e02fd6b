//! Physics BSPs: polygons to collide with, in a tree flattened into arrays (`transition.md` 6).

mod audit;

use glam::Vec3;

use crate::box_quads::BoxQuads;
use crate::constants::EPSILON;
use crate::edge_quads::EdgeQuad;
use crate::geometry::{BoundingBox, Plane, Side, Sphere};
use crate::lanes::{LaneBox, Lanes};
use crate::open_box::open_box;
use crate::polygon::PolygonSet;

/// Where a child of a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Child(u32);

/// What a [`Child`] refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChildKind {
    /// No child: answers "nothing" to every query.
    Absent,
    /// Index into [`PhysicsBsp::nodes`].
    Node(usize),
    /// Index into [`PhysicsBsp::leaves`].
    Leaf(usize),
}

impl Child {
    const LEAF: u32 = 1 << 31;
    /// No child.
    pub const ABSENT: Child = Child(u32::MAX);

    /// A child that is the inner node `index`.
    pub const fn node(index: u32) -> Self {
        Child(index & !Self::LEAF)
    }

    /// A child that is the leaf `index`.
    pub const fn leaf(index: u32) -> Self {
        Child(index | Self::LEAF)
    }

    /// What this refers to.
    #[inline]
    pub const fn kind(self) -> ChildKind {
        if self.0 == u32::MAX {
            ChildKind::Absent
        } else if self.0 & Self::LEAF != 0 {
            ChildKind::Leaf((self.0 & !Self::LEAF) as usize)
        } else {
            ChildKind::Node(self.0 as usize)
        }
    }
}

/// An inner node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicsNode {
    /// Splitting plane.
    pub plane: Plane,
    /// Bounding sphere; `None` on a PORT node, which is never pruned (`transition.md` 6.1).
    pub sphere: Option<Sphere>,
    /// Child in front of the plane.
    pub positive: Child,
    /// Child behind the plane.
    pub negative: Child,
}

/// A leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicsLeaf {
    /// Whether its volume is solid.
    pub solid: bool,
    /// Bounding sphere of its polygons.
    pub sphere: Sphere,
    /// First entry in [`PhysicsBsp::faces`].
    pub first: u32,
    /// Number of entries.
    pub count: u32,
}

/// A polygon as collision tests want it: its plane and its edges, in the order the leaves name polygons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Its plane, owner-local.
    pub plane: Plane,
    /// First edge in [`PhysicsBsp::all_edges`].
    first_edge: u32,
    /// First group of edges in `edge_quads`.
    first_quad: u32,
    /// Number of edges.
    pub(crate) edge_count: u32,
    /// Position of the polygon in [`PhysicsBsp::polygons`].
    pub polygon: u32,
    /// The polygon lies where the tree says: whatever overlaps it by more than [`SURE_OVERLAP`] finds it by a
    /// walk.
    pub sound: bool,
    /// The first and last time that a walk of everything, fronts first, comes by the polygon.
    met: (u32, u32),
    /// Points of the polygon's plane in this box are certainly on the inner side of all edges. It is endless along an
    /// axis.
    inner: LaneBox,
}

impl Face {
    /// Whether every walk that takes fronts first and finds both polygons finds this one first.
    #[inline(always)]
    pub fn is_met_before(&self, other: &Face) -> bool {
        self.met.1 < other.met.0
    }

    /// The box of [`Face::certainly_inside`].
    pub(crate) fn inside(&self) -> BoundingBox {
        self.inner.bounds()
    }

    /// Whether a point of the polygon's plane is certainly on the inner side of all edges.
    #[inline(always)]
    pub fn certainly_inside(&self, p: Lanes) -> bool {
        self.inner.holds(p)
    }
}

/// How deep a sphere must overlap a sound [`Face`] for a walk to be certain to reach it, metres.
pub const SURE_OVERLAP: f32 = 1e-3;

/// An edge of a [`Face`], from one vertex to the next; the first runs from the last vertex to the first
/// (`transition.md` 6.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceEdge {
    /// Where it starts.
    pub start: Vec3,
    /// Normal of the polygon times the edge: points inwards, in the plane, not normalised.
    pub inward: Vec3,
}

/// A physics tree with the polygons it refers to; one per model or cell structure, shared by all that place it.
#[derive(Clone, Debug, PartialEq)]
pub struct PhysicsBsp {
    /// The tree's root.
    pub root: Child,
    nodes: Box<[PhysicsNode]>,
    leaves: Box<[PhysicsLeaf]>,
    faces: Box<[Face]>,
    edges: Box<[FaceEdge]>,
    /// The same in groups of four, where there are `quads`.
    edge_quads: Box<[EdgeQuad]>,
    polygons: PolygonSet,
    /// Which faces a sphere is near; `None` for large trees.
    quads: Option<BoxQuads>,
    /// See [`PhysicsBsp::reach`].
    reach: BoundingBox,
    /// No polygon enters this box; empty when there is none.
    open: LaneBox,
    /// No leaf is solid and has polygons.
    is_hollow: bool,
    /// No leaf that is solid and has polygons reaches into `open`.
    open_is_hollow: bool,
}

impl PhysicsBsp {
    /// Memory behind the tree, bytes.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&*self.nodes)
            + size_of_val(&*self.leaves)
            + size_of_val(&*self.faces)
            + size_of_val(&*self.edges)
            + size_of_val(&*self.edge_quads)
            + self.polygons.memory()
    }

    /// A tree from its parts. `leaf_polygons` holds the polygons of the leaves, in the leaves' own order, as
    /// positions in `polygons`; positions that do not exist become faces that nothing can hit.
    pub fn new(
        root: Child,
        nodes: Vec<PhysicsNode>,
        leaves: Vec<PhysicsLeaf>,
        leaf_polygons: &[u32],
        polygons: PolygonSet,
    ) -> Self {
        let mut faces = Vec::with_capacity(leaf_polygons.len());
        let mut edges = Vec::new();
        for &index in leaf_polygons {
            let polygon = polygons.get(index as usize).copied();
            let first_edge = edges.len() as u32;
            let plane = polygon.map(|p| p.plane).unwrap_or_default();
            let vertices = polygon.as_ref().map_or(&[][..], |p| polygons.vertices(p));
            let mut start = vertices.last().copied().unwrap_or_default();
            for &end in vertices {
                edges.push(FaceEdge {
                    start,
                    inward: plane.normal.cross(end - start),
                });
                start = end;
            }
            let edge_count = edges.len() as u32 - first_edge;
            faces.push(Face {
                plane,
                first_edge,
                first_quad: 0,
                edge_count,
                polygon: index,
                sound: false,
                met: (0, u32::MAX),
                inner: LaneBox::NOTHING,
            });
        }
        let mut boxes = Vec::with_capacity(faces.len());
        let mut reaches = Vec::with_capacity(faces.len());
        for face in &mut faces {
            let polygon = polygons.get(face.polygon as usize);
            let vertices = polygon.map_or(&[][..], |p| polygons.vertices(p));
            let first = face.first_edge as usize;
            let edges = &edges[first..first + face.edge_count as usize];
            let around = BoundingBox::of(vertices.iter().copied());
            boxes.extend(around);
            let around = around.filter(|b| is_plain(&face.plane, b, vertices, edges));
            face.inner = around.map_or(LaneBox::NOTHING, |b| inner_rect(&face.plane, &b, edges));
            reaches.push(around.map_or(ENDLESS, |b| BoundingBox {
                min: b.min - Vec3::splat(REACH_SLACK),
                max: b.max + Vec3::splat(REACH_SLACK),
            }));
        }
        let quads = BoxQuads::new(&faces, &reaches);
        let mut edge_quads = Vec::new();
        if quads.is_some() {
            for face in &mut faces {
                let first = face.first_edge as usize;
                face.first_quad = edge_quads.len() as u32;
                edge_quads.extend(EdgeQuad::of(&edges[first..first + face.edge_count as usize]));
            }
        }
        let is_hollow = !leaves.iter().any(|l| l.solid && l.count != 0);
        let mut bsp = PhysicsBsp {
            quads,
            edge_quads: edge_quads.into(),
            reach: union_of(&reaches).unwrap_or(ENDLESS),
            open: open_box(&boxes).map_or(LaneBox::NOTHING, |b| LaneBox::new(&b)),
            is_hollow,
            open_is_hollow: false,
            root,
            nodes: nodes.into(),
            leaves: leaves.into(),
            faces: faces.into(),
            edges: edges.into(),
            polygons,
        };
        bsp.audit();
        bsp
    }

    /// Leaves only the tree itself: every question is answered by a walk.
    pub(crate) fn forget_hints(&mut self) {
        self.quads = None;
        self.open = LaneBox::NOTHING;
        self.is_hollow = false;
        self.open_is_hollow = false;
        for face in &mut self.faces {
            face.sound = false;
            face.inner = LaneBox::NOTHING;
        }
    }

    /// The inner nodes, parents before children.
    #[inline]
    pub fn nodes(&self) -> &[PhysicsNode] {
        &self.nodes
    }

    /// The leaves.
    #[inline]
    pub fn leaves(&self) -> &[PhysicsLeaf] {
        &self.leaves
    }

    /// The polygons of all leaves, leaf by leaf.
    #[inline]
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The polygons of a leaf, in its order.
    #[inline]
    pub fn faces_of(&self, leaf: &PhysicsLeaf) -> &[Face] {
        let first = leaf.first as usize;
        self.faces.get(first..first + leaf.count as usize).unwrap_or(&[])
    }

    /// The edges of a face.
    #[inline]
    pub fn edges(&self, face: &Face) -> &[FaceEdge] {
        let first = face.first_edge as usize;
        self.edges
            .get(first..first + face.edge_count as usize)
            .unwrap_or(&[])
    }

    /// The edges of a face in groups of four: all of them in trees that [`PhysicsBsp::any_face_near`] looks at.
    #[inline(always)]
    pub fn edge_quads(&self, face: &Face) -> &[EdgeQuad] {
        let first = face.first_quad as usize;
        let count = face.edge_count.div_ceil(4) as usize;
        self.edge_quads.get(first..first + count).unwrap_or(&[])
    }

    /// Whether a sphere certainly overlaps no polygon, by the tolerance of sphere tests: it lies in open space. A
    /// sphere that rests on a floor does.
    #[inline]
    pub fn certainly_clear(&self, sphere: Lanes) -> bool {
        // An overlap must be deeper than epsilon; rounding is far below the rest.
        let radius = sphere.fourth();
        radius > LEAST_CLEAR_RADIUS && self.open.holds_cube(sphere, radius - 0.75 * EPSILON)
    }

    /// Whether some polygon near a sphere passes `test`, which is also told the distance of the centre from its plane;
    /// those that the sphere overlaps are near. With `only_up` polygons that hardly look up (normal z under 0.05) may be
    /// left out. `None` when the tree is too large for that to be quicker than a walk.
    #[inline]
    pub fn any_face_near<'b>(
        &'b self,
        s: Lanes,
        only_up: bool,
        mut test: impl FnMut(&'b Face, f32) -> bool,
    ) -> Option<bool> {
        let known = self.quads.as_ref()?;
        let count = if only_up { known.up } else { known.quads.len() };
        for quad in known.quads.get(..count).unwrap_or(&known.quads) {
            let (mut near, distances) = quad.near(s);
            while near != 0 {
                let k = near.trailing_zeros() as usize;
                near &= near - 1;
                let face = quad.faces.get(k).and_then(|&i| self.faces.get(i as usize));
                if face.is_some_and(|face| test(face, distances.lane(k))) {
                    return Some(true);
                }
            }
        }
        Some(false)
    }

    /// How far a sphere may be shifted and certainly overlaps no polygon, metres; `None` when that is not easily told.
    #[inline]
    pub fn clearance(&self, s: Lanes) -> Option<f32> {
        /// Many times the rounding of distances, metres.
        const SLACK: f32 = 3e-5;
        let mut least = Lanes::splat(f32::INFINITY);
        for quad in &self.quads.as_ref()?.quads {
            least = quad.clearances(s).lesser(least);
        }
        let least = least.least() - SLACK;
        (least > 0.0).then_some(least)
    }

    /// The face that looks up, if there is only one: normal z at least 0.05.
    #[inline(always)]
    pub fn only_face_up(&self) -> Option<&Face> {
        self.faces.get(self.quads.as_ref()?.only_up? as usize)
    }

    /// Whether a point, shifted by up to `reach`, is certainly not in a leaf that is solid and has polygons.
    #[inline]
    pub fn is_certainly_hollow_around(&self, p: Lanes, reach: f32) -> bool {
        self.is_hollow || (self.open_is_hollow && self.open.holds_cube(p, LEAST_CLEAR_RADIUS - 0.01 + reach))
    }

    /// Whatever does not reach into this box touches nothing of the tree, nor is it in anything solid.
    pub(crate) fn reach(&self) -> BoundingBox {
        self.reach
    }

    /// The box of open space; inside out when there is none.
    pub(crate) fn open_box(&self) -> BoundingBox {
        self.open.bounds()
    }

    /// Whether no point of the open space of [`PhysicsBsp::certainly_clear`] is in a leaf that is solid and has
    /// polygons.
    #[inline]
    pub fn open_is_hollow(&self) -> bool {
        self.open_is_hollow
    }

    /// The polygons, owner-local coordinates.
    pub fn polygons(&self) -> &PolygonSet {
        &self.polygons
    }

    /// The root's bounding sphere: the owner's physics sphere (`dat-format.md` G11).
    pub fn sphere(&self) -> Option<Sphere> {
        match self.root.kind() {
            ChildKind::Absent => None,
            ChildKind::Node(i) => self.nodes.get(i).and_then(|n| n.sphere),
            ChildKind::Leaf(i) => self.leaves.get(i).map(|l| l.sphere),
        }
    }
}

/// Reaches everything; not infinite, so that it has a middle.
const ENDLESS: BoundingBox = BoundingBox {
    min: Vec3::splat(f32::MIN / 4.0),
    max: Vec3::splat(f32::MAX / 4.0),
};

fn union_of(boxes: &[BoundingBox]) -> Option<BoundingBox> {
    let mut all = *boxes.first()?;
    for b in boxes {
        all.grow(b.min);
        all.grow(b.max);
    }
    Some(all)
}

/// How far the box that stands for a polygon reaches beyond it: many times the rounding of the tests, metres.
const REACH_SLACK: f32 = 0.01;

/// Whether a polygon is flat, convex and of a usual size, so that what overlaps it is near it.
fn is_plain(plane: &Plane, around: &BoundingBox, vertices: &[Vec3], edges: &[FaceEdge]) -> bool {
    let small = around.min.abs().max_element() < 64.0 && around.max.abs().max_element() < 64.0;
    let unit = (plane.normal.dot(plane.normal) - 1.0).abs() < 1e-4;
    let sharp = edges.iter().any(|e| e.inward.dot(e.inward) < 1e-4);
    // Every corner is on the inner side of every edge: the edges go round it once, and it is convex.
    let convex = vertices.iter().all(|&v| {
        plane.dist(v).abs() < 1e-3
            && edges
                .iter()
                .all(|e| (v - e.start).dot(e.inward) >= -1e-5 * e.inward.dot(e.inward))
    });
    small && unit && convex && !sharp
}

/// A rectangle inside a plain polygon, if one fits around its middle: a box that is endless along an axis.
fn inner_rect(plane: &Plane, around: &BoundingBox, edges: &[FaceEdge]) -> LaneBox {
    /// How far it stays away from the edges: many times the rounding of the tests, metres.
    const MARGIN: f32 = 2e-3;
    let n = plane.normal;
    let axis = (0..3).fold(0, |k, i| if n[i].abs() > n[k].abs() { i } else { k });
    let (u, v) = [(1, 2), (0, 2), (0, 1)][axis];
    let inside = |r: &BoundingBox| {
        let corners = [
            (r.min[u], r.min[v]),
            (r.max[u], r.min[v]),
            (r.min[u], r.max[v]),
            (r.max[u], r.max[v]),
        ];
        r.min[u] < r.max[u]
            && r.min[v] < r.max[v]
            && corners.iter().all(|&(a, b)| {
                let mut p = Vec3::ZERO;
                (p[u], p[v]) = (a, b);
                p[axis] = -(n[u] * a + n[v] * b + plane.d) / n[axis];
                edges.iter().all(|e| {
                    let far = MARGIN * 0.5 * libm::sqrtf(e.inward.dot(e.inward));
                    (p - e.start).dot(e.inward) > far
                })
            })
    };
    let (lo, hi) = (around.min, around.max);
    let rect = |share: f32| {
        let mut found = BoundingBox {
            min: Vec3::NEG_INFINITY,
            max: Vec3::INFINITY,
        };
        for i in [u, v] {
            let (middle, half) = ((lo[i] + hi[i]) * 0.5, (hi[i] - lo[i]) * 0.5 * share - MARGIN);
            (found.min[i], found.max[i]) = (middle - half, middle + half);
        }
        found
    };
    [1.0, 0.8, 0.6, 0.5]
        .into_iter()
        .map(rect)
        .find(inside)
        .map_or(LaneBox::NOTHING, |b| LaneBox::new(&b))
}

/// Smaller spheres are not said to be clear.
pub(crate) const LEAST_CLEAR_RADIUS: f32 = 0.06;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_start_at_the_last_vertex_and_point_inwards() {
        let mut set = PolygonSet::default();
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
        assert!(set.push(7, false, &square));
        let leaf = PhysicsLeaf {
            solid: false,
            sphere: Sphere::new(Vec3::ONE, 2.0),
            first: 0,
            count: 1,
        };
        let bsp = PhysicsBsp::new(Child::leaf(0), vec![], vec![leaf], &[0], set);
        let face = bsp.faces_of(&bsp.leaves()[0])[0];
        let edges = bsp.edges(&face);
        assert_eq!(
            edges.iter().map(|e| e.start).collect::<Vec<_>>(),
            [square[3], square[0], square[1], square[2]]
        );
        for edge in edges {
            assert!((Vec3::new(1.0, 1.0, 0.0) - edge.start).dot(edge.inward) > 0.0);
        }
    }
}
