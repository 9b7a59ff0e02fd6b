//! Unions of convex solids.

use super::{CUT, Face, Plane, Polygon, Polytope, Side};

/// A solid of any form: convex parts whose union it is. They may overlap.
pub type Solid = Vec<Polytope>;

/// What of a polygon lies outside a convex solid. A polygon in one of the solid's faces and facing the same way
/// is outside unless `drop_same` is set; facing the other way (the two touch) it is not outside.
fn outside(polygon: &Polygon, solid: &Polytope, drop_same: bool) -> Vec<Polygon> {
    let mut out = Vec::new();
    let mut rest = polygon.clone();
    for face in &solid.faces {
        let plane = &face.polygon.plane;
        match rest.side(plane) {
            Side::Back => {}
            Side::Front => {
                out.clear();
                return vec![polygon.clone()];
            }
            Side::On => {
                if plane.normal.dot(rest.plane.normal) > 0.0 && !drop_same {
                    return vec![polygon.clone()];
                }
            }
            Side::Across => {
                let (front, back) = rest.split(plane);
                out.extend(front);
                match back {
                    Some(back) => rest = back,
                    None => return out,
                }
            }
        }
    }
    out
}

/// The surface of a union: of every face what no other part covers. Faces in which two parts touch vanish.
/// `Face::tag`s are kept.
pub fn union_faces(parts: &[Polytope]) -> Vec<Face> {
    let mut out = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        for face in &part.faces {
            let mut pieces = vec![face.polygon.clone()];
            for (j, other) in parts.iter().enumerate() {
                if i != j {
                    pieces = pieces.iter().flat_map(|p| outside(p, other, j < i)).collect();
                }
            }
            out.extend(pieces.into_iter().map(|polygon| Face {
                polygon,
                tag: face.tag,
            }));
        }
    }
    out
}

/// What of a polygon no part of a solid covers; a polygon in a solid's face, facing either way, is covered.
pub(crate) fn uncovered(polygon: &Polygon, solids: &[Polytope]) -> Vec<Polygon> {
    solids.iter().fold(vec![polygon.clone()], |pieces, solid| {
        pieces.iter().flat_map(|p| outside(p, solid, true)).collect()
    })
}

/// What of a polygon lies inside a convex solid; a polygon in one of its faces is not inside.
pub(crate) fn inside(polygon: &Polygon, solid: &Polytope) -> Option<Polygon> {
    solid.faces.iter().try_fold(polygon.clone(), |part, face| {
        let inwards = face.polygon.plane.flipped();
        (part.side(&inwards) != Side::On)
            .then(|| part.clipped(&inwards))
            .flatten()
    })
}

/// Joins parts that touch in a whole face and together are convex. Faces in one plane must have the same tag, or
/// the tag [`CUT`].
pub fn merge_convex(mut parts: Vec<Polytope>) -> Vec<Polytope> {
    'again: loop {
        for i in 0..parts.len() {
            for j in i + 1..parts.len() {
                if let Some(joined) = join(&parts[i], &parts[j]) {
                    parts.remove(j);
                    parts[i] = joined;
                    continue 'again;
                }
            }
        }
        return parts;
    }
}

fn join(a: &Polytope, b: &Polytope) -> Option<Polytope> {
    let touching = a.faces.iter().enumerate().find_map(|(i, f)| {
        b.faces
            .iter()
            .position(|g| f.polygon.meets(&g.polygon))
            .map(|j| (i, j))
    })?;
    let keep = |p: &Polytope, skip: usize| -> Vec<(Plane, u32)> {
        p.planes()
            .into_iter()
            .enumerate()
            .filter(|(k, _)| *k != skip)
            .map(|(_, plane)| plane)
            .collect()
    };
    let mut planes = keep(a, touching.0);
    planes.extend(keep(b, touching.1));
    planes.sort_by_key(|(_, tag)| *tag == CUT);
    let same_tags = planes.iter().enumerate().all(|(k, (p, tag))| {
        planes[..k]
            .iter()
            .all(|(q, other)| !p.same_as(q) || tag == other || *tag == CUT)
    });
    let joined = Polytope::from_planes(&planes).filter(|_| same_tags)?;
    let volume = a.volume() + b.volume();
    ((joined.volume() - volume).abs() < 1.0e-6 * volume).then_some(joined)
}
