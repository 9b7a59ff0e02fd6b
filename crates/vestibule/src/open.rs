//! Opening a world's DAT files: a folder of them, or the world that is built in.

use std::path::Path;
use std::sync::Arc;

use vestibule_dat::DatSet;
use vestibule_world::{World, WorldError};

/// Name of the built-in world in messages.
pub const EMBEDDED_NAME: &str = "the embedded world";

/// Why a world cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// A DAT file is missing or damaged.
    #[error(transparent)]
    Dat(#[from] vestibule_dat::Error),
    /// The files do not make a world.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The built-in scene does not compile: a fault of this library.
    #[error("the embedded world does not compile: {0}")]
    Embedded(#[from] vestibule_forge::Diagnostics),
}

/// The DAT files of `folder`, or those of the embedded world.
///
/// ```
/// let dats = vestibule::open_dats(None)?;
/// assert!(dats.cell().iter().count() > 9);
/// # Ok::<(), vestibule::OpenError>(())
/// ```
///
/// # Errors
/// The folder lacks `client_portal.dat` or `client_cell_1.dat`, or a file in it is no DAT file.
pub fn open_dats(folder: Option<&Path>) -> Result<Arc<DatSet>, OpenError> {
    let dats = match folder {
        Some(folder) => DatSet::open(folder)?,
        None => vestibule_forge::embedded_world()?.dat_set()?,
    };
    Ok(Arc::new(dats))
}

/// The world of the DAT files of `folder`, or the embedded world. Landblocks load when they are first touched.
///
/// ```
/// use vestibule::world::BlockId;
///
/// let world = vestibule::open_world(None)?;
/// let village = world.block(BlockId(0xA9B4)).expect("the embedded world has a village");
/// assert!(!village.buildings.is_empty());
/// # Ok::<(), vestibule::OpenError>(())
/// ```
///
/// # Errors
/// As [`open_dats`], and when the Region record is missing or damaged.
pub fn open_world(folder: Option<&Path>) -> Result<World, OpenError> {
    Ok(World::open(open_dats(folder)?)?)
}
