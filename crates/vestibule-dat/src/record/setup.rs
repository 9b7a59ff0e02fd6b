//! Setup, `02......` (`dat-format.md` 10.3).

use glam::Vec3;

use crate::primitive::{Argb, CylSphere, Frame, Sphere};

/// An object of several parts, with what it collides as.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Setup {
    /// Data id as stored.
    pub id: u32,
    /// Bit 0 parent indices, 1 default scales, 2 allow free heading, 3 has a physics BSP.
    pub flags: u32,
    /// Parts, GfxObj ids.
    pub parts: Vec<u32>,
    /// Per part, the part it hangs on (0xFFFFFFFF none); present iff flags bit 0.
    pub parent_indices: Option<Vec<u32>>,
    /// Per part, its scale; present iff flags bit 1.
    pub default_scales: Option<Vec<Vec3>>,
    /// Where things are held.
    pub holding_locations: Vec<Location>,
    /// Where things connect.
    pub connection_points: Vec<Location>,
    /// Poses.
    pub placement_frames: Vec<PlacementFrame>,
    /// Cylinders it collides as.
    pub cyl_spheres: Vec<CylSphere>,
    /// Spheres it collides as.
    pub spheres: Vec<Sphere>,
    /// Metres.
    pub height: f32,
    /// Metres.
    pub radius: f32,
    /// Metres.
    pub step_up_height: f32,
    /// Metres.
    pub step_down_height: f32,
    /// For sorting by distance.
    pub sorting_sphere: Sphere,
    /// For picking.
    pub selection_sphere: Sphere,
    /// Lights it carries.
    pub lights: Vec<Light>,
    /// Animation, 0 none.
    pub default_animation: u32,
    /// PhysicsScript, 0 none.
    pub default_script: u32,
    /// MotionTable, 0 none.
    pub default_motion_table: u32,
    /// SoundTable, 0 none.
    pub default_sound_table: u32,
    /// PhysicsScriptTable, 0 none.
    pub default_script_table: u32,
}

/// A place on a part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Location {
    /// Its key.
    pub location: i32,
    /// The part it is on.
    pub part: i32,
    /// Place relative to the part.
    pub frame: Frame,
}

/// A pose: a frame for every part.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlacementFrame {
    /// Its key; see [`Setup::RESTING`].
    pub placement: i32,
    /// Per part, place in the object's frame.
    pub frames: Vec<Frame>,
    /// What happens in it.
    pub hooks: Vec<Hook>,
}

/// An animation hook. Only its length is known here; the payload is kept as bytes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Hook {
    /// Type, 0 to 0x19.
    pub hook_type: u32,
    /// Direction in which the animation must run.
    pub direction: i32,
    /// What follows.
    pub payload: Vec<u8>,
}

/// A light of an object.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Light {
    /// Its key.
    pub key: i32,
    /// Place in the object's frame.
    pub frame: Frame,
    /// Colour.
    pub color: Argb,
    /// Brightness.
    pub intensity: f32,
    /// Metres.
    pub falloff: f32,
    /// Radians.
    pub cone_angle: f32,
}

impl Setup {
    /// Flag: parent indices follow.
    pub const HAS_PARENTS: u32 = 1;
    /// Flag: default scales follow.
    pub const HAS_SCALES: u32 = 2;
    /// Flag: allow free heading.
    pub const FREE_HEADING: u32 = 4;
    /// Flag: collides by the BSP of its parts.
    pub const HAS_PHYSICS_BSP: u32 = 8;
    /// Key of the pose "default".
    pub const DEFAULT_PLACEMENT: i32 = 0;
    /// Key of the pose "resting".
    pub const RESTING: i32 = 0x65;

    /// The pose of an object put into the world (X4): "resting", else "default", else the first; `None` when there
    /// are no poses, which means identity for every part.
    pub fn resting_frame(&self) -> Option<&PlacementFrame> {
        let keyed = |key| self.placement_frames.iter().find(|pose| pose.placement == key);
        keyed(Self::RESTING)
            .or_else(|| keyed(Self::DEFAULT_PLACEMENT))
            .or(self.placement_frames.first())
    }

    /// Whether it may be turned about any axis (flags bit 2).
    pub fn allow_free_heading(&self) -> bool {
        self.flags & Self::FREE_HEADING != 0
    }

    /// Whether it collides by the BSP of its parts (flags bit 3).
    pub fn has_physics_bsp(&self) -> bool {
        self.flags & Self::HAS_PHYSICS_BSP != 0
    }
}
