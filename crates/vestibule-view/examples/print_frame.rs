//! Prints the frame of a viewer: what to draw, in order, with the regions that confine it.
//!
//! ```text
//! cargo run -p vestibule-view --example print_frame -- DAT_FOLDER "0xA9B40170 [155.3 15.1 95.5]" 0,1,0
//! ```
//!
//! A renderer of your own walks the same list: every line here is one step of drawing.

use std::error::Error;
use std::io::Write as _;

use glam::{Vec2, Vec3};
use vestibule_dat::DatSet;
use vestibule_view::{Camera, Command, FrameInput, FrameView, Openings, Region, WorldObjects, retail_fov_y};
use vestibule_world::{Position, World};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(folder), Some(place)) = (arguments.next(), arguments.next()) else {
        return Err("usage: print_frame DAT_FOLDER POSITION [LOOK_X,LOOK_Y,LOOK_Z]".into());
    };
    let look = match arguments.next() {
        Some(text) => direction(&text)?,
        None => Vec3::Y,
    };
    let world = World::open(DatSet::open(folder)?)?;
    let position: Position = place.parse()?;
    let viewport = Vec2::new(1280.0, 720.0);
    let fov_y = retail_fov_y(core::f32::consts::FRAC_PI_2, viewport.x / viewport.y);
    let camera = Camera::new(position.cell, position.origin(), look, Vec3::Z, fov_y, viewport)?;

    // One of each is kept for the whole run: openings per world, a frame per viewer.
    let openings = Openings::new();
    let mut frame = FrameView::default();
    frame.update(
        &world,
        &openings,
        &WorldObjects::new(&world),
        &FrameInput::new(camera),
    );

    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "path {:?}, {} commands",
        frame.path(),
        frame.commands().len()
    )?;
    for region in frame.landscape_views() {
        writeln!(out, "landscape through {}", pixels(region, &camera))?;
    }
    let mut terrain = 0;
    for command in frame.commands() {
        if let Command::Terrain(_) | Command::TerrainBlock { .. } = command {
            // Many; a renderer would merge neighbours into one draw as well.
            terrain += 1;
            continue;
        }
        if terrain > 0 {
            writeln!(out, "terrain, {terrain} pieces")?;
            terrain = 0;
        }
        match command {
            Command::Room { cell, views } => {
                writeln!(out, "room {cell}")?;
                for region in frame.regions(*views) {
                    writeln!(out, "    through {}", pixels(region, &camera))?;
                }
            }
            Command::Punch {
                polygon,
                building,
                portal,
                ..
            } => {
                let corners = frame.polygon(*polygon).len();
                writeln!(
                    out,
                    "punch building {building} portal {portal}, {corners} corners"
                )?;
            }
            Command::Seal {
                polygon,
                depth,
                cell,
                portal,
            } => {
                let corners = frame.polygon(*polygon).len();
                writeln!(
                    out,
                    "seal {cell} portal {portal} at {depth:?} depth, {corners} corners"
                )?;
            }
            Command::Object { id, cell, .. } => writeln!(out, "object {id:?} in {cell}")?,
            other => writeln!(out, "{other:?}")?,
        }
    }
    if terrain > 0 {
        writeln!(out, "terrain, {terrain} pieces")?;
    }
    writeln!(out, "{:#?}", frame.counters())?;
    Ok(())
}

fn direction(text: &str) -> Result<Vec3, Box<dyn Error>> {
    let numbers: Vec<f32> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
    match numbers[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err("a direction is three numbers, X,Y,Z".into()),
    }
}

fn pixels(region: Region<'_>, camera: &Camera) -> String {
    let (low, high) = region.pixel_bounds(camera);
    let corners = region.edges().len();
    format!(
        "{corners} corners in {:.1},{:.1} to {:.1},{:.1}",
        low.x, low.y, high.x, high.y
    )
}
