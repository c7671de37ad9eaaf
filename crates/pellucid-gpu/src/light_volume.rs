//! Light volumes (6.1-2, K-04): what is left of every light at the points of a grid, swept through all volumes once, as
//! in the CPU backend, and kept while neither lights nor what holds them back change.

use std::sync::Arc;

use bytemuck::bytes_of;
use glam::DAffine3;
use pellucid_field::Grid;
use pellucid_optics::ResolvedLight;
use pellucid_plan::half_angle::{Geometry, LightError, LightPoints, around};
use pellucid_plan::{TableError, Tables, merge_order};
use pellucid_scene::{Control, HalfAngle, Overlap, Region, Stage};
use wgpu::{
    BindingResource, CommandEncoderDescriptor, Texture, TextureDescriptor, TextureDimension, TextureFormat,
    TextureUsages, TextureView,
};

use crate::bindings::Bindings;
use crate::bounds::{BoundsBuffer, LightBounds, PointBounds, Run};
use crate::dispatch::Bound;
use crate::drawing::Drawing;
use crate::groups::Named;
use crate::half_angle::{self, Layers, Sweep};
use crate::on_device::Drawn;
use crate::optics::Optics;
use crate::pass_volumes::{PassVolume, PassVolumes};
use crate::pipelines::{Pipeline, Pipelines};
use crate::shaders::{Pass, Variant};
use crate::texture::extent;
use crate::uniforms::{Frame, four};
use crate::uploads::Uploads;
use crate::{Device, GpuError};

/// Slabs that light passes in a submission.
const RUN: u32 = 16;

/// The light of all lights in the box around all volumes, one behind the other in a texture.
pub struct LightVolumes {
    of: Settings,
    /// From positions of the world to parts of the box.
    pub part_from_world: DAffine3,
    /// Points across the last axis, of one light.
    pub depth: usize,
    /// The points.
    pub points: TextureView,
}

/// What they depend on.
#[derive(PartialEq)]
struct Settings {
    volumes: Vec<(Same, Region)>,
    overlap: Overlap,
    lights: Vec<ResolvedLight>,
    resolution: f64,
    drawing: Drawing,
}

/// Tables that are the same if they are at the same place.
struct Same(Arc<Tables>);

impl PartialEq for Same {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Most points along an axis, those of all lights along the last.
pub fn side(device: &Device) -> usize {
    device.capabilities.limits.max_texture_dimension_3d as usize
}

/// The most bytes that making and keeping the light volumes of a stage takes; 0 if it asks for none.
///
/// # Errors
/// [`GpuError::Tables`] if there are too many points.
pub fn bytes(device: &Device, stage: &Stage) -> Result<u64, GpuError> {
    let Some(points) = LightPoints::of(stage, side(device)).map_err(TableError::from)? else { return Ok(0) };
    let side = points.texels + 1;
    Ok(4 * (points.grid.len() * stage.lights.len()) as u64 + Layers::bytes([side; 2], RUN + 1))
}

impl LightVolumes {
    /// Those that are there, if they are of this stage, or new ones; `None` if it asks for none. Volumes and their tables
    /// come in the order in which they are merged.
    ///
    /// # Errors
    /// As [`LightVolumes::new`].
    pub fn kept<'l>(
        slot: &'l mut Option<Self>,
        device: &Device,
        pipelines: &mut Pipelines,
        stage: &Stage,
        (drawn, tables): (&mut [Drawn], &[Arc<Tables>]),
        drawing: Drawing,
        control: &Control,
    ) -> Result<Option<&'l Self>, GpuError> {
        let Some(resolution) = stage.light_resolution() else {
            *slot = None;
            return Ok(None);
        };
        let volume = |(drawn, tables): (&Drawn, &Arc<Tables>)| (Same(tables.clone()), stage.region(drawn.volume));
        let volumes = drawn.iter().zip(tables).map(volume).collect();
        let of = Settings { volumes, overlap: stage.overlap, lights: stage.lights.clone(), resolution, drawing };
        // The old ones go first.
        slot.take_if(|kept| kept.of != of);
        if slot.is_none() {
            *slot = Some(Self::new(device, pipelines, stage, (drawn, tables), of, control)?);
        }
        Ok(slot.as_ref())
    }

    /// Sweeps all lights through the volumes.
    ///
    /// # Errors
    /// [`GpuError::Light`] if one stands among the volumes, [`GpuError::Budget`] if a texture has not so many points,
    /// [`GpuError::Volumes`] if a pass cannot be given as many volumes, [`GpuError::Cancelled`], or what the device
    /// reports.
    fn new(
        device: &Device,
        pipelines: &mut Pipelines,
        stage: &Stage,
        (drawn, tables): (&mut [Drawn], &[Arc<Tables>]),
        of: Settings,
        control: &Control,
    ) -> Result<Self, GpuError> {
        let numbers = merge_order(stage).into_iter();
        let optics: Vec<_> =
            numbers.zip(tables).map(|(number, tables)| Optics::of_light(stage, number, tables)).collect();
        let uploads = tables.iter().zip(&optics).map(|(tables, optics)| Uploads::new(device, tables, optics, None));
        let uploads: Vec<_> = uploads.collect();
        let met = drawn.iter_mut().zip(&optics).zip(&uploads).map(|((drawn, optics), uploads)| Drawn {
            volume: drawn.volume,
            resident: &mut *drawn.resident,
            optics,
            uploads,
        });
        let interpolation = half_angle::interpolation(device, of.drawing);
        let volumes = PassVolumes::new(device, met.collect(), |Drawn { volume, resident, optics, uploads }, lists| {
            let (what, alter) = ((stage, *volume), |frame: &mut Frame| frame.lists = lists);
            let mut bindings = Bindings::new(device, resident, what, (optics, uploads), interpolation, alter);
            bindings.variant.skip = optics.blocks.is_some();
            bindings
        });
        let grid = around(stage).map_err(TableError::from)?;
        let LightPoints { grid: points, texels, .. } =
            LightPoints::new(&grid, of.resolution, of.lights.len(), side(device)).map_err(TableError::from)?;
        let texture = create(device, points.dims(), of.lights.len())?;
        let view = texture.create_view(&Default::default());
        let variant = |of| Variant { pass: Pass::HalfAngleLight, ..of };
        let advance = pipelines.of_layers(device, volumes.variants().map(variant).collect())?.clone();
        let fill = pipelines.get(device, Variant::of(Pass::LightPoints))?.clone();
        let dims = points.dims().map(|n| n as u32);
        let mut sweeper = Sweeper { device, stage, volumes, advance, fill, points: &view, dims };
        for (number, light) in of.lights.iter().enumerate() {
            let geometry =
                Geometry::of_light(stage.step, &grid, light, texels).ok_or(LightError::Inside { light: number })?;
            sweeper.sweep(&geometry, (number, light), control)?;
        }
        Ok(Self { of, part_from_world: part_from_world(&grid), depth: points.dims()[2], points: view })
    }
}

/// From positions of the world to parts of a grid's box.
fn part_from_world(grid: &Grid) -> DAffine3 {
    let (low, high) = grid.index_bounds();
    let part_from_index = DAffine3::from_scale((high - low).recip()) * DAffine3::from_translation(-low);
    part_from_index * grid.index_from_world()
}

/// A texture of points, one light behind the other.
fn create(device: &Device, [width, height, depth]: [usize; 3], lights: usize) -> Result<Texture, GpuError> {
    let dims = [width, height, depth * lights];
    let most = side(device);
    if dims.into_iter().any(|points| points > most) {
        let what = format!("the light volume with {width} x {height} x {depth} points for each of {lights} lights");
        let (needed, budget) = (4 * dims.into_iter().max().unwrap_or(0) as u64, 4 * most as u64);
        let advice = "use fewer lights, or lower lighting.shadows.volume.resolution";
        return Err(GpuError::Budget { what, needed, budget, advice });
    }
    Ok(device.device.create_texture(&TextureDescriptor {
        label: Some("light volume"),
        size: extent(dims),
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D3,
        format: TextureFormat::R32Float,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    }))
}

/// What lights are swept with.
struct Sweeper<'a> {
    device: &'a Device,
    stage: &'a Stage,
    volumes: PassVolumes<'a>,
    advance: Pipeline,
    fill: Pipeline,
    points: &'a TextureView,
    dims: [u32; 3],
}

impl Sweeper<'_> {
    fn sweep(
        &mut self,
        geometry: &Geometry,
        (number, light): (usize, &ResolvedLight),
        control: &Control,
    ) -> Result<(), GpuError> {
        let (device, size) = (self.device, geometry.frame.size.map(|n| n as u32));
        let direct = HalfAngle { indirect: 0.0, ..HalfAngle::default() };
        // Nothing becomes indirect light.
        let settings = (&direct, [0.0; 3]);
        let numbers = |grid: &Grid| {
            let sweep = Sweep::new((self.stage, grid), settings, geometry, (light, 1), Layers::sides(size));
            device.constant_buffer("sweep", bytes_of(&sweep))
        };
        let each = |volume: &PassVolume| numbers(volume.volume.volume.grid());
        let (each, around): (Vec<_>, _) = (self.volumes.each().iter().map(each).collect(), numbers(&geometry.grid));
        let each: Vec<Named> = each.iter().map(|numbers| ("sweep", numbers.as_entire_binding())).collect();
        let around = [("sweep", around.as_entire_binding())];
        let slabs = geometry.slabs.count as u32;
        let (run, runs) = (RUN.min(slabs), slabs.div_ceil(RUN));
        let count = run + 1;
        let mut slot = None;
        let layers = Layers::kept(&mut slot, device, size, count);
        let pass = |slab| LightBounds { high: size, ..LightBounds::of(slab) };
        let passes = BoundsBuffer::new(device, (0..slabs).map(pass));
        let (low, high) = geometry.grid.index_bounds();
        let filled = |run: u32| PointBounds {
            low: four(low, 0.0),
            high: four(high, 0.0),
            run: Run::of([run * RUN, slabs.min((run + 1) * RUN)], count),
            size: self.dims,
            first: number as u32 * self.dims[2],
        };
        let fills = BoundsBuffer::new(device, (0..runs).map(filled));
        let texture = |name, view| (name, BindingResource::TextureView(view));
        let advance = |layer: u32| {
            let [before, _] = &layers.each[layer as usize];
            let [_, behind] = &layers.each[((layer + 1) % count) as usize];
            let own = [texture("lost", before), texture("next", behind)];
            self.volumes.bound(&self.advance, &passes, (&own, &each), control)
        };
        let advance = (0..count).map(advance).collect::<Result<Vec<Bound>, _>>()?;
        let own = [texture("lost", &layers.all), texture("points", self.points)];
        let fill = self.volumes.bound(&self.fill, &fills, (&own, &around), control)?;
        for run in 0..runs {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            let descriptor = CommandEncoderDescriptor { label: Some("light volume") };
            let mut encoder = device.device.create_command_encoder(&descriptor);
            if run == 0 {
                layers.clear(&mut encoder);
            }
            for slab in run * RUN..slabs.min((run + 1) * RUN) {
                let texels = [size[0], size[1], 1];
                advance[(slab % count) as usize].dispatch(&mut encoder, passes.offset(slab as usize), texels, None);
            }
            fill.dispatch(&mut encoder, fills.offset(run as usize), self.dims, None);
            device.queue.submit([encoder.finish()]);
            device.wait()?;
        }
        Ok(())
    }
}
