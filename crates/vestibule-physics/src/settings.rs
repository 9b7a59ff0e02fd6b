//! Switches for retail's quirks (`transition.md` 12.6).

/// How a sweep answers where the retail client does something odd. The default is retail, except for the first
/// two, whose corrected forms agree with retail wherever retail is right (`transition.md` 12.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Multiply the distance of a scaled part's contact plane by the scale, as retail does, which is exact for
    /// scale 1 or planes through the origin only (1.5.9). Off: take it from a scaled vertex.
    pub retail_scale_quirk: bool,
    /// Leave out the block offset where retail does: pinning to the last-known plane (5.11.4), the viewer on
    /// terrain (7.3), case 5 of edge sliding (5.10), normals and clipped contacts of spheres and cylinders (8.3,
    /// 8.4). Matters within a step of a landblock's border. Off: the offset is applied.
    pub retail_missing_block_offsets: bool,
    /// Slide along the last-known contact plane even when it is no longer valid (5.12.3).
    pub stale_last_known_plane: bool,
    /// A cliff approached from behind doubles the approach instead of removing it (5.10).
    pub cliff_slide_doubling: bool,
    /// Each support test halves the radius that the next one starts from (2.2.13).
    pub persistent_walkable_halving: bool,
    /// Step up onto spheres with a normal that is not of unit length (8.3.6).
    pub unnormalised_sphere_step_up: bool,
    /// Turn the normal of a cylinder that is stepped up by the target's frame, although it is global (8.4.5).
    pub rotated_cylinder_step_up: bool,
    /// Tops of spheres and cylinders count as water, which keeps the safety push away from them and shows as
    /// water contact (8.3).
    pub object_tops_are_water: bool,
    /// A placement without sliding may be pushed any distance towards smaller x and y (9.7.4).
    pub signed_placement_acceptance: bool,
    /// Moves of more steps than this are refused. Retail has no limit; this many steps take a player farther
    /// than from one end of the map to the other (3.4).
    pub max_steps: u32,
}

impl Settings {
    /// The retail client's answers.
    pub const RETAIL: Settings = Settings {
        retail_scale_quirk: false,
        retail_missing_block_offsets: false,
        stale_last_known_plane: true,
        cliff_slide_doubling: true,
        persistent_walkable_halving: true,
        unnormalised_sphere_step_up: true,
        rotated_cylinder_step_up: true,
        object_tops_are_water: true,
        signed_placement_acceptance: true,
        max_steps: 110_000,
    };
}

impl Default for Settings {
    fn default() -> Self {
        Settings::RETAIL
    }
}
