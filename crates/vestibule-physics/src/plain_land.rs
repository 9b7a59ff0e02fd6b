//! The usual step on terrain, worked out without a transition (`transition.md` 5.6, 5.8, 7.3); see
//! [`crate::plain_step`].

use vestibule_world::{
    Building, CellArray, CellEntry, CellId, LandCell, Lanes, Sphere, TerrainPolygon, Water, add_land_cells,
    distance_to_rooms, transit::add_all_outside_cells,
};

use crate::candidate::{Candidate, Shape, distance_to_sphere, down};
use crate::constants::{EPSILON, SHAPE_INTERP_LIMIT};
use crate::object_info::is_walkable_z;
use crate::plain_step::{PlainEnd, PlainStep, end_at};

/// A step on a land cell, if it is a usual one. Land cells are columns and such a step goes straight up and down from the
/// candidate: which of them it touches stays the same.
#[inline(always)]
pub(crate) fn plain_step_on_land(step: &PlainStep<'_>, array: &mut CellArray) -> Option<PlainEnd> {
    let id = step.from.cell;
    let cell = step.block.land_cell(id)?;
    match step.rest_on_open_ground(id, cell) {
        Some((rest, plane)) => {
            // Last: a call before there is less to be kept over it would cost more.
            if !step.is_alone_in(id) {
                return None;
            }
            array.start(id, true);
            end_at(step.from, id, &rest, plane, cell.water != Water::Not, None)
        }
        None => on_any_land(*step, array),
    }
}

/// See [`PlainStep::on_land`].
#[inline(never)]
fn on_any_land(step: PlainStep<'_>, array: &mut CellArray) -> Option<PlainEnd> {
    let end = step.on_land(array);
    if end.is_none() {
        array.clear();
    }
    end
}

impl PlainStep<'_> {
    /// Where the candidate comes to rest if it touches nothing but the ground of one land cell, the usual case, and on what
    /// plane.
    #[inline(always)]
    fn rest_on_open_ground(&self, id: CellId, cell: &LandCell) -> Option<(Candidate, Lanes)> {
        let spheres = self.candidate.spheres;
        if !self.low.has_xy_of(spheres[0])
            || !cell.certainly_holds(spheres)
            || !self.block.is_known_open(id, cell, spheres)
        {
            return None;
        }
        let plane = Lanes::of_plane(&cell.find_terrain_poly_inside(spheres[0])?.plane);
        let water = cell.water_depth_inside(spheres[0]);
        Some((self.rest_on(plane, water)?, plane))
    }

    /// On land cells with other things on them, or on several: where the rooms of their buildings are not touched, nor
    /// any object.
    #[inline(always)]
    fn on_land(&self, array: &mut CellArray) -> Option<PlainEnd> {
        let land = self.block.land.as_ref()?;
        let upright = self.low.has_xy_of(self.candidate.spheres[0]);
        if land.water == Water::Entirely || !upright {
            return None;
        }
        let (id, cell, polygon) = self.land_cells(array)?;
        let cells = array.entries();
        let rooms = self.distance_to_rooms(cells, &self.candidate)?;
        let objects = self.objects_on_lands(cells, &self.candidate, false)?;
        let plane = Lanes::of_plane(&polygon.plane);
        let rest = self.rest_on(plane, cell.water_depth(self.low.xyz()))?;
        if !self.candidate.has_bits_of(&rest) {
            if !rest.is_within(self.candidate.spheres[0], rooms) {
                self.distance_to_rooms(cells, &rest)?;
            }
            if !rest.is_within(self.candidate.spheres[0], objects) {
                self.objects_on_lands(cells, &rest, true)?;
            }
        }
        end_at(self.from, id, &rest, plane, cell.water != Water::Not, None)
    }

    /// Where the candidate comes to rest on walkable ground (5.6, 5.8, 7.3): where it is, lifted out of the ground, or
    /// lowered and lifted. The first insertion that moves nothing is the last: one more, or to place it, finds the same.
    /// `water` is how far it sinks in, metres.
    #[inline(always)]
    fn rest_on(&self, plane: Lanes, water: f32) -> Option<Candidate> {
        let (n_z, mut rest) = (plane.z(), self.candidate);
        let foot = rest.spheres[0];
        // Of the low point only the height changes. The sums are those of its distance from the plane.
        let across = plane.times(foot);
        let across = across.lane(0) + across.lane(1);
        let above = |z: f32| across + n_z * (z - foot.fourth()) + plane.fourth() + water;
        let z = foot.z();
        let a = above(z);
        if a > EPSILON {
            // The ground below.
            let h = self.search_depth();
            let z = z - h;
            let a = above(z);
            let lift = a / n_z;
            let interp = 1.0 + lift / h;
            rest.shift(down(h));
            rest.shift(down(lift));
            // All at once: each branch costs more.
            let found = (a < -EPSILON) & (SHAPE_INTERP_LIMIT..1.0).contains(&interp);
            return (found & (above(z - lift) >= -EPSILON) & is_walkable_z(n_z)).then_some(rest);
        }
        if !(a >= -EPSILON) {
            let lift = a / n_z;
            rest.shift(down(lift));
            if !(above(z - lift) >= -EPSILON) {
                return None;
            }
        }
        is_walkable_z(n_z).then_some(rest)
    }

    /// Fills the array with the land cells touched, all of this landblock, and finds the one below the foot and its ground
    /// there.
    #[inline(always)]
    fn land_cells(&self, array: &mut CellArray) -> Option<(CellId, &LandCell, &TerrainPolygon)> {
        let id = self.from.cell;
        let own = self.block.land_cell(id)?;
        let spheres = self.candidate.spheres;
        if add_land_cells(id, own, spheres, array) {
            return Some((id, own, own.find_terrain_poly_inside(spheres[0])?));
        }
        array.clear();
        add_all_outside_cells(
            self.world,
            id,
            spheres[0].xyz(),
            &spheres.map(Sphere::from),
            array,
        );
        if !array.contains(id) {
            return None;
        }
        let mut below = None;
        for entry in array.entries() {
            let here = entry.id.block() == id.block();
            let cell = self.block.land_cell(entry.id).filter(|_| here)?;
            if let Some(polygon) = cell.find_terrain_poly(self.low.xyz()) {
                // On a border, more than one.
                if below.is_some() {
                    return None;
                }
                below = Some((entry.id, cell, polygon));
            }
        }
        below
    }

    /// How far a pose may be shifted without touching a room of a building on one of these land cells, metres.
    fn distance_to_rooms(&self, cells: &[CellEntry], pose: &Candidate) -> Option<f32> {
        let mut least = f32::INFINITY;
        for entry in cells {
            let cell = self.block.land_cell(entry.id)?;
            let d = distance_to_rooms(self.world, self.block, cell, pose.spheres);
            least = if d < least { d } else { least };
        }
        (least > 0.0).then_some(least)
    }

    /// As [`PlainStep::objects_on_land`] in all land cells that a pose touches, none of which may be watched over.
    #[inline(always)]
    fn objects_on_lands(&self, cells: &[CellEntry], pose: &Candidate, placing: bool) -> Option<f32> {
        let mut least = f32::INFINITY;
        for entry in cells {
            let cell = self.block.land_cell(entry.id)?;
            if cell.restriction.is_some() {
                return None;
            }
            let d = self.objects_on_land(entry.id, cell, pose, placing)?;
            least = if d < least { d } else { least };
        }
        Some(least)
    }

    /// As [`PlainStep::objects_around`], the land cell's building among them.
    #[inline(always)]
    fn objects_on_land(&self, id: CellId, cell: &LandCell, pose: &Candidate, placing: bool) -> Option<f32> {
        let objects = self.objects_around(id, pose, placing)?;
        let Some(index) = cell.building else {
            return Some(objects);
        };
        let building = self.block.buildings.get(usize::from(index))?;
        let shell = shell_around(building, &self.shape, pose, placing)?;
        Some(if shell < objects { shell } else { objects })
    }
}

/// How far a pose may be shifted before it comes near a building's shell; see [`PlainStep::objects_around`].
#[inline(never)]
fn shell_around(building: &Building, shape: &Shape, pose: &Candidate, placing: bool) -> Option<f32> {
    /// Spheres that graze each other overlap (6.1), metres.
    const SLACK: f32 = 0.01;
    let (Some(part), Some(frame)) = (building.shape.parts.first(), building.part_frames.first()) else {
        return Some(f32::INFINITY);
    };
    let model = part.model.as_ref();
    let Some((bsp, bound)) = model.and_then(|m| Some((m.physics.as_ref()?, m.physics_sphere?))) else {
        return Some(f32::INFINITY);
    };
    if part.scale.z != 1.0 {
        return None;
    }
    let around = Sphere::new(frame.local_to_global(bound.center), bound.radius + SLACK);
    let distance = distance_to_sphere(&around, 1.0, shape, pose);
    if distance > 0.0 {
        return Some(distance);
    }
    pose.clears_part(shape, frame, bsp, &bound, placing)
        .then_some(0.0)
}
