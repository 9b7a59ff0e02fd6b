//! The `vestibule` command.

#![forbid(unsafe_code)]

mod cmd;
mod ui;

use std::io::{ErrorKind, Write};
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
            if !error.is::<Failed>() && !is_usage(&error) {
                context.warn_of_damage(&format!("{error:#}"));
            }
            match context.out.flush() {
                Err(e) if e.kind() == ErrorKind::BrokenPipe => ExitCode::SUCCESS,
                // What was printed is lost, whatever else went wrong.
                Err(e) if error.is::<Failed>() => report(&e.into()),
                _ => report(&error),
            }
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|e| {
        e.downcast_ref::<std::io::Error>()
            .is_some_and(|e| e.kind() == ErrorKind::BrokenPipe)
    })
}

fn is_usage(error: &anyhow::Error) -> bool {
    error.chain().any(|e| e.is::<ui::Usage>())
}

/// Advice for what the operating system refused.
fn advice(error: &anyhow::Error) -> Option<&'static str> {
    let refused = error.chain().find_map(|e| e.downcast_ref::<std::io::Error>())?;
    match refused.kind() {
        ErrorKind::NotFound => Some("check the path; a file is written to a folder that is there already"),
        ErrorKind::PermissionDenied => Some("this needs the right to read or write there"),
        ErrorKind::IsADirectory => Some("that is a folder; name a file"),
        ErrorKind::NotADirectory => Some("a part of the path is a file where a folder is needed"),
        ErrorKind::StorageFull => Some("make room and run it again"),
        ErrorKind::InvalidData => Some("a text file (UTF-8) is needed here"),
        _ => None,
    }
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
    if let Some(hint) = hint.map(|h| h.hint.as_str()).or_else(|| advice(error)) {
        let style = ui::style::HINT;
        text.push_str(&format!("\n\n{style}hint{style:#}: {hint}"));
    }
    anstream::eprintln!("{text}");
    if is_usage(error) {
        ExitCode::from(2)
    } else {
        ExitCode::FAILURE
    }
}
