//! Reading.

use glam::{Quat, Vec2, Vec3};

use super::{
    Argb, Bool32, CompressedForm, CylSphere, Frame, KnownTypeId, LegacyString, PackedHashTable, Plane, Sphere,
};
use crate::record::{RecordError, RecordErrorKind};

/// A cursor over the bytes of one record.
///
/// Every method takes the name of the field it reads, so that an error names record, offset and field. Nothing is
/// allocated before it is known that the record has the bytes for it (D1).
///
/// ```
/// use vestibule_dat::primitive::Reader;
///
/// let mut reader = Reader::new(0x0400_0001, &[0x92, 0x34, 0xFF]);
/// assert_eq!(reader.compressed_u32("count")?.0, 0x1234);
/// let error = reader.u32("color").unwrap_err();
/// assert_eq!((error.id, error.offset, error.field), (0x0400_0001, 2, "color"));
/// # Ok::<(), vestibule_dat::record::RecordError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    position: usize,
    id: u32,
}

type Read<T> = Result<T, RecordError>;

impl<'a> Reader<'a> {
    /// A cursor at the start of record `id`.
    pub fn new(id: u32, bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            position: 0,
            id,
        }
    }

    /// Data id of the record, for errors.
    #[inline]
    pub fn id(&self) -> u32 {
        self.id
    }

    /// Byte offset of the cursor from the record's start.
    #[inline]
    pub fn position(&self) -> usize {
        self.position
    }

    /// Bytes not read yet.
    #[inline]
    pub fn left(&self) -> usize {
        self.bytes.len() - self.position
    }

    /// An error at the cursor.
    #[cold]
    pub fn error(&self, field: &'static str, kind: RecordErrorKind) -> RecordError {
        self.error_at(self.position, field, kind)
    }

    /// An error at `offset`, for a field that was already read.
    #[cold]
    pub fn error_at(&self, offset: usize, field: &'static str, kind: RecordErrorKind) -> RecordError {
        RecordError {
            id: self.id,
            offset,
            field,
            kind,
        }
    }

    #[cold]
    fn truncated(&self, wanted: usize, field: &'static str) -> RecordError {
        self.error(
            field,
            RecordErrorKind::Truncated {
                wanted,
                left: self.left(),
            },
        )
    }

    /// The next `count` bytes.
    ///
    /// # Errors
    /// `Truncated` when fewer are left. The same holds for every other reading method.
    #[inline]
    pub fn take(&mut self, count: usize, field: &'static str) -> Read<&'a [u8]> {
        match self.bytes.get(self.position..).and_then(|rest| rest.get(..count)) {
            Some(taken) => {
                self.position += count;
                Ok(taken)
            }
            None => Err(self.truncated(count, field)),
        }
    }

    /// The next `N` bytes as an array.
    #[inline]
    pub fn array<const N: usize>(&mut self, field: &'static str) -> Read<[u8; N]> {
        match self
            .bytes
            .get(self.position..)
            .and_then(|rest| rest.first_chunk::<N>())
        {
            Some(taken) => {
                self.position += N;
                Ok(*taken)
            }
            None => Err(self.truncated(N, field)),
        }
    }

    /// One byte.
    #[inline]
    pub fn u8(&mut self, field: &'static str) -> Read<u8> {
        Ok(self.array::<1>(field)?[0])
    }

    /// A little-endian u16.
    #[inline]
    pub fn u16(&mut self, field: &'static str) -> Read<u16> {
        Ok(u16::from_le_bytes(self.array(field)?))
    }

    /// A little-endian i16.
    #[inline]
    pub fn i16(&mut self, field: &'static str) -> Read<i16> {
        Ok(i16::from_le_bytes(self.array(field)?))
    }

    /// A little-endian u32.
    #[inline]
    pub fn u32(&mut self, field: &'static str) -> Read<u32> {
        Ok(u32::from_le_bytes(self.array(field)?))
    }

    /// A little-endian i32.
    #[inline]
    pub fn i32(&mut self, field: &'static str) -> Read<i32> {
        Ok(i32::from_le_bytes(self.array(field)?))
    }

    /// A binary32 number, bits kept.
    #[inline]
    pub fn f32(&mut self, field: &'static str) -> Read<f32> {
        Ok(f32::from_le_bytes(self.array(field)?))
    }

    /// A binary64 number, bits kept; it need not be aligned (X9).
    #[inline]
    pub fn f64(&mut self, field: &'static str) -> Read<f64> {
        Ok(f64::from_le_bytes(self.array(field)?))
    }

    /// A 32-bit boolean, kept as its word.
    #[inline]
    pub fn bool32(&mut self, field: &'static str) -> Read<Bool32> {
        Ok(Bool32(self.u32(field)?))
    }

    /// A colour.
    #[inline]
    pub fn argb(&mut self, field: &'static str) -> Read<Argb> {
        Ok(Argb(self.u32(field)?))
    }

    /// `N` binary32 numbers.
    #[inline]
    pub fn f32s<const N: usize>(&mut self, field: &'static str) -> Read<[f32; N]> {
        let (words, _) = self.take(4 * N, field)?.as_chunks::<4>();
        let mut values = [0.0; N];
        for (value, word) in values.iter_mut().zip(words) {
            *value = f32::from_le_bytes(*word);
        }
        Ok(values)
    }

    /// A pair of numbers.
    #[inline]
    pub fn vec2(&mut self, field: &'static str) -> Read<Vec2> {
        Ok(Vec2::from_array(self.f32s(field)?))
    }

    /// A vector x, y, z.
    #[inline]
    pub fn vec3(&mut self, field: &'static str) -> Read<Vec3> {
        Ok(Vec3::from_array(self.f32s(field)?))
    }

    /// A quaternion, stored w, x, y, z.
    #[inline]
    pub fn quat(&mut self, field: &'static str) -> Read<Quat> {
        let [w, x, y, z] = self.f32s(field)?;
        Ok(Quat::from_xyzw(x, y, z, w))
    }

    /// A frame: origin, then orientation, 28 bytes.
    #[inline]
    pub fn frame(&mut self, field: &'static str) -> Read<Frame> {
        Ok(Frame {
            origin: self.vec3(field)?,
            rotation: self.quat(field)?,
        })
    }

    /// A plane, 16 bytes.
    #[inline]
    pub fn plane(&mut self, field: &'static str) -> Read<Plane> {
        Ok(Plane {
            normal: self.vec3(field)?,
            d: self.f32(field)?,
        })
    }

    /// A sphere, 16 bytes.
    #[inline]
    pub fn sphere(&mut self, field: &'static str) -> Read<Sphere> {
        Ok(Sphere {
            center: self.vec3(field)?,
            radius: self.f32(field)?,
        })
    }

    /// A cylsphere, 20 bytes.
    #[inline]
    pub fn cyl_sphere(&mut self, field: &'static str) -> Read<CylSphere> {
        Ok(CylSphere {
            low_point: self.vec3(field)?,
            radius: self.f32(field)?,
            height: self.f32(field)?,
        })
    }

    /// A compressed u32 (P1) and the form it was spelled in.
    pub fn compressed_u32(&mut self, field: &'static str) -> Read<(u32, CompressedForm)> {
        match self.bytes.get(self.position).copied().unwrap_or(0) {
            0x00..=0x7F => Ok((u32::from(self.u8(field)?), CompressedForm::One)),
            0x80..=0xBF => {
                let [high, low] = self.array(field)?;
                Ok((u32::from(high & 0x7F) << 8 | u32::from(low), CompressedForm::Two))
            }
            0xC0..=0xFF => {
                let [top, high, low_0, low_1] = self.array(field)?;
                let high = u32::from(top & 0x3F) << 8 | u32::from(high);
                Ok((
                    high << 16 | u32::from(u16::from_le_bytes([low_0, low_1])),
                    CompressedForm::Four,
                ))
            }
        }
    }

    /// An id of known type (P2); `base` is the type's first id.
    pub fn known_type_id(&mut self, base: u32, field: &'static str) -> Read<KnownTypeId> {
        let short = self.u16(field)?;
        if short & 0x8000 == 0 {
            return Ok(KnownTypeId {
                id: base.wrapping_add(u32::from(short)),
                long_form: false,
            });
        }
        let offset = u32::from(short & 0x3FFF) << 16 | u32::from(self.u16(field)?);
        Ok(KnownTypeId {
            id: base.wrapping_add(offset),
            long_form: true,
        })
    }

    /// A legacy string (P3) with its padding.
    pub fn legacy_string(&mut self, field: &'static str) -> Read<LegacyString> {
        let short = self.u16(field)?;
        let long_form = short == u16::MAX;
        let length = if long_form {
            self.u32(field)?
        } else {
            u32::from(short)
        };
        let length = self.check_count(u64::from(length), 1, field)?;
        let bytes = self.take(length, field)?.to_vec();
        self.align4(field)?;
        Ok(LegacyString { bytes, long_form })
    }

    /// A PString of one-byte characters (P4): the bytes and the form of the length.
    pub fn p_string(&mut self, field: &'static str) -> Read<(Vec<u8>, CompressedForm)> {
        let (length, form) = self.compressed_u32(field)?;
        let length = self.check_count(u64::from(length), 1, field)?;
        Ok((self.take(length, field)?.to_vec(), form))
    }

    /// A PString of two-byte characters (P4): the code units and the form of the length.
    pub fn p_string_wide(&mut self, field: &'static str) -> Read<(Vec<u16>, CompressedForm)> {
        let (length, form) = self.compressed_u32(field)?;
        let length = self.check_count(u64::from(length), 2, field)?;
        Ok((self.u16s(length, field)?, form))
    }

    /// An obfuscated string (P5) with its padding, in clear.
    pub fn obfuscated_string(&mut self, field: &'static str) -> Read<Vec<u8>> {
        let length = usize::from(self.u16(field)?);
        let bytes = self
            .take(length, field)?
            .iter()
            .map(|byte| byte.rotate_left(4))
            .collect();
        self.align4(field)?;
        Ok(bytes)
    }

    /// Skips to the next multiple of 4 from the record's start (P6). The padding is not looked at.
    pub fn align4(&mut self, field: &'static str) -> Read<()> {
        self.take(self.position.wrapping_neg() % 4, field).map(drop)
    }

    /// `count` little-endian u16.
    #[inline]
    pub fn u16s(&mut self, count: usize, field: &'static str) -> Read<Vec<u16>> {
        let wanted = count.saturating_mul(2);
        Ok(self
            .take(wanted, field)?
            .as_chunks()
            .0
            .iter()
            .map(|&word| u16::from_le_bytes(word))
            .collect())
    }

    /// `count` little-endian u32.
    #[inline]
    pub fn u32s(&mut self, count: usize, field: &'static str) -> Read<Vec<u32>> {
        let wanted = count.saturating_mul(4);
        Ok(self
            .take(wanted, field)?
            .as_chunks()
            .0
            .iter()
            .map(|&word| u32::from_le_bytes(word))
            .collect())
    }

    /// Checks a count just read against the bytes left, given that each item takes at least `min_size` bytes (D1).
    ///
    /// # Errors
    /// `CountTooLarge`.
    #[inline]
    pub fn check_count(&self, count: u64, min_size: usize, field: &'static str) -> Read<usize> {
        let needed = count.saturating_mul(min_size as u64);
        match usize::try_from(count) {
            Ok(items) if needed <= self.left() as u64 => Ok(items),
            _ => Err(self.error(
                field,
                RecordErrorKind::CountTooLarge {
                    count,
                    needed,
                    left: self.left(),
                },
            )),
        }
    }

    /// A u32 count (P7), checked like [`check_count`](Self::check_count).
    #[inline]
    pub fn count32(&mut self, min_size: usize, field: &'static str) -> Read<usize> {
        let count = self.u32(field)?;
        self.check_count(u64::from(count), min_size, field)
    }

    /// A compressed count (P7) with its spelling.
    #[inline]
    pub fn count_compressed(
        &mut self,
        min_size: usize,
        field: &'static str,
    ) -> Read<(usize, CompressedForm)> {
        let (count, form) = self.compressed_u32(field)?;
        Ok((self.check_count(u64::from(count), min_size, field)?, form))
    }

    /// An i32 count, which must not be negative (D6).
    #[inline]
    pub fn count_i32(&mut self, min_size: usize, field: &'static str) -> Read<usize> {
        let start = self.position;
        let count = self.i32(field)?;
        match u64::try_from(count) {
            Ok(count) => self.check_count(count, min_size, field),
            Err(_) => Err(self.error_at(start, field, RecordErrorKind::NegativeCount(count))),
        }
    }

    /// `count` items, each read by `read`. The count must have been checked.
    #[inline]
    pub fn items<T>(&mut self, count: usize, mut read: impl FnMut(&mut Self) -> Read<T>) -> Read<Vec<T>> {
        let mut items = Vec::with_capacity(count);
        for _ in 0..count {
            items.push(read(self)?);
        }
        Ok(items)
    }

    /// A list32 (P7): a count, then the items, none smaller than `min_size` bytes.
    #[inline]
    pub fn list32<T>(
        &mut self,
        min_size: usize,
        field: &'static str,
        read: impl FnMut(&mut Self) -> Read<T>,
    ) -> Read<Vec<T>> {
        let count = self.count32(min_size, field)?;
        self.items(count, read)
    }

    /// A list with an i32 count (D6).
    #[inline]
    pub fn list_i32<T>(
        &mut self,
        min_size: usize,
        field: &'static str,
        read: impl FnMut(&mut Self) -> Read<T>,
    ) -> Read<Vec<T>> {
        let count = self.count_i32(min_size, field)?;
        self.items(count, read)
    }

    /// A packed hash table of u32 to u32 (P8).
    pub fn packed_hash_table(&mut self, field: &'static str) -> Read<PackedHashTable> {
        let count = u64::from(self.u16(field)?);
        let bucket_count = self.u16(field)?;
        let count = self.check_count(count, 8, field)?;
        let entries = self.items(count, |reader| Ok((reader.u32(field)?, reader.u32(field)?)))?;
        Ok(PackedHashTable {
            bucket_count,
            entries,
        })
    }

    /// Checks that nothing is left (F6).
    ///
    /// # Errors
    /// `TrailingBytes`.
    pub fn finish(self) -> Read<()> {
        match self.left() {
            0 => Ok(()),
            left => Err(self.error("end of record", RecordErrorKind::TrailingBytes { left })),
        }
    }
}
