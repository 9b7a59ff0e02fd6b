//! Cases as they stand in the files.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use crate::open::OpenError;

/// One case of the vectors.
#[derive(Clone, Debug, Deserialize)]
pub struct Case {
    /// Name of the case.
    pub id: String,
    /// Folder under `worlds/` that it runs on.
    pub world: String,
    /// The operation.
    pub op: String,
    /// What it was made for; no input.
    #[serde(default)]
    pub tags: Vec<String>,
    /// Input, as the operation wants it.
    #[serde(rename = "in")]
    pub input: Value,
    /// Expected answer.
    pub expect: Value,
    /// The outcome hangs on the last bits of a float: run, but it does not decide.
    #[serde(default)]
    pub sensitive: bool,
    /// The expectation itself is doubted: run, but it does not decide.
    #[serde(default)]
    pub suspect: Option<Value>,
    /// File and line it comes from.
    #[serde(skip)]
    pub(crate) place: (PathBuf, usize),
}

impl Case {
    /// Whether it does not decide.
    pub fn is_flagged(&self) -> bool {
        self.sensitive || !matches!(self.suspect, None | Some(Value::Null | Value::Bool(false)))
    }

    pub(crate) fn bad(&self, source: serde_json::Error) -> ConformError {
        ConformError::Case {
            path: self.place.0.clone(),
            line: self.place.1,
            id: self.id.clone(),
            source,
        }
    }
}

/// Why vectors cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConformError {
    /// A file or the folder cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// What was read.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// A line is no case.
    #[error("line {line}, column {}: {source}, in {}", source.column(), path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// The input or expectation of a case has not the form of its operation.
    #[error("case {id}: {source}, in line {line} of {}", path.display())]
    Case {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Name of the case.
        id: String,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// A world that cases name cannot be opened.
    #[error("world {name}: {source}")]
    World {
        /// Its name.
        name: String,
        /// Why not.
        source: Box<OpenError>,
    },
}

/// Every case of the `*.jsonl` files of a folder, files in order of their names.
///
/// # Errors
/// A file cannot be read, or a line is no case.
pub fn read_folder(folder: &Path) -> Result<Vec<Case>, ConformError> {
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| ConformError::Io { path, source }
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io(folder))? {
        let path = entry.map_err(io(folder))?.path();
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("jsonl")) {
            files.push(path);
        }
    }
    files.sort();
    let mut cases = Vec::new();
    for path in files {
        let text = std::fs::read_to_string(&path).map_err(io(&path))?;
        for (line, text) in (1..)
            .zip(text.lines())
            .filter(|(_, text)| !text.trim().is_empty())
        {
            let mut case: Case = serde_json::from_str(text).map_err(|source| ConformError::Line {
                path: path.clone(),
                line,
                source,
            })?;
            case.place = (path.clone(), line);
            cases.push(case);
        }
    }
    Ok(cases)
}
