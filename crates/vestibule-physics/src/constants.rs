//! The numbers of the sweep and the body (`transition.md` 1.2), named once. Metres and seconds.

pub use vestibule_world::constants::{EPSILON, FLOOR_Z};

/// Least normal z to land on when not on walkable ground: cos 85°.
pub const Z_FOR_LANDING: f32 = 0.087_155_7;
/// Step height of a mover that is not on walkable ground, metres.
pub const DEFAULT_STEP_HEIGHT: f32 = 0.04;
/// Step up and step down of a body without setup data, metres.
pub const STEP_HEIGHT_WITHOUT_SETUP: f32 = 0.01;
/// Acceleration of a body under gravity on z, m/s².
pub const GRAVITY: f32 = -9.8;
/// Friction of a body unless set otherwise: the share of speed lost in a second.
pub const DEFAULT_FRICTION: f32 = 0.95;
/// Elasticity of a body unless set otherwise.
pub const DEFAULT_ELASTICITY: f32 = 0.05;
/// Elasticity is clamped to 0…0.1.
pub const MAX_ELASTICITY: f32 = 0.1;
/// Greatest speed of a body, m/s.
pub const MAX_VELOCITY: f32 = 50.0;
/// Square of the speed under which a body stops, (m/s)².
pub const SMALL_VELOCITY_SQUARED: f32 = 0.0625;
/// Shortest time that is integrated, seconds.
pub const MIN_QUANTUM: f64 = 1.0 / 30.0;
/// Longest time that is integrated at once, seconds.
pub const MAX_QUANTUM: f64 = 0.2;
/// Longer pauses than this are dropped, seconds.
pub const HUGE_QUANTUM: f64 = 2.0;
/// Radius and height of the sphere of a body without collision spheres, metres.
pub const DUMMY_SPHERE_RADIUS: f32 = 0.1;
/// Radius of the camera's sphere, metres.
pub const VIEWER_SPHERE_RADIUS: f32 = 0.3;
/// Least `walk_interp` that a polygon may leave (`transition.md` 6.6).
pub const POLYGON_INTERP_LIMIT: f32 = -0.5;
/// Least `walk_interp` that terrain, spheres and cylinders may leave (`transition.md` 7.3, 8).
pub const SHAPE_INTERP_LIMIT: f32 = -0.1;
/// Attempts of an insertion that moves, and of one that places (`transition.md` 4.3).
pub const MOVE_ATTEMPTS: u32 = 3;
/// Attempts of the insertion inside a step down (`transition.md` 4.3).
pub const STEP_DOWN_ATTEMPTS: u32 = 5;
/// Iterations of `adjust_to_plane`, shared by its two loops (`transition.md` 6.8).
pub const ADJUST_TO_PLANE_BUDGET: u32 = 15;
/// The bisection of `adjust_to_plane` stops when its bounds are this close (`transition.md` 6.8).
pub const BISECTION_STOP: f64 = 0.02;
/// Rounds of the initial placement in a cell structure (`transition.md` 6.9).
pub const PLACEMENT_INSERT_BUDGET: u32 = 20;
/// How far a placement searches around, metres; half of it for tiny movers (`transition.md` 3.6).
pub const PLACEMENT_SEARCH_RADIUS: f32 = 4.0;
/// Foot radius below which a mover counts as tiny in a placement search, metres.
pub const TINY_PLACEMENT_RADIUS: f32 = 0.125;
/// Foot radius that a placement search assumes at least for others, metres.
pub const MIN_PLACEMENT_RADIUS: f32 = 0.48;
/// Retail's pi in the placement search (`transition.md` 3.6).
#[allow(clippy::approx_constant, reason = "retail's own value is 3.1415999")]
pub const PLACEMENT_PI: f32 = 3.1416;
/// How far a placement without sliding may be pushed on x and y, metres (`transition.md` 9.7).
pub const PLACEMENT_ACCEPTANCE: f32 = 0.05;
/// Bodies farther than this from the player are not integrated, metres (`transition.md` 9.8).
pub const INACTIVITY_DISTANCE: f32 = 96.0;
/// Nested insertions deeper than this answer "collided"; valid data never comes near.
pub(crate) const MAX_INSERTION_DEPTH: u32 = 24;
