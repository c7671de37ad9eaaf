//! What lights isosurfaces.

use pellucid::scene::{GlobalIllumination, Illumination, Mode, Scene};

use crate::failure::Failure;
use crate::values;

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Light of surfaces")]
pub struct IlluminationFlags {
    /// Light surfaces (--iso) by all light that arrives: from around, from the lights, and from the surface itself
    ///
    /// Light is followed from places of a lattice beside what is seen, and kept while one scene is drawn. 'pellucid bake' saves
    /// it. From around there comes white light, unless --set
    /// technique.ray_cast.mode.isosurface.illumination.global.environment says otherwise, and the lights are then those of
    /// --light.
    #[arg(long, conflicts_with = "ambient_occlusion")]
    global_illumination: bool,
    /// Light surfaces (--iso) by how much of a white sky each place of them sees, at a distance in world units or, if none is
    /// said, over the whole volume
    #[arg(long, value_name = "DISTANCE", num_args = 0..=1, require_equals = true, default_missing_value = "inf",
        value_parser = distance)]
    ambient_occlusion: Option<f64>,
}

fn distance(text: &str) -> Result<f64, String> {
    if text == "inf" { Ok(f64::INFINITY) } else { values::number(text) }
}

impl IlluminationFlags {
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        let (flag, global) = match self.ambient_occlusion {
            Some(distance) => {
                let within = Some(distance).filter(|distance| distance.is_finite());
                ("--ambient-occlusion", GlobalIllumination::ambient_occlusion(within))
            }
            None if self.global_illumination => ("--global-illumination", GlobalIllumination::default()),
            None => return Ok(()),
        };
        let Some(Mode::Isosurface(surfaces)) = scene.technique.mode_mut() else {
            let message = format_args!("{flag} is about the light of surfaces, and none is drawn");
            return Err(Failure::input(message).hint("add --iso VALUE"));
        };
        surfaces.illumination = Illumination::Global(global);
        Ok(())
    }
}
