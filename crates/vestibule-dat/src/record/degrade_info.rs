//! GfxObjDegradeInfo, `11......` (`dat-format.md` 10.10).

/// The coarser versions of a model, by distance.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GfxObjDegradeInfo {
    /// Data id as stored.
    pub id: u32,
    /// From near to far.
    pub degrades: Vec<Degrade>,
}

/// One version of a model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Degrade {
    /// GfxObj, 0 none.
    pub gfx_obj: u32,
    /// How it is drawn.
    pub degrade_mode: u32,
    /// Metres.
    pub min_dist: f32,
    /// Metres.
    pub ideal_dist: f32,
    /// Metres.
    pub max_dist: f32,
}
