//! The noise volume (K-20, MOD-07): periodic, fair, without a seam, and the same everywhere.

use pellucid_field::Noise;

const SIZE: usize = Noise::SIZE;

/// A channel of a texel of the endless repetition.
fn byte(noise: &Noise, [x, y, z]: [usize; 3], channel: usize) -> f64 {
    f64::from(noise.texels()[x % SIZE + SIZE * (y % SIZE + SIZE * (z % SIZE))][channel])
}

fn all() -> impl Iterator<Item = [usize; 3]> {
    (0..SIZE.pow(3)).map(|i| [i % SIZE, i / SIZE % SIZE, i / (SIZE * SIZE)])
}

/// Root mean square of the steps from texels x to x + 1 along an axis.
fn steps(noise: &Noise, axis: usize, channel: usize, from: impl Fn(usize) -> bool) -> f64 {
    let squares: Vec<f64> = all()
        .filter(|at| from(at[axis]))
        .map(|at| {
            let mut next = at;
            next[axis] += 1;
            (byte(noise, next, channel) - byte(noise, at, channel)).powi(2)
        })
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn takes_the_memory_that_the_paper_states() {
    assert_eq!(size_of_val(Noise::new(0).texels()), 131_072);
}

#[test]
fn repeats() {
    let noise = Noise::new(3);
    for k in 0..200 {
        // Places that floats hold exactly, a period on and far away, negative ones too.
        let p = [0, 1, 2].map(|axis| ((k * (17 + 12 * axis)) % 256) as f32 / 8.0);
        for periods in [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-3, 2, 5], [-100, -7, 40]] {
            let q = [0, 1, 2].map(|axis| p[axis] + (32 * periods[axis]) as f32);
            assert_eq!(noise.signed(p), noise.signed(q), "{p:?} and {q:?}");
        }
    }
}

#[test]
fn meets_texels_and_is_linear_between_them() {
    let noise = Noise::new(5);
    for at in all().step_by(97) {
        let p = at.map(|i| i as f32);
        let found = noise.signed(p);
        let next = noise.signed([p[0] + 0.25, p[1], p[2]]);
        for channel in 0..4 {
            let here = byte(&noise, at, channel) / 127.5 - 1.0;
            let there = byte(&noise, [at[0] + 1, at[1], at[2]], channel) / 127.5 - 1.0;
            assert!((f64::from(found[channel]) - here).abs() < 1e-6);
            assert!((f64::from(next[channel]) - (0.75 * here + 0.25 * there)).abs() < 1e-6);
        }
    }
}

/// The standard deviation of 32,768 uniform bytes' mean is 0.0016: 0.01 is six of them.
#[test]
fn is_fair_and_its_channels_are_independent() {
    for seed in [0, 1, 77, u32::MAX] {
        let noise = Noise::new(seed);
        let n = SIZE.pow(3) as f64;
        let mean = |channel| all().map(|at| byte(&noise, at, channel)).sum::<f64>() / n / 255.0;
        let product = |a, b| {
            let (ma, mb) = (mean(a), mean(b));
            let sum = |at| (byte(&noise, at, a) / 255.0 - ma) * (byte(&noise, at, b) / 255.0 - mb);
            all().map(sum).sum::<f64>() / n
        };
        for a in 0..4 {
            assert!((mean(a) - 0.5).abs() < 0.01, "channel {a} of seed {seed}: {}", mean(a));
            // Uniform numbers have 1/12; along each axis the blur leaves (1 + 36 + 1) / 64 of it.
            let expected = (38.0f64 / 64.0).powi(3) / 12.0;
            assert!((product(a, a) / expected - 1.0).abs() < 0.05);
            for b in 0..a {
                assert!(product(a, b).abs() < 0.05 * expected, "channels {a} and {b} of seed {seed}");
            }
        }
    }
}

#[test]
fn has_no_seam() {
    let noise = Noise::new(9);
    for axis in 0..3 {
        // One plane has 1024 steps: all channels together, so that chance moves the mean by 1 % only.
        let rms = |from: &dyn Fn(usize) -> bool| {
            ((0..4).map(|channel| steps(&noise, axis, channel, from).powi(2)).sum::<f64>() / 4.0).sqrt()
        };
        let ratio = rms(&|x| x == SIZE - 1) / rms(&|x| x != SIZE - 1);
        assert!((ratio - 1.0).abs() < 0.1, "axis {axis}: {ratio}");
        // Independent uniform bytes differ by 255 / sqrt(6): the blur takes a good part of it.
        assert!(rms(&|_| true) < 0.6 * 255.0 / 6f64.sqrt());
    }
}

/// Bytes that never change: documents keep their pictures.
#[test]
fn seeds_are_reproducible_and_differ() {
    let noise = Noise::new(0);
    assert_eq!(&noise, &Noise::new(0));
    assert_ne!(noise, Noise::new(1));
    assert_eq!(noise.texels()[..3], FIRST);
}

const FIRST: [[u8; 4]; 3] = [[117, 117, 116, 136], [136, 116, 132, 79], [163, 145, 117, 123]];
