//! The usual step on terrain, worked out without a transition (`transition.md` 5.6, 5.8, 7.3); see
//! [`crate::plain_step`].

use vestibule_world::{
    Building, CellArray, CellEntry, CellId, LandCell, Lanes, Plane, Sphere, Water, certain_land_cells,
};

use crate::candidate::{Candidate, Shape, distance_to_sphere, down};
use crate::constants::{EPSILON, FLOOR_Z, MOVE_ATTEMPTS, SHAPE_INTERP_LIMIT, STEP_DOWN_ATTEMPTS};
use crate::object_info::is_walkable_z;
use crate::plain_step::{PlainEnd, PlainStep};
use crate::plain_walls::Known;
use crate::sweep::Scratch;

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

/// A step on a land cell, if it is a usual one.
#[inline(always)]
pub(crate) fn plain_step_on_land(
    step: &PlainStep<'_>,
    scratch: &mut Scratch,
    found: &mut Option<Known>,
) -> Option<PlainEnd> {
    let (id, block) = (step.from.cell, step.block);
    let cell = block.land_cell(id)?;
    let drowned = block
        .land
        .as_ref()
        .is_none_or(|land| land.water == Water::Entirely);
    let spheres = step.candidate.spheres();
    let spheres = spheres.get(..step.shape.count()).unwrap_or(&spheres);
    let to_cells = certain_land_cells(step.world, block, id, cell, spheres, &mut scratch.cell_array);
    let end = step.on_certain_land(id, cell, to_cells, drowned, &scratch.cell_array);
    if end.is_none() {
        *found = Some(Known::cells(&step.candidate, to_cells));
    }
    end
}

impl PlainStep<'_> {
    /// On a land cell that is the only one touched, also up to `to_cells` from the candidate.
    #[inline(always)]
    fn on_certain_land(
        &self,
        id: CellId,
        cell: &LandCell,
        to_cells: f32,
        drowned: bool,
        array: &CellArray,
    ) -> Option<PlainEnd> {
        if !(to_cells > 0.0) || cell.restriction.is_some() || drowned {
            return None;
        }
        let mut over = OverLand {
            cell,
            plane: &cell.find_terrain_poly(self.low.xyz())?.plane,
            pose: self.candidate,
            low: self.low,
            contact: None,
        };
        settle(&mut over, MOVE_ATTEMPTS, None, 0.0)?;
        let moved = over.pose;
        let others = array.entries().get(1..)?;
        let objects = self.objects_on_lands(id, cell, others, &moved, false)?;
        if !moved.is_within(self.candidate.spheres[0], to_cells) {
            return None;
        }
        if over.contact.is_none() {
            // The ground below (5.6).
            let h = self.search_depth();
            over.shift(down(h));
            settle(&mut over, STEP_DOWN_ATTEMPTS, Some(1.0), h)?;
            if !over.pose.is_within(self.candidate.spheres[0], to_cells)
                || !(over.pose.is_within(moved.spheres[0], objects)
                    || self
                        .objects_on_lands(id, cell, others, &over.pose, true)
                        .is_some())
                || over.contact?.normal.z < FLOOR_Z
            {
                return None;
            }
            // It must be possible to be placed there.
            let Answer::Ok = over.insert(None, 0.0)? else {
                return None;
            };
        }
        let plane = Lanes::of_plane(&over.contact?);
        self.end(&over.pose, plane, cell.water != Water::Not, None)
    }

    /// As [`PlainStep::objects_on_land`] in all land cells that a pose touches. The others' ground is not under it, nor
    /// may they be watched over.
    #[inline(always)]
    fn objects_on_lands(
        &self,
        id: CellId,
        cell: &LandCell,
        others: &[CellEntry],
        pose: &Candidate,
        placing: bool,
    ) -> Option<f32> {
        let mut least = self.objects_on_land(id, cell, pose, placing)?;
        for entry in others {
            let other = self.block.land_cell(entry.id)?;
            let upright = self.low.has_xy_of(self.candidate.spheres[0]);
            if other.restriction.is_some() || !upright {
                return None;
            }
            let d = self.objects_on_land(entry.id, other, pose, placing)?;
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
