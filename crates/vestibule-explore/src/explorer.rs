//! The state behind the window: the player, the camera, what is shown. It knows no window and no GPU.

mod acting;
mod looking;

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};
use vestibule_physics::{Body, BodyId, Locomotion, Motion, ObjectRef, Placement, Population, Scratch};
use vestibule_render::{Assets, Scene};
use vestibule_view::{
    Camera, CameraMode, CameraRig, ChaseCamera, Command, FrameInput, FramePath, FrameSettings, FrameView,
    LightSet, Openings, PlayerCell, Viewer, ViewerTarget, Views, WorldObjects, retail_fov_y,
};
use vestibule_world::{BlockId, CellId, Position, World};

use crate::doors::Doors;
use crate::error::ExploreError;
use crate::everything;
use crate::fly::FlyCamera;
use crate::keys::Held;
use crate::picking::Picked;
use crate::places::{self, NamedPlace};

/// Seconds a message stays.
const MESSAGE_SECONDS: f64 = 6.0;
/// Radians a pixel of dragging turns.
const TURN_PER_PIXEL: f32 = 0.005;
/// Longest time that one tick makes up for, seconds: after a pause the world does not leap.
const LONGEST_TICK: f32 = 1.0;
/// Seconds of a step of bodies: always the same, so that a walk does not depend on how fast pictures are drawn. Just
/// over the shortest time that is integrated (`transition.md` 9.8).
const STEP: f64 = 1.0 / 30.0 + 1.0e-6;
/// Landblocks to each side of the viewer's where everything is drawn.
const AROUND: i32 = 2;
/// Landblocks that are loaded in a tick at most where everything is drawn.
const LOADS_A_TICK: usize = 2;

/// What is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    /// What the traversal reaches.
    #[default]
    Reached,
    /// One cell and what is in it.
    SingleCell,
    /// Everything within two landblocks of the viewer. What is not loaded is, a few landblocks a tick.
    Everything,
}

/// Where the player was after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrailStep {
    /// Seconds that bodies had moved for.
    pub seconds: f64,
    /// The player's cell.
    pub cell: CellId,
    /// Where it stood.
    pub position: Position,
    /// It was put there since the step before, and did not walk.
    pub teleported: bool,
}

/// A world being explored.
#[derive(Debug)]
pub struct Explorer {
    world: Arc<World>,
    assets: Assets,
    openings: Openings,
    population: Population,
    scratch: Scratch,
    player: BodyId,
    rig: CameraRig,
    frame: FrameView,
    input: Option<FrameInput>,
    fly: Option<FlyCamera>,
    doors: Doors,
    start: Position,
    now: f64,
    /// The time of bodies, seconds: steps that were made.
    clock: f64,
    /// Time that passed and is not stepped yet, seconds.
    owed: f64,
    /// Keys pressed since the last step, though they may be up again.
    tapped: Held,
    /// Steps of the last tick.
    trail: Vec<TrailStep>,
    teleported: bool,
    message: Option<(String, f64)>,
    viewport: Vec2,
    commands: Vec<Command>,
    /// Landblocks that were loaded, or tried to be, because everything is drawn.
    asked: BTreeSet<BlockId>,
    /// Places with names.
    pub names: Vec<NamedPlace>,
    /// Overlays that are on, by their position in [`Overlay::ALL`](crate::Overlay::ALL).
    pub overlays: [bool; 5],
    /// What is drawn.
    pub show: Show,
    /// The cell of [`Show::SingleCell`]; `None` takes the player's.
    pub single: Option<CellId>,
    /// Time of day, 0…1; 0.5 is noon.
    pub time_of_day: f32,
    /// What was clicked last.
    pub picked: Option<Picked>,
    /// The list of keys is shown.
    pub show_help: bool,
    /// Panels are shown.
    pub show_panels: bool,
    /// The map is shown.
    pub show_map: bool,
    /// Where to go is being typed.
    pub typing: Option<String>,
    /// A picture is wanted.
    pub wants_screenshot: bool,
    /// The program is to end.
    pub wants_to_leave: bool,
}

impl Explorer {
    /// A player put down at `start`, or near it.
    ///
    /// # Errors
    /// When there is no place for it.
    pub fn new(world: Arc<World>, names: Vec<NamedPlace>, start: Position) -> Result<Self, ExploreError> {
        let mut population = Population::new();
        let mut body = Body::player();
        body.locomotion = Some(Locomotion::with_skills(60.0, 50.0));
        let player = population.add(body);
        let mut explorer = Explorer {
            world,
            assets: Assets::new(),
            openings: Openings::new(),
            population,
            scratch: Scratch::new(),
            player,
            rig: CameraRig::new(ChaseCamera::default()),
            frame: FrameView::new(FrameSettings::default()),
            input: None,
            fly: None,
            doors: Doors::default(),
            start,
            now: 0.0,
            clock: 0.0,
            owed: 0.0,
            tapped: Held::default(),
            trail: Vec::new(),
            teleported: false,
            message: None,
            viewport: Vec2::new(1280.0, 720.0),
            commands: Vec::new(),
            asked: BTreeSet::new(),
            names,
            overlays: [false; 5],
            show: Show::Reached,
            single: None,
            time_of_day: 0.5,
            picked: None,
            show_help: false,
            show_panels: true,
            show_map: false,
            typing: None,
            wants_screenshot: false,
            wants_to_leave: false,
        };
        if !explorer.place(&start) {
            let world = explorer.world.clone();
            let mut near = places::spots(&world, start.cell);
            near.extend(places::middle_of(&world, start.cell));
            if !near.iter().any(|p| explorer.place(p)) {
                return Err(ExploreError::NoStart(format!("nobody can stand at {start}")));
            }
        }
        Ok(explorer)
    }

    /// The world.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// The player's body.
    pub fn body(&self) -> Option<&Body> {
        self.population.body(self.player)
    }

    /// Bodies.
    pub fn population(&self) -> &Population {
        &self.population
    }

    /// The cell the player's body is in.
    pub fn player_cell(&self) -> CellId {
        self.body()
            .map_or(CellId::NONE, |b| b.cell().unwrap_or(b.position().cell))
    }

    /// Where the eye of the player's camera is.
    pub fn viewer(&self) -> Option<&Viewer> {
        self.rig.viewer()
    }

    /// The frame of the traversal.
    pub fn frame(&self) -> &FrameView {
        &self.frame
    }

    /// Assets of the world.
    pub fn assets(&self) -> &Assets {
        &self.assets
    }

    /// The eye of the camera that flies, while the traversal is held.
    pub fn flying_at(&self) -> Option<Position> {
        let camera = self.fly.as_ref().and(self.camera())?;
        Some(Position::new(camera.cell(), camera.eye()))
    }

    /// Whether the traversal is held.
    pub fn is_frozen(&self) -> bool {
        self.fly.is_some()
    }

    /// Name of a cell, if it has one.
    pub fn name_of(&self, cell: CellId) -> Option<&str> {
        self.names
            .iter()
            .find(|n| n.position.cell == cell)
            .map(|n| n.name.as_str())
    }

    /// What is to be told.
    pub fn message(&self) -> Option<&str> {
        let (text, since) = self.message.as_ref()?;
        (self.now - since < MESSAGE_SECONDS).then_some(text.as_str())
    }

    /// Tells something for a few seconds.
    pub fn tell(&mut self, text: impl Into<String>) {
        self.message = Some((text.into(), self.now));
    }

    /// Puts the player somewhere; whether it could be.
    fn place(&mut self, at: &Position) -> bool {
        let placement = Placement::at(*at);
        let done = self
            .population
            .set_position(&self.world, &mut self.scratch, self.player, &placement);
        let there = matches!(done, Ok(Ok(vestibule_physics::Placed::InCell(_))));
        if there {
            self.teleported = true;
            let mode = self.rig.camera.mode();
            self.rig = CameraRig::new(ChaseCamera::default());
            self.rig.camera.set_mode(mode);
        }
        there
    }

    /// Goes to the place a text names, or tells why not.
    pub fn teleport(&mut self, text: &str) {
        match places::find(&self.world, &self.names, text) {
            Ok(position) => self.go_to(&position),
            Err(error) => self.tell(error.to_string()),
        }
    }

    /// Goes to a position, or tells why not.
    pub fn go_to(&mut self, position: &Position) {
        self.world.block(position.cell.block());
        if !self.world.is_resident(position.cell) {
            self.tell(format!("there is no cell {} in this world", position.cell));
            return;
        }
        if self.place(position) {
            self.fly = None;
            let cell = self.player_cell();
            let name = self.name_of(cell).map(|n| format!(" ({n})")).unwrap_or_default();
            self.tell(format!("now in {cell}{name}"));
            return;
        }
        let world = self.world.clone();
        let spots = places::spots(&world, position.cell);
        if !spots.iter().any(|spot| self.place(spot)) {
            self.tell(format!(
                "nobody can stand at {position}: nothing there, or it is taken"
            ));
            return;
        }
        self.fly = None;
        self.tell(format!(
            "that place is taken; now beside it, in {}",
            self.player_cell()
        ));
    }

    /// Turns by a drag of the mouse in pixels.
    pub fn look(&mut self, delta: Vec2) {
        if !delta.is_finite() {
            return;
        }
        if let Some(fly) = &mut self.fly {
            fly.look(delta * TURN_PER_PIXEL);
            return;
        }
        self.turn_player(-delta.x * TURN_PER_PIXEL);
        let first_person = self.rig.camera.mode() == CameraMode::FirstPerson;
        let steps = delta.y * TURN_PER_PIXEL / 8.0f32.to_radians();
        // In first person dragging down looks down; behind the character the camera rises instead.
        self.rig
            .camera
            .raise(if first_person { -steps * 0.7 } else { steps });
    }

    fn turn_player(&mut self, radians: f32) {
        let Some(body) = self.population.body(self.player) else {
            return;
        };
        let mut to = *body.position();
        let turned = Quat::from_rotation_z(radians) * to.frame.rotation();
        to.frame.set_rotation(turned);
        // A turn that is refused is no loss: the next one may do.
        let _ = self
            .population
            .move_to(&self.world, &mut self.scratch, self.player, &to);
    }

    /// Zooms by steps of the wheel, closer if above zero.
    pub fn zoom(&mut self, steps: f32) {
        if let Some(fly) = &mut self.fly {
            fly.faster(steps);
            return;
        }
        let camera = &mut self.rig.camera;
        if steps > 0.0 {
            if camera.mode() == CameraMode::Chase && !camera.zoom_in(steps.min(2.0)) {
                camera.set_mode(CameraMode::FirstPerson);
            }
        } else if steps < 0.0 {
            if camera.mode() == CameraMode::FirstPerson {
                camera.set_mode(CameraMode::Chase);
            } else {
                camera.zoom_out((-steps).min(2.0));
            }
        }
    }

    /// Notes keys that were pressed: each counts for one step at least, even if it is up again before the next tick.
    pub fn tap(&mut self, keys: Held) {
        self.tapped = self.tapped.or(keys);
    }

    /// Whether the door within reach is closed; `None` if there is none.
    pub fn door_within_reach(&self) -> Option<bool> {
        let at = self.body()?.position();
        self.doors.within_reach(&self.world, at)
    }

    /// Moves everything on by `dt` seconds, at most a second, and decides the frame for a screen of `viewport` pixels.
    /// Bodies move by steps of equal length, so that where a walk leads does not depend on the length of ticks. A screen
    /// without area keeps the last frame.
    pub fn tick(&mut self, held: &Held, dt: f32, viewport: Vec2) {
        let dt = if dt.is_finite() {
            dt.clamp(0.0, LONGEST_TICK)
        } else {
            0.0
        };
        self.now += f64::from(dt);
        self.trail.clear();
        if viewport.x >= 1.0 && viewport.y >= 1.0 && viewport.is_finite() {
            self.viewport = viewport;
        }
        if let Some(fly) = &mut self.fly {
            fly.tick(held, dt);
            self.tapped = Held::default();
            self.prepare_commands();
            return;
        }
        self.owed += f64::from(dt);
        while self.owed >= STEP {
            self.owed -= STEP;
            let held = held.or(core::mem::take(&mut self.tapped));
            self.step(held);
        }
        self.see(dt);
        self.prepare_commands();
    }

    /// A step of the player.
    fn step(&mut self, held: Held) {
        self.clock += STEP;
        let axis = |plus: bool, minus: bool| f32::from(i8::from(plus) - i8::from(minus));
        if let Some(body) = self.population.body_mut(self.player) {
            body.set_motion(Motion {
                forward: axis(held.forward, held.back),
                sidestep: axis(held.right, held.left),
                turn: axis(held.turn_right, held.turn_left),
                run: !held.slow,
            });
            if held.jump && body.can_jump() {
                body.jump(1.0, self.clock);
            }
        }
        let moved = self
            .population
            .update(&self.world, &mut self.scratch, self.player, self.clock);
        if let Err(error) = moved {
            self.tell(format!("the player cannot move: {error}"));
        }
        if let Some(position) = self.body().map(|b| *b.position()) {
            self.trail.push(TrailStep {
                seconds: self.clock,
                cell: self.player_cell(),
                position,
                teleported: core::mem::take(&mut self.teleported),
            });
        }
    }

    /// Seconds that bodies have moved for.
    pub fn clock(&self) -> f64 {
        self.clock
    }

    /// Where the player was after each step of the last tick. There may be none: ticks can be shorter than steps.
    pub fn trail(&self) -> &[TrailStep] {
        &self.trail
    }

    fn fov(&self) -> f32 {
        retail_fov_y(core::f32::consts::FRAC_PI_2, self.viewport.x / self.viewport.y)
    }

    fn see(&mut self, dt: f32) {
        let Some(target) = ViewerTarget::of_body(&self.population, self.player) else {
            return;
        };
        let viewer = self.rig.update(
            &self.world,
            &self.population,
            &mut self.scratch,
            Some(&target),
            dt,
        );
        let Some(viewer) = viewer.copied() else { return };
        let player_cell: Option<PlayerCell> = target.cell;
        match viewer.frame_input(player_cell, self.fov(), self.viewport) {
            Ok(input) => {
                let first = self.rig.camera.mode() == CameraMode::FirstPerson;
                let source = WorldObjects::new(&self.world)
                    .with_population(&self.population)
                    .without(first.then_some(self.player));
                self.frame.update(&self.world, &self.openings, &source, &input);
                self.input = Some(input);
            }
            Err(error) => {
                self.frame.keep(error);
            }
        }
    }

    /// The camera that is drawn from.
    pub fn camera(&self) -> Option<Camera> {
        match &self.fly {
            Some(fly) => fly.camera(self.fov(), self.viewport),
            None => self.frame.camera().copied(),
        }
    }

    fn prepare_commands(&mut self) {
        let mut commands = core::mem::take(&mut self.commands);
        commands.clear();
        let frozen = self.fly.is_some();
        match self.show {
            Show::Everything => {
                if let Some(camera) = self.camera() {
                    let missing = everything::to_load(&self.world, camera.cell().block(), AROUND);
                    let asked = &mut self.asked;
                    for block in missing
                        .into_iter()
                        .filter(|b| asked.insert(*b))
                        .take(LOADS_A_TICK)
                    {
                        self.world.block(block);
                    }
                    everything::commands(
                        &self.world,
                        &self.population,
                        camera.cell().block(),
                        AROUND,
                        &mut commands,
                    );
                }
            }
            Show::SingleCell => {
                let cell = self.single.unwrap_or_else(|| self.player_cell());
                self.single_cell(cell, &mut commands);
            }
            Show::Reached => {
                let eye_bound = |c: &Command| {
                    matches!(
                        c,
                        Command::Punch { .. }
                            | Command::Seal { .. }
                            | Command::ClearDepth
                            | Command::NextStamp
                    )
                };
                let list = self.frame.commands().iter();
                // From outside one looks into rooms, but not through the shell of their house.
                let root = self
                    .frame
                    .interior()
                    .and_then(|f| f.cells().first().map(|c| c.id));
                let own_shell = |c: &Command| match (c, root) {
                    (Command::Building { block, building, .. }, Some(root)) => {
                        let block = self.world.loaded_block(*block);
                        let building = block.and_then(|b| b.buildings.get(*building as usize));
                        building.is_some_and(|b| {
                            b.portals
                                .iter()
                                .any(|p| p.other == root || p.stab_list.contains(&root))
                        })
                    }
                    _ => false,
                };
                let kept = list.filter(|c| !(frozen && (eye_bound(c) || own_shell(c))));
                commands.extend(kept.copied());
            }
        }
        let doors = &self.doors;
        let player = ObjectRef::Body(self.player);
        let is_player = |c: &Command| matches!(c, Command::Object { id, .. } if *id == player);
        // An eye within the player's back sees what the traversal lets it see.
        let hidden = !frozen && !self.draws_player();
        let away = |c: &Command| matches!(c, Command::Object { id, .. } if doors.hides(*id));
        commands.retain(|c| !(away(c) || hidden && is_player(c)));
        self.commands = commands;
    }

    /// Whether the traversal lists the player.
    fn draws_player(&self) -> bool {
        let player = ObjectRef::Body(self.player);
        let mut commands = self.frame.commands().iter();
        commands.any(|c| matches!(c, Command::Object { id, .. } if *id == player))
    }

    fn single_cell(&self, cell: CellId, out: &mut Vec<Command>) {
        let views = Views::Landscape;
        if cell.is_indoor() {
            out.push(Command::Light(LightSet::Indoor));
            out.push(Command::Room { cell, views });
        } else {
            out.push(Command::Light(LightSet::Sun));
            out.push(Command::Terrain(cell));
        }
        for &id in self.world.statics_in(cell) {
            let id = ObjectRef::Static(id);
            out.push(Command::Object { id, cell, views });
        }
        for &id in self.population.shadows_in(cell) {
            let id = ObjectRef::Body(id);
            out.push(Command::Object { id, cell, views });
        }
        out.push(Command::FlushAlpha);
    }

    /// What is drawn, in order.
    pub fn commands(&self) -> &[Command] {
        &self.commands
    }

    /// The frame that the commands' polygons and regions belong to, when they are drawn from its own eye.
    pub fn regions_frame(&self) -> Option<&FrameView> {
        (self.show == Show::Reached && self.fly.is_none()).then_some(&self.frame)
    }

    /// Whether light and fog are those of sealed rooms.
    pub fn is_sealed(&self) -> bool {
        self.frame.path() == FramePath::Sealed
    }

    /// What is drawn from.
    pub fn scene(&self) -> Scene<'_> {
        let distance = self.viewer().zip(self.body()).map_or(10.0, |(viewer, body)| {
            let pivot = body.position().origin() + Vec3::new(0.0, 0.0, 1.5);
            let offset = body.position().offset_to(&viewer.position);
            (body.position().origin() + offset - pivot).length()
        });
        let opacity = if self.fly.is_some() {
            1.0
        } else {
            self.rig.camera.body_opacity(distance)
        };
        Scene::new(&self.world, &self.assets)
            .with_population(&self.population)
            .with_player(self.player, opacity)
            .at_time(self.time_of_day)
    }
}

/// A time of day as hours and minutes.
pub fn clock(time: f32) -> String {
    let minutes = (time * 24.0 * 60.0 + 0.5) as u32 % (24 * 60);
    format!("{:02}:{:02}", minutes / 60, minutes % 60)
}
