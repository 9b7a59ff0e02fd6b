//! Clipping openings against views: `GetClip`, `ClipPortals`, `OtherPortalClip` (`visibility.md` 3, 5.5, 14).

use glam::Vec3;

use super::{DEAD_COUNTED, IN, ON_PLANE_COUNTED, ON_PLANE_INSIDE, OUTSIDE, PView, PieceState, Scene, Shape};
use crate::camera::Camera;
use crate::constants::{CLIP_TOLERANCE, EPSILON, ON_PLANE_MARGIN};
use crate::flood::FloodCounters;
use crate::openings::{NONE, Target};
use crate::view::{Edge, edge_normal};

impl PView {
    /// ClipPortals for the views not handed on yet (`visibility.md` 5.5). False when no portal is usable.
    pub(super) fn clip_portals(&mut self, scene: &Scene<'_>, room: u32) -> bool {
        let mut view = core::mem::replace(&mut self.rooms[room as usize].pending, NONE);
        let portals = scene.openings.portals_of(room);
        let usable = portals.clone().any(|p| {
            self.portals[p as usize].flags & IN == 0
                && scene.openings.portals[p as usize].target != Target::Missing
        });
        while view != NONE {
            for p in portals.clone() {
                if self.portals[p as usize].flags & IN == 0 {
                    self.clip_portal(scene, view, p);
                }
            }
            view = self.views[view as usize].next;
        }
        usable
    }

    /// One view through one opening.
    pub(super) fn clip_portal(&mut self, scene: &Scene<'_>, view: u32, p: u32) {
        let portal = &scene.openings.portals[p as usize];
        let to = match portal.target {
            Target::Outside if scene.start.to_outside => OUTSIDE,
            Target::Outside => return,
            Target::Missing if self.portals[p as usize].flags & DEAD_COUNTED != 0 => return,
            Target::Missing => NONE,
            Target::Room(other) => {
                if self.settings.stab_gate
                    && other != scene.start.room
                    && scene.start.stabs.binary_search(&other).is_err()
                {
                    return;
                }
                other
            }
        };
        if self.eye_is_in_opening(scene, p) {
            // `visibility.md` 12.2: the whole view is handed on, its edges shared.
            let (first, count) = (
                self.views[view as usize].first_edge,
                self.views[view as usize].edge_count,
            );
            self.deliver(scene, to, view, p, Shape::Shared(first, count));
            return;
        }
        let reciprocal = if portal.exact_match || to >= OUTSIDE {
            NONE
        } else {
            portal.other_portal
        };
        for piece in portal.first_piece..portal.first_piece + portal.piece_count {
            if !self.clip_piece(scene, view, p, piece) {
                continue;
            }
            if reciprocal == NONE {
                if self.tidy(scene) {
                    self.deliver(scene, to, view, p, Shape::Polygon);
                }
            } else {
                self.other_portal_clip(scene, to, view, p, reciprocal);
            }
        }
    }

    /// GetClip: one piece of an opening against a view, into `self.polygon` (`visibility.md` 14.3-14.6).
    pub(super) fn clip_piece(&mut self, scene: &Scene<'_>, view: u32, p: u32, piece: u32) -> bool {
        let v = self.views[view as usize];
        let planes = v.first_edge as usize..v.first_edge as usize + usize::from(v.edge_count);
        let (first, count) = self.corner_rays(scene, p, piece);
        let rays = &self.rays[first..first + count];
        let planes = &self.edges[planes];
        if planes
            .iter()
            .any(|e| rays.iter().all(|r| e.normal.dot(r.corner) < -CLIP_TOLERANCE))
        {
            return false;
        }
        side_normals(&mut self.pieces[piece as usize], &mut self.rays);
        self.polygon.set(&self.rays[first..first + count]);
        self.polygon.clip(planes) && self.polygon.finish()
    }

    /// OtherPortalClip: what is left is clipped by the far cell's own polygon (`visibility.md` 3.4).
    pub(super) fn other_portal_clip(
        &mut self,
        scene: &Scene<'_>,
        to: u32,
        view: u32,
        p: u32,
        reciprocal: u32,
    ) {
        self.touch(scene, to);
        if !self.tidy(scene) {
            return;
        }
        if self.eye_is_in_opening(scene, reciprocal) {
            self.deliver(scene, to, view, p, Shape::Polygon);
            return;
        }
        let portal = &scene.openings.portals[reciprocal as usize];
        core::mem::swap(&mut self.polygon, &mut self.far);
        for piece in portal.first_piece..portal.first_piece + portal.piece_count {
            let (first, count) = self.corner_rays(scene, reciprocal, piece);
            side_normals(&mut self.pieces[piece as usize], &mut self.rays);
            self.polygon.set(&self.rays[first..first + count]);
            if self.polygon.clip(self.far.edges()) && self.polygon.finish() && self.tidy(scene) {
                self.deliver(scene, to, view, p, Shape::Polygon);
            }
        }
        core::mem::swap(&mut self.polygon, &mut self.far);
    }

    /// Brings the clipped polygon to at most the allowed number of edges; in retail mode cleans it up in pixels.
    pub(super) fn tidy(&mut self, scene: &Scene<'_>) -> bool {
        let max = self.settings.max_edges;
        if let (Some(camera), true) = (scene.camera, self.settings.min_px > 0.0) {
            return self.polygon.clean_pixels(camera, self.settings.min_px, max);
        }
        if self.polygon.edges().len() > max && self.polygon.simplify(max, scene.start.view) {
            self.counters.simplified_views += 1;
        }
        true
    }

    /// Clips a door given by its rays against a view of the landscape, for a look in. False when nothing is left.
    pub(crate) fn clip_start(&mut self, rays: &[Edge], view: &[Edge], camera: &Camera) -> bool {
        self.polygon.set(rays);
        if !(self.polygon.clip(view) && self.polygon.finish()) {
            return false;
        }
        let max = self.settings.max_edges;
        if self.settings.min_px > 0.0 {
            return self.polygon.clean_pixels(camera, self.settings.min_px, max);
        }
        self.polygon.simplify(max, view);
        true
    }

    /// What the last clip left.
    pub(crate) fn clipped(&self) -> &[Edge] {
        self.polygon.edges()
    }

    pub(crate) fn set_counters(&mut self, counters: FloodCounters) {
        self.counters = counters;
    }

    pub(crate) fn door_rays(&mut self) -> &mut Vec<Edge> {
        &mut self.door_rays
    }

    /// Whether the eye is on the plane of an opening and inside it (`visibility.md` 12.2).
    pub(super) fn eye_is_in_opening(&mut self, scene: &Scene<'_>, p: u32) -> bool {
        let state = self.portals[p as usize];
        let on_plane = state.dist.abs() <= EPSILON;
        if !on_plane || !self.settings.admit_on_plane {
            return false;
        }
        if state.flags & ON_PLANE_COUNTED == 0 {
            let portal = &scene.openings.portals[p as usize];
            let range = portal.first_piece..portal.first_piece + portal.piece_count;
            let inside = range.into_iter().any(|piece| {
                is_in_grown_polygon(scene.openings.piece_vertices(piece), scene.eye, ON_PLANE_MARGIN)
            });
            self.portals[p as usize].flags |= ON_PLANE_COUNTED | if inside { ON_PLANE_INSIDE } else { 0 };
            self.counters.on_plane += u32::from(inside);
        }
        self.portals[p as usize].flags & ON_PLANE_INSIDE != 0
    }

    /// Unit rays to the corners of a piece, counter-clockwise as seen from the eye; computed once per flood.
    /// Normals are still missing on first sight.
    pub(super) fn corner_rays(&mut self, scene: &Scene<'_>, p: u32, piece: u32) -> (usize, usize) {
        let state = self.pieces[piece as usize];
        if state.stamp == self.stamp {
            return (state.first as usize, usize::from(state.count));
        }
        let portal = &scene.openings.portals[p as usize];
        let dist = self.portals[p as usize].dist;
        let negative = if dist == 0.0 {
            portal.interior_is_negative
        } else {
            dist < 0.0
        };
        let first = self.rays.len();
        let ahead = scene
            .camera
            .filter(|_| !self.settings.admit_on_plane)
            .map(Camera::forward);
        let vertices = scene.openings.piece_vertices(piece);
        let count = push_rays(&mut self.rays, vertices, scene.eye, negative, ahead);
        self.pieces[piece as usize] = PieceState {
            stamp: self.stamp,
            first: first as u32,
            count: count as u16,
            has_normals: false,
        };
        (first, count)
    }
}

/// `visibility.md` 4.2: the eye is on the far side of the portal, which then only lets views in.
#[inline]
pub(super) fn is_in(dist: f32, interior_is_negative: bool) -> bool {
    if interior_is_negative {
        dist > EPSILON
    } else {
        dist < -EPSILON
    }
}

/// Appends the unit rays to some vertices, reversed when `negative`. A vertex at the eye has no ray. With `ahead`,
/// the direction of view, what lies less than epsilon ahead of the eye is cut off first, as in retail
/// (`visibility.md` 3.2c): only then does an opening the eye is on the plane of come out without area.
pub(crate) fn push_rays(
    rays: &mut Vec<Edge>,
    vertices: &[Vec3],
    eye: Vec3,
    negative: bool,
    ahead: Option<Vec3>,
) -> usize {
    let before = rays.len();
    let mut push = |v: Vec3| {
        let length = v.dot(v).sqrt();
        if length > 1.0e-12 {
            rays.push(Edge {
                corner: v / length,
                normal: Vec3::ZERO,
            });
        }
    };
    let n = vertices.len();
    let at = |k: usize| vertices[if negative { n - 1 - k } else { k }] - eye;
    for k in 0..n {
        let a = at(k);
        let Some(forward) = ahead else {
            push(a);
            continue;
        };
        let b = at(if k + 1 == n { 0 } else { k + 1 });
        let (da, db) = (forward.dot(a) - EPSILON, forward.dot(b) - EPSILON);
        if da >= 0.0 {
            push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            push(a + (b - a) * (da / (da - db)));
        }
    }
    rays.len() - before
}

/// Fills in the planes of the sides between rays.
pub(crate) fn fill_normals(rays: &mut [Edge]) {
    let n = rays.len();
    for k in 0..n {
        let next = rays[if k + 1 == n { 0 } else { k + 1 }].corner;
        rays[k].normal = edge_normal(rays[k].corner, next);
    }
}

fn side_normals(piece: &mut PieceState, rays: &mut [Edge]) {
    if !piece.has_normals {
        piece.has_normals = true;
        let first = piece.first as usize;
        fill_normals(&mut rays[first..first + usize::from(piece.count)]);
    }
}

/// Whether `p`, near the plane of a convex polygon, lies inside it grown by `margin` metres.
pub(crate) fn is_in_grown_polygon(vertices: &[Vec3], p: Vec3, margin: f32) -> bool {
    let Some(&first) = vertices.first() else {
        return false;
    };
    let mut normal = Vec3::ZERO;
    for pair in vertices.windows(2) {
        normal += (pair[0] - first).cross(pair[1] - first);
    }
    vertices.iter().enumerate().all(|(k, &a)| {
        let b = vertices[if k + 1 == vertices.len() { 0 } else { k + 1 }];
        let inward = normal.cross(b - a);
        let length = inward.length();
        length <= 0.0 || inward.dot(p - a) >= -margin * length
    })
}
