//! Automatic choices: a look for data nobody has described.

use glam::DVec3;
use pellucid_field::{Blocks, Histogram, Short, Volume};
use pellucid_optics::{
    ColorMap, DataRange, GradientWeight, Interpolation, Material, OpacityPoint, OpticsError, Preset, Scale, Table,
    TransferFunction, Visibility, opacity_shape,
};
use serde_json::json;

use crate::choice::Choice;
use crate::{Camera, Mode, View, Viewpoint, VolumeEntry};

/// Optics of a volume.
pub struct Look {
    pub transfer_function: TransferFunction,
    pub material: Option<Material>,
    pub gradient_weight: Option<GradientWeight>,
}

/// The optics an entry asks for, completed by what suits its data; every choice is noted.
pub fn look(entry: &VolumeEntry, volume: &Volume, mode: &Mode, choices: &mut Vec<Choice>) -> Result<Look, OpticsError> {
    let mut preset = entry.preset.as_deref().map(Preset::by_name).transpose()?;
    let shaped = entry.colormap.is_some() || entry.opacity.is_some();
    if preset.is_none() && entry.transfer_function.is_none() && !shaped && !shows_values(mode) {
        let (name, reason) = preset_for(volume);
        choices.push(Choice::new("preset", name, format!("{name} ({reason})")));
        preset = Some(Preset::by_name(name)?);
    }
    // A transfer function in full leaves only a relative preset's gradient weight to be spread.
    let needs_window = match (&entry.transfer_function, preset) {
        (own, Some(preset)) => preset.scale == Scale::Relative || (own.is_none() && shaped),
        (own, None) => own.is_none(),
    };
    let window = match entry.window {
        Some(window) => window,
        None if needs_window => {
            let (window, reason) = window_of(volume, entry.component);
            let unit = volume.value_unit.as_deref().unwrap_or_default();
            let chosen = format!("{} to {} {unit} ({reason})", Short(window[0]), Short(window[1]));
            choices.push(Choice::new("window", window.to_vec(), chosen.replace("  ", " ")));
            window
        }
        // Nothing is spread over it.
        None => [0.0, 1.0],
    };
    let tf = match &entry.transfer_function {
        Some(tf) => tf.clone(),
        None => windowed(entry, mode, preset, window)?,
    };
    let weight = preset.map(|preset| preset.gradient_weight(window, volume.grid().mean_spacing())).transpose()?;
    let by_default = matches!(mode, Mode::Isosurface(_)) || preset.map_or(entry.material.is_some(), |p| p.shading);
    let lit = entry.shading.unwrap_or(by_default);
    let material = entry.material.or(preset.map(|preset| preset.material)).unwrap_or_default();
    Ok(Look {
        transfer_function: with_unit_distance(tf, entry, volume, mode, choices)?,
        material: lit.then_some(material),
        gradient_weight: entry.gradient_weight.or(weight.flatten()),
    })
}

/// Whether an entry's window decides anything of its look: it does not where all that could be spread over it has
/// data values of its own.
pub fn heeds_window(entry: &VolumeEntry, volume: &Volume, mode: &Mode) -> bool {
    let with = |window| {
        let entry = VolumeEntry { window: Some(window), ..entry.clone() };
        look(&entry, volume, mode, &mut Vec::new()).ok().map(|look| (look.transfer_function, look.gradient_weight))
    };
    with([0.0, 1.0]) != with([0.0, 2.0])
}

/// Whether a mode shows values rather than a medium: it gets a gray ramp by default.
fn shows_values(mode: &Mode) -> bool {
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
        (Some(name), _) => ColorMap::by_name(name)?.points(window)?,
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

/// A preset for data by what is known of their values.
fn preset_for(volume: &Volume) -> (&'static str, String) {
    let range = volume.statistics();
    let hounsfield = volume.value_unit.as_deref() == Some("HU");
    // Air at -1000 and something denser than water: nothing but CT numbers looks like that.
    let like_ct =
        volume.voxels().voxel_type().is_integer() && (-3100.0..=-900.0).contains(&range.min) && range.max > 200.0;
    if hounsfield || like_ct {
        let why = if hounsfield { "values are in HU" } else { "values reach from air to bone in Hounsfield units" };
        return ("ct-bone", why.to_owned());
    }
    let voxel_type = volume.voxels().voxel_type();
    let name = match voxel_type.is_integer() {
        true => "micro-ct",
        // Deviations to both sides of zero, or amounts of something.
        false if range.min < 0.0 && range.max > 0.0 => "simulation",
        false => "density",
    };
    (name, format!("{voxel_type} values from {} to {}", Short(range.min), Short(range.max)))
}

/// The values that matter: from the background, the commonest value if it is a low one, to all but
/// the brightest thousandth of what is above it.
fn window_of(volume: &Volume, component: usize) -> ([f64; 2], &'static str) {
    let range = volume.statistics();
    let whole = [range.min, range.max];
    // Levels of integer data are exact; bins would put the background beside its value.
    let levels = Histogram::of_levels(volume, component);
    let histogram = levels.or_else(|| Histogram::new(volume, component, 1024).ok()).filter(|_| range.max > range.min);
    let found = histogram.and_then(|histogram| {
        let middle = (range.min + range.max) / 2.0;
        let low = histogram.mode().filter(|mode| *mode < middle).map_or(range.min, |mode| mode.max(range.min));
        let high = histogram.percentile(0.999)?;
        (high - low > 0.05 * (range.max - range.min)).then_some([low, high])
    });
    match found {
        Some(window) => (window, "from the background to the 99.9th percentile of the histogram"),
        None if range.max > range.min => (whole, "the range of the data"),
        None => {
            // Wide enough to differ in 32 bits.
            let half = (range.min.abs() * 1e-3).max(0.5);
            ([range.min - half, range.min + half], "around the only value there is")
        }
    }
}

/// Corners of what a camera should frame: of the part of the grid that can be seen at all, or of
/// the whole grid where a mode shows every value.
pub fn framed_corners(volume: &Volume, component: usize, tf: &TransferFunction, mode: &Mode) -> Vec<DVec3> {
    let visible = match mode {
        Mode::Isosurface(surfaces) => visible_indices(volume, component, |low, high| {
            surfaces.isovalues.iter().any(|iso| f64::from(low) <= iso.value && iso.value <= f64::from(high))
        }),
        mode if shows_values(mode) => None,
        _ => Table::for_data(tf, &DataRange::of(volume)).ok().and_then(|table| {
            let visibility = Visibility::of_table(&table);
            visible_indices(volume, component, |low, high| visibility.any_opacity(low, high))
        }),
    };
    let bounds = visible.unwrap_or_else(|| volume.grid().index_bounds());
    volume.grid().world_corners_of(bounds).to_vec()
}

/// The index box around all blocks whose range of values is visible; `None` if there is no such
/// block.
fn visible_indices(volume: &Volume, component: usize, seen: impl Fn(f32, f32) -> bool) -> Option<(DVec3, DVec3)> {
    const CELLS: f64 = Blocks::CELLS as f64;
    let blocks = Blocks::new(volume, component, Blocks::CELLS, 0).ok()?;
    let [nx, ny, _] = blocks.dims();
    let visible = blocks.ranges().iter().enumerate().filter(|(_, [low, high])| low <= high && seen(*low, *high));
    let positions = visible.map(|(b, _)| DVec3::new((b % nx) as f64, (b / nx % ny) as f64, (b / (nx * ny)) as f64));
    let (first, last) = positions.fold(None, |found: Option<(DVec3, DVec3)>, p| {
        Some(found.map_or((p, p), |(low, high)| (low.min(p), high.max(p))))
    })?;
    let (low, high) = volume.grid().index_bounds();
    Some(((first * CELLS).max(low), ((last + 1.0) * CELLS).min(high)))
}

/// What the camera was set to where the scene left it open.
pub fn camera_choice(camera: &Camera, view: &Viewpoint) -> Option<Choice> {
    let View::Orbit(orbit) = camera.view else { return None };
    if orbit.target.is_some() && orbit.distance.is_some() {
        return None;
    }
    let DVec3 { x, y, z } = view.eye;
    let [azimuth, elevation, x, y, z] = [orbit.azimuth, orbit.elevation, x, y, z].map(Short);
    let chosen = format!("azimuth {azimuth} and elevation {elevation} degrees, eye at ({x}, {y}, {z})");
    let value = json!({
        "azimuth": orbit.azimuth,
        "elevation": orbit.elevation,
        "eye": view.eye.to_array(),
        "target": view.target.to_array(),
    });
    Some(Choice::new("camera", value, chosen))
}
