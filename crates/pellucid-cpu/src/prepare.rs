//! What a frame needs before its first ray: tables for this step, and blocks.

use std::sync::Arc;

use glam::DVec3;
use pellucid_field::{Blocks, FieldError, Filter, Grid, Volume, spline_coefficients};
use pellucid_optics::{DataRange, PreIntegration, StepTable, Table, Visibility};
use pellucid_scene::{Classification, Mode, RayCast, Region, Slice, Stage, StageVolume, Technique};

use crate::RenderError;
use crate::stride;

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
    /// What is drawn.
    pub stage: &'s Stage,
    /// Its volume, with optics.
    pub volume: &'s StageVolume,
    /// What the reconstruction reads: the volume, or its filter coefficients.
    pub field: Arc<Volume>,
    /// The component of `field` that is read.
    pub component: usize,
    /// How `field` is read.
    pub filter: Filter,
    /// Where the field is neither clipped nor outside a slab.
    pub region: Region,
    /// Blocks, where they bound what is sampled.
    pub blocks: Option<Arc<Blocks>>,
    /// Colour and opacity per unit distance.
    pub table: Table,
    /// Associated colour and opacity of one step.
    pub step_table: StepTable,
    /// The entries of all strides, if steps adapt to the data.
    pub stride_entries: Option<Vec<[f32; 4]>>,
    /// Which values are visible.
    pub visibility: Visibility,
    /// Ray integrals of one step, if classification is pre-integrated.
    pub preintegration: Option<PreIntegration>,
}

impl<'s> Prepared<'s> {
    /// Makes tables and blocks.
    ///
    /// # Errors
    /// [`RenderError::Optics`] if the data's range cannot be tabulated, [`RenderError::Steps`] if rays
    /// are too many steps long.
    pub fn new(stage: &'s Stage, volume: &'s StageVolume, cache: &mut Cache) -> Result<Self, RenderError> {
        let steps = longest(&volume.volume) / stage.step;
        if !(steps < f64::from(MOST_STEPS)) {
            return Err(RenderError::Steps { found: steps, limit: MOST_STEPS });
        }
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
        let step_table = StepTable::new(&table, ratio as f32)?;
        // Without blocks nothing is known of the data ahead.
        let adaptive = stage.quality.adaptive_tolerance > 0.0 && blocks.is_some();
        let stride_entries = adaptive
            .then(|| {
                let tables = stride::tables(&table, ratio as f32)?;
                Ok::<_, RenderError>(tables.iter().flat_map(StepTable::entries).copied().collect())
            })
            .transpose()?;
        Ok(Self {
            region: region(stage, volume),
            stride_entries,
            step_table,
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

    /// The grid all positions refer to.
    pub fn grid(&self) -> &Grid {
        self.volume.volume.grid()
    }
}

/// Steps are numbered in `f32`, which counts to here without a gap.
const MOST_STEPS: u32 = 1 << 24;

/// The diagonal of a volume's box, in world units: no ray is longer inside.
fn longest(volume: &Volume) -> f64 {
    let grid = volume.grid();
    let (low, high) = grid.index_bounds();
    let corner = |signs: [f64; 3]| grid.world_from_index().transform_vector3((high - low) * DVec3::from_array(signs));
    let diagonals = [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]];
    diagonals.map(|signs| corner(signs).length()).into_iter().fold(0.0, f64::max)
}

/// What is made of the samples.
pub fn mode(stage: &Stage) -> &Mode {
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
pub fn plane(stage: &Stage, volume: &StageVolume, slice: &Slice) -> (DVec3, DVec3) {
    let point = slice.point.map_or_else(|| volume.volume.grid().center(), DVec3::from_array);
    let normal = slice.normal.map_or(-stage.viewpoint.forward, DVec3::from_array);
    (point, normal.normalize())
}
