//! Scene, `12......` (`dat-format.md` 10.9).

use crate::primitive::Frame;

/// Scenery that terrain of one kind may grow.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// Data id as stored.
    pub id: u32,
    /// What may grow.
    pub objects: Vec<ObjectDesc>,
}

/// One kind of scenery object.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
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
