//! Examples 12.22 to 12.24: surfaces, textures, palettes and scenes.

use glam::Vec3;

use super::*;
use crate::primitive::{Argb, Frame};

#[test]
fn example_12_22_surfaces() {
    let bytes = hex("02 00 00 00 A0 0F 00 05 00 00 00 00 00 00 00 00 00 00 00 00 00 00 80 3F");
    let Record::Surface(image) = record(RecordKind::Surface, 0x0800_0001, &bytes) else {
        panic!()
    };
    assert_eq!(
        image.paint,
        Paint::Image {
            texture: 0x0500_0FA0,
            palette: 0
        }
    );
    assert_eq!(
        (image.translucency, image.luminosity, image.diffuse),
        (0.0, 0.0, 1.0)
    );

    let bytes = hex("01 00 00 00 40 80 FF 80 00 00 00 3F 00 00 00 00 00 00 80 3F");
    let Record::Surface(solid) = record(RecordKind::Surface, 0x0800_0002, &bytes) else {
        panic!()
    };
    assert_eq!(
        (solid.paint, solid.translucency),
        (Paint::Color(Argb(0x80FF_8040)), 0.5)
    );

    let bytes = hex("A0 0F 00 05 07 00 00 00 02 02 00 00 00 34 12 00 06 35 12 00 06");
    let Record::SurfaceTexture(sizes) = record(RecordKind::SurfaceTexture, 0x0500_0FA0, &bytes) else {
        panic!()
    };
    assert_eq!((sizes.data_category, sizes.texture_type), (7, 2));
    assert_eq!(sizes.textures, [0x0600_1234, 0x0600_1235]);
}

#[test]
fn example_12_23_render_surface() {
    let bytes =
        hex("01 00 00 06 06 00 00 00 02 00 00 00 01 00 00 00 14 00 00 00 06 00 00 00 00 00 FF 00 FF 00");
    let Record::RenderSurface(texture) = record(RecordKind::RenderSurface, 0x0600_0001, &bytes) else {
        panic!()
    };
    assert_eq!((texture.width, texture.height), (2, 1));
    assert_eq!(texture.pixel_format(), Some(PixelFormat::R8G8B8));
    assert_eq!(texture.pixels, [0, 0, 0xFF, 0, 0xFF, 0]);
    assert_eq!(
        (PixelFormat::R8G8B8.byte_length(2, 1), texture.palette),
        (Some(6), None)
    );

    let bytes = hex(
        "02 00 00 06 06 00 00 00 02 00 00 00 02 00 00 00 29 00 00 00 04 00 00 00
         00 01 01 00 7E 00 00 04",
    );
    let Record::RenderSurface(indexed) = record(RecordKind::RenderSurface, 0x0600_0002, &bytes) else {
        panic!()
    };
    assert_eq!(
        (indexed.pixel_format(), indexed.palette),
        (Some(PixelFormat::P8), Some(0x0400_007E))
    );

    let bytes = hex("01 00 00 04 02 00 00 00 30 20 10 FF FF FF FF 00");
    let Record::Palette(palette) = record(RecordKind::Palette, 0x0400_0001, &bytes) else {
        panic!()
    };
    assert_eq!(palette.colors, [Argb(0xFF10_2030), Argb(0x00FF_FFFF)]);
}

#[test]
fn example_12_24_scene() {
    let mut bytes = hex("01 00 00 12 01 00 00 00 21 03 00 02
         00 00 00 00 00 00 00 00 00 00 00 00 00 00 80 3F 00 00 00 00 00 00 00 00 00 00 00 00");
    assert_eq!(bytes.len(), 0x28);
    bytes.extend(hex("00 00 80 3E 00 00 C0 40 00 00 C0 40 CD CC 4C 3F 9A 99 99 3F
         00 00 B4 43 33 33 33 3F 00 00 80 3F"));
    bytes.extend([0; 12]);
    assert_eq!(bytes.len(), 84);
    let Record::Scene(scene) = record(RecordKind::Scene, 0x1200_0001, &bytes) else {
        panic!()
    };
    assert_eq!(
        scene.objects,
        [ObjectDesc {
            object_id: 0x0200_0321,
            base_loc: Frame {
                origin: Vec3::ZERO,
                ..Frame::IDENTITY
            },
            frequency: 0.25,
            displace_x: 6.0,
            displace_y: 6.0,
            min_scale: 0.8,
            max_scale: 1.2,
            max_rotation: 360.0,
            min_slope: 0.7,
            max_slope: 1.0,
            align: 0,
            orient: 0,
            weenie_obj: 0,
        }]
    );
}
