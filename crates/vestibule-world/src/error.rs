//! What can go wrong with the world's records.

use crate::ids::BlockId;

/// Errors that make a world unusable.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The Region record could not be used.
    #[error("{file}: Region record 0x{id:08X}: {reason}")]
    Region {
        /// File it was looked for in.
        file: String,
        /// Record id.
        id: u32,
        /// What is wrong, with offset and field where known.
        reason: String,
    },
}

/// A record that could not be used as it is. The rest of the world stays usable.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: record 0x{id:08X}: {kind}")]
pub struct LoadProblem {
    /// File the record is in, or was looked for in.
    pub file: String,
    /// Record id.
    pub id: u32,
    /// What is wrong.
    pub kind: ProblemKind,
}

/// Kinds of [`LoadProblem`], with what was done about them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProblemKind {
    /// Needed by another record but not there.
    #[error("missing, needed by record 0x{needed_by:08X}")]
    Missing {
        /// The record that refers to it.
        needed_by: u32,
    },
    /// The record cannot be parsed.
    #[error("unreadable: {0}")]
    Unreadable(String),
    /// An env cell names a cell structure that its environment does not have.
    #[error("environment 0x{environment:08X} has no cell structure {key}: the cell is treated as missing")]
    NoCellStruct {
        /// Environment record.
        environment: u32,
        /// Key that is absent.
        key: u16,
    },
    /// A portal's polygon is not among the cell structure's.
    #[error("portal {portal} names polygon {polygon}, which does not exist: portal dropped")]
    NoPortalPolygon {
        /// Index of the portal in the record.
        portal: u16,
        /// Id of the absent polygon.
        polygon: u16,
    },
    /// A building portal names a portal index that its cell does not have.
    #[error("building {building}, portal {portal}: no opposite portal in cell 0x{cell:08X}")]
    NoOppositePortal {
        /// Index of the building.
        building: u16,
        /// Index of its portal.
        portal: u16,
        /// The env cell behind it.
        cell: u32,
    },
    /// An object does not stand on a land cell of its own landblock.
    #[error("{what} {index} stands outside landblock {block}: discarded")]
    OutsideBlock {
        /// "building" or "static object".
        what: &'static str,
        /// Index in the record.
        index: u32,
        /// The landblock.
        block: BlockId,
    },
    /// A second building on one land cell (`world.md` C2).
    #[error(
        "building {index} shares land cell 0x{cell:08X} with another: only the first is found from there"
    )]
    SecondBuilding {
        /// Index of the later building.
        index: u32,
        /// The land cell.
        cell: u32,
    },
    /// The LandBlock says it has objects but there is no LandBlockInfo (`dat-format.md` L3).
    #[error("has_objects is set but the LandBlockInfo record is missing")]
    NoInfo,
    /// A number is not finite.
    #[error("{0} is not a finite number: skipped")]
    NotFinite(&'static str),
}
