//! Buildings, dungeons and their rooms.

use glam::{DQuat, DVec2, DVec3};
use vestibule_world::BlockId;

use super::read::Reader;
use super::read_solid::polygon;
use super::{
    Exit, Fixture, Kind, Link, Opening, Paint, PlaceDef, Placement, RoomDef, ShellDef, SiteDef, SolidDef,
};
use crate::geometry::Polytope;
use crate::text::{Above, Args, Skip, Statement, Word};

const SITE_KEYWORDS: &[&str] = &[
    "shell", "room", "opening", "portal", "exit", "window", "static", "door",
];
const ROOM_KEYWORDS: &[&str] = &[
    "box", "prism", "hull", "ramp", "wedge", "column", "poly", "floor", "walls", "ceiling", "material",
    "face", "block", "stairs",
];

/// What a room is made of; a `shape` is a room body with a name.
#[derive(Clone, Debug)]
pub(super) struct RoomBody {
    solids: Vec<SolidDef>,
    fixtures: Vec<Fixture>,
    paint: Paint,
}

impl RoomBody {
    fn new() -> Self {
        RoomBody {
            solids: Vec::new(),
            fixtures: Vec::new(),
            paint: Paint::plain(0),
        }
    }
}

impl Reader<'_> {
    pub(super) fn shape(&mut self, s: &Statement) -> Result<(), Skip> {
        let mut args = Args::new(s, "shape NAME { … }");
        let name = args.word("a name", self.messages)?;
        args.end(self.messages)?;
        let body = self.room_body(s, RoomBody::new(), &name);
        self.shapes.insert(name.text, body);
        Ok(())
    }

    pub(super) fn site(&mut self, s: &Statement) -> Result<SiteDef, Skip> {
        let building = s.keyword.text == "building";
        let usage = match building {
            true => "building NAME at (x y ~z) [turn DEGREES] { … }",
            false => "dungeon NAME 0xXXYY [at (x y z)] { … }",
        };
        let mut args = Args::new(s, usage);
        let name = args.word("a name", self.messages)?;
        let kind = match building {
            true => Kind::Building,
            false => Kind::Dungeon(BlockId(args.hex("its landblock, as 0x0107,", self.messages)?)),
        };
        if let Kind::Dungeon(block) = kind
            && !block.is_on_map()
        {
            let message = format!("landblock {block} is not on the map");
            self.messages
                .error(args.keyword_span(), message, "use 0x0000 to 0xFEFE");
            return Err(Skip);
        }
        let place = if args.more() {
            self.place(&mut args)?
        } else {
            let height = Above {
                metres: 0.0,
                ground: false,
            };
            PlaceDef {
                at: DVec2::ZERO,
                height,
                rotation: DQuat::IDENTITY,
                span: name.span,
            }
        };
        args.end(self.messages)?;
        let mut site = SiteDef {
            name,
            kind,
            place,
            shell: None,
            rooms: Vec::new(),
            links: Vec::new(),
            exits: Vec::new(),
            statics: Vec::new(),
        };
        for s in s.block.iter().flatten() {
            let _ = self.site_statement(s, &mut site);
        }
        Ok(site)
    }

    fn site_statement(&mut self, s: &Statement, site: &mut SiteDef) -> Result<(), Skip> {
        match s.keyword.text.as_str() {
            "shell" => {
                Args::new(s, "shell { … }").end(self.messages)?;
                let mut shell = ShellDef {
                    solids: Vec::new(),
                    paint: Paint::plain(0),
                };
                for s in s.block.iter().flatten() {
                    let _ = self.shell_statement(s, &mut shell);
                }
                site.shell = Some(shell);
                Ok(())
            }
            "room" => {
                let room = self.room(s)?;
                if let Some(other) = site.rooms.iter().find(|r| r.name.text == room.name.text) {
                    let message = format!("a second room named `{}`", room.name.text);
                    let help = format!(
                        "the first is in line {}; give this one another name",
                        other.name.span.line
                    );
                    self.messages.error(room.name.span, message, help);
                }
                site.rooms.push(room);
                Ok(())
            }
            "opening" | "portal" => {
                let usage = match s.keyword.text.as_str() {
                    "opening" => "opening ROOM ROOM [rect (x y z) (x y z) | poly (x y z) …]",
                    _ => "portal ROOM ROOM [rect (x y z) (x y z) | poly (x y z) …]",
                };
                let mut args = Args::new(s, usage);
                let (from, to) = (
                    args.word("a room", self.messages)?,
                    args.word("a room", self.messages)?,
                );
                let opening = self.opening(s, &mut args)?;
                let one_way = s.keyword.text == "portal";
                site.links.push(Link {
                    span: s.keyword.span,
                    from,
                    to,
                    opening,
                    one_way,
                });
                Ok(())
            }
            "exit" | "window" => {
                let mut args = Args::new(s, "exit ROOM [rect (x y z) (x y z) | poly (x y z) …]");
                let from = args.word("a room", self.messages)?;
                let opening = self.opening(s, &mut args)?;
                let pane = s.keyword.text == "window";
                site.exits.push(Exit {
                    span: s.keyword.span,
                    from,
                    opening,
                    pane,
                });
                Ok(())
            }
            "static" | "door" => {
                let object = self.static_object(s, true)?;
                site.statics.push(object);
                Ok(())
            }
            _ => Err(self.unknown(&s.keyword, SITE_KEYWORDS, "a site")),
        }
    }

    fn shell_statement(&mut self, s: &Statement, shell: &mut ShellDef) -> Result<(), Skip> {
        if let Some(solid) = self.solid(s)? {
            shell.solids.push(solid);
            return Ok(());
        }
        if self.solid_paint(s, &mut shell.paint)? {
            return Ok(());
        }
        let known = [
            "box", "prism", "hull", "column", "cone", "ball", "ramp", "wedge", "poly", "material", "sides",
            "top", "bottom", "face",
        ];
        Err(self.unknown(&s.keyword, &known, "a shell"))
    }

    /// `rect (corner) (corner)` in a plane of the axes, `poly (p) (p) (p) …`, or nothing.
    fn opening(&mut self, s: &Statement, args: &mut Args<'_>) -> Result<Opening, Skip> {
        let opening = if args.accept("rect") {
            let (a, b) = (args.point3(self.messages)?, args.point3(self.messages)?);
            let d = b - a;
            let flat = |n: f64| n.abs() < 1.0e-6;
            let (u, v) = match (flat(d.x), flat(d.y), flat(d.z)) {
                (true, false, false) => (DVec3::Y * d.y, DVec3::Z * d.z),
                (false, true, false) => (DVec3::X * d.x, DVec3::Z * d.z),
                (false, false, true) => (DVec3::X * d.x, DVec3::Y * d.y),
                _ => {
                    let help =
                        "its two corners must agree in exactly one of x, y, z; use poly for slanted openings";
                    self.messages.error(
                        args.keyword_span(),
                        "this rectangle is not upright or level",
                        help,
                    );
                    return Err(Skip);
                }
            };
            Opening::Polygon(polygon(s, vec![a, a + u, a + u + v, a + v], self.messages)?)
        } else if args.accept("poly") {
            let points = args.points3(3, self.messages)?;
            Opening::Polygon(polygon(s, points, self.messages)?)
        } else {
            Opening::Shared
        };
        args.end(self.messages)?;
        Ok(opening)
    }

    fn room(&mut self, s: &Statement) -> Result<RoomDef, Skip> {
        let mut args = Args::new(
            s,
            "room NAME [SHAPE] [id 0xNNNN] [at (x y z)] [turn DEGREES] { … }",
        );
        let name = args.word("a name", self.messages)?;
        let (mut body, mut id) = (RoomBody::new(), None);
        let mut place = Placement::IDENTITY;
        // `at`, `turn` and so on start the place; what is not a keyword is a shape.
        while args.more() {
            let span = args.span();
            if args.accept("id") {
                id = Some((span, args.hex("a cell number, as 0x0100,", self.messages)?));
            } else if args.accept("like") {
                let word = args.word("a shape", self.messages)?;
                body = match self.shapes.get(&word.text) {
                    Some(body) => body.clone(),
                    None => {
                        let message = format!("there is no shape `{}`", word.text);
                        let help = format!("define it: shape {} {{ … }}", word.text);
                        self.messages.error(word.span, message, help);
                        return Err(Skip);
                    }
                };
            } else {
                let def = self.place(&mut args)?;
                if def.height.ground {
                    let help = "rooms stand in the coordinates of their site; use `~` on the site itself";
                    self.messages
                        .error(span, "a room cannot stand above the ground", help);
                    return Err(Skip);
                }
                place = def.resolve(|_| 0.0);
                args.end(self.messages)?;
            }
        }
        let RoomBody {
            solids,
            fixtures,
            paint,
        } = self.room_body(s, body, &name);
        Ok(RoomDef {
            name,
            id,
            place,
            solids,
            fixtures,
            paint,
        })
    }

    fn room_body(&mut self, s: &Statement, mut body: RoomBody, name: &Word) -> RoomBody {
        let mut complete = true;
        for s in s.block.iter().flatten() {
            complete &= self.room_statement(s, &mut body).is_ok();
        }
        if body.solids.is_empty() && complete {
            let message = format!("room `{}` has no shape", name.text);
            self.messages.error(
                name.span,
                message,
                "add a box, prism, hull, ramp or polygons to it",
            );
        }
        body
    }

    fn room_statement(&mut self, s: &Statement, body: &mut RoomBody) -> Result<(), Skip> {
        if let Some(solid) = self.solid(s)? {
            body.solids.push(solid);
            return Ok(());
        }
        if self.room_paint(s, &mut body.paint)? {
            return Ok(());
        }
        match s.keyword.text.as_str() {
            "block" => {
                Args::new(s, "block { … }").end(self.messages)?;
                let mut solids = Vec::new();
                let mut paint = body.paint.clone();
                let mut painted = false;
                for s in s.block.iter().flatten() {
                    match self.solid(s)? {
                        Some(solid) => solids.push(solid),
                        None if self.solid_paint(s, &mut paint)? => painted = true,
                        None => return Err(self.unknown(&s.keyword, &["box", "material"], "a block")),
                    }
                }
                for solid in &mut solids {
                    if painted {
                        solid.all = solid.all.or(Some(paint.side));
                        solid.top = solid.top.or(Some(paint.up));
                    }
                }
                body.fixtures.push(Fixture {
                    draw: solids.clone(),
                    physics: solids,
                });
                Ok(())
            }
            "stairs" => {
                let fixture = self.stairs(s)?;
                body.fixtures.push(fixture);
                Ok(())
            }
            _ => Err(self.unknown(&s.keyword, ROOM_KEYWORDS, "a room")),
        }
    }

    /// Steps that fill a box, rising towards a side. Feet glide over a ramp along the edges of the steps.
    fn stairs(&mut self, s: &Statement) -> Result<Fixture, Skip> {
        let usage = "stairs (x y z) (x y z) east|north|west|south STEPS [rough] [MATERIAL]";
        let mut args = Args::new(s, usage);
        let (a, b) = (args.point3(self.messages)?, args.point3(self.messages)?);
        let (low, high) = (a.min(b), a.max(b));
        let direction = args.word("the direction in which they rise", self.messages)?;
        let axis = match direction.text.as_str() {
            "east" => DVec3::X,
            "west" => DVec3::NEG_X,
            "north" => DVec3::Y,
            "south" => DVec3::NEG_Y,
            _ => return Err(self.unknown(&direction, &["east", "north", "west", "south"], "stairs")),
        };
        let steps = args
            .number("the number of steps", self.messages)?
            .clamp(1.0, 100.0) as usize;
        let rough = args.accept("rough");
        let all = match args.any_word() {
            Some(word) => Some(self.material_named(&word)?),
            None => None,
        };
        args.end(self.messages)?;
        let size = high - low;
        let (length, rise) = (axis.abs().dot(size), size.z / steps as f64);
        let run = length / steps as f64;
        if rise <= 0.0 || run <= 0.0 || size.min_element() <= 0.0 {
            self.messages.error(
                s.keyword.span,
                "these stairs are flat",
                "give their box a length, width and height",
            );
            return Err(Skip);
        }
        if rise > run * 1.12 {
            let message = format!(
                "these stairs rise {:.0} cm on {:.0} cm: too steep to walk",
                rise * 100.0,
                run * 100.0
            );
            self.messages.warning(
                s.keyword.span,
                message,
                "make them longer: at most 48 degrees can be walked",
            );
        }
        // From the lower end, across the stairs.
        let foot = DVec3::new(
            if axis.x < 0.0 { high.x } else { low.x },
            if axis.y < 0.0 { high.y } else { low.y },
            low.z,
        );
        let across = DVec3::new(axis.y.abs() * size.x, axis.x.abs() * size.y, 0.0);
        let point = |along: f64, z: f64| foot + axis * along + DVec3::Z * z;
        let solid = |part: Option<Polytope>| {
            part.map(|part| SolidDef {
                parts: vec![part],
                all,
                ..SolidDef::new()
            })
        };
        let step = |k: usize| {
            let (from, to) = (k as f64 * run, (k + 1) as f64 * run);
            Polytope::cuboid(point(from, 0.0), point(to, (k + 1) as f64 * rise) + across)
        };
        let draw: Vec<SolidDef> = (0..steps).filter_map(|k| solid(step(k))).collect();
        let physics = if rough {
            draw.clone()
        } else {
            let profile = [
                (-run, 0.0),
                (length - run, size.z),
                (length, size.z),
                (length, 0.0),
            ];
            let points = profile
                .iter()
                .flat_map(|&(x, z)| [point(x, z), point(x, z) + across]);
            solid(Polytope::hull(&points.collect::<Vec<_>>()))
                .into_iter()
                .collect()
        };
        Ok(Fixture { draw, physics })
    }
}
