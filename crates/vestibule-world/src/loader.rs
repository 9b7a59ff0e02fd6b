//! Loading landblocks off the thread that moves bodies.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

use crate::ids::BlockId;
use crate::landblock::{BoxedBlock, Landblock};
use crate::load;
use crate::records::Records;

/// What the loader is told to do.
enum Request {
    /// Load a landblock: all of it, or its terrain only.
    Load { id: BlockId, full: bool },
    /// Free memory: that too takes time.
    Drop(Vec<BoxedBlock>),
    /// Forget compiled assets that nothing uses any more.
    Prune,
}

/// A landblock that was asked for.
pub(crate) struct Loaded {
    pub(crate) id: BlockId,
    /// All of it, not its terrain only.
    pub(crate) full: bool,
    /// `None`: there is no such landblock.
    pub(crate) block: Option<Box<Landblock>>,
    pub(crate) bytes: usize,
}

/// Loads on a thread of its own, or at once where there are no threads.
pub(crate) struct Loader {
    records: Arc<Records>,
    thread: Option<(Sender<Request>, Receiver<Loaded>)>,
    /// Loaded at once, for want of a thread.
    done: std::collections::VecDeque<Loaded>,
}

impl Loader {
    pub(crate) fn new(records: Arc<Records>, threaded: bool) -> Self {
        let thread = if threaded { spawn(&records) } else { None };
        Loader {
            records,
            thread,
            done: Default::default(),
        }
    }

    pub(crate) fn load(&mut self, id: BlockId, full: bool) {
        if let Some((requests, _)) = &self.thread {
            if requests.send(Request::Load { id, full }).is_ok() {
                return;
            }
            self.thread = None;
        }
        self.done.push_back(load(&self.records, id, full));
    }

    pub(crate) fn drop_blocks(&mut self, blocks: Vec<BoxedBlock>) {
        if let (false, Some((requests, _))) = (blocks.is_empty(), &self.thread) {
            // A thread that is gone gives the blocks back, and they are dropped here.
            let _ = requests.send(Request::Drop(blocks));
        }
    }

    pub(crate) fn prune(&mut self) {
        match &self.thread {
            Some((requests, _)) => drop(requests.send(Request::Prune)),
            None => self.records.assets.prune(),
        }
    }

    /// The next landblock that is ready; waits for one if `wait`. `Err` when the thread is gone and what was asked
    /// of it is lost.
    pub(crate) fn next(&mut self, wait: bool) -> Result<Option<Loaded>, LoaderGone> {
        if let Some(loaded) = self.done.pop_front() {
            return Ok(Some(loaded));
        }
        let Some((_, results)) = &self.thread else {
            return Ok(None);
        };
        let gone = if wait {
            match results.recv() {
                Ok(loaded) => return Ok(Some(loaded)),
                Err(_) => true,
            }
        } else {
            match results.try_recv() {
                Ok(loaded) => return Ok(Some(loaded)),
                Err(e) => e == TryRecvError::Disconnected,
            }
        };
        if gone {
            self.thread = None;
            return Err(LoaderGone);
        }
        Ok(None)
    }
}

/// The loading thread has ended.
pub(crate) struct LoaderGone;

/// `None` where threads cannot be started.
fn spawn(records: &Arc<Records>) -> Option<(Sender<Request>, Receiver<Loaded>)> {
    let (requests, todo) = channel();
    let (finished, results) = channel();
    let records = Arc::clone(records);
    let work = move || {
        while let Ok(request) = todo.recv() {
            match request {
                Request::Load { id, full } => {
                    if finished.send(load(&records, id, full)).is_err() {
                        return;
                    }
                }
                Request::Drop(blocks) => drop(blocks),
                Request::Prune => records.assets.prune(),
            }
        }
    };
    let builder = std::thread::Builder::new().name("landblock loader".to_owned());
    builder.spawn(work).ok().map(|_| (requests, results))
}

fn load(records: &Records, id: BlockId, full: bool) -> Loaded {
    let block = if full {
        load::landblock(records, id)
    } else {
        load::landscape(records, id)
    };
    Loaded {
        id,
        full,
        bytes: block.as_ref().map_or(0, Landblock::memory),
        block: block.map(Box::new),
    }
}
