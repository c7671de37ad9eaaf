//! The field of a stage, in the type that loops are compiled for.

use pellucid_field::{ComponentView, Filter, Gradient, Linear, Reconstruct, Sampler, Voxels, for_voxels};

use crate::RenderError;
use crate::field::{Any, Bounds, Displaced, Entered, Field, General, Knots, Probe, Separable, Texel, Trilinear, fits};
use crate::lanes::Lanes;
use crate::prepare::Prepared;

/// What is to be done with a field of whatever type.
pub trait WithField<'a, S: Lanes> {
    /// What comes of it.
    type Output;

    /// Does it.
    fn with<F: Field<S> + 'a>(self, field: F) -> Self::Output;
}

impl Prepared<'_> {
    /// The field as its filter reconstructs it.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn sampler(&self) -> Result<Sampler<'_>, RenderError> {
        let (values, component) = &self.values;
        Ok(Sampler::new(values, *component, self.tables.filter)?)
    }

    /// Does something with the field. What most data have, trilinear interpolation of a few voxel types, comes in a
    /// type of its own, compiled into the loops; every other field is asked by one virtual call a packet.
    pub fn with_field<'a, S: Lanes, W: WithField<'a, S>>(&'a self, sampler: Sampler<'a>, with: W) -> W::Output {
        let plain = sampler.filter() == Filter::Linear && self.stage.quality.gradient == Gradient::Central;
        if !plain || self.tables.displacer.is_some() {
            return with.with(self.any(sampler));
        }
        macro_rules! typed {
            ($data:expr) => {
                if let Some(field) = self.trilinear($data) {
                    return with.with(field);
                }
            };
        }
        match self.values.0.voxels() {
            Voxels::U8(data) => typed!(data),
            Voxels::U16(data) => typed!(data),
            Voxels::I16(data) => typed!(data),
            Voxels::F32(data) => typed!(data),
            _ => {}
        }
        with.with(self.any(sampler))
    }

    /// The field of any filter and voxel type, displaced if it is.
    pub fn any<'a, S: Lanes>(&'a self, sampler: Sampler<'a>) -> Any<'a, S> {
        self.any_sloping(sampler, self.stage.quality.gradient)
    }

    /// The same with other gradients than the stage's.
    pub fn any_sloping<'a, S: Lanes>(&'a self, sampler: Sampler<'a>, gradient: Gradient) -> Any<'a, S> {
        let plain = self.undisplaced(sampler, gradient);
        let Some(displacer) = &self.tables.displacer else { return plain };
        let (bounds, grid) = (Bounds::new(self.grid(), &self.region), self.grid());
        Box::new(Entered(Displaced::new(plain, displacer, bounds, grid.world_from_index_gradient())))
    }

    fn undisplaced<'a, S: Lanes>(&'a self, sampler: Sampler<'a>, gradient: Gradient) -> Any<'a, S> {
        let knots = self.knots(sampler.filter());
        let (values, _) = &self.values;
        let boxed = match values.voxels() {
            Voxels::U32(_) | Voxels::I32(_) if !fits(values) => None,
            voxels => for_voxels!(voxels, data => self.boxed(data, &sampler, gradient)),
        };
        boxed.unwrap_or_else(|| Box::new(Entered(General(self.probe(sampler, gradient), knots))))
    }

    fn boxed<'a, S: Lanes, T: Texel>(
        &'a self,
        data: &'a [T],
        sampler: &Sampler<'a>,
        gradient: Gradient,
    ) -> Option<Box<dyn Field<S> + 'a>> {
        let trilinear = self.trilinear(data)?;
        if (sampler.filter(), gradient) == (Filter::Linear, Gradient::Central) {
            return Some(Box::new(Entered(trilinear)));
        }
        let view = self.view(data);
        let bounds = Bounds::new(self.grid(), &self.region);
        let knots = self.knots(sampler.filter());
        let field = Separable::new(view, bounds, gradient, trilinear, knots, self.probe(sampler.clone(), gradient))?;
        Some(Box::new(Entered(field)))
    }

    fn view<'a, T: Texel>(&'a self, data: &'a [T]) -> ComponentView<'a, T> {
        let (values, component) = &self.values;
        ComponentView::new(values, data, *component)
    }

    fn probe<'a, R: Reconstruct>(&'a self, field: R, gradient: Gradient) -> Probe<'a, R> {
        Probe::new(field, self.grid(), &self.region, gradient)
    }

    /// Whether some voxels are absent.
    fn has_holes(&self) -> bool {
        let statistics = self.values.0.statistics();
        statistics.nan + statistics.infinite > 0
    }

    fn knots(&self, filter: Filter) -> Knots {
        Knots::new(filter, self.has_holes())
    }

    fn trilinear<'a, T: Texel>(&'a self, data: &'a [T]) -> Option<Trilinear<'a, T>> {
        let view = self.view(data);
        Trilinear::new(
            view,
            self.has_holes(),
            Bounds::new(self.grid(), &self.region),
            self.probe(Linear(view), Gradient::Central),
        )
    }
}
