//! `transition.md` 11.2: how a step's offset is bent by floor and wall.

use glam::Vec3;
use vestibule_world::{CellId, Plane};

use crate::rig::*;
use crate::sweep::{Carried, ContactPlane};

/// Adjusts an offset for a walker at (12, 12, 5), far from everything.
fn adjusted(carried: &Carried, offset: Vec3) -> (Vec3, Option<Vec3>, f32) {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), carried, v(12.0, 12.0, 5.0));
    let out = t.adjust_offset(offset);
    (out, t.info.sliding.get(), t.path.center(0).z - 5.48)
}

/// A plane far below, so that nothing is pushed.
fn bent_by(normal: Vec3, sliding: Option<Vec3>) -> Carried {
    Carried {
        sliding_normal: sliding,
        ..on_plane(normal, 100.0)
    }
}

const SLOPE: Vec3 = Vec3::new(-0.5, 0.0, 0.866_025_4);

#[test]
fn w7_uphill_is_slowed() {
    let (out, ..) = adjusted(&bent_by(SLOPE, None), v(0.1, 0.0, 0.0));
    assert!(close(out, v(0.075, 0.0, 0.043_301_3)), "{out}");
}

#[test]
fn w8_downhill_keeps_its_horizontal_speed() {
    let (out, ..) = adjusted(&bent_by(SLOPE, None), v(-0.1, 0.0, 0.0));
    assert!(close(out, v(-0.1, 0.0, -0.057_735_0)), "{out}");
}

#[test]
fn w9_crease_on_flat() {
    let (out, ..) = adjusted(&bent_by(Vec3::Z, Some(-Vec3::X)), v(0.3, 0.4, 0.0));
    assert!(close(out, v(0.0, 0.4, 0.0)), "{out}");
}

#[test]
fn w10_crease_on_a_slope() {
    let h = core::f32::consts::FRAC_1_SQRT_2;
    let (out, ..) = adjusted(&bent_by(v(-h, 0.0, h), Some(-Vec3::Y)), v(0.3, 0.4, 0.0));
    assert!(close(out, v(0.15, 0.0, 0.15)), "{out}");
}

#[test]
fn w11_sliding_is_dropped_when_moving_away() {
    let carried = Carried {
        sliding_normal: Some(-Vec3::X),
        ..Carried::default()
    };
    let (out, sliding, _) = adjusted(&carried, v(-0.1, 0.2, 0.0));
    assert_eq!((out, sliding), (v(-0.1, 0.2, 0.0), None));
}

#[test]
fn w12_sliding_without_a_plane() {
    let carried = Carried {
        sliding_normal: Some(-Vec3::X),
        ..Carried::default()
    };
    let (out, sliding, _) = adjusted(&carried, v(0.3, 0.4, -0.2));
    assert!(close(out, v(0.0, 0.4, -0.2)) && sliding.is_some());
}

/// How far a body is lifted whose foot centre is `s` over a plane with this normal.
fn pushed(normal: Vec3, s: f32, water: bool, cell: CellId) -> f32 {
    let d = s - normal.dot(v(12.0, 12.0, 5.48));
    let contact = ContactPlane {
        plane: Plane { normal, d },
        cell,
        is_water: water,
    };
    let carried = Carried {
        contact: Some(contact),
        ..Carried::default()
    };
    adjusted(&carried, v(0.1, 0.0, 0.0)).2
}

#[test]
fn w13_safety_push() {
    assert!((pushed(Vec3::Z, 0.40, false, LAND) - 0.08).abs() < 1e-4);
    assert_eq!(pushed(Vec3::Z, 0.40, true, LAND), 0.0);
    assert_eq!(pushed(Vec3::Z, 0.40, false, CellId::NONE), 0.0);
    assert_eq!(pushed(Vec3::Z, 0.4799, false, LAND), 0.0);
}

#[test]
fn w14_safety_push_on_slopes() {
    assert!((pushed(SLOPE, 0.415_692_2, false, LAND) - 0.074_256_3).abs() < 1e-4);
    let angle = 61.0f32.to_radians();
    let steep = v(-libm::sinf(angle), 0.0, libm::cosf(angle));
    assert_eq!(pushed(steep, 0.48 * steep.z, false, LAND), 0.0);
}

#[test]
fn s4_2_3_the_push_knows_the_landblock_of_the_plane() {
    // The plane x = 205 of the block to the east... is x = 13 in its own coordinates.
    let east = CellId(0xAAB4_0001);
    let plane = Plane {
        normal: Vec3::Z,
        d: 0.0,
    };
    let sloped = Plane {
        normal: SLOPE,
        d: 0.5 * -180.0 - 0.866_025_4 * 5.48 + 0.4,
    };
    for plane in [plane, sloped] {
        let mut rig = Rig::flat();
        let contact = ContactPlane {
            plane,
            cell: east,
            is_water: false,
        };
        let carried = Carried {
            contact: Some(contact),
            ..Carried::default()
        };
        let mut t = rig.transition(&walker(), &carried, v(12.0, 12.0, 5.0));
        t.adjust_offset(Vec3::ZERO);
        let lifted = t.path.center(0).z - 5.48;
        // blk(check, plane) = (192, 0, 0): the foot is at x = -180 there.
        let s = plane.dist(v(12.0 - 192.0, 12.0, 5.48));
        let expected = if s < 0.4798 && (0.48 - s) / plane.normal.z < 0.48 {
            (0.48 - s) / plane.normal.z
        } else {
            0.0
        };
        assert!((lifted - expected).abs() < 1e-4, "{lifted} {expected}");
    }
}

#[test]
fn s4_2_a_foot_in_the_floor_is_pushed_out_of_it_while_sliding_too() {
    for sliding in [None, Some(-Vec3::X)] {
        let carried = Carried {
            sliding_normal: sliding,
            ..on_level(5.1)
        };
        let (out, _, lifted) = adjusted(&carried, v(0.3, 0.4, 0.0));
        assert_eq!(out.x == 0.0, sliding.is_some());
        assert!((lifted - 0.1).abs() < 1e-4, "{lifted}");
    }
}
