//! The ray caster: passes over bands of the picture (7.2).

use std::time::{Duration, Instant};

use bytemuck::{Pod, bytes_of, cast_slice};
use pellucid_scene::{BLUE_NOISE_TILE, Control, Frame as Picture, Stage, StageVolume, blue_noise};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindingResource, Buffer, BufferBinding,
    BufferUsages, CommandEncoder, CommandEncoderDescriptor, ComputePassDescriptor, ComputePipeline, FilterMode,
    Sampler, SamplerDescriptor, TextureFormat, TextureView,
};

use crate::bricks::{self, Brick};
use crate::optics::{BlockContent, BlockMap, Optics, lights};
use crate::pipelines::Pipelines;
use crate::resident::Resident;
use crate::shaders::{Pass, Variant};
use crate::targets::Targets;
use crate::texture;
use crate::uniforms::{self, Frame, Light};
use crate::{Device, GpuError};

/// How long the commands of a submission may take: short enough to be cancelled in time, and far from
/// what drivers take for a hang.
const SUBMISSION: Duration = Duration::from_millis(25);

/// Most passes of a submission.
const MOST_PASSES: usize = 256;

/// How much is drawn at once, learnt from frame to frame.
pub struct Bands {
    /// Seconds that a ray took in the slowest band of the last frame.
    last: f64,
    /// The same of this frame so far.
    slowest: f64,
}

impl Default for Bands {
    /// A guess that lets the first frame begin with little: too little costs less than too much.
    fn default() -> Self {
        Self { last: 5e-6, slowest: 0.0 }
    }
}

impl Bands {
    /// Rays for the next submission.
    fn rays(&self) -> u64 {
        (SUBMISSION.as_secs_f64() / self.last.max(self.slowest)) as u64
    }

    fn learn(&mut self, rays: u64, took: Duration) {
        self.slowest = self.slowest.max(took.as_secs_f64() / rays as f64);
    }

    fn end_frame(&mut self) {
        *self = Self { last: self.slowest, slowest: 0.0 };
    }
}

/// Everything on the device that one frame is drawn with.
pub struct RayCaster<'a> {
    device: &'a Device,
    resident: &'a mut Resident,
    stage: &'a Stage,
    bricks: Vec<Brick>,
    march: ComputePipeline,
    resolve: ComputePipeline,
    frame_layout: BindGroupLayout,
    volume_layout: BindGroupLayout,
    table: BindGroup,
    blocks: TextureView,
    /// If the texture unit interpolates.
    sampler: Option<Sampler>,
    /// Frame, planes, noise, lights, levels.
    parts: [Buffer; 5],
}

impl<'a> RayCaster<'a> {
    /// Makes pipelines and tables.
    ///
    /// # Errors
    /// What the device reports.
    pub fn new(
        device: &'a Device,
        pipelines: &mut Pipelines,
        resident: &'a mut Resident,
        stage: &'a Stage,
        volume: &StageVolume,
        optics: &Optics,
        hardware: bool,
    ) -> Result<Self, GpuError> {
        let grid = volume.volume.grid();
        let region = stage.region(volume);
        let variant = Variant {
            pass: optics.pass,
            hardware: hardware && resident.encoding.filterable,
            holes: resident.encoding.holes,
            bricks: !resident.is_whole(),
            skip: optics.blocks.is_some(),
            shaded: volume.material.is_some() && lights(stage.mode()),
            weighted: volume.gradient_weight.is_some(),
            opaque: optics.opaque,
        }
        .canonical();
        let mut frame = Frame::new(stage, volume, &region);
        frame.set_values(resident.encoding.data(&volume.volume));
        frame.set_nodes(&optics.nodes);
        if let Some(blocks) = &optics.blocks {
            frame.set_blocks(blocks.dims, blocks.size);
        }
        let lights: Vec<Light> = stage.lights.iter().map(Light::from).collect();
        let noise: Vec<f32> = (0..BLUE_NOISE_TILE * BLUE_NOISE_TILE)
            .map(|cell| blue_noise(cell % BLUE_NOISE_TILE, cell / BLUE_NOISE_TILE, 0) as f32)
            .collect();
        let parts = [
            device.buffer("frame", bytes_of(&frame), BufferUsages::UNIFORM),
            storage(device, "planes", &uniforms::planes(&region, grid)),
            storage(device, "noise", &noise),
            storage(device, "lights", &lights),
            storage(device, "levels", &optics.levels),
        ];
        let blocks = block_texture(device, optics.blocks.as_ref(), optics.pass.compares_extremes());
        let resolve = pipelines.get(device, Variant::of(Pass::Resolve))?.pipeline.clone();
        let march = pipelines.get(device, variant)?;
        let entries = storage(device, "table", &optics.entries);
        let table = device.device.create_bind_group(&BindGroupDescriptor {
            label: Some("tables"),
            layout: &march.groups[2],
            entries: &[BindGroupEntry { binding: 0, resource: entries.as_entire_binding() }],
        });
        let mut bricks = resident.bricks.clone();
        bricks::sort(&mut bricks, stage, grid);
        Ok(Self {
            device,
            resident,
            stage,
            bricks,
            march: march.pipeline.clone(),
            resolve,
            frame_layout: march.groups[0].clone(),
            volume_layout: march.groups[1].clone(),
            table,
            blocks,
            sampler: variant.hardware.then(|| sampler(device)),
            parts,
        })
    }

    /// Draws all bands into a picture of the stage's size.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn draw(&mut self, bands: &mut Bands, control: &Control, picture: &mut Picture) -> Result<(), GpuError> {
        let (width, height) = (picture.width as u32, picture.height as u32);
        let rays = u64::from(width) * u64::from(self.stage.quality.supersampling.pow(2));
        let mut targets: Option<Targets> = None;
        let mut row = 0;
        while row < height {
            let most = self.resident.plan.rows.min(height - row);
            // The passes of bricks are many anyway: as many rows of each as there can be.
            let wanted = if self.resident.is_whole() { (bands.rays() / rays) as u32 } else { most };
            let rows = wanted.max(8).next_multiple_of(8).min(most);
            if targets.as_ref().is_none_or(|targets| !targets.fits(rows)) {
                // The old ones go first.
                drop(targets.take());
            }
            let targets = targets.get_or_insert_with(|| Targets::new(self.device, width, rows));
            self.draw_band(targets, (row, rows, width), bands, control)?;
            targets.read(self.device, row, rows, picture)?;
            row += rows;
            control.report(f64::from(row) / f64::from(height));
        }
        bands.end_frame();
        Ok(())
    }

    /// Draws rows: for every ray of a pixel one brick after the other, in submissions of bounded length.
    fn draw_band(
        &mut self,
        targets: &Targets,
        (row, rows, width): (u32, u32, u32),
        bands: &mut Bands,
        control: &Control,
    ) -> Result<(), GpuError> {
        let align = u64::from(self.device.capabilities.limits.min_uniform_buffer_offset_alignment);
        let stride = (size_of::<uniforms::Pass>() as u64).next_multiple_of(align) as usize;
        let (pixels, bricks) = (u64::from(width) * u64::from(rows), self.bricks.len());
        let turns = bricks * self.stage.quality.supersampling.pow(2) as usize;
        let mut turn = 0;
        while turn < turns {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            let together = if self.resident.is_complete() { (bands.rays() / pixels) as usize } else { 1 };
            let together = together.clamp(1, MOST_PASSES);
            let first = turn;
            turn = turns.min(turn + together);
            let mut passes = vec![0; stride * (turn - first)];
            for (turn, place) in (first..turn).zip(passes.chunks_mut(stride)) {
                place[..size_of::<uniforms::Pass>()].copy_from_slice(bytes_of(&self.pass(turn, row, rows)));
            }
            let passes = self.device.buffer("passes", &passes, BufferUsages::UNIFORM);
            let frame = self.frame_group(targets, &passes);
            let mut views = Vec::with_capacity(turn - first);
            for turn in first..turn {
                let brick = self.bricks[turn % bricks];
                views.push(self.resident.texture(self.device, &brick, control)?);
            }
            if self.resident.is_complete() {
                // Uploads are not what is measured.
                self.device.wait()?;
            }
            let started = Instant::now();
            let mut encoder = self.encoder();
            for (number, view) in views.iter().enumerate() {
                let offset = (number * stride) as u32;
                let volume = self.volume_group(view);
                let groups = [&frame, &volume, &self.table];
                dispatch(&mut encoder, &self.march, &groups, offset, width, rows);
                if (first + number + 1) % bricks == 0 {
                    dispatch(&mut encoder, &self.resolve, &groups, offset, width, rows);
                }
            }
            if turn == turns {
                targets.copy(&mut encoder, rows);
            }
            let submission = self.device.queue.submit([encoder.finish()]);
            if self.resident.is_complete() {
                self.device.wait()?;
                bands.learn(pixels * (turn - first) as u64, started.elapsed());
            } else {
                // Meanwhile the next brick may come.
                self.resident.used(submission);
                self.device.check()?;
            }
        }
        Ok(())
    }

    /// What a turn draws: a brick for one of the rays of the pixels.
    fn pass(&self, turn: usize, row: u32, rows: u32) -> uniforms::Pass {
        let (sub, number) = (turn / self.bricks.len(), turn % self.bricks.len());
        let brick = &self.bricks[number];
        let four = |[x, y, z]: [usize; 3], w| [x as u32, y as u32, z as u32, w];
        uniforms::Pass {
            rows: [row, rows, sub as u32, u32::MAX],
            texture_low: four(brick.voxels.low, u32::from(number == 0)),
            core_low: four(brick.core.low, 0),
            core_high: four(brick.core.high, 0),
        }
    }

    fn encoder(&self) -> CommandEncoder {
        self.device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("rays") })
    }

    fn frame_group(&self, targets: &Targets, passes: &Buffer) -> BindGroup {
        let [frame, planes, noise, lights, levels] = &self.parts;
        let size = std::num::NonZeroU64::new(size_of::<uniforms::Pass>() as u64);
        let pass = BindingResource::Buffer(BufferBinding { buffer: passes, offset: 0, size });
        let buffers = [(2, planes), (3, noise), (4, lights), (5, &targets.states), (6, levels), (7, &targets.pixels)];
        let mut entries = vec![
            BindGroupEntry { binding: 0, resource: frame.as_entire_binding() },
            BindGroupEntry { binding: 1, resource: pass },
        ];
        entries
            .extend(buffers.map(|(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() }));
        self.device.device.create_bind_group(&BindGroupDescriptor {
            label: Some("frame"),
            layout: &self.frame_layout,
            entries: &entries,
        })
    }

    fn volume_group(&self, volume: &TextureView) -> BindGroup {
        let mut entries = vec![
            BindGroupEntry { binding: 0, resource: BindingResource::TextureView(volume) },
            BindGroupEntry { binding: 2, resource: BindingResource::TextureView(&self.blocks) },
        ];
        if let Some(sampler) = &self.sampler {
            entries.push(BindGroupEntry { binding: 1, resource: BindingResource::Sampler(sampler) });
        }
        self.device.device.create_bind_group(&BindGroupDescriptor {
            label: Some("volume"),
            layout: &self.volume_layout,
            entries: &entries,
        })
    }
}

fn dispatch(
    encoder: &mut CommandEncoder,
    pipeline: &ComputePipeline,
    groups: &[&BindGroup; 3],
    offset: u32,
    width: u32,
    rows: u32,
) {
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor { label: None, timestamp_writes: None });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, groups[0], &[offset]);
    pass.set_bind_group(1, groups[1], &[]);
    pass.set_bind_group(2, groups[2], &[]);
    pass.dispatch_workgroups(width.div_ceil(8), rows.div_ceil(8), 1);
}

/// A buffer that shaders read; never empty, as bindings cannot be.
fn storage<T: Pod>(device: &Device, label: &str, content: &[T]) -> Buffer {
    let nothing = [0u8; 64];
    let contents = if content.is_empty() { &nothing } else { cast_slice(content) };
    device.buffer(label, contents, BufferUsages::STORAGE)
}

fn sampler(device: &Device) -> Sampler {
    device.device.create_sampler(&SamplerDescriptor {
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        ..Default::default()
    })
}

/// The blocks as a texture; a single one where none is asked.
fn block_texture(device: &Device, blocks: Option<&BlockMap>, extremes: bool) -> TextureView {
    let format = if extremes { TextureFormat::R32Float } else { TextureFormat::R8Uint };
    let (dims, bytes): ([usize; 3], &[u8]) = match blocks {
        None => ([1; 3], &[0; 4]),
        Some(BlockMap { dims, content: BlockContent::Distances(distances), .. }) => (*dims, distances),
        Some(BlockMap { dims, content: BlockContent::Extremes(extremes), .. }) => (*dims, cast_slice(extremes)),
    };
    let texture = texture::of_bytes(device, "blocks", format, dims, bytes);
    texture.create_view(&Default::default())
}
