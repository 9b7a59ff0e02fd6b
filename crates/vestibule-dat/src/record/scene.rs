//! Scene, `12......` (`dat-format.md` 10.9).

use super::{DatRecord, RecordError, inherent_parse_and_encode};
use crate::primitive::{Frame, Reader, Writer};

/// Scenery that terrain of one kind may grow.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Scene {
    /// Data id as stored.
    pub id: u32,
    /// What may grow.
    pub objects: Vec<ObjectDesc>,
}

/// One kind of scenery object.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ObjectDesc {
    /// GfxObj or Setup.
    pub object_id: u32,
    /// Place before displacement.
    pub base_loc: Frame,
    /// How often, 0 to 1.
    pub frequency: f32,
    /// Largest displacement, metres.
    pub displace_x: f32,
    /// Largest displacement, metres.
    pub displace_y: f32,
    /// Smallest scale.
    pub min_scale: f32,
    /// Largest scale.
    pub max_scale: f32,
    /// Largest rotation about up, degrees.
    pub max_rotation: f32,
    /// Least slope it grows on, as the z of the ground's normal.
    pub min_slope: f32,
    /// Largest slope it grows on, as the z of the ground's normal.
    pub max_slope: f32,
    /// Non-zero: follows the ground's slope.
    pub align: u32,
    /// Non-zero: keeps one heading.
    pub orient: u32,
    /// Non-zero: stands for an object of the server; not drawn.
    pub weenie_obj: u32,
}

impl DatRecord for Scene {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let objects = reader.list32(ObjectDesc::SIZE, "objects", ObjectDesc::read)?;
        Ok(Self { id, objects })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.id);
        writer.count32(self.objects.len(), "objects")?;
        self.objects.iter().for_each(|object| object.write(writer));
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(Scene);

impl ObjectDesc {
    const SIZE: usize = 76;

    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            object_id: reader.u32("object.object_id")?,
            base_loc: reader.frame("object.base_loc")?,
            frequency: reader.f32("object.frequency")?,
            displace_x: reader.f32("object.displace_x")?,
            displace_y: reader.f32("object.displace_y")?,
            min_scale: reader.f32("object.min_scale")?,
            max_scale: reader.f32("object.max_scale")?,
            max_rotation: reader.f32("object.max_rotation")?,
            min_slope: reader.f32("object.min_slope")?,
            max_slope: reader.f32("object.max_slope")?,
            align: reader.u32("object.align")?,
            orient: reader.u32("object.orient")?,
            weenie_obj: reader.u32("object.weenie_obj")?,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.u32(self.object_id);
        writer.frame(&self.base_loc);
        writer.f32s(&[
            self.frequency,
            self.displace_x,
            self.displace_y,
            self.min_scale,
            self.max_scale,
            self.max_rotation,
            self.min_slope,
            self.max_slope,
        ]);
        writer.u32s(&[self.align, self.orient, self.weenie_obj]);
    }
}
