//! The directory in memory while it is edited: the textbook B-tree of `dat-format.md` 5.2 and 5.3.
//!
//! Nodes come from the file when they are needed (and are checked then, B8) and stay in an arena. No operation leaves the
//! tree in disorder when a node cannot be read halfway: splits, rotations and merges keep every entry in order, and an entry
//! is taken out last.

use super::chain::{Geometry, ReadAt};
use super::node::{ALL_IDS, Entry, Interval, MAX_ENTRIES, MIN_ENTRIES, Node};
use crate::error::Fault;

/// Entry count below which a node is filled up before an entry is taken from it (t in 5.3).
const T: usize = MIN_ENTRIES + 1;

/// A node of the tree: still in the file, or in the arena.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Child {
    /// In the file at this offset.
    Disk(u32),
    /// In the arena at this index.
    Memory(usize),
}

#[derive(Debug, Default)]
pub(crate) struct MemNode {
    pub(crate) entries: Vec<Entry>,
    /// Empty for a leaf, else one more than entries.
    pub(crate) children: Vec<Child>,
    /// Where the file has the node, if it has it unchanged.
    pub(crate) on_disk: Option<u32>,
}

impl MemNode {
    fn is_leaf(&self) -> bool {
        self.children.is_empty()
    }

    fn position(&self, key: u32) -> usize {
        self.entries.partition_point(|e| e.id < key)
    }

    fn has(&self, i: usize, key: u32) -> bool {
        self.entries.get(i).is_some_and(|e| e.id == key)
    }
}

/// Where nodes are read from.
pub(crate) struct Origin<'a, R> {
    pub(crate) bytes: &'a R,
    pub(crate) geometry: Geometry,
}

/// The tree under edit.
#[derive(Debug)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<MemNode>,
    pub(crate) root: Option<Child>,
    /// Offsets of nodes in the file that the tree no longer uses.
    pub(crate) replaced: Vec<u32>,
}

/// A place on the way down: the node, its level and the ids it may hold.
#[derive(Clone)]
struct At {
    node: usize,
    depth: usize,
    interval: Interval,
}

impl Tree {
    pub(crate) fn new(root: u32) -> Tree {
        let root = (root != 0).then_some(Child::Disk(root));
        Tree {
            nodes: Vec::new(),
            root,
            replaced: Vec::new(),
        }
    }

    /// Looks up an entry (B5).
    pub(crate) fn find<R: ReadAt>(&mut self, from: &Origin<'_, R>, key: u32) -> Result<Option<Entry>, Fault> {
        let Some(mut at) = self.enter_root(from)? else {
            return Ok(None);
        };
        loop {
            let node = &self.nodes[at.node];
            let i = node.position(key);
            if node.has(i, key) {
                return Ok(Some(node.entries[i]));
            }
            if node.is_leaf() {
                return Ok(None);
            }
            at = self.enter(from, &at, i)?;
        }
    }

    /// Overwrites the entry of an id that is there (5.2.4): the shape stays.
    pub(crate) fn replace<R: ReadAt>(&mut self, from: &Origin<'_, R>, entry: Entry) -> Result<(), Fault> {
        let Some(mut at) = self.enter_root(from)? else {
            return Ok(());
        };
        loop {
            let i = self.nodes[at.node].position(entry.id);
            if self.nodes[at.node].has(i, entry.id) {
                self.change(at.node).entries[i] = entry;
                return Ok(());
            }
            if self.nodes[at.node].is_leaf() {
                return Ok(());
            }
            at = self.enter(from, &at, i)?;
        }
    }

    /// Inserts the entry of an id that is not there (5.2.1 to 5.2.3): full nodes are split on the way down.
    pub(crate) fn insert<R: ReadAt>(&mut self, from: &Origin<'_, R>, entry: Entry) -> Result<(), Fault> {
        let mut at = match self.enter_root(from)? {
            Some(at) => at,
            None => {
                self.root = Some(self.add(MemNode::default()));
                At {
                    node: self.nodes.len() - 1,
                    depth: 0,
                    interval: ALL_IDS,
                }
            }
        };
        if self.nodes[at.node].entries.len() == MAX_ENTRIES {
            let old = Child::Memory(at.node);
            let root = self.add(MemNode {
                children: vec![old],
                ..MemNode::default()
            });
            self.root = Some(root);
            at.node = self.nodes.len() - 1;
            let child = self.enter(from, &at, 0)?;
            self.split(at.node, 0, child.node);
        }
        loop {
            let mut i = self.nodes[at.node].position(entry.id);
            if self.nodes[at.node].is_leaf() {
                self.change(at.node).entries.insert(i, entry);
                return Ok(());
            }
            let child = self.enter(from, &at, i)?;
            if self.nodes[child.node].entries.len() == MAX_ENTRIES {
                self.split(at.node, i, child.node);
                if entry.id > self.nodes[at.node].entries[i].id {
                    i += 1;
                }
            }
            at = self.enter(from, &at, i)?;
        }
    }

    /// 5.2.3: splits the full node `child`, which stands under `parent` at `i`.
    fn split(&mut self, parent: usize, i: usize, child: usize) {
        let node = self.change(child);
        let right_entries = node.entries.split_off(MIN_ENTRIES + 1);
        let right_children = if node.is_leaf() {
            Vec::new()
        } else {
            node.children.split_off(MIN_ENTRIES + 1)
        };
        let Some(up) = node.entries.pop() else { return };
        let right = self.add(MemNode {
            entries: right_entries,
            children: right_children,
            on_disk: None,
        });
        let parent = self.change(parent);
        parent.entries.insert(i, up);
        parent.children.insert(i + 1, right);
    }

    /// 5.3: takes an entry out. Gives it, or `None` if it is not there.
    pub(crate) fn remove<R: ReadAt>(
        &mut self,
        from: &Origin<'_, R>,
        key: u32,
    ) -> Result<Option<Entry>, Fault> {
        // Known to be there, so that the way down does not rearrange anything for nothing.
        if self.find(from, key)?.is_none() {
            return Ok(None);
        }
        let Some(at) = self.enter_root(from)? else {
            return Ok(None);
        };
        let removed = self.remove_below(from, at, Target::Key(key));
        // 5.3.3: also after a failure, since a merge may have emptied the root before it.
        if let Some(Child::Memory(root)) = self.root
            && self.nodes[root].entries.is_empty()
            && let [only] = self.nodes[root].children[..]
        {
            self.drop_node(root);
            self.root = Some(only);
        }
        removed
    }

    /// Removes from the node at `at`, which has an entry to spare (or is the root), or from below it.
    fn remove_below<R: ReadAt>(
        &mut self,
        from: &Origin<'_, R>,
        mut at: At,
        target: Target,
    ) -> Result<Option<Entry>, Fault> {
        loop {
            let node = &self.nodes[at.node];
            let i = target.position(node);
            let here = match target {
                Target::Key(key) => node.has(i, key),
                Target::First | Target::Last => false,
            };
            if node.is_leaf() {
                // 5.3.1a
                let i = match target {
                    Target::Key(_) if !here => return Ok(None),
                    Target::Key(_) | Target::First => i,
                    Target::Last => node.entries.len().saturating_sub(1),
                };
                if i >= node.entries.len() {
                    return Ok(None);
                }
                return Ok(Some(self.change(at.node).entries.remove(i)));
            }
            if !here {
                // 5.3.2
                at = self.enter_with_spare(from, &at, i)?;
                continue;
            }
            // 5.3.1b to d. The neighbour in key order is taken from below first; the entry itself goes last.
            let left = self.enter(from, &at, i)?;
            let stand_in = if self.nodes[left.node].entries.len() >= T {
                self.remove_below(from, left, Target::Last)?
            } else {
                let right = self.enter(from, &at, i + 1)?;
                if self.nodes[right.node].entries.len() < T {
                    self.merge(at.node, i, left.node, right.node);
                    at = self.enter(from, &at, i)?;
                    continue;
                }
                self.remove_below(from, right, Target::First)?
            };
            let Some(stand_in) = stand_in else { return Ok(None) };
            return Ok(Some(std::mem::replace(
                &mut self.change(at.node).entries[i],
                stand_in,
            )));
        }
    }

    /// 5.3.2: goes to child `i`, after giving it an entry to spare.
    fn enter_with_spare<R: ReadAt>(&mut self, from: &Origin<'_, R>, at: &At, i: usize) -> Result<At, Fault> {
        let child = self.enter(from, at, i)?;
        if self.nodes[child.node].entries.len() >= T {
            return Ok(child);
        }
        let left = if i > 0 {
            Some(self.enter(from, at, i - 1)?.node)
        } else {
            None
        };
        if let Some(left) = left
            && self.nodes[left].entries.len() >= T
        {
            self.rotate_right(at.node, i, left, child.node);
            return self.enter(from, at, i);
        }
        let right = if i < self.nodes[at.node].entries.len() {
            Some(self.enter(from, at, i + 1)?.node)
        } else {
            None
        };
        match (left, right) {
            (_, Some(right)) if self.nodes[right].entries.len() >= T => {
                self.rotate_left(at.node, i, child.node, right);
                self.enter(from, at, i)
            }
            (_, Some(right)) => {
                self.merge(at.node, i, child.node, right);
                self.enter(from, at, i)
            }
            (Some(left), None) => {
                self.merge(at.node, i - 1, left, child.node);
                self.enter(from, at, i - 1)
            }
            // An only child: its parent is a root without entries, which the next removal does away with.
            (None, None) => Ok(child),
        }
    }

    /// 5.3.2a: the last entry of `left` goes up, the one between goes to the front of `child` (at `i`).
    fn rotate_right(&mut self, parent: usize, i: usize, left: usize, child: usize) {
        let node = self.change(left);
        let Some(up) = node.entries.pop() else { return };
        let moved = node.children.pop();
        let down = std::mem::replace(&mut self.change(parent).entries[i - 1], up);
        let node = self.change(child);
        node.entries.insert(0, down);
        if let Some(moved) = moved {
            node.children.insert(0, moved);
        }
    }

    /// 5.3.2b: the first entry of `right` goes up, the one between goes to the end of `child` (at `i`).
    fn rotate_left(&mut self, parent: usize, i: usize, child: usize, right: usize) {
        let node = self.change(right);
        if node.entries.is_empty() {
            return;
        }
        let up = node.entries.remove(0);
        let moved = (!node.is_leaf()).then(|| node.children.remove(0));
        let down = std::mem::replace(&mut self.change(parent).entries[i], up);
        let node = self.change(child);
        node.entries.push(down);
        node.children.extend(moved);
    }

    /// 5.3.1d, 5.3.2c: `left` (at `i`) takes the entry between and all of `right`.
    fn merge(&mut self, parent: usize, i: usize, left: usize, right: usize) {
        let gone = std::mem::take(self.change(right));
        self.drop_node(right);
        let node = self.change(parent);
        let between = node.entries.remove(i);
        node.children.remove(i + 1);
        let node = self.change(left);
        node.entries.push(between);
        node.entries.extend(gone.entries);
        node.children.extend(gone.children);
    }

    fn enter_root<R: ReadAt>(&mut self, from: &Origin<'_, R>) -> Result<Option<At>, Fault> {
        let Some(root) = self.root else { return Ok(None) };
        let node = self.load(from, root, 0, &ALL_IDS)?;
        self.root = Some(Child::Memory(node));
        Ok(Some(At {
            node,
            depth: 0,
            interval: ALL_IDS,
        }))
    }

    /// Goes to child `i` of the node at `at`, which is inner and has such a child.
    fn enter<R: ReadAt>(&mut self, from: &Origin<'_, R>, at: &At, i: usize) -> Result<At, Fault> {
        let parent = &self.nodes[at.node];
        let child = parent.children[i];
        let start = if i == 0 {
            at.interval.start
        } else {
            u64::from(parent.entries[i - 1].id) + 1
        };
        let end = parent.entries.get(i).map_or(at.interval.end, |e| u64::from(e.id));
        let (interval, depth) = (start..end, at.depth + 1);
        let node = self.load(from, child, depth, &interval)?;
        self.nodes[at.node].children[i] = Child::Memory(node);
        Ok(At {
            node,
            depth,
            interval,
        })
    }

    fn load<R: ReadAt>(
        &mut self,
        from: &Origin<'_, R>,
        child: Child,
        depth: usize,
        interval: &Interval,
    ) -> Result<usize, Fault> {
        let offset = match child {
            Child::Memory(node) => return Ok(node),
            Child::Disk(offset) => offset,
        };
        let node = Node::read(from.bytes, from.geometry, offset, depth, interval)?;
        let mut entries = Vec::with_capacity(MAX_ENTRIES);
        entries.extend((0..node.len()).map(|i| node.entry(i)));
        let children = match node.is_leaf() {
            true => Vec::new(),
            false => (0..=node.len()).map(|i| Child::Disk(node.branch(i))).collect(),
        };
        self.nodes.push(MemNode {
            entries,
            children,
            on_disk: Some(offset),
        });
        Ok(self.nodes.len() - 1)
    }

    fn add(&mut self, node: MemNode) -> Child {
        self.nodes.push(node);
        Child::Memory(self.nodes.len() - 1)
    }

    /// The node to change it: its copy in the file is out of use from now on.
    fn change(&mut self, node: usize) -> &mut MemNode {
        let node = &mut self.nodes[node];
        self.replaced.extend(node.on_disk.take());
        node
    }

    fn drop_node(&mut self, node: usize) {
        *self.change(node) = MemNode::default();
    }

    /// Sets where a record lies, in an entry that is there and whose nodes are changed already.
    pub(crate) fn set_offset(&mut self, key: u32, offset: u32) {
        let mut at = self.root;
        while let Some(Child::Memory(node)) = at {
            let node = &mut self.nodes[node];
            let i = node.position(key);
            if let Some(entry) = node.entries.get_mut(i)
                && entry.id == key
            {
                entry.offset = offset;
                return;
            }
            at = node.children.get(i).copied();
        }
    }

    /// Writes every node whose own bytes or whose children have moved, children first. `write` places the bytes of a node and
    /// gives their offset. Gives the offset of the root.
    pub(crate) fn write(
        &mut self,
        mut write: impl FnMut(&[Entry], &[u32]) -> Result<u32, Fault>,
    ) -> Result<u32, Fault> {
        match self.root {
            Some(root) => Ok(self.write_below(root, &mut write)?.0),
            None => Ok(0),
        }
    }

    /// Gives the offset of a node and whether it is new.
    fn write_below(
        &mut self,
        child: Child,
        write: &mut impl FnMut(&[Entry], &[u32]) -> Result<u32, Fault>,
    ) -> Result<(u32, bool), Fault> {
        let index = match child {
            Child::Disk(offset) => return Ok((offset, false)),
            Child::Memory(index) => index,
        };
        let children = self.nodes[index].children.clone();
        let mut offsets = Vec::with_capacity(children.len());
        let mut moved = false;
        for child in children {
            let (offset, new) = self.write_below(child, write)?;
            moved |= new;
            offsets.push(offset);
        }
        if let Some(offset) = self.nodes[index].on_disk
            && !moved
        {
            return Ok((offset, false));
        }
        let node = self.change(index);
        let offset = write(&node.entries, &offsets)?;
        node.on_disk = Some(offset);
        Ok((offset, true))
    }
}

/// What is to be removed: a key, or the first or last entry below a node.
#[derive(Clone, Copy)]
enum Target {
    Key(u32),
    First,
    Last,
}

impl Target {
    /// Where a node has the target, or the child that leads to it.
    fn position(self, node: &MemNode) -> usize {
        match self {
            Target::Key(key) => node.position(key),
            Target::First => 0,
            Target::Last => node.entries.len(),
        }
    }
}

#[cfg(test)]
mod tests;
