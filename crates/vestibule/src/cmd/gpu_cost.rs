//! What frames cost on a graphics card, to be printed.

/// The cost of one view. Milliseconds are of the processor, medians.
#[derive(serde::Serialize)]
pub(crate) struct ViewCost {
    #[serde(rename = "view")]
    pub(crate) name: String,
    /// From the start of the traversal to the return of the submit.
    pub(crate) processor_ms: f64,
    pub(crate) traversal_ms: f64,
    pub(crate) submit_ms: f64,
    pub(crate) draws: u32,
    pub(crate) triangles: u32,
    pub(crate) frames_per_second: f64,
    /// The same without the traversal, drawing everything in the nine landblocks around.
    pub(crate) everything_ms: f64,
    pub(crate) everything_draws: u32,
    pub(crate) everything_frames_per_second: f64,
}

/// The cost of some views.
#[derive(serde::Serialize)]
pub(crate) struct Costs {
    pub(crate) adapter: String,
    /// It draws on the processor.
    pub(crate) software: bool,
    pub(crate) size: (u32, u32),
    pub(crate) views: Vec<ViewCost>,
}
