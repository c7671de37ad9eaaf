//! How carefully to draw.

use pellucid::field::{Filter, Gradient, SincWindow};
use pellucid::scene::{Classification, Jitter, Scene};

use crate::values;

/// Every kind of reconstruction by its name.
pub const FILTERS: [(&str, Filter); 7] = [
    ("nearest", Filter::Nearest),
    ("linear", Filter::Linear),
    ("b-spline", Filter::BSpline { prefilter: true }),
    ("b-spline-smooth", Filter::BSpline { prefilter: false }),
    ("catmull-rom", Filter::CATMULL_ROM),
    ("mitchell", Filter::MITCHELL),
    ("lanczos", Filter::Sinc { window: SincWindow::Lanczos, half_width: 3 }),
];

/// Every gradient estimator by its name.
pub const GRADIENTS: [(&str, Gradient); 8] = [
    ("forward", Gradient::Forward),
    ("backward", Gradient::Backward),
    ("central", Gradient::Central),
    ("sobel", Gradient::Sobel),
    ("sobel-isotropic", Gradient::SobelIsotropic),
    ("prewitt", Gradient::Prewitt),
    ("gaussian", Gradient::Gaussian { sigma: 1.0 }),
    ("b-spline", Gradient::BSpline),
];

const CLASSIFICATIONS: [(&str, Classification); 3] =
    [("post", Classification::Post), ("pre", Classification::Pre), ("pre-integrated", Classification::PreIntegrated)];

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Quality")]
pub struct QualityFlags {
    /// Distance between samples in units of the smallest voxel spacing, 0.01 to 100 [default: 0.5]
    #[arg(long, value_name = "VOXELS", value_parser = values::number, allow_hyphen_values = true)]
    step: Option<f64>,
    /// Reconstruction between voxels; b-spline passes through the voxels, b-spline-smooth between
    /// them, lanczos has a half width of 3 voxels [default: linear]
    #[arg(long, value_name = "KERNEL", value_parser = values::word(&FILTERS))]
    filter: Option<Filter>,
    /// Gradient estimator for shading; gaussian has a sigma of 1 voxel [default: central]
    #[arg(long, value_name = "ESTIMATOR", value_parser = values::word(&GRADIENTS))]
    gradient: Option<Gradient>,
    /// Where the transfer function is applied: to interpolated values, to voxels, or to ray
    /// segments [default: post]
    #[arg(long, value_name = "WHERE", value_parser = values::word(&CLASSIFICATIONS))]
    classification: Option<Classification>,
    /// First sample of a ray: 'centered' in its step, or 'blue-noise' (with =SEED, a whole number)
    /// to trade banding for fine noise [default: centered]
    #[arg(long, value_name = "centered|blue-noise[=SEED]", value_parser = jitter)]
    jitter: Option<Jitter>,
    /// A ray stops at this opacity, above 0 to 1; 1 never stops early [default: 0.999]
    #[arg(long, value_name = "OPACITY", value_parser = values::number32, allow_hyphen_values = true)]
    early_termination: Option<f32>,
    /// Take longer steps where they change colour or opacity by no more than this, 0 to 1; 0 takes
    /// every sample [default: 0]
    #[arg(long, value_name = "TOLERANCE", value_parser = values::number32, allow_hyphen_values = true)]
    adaptive: Option<f32>,
    /// Do not leap over empty blocks; the picture is the same, only slower
    #[arg(long)]
    no_skip: bool,
    /// Rays per pixel and axis, 1 to 16: 2 draws four rays a pixel [default: 1]
    #[arg(long, value_name = "N")]
    supersampling: Option<u32>,
}

impl QualityFlags {
    pub fn apply(&self, scene: &mut Scene) {
        let quality = &mut scene.quality;
        quality.step = self.step.unwrap_or(quality.step);
        quality.filter = self.filter.unwrap_or(quality.filter);
        quality.gradient = self.gradient.unwrap_or(quality.gradient);
        quality.classification = self.classification.unwrap_or(quality.classification);
        quality.jitter = self.jitter.unwrap_or(quality.jitter);
        quality.early_termination = self.early_termination.unwrap_or(quality.early_termination);
        quality.adaptive_tolerance = self.adaptive.unwrap_or(quality.adaptive_tolerance);
        quality.empty_space_skipping &= !self.no_skip;
        quality.supersampling = self.supersampling.unwrap_or(quality.supersampling);
    }
}

fn jitter(text: &str) -> Result<Jitter, String> {
    match text.split_once('=') {
        None if text == "centered" => Ok(Jitter::Centered),
        None if text == "blue-noise" => Ok(Jitter::BlueNoise { seed: 0 }),
        Some(("blue-noise", seed)) => match seed.parse() {
            Ok(seed) => Ok(Jitter::BlueNoise { seed }),
            Err(_) => Err(format!("the seed '{seed}' is not a whole number from 0 to {}", u32::MAX)),
        },
        _ => Err("expected centered, blue-noise or blue-noise=SEED".into()),
    }
}
