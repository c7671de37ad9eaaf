//! The ray caster: passes over bands of the picture (7.2).

use std::time::{Duration, Instant};

use bytemuck::bytes_of;
use pellucid_scene::{Control, Frame as Picture, Stage, StageVolume};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindingResource, Buffer, BufferBinding,
    BufferUsages, CommandEncoder, CommandEncoderDescriptor, ComputePassDescriptor, ComputePassTimestampWrites,
    ComputePipeline, FilterMode, SamplerDescriptor, TextureView,
};

use crate::bricks::{self, Brick};
use crate::optics::lights;
use crate::pipelines::Pipelines;
use crate::resident::Resident;
use crate::shaders::{Pass, Variant};
use crate::tables::{Tables, storage};
use crate::targets::Targets;
use crate::timer::Timer;
use crate::uniforms::{self, Frame, Light};
use crate::{Device, GpuError};

/// How long the commands of a submission may take: short enough to be cancelled in time, and far from
/// what drivers take for a hang.
const SUBMISSION: Duration = Duration::from_millis(40);

/// Most bytes of the states of a band's rays.
const BAND_BYTES: u64 = 64 << 20;

/// How many rows of a picture are drawn at once, learnt from frame to frame.
#[derive(Default)]
struct Bands {
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

/// What is used again from frame to frame.
pub struct Reused {
    bands: Bands,
    targets: Option<Targets>,
    timer: Option<Timer>,
}

impl Reused {
    /// Nothing yet, on a device.
    pub fn new(device: &Device) -> Self {
        Self { bands: Bands::default(), targets: None, timer: Timer::new(device) }
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
    tables: &'a Tables,
    hardware: bool,
    /// Frame, planes, lights.
    parts: [Buffer; 3],
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
        tables: &'a Tables,
        hardware: bool,
    ) -> Result<Self, GpuError> {
        let optics = &tables.optics;
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
        let uniform = BufferInitDescriptor {
            label: Some("frame"),
            contents: bytes_of(&frame),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        };
        let parts = [
            device.device.create_buffer_init(&uniform),
            storage(device, "planes", &uniforms::planes(&region, grid)),
            storage(device, "lights", &lights),
        ];
        let resolve = pipelines.get(device, Variant::of(Pass::Resolve))?.pipeline.clone();
        let march = pipelines.get(device, variant)?;
        let table = device.device.create_bind_group(&BindGroupDescriptor {
            label: Some("tables"),
            layout: &march.groups[2],
            entries: &[BindGroupEntry { binding: 0, resource: tables.entries.as_entire_binding() }],
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
            tables,
            hardware: variant.hardware,
            parts,
        })
    }

    /// Draws all bands into a picture of the stage's size.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn draw(
        &mut self,
        Reused { bands, targets, timer }: &mut Reused,
        control: &Control,
        picture: &mut Picture,
    ) -> Result<(), GpuError> {
        let (width, height) = (picture.width as u32, picture.height as u32);
        let rays = self.stage.quality.supersampling.pow(2);
        let most = (BAND_BYTES / (uniforms::STATE_BYTES * u64::from(width))).max(1) as u32;
        let work = u64::from(width) * u64::from(rays);
        let mut busy = timer.as_ref().map(|_| 0.0);
        let mut row = 0;
        while row < height {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            let rows = bands.rows(work, most.min(height)).min(most).min(height - row);
            let fits = |targets: &Targets| targets.width == width && targets.rows >= rows;
            let room = match targets.take() {
                Some(targets) if fits(&targets) => targets,
                _ => Targets::new(self.device, width, rows),
            };
            let started = Instant::now();
            self.draw_band(&room, timer.as_ref(), row, rows, rays)?;
            room.read(self.device, row, rows, picture)?;
            if let (Some(busy), Some(timer)) = (&mut busy, timer.as_ref()) {
                *busy += timer.seconds().unwrap_or(0.0);
            }
            *targets = Some(room);
            bands.learn(rows, work, started.elapsed());
            row += rows;
            control.report(f64::from(row) / f64::from(height));
        }
        picture.statistics.device_seconds = busy;
        Ok(())
    }

    fn draw_band(
        &mut self,
        targets: &Targets,
        timer: Option<&Timer>,
        row: u32,
        rows: u32,
        rays: u32,
    ) -> Result<(), GpuError> {
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
        let last = (rays - 1, self.bricks.len() - 1);
        for sub in 0..rays {
            for number in 0..self.bricks.len() {
                let brick = self.bricks[number];
                let view = self.resident.texture(self.device, &brick)?;
                let volume = self.volume_group(&view);
                let offset = ((u64::from(sub) * self.bricks.len() as u64 + number as u64) * stride) as u32;
                let groups = [&frame, &volume, &self.table];
                let size = [targets.width, rows];
                let writes = |first, last| timer.and_then(|timer| timer.writes(first, last));
                dispatch(&mut encoder, &self.march, &groups, offset, size, writes((sub, number) == (0, 0), false));
                if !self.resident.is_complete() {
                    // The next upload needs the memory of this brick.
                    self.device.queue.submit([std::mem::replace(&mut encoder, self.encoder()).finish()]);
                    self.device.wait()?;
                }
                if number == last.1 {
                    dispatch(&mut encoder, &self.resolve, &groups, offset, size, writes(false, (sub, number) == last));
                }
            }
        }
        targets.copy(&mut encoder, rows);
        if let Some(timer) = timer {
            timer.copy(&mut encoder);
        }
        self.device.queue.submit([encoder.finish()]);
        Ok(())
    }

    fn encoder(&self) -> CommandEncoder {
        self.device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("rays") })
    }

    fn frame_group(&self, targets: &Targets, passes: &Buffer) -> BindGroup {
        let [frame, planes, lights] = &self.parts;
        let Tables { noise, levels, .. } = self.tables;
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
        let sampler = self.device.device.create_sampler(&SamplerDescriptor {
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..Default::default()
        });
        let mut entries = vec![
            BindGroupEntry { binding: 0, resource: BindingResource::TextureView(volume) },
            BindGroupEntry { binding: 2, resource: BindingResource::TextureView(&self.tables.blocks) },
        ];
        if self.hardware {
            entries.push(BindGroupEntry { binding: 1, resource: BindingResource::Sampler(&sampler) });
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
    [width, rows]: [u32; 2],
    timestamp_writes: Option<ComputePassTimestampWrites>,
) {
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor { label: None, timestamp_writes });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, groups[0], &[offset]);
    pass.set_bind_group(1, groups[1], &[]);
    pass.set_bind_group(2, groups[2], &[]);
    pass.dispatch_workgroups(width.div_ceil(8), rows.div_ceil(8), 1);
}
