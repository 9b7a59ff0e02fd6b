//! The parts of static objects in little memory, landblock by landblock, ready to be placed for an eye.

use glam::Vec3;
use vestibule_view::NumberMap;
use vestibule_world::{BlockId, CellId, Landblock, StaticRef, World};

use crate::model_table::ModelTable;

/// A landblock that was not walked through in so many walks is forgotten.
const KEPT_WALKS: u64 = 1024;
/// Every so many walks that is looked for.
const SWEEP: u64 = 256;

/// A part of a static object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StaticPart {
    /// Its frame in the landblock's.
    pub(crate) origin: Vec3,
    pub(crate) axes: [Vec3; 3],
    pub(crate) scale: Vec3,
    /// Of the model table.
    pub(crate) model: u32,
}

/// A static object: its cell and its parts, for [`StaticParts::parts`].
#[derive(Clone, Debug)]
pub(crate) struct StaticThing {
    pub(crate) cell: CellId,
    block: usize,
    parts: core::ops::Range<u32>,
}

/// The static objects of the landblocks that walks go through.
#[derive(Debug, Default)]
pub(crate) struct StaticParts {
    blocks: Vec<BlockParts>,
    positions: NumberMap<u16, u32>,
    /// The landblock asked for last: objects of one come together.
    last: Option<(BlockId, usize)>,
    walk: u64,
}

#[derive(Debug)]
struct BlockParts {
    id: BlockId,
    /// Where the world holds the objects: after a landblock was loaded again they lie elsewhere.
    source: (usize, usize),
    /// The cell of each object and its first part; one more than there are objects.
    objects: Vec<(CellId, u32)>,
    parts: Vec<StaticPart>,
    /// The walk it was last looked at in.
    walk: u64,
}

fn source_of(block: &Landblock) -> (usize, usize) {
    (block.statics.as_ptr() as usize, block.statics.len())
}

impl StaticParts {
    /// A walk begins: what is kept is held against the world again.
    pub(crate) fn begin(&mut self) {
        self.walk += 1;
        self.last = None;
        if self.walk.is_multiple_of(SWEEP) {
            let walk = self.walk;
            self.blocks.retain(|b| walk - b.walk < KEPT_WALKS);
            self.positions.clear();
            let places = self.blocks.iter().zip(0..);
            self.positions.extend(places.map(|(b, at)| (b.id.0, at)));
        }
    }

    /// A static object; `None` when the world does not have it.
    pub(crate) fn thing(
        &mut self,
        world: &World,
        models: &mut ModelTable,
        id: StaticRef,
    ) -> Option<StaticThing> {
        let block = match self.last {
            Some((last, block)) if last == id.block => block,
            _ => self.block(world, models, id.block)?,
        };
        self.last = Some((id.block, block));
        match self.blocks.get(block)?.objects.get(id.index as usize..)? {
            [(cell, first), (_, end), ..] => Some(StaticThing {
                cell: *cell,
                block,
                parts: *first..*end,
            }),
            _ => None,
        }
    }

    /// The parts of a static object of this walk.
    pub(crate) fn parts(&self, thing: &StaticThing) -> &[StaticPart] {
        let range = thing.parts.start as usize..thing.parts.end as usize;
        let block = self.blocks.get(thing.block);
        block.and_then(|b| b.parts.get(range)).unwrap_or(&[])
    }

    fn block(&mut self, world: &World, models: &mut ModelTable, id: BlockId) -> Option<usize> {
        let known = self.positions.get(&id.0).map(|&at| at as usize);
        if let Some(at) = known
            && self.blocks.get(at).is_some_and(|b| b.walk == self.walk)
        {
            return known;
        }
        let found = world.block(id)?;
        let at = known.unwrap_or_else(|| {
            self.positions.insert(id.0, self.blocks.len() as u32);
            self.blocks.push(BlockParts {
                id,
                source: (0, 0),
                objects: Vec::new(),
                parts: Vec::new(),
                walk: 0,
            });
            self.blocks.len() - 1
        });
        let kept = self.blocks.get_mut(at)?;
        if kept.source != source_of(found) {
            kept.fill(found, models);
        }
        kept.walk = self.walk;
        Some(at)
    }
}

impl BlockParts {
    fn fill(&mut self, block: &Landblock, models: &mut ModelTable) {
        self.source = source_of(block);
        self.objects.clear();
        self.parts.clear();
        for object in &block.statics {
            self.objects.push((object.cell, self.parts.len() as u32));
            for (part, frame) in object.shape.parts.iter().zip(&object.part_frames) {
                self.parts.push(StaticPart {
                    origin: frame.origin,
                    axes: *frame.axes(),
                    scale: part.scale,
                    model: models.position(part.model_id),
                });
            }
        }
        self.objects.push((CellId(0), self.parts.len() as u32));
    }
}
