//! The `vestibule` command.

#![forbid(unsafe_code)]

mod cmd;
mod ui;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use crate::cmd::Command;
use crate::ui::{Context, Failed, Hinted};

/// The cells of Asheron's Call: who is in which cell, what a body runs into and what can be seen, from retail DAT
/// files.
#[derive(Parser)]
#[command(version, propagate_version = true, after_help = AFTER_HELP)]
struct Cli {
    #[command(flatten)]
    global: ui::Global,
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Examples:
  vestibule tour
  vestibule tour --dat ~/ac
  vestibule where \"0xA9B40031 [155.372 16.028 94.005]\"
  vestibule inspect 0xA9B40100
  vestibule map A9B4 -o town.svg

Without --dat and VESTIBULE_DAT every command uses a small world that is built in.
Exit codes: 0 done, 1 failed (or something differs), 2 wrong usage.";

fn main() -> ExitCode {
    let cli = Cli::parse();
    let mut context = Context::new(cli.global);
    let done = cli
        .command
        .run(&mut context)
        .and_then(|()| Ok(context.out.flush()?));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        // The reader has gone, as with `vestibule ls | head`: no error.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            if context.out.flush().is_err() {
                return ExitCode::SUCCESS;
            }
            report(&error)
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|e| {
        e.downcast_ref::<std::io::Error>()
            .is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
    })
}

fn report(error: &anyhow::Error) -> ExitCode {
    // The outcome was printed already.
    if error.is::<Failed>() {
        return ExitCode::FAILURE;
    }
    let style = ui::style::ERROR;
    let mut text = format!("{style}error{style:#}: ");
    let mut last = String::new();
    for cause in error.chain() {
        let cause_text = cause.to_string();
        // Errors that show their source themselves would be said twice.
        if !last.contains(&cause_text) {
            if !last.is_empty() {
                text.push_str(": ");
            }
            text.push_str(&cause_text);
            last = cause_text;
        }
    }
    let hint = error.chain().find_map(|e| e.downcast_ref::<Hinted>());
    if let Some(hint) = hint {
        let style = ui::style::HINT;
        text.push_str(&format!("\n\n{style}hint{style:#}: {}", hint.hint));
    }
    anstream::eprintln!("{text}");
    if error.chain().any(|e| e.is::<ui::Usage>()) {
        ExitCode::from(2)
    } else {
        ExitCode::FAILURE
    }
}
