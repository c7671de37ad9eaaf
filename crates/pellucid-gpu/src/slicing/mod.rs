//! Slices through the volume, blended by the device (chapter 3): what fragments find is what the ray caster would
//! find at the same place, by the same shaders.

mod blending;
mod boxes;
mod geometry;
mod lattice;
mod pipelines;
mod polygon;
mod targets;
mod view;

use std::ops::Range;
use std::time::Instant;

use bytemuck::{bytes_of, cast_slice};
use pellucid_scene::{Control, Frame as Picture, RenderWarning, Slicing, Stage, StageVolume};
use wgpu::{
    BindGroup, BindingResource, Buffer, BufferUsages, Color, CommandEncoder, CommandEncoderDescriptor, IndexFormat,
    LoadOp, Operations, RenderPass, RenderPassColorAttachment, RenderPassDepthStencilAttachment, RenderPassDescriptor,
    RenderPassTimestampWrites, StoreOp,
};

use crate::bindings::Bindings;
use crate::bounds::{BoundsBuffer, RayBounds, Rows};
use crate::bricks::{self, Brick};
use crate::dispatch::dispatch;
use crate::drawing::Drawing;
use crate::optics::Optics;
use crate::pace::Pace;
use crate::pipelines::{Pipeline, Pipelines};
use crate::plan::Demands;
use crate::resident::Resident;
use crate::shaders::{Pass, Traversal, Variant};
use crate::targets::Targets;
use crate::texture::Layout;
use crate::timer::Timer;
use crate::uniforms;
use crate::uploads::Uploads;
use crate::window::Window;
use crate::{Device, GpuError};

use blending::{Blending, cleared};
use geometry::{Geometry, MOST_STRIDE};
use lattice::Lattice;
use pipelines::{DrawPipeline, DrawPipelines};
use targets::Canvas;

#[cfg(test)]
pub use boxes::SliceBox;

/// Most looks at what is done in a frame: each waits for the slices before it.
const MOST_LOOKS: u32 = 64;

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
    resident: &'a mut Resident,
    stage: &'a Stage,
    volume: &'a StageVolume,
    slicing: &'a Slicing,
    bindings: Bindings<'a>,
    lattice: Lattice,
    geometry: Geometry,
    blending: Blending,
    slices: DrawPipeline,
    done: DrawPipeline,
    tiles: Pipeline,
    occlusion: Pipeline,
    pixels: Pipeline,
    warnings: Vec<RenderWarning>,
}

/// A band of the picture, for one of the rays of its pixels: where it is, and what it is drawn with.
struct Layer {
    rows: u32,
    passes: BoundsBuffer,
    numbers: Buffer,
    slices: BindGroup,
    done: BindGroup,
    tiles: BindGroup,
    occlusion: BindGroup,
}

impl<'a> Slicer<'a> {
    /// Makes pipelines and what changes with the camera.
    ///
    /// # Errors
    /// What the device reports.
    pub fn new(
        device: &'a Device,
        pipelines: (&mut Pipelines, &mut DrawPipelines),
        resident: &'a mut Resident,
        (stage, volume, slicing): (&'a Stage, &'a StageVolume, &'a Slicing),
        (optics, uploads): (&Optics, &'a Uploads),
        drawing: Drawing,
    ) -> Result<Self, GpuError> {
        let (pipelines, draws) = pipelines;
        let grid = volume.volume.grid();
        let lattice = Lattice::new(stage, grid, slicing);
        let alter = |frame: &mut uniforms::Frame| {
            if !lattice.jitters() {
                frame.jitter[2] = 0;
            }
            frame.stack[0] = lattice.axis.unwrap_or(0) as u32;
        };
        let mut bindings =
            Bindings::new(device, resident, (stage, volume), (optics, uploads), drawing.interpolation, alter);
        bindings.variant = Variant {
            traversal: Traversal::Slices,
            stack: resident.plan.layout != Layout::Solid,
            bleeding: optics.bleeds,
            opaque: false,
            ..bindings.variant
        }
        .canonical();
        let (blending, is_coarse) = Blending::new(device, optics.pass, slicing);
        let margin = view::margin(stage, grid, &lattice);
        let geometry = Geometry::new(device, (stage, grid), (slicing, &lattice), optics, &resident.bricks, margin)?;
        let pixels = Variant {
            traversal: Traversal::SlicePixels,
            opaque: optics.opaque,
            knots: !optics.nodes.knots().is_empty(),
            ..Variant::of(optics.pass)
        };
        let mut warnings = Vec::new();
        if is_coarse {
            let reason = "the graphics device does not blend 32-bit floats: slices are blended in 16 bits".to_owned();
            warnings.push(RenderWarning::Fallback { reason });
        }
        if lattice.longest.is_infinite() {
            let reason = "some rays run along the slices or meet them from behind, and see nothing: \
                view_aligned slices have none"
                .to_owned();
            warnings.push(RenderWarning::Fallback { reason });
        }
        Ok(Self {
            device,
            slices: draws.slices(device, bindings.variant, geometry.pass, blending)?,
            done: draws.done(device)?,
            tiles: pipelines.get(device, Variant::of(Pass::SliceTiles))?.clone(),
            occlusion: pipelines.get(device, Variant::of(Pass::SliceOcclusion))?.clone(),
            pixels: pipelines.get(device, pixels)?.clone(),
            resident,
            stage,
            volume,
            slicing,
            bindings,
            lattice,
            geometry,
            blending,
            warnings,
        })
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
        let Window { low: [column, first], size: [width, height] } = self.bindings.window;
        let rays = self.stage.quality.supersampling.pow(2);
        let timer = timer.filter(|_| self.resident.is_complete());
        let mut busy = timer.map(|_| 0.0);
        let (mut row, end) = (first, if width == 0 { first } else { first + height });
        while row < end {
            let rows = self.resident.plan.rows.min(end - row);
            let size = [width, rows];
            // The old ones go first.
            kept.canvas.take_if(|canvas| !canvas.fits(size, &self.blending));
            let targets = Targets::kept(slot, self.device, (picture.width, false), size);
            let canvas = kept.canvas.get_or_insert_with(|| Canvas::new(self.device, size, &self.blending));
            for sub in 0..rays {
                let layer = self.layer(canvas, [row, rows, sub]);
                let seconds = self.draw_layer(canvas, &layer, timer, &mut kept.pace, control)?;
                busy = busy.zip(seconds).map(|(busy, seconds)| busy + seconds);
                let mut encoder = self.encoder();
                self.add_to_pixels(&mut encoder, canvas, targets, &layer);
                if sub + 1 == rays {
                    targets.copy(&mut encoder, rows);
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

    /// What a band is drawn with.
    fn layer(&self, canvas: &Canvas, [row, rows, sub]: [u32; 3]) -> Layer {
        let Self { bindings, geometry, .. } = self;
        let pass = |(brick, _): &(Brick, Range<u32>)| {
            let texture_low = brick.voxels.low.map(|v| v as u32);
            RayBounds { rows: Rows::of([row, rows, sub]), texture_low, most_looks: u32::MAX, ..RayBounds::default() }
        };
        let passes = BoundsBuffer::new(self.device, geometry.shares.iter().map(pass));
        let what = (self.slicing, bindings.variant.pass, geometry.slices);
        let numbers = view::numbers(
            self.stage,
            self.volume.volume.grid(),
            &self.lattice,
            what,
            (&bindings.window, [row, rows, sub]),
        );
        let numbers = self.device.constant_buffer("slices", bytes_of(&numbers));
        // At first all boxes may be seen.
        let seen = vec![1u32; geometry.box_count.max(1) as usize];
        let visible = self.device.buffer("visible", cast_slice(&seen), BufferUsages::STORAGE);
        let own = [
            ("slices", numbers.as_entire_binding()),
            ("boxes", geometry.boxes.as_entire_binding()),
            ("instances", geometry.instances.as_entire_binding()),
            ("visible", visible.as_entire_binding()),
            ("tiles", canvas.tiles.as_entire_binding()),
            ("colors", BindingResource::TextureView(&canvas.colors)),
        ];
        let group = |groups| bindings.frame_group(groups, &passes, &own);
        Layer {
            rows,
            slices: group(&self.slices.groups),
            done: group(&self.done.groups),
            tiles: group(&self.tiles.groups),
            occlusion: group(&self.occlusion.groups),
            passes,
            numbers,
        }
    }

    /// Blends all slices, in submissions of bounded length. Returns the seconds that the device worked, if it
    /// tells.
    fn draw_layer(
        &mut self,
        canvas: &Canvas,
        layer: &Layer,
        timer: Option<&Timer>,
        pace: &mut Pace,
        control: &Control,
    ) -> Result<Option<f64>, GpuError> {
        let table = self.bindings.table_group(&self.slices.groups);
        let between = self.between_looks();
        let mut until_look = between;
        let mut busy = Some(0.0);
        let mut is_first = true;
        let shares = self.geometry.shares.clone();
        for (number, (brick, range)) in shares.iter().enumerate() {
            let offset = layer.passes.offset(number);
            let mut next = range.start;
            // Pixels without a slice have to be cleared, too.
            while next < range.end || (is_first && number + 1 == shares.len()) {
                if control.is_cancelled() {
                    return Err(GpuError::Cancelled);
                }
                let views = self.resident.textures(self.device, brick, control)?;
                let volume = self.bindings.volume_group(&self.slices.groups, &views);
                if self.resident.is_complete() {
                    // Uploads are not what is measured.
                    self.device.wait()?;
                }
                let started = Instant::now();
                let mut encoder = self.encoder();
                let end = range.end.min(next + pace.amount(range.end - next));
                let mut marked = false;
                loop {
                    if until_look == 0 {
                        self.look(&mut encoder, canvas, layer, offset, timer.filter(|_| !marked));
                        (until_look, marked) = (between, true);
                    }
                    let some = until_look.min(end - next);
                    let marks = timer.and_then(|timer| timer.render_writes(0, !marked, next + some == end));
                    marked = true;
                    let mut pass = self.begin(&mut encoder, canvas, is_first, marks);
                    is_first = false;
                    pass.set_pipeline(&self.slices.pipeline);
                    pass.set_bind_group(0, &layer.slices, &[offset]);
                    pass.set_bind_group(1, &volume, &[]);
                    pass.set_bind_group(2, &table, &[]);
                    pass.set_index_buffer(self.geometry.indices.slice(..), IndexFormat::Uint16);
                    pass.draw_indexed(0..self.geometry.index_count, 0, next..next + some);
                    drop(pass);
                    next += some;
                    until_look -= some;
                    if next == end {
                        break;
                    }
                }
                if let Some(timer) = timer {
                    timer.copy(&mut encoder, 1);
                }
                let submission = self.device.queue.submit([encoder.finish()]);
                if self.resident.is_complete() {
                    self.device.wait()?;
                    pace.learn(started.elapsed());
                    busy = busy.zip(timer.and_then(|timer| timer.seconds(1))).map(|(busy, seconds)| busy + seconds);
                } else {
                    self.resident.used(submission);
                    self.device.check()?;
                }
            }
        }
        Ok(busy.filter(|_| timer.is_some()))
    }

    /// Proxies between two looks at what is done.
    fn between_looks(&self) -> u32 {
        let interval = self.slicing.termination_interval;
        if interval == 0 || !self.blending.terminates {
            return u32::MAX;
        }
        let looks = (self.geometry.slices / interval).clamp(1, MOST_LOOKS);
        self.geometry.count().div_ceil(looks).max(1)
    }

    /// Marks what is done: pixels, so that fragments behind them are not worked on (8.6-2), and boxes that are
    /// behind nothing but such pixels (8.5-1).
    fn look(&self, encoder: &mut CommandEncoder, canvas: &Canvas, layer: &Layer, offset: u32, timer: Option<&Timer>) {
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("done"),
            depth_stencil_attachment: Some(depth(canvas, LoadOp::Load)),
            timestamp_writes: timer.and_then(|timer| timer.render_writes(0, true, false)),
            ..Default::default()
        });
        pass.set_pipeline(&self.done.pipeline);
        pass.set_bind_group(0, &layer.done, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        if self.slicing.occlusion_culling && self.geometry.box_count > 1 {
            let [columns, rows] = [self.bindings.window.size[0], layer.rows].map(|n| n.div_ceil(targets::TILE));
            let only = |group| [Some(group), None, None];
            let tiles = [columns, rows, 1];
            dispatch(encoder, &self.tiles.pipeline, only(&layer.tiles), offset, tiles, None);
            // Workgroups of 64 in a row.
            let boxes = [self.geometry.box_count.div_ceil(8), 1, 1];
            dispatch(encoder, &self.occlusion.pipeline, only(&layer.occlusion), offset, boxes, None);
        }
    }

    fn begin<'e>(
        &self,
        encoder: &'e mut CommandEncoder,
        canvas: &Canvas,
        clears: bool,
        timestamp_writes: Option<RenderPassTimestampWrites>,
    ) -> RenderPass<'e> {
        let target = |view, color| {
            let load = if clears { LoadOp::Clear(color) } else { LoadOp::Load };
            Some(RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load, store: StoreOp::Store },
            })
        };
        encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("slices"),
            color_attachments: &[
                target(&canvas.colors, cleared(self.bindings.variant.pass)),
                target(&canvas.counts, Color::TRANSPARENT),
            ],
            depth_stencil_attachment: Some(depth(canvas, if clears { LoadOp::Clear(1.0) } else { LoadOp::Load })),
            timestamp_writes,
            ..Default::default()
        })
    }

    /// What was blended becomes a part of the pixels.
    fn add_to_pixels(&self, encoder: &mut CommandEncoder, canvas: &Canvas, targets: &Targets, layer: &Layer) {
        let own = [
            ("pixels", targets.pixels.as_entire_binding()),
            ("slices", layer.numbers.as_entire_binding()),
            ("colors", BindingResource::TextureView(&canvas.colors)),
            ("taken", BindingResource::TextureView(&canvas.counts)),
        ];
        let frame = self.bindings.frame_group(&self.pixels.groups, &layer.passes, &own);
        let table = self.bindings.table_group(&self.pixels.groups);
        let size = [targets.width, layer.rows, 1];
        dispatch(encoder, &self.pixels.pipeline, [Some(&frame), None, Some(&table)], 0, size, None);
    }

    fn encoder(&self) -> CommandEncoder {
        self.device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("slices") })
    }
}

fn depth<'c>(canvas: &'c Canvas, load: LoadOp<f32>) -> RenderPassDepthStencilAttachment<'c> {
    RenderPassDepthStencilAttachment {
        view: &canvas.done,
        depth_ops: Some(Operations { load, store: StoreOp::Store }),
        stencil_ops: None,
    }
}
