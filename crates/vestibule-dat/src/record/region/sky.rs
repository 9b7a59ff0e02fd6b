//! Calendar and sky.

use crate::primitive::{Argb, Bool32, LegacyString, Reader, Writer};
use crate::record::RecordError;

/// The calendar.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Season {
    /// Day of the year on which it begins.
    pub start: u32,
    /// Name.
    pub name: LegacyString,
}

/// The skies.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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

impl GameTime {
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            zero_time_of_year: reader.f64("game_time.zero_time_of_year")?,
            zero_year: reader.u32("game_time.zero_year")?,
            day_length: reader.f32("game_time.day_length")?,
            days_per_year: reader.u32("game_time.days_per_year")?,
            year_spec: reader.legacy_string("game_time.year_spec")?,
            times_of_day: reader.list32(10, "game_time.times_of_day", |reader| {
                Ok(TimeOfDay {
                    start: reader.f32("time_of_day.start")?,
                    is_night: reader.bool32("time_of_day.is_night")?,
                    name: reader.legacy_string("time_of_day.name")?,
                })
            })?,
            days_of_week: reader.list32(2, "game_time.days_of_week", |reader| {
                reader.legacy_string("game_time.days_of_week")
            })?,
            seasons: reader.list32(6, "game_time.seasons", |reader| {
                Ok(Season {
                    start: reader.u32("season.start")?,
                    name: reader.legacy_string("season.name")?,
                })
            })?,
        })
    }

    pub(super) fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.f64(self.zero_time_of_year);
        writer.u32(self.zero_year);
        writer.f32(self.day_length);
        writer.u32(self.days_per_year);
        writer.legacy_string(&self.year_spec, "game_time.year_spec")?;
        writer.count32(self.times_of_day.len(), "game_time.times_of_day")?;
        for time in &self.times_of_day {
            writer.f32(time.start);
            writer.bool32(time.is_night);
            writer.legacy_string(&time.name, "time_of_day.name")?;
        }
        writer.count32(self.days_of_week.len(), "game_time.days_of_week")?;
        for name in &self.days_of_week {
            writer.legacy_string(name, "game_time.days_of_week")?;
        }
        writer.count32(self.seasons.len(), "game_time.seasons")?;
        for season in &self.seasons {
            writer.u32(season.start);
            writer.legacy_string(&season.name, "season.name")?;
        }
        Ok(())
    }
}

impl SkyDesc {
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            tick_size: reader.f64("sky.tick_size")?,
            light_tick_size: reader.f64("sky.light_tick_size")?,
            day_groups: reader.list32(14, "sky.day_groups", DayGroup::read)?,
        })
    }

    pub(super) fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.f64(self.tick_size);
        writer.f64(self.light_tick_size);
        writer.count32(self.day_groups.len(), "sky.day_groups")?;
        self.day_groups.iter().try_for_each(|group| group.write(writer))
    }
}

impl DayGroup {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            chance: reader.f32("day_group.chance")?,
            name: reader.legacy_string("day_group.name")?,
            sky_objects: reader.list32(36, "day_group.sky_objects", SkyObject::read)?,
            sky_times: reader.list32(48, "day_group.sky_times", SkyTime::read)?,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.f32(self.chance);
        writer.legacy_string(&self.name, "day_group.name")?;
        writer.count32(self.sky_objects.len(), "day_group.sky_objects")?;
        self.sky_objects.iter().for_each(|object| object.write(writer));
        writer.count32(self.sky_times.len(), "day_group.sky_times")?;
        self.sky_times.iter().try_for_each(|time| time.write(writer))
    }
}

impl SkyObject {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            begin_time: reader.f32("sky_object.begin_time")?,
            end_time: reader.f32("sky_object.end_time")?,
            begin_angle: reader.f32("sky_object.begin_angle")?,
            end_angle: reader.f32("sky_object.end_angle")?,
            tex_velocity_x: reader.f32("sky_object.tex_velocity_x")?,
            tex_velocity_y: reader.f32("sky_object.tex_velocity_y")?,
            gfx_obj: reader.u32("sky_object.gfx_obj")?,
            pes: reader.u32("sky_object.pes")?,
            properties: reader.u32("sky_object.properties")?,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.f32s(&[
            self.begin_time,
            self.end_time,
            self.begin_angle,
            self.end_angle,
            self.tex_velocity_x,
            self.tex_velocity_y,
        ]);
        writer.u32s(&[self.gfx_obj, self.pes, self.properties]);
    }
}

impl SkyTime {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            begin: reader.f32("sky_time.begin")?,
            dir_bright: reader.f32("sky_time.dir_bright")?,
            dir_heading: reader.f32("sky_time.dir_heading")?,
            dir_pitch: reader.f32("sky_time.dir_pitch")?,
            dir_color: reader.argb("sky_time.dir_color")?,
            amb_bright: reader.f32("sky_time.amb_bright")?,
            amb_color: reader.argb("sky_time.amb_color")?,
            min_fog: reader.f32("sky_time.min_fog")?,
            max_fog: reader.f32("sky_time.max_fog")?,
            fog_color: reader.argb("sky_time.fog_color")?,
            fog_type: reader.u32("sky_time.fog_type")?,
            replaces: reader.list32(24, "sky_time.replaces", SkyObjectReplace::read)?,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.f32s(&[self.begin, self.dir_bright, self.dir_heading, self.dir_pitch]);
        writer.argb(self.dir_color);
        writer.f32(self.amb_bright);
        writer.argb(self.amb_color);
        writer.f32s(&[self.min_fog, self.max_fog]);
        writer.argb(self.fog_color);
        writer.u32(self.fog_type);
        writer.count32(self.replaces.len(), "sky_time.replaces")?;
        for replace in &self.replaces {
            writer.u32s(&[replace.object_index, replace.gfx_obj]);
            writer.f32s(&[
                replace.rotate,
                replace.transparent,
                replace.luminosity,
                replace.max_bright,
            ]);
        }
        Ok(())
    }
}

impl SkyObjectReplace {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            object_index: reader.u32("replace.object_index")?,
            gfx_obj: reader.u32("replace.gfx_obj")?,
            rotate: reader.f32("replace.rotate")?,
            transparent: reader.f32("replace.transparent")?,
            luminosity: reader.f32("replace.luminosity")?,
            max_bright: reader.f32("replace.max_bright")?,
        })
    }
}
