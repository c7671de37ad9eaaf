//! The path tracer: the equation of transfer by random paths, free of bias.
//!
//! A path starts at the eye and collides with the medium as light would (`medium`), between bounds of
//! the extinction for each block of the data (`majorants`). There it is scattered by the phase function
//! or reflected by a surface (`vertex`), and one light, or the sky, is asked for what comes from it
//! (`path`). Every path has random numbers of its own (`random`), and every pixel its paths in one
//! order: the picture is the same to the bit for any number of threads and any tiles.

mod extinction;
mod lens;
mod majorants;
mod medium;
mod path;
mod pixel;
mod random;
mod sights;
mod space;
mod values;
mod vertex;

use std::sync::Arc;

use glam::DVec3;
use pellucid_field::{ComponentView, Gradient, Sampler, Voxels};
use pellucid_optics::Sky;
use pellucid_plan::{MajorantGrid, PlanCache, Tables};
use pellucid_scene::{Control, Jitter, PathTrace, Region, Stage, StageVolume};

use crate::RenderError;
use crate::field::{Moved, Probe};
use crate::tiles::Tile;
use extinction::Extinctions;
use lens::Lens;
use medium::Medium;
use path::World;
use sights::Sights;
use space::Space;
use values::{Any, Perturbed, Trilinear, Values};

/// A stage, made ready for its paths.
pub struct PathTracer<'s> {
    stage: &'s Stage,
    volume: &'s StageVolume,
    settings: &'s PathTrace,
    region: Region,
    tables: Arc<Tables>,
    majorants: Arc<MajorantGrid>,
    sky: Option<Sky>,
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
    pub fn new(
        stage: &'s Stage,
        layer: usize,
        settings: &'s PathTrace,
        cache: &mut PlanCache,
    ) -> Result<Self, RenderError> {
        let volume = &stage.volumes[layer];
        let tables = cache.tables(stage, layer)?;
        let majorants = cache.majorants(stage, layer, &tables, settings.majorants)?;
        let sky = settings.environment.resolve()?;
        Ok(Self { stage, volume, settings, region: stage.region(volume), tables, majorants, sky })
    }

    /// What draws. Trilinear fields of the types most data have are compiled into the loops.
    ///
    /// # Errors
    /// [`RenderError::Field`] for a filter out of range.
    pub fn drawer(&self) -> Result<Box<dyn Draw + '_>, RenderError> {
        let Tables { field, component, filter, .. } = &*self.tables;
        let sampler = || Sampler::new(field, *component, *filter);
        let (displacer, variation) = (self.tables.displacer.as_ref(), self.tables.variation.as_ref());
        if displacer.is_some() || variation.is_some() {
            return Ok(self.paths(Perturbed { field: self.any(sampler()?), displacer, variation }, sampler()?));
        }
        if *filter == pellucid_field::Filter::Linear {
            macro_rules! typed {
                ($data:expr) => {
                    if let Some(values) = Trilinear::new(ComponentView::new(field, $data, *component)) {
                        return Ok(self.paths(values, sampler()?));
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
        Ok(self.paths(self.any(sampler()?), sampler()?))
    }

    fn any<'a>(&self, sampler: Sampler<'a>) -> Any<'a> {
        let (low, high) = self.volume.volume.grid().index_bounds();
        Any { sampler, bounds: [low.as_vec3(), high.as_vec3()] }
    }

    fn paths<'a, F: Values + 'a>(&'a self, field: F, sampler: Sampler<'a>) -> Box<dyn Draw + 'a> {
        let grid = self.volume.volume.grid();
        let seed = match self.stage.quality.jitter {
            Jitter::Centered => 0,
            // Frames to be averaged differ by it.
            Jitter::BlueNoise { seed } => seed.wrapping_add(1),
        };
        let gradient: Gradient = self.stage.quality.gradient;
        let displacer = self.tables.displacer.as_ref();
        let mut probe = Probe::new(Moved { sampler, displacer }, grid, &self.region, gradient);
        if let Some(displacer) = displacer {
            probe = probe.with_spacing(DVec3::from_array(displacer.spacing.map(f64::from)));
        }
        Box::new(Paths {
            lens: Lens::new(&self.stage.viewpoint, self.settings),
            sights: Sights::new(&self.stage.viewpoint, grid, &self.majorants, self.settings),
            width: self.stage.viewpoint.width,
            seeds: [self.settings.seed, seed],
            world: World {
                medium: Medium {
                    field,
                    space: Space::new(grid, &self.region),
                    extinctions: Extinctions::new(&self.tables.table, self.volume.unit_distance()),
                    majorants: &self.majorants,
                    chroma: self.volume.scattering.extinction_factors(),
                },
                probe,
                table: &self.tables.table,
                scattering: &self.volume.scattering,
                material: self.volume.material.as_ref(),
                lights: &self.stage.lights,
                sky: self.sky.as_ref(),
                settings: self.settings,
            },
        })
    }
}

/// The paths of a picture.
struct Paths<'a, F> {
    world: World<'a, F>,
    lens: Lens,
    /// If something is known of all rays of a pixel.
    sights: Option<Sights>,
    /// Of the picture.
    width: usize,
    seeds: [u32; 2],
}
