//! Setup, `02......` (`dat-format.md` 10.3).

use glam::Vec3;

use super::{DatRecord, RecordError, RecordErrorKind, inherent_parse_and_encode};
use crate::primitive::{Argb, CylSphere, Frame, Reader, Sphere, Writer};

/// An object of several parts, with what it collides as.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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

impl DatRecord for Setup {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let flags = reader.u32("flags")?;
        let num_parts = reader.count32(4, "num_parts")?;
        let parts = reader.u32s(num_parts, "parts")?;
        let parent_indices = if flags & Self::HAS_PARENTS != 0 {
            Some(reader.u32s(num_parts, "parent_indices")?)
        } else {
            None
        };
        let default_scales = if flags & Self::HAS_SCALES != 0 {
            let count = reader.check_count(num_parts as u64, 12, "default_scales")?;
            Some(reader.items(count, |reader| reader.vec3("default_scales"))?)
        } else {
            None
        };
        let holding_locations = reader.list_i32(Location::SIZE, "holding_locations", Location::read)?;
        let connection_points = reader.list_i32(Location::SIZE, "connection_points", Location::read)?;
        let pose_size = num_parts.saturating_mul(28).saturating_add(8);
        let placement_frames = reader.list_i32(pose_size, "placement_frames", |reader| {
            PlacementFrame::read(reader, num_parts)
        })?;
        Ok(Self {
            id,
            flags,
            parts,
            parent_indices,
            default_scales,
            holding_locations,
            connection_points,
            placement_frames,
            cyl_spheres: reader.list32(20, "cyl_spheres", |reader| reader.cyl_sphere("cyl_spheres"))?,
            spheres: reader.list32(16, "spheres", |reader| reader.sphere("spheres"))?,
            height: reader.f32("height")?,
            radius: reader.f32("radius")?,
            step_up_height: reader.f32("step_up_height")?,
            step_down_height: reader.f32("step_down_height")?,
            sorting_sphere: reader.sphere("sorting_sphere")?,
            selection_sphere: reader.sphere("selection_sphere")?,
            lights: reader.list_i32(48, "lights", Light::read)?,
            default_animation: reader.u32("default_animation")?,
            default_script: reader.u32("default_script")?,
            default_motion_table: reader.u32("default_motion_table")?,
            default_sound_table: reader.u32("default_sound_table")?,
            default_script_table: reader.u32("default_script_table")?,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        let num_parts = self.parts.len();
        writer.u32(self.id);
        writer.u32(self.flags);
        writer.count32(num_parts, "num_parts")?;
        writer.u32s(&self.parts);
        let per_part = "a list with one item for every part exists iff its bit in flags is set";
        let wanted = (self.flags & Self::HAS_PARENTS != 0).then_some(num_parts);
        writer.require(
            self.parent_indices.as_ref().map(Vec::len) == wanted,
            "parent_indices",
            per_part,
        )?;
        writer.u32s(self.parent_indices.as_deref().unwrap_or_default());
        let wanted = (self.flags & Self::HAS_SCALES != 0).then_some(num_parts);
        writer.require(
            self.default_scales.as_ref().map(Vec::len) == wanted,
            "default_scales",
            per_part,
        )?;
        self.default_scales
            .iter()
            .flatten()
            .for_each(|&scale| writer.vec3(scale));
        for (locations, field) in [
            (&self.holding_locations, "holding_locations"),
            (&self.connection_points, "connection_points"),
        ] {
            writer.count_i32(locations.len(), field)?;
            locations.iter().for_each(|location| location.write(writer));
        }
        writer.count_i32(self.placement_frames.len(), "placement_frames")?;
        for pose in &self.placement_frames {
            pose.write(writer, num_parts)?;
        }
        writer.count32(self.cyl_spheres.len(), "cyl_spheres")?;
        self.cyl_spheres
            .iter()
            .for_each(|cyl_sphere| writer.cyl_sphere(cyl_sphere));
        writer.count32(self.spheres.len(), "spheres")?;
        self.spheres.iter().for_each(|sphere| writer.sphere(sphere));
        writer.f32s(&[
            self.height,
            self.radius,
            self.step_up_height,
            self.step_down_height,
        ]);
        writer.sphere(&self.sorting_sphere);
        writer.sphere(&self.selection_sphere);
        writer.count_i32(self.lights.len(), "lights")?;
        self.lights.iter().for_each(|light| light.write(writer));
        writer.u32s(&[
            self.default_animation,
            self.default_script,
            self.default_motion_table,
            self.default_sound_table,
            self.default_script_table,
        ]);
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(Setup);

impl Location {
    const SIZE: usize = 36;

    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            location: reader.i32("location.location")?,
            part: reader.i32("location.part")?,
            frame: reader.frame("location.frame")?,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.i32(self.location);
        writer.i32(self.part);
        writer.frame(&self.frame);
    }
}

impl PlacementFrame {
    fn read(reader: &mut Reader<'_>, num_parts: usize) -> Result<Self, RecordError> {
        let placement = reader.i32("placement_frame.placement")?;
        let count = reader.check_count(num_parts as u64, 28, "placement_frame.frames")?;
        let frames = reader.items(count, |reader| reader.frame("placement_frame.frames"))?;
        let hooks = reader.list32(8, "placement_frame.hooks", Hook::read)?;
        Ok(Self {
            placement,
            frames,
            hooks,
        })
    }

    fn write(&self, writer: &mut Writer, num_parts: usize) -> Result<(), RecordError> {
        writer.i32(self.placement);
        let what = "a placement frame has one frame for every part";
        writer.require(self.frames.len() == num_parts, "placement_frame.frames", what)?;
        self.frames.iter().for_each(|frame| writer.frame(frame));
        writer.count32(self.hooks.len(), "placement_frame.hooks")?;
        self.hooks.iter().try_for_each(|hook| hook.write(writer))
    }
}

impl Hook {
    /// Type "replace object": a part, then an id of known type, which is 2 or 4 bytes long.
    pub const REPLACE_OBJECT: u32 = 5;

    /// Payload bytes of a hook type; of [`REPLACE_OBJECT`](Self::REPLACE_OBJECT) the shorter form. `None` for types
    /// whose length is not known, 0x1A among them (X3).
    fn payload_length(hook_type: u32) -> Option<usize> {
        Some(match hook_type {
            0 | 4 | 0x11 => 0,
            1 | 2 | 5 | 6 | 0x0E | 0x0F | 0x10 | 0x12 | 0x19 => 4,
            3 => 28,
            7 | 9 | 0x0B | 0x15 => 16,
            8 | 0x0A | 0x14 | 0x16 | 0x18 => 12,
            0x0C | 0x13 | 0x17 => 8,
            0x0D => 40,
            _ => return None,
        })
    }

    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let start = reader.position();
        let hook_type = reader.u32("hook.type")?;
        let direction = reader.i32("hook.direction")?;
        let Some(length) = Self::payload_length(hook_type) else {
            let expected = "a hook type whose length is known";
            let kind = RecordErrorKind::BadValue {
                value: hook_type,
                expected,
            };
            return Err(reader.error_at(start, "hook.type", kind));
        };
        let mut payload = reader.take(length, "hook.payload")?.to_vec();
        if is_long_replace(hook_type, &payload) {
            payload.extend_from_slice(reader.take(2, "hook.payload")?);
        }
        Ok(Self {
            hook_type,
            direction,
            payload,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        let extra = if is_long_replace(self.hook_type, &self.payload) {
            2
        } else {
            0
        };
        let wanted = Self::payload_length(self.hook_type).map(|length| length + extra);
        let what = "a hook's payload has the length of its type";
        writer.require(wanted == Some(self.payload.len()), "hook.payload", what)?;
        writer.u32(self.hook_type);
        writer.i32(self.direction);
        writer.bytes(&self.payload);
        Ok(())
    }
}

/// Whether the id of known type in a "replace object" hook has its long form.
fn is_long_replace(hook_type: u32, payload: &[u8]) -> bool {
    hook_type == Hook::REPLACE_OBJECT && payload.get(3).is_some_and(|high| high & 0x80 != 0)
}

impl Light {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            key: reader.i32("light.key")?,
            frame: reader.frame("light.frame")?,
            color: reader.argb("light.color")?,
            intensity: reader.f32("light.intensity")?,
            falloff: reader.f32("light.falloff")?,
            cone_angle: reader.f32("light.cone_angle")?,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.i32(self.key);
        writer.frame(&self.frame);
        writer.argb(self.color);
        writer.f32s(&[self.intensity, self.falloff, self.cone_angle]);
    }
}
