//! Environment, `0D......` (`dat-format.md` 10.1).

use super::{
    BspKind, BspTree, DatRecord, Polygon, RecordError, VertexArray, find_polygon, inherent_parse_and_encode,
};
use crate::primitive::{Bool32, Reader, Writer};

/// A set of cell structures: the shapes that EnvCells place.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Environment {
    /// Data id as stored.
    pub id: u32,
    /// The structures, in file order.
    pub cell_structs: Vec<CellStruct>,
}

/// The shape of a cell, in its own frame.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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

impl DatRecord for Environment {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let cell_structs = reader.list32(CellStruct::MIN_SIZE, "cell_structs", CellStruct::read)?;
        reader.align4("padding")?;
        Ok(Self { id, cell_structs })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.id);
        writer.count32(self.cell_structs.len(), "cell_structs")?;
        self.cell_structs
            .iter()
            .try_for_each(|cell_struct| cell_struct.write(writer))?;
        writer.align4();
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(Environment);

impl CellStruct {
    /// Four words, an empty vertex array, two trees of one leaf, one word.
    const MIN_SIZE: usize = 16 + 8 + 8 + 32 + 4;

    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("cell_struct.id")?;
        let num_polygons = reader.count32(Polygon::MIN_SIZE, "cell_struct.num_polygons")?;
        let num_physics_polygons = reader.count32(Polygon::MIN_SIZE, "cell_struct.num_physics_polygons")?;
        let num_portals = reader.count32(2, "cell_struct.num_portals")?;
        let vertices = VertexArray::read(reader)?;
        let num_polygons =
            reader.check_count(num_polygons as u64, Polygon::MIN_SIZE, "cell_struct.num_polygons")?;
        let polygons = reader.items(num_polygons, Polygon::read)?;
        let portals = reader.u16s(num_portals, "cell_struct.portals")?;
        reader.align4("cell_struct.padding")?;
        let cell_bsp = BspTree::read(reader, BspKind::Cell)?;
        let field = "cell_struct.num_physics_polygons";
        let num_physics_polygons =
            reader.check_count(num_physics_polygons as u64, Polygon::MIN_SIZE, field)?;
        let physics_polygons = reader.items(num_physics_polygons, Polygon::read)?;
        let physics_bsp = BspTree::read(reader, BspKind::Physics)?;
        let has_drawing_bsp = reader.bool32("cell_struct.has_drawing_bsp")?;
        let drawing_bsp = if has_drawing_bsp.is_true() {
            Some(BspTree::read(reader, BspKind::Drawing)?)
        } else {
            None
        };
        reader.align4("cell_struct.padding")?;
        Ok(Self {
            id,
            vertices,
            polygons,
            portals,
            cell_bsp,
            physics_polygons,
            physics_bsp,
            has_drawing_bsp,
            drawing_bsp,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.id);
        writer.count32(self.polygons.len(), "cell_struct.num_polygons")?;
        writer.count32(self.physics_polygons.len(), "cell_struct.num_physics_polygons")?;
        writer.count32(self.portals.len(), "cell_struct.num_portals")?;
        self.vertices.write(writer)?;
        Polygon::write_all(&self.polygons, writer)?;
        writer.u16s(&self.portals);
        writer.align4();
        self.cell_bsp.write_as(BspKind::Cell, writer)?;
        Polygon::write_all(&self.physics_polygons, writer)?;
        self.physics_bsp.write_as(BspKind::Physics, writer)?;
        let what = "a drawing tree exists iff has_drawing_bsp is true";
        writer.require(
            self.drawing_bsp.is_some() == self.has_drawing_bsp.is_true(),
            "has_drawing_bsp",
            what,
        )?;
        writer.bool32(self.has_drawing_bsp);
        if let Some(drawing_bsp) = &self.drawing_bsp {
            drawing_bsp.write_as(BspKind::Drawing, writer)?;
        }
        writer.align4();
        Ok(())
    }
}
