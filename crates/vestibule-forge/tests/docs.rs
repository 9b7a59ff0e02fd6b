//! The examples of the language's description compile.

const TEXT: &str = include_str!("../docs/scenes.md");

fn blocks() -> impl Iterator<Item = &'static str> {
    TEXT.split("```text\n")
        .skip(1)
        .filter_map(|rest| rest.split_once("```").map(|(block, _)| block))
}

#[test]
fn the_first_example_compiles_without_warnings() {
    let text = blocks().next().unwrap();
    let world = vestibule_forge::compile_scene("scenes.md", text).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(world.warnings, []);
    assert_eq!((world.stats.cells, world.stats.buildings), (2, 1));
    assert!(world.start.is_some());
}

#[test]
fn the_other_examples_compile_with_what_they_leave_out() {
    for text in blocks().skip(1) {
        let text = format!(
            "land 0x8080 0x8080\nmaterial boards planks color 1 2 3\nmaterial iron grain color 1 2 3
             material flame glow color 1 2 3\nmodel tree {{ cone (0 0 0) 1 3 }}\n{text}"
        );
        let world = vestibule_forge::compile_scene("scenes.md", &text).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(world.warnings, []);
    }
}

#[test]
fn every_pattern_and_statement_is_described() {
    for word in [
        "opening", "portal", "exit", "window", "static", "door", "shell", "room", "block", "stairs",
        "scatter", "start", "wedge", "ramp", "hull", "prism", "column", "cone", "ball", "poly", "rect",
        "floor", "walls", "ceiling", "collide", "light", "level", "ridge", "bowl", "noise", "paint", "road",
        "heights", "beams", "shingles", "cobbles",
    ] {
        assert!(
            TEXT.contains(&format!("`{word}"))
                || TEXT.lines().any(|l| l.trim().starts_with(&format!("{word} "))),
            "{word}"
        );
    }
}
