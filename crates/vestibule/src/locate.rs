//! Where a point is: its cell, the cells around it, the ground and the water under it.

use glam::Vec3;
use serde::Serialize;
use vestibule_world::constants::FLOOR_Z;
use vestibule_world::terrain::vertex_index;
use vestibule_world::{
    CellArray, CellId, MapCoordinates, PortalTarget, Position, Sphere, Water, World, adjust_position,
    find_cell_list,
};

/// Centres of a player's spheres above the feet, metres (`evidence.md` E4).
pub const PLAYER_SPHERE_CENTERS: [f32; 2] = [0.475, 1.35];
/// Radius of a player's spheres, metres (`evidence.md` E4).
pub const PLAYER_SPHERE_RADIUS: f32 = 0.48;

/// The spheres of a player whose feet are at `feet`.
pub fn player_spheres(feet: Vec3) -> [Sphere; 2] {
    PLAYER_SPHERE_CENTERS.map(|z| Sphere::new(feet + Vec3::new(0.0, 0.0, z), PLAYER_SPHERE_RADIUS))
}

/// What is known about a place, from [`locate`].
#[derive(Clone, Debug, Serialize)]
pub struct Location {
    /// The position asked for.
    pub position: String,
    /// Its map coordinates.
    pub map: String,
    /// The cell it names, and whether the world has it.
    pub named: CellSummary,
    /// The cell that a body placed here would be in (retail `AdjustPosition`), if any.
    pub placed_in: Option<CellSummary>,
    /// The cell that holds the centre of the lower sphere of a player standing here, seeded from the cell placed in.
    pub containing: Option<CellSummary>,
    /// All cells that the player's spheres touch, in retail's order.
    pub touching: Vec<String>,
    /// Every env cell of the landblock that holds that centre. More than one means that cells overlap here.
    pub env_cells_here: Vec<String>,
    /// Cells next to the containing cell, with the way there.
    pub neighbours: Vec<Neighbour>,
    /// The ground under or over the place, if there is terrain.
    pub ground: Option<GroundSummary>,
    /// Static objects that reach into the containing cell.
    pub statics: Vec<StaticSummary>,
    /// What could not be loaded around here.
    pub problems: Vec<String>,
}

/// A cell in a few words.
#[derive(Clone, Debug, Serialize)]
pub struct CellSummary {
    /// Its id.
    pub cell: String,
    /// `land cell` or `env cell`.
    pub kind: &'static str,
    /// Whether the world has it.
    pub exists: bool,
    /// Env cells: whether the landscape can be seen from it.
    pub seen_outside: Option<bool>,
    /// Env cells: structure it is made of, as environment and key.
    pub structure: Option<String>,
    /// Land cells: the model of the building on it.
    pub building: Option<String>,
}

/// A cell next to another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Neighbour {
    /// Its id, or `outside`.
    pub cell: String,
    /// The way there: a portal, a building portal, or the side of a land cell.
    pub way: String,
    /// How far the feet are from the middle of the portal, metres.
    pub distance: Option<f32>,
}

/// Ground at a place.
#[derive(Clone, Debug, Serialize)]
pub struct GroundSummary {
    /// The land cell.
    pub cell: String,
    /// Height of the ground, metres.
    pub z: f32,
    /// How far the place is above it, metres; negative below.
    pub above: f32,
    /// Slope, degrees.
    pub slope: f32,
    /// Whether one can stand on it.
    pub walkable: bool,
    /// Water of the land cell: none, partly, entirely.
    pub water: &'static str,
    /// How far a body sinks in here, metres.
    pub water_depth: f32,
    /// Terrain types of the corners SW, SE, NE, NW.
    pub terrain: [String; 4],
    /// Whether a corner has a road.
    pub road: bool,
}

/// A static object.
#[derive(Clone, Debug, Serialize)]
pub struct StaticSummary {
    /// Setup or GfxObj.
    pub id: String,
    /// Where it stands.
    pub position: String,
}

/// Tells where a place is. `feet` is taken as the foot point of a player.
pub fn locate(world: &World, feet: &Position) -> Location {
    let low = Vec3::new(0.0, 0.0, PLAYER_SPHERE_CENTERS[0]);
    let unturned = Position::new(feet.cell, feet.origin());
    let placed = adjust_position(world, &unturned, low, true).filter(|p| p.resident);
    let seed = placed.map_or(unturned, |p| p.position);
    let spheres = player_spheres(seed.origin());
    let mut array = CellArray::new();
    let found = find_cell_list(world, seed.cell, seed.origin(), &spheres, &mut array, true);
    let center = spheres[0].center;
    let env_cells_here = world
        .block(seed.cell.block())
        .into_iter()
        .flat_map(|block| block.env_cells())
        .filter(|cell| cell.contains_point(center))
        .map(|cell| cell.id.to_string())
        .collect();
    let around = found.containing.unwrap_or(seed.cell);
    Location {
        position: feet.to_string(),
        map: MapCoordinates::of(feet).to_string(),
        named: summary(world, feet.cell),
        placed_in: placed.map(|p| summary(world, p.position.cell)),
        containing: found.containing.map(|cell| summary(world, cell)),
        touching: array.entries().iter().map(|e| e.id.to_string()).collect(),
        env_cells_here,
        neighbours: neighbours(world, around, &seed),
        ground: ground(world, &seed),
        statics: world
            .statics_in(around)
            .iter()
            .filter_map(|&r| world.static_object(r))
            .map(|object| StaticSummary {
                id: format!("0x{:08X}", object.shape.id),
                position: Position {
                    cell: object.cell,
                    frame: object.frame,
                }
                .to_string(),
            })
            .collect(),
        problems: world.problems().iter().map(ToString::to_string).collect(),
    }
}

fn summary(world: &World, id: CellId) -> CellSummary {
    let env_cell = world.env_cell(id);
    CellSummary {
        cell: id.to_string(),
        kind: if id.is_indoor() { "env cell" } else { "land cell" },
        exists: world.is_resident(id),
        seen_outside: env_cell.map(|cell| cell.seen_outside),
        structure: env_cell
            .map(|cell| format!("0x{:08X} {}", cell.structure.environment, cell.structure.key)),
        building: world
            .building_on(id)
            .map(|building| format!("0x{:08X}", building.model_id)),
    }
}

fn neighbours(world: &World, id: CellId, feet: &Position) -> Vec<Neighbour> {
    let mut out = Vec::new();
    if let Some(cell) = world.env_cell(id) {
        let here = feet.origin();
        for portal in &cell.portals {
            let vertices = cell.portal_vertices(portal);
            let middle = vertices.iter().copied().sum::<Vec3>() / vertices.len().max(1) as f32;
            let distance = (cell.frame.local_to_global(middle) - here).length();
            out.push(Neighbour {
                cell: match portal.other {
                    PortalTarget::Outside => "outside".to_owned(),
                    PortalTarget::Cell(other) => other.to_string(),
                },
                way: format!("portal {}", portal.record_index),
                distance: Some(distance),
            });
        }
        return out;
    }
    let Some(at) = id.land_coord() else { return out };
    for (side, dx, dy) in [("north", 0, 1), ("east", 1, 0), ("south", 0, -1), ("west", -1, 0)] {
        let next = vestibule_world::LandCoord {
            x: at.x + dx,
            y: at.y + dy,
        };
        if let Some(next) = next.in_bounds() {
            let way = format!("to the {side}");
            out.push(Neighbour {
                cell: next.cell_id().to_string(),
                way,
                distance: None,
            });
        }
    }
    if let Some(building) = world.building_on(id) {
        for (index, portal) in building.portals.iter().enumerate() {
            let way = format!("portal {index} of the building");
            out.push(Neighbour {
                cell: portal.other.to_string(),
                way,
                distance: None,
            });
        }
    }
    out
}

fn ground(world: &World, feet: &Position) -> Option<GroundSummary> {
    let ground = world.ground_at(feet.cell, feet.origin())?;
    let normal = ground.polygon.plane.normal;
    let land = world.block(ground.cell.block())?.land.as_ref()?;
    let (cx, cy) = (
        usize::from((ground.cell.low() - 1) >> 3),
        usize::from((ground.cell.low() - 1) & 7),
    );
    let corners = [(cx, cy), (cx + 1, cy), (cx + 1, cy + 1), (cx, cy + 1)];
    let words = corners.map(|(i, j)| land.words.get(vertex_index(i, j)).copied().unwrap_or_default());
    Some(GroundSummary {
        cell: ground.cell.to_string(),
        z: ground.z,
        above: feet.origin().z - ground.z,
        slope: libm::acosf(normal.z.clamp(-1.0, 1.0)).to_degrees(),
        walkable: normal.z >= FLOOR_Z,
        water: match ground.land_cell.water {
            Water::Not => "none",
            Water::Partially => "partly",
            Water::Entirely => "entirely",
        },
        water_depth: ground.water_depth(),
        terrain: words.map(|w| terrain_name(w.terrain_type()).to_owned()),
        road: words.iter().any(|w| w.road() != 0),
    })
}

/// Name of a terrain type (`world.md` A1).
pub fn terrain_name(terrain_type: u8) -> &'static str {
    const NAMES: [&str; 32] = [
        "barren rock",
        "grassland",
        "ice",
        "lush grass",
        "marsh",
        "mud",
        "obsidian",
        "packed dirt",
        "patchy dirt",
        "patchy grass",
        "yellow sand",
        "grey sand",
        "rocky sand",
        "sedimentary rock",
        "semi-barren",
        "snow",
        "running water",
        "standing fresh water",
        "shallow sea",
        "shallow still sea",
        "deep sea",
        "forest floor",
        "faux water",
        "sea slime",
        "argila",
        "volcano 1",
        "volcano 2",
        "blue ice",
        "moss",
        "dark moss",
        "olthoi",
        "desolate",
    ];
    NAMES.get(usize::from(terrain_type)).copied().unwrap_or("unknown")
}
