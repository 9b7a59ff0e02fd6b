//! Writing.

use std::ops::Range;

use glam::{Quat, Vec2, Vec3};

use super::{
    Argb, Bool32, CompressedForm, CylSphere, Frame, KnownTypeId, LegacyString, PackedHashTable, Plane, Sphere,
};
use crate::record::{RecordError, RecordErrorKind};

/// Builds the bytes of one record. It remembers which bytes are padding, so that a verifier can tell a difference
/// in padding from one that matters (D5).
#[derive(Debug, Clone, Default)]
pub struct Writer {
    bytes: Vec<u8>,
    padding: Vec<Range<usize>>,
    id: u32,
}

type Written = Result<(), RecordError>;

impl Writer {
    /// Starts record `id`, which is only used in errors.
    pub fn new(id: u32) -> Self {
        Self {
            id,
            ..Self::default()
        }
    }

    /// Data id of the record, for errors.
    pub fn id(&self) -> u32 {
        self.id
    }

    /// Bytes written so far.
    pub fn position(&self) -> usize {
        self.bytes.len()
    }

    /// The record, and the ranges of it that are padding.
    pub fn finish(self) -> (Vec<u8>, Vec<Range<usize>>) {
        (self.bytes, self.padding)
    }

    /// An error at the end of what is written.
    #[cold]
    pub fn error(&self, field: &'static str, kind: RecordErrorKind) -> RecordError {
        RecordError {
            id: self.id,
            offset: self.bytes.len(),
            field,
            kind,
        }
    }

    /// An error unless `holds`: two fields contradict each other.
    ///
    /// # Errors
    /// `Inconsistent(what)`.
    pub fn require(&self, holds: bool, field: &'static str, what: &'static str) -> Written {
        if holds {
            Ok(())
        } else {
            Err(self.error(field, RecordErrorKind::Inconsistent(what)))
        }
    }

    /// Bytes as they are.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// One byte.
    pub fn u8(&mut self, value: u8) {
        self.bytes.push(value);
    }

    /// A little-endian u16.
    pub fn u16(&mut self, value: u16) {
        self.bytes(&value.to_le_bytes());
    }

    /// A little-endian i16.
    pub fn i16(&mut self, value: i16) {
        self.bytes(&value.to_le_bytes());
    }

    /// A little-endian u32.
    pub fn u32(&mut self, value: u32) {
        self.bytes(&value.to_le_bytes());
    }

    /// A little-endian i32.
    pub fn i32(&mut self, value: i32) {
        self.bytes(&value.to_le_bytes());
    }

    /// A binary32 number, bits kept.
    pub fn f32(&mut self, value: f32) {
        self.bytes(&value.to_le_bytes());
    }

    /// A binary64 number, bits kept.
    pub fn f64(&mut self, value: f64) {
        self.bytes(&value.to_le_bytes());
    }

    /// A 32-bit boolean.
    pub fn bool32(&mut self, value: Bool32) {
        self.u32(value.0);
    }

    /// A colour.
    pub fn argb(&mut self, value: Argb) {
        self.u32(value.0);
    }

    /// Several binary32 numbers.
    pub fn f32s(&mut self, values: &[f32]) {
        for &value in values {
            self.f32(value);
        }
    }

    /// Several u16.
    pub fn u16s(&mut self, values: &[u16]) {
        for &value in values {
            self.u16(value);
        }
    }

    /// Several u32.
    pub fn u32s(&mut self, values: &[u32]) {
        for &value in values {
            self.u32(value);
        }
    }

    /// A pair of numbers.
    pub fn vec2(&mut self, value: Vec2) {
        self.f32s(&value.to_array());
    }

    /// A vector x, y, z.
    pub fn vec3(&mut self, value: Vec3) {
        self.f32s(&value.to_array());
    }

    /// A quaternion, stored w, x, y, z.
    pub fn quat(&mut self, value: Quat) {
        self.f32s(&[value.w, value.x, value.y, value.z]);
    }

    /// A frame.
    pub fn frame(&mut self, value: &Frame) {
        self.vec3(value.origin);
        self.quat(value.rotation);
    }

    /// A plane.
    pub fn plane(&mut self, value: &Plane) {
        self.vec3(value.normal);
        self.f32(value.d);
    }

    /// A sphere.
    pub fn sphere(&mut self, value: &Sphere) {
        self.vec3(value.center);
        self.f32(value.radius);
    }

    /// A cylsphere.
    pub fn cyl_sphere(&mut self, value: &CylSphere) {
        self.vec3(value.low_point);
        self.f32s(&[value.radius, value.height]);
    }

    /// A compressed u32 (P1), in `form` or, where that is too short for the value, in the shortest that will do.
    ///
    /// # Errors
    /// `TooMany` above 0x3FFF_FFFF.
    pub fn compressed_u32(&mut self, value: u32, form: CompressedForm, field: &'static str) -> Written {
        if value > CompressedForm::MAX_VALUE {
            let max = CompressedForm::MAX_VALUE as usize;
            return Err(self.error(
                field,
                RecordErrorKind::TooMany {
                    count: value as usize,
                    max,
                },
            ));
        }
        let [byte_0, byte_1, byte_2, byte_3] = value.to_le_bytes();
        match form.max(CompressedForm::shortest(value)) {
            CompressedForm::One => self.u8(byte_0),
            CompressedForm::Two => self.bytes(&[byte_1 | 0x80, byte_0]),
            CompressedForm::Four => self.bytes(&[byte_3 | 0xC0, byte_2, byte_0, byte_1]),
        }
        Ok(())
    }

    /// An id of known type (P2). The short form says offsets up to 0x7FFF, but a new id with an offset from 0x4000
    /// up should ask for the long form, as retail's own writers do; [`KnownTypeId`] says which was read.
    ///
    /// # Errors
    /// `BadValue` when the id is not within 0x3FFF_FFFF of `base`.
    pub fn known_type_id(&mut self, value: KnownTypeId, base: u32, field: &'static str) -> Written {
        let offset = value.id.wrapping_sub(base);
        if offset > CompressedForm::MAX_VALUE {
            return Err(self.error(
                field,
                RecordErrorKind::BadValue {
                    value: value.id,
                    expected: "an id of the field's type",
                },
            ));
        }
        let [byte_0, byte_1, byte_2, byte_3] = offset.to_le_bytes();
        if value.long_form || offset > 0x7FFF {
            self.bytes(&[byte_2, byte_3 | 0x80, byte_0, byte_1]);
        } else {
            self.bytes(&[byte_0, byte_1]);
        }
        Ok(())
    }

    /// A legacy string (P3) with its padding.
    ///
    /// # Errors
    /// `TooMany` when the length does not fit 32 bits.
    pub fn legacy_string(&mut self, value: &LegacyString, field: &'static str) -> Written {
        match u16::try_from(value.bytes.len()) {
            Ok(length) if length != u16::MAX && !value.long_form => self.u16(length),
            _ => {
                self.u16(u16::MAX);
                self.count32(value.bytes.len(), field)?;
            }
        }
        self.bytes(&value.bytes);
        self.align4();
        Ok(())
    }

    /// A PString of one-byte characters (P4).
    ///
    /// # Errors
    /// `TooMany` above 0x3FFF_FFFF characters.
    pub fn p_string(&mut self, value: &[u8], form: CompressedForm, field: &'static str) -> Written {
        self.count_compressed(value.len(), form, field)?;
        self.bytes(value);
        Ok(())
    }

    /// A PString of two-byte characters (P4).
    ///
    /// # Errors
    /// `TooMany` above 0x3FFF_FFFF characters.
    pub fn p_string_wide(&mut self, value: &[u16], form: CompressedForm, field: &'static str) -> Written {
        self.count_compressed(value.len(), form, field)?;
        self.u16s(value);
        Ok(())
    }

    /// An obfuscated string (P5) with its padding; `clear` is the plain text.
    ///
    /// # Errors
    /// `TooMany` above 65,535 bytes.
    pub fn obfuscated_string(&mut self, clear: &[u8], field: &'static str) -> Written {
        self.count16(clear.len(), field)?;
        self.bytes.extend(clear.iter().map(|byte| byte.rotate_left(4)));
        self.align4();
        Ok(())
    }

    /// Zero bytes up to the next multiple of 4 from the record's start (P6), remembered as padding.
    pub fn align4(&mut self) {
        self.pad(self.bytes.len().wrapping_neg() % 4);
    }

    /// `count` zero bytes, remembered as padding.
    pub fn pad(&mut self, count: usize) {
        if count != 0 {
            let start = self.bytes.len();
            self.bytes.resize(start + count, 0);
            self.padding.push(start..start + count);
        }
    }

    /// A count in one byte.
    ///
    /// # Errors
    /// `TooMany` above 255.
    pub fn count8(&mut self, count: usize, field: &'static str) -> Written {
        match u8::try_from(count) {
            Ok(value) => self.u8(value),
            Err(_) => return Err(self.too_many(count, u8::MAX as usize, field)),
        }
        Ok(())
    }

    /// A count in two bytes.
    ///
    /// # Errors
    /// `TooMany` above 65,535.
    pub fn count16(&mut self, count: usize, field: &'static str) -> Written {
        match u16::try_from(count) {
            Ok(value) => self.u16(value),
            Err(_) => return Err(self.too_many(count, u16::MAX as usize, field)),
        }
        Ok(())
    }

    /// A count in four bytes.
    ///
    /// # Errors
    /// `TooMany` above 4,294,967,295.
    pub fn count32(&mut self, count: usize, field: &'static str) -> Written {
        match u32::try_from(count) {
            Ok(value) => self.u32(value),
            Err(_) => return Err(self.too_many(count, u32::MAX as usize, field)),
        }
        Ok(())
    }

    /// A signed count in four bytes (D6).
    ///
    /// # Errors
    /// `TooMany` above 2,147,483,647.
    pub fn count_i32(&mut self, count: usize, field: &'static str) -> Written {
        match i32::try_from(count) {
            Ok(value) => self.i32(value),
            Err(_) => return Err(self.too_many(count, i32::MAX as usize, field)),
        }
        Ok(())
    }

    /// A compressed count (P7).
    ///
    /// # Errors
    /// `TooMany` above 0x3FFF_FFFF.
    pub fn count_compressed(&mut self, count: usize, form: CompressedForm, field: &'static str) -> Written {
        match u32::try_from(count) {
            Ok(value) => self.compressed_u32(value, form, field),
            Err(_) => Err(self.too_many(count, CompressedForm::MAX_VALUE as usize, field)),
        }
    }

    /// A packed hash table (P8), in the order given.
    ///
    /// # Errors
    /// `TooMany` above 65,535 entries.
    pub fn packed_hash_table(&mut self, table: &PackedHashTable, field: &'static str) -> Written {
        self.count16(table.entries.len(), field)?;
        self.u16(table.bucket_count);
        for &(key, value) in &table.entries {
            self.u32s(&[key, value]);
        }
        Ok(())
    }

    #[cold]
    fn too_many(&self, count: usize, max: usize, field: &'static str) -> RecordError {
        self.error(field, RecordErrorKind::TooMany { count, max })
    }
}
