//! Pictures of a world: a camera somewhere, or behind a player.

use glam::Vec2;
use vestibule_physics::{Body, BodyId, Population, Scratch};
use vestibule_render::{
    Assets, Everything, IdImage, Image, RenderError, RenderSettings, Scene, render, render_everything,
    render_everything_ids, render_ids,
};
use vestibule_view::{
    Camera, CameraError, CameraRig, ChaseCamera, FrameInput, FrameView, Openings, PlayerCell, Viewer,
    ViewerCell, ViewerTarget, WorldObjects,
};
use vestibule_world::{CellId, Position, World};

/// Ticks after which a camera that has been put behind a player is at rest.
const SETTLE_TICKS: u32 = 90;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudioError {
    /// The camera cannot be made.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The picture cannot be made or written.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// A view that has been decided on, ready to be drawn.
#[derive(Debug)]
pub struct Shot {
    /// What is drawn.
    pub frame: FrameView,
    /// The eye.
    pub camera: Camera,
    /// The player and nobody else, if one is in the picture.
    pub population: Population,
    /// The player, and how much of it shows, 0…1.
    pub player: Option<(BodyId, f32)>,
}

/// Draws pictures of a world with the reference renderer. Textures and meshes are kept from picture to picture; it may
/// be shared between threads.
///
/// ```
/// use glam::{Vec2, Vec3};
/// use vestibule::studio::Studio;
/// use vestibule::view::Camera;
///
/// let world = vestibule::open_world(None)?;
/// let eye: vestibule::world::Position = "0xA9B40031 [152 22 95.5]".parse()?;
/// let camera = Camera::new(eye.cell, eye.origin(), Vec3::new(0.5, -1.0, 0.0), Vec3::Z, 1.0, Vec2::new(64.0, 48.0))?;
/// let studio = Studio::new(&world);
/// let picture = studio.picture(&studio.shot(camera))?;
/// assert_eq!((picture.width(), picture.height()), (64, 48));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Studio<'w> {
    world: &'w World,
    openings: Openings,
    assets: Assets,
    /// How pictures are made.
    pub settings: RenderSettings,
    /// Time of day, 0…1; 0.5 is noon.
    pub time_of_day: f32,
}

impl<'w> Studio<'w> {
    /// A studio at noon.
    pub fn new(world: &'w World) -> Self {
        Studio {
            world,
            openings: Openings::new(),
            assets: Assets::new(),
            settings: RenderSettings::default(),
            time_of_day: 0.5,
        }
    }

    /// The textures and meshes used so far, and what was missing.
    pub fn assets(&self) -> &Assets {
        &self.assets
    }

    /// What a camera sees, nobody in the picture.
    pub fn shot(&self, camera: Camera) -> Shot {
        self.decide(&FrameInput::new(camera), Population::new(), None)
    }

    /// What an eye sees that follows a player: `player` is where it stands and faces, `cell` its cell, `eye` the eye's
    /// place and rotation (y forward, z up), `viewer_cell` the cell that the eye's sweep ended in. `opacity` says how
    /// much of the player shows, 0…1.
    ///
    /// # Errors
    /// The angle of view or the size is out of range.
    pub fn shot_behind(
        &self,
        player: &Position,
        eye: &Position,
        viewer_cell: Option<CellId>,
        fov_y: f32,
        size: Vec2,
    ) -> Result<Shot, StudioError> {
        let camera = Camera::from_frame(eye.cell, &eye.frame, fov_y, size)?;
        let input = FrameInput {
            camera,
            viewer_cell: viewer_cell.map(ViewerCell),
            player_cell: Some(PlayerCell(player.cell)),
            weather: false,
        };
        let mut population = Population::new();
        let id = population.add(Body::player());
        population.force_into_cell(self.world, &mut Scratch::new(), id, player);
        let pivot = Position {
            cell: player.cell,
            frame: ViewerTarget::at(*player).pivot(vestibule_view::PIVOT_OFFSET),
        };
        let distance = pivot.offset_to(eye).length();
        let opacity = ChaseCamera::new(1.0).body_opacity(distance);
        Ok(self.decide(&input, population, Some((id, opacity))))
    }

    /// Where the chase camera comes to rest behind a player who stands at `player` and faces as it says.
    pub fn chase(&self, player: &Position) -> Viewer {
        let (population, mut scratch) = (Population::new(), Scratch::new());
        let target = ViewerTarget::at(*player);
        let mut rig = CameraRig::new(ChaseCamera::new(1.0));
        let mut last = None;
        for _ in 0..SETTLE_TICKS {
            last = rig
                .update(
                    self.world,
                    &population,
                    &mut scratch,
                    Some(&target),
                    crate::walker::TICK,
                )
                .copied();
        }
        last.unwrap_or(Viewer {
            position: *player,
            cell: Some(ViewerCell(player.cell)),
            sought: *player,
            source: vestibule_view::ViewerSource::Player,
        })
    }

    fn decide(&self, input: &FrameInput, population: Population, player: Option<(BodyId, f32)>) -> Shot {
        let mut frame = FrameView::default();
        let objects = WorldObjects::new(self.world).with_population(&population);
        frame.update(self.world, &self.openings, &objects, input);
        Shot {
            frame,
            camera: input.camera,
            population,
            player,
        }
    }

    /// What is drawn of a shot besides its frame, for other renderers.
    pub fn scene<'a>(&'a self, shot: &'a Shot) -> Scene<'a> {
        let scene = Scene::new(self.world, &self.assets)
            .at_time(self.time_of_day)
            .with_population(&shot.population);
        match shot.player {
            Some((id, opacity)) => scene.with_player(id, opacity),
            None => scene,
        }
    }

    /// The picture.
    ///
    /// # Errors
    /// The size is out of range.
    pub fn picture(&self, shot: &Shot) -> Result<Image, RenderError> {
        render(&self.scene(shot), &shot.frame, &self.settings)
    }

    /// The picture of cell ids.
    ///
    /// # Errors
    /// The size is out of range.
    pub fn ids(&self, shot: &Shot) -> Result<IdImage, RenderError> {
        render_ids(&self.scene(shot), &shot.frame, &self.settings)
    }

    /// All loaded cells around the eye by depth alone, without a traversal.
    ///
    /// # Errors
    /// The size is out of range.
    pub fn everything(&self, shot: &Shot) -> Result<Image, RenderError> {
        render_everything(
            &self.scene(shot),
            &shot.camera,
            Everything::default(),
            &self.settings,
        )
    }

    /// The cell ids of everything.
    ///
    /// # Errors
    /// The size is out of range.
    pub fn everything_ids(&self, shot: &Shot) -> Result<IdImage, RenderError> {
        render_everything_ids(
            &self.scene(shot),
            &shot.camera,
            Everything::default(),
            &self.settings,
        )
    }
}
