//! Transfer function, material and light.

use std::path::Path;

use pellucid::io::{IoError, Limits, read_text};
use pellucid::optics::{Light, LightKind, Lighting, Material, TransferFunction, VolumeProperty};
use pellucid::scene::Scene;

use super::first_volume;
use crate::cli::failure::Failure;
use crate::cli::values;

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Look")]
pub struct LookFlags {
    /// A ready-made look; 'pellucid presets' lists them [default: by the data's unit and range]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Data values that presets, colour maps and opacity shapes are spread over [default: from the
    /// histogram]
    #[arg(long, value_name = "LOW,HIGH", value_parser = values::numbers::<2>, allow_hyphen_values = true)]
    window: Option<[f64; 2]>,
    /// A colour map over the window, reversed with _r; 'pellucid presets --colormaps' lists them
    #[arg(long, value_name = "NAME")]
    colormap: Option<String>,
    /// An opacity shape over the window, reversed with _r; 'pellucid presets --opacities' lists
    /// them
    #[arg(long, value_name = "NAME")]
    opacity: Option<String>,
    /// World distance that the opacities hold for [default: that of preset or transfer function,
    /// else the mean voxel spacing]
    #[arg(long, value_name = "LENGTH", value_parser = values::number, allow_hyphen_values = true)]
    unit_distance: Option<f64>,
    /// A transfer function in full: .toml or .json as in a scene, or .vp.json as 3D Slicer saves
    /// volume properties
    #[arg(long, value_name = "FILE", value_parser = look_file,
        conflicts_with_all = ["preset", "window", "colormap", "opacity"])]
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
    transfer_function: TransferFunction,
    /// Material and shading, where the format has them.
    surface: Option<(Material, bool)>,
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

    pub fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        self.apply_names(scene)?;
        if let Some(file) = &self.transfer_function {
            let entry = first_volume(scene, "--transfer-function")?;
            entry.transfer_function = Some(file.transfer_function.clone());
            if let Some((material, shading)) = file.surface {
                (entry.material, entry.shading) = (Some(material), Some(shading));
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
        if self.opacity.is_some() {
            let entry = first_volume(scene, "--opacity")?;
            entry.opacity.clone_from(&self.opacity);
            entry.transfer_function = None;
        }
        if self.window.is_some() {
            let entry = first_volume(scene, "--window")?;
            entry.window = self.window;
            if entry.transfer_function.is_some() {
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

fn light(text: &str) -> Result<LightFlag, String> {
    match text {
        "headlight" => Ok(LightFlag::Rig(Lighting::headlight())),
        "three-point" => Ok(LightFlag::Rig(Lighting::three_point())),
        _ => values::numbers(text)
            .map(LightFlag::Direction)
            .map_err(|_| "expected headlight, three-point or the three numbers of a direction".into()),
    }
}

fn look_file(path: &str) -> Result<LookFile, String> {
    let text = read_text(path, &Limits::default()).map_err(|error| match error {
        // The flag's name and the file's stand before it.
        IoError::Io { source, .. } => source.to_string(),
        other => other.to_string(),
    })?;
    let own = |transfer_function| LookFile { transfer_function, surface: None, warnings: Vec::new() };
    if path.to_lowercase().ends_with(".vp.json") {
        return slicer_file(&text);
    }
    match Path::new(path).extension().and_then(|extension| extension.to_str()) {
        Some("toml") => toml::from_str(&text).map(own).map_err(|error| error.to_string()),
        Some("json") => serde_json::from_str(&text).map(own).map_err(|error| error.to_string()),
        _ => Err("the name must end in .toml, .json or .vp.json".into()),
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
    Ok(LookFile { transfer_function: first.transfer_function, surface, warnings })
}
