//! Automatic choices: a look for data nobody has described.

use std::cell::OnceCell;

use pellucid_field::{Short, Volume};
use pellucid_optics::{
    ColorMap, Environment, GradientWeight, Interpolation, Light, Lighting, Material, OpacityPoint, OpticsError, Preset,
    Scale, TransferFunction, opacity_shape,
};
use serde_json::json;

use crate::choice::Choice;
use crate::origin::origin_of;
use crate::population::{Backdrop, Population};
use crate::{Camera, Mode, Projection, Technique, View, Viewpoint, VolumeEntry};

/// Optics of a volume.
pub struct Optics {
    pub transfer_function: TransferFunction,
    pub material: Option<Material>,
    pub gradient_weight: Option<GradientWeight>,
}

/// What was filled in of an entry: a document with it draws the same without asking the data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chosen {
    pub preset: Option<String>,
    pub colormap: Option<String>,
    pub opacity: Option<String>,
    pub window: Option<[f64; 2]>,
}

/// The optics an entry asks for, completed by what suits the data of a component; every choice is noted.
pub fn optics(
    entry: &VolumeEntry,
    volume: &Volume,
    component: usize,
    mode: &Mode,
    choices: &mut Vec<Choice>,
) -> Result<(Optics, Chosen), OpticsError> {
    // Only what is asked of the data is looked for in it.
    let (population, backdrop) = (OnceCell::new(), OnceCell::new());
    let population = || population.get_or_init(|| Population::of(volume, component));
    let backdrop = || *backdrop.get_or_init(|| population().backdrop());
    let mut entry = entry.clone();
    let shaped = entry.colormap.is_some() || entry.opacity.is_some();
    if entry.preset.is_none() && entry.transfer_function.is_none() && !shaped && !shows_values(mode) {
        let (preset, reason) = preset_for(volume, population(), backdrop(), entry.window);
        choices.push(Choice::new("preset", preset, format!("{preset} ({reason})")));
        entry.preset = Some(preset.to_owned());
        if let (Backdrop::Above(common), None) = (backdrop(), entry.window)
            && preset != "ct-bone"
        {
            let chosen = format!("viridis_r and linear_r, as the commonest value, {}, is a high one", Short(common));
            choices.push(Choice::new("colormap and opacity", vec!["viridis_r", "linear_r"], chosen));
            (entry.colormap, entry.opacity) = (Some("viridis_r".into()), Some("linear_r".into()));
        }
    }
    let shaped = entry.colormap.is_some() || entry.opacity.is_some();
    let preset = entry.preset.as_deref().map(Preset::by_name).transpose()?;
    // A transfer function in full leaves only a relative preset's gradient weight to be spread.
    let needs_window = match (&entry.transfer_function, preset) {
        (own, Some(preset)) => preset.scale == Scale::Relative || (own.is_none() && shaped),
        (own, None) => own.is_none(),
    };
    if needs_window && entry.window.is_none() {
        let (window, reason) = window_of(population(), backdrop(), mode, entry.preset.as_deref(), origin_of(volume));
        let unit = volume.value_unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
        let [low, high] = Short::ends(window[0], window[1]);
        let chosen = format!("{low} to {high}{unit} ({reason})");
        choices.push(Choice::new("window", window.to_vec(), chosen));
        entry.window = Some(window);
    }
    let moved = entry.window.filter(|_| !needs_window && entry.transfer_function.is_none());
    // Nothing is spread over a window that is not there.
    let window = entry.window.unwrap_or([0.0, 1.0]);
    let tf = match &entry.transfer_function {
        Some(tf) => tf.clone(),
        None => windowed(&entry, mode, preset, window)?,
    };
    let (tf, stretch) = match moved {
        // A preset in units of its own is moved to a window that is asked for.
        Some(window) => {
            let hull = tf.hull();
            (tf.remap(hull, window)?, (window[1] - window[0]) / (hull[1] - hull[0]))
        }
        None => (tf, 1.0),
    };
    let weight =
        preset.map(|preset| preset.gradient_weight(window, volume.grid().mean_spacing())).transpose()?.flatten();
    let stretched = |weight: GradientWeight| {
        let [low, high] = [weight.low, weight.high].map(|slope| (f64::from(slope) * stretch) as f32);
        GradientWeight { low, high }
    };
    let by_default = matches!(mode, Mode::Isosurface(_)) || preset.map_or(entry.material.is_some(), |p| p.shading);
    let lit = entry.shading.unwrap_or(by_default);
    let material = entry.material.or(preset.map(|preset| preset.material)).unwrap_or_default();
    if matches!(mode, Mode::Minimum) && entry.crop.is_none() {
        choices.extend(background_of_minima(population(), backdrop()));
    }
    let optics = Optics {
        transfer_function: with_unit_distance(tf, &entry, volume, mode, choices)?,
        material: lit.then_some(material),
        gradient_weight: entry.gradient_weight.or(weight.map(stretched)),
    };
    let VolumeEntry { preset, colormap, opacity, window, .. } = entry;
    Ok((optics, Chosen { preset, colormap, opacity, window }))
}

/// Rays through the background have it as their smallest value, whatever lies behind.
fn background_of_minima(population: &Population, backdrop: Backdrop) -> Option<Choice> {
    let (Backdrop::Below(common), Some((_, share))) = (backdrop, population.commonest()) else { return None };
    let chosen = format!(
        "{} is both low and common: a minimum projection shows it on every ray that meets it. A crop or clips to the \
         inside show what is lowest there",
        Short(common)
    );
    (share > 0.05).then(|| Choice::new("background", common, chosen))
}

/// Whether an entry's window decides anything of its look: it does not where all that could be spread over it has
/// data values of its own.
pub fn heeds_window(entry: &VolumeEntry, volume: &Volume, mode: &Mode) -> bool {
    let with = |window| {
        let entry = VolumeEntry { window: Some(window), ..entry.clone() };
        let component = entry.component.unwrap_or_default();
        let optics = optics(&entry, volume, component, mode, &mut Vec::new());
        optics.ok().map(|(optics, _)| (optics.transfer_function, optics.gradient_weight))
    };
    with([0.0, 1.0]) != with([0.0, 2.0])
}

/// Whether a mode shows values rather than a medium: it gets a gray ramp by default.
pub fn shows_values(mode: &Mode) -> bool {
    matches!(mode, Mode::Maximum | Mode::Minimum | Mode::Average | Mode::Slice(_) | Mode::XRay)
}

/// A transfer function over a window: the preset's, its colours or opacities replaced by the
/// entry's colour map and opacity shape, or a gray ramp.
fn windowed(
    entry: &VolumeEntry,
    mode: &Mode,
    preset: Option<&Preset>,
    window: [f64; 2],
) -> Result<TransferFunction, OpticsError> {
    let base = preset.map(|preset| preset.transfer_function(window)).transpose()?;
    let colors = match (&entry.colormap, &base) {
        (Some(name), _) => ColorMap::colors(name, window)?,
        (None, Some(base)) => base.colors().to_vec(),
        (None, None) => ColorMap::by_name("gray")?.points(window)?,
    };
    let opacities = match (&entry.opacity, &base) {
        (Some(name), _) => opacity_shape(name, window)?,
        (None, Some(base)) => base.opacities().to_vec(),
        (None, None) if shows_values(mode) && !matches!(mode, Mode::XRay) => {
            vec![OpacityPoint { value: window[0], opacity: 1.0, interpolation: Interpolation::Linear }]
        }
        (None, None) => opacity_shape("linear", window)?,
    };
    let unit = base.as_ref().and_then(TransferFunction::unit_distance);
    let space = base.as_ref().map(TransferFunction::color_space).unwrap_or_default();
    TransferFunction::new(colors, opacities)?.with_color_space(space).with_unit_distance(unit)
}

/// Sets the unit distance: the entry's, the transfer function's own, or an automatic one.
fn with_unit_distance(
    tf: TransferFunction,
    entry: &VolumeEntry,
    volume: &Volume,
    mode: &Mode,
    choices: &mut Vec<Choice>,
) -> Result<TransferFunction, OpticsError> {
    if entry.unit_distance.is_some() {
        return tf.with_unit_distance(entry.unit_distance);
    }
    if tf.unit_distance().is_some() {
        return Ok(tf);
    }
    let length = volume.length_unit.as_deref().unwrap_or("world units");
    let grid = volume.grid();
    // A radiograph looks through everything: its opacities hold for a share of the whole.
    let (unit, why) = match mode {
        Mode::XRay => {
            let (low, high) = grid.world_bounds();
            ((high - low).max_element() / 2.0, "half the volume's longest side")
        }
        _ => (grid.mean_spacing(), "the mean voxel spacing"),
    };
    choices.push(Choice::new("unit distance", unit, format!("opacities hold for {} {length} ({why})", Short(unit))));
    tf.with_unit_distance(Some(unit))
}

/// A preset for data by what is known of their values. A window that was asked for is spread over, which those in
/// units of their own are not.
fn preset_for(
    volume: &Volume,
    population: &Population,
    backdrop: Backdrop,
    window: Option<[f64; 2]>,
) -> (&'static str, String) {
    let hounsfield = volume.value_unit.as_deref() == Some("HU");
    if window.is_none() && (hounsfield || population.is_like_hounsfield()) {
        let why = if hounsfield { "values are in HU" } else { "values reach from air to bone in Hounsfield units" };
        return ("ct-bone", why.to_owned());
    }
    let voxel_type = volume.voxels().voxel_type();
    let (Some(least), Some(most)) = (population.values().first(), population.values().last()) else {
        return ("density", "no value is there to choose by".to_owned());
    };
    let [least, most] = Short::ends(*least, *most);
    let values = format!("{voxel_type} values from {least} to {most}");
    match backdrop {
        Backdrop::Between(neutral) if window.is_none_or(|[low, high]| low < neutral && neutral < high) => {
            ("simulation", format!("{values}, to both sides of {}", Short(neutral)))
        }
        _ if voxel_type.is_integer() => ("micro-ct", values),
        _ => ("density", values),
    }
}

/// The values that matter: all but the background, if there is one, and but for outliers.
fn window_of(
    population: &Population,
    backdrop: Backdrop,
    mode: &Mode,
    preset: Option<&str>,
    origin: Option<f64>,
) -> ([f64; 2], String) {
    let Some([low, high]) = population.ends() else {
        return ([-0.5, 0.5], "there is no value to choose by".to_owned());
    };
    let reach = |from: f64, side: f64| population.reach(from, side).unwrap_or(0.0);
    let ([low, high], why) = match backdrop {
        Backdrop::Between(neutral) if preset == Some("simulation") => {
            let most = reach(neutral, 1.0).max(reach(neutral, -1.0));
            ([neutral - most, neutral + most], format!("as far to both sides of {} as values reach", Short(neutral)))
        }
        Backdrop::Below(common) => (
            [common, common + reach(common, 1.0)],
            "from the background, the commonest value, to all but outliers".to_owned(),
        ),
        Backdrop::Above(common) if !shows_values(mode) => (
            [common - reach(common, -1.0), common],
            "from all but outliers to the background, the commonest value".to_owned(),
        ),
        _ => ([low, high], "all values but outliers".to_owned()),
    };
    // Wide enough for what is in between to differ: in 32 bits, where values may be differences, and in the 64 of control
    // points.
    let size = |value: f64| (value - origin.unwrap_or(0.0)).abs();
    let least = (size(low).max(size(high)) * 1e-6).max(f64::from(f32::MIN_POSITIVE));
    let least = least.max(64.0 * f64::EPSILON * low.abs().max(high.abs()));
    if high - low > least {
        return ([low, high], why);
    }
    if let (Some(&low), Some(&high)) = (population.values().first(), population.values().last()) {
        if high - low > least {
            return ([low, high], "the range of the data".to_owned());
        }
        if high > low && origin.is_some() {
            let (middle, half) = ((low + high) / 2.0, least / 2.0);
            return ([middle - half, middle + half], "around the data, as wide as numbers so large need".to_owned());
        }
    }
    let half = (low.abs() * 1e-3).max(0.5);
    ([low - half, low + half], "around the only value there is".to_owned())
}

/// What the camera was set to where the scene left it open.
pub fn camera_choice(camera: &Camera, view: &Viewpoint) -> Option<Choice> {
    let View::Orbit(orbit) = camera.view else { return None };
    if orbit.target.is_some() && orbit.distance.is_some() {
        return None;
    }
    let [azimuth, elevation] = [orbit.azimuth, orbit.elevation].map(Short);
    let [x, y, z] = view.eye.to_array().map(Short);
    let chosen = format!("azimuth {azimuth} and elevation {elevation} degrees, eye at ({x}, {y}, {z})");
    let value = json!({
        "azimuth": orbit.azimuth,
        "elevation": orbit.elevation,
        "eye": view.eye.to_array(),
        "target": view.target.to_array(),
    });
    Some(Choice::new("camera", value, chosen))
}

/// The camera with what was chosen for it written down.
pub fn settled_camera(camera: &Camera, view: &Viewpoint) -> Camera {
    let mut camera = *camera;
    let mut zoom = 1.0;
    if let View::Orbit(orbit) = &mut camera.view {
        orbit.target.get_or_insert(view.target.to_array());
        orbit.distance.get_or_insert((view.eye - view.target).length());
        zoom = orbit.zoom;
    }
    if let Projection::Orthographic { height } = &mut camera.projection {
        height.get_or_insert(2.0 * view.half_height * zoom);
    }
    camera
}

/// The lights of a scene: those it lists, but for the default headlight where an environment is the light.
pub fn lights<'l>(lighting: &'l Lighting, technique: &Technique) -> &'l [Light] {
    if lit_by_environment(technique) && is_default(lighting) { &[] } else { &lighting.lights }
}

fn is_default(lighting: &Lighting) -> bool {
    lighting.lights == Lighting::default().lights
}

fn lit_by_environment(technique: &Technique) -> bool {
    technique.environment().is_some_and(|environment| *environment != Environment::Dark)
}

/// What lights a technique that follows light, or finds it all around, where the scene left it open.
pub fn lights_choice(lighting: &Lighting, technique: &Technique) -> Option<Choice> {
    let follows = technique.needs().light.is_followed() || technique.environment().is_some();
    let (lights, chosen) = match lit_by_environment(technique) {
        true => ("environment", "the environment alone"),
        false => ("headlight", "a headlight, which casts no shadow that is seen; lighting.lights brings others"),
    };
    (follows && is_default(lighting)).then(|| Choice::new("lights", lights, chosen))
}
