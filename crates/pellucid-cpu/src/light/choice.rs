//! Light on a prepared volume.

use pellucid_field::Sampler;
use pellucid_scene::Mode;

use super::blinn_phong::BlinnPhong;
use super::lighting::{Answer, Lighting};
use super::lights::Lights;
use super::scatter::Scatter;
use crate::lanes::Lanes;
use crate::prepare::Prepared;
use crate::shadow::{LightVolume, LightVolumes, Media, Shadow, Surfaces, ToLights};

impl Prepared<'_> {
    /// Light on samples, if they are lit at all, and in what shadow.
    pub fn lighting<'a, S: Lanes>(
        &'a self,
        shadow: impl FnOnce() -> Option<Box<dyn Shadow<S> + 'a>>,
    ) -> Option<Lighting<'a, S>> {
        let (weight, stage, scatter) = (self.volume.gradient_weight, self.stage, self.scatter());
        if self.volume.material.is_none() && scatter.is_none() {
            return None;
        }
        let material = self.volume.material.unwrap_or_default();
        Some(Lighting {
            lights: Lights::new(&stage.lights, self.grid().world_from_index()),
            shadow: shadow(),
            chroma: stage.chroma(self.volume),
            answer: Answer::new(BlinnPhong { material, weight, ambient: stage.ambient }, scatter),
        })
    }

    /// How samples scatter, if they are not surfaces.
    pub fn scatter(&self) -> Option<Scatter<'_>> {
        self.tables.light.scatter.as_ref().map(|table| Scatter::new(&self.volume.scattering, table))
    }

    /// What the volume itself leaves of lights: what volumes of light remember, or what rays to them find.
    pub fn shadow<'a, S: Lanes>(
        &'a self,
        s: S,
        sampler: &Sampler<'a>,
        lights: Option<&'a [LightVolume]>,
    ) -> Option<Box<dyn Shadow<S> + 'a>> {
        if let Some(lights) = lights {
            return Some(Box::new(LightVolumes::new(lights, self.grid())));
        }
        let shadows = self.shadows.as_ref()?;
        let ways = ToLights::new(self, shadows.length);
        Some(match self.stage.mode() {
            Mode::Isosurface(_) => {
                let away = self.stage.shadow_offset(self.volume, shadows.length) as f32;
                Box::new(Surfaces { medium: self.surfaces(s, self.any(sampler.clone()), None), ways, away })
            }
            _ => Box::new(Media { medium: self.shadowing(s, sampler.clone())?, ways }),
        })
    }
}
