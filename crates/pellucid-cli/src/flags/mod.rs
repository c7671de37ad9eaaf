//! The flags that change a scene, one group per part of the document.

mod camera;
mod channels;
mod clipping;
mod given;
mod illumination;
mod look;
mod picture;
pub mod quality;
pub mod technique;

use std::sync::Arc;

use pellucid::field::Volume;
use pellucid::scene::{Camera, Choice, Orbit, Scene, Stage, View, VolumeEntry};
use pellucid::without_effect;

use super::failure::Failure;
use super::input::Base;
use super::set::Setting;
use given::Given;

/// Every flag that changes the scene. What is not given leaves the scene as it is.
#[derive(clap::Args, Debug)]
pub struct SceneFlags {
    #[command(flatten)]
    given: Given,
    #[command(flatten)]
    picture: picture::PictureFlags,
    #[command(flatten)]
    camera: camera::CameraFlags,
    #[command(flatten)]
    look: look::LookFlags,
    #[command(flatten)]
    channels: channels::ChannelFlags,
    #[command(flatten)]
    technique: technique::TechniqueFlags,
    #[command(flatten)]
    illumination: illumination::IlluminationFlags,
    #[command(flatten)]
    quality: quality::QualityFlags,
    #[command(flatten)]
    clipping: clipping::ClippingFlags,
    /// Change any setting of the scene; the last word over file and flags. Repeatable
    ///
    /// PATH is where the setting stands in the scene document, as in
    ///   --set quality.step=0.25
    ///   --set volumes[0].window=[100,900]
    ///   --set technique.ray_cast.mode.slice.thickness=5
    /// VALUE is written as in TOML; a bare word is taken as text, and nothing at all removes the
    /// setting, so that its default returns. 'pellucid schema' lists every path.
    #[arg(long = "set", value_name = "PATH=VALUE", help_heading = "Any setting", verbatim_doc_comment)]
    settings: Vec<Setting>,
}

/// A scene with nothing left to its flags, and what it resolves to.
pub struct Staged {
    pub scene: Scene,
    pub stage: Stage,
    pub choices: Vec<Choice>,
    /// What was lost in reading files that flags name, and settings that have no effect.
    pub warnings: Vec<String>,
}

impl SceneFlags {
    /// The scene with all flags applied, and checked.
    pub fn apply(&self, base: &Scene) -> Result<Scene, Failure> {
        super::set::apply(&self.named(base)?, &self.settings)
    }

    /// The stage of the scene that [`SceneFlags::apply`] made of `base`, once what flags leave to the
    /// loaded volumes is filled in, and its optics are read.
    pub fn stage(&self, base: &Base, mut scene: Scene, volumes: &[Arc<Volume>]) -> Result<Staged, Failure> {
        base.load_optics(&mut scene)?;
        let (mut stage, mut choices) = scene.resolve(volumes)?;
        if let Some(settled) = self.settle(&base.scene, &stage, &choices)? {
            scene = settled;
            base.load_optics(&mut scene)?;
            let first = choices;
            (stage, choices) = scene.resolve(volumes)?;
            // What was chosen to settle with stays chosen.
            choices.extend(first.into_iter().filter(|choice| self.look.settles_with(choice)));
        }
        let idle = without_effect(&scene, &stage, &self.given.settings());
        let idle = idle.iter().map(|idle| self.given.in_words(idle));
        let warnings = self.look.warnings().iter().cloned().chain(idle).collect();
        Ok(Staged { scene, stage, choices, warnings })
    }

    /// Fills in what depends on the volumes and on what was chosen for them: a slice position in
    /// percent, the rest of a material of which flags give some numbers, and a look over the window
    /// that was chosen. `None` if there is no such flag.
    fn settle(&self, base: &Scene, stage: &Stage, choices: &[Choice]) -> Result<Option<Scene>, Failure> {
        let mut scene = self.named(base)?;
        let Some(volume) = stage.volumes.first() else { return Ok(None) };
        let placed = self.technique.place(&mut scene, volume) | self.look.spread(&mut scene, volume, choices)?;
        let changed = self.look.change_material(&mut scene, volume.material);
        if placed || changed { super::set::apply(&scene, &self.settings).map(Some) } else { Ok(None) }
    }

    /// The scene with the named flags applied.
    fn named(&self, base: &Scene) -> Result<Scene, Failure> {
        let mut scene = base.clone();
        self.camera.apply(&mut scene)?;
        let Camera { projection, view, .. } = scene.camera;
        let view = match view {
            View::Orbit(orbit) => View::Orbit(Orbit { zoom: Orbit::default().zoom, ..orbit }),
            View::LookAt(_) => view,
        };
        let free = (Camera { projection, view, ..Camera::default() }) == Camera::default() && !self.camera.is_given();
        self.technique.apply(&mut scene, free)?;
        self.illumination.apply(&mut scene)?;
        // A look depends on the technique, and other flags change parts of it.
        self.look.apply_bundle(&mut scene);
        self.picture.apply(&mut scene);
        self.look.apply(&mut scene)?;
        self.quality.apply(&mut scene);
        self.clipping.apply(&mut scene)?;
        // Layers are otherwise as the volume that flags describe.
        self.channels.apply(&mut scene)?;
        Ok(scene)
    }
}

/// The volume that flags about a volume mean: the first.
fn first_volume<'s>(scene: &'s mut Scene, flag: &str) -> Result<&'s mut VolumeEntry, Failure> {
    let missing = || Failure::input(format_args!("{flag} is about a volume, and the scene lists none"));
    scene.volumes.first_mut().ok_or_else(missing)
}
