//! Settings of the ray caster (chapter 7).

use pellucid_optics::{Environment, Lighting};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Technique;
use super::mode::Mode;
use super::needs::{LightPath, Needs};
use super::settings::Settings;
use crate::Look;

/// Settings of the ray caster.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RayCast {
    /// What becomes of the samples along a ray. Default composite.
    pub mode: Mode,
}

impl Settings for RayCast {
    fn name(&self) -> &'static str {
        "ray_cast"
    }

    fn needs(&self) -> Needs {
        let (composites, meets_surfaces) = (self.mode == Mode::Composite, matches!(self.mode, Mode::Isosurface(_)));
        let by_lights = self.mode.global_illumination().is_none();
        Needs {
            light: LightPath::Arrives,
            ambient: by_lights,
            classification: composites,
            extinction_color: composites,
            shadows: composites || meets_surfaces && by_lights,
            several_volumes: true,
            overlap: !meets_surfaces,
            data_colors: composites,
            adaptive: true,
            jitter: true,
            front_to_back: true,
            blending: false,
            frames: 1,
        }
    }

    fn mode(&self) -> &Mode {
        &self.mode
    }

    fn mode_mut(&mut self) -> Option<&mut Mode> {
        Some(&mut self.mode)
    }

    fn environment(&self) -> Option<&Environment> {
        self.mode.global_illumination().map(|global| &global.environment)
    }

    fn environment_mut(&mut self) -> Option<&mut Environment> {
        self.mode.global_illumination_mut().map(|global| &mut global.environment)
    }

    fn plain(&self) -> Technique {
        Technique::RayCast(Self { mode: self.mode.plain() })
    }

    fn light_by(&mut self, look: Look, lighting: &mut Lighting) {
        // Surfaces lie half in the shadow of their own matter, and light that is scattered again is lost.
        let gain = if look == Look::Cloud { 2.5 } else { 1.6 };
        lighting.lights.iter_mut().for_each(|light| light.intensity *= gain);
    }
}
