//! Makes and checks worlds.
#![forbid(unsafe_code)]

pub mod bsp;
pub mod geometry;
