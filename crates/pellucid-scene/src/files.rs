//! The files that a scene names.

use std::path::PathBuf;

use pellucid_optics::{Environment, SkySource};

use crate::{HeightSource, Mode, ModelSource, Scene, Source};

impl Scene {
    /// Every name of a file in the scene, to be looked at or changed: volumes, maps of heights, phase functions, the
    /// picture of the sky, and saved light.
    pub fn files_mut(&mut self) -> Vec<&mut PathBuf> {
        let mut files = Vec::new();
        for entry in &mut self.volumes {
            match &mut entry.source {
                Source::File(path) | Source::Raw { path, .. } => files.push(path),
                Source::Model(ModelSource::HeightField(land)) => {
                    if let HeightSource::File(path) = &mut land.map {
                        files.push(path);
                    }
                }
                Source::Model(ModelSource::Clouds(_) | ModelSource::Spectral(_))
                | Source::Sample(_)
                | Source::Memory(_) => {}
            }
            files.extend(entry.scattering.phase.file_mut());
        }
        let environment = match self.technique.mode().global_illumination() {
            None => self.technique.environment_mut(),
            Some(_) => self.technique.mode_mut().and_then(Mode::global_illumination_mut).map(|global| {
                files.extend(&mut global.file);
                &mut global.environment
            }),
        };
        if let Some(Environment::Image(image)) = environment
            && let SkySource::File(path) = &mut image.source
        {
            files.push(path);
        }
        files
    }
}
