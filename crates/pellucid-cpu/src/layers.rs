//! A stage with several volumes: each is made ready by itself, and all are drawn together.

use pellucid_field::Sampler;
use pellucid_plan::{Merging, merge_order};
use pellucid_scene::{Mode, Stage};

use crate::RenderError;
use crate::apart::{Apart, Isosurfaced};
use crate::classify::Classify;
use crate::field::Field;
use crate::integrator::Integrator;
use crate::isosurface::Surfaced;
use crate::lanes::{InstructionSet, Lanes, dispatch};
use crate::medium::{Integrals, Layer, Many, OneGrid, Segmented, WithMedium};
use crate::prepare::{Cache, MOST_STEPS, Prepared};
use crate::shadow::{Across, LightVolume, LightVolumes, Product, Shadow, Surfaces, ToLights, Turn};
use crate::vary::Vary;

/// The volumes of a stage, in the order in which they are merged.
pub struct Layers<'s> {
    stage: &'s Stage,
    each: Vec<Prepared<'s>>,
}

impl<'s> Layers<'s> {
    /// Makes tables and blocks of all layers, or finds them in the cache.
    ///
    /// # Errors
    /// As [`Prepared::new`].
    pub fn new(stage: &'s Stage, cache: &mut Cache) -> Result<Self, RenderError> {
        let corners = || stage.volumes.iter().flat_map(|volume| volume.volume.grid().world_corners());
        let middle = stage.volumes[0].volume.grid().center();
        let steps = 2.0 * corners().map(|corner| corner.distance(middle)).fold(0.0, f64::max) / stage.step;
        if steps >= f64::from(MOST_STEPS) {
            return Err(RenderError::Steps { found: steps, limit: MOST_STEPS });
        }
        let layer = |number| Prepared::new(stage, number, cache);
        Ok(Self { stage, each: merge_order(stage).into_iter().map(layer).collect::<Result<_, _>>()? })
    }

    /// The volumes, made ready.
    pub fn each(&self) -> &[Prepared<'s>] {
        &self.each
    }

    /// The integrator of the stage's mode, for an instruction set, in the light of volumes if there are such.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn integrator<'a>(
        &'a self,
        set: InstructionSet,
        lights: Option<&'a [LightVolume]>,
    ) -> Result<Box<dyn Integrator + 'a>, RenderError> {
        let samplers = self.each.iter().map(Prepared::sampler).collect::<Result<Vec<_>, _>>()?;
        Ok(dispatch!(set, s => self.integrator_in(s, &samplers, lights)))
    }

    fn integrator_in<'a, S: Lanes>(
        &'a self,
        s: S,
        samplers: &[Sampler<'a>],
        lights: Option<&'a [LightVolume]>,
    ) -> Box<dyn Integrator + 'a> {
        let (stage, step) = (self.stage, self.stage.step);
        let layers = || self.each.iter().zip(samplers);
        match stage.mode() {
            Mode::Composite => {
                let layer = |(prepared, sampler): (&'a Prepared, &Sampler<'a>)| {
                    let lighting = prepared.lighting(|| match lights {
                        Some(lights) => Some(Box::new(LightVolumes::new(lights, prepared.grid()))),
                        None => self.shadow(s, prepared, samplers),
                    });
                    prepared.with_medium(s, sampler.clone(), lighting, AsLayer)
                };
                let accumulation = self.each[0].accumulation();
                let (layers, overlap) = (layers().map(layer).collect(), stage.overlap);
                Box::new(Many { s, layers, overlap, accumulation, step })
            }
            Mode::Isosurface(_) => {
                let surfaces = |(prepared, sampler): (&'a Prepared, &Sampler<'a>)| {
                    let lighting = prepared.lighting(|| self.shadow(s, prepared, samplers));
                    let surfaces = prepared.isosurfaces(s, prepared.any(sampler.clone()), lighting, None);
                    Box::new(surfaces) as Box<dyn Surfaced<S> + 'a>
                };
                let early_termination = stage.quality.early_termination;
                Box::new(Isosurfaced { s, layers: layers().map(surfaces).collect(), step, early_termination })
            }
            _ => {
                let projection =
                    |(prepared, sampler): (&'a Prepared, &Sampler<'a>)| prepared.projection(s, sampler.clone());
                Box::new(Apart { s, layers: layers().map(projection).collect(), merging: Merging::of(stage), step })
            }
        }
    }

    /// What all layers leave of lights on their way to samples of one, as rays to them find it.
    fn shadow<'a, S: Lanes>(
        &'a self,
        s: S,
        lit: &Prepared,
        samplers: &[Sampler<'a>],
    ) -> Option<Box<dyn Shadow<S> + 'a>> {
        let turn = |other: &Prepared| Turn::new(other.grid().index_from_world() * lit.grid().world_from_index());
        let length = lit.shadows.as_ref()?.length;
        let casting = || self.each.iter().zip(samplers);
        Some(match self.stage.mode() {
            Mode::Isosurface(_) => {
                let away = self.stage.shadow_offset(lit.volume, length) as f32;
                let surfaces = |(prepared, sampler): (&'a Prepared, &Sampler<'a>)| {
                    let medium = prepared.surfaces(s, prepared.any(sampler.clone()), None);
                    (turn(prepared), Surfaces { medium, ways: ToLights::new(prepared, length), away })
                };
                Box::new(Product(casting().map(surfaces).collect()))
            }
            _ => {
                let layer = |(prepared, sampler): (&'a Prepared, &Sampler<'a>)| {
                    let layer = Box::new(prepared.shadowing(s, sampler.clone())?) as Box<dyn Layer<S> + 'a>;
                    Some((layer, (turn(prepared), ToLights::new(prepared, length))))
                };
                let (layers, ways) = casting().filter_map(layer).unzip();
                Box::new(Across { layers, ways, overlap: self.stage.overlap })
            }
        })
    }
}

/// A medium as one of several layers.
pub struct AsLayer;

impl<'a, S: Lanes> WithMedium<'a, S> for AsLayer {
    type Output = Box<dyn Layer<S> + 'a>;

    fn samples<F: Field<S> + 'a, C: Classify<S> + 'a>(self, medium: OneGrid<'a, S, F, C>) -> Self::Output {
        Box::new(medium)
    }

    fn segments<F: Field<S> + 'a, V: Vary + 'a>(self, medium: OneGrid<'a, S, F, Integrals<'a, V>>) -> Self::Output {
        Box::new(Segmented(medium))
    }
}
