//! The keys, for the window, its help and `--help`.

use std::fmt::Write as _;

/// What a key does once, when it is pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Show or hide the list of keys.
    Help,
    /// Show or hide all panels.
    Panels,
    /// Show or hide the map.
    Map,
    /// Show or hide an overlay, by its position in [`crate::overlays::Overlay::ALL`].
    Overlay(usize),
    /// Hold the traversal and fly, or go on.
    Freeze,
    /// Draw only the cell of the player, or everything again.
    SingleCell,
    /// Draw everything there is, or only what the traversal reaches.
    Everything,
    /// Open or close the door in front.
    Door,
    /// Into the head, or behind the character.
    FirstPerson,
    /// Save a picture.
    Screenshot,
    /// An hour earlier (-1) or later (1).
    Time(i8),
    /// Begin typing where to go.
    Teleport,
    /// Back to where it began.
    Home,
    /// Leave what is open, then the program.
    Escape,
}

/// What is done while a key is held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// Walk forwards.
    pub forward: bool,
    /// Walk backwards.
    pub back: bool,
    /// Side-step to the left.
    pub left: bool,
    /// Side-step to the right.
    pub right: bool,
    /// Turn to the left.
    pub turn_left: bool,
    /// Turn to the right.
    pub turn_right: bool,
    /// Walk instead of running; fly slowly.
    pub slow: bool,
    /// Jump; fly upwards.
    pub jump: bool,
    /// Fly downwards.
    pub down: bool,
}

/// Keys and what they do, in the order they are shown.
pub const KEYS: [(&str, &str); 23] = [
    ("W S, up down", "walk forwards and backwards"),
    ("A D", "step to the side"),
    ("Q E, left right", "turn"),
    ("Shift", "walk instead of running"),
    ("Space", "jump"),
    ("drag the mouse", "look around"),
    ("mouse wheel", "zoom, from first person outwards"),
    ("V", "first person or behind the character"),
    ("F", "open or close the door in front"),
    ("T", "type where to go: position, coordinates or name"),
    ("Home", "back to where you began"),
    ("click", "what is this? cell, polygon, surface, object"),
    ("M", "map: click a cell to go there"),
    ("1", "overlay: cell outlines"),
    ("2", "overlay: portals, passed or refused and why"),
    ("3", "overlay: clip regions"),
    ("4", "overlay: collision polygons"),
    ("5", "overlay: stab list"),
    (
        "G",
        "hold the traversal and fly out to look at it (Space up, C down)",
    ),
    ("O, P", "draw only the player's cell; draw everything there is"),
    ("[ ]", "earlier, later in the day"),
    ("F2", "save a picture"),
    ("H or F1, Tab, Esc", "these keys; all panels; close or leave"),
];

/// The keys as text, for `--help`.
pub fn keys_help() -> String {
    let mut out = String::from("Keys:\n");
    for (keys, what) in KEYS {
        // Writing to a string does not fail.
        let _ = writeln!(out, "  {keys:<18} {what}");
    }
    out
}

/// The action of a key, by the name of the character it types or its own (`F1`, `Tab`, `Escape`, `Home`).
pub fn action(key: &str) -> Option<Action> {
    Some(match key {
        "h" | "F1" => Action::Help,
        "Tab" => Action::Panels,
        "m" => Action::Map,
        "1" | "2" | "3" | "4" | "5" => Action::Overlay(usize::from(key.as_bytes()[0] - b'1')),
        "g" => Action::Freeze,
        "o" => Action::SingleCell,
        "p" => Action::Everything,
        "f" => Action::Door,
        "v" => Action::FirstPerson,
        "F2" | "F12" => Action::Screenshot,
        "[" => Action::Time(-1),
        "]" => Action::Time(1),
        "t" => Action::Teleport,
        "Home" => Action::Home,
        "Escape" => Action::Escape,
        _ => return None,
    })
}

impl Held {
    /// What either holds.
    pub fn or(self, other: Held) -> Held {
        Held {
            forward: self.forward || other.forward,
            back: self.back || other.back,
            left: self.left || other.left,
            right: self.right || other.right,
            turn_left: self.turn_left || other.turn_left,
            turn_right: self.turn_right || other.turn_right,
            slow: self.slow || other.slow,
            jump: self.jump || other.jump,
            down: self.down || other.down,
        }
    }

    /// The key, by the name of what it types or its own, went down or up; whether it is one that is held.
    pub fn set(&mut self, key: &str, down: bool) -> bool {
        let slot = match key {
            "w" | "ArrowUp" => &mut self.forward,
            "s" | "ArrowDown" => &mut self.back,
            "a" => &mut self.left,
            "d" => &mut self.right,
            "q" | "ArrowLeft" => &mut self.turn_left,
            "e" | "ArrowRight" => &mut self.turn_right,
            "Shift" => &mut self.slow,
            "Space" => &mut self.jump,
            "c" => &mut self.down,
            _ => return false,
        };
        *slot = down;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_is_both_held_and_pressed_once() {
        for key in [
            "w",
            "s",
            "a",
            "d",
            "q",
            "e",
            "c",
            "Shift",
            "Space",
            "ArrowUp",
            "ArrowDown",
            "ArrowLeft",
            "ArrowRight",
        ] {
            assert!(Held::default().set(key, true), "{key}");
            assert_eq!(action(key), None, "{key}");
        }
    }

    #[test]
    fn help_lists_every_key() {
        let help = keys_help();
        for (keys, what) in KEYS {
            assert!(help.contains(keys) && help.contains(what));
        }
        assert!(help.lines().all(|line| line.len() < 90));
    }
}
