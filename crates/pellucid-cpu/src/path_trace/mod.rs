//! The path tracer: the equation of transfer by random paths, free of bias.
//!
//! A path starts at the eye and collides with the medium as light would (`medium`), between bounds of
//! the extinction for each block of the data (`majorants`). There it is scattered by the phase function
//! or reflected by a surface (`vertex`), and one light, or the sky, is asked for what comes from it
//! (`path`). Every path has random numbers of its own (`random`), and every pixel its paths in one
//! order: the picture is the same to the bit for any number of threads and any tiles.

mod extinction;
mod layer;
mod lens;
mod majorants;
mod medium;
mod path;
mod pixel;
mod random;
mod sights;
mod space;
mod surroundings;
mod values;
mod vertex;

use std::sync::Arc;

use glam::DVec3;
use pellucid_field::{ComponentView, Gradient, Sampler, Volume, Voxels, for_voxels};
use pellucid_optics::Sky;
use pellucid_plan::{MajorantGrid, PlanCache, Tables, merge_order};
use pellucid_scene::{Control, Jitter, PathTrace, Region, Stage, StageVolume};

use crate::RenderError;
use crate::field::{Moved, Probe};
use crate::tiles::Tile;
use extinction::Extinctions;
use layer::PathLayer;
use lens::Lens;
use medium::Medium;
use path::World;
use sights::Sights;
use space::Space;
use surroundings::{Alone, Surroundings, Together};
use values::{Perturbed, ScalarAny, ScalarTrilinear, Values};

/// A stage, made ready for its paths.
pub struct PathTracer<'s> {
    stage: &'s Stage,
    settings: &'s PathTrace,
    layers: Vec<PreparedLayer<'s>>,
    sky: Option<Sky>,
}

/// A volume, made ready for paths.
struct PreparedLayer<'s> {
    stage: &'s Stage,
    volume: &'s StageVolume,
    region: Region,
    tables: Arc<Tables>,
    /// What samples are made of, and which component of it.
    values: (Arc<Volume>, usize),
    majorants: Arc<MajorantGrid>,
}

/// Draws tiles.
pub trait Draw: Sync {
    /// Draws a tile.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    fn draw(&self, tile: &mut Tile, control: &Control) -> Result<(), RenderError>;
}

impl<'s> PathTracer<'s> {
    /// Makes tables and bounds, or finds them in the cache.
    ///
    /// # Errors
    /// [`RenderError::Optics`] if the data's range cannot be tabulated or the sky's picture was not read,
    /// [`RenderError::Field`] for a
    /// filter out of range.
    pub fn new(stage: &'s Stage, settings: &'s PathTrace, cache: &mut PlanCache) -> Result<Self, RenderError> {
        let layer = |number| {
            let volume = &stage.volumes[number];
            let tables = cache.tables(stage, number)?;
            let majorants = cache.majorants(stage, number, &tables, settings.majorants)?;
            let values = cache.values(stage, number, &tables)?;
            let region = stage.region(volume);
            Ok::<_, RenderError>(PreparedLayer { stage, volume, region, tables, values, majorants })
        };
        let layers = merge_order(stage).into_iter().map(layer).collect::<Result<_, _>>()?;
        Ok(Self { stage, settings, layers, sky: settings.environment.resolve()? })
    }

    /// What draws. A trilinear field of the types most data have is compiled into the loops if it is alone.
    ///
    /// # Errors
    /// [`RenderError::Field`] for a filter out of range.
    pub fn drawer(&self) -> Result<Box<dyn Draw + '_>, RenderError> {
        let [layer] = &*self.layers else {
            let layers = self.layers.iter().map(PreparedLayer::with_any).collect::<Result<_, _>>()?;
            return Ok(self.paths(Together(layers), None));
        };
        let (field, component) = &layer.values;
        if layer.tables.filter == pellucid_field::Filter::Linear && !layer.is_perturbed() {
            macro_rules! typed {
                ($data:expr) => {
                    if let Some(values) = ScalarTrilinear::new(ComponentView::new(field, $data, *component)) {
                        return Ok(self.alone(layer, values, layer.sampler()?));
                    }
                };
            }
            match field.voxels() {
                Voxels::U8(data) => typed!(data),
                Voxels::U16(data) => typed!(data),
                Voxels::I16(data) => typed!(data),
                Voxels::F32(data) => typed!(data),
                _ => {}
            }
        }
        Ok(match layer.is_perturbed() {
            true => self.alone(layer, layer.perturbed()?, layer.sampler()?),
            false => self.alone(layer, layer.any()?, layer.sampler()?),
        })
    }

    fn alone<'a, F: Values + 'a>(
        &'a self,
        layer: &'a PreparedLayer,
        field: F,
        sampler: Sampler<'a>,
    ) -> Box<dyn Draw + 'a> {
        let grid = layer.volume.volume.grid();
        let sights = Sights::new(&self.stage.viewpoint, grid, &layer.majorants, self.settings);
        self.paths(Alone(layer.with(field, sampler)), sights)
    }

    fn paths<'a, M: Surroundings + 'a>(&'a self, matter: M, sights: Option<Sights>) -> Box<dyn Draw + 'a> {
        let seed = match self.stage.quality.jitter {
            Jitter::Centered => 0,
            // Frames to be averaged differ by it.
            Jitter::BlueNoise { seed } => seed.wrapping_add(1),
        };
        Box::new(Paths {
            lens: Lens::new(&self.stage.viewpoint, self.settings),
            sights,
            width: self.stage.viewpoint.width,
            seeds: [self.settings.seed, seed],
            world: World { matter, lights: &self.stage.lights, sky: self.sky.as_ref(), settings: self.settings },
        })
    }
}

impl PreparedLayer<'_> {
    fn sampler(&self) -> Result<Sampler<'_>, RenderError> {
        let (field, component) = &self.values;
        Ok(Sampler::new(field, *component, self.tables.filter)?)
    }

    fn is_perturbed(&self) -> bool {
        self.tables.displacer.is_some() || self.tables.variation.is_some()
    }

    fn any(&self) -> Result<ScalarAny<'_>, RenderError> {
        let (low, high) = self.volume.volume.grid().index_bounds();
        Ok(ScalarAny { sampler: self.sampler()?, bounds: [low.as_vec3(), high.as_vec3()] })
    }

    fn perturbed(&self) -> Result<Perturbed<'_>, RenderError> {
        let (displacer, variation) = (self.tables.displacer.as_ref(), self.tables.variation.as_ref());
        Ok(Perturbed { field: self.any()?, displacer, variation })
    }

    /// The field of any type, behind a virtual call.
    fn boxed(&self) -> Result<Box<dyn Values + '_>, RenderError> {
        if self.is_perturbed() {
            return Ok(Box::new(self.perturbed()?));
        }
        let (field, component) = &self.values;
        if self.tables.filter == pellucid_field::Filter::Linear {
            let typed: Option<Box<dyn Values>> = for_voxels!(field.voxels(), data => {
                let values = ScalarTrilinear::new(ComponentView::new(field, data, *component));
                values.map(|values| Box::new(values) as Box<dyn Values>)
            });
            if let Some(values) = typed {
                return Ok(values);
            }
        }
        Ok(Box::new(self.any()?))
    }

    fn with_any(&self) -> Result<PathLayer<'_, Box<dyn Values + '_>>, RenderError> {
        Ok(self.with(self.boxed()?, self.sampler()?))
    }

    fn with<'a, F: Values + 'a>(&'a self, field: F, sampler: Sampler<'a>) -> PathLayer<'a, F> {
        let grid = self.volume.volume.grid();
        let gradient: Gradient = self.stage.quality.gradient;
        let displacer = self.tables.displacer.as_ref();
        let mut probe = Probe::new(Moved { sampler, displacer }, grid, &self.region, gradient);
        if let Some(displacer) = displacer {
            probe = probe.with_spacing(DVec3::from_array(displacer.spacing.map(f64::from)));
        }
        // Colours of several volumes are lost alike.
        let chroma = self.volume.scattering.extinction_factors().filter(|_| !self.stage.has_layers());
        PathLayer {
            medium: Medium {
                field,
                space: Space::new(grid, &self.region),
                extinctions: Extinctions::new(&self.tables.table, self.volume.unit_distance()),
                majorants: &self.majorants,
                chroma,
            },
            probe,
            table: &self.tables.table,
            scattering: &self.volume.scattering,
            material: self.volume.material.as_ref(),
        }
    }
}

/// The paths of a picture.
struct Paths<'a, M> {
    world: World<'a, M>,
    lens: Lens,
    /// If something is known of all rays of a pixel.
    sights: Option<Sights>,
    /// Of the picture.
    width: usize,
    seeds: [u32; 2],
}
