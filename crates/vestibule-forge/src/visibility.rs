//! Which cells can be seen from anywhere in a cell: stab lists and `seen_outside` (`world.md` P5, P6).
//!
//! A cell is convex, so whatever is seen from it is seen through one of its openings. From each opening (the
//! *source*) a search walks on from cell to cell. What a ray through the source and through the openings passed so
//! far can reach is bounded by their *separating planes*: a plane through an edge of one opening and a corner of a
//! later one, with the one behind it and the other in front. Every further opening is clipped to all of these
//! planes, and the source to those between the last two openings; when nothing is left, nothing beyond is seen.
//!
//! **Conservative**: a plane is used only if it truly separates, and everything is kept to within a millimetre, so no
//! cell that an eye can see is left out. **Tight**: exact for rays through two openings; for three and more the
//! region that rays reach has curved borders (ruled quadrics) of which the planes are the flat hull, so a cell that
//! is only nearly seen around two corners may be listed. No furniture or door hides anything.

use std::collections::BTreeSet;

use glam::DVec3;

use crate::geometry::{Plane, Polygon};

/// What is clipped away must lie farther than this behind a plane, metres.
const SLACK: f64 = 1.0e-3;
/// A search gives up after this many steps, and then lists every cell that can be reached.
const MAX_STEPS: u32 = 100_000;

/// An opening of a convex cell.
#[derive(Clone, Debug)]
pub struct Opening {
    /// Its shape, facing out of the cell.
    pub polygon: Polygon,
    /// The cell behind it; `None`: the landscape.
    pub to: Option<usize>,
}

/// What is seen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Cells, by position; without the one they are seen from.
    pub cells: BTreeSet<usize>,
    /// Whether the landscape is among it.
    pub outside: bool,
}

/// What can be seen from somewhere in cell `from`. `cells[k]` are the openings of cell `k`; positions beyond its end
/// are cells without openings.
pub fn seen_from_cell(cells: &[Vec<Opening>], from: usize) -> Seen {
    let mut search = Search::new(cells, Some(from));
    for opening in cells.get(from).into_iter().flatten() {
        search.enter(opening.to, &opening.polygon);
    }
    search.finish()
}

/// What can be seen from outside through `opening`, a polygon that faces into cell `into`.
pub fn seen_through(cells: &[Vec<Opening>], opening: &Polygon, into: usize) -> Seen {
    let mut search = Search::new(cells, None);
    search.enter(Some(into), opening);
    search.finish()
}

struct Search<'a> {
    cells: &'a [Vec<Opening>],
    from: Option<usize>,
    seen: Seen,
    steps: u32,
    /// The cells passed.
    chain: Vec<usize>,
    /// What bounds the rays so far; the reached side is in front.
    bounds: Vec<Plane>,
}

impl<'a> Search<'a> {
    fn new(cells: &'a [Vec<Opening>], from: Option<usize>) -> Self {
        Search {
            cells,
            from,
            seen: Seen::default(),
            steps: 0,
            chain: from.into_iter().collect(),
            bounds: Vec::new(),
        }
    }

    fn enter(&mut self, to: Option<usize>, source: &Polygon) {
        match to {
            None => self.seen.outside = true,
            Some(cell) if self.chain.contains(&cell) => {}
            Some(cell) => {
                self.seen.cells.insert(cell);
                self.walk(cell, source, None);
            }
        }
    }

    /// Looks on from `cell`, entered through `pass` (or, at first, through the source itself).
    fn walk(&mut self, cell: usize, source: &Polygon, pass: Option<&Polygon>) {
        self.chain.push(cell);
        let cells = self.cells;
        for opening in cells.get(cell).into_iter().flatten() {
            if self.steps >= MAX_STEPS || opening.to.is_some_and(|to| self.chain.contains(&to)) {
                continue;
            }
            self.steps += 1;
            let ahead = source.plane.moved(-SLACK);
            let target = opening.polygon.clipped(&ahead).filter(|t| {
                // An opening in the very plane of the source is seen edge-on, by nobody.
                t.points.iter().any(|p| source.plane.dist(*p) > 1.0e-6)
            });
            let target = self
                .bounds
                .iter()
                .try_fold(target, |part, plane| part.map(|p| p.clipped(plane)));
            let Some(target) = target.flatten() else { continue };
            let narrowed = match pass {
                None => Some(source.clone()),
                Some(pass) => separators(&target, pass)
                    .iter()
                    .try_fold(source.clone(), |s, p| s.clipped(p)),
            };
            let Some(narrowed) = narrowed else { continue };
            match opening.to {
                None => self.seen.outside = true,
                Some(next) => {
                    self.seen.cells.insert(next);
                    let kept = self.bounds.len();
                    self.bounds.extend(separators(&narrowed, &target));
                    self.walk(next, &narrowed, Some(&target));
                    self.bounds.truncate(kept);
                }
            }
        }
        self.chain.pop();
    }

    fn finish(mut self) -> Seen {
        if self.steps >= MAX_STEPS {
            self.everything();
        }
        if let Some(from) = self.from {
            self.seen.cells.remove(&from);
        }
        self.seen
    }

    /// Adds every cell that can be reached from those seen.
    fn everything(&mut self) {
        let mut todo: Vec<usize> = self.seen.cells.iter().copied().collect();
        while let Some(cell) = todo.pop() {
            for opening in self.cells.get(cell).into_iter().flatten() {
                match opening.to {
                    None => self.seen.outside = true,
                    Some(next) if self.seen.cells.insert(next) => todo.push(next),
                    Some(_) => {}
                }
            }
        }
    }
}

/// The planes that have `near` behind and `far` in front, through an edge of one and a corner of the other, moved
/// back a little.
fn separators(near: &Polygon, far: &Polygon) -> Vec<Plane> {
    let mut out = Vec::new();
    separators_along(near, far, false, &mut out);
    separators_along(far, near, true, &mut out);
    out
}

fn separators_along(edges: &Polygon, corners: &Polygon, flip: bool, out: &mut Vec<Plane>) {
    const ON: f64 = 1.0e-6;
    let n = edges.points.len();
    for i in 0..n {
        let (a, b) = (edges.points[i], edges.points[(i + 1) % n]);
        for c in &corners.points {
            let normal: DVec3 = (b - a).cross(*c - a);
            let length = normal.length();
            if length < 1.0e-6 {
                continue;
            }
            let plane = Plane::through(normal / length, a);
            let sides = |points: &[DVec3]| {
                points.iter().fold((false, false), |(front, back), p| {
                    let dist = plane.dist(*p);
                    (front || dist > ON, back || dist < -ON)
                })
            };
            // The corner is on the plane; its polygon must lie on one side, the other polygon on the other.
            let plane = match (sides(&edges.points), sides(&corners.points)) {
                ((false, true), (true, false)) => plane,
                ((true, false), (false, true)) => plane.flipped(),
                _ => continue,
            };
            // Now `edges` is behind and `corners` in front.
            let plane = if flip { plane.flipped() } else { plane };
            out.push(plane.moved(-SLACK));
        }
    }
}
