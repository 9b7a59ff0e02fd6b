//! `vestibule bench`: times the engine on known work.

mod all;
mod render;
mod sweep;
mod view;

use crate::ui::Context;

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
