//! Sky, sun and fog by time of day (`rendering.md` 12.2, 13, 16).

use glam::Vec3;
use vestibule_dat::record::Region;
use vestibule_dat::record::region::{DayGroup, SkyObject, SkyTime};
use vestibule_world::{REGION_RECORD, Store, World};

use crate::assets::rgb;

/// What the region says about its skies. Without a sky description everything has the defaults of
/// `rendering.md` 12.3.
#[derive(Clone, Debug, Default)]
pub struct SkyTable {
    groups: Vec<DayGroup>,
    calendar: Calendar,
}

/// How the region counts time (`rendering.md` 16.0).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Calendar {
    /// Seconds.
    zero_time_of_year: f64,
    zero_year: u32,
    /// Seconds.
    day_length: f32,
    days_per_year: u32,
}

/// A moment of the game's calendar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Year.
    pub year: u32,
    /// Day of the year, from 0.
    pub day: u32,
    /// Time of day, 0…1; 0.5 is noon.
    pub time_of_day: f32,
    /// The kind of weather of the day, for [`SkyTable::daylight`].
    pub day_group: usize,
}

/// Light and fog of one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Daylight {
    /// Towards the sun; its length is the brightness (`rendering.md` 12.2).
    pub sun: Vec3,
    /// Colour of the sun, 0…1.
    pub sun_color: Vec3,
    /// Ambient brightness.
    pub ambient: f32,
    /// Ambient colour, 0…1.
    pub ambient_color: Vec3,
    /// Fog of the outdoors; `None` when it is off.
    pub fog: Option<Fog>,
    /// Colour of the sky overhead, 0…1, where no sky object covers it.
    pub zenith: Vec3,
    /// Colour of the sky at the horizon, and the clear colour (`rendering.md` 13.4).
    pub horizon: Vec3,
}

/// Linear fog by distance from the eye (`rendering.md` 13.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fog {
    /// Where it begins, metres.
    pub start: f32,
    /// Where nothing else is left, metres.
    pub end: f32,
    /// Its colour, 0…1.
    pub color: Vec3,
}

impl Fog {
    /// How much of a colour is left at this distance: 1 all, 0 none.
    #[inline]
    pub fn clear(&self, distance: f32) -> f32 {
        let span = self.end - self.start;
        let span = if span < 0.001 { 0.001 } else { span };
        ((self.end - distance) / span).clamp(0.0, 1.0)
    }
}

/// A thing in the sky at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyThing {
    /// Model (0x01…).
    pub model: u32,
    /// Height above the horizon along its path, radians: rotation about the north-south axis.
    pub angle: f32,
    /// Heading of its path, radians about up.
    pub heading: f32,
    /// Light of its own, 0…1.
    pub luminosity: f32,
    /// 0 opaque to 1 invisible.
    pub translucency: f32,
    /// Drawn after the landscape (weather), not before it.
    pub after: bool,
    /// Belongs to the weather.
    pub weather: bool,
}

impl SkyTable {
    /// Reads the skies of a world's region.
    pub fn read(world: &World) -> Self {
        let bytes = world.source().record(Store::Portal, REGION_RECORD);
        let region = bytes
            .ok()
            .flatten()
            .and_then(|b| Region::parse(REGION_RECORD, &b).ok());
        let Some(region) = region else {
            return SkyTable::default();
        };
        let time = &region.game_time;
        SkyTable {
            calendar: Calendar {
                zero_time_of_year: time.zero_time_of_year,
                zero_year: time.zero_year,
                day_length: time.day_length,
                days_per_year: time.days_per_year,
            },
            groups: region.sky.map(|s| s.day_groups).unwrap_or_default(),
        }
    }

    /// The moment of the calendar at a server's clock, seconds (`rendering.md` 16.0); noon of the first day where the
    /// region counts no time.
    pub fn moment(&self, seconds: f64) -> Moment {
        let c = &self.calendar;
        let length = f64::from(c.day_length);
        let t = seconds + c.zero_time_of_year;
        let days = t / length;
        if !(length > 0.0) || c.days_per_year == 0 || !(0.0..4.0e9).contains(&days) {
            return Moment {
                year: c.zero_year,
                day: 0,
                time_of_day: 0.5,
                day_group: self.group_of(0, c.zero_year, c.days_per_year),
            };
        }
        let whole = days as u32;
        let day = whole % c.days_per_year;
        let year = (whole / c.days_per_year).wrapping_add(c.zero_year);
        Moment {
            year,
            day,
            time_of_day: (days - f64::from(whole)) as f32,
            day_group: self.group_of(day, year, c.days_per_year),
        }
    }

    /// A table with these day groups.
    pub fn from_groups(groups: Vec<DayGroup>) -> Self {
        SkyTable {
            groups,
            calendar: Calendar::default(),
        }
    }

    /// Number of day groups (kinds of weather).
    pub fn groups(&self) -> usize {
        self.groups.len()
    }

    /// The day group of a date (`rendering.md` 16.1); 0 without any.
    pub fn group_of(&self, day_of_year: u32, year: u32, days_per_year: u32) -> usize {
        let n = day_of_year.wrapping_add(days_per_year.wrapping_mul(year));
        let h = 1_782_775_218u32.wrapping_mul(n).wrapping_sub(1_967_253_934);
        let index = (self.groups.len() as f32 * h as f32 / 4_294_967_296.0) as usize;
        if index < self.groups.len() { index } else { 0 }
    }

    /// Light at a time of day, 0…1 (`rendering.md` 16.2); 0.5 is noon.
    pub fn daylight(&self, group: usize, time: f32) -> Daylight {
        let time = wrapped(time);
        let times = self.groups.get(group).map_or(&[][..], |g| &g.sky_times);
        let Some((a, b, t)) = bracket(times, time) else {
            return Daylight::without_data(time);
        };
        let mix = |x: f32, y: f32| x + (y - x) * t;
        let color = |x, y| {
            let (x, y) = (rgb(x), rgb(y));
            x + (y - x) * t
        };
        // The shorter way round.
        let mut turn = (b.dir_heading - a.dir_heading) % 360.0;
        if turn > 180.0 {
            turn -= 360.0;
        } else if turn < -180.0 {
            turn += 360.0;
        }
        let heading = (a.dir_heading + turn * t).to_radians();
        let pitch = mix(a.dir_pitch, b.dir_pitch).to_radians();
        let bright = mix(a.dir_bright, b.dir_bright);
        let (sh, ch) = libm::sincosf(heading);
        let (sp, cp) = libm::sincosf(pitch);
        let fog_color = color(a.fog_color, b.fog_color);
        let fog_on = a.fog_type != 0 && b.fog_type != 0;
        let zenith = Daylight::without_data(time).zenith;
        Daylight {
            sun: Vec3::new(sh * cp, ch * cp, sp) * bright,
            sun_color: color(a.dir_color, b.dir_color),
            ambient: mix(a.amb_bright, b.amb_bright),
            ambient_color: color(a.amb_color, b.amb_color),
            fog: fog_on.then(|| Fog {
                start: mix(a.min_fog, b.min_fog),
                end: mix(a.max_fog, b.max_fog),
                color: fog_color,
            }),
            zenith: if fog_color == Vec3::ZERO {
                zenith
            } else {
                zenith * 0.7 + fog_color * 0.3
            },
            horizon: if fog_color == Vec3::ZERO {
                Daylight::without_data(time).horizon
            } else {
                fog_color
            },
        }
    }

    /// What is in the sky at a time of day, in drawing order (`rendering.md` 16.3).
    pub fn things(&self, group: usize, time: f32) -> Vec<SkyThing> {
        let time = wrapped(time);
        let Some(group) = self.groups.get(group) else {
            return Vec::new();
        };
        let bracket = bracket(&group.sky_times, time);
        let visible = |o: &SkyObject| o.begin_time == o.end_time || o.begin_time < time && time < o.end_time;
        let objects = group.sky_objects.iter().enumerate().filter(|(_, o)| visible(o));
        objects
            .filter_map(|(index, o)| {
                let span = o.end_time - o.begin_time;
                let t = if span > 0.0 {
                    (time - o.begin_time) / span
                } else {
                    0.0
                };
                let change = bracket.and_then(|(a, ..)| {
                    a.replaces
                        .iter()
                        .find(|r| usize::try_from(r.object_index).ok() == Some(index))
                });
                let model = change.map(|r| r.gfx_obj).filter(|&m| m != 0).unwrap_or(o.gfx_obj);
                (model != 0).then(|| SkyThing {
                    model,
                    angle: (o.begin_angle + (o.end_angle - o.begin_angle) * t).to_radians(),
                    heading: change.map_or(0.0, |r| r.rotate).to_radians(),
                    luminosity: change.map_or(1.0, |r| r.luminosity / 100.0).clamp(0.0, 1.0),
                    translucency: change.map_or(0.0, |r| r.transparent / 100.0).clamp(0.0, 1.0),
                    after: o.properties & 1 != 0,
                    weather: o.properties & 4 != 0,
                })
            })
            .collect()
    }
}

impl Daylight {
    /// Light of a world that says nothing: at noon the defaults of `rendering.md` 12.3; the sun rises in the east at
    /// a quarter of the day and sets at three quarters.
    pub fn without_data(time: f32) -> Self {
        // 1 at noon, 0 at the horizon, below zero at night.
        let high = -libm::cosf(time * core::f32::consts::TAU);
        let day = (high * 3.0 + 0.6).clamp(0.0, 1.0);
        let noon = Vec3::new(1.2, 0.0, 0.5);
        let east = libm::sinf(time * core::f32::consts::TAU);
        let sun = if (time - 0.5).abs() < 1.0e-6 {
            noon
        } else {
            Vec3::new(east, -0.35, if high > 0.02 { high } else { 0.02 }).normalize() * (1.3 * day)
        };
        let dusk = (1.0 - (high * 2.5).abs()).clamp(0.0, 1.0);
        let mix = |a: Vec3, b: Vec3, t: f32| a + (b - a) * t;
        let horizon = mix(
            mix(Vec3::new(0.05, 0.06, 0.11), Vec3::new(0.74, 0.83, 0.91), day),
            Vec3::new(0.93, 0.58, 0.36),
            dusk * 0.8,
        );
        let zenith = mix(
            mix(Vec3::new(0.01, 0.015, 0.05), Vec3::new(0.25, 0.46, 0.78), day),
            Vec3::new(0.32, 0.30, 0.48),
            dusk * 0.6,
        );
        Daylight {
            sun,
            sun_color: mix(Vec3::ONE, Vec3::new(1.0, 0.72, 0.45), dusk),
            ambient: 0.15 + 0.25 * day,
            ambient_color: Vec3::ONE,
            fog: Some(Fog {
                start: 150.0,
                end: 900.0,
                color: horizon,
            }),
            zenith,
            horizon,
        }
    }

    /// Colour of the sky in a direction of unit length, x east, y north, z up: a gradient, a haze at the horizon and
    /// the sun's disc (`rendering.md` 16.6).
    #[inline]
    pub fn sky(&self, direction: Vec3) -> Vec3 {
        let z = direction.z.clamp(0.0, 1.0);
        let t = libm::sqrtf(z);
        let mut c = self.horizon + (self.zenith - self.horizon) * t;
        let bright = libm::sqrtf(self.sun.dot(self.sun));
        if bright > 0.01 {
            let cos = self.sun.dot(direction) / bright;
            if cos > 0.9 {
                let glow = (cos - 0.9) / 0.1;
                let glow = glow * glow * glow;
                let strength = if bright < 1.0 { bright } else { 1.0 };
                c += self.sun_color * (0.35 * glow * glow * strength);
                if cos > 0.999 {
                    let edge = ((cos - 0.999) / 0.0004).clamp(0.0, 1.0);
                    c += (Vec3::ONE - c) * (edge * strength);
                }
            }
        }
        c
    }
}

fn wrapped(time: f32) -> f32 {
    if time.is_finite() {
        time - libm::floorf(time)
    } else {
        0.5
    }
}

/// The entries before and after a time, the last wrapping to the first, and how far between them it is.
fn bracket(times: &[SkyTime], time: f32) -> Option<(&SkyTime, &SkyTime, f32)> {
    let first = times.first()?;
    let last = times.last()?;
    let after = times.iter().position(|t| t.begin > time);
    let (a, b) = match after {
        Some(0) => (last, first),
        Some(i) => (&times[i - 1], &times[i]),
        None => (last, first),
    };
    let mut span = b.begin - a.begin;
    if span <= 0.0 {
        span += 1.0;
    }
    let mut gone = time - a.begin;
    if gone < 0.0 {
        gone += 1.0;
    }
    let t = gone / span;
    Some((a, b, if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn r12_3_defaults_at_noon() {
        let d = Daylight::without_data(0.5);
        assert_eq!((d.sun, d.sun_color), (Vec3::new(1.2, 0.0, 0.5), Vec3::ONE));
        assert!((d.ambient - 0.4).abs() < 1e-6);
    }

    #[test]
    fn r13_1_fog_is_linear_and_never_divides_by_zero() {
        let fog = Fog {
            start: 10.0,
            end: 20.0,
            color: Vec3::ZERO,
        };
        assert_eq!(
            [5.0, 10.0, 15.0, 20.0, 25.0].map(|d| fog.clear(d)),
            [1.0, 1.0, 0.5, 0.0, 0.0]
        );
        let wall = Fog { end: 10.0, ..fog };
        assert_eq!((wall.clear(9.9), wall.clear(10.1)), (1.0, 0.0));
    }

    #[test]
    fn r16_0_a_servers_clock_tells_day_and_time() {
        let mut table = SkyTable::from_groups(vec![group()]);
        table.calendar = Calendar {
            zero_time_of_year: 3600.0,
            zero_year: 10,
            day_length: 7620.0,
            days_per_year: 360,
        };
        let m = table.moment(7620.0 * (360.0 * 2.0 + 5.0) - 3600.0 + 1905.0);
        assert_eq!((m.year, m.day, m.day_group), (12, 5, 0));
        assert!((m.time_of_day - 0.25).abs() < 1e-4);
        for odd in [f64::NAN, f64::INFINITY, -1.0e300] {
            assert_eq!(table.moment(odd).time_of_day, 0.5);
        }
        assert_eq!(SkyTable::default().moment(1.0e6).day, 0);
    }

    #[test]
    fn r16_2_times_of_day_blend_and_wrap() {
        use vestibule_dat::primitive::Argb;
        let entry = |begin: f32, bright: f32, heading: f32, fog: u32| SkyTime {
            begin,
            dir_bright: bright,
            dir_heading: heading,
            amb_bright: bright,
            fog_type: fog,
            min_fog: 10.0 * bright,
            max_fog: 100.0,
            fog_color: Argb(0xFF80_8080),
            ..SkyTime::default()
        };
        let mut day = group();
        day.sky_times = vec![entry(0.25, 1.0, 350.0, 1), entry(0.75, 3.0, 10.0, 1)];
        let table = SkyTable::from_groups(vec![day.clone()]);
        let noon = table.daylight(0, 0.5);
        assert!((noon.ambient - 2.0).abs() < 1e-5);
        // From 350 to 10 degrees by the shorter way: due north at the middle.
        assert!(
            noon.sun.x.abs() < 1e-3 && (noon.sun.y - 2.0).abs() < 1e-3,
            "{}",
            noon.sun
        );
        assert_eq!(noon.fog.map(|f| f.start), Some(20.0));
        // The last entry leads back to the first.
        assert!((table.daylight(0, 0.0).ambient - 2.0).abs() < 1e-5);
        assert!((table.daylight(0, 0.85).ambient - 2.6).abs() < 1e-5);
        day.sky_times[1].fog_type = 0;
        assert_eq!(
            SkyTable::from_groups(vec![day]).daylight(0, 0.5).fog,
            None,
            "both must be on"
        );
    }

    #[test]
    fn r16_3_things_of_the_sky_rise_and_set() {
        let mut day = group();
        day.sky_objects = vec![
            SkyObject {
                begin_time: 0.25,
                end_time: 0.75,
                begin_angle: 0.0,
                end_angle: 180.0,
                gfx_obj: 0x0100_0001,
                ..SkyObject::default()
            },
            SkyObject {
                gfx_obj: 0x0100_0002,
                properties: 1 | 4,
                ..SkyObject::default()
            },
        ];
        let table = SkyTable::from_groups(vec![day]);
        let at = |t: f32| table.things(0, t);
        assert_eq!(at(0.2).len(), 1, "not risen; the other is always there");
        let noon = at(0.5);
        assert_eq!(noon.len(), 2);
        assert!((noon[0].angle - core::f32::consts::FRAC_PI_2).abs() < 1e-5);
        assert!(!noon[0].after && noon[1].after && noon[1].weather);
    }

    #[test]
    fn r16_1_day_groups_stay_in_range() {
        let table = SkyTable::from_groups((0..7).map(|_| group()).collect());
        for day in 0..1000 {
            assert!(table.group_of(day, 12, 360) < 7);
        }
    }

    fn group() -> DayGroup {
        DayGroup {
            chance: 1.0,
            name: Default::default(),
            sky_objects: Vec::new(),
            sky_times: Vec::new(),
        }
    }
}
