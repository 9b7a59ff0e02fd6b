//! Small worlds made of records.

use glam::{Quat, Vec3};
use vestibule_dat::primitive::{Bool32, Frame, Plane};
use vestibule_dat::record::{
    BspKind, BspLeafPhysics, BspNode, BspTag, BspTree, Building, BuildingPortal, CellPortal, CellStruct,
    EnvCell, Environment, GfxObj, GfxObjPolygons, LandBlock, LandBlockInfo, Polygon, Region, Setup, Stab,
    Vertex, VertexArray, region,
};
use vestibule_world::{BlockId, MemoryRecords, REGION_RECORD, Store, World};

/// One opening of a [`Room`].
pub struct Opening {
    /// Low word of the cell behind it; `None` leads outside.
    pub other: Option<u16>,
    /// The portal of that cell that matches; negative: none.
    pub other_portal: i16,
    /// Corners, room-local.
    pub corners: Vec<Vec3>,
    /// Retail `portal_side` 1.
    pub interior_is_negative: bool,
}

/// A convex room.
pub struct Room {
    /// Low word of its cell id.
    pub low: u16,
    /// Where it stands in the landblock.
    pub frame: Frame,
    /// Inside where all are positive, room-local.
    pub planes: Vec<Plane>,
    /// Its portals, in order.
    pub openings: Vec<Opening>,
    /// Low words of the cells of its stab list.
    pub stabs: Vec<u16>,
    /// Retail's flag of the same name.
    pub seen_outside: bool,
    /// Objects that stand in it.
    pub statics: Vec<Stab>,
    /// Polygons that collide, room-local, counter-clockwise seen from the side they face.
    pub walls: Vec<Vec<Vec3>>,
}

/// A plane by its normal and distance.
pub fn plane(x: f32, y: f32, z: f32, d: f32) -> Plane {
    Plane {
        normal: Vec3::new(x, y, z),
        d,
    }
}

/// The six planes of a box.
pub fn box_planes(min: Vec3, max: Vec3) -> Vec<Plane> {
    vec![
        plane(1.0, 0.0, 0.0, -min.x),
        plane(-1.0, 0.0, 0.0, max.x),
        plane(0.0, 1.0, 0.0, -min.y),
        plane(0.0, -1.0, 0.0, max.y),
        plane(0.0, 0.0, 1.0, -min.z),
        plane(0.0, 0.0, -1.0, max.z),
    ]
}

impl Room {
    /// A box without openings, in the landblock's frame.
    pub fn of_box(low: u16, min: Vec3, max: Vec3) -> Self {
        Room {
            low,
            frame: Frame::IDENTITY,
            planes: box_planes(min, max),
            openings: Vec::new(),
            stabs: Vec::new(),
            seen_outside: false,
            statics: Vec::new(),
            walls: Vec::new(),
        }
    }

    /// Adds polygons that collide.
    pub fn walls(mut self, walls: &[Vec<Vec3>]) -> Self {
        self.walls.extend_from_slice(walls);
        self
    }

    /// Adds an opening; `side` is its `interior_is_negative`.
    pub fn opening(
        mut self,
        other: Option<u16>,
        other_portal: i16,
        side: bool,
        corners: &[[f32; 3]],
    ) -> Self {
        let corners = corners.iter().map(|&c| Vec3::from_array(c)).collect();
        self.openings.push(Opening {
            other,
            other_portal,
            corners,
            interior_is_negative: side,
        });
        self
    }

    /// Sets the stab list.
    pub fn stabs(mut self, stabs: &[u16]) -> Self {
        self.stabs = stabs.to_vec();
        self
    }
}

/// A chain of planes ending in a leaf.
pub fn chain(planes: &[Plane]) -> BspTree {
    let mut nodes: Vec<BspNode> = planes
        .iter()
        .zip(1u32..)
        .map(|(&plane, next)| BspNode::Inner {
            tag: BspTag::BPNN_LOWER,
            plane,
            pos: Some(next),
            neg: None,
            sphere: None,
            polys: Vec::new(),
        })
        .collect();
    nodes.push(BspNode::Leaf {
        index: 0,
        physics: None,
    });
    BspTree {
        kind: BspKind::Cell,
        nodes,
    }
}

/// A tree in which nothing collides.
pub fn empty_physics() -> BspTree {
    let leaf = BspNode::Leaf {
        index: 0,
        physics: Some(BspLeafPhysics::default()),
    };
    BspTree {
        kind: BspKind::Physics,
        nodes: vec![leaf],
    }
}

/// A leaf with all of these polygons.
pub fn one_leaf(polygons: &[Polygon]) -> BspTree {
    let leaf = BspLeafPhysics {
        solid: 0,
        sphere: vestibule_dat::primitive::Sphere {
            center: Vec3::ZERO,
            radius: 500.0,
        },
        polys: polygons.iter().map(|p| p.id).collect(),
    };
    BspTree {
        kind: BspKind::Physics,
        nodes: vec![BspNode::Leaf {
            index: 0,
            physics: Some(leaf),
        }],
    }
}

/// A polygon of these vertices, seen from one side, without surfaces.
pub fn polygon(id: u16, vertex_ids: Vec<u16>) -> Polygon {
    Polygon {
        id,
        stippling: 0x0C,
        sides_type: 1,
        pos_surface: -1,
        neg_surface: -1,
        vertex_ids,
        ..Default::default()
    }
}

fn vertices_and_polygons(faces: &[Vec<Vec3>]) -> (VertexArray, Vec<Polygon>) {
    let mut vertices = Vec::new();
    let mut polygons = Vec::new();
    for (id, face) in (0u16..).zip(faces) {
        let first = vertices.len() as u16;
        polygons.push(polygon(id, (first..first + face.len() as u16).collect()));
        for &origin in face {
            vertices.push(Vertex {
                id: vertices.len() as u16,
                origin,
                normal: Vec3::Z,
                uvs: Vec::new(),
            });
        }
    }
    (VertexArray { vertices }, polygons)
}

/// Records of a world under construction.
pub struct Builder {
    /// What is there so far.
    pub records: MemoryRecords,
    /// The landblock that rooms and buildings go to.
    pub block: BlockId,
    /// Its objects and buildings.
    pub info: LandBlockInfo,
    /// Its terrain words.
    pub terrain: [u16; 81],
    /// Its heights; ground lies at twice as many metres.
    pub heights: [u8; 81],
    environments: u32,
}

impl Builder {
    /// A world whose heights are twice the index and whose one landblock is flat.
    pub fn new(block: u16) -> Self {
        let block = BlockId(block);
        let mut records = MemoryRecords::new();
        let mut heights = [0.0; 256];
        for (i, h) in heights.iter_mut().enumerate() {
            *h = 2.0 * i as f32;
        }
        let region = Region {
            id: REGION_RECORD,
            region_number: 1,
            version: 3,
            name: Default::default(),
            land_defs: region::LandDefs {
                num_block_length: 255,
                num_block_width: 255,
                square_length: 24.0,
                lblock_length: 8,
                vertex_per_cell: 1,
                max_obj_height: 200.0,
                sky_height: 1000.0,
                road_width: 5.0,
                land_height_table: heights,
            },
            game_time: Default::default(),
            parts_mask: 0,
            sky: None,
            sound: None,
            scene: None,
            terrain: Default::default(),
            misc: None,
        };
        records.insert(Store::Portal, REGION_RECORD, region.encode().unwrap());
        let info = LandBlockInfo {
            id: block.info_record(),
            ..Default::default()
        };
        Builder {
            records,
            block,
            info,
            terrain: [0; 81],
            heights: [0; 81],
            environments: 0,
        }
    }

    /// Adds a room of the landblock.
    pub fn room(&mut self, room: Room) -> &mut Self {
        let mut faces: Vec<Vec<Vec3>> = room.openings.iter().map(|o| o.corners.clone()).collect();
        faces.extend_from_slice(&room.walls);
        let (vertices, mut polygons) = vertices_and_polygons(&faces);
        let physics_polygons = polygons.split_off(room.openings.len());
        self.environments += 1;
        let environment = 0x0D00_0000 | self.environments;
        let cell_struct = CellStruct {
            id: 0,
            vertices,
            portals: polygons.iter().map(|p| p.id).collect(),
            polygons,
            cell_bsp: chain(&room.planes),
            physics_bsp: if physics_polygons.is_empty() {
                empty_physics()
            } else {
                one_leaf(&physics_polygons)
            },
            physics_polygons,
            has_drawing_bsp: Bool32(0),
            drawing_bsp: None,
        };
        let record = Environment {
            id: environment,
            cell_structs: vec![cell_struct],
        };
        self.records
            .insert(Store::Portal, environment, record.encode().unwrap());
        let full = |low: u16| u32::from(self.block.0) << 16 | u32::from(low);
        let portals = room
            .openings
            .iter()
            .zip(0u16..)
            .map(|(o, polygon_id)| CellPortal {
                flags: u16::from(!o.interior_is_negative) << 1 | if o.other.is_none() { 4 } else { 0 },
                polygon_id,
                other_cell_id: full(o.other.unwrap_or(0xFFFF)),
                other_portal_id: o.other_portal,
            })
            .collect();
        let cell = EnvCell {
            id: full(room.low),
            flags: u32::from(room.seen_outside) | if room.statics.is_empty() { 0 } else { 2 },
            id_again: full(room.low),
            surfaces: Vec::new(),
            environment,
            cell_struct: 0,
            frame: room.frame,
            portals,
            stabs: room.stabs.iter().map(|&s| full(s)).collect(),
            statics: room.statics,
            restriction: None,
        };
        self.records.insert(Store::Cell, cell.id, cell.encode().unwrap());
        self.info.num_cells = self.info.num_cells.max(u32::from(room.low) - 0xFF);
        self
    }

    /// A building whose portals lead to (cell, its portal).
    pub fn building(&mut self, origin: Vec3, portals: &[(u16, i16)]) -> &mut Self {
        let model_id = 0x0100_0001;
        self.model(model_id, &[vec![Vec3::ZERO, Vec3::X, Vec3::Y]], false);
        let full = |low: u16| u32::from(self.block.0) << 16 | u32::from(low);
        self.info.buildings.push(Building {
            model_id,
            frame: Frame {
                origin,
                rotation: Quat::IDENTITY,
            },
            num_leaves: 1,
            portals: portals
                .iter()
                .map(|&(cell, other_portal_id)| BuildingPortal {
                    flags: 1,
                    other_cell_id: full(cell),
                    other_portal_id,
                    stabs: vec![full(cell)],
                })
                .collect(),
        });
        self
    }

    /// A model of loose faces; with `physics` they collide.
    pub fn model(&mut self, id: u32, faces: &[Vec<Vec3>], physics: bool) -> &mut Self {
        let (vertices, polygons) = vertices_and_polygons(faces);
        let leaf = |kind, physics| BspTree {
            kind,
            nodes: vec![BspNode::Leaf { index: 0, physics }],
        };
        let sphere = vestibule_dat::primitive::Sphere {
            center: Vec3::ZERO,
            radius: 10.0,
        };
        let all: Vec<u16> = polygons.iter().map(|p| p.id).collect();
        let tree = leaf(
            BspKind::Physics,
            Some(BspLeafPhysics {
                solid: 0,
                sphere,
                polys: all,
            }),
        );
        let part = |bsp| GfxObjPolygons {
            polygons: polygons.clone(),
            form: Default::default(),
            bsp,
        };
        let record = GfxObj {
            id,
            flags: if physics { 3 } else { 2 },
            physics: physics.then(|| part(tree)),
            drawing: Some(part(leaf(BspKind::Drawing, None))),
            vertices,
            ..Default::default()
        };
        self.records.insert(Store::Portal, id, record.encode().unwrap());
        self
    }

    /// Adds a setup.
    pub fn setup(&mut self, setup: &Setup) -> &mut Self {
        self.records
            .insert(Store::Portal, setup.id, setup.encode().unwrap());
        self
    }

    /// The records.
    pub fn finish(mut self) -> MemoryRecords {
        let has_objects =
            self.info.num_cells > 0 || !self.info.objects.is_empty() || !self.info.buildings.is_empty();
        let land = LandBlock {
            id: self.block.land_block_record(),
            has_objects: Bool32(u32::from(has_objects)),
            terrain: self.terrain,
            height: self.heights,
        };
        self.records.insert(Store::Cell, land.id, land.encode().unwrap());
        if has_objects {
            self.records
                .insert(Store::Cell, self.info.id, self.info.encode().unwrap());
        }
        self.records
    }

    /// Adds a flat landblock without objects.
    pub fn flat_block(&mut self, block: u16) -> &mut Self {
        let id = BlockId(block).land_block_record();
        let land = LandBlock {
            id,
            has_objects: Bool32(0),
            terrain: [0; 81],
            height: [0; 81],
        };
        self.records.insert(Store::Cell, id, land.encode().unwrap());
        self
    }

    /// The world, opened.
    pub fn world(self) -> World {
        World::open(self.finish()).unwrap()
    }
}
