//! Slices through the volume, blended by the device (chapter 3): what fragments find is what the ray caster would
//! find at the same place, by the same shaders.

mod blending;
mod boxes;
mod geometry;
mod lattice;
mod pipelines;
mod polygon;
mod slabs;
mod sliced;
mod targets;
mod view;

use pellucid_scene::{Control, Frame as Picture, RenderWarning, Slicing, Stage, StageVolume};
use wgpu::CommandEncoder;

use crate::bindings::Bindings;
use crate::bricks;
use crate::dispatch::dispatch;
use crate::drawing::Drawing;
use crate::on_device::Drawn;
use crate::optics::Optics;
use crate::pace::Pace;
use crate::pass_volumes;
use crate::pipelines::{Pipeline, Pipelines};
use crate::plan::Demands;
use crate::shaders::{Pass, Variant};
use crate::targets::Targets;
use crate::texture::Layout;
use crate::timer::Timer;
use crate::window::Window;
use crate::{Device, GpuError};

use geometry::MOST_STRIDE;
use lattice::Lattice;
use pipelines::DrawPipelines;
use sliced::{Layer, Sliced};
use targets::Canvas;

#[cfg(test)]
pub use boxes::SliceBox;

/// What the slices of a stage want of the memory.
pub fn demands(stage: &Stage, volume: &StageVolume, optics: &Optics, slicing: &Slicing) -> Demands {
    let grid = volume.volume.grid();
    let lattice = Lattice::new(stage, grid, slicing);
    let filtered = Bindings::needs_kernels(stage, optics);
    let layout = lattice.axis.filter(|_| !filtered).map_or(Layout::Solid, Layout::Stack);
    let border = bricks::border(stage, grid, lattice.longest.min(MOST_STRIDE));
    Demands { layout, border, pixel_bytes: Canvas::PIXEL_BYTES, frame_bytes: 0 }
}

/// What is kept from frame to frame.
#[derive(Default)]
pub struct KeptSlices {
    /// Pipelines that draw.
    pub pipelines: DrawPipelines,
    /// Slices in a submission.
    pace: Pace,
    /// What they are blended in.
    canvas: Option<Canvas>,
}

/// Everything on the device that one frame is drawn with.
pub struct Slicer<'a> {
    device: &'a Device,
    stage: &'a Stage,
    /// What is sliced, one after the other; more than one if what slices add up to is merged at the end.
    parts: Vec<Sliced<'a>>,
    /// What merges it, and adds it to the picture.
    merge: Option<[Pipeline; 2]>,
    warnings: Vec<RenderWarning>,
}

impl<'a> Slicer<'a> {
    /// Makes pipelines and what changes with the camera.
    ///
    /// # Errors
    /// What the device reports; [`GpuError::Volumes`] if a pass cannot be given as many volumes.
    pub fn new(
        device: &'a Device,
        (pipelines, draws): (&mut Pipelines, &mut DrawPipelines),
        (stage, slicing): (&'a Stage, &'a Slicing),
        drawn: Vec<Drawn<'a, '_>>,
        drawing: Drawing,
    ) -> Result<Self, GpuError> {
        let mut sliced = |some| Sliced::new(device, (pipelines, draws), (stage, slicing), some, drawing);
        let parts = pass_volumes::parts(drawn).into_iter().map(&mut sliced).collect::<Result<Vec<_>, _>>()?;
        let merge = match parts.len() {
            1 => None,
            several => {
                let merge = pipelines.of_layers(device, vec![Variant::of(Pass::Apart); several])?.clone();
                let resolve = Variant { layered: true, ..Variant::of(Pass::Resolve) };
                Some([merge, pipelines.get(device, resolve)?.clone()])
            }
        };
        let mut warnings = Vec::new();
        if parts[0].is_coarse {
            let reason = "the graphics device does not blend 32-bit floats: slices are blended in 16 bits".to_owned();
            warnings.push(RenderWarning::Fallback { reason });
        }
        if parts.iter().any(Sliced::misses_rays) {
            let reason = "some rays run along the slices or meet them from behind, and see nothing: \
                view_aligned slices have none"
                .to_owned();
            warnings.push(RenderWarning::Fallback { reason });
        }
        Ok(Self { device, stage, parts, merge, warnings })
    }

    /// Draws all bands into a picture of the stage's size.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn draw(
        &mut self,
        kept: &mut KeptSlices,
        (slot, timer): (&mut Option<Targets>, Option<&Timer>),
        control: &Control,
        picture: &mut Picture,
    ) -> Result<(), GpuError> {
        let Window { low: [column, first], size: [width, height] } = self.parts[0].volumes.first().bindings.window;
        let rays = self.stage.quality.supersampling.pow(2);
        let timer = timer.filter(|_| self.parts.iter().all(|part| part.volumes.are_complete()));
        let mut busy = timer.map(|_| 0.0);
        let most = self.parts.iter().map(|part| part.volumes.most_rows()).min().unwrap_or(1);
        let (mut row, end) = (first, if width == 0 { first } else { first + height });
        while row < end {
            let rows = most.min(end - row);
            let size = [width, rows];
            // The old ones go first.
            kept.canvas.take_if(|canvas| !canvas.fits(size, &self.parts[0].blending));
            let targets = Targets::kept_apart(slot, self.device, self.parts.len(), (picture.width, false), size);
            let canvas = kept.canvas.get_or_insert_with(|| Canvas::new(self.device, size, &self.parts[0].blending));
            let count = self.parts.len();
            for (sub, number) in (0..rays).flat_map(|sub| (0..count).map(move |number| (sub, number))) {
                let part = &mut self.parts[number];
                let layer = part.layer(canvas, [row, rows, sub]);
                let seconds = part.draw_layer(canvas, &layer, timer, &mut kept.pace, control)?;
                busy = busy.zip(seconds).map(|(busy, seconds)| busy + seconds);
                let mut encoder = sliced::encoder(self.device);
                part.add_to_pixels(&mut encoder, canvas, targets, &layer, number);
                if number + 1 == count {
                    self.merge(&mut encoder, targets, &layer);
                    if sub + 1 == rays {
                        targets.copy(&mut encoder, rows);
                    }
                }
                self.device.queue.submit([encoder.finish()]);
            }
            targets.read(self.device, [column, row], rows, picture)?;
            row += rows;
            control.report(f64::from(row - first) / f64::from(height));
        }
        picture.statistics.device_seconds = busy;
        picture.warnings.append(&mut self.warnings);
        Ok(())
    }

    /// What several volumes have made of rays becomes a part of the pixels.
    fn merge(&self, encoder: &mut CommandEncoder, targets: &Targets, layer: &Layer) {
        let Some([merge, resolve]) = &self.merge else { return };
        let pixels = ("pixels", targets.pixels.as_entire_binding());
        let size = [targets.width, layer.rows, 1];
        for (pipeline, own) in
            [(merge, vec![("states", targets.states())]), (resolve, vec![("states", targets.states_in(0)), pixels])]
        {
            let frame = self.parts[0].volumes.frame_group(&pipeline.groups, &layer.passes, &own);
            dispatch(encoder, &pipeline.pipeline, [Some(&frame), None, None], 0, size, None);
        }
    }
}
