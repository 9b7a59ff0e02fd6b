//! What the command says to input that is wrong: an error that names the place, no panic, the right exit code.

mod support;

use std::path::Path;

use support::Sandbox;

#[test]
fn a_folder_that_is_missing_or_lacks_files() {
    let sandbox = Sandbox::new();
    sandbox.run(&["ls", "--dat", "nowhere"]).fails(1).says(&[
        "nowhere",
        "No such file",
        "hint:",
        "installation",
    ]);
    std::fs::create_dir(sandbox.join("empty")).unwrap();
    sandbox
        .run(&["ls", "--dat", "empty"])
        .fails(1)
        .says(&["client_portal.dat", "hint:"]);
}

fn damage(dir: &Path, file: &str, change: impl FnOnce(&mut Vec<u8>)) {
    let path = dir.join(file);
    let mut bytes = std::fs::read(&path).unwrap();
    change(&mut bytes);
    std::fs::write(&path, bytes).unwrap();
}

const CELL: &str = "client_cell_1.dat";
const PORTAL: &str = "client_portal.dat";

#[test]
fn an_empty_truncated_or_random_file_is_named_with_the_offset() {
    let sandbox = Sandbox::new();
    let dir = sandbox.build_world("w");
    damage(&dir, CELL, Vec::clear);
    sandbox
        .run(&["ls", "--dat", "w"])
        .fails(1)
        .says(&[CELL, "0 bytes where 400 are needed"]);
    let dir = sandbox.build_world("w");
    damage(&dir, CELL, |bytes| bytes.truncate(5000));
    sandbox
        .run(&["ls", "--dat", "w"])
        .fails(1)
        .says(&[CELL, "5000 bytes", "at byte 0x148"]);
    let dir = sandbox.build_world("w");
    damage(&dir, PORTAL, |bytes| {
        let mut state = 1u32;
        for byte in bytes.iter_mut() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *byte = (state >> 24) as u8;
        }
    });
    sandbox
        .run(&["tour", "--dat", "w"])
        .fails(1)
        .says(&[PORTAL, "not a DAT file", "at byte 0x140"]);
}

#[test]
fn the_wrong_one_of_the_four_files_is_told() {
    let sandbox = Sandbox::new();
    let dir = sandbox.build_world("w");
    std::fs::copy(dir.join(CELL), dir.join(PORTAL)).unwrap();
    sandbox
        .run(&["ls", "--dat", "w"])
        .fails(1)
        .says(&["this is a cell file, a portal file was expected", PORTAL]);
}

/// Where a record's bytes lie in a file: its directory entry's offset and size, found by its id.
fn entry_of(bytes: &[u8], id: u32) -> usize {
    let id = id.to_le_bytes();
    // flags and version, id, offset, size, date, iteration
    (0..bytes.len() - 24)
        .find(|&at| bytes[at..at + 4] == [0, 0, 2, 0] && bytes[at + 4..at + 8] == id)
        .expect("the record is in the directory")
}

#[test]
fn a_node_that_points_outside_leaves_other_records_usable() {
    let sandbox = Sandbox::new();
    let dir = sandbox.build_world("w");
    damage(&dir, CELL, |bytes| {
        let at = entry_of(bytes, 0xA9B4_0100) + 8;
        bytes[at..at + 4].copy_from_slice(&0x7FFF_FFF0u32.to_le_bytes());
    });
    sandbox
        .run(&["inspect", "0xA9B40100", "--dat", "w"])
        .fails(1)
        .says(&["record 0xA9B40100", CELL, "outside"]);
    sandbox.run(&["inspect", "0xA9B40101", "--dat", "w"]).ok();
    sandbox
        .run(&["dat", "verify", "w"])
        .fails(1)
        .shows(&["problem: record 0xA9B40100", "cell"]);
    // The rest of the world can still be walked; what is missing is said.
    let tour = sandbox.run(&["tour", "--dat", "w", "--stand", "2", "--no-pictures"]);
    assert_eq!(tour.code, Some(0), "{}", tour.err);
    tour.says(&["warning", "0xA9B40100"]);
}

#[test]
fn a_damaged_directory_is_said_wherever_nothing_is_found() {
    let sandbox = Sandbox::new();
    let dir = sandbox.build_world("w");
    damage(&dir, CELL, |bytes| {
        // The root node's first branch, past its block's link.
        let root = u32::from_le_bytes(bytes[0x160..0x164].try_into().unwrap()) as usize;
        bytes[root + 4..root + 8].copy_from_slice(&0x7FFF_FFF0u32.to_le_bytes());
    });
    let warning = "warning: branches: 0x7FFFFFF0 is outside the blocks";
    sandbox.run(&["ls", "--dat", "w"]).says(&[warning, CELL]);
    let (land, room) = ("0xA9B40031 [155.5 24 94.1]", "0xA9B40101 [155.4 14.2 94.1]");
    for (args, code, wanted) in [
        (&["tour"][..], 1, "no place to start"),
        (&["tour", "--start", land], 1, "nobody can stand"),
        (&["render", land, "--size", "8x6", "--cpu"], 1, "nobody can stand"),
        (
            &["render", "--eye", room, "--look", "0,1,0"],
            1,
            "there is no cell",
        ),
        (&["walk", "--from", land, "--to", room], 1, "nobody can stand"),
        (&["map", "A9B4"], 1, "there is no landblock"),
        (&["visible", "--eye", room, "--look", "0,1,0"], 0, ""),
        (&["visible", "--eye", room, "--look", "0,1,0", "--json"], 0, ""),
        // It is the error itself.
        (
            &["inspect", "0xA9B40101"],
            1,
            "error: record 0xA9B40101: branches",
        ),
    ] {
        let ran = sandbox.run(&[args, &["--dat", "w"]].concat()).fails(code);
        let ran = ran.says(&[CELL, wanted]);
        let said: Vec<_> = ran.err.lines().filter(|line| line.contains(CELL)).collect();
        assert_eq!(said.len(), 1, "{args:?}: {}", ran.err);
        if args[0] != "inspect" {
            assert!(said[0].starts_with(warning), "{}", ran.err);
            assert!(said[0].contains("hint: "), "{}", ran.err);
        }
    }
    // What is wrong with the command line is not the file's fault.
    let usage = ["ls", "--dat", "w", "--file", "highres"];
    assert!(!sandbox.run(&usage).fails(2).err.contains("warning"));
}

#[test]
fn a_chain_that_runs_in_a_circle_ends() {
    let sandbox = Sandbox::new();
    let dir = sandbox.build_world("w");
    damage(&dir, PORTAL, |bytes| {
        let entry = entry_of(bytes, 0x0D00_0001);
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let first = word(entry + 8);
        // The first block's link leads back to itself.
        bytes[first as usize..first as usize + 4].copy_from_slice(&first.to_le_bytes());
    });
    sandbox
        .run(&["inspect", "0x0D000001", "--dat", "w"])
        .fails(1)
        .says(&["record 0x0D000001", PORTAL]);
    sandbox
        .run(&["dat", "verify", "w"])
        .fails(1)
        .shows(&["0x0D000001"]);
    sandbox.run(&["inspect", "0x0D000002", "--dat", "w"]).ok();
}

#[test]
fn a_count_larger_than_the_record_is_an_error_at_its_byte() {
    let sandbox = Sandbox::new();
    let dir = sandbox.build_world("w");
    damage(&dir, CELL, |bytes| {
        let entry = entry_of(bytes, 0xA9B4_FFFE);
        let first = u32::from_le_bytes(bytes[entry + 8..entry + 12].try_into().unwrap()) as usize;
        // Past the block's link, id and num_cells: the number of objects.
        bytes[first + 12..first + 16].copy_from_slice(&0x4000_0000u32.to_le_bytes());
    });
    let ran = sandbox.run(&["inspect", "0xA9B4FFFE", "--dat", "w"]).fails(1);
    ran.says(&[
        "A9B4FFFE",
        "byte 0xc",
        "`objects`",
        "count 1073741824",
        CELL,
        "--hex",
    ]);
    sandbox
        .run(&["inspect", "0xA9B4FFFE", "--dat", "w", "--hex"])
        .ok();
    sandbox
        .run(&["dat", "verify", "w"])
        .fails(1)
        .shows(&["A9B4FFFE", "1"]);
}

#[test]
fn a_dangling_id_is_reported_and_the_rest_stands() {
    let sandbox = Sandbox::new();
    let dir = sandbox.build_world("w");
    damage(&dir, CELL, |bytes| {
        let entry = entry_of(bytes, 0xA9B4_0101);
        let first = u32::from_le_bytes(bytes[entry + 8..entry + 12].try_into().unwrap()) as usize;
        // Past link, ids and flags, counts and surfaces: the short id of the environment.
        let surfaces = usize::from(bytes[first + 16]);
        let at = first + 20 + 2 * surfaces;
        bytes[at..at + 2].copy_from_slice(&0x7777u16.to_le_bytes());
    });
    let ran = sandbox
        .run(&["where", "0xA9B40101 [155.4 14.2 94]", "--dat", "w"])
        .ok();
    ran.shows(&[
        "not in this world",
        "0x0D007777",
        "missing, needed by record 0xA9B40101",
    ]);
    sandbox
        .run(&["where", "0xA9B40107 [148 5 91.7]", "--dat", "w"])
        .ok()
        .shows(&["0xA9B40107, env cell"]);
    sandbox
        .run(&["refs", "0x0D007777", "--dat", "w"])
        .ok()
        .shows(&["does not exist", "0xA9B40101"]);
}

#[test]
fn a_position_that_does_not_parse_names_text_and_column() {
    let sandbox = Sandbox::new();
    for (text, wanted) in [
        ("0xA9B40101 [82 x 40.105]", "column 16: expected a number"),
        ("0xA9B40101 82 84 40", "column 12: expected '['"),
        (
            "0xA9B40101 [1 2 NaN]",
            "column 17: a coordinate must be a finite number",
        ),
        (
            "0xA9B40101 [1 inf 3]",
            "column 15: a coordinate must be a finite number",
        ),
        ("nonsense", "column 1: expected a cell id"),
        ("0xFFB40001 [1 2 3]", "column 1: landblock 0xFFB4 is off the map"),
        ("0x00000001 [-5 2 3]", "column 12: lies outside the map"),
        ("0xA9B40041 [1 2 3]", "0xA9B40041 is no cell"),
        ("142.1N, 33.6E", "is not a pair of map coordinates"),
        ("42.1N 33.6", "is not a pair of map coordinates"),
    ] {
        sandbox.run(&["where", text]).fails(2).says(&[text, wanted]);
        sandbox.run(&["tour", "--start", text]).fails(2).says(&[wanted]);
    }
}

#[test]
fn a_place_where_nobody_can_stand() {
    let sandbox = Sandbox::new();
    for place in [
        "0xA9B40101 [155 12 3000]",
        "0xA9B401F0 [155.4 14.2 94]",
        "0x00000001 [10 10 0]",
    ] {
        sandbox
            .run(&["tour", "--start", place])
            .fails(1)
            .says(&["nobody can stand at 0x", "hint:"]);
        sandbox
            .run(&["walk", "--from", place, "--to", "0xA9B40101 [155.4 14.2 94]"])
            .fails(1)
            .says(&["nobody can stand"]);
    }
    let away = [
        "walk",
        "--from",
        "0xA9B40101 [155.4 14.2 94]",
        "--to",
        "0x01070100 [0 0 0]",
    ];
    sandbox.run(&away).fails(1);
}

#[test]
fn ids_that_are_wrong_or_not_there() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&["inspect", "12345678"])
        .fails(1)
        .says(&["no record 0x12345678", "vestibule ls"]);
    sandbox
        .run(&["inspect", "xyz"])
        .fails(2)
        .says(&["eight hexadecimal digits"]);
    sandbox
        .run(&["map", "1234"])
        .fails(1)
        .says(&["no landblock 0x1234", "vestibule ls LandBlock"]);
    sandbox.run(&["map", "FFFF"]).fails(2).says(&["off the map"]);
    sandbox.run(&["ls", "Nonsense"]).fails(2).says(&["no such type"]);
    sandbox
        .run(&["ls", "--file", "highres"])
        .fails(2)
        .says(&["no highres file"]);
    sandbox
        .run(&["inspect", "0xA9B40100", "--file", "portal"])
        .fails(1)
        .says(&["no record"]);
}

#[test]
fn vectors_that_are_wrong() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&["conform", "nowhere"])
        .fails(1)
        .says(&["cannot read nowhere", "hint:"]);
    sandbox.write("v/a.jsonl", "{\"id\": \"one\", \"world\":");
    sandbox
        .run(&["conform", "v"])
        .fails(1)
        .says(&["line 1, column 22", "a.jsonl"]);
    sandbox.write(
        "v/a.jsonl",
        r#"{"id":"one","world":"w","op":"point_in_cell","in":{"cell":"x"},"expect":{}}"#,
    );
    sandbox.run(&["conform", "v"]).fails(1).says(&["world w"]);
    sandbox.build_world("v/worlds/w");
    sandbox
        .run(&["conform", "v"])
        .fails(1)
        .says(&["case one", "a.jsonl"]);
    sandbox.write(
        "v/a.jsonl",
        r#"{"id":"one","world":"w","op":"juggle","in":{},"expect":{}}"#,
    );
    sandbox.run(&["conform", "v"]).ok().shows(&[
        "juggle: not supported, 1 cases not counted",
        "conform: 0 of 0 agree",
    ]);
    sandbox
        .run(&["conform", "v", "--op", "nonsense"])
        .fails(2)
        .says(&["nonsense", "find_cell_list"]);
}

#[test]
fn differences_are_shown_in_full_and_decide() {
    let sandbox = Sandbox::new();
    sandbox.build_world("v/worlds/w");
    let case = |id: &str, more: &str, inside: bool| {
        format!(
            r#"{{"id":"{id}","world":"w","op":"point_in_cell","tags":["t"],{more}"in":{{"cell":2847146241,"pos":[155,12,95]}},"expect":{{"inside":{inside}}}}}"#
        )
    };
    let lines = [
        case("right", "", true),
        case("wrong", "", false),
        case("last-bit", r#""sensitive":true,"#, false),
        case("doubted", r#""suspect":"see notes","#, false),
    ];
    sandbox.write("v/a.jsonl", lines.join("\n"));
    let ran = sandbox.run(&["conform", "v"]).fails(1);
    assert_eq!(ran.out.lines().last(), Some("conform: 1 of 2 agree"));
    ran.shows(&[
        "point_in_cell: 1 agree, 1 differ, 2 flagged",
        "wrong on w (t)",
        "expected false",
        "actual   true",
    ]);
    let json = sandbox.run(&["conform", "v", "--json"]).fails(1).json();
    assert_eq!(
        (json["agree"].as_u64(), json["differ"].as_u64()),
        (Some(1), Some(1))
    );
    assert_eq!(json["ops"][0]["differences"][0]["id"], "wrong");
}

#[test]
fn scenes_scripts_trails_and_directions_that_are_wrong() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&["build", "nowhere.scene", "--out", "o"])
        .fails(1)
        .says(&["nowhere.scene"]);
    sandbox.write("bad.scene", "land 0x8080 0x8080\nnonsense here\n");
    sandbox
        .run(&["build", "bad.scene", "--check"])
        .fails(1)
        .says(&["bad.scene:"]);
    let from = "0xA9B40101 [155.4 14.2 94]";
    let script = ["walk", "--from", from, "--script", "-"];
    sandbox
        .run_with(&script, "walk 1\n  fly 3")
        .fails(1)
        .says(&["line 2, column 3: 'fly' is no command"]);
    sandbox
        .run_with(&script, "walk far")
        .fails(1)
        .says(&["line 1, column 6: 'far' is no number"]);
    sandbox
        .run_with(&script, "turn 90 91")
        .fails(1)
        .says(&["column 9: unexpected '91'"]);
    sandbox.write("bad.jsonl", "{\"t\":0}\n");
    sandbox
        .run(&["replay", "bad.jsonl"])
        .fails(1)
        .says(&["bad.jsonl", "line 1"]);
    sandbox.write("bad.log", "| 1 | 0031 | 155.3 | sixteen | 94 | 0170 |\n");
    sandbox
        .run(&["replay", "bad.log"])
        .fails(1)
        .says(&["line 1", "'sixteen' is no finite number"]);
    sandbox
        .run(&["map", "A9B4", "--trail", "bad.jsonl"])
        .fails(1)
        .says(&["line 1 of bad.jsonl"]);
    for look in ["0,0,0", "NaN,0,1", "1,2", "north"] {
        sandbox
            .run(&["visible", "--eye", from, "--look", look])
            .fails(2)
            .says(&["--look"]);
    }
    for fov in ["0", "180", "NaN", "-10"] {
        sandbox
            .run(&[
                "visible",
                "--eye",
                from,
                "--look",
                "0,1,0",
                &format!("--fov={fov}"),
            ])
            .fails(2)
            .says(&["no camera"]);
    }
    let nowhere = sandbox
        .run(&["visible", "--eye", "0xA9B401F0 [1 1 1]", "--look", "0,1,0"])
        .ok();
    nowhere.shows(&["the eye is in no cell of this world"]);
}

#[test]
fn files_that_cannot_be_written() {
    let sandbox = Sandbox::new();
    sandbox.write("file", "in the way");
    sandbox
        .run(&["map", "A9B4", "-o", "file/m.svg"])
        .fails(1)
        .says(&["cannot write file/m.svg"]);
    sandbox
        .run(&["tour", "--out", "file", "--stand", "1", "--no-look"])
        .fails(1)
        .says(&["cannot create file"]);
    sandbox
        .run(&["dat", "extract", "0xA9B40100", "-o", "file/x"])
        .fails(1)
        .says(&["cannot write file/x"]);
}

#[test]
fn recordings_walks_and_benches_that_have_nothing_to_say() {
    let sandbox = Sandbox::new();
    let place = "0xA9B40031 [155.5 24 94.1]";
    sandbox.write("words.txt", "hello\n");
    sandbox.write("one.jsonl", "{\"cell\":\"0xA9B40031\",\"pos\":[155.5,24,94]}\n");
    sandbox.write("far.jsonl", "{\"cell\":\"0xA9B40031\",\"pos\":[1e40,24,94]}\n");
    std::fs::create_dir_all(sandbox.join("empty/worlds")).unwrap();
    for (args, code, wanted) in [
        (&["replay", "words.txt"][..], 1, "replay reads JSON lines"),
        (&["replay", "one.jsonl"], 1, "nothing to hold against the world"),
        (&["replay", "far.jsonl"], 1, "line 1: the position"),
        (&["walk", "--from", place], 2, "--script"),
        (
            &["walk", "--from", place, "--to", "0x01070100 [60 -80 -20]"],
            1,
            "no way on foot leads from",
        ),
        (
            &["conform", "empty"],
            1,
            "conform takes a folder of *.jsonl files",
        ),
        (
            &["bench", "sweep", "--vectors", "empty", "--world", "x"],
            1,
            "there is no world x in empty",
        ),
        (
            &["bench", "view", "--vectors", "empty", "--world", "x"],
            1,
            "there is no world x in empty",
        ),
        (
            &["bench", "all", "--vectors", "empty"],
            1,
            "there is no world cottage-1 in empty",
        ),
        (&["build"], 2, "--out"),
        (
            &["build", "--synthetic", "huge", "--out", "x"],
            2,
            "retail, small",
        ),
        (
            &["build", "--synthetic", "small", "--out", "words.txt"],
            1,
            "--out takes a folder",
        ),
        (
            &["build", "room.scene", "--seed", "3", "--out", "x"],
            2,
            "--synthetic",
        ),
    ] {
        sandbox.run(args).fails(code).says(&[wanted]);
    }
    // The target's cell is the one that holds it, and that is said.
    let args = [
        "walk",
        "--from",
        place,
        "--to",
        "0xA9B40101 [155.5 20 94.1]",
        "-o",
        "trail.jsonl",
    ];
    let ran = sandbox.run(&args);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    ran.says(&["note: 0xA9B40101 does not hold the target; the walk ended in 0xA9B40031"]);
}
