//! The scene whose parts synthetic worlds are copies of.

use std::collections::BTreeMap;
use std::fmt::Write;

use glam::{DVec2, DVec3};
use vestibule_dat::record::{Building, EnvCell, Environment, LandBlockInfo};
use vestibule_world::{BlockId, CellId};

use super::SyntheticError;
use super::dungeon::SIDES;
use super::stamp::House;
use crate::compile::{CompiledWorld, compile};

/// Distance of dungeon rooms, and of levels, metres.
pub(super) const PITCH: f64 = 10.0;
pub(super) const LEVEL: f64 = 5.0;
/// Height of a room, and width and height of its doors.
const ROOM_HEIGHT: f64 = 4.5;
const DOOR: (f64, f64) = (3.0, 2.9);
/// Rooms of a house.
const HOUSE_PITCH: f64 = 5.0;

/// A kind of house.
pub(super) struct HouseKind {
    /// Rooms from west to east and from south to north.
    rooms: (usize, usize),
    /// Rooms with a way out: column, row, side.
    exits: &'static [(usize, usize, usize)],
    /// How many of a hundred houses are of this kind.
    pub(super) percent: u32,
}

/// 3.1 portals a building (`evidence.md` E3).
pub(super) const HOUSES: [HouseKind; 3] = [
    HouseKind {
        rooms: (2, 1),
        exits: &[(0, 0, 2), (1, 0, 0)],
        percent: 25,
    },
    HouseKind {
        rooms: (2, 2),
        exits: &[(0, 0, 2), (1, 1, 0), (1, 0, 1)],
        percent: 40,
    },
    HouseKind {
        rooms: (3, 3),
        exits: &[(1, 0, 2), (1, 2, 0), (2, 1, 1), (0, 1, 3)],
        percent: 35,
    },
];

/// How doors of a dungeon look, and how its rooms are turned against their own axes.
pub(super) struct Style {
    /// Doors with six corners instead of four.
    arched: bool,
    turn_degrees: f64,
    /// How many of a hundred dungeons.
    pub(super) percent: u32,
}

/// 26 of a hundred portals are no quads, 9 not along the axes (`evidence.md` E3).
pub(super) const STYLES: [Style; 3] = [
    Style {
        arched: false,
        turn_degrees: 0.0,
        percent: 65,
    },
    Style {
        arched: true,
        turn_degrees: 0.0,
        percent: 26,
    },
    Style {
        arched: false,
        turn_degrees: 30.0,
        percent: 9,
    },
];

impl Style {
    /// A point of the plan in the coordinates of the dungeon.
    pub(super) fn turned(&self, p: DVec3) -> DVec3 {
        let angle = self.turn_degrees.to_radians();
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        DVec3::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z)
    }
}

/// A cell structure of a dungeon with what its cells need.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// The cell it was compiled to.
    pub(super) cell: EnvCell,
    /// For each side with a door, ascending: the portal's flags and polygon.
    pub(super) doors: Vec<(u16, u16)>,
}

/// The compiled palette.
pub(super) struct Palette {
    /// The portal file of every synthetic world.
    pub(super) portal: BTreeMap<u32, Vec<u8>>,
    pub(super) houses: Vec<House>,
    /// For each style the rooms by their doors (bits), then the ramps by the side they rise to.
    pub(super) rooms: Vec<BTreeMap<u8, Piece>>,
    pub(super) ramps: Vec<Vec<Piece>>,
    /// Models for the land and for dungeons.
    pub(super) outdoors: Vec<u32>,
    pub(super) indoors: Vec<u32>,
    /// Corners of the polygons of each structure.
    corners: BTreeMap<(u32, u16, u16), usize>,
}

const HOUSE_BLOCK: u16 = 0x8080;
const DUNGEON_BLOCK: u16 = 0x0101;

impl Palette {
    pub(super) fn compile() -> Result<Self, SyntheticError> {
        let text = scene();
        let world = compile(&[("palette.scene", &text)])?;
        let mut palette = Palette {
            houses: Vec::new(),
            rooms: Vec::new(),
            ramps: Vec::new(),
            outdoors: Vec::new(),
            indoors: Vec::new(),
            corners: BTreeMap::new(),
            portal: world.portal.clone(),
        };
        for (&id, bytes) in world.portal.range(0x0D00_0000..0x0E00_0000) {
            for structure in Environment::parse(id, bytes)?.cell_structs {
                for polygon in &structure.polygons {
                    let key = (id, structure.id as u16, polygon.id);
                    palette.corners.insert(key, polygon.vertex_ids.len());
                }
            }
        }
        for k in 0..HOUSES.len() {
            palette.houses.push(house(&world, k)?);
        }
        for (s, style) in STYLES.iter().enumerate() {
            let mut rooms = BTreeMap::new();
            for doors in 1..16u8 {
                rooms.insert(doors, piece(&world, style, &format!("palette{s}.m{doors}"))?);
            }
            palette.rooms.push(rooms);
            let ramps = (0..4).map(|side| piece(&world, style, &format!("palette{s}.r{side}")));
            palette.ramps.push(ramps.collect::<Result<_, _>>()?);
        }
        let info = info_of(&world, HOUSE_BLOCK)?;
        palette.outdoors = info.objects.iter().map(|o| o.id).collect();
        let furnished = cell_of(&world, "palette0.m1")?;
        palette.indoors = furnished.statics.iter().map(|o| o.id).collect();
        if palette.outdoors.is_empty() || palette.indoors.is_empty() {
            return Err(SyntheticError::Incomplete("its models".to_owned()));
        }
        Ok(palette)
    }

    /// Whether a polygon has four corners.
    pub(super) fn is_quad(&self, environment: u32, structure: u16, polygon: u16) -> bool {
        self.corners.get(&(environment, structure, polygon)) == Some(&4)
    }
}

fn missing(what: &str) -> SyntheticError {
    SyntheticError::Incomplete(what.to_owned())
}

fn info_of(world: &CompiledWorld, block: u16) -> Result<LandBlockInfo, SyntheticError> {
    let id = BlockId(block).info_record();
    let bytes = world.cell.get(&id).ok_or_else(|| missing("a landblock"))?;
    Ok(LandBlockInfo::parse(id, bytes)?)
}

fn cell_of(world: &CompiledWorld, name: &str) -> Result<EnvCell, SyntheticError> {
    let id = world.cell_named(name).ok_or_else(|| missing(name))?.0;
    let bytes = world.cell.get(&id).ok_or_else(|| missing(name))?;
    Ok(EnvCell::parse(id, bytes)?)
}

fn house(world: &CompiledWorld, k: usize) -> Result<House, SyntheticError> {
    let block = HOUSE_BLOCK + ((k as u16) << 8);
    let mut info = info_of(world, block)?;
    let building: Building = info.buildings.pop().ok_or_else(|| missing("a house"))?;
    let mut cells = Vec::new();
    for low in 0..info.num_cells as u16 {
        let id = CellId::new(BlockId(block), 0x100 + low).0;
        let bytes = world.cell.get(&id).ok_or_else(|| missing("a room of a house"))?;
        cells.push(EnvCell::parse(id, bytes)?);
    }
    Ok(House { building, cells })
}

/// A piece, its doors found by the direction in which their polygons lie.
fn piece(world: &CompiledWorld, style: &Style, name: &str) -> Result<Piece, SyntheticError> {
    let cell = cell_of(world, name)?;
    let bytes = world.portal.get(&cell.environment).ok_or_else(|| missing(name))?;
    let environment = Environment::parse(cell.environment, bytes)?;
    let structure = environment
        .cell_struct(u32::from(cell.cell_struct))
        .ok_or_else(|| missing(name))?;
    let vertices = &structure.vertices.vertices;
    let mut doors: Vec<(usize, u16, u16)> = Vec::new();
    for portal in &cell.portals {
        let polygon = structure.polygons.iter().find(|p| p.id == portal.polygon_id);
        let corners = polygon.map_or(&[][..], |p| &p.vertex_ids);
        let sum: glam::Vec3 = corners
            .iter()
            .filter_map(|&id| vertices.get(usize::from(id)))
            .map(|v| v.origin)
            .sum();
        let side = (0..4).max_by(|&a, &b| {
            let along = |side: usize| {
                let (dx, dy) = SIDES[side];
                style
                    .turned(DVec3::new(f64::from(dx), f64::from(dy), 0.0))
                    .dot(sum.as_dvec3())
            };
            along(a).total_cmp(&along(b))
        });
        doors.push((side.unwrap_or(0), portal.flags, portal.polygon_id));
    }
    doors.sort_unstable();
    let doors = doors
        .into_iter()
        .map(|(_, flags, polygon)| (flags, polygon))
        .collect();
    Ok(Piece { cell, doors })
}

/// Text of the scene.
fn scene() -> String {
    let mut out = String::from(
        r#"scene "Palette"
land 0x8080 0x8780
heights 2
terrain {
    base 40
    paint grassland everywhere
    paint packed_dirt box (0 0) (192 192)
    paint standing_water box (1344 0) (1536 192)
}
material stone blocks color 148 142 132 second 96 90 84 size 2
material brick bricks color 150 92 70 second 150 140 126 size 1.6
material flags cobbles color 138 132 120 second 92 88 80 size 2.4
material plaster plaster color 226 214 190 second 198 184 158 size 2.5
material boards planks color 148 110 70 second 78 54 34 size 1.6
material rock rock color 128 118 108 second 86 80 76 size 4
material leaves leaves color 84 116 52 second 48 78 36 size 1.4
material bark bark color 104 84 62 second 70 54 40 size 0.7
material flame glow color 255 190 96 size 1
model crate { box (-0.25 -0.25 0) (0.25 0.25 0.5); material boards }
model pillar { column (0 0 0) 0.35 4 8; material stone }
model boulder { ball (0 0 0.6) 1.4 1.2 1; material rock }
model tree {
    column (0 0 0) 0.3 5 6 bark
    ball (0 0 6) 2
    material leaves
    collide cylinder 0.4 8
}
static tree at (120 120 ~0)
static boulder at (140 120 ~0)
"#,
    );
    for (k, kind) in HOUSES.iter().enumerate() {
        write_house(&mut out, k, kind);
    }
    for (s, style) in STYLES.iter().enumerate() {
        write_dungeon(&mut out, s, style);
    }
    out
}

/// A house of equal rooms, with a niche as deep as the wall for each way out.
fn write_house(out: &mut String, k: usize, kind: &HouseKind) {
    let (nx, ny) = kind.rooms;
    let low = DVec2::new(nx as f64, ny as f64) * HOUSE_PITCH * -0.5;
    let corner = |i: usize, j: usize| low + DVec2::new(i as f64, j as f64) * HOUSE_PITCH;
    let wall = 0.4;
    let _ = writeln!(
        out,
        "building house{k} at ({} 36 ~0.05) {{",
        k as f64 * 192.0 + 36.0
    );
    let (a, b) = (corner(0, 0) - wall, corner(nx, ny) + wall);
    let _ = writeln!(
        out,
        "    shell {{ box ({} {} -1) ({} {} 3.6); material brick }}",
        a.x, a.y, b.x, b.y
    );
    for i in 0..nx {
        for j in 0..ny {
            let (a, b) = (corner(i, j), corner(i + 1, j + 1));
            let _ = writeln!(
                out,
                "    room h{i}{j} {{ box ({} {} 0) ({} {} 3.2); floor boards; walls plaster; ceiling boards }}",
                a.x, a.y, b.x, b.y
            );
        }
    }
    for (e, &(i, j, side)) in kind.exits.iter().enumerate() {
        let middle = (corner(i, j) + corner(i + 1, j + 1)) * 0.5;
        let (dx, dy) = SIDES[side];
        let d = DVec2::new(f64::from(dx), f64::from(dy));
        let across = DVec2::new(d.y, d.x).abs() * 0.9;
        let face = middle + d * HOUSE_PITCH * 0.5;
        let (p, q) = (face - across, face + across + d * wall);
        let (p, q) = (p.min(q), p.max(q));
        let _ = writeln!(
            out,
            "    room e{e} {{ box ({} {} 0) ({} {} 2.4); material stone; floor flags }}\n    exit e{e}\n    opening e{e} h{i}{j}",
            p.x, p.y, q.x, q.y
        );
    }
    for i in 0..nx {
        for j in 0..ny {
            let (a, b) = (corner(i, j), corner(i + 1, j + 1));
            let m = (a + b) * 0.5;
            if i + 1 < nx {
                let _ = writeln!(
                    out,
                    "    opening h{i}{j} h{}{j} rect ({x} {} 0) ({x} {} 2.3)",
                    i + 1,
                    m.y - 0.8,
                    m.y + 0.8,
                    x = b.x
                );
            }
            if j + 1 < ny {
                let _ = writeln!(
                    out,
                    "    opening h{i}{j} h{i}{} rect ({} {y} 0) ({} {y} 2.3)",
                    j + 1,
                    m.x - 0.8,
                    m.x + 0.8,
                    y = b.y
                );
            }
        }
    }
    let at = corner(0, 0) + 0.8;
    let _ = writeln!(out, "    static crate in h00 at ({} {} 0)\n}}", at.x, at.y);
}

fn point(style: &Style, p: DVec3) -> String {
    let q = style.turned(p);
    format!("({} {} {})", q.x, q.y, q.z)
}

/// The corners of a door in the wall at `middle`, which is looked through along `d`.
fn door(style: &Style, middle: DVec3, d: DVec3) -> String {
    let across = DVec3::new(d.y.abs(), d.x.abs(), 0.0) * (DOOR.0 * 0.5);
    let up = DVec3::Z * DOOR.1;
    let mut corners = vec![middle - across, middle + across];
    if style.arched {
        let shoulder = DVec3::Z * (DOOR.1 - 0.9);
        corners.extend([middle + across + shoulder, middle + across * 0.4 + up]);
        corners.extend([middle - across * 0.4 + up, middle - across + shoulder]);
    } else {
        corners.extend([middle + across + up, middle - across + up]);
    }
    let written: Vec<String> = corners.into_iter().map(|p| point(style, p)).collect();
    written.join(" ")
}

/// For each set of doors a room with stubs behind them, and the four ramps between stubs.
fn write_dungeon(out: &mut String, s: usize, style: &Style) {
    let block = DUNGEON_BLOCK + s as u16;
    let _ = writeln!(out, "dungeon palette{s} 0x{block:04X} at (0 0 -100) {{");
    let half = PITCH * 0.5;
    let paint = "floor flags; walls stone; ceiling rock";
    // Rooms are written about their own origin, so that equal ones come out equal.
    let room = |out: &mut String, name: &str, at: DVec3| {
        let mut corners = String::new();
        for (x, y, z) in (0..8).map(|k| (k & 1, k >> 1 & 1, k >> 2)) {
            let p = DVec3::new(
                f64::from(2 * x - 1) * half,
                f64::from(2 * y - 1) * half,
                f64::from(z) * ROOM_HEIGHT,
            );
            corners += &point(style, p);
            corners.push(' ');
        }
        let _ = writeln!(
            out,
            "    room {name} at {} {{ hull {corners}; {paint} }}",
            point(style, at)
        );
    };
    let toward = |side: usize| DVec3::new(f64::from(SIDES[side].0), f64::from(SIDES[side].1), 0.0);
    for doors in 1..16usize {
        let at = DVec3::new(doors as f64 * 40.0, 0.0, 0.0);
        room(out, &format!("m{doors}"), at);
        for side in (0..4).filter(|side| doors >> side & 1 == 1) {
            let d = toward(side);
            room(out, &format!("m{doors}s{side}"), at + d * PITCH);
            let shape = door(style, at + d * half, d);
            let _ = writeln!(out, "    opening m{doors} m{doors}s{side} poly {shape}");
        }
    }
    for side in 0..4usize {
        let at = DVec3::new(side as f64 * 60.0, 80.0, 0.0);
        let d = toward(side);
        let across = DVec3::new(d.y.abs(), d.x.abs(), 0.0) * (DOOR.0 * 0.5);
        let mut corners = String::new();
        for (end, z) in [(-half, 0.0), (half, LEVEL)] {
            for edge in [across, -across] {
                for top in [0.0, DOOR.1] {
                    corners += &point(style, d * end + edge + DVec3::Z * (z + top));
                    corners.push(' ');
                }
            }
        }
        let _ = writeln!(
            out,
            "    room r{side} at {} {{ hull {corners}; {paint} }}",
            point(style, at)
        );
        for (name, end, z) in [("low", -1.0, 0.0), ("high", 1.0, LEVEL)] {
            let up = DVec3::Z * z;
            room(out, &format!("r{side}{name}"), at + d * (PITCH * end) + up);
            let shape = door(style, at + d * (half * end) + up, d);
            let _ = writeln!(out, "    opening r{side} r{side}{name} poly {shape}");
        }
    }
    let corner = point(style, DVec3::new(40.0 - 3.5, -3.5, 0.0));
    let _ = writeln!(out, "    static crate in m1 at {corner}");
    let corner = point(style, DVec3::new(40.0 + 3.5, -3.5, 0.0));
    let _ = writeln!(out, "    static pillar in m1 at {corner}\n}}");
}
