//! The cell a frame starts from.

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
