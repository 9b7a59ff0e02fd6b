//! Handing views to rooms and to the outside: the ancestor rule and the limits (`visibility.md` 6.5, 13.4).

use glam::Vec2;

use super::{DEAD_COUNTED, NO_VIEWS, OUTSIDE, PView, Scene, Shape, View, ViewList};
use crate::constants::{MAX_HOPS, MAX_VIEWS, MAX_VIEWS_PER_CELL};
use crate::openings::NONE;
use crate::view::{Edge, lower, rectangle, upper};

impl PView {
    /// Adds what was clipped to a neighbour or to the outside, or counts why not.
    pub(super) fn deliver(&mut self, scene: &Scene<'_>, to: u32, parent: u32, p: u32, shape: Shape) {
        if to == NONE {
            self.portals[p as usize].flags |= DEAD_COUNTED;
            self.counters.dead_portals += 1;
            return;
        }
        // The ancestor rule (`visibility.md` 6.5). The root is an ancestor of everything, also of widened views.
        let mut ancestor = parent;
        let mut rejected = to == scene.start.room;
        while ancestor != NONE && !rejected {
            let v = &self.views[ancestor as usize];
            rejected = v.room == to;
            ancestor = v.parent;
        }
        if rejected {
            self.counters.ancestor_rejections += 1;
            return;
        }
        let list = if to == OUTSIDE {
            self.outside
        } else {
            self.touch(scene, to);
            self.rooms[to as usize].views
        };
        if list.saturated {
            return;
        }
        let hops = self.views[parent as usize].hops + 1;
        if hops > MAX_HOPS || self.views.len() >= MAX_VIEWS {
            self.truncated = true;
            self.saturate(scene, to, None);
        } else if list.count >= MAX_VIEWS_PER_CELL {
            let bounds = self.bounds_with_polygon(scene, &list, &shape);
            self.saturate(scene, to, bounds);
        } else {
            let (first_edge, edge_count) = match shape {
                Shape::Shared(first, count) => (first, count),
                Shape::Polygon => {
                    let first = self.edges.len() as u32;
                    self.edges.extend_from_slice(self.polygon.edges());
                    (first, self.polygon.edges().len() as u16)
                }
            };
            self.append(
                to,
                View {
                    room: to,
                    parent,
                    portal: p,
                    next: NONE,
                    first_edge,
                    edge_count,
                    hops,
                },
            );
        }
    }

    pub(super) fn append(&mut self, to: u32, view: View) {
        let at = self.views.len() as u32;
        self.views.push(view);
        let list = if to == OUTSIDE {
            &mut self.outside
        } else {
            let state = &mut self.rooms[to as usize];
            if state.pending == NONE {
                state.pending = at;
            }
            state.news = true;
            &mut state.views
        };
        if list.tail == NONE {
            list.head = at;
        } else {
            self.views[list.tail as usize].next = at;
        }
        list.tail = at;
        list.count += 1;
    }

    /// Replaces the views of a room by one that bounds them, and accepts no more (`visibility.md` 13.4). Without
    /// bounds it is the view the flood started with, which holds all others.
    pub(super) fn saturate(&mut self, scene: &Scene<'_>, to: u32, bounds: Option<[Edge; 4]>) {
        self.counters.saturated_cells += 1;
        let (first_edge, edge_count) = match bounds {
            Some(edges) => (self.push_edges(&edges), 4),
            None => (0, scene.start.view.len() as u16),
        };
        let replaced = ViewList {
            saturated: true,
            ..NO_VIEWS
        };
        if to == OUTSIDE {
            self.outside = replaced;
        } else {
            self.rooms[to as usize].views = replaced;
            self.rooms[to as usize].pending = NONE;
        }
        let view = View {
            room: to,
            parent: NONE,
            portal: NONE,
            next: NONE,
            first_edge,
            edge_count,
            hops: 0,
        };
        self.append(to, view);
    }

    /// The rectangle of the screen around all views of a list and the polygon at hand.
    pub(super) fn bounds_with_polygon(
        &self,
        scene: &Scene<'_>,
        list: &ViewList,
        shape: &Shape,
    ) -> Option<[Edge; 4]> {
        let camera = scene.camera?;
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let mut grow = |edges: &[Edge]| {
            edges.iter().all(|e| {
                let c = camera.to_camera(e.corner);
                let slope = Vec2::new(c.x / c.y, c.z / c.y);
                low = Vec2::new(lower(low.x, slope.x), lower(low.y, slope.y));
                high = Vec2::new(upper(high.x, slope.x), upper(high.y, slope.y));
                c.y > 0.0 && slope.is_finite()
            })
        };
        let edges_of =
            |first: u32, count: u16| &self.edges[first as usize..first as usize + usize::from(count)];
        let mut at = list.head;
        while at != NONE {
            let v = &self.views[at as usize];
            if !grow(edges_of(v.first_edge, v.edge_count)) {
                return None;
            }
            at = v.next;
        }
        let ahead = match *shape {
            Shape::Shared(first, count) => grow(edges_of(first, count)),
            Shape::Polygon => grow(self.polygon.edges()),
        };
        ahead.then(|| rectangle(camera, low, high))
    }
}
