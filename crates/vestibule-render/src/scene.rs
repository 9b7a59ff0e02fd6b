//! What is drawn and how: the inputs of a picture besides the frame.

use vestibule_physics::{BodyId, Population};
use vestibule_world::World;

use crate::assets::Assets;
use crate::sky::Daylight;

/// The world to draw from, with its assets, its bodies and the time.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The world of the frame.
    pub world: &'a World,
    /// The assets of that world.
    pub assets: &'a Assets,
    /// Bodies, if there are any.
    pub population: Option<&'a Population>,
    /// The player: carries the viewer light and may be faded.
    pub player: Option<BodyId>,
    /// How much of the player shows, 0…1 (`rendering.md` 4.8).
    pub player_opacity: f32,
    /// Time of day, 0…1; 0.5 is noon.
    pub time_of_day: f32,
    /// Which kind of weather, by position in the region's list (`rendering.md` 16.1).
    pub day_group: usize,
}

impl<'a> Scene<'a> {
    /// A world at noon without bodies.
    pub fn new(world: &'a World, assets: &'a Assets) -> Self {
        Scene {
            world,
            assets,
            population: None,
            player: None,
            player_opacity: 1.0,
            time_of_day: 0.5,
            day_group: 0,
        }
    }

    /// With these bodies.
    #[must_use]
    pub fn with_population(mut self, population: &'a Population) -> Self {
        self.population = Some(population);
        self
    }

    /// With this player, of whom a share 0…1 shows.
    #[must_use]
    pub fn with_player(mut self, player: BodyId, opacity: f32) -> Self {
        (self.player, self.player_opacity) = (Some(player), opacity);
        self
    }

    /// At this time of day, 0…1.
    #[must_use]
    pub fn at_time(mut self, time_of_day: f32) -> Self {
        self.time_of_day = time_of_day;
        self
    }

    /// Light, fog and sky of the moment.
    pub fn daylight(&self) -> Daylight {
        self.assets
            .sky(self.world)
            .daylight(self.day_group, self.time_of_day)
    }
}

/// Where light is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightDetail {
    /// At the corners of polygons, as retail does (`rendering.md` 12.5, 12.6).
    PerVertex,
    /// At every pixel, by the same formulas: lamps in the middle of a large wall show. Indoors bright light rolls off
    /// softly instead of being cut at white, walls throw some light back onto what stands between them, and rooms
    /// that see the outside get less of its ambient light.
    #[default]
    PerPixel,
}

/// How pictures are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Where light is computed.
    pub light: LightDetail,
    /// Fog outdoors and in rooms that see out (`rendering.md` 13).
    pub fog: bool,
    /// Rooms that overlap others in the same list show only inside their own regions (`rendering.md` 9.5).
    pub confine_overlaps: bool,
    /// The light that the viewer carries (`rendering.md` 12.7). With light per pixel it is weaker in rooms that see
    /// the outside.
    pub viewer_light: bool,
    /// How much lower than it is the ground is drawn, metres (`rendering.md` 6.6).
    pub terrain_offset: f32,
    /// From a room, what lies before an exit is not drawn as landscape: a shell or a hillside that a tunnel runs through
    /// does not stand in the tunnel. Retail draws it.
    pub only_behind_exits: bool,
    /// Ground that faces away from the eye is not drawn (`rendering.md` 6.9).
    pub cull_terrain: bool,
    /// Quality of the levels of detail of objects, -1…1 (`rendering.md` 17.1); for buildings see
    /// [`DetailedObjects`](crate::DetailedObjects).
    pub detail: f32,
    /// Distance, texture coordinates, light and fog are computed at every pixel of a row, as a graphics card does, not at
    /// every eighth: the far ground is a little different then, and drawing takes twice as long.
    pub exact: bool,
    /// Threads that colour a picture; 0 is as many as the machine runs at once. The picture is the same.
    pub threads: usize,
}

impl Default for RenderSettings {
    fn default() -> Self {
        RenderSettings {
            light: LightDetail::default(),
            fog: true,
            confine_overlaps: true,
            viewer_light: true,
            terrain_offset: crate::land::TERRAIN_OFFSET,
            only_behind_exits: true,
            cull_terrain: true,
            detail: 0.0,
            exact: false,
            threads: 0,
        }
    }
}

/// What happened while a picture was drawn, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderCounters {
    /// Triangles drawn, behind or outside the screen included.
    pub triangles: u32,
    /// Things a command names that the world or the assets do not have.
    pub missing: u32,
    /// See-through triangles put aside and drawn at a flush.
    pub deferred: u32,
    /// Rooms confined to their regions because they overlap another.
    pub confined: u32,
}
