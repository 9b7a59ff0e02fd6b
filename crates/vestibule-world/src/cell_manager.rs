//! Streaming by retail's rules around one viewer (`world.md` 17, retail `CellManager`, `LScape`).

use std::collections::{BTreeMap, BTreeSet};

use crate::env_cell::EnvCell;
use crate::ids::{BlockId, CellId};
use crate::landblock::{BoxedBlock, Landblock};
use crate::loader::{Loaded, Loader};
use crate::lscape::LandscapeWindow;
use crate::position::Position;
use crate::residency::{Hidden, ResidencySettings, ResidencyStats, apart, window_of};
use crate::world::World;

/// Landblocks this far from the load point have objects, buildings and cells (`world.md` 4.4, 17.2 L3).
const FULL_DETAIL: u8 = 1;
/// Landblocks this far from the load point are loaded whole, so that they are there when it moves on.
const PREFETCHED: u8 = 2;

/// Keeps resident what a viewer needs, and nothing else, of a [`World`] of any size.
///
/// What physics knows after each [`CellManager::update`], once everything asked for has been loaded
/// (`world.md` 17.1 R5):
///
/// * env cells: the current cell and those of its stab list when it is indoors, and the stab lists of the landblocks
///   around when it is outdoors or sees the outside;
/// * land cells: of the landblock of the load point and the eight around it, unless the current cell does not see
///   the outside.
///
/// Everything else is *unknown*: look-ups answer `None` and nothing loads when it is touched. A body that comes to
/// what is not there yet is treated as retail treats it; it does not fall. Farther landscape is loaded for drawing
/// and found by [`World::loaded_block`] only.
///
/// Landblocks are loaded, and freed, on a thread of their own. The world is changed only in `change_position`,
/// `update`, `finish` and `reset`, between steps; while bodies move it is shared as ever.
///
/// ```no_run
/// use vestibule_world::{CellManager, Position, ResidencySettings, World};
/// # fn demo(source: vestibule_world::MemoryRecords) -> Result<(), Box<dyn std::error::Error>> {
/// let mut world = World::open(source)?;
/// let mut cells = CellManager::new(&mut world, ResidencySettings::default());
/// let start: Position = "0xA9B40031 [155.372 16.028 94.005]".parse()?;
/// cells.change_position(&mut world, &start);
/// cells.finish(&mut world); // a loading screen would do this
/// loop {
///     // ... move bodies ...
///     # let now = start;
///     cells.change_position(&mut world, &now);
///     cells.update(&mut world);
/// #   break;
/// }
/// # Ok(()) }
/// ```
pub struct CellManager {
    settings: ResidencySettings,
    loader: Loader,
    /// The load position: what is resident follows it.
    current: Option<Position>,
    /// Where the viewer has gone; becomes `current` when its landblock is there.
    wanted: Option<Position>,
    window: Option<LandscapeWindow>,
    /// What of the landblocks that physics knows is hidden from it.
    known: BTreeMap<BlockId, Hidden>,
    /// All landblocks held, with their memory in bytes and whether they are whole.
    held: BTreeMap<BlockId, Held>,
    in_flight: BTreeSet<BlockId>,
    /// Env cells that physics knows, ascending.
    resident: Vec<CellId>,
    released: Vec<BoxedBlock>,
    /// Memory ran out: no more distant landscape until the load point moves on.
    full_up: bool,
    stats: ResidencyStats,
}

#[derive(Clone, Copy)]
struct Held {
    full: bool,
    bytes: usize,
    /// There is no such landblock.
    absent: bool,
}

impl CellManager {
    /// Takes over what is resident in `world`: it is released, and nothing loads on touch from now on.
    pub fn new(world: &mut World, settings: ResidencySettings) -> Self {
        let mut loader = Loader::new(world.records().clone(), settings.threaded);
        loader.drop_blocks(world.stop_loading_on_touch());
        loader.prune();
        CellManager {
            settings,
            loader,
            current: None,
            wanted: None,
            window: None,
            known: BTreeMap::new(),
            held: BTreeMap::new(),
            in_flight: BTreeSet::new(),
            resident: Vec::new(),
            released: Vec::new(),
            full_up: false,
            stats: ResidencyStats::default(),
        }
    }

    /// Tells where the viewer is (retail `ChangePosition`, `world.md` 17.3 W1). What is loaded already becomes
    /// resident at once, and only then is the old released; the rest follows in [`CellManager::update`]. Cell id 0
    /// releases everything.
    pub fn change_position(&mut self, world: &mut World, position: &Position) {
        if position.cell.is_none() {
            self.reset(world);
            return;
        }
        if self
            .wanted
            .or(self.current)
            .is_some_and(|now| now.cell == position.cell)
        {
            return;
        }
        self.wanted = Some(*position);
        self.apply(world);
    }

    /// Takes over what has been loaded since, asks for what is still missing. Cheap: call it once a step.
    pub fn update(&mut self, world: &mut World) {
        let mut changed = false;
        for _ in 0..self.settings.taken_per_update.max(1) {
            match self.loader.next(false) {
                Ok(Some(loaded)) => {
                    self.take(world, loaded);
                    changed = true;
                }
                Ok(None) => break,
                Err(_) => self.in_flight.clear(),
            }
        }
        if changed {
            self.apply(world);
        } else {
            self.request();
        }
    }

    /// Waits until everything is resident that the position asks for and memory allows.
    pub fn finish(&mut self, world: &mut World) {
        loop {
            self.apply(world);
            if self.in_flight.is_empty() {
                return;
            }
            match self.loader.next(true) {
                Ok(Some(loaded)) => self.take(world, loaded),
                Ok(None) => return,
                Err(_) => self.in_flight.clear(),
            }
        }
    }

    /// Releases everything (retail `Reset`, `world.md` 17.3 W3).
    pub fn reset(&mut self, world: &mut World) {
        (self.current, self.wanted, self.window) = (None, None, None);
        self.resident.clear();
        for id in core::mem::take(&mut self.held).into_keys() {
            self.released.extend(world.set_block(id, None));
            self.released.extend(world.distant().remove(&id));
        }
        self.known.clear();
        self.loader.drop_blocks(core::mem::take(&mut self.released));
        self.loader.prune();
    }

    /// The position that residency follows: the last one whose landblock has been loaded.
    pub fn load_position(&self) -> Option<&Position> {
        self.current.as_ref()
    }

    /// Whether the position asked for, its env cells and the landblocks around it are all there.
    pub fn is_complete(&self) -> bool {
        self.wanted.is_none()
            && self.window.as_ref().is_none_or(|window| {
                window
                    .blocks()
                    .filter(|&id| apart(id, window.center) <= FULL_DETAIL)
                    .all(|id| self.held.get(&id).is_some_and(|held| held.full))
            })
    }

    /// The env cells that physics knows, ascending.
    pub fn resident_cells(&self) -> &[CellId] {
        &self.resident
    }

    /// The landscape that is loaded; `None` in a cell that does not see the outside.
    pub fn window(&self) -> Option<LandscapeWindow> {
        self.window
    }

    /// What is resident, and what it took.
    pub fn stats(&self) -> ResidencyStats {
        ResidencyStats {
            env_cells: self.resident.len(),
            blocks: self.known.len(),
            distant_blocks: self.held.values().filter(|h| !h.absent).count() - self.known.len(),
            in_flight: self.in_flight.len(),
            ..self.stats
        }
    }

    fn take(&mut self, world: &mut World, loaded: Loaded) {
        self.in_flight.remove(&loaded.id);
        self.stats.loaded += 1;
        let Some(block) = loaded.block else {
            let absent = Held {
                full: true,
                bytes: 0,
                absent: true,
            };
            self.held.insert(loaded.id, absent);
            return;
        };
        // Asked for and no longer needed, or here already.
        let needed = self.is_wanted(loaded.id) && !self.known.contains_key(&loaded.id);
        if !needed {
            self.released.push(block);
            return;
        }
        self.released.extend(world.distant().insert(loaded.id, block));
        let held = Held {
            full: loaded.full,
            bytes: loaded.bytes,
            absent: false,
        };
        self.held.insert(loaded.id, held);
    }

    /// Whether the window or the position asks for a block at all.
    fn is_wanted(&self, id: BlockId) -> bool {
        let named = |p: &Option<Position>| p.is_some_and(|p| p.cell.block() == id);
        named(&self.wanted)
            || named(&self.current)
            || self
                .window
                .is_some_and(|w| apart(id, w.center) <= w.radius.max(PREFETCHED))
    }

    fn env_cell<'a>(&'a self, world: &'a World, id: CellId) -> Option<&'a EnvCell> {
        let hidden = self.known.get(&id.block()).and_then(|hidden| hidden.cell(id));
        let block = || world.loaded_block(id.block());
        hidden.or_else(|| block()?.env_cell(id))
    }

    /// Brings the world up to the position asked for, as far as it is loaded.
    fn apply(&mut self, world: &mut World) {
        if let Some(wanted) = self.wanted {
            let there = self.held.get(&wanted.cell.block()).is_some_and(|held| held.full);
            if !there {
                self.request();
                return;
            }
            self.current = Some(wanted);
            self.wanted = None;
            let seen_outside = self.env_cell(world, wanted.cell).is_some_and(|c| c.seen_outside);
            self.window = window_of(&wanted, seen_outside, self.settings.radius);
            self.full_up = false;
        }
        let Some(current) = self.current else { return };
        let center = self.window.map(|w| w.center);
        let outdoors = |id: BlockId| center.is_some_and(|c| apart(id, c) <= FULL_DETAIL);
        let needed = |id: BlockId| outdoors(id) || (current.cell.is_indoor() && id == current.cell.block());

        // Grab the new before the old is released (`world.md` W1).
        let mut changed: BTreeSet<BlockId> = BTreeSet::new();
        let grab: Vec<BlockId> = self
            .held
            .iter()
            .filter(|&(&id, held)| held.full && !held.absent && needed(id))
            .map(|(&id, _)| id)
            .collect();
        for id in grab {
            if !self.known.contains_key(&id)
                && let Some(mut block) = world.distant().remove(&id)
            {
                self.known.insert(id, Hidden::all_of(&mut block));
                world.set_block(id, Some(block));
                changed.insert(id);
            }
            if let (Some(hidden), Some(block)) = (self.known.get_mut(&id), world.block_mut(id))
                && hidden.set_land(block, outdoors(id))
            {
                changed.insert(id);
            }
        }
        self.change_cells(world, &current, &mut changed);
        self.release(world, needed, &mut changed);
        for id in changed {
            forget_shadows(world, id);
        }
        self.keep_ceiling(world);
        self.loader.drop_blocks(core::mem::take(&mut self.released));
        self.request();
    }

    /// Makes exactly the env cells of `world.md` R5 known.
    fn change_cells(&mut self, world: &mut World, current: &Position, changed: &mut BTreeSet<BlockId>) {
        let mut resident: Vec<CellId> = Vec::new();
        if let Some(cell) = self.env_cell(world, current.cell) {
            resident.push(cell.id);
            resident.extend(&cell.stab_list);
        }
        if let Some(window) = self.window {
            for (_, hidden) in self
                .known
                .iter()
                .filter(|(id, _)| apart(**id, window.center) <= FULL_DETAIL)
            {
                resident.extend(&hidden.stabs);
            }
        }
        resident.sort_unstable();
        resident.dedup();
        resident.retain(|&id| id.is_indoor() && self.env_cell(world, id).is_some());
        let known = &self.known;
        resident.retain(|id| known.contains_key(&id.block()));
        let moves = differences(&self.resident, &resident);
        let mut rest = &moves[..];
        while let Some(first) = rest.first() {
            let block = first.block();
            let end = rest
                .iter()
                .position(|id| id.block() != block)
                .unwrap_or(rest.len());
            if let (Some(hidden), Some(landblock)) = (self.known.get_mut(&block), world.block_mut(block)) {
                hidden.change_cells(landblock, &rest[..end]);
                changed.insert(block);
            }
            rest = &rest[end..];
        }
        self.resident = resident;
    }

    /// Takes from physics what it is not to know any more, and drops what is out of the window.
    fn release(
        &mut self,
        world: &mut World,
        needed: impl Fn(BlockId) -> bool,
        changed: &mut BTreeSet<BlockId>,
    ) {
        let gone: Vec<BlockId> = self.known.keys().copied().filter(|&id| !needed(id)).collect();
        for id in gone {
            if let (Some(hidden), Some(mut block)) = (self.known.remove(&id), world.set_block(id, None)) {
                forget_own_shadows(&mut block);
                hidden.restore(&mut block);
                world.distant().insert(id, block);
            }
            changed.insert(id);
        }
        let unwanted: Vec<BlockId> = self
            .held
            .keys()
            .copied()
            .filter(|&id| !self.is_wanted(id))
            .collect();
        let mut any = !unwanted.is_empty();
        for id in unwanted {
            self.held.remove(&id);
            self.released.extend(world.distant().remove(&id));
        }
        // What is no longer near has terrain only (`world.md` 17.2 L3).
        if let Some(window) = self.window {
            let far = |id: BlockId| apart(id, window.center) > PREFETCHED + 1;
            for (&id, held) in self
                .held
                .iter_mut()
                .filter(|(id, held)| held.full && !held.absent && far(**id))
            {
                if let Some(block) = world.distant().get_mut(&id) {
                    let coarse = Box::new(Landblock::of_land(id, block.land.take()));
                    (held.full, held.bytes) = (false, coarse.memory());
                    self.released.push(core::mem::replace(block, coarse));
                    any = true;
                }
            }
        }
        if any {
            self.loader.drop_blocks(core::mem::take(&mut self.released));
            self.loader.prune();
        }
    }

    /// Gives up distant landscape while too much memory is taken.
    fn keep_ceiling(&mut self, world: &mut World) {
        let total = |held: &BTreeMap<BlockId, Held>| held.values().map(|h| h.bytes).sum::<usize>();
        let assets = world.records().assets.bytes();
        let mut bytes = total(&self.held) + assets;
        self.stats.peak_bytes = self.stats.peak_bytes.max(bytes);
        while bytes > self.settings.memory_ceiling {
            let center = self.window.map(|w| w.center);
            let farthest = self
                .held
                .iter()
                .filter(|&(id, held)| held.bytes > 0 && !self.known.contains_key(id) && !self.is_near(*id))
                .max_by_key(|&(&id, held)| (center.map_or(0, |c| apart(id, c)), held.bytes))
                .map(|(&id, _)| id);
            let Some(id) = farthest else { break };
            self.held.remove(&id);
            self.released.extend(world.distant().remove(&id));
            self.stats.evicted += 1;
            self.full_up = true;
            bytes = total(&self.held) + assets;
        }
        self.stats.bytes = bytes;
    }

    /// Blocks that are kept whatever they take.
    fn is_near(&self, id: BlockId) -> bool {
        let named = |p: &Option<Position>| p.is_some_and(|p| p.cell.block() == id);
        named(&self.wanted)
            || named(&self.current)
            || self.window.is_some_and(|w| apart(id, w.center) <= FULL_DETAIL)
    }

    /// Asks for what is missing, the nearest first.
    fn request(&mut self) {
        let limit = if self.settings.threaded {
            self.settings.in_flight.max(1)
        } else {
            1
        };
        if self.in_flight.len() >= limit {
            return;
        }
        for position in [self.wanted, self.current].into_iter().flatten() {
            if position.cell.block().is_on_map() {
                self.ask(position.cell.block(), true);
            } else if self.wanted == Some(position) {
                // Nowhere: nothing can become resident.
                self.wanted = None;
            }
        }
        let Some(window) = self.window else { return };
        let reach = window.radius.max(PREFETCHED);
        let wide = LandscapeWindow {
            center: window.center,
            radius: reach,
        };
        for ring in 0..=reach {
            let no_room = self.full_up || self.stats.bytes + ROOM > self.settings.memory_ceiling;
            if ring > FULL_DETAIL && no_room {
                return;
            }
            for id in wide.blocks().filter(|&id| apart(id, window.center) == ring) {
                self.ask(id, ring <= PREFETCHED);
                if self.in_flight.len() >= limit {
                    return;
                }
            }
        }
    }

    fn ask(&mut self, id: BlockId, full: bool) {
        let enough = self.held.get(&id).is_some_and(|held| held.full || !full);
        if !enough && !self.in_flight.contains(&id) {
            self.in_flight.insert(id);
            self.loader.load(id, full);
        }
    }
}

/// Memory that is left free below the ceiling before distant landscape is asked for, bytes.
const ROOM: usize = 1 << 20;

/// What is in one ascending list and not in the other.
fn differences(a: &[CellId], b: &[CellId]) -> Vec<CellId> {
    let (mut i, mut k) = (0, 0);
    let mut out = Vec::new();
    while let (Some(&x), Some(&y)) = (a.get(i), b.get(k)) {
        if x == y {
            (i, k) = (i + 1, k + 1);
        } else if x < y {
            out.push(x);
            i += 1;
        } else {
            out.push(y);
            k += 1;
        }
    }
    out.extend(a.get(i..).unwrap_or_default());
    out.extend(b.get(k..).unwrap_or_default());
    out
}

/// Lets the shadow lists of a block and of those around it be made anew (`world.md` 14 H4).
fn forget_shadows(world: &mut World, id: BlockId) {
    for dx in -1..=1 {
        for dy in -1..=1 {
            let Some(block) = id.neighbour(dx, dy).and_then(|near| world.block_mut(near)) else {
                continue;
            };
            block.shadows.take();
            if block.id == id || block.reach.get().is_some_and(|reach| reach.touches(id)) {
                block.reach.take();
            }
        }
    }
}

fn forget_own_shadows(block: &mut Landblock) {
    block.shadows.take();
    block.reach.take();
}

impl core::fmt::Debug for CellManager {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("CellManager")
            .field("current", &self.current.map(|p| p.cell))
            .field("stats", &self.stats())
            .finish_non_exhaustive()
    }
}
