//! `vestibule explore` in a program that was built without a window.

use crate::ui::{Context, hinted};

/// Walk through a world in a window, and look behind the scenes (not in this build)
///
/// This program was built without the window. To have it:
///   cargo run --release --features explore -- explore
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Args {
    /// Whatever the window would be told
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _rest: Vec<String>,
}

pub(crate) fn run(_: &Args, _: &mut Context) -> anyhow::Result<()> {
    Err(hinted(
        anyhow::anyhow!("this program was built without the window"),
        "build it with the window: cargo run --release --features explore -- explore",
    ))
}
