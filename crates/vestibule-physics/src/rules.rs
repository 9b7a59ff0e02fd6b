//! Rules of `transition.md` one by one, by section.

mod edges;
mod insertion;
mod stepping;
