//! The iteration record, `FFFF0001` (`dat-format.md` section 6).

/// Which patch iterations a file holds. The record holds no id.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct IterationList {
    /// How many iterations in all.
    pub total: i32,
    /// Runs of iterations that are present.
    pub runs: Vec<IterationRun>,
}

/// Iterations `start` to `start + |count| - 1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IterationRun {
    /// How many, negated: always below zero.
    pub count: i32,
    /// The first.
    pub start: i32,
}

impl IterationList {
    /// Data id of the record in every file.
    pub const ID: u32 = 0xFFFF_0001;

    /// The list of a complete file (V2). A `total` of zero or less has no run.
    pub fn complete(total: i32) -> Self {
        let runs = if total > 0 {
            vec![IterationRun {
                count: -total,
                start: 1,
            }]
        } else {
            Vec::new()
        };
        Self { total, runs }
    }

    /// Whether the file is completely patched (V2).
    pub fn is_complete(&self) -> bool {
        *self == Self::complete(self.total)
    }
}
