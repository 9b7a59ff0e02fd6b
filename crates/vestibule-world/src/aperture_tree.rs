//! In which order the openings of a building's shell are met (`visibility.md` 8.2): the drawing BSP, as far as there
//! are openings in it.

use glam::Vec3;
use vestibule_dat::record::{BspNode, BspTree};

use crate::constants::EPSILON;
use crate::geometry::Plane;

/// No child.
const NONE: u32 = u32::MAX;
/// Marks a node on the stack whose far side has been walked.
const FAR_SIDE_DONE: u32 = 1 << 31;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    plane: Plane,
    positive: u32,
    negative: u32,
    /// Its openings among all.
    first: u32,
    count: u32,
}

/// The splitting planes of a model's drawing BSP that have openings in or below them. Model-local metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ApertureTree {
    /// The root first, children after their parents.
    nodes: Box<[Node]>,
    /// Portal indices, node by node.
    portals: Box<[u16]>,
}

impl ApertureTree {
    /// The tree of a drawing BSP. Children that do not come after their parents are left out.
    pub(crate) fn of(tree: &BspTree) -> Self {
        let count = tree.nodes.len();
        let children = |at: usize| {
            let (pos, neg) = match tree.nodes.get(at) {
                Some(BspNode::Inner { pos, neg, .. }) => (*pos, *neg),
                Some(BspNode::Portal { pos, neg, .. }) => (Some(*pos), Some(*neg)),
                _ => (None, None),
            };
            [pos, neg].map(|child| child.map(|c| c as usize).filter(|&c| c > at && c < count))
        };
        // Whether there is an opening in a node or below it: children first.
        let mut leads = vec![false; count];
        for at in (0..count).rev() {
            let own =
                matches!(&tree.nodes[at], BspNode::Portal { portal_polys, .. } if !portal_polys.is_empty());
            leads[at] = own || children(at).into_iter().flatten().any(|child| leads[child]);
        }
        let mut place = vec![NONE; count];
        let (mut nodes, mut portals) = (Vec::new(), Vec::new());
        for at in 0..count {
            let (plane, own) = match &tree.nodes[at] {
                BspNode::Inner { plane, .. } => (plane, &[][..]),
                BspNode::Portal {
                    plane, portal_polys, ..
                } => (plane, &portal_polys[..]),
                BspNode::Leaf { .. } => continue,
            };
            if !leads[at] || nodes.len() >= FAR_SIDE_DONE as usize {
                continue;
            }
            place[at] = nodes.len() as u32;
            let first = portals.len() as u32;
            portals.extend(own.iter().map(|&(_, portal)| portal));
            let [positive, negative] =
                children(at).map(|c| c.filter(|&c| leads[c]).map_or(NONE, |c| c as u32));
            nodes.push(Node {
                plane: plane.into(),
                positive,
                negative,
                first,
                count: portals.len() as u32 - first,
            });
        }
        for node in &mut nodes {
            for child in [&mut node.positive, &mut node.negative] {
                *child = place.get(*child as usize).copied().unwrap_or(NONE);
            }
        }
        ApertureTree {
            nodes: nodes.into(),
            portals: portals.into(),
        }
    }

    /// Whether there is no opening.
    pub fn is_empty(&self) -> bool {
        self.portals.is_empty()
    }

    /// Memory behind the tree, bytes.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.portals)
    }

    /// Names the portals of all openings back to front from the eye: at each plane those beyond it, those in it,
    /// then those on the eye's side. An eye in a plane sees them in this order too (`visibility.md` 12.2). `stack` is
    /// working memory.
    pub fn back_to_front(&self, eye: Vec3, stack: &mut Vec<u32>, mut emit: impl FnMut(u16)) {
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        // A record may name a node twice: each is met at most once per way to it, and ways are as many as nodes.
        let mut steps = 2 * self.nodes.len();
        while let (Some(top), true) = (stack.pop(), steps > 0) {
            steps -= 1;
            let Some(node) = self.nodes.get((top & !FAR_SIDE_DONE) as usize) else {
                continue;
            };
            let (near, far) = if node.plane.dist(eye) > EPSILON {
                (node.positive, node.negative)
            } else {
                (node.negative, node.positive)
            };
            if top & FAR_SIDE_DONE == 0 {
                stack.push(top | FAR_SIDE_DONE);
                if far != NONE {
                    stack.push(far);
                }
                continue;
            }
            let own = node.first as usize..(node.first + node.count) as usize;
            for &portal in self.portals.get(own).unwrap_or(&[]) {
                emit(portal);
            }
            if near != NONE {
                stack.push(near);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vestibule_dat::record::{BspKind, BspTag};

    fn plane(x: f32, y: f32, d: f32) -> vestibule_dat::primitive::Plane {
        vestibule_dat::primitive::Plane {
            normal: Vec3::new(x, y, 0.0),
            d,
        }
    }

    fn leaf() -> BspNode {
        BspNode::Leaf {
            index: 0,
            physics: None,
        }
    }

    /// Openings 0 in y = 0, 1 in x = 3 beyond it, 2 in y = -4; a plane without any in between.
    fn tree() -> ApertureTree {
        let portal = |plane, pos, neg, portal| BspNode::Portal {
            plane,
            pos,
            neg,
            sphere: None,
            polys: Vec::new(),
            portal_polys: vec![(7, portal)],
        };
        let inner = BspNode::Inner {
            tag: BspTag::PORT,
            plane: plane(1.0, 0.0, 0.0),
            pos: Some(2),
            neg: Some(5),
            sphere: None,
            polys: Vec::new(),
        };
        let nodes = vec![
            portal(plane(0.0, 1.0, 0.0), 1, 6, 0),
            inner,
            portal(plane(1.0, 0.0, -3.0), 3, 4, 1),
            leaf(),
            leaf(),
            leaf(),
            portal(plane(0.0, 1.0, 4.0), 7, 8, 2),
            leaf(),
            leaf(),
        ];
        ApertureTree::of(&BspTree {
            kind: BspKind::Drawing,
            nodes,
        })
    }

    fn order(eye: Vec3) -> Vec<u16> {
        let mut out = Vec::new();
        tree().back_to_front(eye, &mut Vec::new(), |portal| out.push(portal));
        out
    }

    #[test]
    fn v8_2_beyond_the_plane_then_in_it_then_on_the_near_side() {
        assert_eq!(order(Vec3::new(0.0, 50.0, 0.0)), [2, 0, 1]);
        assert_eq!(order(Vec3::new(0.0, -50.0, 0.0)), [1, 0, 2]);
        // However far the openings are: only the planes decide.
        assert_eq!(order(Vec3::new(400.0, -1.0, 0.0)), [1, 0, 2]);
    }

    #[test]
    fn v8_2_an_eye_in_the_plane_of_an_opening_meets_it_between_the_sides() {
        let got = order(Vec3::new(9.0, 0.0, 0.0));
        assert_eq!((got.len(), got[1]), (3, 0));
    }

    #[test]
    fn v8_2_bad_trees_end() {
        let looped = |pos, neg| {
            let node = BspNode::Portal {
                plane: plane(0.0, f32::NAN, 0.0),
                pos,
                neg,
                sphere: None,
                polys: Vec::new(),
                portal_polys: vec![(1, 0)],
            };
            ApertureTree::of(&BspTree {
                kind: BspKind::Drawing,
                nodes: vec![node; 40],
            })
        };
        for (pos, neg) in [(0, 0), (39, 39), (1, 1), (99, 5)] {
            let mut met = 0;
            looped(pos, neg).back_to_front(Vec3::ZERO, &mut Vec::new(), |_| met += 1);
            assert!(met <= 80, "{met}");
        }
        assert!(ApertureTree::default().is_empty());
    }
}
