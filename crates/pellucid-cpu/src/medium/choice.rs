//! The medium of a prepared volume, in the types that loops are compiled for.

use pellucid_field::Sampler;
use pellucid_scene::Classification;

use super::{Emission, Integrals, Isolevels, Level, OneGrid, ValueOptics};
use crate::classify::{Classify, Lookup, Post, Pre, PreEach, Segments};
use crate::field::{Any, Field, Moved};
use crate::lanes::Lanes;
use crate::light::Lighting;
use crate::paint::Paint;
use crate::prepare::Prepared;
use crate::reconstruct::WithField;
use crate::vary::{Placed, Uniform, Varied, VariedSamples, Vary};

/// A medium between samples and lights.
pub type Shadowing<'a, S> = OneGrid<'a, S, Any<'a, S>, VariedSamples<Post<'a>, Option<Varied<'a>>>>;

/// What is to be done with a medium of whatever type.
pub trait WithMedium<'a, S: Lanes> {
    /// What comes of it.
    type Output;

    /// Does it with optics of single samples.
    fn samples<F: Field<S> + 'a, C: Classify<S> + 'a>(self, medium: OneGrid<'a, S, F, C>) -> Self::Output;

    /// Does it with optics of segments.
    fn segments<F: Field<S> + 'a, V: Vary + 'a>(self, medium: OneGrid<'a, S, F, Integrals<'a, V>>) -> Self::Output;
}

impl Prepared<'_> {
    /// Does something with the medium. Post-classified and pre-integrated fields of the types most data have are
    /// compiled into the loops; what is classified before, or varies, asks its field by one virtual call a packet.
    pub fn with_medium<'a, S: Lanes, W: WithMedium<'a, S>>(
        &'a self,
        s: S,
        sampler: Sampler<'a>,
        lighting: Option<Lighting<'a, S>>,
        with: W,
    ) -> W::Output {
        let plain = self.stage.quality.classification != Classification::Pre && self.placed().is_none();
        match plain {
            true => self.with_field(sampler, Plain { prepared: self, s, lighting, with }),
            false => self.with_any_medium(s, sampler, lighting, with),
        }
    }

    /// The same with a field that is asked by one virtual call a packet, whatever its type.
    pub fn with_any_medium<'a, S: Lanes, W: WithMedium<'a, S>>(
        &'a self,
        s: S,
        sampler: Sampler<'a>,
        lighting: Option<Lighting<'a, S>>,
        with: W,
    ) -> W::Output {
        if self.stage.quality.classification == Classification::Pre {
            let classifier = self.classified_voxels(sampler.clone());
            let field = self.any(sampler);
            return match self.placed() {
                Some(placed) => {
                    let optics = VariedSamples { classifier, vary: placed };
                    with.samples(self.one_grid(s, field, optics, lighting))
                }
                None => with.samples(self.one_grid(s, field, classifier, lighting)),
            };
        }
        let field = self.any(sampler);
        let Some(placed) = self.placed() else {
            return Plain { prepared: self, s, lighting, with }.with(field);
        };
        match &self.tables.preintegration {
            Some(table) => {
                let optics = Integrals { table: Segments(table), vary: placed };
                with.segments(self.one_grid(s, field, optics, lighting))
            }
            None => {
                let optics = VariedSamples { classifier: Post(self.lookup()), vary: placed };
                with.samples(self.one_grid(s, field, optics, lighting))
            }
        }
    }

    fn classified_voxels<'a, S: Lanes>(&'a self, sampler: Sampler<'a>) -> Pre<'a, S> {
        let moved = Moved { sampler: sampler.clone(), displacer: self.tables.displacer.as_ref() };
        let (volume, component) = (&*self.volume.volume, self.volume.component);
        let each =
            PreEach { table: &self.tables.step_table, volume, component, filter: self.stage.quality.filter, moved };
        Pre { field: self.any(sampler), lookup: Lookup::of_steps(&self.tables.step_table), each }
    }

    /// The medium with a field, optics, and light on it.
    pub fn one_grid<'a, S: Lanes, F: Field<S>, O>(
        &'a self,
        s: S,
        field: F,
        optics: O,
        lighting: Option<Lighting<'a, S>>,
    ) -> OneGrid<'a, S, F, O> {
        let (skip, levels) = (self.grids.skip.as_ref(), self.grids.levels.as_ref());
        OneGrid { s, field, optics, lighting, cuts: self.cuts(), skip, levels, chroma: self.stage.chroma(self.volume) }
    }

    /// What holds light back on its way to samples, steps of shadow rays at a time, if such are cast.
    pub fn shadowing<'a, S: Lanes>(&'a self, s: S, sampler: Sampler<'a>) -> Option<Shadowing<'a, S>> {
        let shadows = self.shadows.as_ref()?;
        // Light is lost in a place, whatever the colours of its voxels.
        let optics = VariedSamples { classifier: Post(Lookup::of_steps(&shadows.table)), vary: self.varied() };
        Some(self.one_grid(s, self.any(sampler), optics, None))
    }

    /// The isosurfaces of the volume, classified, in ascending order.
    pub fn surfaces<'a, S: Lanes, F: Field<S>>(
        &'a self,
        s: S,
        field: F,
        lighting: Option<Lighting<'a, S>>,
    ) -> OneGrid<'a, S, F, Isolevels> {
        let tf = &self.volume.transfer_function;
        let each = self.stage.isovalues(self.number).iter().map(|iso| Level::new(iso, tf)).collect();
        self.one_grid(s, field, Isolevels { each, is_exact: self.stage.finds_every_surface(self.volume) }, lighting)
    }

    /// ValueOptics that stand for whole rays, `opaque` or as the transfer function has them.
    pub fn valued<'a, S: Lanes, F: Field<S>>(
        &'a self,
        s: S,
        field: F,
        opaque: bool,
    ) -> OneGrid<'a, S, F, ValueOptics<'a>> {
        self.one_grid(s, field, ValueOptics { table: Lookup::of_table(&self.tables.table), opaque }, None)
    }

    /// The medium as it shines, without holding light back.
    pub fn shining<'a, S: Lanes>(&'a self, s: S, sampler: Sampler<'a>) -> OneGrid<'a, S, Any<'a, S>, Emission<'a>> {
        let step_ratio = (self.stage.step / self.volume.unit_distance()) as f32;
        let optics = Emission { table: Lookup::of_table(&self.tables.table), step_ratio };
        self.one_grid(s, self.any(sampler), optics, None)
    }

    /// The medium of a radiograph: opacities of single steps.
    pub fn radiograph<'a, S: Lanes>(&'a self, s: S, sampler: Sampler<'a>) -> OneGrid<'a, S, Any<'a, S>, Post<'a>> {
        let optics = Post(Lookup::of_steps(&self.tables.step_table));
        self.one_grid(s, self.any(sampler), optics, None)
    }

    /// What of optics depends on the place, if anything does.
    fn placed(&self) -> Option<Placed<'_>> {
        let (paint, varied) = (self.paint(), self.varied());
        (paint.is_some() || varied.is_some()).then_some(Placed { paint, varied })
    }

    /// The colours of voxels, if they are drawn in them.
    pub fn paint(&self) -> Option<Paint<'_>> {
        self.colors.as_deref().map(Paint)
    }

    /// What varies optics, if anything does.
    pub fn varied(&self) -> Option<Varied<'_>> {
        let chroma = self.stage.chroma(self.volume);
        self.tables.variation.as_ref().map(|variation| Varied { variation, chroma })
    }

    /// Associated colours of one step and, if steps adapt to the data, of longer ones.
    fn lookup(&self) -> Lookup<'_> {
        match &self.tables.stride_entries {
            Some(entries) => Lookup::of_strides(entries, self.tables.step_table.nodes()),
            None => Lookup::of_steps(self.step_table()),
        }
    }
}

/// A medium whose optics do not vary, once its field is known.
struct Plain<'a, S, W> {
    prepared: &'a Prepared<'a>,
    s: S,
    lighting: Option<Lighting<'a, S>>,
    with: W,
}

impl<'a, S: Lanes, W: WithMedium<'a, S>> WithField<'a, S> for Plain<'a, S, W> {
    type Output = W::Output;

    fn with<F: Field<S> + 'a>(self, field: F) -> Self::Output {
        let Self { prepared, s, lighting, with } = self;
        match &prepared.tables.preintegration {
            Some(table) => {
                let optics = Integrals { table: Segments(table), vary: Uniform };
                with.segments(prepared.one_grid(s, field, optics, lighting))
            }
            None => with.samples(prepared.one_grid(s, field, Post(prepared.lookup()), lighting)),
        }
    }
}
