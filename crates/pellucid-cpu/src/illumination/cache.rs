//! Light at places, kept while nothing that it depends on changes: it does not depend on the camera nor on isovalues (G-25).

use std::sync::Arc;

use pellucid_field::{Filter, Gradient, Volume};
use pellucid_optics::{Environment, Perturbation, ResolvedLight, TransferFunction};
use pellucid_scene::{
    GlobalIllumination, HarmonicWindow, IlluminationBasis, IlluminationMethod, Isovalue, PlacesOn, Region, Stage,
};

use super::bricks::Bricks;
use super::distant::{Distant, DistantLight};
use super::lattice::Lattice;
use super::level_grids::LevelGrids;
use crate::prepare::Prepared;

/// The light of the last stage.
#[derive(Default)]
pub struct IlluminationCache {
    grids: Option<Arc<LevelGrids>>,
    kept: Option<(Settings, Arc<Kept>)>,
    distant: DistantLight,
}

/// What is kept of light.
pub struct Kept {
    volume: Arc<Volume>,
    /// What rays leap over.
    pub grids: Option<Arc<LevelGrids>>,
    /// The places, if any are kept.
    pub lattice: Option<Lattice>,
    /// The surfaces that they are on.
    pub surfaces: Vec<Surface>,
}

/// Light of a lattice's places on a surface that is drawn, or each on its own.
pub struct Surface {
    /// The isovalue, if it is the same for all.
    pub level: Option<f32>,
    /// Light on the side of lower values, and on the other.
    pub sides: [Bricks; 2],
}

impl Kept {
    /// The sides of surfaces of whose places anything is known.
    pub fn touched(&self) -> impl Iterator<Item = (&Surface, usize)> {
        let sides = self.surfaces.iter().flat_map(|surface| [(surface, 0), (surface, 1)]);
        sides.filter(|(surface, side)| surface.sides[*side].are_touched())
    }

    /// The surface of an isovalue.
    pub fn surface(&self, level: f32) -> Option<&Surface> {
        self.surfaces.iter().find(|surface| surface.level.is_none_or(|of| of == level))
    }

    fn is_of(&self, volume: &Arc<Volume>) -> bool {
        Arc::ptr_eq(&self.volume, volume)
    }
}

/// Everything that light at places depends on.
#[derive(PartialEq)]
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
    component: usize,
}

impl Settings {
    fn new(prepared: &Prepared, global: &GlobalIllumination) -> Self {
        let (stage, volume) = (prepared.stage, prepared.volume);
        let mut isovalues = stage.isovalues(prepared.number);
        if isovalues.iter().all(|iso| iso.color.is_none()) && global.surfaces == PlacesOn::Own {
            isovalues.clear();
        }
        let (mut global, mut lights) = (global.clone(), stage.lights.clone());
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
            component: volume.component,
        }
    }
}

impl IlluminationCache {
    /// The light from far away, if that is what places know of.
    pub fn distant(&mut self, stage: &Stage, global: &GlobalIllumination) -> Option<Distant> {
        Some(self.distant.of(stage, global.harmonics()?))
    }

    /// The light of a volume that is made ready, in such settings: the last one, if nothing that it depends on has changed.
    pub fn kept(&mut self, prepared: &Prepared, global: &GlobalIllumination) -> Arc<Kept> {
        let grids = prepared.tables.ranges.as_ref().map(|ranges| match &self.grids {
            Some(grids) if grids.are_of(ranges) => grids.clone(),
            _ => Arc::new(LevelGrids::new(ranges.clone())),
        });
        self.grids.clone_from(&grids);
        let settings = Settings::new(prepared, global);
        let of_volume: &Arc<Volume> = &prepared.volume.volume;
        match &self.kept {
            Some((of, kept)) if *of == settings && kept.is_of(of_volume) => kept.clone(),
            _ => {
                let lattice = (global.method == IlluminationMethod::Lattice)
                    .then(|| Lattice::new(prepared.grid().dims(), global.resolution));
                let levels = match global.surfaces {
                    PlacesOn::Own => vec![None],
                    PlacesOn::Drawn => {
                        let drawn = prepared.stage.isovalues(prepared.number);
                        drawn.iter().map(|iso| Some(iso.value as f32)).collect()
                    }
                };
                let surface = |(lattice, level): (&Lattice, _)| {
                    let sides = [(); 2].map(|()| Bricks::new(lattice.dims, global.harmonics().is_some()));
                    Surface { level, sides }
                };
                let surfaces = lattice.iter().flat_map(|lattice| levels.iter().map(move |level| (lattice, *level)));
                let surfaces = surfaces.map(surface).collect();
                let kept = Arc::new(Kept { volume: of_volume.clone(), grids, lattice, surfaces });
                self.kept = Some((settings, kept.clone()));
                kept
            }
        }
    }
}
