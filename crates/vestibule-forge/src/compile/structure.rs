//! Cell structures and models: polygons, trees and surfaces of one shape.

use glam::DVec3;
use vestibule_dat::primitive::{Bool32, CompressedForm};
use vestibule_dat::record::{CellStruct, GfxObj, GfxObjPolygons};

use super::cells::{Cell, SiteCells, Target};
use super::mesh::{Mesh, Painted, snapped};
use super::room::{CUT, painted};
use crate::bsp::{BspError, cell_bsp, drawing_bsp, inward_planes, physics_bsp};
use crate::geometry::{Face, Plane, Polygon, Polytope, inside, uncovered, union_faces};
use crate::scene::{Fixture, RoomDef, SolidDef};

/// How deep below the ground a shell's faces are not drawn any more, metres.
const SUNK: f64 = 0.05;

/// A cell structure and the materials its surface indices select from.
pub(crate) struct BuiltCell {
    pub(crate) structure: CellStruct,
    pub(crate) surfaces: Vec<usize>,
    /// For each hole of the cell the id of its polygon.
    pub(crate) portal_polygons: Vec<u16>,
}

/// The walls of a cell: its faces less the holes that `cut` picks and less what `solids` cover, facing inwards.
fn walls(
    cell: &Cell,
    space: &Polytope,
    holes: &[Polygon],
    cut: impl Fn(usize) -> bool,
    solids: &[Polytope],
) -> Vec<Painted> {
    let mut out = Vec::new();
    for (k, face) in space.faces.iter().enumerate() {
        let mut parts = vec![face.polygon.clone()];
        for h in (0..holes.len()).filter(|&h| cell.holes[h].face == k && cut(h)) {
            parts = parts.iter().flat_map(|p| p.without(&holes[h])).collect();
        }
        for part in parts.iter().flat_map(|p| uncovered(p, solids)) {
            out.push(Painted {
                polygon: part.flipped(),
                material: face.tag as usize,
            });
        }
    }
    out
}

fn fixture_parts(room: &RoomDef, pick: impl Fn(&Fixture) -> &[SolidDef]) -> Vec<Polytope> {
    room.fixtures
        .iter()
        .flat_map(pick)
        .flat_map(|solid| painted(solid, &room.paint, false))
        .collect()
}

/// The surface of fixtures inside a cell, and in its openings: the top of stairs that end in one.
fn fixture_faces(parts: &[Polytope], cell: &Cell, space: &Polytope, holes: &[Polygon]) -> Vec<Painted> {
    let near: Vec<Polytope> = parts
        .iter()
        .filter(|p| p.intersection(space).is_some())
        .cloned()
        .collect();
    let mut out = Vec::new();
    for Face { polygon, tag } in union_faces(&near) {
        let material = tag as usize;
        match space
            .faces
            .iter()
            .position(|f| f.polygon.plane.same_as(&polygon.plane))
        {
            Some(k) => {
                let in_face = (0..holes.len()).filter(|&h| cell.holes[h].face == k);
                out.extend(
                    in_face
                        .filter_map(|h| polygon.intersection(&holes[h]))
                        .map(|p| (p, material)),
                );
            }
            None => out.extend(inside(&polygon, space).map(|p| (p, material))),
        }
    }
    out.into_iter()
        .map(|(polygon, material)| Painted { polygon, material })
        .collect()
}

/// Builds the structure of a cell in the coordinates of its room.
pub(crate) fn build_cell(cell: &Cell, room: &RoomDef, sizes: &[f64]) -> Result<BuiltCell, BspError> {
    let local = |p: DVec3| cell.place.to_inner(p);
    let mut space = cell.space.mapped(local).unwrap_or_else(|| cell.space.clone());
    for face in space.faces.iter_mut().filter(|f| f.tag == CUT) {
        face.tag = room.paint.of(-face.polygon.plane.normal) as u32;
    }
    let moved = |p: &Polygon| {
        let points = p.points.iter().map(|p| local(*p)).collect();
        Polygon::new(points).unwrap_or_else(|| p.clone())
    };
    let holes: Vec<Polygon> = cell.holes.iter().map(|h| moved(&h.polygon)).collect();

    let solids = fixture_parts(room, |f| &f.draw);
    let cuts: Vec<Polygon> = cell
        .holes
        .iter()
        .map(|h| moved(h.cut.as_ref().unwrap_or(&h.polygon)))
        .collect();
    let mut drawn = walls(cell, &space, &cuts, |_| true, &solids);
    drawn.extend(fixture_faces(&solids, cell, &space, &holes));
    // Portals to cells face inwards (portal side 0), those to the outside outwards (side 1), as retail's do.
    let portals: Vec<Polygon> = cell
        .holes
        .iter()
        .zip(&holes)
        .map(|(hole, p)| {
            if matches!(hole.to, Target::Outside(_)) {
                p.clone()
            } else {
                p.flipped()
            }
        })
        .map(|p| snapped(&p))
        .collect();
    let polygons: Vec<Polygon> = drawn.iter().map(|d| snapped(&d.polygon)).collect();
    let materials: Vec<usize> = drawn.iter().map(|d| d.material).collect();
    let drawing = drawing_bsp(&polygons, &portals)?;

    let solids = fixture_parts(room, |f| &f.physics);
    let mut solid = walls(cell, &space, &cuts, |h| !cell.holes[h].pane, &solids);
    solid.extend(fixture_faces(&solids, cell, &space, &holes));
    let solid: Vec<Polygon> = solid.iter().map(|d| snapped(&d.polygon)).collect();
    let inwards = inward_planes(&space);
    let physics = physics_bsp(&solid, &[], &inwards)?;

    let mut mesh = Mesh::default();
    let mut polygons = mesh.drawn(&drawing.pieces, &materials, sizes);
    let first = polygons.len();
    polygons.extend(mesh.plain(portals.iter(), first));
    let portal_polygons: Vec<u16> = (0..portals.len()).map(|k| (first + k) as u16).collect();
    let physics_polygons = mesh.plain(physics.pieces.iter().map(|p| &p.polygon), 0);
    mesh.check()?;
    let structure = CellStruct {
        id: 0,
        vertices: mesh.vertices,
        polygons,
        portals: portal_polygons.clone(),
        cell_bsp: cell_bsp(&inwards),
        physics_polygons,
        physics_bsp: physics.tree,
        has_drawing_bsp: Bool32::from(true),
        drawing_bsp: Some(drawing.tree),
    };
    Ok(BuiltCell {
        structure,
        surfaces: mesh.surfaces,
        portal_polygons,
    })
}

/// A model and the number of leaves of its drawing tree.
pub(crate) struct BuiltModel {
    pub(crate) record: GfxObj,
    pub(crate) leaves: u32,
}

/// What a model is built from.
pub(crate) struct ModelParts {
    pub(crate) drawn: Vec<Painted>,
    /// Openings drawn as PORT nodes.
    pub(crate) portals: Vec<Polygon>,
    /// What is collided with; `None`: no physics.
    pub(crate) solid: Option<Vec<Polygon>>,
}

impl ModelParts {
    /// A model of solids.
    pub(crate) fn of_solids(parts: &[Polytope], collides: bool) -> Self {
        let faces = union_faces(parts);
        let drawn: Vec<Painted> = faces
            .into_iter()
            .map(|f| Painted {
                polygon: f.polygon,
                material: f.tag as usize,
            })
            .collect();
        let solid = collides.then(|| drawn.iter().map(|d| d.polygon.clone()).collect());
        ModelParts {
            drawn,
            portals: Vec::new(),
            solid,
        }
    }

    /// The shell of a building, cut by its openings; windows stay closed to bodies.
    ///
    /// `ground`: how high the ground is over a point of the site. What of the shell lies below it is collided with but
    /// not drawn: nobody sees it from outside, and to an eye in a cellar it would stand before the exits.
    pub(crate) fn of_shell(site: &SiteCells, ground: impl Fn(DVec3) -> f64) -> Self {
        let cut = |face: &Face, panes: bool| {
            let holes = site.shell_holes.iter().filter(|h| panes || !h.pane);
            holes
                .filter(|h| h.polygon.plane.same_as(&face.polygon.plane))
                .fold(vec![face.polygon.clone()], |parts, hole| {
                    parts.iter().flat_map(|p| p.without(&hole.polygon)).collect()
                })
        };
        let points = site.shell.iter().flat_map(|f| &f.polygon.points);
        let lowest = points.map(|p| ground(*p)).fold(f64::INFINITY, f64::min);
        let above = Plane::through(DVec3::Z, DVec3::Z * (lowest - SUNK));
        let buried = |p: &Polygon| {
            p.points
                .iter()
                .chain([&p.center()])
                .all(|p| p.z < ground(*p) - SUNK)
        };
        let mut drawn = Vec::new();
        for face in &site.shell {
            let parts = cut(face, true)
                .into_iter()
                .filter_map(|p| p.clipped(&above))
                .filter(|p| !buried(p));
            drawn.extend(parts.map(|polygon| Painted {
                polygon,
                material: face.tag as usize,
            }));
        }
        ModelParts {
            drawn,
            portals: site.shell_holes.iter().map(|h| h.polygon.clone()).collect(),
            solid: Some(site.shell.iter().flat_map(|face| cut(face, false)).collect()),
        }
    }

    /// Builds the record. `surface_ids`: the Surface of each material; `sizes`: the metres it covers.
    pub(crate) fn build(&self, id: u32, surface_ids: &[u32], sizes: &[f64]) -> Result<BuiltModel, BspError> {
        let portals: Vec<Polygon> = self.portals.iter().map(snapped).collect();
        let polygons: Vec<Polygon> = self.drawn.iter().map(|d| snapped(&d.polygon)).collect();
        let materials: Vec<usize> = self.drawn.iter().map(|d| d.material).collect();
        let drawing = drawing_bsp(&polygons, &portals)?;
        let mut mesh = Mesh::default();
        let mut polygons = mesh.drawn(&drawing.pieces, &materials, sizes);
        let first = polygons.len();
        polygons.extend(mesh.plain(portals.iter(), first));
        let mut physics = None;
        if let Some(solid) = &self.solid {
            let solid: Vec<Polygon> = solid.iter().map(snapped).collect();
            let built = physics_bsp(&solid, &portals, &[])?;
            let polygons = mesh.plain(built.pieces.iter().map(|p| &p.polygon), 0);
            let form = CompressedForm::shortest(polygons.len() as u32);
            physics = Some(GfxObjPolygons {
                polygons,
                form,
                bsp: built.tree,
            });
        }
        mesh.check()?;
        let sort_center = drawing.tree.bounding_sphere().center;
        let form = CompressedForm::shortest(polygons.len() as u32);
        let surfaces: Vec<u32> = mesh.surfaces.iter().map(|m| surface_ids[*m]).collect();
        let record = GfxObj {
            id,
            flags: GfxObj::HAS_DRAWING | if physics.is_some() { GfxObj::HAS_PHYSICS } else { 0 },
            surfaces_form: CompressedForm::shortest(surfaces.len() as u32),
            surfaces,
            vertices: mesh.vertices,
            physics,
            sort_center,
            drawing: Some(GfxObjPolygons {
                polygons,
                form,
                bsp: drawing.tree,
            }),
            degrade_id: None,
        };
        Ok(BuiltModel {
            record,
            leaves: drawing.leaves,
        })
    }
}
