//! `vestibule dat`: the files themselves.

mod diff;
mod extract;
mod verify;

use crate::ui::Context;

/// Verify, compare and take apart DAT files
#[derive(clap::Subcommand)]
pub(crate) enum Command {
    Verify(verify::Args),
    Diff(diff::Args),
    Extract(extract::Args),
}

impl Command {
    pub(crate) fn run(&self, context: &mut Context) -> anyhow::Result<()> {
        match self {
            Command::Verify(args) => verify::run(args, context),
            Command::Diff(args) => diff::run(args, context),
            Command::Extract(args) => extract::run(args, context),
        }
    }
}
