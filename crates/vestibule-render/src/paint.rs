//! The painter: draws meshes and ground into the buffers, lit and fogged, or as ids.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use vestibule_view::Camera;

use crate::land::LandMesh;
use crate::lighting::{Lamp, LightLevels, clamp01, shell_light, soft};
use crate::material::{Blend, DrawList, Material};
use crate::mesh::Mesh;
use crate::place::{EyeFrame, Placed};
use crate::raster::scan::{Affine, Facing, Setup};
use crate::raster::{Buffers, PixelId, PixelKind, PixelWrite};
use crate::scene::{LightDetail, RenderCounters, RenderSettings};
use crate::sky::{Daylight, Fog};

/// What pixels are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    Color,
    Ids,
}

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

/// Who a mesh belongs to, for its ids.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Owner {
    pub(crate) kind: PixelKind,
    pub(crate) cell: u32,
    /// The item of every face; `None` takes the polygon's key.
    pub(crate) item: Option<u32>,
}

/// A see-through triangle put aside (`rendering.md` 14.7).
struct Deferred {
    points: [DVec3; 3],
    uv: [[f32; 2]; 3],
    light: [Vec3; 3],
    material: Arc<Material>,
    opacity: f32,
    wrap: bool,
    fogged: bool,
    /// Of the part's sphere, for sorting.
    distance: f64,
    id: PixelId,
    confine: Vec<Affine>,
}

pub(crate) struct Painter {
    pub(crate) mode: Mode,
    pub(crate) settings: RenderSettings,
    pub(crate) eye: EyeFrame,
    pub(crate) buffers: Buffers,
    pub(crate) levels: LightLevels,
    pub(crate) day: Daylight,
    pub(crate) fog: Option<Fog>,
    pub(crate) counters: RenderCounters,
    /// How much opaque triangles of meshes grow, pixels: [`GROWTH`](crate::raster::scan::GROWTH) for the viewer's own
    /// rooms, else nothing.
    pub(crate) growth: f64,
    /// The viewer's cell does not see the outside.
    pub(crate) sealed: bool,
    /// Sun and up in camera axes.
    sun: Vec3,
    slopes: (f64, f64),
    deferred: Vec<Deferred>,
    points: Vec<DVec3>,
    normals: Vec<Vec3>,
}

impl Painter {
    pub(crate) fn new(
        mode: Mode,
        settings: RenderSettings,
        camera: &Camera,
        buffers: Buffers,
        day: Daylight,
        sealed: bool,
    ) -> Self {
        let eye = EyeFrame::new(camera);
        let levels = LightLevels::new(&day, sealed);
        Painter {
            mode,
            settings,
            buffers,
            levels,
            day,
            fog: day.fog.filter(|_| settings.fog && !sealed),
            counters: RenderCounters::default(),
            growth: 0.0,
            sealed,
            sun: eye.turn(levels.sun_direction.as_dvec3()).as_vec3(),
            slopes: (f64::from(camera.slopes().x), f64::from(camera.slopes().y)),
            eye,
            deferred: Vec::new(),
            points: Vec::new(),
            normals: Vec::new(),
        }
    }

    /// A lamp of a landblock's frame, in camera axes.
    pub(crate) fn lamp_seen(&self, placed: &Placed, lamp: &Lamp) -> Lamp {
        Lamp {
            position: placed.point(lamp.position).as_vec3(),
            ..*lamp
        }
    }

    /// Whether any of a sphere in camera axes can be on the screen.
    fn on_screen(&self, center: DVec3, radius: f64) -> bool {
        let (sx, sy) = self.slopes;
        let (lx, ly) = ((1.0 + sx * sx).sqrt(), (1.0 + sy * sy).sqrt());
        center.y >= -radius
            && sx * center.y - center.x.abs() >= -radius * lx
            && sy * center.y - center.z.abs() >= -radius * ly
    }

    /// Draws a placed mesh. `opacity` below 1 fades all of it.
    pub(crate) fn mesh(
        &mut self,
        mesh: &Mesh,
        placed: &Placed,
        owner: Owner,
        light: MeshLight<'_>,
        opacity: f32,
        confine: &[Affine],
    ) {
        let middle = placed.point(mesh.sphere.center);
        let reach = (placed.point(mesh.sphere.center + Vec3::X) - middle)
            .length()
            .max((placed.point(mesh.sphere.center + Vec3::Y) - middle).length())
            .max((placed.point(mesh.sphere.center + Vec3::Z) - middle).length());
        if !self.on_screen(middle, f64::from(mesh.sphere.radius) * reach + 0.01) {
            return;
        }
        let mut points = core::mem::take(&mut self.points);
        let mut normals = core::mem::take(&mut self.normals);
        points.clear();
        points.extend(mesh.vertices.iter().map(|v| placed.point(v.position)));
        normals.clear();
        if self.mode == Mode::Color {
            let origin = placed.point(Vec3::ZERO);
            normals.extend(
                mesh.vertices
                    .iter()
                    .map(|v| (placed.point(v.normal) - origin).normalize_or_zero().as_vec3()),
            );
        }
        let mirrors = placed.mirrors();
        for face in &mesh.faces {
            let Some(material) = mesh.materials.get(face.material as usize) else {
                continue;
            };
            let first = face.first as usize;
            for k in 1..face.count as usize - 1 {
                let mut corners = [first, first + k, first + k + 1];
                if mirrors {
                    corners.swap(1, 2);
                }
                let Some(p) = pick(&points, corners) else { continue };
                self.counters.triangles += 1;
                let id = PixelId::new(
                    owner.kind,
                    owner.cell,
                    owner.item.unwrap_or(u32::from(face.polygon)),
                );
                let at_once = material.list == DrawList::Now && opacity >= 1.0;
                if at_once && self.mode == Mode::Ids {
                    self.buffers
                        .id_triangle(p, id, confine, Facing::Front, self.growth);
                    continue;
                }
                let uv = corners.map(|i| mesh.vertices.get(i).map_or([0.0; 2], |v| [v.uv.x, v.uv.y]));
                let n = pick(&normals, corners).unwrap_or([Vec3::Z; 3]);
                if at_once {
                    self.opaque(p, n, uv, material, face.wrap, light, confine);
                } else {
                    self.counters.deferred += 1;
                    let light =
                        core::array::from_fn(|k| self.light_at(material, light, p[k].as_vec3(), n[k]));
                    self.deferred.push(Deferred {
                        points: p,
                        uv,
                        light,
                        material: material.clone(),
                        opacity,
                        wrap: face.wrap,
                        fogged: material.fogged,
                        distance: middle.length(),
                        id,
                        confine: confine.to_vec(),
                    });
                }
            }
        }
        (self.points, self.normals) = (points, normals);
    }

    /// The light on a point with this normal, both in camera axes: the factor of the texture (`rendering.md` 12.5).
    #[inline]
    fn light_at(&self, material: &Material, light: MeshLight<'_>, place: Vec3, normal: Vec3) -> Vec3 {
        let own = Vec3::splat(material.luminosity);
        let indoors = matches!(light, MeshLight::Shell { .. } | MeshLight::Indoor { .. });
        let finish = |c: Vec3| {
            if indoors && self.settings.light == LightDetail::PerPixel {
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
                lit(sum)
            }
            MeshLight::Own(luminosity) => Vec3::splat(luminosity),
        }
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "one triangle, split from mesh for reading"
    )]
    fn opaque(
        &mut self,
        p: [DVec3; 3],
        n: [Vec3; 3],
        uv: [[f32; 2]; 3],
        material: &Material,
        wrap: bool,
        light: MeshLight<'_>,
        confine: &[Affine],
    ) {
        let Some(setup) = Setup::new(&self.buffers.screen, p, Facing::Front, self.growth) else {
            return;
        };
        let texture = TextureMap::new(&setup, uv, material, wrap);
        let fog = self.fog.filter(|_| material.fogged);
        let screen = self.buffers.screen;
        let finish = |c: [f32; 4], light: Vec3, x: u32, y: u32, far: f64| {
            let c = [c[0] * light.x, c[1] * light.y, c[2] * light.z];
            Some((fogged(c, fog, &screen, x, y, far), 1.0))
        };
        let how = PixelWrite {
            test: true,
            write: true,
            blend: Blend::OPAQUE,
        };
        let lamps = matches!(light, MeshLight::Shell { .. } | MeshLight::Indoor { .. });
        let mut buffers = core::mem::replace(&mut self.buffers, Buffers::empty(screen));
        if lamps && self.settings.light == LightDetail::PerPixel {
            let flat = n[0] == n[1] && n[1] == n[2];
            let smooth = [0, 1, 2].map(|k| setup.attribute(n.map(|n| n[k])));
            buffers.shaded(&setup, how, confine, |x, y, far| {
                let place = (screen.ray(x, y) * far).as_vec3();
                let normal = if flat {
                    n[0]
                } else {
                    Vec3::from_array(smooth.map(|a| (a.at(x, y) * far) as f32)).normalize_or_zero()
                };
                let light = self.light_at(material, light, place, normal);
                finish(texture.at(material, x, y, far), light, x, y, far)
            });
        } else {
            let corner: [Vec3; 3] =
                core::array::from_fn(|k| self.light_at(material, light, p[k].as_vec3(), n[k]));
            if corner[0] == corner[1] && corner[1] == corner[2] {
                buffers.shaded(&setup, how, confine, |x, y, far| {
                    finish(texture.at(material, x, y, far), corner[0], x, y, far)
                });
            } else {
                let smooth = [0, 1, 2].map(|k| setup.attribute(corner.map(|c| c[k])));
                buffers.shaded(&setup, how, confine, |x, y, far| {
                    let light = Vec3::from_array(smooth.map(|a| (a.at(x, y) * far) as f32));
                    finish(texture.at(material, x, y, far), light, x, y, far)
                });
            }
        }
        self.buffers = buffers;
    }

    /// Draws what was put aside: cut-outs in order, then what is blended far to near (`rendering.md` 14.7).
    pub(crate) fn flush(&mut self) {
        let mut list = core::mem::take(&mut self.deferred);
        let cut_out = |d: &Deferred| d.material.list == DrawList::CutOut && d.opacity >= 1.0;
        // Stable: cut-outs first, in order; the rest by distance, ties in order.
        list.sort_by(|a, b| match (cut_out(a), cut_out(b)) {
            (true, true) => core::cmp::Ordering::Equal,
            (true, false) => core::cmp::Ordering::Less,
            (false, true) => core::cmp::Ordering::Greater,
            (false, false) => b.distance.total_cmp(&a.distance),
        });
        for d in &list {
            if self.mode == Mode::Ids {
                // Cut-outs count as solid, what is blended writes nothing (`rendering.md` 10.1).
                if cut_out(d) {
                    self.buffers
                        .id_triangle(d.points, d.id, &d.confine, Facing::Front, 0.0);
                }
                continue;
            }
            let material = &d.material;
            let Some(setup) = Setup::new(&self.buffers.screen, d.points, Facing::Front, 0.0) else {
                continue;
            };
            let texture = TextureMap::new(&setup, d.uv, material, d.wrap);
            let smooth = [0, 1, 2].map(|k| setup.attribute(d.light.map(|c| c[k])));
            let fog = self.fog.filter(|_| d.fogged);
            let screen = self.buffers.screen;
            let faded = d.opacity < 1.0;
            let how = PixelWrite {
                test: true,
                write: material.writes_depth() && !faded,
                blend: if faded && material.list == DrawList::Now {
                    Blend::ALPHA
                } else {
                    material.blend
                },
            };
            let opacity = material.opacity * d.opacity;
            self.buffers.shaded(&setup, how, &d.confine, |x, y, far| {
                let c = texture.at(material, x, y, far);
                if material.alpha_test.is_some_and(|limit| c[3] < f32::from(limit)) {
                    return None;
                }
                let alpha = if material.list == DrawList::Now {
                    1.0
                } else {
                    c[3] / 255.0
                };
                let light = Vec3::from_array(smooth.map(|a| (a.at(x, y) * far) as f32));
                let lit = [c[0] * light.x, c[1] * light.y, c[2] * light.z];
                Some((fogged(lit, fog, &screen, x, y, far), alpha * opacity))
            });
        }
        list.clear();
        self.deferred = list;
    }

    /// Draws triangles of a landblock's ground: corners in its frame with their normals. `cell` gives the id; a
    /// `cell` below 64 also says whose paint is used, otherwise each pixel takes that of the land cell it is over.
    pub(crate) fn ground(
        &mut self,
        land: &LandMesh,
        placed: &Placed,
        corners: [Vec3; 3],
        normals: [Vec3; 3],
        cell: u32,
        only: Option<usize>,
    ) {
        let lowered = corners.map(|p| p - Vec3::Z * self.settings.terrain_offset);
        let p = lowered.map(|v| placed.point(v));
        self.counters.triangles += 1;
        let facing = if self.settings.cull_terrain {
            Facing::Front
        } else {
            Facing::Both
        };
        if self.mode == Mode::Ids {
            let id = PixelId::new(PixelKind::Terrain, cell, 0);
            self.buffers.id_triangle(p, id, &[], facing, 0.0);
            return;
        }
        let Some(setup) = Setup::new(&self.buffers.screen, p, facing, 0.0) else {
            return;
        };
        const SIDE: f32 = vestibule_world::constants::SQUARE_LENGTH;
        let light = normals.map(|n| self.levels.on_terrain(n));
        let smooth = [0, 1, 2].map(|k| setup.attribute(light.map(|c| c[k])));
        let across = [
            setup.attribute(corners.map(|v| v.x / SIDE)),
            setup.attribute(corners.map(|v| v.y / SIDE)),
        ];
        let slope = Slope::new(&setup, across);
        let (fog, screen) = (self.fog, self.buffers.screen);
        let how = PixelWrite {
            test: true,
            write: true,
            blend: Blend::OPAQUE,
        };
        self.buffers.shaded(&setup, how, &[], |x, y, far| {
            let place = across.map(|a| (a.at(x, y) * far) as f32);
            let index = |v: f32| (v as i32).clamp(0, 7);
            let (cx, cy) = match only {
                Some(k) => ((k / 8) as i32, (k % 8) as i32),
                None => (index(place[0]), index(place[1])),
            };
            let paint = land.paint.get((cx * 8 + cy) as usize)?;
            let (u, v) = (place[0] - cx as f32, 1.0 - (place[1] - cy as f32));
            let c = paint.sample(u, v, slope.at(place, far));
            let l = smooth.map(|a| (a.at(x, y) * far) as f32);
            let c = [c[0] * l[0], c[1] * l[1], c[2] * l[2]];
            Some((fogged(c, fog, &screen, x, y, far), 1.0))
        });
    }

    /// Fills columns and rows (from, to) with the sky (`rendering.md` 16.4: no depth).
    pub(crate) fn sky(&mut self, [x0, x1, y0, y1]: [u32; 4]) {
        let screen = self.buffers.screen;
        for y in y0..y1.min(screen.height) {
            let start = y as usize * screen.width as usize;
            for x in x0..x1.min(screen.width) {
                let at = start + x as usize;
                if self.mode == Mode::Ids {
                    if let Some(id) = self.buffers.ids.get_mut(at) {
                        *id = PixelId::SKY;
                    }
                    continue;
                }
                let ray = self.eye.turn_back(screen.ray(x, y).normalize()).as_vec3();
                let c = self.day.sky(ray) * 255.0;
                if let Some(pixel) = self.buffers.color.get_mut(at) {
                    let byte = |v: f32| v.clamp(0.0, 255.0) as u8;
                    *pixel = [byte(c.x), byte(c.y), byte(c.z), 255];
                }
            }
        }
    }

    /// Draws a thing of the sky: over everything, no depth, no fog.
    pub(crate) fn sky_mesh(&mut self, mesh: &Mesh, placed: &Placed, luminosity: f32, opacity: f32) {
        if self.mode == Mode::Ids {
            return;
        }
        for face in &mesh.faces {
            let Some(material) = mesh.materials.get(face.material as usize) else {
                continue;
            };
            let corners = mesh.corners(face);
            for k in 1..corners.len().saturating_sub(1) {
                let tri = [&corners[0], &corners[k], &corners[k + 1]];
                let p = tri.map(|v| placed.point(v.position));
                let Some(setup) = Setup::new(&self.buffers.screen, p, Facing::Front, 0.0) else {
                    continue;
                };
                let uv = tri.map(|v| [v.uv.x, v.uv.y]);
                let texture = TextureMap::new(&setup, uv, material, face.wrap);
                let own = MeshLight::Own(luminosity);
                let light = self.light_at(material, own, Vec3::ZERO, Vec3::Z);
                let how = PixelWrite {
                    test: false,
                    write: false,
                    blend: material.blend,
                };
                let alpha = material.opacity * opacity;
                self.buffers.shaded(&setup, how, &[], |x, y, far| {
                    let c = texture.at(material, x, y, far);
                    if material.alpha_test.is_some_and(|limit| c[3] < f32::from(limit)) {
                        return None;
                    }
                    let c3 = [c[0] * light.x, c[1] * light.y, c[2] * light.z];
                    Some((c3, c[3] / 255.0 * alpha))
                });
            }
        }
    }
}

fn pick<T: Copy>(all: &[T], at: [usize; 3]) -> Option<[T; 3]> {
    Some([*all.get(at[0])?, *all.get(at[1])?, *all.get(at[2])?])
}

#[inline]
fn fogged(
    c: [f32; 3],
    fog: Option<Fog>,
    screen: &crate::raster::scan::Projection,
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
struct Slope {
    per_x: [f32; 2],
    per_y: [f32; 2],
    inverse: [f32; 2],
}

impl Slope {
    fn new(setup: &Setup, uv: [Affine; 2]) -> Self {
        Slope {
            per_x: uv.map(|a| a.a as f32),
            per_y: uv.map(|a| a.b as f32),
            inverse: [setup.inverse.a as f32, setup.inverse.b as f32],
        }
    }

    /// The larger change of (u, v), from one pixel to the next across or down, at a pixel with these coordinates.
    #[inline]
    fn at(&self, uv: [f32; 2], far: f64) -> f32 {
        let far = far as f32;
        let change = |per: [f32; 2], inverse: f32| {
            let du = (per[0] - uv[0] * inverse) * far;
            let dv = (per[1] - uv[1] * inverse) * far;
            du * du + dv * dv
        };
        let (a, b) = (
            change(self.per_x, self.inverse[0]),
            change(self.per_y, self.inverse[1]),
        );
        // Between the two: sharper than the larger, calmer than the smaller.
        libm::sqrtf(libm::sqrtf(a * b)).max(libm::sqrtf(if a > b { a } else { b }) * 0.35)
    }
}

/// A texture on a triangle.
struct TextureMap {
    uv: [Affine; 2],
    slope: Slope,
    size: f32,
    wrap: bool,
    solid: Option<[f32; 4]>,
}

impl TextureMap {
    fn new(setup: &Setup, uv: [[f32; 2]; 3], material: &Material, wrap: bool) -> Self {
        let map = [0, 1].map(|k| setup.attribute(uv.map(|c| c[k])));
        let (w, h) = (material.texture.width(), material.texture.height());
        TextureMap {
            uv: map,
            slope: Slope::new(setup, map),
            size: if w > h { w } else { h } as f32,
            wrap,
            solid: (w == 1 && h == 1).then(|| material.texture.sample(0.0, 0.0, 0.0, false)),
        }
    }

    #[inline]
    fn at(&self, material: &Material, x: u32, y: u32, far: f64) -> [f32; 4] {
        if let Some(c) = self.solid {
            return c;
        }
        let uv = self.uv.map(|a| (a.at(x, y) * far) as f32);
        let texels = self.slope.at(uv, far) * self.size;
        let lod = if texels > 1.0 { libm::log2f(texels) } else { 0.0 };
        material.texture.sample(uv[0], uv[1], lod, self.wrap)
    }
}
