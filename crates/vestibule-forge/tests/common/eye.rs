//! What an eye at a point sees through portals, exactly: an oracle for stab lists.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};
use vestibule_world::{CellId, CellPortal, EnvCell, PortalTarget, World};

/// A portal's polygon in the frame of its landblock.
pub(crate) fn portal_points(cell: &EnvCell, portal: &CellPortal) -> Vec<DVec3> {
    cell.portal_vertices(portal)
        .iter()
        .map(|v| cell.frame.local_to_global(*v).as_dvec3())
        .collect()
}

fn clip(points: &[DVec3], inside: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut out = Vec::new();
    for (i, a) in points.iter().enumerate() {
        let b = points[(i + 1) % points.len()];
        let (da, db) = (inside(*a), inside(b));
        if da >= 0.0 {
            out.push(*a);
        }
        if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
            out.push(*a + (b - *a) * (da / (da - db)));
        }
    }
    out
}

fn area(points: &[DVec3]) -> f64 {
    points
        .windows(2)
        .skip(1)
        .map(|w| (w[0] - points[0]).cross(w[1] - points[0]))
        .sum::<DVec3>()
        .length()
        / 2.0
}

/// The cells seen from `eye` in `cell`, and whether the outside is.
pub(crate) fn seen(world: &World, cell: &EnvCell, eye: DVec3) -> (BTreeSet<CellId>, bool) {
    let mut out = (BTreeSet::new(), false);
    look(world, cell, eye, None, &mut vec![cell.id], &mut out);
    out
}

fn look(
    world: &World,
    cell: &EnvCell,
    eye: DVec3,
    view: Option<&[DVec3]>,
    chain: &mut Vec<CellId>,
    out: &mut (BTreeSet<CellId>, bool),
) {
    for portal in &cell.portals {
        let local = cell.frame.global_to_local(eye.as_vec3());
        let front = portal.plane.dist(local);
        let depth = if portal.interior_is_negative {
            -front
        } else {
            front
        };
        if depth < 1.0e-3 {
            continue; // Seen from behind, or edge-on.
        }
        let mut polygon = portal_points(cell, portal);
        if let Some(view) = view {
            let middle: DVec3 = view.iter().sum::<DVec3>() / view.len() as f64 - eye;
            for (i, a) in view.iter().enumerate() {
                let b = view[(i + 1) % view.len()];
                let normal = (*a - eye).cross(b - eye);
                let normal = normal * normal.dot(middle).signum();
                polygon = clip(&polygon, |p| normal.dot(p - eye));
                if polygon.len() < 3 {
                    break;
                }
            }
        }
        if polygon.len() < 3 || area(&polygon) < 1.0e-5 {
            continue;
        }
        match portal.other {
            PortalTarget::Outside => out.1 = true,
            PortalTarget::Cell(id) if chain.contains(&id) => {}
            PortalTarget::Cell(id) => {
                out.0.insert(id);
                if let Some(next) = world.env_cell(id) {
                    chain.push(id);
                    look(world, next, eye, Some(&polygon), chain, out);
                    chain.pop();
                }
            }
        }
    }
}

/// Points inside a cell, spread by a counter; landblock frame.
pub(crate) fn points_inside(cell: &EnvCell, count: usize, seed: u64) -> Vec<Vec3> {
    let Some(bounds) = cell.structure.bounds else {
        return Vec::new();
    };
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let mut out = Vec::new();
    for _ in 0..count * 50 {
        let p = bounds.min + (bounds.max - bounds.min) * Vec3::new(next(), next(), next());
        if out.len() < count
            && cell
                .structure
                .cell_bsp
                .planes()
                .iter()
                .all(|plane| plane.dist(p) > 0.001)
        {
            out.push(cell.frame.local_to_global(p));
        }
    }
    out
}
