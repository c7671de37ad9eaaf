//! The ray caster: passes over bands of the picture (7.2).

mod bands;
mod followed;
mod wavefront;

use std::time::Instant;

use pellucid_scene::{Control, Frame as Picture, Stage};
use wgpu::{BindGroup, CommandEncoder, CommandEncoderDescriptor, ComputePipeline};

use crate::bounds::{BoundsBuffer, RayBounds, Rows};
use crate::bricks::Brick;
use crate::dispatch::dispatch;
use crate::drawing::Drawing;
use crate::groups::Named;
use crate::light_volume::LightVolumes;
use crate::on_device::Drawn;
use crate::pace::Pace;
use crate::pass_volumes::{self, PassVolumes};
use crate::pipelines::{Pipeline, Pipelines};
use crate::shaders::{Pass, Variant};
use crate::targets::Targets;
use crate::timer::Timer;
use crate::window::Window;
use crate::{Device, GpuError};

use bands::Bands;
use followed::{Followed, bindings};
use wavefront::Front;

/// Most passes of a submission.
const MOST_PASSES: usize = 256;

/// Rows of the picture.
#[derive(Clone, Copy)]
struct Band {
    row: u32,
    rows: u32,
}

/// A brick, and which of the parts it is of; whether rays begin there.
#[derive(Clone, Copy)]
struct Turn {
    part: usize,
    brick: Brick,
    begins: bool,
}

/// What was learnt of the device's speed, kept from frame to frame.
#[derive(Default)]
pub struct KeptRays {
    bands: Bands,
    /// Looks at the blocks in a pass of a wavefront.
    looks: Pace,
}

/// Everything on the device that one frame is drawn with.
pub struct RayCaster<'a> {
    device: &'a Device,
    stage: &'a Stage,
    /// What rays are followed through, one after the other; more than one if what they find is merged at the end.
    parts: Vec<Followed<'a>>,
    /// What merges it.
    merge: Option<Pipeline>,
    resolve: Pipeline,
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
        with: (Drawing, Option<&LightVolumes>),
    ) -> Result<Self, GpuError> {
        let bound = |some| PassVolumes::new(device, some, |drawn, lists| bindings(device, stage, drawn, with, lists));
        let volumes: Vec<PassVolumes> = pass_volumes::parts(drawn).into_iter().map(bound).collect();
        // All volumes take turns alike.
        let wavefront = volumes.iter().flat_map(PassVolumes::variants).any(|variant| variant.wavefront);
        let parts = volumes.into_iter().map(|some| Followed::new(device, pipelines, stage, some, wavefront));
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        let (chromatic, layered) = (stage.holds_back_each_color(), stage.has_layers());
        let resolve = pipelines.get(device, Variant { chromatic, layered, ..Variant::of(Pass::Resolve) })?.clone();
        let merge = match parts.len() {
            1 => None,
            several => Some(pipelines.of_layers(device, vec![Variant::of(Pass::Apart); several])?.clone()),
        };
        Ok(Self { device, stage, parts, merge, resolve })
    }

    /// The first of what is followed: what all have in common is told of it.
    fn first(&self) -> &Followed<'a> {
        &self.parts[0]
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
        let Window { low: [column, first], size: [width, height] } = self.first().volumes.first().bindings.window;
        let rays = u64::from(width) * u64::from(self.stage.quality.supersampling.pow(2));
        let wavefront = self.first().march.variant.wavefront;
        let mut busy = timer.map(|_| 0.0);
        let (mut row, end) = (first, if width == 0 { first } else { first + height });
        while row < end {
            let rows = self.parts.iter().map(|part| part.volumes.most_rows()).min();
            let most = rows.unwrap_or(1).min(end - row);
            // The passes of bricks are many anyway: as many rows of each as there can be; a wavefront is as
            // wide as there is room.
            let learnt = self.first().bricks.len() == 1 && !wavefront;
            let wanted = if learnt { (kept.bands.rays() / rays) as u32 } else { most };
            let rows = wanted.max(8).next_multiple_of(8).min(most);
            let targets = {
                let shape = (picture.width, self.resolve.variant.chromatic);
                Targets::kept_apart(slot, self.device, self.parts.len(), shape, [width, rows])
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
        let (pixels, each) = (u64::from(targets.width) * u64::from(band.rows), self.each_turn());
        let turns = each.len() * self.stage.quality.supersampling.pow(2) as usize;
        let size = [targets.width, band.rows, 1];
        let complete = self.parts.iter().all(|part| part.volumes.are_complete());
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
            let of = |turn: usize| each[turn % each.len()];
            let pass = |turn| self.pass(of(turn), (turn / each.len()) as u32, band);
            let passes = BoundsBuffer::new(self.device, (first..turn).map(pass));
            let mut volumes = Vec::with_capacity(turn - first);
            for Turn { part, brick, .. } in (first..turn).map(of) {
                volumes.push(self.parts[part].volume_group(&brick, control)?);
            }
            let march = self.march_groups(targets, &passes, None);
            let finish = self.finish_groups(targets, &passes);
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
                let part = of(first + number).part;
                let Followed { march: Pipeline { pipeline, .. }, table, .. } = &self.parts[part];
                let groups = [Some(&march[part]), Some(volume), Some(table)];
                dispatch(&mut encoder, pipeline, groups, offset, size, begins);
                if (first + number + 1) % each.len() == 0 {
                    finish.iter().for_each(|(pipeline, group)| {
                        dispatch(&mut encoder, pipeline, [Some(group), None, None], offset, size, None);
                    });
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
                let volumes = self.parts.iter_mut().flat_map(|part| part.volumes.residents());
                volumes.for_each(|volume| volume.used(submission.clone()));
                self.device.check()?;
            }
            if reads {
                self.device.wait()?;
                busy = sum(busy, timer.and_then(|timer| timer.seconds(pair + 1)));
            }
        }
        Ok(busy)
    }

    /// What each of a pixel's rays is followed through, one after the other.
    fn each_turn(&self) -> Vec<Turn> {
        let of = |(part, followed): (usize, &Followed)| -> Vec<Turn> {
            let turn = |(number, brick): (usize, &Brick)| Turn { part, brick: *brick, begins: number == 0 };
            followed.bricks.iter().enumerate().map(turn).collect()
        };
        self.parts.iter().enumerate().flat_map(of).collect()
    }

    /// What a turn of one of the rays of the pixels draws.
    fn pass(&self, Turn { part, brick, begins }: Turn, sub: u32, Band { row, rows }: Band) -> RayBounds {
        let corner = |voxel: [usize; 3]| voxel.map(|v| v as u32);
        RayBounds {
            rows: Rows { begin: u32::from(begins), ..Rows::of([row, rows, sub]) },
            most_looks: self.parts[part].volumes.most_looks(),
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
        let mut volumes = Vec::with_capacity(self.parts.len());
        for part in &mut self.parts {
            let brick = part.bricks[0];
            volumes.push(part.volume_group(&brick, control)?);
        }
        let mut busy = Some(0.0);
        for (sub, part) in (0..rays).flat_map(|sub| (0..volumes.len()).map(move |part| (sub, part))) {
            let Followed { march: Pipeline { pipeline, .. }, table, .. } = &self.parts[part];
            // Rays that go on, once there has been a pass.
            let mut left = None;
            let mut list = 0;
            while left != Some(0) {
                if control.is_cancelled() {
                    return Err(GpuError::Cancelled);
                }
                let pass = RayBounds {
                    rows: Rows { begin: u32::from(left.is_none()), ..Rows::of([row, rows, sub]) },
                    most_looks: pace.amount(self.parts[part].volumes.most_looks()),
                    list,
                    list_length: capacity,
                    ..RayBounds::default()
                };
                let passes = BoundsBuffer::new(self.device, [pass]);
                let march = self.march_groups(targets, &passes, Some(&front));
                let mut encoder = self.encoder();
                front.clear(&mut encoder, 1 - list);
                // Lists are read by workgroups in one row.
                let size = left.map_or([targets.width, rows, 1], |rays: u32| [rays.div_ceil(8), 1, 1]);
                let started = Instant::now();
                let writes = timer.and_then(|timer| timer.writes(0, true, true));
                let groups = [Some(&march[part]), Some(&volumes[part]), Some(table)];
                dispatch(&mut encoder, pipeline, groups, 0, size, writes);
                if let Some(timer) = timer {
                    timer.copy(&mut encoder, 1);
                }
                left = Some(front.count(self.device, encoder, 1 - list)?);
                pace.learn(started.elapsed());
                busy = sum(busy, timer.and_then(|timer| timer.seconds(1)));
                list = 1 - list;
            }
            if part + 1 < volumes.len() {
                continue;
            }
            let pass = RayBounds { rows: Rows::of([row, rows, sub]), ..RayBounds::default() };
            let passes = BoundsBuffer::new(self.device, [pass]);
            let mut encoder = self.encoder();
            let size = [targets.width, rows, 1];
            for (pipeline, group) in self.finish_groups(targets, &passes) {
                dispatch(&mut encoder, pipeline, [Some(&group), None, None], 0, size, None);
            }
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

    /// What those that follow rays are told of the frame, their passes and their targets.
    fn march_groups(&self, targets: &Targets, passes: &BoundsBuffer, front: Option<&Front>) -> Vec<BindGroup> {
        let group = |(number, part): (usize, &Followed)| {
            let front = front.map(|front| ("front", front.lists().as_entire_binding()));
            let own: Vec<_> = std::iter::once(("states", targets.states_in(number))).chain(front).collect();
            part.frame_group(passes, &own)
        };
        self.parts.iter().enumerate().map(group).collect()
    }

    /// What happens to rays that have been followed to their ends, and what it is told.
    fn finish_groups(&self, targets: &Targets, passes: &BoundsBuffer) -> Vec<(&ComputePipeline, BindGroup)> {
        let merge = self.merge.as_ref().map(|merge| (merge, vec![("states", targets.states())]));
        let pixels = ("pixels", targets.pixels.as_entire_binding());
        let resolve = (&self.resolve, vec![("states", targets.states_in(0)), pixels]);
        let volumes = &self.first().volumes;
        let bound = |pipeline: &Pipeline, own: &[Named]| volumes.frame_group(&pipeline.groups, passes, own);
        let finish = merge.into_iter().chain([resolve]);
        finish.map(|(pipeline, own)| (&pipeline.pipeline, bound(pipeline, &own))).collect()
    }
}

/// Both together, where both are known.
fn sum(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.zip(b).map(|(a, b)| a + b)
}
