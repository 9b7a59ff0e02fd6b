//! The subcommands, one a file.

mod conform;

use crate::ui::Context;

#[derive(clap::Subcommand)]
pub(crate) enum Command {
    Conform(conform::Args),
}

impl Command {
    pub(crate) fn run(&self, context: &mut Context) -> anyhow::Result<()> {
        match self {
            Command::Conform(args) => conform::run(args, context),
        }
    }
}
