//! `vestibule render`: a picture.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::{Vec2, Vec3};
use serde_json::json;
use vestibule::render::{IdImage, Image, MAX_SIDE, PixelKind};
use vestibule::studio::{Shot, Studio};
use vestibule::view::{Camera, retail_fov_y};
use vestibule::walker::Walker;
use vestibule::world::{CellId, Position, World, adjust_position};

use super::gpu::Graphics;
use super::place::{Place, join_place, parse_place};
use super::visible::parse_direction;
use crate::ui::{Context, Usage, count, hinted, style};

/// Draw a picture of what can be seen from a place
///
/// With a position alone a player stands there and the chase camera looks from behind it, facing as the position's
/// rotation says (north without one). With --eye and --look the eye is wherever it is put. What is drawn is decided by
/// the portal traversal; --everything draws all loaded cells by depth alone, to compare. Pictures are drawn on the graphics
/// card if there is one and this program was built for it, those of --ids and --everything always on the processor.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule render \"0xA9B40031 [155.4 22 94.1] 0 0 0 1\" -o door.png
  vestibule render --eye \"0xA9B40101 [156.4 12.9 95.7]\" --look=-0.2,1,0 -o out.png
  vestibule render --eye \"0xA9B40101 [156.4 12.9 95.7]\" --look=-0.2,1,0 --ids -o ids.png
  vestibule render \"0xA9B40031 [155.4 22 94.1]\" --cpu -o repeatable.png
  vestibule render \"0xA9B40031 [155.4 22 94.1]\" --time 0.76 --size 320x180 --fov 60 -o evening.png

In the picture of --ids a pixel's red, green and blue are the low 24 bits of the cell whose
surface won it; shells of buildings count as their land cell, white is sky, black is where nothing
was drawn.")]
pub(crate) struct Args {
    /// Where the player stands: a position or map coordinates
    #[arg(value_name = "POS", required_unless_present = "eye", conflicts_with = "eye")]
    place: Vec<String>,
    /// Where the eye is, instead of behind a player
    #[arg(long, value_name = "POS", value_parser = parse_place, requires = "look")]
    eye: Option<Place>,
    /// Direction of view: x east, y north, z up
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_direction, allow_hyphen_values = true, requires = "eye")]
    look: Option<Vec3>,
    /// Size of the picture, pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1280x720")]
    size: (u32, u32),
    /// Whole vertical angle of view, degrees [default: as retail for the size]
    #[arg(long, value_name = "DEG", value_parser = parse_fov)]
    fov: Option<f32>,
    /// Time of day from 0 to 1: 0.25 is morning, 0.5 noon, 0.75 evening
    #[arg(long, value_name = "SHARE", value_parser = parse_time, default_value = "0.5")]
    time: f32,
    /// Draw cell ids instead of colours
    #[arg(long)]
    ids: bool,
    /// Draw all loaded cells by depth alone, without the traversal
    #[arg(long)]
    everything: bool,
    /// Draw on the processor even if there is a graphics card
    #[arg(long)]
    cpu: bool,
    /// File to write
    #[arg(short, long, value_name = "FILE.png", value_parser = png_file(), default_value = "view.png")]
    output: PathBuf,
}

/// Reads `1280x720`.
pub(crate) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let help = || format!("write a size as 1280x720, each side from 1 to {MAX_SIDE}");
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(help)?;
    let side = |text: &str| text.trim().parse::<u32>().map_err(|_| help());
    let (w, h) = (side(w)?, side(h)?);
    match (1..=MAX_SIDE).contains(&w) && (1..=MAX_SIDE).contains(&h) {
        true => Ok((w, h)),
        false if w == 0 || h == 0 => Err(format!("a picture without pixels; {}", help())),
        false => Err(format!("too large; {}", help())),
    }
}

/// A file for a picture. Every picture is a PNG: a name that says it is something else is refused.
pub(crate) fn png_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        let is_png = |e: &OsStr| e.eq_ignore_ascii_case("png") || e.eq_ignore_ascii_case("apng");
        if path.extension().is_none_or(is_png) {
            return Ok(path);
        }
        let named = path.with_extension("png");
        Err(format!(
            "pictures are written as PNG; hint: name it {}",
            named.display()
        ))
    })
}

fn parse_fov(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => Err("the angle is in degrees, between 0 and 180, as 60".to_owned()),
    }
}

fn parse_time(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(time) if (0.0..=1.0).contains(&time) => Ok(time),
        _ => Err("the time of day goes from 0 to 1, as 0.5 for noon".to_owned()),
    }
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let world = context.world()?;
    let mut studio = Studio::new(&world);
    studio.time_of_day = args.time;
    let size = Vec2::new(args.size.0 as f32, args.size.1 as f32);
    let fov = match args.fov {
        Some(degrees) => degrees.to_radians(),
        None => retail_fov_y(core::f32::consts::FRAC_PI_2, size.x / size.y),
    };
    let mut player = None;
    let shot = match (args.eye, args.look) {
        (Some(eye), Some(look)) => {
            let eye = place_eye(&world, &eye.position(&world)?)?;
            // Looking straight up or down, the top of the picture is north.
            let up = if look.normalize().z.abs() > 0.999 {
                Vec3::Y
            } else {
                Vec3::Z
            };
            let camera = Camera::new(eye.cell, eye.origin(), look, up, fov, size)
                .map_err(|e| Usage(format!("no camera: {e}")))?;
            studio.shot(camera)
        }
        _ => {
            let asked = join_place(&args.place)?.position(&world)?;
            let stands = stand(&world, &asked)?;
            player = Some(stands);
            let viewer = studio.chase(&stands);
            let cell = viewer.cell.map(|cell| cell.0);
            studio.shot_behind(&stands, &viewer.position, cell, fov, size)?
        }
    };
    let started = Instant::now();
    let (image, ids, drawn_by) = draw(&studio, &shot, args)?;
    let took = started.elapsed().as_secs_f64() * 1e3;
    write(&image, &args.output)?;
    let eye = Position::new(shot.camera.cell(), shot.camera.eye());
    let missing = studio.assets().counters().total();
    let mut cells: Vec<(CellId, usize)> = Vec::new();
    for id in ids.iter().flat_map(IdImage::ids) {
        if let Some(cell) = id.cell() {
            match cells.iter_mut().find(|(known, _)| *known == cell) {
                Some((_, pixels)) => *pixels += 1,
                None => cells.push((cell, 1)),
            }
        }
    }
    cells.sort_by_key(|&(cell, pixels)| (std::cmp::Reverse(pixels), cell));
    let clear = ids.as_ref().map_or(0, |ids| ids.count(PixelKind::Background));
    if context.json {
        let cells: Vec<_> = cells
            .iter()
            .map(|(cell, n)| json!({ "cell": cell.to_string(), "pixels": n }))
            .collect();
        return context.print_json(&json!({
            "written": args.output, "width": args.size.0, "height": args.size.1, "renderer": if drawn_by.is_some() { "gpu" } else { "cpu" }, "adapter": drawn_by,
            "milliseconds": took, "eye": eye.to_string(), "player": player.map(|p| p.to_string()),
            "path": format!("{:?}", shot.frame.path()), "placeholders": missing,
            "cells": args.ids.then_some(cells), "clear_pixels": args.ids.then_some(clear),
        }));
    }
    let (head, cell) = (style::HEAD, style::CELL);
    let out = &mut context.out;
    if let Some(player) = player {
        let p = player.origin();
        writeln!(
            out,
            "{head}player{head:#}   {cell}{}{cell:#} [{:.2} {:.2} {:.2}]",
            player.cell, p.x, p.y, p.z
        )?;
    }
    let p = eye.origin();
    writeln!(
        out,
        "{head}eye{head:#}      {cell}{}{cell:#} [{:.2} {:.2} {:.2}], angle of view {:.1} degrees",
        eye.cell,
        p.x,
        p.y,
        p.z,
        fov.to_degrees()
    )?;
    if args.ids {
        for (cell, pixels) in cells.iter().take(8) {
            writeln!(out, "{head}seen{head:#}     {cell}: {}", count(*pixels, "pixel"))?;
        }
        if clear > 0 {
            writeln!(
                out,
                "{}nothing{:#}  {}",
                style::WARN,
                style::WARN,
                count(clear, "pixel")
            )?;
        }
    }
    if missing > 0 {
        let text = count(missing as usize, "surface, texture or model");
        anstream::eprintln!(
            "{}warning{:#}: {text} missing or unusable, shown as a checker",
            style::WARN,
            style::WARN
        );
    }
    writeln!(
        out,
        "drawn {} in {took:.0} ms\nwritten {}",
        drawn_by.map_or_else(|| "on the processor".to_owned(), |name| format!("by {name},")),
        args.output.display()
    )?;
    Ok(())
}

/// The picture, its ids if they are asked for, and the name of the adapter if one drew it.
fn draw(
    studio: &Studio<'_>,
    shot: &Shot,
    args: &Args,
) -> anyhow::Result<(Image, Option<IdImage>, Option<String>)> {
    if cfg!(feature = "explore") && !args.cpu && !args.ids && !args.everything {
        let drawn = Graphics::open().and_then(|g| Ok((g.picture(studio, shot)?, g.name())));
        match drawn {
            Ok((image, name)) => return Ok((image, None, Some(name))),
            Err(why) => anstream::eprintln!(
                "{}notice{:#}: {why}; drawing on the processor",
                style::WARN,
                style::WARN
            ),
        }
    }
    if !args.ids {
        let image = if args.everything {
            studio.everything(shot)?
        } else {
            studio.picture(shot)?
        };
        return Ok((image, None, None));
    }
    let ids = if args.everything {
        studio.everything_ids(shot)?
    } else {
        studio.ids(shot)?
    };
    Ok((ids.to_image()?, Some(ids), None))
}

/// Writes a picture beside its place first, so that a failure leaves no half of it.
pub(crate) fn write(image: &Image, path: &Path) -> anyhow::Result<()> {
    let bytes = image.to_png()?;
    super::write_whole_by(path, |file| file.write_all(&bytes)).with_context(|| {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty() && !p.is_dir());
        match folder {
            Some(folder) => format!("there is no folder {}", folder.display()),
            None => format!("cannot write {}", path.display()),
        }
    })
}

/// The eye in the cell that holds it; the place may be given with the id of a cell nearby.
fn place_eye(world: &World, asked: &Position) -> anyhow::Result<Position> {
    let hint = "`vestibule where` tells which cell a place is in and how high the floor is there";
    if asked.cell.is_indoor() && world.env_cell(asked.cell).is_none() {
        return Err(hinted(anyhow::anyhow!("there is no cell {}", asked.cell), hint));
    }
    let found = adjust_position(world, asked, Vec3::ZERO, true).filter(|found| found.resident);
    let Some(found) = found.map(|found| found.position) else {
        let text = format!("the eye is in no cell: nothing of this world holds {asked}");
        return Err(hinted(anyhow::anyhow!(text), hint));
    };
    let below = |at: &Position| {
        world
            .ground_at(at.cell, at.origin())
            .filter(|ground| at.origin().z < ground.z)
    };
    if let Some(ground) = below(&found).filter(|_| !found.cell.is_indoor()) {
        let text = format!(
            "the eye is {:.1} m under the ground, and in no room",
            ground.z - found.origin().z
        );
        return Err(hinted(anyhow::anyhow!(text), hint));
    }
    Ok(found)
}

/// The player on its feet, facing as the position says.
fn stand(world: &World, asked: &Position) -> anyhow::Result<Position> {
    let hint = "`vestibule where` tells what is at a place; with --eye and --look the eye can be anywhere in the air";
    if asked.cell.is_indoor() && world.env_cell(asked.cell).is_none() {
        return Err(hinted(anyhow::anyhow!("there is no cell {}", asked.cell), hint));
    }
    let footing = Walker::new(world, asked.cell.block()).put(asked);
    let Some(footing) = footing else {
        let text = format!(
            "nobody can stand at {asked}: it is in no cell, inside something, or nothing is below it"
        );
        return Err(hinted(anyhow::anyhow!(text), hint));
    };
    let mut at = footing.at;
    at.frame.set_rotation(asked.frame.rotation());
    Ok(at)
}
