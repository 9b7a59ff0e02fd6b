//! Random sweeps in sealed worlds: no body leaves its cells, moves without an accepted step or becomes NaN.
//! A million of them.

mod common;

use common::*;
use glam::Vec3;
use vestibule_physics::{Carried, Mover, Population, Scratch, Settings, SweepError, sweep};
use vestibule_world::{CellId, PortalTarget, Position, World};

/// Split over two worlds, four in a row from each start.
const STARTS: u32 = 125_000;

struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn signed(&mut self) -> f32 {
        self.next() * 2.0 - 1.0
    }
}

/// Whether `to` is reached from `from` through at most `hops` portals.
fn linked(world: &World, from: CellId, to: CellId, hops: u32) -> bool {
    if from == to {
        return true;
    }
    let Some(cell) = world.env_cell(from) else {
        return false;
    };
    hops > 0
        && cell
            .portals
            .iter()
            .any(|p| matches!(p.other, PortalTarget::Cell(id) if linked(world, id, to, hops - 1)))
}

fn soak(name: &str, sweeps: u32) {
    let Some(world) = open_world(name) else { return };
    let text = std::fs::read_to_string(vectors().unwrap().join(format!("bench/{name}.jsonl"))).unwrap();
    let starts: Vec<(Position, Carried)> = text
        .lines()
        .map(|line| {
            let v: serde_json::Value = serde_json::from_str(line).unwrap();
            (start(&v), carried(&v["state"]))
        })
        .collect();
    let (population, mut scratch) = (Population::new(), Scratch::new());
    let mut draws = Draws(0x9E37_79B9_7F4A_7C15);
    let mover = Mover::player();
    for i in 0..sweeps {
        // A fresh start now and then; else on from where the last one ended.
        let (mut at, mut state) = starts[(i / 40) as usize % starts.len()];
        for _ in 0..(i % 40) % 2 {
            state.sliding_normal = None;
        }
        for _ in 0..4 {
            let reach = if draws.next() < 0.05 { 6.0 } else { 0.4 };
            let step = Vec3::new(draws.signed(), draws.signed(), draws.signed() * 0.5) * reach;
            let mut to = at;
            to.frame.origin += step;
            let swept = sweep(&world, &population, &mut scratch, &mover, &state, &at, &to).unwrap();
            assert!(swept.position.is_finite());
            if !swept.ok {
                assert_eq!(swept.position.origin(), at.origin());
                continue;
            }
            let cell = swept
                .cell
                .unwrap_or_else(|| panic!("{name}: left the world at {}", swept.position));
            assert!(cell.is_indoor() && swept.position.cell == cell);
            assert!(
                linked(&world, at.cell, cell, 16.min(1 + (reach * 4.0) as u32)),
                "{} to {cell}",
                at.cell
            );
            let center = swept.position.origin() + mover.spheres()[0].center;
            let holds = world.point_in_cell(cell, center)
                || (at.cell == cell && (swept.position.origin() - at.origin()).length() < 1e-6);
            assert!(holds, "{name}: {cell} does not hold {center}");
            // Nothing is farther than the steps allow.
            let moved = (swept.position.origin() - at.origin()).length();
            assert!(
                moved <= step.length() + 2.6 * (1.0 + step.length() / 0.48),
                "{moved} for {step}"
            );
            at = swept.position;
            state = swept.carried();
        }
    }
}

#[test]
fn soak_dungeon() {
    soak("dungeon-1", STARTS);
}

#[test]
fn soak_maze() {
    soak("maze-424", STARTS);
}

#[test]
fn bad_input_is_refused_or_answers_lost() {
    let Some(world) = open_world("dungeon-1") else {
        return;
    };
    let (population, mut scratch) = (Population::new(), Scratch::new());
    let at = Position::new(CellId(30_998_784), Vec3::new(16.0, 36.0, 12.005));
    let mut go = |mover: &Mover, from: Position, to: Vec3| {
        let to = Position::new(from.cell, to);
        sweep(
            &world,
            &population,
            &mut scratch,
            mover,
            &Carried::default(),
            &from,
            &to,
        )
    };
    let player = Mover::player();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(matches!(
            go(&player, at, Vec3::splat(bad)),
            Err(SweepError::NotFinite { .. })
        ));
        let from = Position::new(at.cell, Vec3::splat(bad));
        assert!(matches!(
            go(&player, from, at.origin()),
            Err(SweepError::NotFinite { .. })
        ));
    }
    // Cells that do not exist, or are none: not ok, nothing moved (I10).
    for cell in [0, 0x01D9_0041, 0x01D9_0FFF, 0x01D9_FFFF, 0xFFFF_0001, 0x01D9_FFFE] {
        let from = Position::new(CellId(cell), at.origin());
        let swept = go(&player, from, at.origin() + Vec3::X).unwrap();
        assert_eq!(
            (swept.ok, swept.cell, swept.position.origin()),
            (false, None, at.origin()),
            "{cell:X}"
        );
    }
    // 10 km in any direction ends; so does 1e30 m, as an error.
    for direction in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Z] {
        let swept = go(&player, at, at.origin() + direction * 10_000.0).unwrap();
        assert!(swept.position.is_finite() && swept.cell.is_some());
        let far = go(&player, at, at.origin() + direction * 1e30);
        assert!(matches!(far, Err(SweepError::TooManySteps { .. })), "{far:?}");
    }
    assert!(go(&player, at, Vec3::splat(f32::MAX)).is_err());
    // No radius at all.
    let point = Mover::new(&[vestibule_world::Sphere::new(Vec3::new(0.0, 0.0, 0.5), 0.0)]).unwrap();
    let swept = go(&point, at, at.origin() + Vec3::new(1.0, 0.0, 0.0)).unwrap();
    assert!(swept.position.is_finite());
    assert!(Settings::default().max_steps >= 100_000);
}

#[test]
fn i16_and_reach_a_result_depends_on_nothing_out_of_reach() {
    // Fresh worlds each time against one that has walked all over.
    let (Some(used), population) = (open_world("cottage-1"), Population::new()) else {
        return;
    };
    for block in 0..=u16::MAX {
        let _ = used.block(vestibule_world::BlockId(block));
    }
    let mut scratch = Scratch::new();
    let mut fresh_scratch = Scratch::new();
    for case in cases("sweep.jsonl")
        .iter()
        .filter(|c| c["world"] == "cottage-1")
        .take(40)
    {
        let fresh = open_world("cottage-1").unwrap();
        let input = &case["in"];
        let from = start(input);
        let to = Position::new(from.cell, vec3(&input["to"]));
        let (mover, state) = (mover(input), carried(&input["state"]));
        let a = sweep(&used, &population, &mut scratch, &mover, &state, &from, &to);
        let b = sweep(
            &fresh,
            &population,
            &mut fresh_scratch,
            &mover,
            &state,
            &from,
            &to,
        );
        assert_eq!(a, b);
        assert_eq!(scratch.cells(), fresh_scratch.cells());
        // Standing still never changes the cell, and a blocked step changes nothing.
        let still = sweep(&used, &population, &mut scratch, &mover, &state, &from, &from).unwrap();
        assert_eq!((still.cell, still.position), (Some(from.cell), from));
    }
}
