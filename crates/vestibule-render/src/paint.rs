//! The painter: draws meshes and ground into the buffers, lit and fogged, or as ids.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use vestibule_view::Camera;

use crate::land::LandMesh;
use crate::lighting::{Lamp, LightLevels};
use crate::material::{Blend, DrawList, Material};
use crate::mesh::Mesh;
use crate::place::{EyeFrame, Placed};
use crate::raster::scan::{Affine, Facing, Setup};
use crate::raster::{Buffers, PixelId, PixelKind, PixelWrite};
use crate::scene::{LightDetail, RenderCounters, RenderSettings};
use crate::shade::{
    Lamps, Light, Lighting, MeshLight, Normal, Palette, Shade, Slope, Surface, TextureMap, fogged, step_of,
};
use crate::sky::{Daylight, Fog};
use crate::walk::Owner;

/// What pixels are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    Color,
    Ids,
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
    pub(crate) lighting: Lighting,
    pub(crate) day: Daylight,
    pub(crate) fog: Option<Fog>,
    pub(crate) counters: RenderCounters,
    /// How much opaque triangles of meshes grow, pixels: [`GROWTH`](crate::raster::scan::GROWTH) for the viewer's own
    /// rooms, else nothing.
    pub(crate) growth: f64,
    slopes: (f64, f64),
    deferred: Vec<Deferred>,
    /// Opaque triangles whose pixels wait for their colour, and the lamps they name.
    shades: Vec<Shade>,
    lamp_pool: Vec<Lamp>,
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
        let levels = LightLevels::new(&day, sealed, settings.light);
        Painter {
            mode,
            settings,
            buffers,
            lighting: Lighting {
                levels,
                sun: eye.turn(levels.sun_direction.as_dvec3()).as_vec3(),
                detail: settings.light,
            },
            day,
            fog: day.fog.filter(|_| settings.fog && !sealed),
            counters: RenderCounters::default(),
            growth: 0.0,
            slopes: (f64::from(camera.slopes().x), f64::from(camera.slopes().y)),
            eye,
            deferred: Vec::new(),
            shades: Vec::new(),
            lamp_pool: Vec::new(),
            points: Vec::new(),
            normals: Vec::new(),
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
        if !self.on_screen(middle, f64::from(mesh.sphere.radius) * placed.reach() + 0.01) {
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
        let pooled = match light {
            MeshLight::Shell { lamps, .. } | MeshLight::Indoor { lamps, .. }
                if self.mode == Mode::Color && self.settings.light == LightDetail::PerPixel =>
            {
                let first = self.lamp_pool.len() as u32;
                self.lamp_pool.extend_from_slice(lamps);
                Some((first, lamps.len() as u32))
            }
            _ => None,
        };
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
                    owner.cell.0,
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
                    self.opaque(p, n, uv, material, face.wrap, light, pooled, confine);
                } else {
                    self.counters.deferred += 1;
                    let light =
                        core::array::from_fn(|k| self.lighting.at(material, light, p[k].as_vec3(), n[k]));
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

    #[expect(
        clippy::too_many_arguments,
        reason = "one triangle, split from mesh for reading"
    )]
    fn opaque(
        &mut self,
        p: [DVec3; 3],
        n: [Vec3; 3],
        uv: [[f32; 2]; 3],
        material: &Arc<Material>,
        wrap: bool,
        light: MeshLight<'_>,
        pooled: Option<(u32, u32)>,
        confine: &[Affine],
    ) {
        let Some(setup) = Setup::new(&self.buffers.screen, p, Facing::Front, self.growth) else {
            return;
        };
        if !self.buffers.own(&setup, self.shades.len() as u32 + 1, confine) {
            return;
        }
        let (lamps, shell) = match light {
            MeshLight::Shell { viewer, .. } => (pooled.zip(Some(viewer)), true),
            MeshLight::Indoor { viewer, .. } => (pooled.zip(Some(viewer)), false),
            MeshLight::Sun | MeshLight::Own(_) => (None, false),
        };
        let smooth = |v: [Vec3; 3]| [0, 1, 2].map(|k| setup.attribute(v.map(|v| v[k])));
        let even = |v: [Vec3; 3]| v[0] == v[1] && v[1] == v[2];
        let light = match lamps {
            Some(((first, count), viewer)) => Light::Lamps(Lamps {
                first,
                count,
                viewer,
                shell,
                normal: if even(n) {
                    Normal::Flat(n[0])
                } else {
                    Normal::Smooth(smooth(n))
                },
            }),
            None => {
                let corner: [Vec3; 3] =
                    core::array::from_fn(|k| self.lighting.at(material, light, p[k].as_vec3(), n[k]));
                if even(corner) {
                    Light::Flat(corner[0])
                } else {
                    Light::Smooth(smooth(corner))
                }
            }
        };
        let map = TextureMap::new(&setup, uv, &material.texture, wrap);
        self.shades.push(Shade {
            inverse: setup.inverse,
            surface: Surface::Mesh {
                material: material.clone(),
                map,
                light,
            },
        });
    }

    /// Colours the pixels that wait for it.
    pub(crate) fn resolve(&mut self) {
        if self.shades.is_empty() {
            return;
        }
        let palette = Palette {
            shades: &self.shades,
            lamps: &self.lamp_pool,
            lighting: &self.lighting,
            fog: self.fog,
            day: &self.day,
            eye: &self.eye,
            screen: self.buffers.screen,
            threads: self.settings.threads,
            step: step_of(self.settings.exact),
        };
        palette.apply(&mut self.buffers.color, &mut self.buffers.owners);
        self.shades.clear();
        self.lamp_pool.clear();
    }

    /// Draws what was put aside: cut-outs in order, then what is blended far to near (`rendering.md` 14.7).
    pub(crate) fn flush(&mut self) {
        let mut list = core::mem::take(&mut self.deferred);
        if !list.is_empty() {
            self.resolve();
        }
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
            let texture = TextureMap::new(&setup, d.uv, &material.texture, d.wrap);
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
                let c = texture.at(&material.texture, x, y, far);
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
        land: &Arc<LandMesh>,
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
        if !self.buffers.own(&setup, self.shades.len() as u32 + 1, &[]) {
            return;
        }
        const SIDE: f32 = vestibule_world::constants::SQUARE_LENGTH;
        let light = normals.map(|n| self.lighting.levels.on_terrain(n));
        let smooth = [0, 1, 2].map(|k| setup.attribute(light.map(|c| c[k])));
        let across = [
            setup.attribute(corners.map(|v| v.x / SIDE)),
            setup.attribute(corners.map(|v| v.y / SIDE)),
        ];
        let slope = Slope::new(&setup, across);
        self.shades.push(Shade {
            inverse: setup.inverse,
            surface: Surface::Ground {
                land: land.clone(),
                across,
                slope,
                light: smooth,
                only,
            },
        });
    }

    /// Fills columns and rows (from, to) with the sky (`rendering.md` 16.4: no depth).
    pub(crate) fn sky(&mut self, [x0, x1, y0, y1]: [u32; 4]) {
        let screen = self.buffers.screen;
        if self.mode == Mode::Color {
            self.shades.push(Shade {
                inverse: Affine::default(),
                surface: Surface::Sky,
            });
        }
        let owner = self.shades.len() as u32;
        let (x0, x1) = (x0 as usize, x1.min(screen.width) as usize);
        for y in y0..y1.min(screen.height) {
            let start = y as usize * screen.width as usize;
            let row = start + x0.min(x1)..start + x1;
            if let Some(ids) = self.buffers.ids.get_mut(row.clone()) {
                ids.fill(PixelId::SKY);
            }
            if let Some(owners) = self.buffers.owners.get_mut(row) {
                owners.fill(owner);
            }
        }
    }

    /// Draws a thing of the sky: over everything, no depth, no fog.
    pub(crate) fn sky_mesh(&mut self, mesh: &Mesh, placed: &Placed, luminosity: f32, opacity: f32) {
        if self.mode == Mode::Ids {
            return;
        }
        self.resolve();
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
                let texture = TextureMap::new(&setup, uv, &material.texture, face.wrap);
                let own = MeshLight::Own(luminosity);
                let light = self.lighting.at(material, own, Vec3::ZERO, Vec3::Z);
                let how = PixelWrite {
                    test: false,
                    write: false,
                    blend: material.blend,
                };
                let alpha = material.opacity * opacity;
                self.buffers.shaded(&setup, how, &[], |x, y, far| {
                    let c = texture.at(&material.texture, x, y, far);
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
