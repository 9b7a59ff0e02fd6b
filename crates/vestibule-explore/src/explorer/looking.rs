//! What is drawn over the picture, and what was clicked.

use glam::Vec2;
use vestibule_physics::ObjectRef;
use vestibule_view::{Command, FrameInput};

use super::Explorer;
use crate::overlays::{Mark, Marks, Overlay};
use crate::picking::pick;
use crate::portals;

impl Explorer {
    /// Marks of the overlays that are on.
    pub fn marks(&self) -> Vec<Mark> {
        let Some(camera) = self.camera() else {
            return Vec::new();
        };
        let mut marks = Marks::new(&camera);
        let player = self.player_cell();
        for (on, overlay) in self.overlays.iter().zip(Overlay::ALL) {
            if *on {
                marks.overlay(overlay, &self.world, &self.frame, player);
            }
        }
        if self.overlays.get(3) == Some(&true) {
            let bodies = self.population.bodies();
            let shown = bodies.filter(|(id, _)| !self.doors.hides(ObjectRef::Body(*id)));
            // Not around one's own head.
            let drawn = |id| self.fly.is_some() || id != self.player || self.draws_player();
            for (_, body) in shown.filter(|(id, _)| drawn(*id)) {
                marks.body(body);
            }
        }
        if self.fly.is_some() {
            self.mark_frozen_eye(&mut marks);
        }
        marks.list
    }

    /// Where the held traversal looked from: its eye and the corners of its screen.
    fn mark_frozen_eye(&self, marks: &mut Marks<'_>) {
        let (Some(held), Some(camera)) = (self.frame.camera(), self.camera()) else {
            return;
        };
        let eye = held.eye_in(camera.cell().block()) - camera.eye();
        let size = held.viewport();
        let corner = |x: f32, y: f32| eye + held.ray_through(Vec2::new(x, y)).normalize_or_zero() * 4.0;
        let corners = [
            corner(0.0, 0.0),
            corner(size.x, 0.0),
            corner(size.x, size.y),
            corner(0.0, size.y),
        ];
        for c in corners {
            marks.line(eye, c, [255, 255, 255, 230], 2.0);
        }
        marks.polygon(&corners, [255, 255, 255, 230], 2.0, [255, 255, 255, 18]);
        marks.label(eye, "eye", [255, 255, 255]);
    }

    /// Finds out what is at a pixel.
    pub fn pick(&mut self, pixel: Vec2) {
        let Some(camera) = self.camera() else { return };
        let input = match (&self.fly, self.input) {
            (None, Some(input)) => FrameInput { camera, ..input },
            _ => FrameInput::new(camera),
        };
        let doors = &self.doors;
        let hidden = |c: &Command| matches!(c, Command::Object { id, .. } if doors.hides(*id));
        let mut found = pick(&self.scene(), &self.openings, &input, hidden, pixel);
        if let Some(found) = &mut found {
            found.portals = portals::along(&self.world, &self.frame, &camera, pixel);
        }
        self.picked = found;
    }
}
