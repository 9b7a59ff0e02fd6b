//! Time: which quanta are integrated, and one step of a body (`transition.md` 9.3, 9.8).

use vestibule_world::ids::block_offset;
use vestibule_world::{Frame, Position, World};

use crate::constants::{EPSILON, HUGE_QUANTUM, INACTIVITY_DISTANCE, MAX_QUANTUM, MIN_QUANTUM};
use crate::error::SweepError;
use crate::flags::{PhysicsState, TransientState};
use crate::math::{heading_to_rotation, length, vector_to_heading};
use crate::population::{BodyId, Population};
use crate::sweep::{Scratch, Swept};

/// The pieces in which a span of time is integrated (`transition.md` 9.8). Iterate over the lengths in seconds;
/// what is too short is left for later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quanta {
    rest: f64,
}

impl Quanta {
    /// The pieces of `elapsed` seconds: none of a span over two seconds, which is dropped.
    pub fn of(elapsed: f64) -> Self {
        let usable = elapsed > f64::from(EPSILON) && elapsed <= HUGE_QUANTUM;
        Quanta {
            rest: if usable { elapsed } else { 0.0 },
        }
    }

    /// Whether the clock is set to now, whatever is integrated: no time has passed, or too much.
    pub fn resets_clock(elapsed: f64) -> bool {
        !(elapsed > f64::from(EPSILON) && elapsed <= HUGE_QUANTUM)
    }
}

impl Iterator for Quanta {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        let q = if self.rest > MAX_QUANTUM {
            MAX_QUANTUM
        } else if self.rest > MIN_QUANTUM {
            self.rest
        } else {
            return None;
        };
        self.rest -= q;
        Some(q)
    }
}

/// What a body is to do in a step of a [`crate::Simulation`].
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "made and used at once, never stored in bulk"
)]
pub(crate) enum Motive {
    /// To sweep, after its own motion over `q` seconds.
    Sweep { from: Position, to: Position, q: f32 },
    /// To be stepped by itself.
    Alone,
}

impl Population {
    /// Moves a body on to the time `now`, seconds on the caller's clock, by its own motion and physics
    /// (`transition.md` 9.8). What happens is left in [`Scratch::events`].
    ///
    /// # Errors
    /// No such body. A body whose numbers have become unusable is stopped where it is and reported.
    pub fn update(
        &mut self,
        world: &World,
        scratch: &mut Scratch,
        id: BodyId,
        now: f64,
    ) -> Result<(), SweepError> {
        self.update_with(world, scratch, id, now, |body, q| {
            body.locomotion
                .map_or(Frame::IDENTITY, |legs| legs.root_motion(q))
        })
    }

    /// As [`Population::update`], with the body-local displacement and turn of each quantum from `motion`
    /// instead of the body's own: an animation's root motion, or a creature's steps. It counts on walkable ground
    /// only.
    ///
    /// # Errors
    /// As [`Population::update`].
    pub fn update_with(
        &mut self,
        world: &World,
        scratch: &mut Scratch,
        id: BodyId,
        now: f64,
        motion: impl Fn(&crate::body::Body, f32) -> Frame,
    ) -> Result<(), SweepError> {
        scratch.events.clear();
        let Some(elapsed) = self.elapsed(id, now)? else {
            return Ok(());
        };
        for q in Quanta::of(elapsed) {
            if let Some(body) = self.body_mut(id) {
                body.update_time += q;
            }
            self.update_internal(world, scratch, id, q as f32, &motion)?;
        }
        Ok(())
    }

    /// Whether the body is too far from the observer to be integrated.
    fn is_far(&self, id: BodyId) -> bool {
        let (Some(observer), Some(body)) = (self.observer.and_then(|o| self.body(o)), self.body(id)) else {
            return false;
        };
        if Some(id) == self.observer || observer.cell.is_none() {
            return false;
        }
        length(observer.position.offset_to(&body.position)) > INACTIVITY_DISTANCE
    }

    /// One integration step (retail `UpdateObjectInternal`, `transition.md` 9.3).
    fn update_internal(
        &mut self,
        world: &World,
        scratch: &mut Scratch,
        id: BodyId,
        q: f32,
        motion: &impl Fn(&crate::body::Body, f32) -> Frame,
    ) -> Result<(), SweepError> {
        let Some(body) = self.body(id) else { return Ok(()) };
        if !body.transient.has(TransientState::ACTIVE) || body.cell.is_none() {
            return Ok(());
        }
        if body.transient.has(TransientState::CHECK_ETHEREAL) {
            self.try_end_ethereal(world, scratch, id);
        }
        if let Some((from, to)) = self.integrate(scratch, id, q, motion)? {
            let swept = match self.sweep(world, scratch, id, &to) {
                Ok(swept) => swept,
                Err(error) => {
                    if let Some(body) = self.body_mut(id) {
                        body.halt();
                    }
                    return Err(error);
                }
            };
            self.end_update(world, scratch, id, &from, &to, q, &swept);
        }
        Ok(())
    }

    /// The first half of an integration step: the body's own motion. `None` when there is nothing to sweep, else
    /// where from and where to.
    fn integrate(
        &mut self,
        _scratch: &mut Scratch,
        id: BodyId,
        q: f32,
        motion: &impl Fn(&crate::body::Body, f32) -> Frame,
    ) -> Result<Option<(Position, Position)>, SweepError> {
        let Some(body) = self.body_mut(id) else {
            return Ok(None);
        };
        body.jumped_this_frame = false;
        let old = body.position;
        let root = motion(body, q);
        let root = if root.is_finite() { root } else { Frame::IDENTITY };
        let mut frame = body.update_position(q, &root);
        if !frame.is_finite() {
            body.halt();
            return Err(SweepError::NotFinite {
                what: "motion of the body",
            });
        }
        if !body.has_spheres() {
            if body.locomotion.is_none() && body.is_on_walkable() {
                body.transient.set(TransientState::ACTIVE, false);
            }
            body.set_frame(Frame::new(old.frame.origin, frame.rotation()));
            return Ok(None);
        }
        let moved = frame.origin - old.frame.origin;
        if moved.abs().max_element() < EPSILON {
            body.set_frame(Frame::new(old.frame.origin, frame.rotation()));
            body.cached_velocity = glam::Vec3::ZERO;
            self.move_children_of(id);
            return Ok(None);
        }
        if body.state.has(PhysicsState::ALIGNPATH) {
            frame.set_rotation(heading_to_rotation(vector_to_heading(moved)));
        } else if body.state.has(PhysicsState::SLEDDING) && body.velocity != glam::Vec3::ZERO {
            frame.set_rotation(heading_to_rotation(vector_to_heading(body.velocity)));
        }
        let to = Position {
            cell: old.cell,
            frame,
        };
        Ok(Some((old, to)))
    }

    /// The second half of an integration step: what the sweep found is written back. `scratch` must be as the
    /// sweep left it.
    #[expect(clippy::too_many_arguments, reason = "the two halves of a step share them")]
    pub(crate) fn end_update(
        &mut self,
        world: &World,
        scratch: &mut Scratch,
        id: BodyId,
        from: &Position,
        to: &Position,
        q: f32,
        swept: &Swept,
    ) {
        let Some(body) = self.body_mut(id) else { return };
        if swept.ok {
            body.cached_velocity = from.offset_to(&swept.position) / q;
            self.commit(world, scratch, id, swept);
        } else {
            body.set_frame(Frame::new(from.frame.origin, to.frame.rotation()));
            body.cached_velocity = glam::Vec3::ZERO;
            self.move_children_of(id);
        }
    }

    /// Begins a step to the time `now` whose sweep is made elsewhere: the body's own motion is integrated.
    /// `None` when there is nothing to sweep.
    pub(crate) fn begin_update(
        &mut self,
        scratch: &mut Scratch,
        id: BodyId,
        now: f64,
    ) -> Result<Option<Motive>, SweepError> {
        let Some(elapsed) = self.elapsed(id, now)? else {
            return Ok(None);
        };
        let mut quanta = Quanta::of(elapsed);
        let (Some(q), None) = (quanta.next(), quanta.next()) else {
            // Nothing is due, or more than one piece of time.
            return Ok(Quanta::of(elapsed).next().map(|_| Motive::Alone));
        };
        let body = self.body_mut(id).ok_or(SweepError::NoSuchBody)?;
        if body.transient.has(TransientState::CHECK_ETHEREAL) || !body.children.is_empty() {
            return Ok(Some(Motive::Alone));
        }
        body.update_time += q;
        let motion = |body: &crate::body::Body, q: f32| {
            body.locomotion
                .map_or(Frame::IDENTITY, |legs| legs.root_motion(q))
        };
        let moved = self.integrate(scratch, id, q as f32, &motion)?;
        Ok(moved.map(|(from, to)| Motive::Sweep {
            from,
            to,
            q: q as f32,
        }))
    }

    /// The time that has passed for a body, seconds; `None` when it rests, or its clock had to be set.
    fn elapsed(&mut self, id: BodyId, now: f64) -> Result<Option<f64>, SweepError> {
        let far = self.is_far(id);
        let body = self.body_mut(id).ok_or(SweepError::NoSuchBody)?;
        if !now.is_finite() {
            return Err(SweepError::NotFinite { what: "time" });
        }
        if body.parent.is_some() || body.cell.is_none() || body.state.has(PhysicsState::FROZEN) || far {
            body.transient.set(TransientState::ACTIVE, false);
            return Ok(None);
        }
        if !body.state.has(PhysicsState::STATIC) && !body.transient.has(TransientState::ACTIVE) {
            body.transient.set(TransientState::ACTIVE, true);
            body.update_time = now;
        }
        let elapsed = now - body.update_time;
        if Quanta::resets_clock(elapsed) {
            body.update_time = now;
            return Ok(None);
        }
        Ok(Some(elapsed))
    }

    fn move_children_of(&mut self, id: BodyId) {
        if self.body(id).is_some_and(|body| !body.children.is_empty()) {
            self.move_children(id);
        }
    }

    /// Distance between two bodies, metres, across landblocks; `None` when there is no such body.
    pub fn distance(&self, a: BodyId, b: BodyId) -> Option<f32> {
        let (a, b) = (self.body(a)?.position, self.body(b)?.position);
        let between = block_offset(a.cell.block(), b.cell.block()) + b.origin() - a.origin();
        Some(length(between))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quanta(elapsed: f64) -> Vec<f64> {
        Quanta::of(elapsed).collect()
    }

    fn close(a: &[f64], b: &[f64]) -> bool {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    #[test]
    fn w60_quanta() {
        assert!(close(&quanta(0.5), &[0.2, 0.2, 0.1]));
        assert!(close(&quanta(0.42), &[0.2, 0.2]));
        assert!(close(&quanta(2.5), &[]) && Quanta::resets_clock(2.5));
        assert!(close(&quanta(0.03), &[]) && !Quanta::resets_clock(0.03));
        assert!(Quanta::resets_clock(0.0001) && Quanta::resets_clock(-1.0) && Quanta::resets_clock(f64::NAN));
        assert!(close(&quanta(0.05), &[0.05]));
    }
}
