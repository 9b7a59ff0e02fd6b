//! Panels without a GPU: draws egui's triangles into pixels.

use std::collections::HashMap;

use egui::epaint::{ClippedPrimitive, Primitive, Vertex};
use egui::{Color32, ImageData, TextureId, TexturesDelta};

/// Textures of the panels.
#[derive(Debug, Default)]
pub(crate) struct SoftPainter {
    textures: HashMap<TextureId, ([usize; 2], Vec<Color32>)>,
}

/// Pixels, 0x00RRGGBB, row by row from the top.
pub(crate) struct Pixels<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) data: &'a mut [u32],
}

impl SoftPainter {
    /// Takes over what changed about textures.
    pub(crate) fn update(&mut self, delta: &TexturesDelta) {
        for (id, change) in delta
            .set
            .iter()
            .flat_map(|(id, all)| all.iter().map(move |c| (id, c)))
        {
            let ImageData::Color(image) = &change.image;
            match change.pos {
                None => {
                    self.textures.insert(*id, (image.size, image.pixels.clone()));
                }
                Some([x, y]) => {
                    let Some((size, pixels)) = self.textures.get_mut(id) else {
                        continue;
                    };
                    for row in 0..image.size[1] {
                        let from = row * image.size[0];
                        let to = (y + row) * size[0] + x;
                        let source = image.pixels.get(from..from + image.size[0]);
                        let target = pixels.get_mut(to..to + image.size[0]);
                        if let (Some(source), Some(target)) = (source, target) {
                            target.copy_from_slice(source);
                        }
                    }
                }
            }
        }
        for id in &delta.free {
            self.textures.remove(id);
        }
    }

    /// Draws triangles over the pixels.
    pub(crate) fn paint(&self, pixels: &mut Pixels<'_>, list: &[ClippedPrimitive], points: f32) {
        for clipped in list {
            let Primitive::Mesh(mesh) = &clipped.primitive else {
                continue;
            };
            let Some(texture) = self.textures.get(&mesh.texture_id) else {
                continue;
            };
            let r = clipped.clip_rect;
            let cut = |v: f32, n: usize| (v * points).round().clamp(0.0, n as f32) as usize;
            let clip = [
                cut(r.min.x, pixels.width),
                cut(r.max.x, pixels.width),
                cut(r.min.y, pixels.height),
                cut(r.max.y, pixels.height),
            ];
            for t in mesh.indices.chunks_exact(3) {
                let corner = |k: usize| mesh.vertices.get(t[k] as usize);
                if let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) {
                    triangle(pixels, clip, texture, [a, b, c], points);
                }
            }
        }
    }
}

fn triangle(
    pixels: &mut Pixels<'_>,
    [x0, x1, y0, y1]: [usize; 4],
    (size, texels): &([usize; 2], Vec<Color32>),
    [a, b, c]: [&Vertex; 3],
    points: f32,
) {
    let p = [a, b, c].map(|v| (v.pos.x * points, v.pos.y * points));
    let area = (p[1].0 - p[0].0) * (p[2].1 - p[0].1) - (p[1].1 - p[0].1) * (p[2].0 - p[0].0);
    if !(area.abs() > 1.0e-6 && area.is_finite()) {
        return;
    }
    let low = |k: fn(&(f32, f32)) -> f32| {
        p.iter()
            .map(k)
            .fold(f32::INFINITY, |a, b| if b < a { b } else { a })
    };
    let high = |k: fn(&(f32, f32)) -> f32| p.iter().map(k).fold(0.0f32, |a, b| if b > a { b } else { a });
    let from_x = (low(|q| q.0).max(0.0) as usize).max(x0);
    let from_y = (low(|q| q.1).max(0.0) as usize).max(y0);
    let to_x = (high(|q| q.0) as usize + 1).min(x1);
    let to_y = (high(|q| q.1) as usize + 1).min(y1);
    for y in from_y..to_y {
        for x in from_x..to_x {
            let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
            let edge = |i: usize, j: usize| {
                ((p[j].0 - p[i].0) * (py - p[i].1) - (p[j].1 - p[i].1) * (px - p[i].0)) / area
            };
            let w = [edge(1, 2), edge(2, 0), edge(0, 1)];
            if w.iter().any(|w| *w < 0.0) {
                continue;
            }
            let mix = |f: fn(&Vertex) -> f32| f(a) * w[0] + f(b) * w[1] + f(c) * w[2];
            let u = (mix(|v| v.uv.x) * size[0] as f32) as usize;
            let v = (mix(|v| v.uv.y) * size[1] as f32) as usize;
            let texel = texels.get(v.min(size[1] - 1) * size[0] + u.min(size[0] - 1));
            let Some(texel) = texel.map(|t| t.to_array()) else {
                continue;
            };
            let color = [
                mix(|v| f32::from(v.color.r())),
                mix(|v| f32::from(v.color.g())),
                mix(|v| f32::from(v.color.b())),
                mix(|v| f32::from(v.color.a())),
            ];
            let s: [f32; 4] = core::array::from_fn(|k| color[k] * f32::from(texel[k]) / 255.0);
            let Some(slot) = pixels.data.get_mut(y * pixels.width + x) else {
                continue;
            };
            let rest = 1.0 - s[3] / 255.0;
            let old = [(*slot >> 16) as u8, (*slot >> 8) as u8, *slot as u8];
            let out: [u32; 3] =
                core::array::from_fn(|k| (s[k] + f32::from(old[k]) * rest + 0.5).min(255.0) as u32);
            *slot = out[0] << 16 | out[1] << 8 | out[2];
        }
    }
}
