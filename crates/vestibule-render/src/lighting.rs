//! Light on surfaces: sun, ambient, lamps (`rendering.md` 12).

use std::sync::Arc;

use glam::Vec3;
use vestibule_world::{EnvCell, World};

use crate::assets::Assets;
use crate::scene::LightDetail;
use crate::sky::Daylight;

/// Ambient level of sealed interiors (`rendering.md` 12.3).
pub(crate) const SEALED_AMBIENT: f32 = 0.2;
/// A lamp lights objects this much farther than its falloff (`rendering.md` 12.5).
pub const OBJECT_RANGE: f32 = 1.5;
/// A lamp lights shells this much farther than its falloff (`rendering.md` 12.6).
pub(crate) const SHELL_RANGE: f32 = 1.3;
/// Lamps that light one object (`rendering.md` 12.1).
pub const MAX_OBJECT_LAMPS: usize = 8;
/// Lamps that light one shell: retail's pool (`rendering.md` 12.1).
pub const MAX_SHELL_LAMPS: usize = 40;

/// Share of a lamp's light on a wall that comes back from it.
const THROWN_BACK: f32 = 0.3;

/// A point light, in whatever frame it is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Where, metres.
    pub position: Vec3,
    /// Red, green, blue, 0…1.
    pub color: Vec3,
    /// Brightness.
    pub intensity: f32,
    /// Metres.
    pub falloff: f32,
}

impl Lamp {
    /// The light a viewer carries (`rendering.md` 12.7): white, 2 m over the player's feet.
    pub fn of_viewer(position: Vec3) -> Self {
        Lamp {
            position,
            color: Vec3::ONE,
            intensity: 2.25,
            falloff: 10.0,
        }
    }

    /// What it adds to a corner of a shell with this place and unit normal (`rendering.md` 12.6).
    #[inline]
    pub fn on_shell(&self, place: Vec3, normal: Vec3) -> Vec3 {
        let gap = self.position - place;
        let square = gap.dot(gap);
        let range = self.falloff * SHELL_RANGE;
        if !(square < range * range) {
            return Vec3::ZERO;
        }
        let d = libm::sqrtf(square);
        let w = (0.5 * d + normal.dot(gap)) / 1.5;
        if !(w > 0.0) {
            return Vec3::ZERO;
        }
        let k = if d <= 1.0 {
            if d > 0.0 { w / d } else { 0.0 }
        } else {
            w / (square * d)
        };
        let k = k * (1.0 - d / range) * self.intensity;
        let c = self.color;
        // No more than its own colour per channel.
        if k < 1.0 { c * k } else { c }
    }

    /// What it adds to a corner of an object, before the material (`rendering.md` 12.5).
    #[inline]
    pub fn on_object(&self, place: Vec3, normal: Vec3) -> Vec3 {
        let gap = self.position - place;
        let square = gap.dot(gap);
        let range = self.falloff * OBJECT_RANGE;
        if !(square < range * range) || !(square > 0.0) {
            return Vec3::ZERO;
        }
        // N·L / d with L = gap / d.
        let facing = normal.dot(gap) / square;
        if facing > 0.0 {
            self.color * (self.intensity * facing)
        } else {
            Vec3::ZERO
        }
    }
}

impl Lamp {
    /// What walls and floors around throw back onto a thing at this place, from all sides: a part of what they get. With
    /// light per pixel only; retail has none of it, and what is turned away from every lamp is nearly black there.
    #[inline]
    pub fn thrown_back(&self, place: Vec3) -> Vec3 {
        let gap = self.position - place;
        let square = gap.dot(gap);
        let range = self.falloff * SHELL_RANGE;
        if !(square < range * range) {
            return Vec3::ZERO;
        }
        let near = 1.0 - libm::sqrtf(square) / range;
        let k = near * self.intensity / if square > 1.0 { square } else { 1.0 };
        self.color * (THROWN_BACK * if k < 1.0 { k } else { 1.0 })
    }
}

/// Baked light on a corner of a shell: the sum over lamps, each channel at most 1 (`rendering.md` 12.6).
pub fn shell_light(lamps: &[Lamp], place: Vec3, normal: Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for lamp in lamps {
        sum += lamp.on_shell(place, normal);
    }
    clamp01(sum)
}

/// How much of the ambient light outdoors is left in rooms that see the outside when light is per pixel: so much that
/// lamps show by day and daylight stays outside.
const DIMMED: f32 = 0.62;

/// The sun and the ambient light of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightLevels {
    /// Towards the sun, unit.
    pub sun_direction: Vec3,
    /// Its colour times its brightness.
    pub sun: Vec3,
    /// Ambient light on terrain.
    pub terrain: Vec3,
    /// Ambient light on objects and shells outdoors, and indoors where the outside can be seen.
    pub outdoors: Vec3,
    /// Ambient light of interiors in this frame.
    pub indoors: Vec3,
}

impl LightLevels {
    /// The levels of a frame; `sealed`: the viewer's cell does not see the outside (`rendering.md` 12.3). With light per
    /// pixel the rooms of a frame that sees out are dimmed, which is not retail's.
    pub fn new(day: &Daylight, sealed: bool, detail: LightDetail) -> Self {
        let bright = libm::sqrtf(day.sun.dot(day.sun));
        let a = if day.ambient >= 0.2 { day.ambient } else { 0.2 };
        let outdoors = day.ambient_color * (bright * 0.2 + day.ambient);
        LightLevels {
            sun_direction: if bright > 0.0 { day.sun / bright } else { Vec3::Z },
            sun: day.sun_color * bright,
            terrain: day.ambient_color * a,
            outdoors,
            indoors: match (sealed, detail) {
                (true, _) => Vec3::splat(SEALED_AMBIENT),
                (false, LightDetail::PerPixel) => outdoors * DIMMED,
                (false, _) => outdoors,
            },
        }
    }

    /// Sun and ambient light on an object outdoors, before the material.
    #[inline]
    pub fn on_object(&self, normal: Vec3) -> Vec3 {
        let facing = normal.dot(self.sun_direction);
        if facing > 0.0 {
            self.outdoors + self.sun * facing
        } else {
            self.outdoors
        }
    }

    /// Light on a terrain corner (`rendering.md` 12.4).
    #[inline]
    pub fn on_terrain(&self, normal: Vec3) -> Vec3 {
        let facing = normal.dot(self.sun_direction);
        let light = if facing > 0.0 {
            self.terrain + self.sun * facing
        } else {
            self.terrain
        };
        clamp01(light)
    }
}

/// Every channel cut to 0…1.
#[inline]
pub(crate) fn clamp01(c: Vec3) -> Vec3 {
    c.clamp(Vec3::ZERO, Vec3::ONE)
}

/// Light above a half rolls off towards 1 instead of being cut there, so that bright rooms keep their shape.
#[inline]
pub(crate) fn soft(c: Vec3) -> Vec3 {
    let channel = |v: f32| {
        if v <= 0.5 {
            if v > 0.0 { v } else { 0.0 }
        } else {
            // 0.5 + 0.5 (1 - 1 / (1 + x + x²)) with the same slope at a half.
            let x = (v - 0.5) * 2.0;
            1.0 - 0.5 / (1.0 + x + x * x * 0.5)
        }
    };
    Vec3::new(channel(c.x), channel(c.y), channel(c.z))
}

/// The lamps of a cell and of its stab list, landblock frame.
pub(crate) fn lamps_of(assets: &Assets, world: &World, cell: &EnvCell) -> Arc<[Lamp]> {
    let Some(block) = world.block(cell.id.block()) else {
        return [].into();
    };
    let bounds = cell.structure.bounds.map(|b| {
        let center = cell.frame.local_to_global((b.min + b.max) * 0.5);
        let half = (b.max - b.min) * 0.5;
        (center, libm::sqrtf(half.dot(half)))
    });
    let cells = core::iter::once(&cell.id).chain(cell.stab_list.iter().filter(|&&id| id != cell.id));
    let mut lamps = Vec::new();
    for other in cells.filter_map(|&id| block.env_cell(id)) {
        let range = other.statics.start as usize..other.statics.end as usize;
        for object in block.statics.get(range).unwrap_or(&[]) {
            for light in assets.lights(world, object.shape.id).iter() {
                let position = object.frame.local_to_global(light.position);
                let reach = light.falloff * OBJECT_RANGE;
                let near = bounds.is_none_or(|(center, radius)| {
                    let gap = position - center;
                    gap.dot(gap) < (reach + radius) * (reach + radius)
                });
                if near && lamps.len() < MAX_SHELL_LAMPS {
                    lamps.push(Lamp {
                        position,
                        color: light.color,
                        intensity: light.intensity,
                        falloff: light.falloff,
                    });
                }
            }
        }
    }
    lamps.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp() -> Lamp {
        Lamp {
            position: Vec3::ZERO,
            color: Vec3::new(255.0, 150.0, 80.0) / 255.0,
            intensity: 100.0,
            falloff: 4.0,
        }
    }

    #[test]
    fn r24_baked_light() {
        let at = |d: f32, normal: Vec3| shell_light(&[lamp()], Vec3::new(0.0, 0.0, -d), normal);
        assert_eq!(
            at(1.5, Vec3::Z),
            lamp().color,
            "facing at 1.5 m: exactly its colour"
        );
        assert_eq!(at(6.0, Vec3::Z), Vec3::ZERO, "out of range");
        assert_eq!(at(1.5, -Vec3::Z), Vec3::ZERO, "facing away");
        assert!(at(1.5, Vec3::X).x > 0.0, "perpendicular is half lit");
        assert_eq!(shell_light(&[], Vec3::ZERO, Vec3::Z), Vec3::ZERO);
    }

    #[test]
    fn r12_5_lamps_on_objects_end_at_their_range() {
        let on = |d: f32| lamp().on_object(Vec3::new(0.0, 0.0, -d), Vec3::Z).x;
        assert!(on(5.9) > 0.0);
        assert_eq!(on(6.1), 0.0);
        assert!((on(4.0) - 25.0).abs() < 1e-3, "intensity by distance");
    }

    #[test]
    fn light_comes_back_from_the_walls() {
        let back = |d: f32| lamp().thrown_back(Vec3::new(0.0, 0.0, -d));
        assert_eq!(
            back(1.5),
            lamp().color * THROWN_BACK,
            "no more than a share of its colour"
        );
        assert!(back(4.0).x > back(4.9).x && back(4.9).x > 0.0);
        assert_eq!(back(5.3), Vec3::ZERO, "out of range");
    }

    #[test]
    fn r12_3_sealed_interiors_have_their_own_level() {
        let day = Daylight::without_data(0.5);
        let levels = |sealed, detail| LightLevels::new(&day, sealed, detail);
        assert_eq!(levels(true, LightDetail::PerPixel).indoors, Vec3::splat(0.2));
        let open = levels(false, LightDetail::PerVertex);
        assert!((open.indoors.x - (1.3 * 0.2 + 0.4)).abs() < 1e-5);
        assert_eq!(
            open.indoors * DIMMED,
            levels(false, LightDetail::PerPixel).indoors
        );
        assert!((open.terrain.x - 0.4).abs() < 1e-6);
    }
}
