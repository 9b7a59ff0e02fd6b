//! Shapes and their paint.

use glam::{DVec2, DVec3};

use super::read::Reader;
use super::{Paint, SolidDef};
use crate::geometry::{Polygon, Polytope, convex_parts};
use crate::text::{Args, Messages, Skip, Statement};

/// Most corners of a hull: the search for its faces tries all triples.
const MAX_HULL: usize = 32;
/// Most corners of a prism's outline.
const MAX_OUTLINE: usize = 200;

impl Reader<'_> {
    /// Reads a shape statement; `None` when it is something else.
    pub(super) fn solid(&mut self, s: &Statement) -> Result<Option<SolidDef>, Skip> {
        let usage = match s.keyword.text.as_str() {
            "box" => "box (x y z) (x y z) [MATERIAL] [top MATERIAL]",
            "prism" => "prism z Z0 Z1 (x y) (x y) (x y) … (or: prism x X0 X1 (y z) …, prism y Y0 Y1 (x z) …)",
            "hull" => "hull (x y z) (x y z) (x y z) (x y z) …",
            "column" => "column (x y z) RADIUS HEIGHT [SIDES]",
            "cone" => "cone (x y z) RADIUS HEIGHT [SIDES]",
            "ball" => "ball (x y z) RADIUS [RADIUS_Y RADIUS_Z]",
            "ramp" => {
                "ramp (x y z) (x y z) east|north|west|south HEIGHT (from the low end's floor to the high end's)"
            }
            "wedge" => "wedge (x y z) (x y z) east|north|west|south",
            "poly" => "poly (x y z) (x y z) (x y z) …",
            _ => return Ok(None),
        };
        let mut args = Args::new(s, usage);
        let mut solid = SolidDef::new();
        self.solid_shape(s, &mut args, &mut solid)?;
        while let Some(word) = args.any_word() {
            if word.text == "top" {
                let word = args.word("a material", self.messages)?;
                solid.top = Some(self.material_named(&word)?);
            } else {
                solid.all = Some(self.material_named(&word)?);
            }
        }
        args.end(self.messages)?;
        Ok(Some(solid))
    }

    fn solid_shape(&mut self, s: &Statement, args: &mut Args<'_>, out: &mut SolidDef) -> Result<(), Skip> {
        let m = &mut *self.messages;
        let part = match s.keyword.text.as_str() {
            "box" => Polytope::cuboid(args.point3(m)?, args.point3(m)?),
            "prism" => {
                out.parts = prism(s, args, m)?;
                return Ok(());
            }
            "hull" => {
                let points = args.points3(4, m)?;
                if points.len() > MAX_HULL {
                    let message = format!("a hull of {} points", points.len());
                    m.error(
                        s.keyword.span,
                        message,
                        format!("use at most {MAX_HULL}, or several hulls"),
                    );
                    return Err(Skip);
                }
                Polytope::hull(&points)
            }
            "column" | "cone" => {
                let (foot, radius) = (args.point3(m)?, args.number("a radius", m)?);
                let height = args.number("a height", m)?;
                let sides = args.any_number().unwrap_or(8.0).clamp(3.0, 14.0) as usize;
                let mut points = ring(foot, DVec3::new(radius, radius, 0.0), sides);
                if s.keyword.text == "cone" {
                    points.push(foot + DVec3::Z * height);
                } else {
                    points.extend(ring(
                        foot + DVec3::Z * height,
                        DVec3::new(radius, radius, 0.0),
                        sides,
                    ));
                }
                Polytope::hull(&points)
            }
            "ball" => {
                let (center, x) = (args.point3(m)?, args.number("a radius", m)?);
                let (y, z) = match args.any_number() {
                    Some(y) => (y, args.number("the third radius", m)?),
                    None => (x, x),
                };
                let mut points = vec![center + DVec3::Z * z, center - DVec3::Z * z];
                for height in [-0.5, 0.5] {
                    let radius = DVec3::new(x, y, 0.0) * 0.866;
                    points.extend(ring(center + DVec3::Z * z * height, radius, 7));
                }
                Polytope::hull(&points)
            }
            "ramp" | "wedge" => {
                let (a, b) = (args.point3(m)?, args.point3(m)?);
                let (low, high) = (a.min(b), a.max(b));
                let direction = args.word("the direction in which it rises", m)?;
                let [near, far] = match direction.text.as_str() {
                    "east" => [[(0, 0), (0, 1)], [(1, 0), (1, 1)]],
                    "west" => [[(1, 0), (1, 1)], [(0, 0), (0, 1)]],
                    "north" => [[(0, 0), (1, 0)], [(0, 1), (1, 1)]],
                    "south" => [[(0, 1), (1, 1)], [(0, 0), (1, 0)]],
                    _ => return Err(self.unknown(&direction, &["east", "north", "west", "south"], "a ramp")),
                };
                let corner = |(x, y): (u8, u8), z: f64| {
                    DVec3::new(
                        if x == 0 { low.x } else { high.x },
                        if y == 0 { low.y } else { high.y },
                        z,
                    )
                };
                let mut points: Vec<DVec3> = near.map(|c| corner(c, low.z)).to_vec();
                points.extend(far.map(|c| corner(c, high.z)));
                if s.keyword.text == "ramp" {
                    let height = DVec3::Z * args.number("the height of the passage", m)?;
                    points.extend(points.clone().into_iter().map(|p| p + height));
                } else {
                    points.extend(far.map(|c| corner(c, low.z)));
                }
                Polytope::hull(&points)
            }
            _ => {
                let points = args.points3(3, m)?;
                out.polygons = vec![(s.keyword.span, polygon(s, points, m)?)];
                return Ok(());
            }
        };
        match part {
            Some(part) => out.parts.push(part),
            None => {
                let help = "its points must span a volume: all sizes above a tenth of a millimetre";
                m.error(s.keyword.span, format!("this {} is flat", s.keyword.text), help);
                return Err(Skip);
            }
        }
        Ok(())
    }

    /// Reads `material`, `top`, `sides`, `bottom`, `face` of a solid; false when it is something else.
    pub(super) fn solid_paint(&mut self, s: &Statement, paint: &mut Paint) -> Result<bool, Skip> {
        let known = ["material", "top", "sides", "bottom"];
        self.paint(s, paint, known)
    }

    /// Reads `material`, `floor`, `walls`, `ceiling`, `face` of a room.
    pub(super) fn room_paint(&mut self, s: &Statement, paint: &mut Paint) -> Result<bool, Skip> {
        let known = ["material", "floor", "walls", "ceiling"];
        self.paint(s, paint, known)
    }

    fn paint(
        &mut self,
        s: &Statement,
        paint: &mut Paint,
        [all, up, side, down]: [&str; 4],
    ) -> Result<bool, Skip> {
        let keyword = s.keyword.text.as_str();
        if keyword == "face" {
            let mut args = Args::new(
                s,
                "face (x y z) MATERIAL, where (x y z) is the way the face looks",
            );
            let direction = args.point3(self.messages)?;
            let word = args.word("a material", self.messages)?;
            let material = self.material_named(&word)?;
            paint.special.push((direction.normalize_or_zero(), material));
            args.end(self.messages)?;
            return Ok(true);
        }
        if ![all, up, side, down].contains(&keyword) {
            return Ok(false);
        }
        let mut args = Args::new(s, "KEYWORD MATERIAL, as: material stone");
        let word = args.word("a material", self.messages)?;
        let material = self.material_named(&word)?;
        args.end(self.messages)?;
        if keyword == all {
            *paint = Paint {
                special: paint.special.clone(),
                ..Paint::plain(material)
            };
        } else if keyword == up {
            paint.up = material;
        } else if keyword == side {
            paint.side = material;
        } else {
            paint.down = material;
        }
        Ok(true)
    }
}

fn ring(center: DVec3, radius: DVec3, sides: usize) -> Vec<DVec3> {
    (0..sides)
        .map(|k| {
            // Turned by half a side, so that a column of four sides is a square along the axes.
            let angle = (k as f64 + 0.5) / sides as f64 * core::f64::consts::TAU;
            center + DVec3::new(radius.x * libm::cos(angle), radius.y * libm::sin(angle), 0.0)
        })
        .collect()
}

fn prism(s: &Statement, args: &mut Args<'_>, m: &mut Messages) -> Result<Vec<Polytope>, Skip> {
    let axis = args.word("the axis x, y or z", m)?;
    let ends = (args.number("one end", m)?, args.number("the other end", m)?);
    let outline = args.points2(3, m)?;
    if outline.len() > MAX_OUTLINE {
        let message = format!("an outline of {} points", outline.len());
        m.error(
            s.keyword.span,
            message,
            format!("use at most {MAX_OUTLINE}, or several prisms"),
        );
        return Err(Skip);
    }
    let lift = |p: DVec2, end: f64| match axis.text.as_str() {
        "x" => DVec3::new(end, p.x, p.y),
        "y" => DVec3::new(p.x, end, p.y),
        _ => p.extend(end),
    };
    let Some(parts) = convex_parts(&outline) else {
        let help = "list the corners in order around the outline; it must not cross or touch itself";
        m.error(
            s.keyword.span,
            "the outline of this prism crosses itself or is flat",
            help,
        );
        return Err(Skip);
    };
    let solid = |part: &Vec<DVec2>| {
        let ends = [ends.0, ends.1].into_iter();
        Polytope::hull(
            &ends
                .flat_map(|end| part.iter().map(move |p| lift(*p, end)))
                .collect::<Vec<_>>(),
        )
    };
    parts
        .iter()
        .map(solid)
        .collect::<Option<Vec<_>>>()
        .ok_or_else(|| {
            let help = "its two ends must be apart; its corners at least a millimetre from each other";
            m.error(s.keyword.span, "this prism is flat", help);
            Skip
        })
}

/// A convex polygon from written points.
pub(super) fn polygon(s: &Statement, points: Vec<DVec3>, m: &mut Messages) -> Result<Polygon, Skip> {
    let span = s.keyword.span;
    let Some(polygon) = Polygon::new(points) else {
        m.error(
            span,
            "this polygon has no area",
            "its points must not lie on one line",
        );
        return Err(Skip);
    };
    if polygon
        .points
        .iter()
        .any(|p| polygon.plane.dist(*p).abs() > 1.0e-3)
    {
        let help = "move its points into one plane, or cut it into triangles";
        m.error(span, "the points of this polygon do not lie in one plane", help);
        return Err(Skip);
    }
    let convex = polygon
        .edge_planes()
        .all(|e| polygon.points.iter().all(|p| e.dist(*p) > -1.0e-3));
    if !convex {
        let help = "list its corners in order around it; cut it in two where it bends inwards";
        m.error(span, "this polygon is not convex", help);
        return Err(Skip);
    }
    Ok(polygon)
}
