//! The vectors, when they are there: every supported case agrees, and every world can be toured and verified.

mod support;

use support::Sandbox;

#[test]
fn conform_agrees_on_every_case() {
    let Some(vectors) = support::vectors("conform_agrees_on_every_case") else {
        return;
    };
    let json = Sandbox::new()
        .run(&["conform", &vectors.display().to_string(), "--json"])
        .ok()
        .json();
    let agree = |op: &str| {
        json["ops"]
            .as_array()
            .unwrap()
            .iter()
            .find(|o| o["op"] == op)
            .unwrap()["agree"]
            .as_u64()
            .unwrap()
    };
    assert_eq!(
        agree("find_cell_list") + agree("point_in_cell") + agree("terrain_z"),
        788
    );
    assert_eq!(agree("sweep") + agree("walk"), 3060 - 788);
    assert_eq!(agree("visible"), 399);
}

#[test]
fn conform_can_be_narrowed() {
    let Some(vectors) = support::vectors("conform_can_be_narrowed") else {
        return;
    };
    let vectors = vectors.display().to_string();
    let ran = Sandbox::new()
        .run(&["conform", &vectors, "--op", "terrain_z", "--op", "point_in_cell"])
        .ok();
    assert_eq!(ran.out.lines().last(), Some("conform: 168 of 168 agree"));
    Sandbox::new()
        .run(&["conform", &vectors, "--world", "nowhere"])
        .fails(2)
        .says(&["nowhere"]);
}

#[test]
fn every_world_verifies_and_is_toured_without_a_change_while_standing() {
    let Some(vectors) = support::vectors("every_world_verifies_and_is_toured") else {
        return;
    };
    let sandbox = Sandbox::new();
    let mut worlds: Vec<_> = std::fs::read_dir(vectors.join("worlds"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    worlds.sort();
    assert!(worlds.len() >= 20);
    for world in worlds {
        let (path, name) = (
            world.display().to_string(),
            world.file_name().unwrap().to_string_lossy().into_owned(),
        );
        let verified = sandbox.run(&["dat", "verify", &path, "--json"]).ok().json();
        for file in verified["files"].as_array().unwrap() {
            assert_eq!(file["records"], file["identical"], "{name}");
        }
        // The largest is left to people: it takes long without optimisation.
        if name == "maze-424" {
            continue;
        }
        let ran = sandbox.run(&[
            "tour",
            "--dat",
            &path,
            "--out",
            &name,
            "--stand",
            "20",
            "--json",
            "--no-pictures",
        ]);
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.err);
        let summary = &ran.json()["summary"];
        assert_eq!(summary["changes_while_standing"], 0, "{name}");
        assert_eq!(summary["look_ups_that_differ"], 0, "{name}");
        let entered = summary["env_cells"].as_u64().unwrap();
        let enough = match name.as_str() {
            // The sea keeps everyone in; the hill reaches into the doorway.
            "cottage-1-sea" | "cottage-1-steep9" => 1,
            n if n.starts_with("cottage-1") => 6,
            "cottage-2" => 11,
            n if n.starts_with("dungeon") => 20,
            "maze-1" => 23,
            n if n.starts_with("maze") => 1,
            _ => 8,
        };
        assert!(
            entered >= enough,
            "{name}: {entered} cells entered, {enough} can be reached"
        );
    }
}
