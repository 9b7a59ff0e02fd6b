//! Views: convex cones of sight through the eye, and clipping openings against them (`visibility.md` 3, 14).
//!
//! A view is a list of planes through the eye whose inner sides are the region that is seen. Nothing behind the
//! eye can be inside a view with edges, so neither a near plane nor homogeneous coordinates are needed.

use glam::{Vec2, Vec3};

use crate::camera::Camera;
use crate::constants::{CLIP_TOLERANCE, MIN_EDGE, MIN_VIEW_AREA, MIN_VIEW_WIDTH};

/// Corners a polygon may have while it is being clipped: a piece and a view together.
pub(crate) const CLIP_CAP: usize = 64;

/// One side of a view: a corner and the plane from it to the next corner.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Edge {
    /// Unit direction from the eye to the corner where the side begins.
    pub corner: Vec3,
    /// Unit normal of the plane through the eye and the side, pointing inside. Zero for a side too short to
    /// have a direction: it bounds nothing.
    pub normal: Vec3,
}

/// How a sphere lies to a view (`visibility.md` 11.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InView {
    /// No part of it is in the view.
    Outside,
    /// Some of it may be.
    Partial,
    /// All of it is.
    Inside,
}

/// A convex region of directions as seen from the eye. Its corners run counter-clockwise on the screen.
///
/// Without edges it is the whole sphere of directions (a viewer who looks everywhere at once).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region<'a> {
    edges: &'a [Edge],
}

impl<'a> Region<'a> {
    /// A region from its edges.
    pub fn new(edges: &'a [Edge]) -> Self {
        Region { edges }
    }

    /// Corners and planes, counter-clockwise on the screen.
    pub fn edges(&self) -> &'a [Edge] {
        self.edges
    }

    /// Whether an eye-relative direction lies inside, by at most `tolerance` radians outside.
    pub fn contains(&self, direction: Vec3, tolerance: f32) -> bool {
        let reach = -tolerance * direction.length();
        self.edges.iter().all(|e| e.normal.dot(direction) >= reach)
    }

    /// How a sphere with eye-relative centre lies to the region and to the plane `near` metres ahead of the eye
    /// (`visibility.md` 11.1). Conservative: it may keep a sphere beyond a corner.
    pub fn sphere(&self, center: Vec3, radius: f32, forward: Vec3, near: f32) -> InView {
        let mut answer = InView::Inside;
        let mut test = |dist: f32| {
            if dist < -radius {
                answer = InView::Outside;
            } else if dist <= radius && answer == InView::Inside {
                answer = InView::Partial;
            }
        };
        if !self.edges.is_empty() {
            test(forward.dot(center) - near);
        }
        for e in self.edges {
            test(e.normal.dot(center));
        }
        answer
    }

    /// Whether some of a sphere may be inside, as [`Region::sphere`] tells.
    #[inline]
    pub(crate) fn shows_sphere(&self, center: Vec3, radius: f32, forward: Vec3, near: f32) -> bool {
        (self.edges.is_empty() || !(forward.dot(center) - near < -radius))
            && self.edges.iter().all(|e| !(e.normal.dot(center) < -radius))
    }

    /// Whether some of a box may be inside: no plane has all corners outside. `low` and `high` are its corners with the
    /// smallest and the largest coordinates, relative to the eye.
    pub fn meets_box(&self, low: Vec3, high: Vec3, forward: Vec3, near: f32) -> InView {
        let mut answer = InView::Inside;
        let mut outside = |normal: Vec3, offset: f32| {
            if farthest(low, high, normal) < offset {
                return true;
            }
            if farthest(high, low, normal) < offset {
                answer = InView::Partial;
            }
            false
        };
        if !self.edges.is_empty() && outside(forward, near) {
            return InView::Outside;
        }
        for e in self.edges {
            // A zero normal puts nothing outside.
            if outside(e.normal, -crate::constants::EPSILON) {
                return InView::Outside;
            }
        }
        answer
    }

    /// Whether some of a box may be inside, as [`Region::meets_box`] tells.
    #[inline]
    pub(crate) fn shows_box(&self, low: Vec3, high: Vec3, forward: Vec3, near: f32) -> bool {
        (self.edges.is_empty() || !(farthest(low, high, forward) < near))
            && self
                .edges
                .iter()
                .all(|e| !(farthest(low, high, e.normal) < -crate::constants::EPSILON))
    }

    /// The region's corners in pixels of the camera's screen, y down. Corners that do not lie ahead are left out.
    pub fn pixels(&self, camera: &Camera) -> impl Iterator<Item = Vec2> + use<'a> {
        let camera = *camera;
        self.edges.iter().filter_map(move |e| camera.project(e.corner))
    }

    /// The region's bounding rectangle on the screen, smallest and largest pixel coordinates, cut to the
    /// viewport. The whole screen for a region without edges or one that reaches behind the eye.
    pub fn pixel_bounds(&self, camera: &Camera) -> (Vec2, Vec2) {
        let whole = (Vec2::ZERO, camera.viewport());
        let (mut min, mut max) = (camera.viewport(), Vec2::ZERO);
        for e in self.edges {
            let Some(p) = camera.project(e.corner) else {
                return whole;
            };
            min = Vec2::new(lower(min.x, p.x), lower(min.y, p.y));
            max = Vec2::new(upper(max.x, p.x), upper(max.y, p.y));
        }
        if self.edges.is_empty() {
            return whole;
        }
        let (size, zero) = (camera.viewport(), 0.0);
        let cut = |v: Vec2| Vec2::new(lower(upper(v.x, zero), size.x), lower(upper(v.y, zero), size.y));
        (cut(min), cut(max))
    }

    /// The region's area on the camera's screen, square pixels.
    pub fn pixel_area(&self, camera: &Camera) -> f32 {
        let points = || self.pixels(camera);
        let Some(first) = points().next() else { return 0.0 };
        let mut twice = 0.0;
        for (a, b) in points().zip(points().skip(1)) {
            twice += (a - first).perp_dot(b - first);
        }
        (twice * 0.5).abs()
    }

    /// A direction inside the region: the mean of its corners, not normalised. Forward for one without edges.
    pub fn middle(&self) -> Option<Vec3> {
        (!self.edges.is_empty()).then(|| self.edges.iter().map(|e| e.corner).sum())
    }
}

/// How far along a normal the corner of a box lies that lies farthest: rounding keeps it the farthest. With the corners
/// exchanged, the one opposite.
#[inline]
fn farthest(low: Vec3, high: Vec3, normal: Vec3) -> f32 {
    normal.dot(Vec3::select(normal.cmpgt(Vec3::ZERO), high, low))
}

pub(crate) fn lower(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

pub(crate) fn upper(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The edges of a rectangle of the screen in slopes (`x/forward`, `z/forward`), lowest and highest.
pub(crate) fn rectangle(camera: &Camera, low: Vec2, high: Vec2) -> [Edge; 4] {
    let corner = |x, z| {
        let v = camera.from_camera(Vec3::new(x, 1.0, z));
        v / v.length()
    };
    let corners = [
        corner(low.x, low.y),
        corner(high.x, low.y),
        corner(high.x, high.y),
        corner(low.x, high.y),
    ];
    core::array::from_fn(|k| Edge {
        corner: corners[k],
        normal: edge_normal(corners[k], corners[(k + 1) % 4]),
    })
}

/// The whole screen: bottom left, bottom right, top right, top left (`visibility.md` 3.1).
pub(crate) fn full_view(camera: &Camera) -> [Edge; 4] {
    rectangle(camera, -camera.slopes(), camera.slopes())
}

/// The inward normal of the side from unit ray `a` to unit ray `b` of a polygon that runs counter-clockwise as
/// seen from the eye. Zero when the rays span no plane (`visibility.md` 14.4).
#[inline]
pub(crate) fn edge_normal(a: Vec3, b: Vec3) -> Vec3 {
    let n = b.cross(a);
    let length = n.dot(n).sqrt();
    if length < MIN_EDGE { Vec3::ZERO } else { n / length }
}

/// A polygon on the sphere of directions being clipped. Each side keeps the plane it came from, an opening's or
/// an earlier view's, so planes never drift with the number of clips.
#[derive(Clone, Debug)]
pub(crate) struct ClipPolygon {
    edges: [Edge; CLIP_CAP],
    len: usize,
    spare: [Edge; CLIP_CAP],
}

impl Default for ClipPolygon {
    fn default() -> Self {
        ClipPolygon {
            edges: [Edge::default(); CLIP_CAP],
            len: 0,
            spare: [Edge::default(); CLIP_CAP],
        }
    }
}

impl ClipPolygon {
    pub(crate) fn edges(&self) -> &[Edge] {
        &self.edges[..self.len]
    }

    /// Starts from the sides of an opening.
    pub(crate) fn set(&mut self, edges: &[Edge]) {
        let len = edges.len().min(CLIP_CAP);
        self.edges[..len].copy_from_slice(&edges[..len]);
        self.len = len;
    }

    /// Cuts the polygon to the inner sides of a view (`visibility.md` 14.3: closed half spaces, kept when in
    /// doubt). False when less than a triangle is left.
    pub(crate) fn clip(&mut self, view: &[Edge]) -> bool {
        for side in view {
            if !self.clip_plane(side.normal) {
                return false;
            }
        }
        self.len >= 3
    }

    fn clip_plane(&mut self, normal: Vec3) -> bool {
        let mut dist = [0.0f32; CLIP_CAP];
        let mut kept = 0usize;
        for (d, e) in dist.iter_mut().zip(&self.edges[..self.len]) {
            *d = normal.dot(e.corner);
            kept += usize::from(*d >= -CLIP_TOLERANCE);
        }
        if kept == self.len {
            return true;
        }
        if kept == 0 {
            self.len = 0;
            return false;
        }
        let mut out = 0;
        let mut push = |spare: &mut [Edge; CLIP_CAP], e: Edge| {
            // A convex polygon gains at most one corner; a broken one is cut short instead of overflowing.
            if out < CLIP_CAP {
                spare[out] = e;
                out += 1;
            }
        };
        for k in 0..self.len {
            let next = if k + 1 == self.len { 0 } else { k + 1 };
            let (a, b) = (self.edges[k], self.edges[next]);
            let (da, db) = (dist[k], dist[next]);
            let (a_in, b_in) = (da >= -CLIP_TOLERANCE, db >= -CLIP_TOLERANCE);
            match (a_in, b_in) {
                (true, true) => push(&mut self.spare, a),
                (true, false) if da <= 0.0 => push(
                    &mut self.spare,
                    Edge {
                        corner: a.corner,
                        normal,
                    },
                ),
                (true, false) => {
                    push(&mut self.spare, a);
                    push(
                        &mut self.spare,
                        Edge {
                            corner: crossing(a.corner, b.corner, da, db),
                            normal,
                        },
                    );
                }
                // A corner on the plane begins the next side itself.
                (false, true) if db <= 0.0 => {}
                (false, true) => {
                    let corner = crossing(a.corner, b.corner, da, db);
                    push(
                        &mut self.spare,
                        Edge {
                            corner,
                            normal: a.normal,
                        },
                    );
                }
                (false, false) => {}
            }
        }
        self.edges[..out].copy_from_slice(&self.spare[..out]);
        self.len = out;
        out >= 3
    }

    /// Drops corners that coincide, then tells whether anything with an area is left (`visibility.md` 14.6).
    pub(crate) fn finish(&mut self) -> bool {
        let mut out = 0;
        for k in 0..self.len {
            let next = if k + 1 == self.len { 0 } else { k + 1 };
            let gap = self.edges[next].corner - self.edges[k].corner;
            if gap.dot(gap) > MIN_EDGE * MIN_EDGE {
                self.edges[out] = self.edges[k];
                out += 1;
            }
        }
        self.len = out;
        out >= 3 && has_area(self.edges())
    }

    /// Simplifies outward until at most `max` sides are left: drops the side whose removal adds the least, by
    /// extending its neighbours until they meet (`visibility.md` 14.5). `full` bounds what may be added; a
    /// polygon that cannot be simplified inside it is cut at `full` instead. Returns whether it did anything.
    pub(crate) fn simplify(&mut self, max: usize, full: &[Edge]) -> bool {
        let before = self.len;
        while self.len > max {
            let mut best: Option<(f32, usize, Vec3)> = None;
            for k in 0..self.len {
                let prev = if k == 0 { self.len - 1 } else { k - 1 };
                let next = if k + 1 == self.len { 0 } else { k + 1 };
                let (a, b) = (self.edges[k].corner, self.edges[next].corner);
                let apex = self.edges[prev].normal.cross(self.edges[next].normal);
                let length = apex.dot(apex).sqrt();
                if length < MIN_EDGE {
                    continue;
                }
                let apex = if apex.dot(a + b) < 0.0 {
                    -apex / length
                } else {
                    apex / length
                };
                // The neighbours must meet beyond the side, not behind it, and inside the screen.
                if self.edges[k].normal.dot(apex) > CLIP_TOLERANCE
                    || full.iter().any(|f| f.normal.dot(apex) < -CLIP_TOLERANCE)
                {
                    continue;
                }
                let area = (b - a).cross(apex - a);
                let area = area.dot(area).sqrt();
                if best.is_none_or(|(least, ..)| area < least) {
                    best = Some((area, k, apex));
                }
            }
            let Some((_, k, apex)) = best else { break };
            let next = if k + 1 == self.len { 0 } else { k + 1 };
            self.edges[next].corner = apex;
            self.edges.copy_within(k + 1..self.len, k);
            self.len -= 1;
        }
        if self.len > max {
            // Nothing fits: the whole screen is a superset of it.
            self.set(full);
        }
        self.len != before
    }

    /// Retail's clean-up of a clipped polygon in pixels (`visibility.md` 3.3 a-c): corners nearer than `min_px` in
    /// both axes are one, corners less than about a pixel off the chord go, the surplus above `max` is cut off.
    /// False when less than a triangle is left.
    pub(crate) fn clean_pixels(&mut self, camera: &Camera, min_px: f32, max: usize) -> bool {
        let mut points = [Vec2::ZERO; CLIP_CAP];
        let mut kept = [0usize; CLIP_CAP];
        let mut len = 0;
        // Whether the middle of three points lies off the chord of its neighbours.
        let off_chord = |a: Vec2, m: Vec2, b: Vec2| {
            let chord = (b - a).abs();
            (m - a).perp_dot(b - m).abs() >= upper(chord.x, chord.y) * min_px
        };
        for k in 0..self.len {
            let Some(p) = camera.project(self.edges[k].corner) else {
                continue;
            };
            if len > 0 {
                let gap = (p - points[len - 1]).abs();
                if !(gap.x > min_px || gap.y > min_px) {
                    continue;
                }
            }
            if len >= 2 && !off_chord(points[len - 2], points[len - 1], p) {
                len -= 1;
            }
            points[len] = p;
            kept[len] = k;
            len += 1;
        }
        while len >= 3 {
            let gap = (points[0] - points[len - 1]).abs();
            let same = !(gap.x > min_px || gap.y > min_px);
            if same || !off_chord(points[len - 2], points[len - 1], points[0]) {
                len -= 1;
            } else if !off_chord(points[len - 1], points[0], points[1]) {
                points.copy_within(1..len, 0);
                kept.copy_within(1..len, 0);
                len -= 1;
            } else {
                break;
            }
        }
        let len = len.min(max);
        if len < 3 {
            return false;
        }
        for (spare, &from) in self.spare.iter_mut().zip(&kept[..len]) {
            spare.corner = self.edges[from].corner;
        }
        for i in 0..len {
            let next = if i + 1 == len { 0 } else { i + 1 };
            self.spare[i].normal = edge_normal(self.spare[i].corner, self.spare[next].corner);
        }
        self.edges[..len].copy_from_slice(&self.spare[..len]);
        self.len = len;
        true
    }
}

/// Where the great circle arc from `a` to `b` meets the plane that they are `da` and `db` away from, unit. The
/// same whichever way the arc is run.
#[inline]
fn crossing(a: Vec3, b: Vec3, da: f32, db: f32) -> Vec3 {
    let p = if da.abs() <= db.abs() {
        a + (b - a) * (da / (da - db))
    } else {
        b + (a - b) * (db / (db - da))
    };
    let length = p.dot(p).sqrt();
    if length > 1.0e-12 { p / length } else { a }
}

/// `visibility.md` 14.6: neither without area nor without width.
fn has_area(edges: &[Edge]) -> bool {
    let Some(first) = edges.first().map(|e| e.corner) else {
        return false;
    };
    let mut sum = Vec3::ZERO;
    let mut chord = 0.0f32;
    for (k, pair) in edges.windows(2).enumerate() {
        let (a, b) = (pair[0].corner - first, pair[1].corner - first);
        sum += a.cross(b);
        for e in &edges[..=k] {
            let gap = pair[1].corner - e.corner;
            chord = upper(chord, gap.dot(gap));
        }
    }
    let area = 0.5 * sum.dot(sum).sqrt();
    area >= MIN_VIEW_AREA && area >= MIN_VIEW_WIDTH * chord.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vestibule_world::CellId;

    fn camera() -> Camera {
        let fov = core::f32::consts::FRAC_PI_2;
        Camera::new(
            CellId(0x100),
            Vec3::ZERO,
            Vec3::Y,
            Vec3::Z,
            fov,
            Vec2::splat(512.0),
        )
        .unwrap()
    }

    fn polygon(points: &[(f32, f32)]) -> ClipPolygon {
        let rays: Vec<Vec3> = points
            .iter()
            .map(|&(x, z)| Vec3::new(x, 1.0, z).normalize())
            .collect();
        let edges: Vec<Edge> = (0..rays.len())
            .map(|k| Edge {
                corner: rays[k],
                normal: edge_normal(rays[k], rays[(k + 1) % rays.len()]),
            })
            .collect();
        let mut out = ClipPolygon::default();
        out.set(&edges);
        out
    }

    #[test]
    fn s3_1_the_full_view_is_the_viewport_counter_clockwise() {
        let camera = camera();
        let edges = full_view(&camera);
        let pixels: Vec<Vec2> = Region::new(&edges).pixels(&camera).collect();
        for (p, (x, y)) in pixels
            .iter()
            .zip([(0.0, 512.0), (512.0, 512.0), (512.0, 0.0), (0.0, 0.0)])
        {
            assert!((*p - Vec2::new(x, y)).length() < 1e-3, "{p}");
        }
        assert!(Region::new(&edges).contains(Vec3::Y, 0.0));
        assert!(!Region::new(&edges).contains(-Vec3::Y, 0.0));
        assert!((Region::new(&edges).pixel_area(&camera) - 262_144.0).abs() < 1.0);
    }

    #[test]
    fn s14_3_clipping_keeps_what_is_inside_and_its_planes() {
        let camera = camera();
        let mut p = polygon(&[(-3.0, -0.5), (0.5, -0.5), (0.5, 0.5), (-3.0, 0.5)]);
        assert!(p.clip(&full_view(&camera)) && p.finish());
        assert_eq!(p.edges().len(), 4);
        let area = Region::new(p.edges()).pixel_area(&camera);
        assert!((area - 384.0 * 256.0).abs() < 1.0, "{area}");
        let mut behind = polygon(&[(2.0, -0.5), (3.0, -0.5), (3.0, 0.5)]);
        assert!(!behind.clip(&full_view(&camera)));
    }

    #[test]
    fn s14_6_slivers_without_width_are_rejected() {
        let mut thin = polygon(&[(-0.5, 0.0), (0.5, 0.0), (0.5, 2.0e-7)]);
        assert!(!thin.finish());
        let mut narrow = polygon(&[(-0.5, 0.0), (0.5, 0.0), (0.5, 2.0e-4)]);
        assert!(narrow.finish());
    }

    #[test]
    fn s14_5_simplifying_only_adds() {
        let ring: Vec<(f32, f32)> = (0..20)
            .map(|k| {
                let a = k as f32 * core::f32::consts::TAU / 20.0;
                (0.4 * libm::cosf(a), 0.4 * libm::sinf(a))
            })
            .collect();
        let camera = camera();
        let original = polygon(&ring);
        let mut simple = original.clone();
        assert!(simple.simplify(12, &full_view(&camera)));
        assert_eq!(simple.edges().len(), 12);
        let region = Region::new(simple.edges());
        for e in original.edges() {
            assert!(region.contains(e.corner, 1e-6));
        }
        let grown = region.pixel_area(&camera) / Region::new(original.edges()).pixel_area(&camera);
        assert!(grown < 1.06, "{grown}");
    }

    #[test]
    fn s11_1_sphere_against_a_view() {
        let camera = camera();
        let full = full_view(&camera);
        let region = Region::new(&full);
        let test = |c: Vec3, r: f32| region.sphere(c, r, Vec3::Y, 0.1);
        assert_eq!(test(Vec3::new(0.0, 10.0, 0.0), 1.0), InView::Inside);
        assert_eq!(test(Vec3::new(10.0, 10.0, 0.0), 1.0), InView::Partial);
        assert_eq!(test(Vec3::new(12.0, 10.0, 0.0), 1.0), InView::Outside);
        assert_eq!(test(Vec3::new(0.0, -1.0, 0.0), 0.5), InView::Outside);
        assert_eq!(test(Vec3::ZERO, 0.5), InView::Partial);
    }
}
