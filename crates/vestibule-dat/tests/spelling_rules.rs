//! What has more than one spelling keeps the one it was read in (`dat-format.md` D5), down to the primitives of section 7.

use vestibule_dat::RecordKind;
use vestibule_dat::primitive::{Bool32, CompressedForm, LegacyString, PackedHashTable, Reader, Writer};
use vestibule_dat::record::*;

fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

#[test]
fn d5_long_spellings_of_counts_survive() {
    let mut model = GfxObj {
        flags: 2,
        surfaces: vec![7],
        ..GfxObj::default()
    };
    let leaf = BspNode::Leaf {
        index: 0,
        physics: None,
    };
    let bsp = BspTree {
        kind: BspKind::Drawing,
        nodes: vec![leaf],
    };
    model.drawing = Some(GfxObjPolygons {
        polygons: vec![],
        form: CompressedForm::Four,
        bsp,
    });
    let mut lengths = vec![];
    for form in [CompressedForm::One, CompressedForm::Two, CompressedForm::Four] {
        model.surfaces_form = form;
        let bytes = model.encode().unwrap();
        assert_eq!(GfxObj::parse(0, &bytes).unwrap(), model);
        lengths.push(bytes.len());
    }
    assert_eq!(lengths, [lengths[0], lengths[0] + 1, lengths[0] + 3]);
}

#[test]
fn p1_a_form_too_short_for_the_value_is_lengthened() {
    let mut writer = Writer::new(0);
    writer
        .compressed_u32(0x4000, CompressedForm::One, "count")
        .unwrap();
    assert_eq!(writer.finish().0, [0xC0, 0, 0, 0x40]);
    assert!(
        Writer::new(0)
            .compressed_u32(0x4000_0000, CompressedForm::Four, "count")
            .is_err()
    );
}

#[test]
fn d5_any_non_zero_boolean_is_true_and_stays_what_it_was() {
    let block = LandBlock {
        id: 1,
        has_objects: Bool32(0xCDCD_0000),
        terrain: [0x780; 81],
        height: [0; 81],
    };
    let read = LandBlock::parse(1, &block.encode().unwrap()).unwrap();
    assert!(read.has_objects.is_true());
    assert_eq!(read, block, "unused terrain bits and the word are kept");
}

#[test]
fn d5_padding_that_is_not_zero_is_told_apart_from_data() {
    let mut bytes = LandBlock {
        id: 1,
        has_objects: Bool32(0),
        terrain: [0; 81],
        height: [0; 81],
    }
    .encode()
    .unwrap();
    assert_eq!(bytes.len(), 252);
    bytes[251] = 0xCD;
    assert_eq!(
        round_trip(RecordKind::LandBlock, 1, &bytes),
        Ok(RoundTrip::PaddingDiffers)
    );

    let portal = BuildingPortal {
        stabs: vec![0x1_0100],
        other_cell_id: 0x1_0100,
        ..Default::default()
    };
    let building = Building {
        portals: vec![portal],
        ..Building::default()
    };
    let info = LandBlockInfo {
        id: 0x1_FFFE,
        buildings: vec![building],
        ..LandBlockInfo::default()
    };
    let mut bytes = info.encode().unwrap();
    let last = bytes.len() - 1;
    bytes[last] = 1;
    assert_eq!(
        round_trip(RecordKind::LandBlockInfo, 1, &bytes),
        Ok(RoundTrip::PaddingDiffers)
    );
}

#[test]
fn d5_unknown_record_types_pass_through() {
    let bytes = [1, 2, 3];
    let record = Record::parse(RecordKind::Wave, 0x0A00_0001, &bytes).unwrap();
    assert_eq!(record.kind(), RecordKind::Wave);
    assert_eq!(record.encode().unwrap(), bytes);
    assert_eq!(
        round_trip(RecordKind::Unknown, 1, &bytes),
        Ok(RoundTrip::Identical)
    );
}

#[test]
fn d5_nan_payloads_and_negative_zero_survive() {
    let bytes = words(&[1, 0, 0x7F80_0001, 0xFFC1_2345, 0x8000_0000]);
    assert_eq!(
        round_trip(RecordKind::Surface, 0, &bytes),
        Ok(RoundTrip::Identical)
    );
}

#[test]
fn p3_a_short_string_spelled_long_survives_and_a_long_one_is_spelled_long() {
    let long = LegacyString {
        bytes: b"ab".to_vec(),
        long_form: true,
    };
    let mut writer = Writer::new(0);
    writer.legacy_string(&long, "name").unwrap();
    let (bytes, padding) = writer.finish();
    assert_eq!(bytes, [0xFF, 0xFF, 2, 0, 0, 0, b'a', b'b']);
    assert!(padding.is_empty());
    assert_eq!(Reader::new(0, &bytes).legacy_string("name"), Ok(long));

    let huge = LegacyString::new(vec![b'x'; 0xFFFF]);
    let mut writer = Writer::new(0);
    writer.legacy_string(&huge, "name").unwrap();
    let bytes = writer.finish().0;
    assert_eq!(bytes[..6], [0xFF, 0xFF, 0xFF, 0xFF, 0, 0]);
    assert_eq!(
        Reader::new(0, &bytes).legacy_string("name").unwrap().bytes.len(),
        0xFFFF
    );
}

#[test]
fn p3_text_is_windows_1252() {
    let text = "Caf\u{E9} \u{2013} 5\u{20AC}";
    let string = LegacyString::from(text);
    assert_eq!(string.bytes, b"Caf\xE9 \x96 5\x80");
    assert_eq!(string.text(), text);
    assert_eq!(LegacyString::from("\u{4E16}").bytes, b"?");
}

#[test]
fn p4_strings_with_narrow_and_wide_characters() {
    let mut reader = Reader::new(0, &[2, b'h', b'i', 1, 0x16, 0x4E]);
    assert_eq!(reader.p_string("name").unwrap().0, b"hi");
    assert_eq!(reader.p_string_wide("name").unwrap().0, [0x4E16]);
    let mut writer = Writer::new(0);
    writer.p_string(b"hi", CompressedForm::One, "name").unwrap();
    writer
        .p_string_wide(&[0x4E16], CompressedForm::One, "name")
        .unwrap();
    assert_eq!(writer.finish().0, [2, b'h', b'i', 1, 0x16, 0x4E]);
}

#[test]
fn p6_alignment_counts_from_the_records_start() {
    let mut writer = Writer::new(0);
    writer.u8(1);
    writer.align4();
    writer.align4();
    assert_eq!(writer.position(), 4);
    writer.u16(1);
    writer.align4();
    assert_eq!(writer.finish(), (vec![1, 0, 0, 0, 1, 0, 0, 0], vec![1..4, 6..8]));
}

#[test]
fn p8_a_new_table_groups_keys_by_bucket() {
    let table = PackedHashTable::new(vec![(17, 0), (8, 1), (1, 2), (16, 3), (9, 4)]);
    assert_eq!(table.bucket_count, 8);
    let keys: Vec<_> = table.entries.iter().map(|entry| entry.0).collect();
    assert_eq!(keys, [8, 16, 1, 9, 17]);
}

#[test]
fn p9_a_cell_of_another_landblock_cannot_be_written() {
    let cell = EnvCell {
        id: 0x1234_0100,
        environment: 0x0D00_0001,
        stabs: vec![0x1235_0101],
        ..EnvCell::default()
    };
    let error = cell.encode().unwrap_err();
    assert_eq!((error.id, error.field), (0x1234_0100, "stabs"));
}
