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

/// What keys are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Moving and looking.
    Move,
    /// Going elsewhere.
    Go,
    /// Finding out why it looks as it does.
    Why,
    /// The window.
    Window,
}

impl Group {
    /// All, in the order they are shown.
    pub const ALL: [Group; 4] = [Group::Move, Group::Go, Group::Why, Group::Window];

    /// Its heading.
    pub fn name(self) -> &'static str {
        match self {
            Group::Move => "walk",
            Group::Go => "go",
            Group::Why => "look behind the scenes",
            Group::Window => "window",
        }
    }
}

/// Keys and what they do, in the order they are shown.
pub const KEYS: [(Group, &str, &str); 24] = [
    (Group::Move, "W S, up down", "walk forwards and backwards"),
    (Group::Move, "A D", "step to the side"),
    (Group::Move, "Q E, left right", "turn"),
    (Group::Move, "Shift", "walk instead of running"),
    (Group::Move, "Space", "jump"),
    (Group::Move, "drag the mouse", "look around"),
    (Group::Move, "mouse wheel", "zoom, from first person outwards"),
    (Group::Move, "V", "first person, or behind the character"),
    (Group::Move, "F", "open or close the door in front"),
    (Group::Go, "T", "type a position, coordinates or name"),
    (Group::Go, "M", "map: click a place, zoom by the wheel"),
    (Group::Go, "Home", "back to where you began"),
    (Group::Go, "[ ]", "earlier, later in the day"),
    (Group::Why, "click", "what is this, and through which portals?"),
    (Group::Why, "1", "cell outlines"),
    (Group::Why, "2", "portals, passed or refused and why"),
    (Group::Why, "3", "clip regions"),
    (Group::Why, "4", "collision polygons"),
    (Group::Why, "5", "stab list"),
    (Group::Why, "G", "hold the traversal, fly out (Space up, C down)"),
    (Group::Why, "O, P", "draw one cell only; draw everything near"),
    (Group::Window, "Tab", "panels"),
    (Group::Window, "F2", "save the picture"),
    (Group::Window, "H or F1, Esc", "these keys; close, then leave"),
];

/// The keys as text, for `--help`.
pub fn keys_help() -> String {
    let mut out = String::from("Keys:\n");
    for group in Group::ALL {
        // Writing to a string does not fail.
        let _ = writeln!(out, "  {}:", group.name());
        for (_, keys, what) in KEYS.iter().filter(|k| k.0 == group) {
            let _ = writeln!(out, "    {keys:<16} {what}");
        }
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
        "F2" => Action::Screenshot,
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
        for (_, keys, what) in KEYS {
            assert!(help.contains(keys) && help.contains(what));
        }
        assert!(help.lines().all(|line| line.len() < 90));
    }

    /// Names of keys as the window hears them, and as the list shows them.
    fn every_key() -> impl Iterator<Item = (String, String)> {
        let typed = ('a'..='z').map(|c| (c.to_string(), c.to_uppercase().to_string()));
        let signs = "0123456789[]-=;',./"
            .chars()
            .map(|c| (c.to_string(), c.to_string()));
        let function = (1..=12).map(|k| (format!("F{k}"), format!("F{k}")));
        let named = [
            ("ArrowUp", "up"),
            ("ArrowDown", "down"),
            ("ArrowLeft", "left"),
            ("ArrowRight", "right"),
            ("Escape", "Esc"),
            ("Shift", "Shift"),
            ("Space", "Space"),
            ("Home", "Home"),
            ("Tab", "Tab"),
            ("End", "End"),
            ("Enter", "Enter"),
        ];
        let named = named.map(|(name, shown)| (name.to_owned(), shown.to_owned()));
        typed.chain(signs).chain(function).chain(named)
    }

    fn is_used(key: &str) -> bool {
        action(key).is_some() || Held::default().set(key, true)
    }

    /// Keys that the first column names, and those in brackets of the second.
    fn listed() -> Vec<String> {
        let split = |text: &str| -> Vec<String> {
            let words = text.split([' ', ',', '(', ')']);
            words.map(str::to_owned).filter(|w| !w.is_empty()).collect()
        };
        let mut all = Vec::new();
        for (_, keys, what) in KEYS {
            all.extend(split(keys));
            if let Some((_, held)) = what.split_once('(') {
                all.extend(split(held));
            }
        }
        all
    }

    #[test]
    fn what_is_listed_is_what_works() {
        let listed = listed();
        for (key, shown) in every_key() {
            assert_eq!(is_used(&key), listed.contains(&shown), "{key}, shown as {shown}");
        }
    }

    #[test]
    fn the_readme_lists_the_same_keys() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../README.md");
        let Ok(readme) = std::fs::read_to_string(path) else {
            // A crate by itself has no README of the workspace.
            return;
        };
        let begin = readme.find("| key | |").expect("a table of keys");
        let table = readme[begin..].split("\n\n").next().unwrap_or_default();
        let words: Vec<&str> = table.split([' ', ',', '|', '\n', '(', ')']).collect();
        for (key, shown) in every_key() {
            // Arrows are called so; F1 is another H.
            let shown = if key.starts_with("Arrow") {
                "arrows"
            } else {
                &shown
            };
            if is_used(&key) && key != "F1" {
                assert!(words.contains(&shown), "{shown} is not in README.md");
            }
        }
    }
}
