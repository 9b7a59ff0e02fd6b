//! The world that is built in.

use crate::compile::{CompiledWorld, compile};
use crate::text::Diagnostics;

/// The scene files of the built-in world, in the order in which they are read.
pub const EMBEDDED_SCENE: [(&str, &str); 4] = [
    (
        "worlds/hollow/1-land.scene",
        include_str!("../worlds/hollow/1-land.scene"),
    ),
    (
        "worlds/hollow/2-things.scene",
        include_str!("../worlds/hollow/2-things.scene"),
    ),
    (
        "worlds/hollow/3-village.scene",
        include_str!("../worlds/hollow/3-village.scene"),
    ),
    (
        "worlds/hollow/4-mine.scene",
        include_str!("../worlds/hollow/4-mine.scene"),
    ),
];

/// Compiles the built-in world, "Hollow": a valley of nine landblocks with a village, a mine and a dungeon, made so
/// that everything that goes wrong in clients is in it once. Takes a few hundredths of a second.
///
/// # Errors
/// Never, as long as the scene that this crate was built with is right; a test compiles it.
pub fn embedded_world() -> Result<CompiledWorld, Diagnostics> {
    compile(&EMBEDDED_SCENE)
}
