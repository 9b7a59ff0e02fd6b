//! The look-up vectors: independent results on worlds in real DAT format (`../shared/vectors`, when present).

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use serde_json::Value;
use vestibule_dat::DatSet;
use vestibule_testing::vectors;
use vestibule_world::{CellArray, CellId, Sphere, World, find_cell_list};

struct Worlds {
    dir: PathBuf,
    open: HashMap<String, World>,
}

impl Worlds {
    fn get(&mut self, name: &str) -> &World {
        let dir = self.dir.join("worlds").join(name);
        self.open
            .entry(name.to_owned())
            .or_insert_with(|| World::open(DatSet::open_in_memory(dir).unwrap()).unwrap())
    }
}

fn cases(dir: &Path, file: &str) -> Vec<Value> {
    let text = std::fs::read_to_string(dir.join(file)).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn vec3(v: &Value) -> Vec3 {
    let at = |i: usize| v[i].as_f64().unwrap() as f32;
    Vec3::new(at(0), at(1), at(2))
}

fn cell(v: &Value) -> CellId {
    CellId(u32::try_from(v.as_u64().unwrap()).unwrap())
}

fn flagged(case: &Value) -> bool {
    case["sensitive"] == true || case["suspect"] == true
}

#[test]
fn find_cell_list_agrees_with_the_vectors() {
    let Some(dir) = vectors("look-up vectors") else {
        return;
    };
    let mut worlds = Worlds {
        dir: dir.clone(),
        open: HashMap::new(),
    };
    let mut array = CellArray::new();
    let (mut agree, mut differ) = (0, Vec::new());
    for case in cases(&dir, "find_cell_list.jsonl") {
        let world = worlds.get(case["world"].as_str().unwrap());
        let (input, expect) = (&case["in"], &case["expect"]);
        let pos = vec3(&input["pos"]);
        let spheres: Vec<Sphere> = input["spheres"]
            .as_array()
            .unwrap()
            .iter()
            .map(|s| Sphere::new(pos + vec3(s), s[3].as_f64().unwrap() as f32))
            .collect();
        let found = find_cell_list(world, cell(&input["cell"]), pos, &spheres, &mut array, true);
        let cells: Vec<CellId> = array.entries().iter().map(|e| e.id).collect();
        let expected: Vec<CellId> = expect["cells"].as_array().unwrap().iter().map(cell).collect();
        let same = cells == expected
            && found.containing.unwrap_or_default() == cell(&expect["containing"])
            && found.hits_interior == expect["hits_interior"].as_bool().unwrap();
        if same {
            agree += 1;
        } else if !flagged(&case) {
            differ.push(format!("{}: {found:?} {cells:?}, expected {expect}", case["id"]));
        }
    }
    assert!(
        differ.is_empty(),
        "{agree} agree, {} differ:\n{}",
        differ.len(),
        differ[..differ.len().min(10)].join("\n")
    );
    assert_eq!(agree, 620);
}

#[test]
fn single_look_ups_agree_with_the_vectors() {
    let Some(dir) = vectors("look-up vectors") else {
        return;
    };
    let mut worlds = Worlds {
        dir: dir.clone(),
        open: HashMap::new(),
    };
    let (mut agree, mut differ) = (0, Vec::new());
    for case in cases(&dir, "misc.jsonl") {
        let world = worlds.get(case["world"].as_str().unwrap());
        let (input, expect) = (&case["in"], &case["expect"]);
        let (id, pos) = (cell(&input["cell"]), vec3(&input["pos"]));
        let same = match case["op"].as_str() {
            Some("point_in_cell") => world.point_in_cell(id, pos) == expect["inside"].as_bool().unwrap(),
            Some("terrain_z") => match world.ground_at(id, pos) {
                Some(ground) => {
                    let n = ground.polygon.plane.normal;
                    let close = |a: f32, b: &Value| (a - b.as_f64().unwrap() as f32).abs() < 0.001;
                    ground.cell == cell(&expect["cell"])
                        && close(ground.z, &expect["z"])
                        && close(n.x, &expect["plane"][0])
                        && close(n.y, &expect["plane"][1])
                        && close(n.z, &expect["plane"][2])
                        && close(ground.polygon.plane.d, &expect["plane"][3])
                        && close(ground.water_depth(), &expect["water_depth"])
                }
                None => false,
            },
            other => panic!("{other:?}"),
        };
        if same {
            agree += 1;
        } else if !flagged(&case) {
            differ.push(case.to_string());
        }
    }
    assert!(
        differ.is_empty(),
        "{agree} agree, {} differ:\n{}",
        differ.len(),
        differ[..differ.len().min(10)].join("\n")
    );
    assert_eq!(agree, 168);
}
