//! Properties over random worlds of connected rooms (`visibility.md` 15, 17).

mod common;

use std::io::Write as _;

use common::maze::{Maze, Random, connected, walk};
use common::*;
use glam::{Vec2, Vec3};
use vestibule_view::{BlockOpenings, Camera, Flood, FloodSettings, PView};
use vestibule_world::{BlockId, CellId, PortalTarget};

const WORLDS: u64 = 10_000;
const RAYS: usize = 400;

fn ids_of(flood: &Flood<'_>) -> Vec<CellId> {
    flood.cells().iter().map(|c| c.id).collect()
}

fn sorted(mut ids: Vec<CellId>) -> Vec<CellId> {
    ids.sort_unstable();
    ids
}

/// I7 completeness, I1-I3, I5, I9: no room that a ray enters is missing, and the ray lies in one of its views.
#[test]
fn s17_2_no_ray_escapes_the_views() {
    let mut pview = PView::default();
    let (mut views, mut crossings, mut most) = (0usize, 0usize, 0usize);
    for seed in 0..WORLDS {
        let mut random = Random(seed);
        let mut maze = Maze::random(&mut random, seed % 2 == 1);
        let camera = maze.camera(&mut random);
        let openings = maze.rooms.build();
        let flood = pview.look_in_block(Some(&openings), &camera);
        assert!(!flood.truncated(), "seed {seed}");
        views += flood.view_count();
        most = most.max(flood.view_count());
        let list = ids_of(&flood);
        assert_eq!(list[0], camera.cell(), "I1, seed {seed}");
        let mut unique = sorted(list.clone());
        unique.dedup();
        assert_eq!(unique.len(), list.len(), "I2, seed {seed}");
        let root = usize::from(camera.cell().low() - 0x100);
        let reachable = connected(&maze.rooms.specs, root);
        for (at, cell) in flood.cells().iter().enumerate() {
            assert!(flood.regions(cell).len() >= 1, "I3, seed {seed}");
            assert!(
                reachable.contains(&usize::from(cell.id.low() - 0x100)),
                "I9, seed {seed}"
            );
            assert_eq!(cell.reached_from.is_none(), at == 0, "I5, seed {seed}");
            check_views(&flood, cell, &camera, seed);
        }
        for _ in 0..RAYS {
            let pixel = Vec2::new(random.within(0.0, VIEWPORT.x), random.within(0.0, VIEWPORT.y));
            let ray = camera.ray_through(pixel).normalize();
            let walked = walk(&maze.rooms.specs, root, camera.eye(), ray);
            crossings += walked.rooms.len() - 1;
            for room in &walked.rooms {
                let at = flood
                    .position(*room)
                    .unwrap_or_else(|| panic!("I7, seed {seed}: {room} is missing"));
                assert!(
                    flood.regions(&flood.cells()[at]).any(|r| r.contains(ray, 1.0e-5)),
                    "I7, seed {seed}: a ray enters {room} outside its views"
                );
            }
            if walked.outside {
                assert!(
                    flood.outside().any(|r| r.contains(ray, 1.0e-5)),
                    "I7, seed {seed}: outside"
                );
            }
        }
    }
    let _ = writeln!(
        std::io::stderr(),
        "{WORLDS} worlds, {RAYS} rays each: {crossings} doors crossed, {views} views, at most {most} in a flood"
    );
}

/// I4: convex, few edges, inside the viewport and inside the view they came from.
fn check_views(flood: &Flood<'_>, cell: &vestibule_view::SeenCell, camera: &Camera, seed: u64) {
    for view in flood.views(cell) {
        let region = flood.region(view);
        assert!((3..=12).contains(&region.edges().len()), "I4, seed {seed}");
        for e in region.edges() {
            assert!(region.contains(e.corner, 1.0e-5), "I4 convex, seed {seed}");
            let c = camera.to_camera(e.corner);
            let limit = |slope: f32| slope * c.y + 1.0e-4;
            assert!(
                c.x.abs() <= limit(camera.slopes().x) && c.z.abs() <= limit(camera.slopes().y),
                "I4, {seed}"
            );
            if let Some(parent) = view.parent.and_then(|p| flood.view(p)) {
                assert!(
                    flood.region(parent).contains(e.corner, 1.0e-5),
                    "I4 parent, seed {seed}"
                );
            }
        }
    }
}

/// I6 soundness: in convex rooms the middle of each view really reaches its room.
#[test]
fn i6_the_middle_of_every_view_reaches_its_room() {
    let mut pview = PView::default();
    let mut checked = 0;
    for seed in 0..2_000 {
        let mut random = Random(seed);
        let mut maze = Maze::random(&mut random, false);
        assert!(maze.convex);
        let camera = maze.camera(&mut random);
        let openings = maze.rooms.build();
        let flood = pview.look_in_block(Some(&openings), &camera);
        let root = usize::from(camera.cell().low() - 0x100);
        for cell in flood.cells() {
            for region in flood.regions(cell) {
                let ray = region.middle().unwrap().normalize();
                let walked = walk(&maze.rooms.specs, root, camera.eye(), ray);
                // A sliver thinner than the arithmetic resolves proves nothing.
                let thin = region.pixel_area(&camera) < 1.0e-2;
                assert!(
                    walked.rooms.contains(&cell.id) || thin,
                    "seed {seed}, {}",
                    cell.id
                );
                checked += 1;
            }
        }
        for region in flood.outside() {
            let ray = region.middle().unwrap().normalize();
            let walked = walk(&maze.rooms.specs, root, camera.eye(), ray);
            assert!(
                walked.outside || region.pixel_area(&camera) < 1.0e-2,
                "seed {seed}"
            );
        }
    }
    assert!(checked > 2_000);
}

/// I10: the same input gives the same bits, whatever ran before.
#[test]
fn i10_results_do_not_depend_on_history() {
    let mut used = PView::default();
    for seed in 0..300 {
        let mut random = Random(seed);
        let mut maze = Maze::random(&mut random, seed % 2 == 0);
        let camera = maze.camera(&mut random);
        let openings = maze.rooms.build();
        let mut fresh = PView::default();
        let a = fresh.look_in_block(Some(&openings), &camera);
        let b = used.look_in_block(Some(&openings), &camera);
        assert_eq!(a.cells(), b.cells(), "seed {seed}");
        for (x, y) in a.cells().iter().zip(b.cells()) {
            assert!(a.regions(x).eq(b.regions(y)), "seed {seed}");
        }
        assert!(a.outside().eq(b.outside()), "seed {seed}");
    }
}

/// I12: closing a door never adds a room.
#[test]
fn i12_closing_a_door_never_adds_a_room() {
    let mut pview = PView::default();
    for seed in 0..1_000 {
        let mut random = Random(seed);
        let mut maze = Maze::random(&mut random, seed % 2 == 0);
        let camera = maze.camera(&mut random);
        let before = ids_of(&pview.look_in_block(Some(&maze.rooms.build()), &camera));
        let room = random.below(maze.rooms.specs.len());
        if maze.rooms.specs[room].portals.is_empty() {
            continue;
        }
        let portal = random.below(maze.rooms.specs[room].portals.len());
        maze.rooms.specs[room].portals[portal].vertices = vec![Vec3::ZERO; 4];
        let after = ids_of(&pview.look_in_block(Some(&maze.rooms.build()), &camera));
        assert!(after.iter().all(|id| before.contains(id)), "seed {seed}");
    }
}

/// 17.5 and 17.6: neither turning the world with its camera nor another landblock changes the list.
#[test]
fn s17_5_s17_6_moving_the_world_with_its_camera_changes_nothing() {
    let mut pview = PView::default();
    let mut slivers = 0;
    for seed in 0..500 {
        let mut random = Random(seed);
        let mut maze = Maze::random(&mut random, false);
        let camera = maze.camera(&mut random);
        let first = pview.look_in_block(Some(&maze.rooms.build()), &camera);
        let (before, order) = (first.cells().to_vec(), ids_of(&first));
        let smallest = first
            .cells()
            .iter()
            .flat_map(|c| first.regions(c))
            .map(|r| r.pixel_area(&camera))
            .fold(f32::INFINITY, f32::min);
        // Transport: bit for bit.
        for block in [BlockId(0x0000), BlockId(0xFEFE)] {
            let mut moved = maze.rooms.clone();
            for spec in &mut moved.specs {
                spec.id = CellId::new(block, spec.id.low());
                for portal in &mut spec.portals {
                    if let PortalTarget::Cell(id) = &mut portal.target {
                        *id = CellId::new(block, id.low());
                    }
                }
            }
            let openings = BlockOpenings::from_rooms(block, &moved.specs);
            let there = camera_in(&camera, CellId::new(block, camera.cell().low()));
            let flood = pview.look_in_block(Some(&openings), &there);
            let keys: Vec<(u16, f32)> = flood.cells().iter().map(|c| (c.id.low(), c.key)).collect();
            assert_eq!(
                keys,
                before.iter().map(|c| (c.id.low(), c.key)).collect::<Vec<_>>(),
                "seed {seed}"
            );
        }
        // A quarter turn about z.
        let turn = |p: Vec3| Vec3::new(-p.y, p.x, p.z);
        for spec in &mut maze.rooms.specs {
            let h = core::f32::consts::FRAC_1_SQRT_2;
            let rotation = glam::Quat::from_xyzw(0.0, 0.0, h, h) * spec.frame.rotation();
            spec.frame = vestibule_world::Frame::new(turn(spec.frame.origin), rotation);
        }
        let [_, forward, up] = *camera.axes();
        let fov = 2.0 * libm::atanf(camera.slopes().y);
        let turned = Camera::new(
            camera.cell(),
            turn(camera.eye()),
            turn(forward),
            turn(up),
            fov,
            VIEWPORT,
        )
        .unwrap();
        let flood = pview.look_in_block(Some(&maze.rooms.build()), &turned);
        if smallest < 1.0 {
            slivers += 1;
        } else {
            assert_eq!(sorted(ids_of(&flood)), sorted(order), "seed {seed}");
        }
    }
    assert!(slivers < 250, "{slivers}");
}

fn camera_in(camera: &Camera, cell: CellId) -> Camera {
    let [_, forward, up] = *camera.axes();
    let fov = 2.0 * libm::atanf(camera.slopes().y);
    Camera::new(cell, camera.eye(), forward, up, fov, VIEWPORT).unwrap()
}

/// 17.8: the order of portals in the data does not change the set.
#[test]
fn s17_8_portal_order_does_not_change_the_set() {
    let mut pview = PView::default();
    for seed in 0..1_000 {
        let mut random = Random(seed);
        let mut maze = Maze::random(&mut random, seed % 2 == 0);
        let camera = maze.camera(&mut random);
        let before = sorted(ids_of(&pview.look_in_block(Some(&maze.rooms.build()), &camera)));
        // Turn each room's list of portals round and mend the links.
        let counts: Vec<u16> = maze.rooms.specs.iter().map(|s| s.portals.len() as u16).collect();
        for spec in &mut maze.rooms.specs {
            spec.portals.reverse();
            for portal in &mut spec.portals {
                if let (PortalTarget::Cell(id), Some(other)) = (portal.target, &mut portal.other_portal) {
                    *other = counts[usize::from(id.low() - 0x100)] - 1 - *other;
                }
            }
        }
        let after = sorted(ids_of(&pview.look_in_block(Some(&maze.rooms.build()), &camera)));
        assert_eq!(before, after, "seed {seed}");
    }
}

/// 14.6, 17.2: retail mode lists a subset, apart from the gate's and slivers' losses nothing else.
#[test]
fn retail_mode_lists_a_subset() {
    let (mut pview, mut retail) = (PView::default(), PView::new(FloodSettings::retail()));
    for seed in 0..1_000 {
        let mut random = Random(seed);
        let mut maze = Maze::random(&mut random, seed % 2 == 0);
        let camera = maze.camera(&mut random);
        let openings = maze.rooms.build();
        let ours = sorted(ids_of(&pview.look_in_block(Some(&openings), &camera)));
        let theirs = ids_of(&retail.look_in_block(Some(&openings), &camera));
        assert!(theirs.iter().all(|id| ours.contains(id)), "seed {seed}");
    }
}

/// 17.3: walking through doors by millimetres, no room with a visible area flickers out for one frame.
#[test]
fn s17_3_no_room_flickers_on_a_path_through_a_door() {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", (-5.0, 5.0), (-5.0, 5.0));
    let b = rooms.room("B", (-5.0, 5.0), (5.0, 15.0));
    let c = rooms.room("C", (5.0, 15.0), (5.0, 15.0));
    rooms.door(a, b, &at_y(5.0, (-1.0, 1.0), TALL));
    rooms.door(b, c, &at_x(5.0, (9.0, 11.0), TALL));
    let openings = rooms.build();
    let mut pview = PView::default();
    for look in [Vec3::Y, Vec3::X, Vec3::new(1.0, 1.0, 0.0)] {
        let mut last: Option<Vec<(CellId, f32)>> = None;
        for step in 0..2_000 {
            let y = 4.0 + step as f32 * 1.0e-3;
            let root = if y < 5.0 { a } else { b };
            let camera = camera(root, v(0.1, y, 1.5), look, 1.0);
            let flood = pview.look_in_block(Some(&openings), &camera);
            let now: Vec<(CellId, f32)> = flood
                .cells()
                .iter()
                .map(|c| (c.id, flood.regions(c).map(|r| r.pixel_area(&camera)).sum()))
                .collect();
            if let Some(before) = &last {
                for (id, area) in before {
                    // The room just left is behind the eye.
                    let left = *id == id_of(a) && root == b;
                    assert!(
                        left || *area < 600.0 || now.iter().any(|(n, _)| n == id),
                        "{id} with {area} px is gone at y {y}"
                    );
                }
            }
            last = Some(now);
        }
    }
}

fn id_of(room: usize) -> CellId {
    id(room)
}

/// What could be seen from a room holds everything any eye in it sees; what it sees all around holds what it sees
/// ahead.
#[test]
fn sight_without_a_camera_holds_every_camera() {
    let mut pview = PView::default();
    let (mut listed, mut reachable) = (0, 0);
    for seed in 0..600 {
        let mut random = Random(seed);
        let mut maze = Maze::random(&mut random, seed % 4 == 0);
        let openings = maze.rooms.build();
        let first = maze.camera(&mut random);
        let root = usize::from(first.cell().low() - 0x100);
        let could = vestibule_view::potentially_visible(&openings, first.cell());
        assert!(!could.truncated && could.cells.contains(&first.cell()));
        listed += could.cells.len();
        reachable += connected(&maze.rooms.specs, root).len();
        for _ in 0..60 {
            let camera = maze.camera(&mut random);
            if camera.cell() != first.cell() {
                continue;
            }
            let around = pview.look_around(Some(&openings), camera.cell(), camera.eye());
            let (all, out) = (ids_of(&around), around.sees_outside());
            assert!(all.iter().all(|id| could.cells.contains(id)), "seed {seed}");
            assert!(!out || could.outside, "seed {seed}");
            let flood = pview.look_in_block(Some(&openings), &camera);
            assert!(flood.cells().iter().all(|c| all.contains(&c.id)), "seed {seed}");
            assert!(!flood.sees_outside() || out, "seed {seed}");
        }
    }
    let _ = writeln!(
        std::io::stderr(),
        "could be seen: {listed} of {reachable} reachable rooms"
    );
    assert!(listed < reachable);
}

/// 17.4: whoever is seen can look back.
#[test]
fn s17_4_sight_is_mutual() {
    let mut pview = PView::default();
    let mut checked = 0;
    for seed in 0..2_000 {
        let mut random = Random(seed);
        let mut maze = Maze::random(&mut random, false);
        let camera = maze.camera(&mut random);
        let openings = maze.rooms.build();
        let root = usize::from(camera.cell().low() - 0x100);
        let flood = pview.look_in_block(Some(&openings), &camera);
        let rays: Vec<(CellId, Vec3)> = flood
            .cells()
            .iter()
            .skip(1)
            .flat_map(|c| flood.regions(c).map(|r| (c.id, r)))
            .filter(|(_, r)| r.pixel_area(&camera) > 1.0)
            .map(|(id, r)| (id, r.middle().unwrap().normalize()))
            .collect();
        for (id, ray) in rays {
            let walked = walk(&maze.rooms.specs, root, camera.eye(), ray);
            let Some(at) = walked.rooms.iter().position(|r| *r == id) else {
                continue;
            };
            let there = camera.eye() + ray * (walked.entered[at] as f32 + 0.02);
            let back = Camera::new(id, there, -ray, Vec3::Z, 1.0, VIEWPORT).unwrap();
            assert!(
                pview.look_in_block(Some(&openings), &back).sees(camera.cell()),
                "seed {seed}"
            );
            checked += 1;
        }
    }
    assert!(checked > 1_000, "{checked}");
}
