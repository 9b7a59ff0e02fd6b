//! One buffer for the corners, or the indices, of all meshes, so that drawing another mesh changes no state.

/// A buffer that parts are taken from and given back to, counted in equal elements.
#[derive(Debug)]
pub(crate) struct Arena {
    label: &'static str,
    usage: wgpu::BufferUsages,
    /// Bytes of an element, a multiple of four.
    element: u64,
    elements: u64,
    pub(crate) buffer: wgpu::Buffer,
    /// Free parts (first, count) by their place; no two touch.
    free: Vec<(u64, u64)>,
}

impl Arena {
    pub(crate) fn new(
        device: &wgpu::Device,
        label: &'static str,
        usage: wgpu::BufferUsages,
        element: usize,
        elements: u64,
    ) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let element = element as u64;
        Arena {
            label,
            usage,
            element,
            elements,
            buffer: make(device, label, usage, element * elements),
            free: vec![(0, elements)],
        }
    }

    /// Takes so many elements; `None` when the adapter allows no larger buffer.
    pub(crate) fn take(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, count: u64) -> Option<u64> {
        let slot = match self.free.iter().position(|&(_, n)| n >= count) {
            Some(slot) => slot,
            None => {
                self.grow(device, queue, count)?;
                self.free.iter().position(|&(_, n)| n >= count)?
            }
        };
        let (at, there) = self.free[slot];
        if there == count {
            self.free.remove(slot);
        } else {
            self.free[slot] = (at + count, there - count);
        }
        Some(at)
    }

    /// Fills elements from this one on.
    pub(crate) fn write(&self, queue: &wgpu::Queue, at: u64, bytes: &[u8]) {
        queue.write_buffer(&self.buffer, at * self.element, bytes);
    }

    /// Gives elements back.
    pub(crate) fn give_back(&mut self, at: u64, count: u64) {
        if count == 0 {
            return;
        }
        let slot = self.free.partition_point(|&(first, _)| first < at);
        self.free.insert(slot, (at, count));
        if let Some(&(next, n)) = self.free.get(slot + 1)
            && at + count == next
        {
            self.free[slot].1 += n;
            self.free.remove(slot + 1);
        }
        if slot > 0 && self.free[slot - 1].0 + self.free[slot - 1].1 == at {
            self.free[slot - 1].1 += self.free[slot].1;
            self.free.remove(slot);
        }
    }

    fn grow(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, more: u64) -> Option<()> {
        let old = self.elements;
        let most = device.limits().max_buffer_size / self.element;
        let elements = (old + old.max(more)).min(most);
        if elements < old + more {
            return None;
        }
        let buffer = make(device, self.label, self.usage, elements * self.element);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&self.buffer, 0, &buffer, 0, old * self.element);
        queue.submit([encoder.finish()]);
        (self.buffer, self.elements) = (buffer, elements);
        self.give_back(old, elements - old);
        Some(())
    }
}

fn make(device: &wgpu::Device, label: &str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}
