//! The reference renderer: draws what a walk over a frame's commands yields (`rendering.md` 5, 6, 10).

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use vestibule_view::{Camera, Command, FrameView};
use vestibule_world::terrain::vertex_index;
use vestibule_world::{BlockId, CellId};

use crate::distance_image::DistanceImage;
use crate::error::RenderError;
use crate::id_image::IdImage;
use crate::image::{Image, check_size};
use crate::lighting::Lamp;
use crate::mesh::Mesh;
use crate::paint::{Mode, Painter};
use crate::picture::Picture;
use crate::place::Placed;
use crate::raster::scan::{Affine, GROWTH, Projection};
use crate::raster::{Buffers, PUNCH_DEPTH};
use crate::scene::{RenderCounters, RenderSettings, Scene};
use crate::shade::MeshLight;
use crate::sky::SkyThing;
use crate::walk::{Canvas, Piece, PieceLight, PortalDepth, Walk, WalkMemory};

/// Draws the picture of a frame.
///
/// # Errors
/// When the camera's screen is no size for a picture.
pub fn render(scene: &Scene<'_>, frame: &FrameView, settings: &RenderSettings) -> Result<Image, RenderError> {
    render_commands(scene, frame, frame.commands(), settings).map(|(image, _)| image)
}

/// Draws the picture of a frame as ids (`rendering.md` 10.1).
///
/// # Errors
/// As [`render`].
pub fn render_ids(
    scene: &Scene<'_>,
    frame: &FrameView,
    settings: &RenderSettings,
) -> Result<IdImage, RenderError> {
    render_commands_ids(scene, frame, frame.commands(), settings).map(|(image, _)| image)
}

/// As [`render`], with other commands than the frame's own, to see what each is good for.
///
/// # Errors
/// As [`render`].
pub fn render_commands(
    scene: &Scene<'_>,
    frame: &FrameView,
    commands: &[Command],
    settings: &RenderSettings,
) -> Result<(Image, RenderCounters), RenderError> {
    let painter = paint(scene, frame, commands, settings, Mode::Color, false)?;
    let screen = painter.buffers.screen;
    let mut image = Image::new(screen.width, screen.height, [0; 4])?;
    image.pixels_mut().copy_from_slice(&painter.buffers.color);
    Ok((image, painter.counters))
}

/// As [`render_ids`], with other commands than the frame's own.
///
/// # Errors
/// As [`render`].
pub fn render_commands_ids(
    scene: &Scene<'_>,
    frame: &FrameView,
    commands: &[Command],
    settings: &RenderSettings,
) -> Result<(IdImage, RenderCounters), RenderError> {
    let painter = paint(scene, frame, commands, settings, Mode::Ids, false)?;
    let screen = painter.buffers.screen;
    let image = IdImage::from_ids(screen.width, screen.height, painter.buffers.ids);
    let image = image.ok_or(RenderError::Size {
        width: screen.width,
        height: screen.height,
    })?;
    Ok((image, painter.counters))
}

/// How far away everything is that a frame's picture shows, for effects that are made from it afterwards.
///
/// # Errors
/// As [`render`].
pub fn render_distances(
    scene: &Scene<'_>,
    frame: &FrameView,
    settings: &RenderSettings,
) -> Result<DistanceImage, RenderError> {
    let painter = paint(scene, frame, frame.commands(), settings, Mode::Ids, true)?;
    Ok(DistanceImage::new(&painter.buffers))
}

/// The buffers of a camera's screen.
pub(crate) fn buffers(camera: &Camera, mode: Mode) -> Result<Buffers, RenderError> {
    let size = camera.viewport();
    let whole = |v: f32| {
        // Checked below; a float cast saturates.
        v as u32
    };
    let (width, height) = (whole(size.x), whole(size.y));
    check_size(width, height)?;
    if (width as f32, height as f32) != (size.x, size.y) {
        return Err(RenderError::Viewport {
            width,
            height,
            camera_width: size.x,
            camera_height: size.y,
        });
    }
    let slopes = DVec2::new(f64::from(camera.slopes().x), f64::from(camera.slopes().y));
    let screen = Projection::new(width, height, slopes, f64::from(camera.near()));
    Ok(Buffers::new(screen, mode == Mode::Ids))
}

fn paint(
    scene: &Scene<'_>,
    frame: &FrameView,
    commands: &[Command],
    settings: &RenderSettings,
    mode: Mode,
    keep_landscape: bool,
) -> Result<Painter, RenderError> {
    let Some(picture) = Picture::of(frame) else {
        return Err(RenderError::Size { width: 0, height: 0 });
    };
    let mut buffers = buffers(picture.camera, mode)?;
    if keep_landscape {
        buffers.keep_landscape();
    }
    let picture = Picture { commands, ..picture };
    let clear = if picture.sealed {
        Vec3::ZERO
    } else {
        scene.daylight().horizon
    };
    // Until there is a landscape, everything is the viewer's own rooms.
    let own_rooms = frame.interior().is_some();
    Ok(paint_picture(
        scene, &picture, settings, buffers, mode, clear, own_rooms,
    ))
}

/// Draws a picture into buffers of this colour. `own_rooms`: it begins with the rooms around the viewer, which must be
/// watertight.
pub(crate) fn paint_picture(
    scene: &Scene<'_>,
    picture: &Picture<'_>,
    settings: &RenderSettings,
    mut buffers: Buffers,
    mode: Mode,
    clear: Vec3,
    own_rooms: bool,
) -> Painter {
    let clear = clear * 255.0;
    buffers
        .color
        .fill([clear.x as u8, clear.y as u8, clear.z as u8, 255]);
    let painter = Painter::new(
        mode,
        *settings,
        picture.camera,
        buffers,
        scene.daylight(),
        picture.sealed,
    );
    let mut memory = WalkMemory::new();
    let mut walk = Walk::new(scene, settings, picture, &mut memory);
    if mode == Mode::Ids {
        walk = walk.unlit();
    }
    let mut easel = Easel {
        scene,
        viewer: walk.viewer_lamp(),
        painter,
        lamps: Vec::new(),
        confine: Vec::new(),
    };
    easel.close_cracks(own_rooms);
    let met = walk.run(&mut easel);
    let mut painter = easel.painter;
    painter.resolve();
    painter.counters.missing += met.missing;
    painter.counters.confined += met.confined;
    painter
}

/// A painter at work on a walk.
struct Easel<'a> {
    scene: &'a Scene<'a>,
    viewer: Option<Lamp>,
    painter: Painter,
    lamps: Vec<Lamp>,
    confine: Vec<Affine>,
}

impl Easel<'_> {
    /// Whether what follows are the rooms around the viewer, which must be watertight.
    fn close_cracks(&mut self, close: bool) {
        self.painter.growth = if close { GROWTH } else { 0.0 };
    }
}

impl Canvas for Easel<'_> {
    fn sky(&mut self, bounds: [u32; 4]) {
        self.close_cracks(false);
        self.painter.sky(bounds);
    }

    fn sky_thing(&mut self, mesh: &Arc<Mesh>, placed: &Placed, thing: &SkyThing) {
        let opacity = 1.0 - thing.translucency;
        self.painter.sky_mesh(mesh, placed, thing.luminosity, opacity);
    }

    fn land_cell(&mut self, cell: CellId) -> bool {
        let scene = self.scene;
        let (Some(land_cell), Some(land)) = (
            scene.world.land_cell(cell),
            scene.assets.land(scene.world, cell.block()),
        ) else {
            return false;
        };
        let placed = self.painter.eye.place_block(cell.block());
        let index = usize::from(cell.low()) - 1;
        for polygon in &land_cell.polygons {
            let normals = polygon.vertices.map(|v| {
                let side = vestibule_world::constants::SQUARE_LENGTH;
                let at = |v: f32| libm::roundf(v / side) as usize;
                let slot = vertex_index(at(v.x).min(8), at(v.y).min(8));
                land.normals.get(slot).copied().unwrap_or(Vec3::Z)
            });
            self.painter
                .ground(&land, &placed, polygon.vertices, normals, cell.0, Some(index));
        }
        true
    }

    fn land_block(&mut self, block: BlockId, stride: u8) -> bool {
        let scene = self.scene;
        let loaded = scene.world.loaded_block(block).and_then(|b| b.land.as_ref());
        let (Some(ground), Some(land)) = (loaded, scene.assets.land(scene.world, block)) else {
            return false;
        };
        let placed = self.painter.eye.place_block(block);
        let step = usize::from(stride.clamp(1, 8));
        let side = vestibule_world::constants::SQUARE_LENGTH;
        let corner = |i: usize, j: usize| {
            let slot = vertex_index(i, j);
            let place = Vec3::new(i as f32 * side, j as f32 * side, ground.heights[slot]);
            (place, land.normals[slot])
        };
        for i in (0..8).step_by(step) {
            for j in (0..8).step_by(step) {
                let (e, n) = ((i + step).min(8), (j + step).min(8));
                let (sw, se, ne, nw) = (corner(i, j), corner(e, j), corner(e, n), corner(i, n));
                let cell = CellId::new(block, (1 + 8 * i + j) as u16).0;
                for t in [[sw, se, ne], [sw, ne, nw]] {
                    self.painter
                        .ground(&land, &placed, t.map(|c| c.0), t.map(|c| c.1), cell, None);
                }
            }
        }
        true
    }

    fn behind_exit(&mut self, points: &[DVec3]) {
        self.painter.buffers.limit_behind(points);
    }

    fn portal(&mut self, points: &[DVec3], depth: PortalDepth) {
        let buffers = &mut self.painter.buffers;
        match depth {
            PortalDepth::Punch => buffers.depth_polygon(points, Some(PUNCH_DEPTH)),
            PortalDepth::Own => buffers.seal(points, None),
            PortalDepth::Nearest => buffers.seal(points, Some(1.0)),
        }
    }

    fn piece(&mut self, piece: &Piece<'_>) {
        let viewer = self.viewer;
        let light = match piece.light {
            PieceLight::Sun => MeshLight::Sun,
            PieceLight::Shell { lamps, .. } => MeshLight::Shell { lamps, viewer },
            PieceLight::Indoor { lamps, near, .. } => {
                self.lamps.clear();
                let near = near.iter().filter_map(|&k| lamps.get(usize::from(k)));
                self.lamps.extend(near);
                MeshLight::Indoor {
                    lamps: &self.lamps,
                    viewer,
                }
            }
        };
        let screen = self.painter.buffers.screen;
        self.confine.clear();
        let edges = piece.edges.iter().map(|&n| screen.dot_ray(n).grown(2.0 * GROWTH));
        self.confine.extend(edges);
        self.painter.mesh(
            piece.mesh,
            piece.placed,
            piece.owner,
            light,
            piece.opacity,
            &self.confine,
        );
    }

    fn flush(&mut self) {
        self.painter.flush();
    }

    fn clear_depth(&mut self) {
        self.painter.buffers.clear_depth();
        self.painter.buffers.no_limit();
        self.close_cracks(true);
    }
}
