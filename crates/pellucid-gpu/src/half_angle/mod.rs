//! Half-angle slicing: light that travels through the volume while it is drawn (6.3), slab by slab as in the CPU
//! backend. Light is a layer of texels in front of every slab of a *run*: shaders pass it from layer to layer,
//! then the eye looks at the whole run. Runs follow each other without a stop, many in a submission. Slabs are those of
//! all volumes of the picture.

mod area;
mod layers;
mod numbers;

use std::ops::Range;
use std::time::Instant;

use bytemuck::bytes_of;
use pellucid_optics::ResolvedLight;
use pellucid_plan::half_angle::{Geometry, LightError, around, into_cone, lights, material, taps};
use pellucid_scene::{Control, Frame as Picture, HalfAngle, InScatter, Stage};
use wgpu::{BindingResource, Buffer, CommandEncoderDescriptor, Features};

use crate::bindings::Bindings;
use crate::bounds::{BoundsBuffer, EyeBounds, LightBounds, RayBounds, Rows, Run};
use crate::dispatch::dispatch;
use crate::drawing::{Drawing, Interpolation};
use crate::groups::Named;
use crate::on_device::Drawn;
use crate::pace::Pace;
use crate::pass_volumes::{PassVolume, PassVolumes};
use crate::pipelines::{Pipeline, Pipelines};
use crate::shaders::{Pass, Variant};
use crate::targets::Targets;
use crate::timer::Timer;
use crate::uniforms;
use crate::window::Window;
use crate::{Device, GpuError};

use area::Areas;
pub use layers::Layers;
pub use numbers::Sweep;

/// Most slabs that the eye looks at together: fewer where a sample is a sum over many voxels, as
/// [`Kernels::most_looks`](crate::kernels::Kernels::most_looks) says. Texels of all their layers.
const MOST_RUN: u32 = 32;
const MOST_RUN_OF_KERNELS: u32 = 8;
const MOST_TEXELS: usize = 1 << 24;

/// What is kept from frame to frame.
#[derive(Default)]
pub struct KeptLight {
    /// Runs of slabs in a submission.
    pace: Pace,
    /// Light on its way through slabs.
    layers: Option<Layers>,
}

/// Everything on the device that one frame is drawn with.
pub struct HalfAngleSlicer<'a> {
    device: &'a Device,
    stage: &'a Stage,
    volumes: PassVolumes<'a>,
    lights: Vec<Travelling>,
    /// Texels of the widest and the highest of their pictures.
    size: [u32; 2],
    settings: &'a HalfAngle,
    light: Pipeline,
    presence: Option<Pipeline>,
    eye: Pipeline,
    surface: Pipeline,
    resolve: Pipeline,
}

/// A light on its way.
struct Travelling {
    geometry: Geometry,
    /// What shaders are told of it, volume by volume.
    numbers: Vec<Buffer>,
    /// Where it has something to do.
    areas: Areas,
    /// Slabs that the eye looks at together.
    run: u32,
}

impl Travelling {
    /// Texels of its picture.
    fn size(&self) -> [u32; 2] {
        self.geometry.frame.size.map(|n| n as u32)
    }

    /// Layers of texels for a run: light in front of every slab, and behind the last.
    fn layers(&self) -> u32 {
        self.run + 1
    }

    /// Runs of slabs; one at least, so that rays begin.
    fn runs(&self) -> u32 {
        (self.areas.slabs.len() as u32).div_ceil(self.run).max(1)
    }

    fn slabs_of(&self, run: u32) -> Range<u32> {
        let Range { start, end } = self.areas.slabs;
        let first = start + run * self.run;
        first..end.min(first + self.run)
    }
}

/// The most bytes that the light of a stage may take: known before the lights are looked at.
pub fn bytes(settings: &HalfAngle) -> u64 {
    let size = settings.resolution + 1;
    Layers::bytes([size; 2], run_length((size as usize).pow(2)) + 1)
}

/// How light is interpolated: as the volume is.
pub fn interpolation(device: &Device, drawing: Drawing) -> Interpolation {
    match drawing.interpolation {
        Interpolation::Hardware if device.capabilities.has(Features::FLOAT32_FILTERABLE) => Interpolation::Hardware,
        _ => Interpolation::Exact,
    }
}

/// Slabs in a run for pictures of so many texels; no picture depends on it.
fn run_length(texels: usize) -> u32 {
    ((MOST_TEXELS / texels.max(1)) as u32).clamp(1, MOST_RUN)
}

/// What is bound to shaders of one of the volumes, whose lists lie where `lists` says, among so many lights.
fn bindings<'a>(
    device: &'a Device,
    (stage, settings, lights): (&Stage, &HalfAngle, usize),
    Drawn { volume, resident, optics, uploads }: &Drawn<'a, '_>,
    interpolation: Interpolation,
    lists: [u32; 4],
) -> Bindings<'a> {
    let alter = |frame: &mut uniforms::Frame| {
        let (material, ambient) = material(stage, volume, settings, lights);
        frame.set_material(&material, ambient);
        frame.lists = lists;
    };
    let mut bindings = Bindings::new(device, resident, (stage, volume), (optics, uploads), interpolation, alter);
    bindings.variant = Variant {
        skip: optics.blocks.is_some(),
        transport: optics.tables.light.transport.is_some(),
        ..bindings.variant
    };
    bindings
}

impl<'a> HalfAngleSlicer<'a> {
    /// Makes pipelines and what changes with camera and light.
    ///
    /// # Errors
    /// [`GpuError::Light`] if there is no such light or one stands in a volume, [`GpuError::Volumes`] if a pass cannot be
    /// given as many volumes, or what the device reports.
    pub fn new(
        device: &'a Device,
        pipelines: &mut Pipelines,
        (stage, settings): (&'a Stage, &'a HalfAngle),
        drawn: Vec<Drawn<'a, '_>>,
        drawing: Drawing,
    ) -> Result<Self, GpuError> {
        let found = lights(stage, settings)?;
        // Where all light comes from matter, what is empty is dark.
        let is_lit_everywhere = settings.in_scatter != InScatter::BothFromMatter;
        let held: Vec<_> = drawn
            .iter()
            .map(|drawn| (drawn.volume.volume.grid(), drawn.optics.blocks.filter(|_| is_lit_everywhere)))
            .collect();
        let (what, interpolation) = ((stage, settings, found.len()), interpolation(device, drawing));
        let volumes =
            PassVolumes::new(device, drawn, |drawn, lists| bindings(device, what, drawn, interpolation, lists));
        let mut pipeline = |pass| {
            let (scatters_direct, gated) = match settings.in_scatter {
                InScatter::Indirect => (false, false),
                InScatter::Direct => (true, false),
                InScatter::DirectFromMatter | InScatter::BothFromMatter => (true, true),
            };
            let indirect = settings.indirect > 0.0;
            let variant = |of| Variant { pass, indirect, scatters_direct, gated, ..of };
            pipelines.of_layers(device, volumes.variants().map(variant).collect()).cloned()
        };
        let light = pipeline(Pass::HalfAngleLight)?;
        let presence = light.variant.gated.then(|| pipeline(Pass::HalfAnglePresence));
        let [eye, surface] = [Pass::HalfAngleEye, Pass::HalfAngleSurface].map(&mut pipeline);
        let grid = around(stage)?;
        let geometry = |(number, light): &(usize, ResolvedLight)| {
            Geometry::new(stage, &grid, settings, light).ok_or(LightError::Inside { light: *number })
        };
        let geometries = found.iter().map(geometry).collect::<Result<Vec<_>, _>>()?;
        let size =
            [0, 1].map(|axis| geometries.iter().map(|geometry| geometry.frame.size[axis] as u32).max().unwrap_or(1));
        let has_kernels = volumes.variants().any(|variant| variant.kernels);
        let cone = into_cone(stage, settings);
        let most = if has_kernels { MOST_RUN_OF_KERNELS } else { MOST_RUN };
        let travelling = |((_, light), geometry): (&(usize, ResolvedLight), Geometry)| {
            let is_blurred = settings.indirect > 0.0 && taps::count(settings) > 0;
            let radius = taps::radius(settings, geometry.longest, grid.smallest_spacing());
            let reach = if is_blurred { radius * geometry.frame.finest(&grid) } else { 0.0 };
            let sides = Layers::sides(size);
            let numbers = |volume: &PassVolume| {
                let what = (stage, volume.volume.volume.grid());
                let sweep = Sweep::new(what, (settings, cone), &geometry, (light, found.len()), sides);
                device.constant_buffer("sweep", bytes_of(&sweep))
            };
            Travelling {
                numbers: volumes.each().iter().map(numbers).collect(),
                areas: Areas::new(&geometry, &held, reach),
                run: run_length(geometry.frame.size.iter().product()).min(most).min(geometry.slabs.count as u32),
                geometry,
            }
        };
        let lights = found.iter().zip(geometries).map(travelling).collect();
        let (chromatic, layered) = (stage.holds_back_each_color(), stage.has_layers());
        Ok(Self {
            lights,
            size,
            presence: presence.transpose()?,
            eye: eye?,
            surface: surface?,
            resolve: pipelines.get(device, Variant { chromatic, layered, ..Variant::of(Pass::Resolve) })?.clone(),
            device,
            volumes,
            stage,
            settings,
            light,
        })
    }

    /// Draws all bands into a picture of the stage's size.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn draw(
        &mut self,
        kept: &mut KeptLight,
        (slot, timer): (&mut Option<Targets>, Option<&Timer>),
        control: &Control,
        picture: &mut Picture,
    ) -> Result<(), GpuError> {
        let Window { low: [column, first], size: [width, height] } = self.volumes.first().bindings.window;
        let subs = self.stage.quality.supersampling.pow(2);
        let mut busy = timer.map(|_| 0.0);
        let most = self.lights.iter().map(Travelling::layers).max().unwrap_or(1);
        let layers = Layers::kept(&mut kept.layers, self.device, self.size, most);
        let (mut row, end) = (first, if width == 0 { first } else { first + height });
        while row < end {
            let rows = self.volumes.most_rows().min(end - row);
            let targets = {
                let shape = (picture.width, self.stage.holds_back_each_color());
                Targets::kept(slot, self.device, shape, [width, rows])
            };
            for sub in 0..subs {
                for light in 0..self.lights.len() {
                    let place = [row, rows, sub];
                    let seconds = self.sweep(targets, layers, timer, &mut kept.pace, (light, place), control)?;
                    busy = busy.zip(seconds).map(|(busy, seconds)| busy + seconds);
                    let done = (sub as usize * self.lights.len() + light + 1) as f64;
                    let all = f64::from(subs) * self.lights.len() as f64;
                    control.report((f64::from(row - first) + f64::from(rows) * done / all) / f64::from(height));
                }
                self.resolve(targets, [row, rows, sub], sub + 1 == subs);
            }
            targets.read(self.device, [column, row], rows, picture)?;
            row += rows;
        }
        picture.statistics.device_seconds = busy;
        Ok(())
    }

    /// Lets a light pass all slabs and the eye look at them. Returns the seconds that the device worked, if it
    /// tells.
    fn sweep(
        &mut self,
        targets: &Targets,
        layers: &Layers,
        timer: Option<&Timer>,
        pace: &mut Pace,
        (number, [row, rows, sub]): (usize, [u32; 3]),
        control: &Control,
    ) -> Result<Option<f64>, GpuError> {
        let light = &self.lights[number];
        let (slabs, runs) = (light.areas.slabs.clone(), light.runs());
        let place = Rows::of([row, rows, sub]);
        let passes = BoundsBuffer::new(self.device, slabs.clone().map(|slab| self.light_pass(light, slab)));
        let looks = (0..runs).map(|run| eye_pass(light, run, place, number == 0));
        let surface = EyeBounds { rows: place, ..EyeBounds::default() };
        let looks = BoundsBuffer::new(self.device, looks.chain([surface]));
        let light = &self.lights[number];
        let numbers: Vec<_> = light.numbers.iter().map(|numbers| ("sweep", numbers.as_entire_binding())).collect();
        let volumes = &mut self.volumes;
        let mut bound = |pipeline, bounds, own: &[Named]| volumes.bound(pipeline, bounds, (own, &numbers), control);
        let held = ("held", BindingResource::TextureView(&layers.held));
        let advance = (0..light.layers())
            .map(|layer| {
                let [[before, _], [_, behind]] =
                    [layer, (layer + 1) % light.layers()].map(|layer| &layers.each[layer as usize]);
                let [before, behind] = [before, behind].map(BindingResource::TextureView);
                bound(&self.light, &passes, &[held.clone(), ("lost", before), ("next", behind)])
            })
            .collect::<Result<Vec<_>, _>>()?;
        let held = std::slice::from_ref(&held);
        let presence = self.presence.as_ref().map(|presence| bound(presence, &passes, held)).transpose()?;
        let states = ("states", targets.states());
        let all = ("lost", BindingResource::TextureView(&layers.all));
        let eye = bound(&self.eye, &looks, &[states.clone(), all])?;
        let surface = bound(&self.surface, &looks, &[states])?;
        let pixels = [targets.width, rows, 1];
        let [width, height] = light.size();
        let mut busy = Some(0.0);
        let mut next = 0;
        // Uploads are not what is measured.
        self.device.wait()?;
        while next < runs {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            let some = next..next + pace.amount(runs - next);
            next = some.end;
            let started = Instant::now();
            let mut encoder =
                self.device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("half-angle") });
            if some.start == 0 {
                layers.clear(&mut encoder);
            }
            let writes = |first, last| timer.and_then(|timer| timer.writes(0, first, last));
            for run in some.clone() {
                let here = light.slabs_of(run);
                for slab in here.clone() {
                    let offset = passes.offset((slab - slabs.start) as usize);
                    let [from, to] = light.areas.of(slab);
                    let texels = [to[0] - from[0], to[1] - from[1], 1];
                    if let Some(presence) = &presence {
                        presence.dispatch(&mut encoder, offset, [width, height, 1], None);
                    }
                    let begins = writes(run == some.start && slab == here.start, false);
                    advance[(slab % light.layers()) as usize].dispatch(&mut encoder, offset, texels, begins);
                }
                let ends = writes(run == some.start && here.is_empty(), run + 1 == some.end);
                eye.dispatch(&mut encoder, looks.offset(run as usize), pixels, ends);
            }
            if next == runs {
                surface.dispatch(&mut encoder, looks.offset(runs as usize), pixels, None);
            }
            if let Some(timer) = timer {
                timer.copy(&mut encoder, 1);
            }
            self.device.queue.submit([encoder.finish()]);
            self.device.wait()?;
            pace.learn(started.elapsed());
            busy = busy.zip(timer.and_then(|timer| timer.seconds(1))).map(|(busy, seconds)| busy + seconds);
        }
        Ok(busy)
    }

    /// Light passes a slab: from its layer in the run to the next.
    fn light_pass(&self, light: &Travelling, slab: u32) -> LightBounds {
        let [low, high] = light.areas.of(slab);
        let tap = taps::offsets(self.settings, slab as usize).first().copied().unwrap_or_default();
        LightBounds { low, high, tap, ..LightBounds::of(slab) }
    }

    /// Adds rays to their pixels.
    fn resolve(&self, targets: &Targets, [row, rows, sub]: [u32; 3], is_last: bool) {
        let pass = RayBounds { rows: Rows::of([row, rows, sub]), ..RayBounds::default() };
        let passes = BoundsBuffer::new(self.device, [pass]);
        let own = [("states", targets.states()), ("pixels", targets.pixels.as_entire_binding())];
        let group = self.volumes.frame_group(&self.resolve.groups, &passes, &own);
        let mut encoder =
            self.device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("half-angle") });
        let size = [targets.width, rows, 1];
        dispatch(&mut encoder, &self.resolve.pipeline, [Some(&group), None, None], 0, size, None);
        if is_last {
            targets.copy(&mut encoder, rows);
        }
        self.device.queue.submit([encoder.finish()]);
    }
}

/// The eye looks at a run.
fn eye_pass(light: &Travelling, run: u32, rows: Rows, is_first: bool) -> EyeBounds {
    let Range { start, end } = light.slabs_of(run);
    EyeBounds {
        rows: Rows { begin: u32::from(is_first && run == 0), ..rows },
        run: Run::of([start, end], light.layers()),
        begin_sweep: u32::from(run == 0),
    }
}
