//! The integrator of a stage's mode.

use pellucid_field::Sampler;
use pellucid_scene::{Classification, Combine, Isosurface, Mode};

use crate::RenderError;
use crate::classify::{Lookup, Post, Pre, PreEach, Segments};
use crate::composite::{Accumulation, Composite, PreIntegrated};
use crate::field::{Any, Field, Moved};
use crate::integrator::Integrator;
use crate::isosurface::{Isosurfaces, Level};
use crate::lanes::{InstructionSet, Lanes, dispatch};
use crate::medium::{Integrals, OneGrid};
use crate::prepare::Prepared;
use crate::projection::{Additive, Average, Extreme, XRay};
use crate::reconstruct::WithField;
use crate::scatter::Scatter;
use crate::shadow::{LightVolume, LightVolumes, Media, Shadow, Surfaces, ToLights};
use crate::slice::Plane;
use crate::surface::Surface;
use crate::vary::{Uniform, Varied, VariedSamples};

impl Prepared<'_> {
    /// The integrator of the stage's mode, for an instruction set, in the light of volumes if there are
    /// such.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn integrator<'a>(
        &'a self,
        set: InstructionSet,
        lights: Option<&'a [LightVolume]>,
    ) -> Result<Box<dyn Integrator + 'a>, RenderError> {
        let sampler = self.sampler()?;
        Ok(dispatch!(set, s => self.integrator_in(s, sampler, lights)))
    }

    /// The modes that most pictures have are compiled with the voxel type that most data have
    /// inside their loops. All others ask the field by one virtual call a packet.
    fn integrator_in<'a, S: Lanes>(
        &'a self,
        s: S,
        sampler: Sampler<'a>,
        lights: Option<&'a [LightVolume]>,
    ) -> Box<dyn Integrator + 'a> {
        let classification = self.stage.quality.classification;
        let surface = self.surface(s, &sampler, lights);
        let common = match self.stage.mode() {
            Mode::Composite => classification != Classification::Pre,
            Mode::Maximum | Mode::Minimum | Mode::Isosurface(_) => true,
            _ => false,
        };
        if !common {
            return self.rare(s, sampler, surface);
        }
        if self.tables.displacer.is_some() || self.tables.variation.is_some() {
            return match (self.stage.mode(), self.varied()) {
                (Mode::Composite, Some(varied)) => self.varied_composite(s, self.any(sampler), surface, varied),
                _ => self.common(s, self.any(sampler), surface),
            };
        }
        self.with_field(sampler, Common { prepared: self, s, surface })
    }

    /// What varies optics, if anything does.
    pub fn varied(&self) -> Option<Varied<'_>> {
        let chroma = self.stage.chroma(self.volume);
        self.tables.variation.as_ref().map(|variation| Varied { variation, chroma })
    }

    fn common<'a, S: Lanes, F: Field<S> + 'a>(
        &'a self,
        s: S,
        field: F,
        surface: Option<Surface<'a, S>>,
    ) -> Box<dyn Integrator + 'a> {
        let early_termination = self.stage.quality.early_termination;
        match self.stage.mode() {
            Mode::Maximum => self.extreme(s, field, false, false),
            Mode::Minimum => self.extreme(s, field, true, false),
            Mode::Isosurface(isosurface) => Box::new(Isosurfaces {
                s,
                field,
                surface,
                levels: self.levels(isosurface),
                world_from_index_gradient: self.grid().world_from_index_gradient().as_mat3().to_cols_array_2d(),
                skip: self.grids.skip.as_ref(),
                early_termination,
            }),
            _ => {
                let accumulation = self.accumulation();
                match &self.tables.preintegration {
                    Some(table) => {
                        let optics = Integrals { table: Segments(table), vary: Uniform };
                        Box::new(PreIntegrated { medium: self.one_grid(s, field, optics, surface), accumulation })
                    }
                    None => {
                        let medium = self.one_grid(s, field, Post(self.lookup()), surface);
                        Box::new(Composite { medium, accumulation })
                    }
                }
            }
        }
    }

    fn varied_composite<'a, S: Lanes>(
        &'a self,
        s: S,
        field: Any<'a, S>,
        surface: Option<Surface<'a, S>>,
        varied: Varied<'a>,
    ) -> Box<dyn Integrator + 'a> {
        let accumulation = self.accumulation();
        match &self.tables.preintegration {
            Some(table) => {
                let optics = Integrals { table: Segments(table), vary: varied };
                Box::new(PreIntegrated { medium: self.one_grid(s, field, optics, surface), accumulation })
            }
            None => {
                let optics = VariedSamples { classifier: Post(self.lookup()), varied };
                Box::new(Composite { medium: self.one_grid(s, field, optics, surface), accumulation })
            }
        }
    }

    /// Associated colours of one step and, if steps adapt to the data, of longer ones.
    fn lookup(&self) -> Lookup<'_> {
        match &self.tables.stride_entries {
            Some(entries) => Lookup::of_strides(entries, self.tables.step_table.nodes()),
            None => Lookup::of_steps(self.step_table()),
        }
    }

    fn rare<'a, S: Lanes>(
        &'a self,
        s: S,
        sampler: Sampler<'a>,
        surface: Option<Surface<'a, S>>,
    ) -> Box<dyn Integrator + 'a> {
        let moved = Moved { sampler: sampler.clone(), displacer: self.tables.displacer.as_ref() };
        let field = self.any(sampler);
        match self.stage.mode() {
            Mode::Average => Box::new(Average { s, field, table: Lookup::of_table(&self.tables.table), opaque: false }),
            Mode::Additive => {
                let skip = self.grids.skip.as_ref();
                let step_ratio = (self.stage.step / self.volume.unit_distance()) as f32;
                Box::new(Additive { s, field, table: Lookup::of_table(&self.tables.table), step_ratio, skip })
            }
            Mode::XRay => {
                let skip = self.grids.skip.as_ref();
                Box::new(XRay { s, field, table: Lookup::of_steps(&self.tables.step_table), skip })
            }
            Mode::Slice(slice) if slice.thickness == 0.0 => {
                let (point, normal) = self.stage.slice_plane(self.volume, slice);
                Box::new(Plane::new(s, field, Lookup::of_table(&self.tables.table), self.grid(), point, normal))
            }
            Mode::Slice(slice) => match slice.combine {
                Combine::Maximum => self.extreme(s, field, false, true),
                Combine::Minimum => self.extreme(s, field, true, true),
                Combine::Average => {
                    Box::new(Average { s, field, table: Lookup::of_table(&self.tables.table), opaque: true })
                }
            },
            Mode::Composite | Mode::Maximum | Mode::Minimum | Mode::Isosurface(_) => {
                let (volume, component) = (&*self.volume.volume, self.volume.component);
                let filter = self.stage.quality.filter;
                let each = PreEach { table: &self.tables.step_table, volume, component, filter, moved };
                let lookup = Lookup::of_steps(&self.tables.step_table);
                let voxels = self.any(each.moved.sampler.clone());
                let classifier = Pre { field: voxels, lookup, each };
                let accumulation = self.accumulation();
                match self.varied() {
                    Some(varied) => {
                        let optics = VariedSamples { classifier, varied };
                        Box::new(Composite { medium: self.one_grid(s, field, optics, surface), accumulation })
                    }
                    None => Box::new(Composite { medium: self.one_grid(s, field, classifier, surface), accumulation }),
                }
            }
        }
    }

    fn one_grid<'a, S: Lanes, F: Field<S>, O>(
        &'a self,
        s: S,
        field: F,
        optics: O,
        surface: Option<Surface<'a, S>>,
    ) -> OneGrid<'a, S, F, O> {
        let (skip, levels) = (self.grids.skip.as_ref(), self.grids.levels.as_ref());
        let chroma = self.stage.chroma(self.volume);
        OneGrid { s, field, optics, surface, cuts: self.cuts(), skip, levels, chroma }
    }

    fn accumulation(&self) -> Accumulation {
        let early_termination = self.stage.quality.early_termination;
        Accumulation { chroma: self.stage.chroma(self.volume), early_termination }
    }

    fn extreme<'a, S: Lanes, F: Field<S> + 'a>(
        &'a self,
        s: S,
        field: F,
        minimum: bool,
        opaque: bool,
    ) -> Box<dyn Integrator + 'a> {
        let skip = self.grids.extremes.as_deref();
        Box::new(Extreme { s, field, table: Lookup::of_table(&self.tables.table), skip, minimum, opaque })
    }

    /// Light on samples, if they are lit at all.
    fn surface<'a, S: Lanes>(
        &'a self,
        s: S,
        sampler: &Sampler<'a>,
        lights: Option<&'a [LightVolume]>,
    ) -> Option<Surface<'a, S>> {
        let (weight, stage) = (self.volume.gradient_weight, self.stage);
        let (material, scatter) = (self.volume.material, self.scatter());
        if material.is_none() && scatter.is_none() {
            return None;
        }
        let world_from_index = self.grid().world_from_index();
        let surface =
            Surface::new(material.unwrap_or_default(), weight, &stage.lights, stage.ambient, world_from_index);
        let surface = surface.shadowed(self.shadow(s, sampler, lights), stage.chroma(self.volume));
        Some(match scatter {
            Some(scatter) => surface.scattering(scatter),
            None => surface,
        })
    }

    /// How samples scatter, if they are not surfaces.
    pub fn scatter(&self) -> Option<Scatter<'_>> {
        self.tables.light.scatter.as_ref().map(|table| Scatter::new(&self.volume.scattering, table))
    }

    fn shadow<'a, S: Lanes>(
        &'a self,
        s: S,
        sampler: &Sampler<'a>,
        lights: Option<&'a [LightVolume]>,
    ) -> Option<Box<dyn Shadow<S> + 'a>> {
        if let Some(lights) = lights {
            return Some(Box::new(LightVolumes::new(lights)));
        }
        let shadows = self.shadows.as_ref()?;
        let (ways, skip) = (ToLights::new(self, shadows.length), self.grids.skip.as_ref());
        let field = self.any(sampler.clone());
        Some(match self.stage.mode() {
            Mode::Isosurface(isosurface) => {
                let away = self.stage.shadow_offset(self.volume, shadows.length) as f32;
                Box::new(Surfaces { s, field, levels: self.levels(isosurface), ways, away, skip })
            }
            _ => Box::new(Media { field, table: Lookup::of_steps(&shadows.table), ways, skip, varied: self.varied() }),
        })
    }

    fn levels(&self, isosurface: &Isosurface) -> Vec<Level> {
        let tf = &self.volume.transfer_function;
        isosurface.isovalues.iter().map(|iso| Level::new(iso, tf)).collect()
    }
}

/// The modes that most pictures have, once the field is known.
struct Common<'a, S> {
    prepared: &'a Prepared<'a>,
    s: S,
    surface: Option<Surface<'a, S>>,
}

impl<'a, S: Lanes> WithField<'a, S> for Common<'a, S> {
    type Output = Box<dyn Integrator + 'a>;

    fn with<F: Field<S> + 'a>(self, field: F) -> Self::Output {
        self.prepared.common(self.s, field, self.surface)
    }
}
