//! `vestibule bench`: times the engine on known work.

mod sweep;
mod view;

use crate::ui::Context;

/// Time sweeps and portal traversals
#[derive(clap::Subcommand)]
pub(crate) enum Command {
    Sweep(sweep::Args),
    View(view::Args),
}

impl Command {
    pub(crate) fn run(&self, context: &mut Context) -> anyhow::Result<()> {
        match self {
            Command::Sweep(args) => sweep::run(args, context),
            Command::View(args) => view::run(args, context),
        }
    }
}
