//! The usual step on terrain, worked out without a transition (`transition.md` 5.6, 5.8, 7.3); see
//! [`crate::plain_step`].

use vestibule_world::{
    Building, CellArray, CellEntry, CellId, LandCell, Lanes, Plane, Sphere, Water, distance_to_rooms,
    transit::add_all_outside_cells,
};

use crate::candidate::{Candidate, Shape, distance_to_sphere, down};
use crate::constants::{EPSILON, FLOOR_Z, MOVE_ATTEMPTS, SHAPE_INTERP_LIMIT, STEP_DOWN_ATTEMPTS};
use crate::object_info::is_walkable_z;
use crate::plain_step::{PlainEnd, PlainStep};

/// A candidate over terrain.
struct OverLand<'a> {
    cell: &'a LandCell,
    /// The plane of the triangle below: the same for all of a step, which goes straight up and down from where that is
    /// looked up.
    plane: &'a Plane,
    pose: Candidate,
    low: Lanes,
    contact: Option<Plane>,
}

/// How terrain answers an insertion.
enum Answer {
    /// It is satisfied, in contact or not.
    Ok,
    /// It moved the candidate up.
    Adjusted,
}

impl OverLand<'_> {
    #[inline(always)]
    fn shift(&mut self, v: Lanes) {
        self.pose.shift(v);
        self.low += v;
    }

    /// One insertion into the land cell's terrain (7.3); `None` where it is not a usual one. `interp` is what is
    /// left of the movement in a step down by `depth`.
    #[inline(always)]
    fn insert(&mut self, interp: Option<&mut f32>, depth: f32) -> Option<Answer> {
        let plane = *self.plane;
        let water = if self.cell.water == Water::Not {
            0.0
        } else {
            self.cell.water_depth(self.low.xyz())
        };
        let n = plane.normal;
        if interp.is_none() && !is_walkable_z(n.z) {
            return None;
        }
        let foot = self.pose.spheres[0];
        let low = foot - down(-foot.fourth());
        let a = Lanes::of_plane(&plane).dist(low) + water;
        if a > EPSILON {
            return Some(Answer::Ok);
        }
        self.contact = Some(plane);
        if a >= -EPSILON {
            return Some(Answer::Ok);
        }
        let z = a / n.z;
        if let Some(interp) = interp {
            let w = (1.0 + z / (depth * *interp)) * *interp;
            if w >= *interp || w < SHAPE_INTERP_LIMIT {
                return None;
            }
            *interp = w;
        }
        self.shift(down(z));
        Some(Answer::Adjusted)
    }
}

/// A step on a land cell, if it is a usual one. Land cells are columns and such a step goes straight up and down from the
/// candidate: which of them it touches stays the same.
#[inline(always)]
pub(crate) fn plain_step_on_land(step: &PlainStep<'_>, array: &mut CellArray) -> Option<PlainEnd> {
    match step.on_bare_ground(array) {
        Some(end) => Some(end),
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
    /// Where nothing but the ground of one land cell is touched: the usual case. Either it is stood on at once, or it is
    /// found below and lifts the lowered candidate.
    #[inline(always)]
    fn on_bare_ground(&self, array: &mut CellArray) -> Option<PlainEnd> {
        let id = self.from.cell;
        let cell = self.block.land_cell(id)?;
        let [foot, head] = self.candidate.spheres;
        if !self.world.shadow_lists(self.block).is_bare(id)
            || !cell.certainly_holds([foot, head, self.low])
            || !self.is_alone_in(id)
        {
            return None;
        }
        let plane = Lanes::of_plane(&cell.find_terrain_poly_inside(self.low)?.plane);
        let n_z = plane.z();
        if !is_walkable_z(n_z) {
            return None;
        }
        // Only the height changes: the sums are those of [`OverLand::insert`].
        let (across, radius) = (plane.times(self.low), foot.fourth());
        let across = across.lane(0) + across.lane(1);
        let above = |z: f32| across + n_z * (z - radius) + plane.fourth();
        let mut pose = self.candidate;
        let a = above(foot.z());
        if a > EPSILON {
            let h = self.search_depth();
            let z = foot.z() + -h;
            let a = above(z);
            let lift = a / n_z;
            let interp = 1.0 + lift / h;
            if !(a < -EPSILON && interp < 1.0 && interp >= SHAPE_INTERP_LIMIT)
                || !(above(z + -lift) >= -EPSILON)
            {
                return None;
            }
            pose.shift(down(h));
            pose.shift(down(lift));
        } else if !(a >= -EPSILON) {
            return None;
        }
        array.start(id, true);
        self.end(&pose, plane, false, None)
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
        let (id, cell) = self.lands_touched(array)?;
        let cells = array.entries();
        let to_rooms = self.distance_to_rooms(cells, &self.candidate)?;
        let mut over = OverLand {
            cell,
            plane: &cell.find_terrain_poly(self.low.xyz())?.plane,
            pose: self.candidate,
            low: self.low,
            contact: None,
        };
        settle(&mut over, MOVE_ATTEMPTS, None, 0.0)?;
        let moved = over.pose;
        // The cell that is left is asked before the ground of the next one is.
        if id != self.from.cell && !moved.has_bits_of(&self.candidate) {
            return None;
        }
        let objects = self.objects_on_lands(cells, &moved, false)?;
        if !moved.is_within(self.candidate.spheres[0], to_rooms) {
            return None;
        }
        if over.contact.is_none() {
            // The ground below (5.6).
            let h = self.search_depth();
            over.shift(down(h));
            settle(&mut over, STEP_DOWN_ATTEMPTS, Some(1.0), h)?;
            if over.contact?.normal.z < FLOOR_Z {
                return None;
            }
            if !over.pose.is_within(self.candidate.spheres[0], to_rooms) {
                self.distance_to_rooms(cells, &over.pose)?;
            }
            if !over.pose.is_within(moved.spheres[0], objects) {
                self.objects_on_lands(cells, &over.pose, true)?;
            }
            // It must be possible to be placed there.
            let Answer::Ok = over.insert(None, 0.0)? else {
                return None;
            };
        }
        let plane = Lanes::of_plane(&over.contact?);
        let end = self.end(&over.pose, plane, cell.water != Water::Not, None)?;
        Some(PlainEnd {
            cell: id,
            plane_cell: id,
            ..end
        })
    }

    /// Fills the array with the land cells touched, all of this landblock, and finds the one below the foot.
    #[inline(always)]
    fn lands_touched(&self, array: &mut CellArray) -> Option<(CellId, &LandCell)> {
        let id = self.from.cell;
        let own = self.block.land_cell(id)?;
        let [foot, head] = self.candidate.spheres;
        array.start(id, true);
        if own.certainly_holds([foot, head, self.low]) {
            return Some((id, own));
        }
        array.clear();
        let spheres = self.candidate.spheres();
        let spheres = spheres.get(..self.shape.count()).unwrap_or(&spheres);
        add_all_outside_cells(self.world, id, foot.xyz(), spheres, array);
        if !array.contains(id) {
            return None;
        }
        let mut below = None;
        for entry in array.entries() {
            let cell = self
                .block
                .land_cell(entry.id)
                .filter(|_| entry.id.block() == id.block())?;
            if cell.find_terrain_poly(self.low.xyz()).is_some() {
                // On a border, more than one.
                if below.is_some() {
                    return None;
                }
                below = Some((entry.id, cell));
            }
        }
        below
    }

    /// How far a pose may be shifted without touching a room of a building on one of these land cells, metres.
    fn distance_to_rooms(&self, cells: &[CellEntry], pose: &Candidate) -> Option<f32> {
        let spheres = pose.spheres();
        let spheres = spheres.get(..self.shape.count()).unwrap_or(&spheres);
        let mut least = f32::INFINITY;
        for entry in cells {
            let d = distance_to_rooms(self.world, self.block, self.block.land_cell(entry.id)?, spheres);
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

/// Inserts until terrain is satisfied.
#[inline(always)]
fn settle(over: &mut OverLand<'_>, attempts: u32, interp: Option<f32>, depth: f32) -> Option<()> {
    let mut interp = interp;
    for _ in 0..attempts {
        if let Answer::Ok = over.insert(interp.as_mut(), depth)? {
            return Some(());
        }
    }
    None
}
