//! Walking through every opening of the built-in world: only edges move (`common/walk.rs` tells how that is told).
//!
//! All of them for a metre to each side: `cargo run --release -p vestibule-render --example seamless -- 2000 thresholds`.

use crate::common::{Walk, Walked, walk};
use crate::*;

const SIZE: (u32, u32) = (96, 72);
/// Pixels that may change otherwise: far things as small as a few pixels come out from behind an edge.
const LIMIT: usize = 8;

fn walk_hollow(
    (steps, every): (i32, usize),
    how: Walk,
    mut draw: impl FnMut(&mut Stage, Camera) -> IdImage,
) -> Walked {
    let mut out = Walked::default();
    for block in [VILLAGE, DEEP] {
        let mut stage = Stage::hollow(block).0;
        if how != Walk::Right {
            let mut settings = *stage.frame.settings();
            settings.flood.guard_wrong_cell = false;
            stage.frame = FrameView::new(settings);
        }
        out.add(walk(&mut stage, SIZE, (steps, every), how, &mut draw));
    }
    out
}

#[test]
fn walking_every_threshold_in_centimetre_steps_moves_edges_only() {
    let walked = walk_hollow((2, 1), Walk::Right, |stage, camera| stage.ids(camera));
    assert!(walked.crossed == walked.all && walked.exits >= 12, "{walked:?}");
    assert!(walked.worst <= LIMIT, "{walked:?}");
}

#[test]
fn a_camera_that_keeps_its_cell_flashes_at_thresholds() {
    // Beyond the opening that lies behind the camera: the room ahead is lost.
    let walked = walk_hollow((2, 3), Walk::StaticCell, |stage, camera| stage.ids(camera));
    assert!(walked.worst > 10 * LIMIT, "{walked:?}");
}

#[test]
fn a_camera_whose_cell_is_derived_from_coordinates_flashes_at_thresholds() {
    let walked = walk_hollow((3, 3), Walk::Jitter, |stage, camera| stage.ids(camera));
    assert!(walked.worst > 10 * LIMIT, "{walked:?}");
}

#[test]
fn a_neighbour_that_is_forgotten_flashes_at_thresholds() {
    let walked = walk_hollow((2, 3), Walk::Right, |stage, camera| {
        stage.update(camera);
        let root = camera.cell();
        let own = without(
            stage,
            |c| matches!(c, Command::Room { cell, .. } if *cell != root),
        );
        ids_of(stage, &own)
    });
    assert!(walked.worst > 10 * LIMIT, "{walked:?}");
}
