//! What holds for a physics tree as a whole, worked out when it is compiled: which polygons lie where it says, and what of
//! it is certainly not solid.

use super::*;

/// Damaged trees may have endless ways through them.
const MAX_AUDIT_STEPS: u32 = 100_000;

impl PhysicsBsp {
    /// Works out what holds for the tree as a whole: which faces lie where it says, and whether its open space is
    /// hollow.
    pub(super) fn audit(&mut self) {
        if let Some(quads) = &self.quads {
            let listed: Vec<u32> = quads.quads.iter().flat_map(|q| q.faces).collect();
            for i in listed {
                let Some(face) = self.faces.get(i as usize) else {
                    continue;
                };
                let polygon: Vec<Vec3> = self.edges(face).iter().map(|e| e.start).collect();
                let small = polygon.iter().all(|v| v.abs().max_element() < 64.0);
                let sound = small && self.is_found(self.root, &polygon, face.polygon, 0);
                if let Some(face) = self.faces.get_mut(i as usize) {
                    face.sound = sound;
                }
            }
        }
        // Centres of spheres keep away from the sides.
        let inset = Vec3::splat(LEAST_CLEAR_RADIUS - 0.01);
        let space = self.open.bounds();
        self.open_is_hollow = self.is_hollow_in(&BoundingBox {
            min: space.min + inset,
            max: space.max - inset,
        });
        if !self.is_hollow && !self.is_hollow_outside(&self.reach) {
            self.reach = ENDLESS;
        }
        self.number_faces();
    }

    /// Notes when a walk of everything comes by each polygon.
    fn number_faces(&mut self) {
        let count = self.polygons.polygons().len();
        let mut met: Vec<Option<(u32, u32)>> = vec![None; count];
        let mut open = vec![self.root];
        let mut now = 0;
        for _ in 0..MAX_AUDIT_STEPS {
            let Some(at) = open.pop() else {
                for face in &mut self.faces {
                    if let Some(Some(met)) = met.get(face.polygon as usize) {
                        face.met = *met;
                    }
                }
                return;
            };
            match at.kind() {
                ChildKind::Absent => {}
                ChildKind::Node(index) => {
                    if let Some(node) = self.nodes.get(index) {
                        open.extend([node.negative, node.positive]);
                    }
                }
                ChildKind::Leaf(index) => {
                    let faces = self.leaves.get(index).map_or(&[][..], |leaf| self.faces_of(leaf));
                    for face in faces {
                        now += 1;
                        if let Some(met) = met.get_mut(face.polygon as usize) {
                            *met = Some((met.map_or(now, |m| m.0), now));
                        }
                    }
                }
            }
        }
    }

    /// Whether a walk below `at` finds the polygon `id` for every sphere that overlaps the piece `part` of it by
    /// more than [`SURE_OVERLAP`].
    fn is_found(&self, at: Child, part: &[Vec3], id: u32, depth: u32) -> bool {
        // Pieces thinner than this do not matter: an overlap is deeper.
        const TOLERANCE: f32 = 1e-4;
        let within = |s: &Sphere| {
            part.iter().all(|&p| {
                let between = p - s.center;
                let r = s.radius + TOLERANCE;
                between.dot(between) <= r * r
            })
        };
        match at.kind() {
            ChildKind::Absent => false,
            ChildKind::Leaf(index) => self.leaves.get(index).is_some_and(|leaf| {
                within(&leaf.sphere) && self.faces_of(leaf).iter().any(|f| f.polygon == id)
            }),
            ChildKind::Node(index) => {
                let Some(node) = self.nodes.get(index) else {
                    return false;
                };
                let n = node.plane.normal;
                let unit = (n.dot(n) - 1.0).abs() < 1e-4;
                if !unit || depth > 64 || node.sphere.is_some_and(|s| !within(&s)) {
                    return false;
                }
                let in_front = part.iter().any(|&p| node.plane.dist(p) > TOLERANCE);
                let behind = part.iter().any(|&p| node.plane.dist(p) < -TOLERANCE);
                let below = |child, part: &[Vec3]| self.is_found(child, part, id, depth + 1);
                match (in_front, behind) {
                    // In the plane: what overlaps it straddles the plane, and both sides are walked.
                    (false, false) => below(node.positive, part) || below(node.negative, part),
                    (true, false) => below(node.positive, part),
                    (false, true) => below(node.negative, part),
                    (true, true) => {
                        let flipped = Plane {
                            normal: -n,
                            d: -node.plane.d,
                        };
                        below(node.positive, &clipped(part, &node.plane))
                            && below(node.negative, &clipped(part, &flipped))
                    }
                }
            }
        }
    }

    /// Whether no point outside a box is in a leaf that is solid and has polygons.
    fn is_hollow_outside(&self, space: &BoundingBox) -> bool {
        /// Larger trees are not looked at.
        const MAX_NODES: usize = 512;
        /// Bodies farther off than this are out of everybody's reach, metres.
        const FAR: f32 = 1e4;
        self.nodes.len() <= MAX_NODES
            && (0..3).all(|axis| {
                let all = BoundingBox {
                    min: Vec3::splat(-FAR),
                    max: Vec3::splat(FAR),
                };
                let (mut below, mut above) = (all, all);
                below.max[axis] = space.min[axis];
                above.min[axis] = space.max[axis];
                self.is_hollow_in(&below) && self.is_hollow_in(&above)
            })
    }

    /// Whether no point in a box is in a leaf that is solid and has polygons.
    fn is_hollow_in(&self, centers: &BoundingBox) -> bool {
        let mut open = vec![self.root];
        let mut steps = 0;
        while let Some(at) = open.pop() {
            steps += 1;
            match at.kind() {
                ChildKind::Absent => {}
                ChildKind::Leaf(index) => {
                    if self.leaves.get(index).is_some_and(|l| l.solid && l.count != 0) {
                        return false;
                    }
                }
                ChildKind::Node(index) => {
                    let Some(node) = self.nodes.get(index) else {
                        continue;
                    };
                    match centers.side_of(&node.plane) {
                        Side::Positive => open.push(node.positive),
                        Side::Negative => open.push(node.negative),
                        Side::Crossing => open.extend([node.positive, node.negative]),
                    }
                }
            }
            if steps > MAX_AUDIT_STEPS {
                return false;
            }
        }
        true
    }
}

/// The piece of a polygon in front of a plane.
fn clipped(polygon: &[Vec3], plane: &Plane) -> Vec<Vec3> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    let Some(&last) = polygon.last() else { return out };
    let mut from = (last, plane.dist(last));
    for &p in polygon {
        let dist = plane.dist(p);
        if (from.1 < 0.0) != (dist < 0.0) {
            out.push(from.0 + (p - from.0) * (from.1 / (from.1 - dist)));
        }
        if dist >= 0.0 {
            out.push(p);
        }
        from = (p, dist);
    }
    out
}
