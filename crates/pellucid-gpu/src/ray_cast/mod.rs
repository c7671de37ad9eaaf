//! The ray caster: passes over bands of the picture (7.2).

mod bands;
mod lists;
mod wavefront;

use std::time::Instant;

use pellucid_scene::{Control, Frame as Picture, Stage};
use wgpu::{BindGroup, CommandEncoder, CommandEncoderDescriptor};

use crate::bindings::Bindings;
use crate::bounds::{BoundsBuffer, RayBounds, Rows};
use crate::bricks::{self, Brick};
use crate::dispatch::dispatch;
use crate::drawing::{Drawing, Passes};
use crate::light_volume::LightVolumes;
use crate::on_device::Drawn;
use crate::pace::Pace;
use crate::pipelines::{Pipeline, Pipelines};
use crate::resident::Resident;
use crate::shaders::{Pass, Variant};
use crate::targets::Targets;
use crate::timer::Timer;
use crate::uniforms;
use crate::window::Window;
use crate::{Device, GpuError};

use bands::Bands;
use lists::Lists;
use wavefront::Front;

/// Most passes of a submission.
const MOST_PASSES: usize = 256;

/// Rows of the picture.
#[derive(Clone, Copy)]
struct Band {
    row: u32,
    rows: u32,
}

/// What was learnt of the device's speed, kept from frame to frame.
#[derive(Default)]
pub struct KeptRays {
    bands: Bands,
    /// Looks at the blocks in a pass of a wavefront.
    looks: Pace,
}

/// A volume on the device, and what shaders are given of it.
struct OnRays<'a> {
    resident: &'a mut Resident,
    bindings: Bindings<'a>,
}

/// Everything on the device that one frame is drawn with.
pub struct RayCaster<'a> {
    device: &'a Device,
    stage: &'a Stage,
    /// One volume, whole or in bricks, or several whole ones in the order in which they are merged.
    volumes: Vec<OnRays<'a>>,
    /// Their lists, if they are several.
    lists: Option<Lists>,
    bricks: Vec<Brick>,
    march: Pipeline,
    resolve: Pipeline,
    table: BindGroup,
}

impl<'a> RayCaster<'a> {
    /// Makes pipelines and what changes with the camera.
    ///
    /// # Errors
    /// What the device reports; [`GpuError::Volumes`] if a pass cannot be given as many volumes.
    pub fn new(
        device: &'a Device,
        pipelines: &mut Pipelines,
        stage: &'a Stage,
        drawn: Vec<Drawn<'a, '_>>,
        (drawing, light): (Drawing, Option<&LightVolumes>),
    ) -> Result<Self, GpuError> {
        let mut volumes = Vec::with_capacity(drawn.len());
        let mut bricks = Vec::new();
        for Drawn { volume, resident, optics, uploads } in drawn {
            let [entries, planes, lights] =
                Lists::places(volumes.iter().map(|volume: &OnRays| volume.bindings.lists()));
            let alter = |frame: &mut uniforms::Frame| {
                frame.set_light_points(light.map_or(0, |light| light.depth));
                frame.lists = [entries, planes, lights, 0];
            };
            let mut bindings =
                Bindings::new(device, resident, (stage, volume), (optics, uploads), drawing.interpolation, alter)
                    .with_light(light.map(|light| light.points.clone()));
            bindings.variant = Variant {
                skip: optics.blocks.is_some(),
                // The many rounds of wide kernels are for several passes.
                wavefront: drawing.passes == Passes::Wavefront || bindings.variant.kernels,
                strides: optics.blocks.is_some_and(|blocks| blocks.levels.is_some()),
                ..bindings.variant
            };
            if volumes.is_empty() {
                bricks = resident.bricks.clone();
                bricks::sort(&mut bricks, stage, volume.volume.grid());
            }
            volumes.push(OnRays { resident, bindings });
        }
        // All volumes of a pass take turns alike.
        let wavefront = volumes.iter().any(|volume| volume.bindings.variant.wavefront);
        let variant = |volume: &OnRays| Variant { wavefront, ..volume.bindings.variant };
        let march = pipelines.of_layers(device, volumes.iter().map(variant).collect())?.clone();
        let (chromatic, layered) = (stage.holds_back_each_color(), stage.has_layers());
        let resolve = pipelines.get(device, Variant { chromatic, layered, ..Variant::of(Pass::Resolve) })?.clone();
        let each: Vec<_> = volumes.iter().map(|volume| volume.bindings.lists()).collect();
        let lists = stage.has_layers().then(|| Lists::joined(device, &each));
        let table = match &lists {
            Some(lists) => march.groups.tables().bind(device, &lists.named().collect::<Vec<_>>()),
            None => volumes[0].bindings.table_group(&march.groups),
        };
        Ok(Self { device, stage, volumes, lists, bricks, march, resolve, table })
    }

    /// The first of the volumes: what all have in common is told of it.
    fn first(&self) -> &OnRays<'a> {
        &self.volumes[0]
    }

    /// The textures of a brick or, of several volumes, of all of them: bound.
    fn volume_group(&mut self, brick: &Brick, control: &Control) -> Result<BindGroup, GpuError> {
        let mut views = Vec::with_capacity(self.volumes.len());
        for (number, OnRays { resident, .. }) in self.volumes.iter_mut().enumerate() {
            let brick = if number == 0 { *brick } else { resident.bricks[0] };
            views.push(resident.textures(self.device, &brick, control)?);
        }
        let of = self.volumes.iter().zip(&views).map(|(volume, views)| volume.bindings.of_volume(views));
        Ok(self.march.groups.volume().bind_layers(self.device, &of.collect::<Vec<_>>()))
    }

    /// Draws all bands that the volume can be in into an empty picture of the stage's size.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn draw(
        &mut self,
        kept: &mut KeptRays,
        (slot, timer): (&mut Option<Targets>, Option<&Timer>),
        control: &Control,
        picture: &mut Picture,
    ) -> Result<(), GpuError> {
        let Window { low: [column, first], size: [width, height] } = self.first().bindings.window;
        let rays = u64::from(width) * u64::from(self.stage.quality.supersampling.pow(2));
        let wavefront = self.march.variant.wavefront;
        let mut busy = timer.map(|_| 0.0);
        let (mut row, end) = (first, if width == 0 { first } else { first + height });
        while row < end {
            let rows = self.volumes.iter().map(|volume| volume.resident.plan.rows).min();
            let most = rows.unwrap_or(1).min(end - row);
            // The passes of bricks are many anyway: as many rows of each as there can be; a wavefront is as
            // wide as there is room.
            let learnt = self.first().resident.is_whole() && !wavefront;
            let wanted = if learnt { (kept.bands.rays() / rays) as u32 } else { most };
            let rows = wanted.max(8).next_multiple_of(8).min(most);
            let targets = {
                let shape = (picture.width, self.resolve.variant.chromatic);
                Targets::kept(slot, self.device, shape, [width, rows])
            };
            let band = Band { row, rows };
            let seconds = if wavefront {
                self.draw_wavefront(targets, timer, &mut kept.looks, band, control)?
            } else {
                self.draw_band(targets, timer, band, &mut kept.bands, control)?
            };
            busy = sum(busy, seconds);
            targets.read(self.device, [column, row], rows, picture)?;
            row += rows;
            control.report(f64::from(row - first) / f64::from(height));
        }
        kept.bands.end_frame();
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
        let size = [targets.width, band.rows, 1];
        let complete = self.first().resident.is_complete();
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
            let passes = BoundsBuffer::new(self.device, (first..turn).map(|turn| self.pass(turn, band)));
            let march = self.frame_group(&self.march, targets, &passes, None);
            let resolve = self.frame_group(&self.resolve, targets, &passes, None);
            let mut volumes = Vec::with_capacity(turn - first);
            for turn in first..turn {
                let brick = self.bricks[turn % bricks];
                volumes.push(self.volume_group(&brick, control)?);
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
            for (number, volume) in volumes.iter().enumerate() {
                let (offset, begins) = (passes.offset(number), writes(number == 0, number + 1 == volumes.len()));
                let groups = [Some(&march), Some(volume), Some(&self.table)];
                dispatch(&mut encoder, &self.march.pipeline, groups, offset, size, begins);
                if (first + number + 1) % bricks == 0 {
                    dispatch(&mut encoder, &self.resolve.pipeline, [Some(&resolve), None, None], offset, size, None);
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
                self.volumes[0].resident.used(submission);
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
    fn pass(&self, turn: usize, Band { row, rows }: Band) -> RayBounds {
        let (sub, number) = (turn / self.bricks.len(), turn % self.bricks.len());
        let brick = &self.bricks[number];
        let corner = |voxel: [usize; 3]| voxel.map(|v| v as u32);
        RayBounds {
            rows: Rows { begin: u32::from(number == 0), ..Rows::of([row, rows, sub as u32]) },
            most_looks: self.most_looks(),
            texture_low: corner(brick.voxels.low),
            core_low: corner(brick.core.low),
            core_high: corner(brick.core.high),
            ..RayBounds::default()
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
        let volume = self.volume_group(&self.bricks[0].clone(), control)?;
        let mut busy = Some(0.0);
        for sub in 0..rays {
            // Rays that go on, once there has been a pass.
            let mut left = None;
            let mut list = 0;
            while left != Some(0) {
                if control.is_cancelled() {
                    return Err(GpuError::Cancelled);
                }
                let pass = RayBounds {
                    rows: Rows { begin: u32::from(left.is_none()), ..Rows::of([row, rows, sub]) },
                    most_looks: pace.amount(self.most_looks()),
                    list,
                    list_length: capacity,
                    ..RayBounds::default()
                };
                let passes = BoundsBuffer::new(self.device, [pass]);
                let group = self.frame_group(&self.march, targets, &passes, Some(&front));
                let mut encoder = self.encoder();
                front.clear(&mut encoder, 1 - list);
                // Lists are read by workgroups in one row.
                let size = left.map_or([targets.width, rows, 1], |rays: u32| [rays.div_ceil(8), 1, 1]);
                let started = Instant::now();
                let writes = timer.and_then(|timer| timer.writes(0, true, true));
                let groups = [Some(&group), Some(&volume), Some(&self.table)];
                dispatch(&mut encoder, &self.march.pipeline, groups, 0, size, writes);
                if let Some(timer) = timer {
                    timer.copy(&mut encoder, 1);
                }
                left = Some(front.count(self.device, encoder, 1 - list)?);
                pace.learn(started.elapsed());
                busy = sum(busy, timer.and_then(|timer| timer.seconds(1)));
                list = 1 - list;
            }
            let pass = RayBounds { rows: Rows::of([row, rows, sub]), ..RayBounds::default() };
            let passes = BoundsBuffer::new(self.device, [pass]);
            let group = self.frame_group(&self.resolve, targets, &passes, None);
            let mut encoder = self.encoder();
            let size = [targets.width, rows, 1];
            dispatch(&mut encoder, &self.resolve.pipeline, [Some(&group), None, None], 0, size, None);
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
        passes: &BoundsBuffer,
        front: Option<&Front>,
    ) -> BindGroup {
        let mut own = vec![("states", targets.states.as_entire_binding())];
        match pipeline.variant.pass {
            Pass::Resolve => own.push(("pixels", targets.pixels.as_entire_binding())),
            _ => own.extend(front.map(|front| ("front", front.lists().as_entire_binding()))),
        }
        let mut layers: Vec<_> = self.volumes.iter().map(|volume| volume.bindings.of_frame(passes)).collect();
        // What is found first is bound.
        layers[0].splice(0..0, self.lists.iter().flat_map(Lists::named).chain(own));
        pipeline.groups.frame().bind_layers(self.device, &layers)
    }

    /// Most looks at the blocks in a pass.
    fn most_looks(&self) -> u32 {
        self.volumes.iter().map(|volume| volume.bindings.most_looks).min().unwrap_or(u32::MAX)
    }
}

/// Both together, where both are known.
fn sum(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.zip(b).map(|(a, b)| a + b)
}
