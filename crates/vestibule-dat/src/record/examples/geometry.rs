//! Examples 12.15 to 12.21: polygons, vertices, trees and what is made of them.

use glam::{Vec2, Vec3};

use super::*;
use crate::primitive::{Plane, Sphere};

/// Example 12.17.
const CELL_BSP: &str = "6E 6E 50 42 00 00 00 00 00 00 00 00 00 00 80 3F
    00 00 00 00 6E 6E 50 42 00 00 00 00 00 00 00 00
    00 00 80 BF 00 00 40 40 46 41 45 4C 00 00 00 00";

fn polygon(bytes: &str) -> Polygon {
    both_ways(&hex(bytes), Polygon::read, Polygon::write)
}

fn tree(kind: BspKind, bytes: &str) -> BspTree {
    both_ways(&hex(bytes), |reader| BspTree::read(reader, kind), BspTree::write)
}

#[test]
fn example_12_15_polygons() {
    let quad = polygon("00 00 04 00 00 00 00 00 00 00 FF FF 00 00 01 00 02 00 03 00 00 00 00 00");
    assert_eq!(
        (quad.id, quad.sides(), quad.pos_surface, quad.neg_surface),
        (0, Some(Sides::Single), 0, -1)
    );
    assert_eq!(
        (quad.vertex_ids.as_slice(), quad.pos_uv.as_slice()),
        ([0, 1, 2, 3].as_slice(), [0; 4].as_slice())
    );
    assert!(quad.neg_uv.is_empty());

    let triangle = polygon("01 00 03 00 02 00 00 00 01 00 02 00 04 00 05 00 06 00 00 01 02 02 01 00");
    assert_eq!(
        (triangle.sides(), triangle.pos_surface),
        (Some(Sides::BothDifferent), 1)
    );
    assert_eq!(
        (triangle.negative_surface(), triangle.negative_uv()),
        (2, [2, 1, 0].as_slice())
    );
    assert_eq!(
        (triangle.vertex_ids.as_slice(), triangle.pos_uv.as_slice()),
        ([4, 5, 6].as_slice(), [0, 1, 2].as_slice())
    );

    let portal = polygon("02 00 04 0C 01 00 00 00 FF FF FF FF 00 00 01 00 02 00 03 00");
    assert_eq!(
        (portal.id, portal.stippling, portal.sides()),
        (2, 0x0C, Some(Sides::BothAlike))
    );
    assert!(portal.pos_uv.is_empty() && portal.neg_uv.is_empty());
}

#[test]
fn g2_sides_alike_take_the_front_for_the_back() {
    let alike = polygon("00 00 03 00 01 00 00 00 05 00 07 00 00 00 01 00 02 00 02 01 00");
    assert_eq!(
        (alike.neg_surface, alike.neg_uv.as_slice()),
        (7, [].as_slice()),
        "stored as it was"
    );
    assert_eq!(
        (alike.negative_surface(), alike.negative_uv()),
        (5, [2, 1, 0].as_slice())
    );
}

#[test]
fn example_12_16_vertex() {
    let bytes = hex("07 00 01 00 00 00 A0 40 00 00 A0 C0 00 00 40 40
         00 00 00 00 00 00 00 00 00 00 80 3F 00 00 00 3F
         00 00 80 3F");
    let vertex = both_ways(&bytes, Vertex::read, Vertex::write);
    assert_eq!(
        vertex,
        Vertex {
            id: 7,
            origin: Vec3::new(5.0, -5.0, 3.0),
            normal: Vec3::Z,
            uvs: vec![Vec2::new(0.5, 1.0)]
        }
    );
}

#[test]
fn example_12_17_cell_bsp() {
    let tree = tree(BspKind::Cell, CELL_BSP);
    let split = |normal, d, child| BspNode::Inner {
        tag: BspTag::BPNN_LOWER,
        plane: Plane { normal, d },
        pos: Some(child),
        neg: None,
        sphere: None,
        polys: vec![],
    };
    let leaf = BspNode::Leaf {
        index: 0,
        physics: None,
    };
    assert_eq!(
        tree.nodes,
        [split(Vec3::Z, 0.0, 1), split(-Vec3::Z, 3.0, 2), leaf]
    );
    assert_eq!(tree.bounding_sphere(), Sphere::default());
    assert_eq!(BspTag::text(tree.nodes[0].tag()), "BPnn");
}

#[test]
fn example_12_18_physics_leaf() {
    let tree = tree(
        BspKind::Physics,
        "46 41 45 4C 01 00 00 00 00 00 00 00 00 00 00 00
         00 00 00 00 00 00 C0 3F 00 00 00 41 03 00 00 00
         00 00 01 00 04 00",
    );
    let sphere = Sphere {
        center: Vec3::new(0.0, 0.0, 1.5),
        radius: 8.0,
    };
    let physics = BspLeafPhysics {
        solid: 0,
        sphere,
        polys: vec![0, 1, 4],
    };
    assert_eq!(
        tree.nodes,
        [BspNode::Leaf {
            index: 1,
            physics: Some(physics)
        }]
    );
    assert_eq!(tree.bounding_sphere(), sphere);
}

#[test]
fn example_12_19_drawing_port_node() {
    let tree = tree(
        BspKind::Drawing,
        "54 52 4F 50 00 00 00 00 00 00 80 3F 00 00 00 00
         00 00 A0 C0 46 41 45 4C 01 00 00 00 46 41 45 4C
         00 00 00 00 00 00 00 00 00 00 A0 40 00 00 80 3F
         00 00 C0 3F 01 00 00 00 01 00 00 00 06 00 09 00
         00 00",
    );
    let port = BspNode::Portal {
        plane: Plane {
            normal: Vec3::Y,
            d: -5.0,
        },
        pos: 1,
        neg: 2,
        sphere: Some(Sphere {
            center: Vec3::new(0.0, 5.0, 1.0),
            radius: 1.5,
        }),
        polys: vec![6],
        portal_polys: vec![(9, 0)],
    };
    let leaf = |index| BspNode::Leaf { index, physics: None };
    assert_eq!(tree.nodes, [port, leaf(1), leaf(0)]);
}

#[test]
fn example_12_20_environment() {
    let bytes = hex("01 00 00 0D 01 00 00 00 00 00 00 00 01 00 00 00
         01 00 00 00 01 00 00 00 01 00 00 00 03 00 00 00
         00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00
         00 00 00 00 00 00 00 00 00 00 80 3F 01 00 00 00
         00 00 80 3F 00 00 00 00 00 00 00 00 00 00 00 00
         00 00 00 00 00 00 80 3F 02 00 00 00 00 00 00 00
         00 00 80 3F 00 00 00 00 00 00 00 00 00 00 00 00
         00 00 80 3F 00 00 03 0C 01 00 00 00 FF FF FF FF
         00 00 01 00 02 00 00 00 6E 6E 50 42 00 00 00 00
         00 00 00 00 00 00 80 3F 00 00 00 00 6E 6E 50 42
         00 00 00 00 00 00 00 00 00 00 80 BF 00 00 40 40
         46 41 45 4C 00 00 00 00 00 00 03 0C 00 00 00 00
         FF FF FF FF 00 00 01 00 02 00 46 41 45 4C 01 00
         00 00 00 00 00 00 00 00 00 3F 00 00 00 3F 00 00
         00 00 F3 04 35 3F 01 00 00 00 00 00 00 00 00 00");
    let Record::Environment(environment) = record(RecordKind::Environment, 0x0D00_0001, &bytes) else {
        panic!()
    };
    assert_eq!(environment.cell_structs.len(), 1);
    let shape = environment.cell_struct(0).unwrap();
    let origins: Vec<_> = shape
        .vertices
        .vertices
        .iter()
        .map(|vertex| vertex.origin)
        .collect();
    assert_eq!(origins, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(shape.vertices.get(2).unwrap().normal, Vec3::Z);
    assert_eq!(shape.portals, [0]);
    assert_eq!(shape.polygon(0).unwrap().sides(), Some(Sides::BothAlike));
    assert_eq!(shape.physics_polygon(0).unwrap().sides(), Some(Sides::Single));
    assert_eq!(shape.cell_bsp, tree(BspKind::Cell, CELL_BSP));
    let [
        BspNode::Leaf {
            index: 1,
            physics: Some(leaf),
        },
    ] = &shape.physics_bsp.nodes[..]
    else {
        panic!()
    };
    assert_eq!((leaf.solid, leaf.polys.as_slice()), (0, [0].as_slice()));
    assert_eq!(
        leaf.sphere,
        Sphere {
            center: Vec3::new(0.5, 0.5, 0.0),
            radius: 0.70710677
        }
    );
    assert!(!shape.has_drawing_bsp.is_true() && shape.drawing_bsp.is_none());
}

#[test]
fn example_12_21_gfx_obj() {
    let bytes = hex("01 00 00 01 02 00 00 00 01 B8 01 00 08 01 00 00
         00 03 00 00 00 00 00 01 00 00 00 00 00 00 00 00
         00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 80
         3F 00 00 00 00 00 00 80 3F 01 00 01 00 00 00 80
         3F 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00
         00 00 00 80 3F 00 00 80 3F 00 00 80 3F 02 00 01
         00 00 00 00 00 00 00 80 3F 00 00 00 00 00 00 00
         00 00 00 00 00 00 00 80 3F 00 00 00 00 00 00 00
         00 AB AA AA 3E AB AA AA 3E 00 00 00 00 01 00 00
         03 00 00 00 00 00 00 00 FF FF 00 00 01 00 02 00
         00 00 00 4C 4F 50 42 00 00 00 00 00 00 00 00 00
         00 80 3F 00 00 00 00 00 00 00 3F 00 00 00 3F 00
         00 00 00 F3 04 35 3F 01 00 00 00 00 00");
    assert_eq!(bytes.len(), 205);
    let Record::GfxObj(model) = record(RecordKind::GfxObj, 0x0100_0001, &bytes) else {
        panic!()
    };
    assert_eq!(
        (model.flags, model.surfaces.as_slice()),
        (2, [0x0800_01B8].as_slice())
    );
    assert_eq!(model.vertices.vertices.len(), 3);
    assert_eq!(model.vertices.vertices[0].uvs, [Vec2::new(0.0, 1.0)]);
    assert_eq!(model.sort_center, Vec3::new(1.0 / 3.0, 1.0 / 3.0, 0.0));
    assert_eq!(model.bounding_box(), (Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)));
    assert!(model.physics.is_none() && model.degrade_id.is_none());
    let drawing = model.drawing.unwrap();
    assert_eq!(drawing.polygon(0).unwrap().vertex_ids, [0, 1, 2]);
    let [
        BspNode::Inner {
            tag: BspTag::BPOL,
            plane,
            pos: None,
            neg: None,
            sphere: Some(_),
            polys,
        },
    ] = &drawing.bsp.nodes[..]
    else {
        panic!()
    };
    assert_eq!((plane.normal, polys.as_slice()), (Vec3::Z, [0].as_slice()));
    assert_eq!(drawing.bsp.bounding_sphere().radius, 0.70710677);
}
