//! Light from far away in spherical harmonics, for places that know what becomes of it (G-11, G-13).

use glam::DQuat;
use pellucid_optics::{Bands, Environment, Harmonics, ResolvedLight, Rotation, Window};
use pellucid_scene::Stage;

/// The light of the last stage.
#[derive(Default)]
pub struct DistantLight {
    /// The sky before it is turned, and its light.
    sky: Option<(Environment, Bands, Harmonics)>,
    /// All light, of what.
    last: Option<Asked>,
    light: Distant,
}

/// A sky, lights, and how they are told.
type Asked = (Environment, Vec<ResolvedLight>, (Bands, Option<Window>));

/// Coefficients of light, red, green and blue, and a number that other light does not have.
#[derive(Clone, Debug, Default)]
pub struct Distant {
    /// As many as its bands have.
    pub coefficients: Vec<[f32; 3]>,
    /// Of this light.
    pub number: u32,
}

impl DistantLight {
    /// The light of a stage: its directional lights and its sky, which is looked at once, and then turned.
    pub fn of(&mut self, stage: &Stage, (bands, window): (Bands, Option<Window>)) -> Distant {
        let environment = stage.technique.environment().cloned().unwrap_or_default();
        let asked = (environment, stage.lights.clone(), (bands, window));
        if self.last.as_ref() != Some(&asked) {
            let mut light = self.sky(asked.0.clone(), bands);
            for source in &stage.lights {
                // Stages warn of lights that are not far away.
                let _ = light.add_light(source);
            }
            if let Some(window) = window {
                light = light.windowed(window);
            }
            let coefficients = light.coefficients().iter().map(|rgb| rgb.map(|v| v as f32)).collect();
            self.light = Distant { coefficients, number: 1 + self.light.number % (u32::MAX / 2) };
            self.last = Some(asked);
        }
        self.light.clone()
    }

    /// The light of a sky.
    fn sky(&mut self, mut environment: Environment, bands: Bands) -> Harmonics {
        let mut turn = 0.0;
        if let Environment::Image(image) = &mut environment {
            turn = std::mem::take(&mut image.rotation);
        }
        let unturned = match &self.sky {
            Some((of, in_bands, light)) if *of == environment && *in_bands == bands => *light,
            _ => {
                let sky = environment.resolve().ok().flatten();
                let light = sky.map_or(Harmonics::dark(bands), |sky| Harmonics::of_sky(bands, &sky));
                self.sky = Some((environment, bands, light));
                light
            }
        };
        unturned.rotated(&Rotation::new(DQuat::from_rotation_z(turn.to_radians())))
    }
}
