//! Looking into buildings: `visibility.md` 8, examples V18-V20 and V34.

mod common;

use common::*;
use glam::Vec3;
use vestibule_testing::records;
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

/// A look along the facade from right before the door, `x` to the side: the one look, whether the eye is in the door,
/// and the bounds of what is punched and of what is seen.
fn along_the_facade(x: f32, y: f32) -> Option<(u32, Option<[f32; 4]>, [f32; 4])> {
    let house = house(0.0, (-1.0, 1.0), TALL);
    let camera = outdoors(v(x, y, 1.5), Vec3::X);
    let screen = whole_screen(&camera);
    let (looks, floods) = look(&house, &camera, &[Region::new(&screen)], FloodSettings::default());
    assert!(looks.list().len() <= 1);
    let look = looks.list().first()?;
    let punch = looks.punch(look);
    let punch = (!punch.edges().is_empty()).then(|| slopes(&camera, punch));
    let flood = floods.get(look.flood as usize).unwrap();
    let seen = slopes(&camera, flood.regions(&flood.cells()[0]).next().unwrap());
    Some((flood.counters().on_plane, punch, seen))
}

#[test]
fn s12_2_a_door_is_looked_through_whole_from_0_2_mm_to_either_side_of_its_plane() {
    use vestibule_view::constants::EPSILON;
    let beyond = f32::from_bits(EPSILON.to_bits() + 1);
    for y in [0.5 * EPSILON, EPSILON, -0.5 * EPSILON, -EPSILON] {
        let (on_plane, punch, seen) = along_the_facade(0.0, y).unwrap();
        assert_eq!(on_plane, 1, "{y}");
        assert_bounds(seen, [-1.0, 1.0, -1.0, 1.0]);
        // Only the view is widened: half of the screen is punched, to the left, where the facade is.
        if y < 0.0 {
            let punch = punch.unwrap();
            assert!(punch[0] < -0.999 && punch[1].abs() < 1e-3, "{y}: {punch:?}");
        }
    }
    assert!(
        along_the_facade(0.0, beyond).is_none(),
        "behind it there is no door"
    );
    let (on_plane, _, seen) = along_the_facade(0.0, -beyond).unwrap();
    assert_eq!(on_plane, 0);
    assert!(seen[1] < 0.01, "{seen:?}");
}

#[test]
fn s12_2_a_door_is_grown_by_a_centimetre() {
    for (x, inside) in [(1.009, true), (-1.009, true), (1.011, false), (-1.011, false)] {
        let on_plane = along_the_facade(x, 0.0).map_or(0, |(on_plane, ..)| on_plane);
        assert_eq!(on_plane, u32::from(inside), "{x}");
    }
}

#[test]
fn s12_2_a_door_of_several_pieces_is_looked_through_once_from_its_plane() {
    // A door with a step in its threshold, cut into convex pieces; the eye is in one of them.
    let mut house = house(0.0, (-1.0, 1.0), TALL);
    let stepped = [
        (1.0, 0.0),
        (0.0, 0.0),
        (0.0, 0.5),
        (-1.0, 0.5),
        (-1.0, 2.5),
        (1.0, 2.5),
    ];
    let door = DoorSpec {
        target: id(0),
        other_portal: Some(0),
        vertices: stepped.iter().map(|&(x, z)| v(x, 0.0, z)).collect(),
        interior_is_negative: true,
        stab_list: vec![id(0)],
    };
    let spec = HouseSpec {
        frame: Frame::IDENTITY,
        doors: vec![door],
    };
    house.openings = house.rooms.build().with_houses(&[spec]);
    for eye in [v(0.5, 0.0, 0.2), v(-0.5, 0.0, 2.0), v(0.5, -0.0001, 0.2)] {
        let camera = outdoors(eye, Vec3::Y);
        let screen = whole_screen(&camera);
        let (looks, floods) = look(&house, &camera, &[Region::new(&screen)], FloodSettings::default());
        assert_eq!((looks.list().len(), floods.len()), (1, 1), "{eye}");
        let flood = floods.get(0).unwrap();
        assert_eq!(flood.counters().on_plane, 1, "{eye}");
        assert_bounds(
            slopes(&camera, flood.regions(&flood.cells()[0]).next().unwrap()),
            [-1.0, 1.0, -1.0, 1.0],
        );
    }
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

/// A model with openings 0 in the plane y = 0 and 1 in the plane x = 3, the second behind the first, as records.
fn two_doors() -> vestibule_world::World {
    use vestibule_dat::record::{BspKind, BspNode, BspTree, GfxObj};
    use vestibule_world::Store;
    let south = [
        [-1.0, 0.0, 2.0],
        [1.0, 0.0, 2.0],
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
    ];
    let east = [[3.0, 1.0, 0.0], [3.0, 3.0, 0.0], [3.0, 3.0, 2.0], [3.0, 1.0, 2.0]];
    let mut b = records::Builder::new(BLOCK.0);
    let room = |low: u16, min: Vec3, corners: &[[f32; 3]]| {
        records::Room::of_box(low, min, min + Vec3::splat(3.0)).opening(None, -1, false, corners)
    };
    b.room(room(0x100, Vec3::ZERO, &south));
    b.room(room(0x101, Vec3::ZERO, &east));
    b.building(Vec3::ZERO, &[(0x100, 0), (0x101, 0)]);
    let faces = [south, east].map(|f| f.map(Vec3::from_array).to_vec());
    b.model(0x0100_0001, &faces, false);
    let is_model = |&(store, id, _): &(Store, u32, &[u8])| store == Store::Portal && id == 0x0100_0001;
    let bytes = b.records.iter().find(is_model).unwrap().2.to_vec();
    let mut model = GfxObj::parse(0x0100_0001, &bytes).unwrap();
    let node = |plane, pos, neg, portal| BspNode::Portal {
        plane,
        pos,
        neg,
        sphere: Some(vestibule_dat::primitive::Sphere {
            center: Vec3::ZERO,
            radius: 10.0,
        }),
        polys: Vec::new(),
        portal_polys: vec![(portal, portal)],
    };
    let leaf = BspNode::Leaf {
        index: 0,
        physics: None,
    };
    // The second opening is on the positive side of the first one's plane.
    let nodes = vec![
        node(records::plane(0.0, 1.0, 0.0, 0.0), 1, 4, 0),
        node(records::plane(1.0, 0.0, 0.0, -3.0), 2, 3, 1),
        leaf.clone(),
        leaf.clone(),
        leaf,
    ];
    model.drawing.as_mut().unwrap().bsp = BspTree {
        kind: BspKind::Drawing,
        nodes,
    };
    b.records.insert(Store::Portal, model.id, model.encode().unwrap());
    for building in &mut b.info.buildings {
        // Seen from the south and from the west: from the negative sides of both.
        building.portals.iter_mut().for_each(|p| p.flags = 1);
    }
    b.world()
}

#[test]
fn s8_2_doors_come_in_the_order_of_the_drawing_bsp() {
    let world = two_doors();
    let openings = BlockOpenings::compile(world.block(BLOCK).unwrap());
    assert_eq!(openings.problems().mismatched_buildings, 0);
    let order = |eye: Vec3, look: Vec3| {
        let camera = outdoors(eye, look);
        let (mut pview, mut out, mut floods) = (PView::default(), LookIns::new(), FloodArena::new());
        let edges = whole_screen(&camera);
        let views = [Region::new(&edges)];
        pview.look_into_block(&openings, &camera, views.into_iter(), &mut out, &mut floods);
        out.list().iter().map(|l| l.portal).collect::<Vec<_>>()
    };
    // From the south door 1 lies beyond the plane of door 0, wherever its middle is: it comes first although it is
    // the nearer one from here.
    let eye = Vec3::new(2.9, -0.5, 1.0);
    let (south, east) = (Vec3::new(0.0, 0.0, 1.0), Vec3::new(3.0, 2.0, 1.0));
    assert!((south - eye).length() > (east - eye).length());
    assert_eq!(order(eye, Vec3::new(-0.7, 1.0, 0.0)), [1, 0]);
}
