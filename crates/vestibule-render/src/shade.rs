//! What the pixels of a picture look like. Opaque triangles only say which pixels are theirs; each pixel is coloured
//! once, when all of them have spoken, however often it was drawn over.
//!
//! Along a row, what changes slowly (distance, texture coordinates, light, fog) is computed every few pixels and is
//! linear between, or at each pixel (`RenderSettings::exact`).

use std::sync::Arc;

use glam::Vec3;

use crate::land::LandMesh;
use crate::lighting::{Lamp, LightLevels, clamp01, shell_light, soft};
use crate::material::Material;
use crate::place::EyeFrame;
use crate::raster::scan::{Affine, Projection, Setup};
use crate::scene::LightDetail;
use crate::sky::{Daylight, Fog};
use crate::terrain_paint::Way;
use crate::texel::TexelWalk;
use crate::texture::Texture;

/// Pixels of a row over which things are taken as linear, unless the picture is to be exact.
const STEP: u32 = 8;
/// Fewer pixels than this are coloured by one thread.
const MANY_PIXELS: usize = 1 << 15;

/// The light on a mesh; lamps in camera axes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum MeshLight<'l> {
    /// Sun and outdoor ambient.
    Sun,
    /// A shell: ambient, baked lamps and the viewer's.
    Shell { lamps: &'l [Lamp], viewer: Option<Lamp> },
    /// An object indoors: ambient, the nearest lamps and the viewer's.
    Indoor { lamps: &'l [Lamp], viewer: Option<Lamp> },
    /// Its own light only: things in the sky.
    Own(f32),
}

/// The light of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lighting {
    pub(crate) levels: LightLevels,
    /// Towards the sun in camera axes.
    pub(crate) sun: Vec3,
    pub(crate) detail: LightDetail,
}

impl Lighting {
    /// The light on a point with this normal, both in camera axes: the factor of the texture (`rendering.md` 12.5).
    #[inline]
    pub(crate) fn at(&self, material: &Material, light: MeshLight<'_>, place: Vec3, normal: Vec3) -> Vec3 {
        let own = Vec3::splat(material.luminosity);
        let indoors = matches!(light, MeshLight::Shell { .. } | MeshLight::Indoor { .. });
        let finish = |c: Vec3| {
            if indoors && self.detail == LightDetail::PerPixel {
                soft(c)
            } else {
                clamp01(c)
            }
        };
        let lit = |light: Vec3| finish(own + light * material.diffuse);
        match light {
            MeshLight::Sun => {
                let facing = normal.dot(self.sun);
                let sun = if facing > 0.0 {
                    self.levels.sun * facing
                } else {
                    Vec3::ZERO
                };
                lit(self.levels.outdoors + sun)
            }
            MeshLight::Shell { lamps, viewer } => {
                let mut dynamic = self.levels.indoors;
                if let Some(viewer) = viewer {
                    dynamic += viewer.on_object(place, normal);
                }
                finish(own + shell_light(lamps, place, normal) + dynamic * material.diffuse)
            }
            MeshLight::Indoor { lamps, viewer } => {
                let mut sum = self.levels.indoors;
                for lamp in lamps.iter().chain(&viewer) {
                    sum += lamp.on_object(place, normal);
                }
                if self.detail == LightDetail::PerPixel {
                    for lamp in lamps {
                        sum += lamp.thrown_back(place);
                    }
                }
                lit(sum)
            }
            MeshLight::Own(luminosity) => Vec3::splat(luminosity),
        }
    }
}

/// Light on a triangle.
pub(crate) enum Light {
    Flat(Vec3),
    /// From corner to corner, divided by the forward distance.
    Smooth([Affine; 3]),
    /// Of lamps, anew at each place.
    Lamps(Lamps),
}

/// Lamps of the frame's list that light a triangle.
pub(crate) struct Lamps {
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) viewer: Option<Lamp>,
    /// A shell's baked light, else an object's.
    pub(crate) shell: bool,
    pub(crate) normal: Normal,
}

/// The normal on a triangle, camera axes.
pub(crate) enum Normal {
    Flat(Vec3),
    Smooth([Affine; 3]),
}

/// How a triangle's pixels are coloured.
pub(crate) enum Surface {
    Mesh {
        material: Arc<Material>,
        map: TextureMap,
        light: Light,
    },
    Ground {
        land: Arc<LandMesh>,
        /// Land cells from the block's corner, divided by the forward distance.
        across: [Affine; 2],
        slope: Slope,
        light: [Affine; 3],
        /// The only land cell it lies in, if it does.
        only: Option<usize>,
    },
    Sky,
}

/// A triangle, or the sky, whose pixels wait for their colour.
pub(crate) struct Shade {
    pub(crate) inverse: Affine,
    pub(crate) surface: Surface,
}

/// What colouring needs to know of a frame.
pub(crate) struct Palette<'a> {
    pub(crate) shades: &'a [Shade],
    pub(crate) lamps: &'a [Lamp],
    pub(crate) lighting: &'a Lighting,
    pub(crate) fog: Option<Fog>,
    pub(crate) day: &'a Daylight,
    pub(crate) eye: &'a EyeFrame,
    pub(crate) screen: Projection,
    pub(crate) threads: usize,
    /// Of [`step_of`].
    pub(crate) step: u32,
}

/// Pixels of a step.
pub(crate) fn step_of(exact: bool) -> u32 {
    if exact { 1 } else { STEP }
}

impl Palette<'_> {
    /// Colours the pixels that wait for it and makes `owners` zero: 1 is the first of the shades.
    pub(crate) fn apply(&self, color: &mut [[u8; 4]], owners: &mut [u32]) {
        let width = self.screen.width as usize;
        let threads = threads_for(self.threads, color.len());
        if threads <= 1 {
            self.rows(0, color, owners);
            return;
        }
        let rows = (self.screen.height as usize).div_ceil(threads).max(1);
        let bands = color
            .chunks_mut(rows * width)
            .zip(owners.chunks_mut(rows * width));
        std::thread::scope(|scope| {
            for (k, (color, owners)) in bands.enumerate() {
                scope.spawn(move || self.rows((k * rows) as u32, color, owners));
            }
        });
    }

    fn rows(&self, first: u32, color: &mut [[u8; 4]], owners: &mut [u32]) {
        let width = self.screen.width as usize;
        let rows = color.chunks_mut(width).zip(owners.chunks_mut(width));
        for (y, (color, owners)) in (first..).zip(rows) {
            let mut x = 0;
            while let Some(&owner) = owners.get(x) {
                let same = owners[x..].iter().take_while(|&&o| o == owner).count();
                if let Some(shade) = (owner as usize).checked_sub(1).and_then(|k| self.shades.get(k)) {
                    self.run(shade, y, x as u32, &mut color[x..x + same]);
                }
                x += same;
            }
            owners.fill(0);
        }
    }

    /// Colours pixels of one row from column `x` on.
    fn run(&self, shade: &Shade, y: u32, x: u32, pixels: &mut [[u8; 4]]) {
        match &shade.surface {
            Surface::Sky => {
                for (x, pixel) in (x..).zip(pixels) {
                    let ray = self.eye.turn_back(self.screen.ray(x, y).normalize()).as_vec3();
                    let c = self.day.sky(ray) * 255.0;
                    let byte = |v: f32| v.clamp(0.0, 255.0) as u8;
                    *pixel = [byte(c.x), byte(c.y), byte(c.z), 255];
                }
            }
            Surface::Mesh { material, map, light } => {
                let fog = self.fog.filter(|_| material.fogged);
                let end = |x: u32| {
                    let far = 1.0 / shade.inverse.at(x, y);
                    let light = match light {
                        Light::Flat(c) => *c,
                        Light::Smooth(c) => Vec3::from_array([0, 1, 2].map(|k| (c[k].at(x, y) * far) as f32)),
                        Light::Lamps(lamps) => self.lamp_light(material, lamps, x, y, far),
                    };
                    self.end(map.uv, light, fog, x, y, far)
                };
                let texture = &material.texture;
                if let Some(c) = map.solid {
                    let c = c.map(|v| v as u8);
                    stepped(self.step, x, pixels, end, |_, _, _| move |_| c, fog);
                    return;
                }
                let look = |a: &End, b: &End, n: u32| {
                    let level = texture.level_for(map.slope.texels(a.uv, a.far, map.size));
                    let walk = TexelWalk::new(texture.level(level), a.uv, b.uv, n, map.wrap);
                    move |k| walk.at(k)
                };
                stepped(self.step, x, pixels, end, look, fog);
            }
            Surface::Ground {
                land,
                across,
                slope,
                light,
                only,
            } => {
                let end = |x: u32| {
                    let far = 1.0 / shade.inverse.at(x, y);
                    let light = Vec3::from_array([0, 1, 2].map(|k| (light[k].at(x, y) * far) as f32));
                    self.end(*across, light, self.fog, x, y, far)
                };
                if let Some((k, paint)) = only.and_then(|k| Some((k, land.paint.get(k)?))) {
                    let (cx, cy) = ((k / 8) as f32, (k % 8) as f32);
                    let look = |a: &End, b: &End, n: u32| {
                        let uv = |p: [f32; 2]| [p[0] - cx, 1.0 - (p[1] - cy)];
                        let texels = slope.texels(a.uv, a.far, 1.0);
                        let walk = paint.walk(&Way {
                            from: uv(a.uv),
                            to: uv(b.uv),
                            steps: n,
                            texels,
                        });
                        move |k| walk.at(k)
                    };
                    stepped(self.step, x, pixels, end, look, self.fog);
                    return;
                }
                // A triangle of distant ground reaches over several land cells.
                let look = |a: &End, b: &End, n: u32| {
                    let texels = slope.texels(a.uv, a.far, 1.0);
                    let (from, share) = (a.uv, 1.0 / n as f32);
                    let by = [(b.uv[0] - a.uv[0]) * share, (b.uv[1] - a.uv[1]) * share];
                    move |k: u32| {
                        let place = [from[0] + by[0] * k as f32, from[1] + by[1] * k as f32];
                        let index = |v: f32| (v as i32).clamp(0, 7);
                        let (cx, cy) = match only {
                            Some(k) => ((k / 8) as i32, (k % 8) as i32),
                            None => (index(place[0]), index(place[1])),
                        };
                        let (u, v) = (place[0] - cx as f32, 1.0 - (place[1] - cy as f32));
                        let paint = land.paint.get((cx * 8 + cy) as usize);
                        paint.map_or([0; 4], |p| p.fetch(u, v, texels))
                    }
                };
                stepped(self.step, x, pixels, end, look, self.fog);
            }
        }
    }

    fn lamp_light(&self, material: &Material, lamps: &Lamps, x: u32, y: u32, far: f64) -> Vec3 {
        let place = (self.screen.ray(x, y) * far).as_vec3();
        let normal = match &lamps.normal {
            Normal::Flat(n) => *n,
            Normal::Smooth(n) => {
                Vec3::from_array([0, 1, 2].map(|k| (n[k].at(x, y) * far) as f32)).normalize_or_zero()
            }
        };
        let first = lamps.first as usize;
        let own = self.lamps.get(first..first + lamps.count as usize).unwrap_or(&[]);
        let viewer = lamps.viewer;
        let light = if lamps.shell {
            MeshLight::Shell { lamps: own, viewer }
        } else {
            MeshLight::Indoor { lamps: own, viewer }
        };
        self.lighting.at(material, light, place, normal)
    }

    #[inline]
    fn end(&self, uv: [Affine; 2], light: Vec3, fog: Option<Fog>, x: u32, y: u32, far: f64) -> End {
        let clear = fog.map_or(1.0, |fog| {
            fog.clear((far * self.screen.ray(x, y).length()) as f32)
        });
        End {
            uv: uv.map(|a| (a.at(x, y) * far) as f32),
            light,
            clear,
            far: far as f32,
        }
    }
}

/// What is computed at both ends of a step.
#[derive(Clone, Copy)]
struct End {
    uv: [f32; 2],
    light: Vec3,
    /// What fog leaves, 0…1.
    clear: f32,
    far: f32,
}

/// Colours a run of pixels step by step; `look` makes, for a step of so many pixels, what gives the texture's colour
/// at each.
#[inline]
fn stepped<T: Fn(u32) -> [u8; 4]>(
    step: u32,
    x: u32,
    pixels: &mut [[u8; 4]],
    end: impl Fn(u32) -> End,
    look: impl Fn(&End, &End, u32) -> T,
    fog: Option<Fog>,
) {
    let fog = fog.map_or(Vec3::ZERO, |f| f.color * 255.0);
    let Some(last) = (pixels.len() as u32).checked_sub(1) else {
        return;
    };
    // Colour = texture * light + haze, both in 256ths.
    let parts = |e: &End| {
        let light = e.light * (e.clear * 256.0);
        let haze = fog * ((1.0 - e.clear) * 256.0) + 128.0;
        [light.x, light.y, light.z, haze.x, haze.y, haze.z].map(|v| v as i32)
    };
    let (mut a, mut at) = (end(x), 0);
    let mut from = parts(&a);
    loop {
        let next = (at + step).min(last);
        let n = (next - at).max(1);
        let b = if next > at { end(x + next) } else { a };
        let to = parts(&b);
        let texel = look(&a, &b, n);
        let by: [i32; 6] = core::array::from_fn(|k| to[k].wrapping_sub(from[k]) / n as i32);
        let mut now = from;
        // The last step has its end, too.
        let until = if next == last { next + 1 } else { next };
        for (k, pixel) in (0..until - at).zip(&mut pixels[at as usize..until as usize]) {
            let c = texel(k);
            let channel = |i: usize| {
                let v = (i32::from(c[i]) * now[i] + now[i + 3]) >> 8;
                if v < 255 { v as u8 } else { 255 }
            };
            *pixel = [channel(0), channel(1), channel(2), 255];
            for (now, by) in now.iter_mut().zip(by) {
                *now += by;
            }
        }
        if next == last {
            return;
        }
        (a, at, from) = (b, next, to);
    }
}

fn threads_for(wanted: usize, pixels: usize) -> usize {
    if pixels < MANY_PIXELS || cfg!(target_family = "wasm") {
        return 1;
    }
    let there = || std::thread::available_parallelism().map_or(1, |n| n.get().min(16));
    if wanted == 0 { there() } else { wanted.min(64) }
}

/// Fog over one pixel's colour.
#[inline]
pub(crate) fn fogged(
    c: [f32; 3],
    fog: Option<Fog>,
    screen: &Projection,
    x: u32,
    y: u32,
    far: f64,
) -> [f32; 3] {
    let Some(fog) = fog else { return c };
    let distance = far * screen.ray(x, y).length();
    let clear = fog.clear(distance as f32);
    if clear >= 1.0 {
        return c;
    }
    let f = fog.color * 255.0;
    [
        f.x + (c[0] - f.x) * clear,
        f.y + (c[1] - f.y) * clear,
        f.z + (c[2] - f.z) * clear,
    ]
}

/// How fast coordinates change from pixel to pixel.
#[derive(Clone, Copy)]
pub(crate) struct Slope {
    per_x: [f32; 2],
    per_y: [f32; 2],
    inverse: [f32; 2],
}

impl Slope {
    pub(crate) fn new(setup: &Setup, uv: [Affine; 2]) -> Self {
        Slope {
            per_x: uv.map(|a| a.a as f32),
            per_y: uv.map(|a| a.b as f32),
            inverse: [setup.inverse.a as f32, setup.inverse.b as f32],
        }
    }

    /// The square of how many texels a pixel covers at these coordinates, for a texture of `size` texels a side:
    /// between what it is across and what it is down, sharper than the larger, calmer than the smaller.
    #[inline]
    pub(crate) fn texels(&self, uv: [f32; 2], far: f32, size: f32) -> f32 {
        let change = |per: [f32; 2], inverse: f32| {
            let du = (per[0] - uv[0] * inverse) * far * size;
            let dv = (per[1] - uv[1] * inverse) * far * size;
            du * du + dv * dv
        };
        let a = change(self.per_x, self.inverse[0]);
        let b = change(self.per_y, self.inverse[1]);
        let (between, larger) = (libm::sqrtf(a * b), if a > b { a } else { b });
        let least = larger * (0.35 * 0.35);
        if between > least { between } else { least }
    }
}

/// A texture on a triangle.
pub(crate) struct TextureMap {
    pub(crate) uv: [Affine; 2],
    pub(crate) slope: Slope,
    /// Texels of the texture's longer side.
    pub(crate) size: f32,
    pub(crate) wrap: bool,
    /// The only colour of the texture.
    pub(crate) solid: Option<[f32; 4]>,
}

impl TextureMap {
    pub(crate) fn new(setup: &Setup, uv: [[f32; 2]; 3], texture: &Texture, wrap: bool) -> Self {
        let map = [0, 1].map(|k| setup.attribute(uv.map(|c| c[k])));
        let (w, h) = (texture.width(), texture.height());
        TextureMap {
            uv: map,
            slope: Slope::new(setup, map),
            size: if w > h { w } else { h } as f32,
            wrap,
            solid: (w == 1 && h == 1).then(|| texture.sample(0.0, 0.0, 0.0, false)),
        }
    }

    /// The colour at one pixel, each channel 0…255.
    #[inline]
    pub(crate) fn at(&self, texture: &Texture, x: u32, y: u32, far: f64) -> [f32; 4] {
        if let Some(c) = self.solid {
            return c;
        }
        let uv = self.uv.map(|a| (a.at(x, y) * far) as f32);
        let level = texture.level_for(self.slope.texels(uv, far as f32, self.size));
        texture.fetch(level, uv[0], uv[1], self.wrap).map(f32::from)
    }
}
