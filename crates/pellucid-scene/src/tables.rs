//! What every backend looks up: the tables of a stage and what blocks tell of its data, made once and
//! kept from frame to frame.

use std::sync::Arc;

use pellucid_field::{Blocks, FieldError, Filter, Noise, Volume, spline_coefficients};
use pellucid_optics::{
    Chroma, DataRange, Displacer, OpticsError, Perturbation, PreIntegration, Scattering, StepTable, Table,
    TransferFunction, Variation, Visibility,
};

use crate::blocks::{BlockContent, BlockMap};
use crate::light_tables::LightTables;
use crate::strides;
use crate::{Classification, Combine, MajorantGrid, Majorants, Mode, Quality, Slice, Stage, StageVolume};

/// Why the tables of a stage cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TableError {
    /// The transfer function cannot be tabulated over the data.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// The field cannot be reconstructed as asked.
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// What is kept from frame to frame: what depends on the data alone, and the tables of the last
/// settings.
pub struct TableCache {
    /// Most blocks per axis.
    most_blocks: usize,
    blocks: Option<KeptBlocks>,
    /// Of half the size.
    fine_blocks: Option<KeptBlocks>,
    extremes: Option<(Arc<Blocks>, bool, Arc<Vec<f32>>)>,
    coefficients: Option<(Arc<Volume>, usize, Arc<Volume>)>,
    noise: Option<(u32, Arc<Noise>)>,
    tables: Option<(Settings, Arc<Tables>)>,
    pub(crate) majorants: Option<(Arc<Tables>, Majorants, Arc<MajorantGrid>)>,
}

/// Blocks and what they are of.
type KeptBlocks = (Arc<Volume>, usize, Margin, Arc<Blocks>);

/// How far a filter, or a displacement, sees beyond a cell, in voxels, and samples leave the range of what it
/// sees.
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
    classifies_voxels: bool,
    /// How light is scattered, if it is, and whether it travels from slab to slab.
    scattering: Option<(Scattering, bool)>,
    /// How each colour is held back, if not all alike.
    chroma: Option<Chroma>,
    perturbation: Perturbation,
}

impl Default for TableCache {
    fn default() -> Self {
        Self::with_most_blocks(usize::MAX)
    }
}

impl TableCache {
    /// A cache whose block maps have at most so many blocks per axis: they are larger where there would
    /// be more.
    pub fn with_most_blocks(most_blocks: usize) -> Self {
        Self {
            most_blocks: most_blocks.max(1),
            blocks: None,
            fine_blocks: None,
            extremes: None,
            coefficients: None,
            noise: None,
            tables: None,
            majorants: None,
        }
    }

    /// The tables of a volume of a stage: the last ones, if nothing they depend on has changed.
    ///
    /// # Errors
    /// [`TableError`] if the data's range cannot be tabulated, or if there is no such component.
    pub fn tables(&mut self, stage: &Stage, volume: &StageVolume) -> Result<Arc<Tables>, TableError> {
        let settings = Settings {
            transfer_function: volume.transfer_function.clone(),
            component: volume.component,
            step: stage.step,
            unit_distance: volume.unit_distance(),
            quality: stage.quality.clone(),
            mode: stage.mode().clone(),
            classifies_voxels: stage.classifies_voxels(),
            scattering: stage.scatters().then(|| (volume.scattering.clone(), stage.half_angle().is_some())),
            chroma: stage.chroma(volume),
            perturbation: volume.perturbation.clone(),
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

    /// Blocks, of half the usual size, that bound every value of the field that `tables` classify; `None`
    /// if the filter leaves the range of its voxels too far for them to tell anything.
    ///
    /// # Errors
    /// [`TableError::Field`] if there is no such component.
    pub(crate) fn fine_ranges(&mut self, tables: &Tables) -> Result<Option<Arc<Blocks>>, TableError> {
        let Some(margin) = Margin::of(tables.filter) else { return Ok(None) };
        let margin = margin.displaced(tables.displacer.as_ref());
        let size = Blocks::CELLS / 2;
        Ok(Some(kept(&mut self.fine_blocks, &tables.field, tables.component, margin, size)?))
    }

    fn blocks(&mut self, volume: &Arc<Volume>, component: usize, margin: Margin) -> Result<Arc<Blocks>, FieldError> {
        let cells = volume.grid().dims().into_iter().max().unwrap_or(1);
        let size = Blocks::CELLS.max(cells.div_ceil(self.most_blocks).next_power_of_two());
        kept(&mut self.blocks, volume, component, margin, size)
    }

    fn extremes(&mut self, blocks: &Arc<Blocks>, minimum: bool) -> BlockContent {
        let values = match &self.extremes {
            Some((of, least, values)) if Arc::ptr_eq(of, blocks) && *least == minimum => values.clone(),
            _ => {
                let values = BlockContent::extremes(blocks, minimum);
                self.extremes = Some((blocks.clone(), minimum, values.clone()));
                values
            }
        };
        BlockContent::Extremes(values)
    }

    fn noise(&mut self, seed: u32) -> Arc<Noise> {
        match &self.noise {
            Some((of, noise)) if *of == seed => noise.clone(),
            _ => {
                let noise = Arc::new(Noise::new(seed));
                self.noise = Some((seed, noise.clone()));
                noise
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

/// What depends on a volume, its transfer function and the quality, but not on camera and light.
pub struct Tables {
    /// What is drawn.
    volume: Arc<Volume>,
    /// What the reconstruction reads: the volume, or its filter coefficients.
    pub field: Arc<Volume>,
    /// The component of `field` that is read.
    pub component: usize,
    /// How `field` is read: never a B-spline with prefilter.
    pub filter: Filter,
    /// What values the field can have.
    pub range: DataRange,
    /// Colour and opacity per unit distance.
    pub table: Table,
    /// Associated colour and opacity of one step.
    pub step_table: StepTable,
    /// The entries of all strides, if steps adapt to the data: those of one step, then of two, of four.
    pub stride_entries: Option<Vec<[f32; 4]>>,
    /// Ray integrals of one step, if classification is pre-integrated.
    pub preintegration: Option<PreIntegration>,
    /// What blocks tell, for modes that leap over some.
    pub blocks: Option<BlockMap>,
    /// What samples that scatter light look up.
    pub light: LightTables,
    /// What moves the field, if anything does.
    pub displacer: Option<Displacer>,
    /// What varies its optics, if anything does.
    pub variation: Option<Variation>,
}

impl Tables {
    /// Associated colours of one step of what samples scatter or are.
    pub fn scattered_steps(&self) -> &StepTable {
        self.light.albedo.as_ref().unwrap_or(&self.step_table)
    }

    fn new(stage: &Stage, volume: &StageVolume, cache: &mut TableCache) -> Result<Self, TableError> {
        let quality = &stage.quality;
        let (field, component, filter) = match quality.filter {
            Filter::BSpline { prefilter: true } => {
                let coefficients = cache.coefficients(&volume.volume, volume.component)?;
                (coefficients, 0, Filter::BSpline { prefilter: false })
            }
            filter => (volume.volume.clone(), volume.component, filter),
        };
        let tf = &volume.transfer_function;
        let range = reached(&volume.volume, &field, filter);
        let ratio = stage.step / volume.unit_distance();
        let table = Table::for_data(tf, &range)?;
        let chroma = stage.chroma(volume);
        let step_table = steps(&table, ratio as f32, chroma.as_ref())?;
        let light = LightTables::new(stage, volume, &table, &range)?;
        let composited = matches!(stage.mode(), Mode::Composite);
        let preintegration =
            (composited && quality.classification == Classification::PreIntegrated && chroma.is_none())
                .then(|| PreIntegration::for_data(tf, &range, ratio))
                .transpose()?;
        let visibility = match &preintegration {
            Some(segments) => Visibility::of_segments(tf, segments.nodes()),
            None => Visibility::of_table(&table),
        };
        let visible = |low, high| visibility.any_opacity(low, high);
        let (mut displacer, mut variation) = (None, None);
        if volume.perturbation.displaces() || volume.perturbation.varies() {
            let (noise, grid) = (cache.noise(volume.perturbation.seed), volume.volume.grid());
            displacer = Displacer::new(&volume.perturbation, &noise, grid);
            variation = Variation::new(&volume.perturbation, &noise, grid);
        }
        let (of, moved) = ((&field, component, filter), displacer.as_ref());
        let ranges = quality.empty_space_skipping.then(|| bounds(stage, volume, of, moved, cache));
        let ranges = ranges.transpose()?.flatten();
        let mut blocks = ranges.as_ref().and_then(|ranges| {
            let content = match stage.mode() {
                Mode::Minimum | Mode::Slice(Slice { combine: Combine::Minimum, .. }) => cache.extremes(ranges, true),
                Mode::Maximum | Mode::Slice(Slice { combine: Combine::Maximum, .. }) => cache.extremes(ranges, false),
                Mode::Composite | Mode::Additive | Mode::XRay => BlockContent::distances(ranges, visible),
                Mode::Isosurface(isosurface) => {
                    let levels: Vec<f32> = isosurface.isovalues.iter().map(|iso| iso.value as f32).collect();
                    let crossed = |low, high| levels.iter().any(|level| (low..=high).contains(level));
                    BlockContent::distances(ranges, crossed)
                }
                Mode::Average | Mode::Slice(_) => return None,
            };
            Some(BlockMap { dims: ranges.dims(), size: ranges.size(), content, levels: None })
        });
        // Without blocks nothing is known of the data ahead.
        let adaptive = composited && quality.classification == Classification::Post && quality.adaptive_tolerance > 0.0;
        let mut stride_entries = None;
        if let (true, Some(blocks), Some(ranges)) = (adaptive, &mut blocks, &ranges) {
            let shortest = volume.volume.grid().spacing().into_iter().fold(f64::INFINITY, f64::min);
            let step = stage.step / shortest;
            blocks.levels = Some(strides::levels(ranges, &step_table, visible, quality.adaptive_tolerance, step));
            let tables = strides::tables(&table, ratio as f32, chroma.as_ref())?;
            stride_entries = Some(tables.iter().flat_map(StepTable::entries).copied().collect());
        }
        Ok(Self {
            volume: volume.volume.clone(),
            field,
            component,
            filter,
            range,
            table,
            step_table,
            stride_entries,
            preintegration,
            blocks,
            light,
            displacer,
            variation,
        })
    }
}

/// Associated colours of steps of so many unit distances.
pub(crate) fn steps(table: &Table, ratio: f32, chroma: Option<&Chroma>) -> Result<StepTable, OpticsError> {
    match chroma {
        Some(chroma) => StepTable::chromatic(table, ratio, chroma),
        None => StepTable::new(table, ratio),
    }
}

/// The values that the filter can make of what it reads: voxels, or coefficients whose range is wider.
fn reached(volume: &Volume, field: &Volume, filter: Filter) -> DataRange {
    let read = DataRange::of(field);
    let beyond = filter.overshoot() * (read.high - read.low);
    DataRange::of(volume).reaching(read.low - beyond, read.high + beyond)
}

/// The blocks that are kept, if they are of this, or new ones in their place.
fn kept(
    slot: &mut Option<KeptBlocks>,
    volume: &Arc<Volume>,
    component: usize,
    margin: Margin,
    size: usize,
) -> Result<Arc<Blocks>, FieldError> {
    match slot {
        Some((v, c, m, blocks)) if Arc::ptr_eq(v, volume) && *c == component && *m == margin => Ok(blocks.clone()),
        _ => {
            let mut blocks = Blocks::new(volume, component, size, margin.reach)?;
            if margin.overshoot > 0.0 {
                blocks = blocks.overshot(margin.overshoot);
            }
            let blocks = Arc::new(blocks);
            *slot = Some((volume.clone(), component, margin, blocks.clone()));
            Ok(blocks)
        }
    }
}

/// Blocks that bound every value that is classified; `None` if the filter leaves the range of its
/// voxels too far for them to tell anything. Samples of a field are bounded by the numbers that its
/// filter weighs; pre-classified samples blend colours of the volume's voxels, which are zero wherever
/// the voxels' are, whatever the weights.
fn bounds(
    stage: &Stage,
    volume: &StageVolume,
    (field, component, filter): (&Arc<Volume>, usize, Filter),
    displacer: Option<&Displacer>,
    cache: &mut TableCache,
) -> Result<Option<Arc<Blocks>>, FieldError> {
    if stage.classifies_voxels() {
        let reach = filter.half_width() - 1;
        let margin = Margin { reach, overshoot: 0.0 }.displaced(displacer);
        return cache.blocks(&volume.volume, volume.component, margin).map(Some);
    }
    Margin::of(filter).map(|margin| cache.blocks(field, component, margin.displaced(displacer))).transpose()
}

impl Margin {
    /// That of a filter; `None` if its samples leave the range of their voxels too far to tell anything.
    fn of(filter: Filter) -> Option<Self> {
        const FURTHEST: f64 = 4.0;
        let overshoot = filter.overshoot();
        (overshoot <= FURTHEST).then(|| Self { reach: filter.half_width() - 1, overshoot })
    }

    /// This, where positions move before the filter sees them: by no more than the displacement's reach, and
    /// a rounding.
    fn displaced(self, displacer: Option<&Displacer>) -> Self {
        const ROUNDING: f32 = 1e-3;
        let furthest = displacer.map_or(0.0, |displacer| displacer.reach.into_iter().fold(0.0, f32::max) + ROUNDING);
        Self { reach: self.reach + furthest.ceil() as usize, ..self }
    }
}
