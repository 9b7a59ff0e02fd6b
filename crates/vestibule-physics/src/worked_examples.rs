//! The worked examples of `transition.md` 11, by number, and rules of the chapter that need a whole transition.

mod doorway_e1;
mod objects;
mod offset_adjustment;
mod path_clipped;
mod placement;
mod sliding;
mod spheres_and_cylinders;
mod stepping;
mod study_d16;
mod terrain;
