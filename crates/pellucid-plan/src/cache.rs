//! What is kept from frame to frame, for every layer of a stage.

use std::sync::Arc;

use pellucid_field::{Blocks, FieldError, Volume, memory};
use pellucid_optics::{Chroma, ExtinctionBounds, Perturbation, Scattering, TransferFunction};
use pellucid_scene::{LightPath, Majorants, Mode, Quality, Stage};

use crate::color_grid::ColorGrid;
use crate::kept::{Kept, Margin};
use crate::majorants::MajorantGrid;
use crate::noises::Noises;
use crate::tables::{Sources, TableError, Tables};

/// What is kept from frame to frame: of every layer what depends on its data alone, and the tables of its last settings.
pub struct PlanCache {
    /// Most blocks per axis.
    most_blocks: usize,
    noises: Noises,
    layers: Vec<LayerCache>,
}

#[derive(Default)]
struct LayerCache {
    kept: Kept,
    tables: Option<(Settings, Arc<Tables>)>,
    majorants: Option<(Arc<Tables>, Majorants, Arc<MajorantGrid>)>,
    colors: Option<(Arc<Volume>, Arc<ColorGrid>)>,
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
    scattering: Option<(Scattering, LightPath)>,
    /// How each colour is held back, if not all alike.
    chroma: Option<Chroma>,
    perturbation: Perturbation,
}

impl Default for PlanCache {
    fn default() -> Self {
        Self::with_most_blocks(usize::MAX)
    }
}

impl PlanCache {
    /// A cache whose block maps have at most so many blocks per axis: they are larger where there would
    /// be more.
    pub fn with_most_blocks(most_blocks: usize) -> Self {
        Self { most_blocks: most_blocks.max(1), noises: Noises::default(), layers: Vec::new() }
    }

    /// The tables of a layer of a stage, by its number: the last ones, if nothing they depend on has changed. What is
    /// kept of layers that the stage has not any more is forgotten.
    ///
    /// # Errors
    /// [`TableError`] if the data's range cannot be tabulated, or if there is no such component.
    ///
    /// # Panics
    /// If the stage has no such layer.
    pub fn tables(&mut self, stage: &Stage, layer: usize) -> Result<Arc<Tables>, TableError> {
        self.layers.resize_with(stage.volumes.len(), LayerCache::default);
        let volume = &stage.volumes[layer];
        let settings = Settings {
            transfer_function: volume.transfer_function.clone(),
            component: volume.component,
            step: stage.step,
            unit_distance: volume.unit_distance(),
            quality: stage.quality.clone(),
            mode: stage.mode().clone(),
            classifies_voxels: stage.classifies_voxels(),
            scattering: stage.scatters_in(layer).then(|| (volume.scattering.clone(), stage.technique.needs().light)),
            chroma: stage.chroma(volume),
            perturbation: volume.perturbation.clone(),
        };
        let LayerCache { kept, tables, .. } = &mut self.layers[layer];
        match tables {
            Some((of, tables)) if tables.are_of(&volume.volume) && *of == settings => Ok(tables.clone()),
            _ => {
                let sources = Sources { kept, noises: &mut self.noises, most_blocks: self.most_blocks };
                let made = Arc::new(Tables::new(stage, layer, sources)?);
                *tables = Some((settings, made.clone()));
                Ok(made)
            }
        }
    }

    /// The colours of the voxels of a layer, if it is drawn in them: the last ones, if they are of this volume.
    ///
    /// # Panics
    /// If the stage has no such layer.
    pub fn colors(&mut self, stage: &Stage, layer: usize) -> Option<Arc<ColorGrid>> {
        self.layers.resize_with(stage.volumes.len(), LayerCache::default);
        let (kept, volume) = (&mut self.layers[layer].colors, stage.volumes[layer].colors.as_ref());
        kept.take_if(|(of, _)| volume.is_none_or(|volume| !Arc::ptr_eq(of, volume)));
        if let (None, Some(volume)) = (&*kept, volume) {
            *kept = ColorGrid::new(volume).map(|made| (volume.clone(), Arc::new(made)));
        }
        kept.as_ref().map(|(_, colors)| colors.clone())
    }

    /// What samples of a layer are made of, and which component of it: the field of its tables or, if that has several
    /// components, the one that is read by itself, for values that lie side by side are read many at a time. Where
    /// there is no memory for it, the field as it is.
    ///
    /// # Errors
    /// [`TableError::Field`] if there is no such component.
    ///
    /// # Panics
    /// If the stage has no such layer.
    pub fn values(&mut self, stage: &Stage, layer: usize, tables: &Tables) -> Result<(Arc<Volume>, usize), TableError> {
        self.layers.resize_with(stage.volumes.len(), LayerCache::default);
        let (field, component) = (&tables.field, tables.component);
        let all = field.voxels().as_bytes().len();
        if field.components() > 1 && memory::afford(all / field.components()).is_err() {
            return Ok((field.clone(), component));
        }
        Ok((self.layers[layer].kept.alone(field, component)?, 0))
    }

    /// Bounds of the extinction of a layer, for whose tables they are: the last ones, if they are of these tables.
    ///
    /// # Errors
    /// [`TableError::Field`] if there is no such component.
    ///
    /// # Panics
    /// If the stage has no such layer.
    pub fn majorants(
        &mut self,
        stage: &Stage,
        layer: usize,
        tables: &Arc<Tables>,
        bounds: Majorants,
    ) -> Result<Arc<MajorantGrid>, TableError> {
        self.layers.resize_with(stage.volumes.len(), LayerCache::default);
        let LayerCache { kept, majorants, .. } = &mut self.layers[layer];
        if let Some((of, kind, majorants)) = majorants
            && Arc::ptr_eq(of, tables)
            && *kind == bounds
        {
            return Ok(majorants.clone());
        }
        let ranges = match bounds {
            Majorants::Local => fine_ranges(kept, tables)?,
            Majorants::Global => None,
        };
        let extinctions = ExtinctionBounds::new(&tables.table, stage.volumes[layer].unit_distance());
        let variation = tables.variation.as_ref();
        let factors = variation.map_or([1.0; 2], |v| [v.least_extinction(), v.most_extinction()]);
        let statistics = tables.field.statistics();
        let is_whole = statistics.nan + statistics.infinite == 0;
        let made = Arc::new(MajorantGrid::new(ranges.as_deref(), &extinctions, factors, is_whole));
        *majorants = Some((tables.clone(), bounds, made.clone()));
        Ok(made)
    }
}

/// Blocks, of half the usual size, that bound every value of the field that `tables` classify; `None` if the filter
/// leaves the range of its voxels too far for them to tell anything.
fn fine_ranges(kept: &mut Kept, tables: &Tables) -> Result<Option<Arc<Blocks>>, FieldError> {
    let margin = Margin::of(tables.filter).map(|margin| margin.displaced(tables.displacer.as_ref()));
    margin.map(|margin| kept.fine_blocks(&tables.field, tables.component, margin)).transpose()
}
