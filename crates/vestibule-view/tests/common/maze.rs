//! Random worlds of connected rooms and the ray walk that is their ground truth (`visibility.md` 17.1, 17.2).

use std::collections::BTreeSet;

use glam::{Quat, Vec3};
use vestibule_view::{Camera, RoomSpec};
use vestibule_world::{CellId, Frame, PortalTarget};

use super::{Rooms, Span, VIEWPORT, at_x, at_y};

/// A small generator with a fixed sequence (splitmix64).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// 0…1.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u64 << 24) as f32
    }

    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    pub fn chance(&mut self, p: f32) -> bool {
        self.unit() < p
    }
}

pub struct Maze {
    pub rooms: Rooms,
    /// Room of each square.
    pub owner: Vec<usize>,
    pub columns: usize,
    pub rows: usize,
    pub convex: bool,
}

const SIDE: f32 = 10.0;

impl Maze {
    /// 2…6 by 2…6 squares of 10 m, doors at random, some of them double; with `merge` squares are joined to rooms
    /// that need not be convex. Some outer walls have exits. Everything is turned about z by a random angle.
    pub fn random(random: &mut Random, merge: bool) -> Self {
        let (columns, rows) = (2 + random.below(5), 2 + random.below(5));
        let squares = columns * rows;
        let mut owner: Vec<usize> = (0..squares).collect();
        if merge {
            for _ in 0..squares / 2 {
                let a = random.below(squares);
                let b = if random.chance(0.5) { a + 1 } else { a + columns };
                if b < squares && (b == a + columns || b % columns != 0) {
                    let (from, to) = (owner[b], owner[a]);
                    owner.iter_mut().filter(|o| **o == from).for_each(|o| *o = to);
                }
            }
            // Number the rooms without gaps.
            let mut names: Vec<usize> = owner.clone();
            names.sort_unstable();
            names.dedup();
            for o in &mut owner {
                *o = names.binary_search(o).unwrap();
            }
        }
        let count = owner.iter().max().unwrap() + 1;
        let mut rooms = Rooms::new();
        for room in 0..count {
            let squares = owner
                .iter()
                .enumerate()
                .filter(|(_, o)| **o == room)
                .map(|(s, _)| s);
            let (mut x, mut y): (Span, Span) = ((f32::INFINITY, 0.0), (f32::INFINITY, 0.0));
            for s in squares {
                let (cx, cy) = ((s % columns) as f32 * SIDE, (s / columns) as f32 * SIDE);
                x = (x.0.min(cx), x.1.max(cx + SIDE));
                y = (y.0.min(cy), y.1.max(cy + SIDE));
            }
            rooms.room(&format!("R{room}"), x, y);
        }
        let convex = (0..count).all(|r| owner.iter().filter(|o| **o == r).count() == 1);
        for s in 0..squares {
            let (cx, cy) = (s % columns, s / columns);
            let (x, y) = (cx as f32 * SIDE, cy as f32 * SIDE);
            let east = (cx + 1 < columns).then_some(s + 1);
            let north = (cy + 1 < rows).then_some(s + columns);
            for (next, northward) in [(east, false), (north, true)] {
                let Some(n) = next else {
                    if random.chance(0.2) {
                        let opening = opening(random, x, y, northward);
                        rooms.exit(owner[s], &opening);
                    }
                    continue;
                };
                if owner[s] == owner[n] {
                    continue;
                }
                for _ in 0..2 {
                    if random.chance(0.45) {
                        let opening = opening(random, x, y, northward);
                        if random.chance(0.2) {
                            let other = self::opening(random, x, y, northward);
                            rooms.mismatched_door(owner[s], &opening, owner[n], &other, false);
                        } else {
                            rooms.door(owner[s], owner[n], &opening);
                        }
                    }
                }
            }
        }
        let turn = random.within(0.0, core::f32::consts::TAU);
        let frame = Frame::new(
            Vec3::new(
                random.within(-100.0, 300.0),
                random.within(-100.0, 300.0),
                random.within(-20.0, 20.0),
            ),
            Quat::from_xyzw(0.0, 0.0, libm::sinf(turn / 2.0), libm::cosf(turn / 2.0)),
        );
        for spec in &mut rooms.specs {
            spec.frame = frame;
        }
        Maze {
            rooms,
            owner,
            columns,
            rows,
            convex,
        }
    }

    /// A camera somewhere in the maze, looking somewhere.
    pub fn camera(&self, random: &mut Random) -> Camera {
        let square = random.below(self.owner.len());
        let (cx, cy) = (
            (square % self.columns) as f32 * SIDE,
            (square / self.columns) as f32 * SIDE,
        );
        let local = Vec3::new(
            cx + random.within(0.2, SIDE - 0.2),
            cy + random.within(0.2, SIDE - 0.2),
            random.within(0.3, 2.7),
        );
        let yaw = random.within(0.0, core::f32::consts::TAU);
        let look = Vec3::new(libm::sinf(yaw), libm::cosf(yaw), random.within(-0.4, 0.4));
        let room = self.owner[square];
        let eye = self.rooms.specs[room].frame.local_to_global(local);
        let fov = random.within(0.6, 2.2);
        Camera::new(super::id(room), eye, look, Vec3::Z, fov, VIEWPORT).unwrap()
    }
}

fn opening(random: &mut Random, x: f32, y: f32, northward: bool) -> Vec<Vec3> {
    let from = random.within(0.2, 7.0);
    let width = random.within(0.3, 9.8 - from);
    let sill = if random.chance(0.3) {
        random.within(0.2, 1.5)
    } else {
        0.0
    };
    let z = (sill, random.within(sill + 0.5, 3.0));
    if northward {
        at_y(y + SIDE, (x + from, x + from + width), z)
    } else {
        at_x(x + SIDE, (y + from, y + from + width), z)
    }
}

/// What a ray passes: rooms in order, and whether it got outside.
pub struct Walk {
    pub rooms: Vec<CellId>,
    /// How far along the ray each room is entered.
    pub entered: Vec<f64>,
    pub outside: bool,
}

type D3 = [f64; 3];

fn wide(v: Vec3) -> D3 {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}

fn sub(a: D3, b: D3) -> D3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: D3, b: D3) -> D3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: D3, b: D3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Distance along the ray to a convex polygon, whether inside by at least `margin` metres, and the eye's side.
fn hit(polygon: &[Vec3], eye: D3, ray: D3) -> Option<f64> {
    let points: Vec<D3> = polygon.iter().map(|&p| wide(p)).collect();
    let normal = cross(sub(points[1], points[0]), sub(points[2], points[0]));
    let along = dot(normal, ray);
    if along == 0.0 {
        return None;
    }
    let t = dot(normal, sub(points[0], eye)) / along;
    let at = [eye[0] + ray[0] * t, eye[1] + ray[1] * t, eye[2] + ray[2] * t];
    let inside = (0..points.len()).all(|k| {
        let (a, b) = (points[k], points[(k + 1) % points.len()]);
        dot(cross(sub(b, a), sub(at, a)), normal) > 0.0
    });
    inside.then_some(t)
}

fn side(polygon: &[Vec3], eye: D3) -> f64 {
    let points: Vec<D3> = polygon.iter().map(|&p| wide(p)).collect();
    let normal = cross(sub(points[1], points[0]), sub(points[2], points[0]));
    dot(normal, sub(eye, points[0]))
}

/// The oracle of `visibility.md` 17.1, in double precision: from the root cross the nearest opening ahead.
pub fn walk(specs: &[RoomSpec], root: usize, eye: Vec3, ray: Vec3) -> Walk {
    let frame = &specs[root].frame;
    let (eye, ray) = (
        wide(frame.global_to_local(eye)),
        wide(frame.global_to_local_vec(ray)),
    );
    let mut out = Walk {
        rooms: vec![specs[root].id],
        entered: vec![0.0],
        outside: false,
    };
    let (mut room, mut distance) = (root, 0.0f64);
    for _ in 0..200 {
        let mut best: Option<(f64, PortalTarget)> = None;
        for portal in &specs[room].portals {
            let s = side(&portal.vertices, eye);
            if (s < 0.0) != portal.interior_is_negative {
                continue;
            }
            let Some(t) = hit(&portal.vertices, eye, ray).filter(|&t| t > distance) else {
                continue;
            };
            if best.is_none_or(|(b, _)| t < b) {
                best = Some((t, portal.target));
            }
        }
        let Some((t, target)) = best else { break };
        match target {
            PortalTarget::Outside => {
                out.outside = true;
                break;
            }
            PortalTarget::Cell(id) => {
                let next = usize::from(id.low() - 0x100);
                // Where a link is no exact match both polygons count. Doors of one wall may overlap.
                let open = specs[room]
                    .portals
                    .iter()
                    .filter(|p| p.target == target)
                    .filter(|p| hit(&p.vertices, eye, ray).is_some_and(|u| (u - t).abs() < 1.0e-9))
                    .any(|p| {
                        let far = &specs[next].portals[usize::from(p.other_portal.unwrap())];
                        p.exact_match || hit(&far.vertices, eye, ray).is_some()
                    });
                if !open {
                    break;
                }
                room = next;
                distance = t;
                out.rooms.push(id);
                out.entered.push(t);
            }
        }
    }
    out
}

/// Rooms that can be reached through doors at all.
pub fn connected(specs: &[RoomSpec], root: usize) -> BTreeSet<usize> {
    let mut found = BTreeSet::from([root]);
    let mut todo = vec![root];
    while let Some(room) = todo.pop() {
        for portal in &specs[room].portals {
            if let PortalTarget::Cell(id) = portal.target {
                let next = usize::from(id.low() - 0x100);
                if found.insert(next) {
                    todo.push(next);
                }
            }
        }
    }
    found
}
