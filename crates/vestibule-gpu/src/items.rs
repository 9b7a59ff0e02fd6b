//! The things of a frame in the order in which the GPU is told of them, and what is sent with them. Opaque things between
//! two barriers are put in an order that changes little state, see-through ones are put aside until a flush
//! (`rendering.md` 9.3, 9.4, 14.7).

use vestibule_render::NumberMap;

use crate::uniforms::{FrameUniform, IndexStream, Instance, Lists, Sent, Stream};

/// One thing the GPU is told to do.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Item {
    /// Instances of triangles.
    Mesh {
        pipeline: u32,
        array: u16,
        /// Of the lists; `None` when it does not matter.
        window: Option<u16>,
        indices: (u32, u32),
        instances: (u32, u32),
    },
    /// Indices of the ground.
    Ground {
        pipeline: u32,
        indices: (u32, u32),
    },
    /// Columns and rows: from, to, from, to.
    Sky {
        pipeline: u32,
        bounds: [u32; 4],
    },
    /// Corners of a punch or a seal.
    Depth {
        pipeline: u32,
        points: (u32, u32),
    },
    ClearDepth,
}

/// Triangles of a mesh that are drawn at once, not yet in order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draw {
    pub(crate) pipeline: u32,
    /// The array of its textures.
    pub(crate) array: u16,
    pub(crate) window: Option<u16>,
    pub(crate) indices: (u32, u32),
    pub(crate) instance: Instance,
}

impl Draw {
    /// What must be equal for two draws to be one, those first that cost the most to change; the lowest 32 bits are left
    /// for the position.
    fn order(&self) -> u128 {
        let window = self.window.map_or(0, |w| u128::from(w) + 1);
        u128::from(self.pipeline) << 97
            | u128::from(self.array) << 81
            | window << 64
            | u128::from(self.indices.0) << 32
    }
}

#[derive(Clone, Copy, Debug)]
struct Deferred {
    /// To the middle of its mesh, metres; `None` for cut-outs.
    distance: Option<f64>,
    draw: Draw,
}

/// The things of a frame in order, and what is sent with them. Kept from frame to frame for its memory.
#[derive(Debug)]
pub(crate) struct Items {
    pub(crate) list: Vec<Item>,
    pub(crate) stream: Stream,
    pub(crate) ground_indices: IndexStream,
    /// The exits that the landscape is kept behind, in the points.
    pub(crate) limits: (u32, u32),
    pub(crate) points: Vec<[f32; 4]>,
    pub(crate) lists: Lists,
    /// What may be drawn in any order before the next barrier, and what waits for the next flush.
    opaque: Vec<Draw>,
    deferred: Vec<Deferred>,
    order: Vec<u128>,
    /// Land cells in view by slot: those with their base texture only, and the others.
    pub(crate) ground: Vec<(u32, u64, u64)>,
    pub(crate) ground_slots: NumberMap<u32, u32>,
}

/// What a frame was made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameStats {
    /// Draw calls.
    pub draws: u32,
    /// Triangles, behind or outside the screen included.
    pub triangles: u32,
    /// Things a command names that the world or the assets do not have.
    pub missing: u32,
    /// Rooms confined to their regions because they overlap another.
    pub confined: u32,
    /// Punches and seals.
    pub portals: u32,
}

impl Items {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        Items {
            list: Vec::new(),
            stream: Stream::new(device),
            ground_indices: IndexStream::new(device),
            limits: (0, 0),
            points: Vec::new(),
            lists: Lists::default(),
            opaque: Vec::new(),
            order: Vec::new(),
            deferred: Vec::new(),
            ground: Vec::new(),
            ground_slots: NumberMap::default(),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.list.clear();
        self.ground_indices.indices.clear();
        self.limits = (0, 0);
        self.stream.begin();
        self.points.clear();
        self.lists.clear();
        self.opaque.clear();
        self.deferred.clear();
        self.ground.clear();
        self.ground_slots.clear();
    }

    /// Sends everything. Returns whether the buffer is another one now.
    pub(crate) fn send(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &FrameUniform,
        lands: &[[f32; 4]],
    ) -> bool {
        self.ground_indices.send(device, queue);
        let sent = Sent {
            frame,
            lists: &self.lists,
            points: &self.points,
            lands,
        };
        self.stream.send(device, queue, &sent)
    }

    /// Puts aside what may be drawn in any order before the next barrier.
    pub(crate) fn add_opaque(&mut self, draw: Draw) {
        self.opaque.push(draw);
    }

    /// Puts aside what is see-through. `distance`: metres to the middle of its mesh; `None` for cut-outs.
    pub(crate) fn add_deferred(&mut self, draw: Draw, distance: Option<f64>) {
        self.deferred.push(Deferred { distance, draw });
    }

    pub(crate) fn has_deferred(&self) -> bool {
        !self.deferred.is_empty()
    }

    /// Draws what was put aside as opaque, in an order that changes little state.
    pub(crate) fn draw_opaque(&mut self, stats: &mut FrameStats) {
        if self.opaque.is_empty() {
            return;
        }
        let (mut opaque, mut order) = (
            core::mem::take(&mut self.opaque),
            core::mem::take(&mut self.order),
        );
        order.clear();
        order.extend(opaque.iter().zip(0u32..).map(|(d, k)| d.order() | u128::from(k)));
        order.sort_unstable();
        for &key in &order {
            self.mesh(&opaque[key as u32 as usize], stats);
        }
        opaque.clear();
        (self.opaque, self.order) = (opaque, order);
    }

    /// Draws what was put aside as see-through: cut-outs as they came, then the others far to near (`rendering.md` 14.7).
    pub(crate) fn draw_deferred(&mut self, stats: &mut FrameStats) {
        let (mut deferred, mut order) = (
            core::mem::take(&mut self.deferred),
            core::mem::take(&mut self.order),
        );
        order.clear();
        order.extend(deferred.iter().zip(0u32..).map(|(d, k)| {
            // Bits of non-negative floats sort as the floats do; the farthest has the smallest complement.
            let late = d.distance.map_or(0, |v| 1 << 64 | u128::from(!v.to_bits()));
            late << 32 | u128::from(k)
        }));
        order.sort_unstable();
        for &key in &order {
            self.mesh(&deferred[key as u32 as usize].draw, stats);
        }
        deferred.clear();
        (self.deferred, self.order) = (deferred, order);
    }

    /// Draws instances of triangles; those of the same as before, with it.
    pub(crate) fn mesh(&mut self, draw: &Draw, stats: &mut FrameStats) {
        let at = self.stream.add(&draw.instance);
        stats.triangles += draw.indices.1 / 3;
        if let Some(Item::Mesh {
            pipeline,
            array,
            window,
            indices,
            instances,
        }) = self.list.last_mut()
            && (*pipeline, *array, *window) == (draw.pipeline, draw.array, draw.window)
            && *indices == draw.indices
        {
            instances.1 = at + 1;
            return;
        }
        stats.draws += 1;
        self.list.push(Item::Mesh {
            pipeline: draw.pipeline,
            array: draw.array,
            window: draw.window,
            indices: draw.indices,
            instances: (at, at + 1),
        });
    }
}
