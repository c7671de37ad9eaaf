//! Displacement and variation by noise (K-21 to K-26, MOD-07 to MOD-12), at single positions.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use pellucid_field::{Grid, Noise, Sampler, Volume};
use pellucid_optics::{Displacement, Displacer, Octave, Perturbation, PropertyNoise, Turbulence, Variation};

fn grid(dims: [usize; 3], spacing: [f64; 3]) -> Grid {
    Grid::with_spacing(dims, spacing, [0.0; 3]).unwrap()
}

fn displaced(amplitude: f32, octaves: &[Octave]) -> Perturbation {
    let displacement = Displacement { amplitude, octaves: octaves.to_vec(), between: None };
    Perturbation { displacement, ..Perturbation::default() }
}

fn displacer(perturbation: &Perturbation, noise: Noise, grid: &Grid) -> Displacer {
    Displacer::new(perturbation, &Arc::new(noise), grid).unwrap()
}

/// Positions all over a box.
fn positions(dims: [usize; 3], count: usize) -> impl Iterator<Item = [f32; 3]> {
    let share = |k: usize, prime: f64| (k as f64 * prime.sqrt()).fract();
    (0..count).map(move |k| [0, 1, 2].map(|axis| (share(k, [2.0, 3.0, 5.0][axis]) * (dims[axis] - 1) as f64) as f32))
}

#[test]
fn nothing_is_made_of_no_weight() {
    let grid = grid([9; 3], [1.0; 3]);
    let noise = Arc::new(Noise::new(0));
    let none = [Perturbation::default(), displaced(0.0, &[Octave::new(2.0, 1.0)]), displaced(0.5, &[]), {
        displaced(0.5, &[Octave::new(2.0, 0.0)])
    }];
    for perturbation in none {
        assert!(Displacer::new(&perturbation, &noise, &grid).is_none());
        assert!(Variation::new(&perturbation, &noise, &grid).is_none());
    }
}

/// Eq. 12.2: periods, offsets and weights are what they are said to be.
#[test]
fn turbulence_repeats_and_adds_up() {
    let grid = grid([33, 17, 17], [0.5; 3]);
    let noise = Arc::new(Noise::new(4));
    let sum = |octaves: &[Octave]| Turbulence::new(noise.clone(), octaves, &grid);
    // The longest side is 32 voxels: frequency 4 has a period of 8 of them.
    let one = sum(&[Octave::new(4.0, 1.0)]);
    let finer = sum(&[Octave::new(8.0, 1.0)]);
    let both = sum(&[Octave::new(4.0, 0.5), Octave::new(8.0, -3.0)]);
    let moved = sum(&[Octave { offset: [3.0, -2.0, 1e6], ..Octave::new(4.0, 1.0) }]);
    let shifted = sum(&[Octave { offset: [0.25, 0.0, 0.0], ..Octave::new(4.0, 1.0) }]);
    for p in positions([25, 9, 9], 500) {
        let p = p.map(|x| (x * 8.0).round() / 8.0);
        assert_eq!(one.at(p), one.at([p[0] + 8.0, p[1] + 8.0, p[2] - 16.0]));
        assert_eq!(one.at(p), moved.at(p));
        assert_eq!(one.at([p[0] + 2.0, p[1], p[2]]), shifted.at(p));
        for channel in 0..4 {
            let expected = 0.5 * one.at(p)[channel] - 3.0 * finer.at(p)[channel];
            assert!((both.at(p)[channel] - expected).abs() < 1e-5);
            assert!(both.at(p)[channel].abs() <= both.bound());
        }
    }
    assert_eq!(both.bound(), 3.5);
}

/// K-24: the same noise everywhere is a translation, away from the faces.
#[test]
fn constant_noise_translates() {
    let dims = [65, 33, 49];
    let grid = grid(dims, [1.0, 2.0, 0.5]);
    // The longest side is 64; noise of 1 moves by 6.4 world units, along each axis by its own voxels.
    let noise = Noise::from_fn(|_| [255, 0, 204, 0]);
    let by = displacer(&displaced(0.1, &[Octave::new(3.0, 1.0)]), noise, &grid);
    let expected = [6.4, -3.2, 6.4 * 2.0 * 0.6f32];
    for p in positions(dims, 500) {
        let inside = (0..3).all(|axis| (by.reach[axis]..=by.high[axis] - by.reach[axis]).contains(&p[axis]));
        let source = by.source(p, || unreachable!());
        for axis in 0..3 {
            let shift = source[axis] - p[axis];
            if inside {
                assert!((shift - expected[axis]).abs() < 1e-4, "{shift} along {axis}");
            }
        }
    }
}

/// MOD-08's bound, and K-24's traps: nothing comes from outside, so nothing is cut off at the box.
#[test]
fn shifts_are_bounded_and_end_inside() {
    let dims = [40, 21, 5];
    let grid = grid(dims, [0.7, 1.0, 3.0]);
    for seed in 0..4 {
        let octaves = [Octave::new(2.0, 1.0), Octave::new(5.0, -0.5), Octave::new(11.0, 0.25)];
        let by = displacer(&displaced(0.3, &octaves), Noise::new(seed), &grid);
        for p in positions(dims, 2000) {
            let source = by.source(p, || unreachable!());
            for axis in 0..3 {
                let spacing = [0.7, 1.0, 3.0][axis];
                let most = 0.3 * 1.75 * (39.0 * 0.7) / spacing;
                assert!((source[axis] - p[axis]).abs() <= most * (1.0 + 1e-6));
                assert!((0.0..=(dims[axis] - 1) as f32).contains(&source[axis]), "{source:?} of {p:?}");
            }
        }
        // On a face nothing moves through it.
        assert_eq!(by.source([0.0, 7.0, 2.0], || 0.0)[0], 0.0);
        assert_eq!(by.source([10.0, 7.0, 4.0], || 0.0)[2], 4.0);
    }
}

/// Root mean square of the height of the plane z = 32 displaced by sin(kx) cos(kz), over that of the shift,
/// where the amplitude times k is `slope`.
fn height_ratio(slope: f64) -> f64 {
    let grid = grid([65; 3], [1.0; 3]);
    let wave = |x: usize, z: usize| (TAU * x as f64 / 32.0).sin() * (TAU * z as f64 / 32.0).cos();
    let noise = Noise::from_fn(|[x, _, z]| [128, 128, (127.5 + 127.5 * wave(x, z)).round() as u8, 0]);
    let amplitude = (slope / (TAU * 2.0)) as f32;
    let by = displacer(&displaced(amplitude, &[Octave::new(2.0, 1.0)]), noise, &grid);
    // One period of 32 voxels in the middle, where the cosine is 1.
    let (mut heights, mut shifts) = (0.0, 0.0);
    for k in 0..256 {
        let x = 16.0 + k as f32 / 8.0;
        let source = |z: f32| f64::from(by.source([x, 32.0, z], || unreachable!())[2]) - 32.0;
        let (mut low, mut high) = (20.0f32, 44.0f32);
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            if source(middle) < 0.0 { low = middle } else { high = middle }
        }
        heights += f64::from(low - 32.0).powi(2);
        shifts += source(32.0).powi(2);
    }
    (heights / shifts).sqrt()
}

/// K-24: a displacement is implicit, so steep noise flattens, by as much as the specification derives.
#[test]
fn a_displaced_plane_is_as_rough_as_the_noise() {
    for (slope, expected) in [(0.1, 0.996), (0.2, 0.986), (0.5, 0.923), (0.9, 0.815)] {
        let ratio = height_ratio(slope);
        assert!((ratio - expected).abs() < 0.02, "{ratio} at slope {slope}");
    }
}

fn value(sampler: &Sampler, by: Option<&Displacer>, p: DVec3) -> f64 {
    let Some(by) = by else { return sampler.value(p) };
    let source = by.source(p.as_vec3().to_array(), || sampler.value(p) as f32);
    sampler.value(DVec3::from_array(source.map(f64::from)))
}

/// Energy of what varies faster than the voxels can tell, along lines through a field.
fn fine_energy(sampler: &Sampler, by: Option<&Displacer>, last: f64) -> f64 {
    const SAMPLES: usize = 512;
    let mut energy = 0.0;
    for line in 0..9 {
        let [y, z] = [line % 3, line / 3].map(|k| last * (0.3 + 0.15 * k as f64));
        let values: Vec<f64> = (0..SAMPLES)
            // A window takes off the ends, whose jump would be energy at all frequencies.
            .map(|k| {
                let share = (k as f64 + 0.5) / SAMPLES as f64;
                value(sampler, by, DVec3::new(share * last, y, z)) * (TAU / 2.0 * share).sin().powi(4)
            })
            .collect();
        // The voxels' Nyquist frequency; twice it, as trilinear interpolation has harmonics of its own.
        for frequency in (last as usize)..SAMPLES / 2 {
            let turn = |k: usize| TAU * frequency as f64 * k as f64 / SAMPLES as f64;
            let re: f64 = values.iter().enumerate().map(|(k, v)| v * turn(k).cos()).sum();
            let im: f64 = values.iter().enumerate().map(|(k, v)| v * turn(k).sin()).sum();
            energy += re * re + im * im;
        }
    }
    energy
}

/// K-25, MOD-09 and MOD-12: 64^3 voxels and 128 KiB of noise show what the voxels alone cannot.
#[test]
fn displacement_adds_detail_beyond_the_voxels() {
    let ball = ball();
    let sampler = Sampler::new(&ball, 0, pellucid_field::Filter::Linear).unwrap();
    let by = displacer(&displaced(0.05, &Displacement::default().octaves), Noise::new(0), ball.grid());
    let (without, with) = (fine_energy(&sampler, None, 64.0), fine_energy(&sampler, Some(&by), 64.0));
    assert!(with > 10.0 * without, "{with} and {without}");
}

/// Where a ball's surface is along rays from its middle, in voxels: mean and standard deviation.
fn silhouette(sampler: &Sampler, by: Option<&Displacer>, middle: f64, level: f64) -> (f64, f64) {
    let radii: Vec<f64> = (0..400)
        .map(|k| {
            // Evenly over all directions (a Fibonacci lattice).
            let (z, turn) = (1.0 - (2 * k + 1) as f64 / 400.0, TAU * k as f64 * 0.618_033_988_749_895);
            let ring = (1.0 - z * z).sqrt();
            let direction = DVec3::new(ring * turn.cos(), ring * turn.sin(), z);
            let inside = |r: f64| value(sampler, by, DVec3::splat(middle) + direction * r) > level;
            // From outside, as an eye sees it.
            let mut r = middle * 0.999;
            while !inside(r) && r > 0.0 {
                r -= 0.02;
            }
            r
        })
        .collect();
    let mean = radii.iter().sum::<f64>() / radii.len() as f64;
    (mean, (radii.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / radii.len() as f64).sqrt())
}

/// A ball of radius 20 in 65^3 voxels: 1 in its middle, 1/2 at its surface, falling by 1/10 a voxel.
fn ball() -> Volume {
    let grid = grid([65; 3], [1.0; 3]);
    let at = |i: usize| DVec3::new((i % 65) as f64, (i / 65 % 65) as f64, (i / 4225) as f64);
    let value = |i| (0.5 + (20.0 - (at(i) - 32.0).length()) / 10.0).clamp(0.0, 1.0) as f32;
    Volume::new(grid, (0..65 * 65 * 65).map(value).collect::<Vec<f32>>()).unwrap()
}

/// K-26: fur roughens the outline, and leaves it where it is in the mean.
#[test]
fn fur_roughens_the_silhouette() {
    let ball = ball();
    let sampler = Sampler::new(&ball, 0, pellucid_field::Filter::Linear).unwrap();
    let (mean, smooth) = silhouette(&sampler, None, 32.0, 0.5);
    assert!((mean - 20.0).abs() < 0.1 && smooth < 0.1, "{mean} and {smooth}");
    // Even bytes blurred by 1, 6, 1 eighths along each axis: of neighbours a share 12 / 38 is the same. Between two of
    // them, anywhere, 2/3 is left of the variance and 1/3 of what they share (the means of (1 - u)^2 + u^2 and of
    // 2 u (1 - u)).
    let even = ((256.0f64 * 256.0 - 1.0) / 12.0).sqrt() / 127.5;
    let deviation = (even * even * (38.0f64 / 64.0 * (2.0 / 3.0 + 12.0 / 38.0 / 3.0)).powi(3)).sqrt();
    // Fur of so many voxels, whose texels are four voxels apart: its slope is 0.2, where a displacement, which is
    // implicit, is as rough as the noise to two in a hundred (K-24).
    let voxels = 0.6;
    let fur = displaced((voxels / deviation / 64.0) as f32, &[Octave::new(0.5, 1.0)]);
    let seeds = 16;
    let mut variance = 0.0;
    for seed in 0..seeds {
        let by = displacer(&fur, Noise::new(seed), ball.grid());
        let (moved, rough) = silhouette(&sampler, Some(&by), 32.0, 0.5);
        assert!((moved - mean).abs() < 0.5, "{moved} and {mean}");
        variance += rough * rough / f64::from(seeds);
    }
    // Some 300 texels on each of 16 balls tell the deviation to one in a hundred.
    let found = variance.sqrt() / voxels;
    assert!((found - 1.0).abs() < 0.06, "{found}");
}

/// MOD-10: where the data says that nothing moves, nothing does; silhouettes end within the bound.
#[test]
fn fur_leaves_the_inside_alone() {
    let ball = ball();
    let sampler = Sampler::new(&ball, 0, pellucid_field::Filter::Linear).unwrap();
    let mut fur = displaced(0.1, &[Octave::new(4.0, 1.0)]);
    fur.displacement.between = Some([0.8, 0.4]);
    let by = displacer(&fur, Noise::new(2), ball.grid());
    let mut moved = 0;
    for p in positions([65; 3], 20_000) {
        let here = DVec3::from_array(p.map(f64::from));
        let before = sampler.value(here);
        let source = by.source(p, || before as f32);
        if before >= 0.8 {
            assert_eq!(source, p);
        }
        moved += u32::from(source != p);
        let beyond = (here - 32.0).length() > 25.0 + f64::from(by.reach[0]) * 3f64.sqrt();
        assert!(!beyond || value(&sampler, Some(&by), here) == 0.0);
    }
    assert!(moved > 10_000);
    // Halfway between both values, half of the amplitude; absent values stay where they are.
    let p = [32.0, 32.0, 50.0];
    let shift = |value| by.source(p, || value)[2] - p[2];
    assert!((shift(0.6) / shift(0.4) - 0.5).abs() < 1e-5);
    assert_eq!(shift(0.1), shift(0.4));
    assert_eq!(shift(f32::NAN), 0.0);
}

/// MOD-11: no jump in time.
#[test]
fn offsets_move_continuously() {
    let ball = ball();
    let sampler = Sampler::new(&ball, 0, pellucid_field::Filter::Linear).unwrap();
    let sampler = &sampler;
    let at = |time: f64| {
        let octave = Octave { offset: [time, 0.0, 0.0], ..Octave::new(2.0, 1.0) };
        let by = displacer(&displaced(0.05, &[octave]), Noise::new(1), ball.grid());
        let value = move |p: [f32; 3]| value(sampler, Some(&by), DVec3::from_array(p.map(f64::from)));
        positions([65; 3], 4000).map(value).collect::<Vec<_>>()
    };
    let change = |from: f64, to: f64| {
        let squares: f64 = at(from).iter().zip(at(to)).map(|(a, b)| (a - b).powi(2)).sum();
        squares.sqrt()
    };
    // Over the edge of a period, too.
    for start in [0.3, 0.9995] {
        let ratio = change(start, start + 2e-3) / change(start, start + 1e-3);
        assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
    }
    assert_eq!(at(0.25), at(7.25));
}

fn varied(opacity: f32, color: f32, transport: f32) -> Variation {
    let optics = PropertyNoise { opacity, color, transport, ..PropertyNoise::default() };
    let perturbation = Perturbation { optics, ..Perturbation::default() };
    Variation::new(&perturbation, &Arc::new(Noise::new(0)), &grid([9; 3], [1.0; 3])).unwrap()
}

/// K-23: each property by itself, identity at weight 0, and nothing leaves [0, 1].
#[test]
fn properties_vary_by_themselves_and_stay_in_range() {
    let noises = [[-1.0; 4], [1.0; 4], [0.0; 4], [0.7, -0.2, 0.1, 0.4], [-0.5, 0.5, 1.0, -1.0]];
    let colors = [[0.0; 4], [1.0; 4], [0.2, 0.1, 0.3, 0.3], [0.5, 0.0, 0.25, 0.5], [1e-6, 1e-7, 0.0, 1e-6]];
    for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.25, 1.0], [1.0; 3]] {
        let variation = varied(weights[0], weights[1], weights[2]);
        for noise in noises {
            for rgba in colors {
                let found = variation.associated(noise, rgba);
                let through = variation.transport(noise, [rgba[0], rgba[1], rgba[2]]);
                assert!(found.iter().chain(&through).all(|v| (0.0..=1.0).contains(v)), "{found:?} {through:?}");
                assert!((0..3).all(|c| found[c] <= found[3] * (1.0 + 1e-6)), "{found:?} of {rgba:?}");
                if weights[0] == 0.0 {
                    assert_eq!(found[3], rgba[3]);
                }
                if weights[0] == 0.0 && weights[1] == 0.0 {
                    assert_eq!(found, rgba);
                }
                if weights[2] == 0.0 {
                    assert_eq!(through, [rgba[0], rgba[1], rgba[2]]);
                }
            }
        }
    }
    // Twice the extinction, twice the way: 1 - 0.7^2; half the colour.
    let found = varied(1.0, 0.0, 0.0).associated([0.0, 0.0, 0.0, 1.0], [0.3, 0.15, 0.0, 0.3]);
    assert!((found[3] - 0.51).abs() < 1e-6 && (found[0] - 0.51).abs() < 1e-6 && (found[1] - 0.255).abs() < 1e-6);
    let found = varied(0.0, 0.5, 0.0).associated([-1.0, 1.0, 0.0, 1.0], [0.2, 0.1, 0.1, 0.2]);
    assert!((found[0] - 0.1).abs() < 1e-7 && (found[1] - 0.15).abs() < 1e-7 && found[2] == 0.1);
    let through = varied(0.0, 0.0, 0.5).transport([1.0, -1.0, 0.0, 0.0], [0.25; 3]);
    assert!((through[0] - 0.125).abs() < 1e-6 && (through[1] - 0.5).abs() < 1e-6 && through[2] == 0.25);
}
