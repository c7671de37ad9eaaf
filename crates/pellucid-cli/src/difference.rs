//! How far two pictures are apart.

use serde_json::{Value, json};

/// How far the colours of two pictures are apart, in 8-bit steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Peak signal-to-noise ratio in dB; infinite for equal pictures.
    pub psnr: f64,
    /// The largest of a channel.
    pub largest: u8,
    /// The mean over all channels.
    pub mean: f64,
}

impl Difference {
    /// Between pictures of the same size, as RGBA of 8 bits.
    pub fn between(a: &[u8], b: &[u8]) -> Self {
        let colors = |rgba: &[u8]| rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect::<Vec<u8>>();
        let differences: Vec<u8> = colors(a).iter().zip(colors(b)).map(|(a, b)| a.abs_diff(b)).collect();
        let count = differences.len().max(1) as f64;
        let squares: f64 = differences.iter().map(|d| f64::from(*d).powi(2)).sum();
        Self {
            psnr: 10.0 * (255.0 * 255.0 * count / squares).log10(),
            largest: differences.iter().copied().max().unwrap_or(0),
            mean: differences.iter().map(|d| f64::from(*d)).sum::<f64>() / count,
        }
    }

    /// The ratio for programs: JSON has no infinity, equal pictures have none.
    pub fn psnr_json(&self) -> Value {
        json!(self.psnr.is_finite().then_some(self.psnr))
    }
}
