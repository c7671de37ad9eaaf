//! Ready-made looks. A preset carries everything that changes the picture.

use std::sync::LazyLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::unknown_name;
use crate::transfer_function::ascending;
use crate::{GradientWeight, Material, OpticsError, TransferFunction};

/// Where data come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Modality {
    /// X-ray computed tomography of patients, in Hounsfield units.
    Ct,
    /// Magnetic resonance imaging.
    Mr,
    /// X-ray computed tomography of samples.
    MicroCt,
    /// Computed fields.
    Simulation,
}

/// What the values of a preset are.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Scale {
    /// Data values in a unit that means the same in every data set.
    Absolute {
        /// The unit, "HU".
        unit: String,
    },
    /// Fractions of a window of data values, 0 at its lower end and 1 at its upper.
    Relative,
}

/// A look: optical properties, material and shading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// The name it is asked for by.
    pub name: String,
    /// What it shows, in a few words.
    pub title: String,
    /// The data it is for.
    pub modality: Modality,
    /// What its values are.
    pub scale: Scale,
    /// Colour and opacity over the values of [`Preset::scale`].
    pub transfer_function: TransferFunction,
    /// Default as [`Material::default`].
    #[serde(default)]
    pub material: Material,
    /// Whether samples are lit; otherwise they have their classified colour.
    pub shading: bool,
    /// Where shading can be trusted; by default everywhere. On an absolute scale in its units per
    /// world unit, on a relative one in windows per mean voxel spacing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient_weight: Option<GradientWeight>,
}

impl Preset {
    /// The preset of this name.
    ///
    /// # Errors
    /// [`OpticsError::Name`], with the names there are.
    pub fn by_name(name: &str) -> Result<&'static Self, OpticsError> {
        let names = || Self::all().iter().map(|preset| preset.name.as_str());
        Self::all().iter().find(|preset| preset.name == name).ok_or_else(|| unknown_name("preset", name, names()))
    }

    /// All presets. Opacities on an absolute scale hold for 1 mm, others for the mean voxel
    /// spacing.
    pub fn all() -> &'static [Self] {
        static ALL: LazyLock<Vec<Preset>> = LazyLock::new(|| {
            serde_json::from_str(include_str!("presets.json")).expect("the presets in this file are tested")
        });
        &ALL
    }

    /// The transfer function over data values; `window` is what a relative preset is fitted to.
    ///
    /// # Errors
    /// [`OpticsError::Interval`] if the window of a relative preset does not ascend.
    pub fn transfer_function(&self, window: [f64; 2]) -> Result<TransferFunction, OpticsError> {
        match self.scale {
            Scale::Absolute { .. } => Ok(self.transfer_function.clone()),
            Scale::Relative => self.transfer_function.clone().remap([0.0, 1.0], window),
        }
    }

    /// The gradient weight in data units per world unit.
    ///
    /// # Errors
    /// [`OpticsError::Interval`] if the window of a relative preset does not ascend;
    /// [`OpticsError::Parameter`] unless the mean voxel spacing is positive.
    pub fn gradient_weight(&self, window: [f64; 2], mean_spacing: f64) -> Result<Option<GradientWeight>, OpticsError> {
        if self.scale != Scale::Relative {
            return Ok(self.gradient_weight);
        }
        ascending("window of a preset", window)?;
        crate::error::checked("mean voxel spacing", mean_spacing, f64::MIN_POSITIVE..=f64::MAX, "a positive length")?;
        let unit = ((window[1] - window[0]) / mean_spacing) as f32;
        Ok(self.gradient_weight.map(|weight| GradientWeight { low: weight.low * unit, high: weight.high * unit }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_complete_and_valid() {
        let expected = [
            "ct-air",
            "ct-lung",
            "ct-soft-tissue",
            "ct-bone",
            "ct-vessels",
            "ct-skin",
            "mr-default",
            "mr-brain",
            "mr-angiography",
            "micro-ct",
            "simulation",
            "density",
            "flame",
        ];
        let names: Vec<&str> = Preset::all().iter().map(|preset| preset.name.as_str()).collect();
        assert_eq!(names, expected);
        for preset in Preset::all() {
            assert_eq!(Preset::by_name(&preset.name).unwrap(), preset);
            preset.material.validate().unwrap();
            preset.gradient_weight.iter().for_each(|weight| weight.validate().unwrap());
            let (tf, hull) = (&preset.transfer_function, preset.transfer_function.hull());
            match &preset.scale {
                Scale::Absolute { unit } => {
                    assert_eq!((unit.as_str(), tf.unit_distance()), ("HU", Some(1.0)), "{}", preset.name);
                    assert!(hull[0] >= -1024.0 && hull[1] <= 3071.0, "{}", preset.name);
                    // Air around the patient is never seen.
                    assert_eq!(tf.opacity(-1000.0), 0.0, "{}", preset.name);
                }
                Scale::Relative => {
                    assert_eq!(tf.unit_distance(), None);
                    assert!(hull[0] >= 0.0 && hull[1] <= 1.0, "{}", preset.name);
                }
            }
            assert!(tf.opacities().iter().any(|point| point.opacity > 0.0));
            let json = serde_json::to_string(preset).unwrap();
            assert_eq!(&serde_json::from_str::<Preset>(&json).unwrap(), preset);
        }
        assert!(Preset::by_name("ct").unwrap_err().to_string().contains("ct-air, ct-lung"));
    }

    #[test]
    fn tissue_is_shown_where_it_is() {
        // Typical Hounsfield units: lung -800, fat -100, muscle 50, contrast 300, cortical bone 1000.
        let opacity = |preset: &str, value| {
            Preset::by_name(preset).unwrap().transfer_function([0.0, 1.0]).unwrap().opacity(value)
        };
        for (preset, shown, hidden) in [
            ("ct-bone", 1000.0, 50.0),
            ("ct-vessels", 300.0, 50.0),
            ("ct-soft-tissue", 50.0, -800.0),
            ("ct-skin", -100.0, -800.0),
            ("ct-lung", -450.0, 50.0),
            ("ct-air", -930.0, 50.0),
        ] {
            assert!(opacity(preset, shown) > 0.05, "{preset}");
            assert_eq!(opacity(preset, hidden), 0.0, "{preset}");
        }
    }

    #[test]
    fn relative_presets_follow_their_window_and_absolute_ones_do_not() {
        let window = [100.0, 1100.0];
        let relative = Preset::by_name("mr-angiography").unwrap();
        let fitted = relative.transfer_function(window).unwrap();
        for t in [0.1, 0.42, 0.5, 0.9] {
            assert!((fitted.opacity(100.0 + 1000.0 * t) - relative.transfer_function.opacity(t)).abs() < 1e-6);
        }
        // 0.02 to 0.1 windows of 1000 per spacing of 2.
        let weight = relative.gradient_weight(window, 2.0).unwrap().unwrap();
        assert!((weight.low - 10.0).abs() < 1e-4 && (weight.high - 50.0).abs() < 1e-4);
        assert!(relative.transfer_function([1.0, 1.0]).is_err());
        assert!(relative.gradient_weight(window, 0.0).is_err());
        let absolute = Preset::by_name("ct-bone").unwrap();
        assert_eq!(absolute.transfer_function(window).unwrap(), absolute.transfer_function);
        assert_eq!(absolute.gradient_weight(window, 2.0).unwrap(), absolute.gradient_weight);
    }
}
