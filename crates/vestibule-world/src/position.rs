//! Positions (`world.md` K3): a cell and a frame, read and printed as the community writes them.

use core::fmt;
use core::str::FromStr;

use glam::{Quat, Vec3};

use crate::constants::{BLOCK_LENGTH, EPSILON};
use crate::frame::Frame;
use crate::ids::{BlockId, CellId, block_offset};

/// A cell and a frame relative to the south-west corner of the landblock named in the cell id, metres
/// (`world.md` K3), also for env cells.
///
/// ```
/// use vestibule_world::Position;
/// let p: Position = "0xA9B40170 [155.343 15.134 94.005] 1 0 0 0".parse().unwrap();
/// assert_eq!(p.to_string(), "0xA9B40170 [155.343 15.134 94.005] 1 0 0 0");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Position {
    /// The cell; [`CellId::NONE`] for nowhere.
    pub cell: CellId,
    /// Origin and rotation in the frame of the cell's landblock.
    pub frame: Frame,
}

impl Position {
    /// An unrotated position.
    pub fn new(cell: CellId, origin: Vec3) -> Self {
        Position {
            cell,
            frame: Frame::at(origin),
        }
    }

    /// The origin, landblock frame, metres.
    #[inline]
    pub fn origin(&self) -> Vec3 {
        self.frame.origin
    }

    /// The vector from this position's origin to `other`'s (retail `get_offset`, `world.md` K5).
    pub fn offset_to(&self, other: &Position) -> Vec3 {
        block_offset(self.cell.block(), other.cell.block()) + other.frame.origin - self.frame.origin
    }

    /// A point local to `from`, in the frame of this position's landblock (`transition.md` 1.5.3).
    #[inline]
    pub fn local_to_global_of(&self, from: &Position, p: Vec3) -> Vec3 {
        block_offset(self.cell.block(), from.cell.block()) + from.frame.local_to_global(p)
    }

    /// A point local to `from`, local to this position (`transition.md` 1.5.4).
    #[inline]
    pub fn local_to_local(&self, from: &Position, p: Vec3) -> Vec3 {
        self.frame.global_to_local(self.local_to_global_of(from, p))
    }

    /// The land cell under or above the origin, with the origin re-based to its landblock
    /// (retail `adjust_to_outside`); `None` off the map.
    pub fn adjusted_to_outside(&self) -> Option<Position> {
        let (cell, origin) = self.cell.adjust_to_outside(self.frame.origin)?;
        let mut out = *self;
        out.cell = cell;
        out.frame.origin = origin;
        Some(out)
    }

    /// Position equality of `transition.md` 1.3.3: the same full cell id, origin and quaternion within epsilon.
    #[inline]
    pub fn same_as(&self, other: &Position) -> bool {
        let close = |a: f32, b: f32| (a - b).abs() < EPSILON;
        let (a, b) = (self.frame.origin, other.frame.origin);
        let (p, q) = (self.frame.rotation(), other.frame.rotation());
        self.cell == other.cell
            && close(a.x, b.x)
            && close(a.y, b.y)
            && close(a.z, b.z)
            && close(p.w, q.w)
            && close(p.x, q.x)
            && close(p.y, q.y)
            && close(p.z, q.z)
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.frame.is_finite()
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (o, q) = (self.frame.origin, self.frame.rotation());
        write!(
            f,
            "{} [{} {} {}] {} {} {} {}",
            self.cell, o.x, o.y, o.z, q.w, q.x, q.y, q.z
        )
    }
}

/// Why a text is not a position.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{text}', column {column}: {problem}; write a position as \"0xA9B40170 [155.343 15.134 94.005] 1 0 0 0\""
)]
pub struct ParsePositionError {
    /// The whole text.
    pub text: String,
    /// Column of the first wrong character, from 1.
    pub column: usize,
    /// What is wrong there.
    pub problem: &'static str,
}

impl FromStr for Position {
    type Err = ParsePositionError;

    /// Reads `0xCELL [x y z] w x y z`. The quaternion may be left out; `0x` and commas between numbers are
    /// optional. Numbers must be finite.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut scan = Scanner { text, at: 0 };
        let (at, word) = scan.word();
        let cell: CellId = word
            .parse()
            .map_err(|_| scan.error(at, "expected a cell id of eight hexadecimal digits"))?;
        scan.expect('[', "expected '[' before the coordinates")?;
        let origin = Vec3::new(scan.number()?, scan.number()?, scan.number()?);
        scan.expect(']', "expected ']' after three coordinates")?;
        let rotation = if scan.at_end() {
            Quat::IDENTITY
        } else {
            let (w, x, y, z) = (scan.number()?, scan.number()?, scan.number()?, scan.number()?);
            Quat::from_xyzw(x, y, z, w)
        };
        if !scan.at_end() {
            return Err(scan.error(scan.at, "unexpected text after the position"));
        }
        Ok(Position {
            cell,
            frame: Frame::new(origin, rotation),
        })
    }
}

struct Scanner<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Scanner<'a> {
    fn error(&self, at: usize, problem: &'static str) -> ParsePositionError {
        let column = self.text.get(..at).map_or(at, |s| s.chars().count()) + 1;
        ParsePositionError {
            text: self.text.to_owned(),
            column,
            problem,
        }
    }

    fn skip(&mut self) {
        let rest = self.text.get(self.at..).unwrap_or("");
        self.at += rest.len()
            - rest
                .trim_start_matches(|c: char| c.is_whitespace() || c == ',')
                .len();
    }

    fn at_end(&mut self) -> bool {
        self.skip();
        self.at >= self.text.len()
    }

    fn word(&mut self) -> (usize, &'a str) {
        self.skip();
        let start = self.at;
        let rest = self.text.get(start..).unwrap_or("");
        let end = rest
            .find(|c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']'))
            .unwrap_or(rest.len());
        self.at = start + end;
        (start, rest.get(..end).unwrap_or(""))
    }

    fn expect(&mut self, wanted: char, problem: &'static str) -> Result<(), ParsePositionError> {
        self.skip();
        if self
            .text
            .get(self.at..)
            .is_some_and(|rest| rest.starts_with(wanted))
        {
            self.at += wanted.len_utf8();
            Ok(())
        } else {
            Err(self.error(self.at, problem))
        }
    }

    fn number(&mut self) -> Result<f32, ParsePositionError> {
        let (at, word) = self.word();
        match word.parse::<f32>() {
            Ok(v) if v.is_finite() => Ok(v),
            Ok(_) => Err(self.error(at, "a coordinate must be a finite number")),
            Err(_) => Err(self.error(at, "expected a number")),
        }
    }
}

/// Outdoor map coordinates as players read them, `42.1N, 33.6E`: tenths count land cells of 24 m from the
/// middle of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapCoordinates {
    /// Degrees north; negative is south.
    pub north: f32,
    /// Degrees east; negative is west.
    pub east: f32,
}

/// Land cells from the map's south-west corner to its coordinates' origin, 0.0N 0.0E.
const MAP_ORIGIN_CELLS: f64 = 1019.5;

impl MapCoordinates {
    /// Map coordinates of a position, which may be indoors: the point above it counts.
    pub fn of(position: &Position) -> Self {
        let corner = position.cell.block().corner();
        let degrees = |cell: i32, metres: f32| {
            ((f64::from(cell) + f64::from(metres) / 24.0 - MAP_ORIGIN_CELLS) / 10.0) as f32
        };
        let o = position.frame.origin;
        MapCoordinates {
            north: degrees(corner.y, o.y),
            east: degrees(corner.x, o.x),
        }
    }

    /// The outdoor position here, at height `z`; `None` off the map.
    pub fn to_position(self, z: f32) -> Option<Position> {
        let metres = |degrees: f32| (f64::from(degrees) * 10.0 + MAP_ORIGIN_CELLS) * 24.0;
        let (x, y) = (metres(self.east), metres(self.north));
        let side = f64::from(BLOCK_LENGTH);
        let block = |m: f64| u8::try_from(libm::floor(m / side) as i64).ok();
        if !(x.is_finite() && y.is_finite()) {
            return None;
        }
        let id = BlockId::new(block(x)?, block(y)?);
        let local = Vec3::new(
            (x - f64::from(id.x()) * side) as f32,
            (y - f64::from(id.y()) * side) as f32,
            z,
        );
        Position::new(CellId::new(id, 0xFFFF), local).adjusted_to_outside()
    }
}

impl fmt::Display for MapCoordinates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (ns, ew) = (
            if self.north < 0.0 { 'S' } else { 'N' },
            if self.east < 0.0 { 'W' } else { 'E' },
        );
        write!(f, "{:.1}{ns}, {:.1}{ew}", self.north.abs(), self.east.abs())
    }
}

/// A text that is not a pair of map coordinates.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{text}' is not a pair of map coordinates: write 42.1N, 33.6E")]
pub struct ParseMapCoordinatesError {
    text: String,
}

impl FromStr for MapCoordinates {
    type Err = ParseMapCoordinatesError;

    /// Reads `42.1N, 33.6E`; the comma is optional, letters may be small.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let fail = || ParseMapCoordinatesError {
            text: text.to_owned(),
        };
        let mut words = text
            .split(|c: char| c.is_whitespace() || c == ',')
            .filter(|w| !w.is_empty());
        let mut axis = |plus: char, minus: char| -> Option<f32> {
            let word = words.next()?;
            let letter = word.chars().last()?;
            let value: f32 = word.get(..word.len() - letter.len_utf8())?.parse().ok()?;
            if !(0.0..=102.5).contains(&value) {
                return None;
            }
            let letter = letter.to_ascii_uppercase();
            if letter == plus {
                Some(value)
            } else if letter == minus {
                Some(-value)
            } else {
                None
            }
        };
        let north = axis('N', 'S').ok_or_else(fail)?;
        let east = axis('E', 'W').ok_or_else(fail)?;
        if words.next().is_some() {
            return Err(fail());
        }
        Ok(MapCoordinates { north, east })
    }
}

/// Heading of a direction in degrees, 0 north, clockwise, in 0…360 (`world.md` K1).
pub fn heading_of(direction: Vec3) -> f32 {
    let degrees = libm::atan2f(direction.y, direction.x) * (180.0 / core::f32::consts::PI);
    let heading = libm::fmodf(450.0 - degrees, 360.0);
    if heading < 0.0 { heading + 360.0 } else { heading }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_print_and_read_back_to_the_bit() {
        let h = core::f32::consts::FRAC_1_SQRT_2;
        let p = Position {
            cell: CellId(0xA9B4_0031),
            frame: Frame::new(
                Vec3::new(155.3717, 16.0283, 94.005),
                Quat::from_xyzw(0.0, 0.0, -h, h),
            ),
        };
        assert_eq!(p.to_string().parse::<Position>(), Ok(p));
    }

    #[test]
    fn a_position_may_leave_out_its_rotation() {
        let p: Position = "A9B40170 [1, 2, 3]".parse().unwrap();
        assert_eq!(p, Position::new(CellId(0xA9B4_0170), Vec3::new(1.0, 2.0, 3.0)));
    }

    #[test]
    fn a_bad_position_names_the_column_and_the_problem() {
        let columns = [
            ("", 1),
            ("A9B4 [1 2 3]", 1),
            ("0xA9B40170 1 2 3", 12),
            ("0xA9B40170 [1 x 3]", 15),
            ("0xA9B40170 [1 2]", 16),
            ("0xA9B40170 [1 2 NaN]", 17),
            ("0xA9B40170 [1 2 inf]", 17),
            ("0xA9B40170 [1 2 3] 1 0 0", 25),
            ("0xA9B40170 [1 2 3] 1 0 0 0 9", 28),
        ];
        for (text, column) in columns {
            let error = text.parse::<Position>().unwrap_err();
            assert_eq!(error.column, column, "{error}");
        }
    }

    #[test]
    fn map_coordinates_of_the_town_are_those_players_know() {
        let p = Position::new(CellId(0xA9B4_0019), Vec3::new(84.0, 7.1, 94.005));
        assert_eq!(MapCoordinates::of(&p).to_string(), "42.1N, 33.6E");
        let back = "42.1N, 33.6E"
            .parse::<MapCoordinates>()
            .unwrap()
            .to_position(94.0)
            .unwrap();
        assert!(p.offset_to(&back).truncate().length() < 24.0);
        assert_eq!(back.cell.block(), BlockId(0xA9B4));
        assert_eq!(
            "0.5s 101.9W".parse::<MapCoordinates>().unwrap().to_string(),
            "0.5S, 101.9W"
        );
        for bad in ["", "42.1N", "42.1E, 33.6N", "420N, 3E", "NaNN, 3E", "1N 2E 3"] {
            assert!(bad.parse::<MapCoordinates>().is_err(), "{bad}");
        }
    }

    #[test]
    fn example_22_heading() {
        for (v, degrees) in [
            (Vec3::Y, 0.0),
            (Vec3::X, 90.0),
            (-Vec3::Y, 180.0),
            (-Vec3::X, 270.0),
        ] {
            assert!((heading_of(v) - degrees).abs() < 1e-4, "{v}");
        }
    }

    #[test]
    fn e2_outdoor_cell_follows_from_the_position() {
        for block in [0x0000u32, 0xA9B4, 0xFEFE] {
            for i in 0..200u32 {
                let (x, y) = ((i * 37 % 192) as f32 + 0.25, (i * 91 % 192) as f32 + 0.5);
                let (id, _) = CellId(block << 16 | 0xFFFF)
                    .adjust_to_outside(Vec3::new(x, y, 0.0))
                    .unwrap();
                let expected = 8 * (x / 24.0).floor() as u32 + (y / 24.0).floor() as u32 + 1;
                assert_eq!(id.0, block << 16 | expected);
            }
        }
    }
}
