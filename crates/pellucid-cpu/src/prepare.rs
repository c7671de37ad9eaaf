//! What a frame needs before its first ray: tables for this step, and blocks in the shape lanes meet
//! them.

use std::sync::Arc;

use pellucid_field::{Grid, Volume};
use pellucid_optics::StepTable;
use pellucid_plan::{BlockContent, BlockMap, ColorGrid, PlanCache, Tables};
use pellucid_scene::{Region, Stage, StageVolume};

use crate::RenderError;
use crate::cut::Cuts;
use crate::field::Bounds;
use crate::skip::{ExtremeGrid, Levels, SkipGrid};
use crate::solid::Solid;

/// What is kept from frame to frame.
#[derive(Default)]
pub struct Cache {
    /// Tables and blocks of the data.
    pub plan: PlanCache,
    layers: Vec<LayerCache>,
}

/// What is kept of each layer.
#[derive(Default)]
struct LayerCache {
    grids: Option<(Arc<Tables>, Arc<Grids>)>,
    extremes: Option<(Arc<Vec<f32>>, Arc<ExtremeGrid>)>,
}

impl LayerCache {
    fn new_grids(&mut self, tables: &Tables) -> Grids {
        let (mut skip, mut extremes) = (None, None);
        let levels = tables.blocks.as_ref().and_then(Levels::new);
        if let Some(blocks) = &tables.blocks {
            match &blocks.content {
                BlockContent::Distances(distances) => skip = Some(SkipGrid::new(blocks, distances)),
                BlockContent::Extremes(values) => extremes = Some(self.extremes(blocks, values)),
            }
        }
        Grids { skip, levels, extremes }
    }

    /// Extremes depend on the data alone and are kept when optics change.
    fn extremes(&mut self, blocks: &BlockMap, values: &Arc<Vec<f32>>) -> Arc<ExtremeGrid> {
        match &self.extremes {
            Some((of, grid)) if Arc::ptr_eq(of, values) => grid.clone(),
            _ => {
                let grid = Arc::new(ExtremeGrid::new(blocks, values));
                self.extremes = Some((values.clone(), grid.clone()));
                grid
            }
        }
    }

    fn grids(&mut self, tables: &Arc<Tables>) -> Arc<Grids> {
        match &self.grids {
            Some((of, grids)) if Arc::ptr_eq(of, tables) => grids.clone(),
            _ => {
                let grids = Arc::new(self.new_grids(tables));
                self.grids = Some((tables.clone(), grids.clone()));
                grids
            }
        }
    }
}

/// The blocks of tables.
pub struct Grids {
    /// Blocks that can contribute, for modes that know.
    pub skip: Option<SkipGrid>,
    /// The strides that they allow, if steps adapt to the data.
    pub levels: Option<Levels>,
    /// Extremes of blocks, for modes that project one.
    pub extremes: Option<Arc<ExtremeGrid>>,
}

/// A volume and its optics, made ready for one stage.
pub struct Prepared<'s> {
    /// What is drawn.
    pub stage: &'s Stage,
    /// The number of its volume.
    pub number: usize,
    /// Its volume, with optics.
    pub volume: &'s StageVolume,
    /// Where the field is neither clipped nor outside a slab.
    pub region: Region,
    /// What is looked up.
    pub tables: Arc<Tables>,
    /// What samples are made of, and which component of it.
    pub values: (Arc<Volume>, usize),
    /// The colours of its voxels, if it is drawn in them.
    pub colors: Option<Arc<ColorGrid>>,
    /// What is leapt over.
    pub grids: Arc<Grids>,
    /// What the ways to lights need, if shadow rays are cast.
    pub shadows: Option<ShadowSteps>,
}

/// Steps of shadow rays.
pub struct ShadowSteps {
    /// Their length in world units.
    pub length: f64,
    /// Associated colour and opacity of one; of the colour that is lost least.
    pub table: StepTable,
}

impl<'s> Prepared<'s> {
    /// Makes tables and blocks of a layer, or finds them in the cache.
    ///
    /// # Errors
    /// [`RenderError::Optics`] if the data's range cannot be tabulated, [`RenderError::Steps`] if rays
    /// are too many steps long.
    pub fn new(stage: &'s Stage, layer: usize, cache: &mut Cache) -> Result<Self, RenderError> {
        let volume = &stage.volumes[layer];
        let steps = stage.most_steps(volume);
        let numbered = steps < f64::from(MOST_STEPS);
        if !numbered {
            return Err(RenderError::Steps { found: steps, limit: MOST_STEPS });
        }
        let (tables, colors) = (cache.plan.tables(stage, layer)?, cache.plan.colors(stage, layer));
        let values = cache.plan.values(stage, layer, &tables)?;
        cache.layers.resize_with(stage.volumes.len(), LayerCache::default);
        let grids = cache.layers[layer].grids(&tables);
        let length = stage.shadow_step(volume);
        let least = stage.chroma(volume).map_or(1.0, |chroma| chroma.least);
        let steps = |length| {
            let table = StepTable::new(&tables.table, (length / volume.unit_distance()) as f32 * least)?;
            Ok::<_, RenderError>(ShadowSteps { length, table })
        };
        let shadows = length.map(steps).transpose()?;
        Ok(Self { stage, number: layer, volume, region: stage.region(volume), tables, values, colors, grids, shadows })
    }

    /// Associated colours of one step.
    pub fn step_table(&self) -> &StepTable {
        self.tables.scattered_steps()
    }

    /// Where clips and the box cut through matter; a step of the transfer function's width is as steep as that.
    pub fn cuts(&self) -> Cuts {
        let [low, high] = self.tables.table.nodes().domain();
        let rise = if high > low { (high - low) as f32 } else { 1.0 };
        Cuts::new(Bounds::new(self.grid(), &self.region), self.grid().world_from_index_gradient(), rise)
    }

    /// Where the field is.
    pub fn solid(&self) -> Solid {
        Solid::new(self.grid(), &self.region)
    }

    /// The grid all positions refer to.
    pub fn grid(&self) -> &Grid {
        self.volume.volume.grid()
    }
}

/// Steps are numbered in `f32`, which counts to here without a gap.
pub const MOST_STEPS: u32 = 1 << 24;
