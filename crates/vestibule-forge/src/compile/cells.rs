//! Cells and the openings between them, in the coordinates of their site.

use glam::DVec3;

use super::room::{cells_of, written};
use crate::geometry::{Face, Polygon, Polytope, union_faces};
use crate::scene::{Kind, Link, Opening, Placement, RoomDef, SiteDef};
use crate::text::{Messages, Span, Word, closest};

/// Where an opening leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// To the landscape, as this portal of the building.
    Outside(usize),
    /// To a cell, by its position among the site's.
    Cell(usize),
}

/// An opening in a face of a cell.
#[derive(Clone, Debug)]
pub(crate) struct Hole {
    pub(crate) span: Span,
    /// Position of the face.
    pub(crate) face: usize,
    /// Its shape, facing out of the cell.
    pub(crate) polygon: Polygon,
    pub(crate) to: Target,
    /// Position of the opposite hole among the other cell's.
    pub(crate) partner: Option<usize>,
    /// What is cut out of the wall, if less than the shape: where the two sides of an opening differ.
    pub(crate) cut: Option<Polygon>,
    /// Both sides have the same shape.
    pub(crate) exact: bool,
    /// Nobody passes: a window.
    pub(crate) pane: bool,
}

/// A convex cell of a room.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// Position of its room in the site.
    pub(crate) room: usize,
    /// The room's name; further cells of a room are numbered.
    pub(crate) name: String,
    pub(crate) span: Span,
    /// Its space; face tags are materials.
    pub(crate) space: Polytope,
    /// Room to site.
    pub(crate) place: Placement,
    pub(crate) holes: Vec<Hole>,
}

/// An opening of a building's shell.
#[derive(Clone, Debug)]
pub(crate) struct ShellHole {
    /// Its shape, facing out.
    pub(crate) polygon: Polygon,
    pub(crate) cell: usize,
    /// Position among the cell's holes.
    pub(crate) hole: usize,
    pub(crate) pane: bool,
}

/// A site with its cells cut and connected.
pub(crate) struct SiteCells {
    pub(crate) cells: Vec<Cell>,
    /// What of the shell can be seen, face tags are materials; not yet cut by the holes.
    pub(crate) shell: Vec<Face>,
    pub(crate) shell_holes: Vec<ShellHole>,
}

/// Openings smaller than this are not made, square metres.
const LEAST_OPENING: f64 = 1.0e-3;

impl SiteCells {
    pub(crate) fn build(site: &SiteDef, messages: &mut Messages) -> SiteCells {
        let mut out = SiteCells {
            cells: Vec::new(),
            shell: Vec::new(),
            shell_holes: Vec::new(),
        };
        for (room, def) in site.rooms.iter().enumerate() {
            out.add_room(room, def, messages);
        }
        for room in 0..site.rooms.len() {
            out.join_parts(room, site.rooms[room].name.span);
        }
        for link in site.links.iter().filter(|l| !l.one_way) {
            out.link(site, link, messages);
        }
        out.one_way_links(site, messages);
        if let Some(shell) = &site.shell {
            let paint = |s| super::room::painted(s, &shell.paint, false);
            let solids: Vec<Polytope> = shell.solids.iter().flat_map(paint).collect();
            out.shell = union_faces(&solids);
            for exit in &site.exits {
                out.exit(site, exit, &solids, messages);
            }
        } else if let Some(exit) = site.exits.first() {
            let message = format!("`{}` has no shell for its exits to lie in", site.name.text);
            let help = match site.kind {
                Kind::Building => {
                    "add `shell { … }`: the outside of the building, with a face in the plane of each exit"
                }
                Kind::Dungeon(_) => "a dungeon has no outside: remove the exit, or make it a building",
            };
            messages.error(exit.span, message, help);
        }
        out
    }

    fn add_room(&mut self, room: usize, def: &RoomDef, messages: &mut Messages) {
        let parts = cells_of(&def.name, &def.solids, &def.paint, messages);
        for (k, part) in parts.into_iter().enumerate() {
            let Some(space) = part.mapped(|p| def.place.to_outer(p)) else {
                continue;
            };
            let name = if k == 0 {
                def.name.text.clone()
            } else {
                format!("{}.{}", def.name.text, k + 1)
            };
            let (span, place) = (def.name.span, def.place);
            self.cells.push(Cell {
                room,
                name,
                span,
                space,
                place,
                holes: Vec::new(),
            });
        }
    }

    fn of_room(&self, room: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.cells.len()).filter(move |&k| self.cells[k].room == room)
    }

    /// Opens the faces in which the cells of one room touch.
    fn join_parts(&mut self, room: usize, span: Span) {
        let parts: Vec<usize> = self.of_room(room).collect();
        for (k, &a) in parts.iter().enumerate() {
            for &b in &parts[k + 1..] {
                for shared in shared_faces(&self.cells[a], &self.cells[b], &Opening::Shared) {
                    self.connect(span, (a, shared.0), (b, shared.1), shared.2);
                }
            }
        }
    }

    /// Makes an exact two-way opening; the polygon faces out of the first cell.
    fn connect(&mut self, span: Span, a: (usize, usize), b: (usize, usize), polygon: Polygon) {
        let at = [self.cells[a.0].holes.len(), self.cells[b.0].holes.len()];
        let hole = |face, polygon, to, partner| {
            let (to, partner) = (Target::Cell(to), Some(partner));
            Hole {
                span,
                face,
                polygon,
                to,
                partner,
                cut: None,
                exact: true,
                pane: false,
            }
        };
        let back = polygon.flipped();
        self.cells[a.0].holes.push(hole(a.1, polygon, b.0, at[1]));
        self.cells[b.0].holes.push(hole(b.1, back, a.0, at[0]));
    }

    fn room_named(site: &SiteDef, name: &Word, messages: &mut Messages) -> Option<usize> {
        let found = site.rooms.iter().position(|r| r.name.text == name.text);
        if found.is_none() {
            let names = site.rooms.iter().map(|r| r.name.text.as_str());
            let help = match closest(&name.text, names.clone()) {
                Some(best) => format!("did you mean `{best}`?"),
                None => format!(
                    "rooms of `{}`: {}",
                    site.name.text,
                    names.collect::<Vec<_>>().join(", ")
                ),
            };
            messages.error(
                name.span,
                format!("`{}` has no room `{}`", site.name.text, name.text),
                help,
            );
        }
        found
    }

    fn link(&mut self, site: &SiteDef, link: &Link, messages: &mut Messages) {
        let from = Self::room_named(site, &link.from, messages);
        let to = Self::room_named(site, &link.to, messages);
        let (Some(from), Some(to)) = (from, to) else {
            return;
        };
        if from == to {
            messages.error(
                link.span,
                "this opening leads from a room to itself",
                "name two rooms",
            );
            return;
        }
        if self.of_room(from).next().is_none() || self.of_room(to).next().is_none() {
            return; // What is wrong with that room has been said.
        }
        let mut found = Vec::new();
        for a in self.of_room(from) {
            for b in self.of_room(to) {
                let shared = shared_faces(&self.cells[a], &self.cells[b], &link.opening);
                found.extend(
                    shared
                        .into_iter()
                        .map(|(fa, fb, polygon)| ((a, fa), (b, fb), polygon)),
                );
            }
        }
        let opened: f64 = found.iter().map(|(.., p)| p.area()).sum();
        if opened < LEAST_OPENING {
            let message = format!(
                "the rooms `{}` and `{}` do not touch here",
                link.from.text, link.to.text
            );
            messages.error(link.span, message, self.gap_help(from, to, &link.opening));
            return;
        }
        if let Opening::Polygon(wanted) = &link.opening
            && opened < 0.999 * wanted.area()
        {
            let message = format!(
                "only {:.0} % of this opening lies in a wall that `{}` and `{}` share",
                100.0 * opened / wanted.area(),
                link.from.text,
                link.to.text
            );
            let help = "shrink it, or leave the shape out to open all that the rooms share";
            messages.error(link.span, message, help);
            return;
        }
        for (a, b, polygon) in found {
            self.connect(link.span, a, b, polygon);
        }
    }

    /// How far apart the nearest parallel faces of two rooms are.
    fn gap_help(&self, from: usize, to: usize, opening: &Opening) -> String {
        let mut best: Option<(f64, DVec3)> = None;
        for a in self.of_room(from) {
            for b in self.of_room(to) {
                for f in self.cells[a].space.faces.iter().map(|f| &f.polygon) {
                    for g in self.cells[b].space.faces.iter().map(|f| &f.polygon) {
                        let gap = f.plane.dist(g.center());
                        let slid = g.points.iter().map(|p| *p - f.plane.normal * gap).rev().collect();
                        let over = Polygon::new(slid).and_then(|slid| f.intersection(&slid));
                        let parallel = f.plane.normal.dot(g.plane.normal) < -0.999_99;
                        if let (true, Some(over)) = (parallel, over)
                            && best.is_none_or(|(g, _)| gap.abs() < g.abs())
                        {
                            best = Some((gap, over.center()));
                        }
                    }
                }
            }
        }
        match (best, opening) {
            (Some((gap, _)), Opening::Polygon(_)) if gap.abs() < 1.0e-3 => {
                "the rooms touch elsewhere: move the opening into the wall they share".to_owned()
            }
            (Some((gap, at)), _) => format!(
                "near {} their walls are {:.3} m {}; make them meet, or put a room for the passage between them",
                written(at),
                gap.abs(),
                if gap > 0.0 { "apart" } else { "inside each other" }
            ),
            (None, _) => {
                "no wall of one faces a wall of the other; put a room for the passage between them".to_owned()
            }
        }
    }

    /// `portal` statements: each makes a hole in its first room; two that lie upon each other become partners.
    fn one_way_links(&mut self, site: &SiteDef, messages: &mut Messages) {
        let mut made: Vec<(usize, usize, usize, &Link)> = Vec::new();
        for link in site.links.iter().filter(|l| l.one_way) {
            let from = Self::room_named(site, &link.from, messages);
            let to = Self::room_named(site, &link.to, messages);
            let (Some(from), Some(to)) = (from, to) else {
                continue;
            };
            let Some((cell, face, polygon)) = self.face_holding(from, &link.opening, to) else {
                let message = format!("this portal does not lie in a wall of `{}`", link.from.text);
                let help = "all of it must lie in one wall of the room it leads out of";
                messages.error(link.span, message, help);
                continue;
            };
            let behind = polygon.center() + polygon.plane.normal * 0.01;
            let other = self.of_room(to).min_by(|&a, &b| {
                let outside = |k: usize| {
                    self.cells[k]
                        .space
                        .faces
                        .iter()
                        .map(|f| f.polygon.plane.dist(behind))
                        .fold(f64::MIN, f64::max)
                };
                outside(a).total_cmp(&outside(b))
            });
            let Some(other) = other else { continue };
            let to = Target::Cell(other);
            let hole = Hole {
                span: link.span,
                face,
                polygon,
                to,
                partner: None,
                cut: None,
                exact: false,
                pane: false,
            };
            made.push((cell, self.cells[cell].holes.len(), other, link));
            self.cells[cell].holes.push(hole);
        }
        for &(cell, hole, other, link) in &made {
            let here = self.cells[cell].holes[hole].polygon.clone();
            let partner = made.iter().find(|(c, h, o, _)| {
                let there = &self.cells[*c].holes[*h].polygon;
                let facing = there.plane.normal.dot(here.plane.normal) < -0.5;
                *c == other && *o == cell && facing && there.center().distance(here.center()) < 1.0
            });
            let Some(&(_, back, ..)) = partner else {
                let message = format!(
                    "a one-way portal: `{}` leads to `{}`, nothing leads back",
                    link.from.text, link.to.text
                );
                let help = format!(
                    "add `portal {} {} …` with the opening on the other side, or write `opening` instead of `portal`",
                    link.to.text, link.from.text
                );
                messages.error(link.span, message, help);
                continue;
            };
            let there = &self.cells[other].holes[back].polygon;
            let shared = here.intersection(there).filter(|_| here.meets(there));
            let overlap = shared.as_ref().map_or(0.0, |p| p.area());
            let exact = overlap > 0.9999 * here.area() && overlap > 0.9999 * there.area();
            let hole = &mut self.cells[cell].holes[hole];
            (hole.partner, hole.exact, hole.cut) = (Some(back), exact, shared);
        }
    }

    /// The cell and face of a room in which all of an opening lies.
    fn face_holding(&self, room: usize, opening: &Opening, to: usize) -> Option<(usize, usize, Polygon)> {
        match opening {
            Opening::Polygon(wanted) => self.of_room(room).find_map(|cell| {
                self.cells[cell]
                    .space
                    .faces
                    .iter()
                    .enumerate()
                    .find_map(|(k, f)| {
                        let part = in_face(&f.polygon, wanted)?;
                        (part.area() > 0.999 * wanted.area()).then_some((cell, k, part))
                    })
            }),
            Opening::Shared => self.of_room(room).find_map(|a| {
                self.of_room(to).find_map(|b| {
                    let shared = shared_faces(&self.cells[a], &self.cells[b], opening);
                    shared.into_iter().next().map(|(fa, _, polygon)| (a, fa, polygon))
                })
            }),
        }
    }

    /// Opens a room to the outside, through a face of the shell.
    fn exit(
        &mut self,
        site: &SiteDef,
        exit: &crate::scene::Exit,
        solids: &[Polytope],
        messages: &mut Messages,
    ) {
        let Some(room) = Self::room_named(site, &exit.from, messages) else {
            return;
        };
        let mut found = Vec::new();
        for cell in self.of_room(room) {
            for (k, face) in self.cells[cell].space.faces.iter().enumerate() {
                for outer in solids.iter().flat_map(|s| &s.faces) {
                    if !face.polygon.plane.same_as(&outer.polygon.plane) {
                        continue;
                    }
                    let Some(shared) = face.polygon.intersection(&outer.polygon) else {
                        continue;
                    };
                    let part = match &exit.opening {
                        Opening::Shared => Some(shared),
                        Opening::Polygon(wanted) => in_face(&shared, wanted),
                    };
                    let Some(part) = part.filter(|p| p.area() > LEAST_OPENING) else {
                        continue;
                    };
                    let seen: f64 = self
                        .shell
                        .iter()
                        .filter(|f| f.polygon.plane.same_as(&part.plane))
                        .filter_map(|f| f.polygon.intersection(&part))
                        .map(|p| p.area())
                        .sum();
                    let twice = found.iter().any(|(_, _, p): &(usize, usize, Polygon)| {
                        p.plane.same_as(&part.plane) && p.intersection(&part).is_some()
                    });
                    if seen > 0.999 * part.area() && !twice {
                        found.push((cell, k, part));
                    }
                }
            }
        }
        if found.is_empty() {
            let message = format!(
                "the exit of `{}` is on no face of the shell: the building's portal has no polygon",
                exit.from.text
            );
            let help = "let the outer wall of the room lie in a face of the shell, facing the same way, not hidden by another part of it";
            messages.error(exit.span, message, help);
            return;
        }
        if let Opening::Polygon(wanted) = &exit.opening {
            let area: f64 = found.iter().map(|(.., p)| p.area()).sum();
            if area < 0.999 * wanted.area() {
                let share = 100.0 * area / wanted.area();
                let message = format!(
                    "only {share:.0} % of this exit lies in a wall of `{}` and in the shell",
                    exit.from.text
                );
                messages.error(
                    exit.span,
                    message,
                    "shrink it, or leave the shape out to open all that they share",
                );
                return;
            }
        }
        for (cell, face, polygon) in found {
            let hole = self.cells[cell].holes.len();
            let (span, pane, to) = (exit.span, exit.pane, Target::Outside(self.shell_holes.len()));
            self.shell_holes.push(ShellHole {
                polygon: polygon.clone(),
                cell,
                hole,
                pane,
            });
            self.cells[cell].holes.push(Hole {
                span,
                face,
                polygon,
                to,
                partner: None,
                cut: None,
                exact: true,
                pane,
            });
        }
    }
}

/// The part of `wanted` in a face, facing as the face does.
fn in_face(face: &Polygon, wanted: &Polygon) -> Option<Polygon> {
    let wanted = match face.plane.normal.dot(wanted.plane.normal) > 0.0 {
        true => wanted.clone(),
        false => wanted.flipped(),
    };
    let near = |p: &DVec3| face.plane.dist(*p).abs() < 2.0e-3;
    if !wanted.points.iter().all(near) {
        return None;
    }
    // Onto the very plane of the face.
    let points = wanted
        .points
        .iter()
        .map(|p| *p - face.plane.normal * face.plane.dist(*p))
        .collect();
    Polygon::in_plane(points, face.plane)?.intersection(face)
}

/// The faces in which two cells touch, and what they share within an opening, facing out of the first.
fn shared_faces(a: &Cell, b: &Cell, opening: &Opening) -> Vec<(usize, usize, Polygon)> {
    let mut out = Vec::new();
    let ((low_a, high_a), (low_b, high_b)) = (a.space.bounds(), b.space.bounds());
    if (low_a - 0.01).cmpgt(high_b).any() || (low_b - 0.01).cmpgt(high_a).any() {
        return out;
    }
    for (i, f) in a.space.faces.iter().enumerate() {
        for (j, g) in b.space.faces.iter().enumerate() {
            if !f.polygon.meets(&g.polygon) {
                continue;
            }
            let shared = f
                .polygon
                .intersection(&g.polygon)
                .and_then(|shared| match opening {
                    Opening::Shared => Some(shared),
                    Opening::Polygon(wanted) => in_face(&shared, wanted),
                });
            out.extend(
                shared
                    .filter(|p| p.area() > LEAST_OPENING)
                    .map(|polygon| (i, j, polygon)),
            );
        }
    }
    out
}
