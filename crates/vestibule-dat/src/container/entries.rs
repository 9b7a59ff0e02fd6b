//! The in-order walk of the directory (`dat-format.md` B6).

use super::dat_file::{DatFile, View};
use super::node::{ALL_IDS, Entry, Interval, Node};
use crate::error::{Fault, Result};

/// Entries by ascending id, from [`DatFile::iter`] and [`DatFile::range`].
///
/// A damaged node gives one error and then the walk goes on behind the ids that the node stood for. If the file is edited
/// meanwhile, the walk goes on in the newer state.
pub struct Entries<'a> {
    file: &'a DatFile,
    view: &'a View,
    /// Ids still wanted; ends are `u64` so that every range can be said.
    low: u64,
    high: u64,
    started: bool,
    stack: Vec<Level>,
}

struct Level {
    node: Box<Node>,
    interval: Interval,
    next: Step,
}

/// What comes next in a node: the child in front of an entry, or the entry itself.
#[derive(Clone, Copy)]
enum Step {
    Child(usize),
    Entry(usize),
}

impl<'a> Entries<'a> {
    pub(crate) fn new(file: &'a DatFile, low: u64, high: u64) -> Entries<'a> {
        Entries {
            file,
            view: file.view(),
            low,
            high,
            started: false,
            stack: Vec::new(),
        }
    }

    /// Reads the node at `offset` and goes on in it.
    fn enter(&mut self, offset: u32, interval: Interval) -> std::result::Result<(), Fault> {
        let node = Node::read(
            &self.view.bytes(),
            self.view.geometry(),
            offset,
            self.stack.len(),
            &interval,
        )?;
        let first = match u32::try_from(self.low) {
            Ok(low) => node.position(low),
            Err(_) => node.len(),
        };
        let next = if node.is_leaf() {
            Step::Entry(first)
        } else {
            Step::Child(first)
        };
        self.stack.push(Level {
            node: Box::new(node),
            interval,
            next,
        });
        Ok(())
    }

    /// After a failure: the walk starts anew if the file has changed; else the failure is the answer (W5).
    fn failed(&mut self, fault: Fault) -> Option<Result<Entry>> {
        match self.file.newer(self.view) {
            Some(newer) => {
                self.view = newer;
                self.stack.clear();
                self.started = false;
                None
            }
            None => Some(Err(fault.named(self.file.name(), None))),
        }
    }

    fn descend(&mut self, offset: u32, interval: Interval) -> Option<Result<Entry>> {
        let fault = self.enter(offset, interval).err()?;
        self.failed(fault)
    }
}

impl Iterator for Entries<'_> {
    type Item = Result<Entry>;

    fn next(&mut self) -> Option<Result<Entry>> {
        loop {
            if self.low >= self.high {
                return None;
            }
            if !self.started {
                self.started = true;
                let root = self.view.header.btree_root as u32;
                if root == 0 {
                    return None;
                }
                if let Some(answer) = self.descend(root, ALL_IDS) {
                    return Some(answer);
                }
                continue;
            }
            let level = self.stack.last_mut()?;
            match level.next {
                Step::Child(i) => {
                    level.next = Step::Entry(i);
                    let interval = level.node.child_interval(i, &level.interval);
                    // Nothing between two neighbours: only a damaged node could be there.
                    if interval.start < self.high && interval.end > self.low {
                        let offset = level.node.branch(i);
                        if let Some(answer) = self.descend(offset, interval) {
                            return Some(answer);
                        }
                    }
                }
                Step::Entry(i) if i < level.node.len() => {
                    level.next = if level.node.is_leaf() {
                        Step::Entry(i + 1)
                    } else {
                        Step::Child(i + 1)
                    };
                    let entry = level.node.entry(i);
                    if u64::from(entry.id) >= self.high {
                        self.low = self.high;
                        return None;
                    }
                    if u64::from(entry.id) >= self.low {
                        self.low = u64::from(entry.id) + 1;
                        return Some(Ok(entry));
                    }
                }
                Step::Entry(_) => {
                    self.stack.pop();
                }
            }
        }
    }
}
