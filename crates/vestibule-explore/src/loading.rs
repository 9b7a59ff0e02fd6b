//! Loading a world on a thread of its own, telling how far it is.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use vestibule_world::{Position, World};

use crate::explorer::Explorer;
use crate::places::NamedPlace;

/// A world that was opened.
#[derive(Debug)]
pub struct Opened {
    /// The world.
    pub world: World,
    /// Places with names.
    pub names: Vec<NamedPlace>,
    /// Where to begin.
    pub start: Position,
}

/// Opens a world, away from the window's thread. The error is shown in the window and ends the program.
pub type Open = Box<dyn FnOnce() -> Result<Opened, String> + Send>;

/// How far loading is.
#[derive(Debug)]
pub(crate) enum Progress {
    /// What is being done, and the share that is done.
    At(String, f32),
    /// All is there.
    Done(Box<Explorer>),
    /// It cannot be loaded, and why.
    Failed(String),
}

/// Rings of landblocks that are loaded before the first picture.
const RINGS: i32 = 3;

/// Loads a world.
pub(crate) fn start(open: Open) -> Receiver<Progress> {
    let (tell, told) = channel();
    std::thread::spawn(move || {
        let end = load(open, &tell);
        // The window may be closed by now.
        let _ = tell.send(end);
    });
    told
}

fn load(open: Open, tell: &Sender<Progress>) -> Progress {
    let say = |what: &str, share: f32| {
        let _ = tell.send(Progress::At(what.to_owned(), share));
    };
    say("opening the world", 0.02);
    let opened = match open() {
        Ok(opened) => opened,
        Err(why) => return Progress::Failed(why),
    };
    let world = Arc::new(opened.world);
    let centre = opened.start.cell.block();
    let side = 2 * RINGS + 1;
    for k in 0..side * side {
        let (dx, dy) = (k % side - RINGS, k / side - RINGS);
        if let Some(id) = centre.neighbour(dx, dy) {
            say(
                &format!("landblock {id}"),
                0.05 + 0.7 * k as f32 / (side * side) as f32,
            );
            if let Some(block) = world.block(id)
                && dx.abs() <= 1
                && dy.abs() <= 1
            {
                world.shadow_lists(block);
            }
        }
    }
    say("placing the player", 0.8);
    let explorer = match Explorer::new(world, opened.names, opened.start) {
        Ok(explorer) => explorer,
        Err(error) => return Progress::Failed(error.to_string()),
    };
    say("terrain and sky", 0.85);
    explorer.assets().terrain(explorer.world());
    explorer.assets().sky(explorer.world());
    Progress::Done(Box::new(explorer))
}
