//! `evidence.md` E1 as a walk: the recorded doorway.

use vestibule_testing::doorway_e1;

use crate::rig::*;
use crate::sweep::Carried;

#[test]
fn e1_walking_between_the_rows_of_the_recording_gives_their_cells() {
    // Two metres lower than in the game, so that the ground plays no part.
    let mut rig = Rig::of(doorway_e1::doorway(46));
    // The rooms have no floors: each move is made without contact, level.
    let player = crate::sweep::Mover::player();
    let mut at =
        vestibule_world::Position::new(doorway_e1::rows()[0].seed, v(155.375, 17.0, doorway_e1::FLOOR));
    for (i, row) in doorway_e1::rows().iter().enumerate() {
        // Between rows 16 and 17 a change is missing from the log: the walk goes through it.
        if i != 16 {
            assert_eq!(at.cell, row.seed, "before row {}", i + 1);
        }
        let to = vestibule_world::Position::new(at.cell, row.feet);
        let swept = crate::sweep::sweep(
            &rig.world,
            &rig.population,
            &mut rig.scratch,
            &player,
            &Carried::default(),
            &at,
            &to,
        )
        .unwrap();
        assert_eq!((swept.ok, swept.cell), (true, Some(row.picked)), "row {}", i + 1);
        assert!((swept.position.origin() - to.origin()).length() < 1e-4);
        at = swept.position;
    }
}
