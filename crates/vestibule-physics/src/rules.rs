//! Rules of `transition.md` one by one, by section.

mod edges;
