//! What the command writes: JSON that is JSON, files that are whole or not there, and failures that are said.

mod support;

use support::Sandbox;

const PLACE: &str = "0xA9B40031 [155.4 22 94.1]";
const EYE: &str = "0xA9B40101 [156.4 12.9 95.7]";

#[test]
fn with_json_every_subcommand_prints_one_value_and_nothing_else() {
    let sandbox = Sandbox::new();
    sandbox.build_world("w");
    sandbox.write("bad.scene", "land 0x8080\nroom {\n");
    let mut runs = vec![
        vec!["tour", "--stand", "1", "--no-pictures"],
        vec!["replay", "tour/trail.jsonl"],
        vec!["where", PLACE],
        vec!["inspect", "0xA9B40100"],
        vec!["inspect", "0xA9B40100", "--hex"],
        vec!["ls"],
        vec!["ls", "EnvCell"],
        vec!["refs", "0xA9B40101"],
        vec!["visible", "--eye", EYE, "--look", "0,1,0", "-o", "seen.svg"],
        vec!["render", PLACE, "--size", "16x12", "--cpu"],
        vec!["walk", "--from", PLACE, "--to", EYE, "-o", "trail.jsonl"],
        vec!["map", "A9B4", "-o", "map.svg"],
        vec!["build", "w.scenes", "--check"],
        vec!["build", "w.scenes", "--out", "x"],
        vec!["dat", "verify", "w"],
        vec!["dat", "diff", "w", "x"],
        vec!["dat", "extract", "0xA9B40100", "-o", "cell.bin"],
        vec!["dat", "extract", "--all", "--type", "Setup", "-o", "setups"],
    ];
    if cfg!(feature = "explore") {
        runs.push(vec!["explore", "--keys"]);
    }
    for mut args in runs {
        args.push("--json");
        let ran = sandbox.run(&args);
        assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""), "{args:?}");
        ran.json();
        assert!(!ran.out.contains('\x1b'), "{args:?}");
    }
    let messages = sandbox
        .run(&["build", "bad.scene", "--check", "--json"])
        .fails(1)
        .json();
    let first = &messages["messages"][0];
    assert_eq!(
        (&first["severity"], &first["file"], &first["line"]),
        (&"error".into(), &"bad.scene".into(), &1.into())
    );
    assert!(first["help"].is_string(), "{first}");
    // What is no JSON by itself goes to a file.
    for args in [
        &["map", "A9B4", "--json"][..],
        &["dat", "extract", "0xA9B40100", "--json"],
    ] {
        sandbox.run(args).fails(2).says(&["--json goes with -o"]);
    }
}

#[test]
fn a_file_that_cannot_be_written_is_said_with_a_hint_and_leaves_nothing() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.join("folder")).unwrap();
    for (file, hint) in [
        ("nowhere/file", "a folder that is there"),
        ("folder", "name a file"),
    ] {
        for args in [
            &["map", "A9B4"][..],
            &["visible", "--eye", EYE, "--look", "0,1,0"],
            &["walk", "--from", PLACE, "--to", EYE],
            &["dat", "extract", "0xA9B40100"],
            &["render", PLACE, "--size", "16x12", "--cpu"],
        ] {
            let args = [args, &["-o", file]].concat();
            sandbox.run(&args).fails(1).says(&["hint: ", hint]);
        }
    }
    let left: Vec<_> = std::fs::read_dir(sandbox.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn where_a_tour_cannot_write_it_does_not_begin_to_walk() {
    let sandbox = Sandbox::new();
    sandbox.write("file", "in the way");
    for (args, wanted) in [
        (["--out", "file"], "hint: --out takes a folder"),
        (["--out", "file/deep"], "cannot create file"),
        (["--film", "nowhere/film.png"], "there is no folder nowhere"),
    ] {
        let ran = sandbox
            .run(&[&["tour"][..], &args].concat())
            .fails(1)
            .says(&[wanted]);
        assert_eq!(ran.out, "");
    }
    assert!(!sandbox.join("tour").exists());
}

#[test]
fn nothing_is_measured_of_nothing() {
    let sandbox = Sandbox::new();
    for args in [
        &["bench", "sweep", "--vectors", "v", "--world", "w", "-n", "0"][..],
        &["bench", "view", "--eyes", "0"],
        &["bench", "render", "--eyes", "0"],
    ] {
        sandbox.run(args).fails(2).says(&["0 is not in 1.."]);
    }
}

#[test]
fn a_file_that_cannot_be_read_is_said_with_a_hint() {
    let sandbox = Sandbox::new();
    sandbox.write("bytes", [0xFF, 0xFE]);
    for (args, hint) in [
        (&["replay", "nowhere"][..], "check the path"),
        (&["replay", "."], "name a file"),
        (&["map", "A9B4", "--trail", "nowhere"], "check the path"),
        (
            &["walk", "--from", PLACE, "--script", "nowhere"],
            "check the path",
        ),
        (&["walk", "--from", PLACE, "--script", "bytes"], "a text file"),
        (&["ls", "--dat", "nowhere"], "cannot read the folder nowhere"),
        (&["dat", "verify", "bytes"], "hint: a folder of"),
    ] {
        sandbox.run(args).fails(1).says(&["hint: ", hint]);
    }
    sandbox.build_world("w");
    std::fs::write(sandbox.join("w/client_cell_1.dat"), [0; 100]).unwrap();
    sandbox
        .run(&["ls", "--dat", "w"])
        .fails(1)
        .says(&["100 bytes where 400 are needed", "not copied whole"]);
    std::fs::remove_file(sandbox.join("w/client_cell_1.dat")).unwrap();
    sandbox
        .run(&["ls", "--dat", "w"])
        .fails(1)
        .says(&["there is no w/client_cell_1.dat", "hint: "]);
}

#[cfg(unix)]
#[test]
fn links_and_pipes_are_written_through() {
    let sandbox = Sandbox::new();
    sandbox.write("real.svg", "old");
    std::os::unix::fs::symlink("real.svg", sandbox.join("link.svg")).unwrap();
    sandbox.run(&["map", "A9B4", "-o", "link.svg"]).ok();
    assert!(sandbox.join("link.svg").is_symlink());
    assert!(sandbox.read("real.svg").starts_with("<svg"));
    let line =
        "mkfifo pipe && { vestibule map A9B4 -o pipe >said & cat pipe >read.svg; wait; test -p pipe; }";
    assert_eq!(sandbox.shell(line).code, Some(0));
    assert_eq!(sandbox.read("read.svg"), sandbox.read("real.svg"));
}

#[cfg(target_os = "linux")]
#[test]
fn what_is_printed_and_lost_is_a_failure_unless_the_reader_has_gone() {
    let sandbox = Sandbox::new();
    for line in [
        "vestibule ls",
        "vestibule map A9B4",
        "vestibule ls EnvCell --json",
    ] {
        let lost = sandbox.shell(&format!("{line} >/dev/full")).fails(1);
        lost.says(&["No space left", "hint: make room"]);
        sandbox.shell(&format!("{line} | head -c 10")).ok();
    }
}
