//! Passes that compute.

use wgpu::{BindGroup, CommandEncoder, ComputePassDescriptor, ComputePassTimestampWrites, ComputePipeline};

/// A pipeline and all that is bound to it.
pub struct Bound<'p> {
    /// The pipeline.
    pub pipeline: &'p ComputePipeline,
    /// Its groups.
    pub groups: [BindGroup; 3],
}

impl Bound<'_> {
    /// Adds a pass, as [`dispatch`] does.
    pub fn dispatch(
        &self,
        encoder: &mut CommandEncoder,
        offset: u32,
        size: [u32; 3],
        writes: Option<ComputePassTimestampWrites>,
    ) {
        dispatch(encoder, self.pipeline, self.groups.each_ref().map(Some), offset, size, writes);
    }
}

/// Adds a pass over `width` x `rows` x `layers` invocations, in workgroups of 8 x 8.
pub fn dispatch(
    encoder: &mut CommandEncoder,
    pipeline: &ComputePipeline,
    groups: [Option<&BindGroup>; 3],
    offset: u32,
    [width, rows, layers]: [u32; 3],
    timestamp_writes: Option<ComputePassTimestampWrites>,
) {
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor { label: None, timestamp_writes });
    pass.set_pipeline(pipeline);
    for (number, group) in groups.into_iter().enumerate() {
        // The first group has the passes, of which one is chosen.
        let offsets: &[u32] = if number == 0 { &[offset] } else { &[] };
        pass.set_bind_group(number as u32, group, offsets);
    }
    pass.dispatch_workgroups(width.div_ceil(8), rows.div_ceil(8), layers);
}
