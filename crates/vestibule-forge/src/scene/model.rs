//! The parts of a scene.

use glam::{DVec2, DVec3};
use vestibule_world::BlockId;

use super::{Material, PlaceDef, Placement, TerrainOp};
use crate::geometry::{Polygon, Polytope};
use crate::text::{Span, Word};

/// A whole scene. Map coordinates are metres from the south-west corner of `origin`, x east, y north, z up.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) name: String,
    pub(crate) south_west: BlockId,
    pub(crate) north_east: BlockId,
    pub(crate) origin: BlockId,
    /// Metres per height index.
    pub(crate) height_step: f64,
    pub(crate) terrain: Vec<TerrainOp>,
    pub(crate) materials: Vec<Material>,
    pub(crate) models: Vec<ModelDef>,
    pub(crate) sites: Vec<SiteDef>,
    pub(crate) statics: Vec<StaticDef>,
    pub(crate) scatters: Vec<Scatter>,
    pub(crate) start: Option<Start>,
}

/// Which material a face gets, by the way it faces. For a room `up` is the floor, for a solid its top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Paint {
    pub(crate) up: usize,
    pub(crate) side: usize,
    pub(crate) down: usize,
    /// Faces that face this way (within 20 degrees) are painted otherwise.
    pub(crate) special: Vec<(DVec3, usize)>,
}

impl Paint {
    /// The material of a face whose visible side looks along `normal`.
    pub(crate) fn of(&self, normal: DVec3) -> usize {
        const COS_20: f64 = 0.939_692_620_785_908;
        if let Some((_, material)) = self.special.iter().find(|(n, _)| n.dot(normal) > COS_20) {
            return *material;
        }
        // Down to 30 degrees from level counts as floor or roof.
        match normal.z {
            z if z > 0.5 => self.up,
            z if z < -0.5 => self.down,
            _ => self.side,
        }
    }
}

/// A simple shape as written.
#[derive(Clone, Debug)]
pub(crate) struct SolidDef {
    /// Convex parts.
    pub(crate) parts: Vec<Polytope>,
    /// Or polygons to be closed into a volume, facing its inside.
    pub(crate) polygons: Vec<(Span, Polygon)>,
    /// Material of all its faces, if not the owner's.
    pub(crate) all: Option<usize>,
    /// Material of its upper faces.
    pub(crate) top: Option<usize>,
}

/// Something solid inside a room.
#[derive(Clone, Debug)]
pub(crate) struct Fixture {
    pub(crate) draw: Vec<SolidDef>,
    pub(crate) physics: Vec<SolidDef>,
}

#[derive(Clone, Debug)]
pub(crate) struct RoomDef {
    pub(crate) name: Word,
    /// The id asked for, if any.
    pub(crate) id: Option<(Span, u16)>,
    /// Room to site.
    pub(crate) place: Placement,
    pub(crate) solids: Vec<SolidDef>,
    pub(crate) fixtures: Vec<Fixture>,
    pub(crate) paint: Paint,
}

/// The part of a face that an opening takes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Opening {
    /// All that the two sides share.
    Shared,
    /// This polygon, in site coordinates; the way it faces does not matter.
    Polygon(Polygon),
}

/// A way between two rooms.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub(crate) span: Span,
    pub(crate) from: Word,
    pub(crate) to: Word,
    pub(crate) opening: Opening,
    /// Made by `portal`: leads one way, and wants a partner.
    pub(crate) one_way: bool,
}

/// A way out of a room to the landscape.
#[derive(Clone, Debug)]
pub(crate) struct Exit {
    pub(crate) span: Span,
    pub(crate) from: Word,
    pub(crate) opening: Opening,
    /// Made by `window`: seen through, not walked through.
    pub(crate) pane: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct ShellDef {
    pub(crate) solids: Vec<SolidDef>,
    pub(crate) paint: Paint,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Stands on the landscape and has a shell.
    Building,
    /// Rooms in a landblock of their own, in that block's coordinates.
    Dungeon(BlockId),
}

#[derive(Clone, Debug)]
pub(crate) struct SiteDef {
    pub(crate) name: Word,
    pub(crate) kind: Kind,
    pub(crate) place: PlaceDef,
    pub(crate) shell: Option<ShellDef>,
    pub(crate) rooms: Vec<RoomDef>,
    pub(crate) links: Vec<Link>,
    pub(crate) exits: Vec<Exit>,
    pub(crate) statics: Vec<StaticDef>,
}

#[derive(Clone, Debug)]
pub(crate) struct StaticDef {
    pub(crate) span: Span,
    pub(crate) model: usize,
    /// The room it is in; none: the landscape.
    pub(crate) room: Option<Word>,
    pub(crate) place: PlaceDef,
}

/// Many copies of a model strewn over the land.
#[derive(Clone, Debug)]
pub(crate) struct Scatter {
    pub(crate) model: usize,
    pub(crate) count: u32,
    pub(crate) seed: u32,
    pub(crate) low: DVec2,
    pub(crate) high: DVec2,
    /// Distance to keep from sites, metres.
    pub(crate) clear: f64,
    /// Only on this type of terrain.
    pub(crate) on: Option<u8>,
}

/// What an object collides with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Collide {
    /// Its polygons.
    Polygons,
    /// An upright cylinder: radius and height.
    Cylinder(f64, f64),
    /// A sphere: height of the centre and radius.
    Sphere(f64, f64),
    /// Nothing.
    Nothing,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightDef {
    pub(crate) at: DVec3,
    pub(crate) color: [u8; 3],
    pub(crate) intensity: f64,
    pub(crate) falloff: f64,
}

#[derive(Clone, Debug)]
pub(crate) struct ModelDef {
    pub(crate) name: Word,
    pub(crate) solids: Vec<SolidDef>,
    pub(crate) paint: Paint,
    pub(crate) collide: Collide,
    pub(crate) lights: Vec<LightDef>,
}

#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) span: Span,
    /// Site and room; none: the landscape.
    pub(crate) room: Option<(Word, Word)>,
    pub(crate) place: PlaceDef,
}
