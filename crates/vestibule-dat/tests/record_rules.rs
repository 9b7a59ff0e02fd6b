//! Single rules of `dat-format.md`, each broken on purpose.

use vestibule_dat::primitive::CompressedForm;
use vestibule_dat::record::*;
use vestibule_dat::{DatBuilder, DatFile, DatKind, Header, IterationRecord, RecordKind, WriteOptions};

/// Bytes of a record, built field by field.
#[derive(Default, Clone)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn u8(mut self, value: u8) -> Self {
        self.0.push(value);
        self
    }

    fn u16(mut self, value: u16) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn u32(mut self, value: u32) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn f32s(mut self, values: &[f32]) -> Self {
        self.0.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self
    }

    fn zeros(mut self, count: usize) -> Self {
        self.0.resize(self.0.len() + count, 0);
        self
    }

    fn raw(mut self, bytes: &[u8]) -> Self {
        self.0.extend(bytes);
        self
    }
}

fn words(values: &[u32]) -> Vec<u8> {
    values
        .iter()
        .fold(Bytes::default(), |bytes, &value| bytes.u32(value))
        .0
}

fn error_of(kind: RecordKind, bytes: &[u8]) -> RecordError {
    let error = Record::parse(kind, 0x0D00_0001, bytes).unwrap_err();
    assert_eq!(error.id, 0x0D00_0001);
    assert!(
        error.to_string().contains("0D000001") && error.to_string().contains(error.field),
        "{error}"
    );
    error
}

/// A GfxObj that only draws: head, `bsp`, nothing else.
fn gfx_obj(bsp: &[u8]) -> Vec<u8> {
    Bytes::default()
        .u32(1)
        .u32(2)
        .u8(0)
        .u32(1)
        .u32(0)
        .f32s(&[0.0; 3])
        .u8(0)
        .raw(bsp)
        .0
}

const BPIN: u32 = 0x4250_494E;
const LEAF: u32 = 0x4C45_4146;

/// `depth` nodes, each the positive child of the one before; the last is a leaf.
fn nest(depth: usize) -> Vec<u8> {
    let inner = Bytes::default().u32(BspTag::BPNN_LOWER).f32s(&[0.0; 4]).0;
    let mut bytes = inner.repeat(depth - 1);
    bytes.extend(words(&[LEAF, 0]));
    // After its children each node of a drawing tree has a sphere and a count.
    bytes.resize(bytes.len() + 20 * (depth - 1), 0);
    bytes
}

#[test]
fn g13_a_tree_1024_deep_is_read_and_a_deeper_one_refused() {
    let deepest = gfx_obj(&nest(BspTree::MAX_DEPTH));
    assert_eq!(
        round_trip(RecordKind::GfxObj, 1, &deepest),
        Ok(RoundTrip::Identical)
    );
    for depth in [BspTree::MAX_DEPTH + 1, 100_000] {
        let error = error_of(RecordKind::GfxObj, &gfx_obj(&nest(depth)));
        assert_eq!(error.kind, RecordErrorKind::BspTooDeep { limit: 1024 });
    }
}

#[test]
fn g13_more_than_a_million_nodes_are_refused() {
    fn full(bytes: &mut Vec<u8>, levels: u32) {
        if levels == 0 {
            bytes.extend(words(&[LEAF, 0]));
            return;
        }
        bytes.extend(words(&[BPIN, 0, 0, 0, 0]));
        full(bytes, levels - 1);
        full(bytes, levels - 1);
        bytes.extend([0; 20]);
    }
    // Full trees of 2^19 - 1 and 2^20 - 1 nodes.
    let [mut half, mut whole] = [vec![], vec![]];
    full(&mut half, 18);
    full(&mut whole, 19);
    assert_eq!(
        round_trip(RecordKind::GfxObj, 1, &gfx_obj(&half)),
        Ok(RoundTrip::Identical)
    );
    let error = error_of(RecordKind::GfxObj, &gfx_obj(&whole));
    assert_eq!(error.kind, RecordErrorKind::BspTooManyNodes { limit: 1_000_000 });
}

#[test]
fn s8_3_a_tag_that_does_not_begin_with_b_is_refused() {
    for tag in [0x4350_494E, 0, 0x6250_494E] {
        let error = error_of(RecordKind::GfxObj, &gfx_obj(&words(&[tag, 0, 0, 0, 0])));
        assert_eq!(
            (error.kind, error.offset),
            (RecordErrorKind::BadBspTag(tag), 0x1E)
        );
    }
    let odd = Bytes::default().u32(0x4241_4243).f32s(&[0.0; 4]).zeros(20).0;
    assert_eq!(
        round_trip(RecordKind::GfxObj, 1, &gfx_obj(&odd)),
        Ok(RoundTrip::Identical)
    );
}

#[test]
fn s8_1_other_vertex_types_are_refused() {
    for vertex_type in [0, 2, 3] {
        let bytes = Bytes::default()
            .u32(1)
            .u32(0)
            .u8(0)
            .u32(vertex_type)
            .u32(0)
            .zeros(12)
            .0;
        let error = error_of(RecordKind::GfxObj, &bytes);
        assert_eq!((error.offset, error.field), (9, "vertices.vertex_type"));
    }
}

#[test]
fn d1_a_count_beyond_the_record_allocates_nothing() {
    for (kind, head, field) in [
        (RecordKind::Palette, words(&[1, 0x7FFF_FFFF]), "colors"),
        (RecordKind::Scene, words(&[1, 0xFFFF_FFFF]), "objects"),
        (
            RecordKind::GfxObjDegradeInfo,
            words(&[1, 0x1000_0000]),
            "degrades",
        ),
        (RecordKind::Environment, words(&[1, 0xFFFF_FFFF]), "cell_structs"),
        (RecordKind::Setup, words(&[1, 0, 0xFFFF_FFFF]), "num_parts"),
        (RecordKind::LandBlockInfo, words(&[1, 0, 0xFFFF_FFFF]), "objects"),
        (
            RecordKind::RenderSurface,
            words(&[1, 0, 0, 0, 20, 0x7FFF_FFFF]),
            "length",
        ),
        (
            RecordKind::SurfaceTexture,
            Bytes::default().u32(1).u32(0).u8(2).u32(0x7FFF_FFFF).0,
            "textures",
        ),
        (
            RecordKind::GfxObj,
            Bytes::default().u32(1).u32(0).raw(&[0xFF; 4]).0,
            "surfaces",
        ),
        (
            RecordKind::EnvCell,
            Bytes::default().u32(1).u32(0).u32(1).raw(&[0xFF; 4]).0,
            "surfaces",
        ),
    ] {
        let error = error_of(kind, &head);
        assert_eq!(error.field, field);
        assert!(matches!(
            error.kind,
            RecordErrorKind::CountTooLarge { .. } | RecordErrorKind::Truncated { .. }
        ));
    }
}

#[test]
fn d6_negative_counts_are_errors() {
    for (kind, bytes) in [
        (RecordKind::Palette, words(&[1, 0x8000_0000])),
        (RecordKind::RenderSurface, words(&[1, 0, 0, 0, 20, 0xFFFF_FFFF])),
        (
            RecordKind::SurfaceTexture,
            Bytes::default().u32(1).u32(0).u8(2).u32(0xFFFF_FFFE).0,
        ),
        (RecordKind::Setup, words(&[1, 0, 0, 0xFFFF_FFFF])),
        (RecordKind::Iteration, words(&[0xFFFF_FFFF])),
    ] {
        assert!(
            matches!(error_of(kind, &bytes).kind, RecordErrorKind::NegativeCount(_)),
            "{kind}"
        );
    }
}

#[test]
fn f6_embedded_ids_are_kept_even_where_the_directory_differs() {
    let bytes = words(&[0x0400_0002, 0]);
    assert_eq!(Palette::parse(0x0400_0001, &bytes).unwrap().id, 0x0400_0002);
}

#[test]
fn v3_other_shapes_of_the_iteration_record_are_errors() {
    let negative = |value: i32| value as u32;
    for (bytes, field) in [
        (words(&[3, negative(-2), 1, 1, 9]), "run.n"),
        (words(&[3, negative(-4), 1]), "run.n"),
        (words(&[3, 0, 1]), "run.n"),
        (words(&[3, 0x8000_0000, 1]), "run.n"),
        (words(&[3, negative(-3)]), "run.start"),
        (words(&[3, negative(-3), 1, 0]), "end of record"),
    ] {
        assert_eq!(error_of(RecordKind::Iteration, &bytes).field, field);
    }
    let empty = IterationRecord {
        total: 0,
        runs: vec![],
    };
    assert_eq!(
        Record::parse(RecordKind::Iteration, 0, &words(&[0])),
        Ok(Record::Iteration(empty))
    );
}

#[test]
fn l7_and_l8_portals_by_flag_or_sentinel() {
    let portal = |flags, cell: u32, other_portal_id| CellPortal {
        flags,
        polygon_id: 0,
        other_cell_id: 0x1234_0000 | cell,
        other_portal_id,
    };
    assert_eq!(portal(4, 0x0101, 0).other_cell(), OtherCell::Outside);
    assert_eq!(portal(0, 0xFFFF, 0).other_cell(), OtherCell::Outside);
    assert_eq!(portal(3, 0x0101, 0).other_cell(), OtherCell::Cell(0x1234_0101));
    assert_eq!(
        (portal(0, 1, 0).portal_side(), portal(2, 1, 0).portal_side()),
        (1, 0)
    );
    assert_eq!(
        (portal(0, 1, 0).exact_match(), portal(1, 1, 0).exact_match()),
        (false, true)
    );
    assert_eq!(
        (portal(0, 1, -1).other_portal(), portal(0, 1, 7).other_portal()),
        (None, Some(7))
    );
    let building = BuildingPortal {
        other_portal_id: -1,
        ..BuildingPortal::default()
    };
    assert_eq!(building.other_portal(), None);
}

#[test]
fn g10_the_first_of_two_polygons_with_one_id_is_found() {
    let polygon = |id, pos_surface| Polygon {
        id,
        pos_surface,
        ..Polygon::default()
    };
    let polygons = [polygon(1, 10), polygon(1, 11), polygon(0, 12)];
    assert_eq!(find_polygon(&polygons, 1).unwrap().pos_surface, 10);
    assert_eq!(find_polygon(&polygons, 0).unwrap().pos_surface, 12);
    assert!(find_polygon(&polygons, 2).is_none());
}

#[test]
fn g15_polygons_with_too_few_points_are_kept() {
    let polygon = Bytes::default()
        .u16(0)
        .u8(2)
        .u8(4)
        .u32(0)
        .zeros(4)
        .u16(0)
        .u16(1)
        .0;
    let record = Bytes::default()
        .u32(1)
        .u32(2)
        .u8(0)
        .u32(1)
        .u32(0)
        .zeros(12)
        .u8(1)
        .raw(&polygon);
    let bytes = record.raw(&words(&[LEAF, 0])).0;
    assert_eq!(
        round_trip(RecordKind::GfxObj, 1, &bytes),
        Ok(RoundTrip::Identical)
    );
    let model = GfxObj::parse(1, &bytes).unwrap();
    assert!(!model.drawing.unwrap().polygons[0].is_usable());
}

#[test]
fn x3_a_placement_frame_with_a_hook_of_unknown_length_fails() {
    let setup = |hook: &[u8]| {
        let head = words(&[0x0200_0001, 0, 0, 0, 0, 1, 0x65, 1]);
        Bytes::default()
            .raw(&head)
            .raw(hook)
            .zeros(4 * 2 + 16 + 32 + 4 + 20)
            .0
    };
    for hook_type in [0x1A, 0x1B, 0xFFFF_FFFF] {
        let error = error_of(RecordKind::Setup, &setup(&words(&[hook_type, 0])));
        assert_eq!((error.offset, error.field), (0x20, "hook.type"));
    }
    for (hook, payload) in [
        (Bytes::default().u32(5).u32(0).u16(3).u16(0x123), 4),
        (Bytes::default().u32(5).u32(0).u16(3).u16(0x8001).u16(0x2345), 6),
        (Bytes::default().u32(0x0D).u32(0).zeros(40), 40),
        (Bytes::default().u32(0x11).u32(0), 0),
    ] {
        let bytes = setup(&hook.0);
        assert_eq!(round_trip(RecordKind::Setup, 1, &bytes), Ok(RoundTrip::Identical));
        let read = Setup::parse(1, &bytes).unwrap();
        assert_eq!(read.placement_frames[0].hooks[0].payload.len(), payload);
    }
}

#[test]
fn x4_resting_then_default_then_the_first() {
    let setup = |keys: &[i32]| Setup {
        placement_frames: keys
            .iter()
            .map(|&placement| PlacementFrame {
                placement,
                ..PlacementFrame::default()
            })
            .collect(),
        ..Setup::default()
    };
    let chosen = |keys: &[i32]| setup(keys).resting_frame().map(|pose| pose.placement);
    assert_eq!(chosen(&[0, 3, 0x65]), Some(0x65));
    assert_eq!(chosen(&[3, 0]), Some(0));
    assert_eq!(chosen(&[3, 4]), Some(3));
    assert_eq!(chosen(&[]), None);
}

#[test]
fn s10_4_other_region_versions_and_land_surfaces_are_refused() {
    let error = error_of(RecordKind::Region, &words(&[0x1300_0000, 1, 4]));
    assert_eq!((error.offset, error.field), (8, "version"));

    // An empty region: name, land defs, calendar, mask, terrain types; then the kind of land surface.
    let head = Bytes::default()
        .u32(0x1300_0000)
        .u32(1)
        .u32(3)
        .zeros(4 + 32 + 1024 + 20 + 4 + 12 + 4 + 4);
    let tex_merge = head.clone().u32(0).zeros(20).0;
    assert_eq!(
        round_trip(RecordKind::Region, 1, &tex_merge),
        Ok(RoundTrip::Identical)
    );
    let error = error_of(RecordKind::Region, &head.u32(1).zeros(20).0);
    assert_eq!((error.offset, error.field), (1116, "land_surf.kind"));
}

#[test]
fn x7_land_defs_are_checked_as_the_client_does() {
    let sound = region::LandDefs {
        num_block_length: 255,
        num_block_width: 255,
        square_length: 24.0,
        lblock_length: 8,
        vertex_per_cell: 1,
        max_obj_height: 200.0,
        sky_height: 1000.0,
        road_width: 5.0,
        land_height_table: [0.0; 256],
    };
    assert_eq!(sound.validate(), Ok(()));
    type Break = fn(&mut region::LandDefs);
    let breaks: [(Break, &str); 10] = [
        (|defs| defs.num_block_length = 256, "num_block_length"),
        (|defs| defs.num_block_width = 0, "num_block_width"),
        (|defs| defs.square_length = f32::NAN, "square_length"),
        (|defs| defs.lblock_length = 7, "lblock_length"),
        (|defs| defs.vertex_per_cell = 65, "vertex_per_cell"),
        (|defs| defs.max_obj_height = 9.0, "max_obj_height"),
        (|defs| defs.sky_height = 1_000_000.0, "sky_height"),
        (|defs| defs.road_width = 24.0, "road_width"),
        (|defs| defs.land_height_table[255] = 800.5, "land_height_table"),
        (|defs| defs.land_height_table[0] = -0.5, "land_height_table"),
    ];
    for (break_it, field) in breaks {
        let mut defs = sound.clone();
        break_it(&mut defs);
        assert_eq!(defs.validate(), Err(field));
    }
}

#[test]
fn x15_pixel_bytes_by_format() {
    for (format, bytes) in [
        (PixelFormat::R8G8B8, 15),
        (PixelFormat::A8R8G8B8, 20),
        (PixelFormat::R5G6B5, 10),
        (PixelFormat::P8, 5),
        (PixelFormat::Dxt1, 16),
        (PixelFormat::Dxt5, 32),
    ] {
        assert_eq!(format.byte_length(5, 1), Some(bytes), "{format:?}");
    }
    assert_eq!(PixelFormat::RawJpeg.byte_length(5, 1), None);
    assert_eq!(PixelFormat::of(0x31), None);
}

#[test]
fn contradicting_fields_cannot_be_written() {
    let with_static = EnvCell {
        environment: 0x0D00_0001,
        statics: vec![Stab::default()],
        ..EnvCell::default()
    };
    assert_eq!(with_static.encode().unwrap_err().field, "statics");
    let unread = EnvCell {
        environment: 0x0D00_0001,
        flags: 8,
        ..EnvCell::default()
    };
    assert_eq!(unread.encode().unwrap_err().field, "restriction");
    let many = EnvCell {
        environment: 0x0D00_0001,
        surfaces: vec![0x0800_0000; 256],
        ..EnvCell::default()
    };
    assert_eq!(
        many.encode().unwrap_err().kind,
        RecordErrorKind::TooMany { count: 256, max: 255 }
    );
    assert_eq!(
        GfxObj {
            flags: 1,
            ..GfxObj::default()
        }
        .encode()
        .unwrap_err()
        .field,
        "physics"
    );
    let cyclic = BspNode::Inner {
        tag: BspTag::BPNN_LOWER,
        plane: Default::default(),
        pos: Some(0),
        neg: None,
        sphere: Some(Default::default()),
        polys: vec![],
    };
    let bsp = BspTree {
        kind: BspKind::Drawing,
        nodes: vec![cyclic],
    };
    let drawing = GfxObjPolygons {
        polygons: vec![],
        form: CompressedForm::One,
        bsp,
    };
    let model = GfxObj {
        flags: 2,
        drawing: Some(drawing),
        ..GfxObj::default()
    };
    assert!(model.encode().is_err(), "a tree that goes in circles");
}

#[test]
fn d2_a_record_error_names_the_file_and_spares_other_records() {
    let mut dat = DatBuilder::new("test", Vec::new(), Header::new(DatKind::Portal)).unwrap();
    dat.push(
        0x0400_0001,
        &words(&[0x0400_0001, 2, 0]),
        &WriteOptions::default(),
    )
    .unwrap();
    dat.push(
        0x0400_0002,
        &words(&[0x0400_0002, 1, 9]),
        &WriteOptions::default(),
    )
    .unwrap();
    let file = DatFile::from_bytes("some_portal.dat", dat.finish().unwrap()).unwrap();
    let error = file.record(0x0400_0001).unwrap_err();
    assert_eq!(
        (error.id(), error.offset(), error.field()),
        (Some(0x0400_0001), Some(8), "colors")
    );
    let text = error.to_string();
    for part in [
        "some_portal.dat",
        "0x04000001",
        "byte 0x8 of the record",
        "colors",
    ] {
        assert!(text.contains(part), "{part} is missing from {text:?}");
    }
    assert!(matches!(file.record(0x0400_0002), Ok(Some(Record::Palette(_)))));
    assert_eq!(
        file.record_as::<Palette>(0x0400_0002)
            .unwrap()
            .unwrap()
            .colors
            .len(),
        1
    );
    assert!(file.record(0x0400_0003).unwrap().is_none());
}
