//! Pseudo-random numbers that depend on nothing but their arguments.

use glam::DVec2;

/// Mixes a number with a seed (a finaliser of the Murmur family).
pub(crate) fn hash(n: u32, seed: u32) -> u32 {
    let mut h = n.wrapping_mul(0x9E37_79B1) ^ seed.wrapping_mul(0x85EB_CA77).wrapping_add(0x1656_67B1);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2C1B_3C6D);
    h ^= h >> 12;
    h = h.wrapping_mul(0x297A_2D39);
    h ^ h >> 15
}

/// A number from 0 to 1.
pub(crate) fn hash01(n: u32, seed: u32) -> f64 {
    f64::from(hash(n, seed)) / 4_294_967_296.0
}

fn lattice(x: i64, y: i64, seed: u32) -> f64 {
    hash01((x as u32).wrapping_mul(0x01F1_F1F1) ^ (y as u32).wrapping_mul(0x3C6E_F372), seed) * 2.0 - 1.0
}

fn fade(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// Smooth noise from -1 to 1, a new value at every whole number.
pub(crate) fn value_noise(p: DVec2, seed: u32) -> f64 {
    tiled_noise(p, seed, i64::MAX)
}

/// As [`value_noise`], repeating after `period`.
pub(crate) fn tiled_noise(p: DVec2, seed: u32, period: i64) -> f64 {
    let cell = p.floor();
    let (tx, ty) = (fade(p.x - cell.x), fade(p.y - cell.y));
    let (x, y) = (cell.x as i64, cell.y as i64);
    let at = |dx: i64, dy: i64| lattice((x + dx).rem_euclid(period), (y + dy).rem_euclid(period), seed);
    let south = at(0, 0) + (at(1, 0) - at(0, 0)) * tx;
    let north = at(0, 1) + (at(1, 1) - at(0, 1)) * tx;
    south + (north - south) * ty
}
