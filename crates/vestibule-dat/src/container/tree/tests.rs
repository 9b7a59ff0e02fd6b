//! The worked split and every case of deletion, and any edits against a map.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeMap;

const G: Geometry = Geometry {
    block_size: 1024,
    file_size: 0,
};
const NO_BYTES: &[u8] = &[];
const NOTHING: Origin<'static, &[u8]> = Origin {
    bytes: &NO_BYTES,
    geometry: G,
};

fn entry(id: u32) -> Entry {
    Entry {
        id,
        flags: 0,
        version: 2,
        offset: 0,
        size: id,
        date: 0,
        iteration: 1,
    }
}

impl Tree {
    fn put(&mut self, from: &Origin<'_, &[u8]>, entry: Entry) -> Result<Option<Entry>, Fault> {
        let old = self.find(from, entry.id)?;
        match old {
            Some(_) => self.replace(from, entry)?,
            None => self.insert(from, entry)?,
        }
        Ok(old)
    }
}

fn tree(ids: impl IntoIterator<Item = u32>) -> Tree {
    let mut tree = Tree::new(0);
    for id in ids {
        assert_eq!(tree.put(&NOTHING, entry(id)).unwrap(), None);
    }
    tree
}

fn memory(child: Child) -> usize {
    match child {
        Child::Memory(i) => i,
        Child::Disk(_) => panic!("a node of a file"),
    }
}

fn root(t: &Tree) -> &MemNode {
    &t.nodes[memory(t.root.unwrap())]
}

fn child(t: &Tree, i: usize) -> &MemNode {
    &t.nodes[memory(root(t).children[i])]
}

fn ids(node: &MemNode) -> Vec<u32> {
    node.entries.iter().map(|e| e.id).collect()
}

/// Checks B3 and B7 everywhere and gives all ids in order.
fn check(t: &Tree) -> Vec<u32> {
    fn below(t: &Tree, node: &MemNode, is_root: bool, out: &mut Vec<u32>) -> usize {
        assert!(node.entries.len() <= MAX_ENTRIES);
        assert!(
            is_root || node.entries.len() >= MIN_ENTRIES,
            "{} entries",
            node.entries.len()
        );
        if node.is_leaf() {
            out.extend(ids(node));
            return 1;
        }
        assert_eq!(node.children.len(), node.entries.len() + 1);
        let mut depths = Vec::new();
        for (i, c) in node.children.iter().enumerate() {
            depths.push(below(t, &t.nodes[memory(*c)], false, out));
            out.extend(node.entries.get(i).map(|e| e.id));
        }
        assert!(depths.windows(2).all(|w| w[0] == w[1]), "leaves on one level");
        depths[0] + 1
    }
    let mut out = Vec::new();
    if t.root.is_some() {
        below(t, root(t), true, &mut out);
    }
    assert!(out.windows(2).all(|w| w[0] < w[1]));
    out
}

#[test]
fn example_12_6_split() {
    let mut t = tree(1..=61);
    assert!(root(&t).is_leaf());
    t.put(&NOTHING, entry(62)).unwrap();
    assert_eq!(ids(root(&t)), [31]);
    assert_eq!(ids(child(&t, 0)), (1..=30).collect::<Vec<_>>());
    assert_eq!(ids(child(&t, 1)), (32..=62).collect::<Vec<_>>());
}

#[test]
fn section_5_2_4_replace_keeps_the_shape() {
    let mut t = tree(1..=62);
    let old = t.put(&NOTHING, Entry { size: 7, ..entry(31) }).unwrap();
    assert_eq!(old, Some(entry(31)));
    assert_eq!(root(&t).entries[0].size, 7);
    assert_eq!(check(&t).len(), 62);
}

#[test]
fn section_5_3_1b_predecessor() {
    // Root [31], left 1..=30 and 0, right 32..=61.
    let mut t = tree((1..=62).chain([0]));
    t.remove(&NOTHING, 62).unwrap().unwrap();
    assert_eq!((child(&t, 0).entries.len(), child(&t, 1).entries.len()), (31, 30));
    assert_eq!(t.remove(&NOTHING, 31).unwrap(), Some(entry(31)));
    assert_eq!(ids(root(&t)), [30]);
    assert_eq!(ids(child(&t, 0)), (0..=29).collect::<Vec<_>>());
}

#[test]
fn section_5_3_1c_successor() {
    let mut t = tree(1..=62);
    t.remove(&NOTHING, 31).unwrap().unwrap();
    assert_eq!(ids(root(&t)), [32]);
    assert_eq!(ids(child(&t, 1)), (33..=62).collect::<Vec<_>>());
}

#[test]
fn section_5_3_1d_merge_around_the_key_and_5_3_3_root() {
    let mut t = tree(1..=62);
    t.remove(&NOTHING, 62).unwrap().unwrap();
    t.remove(&NOTHING, 31).unwrap().unwrap();
    assert!(root(&t).is_leaf());
    assert_eq!(ids(root(&t)), (1..=61).filter(|i| *i != 31).collect::<Vec<_>>());
}

#[test]
fn section_5_3_2a_rotate_from_the_left() {
    // Left 0..=30, 31 up, right 32..=61: taking from the right draws 31 down and 30 up.
    let mut t = tree((1..=62).chain([0]));
    t.remove(&NOTHING, 62).unwrap().unwrap();
    t.remove(&NOTHING, 40).unwrap().unwrap();
    assert_eq!(ids(root(&t)), [30]);
    assert_eq!(ids(child(&t, 1))[..2], [31, 32]);
    assert_eq!(check(&t).len(), 61);
}

#[test]
fn section_5_3_2b_rotate_from_the_right() {
    let mut t = tree(1..=62);
    t.remove(&NOTHING, 5).unwrap().unwrap();
    assert_eq!(ids(root(&t)), [32]);
    assert_eq!(ids(child(&t, 0))[28..], [30, 31]);
    assert_eq!(check(&t).len(), 61);
}

#[test]
fn section_5_3_2c_merge_with_the_right_or_the_left() {
    let mut t = tree(1..=62);
    t.remove(&NOTHING, 62).unwrap().unwrap();
    t.remove(&NOTHING, 5).unwrap().unwrap();
    assert!(root(&t).is_leaf());
    // The last child merges with the one to its left.
    let mut t = tree(1..=62);
    t.remove(&NOTHING, 62).unwrap().unwrap();
    t.remove(&NOTHING, 50).unwrap().unwrap();
    assert!(root(&t).is_leaf());
    assert_eq!(check(&t).len(), 60);
}

#[test]
fn an_absent_id_changes_nothing() {
    let mut t = tree(1..=62);
    t.remove(&NOTHING, 62).unwrap().unwrap();
    let before = format!("{:?}", t.nodes);
    assert_eq!(t.remove(&NOTHING, 99).unwrap(), None);
    assert_eq!(format!("{:?}", t.nodes), before);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any sequence of inserts, replacements and deletions leaves a tree of the right shape with the right entries.
    #[test]
    fn b3_b7_hold_after_any_edits(edits in proptest::collection::vec((0u32..700, 0u8..5), 0..2500)) {
        let mut t = Tree::new(0);
        let mut model = BTreeMap::new();
        for (step, (id, what)) in edits.into_iter().enumerate() {
            // Twice 1000 steps of growth, then of shrinking.
            let remove = if (step / 1000) % 2 == 0 { what == 0 } else { what != 0 };
            if remove {
                prop_assert_eq!(t.remove(&NOTHING, id).unwrap(), model.remove(&id));
            } else {
                let e = Entry { size: step as u32, ..entry(id) };
                prop_assert_eq!(t.put(&NOTHING, e).unwrap(), model.insert(id, e));
            }
            if step % 100 == 0 {
                check(&t);
            }
        }
        prop_assert_eq!(check(&t), model.keys().copied().collect::<Vec<_>>());
        for (id, e) in &model {
            prop_assert_eq!(t.find(&NOTHING, *id).unwrap(), Some(*e));
        }
    }
}
