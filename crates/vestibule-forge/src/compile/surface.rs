//! Materials as Surface, SurfaceTexture and RenderSurface records.

use vestibule_dat::record::{Paint, PixelFormat, RecordError, RenderSurface, Surface, SurfaceTexture};

use super::texture::{Painter, SIDE};
use super::world::Records;
use crate::scene::{Material, Pattern};

/// Adds an image under the next free ids; answers the id of its SurfaceTexture.
pub(crate) fn add_image(
    records: &mut Records,
    format: PixelFormat,
    pixels: Vec<u8>,
) -> Result<u32, RecordError> {
    let (image, texture) = (records.next_id(0x0600_0001), records.next_id(0x0500_0001));
    let (width, height) = (SIDE as i32, SIDE as i32);
    let record = RenderSurface {
        id: image,
        data_category: 6,
        width,
        height,
        format: format as u32,
        pixels,
        palette: None,
    };
    records.portal.insert(image, record.encode()?);
    let record = SurfaceTexture {
        id: texture,
        data_category: 7,
        texture_type: 2,
        textures: vec![image],
    };
    records.portal.insert(texture, record.encode()?);
    Ok(texture)
}

/// Adds the Surfaces of all materials; answers their ids.
pub(crate) fn add_surfaces(
    records: &mut Records,
    painter: &mut Painter,
    materials: &[Material],
) -> Result<Vec<u32>, RecordError> {
    let mut out = Vec::new();
    for material in materials {
        let pixels = painter.texture(material.pattern, material.color, material.second, material.seed);
        let bytes = pixels.iter().flat_map(|[r, g, b]| [*b, *g, *r]).collect();
        let texture = add_image(records, PixelFormat::R8G8B8, bytes)?;
        let glows = material.pattern == Pattern::Glow;
        let id = records.next_id(0x0800_0001);
        let record = Surface {
            surface_type: Surface::IMAGE | if glows { Surface::LUMINOUS } else { 0 },
            paint: Paint::Image { texture, palette: 0 },
            translucency: 0.0,
            luminosity: if glows { 1.0 } else { 0.0 },
            diffuse: 1.0,
        };
        records.portal.insert(id, record.encode()?);
        out.push(id);
    }
    Ok(out)
}
