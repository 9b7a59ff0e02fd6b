//! The test vectors: independent results on worlds in real DAT format.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use vestibule_dat::DatSet;
use vestibule_world::World;

/// The folder of vectors; `None`, with a notice on stderr that names what is skipped, when it is not there.
pub fn vectors(skipped: &str) -> Option<PathBuf> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/vectors"));
    if folder.is_dir() {
        return Some(folder.to_owned());
    }
    // Not through the captured macros: people should see what was left out.
    let _ = writeln!(
        std::io::stderr(),
        "skipped: {skipped}, {} is not there",
        folder.display()
    );
    None
}

/// A world of the vectors; `None`, with a notice, without them.
///
/// # Panics
/// The vectors are there and the world is not.
pub fn vectors_world(name: &str) -> Option<World> {
    let folder = vectors(name)?.join("worlds").join(name);
    let dats = DatSet::open_in_memory(folder).expect("a world of the vectors opens");
    Some(World::open(dats).expect("a world of the vectors opens"))
}
