//! The cell a frame starts from.

use vestibule_view::{CameraRig, ChaseCamera, PIVOT_OFFSET, ViewerSource, ViewerTarget, update_viewer};

use crate::*;

#[test]
fn r5_the_frame_is_the_cameras_not_the_players() {
    let mut stage = village();
    for camera in [before_cottage(SMALL), in_cottage(SMALL)] {
        let mut pictures = Vec::new();
        for player in [None, Some(0xA9B4_0031), Some(0xA9B4_0101), Some(0x0107_0100)] {
            let input = FrameInput {
                player_cell: player.map(|p| PlayerCell(CellId(p))),
                ..FrameInput::new(camera)
            };
            let source = WorldObjects::new(&stage.world);
            stage.frame.update(&stage.world, &stage.openings, &source, &input);
            pictures.push(render(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap());
        }
        assert!(pictures.windows(2).all(|p| p[0] == p[1]));
        // Broken: a camera outdoors that is drawn from the player's room loses the house it looks at, and the
        // other way round.
        let other = if camera.cell().is_indoor() {
            0xA9B4_0031
        } else {
            0xA9B4_0101
        };
        let wrong = stage.ids(camera.in_cell(CellId(other)));
        let right = stage.ids(camera);
        assert!(compare(&right, &wrong).differing > 100);
    }
}

#[test]
fn r16_cells_that_do_not_exist_end_in_fog_colour_and_a_count() {
    let mut stage = village();
    let camera = look(0xA9B4_0FFF, [100.0, 100.0, 96.0], [100.0, 120.0, 96.0], SMALL);
    let input = FrameInput {
        viewer_cell: Some(ViewerCell(CellId(0xA9B4_0FFF))),
        ..FrameInput::new(camera)
    };
    let source = WorldObjects::new(&stage.world);
    stage.frame.update(&stage.world, &stage.openings, &source, &input);
    assert_eq!(stage.frame.counters().nothing_to_draw, 1);
    let picture = render_ids(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap();
    assert_eq!(picture.count(PixelKind::Sky), picture.ids().len());
    // Commands that name what is not there are counted, not drawn.
    let nonsense = [
        Command::Terrain(CellId(0xA9B4_0FFF)),
        Command::Terrain(CellId(0x1234_0001)),
    ];
    let settings = RenderSettings::default();
    let (_, counters) = render_commands(&stage.scene(), &stage.frame, &nonsense, &settings).unwrap();
    assert_eq!(counters.missing, 2);
}

/// A case of R21: where the player stands, where the camera wants to be relative to the pivot, and what comes of it.
struct Case {
    name: &'static str,
    player: (CellId, [f32; 3]),
    sought: [f32; 3],
    source: ViewerSource,
    /// Cell, and the eye's coordinates that are told by the walls.
    cell: Option<CellId>,
    eye: [Option<f32>; 3],
}

#[test]
fn r21_where_the_camera_ends_and_in_which_cell() {
    let (hall, loft, vestibule) = (
        cell("cottage.hall"),
        cell("cottage.loft"),
        cell("cottage.vestibule"),
    );
    let land = CellId(0xA9B4_0031);
    let in_hall = (hall, [154.0, 10.0, 94.0]);
    let nowhere = (CellId::NONE, [154.0, 10.0, 94.0]);
    let absent = (CellId(0xA9B4_0190), [154.0, 10.0, 94.0]);
    let swept = ViewerSource::Swept;
    let case = |name, player, sought, source, cell, eye| Case {
        name,
        player,
        sought,
        source,
        cell,
        eye,
    };
    let cases = [
        case(
            "free",
            in_hall,
            [-0.5, 0.6, 0.2],
            swept,
            Some(hall),
            [Some(153.5), Some(10.6), Some(95.7)],
        ),
        // The east wall stands at 158.929, the ceiling at 96.6.
        case(
            "a wall behind",
            in_hall,
            [7.0, 0.0, 0.0],
            swept,
            Some(hall),
            [Some(158.629), None, None],
        ),
        case(
            "the ceiling",
            in_hall,
            [0.0, 0.0, 4.0],
            swept,
            Some(hall),
            [None, None, Some(96.3)],
        ),
        // Feet on the stairs in the hall, head in the loft.
        case(
            "the head of the stairs",
            (hall, [157.3, 11.8, 96.45]),
            [-1.0, 0.0, 0.3],
            swept,
            Some(loft),
            [None, None, None],
        ),
        case(
            "out through the door",
            (hall, [155.4, 14.3, 94.0]),
            [0.0, 6.0, 0.0],
            swept,
            Some(land),
            [None, Some(20.3), None],
        ),
        case(
            "in through the door",
            (land, [155.4, 18.0, 94.0]),
            [0.0, -2.5, 0.0],
            swept,
            Some(vestibule),
            [None, Some(15.5), None],
        ),
        case(
            "free outdoors",
            (land, [155.4, 22.0, 94.0]),
            [0.0, 2.0, 1.0],
            swept,
            Some(land),
            [Some(155.4), None, Some(96.5)],
        ),
        // The ground lies at 94.
        case(
            "the ground",
            (land, [155.4, 22.0, 94.0]),
            [0.0, 1.0, -3.0],
            swept,
            Some(land),
            [None, None, Some(94.3)],
        ),
        case(
            "a player in no cell",
            nowhere,
            [0.0, 1.0, 0.0],
            ViewerSource::Player,
            None,
            [None; 3],
        ),
        case(
            "a player in a cell that does not exist",
            absent,
            [0.0, 1.0, 0.0],
            ViewerSource::Player,
            None,
            [Some(154.0), Some(10.0), Some(94.0)],
        ),
        case(
            "a sought place that is none",
            in_hall,
            [f32::NAN; 3],
            ViewerSource::Player,
            None,
            [None; 3],
        ),
        case(
            "a lost player, a camera in a room",
            absent,
            [0.0, 0.0, 0.0],
            ViewerSource::Adjusted,
            Some(hall),
            [None; 3],
        ),
    ];
    let stage = village();
    let (population, mut scratch) = (Population::new(), Scratch::default());
    for case in &cases {
        let position = Position::new(case.player.0, Vec3::from_array(case.player.1));
        let target = ViewerTarget::at(position);
        let mut sought = position;
        sought.frame.origin += PIVOT_OFFSET + Vec3::from_array(case.sought);
        if case.source == ViewerSource::Adjusted {
            sought.cell = hall;
        }
        let mut find = || {
            update_viewer(
                &stage.world,
                &population,
                &mut scratch,
                &target,
                PIVOT_OFFSET,
                &sought,
            )
        };
        let viewer = find();
        assert_eq!(viewer.source, case.source, "{}: {viewer:?}", case.name);
        assert_eq!(
            viewer.cell,
            case.cell.map(ViewerCell),
            "{}: {viewer:?}",
            case.name
        );
        let eye = viewer.position.frame.origin;
        for (k, wanted) in case.eye.into_iter().enumerate() {
            assert!(
                wanted.is_none_or(|w| (eye[k] - w).abs() < 4e-3),
                "{}: {eye}",
                case.name
            );
        }
        for _ in 0..100 {
            let again = find();
            assert_eq!(
                again.position.frame.origin.to_array().map(f32::to_bits),
                eye.to_array().map(f32::to_bits)
            );
            assert_eq!(again.cell, viewer.cell);
        }
    }
}

#[test]
fn r22_a_camera_glides_to_its_place_and_then_rests() {
    let mut stage = village();
    let mut population = Population::new();
    let mut scratch = Scratch::default();
    let id = population.add(Body::player());
    let position = Position::new(CellId(0xA9B4_0031), Vec3::new(155.4, 24.0, 94.0));
    population.force_into_cell(&stage.world, &mut scratch, id, &position);
    let target = ViewerTarget::of_body(&population, id).unwrap();
    let chase = ChaseCamera::default();
    let desired = chase.desired(&target).frame.origin;
    let mut rig = CameraRig::new(chase);
    let mut viewer = *rig
        .update(&stage.world, &population, &mut scratch, Some(&target), 1.0 / 60.0)
        .unwrap();
    // Put aside by a metre, where nothing is in the way.
    viewer.position.frame.origin = desired + Vec3::X;
    rig.set_viewer(viewer);
    let mut gap = 1.0;
    let mut pictures = Vec::new();
    for step in 0..260 {
        let viewer = *rig
            .update(&stage.world, &population, &mut scratch, Some(&target), 1.0 / 60.0)
            .unwrap();
        let next = (viewer.position.frame.origin - desired).length();
        if step < 20 {
            assert!((next / gap - 0.925).abs() < 2e-3, "{next} {gap}");
        }
        gap = next;
        if step > 250 {
            let input = viewer
                .frame_input(target.cell, 1.0, glam::Vec2::new(64.0, 48.0))
                .unwrap();
            let source = WorldObjects::new(&stage.world);
            stage.frame.update(&stage.world, &stage.openings, &source, &input);
            pictures.push(render(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap());
        }
    }
    // The damping snaps when a step would be shorter than 0.4 mm.
    assert!(gap < 0.0004 / 0.075 + 6e-4, "{gap}");
    assert!(
        pictures.windows(2).all(|p| p[0] == p[1]),
        "at rest nothing changes"
    );
    rig.camera.translational_stiffness = 1.0;
    rig.camera.rotational_stiffness = 1.0;
    let viewer = *rig
        .update(&stage.world, &population, &mut scratch, Some(&target), 1.0 / 60.0)
        .unwrap();
    assert!(
        (viewer.position.frame.origin - desired).length() < 1e-3,
        "stiffness 1: one step"
    );
}
