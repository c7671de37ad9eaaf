//! What every backend looks up: the tables of a layer and what blocks tell of its data.

use std::sync::Arc;

use pellucid_field::{Blocks, FieldError, Filter, Volume};
use pellucid_optics::{DataRange, Displacer, OpticsError, PreIntegration, StepTable, Table, Variation, Visibility};
use pellucid_scene::{Classification, Combine, Mode, Slice, Stage, StageVolume};

use crate::blocks::{BlockContent, BlockMap};
use crate::kept::{Kept, Margin};
use crate::light_tables::LightTables;
use crate::noises::Noises;
use crate::strides;

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
    /// The ranges of values in blocks, where empty space is skipped and they tell something.
    pub ranges: Option<Arc<Blocks>>,
    /// What blocks tell, for modes that leap over some.
    pub blocks: Option<BlockMap>,
    /// What samples that scatter light look up.
    pub light: LightTables,
    /// What moves the field, if anything does.
    pub displacer: Option<Displacer>,
    /// What varies its optics, if anything does.
    pub variation: Option<Variation>,
}

/// What tables are made of, and what of it is kept.
pub(crate) struct Sources<'a> {
    pub kept: &'a mut Kept,
    pub noises: &'a mut Noises,
    /// Most blocks per axis.
    pub most_blocks: usize,
}

impl Tables {
    /// Associated colours of one step of what samples scatter or are.
    pub fn scattered_steps(&self) -> &StepTable {
        self.light.albedo.as_ref().unwrap_or(&self.step_table)
    }

    /// Whether they are of this volume.
    pub(crate) fn are_of(&self, volume: &Arc<Volume>) -> bool {
        Arc::ptr_eq(&self.volume, volume)
    }

    pub(crate) fn new(stage: &Stage, layer: usize, from: Sources<'_>) -> Result<Self, TableError> {
        let volume = &stage.volumes[layer];
        let Sources { kept, noises, most_blocks } = from;
        let quality = &stage.quality;
        let (field, component, filter) = match quality.filter {
            Filter::BSpline { prefilter: true } => {
                let coefficients = kept.coefficients(&volume.volume, volume.component)?;
                (coefficients, 0, Filter::BSpline { prefilter: false })
            }
            filter => (volume.volume.clone(), volume.component, filter),
        };
        let tf = &volume.transfer_function;
        let range = reached(&volume.volume, &field, filter);
        let ratio = stage.step / volume.unit_distance();
        let table = Table::for_data(tf, &range)?;
        let chroma = stage.chroma(volume);
        let step_table = StepTable::of(&table, ratio as f32, chroma.as_ref())?;
        let light = LightTables::new(stage, layer, &table, &range)?;
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
            let (noise, grid) = (noises.of(volume.perturbation.seed), volume.volume.grid());
            displacer = Displacer::new(&volume.perturbation, &noise, grid);
            variation = Variation::new(&volume.perturbation, &noise, grid);
        }
        let (of, moved) = ((&field, component, filter), displacer.as_ref());
        let ranges = quality.empty_space_skipping.then(|| bounds(stage, volume, of, moved, kept, most_blocks));
        let ranges = ranges.transpose()?.flatten();
        let mut blocks = ranges.as_ref().and_then(|ranges| {
            let content = match stage.mode() {
                Mode::Minimum | Mode::Slice(Slice { combine: Combine::Minimum, .. }) => kept.extremes(ranges, true),
                Mode::Maximum | Mode::Slice(Slice { combine: Combine::Maximum, .. }) => kept.extremes(ranges, false),
                Mode::Composite | Mode::Additive | Mode::XRay => BlockContent::distances(ranges, visible),
                Mode::Isosurface(_) => {
                    let levels: Vec<f32> = stage.isovalues(layer).iter().map(|iso| iso.value as f32).collect();
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
            ranges,
            blocks,
            light,
            displacer,
            variation,
        })
    }
}

/// The values that the filter can make of what it reads: voxels, or coefficients whose range is wider.
fn reached(volume: &Volume, field: &Volume, filter: Filter) -> DataRange {
    let read = DataRange::of(field);
    let beyond = filter.overshoot() * (read.high - read.low);
    DataRange::of(volume).reaching(read.low - beyond, read.high + beyond)
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
    kept: &mut Kept,
    most: usize,
) -> Result<Option<Arc<Blocks>>, FieldError> {
    if stage.classifies_voxels() {
        let reach = filter.half_width() - 1;
        let margin = Margin { reach, overshoot: 0.0 }.displaced(displacer);
        return kept.blocks(&volume.volume, volume.component, margin, most).map(Some);
    }
    Margin::of(filter).map(|margin| kept.blocks(field, component, margin.displaced(displacer), most)).transpose()
}
