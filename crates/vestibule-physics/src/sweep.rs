//! The sweep itself as a function: a mover, what it carries, from where to where; a value comes back
//! (`transition.md` 3.1).

use glam::Vec3;
use vestibule_world::{CellArray, CellEntry, CellId, Frame, Lanes, Plane, Position, Sphere, World};

use crate::collision_info::CollisionInfo;
use crate::constants::{DUMMY_SPHERE_RADIUS, STEP_HEIGHT_WITHOUT_SETUP};
use crate::error::SweepError;
use crate::flags::{ObjectKind, ObjectState, PhysicsState};
use crate::near_statics::NearStatics;
use crate::obj_collisions::{ObjectRef, Target};
use crate::object_info::{ObjectInfo, is_walkable_z};
use crate::plain_step::plain_step;
use crate::plain_walls::Known;
use crate::population::{BodyId, Event, Population};
use crate::sphere_path::SpherePath;
use crate::transition::{BuiltArray, InsertType, StepPlan, Transition, calc_num_steps, cell_ref};

/// A plane a body is in contact with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPlane {
    /// The plane, in the frame of the landblock of `cell`, metres.
    pub plane: Plane,
    /// The cell whose landblock the plane is given in.
    pub cell: CellId,
    /// The surface is water, or the top of an object that is made of spheres or cylinders (`transition.md` 8.3).
    pub is_water: bool,
}

/// What a body carries from one sweep into the next (`transition.md` 3.1, 3.2).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Carried {
    /// The plane the body is in contact with.
    pub contact: Option<ContactPlane>,
    /// That plane can be walked on. Without contact this has no effect.
    pub on_walkable: bool,
    /// A plane the body has just left, when there is no contact: it moves away from it, as in a jump.
    pub last_known: Option<ContactPlane>,
    /// Normal of what the body slid along.
    pub sliding_normal: Option<Vec3>,
    /// How many moves the body has made no progress in, 0 to 3.
    pub stationary: u8,
}

/// Who is swept: its spheres and what decides how it collides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mover {
    /// Twice the same where there is only one.
    pub(crate) spheres: [Sphere; 2],
    count: u8,
    /// How high it steps up on walkable ground, metres.
    pub step_up_height: f32,
    /// How far it steps down on walkable ground, metres.
    pub step_down_height: f32,
    /// Bits of its ObjectInfo. [`ObjectState::CONTACT`] and [`ObjectState::ON_WALKABLE`] come from [`Carried`].
    pub state: ObjectState,
    /// Its physics state; gravity, missile and ethereal matter here.
    pub physics: PhysicsState,
    /// What the game says of it; players may be kept out of restricted cells.
    pub kind: ObjectKind,
    /// The body it is, which then does not collide with itself.
    pub body: Option<BodyId>,
    /// What a missile is meant for.
    pub target: Option<BodyId>,
}

impl Mover {
    /// A mover with these spheres, relative to its origin, metres; the first is the lower one, more than two are
    /// ignored, and without any it is a ball of radius 0.1 m (`transition.md` 1.2). It is under gravity, keeps
    /// off edges and hardly steps up or down until told otherwise.
    ///
    /// # Errors
    /// A number is not finite, or a radius is negative.
    pub fn new(spheres: &[Sphere]) -> Result<Self, SweepError> {
        let dummy = Sphere::new(Vec3::new(0.0, 0.0, DUMMY_SPHERE_RADIUS), DUMMY_SPHERE_RADIUS);
        let given = if spheres.is_empty() {
            core::slice::from_ref(&dummy)
        } else {
            spheres
        };
        let mut mover = Mover {
            spheres: [given[0]; 2],
            count: given.len().min(2) as u8,
            step_up_height: STEP_HEIGHT_WITHOUT_SETUP,
            step_down_height: STEP_HEIGHT_WITHOUT_SETUP,
            state: ObjectState::EDGE_SLIDE,
            physics: PhysicsState::DEFAULT,
            kind: ObjectKind::NONE,
            body: None,
            target: None,
        };
        for (slot, sphere) in mover.spheres.iter_mut().zip(given) {
            if !sphere.center.is_finite() || !sphere.radius.is_finite() {
                return Err(SweepError::NotFinite { what: "sphere" });
            }
            if sphere.radius < 0.0 {
                return Err(SweepError::NegativeRadius {
                    radius: sphere.radius,
                });
            }
            *slot = *sphere;
        }
        Ok(mover)
    }

    /// A player: two spheres of 0.48 m, stepping up 0.6 m and down 1.5 m (`transition.md` 9.5).
    pub fn player() -> Self {
        Mover {
            spheres: crate::locomotion::PLAYER_SPHERES,
            count: 2,
            step_up_height: crate::locomotion::PLAYER_STEP_UP,
            step_down_height: crate::locomotion::PLAYER_STEP_DOWN,
            state: ObjectState::EDGE_SLIDE,
            physics: PhysicsState::DEFAULT,
            kind: ObjectKind::NONE,
            body: None,
            target: None,
        }
    }

    /// The same mover with these step heights, metres.
    #[must_use]
    pub fn with_steps(self, up: f32, down: f32) -> Self {
        Mover {
            step_up_height: up,
            step_down_height: down,
            ..self
        }
    }

    /// The spheres, relative to the origin of the position, metres.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres[..usize::from(self.count).min(2)]
    }

    fn object_info(&self) -> ObjectInfo {
        let mut state = self
            .state
            .without(ObjectState::CONTACT | ObjectState::ON_WALKABLE);
        if self.kind != ObjectKind::NONE {
            for (kind, bit) in [
                (ObjectKind::PLAYER, ObjectState::IS_PLAYER),
                (ObjectKind::IMPENETRABLE, ObjectState::IS_IMPENETRABLE),
                (ObjectKind::PK, ObjectState::IS_PK),
                (ObjectKind::PKLITE, ObjectState::IS_PKLITE),
            ] {
                if self.kind.has(kind) {
                    state.set(bit, true);
                }
            }
        }
        let missile = self.physics.has(PhysicsState::MISSILE);
        ObjectInfo {
            state,
            step_up_height: self.step_up_height,
            step_down_height: self.step_down_height,
            ethereal: self.physics.has(PhysicsState::ETHEREAL),
            step_down: !missile,
            missile,
            gravity: self.physics.has(PhysicsState::GRAVITY),
            kind: self.kind,
            body: self.body,
            target: self.target,
        }
    }
}

/// An object a sweep ran into (`transition.md` 8.2.8).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touch {
    /// Which one.
    pub object: ObjectRef,
    /// It stopped or deflected the mover; otherwise it was only touched, as an open door is.
    pub stopped: bool,
}

/// Working memory of sweeps. Keep one per thread: after the first few sweeps nothing is allocated any more.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pub(crate) cell_array: CellArray,
    pub(crate) touched: Vec<Touch>,
    pub(crate) events: Vec<Event>,
}

impl Scratch {
    /// Empty working memory.
    pub fn new() -> Self {
        Scratch {
            cell_array: CellArray::new(),
            touched: Vec::with_capacity(16),
            events: Vec::with_capacity(16),
        }
    }

    /// Forgets the last sweep.
    #[inline(always)]
    pub(crate) fn start(&mut self) {
        self.cell_array.clear();
        self.cell_array.do_not_load_cells = false;
        self.touched.clear();
    }

    /// Puts back what a sweep left, for its write-back.
    pub(crate) fn resume(&mut self, cells: &[CellEntry], touched: &[Touch]) {
        self.cell_array.clear();
        for entry in cells {
            self.cell_array.add(entry.id, entry.resident);
        }
        self.touched.clear();
        self.touched.extend_from_slice(touched);
    }

    /// The cells the mover reached when the last sweep ended, in retail's order.
    pub fn cells(&self) -> &[CellEntry] {
        self.cell_array.entries()
    }

    /// The objects the last sweep ran into, in order.
    pub fn touched(&self) -> &[Touch] {
        &self.touched
    }

    /// What happened to bodies during the last call of [`Population`] that moves them, in order.
    pub fn events(&self) -> &[Event] {
        &self.events
    }
}

/// Where a sweep ended and what it met. Nothing is written anywhere until this is committed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swept {
    /// The sweep's own verdict. A body that was blocked has `ok` set and an unchanged place; a sweep that is not
    /// `ok` must not be committed.
    pub ok: bool,
    /// The cell the sweep carried the mover into; `None` when it left the known world ("lost cell").
    pub cell: Option<CellId>,
    /// The last accepted position. Its cell id names the landblock the origin is relative to, also when `cell`
    /// is `None`.
    pub position: Position,
    /// The plane the mover is in contact with.
    pub contact: Option<ContactPlane>,
    /// That plane can be walked on.
    pub on_walkable: bool,
    /// Normal of what the mover ran into, global; zero when it has no direction.
    pub collision_normal: Option<Vec3>,
    /// Horizontal normal of what the next move slides along.
    pub sliding_normal: Option<Vec3>,
    /// Hit the surroundings while not in contact.
    pub collided_with_environment: bool,
    /// Moves without progress so far, 0 to 3.
    pub stationary: u8,
    /// The sweep took the mover's velocity away (retail `kill_velocity`).
    pub velocity_killed: bool,
}

impl Swept {
    /// What the mover carries into its next sweep: see [`Carried`]. A count of three starts again
    /// (`transition.md` 9.2.5).
    pub fn carried(&self) -> Carried {
        Carried {
            contact: self.contact,
            on_walkable: self.on_walkable,
            last_known: None,
            sliding_normal: self.sliding_normal,
            stationary: if self.stationary >= 3 { 0 } else { self.stationary },
        }
    }
}

/// Sweeps `mover` from `from` to `to`. Reads `world` and `population`; what the mover touched and the cells it
/// reached are left in `scratch`.
///
/// `from.cell` is the cell the mover is in; `to` may name any landblock. A cell that is not resident, or an
/// unknown one, gives a sweep that is not [`Swept::ok`] and moves nothing (`transition.md` I10).
///
/// # Errors
/// Input that is not finite, or a move of more steps than [`crate::Settings::max_steps`].
// Out of line the result is written where the caller wants it; inlined it would be copied.
#[inline(never)]
pub fn sweep(
    world: &World,
    population: &Population,
    scratch: &mut Scratch,
    mover: &Mover,
    carried: &Carried,
    from: &Position,
    to: &Position,
) -> Result<Swept, SweepError> {
    scratch.start();
    let mut found = None;
    let offset = offset_in_block(from, to);
    let radius = mover.spheres[0].radius;
    // Certainly one step.
    if offset.dot(offset) < 0.99 * (radius * radius)
        && let Some(end) = plain_step(
            world, population, scratch, mover, carried, from, to, offset, &mut found,
        )
    {
        return Ok(end.swept(mover, carried, to));
    }
    let found: Option<Known> = found;
    let start = match &found {
        Some(known) => {
            Start {
                built: BuiltArray::certain(from.cell, known.cells_at, known.to_cells, &scratch.cell_array),
                // What was looked at is finite, and not a viewer's.
                plan: StepPlan::whole(offset.xyz(), to.frame.rotation()),
            }
        }
        None => start(mover, carried, from, to)?,
    };
    sweep_any(world, population, scratch, mover, carried, from, to, &start)
}

/// What a sweep by the rules starts from.
struct Start {
    /// What is known of the cells around the candidate after the first step.
    built: BuiltArray,
    plan: StepPlan,
}

#[inline(never)]
fn start(mover: &Mover, carried: &Carried, from: &Position, to: &Position) -> Result<Start, SweepError> {
    check_input(mover, carried, from)?;
    if !is_finite(to) {
        return Err(SweepError::NotFinite {
            what: "target position",
        });
    }
    let viewer = mover.state.has(ObjectState::IS_VIEWER);
    let radius = mover.spheres[0].radius;
    Ok(Start {
        built: BuiltArray::NONE,
        plan: calc_num_steps(from.offset_to(to), radius, viewer, to.frame.rotation()),
    })
}

/// From one position to another of the same landblock, as [`Position::offset_to`]; between landblocks what is no number.
#[inline(always)]
fn offset_in_block(from: &Position, to: &Position) -> Lanes {
    if from.cell.block() != to.cell.block() {
        return Lanes::splat(f32::NAN);
    }
    Lanes::ZERO + Lanes::from(to.frame.origin) - Lanes::from(from.frame.origin)
}

/// The sweep by the rules.
#[inline(never)]
#[expect(clippy::too_many_arguments, reason = "those of a sweep")]
fn sweep_any(
    world: &World,
    population: &Population,
    scratch: &mut Scratch,
    mover: &Mover,
    carried: &Carried,
    from: &Position,
    to: &Position,
    start: &Start,
) -> Result<Swept, SweepError> {
    let plan = &start.plan;
    let limit = population.settings().max_steps;
    if plan.steps > limit {
        return Err(SweepError::TooManySteps {
            steps: plan.steps,
            limit,
        });
    }
    let mut transition = begin(
        world,
        population,
        scratch,
        mover,
        carried,
        from,
        InsertType::Transition,
    );
    transition.built = start.built;
    let ok = transition.find_valid_position(plan);
    transition.outcome(ok, &to.frame)
}

/// Places `mover` at `at` without coming from anywhere, as after a teleport (`transition.md` 3.6): out of what
/// is solid, beside what is in the way if `slide`, and down onto the ground. `at.cell` must be the cell that
/// holds the mover, see [`vestibule_world::adjust_position`]. `do_not_load_cells` keeps to cells that can be
/// seen from there (`world.md` 13.5).
///
/// # Errors
/// Input that is not finite.
pub fn place(
    world: &World,
    population: &Population,
    scratch: &mut Scratch,
    mover: &Mover,
    at: &Position,
    slide: bool,
    do_not_load_cells: bool,
) -> Result<Swept, SweepError> {
    let carried = Carried::default();
    check_input(mover, &carried, at)?;
    scratch.start();
    let mut transition = begin(
        world,
        population,
        scratch,
        mover,
        &carried,
        at,
        InsertType::Placement,
    );
    transition.path.placement_allows_sliding = slide;
    transition.cell_array.do_not_load_cells = do_not_load_cells;
    let plan = calc_num_steps(Vec3::ZERO, 1.0, false, at.frame.rotation());
    let ok = transition.find_valid_position(&plan);
    transition.cell_array.do_not_load_cells = false;
    transition.outcome(ok, &at.frame)
}

/// Whether all numbers are finite.
#[inline]
fn is_finite(position: &Position) -> bool {
    let frame = &position.frame;
    Lanes::from(frame.origin).all_finite() && Lanes::of_rotation(frame.rotation()).all_finite()
}

#[inline]
fn check_input(mover: &Mover, carried: &Carried, from: &Position) -> Result<(), SweepError> {
    let plane = |c: &Option<ContactPlane>| {
        c.as_ref().map_or(0.0, |c| {
            c.plane.normal.x + c.plane.normal.y + c.plane.normal.z + c.plane.d
        })
    };
    let sliding = carried.sliding_normal.map_or(0.0, |n| n.x + n.y + n.z);
    let heights = mover.step_up_height + mover.step_down_height;
    let sum = plane(&carried.contact) + plane(&carried.last_known) + sliding + heights;
    if is_finite(from) && sum * 0.0 == 0.0 {
        return Ok(());
    }
    find_bad_input(mover, carried, from)
}

#[cold]
fn find_bad_input(mover: &Mover, carried: &Carried, from: &Position) -> Result<(), SweepError> {
    let contact =
        |c: &Option<ContactPlane>| c.is_none_or(|c| c.plane.normal.is_finite() && c.plane.d.is_finite());
    let what = if !from.is_finite() {
        "position"
    } else if !mover.step_up_height.is_finite() || !mover.step_down_height.is_finite() {
        "step height"
    } else if !contact(&carried.contact) || !contact(&carried.last_known) {
        "contact plane"
    } else if carried.sliding_normal.is_some_and(|n| !n.is_finite()) {
        "sliding normal"
    } else {
        return Ok(());
    };
    Err(SweepError::NotFinite { what })
}

/// A transition ready to run; `scratch` has been started.
#[inline(always)]
pub(crate) fn begin<'w, 's>(
    world: &'w World,
    population: &'w Population,
    scratch: &'s mut Scratch,
    mover: &Mover,
    carried: &Carried,
    at: &Position,
    insert_type: InsertType,
) -> Transition<'w, 's> {
    let mut object = mover.object_info();
    let mut info = CollisionInfo {
        frames_stationary_fall: carried.stationary,
        ..CollisionInfo::default()
    };
    if let Some(c) = &carried.contact {
        info.init_contact_plane(c.plane, c.is_water, c.cell);
        object.state.set(ObjectState::CONTACT, true);
        object.state.set(ObjectState::ON_WALKABLE, carried.on_walkable);
    } else if let Some(c) = &carried.last_known {
        info.init_last_known_contact_plane(c.plane, c.is_water, c.cell);
    }
    if let Some(n) = carried.sliding_normal {
        info.init_sliding_normal(n);
    }
    let cell = cell_ref(world, at.cell);
    Transition {
        world,
        population,
        settings: population.settings(),
        object,
        path: SpherePath::new(usize::from(mover.count), &mover.spheres, cell, at, insert_type),
        info,
        cell_array: &mut scratch.cell_array,
        built: BuiltArray::NONE,
        keeps_shape: true,
        near_statics: [NearStatics::NONE; 2],
        touched: &mut scratch.touched,
        depth: 0,
    }
}

impl Transition<'_, '_> {
    /// What comes back. `end` is the frame the mover was to end in, which mostly has the rotation it has.
    #[inline]
    pub(crate) fn outcome(&self, ok: bool, end: &Frame) -> Result<Swept, SweepError> {
        let (path, info) = (&self.path, &self.info);
        let pose = path.curr_pos;
        let rotation = Lanes::of_rotation(path.curr_rotation);
        if !(pose.origin.all_finite() && rotation.all_finite()) {
            return Err(SweepError::NotFinite {
                what: "position reached",
            });
        }
        let mut frame = *end;
        frame.origin = pose.origin();
        if !rotation.all_equal(Lanes::of_rotation(end.rotation())) {
            frame = Frame::new(pose.origin(), path.curr_rotation);
        }
        let position = Position {
            cell: pose.cell,
            frame,
        };
        let contact = info.contact.valid.then_some(ContactPlane {
            plane: info.contact.plane,
            cell: info.contact.cell,
            is_water: info.contact.is_water,
        });
        Ok(Swept {
            ok,
            cell: path.curr_cell.map(|cell| cell.id()),
            position,
            contact,
            on_walkable: info.contact.valid && is_walkable_z(info.contact.plane.normal.z),
            collision_normal: info.collision.get(),
            sliding_normal: info.sliding.get(),
            collided_with_environment: info.collided_with_environment,
            stationary: info.frames_stationary_fall,
            velocity_killed: info.velocity_killed,
        })
    }
}

/// Whether `mover` at `at` overlaps an object (`transition.md` 3.7).
pub(crate) fn overlaps<'w>(
    world: &'w World,
    population: &'w Population,
    scratch: &mut Scratch,
    mover: &Mover,
    at: &Position,
    target: &Target<'w>,
) -> bool {
    scratch.start();
    let mut transition = begin(
        world,
        population,
        scratch,
        mover,
        &Carried::default(),
        at,
        InsertType::Placement,
    );
    transition.check_collisions(target)
}
