//! Where things stand and how they are turned.

use glam::{DQuat, DVec2, DVec3};

use crate::text::{Above, Span};

/// A rigid motion: `outer = origin + rotation * inner`. Metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    pub(crate) origin: DVec3,
    pub(crate) rotation: DQuat,
}

impl Placement {
    pub(crate) const IDENTITY: Self = Placement {
        origin: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
    };

    pub(crate) fn to_outer(self, p: DVec3) -> DVec3 {
        self.origin + self.rotation * p
    }

    pub(crate) fn to_inner(self, p: DVec3) -> DVec3 {
        self.rotation.conjugate() * (p - self.origin)
    }

    /// `self` inside `outer`, as seen from outside of both.
    pub(crate) fn within(self, outer: Placement) -> Placement {
        Placement {
            origin: outer.to_outer(self.origin),
            rotation: (outer.rotation * self.rotation).normalize(),
        }
    }
}

/// A turn about x, then y, then z, degrees. About z it is counter-clockwise seen from above.
pub(crate) fn rotation(z: f64, x: f64, y: f64) -> DQuat {
    let about = |axis: DVec3, degrees: f64| {
        let half = degrees.to_radians() * 0.5;
        let (sin, cos) = (libm::sin(half), libm::cos(half));
        DQuat::from_xyzw(axis.x * sin, axis.y * sin, axis.z * sin, cos)
    };
    about(DVec3::Z, z) * about(DVec3::Y, y) * about(DVec3::X, x)
}

/// A place as written: its height may be above the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaceDef {
    pub(crate) at: DVec2,
    pub(crate) height: Above,
    pub(crate) rotation: DQuat,
    pub(crate) span: Span,
}

impl PlaceDef {
    /// With heights above the ground resolved.
    pub(crate) fn resolve(&self, ground: impl Fn(DVec2) -> f64) -> Placement {
        let base = if self.height.ground { ground(self.at) } else { 0.0 };
        Placement {
            origin: self.at.extend(base + self.height.metres),
            rotation: self.rotation,
        }
    }
}

/// A turn about z, degrees.
pub(crate) fn turned(degrees: f64) -> DQuat {
    rotation(degrees, 0.0, 0.0)
}
