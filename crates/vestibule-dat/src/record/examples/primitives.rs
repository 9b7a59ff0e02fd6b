//! Examples 12.7 to 12.11.

use glam::{Quat, Vec3};

use super::*;
use crate::primitive::{CompressedForm, Frame, KnownTypeId, LegacyString};

#[test]
fn example_12_7_iteration_record() {
    let bytes = hex("D6 03 00 00 2A FC FF FF 01 00 00 00");
    let Record::Iteration(complete) = record(RecordKind::Iteration, 0xFFFF_0001, &bytes) else {
        panic!()
    };
    assert_eq!(complete, IterationRecord::complete(982));
    assert!(complete.is_complete());

    let bytes = hex("0C 00 00 00 F6 FF FF FF 01 00 00 00 FE FF FF FF 0F 00 00 00");
    let Record::Iteration(partial) = record(RecordKind::Iteration, 0xFFFF_0001, &bytes) else {
        panic!()
    };
    assert_eq!(
        (partial.total, partial.runs.as_slice()),
        (12, [(1, 10), (15, 2)].as_slice())
    );
    assert!(!partial.is_complete());
}

#[test]
fn example_12_8_compressed_u32() {
    for (value, bytes) in [
        (5, "05"),
        (0x7F, "7F"),
        (0x80, "80 80"),
        (0x1234, "92 34"),
        (0x3FFF, "BF FF"),
        (0x4000, "C0 00 00 40"),
        (0x12345, "C0 01 45 23"),
        (0x3FFF_FFFF, "FF FF FF FF"),
    ] {
        let bytes = hex(bytes);
        let mut reader = Reader::new(0, &bytes);
        let (read, form) = reader.compressed_u32("value").unwrap();
        assert_eq!((read, form), (value, CompressedForm::shortest(value)));
        reader.finish().unwrap();
        let mut writer = Writer::new(0);
        writer
            .compressed_u32(value, CompressedForm::One, "value")
            .unwrap();
        assert_eq!(writer.finish().0, bytes);
    }
}

#[test]
fn example_12_9_id_of_known_type() {
    const BASE: u32 = 0x0100_0000;
    let read = |bytes: &str| {
        let bytes = hex(bytes);
        both_ways(
            &bytes,
            |reader| reader.known_type_id(BASE, "id"),
            |&id, writer| writer.known_type_id(id, BASE, "id"),
        )
    };
    let new = |id| {
        let mut writer = Writer::new(0);
        writer
            .known_type_id(KnownTypeId::new(id, BASE), BASE, "id")
            .unwrap();
        writer.finish().0
    };
    for (id, bytes) in [
        (0x0100_0123, "23 01"),
        (0x0100_3FFF, "FF 3F"),
        (0x0100_5678, "00 80 78 56"),
        (0x0101_2345, "01 80 45 23"),
    ] {
        assert_eq!(read(bytes).id, id);
        assert_eq!(new(id), hex(bytes));
    }
    assert_eq!(
        read("78 56"),
        KnownTypeId {
            id: 0x0100_5678,
            long_form: false
        }
    );
}

#[test]
fn example_12_10_strings() {
    for (text, bytes) in [
        ("Dereth", "06 00 44 65 72 65 74 68"),
        ("Morntide", "08 00 4D 6F 72 6E 74 69 64 65 00 00"),
    ] {
        let read = both_ways(
            &hex(bytes),
            |reader| reader.legacy_string("name"),
            |name, writer| writer.legacy_string(name, "name"),
        );
        assert_eq!(read.text(), text);
        assert_eq!(read, LegacyString::from(text));
    }
    let flame = both_ways(
        &hex("05 00 64 C6 16 D6 56 00"),
        |reader| reader.obfuscated_string("name"),
        |name, writer| writer.obfuscated_string(name, "name"),
    );
    assert_eq!(flame, b"Flame");
}

#[test]
fn example_12_11_frame() {
    let bytes = hex("00 00 AB 42 00 00 DB 42 00 00 40 41 F3 04 35 3F
         00 00 00 00 00 00 00 00 F3 04 35 BF");
    let frame = both_ways(
        &bytes,
        |reader| reader.frame("frame"),
        |frame, writer| {
            writer.frame(frame);
            Ok(())
        },
    );
    let half = 0.70710677;
    assert_eq!(
        frame,
        Frame {
            origin: Vec3::new(85.5, 109.5, 12.0),
            rotation: Quat::from_xyzw(0.0, 0.0, -half, half)
        }
    );
}
