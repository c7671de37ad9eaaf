//! From a stage to a frame.

use std::time::Instant;

use pellucid_scene::{Control, Frame, FrameStatistics, RenderWarning, Stage, StageVolume, TableCache};

use crate::device::Device;
use crate::optics::Optics;
use crate::pipelines::Pipelines;
use crate::ray_cast::{Bands, RayCaster};
use crate::resident::Resident;
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

/// The GPU backend. Keep one for several frames: the volume stays on the device, and so do pipelines.
pub struct GpuRenderer {
    device: Device,
    interpolation: Interpolation,
    pipelines: Pipelines,
    tables: TableCache,
    resident: Option<Resident>,
    bands: Bands,
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
            device,
            interpolation: Interpolation::default(),
            pipelines: Pipelines::default(),
            tables: TableCache::default(),
            resident: None,
            bands: Bands::default(),
        }
    }

    /// The same renderer with another interpolation.
    pub fn with_interpolation(mut self, interpolation: Interpolation) -> Self {
        self.interpolation = interpolation;
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
        let tables = self.tables.tables(stage, volume)?;
        let optics = Optics::new(stage, volume, &tables);
        let mut resident = match self.resident.take() {
            Some(resident) if resident.holds(volume, &tables, stage) => resident,
            _ => Resident::plan(&self.device, volume, &tables, stage)?,
        };
        let drawing = Instant::now();
        frame.clear(stage.viewpoint.width, stage.viewpoint.height);
        let hardware = self.interpolation == Interpolation::Hardware;
        let mut caster =
            RayCaster::new(&self.device, &mut self.pipelines, &mut resident, stage, volume, &optics, hardware)?;
        let drawn = caster.draw(&mut self.bands, control, frame);
        drawn?;
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
