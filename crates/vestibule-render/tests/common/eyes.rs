//! Random eyes and directions that do not stand in walls.

use glam::Vec3;
use vestibule_view::Camera;
use vestibule_world::CellId;

use super::stage::{Stage, camera};

/// A small fixed generator.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// 0…1.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u64 << 24) as f32
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() >> 33) as usize % n.max(1)
    }

    pub fn between(&mut self, a: f32, b: f32) -> f32 {
        a + (b - a) * self.unit()
    }

    /// A direction, more often level than steep.
    pub fn direction(&mut self) -> Vec3 {
        let turn = self.between(0.0, std::f32::consts::TAU);
        let pitch = self.between(-1.0, 1.0);
        let pitch = pitch * pitch * pitch * 1.4;
        let (s, c) = libm::sincosf(turn);
        let (sp, cp) = libm::sincosf(pitch);
        Vec3::new(s * cp, c * cp, sp)
    }
}

/// Distance of a point from a triangle.
fn distance(p: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let on_edge = |a: Vec3, b: Vec3| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-12)).clamp(0.0, 1.0);
        (p - (a + (b - a) * t)).length()
    };
    let edges = on_edge(a, b).min(on_edge(b, c)).min(on_edge(c, a));
    let n = (b - a).cross(c - a).normalize_or_zero();
    if n == Vec3::ZERO {
        // Three corners in a line, where a wall's edge is divided.
        return edges;
    }
    let inside = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|&(a, b)| n.dot((b - a).cross(p - a)) >= 0.0);
    if inside {
        edges.min(n.dot(p - a).abs())
    } else {
        edges
    }
}

/// Whether the nearest triangle that a ray meets turns its back to it.
fn first_is_back(triangles: &[[Vec3; 3]], eye: Vec3, d: Vec3) -> bool {
    let mut best = (f32::INFINITY, false);
    for [a, b, c] in triangles {
        let side = |p: Vec3, q: Vec3| d.dot((p - eye).cross(q - eye));
        let (u, v, w) = (side(*a, *b), side(*b, *c), side(*c, *a));
        let n = (*b - *a).cross(*c - *a);
        let t = n.dot(*a - eye) / n.dot(d);
        if (u <= 0.0 && v <= 0.0 && w <= 0.0 || u >= 0.0 && v >= 0.0 && w >= 0.0) && t > 0.0 && t < best.0 {
            best = (t, n.dot(d) > 0.0);
        }
    }
    best.1
}

/// The drawn triangles of a room and of the objects registered in it, landblock frame.
fn solid(stage: &Stage, id: CellId) -> Vec<[Vec3; 3]> {
    let Some(cell) = stage.world.env_cell(id) else {
        return Vec::new();
    };
    let mut out = Vec::new();
    let mut add = |mesh: &vestibule_render::Mesh, place: &dyn Fn(Vec3) -> Vec3| {
        for face in &mesh.faces {
            let c = mesh.corners(face);
            for k in 1..c.len() - 1 {
                out.push([c[0], c[k], c[k + 1]].map(|v| place(v.position)));
            }
        }
    };
    if let Some(mesh) = stage.assets.cell_shell(&stage.world, cell) {
        add(&mesh, &|p| cell.frame.local_to_global(p));
    }
    for &r in stage.world.statics_in(id) {
        let object = stage.world.static_object(r).unwrap();
        for (part, frame) in object.shape.parts.iter().zip(&object.part_frames) {
            if let Some(mesh) = stage.assets.model(&stage.world, part.model_id, None) {
                add(&mesh, &|p| frame.local_to_global(p * part.scale));
            }
        }
    }
    out
}

/// Makes eyes in the rooms of a landblock.
pub struct Rooms {
    /// Where eyes go.
    pub cells: Vec<CellId>,
    all: Vec<CellId>,
    solids: Vec<Vec<[Vec3; 3]>>,
    /// A camera keeps its sphere clear of walls; here a little less will do.
    pub clearance: f32,
}

impl Rooms {
    pub fn new(stage: &Stage) -> Self {
        let block = stage.world.block(stage.block).unwrap();
        let cells: Vec<CellId> = block
            .env_cells()
            .filter(|c| !c.portals.is_empty())
            .map(|c| c.id)
            .collect();
        let solids = cells.iter().map(|&id| solid(stage, id)).collect();
        Rooms {
            all: cells.clone(),
            cells,
            solids,
            clearance: 0.16,
        }
    }

    /// Only these rooms.
    pub fn only(stage: &Stage, keep: impl Fn(CellId) -> bool) -> Self {
        let mut rooms = Rooms::new(stage);
        rooms.cells.retain(|&id| keep(id));
        rooms
    }

    /// Whether a point is this far from everything drawn in a room.
    pub fn is_clear(&self, id: CellId, eye: Vec3, clearance: f32) -> bool {
        let own = self
            .all
            .iter()
            .position(|&c| c == id)
            .map_or(&[][..], |k| &self.solids[k]);
        own.iter().all(|t| distance(eye, *t) >= clearance)
    }

    /// An eye anywhere in a room, clear of walls and furniture of the room and of its neighbours; now and then right
    /// before or behind an opening.
    pub fn eye(&self, stage: &Stage, random: &mut Random) -> (CellId, Vec3) {
        loop {
            let at = random.below(self.cells.len());
            let id = self.cells[at];
            let cell = stage.world.env_cell(id).unwrap();
            let eye = if random.below(8) == 0 && !cell.portals.is_empty() {
                let portal = &cell.portals[random.below(cell.portals.len())];
                let corners = cell.portal_vertices(portal);
                let mut weights: Vec<f32> = corners.iter().map(|_| random.unit()).collect();
                let sum: f32 = weights.iter().sum();
                weights.iter_mut().for_each(|w| *w /= sum);
                let p: Vec3 = corners.iter().zip(&weights).map(|(c, w)| *c * *w).sum();
                let inward = if portal.interior_is_negative { -1.0 } else { 1.0 };
                let gap = [1.0e-4, 1.0e-3, 0.02, 0.09][random.below(4)];
                cell.frame
                    .local_to_global(p + portal.plane.normal * (inward * gap))
            } else {
                let bounds = cell.structure.bounds.unwrap();
                let p = Vec3::new(
                    random.between(bounds.min.x, bounds.max.x),
                    random.between(bounds.min.y, bounds.max.y),
                    random.between(bounds.min.z, bounds.max.z),
                );
                cell.frame.local_to_global(p)
            };
            if !cell.contains_point(eye) {
                continue;
            }
            let clear = |id: CellId| {
                self.all
                    .iter()
                    .position(|&c| c == id)
                    .is_none_or(|k| self.solids[k].iter().all(|t| distance(eye, *t) >= self.clearance))
            };
            // Not inside a block that stands in the room: the first thing met shows its front.
            let own = self
                .all
                .iter()
                .position(|&c| c == id)
                .map_or(&[][..], |k| &self.solids[k]);
            if [
                Vec3::new(0.3, 0.5, 0.8),
                Vec3::new(-0.6, 0.2, 0.3),
                Vec3::new(0.2, -0.7, -0.4),
            ]
            .iter()
            .any(|&d| first_is_back(own, eye, d))
            {
                continue;
            }
            let around = cell.portals.iter().filter_map(|p| match p.other {
                vestibule_world::PortalTarget::Cell(other) => Some(other),
                vestibule_world::PortalTarget::Outside => None,
            });
            if clear(id) && around.into_iter().all(clear) {
                return (id, eye);
            }
        }
    }
}

impl Stage {
    /// Whether a point is a little away from every building's shell, and not inside the wall between shell and rooms.
    pub fn clear_of_shells(&self, eye: Vec3) -> bool {
        let Some(block) = self.world.block(self.block) else {
            return true;
        };
        block.buildings.iter().all(|building| {
            let (Some(part), Some(frame)) = (building.shape.parts.first(), building.part_frames.first())
            else {
                return true;
            };
            let Some(model) = &part.model else { return true };
            let Some(mesh) = self.assets.model(&self.world, part.model_id, Some(model)) else {
                return true;
            };
            let local = frame.global_to_local(eye);
            let b = model.bounds;
            let in_box =
                local.cmpge(b.min - Vec3::splat(0.2)).all() && local.cmple(b.max + Vec3::splat(0.2)).all();
            if !in_box {
                return true;
            }
            let mut best: Option<(f32, bool)> = None;
            for face in &mesh.faces {
                let c = mesh.corners(face);
                for k in 1..c.len() - 1 {
                    let t = [c[0], c[k], c[k + 1]].map(|v| v.position);
                    let d = distance(local, t);
                    let n = (t[1] - t[0]).cross(t[2] - t[0]);
                    if n.length_squared() < 1e-12 {
                        continue;
                    }
                    let front = n.dot(local - t[0]) > 0.0;
                    if best.is_none_or(|(b, _)| d < b) {
                        best = Some((d, front));
                    }
                }
            }
            // In front of the nearest wall: outside the shell.
            best.is_none_or(|(d, front)| front && d >= 0.16)
        })
    }
}

/// An eye outdoors near a building, in front of all shells.
pub fn outdoor_eye(stage: &Stage, random: &mut Random) -> (CellId, Vec3) {
    let block = stage.world.block(stage.block);
    loop {
        let buildings = block.map_or(&[][..], |b| &b.buildings);
        let Some(house) = buildings.get(random.below(buildings.len())) else {
            continue;
        };
        let reach = if random.below(2) == 0 { 14.0 } else { 60.0 };
        let p =
            house.frame.origin + Vec3::new(random.between(-reach, reach), random.between(-reach, reach), 0.0);
        let Some(ground) = stage.world.ground_at(CellId::new(stage.block, 1), p) else {
            continue;
        };
        if ground.cell.block() != stage.block {
            continue;
        }
        let eye = Vec3::new(p.x, p.y, ground.z + random.between(0.3, 6.0));
        let inside = block.is_some_and(|b| b.env_cells().any(|c| c.contains_point(eye)));
        if !inside && stage.clear_of_shells(eye) {
            return (ground.cell, eye);
        }
    }
}

/// A camera anywhere: in a room, or outdoors and mostly looking at a building.
pub fn mixed_camera(stage: &Stage, rooms: &Rooms, random: &mut Random, size: (u32, u32)) -> Camera {
    let block = stage.world.block(stage.block);
    let buildings = block.map_or(&[][..], |b| &b.buildings);
    let (cell, eye) = if !buildings.is_empty() && random.below(2) == 0 {
        outdoor_eye(stage, random)
    } else {
        rooms.eye(stage, random)
    };
    let mut forward = random.direction();
    if !cell.is_indoor()
        && let Some(house) = buildings.get(random.below(buildings.len()))
    {
        let gap = house.frame.origin + Vec3::Z * 1.5 - eye;
        forward = (gap.normalize_or_zero() + forward * 0.3).normalize_or_zero();
    }
    camera(cell, eye, forward, size, 1.2)
}
