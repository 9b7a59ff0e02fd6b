//! Handing views on, and repairing finished rooms that a further view reached (`visibility.md` 5.6, 6).

use std::cmp::Reverse;

use super::{IN, MAX_MOVES, MAX_REPAIR_DEPTH, PView, SEEN_IN, Scene};
use crate::openings::{NONE, Target};

impl PView {
    /// Hands new views on to the neighbours' places in the todo list, or repairs finished ones
    /// (`visibility.md` 5.6).
    pub(super) fn add_view_to_portals(&mut self, scene: &Scene<'_>, room: u32) {
        for p in scene.openings.portals_of(room) {
            let portal = &scene.openings.portals[p as usize];
            let Target::Room(other) = portal.target else {
                continue;
            };
            if self.portals[p as usize].flags & IN != 0 {
                continue;
            }
            let state = &mut self.rooms[other as usize];
            if state.stamp != self.stamp || state.views.count == 0 {
                continue;
            }
            if !state.scheduled {
                self.schedule(scene, other, portal.other_portal, room);
            } else if state.news {
                // Before the repair, not after it: what comes in the course of that is news again.
                state.news = false;
                let done = state.done;
                if portal.other_portal != NONE {
                    self.portals[portal.other_portal as usize].flags |= IN;
                }
                if done {
                    self.fix_cell_list(scene, other, room);
                }
            } else {
                continue;
            }
            if portal.other_portal != NONE {
                let back = &mut self.portals[portal.other_portal as usize].flags;
                if *back & IN != 0 {
                    *back |= SEEN_IN;
                }
            }
        }
    }

    /// A finished room received a new view (`visibility.md` 6.1, 6.3).
    pub(super) fn fix_cell_list(&mut self, scene: &Scene<'_>, done: u32, finder: u32) {
        self.adjust_cell_place(scene, done, finder);
        self.counters.incremental_clips += 1;
        if self.depth >= MAX_REPAIR_DEPTH {
            // Too deep for the stack: it gets its turn again before anything new.
            self.todo.push(Reverse((0, self.inserted, done)));
            self.inserted += 1;
            return;
        }
        self.depth += 1;
        if self.clip_portals(scene, done) {
            self.add_view_to_portals(scene, done);
        }
        self.depth -= 1;
    }

    /// Moves `finder` before `done` in the list, and before it whatever it is seen through (`visibility.md` 6.2).
    /// Each room moves at most once a repair, and none before the root (6.4).
    pub(super) fn adjust_cell_place(&mut self, scene: &Scene<'_>, done: u32, finder: u32) {
        self.repair += 1;
        self.moves.clear();
        self.moves.push((done, finder));
        while let Some((before, mover)) = self.moves.pop() {
            let (to, from) = (
                self.rooms[before as usize].position,
                self.rooms[mover as usize].position,
            );
            let state = &mut self.rooms[mover as usize];
            let stuck = to == 0 || from == NONE || from <= to || state.moved_in == self.repair;
            if stuck || self.counters.moves >= MAX_MOVES {
                continue;
            }
            state.moved_in = self.repair;
            self.counters.moves += 1;
            self.list[to as usize..=from as usize].rotate_right(1);
            for at in to..=from {
                let room = self.list[at as usize];
                self.rooms[room as usize].position = at;
            }
            for p in scene.openings.portals_of(mover).rev() {
                if self.portals[p as usize].flags & (IN | SEEN_IN) != IN | SEEN_IN {
                    continue;
                }
                if let Target::Room(behind) = scene.openings.portals[p as usize].target
                    && self.rooms[behind as usize].stamp == self.stamp
                {
                    self.moves.push((mover, behind));
                }
            }
        }
    }
}
