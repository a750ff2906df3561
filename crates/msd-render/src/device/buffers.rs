//! Buffers on the device, which grow with the picture.

use wgpu::{Buffer, BufferUsages, Device, Queue};

/// A buffer of rows that is made anew, larger, when the rows do not fit.
#[derive(Debug)]
pub(crate) struct Rows {
    label: &'static str,
    usage: BufferUsages,
    buffer: Option<Buffer>,
    /// Number of rows that were uploaded last.
    pub count: u32,
}

impl Rows {
    /// An empty buffer; `usage` is the purpose of its rows.
    pub fn new(label: &'static str, usage: BufferUsages) -> Self {
        Self { label, usage: usage | BufferUsages::COPY_DST, buffer: None, count: 0 }
    }

    /// Uploads rows, as many as fit into the largest buffer of the device.
    pub fn upload<T: bytemuck::Pod>(&mut self, device: &Device, queue: &Queue, rows: &[T]) {
        let row_size = size_of::<T>() as u64;
        let most = device.limits().max_buffer_size / row_size;
        let count = (rows.len() as u64).min(most).min(u64::from(u32::MAX));
        if count < rows.len() as u64 && self.count as u64 != count {
            // Only when the count changes, else the log fills with every picture.
            log::warn!("{}: {} of {} rows fit and are drawn", self.label, count, rows.len());
        }
        self.count = count as u32;
        if count == 0 {
            return;
        }
        let bytes: &[u8] = bytemuck::cast_slice(&rows[..count as usize]);
        let needed = bytes.len() as u64;
        if self.buffer.as_ref().is_none_or(|buffer| buffer.size() < needed) {
            // Half as much again, so that a growing scene does not make a buffer every picture.
            let roomy = (needed + needed / 2).next_multiple_of(4);
            let size = roomy.min(device.limits().max_buffer_size / 4 * 4).max(needed);
            self.buffer = Some(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(self.label),
                size,
                usage: self.usage,
                mapped_at_creation: false,
            }));
        }
        if let Some(buffer) = &self.buffer {
            queue.write_buffer(buffer, 0, bytes);
        }
    }

    /// The buffer, if there is anything to draw.
    pub fn filled(&self) -> Option<&Buffer> {
        self.buffer.as_ref().filter(|_| self.count != 0)
    }
}
