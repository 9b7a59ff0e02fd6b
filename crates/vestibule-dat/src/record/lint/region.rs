//! The Region record.

use super::Lints;
use crate::record::Region;
use crate::record::region::{DayGroup, SkyTime};

impl Lints {
    pub(super) fn region(&mut self, region: &Region) {
        if let Err(field) = region.land_defs.validate() {
            let refused = format_args!("has a value that the client refuses");
            self.add("X7", format_args!("land_defs.{field}"), refused);
        }
        let time = &region.game_time;
        self.double("game_time.zero_time_of_year", time.zero_time_of_year);
        self.float(format_args!("game_time.day_length"), time.day_length);
        for (i, time) in time.times_of_day.iter().enumerate() {
            self.float(format_args!("game_time.times_of_day[{i}].start"), time.start);
        }
        if let Some(sky) = &region.sky {
            self.double("sky.tick_size", sky.tick_size);
            self.double("sky.light_tick_size", sky.light_tick_size);
            for (i, group) in sky.day_groups.iter().enumerate() {
                self.day_group(i, group);
            }
        }
        let sounds = region.sound.iter().flat_map(|sound| &sound.tables).enumerate();
        for (i, table) in sounds {
            for (k, sound) in table.sounds.iter().enumerate() {
                for (name, value) in [
                    ("volume", sound.volume),
                    ("base_chance", sound.base_chance),
                    ("min_rate", sound.min_rate),
                    ("max_rate", sound.max_rate),
                ] {
                    self.float(format_args!("sound.tables[{i}].sounds[{k}].{name}"), value);
                }
            }
        }
        let tables = region.sound.as_ref().map_or(0, |sound| sound.tables.len());
        let scene_types = region.scene.as_ref().map_or(&[][..], |scene| &scene.scene_types);
        for (i, scene_type) in scene_types.iter().enumerate() {
            self.index(
                format_args!("scene.scene_types[{i}].stb_index"),
                scene_type.stb_index,
                tables,
            );
        }
        for (i, terrain_type) in region.terrain.terrain_types.iter().enumerate() {
            for (k, &index) in terrain_type.scene_types.iter().enumerate() {
                let field = format_args!("terrain.terrain_types[{i}].scene_types[{k}]");
                self.index(field, index, scene_types.len());
            }
        }
    }

    /// A position in a list of `count`; -1 is none.
    fn index(&mut self, field: std::fmt::Arguments<'_>, index: i32, count: usize) {
        if index != -1 && usize::try_from(index).map_or(true, |index| index >= count) {
            self.add("10.4", field, format_args!("is {index}, there are {count}"));
        }
    }

    fn double(&mut self, field: &str, value: f64) {
        if !value.is_finite() {
            self.add("D4", format_args!("{field}"), format_args!("is {value}"));
        }
    }

    fn day_group(&mut self, i: usize, group: &DayGroup) {
        self.float(format_args!("sky.day_groups[{i}].chance"), group.chance);
        for (k, object) in group.sky_objects.iter().enumerate() {
            for (name, value) in [
                ("begin_time", object.begin_time),
                ("end_time", object.end_time),
                ("begin_angle", object.begin_angle),
                ("end_angle", object.end_angle),
                ("tex_velocity_x", object.tex_velocity_x),
                ("tex_velocity_y", object.tex_velocity_y),
            ] {
                self.float(format_args!("sky.day_groups[{i}].sky_objects[{k}].{name}"), value);
            }
        }
        for (k, time) in group.sky_times.iter().enumerate() {
            self.sky_time(
                format_args!("sky.day_groups[{i}].sky_times[{k}]"),
                time,
                group.sky_objects.len(),
            );
        }
    }

    fn sky_time(&mut self, at: std::fmt::Arguments<'_>, time: &SkyTime, objects: usize) {
        for (name, value) in [
            ("begin", time.begin),
            ("dir_bright", time.dir_bright),
            ("dir_heading", time.dir_heading),
            ("dir_pitch", time.dir_pitch),
            ("amb_bright", time.amb_bright),
            ("min_fog", time.min_fog),
            ("max_fog", time.max_fog),
        ] {
            self.float(format_args!("{at}.{name}"), value);
        }
        for (i, replace) in time.replaces.iter().enumerate() {
            if replace.object_index as usize >= objects {
                let index = replace.object_index;
                let field = format_args!("{at}.replaces[{i}].object_index");
                self.add("10.4", field, format_args!("is {index}, there are {objects}"));
            }
            for (name, value) in [
                ("rotate", replace.rotate),
                ("transparent", replace.transparent),
                ("luminosity", replace.luminosity),
                ("max_bright", replace.max_bright),
            ] {
                self.float(format_args!("{at}.replaces[{i}].{name}"), value);
            }
        }
    }
}
