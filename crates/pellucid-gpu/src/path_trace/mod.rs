//! The path tracer: a path of light for every pixel at a time, until there are enough of them, as the CPU backend
//! follows them. Random numbers are others, and so is the noise.

mod numbers;
mod sky;

use std::sync::Arc;
use std::time::Instant;

use bytemuck::{bytes_of, cast_slice};
use glam::Vec3;
use pellucid_optics::{Material, Sky};
use pellucid_plan::MajorantGrid;
use pellucid_scene::{Control, Frame as Picture, PathTrace, Stage};
use wgpu::{BindingResource, Buffer, CommandEncoder, CommandEncoderDescriptor, TextureFormat, TextureView};

use crate::bindings::Bindings;
use crate::bounds::{BoundsBuffer, PathBounds, Rows};
use crate::dispatch::dispatch;
use crate::drawing::Drawing;
use crate::on_device::Drawn;
use crate::pace::Pace;
use crate::pass_volumes::PassVolumes;
use crate::pipelines::{Pipeline, Pipelines};
use crate::shaders::{Pass, Variant};
use crate::targets::Targets;
use crate::texture;
use crate::uniforms;
use crate::uploads::storage;
use crate::window::Window;
use crate::{Device, GpuError};

pub use numbers::Paths;
pub use sky::bytes;

use sky::UploadedSky;

/// Most paths of a pixel in a submission.
const MOST_PATHS: u32 = 256;

/// What is kept from frame to frame.
#[derive(Default)]
pub struct KeptPaths {
    /// Paths of a pixel in a submission.
    pace: Pace,
    /// A picture of the sky.
    sky: Option<UploadedSky>,
}

impl KeptPaths {
    /// Keeps a picture of the sky only if it is of this one.
    pub fn forget_others(&mut self, sky: Option<&Sky>) {
        self.sky.take_if(|uploaded| !uploaded.is_of(sky));
    }
}

/// Everything on the device that one frame is drawn with.
pub struct PathTracer<'a> {
    device: &'a Device,
    volumes: PassVolumes<'a>,
    settings: &'a PathTrace,
    /// What shaders are told of paths: of each volume, if they are several.
    numbers: Buffer,
    sky: TextureView,
    trace: Pipeline,
    pixels: Pipeline,
}

impl<'a> PathTracer<'a> {
    /// Makes pipelines and what changes with camera and light; of each volume, with bounds of its extinction.
    ///
    /// # Errors
    /// What the device reports; [`GpuError::Volumes`] if a pass cannot be given as many volumes.
    pub fn new(
        device: &'a Device,
        pipelines: &mut Pipelines,
        (stage, settings): (&Stage, &'a PathTrace),
        (drawn, majorants): (Vec<Drawn<'a, '_>>, &[Arc<MajorantGrid>]),
        (sky, kept): (Option<&Sky>, &mut KeptPaths),
        drawing: Drawing,
    ) -> Result<Self, GpuError> {
        let numbers = |(volume, majorants): (&Drawn, &Arc<MajorantGrid>)| {
            Paths::new(stage, [drawn[0].volume, volume.volume], settings, majorants, sky)
        };
        let numbers: Vec<Paths> = drawn.iter().zip(majorants).map(numbers).collect();
        let numbers = match &*numbers {
            [one] => device.constant_buffer("paths", bytes_of(one)),
            several => storage(device, "paths", several),
        };
        let mut majorants = majorants.iter();
        let volumes = PassVolumes::new(device, drawn, |drawn, lists| {
            let majorants = majorants.next().map(|majorants| texels(device, stage, majorants));
            bindings(device, stage, drawn, drawing, lists).with_majorants(majorants)
        });
        let variants = |pass| volumes.variants().map(move |variant| Variant { pass, ..variant }).collect();
        let trace = pipelines.of_layers(device, variants(Pass::PathTrace))?.clone();
        let chromatic = stage.holds_back_each_color();
        let pixels = volumes.variants().map(|variant| Variant { pass: Pass::PathTracePixels, chromatic, ..variant });
        let pixels = pipelines.of_layers(device, pixels.collect())?.clone();
        if let Some(Sky::Image { map, .. }) = sky {
            kept.sky.get_or_insert_with(|| UploadedSky::new(device, map));
        }
        let sky = match &kept.sky {
            Some(sky) => sky.texels.clone(),
            None => texture::flat(device, "sky", TextureFormat::Rgba32Float, [1; 2], &[0; 16]),
        };
        Ok(Self { device, volumes, settings, numbers, sky, trace, pixels })
    }

    /// Draws all bands into a picture of the stage's size.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn draw(
        &mut self,
        kept: &mut KeptPaths,
        slot: &mut Option<Targets>,
        control: &Control,
        picture: &mut Picture,
    ) -> Result<(), GpuError> {
        let Window { low: [column, first], size: [width, height] } = self.volumes.first().bindings.window;
        let (mut row, end) = (first, if width == 0 { first } else { first + height });
        let mut paths = 0;
        while row < end {
            let rows = self.volumes.most_rows().min(end - row);
            let targets = {
                let shape = (picture.width, self.pixels.variant.chromatic);
                Targets::kept(slot, self.device, shape, [width, rows])
            };
            let report = |done: f64| {
                control.report((f64::from(row - first) + f64::from(rows) * done) / f64::from(height));
            };
            self.draw_band(targets, &mut kept.pace, [row, rows], control, &report)?;
            targets.read_pixels(self.device, [column, row], rows, picture, |pixel, place, picture| {
                let [noise, x, y, _] = pixel.surface;
                let [_, _, met, count] = pixel.counts;
                picture.noise[place] = noise;
                picture.normal[place] = unpacked_normal([x, y]);
                picture.statistics.rays_hit += u64::from(met);
                paths += u64::from(count);
            })?;
            row += rows;
        }
        picture.statistics.rays = paths;
        Ok(())
    }

    fn draw_band(
        &mut self,
        targets: &Targets,
        pace: &mut Pace,
        [row, rows]: [u32; 2],
        control: &Control,
        report: &dyn Fn(f64),
    ) -> Result<(), GpuError> {
        let states = ("states", targets.states());
        let numbers = ("paths", self.numbers.as_entire_binding());
        let sees = [states.clone(), numbers.clone(), ("sky", BindingResource::TextureView(&self.sky))];
        let brick = self.volumes.first().resident.bricks[0];
        let [trace, pixels] = [&self.trace, &self.pixels].map(|Pipeline { groups, .. }| {
            let volume = self.volumes.volume_group(groups, &brick, control)?;
            Ok::<_, GpuError>([volume, self.volumes.table_group(groups)])
        });
        let (trace, pixels) = (trace?, pixels?);
        let size = [targets.width, rows, 1];
        let mut path = 0;
        while path < self.settings.samples {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            let some = path..path + pace.amount(MOST_PATHS.min(self.settings.samples - path));
            path = some.end;
            let pass = |path| PathBounds { rows: Rows { begin: u32::from(path == 0), ..Rows::of([row, rows, path]) } };
            let passes = BoundsBuffer::new(self.device, some.clone().map(pass));
            let frame = self.volumes.frame_group(&self.trace.groups, &passes, &sees);
            let started = Instant::now();
            let mut encoder = self.encoder();
            for number in 0..some.len() {
                let groups = [Some(&frame), Some(&trace[0]), Some(&trace[1])];
                dispatch(&mut encoder, &self.trace.pipeline, groups, passes.offset(number), size, None);
            }
            self.device.queue.submit([encoder.finish()]);
            self.device.wait()?;
            pace.learn(started.elapsed());
            report(f64::from(path) / f64::from(self.settings.samples));
        }
        let passes = BoundsBuffer::new(self.device, [PathBounds { rows: Rows::of([row, rows, 0]) }]);
        let own = [states, numbers, ("pixels", targets.pixels.as_entire_binding())];
        let frame = self.volumes.frame_group(&self.pixels.groups, &passes, &own);
        let groups = [Some(&frame), Some(&pixels[0]), Some(&pixels[1])];
        let mut encoder = self.encoder();
        dispatch(&mut encoder, &self.pixels.pipeline, groups, 0, size, None);
        targets.copy(&mut encoder, rows);
        self.device.queue.submit([encoder.finish()]);
        Ok(())
    }

    fn encoder(&self) -> CommandEncoder {
        self.device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("paths") })
    }
}

/// What shaders are told of a volume whose lists lie where `lists` says.
fn bindings<'a>(
    device: &'a Device,
    stage: &Stage,
    Drawn { volume, resident, optics, uploads }: &Drawn<'a, '_>,
    drawing: Drawing,
    lists: [u32; 4],
) -> Bindings<'a> {
    let alter = |frame: &mut uniforms::Frame| {
        // Ambient light is what paths find out, and what has no material does not shine by itself.
        let material = volume.material.unwrap_or(Material { emission: 0.0, ..Material::default() });
        frame.set_material(&material, 0.0);
        // Paths are spread over each pixel anyway.
        frame.picture[0] = stage.viewpoint.width as f32 / 2.0;
        frame.picture[1] = stage.viewpoint.height as f32 / 2.0;
        (frame.size[2], frame.jitter[2]) = (1, 0);
        frame.lists = lists;
    };
    Bindings::new(device, resident, (stage, volume), (optics, uploads), drawing.interpolation, alter)
}

/// Majorants per step, and how many blocks away the next one is where there is some.
fn texels(device: &Device, stage: &Stage, majorants: &MajorantGrid) -> TextureView {
    let number = |(block, &[_, most]): (usize, &[f32; 2])| {
        [most * stage.step as f32, f32::from(majorants.leaps.distance(block))]
    };
    let blocks: Vec<[f32; 2]> = majorants.bounds.iter().enumerate().map(number).collect();
    let dims = majorants.leaps.dims();
    texture::solid(device, "majorants", TextureFormat::Rg32Float, dims, cast_slice(&blocks))
}

/// A unit vector from its point on the unfolded octahedron, as `path_trace_pixels.wgsl` makes it; zero if it is beyond.
fn unpacked_normal([x, y]: [f32; 2]) -> [f32; 3] {
    if x.abs() > 1.0 {
        return [0.0; 3];
    }
    let z = 1.0 - x.abs() - y.abs();
    let [x, y] = if z < 0.0 { [(1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)] } else { [x, y] };
    Vec3::new(x, y, z).normalize_or_zero().to_array()
}
