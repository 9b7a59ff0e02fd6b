//! 8.2 to 8.4: what is in the way of whom, spheres and cylinders.

use glam::Vec3;
use vestibule_world::{CylSphere, Frame, Shape, Sphere};

use crate::body::Body;
use crate::constants::FLOOR_Z;
use crate::flags::{ObjectKind, ObjectState, PhysicsState};
use crate::obj_collisions::{ObjectRef, Target};
use crate::rig::*;
use crate::sweep::{Carried, Mover, Touch};
use crate::transition::{Transition, TransitionState};

/// Where the target stands.
const TARGET: Vec3 = Vec3::new(12.0, 12.0, 5.0);
const SOLID: PhysicsState = PhysicsState::DEFAULT;

/// A target and who meets it.
struct Meeting {
    state: PhysicsState,
    kind: ObjectKind,
    /// The target is made of a cylinder besides its sphere.
    cylinder: bool,
    scale: f32,
    mover: Mover,
    carried: Carried,
    /// From where to where the mover's feet go, relative to the target.
    from: Vec3,
    by: Vec3,
    step_down: bool,
}

/// What came of it.
struct Met {
    ts: TransitionState,
    touched: Vec<Touch>,
    normal: bool,
    environment: bool,
    moved: Vec3,
}

impl Default for Meeting {
    fn default() -> Self {
        Meeting {
            state: SOLID,
            kind: ObjectKind::NONE,
            cylinder: false,
            scale: 1.0,
            mover: walker(),
            carried: on_level(5.02),
            from: v(-1.0, 0.0, 0.02),
            by: v(0.1, 0.05, 0.0),
            step_down: false,
        }
    }
}

fn meet(m: &Meeting) -> Met {
    let mut rig = Rig::flat();
    let id = rig.population.add(Body::player());
    let base = rig.population.body(id).unwrap().shape().as_ref().clone();
    let cylinder = CylSphere {
        low_point: Vec3::ZERO,
        radius: 0.5,
        height: 1.0,
    };
    let shape = Shape {
        spheres: [Sphere::new(v(0.0, 0.0, 0.5), 0.5)].into(),
        cylspheres: if m.cylinder {
            [cylinder].into()
        } else {
            Box::default()
        },
        ..base
    };
    let frame = Frame::at(TARGET);
    let target = Target {
        object: ObjectRef::Body(id),
        cell: LAND,
        frame: &frame,
        scale: m.scale,
        state: m.state,
        kind: m.kind,
        shape: &shape,
        part_frames: &[],
    };
    let at = TARGET + m.from;
    let mut t = rig.transition(&m.mover, &m.carried, at);
    t.path.add_offset_to_check_pos(m.by);
    t.path.step_down = m.step_down;
    (t.path.step_down_amt, t.path.walk_interp) = (0.6, 1.0);
    t.info.set_collision_normal(Vec3::Y);
    let ts = t.find_object_collisions(&target);
    assert!(!t.path.obstruction_ethereal);
    // Whom it meets twice is listed once.
    t.find_object_collisions(&target);
    let moved = t.path.check_pos.origin() - at - m.by;
    Met {
        ts,
        touched: t.touched.clone(),
        normal: t.info.collision.valid,
        environment: t.info.collided_with_environment,
        moved: if close(moved, Vec3::ZERO) {
            Vec3::ZERO
        } else {
            moved
        },
    }
}

fn stops(m: &Meeting) -> bool {
    meet(m).ts != TransitionState::Ok
}

fn in_the_air(state: ObjectState) -> (Mover, Carried) {
    let mut mover = walker();
    mover.state = state;
    (mover, Carried::default())
}

#[test]
fn s8_2_8_a_body_in_the_way_is_listed_as_what_stopped() {
    let met = meet(&Meeting::default());
    assert_ne!(met.ts, TransitionState::Ok);
    assert_eq!(met.touched.iter().map(|t| t.stopped).collect::<Vec<_>>(), [true]);
    assert!(!met.environment);
    // Not while stepping down onto it.
    let met = meet(&Meeting {
        step_down: true,
        ..Meeting::default()
    });
    assert!(met.touched.is_empty());
}

#[test]
fn s8_2_8_a_static_object_is_surroundings() {
    let fixed = SOLID | PhysicsState::STATIC;
    let met = meet(&Meeting {
        state: fixed,
        ..Meeting::default()
    });
    assert_ne!(met.ts, TransitionState::Ok);
    assert!(met.touched.is_empty() && !met.environment);
    let (mover, carried) = in_the_air(ObjectState::NONE);
    let met = meet(&Meeting {
        state: fixed,
        mover,
        carried,
        ..Meeting::default()
    });
    assert!(met.touched.is_empty() && met.environment);
}

#[test]
fn s8_2_2_a_camera_passes_creatures_only() {
    let camera = |kind| {
        stops(&Meeting {
            kind,
            mover: crate::viewer::viewer_mover(&walker()),
            carried: Carried::default(),
            from: v(-1.0, 0.0, 0.5),
            by: v(0.5, 0.0, 0.0),
            ..Meeting::default()
        })
    };
    assert!(camera(ObjectKind::NONE) && !camera(ObjectKind::CREATURE));
}

#[test]
fn s8_2_3_an_ethereal_mover_passes_all_but_static_objects() {
    let mut ghost = walker();
    ghost.physics = ghost.physics | PhysicsState::ETHEREAL;
    let met = |state| {
        meet(&Meeting {
            state,
            mover: ghost,
            ..Meeting::default()
        })
    };
    let through = met(SOLID);
    assert_eq!((through.ts, through.moved), (TransitionState::Ok, Vec3::ZERO));
    assert_eq!(
        through.touched.iter().map(|t| t.stopped).collect::<Vec<_>>(),
        [false]
    );
    assert!(!through.normal);
    assert_ne!(met(SOLID | PhysicsState::STATIC).ts, TransitionState::Ok);
    // And steps down onto nothing ethereal.
    let met = meet(&Meeting {
        state: SOLID | PhysicsState::ETHEREAL,
        step_down: true,
        ..Meeting::default()
    });
    assert_eq!(
        (met.ts, met.moved, met.touched.len()),
        (TransitionState::Ok, Vec3::ZERO, 0)
    );
}

#[test]
fn s8_2_8_creatures_can_be_ignored_but_are_noted() {
    let ignoring = |kind, state| {
        let mut mover = walker();
        mover.state.set(ObjectState::IGNORE_CREATURES, true);
        meet(&Meeting {
            kind,
            state,
            mover,
            ..Meeting::default()
        })
    };
    let met = ignoring(ObjectKind::CREATURE, SOLID);
    assert_eq!(met.ts, TransitionState::Ok);
    assert_eq!(met.touched.iter().map(|t| t.stopped).collect::<Vec<_>>(), [false]);
    assert!(!met.normal);
    assert_ne!(ignoring(ObjectKind::NONE, SOLID).ts, TransitionState::Ok);
}

#[test]
fn s8_2_missiles_pass_missiles_and_who_they_are_not_meant_for() {
    let shot = |state, kind, target: Option<bool>| {
        let mut mover = walker();
        mover.state = ObjectState::PATH_CLIPPED;
        mover.physics = mover.physics | PhysicsState::MISSILE;
        // The first body of a population, or one that is not there.
        let mut others = crate::population::Population::new();
        let first = others.add(Body::player());
        let second = others.add(Body::player());
        mover.target = target.map(|this| if this { first } else { second });
        stops(&Meeting {
            state,
            kind,
            mover,
            carried: Carried::default(),
            ..Meeting::default()
        })
    };
    let none = ObjectKind::NONE;
    assert!(shot(SOLID, none, None));
    assert!(!shot(SOLID | PhysicsState::MISSILE, none, None));
    // Not only missiles pass missiles.
    assert!(!stops(&Meeting {
        state: SOLID | PhysicsState::MISSILE,
        ..Meeting::default()
    }));
    // A creature that is not the target, and the target.
    assert!(!shot(SOLID, ObjectKind::CREATURE, Some(false)));
    assert!(shot(SOLID, ObjectKind::CREATURE, Some(true)));
    assert!(shot(SOLID, ObjectKind::CREATURE, None));
    // Things stop it, whatever it is meant for.
    assert!(shot(SOLID, none, Some(false)));
}

#[test]
fn s8_2_7_one_kind_of_shape_is_used_cylinders_before_spheres() {
    // Over the cylinder's rim but beside the sphere: at the height of its top.
    let beside = |cylinder, state| {
        stops(&Meeting {
            cylinder,
            state,
            from: v(-1.05, 0.0, 0.5),
            by: v(0.1, 0.0, 0.0),
            carried: on_level(5.5),
            ..Meeting::default()
        })
    };
    assert!(beside(true, SOLID) && !beside(false, SOLID));
    // Above the cylinder, in reach of a sphere, were it asked.
    // With a BSP, neither: this one has no parts.
    assert!(!beside(true, SOLID | PhysicsState::HAS_PHYSICS_BSP));
}

#[test]
fn s8_2_shapes_grow_with_the_scale_of_the_target() {
    let at = |cylinder, scale, x: f32, z: f32| {
        stops(&Meeting {
            cylinder,
            scale,
            from: v(x - 0.1, 0.0, z),
            by: v(0.1, 0.05, 0.0),
            carried: on_level(5.0 + z),
            ..Meeting::default()
        })
    };
    // Radius 0.5 against 1; height 1 against 2; the sphere's centre goes up with it.
    assert!(!at(true, 1.0, -1.3, 0.0) && at(true, 2.0, -1.3, 0.0));
    assert!(!at(true, 1.0, -0.9, 1.6) && at(true, 2.0, -0.9, 1.6));
    assert!(!at(false, 1.0, -1.3, 0.5) && at(false, 2.0, -1.3, 0.5));
    assert!(at(false, 2.0, -0.9, 1.3));
}

#[test]
fn s8_2_an_open_door_of_polygons_is_only_overlapped() {
    for (open, stopped) in [(true, false), (false, true)] {
        let mut rig = Rig::with_faces(&[wall_facing_west(12.0, [8.0, 16.0], [3.0, 9.0])]);
        let id = rig.population.add(Body::player());
        let mut state = SOLID | PhysicsState::HAS_PHYSICS_BSP;
        state.set(PhysicsState::ETHEREAL, open);
        let world = &rig.world;
        let fixed = world.static_object(world.statics_in(LAND)[0]).unwrap();
        let target = Target {
            object: ObjectRef::Body(id),
            cell: LAND,
            frame: &fixed.frame,
            scale: 1.0,
            state,
            kind: ObjectKind::NONE,
            shape: &fixed.shape,
            part_frames: &fixed.part_frames,
        };
        let at = vestibule_world::Position::new(LAND, v(11.4, 12.0, 5.0));
        let mut t = crate::sweep::begin(
            world,
            &rig.population,
            &mut rig.scratch,
            &walker(),
            &on_level(5.0),
            &at,
            crate::transition::InsertType::Transition,
        );
        t.path.add_offset_to_check_pos(v(0.2, 0.1, 0.0));
        let ts = t.find_object_collisions(&target);
        assert_eq!(ts != TransitionState::Ok, stopped);
        assert_eq!(t.touched[0].stopped, stopped);
        let moved = t.path.check_pos.origin() - v(11.6, 12.1, 5.0);
        assert_eq!(close(moved, Vec3::ZERO), open, "{moved}");
    }
}

/// A transition whose foot centre is `disp` from the point TARGET.
fn beside<'r>(rig: &'r mut Rig, mover: &Mover, carried: &Carried, disp: Vec3) -> Transition<'r, 'r> {
    rig.transition(
        mover,
        carried,
        TARGET - Vec3::Z * mover.spheres()[0].center.z + disp,
    )
}

const BALL: Sphere = Sphere::new(TARGET, 0.5);

fn post(height: f32) -> CylSphere {
    CylSphere {
        low_point: TARGET,
        radius: 0.5,
        height,
    }
}

/// A step down by `amount` with the foot centre at `disp` from a ball or a post of 0.5 m.
fn stepped(ball: bool, disp: Vec3, amount: f32, allowance: f32) -> (TransitionState, bool) {
    let mut rig = Rig::flat();
    let mut t = beside(&mut rig, &walker(), &on_level(0.0), disp);
    t.info.clear_contact_plane();
    t.path.step_down = true;
    t.path.walkable_allowance = allowance;
    (t.path.step_down_amt, t.path.walk_interp) = (amount, 1.0);
    let ts = if ball {
        t.intersects_sphere(&BALL, false)
    } else {
        t.intersects_cylsphere(&post(0.5), &Frame::IDENTITY)
    };
    (ts, t.info.contact.valid)
}

#[test]
fn s8_3_7_how_a_ball_is_stepped_down_onto() {
    let top = v(0.3, 0.2, 0.5);
    assert_eq!(
        stepped(true, top, 0.6, FLOOR_Z),
        (TransitionState::Adjusted, true)
    );
    // A step of nothing; a lift of more than 1.1 steps; a head only.
    assert_eq!(
        stepped(true, top, 0.000_1, FLOOR_Z),
        (TransitionState::Collided, false)
    );
    assert_eq!(
        stepped(true, top, 0.3, FLOOR_Z),
        (TransitionState::Collided, false)
    );
    assert_eq!(
        stepped(true, v(0.3, 0.0, -1.2), 0.6, 0.0),
        (TransitionState::Collided, false)
    );
    // Too steep there: 0.3878 / 0.98 = 0.396.
    let side = v(0.9, 0.0, 0.1);
    assert_eq!(stepped(true, side, 0.6, FLOOR_Z), (TransitionState::Ok, false));
    assert_eq!(stepped(true, side, 0.6, 0.3), (TransitionState::Adjusted, true));
    // Not at all.
    assert_eq!(
        stepped(true, v(0.3, 0.2, 1.0), 0.6, 0.0),
        (TransitionState::Ok, false)
    );
}

#[test]
fn s8_4_7_how_a_post_is_stepped_down_onto() {
    let top = v(0.3, 0.2, 0.6);
    assert_eq!(
        stepped(false, top, 0.6, FLOOR_Z),
        (TransitionState::Adjusted, true)
    );
    assert_eq!(
        stepped(false, top, 0.000_1, FLOOR_Z),
        (TransitionState::Collided, false)
    );
    assert_eq!(
        stepped(false, top, 0.3, FLOOR_Z),
        (TransitionState::Collided, false)
    );
    assert_eq!(
        stepped(false, v(0.3, 0.2, -0.6), 0.6, 0.0),
        (TransitionState::Collided, false)
    );
    assert_eq!(
        stepped(false, v(0.3, 0.2, 1.0), 0.6, 0.0),
        (TransitionState::Ok, false)
    );
}

/// A landing that came by `m` to `disp`.
fn rewound(ball: bool, disp: Vec3, m: Vec3, allowance: f32) -> (TransitionState, bool) {
    let mut rig = Rig::flat();
    let mut t = beside(&mut rig, &walker(), &Carried::default(), disp - m);
    t.path.add_offset_to_check_pos(m);
    t.path.collide = true;
    t.path.walk_interp = 1.0;
    t.path.walkable_allowance = allowance;
    let ts = if ball {
        t.intersects_sphere(&BALL, false)
    } else {
        t.intersects_cylsphere(&post(0.5), &Frame::IDENTITY)
    };
    (ts, t.info.contact.valid)
}

#[test]
fn s8_3_8_how_a_landing_on_a_ball_is_rewound() {
    let fall = v(-0.1, 0.0, -0.3);
    assert_eq!(
        rewound(true, v(0.5, 0.0, 0.8), fall, 0.1),
        (TransitionState::Adjusted, true)
    );
    assert_eq!(
        rewound(true, v(0.5, 0.0, 0.8), fall, 0.9),
        (TransitionState::Ok, false)
    );
    // No movement to rewind; more to rewind than there was.
    assert_eq!(
        rewound(true, v(0.5, 0.0, 0.8), v(0.0, 0.0, -0.01), 0.1).0,
        TransitionState::Collided
    );
    assert_eq!(
        rewound(true, v(0.1, 0.0, 0.3), fall, 0.1).0,
        TransitionState::Collided
    );
}

#[test]
fn s8_4_8_how_a_landing_on_a_post_is_rewound() {
    assert_eq!(
        rewound(false, v(0.0, 0.0, 0.8), v(0.0, 0.0, -0.3), 0.1),
        (TransitionState::Adjusted, true)
    );
    // Level: nothing to rewind by. From farther than the movement. From beside it: it has not come from above.
    assert_eq!(
        rewound(false, v(0.5, 0.0, 0.8), v(0.2, 0.0, 0.0), 0.1).0,
        TransitionState::Collided
    );
    assert_eq!(
        rewound(false, v(0.0, 0.0, 0.5), v(0.0, 0.0, -0.3), 0.1).0,
        TransitionState::Collided
    );
    assert_eq!(
        rewound(false, v(0.9, 0.0, 0.7), v(-0.8, 0.0, -0.3), 0.1),
        (TransitionState::Ok, false)
    );
}

/// A path-clipped ball of 0.3 m that goes by `m` to `disp`: what is said, how far it is put back, along what.
fn clipped(ball: bool, disp: Vec3, m: Vec3, perfect: bool) -> (TransitionState, Vec3, Option<Vec3>) {
    let mut mover = missile();
    mover.state.set(ObjectState::PERFECT_CLIP, perfect);
    let mut rig = Rig::flat();
    let mut t = beside(&mut rig, &mover, &Carried::default(), disp - m);
    t.path.add_offset_to_check_pos(m);
    let before = t.path.check_pos.origin();
    let ts = if ball {
        t.intersects_sphere(&BALL, false)
    } else {
        t.intersects_cylsphere(&post(2.0), &Frame::IDENTITY)
    };
    (ts, t.path.check_pos.origin() - before, t.info.collision.get())
}

#[test]
fn s8_3_9_s8_4_9_without_perfect_clip_a_hit_rejects() {
    for ball in [true, false] {
        let z = if ball { 0.0 } else { 1.0 };
        let (ts, moved, n) = clipped(ball, v(-0.5, 0.0, z), v(1.5, 0.0, 0.0), false);
        assert_eq!((ts, moved), (TransitionState::Collided, Vec3::ZERO));
        assert!(close(n.unwrap(), -Vec3::X));
    }
}

#[test]
fn s8_3_9_a_start_inside_the_ball_has_no_time_of_contact() {
    let (ts, moved, n) = clipped(true, v(-0.5, 0.0, 0.0), v(0.1, 0.0, 0.0), true);
    assert_eq!((ts, moved, n), (TransitionState::Collided, Vec3::ZERO, None));
}

#[test]
fn s8_4_9_from_above_and_outside_the_rim_decides_between_top_and_side() {
    // Down steeply onto the top; down flatly against the side, below the rim.
    let (ts, _, n) = clipped(false, v(-0.3, 0.0, 2.0), v(0.6, 0.0, -1.2), true);
    assert_eq!((ts, n), (TransitionState::Adjusted, Some(Vec3::Z)));
    let (ts, moved, n) = clipped(false, v(-0.5, 0.0, 1.7), v(1.5, 0.0, -0.8), true);
    assert_eq!((ts, n), (TransitionState::Adjusted, Some(-Vec3::X)));
    // Where its centre is 0.8 m from the axis.
    assert!((moved.x + 0.3).abs() < 1e-4, "{moved}");
}

#[test]
fn s8_3_8_4_heads_are_met_too() {
    // The foot is below: only the head overlaps.
    let head = v(-0.85, 0.0, -0.875);
    for ball in [true, false] {
        let met = |carried: &Carried| {
            let mut rig = Rig::flat();
            let mut t = beside(&mut rig, &walker(), carried, head - v(0.2, 0.1, 0.0));
            t.path.add_offset_to_check_pos(v(0.2, 0.1, 0.0));
            let before = t.path.check_pos.origin();
            let ts = if ball {
                t.intersects_sphere(&BALL, false)
            } else {
                t.intersects_cylsphere(&post(0.5), &Frame::IDENTITY)
            };
            (ts, t.path.check_pos.origin() - before, t.info.collision.valid)
        };
        // A walker slides along it, one in the air is rejected.
        let (ts, moved, normal) = met(&on_level(0.0));
        assert_eq!((ts, normal), (TransitionState::Slid, true), "{ball}");
        assert!(moved.x < -0.1, "{moved}");
        assert_eq!(
            met(&Carried::default()),
            (TransitionState::Collided, Vec3::ZERO, true)
        );
    }
}

#[test]
fn s8_3_5_s8_4_4_in_the_air_a_foot_lands() {
    for ball in [true, false] {
        let mut rig = Rig::flat();
        let mut t = beside(&mut rig, &walker(), &Carried::default(), v(0.2, 0.0, 1.1));
        t.path
            .add_offset_to_check_pos(v(0.0, 0.0, if ball { -0.2 } else { -0.3 }));
        let ts = if ball {
            t.intersects_sphere(&BALL, false)
        } else {
            t.intersects_cylsphere(&post(0.5), &Frame::IDENTITY)
        };
        assert_eq!(ts, TransitionState::Adjusted);
        assert!(t.path.collide && t.path.walkable_allowance == crate::constants::Z_FOR_LANDING);
        let n = if ball {
            v(0.2, 0.0, 1.1).normalize()
        } else {
            Vec3::Z
        };
        assert!(close(t.path.step_up_normal, n));
    }
}

#[test]
fn s7_7_a_body_does_not_meet_itself_among_others() {
    let mut rig = Rig::flat();
    let stand = |rig: &mut Rig, x: f32| {
        let id = rig
            .population
            .add(Body::creature(&[Sphere::new(v(0.0, 0.0, 0.5), 0.5)], Default::default()).unwrap());
        let at = vestibule_world::Position::new(LAND, v(x, 12.0, 0.0));
        assert!(
            rig.population
                .force_into_cell(&rig.world, &mut rig.scratch, id, &at)
        );
        id
    };
    let own = stand(&mut rig, 8.0);
    let other = stand(&mut rig, 16.0);
    let mut met = |body, x: f32| {
        let mut mover = walker();
        mover.body = Some(body);
        let swept = rig.sweep(&mover, &on_level(0.0), v(x, 12.0, 0.0), v(x + 0.2, 12.0, 0.0));
        (
            close(swept.position.origin(), v(x + 0.2, 12.0, 0.0)),
            rig.scratch.touched.len(),
        )
    };
    assert_eq!(met(own, 8.0), (true, 0));
    // Who is not it, is met.
    assert_eq!(met(other, 8.0), (false, 1));
}

#[test]
fn s6_11_4_a_clipped_mover_is_moved_back_in_the_scale_of_the_world() {
    // The wall of a model at 6 m from its origin, seen at a scale of 1/2 and 1.
    for (scale, wall) in [(1.0, 12.0), (0.5, 9.0)] {
        let mut rig = Rig::with_faces(&[wall_facing_west(18.0, [4.0, 20.0], [0.0, 8.0])]);
        let id = rig.population.add(Body::player());
        let world = &rig.world;
        let fixed = world.static_object(world.statics_in(LAND)[0]).unwrap();
        let frame = Frame::at(v(wall - 6.0 * scale, 12.0, 0.0));
        let target = Target {
            object: ObjectRef::Body(id),
            cell: LAND,
            frame: &frame,
            scale,
            state: SOLID | PhysicsState::HAS_PHYSICS_BSP,
            kind: ObjectKind::NONE,
            shape: &fixed.shape,
            part_frames: &[frame],
        };
        let at = vestibule_world::Position::new(LAND, v(wall - 0.5, 12.0, 2.0));
        let mut t = crate::sweep::begin(
            world,
            &rig.population,
            &mut rig.scratch,
            &missile(),
            &Carried::default(),
            &at,
            crate::transition::InsertType::Transition,
        );
        t.path.add_offset_to_check_pos(v(0.4, 0.0, 0.0));
        assert_eq!(
            t.find_object_collisions(&target),
            TransitionState::Adjusted,
            "{scale}"
        );
        // It touches the wall with its radius of 0.3.
        let x = t.path.check_pos.origin().x;
        assert!((x - (wall - 0.3)).abs() < 0.01, "{scale}: {x}");
    }
}
