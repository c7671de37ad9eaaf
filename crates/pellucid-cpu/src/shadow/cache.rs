//! Volumes of light, kept while neither lights nor what holds them back has changed.

use std::sync::Arc;

use pellucid_optics::ResolvedLight;
use pellucid_plan::Tables;
use pellucid_scene::{Control, Overlap, Region};

use super::LightVolume;
use crate::RenderError;
use crate::lanes::InstructionSet;
use crate::prepare::Prepared;

/// The last light in volumes.
#[derive(Default)]
pub struct LightCache(Option<(LightSettings, Arc<Vec<LightVolume>>)>);

/// Everything that light volumes depend on besides tables.
struct LightSettings {
    volumes: Vec<(Arc<Tables>, Region)>,
    overlap: Overlap,
    lights: Vec<ResolvedLight>,
    resolution: f64,
}

impl LightSettings {
    fn are(&self, layers: &[Prepared], resolution: f64) -> bool {
        let stage = layers[0].stage;
        let is_of = |((tables, region), layer): (&(Arc<Tables>, Region), &Prepared)| {
            Arc::ptr_eq(tables, &layer.tables) && *region == layer.region
        };
        self.volumes.len() == layers.len()
            && self.volumes.iter().zip(layers).all(is_of)
            && self.overlap == stage.overlap
            && self.lights == stage.lights
            && self.resolution == resolution
    }
}

impl LightCache {
    /// The light in the volumes of a stage, in the order in which they are merged, if it asks for such: the last one, if
    /// neither lights nor what holds them back has changed.
    ///
    /// # Errors
    /// As [`LightVolume::new`].
    pub fn lights(
        &mut self,
        layers: &[Prepared],
        set: InstructionSet,
        control: &Control,
    ) -> Result<Option<Arc<Vec<LightVolume>>>, RenderError> {
        let stage = layers[0].stage;
        let Some(resolution) = stage.light_resolution() else { return Ok(None) };
        if let Some((settings, lights)) = &self.0
            && settings.are(layers, resolution)
        {
            return Ok(Some(lights.clone()));
        }
        let volume = |light: (usize, &ResolvedLight)| LightVolume::new(layers, light, resolution, set, control);
        let made: Arc<Vec<LightVolume>> =
            Arc::new(stage.lights.iter().enumerate().map(volume).collect::<Result<_, _>>()?);
        let volumes = layers.iter().map(|layer| (layer.tables.clone(), layer.region.clone())).collect();
        let (overlap, lights) = (stage.overlap, stage.lights.clone());
        self.0 = Some((LightSettings { volumes, overlap, lights, resolution }, made.clone()));
        Ok(Some(made))
    }
}
