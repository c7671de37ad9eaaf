//! Settings of a made-up technique.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Technique;
use super::needs::{LightPath, Needs};
use super::settings::Settings;

/// Settings of a technique that draws one gray.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MadeUp {
    /// How bright it is. Default 0.
    pub gray: f32,
}

impl Settings for MadeUp {
    fn name(&self) -> &'static str {
        "made_up"
    }

    fn needs(&self) -> Needs {
        Needs {
            light: LightPath::Arrives,
            ambient: false,
            classification: false,
            extinction_color: false,
            shadows: false,
            several_volumes: true,
            overlap: false,
            data_colors: false,
            adaptive: false,
            jitter: false,
            front_to_back: false,
            blending: false,
            frames: 1,
        }
    }

    fn plain(&self) -> Technique {
        Technique::MadeUp(Self::default())
    }
}
