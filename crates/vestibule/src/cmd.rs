//! The subcommands, one a file.

mod bench;
mod build;
mod conform;
mod dat;
mod id;
mod inspect;
mod ls;
mod map;
mod place;
mod refs;
mod replay;
mod tour;
mod visible;
mod walk;
mod wheres;

use crate::ui::Context;

#[derive(clap::Subcommand)]
pub(crate) enum Command {
    Tour(tour::Args),
    Where(wheres::Args),
    Inspect(inspect::Args),
    Ls(ls::Args),
    Refs(refs::Args),
    Visible(visible::Args),
    Walk(walk::Args),
    Replay(replay::Args),
    Map(map::Args),
    Build(build::Args),
    #[command(subcommand)]
    Dat(dat::Command),
    Conform(conform::Args),
    #[command(subcommand)]
    Bench(bench::Command),
}

impl Command {
    pub(crate) fn run(&self, context: &mut Context) -> anyhow::Result<()> {
        match self {
            Command::Tour(args) => tour::run(args, context),
            Command::Where(args) => wheres::run(args, context),
            Command::Inspect(args) => inspect::run(args, context),
            Command::Ls(args) => ls::run(args, context),
            Command::Refs(args) => refs::run(args, context),
            Command::Build(args) => build::run(args, context),
            Command::Visible(args) => visible::run(args, context),
            Command::Bench(command) => command.run(context),
            Command::Walk(args) => walk::run(args, context),
            Command::Replay(args) => replay::run(args, context),
            Command::Map(args) => map::run(args, context),
            Command::Dat(command) => command.run(context),
            Command::Conform(args) => conform::run(args, context),
        }
    }
}
