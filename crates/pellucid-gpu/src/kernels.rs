//! Filters and gradients as shaders take them: the structure of `kernel.wgsl`.

use crate::four::Four;
use pellucid_field::{Filter, Gradient, Kernel};
use pellucid_plan::SAMPLES_PER_LOOK;

/// The most taps of a filter, and of a gradient under one: the widest sinc and the widest Gaussian.
const MOST_TAPS: usize = 16;
const MOST_GRADIENT_TAPS: usize = MOST_TAPS + MOST_STENCIL - 1;
const MOST_STENCIL: usize = 19;

/// Fours to a polynomial's coefficients.
const FOURS: usize = Kernel::COEFFICIENTS.div_ceil(4);

/// How the field is reconstructed: what [`Kernels::to_fours`] tells a shader.
pub struct Kernels {
    filter: Filter,
    gradient: Gradient,
    /// What a shader reads of a voxel that is classified, times the first and plus the second, is its
    /// data value.
    pub classified: [f64; 2],
}

impl Kernels {
    /// Filter and gradient of a stage. What is classified before it is interpolated is read as told.
    pub fn new(filter: Filter, gradient: Gradient, classified: [f64; 2]) -> Self {
        Self { filter, gradient, classified }
    }

    /// Looks at the blocks after which a pass must end, so that its loops have not too many rounds: Mesa's
    /// software driver ends all loops of an invocation after 65,535 of them, without a word, and other
    /// drivers take long ones for a hang.
    pub fn most_looks(&self) -> u32 {
        const ROUNDS: usize = 40_000;
        let values = Kernel::of_filter(self.filter).map_or(2, |kernel| kernel.taps());
        let slopes = Kernel::of_gradient(self.filter, self.gradient)[0].taps();
        let sample = values.pow(3) / 4 + values.pow(2) + slopes.pow(3) + slopes.pow(2);
        (ROUNDS / (SAMPLES_PER_LOOK * sample)).max(1) as u32
    }

    /// The structure's numbers.
    pub fn to_fours(&self) -> Vec<Four> {
        let bits = |numbers: [u32; 4]| numbers.map(f32::from_bits);
        let Self { filter, gradient, .. } = *self;
        // Linear interpolation has a path of its own; its two taps are for classified voxels.
        let values = Kernel::of_filter(filter);
        let slopes = Kernel::of_gradient(filter, gradient);
        let taps = values.as_ref().map_or(0, Kernel::taps);
        let stencil = stencil(gradient);
        let spline = gradient == Gradient::BSpline;
        let rounded = filter == Filter::Nearest && !spline;
        let high = values.iter().chain(&slopes).any(|kernel| kernel.degree() > 3);
        let [x, y] = self.classified.map(|v| v as f32);
        let mut fours = vec![
            bits([taps, slopes[0].taps(), stencil.len() / 2, taps].map(|n| n as u32)),
            bits([spline, rounded, high, false].map(u32::from)),
            [x, y, 0.0, 0.0],
        ];
        let polynomials = fours.len() + MOST_STENCIL;
        fours.extend(stencil);
        fours.resize(polynomials, [0.0; 4]);
        for kernel in values.iter().chain(&slopes) {
            for tap in 0..kernel.taps() {
                let mut coefficients = [0.0; 4 * FOURS];
                coefficients[..Kernel::COEFFICIENTS].copy_from_slice(kernel.polynomial(tap));
                fours.extend_from_slice(coefficients.as_chunks().0);
            }
        }
        fours.resize(polynomials + FOURS * (MOST_TAPS + 2 * MOST_GRADIENT_TAPS), [0.0; 4]);
        fours
    }
}

/// Voxels beyond the eight around a position that its value and its gradient are made of.
pub fn reach(filter: Filter, gradient: Gradient) -> usize {
    filter.half_width() - 1 + stencil(gradient).len() / 2
}

/// Smoothing across and derivative along an axis, of samples one voxel apart. Where a B-spline lacks
/// voxels, differences are central.
fn stencil(gradient: Gradient) -> Vec<Four> {
    let differences = || [vec![0.0, 1.0, 0.0], vec![-0.5, 0.0, 0.5]];
    let [across, along] = gradient.stencil().unwrap_or_else(differences);
    across.iter().zip(along).map(|(&a, b)| [a as f32, b as f32, 0.0, 0.0]).collect()
}

#[cfg(test)]
mod tests {
    use pellucid_field::SincWindow;

    use super::*;

    /// The sizes of `kernel.wgsl` hold what there may be at most, and no more.
    #[test]
    fn the_widest_sums_fit() {
        let filter = Filter::Sinc { window: SincWindow::Kaiser, half_width: 8 };
        let gradient = Gradient::Gaussian { sigma: 3.0 };
        assert_eq!(Kernel::of_filter(filter).unwrap().taps(), MOST_TAPS);
        assert_eq!(Kernel::of_gradient(filter, gradient)[0].taps(), MOST_GRADIENT_TAPS);
        assert_eq!(stencil(gradient).len(), MOST_STENCIL);
        let source = include_str!("shaders/kernel.wgsl");
        for text in ["vec4<f32>, 19>", "vec4<f32>, 336>", "MOST_FOURS: u32 = 4u", "MOST_GRADIENT_TAPS: u32 = 34u"] {
            assert!(source.contains(text), "{text}");
        }
        for gradient in [gradient, Gradient::Central, Gradient::BSpline] {
            let fours = Kernels::new(filter, gradient, [1.0, 0.0]).to_fours();
            assert_eq!(fours.len(), 3 + 19 + 336);
        }
    }
}
