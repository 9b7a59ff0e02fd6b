//! Measures how seamless the pictures are: the traversal against everything drawn at once, and against rays.
//!
//! ```text
//! cargo run --release -p vestibule-render --example seamless -- [POSES] [WORLD...]
//! ```
//!
//! A WORLD is a folder of the test vectors, or the path of a folder with DAT files followed by `:` and a landblock
//! (`path/to/dats:0xA9B4`), or `thresholds`: every opening of the built-in world walked through in steps of 1 cm, from a
//! metre before to a metre behind it.

use std::io::Write as _;
use std::time::Instant;

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Difference, Random, Rooms, Stage, camera, compare, compare_with_oracle, mixed_camera};
use vestibule_render::PixelKind;
use vestibule_world::{BlockId, CellId, World};

const SIZE: (u32, u32) = (64, 48);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let poses: usize = arguments.next().map_or(Ok(2000), |a| a.parse())?;
    let mut names: Vec<String> = arguments.collect();
    if names.is_empty() {
        names = [
            "dungeon-1",
            "maze-1",
            "gallery-1",
            "hollow",
            "hollow-deep",
            "thresholds",
        ]
        .map(str::to_owned)
        .into();
    }
    let mut out = std::io::stdout().lock();
    for name in names {
        if name == "thresholds" {
            walk_thresholds(&mut out)?;
            continue;
        }
        let mut names = std::collections::BTreeMap::new();
        let stage = if let Some(block) = [("hollow", 0xA9B4), ("hollow-deep", 0x0107)]
            .iter()
            .find_map(|(n, b)| (*n == name).then_some(*b))
        {
            let (stage, found) = Stage::hollow(block);
            names = found;
            Some(stage)
        } else {
            match name.split_once(':') {
                Some((folder, block)) => {
                    let block = u16::from_str_radix(block.trim_start_matches("0x"), 16)?;
                    let world = World::open(vestibule_dat::DatSet::open(folder)?)?;
                    Some(Stage::new(world, BlockId(block)))
                }
                None => Stage::vectors(&name),
            }
        };
        let Some(mut stage) = stage else { continue };
        let sealed = stage
            .world
            .block(stage.block)
            .is_some_and(|b| b.buildings.is_empty());
        let inner: std::collections::BTreeSet<CellId> = names
            .iter()
            .filter(|(id, n)| {
                // Cells that cannot see the outside: there no ground or shell stands among the rooms.
                n.contains("mine") && stage.world.env_cell(**id).is_some_and(|c| !c.seen_outside)
            })
            .map(|(id, _)| *id)
            .collect();
        let mine = |id: CellId| inner.contains(&id);
        if sealed {
            let rooms = Rooms::new(&stage);
            against_everything(&mut stage, &rooms, &name, poses, &mut out)?;
        } else if names.values().any(|n| n.contains("mine")) {
            let rooms = Rooms::only(&stage, mine);
            against_everything(&mut stage, &rooms, &format!("{name}, mine"), poses, &mut out)?;
        }
        against_rays(&mut stage, &name, poses, &mut out)?;
        writeln!(out, "{name}: assets {:?}", stage.assets.counters())?;
    }
    Ok(())
}

fn walk_thresholds(out: &mut impl std::io::Write) -> std::io::Result<()> {
    let started = Instant::now();
    let mut all = common::Walked::default();
    for block in [0xA9B4, 0x0107] {
        let (mut stage, _) = Stage::hollow(block);
        let right = common::Walk::Right;
        all.add(common::walk(
            &mut stage,
            (96, 72),
            (100, 1),
            right,
            |stage, camera| stage.ids(camera),
        ));
    }
    writeln!(
        out,
        "thresholds: {} of {} walked, {} of them exits; {} pictures after another, in {} of them pixels flash, at most {} of \
         6912; {:.1} s",
        all.crossed,
        all.all,
        all.exits,
        all.pictures,
        all.flashes,
        all.worst,
        started.elapsed().as_secs_f32()
    )
}

fn against_everything(
    stage: &mut Stage,
    rooms: &Rooms,
    name: &str,
    poses: usize,
    out: &mut impl std::io::Write,
) -> std::io::Result<()> {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut total = Difference::default();
    let mut worst = 0;
    let started = Instant::now();
    for pose in 0..poses {
        let (cell, eye) = rooms.eye(stage, &mut random);
        let camera = camera(cell, eye, random.direction(), (160, 120), 1.2);
        let picture = stage.ids(camera);
        let all = stage.everything(&camera);
        let d = compare(&picture, &all);
        if d.differing > 0 || d.clear > 0 {
            worst += 1;
            if worst <= 5 {
                writeln!(out, "  pose {pose}: {camera:?}: {d:?}")?;
                let mut shown = 0;
                for y in 0..picture.height() {
                    for x in 0..picture.width() {
                        let (a, b) = (picture.get(x, y), all.get(x, y));
                        if (a != b || a.is_some_and(|a| a.kind() == PixelKind::Background)) && shown < 4 {
                            shown += 1;
                            writeln!(out, "    ({x},{y}) {} | {}", tell(a), tell(b))?;
                        }
                    }
                }
            }
        }
        total.add(d);
    }
    writeln!(
        out,
        "{name}: {poses} poses against everything: {} of {} pixels differ, {} clear, {:.1} s",
        total.differing,
        total.pixels,
        total.clear,
        started.elapsed().as_secs_f32()
    )
}

fn tell(id: Option<vestibule_render::PixelId>) -> String {
    id.map_or_else(String::new, |id| {
        format!(
            "{:?} {} #{}",
            id.kind(),
            id.cell().unwrap_or(CellId(0)),
            id.item()
        )
    })
}

fn against_rays(
    stage: &mut Stage,
    name: &str,
    poses: usize,
    out: &mut impl std::io::Write,
) -> std::io::Result<()> {
    let rooms = Rooms::new(stage);
    let oracle = stage.oracle();
    let mut random = Random(0x2545_F491_4F6C_DD1D);
    let mut total = Difference::default();
    let mut reported = 0;
    let started = Instant::now();
    for pose in 0..poses {
        let camera = mixed_camera(stage, &rooms, &mut random, SIZE);
        let picture = stage.ids(camera);
        let mut lines = Vec::new();
        let d = compare_with_oracle(&picture, &oracle, &camera, |x, y, shown, truth| {
            lines.push(format!(
                "    ({x},{y}) shows {}, rays {}",
                tell(Some(shown)),
                tell(Some(truth))
            ));
        });
        if !lines.is_empty() && reported < 12 {
            reported += 1;
            writeln!(
                out,
                "  pose {pose} {:?} {} {}: {} unexplained",
                camera.cell(),
                camera.eye(),
                camera.forward(),
                lines.len()
            )?;
            for line in lines.iter().take(3) {
                writeln!(out, "{line}")?;
            }
        }
        total.add(d);
    }
    writeln!(
        out,
        "{name}: {poses} poses against rays: {} of {} pixels differ: {} where surfaces meet within a pixel and one of \
         them shows, {} where another does, {} where rooms disagree on an opening, {} elsewhere; {} clear, {} of them \
         where rooms disagree; {:.1} s",
        total.differing,
        total.pixels,
        total.at_edges,
        total.at_seams,
        total.disputed,
        total.unexplained(),
        total.clear,
        total.clear_disputed,
        started.elapsed().as_secs_f32()
    )
}
