//! Writing down what a flood found (`visibility.md` 15.1).

use super::{PView, Scene, ViewList};
use crate::flood::{FloodArena, FloodCounters, FloodRecord, Seal, SeenCell, SeenView};
use crate::openings::{NONE, Target};

impl PView {
    pub(super) fn write_result(&mut self, scene: &Scene<'_>, out: &mut FloodArena) {
        let openings = scene.openings;
        let (cells, seals) = (out.cells.len() as u32, out.seals.len() as u32);
        let (views, edges) = (out.views.len() as u32, out.edges.len() as u32);
        out.edges.extend_from_slice(&self.edges);
        self.placed.clear();
        self.placed.resize(self.views.len(), NONE);
        let place = |list: &ViewList, out: &mut FloodArena, placed: &mut [u32]| -> (u32, u32) {
            let first = out.views.len() as u32 - views;
            let mut at = list.head;
            while at != NONE {
                let v = &self.views[at as usize];
                placed[at as usize] = out.views.len() as u32 - views;
                out.views.push(SeenView {
                    parent: (v.parent != NONE).then_some(v.parent),
                    portal: (v.portal != NONE).then(|| openings.portals[v.portal as usize].record_index),
                    first_edge: edges + v.first_edge,
                    edge_count: u32::from(v.edge_count),
                });
                at = v.next;
            }
            (first, out.views.len() as u32 - views - first)
        };
        for (&room, at) in self.list.iter().zip(0u32..) {
            let state = &self.rooms[room as usize];
            let (first_view, view_count) = place(&state.views, out, &mut self.placed);
            let from = (state.reached_from != NONE).then(|| self.rooms[state.reached_from as usize].position);
            let compiled = &openings.rooms[room as usize];
            out.cells.push(SeenCell {
                id: compiled.id,
                reached_from: from,
                key: state.key,
                saturated: state.views.saturated,
                first_view,
                view_count,
            });
            for p in openings.portals_of(room) {
                let portal = &openings.portals[p as usize];
                if portal.target == Target::Outside {
                    let on_block_border = portal.on_block_border;
                    out.seals.push(Seal {
                        cell: at,
                        portal: portal.record_index,
                        on_block_border,
                    });
                }
            }
            if room != scene.start.room && scene.start.stabs.binary_search(&room).is_err() {
                self.counters.entered_outside_stab += 1;
            }
        }
        let outside = place(&self.outside, out, &mut self.placed);
        for v in &mut out.views[views as usize..] {
            if let Some(parent) = v.parent {
                let at = self.placed[parent as usize];
                // A view that was replaced when its room saturated lives on in the one that bounds it.
                let room = self.views[parent as usize].room;
                let stand_in = if at == NONE {
                    self.rooms[room as usize].views.head
                } else {
                    parent
                };
                v.parent = self
                    .placed
                    .get(stand_in as usize)
                    .copied()
                    .filter(|&at| at != NONE);
            }
        }
        out.floods.push(FloodRecord {
            cells: (cells, self.list.len() as u32),
            views: (views, out.views.len() as u32 - views),
            outside,
            seals: (seals, out.seals.len() as u32 - seals),
            counters: self.counters,
            truncated: self.truncated,
        });
        self.counters = FloodCounters::default();
    }
}
