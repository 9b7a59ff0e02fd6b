//! Where the eye is and which cell it is in: the camera's own sweep (`rendering.md` 3, `transition.md` 3.8).

use glam::{Vec2, Vec3};
use vestibule_physics::{BodyId, Carried, Mover, Population, Scratch, sweep, viewer_mover};
use vestibule_world::{CellId, Frame, Position, World, adjust_position};

use crate::camera::{Camera, CameraError};
use crate::frame::FrameInput;
use crate::viewer::{PlayerCell, ViewerCell};

/// Radius of the sphere around the eye that is swept, metres (`rendering.md` 3.1).
pub const VIEWER_SPHERE_RADIUS: f32 = vestibule_physics::constants::VIEWER_SPHERE_RADIUS;
/// Where on the player the camera turns about by default, in its frame, metres (`rendering.md` 4.1).
pub const PIVOT_OFFSET: Vec3 = Vec3::new(0.0, 0.0, 1.5);

/// Whom the camera follows, as it is after the player's physics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewerTarget {
    /// Where the player stands.
    pub position: Position,
    /// The cell its body is in; `None` when it is in none.
    pub cell: Option<PlayerCell>,
    /// The frame the pivot is measured in, in the landblock of `position`; `None` for the player's own.
    pub pivot_frame: Option<Frame>,
    /// Velocity, m/s, landblock axes.
    pub velocity: Vec3,
    /// Normal of the ground it stands on.
    pub contact_normal: Option<Vec3>,
    /// Its body as a mover: the viewer's sweep is made with it, and is not stopped by it.
    pub mover: Mover,
}

impl ViewerTarget {
    /// A player standing still at a position, in its cell.
    pub fn at(position: Position) -> Self {
        ViewerTarget {
            position,
            cell: (!position.cell.is_none()).then_some(PlayerCell(position.cell)),
            pivot_frame: None,
            velocity: Vec3::ZERO,
            contact_normal: None,
            mover: Mover::player(),
        }
    }

    /// A body of a population; `None` when there is no such body.
    pub fn of_body(population: &Population, id: BodyId) -> Option<Self> {
        let body = population.body(id)?;
        Some(ViewerTarget {
            position: *body.position(),
            cell: body.cell().map(PlayerCell),
            pivot_frame: None,
            velocity: body.cached_velocity,
            contact_normal: body.contact.map(|c| c.plane.normal),
            mover: body.mover(Some(id)),
        })
    }

    /// The frame with the pivot as its origin, in the landblock of the target's position (`rendering.md` 3.4a).
    pub fn pivot(&self, pivot_offset: Vec3) -> Frame {
        let mut frame = self.pivot_frame.unwrap_or(self.position.frame);
        frame.origin = frame.local_to_global(pivot_offset);
        frame
    }
}

/// How the place of a viewer was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewerSource {
    /// The sweep from the pivot ended there.
    #[default]
    Swept,
    /// The sweep failed; the sought place lies in a cell all the same (`rendering.md` 3.5, first).
    Adjusted,
    /// Both failed: the player's own position, and no cell (`rendering.md` 3.5, last).
    Player,
}

/// Where the eye is (retail `SmartBox::viewer` and `viewer_cell`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewer {
    /// The eye and its rotation: y forward, z up.
    pub position: Position,
    /// The cell the sweep ended in; `None` when nothing was found. Decides the frame.
    pub cell: Option<ViewerCell>,
    /// Where the camera wanted to be.
    pub sought: Position,
    /// How it came about.
    pub source: ViewerSource,
}

impl Viewer {
    /// The viewer's camera (`rendering.md` 2.5, 2.6). `fov_y` in radians, `viewport` in pixels.
    ///
    /// # Errors
    /// As [`Camera::new`].
    pub fn camera(&self, fov_y: f32, viewport: Vec2) -> Result<Camera, CameraError> {
        Camera::from_frame(self.position.cell, &self.position.frame, fov_y, viewport)
    }

    /// What [`crate::FrameView::update`] wants to know of this viewer and its player.
    ///
    /// # Errors
    /// As [`Camera::new`].
    pub fn frame_input(
        &self,
        player_cell: Option<PlayerCell>,
        fov_y: f32,
        viewport: Vec2,
    ) -> Result<FrameInput, CameraError> {
        let camera = self.camera(fov_y, viewport)?;
        Ok(FrameInput {
            camera,
            viewer_cell: self.cell,
            player_cell,
            weather: false,
        })
    }

    fn at_player(target: &ViewerTarget) -> Self {
        let position = target.position;
        Viewer {
            position,
            cell: None,
            sought: position,
            source: ViewerSource::Player,
        }
    }
}

/// Finds the viewer's place and cell (retail `SmartBox::update_viewer`, `rendering.md` 3): the viewer sphere is swept
/// from the pivot to the sought position, and the cell is the one that sweep ended in, never derived from
/// coordinates. A failed sweep falls back to `AdjustPosition` at the sought position, then to the player's position
/// without a cell.
///
/// `sought` may name any landblock. Numbers that are not finite make the sweep fail and lead to a fallback.
pub fn update_viewer(
    world: &World,
    population: &Population,
    scratch: &mut Scratch,
    target: &ViewerTarget,
    pivot_offset: Vec3,
    sought: &Position,
) -> Viewer {
    // A player without a cell cannot re-enter visibility by itself here (3.2).
    let Some(player_cell) = target.cell else {
        return Viewer::at_player(target);
    };
    let begin = Position {
        cell: start_cell(world, target, player_cell, pivot_offset),
        frame: target.pivot(pivot_offset),
    };
    // The pivot is relative to the player's landblock; the start cell may be of another only outdoors.
    let begin = rebased(&begin, target.position.cell);
    if let Some(viewer) = swept(world, population, scratch, target, &begin, sought) {
        return viewer;
    }
    let adjusted = sought
        .is_finite()
        .then(|| adjust_position(world, sought, Vec3::ZERO, true))
        .flatten();
    match adjusted.filter(|found| found.resident) {
        Some(found) => Viewer {
            position: found.position,
            cell: Some(ViewerCell(found.position.cell)),
            sought: *sought,
            source: ViewerSource::Adjusted,
        },
        None => Viewer::at_player(target),
    }
}

/// The head may be in another cell than the feet: stairs, hatches (`rendering.md` 3.4b).
fn start_cell(world: &World, target: &ViewerTarget, player: PlayerCell, pivot_offset: Vec3) -> CellId {
    if !player.0.is_indoor() {
        return player.0;
    }
    let head = Position {
        cell: player.0,
        frame: target.pivot(pivot_offset),
    };
    adjust_position(world, &head, Vec3::ZERO, true).map_or(player.0, |found| found.position.cell)
}

/// Expresses a position whose numbers belong to `from`'s landblock in the landblock of its own cell.
fn rebased(position: &Position, from: CellId) -> Position {
    let mut out = *position;
    out.frame.origin += vestibule_world::ids::block_offset(position.cell.block(), from.block());
    out
}

fn swept(
    world: &World,
    population: &Population,
    scratch: &mut Scratch,
    target: &ViewerTarget,
    begin: &Position,
    sought: &Position,
) -> Option<Viewer> {
    let mover = viewer_mover(&target.mover);
    // The sought origin in the landblock of the start cell (`transition.md` 3.8.5).
    let offset = vestibule_world::ids::block_offset(begin.cell.block(), sought.cell.block());
    let mut end = Position {
        cell: begin.cell,
        frame: sought.frame,
    };
    end.frame.origin += offset;
    let result = sweep(
        world,
        population,
        scratch,
        &mover,
        &Carried::default(),
        begin,
        &end,
    )
    .ok()?;
    let cell = result.cell.filter(|_| result.ok)?;
    let mut position = result.position;
    position.frame.set_rotation(sought.frame.rotation());
    Some(Viewer {
        position,
        cell: Some(ViewerCell(cell)),
        sought: *sought,
        source: ViewerSource::Swept,
    })
}
