//! How long the device itself worked, by its own clock.

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, CommandEncoder, ComputePassTimestampWrites, Features, MapMode, QuerySet,
    QuerySetDescriptor, QueryType, RenderPassTimestampWrites,
};

use crate::Device;

/// Pairs of marks of the device's clock: before the first and after the last pass of something. A mark is
/// set when all commands before it are done: uploads do not count.
pub struct Timer {
    marks: QuerySet,
    resolved: Buffer,
    copied: Buffer,
    seconds_per_tick: f64,
}

impl Timer {
    /// Pairs of marks that there are.
    pub const PAIRS: usize = 256;

    /// Bytes of a pair.
    const BYTES: u64 = 16;

    /// A timer, if the device has a clock.
    pub fn new(device: &Device) -> Option<Self> {
        if !device.capabilities.has(Features::TIMESTAMP_QUERY) {
            return None;
        }
        let buffer = |usage| {
            let size = Self::PAIRS as u64 * Self::BYTES;
            let descriptor = BufferDescriptor { label: Some("timer"), size, usage, mapped_at_creation: false };
            device.device.create_buffer(&descriptor)
        };
        let count = 2 * Self::PAIRS as u32;
        let marks = QuerySetDescriptor { label: Some("timer"), ty: QueryType::Timestamp, count };
        Some(Self {
            marks: device.device.create_query_set(&marks),
            resolved: buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            copied: buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            seconds_per_tick: f64::from(device.queue.get_timestamp_period()) * 1e-9,
        })
    }

    /// What a pass writes of a pair: its beginning if it is the first, its end if it is the last.
    pub fn writes(&self, pair: usize, first: bool, last: bool) -> Option<ComputePassTimestampWrites<'_>> {
        let mark = 2 * pair as u32;
        (first || last).then_some(ComputePassTimestampWrites {
            query_set: &self.marks,
            beginning_of_pass_write_index: first.then_some(mark),
            end_of_pass_write_index: last.then_some(mark + 1),
        })
    }

    /// The same of a pass that draws.
    pub fn render_writes(&self, pair: usize, first: bool, last: bool) -> Option<RenderPassTimestampWrites<'_>> {
        let ComputePassTimestampWrites { query_set, beginning_of_pass_write_index, end_of_pass_write_index } =
            self.writes(pair, first, last)?;
        Some(RenderPassTimestampWrites { query_set, beginning_of_pass_write_index, end_of_pass_write_index })
    }

    /// Makes the first `pairs` readable once the commands are done.
    pub fn copy(&self, encoder: &mut CommandEncoder, pairs: usize) {
        let bytes = pairs as u64 * Self::BYTES;
        encoder.resolve_query_set(&self.marks, 0..2 * pairs as u32, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copied, 0, bytes);
        encoder.map_buffer_on_submit(&self.copied, MapMode::Read, ..bytes, |_| ());
    }

    /// Seconds between the marks of the first `pairs`, all together, whose commands are done.
    pub fn seconds(&self, pairs: usize) -> Option<f64> {
        let mapped = self.copied.slice(..pairs as u64 * Self::BYTES).get_mapped_range().ok()?;
        let took = |&[from, to]: &[u64; 2]| to.saturating_sub(from);
        let ticks: u64 = bytemuck::cast_slice(&mapped).iter().map(took).sum();
        drop(mapped);
        self.copied.unmap();
        Some(ticks as f64 * self.seconds_per_tick)
    }
}
