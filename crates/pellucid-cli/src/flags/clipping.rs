//! What is cut away, and which part of the data is drawn.

use pellucid::scene::{Clip, Crop, Scene};

use super::first_volume;
use crate::failure::Failure;
use crate::values;

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Clipping and data")]
pub struct ClippingFlags {
    /// Keep the side of a plane its normal points to: normal, then a world position on the plane.
    /// Repeatable; clips on the command line replace those of the scene file
    #[arg(long, value_name = "NX,NY,NZ,PX,PY,PZ", value_parser = values::numbers::<6>, allow_hyphen_values = true)]
    clip: Vec<[f64; 6]>,
    /// Keep the inside of a box along the world's axes: lowest, then highest corner
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = values::numbers::<6>, allow_hyphen_values = true)]
    clip_box: Option<[f64; 6]>,
    /// Keep the voxels between two indices, first and last; the rest is absent
    #[arg(long, value_name = "I0,J0,K0,I1,J1,K1", value_parser = values::numbers::<6>, allow_hyphen_values = true)]
    crop: Option<[f64; 6]>,
    /// Which component of the voxels is drawn, from 0 [default: the first; of colours
    /// the brightness, or the alpha if it varies]
    #[arg(long, value_name = "K")]
    component: Option<usize>,
    /// Distance between samples per axis in world units [default: the file's]
    #[arg(long, value_name = "SXxSYxSZ", value_parser = values::lengths, allow_hyphen_values = true)]
    spacing: Option<[f64; 3]>,
}

impl ClippingFlags {
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        let planes = self.clip.iter().map(|&six| {
            let (normal, point) = halves(six);
            Clip::Plane { point, normal }
        });
        let boxes = self.clip_box.iter().map(|&six| {
            let (min, max) = halves(six);
            Clip::Box { min, max }
        });
        let clips: Vec<Clip> = planes.chain(boxes).collect();
        if !clips.is_empty() {
            scene.clips = clips;
        }
        if let Some(six) = self.crop {
            let (from, to) = halves(six);
            first_volume(scene, "--crop")?.crop = Some(Crop { from, to });
        }
        if self.component.is_some() {
            first_volume(scene, "--component")?.component = self.component;
        }
        if self.spacing.is_some() {
            first_volume(scene, "--spacing")?.spacing = self.spacing;
        }
        Ok(())
    }
}

fn halves([a, b, c, d, e, f]: [f64; 6]) -> ([f64; 3], [f64; 3]) {
    ([a, b, c], [d, e, f])
}
