//! What each subcommand does when all is well.

mod support;

use support::Sandbox;

#[test]
fn where_names_the_cell_its_neighbours_and_the_ground() {
    let sandbox = Sandbox::new();
    let text = sandbox.run(&["where", "0xA9B40101 [155.4 14.2 94.005]"]).ok();
    text.shows(&[
        "0xA9B40101, env cell",
        "sees the outside",
        "0xA9B40100",
        "portal",
        "ground",
        "water",
    ]);
    let json = sandbox
        .run(&["where", "0xA9B40031 [155.5 24 94]", "--json"])
        .ok()
        .json();
    // y = 24 is the next land cell's.
    assert_eq!(json["placed_in"]["cell"], "0xA9B40032");
    let by_map = sandbox.run(&["where", "42.1N,", "33.6E", "--json"]).ok().json();
    assert_eq!(by_map["map"], "42.1N, 33.6E");
    assert_eq!(by_map["ground"]["above"], 0.0);
}

#[test]
fn a_position_need_not_be_in_quotes() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&["where", "0xA9B40101", "[155.4", "14.2", "94.005]"])
        .ok()
        .shows(&["0xA9B40101, env cell"]);
}

#[test]
fn inspect_shows_fields_bytes_and_json() {
    let sandbox = Sandbox::new();
    sandbox.run(&["inspect", "0xA9B40100"]).ok().shows(&[
        "EnvCell 0xA9B40100",
        "the landscape can be seen from here",
        "to the outside",
        "environment  0x0D",
        "frame        [161.929 7.50315 94]",
    ]);
    let json = sandbox.run(&["inspect", "A9B4FFFE", "--json"]).ok().json();
    assert_eq!(json["type"], "LandBlockInfo");
    assert_eq!(json["record"]["id"], "0xA9B4FFFE");
    assert!(json["record"]["buildings"].as_array().unwrap().len() >= 4);
    sandbox
        .run(&["inspect", "0x13000000"])
        .ok()
        .shows(&["Region", "land_height_table (256)"]);
    sandbox
        .run(&["inspect", "0xA9B40100", "--hex"])
        .ok()
        .shows(&["000000  00 01 b4 a9"]);
    let hex = sandbox
        .run(&["inspect", "0xA9B40100", "--hex", "--json"])
        .ok()
        .json();
    assert!(hex["hex"].as_str().unwrap().starts_with("0001b4a9"));
}

#[test]
fn ls_counts_types_and_lists_records() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&["ls"])
        .ok()
        .shows(&["LandBlockInfo", "EnvCell", "records in the embedded world"]);
    let json = sandbox.run(&["ls", "--json"]).ok().json();
    let cells = sandbox.run(&["ls", "envcell", "--json"]).ok().json();
    let of_type = |name: &str| {
        json["types"]
            .as_array()
            .unwrap()
            .iter()
            .find(|t| t["type"] == name)
            .unwrap()["records"]
            .as_u64()
            .unwrap()
    };
    assert_eq!(cells["records"], of_type("EnvCell"));
    assert_eq!(cells["list"].as_array().unwrap().len() as u64, of_type("EnvCell"));
    sandbox
        .run(&["ls", "--block", "A9B4", "--limit", "2"])
        .ok()
        .shows(&["0xA9B40100", "... and "]);
}

#[test]
fn refs_finds_users_and_what_is_used() {
    let sandbox = Sandbox::new();
    let json = sandbox.run(&["refs", "0xA9B40101", "--json"]).ok().json();
    let users = json["used_by"].as_array().unwrap();
    assert!(
        users
            .iter()
            .any(|u| u["id"] == "0xA9B40100" && u["fields"].to_string().contains("other_cell_id"))
    );
    assert!(users.iter().any(|u| u["id"] == "0xA9B4FFFE"));
    assert!(
        json["uses"]
            .as_array()
            .unwrap()
            .iter()
            .any(|u| u["field"] == "environment")
    );
    // The same number in the portal file is another record.
    sandbox
        .run(&["refs", "0x0D000001"])
        .ok()
        .shows(&["Environment 0x0D000001 is used by"]);
}

#[test]
fn map_draws_land_levels_and_trail() {
    let sandbox = Sandbox::new();
    sandbox.run(&["tour", "--out", "t", "--no-pictures"]).ok();
    sandbox
        .run(&["map", "A9B4", "--trail", "t/trail.jsonl", "-o", "m.svg"])
        .ok()
        .shows(&["written m.svg"]);
    let svg = sandbox.read("m.svg");
    assert_eq!(svg, sandbox.read("t/map.svg"), "the tour's own map is the same");
    for part in [
        "Landblock 0xA9B4",
        "Land: ",
        "Level 1 of",
        ">0100<",
        "class=\"ex\"",
        "class=\"po\"",
        "class=\"st\"",
        "class=\"tr\"",
    ] {
        assert!(svg.contains(part), "{part}");
    }
    let piped = sandbox.run(&["map", "0xA9B40100"]).ok();
    assert!(piped.out.starts_with("<svg") && piped.out.ends_with("</svg>\n"));
}

#[test]
fn build_writes_the_same_bytes_twice_and_they_verify() {
    let sandbox = Sandbox::new();
    let (a, b) = (sandbox.build_world("a"), sandbox.build_world("b"));
    for name in ["client_portal.dat", "client_cell_1.dat"] {
        assert_eq!(
            std::fs::read(a.join(name)).unwrap(),
            std::fs::read(b.join(name)).unwrap(),
            "{name}"
        );
    }
    sandbox.run(&["dat", "verify", "a"]).ok().shows(&["100.00 %"]);
    sandbox
        .run(&["dat", "diff", "a", "b"])
        .ok()
        .shows(&["records are the same"]);
}

#[test]
fn the_embedded_world_is_the_scene_in_the_repository() {
    let sandbox = Sandbox::new();
    sandbox.build_world("built");
    let embedded = sandbox.run(&["ls", "--json"]).ok().json();
    let built = sandbox.run(&["ls", "--json", "--dat", "built"]).ok().json();
    assert_eq!(embedded, built);
}

#[test]
fn dat_diff_names_what_changed() {
    let sandbox = Sandbox::new();
    sandbox.build_world("a");
    let b = sandbox.build_world("b");
    // One height byte of a landblock.
    let path = b.join("client_cell_1.dat");
    let mut bytes = std::fs::read(&path).unwrap();
    let id = 0xA9B4_FFFFu32.to_le_bytes();
    let record = bytes
        .windows(8)
        .position(|w| w[..4] == id && w[4..] == 1u32.to_le_bytes())
        .unwrap();
    bytes[record + 8 + 162] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let ran = sandbox.run(&["dat", "diff", "a", "b"]).fails(1);
    ran.shows(&["changed  0xA9B4FFFF  LandBlock", "1 changed, 0 added, 0 removed"]);
}

#[test]
fn dat_extract_writes_a_record_as_it_is() {
    let sandbox = Sandbox::new();
    let piped = sandbox.run(&["dat", "extract", "0x06000001"]).ok();
    sandbox
        .run(&["dat", "extract", "0x06000001", "-o", "one.bin"])
        .ok();
    assert_eq!(std::fs::read(sandbox.join("one.bin")).unwrap(), piped.bytes);
    sandbox
        .run(&["dat", "extract", "--all", "--type", "EnvCell", "-o", "all"])
        .ok();
    let cell = std::fs::read(sandbox.join("all/cell/A9B40100.EnvCell")).unwrap();
    assert_eq!(cell[..4], [0, 1, 0xB4, 0xA9]);
}

#[test]
fn visible_lists_cells_and_draws_the_screen() {
    let sandbox = Sandbox::new();
    let eye = "0xA9B40101 [155 10 95.5]";
    let json = sandbox
        .run(&[
            "visible", "--eye", eye, "--look", "0,1,0", "--json", "-o", "v.svg",
        ])
        .ok()
        .json();
    assert_eq!(json["cell"], "0xA9B40101");
    assert_eq!(json["path"], "SeesOut");
    let cells = json["cells"].as_array().unwrap();
    assert!(
        cells.iter().any(|c| c["cell"] == "0xA9B40100"),
        "the vestibule is in view"
    );
    assert!(
        !json["outside"].as_array().unwrap().is_empty(),
        "so is the outside through it"
    );
    assert!(sandbox.read("v.svg").contains(">0100<"));
    sandbox
        .run(&["visible", "--eye", eye, "--look", "0,-1,0.1"])
        .ok()
        .shows(&["frame", "0xA9B40101"]);
}

#[test]
fn walk_goes_to_a_target_and_replay_agrees() {
    let sandbox = Sandbox::new();
    let (from, to) = ("0xA9B40031 [155.5 24 94.1]", "0xA9B40101 [155.4 14.2 94.1]");
    sandbox
        .run(&["walk", "--from", from, "--to", to, "-o", "w.jsonl"])
        .ok()
        .shows(&["end 0xA9B40101"]);
    sandbox.run(&["replay", "w.jsonl"]).ok().shows(&["rows agree"]);
    // A row that is not right is reported with its line.
    let mut lines: Vec<String> = sandbox.read("w.jsonl").lines().map(str::to_owned).collect();
    let wrong = lines.len() - 3;
    lines[wrong] = lines[wrong].replace("0xA9B40101", "0xA9B40031");
    sandbox.write("wrong.jsonl", lines.join("\n"));
    let json = sandbox.run(&["replay", "wrong.jsonl", "--json"]).fails(1).json();
    assert_eq!(json["differences"][0]["line"], wrong + 1);
    assert_eq!(json["differences"][0]["found"], "0xA9B40101");
}

#[test]
fn walk_follows_a_script() {
    let sandbox = Sandbox::new();
    let from = "0xA9B40031 [155.5 26 94.1]";
    let script = "walk 2 # north\nturn 180\nrun 6\njump 1\nwait 0.5\n";
    let ran = sandbox
        .run_with(&["walk", "--from", from, "--script", "-"], script)
        .ok();
    let rows: Vec<serde_json::Value> = ran
        .out
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    let y = |row: &serde_json::Value| row["pos"][1].as_f64().unwrap();
    let furthest = rows.iter().map(y).fold(0.0, f64::max);
    assert!((27.9..28.6).contains(&furthest), "two metres north: {furthest}");
    assert!(y(rows.last().unwrap()) < 23.0, "and back");
    let top = rows
        .iter()
        .map(|r| r["pos"][2].as_f64().unwrap())
        .fold(0.0, f64::max);
    assert!(top > 94.2, "it jumped: {top}");
}

#[test]
fn bench_prints_its_figures() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&["bench", "view", "--eyes", "20", "--rounds", "2"])
        .ok()
        .shows(&["us per traversal", "cells seen"]);
    let Some(vectors) = support::vectors("bench_prints_its_figures") else {
        return;
    };
    let vectors = vectors.display().to_string();
    let args = [
        "bench",
        "sweep",
        "--vectors",
        &vectors,
        "--world",
        "cottage-1",
        "-n",
        "25000",
        "--json",
    ];
    let json = sandbox.run(&args).ok().json();
    assert_eq!(json["steps"], 25_000);
    let share = |name: &str| json[name].as_f64().unwrap();
    assert!(
        (0.07..=0.10).contains(&share("collided")) && (0.009..=0.012).contains(&share("changed_cell")),
        "{json}"
    );
}

#[test]
fn a_folder_can_be_given_by_the_environment() {
    let sandbox = Sandbox::new();
    sandbox.build_world("mine");
    sandbox
        .shell("VESTIBULE_DAT=mine vestibule ls")
        .ok()
        .shows(&["records in mine"]);
    // The option wins, and an empty variable is none.
    sandbox
        .shell("VESTIBULE_DAT=nowhere vestibule ls --dat mine")
        .ok();
    sandbox
        .shell("VESTIBULE_DAT= vestibule ls")
        .ok()
        .shows(&["the embedded world"]);
}

#[test]
fn names_of_files_are_matched_without_regard_to_case() {
    let sandbox = Sandbox::new();
    let dir = sandbox.build_world("mine");
    std::fs::rename(dir.join("client_portal.dat"), dir.join("Client_Portal.DAT")).unwrap();
    sandbox.run(&["ls", "--dat", "mine"]).ok();
}

#[test]
fn a_broken_pipe_is_no_error() {
    let sandbox = Sandbox::new();
    let ran =
        sandbox.shell("vestibule inspect 0x0D000001 --all | head -1; vestibule ls --limit 999 | head -1");
    ran.ok().shows(&["Environment 0x0D000001"]);
}

#[test]
fn no_colours_where_there_is_no_terminal() {
    let sandbox = Sandbox::new();
    for args in [
        &["where", "0xA9B40101 [155.4 14.2 94]"][..],
        &["ls"],
        &["inspect", "0xA9B40100"],
        &["--help"],
    ] {
        assert!(!sandbox.run(args).ok().out.contains('\u{1b}'), "{args:?}");
    }
}

#[test]
fn a_synthetic_world_is_summed_up_and_the_same_every_time() {
    let sandbox = Sandbox::new();
    let build = |seed: &str, out: &str| {
        let args = [
            "build",
            "--synthetic",
            "small",
            "--seed",
            seed,
            "--out",
            out,
            "--json",
        ];
        sandbox.run(&args).ok().json()
    };
    let (a, _, other) = (build("7", "a"), build("7", "b"), build("8", "c"));
    assert_eq!(a["landblocks"], 144);
    assert_eq!(a["env_cells"], 3000);
    assert_eq!(a["buildings"], 40);
    let cell = |folder: &str| std::fs::read(sandbox.join(folder).join("client_cell_1.dat")).unwrap();
    assert_eq!(a["files"][0]["bytes"], cell("a").len());
    assert_eq!(cell("a"), cell("b"));
    assert_ne!(cell("a"), cell("c"));
    assert_eq!(other["env_cells"], 3000, "{other}");
    // Nothing is left of the folder it was built in, and the world can be used.
    let names: Vec<_> = std::fs::read_dir(sandbox.path())
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(names.len(), 3, "{names:?}");
    sandbox.run(&["dat", "verify", "a"]).ok();
    sandbox
        .run(&["build", "--synthetic", "small", "--seed", "7", "--out", "a"])
        .ok()
        .shows(&["env cells", "3,000", "client_cell_1.dat", "written to a"]);
}

#[test]
fn bench_render_times_pictures() {
    let sandbox = Sandbox::new();
    let json = sandbox
        .run(&["bench", "render", "--size", "40x30", "--eyes", "3", "--json"])
        .ok()
        .json();
    let groups = json["groups"].as_array().unwrap();
    assert_eq!(groups.len(), 2);
    assert!(
        groups.iter().all(|g| g["median_ms"].as_f64().unwrap() > 0.0),
        "{json}"
    );
    // What frames cost on the graphics card, or why that is not known.
    match json["gpu"]["views"].as_array() {
        Some(views) => {
            assert_eq!(views.len(), 4);
            let positive = |v: &serde_json::Value, key: &str| v[key].as_f64().unwrap() > 0.0;
            for key in [
                "processor_ms",
                "traversal_ms",
                "draws",
                "frames_per_second",
                "everything_ms",
            ] {
                assert!(views.iter().all(|v| positive(v, key)), "{key}: {json}");
            }
        }
        None => assert!(!json["no_gpu"].as_str().unwrap().is_empty(), "{json}"),
    }
    let plain = sandbox.run(&["bench", "render", "--size", "40x30", "--eyes", "1", "--cpu"]);
    plain.ok().shows(&["on the processor", "indoors"]);
}

#[test]
fn render_says_what_drew() {
    let sandbox = Sandbox::new();
    let place = "0xA9B40031 [155.4 22 94.1]";
    let render = |more: &[&str]| {
        let args = ["render", place, "--size", "48x32", "--json", "-o", "a.png"];
        sandbox.run(&[&args[..], more].concat()).ok().json()
    };
    let (any, cpu) = (render(&[]), render(&["--cpu"]));
    assert_eq!(cpu["renderer"], "cpu");
    assert!(cpu["adapter"].is_null());
    assert_eq!(any["renderer"] == "gpu", any["adapter"].is_string(), "{any}");
    assert_eq!(
        render(&["--ids"])["renderer"],
        "cpu",
        "ids are told by the reference"
    );
}
