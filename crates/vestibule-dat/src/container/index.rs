//! The part of the directory that look-ups have come by, checked once (`dat-format.md` B8).
//!
//! Checking a node costs more than searching it. What has been checked is remembered by the way that led to it, so that a node
//! that is reached by two ways, or with other ids left to it, is checked for each. Nothing is read before it is asked for.

use super::chain::{Geometry, walk_chain};
use super::node::{ALL_IDS, ENTRIES_AT, ENTRY_SIZE, Entry, NODE_SIZE, Node};
use crate::error::Fault;
use std::sync::OnceLock;

/// What is known about the directory of one committed state. Shared between threads; look-ups never wait for each other.
#[derive(Default)]
pub(crate) struct Index {
    root: OnceLock<Checked>,
}

/// A node that has been read and found good.
enum Checked {
    Inner(Box<Inner>),
    /// A leaf stays in the file. If its blocks follow each other it is searched there.
    Leaf {
        count: usize,
        in_one_run: bool,
    },
}

struct Inner {
    node: Node,
    /// The ids once more, close together for the search.
    ids: Vec<u32>,
    below: Vec<OnceLock<Checked>>,
}

impl Index {
    /// The entry of `id` (B5). `root` is the offset of the root, not 0; `bytes` and `g` are always those of the same state.
    pub(crate) fn find(&self, bytes: &[u8], g: Geometry, root: u32, id: u32) -> Result<Option<Entry>, Fault> {
        let (mut slot, mut at) = (&self.root, root);
        let (mut interval, mut depth) = (ALL_IDS, 0);
        loop {
            let checked = match slot.get() {
                Some(checked) => checked,
                None => {
                    let checked = Checked::of(Node::read(&bytes, g, at, depth, &interval)?, bytes, g);
                    slot.get_or_init(|| checked)
                }
            };
            match checked {
                Checked::Inner(inner) => {
                    let i = inner.ids.partition_point(|own| *own < id);
                    if inner.ids.get(i) == Some(&id) {
                        return Ok(Some(inner.node.entry(i)));
                    }
                    let Some(below) = inner.below.get(i) else {
                        return Ok(None);
                    };
                    interval = inner.node.child_interval(i, &interval);
                    at = inner.node.branch(i);
                    slot = below;
                    depth += 1;
                }
                Checked::Leaf {
                    count,
                    in_one_run: true,
                } => return Ok(find_in_place(bytes, g, at, *count, id)),
                Checked::Leaf {
                    in_one_run: false, ..
                } => {
                    let node = Node::read(&bytes, g, at, depth, &interval)?;
                    let i = node.position(id);
                    return Ok((i < node.len() && node.id(i) == id).then(|| node.entry(i)));
                }
            }
        }
    }
}

impl Checked {
    fn of(node: Node, bytes: &[u8], g: Geometry) -> Checked {
        if node.is_leaf() {
            return Checked::Leaf {
                count: node.len(),
                in_one_run: in_one_run(bytes, g, node.offset),
            };
        }
        let ids = (0..node.len()).map(|i| node.id(i)).collect();
        let below = (0..=node.len()).map(|_| OnceLock::new()).collect();
        Checked::Inner(Box::new(Inner { node, ids, below }))
    }
}

fn in_one_run(bytes: &[u8], g: Geometry, start: u32) -> bool {
    let mut expected = u64::from(start);
    let mut good = true;
    let walked = walk_chain(&bytes, g, start, NODE_SIZE as u32, |at, _| {
        good &= u64::from(at) == expected;
        expected += u64::from(g.block_size);
        Ok(())
    });
    walked.is_ok() && good
}

/// Searches a leaf whose blocks follow each other from `start`, where it lies in the file.
fn find_in_place(bytes: &[u8], g: Geometry, start: u32, count: usize, id: u32) -> Option<Entry> {
    let payload = g.payload() as usize;
    // Blocks and fields are multiples of 4, so a word never lies in two blocks.
    let word = |at: usize| {
        let from = start as usize + at / payload * (payload + 4) + 4 + at % payload;
        let b = bytes.get(from..from + 4)?;
        Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    let entry_at = |i: usize| ENTRIES_AT + ENTRY_SIZE * i;
    let (mut low, mut high) = (0, count);
    while low < high {
        let mid = (low + high) / 2;
        if word(entry_at(mid) + 4)? < id {
            low = mid + 1;
        } else {
            high = mid;
        }
    }
    if low == count || word(entry_at(low) + 4)? != id {
        return None;
    }
    let mut entry = [0; ENTRY_SIZE];
    for (i, to) in entry.chunks_exact_mut(4).enumerate() {
        to.copy_from_slice(&word(entry_at(low) + 4 * i)?.to_le_bytes());
    }
    Some(Entry::parse(&entry))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::node::node_bytes;

    fn entry(id: u32) -> Entry {
        Entry {
            id,
            flags: 1,
            version: 2,
            offset: id + 3,
            size: id + 4,
            date: id + 5,
            iteration: 6,
        }
    }

    /// Writes a node in blocks of 256 at the given places.
    fn write(bytes: &mut [u8], places: &[u32], node: [u8; NODE_SIZE]) {
        for (i, (at, part)) in places.iter().zip(node.chunks(252)).enumerate() {
            let at = *at as usize;
            bytes[at..at + 4].copy_from_slice(&places.get(i + 1).unwrap_or(&0).to_le_bytes());
            bytes[at + 4..at + 4 + part.len()].copy_from_slice(part);
        }
    }

    #[test]
    fn b5_b8_remembered_nodes_answer_as_fresh_ones_do() {
        let mut bytes = vec![0; 0x4000];
        let g = Geometry {
            block_size: 256,
            file_size: 0x4000,
        };
        let run = |from: u32| (0..7).map(|i| from + 256 * i).collect::<Vec<_>>();
        let scattered = [0x2000, 0x2100, 0x2300, 0x2200, 0x2400, 0x2500, 0x2600];
        let leaf = |from: u32| (from..from + 61).map(|i| entry(2 * i)).collect::<Vec<_>>();
        write(
            &mut bytes,
            &run(0x400),
            node_bytes(&[entry(1000), entry(2000)], &[0x1000, 0x2000, 0x3000]),
        );
        write(&mut bytes, &run(0x1000), node_bytes(&leaf(10), &[]));
        write(&mut bytes, &scattered, node_bytes(&leaf(510), &[]));
        // The third leaf has ids that are not its own.
        write(&mut bytes, &run(0x3000), node_bytes(&leaf(900), &[]));
        let index = Index::default();
        let find = |id| index.find(&bytes, g, 0x400, id);
        for _ in 0..2 {
            for id in (0..1200).chain([2000]) {
                let there = id % 2 == 0 && ((20..142).contains(&id) || (1020..1142).contains(&id));
                let expected = (there || id == 1000 || id == 2000).then(|| entry(id));
                assert_eq!(find(id).unwrap(), expected, "{id}");
            }
            assert_eq!(
                find(2001).unwrap_err().field,
                "entry.id",
                "a damaged node fails each time"
            );
        }
    }
}
