//! From a document and loaded volumes to a stage: everything automatic is chosen, and said.

use std::cell::LazyCell;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use pellucid_field::{FieldError, Grid, Volume, VoxelType};
use pellucid_optics::{Light, Lighting, OpticsError, Preset, ResolvedLight, Scale};

use serde_json::json;

use crate::auto::{self, Chosen};
use crate::brightness::{alpha, brightness};
use crate::choice::Choice;
use crate::framing::Framed;
use crate::fused::fuse;
use crate::origin::{counted_from, origin_of};
use crate::{
    Colors, Crop, ImageSettings, Invalid, Mode, Overlap, Region, Scene, Stage, StageVolume, Technique, Viewpoint,
    VolumeEntry, holds_alpha, holds_colors,
};

/// Why a scene does not fit its volumes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResolveError {
    /// A value out of range.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The scene lists another number of volumes than were loaded, or none.
    #[error("the scene lists {listed} volumes and {loaded} were loaded; at least one is needed")]
    Volumes {
        /// Volumes in the document.
        listed: usize,
        /// Volumes loaded.
        loaded: usize,
    },
    /// A component that the volume does not have.
    #[error("volumes[{volume}].component is {found}, but the volume has {components} (numbered from 0)")]
    Component {
        /// Position in the list.
        volume: usize,
        /// The component asked for.
        found: usize,
        /// Components per voxel.
        components: usize,
    },
    /// Colours asked for of voxels that are none.
    #[error(
        "volumes[{volume}].colors is \"data\", and {components} x {voxel_type} to a voxel are no colours: those are 3 or 4 \
         components of u8 or u16"
    )]
    Colors {
        /// Position in the list.
        volume: usize,
        /// Components per voxel.
        components: usize,
        /// Their type.
        voxel_type: VoxelType,
    },
    /// A spacing that does not fit the grid.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// Optics that cannot be made: an unknown name, a window that does not fit.
    #[error("{path}: {error}")]
    Optics {
        /// Where in the document.
        path: String,
        /// What is wrong.
        error: OpticsError,
    },
}

impl Scene {
    /// Fills in what is left automatic for the loaded volumes (one per entry, in order).
    ///
    /// # Errors
    /// [`ResolveError`].
    pub fn resolve(&self, volumes: &[Arc<Volume>]) -> Result<(Stage, Vec<Choice>), ResolveError> {
        let (stage, choices, _) = self.fill_in(volumes)?;
        Ok((stage, choices))
    }

    /// The scene with what is chosen for the loaded volumes written down: preset, window, unit distance, component,
    /// lights and camera. It draws the same picture, whatever becomes of the data and of automatic choices;
    /// what has no effect beside a transfer function in full is left out.
    ///
    /// # Errors
    /// [`ResolveError`].
    pub fn settled(&self, volumes: &[Arc<Volume>]) -> Result<Self, ResolveError> {
        Ok(self.fill_in(volumes)?.2)
    }

    fn fill_in(&self, volumes: &[Arc<Volume>]) -> Result<(Stage, Vec<Choice>, Self), ResolveError> {
        self.validate()?;
        if volumes.is_empty() || volumes.len() != self.volumes.len() {
            return Err(ResolveError::Volumes { listed: self.volumes.len(), loaded: volumes.len() });
        }
        let mut choices = Vec::new();
        let mut staged = Vec::new();
        let mut settled = self.clone();
        for (k, volume) in volumes.iter().enumerate() {
            let known = choices.len();
            let (volume, chosen) = self.stage_volume(k, volume, &mut choices)?;
            if volumes.len() > 1 {
                choices[known..].iter_mut().for_each(|choice| choice.chosen += &format!(", for volumes[{k}]"));
            }
            settle(&mut settled.volumes[k], &volume, chosen);
            staged.push(volume);
        }
        let technique = self.ordered_technique(staged.first().map_or(0.0, |volume| volume.origin));
        let ImageSettings { width, height, .. } = self.image;
        let framed = {
            // A camera that is given in full asks nothing of the data.
            let framed = LazyCell::new(|| {
                let framed = |volume| Framed::new(volume, technique.mode(), self.camera.frame);
                staged.iter().map(framed).collect::<Vec<_>>()
            });
            let support = |d: DVec3| framed.iter().map(|framed| framed.support(d)).fold(f64::NEG_INFINITY, f64::max);
            self.camera.framing(width as usize, height as usize, &support)
        };
        settled.camera = auto::settled_camera(&self.camera, &framed);
        // What is written down is what is drawn, to the bit.
        let viewpoint = settled.camera.viewpoint(width as usize, height as usize, &[]);
        let overlap = if technique.needs().overlap { self.overlap } else { Overlap::Add };
        fuse(overlap, &mut staged).map_err(|error| ResolveError::Optics { path: "overlap".to_owned(), error })?;
        choices.extend(auto::camera_choice(&self.camera, &viewpoint));
        choices.extend(auto::lights_choice(&self.lighting, &self.technique));
        settled.lighting.lights = auto::lights(&self.lighting, &self.technique).to_vec();
        let smallest = staged.iter().map(|v| v.volume.grid().smallest_spacing()).fold(f64::INFINITY, f64::min);
        let stage = Stage {
            lights: world_lights(&self.lighting, &self.technique, &viewpoint)?,
            ambient: self.lighting.ambient,
            shadows: self.lighting.shadows,
            light_model: self.lighting.model,
            volumes: staged,
            overlap,
            viewpoint,
            technique,
            quality: self.quality.clone(),
            image: self.image.clone(),
            step: self.quality.step * smallest,
        };
        Ok((stage, choices, settled))
    }

    fn stage_volume(
        &self,
        k: usize,
        loaded: &Arc<Volume>,
        choices: &mut Vec<Choice>,
    ) -> Result<(StageVolume, Chosen), ResolveError> {
        let entry = &self.volumes[k];
        let colors = self.data_colors(k, loaded)?.then(|| loaded.clone());
        let (volume, component) = component_of(k, entry, loaded, colors.is_some(), choices)?;
        let entry = &if colors.is_some() { in_data_colors(entry, loaded) } else { entry.clone() };
        let volume = match entry.spacing {
            None => volume,
            Some(spacing) => Arc::new((*volume).clone().with_grid(respaced(volume.grid(), spacing)?)?),
        };
        let mut region = Region::from_clips(&self.clips);
        if let Some(crop) = &entry.crop {
            keep_crop(&mut region, volume.grid(), crop);
        }
        if let Some(file) = entry.scattering.phase.file().filter(|_| entry.scattering.phase.is_unread()) {
            let error = OpticsError::PhaseFile { file: file.to_owned(), problem: "it has not been read".to_owned() };
            return Err(ResolveError::Optics { path: format!("volumes[{k}].scattering.phase"), error });
        }
        let path = format!("volumes[{k}]");
        let (optics, chosen) = auto::optics(entry, &volume, component, self.technique.mode(), choices)
            .map_err(|error| ResolveError::Optics { path, error })?;
        let (origin, mut volume) = (origin_of(&volume), volume);
        if let Some(origin) = origin {
            let coarse = if volume.voxels().voxel_type().is_integer() {
                "tells integers apart up to 2^24"
            } else {
                "is too coarse that far from 0"
            };
            let chosen = format!("drawn as differences to {origin}, as single precision {coarse}");
            choices.push(Choice::new("values", origin, chosen));
            volume = counted_from(&volume, origin)?;
        }
        let origin = origin.unwrap_or_default();
        let staged = StageVolume {
            component,
            colors,
            transfer_function: optics.transfer_function.counted_from(origin),
            material: optics.material,
            gradient_weight: optics.gradient_weight,
            scattering: entry.scattering.clone().counted_from(origin),
            perturbation: entry.perturbation.clone().counted_from(origin),
            region,
            crop: entry.crop,
            volume,
            origin,
        };
        Ok((staged, chosen))
    }

    /// Whether a volume is drawn in the colours of its voxels.
    fn data_colors(&self, k: usize, volume: &Volume) -> Result<bool, ResolveError> {
        let VolumeEntry { colors, component, preset, colormap, transfer_function, .. } = &self.volumes[k];
        let told = component.is_some() || preset.is_some() || colormap.is_some() || transfer_function.is_some();
        let heeded = self.technique.needs().data_colors;
        match colors {
            Some(Colors::TransferFunction) => Ok(false),
            Some(Colors::Data) if holds_colors(volume) => Ok(heeded),
            Some(Colors::Data) => Err(ResolveError::Colors {
                volume: k,
                components: volume.components(),
                voxel_type: volume.voxels().voxel_type(),
            }),
            None => Ok(heeded && !told && holds_colors(volume)),
        }
    }

    /// With isovalues in their order, less the value that those of the volume count from.
    fn ordered_technique(&self, origin: f64) -> Technique {
        let mut technique = self.technique.clone();
        if let Some(Mode::Isosurface(surfaces)) = technique.mode_mut() {
            surfaces.isovalues.iter_mut().for_each(|iso| iso.value -= origin);
            surfaces.isovalues.sort_by(|a, b| a.value.total_cmp(&b.value));
        }
        technique
    }
}

impl Scene {
    /// Whether the window of a volume decides anything of its look; see [`VolumeEntry::window`].
    pub fn heeds_window(&self, entry: &VolumeEntry, volume: &Volume) -> bool {
        auto::heeds_window(entry, volume, self.technique.mode())
    }
}

impl Stage {
    /// Moves the eye, and with it the lights of the scene's `lighting` that stand in its frame.
    /// Nothing else is chosen anew.
    ///
    /// # Errors
    /// [`ResolveError::Optics`] for a light that cannot be.
    pub fn look_from(&mut self, viewpoint: Viewpoint, lighting: &Lighting) -> Result<(), ResolveError> {
        self.lights = world_lights(lighting, &self.technique, &viewpoint)?;
        self.viewpoint = viewpoint;
        Ok(())
    }
}

/// An entry whose voxels have colours: nothing tints them unless it is asked for, and alpha is opacity.
fn in_data_colors(entry: &VolumeEntry, colors: &Volume) -> VolumeEntry {
    let mut entry = entry.clone();
    if entry.transfer_function.is_some() {
        return entry;
    }
    entry.colormap.get_or_insert_with(|| "white".to_owned());
    if entry.component.is_none() && entry.preset.is_none() && holds_alpha(colors) {
        entry.opacity.get_or_insert_with(|| "linear".to_owned());
        let most = if colors.voxels().voxel_type() == VoxelType::U8 { u8::MAX.into() } else { u16::MAX.into() };
        entry.window.get_or_insert_with(|| [0.0, most].map(|stored: f64| colors.value_map().value(stored)));
    }
    entry
}

/// Writes down what was chosen for an entry.
fn settle(entry: &mut VolumeEntry, staged: &StageVolume, chosen: Chosen) {
    if staged.colors.is_some() {
        entry.colors = Some(Colors::Data);
    }
    (entry.preset, entry.window) = (chosen.preset, chosen.window);
    (entry.colormap, entry.opacity) = (chosen.colormap, chosen.opacity);
    if staged.volume.components() > 1 {
        entry.component = Some(staged.component);
    }
    if let Some(tf) = &entry.transfer_function {
        let preset = entry.preset.as_deref().and_then(|name| Preset::by_name(name).ok());
        (entry.colormap, entry.opacity) = (None, None);
        // A relative preset spreads its gradient weight over the window.
        entry.window = entry.window.filter(|_| preset.is_some_and(|preset| preset.scale == Scale::Relative));
        if tf.unit_distance().is_none() {
            entry.unit_distance.get_or_insert(staged.unit_distance());
        }
        return;
    }
    let own = entry.preset.as_deref().and_then(|name| Preset::by_name(name).ok()?.transfer_function.unit_distance());
    if own.is_none() {
        entry.unit_distance.get_or_insert(staged.unit_distance());
    }
}

/// The volume and the component of it that are drawn for an entry: of voxels that are `colored`, those that give opacity.
fn component_of(
    k: usize,
    entry: &VolumeEntry,
    volume: &Arc<Volume>,
    colored: bool,
    choices: &mut Vec<Choice>,
) -> Result<(Arc<Volume>, usize), ResolveError> {
    let components = volume.components();
    match entry.component {
        Some(found) if found >= components => Err(ResolveError::Component { volume: k, found, components }),
        Some(component) => Ok((volume.clone(), component)),
        None if components == 1 => Ok((volume.clone(), 0)),
        None if colored && holds_alpha(volume) => {
            let chosen = "4 components are drawn as colours and the opacity that they have".to_owned();
            choices.push(Choice::new("component", json!("alpha"), chosen));
            Ok((alpha(volume)?.map_or_else(|| volume.clone(), Arc::new), 0))
        }
        None if colored => {
            let chosen = format!(
                "{components} components are drawn as colours, with opacity by their brightness; volumes[{k}].colors = \
                 \"transfer_function\" draws the brightness in other colours"
            );
            choices.push(Choice::new("component", json!("brightness"), chosen));
            Ok((brightness(volume)?.map_or_else(|| volume.clone(), Arc::new), 0))
        }
        None => {
            let bright = brightness(volume)?;
            let (value, what) = match bright {
                Some(_) => (json!("brightness"), "their brightness is drawn, in the colours of the transfer function"),
                None => (json!(0), "only number 0 is drawn"),
            };
            let last = components - 1;
            let chosen =
                format!("{components} components, {what}; volumes[{k}].component 0 to {last} draws one of them");
            choices.push(Choice::new("component", value, chosen));
            Ok((bright.map_or_else(|| volume.clone(), Arc::new), 0))
        }
    }
}

fn world_lights(
    lighting: &Lighting,
    technique: &Technique,
    view: &Viewpoint,
) -> Result<Vec<ResolvedLight>, ResolveError> {
    let world_from_camera =
        DAffine3 { matrix3: DMat3::from_cols(view.right, view.up, -view.forward), translation: view.eye };
    let resolve = |(k, light): (usize, &Light)| {
        let path = format!("lighting.lights[{k}]");
        light.resolve(world_from_camera).map_err(|error| ResolveError::Optics { path, error })
    };
    auto::lights(lighting, technique).iter().enumerate().map(resolve).collect()
}

/// A grid with the same axes and origin and another distance between samples.
fn respaced(grid: &Grid, spacing: [f64; 3]) -> Result<Grid, FieldError> {
    let mut affine = grid.world_from_index();
    let old = grid.spacing();
    for axis in 0..3 {
        *affine.matrix3.col_mut(axis) *= spacing[axis] / old[axis];
    }
    Grid::with_affine(grid.dims(), affine)
}

/// Keeps the part of a grid between two continuous indices.
fn keep_crop(region: &mut Region, grid: &Grid, crop: &Crop) {
    let world_from_index = grid.world_from_index();
    for axis in 0..3 {
        // A plane of constant index has the world gradient of that index as its normal.
        let normal = grid.world_from_index_gradient().col(axis).normalize();
        for (bound, side) in [(crop.from, 1.0), (crop.to, -1.0)] {
            region.keep(normal * side, world_from_index.transform_point3(DVec3::from_array(bound)));
        }
    }
}
