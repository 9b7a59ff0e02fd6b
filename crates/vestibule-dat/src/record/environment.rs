//! Environment, `0D......` (`dat-format.md` 10.1).

use super::{BspTree, Polygon, VertexArray, find_polygon};
use crate::primitive::Bool32;

/// A set of cell structures: the shapes that EnvCells place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Environment {
    /// Data id as stored.
    pub id: u32,
    /// The structures, in file order.
    pub cell_structs: Vec<CellStruct>,
}

/// The shape of a cell, in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct CellStruct {
    /// Key by which EnvCells name it (E2).
    pub id: u32,
    /// Vertices of both polygon lists.
    pub vertices: VertexArray,
    /// Polygons that are drawn; the openings are among them.
    pub polygons: Vec<Polygon>,
    /// Ids of the polygons that are openings.
    pub portals: Vec<u16>,
    /// Says which points are inside.
    pub cell_bsp: BspTree,
    /// Polygons that are collided with.
    pub physics_polygons: Vec<Polygon>,
    /// Splits `physics_polygons`.
    pub physics_bsp: BspTree,
    /// The word before the drawing tree.
    pub has_drawing_bsp: Bool32,
    /// Splits `polygons`; present iff `has_drawing_bsp`.
    pub drawing_bsp: Option<BspTree>,
}

impl Environment {
    /// The structure with this key (E2).
    pub fn cell_struct(&self, key: u32) -> Option<&CellStruct> {
        self.cell_structs.iter().find(|cell_struct| cell_struct.id == key)
    }
}

impl CellStruct {
    /// The drawn polygon with this id.
    pub fn polygon(&self, id: u16) -> Option<&Polygon> {
        find_polygon(&self.polygons, id)
    }

    /// The physics polygon with this id.
    pub fn physics_polygon(&self, id: u16) -> Option<&Polygon> {
        find_polygon(&self.physics_polygons, id)
    }
}
