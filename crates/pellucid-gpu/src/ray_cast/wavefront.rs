//! Rays that are followed for a while at a time: the lists of those that go on (7.4-1).

use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, MapMode};

use crate::{Device, GpuError};

/// The lists of rays that are not done: one is read while the other is written.
pub struct Front {
    lists: Buffer,
    copied: Buffer,
}

impl Front {
    /// Bytes of a count, and of all of them before the lists.
    const COUNT: u64 = 4;
    const COUNTS: u64 = 16;

    /// Lists of up to so many rays.
    pub fn new(device: &Device, rays: u32) -> Self {
        let buffer = |size, usage| {
            let descriptor = BufferDescriptor { label: Some("front"), size, usage, mapped_at_creation: false };
            device.device.create_buffer(&descriptor)
        };
        let lists = Self::COUNTS + 2 * u64::from(rays) * 4;
        Self {
            lists: buffer(lists, BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST),
            copied: buffer(Self::COUNT, BufferUsages::MAP_READ | BufferUsages::COPY_DST),
        }
    }

    /// The lists, to be bound.
    pub fn lists(&self) -> &Buffer {
        &self.lists
    }

    /// Empties a list.
    pub fn clear(&self, encoder: &mut CommandEncoder, list: u32) {
        encoder.clear_buffer(&self.lists, u64::from(list) * Self::COUNT, Some(Self::COUNT));
    }

    /// Submits commands, waits for them and tells how many rays are in a list.
    ///
    /// # Errors
    /// What the device reports.
    pub fn count(&self, device: &Device, mut encoder: CommandEncoder, list: u32) -> Result<u32, GpuError> {
        encoder.copy_buffer_to_buffer(&self.lists, u64::from(list) * Self::COUNT, &self.copied, 0, Self::COUNT);
        // A failure is reported by the device, too.
        encoder.map_buffer_on_submit(&self.copied, MapMode::Read, .., |_| ());
        device.queue.submit([encoder.finish()]);
        device.wait()?;
        let lost = |error: wgpu::MapRangeError| GpuError::Lost { reason: error.to_string() };
        let mapped = self.copied.slice(..).get_mapped_range().map_err(lost)?;
        let count = *bytemuck::from_bytes(&mapped);
        drop(mapped);
        self.copied.unmap();
        Ok(count)
    }
}
