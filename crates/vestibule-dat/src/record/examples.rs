//! The worked examples of `dat-format.md` section 12 that concern records, each in both directions.

mod geometry;
mod portal_records;
mod primitives;
mod world_records;

use super::*;

/// Bytes from lines of hexadecimal.
fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).expect("two digits"))
        .collect()
}

/// Reads with `read`, checks that all bytes were used, writes with `write` and checks that the same bytes come out.
fn both_ways<T>(
    bytes: &[u8],
    read: impl FnOnce(&mut Reader<'_>) -> Result<T, RecordError>,
    write: impl FnOnce(&T, &mut Writer) -> Result<(), RecordError>,
) -> T {
    let mut reader = Reader::new(0, bytes);
    let value = read(&mut reader).expect("the example reads");
    reader.finish().expect("the example reads to its end");
    let mut writer = Writer::new(0);
    write(&value, &mut writer).expect("the example writes");
    assert_eq!(writer.finish().0, bytes);
    value
}

/// A whole record by its kind, in both directions.
fn record(kind: RecordKind, id: u32, bytes: &[u8]) -> Record {
    let record = Record::parse(kind, id, bytes).expect("the example parses");
    assert_eq!(record.kind(), kind);
    assert_eq!(record.encode().expect("the example encodes"), bytes);
    assert_eq!(round_trip(kind, id, bytes), Ok(RoundTrip::Identical));
    if let Some(stored) = record.stored_id() {
        assert_eq!(stored, id);
    }
    record
}
