//! Polygons into vertex arrays and polygon lists.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3};
use vestibule_dat::record::{Polygon as PolygonRecord, Vertex, VertexArray};

use crate::bsp::{BspError, Piece};
use crate::geometry::Polygon;

/// Coordinates are stored in steps of 2⁻²⁰ m: rooms that are equal but for rounding become equal.
const GRID: f64 = 1_048_576.0;

/// A polygon and its material.
#[derive(Clone, Debug)]
pub(crate) struct Painted {
    pub(crate) polygon: Polygon,
    pub(crate) material: usize,
}

/// A polygon on the grid of stored coordinates, starting at its least corner, so that equal rooms come out equal
/// whatever they were cut from.
pub(crate) fn snapped(polygon: &Polygon) -> Polygon {
    let mut points: Vec<DVec3> = polygon
        .points
        .iter()
        .map(|p| (*p * GRID).round() / GRID + DVec3::ZERO)
        .collect();
    let least = |a: &DVec3, b: &DVec3| {
        a.to_array()
            .partial_cmp(&b.to_array())
            .unwrap_or(core::cmp::Ordering::Equal)
    };
    let first = (0..points.len())
        .min_by(|&a, &b| least(&points[a], &points[b]))
        .unwrap_or(0);
    points.rotate_left(first);
    Polygon {
        points,
        plane: polygon.plane.tidy(),
    }
}

/// Collects the vertices and surfaces of one model or cell structure.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) vertices: VertexArray,
    /// Materials in order of first use; polygons select them by position.
    pub(crate) surfaces: Vec<usize>,
    by_place: HashMap<([u32; 3], [u32; 3]), u16>,
}

impl Mesh {
    fn vertex(&mut self, origin: DVec3, normal: DVec3) -> u16 {
        // Adding zero turns -0 into 0, so that equal places are equal keys.
        let (origin, normal) = (origin.as_vec3() + Vec3::ZERO, normal.as_vec3() + Vec3::ZERO);
        let key = (
            origin.to_array().map(f32::to_bits),
            normal.to_array().map(f32::to_bits),
        );
        *self.by_place.entry(key).or_insert_with(|| {
            let id = self.vertices.vertices.len() as u16;
            self.vertices.vertices.push(Vertex {
                id,
                origin,
                normal,
                uvs: Vec::new(),
            });
            id
        })
    }

    fn uv(&mut self, vertex: u16, uv: Vec2) -> u8 {
        let uvs = &mut self.vertices.vertices[usize::from(vertex)].uvs;
        let at = uvs.iter().position(|known| *known == uv).unwrap_or_else(|| {
            uvs.push(uv);
            uvs.len() - 1
        });
        at as u8
    }

    /// Whether all vertices could be named.
    pub(crate) fn check(&self) -> Result<(), BspError> {
        match self.vertices.vertices.len() {
            count if count > usize::from(u16::MAX) + 1 => Err(BspError::TooManyVertices(count)),
            _ => Ok(()),
        }
    }

    fn surface(&mut self, material: usize) -> i16 {
        let at = self
            .surfaces
            .iter()
            .position(|m| *m == material)
            .unwrap_or_else(|| {
                self.surfaces.push(material);
                self.surfaces.len() - 1
            });
        at as i16
    }

    /// The drawn polygons. `materials[source]` is a piece's material, `sizes` the metres each material covers.
    pub(crate) fn drawn(
        &mut self,
        pieces: &[Piece],
        materials: &[usize],
        sizes: &[f64],
    ) -> Vec<PolygonRecord> {
        let mut points: Vec<DVec3> = pieces
            .iter()
            .flat_map(|p| p.polygon.points.iter().copied())
            .collect();
        points.sort_by(|a, b| {
            a.to_array()
                .partial_cmp(&b.to_array())
                .unwrap_or(core::cmp::Ordering::Equal)
        });
        points.dedup();
        let mut out = Vec::with_capacity(pieces.len());
        for (id, piece) in pieces.iter().enumerate() {
            let material = materials[piece.source];
            let size = sizes[material];
            let plane = piece.polygon.plane;
            let (u, v) = plane.axes();
            let corners = stitched(&piece.polygon, &points);
            let (mut vertex_ids, mut pos_uv) = (Vec::new(), Vec::new());
            for p in &corners {
                let vertex = self.vertex(*p, plane.normal);
                vertex_ids.push(vertex);
                // Textures hang upright on walls: v runs down.
                pos_uv.push(self.uv(
                    vertex,
                    Vec2::new((p.dot(u) / size) as f32, (-p.dot(v) / size) as f32),
                ));
            }
            out.push(PolygonRecord {
                id: id as u16,
                stippling: 1,
                sides_type: 0,
                pos_surface: self.surface(material),
                neg_surface: -1,
                vertex_ids,
                pos_uv,
                neg_uv: Vec::new(),
            });
        }
        out
    }

    /// Polygons that are not drawn: openings, and what is collided with. Ids count from `first`.
    pub(crate) fn plain<'a>(
        &mut self,
        polygons: impl Iterator<Item = &'a Polygon>,
        first: usize,
    ) -> Vec<PolygonRecord> {
        let mut out = Vec::new();
        for (k, polygon) in polygons.enumerate() {
            let normal = polygon.plane.normal;
            out.push(PolygonRecord {
                id: (first + k) as u16,
                stippling: PolygonRecord::NO_POS_UVS | PolygonRecord::NO_NEG_UVS,
                sides_type: 0,
                pos_surface: -1,
                neg_surface: -1,
                vertex_ids: polygon.points.iter().map(|p| self.vertex(*p, normal)).collect(),
                pos_uv: Vec::new(),
                neg_uv: Vec::new(),
            });
        }
        out
    }
}

/// The polygon with every one of `points` that lies on an edge made a corner, so that its neighbours meet it
/// corner to corner and no cracks show; at most 255 corners. It starts where a fan of triangles keeps most of them.
fn stitched(polygon: &Polygon, points: &[DVec3]) -> Vec<DVec3> {
    let n = polygon.points.len();
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = polygon
        .points
        .iter()
        .fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
    let near: Vec<DVec3> = points
        .iter()
        .filter(|p| p.cmpge(low - 1.0e-4).all() && p.cmple(high + 1.0e-4).all())
        .copied()
        .collect();
    let mut out = Vec::with_capacity(n + 4);
    for i in 0..n {
        let (a, b) = (polygon.points[i], polygon.points[(i + 1) % n]);
        out.push(a);
        let along = b - a;
        let length = along.length_squared();
        let mut between: Vec<(f64, DVec3)> = Vec::new();
        for p in &near {
            let t = (*p - a).dot(along) / length;
            if t > 1.0e-5 && t < 1.0 - 1.0e-5 && (*p - a - along * t).length_squared() < 1.0e-9 {
                between.push((t, *p));
            }
        }
        between.sort_by(|x, y| x.0.total_cmp(&y.0));
        out.extend(between.into_iter().map(|(_, p)| p));
    }
    if out.len() == n || out.len() > 255 {
        return if out.len() == n {
            out
        } else {
            polygon.points.clone()
        };
    }
    let flat = |start: usize| {
        let m = out.len();
        let at = |k: usize| out[(start + k) % m];
        (1..m - 1)
            .filter(|&k| (at(k) - at(0)).cross(at(k + 1) - at(0)).length_squared() < 1.0e-12)
            .count()
    };
    let best = (0..out.len()).min_by_key(|&k| flat(k)).unwrap_or(0);
    out.rotate_left(best);
    out
}
