//! `vestibule bench`: times the engine on known work.

mod all;
mod render;
mod sweep;
mod view;

use std::path::{Path, PathBuf};

use crate::ui::{Context, hinted};

/// The DAT files of a world of the vectors.
fn vectors_world(vectors: &Path, name: &str) -> anyhow::Result<PathBuf> {
    let folder = vectors.join("worlds").join(name);
    if folder.is_dir() {
        return Ok(folder);
    }
    let hint = "--vectors takes the folder of the test vectors, which has a folder worlds/ with a folder for each world";
    Err(hinted(
        anyhow::anyhow!("there is no world {name} in {}", vectors.display()),
        hint,
    ))
}

/// Time sweeps, traversals and pictures, or measure every figure at once
#[derive(clap::Subcommand)]
pub(crate) enum Command {
    All(all::Args),
    Sweep(sweep::Args),
    View(view::Args),
    Render(render::Args),
}

impl Command {
    pub(crate) fn run(&self, context: &mut Context) -> anyhow::Result<()> {
        match self {
            Command::All(args) => all::run(args, context),
            Command::Sweep(args) => sweep::run(args, context),
            Command::View(args) => view::run(args, context),
            Command::Render(args) => render::run(args, context),
        }
    }
}
