//! What keys do once.

use vestibule_view::CameraMode;

use super::{Explorer, Show, clock};
use crate::doors::DoorOutcome;
use crate::fly::FlyCamera;
use crate::keys::Action;
use crate::overlays::Overlay;

/// The share of a day that a key changes the time by: an hour.
const HOUR: f32 = 1.0 / 24.0;

impl Explorer {
    /// Does what a key asks for once.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::Help => self.show_help = !self.show_help,
            Action::Panels => self.show_panels = !self.show_panels,
            Action::Map => self.show_map = !self.show_map,
            Action::Overlay(k) => {
                if let (Some(on), Some(overlay)) = (self.overlays.get_mut(k), Overlay::ALL.get(k)) {
                    *on = !*on;
                    let text = format!("{} {}", overlay.name(), if *on { "on" } else { "off" });
                    self.tell(text);
                }
            }
            Action::Freeze => self.freeze(),
            Action::SingleCell => {
                self.show = if self.show == Show::SingleCell {
                    Show::Reached
                } else {
                    Show::SingleCell
                };
                self.single = None;
                self.tell(self.shown());
            }
            Action::Everything => {
                self.show = if self.show == Show::Everything {
                    Show::Reached
                } else {
                    Show::Everything
                };
                self.tell(self.shown());
            }
            Action::Door => self.door(),
            Action::FirstPerson => {
                let first = self.rig.camera.mode() == CameraMode::FirstPerson;
                let mode = if first {
                    CameraMode::Chase
                } else {
                    CameraMode::FirstPerson
                };
                self.rig.camera.set_mode(mode);
            }
            Action::Screenshot => self.wants_screenshot = true,
            Action::Time(step) => {
                let time = self.time_of_day + f32::from(step) * HOUR;
                self.time_of_day = time - libm::floorf(time);
                self.tell(format!("time of day {}", clock(self.time_of_day)));
            }
            Action::Teleport => self.typing = Some(String::new()),
            Action::Home => {
                let start = self.start;
                self.go_to(&start);
            }
            Action::Escape => self.escape(),
        }
    }

    fn shown(&self) -> &'static str {
        match self.show {
            Show::Reached => "drawing what the traversal reaches",
            Show::SingleCell => "drawing the player's cell only",
            Show::Everything => "drawing everything, no traversal",
        }
    }

    fn escape(&mut self) {
        if self.typing.take().is_some() {
        } else if self.show_help {
            self.show_help = false;
        } else if self.picked.take().is_some() {
        } else if self.fly.is_some() {
            self.freeze();
        } else {
            self.wants_to_leave = true;
        }
    }

    fn freeze(&mut self) {
        if self.fly.take().is_some() {
            self.tell("the traversal goes on");
        } else if let Some(camera) = self.frame.camera() {
            self.fly = Some(FlyCamera::from(camera));
            self.tell("the traversal is held: fly with W A S D, Space and C; G goes on");
        }
    }

    fn door(&mut self) {
        let Some(at) = self.body().map(|b| *b.position()) else {
            return;
        };
        let outcome = self
            .doors
            .toggle(&self.world, &mut self.population, &mut self.scratch, &at);
        self.tell(match outcome {
            DoorOutcome::Closed => "the door is closed",
            DoorOutcome::Opened => "the door is open",
            DoorOutcome::Blocked => "something stands in the door",
            DoorOutcome::None => "no door within reach",
        });
    }
}
