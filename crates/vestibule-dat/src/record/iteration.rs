//! The iteration record, `FFFF0001` (`dat-format.md` section 6). It holds no id.

use super::{DatRecord, RecordError, RecordErrorKind};
use crate::container::IterationRecord;
use crate::primitive::{Reader, Writer};

impl DatRecord for IterationRecord {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let start = reader.position();
        let total = reader.i32("total")?;
        if total < 0 {
            return Err(reader.error_at(start, "total", RecordErrorKind::NegativeCount(total)));
        }
        let mut missing = total;
        let mut runs = Vec::new();
        while missing != 0 {
            let at = reader.position();
            let negated = reader.i32("run.n")?;
            let start = reader.i32("run.start")?;
            match negated.checked_neg() {
                Some(count) if count > 0 && count <= missing => {
                    missing -= count;
                    runs.push((start, count));
                }
                _ => {
                    let expected = "a negated count within the total";
                    let kind = RecordErrorKind::BadValue {
                        value: negated as u32,
                        expected,
                    };
                    return Err(reader.error_at(at, "run.n", kind));
                }
            }
        }
        Ok(Self { total, runs })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        let counts = self.runs.iter().map(|run| i64::from(run.1));
        let sound = counts.clone().all(|count| count > 0) && counts.sum::<i64>() == i64::from(self.total);
        writer.require(
            sound,
            "total",
            "the runs' counts are above zero and add up to the total",
        )?;
        writer.bytes(&self.bytes());
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        None
    }
}
