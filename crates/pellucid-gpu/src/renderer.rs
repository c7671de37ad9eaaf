//! From a stage to a frame.

use std::time::Instant;

use pellucid_scene::{Control, Frame, FrameStatistics, RenderWarning, Stage, StageVolume};

use crate::device::Device;
use crate::optics::BlockCache;
use crate::pipelines::Pipelines;
use crate::ray_cast::{RayCaster, Reused};
use crate::resident::Resident;
use crate::tables::Tables;
use crate::{AdapterChoice, Ceiling, GpuError};

/// How the field is interpolated between voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// In the shader, in single precision: agrees with the CPU backend.
    Exact,
    /// By the texture unit, whose positions have some 8 bits between voxels: fast. Falls back to
    /// [`Interpolation::Exact`] where voxels are absent or the format cannot be filtered.
    #[default]
    Hardware,
}

/// How the work of a frame is handed to the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Passes {
    /// Every ray from its entry to its end at once (7.2), in bands of the picture that take a few
    /// hundredths of a second.
    #[default]
    Single,
    /// All rays for a while, then those that are not done (7.4): the picture is the same to the bit, no
    /// submission is long whatever rays meet, and rays that have ended cost nothing. Volumes in bricks
    /// are drawn brick by brick instead.
    Wavefront,
}

/// How frames are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Drawing {
    pub interpolation: Interpolation,
    pub passes: Passes,
}

/// The GPU backend. Keep one for several frames: the volume stays on the device, and so do pipelines.
pub struct GpuRenderer {
    device: Device,
    drawing: Drawing,
    pipelines: Pipelines,
    blocks: BlockCache,
    resident: Option<Resident>,
    tables: Option<Tables>,
    reused: Reused,
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
            reused: Reused::new(&device),
            device,
            drawing: Drawing::default(),
            pipelines: Pipelines::default(),
            blocks: BlockCache::default(),
            resident: None,
            tables: None,
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
    /// [`GpuError`]; the frame is then empty or unfinished.
    pub fn render_into(&mut self, stage: &Stage, control: &Control, frame: &mut Frame) -> Result<(), GpuError> {
        let [volume] = stage.volumes.as_slice() else {
            return Err(GpuError::Volumes { found: stage.volumes.len() });
        };
        check_steps(stage, volume)?;
        let started = Instant::now();
        let tables = Tables::of(self.tables.take(), &self.device, stage, volume, &mut self.blocks)?;
        let tables = self.tables.insert(tables);
        let mut resident = match self.resident.take() {
            Some(resident) if resident.holds(volume, stage) => resident,
            _ => Resident::plan(&self.device, volume, stage)?,
        };
        let drawing = Instant::now();
        frame.clear(stage.viewpoint.width, stage.viewpoint.height);
        let mut caster =
            RayCaster::new(&self.device, &mut self.pipelines, &mut resident, stage, volume, tables, self.drawing)?;
        caster.draw(&mut self.reused, control, frame)?;
        self.resident = Some(resident);
        let rays = (stage.viewpoint.width * stage.viewpoint.height) as u64;
        frame.statistics = FrameStatistics {
            rays: rays * u64::from(stage.quality.supersampling).pow(2),
            setup_seconds: (drawing - started).as_secs_f64(),
            render_seconds: drawing.elapsed().as_secs_f64(),
            ..frame.statistics
        };
        if frame.statistics.samples_visible == 0 {
            frame.warnings.push(RenderWarning::empty(frame.statistics.rays_hit));
        }
        Ok(())
    }
}

/// Steps are numbered in `f32`, which counts to 2^24 without a gap.
fn check_steps(stage: &Stage, volume: &StageVolume) -> Result<(), GpuError> {
    const MOST: u32 = 1 << 24;
    let found = stage.most_steps(volume);
    if found < f64::from(MOST) { Ok(()) } else { Err(GpuError::Steps { found, limit: MOST }) }
}
