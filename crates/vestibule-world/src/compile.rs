//! Records compiled into the flat forms that look-ups and collisions use.

use std::collections::BTreeMap;

use glam::Vec3;
use vestibule_dat::{primitive, record};

use crate::aperture_tree::ApertureTree;
use crate::cell_bsp::CellBsp;
use crate::env_cell::CellStruct;
use crate::frame::Frame;
use crate::geometry::{BoundingBox, CylSphere, Plane, Sphere};
use crate::physics_bsp::{Child, PhysicsBsp, PhysicsLeaf, PhysicsNode};
use crate::polygon::PolygonSet;
use crate::shape::{Aperture, Model};

impl From<&primitive::Frame> for Frame {
    fn from(f: &primitive::Frame) -> Self {
        Frame::new(f.origin, f.rotation)
    }
}

impl From<&primitive::Plane> for Plane {
    fn from(p: &primitive::Plane) -> Self {
        Plane {
            normal: p.normal,
            d: p.d,
        }
    }
}

impl From<&primitive::Sphere> for Sphere {
    fn from(s: &primitive::Sphere) -> Self {
        Sphere::new(s.center, s.radius)
    }
}

impl From<&primitive::CylSphere> for CylSphere {
    fn from(c: &primitive::CylSphere) -> Self {
        CylSphere {
            low_point: c.low_point,
            radius: c.radius,
            height: c.height,
        }
    }
}

/// Finds vertices by their stored id (`dat-format.md` G1); position and id agree in nearly all records.
struct Vertices<'a> {
    list: &'a [record::Vertex],
    /// Where they do not: the first position of each id. A search for every corner would let a hostile record take
    /// minutes.
    misplaced: BTreeMap<u16, usize>,
}

impl<'a> Vertices<'a> {
    fn new(list: &'a [record::Vertex]) -> Self {
        let mut misplaced = BTreeMap::new();
        for (at, vertex) in list.iter().enumerate() {
            if usize::from(vertex.id) != at {
                misplaced.entry(vertex.id).or_insert(at);
            }
        }
        Vertices { list, misplaced }
    }

    fn origin(&self, id: u16) -> Option<Vec3> {
        match self.list.get(usize::from(id)) {
            Some(v) if v.id == id => Some(v.origin),
            _ => self.list.get(*self.misplaced.get(&id)?).map(|v| v.origin),
        }
    }

    fn of(&self, polygon: &record::Polygon, out: &mut Vec<Vec3>) -> bool {
        out.clear();
        out.extend(polygon.vertex_ids.iter().filter_map(|&id| self.origin(id)));
        out.len() == polygon.vertex_ids.len() && out.iter().all(|v| v.is_finite())
    }
}

/// The usable polygons of a record (`dat-format.md` G15): three corners or more, all of them known and finite.
pub fn polygon_set(vertices: &[record::Vertex], polygons: &[record::Polygon]) -> PolygonSet {
    let vertices = Vertices::new(vertices);
    let mut set = PolygonSet::default();
    let mut corners = Vec::new();
    for polygon in polygons {
        if vertices.of(polygon, &mut corners) {
            set.push(polygon.id, polygon.sides_type == 0, &corners);
        }
    }
    set
}

/// Flattens a cell tree to the planes along its positive children (`dat-format.md` G14).
pub fn cell_bsp(tree: &record::BspTree) -> CellBsp {
    let mut planes = Vec::new();
    let mut ends_in_leaf = false;
    let mut at = Some(0u32);
    // A parsed tree's children come after their parents, so this ends.
    while let Some(node) = at.and_then(|i| tree.nodes.get(i as usize)) {
        match node.plane() {
            Some(plane) => planes.push(plane.into()),
            None => {
                ends_in_leaf = true;
                break;
            }
        }
        let next = node.children().0;
        at = if next > at { next } else { None };
    }
    CellBsp::new(planes, ends_in_leaf)
}

/// Flattens a physics tree. `None` for a tree without nodes.
pub fn physics_bsp(tree: &record::BspTree, polygons: PolygonSet) -> Option<PhysicsBsp> {
    // Where each record node lands among the inner nodes or the leaves.
    let (mut inner, mut leaf) = (0u32, 0u32);
    let place: Vec<Child> = tree
        .nodes
        .iter()
        .map(|node| match node.plane() {
            Some(_) => (Child::node(inner), inner += 1).0,
            None => (Child::leaf(leaf), leaf += 1).0,
        })
        .collect();
    let root = *place.first()?;
    let child = |at: usize, index: Option<u32>| -> Child {
        match index.map(|i| i as usize) {
            Some(i) if i > at => place.get(i).copied().unwrap_or(Child::ABSENT),
            _ => Child::ABSENT,
        }
    };
    let mut nodes = Vec::with_capacity(inner as usize);
    let mut leaves = Vec::with_capacity(leaf as usize);
    let mut leaf_polygons = Vec::new();
    for (at, node) in tree.nodes.iter().enumerate() {
        if let Some(plane) = node.plane() {
            let (positive, negative) = node.children();
            nodes.push(PhysicsNode {
                plane: plane.into(),
                sphere: node.sphere().map(Sphere::from),
                positive: child(at, positive),
                negative: child(at, negative),
            });
        } else {
            let first = leaf_polygons.len() as u32;
            let known = node.polys().iter().filter_map(|&id| polygons.index_of(id));
            leaf_polygons.extend(known.map(|i| i as u32));
            let solid = matches!(node, record::BspNode::Leaf { physics: Some(p), .. } if p.solid != 0);
            leaves.push(PhysicsLeaf {
                solid,
                sphere: node.sphere().map(Sphere::from).unwrap_or_default(),
                first,
                count: leaf_polygons.len() as u32 - first,
            });
        }
    }
    Some(PhysicsBsp::new(root, nodes, leaves, &leaf_polygons, polygons))
}

/// Compiles a cell structure.
pub fn cell_struct(environment: u32, key: u16, record: &record::CellStruct) -> CellStruct {
    let vertices = &record.vertices.vertices;
    CellStruct {
        environment,
        key,
        cell_bsp: cell_bsp(&record.cell_bsp),
        physics: physics_bsp(
            &record.physics_bsp,
            polygon_set(vertices, &record.physics_polygons),
        ),
        polygons: polygon_set(vertices, &record.polygons),
        portal_polygons: record.portals.as_slice().into(),
        bounds: BoundingBox::of(vertices.iter().map(|v| v.origin)),
    }
}

/// Compiles a GfxObj.
pub fn model(id: u32, record: &record::GfxObj) -> Model {
    let vertices = &record.vertices.vertices;
    let physics = record
        .physics
        .as_ref()
        .and_then(|part| physics_bsp(&part.bsp, polygon_set(vertices, &part.polygons)));
    let polygons = record
        .drawing
        .as_ref()
        .map(|d| polygon_set(vertices, &d.polygons))
        .unwrap_or_default();
    let mut apertures: Vec<Aperture> = Vec::new();
    for node in record.drawing.iter().flat_map(|d| &d.bsp.nodes) {
        if let record::BspNode::Portal { portal_polys, .. } = node {
            for &(polygon, portal) in portal_polys {
                if let Some(index) = polygons.index_of(polygon) {
                    apertures.push(Aperture {
                        polygon: index as u32,
                        portal,
                    });
                }
            }
        }
    }
    apertures.sort_by_key(|a| a.portal);
    Model {
        id,
        physics_sphere: physics.as_ref().and_then(PhysicsBsp::sphere),
        physics,
        drawing_sphere: record.drawing.as_ref().map(|d| (&d.bsp.bounding_sphere()).into()),
        bounds: BoundingBox::of(vertices.iter().map(|v| v.origin)).unwrap_or(BoundingBox {
            min: Vec3::ZERO,
            max: Vec3::ZERO,
        }),
        polygons,
        apertures: apertures.into(),
        aperture_tree: record
            .drawing
            .as_ref()
            .map(|d| ApertureTree::of(&d.bsp))
            .unwrap_or_default(),
    }
}
