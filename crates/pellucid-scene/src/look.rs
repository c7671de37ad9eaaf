//! Ready-made light: what a photographer sets up, for any data and any technique.

use pellucid_field::nearest;
use pellucid_optics::{
    Albedo, Color, ColorPoint, Environment, Frame, Light, LightKind, LightModel, Lighting, Material, NumberPoint,
    OpticsError, Phase, PhaseNormalization, Scattering, ShadowVolume, Shadows, SkyImage, SkySource, SurfaceShare,
};

use crate::Background;

/// A bundle of ordinary settings: lights, ambient light, shadows, the environment of paths, the background, and how
/// the volumes answer light. What a transfer function or a preset decides, which values are seen and in
/// which colours, stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// A key light from the upper left, a fill and a rim, with soft shadows before a gray wall.
    Studio,
    /// A day outdoors: a warm sun and blue light from the sky.
    Sky,
    /// Flesh, wax and leaves: a warm light from behind on one side comes through what is thin.
    Skin,
    /// Mist, smoke and clouds in the light of a sun aside, before a blue sky.
    Cloud,
}

impl Look {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Studio, Self::Sky, Self::Skin, Self::Cloud];

    /// The name it is asked for by.
    pub fn name(self) -> &'static str {
        match self {
            Self::Studio => "studio",
            Self::Sky => "sky",
            Self::Skin => "skin",
            Self::Cloud => "cloud",
        }
    }

    /// What it is for, in a line.
    pub fn title(self) -> &'static str {
        match self {
            Self::Studio => "Key, fill and rim light with soft shadows: shape, for anything",
            Self::Sky => "A warm sun and a blue sky: solid things outdoors",
            Self::Skin => "Warm light from behind that comes through what is thin: flesh, wax, leaves",
            Self::Cloud => "A sun aside of what scatters and has no surface: clouds, smoke, densities",
        }
    }

    /// The look of a name.
    ///
    /// # Errors
    /// [`OpticsError::Name`], with the names there are.
    pub fn by_name(name: &str) -> Result<Self, OpticsError> {
        let known = || Self::ALL.map(Self::name);
        Self::ALL.into_iter().find(|look| look.name() == name).ok_or_else(|| OpticsError::Name {
            kind: "look",
            found: name.to_owned(),
            meant: nearest(name, known()).map(str::to_owned),
            known: known().join(", "),
        })
    }

    /// Its lights.
    pub(crate) fn lighting(self) -> Lighting {
        let shadows = Shadows::Volume(ShadowVolume { resolution: 1.0 });
        let (lights, ambient) = match self {
            Self::Studio => (
                vec![
                    light([0.55, -0.65, -0.7], 0xfff4e6, 1.05, Frame::Camera),
                    Light { specular: false, ..light([-0.9, -0.1, -0.5], 0xdfe8ff, 0.3, Frame::Camera) },
                    light([-0.35, -0.45, 0.85], 0xffffff, 0.55, Frame::Camera),
                ],
                0.25,
            ),
            // The place of the sun in the built-in day, and its light on what it shines on.
            Self::Sky => (vec![light([-0.8, 0.4, -0.6], 0xfff0d8, 1.1, Frame::World)], 0.6),
            Self::Skin => (
                vec![
                    light([-0.8, -0.25, 0.55], 0xffe6c8, 1.3, Frame::Camera),
                    Light { specular: false, ..light([0.6, -0.5, -0.7], 0xe8eeff, 0.6, Frame::Camera) },
                ],
                0.2,
            ),
            Self::Cloud => (vec![light([-0.65, -0.6, -0.3], 0xfff0dc, 1.5, Frame::Camera)], 0.35),
        };
        let model = if self == Self::Cloud { LightModel::Scattering } else { LightModel::Surface };
        Lighting { lights, ambient, shadows, model }
    }

    /// What is seen behind the volumes.
    pub(crate) fn background(self) -> Background {
        let gradient = |top, bottom| Background::Gradient { top: Color::hex(top), bottom: Color::hex(bottom) };
        match self {
            Self::Studio => gradient(0x565a61, 0x1c1e22),
            Self::Sky => gradient(0x4c7fc0, 0xd6e2ec),
            Self::Skin => gradient(0x2b2422, 0x0c0a0a),
            Self::Cloud => gradient(0x2a5c9e, 0xa8c8e8),
        }
    }

    /// What shines from around.
    pub(crate) fn environment(self) -> Environment {
        let gradient = |top, bottom, intensity| Environment::Gradient {
            top: Color::hex(top),
            bottom: Color::hex(bottom),
            intensity,
        };
        match self {
            Self::Studio => gradient(0xb8bcc4, 0x303034, 0.5),
            Self::Sky => {
                Environment::Image(SkyImage { source: SkySource::Day, rotation: 0.0, intensity: 1.0, map: None })
            }
            Self::Skin => gradient(0x6a6470, 0x302420, 0.5),
            Self::Cloud => gradient(0x6f9fd8, 0x60686c, 0.7),
        }
    }

    /// How surfaces answer light, if it shows any.
    pub(crate) fn material(self) -> Option<Material> {
        let material = |diffuse, specular, shininess| Material {
            ambient: 0.5,
            diffuse,
            specular,
            shininess,
            ..Material::default()
        };
        match self {
            Self::Studio => Some(material(0.8, 0.25, 40.0)),
            Self::Sky => Some(material(0.85, 0.12, 25.0)),
            Self::Skin => Some(material(0.65, 0.3, 16.0)),
            Self::Cloud => None,
        }
    }

    /// How volumes scatter; `physical`: whether light is followed and conserved, or made for the eye.
    pub(crate) fn scattering(self, physical: bool) -> Scattering {
        let everywhere = |color| Some(vec![ColorPoint::new(0.0, Color::hex(color))]);
        let surface = |share| SurfaceShare::Values(vec![NumberPoint::new(0.0, share)]);
        let normalization = if physical { PhaseNormalization::Physical } else { PhaseNormalization::Renormalised };
        let scattering = Scattering { phase_normalization: normalization, ..Scattering::default() };
        match self {
            Self::Studio | Self::Sky => {
                Scattering { surface: surface(0.85), transport: everywhere(0xe8e4e0), ..scattering }
            }
            Self::Skin => Scattering { surface: surface(0.45), transport: everywhere(0xfbded2), ..scattering },
            Self::Cloud => Scattering {
                // A cloud throws most light on; where that is not conserved, its sides would be black.
                phase: Phase::HenyeyGreenstein { g: if physical { 0.6 } else { 0.2 } },
                // The colours of values that are little of a cloud are dark, and light would be lost to them.
                albedo: Albedo::Constant(0.99),
                transport: everywhere(0xebedf2),
                ..scattering
            },
        }
    }
}

fn light(direction: [f64; 3], color: u32, intensity: f32, frame: Frame) -> Light {
    Light { color: Color::hex(color), intensity, frame, ..Light::new(LightKind::Directional { direction }) }
}
