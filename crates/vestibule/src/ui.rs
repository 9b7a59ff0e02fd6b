//! What every subcommand shares: options, output, tables, progress, errors with a hint.

use std::cell::RefCell;
use std::io::{BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use vestibule::OpenError;
use vestibule::dat::{DatSet, ErrorKind};
use vestibule::world::World;

/// Options of every subcommand.
#[derive(clap::Args)]
pub(crate) struct Global {
    /// Folder with client_portal.dat and client_cell_1.dat [default: VESTIBULE_DAT, else a small world that is built
    /// in]
    #[arg(long, value_name = "DIR", global = true)]
    dat: Option<PathBuf>,
    /// Print JSON for machines instead of text
    #[arg(long, global = true)]
    json: bool,
}

/// Where a subcommand finds its world and writes its results.
pub(crate) struct Context {
    dat: Option<PathBuf>,
    /// Whether to print JSON.
    pub(crate) json: bool,
    /// Results; colours are dropped where it is no terminal.
    pub(crate) out: BufWriter<anstream::AutoStream<std::io::Stdout>>,
    /// What was opened, until its directories have been looked through for damage.
    opened: RefCell<Option<Arc<DatSet>>>,
}

impl Context {
    pub(crate) fn new(global: Global) -> Self {
        // An empty variable means the same as none.
        let from_environment = || std::env::var_os("VESTIBULE_DAT").map(PathBuf::from);
        let dat = global
            .dat
            .or_else(from_environment)
            .filter(|dir| !dir.as_os_str().is_empty());
        let out = BufWriter::new(anstream::AutoStream::auto(std::io::stdout()));
        Context {
            dat,
            json: global.json,
            out,
            opened: RefCell::new(None),
        }
    }

    /// The folder given, if one was.
    pub(crate) fn folder(&self) -> Option<&Path> {
        self.dat.as_deref()
    }

    /// The world's name for people.
    pub(crate) fn world_name(&self) -> String {
        match &self.dat {
            Some(folder) => folder.display().to_string(),
            None => vestibule::EMBEDDED_NAME.to_owned(),
        }
    }

    pub(crate) fn dats(&self) -> anyhow::Result<Arc<DatSet>> {
        let dats = open_dats(self.folder())?;
        *self.opened.borrow_mut() = Some(dats.clone());
        Ok(dats)
    }

    /// Says on stderr, a line a file, where the directories of the files opened are damaged, unless it was said
    /// before or the text `said` has it: a world that is mostly missing has nothing else to show for it. Looks through
    /// whole directories, so it is for when nothing was found, or before work that takes long.
    pub(crate) fn warn_of_damage(&self, said: &str) {
        let Some(dats) = self.opened.take() else { return };
        for (_, file) in dats.files() {
            let mut damage = file.iter().filter_map(Result::err);
            let first = damage.next().map(|e| e.to_string());
            let Some(first) = first.filter(|text| !said.contains(text)) else {
                continue;
            };
            let more = match damage.count() {
                0 => String::new(),
                n => format!(" and {n} more"),
            };
            let (warn, hint) = (style::WARN, style::HINT);
            anstream::eprintln!(
                "{warn}warning{warn:#}: {first}{more}; {hint}hint{hint:#}: records are missing; copy the file again \
                 from the installation, `vestibule dat verify` tells more"
            );
        }
    }

    pub(crate) fn world(&self) -> anyhow::Result<World> {
        Ok(World::open(self.dats()?)?)
    }

    /// Writes a value as indented JSON.
    pub(crate) fn print_json(&mut self, value: &impl serde::Serialize) -> anyhow::Result<()> {
        serde_json::to_writer_pretty(&mut self.out, value).map_err(std::io::Error::from)?;
        writeln!(self.out)?;
        Ok(())
    }
}

/// Opens a folder, with a hint where it is none of DAT files.
pub(crate) fn open_dats(folder: Option<&Path>) -> anyhow::Result<Arc<DatSet>> {
    vestibule::open_dats(folder).map_err(|error| {
        let missing = folder.is_some_and(|f| !f.is_dir());
        let damaged = matches!(
            &error,
            OpenError::Dat(e) if matches!(
                e.kind(),
                ErrorKind::TooShort { .. } | ErrorKind::OutsideFile { .. } | ErrorKind::BadBlockSize(_)
            )
        );
        let hint = if missing {
            "a folder of an Asheron's Call installation is needed (--dat, or VESTIBULE_DAT)"
        } else if damaged {
            "the file is damaged or was not copied whole: copy it again from the installation"
        } else {
            "the folder needs client_portal.dat and client_cell_1.dat as retail installs them; \
             without --dat a small built-in world is used"
        };
        hinted(error, hint)
    })
}

/// An error with advice.
#[derive(Debug)]
pub(crate) struct Hinted {
    error: anyhow::Error,
    pub(crate) hint: String,
}

impl std::fmt::Display for Hinted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.error.fmt(f)
    }
}

impl std::error::Error for Hinted {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.error.source()
    }
}

/// Adds advice to an error.
pub(crate) fn hinted(error: impl Into<anyhow::Error>, hint: impl Into<String>) -> anyhow::Error {
    Hinted {
        error: error.into(),
        hint: hint.into(),
    }
    .into()
}

/// The command line asks for something that cannot be: exit code 2.
#[derive(Debug)]
pub(crate) struct Usage(pub(crate) String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// The command has run and said why the outcome is not good: exit code 1, nothing more to print.
#[derive(Debug)]
pub(crate) struct Failed;

impl std::fmt::Display for Failed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("failed")
    }
}

impl std::error::Error for Failed {}

/// Colours, by meaning.
pub(crate) mod style {
    use clap::builder::styling::{AnsiColor, Style};

    pub(crate) const HEAD: Style = Style::new().bold();
    pub(crate) const DIM: Style = Style::new().dimmed();
    pub(crate) const CELL: Style = AnsiColor::Cyan.on_default();
    pub(crate) const GOOD: Style = AnsiColor::Green.on_default();
    pub(crate) const BAD: Style = AnsiColor::Red.on_default().bold();
    pub(crate) const WARN: Style = AnsiColor::Yellow.on_default();
    pub(crate) const ERROR: Style = BAD;
    pub(crate) const HINT: Style = AnsiColor::Cyan.on_default();
}

/// Which side of a column its texts are set to.
#[derive(Clone, Copy)]
pub(crate) enum Align {
    Left,
    Right,
}

/// A table of texts; columns are as wide as their widest text.
pub(crate) struct Table {
    columns: Vec<(&'static str, Align)>,
    rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn new(columns: &[(&'static str, Align)]) -> Self {
        Table {
            columns: columns.to_vec(),
            rows: Vec::new(),
        }
    }

    pub(crate) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    pub(crate) fn write(&self, out: &mut impl Write) -> std::io::Result<()> {
        let width = |i: usize, head: &str| {
            let longest = self
                .rows
                .iter()
                .filter_map(|row| row.get(i))
                .map(|text| text.chars().count())
                .max();
            longest.unwrap_or(0).max(head.chars().count())
        };
        let widths: Vec<usize> = self
            .columns
            .iter()
            .enumerate()
            .map(|(i, (head, _))| width(i, head))
            .collect();
        let line = |texts: &mut dyn Iterator<Item = &str>| {
            let mut line = String::new();
            for ((text, &(_, align)), &width) in texts.zip(&self.columns).zip(&widths) {
                let pad = " ".repeat(width.saturating_sub(text.chars().count()));
                match align {
                    Align::Left => line.push_str(&format!("{text}{pad}  ")),
                    Align::Right => line.push_str(&format!("{pad}{text}  ")),
                }
            }
            line.trim_end().to_owned()
        };
        let head = line(&mut self.columns.iter().map(|(head, _)| *head));
        writeln!(out, "{}{head}{:#}", style::HEAD, style::HEAD)?;
        for row in &self.rows {
            writeln!(out, "{}", line(&mut row.iter().map(String::as_str)))?;
        }
        Ok(())
    }
}

/// A progress bar on stderr that only shows on a terminal, and only once something has taken a second.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    what: &'static str,
    total: u64,
    started: Instant,
}

impl Progress {
    pub(crate) fn new(what: &'static str, total: u64) -> Self {
        Progress {
            bar: None,
            what,
            total,
            started: Instant::now(),
        }
    }

    /// For work of unknown length.
    pub(crate) fn spinner(what: &'static str) -> Self {
        Progress::new(what, 0)
    }

    pub(crate) fn set(&mut self, done: u64) {
        match &self.bar {
            Some(bar) => bar.set_position(done),
            None if self.started.elapsed() >= Duration::from_secs(1) => self.show(done),
            None => {}
        }
    }

    fn show(&mut self, done: u64) {
        if !std::io::stderr().is_terminal() {
            return;
        }
        let known = self.total > 0;
        let total = known.then_some(self.total);
        let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::stderr_with_hz(10));
        let template = if known {
            "{msg} [{bar:40}] {human_pos}/{human_len} {eta}"
        } else {
            "{spinner} {human_pos} {msg}"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(self.what);
        bar.set_position(done);
        self.bar = Some(bar);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// A turning wheel on stderr for work that cannot say how far it is; shows on a terminal after a second.
pub(crate) struct Spinner(ProgressBar);

impl Spinner {
    pub(crate) fn new(what: &'static str) -> Self {
        let bar = ProgressBar::hidden();
        if std::io::stderr().is_terminal() {
            bar.set_message(what);
            let shown = bar.clone();
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_secs(1));
                if !shown.is_finished() {
                    shown.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
                    shown.enable_steady_tick(Duration::from_millis(100));
                }
            });
        }
        Spinner(bar)
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// `1 cell`, `2 cells`.
pub(crate) fn count(n: usize, what: &str) -> String {
    if n == 1 {
        format!("{n} {what}")
    } else {
        format!("{n} {what}s")
    }
}
