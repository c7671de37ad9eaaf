//! All the light of a scene, and the usual arrangements of it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Frame, Light, LightKind, LightModel, Shadows};

/// The lights of a scene and the ambient light among them. The default is a headlight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Lighting {
    /// The lights; their effects add up (5.2-7).
    pub lights: Vec<Light>,
    /// White light from everywhere, which materials reflect by their `ambient`; default 0.3,
    /// not negative (5.4-6).
    #[schemars(range(min = 0.0))]
    pub ambient: f32,
    /// Whether what lies between a light and a sample holds light back; default none. Ray caster only: other
    /// techniques have shadows of their own or none.
    pub shadows: Shadows,
    /// How samples of composited volumes answer light; default surface. Ray caster only.
    pub model: LightModel,
}

impl Default for Lighting {
    fn default() -> Self {
        Self::headlight()
    }
}

impl Lighting {
    /// One light that shines from the eye, of intensity 1.
    pub fn headlight() -> Self {
        Self { lights: vec![from_camera([0.0, 0.0, -1.0], 1.0, true)], ambient: 0.3, ..Self::dark() }
    }

    /// A key light from the upper left, a fill light of less than half its strength from the
    /// right and a weaker one from below and behind: shape by direction, and no side left black,
    /// without ambient light (5.4-3). They move with the camera; only the key makes highlights.
    pub fn three_point() -> Self {
        let key = from_camera([0.5, -0.6, -0.8], 0.9, true);
        let fill = from_camera([-0.8, -0.1, -0.6], 0.35, false);
        let back = from_camera([0.2, 0.7, 0.7], 0.2, false);
        Self { lights: vec![key, fill, back], ambient: 0.0, ..Self::dark() }
    }

    /// No light at all.
    pub const fn dark() -> Self {
        Self { lights: Vec::new(), ambient: 0.0, shadows: Shadows::None, model: LightModel::Surface }
    }
}

fn from_camera(direction: [f64; 3], intensity: f32, specular: bool) -> Light {
    Light { intensity, specular, frame: Frame::Camera, ..Light::new(LightKind::Directional { direction }) }
}
