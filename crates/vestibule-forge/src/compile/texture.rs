//! Textures drawn by formula. They tile in both directions.

use glam::DVec2;

use super::noise::{Tables, hash01, value_noise};
use crate::scene::Pattern;

/// Width and height of textures, pixels.
pub(crate) const SIDE: usize = 64;

/// Several octaves of noise over the unit square, from -1 to 1.
fn grain(t: &Tables, (u, v): (f64, f64), cells: u32, octaves: u32, seed: u32) -> f64 {
    let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let period = cells << octave;
        let side = f64::from(period);
        sum += weight * t.noise(u * side, v * side, period, seed.wrapping_add(octave));
        total += weight;
        weight *= 0.55;
    }
    sum / total
}

/// Rows of stones: shade of the one at (u, v), and how far from its joint (0 on it, 1 well inside).
fn courses(u: f64, v: f64, across: u32, rows: u32, seed: u32) -> (f64, f64) {
    let row = (v * f64::from(rows)).floor();
    let shift = if row as u32 % 2 == 1 { 0.5 } else { 0.0 };
    let x = u * f64::from(across) + shift;
    let column = x.floor() as u32 % across;
    let (fx, fy) = (x - x.floor(), v * f64::from(rows) - row);
    let edge = |t: f64| t.min(1.0 - t);
    let to_joint = (edge(fx) / f64::from(across)).min(edge(fy) / f64::from(rows));
    (
        hash01(column + 131 * row as u32, seed),
        (to_joint * 64.0 - 0.5).clamp(0.0, 1.0),
    )
}

/// What to mix of the two colours, and how bright the mixture is.
fn shade(t: &Tables, pattern: Pattern, (u, v): (f64, f64), seed: u32) -> (f64, f64) {
    let grain = |cells, octaves, seed| grain(t, (u, v), cells, octaves, seed);
    let fine = match pattern {
        Pattern::Plain | Pattern::Glow | Pattern::Bark | Pattern::Water => 0.0,
        _ => grain(16, 2, seed),
    };
    match pattern {
        Pattern::Plain => (0.0, 1.0),
        Pattern::Glow => (0.0, 1.05 + 0.15 * grain(4, 2, seed)),
        Pattern::Grain => (0.3 + 0.3 * grain(6, 3, seed), 1.0 + 0.08 * fine),
        Pattern::Grass => {
            let blades = t.noise(u * 24.0, v * 24.0, 12, seed);
            (0.35 + 0.45 * grain(5, 3, seed), 1.0 + 0.16 * blades + 0.1 * fine)
        }
        Pattern::Soil => (0.4 + 0.5 * grain(6, 3, seed), 1.0 + 0.18 * fine),
        Pattern::Rock => {
            let strata = grain(3, 4, seed);
            (0.4 + 0.6 * strata.abs(), 0.95 + 0.3 * strata + 0.1 * fine)
        }
        Pattern::Bricks | Pattern::Blocks | Pattern::Cobbles => {
            let (across, rows) = match pattern {
                Pattern::Bricks => (4, 8),
                Pattern::Blocks => (2, 4),
                _ => (6, 6),
            };
            let warp = if pattern == Pattern::Cobbles { 0.02 } else { 0.004 };
            let (du, dv) = (warp * grain(8, 2, seed), warp * grain(8, 2, seed ^ 9));
            let (stone, joint) = courses(
                (u + du).rem_euclid(1.0),
                (v + dv).rem_euclid(1.0),
                across,
                rows,
                seed,
            );
            (1.0 - joint, 0.86 + 0.26 * stone + 0.12 * fine)
        }
        Pattern::Plaster => (0.15 + 0.25 * grain(3, 3, seed), 1.0 + 0.05 * fine),
        Pattern::Planks => {
            let (board, joint) = courses(u, v, 1, 5, seed);
            let fibre = t.noise(u * 6.0, v * 60.0, 6, seed);
            (1.0 - joint, 0.85 + 0.24 * board + 0.12 * fibre)
        }
        Pattern::Beams => {
            // Plaster between upright and level timbers.
            let frame = u.min(1.0 - u) < 0.07 || v.min(1.0 - v) < 0.07;
            let fibre = t.noise(u * 24.0, v * 24.0, 24, seed);
            if frame {
                (1.0, 1.0 + 0.2 * fibre)
            } else {
                (0.08, 1.0 + 0.06 * fine)
            }
        }
        Pattern::Thatch => {
            let straw = t.noise(u * 40.0, v * 6.0, 2, seed);
            (0.35 + 0.4 * straw, 0.85 + 0.25 * v.fract() + 0.08 * fine)
        }
        Pattern::Shingles => {
            let (tile, joint) = courses(u, v, 6, 6, seed);
            let drop = 1.0 - (v * 6.0).fract();
            (0.7 * (1.0 - joint), 0.75 + 0.2 * tile + 0.25 * drop)
        }
        Pattern::Leaves => {
            let clumps = grain(9, 2, seed);
            (0.5 - 0.6 * clumps, 0.85 + 0.45 * clumps + 0.2 * fine)
        }
        Pattern::Bark => {
            let ribs = t.noise(u * 20.0, v * 4.0, 4, seed);
            (0.5 + 0.5 * ribs, 0.9 + 0.2 * ribs)
        }
        Pattern::Water => {
            let ripple = grain(6, 2, seed);
            (0.4 + 0.4 * ripple, 1.0 + 0.15 * ripple)
        }
    }
}

/// For each pixel the share of the second colour and the brightness.
type Shades = Vec<(f64, f64)>;

/// Draws textures. What a pattern looks like is computed once; materials only colour it.
#[derive(Default)]
pub(crate) struct Painter {
    /// Pattern and seed with, for each pixel, the share of the second colour and the brightness.
    drawn: Vec<(Pattern, u32, Shades)>,
}

impl Painter {
    fn shades(&mut self, pattern: Pattern, seed: u32) -> &[(f64, f64)] {
        let at = self
            .drawn
            .iter()
            .position(|(p, s, _)| (*p, *s) == (pattern, seed))
            .unwrap_or_else(|| {
                let tables = Tables::default();
                let place = |k: usize| (k as f64 + 0.5) / SIDE as f64;
                let pixel = |k: usize| shade(&tables, pattern, (place(k % SIDE), place(k / SIDE)), seed);
                self.drawn
                    .push((pattern, seed, (0..SIDE * SIDE).map(pixel).collect()));
                self.drawn.len() - 1
            });
        &self.drawn[at].2
    }

    /// The pixels of a texture, rows from top to bottom, red green blue.
    pub(crate) fn texture(
        &mut self,
        pattern: Pattern,
        color: [u8; 3],
        second: [u8; 3],
        seed: u32,
    ) -> Vec<[u8; 3]> {
        let colored = |&(mix, bright): &(f64, f64)| {
            let mix = mix.clamp(0.0, 1.0);
            let channel = |k: usize| {
                let (a, b) = (f64::from(color[k]), f64::from(second[k]));
                ((a + (b - a) * mix) * bright).clamp(0.0, 255.0) as u8
            };
            [channel(0), channel(1), channel(2)]
        };
        self.shades(pattern, seed).iter().map(colored).collect()
    }
}

/// A terrain blend map: 0 where the corners of `code` (SW 1, SE 2, NE 4, NW 8) are, 255 elsewhere, with a ragged
/// border (`rendering.md` 11.5g). Pixel rows run from north to south.
pub(crate) fn blend_map(code: u32, reach: f64, seed: u32) -> Vec<u8> {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
    let mut out = Vec::with_capacity(SIDE * SIDE);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let last = (SIDE - 1) as f64;
            let p = DVec2::new(x as f64 / last, 1.0 - y as f64 / last);
            let on = |k: usize| code & 1 << k != 0;
            let mut near = f64::INFINITY;
            for k in 0..4 {
                let (a, b) = (corners[k], corners[(k + 1) % 4]);
                if on(k) {
                    near = near.min(p.distance(a));
                }
                if on(k) && on((k + 1) % 4) {
                    let t = (p - a).dot(b - a).clamp(0.0, 1.0);
                    near = near.min(p.distance(a + (b - a) * t));
                }
            }
            for (a, c) in [(0, 2), (1, 3)] {
                if on(a) && on(c) {
                    let (a, c) = (corners[a], corners[c]);
                    let t = ((p - a).dot(c - a) / 2.0).clamp(0.0, 1.0);
                    near = near.min(p.distance(a + (c - a) * t));
                }
            }
            let ragged = near + 0.07 * value_noise(p * 9.0, seed);
            out.push(((ragged - reach) / 0.16 * 255.0).clamp(0.0, 255.0) as u8);
        }
    }
    out
}
