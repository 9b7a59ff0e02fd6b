//! Every example that a help text shows runs.

mod support;

use std::collections::BTreeSet;

use support::Sandbox;

/// All subcommands, as words.
fn subcommands(sandbox: &Sandbox) -> Vec<Vec<String>> {
    let mut out = vec![vec![]];
    let mut i = 0;
    while i < out.len() {
        let mut args: Vec<&str> = out[i].iter().map(String::as_str).collect();
        args.push("--help");
        let help = sandbox.run(&args).ok().out;
        if let Some(list) = help.split("Commands:\n").nth(1) {
            for line in list.lines().take_while(|line| line.starts_with("  ")) {
                // Names stand two spaces in; their texts may run over more lines.
                let name = line.strip_prefix("  ").unwrap();
                if !name.starts_with(' ') && !name.starts_with("help") {
                    let mut words = out[i].clone();
                    words.push(name.split_whitespace().next().unwrap().to_owned());
                    out.push(words);
                }
            }
        }
        i += 1;
    }
    out
}

fn examples(help: &str) -> Vec<String> {
    let Some(list) = help.split("Examples:\n").nth(1) else {
        return Vec::new();
    };
    list.lines()
        .take_while(|line| line.starts_with("  "))
        .map(|line| line.trim().to_owned())
        .collect()
}

#[test]
fn every_subcommand_has_examples_and_they_run() {
    let sandbox = Sandbox::new();
    let vectors = support::vectors("help examples that need vectors");
    if let Some(vectors) = &vectors {
        std::os::unix::fs::symlink(vectors, sandbox.join("vectors")).unwrap();
    }
    sandbox.write_scene("crates/vestibule-forge/worlds/hollow");
    for name in ["ac", "old", "new", "patched"] {
        sandbox.build_world(name);
    }
    sandbox.write("steps.txt", "walk 2\nturn 90\n");
    sandbox.write(
        "doorway.log",
        "| # | seed | x | y | z | picked |\n| 1 | 0031 | 155.3717 | 16.0283 | 94.0050 | 0100 |\n",
    );
    sandbox.write("room.scene", include_str!("room.scene"));
    sandbox.run(&["tour", "--stand", "1", "--no-pictures"]).ok();
    let mut ran = BTreeSet::new();
    for words in subcommands(&sandbox) {
        if words == ["explore"] && cfg!(not(feature = "explore")) {
            let refused = sandbox.run(&["explore", "--cpu"]);
            assert_eq!(refused.code, Some(1));
            refused.says(&["without the window", "--features explore"]);
            continue;
        }
        let mut args: Vec<&str> = words.iter().map(String::as_str).collect();
        args.push("--help");
        let help = sandbox.run(&args).ok().out;
        assert!(
            !help.contains("\\\""),
            "{words:?}: quotes are written as they are typed"
        );
        let examples = examples(&help);
        // Of what opens a window only the rest can be run here.
        let enough = if help.contains("Opens a window:") { 1 } else { 2 };
        let is_group = help.contains("\nCommands:\n");
        assert!(
            is_group || examples.len() >= enough,
            "{words:?} shows {} examples",
            examples.len()
        );
        for example in examples {
            let needs_vectors = example.contains("vectors");
            if needs_vectors && vectors.is_none() || !ran.insert(example.clone()) {
                continue;
            }
            // Long ones are cut short: it is the arguments that matter here.
            let line = example
                .replace("-n 1000000", "-n 1000")
                .replace("--eyes 10000", "--eyes 50")
                .replace("tour --film", "tour --stand 1 --film-size 16x12 --film")
                .replace("vestibule tour", "vestibule tour --no-pictures")
                .replace("bench render", "bench render --eyes 3 --size 64x48")
                .replace(
                    "render --eyes 3 --size 64x48 --size 320x240 --eyes 20",
                    "render --size 32x24 --eyes 2",
                )
                .replace(
                    "bench all --quick --vectors vectors",
                    "bench sweep --vectors vectors --world maze-424",
                );
            if line.ends_with("bench all --quick") {
                // As with --json.
                continue;
            }
            let result = sandbox.shell(&line);
            assert_eq!(result.code, Some(0), "{example}\n{}\n{}", result.out, result.err);
        }
    }
    assert!(ran.len() > 30, "{}", ran.len());
}

#[test]
fn short_and_long_help_and_version() {
    let sandbox = Sandbox::new();
    let (short, long) = (
        sandbox.run(&["tour", "-h"]).ok().out,
        sandbox.run(&["tour", "--help"]).ok().out,
    );
    assert!(long.len() > short.len(), "--help says more than -h");
    assert!(sandbox.run(&["--version"]).ok().out.starts_with("vestibule "));
    sandbox.run(&[]).fails(2);
    sandbox
        .run(&["nonsense"])
        .fails(2)
        .says(&["unrecognized subcommand 'nonsense'"]);
}
