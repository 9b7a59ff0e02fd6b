//! Missing and damaged records, absurd sizes.

use crate::*;

#[test]
fn bad_input_is_a_message_or_a_count_never_a_crash() {
    let mut stage = village();
    let frame = FrameView::default();
    assert!(
        render(&stage.scene(), &frame, &RenderSettings::default()).is_err(),
        "no frame yet"
    );
    let camera = |w: f32, h: f32| {
        let eye = Vec3::new(155.4, 24.0, 95.6);
        Camera::new(
            CellId(0xA9B4_0031),
            eye,
            Vec3::Y,
            Vec3::Z,
            1.0,
            glam::Vec2::new(w, h),
        )
    };
    assert!(camera(0.0, 10.0).is_err());
    for (w, h) in [(10.5, 10.0), (9000.0, 2.0), (1.0e9, 1.0e9)] {
        stage.update(camera(w, h).unwrap());
        assert!(render(&stage.scene(), &stage.frame, &RenderSettings::default()).is_err());
    }
    // Without any surface or texture records: everything is a checker, and counted.
    let compiled = vestibule_forge::embedded_world().unwrap();
    let mut records = compiled.memory_records();
    let ids: Vec<u32> = compiled
        .portal
        .keys()
        .copied()
        .filter(|id| matches!(id >> 24, 5 | 6 | 8))
        .collect();
    for id in ids {
        records.remove(vestibule_world::Store::Portal, id);
    }
    let world = vestibule_world::World::open(records).unwrap();
    let mut bare = Stage::new(world, vestibule_world::BlockId(VILLAGE));
    bare.update(before_cottage(SMALL));
    render(&bare.scene(), &bare.frame, &RenderSettings::default()).unwrap();
    assert!(bare.assets.counters().missing_surfaces > 0);
    assert!(bare.assets.counters().missing_textures > 0);
}
