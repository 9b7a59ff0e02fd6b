//! `vestibule visible`: what a camera sees.

use std::io::Write;
use std::path::PathBuf;

use glam::{Vec2, Vec3};
use serde_json::json;
use vestibule::view::{Camera, Command, FrameInput, FrameView, Openings, WorldObjects, retail_fov_y};
use vestibule::visible_svg::picture;
use vestibule::world::{CellId, World, adjust_position};

use super::place::{Place, parse_place};
use crate::ui::{Align, Context, Table, Usage, count, style};

/// Show what a camera sees: the cells to draw, in order, and the regions of the screen they show through
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule visible --eye \"0xA9B40101 [155 10 95.5]\" --look 0,1,0
  vestibule visible --eye \"0xA9B40031 [155 24 95.5]\" --look 0,-1,0 -o door.svg
  vestibule visible --eye \"0xA9B40101 [155 10 95.5]\" --look 0,1,0 --fov 60 --json")]
pub(crate) struct Args {
    /// Where the eye is: a position or map coordinates
    #[arg(long, value_name = "POS", value_parser = parse_place)]
    eye: Place,
    /// Direction of view: x east, y north, z up
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_direction, allow_hyphen_values = true)]
    look: Vec3,
    /// Whole vertical angle of view, degrees [default: as retail for the size]
    #[arg(long, value_name = "DEG")]
    fov: Option<f32>,
    /// Size of the screen, pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1280x720")]
    size: Vec2,
    /// Write a picture of the regions
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub(crate) fn parse_direction(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|part| part.trim().parse::<f32>()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if x.is_finite() && y.is_finite() && z.is_finite() && (x, y, z) != (0.0, 0.0, 0.0) => {
            Ok(Vec3::new(x, y, z))
        }
        Ok([_, _, _]) => Err("a direction needs finite numbers that are not all zero".to_owned()),
        _ => Err("write a direction as three numbers, as 0,1,0 for north".to_owned()),
    }
}

fn parse_size(text: &str) -> Result<Vec2, String> {
    let help = "write a size as 1280x720, from 1 to 16384";
    let (w, h) = text.split_once('x').ok_or(help)?;
    let side = |text: &str| {
        text.parse::<u16>()
            .ok()
            .filter(|n| (1..=16384).contains(n))
            .ok_or(help)
    };
    Ok(Vec2::new(f32::from(side(w)?), f32::from(side(h)?)))
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let world = context.world()?;
    let eye = args.eye.position(&world)?;
    // The eye may be given with the id of a cell nearby.
    let cell = adjust_position(&world, &eye, Vec3::ZERO, true)
        .filter(|a| a.resident)
        .map(|a| a.position);
    if cell.is_none() {
        context.warn_of_damage("");
    }
    let eye = cell.unwrap_or(eye);
    let fov = match args.fov {
        Some(degrees) => degrees.to_radians(),
        None => retail_fov_y(core::f32::consts::FRAC_PI_2, args.size.x / args.size.y),
    };
    // Looking straight up or down, the top of the screen is north.
    let up = if args.look.normalize().z.abs() > 0.999 {
        Vec3::Y
    } else {
        Vec3::Z
    };
    let camera = Camera::new(eye.cell, eye.origin(), args.look, up, fov, args.size)
        .map_err(|e| Usage(format!("no camera: {e}")))?;
    let openings = Openings::new();
    let mut frame = FrameView::default();
    frame.update(
        &world,
        &openings,
        &WorldObjects::new(&world),
        &FrameInput::new(camera),
    );
    let rooms = rooms(&world, &frame, &camera);
    if let Some(path) = &args.output {
        super::write_whole(path, picture(&frame, &camera).as_bytes())?;
    }
    let terrain = frame
        .commands()
        .iter()
        .filter(|c| matches!(c, Command::Terrain(_) | Command::TerrainBlock { .. }))
        .count();
    let objects = frame
        .commands()
        .iter()
        .filter(|c| matches!(c, Command::Object { .. }))
        .count();
    let buildings = frame
        .commands()
        .iter()
        .filter(|c| matches!(c, Command::Building { .. }))
        .count();
    if context.json {
        let cells: Vec<_> = rooms
            .iter()
            .map(|room| {
                json!({
                    "cell": room.cell.to_string(), "distance": room.distance, "area": room.area,
                    "regions": room.regions,
                })
            })
            .collect();
        let outside: Vec<Vec<[f32; 2]>> = frame
            .landscape_views()
            .map(|region| region.pixels(&camera).map(|p| p.to_array()).collect())
            .collect();
        return context.print_json(&json!({
            "eye": eye.to_string(), "cell": eye.cell.to_string(), "path": format!("{:?}", frame.path()),
            "cells": cells, "outside": outside, "terrain": terrain, "buildings": buildings, "objects": objects,
            "written": args.output,
        }));
    }
    let out = &mut context.out;
    let (head, dim) = (style::HEAD, style::DIM);
    let (x, y, z) = (eye.origin().x, eye.origin().y, eye.origin().z);
    writeln!(
        out,
        "{head}eye{head:#}      {}{}{:#} [{x:.2} {y:.2} {z:.2}], angle of view {:.1} degrees",
        style::CELL,
        eye.cell,
        style::CELL,
        fov.to_degrees()
    )?;
    writeln!(
        out,
        "{head}frame{head:#}    {:?}: {}",
        frame.path(),
        in_words(&frame)
    )?;
    writeln!(
        out,
        "{head}drawn{head:#}    {}, {}, {}, {}",
        count(rooms.len(), "room"),
        count(terrain, "piece") + " of terrain",
        count(buildings, "building"),
        count(objects, "object")
    )?;
    for region in frame.landscape_views() {
        let (low, high) = region.pixel_bounds(&camera);
        writeln!(
            out,
            "{head}outside{head:#}  through {:.0},{:.0} to {:.0},{:.0}",
            low.x, low.y, high.x, high.y
        )?;
    }
    if !rooms.is_empty() {
        writeln!(out, "\n{dim}in drawing order, far to near{dim:#}")?;
        let mut table = Table::new(&[
            ("cell", Align::Left),
            ("metres", Align::Right),
            ("regions", Align::Right),
            ("pixels", Align::Right),
            ("on the screen", Align::Left),
        ]);
        for room in &rooms {
            table.row([
                room.cell.to_string(),
                format!("{:.1}", room.distance),
                room.regions.len().to_string(),
                format!("{:.0}", room.area),
                room.bounds.clone(),
            ]);
        }
        table.write(out)?;
    }
    if let Some(path) = &args.output {
        writeln!(out, "written {}", path.display())?;
    }
    Ok(())
}

fn in_words(frame: &FrameView) -> &'static str {
    use vestibule::view::FramePath;
    match frame.path() {
        FramePath::Outdoors => "the landscape through the whole screen, and looks into buildings",
        FramePath::SeesOut => "rooms, and the landscape through the exits in view",
        FramePath::Sealed => "rooms only",
        FramePath::Nothing => "nothing to draw: the eye is in no cell of this world",
    }
}

/// A room of the draw list.
struct Room {
    cell: CellId,
    distance: f32,
    area: f32,
    regions: Vec<Vec<[f32; 2]>>,
    bounds: String,
}

fn rooms(world: &World, frame: &FrameView, camera: &Camera) -> Vec<Room> {
    let mut out = Vec::new();
    for command in frame.commands() {
        let Command::Room { cell, views } = command else {
            continue;
        };
        let (mut low, mut high) = (camera.viewport(), Vec2::ZERO);
        let mut regions = Vec::new();
        let mut area = 0.0;
        for region in frame.regions(*views) {
            let (a, b) = region.pixel_bounds(camera);
            low = low.min(a);
            high = high.max(b);
            area += region.pixel_area(camera);
            regions.push(region.pixels(camera).map(|p| p.to_array()).collect());
        }
        out.push(Room {
            cell: *cell,
            distance: distance(world, *cell, camera),
            area,
            regions,
            bounds: format!("{:.0},{:.0} to {:.0},{:.0}", low.x, low.y, high.x, high.y),
        });
    }
    out
}

/// From the eye to the nearest point of the cell's box, metres.
fn distance(world: &World, id: CellId, camera: &Camera) -> f32 {
    let Some(cell) = world.env_cell(id) else {
        return 0.0;
    };
    let Some(bounds) = cell.structure.bounds else {
        return 0.0;
    };
    let eye = cell.frame.global_to_local(camera.eye_in(id.block()));
    eye.distance(eye.clamp(bounds.min, bounds.max))
}
