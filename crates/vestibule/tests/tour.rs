//! Tours: what they walk, what they run into, and both ways of telling the cell.

mod support;

use std::collections::BTreeSet;

use support::Sandbox;

#[test]
fn tour_walks_everything_and_never_changes_cell_while_standing() {
    let sandbox = Sandbox::new();
    let ran = sandbox.run(&["tour", "--no-pictures"]).ok().shows(&[
        "A tour of the embedded world",
        "land cell border",
        "portal 0",
        "changes while standing: 0",
        "by sweep",
        "static",
        "trials: 19 of 19 as expected",
        "written tour/trail.jsonl",
        "written tour/map.svg",
    ]);
    let changes = ran
        .out
        .lines()
        .filter(|line| line.contains(" to ") && line.contains("0xA9B4"))
        .count();
    assert!(changes > 60, "{}", ran.out);
    let mut cells = BTreeSet::new();
    let mut standing = 0;
    let mut last_time = -1.0;
    for line in sandbox.read("tour/trail.jsonl").lines() {
        let step: serde_json::Value = serde_json::from_str(line).unwrap();
        let t = step["t"].as_f64().unwrap();
        assert!(t > last_time);
        last_time = t;
        let cell = step["cell"].as_str().unwrap();
        assert!(cell.starts_with("0x") && cell.len() == 10, "{cell}");
        assert_eq!(step["pos"].as_array().unwrap().len(), 3);
        cells.insert(cell.to_owned());
        standing += usize::from(step["standing"] == true);
    }
    // Vestibule, hall, loft, passage, cellar, barn, shop, tower and mine.
    let indoor = cells.iter().filter(|cell| cell.as_bytes()[7] != b'0').count();
    assert!(indoor >= 30, "{cells:?}");
    assert!(standing >= 100 * 30, "{standing}");
    assert!(
        sandbox.read("tour/map.svg").contains("class=\"tr\""),
        "the trail is on the map"
    );
}

#[test]
fn tour_in_json_sums_up_what_it_prints() {
    let sandbox = Sandbox::new();
    let json = sandbox
        .run(&["tour", "--json", "--out", "t", "--no-pictures", "--no-look"])
        .ok()
        .json();
    let summary = &json["summary"];
    assert_eq!(summary["changes_while_standing"], 0);
    assert_eq!(summary["look_ups_that_differ"], 0);
    let changes = json["changes"].as_array().unwrap();
    let teleports = changes.iter().filter(|change| change["by"] == "teleport").count();
    assert_eq!(
        summary["transitions"].as_u64().unwrap() as usize,
        changes.len() - teleports
    );
    assert!(
        changes.iter().all(|c| c["by"] != "no portal between them"),
        "{changes:#?}"
    );
    assert!(sandbox.join("t/trail.jsonl").is_file());
}

#[test]
fn tour_starts_where_it_is_told() {
    let sandbox = Sandbox::new();
    let json = sandbox
        .run(&[
            "tour",
            "--json",
            "--start",
            "0xA9B40101 [155.4 14.2 94.005]",
            "--stand",
            "3",
            "--no-pictures",
            "--no-trials",
        ])
        .ok()
        .json();
    assert!(
        json["summary"]["start"]
            .as_str()
            .unwrap()
            .starts_with("0xA9B40101 [155.40 14.20")
    );
    assert_eq!(json["summary"]["changes_while_standing"], 0);
}

#[test]
fn every_trial_of_the_embedded_world_goes_as_expected() {
    let sandbox = Sandbox::new();
    let json = sandbox
        .run(&["tour", "--json", "--stand", "1", "--no-pictures"])
        .ok()
        .json();
    let trials = json["summary"]["trials"].as_array().unwrap();
    for wanted in [
        "wall, head on",
        "wall, at a slant",
        "stairs, up",
        "ramp, down under the meadow",
        "edge of the same bridge, jumping",
        "fence, jumping",
        "ridge, too steep to walk",
        "door that is shut",
        "the same door, opened",
        "teleport to the dungeon",
    ] {
        let trial = trials.iter().find(|trial| trial["trial"] == wanted);
        let trial = trial.unwrap_or_else(|| panic!("no trial '{wanted}'"));
        assert_eq!(trial["passed"], true, "{trial}");
    }
    let cell = |name: &str| trials.iter().find(|trial| trial["trial"] == name).unwrap()["cell"].clone();
    assert_eq!(cell("stairs, up"), "cottage.loft");
    assert_eq!(cell("ramp, down under the meadow"), "cottage.cellar");
    assert_eq!(cell("teleport to the dungeon"), "deep.arrival");
}

/// Both ways of telling the cell are counted on the same walk; deriving it puts the player into wrong cells.
#[test]
fn static_membership_is_counted_beside_the_sweeps() {
    let sandbox = Sandbox::new();
    let run = |membership: &str| {
        let args = [
            "tour",
            "--json",
            "--membership",
            membership,
            "--no-pictures",
            "--no-look",
            "--out",
            membership,
        ];
        sandbox.run(&args).ok().json()
    };
    let (sweep, fixed) = (run("sweep"), run("static"));
    for json in [&sweep, &fixed] {
        let summary = &json["summary"];
        assert_eq!(summary["by_sweep"]["flickers"], 0);
        assert_eq!(summary["by_sweep"]["while_standing"], 0);
        assert_eq!(summary["by_sweep"]["ticks_off"], 0);
        assert_eq!(summary["by_sweep"]["changes"], summary["transitions"]);
        assert!(
            summary["by_position"]["ticks_off"].as_u64().unwrap() > 100,
            "{}",
            summary["by_position"]
        );
        let list = summary["disagreements"].as_array().unwrap();
        let ticks: u64 = list.iter().map(|d| d["ticks"].as_u64().unwrap()).sum();
        assert_eq!(summary["by_position"]["ticks_off"], ticks);
    }
    assert_eq!(sweep["summary"]["by_position"], fixed["summary"]["by_position"]);
    // The trail holds the cells that were asked for: they differ where the summary says so.
    let rows = |name: &str| sandbox.read(name).lines().map(str::to_owned).collect::<Vec<_>>();
    let (a, b) = (rows("sweep/trail.jsonl"), rows("static/trail.jsonl"));
    let differ = a.iter().zip(&b).filter(|(a, b)| a != b).count();
    assert_eq!(sweep["summary"]["by_position"]["ticks_off"], differ);
}

#[test]
fn a_tour_records_the_viewers_cell_and_the_draw_list() {
    let sandbox = Sandbox::new();
    let ran = sandbox
        .run(&["tour", "--json", "--stand", "1", "--no-pictures"])
        .ok();
    let seen = ran.json()["summary"]["seen"].clone();
    let (mut elsewhere, mut most, mut rooms) = (0u64, 0, 0);
    let text = sandbox.read("tour/trail.jsonl");
    for line in text.lines() {
        let row: serde_json::Value = serde_json::from_str(line).unwrap();
        assert_eq!(row["eye"].as_array().unwrap().len(), 3);
        elsewhere += u64::from(row["viewer"] != row["cell"]);
        if let Some(list) = row["rooms"].as_array() {
            rooms = list.len();
        }
        most = most.max(rooms);
    }
    assert_eq!(seen["ticks"], text.lines().count());
    assert_eq!(seen["viewer_elsewhere"], elsewhere);
    assert_eq!(seen["rooms_max"], most);
    assert_eq!(seen["viewer_lost"], 0);
    assert_eq!(seen["landscape_in_sealed"], 0);
    assert!(seen["rooms_median"].as_u64().unwrap() >= 2);
    // Also as something to hold against the world again, teleports and all.
    sandbox
        .run(&["replay", "tour/trail.jsonl"])
        .ok()
        .shows(&["rows agree"]);
}

#[test]
fn a_world_that_nothing_is_known_of_has_the_trials_that_it_has_things_for() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&["build", "--synthetic", "small", "--seed", "3", "--out", "plain"])
        .ok();
    let json = sandbox
        .run(&[
            "tour",
            "--dat",
            "plain",
            "--json",
            "--stand",
            "1",
            "--no-pictures",
        ])
        .ok()
        .json();
    let trials = json["summary"]["trials"].as_array().unwrap();
    let passed = |name: &str| trials.iter().find(|t| t["trial"] == name).unwrap()["passed"].clone();
    assert_eq!(passed("wall, head on"), true);
    assert_eq!(passed("jump"), true);
    assert_eq!(passed("teleport to a dungeon"), true);
    assert_eq!(passed("ridge, too steep to walk"), serde_json::Value::Null);
}

/// A copy of the embedded world in a folder is the embedded world.
#[test]
fn the_trials_of_the_embedded_world_are_run_in_a_copy_too() {
    let sandbox = Sandbox::new();
    sandbox.build_world("w");
    sandbox
        .run(&["tour", "--dat", "w", "--stand", "1", "--no-pictures", "--no-look"])
        .ok()
        .shows(&[
            "trials: 19 of 19 as expected",
            "started      0xA9B40032 [155.40 26.00",
        ]);
}
