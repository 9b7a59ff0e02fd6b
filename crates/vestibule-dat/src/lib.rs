#![doc = "Under construction."]

pub mod primitive;
pub mod record;
