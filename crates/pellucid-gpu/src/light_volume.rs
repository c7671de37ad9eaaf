//! Light volumes (6.1-2, K-04): what is left of every light at the points of a grid, swept through the volume once, as
//! in the CPU backend, and kept while neither lights nor what holds them back change.

use std::sync::Arc;

use bytemuck::bytes_of;
use pellucid_optics::ResolvedLight;
use pellucid_plan::half_angle::{Geometry, LightError, LightPoints};
use pellucid_plan::{TableError, Tables};
use pellucid_scene::{Control, HalfAngle, Region, Stage, StageVolume};
use wgpu::{
    BindingResource, CommandEncoderDescriptor, Texture, TextureDescriptor, TextureDimension, TextureFormat,
    TextureUsages, TextureView,
};

use crate::bindings::Bindings;
use crate::bounds::{BoundsBuffer, LightBounds, PointBounds, Run};
use crate::drawing::Drawing;
use crate::groups::Named;
use crate::half_angle::{self, Layers, Sweep};
use crate::optics::Optics;
use crate::pipelines::{Pipeline, Pipelines};
use crate::resident::Resident;
use crate::shaders::{Pass, Variant};
use crate::texture::extent;
use crate::uploads::Uploads;
use crate::{Device, GpuError};

/// Slabs that light passes in a submission.
const RUN: u32 = 16;

/// The light of all lights in a volume, one behind the other in a texture.
pub struct LightVolumes {
    of: Settings,
    /// Points across the last axis, of one light.
    pub depth: usize,
    /// The points.
    pub points: TextureView,
}

/// What they depend on.
#[derive(PartialEq)]
struct Settings {
    lights: Vec<ResolvedLight>,
    region: Region,
    resolution: f64,
    drawing: Drawing,
    tables: Same,
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
pub fn bytes(device: &Device, stage: &Stage, volume: &StageVolume) -> Result<u64, GpuError> {
    let Some(points) = LightPoints::of(stage, volume, side(device)).map_err(TableError::from)? else { return Ok(0) };
    let side = points.texels + 1;
    Ok(4 * (points.grid.len() * stage.lights.len()) as u64 + Layers::bytes([side; 2], RUN + 1))
}

impl LightVolumes {
    /// Those that are there, if they are of this stage, or new ones; `None` if it asks for none.
    ///
    /// # Errors
    /// As [`LightVolumes::new`].
    pub fn kept<'l>(
        slot: &'l mut Option<Self>,
        device: &Device,
        pipelines: &mut Pipelines,
        resident: &mut Resident,
        (stage, volume, tables): (&Stage, &StageVolume, &Arc<Tables>),
        drawing: Drawing,
        control: &Control,
    ) -> Result<Option<&'l Self>, GpuError> {
        let Some(resolution) = stage.light_resolution(volume) else {
            *slot = None;
            return Ok(None);
        };
        let (lights, region) = (stage.lights.clone(), stage.region(volume));
        let of = Settings { lights, region, resolution, drawing, tables: Same(tables.clone()) };
        // The old ones go first.
        slot.take_if(|kept| kept.of != of);
        if slot.is_none() {
            *slot = Some(Self::new(device, pipelines, resident, (stage, volume), of, control)?);
        }
        Ok(slot.as_ref())
    }

    /// Sweeps all lights through the volume.
    ///
    /// # Errors
    /// [`GpuError::Light`] if one stands in the volume, [`GpuError::Budget`] if a texture has not so many points,
    /// [`GpuError::Cancelled`], or what the device reports.
    fn new(
        device: &Device,
        pipelines: &mut Pipelines,
        resident: &mut Resident,
        (stage, volume): (&Stage, &StageVolume),
        of: Settings,
        control: &Control,
    ) -> Result<Self, GpuError> {
        // Through several volumes, rays are cast.
        let optics = Optics::of_light(stage, 0, &of.tables.0);
        let uploads = Uploads::new(device, &of.tables.0, &optics, None);
        let LightPoints { grid: points, texels, .. } =
            LightPoints::new(volume.volume.grid(), of.resolution, of.lights.len(), side(device))
                .map_err(TableError::from)?;
        let texture = create(device, points.dims(), of.lights.len())?;
        let view = texture.create_view(&Default::default());
        let interpolation = half_angle::interpolation(device, of.drawing);
        let bindings = Bindings::new(device, resident, (stage, volume), (&optics, &uploads), interpolation, |_| ());
        let variant = |pass| Variant { pass, skip: optics.blocks.is_some(), ..bindings.variant };
        let [advance, fill] =
            [Pass::HalfAngleLight, Pass::LightPoints].map(|pass| pipelines.get(device, variant(pass)).cloned());
        let (advance, fill) = (advance?, fill?);
        let brick = resident.bricks[0];
        let textures = resident.textures(device, &brick, control)?;
        let sweeper =
            Sweeper { device, textures, bindings, advance, fill, points: &view, dims: points.dims().map(|n| n as u32) };
        let direct = HalfAngle { indirect: 0.0, ..HalfAngle::default() };
        for (number, light) in of.lights.iter().enumerate() {
            let geometry = Geometry::of_light(stage.step, volume.volume.grid(), light, texels)
                .ok_or(LightError::Inside { light: number })?;
            sweeper.sweep((stage, volume, &direct), &geometry, (number, light), control)?;
        }
        Ok(Self { of, depth: points.dims()[2], points: view })
    }
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
    bindings: Bindings<'a>,
    textures: [TextureView; 2],
    advance: Pipeline,
    fill: Pipeline,
    points: &'a TextureView,
    dims: [u32; 3],
}

impl Sweeper<'_> {
    fn sweep(
        &self,
        (stage, volume, settings): (&Stage, &StageVolume, &HalfAngle),
        geometry: &Geometry,
        (number, light): (usize, &ResolvedLight),
        control: &Control,
    ) -> Result<(), GpuError> {
        let size = geometry.frame.size.map(|n| n as u32);
        // Nothing becomes indirect light.
        let settings = (settings, [0.0; 3]);
        let numbers = Sweep::new((stage, volume), settings, geometry, (light, 1), Layers::sides(size));
        let numbers = self.device.constant_buffer("sweep", bytes_of(&numbers));
        let slabs = geometry.slabs.count as u32;
        let (run, runs) = (RUN.min(slabs), slabs.div_ceil(RUN));
        let count = run + 1;
        let mut slot = None;
        let layers = Layers::kept(&mut slot, self.device, size, count);
        let pass = |slab| LightBounds { high: size, ..LightBounds::of(slab) };
        let passes = BoundsBuffer::new(self.device, (0..slabs).map(pass));
        let filled = |run: u32| PointBounds {
            run: Run::of([run * RUN, slabs.min((run + 1) * RUN)], count),
            size: self.dims,
            first: number as u32 * self.dims[2],
        };
        let fills = BoundsBuffer::new(self.device, (0..runs).map(filled));
        let numbers = ("sweep", numbers.as_entire_binding());
        let texture = |name, view| (name, BindingResource::TextureView(view));
        let bound = |pipeline, bounds, own: &[Named]| self.bindings.bound(pipeline, bounds, own, &self.textures);
        let advance = |layer: u32| {
            let [before, _] = &layers.each[layer as usize];
            let [_, behind] = &layers.each[((layer + 1) % count) as usize];
            let own = [numbers.clone(), texture("lost", before), texture("next", behind)];
            bound(&self.advance, &passes, &own)
        };
        let advance: Vec<_> = (0..count).map(advance).collect();
        let own = [numbers.clone(), texture("lost", &layers.all), texture("points", self.points)];
        let fill = bound(&self.fill, &fills, &own);
        for run in 0..runs {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            let descriptor = CommandEncoderDescriptor { label: Some("light volume") };
            let mut encoder = self.device.device.create_command_encoder(&descriptor);
            if run == 0 {
                layers.clear(&mut encoder);
            }
            for slab in run * RUN..slabs.min((run + 1) * RUN) {
                let texels = [size[0], size[1], 1];
                advance[(slab % count) as usize].dispatch(&mut encoder, passes.offset(slab as usize), texels, None);
            }
            fill.dispatch(&mut encoder, fills.offset(run as usize), self.dims, None);
            self.device.queue.submit([encoder.finish()]);
            self.device.wait()?;
        }
        Ok(())
    }
}
