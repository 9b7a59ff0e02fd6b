//! Vertices, polygons, trees, and the records made of them.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use glam::Vec3;

use super::Lints;
use crate::record::{BspKind, BspNode, BspTree, Environment, GfxObj, Polygon, Vertex, VertexArray};

/// Twice the area, in square metres, below which a polygon counts as having none.
const NO_AREA: f32 = 1e-6;

type Vertices<'a> = HashMap<u16, &'a Vertex>;

impl Lints {
    pub(super) fn environment(&mut self, environment: &Environment) {
        let mut keys = HashSet::new();
        for (i, shape) in environment.cell_structs.iter().enumerate() {
            if !keys.insert(shape.id) {
                let twice = format_args!("{} is the key of two structures", shape.id);
                self.add("E2", format_args!("cell_structs[{i}].id"), twice);
            }
            let at = format!("cell_structs[{i}].");
            let vertices = self.vertices(&at, &shape.vertices);
            let ids = self.polygons(&format!("{at}polygons"), &shape.polygons, &vertices, None);
            for (k, portal) in shape.portals.iter().enumerate() {
                if !ids.contains(portal) {
                    let field = format_args!("{at}portals[{k}]");
                    self.add("D4", field, format_args!("there is no polygon {portal}"));
                }
            }
            if let Some(tree) = &shape.drawing_bsp {
                self.tree(&format!("{at}drawing_bsp"), tree, &ids);
            }
            self.tree(&format!("{at}cell_bsp"), &shape.cell_bsp, &ids);
            let path = format!("{at}physics_polygons");
            let ids = self.polygons(&path, &shape.physics_polygons, &vertices, None);
            self.areas(&path, &shape.physics_polygons, &vertices);
            self.tree(&format!("{at}physics_bsp"), &shape.physics_bsp, &ids);
        }
    }

    pub(super) fn gfx_obj(&mut self, model: &GfxObj) {
        let vertices = self.vertices("", &model.vertices);
        let surfaces = Some(model.surfaces.len());
        self.vec3(format_args!("sort_center"), model.sort_center);
        if let Some(physics) = &model.physics {
            let ids = self.polygons("physics.polygons", &physics.polygons, &vertices, None);
            self.areas("physics.polygons", &physics.polygons, &vertices);
            self.tree("physics.bsp", &physics.bsp, &ids);
        }
        if let Some(drawing) = &model.drawing {
            let ids = self.polygons("drawing.polygons", &drawing.polygons, &vertices, surfaces);
            self.tree("drawing.bsp", &drawing.bsp, &ids);
        }
    }

    fn vertices<'a>(&mut self, at: &str, array: &'a VertexArray) -> Vertices<'a> {
        let mut vertices = Vertices::with_capacity(array.vertices.len());
        for (i, vertex) in array.vertices.iter().enumerate() {
            self.vec3(format_args!("{at}vertices[{i}].origin"), vertex.origin);
            self.vec3(format_args!("{at}vertices[{i}].normal"), vertex.normal);
            for (k, uv) in vertex.uvs.iter().enumerate() {
                if !uv.is_finite() {
                    self.add(
                        "D4",
                        format_args!("{at}vertices[{i}].uvs[{k}]"),
                        format_args!("is {uv}"),
                    );
                }
            }
            if let Entry::Vacant(place) = vertices.entry(vertex.id) {
                place.insert(vertex);
            } else {
                let field = format_args!("{at}vertices[{i}].id");
                self.add(
                    "G1",
                    field,
                    format_args!("{} is the id of two vertices", vertex.id),
                );
            }
        }
        vertices
    }

    /// Checks a list of polygons and returns their ids. `surfaces` is the number of surfaces they select from, where
    /// that is known.
    fn polygons(
        &mut self,
        at: &str,
        polygons: &[Polygon],
        vertices: &Vertices<'_>,
        surfaces: Option<usize>,
    ) -> HashSet<u16> {
        let mut ids = HashSet::with_capacity(polygons.len());
        for (i, polygon) in polygons.iter().enumerate() {
            if !ids.insert(polygon.id) {
                let twice = format_args!("{} is the id of two polygons; the second is not used", polygon.id);
                self.add("G15", format_args!("{at}[{i}].id"), twice);
            }
            if !polygon.is_usable() {
                let few = format_args!("{} points, a polygon has at least 3", polygon.vertex_ids.len());
                self.add("G15", format_args!("{at}[{i}].vertex_ids"), few);
            }
            if polygon.sides().is_none() {
                let sides = format_args!("{} is not defined", polygon.sides_type);
                self.add("8.2", format_args!("{at}[{i}].sides_type"), sides);
            }
            for (k, id) in polygon.vertex_ids.iter().enumerate() {
                let Some(vertex) = vertices.get(id) else {
                    let field = format_args!("{at}[{i}].vertex_ids[{k}]");
                    self.add("G1", field, format_args!("there is no vertex {id}"));
                    continue;
                };
                for uvs in [&polygon.pos_uv, &polygon.neg_uv] {
                    if uvs
                        .get(k)
                        .is_some_and(|&uv| uv != 0 && usize::from(uv) >= vertex.uvs.len())
                    {
                        let field = format_args!("{at}[{i}]");
                        self.add(
                            "8.2",
                            field,
                            format_args!("point {k}: vertex {id} has no such UV"),
                        );
                    }
                }
            }
            if let Some(count) = surfaces {
                self.surface_index(format_args!("{at}[{i}].pos_surface"), polygon.pos_surface, count);
                self.surface_index(
                    format_args!("{at}[{i}].neg_surface"),
                    polygon.negative_surface(),
                    count,
                );
            }
        }
        ids
    }

    /// An index into a list of `count` surfaces; negative is none.
    pub(super) fn surface_index(&mut self, field: std::fmt::Arguments<'_>, index: i16, count: usize) {
        if usize::try_from(index).is_ok_and(|index| index >= count) {
            self.add(
                "D4",
                field,
                format_args!("is {index}, there are {count} surfaces"),
            );
        }
    }

    /// Physics polygons must have an area (D4).
    fn areas(&mut self, at: &str, polygons: &[Polygon], vertices: &Vertices<'_>) {
        for (i, polygon) in polygons.iter().enumerate() {
            let points: Option<Vec<Vec3>> = polygon
                .vertex_ids
                .iter()
                .map(|id| vertices.get(id).map(|vertex| vertex.origin))
                .collect();
            if let Some([first, rest @ ..]) = points.as_deref()
                && rest.len() >= 2
            {
                let edges = rest.iter().zip(rest.iter().skip(1));
                let sum: Vec3 = edges.map(|(&a, &b)| (a - *first).cross(b - *first)).sum();
                if sum.length() < NO_AREA {
                    self.add("D4", format_args!("{at}[{i}]"), format_args!("has no area"));
                }
            }
        }
    }

    /// `ids` are those of the polygons that the tree may name.
    fn tree(&mut self, at: &str, tree: &BspTree, ids: &HashSet<u16>) {
        for (i, node) in tree.nodes.iter().enumerate() {
            if let Some(plane) = node.plane() {
                self.plane(format_args!("{at}.nodes[{i}].plane"), plane);
            }
            if let Some(sphere) = node.sphere() {
                self.sphere(format_args!("{at}.nodes[{i}].sphere"), sphere);
            }
            let portals: &[(u16, u16)] = match node {
                BspNode::Portal { portal_polys, .. } => portal_polys,
                _ => &[],
            };
            for id in node.polys().iter().chain(portals.iter().map(|(id, _)| id)) {
                if !ids.contains(id) {
                    let field = format_args!("{at}.nodes[{i}]");
                    self.add("G10", field, format_args!("there is no polygon {id}"));
                }
            }
            match (tree.kind, node) {
                (BspKind::Cell, BspNode::Inner { neg: Some(_), .. }) => {
                    let field = format_args!("{at}.nodes[{i}]");
                    self.add(
                        "G14",
                        field,
                        format_args!("a cell tree has a negative child, which is ignored"),
                    );
                }
                (BspKind::Cell | BspKind::Physics, BspNode::Portal { .. }) => {
                    let field = format_args!("{at}.nodes[{i}]");
                    self.add("8.3", field, format_args!("a PORT node outside a drawing tree"));
                }
                _ => {}
            }
        }
    }
}
