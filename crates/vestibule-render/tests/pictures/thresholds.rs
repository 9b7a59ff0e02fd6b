//! Walking through every opening.

use crate::*;

#[test]
fn every_threshold_in_centimetre_steps_changes_no_picture_abruptly() {
    let mut worst = 0.0f32;
    let mut walked = 0;
    let mut broken = 0.0f32;
    for block in [VILLAGE, DEEP] {
        let mut stage = Stage::hollow(block).0;
        let rooms = Rooms::new(&stage);
        let cells: Vec<CellId> = stage
            .world
            .block(stage.block)
            .unwrap()
            .env_cells()
            .map(|c| c.id)
            .collect();
        for id in cells {
            let cell = stage.world.env_cell(id).unwrap().clone();
            for portal in &cell.portals {
                let PortalTarget::Cell(other) = portal.other else {
                    continue;
                };
                // Each threshold once, level ones only.
                let out = portal.plane.normal * if portal.interior_is_negative { 1.0 } else { -1.0 };
                if other < id || out.z.abs() > 0.5 {
                    continue;
                }
                let corners = cell.portal_vertices(portal);
                let low = corners.iter().map(|c| c.z).fold(f32::INFINITY, f32::min);
                let mut middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
                middle.z = (low + middle.z) * 0.5;
                let (middle, out) = (
                    cell.frame.local_to_global(middle),
                    cell.frame.local_to_global_vec(out),
                );
                let reach = if poses(0) > 0 { 50 } else { 12 };
                let mut before: Option<IdImage> = None;
                for k in -reach..=reach {
                    let eye = middle + out * (k as f32 * 0.01 + 0.0013);
                    let Some(at) = [id, other]
                        .into_iter()
                        .find(|&c| stage.world.env_cell(c).is_some_and(|c| c.contains_point(eye)))
                    else {
                        before = None;
                        continue;
                    };
                    if !rooms.is_clear(at, eye, 0.2) {
                        before = None;
                        continue;
                    }
                    let camera = camera(at, eye, out + Vec3::new(0.05, 0.03, -0.02), SMALL, 1.2);
                    let picture = stage.ids(camera);
                    if let Some(last) = &before {
                        // A step of 1 cm with everything 0.2 m away or more moves an edge by a few pixels.
                        let change = changed(last, &picture);
                        worst = worst.max(change);
                        walked += 1;
                    }
                    if k == 1 {
                        let cut = without(&stage, |c| matches!(c, Command::Room { cell, .. } if *cell == at));
                        broken = broken.max(changed(&picture, &ids_of(&stage, &cut)));
                    }
                    before = Some(picture);
                }
            }
        }
    }
    assert!(walked > 300, "{walked}");
    assert!(worst < 0.15, "{worst}");
    assert!(broken > 0.3, "{broken}");
}
