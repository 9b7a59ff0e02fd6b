//! `transition.md` 6.4, 6.10.6: polygons that are left behind, and movers that stop where they touch.

use glam::Vec3;
use vestibule_world::Sphere;

use crate::flags::ObjectState;
use crate::rig::*;
use crate::sweep::Carried;

#[test]
fn s6_4_a_surface_that_is_left_behind_is_named_but_not_hit() {
    // W31 on the tree: floor up, centre 0.3 over it.
    let rig = Rig::with_faces(&[level([8.0, 16.0], [8.0, 16.0], 5.0)]);
    let object = rig.world.static_object(rig.world.statics_in(LAND)[0]).unwrap();
    let bsp = object.shape.parts[0]
        .model
        .as_ref()
        .unwrap()
        .physics
        .as_ref()
        .unwrap();
    let sphere = Sphere::new(v(0.0, 0.0, 5.3), 0.48);
    for (movement, hit) in [
        (v(0.0, 0.0, -0.1), true),
        (v(0.1, 0.0, 0.0), false),
        (v(0.0, 0.0, 0.1), false),
    ] {
        let mut named = None;
        assert_eq!(
            crate::bsp_tree::sphere_intersects_poly(bsp, sphere.into(), movement.into(), &mut named),
            hit
        );
        assert!(named.is_some());
    }
    let mut named = None;
    let above = Sphere::new(v(0.0, 0.0, 5.4799), 0.48);
    assert!(
        !crate::bsp_tree::sphere_intersects_poly(bsp, above.into(), (-Vec3::Z).into(), &mut named)
            && named.is_none()
    );
}

#[test]
fn s6_10_6_a_path_clipped_mover_stops_where_it_touches() {
    let mut rig = Rig::with_faces(&[wall_facing_west(12.0, [4.0, 20.0], [-1.0, 8.0])]);
    let swept = rig.sweep(
        &missile(),
        &Carried::default(),
        v(11.0, 12.0, 4.0),
        v(13.0, 12.0, 4.0),
    );
    assert!(
        (swept.position.origin().x - 11.7).abs() < 0.01,
        "{}",
        swept.position.origin()
    );
    assert_eq!(swept.collision_normal, Some(-Vec3::X));
    let mut blunt = missile();
    blunt.state.set(ObjectState::PERFECT_CLIP, false);
    let swept = rig.sweep(
        &blunt,
        &Carried::default(),
        v(11.0, 12.0, 4.0),
        v(13.0, 12.0, 4.0),
    );
    assert!(
        swept.position.origin().x < 11.7 - 0.01,
        "{}",
        swept.position.origin()
    );
}
