//! The ray caster: passes over bands of the picture (7.2).

use std::time::{Duration, Instant};

use bytemuck::{Pod, bytes_of, cast_slice};
use pellucid_field::{Filter, Gradient};
use pellucid_scene::{
    BLUE_NOISE_TILE, BlockContent, BlockMap, Control, Frame as Picture, Stage, StageVolume, blue_noise,
};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindingResource, Buffer, BufferBinding,
    BufferDescriptor, BufferUsages, CommandEncoder, CommandEncoderDescriptor, ComputePassDescriptor, ComputePipeline,
    FilterMode, MapMode, SamplerDescriptor, TextureFormat, TextureView,
};

use crate::bricks::{self, Brick};
use crate::kernels::Kernels;
use crate::optics::{Optics, lights};
use crate::pipelines::Pipelines;
use crate::resident::Resident;
use crate::shaders::{Pass, Variant};
use crate::texture;
use crate::uniforms::{self, Frame, Light, Pixel};
use crate::{Device, GpuError};

/// How long the commands of a submission may take: short enough to be cancelled in time, and far from
/// what drivers take for a hang.
const SUBMISSION: Duration = Duration::from_millis(40);

/// Most bytes of the states of a band's rays.
const BAND_BYTES: u64 = 64 << 20;

/// How many rows of a picture are drawn at once, learnt from frame to frame.
#[derive(Default)]
pub struct Bands {
    /// Seconds a row of the last frame took, and the pixels and rays of it.
    row: Option<(f64, u64)>,
}

impl Bands {
    /// Rows for the next submission.
    fn rows(&self, work: u64, most: u32) -> u32 {
        let rows = match self.row {
            Some((seconds, of)) => SUBMISSION.as_secs_f64() / (seconds * work as f64 / of as f64).max(1e-9),
            None => 16.0,
        };
        (rows as u32).clamp(8, most.max(8)).next_multiple_of(8)
    }

    /// What rows took. What is learnt rises at once and falls slowly, as rows differ.
    fn learn(&mut self, rows: u32, work: u64, took: Duration) {
        let seconds = took.as_secs_f64() / f64::from(rows);
        let old = self.row.map_or(0.0, |(seconds, of)| seconds * work as f64 / of as f64);
        self.row = Some((seconds.max(old * 0.7), work));
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
    kernels: Option<Buffer>,
    variant: Variant,
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
        let (filter, gradient) = (optics.tables.filter, stage.quality.gradient);
        let encoding = resident.encoding();
        let variant = Variant {
            pass: optics.pass,
            hardware: hardware && encoding.filterable && filter == Filter::Linear,
            holes: encoding.holes,
            bricks: !resident.is_whole(),
            skip: optics.blocks.is_some(),
            shaded: volume.material.is_some() && lights(stage.mode()),
            weighted: volume.gradient_weight.is_some(),
            opaque: optics.opaque,
            kernels: filter != Filter::Linear || (gradient != Gradient::Central && lights(stage.mode())),
            strides: optics.blocks.is_some_and(|blocks| blocks.levels.is_some()),
        }
        .canonical();
        let mut frame = Frame::new(stage, volume, &region);
        frame.set_values(resident.field().data());
        frame.set_nodes(&optics.nodes);
        if let Some(blocks) = optics.blocks {
            frame.set_blocks(blocks.dims, blocks.size);
        }
        let lights: Vec<Light> = stage.lights.iter().map(Light::from).collect();
        let noise: Vec<f32> = (0..BLUE_NOISE_TILE * BLUE_NOISE_TILE)
            .map(|cell| blue_noise(cell % BLUE_NOISE_TILE, cell / BLUE_NOISE_TILE, 0) as f32)
            .collect();
        let uniform = BufferInitDescriptor {
            label: Some("frame"),
            contents: bytes_of(&frame),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        };
        let parts = [
            device.device.create_buffer_init(&uniform),
            storage(device, "planes", &uniforms::planes(&region, grid)),
            storage(device, "noise", &noise),
            storage(device, "lights", &lights),
            storage(device, "levels", &optics.levels),
        ];
        let blocks = block_texture(device, optics.blocks, optics.pass.compares_extremes());
        let kernels = variant.kernels.then(|| {
            let kernels = Kernels::new(filter, gradient, resident.voxels().data()).to_fours();
            let contents = cast_slice(&kernels);
            let usage = BufferUsages::UNIFORM;
            device.device.create_buffer_init(&BufferInitDescriptor { label: Some("kernels"), contents, usage })
        });
        let resolve = pipelines.get(device, Variant::of(Pass::Resolve))?.pipeline.clone();
        let march = pipelines.get(device, variant)?;
        let entries = storage(device, "table", optics.entries);
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
            kernels,
            variant,
            parts,
        })
    }

    /// Draws all bands into a picture of the stage's size.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn draw(&mut self, bands: &mut Bands, control: &Control, picture: &mut Picture) -> Result<(), GpuError> {
        let (width, height) = (picture.width as u32, picture.height as u32);
        let rays = self.stage.quality.supersampling.pow(2);
        let most = (BAND_BYTES / (uniforms::STATE_BYTES * u64::from(width))).max(1) as u32;
        let work = u64::from(width) * u64::from(rays);
        let mut targets: Option<Targets> = None;
        let mut row = 0;
        while row < height {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            let rows = bands.rows(work, most.min(height)).min(most).min(height - row);
            if targets.as_ref().is_none_or(|targets| targets.rows < rows) {
                targets = Some(Targets::new(self.device, width, rows));
            }
            let Some(targets) = &targets else { continue };
            let started = Instant::now();
            self.draw_band(targets, row, rows, rays)?;
            targets.read(self.device, row, rows, picture)?;
            bands.learn(rows, work, started.elapsed());
            row += rows;
            control.report(f64::from(row) / f64::from(height));
        }
        Ok(())
    }

    fn draw_band(&mut self, targets: &Targets, row: u32, rows: u32, rays: u32) -> Result<(), GpuError> {
        let align = u64::from(self.device.capabilities.limits.min_uniform_buffer_offset_alignment);
        let stride = (size_of::<uniforms::Pass>() as u64).next_multiple_of(align);
        let count = self.bricks.len() as u64 * u64::from(rays);
        let mut passes = vec![0u8; (stride * count) as usize];
        let every =
            (0..rays).flat_map(|sub| self.bricks.iter().enumerate().map(move |(number, brick)| (sub, number, brick)));
        for ((sub, number, brick), place) in every.zip(passes.chunks_mut(stride as usize)) {
            let four = |[x, y, z]: [usize; 3], w| [x as u32, y as u32, z as u32, w];
            let pass = uniforms::Pass {
                rows: [row, rows, sub, u32::MAX],
                texture_low: four(brick.voxels.low, u32::from(number == 0)),
                core_low: four(brick.core.low, 0),
                core_high: four(brick.core.high, 0),
            };
            place[..size_of::<uniforms::Pass>()].copy_from_slice(bytes_of(&pass));
        }
        let usage = BufferUsages::UNIFORM;
        let passes = self.device.device.create_buffer_init(&BufferInitDescriptor {
            label: Some("passes"),
            contents: &passes,
            usage,
        });
        let frame = self.frame_group(targets, &passes);
        let mut encoder = self.encoder();
        for sub in 0..rays {
            let mut offset = 0;
            for number in 0..self.bricks.len() {
                let brick = self.bricks[number];
                let views = self.resident.textures(self.device, &brick)?;
                let volume = self.volume_group(&views);
                offset = ((u64::from(sub) * self.bricks.len() as u64 + number as u64) * stride) as u32;
                dispatch(&mut encoder, &self.march, &[&frame, &volume, &self.table], offset, targets.width, rows);
                if !self.resident.is_complete() {
                    // The next upload needs the memory of this brick.
                    self.device.queue.submit([std::mem::replace(&mut encoder, self.encoder()).finish()]);
                    self.device.wait()?;
                }
                if number + 1 == self.bricks.len() {
                    dispatch(&mut encoder, &self.resolve, &[&frame, &volume, &self.table], offset, targets.width, rows);
                }
            }
            let _ = offset;
        }
        targets.copy(&mut encoder, rows);
        self.device.queue.submit([encoder.finish()]);
        Ok(())
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

    fn volume_group(&self, [field, voxels]: &[TextureView; 2]) -> BindGroup {
        let sampler = self.device.device.create_sampler(&SamplerDescriptor {
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..Default::default()
        });
        let mut entries = vec![
            BindGroupEntry { binding: 0, resource: BindingResource::TextureView(field) },
            BindGroupEntry { binding: 2, resource: BindingResource::TextureView(&self.blocks) },
        ];
        if self.variant.hardware {
            entries.push(BindGroupEntry { binding: 1, resource: BindingResource::Sampler(&sampler) });
        }
        if let Some(kernels) = &self.kernels {
            entries.push(BindGroupEntry { binding: 3, resource: kernels.as_entire_binding() });
        }
        if self.variant.has_voxels() {
            entries.push(BindGroupEntry { binding: 4, resource: BindingResource::TextureView(voxels) });
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
    let usage = BufferUsages::STORAGE;
    device.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
}

/// The blocks as a texture; a single one where none is asked.
fn block_texture(device: &Device, blocks: Option<&BlockMap>, extremes: bool) -> TextureView {
    let none = if extremes { TextureFormat::R32Float } else { TextureFormat::R8Uint };
    let (format, dims, bytes) = match blocks {
        None => (none, [1; 3], vec![0; 4]),
        Some(BlockMap { dims, content, levels, .. }) => match (content, levels) {
            (BlockContent::Distances(distances), None) => (TextureFormat::R8Uint, *dims, distances.clone()),
            (BlockContent::Distances(distances), Some(levels)) => {
                let pairs = distances.iter().zip(levels).flat_map(|(&distance, &level)| [distance, level]);
                (TextureFormat::Rg8Uint, *dims, pairs.collect())
            }
            (BlockContent::Extremes(extremes), _) => {
                // Shaders need not know infinity, which blocks without any value have.
                let bytes = extremes.iter().flat_map(|v| v.max(f32::MIN).to_ne_bytes());
                (TextureFormat::R32Float, *dims, bytes.collect())
            }
        },
    };
    let texture = texture::of_bytes(device, "blocks", format, dims, &bytes);
    texture.create_view(&Default::default())
}

/// What a band is drawn into.
struct Targets {
    width: u32,
    rows: u32,
    states: Buffer,
    pixels: Buffer,
    copied: Buffer,
}

impl Targets {
    fn new(device: &Device, width: u32, rows: u32) -> Self {
        let count = u64::from(width) * u64::from(rows);
        let buffer = |label, bytes: u64, usage| {
            let descriptor =
                BufferDescriptor { label: Some(label), size: count * bytes, usage, mapped_at_creation: false };
            device.device.create_buffer(&descriptor)
        };
        let pixel = size_of::<Pixel>() as u64;
        Self {
            width,
            rows,
            states: buffer("states", uniforms::STATE_BYTES, BufferUsages::STORAGE),
            pixels: buffer("pixels", pixel, BufferUsages::STORAGE | BufferUsages::COPY_SRC),
            copied: buffer("copied", pixel, BufferUsages::MAP_READ | BufferUsages::COPY_DST),
        }
    }

    fn bytes(&self, rows: u32) -> u64 {
        u64::from(self.width) * u64::from(rows) * size_of::<Pixel>() as u64
    }

    fn copy(&self, encoder: &mut CommandEncoder, rows: u32) {
        encoder.copy_buffer_to_buffer(&self.pixels, 0, &self.copied, 0, self.bytes(rows));
    }

    /// Waits for a band and puts it into the picture.
    fn read(&self, device: &Device, row: u32, rows: u32, picture: &mut Picture) -> Result<(), GpuError> {
        let slice = self.copied.slice(..self.bytes(rows));
        // A failure is reported by the device, too.
        slice.map_async(MapMode::Read, |_| ());
        device.wait()?;
        let mapped = slice.get_mapped_range().map_err(|error| GpuError::Lost { reason: error.to_string() })?;
        let pixels: &[Pixel] = cast_slice(&mapped);
        let start = row as usize * picture.width;
        let statistics = &mut picture.statistics;
        for (place, pixel) in (start..).zip(pixels) {
            picture.color[place] = pixel.color;
            let [x, y, z, depth] = pixel.surface;
            if depth < NOWHERE {
                picture.depth[place] = depth;
                picture.normal[place] = [x, y, z];
            }
            let [samples, visible, skipped, rays] = pixel.counts;
            picture.samples[place] = samples;
            statistics.samples += u64::from(samples);
            statistics.samples_visible += u64::from(visible);
            statistics.samples_skipped += u64::from(skipped);
            statistics.rays_hit += u64::from(rays & 0xffff);
            statistics.rays_terminated += u64::from(rays >> 16);
        }
        drop(mapped);
        self.copied.unmap();
        Ok(())
    }
}

/// Depth of a pixel that met nothing; `march.wgsl` has the same.
const NOWHERE: f32 = 1e30;
