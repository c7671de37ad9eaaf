//! Transfer function, material and light.

use std::path::Path;

use pellucid::io::{IoError, Limits, read_text};
use pellucid::optics::{
    GradientWeight, Light, LightKind, Lighting, Material, Preset, Scale, TransferFunction, VolumeProperty,
};
use pellucid::scene::{Choice, Colors, Look, Scene, StageVolume};

use super::first_volume;
use crate::failure::Failure;
use crate::values;

/// A preset over a window, which is there as long as the window is not known: the one that a file was printed from, which
/// may choose its window in its own way, or this one.
const RELATIVE: &str = "density";

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Look")]
pub struct LookFlags {
    /// Ready-made light for any data and technique: lights, environment, background, material and
    /// scattering, all of which other flags change; 'pellucid presets --looks' tells what each is for
    #[arg(long, value_name = "studio|sky|skin|cloud", value_parser = bundle)]
    look: Option<Look>,
    /// A ready-made transfer function with its material; 'pellucid presets' lists them [default: by the data's
    /// unit and values]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Data values that presets, colour maps and opacity shapes are spread over [default: from the
    /// histogram]
    #[arg(long, value_name = "LOW,HIGH", value_parser = values::numbers::<2>, allow_hyphen_values = true)]
    window: Option<[f64; 2]>,
    /// A colour map over the window, reversed with _r; 'pellucid presets --colormaps' lists them
    #[arg(long, value_name = "NAME")]
    colormap: Option<String>,
    /// Where colours come from: the voxels, where they are red, green and blue, or the transfer function
    /// [default: the voxels, if neither component, preset, colour map nor transfer function is given]
    #[arg(long, value_name = "data|transfer-function", value_parser = colors)]
    colors: Option<Colors>,
    /// An opacity shape over the window, reversed with _r; 'pellucid presets --opacities' lists
    /// them
    #[arg(long, value_name = "NAME")]
    opacity: Option<String>,
    /// World distance that the opacities hold for [default: that of preset or transfer function,
    /// else the mean voxel spacing]
    #[arg(long, value_name = "LENGTH", value_parser = values::number, allow_hyphen_values = true)]
    unit_distance: Option<f64>,
    /// A transfer function in full: .toml or .json as in a scene or as 'pellucid presets NAME' prints
    /// it, or .vp.json as 3D Slicer saves volume properties
    #[arg(long, value_name = "FILE", value_parser = look_file,
        conflicts_with_all = ["preset", "colormap", "opacity"])]
    transfer_function: Option<LookFile>,
    /// Whether surfaces are lit [default: the preset decides]
    #[arg(long, value_name = "on|off", value_parser = values::switch)]
    shading: Option<bool>,
    /// Part of the ambient light the material reflects, 0 to 1 [default: the preset's, else 0.1]
    #[arg(long, value_name = "PART", value_parser = values::number32, allow_hyphen_values = true)]
    ambient: Option<f32>,
    /// Part of the light reflected evenly, 0 to 1 [default: the preset's, else 0.6]
    #[arg(long, value_name = "PART", value_parser = values::number32, allow_hyphen_values = true)]
    diffuse: Option<f32>,
    /// Part of the light reflected as highlight, 0 to 1 [default: the preset's, else 0.2]
    #[arg(long, value_name = "PART", value_parser = values::number32, allow_hyphen_values = true)]
    specular: Option<f32>,
    /// Sharpness of the highlight, 1 to 1000 [default: the preset's, else 30]
    #[arg(long, value_name = "EXPONENT", value_parser = values::number32, allow_hyphen_values = true)]
    shininess: Option<f32>,
    /// A light: 'headlight' at the eye, 'three-point' around it, or the world direction light
    /// travels in. Repeatable; lights on the command line replace those of the scene file
    /// [default: headlight]
    #[arg(long, value_name = "headlight|three-point|DX,DY,DZ", value_parser = light, allow_hyphen_values = true)]
    light: Vec<LightFlag>,
}

/// What a transfer function file holds.
#[derive(Clone, Debug)]
struct LookFile {
    /// Over data values, or over parts of a window.
    transfer_function: TransferFunction,
    /// A preset, where the file holds one whose values are parts of a window.
    relative: Option<Preset>,
    /// Material and shading, where the format has them.
    surface: Option<(Material, bool)>,
    gradient_weight: Option<GradientWeight>,
    warnings: Vec<String>,
}

#[derive(Clone, Debug)]
enum LightFlag {
    Rig(Lighting),
    Direction([f64; 3]),
}

impl LookFlags {
    /// What was lost in reading a transfer function file.
    pub fn warnings(&self) -> &[String] {
        self.transfer_function.as_ref().map_or(&[], |file| &file.warnings)
    }

    /// Brings the light of a look, before flags that change parts of it.
    pub fn apply_bundle(&self, scene: &mut Scene) {
        if let Some(look) = self.look {
            look.apply(scene);
        }
    }

    pub fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        self.apply_names(scene)?;
        if let Some(file) = &self.transfer_function {
            let entry = first_volume(scene, "--transfer-function")?;
            if let Some((material, shading)) = file.surface {
                let lit = self.shading.unwrap_or(shading);
                (entry.material, entry.shading) = (lit.then_some(material), Some(shading));
            }
            match &file.relative {
                None => {
                    entry.transfer_function = Some(file.transfer_function.clone());
                    entry.gradient_weight = file.gradient_weight.or(entry.gradient_weight);
                }
                // Any look over a window, until the window is known: `spread` puts the file's in its place.
                Some(preset) => {
                    let built_in = Preset::by_name(&preset.name).is_ok_and(|known| known.scale == Scale::Relative);
                    let stand_in = if built_in { preset.name.clone() } else { RELATIVE.to_owned() };
                    (entry.preset, entry.colormap, entry.opacity) = (Some(stand_in), None, None);
                    entry.transfer_function = None;
                }
            }
        }
        if self.unit_distance.is_some() {
            first_volume(scene, "--unit-distance")?.unit_distance = self.unit_distance;
        }
        if self.shading.is_some() {
            first_volume(scene, "--shading")?.shading = self.shading;
        }
        self.apply_lights(scene);
        Ok(())
    }

    /// Spreads the relative look of a file over the window of the volume, chosen or given. Whether there is one.
    pub fn spread(&self, scene: &mut Scene, volume: &StageVolume, choices: &[Choice]) -> Result<bool, Failure> {
        let Some(preset) = self.transfer_function.as_ref().and_then(|file| file.relative.as_ref()) else {
            return Ok(false);
        };
        let entry = first_volume(scene, "--transfer-function")?;
        let chosen = choices.iter().find(|choice| self.settles_with(choice));
        let ends = chosen.and_then(|choice| Some([choice.value.get(0)?.as_f64()?, choice.value.get(1)?.as_f64()?]));
        let window = entry.window.or(ends).ok_or_else(|| Failure::work("no window was chosen"))?;
        let spacing = volume.volume.grid().mean_spacing();
        entry.transfer_function = Some(preset.transfer_function(window).map_err(Failure::input)?);
        entry.gradient_weight = preset.gradient_weight(window, spacing).map_err(Failure::input)?;
        // It has been used up.
        (entry.preset, entry.window) = (None, None);
        Ok(true)
    }

    /// Whether a choice decides something that [`LookFlags::spread`] writes into the scene.
    pub fn settles_with(&self, choice: &Choice) -> bool {
        choice.setting == "window" && self.transfer_function.as_ref().is_some_and(|file| file.relative.is_some())
    }

    /// A name on the command line wins over whatever else the scene says of the transfer function.
    fn apply_names(&self, scene: &mut Scene) -> Result<(), Failure> {
        if self.preset.is_some() {
            let entry = first_volume(scene, "--preset")?;
            entry.preset.clone_from(&self.preset);
            (entry.colormap, entry.opacity, entry.transfer_function) = (None, None, None);
        }
        if self.colormap.is_some() {
            let entry = first_volume(scene, "--colormap")?;
            entry.colormap.clone_from(&self.colormap);
            entry.transfer_function = None;
        }
        if self.colors.is_some() {
            first_volume(scene, "--colors")?.colors = self.colors;
        }
        if self.opacity.is_some() {
            let entry = first_volume(scene, "--opacity")?;
            entry.opacity.clone_from(&self.opacity);
            entry.transfer_function = None;
        }
        if self.window.is_some() {
            let entry = first_volume(scene, "--window")?;
            entry.window = self.window;
            let file = self.transfer_function.as_ref();
            if file.is_some_and(|file| file.relative.is_none()) {
                return Err(Failure::input("--window has no effect on a --transfer-function over data values"));
            }
            if entry.transfer_function.is_some() && file.is_none() {
                return Err(Failure::input("--window has no effect on the scene's transfer_function")
                    .hint("add --preset or --colormap and --opacity to replace it"));
            }
        }
        Ok(())
    }

    /// Changes numbers of the material there is: the scene's, or else the `staged` one, which the
    /// preset has brought. Whether there was anything to change.
    pub fn change_material(&self, scene: &mut Scene, staged: Option<Material>) -> bool {
        let given = [self.ambient, self.diffuse, self.specular, self.shininess].iter().any(Option::is_some);
        let (true, Some(entry)) = (given, scene.volumes.first_mut()) else { return false };
        let material = entry.material.get_or_insert(staged.unwrap_or_default());
        material.ambient = self.ambient.unwrap_or(material.ambient);
        material.diffuse = self.diffuse.unwrap_or(material.diffuse);
        material.specular = self.specular.unwrap_or(material.specular);
        material.shininess = self.shininess.unwrap_or(material.shininess);
        true
    }

    fn apply_lights(&self, scene: &mut Scene) {
        if self.light.is_empty() {
            return;
        }
        let lighting = &mut scene.lighting;
        lighting.lights.clear();
        for light in &self.light {
            match light {
                LightFlag::Direction(direction) => {
                    lighting.lights.push(Light::new(LightKind::Directional { direction: *direction }));
                }
                // An arrangement comes with its ambient light.
                LightFlag::Rig(rig) => {
                    lighting.lights.extend(&rig.lights);
                    lighting.ambient = rig.ambient;
                }
            }
        }
    }
}

fn bundle(name: &str) -> Result<Look, String> {
    Look::by_name(name).map_err(|error| error.to_string())
}

fn colors(text: &str) -> Result<Colors, String> {
    match text {
        "data" => Ok(Colors::Data),
        "transfer-function" => Ok(Colors::TransferFunction),
        _ => Err(values::with_pointer("expected data or transfer-function", text, &["data", "transfer-function"])),
    }
}

fn light(text: &str) -> Result<LightFlag, String> {
    match text {
        "headlight" => Ok(LightFlag::Rig(Lighting::headlight())),
        "three-point" => Ok(LightFlag::Rig(Lighting::three_point())),
        _ => values::numbers(text).map(LightFlag::Direction).map_err(|_| {
            let expected = "expected headlight, three-point or the three numbers of a direction";
            values::with_pointer(expected, text, &["headlight", "three-point"])
        }),
    }
}

fn look_file(path: &str) -> Result<LookFile, String> {
    let text = read_text(path, &Limits::default()).map_err(|error| match error {
        // The flag's name and the file's stand before it.
        IoError::Io { source, .. } => source.to_string(),
        other => other.to_string(),
    })?;
    if path.to_lowercase().ends_with(".vp.json") {
        return slicer_file(&text);
    }
    match Path::new(path).extension().and_then(|extension| extension.to_str()) {
        Some("toml") => look(|| toml::from_str(&text), || toml::from_str(&text)),
        Some("json") => look(|| serde_json::from_str(&text), || serde_json::from_str(&text)),
        _ => Err("the name must end in .toml, .json or .vp.json".into()),
    }
}

/// A transfer function, or a preset, which has a transfer function among other things.
fn look<E: ToString>(
    plain: impl Fn() -> Result<TransferFunction, E>,
    preset: impl Fn() -> Result<Preset, E>,
) -> Result<LookFile, String> {
    let file = |transfer_function| LookFile {
        transfer_function,
        relative: None,
        surface: None,
        gradient_weight: None,
        warnings: Vec::new(),
    };
    let error = match plain() {
        Ok(transfer_function) => return Ok(file(transfer_function)),
        Err(error) => error.to_string(),
    };
    // What lacks the keys of a preset, or has those of a transfer function, was not meant to be one.
    match preset() {
        Ok(preset) => Ok(LookFile {
            surface: Some((preset.material, preset.shading)),
            gradient_weight: preset.gradient_weight,
            relative: (preset.scale == Scale::Relative).then(|| preset.clone()),
            ..file(preset.transfer_function)
        }),
        Err(of_preset) => {
            let of_preset = of_preset.to_string();
            let other = ["missing field", "unknown field `colors`", "unknown field `opacities`"];
            Err(if other.iter().any(|part| of_preset.contains(part)) { error } else { of_preset })
        }
    }
}

fn slicer_file(text: &str) -> Result<LookFile, String> {
    let (properties, warnings) = VolumeProperty::from_slicer(text).map_err(|error| error.to_string())?;
    let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    if properties.len() > 1 {
        warnings.push(format!("the first of {} components of the volume property is used", properties.len()));
    }
    let first = properties.into_iter().next().ok_or("it holds no volume property")?;
    if first.gradient_opacity.iter().any(|point| point.opacity != 1.0) {
        warnings.push("the gradient opacity of the volume property is ignored".into());
    }
    let surface = Some((first.material, first.shading));
    let transfer_function = first.transfer_function;
    Ok(LookFile { transfer_function, relative: None, surface, gradient_weight: None, warnings })
}
