//! Volumes of light, kept while neither lights nor what holds them back has changed.

use std::sync::Arc;

use pellucid_optics::{ResolvedLight, ShadowVolume, Shadows};
use pellucid_plan::Tables;
use pellucid_scene::{Control, Mode, Region};

use super::LightVolume;
use crate::RenderError;
use crate::lanes::InstructionSet;
use crate::prepare::Prepared;

/// The last light in a volume.
#[derive(Default)]
pub struct LightCache(Option<(LightSettings, Arc<Vec<LightVolume>>)>);

/// Everything that light volumes depend on besides tables.
struct LightSettings {
    tables: Arc<Tables>,
    lights: Vec<ResolvedLight>,
    region: Region,
    resolution: f64,
}

impl LightSettings {
    fn are(&self, prepared: &Prepared, resolution: f64) -> bool {
        Arc::ptr_eq(&self.tables, &prepared.tables)
            && self.lights == prepared.stage.lights
            && self.region == prepared.region
            && self.resolution == resolution
    }
}

impl LightCache {
    /// The light in the volume of a stage, if it asks for such: the last one, if neither lights nor what
    /// holds them back has changed.
    ///
    /// # Errors
    /// As [`LightVolume::new`].
    pub fn lights(
        &mut self,
        prepared: &Prepared,
        set: InstructionSet,
        control: &Control,
    ) -> Result<Option<Arc<Vec<LightVolume>>>, RenderError> {
        let Shadows::Volume(ShadowVolume { resolution }) = prepared.stage.shadows else { return Ok(None) };
        if *prepared.stage.mode() != Mode::Composite || !prepared.is_lit() {
            return Ok(None);
        }
        if let Some((settings, lights)) = &self.0
            && settings.are(prepared, resolution)
        {
            return Ok(Some(lights.clone()));
        }
        let (tables, lights, region) =
            (prepared.tables.clone(), prepared.stage.lights.clone(), prepared.region.clone());
        let volume = |light: (usize, &ResolvedLight)| LightVolume::new(prepared, light, resolution, set, control);
        let made: Arc<Vec<LightVolume>> = Arc::new(lights.iter().enumerate().map(volume).collect::<Result<_, _>>()?);
        self.0 = Some((LightSettings { tables, lights, region, resolution }, made.clone()));
        Ok(Some(made))
    }
}
