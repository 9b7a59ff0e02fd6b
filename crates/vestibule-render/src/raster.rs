//! The buffers a picture is drawn into and the primitives that are drawn (`rendering.md` 9.3, 10).
//!
//! Depth is reversed: near plane distance by distance along the view axis, 1 nearest, 0 cleared, nearer or equal
//! wins.

pub(crate) mod scan;

use glam::DVec3;

use crate::material::{Blend, Factor};
use scan::{Affine, Facing, Projection, Setup};

/// Depth a punch writes: 100 km away, farther than anything real, nearer than cleared (`rendering.md` 9.3).
pub const PUNCH_DEPTH: f32 = 1.0e-6;

/// The id of a pixel: which cell's what was drawn there last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PixelId(pub u64);

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PixelKind {
    /// The colour it was cleared with: nothing was drawn.
    Background,
    /// Sky.
    Sky,
    /// Ground.
    Terrain,
    /// The shell of a building.
    Building,
    /// A room.
    Room,
    /// An object or body.
    Object,
}

impl PixelId {
    /// Nothing was drawn.
    pub const BACKGROUND: PixelId = PixelId(0);
    /// Sky.
    pub const SKY: PixelId = PixelId(u64::MAX);

    /// An id of its parts; `item` is cut to 28 bits.
    pub(crate) fn new(kind: PixelKind, cell: u32, item: u32) -> Self {
        let code = match kind {
            PixelKind::Background => return PixelId::BACKGROUND,
            PixelKind::Sky => return PixelId::SKY,
            PixelKind::Terrain => 1,
            PixelKind::Building => 2,
            PixelKind::Room => 3,
            PixelKind::Object => 4,
        };
        PixelId(u64::from(cell) << 32 | code << 28 | u64::from(item & 0x0FFF_FFFF))
    }

    /// What it is.
    pub fn kind(self) -> PixelKind {
        match (self, self.0 >> 28 & 15) {
            (PixelId::BACKGROUND, _) => PixelKind::Background,
            (PixelId::SKY, _) => PixelKind::Sky,
            (_, 1) => PixelKind::Terrain,
            (_, 2) => PixelKind::Building,
            (_, 3) => PixelKind::Room,
            _ => PixelKind::Object,
        }
    }

    /// The cell whose surface it is: the room, the land cell of ground and of a building's shell, the cell an object
    /// stands in. `None` for sky and background.
    pub fn cell(self) -> Option<vestibule_world::CellId> {
        (self != PixelId::BACKGROUND && self != PixelId::SKY)
            .then_some(vestibule_world::CellId((self.0 >> 32) as u32))
    }

    /// Which polygon or object of the cell: the polygon's key for rooms and buildings, the position of an object.
    pub fn item(self) -> u32 {
        (self.0 & 0x0FFF_FFFF) as u32
    }

    /// The colour of the id picture: the low 24 bits of the cell, white for sky, black for background.
    pub fn color(self) -> [u8; 4] {
        let v = match self {
            PixelId::BACKGROUND => 0,
            PixelId::SKY => 0xFF_FFFF,
            _ => (self.0 >> 32) as u32 & 0xFF_FFFF,
        };
        [(v >> 16) as u8, (v >> 8) as u8, v as u8, 255]
    }
}

/// Buffers of one picture.
#[derive(Clone, Debug)]
pub(crate) struct Buffers {
    pub(crate) screen: Projection,
    pub(crate) color: Vec<[u8; 4]>,
    pub(crate) depth: Vec<f32>,
    /// Nothing nearer than this is drawn; empty when there is no such limit.
    pub(crate) limit: Vec<f32>,
    /// Empty unless ids are wanted.
    pub(crate) ids: Vec<PixelId>,
    /// Which of the shades that are put aside a pixel waits for, 0 none; empty when ids are wanted.
    pub(crate) owners: Vec<u32>,
    /// The depth that seals wrote, 0 elsewhere; empty unless distances are wanted.
    seals: Vec<f32>,
    /// The depth of the landscape before it was cleared; empty unless distances are wanted.
    landscape: Vec<f32>,
}

impl Buffers {
    pub(crate) fn new(screen: Projection, with_ids: bool) -> Self {
        let n = screen.width as usize * screen.height as usize;
        Buffers {
            screen,
            color: vec![[0, 0, 0, 255]; if with_ids { 0 } else { n }],
            depth: vec![0.0; n],
            limit: Vec::new(),
            ids: vec![PixelId::BACKGROUND; if with_ids { n } else { 0 }],
            owners: vec![0; if with_ids { 0 } else { n }],
            seals: Vec::new(),
            landscape: Vec::new(),
        }
    }

    /// From here on the depth of what seals protect is kept.
    pub(crate) fn keep_landscape(&mut self) {
        self.seals = vec![0.0; self.depth.len()];
        self.landscape = vec![0.0; self.depth.len()];
    }

    /// Depth of what the pixels show, where seals lie that of the landscape behind them.
    pub(crate) fn shown_depth(&self) -> Vec<f32> {
        let behind = self.seals.iter().zip(&self.landscape);
        let all = self.depth.iter().zip(behind);
        all.map(|(&d, (&seal, &landscape))| if seal > 0.0 && seal == d { landscape } else { d })
            .collect()
    }

    pub(crate) fn clear_depth(&mut self) {
        if !self.landscape.is_empty() {
            self.landscape.copy_from_slice(&self.depth);
        }
        self.depth.fill(0.0);
    }

    #[inline]
    fn row(&self, y: u32) -> usize {
        y as usize * self.screen.width as usize
    }

    /// A triangle in one id: test nearer or equal, depth and id written.
    pub(crate) fn id_triangle(
        &mut self,
        p: [DVec3; 3],
        id: PixelId,
        confine: &[Affine],
        facing: Facing,
        growth: f64,
    ) {
        let Some(setup) = Setup::new(&self.screen, p, facing, growth) else {
            return;
        };
        claim(
            &setup,
            &self.screen,
            confine,
            (&mut self.depth, &mut self.ids, &self.limit),
            id,
        );
    }

    /// Opaque: pixels where the triangle is nearer or as near wait for this shade. Returns whether there are any.
    pub(crate) fn own(&mut self, setup: &Setup, owner: u32, confine: &[Affine]) -> bool {
        let buffers = (&mut self.depth, &mut self.owners, &self.limit);
        claim(setup, &self.screen, confine, buffers, owner)
    }

    /// From here on nothing nearer than `points`, a polygon, is drawn over it.
    pub(crate) fn limit_behind(&mut self, points: &[DVec3]) {
        if self.limit.is_empty() {
            // Where no polygon is: no limit, told by a number that no depth reaches.
            self.limit = vec![0.0; self.depth.len()];
        }
        let real = core::mem::take(&mut self.depth);
        self.depth = core::mem::take(&mut self.limit);
        self.depth_polygon_if(points, None, |old, new| new > old);
        self.limit = core::mem::replace(&mut self.depth, real);
    }

    /// Ends what [`Buffers::limit_behind`] began.
    pub(crate) fn no_limit(&mut self) {
        self.limit.clear();
    }

    /// Seals a polygon: its own depth, or a constant (`rendering.md` 7.6a).
    pub(crate) fn seal(&mut self, points: &[DVec3], constant: Option<f32>) {
        self.depth_polygon(points, constant);
        if !self.seals.is_empty() {
            core::mem::swap(&mut self.depth, &mut self.seals);
            self.depth_polygon(points, constant);
            core::mem::swap(&mut self.depth, &mut self.seals);
        }
    }

    /// Writes depth only, test always: a punch with a constant, a seal with its own depth (`rendering.md` 7).
    pub(crate) fn depth_polygon(&mut self, points: &[DVec3], constant: Option<f32>) {
        self.depth_polygon_if(points, constant, |_, _| true);
    }

    fn depth_polygon_if(
        &mut self,
        points: &[DVec3],
        constant: Option<f32>,
        wanted: impl Fn(f32, f32) -> bool,
    ) {
        let [a, rest @ ..] = points else { return };
        let near = self.screen.near;
        for pair in rest.windows(2) {
            let Some(setup) = Setup::new(&self.screen, [*a, pair[0], pair[1]], Facing::Both, 0.0) else {
                continue;
            };
            let setup = setup.up_to_the_eye();
            setup.spans(&[], |row| {
                let start = self.row(row.y);
                for x in row.first..row.end {
                    let own = (near * setup.inverse.at(x, row.y)) as f32;
                    let d = constant.unwrap_or(if own < 1.0 { own } else { 1.0 });
                    if let Some(slot) = self.depth.get_mut(start + x as usize).filter(|s| wanted(**s, d)) {
                        *slot = d;
                    }
                }
            });
        }
    }

    /// Draws a triangle whose pixels `shade` colours: it gets the column, the row and the forward distance and
    /// returns red, green, blue (0…255) and alpha (0…1), or nothing.
    #[inline]
    pub(crate) fn shaded(
        &mut self,
        setup: &Setup,
        how: PixelWrite,
        confine: &[Affine],
        mut shade: impl FnMut(u32, u32, f64) -> Option<([f32; 3], f32)>,
    ) {
        let near = self.screen.near;
        let width = self.screen.width as usize;
        let (depth, color, limit) = (&mut self.depth, &mut self.color, &self.limit);
        setup.spans(confine, |row| {
            let y = row.y;
            let start = y as usize * width;
            let range = start + row.first as usize..start + row.end as usize;
            let (Some(depths), Some(colors)) = (depth.get_mut(range.clone()), color.get_mut(range)) else {
                return;
            };
            for (x, (d, pixel)) in (row.first..row.end).zip(depths.iter_mut().zip(colors)) {
                let inverse = setup.inverse.at(x, y);
                let here = (near * row.depth_factor(x) * inverse) as f32;
                if how.test && (!(here >= *d) || here > limit_at(limit, start + x as usize)) {
                    continue;
                }
                let Some((c, alpha)) = shade(x, y, 1.0 / inverse) else {
                    continue;
                };
                if how.write {
                    *d = here;
                }
                *pixel = blended(*pixel, c, alpha, how.blend);
            }
        });
    }
}

/// The limit of a pixel; a little nearer than the polygon, whose own plane may be drawn.
#[inline]
fn limit_at(limit: &[f32], at: usize) -> f32 {
    match limit.get(at) {
        Some(&l) if l > 0.0 => l * (1.0 + 1.0e-4),
        _ => f32::INFINITY,
    }
}

/// How shaded pixels are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelWrite {
    /// Depth test; without it everything passes.
    pub(crate) test: bool,
    /// Depth write.
    pub(crate) write: bool,
    pub(crate) blend: Blend,
}

/// Writes depth and a value where a triangle is nearer or as near. Returns whether it was anywhere.
#[inline]
fn claim<T: Copy>(
    setup: &Setup,
    screen: &Projection,
    confine: &[Affine],
    (depth, values, limit): (&mut Vec<f32>, &mut Vec<T>, &Vec<f32>),
    value: T,
) -> bool {
    let (near, inverse, width) = (screen.near, setup.inverse, screen.width as usize);
    let mut any = false;
    setup.spans(confine, |row| {
        let start = row.y as usize * width;
        let base = inverse.b * f64::from(row.y) + inverse.c;
        let range = start + row.first as usize..start + row.end as usize;
        let (Some(depths), Some(values)) = (depth.get_mut(range.clone()), values.get_mut(range)) else {
            return;
        };
        for (x, (d, slot)) in (row.first..row.end).zip(depths.iter_mut().zip(values)) {
            let here = (near * row.depth_factor(x) * (inverse.a * f64::from(x) + base)) as f32;
            if here >= *d && !(here > limit_at(limit, start + x as usize)) {
                *d = here;
                *slot = value;
                any = true;
            }
        }
    });
    any
}

fn blended(old: [u8; 4], c: [f32; 3], alpha: f32, blend: Blend) -> [u8; 4] {
    let byte = |v: f32| {
        if v >= 255.0 {
            255
        } else if v > 0.0 {
            (v + 0.5) as u8
        } else {
            0
        }
    };
    if blend == Blend::OPAQUE {
        return [byte(c[0]), byte(c[1]), byte(c[2]), 255];
    }
    let factor = |f: Factor| match f {
        Factor::Zero => 0.0,
        Factor::One => 1.0,
        Factor::SrcAlpha => alpha,
        Factor::InvSrcAlpha => 1.0 - alpha,
    };
    let (s, d) = (factor(blend.src), factor(blend.dst));
    let mix = |k: usize| byte(c[k] * s + f32::from(old[k]) * d);
    [mix(0), mix(1), mix(2), 255]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn buffers() -> Buffers {
        Buffers::new(Projection::new(32, 32, DVec2::ONE, 0.1), true)
    }

    fn wall(distance: f64) -> [DVec3; 3] {
        let far = 5000.0;
        [
            DVec3::new(-far, distance, -far),
            DVec3::new(far, distance, -far),
            DVec3::new(0.0, distance, far),
        ]
    }

    #[test]
    fn r26_a_seal_keeps_what_is_nearer_and_rejects_what_is_farther() {
        let id = PixelId::new(PixelKind::Room, 5, 5);
        let mut d = 0.3;
        while d < 200.0 {
            let mut b = buffers();
            b.depth_polygon(&wall(d), None);
            b.id_triangle(wall(d + 0.02), id, &[], Facing::Front, 0.0);
            assert_eq!(b.ids[16 * 32 + 16], PixelId::BACKGROUND, "{d}");
            b.id_triangle(wall(d - 0.02), id, &[], Facing::Front, 0.0);
            assert_eq!(b.ids[16 * 32 + 16], id, "{d}");
            d *= 1.03;
        }
    }

    #[test]
    fn r26_a_punched_pixel_accepts_everything_real() {
        let mut b = buffers();
        let id = PixelId::new(PixelKind::Room, 5, 5);
        b.id_triangle(wall(10.0), id, &[], Facing::Front, 0.0);
        b.depth_polygon(&wall(1.0), Some(PUNCH_DEPTH));
        let far = PixelId::new(PixelKind::Terrain, 6, 6);
        b.id_triangle(wall(3000.0), far, &[], Facing::Front, 0.0);
        assert_eq!(b.ids[16 * 32 + 16], far);
    }

    #[test]
    fn r7_6a_a_seal_before_the_near_plane_is_nearest() {
        let mut b = buffers();
        let id = PixelId::new(PixelKind::Room, 5, 5);
        b.depth_polygon(&wall(0.02), None);
        b.id_triangle(wall(0.5), id, &[], Facing::Front, 0.0);
        assert_eq!(b.ids[16 * 32 + 16], PixelId::BACKGROUND);
    }

    #[test]
    fn ids_keep_their_parts() {
        let id = PixelId::new(PixelKind::Building, 0xA9B4_0017, 77);
        assert_eq!((id.kind(), id.item()), (PixelKind::Building, 77));
        assert_eq!(id.cell(), Some(vestibule_world::CellId(0xA9B4_0017)));
        assert_eq!(id.color(), [0xB4, 0x00, 0x17, 255]);
        assert_eq!(PixelId::SKY.color(), [255; 4]);
        assert_eq!(PixelId::BACKGROUND.color(), [0, 0, 0, 255]);
        assert_eq!((PixelId::SKY.kind(), PixelId::SKY.cell()), (PixelKind::Sky, None));
    }
}
