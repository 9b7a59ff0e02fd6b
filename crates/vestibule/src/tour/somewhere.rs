//! Trials in a world that nothing is known of: with what can be found in it.

use glam::Vec2;
use vestibule_dat::{DatSet, RecordKind};
use vestibule_world::BlockId;

use super::Tour;
use super::start::inside;
use super::trial::PACE;
use crate::walker::Walker;

/// Directions that are tried in a room.
const HEADINGS: [Vec2; 4] = [Vec2::X, Vec2::Y, Vec2::NEG_X, Vec2::NEG_Y];
/// Landblocks with cells that are looked at for a dungeon.
const MAX_BLOCKS: usize = 2000;
/// A change of height that is worth telling of, metres.
const CLIMB: f32 = 0.5;
/// Speed of a jump, m/s.
const JUMP: f32 = 4.0;
/// Ticks after which a jump has shown that there is room, and how high it is then at least, metres.
const ROOM_TICKS: u32 = 4;
/// A jump rises at least this high, metres.
const MIN_RISE: f32 = 0.05;

impl Tour<'_, '_> {
    /// All trials that this world has something for.
    pub(super) fn try_somewhere(&mut self, dats: &DatSet) {
        self.try_found_walls();
        self.tell_of_heights();
        self.try_jump();
        for (trial, expected) in [
            ("ridge, too steep to walk", "is turned back on its slope"),
            ("door that is shut, then open", "stops before it, then passes"),
        ] {
            self.not_present(trial, expected, "not looked for outside the embedded world");
        }
        self.try_found_dungeon(dats);
    }

    fn try_found_walls(&mut self) {
        let rooms = self.rooms.clone();
        let ticks = 120;
        let found = rooms.iter().find_map(|room| {
            HEADINGS.into_iter().find_map(|heading| {
                let far = self.would_stop(room, heading * PACE, ticks)?;
                (far > 0.3).then_some((*room, heading))
            })
        });
        let (head_on, slant) = ("wall, head on", "wall, at a slant");
        let (stops, slides) = ("stops before it, in its cell", "slides along it");
        let Some((room, heading)) = found else {
            self.not_present(head_on, stops, "no room with a wall to walk into was visited");
            self.not_present(slant, slides, "no room with a wall to walk into was visited");
            return;
        };
        self.attempt(head_on, stops, Some(room.at), |tour| {
            let walked = tour.push(heading * PACE, ticks);
            (
                walked.stopped && walked.one_cell(),
                format!("stopped after {:.2} m", walked.along(heading)),
            )
        });
        let aside = Vec2::new(-heading.y, heading.x);
        self.attempt(slant, slides, Some(room.at), |tour| {
            let to_wall = tour.push(heading * PACE, ticks);
            let (left, right) = ((heading + aside) * 0.7 * PACE, (heading - aside) * 0.7 * PACE);
            let slid = tour.push(left, 30);
            let slid = if slid.path < 0.2 {
                tour.push(right, 30)
            } else {
                slid
            };
            let into = slid.along(heading);
            (
                slid.path > 0.2 && into < 0.7 * slid.path,
                format!(
                    "{:.2} m to the wall, then {:.2} m along it",
                    to_wall.along(heading),
                    slid.path
                ),
            )
        });
    }

    /// What the tour has climbed and fallen so far.
    fn tell_of_heights(&mut self) {
        let (mut low, mut best) = (f32::INFINITY, 0.0f32);
        let mut before = None;
        for step in &self.trail {
            let broken = step.teleported
                || !step.cell.is_indoor()
                || before.is_some_and(|z: f32| (z - step.pos.z).abs() > 0.65);
            low = if broken || step.pos.z < low {
                step.pos.z
            } else {
                low
            };
            best = best.max(step.pos.z - low);
            before = Some(step.pos.z);
        }
        let (trial, expected) = ("stairs or ramps", "climbs from floor to floor");
        if best > CLIMB {
            self.report_after(
                trial,
                expected,
                format!("climbed up to {best:.2} m indoors in one go"),
                true,
            );
        } else {
            self.not_present(trial, expected, "none was walked on");
        }
        let (trial, expected) = ("drops", "falls and stands at the bottom");
        match self.summary.falls {
            0 => self.not_present(trial, expected, "none was found"),
            falls => self.report_after(trial, expected, format!("{falls} taken"), true),
        }
    }

    fn try_jump(&mut self) {
        let (trial, expected) = ("jump", "rises, lands where it was, in the same cell");
        let mut places = vec![self.outside];
        places.extend(self.rooms.iter().copied());
        // Where there is room to rise at all: worlds have doorways that a hill reaches into.
        let place = places.into_iter().find(|place| {
            let mut now = self.walker.jump(place, JUMP);
            for _ in 0..ROOM_TICKS {
                now = self.walker.step(&now, Vec2::ZERO);
            }
            let up = self.walker.point(&now.at).z - self.walker.point(&place.at).z;
            (MIN_RISE..1.0).contains(&up)
        });
        let Some(place) = place else {
            self.not_present(trial, expected, "no place with room to jump was visited");
            return;
        };
        self.attempt(trial, expected, Some(place.at), |tour| {
            let walked = tour.leap(JUMP, Vec2::ZERO);
            let up = walked.highest - walked.from.z;
            (
                up > MIN_RISE && walked.one_cell() && walked.rise().abs() < 0.05,
                format!("rose {up:.2} m"),
            )
        });
    }

    fn try_found_dungeon(&mut self, dats: &DatSet) {
        let world = self.walker.world();
        let blocks = dats
            .cell()
            .iter()
            .filter_map(Result::ok)
            .filter(|entry| RecordKind::of_cell_id(entry.id) == RecordKind::LandBlockInfo)
            .map(|entry| BlockId((entry.id >> 16) as u16));
        let here = self.footing.at.cell.block();
        let mut found = None;
        for id in blocks.filter(|&id| id != here).take(MAX_BLOCKS) {
            let is_dungeon = world.block(id).is_some_and(|block| {
                block.buildings.is_empty() && block.env_cells().any(|cell| !cell.portals.is_empty())
            });
            if is_dungeon {
                found = inside(&mut Walker::new(world, id), id);
                if found.is_some() {
                    break;
                }
            }
        }
        let (trial, expected) = (
            "teleport to a dungeon",
            "arrives in a cell of it, and stays in it",
        );
        let Some(place) = found else {
            self.not_present(trial, expected, "this world has no dungeon that one can stand in");
            return;
        };
        self.attempt(trial, expected, Some(place.at), |tour| {
            let stood = tour.wait(30);
            (
                stood.one_cell() && tour.footing.at.cell == place.at.cell,
                "arrived".to_owned(),
            )
        });
    }
}
