//! `vestibule explore`: a window to walk in.

use std::io::Write as _;
use std::path::PathBuf;

use vestibule::world::{CellId, Position, World};
use vestibule_explore::{
    AdapterChoice, ExploreError, KEYS, NamedPlace, Opened, Options, keys_help, middle_of,
};

use super::explore_trail;
use super::place::{Place, parse_place};
use super::render::parse_size;
use crate::ui::{Context, hinted};

/// Walk through a world in a window, and look behind the scenes
///
/// The player moves by the collision sweep, the camera follows by its own, and what the portal traversal reaches is
/// drawn on the graphics card, or by the processor where there is none. Overlays show why a door shows what it shows:
/// cells, portals passed or refused, clip regions, collision polygons, the stab list; the traversal can be held and
/// looked at from outside.
#[derive(clap::Args)]
#[command(after_help = after_help())]
pub(crate) struct Args {
    /// Where to start: a position or map coordinates [default: where the world says, else the first landblock]
    #[arg(long, value_name = "POS", value_parser = parse_place)]
    start: Option<Place>,
    /// Size of the window
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1280x720")]
    size: (u32, u32),
    /// Draw on the processor even if there is a graphics card
    #[arg(long)]
    cpu: bool,
    /// Take the graphics adapter that saves power
    #[arg(long, conflicts_with = "software")]
    low_power: bool,
    /// Take the adapter that draws in software
    #[arg(long)]
    software: bool,
    /// Folder for saved pictures
    #[arg(long, value_name = "DIR", default_value = ".")]
    pictures: PathBuf,
    /// Write where player and viewer are as JSON lines, one a step; `-` is standard output. `vestibule map --trail` draws
    /// it, `vestibule replay` holds it against the world
    #[arg(long, value_name = "FILE")]
    trail: Option<PathBuf>,
    /// Destroy the graphics device after so many seconds, to try out what happens then
    #[arg(long, value_name = "SECONDS", hide = true, value_delimiter = ',')]
    lose_device: Vec<f32>,
    /// Print the keys and open no window
    #[arg(long)]
    keys: bool,
}

fn after_help() -> String {
    format!(
        "{}\nOpens a window:\n  vestibule explore\n  vestibule explore --dat ~/ac --start 42.1N,33.6E\n\n\
         Examples:\n  vestibule explore --keys",
        keys_help()
    )
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    if args.keys {
        if context.json {
            let keys = KEYS.iter().map(|(group, keys, what)| {
                serde_json::json!({ "group": group.name(), "keys": keys, "what": what })
            });
            return context.print_json(&keys.collect::<Vec<_>>());
        }
        write!(context.out, "{}", keys_help())?;
        return Ok(());
    }
    let dats = context.dats()?;
    let embedded = context.folder().is_none();
    let start = args.start;
    let options = Options {
        open: Box::new(move || {
            let world = World::open(dats).map_err(|e| e.to_string())?;
            let (mut names, mut named_start) = (Vec::new(), None);
            if embedded {
                let scene = vestibule_forge::embedded_world().map_err(|e| e.to_string())?;
                names = named(
                    &world,
                    scene.cell_names.iter().map(|(id, name)| (*id, name.as_str())),
                );
                named_start = scene.start;
            }
            let start = match start {
                Some(place) => place.position(&world).map_err(|e| e.to_string())?,
                None => named_start
                    .or_else(|| first_place(&world))
                    .ok_or("this world has no landblock to stand on")?,
            };
            Ok(Opened { world, names, start })
        }),
        title: format!("Vestibule: {}", context.world_name()),
        size: args.size,
        adapter: match (args.low_power, args.software) {
            (_, true) => AdapterChoice::Software,
            (true, _) => AdapterChoice::LowPower,
            _ => AdapterChoice::Best,
        },
        cpu: args.cpu,
        pictures: args.pictures.clone(),
        lose_device: args.lose_device.clone(),
        watch: args.trail.as_deref().map(explore_trail::watch).transpose()?,
    };
    vestibule_explore::run(options).map_err(|error| match error {
        ExploreError::World(_) | ExploreError::NoStart(_) => hinted(
            error,
            "`vestibule dat verify DIR` tells what is wrong with files; --start says where to begin",
        ),
        _ => hinted(
            error,
            "a window needs a display; `vestibule render` and `vestibule tour` do without",
        ),
    })
}

fn named<'a>(world: &World, names: impl Iterator<Item = (CellId, &'a str)>) -> Vec<NamedPlace> {
    names
        .filter_map(|(cell, name)| {
            Some(NamedPlace {
                name: name.to_owned(),
                position: middle_of(world, cell)?,
            })
        })
        .collect()
}

/// Holtburg, where the doorway of the recorded walk is; else the first landblock there is.
fn first_place(world: &World) -> Option<Position> {
    let holtburg = middle_of(world, CellId(0xA9B4_0031));
    holtburg.or_else(|| {
        let blocks = (0..=0xFEFEu32).filter(|b| b & 0xFF != 0xFF);
        let mut cells = blocks.flat_map(|b| [b << 16 | 1, b << 16 | 0x100]);
        cells.find_map(|id| middle_of(world, CellId(id)))
    })
}

#[cfg(test)]
mod tests {
    use clap::Args as _;
    use vestibule_explore::KEYS;

    #[test]
    fn help_has_the_keys_of_the_window() {
        let mut command = super::Args::augment_args(clap::Command::new("explore"));
        let help = command.render_long_help().to_string();
        for (group, keys, what) in KEYS {
            let line = help
                .lines()
                .find(|line| line.trim_start().starts_with(keys) && line.ends_with(what));
            assert!(line.is_some(), "{keys}: {what} in\n{help}");
            assert!(help.contains(group.name()));
        }
        assert!(!help.contains("lose-device"));
    }
}
