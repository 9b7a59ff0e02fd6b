//! Plane geometry of plain convex things, in f64: polygons, convex solids and unions of them.
//!
//! Everything the compiler and the BSP builders do to shapes is done here, in metres. Records store f32; what is
//! computed from authored numbers stays f64 until it is stored.

mod carve;
mod outline;
mod plane;
mod polygon;
mod polytope;
mod union;

pub use carve::carve;
pub use outline::convex_parts;
pub use plane::{Plane, Side};
pub use polygon::Polygon;
pub use polytope::{Face, Polytope};
pub use union::{Solid, merge_convex, union_faces};
pub(crate) use union::{inside, uncovered};

/// Points nearer to a plane than this lie on it, metres. Half of retail's epsilon, so that what is built here is
/// never finer than what the engine can tell apart.
pub const ON_PLANE: f64 = 1.0e-4;
/// Polygons smaller than this are dropped, square metres.
pub const MIN_AREA: f64 = 1.0e-7;
/// Tag of faces that were made by cutting and are no one's wall.
pub const CUT: u32 = u32::MAX;
