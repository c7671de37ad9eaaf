//! How long the device itself worked, by its own clock.

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, CommandEncoder, ComputePassTimestampWrites, Features, MapMode, QuerySet,
    QuerySetDescriptor, QueryType, RenderPassTimestampWrites,
};

use crate::Device;

/// Two marks of the device's clock: before the first and after the last pass of a submission.
pub struct Timer {
    marks: QuerySet,
    resolved: Buffer,
    copied: Buffer,
    seconds_per_tick: f64,
}

impl Timer {
    /// Bytes of the two marks.
    const BYTES: u64 = 16;

    /// A timer, if the device has a clock.
    pub fn new(device: &Device) -> Option<Self> {
        if !device.capabilities.has(Features::TIMESTAMP_QUERY) {
            return None;
        }
        let buffer = |usage| {
            let descriptor =
                BufferDescriptor { label: Some("timer"), size: Self::BYTES, usage, mapped_at_creation: false };
            device.device.create_buffer(&descriptor)
        };
        let marks = QuerySetDescriptor { label: Some("timer"), ty: QueryType::Timestamp, count: 2 };
        Some(Self {
            marks: device.device.create_query_set(&marks),
            resolved: buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            copied: buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            seconds_per_tick: f64::from(device.queue.get_timestamp_period()) * 1e-9,
        })
    }

    /// What a pass writes: its beginning if it is the first, its end if it is the last.
    pub fn writes(&self, first: bool, last: bool) -> Option<ComputePassTimestampWrites<'_>> {
        (first || last).then_some(ComputePassTimestampWrites {
            query_set: &self.marks,
            beginning_of_pass_write_index: first.then_some(0),
            end_of_pass_write_index: last.then_some(1),
        })
    }

    /// The same of a pass that draws.
    pub fn render_writes(&self, first: bool, last: bool) -> Option<RenderPassTimestampWrites<'_>> {
        let ComputePassTimestampWrites { query_set, beginning_of_pass_write_index, end_of_pass_write_index } =
            self.writes(first, last)?;
        Some(RenderPassTimestampWrites { query_set, beginning_of_pass_write_index, end_of_pass_write_index })
    }

    /// Makes the marks readable once the commands are done.
    pub fn copy(&self, encoder: &mut CommandEncoder) {
        encoder.resolve_query_set(&self.marks, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copied, 0, Self::BYTES);
        encoder.map_buffer_on_submit(&self.copied, MapMode::Read, .., |_| ());
    }

    /// Seconds between the marks of commands that are done.
    pub fn seconds(&self) -> Option<f64> {
        let mapped = self.copied.slice(..).get_mapped_range().ok()?;
        let [from, to]: [u64; 2] = *bytemuck::from_bytes(&mapped);
        drop(mapped);
        self.copied.unmap();
        Some(to.saturating_sub(from) as f64 * self.seconds_per_tick)
    }
}
