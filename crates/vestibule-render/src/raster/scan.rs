//! Which pixels a triangle covers and how far away it is there (`rendering.md` 10.1).
//!
//! A triangle is not projected: its edges are planes through the eye, and each pixel's ray is tested against them.
//! So nothing has to be clipped at the near plane, corners behind the eye do no harm, and two triangles that share
//! an edge agree on it. Everything is set up in f64.

use glam::{DVec2, DVec3};

/// Walls of the viewer's own rooms also cover pixels whose centre is this near to them, pixels: rooms whose walls meet
/// without sharing corners, or in f32 of different frames, still close (`rendering.md` 7.5 needs watertight
/// interiors).
pub(crate) const GROWTH: f64 = 1.0 / 256.0;
/// A pixel that is only covered by growth counts as this many times farther away, so that whatever really covers it
/// wins and only cracks are filled.
const GROWN_DEPTH: f64 = 1.0 / 64.0;

/// From camera axes (x right, y forward, z up) to pixels (`rendering.md` 2.6).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    pub(crate) width: u32,
    pub(crate) height: u32,
    slopes: DVec2,
    pub(crate) near: f64,
}

/// A value that is linear on the screen: `a x + b y + c` at the centre of pixel (x, y).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Affine {
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
}

impl Affine {
    #[inline]
    pub(crate) fn at(&self, x: u32, y: u32) -> f64 {
        self.a * f64::from(x) + (self.b * f64::from(y) + self.c)
    }

    #[inline]
    pub(crate) fn scaled(&self, s: f64) -> Affine {
        Affine {
            a: self.a * s,
            b: self.b * s,
            c: self.c * s,
        }
    }

    #[inline]
    pub(crate) fn plus(&self, o: &Affine) -> Affine {
        Affine {
            a: self.a + o.a,
            b: self.b + o.b,
            c: self.c + o.c,
        }
    }

    /// How much the value changes over this many pixels, across and down together.
    #[inline]
    fn across(&self, pixels: f64) -> f64 {
        pixels * (self.a.abs() + self.b.abs())
    }

    /// Moved outward by a part of a pixel.
    #[inline]
    pub(crate) fn grown(&self, pixels: f64) -> Affine {
        Affine {
            c: self.c + self.across(pixels),
            ..*self
        }
    }
}

impl Projection {
    pub(crate) fn new(width: u32, height: u32, slopes: DVec2, near: f64) -> Self {
        Projection {
            width,
            height,
            slopes,
            near,
        }
    }

    /// `n · ray` for the ray through each pixel's centre, whose forward component is 1.
    #[inline]
    pub(crate) fn dot_ray(&self, n: DVec3) -> Affine {
        let (w, h) = (f64::from(self.width), f64::from(self.height));
        Affine {
            a: n.x * 2.0 * self.slopes.x / w,
            b: -n.z * 2.0 * self.slopes.y / h,
            c: n.y + n.x * self.slopes.x * (1.0 / w - 1.0) + n.z * self.slopes.y * (1.0 - 1.0 / h),
        }
    }

    /// The ray through a pixel's centre, camera axes, forward component 1.
    #[inline]
    pub(crate) fn ray(&self, x: u32, y: u32) -> DVec3 {
        let (w, h) = (f64::from(self.width), f64::from(self.height));
        DVec3::new(
            ((2.0 * f64::from(x) + 1.0) / w - 1.0) * self.slopes.x,
            1.0,
            (1.0 - (2.0 * f64::from(y) + 1.0) / h) * self.slopes.y,
        )
    }

    /// The pixels a set of points may cover: columns and rows from (inclusive) and to (exclusive). The whole screen
    /// when a point is not well ahead of the eye; `None` when all lie beyond one side of the screen or behind.
    #[inline]
    fn bounds(&self, points: &[DVec3]) -> Option<[u32; 4]> {
        let all = |f: &dyn Fn(&DVec3) -> bool| points.iter().all(f);
        let s = self.slopes;
        // A pixel's width of margin for the growth of edges.
        let m = 1.01;
        if all(&|p| p.y <= 0.0)
            || all(&|p| p.x > m * s.x * p.y)
            || all(&|p| -p.x > m * s.x * p.y)
            || all(&|p| p.z > m * s.y * p.y)
            || all(&|p| -p.z > m * s.y * p.y)
        {
            return None;
        }
        if points.iter().any(|p| p.y < 1.0e-3) {
            return Some([0, self.width, 0, self.height]);
        }
        let (w, h) = (f64::from(self.width), f64::from(self.height));
        let (mut x0, mut x1, mut y0, mut y1) = (w, 0.0f64, h, 0.0f64);
        for p in points {
            let x = (1.0 + p.x / (p.y * s.x)) * 0.5 * w;
            let y = (1.0 - p.z / (p.y * s.y)) * 0.5 * h;
            x0 = x0.min(x);
            x1 = x1.max(x);
            y0 = y0.min(y);
            y1 = y1.max(y);
        }
        let cut = |v: f64, n: u32| v.clamp(0.0, f64::from(n)) as u32;
        let out = [
            cut(x0 - 1.0, self.width),
            cut(x1 + 2.0, self.width),
            cut(y0 - 1.0, self.height),
            cut(y1 + 2.0, self.height),
        ];
        (out[0] < out[1] && out[2] < out[3]).then_some(out)
    }
}

/// A triangle set up for drawing.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    /// 1 / forward distance.
    pub(crate) inverse: Affine,
    /// The weights of the corners, divided by the forward distance.
    pub(crate) weights: [Affine; 3],
    planes: [Affine; 5],
    /// How far out the first three planes may be overstepped.
    margins: [f64; 3],
    bounds: [u32; 4],
}

/// A run of covered pixels of one row, from (inclusive) and to (exclusive).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) y: u32,
    pub(crate) first: u32,
    pub(crate) end: u32,
    /// The part that is covered without growth.
    pub(crate) inner: (u32, u32),
}

impl Span {
    /// What the depth of a column is multiplied with.
    #[inline]
    pub(crate) fn depth_factor(&self, x: u32) -> f64 {
        if x >= self.inner.0 && x < self.inner.1 {
            1.0
        } else {
            GROWN_DEPTH
        }
    }
}

/// Which sides of a triangle show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Facing {
    Front,
    Both,
}

impl Setup {
    /// Sets up a triangle in camera axes, eye at the origin. `None` when it faces away, has no area or cannot be on
    /// the screen.
    #[inline]
    pub(crate) fn new(screen: &Projection, p: [DVec3; 3], facing: Facing, growth: f64) -> Option<Setup> {
        let bounds = screen.bounds(&p)?;
        let normals = [p[1].cross(p[2]), p[2].cross(p[0]), p[0].cross(p[1])];
        let det = p[0].dot(normals[0]);
        // Counter-clockwise towards the eye: the determinant is negative (`rendering.md` 2.7).
        if !(det != 0.0 && det.is_finite()) || facing == Facing::Front && det > 0.0 {
            return None;
        }
        let weights = normals.map(|n| screen.dot_ray(n).scaled(1.0 / det));
        let inverse = weights[0].plus(&weights[1]).plus(&weights[2]);
        if !(inverse.c.is_finite() && inverse.a.is_finite() && inverse.b.is_finite()) {
            return None;
        }
        let near = Affine {
            a: -inverse.a,
            b: -inverse.b,
            c: 1.0 / screen.near - inverse.c,
        };
        let ahead = Affine {
            c: inverse.c - 1.0e-9,
            ..inverse
        };
        Some(Setup {
            inverse,
            weights,
            planes: [weights[0], weights[1], weights[2], near, ahead],
            margins: [0, 1, 2].map(|k| weights[k].across(growth)),
            bounds,
        })
    }

    /// The same without the cut at the near plane, for seals (`rendering.md` 7.6a).
    pub(crate) fn up_to_the_eye(mut self) -> Self {
        self.planes[3] = Affine {
            c: 1.0,
            ..Affine::default()
        };
        self
    }

    /// A value given at the corners, divided by the forward distance.
    #[inline]
    pub(crate) fn attribute(&self, values: [f32; 3]) -> Affine {
        let [a, b, c] = [0, 1, 2].map(|k| self.weights[k].scaled(f64::from(values[k])));
        a.plus(&b).plus(&c)
    }

    /// Calls `row` for each run of covered pixels, inside `confine` as well.
    #[inline]
    pub(crate) fn spans(&self, confine: &[Affine], mut row: impl FnMut(Span)) {
        let [x0, x1, y0, y1] = self.bounds;
        for y in y0..y1 {
            let mut range = Range {
                low: f64::from(x0),
                high: f64::from(x1) - 1.0,
            };
            for p in self.planes[3..].iter().chain(confine) {
                range.cut(p, y, 0.0);
            }
            let mut inner = range;
            for (p, margin) in self.planes.iter().zip(self.margins) {
                range.cut(p, y, margin);
                inner.cut(p, y, 0.0);
            }
            let (first, end) = range.columns();
            if first < end {
                let inner = inner.columns();
                row(Span { y, first, end, inner });
            }
        }
    }
}

/// A piece of a row, on the axis of pixel centres.
#[derive(Clone, Copy, Debug)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// Keeps where `p` is not below minus `margin`.
    #[inline]
    fn cut(&mut self, p: &Affine, y: u32, margin: f64) {
        let rest = p.b * f64::from(y) + p.c + margin;
        if p.a > 0.0 {
            let x = -rest / p.a;
            if x > self.low {
                self.low = x;
            }
        } else if p.a < 0.0 {
            let x = -rest / p.a;
            if x < self.high {
                self.high = x;
            }
        } else if rest < 0.0 {
            self.high = -1.0;
        }
    }

    /// The pixels whose centre is inside, from (inclusive) and to (exclusive).
    #[inline]
    fn columns(&self) -> (u32, u32) {
        if !(self.low <= self.high) {
            return (0, 0);
        }
        // Both lie on the screen: no cast can overflow.
        let mut first = self.low as u32;
        if f64::from(first) < self.low {
            first += 1;
        }
        (first, self.high as u32 + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn screen() -> Projection {
        Projection::new(64, 48, DVec2::new(1.0, 0.75), 0.1)
    }

    fn count(p: [DVec3; 3], growth: f64) -> u32 {
        let mut n = 0;
        if let Some(s) = Setup::new(&screen(), p, Facing::Both, growth) {
            s.spans(&[], |r| n += r.end - r.first);
        }
        n
    }

    #[test]
    fn a_wall_that_passes_the_eye_covers_what_its_rays_hit() {
        // The plane x = 1 from behind the eye to far ahead, from far below to far above: the right half's part
        // where the ray hits it ahead.
        let far = 1000.0;
        let p = |y: f64, z: f64| DVec3::new(0.5, y, z);
        let quad = [p(-far, -far), p(far, -far), p(far, far), p(-far, far)];
        let n = count([quad[0], quad[1], quad[2]], 0.0) + count([quad[0], quad[2], quad[3]], 0.0);
        // All pixels right of the middle, but for the column that meets it beyond its far end.
        assert_eq!(n, 32 * 48);
    }

    #[test]
    fn triangles_behind_the_eye_cover_nothing() {
        let p = [
            DVec3::new(-1.0, -2.0, -1.0),
            DVec3::new(1.0, -2.0, -1.0),
            DVec3::new(0.0, -2.0, 1.0),
        ];
        assert_eq!(count(p, 0.0), 0);
    }

    #[test]
    fn r2_7_counter_clockwise_faces_the_eye() {
        let ccw = [
            DVec3::new(-1.0, 2.0, -1.0),
            DVec3::new(1.0, 2.0, -1.0),
            DVec3::new(0.0, 2.0, 1.0),
        ];
        let cw = [ccw[1], ccw[0], ccw[2]];
        assert!(Setup::new(&screen(), ccw, Facing::Front, 0.0).is_some());
        assert!(Setup::new(&screen(), cw, Facing::Front, 0.0).is_none());
        assert!(Setup::new(&screen(), cw, Facing::Both, 0.0).is_some());
    }

    #[test]
    fn the_inverse_distance_is_that_of_the_plane() {
        let p = [
            DVec3::new(-9.0, 4.0, -9.0),
            DVec3::new(9.0, 4.0, -9.0),
            DVec3::new(0.0, 4.0, 30.0),
        ];
        let s = Setup::new(&screen(), p, Facing::Front, 0.0).unwrap();
        for (x, y) in [(0, 0), (31, 20), (63, 47)] {
            assert!((s.inverse.at(x, y) - 0.25).abs() < 1e-12);
        }
    }

    #[test]
    fn shared_edges_leave_no_hole() {
        // A fan around a point, corners all over the place.
        let rim: Vec<DVec3> = (0..17)
            .map(|k| {
                let (s, c) = libm::sincos(f64::from(k) * std::f64::consts::TAU / 17.0);
                DVec3::new(c * 7.0, 3.0 + s * 0.7, s * 7.0)
            })
            .collect();
        let middle = DVec3::new(0.013, 3.1, -0.027);
        let mut covered = vec![0u8; 64 * 48];
        for k in 0..17 {
            let tri = [middle, rim[k], rim[(k + 1) % 17]];
            if let Some(s) = Setup::new(&screen(), tri, Facing::Both, GROWTH) {
                s.spans(&[], |r| {
                    for x in r.first..r.end {
                        covered[(r.y * 64 + x) as usize] = 1;
                    }
                });
            }
        }
        assert!(covered.iter().all(|&c| c == 1));
    }
}
