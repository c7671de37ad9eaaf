//! The ray caster: passes over bands of the picture (7.2).

use std::time::{Duration, Instant};

use bytemuck::{bytes_of, cast_slice};
use pellucid_field::{Filter, Gradient};
use pellucid_scene::{Control, Frame as Picture, Stage, StageVolume};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferUsages, CommandEncoder,
    CommandEncoderDescriptor, ComputePassDescriptor, ComputePassTimestampWrites, ComputePipeline, FilterMode, Sampler,
    SamplerDescriptor, TextureView,
};

use crate::bricks::{self, Brick};
use crate::kernels::Kernels;
use crate::optics::{Optics, lights};
use crate::passes::PassBuffer;
use crate::pipelines::{Pipeline, Pipelines};
use crate::renderer::{Drawing, Interpolation, Passes};
use crate::resident::Resident;
use crate::shaders::{Pass, Variant};
use crate::targets::Targets;
use crate::timer::Timer;
use crate::uniforms::{self, Frame, Light};
use crate::uploads::{Uploads, storage};
use crate::wavefront::{Front, Pace};
use crate::window::Window;
use crate::{Device, GpuError};

/// How long the commands of a submission may take: short enough to be cancelled in time, and far from
/// what drivers take for a hang.
const SUBMISSION: Duration = Duration::from_millis(25);

/// Most passes of a submission.
const MOST_PASSES: usize = 256;

/// How much is drawn at once, learnt from frame to frame.
struct Bands {
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

/// What is used again from frame to frame.
pub struct Reused {
    bands: Bands,
    targets: Option<Targets>,
    timer: Option<Timer>,
    pace: Pace,
}

impl Reused {
    /// Nothing yet, on a device.
    pub fn new(device: &Device) -> Self {
        Self { bands: Bands::default(), targets: None, timer: Timer::new(device), pace: Pace::default() }
    }
}

/// Rows of the picture.
#[derive(Clone, Copy)]
struct Band {
    row: u32,
    rows: u32,
}

/// Everything on the device that one frame is drawn with.
pub struct RayCaster<'a> {
    device: &'a Device,
    resident: &'a mut Resident,
    stage: &'a Stage,
    uploads: &'a Uploads,
    window: Window,
    bricks: Vec<Brick>,
    march: Pipeline,
    resolve: Pipeline,
    table: BindGroup,
    kernels: Option<Buffer>,
    /// Most looks at the blocks in a pass.
    most_looks: u32,
    /// If the texture unit interpolates.
    sampler: Option<Sampler>,
    /// Frame, planes, lights.
    parts: [Buffer; 3],
}

impl<'a> RayCaster<'a> {
    /// Makes pipelines and what changes with the camera.
    ///
    /// # Errors
    /// What the device reports.
    pub fn new(
        device: &'a Device,
        pipelines: &mut Pipelines,
        resident: &'a mut Resident,
        (stage, volume): (&'a Stage, &StageVolume),
        (optics, uploads): (&Optics, &'a Uploads),
        Drawing { interpolation, passes }: Drawing,
    ) -> Result<Self, GpuError> {
        let grid = volume.volume.grid();
        let region = stage.region(volume);
        let (filter, gradient) = (optics.tables.filter, stage.quality.gradient);
        let encoding = resident.field().encoding;
        let kernels = filter != Filter::Linear || (gradient != Gradient::Central && lights(stage.mode()));
        let kernels = kernels.then(|| Kernels::new(filter, gradient, resident.voxels().data()));
        let variant = Variant {
            pass: optics.pass,
            hardware: interpolation == Interpolation::Hardware && encoding.filterable && filter == Filter::Linear,
            holes: encoding.holes,
            bricks: !resident.is_whole(),
            skip: optics.blocks.is_some(),
            shaded: volume.material.is_some() && lights(stage.mode()),
            weighted: volume.gradient_weight.is_some(),
            opaque: optics.opaque,
            // The many rounds of wide kernels are for several passes.
            wavefront: passes == Passes::Wavefront || kernels.is_some(),
            kernels: kernels.is_some(),
            strides: optics.blocks.is_some_and(|blocks| blocks.levels.is_some()),
        }
        .canonical();
        let mut frame = Frame::new(stage, volume, &region);
        let window = Window::of(&stage.viewpoint, &grid.world_corners());
        frame.set_window(&window);
        frame.set_values(resident.field().data());
        frame.set_nodes(&optics.nodes);
        if let Some(blocks) = optics.blocks {
            frame.set_blocks(blocks.dims, blocks.size);
        }
        let lights: Vec<Light> = stage.lights.iter().map(Light::from).collect();
        let parts = [
            device.buffer("frame", bytes_of(&frame), BufferUsages::UNIFORM),
            storage(device, "planes", &uniforms::planes(&region, grid)),
            storage(device, "lights", &lights),
        ];
        let most_looks = kernels.as_ref().filter(|_| variant.kernels).map_or(u32::MAX, Kernels::most_looks);
        let kernels = kernels
            .filter(|_| variant.kernels)
            .map(|kernels| device.buffer("kernels", cast_slice(&kernels.to_fours()), BufferUsages::UNIFORM));
        let resolve = pipelines.get(device, Variant::of(Pass::Resolve))?.clone();
        let march = pipelines.get(device, variant)?.clone();
        let table = device.device.create_bind_group(&BindGroupDescriptor {
            label: Some("tables"),
            layout: &march.groups[2],
            entries: &[BindGroupEntry { binding: 0, resource: uploads.entries.as_entire_binding() }],
        });
        let mut bricks = resident.bricks.clone();
        bricks::sort(&mut bricks, stage, grid);
        Ok(Self {
            device,
            resident,
            stage,
            uploads,
            window,
            bricks,
            march,
            resolve,
            table,
            kernels,
            most_looks,
            sampler: variant.hardware.then(|| sampler(device)),
            parts,
        })
    }

    /// Draws all bands that the volume can be in into an empty picture of the stage's size.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn draw(&mut self, reused: &mut Reused, control: &Control, picture: &mut Picture) -> Result<(), GpuError> {
        let Window { low: [column, first], size: [width, height] } = self.window;
        let rays = u64::from(width) * u64::from(self.stage.quality.supersampling.pow(2));
        let wavefront = self.march.variant.wavefront;
        let timer = reused.timer.as_ref();
        let mut busy = timer.map(|_| 0.0);
        let (mut row, end) = (first, if width == 0 { first } else { first + height });
        while row < end {
            let most = self.resident.plan.rows.min(end - row);
            // The passes of bricks are many anyway: as many rows of each as there can be; a wavefront is as
            // wide as there is room.
            let learnt = self.resident.is_whole() && !wavefront;
            let wanted = if learnt { (reused.bands.rays() / rays) as u32 } else { most };
            let rows = wanted.max(8).next_multiple_of(8).min(most);
            // The old ones go first.
            let room = picture.width as u64 * u64::from(rows);
            reused.targets.take_if(|targets| !targets.fits(room));
            let targets = reused.targets.get_or_insert_with(|| Targets::new(self.device, room));
            targets.width = width;
            let band = Band { row, rows };
            let seconds = if wavefront {
                self.draw_wavefront(targets, timer, &mut reused.pace, band, control)?
            } else {
                self.draw_band(targets, timer, band, &mut reused.bands, control)?
            };
            busy = sum(busy, seconds);
            targets.read(self.device, [column, row], rows, picture)?;
            row += rows;
            control.report(f64::from(row - first) / f64::from(height));
        }
        reused.bands.end_frame();
        picture.statistics.device_seconds = busy;
        Ok(())
    }

    /// Draws rows: for every ray of a pixel one brick after the other, in submissions of bounded length.
    /// Returns the seconds that the device worked, if it tells.
    fn draw_band(
        &mut self,
        targets: &Targets,
        timer: Option<&Timer>,
        band: Band,
        bands: &mut Bands,
        control: &Control,
    ) -> Result<Option<f64>, GpuError> {
        let (pixels, bricks) = (u64::from(targets.width) * u64::from(band.rows), self.bricks.len());
        let turns = bricks * self.stage.quality.supersampling.pow(2) as usize;
        let size = [targets.width, band.rows];
        let complete = self.resident.is_complete();
        let mut busy = Some(0.0);
        let mut turn = 0;
        while turn < turns {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            let together = if complete { (bands.rays() / pixels) as usize } else { 1 };
            let together = together.clamp(1, MOST_PASSES);
            let first = turn;
            turn = turns.min(turn + together);
            let passes = PassBuffer::new(self.device, (first..turn).map(|turn| self.pass(turn, band)));
            let march = self.frame_group(&self.march, targets, &passes, None);
            let resolve = self.frame_group(&self.resolve, targets, &passes, None);
            let mut views = Vec::with_capacity(turn - first);
            for turn in first..turn {
                let brick = self.bricks[turn % bricks];
                views.push(self.resident.textures(self.device, &brick, control)?);
            }
            if complete {
                // Uploads are not what is measured.
                self.device.wait()?;
            }
            // Passes that wait for bricks are not waited for: their times are read many at once.
            let pair = if complete { 0 } else { first % Timer::PAIRS };
            let reads = complete || pair + 1 == Timer::PAIRS || turn == turns;
            let writes = |first, last| timer.and_then(|timer| timer.writes(pair, first, last));
            let started = Instant::now();
            let mut encoder = self.encoder();
            for (number, view) in views.iter().enumerate() {
                let volume = self.volume_group(view);
                let (offset, begins) = (passes.offset(number), writes(number == 0, number + 1 == views.len()));
                dispatch(&mut encoder, &self.march.pipeline, &[&march, &volume, &self.table], offset, size, begins);
                if (first + number + 1) % bricks == 0 {
                    dispatch(&mut encoder, &self.resolve.pipeline, &[&resolve], offset, size, None);
                }
            }
            if turn == turns {
                targets.copy(&mut encoder, band.rows);
            }
            if let Some(timer) = timer.filter(|_| reads) {
                timer.copy(&mut encoder, pair + 1);
            }
            let submission = self.device.queue.submit([encoder.finish()]);
            if complete {
                self.device.wait()?;
                bands.learn(pixels * (turn - first) as u64, started.elapsed());
            } else {
                // Meanwhile the next brick may come.
                self.resident.used(submission);
                self.device.check()?;
            }
            if reads {
                self.device.wait()?;
                busy = sum(busy, timer.and_then(|timer| timer.seconds(pair + 1)));
            }
        }
        Ok(busy)
    }

    /// What a turn draws: a brick for one of the rays of the pixels.
    fn pass(&self, turn: usize, Band { row, rows }: Band) -> uniforms::Pass {
        let (sub, number) = (turn / self.bricks.len(), turn % self.bricks.len());
        let brick = &self.bricks[number];
        let four = |[x, y, z]: [usize; 3], w| [x as u32, y as u32, z as u32, w];
        uniforms::Pass {
            rows: [row, rows, sub as u32, self.most_looks],
            texture_low: four(brick.voxels.low, u32::from(number == 0)),
            core_low: four(brick.core.low, 0),
            core_high: four(brick.core.high, 0),
        }
    }

    /// Follows all rays for a while, then those that are not done, until there is none: every submission
    /// is short, whatever the rays meet, and no invocation is spent on a ray that has ended (7.4-1).
    /// Returns the seconds that the device worked, if it tells.
    fn draw_wavefront(
        &mut self,
        targets: &Targets,
        timer: Option<&Timer>,
        pace: &mut Pace,
        band: Band,
        control: &Control,
    ) -> Result<Option<f64>, GpuError> {
        let Band { row, rows } = band;
        let rays = self.stage.quality.supersampling.pow(2);
        let capacity = targets.width * rows;
        let front = Front::new(self.device, capacity);
        let view = self.resident.textures(self.device, &self.bricks[0], control)?;
        let volume = self.volume_group(&view);
        let mut busy = Some(0.0);
        for sub in 0..rays {
            // Rays that go on, once there has been a pass.
            let mut left = None;
            let mut list = 0;
            while left != Some(0) {
                if control.is_cancelled() {
                    return Err(GpuError::Cancelled);
                }
                let pass = uniforms::Pass {
                    rows: [row, rows, sub, pace.looks(self.most_looks)],
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
                let writes = timer.and_then(|timer| timer.writes(0, true, true));
                dispatch(&mut encoder, &self.march.pipeline, &[&group, &volume, &self.table], 0, size, writes);
                if let Some(timer) = timer {
                    timer.copy(&mut encoder, 1);
                }
                left = Some(front.count(self.device, encoder, 1 - list)?);
                pace.learn(started.elapsed());
                busy = sum(busy, timer.and_then(|timer| timer.seconds(1)));
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
        Ok(busy)
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
        let Uploads { noise, levels, .. } = self.uploads;
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

    fn volume_group(&self, [field, voxels]: &[TextureView; 2]) -> BindGroup {
        let mut entries = vec![
            BindGroupEntry { binding: 0, resource: BindingResource::TextureView(field) },
            BindGroupEntry { binding: 2, resource: BindingResource::TextureView(&self.uploads.blocks) },
        ];
        if let Some(sampler) = &self.sampler {
            entries.push(BindGroupEntry { binding: 1, resource: BindingResource::Sampler(sampler) });
        }
        if let Some(kernels) = &self.kernels {
            entries.push(BindGroupEntry { binding: 3, resource: kernels.as_entire_binding() });
        }
        if self.march.variant.has_voxels() {
            entries.push(BindGroupEntry { binding: 4, resource: BindingResource::TextureView(voxels) });
        }
        self.device.device.create_bind_group(&BindGroupDescriptor {
            label: Some("volume"),
            layout: &self.march.groups[1],
            entries: &entries,
        })
    }
}

/// Both together, where both are known.
fn sum(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.zip(b).map(|(a, b)| a + b)
}

fn sampler(device: &Device) -> Sampler {
    device.device.create_sampler(&SamplerDescriptor {
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        ..Default::default()
    })
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
