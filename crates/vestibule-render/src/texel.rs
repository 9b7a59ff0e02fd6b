//! Fast reading of textures: mip levels picked without logarithms, colours between texels in whole numbers.

use crate::texture::{Level, Texture};

impl Texture {
    /// The mip level for a pixel that covers so many texels of the largest level, squared.
    #[inline]
    pub(crate) fn level_for(&self, texels_squared: f32) -> usize {
        if !(texels_squared > 1.0) {
            return 0;
        }
        // Half the binary logarithm, rounded to the nearest level: that of the exponent is enough.
        let level = ((texels_squared * 2.0).to_bits() >> 23).saturating_sub(127) as usize / 2;
        level.min(self.levels().len() - 1)
    }

    /// A level; the smallest when there are not so many.
    #[inline]
    pub(crate) fn level(&self, level: usize) -> &Level {
        &self.levels()[level.min(self.levels().len() - 1)]
    }

    /// As [`Texture::sample`] from one level, in whole steps of a byte.
    #[inline]
    pub(crate) fn fetch(&self, level: usize, u: f32, v: f32, wrap: bool) -> [u8; 4] {
        self.level(level).fetch(u, v, wrap)
    }
}

/// A straight walk over a level, in 256ths of a texel.
pub(crate) struct TexelWalk<'t> {
    level: &'t Level,
    from: [i32; 2],
    by: [i32; 2],
    wrap: bool,
}

impl<'t> TexelWalk<'t> {
    /// From one pair of coordinates to another in `n` steps.
    #[inline]
    pub(crate) fn new(level: &'t Level, a: [f32; 2], b: [f32; 2], n: u32, wrap: bool) -> Self {
        let sides = [level.width, level.height];
        let mut walk = TexelWalk {
            level,
            from: [0; 2],
            by: [0; 2],
            wrap,
        };
        for k in 0..2 {
            // Whole repeats are left away, so that little numbers remain; casts saturate.
            let whole = if wrap { a[k] as i32 as f32 } else { 0.0 };
            let side = (sides[k] * 256) as f32;
            walk.from[k] = (((a[k] - whole) * side) as i32).saturating_sub(128);
            walk.by[k] = ((b[k] - a[k]) * side / n.max(1) as f32) as i32;
        }
        walk
    }

    /// The colour after `k` steps.
    #[inline]
    pub(crate) fn at(&self, k: u32) -> [u8; 4] {
        let level = self.level;
        let place = |axis: usize, n: u32| {
            let t = self.from[axis].wrapping_add(self.by[axis].wrapping_mul(k as i32));
            let (low, n) = (t >> 8, n as i32);
            let pair = if !self.wrap {
                [low.clamp(0, n - 1), (low + 1).clamp(0, n - 1)]
            } else if n & (n - 1) == 0 {
                [low & (n - 1), (low + 1) & (n - 1)]
            } else {
                [low.rem_euclid(n), (low + 1).rem_euclid(n)]
            };
            (pair.map(|i| i as usize), (t & 255) as u32)
        };
        let (x, fx) = place(0, level.width);
        let (y, fy) = place(1, level.height);
        level.between(x, y, fx, fy)
    }
}

/// Texels to each side of a coordinate, and how far it is between them in 256 steps.
#[inline]
fn axis(t: f32, n: u32, wrap: bool) -> (usize, usize, u32) {
    let t = if wrap {
        t
    } else if t > 1.0 {
        1.0
    } else if t > 0.0 {
        t
    } else {
        0.0
    };
    let x = t * n as f32 - 0.5;
    // The cast saturates and makes nought of what is no number.
    let cut = x as i32;
    let low = if cut as f32 > x { cut.wrapping_sub(1) } else { cut };
    let share = ((x - low as f32) * 256.0) as u32;
    let n = n as i32;
    let (a, b) = if !wrap {
        (low.clamp(0, n - 1), low.saturating_add(1).clamp(0, n - 1))
    } else if n & (n - 1) == 0 {
        (low & (n - 1), low.wrapping_add(1) & (n - 1))
    } else {
        (low.rem_euclid(n), low.wrapping_add(1).rem_euclid(n))
    };
    (a as usize, b as usize, if share < 256 { share } else { 256 })
}

impl Level {
    #[inline]
    fn fetch(&self, u: f32, v: f32, wrap: bool) -> [u8; 4] {
        let (x0, x1, fx) = axis(u, self.width, wrap);
        let (y0, y1, fy) = axis(v, self.height, wrap);
        self.between([x0, x1], [y0, y1], fx, fy)
    }

    /// The colour between four texels, `fx` and `fy` 256ths of the way.
    #[inline]
    fn between(&self, [x0, x1]: [usize; 2], [y0, y1]: [usize; 2], fx: u32, fy: u32) -> [u8; 4] {
        let w = self.width as usize;
        let (top, bottom) = (y0 * w, y1 * w);
        let at = |i: usize| u32::from_le_bytes(self.pixels.get(i).copied().unwrap_or_default());
        // Two channels at a time, 16 bits each.
        const PAIR: u32 = 0x00FF_00FF;
        let mix = |a: u32, b: u32, f: u32| ((a * (256 - f) + b * f + 0x0080_0080) >> 8) & PAIR;
        let (p, q, r, s) = (at(top + x0), at(top + x1), at(bottom + x0), at(bottom + x1));
        let even = mix(mix(p & PAIR, q & PAIR, fx), mix(r & PAIR, s & PAIR, fx), fy);
        let (p, q, r, s) = (p >> 8, q >> 8, r >> 8, s >> 8);
        let odd = mix(mix(p & PAIR, q & PAIR, fx), mix(r & PAIR, s & PAIR, fx), fy);
        (even | odd << 8).to_le_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fetching_stays_inside_whatever_the_coordinates() {
        let t = Texture::placeholder();
        for u in [f32::NAN, f32::INFINITY, -1e30, 1e30, 0.999_999_94, -0.0] {
            for wrap in [false, true] {
                t.fetch(t.level_for(u), u, u, wrap);
                t.fetch(usize::MAX, u, -u, wrap);
            }
        }
    }

    #[test]
    fn fetching_is_sampling_in_bytes() {
        let pixels = (0..48u8).map(|i| [i * 5, 255 - i * 5, i * 3, 100 + i]).collect();
        let t = Texture::new(8, 6, pixels, false);
        for k in 0..400 {
            let (u, v) = (k as f32 * 0.0173 - 3.0, 2.0 - k as f32 * 0.0091);
            for wrap in [false, true] {
                let (exact, fast) = (t.sample(u, v, 0.0, wrap), t.fetch(0, u, v, wrap));
                let close = exact
                    .iter()
                    .zip(fast)
                    .all(|(e, f)| (e - f32::from(f)).abs() < 3.0);
                assert!(close, "{u} {v} {wrap}: {exact:?} {fast:?}");
            }
        }
        for wrap in [false, true] {
            let (a, b) = ([-1.3f32, 0.4], [2.2f32, -0.9]);
            let walk = TexelWalk::new(t.level(0), a, b, 8, wrap);
            for k in 0..=8 {
                let at = |i: usize| a[i] + (b[i] - a[i]) * k as f32 / 8.0;
                let (exact, fast) = (t.sample(at(0), at(1), 0.0, wrap), walk.at(k));
                let close = exact
                    .iter()
                    .zip(fast)
                    .all(|(e, f)| (e - f32::from(f)).abs() < 8.0);
                assert!(close, "{k} {wrap}: {exact:?} {fast:?}");
            }
        }
        let odd = [f32::NAN, f32::INFINITY, -1e30, 1e30];
        for (a, b) in odd.iter().flat_map(|a| odd.map(|b| (*a, b))) {
            for wrap in [false, true] {
                TexelWalk::new(t.level(0), [a, b], [b, a], 8, wrap).at(8);
            }
        }
        let levels = [0.5f32, 1.0, 1.4, 1.5, 2.8, 2.9, 5.7].map(|texels| t.level_for(texels * texels));
        assert_eq!(levels, [0, 0, 0, 1, 1, 2, 3]);
    }
}
