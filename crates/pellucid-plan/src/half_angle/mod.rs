//! Where light and eye meet the slabs of half-angle slicing (K-05, 6.1-3): what every backend sweeps over.

mod light_frame;
mod points;
mod slabs;
pub mod taps;

use glam::{DAffine3, DVec3};
use pellucid_field::{FieldError, Grid};
use pellucid_optics::{Light, LightKind, Material, OpticsError, ResolvedLight, Scattering};
use pellucid_scene::{HalfAngle, Stage, StageVolume};

use crate::merge_order;

pub use light_frame::LightFrame;
pub use points::LightPoints;
pub use slabs::{Slabs, along_light, slice_axis};

/// Why the light of a stage cannot be followed from slab to slab.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LightError {
    /// A light that there is not.
    #[error("technique.half_angle.light is {found}, but the scene has {lights} lights (numbered from 0)")]
    Absent {
        /// The light asked for.
        found: usize,
        /// How many there are.
        lights: usize,
    },
    /// A light in the volume, from which it does not lie ahead.
    #[error(
        "lighting.lights[{light}] stands in the volume or right beside it, where slices cannot follow its light: \
         move it away, or cast shadow rays"
    )]
    Inside {
        /// Its number.
        light: usize,
    },
    /// A light that is none.
    #[error(transparent)]
    Optics(#[from] OpticsError),
}

/// The lights that shine, with their numbers. Without any, one along the view that is black: what is left is
/// attenuation (K-16).
///
/// # Errors
/// [`LightError::Absent`] if the settings ask for a light that there is not.
pub fn lights(stage: &Stage, settings: &HalfAngle) -> Result<Vec<(usize, ResolvedLight)>, LightError> {
    match settings.light {
        None if stage.lights.is_empty() => {
            let direction = stage.viewpoint.forward.to_array();
            let dark = Light { intensity: 0.0, ..Light::new(LightKind::Directional { direction }) };
            Ok(vec![(0, dark.resolve(DAffine3::IDENTITY)?)])
        }
        None => Ok(stage.lights.iter().copied().enumerate().collect()),
        Some(light) => {
            let found = stage.lights.get(light);
            let found = found.ok_or(LightError::Absent { found: light, lights: stage.lights.len() })?;
            Ok(vec![(light, *found)])
        }
    }
}

/// What samples are made of and the ambient light on them, each in one of so many sweeps, whose light adds up. What
/// is not shaded does not shine by itself.
pub fn material(stage: &Stage, volume: &StageVolume, settings: &HalfAngle, sweeps: usize) -> (Material, f32) {
    let share = 1.0 / sweeps as f32;
    let material = volume.material.unwrap_or(Material { emission: 0.0, ..Material::default() });
    let ambient = if settings.ambient { stage.ambient * share } else { 0.0 };
    (Material { emission: material.emission * share, ..material }, ambient)
}

/// What light and slabs of a stage are around: the grid of its volume or, where there are several, one over the box of
/// all of them along the world's axes.
///
/// # Errors
/// [`FieldError`] if there can be no such grid.
pub fn around(stage: &Stage) -> Result<Grid, FieldError> {
    /// Voxels along an axis: of what is larger, slabs need not be as thin as the smallest voxel.
    const MOST: f64 = 65536.0;
    if let [volume] = stage.volumes.as_slice() {
        return Ok(*volume.volume.grid());
    }
    let grids = || stage.volumes.iter().map(|volume| volume.volume.grid());
    let corners = || grids().flat_map(Grid::world_corners);
    let (low, high) = (corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max));
    let spacing = grids().map(Grid::smallest_spacing).fold(f64::INFINITY, f64::min);
    // Grids of several voxels along each axis have their corners in the outermost ones.
    let cells = ((high - low) / spacing).ceil().clamp(DVec3::ONE, DVec3::splat(MOST));
    let sides = ((high - low) / cells).max(DVec3::splat(spacing * 1e-3));
    let dims = cells.to_array().map(|n| n as usize + 1);
    Grid::with_affine(dims, DAffine3::from_translation(low) * DAffine3::from_scale(sides))
}

/// Where light and slabs are.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// The grid whose box they are around.
    pub grid: Grid,
    /// The light's picture.
    pub frame: LightFrame,
    /// The slabs.
    pub slabs: Slabs,
    /// How far light travels in them.
    pub ways: Ways,
    /// The longest way, in world units.
    pub longest: f64,
}

/// How far light travels in a slab.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ways {
    /// So many steps.
    Same(f32),
    /// From a light at this coordinate of the slabs; a step in world units.
    From {
        /// Coordinate of the light.
        place: f32,
        /// World length of a step.
        step: f32,
    },
}

impl Geometry {
    /// For a light and the eye of a stage that looks at a grid; `None` if the light stands in its box, or beside
    /// it.
    pub fn new(stage: &Stage, grid: &Grid, settings: &HalfAngle, light: &ResolvedLight) -> Option<Self> {
        let frame = LightFrame::new(light, grid, settings.resolution)?;
        let view = &stage.viewpoint;
        let toward = (grid.center() - view.eye).try_normalize().filter(|_| view.perspective).unwrap_or(view.forward);
        let rays = frame.corner_rays();
        let axis = along_light(slice_axis(toward, frame.forward), frame.forward, &rays);
        // So that a ray of the eye in the middle has its samples a step apart.
        let thickness = stage.step * axis.dot(toward).abs().max(0.1);
        Some(Self::across(stage.step, grid, frame, axis, thickness))
    }

    /// For a light alone: slabs across its middle direction, a step apart; `None` as above.
    pub fn of_light(step: f64, grid: &Grid, light: &ResolvedLight, resolution: u32) -> Option<Self> {
        let frame = LightFrame::new(light, grid, resolution)?;
        let axis = frame.forward;
        Some(Self::across(step, grid, frame, axis, step))
    }

    fn across(step: f64, grid: &Grid, frame: LightFrame, axis: DVec3, thickness: f64) -> Self {
        let rays = frame.corner_rays();
        let slabs = Slabs::new(axis, thickness, grid);
        let thickness = slabs.thickness;
        let ways = match frame.position() {
            None => Ways::Same((thickness / axis.dot(frame.forward) / step) as f32),
            Some(position) => Ways::From { place: slabs.coordinate(position) as f32, step: step as f32 },
        };
        let steepest = rays.iter().map(|ray| ray.dot(axis)).fold(1.0, f64::min);
        let depth = thickness * slabs.count as f64;
        Self { grid: *grid, frame, slabs, ways, longest: thickness.min(depth) / steepest }
    }
}

/// Weights of direct light that is scattered into the cone, over those of light that is thrown straight on (Eq. 6.8): of
/// several volumes that hold light back the mean.
pub fn into_cone(stage: &Stage, settings: &HalfAngle) -> [f32; 3] {
    let cosine = (settings.blur_angle.to_radians() / 2.0).cos() as f32;
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for number in merge_order(stage).into_iter().filter(|&number| stage.overlap.holds_back(number)) {
        let Scattering { phase, phase_normalization, .. } = &stage.volumes[number].scattering;
        let g = phase.anisotropy().unwrap_or(0.0);
        let [cone, forward] = [cosine, 1.0].map(|mu| phase.weight(*phase_normalization, g, mu));
        for channel in 0..3 {
            sum[channel] += if forward[channel] > 0.0 { cone[channel] / forward[channel] } else { 1.0 };
        }
        count += 1.0;
    }
    sum.map(|weights| weights / count)
}
