//! The integrator of a stage's mode.

use pellucid_field::Sampler;
use pellucid_scene::{Combine, Mode};

use crate::RenderError;
use crate::classify::Classify;
use crate::composite::{Accumulation, Composite, PreIntegrated};
use crate::field::Field;
use crate::illumination::{Bake, Global, Globally, Illuminate};
use crate::integrator::Integrator;
use crate::isosurface::Isosurfaces;
use crate::lanes::{InstructionSet, Lanes, dispatch};
use crate::light::Lighting;
use crate::medium::{Integrals, OneGrid, ValueOptics, WithMedium};
use crate::prepare::Prepared;
use crate::projection::{Additive, Average, Extreme, XRay};
use crate::reconstruct::WithField;
use crate::shadow::LightVolume;
use crate::slice::SlicePlane;
use crate::vary::Vary;

impl Prepared<'_> {
    /// The integrator of the stage's mode, for an instruction set, in the light of volumes, or in all light there is, if
    /// there are such.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn integrator<'a>(
        &'a self,
        set: InstructionSet,
        lights: Option<&'a [LightVolume]>,
        global: Option<Globally<'a>>,
    ) -> Result<Box<dyn Integrator + 'a>, RenderError> {
        let sampler = self.sampler()?;
        dispatch!(set, s => match global {
            Some(global) => {
                let illumination = Box::new(Global::new(s, self, global)?);
                let mode = IsosurfaceMode { prepared: self, s, lighting: None, illumination: Some(illumination) };
                Ok(self.with_field(sampler, mode))
            }
            None => Ok(self.integrator_in(s, sampler, lights)),
        })
    }

    /// What finds light at all places of a lattice.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn bake<'a>(&'a self, set: InstructionSet, global: Globally<'a>) -> Result<Box<dyn Bake + 'a>, RenderError> {
        dispatch!(set, s => Ok(Box::new(Global::new(s, self, global)?)))
    }

    fn integrator_in<'a, S: Lanes>(
        &'a self,
        s: S,
        sampler: Sampler<'a>,
        lights: Option<&'a [LightVolume]>,
    ) -> Box<dyn Integrator + 'a> {
        match self.stage.mode() {
            Mode::Composite => {
                let lighting = self.lighting(|| self.shadow(s, &sampler, lights));
                self.with_medium(s, sampler, lighting, Composited(self.accumulation()))
            }
            Mode::Isosurface(_) => {
                let lighting = self.lighting(|| self.shadow(s, &sampler, lights));
                self.with_field(sampler, IsosurfaceMode { prepared: self, s, lighting, illumination: None })
            }
            _ => self.projection(s, sampler),
        }
    }

    /// The integrator of a mode whose samples have no order.
    pub fn projection<'a, S: Lanes>(&'a self, s: S, sampler: Sampler<'a>) -> Box<dyn Integrator + 'a> {
        let valued = |sampler, opaque| self.valued(s, self.any(sampler), opaque);
        match self.stage.mode() {
            Mode::Maximum | Mode::Minimum => self.with_field(sampler, Extremes { prepared: self, s }),
            Mode::Additive => Box::new(Additive { medium: self.shining(s, sampler) }),
            Mode::XRay => Box::new(XRay { medium: self.radiograph(s, sampler) }),
            Mode::Slice(slice) if slice.thickness == 0.0 => {
                let (point, normal) = self.stage.slice_plane(self.volume, slice);
                Box::new(SlicePlane::new(valued(sampler, true), self.grid(), point, normal))
            }
            Mode::Slice(slice) => match slice.combine {
                Combine::Maximum => Box::new(self.extreme(valued(sampler, true), false)),
                Combine::Minimum => Box::new(self.extreme(valued(sampler, true), true)),
                Combine::Average => Box::new(Average { medium: valued(sampler, true) }),
            },
            Mode::Average | Mode::Composite | Mode::Isosurface(_) => {
                Box::new(Average { medium: valued(sampler, false) })
            }
        }
    }

    /// How light accumulates along rays.
    pub fn accumulation(&self) -> Accumulation {
        let early_termination = self.stage.quality.early_termination;
        Accumulation { chroma: self.stage.chroma(self.volume), early_termination }
    }

    fn extreme<'a, S: Lanes, F: Field<S> + 'a>(
        &'a self,
        medium: OneGrid<'a, S, F, ValueOptics<'a>>,
        minimum: bool,
    ) -> Extreme<'a, S, F> {
        Extreme { medium, blocks: self.grids.extremes.as_deref(), minimum }
    }

    /// Shaded isosurfaces of the volume.
    pub fn isosurfaces<'a, S: Lanes, F: Field<S>>(
        &'a self,
        s: S,
        field: F,
        lighting: Option<Lighting<'a, S>>,
        illumination: Option<Box<dyn Illuminate<S> + 'a>>,
    ) -> Isosurfaces<'a, S, F> {
        let early_termination = self.stage.quality.early_termination;
        Isosurfaces { medium: self.surfaces(s, field, lighting), illumination, early_termination }
    }
}

/// A medium as an integrator, whose light accumulates so.
pub struct Composited(pub Accumulation);

impl<'a, S: Lanes> WithMedium<'a, S> for Composited {
    type Output = Box<dyn Integrator + 'a>;

    fn samples<F: Field<S> + 'a, C: Classify<S> + 'a>(self, medium: OneGrid<'a, S, F, C>) -> Self::Output {
        Box::new(Composite { medium, accumulation: self.0 })
    }

    fn segments<F: Field<S> + 'a, V: Vary + 'a>(self, medium: OneGrid<'a, S, F, Integrals<'a, V>>) -> Self::Output {
        Box::new(PreIntegrated { medium, accumulation: self.0 })
    }
}

/// Isosurfaces, once the field is known.
struct IsosurfaceMode<'a, S: Lanes> {
    prepared: &'a Prepared<'a>,
    s: S,
    lighting: Option<Lighting<'a, S>>,
    illumination: Option<Box<dyn Illuminate<S> + 'a>>,
}

impl<'a, S: Lanes> WithField<'a, S> for IsosurfaceMode<'a, S> {
    type Output = Box<dyn Integrator + 'a>;

    fn with<F: Field<S> + 'a>(self, field: F) -> Self::Output {
        Box::new(self.prepared.isosurfaces(self.s, field, self.lighting, self.illumination))
    }
}

/// Projections of extremes, once the field is known.
struct Extremes<'a, S> {
    prepared: &'a Prepared<'a>,
    s: S,
}

impl<'a, S: Lanes> WithField<'a, S> for Extremes<'a, S> {
    type Output = Box<dyn Integrator + 'a>;

    fn with<F: Field<S> + 'a>(self, field: F) -> Self::Output {
        let Self { prepared, s } = self;
        let minimum = *prepared.stage.mode() == Mode::Minimum;
        Box::new(prepared.extreme(prepared.valued(s, field, false), minimum))
    }
}
