//! Places as arguments: positions and map coordinates.

use vestibule::world::{MapCoordinates, Position, World};

use crate::ui::Usage;

/// A place as a person gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// `0xA9B40170 [155.343 15.134 94.005] 1 0 0 0`
    Position(Position),
    /// `42.1N, 33.6E`, on the ground.
    Map(MapCoordinates),
}

/// Reads a place. What `/loc` prints in the game may be pasted whole.
pub(crate) fn parse_place(text: &str) -> Result<Place, String> {
    let text = text.trim();
    let text = text.strip_prefix("Your location is:").map_or(text, str::trim);
    let is_map = !text.contains('[')
        && !text.contains("0x")
        && text.contains(|c| "NSEWnsew".contains(c))
        && text.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '.')
        && text
            .split_whitespace()
            .next()
            .is_none_or(|word| word.parse::<vestibule::world::CellId>().is_err());
    if is_map {
        return text
            .parse::<MapCoordinates>()
            .map(Place::Map)
            .map_err(|e| e.to_string());
    }
    let position: Position = text
        .parse()
        .map_err(|e: vestibule::world::ParsePositionError| e.to_string())?;
    let cell = position.cell;
    if !cell.block().is_on_map() {
        return Err(format!(
            "'{text}', column 1: landblock {} is off the map, whose indices go from 00 to FE",
            cell.block()
        ));
    }
    if !cell.has_valid_low() {
        return Err(format!(
            "'{text}', column 1: {cell} is no cell: outdoor cells end in 0001 to 0040, indoor ones in 0100 to FFFD"
        ));
    }
    if cell.outside_land_coord(position.origin()).is_none() && !cell.is_indoor() {
        return Err(format!(
            "'{text}', column {}: lies outside the map",
            text.find('[').map_or(1, |at| at + 1)
        ));
    }
    Ok(Place::Position(position))
}

/// Several words as one place, as when it was not put into quotes.
pub(crate) fn join_place(words: &[String]) -> Result<Place, Usage> {
    parse_place(&words.join(" ")).map_err(Usage)
}

impl Place {
    /// The position; map coordinates are put on the ground of `world`.
    pub(crate) fn position(self, world: &World) -> Result<Position, Usage> {
        match self {
            Place::Position(position) => Ok(position),
            Place::Map(map) => {
                let flat = map
                    .to_position(0.0)
                    .ok_or_else(|| Usage(format!("{map} lies outside the map")))?;
                let ground = world.ground_at(flat.cell, flat.origin());
                let mut origin = flat.origin();
                origin.z = ground.map_or(0.0, |g| g.z);
                Ok(Position::new(flat.cell, origin))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_game_prints_can_be_pasted() {
        let text = "Your location is: 0xA9B40019 [84.000000 7.100000 94.005005] 0.996917 0.000000 0.000000 -0.078459";
        assert!(matches!(parse_place(text), Ok(Place::Position(p)) if p.cell.0 == 0xA9B4_0019));
        assert!(matches!(parse_place("42.1N, 33.6E"), Ok(Place::Map(_))));
    }

    #[test]
    fn what_is_off_the_map_is_said_with_its_column() {
        for (text, wanted) in [
            ("0xFFB40001 [1 2 3]", "column 1: landblock 0xFFB4 is off the map"),
            ("0xA9B40041 [1 2 3]", "column 1: 0xA9B40041 is no cell"),
            ("0x00000001 [-5 2 3]", "column 12: lies outside the map"),
            ("0xA9B40001 [1 x 3]", "column 15: expected a number"),
            ("400N, 3E", "is not a pair of map coordinates"),
        ] {
            let error = parse_place(text).unwrap_err();
            assert!(error.contains(wanted), "{error}");
        }
    }
}
