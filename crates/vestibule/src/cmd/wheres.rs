//! `vestibule where`: which cell a place is in.

use std::io::Write;

use vestibule::locate::{CellSummary, Location, locate};

use super::place::join_place;
use crate::ui::{Align, Context, Table, style};

/// Show where a place is: its cell, what is next to it, ground and water
///
/// The place is a position as the game's /loc prints it, or map coordinates. It is taken as the foot point of a
/// player: the cell is that of the centre of the lower sphere, 0.475 m higher.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  vestibule where \"0xA9B40031 [155.372 16.028 94.005]\"
  vestibule where 42.1N, 33.6E
  vestibule where \"0xA9B40101 [155.4 14.2 94.005] 1 0 0 0\" --json")]
pub(crate) struct Args {
    /// Position "0xCELL [x y z]" or map coordinates 42.1N, 33.6E
    #[arg(required = true, num_args = 1.., allow_negative_numbers = true)]
    place: Vec<String>,
}

pub(crate) fn run(args: &Args, context: &mut Context) -> anyhow::Result<()> {
    let place = join_place(&args.place)?;
    let world = context.world()?;
    let location = locate(&world, &place.position(&world)?);
    if context.json {
        context.print_json(&location)
    } else {
        print(&location, context)
    }
}

fn in_words(cell: &CellSummary) -> String {
    let mut out = format!("{}{}{:#}, {}", style::CELL, cell.cell, style::CELL, cell.kind);
    if !cell.exists {
        out.push_str(&format!(" {}not in this world{:#}", style::WARN, style::WARN));
    }
    if let Some(structure) = &cell.structure {
        out.push_str(&format!(" of structure {structure}"));
    }
    match cell.seen_outside {
        Some(true) => out.push_str(", sees the outside"),
        Some(false) => out.push_str(", sealed"),
        None => {}
    }
    if let Some(building) = &cell.building {
        out.push_str(&format!(", building {building} stands on it"));
    }
    out
}

fn print(location: &Location, context: &mut Context) -> anyhow::Result<()> {
    let out = &mut context.out;
    let (head, dim) = (style::HEAD, style::DIM);
    writeln!(out, "{head}position{head:#}   {}", location.position)?;
    writeln!(out, "{head}map{head:#}        {}", location.map)?;
    writeln!(out, "{head}named{head:#}      {}", in_words(&location.named))?;
    match &location.placed_in {
        Some(cell) if cell.cell == location.named.cell => {}
        Some(cell) => writeln!(out, "{head}placed in{head:#}  {}", in_words(cell))?,
        None => writeln!(
            out,
            "{head}placed in{head:#}  no cell: a body put here would be lost"
        )?,
    }
    match &location.containing {
        Some(cell) => writeln!(out, "{head}cell{head:#}       {}", in_words(cell))?,
        None => writeln!(
            out,
            "{head}cell{head:#}       none holds the centre of the lower sphere"
        )?,
    }
    if !location.touching.is_empty() {
        writeln!(out, "{head}touching{head:#}   {}", location.touching.join(" "))?;
    }
    if location.env_cells_here.len() > 1 {
        writeln!(
            out,
            "{head}overlap{head:#}    the centre is in {}",
            location.env_cells_here.join(" and ")
        )?;
    } else if let ([other], Some(cell)) = (location.env_cells_here.as_slice(), &location.containing)
        && *other != cell.cell
    {
        writeln!(
            out,
            "{head}note{head:#}       {other} holds the centre too, but is not reached from there"
        )?;
    }
    if let Some(ground) = &location.ground {
        let walkable = if ground.walkable {
            "walkable"
        } else {
            "too steep to stand on"
        };
        writeln!(
            out,
            "{head}ground{head:#}     {} at z {:.3}, slope {:.1} degrees, {walkable}; the place is {:.3} m {} it",
            ground.cell,
            ground.z,
            ground.slope,
            ground.above.abs(),
            if ground.above < 0.0 { "below" } else { "above" }
        )?;
        let mut terrain: Vec<&str> = Vec::new();
        for name in &ground.terrain {
            if !terrain.contains(&name.as_str()) {
                terrain.push(name);
            }
        }
        let road = if ground.road { ", road" } else { "" };
        writeln!(out, "{head}terrain{head:#}    {}{road}", terrain.join(", "))?;
        writeln!(
            out,
            "{head}water{head:#}      {}, a body sinks in {:.2} m",
            ground.water, ground.water_depth
        )?;
    } else {
        writeln!(out, "{head}ground{head:#}     no terrain here")?;
    }
    if !location.neighbours.is_empty() {
        writeln!(out)?;
        let mut table = Table::new(&[
            ("neighbour", Align::Left),
            ("by", Align::Left),
            ("metres", Align::Right),
        ]);
        for n in &location.neighbours {
            let distance = n.distance.map(|d| format!("{d:.2}")).unwrap_or_default();
            table.row([n.cell.clone(), n.way.clone(), distance]);
        }
        table.write(out)?;
    }
    if !location.statics.is_empty() {
        writeln!(out)?;
        let mut table = Table::new(&[("static object", Align::Left), ("position", Align::Left)]);
        for s in &location.statics {
            table.row([s.id.clone(), s.position.clone()]);
        }
        table.write(out)?;
    }
    for problem in &location.problems {
        writeln!(out, "{dim}problem: {problem}{dim:#}")?;
    }
    Ok(())
}
