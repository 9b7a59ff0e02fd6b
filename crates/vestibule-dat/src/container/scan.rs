//! The walk over everything: which blocks belong to which node and record.

use super::chain::{Geometry, ReadAt, walk_chain};
use super::header::Header;
use super::node::{ALL_IDS, Entry, Interval, NODE_SIZE, Node};
use crate::error::Fault;

/// Who a block belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Owner {
    /// The node at this offset.
    Node(u32),
    /// The record of this id.
    Record(u32),
    /// The free list.
    FreeList,
}

impl Owner {
    pub(crate) fn in_words(self) -> String {
        match self {
            Owner::Node(offset) => format!("the node at 0x{offset:X}"),
            Owner::Record(id) => format!("record 0x{id:08X}"),
            Owner::FreeList => "the free list".to_owned(),
        }
    }

    pub(crate) fn id(self) -> Option<u32> {
        match self {
            Owner::Record(id) => Some(id),
            Owner::Node(_) | Owner::FreeList => None,
        }
    }
}

/// What [`scan`] finds.
#[derive(Default)]
pub(crate) struct Scan {
    /// Every block of every node and record, in order of the walk.
    pub(crate) blocks: Vec<(u32, Owner)>,
    /// Blocks that empty records name; nothing reads them, so a wrong one is no error (C8).
    pub(crate) of_empty_records: Vec<u32>,
    /// What is damaged, with the record concerned.
    pub(crate) faults: Vec<(Option<u32>, Fault)>,
    pub(crate) records: usize,
    pub(crate) nodes: usize,
    pub(crate) depth: usize,
}

/// Walks the whole tree and every chain. `on_record` sees each entry whose chain is whole.
///
/// A damaged node or chain is noted and passed by. The walk ends on every file: nodes are bounded by B8, chains by C9.
pub(crate) fn scan<R: ReadAt>(
    bytes: &R,
    header: &Header,
    mut on_record: impl FnMut(&Entry, &mut Scan),
) -> Scan {
    let mut scan = Scan::default();
    let root = header.btree_root as u32;
    if root != 0 {
        scan_node(
            bytes,
            Geometry::of(header),
            root,
            0,
            &ALL_IDS,
            &mut scan,
            &mut on_record,
        );
    }
    scan
}

fn scan_node<R: ReadAt>(
    bytes: &R,
    g: Geometry,
    offset: u32,
    depth: usize,
    interval: &Interval,
    scan: &mut Scan,
    on_record: &mut impl FnMut(&Entry, &mut Scan),
) {
    let node = match Node::read(bytes, g, offset, depth, interval) {
        Ok(node) => Box::new(node),
        Err(fault) => {
            scan.faults.push((None, fault));
            return;
        }
    };
    scan.nodes += 1;
    scan.depth = scan.depth.max(depth + 1);
    claim(bytes, g, offset, NODE_SIZE as u32, Owner::Node(offset), scan);
    for i in 0..=node.len() {
        if !node.is_leaf() {
            let below = node.child_interval(i, interval);
            scan_node(bytes, g, node.branch(i), depth + 1, &below, scan, on_record);
        }
        if i < node.len() {
            let entry = node.entry(i);
            scan.records += 1;
            if entry.size == 0 {
                if g.holds(entry.offset, 0) {
                    scan.of_empty_records.push(entry.offset);
                }
                on_record(&entry, scan);
            } else if claim(bytes, g, entry.offset, entry.size, Owner::Record(entry.id), scan) {
                on_record(&entry, scan);
            }
        }
    }
}

/// Notes the blocks of a chain; false if the chain is damaged.
fn claim<R: ReadAt>(bytes: &R, g: Geometry, start: u32, n: u32, owner: Owner, scan: &mut Scan) -> bool {
    let blocks = &mut scan.blocks;
    let before = blocks.len();
    let done = walk_chain(bytes, g, start, n, |at, _| {
        blocks.push((at, owner));
        Ok(())
    });
    match done {
        Ok(()) => true,
        Err(fault) => {
            scan.blocks.truncate(before);
            scan.faults.push((owner.id(), fault));
            false
        }
    }
}
