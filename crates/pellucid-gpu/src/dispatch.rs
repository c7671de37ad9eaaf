//! Passes that compute.

use wgpu::{BindGroup, CommandEncoder, ComputePassDescriptor, ComputePassTimestampWrites, ComputePipeline};

/// Adds a pass over `width` x `rows` invocations, in workgroups of 8 x 8.
pub fn dispatch(
    encoder: &mut CommandEncoder,
    pipeline: &ComputePipeline,
    groups: &[&BindGroup],
    offset: u32,
    [width, rows]: [u32; 2],
    timestamp_writes: Option<ComputePassTimestampWrites>,
) {
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor { label: None, timestamp_writes });
    pass.set_pipeline(pipeline);
    for (number, group) in groups.iter().enumerate() {
        // The first group has the passes, of which one is chosen.
        let offsets: &[u32] = if number == 0 { &[offset] } else { &[] };
        pass.set_bind_group(number as u32, *group, offsets);
    }
    pass.dispatch_workgroups(width.div_ceil(8), rows.div_ceil(8), 1);
}
