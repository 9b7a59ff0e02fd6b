//! Measurements of a world of retail size.

use std::path::Path;
use std::time::{Duration, Instant};

use glam::Vec3;
use vestibule_dat::DatSet;
use vestibule_dat::record::LandBlock;
use vestibule_forge::synthetic::{SyntheticError, SyntheticReport, SyntheticWorld};
use vestibule_physics::{Carried, Mover, Population, Scratch, Simulation, SweepError, sweep};
use vestibule_world::{
    BlockId, CellArray, CellId, CellManager, MemoryRecords, PortalTarget, Position, ResidencySettings,
    ResidencyStats, Sphere, Store, World, WorldError, find_cell_list,
};

use crate::crowd;
use crate::golden::{self, GoldenError};

/// A measured figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What was measured.
    pub name: String,
    /// How much, with its unit.
    pub value: String,
    /// What it should be, if anything was asked for.
    pub target: Option<&'static str>,
}

/// Why something could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The world was not built.
    #[error(transparent)]
    Build(#[from] SyntheticError),
    /// Files cannot be read.
    #[error(transparent)]
    Dat(#[from] vestibule_dat::Error),
    /// A world cannot be opened.
    #[error(transparent)]
    World(#[from] WorldError),
    /// A record is not what was written.
    #[error(transparent)]
    Record(#[from] vestibule_dat::record::RecordError),
    /// A body could not be moved.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// The golden scenario did not run.
    #[error(transparent)]
    Golden(#[from] GoldenError),
    /// The scene of the comparison does not compile.
    #[error("the built-in world does not compile: {0}")]
    Scene(String),
    /// There is nothing to walk on.
    #[error("no ground at {0}")]
    NoGround(Position),
}

/// Everything, in the order of `docs/performance.md`. `folder` receives the world of retail size. `found` is called
/// with each figure as soon as it is known.
///
/// # Errors
/// When files cannot be written or read.
pub fn all(folder: &Path, found: &mut dyn FnMut(Figure)) -> Result<(), BenchError> {
    found(figure("machine", machine(), None));
    let report = build(folder, found)?;
    open(folder, found)?;
    cold_loads(folder, &report, found)?;
    streaming(folder, &report, found)?;
    crowds(folder, &report, found)?;
    near_not_far(found)?;
    golden_scenario(found)
}

/// The figures of crowds only, in a world that is built into `folder` first.
///
/// # Errors
/// As [`all`].
pub fn only_crowds(folder: &Path, found: &mut dyn FnMut(Figure)) -> Result<(), BenchError> {
    let report = build(folder, found)?;
    crowds(folder, &report, found)
}

/// The figures of loading and streaming only, in a world that is built into `folder` first.
///
/// # Errors
/// As [`all`].
pub fn only_streaming(folder: &Path, found: &mut dyn FnMut(Figure)) -> Result<(), BenchError> {
    let report = build(folder, found)?;
    cold_loads(folder, &report, found)?;
    streaming(folder, &report, found)
}

fn golden_scenario(found: &mut dyn FnMut(Figure)) -> Result<(), BenchError> {
    for threads in [1, 2] {
        let begun = Instant::now();
        let hash = golden::whole(threads)?;
        let name = format!("golden scenario, {threads} thread(s)");
        let value = format!("0x{hash:016X} in {:.2} s", begun.elapsed().as_secs_f64());
        found(figure(&name, value, Some("0xEA38E4B2F249C762")));
    }
    Ok(())
}

fn figure(name: &str, value: String, target: Option<&'static str>) -> Figure {
    Figure {
        name: name.to_owned(),
        value,
        target,
    }
}

/// Processor and number of cores.
pub fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name"));
    let model = model.map_or("unknown processor", |text| {
        text.trim_start_matches([' ', '\t', ':'])
    });
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {cores} cores, {}", std::env::consts::OS)
}

/// Memory of this process, bytes: what files map is not counted. Zero where it cannot be told.
fn memory() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let field = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name))?;
        line.split_whitespace().nth(1)?.parse::<usize>().ok()
    };
    field("RssAnon").unwrap_or(0) * 1024
}

/// Everything is done so often, and of each part the least time is taken: what other programs on the machine take
/// away is not counted then. The work is the same each time, to the bit.
const ROUNDS: usize = 3;

/// Processor time of all threads of this process so far, seconds, to a hundredth: unlike the clock it does not count
/// what other programs take. Zero where it cannot be told.
fn processor_time() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Fields 14 and 15, counted behind the name in parentheses.
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    let ticks: f64 = fields
        .skip(11)
        .take(2)
        .filter_map(|n| n.parse::<f64>().ok())
        .sum();
    ticks / 100.0
}

/// The shorter of each pair of times.
fn least(best: &mut Vec<Duration>, times: &[Duration]) {
    best.resize(times.len(), Duration::MAX);
    for (best, &time) in best.iter_mut().zip(times) {
        *best = (*best).min(time);
    }
}

fn milliseconds(t: Duration) -> f64 {
    t.as_secs_f64() * 1e3
}

/// Median, 99th percentile and largest of some times.
fn spread(times: &mut [Duration]) -> (Duration, Duration, Duration) {
    times.sort_unstable();
    let at = |share: usize| times.get(times.len() * share / 100).copied().unwrap_or_default();
    (at(50), at(99), times.last().copied().unwrap_or_default())
}

fn build(folder: &Path, found: &mut dyn FnMut(Figure)) -> Result<SyntheticReport, BenchError> {
    let begun = Instant::now();
    let report = SyntheticWorld::retail(1).build(folder, &mut |_| ())?;
    found(figure(
        "build a world of retail size",
        format!("{:.1} s", begun.elapsed().as_secs_f64()),
        Some("minutes"),
    ));
    let size = |name: &str| std::fs::metadata(folder.join(name)).map_or(0, |m| m.len()) as f64 / 1e6;
    let sizes = format!(
        "{:.1} MB cells, {:.2} MB assets",
        size("client_cell_1.dat"),
        size("client_portal.dat")
    );
    found(figure("its files", sizes, None));
    let counts = format!(
        "{} landblocks, {} buildings, {} env cells, {} portals, {} records",
        report.landblocks, report.buildings, report.env_cells, report.cell_portals, report.records
    );
    found(figure("in them", counts, None));
    Ok(report)
}

fn open(folder: &Path, found: &mut dyn FnMut(Figure)) -> Result<(), BenchError> {
    let mut times = Vec::new();
    for _ in 0..21 {
        let begun = Instant::now();
        let world = World::open(DatSet::open(folder)?)?;
        times.push(begun.elapsed());
        drop(world);
    }
    let (median, ..) = spread(&mut times);
    found(figure("open it", format!("{:.2} ms", milliseconds(median)), None));
    Ok(())
}

/// Landblocks loaded for the first time: all sorts in the proportions of the world, then those with cells.
fn cold_loads(
    folder: &Path,
    report: &SyntheticReport,
    found: &mut dyn FnMut(Figure),
) -> Result<(), BenchError> {
    let every: Vec<BlockId> = (0..2_000u32)
        .map(|k| BlockId::new((k * 97 % 255) as u8, (k * 61 % 255 + k / 255) as u8))
        .collect();
    let towns: Vec<BlockId> = report.towns.iter().map(|c| c.block()).take(1_000).collect();
    let dungeons: Vec<BlockId> = report.dungeons.iter().map(|d| d.0.block()).collect();
    for (name, blocks) in [("any", every), ("with houses", towns), ("dungeons", dungeons)] {
        let mut times = vec![Duration::MAX; blocks.len()];
        for _ in 0..ROUNDS {
            let world = World::open(DatSet::open(folder)?)?;
            for (&id, time) in blocks.iter().zip(&mut times) {
                let begun = Instant::now();
                std::hint::black_box(world.block(id));
                *time = (*time).min(begun.elapsed());
            }
        }
        let (median, high, most) = spread(&mut times);
        let value = format!(
            "median {:.3} ms, 99 % {:.3} ms, most {:.3} ms",
            milliseconds(median),
            milliseconds(high),
            milliseconds(most)
        );
        found(figure(
            &format!("cold landblock load, {name}"),
            value,
            Some("median 0.3 ms"),
        ));
    }
    Ok(())
}

fn streaming(
    folder: &Path,
    report: &SyntheticReport,
    found: &mut dyn FnMut(Figure),
) -> Result<(), BenchError> {
    let across = |world: &mut World, cells: &mut CellManager| -> Result<Trip, BenchError> {
        // East through 100 landblocks with a step of 2 m, each a millisecond after the other at least: far faster
        // than anything runs.
        let mut trip = Trip::default();
        let mut walk = Walk::new();
        let start = Position::new(CellId(0x5080_0001), Vec3::new(1.0, 100.0, 0.0));
        cells.change_position(world, &start);
        cells.finish(world);
        for k in 0..9_600u32 {
            let x = 1.0 + 2.0 * k as f32;
            let block = BlockId::new(0x50 + (x / 192.0) as u8, 0x80);
            let p = Vec3::new(x % 192.0, 100.0 + libm::sinf(x * 0.01) * 60.0, 0.0);
            let found = CellId::new(block, 1).adjust_to_outside(p);
            let cell = found.map_or(CellId::NONE, |(cell, _)| cell);
            trip.step(world, cells, &Position::new(cell, p), |world| {
                let Some(ground) = world.ground_at(cell, p) else {
                    return Ok(false);
                };
                let feet = ground.point.with_z(ground.z + 0.005);
                walk.step(world, Position::new(ground.cell, feet))?;
                Ok(true)
            })?;
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(trip)
    };
    rounds(folder, "walk through 100 landblocks", across, found)?;

    // The largest dungeon, cell by cell in the order of their distance.
    let Some(&(first, count)) = report.dungeons.first() else {
        return Ok(());
    };
    let everything = World::open(DatSet::open(folder)?)?;
    let mut route: Vec<CellId> = vec![first];
    let mut next = 0;
    while let Some(&id) = route.get(next) {
        next += 1;
        for portal in everything.env_cell(id).iter().flat_map(|c| &c.portals) {
            if let PortalTarget::Cell(other) = portal.other
                && !route.contains(&other)
            {
                route.push(other);
            }
        }
    }
    let places: Vec<Position> = route
        .iter()
        .filter_map(|&id| crowd::in_the_room(&everything, id))
        .collect();
    let through = |world: &mut World, cells: &mut CellManager| -> Result<Trip, BenchError> {
        let mut trip = Trip::default();
        let mut walk = Walk::new();
        if let Some(place) = places.first() {
            cells.change_position(world, place);
            cells.finish(world);
        }
        for place in &places {
            trip.step(world, cells, place, |world| {
                let known = world.is_resident(place.cell);
                walk.step(world, *place)?;
                Ok(known)
            })?;
        }
        Ok(trip)
    };
    rounds(
        folder,
        &format!("through a dungeon of {count} cells"),
        through,
        found,
    )
}

/// What was measured on the way.
#[derive(Default)]
struct Trip {
    /// Of each step, the time for streaming and for all of it.
    stalls: Vec<Duration>,
    steps: Vec<Duration>,
    /// Steps onto what was not there.
    unknown: u32,
    memory: usize,
}

impl Trip {
    fn step(
        &mut self,
        world: &mut World,
        cells: &mut CellManager,
        at: &Position,
        act: impl FnOnce(&World) -> Result<bool, SweepError>,
    ) -> Result<(), BenchError> {
        let begun = Instant::now();
        cells.change_position(world, at);
        cells.update(world);
        self.stalls.push(begun.elapsed());
        self.unknown += u32::from(!act(world)?);
        self.steps.push(begun.elapsed());
        if self.steps.len() % 64 == 1 {
            self.memory = self.memory.max(memory());
        }
        Ok(())
    }
}

/// Makes a trip several times.
fn rounds(
    folder: &Path,
    name: &str,
    make: impl Fn(&mut World, &mut CellManager) -> Result<Trip, BenchError>,
    found: &mut dyn FnMut(Figure),
) -> Result<(), BenchError> {
    let mut best = Trip::default();
    let mut stats = ResidencyStats::default();
    for _ in 0..ROUNDS {
        let before = memory();
        let mut world = World::open(DatSet::open(folder)?)?;
        let mut cells = CellManager::new(&mut world, ResidencySettings::default());
        let trip = make(&mut world, &mut cells)?;
        least(&mut best.stalls, &trip.stalls);
        least(&mut best.steps, &trip.steps);
        best.unknown += trip.unknown;
        best.memory = best.memory.max(trip.memory.saturating_sub(before));
        stats = cells.stats();
    }
    let (median, high, longest) = spread(&mut best.stalls);
    let value = format!(
        "longest {:.3} ms, 99 % {:.3} ms, median {:.4} ms ({} steps)",
        milliseconds(longest),
        milliseconds(high),
        milliseconds(median),
        best.stalls.len()
    );
    found(figure(
        &format!("{name}: stall for streaming"),
        value,
        Some("under 1 ms"),
    ));
    let (.., longest) = spread(&mut best.steps);
    let value = format!("{:.3} ms", milliseconds(longest));
    found(figure(
        &format!("{name}: longest whole step"),
        value,
        Some("under 1 ms"),
    ));
    let value = best.unknown.to_string();
    found(figure(
        &format!("{name}: steps onto what was not there"),
        value,
        Some("0"),
    ));
    let value = format!(
        "{:.1} MB of the process, {:.1} MB by own count; {} landblocks loaded",
        best.memory as f64 / 1e6,
        stats.peak_bytes as f64 / 1e6,
        stats.loaded
    );
    found(figure(
        &format!("{name}: peak memory"),
        value,
        Some("under 300 MB"),
    ));
    Ok(())
}

/// A body that is swept a little way wherever it is put.
struct Walk {
    mover: Mover,
    population: Population,
    scratch: Scratch,
}

impl Walk {
    fn new() -> Self {
        Walk {
            mover: Mover::player(),
            population: Population::new(),
            scratch: Scratch::new(),
        }
    }

    fn step(&mut self, world: &World, at: Position) -> Result<(), SweepError> {
        let mut to = at;
        to.frame.origin.x += 0.13;
        let carried = Carried::default();
        let swept = sweep(
            world,
            &self.population,
            &mut self.scratch,
            &self.mover,
            &carried,
            &at,
            &to,
        )?;
        std::hint::black_box(swept);
        Ok(())
    }
}

fn crowds(folder: &Path, report: &SyntheticReport, found: &mut dyn FnMut(Figure)) -> Result<(), BenchError> {
    let world = World::open(DatSet::open(folder)?)?;
    let mut spread_out: Vec<Position> = Vec::new();
    for k in 0..10_000u64 {
        let block = match report.towns.get(k as usize / 4) {
            Some(town) if k % 4 == 0 => town.block(),
            _ => BlockId::new((2 + k * 7 % 250) as u8, (2 + k * 13 % 250) as u8),
        };
        spread_out.extend(crowd::on_the_ground(&world, block, k));
    }
    crowd_figures(&world, "10,000 bodies over the world", &spread_out, found);
    let Some(&(first, count)) = report.dungeons.first() else {
        return Ok(());
    };
    let inside: Vec<Position> = (0..1_000u32)
        .filter_map(|k| crowd::in_the_room(&world, CellId(first.0 + k % u32::from(count))))
        .collect();
    crowd_figures(&world, "1,000 bodies in one dungeon", &inside, found);
    // A tenth of the rooms: everybody meets somebody.
    let packed: Vec<Position> = (0..1_000u32)
        .filter_map(|k| {
            let mut place = crowd::in_the_room(&world, CellId(first.0 + k % (u32::from(count) / 8)))?;
            place.frame.origin += Vec3::new(
                (k / 125 % 3) as f32 * 1.6 - 1.6,
                (k / 375) as f32 * 1.6 - 1.6,
                0.0,
            );
            Some(place)
        })
        .collect();
    crowd_figures(&world, "1,000 bodies in an eighth of its rooms", &packed, found);
    Ok(())
}

fn crowd_figures(world: &World, name: &str, places: &[Position], found: &mut dyn FnMut(Figure)) {
    let mut hashes = Vec::new();
    for threads in [1, 2] {
        let (mut sweeps, mut again) = (0, 0);
        let mut processor = 0.0;
        let mut best = Vec::new();
        for _ in 0..ROUNDS {
            (sweeps, again) = (0, 0);
            let mut simulation = Simulation::new(threads);
            crowd::populate(&mut simulation, places);
            let mut ticks = Vec::new();
            let mut settled = 0.0;
            for tick in 0..120u64 {
                if tick == 30 {
                    settled = processor_time();
                }
                crowd::direct(&mut simulation, tick);
                let begun = Instant::now();
                // A little more than a thirtieth, which is the least that is integrated.
                let report = simulation.step(world, 0.033_34);
                // The first second settles the bodies and loads what they touch.
                if tick >= 30 {
                    ticks.push(begun.elapsed());
                    sweeps += report.sweeps;
                    again += report.again;
                }
            }
            processor += (processor_time() - settled) / (ticks.len() * ROUNDS) as f64;
            least(&mut best, &ticks);
            hashes.push(simulation.hash());
        }
        let total: Duration = best.iter().sum();
        let (median, high, most) = spread(&mut best);
        let value = format!(
            "{:.2} M sweeps/s; a tick median {:.1} ms, 99 % {:.1} ms, most {:.1} ms, {:.1} ms of processor; {:.1} % \
             swept again",
            sweeps as f64 / total.as_secs_f64() / 1e6,
            milliseconds(median),
            milliseconds(high),
            milliseconds(most),
            processor * 1e3,
            100.0 * again as f64 / sweeps.max(1) as f64
        );
        found(figure(
            &format!("{name}, {threads} thread(s)"),
            value,
            Some("33.3 ms a tick"),
        ));
    }
    let same = if hashes.windows(2).all(|w| w[0] == w[1]) {
        "yes"
    } else {
        "NO"
    };
    found(figure(
        &format!("{name}: the same bytes"),
        same.to_owned(),
        Some("yes"),
    ));
}

/// The same surroundings alone, and in a world with thousands of times as many landblocks, all loaded.
fn near_not_far(found: &mut dyn FnMut(Figure)) -> Result<(), BenchError> {
    let built = vestibule_forge::embedded_world().map_err(|e| BenchError::Scene(e.to_string()))?;
    let small: MemoryRecords = built.memory_records();
    let mut large = small.clone();
    let template = small
        .iter()
        .find(|r| r.0 == Store::Cell && r.1 & 0xFFFF == 0xFFFF);
    if let Some((_, id, bytes)) = template {
        let mut record = LandBlock::parse(id, bytes)?;
        record.has_objects = Default::default();
        for id in (0..=u16::MAX)
            .map(BlockId)
            .filter(|id| id.is_on_map() && id.0 % 5 == 0)
        {
            record.id = id.land_block_record();
            if !small.iter().any(|r| (r.0, r.1) == (Store::Cell, record.id)) {
                large.insert(Store::Cell, record.id, record.encode()?);
            }
        }
    }
    let cells: Vec<CellId> = built.cell_names.keys().copied().collect();
    let (small, large) = (World::open(small)?, World::open(large)?);
    let mut blocks = 0;
    for id in (0..=u16::MAX).map(BlockId) {
        blocks += u32::from(large.block(id).is_some());
    }
    let places: Vec<Position> = cells
        .iter()
        .filter_map(|&cell| crowd::in_the_room(&small, cell))
        .collect();
    let mut walk = Walk::new();
    let mut array = CellArray::new();
    let mut look_up = |world: &World| {
        for place in &places {
            let sphere = Sphere::new(place.origin() + Vec3::Z * 0.475, 0.48);
            std::hint::black_box(find_cell_list(
                world,
                place.cell,
                place.origin(),
                &[sphere],
                &mut array,
                true,
            ));
        }
        Ok(())
    };
    let mut sweep = |world: &World| {
        for place in &places {
            walk.step(world, *place)?;
        }
        Ok(())
    };
    for (name, work) in [
        (
            "look-up",
            &mut look_up as &mut dyn FnMut(&World) -> Result<(), BenchError>,
        ),
        ("sweep", &mut sweep),
    ] {
        let mut best = [Duration::MAX; 2];
        for _ in 0..400 {
            for (world, best) in [&small, &large].into_iter().zip(&mut best) {
                let begun = Instant::now();
                work(world)?;
                *best = (*best).min(begun.elapsed());
            }
        }
        let each = |t: Duration| t.as_secs_f64() * 1e9 / places.len() as f64;
        let value = format!(
            "{:.0} ns alone, {:.0} ns among {blocks} landblocks ({:+.1} %)",
            each(best[0]),
            each(best[1]),
            100.0 * (best[1].as_secs_f64() / best[0].as_secs_f64() - 1.0)
        );
        found(figure(
            &format!("{name}, same surroundings"),
            value,
            Some("within 10 %"),
        ));
    }
    Ok(())
}
