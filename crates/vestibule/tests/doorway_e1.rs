//! `evidence.md` E1: the doorway recorded from the retail client, 19 rows of 19.

use glam::Vec3;
use vestibule::locate::player_spheres;
use vestibule::replay;
use vestibule::walker::Walker;
use vestibule::world::{BlockId, CellArray, CellId, Position, World, find_cell_list};
use vestibule_testing::doorway_e1;

const BLOCK: u32 = 0xA9B4_0000;

/// The table of E1.
const LOG: &str = "\
| # | seed | x | y | z | picked |
|---|---|---|---|---|---|
| 1 | 0031 | 155.3717 | 16.0283 | 94.0050 | 0170 |
| 2 | 0170 | 155.3438 | 15.1343 | 94.0050 | 0171 |
| 3 | 0171 | 155.3463 | 15.2186 | 94.0050 | 0170 |
| 4 | 0170 | 155.3742 | 16.1126 | 94.0050 | 0031 |
| 5 | 0031 | 155.3723 | 16.0516 | 94.0050 | 0170 |
| 6 | 0170 | 155.3431 | 15.1187 | 94.0050 | 0171 |
| 7 | 0171 | 155.3445 | 15.1641 | 94.0050 | 0170 |
| 8 | 0170 | 155.3748 | 16.1358 | 94.0050 | 0031 |
| 9 | 0031 | 155.3692 | 15.9583 | 94.0050 | 0170 |
| 10 | 0170 | 155.3437 | 15.1420 | 94.0050 | 0171 |
| 11 | 0171 | 155.3451 | 15.1874 | 94.0050 | 0170 |
| 12 | 0170 | 155.3730 | 16.0814 | 94.0050 | 0031 |
| 13 | 0031 | 155.3721 | 16.0571 | 94.0050 | 0170 |
| 14 | 0170 | 155.3418 | 15.0854 | 94.0050 | 0171 |
| 15 | 0171 | 155.3456 | 15.2085 | 94.0050 | 0170 |
| 16 | 0170 | 155.3735 | 16.1025 | 94.0050 | 0031 |
| 17 | 0170 | 155.3435 | 15.1454 | 94.0050 | 0171 |
| 18 | 0171 | 155.3461 | 15.2296 | 94.0050 | 0170 |
| 19 | 0170 | 155.3740 | 16.1236 | 94.0050 | 0031 |
";

/// The doorway, with the ground below its floor, so that only cells matter.
fn doorway() -> World {
    doorway_e1::doorway(45).world()
}

#[test]
fn e1_nineteen_of_nineteen_rows() {
    let world = doorway();
    let rows = replay::read(LOG, 0xA9B4).unwrap();
    assert_eq!(rows.len(), 19);
    assert_eq!(world.problems(), []);
    let report = replay::run(&world, &rows);
    assert_eq!((report.agree, report.rows), (19, 19), "{:#?}", report.differences);
}

/// What the rows settle: the point is the centre of the first sphere, neither the feet nor the second sphere's centre.
#[test]
fn e1_other_points_explain_fewer_rows() {
    let world = doorway();
    let rows = replay::read(LOG, 0xA9B4).unwrap();
    let explained = |which: fn(Vec3) -> Vec3| {
        let mut cells = CellArray::new();
        rows.iter()
            .filter(|row| {
                let mut spheres = player_spheres(row.pos);
                spheres[0].center = which(row.pos);
                let seed = row.seed.unwrap();
                find_cell_list(&world, seed, row.pos, &spheres, &mut cells, true).containing == Some(row.cell)
            })
            .count()
    };
    assert_eq!(explained(|feet| feet + Vec3::new(0.0, 0.0, 0.475)), 19);
    assert_eq!(explained(|feet| feet), 17);
    assert_eq!(explained(|feet| feet + Vec3::new(0.0, 0.0, 1.35)), 16);
}

/// Walking from row to row by sweeps ends in the same cells, the row that the log lacks included.
#[test]
fn e1_as_a_sequence_of_sweeps() {
    let world = doorway();
    let rows = replay::read(LOG, 0xA9B4).unwrap();
    let mut walker = Walker::new(&world, BlockId(0xA9B4));
    let outside = Position::new(CellId(BLOCK | 0x31), Vec3::new(155.38, 16.4, 94.005));
    let mut footing = vestibule::walker::Footing {
        at: outside,
        carried: Default::default(),
        rise: 0.0,
    };
    for row in &rows {
        // Nothing to stand on was recorded: without contact the body does not look for ground.
        footing.carried = Default::default();
        footing = walker.sweep_to(&footing, row.pos);
        assert_eq!(footing.at.cell, row.cell, "line {}", row.line);
        assert!(
            footing.at.origin().distance(row.pos) < 0.01,
            "line {}: {}",
            row.line,
            footing.at
        );
    }
}
