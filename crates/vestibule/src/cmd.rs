//! The subcommands, one a file.

mod bench;
mod build;
mod conform;
mod dat;
#[cfg_attr(not(feature = "explore"), path = "cmd/no_explore.rs")]
mod explore;
#[cfg(feature = "explore")]
mod explore_trail;
#[cfg_attr(not(feature = "explore"), path = "cmd/no_gpu.rs")]
mod gpu;
mod gpu_cost;
mod id;
mod inspect;
mod ls;
mod map;
mod place;
mod refs;
mod render;
mod replay;
mod tour;
mod visible;
mod walk;
mod wheres;

use std::io::Write as _;
use std::path::Path;

use crate::ui::Context;

#[derive(clap::Subcommand)]
pub(crate) enum Command {
    Tour(tour::Args),
    Where(wheres::Args),
    Inspect(inspect::Args),
    Ls(ls::Args),
    Refs(refs::Args),
    Visible(visible::Args),
    Render(render::Args),
    Explore(explore::Args),
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
            Command::Render(args) => render::run(args, context),
            Command::Explore(args) => explore::run(args, context),
            Command::Bench(command) => command.run(context),
            Command::Walk(args) => walk::run(args, context),
            Command::Replay(args) => replay::run(args, context),
            Command::Map(args) => map::run(args, context),
            Command::Dat(command) => command.run(context),
            Command::Conform(args) => conform::run(args, context),
        }
    }
}

/// Writes a file as a whole or not at all: under another name first, then renamed.
fn write_whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let write = || {
        let mut file = std::fs::File::create(&part)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        std::fs::rename(&part, path)
    };
    write().inspect_err(|_| {
        let _ = std::fs::remove_file(&part);
    })
}
