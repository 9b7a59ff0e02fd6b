//! Pseudo-random numbers that depend on nothing but their arguments.

use std::cell::RefCell;
use std::rc::Rc;

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
    hash01(
        (x as u32).wrapping_mul(0x01F1_F1F1) ^ (y as u32).wrapping_mul(0x3C6E_F372),
        seed,
    ) * 2.0
        - 1.0
}

fn fade(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// Smooth noise from -1 to 1, a new value at every whole number.
pub(crate) fn value_noise(p: DVec2, seed: u32) -> f64 {
    let cell = p.floor();
    let (tx, ty) = (fade(p.x - cell.x), fade(p.y - cell.y));
    let (x, y) = (cell.x as i64, cell.y as i64);
    let at = |dx: i64, dy: i64| lattice(x + dx, y + dy, seed);
    let south = at(0, 0) + (at(1, 0) - at(0, 0)) * tx;
    let north = at(0, 1) + (at(1, 1) - at(0, 1)) * tx;
    south + (north - south) * ty
}

/// A lattice of random numbers: its period, its seed, and the numbers.
type Table = (u32, u32, Rc<[f64]>);

/// Noise tables, made when first needed: textures look up the same few lattices for every pixel.
#[derive(Default)]
pub(crate) struct Tables {
    made: RefCell<Vec<Table>>,
}

impl Tables {
    fn of(&self, period: u32, seed: u32) -> Rc<[f64]> {
        let mut made = self.made.borrow_mut();
        if let Some((.., table)) = made.iter().find(|(p, s, _)| (*p, *s) == (period, seed)) {
            return table.clone();
        }
        let cells = (0..period * period).map(|k| lattice(i64::from(k / period), i64::from(k % period), seed));
        let table: Rc<[f64]> = cells.collect();
        made.push((period, seed, table.clone()));
        table
    }

    /// As [`value_noise`] for places from 0 on, repeating after `period`.
    pub(crate) fn noise(&self, x: f64, y: f64, period: u32, seed: u32) -> f64 {
        let (cx, cy) = (x as u32, y as u32);
        let (tx, ty) = (fade(x - f64::from(cx)), fade(y - f64::from(cy)));
        let (x0, y0) = (cx % period, cy % period);
        let (x1, y1) = ((x0 + 1) % period, (y0 + 1) % period);
        let table = self.of(period, seed);
        let at = |x: u32, y: u32| table[(x * period + y) as usize];
        let south = at(x0, y0) + (at(x1, y0) - at(x0, y0)) * tx;
        let north = at(x0, y1) + (at(x1, y1) - at(x0, y1)) * tx;
        south + (north - south) * ty
    }
}
