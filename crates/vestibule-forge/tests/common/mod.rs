//! A player that walks by sweeps, for tests of worlds.

#![allow(dead_code, reason = "each test uses a part of this")]

pub(crate) mod eye;
pub(crate) mod random;

use glam::{Vec2, Vec3};
use vestibule_physics::{Carried, Mover, Population, Scratch, place, sweep};
use vestibule_world::ids::block_offset;
use vestibule_world::{CellId, Position, World, adjust_position};

pub(crate) struct Walker<'w> {
    world: &'w World,
    population: Population,
    scratch: Scratch,
    mover: Mover,
    pub(crate) at: Position,
    carried: Carried,
    fall: f32,
    /// Every cell entered, in order.
    pub(crate) trail: Vec<CellId>,
}

impl<'w> Walker<'w> {
    /// A player put down in a cell and come to rest.
    pub(crate) fn new(world: &'w World, cell: CellId, at: Vec3) -> Self {
        let (population, mut scratch, mover) = (Population::new(), Scratch::new(), Mover::player());
        let low = mover.spheres()[0].center;
        let adjusted =
            adjust_position(world, &Position::new(cell, at), low, true).expect("a place in a cell");
        let placed = place(
            world,
            &population,
            &mut scratch,
            &mover,
            &adjusted.position,
            true,
            true,
        )
        .unwrap();
        assert!(placed.ok, "a player does not fit at {cell:?} {at}");
        let cell = placed.cell.expect("a cell");
        let at = Position {
            cell,
            ..placed.position
        };
        let carried = placed.carried();
        let mut walker = Walker {
            world,
            population,
            scratch,
            mover,
            at,
            carried,
            fall: 0.0,
            trail: vec![cell],
        };
        for _ in 0..100 {
            walker.step(Vec2::ZERO);
        }
        walker
    }

    pub(crate) fn standing(&self) -> bool {
        self.carried.contact.is_some() && self.carried.on_walkable
    }

    pub(crate) fn step(&mut self, offset: Vec2) {
        let mut wanted = offset.extend(0.0);
        if self.standing() {
            self.fall = 0.0;
        } else {
            self.fall -= 9.8 / 30.0;
            wanted.z = self.fall / 30.0;
        }
        let to = Position::new(self.at.cell, self.at.origin() + wanted);
        let swept = sweep(
            self.world,
            &self.population,
            &mut self.scratch,
            &self.mover,
            &self.carried,
            &self.at,
            &to,
        )
        .unwrap();
        if let (true, Some(cell)) = (swept.ok, swept.cell) {
            self.at = Position {
                cell,
                ..swept.position
            };
            self.carried = swept.carried();
            if self.trail.last() != Some(&cell) {
                self.trail.push(cell);
            }
        }
    }

    /// Walks straight towards a point of landblock `base`'s frame; true when it gets within 5 cm.
    pub(crate) fn walk_to(&mut self, base: CellId, to: Vec2) -> bool {
        for _ in 0..2000 {
            let here = (block_offset(base.block(), self.at.cell.block()) + self.at.origin()).truncate();
            let left = to - here;
            if left.length() < 0.05 {
                return true;
            }
            self.step(left.clamp_length_max(0.1));
        }
        false
    }
}
