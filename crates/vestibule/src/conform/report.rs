//! What a run of vectors found.

use serde::Serialize;
use serde_json::Value;

use super::Case;

/// Differences kept in full for each operation.
const KEPT: usize = 10;

/// One field of an answer that is not as expected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldDifference {
    /// Name of the field.
    pub field: String,
    /// What the case expects.
    pub expected: Value,
    /// What came out.
    pub actual: Value,
}

/// A case that differs.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// Name of the case.
    pub id: String,
    /// World it ran on.
    pub world: String,
    /// What it was made for.
    pub tags: Vec<String>,
    /// Its input.
    #[serde(rename = "in")]
    pub input: Value,
    /// The fields that differ.
    pub fields: Vec<FieldDifference>,
}

/// Counts for one operation.
#[derive(Clone, Debug, Default, Serialize)]
pub struct OpReport {
    /// The operation.
    pub op: String,
    /// Cases that agree.
    pub agree: u64,
    /// Cases that differ.
    pub differ: u64,
    /// Cases marked sensitive or suspect, which do not decide.
    pub flagged: u64,
    /// Of the flagged ones, those that differ.
    pub flagged_differ: u64,
    /// Cases not run because the operation is not supported.
    pub unsupported: u64,
    /// The first ten differences.
    pub differences: Vec<Difference>,
}

/// The outcome of a run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// By operation.
    pub ops: Vec<OpReport>,
}

impl Report {
    /// Cases that agree, without the flagged ones.
    pub fn agree(&self) -> u64 {
        self.ops.iter().map(|op| op.agree).sum()
    }

    /// Cases that differ, without the flagged ones.
    pub fn differ(&self) -> u64 {
        self.ops.iter().map(|op| op.differ).sum()
    }

    /// Cases that decide: those that agree and those that differ.
    pub fn counted(&self) -> u64 {
        self.agree() + self.differ()
    }

    pub(super) fn of(&mut self, op: &str) -> &mut OpReport {
        let at = self
            .ops
            .iter()
            .position(|known| known.op == op)
            .unwrap_or_else(|| {
                self.ops.push(OpReport {
                    op: op.to_owned(),
                    ..OpReport::default()
                });
                self.ops.len() - 1
            });
        &mut self.ops[at]
    }

    pub(super) fn count(&mut self, case: &Case, fields: Vec<FieldDifference>) {
        let flagged = case.is_flagged();
        let op = self.of(&case.op);
        op.flagged += u64::from(flagged);
        if fields.is_empty() {
            op.agree += u64::from(!flagged);
            return;
        }
        if flagged {
            op.flagged_differ += 1;
            return;
        }
        op.differ += 1;
        if op.differences.len() < KEPT {
            op.differences.push(Difference {
                id: case.id.clone(),
                world: case.world.clone(),
                tags: case.tags.clone(),
                input: case.input.clone(),
                fields,
            });
        }
    }

    pub(super) fn sort_by(&mut self, position: impl Fn(&str) -> Option<usize>) {
        self.ops
            .sort_by_key(|op| (position(&op.op).unwrap_or(usize::MAX), op.op.clone()));
    }
}
