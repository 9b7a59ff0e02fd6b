//! Meshes: the drawn sides of a record's polygons, ready to be placed (`rendering.md` 14.3-14.6).

use std::sync::Arc;

use glam::{Vec2, Vec3};
use vestibule_dat::record::{Polygon, Sides, VertexArray};
use vestibule_world::Sphere;

use crate::material::Material;

/// A corner of a mesh, owner-local.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshVertex {
    /// Metres.
    pub position: Vec3,
    /// For lighting; unit when it comes from good data.
    pub normal: Vec3,
    /// Texture coordinates, v downwards.
    pub uv: Vec2,
}

/// One drawn side of a polygon: a convex fan, counter-clockwise seen from where it is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshFace {
    /// First corner in [`Mesh::vertices`].
    pub first: u32,
    /// Number of corners, at least 3.
    pub count: u32,
    /// Position in [`Mesh::materials`].
    pub material: u32,
    /// Key of the polygon in its record.
    pub polygon: u16,
    /// Texture coordinates repeat beyond 0…1; otherwise they are clamped.
    pub wrap: bool,
}

/// Polygons to draw with their materials, owner-local metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners; a face's are contiguous.
    pub vertices: Vec<MeshVertex>,
    /// Faces in record order.
    pub faces: Vec<MeshFace>,
    /// Materials that faces select from.
    pub materials: Vec<Arc<Material>>,
    /// A sphere around all corners; radius 0 for an empty mesh.
    pub sphere: Sphere,
}

/// What the sides of an owner's polygons are like.
pub(crate) struct MeshInput<'a> {
    pub(crate) vertices: &'a VertexArray,
    pub(crate) polygons: &'a [Polygon],
    /// Materials by surface index.
    pub(crate) materials: Vec<Arc<Material>>,
    /// A cell shell or building shell: colours are not drawn (14.4) unless the world has no textures (14.4a).
    pub(crate) shell: bool,
    /// The files hold no textures at all.
    pub(crate) untextured_world: bool,
    /// Whether a polygon, by its key, is a portal.
    pub(crate) is_portal: &'a dyn Fn(u16) -> bool,
}

/// What was odd about the polygons of a mesh, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MeshOddities {
    pub(crate) drawn_portals: u32,
    pub(crate) without_uvs: u32,
    pub(crate) bad_vertices: u32,
    pub(crate) bad_surfaces: u32,
}

impl Mesh {
    /// The mesh of a record's polygons.
    pub(crate) fn build(input: MeshInput<'_>) -> (Mesh, MeshOddities) {
        let mut odd = MeshOddities::default();
        let mut mesh = Mesh {
            materials: input.materials,
            ..Mesh::default()
        };
        for polygon in input.polygons {
            let portal = (input.is_portal)(polygon.id);
            let mut side = |surface: i16, uvs: &[u8], wrap: bool, back: bool| {
                let Some(material) = usize::try_from(surface)
                    .ok()
                    .and_then(|i| mesh.materials.get(i).map(|m| (i, m)))
                else {
                    odd.bad_surfaces += u32::from(surface >= 0);
                    return;
                };
                let (index, material) = material;
                if !material.has_image {
                    if portal || input.shell && !input.untextured_world {
                        return;
                    }
                } else if uvs.is_empty() {
                    odd.without_uvs += 1;
                    return;
                }
                odd.drawn_portals += u32::from(portal);
                let first = mesh.vertices.len() as u32;
                let sign = if back { -1.0 } else { 1.0 };
                for k in 0..polygon.vertex_ids.len() {
                    let k = if back { polygon.vertex_ids.len() - 1 - k } else { k };
                    let vertex = polygon.vertex_ids.get(k).and_then(|&id| input.vertices.get(id));
                    let Some(v) = vertex.filter(|v| v.origin.is_finite() && v.normal.is_finite()) else {
                        odd.bad_vertices += 1;
                        continue;
                    };
                    let uv = uvs
                        .get(k)
                        .and_then(|&i| v.uvs.get(usize::from(i)))
                        .or(v.uvs.first().filter(|_| !uvs.is_empty()));
                    mesh.vertices.push(MeshVertex {
                        position: v.origin,
                        normal: v.normal * sign,
                        uv: uv.copied().filter(|uv| uv.is_finite()).unwrap_or_default(),
                    });
                }
                let count = mesh.vertices.len() as u32 - first;
                if count < 3 {
                    mesh.vertices.truncate(first as usize);
                    return;
                }
                mesh.faces.push(MeshFace {
                    first,
                    count,
                    material: index as u32,
                    polygon: polygon.id,
                    wrap,
                });
            };
            let wraps = |bit: u8| polygon.stippling & bit != 0;
            side(polygon.pos_surface, &polygon.pos_uv, wraps(1), false);
            match polygon.sides() {
                Some(Sides::BothAlike) => side(polygon.pos_surface, &polygon.pos_uv, wraps(1), true),
                Some(Sides::BothDifferent) => side(polygon.neg_surface, &polygon.neg_uv, wraps(2), true),
                _ => {}
            }
        }
        mesh.sphere = sphere_around(&mesh.vertices);
        (mesh, odd)
    }

    /// The corners of a face.
    pub fn corners(&self, face: &MeshFace) -> &[MeshVertex] {
        let first = face.first as usize;
        self.vertices
            .get(first..first + face.count as usize)
            .unwrap_or(&[])
    }

    /// Adds a convex polygon with one normal, for meshes that do not come from records.
    pub(crate) fn push_flat(&mut self, corners: &[Vec3], material: u32, polygon: u16) {
        let Some(normal) = normal_of(corners) else { return };
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners.iter().map(|&position| MeshVertex {
            position,
            normal,
            uv: Vec2::ZERO,
        }));
        self.faces.push(MeshFace {
            first,
            count: corners.len() as u32,
            material,
            polygon,
            wrap: false,
        });
        self.sphere = sphere_around(&self.vertices);
    }
}

/// Unit normal of a polygon's first corner that has one.
pub(crate) fn normal_of(corners: &[Vec3]) -> Option<Vec3> {
    let [a, rest @ ..] = corners else { return None };
    rest.windows(2).find_map(|w| {
        let n = (w[0] - *a).cross(w[1] - *a);
        let length = libm::sqrtf(n.dot(n));
        (length > 0.0).then(|| n / length)
    })
}

fn sphere_around(vertices: &[MeshVertex]) -> Sphere {
    let Some(bounds) = vestibule_world::BoundingBox::of(vertices.iter().map(|v| v.position)) else {
        return Sphere::default();
    };
    let center = (bounds.min + bounds.max) * 0.5;
    let mut square = 0.0f32;
    for v in vertices {
        let gap = v.position - center;
        let d = gap.dot(gap);
        if d > square {
            square = d;
        }
    }
    Sphere::new(center, libm::sqrtf(square))
}
