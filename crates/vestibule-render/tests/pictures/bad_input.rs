//! Missing and damaged records, absurd sizes, a world that goes away: a message, or a placeholder that is counted.

use vestibule_dat::record::{RenderSurface, Surface, SurfaceTexture};
use vestibule_render::{AssetCounters, Image, RenderError};
use vestibule_world::{CellManager, MemoryRecords, ResidencySettings, Store};

use crate::common::hollow_records;
use crate::*;

/// A picture of the cottage's hall, what was counted, and how many of its pixels are the checker's magenta.
fn hall(edit: impl FnOnce(&mut MemoryRecords)) -> (AssetCounters, usize) {
    let mut stage = Stage::edited(VILLAGE, edit);
    stage.update(look(0xA9B4_0101, [157.5, 13.4, 95.6], [152.0, 9.0, 95.2], SMALL));
    let picture = render(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap();
    let magenta = |p: &&[u8; 4]| p[0] > 40 && p[2] > 40 && p[1] < p[0] / 4;
    (
        stage.assets.counters(),
        picture.pixels().iter().filter(magenta).count(),
    )
}

/// The surface of the hall's largest wall, its SurfaceTexture and its RenderSurface.
fn hall_surface() -> (u32, u32, u32) {
    let stage = village();
    let hall = stage.world.env_cell(CellId(0xA9B4_0101)).unwrap();
    let mesh = stage.assets.cell_shell(&stage.world, hall).unwrap();
    let mut faces = vec![0; hall.surfaces.len()];
    for face in &mesh.faces {
        faces[face.material as usize] += face.count;
    }
    let most = (0..faces.len()).max_by_key(|&k| faces[k]).unwrap();
    let record = |id: u32| {
        let bytes = stage.world.source().record(Store::Portal, id).unwrap().unwrap();
        bytes.into_owned()
    };
    let surface = hall.surfaces[most];
    let parsed = Surface::parse(surface, &record(surface)).unwrap();
    let vestibule_dat::record::Paint::Image { texture, .. } = parsed.paint else {
        panic!("{surface:#x} has no image");
    };
    let texture_record = SurfaceTexture::parse(texture, &record(texture)).unwrap();
    (surface, texture, texture_record.textures[0])
}

/// The same record with something changed.
fn edited(id: u32, edit: impl FnOnce(&mut RenderSurface)) -> Vec<u8> {
    let mut record = RenderSurface::parse(id, &hollow_records().portal[&id]).unwrap();
    edit(&mut record);
    record.encode().unwrap()
}

#[test]
fn sound_records_need_no_placeholder() {
    let (counters, magenta) = hall(|_| {});
    assert_eq!((counters.total(), magenta), (0, 0));
}

#[test]
fn a_missing_or_damaged_surface_is_a_checker_and_counted() {
    let (surface, ..) = hall_surface();
    let (counters, magenta) = hall(|r| assert!(r.remove(Store::Portal, surface)));
    assert!(
        counters.missing_surfaces == 1 && magenta > 100,
        "{counters:?} {magenta}"
    );
    let (counters, magenta) = hall(|r| r.insert(Store::Portal, surface, vec![1, 2, 3]));
    assert!(
        counters.missing_surfaces == 1 && magenta > 100,
        "{counters:?} {magenta}"
    );
}

#[test]
fn a_missing_or_damaged_texture_is_a_checker_and_counted() {
    let (_, texture, image) = hall_surface();
    for id in [texture, image] {
        let (counters, magenta) = hall(|r| assert!(r.remove(Store::Portal, id)));
        assert!(
            counters.missing_textures == 1 && magenta > 100,
            "{counters:?} {magenta}"
        );
    }
    let (counters, magenta) = hall(|r| r.insert(Store::Portal, image, vec![0; 9]));
    assert!(
        counters.missing_textures == 1 && magenta > 100,
        "{counters:?} {magenta}"
    );
}

#[test]
fn textures_of_absurd_size_unknown_format_or_too_few_bytes_are_checkers_and_counted() {
    let (.., image) = hall_surface();
    let edits: [fn(&mut RenderSurface); 6] = [
        |t| t.width = 1 << 20,
        |t| (t.width, t.height) = (i32::MAX, i32::MAX),
        |t| t.height = 0,
        |t| t.width = -4,
        |t| t.format = 9999,
        |t| t.pixels.truncate(5),
    ];
    for edit in edits {
        let (counters, magenta) = hall(|r| r.insert(Store::Portal, image, edited(image, edit)));
        assert!(
            counters.unusable_textures == 1 && magenta > 100,
            "{counters:?} {magenta}"
        );
    }
}

#[test]
fn without_any_surfaces_and_textures_a_picture_is_made() {
    let mut stage = Stage::edited(VILLAGE, |records| {
        let ids: Vec<u32> = hollow_records().portal.keys().copied().collect();
        for id in ids.into_iter().filter(|id| matches!(id >> 24, 5 | 6 | 8)) {
            records.remove(Store::Portal, id);
        }
    });
    stage.update(before_cottage(SMALL));
    render(&stage.scene(), &stage.frame, &RenderSettings::default()).unwrap();
    assert!(stage.assets.counters().missing_surfaces > 0);
    assert!(stage.assets.counters().missing_textures > 0);
}

#[test]
fn pictures_without_pixels_or_of_absurd_size_are_errors() {
    let mut stage = village();
    let settings = RenderSettings::default();
    let none = FrameView::default();
    assert!(render(&stage.scene(), &none, &settings).is_err(), "no frame yet");
    let camera = |w: f32, h: f32| {
        let eye = Vec3::new(155.4, 24.0, 95.6);
        let size = glam::Vec2::new(w, h);
        Camera::new(CellId(0xA9B4_0031), eye, Vec3::Y, Vec3::Z, 1.0, size)
    };
    assert!(camera(0.0, 10.0).is_err() && camera(10.0, f32::NAN).is_err());
    assert!(matches!(
        Image::new(0, 0, [0; 4]),
        Err(RenderError::Size { width: 0, height: 0 })
    ));
    for (w, h) in [(10.5, 10.0), (9000.0, 2.0), (1.0e9, 1.0e9)] {
        stage.update(camera(w, h).unwrap());
        assert!(
            render(&stage.scene(), &stage.frame, &settings).is_err(),
            "{w} x {h}"
        );
        assert!(render_ids(&stage.scene(), &stage.frame, &settings).is_err());
    }
}

#[test]
fn a_world_that_is_unloaded_before_its_frame_is_drawn_leaves_sky_and_a_count() {
    let mut stage = village();
    let camera = before_cottage(SMALL);
    let right = stage.ids(camera);
    // The frame is kept, the landblocks go.
    let mut world = vestibule_world::World::open(hollow_records().memory_records()).unwrap();
    let _manager = CellManager::new(&mut world, ResidencySettings::default());
    let scene = Scene::new(&world, &stage.assets);
    let settings = RenderSettings::default();
    let commands = stage.frame.commands();
    let (picture, counters) = render_commands_ids(&scene, &stage.frame, commands, &settings).unwrap();
    assert!(right.count(PixelKind::Terrain) > 300);
    assert_eq!(
        picture.count(PixelKind::Terrain) + picture.count(PixelKind::Building),
        0
    );
    assert_eq!(picture.count(PixelKind::Sky), picture.ids().len());
    assert!(counters.missing > 20, "{counters:?}");
    render(&scene, &stage.frame, &settings).unwrap();
    // Inside as well, where nothing but the clear colour is left.
    stage.update(in_cottage(SMALL));
    let commands = stage.frame.commands();
    let scene = Scene::new(&world, &stage.assets);
    let (_, counters) = render_commands_ids(&scene, &stage.frame, commands, &settings).unwrap();
    assert!(counters.missing > 20, "{counters:?}");
}
