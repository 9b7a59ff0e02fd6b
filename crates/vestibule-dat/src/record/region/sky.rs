//! Calendar and sky.

use crate::primitive::{Argb, Bool32, LegacyString};

/// The calendar.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GameTime {
    /// Seconds at which the first year begins.
    pub zero_time_of_year: f64,
    /// Number of the first year.
    pub zero_year: u32,
    /// Seconds in a day.
    pub day_length: f32,
    /// Days in a year.
    pub days_per_year: u32,
    /// How years are written.
    pub year_spec: LegacyString,
    /// Parts of the day.
    pub times_of_day: Vec<TimeOfDay>,
    /// Names of the days.
    pub days_of_week: Vec<LegacyString>,
    /// Seasons.
    pub seasons: Vec<Season>,
}

/// A part of the day.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TimeOfDay {
    /// When it begins, as a fraction of the day.
    pub start: f32,
    /// Whether it is night.
    pub is_night: Bool32,
    /// Name.
    pub name: LegacyString,
}

/// A season.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Season {
    /// Day of the year on which it begins.
    pub start: u32,
    /// Name.
    pub name: LegacyString,
}

/// The skies.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SkyDesc {
    /// Seconds between two updates of the sky.
    pub tick_size: f64,
    /// Seconds between two updates of the light.
    pub light_tick_size: f64,
    /// Kinds of weather.
    pub day_groups: Vec<DayGroup>,
}

/// One kind of weather.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DayGroup {
    /// How likely it is.
    pub chance: f32,
    /// Name.
    pub name: LegacyString,
    /// What is in the sky.
    pub sky_objects: Vec<SkyObject>,
    /// Light over the day.
    pub sky_times: Vec<SkyTime>,
}

/// Something in the sky.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SkyObject {
    /// When it rises, as a fraction of the day.
    pub begin_time: f32,
    /// When it sets.
    pub end_time: f32,
    /// Where it rises, degrees.
    pub begin_angle: f32,
    /// Where it sets, degrees.
    pub end_angle: f32,
    /// Drift of its texture.
    pub tex_velocity_x: f32,
    /// Drift of its texture.
    pub tex_velocity_y: f32,
    /// Model.
    pub gfx_obj: u32,
    /// PhysicsScript.
    pub pes: u32,
    /// Property bits.
    pub properties: u32,
}

/// Light and fog from one time of day on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SkyTime {
    /// When, as a fraction of the day.
    pub begin: f32,
    /// Brightness of the sun.
    pub dir_bright: f32,
    /// Heading of the sun, degrees.
    pub dir_heading: f32,
    /// Pitch of the sun, degrees.
    pub dir_pitch: f32,
    /// Colour of the sun.
    pub dir_color: Argb,
    /// Brightness of the ambient light.
    pub amb_bright: f32,
    /// Colour of the ambient light.
    pub amb_color: Argb,
    /// Where fog begins, metres.
    pub min_fog: f32,
    /// Where fog is full, metres.
    pub max_fog: f32,
    /// Colour of the fog.
    pub fog_color: Argb,
    /// Kind of fog.
    pub fog_type: u32,
    /// Objects that look different now.
    pub replaces: Vec<SkyObjectReplace>,
}

/// How one of the sky's objects looks from one time of day on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SkyObjectReplace {
    /// Position in `DayGroup::sky_objects`.
    pub object_index: u32,
    /// Model, 0 as before.
    pub gfx_obj: u32,
    /// Rotation, degrees.
    pub rotate: f32,
    /// Transparency.
    pub transparent: f32,
    /// Light of its own.
    pub luminosity: f32,
    /// Highest brightness.
    pub max_bright: f32,
}
