//! Our sweep beside `rapier3d` in one room and one run: a sweep, a ball cast against the same polygons and a step of
//! the kinematic character controller. Prints medians and ratios.
//!
//!     cargo run --release [WORLD [CELL]]
//!
//! WORLD is a folder of DAT files, the built-in world without; CELL an env cell id, else the sealed room whose own
//! polygons make closest to 36 triangles.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use glam::Vec3;
use rapier3d::control::{CharacterAutostep, CharacterLength, KinematicCharacterController};
use rapier3d::prelude as rapier;
use vestibule_physics::{Carried, Mover, Population, Scratch, constants::FLOOR_Z, sweep};
use vestibule_world::{CellId, EnvCell, PortalTarget, Position, World};

/// Moves of a round, rounds of each measurement.
const MOVES: usize = 4_000;
const ROUNDS: usize = 41;

struct Move {
    from: Position,
    to: Position,
    carried: Carried,
    /// The walker was put back to the start before this move.
    begins: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let world = match args.next() {
        Some(dir) => World::open(vestibule_dat::DatSet::open_in_memory(dir)?)?,
        None => World::open(
            vestibule_forge::embedded_world()
                .map_err(|e| format!("{e:?}"))?
                .memory_records(),
        )?,
    };
    let room = match args.next() {
        Some(cell) => CellId(u32::from_str_radix(cell.trim_start_matches("0x"), 16)?),
        None => choose_room(&world).ok_or("no sealed room")?,
    };
    let cell = world.env_cell(room).ok_or("no such cell")?;
    let mut cells = vec![cell];
    for portal in &cell.portals {
        if let PortalTarget::Cell(id) = portal.other
            && let Some(next) = world.env_cell(id)
            && cells.iter().all(|c| c.id != id)
        {
            cells.push(next);
        }
    }
    let triangles: Vec<[Vec3; 3]> = cells.iter().flat_map(|c| triangles_of(c)).collect();
    println!(
        "room {room}: {} triangles, {} with its {} neighbours",
        triangles_of(cell).len(),
        triangles.len(),
        cells.len() - 1
    );
    let mover = Mover::player();
    let moves = record_walk(&world, &mover, cell, &cells)?;
    let scene = Scene::new(&triangles)?;
    let (population, mut scratch) = (Population::new(), Scratch::new());
    let mut sweeps = || {
        for m in &moves {
            let swept = sweep(
                &world,
                &population,
                &mut scratch,
                &mover,
                &m.carried,
                &m.from,
                &m.to,
            );
            let _ = black_box(swept);
        }
    };
    let (mut hits, mut steps) = (0, Steps::default());
    let mut casts = || hits = scene.cast_all(&mover, &moves);
    let mut controller = || steps = scene.step_all(&mover, &moves, cell);
    let figures = measure(&mut [&mut sweeps, &mut casts, &mut controller]);
    let share = |n: usize| 100.0 * n as f64 / moves.len() as f64;
    println!("{:.1} % of the ball casts hit", share(hits));
    println!(
        "{:.1} % of the controller's steps end on the ground, {:.2} m from ours on average",
        share(steps.grounded),
        steps.apart / moves.len() as f64
    );
    println!("{:<44} {:>11} {:>11} {:>15}", "", "median", "least", "ratios");
    let rows = [
        "sweep of two spheres (vestibule-physics)",
        "cast of the foot ball (rapier3d)",
        "step of its character controller (rapier3d)",
    ];
    let ours = figures[0];
    for (name, (median, least)) in rows.into_iter().zip(figures) {
        let (a, b) = (median / ours.0, least / ours.1);
        println!("{name:<44} {median:>8.0} ns {least:>8.0} ns {a:>7.2} {b:>7.2}");
    }
    Ok(())
}

/// The polygons that collide, in the frame of the landblock, each once.
fn triangles_of(cell: &EnvCell) -> Vec<[Vec3; 3]> {
    let Some(bsp) = &cell.structure.physics else {
        return Vec::new();
    };
    let mut seen = Vec::new();
    let mut triangles = Vec::new();
    for face in bsp.faces() {
        if seen.contains(&face.polygon) {
            continue;
        }
        seen.push(face.polygon);
        let corners: Vec<Vec3> = bsp
            .edges(face)
            .iter()
            .map(|e| cell.frame.local_to_global(e.start))
            .collect();
        for pair in corners.windows(2).skip(1) {
            triangles.push([corners[0], pair[0], pair[1]]);
        }
    }
    triangles
}

fn choose_room(world: &World) -> Option<CellId> {
    let mut best = None;
    for block in 0..=u16::MAX {
        let Some(block) = world.block(vestibule_world::BlockId(block)) else {
            continue;
        };
        for cell in block.env_cells().filter(|c| !c.seen_outside) {
            let distance = triangles_of(cell).len().abs_diff(36);
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, cell.id));
            }
        }
    }
    best.map(|(_, id)| id)
}

struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// A walk of the kind of the vectors' workload, kept to the room and its neighbours.
fn record_walk(
    world: &World,
    mover: &Mover,
    room: &EnvCell,
    cells: &[&EnvCell],
) -> Result<Vec<Move>, Box<dyn Error>> {
    let (population, mut scratch) = (Population::new(), Scratch::new());
    let bounds = room.structure.bounds.ok_or("a room without size")?;
    let middle = room.frame.local_to_global((bounds.min + bounds.max) * 0.5);
    let mut start = (Position::new(room.id, middle), Carried::default());
    let mut draws = Draws(88_172_645_463_325_252);
    for _ in 0..400 {
        if start.1.on_walkable {
            break;
        }
        let mut to = start.0;
        to.frame.origin.z -= 0.05;
        let swept = sweep(world, &population, &mut scratch, mover, &start.1, &start.0, &to)?;
        start = (swept.position, swept.carried());
    }
    if !start.1.on_walkable {
        return Err("no ground under the middle of the room".into());
    }
    let mut moves = Vec::with_capacity(MOVES);
    let (mut at, mut carried) = start;
    let mut heading = draws.next() * core::f32::consts::TAU;
    let mut begins = true;
    while moves.len() < MOVES {
        if draws.next() < 0.1 {
            heading += (draws.next() - 0.5) * 3.0;
        }
        let d = 0.1 + 0.2 * draws.next();
        let mut to = at;
        to.frame.origin += Vec3::new(libm::cosf(heading) * d, libm::sinf(heading) * d, 0.0);
        let swept = sweep(world, &population, &mut scratch, mover, &carried, &at, &to)?;
        moves.push(Move {
            from: at,
            to,
            carried,
            begins,
        });
        begins = false;
        if swept.collision_normal.is_some() {
            heading += 2.0 * draws.next();
        }
        (at, carried) = (swept.position, swept.carried());
        let inside = swept.cell.is_some_and(|id| cells.iter().any(|c| c.id == id));
        if !inside || !carried.on_walkable {
            (at, carried) = start;
            begins = true;
        }
    }
    Ok(moves)
}

/// Nanoseconds a call of each, median and least of the rounds, which take turns: so a machine that does other
/// things does them to all.
fn measure(rounds: &mut [&mut dyn FnMut()]) -> Vec<(f64, f64)> {
    let mut times = vec![Vec::with_capacity(ROUNDS); rounds.len()];
    for round in 0..=ROUNDS {
        for (run, times) in rounds.iter_mut().zip(&mut times) {
            let start = Instant::now();
            run();
            // The first round warms up.
            if round > 0 {
                times.push(start.elapsed().as_nanos() as f64 / MOVES as f64);
            }
        }
    }
    times
        .iter_mut()
        .map(|times| {
            times.sort_by(f64::total_cmp);
            (times[ROUNDS / 2], times[0])
        })
        .collect()
}

/// What the steps of the controller came to.
#[derive(Default)]
struct Steps {
    grounded: usize,
    /// Sum of the distances from where our walker was, metres.
    apart: f64,
}

/// The room as rapier has it: one fixed triangle mesh.
struct Scene {
    bodies: rapier::RigidBodySet,
    colliders: rapier::ColliderSet,
    broad_phase: rapier::BroadPhaseBvh,
    narrow_phase: rapier::NarrowPhase,
}

fn vector(p: Vec3) -> rapier::Vector {
    rapier::Vector::new(p.x, p.y, p.z)
}

impl Scene {
    fn new(triangles: &[[Vec3; 3]]) -> Result<Self, Box<dyn Error>> {
        let vertices = triangles.iter().flatten().map(|&p| vector(p)).collect();
        let indices = (0..triangles.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        let mut scene = Scene {
            bodies: rapier::RigidBodySet::new(),
            colliders: rapier::ColliderSet::new(),
            broad_phase: rapier::BroadPhaseBvh::new(),
            narrow_phase: rapier::NarrowPhase::new(),
        };
        scene
            .colliders
            .insert(rapier::ColliderBuilder::trimesh(vertices, indices)?);
        rapier::CollisionPipeline::new().step(
            0.0,
            &mut rapier::IslandManager::new(),
            &mut scene.broad_phase,
            &mut scene.narrow_phase,
            &mut scene.bodies,
            &mut scene.colliders,
            &(),
            &(),
        );
        Ok(scene)
    }

    fn queries(&self) -> rapier::QueryPipeline<'_> {
        self.broad_phase.as_query_pipeline(
            self.narrow_phase.query_dispatcher(),
            &self.bodies,
            &self.colliders,
            rapier::QueryFilter::default(),
        )
    }

    /// The foot ball along each move, as far as it goes: nothing is slid along or stepped onto. It is lifted by a
    /// centimetre, so that it does not rest on the floor, which would end every cast at once.
    fn cast_all(&self, mover: &Mover, moves: &[Move]) -> usize {
        let foot = mover.spheres()[0];
        let ball = rapier::Ball::new(foot.radius);
        let options = rapier3d::parry::query::ShapeCastOptions {
            max_time_of_impact: 1.0,
            ..Default::default()
        };
        let lift = Vec3::new(0.0, 0.0, 0.01);
        let queries = self.queries();
        let mut hits = 0;
        for m in moves {
            let pose = rapier::Pose::from_translation(vector(m.from.origin() + foot.center + lift));
            let velocity = vector(m.to.origin() - m.from.origin());
            let hit = queries.cast_shape(&pose, velocity, &ball, options);
            hits += usize::from(black_box(hit).is_some());
        }
        hits
    }

    /// A capsule of the same radius and height that steps up 0.6 m and is drawn down 1.5 m, wherever it goes.
    fn step_all(&self, mover: &Mover, moves: &[Move], room: &EnvCell) -> Steps {
        let [foot, head] = [mover.spheres()[0], mover.spheres()[1]];
        let half = (head.center.z - foot.center.z) * 0.5;
        let capsule = rapier::Capsule::new_z(half, foot.radius);
        let gap = 0.01;
        let controller = KinematicCharacterController {
            up: vector(Vec3::Z),
            offset: CharacterLength::Absolute(gap),
            slide: true,
            autostep: Some(CharacterAutostep {
                max_height: CharacterLength::Absolute(mover.step_up_height),
                min_width: CharacterLength::Absolute(0.1),
                include_dynamic_bodies: false,
            }),
            max_slope_climb_angle: libm::acosf(FLOOR_Z),
            min_slope_slide_angle: libm::acosf(FLOOR_Z),
            snap_to_ground: Some(CharacterLength::Absolute(mover.step_down_height)),
            ..Default::default()
        };
        let queries = self.queries();
        let lift = Vec3::new(0.0, 0.0, foot.center.z + half + gap);
        let lowest = room.frame.origin.z - 20.0;
        let mut at = Vec3::ZERO;
        let mut steps = Steps::default();
        for m in moves {
            if m.begins || at.z < lowest || (at - m.from.origin()).length() > 3.0 {
                at = m.from.origin();
            }
            let pose = rapier::Pose::from_translation(vector(at + lift));
            let wanted = vector(m.to.origin() - m.from.origin());
            let moved = controller.move_shape(1.0 / 30.0, &queries, &capsule, &pose, wanted, |_| {});
            steps.grounded += usize::from(moved.grounded);
            at += Vec3::new(moved.translation.x, moved.translation.y, moved.translation.z);
            steps.apart += f64::from((at - m.from.origin()).length());
        }
        steps
    }
}
