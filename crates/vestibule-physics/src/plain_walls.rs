//! The usual collision, worked out without a transition: a walker against walls of the rooms it is in, out of reach of
//! objects, with nothing to step up onto (`transition.md` 5.1 to 5.3, 5.5, 5.7, 5.12, 6.10, 6.11.2); see
//! [`crate::plain_step`].

use glam::Vec3;
use vestibule_world::{CellArray, EnvCell, Face, Lanes};

use crate::bsp_tree;
use crate::candidate::{Candidate, local_center};
use crate::collision_info::collision_normal;
use crate::constants::{EPSILON, FLOOR_Z, MOVE_ATTEMPTS};
use crate::object_info::is_walkable_z;
use crate::plain_step::{PlainEnd, PlainStep, search_below};

/// What is known of the surroundings of candidates.
#[derive(Clone, Copy)]
pub(crate) struct Known {
    /// The cell array is that of these spheres of a candidate.
    pub(crate) cells_at: [Lanes; 2],
    /// How far it may be shifted without changing the array, metres.
    pub(crate) to_cells: f32,
    /// A candidate with its foot sphere here touches no object.
    pub(crate) objects_at: Lanes,
    /// How far it may be shifted without coming near one, metres.
    pub(crate) to_objects: f32,
}

impl Known {
    /// The cells of a candidate, nothing of objects.
    #[inline(always)]
    pub(crate) fn cells(at: &Candidate, to_cells: f32) -> Self {
        Known {
            cells_at: at.spheres,
            to_cells,
            objects_at: at.spheres[0],
            to_objects: 0.0,
        }
    }

    /// Makes sure that the cell array is that of a pose; `false` when none is certain.
    #[inline(always)]
    pub(crate) fn cells_of(
        &mut self,
        step: &PlainStep<'_>,
        own: &EnvCell,
        at: &Candidate,
        array: &mut CellArray,
    ) -> bool {
        if !at.is_within(self.cells_at[0], self.to_cells) {
            self.cells_at = at.spheres;
            self.to_cells = step.certain_rooms(own, at, array);
            // What is near other cells is not known.
            self.to_objects = 0.0;
        }
        self.to_cells > 0.0
    }
}

/// Where walls leave a candidate.
pub(crate) enum Slide {
    /// There, having run into something with this normal, if into anything.
    To(Candidate, Option<Vec3>),
    /// Nowhere: it is rejected, having run into something with this normal.
    Stopped(Vec3),
}

/// How a cell answers an insertion.
enum Answer {
    Ok,
    Slid,
    Collided,
}

/// An overlap with a surface that is not moved into (5.5).
struct NegPolyHit {
    step_up: bool,
    normal: Lanes,
}

/// A candidate among walls.
struct AmongWalls<'a, 's> {
    step: &'a PlainStep<'s>,
    cell: &'a EnvCell,
    known: &'a mut Known,
    array: &'a mut CellArray,
    pose: Candidate,
    neg_poly_hit: Option<NegPolyHit>,
    /// What was run into last.
    normal: Option<Lanes>,
}

impl PlainStep<'_> {
    /// Inserts the candidate, which is not clear of walls. `None` where that is not usual. `known` is kept up.
    #[inline(never)]
    pub(crate) fn slide_along_walls(
        &self,
        cell: &EnvCell,
        known: &mut Known,
        array: &mut CellArray,
    ) -> Option<Slide> {
        let mut among = AmongWalls {
            step: self,
            cell,
            known,
            array,
            pose: self.candidate,
            neg_poly_hit: None,
            normal: None,
        };
        for _ in 0..MOVE_ATTEMPTS {
            let before = among.pose;
            match among.insert()? {
                Answer::Ok => {}
                Answer::Slid if among.stays(&before) => break,
                Answer::Slid => {
                    among.neg_poly_hit = None;
                    continue;
                }
                Answer::Collided => break,
            }
            let Some(hit) = among.neg_poly_hit.take() else {
                return Some(Slide::To(among.pose, among.collision_normal()));
            };
            if hit.step_up {
                among.step_up_in_vain()?;
            }
            among.slide(hit.normal)?;
            if among.stays(&before) {
                break;
            }
        }
        among.collision_normal().map(Slide::Stopped)
    }

    /// The sweep puts the mover back (5.11), standing on what it stood on.
    #[inline(never)]
    pub(crate) fn stop(
        &self,
        cell: &EnvCell,
        hit: Vec3,
        known: &mut Known,
        array: &mut CellArray,
    ) -> Option<PlainEnd> {
        let at = Candidate::at(self.from.frame.origin.into(), &self.shape);
        let plane = Lanes::of_plane(&self.contact.plane);
        let radius = self.shape.arms[0].fourth();
        let stands = radius + EPSILON > plane.dist(at.spheres[0]).abs() && is_walkable_z(plane.z());
        let certain = stands && known.cells_of(self, cell, &at, array);
        certain.then_some(PlainEnd {
            cell: self.from.cell,
            origin: at.origin,
            plane,
            plane_cell: self.contact.cell,
            is_water: self.contact.is_water,
            hit: Some(hit),
            stopped: true,
        })
    }
}

impl AmongWalls<'_, '_> {
    fn collision_normal(&self) -> Option<Vec3> {
        self.normal.map(|n| collision_normal(n.xyz()))
    }

    /// Whether what was done left the candidate where it was before: then the same would be done again.
    #[inline(always)]
    fn stays(&self, before: &Candidate) -> bool {
        self.pose.has_bits_of(before)
    }

    /// Makes sure that the cell array is that of the pose.
    #[inline(always)]
    fn know_cells(&mut self) -> Option<()> {
        let certain = self.known.cells_of(self.step, self.cell, &self.pose, self.array);
        if certain { Some(()) } else { None }
    }

    /// Makes sure that the pose touches no object of any cell that it reaches.
    #[inline(always)]
    fn know_objects(&mut self) -> Option<()> {
        if self.pose.is_within(self.known.objects_at, self.known.to_objects) {
            return Some(());
        }
        let mut least = f32::INFINITY;
        for entry in self.array.entries() {
            let d = self.step.objects_around(entry.id, &self.pose, false)?;
            least = if d < least { d } else { least };
        }
        self.known.objects_at = self.pose.spheres[0];
        self.known.to_objects = least;
        Some(())
    }

    /// One attempt: the own room, several times, then the others (5.2, 5.3).
    #[inline(always)]
    fn insert(&mut self) -> Option<Answer> {
        let own = self.cell;
        for _ in 0..MOVE_ATTEMPTS {
            let before = self.pose;
            match self.find_collisions(own)? {
                Answer::Ok => {
                    self.know_cells()?;
                    self.know_objects()?;
                    return self.insert_into_others();
                }
                Answer::Collided => return Some(Answer::Collided),
                Answer::Slid if self.stays(&before) => break,
                Answer::Slid => {}
            }
        }
        Some(Answer::Slid)
    }

    #[inline(always)]
    fn insert_into_others(&mut self) -> Option<Answer> {
        let mut i = 1;
        while let Some(entry) = self.array.get(i) {
            let other = self.step.block.env_cell(entry.id)?;
            if other.restriction.is_some() {
                return None;
            }
            match self.find_collisions(other)? {
                Answer::Ok => {}
                answer => return Some(answer),
            }
            i += 1;
        }
        Some(Answer::Ok)
    }

    /// What a room's walls answer a mover in contact (6.10).
    fn find_collisions(&mut self, cell: &EnvCell) -> Option<Answer> {
        let step = self.step;
        let shape = &step.shape;
        let bsp = cell.structure.physics.as_ref()?;
        if self.pose.is_in_the_open(shape, cell) {
            return Some(Answer::Ok);
        }
        let frame = &cell.frame;
        let foot = self.pose.local(shape, frame, 0);
        let movement = foot.with_fourth(0.0) - local_center(step.from.frame.origin.into(), shape, frame, 0);
        let normal = |face: &Face| frame.turned_out(Lanes::of_plane(&face.plane));
        let mut foot_poly = None;
        let foot_hit = bsp_tree::sphere_intersects_poly(bsp, foot, movement, &mut foot_poly);
        if let (true, Some(face)) = (foot_hit, foot_poly) {
            self.step_up_in_vain()?;
            return self.slide(normal(face));
        }
        if shape.two {
            let mut head_poly = None;
            let head = self.pose.local(shape, frame, 1);
            let head_hit = bsp_tree::sphere_intersects_poly(bsp, head, movement, &mut head_poly);
            match (head_hit, head_poly) {
                (true, Some(face)) => return self.slide(normal(face)),
                (false, Some(face)) => self.note(false, normal(face)),
                (_, None) => {
                    if let Some(face) = foot_poly {
                        self.note(true, normal(face));
                    }
                }
            }
        }
        Some(Answer::Ok)
    }

    #[inline(always)]
    fn note(&mut self, step_up: bool, normal: Lanes) {
        self.neg_poly_hit = Some(NegPolyHit {
            step_up,
            normal: Lanes::from(-normal.xyz()),
        });
    }

    /// A step up that certainly finds no ground, after which the candidate is placed anew (5.7). `None` where it
    /// may find some.
    #[inline(always)]
    fn step_up_in_vain(&mut self) -> Option<()> {
        self.know_cells()?;
        self.know_objects()?;
        let step = self.step;
        let h = step.mover.step_up_height;
        let finds_floor = |cell: &EnvCell| search_below(cell, &step.shape, &self.pose, h, FLOOR_Z).is_some();
        if finds_floor(self.cell) {
            return None;
        }
        for entry in self.array.entries().get(1..)? {
            let other = step.block.env_cell(entry.id)?;
            if other.restriction.is_some() || finds_floor(other) {
                return None;
            }
        }
        self.pose = Candidate::at(self.pose.origin, &step.shape);
        Some(())
    }

    /// Slides the foot sphere along a surface, on the plane stood on before (5.12).
    fn slide(&mut self, n: Lanes) -> Option<Answer> {
        let curr = Lanes::from(self.step.from.frame.origin) + self.step.shape.arms[0];
        let floor = self.step.contact.plane.normal;
        let normal = n.xyz();
        if normal == Vec3::ZERO {
            return None;
        }
        self.normal = Some(n);
        let g = Lanes::ZERO + self.pose.spheres[0] - curr;
        let crease = Lanes::from(normal.cross(floor));
        let squared = crease.dot(crease);
        if squared >= EPSILON {
            let along = crease * crease.dot(g) / squared;
            if along.dot(along) < EPSILON {
                return Some(Answer::Collided);
            }
            self.pose.shift(along - g);
            return Some(Answer::Slid);
        }
        // Between a floor and what is level itself: seldom.
        None
    }
}
