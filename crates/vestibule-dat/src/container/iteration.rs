//! The iteration record (`dat-format.md` 6).

use crate::error::{ErrorKind, Fault};

/// Id of the iteration record, in every file (F4).
pub const ITERATION_ID: u32 = 0xFFFF_0001;

/// Which patch iterations a file holds (V1).
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IterationRecord {
    /// Number of iterations present.
    pub total: i32,
    /// Runs of iterations that are present, as (first, how many).
    pub runs: Vec<(i32, i32)>,
}

impl IterationRecord {
    /// The record of a file that is complete up to `total` (V2).
    pub fn complete(total: i32) -> IterationRecord {
        IterationRecord {
            total,
            runs: vec![(1, total)],
        }
    }

    /// Whether the file has every iteration from 1 to `total` in one run (V2), or none at all.
    pub fn is_complete(&self) -> bool {
        matches!(self.runs[..], [(1, n)] if n == self.total) || (self.total == 0 && self.runs.is_empty())
    }

    /// Reads the record; anything but the shape of V1 is an error of this record only (V3).
    ///
    /// # Errors
    /// An [`ErrorKind::Iteration`] and the field with its offset in the record.
    pub(crate) fn parse_fault(b: &[u8]) -> Result<IterationRecord, Fault> {
        let at = |offset: usize, field, why| Fault::at(offset as u64, field, ErrorKind::Iteration(why));
        let word = |offset: usize, field| match b.get(offset..offset + 4) {
            Some(w) => Ok(i32::from_le_bytes([w[0], w[1], w[2], w[3]])),
            None => Err(at(offset, field, "it ends early")),
        };
        let total = word(0, "total")?;
        if total < 0 {
            return Err(at(0, "total", "the total is negative"));
        }
        let mut runs = Vec::new();
        let (mut sum, mut offset) = (0i64, 4);
        while sum < i64::from(total) {
            let n = word(offset, "n")?;
            let start = word(offset + 4, "start")?;
            if n >= 0 {
                return Err(at(offset, "n", "a run must be negative"));
            }
            sum += i64::from(n).abs();
            if sum > i64::from(total) {
                return Err(at(offset, "n", "the runs pass the total"));
            }
            // n is negative and its magnitude at most the total, so it can be turned round.
            runs.push((start, -n));
            offset += 8;
        }
        if offset != b.len() {
            return Err(at(offset, "n", "bytes are left over"));
        }
        Ok(IterationRecord { total, runs })
    }

    /// Reads the record; `None` if it has another shape than V1 (V3).
    pub fn parse(b: &[u8]) -> Option<IterationRecord> {
        IterationRecord::parse_fault(b).ok()
    }

    /// The bytes of the record.
    pub fn bytes(&self) -> Vec<u8> {
        let mut out = self.total.to_le_bytes().to_vec();
        for (start, n) in &self.runs {
            out.extend_from_slice(&n.wrapping_neg().to_le_bytes());
            out.extend_from_slice(&start.to_le_bytes());
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn example_12_7_complete() {
        let b = [0xD6, 3, 0, 0, 0x2A, 0xFC, 0xFF, 0xFF, 1, 0, 0, 0];
        let r = IterationRecord::parse(&b).unwrap();
        assert_eq!(r, IterationRecord::complete(982));
        assert!(r.is_complete());
        assert_eq!(r.bytes(), b);
    }

    #[test]
    fn example_12_7_with_a_gap() {
        let b = [
            0x0C, 0, 0, 0, 0xF6, 0xFF, 0xFF, 0xFF, 1, 0, 0, 0, 0xFE, 0xFF, 0xFF, 0xFF, 0x0F, 0, 0, 0,
        ];
        let r = IterationRecord::parse(&b).unwrap();
        assert_eq!(
            r,
            IterationRecord {
                total: 12,
                runs: vec![(1, 10), (15, 2)]
            }
        );
        assert!(
            !r.is_complete(),
            "V2: more pairs are an incompletely patched file"
        );
        assert_eq!(r.bytes(), b);
    }

    #[test]
    fn v3_other_shapes() {
        let words = |w: &[i32]| w.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<_>>();
        assert!(
            IterationRecord::parse(&words(&[0])).is_some(),
            "no iterations, no pairs"
        );
        let bad: [&[i32]; 8] = [
            &[],
            &[5],
            &[5, 5, 1],
            &[5, -6, 1],
            &[5, -5, 1, 0],
            &[0, -1, 1],
            &[-1],
            &[5, 0, 1, -5, 1],
        ];
        for bad in bad {
            assert!(IterationRecord::parse(&words(bad)).is_none(), "{bad:?}");
        }
        assert!(IterationRecord::parse(&words(&[i32::MAX, i32::MIN, 1])).is_none());
    }
}
