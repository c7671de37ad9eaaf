//! The mean of frames.

use pellucid_field::parallel;
use pellucid_scene::{Frame, RenderWarning};
use rayon::prelude::*;

/// Fewer pixels are done before another thread has woken up.
const LEAST: usize = 1 << 14;

/// Takes a frame into a mean, of which it becomes this share. Colour, which is associated, is averaged, and noise as
/// that of independent frames; samples and totals are summed; a warning stays as long as it is true of every frame, and
/// one about totals is that of their sum; depth and normal, of which no mean is a surface, stay those of the first.
pub fn average(mean: &mut Frame, frame: &Frame, share: f32) {
    parallel(|| {
        let colors = mean.color.par_iter_mut().zip(&frame.color).with_min_len(LEAST);
        colors.for_each(|(mean, color)| (0..4).for_each(|c| mean[c] += (color[c] - mean[c]) * share));
        let opacities = mean.opacities.par_iter_mut().zip(&frame.opacities).with_min_len(LEAST);
        opacities.for_each(|(mean, opacities)| (0..3).for_each(|c| mean[c] += (opacities[c] - mean[c]) * share));
        let samples = mean.samples.par_iter_mut().zip(&frame.samples).with_min_len(LEAST);
        samples.for_each(|(sum, samples)| *sum = sum.saturating_add(*samples));
        let noise = mean.noise.par_iter_mut().zip(&frame.noise).with_min_len(LEAST);
        noise.for_each(|(mean, noise)| *mean = (*mean * (1.0 - share)).hypot(noise * share));
    });
    mean.statistics.add(&frame.statistics);
    let of_one = |warning: &RenderWarning| matches!(warning, RenderWarning::Bias { .. });
    mean.warnings.retain(|warning| frame.warnings.contains(warning) && !of_one(warning));
    mean.warnings.extend(RenderWarning::clamped(&mean.statistics));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_averaged_and_counts_summed() {
        let colors = [[0.25, 1.0, 0.0, 0.5], [0.75, 4.0, 0.0, 1.0], [0.5, 1.0, 3.0, 0.0]];
        let frames = colors.map(|color| {
            let mut frame = Frame::new(1, 1);
            (frame.color[0], frame.depth[0], frame.samples[0]) = (color, color[0], 5);
            frame.noise[0] = 0.3;
            frame.statistics.rays = 1;
            frame.warnings.push(RenderWarning::Empty { reason: String::new() });
            frame
        });
        let mut mean = frames[0].clone();
        average(&mut mean, &frames[1], 1.0 / 2.0);
        assert_eq!((mean.color[0], mean.warnings.len()), ([0.5, 2.5, 0.0, 0.75], 1));
        average(&mut mean, &Frame { warnings: vec![], ..frames[2].clone() }, 1.0 / 3.0);
        let exact = [0.5, 2.0, 1.0, 0.5];
        assert!((0..4).all(|c| (mean.color[0][c] - exact[c]).abs() < 1e-6), "{:?}", mean.color);
        // Of three independent frames.
        assert!((mean.noise[0] - 0.3 / 3f32.sqrt()).abs() < 1e-6, "{}", mean.noise[0]);
        // What is said of totals is said of those of all frames, though no two frames say the same.
        let clamped = |brought, held| {
            let mut frame = frames[0].clone();
            frame.statistics.light = [brought, held];
            frame.warnings = RenderWarning::clamped(&frame.statistics).into_iter().collect();
            frame
        };
        let mut both = clamped(100.0, 1.0);
        average(&mut both, &clamped(100.0, 3.0), 0.5);
        let said: Vec<String> = both.warnings.iter().map(ToString::to_string).collect();
        assert!(said.len() == 1 && said[0].contains(" 2.00 %"), "{said:?}");
        assert_eq!((mean.depth[0], mean.samples[0], mean.statistics.rays, mean.warnings.len()), (0.25, 15, 3, 0));
    }
}
