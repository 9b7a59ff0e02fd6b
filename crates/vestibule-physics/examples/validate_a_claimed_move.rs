//! A server checks a position that a client claims to have walked to:
//! `validate_a_claimed_move DAT_FOLDER FROM TO`.

use std::error::Error;

use vestibule_dat::DatSet;
use vestibule_physics::{Body, Placement, Population, Scratch, SweepError};
use vestibule_world::{Position, World};

/// How far a claim may be off, metres: clients send positions less often than they move.
const TOLERANCE: f32 = 0.25;

/// Whether a body could have walked to where it claims to be. Nothing moves.
fn could_walk(
    world: &World,
    population: &Population,
    scratch: &mut Scratch,
    id: vestibule_physics::BodyId,
    claimed: &Position,
) -> Result<bool, SweepError> {
    let swept = population.sweep(world, scratch, id, claimed)?;
    let off = swept.position.offset_to(claimed);
    Ok(swept.ok && swept.cell == Some(claimed.cell) && off.length() < TOLERANCE)
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, from, to] = args.as_slice() else {
        println!("usage: validate_a_claimed_move DAT_FOLDER FROM TO");
        return Ok(());
    };
    let world = World::open(DatSet::open(folder)?)?;
    let mut population = Population::new();
    let mut scratch = Scratch::new();
    let player = population.add(Body::player());
    population
        .set_position(&world, &mut scratch, player, &Placement::at(from.parse()?))?
        .ok();
    let claimed: Position = to.parse()?;
    let verdict = could_walk(&world, &population, &mut scratch, player, &claimed)?;
    println!("{}", if verdict { "plausible" } else { "refused" });
    Ok(())
}
