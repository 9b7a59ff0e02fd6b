//! Looking into buildings: `visibility.md` 8, examples V18-V20 and V34.

mod common;

use common::*;
use glam::Vec3;
use vestibule_view::{
    BlockOpenings, Camera, DoorSpec, FloodArena, FloodSettings, HouseSpec, LookIns, PView, Region,
};
use vestibule_world::{CellId, Frame};

/// The house of V18: a facade with a door, one room with a rear window.
struct House {
    openings: BlockOpenings,
    rooms: Rooms,
}

fn house(facade: f32, door: Span, height: Span) -> House {
    let mut rooms = Rooms::new();
    let r = rooms.room("R", (-5.0, 5.0), (facade, facade + 10.0));
    let door = at_y(facade, door, height);
    // The room's own side of the door: it lies on the positive side.
    rooms.specs[r].portals.push(vestibule_view::PortalSpec {
        target: vestibule_world::PortalTarget::Outside,
        other_portal: None,
        vertices: door.clone(),
        interior_is_negative: false,
        exact_match: true,
    });
    rooms.exit(r, &at_y(facade + 10.0, (-1.0, 1.0), (1.0, 2.0)));
    let spec = HouseSpec {
        frame: Frame::IDENTITY,
        doors: vec![DoorSpec {
            target: id(r),
            other_portal: Some(0),
            vertices: door,
            // Seen from the south, the polygon's negative side.
            interior_is_negative: true,
            stab_list: vec![id(r)],
        }],
    };
    let openings = rooms.build().with_houses(&[spec]);
    House { openings, rooms }
}

fn outdoors(eye: Vec3, look: Vec3) -> Camera {
    let right_angle = core::f32::consts::FRAC_PI_2;
    Camera::new(CellId::new(BLOCK, 1), eye, look, Vec3::Z, right_angle, VIEWPORT).unwrap()
}

fn whole_screen(camera: &Camera) -> Vec<vestibule_view::Edge> {
    let mut rooms = Rooms::new();
    rooms.room("any", (-1.0, 1.0), (-1.0, 1.0));
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera.in_cell(id(0)));
    flood.regions(&flood.cells()[0]).next().unwrap().edges().to_vec()
}

fn look(
    house: &House,
    camera: &Camera,
    views: &[Region<'_>],
    settings: FloodSettings,
) -> (LookIns, FloodArena) {
    let (mut look_ins, mut floods) = (LookIns::new(), FloodArena::new());
    let mut pview = PView::new(settings);
    pview.look_into_block(
        &house.openings,
        camera,
        views.iter().copied(),
        &mut look_ins,
        &mut floods,
    );
    (look_ins, floods)
}

#[test]
fn v18_a_room_seen_through_a_door() {
    let house = house(10.0, (-1.0, 1.0), TALL);
    let camera = outdoors(v(0.0, 0.0, 1.5), Vec3::Y);
    let screen = whole_screen(&camera);
    let (looks, floods) = look(&house, &camera, &[Region::new(&screen)], FloodSettings::default());
    assert_eq!(looks.list().len(), 1);
    let seen = looks.list()[0];
    assert_bounds(slopes(&camera, looks.punch(&seen)), [-0.1, 0.1, -0.15, 0.1]);
    let flood = floods.get(seen.flood as usize).unwrap();
    assert_eq!(house.rooms.list(&flood), ["R"]);
    assert!(!flood.sees_outside(), "8.5: exits met inside add nothing");
    assert_eq!((seen.entry, seen.portal, seen.view), (id(0), 0, 0));
}

#[test]
fn v19_from_behind_there_is_no_door() {
    let house = house(10.0, (-1.0, 1.0), TALL);
    let camera = outdoors(v(0.0, 40.0, 1.5), -Vec3::Y);
    let screen = whole_screen(&camera);
    let (looks, floods) = look(&house, &camera, &[Region::new(&screen)], FloodSettings::default());
    assert!(looks.list().is_empty() && floods.is_empty());
}

#[test]
fn v20_house_to_house() {
    let camera = outdoors(v(0.0, 0.0, 1.5), Vec3::Y);
    let mut near = Rooms::new();
    let a = near.room("A", (-5.0, 5.0), (-5.0, 5.0));
    near.exit(a, &at_y(5.0, (-1.0, 1.0), TALL));
    let mut pview = PView::default();
    let openings = near.build();
    let flood = pview.look_in_block(Some(&openings), &camera.in_cell(id(0)));
    assert_eq!(near.list(&flood), ["A"]);
    let outside: Vec<Region<'_>> = flood.outside().collect();
    assert_eq!(outside.len(), 1);
    assert_x(slopes(&camera, outside[0]), -0.2, 0.2);
    let far = house(25.0, (-1.0, 1.0), TALL);
    let (looks, floods) = look(&far, &camera, &outside, FloodSettings::default());
    assert_eq!(looks.list().len(), 1);
    assert_bounds(
        slopes(&camera, looks.punch(&looks.list()[0])),
        [-0.04, 0.04, -0.06, 0.04],
    );
    assert_eq!(far.rooms.list(&floods.get(0).unwrap()), ["R"]);
    let aside = house(25.0, (6.0, 8.0), TALL);
    let (looks, _) = look(&aside, &camera, &outside, FloodSettings::default());
    assert!(looks.list().is_empty());
}

#[test]
fn v34_an_eye_in_the_plane_of_a_door() {
    let house = house(10.0, (-1.0, 1.0), TALL);
    let camera = outdoors(v(0.0, 10.0, 1.5), Vec3::Y);
    let screen = whole_screen(&camera);
    let view = [Region::new(&screen)];
    let (looks, floods) = look(&house, &camera, &view, FloodSettings::default());
    assert_eq!(looks.list().len(), 1);
    assert!(
        looks.punch(&looks.list()[0]).edges().is_empty(),
        "12.2: only the view is widened, not the punch"
    );
    let flood = floods.get(0).unwrap();
    assert_bounds(
        slopes(&camera, flood.regions(&flood.cells()[0]).next().unwrap()),
        [-1.0, 1.0, -1.0, 1.0],
    );
    let (looks, _) = look(&house, &camera, &view, FloodSettings::retail());
    assert!(looks.list().is_empty(), "retail does not emit it");
}

#[test]
fn s8_7_each_view_floods_once_and_views_of_the_landscape_do_not_mix() {
    let house = house(10.0, (-2.0, 2.0), TALL);
    let camera = outdoors(v(0.0, 0.0, 1.5), Vec3::Y);
    let screen = whole_screen(&camera);
    // Two halves of the screen.
    let half = |left: bool| {
        let mut rooms = Rooms::new();
        let a = rooms.room("A", (-5.0, 5.0), (-5.0, 5.0));
        rooms.exit(
            a,
            &at_y(5.0, if left { (-5.0, 0.0) } else { (0.0, 5.0) }, (-5.0, 8.0)),
        );
        let openings = rooms.build();
        let mut pview = PView::default();
        let flood = pview.look_in_block(Some(&openings), &camera.in_cell(id(0)));
        flood.outside().next().unwrap().edges().to_vec()
    };
    let (left, right) = (half(true), half(false));
    let views = [Region::new(&left), Region::new(&right), Region::new(&screen)];
    let (looks, floods) = look(&house, &camera, &views, FloodSettings::default());
    assert_eq!(looks.list().iter().map(|l| l.view).collect::<Vec<_>>(), [0, 1, 2]);
    assert_eq!(floods.len(), 3);
    let x = |k: usize| slopes(&camera, looks.punch(&looks.list()[k]));
    assert_x(x(0), -0.2, 0.0);
    assert_x(x(1), 0.0, 0.2);
    assert_x(x(2), -0.2, 0.2);
}

#[test]
fn s8_4d_a_door_to_a_room_that_is_not_loaded_is_counted() {
    let mut there = house(10.0, (-1.0, 1.0), TALL);
    let spec = HouseSpec {
        frame: Frame::IDENTITY,
        doors: vec![DoorSpec {
            target: id(7),
            other_portal: Some(0),
            vertices: at_y(10.0, (-1.0, 1.0), TALL),
            interior_is_negative: true,
            stab_list: vec![],
        }],
    };
    there.openings = Rooms::new().build().with_houses(&[spec]);
    let camera = outdoors(v(0.0, 0.0, 1.5), Vec3::Y);
    let screen = whole_screen(&camera);
    let (looks, floods) = look(&there, &camera, &[Region::new(&screen)], FloodSettings::default());
    assert!(looks.list().is_empty() && floods.is_empty());
    assert_eq!(looks.dead_doors, 1);
}
