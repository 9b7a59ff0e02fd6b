//! Objects on a walk: static ones from what is kept of them, bodies as they are now (`rendering.md` 6, 17).

use std::sync::Arc;

use glam::{DVec3, Vec3};
use vestibule_physics::{BodyId, ObjectRef};
use vestibule_view::LightSet;
use vestibule_world::{BlockId, CellId, Frame, StaticRef};

use super::{BODY_ITEM, Canvas, Owner, Piece, PieceLight, Walk, WalkMemory};
use crate::cell_lamps::{CellLamps, nearest};
use crate::detail::turned;
use crate::figure::{FIGURE_HEIGHT, figure};
use crate::lighting::MAX_OBJECT_LAMPS;
use crate::mesh::Mesh;
use crate::model_table::{Level, ModelTable};
use crate::place::{EyeFrame, Placed};
use crate::raster::PixelKind;
use crate::scene::Scene;
use crate::static_parts::{StaticPart, StaticParts};

impl Walk<'_> {
    pub(super) fn object(&mut self, id: ObjectRef, cell: CellId, edges: &[DVec3], canvas: &mut impl Canvas) {
        match id {
            ObjectRef::Static(id) => self.static_object(id, cell, edges, canvas),
            ObjectRef::Body(id) => self.body(id, cell, edges, canvas),
        }
    }

    fn static_object(&mut self, id: StaticRef, cell: CellId, edges: &[DVec3], canvas: &mut impl Canvas) {
        let scene = self.scene;
        let WalkMemory { statics, models, .. } = &mut *self.memory;
        let Some(found) = statics.thing(scene.world, models, id) else {
            self.missing();
            return;
        };
        let thing = Thing {
            owner: Owner {
                kind: PixelKind::Object,
                cell: found.cell,
                item: Some(id.index),
            },
            block: found.cell.block(),
            listed_in: cell,
            opacity: 1.0,
            edges,
        };
        let (mut parts, statics) = self.parts();
        for (part, at) in statics.parts(&found).iter().zip(0..) {
            let frame = || {
                let object = scene.world.static_object(id);
                object
                    .and_then(|o| o.part_frames.get(at).copied())
                    .unwrap_or_default()
            };
            parts.draw(&thing, part, frame, canvas);
        }
    }

    fn body(&mut self, id: BodyId, cell: CellId, edges: &[DVec3], canvas: &mut impl Canvas) {
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
        let thing = Thing {
            owner: Owner {
                kind: PixelKind::Object,
                cell: body.cell().unwrap_or(position.cell),
                item: Some(BODY_ITEM),
            },
            block: position.cell.block(),
            listed_in: cell,
            opacity,
            edges,
        };
        let shape = body.shape();
        let eye = self.eye;
        let (mut parts, _) = self.parts();
        if !shape.parts.is_empty() && !body.part_frames().is_empty() {
            for (part, frame) in shape.parts.iter().zip(body.part_frames()) {
                let placed = StaticPart {
                    origin: frame.origin,
                    axes: *frame.axes(),
                    scale: part.scale * body.scale(),
                    model: parts.models.position(part.model_id),
                };
                parts.draw(&thing, &placed, || *frame, canvas);
            }
            return;
        }
        let tops = shape.spheres.iter().map(|s| s.center.z + s.radius);
        let tallest = tops.fold(shape.height, |a, b| if b > a { b } else { a });
        let height = if tallest > 0.1 { tallest } else { FIGURE_HEIGHT };
        let scale = Vec3::splat(height / FIGURE_HEIGHT * body.scale());
        let placed = eye.place(thing.block, &position.frame, scale);
        draw_lit(scene, &eye, parts.light(), &thing, &figure(), &placed, canvas);
    }

    fn parts(&mut self) -> (Parts<'_>, &StaticParts) {
        let WalkMemory {
            statics,
            models,
            lamps,
            ..
        } = &mut *self.memory;
        let parts = Parts {
            scene: self.scene,
            eye: &self.eye,
            quality: self.settings.detail,
            set: self.light,
            lit: self.lit,
            models,
            lamps,
            missing: &mut self.counters.missing,
        };
        (parts, statics)
    }
}

/// What drawing parts needs of a walk.
struct Parts<'p> {
    scene: &'p Scene<'p>,
    eye: &'p EyeFrame,
    quality: f32,
    set: LightSet,
    lit: bool,
    models: &'p mut ModelTable,
    lamps: &'p mut CellLamps,
    missing: &'p mut u32,
}

impl Parts<'_> {
    /// The lamps and whether they are looked for; `None` by the sun.
    fn light(&mut self) -> Option<(&mut CellLamps, bool)> {
        (self.set != LightSet::Sun).then_some((&mut *self.lamps, self.lit))
    }

    /// Draws a part of an object at the level for its distance, turned to the viewer if the level says so
    /// (`rendering.md` 17.1); `frame` is asked for its whole frame then.
    fn draw(
        &mut self,
        thing: &Thing<'_>,
        part: &StaticPart,
        frame: impl FnOnce() -> Frame,
        canvas: &mut impl Canvas,
    ) {
        let eye = self.eye.eye_in(thing.block);
        // Within the 50 m in which parts have distances of their own everything is drawn in full.
        let gap = part.origin - eye.as_vec3();
        let distance = libm::sqrtf(gap.dot(gap)) / part.scale.z;
        let (mesh, mode) = match self.models.level(self.scene, part.model, distance, self.quality) {
            Level::Mesh(mesh, mode) => (mesh, mode),
            Level::Nothing => return,
            Level::Missing => {
                *self.missing += 1;
                return;
            }
        };
        let placed = if matches!(mode, 2..=5) {
            let turned = turned(&frame(), eye.as_vec3(), mode);
            self.eye.place(thing.block, &turned, part.scale)
        } else {
            self.eye.place_axes(eye, part.origin, &part.axes, part.scale)
        };
        let light = (self.set != LightSet::Sun).then_some((&mut *self.lamps, self.lit));
        draw_lit(self.scene, self.eye, light, thing, mesh, &placed, canvas);
    }
}

/// Draws a mesh of an object; with lamps by those of its cell that are nearest, if they are looked for, else by the sun.
fn draw_lit(
    scene: &Scene<'_>,
    eye: &EyeFrame,
    light: Option<(&mut CellLamps, bool)>,
    thing: &Thing<'_>,
    mesh: &Arc<Mesh>,
    placed: &Placed,
    canvas: &mut impl Canvas,
) {
    let mut near = [0u8; MAX_OBJECT_LAMPS];
    let cell = thing.listed_in;
    let light = match light {
        None => PieceLight::Sun,
        Some((lamps, lit)) => {
            let lamps = if lit { lamps.of(scene, eye, cell) } else { &[] };
            let count = nearest(lamps, mesh, placed, &mut near);
            PieceLight::Indoor {
                cell,
                lamps,
                near: &near[..count],
            }
        }
    };
    canvas.piece(&Piece {
        mesh,
        placed,
        owner: thing.owner,
        light,
        opacity: thing.opacity,
        edges: thing.edges,
    });
}

/// An object whose parts are being drawn.
struct Thing<'t> {
    owner: Owner,
    block: BlockId,
    /// The cell whose lamps light it.
    listed_in: CellId,
    opacity: f32,
    edges: &'t [DVec3],
}
