//! Everything at once: all loaded cells with a depth buffer and no traversal (`rendering.md` 10.4).

use vestibule_physics::ObjectRef;
use vestibule_view::{Camera, Command, LightSet, Views};
use vestibule_world::{CellId, Landblock, StaticRef};

use crate::error::RenderError;
use crate::id_image::IdImage;
use crate::image::Image;
use crate::paint::{Mode, Painter};
use crate::picture::Picture;
use crate::reference::{buffers, paint_picture};
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

/// The commands that draw all landblocks around a camera, only depth deciding: ground and shells, objects, rooms, bodies.
pub fn everything_commands(scene: &Scene<'_>, camera: &Camera, what: Everything) -> Vec<Command> {
    let views = Views::Landscape;
    let centre = camera.cell().block();
    let radius = what.radius.clamp(0, 32);
    let blocks: Vec<&Landblock> = (-radius..=radius)
        .flat_map(|dx| (-radius..=radius).filter_map(move |dy| centre.neighbour(dx, dy)))
        .filter_map(|id| scene.world.block(id))
        .collect();
    let mut out = Vec::new();
    if what.outdoors && blocks.iter().any(|b| b.land.is_some()) {
        out.push(Command::Sky);
    }
    for block in &blocks {
        if what.outdoors {
            out.push(Command::Light(LightSet::Sun));
            out.extend(block.land_cells().map(|(id, _)| Command::Terrain(id)));
            for (index, building) in block.buildings.iter().enumerate() {
                if let Some(part) = building.shape.parts.first().filter(|p| p.model.is_some()) {
                    out.push(Command::Building {
                        block: block.id,
                        building: index as u32,
                        model: part.model_id,
                    });
                }
            }
        }
        for (index, object) in block.statics.iter().enumerate() {
            let cell = object.cell;
            if !what.outdoors && !cell.is_indoor() {
                continue;
            }
            out.push(Command::Light(set_for(cell)));
            let id = ObjectRef::Static(StaticRef {
                block: block.id,
                index: index as u32,
            });
            out.push(Command::Object { id, cell, views });
        }
        out.push(Command::Light(LightSet::Indoor));
        out.extend(block.env_cells().map(|c| Command::Room { cell: c.id, views }));
    }
    for (id, body) in scene.population.iter().flat_map(|p| p.bodies()) {
        let cell = body.cell().unwrap_or(body.position().cell);
        let id = ObjectRef::Body(id);
        out.push(Command::Light(set_for(cell)));
        out.push(Command::Object { id, cell, views });
    }
    out
}

fn paint(
    scene: &Scene<'_>,
    camera: &Camera,
    what: Everything,
    settings: &RenderSettings,
    mode: Mode,
) -> Result<Painter, RenderError> {
    let buffers = buffers(camera, mode)?;
    let cell = scene.world.env_cell(camera.cell());
    let picture = Picture {
        camera,
        commands: &everything_commands(scene, camera, what),
        frame: None,
        sealed: camera.cell().is_indoor() && cell.is_none_or(|c| !c.seen_outside),
    };
    let clear = scene.daylight().horizon;
    let own_rooms = !what.outdoors;
    Ok(paint_picture(
        scene, &picture, settings, buffers, mode, clear, own_rooms,
    ))
}

fn set_for(cell: CellId) -> LightSet {
    if cell.is_indoor() {
        LightSet::Indoor
    } else {
        LightSet::Sun
    }
}
