//! Pictures: render, the filmstrip and the film of a tour.

mod support;

use std::path::Path;

use support::Sandbox;

/// Width and height, and the stored pixels, four bytes each.
fn decode(path: &Path) -> (u32, u32, Vec<[u8; 4]>) {
    let bytes = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(bytes).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgba);
    let pixels = pixels.as_chunks::<4>().0.to_vec();
    (info.width, info.height, pixels)
}

const DOORWAY: &str = "0xA9B40101 [156.4 12.9 95.7]";

#[test]
fn render_draws_a_player_from_behind() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&[
            "render",
            "0xA9B40031 [155.4 22 94.1] 0 0 0 1",
            "--size",
            "160x120",
            "-o",
            "door.png",
            "--cpu",
        ])
        .ok()
        .shows(&["player   0xA9B40031", "eye      0xA9B4003", "written door.png"]);
    let (w, h, pixels) = decode(&sandbox.join("door.png"));
    assert_eq!((w, h), (160, 120));
    // The blue coat in the middle.
    let coat = pixels
        .iter()
        .filter(|[r, _, b, _]| *b > 60 && *b as i32 > *r as i32 + 40)
        .count();
    assert!(coat > 50, "{coat}");
    let leftovers = std::fs::read_dir(sandbox.path()).unwrap().count();
    assert_eq!(leftovers, 1, "nothing but the picture");
}

#[test]
fn render_ids_are_the_low_24_bits_of_the_cell() {
    let sandbox = Sandbox::new();
    let args = [
        "render",
        "--eye",
        DOORWAY,
        "--look=-0.2,1,0",
        "--size",
        "120x90",
        "--ids",
        "-o",
        "ids.png",
    ];
    let json = sandbox.run(&[&args[..], &["--json"]].concat()).ok().json();
    let (_, _, pixels) = decode(&sandbox.join("ids.png"));
    let count = |id: u32| {
        let color = [(id >> 16) as u8, (id >> 8) as u8, id as u8, 255];
        pixels.iter().filter(|p| **p == color).count()
    };
    for (cell, low) in [("0xA9B40101", 0xB4_0101), ("0xA9B40100", 0xB4_0100)] {
        let listed = json["cells"]
            .as_array()
            .unwrap()
            .iter()
            .find(|c| c["cell"] == cell)
            .unwrap();
        assert_eq!(listed["pixels"], count(low), "{cell}");
        assert!(count(low) > 20, "{cell}");
    }
    assert!(count(0xFF_FFFF) > 5, "sky through the door");
    assert_eq!(count(0), 0, "no pixel keeps the clear colour");
    assert_eq!(json["clear_pixels"], 0);
}

#[test]
fn in_sealed_rooms_everything_at_once_is_the_same_picture() {
    let sandbox = Sandbox::new();
    let args = [
        "render",
        "--eye",
        "0x01070100 [60 -80 -18.2]",
        "--look=1,0.1,0",
        "--size",
        "120x90",
        "--ids",
    ];
    sandbox.run(&[&args[..], &["-o", "a.png"]].concat()).ok();
    sandbox
        .run(&[&args[..], &["-o", "b.png", "--everything"]].concat())
        .ok();
    assert_eq!(decode(&sandbox.join("a.png")), decode(&sandbox.join("b.png")));
}

#[test]
fn the_time_of_day_and_the_angle_of_view_show() {
    let sandbox = Sandbox::new();
    let shot = |name: &str, more: &[&str]| {
        let args = [
            "render",
            "--eye",
            DOORWAY,
            "--look=-0.2,1,0",
            "--size",
            "80x60",
            "-o",
            name,
        ];
        sandbox.run(&[&args[..], more].concat()).ok();
        decode(&sandbox.join(name)).2
    };
    let noon = shot("noon.png", &[]);
    assert_eq!(noon, shot("again.png", &["--time", "0.5"]), "the same every time");
    assert_ne!(noon, shot("night.png", &["--time", "0.95"]));
    assert_ne!(noon, shot("wide.png", &["--fov", "120"]));
}

#[test]
fn pictures_that_cannot_be_made_say_why_and_what_to_do() {
    let sandbox = Sandbox::new();
    let place = "0xA9B40031 [155.4 22 94.1]";
    for (args, code, wanted) in [
        (
            &["render", place, "--size", "0x5"][..],
            2,
            "a picture without pixels",
        ),
        (
            &["render", place, "--size", "99999x5"],
            2,
            "too large; write a size as 1280x720",
        ),
        (&["render", place, "--size", "big"], 2, "write a size as 1280x720"),
        (&["render", place, "--fov", "180"], 2, "between 0 and 180"),
        (&["render", place, "--time", "7"], 2, "goes from 0 to 1"),
        (
            &["render", "0xA9B40999 [1 2 94]"],
            1,
            "there is no cell 0xA9B40999",
        ),
        (
            &["render", "--eye", "0xA9B40999 [1 2 94]", "--look", "0,1,0"],
            1,
            "there is no cell 0xA9B40999",
        ),
        (
            &["render", "--eye", "0xA9B40031 [155.4 24 80]", "--look", "0,1,0"],
            1,
            "m under the ground",
        ),
        (
            &["render", "--eye", "0x01070100 [200 -80 -18]", "--look", "0,1,0"],
            1,
            "the eye is in no cell",
        ),
        (&["render", "0xA9B40101 [155 10 80]"], 1, "nobody can stand at"),
        (&["render", "--eye", place, "--look", "0,0,0"], 2, "not all zero"),
        (&["render", "--eye", place], 2, "--look"),
        (&["render"], 2, "<POS>"),
        (&["render", place, "-o", "x.jpg"], 2, "hint: name it x.png"),
        (&["tour", "--film", "x.gif"], 2, "hint: name it x.png"),
        (
            &["render", place, "-o", "nowhere/x.png"],
            1,
            "there is no folder nowhere",
        ),
    ] {
        let ran = sandbox.run(args).fails(code).says(&[wanted]);
        assert!(ran.err.starts_with("error: "), "{}", ran.err);
    }
    assert_eq!(
        std::fs::read_dir(sandbox.path()).unwrap().count(),
        0,
        "nothing was left behind"
    );
}

#[test]
fn a_tour_draws_its_thresholds_and_a_film() {
    let sandbox = Sandbox::new();
    // Indoors with little to walk: the dungeon.
    let args = [
        "tour",
        "--start",
        "0x01070106 [83.9 -56.1 -20]",
        "--stand",
        "1",
        "--no-trials",
    ];
    let more = ["--film", "film.png", "--film-size", "32x24"];
    sandbox
        .run(&[&args[..], &more].concat())
        .ok()
        .shows(&["written tour/filmstrip.png", "written film.png"]);
    let (w, h, pixels) = decode(&sandbox.join("tour/filmstrip.png"));
    // Nine openings join its ten cells; two thresholds a row, three pictures each.
    assert!(w > 1200 && h > 5 * 150, "{w} x {h}");
    let colours: std::collections::BTreeSet<_> = pixels.iter().collect();
    assert!(colours.len() > 1000, "{}", colours.len());
    let film = std::fs::read(sandbox.join("film.png")).unwrap();
    assert!(film.windows(4).any(|w| w == b"acTL"), "it is animated");
}

/// The pictures of the documentation are made by the commands that stand beside them.
#[test]
fn the_commands_beside_the_pictures_of_the_documentation_make_them() {
    let sandbox = Sandbox::new();
    let folder = Path::new(support::REPOSITORY).join("docs/pictures");
    let Ok(text) = std::fs::read_to_string(folder.join("README.md")) else {
        // The crate by itself has no pictures of the workspace.
        return;
    };
    std::fs::create_dir_all(sandbox.join("docs/pictures")).unwrap();
    let commands: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("    vestibule "))
        .collect();
    assert!(commands.len() >= 7);
    for command in &commands {
        let (_, file) = command.rsplit_once(" -o ").unwrap();
        sandbox.shell(&format!("vestibule {command}")).ok();
        let kept = folder.join(file.rsplit('/').next().unwrap());
        assert!(
            kept.metadata().unwrap().len() < 150_000,
            "{file} is too large for a page"
        );
        if file.ends_with(".png") {
            let (made, kept) = (decode(&sandbox.join(file)), decode(&kept));
            assert_eq!((made.0, made.1), (kept.0, kept.1), "{file}");
        }
    }
    // Every picture is shown, and none is left over; those of the window are not made by a command.
    for entry in std::fs::read_dir(&folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let shown =
            name == "README.md" || name.starts_with("explore") || text.contains(&format!("![]({name})"));
        assert!(shown, "{name}");
    }
}
