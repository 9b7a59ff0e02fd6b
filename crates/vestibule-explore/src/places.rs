//! Where to go: typed positions, map coordinates and names.

use vestibule_world::{CellId, MapCoordinates, Position, World};

/// A place with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPlace {
    /// What it is called.
    pub name: String,
    /// Where it is.
    pub position: Position,
}

/// Why a text names no place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlaceError {
    /// It is neither a position nor coordinates nor a name.
    #[error(
        "'{text}' is no place: type a position like 0xA9B40031 [155.4 26 94], coordinates like 42.1N, 33.6E, a cell or a name"
    )]
    Unknown {
        /// What was typed.
        text: String,
    },
    /// There is no such cell.
    #[error("there is no cell {0} in this world")]
    NoCell(CellId),
    /// There is such a cell, and the point is nowhere near it.
    #[error("{0} lies far from the landblock of its cell, which measures 192 m")]
    Far(Position),
    /// The coordinates lie outside the map.
    #[error("{0} lies outside the map")]
    OffMap(MapCoordinates),
}

/// The place a text names: a position as the game prints it, map coordinates, a cell, or one of `names` or the
/// beginning of it.
///
/// # Errors
/// When it names none.
pub fn find(world: &World, names: &[NamedPlace], text: &str) -> Result<Position, PlaceError> {
    let text = text.trim();
    let text = text.strip_prefix("Your location is:").map_or(text, str::trim);
    let lower = text.to_lowercase();
    if lower.is_empty() {
        return Err(PlaceError::Unknown { text: lower });
    }
    let same = |n: &&NamedPlace| n.name.to_lowercase() == lower;
    let begins = |n: &&NamedPlace| n.name.to_lowercase().starts_with(&lower);
    let holds = |n: &&NamedPlace| n.name.to_lowercase().contains(&lower);
    let named = names.iter().find(same);
    let named = named.or_else(|| names.iter().find(begins));
    let named = named.or_else(|| names.iter().find(|n| lower.len() > 2 && holds(n)));
    if let Some(place) = named {
        return Ok(place.position);
    }
    if let Ok(position) = text.parse::<Position>() {
        return usable(world, position);
    }
    if let Ok(map) = text.parse::<MapCoordinates>() {
        let flat = map.to_position(0.0).ok_or(PlaceError::OffMap(map))?;
        let mut origin = flat.origin();
        origin.z = world.ground_at(flat.cell, origin).map_or(0.0, |g| g.z);
        return usable(world, Position::new(flat.cell, origin));
    }
    if let Ok(cell) = text.parse::<CellId>() {
        return middle_of(world, cell).ok_or(PlaceError::NoCell(cell));
    }
    Err(PlaceError::Unknown {
        text: text.to_owned(),
    })
}

fn usable(world: &World, position: Position) -> Result<Position, PlaceError> {
    let block = world.block(position.cell.block());
    // Landblocks measure 192 m; a kilometre beside one is a slip of the pen.
    let near = position.is_finite() && position.origin().abs().max_element() < 1000.0;
    match block {
        None => Err(PlaceError::NoCell(position.cell)),
        Some(_) if !near => Err(PlaceError::Far(position)),
        Some(_) => Ok(position),
    }
}

/// A place to stand in a cell: the middle of a room at its floor, or of a land cell on the ground.
pub fn middle_of(world: &World, cell: CellId) -> Option<Position> {
    world.block(cell.block())?;
    if let Some(room) = world.env_cell(cell) {
        let b = room.structure.bounds?;
        let middle = room.frame.local_to_global((b.min + b.max) * 0.5);
        let first = spots(world, cell).first().copied();
        return Some(first.unwrap_or_else(|| Position::new(cell, middle)));
    }
    let land = world.land_cell(cell)?;
    let corners = land.polygons.iter().flat_map(|p| p.vertices);
    let sum: glam::Vec3 = corners.sum();
    let mut middle = sum / 6.0;
    middle.z = world.ground_at(cell, middle).map_or(middle.z, |g| g.z);
    Some(Position::new(cell, middle))
}

/// Points of a room at its floor, from the middle outwards: furniture and stairs may stand on some.
pub(crate) fn spots(world: &World, cell: CellId) -> Vec<Position> {
    let Some((room, b)) = world.env_cell(cell).and_then(|c| Some((c, c.structure.bounds?))) else {
        return Vec::new();
    };
    let (middle, half) = ((b.min + b.max) * 0.5, (b.max - b.min) * 0.5);
    let step = |k: i32| ((k + 1) / 2) as f32 * if k % 2 == 0 { 0.21 } else { -0.21 };
    // Rooms are seldom boxes: only what is inside.
    let spot = |k: i32| {
        let ring = [(k % 7), (k / 7)];
        let p = middle + glam::Vec3::new(step(ring[0]) * half.x, step(ring[1]) * half.y, 0.0);
        let p = glam::Vec3::new(p.x, p.y, b.min.z + 0.5);
        let at = room.frame.local_to_global(p);
        let down = room.frame.local_to_global(p - glam::Vec3::Z * 0.48);
        room.contains_point(at).then(|| Position::new(cell, down))
    };
    (0..49).filter_map(spot).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hollow;

    #[test]
    fn places_are_found_by_position_coordinates_cell_and_name() {
        let (world, names) = hollow();
        let at = |text: &str| find(&world, &names, text);
        assert_eq!(at("0xA9B40031 [155.4 26 94]").unwrap().cell, CellId(0xA9B4_0031));
        assert_eq!(at("0xA9B40101").unwrap().cell, CellId(0xA9B4_0101));
        let cellar = at("cottage.cellar").unwrap();
        assert!(
            world
                .env_cell(cellar.cell)
                .unwrap()
                .contains_point(cellar.origin() + glam::Vec3::Z)
        );
        assert_eq!(at("COTTAGE.CEL").unwrap(), cellar);
        let map = MapCoordinates::of(&Position::new(
            CellId(0xA9B4_0031),
            glam::Vec3::new(155.0, 26.0, 0.0),
        ));
        assert!(at(&map.to_string()).is_ok(), "{map}");
    }

    #[test]
    fn nowhere_is_an_error_that_says_what_would_do() {
        let (world, names) = hollow();
        for text in [
            "",
            "  ",
            "no such place",
            "0xA9B4FFF0",
            "0x00010001 [1 2 3]",
            "999N, 999E",
            "0xA9B40031 [nan 1 2]",
        ] {
            assert!(find(&world, &names, text).is_err(), "{text}");
        }
        let far = find(&world, &names, "0xA9B40031 [1e30 0 0]");
        assert!(matches!(far, Err(PlaceError::Far(_))), "{far:?}");
    }
}
