//! Volumes that are sliced together: what is drawn of them, and how.

use std::ops::Range;
use std::time::Instant;

use bytemuck::{bytes_of, cast_slice};
use pellucid_scene::{Control, Slicing, Stage};
use wgpu::{
    BindGroup, BindingResource, Buffer, BufferUsages, Color, CommandEncoder, CommandEncoderDescriptor, IndexFormat,
    LoadOp, Operations, RenderPass, RenderPassColorAttachment, RenderPassDepthStencilAttachment, RenderPassDescriptor,
    RenderPassTimestampWrites, StoreOp,
};

use crate::bindings::Bindings;
use crate::bounds::{BoundsBuffer, RayBounds, Rows};
use crate::bricks::Brick;
use crate::dispatch::dispatch;
use crate::drawing::Drawing;
use crate::on_device::Drawn;
use crate::pace::Pace;
use crate::pass_volumes::{PassVolume, PassVolumes};
use crate::pipelines::{Pipeline, Pipelines};
use crate::shaders::{Pass, Traversal, Variant};
use crate::targets::Targets;
use crate::texture::Layout;
use crate::timer::Timer;
use crate::uniforms;
use crate::{Device, GpuError};

use super::blending::{Blending, cleared};
use super::geometry::Geometry;
use super::lattice::Lattice;
use super::pipelines::{DrawPipeline, DrawPipelines};
use super::slabs::Slabs;
use super::targets::{Canvas, TILE};
use super::view;

/// Most looks at what is done in a frame: each waits for the slices before it.
const MOST_LOOKS: u32 = 64;

/// Volumes that are sliced together.
pub struct Sliced<'a> {
    device: &'a Device,
    /// The volumes.
    pub volumes: PassVolumes<'a>,
    stage: &'a Stage,
    slicing: &'a Slicing,
    positions: Positions,
    geometry: Geometry,
    /// How slices are blended.
    pub blending: Blending,
    /// Whether in coarser numbers than asked for.
    pub is_coarse: bool,
    slices: DrawPipeline,
    done: DrawPipeline,
    tiles: Pipeline,
    occlusion: Pipeline,
    pixels: Pipeline,
}

/// Where slices are.
enum Positions {
    /// Through one volume.
    OfOne(Lattice),
    /// Through several.
    OfSeveral(Slabs),
}

/// A band of the picture, for one of the rays of its pixels: where it is, and what it is drawn with.
pub struct Layer {
    /// How many rows it has.
    pub rows: u32,
    /// What passes are told of it.
    pub passes: BoundsBuffer,
    numbers: Buffer,
    slices: BindGroup,
    done: BindGroup,
    tiles: BindGroup,
    occlusion: BindGroup,
}

impl<'a> Sliced<'a> {
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
        let Drawn { volume, resident, optics, .. } = &drawn[0];
        let grid = volume.volume.grid();
        let (positions, geometry) = if drawn.len() > 1 {
            let slabs = Slabs::new(stage, slicing);
            let geometry = Geometry::windows(device, slabs.counts, slicing, resident.bricks[0]);
            (Positions::OfSeveral(slabs), geometry)
        } else {
            let lattice = Lattice::new(stage, grid, slicing);
            let margin = view::margin(stage, grid, &lattice);
            let geometry = Geometry::new(device, (stage, grid), (slicing, &lattice), optics, &resident.bricks, margin)?;
            (Positions::OfOne(lattice), geometry)
        };
        let (blending, is_coarse) = Blending::new(device, optics.pass, slicing);
        let pixels = drawn.iter().map(|Drawn { optics, .. }| Variant {
            traversal: Traversal::SlicePixels,
            opaque: optics.opaque,
            knots: !optics.nodes.knots().is_empty(),
            layered: stage.has_layers(),
            ..Variant::of(optics.pass)
        });
        let pixels = pixels.collect();
        let bindings = |drawn: &Drawn<'a, '_>, lists| bindings(device, stage, drawn, drawing, &positions, lists);
        let volumes = PassVolumes::new(device, drawn, bindings);
        Ok(Self {
            device,
            is_coarse,
            slices: draws.slices(device, volumes.variants().collect(), geometry.pass, blending)?,
            done: draws.done(device)?,
            tiles: pipelines.get(device, Variant::of(Pass::SliceTiles))?.clone(),
            occlusion: pipelines.get(device, Variant::of(Pass::SliceOcclusion))?.clone(),
            pixels: pipelines.of_layers(device, pixels)?.clone(),
            volumes,
            stage,
            slicing,
            positions,
            geometry,
            blending,
        })
    }

    /// Whether some rays meet no slice.
    pub fn misses_rays(&self) -> bool {
        matches!(&self.positions, Positions::OfOne(lattice) if lattice.longest.is_infinite())
    }

    /// What a band is drawn with.
    pub fn layer(&self, canvas: &Canvas, [row, rows, sub]: [u32; 3]) -> Layer {
        let Self { volumes, geometry, stage, slicing, .. } = self;
        let PassVolume { volume, bindings, .. } = volumes.first();
        let pass = |(brick, _): &(Brick, Range<u32>)| {
            let texture_low = brick.voxels.low.map(|v| v as u32);
            RayBounds { rows: Rows::of([row, rows, sub]), texture_low, most_looks: u32::MAX, ..RayBounds::default() }
        };
        let passes = BoundsBuffer::new(self.device, geometry.shares.iter().map(pass));
        let pass = bindings.variant.pass;
        let numbers = match &self.positions {
            Positions::OfOne(lattice) => {
                let (grid, what) = (volume.volume.grid(), (*slicing, pass, geometry.slices));
                view::numbers(stage, grid, lattice, what, (&bindings.window, [row, rows, sub]))
            }
            Positions::OfSeveral(slabs) => slabs.numbers(stage, slicing, pass),
        };
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
        let group = |groups| volumes.frame_group(groups, &passes, &own);
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
    pub fn draw_layer(
        &mut self,
        canvas: &Canvas,
        layer: &Layer,
        timer: Option<&Timer>,
        pace: &mut Pace,
        control: &Control,
    ) -> Result<Option<f64>, GpuError> {
        let table = self.volumes.table_group(&self.slices.groups);
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
                let volume = self.volumes.volume_group(&self.slices.groups, brick, control)?;
                if self.volumes.are_complete() {
                    // Uploads are not what is measured.
                    self.device.wait()?;
                }
                let started = Instant::now();
                let mut encoder = encoder(self.device);
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
                if self.volumes.are_complete() {
                    self.device.wait()?;
                    pace.learn(started.elapsed());
                    busy = busy.zip(timer.and_then(|timer| timer.seconds(1))).map(|(busy, seconds)| busy + seconds);
                } else {
                    self.volumes.residents().for_each(|resident| resident.used(submission.clone()));
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
            let [columns, rows] = [self.volumes.first().bindings.window.size[0], layer.rows].map(|n| n.div_ceil(TILE));
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
                target(&canvas.colors, cleared(self.volumes.first().bindings.variant.pass)),
                target(&canvas.counts, Color::TRANSPARENT),
            ],
            depth_stencil_attachment: Some(depth(canvas, if clears { LoadOp::Clear(1.0) } else { LoadOp::Load })),
            timestamp_writes,
            ..Default::default()
        })
    }

    /// What was blended becomes a part of the pixels or, of one of several volumes that are sliced one after the other,
    /// the states of rays in that.
    pub fn add_to_pixels(
        &self,
        encoder: &mut CommandEncoder,
        canvas: &Canvas,
        targets: &Targets,
        layer: &Layer,
        number: usize,
    ) {
        let own = [
            ("states", targets.states_in(number)),
            ("pixels", targets.pixels.as_entire_binding()),
            ("slices", layer.numbers.as_entire_binding()),
            ("colors", BindingResource::TextureView(&canvas.colors)),
            ("taken", BindingResource::TextureView(&canvas.counts)),
        ];
        let frame = self.volumes.frame_group(&self.pixels.groups, &layer.passes, &own);
        let table = self.volumes.table_group(&self.pixels.groups);
        let size = [targets.width, layer.rows, 1];
        dispatch(encoder, &self.pixels.pipeline, [Some(&frame), None, Some(&table)], 0, size, None);
    }
}

/// What is bound to shaders that draw slices through a volume whose lists lie where `lists` says.
fn bindings<'a>(
    device: &'a Device,
    stage: &Stage,
    Drawn { volume, resident, optics, uploads }: &Drawn<'a, '_>,
    drawing: Drawing,
    positions: &Positions,
    lists: [u32; 4],
) -> Bindings<'a> {
    let alter = |frame: &mut uniforms::Frame| {
        if let Positions::OfOne(lattice) = positions {
            if !lattice.jitters() {
                frame.jitter[2] = 0;
            }
            frame.stack[0] = lattice.axis.unwrap_or(0) as u32;
        }
        frame.lists = lists;
    };
    let mut bindings =
        Bindings::new(device, resident, (stage, volume), (optics, uploads), drawing.interpolation, alter);
    bindings.variant = Variant {
        traversal: Traversal::Slices,
        stack: resident.plan.layout != Layout::Solid,
        bleeding: optics.bleeds,
        opaque: false,
        // Boxes of one volume leave out what is empty.
        skip: stage.has_layers() && optics.blocks.is_some(),
        ..bindings.variant
    }
    .canonical();
    bindings
}

/// What work for a device is written down in.
pub fn encoder(device: &Device) -> CommandEncoder {
    device.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("slices") })
}

fn depth<'c>(canvas: &'c Canvas, load: LoadOp<f32>) -> RenderPassDepthStencilAttachment<'c> {
    RenderPassDepthStencilAttachment {
        view: &canvas.done,
        depth_ops: Some(Operations { load, store: StoreOp::Store }),
        stencil_ops: None,
    }
}
