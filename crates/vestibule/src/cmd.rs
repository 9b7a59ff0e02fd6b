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

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use anyhow::Context as _;

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

/// Writes a file as a whole or not at all.
fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_whole_by(path, |file| file.write_all(bytes))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// As [`write_whole`], piece by piece: under another name first, then renamed.
fn write_whole_by(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        // A device or a pipe is written to, not replaced.
        let mut file = BufWriter::new(File::create(path)?);
        fill(&mut file)?;
        return file.flush();
    }
    // Of a link it is the file it names that is replaced.
    let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut name = place.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = place.with_file_name(name);
    let write = || {
        let mut file = BufWriter::new(File::create(&part)?);
        fill(&mut file)?;
        let file = file.into_inner().map_err(std::io::IntoInnerError::into_error)?;
        file.sync_all()?;
        std::fs::rename(&part, &place)
    };
    write().inspect_err(|_| {
        let _ = std::fs::remove_file(&part);
    })
}
