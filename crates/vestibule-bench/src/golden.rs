//! A fixed scenario and the hash of its outcome.

use vestibule_dat::DatSet;
use vestibule_forge::synthetic::{SyntheticError, SyntheticWorld};
use vestibule_physics::Simulation;
use vestibule_world::{BlockId, World, WorldError};

use crate::crowd;

/// Steps of bodies in the whole scenario.
pub const BODY_STEPS: u64 = 100_000;
/// Bodies in it.
const BODIES: u64 = 80;
/// The outcome of the whole scenario on every machine.
pub const HASH: u64 = 0xEA38_E4B2_F249_C762;

/// Why the scenario could not be run.
#[derive(Debug, thiserror::Error)]
pub enum GoldenError {
    /// Its world was not built.
    #[error(transparent)]
    Build(#[from] SyntheticError),
    /// Its files cannot be read.
    #[error(transparent)]
    Dat(#[from] vestibule_dat::Error),
    /// Its world cannot be opened.
    #[error(transparent)]
    World(#[from] WorldError),
}

/// Runs `ticks` ticks of 80 bodies, 1,250 for the whole scenario: a small synthetic world is built, and bodies walk
/// about in its land, houses and dungeons and into each other. The hash of where they end.
///
/// # Errors
/// Never, unless this crate and the others do not belong together.
pub fn scenario(threads: usize, ticks: u64) -> Result<u64, GoldenError> {
    let (portal, cell, report) =
        SyntheticWorld::small(2_026).build_into(Vec::new(), Vec::new(), &mut |_| ())?;
    let world = World::open(DatSet::from_bytes(portal, cell)?)?;
    let mut places = Vec::new();
    for k in 0..BODIES {
        let dungeon = report.dungeons.get(k as usize % 3).map(|d| d.0);
        let place = match (k % 4, dungeon) {
            // Several in each room, so that they meet.
            (0 | 1, Some(first)) => {
                crowd::in_the_room(&world, vestibule_world::CellId(first.0 + (k as u32 % 11)))
            }
            (2, _) => {
                let town = report.towns.get(k as usize % report.towns.len().max(1));
                town.and_then(|&first| crowd::in_the_room(&world, first))
            }
            _ => crowd::on_the_ground(&world, BlockId::new(2 + (k % 8) as u8, 2 + (k / 8 % 8) as u8), k),
        };
        places.extend(place);
    }
    let mut simulation = Simulation::new(threads);
    crowd::populate(&mut simulation, &places);
    for tick in 0..ticks {
        crowd::direct(&mut simulation, tick);
        simulation.step(&world, 1.0 / 20.0);
    }
    Ok(simulation.hash())
}

/// The whole scenario.
///
/// # Errors
/// As [`scenario`].
pub fn whole(threads: usize) -> Result<u64, GoldenError> {
    scenario(threads, BODY_STEPS / BODIES)
}
