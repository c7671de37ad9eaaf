//! Light at places, kept while nothing that it depends on changes (G-25): not on the camera and, at places that are each on
//! their own surface, not on isovalues either.

use std::path::Path;
use std::sync::Arc;

use pellucid_field::memory::OutOfMemory;
use pellucid_field::{Filter, Gradient, Volume};
use pellucid_optics::{Environment, Perturbation, ResolvedLight, SkySource, TransferFunction};
use pellucid_scene::{
    GlobalIllumination, HarmonicWindow, Held, IlluminationBasis, IlluminationInterpolation, IlluminationMethod,
    Isovalue, PlacesOn, Region, Stage, SurfaceNormals,
};

use super::bricks::Bricks;
use super::distant::{Distant, DistantLight};
use super::kept::{Kept, Surface};
use super::lattice::Lattice;
use super::level_grids::LevelGrids;
use super::mark::Mark;
use super::saved;
use super::saved_error::SavedLightError;
use crate::RenderError;
use crate::prepare::Prepared;

/// The light of the last stage.
#[derive(Default)]
pub struct IlluminationCache {
    grids: Option<Arc<LevelGrids>>,
    last: Option<Entry>,
    distant: DistantLight,
}

/// Light, what it depends on, and where it was read from.
struct Entry {
    settings: Settings,
    saved: Held,
    kept: Arc<Kept>,
}

/// Everything that light at places depends on.
#[derive(Clone, Debug, PartialEq)]
struct Settings {
    global: GlobalIllumination,
    lights: Vec<ResolvedLight>,
    transfer_function: TransferFunction,
    /// The isovalues, if light depends on them.
    isovalues: Vec<Isovalue>,
    region: Region,
    perturbation: Perturbation,
    filter: Filter,
    gradient: Gradient,
    step: f64,
    /// Whether every surface is found, whatever the step.
    is_exact: bool,
    component: usize,
}

impl Settings {
    fn new(prepared: &Prepared, global: &GlobalIllumination) -> Self {
        let (stage, volume) = (prepared.stage, prepared.volume);
        let mut isovalues = stage.isovalues(prepared.number);
        if isovalues.iter().all(|iso| iso.color.is_none()) && global.surfaces == PlacesOn::Own {
            isovalues.clear();
        }
        // What is seen through a surface has no part in its light.
        isovalues.iter_mut().for_each(|iso| iso.opacity = 1.0);
        let (mut global, mut lights) = (global.clone(), stage.lights.clone());
        // Places know nothing of what lies between them, nor of where their light is kept.
        global.interpolation = IlluminationInterpolation::default();
        (global.file, global.baked) = (None, Held::default());
        if global.harmonics().is_some() {
            // Whatever the light, its transfer is the same.
            global.environment = Environment::Dark;
            if let IlluminationBasis::Harmonics(transfer) = &mut global.basis {
                transfer.window = HarmonicWindow::None;
            }
            lights.clear();
        }
        Self {
            global,
            lights,
            transfer_function: volume.transfer_function.clone(),
            isovalues,
            region: prepared.region.clone(),
            perturbation: volume.perturbation.clone(),
            filter: stage.quality.filter,
            gradient: stage.quality.gradient,
            step: stage.step,
            is_exact: stage.finds_every_surface(volume),
            component: volume.component,
        }
    }

    /// The mark of light in these settings: it does not tell between those that change light by roundings alone.
    fn mark(&self, volume: &Volume) -> u64 {
        let mut of = self.clone();
        if of.is_exact {
            of.step = 0.0;
        }
        if of.global.normals != SurfaceNormals::Data {
            of.gradient = Gradient::default();
        }
        let mut mark = Mark::new();
        mark.add_volume(volume);
        if let Environment::Image(image) = &mut of.global.environment
            && let Some(map) = image.map.take()
        {
            // Its light, whatever the name of its file.
            image.source = SkySource::Day;
            mark.add_sky(&map);
        }
        mark.add(&of);
        mark.number()
    }
}

impl IlluminationCache {
    /// The light from far away, if that is what places know of.
    pub fn distant(&mut self, stage: &Stage, global: &GlobalIllumination) -> Option<Distant> {
        Some(self.distant.of(stage, global.harmonics()?))
    }

    /// The light of a volume that is made ready, in such settings: the last one, if nothing that it depends on has changed, and
    /// else what was saved of it.
    ///
    /// # Errors
    /// [`SavedLightError`] if what was saved is not read, or is other light.
    pub fn kept(&mut self, prepared: &Prepared, global: &GlobalIllumination) -> Result<Arc<Kept>, SavedLightError> {
        let grids = prepared.tables.ranges.as_ref().map(|ranges| match &self.grids {
            Some(grids) if grids.are_of(ranges) => grids.clone(),
            _ => Arc::new(LevelGrids::new(ranges.clone())),
        });
        self.grids.clone_from(&grids);
        let settings = Settings::new(prepared, global);
        let volume: &Arc<Volume> = &prepared.volume.volume;
        if let Some(Entry { settings: of, saved, kept }) = &self.last
            && *of == settings
            && *saved == global.baked
            && kept.is_of(volume)
        {
            return Ok(kept.clone());
        }
        let lattice = (global.method == IlluminationMethod::Lattice)
            .then(|| Lattice::new(prepared.grid().dims(), global.resolution));
        let levels = match global.surfaces {
            PlacesOn::Own => vec![None],
            PlacesOn::Drawn => {
                let drawn = prepared.stage.isovalues(prepared.number);
                drawn.iter().map(|iso| Some(iso.value as f32)).collect()
            }
        };
        let coefficients = global.harmonics().map(|(bands, _)| bands.coefficients());
        let surface = |(lattice, level): (&Lattice, _)| {
            let bricks = || Bricks::new(lattice.dims, coefficients.is_some());
            Ok::<_, OutOfMemory>(Surface { level, sides: [bricks()?, bricks()?] })
        };
        let surfaces = lattice.iter().flat_map(|lattice| levels.iter().map(move |level| (lattice, *level)));
        let surfaces = surfaces.map(surface).collect::<Result<_, _>>()?;
        let kept =
            Arc::new(Kept { volume: volume.clone(), grids, lattice, coefficients, paths: global.samples, surfaces });
        if kept.lattice.is_some() {
            match (&global.baked.0, &global.file) {
                (Some(saved), file) => {
                    let file = file.as_deref().unwrap_or(Path::new(&saved.name));
                    saved::load(&kept, settings.mark(volume), saved, file)?;
                }
                (None, Some(file)) => return Err(SavedLightError::Unread { file: file.clone() }),
                (None, None) => {}
            }
        }
        self.last = Some(Entry { settings, saved: global.baked.clone(), kept: kept.clone() });
        Ok(kept)
    }

    /// The light that is kept, as a volume; `None` if none is.
    ///
    /// # Errors
    /// As [`saved::save`].
    pub fn save(&self) -> Result<Option<Volume>, RenderError> {
        let Some(Entry { settings, kept, .. }) = &self.last else { return Ok(None) };
        saved::save(kept, settings.mark(&kept.volume))
    }
}
