//! What loading needs and threads share: the record source, the Region, compiled assets and the problems met.

use std::sync::{Mutex, PoisonError};

use vestibule_dat::record;

use crate::assets::Assets;
use crate::error::{LoadProblem, ProblemKind};
use crate::region::Region;
use crate::source::{RecordSource, Store};

/// At most this many load problems are kept; more are counted.
const MAX_KEPT_PROBLEMS: usize = 10_000;

/// The records of a world with what is compiled from them and shared.
pub(crate) struct Records {
    pub(crate) source: Box<dyn RecordSource>,
    pub(crate) region: Region,
    pub(crate) assets: Assets,
    /// Nothing compiled from them holds hints.
    pub(crate) exact: bool,
    problems: Mutex<Problems>,
}

#[derive(Default)]
struct Problems {
    kept: Vec<LoadProblem>,
    dropped: usize,
}

impl Records {
    pub(crate) fn new(source: Box<dyn RecordSource>, region: Region, exact: bool) -> Self {
        Records {
            source,
            region,
            assets: Assets::default(),
            exact,
            problems: Mutex::default(),
        }
    }

    /// The bytes of a record are there, or were damaged.
    pub(crate) fn is_absent(&self, store: Store, id: u32) -> bool {
        matches!(self.source.record(store, id), Ok(None))
    }

    /// Reads and parses a record that `needed_by` refers to; problems are reported and answer `None`.
    pub(crate) fn parse<T>(
        &self,
        store: Store,
        id: u32,
        needed_by: u32,
        parse: impl FnOnce(u32, &[u8]) -> Result<T, record::RecordError>,
    ) -> Option<T> {
        let kind = match self.source.record(store, id) {
            Ok(Some(bytes)) => match parse(id, &bytes) {
                Ok(record) => return Some(record),
                Err(e) => ProblemKind::Unreadable(e.to_string()),
            },
            Ok(None) => ProblemKind::Missing { needed_by },
            Err(e) => ProblemKind::Unreadable(e.to_string()),
        };
        self.report_in(store, id, kind);
        None
    }

    /// Keeps a problem with a record.
    pub(crate) fn report_in(&self, store: Store, id: u32, kind: ProblemKind) {
        let file = self.source.file_of(store, id);
        let mut problems = self.problems.lock().unwrap_or_else(PoisonError::into_inner);
        if problems.kept.len() < MAX_KEPT_PROBLEMS {
            problems.kept.push(LoadProblem { file, id, kind });
        } else {
            problems.dropped += 1;
        }
    }

    pub(crate) fn problems(&self) -> Vec<LoadProblem> {
        self.problems
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .kept
            .clone()
    }

    pub(crate) fn problem_count(&self) -> usize {
        let problems = self.problems.lock().unwrap_or_else(PoisonError::into_inner);
        problems.kept.len() + problems.dropped
    }
}
