//! Makes and checks worlds.
#![forbid(unsafe_code)]

pub mod bsp;
pub mod geometry;
mod scene;
mod text;
mod compile;
pub mod visibility;

pub use compile::{CompileStats, CompiledWorld};
pub use text::{Diagnostic, Diagnostics, Severity};

/// Compiles the text of a scene; `name` is the file's name for messages.
///
/// # Errors
/// When the scene has errors; warnings come with the compiled world.
pub fn compile_scene(name: &str, text: &str) -> Result<CompiledWorld, Diagnostics> {
    compile::compile(&[(name, text)])
}
