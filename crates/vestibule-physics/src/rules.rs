//! Rules of `transition.md` one by one, by section.

mod body_and_tree;
mod edges;
mod insertion;
mod objects;
mod stepping;
mod validation;
