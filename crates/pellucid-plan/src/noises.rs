//! Noise by its seed: layers with the same share its bytes.

use std::sync::Arc;

use pellucid_field::Noise;

/// Noise of the seeds that were asked for last.
#[derive(Default)]
pub(crate) struct Noises(Vec<(u32, Arc<Noise>)>);

impl Noises {
    /// As many as layers may have seeds of their own, before the oldest is made again.
    const MOST: usize = 8;

    /// The noise of a seed.
    pub fn of(&mut self, seed: u32) -> Arc<Noise> {
        if let Some((_, noise)) = self.0.iter().find(|(of, _)| *of == seed) {
            return noise.clone();
        }
        let noise = Arc::new(Noise::new(seed));
        self.0.truncate(Self::MOST - 1);
        self.0.insert(0, (seed, noise.clone()));
        noise
    }
}
