//! Messages about a scene: what is wrong, where, and how to mend it.

use core::fmt;

use super::Span;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The world can be built, but something in it is probably not meant.
    Warning,
    /// No world comes out.
    Error,
}

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// Name of the scene file.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// What is wrong.
    pub message: String,
    /// How to mend it.
    pub help: String,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        let Diagnostic {
            file,
            line,
            column,
            message,
            help,
            ..
        } = self;
        write!(f, "{file}:{line}:{column}: {severity}: {message}\n  help: {help}")
    }
}

/// The messages of a compilation that failed, in order of their places in the text.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, diagnostic) in self.0.iter().enumerate() {
            if k > 0 {
                writeln!(f)?;
            }
            diagnostic.fmt(f)?;
        }
        Ok(())
    }
}

impl core::error::Error for Diagnostics {}

/// Messages as they are collected.
#[derive(Clone, Debug, Default)]
pub(crate) struct Messages {
    files: Vec<String>,
    found: Vec<(Span, Diagnostic)>,
}

impl Messages {
    pub(crate) fn new(files: Vec<String>) -> Self {
        Messages {
            files,
            found: Vec::new(),
        }
    }

    fn add(&mut self, severity: Severity, span: Span, message: String, help: String) {
        let file = self
            .files
            .get(usize::from(span.file))
            .cloned()
            .unwrap_or_default();
        let Span { line, column, .. } = span;
        let diagnostic = Diagnostic {
            severity,
            file,
            line,
            column,
            message,
            help,
        };
        if !self.found.iter().any(|(_, d)| *d == diagnostic) {
            self.found.push((span, diagnostic));
        }
    }

    pub(crate) fn error(&mut self, span: Span, message: impl Into<String>, help: impl Into<String>) {
        self.add(Severity::Error, span, message.into(), help.into());
    }

    pub(crate) fn warning(&mut self, span: Span, message: impl Into<String>, help: impl Into<String>) {
        self.add(Severity::Warning, span, message.into(), help.into());
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.found.iter().any(|(_, d)| d.severity == Severity::Error)
    }

    /// In the order of the text.
    pub(crate) fn finish(mut self) -> Vec<Diagnostic> {
        self.found.sort_by_key(|(span, _)| *span);
        self.found.into_iter().map(|(_, d)| d).collect()
    }
}

/// The one of `known` that `text` was probably meant to be.
pub(crate) fn closest<'a>(text: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = text.chars().count() / 3 + 1;
    let scored = known
        .into_iter()
        .map(|k| (edit_distance(text, k), k))
        .min_by_key(|(d, _)| *d)?;
    (scored.0 <= limit).then_some(scored.1)
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let cost = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = cost.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
