//! The light at the points of a grid, swept through all volumes once (6.1-2, K-04).

use glam::DVec3;
use pellucid_field::{ComponentView, Gradient, Grid, Linear, Volume, Voxels};
use pellucid_optics::ResolvedLight;
use pellucid_plan::half_angle::{Geometry, LightError, LightPoints, around};
use pellucid_scene::{Control, HalfAngle, Region};
use rayon::prelude::*;

use super::{Shadow, Turn};
use crate::RenderError;
use crate::field::{Any, Bounds, Field, Probe, Trilinear};
use crate::half_angle::{Lengths, Matter, Seen, Sweep};
use crate::lanes::*;
use crate::prepare::Prepared;

/// What is left of a light in the box around all volumes.
pub struct LightVolume {
    volume: Volume,
    /// All of it is there.
    region: Region,
}

impl LightVolume {
    /// Sweeps a light through the volumes of a stage, in the order in which they are merged, with `resolution` points for
    /// each voxel and axis.
    ///
    /// # Errors
    /// [`RenderError::Light`] if it stands among the volumes, [`RenderError::Cancelled`].
    pub fn new(
        layers: &[Prepared],
        (number, light): (usize, &ResolvedLight),
        resolution: f64,
        set: InstructionSet,
        control: &Control,
    ) -> Result<Self, RenderError> {
        let stage = layers[0].stage;
        let grid = around(stage)?;
        let LightPoints { grid: points, texels, .. } =
            LightPoints::new(&grid, resolution, stage.lights.len(), usize::MAX)?;
        let geometry =
            Geometry::of_light(stage.step, &grid, light, texels).ok_or(LightError::Inside { light: number })?;
        let direct = HalfAngle { indirect: 0.0, ..HalfAngle::default() };
        let values = dispatch!(set, s => sweep(s, layers, &geometry, &direct, &points, control))?;
        Ok(Self { volume: Volume::new(points, Voxels::from(values))?, region: Region::default() })
    }

    fn field(&self) -> Option<Trilinear<'_, f32>> {
        let Voxels::F32(data) = self.volume.voxels() else { return None };
        let view = ComponentView::new(&self.volume, data, 0);
        let probe = Probe::new(Linear(view), self.volume.grid(), &self.region, Gradient::Central);
        Trilinear::new(view, false, Bounds::new(self.volume.grid(), &self.region), probe)
    }
}

/// The light at points, x fastest.
fn sweep<S: Lanes>(
    s: S,
    layers: &[Prepared],
    geometry: &Geometry,
    settings: &HalfAngle,
    points: &Grid,
    control: &Control,
) -> Result<Vec<f32>, RenderError> {
    let Geometry { frame, slabs, ways, .. } = geometry;
    let cancelled = || control.is_cancelled();
    let lengths = layers.iter().map(|layer| Lengths::new(layer, *ways)).collect::<Result<Vec<_>, _>>()?;
    let samplers = layers.iter().map(Prepared::sampler).collect::<Result<Vec<_>, _>>()?;
    let fields: Vec<Any<S>> = layers.iter().zip(samplers).map(|(layer, sampler)| layer.any(sampler)).collect();
    let each = layers.iter().zip(&lengths).zip(&fields);
    let matter = each.map(|((layer, lengths), field)| Matter::new(s, layer, lengths, field, settings)).collect();
    let mut light = Sweep::new(layers, settings, geometry, matter, Seen::Everywhere, cancelled)?;
    let [nx, ny, _] = points.dims();
    let world = points.world_from_index();
    let mut values = vec![1.0f32; points.len()];
    // Coordinates of slabs change by as much from point to point along a row.
    let along = slabs.axis.dot(world.matrix3.x_axis) / slabs.thickness;
    for start in (0..slabs.count).step_by(light.run_length()) {
        let run = start..slabs.count.min(start + light.run_length());
        light.pass(run.clone(), cancelled)?;
        let buffers = light.buffers();
        values.par_chunks_mut(nx).enumerate().for_each(|(row, values)| {
            let at = |x: usize| world.transform_point3(DVec3::new(x as f64, (row % ny) as f64, (row / ny) as f64));
            let first = slabs.coordinate(at(0));
            // The points of the row that may lie in the run, and a little more, as the last coordinate is the
            // end of the last slab; the whole row where it lies across the light, or all but.
            let [a, b] = [run.start as f64, run.end as f64].map(|end| (end - first) / along);
            let is_across = along.abs() * (nx as f64) < 1e-6;
            let (from, to) = if is_across { (0.0, nx as f64) } else { (a.min(b) - 2.0, a.max(b) + 2.0) };
            for x in from.clamp(0.0, nx as f64) as usize..to.clamp(0.0, nx as f64) as usize {
                let place = (first + along * x as f64).clamp(0.0, slabs.count as f64 - 1e-6);
                let slab = place as usize;
                if run.contains(&slab) {
                    let texel = frame.project(at(x));
                    let [near, far] = [0, 1].map(|next| buffers[slab - start + next].read(0, texel));
                    values[x] = near + (far - near) * (place - slab as f64) as f32;
                }
            }
        });
    }
    Ok(values)
}

/// Light volumes of all lights, as samples of one of the volumes find them.
pub struct LightVolumes<'a> {
    lights: Vec<(Trilinear<'a, f32>, Turn)>,
}

impl<'a> LightVolumes<'a> {
    /// In the order of the lights, for samples at index positions of a grid.
    pub fn new(volumes: &'a [LightVolume], grid: &Grid) -> Self {
        let light = |light: &'a LightVolume| {
            let points = light.volume.grid();
            Some((light.field()?, Turn::new(points.index_from_world() * grid.world_from_index())))
        };
        Self { lights: volumes.iter().filter_map(light).collect() }
    }
}

impl<S: Lanes> Shadow<S> for LightVolumes<'_> {
    fn transmittance(&self, s: S, light: usize, index: &Vec3<S>, lanes: Mask<S>) -> F32<S> {
        s.vectorize(
            #[inline(always)]
            || {
                let (field, turn) = &self.lights[light];
                field.values(s, turn.of(s, index), lanes)
            },
        )
    }
}
