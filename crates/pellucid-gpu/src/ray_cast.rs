//! The ray caster: passes over bands of the picture (7.2).

use std::time::{Duration, Instant};

use bytemuck::bytes_of;
use pellucid_scene::{Control, Frame as Picture, Stage, StageVolume};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferUsages, CommandEncoder,
    CommandEncoderDescriptor, ComputePassDescriptor, ComputePassTimestampWrites, ComputePipeline, FilterMode,
    SamplerDescriptor, TextureView,
};

use crate::bricks::{self, Brick};
use crate::optics::lights;
use crate::passes::PassBuffer;
use crate::pipelines::{Pipeline, Pipelines};
use crate::renderer::{Drawing, Interpolation, Passes};
use crate::resident::Resident;
use crate::shaders::{Pass, Variant};
use crate::tables::{Tables, storage};
use crate::targets::Targets;
use crate::timer::Timer;
use crate::uniforms::{self, Frame, Light};
use crate::wavefront::{Front, Pace};
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
    pace: Pace,
}

/// A part of the picture.
pub struct Band {
    /// First row.
    pub row: u32,
    /// Rows.
    pub rows: u32,
    /// Rays per pixel.
    pub rays: u32,
}

impl Reused {
    /// Nothing yet, on a device.
    pub fn new(device: &Device) -> Self {
        Self { bands: Bands::default(), targets: None, timer: Timer::new(device), pace: Pace::default() }
    }
}

/// Everything on the device that one frame is drawn with.
pub struct RayCaster<'a> {
    device: &'a Device,
    resident: &'a mut Resident,
    stage: &'a Stage,
    bricks: Vec<Brick>,
    march: Pipeline,
    resolve: Pipeline,
    table: BindGroup,
    tables: &'a Tables,
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
        Drawing { interpolation, passes }: Drawing,
    ) -> Result<Self, GpuError> {
        let optics = &tables.optics;
        let wavefront = passes == Passes::Wavefront;
        let grid = volume.volume.grid();
        let region = stage.region(volume);
        let variant = Variant {
            pass: optics.pass,
            hardware: interpolation == Interpolation::Hardware && resident.encoding.filterable,
            holes: resident.encoding.holes,
            bricks: !resident.is_whole(),
            skip: optics.blocks.is_some(),
            shaded: volume.material.is_some() && lights(stage.mode()),
            weighted: volume.gradient_weight.is_some(),
            opaque: optics.opaque,
            wavefront,
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
        let resolve = pipelines.get(device, Variant::of(Pass::Resolve))?.clone();
        let march = pipelines.get(device, variant)?.clone();
        let table = device.device.create_bind_group(&BindGroupDescriptor {
            label: Some("tables"),
            layout: &march.groups[2],
            entries: &[BindGroupEntry { binding: 0, resource: tables.entries.as_entire_binding() }],
        });
        let mut bricks = resident.bricks.clone();
        bricks::sort(&mut bricks, stage, grid);
        Ok(Self { device, resident, stage, bricks, march, resolve, table, tables, parts })
    }

    /// Draws all bands into a picture of the stage's size.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn draw(
        &mut self,
        Reused { bands, targets, timer, pace }: &mut Reused,
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
            let band = Band { row, rows, rays };
            if self.march.variant.wavefront {
                self.draw_wavefront(&room, pace, &band, control)?;
            } else {
                self.draw_band(&room, timer.as_ref(), &band)?;
            }
            room.read(self.device, row, rows, picture)?;
            if let (Some(busy), Some(timer), false) = (&mut busy, timer.as_ref(), self.march.variant.wavefront) {
                *busy += timer.seconds().unwrap_or(0.0);
            }
            *targets = Some(room);
            bands.learn(rows, work, started.elapsed());
            row += rows;
            control.report(f64::from(row) / f64::from(height));
        }
        picture.statistics.device_seconds = busy.filter(|_| !self.march.variant.wavefront);
        Ok(())
    }

    fn draw_band(&mut self, targets: &Targets, timer: Option<&Timer>, band: &Band) -> Result<(), GpuError> {
        let Band { row, rows, rays } = *band;
        let every =
            (0..rays).flat_map(|sub| self.bricks.iter().enumerate().map(move |(number, brick)| (sub, number, brick)));
        let pass = |(sub, number, brick): (u32, usize, &Brick)| {
            let four = |[x, y, z]: [usize; 3], w| [x as u32, y as u32, z as u32, w];
            uniforms::Pass {
                rows: [row, rows, sub, u32::MAX],
                texture_low: four(brick.voxels.low, u32::from(number == 0)),
                core_low: four(brick.core.low, 0),
                core_high: four(brick.core.high, 0),
            }
        };
        let passes = PassBuffer::new(self.device, every.map(pass));
        let march = self.frame_group(&self.march, targets, &passes, None);
        let resolve = self.frame_group(&self.resolve, targets, &passes, None);
        let mut encoder = self.encoder();
        let last = (rays - 1, self.bricks.len() - 1);
        for sub in 0..rays {
            for number in 0..self.bricks.len() {
                let brick = self.bricks[number];
                let view = self.resident.texture(self.device, &brick)?;
                let volume = self.volume_group(&view);
                let offset = passes.offset(sub as usize * self.bricks.len() + number);
                let size = [targets.width, rows];
                let writes = |first, last| timer.and_then(|timer| timer.writes(first, last));
                let groups = &[&march, &volume, &self.table][..];
                let begins = writes((sub, number) == (0, 0), false);
                dispatch(&mut encoder, &self.march.pipeline, groups, offset, size, begins);
                if !self.resident.is_complete() {
                    // The next upload needs the memory of this brick.
                    self.device.queue.submit([std::mem::replace(&mut encoder, self.encoder()).finish()]);
                    self.device.wait()?;
                }
                if number == last.1 {
                    let ends = writes(false, (sub, number) == last);
                    dispatch(&mut encoder, &self.resolve.pipeline, &[&resolve], offset, size, ends);
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

    /// Follows all rays for a while, then those that are not done, until there is none: every submission
    /// is short, whatever the rays meet, and no invocation is spent on a ray that has ended (7.4-1).
    fn draw_wavefront(
        &mut self,
        targets: &Targets,
        pace: &mut Pace,
        band: &Band,
        control: &Control,
    ) -> Result<(), GpuError> {
        let Band { row, rows, rays } = *band;
        let capacity = targets.width * rows;
        let front = Front::new(self.device, capacity);
        let view = self.resident.texture(self.device, &self.bricks[0])?;
        let volume = self.volume_group(&view);
        for sub in 0..rays {
            // Rays that go on, once there has been a pass.
            let mut left = None;
            let mut list = 0;
            while left != Some(0) {
                if control.is_cancelled() {
                    return Err(GpuError::Cancelled);
                }
                let pass = uniforms::Pass {
                    rows: [row, rows, sub, pace.looks()],
                    texture_low: [0, 0, 0, u32::from(left.is_none())],
                    core_low: [0, 0, 0, list],
                    core_high: [0, 0, 0, capacity],
                };
                let passes = PassBuffer::new(self.device, [pass]);
                let group = self.frame_group(&self.march, targets, &passes, Some(&front));
                let mut encoder = self.encoder();
                front.clear(&mut encoder, 1 - list);
                // Lists are read by workgroups in one row.
                let size = left.map_or([targets.width, rows], |rays: u32| [rays.div_ceil(8), 1]);
                let started = Instant::now();
                dispatch(&mut encoder, &self.march.pipeline, &[&group, &volume, &self.table], 0, size, None);
                left = Some(front.count(self.device, encoder, 1 - list)?);
                pace.learn(started.elapsed());
                list = 1 - list;
            }
            let pass = uniforms::Pass { rows: [row, rows, sub, 0], ..uniforms::Pass::default() };
            let passes = PassBuffer::new(self.device, [pass]);
            let group = self.frame_group(&self.resolve, targets, &passes, None);
            let mut encoder = self.encoder();
            dispatch(&mut encoder, &self.resolve.pipeline, &[&group], 0, [targets.width, rows], None);
            if sub + 1 == rays {
                targets.copy(&mut encoder, rows);
            }
            self.device.queue.submit([encoder.finish()]);
        }
        Ok(())
    }

    fn encoder(&self) -> CommandEncoder {
        self.device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("rays") })
    }

    /// What a pipeline is told of the frame, its passes and its targets.
    fn frame_group(
        &self,
        pipeline: &Pipeline,
        targets: &Targets,
        passes: &PassBuffer,
        front: Option<&Front>,
    ) -> BindGroup {
        let [frame, planes, lights] = &self.parts;
        let Tables { noise, levels, .. } = self.tables;
        let mut buffers = vec![(0, frame), (2, planes), (3, noise), (4, lights), (5, &targets.states), (6, levels)];
        match pipeline.variant.pass {
            Pass::Resolve => buffers.push((7, &targets.pixels)),
            _ => buffers.extend(front.map(|front| (8, front.lists()))),
        }
        let mut entries = vec![BindGroupEntry { binding: 1, resource: passes.binding() }];
        for (binding, buffer) in buffers {
            entries.push(BindGroupEntry { binding, resource: buffer.as_entire_binding() });
        }
        self.device.device.create_bind_group(&BindGroupDescriptor {
            label: Some("frame"),
            layout: &pipeline.groups[0],
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
        if self.march.variant.hardware {
            entries.push(BindGroupEntry { binding: 1, resource: BindingResource::Sampler(&sampler) });
        }
        self.device.device.create_bind_group(&BindGroupDescriptor {
            label: Some("volume"),
            layout: &self.march.groups[1],
            entries: &entries,
        })
    }
}

fn dispatch(
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
