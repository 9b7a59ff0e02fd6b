//! Every message has a scene that triggers it, in `messages.txt`: scenes and, after a line `---`, what the compiler
//! says. Run with `BLESS=1` to write the messages as they are now.

use std::fmt::Write;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/messages.txt");

fn says(scene: &str) -> String {
    let (kind, diagnostics) = match vestibule_forge::compile_scene("test.scene", scene) {
        Ok(world) => ("compiles", world.warnings),
        Err(errors) => ("does not compile", errors.0),
    };
    let mut out = format!("{kind}\n");
    for diagnostic in diagnostics {
        writeln!(out, "{diagnostic}").unwrap();
    }
    out
}

#[test]
fn every_message_is_triggered_by_its_scene() {
    let text = std::fs::read_to_string(FILE).unwrap();
    let bless = std::env::var_os("BLESS").is_some();
    let (mut blessed, mut wrong) = (String::new(), Vec::new());
    for case in text.split("=== ").skip(1) {
        let (name, rest) = case.split_once('\n').unwrap();
        let (scene, expected) = rest.split_once("---\n").unwrap();
        let found = says(scene);
        if found.trim() != expected.trim() {
            wrong.push(format!("{name}:\n{found}\nexpected:\n{expected}"));
        }
        write!(blessed, "=== {name}\n{scene}---\n{found}\n").unwrap();
    }
    if bless {
        std::fs::write(FILE, blessed).unwrap();
    } else {
        assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    }
}

/// Each way of reporting in the sources is used by some scene, by the first words of its message.
#[test]
fn no_message_is_untested() {
    let text = std::fs::read_to_string(FILE).unwrap();
    for message in [
        "overlap",
        "a one-way portal",
        "do not touch here",
        "of this opening lies in a wall",
        "has a hole",
        "this polygon faces out of room",
        "face outwards",
        "is outside of 0x0100 to 0xFFFD",
        "is taken",
        "leaves a gap",
        "the building's portal has no polygon",
        "has no shell for its exits",
        "of this exit lies in a wall",
        "does not lie in a wall",
        "has no opening",
        "reaches",
        "above the sill of the exit",
        "too high to step in",
        "stands on the same land cell",
        "stands outside the land",
        "stands outside of room",
        "lies exactly 12 m",
        "has no room",
        "there is no material",
        "there is no model",
        "there is no shape",
        "there is no pattern",
        "there is no terrain type",
        "unknown statement",
        "never closed",
        "is flat",
        "is not convex",
        "do not lie in one plane",
        "crosses itself",
        "has no shape",
        "too steep to walk",
        "leaves the land",
        "is not a number",
        "needs a point",
        "leads from a room to itself",
        "a second room named",
        "a second site named",
    ] {
        assert!(text.contains(message), "no scene for: {message}");
    }
}
