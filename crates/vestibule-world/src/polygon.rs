//! Polygons of models and cell structures, in flat arrays shared by everything that uses the record.

use std::collections::BTreeMap;

use glam::Vec3;

use crate::geometry::Plane;

/// A convex polygon: its plane and where its vertices lie in its [`PolygonSet`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygon {
    /// The key it has in the record.
    pub id: u16,
    /// Number of vertices, at least 3.
    pub count: u16,
    /// First vertex in [`PolygonSet::vertices`].
    pub first: u32,
    /// Its plane; front is the side from which the vertices run counter-clockwise (`dat-format.md` G4).
    pub plane: Plane,
    /// Whether only the front counts for ray tests and drawing (`dat-format.md` G3: `sides_type` 0).
    pub single_sided: bool,
}

/// Polygons and their vertices, contiguous, in record order. Coordinates are local to the owner, metres.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct PolygonSet {
    polygons: Vec<Polygon>,
    vertices: Vec<Vec3>,
    /// Positions of polygons whose id is not their position: few, except in hostile records.
    misplaced: BTreeMap<u16, u32>,
}

impl PolygonSet {
    /// Memory behind the set, bytes.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&*self.polygons) + size_of_val(&*self.vertices)
    }

    /// Adds a polygon. Fewer than three vertices, or an id that is already there, are left out
    /// (`dat-format.md` G15): the answer is then false.
    pub fn push(&mut self, id: u16, single_sided: bool, vertices: &[Vec3]) -> bool {
        let Ok(count) = u16::try_from(vertices.len()) else {
            return false;
        };
        if count < 3 || self.index_of(id).is_some() {
            return false;
        }
        let first = self.vertices.len() as u32;
        self.vertices.extend_from_slice(vertices);
        if usize::from(id) != self.polygons.len() {
            self.misplaced.insert(id, self.polygons.len() as u32);
        }
        self.polygons.push(Polygon {
            id,
            count,
            first,
            plane: Plane::of_polygon(vertices),
            single_sided,
        });
        true
    }

    /// All polygons in record order.
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
    }

    /// The polygon at `index` (position in the set, not the record's key).
    #[inline]
    pub fn get(&self, index: usize) -> Option<&Polygon> {
        self.polygons.get(index)
    }

    /// All vertices; a polygon's are contiguous.
    pub fn all_vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// The vertices of one of this set's polygons.
    #[inline]
    pub fn vertices(&self, polygon: &Polygon) -> &[Vec3] {
        let first = polygon.first as usize;
        self.vertices
            .get(first..first + usize::from(polygon.count))
            .unwrap_or(&[])
    }

    /// Position of the polygon with record key `id`.
    pub fn index_of(&self, id: u16) -> Option<usize> {
        // Writers emit id = position, so the guess is nearly always right.
        let guess = usize::from(id);
        if self.polygons.get(guess).is_some_and(|p| p.id == id) {
            return Some(guess);
        }
        self.misplaced.get(&id).map(|&i| i as usize)
    }

    /// The polygon with record key `id`.
    pub fn by_id(&self, id: u16) -> Option<&Polygon> {
        self.index_of(id).and_then(|i| self.polygons.get(i))
    }
}
