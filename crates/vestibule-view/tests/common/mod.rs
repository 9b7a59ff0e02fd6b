//! Worlds of box rooms made on the spot, as in `visibility.md` 16.
#![allow(dead_code, unreachable_pub, reason = "each test file uses its own part")]

pub mod maze;

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use vestibule_view::{BlockOpenings, Camera, Flood, PortalSpec, Region, RoomSpec};
use vestibule_world::{BlockId, CellBsp, CellId, Frame, Plane, PortalTarget};

pub const BLOCK: BlockId = BlockId(0xA9B4);
pub const VIEWPORT: Vec2 = Vec2::splat(512.0);

pub fn id(room: usize) -> CellId {
    CellId::new(BLOCK, 0x0100 + room as u16)
}

pub fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Rooms under construction; names are for messages and expectations.
#[derive(Clone, Default)]
pub struct Rooms {
    pub specs: Vec<RoomSpec>,
    pub names: Vec<String>,
}

pub type Span = (f32, f32);

/// Rectangle at x = `x`, its positive side towards +x.
pub fn at_x(x: f32, y: Span, z: Span) -> Vec<Vec3> {
    vec![v(x, y.0, z.0), v(x, y.1, z.0), v(x, y.1, z.1), v(x, y.0, z.1)]
}

/// Rectangle at y = `y`, its positive side towards +y.
pub fn at_y(y: f32, x: Span, z: Span) -> Vec<Vec3> {
    vec![v(x.1, y, z.0), v(x.0, y, z.0), v(x.0, y, z.1), v(x.1, y, z.1)]
}

/// Rectangle at z = `z`, its positive side up.
pub fn at_z(z: f32, x: Span, y: Span) -> Vec<Vec3> {
    vec![v(x.0, y.0, z), v(x.1, y.0, z), v(x.1, y.1, z), v(x.0, y.1, z)]
}

pub const TALL: Span = (0.0, 2.5);

impl Rooms {
    pub fn new() -> Self {
        Self::default()
    }

    /// A box room.
    pub fn room(&mut self, name: &str, x: Span, y: Span) -> usize {
        self.tall_room(name, x, y, (0.0, 3.0))
    }

    pub fn tall_room(&mut self, name: &str, x: Span, y: Span, z: Span) -> usize {
        let plane = |normal: Vec3, d: f32| Plane { normal, d };
        let planes = vec![
            plane(Vec3::X, -x.0),
            plane(-Vec3::X, x.1),
            plane(Vec3::Y, -y.0),
            plane(-Vec3::Y, y.1),
            plane(Vec3::Z, -z.0),
            plane(-Vec3::Z, z.1),
        ];
        self.specs.push(RoomSpec {
            id: id(self.specs.len()),
            frame: Frame::IDENTITY,
            bsp: CellBsp::new(planes, true),
            portals: Vec::new(),
            stab_list: Vec::new(),
        });
        self.names.push(name.to_owned());
        self.specs.len() - 1
    }

    /// A pair of portals: `behind` lies on the polygon's negative side, `front` on its positive side.
    pub fn door(&mut self, behind: usize, front: usize, polygon: &[Vec3]) {
        self.mismatched_door(behind, polygon, front, polygon, true);
    }

    pub fn mismatched_door(&mut self, behind: usize, p: &[Vec3], front: usize, q: &[Vec3], exact: bool) {
        let (a, b) = (
            self.specs[behind].portals.len() as u16,
            self.specs[front].portals.len() as u16,
        );
        let b = if behind == front { b + 1 } else { b };
        self.specs[behind].portals.push(PortalSpec {
            target: PortalTarget::Cell(id(front)),
            other_portal: Some(b),
            vertices: p.to_vec(),
            interior_is_negative: true,
            exact_match: exact,
        });
        self.specs[front].portals.push(PortalSpec {
            target: PortalTarget::Cell(id(behind)),
            other_portal: Some(a),
            vertices: q.to_vec(),
            interior_is_negative: false,
            exact_match: exact,
        });
    }

    /// An exit; the room lies on the polygon's negative side.
    pub fn exit(&mut self, room: usize, polygon: &[Vec3]) {
        self.specs[room].portals.push(PortalSpec {
            target: PortalTarget::Outside,
            other_portal: None,
            vertices: polygon.to_vec(),
            interior_is_negative: true,
            exact_match: true,
        });
    }

    /// Every room may see every other.
    pub fn full_stabs(&mut self) {
        let all: Vec<CellId> = self.specs.iter().map(|s| s.id).collect();
        for spec in &mut self.specs {
            spec.stab_list = all.iter().copied().filter(|&i| i != spec.id).collect();
        }
    }

    pub fn build(&mut self) -> BlockOpenings {
        self.full_stabs();
        BlockOpenings::from_rooms(BLOCK, &self.specs)
    }

    /// Names of the draw list.
    pub fn list(&self, flood: &Flood<'_>) -> Vec<&str> {
        flood
            .cells()
            .iter()
            .map(|c| self.names[usize::from(c.id.low() - 0x100)].as_str())
            .collect()
    }

    /// Names of the seen rooms and their number of views.
    pub fn views(&self, flood: &Flood<'_>) -> BTreeMap<&str, usize> {
        flood
            .cells()
            .iter()
            .map(|c| {
                (
                    self.names[usize::from(c.id.low() - 0x100)].as_str(),
                    flood.regions(c).len(),
                )
            })
            .collect()
    }
}

/// A camera with the same half slope both ways.
pub fn camera(root: usize, eye: Vec3, look: Vec3, slope: f32) -> Camera {
    let up = if look.z.abs() > 0.9 { Vec3::Y } else { Vec3::Z };
    Camera::new(id(root), eye, look, up, 2.0 * libm::atanf(slope), VIEWPORT).unwrap()
}

/// A region's bounds in slopes relative to the camera's forward axis: (x from, x to, z from, z to).
pub fn slopes(camera: &Camera, region: Region<'_>) -> [f32; 4] {
    let mut out = [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY];
    for e in region.edges() {
        let c = camera.to_camera(e.corner);
        let (x, z) = (c.x / c.y, c.z / c.y);
        out = [out[0].min(x), out[1].max(x), out[2].min(z), out[3].max(z)];
    }
    out
}

/// Bounds of each view of the cell with this name.
pub fn views_of(rooms: &Rooms, flood: &Flood<'_>, camera: &Camera, name: &str) -> Vec<[f32; 4]> {
    let at = rooms.names.iter().position(|n| n == name).unwrap();
    let Some(position) = flood.position(id(at)) else {
        return Vec::new();
    };
    flood
        .regions(&flood.cells()[position])
        .map(|r| slopes(camera, r))
        .collect()
}

#[track_caller]
pub fn assert_bounds(got: [f32; 4], want: [f32; 4]) {
    for (g, w) in got.iter().zip(want) {
        assert!(
            (g - w).abs() < 2.0e-4 * w.abs().max(1.0),
            "{got:?}, expected {want:?}"
        );
    }
}

/// Only the horizontal bounds.
#[track_caller]
pub fn assert_x(got: [f32; 4], low: f32, high: f32) {
    assert!(
        (got[0] - low).abs() < 2.0e-4 && (got[1] - high).abs() < 2.0e-4,
        "{got:?}, expected {low}..{high}"
    );
}
