//! How voxels get to the device: through a ring of buffers, one being filled while others are copied
//! (8.2-1). Nothing waits unless all of them are on their way.

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, COPY_BYTES_PER_ROW_ALIGNMENT, CommandEncoderDescriptor, MapMode, Origin3d,
    SubmissionIndex, TexelCopyBufferInfo, TexelCopyBufferLayout, TexelCopyTextureInfo, Texture, TextureAspect,
};

use crate::texture::{Encoding, extent};
use crate::{Device, GpuError};

/// A ring of buffers.
pub struct Staging {
    slots: Vec<Slot>,
    next: usize,
    bytes: usize,
}

struct Slot {
    buffer: Buffer,
    /// The copy out of it.
    copy: Option<SubmissionIndex>,
}

impl Staging {
    const SLOTS: u64 = 3;
    const ALIGNMENT: usize = COPY_BYTES_PER_ROW_ALIGNMENT as usize;

    /// Bytes that make uploads fast.
    pub const WANTED: u64 = Self::SLOTS * (4 << 20);

    /// Bytes without which nothing is uploaded: a row each.
    pub fn least(dims: [usize; 3], encoding: &Encoding) -> u64 {
        Self::SLOTS * Self::row(dims[0] * encoding.bytes) as u64
    }

    /// Bytes that a row takes: copies want them aligned.
    fn row(bytes: usize) -> usize {
        bytes.next_multiple_of(Self::ALIGNMENT)
    }

    /// A ring of so many bytes.
    pub fn new(device: &Device, bytes: u64) -> Self {
        let bytes = (bytes / Self::SLOTS) as usize / Self::ALIGNMENT * Self::ALIGNMENT;
        let slot = |_| Slot {
            buffer: device.device.create_buffer(&BufferDescriptor {
                label: Some("staging"),
                size: bytes as u64,
                usage: BufferUsages::MAP_WRITE | BufferUsages::COPY_SRC,
                mapped_at_creation: true,
            }),
            copy: None,
        };
        Self { slots: (0..Self::SLOTS).map(slot).collect(), next: 0, bytes }
    }

    /// Fills the texels of a box from `at` on. `fill` appends those of a row (y, z) of the box.
    ///
    /// # Errors
    /// What the device reports, or what `go_on` says, which is asked again and again.
    pub fn write(
        &mut self,
        device: &Device,
        texture: &Texture,
        at: [usize; 3],
        dims: [usize; 3],
        mut fill: impl FnMut(&mut Vec<u8>, usize, usize),
        go_on: impl Fn() -> Result<(), GpuError>,
    ) -> Result<(), GpuError> {
        let texel = texture.format().block_copy_size(None).unwrap_or(4) as usize;
        let row = Self::row(dims[0] * texel);
        // Whole slices, or as many rows of one as fit.
        let rows = (self.bytes / row).clamp(1, dims[1]);
        let slices = if rows == dims[1] { (self.bytes / (row * rows)).clamp(1, dims[2]) } else { 1 };
        let mut bytes = Vec::with_capacity(row * rows * slices);
        for z in (0..dims[2]).step_by(slices) {
            for y in (0..dims[1]).step_by(rows) {
                go_on()?;
                let (rows, slices) = (rows.min(dims[1] - y), slices.min(dims[2] - z));
                bytes.clear();
                for line in 0..rows * slices {
                    fill(&mut bytes, y + line % rows, z + line / rows);
                    bytes.resize((line + 1) * row, 0);
                }
                let origin = [at[0], at[1] + y, at[2] + z];
                self.send(device, texture, origin, [dims[0], rows, slices], &bytes)?;
            }
        }
        Ok(())
    }

    fn send(
        &mut self,
        device: &Device,
        texture: &Texture,
        [x, y, z]: [usize; 3],
        dims: [usize; 3],
        bytes: &[u8],
    ) -> Result<(), GpuError> {
        let count = self.slots.len();
        let slot = &mut self.slots[self.next];
        self.next = (self.next + 1) % count;
        if let Some(copy) = slot.copy.take() {
            device.wait_for(copy)?;
        }
        match slot.buffer.get_mapped_range_mut(..bytes.len() as u64) {
            Ok(mut view) => view.copy_from_slice(bytes),
            Err(error) => {
                device.check()?;
                return Err(GpuError::Lost { reason: error.to_string() });
            }
        }
        slot.buffer.unmap();
        let layout = TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some((bytes.len() / (dims[1] * dims[2])) as u32),
            rows_per_image: Some(dims[1] as u32),
        };
        let origin = Origin3d { x: x as u32, y: y as u32, z: z as u32 };
        let mut encoder = device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("upload") });
        encoder.copy_buffer_to_texture(
            TexelCopyBufferInfo { buffer: &slot.buffer, layout },
            TexelCopyTextureInfo { texture, mip_level: 0, origin, aspect: TextureAspect::All },
            extent(dims),
        );
        slot.copy = Some(device.queue.submit([encoder.finish()]));
        slot.buffer.map_async(MapMode::Write, .., |_| ());
        device.check()
    }
}
