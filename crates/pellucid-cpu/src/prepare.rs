//! What a frame needs before its first ray: tables for this step, blocks, and the integrator of
//! the mode.

use std::sync::Arc;

use glam::DVec3;
use pellucid_field::{Blocks, FieldError, Filter, Grid, Reconstruct, Sampler, Volume, spline_coefficients};
use pellucid_optics::{DataRange, PreIntegration, StepTable, Table, Visibility};
use pellucid_scene::{Classification, Combine, Mode, RayCast, Region, Slice, Stage, StageVolume, Technique};

use crate::RenderError;
use crate::composite::{Composite, Medium, PreIntegrated};
use crate::integrator::Integrator;
use crate::isosurface::{Isosurfaces, Level};
use crate::medium::{Post, Pre};
use crate::probe::Probe;
use crate::projection::{Additive, Average, Extreme, XRay};
use crate::skip::{BlockMap, SkipGrid};
use crate::slice::Plane;
use crate::surface::Surface;

/// What depends on the data alone and is kept from frame to frame.
#[derive(Default)]
pub struct Cache {
    blocks: Option<(Arc<Volume>, usize, usize, Arc<Blocks>)>,
    coefficients: Option<(Arc<Volume>, usize, Arc<Volume>)>,
}

impl Cache {
    fn blocks(&mut self, volume: &Arc<Volume>, component: usize, reach: usize) -> Result<Arc<Blocks>, FieldError> {
        match &self.blocks {
            Some((v, c, r, blocks)) if Arc::ptr_eq(v, volume) && *c == component && *r == reach => Ok(blocks.clone()),
            _ => {
                let blocks = Arc::new(Blocks::new(volume, component, Blocks::CELLS, reach)?);
                self.blocks = Some((volume.clone(), component, reach, blocks.clone()));
                Ok(blocks)
            }
        }
    }

    fn coefficients(&mut self, volume: &Arc<Volume>, component: usize) -> Result<Arc<Volume>, FieldError> {
        match &self.coefficients {
            Some((v, c, made)) if Arc::ptr_eq(v, volume) && *c == component => Ok(made.clone()),
            _ => {
                let made = Arc::new(spline_coefficients(volume, component)?);
                self.coefficients = Some((volume.clone(), component, made.clone()));
                Ok(made)
            }
        }
    }
}

/// A volume and its optics, made ready for one stage.
pub struct Prepared<'s> {
    stage: &'s Stage,
    volume: &'s StageVolume,
    /// What the reconstruction reads: the volume, or its filter coefficients.
    field: Arc<Volume>,
    component: usize,
    filter: Filter,
    /// Where the field is neither clipped nor outside a slab.
    pub region: Region,
    blocks: Option<Arc<Blocks>>,
    table: Table,
    step_table: StepTable,
    visibility: Visibility,
    preintegration: Option<PreIntegration>,
}

impl<'s> Prepared<'s> {
    /// Makes tables and blocks.
    ///
    /// # Errors
    /// [`RenderError::Optics`] if the data's range cannot be tabulated.
    pub fn new(stage: &'s Stage, volume: &'s StageVolume, cache: &mut Cache) -> Result<Self, RenderError> {
        let (field, component, filter) = match stage.quality.filter {
            Filter::BSpline { prefilter: true } => {
                let coefficients = cache.coefficients(&volume.volume, volume.component)?;
                (coefficients, 0, Filter::BSpline { prefilter: false })
            }
            filter => (volume.volume.clone(), volume.component, filter),
        };
        let tf = &volume.transfer_function;
        let range = DataRange::of(&volume.volume);
        let ratio = stage.step / volume.unit_distance();
        let table = Table::for_data(tf, &range)?;
        let composited = matches!(mode(stage), Mode::Composite);
        let preintegration = (composited && stage.quality.classification == Classification::PreIntegrated)
            .then(|| PreIntegration::for_data(tf, &range, ratio))
            .transpose()?;
        let visibility = match &preintegration {
            Some(segments) => Visibility::of_segments(tf, segments.nodes()),
            None => Visibility::of_table(&table),
        };
        // Min-max blocks bound a sample only if no weight is negative.
        let bounded = field_is_bounded(stage.quality.filter, stage.quality.classification, composited);
        let blocks = (stage.quality.empty_space_skipping && bounded)
            .then(|| cache.blocks(&volume.volume, volume.component, filter.half_width() - 1))
            .transpose()?;
        Ok(Self {
            region: region(stage, volume),
            step_table: StepTable::new(&table, ratio as f32)?,
            stage,
            volume,
            field,
            component,
            filter,
            blocks,
            table,
            visibility,
            preintegration,
        })
    }

    /// The reconstruction of the field.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn sampler(&self) -> Result<Sampler<'_>, RenderError> {
        Ok(Sampler::new(&self.field, self.component, self.filter)?)
    }

    /// The grid all positions refer to.
    pub fn grid(&self) -> &Grid {
        self.volume.volume.grid()
    }

    /// The integrator of the stage's mode over a reconstruction of `field`.
    pub fn integrator<'a, R: Reconstruct + 'a>(&'a self, field: R) -> Box<dyn Integrator + 'a> {
        let quality = &self.stage.quality;
        let probe = Probe::new(field, self.grid(), &self.region, quality.gradient);
        let early_termination = quality.early_termination;
        match mode(self.stage) {
            Mode::Composite => {
                let skip = self.skip(|low, high| self.visibility.any_opacity(low, high));
                let medium = Medium { probe, surface: self.surface(), skip, early_termination };
                let table = &self.step_table;
                match (quality.classification, &self.preintegration) {
                    (Classification::PreIntegrated, Some(table)) => Box::new(PreIntegrated { medium, table }),
                    (Classification::Pre, _) => {
                        let (volume, component) = (&*self.volume.volume, self.volume.component);
                        let classifier = Pre { table, volume, component, filter: quality.filter };
                        Box::new(Composite { medium, classifier })
                    }
                    _ => Box::new(Composite { medium, classifier: Post { table } }),
                }
            }
            Mode::Maximum => self.extreme(probe, false, false),
            Mode::Minimum => self.extreme(probe, true, false),
            Mode::Average => Box::new(Average { probe, table: &self.table, opaque: false }),
            Mode::Additive => {
                let skip = self.skip(|low, high| self.visibility.any_opacity(low, high));
                let step_ratio = self.stage.step / self.volume.unit_distance();
                Box::new(Additive { probe, table: &self.table, step_ratio, skip })
            }
            Mode::XRay => {
                let skip = self.skip(|low, high| self.visibility.any_opacity(low, high));
                Box::new(XRay { probe, table: &self.step_table, skip })
            }
            Mode::Isosurface(isosurface) => {
                let tf = &self.volume.transfer_function;
                let levels: Vec<Level> = isosurface.isovalues.iter().map(|iso| Level::new(iso, tf)).collect();
                let skip = self.skip(|low, high| {
                    levels.iter().any(|level| f64::from(low) <= level.value && level.value <= f64::from(high))
                });
                Box::new(Isosurfaces { probe, surface: self.surface(), levels, skip, early_termination })
            }
            Mode::Slice(slice) if slice.thickness == 0.0 => {
                let (point, normal) = plane(self.stage, self.volume, slice);
                Box::new(Plane { probe, table: &self.table, point, normal })
            }
            Mode::Slice(slice) => match slice.combine {
                Combine::Maximum => self.extreme(probe, false, true),
                Combine::Minimum => self.extreme(probe, true, true),
                Combine::Average => Box::new(Average { probe, table: &self.table, opaque: true }),
            },
        }
    }

    fn extreme<'a, R: Reconstruct + 'a>(
        &'a self,
        probe: Probe<'a, R>,
        minimum: bool,
        opaque: bool,
    ) -> Box<dyn Integrator + 'a> {
        let skip = self.blocks.as_deref().map(BlockMap::new);
        Box::new(Extreme { probe, table: &self.table, skip, minimum, opaque })
    }

    fn surface(&self) -> Option<Surface<'_>> {
        let material = self.volume.material.as_ref()?;
        let weight = self.volume.gradient_weight;
        Some(Surface { material, weight, lights: &self.stage.lights, ambient: self.stage.ambient })
    }

    fn skip(&self, live: impl Fn(f32, f32) -> bool) -> Option<SkipGrid<'_>> {
        self.blocks.as_deref().map(|blocks| SkipGrid::new(blocks, live))
    }
}

fn mode(stage: &Stage) -> &Mode {
    let Technique::RayCast(RayCast { mode }) = &stage.technique;
    mode
}

/// Whether every classified value lies within the range of the voxels around it. Pre-classified
/// samples blend colours of voxels, which are zero wherever the voxels' are, whatever the weights.
fn field_is_bounded(filter: Filter, classification: Classification, composited: bool) -> bool {
    filter.is_positive() || (composited && classification == Classification::Pre)
}

/// The clips of a volume and, for a thick slice, the planes of its slab.
fn region(stage: &Stage, volume: &StageVolume) -> Region {
    let mut region = volume.region.clone();
    if let Mode::Slice(slice) = mode(stage)
        && slice.thickness > 0.0
    {
        let (point, normal) = plane(stage, volume, slice);
        let half = normal * (slice.thickness / 2.0);
        region.keep(normal, point - half);
        region.keep(-normal, point + half);
    }
    region
}

/// A slice's point and unit normal, with their automatic values filled in.
fn plane(stage: &Stage, volume: &StageVolume, slice: &Slice) -> (DVec3, DVec3) {
    let point = slice.point.map_or_else(|| volume.volume.grid().center(), DVec3::from_array);
    let normal = slice.normal.map_or(-stage.viewpoint.forward, DVec3::from_array);
    (point, normal.normalize())
}
