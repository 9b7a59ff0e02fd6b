//! The static objects that a mover may run into near where it is, remembered over the small shifts of a step
//! (`transition.md` 7.7).

use vestibule_world::{CellId, Landblock, Lanes, StaticObject};

use crate::statics_around::distance_to_statics;
use crate::transition::Transition;

/// The static objects of a cell in reach of a mover.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearStatics<'w> {
    cell: CellId,
    /// Where the foot sphere was.
    foot: Lanes,
    /// How far it may be shifted before it comes near any other object, squared.
    reach: f32,
    /// In order of entry.
    objects: Objects<'w>,
}

/// A few static objects, those there are first.
type Objects<'w> = [Option<&'w StaticObject>; 4];

impl NearStatics<'_> {
    /// Nothing is known.
    pub(crate) const NONE: Self = NearStatics {
        cell: CellId::NONE,
        foot: Lanes::ZERO,
        reach: 0.0,
        objects: [None; 4],
    };

    /// Whether it is right for a cell and a foot sphere.
    #[inline(always)]
    fn holds(&self, cell: CellId, foot: Lanes) -> bool {
        let shift = foot - self.foot;
        self.cell == cell && shift.dot(shift) < self.reach
    }
}

impl<'w> Transition<'w, '_> {
    /// Whether no body but the mover itself reaches into a cell.
    #[inline(always)]
    fn is_alone_in(&self, cell: CellId) -> bool {
        !self.population.has_bodies() || self.population.is_alone_in(cell, self.object.body)
    }

    /// Whether there certainly is no object of the cell in reach of the candidate, shifted so that its foot sphere
    /// is at `foot`.
    #[inline(always)]
    pub(crate) fn has_no_objects_near(&self, cell: CellId, block: &'w Landblock, foot: Lanes) -> bool {
        if !self.is_alone_in(cell) {
            return false;
        }
        let calm = |near: &NearStatics<'_>| near.objects[0].is_none() && near.holds(cell, foot);
        self.near_statics.iter().any(calm) || self.world.shadow_lists(block).is_empty_in(cell)
    }

    /// As [`Transition::has_no_objects_near`] at the candidate itself, looking closer.
    pub(crate) fn has_objects_afar(&self, cell: CellId, block: &'w Landblock) -> bool {
        self.has_no_objects_near(cell, block, self.path.global_sphere[0])
            || (self.is_alone_in(cell) && self.may_remember(cell) && {
                let (shape, at) = (self.path.shape(), self.path.candidate());
                let quads = self.world.shadow_lists(block).quads(cell);
                distance_to_statics(quads, at.spheres, shape.larger_radius()) > 0.0
            })
    }

    /// The static objects of a cell in reach of the candidate, if there is nothing else to run into in it and they are
    /// few.
    #[inline(always)]
    pub(crate) fn only_statics_near(&mut self, cell: CellId, block: &'w Landblock) -> Option<Objects<'w>> {
        if !self.is_alone_in(cell) {
            return None;
        }
        // One is for the own cell, one for the others.
        let slot = usize::from(cell != self.path.check_pos.cell);
        if !self.near_statics[slot].holds(cell, self.path.global_sphere[0])
            && !self.look_for_statics(cell, block, slot)
        {
            return None;
        }
        Some(self.near_statics[slot].objects)
    }

    /// Shifts are measured in the frame of one landblock, from spheres that keep their places to each other.
    #[inline(always)]
    fn may_remember(&self, cell: CellId) -> bool {
        self.keeps_shape && cell.block() == self.path.check_pos.cell.block() && !self.world.settings().exact
    }

    /// Fills a slot; `false` when that is not to be.
    #[inline(never)]
    fn look_for_statics(&mut self, cell: CellId, block: &'w Landblock, slot: usize) -> bool {
        /// Objects nearer than this may be in reach after a small shift, metres.
        const MARGIN: f32 = 0.25;
        if !self.may_remember(cell) {
            return false;
        }
        let lists = self.world.shadow_lists(block);
        let (path, shape) = (&self.path, self.path.shape());
        let mut objects = [None; 4];
        let mut count = 0;
        let mut least = Lanes::splat(f32::INFINITY);
        for (four, quad) in lists.of(cell).chunks(4).zip(lists.quads(cell)) {
            let mut distances = quad.distances(path.candidate().spheres, shape.larger_radius());
            let mut near = !Lanes::splat(MARGIN).less(distances) & 0b1111;
            while near != 0 {
                let k = near.trailing_zeros() as usize;
                near &= near - 1;
                distances.set_lane(k, f32::INFINITY);
                if let Some(object) = four.get(k).and_then(|&r| self.world.static_object(r)) {
                    let Some(next) = objects.get_mut(count) else {
                        return false;
                    };
                    *next = Some(object);
                    count += 1;
                }
            }
            least = distances.lesser(least);
        }
        let least = least.least();
        self.near_statics[slot] = NearStatics {
            cell,
            foot: path.global_sphere[0],
            reach: least * least,
            objects,
        };
        true
    }
}
