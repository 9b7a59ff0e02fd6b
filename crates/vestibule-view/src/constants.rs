//! The numbers of the visibility rules, named once (`visibility.md` 1, 13.4, 14).

/// Tolerance of the facing test: an eye nearer to a portal plane than this is on it, metres (`visibility.md`
/// 4.1). Retail `F_EPSILON`.
pub const EPSILON: f32 = vestibule_world::constants::EPSILON;
/// Distance of the near plane used for drawing and for sphere tests, metres (`visibility.md` 1, ZNEAR).
pub const NEAR_PLANE: f32 = 0.1;
/// How much a portal polygon is grown when the eye is on its plane, metres (`visibility.md` 12.2).
pub const ON_PLANE_MARGIN: f32 = 0.01;
/// How far an eye may lie outside its cell before a neighbour that holds it is taken instead, metres
/// (`visibility.md` 12.3).
pub const WRONG_CELL_MARGIN: f32 = 0.05;
/// Views a cell may have before they are replaced by their bounding rectangle (`visibility.md` 13.4).
pub const MAX_VIEWS_PER_CELL: u32 = 64;
/// Views of one flood (`visibility.md` 13.4).
pub const MAX_VIEWS: usize = 4096;
/// Portals one line of sight may pass (`visibility.md` 13.4).
pub const MAX_HOPS: u16 = 128;
/// Edges of a view; more are simplified outward (`visibility.md` 14.5).
pub const MAX_EDGES: usize = 12;
/// Edges of a view in retail mode; more are cut off (`visibility.md` 1, VIEW_MAX_VERTS).
pub const MAX_EDGES_RETAIL: usize = 31;
/// Vertices of one convex piece of an opening; longer polygons are split when compiled (`visibility.md` 14.5).
pub const MAX_PIECE_VERTICES: usize = 32;
/// Smallest area of a portal polygon, square metres; a smaller one is closed for good (`visibility.md` 12.7).
pub const MIN_PORTAL_AREA: f32 = 1.0e-6;
/// A unit ray this far outside a plane still counts as inside: keep when in doubt (`visibility.md` 14.3).
pub const CLIP_TOLERANCE: f32 = 1.0e-6;
/// An edge whose cross product of unit rays is shorter has no direction (`visibility.md` 14.4).
pub const MIN_EDGE: f32 = 1.0e-7;
/// Smallest area of a view on the unit sphere (`visibility.md` 14.6).
pub const MIN_VIEW_AREA: f32 = 1.0e-9;
/// Smallest width of a view on the unit sphere (`visibility.md` 14.6).
pub const MIN_VIEW_WIDTH: f32 = 1.0e-6;
