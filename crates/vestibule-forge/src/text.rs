//! The scene text: words, statements and messages that point into it. What the statements mean is in
//! `scene`; the whole language is described in `docs/scenes.md`.

mod args;
mod diagnostic;
mod lexer;
mod statement;

pub(crate) use args::{Args, Skip};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub(crate) use diagnostic::{Messages, closest};
pub(crate) use lexer::{Above, Span, Value};
pub(crate) use statement::{Statement, Word, parse};
