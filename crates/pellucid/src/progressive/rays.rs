//! Where the rays of a picture go: fewer of them for a preview, elsewhere for every frame of a mean.

use pellucid_scene::{Jitter, Stage, Viewpoint};

/// What of a stage decides where its rays go and where they are sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rays {
    viewpoint: Viewpoint,
    jitter: Jitter,
    supersampling: u32,
}

impl Rays {
    /// Those of a stage.
    pub fn of(stage: &Stage) -> Self {
        let quality = &stage.quality;
        Self { viewpoint: stage.viewpoint, jitter: quality.jitter, supersampling: quality.supersampling }
    }

    /// Width and height of their picture.
    pub fn size(&self) -> (usize, usize) {
        (self.viewpoint.width, self.viewpoint.height)
    }

    /// One ray per pixel of the same view in fewer rows.
    pub fn reduced(self, rows: usize) -> Self {
        Self { viewpoint: self.viewpoint.with_rows(rows), supersampling: 1, ..self }
    }

    /// Those of frame k of a mean: frame 0 has the stage's own. The shifts fill the share of the pixel
    /// that a ray stands for, and the samples along rays their step, so that the mean tends to the
    /// integral over both (9.1-4).
    pub fn frame(self, k: u32) -> Self {
        if k == 0 {
            return self;
        }
        let [dx, dy] = offset(k).map(|v| v / f64::from(self.supersampling.max(1)));
        Self { viewpoint: self.viewpoint.shifted(dx, dy), jitter: another(self.jitter, k), ..self }
    }

    /// Gives a stage these rays and returns those it had.
    pub fn exchange(self, stage: &mut Stage) -> Self {
        let own = Self::of(stage);
        stage.viewpoint = self.viewpoint;
        (stage.quality.jitter, stage.quality.supersampling) = (self.jitter, self.supersampling);
        own
    }
}

/// The jitter of frame k of a mean: that of frame 0 is the stage's own.
pub fn another(own: Jitter, k: u32) -> Jitter {
    match own {
        own if k == 0 => own,
        Jitter::Centered => Jitter::BlueNoise { seed: k },
        Jitter::BlueNoise { seed } => Jitter::BlueNoise { seed: seed.wrapping_add(k) },
    }
}

/// Where in its pixel frame k looks, `[-1/2, 1/2]` from the middle: at the points of the R2 sequence
/// (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018), each followed by its
/// mirror image, so that a mean of few frames does not move the picture.
fn offset(k: u32) -> [f64; 2] {
    /// The plastic number, the real root of x^3 = x + 1.
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let sign = if k % 2 == 1 { 1.0 } else { -1.0 };
    let place = |alpha: f64| sign * ((0.5 + f64::from(k.div_ceil(2)) * alpha).fract() - 0.5);
    [place(PLASTIC.recip()), place(PLASTIC.powi(-2))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_start_in_the_middle_and_fill_the_pixel_evenly() {
        let points: Vec<[f64; 2]> = (0..257).map(offset).collect();
        assert!(points[0] == [0.0; 2] && points.iter().flatten().all(|v| (-0.5..=0.5).contains(v)));
        let sum = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>();
        assert!(sum(0).abs() < 1e-9 && sum(1).abs() < 1e-9);
        // Every box at a corner of the pixel holds its share of the points: their star discrepancy is
        // far below that of random ones, about 1/16.
        let mut worst = 0.0f64;
        for (i, j) in (1..=32).flat_map(|i| (1..=32).map(move |j| (f64::from(i) / 32.0, f64::from(j) / 32.0))) {
            let inside = points.iter().filter(|p| p[0] + 0.5 < i && p[1] + 0.5 < j).count();
            worst = worst.max((inside as f64 / 257.0 - i * j).abs());
        }
        assert!(worst < 0.03, "discrepancy {worst}");
    }
}
