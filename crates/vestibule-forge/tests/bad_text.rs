//! Scenes that make no sense give messages, never a panic.

use vestibule_forge::{EMBEDDED_SCENE, compile_scene};

mod common;
use common::random::Random;

/// Damages a text: words swapped, dropped, doubled, numbers made huge, characters changed.
fn damaged(text: &str, random: &mut Random) -> String {
    let mut next = |limit: usize| random.below(limit);
    let mut words: Vec<&str> = text.split_inclusive([' ', '\n']).collect();
    let odd = [
        "(0 0 0) ", "1e300 ", "-1e-300 ", "~ ", "{\n", "}\n", "( ", ") ", "\" ", "0x ", "0xFFFF ", "é ",
        "; ", "room ", "box ",
    ];
    for _ in 0..1 + next(6) {
        let at = next(words.len());
        match next(5) {
            0 => drop(words.remove(at)),
            1 => words.insert(at, words[at]),
            2 => words[at] = odd[next(odd.len())],
            3 => {
                let other = next(words.len());
                words.swap(at, other);
            }
            _ => words.insert(at, odd[next(odd.len())]),
        }
        if words.is_empty() {
            break;
        }
    }
    words.concat()
}

#[test]
fn damaged_scenes_never_panic() {
    let small = "land 0x8080 0x8080\nheights 1\nterrain { base 10; hill (20 20) 30 8; paint grassland everywhere; road (0 0) (24 48) }
        material m bricks color 10 20 30 size 2
        model c { column (0 0 0) 0.3 1 6 m; collide cylinder 0.3 1; light (0 0 1) 1 2 3 4 5 }
        static c at (3 3 ~0) turn 20
        scatter c 5 (0 0) (50 50) clear 1
        shape s { box (0 0 0) (4 4 3); stairs (1 1 0) (2 3 1) north 3 }
        building h at (12 12 ~0.1) turn 30 { shell { box (-4 -4 -1) (4 4 4) m top m }
            room a { prism z 0 3 (-3 -4) (3 -4) (3 3) (0 1) (-3 3); block { wedge (0 0 0) (1 1 1) east }; walls m }
            room b like s at (-1.5 -3.9 -5) turn 90 { floor m }
            exit a rect (-1 -4 0) (1 -4 2); static c in a at (0 -1 0) }
        dungeon d 0x0101 { room x id 0x0100 { box (0 0 0) (4 4 3) } room y { poly (4 0 0) (4 4 0) (8 2 1)
            poly (4 0 0) (4 0 3) (4 4 3) (4 4 0); ramp (4 0 0) (6 4 1) east 2 } opening x y; portal x y; window x }
        start in d x at (1 1 0)\n";
    let mut random = Random(7);
    let mut compiled = 0;
    for _ in 0..3000 {
        let text = damaged(small, &mut random);
        compiled += usize::from(compile_scene("damaged.scene", &text).is_ok());
    }
    assert!(compiled < 3000);
    let thing = EMBEDDED_SCENE[3].1;
    for _ in 0..60 {
        let _ = compile_scene("damaged.scene", &damaged(thing, &mut random));
    }
}
