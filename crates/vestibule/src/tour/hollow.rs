//! The trials of the embedded world (`worlds/hollow` of `vestibule-forge`): its walls, stairs, ramps, doors, its pit,
//! its ridge and its dungeon. Places are metres from the south-west corner of landblock 0xA9B4, as in the scene.

use glam::{Vec2, Vec3};
use vestibule_world::constants::FLOOR_Z;
use vestibule_world::{BlockId, CellId, Position};

use super::trial::PACE;
use super::{Guide, Tour};

/// The landblock that places are given in.
const VILLAGE: BlockId = BlockId(0xA9B4);
/// Half the width of a player, metres: how near its middle comes to a wall.
const REACH: f32 = 0.48;

/// A point of the cottage's plan in the scene, which is turned by half a circle.
fn cottage(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(161.929 - x, 7.503_15 - y, 94.0 + z)
}

/// A point of the mine's plan.
fn mine(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(14.0 + x, 108.0 + y, 96.2 + z)
}

impl Tour<'_, '_> {
    fn on_land(&self, x: f32, y: f32) -> Option<Position> {
        let land = CellId::new(VILLAGE, 0xFFFF);
        let ground = self.walker.world().ground_at(land, Vec3::new(x, y, 0.0))?;
        Some(Position::new(
            ground.cell,
            ground.point.truncate().extend(ground.z + 0.01),
        ))
    }

    /// A point of the village's landblock in the frame of the routes.
    fn routes(&self, point: Vec3) -> Vec2 {
        self.walker
            .point(&Position::new(CellId::new(VILLAGE, 1), point))
            .truncate()
    }

    /// All trials.
    pub(super) fn try_hollow(&mut self, guide: &Guide) {
        let inside = |name: &str, at: Vec3| guide.cell(name).map(|cell| Position::new(cell, at));
        self.try_walls(guide, &inside);
        self.try_heights(guide, &inside);
        self.try_doors(guide, &inside);
        self.try_land();
        self.try_dungeon(guide);
    }

    fn try_walls(&mut self, guide: &Guide, inside: &dyn Fn(&str, Vec3) -> Option<Position>) {
        // North in the village is south in the cottage.
        self.attempt(
            "wall, head on",
            "stops half a body before it, in its cell",
            inside("cottage.side", cottage(12.0, -5.5, 0.01)),
            |tour| {
                let walked = tour.push(Vec2::Y * PACE, 90);
                let gone = walked.along(Vec2::Y);
                // The last step, which would have gone in, is not taken.
                let left = (7.65 - 5.5 - REACH) - gone;
                let short = left > -0.001 && left < PACE;
                (
                    short && walked.stopped && walked.one_cell(),
                    format!("stopped after {gone:.2} m"),
                )
            },
        );
        self.attempt(
            "wall, at a slant",
            "slides along it into the corner, in its cell",
            inside("cottage.side", cottage(14.0, -6.2, 0.01)),
            |tour| {
                let walked = tour.push(Vec2::new(0.8, 0.6) * PACE, 120);
                let (along, into) = (walked.along(Vec2::X), walked.along(Vec2::Y));
                let slid = along > 2.5 && (into - (7.65 - 6.2 - REACH)).abs() < 0.02;
                (
                    slid && walked.stopped && walked.one_cell(),
                    format!(
                        "{into:.2} m to the wall, then {:.2} m along it",
                        along - into * 4.0 / 3.0
                    ),
                )
            },
        );
        self.attempt(
            "wall of a house, outside",
            "slides along the front to the porch, stays outdoors",
            self.on_land(147.2, 18.0),
            |tour| {
                let walked = tour.push(Vec2::new(0.6, -0.8) * PACE, 150);
                let along = walked.along(Vec2::X);
                (
                    walked.outdoors() && walked.stopped && along > 4.0,
                    format!(
                        "slid {along:.2} m along the wall, {} land cell(s)",
                        walked.cells.len()
                    ),
                )
            },
        );
        self.attempt(
            "wall between two rooms that touch",
            "neither side leads to the other",
            inside("mine.west_corner", mine(-28.0, 11.0, -4.99)),
            |tour| {
                let east = tour.push(-Vec2::X * PACE, 90);
                let from = inside("mine.vault", mine(-31.0, 13.2, -4.99)).and_then(|at| tour.walker.put(&at));
                let Some(from) = from else {
                    return (false, "nobody can stand in the vault".to_owned());
                };
                tour.teleport(from);
                let west = tour.push(Vec2::X * PACE, 90);
                let names = format!(
                    "stayed in {} and {}",
                    guide.name(east.cells[0]),
                    guide.name(west.cells[0])
                );
                (
                    east.one_cell() && west.one_cell() && east.stopped && west.stopped,
                    names,
                )
            },
        );
    }

    fn try_heights(&mut self, guide: &Guide, inside: &dyn Fn(&str, Vec3) -> Option<Position>) {
        let ends_in = |tour: &Self, name: &str| guide.cell(name) == Some(tour.footing.at.cell);
        self.attempt(
            "stairs, up",
            "climbs 2.8 m into the loft",
            inside("cottage.hall", cottage(9.4, -6.2, 0.01)),
            |tour| {
                let [foot, top] = [(9.4, 0.0), (3.5, 2.8)].map(|(x, z)| tour.routes(cottage(x, -4.3, z)));
                let walked = tour.walk_to(foot, 60);
                let walked = walked.then(tour.walk_to(top, 200));
                let up = walked.rise();
                (
                    (up - 2.8).abs() < 0.05 && ends_in(tour, "cottage.loft"),
                    format!("climbed {up:.2} m"),
                )
            },
        );
        self.attempt(
            "stairs, down",
            "back in the hall, never in the air",
            inside("cottage.loft", cottage(3.5, -4.3, 2.81)),
            |tour| {
                let walked = tour.walk_to(tour.routes(cottage(9.55, -4.3, 0.0)), 200);
                let down = -walked.rise();
                (
                    (down - 2.8).abs() < 0.05 && ends_in(tour, "cottage.hall"),
                    format!("came down {down:.2} m"),
                )
            },
        );
        self.attempt(
            "ramp, down under the meadow",
            "into the cellar, 2.4 m down",
            inside("cottage.side", cottage(14.0, -6.9, 0.01)),
            |tour| {
                let walked = tour.walk_to(tour.routes(cottage(14.0, 1.0, -2.4)), 200);
                let stood = tour.wait(100);
                let down = -walked.rise();
                (
                    (down - 2.4).abs() < 0.05 && ends_in(tour, "cottage.cellar") && stood.one_cell(),
                    format!("came down {down:.2} m and stood there for 100 ticks"),
                )
            },
        );
        self.attempt(
            "jump under a low ceiling",
            "the head stops at the ceiling, the cell stays",
            inside("cottage.cellar", cottage(13.0, 2.4, -2.39)),
            |tour| {
                let walked = tour.leap(5.0, Vec2::ZERO);
                let up = walked.highest - walked.from.z;
                (
                    up < 0.5 && up > 0.2 && walked.one_cell() && walked.rise().abs() < 0.02,
                    format!("rose {up:.2} m under a ceiling of 2.2 m"),
                )
            },
        );
        let bridge = inside("mine.pit", mine(0.0, 12.0, -4.99));
        self.attempt(
            "edge of a bridge, walking",
            "is held at the edge",
            bridge,
            |tour| {
                let walked = tour.push(Vec2::Y * PACE, 60);
                let gone = walked.along(Vec2::Y);
                (
                    walked.stopped && gone < 1.5 && walked.rise().abs() < 0.05 && walked.one_cell(),
                    format!("stopped after {gone:.2} m, {:.2} m beyond the edge", gone - 1.0),
                )
            },
        );
        self.attempt(
            "edge of the same bridge, jumping",
            "falls 6 m into the pit and stands",
            bridge,
            |tour| {
                let walked = tour
                    .push(Vec2::Y * PACE, 5)
                    .then(tour.leap(1.5, Vec2::Y * PACE * 0.5));
                let fell = -walked.rise();
                let name = guide.name(tour.footing.at.cell);
                (
                    (fell - 6.0).abs() < 0.05 && tour.footing.is_standing() && name.starts_with("mine.pit"),
                    format!("fell {fell:.2} m"),
                )
            },
        );
        self.attempt(
            "ramp, up out of the pit",
            "climbs 6 m back to the bridge's level",
            inside("mine.pit", mine(-5.4, 14.0, -10.99)),
            |tour| {
                let foot = tour.walk_to(tour.routes(mine(-5.4, 8.0, -11.0)), 120);
                let walked = foot.then(tour.walk_to(tour.routes(mine(6.0, 8.0, -5.0)), 250));
                let up = walked.rise();
                ((up - 6.0).abs() < 0.05, format!("climbed {up:.2} m"))
            },
        );
    }

    fn try_doors(&mut self, guide: &Guide, inside: &dyn Fn(&str, Vec3) -> Option<Position>) {
        self.attempt(
            "gate that is shut",
            "stops before it, in its cell",
            inside("mine.gate_tunnel", mine(-18.6, 24.0, -4.99)),
            |tour| {
                let walked = tour.push(-Vec2::X * PACE, 90);
                let gone = walked.along(-Vec2::X);
                (
                    gone < 2.4 && walked.stopped && walked.one_cell(),
                    format!("stopped after {gone:.2} m"),
                )
            },
        );
        let hinge = cottage(5.6, -7.6, 0.0);
        let hall = guide.cell("cottage.hall");
        let leaf = hall.and_then(|hall| {
            let world = self.walker.world();
            let statics = world
                .statics_in(hall)
                .iter()
                .filter_map(|&r| world.static_object(r));
            // The cottage's own door, which stands open at the other side of the opening.
            let own = cottage(7.4, -7.6, 0.0);
            statics.min_by(|a, b| {
                a.frame
                    .origin
                    .distance(own)
                    .total_cmp(&b.frame.origin.distance(own))
            })
        });
        let frame = vestibule_world::Frame::new(hinge, super::facing(core::f32::consts::PI));
        let door = match (hall, leaf) {
            (Some(cell), Some(leaf)) => self
                .walker
                .add_door(leaf.shape.clone(), &Position { cell, frame }),
            _ => None,
        };
        let Some(door) = door else {
            self.not_present("door that is shut", "stops before it", "there is no door");
            return;
        };
        let before = self.on_land(155.53, 17.6);
        self.attempt(
            "door that is shut",
            "stops before it, does not enter the hall",
            before,
            |tour| {
                let walked = tour.push(-Vec2::Y * PACE, 90);
                let gone = walked.along(-Vec2::Y);
                let entered = walked.cells.iter().any(|&cell| hall == Some(cell));
                (
                    walked.stopped && !entered && gone > 1.0,
                    format!("stopped after {gone:.2} m"),
                )
            },
        );
        self.walker.set_open(door, true);
        self.attempt(
            "the same door, opened",
            "walks through into the hall",
            before,
            |tour| {
                let walked = tour.push(-Vec2::Y * PACE, 30);
                let gone = walked.along(-Vec2::Y);
                (
                    hall == Some(tour.footing.at.cell) && gone > 3.0,
                    format!("walked {gone:.2} m"),
                )
            },
        );
        self.walker.remove_door(door);
    }

    fn try_land(&mut self) {
        self.attempt(
            "fence, walking",
            "stops before it",
            self.on_land(137.5, 13.0),
            |tour| {
                let walked = tour.push(Vec2::X * PACE, 60);
                let gone = walked.along(Vec2::X);
                (
                    gone < 2.2 && walked.stopped && walked.outdoors(),
                    format!("stopped after {gone:.2} m"),
                )
            },
        );
        self.attempt(
            "fence, jumping",
            "lands behind it",
            self.on_land(136.5, 13.0),
            |tour| {
                let before = tour.push(Vec2::X * PACE, 14);
                let walked = before.then(tour.leap(5.0, Vec2::X * PACE));
                let (gone, up) = (walked.along(Vec2::X), walked.highest - walked.from.z);
                (
                    gone > 4.2 && up > 1.0 && walked.outdoors(),
                    format!("rose {up:.2} m, landed {gone:.2} m on"),
                )
            },
        );
        self.attempt(
            "ridge, too steep to walk",
            "is turned back on its slope",
            self.on_land(250.0, 40.0),
            |tour| {
                let walked = tour.push(Vec2::X * PACE, 450);
                let (gone, up) = (walked.along(Vec2::X), walked.rise());
                let contact = tour.footing.carried.contact;
                let stands = contact.is_some_and(|contact| contact.plane.normal.z >= FLOOR_Z);
                // Its crest is 38 m on and over 20 m up.
                (
                    gone < 25.0 && stands && walked.outdoors(),
                    format!("got {gone:.1} m further and {up:.1} m up"),
                )
            },
        );
    }

    fn try_dungeon(&mut self, guide: &Guide) {
        let arrival = guide.cell("deep.arrival");
        let to = arrival.map(|cell| Position::new(cell, Vec3::new(60.0, -80.0, -19.99)));
        self.attempt(
            "teleport to the dungeon",
            "arrives in its first hall, sees no sky",
            to,
            |tour| {
                let stood = tour.wait(30);
                let list = tour
                    .looks
                    .last()
                    .and_then(|look| tour.eyes.as_ref()?.lists().get(look.list));
                let sky = list.is_some_and(|list| list.outside);
                let rooms = list.map_or(0, |list| list.rooms.len());
                let here = arrival == Some(tour.footing.at.cell) && stood.one_cell();
                (
                    here && !sky,
                    format!(
                        "arrived; {rooms} rooms in view, {}",
                        if sky { "and the sky" } else { "no sky" }
                    ),
                )
            },
        );
        let before = self.entered.len();
        self.stops = true;
        if let Some(cell) = arrival.filter(|&cell| cell == self.footing.at.cell) {
            self.visit(cell);
        }
        self.stops = false;
        let met = self.entered.len() - before;
        let all = guide
            .names
            .values()
            .filter(|name| name.starts_with("deep."))
            .count();
        let expected = "every cell of the dungeon is walked through";
        let outcome = format!("{} of {all} cells", met + 1);
        self.report_after("the dungeon on foot", expected, outcome, met + 1 == all);
    }
}
