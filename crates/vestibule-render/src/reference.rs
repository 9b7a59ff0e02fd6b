//! The reference renderer: walks a frame's commands from first to last (`rendering.md` 5, 6, 10).

use glam::{DVec2, DVec3, Vec3};
use vestibule_physics::ObjectRef;
use vestibule_view::{Camera, Command, FramePath, FrameView, LightSet, Region, SealDepth, Views};
use vestibule_world::terrain::vertex_index;
use vestibule_world::{BlockId, CellId, EnvCell, Frame, StaticRef};

use crate::distance_image::DistanceImage;
use crate::error::RenderError;
use crate::id_image::IdImage;
use crate::image::{Image, check_size};
use crate::lighting::{Lamp, MAX_OBJECT_LAMPS};
use crate::overlaps::overlapping_cells;
use crate::paint::{Mode, Owner, Painter};
use crate::raster::scan::{Affine, GROWTH, Projection};
use crate::raster::{Buffers, PUNCH_DEPTH, PixelKind};
use crate::scene::{LightDetail, RenderCounters, RenderSettings, Scene};
use crate::shade::MeshLight;

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
    let Some(camera) = frame.camera() else {
        return Err(RenderError::Size { width: 0, height: 0 });
    };
    let mut buffers = buffers(camera, mode)?;
    if keep_landscape {
        buffers.keep_landscape();
    }
    let day = scene.daylight();
    let sealed = frame.path() == FramePath::Sealed;
    let clear = if sealed { Vec3::ZERO } else { day.horizon } * 255.0;
    buffers
        .color
        .fill([clear.x as u8, clear.y as u8, clear.z as u8, 255]);
    let painter = Painter::new(mode, *settings, camera, buffers, day, sealed);
    let mut run = Run::new(scene, camera, painter);
    // Until there is a landscape, everything is the viewer's own rooms.
    run.close_cracks(frame.interior().is_some());
    if settings.confine_overlaps {
        run.overlaps = frame
            .floods()
            .iter()
            .map(|f| overlapping_cells(scene.world, &f))
            .collect();
    }
    if settings.only_behind_exits && frame.interior().is_some() {
        for command in commands {
            if let Command::Seal {
                polygon,
                depth: SealDepth::True,
                ..
            } = *command
            {
                let points = run.seen(frame.polygon(polygon));
                run.painter.buffers.limit_behind(&points);
            }
        }
    }
    for command in commands {
        run.command(frame, command);
    }
    run.painter.resolve();
    Ok(run.painter)
}

/// A frame being drawn.
pub(crate) struct Run<'a> {
    scene: &'a Scene<'a>,
    camera: Camera,
    pub(crate) painter: Painter,
    light: LightSet,
    viewer_lamp: Option<Lamp>,
    /// Per traversal the rooms that overlap others.
    overlaps: Vec<Vec<CellId>>,
}

impl<'a> Run<'a> {
    pub(crate) fn new(scene: &'a Scene<'a>, camera: &Camera, painter: Painter) -> Self {
        let mut run = Run {
            scene,
            camera: *camera,
            painter,
            light: LightSet::Sun,
            viewer_lamp: None,
            overlaps: Vec::new(),
        };
        run.viewer_lamp = run.find_viewer_lamp();
        run
    }

    /// The light the viewer carries, camera axes (`rendering.md` 12.7).
    fn find_viewer_lamp(&self) -> Option<Lamp> {
        if !self.painter.settings.viewer_light {
            return None;
        }
        let over = Vec3::new(0.0, 0.0, 2.0);
        let player = self.scene.player.zip(self.scene.population);
        let body = player.and_then(|(id, population)| population.body(id));
        let position = match body {
            Some(body) => {
                let p = body.position();
                let placed = self.painter.eye.place_block(p.cell.block());
                placed.point(p.frame.origin + over)
            }
            None => DVec3::ZERO,
        };
        let mut lamp = Lamp::of_viewer(position.as_vec3());
        if self.painter.settings.light == LightDetail::PerPixel && !self.painter.sealed {
            // By daylight it would drown what the room's own lamps do.
            lamp.intensity *= 0.3;
        }
        Some(lamp)
    }

    pub(crate) fn set_light(&mut self, light: LightSet) {
        self.light = light;
    }

    /// Whether what follows are the rooms around the viewer, which must be watertight.
    pub(crate) fn close_cracks(&mut self, close: bool) {
        self.painter.growth = if close { GROWTH } else { 0.0 };
    }

    fn missing(&mut self) {
        self.painter.counters.missing += 1;
    }

    fn command(&mut self, frame: &FrameView, command: &Command) {
        match *command {
            Command::Light(light) => self.light = light,
            Command::Sky => {
                self.close_cracks(false);
                self.sky(sky_bounds(frame, &self.camera));
            }
            Command::Terrain(cell) => self.terrain(cell),
            Command::TerrainBlock { block, stride } => self.terrain_block(block, stride),
            Command::FlushAlpha => self.painter.flush(),
            Command::Punch { polygon, .. } => {
                let points = self.seen(frame.polygon(polygon));
                self.painter.buffers.depth_polygon(&points, Some(PUNCH_DEPTH));
            }
            Command::Seal { polygon, depth, .. } => {
                let points = self.seen(frame.polygon(polygon));
                let constant = (depth == SealDepth::Nearest).then_some(1.0);
                self.painter.buffers.seal(&points, constant);
            }
            Command::Building {
                block,
                building,
                model,
            } => self.building(block, building, model),
            Command::Room { cell, views } => match self.confined(frame, cell, views) {
                Some(regions) => {
                    self.painter.counters.confined += 1;
                    for region in regions {
                        self.room(cell, &region);
                    }
                }
                None => self.room(cell, &[]),
            },
            Command::Object { id, cell, views } => match self.confined(frame, cell, views) {
                Some(regions) => {
                    for region in regions {
                        self.object(id, cell, &region);
                    }
                }
                None => self.object(id, cell, &[]),
            },
            Command::NextStamp => {}
            Command::ClearDepth => {
                self.painter.buffers.clear_depth();
                self.painter.buffers.no_limit();
                self.close_cracks(true);
            }
            Command::Weather => self.sky_things(true),
        }
    }

    /// Eye-relative points in camera axes.
    fn seen(&self, points: &[Vec3]) -> Vec<DVec3> {
        points
            .iter()
            .map(|p| self.painter.eye.turn(p.as_dvec3()))
            .collect()
    }

    /// The regions of a room that overlaps others, as planes on the screen (`rendering.md` 9.5).
    fn confined(&self, frame: &FrameView, cell: CellId, views: Views) -> Option<Vec<Vec<Affine>>> {
        let Views::Cell { flood, .. } = views else {
            return None;
        };
        let overlapping = self.overlaps.get(flood as usize)?;
        overlapping.contains(&cell).then(|| {
            let planes = |region: Region<'_>| {
                let edges = region.edges().iter();
                edges
                    .map(|e| {
                        let n = self.painter.eye.turn(e.normal.as_dvec3());
                        self.painter.buffers.screen.dot_ray(n).grown(2.0 * GROWTH)
                    })
                    .collect()
            };
            frame.regions(views).map(planes).collect()
        })
    }

    pub(crate) fn sky(&mut self, bounds: [u32; 4]) {
        self.painter.sky(bounds);
        self.sky_things(false);
    }

    fn sky_things(&mut self, after: bool) {
        let scene = self.scene;
        let table = scene.assets.sky(scene.world);
        for thing in table.things(scene.day_group, scene.time_of_day) {
            if thing.after != after {
                continue;
            }
            let Some(mesh) = scene.assets.model(scene.world, thing.model, None) else {
                self.missing();
                continue;
            };
            let heading = glam::Quat::from_rotation_z(-thing.heading);
            let rotation = heading * glam::Quat::from_rotation_y(-thing.angle);
            // Around the eye: endlessly far away.
            let frame = Frame::new(self.camera.eye(), rotation);
            let placed = self
                .painter
                .eye
                .place(self.camera.cell().block(), &frame, Vec3::ONE);
            self.painter
                .sky_mesh(&mesh, &placed, thing.luminosity, 1.0 - thing.translucency);
        }
    }

    pub(crate) fn terrain(&mut self, cell: CellId) {
        let scene = self.scene;
        let (Some(land_cell), Some(land)) = (
            scene.world.land_cell(cell),
            scene.assets.land(scene.world, cell.block()),
        ) else {
            self.missing();
            return;
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
    }

    fn terrain_block(&mut self, block: BlockId, stride: u8) {
        let scene = self.scene;
        let loaded = scene.world.loaded_block(block).and_then(|b| b.land.as_ref());
        let (Some(ground), Some(land)) = (loaded, scene.assets.land(scene.world, block)) else {
            self.missing();
            return;
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
    }

    pub(crate) fn building(&mut self, block: BlockId, index: u32, model: u32) {
        let scene = self.scene;
        let found = scene.world.loaded_block(block);
        let Some(building) = found.and_then(|b| b.buildings.get(index as usize)) else {
            self.missing();
            return;
        };
        let part = building.shape.parts.first();
        let shell = part.and_then(|p| p.model.as_deref());
        let Some((mesh, part)) = shell
            .and_then(|s| scene.assets.model(scene.world, model, Some(s)))
            .zip(part)
        else {
            self.missing();
            return;
        };
        let frame = building.part_frames.first().copied().unwrap_or(building.frame);
        let placed = self.painter.eye.place(block, &frame, part.scale);
        let owner = Owner {
            kind: PixelKind::Building,
            cell: building.cell.0,
            item: None,
        };
        self.painter.mesh(&mesh, &placed, owner, MeshLight::Sun, 1.0, &[]);
    }

    fn seen_lamps(&self, cell: &EnvCell) -> Vec<Lamp> {
        if self.painter.mode == Mode::Ids {
            return Vec::new();
        }
        let placed = self.painter.eye.place_block(cell.id.block());
        let lamps = self.scene.assets.lamps(self.scene.world, cell);
        lamps.iter().map(|l| self.painter.lamp_seen(&placed, l)).collect()
    }

    pub(crate) fn room(&mut self, id: CellId, confine: &[Affine]) {
        let scene = self.scene;
        let Some(cell) = scene.world.env_cell(id) else {
            self.missing();
            return;
        };
        let Some(mesh) = scene.assets.cell_shell(scene.world, cell) else {
            self.missing();
            return;
        };
        let placed = self.painter.eye.place(id.block(), &cell.frame, Vec3::ONE);
        let owner = Owner {
            kind: PixelKind::Room,
            cell: id.0,
            item: None,
        };
        let lamps = self.seen_lamps(cell);
        let light = MeshLight::Shell {
            lamps: &lamps,
            viewer: self.viewer_lamp,
        };
        self.painter.mesh(&mesh, &placed, owner, light, 1.0, confine);
    }

    pub(crate) fn object(&mut self, id: ObjectRef, cell: CellId, confine: &[Affine]) {
        match id {
            ObjectRef::Static(id) => self.static_object(id, cell, confine),
            ObjectRef::Body(id) => self.body(id, cell, confine),
        }
    }

    /// The model to draw of a part at its distance, and its frame, turned to the viewer if the level says so; `None`
    /// when nothing is drawn of it.
    fn level(&self, block: BlockId, model: u32, frame: &Frame, scale: f32) -> Option<(u32, Frame)> {
        let eye = self.painter.eye.eye_in(block).as_vec3();
        // Within the 50 m in which parts have distances of their own everything is drawn in full.
        let gap = frame.origin - eye;
        let distance = libm::sqrtf(gap.dot(gap)) / scale;
        let quality = self.painter.settings.detail;
        let level = self
            .scene
            .assets
            .model_level(self.scene.world, model, distance, quality);
        Some((level.model?, crate::detail::turned(frame, eye, level.mode)))
    }

    fn static_object(&mut self, id: StaticRef, cell: CellId, confine: &[Affine]) {
        let scene = self.scene;
        let Some(object) = scene.world.static_object(id) else {
            self.missing();
            return;
        };
        let owner = Owner {
            kind: PixelKind::Object,
            cell: object.cell.0,
            item: Some(id.index),
        };
        let parts = object.shape.parts.iter().zip(&object.part_frames);
        for (part, frame) in parts {
            let block = object.cell.block();
            let Some((model, frame)) = self.level(block, part.model_id, frame, part.scale.z) else {
                continue;
            };
            let Some(mesh) = scene.assets.model(scene.world, model, None) else {
                self.missing();
                continue;
            };
            let placed = self.painter.eye.place(block, &frame, part.scale);
            self.lit_object(&mesh, &placed, owner, cell, 1.0, confine);
        }
    }

    fn body(&mut self, id: vestibule_physics::BodyId, cell: CellId, confine: &[Affine]) {
        let scene = self.scene;
        let Some(body) = scene.population.and_then(|p| p.body(id)) else {
            self.missing();
            return;
        };
        let opacity = if scene.player == Some(id) {
            scene.player_opacity
        } else {
            1.0
        };
        if !(opacity > 0.0) {
            return;
        }
        let position = body.position();
        let block = position.cell.block();
        let owner = Owner {
            kind: PixelKind::Object,
            cell: body.cell().unwrap_or(position.cell).0,
            item: Some(0x0800_0000),
        };
        let mut drawn = false;
        for (part, frame) in body.shape().parts.iter().zip(body.part_frames()) {
            drawn = true;
            let scale = part.scale * body.scale();
            let Some((model, frame)) = self.level(block, part.model_id, frame, scale.z) else {
                continue;
            };
            let Some(mesh) = scene.assets.model(scene.world, model, None) else {
                self.missing();
                continue;
            };
            let placed = self.painter.eye.place(block, &frame, scale);
            self.lit_object(&mesh, &placed, owner, cell, opacity, confine);
        }
        if !drawn {
            let shape = body.shape();
            let tallest = shape
                .spheres
                .iter()
                .map(|s| s.center.z + s.radius)
                .fold(shape.height, |a, b| if b > a { b } else { a });
            let height = if tallest > 0.1 {
                tallest
            } else {
                crate::figure::FIGURE_HEIGHT
            };
            let scale = Vec3::splat(height / crate::figure::FIGURE_HEIGHT * body.scale());
            let placed = self.painter.eye.place(block, &position.frame, scale);
            self.lit_object(&crate::figure::figure(), &placed, owner, cell, opacity, confine);
        }
    }

    fn lit_object(
        &mut self,
        mesh: &crate::mesh::Mesh,
        placed: &crate::place::Placed,
        owner: Owner,
        listed_in: CellId,
        opacity: f32,
        confine: &[Affine],
    ) {
        if self.light == LightSet::Sun {
            self.painter
                .mesh(mesh, placed, owner, MeshLight::Sun, opacity, confine);
            return;
        }
        let cell = self.scene.world.env_cell(listed_in);
        let mut lamps = cell.map(|c| self.seen_lamps(c)).unwrap_or_default();
        let middle = placed.point(mesh.sphere.center).as_vec3();
        let reach = |l: &Lamp| l.falloff * crate::lighting::OBJECT_RANGE + mesh.sphere.radius;
        let square = |l: &Lamp| {
            let gap = l.position - middle;
            gap.dot(gap)
        };
        lamps.retain(|l| square(l) < reach(l) * reach(l));
        lamps.sort_by(|a, b| square(a).total_cmp(&square(b)));
        lamps.truncate(MAX_OBJECT_LAMPS);
        let light = MeshLight::Indoor {
            lamps: &lamps,
            viewer: self.viewer_lamp,
        };
        self.painter.mesh(mesh, placed, owner, light, opacity, confine);
    }
}

/// The columns and rows the landscape can show in: the regions' bounds and a pixel around them.
fn sky_bounds(frame: &FrameView, camera: &Camera) -> [u32; 4] {
    let size = camera.viewport();
    let whole = [0, size.x as u32, 0, size.y as u32];
    if frame.path() == FramePath::Outdoors || frame.landscape_views().len() == 0 {
        return whole;
    }
    let (mut x0, mut x1, mut y0, mut y1) = (size.x, 0.0f32, size.y, 0.0f32);
    for region in frame.landscape_views() {
        let (low, high) = region.pixel_bounds(camera);
        x0 = if low.x < x0 { low.x } else { x0 };
        y0 = if low.y < y0 { low.y } else { y0 };
        x1 = if high.x > x1 { high.x } else { x1 };
        y1 = if high.y > y1 { high.y } else { y1 };
    }
    // Casts of floats saturate at zero.
    [
        (x0 - 2.0) as u32,
        (x1 + 2.0) as u32,
        (y0 - 2.0) as u32,
        (y1 + 2.0) as u32,
    ]
}
