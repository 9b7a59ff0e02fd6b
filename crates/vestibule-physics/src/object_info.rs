//! The mover as a sweep sees it (retail `OBJECTINFO`, `transition.md` 2.4).

use crate::constants::FLOOR_Z;
use crate::flags::{ObjectKind, ObjectState};
use crate::population::BodyId;

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ObjectInfo {
    pub(crate) state: ObjectState,
    pub(crate) step_up_height: f32,
    pub(crate) step_down_height: f32,
    pub(crate) ethereal: bool,
    /// The mover looks for ground below: all but missiles.
    pub(crate) step_down: bool,
    pub(crate) missile: bool,
    pub(crate) gravity: bool,
    pub(crate) kind: ObjectKind,
    /// The body that moves, which does not collide with itself.
    pub(crate) body: Option<BodyId>,
    /// What a missile is meant for.
    pub(crate) target: Option<BodyId>,
}

impl ObjectInfo {
    #[inline]
    pub(crate) fn is(&self, bits: ObjectState) -> bool {
        self.state.has_any(bits)
    }
}

/// Whether ground with this normal z can be walked on (retail `is_valid_walkable`).
#[inline]
pub(crate) fn is_walkable_z(z: f32) -> bool {
    z >= FLOOR_Z
}
