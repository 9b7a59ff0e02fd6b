//! What is done with hostile input: by the tests of this crate with inputs of their own making, and by the fuzz
//! targets (`fuzz/`) with those of a fuzzer. Nothing here may panic, hang or take much memory.
#![allow(dead_code, reason = "each test and fuzz target uses a part of it")]

use glam::{Quat, Vec2, Vec3};
use vestibule::conform::Case;
use vestibule_dat::record::{Record, lint};
use vestibule_dat::{
    DatBuilder, DatEditor, DatFile, DatKind, DatSet, EditOptions, Header, Limits, RecordKind, WriteOptions,
};
use vestibule_physics::{
    Body, Carried, Motion, Mover, Placement, Population, Scratch, SetPositionFlags, place, sweep,
};
use vestibule_view::{Camera, FloodArena, FloodSettings, LookIns, Openings, PView, Region};
use vestibule_world::{
    BlockId, CellArray, CellId, Frame, MapCoordinates, MemoryRecords, Position, Sphere, Store, World,
    adjust_position, find_cell_list,
};

/// Every operation on the bytes of a container.
pub(crate) fn container(bytes: &[u8]) {
    let limits = Limits { inflated: 1 << 20 };
    if let Ok(dat) = DatFile::from_bytes("fuzzed", bytes).map(|dat| dat.with_limits(limits)) {
        let report = dat.verify();
        let _ = (report.is_clean(), dat.iteration());
        let mut buffer = Vec::new();
        for entry in dat.iter().take(2_000).flatten() {
            let read = dat.read(&entry).ok().map(|bytes| bytes.into_owned());
            if let Ok(Some(_)) = dat.read_into(entry.id, &mut buffer) {
                assert_eq!(
                    read.as_deref(),
                    Some(&buffer[..]),
                    "two ways to read record 0x{:08X}",
                    entry.id
                );
            }
            let _ = dat.record(entry.id);
        }
        let _ = dat.range(0x0100_0000..0x0D00_0000).take(2_000).count();
        let _ = (dat.find(0), dat.find(u32::MAX), dat.get(0x0D00_0001));
    }
    edit(bytes);
}

/// Edits a damaged file: what the editor accepts it must leave readable.
fn edit(bytes: &[u8]) {
    let mut storage = bytes.to_vec();
    let Ok(mut editor) = DatEditor::edit("fuzzed", &mut storage, EditOptions::default()) else {
        return;
    };
    let written = [0xAB; 700];
    let put = editor
        .put(0x0500_1234, &written, &WriteOptions::default())
        .is_ok();
    let _ = editor.delete(0x0100_0001);
    let _ = editor.put(0x0D00_0001, &[1, 2, 3], &WriteOptions::default());
    let committed = editor.commit().is_ok();
    drop(editor);
    if put && committed {
        let dat = DatFile::from_bytes("edited", storage).expect("a committed file opens");
        let back = dat.get(0x0500_1234).expect("a committed record can be read");
        assert_eq!(back.as_deref(), Some(&written[..]));
    }
}

/// A record: the first byte selects the type, the rest are its bytes. What parses must encode and parse again to
/// the same, and lint must come back.
pub(crate) fn record(bytes: &[u8]) {
    let Some((&selector, bytes)) = bytes.split_first() else {
        return;
    };
    let kind = RecordKind::ALL[usize::from(selector) % RecordKind::ALL.len()];
    let id = bytes.first_chunk().map_or(0, |b| u32::from_le_bytes(*b));
    let Ok(parsed) = Record::parse(kind, id, bytes) else {
        return;
    };
    let _ = lint::lint(id, &parsed);
    if let Ok(encoded) = parsed.encode() {
        let again = Record::parse(kind, id, &encoded).expect("an encoded record parses");
        // Compared as bytes: a NaN is not equal to itself.
        assert_eq!(again.encode().expect("and encodes"), encoded, "{kind:?}");
    }
}

/// Text that people type, and vectors.
pub(crate) fn text(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    if let Ok(position) = text.parse::<Position>()
        && position.is_finite()
    {
        let back: Position = position
            .to_string()
            .parse()
            .expect("a printed position reads back");
        assert_eq!(back.cell, position.cell);
        let _ = (position.adjusted_to_outside(), MapCoordinates::of(&position));
    }
    if let Ok(at) = text.parse::<MapCoordinates>() {
        let _ = at.to_position(0.0);
        assert!(at.to_string().parse::<MapCoordinates>().is_ok(), "{at}");
    }
    if let Ok(id) = text.parse::<CellId>() {
        assert_eq!(id.to_string().parse(), Ok(id));
    }
    let _ = serde_json::from_str::<Case>(text);
}

/// The bytes of the portal and the cell file of the built-in world.
pub(crate) fn embedded_files() -> (Vec<u8>, Vec<u8>) {
    let dats = vestibule::open_dats(None).expect("the embedded world opens");
    let bytes = |kind: DatKind, file: &DatFile| {
        let mut out = DatBuilder::new(kind.file_name(), Vec::new(), Header::new(kind))?;
        out.without_iteration_record();
        out.push_all(file)?;
        out.finish()
    };
    let portal = bytes(DatKind::Portal, dats.portal()).expect("a portal file");
    (portal, bytes(DatKind::Cell, dats.cell()).expect("a cell file"))
}

/// All records of a pair of files.
pub(crate) fn records_of(dats: &DatSet) -> MemoryRecords {
    let mut records = MemoryRecords::new();
    for (store, file) in [(Store::Cell, dats.cell()), (Store::Portal, dats.portal())] {
        for entry in file.iter().flatten() {
            if let Ok(bytes) = file.read(&entry) {
                records.insert(store, entry.id, bytes.into_owned());
            }
        }
    }
    records
}

/// Changes records as told by `script`, seven bytes a change: which record (2), what to do (1), where (2), a value
/// (2).
pub(crate) fn mutate(records: &mut MemoryRecords, script: &[u8]) {
    let ids: Vec<(Store, u32)> = records.iter().map(|(store, id, _)| (store, id)).collect();
    if ids.is_empty() {
        return;
    }
    for change in script.chunks_exact(7).take(64) {
        let word = |at: usize| usize::from(u16::from_le_bytes([change[at], change[at + 1]]));
        let (store, id) = ids[word(0) % ids.len()];
        let Some(mut bytes) = records
            .iter()
            .find(|r| (r.0, r.1) == (store, id))
            .map(|r| r.2.to_vec())
        else {
            continue;
        };
        let (action, value) = (change[2], word(5));
        let at = if bytes.is_empty() {
            0
        } else {
            word(3) % bytes.len()
        };
        change_bytes(&mut bytes, action, at, value);
        match action {
            250..=252 => drop(records.remove(store, id)),
            253.. => {
                // Another record's bytes under this id.
                let (other_store, other) = ids[value % ids.len()];
                let found = records.iter().find(|r| (r.0, r.1) == (other_store, other));
                if let Some(bytes) = found.map(|r| r.2.to_vec()) {
                    records.insert(store, id, bytes);
                }
            }
            _ => records.insert(store, id, bytes),
        }
    }
}

fn change_bytes(bytes: &mut Vec<u8>, action: u8, at: usize, value: usize) {
    const NUMBERS: [u32; 16] = [
        0,
        1,
        2,
        0xFF,
        0x7FFF,
        0xFFFF,
        0x1_0000,
        0x7FFF_FFFF,
        0x8000_0000,
        0xFFFF_FFFF,
        0x7F80_0000, // infinity
        0xFF80_0000,
        0x7FC0_0000, // NaN
        0x7149_F2CA, // 1e30
        0x0000_0001, // the smallest number above 0
        0xBF80_0000, // -1
    ];
    let mut put = |new: &[u8]| {
        for (i, &b) in new.iter().enumerate() {
            if let Some(byte) = bytes.get_mut(at + i) {
                *byte = b;
            }
        }
    };
    match action % 8 {
        0 => put(&[value as u8]),
        1 => put(&(value as u16).to_le_bytes()),
        2 => put(&NUMBERS[value % NUMBERS.len()].to_le_bytes()),
        3 => put(&NUMBERS[value % NUMBERS.len()].to_le_bytes()[..2]),
        4 => put(&((value as f32 - 32_768.0) * 0.01).to_le_bytes()),
        5 => bytes.truncate(at),
        6 => {
            let tail = bytes.split_off(at);
            bytes.extend(std::iter::repeat_n(value as u8, value % 40));
            bytes.extend(tail);
        }
        _ => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << (value % 8);
            }
        }
    }
}

/// Blocks that a world's cell records name, at most `limit`.
pub(crate) fn blocks_of(records: &MemoryRecords, limit: usize) -> Vec<BlockId> {
    let mut blocks: Vec<BlockId> = records
        .iter()
        .filter(|r| r.0 == Store::Cell)
        .map(|r| CellId(r.1).block())
        .collect();
    blocks.dedup();
    blocks.truncate(limit);
    blocks
}

/// Loads every block, asks every look-up, sweeps and looks around from every cell.
pub(crate) fn load_and_walk(world: &World, blocks: &[BlockId]) {
    let mover = Mover::player();
    let mut walker = Walker {
        world,
        mover,
        population: Population::new(),
        scratch: Scratch::new(),
        array: CellArray::new(),
        openings: Openings::new(),
        view: PView::new(FloodSettings::default()),
        look_ins: LookIns::new(),
        arena: FloodArena::new(),
    };
    for &id in blocks {
        let Some(block) = world.block(id) else { continue };
        let _ = (
            block.stab_list(),
            block.looks_like_a_dungeon(),
            world.block_water(id),
        );
        let mut starts: Vec<Position> = block
            .env_cells()
            .take(48)
            .map(|cell| {
                let middle = cell
                    .structure
                    .bounds
                    .map_or(Vec3::ZERO, |b| (b.min + b.max) * 0.5);
                Position::new(cell.id, cell.frame.local_to_global(middle))
            })
            .collect();
        for low in [1u16, 9, 28, 36, 64] {
            let (x, y) = (f32::from((low - 1) / 8), f32::from((low - 1) % 8));
            let p = Vec3::new(x * 24.0 + 11.0, y * 24.0 + 13.0, 0.0);
            let cell = CellId::new(id, low);
            let z = world
                .ground_at(cell, p)
                .map_or(0.0, |ground| ground.z + ground.water_depth());
            starts.push(Position::new(cell, Vec3::new(p.x, p.y, z + 0.005)));
        }
        for building in &block.buildings {
            starts.push(Position::new(building.cell, building.frame.origin));
        }
        for (i, start) in starts.iter().enumerate() {
            walker.visit(start, i);
        }
    }
    let _ = (world.problems(), world.problem_count());
}

struct Walker<'w> {
    world: &'w World,
    mover: Mover,
    population: Population,
    scratch: Scratch,
    array: CellArray,
    openings: Openings,
    view: PView,
    look_ins: LookIns,
    arena: FloodArena,
}

impl Walker<'_> {
    fn visit(&mut self, at: &Position, turn: usize) {
        let world = self.world;
        let spheres = [
            Sphere::new(at.origin() + Vec3::Z * 0.475, 0.48),
            Sphere::new(at.origin() + Vec3::Z * 1.35, 0.48),
        ];
        let list = find_cell_list(world, at.cell, at.origin(), &spheres, &mut self.array, true);
        let entries: Vec<CellId> = self.array.entries().iter().map(|e| e.id).collect();
        for &cell in entries.iter().take(32) {
            for &r in world.statics_in(cell).iter().take(16) {
                let _ = world.static_object(r);
            }
            let _ = world.point_in_cell(cell, at.origin());
        }
        let cell = list.containing.unwrap_or(at.cell);
        let _ = adjust_position(world, at, Vec3::Z * 0.475, turn.is_multiple_of(2));
        let directions = [
            Vec3::X,
            Vec3::Y,
            -Vec3::X,
            -Vec3::Y,
            -Vec3::Z,
            Vec3::new(0.7, 0.7, 0.1),
        ];
        let mut from = Position { cell, ..*at };
        let mut carried = Carried::default();
        for step in 0..4 {
            let mut to = from;
            to.frame.origin += directions[(turn + step) % directions.len()] * 1.3;
            let swept = sweep(
                world,
                &self.population,
                &mut self.scratch,
                &self.mover,
                &carried,
                &from,
                &to,
            );
            if let Ok(swept) = swept
                && swept.ok
                && let Some(cell) = swept.cell
            {
                assert!(
                    swept.position.is_finite(),
                    "a sweep from {from} to {to} ended nowhere"
                );
                from = Position {
                    cell,
                    ..swept.position
                };
                carried = swept.carried();
            }
        }
        let _ = place(
            world,
            &self.population,
            &mut self.scratch,
            &self.mover,
            &from,
            true,
            true,
        );
        if turn.is_multiple_of(4) {
            self.step_bodies(&from);
        }
        self.look(&from, directions[turn % 4]);
    }

    fn step_bodies(&mut self, at: &Position) {
        let mut population = Population::new();
        let ids = [population.add(Body::player()), population.add(Body::player())];
        for (i, &id) in ids.iter().enumerate() {
            let mut there = *at;
            there.frame.origin.x += i as f32;
            let placement = Placement::at(there).with_flags(SetPositionFlags::default());
            let _ = population.set_position(self.world, &mut self.scratch, id, &placement);
            if let Some(body) = population.body_mut(id) {
                body.set_motion(Motion::default());
            }
        }
        for tick in 1..4 {
            for &id in &ids {
                let _ = population.update(self.world, &mut self.scratch, id, f64::from(tick) * 0.1);
            }
        }
    }

    fn look(&mut self, at: &Position, forward: Vec3) {
        let eye = at.origin() + Vec3::Z;
        let Ok(camera) = Camera::new(at.cell, eye, forward, Vec3::Z, 1.2, Vec2::new(320.0, 200.0)) else {
            return;
        };
        let flood = self.view.look(self.world, &self.openings, &camera);
        let _ = (flood.cells().len(), flood.truncated());
        self.look_ins.clear();
        self.arena.clear();
        if let Some(openings) = self.openings.block(self.world, at.cell.block()) {
            let whole = [Region::new(&[])];
            self.view.look_into_block(
                openings,
                &camera,
                whole.into_iter(),
                &mut self.look_ins,
                &mut self.arena,
            );
        }
    }
}

/// A frame with the numbers of `bytes`, whatever they are.
pub(crate) fn frame_of(bytes: &[u8; 28]) -> Frame {
    let mut numbers = [0.0f32; 7];
    for (n, b) in numbers.iter_mut().zip(bytes.chunks_exact(4)) {
        *n = f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    }
    let [x, y, z, qw, qx, qy, qz] = numbers;
    Frame::new(Vec3::new(x, y, z), Quat::from_xyzw(qx, qy, qz, qw))
}

/// Random numbers that are the same everywhere.
pub(crate) struct Draws(pub(crate) u64);

impl Draws {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() >> 11) as usize % n.max(1)
    }

    pub(crate) fn bytes(&mut self, n: usize) -> Vec<u8> {
        (0..n).map(|_| (self.next() >> 23) as u8).collect()
    }
}
