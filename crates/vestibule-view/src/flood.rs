//! What one traversal yields: the cells that are seen, through which regions, and the openings to the outside
//! (`visibility.md` 15.1).

use vestibule_world::CellId;

use crate::constants::{MAX_EDGES, MAX_EDGES_RETAIL};
use crate::view::{Edge, Region};

/// How a traversal decides where retail and its modern form differ (`visibility.md` 14).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloodSettings {
    /// Enter only the root and the cells of its stab list (`visibility.md` 5.7). Off by default: entered cells that
    /// the list lacks are counted instead.
    pub stab_gate: bool,
    /// Views narrower than about this many pixels are dropped, and retail's clean-up of vertices is applied
    /// (`visibility.md` 3.3, 14.6). 0 keeps everything that has an area; retail's value is 1.
    pub min_px: f32,
    /// An eye on the plane of an opening (within 0.2 mm) and inside it sees all of its view through it
    /// (`visibility.md` 12.2). Without this the neighbour is lost for a frame, as in retail.
    pub admit_on_plane: bool,
    /// Use the neighbour that holds the eye when the eye is outside the root (`visibility.md` 12.3).
    pub guard_wrong_cell: bool,
    /// Most edges a view keeps; more are simplified outward, in retail mode cut off (`visibility.md` 3.3c, 14.5).
    pub max_edges: usize,
}

impl Default for FloodSettings {
    fn default() -> Self {
        FloodSettings {
            stab_gate: false,
            min_px: 0.0,
            admit_on_plane: true,
            guard_wrong_cell: true,
            max_edges: MAX_EDGES,
        }
    }
}

impl FloodSettings {
    /// Strict retail behaviour: the stab gate, the loss of views under a pixel, no help for an eye on a plane or in
    /// the wrong cell. The rule that makes every traversal end (`visibility.md` 6.5) stays.
    pub fn retail() -> Self {
        FloodSettings {
            stab_gate: true,
            min_px: 1.0,
            admit_on_plane: false,
            guard_wrong_cell: false,
            max_edges: MAX_EDGES_RETAIL,
        }
    }
}

/// What happened during a traversal, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FloodCounters {
    /// Openings in view that lead to a cell that is not loaded: holes in the picture.
    pub dead_portals: u32,
    /// Cells entered although the root's stab list lacks them.
    pub entered_outside_stab: u32,
    /// Views not added because their cell is one of their own ancestors (`visibility.md` 6.5).
    pub ancestor_rejections: u32,
    /// Cells moved forward in the list (`visibility.md` 6.2).
    pub moves: u32,
    /// Finished cells that received further views (`visibility.md` 6.3).
    pub incremental_clips: u32,
    /// Views with more edges than the settings allow, simplified outward.
    pub simplified_views: u32,
    /// Cells whose views were replaced by one that bounds them (`visibility.md` 13.4).
    pub saturated_cells: u32,
    /// Openings that the eye was on the plane and inside of.
    pub on_plane: u32,
    /// The eye was outside the root cell and a neighbour was used (`visibility.md` 12.3).
    pub wrong_cell: u32,
    /// The root cell is not loaded: nothing can be seen.
    pub missing_root: u32,
}

impl FloodCounters {
    pub(crate) fn add(&mut self, o: &FloodCounters) {
        self.dead_portals += o.dead_portals;
        self.entered_outside_stab += o.entered_outside_stab;
        self.ancestor_rejections += o.ancestor_rejections;
        self.moves += o.moves;
        self.incremental_clips += o.incremental_clips;
        self.simplified_views += o.simplified_views;
        self.saturated_cells += o.saturated_cells;
        self.on_plane += o.on_plane;
        self.wrong_cell += o.wrong_cell;
        self.missing_root += o.missing_root;
    }
}

/// A cell of the draw list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenCell {
    /// Which.
    pub id: CellId,
    /// Position in the list of the cell through which it was first reached; `None` for the root.
    pub reached_from: Option<u32>,
    /// Its todo priority, square metres (`visibility.md` 5.4).
    pub key: f32,
    /// Its views were replaced by one that bounds them.
    pub saturated: bool,
    pub(crate) first_view: u32,
    pub(crate) view_count: u32,
}

/// One region through which a cell, or the outside, is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenView {
    /// The view of the earlier cell it was clipped from, as an index for [`Flood::view`]; `None` for a start.
    pub parent: Option<u32>,
    /// Record index of the portal, in the earlier cell, that it came through.
    pub portal: Option<u16>,
    pub(crate) first_edge: u32,
    pub(crate) edge_count: u32,
}

/// A portal to the outside of a listed cell, to be sealed when the landscape is drawn (`rendering.md` 7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seal {
    /// The cell, by its position in the list.
    pub cell: u32,
    /// Record index of the portal.
    pub portal: u16,
    /// On a border of a 24 m piece: never drawn (`rendering.md` 7.3).
    pub on_block_border: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FloodRecord {
    pub(crate) cells: (u32, u32),
    pub(crate) views: (u32, u32),
    pub(crate) outside: (u32, u32),
    pub(crate) seals: (u32, u32),
    pub(crate) counters: FloodCounters,
    pub(crate) truncated: bool,
}

/// Results of traversals, one after the other, in shared arrays that are reused from frame to frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FloodArena {
    pub(crate) cells: Vec<SeenCell>,
    pub(crate) views: Vec<SeenView>,
    pub(crate) edges: Vec<Edge>,
    pub(crate) seals: Vec<Seal>,
    pub(crate) floods: Vec<FloodRecord>,
}

impl FloodArena {
    /// An empty one.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets all results, keeping the memory.
    pub fn clear(&mut self) {
        self.cells.clear();
        self.views.clear();
        self.edges.clear();
        self.seals.clear();
        self.floods.clear();
    }

    /// Number of results.
    pub fn len(&self) -> usize {
        self.floods.len()
    }

    /// Whether there is no result.
    pub fn is_empty(&self) -> bool {
        self.floods.is_empty()
    }

    /// One result.
    pub fn get(&self, index: usize) -> Option<Flood<'_>> {
        self.floods
            .get(index)
            .map(|&record| Flood { arena: self, record })
    }

    /// The last result; an empty one when there is none.
    pub(crate) fn last(&self) -> Flood<'_> {
        let record = self.floods.last().copied().unwrap_or_default();
        Flood { arena: self, record }
    }

    /// All results in order.
    pub fn iter(&self) -> impl Iterator<Item = Flood<'_>> {
        self.floods.iter().map(|&record| Flood { arena: self, record })
    }
}

/// The result of one traversal.
#[derive(Clone, Copy, Debug)]
pub struct Flood<'a> {
    arena: &'a FloodArena,
    record: FloodRecord,
}

impl<'a> Flood<'a> {
    /// The draw list: near to far, the root first. Draw it from the end.
    pub fn cells(&self) -> &'a [SeenCell] {
        slice(&self.arena.cells, self.record.cells)
    }

    /// The position of a cell in the list.
    pub fn position(&self, id: CellId) -> Option<usize> {
        self.cells().iter().position(|c| c.id == id)
    }

    /// Whether a cell is seen.
    pub fn sees(&self, id: CellId) -> bool {
        self.position(id).is_some()
    }

    /// The regions through which a listed cell is seen, in order of arrival.
    pub fn regions(&self, cell: &SeenCell) -> impl ExactSizeIterator<Item = Region<'a>> + Clone + use<'a> {
        self.regions_of((self.record.views.0 + cell.first_view, cell.view_count))
    }

    /// The views of a listed cell, with where they come from.
    pub fn views(&self, cell: &SeenCell) -> &'a [SeenView] {
        slice(
            &self.arena.views,
            (self.record.views.0 + cell.first_view, cell.view_count),
        )
    }

    /// A view by its index in this result.
    pub fn view(&self, index: u32) -> Option<&'a SeenView> {
        slice(&self.arena.views, self.record.views).get(index as usize)
    }

    /// The region of a view.
    pub fn region(&self, view: &SeenView) -> Region<'a> {
        Region::new(slice(&self.arena.edges, (view.first_edge, view.edge_count)))
    }

    /// The regions through which the outside shows; a union, they may overlap.
    pub fn outside(&self) -> impl ExactSizeIterator<Item = Region<'a>> + Clone + use<'a> {
        self.regions_of((self.record.views.0 + self.record.outside.0, self.record.outside.1))
    }

    /// The views through which the outside shows.
    pub fn outside_views(&self) -> &'a [SeenView] {
        slice(
            &self.arena.views,
            (self.record.views.0 + self.record.outside.0, self.record.outside.1),
        )
    }

    /// Whether the outside shows anywhere.
    pub fn sees_outside(&self) -> bool {
        self.record.outside.1 > 0
    }

    /// Every portal to the outside of every listed cell, facing or not (`visibility.md` 15.1).
    pub fn seals(&self) -> &'a [Seal] {
        slice(&self.arena.seals, self.record.seals)
    }

    /// What was counted.
    pub fn counters(&self) -> &FloodCounters {
        &self.record.counters
    }

    /// A limit was reached and regions were widened; no cell was dropped (`visibility.md` 13.4).
    pub fn truncated(&self) -> bool {
        self.record.truncated
    }

    /// Number of views of all cells and the outside.
    pub fn view_count(&self) -> usize {
        self.record.views.1 as usize
    }

    fn regions_of(&self, range: (u32, u32)) -> impl ExactSizeIterator<Item = Region<'a>> + Clone + use<'a> {
        let edges = &self.arena.edges;
        slice(&self.arena.views, range)
            .iter()
            .map(move |v| Region::new(slice(edges, (v.first_edge, v.edge_count))))
    }
}

fn slice<T>(all: &[T], (first, count): (u32, u32)) -> &[T] {
    let first = first as usize;
    all.get(first..first + count as usize).unwrap_or(&[])
}
