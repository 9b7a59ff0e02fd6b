//! The bit sets of `transition.md` 2.1.

/// A set of named bits with the usual operations.
macro_rules! bit_set {
    ($(#[$meta:meta])* $name:ident : $int:ty { $($(#[$bit_meta:meta])* $bit:ident = $value:expr;)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
        pub struct $name(pub $int);

        impl $name {
            /// No bit.
            pub const NONE: Self = Self(0);
            $($(#[$bit_meta])* pub const $bit: Self = Self($value);)*

            /// Whether every bit of `other` is set.
            #[inline]
            pub const fn has(self, other: Self) -> bool {
                self.0 & other.0 == other.0
            }

            /// Whether some bit of `other` is set.
            #[inline]
            pub const fn has_any(self, other: Self) -> bool {
                self.0 & other.0 != 0
            }

            /// This set with the bits of `other`.
            #[inline]
            #[must_use]
            pub const fn with(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }

            /// This set without the bits of `other`.
            #[inline]
            #[must_use]
            pub const fn without(self, other: Self) -> Self {
                Self(self.0 & !other.0)
            }

            /// Sets or clears the bits of `other`.
            #[inline]
            pub fn set(&mut self, other: Self, on: bool) {
                *self = if on { self.with(other) } else { self.without(other) };
            }
        }

        impl core::ops::BitOr for $name {
            type Output = Self;
            fn bitor(self, other: Self) -> Self {
                self.with(other)
            }
        }
    };
}

bit_set! {
    /// What an OBJECTINFO says of the mover (`transition.md` 2.1).
    ObjectState: u32 {
        /// The body starts, or after a step continues, in contact with some plane.
        CONTACT = 0x1;
        /// That plane can be walked on.
        ON_WALKABLE = 0x2;
        /// Camera probe: no ground logic, passes creatures, counts steps its own way.
        IS_VIEWER = 0x4;
        /// Stop the sweep at the first collision normal: missiles and the camera.
        PATH_CLIPPED = 0x8;
        /// Adopt the end orientation at once instead of turning over the steps.
        FREE_ROTATE = 0x10;
        /// On a path-clipped hit move to the exact touching point instead of rejecting the step.
        PERFECT_CLIP = 0x40;
        /// Collides with players even as a player.
        IS_IMPENETRABLE = 0x80;
        /// Is a player.
        IS_PLAYER = 0x100;
        /// May not walk off edges and slides along them.
        EDGE_SLIDE = 0x200;
        /// Creatures are touched but do not stop the mover.
        IGNORE_CREATURES = 0x400;
        /// Player killer.
        IS_PK = 0x800;
        /// Lite player killer.
        IS_PKLITE = 0x1000;
    }
}

bit_set! {
    /// The physics state of an object (`transition.md` 2.1).
    PhysicsState: u32 {
        /// Never moves.
        STATIC = 0x1;
        /// Touched, never stops anything.
        ETHEREAL = 0x4;
        /// Reports what it runs into.
        REPORT_COLLISIONS = 0x8;
        /// With [`PhysicsState::ETHEREAL`]: not even touched.
        IGNORE_COLLISIONS = 0x10;
        /// Not drawn.
        NODRAW = 0x20;
        /// A missile: its path is clipped at the first hit.
        MISSILE = 0x40;
        /// Can be pushed.
        PUSHABLE = 0x80;
        /// Faces along its path.
        ALIGNPATH = 0x100;
        /// Its path is clipped.
        PATHCLIPPED = 0x200;
        /// Falls.
        GRAVITY = 0x400;
        /// Lights are on.
        LIGHTING_ON = 0x800;
        /// Emits particles.
        PARTICLE_EMITTER = 0x1000;
        /// Hidden: neither animates nor integrates.
        HIDDEN = 0x4000;
        /// Collisions are scripted.
        SCRIPTED_COLLISION = 0x8000;
        /// Collides by the physics BSPs of its parts.
        HAS_PHYSICS_BSP = 0x10000;
        /// Loses all velocity when it bounces.
        INELASTIC = 0x20000;
        /// Cloaked.
        CLOAKED = 0x10_0000;
        /// Whoever runs into it ran into the environment.
        REPORT_COLLISIONS_AS_ENVIRONMENT = 0x20_0000;
        /// Keeps off edges.
        EDGE_SLIDE = 0x40_0000;
        /// Slides downhill.
        SLEDDING = 0x80_0000;
        /// Not integrated.
        FROZEN = 0x100_0000;
        /// What a body starts with: edge sliding, lighting, gravity, reports.
        DEFAULT = 0x40_0C08;
    }
}

bit_set! {
    /// What a body carries from one move to the next (`transition.md` 2.1).
    TransientState: u32 {
        /// In contact with a plane.
        CONTACT = 0x1;
        /// On ground that can be walked on.
        ON_WALKABLE = 0x2;
        /// Slid along something in its last move.
        SLIDING = 0x4;
        /// The contact plane is water.
        WATER_CONTACT = 0x8;
        /// Made no progress in its last move.
        STATIONARY_FALL = 0x10;
        /// Made no progress in its last two moves.
        STATIONARY_STOP = 0x20;
        /// Made no progress in its last three moves.
        STATIONARY_STUCK = 0x40;
        /// Is integrated.
        ACTIVE = 0x80;
        /// Waits for room to stop being ethereal.
        CHECK_ETHEREAL = 0x100;
    }
}

bit_set! {
    /// How a body is to be placed (`transition.md` 2.1, `world.md` 16).
    SetPositionFlags: u32 {
        /// Placed rather than moved; informs the caller's bookkeeping only.
        PLACEMENT = 0x1;
        /// Teleported; informs the caller's bookkeeping only.
        TELEPORT = 0x2;
        /// Restored; informs the caller's bookkeeping only.
        RESTORE = 0x4;
        /// May be put aside when the place is taken.
        SLIDE = 0x10;
        /// Keep to the cells seen from the one named (`world.md` 13.5).
        DONOTCREATECELLS = 0x20;
        /// When the exact position fails, try others around it.
        SCATTER = 0x100;
        /// Only try positions around it.
        RANDOMSCATTER = 0x200;
        /// Informs the caller's bookkeeping only.
        LINE = 0x400;
        /// Informs the caller's bookkeeping only.
        SEND_POSITION_EVENT = 0x1000;
    }
}

bit_set! {
    /// What the game says of an object, as far as collisions ask (`transition.md` 2.4, 8.2).
    ObjectKind: u32 {
        /// There is a game object behind it.
        HAS_GAME_OBJECT = 0x1;
        /// A creature; players are creatures too.
        CREATURE = 0x2;
        /// A player.
        PLAYER = 0x4;
        /// Collides with players even as a player.
        IMPENETRABLE = 0x8;
        /// Player killer.
        PK = 0x10;
        /// Lite player killer.
        PKLITE = 0x20;
        /// Storage, corpse or hook: placed without a collision test (`world.md` 16.3b).
        FORCED_PLACEMENT = 0x40;
        /// May enter restricted cells (`transition.md` 7.5).
        BYPASSES_RESTRICTIONS = 0x80;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn s2_1_the_default_state_is_the_sum_of_its_parts() {
        let parts = PhysicsState::EDGE_SLIDE
            | PhysicsState::LIGHTING_ON
            | PhysicsState::GRAVITY
            | PhysicsState::REPORT_COLLISIONS;
        assert_eq!(PhysicsState::DEFAULT, parts);
    }

    #[test]
    fn bits_are_set_and_cleared() {
        let mut s = ObjectState::CONTACT | ObjectState::EDGE_SLIDE;
        s.set(ObjectState::CONTACT, false);
        s.set(ObjectState::ON_WALKABLE, true);
        assert_eq!(s.0, 0x202);
        assert!(s.has(ObjectState::EDGE_SLIDE) && !s.has(ObjectState::EDGE_SLIDE | ObjectState::CONTACT));
        assert!(s.has_any(ObjectState::EDGE_SLIDE | ObjectState::CONTACT));
    }
}
