//! What a frame needs before its first ray: tables for this step, and blocks.

use std::sync::Arc;

use glam::DVec3;
use pellucid_field::{Blocks, FieldError, Filter, Grid, Volume, spline_coefficients};
use pellucid_optics::{DataRange, PreIntegration, StepTable, Table, TransferFunction, Visibility};
use pellucid_scene::{Classification, Combine, Mode, Quality, RayCast, Region, Slice, Stage, StageVolume, Technique};

use crate::RenderError;
use crate::skip::{ExtremeGrid, SkipGrid};
use crate::stride;

/// What is kept from frame to frame: what depends on the data alone, and the tables of the last
/// settings.
#[derive(Default)]
pub struct Cache {
    blocks: Option<(Arc<Volume>, usize, Margin, Arc<Blocks>)>,
    extremes: Option<(Arc<Blocks>, bool, Arc<ExtremeGrid>)>,
    coefficients: Option<(Arc<Volume>, usize, Arc<Volume>)>,
    tables: Option<(Settings, Arc<Tables>)>,
}

/// How far a filter sees beyond a cell, in voxels, and its samples leave the range of what it sees.
#[derive(Clone, Copy, PartialEq)]
struct Margin {
    reach: usize,
    overshoot: f64,
}

/// Everything that tables depend on.
#[derive(PartialEq)]
struct Settings {
    transfer_function: TransferFunction,
    component: usize,
    step: f64,
    unit_distance: f64,
    quality: Quality,
    mode: Mode,
}

impl Cache {
    fn blocks(&mut self, volume: &Arc<Volume>, component: usize, margin: Margin) -> Result<Arc<Blocks>, FieldError> {
        match &self.blocks {
            Some((v, c, m, blocks)) if Arc::ptr_eq(v, volume) && *c == component && *m == margin => Ok(blocks.clone()),
            _ => {
                let mut blocks = Blocks::new(volume, component, Blocks::CELLS, margin.reach)?;
                if margin.overshoot > 0.0 {
                    blocks = blocks.overshot(margin.overshoot);
                }
                let blocks = Arc::new(blocks);
                self.blocks = Some((volume.clone(), component, margin, blocks.clone()));
                Ok(blocks)
            }
        }
    }

    fn extremes(&mut self, blocks: &Arc<Blocks>, minimum: bool) -> Arc<ExtremeGrid> {
        match &self.extremes {
            Some((of, least, grid)) if Arc::ptr_eq(of, blocks) && *least == minimum => grid.clone(),
            _ => {
                let grid = Arc::new(ExtremeGrid::new(blocks, minimum));
                self.extremes = Some((blocks.clone(), minimum, grid.clone()));
                grid
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

    fn tables(&mut self, stage: &Stage, volume: &StageVolume) -> Result<Arc<Tables>, RenderError> {
        let settings = Settings {
            transfer_function: volume.transfer_function.clone(),
            component: volume.component,
            step: stage.step,
            unit_distance: volume.unit_distance(),
            quality: stage.quality.clone(),
            mode: mode(stage).clone(),
        };
        match &self.tables {
            Some((of, tables)) if Arc::ptr_eq(&tables.volume, &volume.volume) && *of == settings => Ok(tables.clone()),
            _ => {
                let tables = Arc::new(Tables::new(stage, volume, self)?);
                self.tables = Some((settings, tables.clone()));
                Ok(tables)
            }
        }
    }
}

/// What depends on a volume, its transfer function and the quality, but not on camera and light.
pub struct Tables {
    /// What is drawn.
    volume: Arc<Volume>,
    /// What the reconstruction reads: the volume, or its filter coefficients.
    pub field: Arc<Volume>,
    /// The component of `field` that is read.
    pub component: usize,
    /// How `field` is read.
    pub filter: Filter,
    /// Colour and opacity per unit distance.
    pub table: Table,
    /// Associated colour and opacity of one step.
    pub step_table: StepTable,
    /// The entries of all strides, if steps adapt to the data.
    pub stride_entries: Option<Vec<[f32; 4]>>,
    /// Ray integrals of one step, if classification is pre-integrated.
    pub preintegration: Option<PreIntegration>,
    /// Blocks that can contribute, for modes that know.
    pub skip: Option<SkipGrid>,
    /// Extremes of blocks, for modes that project one.
    pub extremes: Option<Arc<ExtremeGrid>>,
}

impl Tables {
    fn new(stage: &Stage, volume: &StageVolume, cache: &mut Cache) -> Result<Self, RenderError> {
        let quality = &stage.quality;
        let (field, component, filter) = match quality.filter {
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
        let step_table = StepTable::new(&table, ratio as f32)?;
        let composited = matches!(mode(stage), Mode::Composite);
        let preintegration = (composited && quality.classification == Classification::PreIntegrated)
            .then(|| PreIntegration::for_data(tf, &range, ratio))
            .transpose()?;
        let visibility = match &preintegration {
            Some(segments) => Visibility::of_segments(tf, segments.nodes()),
            None => Visibility::of_table(&table),
        };
        let visible = |low, high| visibility.any_opacity(low, high);
        let blocks = quality.empty_space_skipping.then(|| bounds(stage, volume, (&field, component, filter), cache));
        let blocks = blocks.transpose()?.flatten();
        let extremes = blocks.as_ref().and_then(|blocks| match mode(stage) {
            Mode::Minimum | Mode::Slice(Slice { combine: Combine::Minimum, .. }) => Some(cache.extremes(blocks, true)),
            Mode::Maximum | Mode::Slice(Slice { combine: Combine::Maximum, .. }) => Some(cache.extremes(blocks, false)),
            _ => None,
        });
        let mut skip = blocks.as_ref().and_then(|blocks| match mode(stage) {
            Mode::Composite | Mode::Additive | Mode::XRay => Some(SkipGrid::new(blocks, visible)),
            Mode::Isosurface(isosurface) => {
                let levels: Vec<f32> = isosurface.isovalues.iter().map(|iso| iso.value as f32).collect();
                Some(SkipGrid::new(blocks, |low, high| levels.iter().any(|level| (low..=high).contains(level))))
            }
            Mode::Maximum | Mode::Minimum | Mode::Average | Mode::Slice(_) => None,
        });
        // Without blocks nothing is known of the data ahead.
        let adaptive = composited && quality.classification == Classification::Post && quality.adaptive_tolerance > 0.0;
        let mut stride_entries = None;
        if let (true, Some(grid), Some(blocks)) = (adaptive, &mut skip, &blocks) {
            let shortest = volume.volume.grid().spacing().into_iter().fold(f64::INFINITY, f64::min);
            let step = stage.step / shortest;
            grid.set_levels(stride::levels(blocks, &step_table, visible, quality.adaptive_tolerance, step));
            let tables = stride::tables(&table, ratio as f32)?;
            stride_entries = Some(tables.iter().flat_map(StepTable::entries).copied().collect());
        }
        Ok(Self {
            volume: volume.volume.clone(),
            field,
            component,
            filter,
            table,
            step_table,
            stride_entries,
            preintegration,
            skip,
            extremes,
        })
    }
}

/// A volume and its optics, made ready for one stage.
pub struct Prepared<'s> {
    /// What is drawn.
    pub stage: &'s Stage,
    /// Its volume, with optics.
    pub volume: &'s StageVolume,
    /// Where the field is neither clipped nor outside a slab.
    pub region: Region,
    /// What is looked up.
    pub tables: Arc<Tables>,
}

impl<'s> Prepared<'s> {
    /// Makes tables and blocks, or finds them in the cache.
    ///
    /// # Errors
    /// [`RenderError::Optics`] if the data's range cannot be tabulated, [`RenderError::Steps`] if rays
    /// are too many steps long.
    pub fn new(stage: &'s Stage, volume: &'s StageVolume, cache: &mut Cache) -> Result<Self, RenderError> {
        let steps = longest(&volume.volume) / stage.step;
        let numbered = steps < f64::from(MOST_STEPS);
        if !numbered {
            return Err(RenderError::Steps { found: steps, limit: MOST_STEPS });
        }
        Ok(Self { stage, volume, region: region(stage, volume), tables: cache.tables(stage, volume)? })
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

/// Blocks that bound every value that is classified; `None` if the filter leaves the range of its
/// voxels too far for them to tell anything. Samples of a field are bounded by the numbers that its
/// filter weighs; pre-classified samples blend colours of the volume's voxels, which are zero wherever
/// the voxels' are, whatever the weights.
fn bounds(
    stage: &Stage,
    volume: &StageVolume,
    (field, component, filter): (&Arc<Volume>, usize, Filter),
    cache: &mut Cache,
) -> Result<Option<Arc<Blocks>>, FieldError> {
    const FURTHEST: f64 = 4.0;
    let reach = filter.half_width() - 1;
    if matches!(mode(stage), Mode::Composite) && stage.quality.classification == Classification::Pre {
        return cache.blocks(&volume.volume, volume.component, Margin { reach, overshoot: 0.0 }).map(Some);
    }
    let overshoot = filter.overshoot();
    if overshoot > FURTHEST {
        return Ok(None);
    }
    cache.blocks(field, component, Margin { reach, overshoot }).map(Some)
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
