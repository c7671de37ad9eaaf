//! From a stage to a frame.

use std::sync::Arc;
use std::time::Instant;

use pellucid_field::{Volume, memory};
use pellucid_optics::{Anisotropy, Phase, ResolvedLight, Scattering, Shadows, Sky};
use pellucid_plan::{PlanCache, Tables, cautions, merge_order};
use pellucid_scene::{
    Control, Frame, FrameStatistics, Mode, Overlap, RenderWarning, Stage, StageVolume, Technique, denoise,
};

use crate::bricks;
use crate::device::Device;
use crate::drawing::{Drawing, Interpolation, Passes};
use crate::half_angle::{self, HalfAngleSlicer, KeptLight};
use crate::light_volume::{self, LightVolumes};
use crate::on_device::{OnDevice, Wanted};
use crate::optics::Optics;
use crate::path_trace::{self, KeptPaths, PathTracer};
use crate::pipelines::Pipelines;
use crate::plan::Demands;
use crate::ray_cast::{KeptRays, RayCaster};
use crate::slicing::{self, KeptSlices, Slicer};
use crate::targets::Targets;
use crate::texture::{Encoding, Layout, Part, Source};
use crate::timer::Timer;
use crate::{AdapterChoice, Ceiling, GpuError, MemoryPlan};

/// The GPU backend. Keep one for several frames: the volume stays on the device, and so do pipelines.
pub struct GpuRenderer {
    device: Device,
    drawing: Drawing,
    pipelines: Pipelines,
    cache: PlanCache,
    /// The volumes that were drawn last, in the order in which they are merged.
    volumes: Vec<OnDevice>,
    light: Option<LightVolumes>,
    rays: KeptRays,
    slices: KeptSlices,
    travelling: KeptLight,
    paths: KeptPaths,
    targets: Option<Targets>,
    /// The device's clock, if it has one.
    timer: Option<Timer>,
    /// Most bytes to use: the device's, or less once it had no more.
    budget: u64,
    /// Drawn into, so that a frame is finished or what it was before.
    next: Frame,
}

impl GpuRenderer {
    /// A renderer on an adapter, with limits lowered to a ceiling.
    ///
    /// # Errors
    /// [`GpuError::Adapter`] or [`GpuError::Device`].
    pub fn new(choice: &AdapterChoice, ceiling: &Ceiling) -> Result<Self, GpuError> {
        Ok(Self::on(Device::open(choice, ceiling)?))
    }

    /// A renderer on an open device.
    pub fn on(device: Device) -> Self {
        Self {
            budget: device.capabilities.memory,
            cache: PlanCache::with_most_blocks(device.capabilities.limits.max_texture_dimension_3d as usize),
            timer: Timer::new(&device),
            device,
            drawing: Drawing::default(),
            pipelines: Pipelines::default(),
            rays: KeptRays::default(),
            slices: KeptSlices::default(),
            travelling: KeptLight::default(),
            paths: KeptPaths::default(),
            targets: None,
            volumes: Vec::new(),
            light: None,
            next: Frame::default(),
        }
    }

    /// Whether this backend has all that a stage asks for: its technique, and how its light travels.
    pub fn draws(stage: &Stage) -> bool {
        Self::lacks(stage).is_none()
    }

    /// What a stage asks for and this backend does not have, if anything.
    pub fn lacks(stage: &Stage) -> Option<String> {
        let lit = matches!(stage.mode(), Mode::Composite | Mode::Isosurface(_));
        let name = stage.technique.name();
        let shadows = stage.shadows == Shadows::None || stage.technique.needs().shadows;
        let noisy = |volume: &StageVolume| volume.perturbation.displaces() || volume.perturbation.varies();
        let face = lit && stage.path_trace().is_none() && stage.lights.iter().any(ResolvedLight::is_face);
        match &stage.technique {
            _ if face => Some("lighting.lights of kind rectangle".to_owned()),
            _ if stage.global_illumination().is_some() => {
                Some("technique.ray_cast.mode.isosurface.illumination.global".to_owned())
            }
            // Slices take a sample at its own place.
            Technique::Slicing(_) if stage.volumes.iter().any(noisy) => Some(format!("volumes.perturbation in {name}")),
            Technique::Slicing(_) if lit && !shadows => {
                Some(format!("lighting.shadows = {} in {name}", stage.shadows.name()))
            }
            _ if stage.has_layers() => lacks_of_layers(stage),
            Technique::PathTrace(_) => lacks_of_paths(stage),
            _ if stage.classifies_voxels() && stage.volumes.iter().any(|volume| stage.chroma(volume).is_some()) => {
                Some("scattering.extinction_color of classified voxels".to_owned())
            }
            Technique::RayCast(_) | Technique::Slicing(_) | Technique::HalfAngle(_) => None,
            _ => Some(name.to_owned()),
        }
    }

    /// The same renderer with another interpolation.
    pub fn with_interpolation(mut self, interpolation: Interpolation) -> Self {
        self.drawing.interpolation = interpolation;
        self
    }

    /// The same renderer with its work in other portions.
    pub fn with_passes(mut self, passes: Passes) -> Self {
        self.drawing.passes = passes;
        self
    }

    /// How the field is interpolated, if its format allows it.
    pub fn interpolation(&self) -> Interpolation {
        self.drawing.interpolation
    }

    /// The device it draws with.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// [`GpuError`]; nothing of an unfinished frame is returned.
    pub fn render(&mut self, stage: &Stage, control: &Control) -> Result<Frame, GpuError> {
        let mut frame = Frame::default();
        self.render_into(stage, control, &mut frame)?;
        Ok(frame)
    }

    /// Draws a frame into one that is there; its memory is used again.
    ///
    /// # Errors
    /// [`GpuError`]; the frame is then what it was before.
    pub fn render_into(&mut self, stage: &Stage, control: &Control, frame: &mut Frame) -> Result<(), GpuError> {
        let drawn = match self.draw(stage, control) {
            Err(GpuError::Memory { .. }) if self.held().is_some() => {
                // Drivers do not tell beforehand what they have: once more, with half of what was tried.
                let tried = self.held().map_or(self.budget, |plan| plan.total());
                self.volumes.clear();
                self.budget = tried / 2;
                self.draw(stage, control).map(|()| {
                    let plan = self.held().map(|plan| plan.to_string());
                    let reason = format!(
                        "the graphics device has no {} MiB; drawn with {}",
                        tried >> 20,
                        plan.unwrap_or_default()
                    );
                    self.next.warnings.push(RenderWarning::Memory { reason });
                })
            }
            drawn => drawn,
        };
        if let Err(error) = &drawn
            && *error != GpuError::Cancelled
        {
            // Whatever is on the device is not to be relied on.
            self.volumes.clear();
            self.light = None;
        }
        drawn?;
        std::mem::swap(&mut self.next, frame);
        Ok(())
    }

    /// What drawing a stage needs on the device. Nothing is uploaded.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`].
    pub fn plan(&mut self, stage: &Stage) -> Result<MemoryPlan, GpuError> {
        self.prepare(stage)?.plan().ok_or(GpuError::Volumes { found: 0, most: 1 })
    }

    /// What the volumes on the device were planned to need.
    fn held(&self) -> Option<MemoryPlan> {
        let plans = self.volumes.iter().filter_map(|held| Some(held.resident.as_ref()?.plan.clone()));
        plans.reduce(MemoryPlan::and)
    }

    /// Uploads what changed: `volume` is the one drawn last but for the voxels in `part`, and the stages
    /// to come show it. If it differs in shape or type, or none was drawn yet, nothing is done: a volume
    /// that is not known is uploaded when it is drawn.
    ///
    /// The voxels are on their way when this returns, and there before the next frame is drawn (8.2-1).
    ///
    /// # Errors
    /// [`GpuError::Part`] if the part does not lie in the volume; what the device reports.
    pub fn update(&mut self, volume: &Arc<Volume>, part: Part) -> Result<(), GpuError> {
        let dims = volume.grid().dims();
        if (0..3).any(|axis| part.low[axis] > part.high[axis] || part.high[axis] > dims[axis]) {
            return Err(GpuError::Part { low: part.low, high: part.high, dims });
        }
        self.light = None;
        let encoding = Encoding::of(volume, &self.device.capabilities);
        for resident in self.volumes.iter_mut().filter_map(|held| held.resident.as_mut()) {
            if resident.update(&self.device, volume, &encoding, part)? {
                break;
            }
        }
        Ok(())
    }

    fn prepare<'s>(&mut self, stage: &'s Stage) -> Result<Prepared<'s>, GpuError> {
        if let Some(what) = Self::lacks(stage) {
            // There is no other backend that slices.
            let advice = if stage.slicing().is_some() { "use ray_cast" } else { "use --backend cpu" };
            return Err(GpuError::Unsupported { what, advice });
        }
        let sky = stage.path_trace().map(|settings| settings.environment.resolve()).transpose()?.flatten();
        let light = light_volume::bytes(&self.device, stage)?;
        let (mut volumes, mut used) = (Vec::with_capacity(stage.volumes.len()), 0);
        for number in merge_order(stage) {
            // All volumes are under one sky, and in the same light.
            let (sky, light) = if volumes.is_empty() { (sky.as_ref(), light) } else { (None, 0) };
            let prepared = self.prepare_volume(stage, number, (sky, light), self.budget.saturating_sub(used))?;
            used = used.saturating_add(prepared.plan.kept());
            volumes.push(prepared);
        }
        Ok(Prepared { volumes, sky })
    }

    fn prepare_volume<'s>(
        &mut self,
        stage: &'s Stage,
        number: usize,
        (sky, light): (Option<&Sky>, u64),
        budget: u64,
    ) -> Result<Wanted<'s>, GpuError> {
        let volume = &stage.volumes[number];
        check_steps(stage, volume)?;
        let tables = self.cache.tables(stage, number)?;
        let sources = Source::of(&self.device, volume, &tables, stage);
        let optics = Optics::new(stage, number, &tables);
        let colors = self.cache.colors(stage, number);
        let demands = match stage.slicing() {
            Some(slicing) => slicing::demands(stage, volume, &optics, slicing),
            None => Demands {
                layout: Layout::Solid,
                border: bricks::border(stage, volume.volume.grid(), 1.0),
                pixel_bytes: 0,
                frame_bytes: stage.half_angle().map_or(0, half_angle::bytes)
                    + light
                    + path_trace::bytes(&self.device, sky)?
                    + colors.as_ref().map_or(0, |colors| size_of_val(colors.texels()) as u64),
            },
        };
        let (plan, bricks) = MemoryPlan::new(&self.device, budget, stage, volume, &sources, &optics, demands)?;
        let travels = stage.technique.needs().light.is_followed();
        let moves = tables.displacer.is_some() || tables.variation.is_some() || colors.is_some();
        let shadowed = stage.shadow_step(volume).is_some() || stage.light_resolution().is_some();
        if (travels || moves || shadowed || stage.has_layers()) && bricks.len() > 1 {
            let what = match stage.has_layers() {
                true => format!("volumes[{number}], as one of several that are whole,"),
                false => "the volume, which light on its way, noise and colours need whole,".to_owned(),
            };
            let needed = volume.volume.voxels().as_bytes().len() as u64;
            let advice = "draw it with --backend cpu, or resample it";
            return Err(GpuError::Budget { what, needed, budget: plan.budget, advice });
        }
        Ok(Wanted { volume, number, tables, colors, sources, plan, bricks })
    }

    /// Draws the next frame.
    fn draw(&mut self, stage: &Stage, control: &Control) -> Result<(), GpuError> {
        let started = Instant::now();
        // A device that was lost stays so: nothing needs to be made ready for it.
        self.device.check()?;
        let [width, height] = [stage.viewpoint.width, stage.viewpoint.height];
        if (self.next.width, self.next.height) != (width, height) {
            memory::afford(width.saturating_mul(height).saturating_mul(Frame::PIXEL_BYTES))?;
        }
        let Prepared { volumes, sky } = self.prepare(stage)?;
        let tables: Vec<Arc<Tables>> = volumes.iter().map(|prepared| prepared.tables.clone()).collect();
        let optics = volumes.iter().zip(&tables).map(|(prepared, tables)| Optics::new(stage, prepared.number, tables));
        let optics: Vec<Optics> = optics.collect();
        // The memory of the last volumes and their tables is free before that of these is asked for.
        self.volumes.resize_with(volumes.len(), OnDevice::default);
        for ((held, prepared), optics) in self.volumes.iter_mut().zip(&volumes).zip(&optics) {
            held.forget_others(prepared, optics);
        }
        self.paths.forget_others(sky.as_ref());
        let mut drawn = Vec::with_capacity(volumes.len());
        for ((held, prepared), optics) in self.volumes.iter_mut().zip(volumes).zip(&optics) {
            drawn.push(held.filled(&self.device, prepared, optics));
        }
        let frame = &mut self.next;
        frame.clear(stage.viewpoint.width, stage.viewpoint.height);
        let device = &self.device;
        let target = (&mut self.targets, self.timer.as_ref());
        let drawing = match &stage.technique {
            Technique::PathTrace(settings) => {
                let majorants = merge_order(stage)
                    .into_iter()
                    .zip(&tables)
                    .map(|(number, tables)| self.cache.majorants(stage, number, tables, settings.majorants));
                let majorants = majorants.collect::<Result<Vec<_>, _>>()?;
                let (what, sky) = ((stage, settings), (sky.as_ref(), &mut self.paths));
                let volumes = (drawn, &*majorants);
                let tracer = PathTracer::new(device, &mut self.pipelines, what, volumes, sky, self.drawing);
                let (mut tracer, drawing) = (tracer?, Instant::now());
                tracer.draw(&mut self.paths, target.0, control, frame)?;
                if settings.denoise {
                    denoise(frame, settings.samples, control).map_err(|_| GpuError::Cancelled)?;
                }
                drawing
            }
            Technique::RayCast(_) => {
                let (kept, pipelines) = (&mut self.light, &mut self.pipelines);
                let volumes = (drawn.as_mut_slice(), tables.as_slice());
                let light = LightVolumes::kept(kept, device, pipelines, stage, volumes, self.drawing, control)?;
                let caster = RayCaster::new(device, pipelines, stage, drawn, (self.drawing, light));
                let (mut caster, drawing) = (caster?, Instant::now());
                caster.draw(&mut self.rays, target, control, frame)?;
                drawing
            }
            Technique::HalfAngle(settings) => {
                let slicer = HalfAngleSlicer::new(device, &mut self.pipelines, (stage, settings), drawn, self.drawing);
                let (mut slicer, drawing) = (slicer?, Instant::now());
                slicer.draw(&mut self.travelling, target, control, frame)?;
                drawing
            }
            Technique::Slicing(slicing) => {
                let pipelines = (&mut self.pipelines, &mut self.slices.pipelines);
                let slicer = Slicer::new(device, pipelines, (stage, slicing), drawn, self.drawing);
                let (mut slicer, drawing) = (slicer?, Instant::now());
                slicer.draw(&mut self.slices, target, control, frame)?;
                drawing
            }
            other => {
                return Err(GpuError::Unsupported { what: other.name().to_owned(), advice: "use --backend cpu" });
            }
        };
        let rays = (stage.viewpoint.width * stage.viewpoint.height) as u64;
        frame.statistics = FrameStatistics {
            waiting: 0,
            rays: match stage.technique {
                // Paths are counted as they are followed.
                Technique::PathTrace(_) => frame.statistics.rays,
                _ => rays * u64::from(stage.quality.supersampling).pow(2),
            },
            setup_seconds: (drawing - started).as_secs_f64(),
            render_seconds: drawing.elapsed().as_secs_f64(),
            ..frame.statistics
        };
        frame.warnings.extend(stage.fallbacks());
        frame.warnings.extend(cautions(stage, light_volume::side(device)));
        frame.backdrop = stage.backdrop();
        if frame.statistics.samples_visible == 0 || stage.is_too_faint(frame) {
            frame.warnings.push(RenderWarning::empty(stage, frame.statistics.rays_hit));
        }
        Ok(())
    }
}

/// What the path tracer of this backend does not have.
fn lacks_of_paths(stage: &Stage) -> Option<String> {
    let lacks = |what: &str| Some(format!("{what} in path_trace"));
    stage.volumes.iter().find_map(|volume| {
        let Scattering { phase, anisotropy, .. } = &volume.scattering;
        let varies = matches!(phase, Phase::Hybrid { .. }) && *anisotropy != Anisotropy::Uniform;
        varies.then(|| lacks("anisotropy of a hybrid phase function over the data")).flatten()
    })
}

/// What of several volumes in one picture this backend does not have.
fn lacks_of_layers(stage: &Stage) -> Option<String> {
    let (count, name) = (stage.volumes.len(), stage.technique.name());
    match (&stage.technique, stage.mode()) {
        (Technique::RayCast(_), Mode::Composite) => {
            let casts = stage.volumes.iter().any(|volume| stage.shadow_step(volume).is_some());
            // Each volume holds light back by itself.
            let merges = casts && stage.overlap != Overlap::Add;
            merges.then(|| "lighting.shadows between volumes whose overlap is not add".to_owned())
        }
        (Technique::RayCast(_) | Technique::HalfAngle(_), _) => None,
        (Technique::Slicing(_), _) if stage.technique.needs().several_volumes => None,
        (Technique::PathTrace(_), _) => lacks_of_paths(stage),
        _ => Some(format!("{count} volumes in one picture by {name}")),
    }
}

/// What is known of a stage before anything of it is on the device.
struct Prepared<'s> {
    /// In the order in which they are merged.
    volumes: Vec<Wanted<'s>>,
    sky: Option<Sky>,
}

impl Prepared<'_> {
    /// What all of it needs.
    fn plan(self) -> Option<MemoryPlan> {
        self.volumes.into_iter().map(|wanted| wanted.plan).reduce(MemoryPlan::and)
    }
}

/// Steps are numbered in `f32`, which counts to 2^24 without a gap.
fn check_steps(stage: &Stage, volume: &StageVolume) -> Result<(), GpuError> {
    const MOST: u32 = 1 << 24;
    let found = stage.most_steps(volume);
    if found < f64::from(MOST) { Ok(()) } else { Err(GpuError::Steps { found, limit: MOST }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Device;
    use pellucid_field::Grid;
    use pellucid_scene::{Format, Scene};

    #[test]
    fn a_device_without_memory_is_tried_again_with_half_of_it_in_bricks() {
        let grid = Grid::new([100; 3]).unwrap();
        let values = (0..grid.len()).map(|k| (k % 251) as u8).collect::<Vec<_>>();
        let volume = Arc::new(Volume::new(grid, values).unwrap());
        let mut scene = Scene::parse("[[volumes]]\nsource = \"memory\"", Format::Toml).unwrap();
        (scene.image.width, scene.image.height) = (16, 16);
        let (stage, _) = scene.resolve(&[volume]).unwrap();
        let open = |choice| Device::open(&choice, &Ceiling { memory: Some(1400 << 10), ..Ceiling::default() });
        let device = open(AdapterChoice::Hardware).or_else(|_| open(AdapterChoice::Software)).unwrap();
        let mut gpu = GpuRenderer::on(device).with_interpolation(Interpolation::Exact);
        let whole = gpu.render(&stage, &Control::default()).unwrap();
        let tried = gpu.plan(&stage).unwrap();
        assert_eq!((tried.bricks, whole.warnings.len()), (1, 0), "{tried}");
        // What a driver would report.
        let refused = GpuError::Memory { reason: "none left".to_owned() };
        gpu.device.note(refused);
        let again = gpu.render(&stage, &Control::default()).unwrap();
        let plan = gpu.plan(&stage).unwrap();
        assert!(plan.bricks > 1 && plan.total() <= tried.total() / 2, "{plan}");
        assert!(matches!(&again.warnings[..], [RenderWarning::Memory { reason }] if reason.contains("bricks")));
        assert_eq!(again.color, whole.color);
        assert!(gpu.render(&stage, &Control::default()).unwrap().warnings.is_empty());
    }
}
