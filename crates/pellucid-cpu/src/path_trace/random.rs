//! Random numbers: a stream of its own for every path, so that a picture does not depend on which
//! thread draws which pixel.

/// PCG-XSH-RR with 64 bits of state (O'Neill 2014).
pub struct Random {
    state: u64,
}

impl Random {
    /// The stream of a path: number `sample` of a pixel, in a picture with these seeds.
    pub fn new(seeds: [u32; 2], pixel: usize, sample: u32) -> Self {
        let seed = u64::from(seeds[0]) << 32 | u64::from(seeds[1]);
        let state = [pixel as u64, u64::from(sample)].into_iter().fold(mixed(seed), |state, v| mixed(state ^ v));
        Self { state }
    }

    #[inline(always)]
    fn next(&mut self) -> u32 {
        let state = self.state;
        self.state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let shifted = ((state >> 18 ^ state) >> 27) as u32;
        shifted.rotate_right((state >> 59) as u32)
    }

    /// A number in 0..1, never 1.
    #[inline(always)]
    pub fn number(&mut self) -> f32 {
        (self.next() >> 8) as f32 * (1.0 / (1 << 24) as f32)
    }

    /// Two numbers in 0..1.
    #[inline(always)]
    pub fn pair(&mut self) -> [f32; 2] {
        [self.number(), self.number()]
    }

    /// The optical depth at which light next collides: exponentially distributed.
    #[inline(always)]
    pub fn depth(&mut self) -> f32 {
        // Halfway between two numbers, so that the logarithm is finite.
        -(self.number() + 0.5 / (1 << 24) as f32).ln()
    }
}

/// The step and the finalizer of SplitMix64 (Steele, Lea and Flood 2014): every bit moves all others.
fn mixed(v: u64) -> u64 {
    let v = v.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let v = (v ^ v >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let v = (v ^ v >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    v ^ v >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_neighbouring_paths_are_independent_and_uniform() {
        // First numbers of the paths of a row of pixels, then of the samples of one pixel.
        let rows: [&dyn Fn(usize) -> Random; 2] =
            [&|k| Random::new([0, 0], k, 0), &|k| Random::new([3, 7], 5, k as u32)];
        for stream in rows {
            const COUNT: usize = 100_000;
            let numbers: Vec<f64> = (0..COUNT).map(|k| f64::from(stream(k).number())).collect();
            let mean = numbers.iter().sum::<f64>() / COUNT as f64;
            let lagged = numbers.windows(2).map(|pair| (pair[0] - 0.5) * (pair[1] - 0.5)).sum::<f64>();
            // Standard errors of 1 / sqrt(12 N), and of 1/12 / sqrt(N): both within four.
            assert!((mean - 0.5).abs() < 4.0 / (12.0 * COUNT as f64).sqrt(), "{mean}");
            assert!((lagged / COUNT as f64).abs() < 4.0 / 12.0 / (COUNT as f64).sqrt(), "{lagged}");
        }
    }

    #[test]
    fn depths_are_finite_and_have_mean_one() {
        let mut random = Random::new([1, 2], 3, 4);
        let depths: Vec<f64> = (0..100_000).map(|_| f64::from(random.depth())).collect();
        assert!(depths.iter().all(|depth| depth.is_finite() && *depth > 0.0));
        assert!((depths.iter().sum::<f64>() / 1e5 - 1.0).abs() < 4.0 / 1e5f64.sqrt());
    }
}
