//! The analytic oracle: what a ray meets as it walks from cell to cell (`rendering.md` 10.5, `visibility.md` 17.1).
//!
//! It shares nothing with the drawing but the meshes: no regions, no depth buffer, no order.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use vestibule_view::Camera;
use vestibule_world::ids::block_offset;
use vestibule_world::{BlockId, CellId, Frame, PortalTarget, StaticRef, World};

use crate::assets::Assets;
use crate::land::TERRAIN_OFFSET;
use crate::material::DrawList;
use crate::mesh::Mesh;
use crate::raster::{PixelId, PixelKind};

/// A ray may cross this many openings.
const MAX_CROSSINGS: u32 = 128;
/// Openings this little behind where the ray entered still count, metres.
const BACK: f64 = 1.0e-7;

/// Surfaces this little behind an opening lie in its plane, metres along the ray.
const IN_PLANE: f64 = 1.0e-6;

#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [DVec3; 3],
    id: PixelId,
}

/// A bunch of triangles with a sphere around them.
#[derive(Clone, Debug, Default)]
struct Bunch {
    center: DVec3,
    radius: f64,
    triangles: Vec<Triangle>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Medium {
    Room(CellId),
    Outdoors,
}

#[derive(Clone, Debug)]
struct Opening {
    corners: Vec<DVec3>,
    normal: DVec3,
    /// A ray passes when its direction along the normal has this sign.
    sign: f64,
    to: Option<Medium>,
    /// The far side's polygon, where the two are not promised to be the same (`visibility.md` 3.4).
    partner: Option<Vec<DVec3>>,
}

/// What a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// What shows.
    pub id: PixelId,
    /// How far away it is along the ray, metres; infinite for sky and where nothing is met.
    pub distance: f64,
    /// The ray crossed a link beside the far side's polygon: the two rooms do not agree on their opening, so there is
    /// no telling what is right.
    pub disputed: bool,
}

#[derive(Clone, Debug, Default)]
struct Space {
    bunches: Vec<Bunch>,
    openings: Vec<Opening>,
}

/// Rays through one camera's world: rooms of the camera's landblock and of its neighbours within a radius, all in
/// the frame of the camera's landblock.
#[derive(Clone, Debug)]
pub struct Oracle {
    home: BlockId,
    rooms: BTreeMap<CellId, Space>,
    outdoors: Space,
    /// There is ground somewhere, so what misses everything is sky.
    has_land: bool,
}

impl Oracle {
    /// Prepares the landblocks within `radius` blocks of `home`.
    pub fn new(world: &World, assets: &Assets, home: BlockId, radius: i32) -> Self {
        let mut oracle = Oracle {
            home,
            rooms: BTreeMap::new(),
            outdoors: Space::default(),
            has_land: false,
        };
        for dx in -radius..=radius {
            for dy in -radius..=radius {
                if let Some(block) = home.neighbour(dx, dy) {
                    oracle.add_block(world, assets, block);
                }
            }
        }
        oracle
    }

    fn add_block(&mut self, world: &World, assets: &Assets, id: BlockId) {
        let Some(block) = world.block(id) else { return };
        let offset = block_offset(self.home, id).as_dvec3();
        let whole = Placing {
            offset,
            frame: Frame::IDENTITY,
            scale: Vec3::ONE,
        };
        for (cell, land) in block.land_cells() {
            self.has_land = true;
            let lower = Vec3::Z * TERRAIN_OFFSET;
            let id = PixelId::new(PixelKind::Terrain, cell.0, 0);
            let triangles = land.polygons.iter().map(|p| Triangle {
                corners: p.vertices.map(|v| whole.point(v - lower)),
                id,
            });
            self.outdoors.bunches.push(Bunch::of(triangles.collect()));
            self.add_statics(world, assets, cell, Medium::Outdoors);
        }
        for building in &block.buildings {
            let Some(part) = building.shape.parts.first() else {
                continue;
            };
            let Some(model) = &part.model else { continue };
            let frame = building.part_frames.first().copied().unwrap_or(building.frame);
            let placing = Placing {
                offset,
                frame,
                scale: part.scale,
            };
            if let Some(mesh) = assets.model(world, part.model_id, Some(model)) {
                let id = |polygon| PixelId::new(PixelKind::Building, building.cell.0, polygon);
                self.outdoors.bunches.push(placing.bunch(&mesh, id));
            }
            if model.apertures.len() != building.portals.len() {
                continue;
            }
            for aperture in &model.apertures {
                let (Some(polygon), Some(portal)) = (
                    model.polygons.get(aperture.polygon as usize),
                    building.portals.get(usize::from(aperture.portal)),
                ) else {
                    continue;
                };
                let to = world.env_cell(portal.other).map(|c| Medium::Room(c.id));
                let sign = if portal.interior_is_negative { 1.0 } else { -1.0 };
                let corners = model.polygons.vertices(polygon);
                let opening = placing.opening(corners, polygon.plane.normal, sign, to);
                self.outdoors.openings.push(opening);
            }
        }
        for cell in block.env_cells() {
            let placing = Placing {
                offset,
                frame: cell.frame,
                scale: Vec3::ONE,
            };
            let mut space = Space::default();
            if let Some(mesh) = assets.cell_shell(world, cell) {
                let id = |polygon| PixelId::new(PixelKind::Room, cell.id.0, polygon);
                space.bunches.push(placing.bunch(&mesh, id));
            }
            for portal in &cell.portals {
                let to = match portal.other {
                    PortalTarget::Outside => Some(Medium::Outdoors),
                    PortalTarget::Cell(other) => world.env_cell(other).map(|c| Medium::Room(c.id)),
                };
                let sign = if portal.interior_is_negative { 1.0 } else { -1.0 };
                let corners = cell.portal_vertices(portal);
                let mut opening = placing.opening(corners, portal.plane.normal, sign, to);
                if let (PortalTarget::Cell(other), false) = (portal.other, portal.exact_match) {
                    let far = world.env_cell(other);
                    let found = far.and_then(|c| Some((c, c.portal(portal.other_portal?)?)));
                    opening.partner = found.map(|(far, partner)| {
                        let there = Placing {
                            offset,
                            frame: far.frame,
                            scale: Vec3::ONE,
                        };
                        far.portal_vertices(partner)
                            .iter()
                            .map(|&p| there.point(p))
                            .collect()
                    });
                }
                space.openings.push(opening);
            }
            self.rooms.insert(cell.id, space);
            self.add_statics(world, assets, cell.id, Medium::Room(cell.id));
        }
    }

    /// The objects registered in a cell.
    fn add_statics(&mut self, world: &World, assets: &Assets, cell: CellId, medium: Medium) {
        for &r in world.statics_in(cell) {
            let Some(bunches) = object_bunches(world, assets, self.home, r) else {
                continue;
            };
            let space = match medium {
                Medium::Outdoors => &mut self.outdoors,
                Medium::Room(id) => self.rooms.entry(id).or_default(),
            };
            space.bunches.extend(bunches);
        }
    }

    /// What the pixel at (x, y), in pixels from the top left corner, shows; pixel centres lie at +0.5.
    pub fn pixel(&self, camera: &Camera, x: f32, y: f32) -> RayHit {
        let s = camera.slopes().as_dvec2();
        let v = camera.viewport().as_dvec2();
        let (cx, cz) = (
            (2.0 * f64::from(x) / v.x - 1.0) * s.x,
            (1.0 - 2.0 * f64::from(y) / v.y) * s.y,
        );
        let [right, forward, up] = camera.axes().map(|a| a.as_dvec3());
        let d = (right * cx + forward + up * cz).normalize();
        let eye = camera.eye().as_dvec3() + block_offset(self.home, camera.cell().block()).as_dvec3();
        let start = if camera.cell().is_indoor() {
            Medium::Room(camera.cell())
        } else {
            Medium::Outdoors
        };
        self.walk(eye, d, start)
    }

    fn walk(&self, eye: DVec3, d: DVec3, start: Medium) -> RayHit {
        let (mut medium, mut from) = (start, 0.0f64);
        let mut hit = RayHit {
            id: PixelId::BACKGROUND,
            distance: f64::INFINITY,
            disputed: false,
        };
        for _ in 0..MAX_CROSSINGS {
            let space = match medium {
                Medium::Outdoors => &self.outdoors,
                Medium::Room(id) => match self.rooms.get(&id) {
                    Some(space) => space,
                    None => return hit,
                },
            };
            let mut best: Option<(f64, PixelId)> = None;
            for bunch in &space.bunches {
                bunch.hit(eye, d, from - BACK, &mut best);
            }
            // A surface in the plane of an opening covers it: portal polygons can be larger than the hole in the wall.
            let reach = best.map_or(f64::INFINITY, |(t, _)| t - IN_PLANE);
            let mut next: Option<(f64, &Opening)> = None;
            for opening in &space.openings {
                if let Some(t) = opening.hit(eye, d) {
                    let nearest = next.map_or(reach, |(t, _)| t);
                    if t > from - BACK && t <= nearest {
                        next = Some((t, opening));
                    }
                }
            }
            match (next, best, medium) {
                (Some((t, opening)), ..) => {
                    hit.disputed |= opening
                        .partner
                        .as_ref()
                        .is_some_and(|p| !opening.inside(p, eye + d * t));
                    if let Some(to) = opening.to {
                        (medium, from) = (to, t);
                        continue;
                    }
                }
                (None, Some((t, id)), _) => (hit.id, hit.distance) = (id, t),
                (None, None, Medium::Outdoors) if self.has_land => hit.id = PixelId::SKY,
                (None, None, _) => {}
            }
            return hit;
        }
        hit
    }
}

/// Where geometry goes.
struct Placing {
    offset: DVec3,
    frame: Frame,
    scale: Vec3,
}

impl Placing {
    fn vector(&self, v: DVec3) -> DVec3 {
        let [a, b, c] = self.frame.axes().map(|a| a.as_dvec3());
        a * v.x + b * v.y + c * v.z
    }

    fn point(&self, p: Vec3) -> DVec3 {
        let p = p.as_dvec3() * self.scale.as_dvec3();
        self.vector(p) + self.frame.origin.as_dvec3() + self.offset
    }

    fn bunch(&self, mesh: &Mesh, id: impl Fn(u32) -> PixelId) -> Bunch {
        let mirrors = self.scale.x * self.scale.y * self.scale.z < 0.0;
        let mut triangles = Vec::new();
        for face in &mesh.faces {
            let see_through = mesh
                .materials
                .get(face.material as usize)
                .is_none_or(|m| m.list == DrawList::Blended);
            if see_through {
                continue;
            }
            let corners = mesh.corners(face);
            for k in 1..corners.len().saturating_sub(1) {
                let mut c = [corners[0], corners[k], corners[k + 1]].map(|v| self.point(v.position));
                if mirrors {
                    c.swap(1, 2);
                }
                triangles.push(Triangle {
                    corners: c,
                    id: id(u32::from(face.polygon)),
                });
            }
        }
        Bunch::of(triangles)
    }

    fn opening(&self, corners: &[Vec3], normal: Vec3, sign: f64, to: Option<Medium>) -> Opening {
        Opening {
            corners: corners.iter().map(|&p| self.point(p)).collect(),
            normal: self.vector(normal.as_dvec3()),
            sign,
            to,
            partner: None,
        }
    }
}

fn object_bunches(world: &World, assets: &Assets, home: BlockId, r: StaticRef) -> Option<Vec<Bunch>> {
    let object = world.static_object(r)?;
    let offset = block_offset(home, object.cell.block()).as_dvec3();
    let id = PixelId::new(PixelKind::Object, object.cell.0, r.index);
    let parts = object.shape.parts.iter().zip(&object.part_frames);
    let bunches = parts.filter_map(|(part, frame)| {
        let mesh = assets.model(world, part.model_id, None)?;
        let placing = Placing {
            offset,
            frame: *frame,
            scale: part.scale,
        };
        Some(placing.bunch(&mesh, |_| id))
    });
    Some(bunches.collect())
}

impl Bunch {
    fn of(triangles: Vec<Triangle>) -> Self {
        let n = (3 * triangles.len()).max(1) as f64;
        let corners = || triangles.iter().flat_map(|t| t.corners);
        let center = corners().fold(DVec3::ZERO, |a, c| a + c) / n;
        let square = corners()
            .map(|c| (c - center).length_squared())
            .fold(0.0, f64::max);
        Bunch {
            center,
            radius: square.sqrt() + 1.0e-3,
            triangles,
        }
    }

    fn hit(&self, eye: DVec3, d: DVec3, from: f64, best: &mut Option<(f64, PixelId)>) {
        let gap = self.center - eye;
        let along = gap.dot(d);
        if along + self.radius < from || gap.length_squared() - along * along > self.radius * self.radius {
            return;
        }
        for t in &self.triangles {
            if let Some(dist) = t.hit(eye, d)
                && dist > from
                && best.is_none_or(|(b, _)| dist < b)
            {
                *best = Some((dist, t.id));
            }
        }
    }
}

impl Triangle {
    /// Distance to where the ray meets the front.
    fn hit(&self, eye: DVec3, d: DVec3) -> Option<f64> {
        let [a, b, c] = self.corners;
        let (e1, e2) = (b - a, c - a);
        let n = e1.cross(e2);
        let facing = n.dot(d);
        if !(facing < 0.0) {
            return None;
        }
        let s = a - eye;
        let t = n.dot(s) / facing;
        // Signed volumes of the ray and the three edges.
        let side = |p: DVec3, q: DVec3| d.dot((p - eye).cross(q - eye));
        let inside = side(a, b) <= 0.0 && side(b, c) <= 0.0 && side(c, a) <= 0.0;
        (inside && t > 0.0).then_some(t)
    }
}

impl Opening {
    fn hit(&self, eye: DVec3, d: DVec3) -> Option<f64> {
        let along = self.normal.dot(d);
        if !(along * self.sign > 0.0) {
            return None;
        }
        let first = self.corners.first()?;
        let t = self.normal.dot(*first - eye) / along;
        self.inside(&self.corners, eye + d * t).then_some(t)
    }

    /// Whether a point of the plane lies in a convex polygon of it.
    fn inside(&self, corners: &[DVec3], p: DVec3) -> bool {
        let n = corners.len();
        let (mut all_left, mut all_right) = (n >= 3, n >= 3);
        for k in 0..n {
            let (a, b) = (corners[k], corners[(k + 1) % n]);
            let side = self.normal.dot((b - a).cross(p - a));
            all_left &= side >= 0.0;
            all_right &= side <= 0.0;
        }
        all_left || all_right
    }
}
