//! The tables and blocks of a stage: the same numbers that the CPU backend looks up.

use std::sync::Arc;

use pellucid_field::{Blocks, FieldError, Filter, Gradient, Volume, distances};
use pellucid_optics::{ColorSpace, DataRange, Nodes, PreIntegration, StepTable, Table, TransferFunction, Visibility};
use pellucid_scene::{Classification, Combine, Isosurface, Mode, Slice, Stage, StageVolume};

use crate::GpuError;
use crate::shaders::Pass;
use crate::uniforms::Level;

/// What a stage's mode needs.
pub struct Optics {
    /// The pass that draws it.
    pub pass: Pass,
    /// Whether values have opacity 1.
    pub opaque: bool,
    /// Linear RGB and opacity: per unit distance, per step or per segment, as the pass wants.
    pub entries: Vec<[f32; 4]>,
    /// Where they are.
    pub nodes: Nodes,
    /// What blocks say, if any are skipped.
    pub blocks: Option<BlockMap>,
    /// Isosurfaces.
    pub levels: Vec<Level>,
}

/// What rays ask of blocks, x fastest.
pub struct BlockMap {
    /// Blocks per axis.
    pub dims: [usize; 3],
    /// Cells per block and axis.
    pub size: usize,
    /// What is known of each.
    pub content: BlockContent,
}

impl BlockMap {
    /// Bytes of the texture.
    pub fn bytes(&self) -> u64 {
        match &self.content {
            BlockContent::Distances(distances) => distances.len() as u64,
            BlockContent::Extremes(extremes) => size_of_val(extremes.as_slice()) as u64,
        }
    }
}

/// What is known of blocks.
pub enum BlockContent {
    /// How many blocks away the next one is that can contribute.
    Distances(Vec<u8>),
    /// The largest value, or the smallest with its sign turned.
    Extremes(Vec<f32>),
}

/// What depends on the data alone and is kept from stage to stage.
#[derive(Default)]
pub struct BlockCache(Option<(Arc<Volume>, usize, Arc<Blocks>)>);

impl BlockCache {
    /// Blocks of the usual size, or so large that they fit into a texture of `side` per axis.
    fn blocks(&mut self, volume: &Arc<Volume>, component: usize, side: usize) -> Result<Arc<Blocks>, FieldError> {
        match &self.0 {
            Some((v, c, blocks)) if Arc::ptr_eq(v, volume) && *c == component => Ok(blocks.clone()),
            _ => {
                let cells = volume.grid().dims().into_iter().max().unwrap_or(1);
                let size = Blocks::CELLS.max(cells.div_ceil(side).next_power_of_two());
                let blocks = Arc::new(Blocks::new(volume, component, size, 0)?);
                self.0 = Some((volume.clone(), component, blocks.clone()));
                Ok(blocks)
            }
        }
    }
}

impl Optics {
    /// Makes the tables of a stage; textures have at most `side` texels per axis.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for a filter or gradient that this backend lacks, [`GpuError::Optics`]
    /// if the data's range cannot be tabulated.
    pub fn new(stage: &Stage, volume: &StageVolume, side: usize, cache: &mut BlockCache) -> Result<Self, GpuError> {
        let quality = &stage.quality;
        if quality.filter != Filter::Linear {
            return Err(GpuError::Unsupported { what: "filter but linear".to_owned() });
        }
        let lit = volume.material.is_some() && lights(stage.mode());
        if lit && quality.gradient != Gradient::Central {
            return Err(GpuError::Unsupported { what: "gradient but central differences".to_owned() });
        }
        let (pass, opaque) = pass_of(stage);
        let tf = &volume.transfer_function;
        let range = DataRange::of(&volume.volume);
        let ratio = stage.step / volume.unit_distance();
        let table = Table::for_data(tf, &range)?;
        let mut visibility = Visibility::of_table(&table);
        let (entries, nodes) = match pass {
            Pass::Composite | Pass::CompositePre | Pass::XRay => {
                let steps = StepTable::new(&table, ratio as f32)?;
                (steps.entries().to_vec(), *steps.nodes())
            }
            Pass::PreIntegrated => {
                let segments = PreIntegration::for_data(tf, &range, ratio)?;
                visibility = Visibility::of_segments(tf, segments.nodes());
                (segments.entries().to_vec(), *segments.nodes())
            }
            _ => (table.entries().to_vec(), *table.nodes()),
        };
        let levels = match stage.mode() {
            Mode::Isosurface(surfaces) => levels(surfaces, tf),
            _ => Vec::new(),
        };
        let blocks =
            quality.empty_space_skipping.then(|| cache.blocks(&volume.volume, volume.component, side)).transpose()?;
        let blocks = blocks.and_then(|blocks| {
            let live = |[low, high]: [f32; 2]| match pass {
                Pass::Isosurface => levels.iter().any(|level| (low..=high).contains(&level.value[0])),
                _ => visibility.any_opacity(low, high),
            };
            let content = match pass {
                Pass::Maximum | Pass::Minimum => BlockContent::Extremes(extremes(&blocks, pass == Pass::Minimum)),
                Pass::Average | Pass::Slice => return None,
                _ => BlockContent::Distances(distances(blocks.dims(), |block| {
                    let range = blocks.ranges()[block];
                    range != Blocks::ABSENT && live(Blocks::interpolated(range))
                })),
            };
            Some(BlockMap { dims: blocks.dims(), size: blocks.size(), content })
        });
        Ok(Self { pass, opaque, entries, nodes, blocks, levels })
    }
}

impl Optics {
    /// Bytes of the tables.
    pub fn bytes(&self) -> u64 {
        (size_of_val(self.entries.as_slice()) + size_of_val(self.levels.as_slice())) as u64
    }
}

/// Whether a mode shows surfaces in light.
pub fn lights(mode: &Mode) -> bool {
    matches!(mode, Mode::Composite | Mode::Isosurface(_))
}

/// The pass of a stage's mode, and whether values are opaque.
fn pass_of(stage: &Stage) -> (Pass, bool) {
    match stage.mode() {
        Mode::Composite => match stage.quality.classification {
            Classification::Post => (Pass::Composite, false),
            Classification::Pre => (Pass::CompositePre, false),
            Classification::PreIntegrated => (Pass::PreIntegrated, false),
        },
        Mode::Maximum => (Pass::Maximum, false),
        Mode::Minimum => (Pass::Minimum, false),
        Mode::Average => (Pass::Average, false),
        Mode::Additive => (Pass::Additive, false),
        Mode::XRay => (Pass::XRay, false),
        Mode::Isosurface(_) => (Pass::Isosurface, false),
        Mode::Slice(Slice { thickness, .. }) if *thickness <= 0.0 => (Pass::Slice, true),
        Mode::Slice(Slice { combine, .. }) => match combine {
            Combine::Maximum => (Pass::Maximum, true),
            Combine::Minimum => (Pass::Minimum, true),
            Combine::Average => (Pass::Average, true),
        },
    }
}

fn levels(surfaces: &Isosurface, tf: &TransferFunction) -> Vec<Level> {
    let level = |iso: &pellucid_scene::Isovalue| {
        let [r, g, b] = iso.color.map_or_else(|| tf.color(iso.value), |color| color.to_linear(ColorSpace::Srgb));
        Level { color: [r, g, b, iso.opacity], value: [iso.value as f32, 0.0, 0.0, 0.0] }
    };
    surfaces.isovalues.iter().map(level).collect()
}

/// The largest values of blocks, or the smallest with their signs turned; below all where there is none.
fn extremes(blocks: &Blocks, minimum: bool) -> Vec<f32> {
    let extreme = |&range: &[f32; 2]| {
        let [low, high] = Blocks::interpolated(range);
        (if minimum { -low } else { high }).max(f32::MIN)
    };
    blocks.ranges().iter().map(extreme).collect()
}
