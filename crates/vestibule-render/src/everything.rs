//! Everything at once: all loaded cells with a depth buffer and no traversal (`rendering.md` 10.4).

use vestibule_physics::ObjectRef;
use vestibule_view::{Camera, LightSet};
use vestibule_world::{CellId, Landblock, StaticRef};

use crate::error::RenderError;
use crate::id_image::IdImage;
use crate::image::Image;
use crate::paint::{Mode, Painter};
use crate::reference::{Run, buffers};
use crate::scene::{RenderSettings, Scene};

/// What [`render_everything`] draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Everything {
    /// Landblocks within this many blocks of the camera's.
    pub radius: i32,
    /// Sky, ground, buildings' shells and the objects outdoors; otherwise rooms and what is in them only.
    pub outdoors: bool,
}

impl Default for Everything {
    fn default() -> Self {
        Everything {
            radius: 2,
            outdoors: true,
        }
    }
}

/// Draws all landblocks around the camera: ground, shells, rooms, objects, in no particular order, only depth
/// deciding. The truth where nothing overlaps.
///
/// # Errors
/// When the camera's screen is no size for a picture.
pub fn render_everything(
    scene: &Scene<'_>,
    camera: &Camera,
    what: Everything,
    settings: &RenderSettings,
) -> Result<Image, RenderError> {
    let painter = paint(scene, camera, what, settings, Mode::Color)?;
    let screen = painter.buffers.screen;
    let mut image = Image::new(screen.width, screen.height, [0; 4])?;
    image.pixels_mut().copy_from_slice(&painter.buffers.color);
    Ok(image)
}

/// As [`render_everything`], as ids.
///
/// # Errors
/// As [`render_everything`].
pub fn render_everything_ids(
    scene: &Scene<'_>,
    camera: &Camera,
    what: Everything,
    settings: &RenderSettings,
) -> Result<IdImage, RenderError> {
    let painter = paint(scene, camera, what, settings, Mode::Ids)?;
    let screen = painter.buffers.screen;
    IdImage::from_ids(screen.width, screen.height, painter.buffers.ids).ok_or(RenderError::Size {
        width: screen.width,
        height: screen.height,
    })
}

fn paint(
    scene: &Scene<'_>,
    camera: &Camera,
    what: Everything,
    settings: &RenderSettings,
    mode: Mode,
) -> Result<Painter, RenderError> {
    let world = scene.world;
    let mut buffers = buffers(camera, mode)?;
    let day = scene.daylight();
    let cell = world.env_cell(camera.cell());
    let sealed = camera.cell().is_indoor() && cell.is_none_or(|c| !c.seen_outside);
    let clear = day.horizon * 255.0;
    buffers
        .color
        .fill([clear.x as u8, clear.y as u8, clear.z as u8, 255]);
    let painter = Painter::new(mode, *settings, camera, buffers, day, sealed);
    let mut run = Run::new(scene, camera, painter);
    run.close_cracks(!what.outdoors);
    let centre = camera.cell().block();
    let radius = what.radius.clamp(0, 32);
    let blocks: Vec<&Landblock> = (-radius..=radius)
        .flat_map(|dx| (-radius..=radius).filter_map(move |dy| centre.neighbour(dx, dy)))
        .filter_map(|id| world.block(id))
        .collect();
    if what.outdoors && blocks.iter().any(|b| b.land.is_some()) {
        let size = run.painter.buffers.screen;
        run.sky([0, size.width, 0, size.height]);
    }
    for block in &blocks {
        if what.outdoors {
            run.set_light(LightSet::Sun);
            for (id, _) in block.land_cells() {
                run.terrain(id);
            }
            for (index, building) in block.buildings.iter().enumerate() {
                if let Some(part) = building.shape.parts.first().filter(|p| p.model.is_some()) {
                    run.building(block.id, index as u32, part.model_id);
                }
            }
        }
        for index in 0..block.statics.len() as u32 {
            let object = &block.statics[index as usize];
            if !what.outdoors && !object.cell.is_indoor() {
                continue;
            }
            run.set_light(set_for(object.cell));
            let id = StaticRef {
                block: block.id,
                index,
            };
            run.object(ObjectRef::Static(id), object.cell, &[]);
        }
        run.set_light(LightSet::Indoor);
        for cell in block.env_cells() {
            run.room(cell.id, &[]);
        }
    }
    if let Some(population) = scene.population {
        for (id, body) in population.bodies() {
            let cell = body.cell().unwrap_or(body.position().cell);
            run.set_light(set_for(cell));
            run.object(ObjectRef::Body(id), cell, &[]);
        }
    }
    run.painter.flush();
    run.painter.resolve();
    Ok(run.painter)
}

fn set_for(cell: CellId) -> LightSet {
    if cell.is_indoor() {
        LightSet::Indoor
    } else {
        LightSet::Sun
    }
}
