//! Shadow lists: which static objects each cell holds or is reached by (`world.md` 14).

use glam::Vec3;

use crate::cell_array::CellArray;
use crate::find_cell_list::find_cell_list_of_cylspheres;
use crate::frame::Frame;
use crate::geometry::{BoundingBox, Sphere};
use crate::ids::{BlockId, CellId, block_offset};
use crate::landblock::{LAND_CELLS, Landblock};
use crate::lanes::Lanes;
use crate::open_ground::OpenGround;
use crate::physics_bsp::PhysicsBsp;
use crate::position::Position;
use crate::shape::{StaticObject, StaticRef};
use crate::transit_parts::{PartBounds, find_bbox_cell_list};
use crate::world::World;

/// For each cell of a landblock, the static objects that reach it, in order of entry: block by block, the
/// block's statics in record order, then those of its env cells (`world.md` H7).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowLists {
    /// Start of each cell's range in `refs`: 64 land cells, then the env cells; one more entry than cells.
    starts: Box<[u32]>,
    refs: Box<[StaticRef]>,
    /// How far each of `refs` reaches, in the frame of the lists' landblock.
    reaches: Box<[StaticReach]>,
    /// What each of `refs` is drawn in, in the frame of the lists' landblock.
    bounds: Box<[Sphere]>,
    /// Land cells that some object reaches, one bit each.
    land_cells: u64,
    pub(crate) open_ground: OpenGround,
    /// Start of each cell's range in `quads`; one more entry than cells.
    quad_starts: Box<[u32]>,
    quads: Box<[ReachQuad]>,
}

/// Four [`StaticReach`]es of one cell side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachQuad {
    center: [Lanes; 3],
    radius: Lanes,
    stretch: Lanes,
    middle: [Lanes; 3],
    half: [Lanes; 3],
}

impl ReachQuad {
    fn new(reaches: &[StaticReach]) -> Self {
        let mut quad = ReachQuad {
            center: [Lanes::ZERO; 3],
            radius: Lanes::splat(f32::NEG_INFINITY),
            stretch: Lanes::ZERO,
            middle: [Lanes::ZERO; 3],
            half: [Lanes::splat(f32::INFINITY); 3],
        };
        for (k, reach) in reaches.iter().enumerate().take(4) {
            for axis in 0..3 {
                quad.center[axis].set_lane(k, reach.sphere.center[axis]);
                let (min, max) = (reach.bounds.min[axis], reach.bounds.max[axis]);
                // What is endless has no middle.
                if min.is_finite() && max.is_finite() {
                    quad.middle[axis].set_lane(k, (min + max) * 0.5);
                    quad.half[axis].set_lane(k, (max - min) * 0.5);
                }
            }
            quad.radius.set_lane(k, reach.sphere.radius);
            quad.stretch.set_lane(k, reach.stretch);
        }
        quad
    }

    /// How far two spheres of which `larger` is the larger radius may be shifted before one comes near each of the four
    /// objects, metres; infinite where there are fewer.
    #[inline(always)]
    pub fn distances(&self, [a, b]: [Lanes; 2], larger: f32) -> Lanes {
        let squares = self.squares(a).lesser(self.squares(b));
        let round = squares.sqrt() - (self.radius + self.stretch * larger);
        if Lanes::ZERO.less(round) == 0b1111 {
            return round;
        }
        let square = self.beyond_boxes(a).lesser(self.beyond_boxes(b));
        round.greater(square - Lanes::splat(larger))
    }

    /// Squared distances of a point from the centres.
    #[inline(always)]
    fn squares(&self, p: Lanes) -> Lanes {
        let square = |axis: usize| {
            let d = Lanes::splat(p.lane(axis)) - self.center[axis];
            d.times(d)
        };
        square(0) + square(1) + square(2)
    }

    /// How far a point is from the boxes along the axis on which it is farthest.
    #[inline(always)]
    fn beyond_boxes(&self, p: Lanes) -> Lanes {
        let from = |axis: usize| (Lanes::splat(p.lane(axis)) - self.middle[axis]).abs() - self.half[axis];
        from(0).greater(from(1)).greater(from(2))
    }
}

/// How far a static object that can be run into reaches, in the frame of the lists' landblock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticReach {
    /// Holds all of it. A radius below zero: it cannot be run into.
    pub sphere: Sphere,
    /// A sphere farther from [`StaticReach::sphere`] than its radius times this does not touch the object: tests
    /// against cylinders are square in section.
    pub stretch: f32,
    /// A sphere that does not reach into this box does not touch the object.
    pub bounds: BoundingBox,
}

impl ShadowLists {
    /// The static objects found in a cell of this block.
    #[inline]
    pub fn of(&self, cell: CellId) -> &[StaticRef] {
        self.refs.get(self.range(cell)).unwrap_or(&[])
    }

    /// As [`ShadowLists::of`], with how far each object reaches.
    #[inline]
    pub fn with_reaches(&self, cell: CellId) -> impl Iterator<Item = (StaticRef, &StaticReach)> {
        let range = self.range(cell);
        let refs = self.refs.get(range.clone()).unwrap_or(&[]);
        refs.iter().copied().zip(self.reaches.get(range).unwrap_or(&[]))
    }

    /// As [`ShadowLists::of`], with [`StaticObject::bounds`] of each object, in the frame of the lists' landblock.
    #[inline]
    pub fn with_bounds(&self, cell: CellId) -> impl Iterator<Item = (&StaticRef, &Sphere)> {
        let range = self.range(cell);
        let refs = self.refs.get(range.clone()).unwrap_or(&[]);
        refs.iter().zip(self.bounds.get(range).unwrap_or(&[]))
    }

    /// The land cells that some static object reaches, one bit each in order of their ids.
    #[inline]
    pub fn land_cells(&self) -> u64 {
        self.land_cells
    }

    /// How far the objects of [`ShadowLists::of`] reach, four at a time.
    #[inline(always)]
    pub fn quads(&self, cell: CellId) -> &[ReachQuad] {
        self.quads.get(range_of(&self.quad_starts, cell)).unwrap_or(&[])
    }

    /// Whether no static object reaches a cell.
    #[inline]
    pub fn is_empty_in(&self, cell: CellId) -> bool {
        self.range(cell).is_empty()
    }

    #[inline]
    fn range(&self, cell: CellId) -> core::ops::Range<usize> {
        range_of(&self.starts, cell)
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.starts)
            + size_of_val(&*self.refs)
            + size_of_val(&*self.reaches)
            + size_of_val(&*self.bounds)
            + self.open_ground.bytes()
            + size_of_val(&*self.quad_starts)
            + size_of_val(&*self.quads)
    }

    /// Builds the lists of `block` from its own statics and those of the blocks around it.
    pub(crate) fn build(world: &World, block: &Landblock) -> Self {
        let cells = LAND_CELLS + block.env_cells.len();
        let mut found: Vec<(usize, StaticRef, StaticReach, Sphere)> = Vec::new();
        for dx in -1..=1 {
            for dy in -1..=1 {
                let Some(id) = block.id.neighbour(dx, dy) else {
                    continue;
                };
                let (near, own) = if id == block.id {
                    (Some(block), true)
                } else {
                    (world.block(id), false)
                };
                let Some(near) = near else { continue };
                let cells_of = near.reach(world);
                let entries = if own { &cells_of.own } else { &cells_of.foreign };
                for &(cell, index) in entries.iter().filter(|(cell, _)| cell.block() == block.id) {
                    let placed = near.statics.get(index as usize);
                    if let (Some(slot), Some(object)) = (slot(cell).filter(|&s| s < cells), placed) {
                        let mut sphere = bounding_sphere_of(object);
                        let offset = block_offset(block.id, object.cell.block());
                        sphere.center += offset;
                        let bounds = Sphere::new(object.bounds.center + offset, object.bounds.radius);
                        let stretch = if object.shape.has_physics_bsp { 1.0 } else { 1.5 };
                        found.push((
                            slot,
                            StaticRef { block: id, index },
                            StaticReach {
                                sphere,
                                stretch,
                                bounds: box_of(object, offset),
                            },
                            bounds,
                        ));
                    }
                }
            }
        }
        // Stable: keeps the order of entry within a cell.
        found.sort_by_key(|&(slot, ..)| slot);
        let mut starts = vec![0u32; cells + 1];
        for &(slot, ..) in &found {
            if let Some(count) = starts.get_mut(slot + 1) {
                *count += 1;
            }
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let in_land = found.iter().filter(|&&(slot, ..)| slot < LAND_CELLS);
        let reaches: Box<[StaticReach]> = found.iter().map(|&(_, _, reach, _)| reach).collect();
        let mut quads = Vec::new();
        let mut quad_starts = vec![0u32; cells + 1];
        for cell in 0..cells {
            let of_cell = reaches.get(starts[cell] as usize..starts[cell + 1] as usize);
            quads.extend(of_cell.unwrap_or(&[]).chunks(4).map(ReachQuad::new));
            quad_starts[cell + 1] = quads.len() as u32;
        }
        ShadowLists {
            land_cells: in_land.fold(0, |bits, &(slot, ..)| bits | 1 << slot),
            open_ground: OpenGround::build(world, block, |cell| {
                reaches.get(range_of(&starts, cell)).unwrap_or(&[])
            }),
            starts: starts.into(),
            refs: found.iter().map(|&(_, r, ..)| r).collect(),
            bounds: found.iter().map(|&(.., bounds)| bounds).collect(),
            reaches,
            quad_starts: quad_starts.into(),
            quads: quads.into(),
        }
    }
}

/// A sphere that holds all of an object that can be run into, in the frame of its landblock.
fn bounding_sphere_of(object: &StaticObject) -> Sphere {
    let shape = &object.shape;
    let mut spheres: Vec<Sphere> = Vec::new();
    if shape.has_physics_bsp {
        for (part, frame) in shape.parts.iter().zip(&object.part_frames) {
            if let Some(bound) = part.model.as_ref().and_then(|m| m.physics_sphere) {
                let scale = part.scale.z;
                let center = frame.local_to_global(bound.center * scale);
                // Slack of 0.03 for the tolerance of the part's own test, at its scale.
                let slack = if scale.abs() > 1.0 {
                    0.03 * scale.abs()
                } else {
                    0.03
                };
                spheres.push(Sphere::new(center, bound.radius * scale.abs() + slack));
            }
        }
    } else if !shape.cylspheres.is_empty() {
        for c in &shape.cylspheres {
            let half = c.height / 2.0;
            let center = object.frame.local_to_global(c.low_point) + Vec3::new(0.0, 0.0, half);
            spheres.push(Sphere::new(
                center,
                libm::sqrtf(c.radius * c.radius + half * half),
            ));
        }
    } else {
        let place = |s: &Sphere| Sphere::new(object.frame.local_to_global(s.center), s.radius);
        spheres.extend(shape.spheres.iter().map(place));
    }
    let Some(first) = spheres.first() else {
        return Sphere::new(object.frame.origin, -1.0);
    };
    let center = first.center;
    let mut radius = 0.0;
    for s in &spheres {
        let between = s.center - center;
        let far = libm::sqrtf(between.dot(between)) + s.radius;
        radius = if far > radius { far } else { radius };
    }
    Sphere::new(center, radius + 0.02)
}

/// A box that holds all of an object that can be touched, shifted by `offset`; endless where that is not easily told.
fn box_of(object: &StaticObject, offset: Vec3) -> BoundingBox {
    let shape = &object.shape;
    let mut corners: Vec<Vec3> = Vec::new();
    if shape.has_physics_bsp {
        for (part, frame) in shape.parts.iter().zip(&object.part_frames) {
            if let Some(bsp) = part.model.as_ref().and_then(|m| m.physics.as_ref()) {
                let scale = part.scale.z;
                if !(scale > 0.0 && scale <= 1.0) {
                    return ENDLESS;
                }
                corners.extend(corners_of(bsp, frame, scale));
            }
        }
    } else if !shape.cylspheres.is_empty() {
        for c in &shape.cylspheres {
            let (low, across) = (
                object.frame.local_to_global(c.low_point),
                Vec3::new(c.radius, c.radius, 0.0),
            );
            corners.extend([low - across, low + across + Vec3::Z * c.height]);
        }
    } else {
        for s in &shape.spheres {
            let center = object.frame.local_to_global(s.center);
            corners.extend([center - s.radius, center + s.radius]);
        }
    }
    box_around(&corners, offset)
}

/// Corners of what a physics BSP reaches when it is placed.
pub(crate) fn corners_of(bsp: &PhysicsBsp, frame: &Frame, scale: f32) -> [Vec3; 8] {
    bsp.reach().corners().map(|p| frame.local_to_global(p * scale))
}

/// A box around points and a little more, shifted by `offset`; endless where rounding may be more than that.
pub(crate) fn box_around(points: &[Vec3], offset: Vec3) -> BoundingBox {
    /// For the tolerance of tests and the rounding of frames, metres.
    const SLACK: Vec3 = Vec3::splat(0.03);
    let Some(found) = BoundingBox::of(points.iter().copied()) else {
        return ENDLESS;
    };
    let found = BoundingBox {
        min: found.min - SLACK + offset,
        max: found.max + SLACK + offset,
    };
    let is_near = |v: Vec3| v.abs().max_element() < 1024.0;
    if is_near(found.min) && is_near(found.max) {
        found
    } else {
        ENDLESS
    }
}

/// Reaches everything.
const ENDLESS: BoundingBox = BoundingBox {
    min: Vec3::NEG_INFINITY,
    max: Vec3::INFINITY,
};

/// The cells that the static objects of one landblock occupy, with the position of the object, object by object.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Reach {
    /// Cells of the landblock itself.
    own: Box<[(CellId, u32)]>,
    /// Cells of other landblocks.
    foreign: Box<[(CellId, u32)]>,
}

impl Reach {
    /// Works out the cells of every static object whose own cell is resident (`world.md` H2, H4).
    pub(crate) fn build(world: &World, block: &Landblock) -> Self {
        let mut array = CellArray::new();
        let (mut own, mut foreign) = (Vec::new(), Vec::new());
        for (index, object) in (0u32..).zip(&block.statics) {
            if !world.is_resident(object.cell) {
                continue;
            }
            calc_cross_cells_static(world, object, &mut array);
            for entry in array.entries() {
                let list = if entry.id.block() == block.id {
                    &mut own
                } else {
                    &mut foreign
                };
                list.push((entry.id, index));
            }
        }
        Reach {
            own: own.into(),
            foreign: foreign.into(),
        }
    }

    /// Whether an object reaches, or would reach, a cell of another landblock.
    pub(crate) fn touches(&self, block: BlockId) -> bool {
        self.foreign.iter().any(|(cell, _)| cell.block() == block)
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.own) + size_of_val(&*self.foreign)
    }
}

#[inline(always)]
fn range_of(starts: &[u32], cell: CellId) -> core::ops::Range<usize> {
    let Some(slot) = slot(cell) else { return 0..0 };
    match (starts.get(slot), starts.get(slot + 1)) {
        (Some(&a), Some(&b)) => a as usize..b as usize,
        _ => 0..0,
    }
}

/// Position of a cell in the lists of its block.
#[inline(always)]
fn slot(cell: CellId) -> Option<usize> {
    if cell.is_land_cell() {
        Some(usize::from(cell.low()) - 1)
    } else if cell.is_env_cell() {
        Some(LAND_CELLS + usize::from(cell.low()) - 0x100)
    } else {
        None
    }
}

/// The cells a static object occupies (retail `calc_cross_cells_static`, `world.md` H2): by its cylinders when
/// it has some and no physics BSP, else by the boxes of its parts.
pub fn calc_cross_cells_static(world: &World, object: &StaticObject, array: &mut CellArray) {
    array.do_not_load_cells = true;
    if !object.shape.cylspheres.is_empty() && !object.shape.has_physics_bsp {
        let position = Position {
            cell: object.cell,
            frame: object.frame,
        };
        find_cell_list_of_cylspheres(world, &position, &object.shape.cylspheres, array);
    } else {
        let parts = part_bounds(object);
        find_bbox_cell_list(world, object.cell, &parts, array);
    }
}

/// The parts of a placed object as the cell tests see them. Parts without a model are left out.
pub fn part_bounds(object: &StaticObject) -> Vec<PartBounds> {
    let placed = object.shape.parts.iter().zip(&object.part_frames);
    placed
        .filter_map(|(part, frame)| {
            let model = part.model.as_ref()?;
            Some(PartBounds {
                frame: *frame,
                sphere: model.cell_sphere(),
                bounds: model.bounds,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_of_a_movers_spheres_and_of_five_objects_counts() {
        let reach = |x: f32, stretch: f32| StaticReach {
            sphere: Sphere::new(Vec3::new(x, 0.0, 2.0), 0.5),
            stretch,
            bounds: ENDLESS,
        };
        let reaches = [
            reach(50.0, 1.0),
            reach(40.0, 1.0),
            reach(30.0, 1.0),
            reach(20.0, 1.0),
            reach(3.0, 1.5),
        ];
        let lists = ShadowLists {
            quad_starts: [0, 2].into(),
            quads: reaches.chunks(4).map(ReachQuad::new).collect(),
            ..ShadowLists::default()
        };
        let (cell, foot) = (CellId(0xA9B4_0001), Lanes::ZERO);
        let distance = |cell, spheres| {
            let quads = lists.quads(cell).iter();
            let least = quads.map(|quad| quad.distances(spheres, 0.4).least());
            least.fold(f32::INFINITY, |a, b| if b < a { b } else { a })
        };
        let at = |head| distance(cell, [foot, head]);
        assert!((at(foot) - (13.0f32.sqrt() - 0.5 - 0.6)).abs() < 1e-5);
        assert!((at(Vec3::new(0.0, 0.0, 2.0).into()) - (3.0 - 0.5 - 0.6)).abs() < 1e-5);
        assert_eq!(distance(CellId(0xA9B4_0002), [foot; 2]), f32::INFINITY);
    }

    #[test]
    fn near_the_sphere_around_an_object_its_box_counts() {
        let table = StaticReach {
            sphere: Sphere::new(Vec3::new(0.0, 0.0, 0.4), 1.5),
            stretch: 1.0,
            bounds: BoundingBox {
                min: Vec3::new(-1.4, -0.5, 0.0),
                max: Vec3::new(1.4, 0.5, 0.8),
            },
        };
        let at = |x: f32, y: f32| {
            let p = Lanes::from(Vec3::new(x, y, 0.48));
            ReachQuad::new(&[table]).distances([p; 2], 0.48).lane(0)
        };
        assert!((at(0.0, 1.2) - 0.22).abs() < 1e-5 && at(0.0, 0.9) < 0.0);
        // Without a box there is only the sphere.
        let endless = StaticReach {
            bounds: ENDLESS,
            ..table
        };
        let p = Lanes::from(Vec3::new(0.0, 1.2, 0.48));
        assert!(ReachQuad::new(&[endless]).distances([p; 2], 0.48).lane(0) < 0.0);
    }
}
