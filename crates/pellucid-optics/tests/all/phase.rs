//! Phase functions against published values, quadrature and the statistics of their samples.

use std::f64::consts::{PI, TAU};

use glam::Vec3;
use pellucid_optics::{
    BackLobe, OpticsError, Phase, PhaseEntries, PhaseNormalization, PhaseTable, TableAngles, turned,
};
use proptest::prelude::*;

fn cosine(degrees: f64) -> f32 {
    degrees.to_radians().cos() as f32
}

fn henyey_greenstein(g: f32) -> Phase {
    Phase::HenyeyGreenstein { g }
}

/// A coloured table with a peak forward and a bow at 138 degrees, which is red outside.
fn rainbow(uniform_in: TableAngles, count: usize) -> PhaseTable {
    let value = |entry: usize| {
        let t = entry as f64 / (count - 1) as f64;
        let theta = match uniform_in {
            TableAngles::Theta => PI * t,
            TableAngles::Cosine => (2.0 * t - 1.0).acos(),
        };
        [0.0, 0.04, 0.08].map(|shift: f64| {
            let bow = (-((theta - 2.4 - shift) / 0.05).powi(2)).exp();
            (5.0 * (-theta / 0.3).exp() + 0.3 * bow + 0.02 + shift) as f32
        })
    };
    PhaseTable::new(uniform_in, (0..count).map(value).collect()).unwrap()
}

fn glory() -> BackLobe {
    let value = |entry: usize| {
        let theta = PI * (0.5 + entry as f64 / 128.0);
        [1.0, 1.1, 1.2].map(|scale: f64| ((PI - theta) * 20.0 * scale).cos().powi(2) as f32 * 1e-3 + 1e-4)
    };
    BackLobe::new(TableAngles::Theta, (0..65).map(value).collect()).unwrap()
}

/// Every phase function, with an anisotropy to use it with.
fn all() -> Vec<(Phase, f32)> {
    let lobes = [-0.9, -0.3, 0.0, 1e-5, 0.5, 0.8, 0.9, 0.99];
    let mut all = vec![(Phase::Isotropic, 0.0), (Phase::Rayleigh, 0.0)];
    all.extend(lobes.map(|g| (henyey_greenstein(g), g)));
    all.extend(lobes.map(|g| (Phase::Schlick { g }, g)));
    all.extend([0.0, 0.7, 1.0].map(|share| (Phase::DoubleHenyeyGreenstein { first: 0.85, second: -0.3, share }, 0.0)));
    all.push((Phase::Table(rainbow(TableAngles::Theta, 181)), 0.0));
    all.push((Phase::Table(rainbow(TableAngles::Cosine, 400)), 0.0));
    all.extend([-0.5, 0.0, 0.8].map(|g| (Phase::Hybrid { g, back: glory() }, g)));
    all
}

/// The integral over all directions of `f` of the cosine, for each colour, by Gauss-Legendre
/// quadrature of three points in cells that are evenly spaced in angle and small.
fn integral(f: impl Fn(f32) -> [f32; 3]) -> [f64; 3] {
    const CELLS: usize = 36_000;
    let mut sum = [0.0; 3];
    for cell in 0..CELLS {
        let [from, to] = [cell, cell + 1].map(|edge| (PI * edge as f64 / CELLS as f64).cos());
        for (place, weight) in [(-(0.6f64.sqrt()), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)] {
            let mu = ((from + to) + place * (from - to)) / 2.0;
            let value = f(mu as f32);
            for channel in 0..3 {
                sum[channel] += TAU * weight * (from - to) / 2.0 * f64::from(value[channel]);
            }
        }
    }
    sum
}

#[test]
fn published_values_of_henyey_and_greenstein() {
    // 6.2-3 and 6.2-4.
    for (degrees, g, physical) in [
        (0.0, 0.0, 0.079_577_5),
        (0.0, 0.5, 0.477_465),
        (90.0, 0.5, 0.042_706),
        (180.0, 0.5, 0.017_684),
        (0.0, 0.8, 3.580_986),
        (90.0, 0.8, 0.013_640),
        (180.0, 0.8, 0.004_912),
        (0.0, 0.9, 15.1197),
    ] {
        let found = f64::from(henyey_greenstein(g).pdf(g, cosine(degrees)));
        assert!((found / physical - 1.0).abs() < 5e-5, "{degrees} degrees, g = {g}: {found}");
    }
    for (degrees, g, expected) in [(90.0, 0.5, 0.089_443), (180.0, 0.5, 0.037_037), (90.0, 0.8, 0.003_809)] {
        for (g, degrees) in [(g, degrees), (-g, 180.0 - degrees)] {
            let weight = henyey_greenstein(g).weight(PhaseNormalization::Renormalised, g, cosine(degrees));
            assert!((f64::from(weight[0]) - expected).abs() < 1e-6, "{degrees} degrees, g = {g}: {weight:?}");
        }
    }
}

#[test]
fn light_is_conserved_and_the_mean_cosine_is_that_of_the_integral() {
    for (phase, g) in all() {
        let whole = integral(|mu| phase.eval(g, mu));
        let mean = integral(|mu| phase.eval(g, mu).map(|v| v * mu));
        // Cosines next to 1 are 6e-8 apart in single precision: at g = 0.99 that is a thousandth of the peak.
        let bound = if g.abs() > 0.95 { 2e-5 } else { 1e-6 };
        for channel in 0..3 {
            let claimed = f64::from(phase.mean_cosine(g)[channel]);
            assert!((whole[channel] - 1.0).abs() < bound, "{}, g = {g}: {whole:?}", phase.name());
            assert!((mean[channel] - claimed).abs() < bound, "{}, g = {g}: {mean:?}, not {claimed}", phase.name());
        }
        let density = integral(|mu| [phase.pdf(g, mu); 3])[0];
        assert!((density - 1.0).abs() < bound, "{}, g = {g}: {density}", phase.name());
    }
}

#[test]
fn samples_are_distributed_as_they_claim() {
    const BINS: usize = 40;
    const SAMPLES: usize = 400_000;
    for (phase, g) in all() {
        let mut counts = [0.0; BINS];
        let mut claimed = [0.0; BINS];
        for k in 0..SAMPLES {
            // Evenly spaced, so that counts have no noise beyond the rounding of both ends of a bin.
            let mu = phase.sample(g, (k as f32 + 0.5) / SAMPLES as f32);
            assert!((-1.0..=1.0).contains(&mu));
            let angle = f64::from(mu).acos();
            counts[((angle / PI * BINS as f64) as usize).min(BINS - 1)] += 1.0;
        }
        for (bin, claimed) in claimed.iter_mut().enumerate() {
            const PARTS: usize = 2000;
            for part in 0..PARTS {
                let theta = PI * (bin as f64 + (part as f64 + 0.5) / PARTS as f64) / BINS as f64;
                let density = f64::from(phase.pdf(g, theta.cos() as f32));
                *claimed += TAU * density * theta.sin() * PI / (BINS * PARTS) as f64;
            }
        }
        let mut chi_squared = 0.0;
        for bin in 0..BINS {
            let expected = claimed[bin] * SAMPLES as f64;
            chi_squared += (counts[bin] - expected).powi(2) / expected.max(5.0);
        }
        // Independent samples have 39 with a deviation of 9; even ones far less, but for the rounding of u
        // and of the peak at 0.99.
        assert!(chi_squared < 40.0, "{}, g = {g}: {chi_squared}", phase.name());
    }
}

#[test]
fn the_largest_renormalised_weight_is_one() {
    for (phase, g) in all() {
        let weights =
            (0..=180_000).flat_map(|k| phase.weight(PhaseNormalization::Renormalised, g, cosine(k as f64 / 1000.0)));
        let largest = weights.fold(0.0, f32::max);
        // A hybrid adds two functions of at most 1, which peak on opposite sides if g is positive.
        let bound = if matches!(phase, Phase::Hybrid { .. }) { 1.0..=2.0 } else { 0.999..=1.0001 };
        assert!(bound.contains(&largest), "{}, g = {g}: {largest}", phase.name());
        let ratio = |mu| {
            let [physical, renormalised] = [PhaseNormalization::Physical, PhaseNormalization::Renormalised]
                .map(|normalization| phase.weight(normalization, g, mu)[1]);
            renormalised / physical
        };
        assert!((ratio(-0.8) / ratio(0.3) - 1.0).abs() < 1e-4, "{}, g = {g}", phase.name());
    }
    assert!((Phase::Isotropic.weight(PhaseNormalization::Physical, 0.0, 0.3)[0] - 0.25).abs() < 1e-6);
}

#[test]
fn a_table_reproduces_the_function_it_was_made_of() {
    // 6.2-5: evenly spaced angles suffice where cosines would not.
    let table = |uniform_in, g: f32, count: usize| {
        let value = |entry: usize| {
            let t = entry as f64 / (count - 1) as f64;
            let mu = if uniform_in == TableAngles::Theta { (PI * t).cos() } else { 2.0 * t - 1.0 };
            [henyey_greenstein(g).pdf(g, mu as f32); 3]
        };
        Phase::Table(PhaseTable::new(uniform_in, (0..count).map(value).collect()).unwrap())
    };
    let error = |table: &Phase, g: f32| {
        let mus = (0..=20_000).map(|k| cosine(k as f64 * 180.0 / 20_000.0));
        let difference = mus.map(|mu| {
            let [found, exact] =
                [table, &henyey_greenstein(g)].map(|phase| phase.weight(PhaseNormalization::Renormalised, g, mu)[2]);
            (found - exact).abs()
        });
        difference.fold(0.0, f32::max)
    };
    for g in [0.0, 0.5, 0.8, 0.9] {
        let found = error(&table(TableAngles::Theta, g, 256), g);
        assert!(found < 0.01, "g = {g}: {found}");
    }
    assert!(error(&table(TableAngles::Cosine, 0.5, 256), 0.5) < 0.01);
    assert!(error(&table(TableAngles::Cosine, 0.9, 256), 0.9) > 0.1);
}

#[test]
fn a_hybrid_is_henyey_and_greenstein_in_front_and_coloured_behind() {
    let g = 0.8;
    let hybrid = Phase::Hybrid { g, back: glory() };
    let renormalised = |phase: &Phase, degrees| phase.weight(PhaseNormalization::Renormalised, g, cosine(degrees));
    for degrees in [0.0, 30.0, 60.0, 89.9] {
        assert_eq!(renormalised(&hybrid, degrees), renormalised(&henyey_greenstein(g), degrees));
    }
    let [red, _, blue] = renormalised(&hybrid, 177.0);
    assert!(red > 1.4 * blue, "{red} and {blue}");
    assert!(renormalised(&hybrid, 180.0)[0] > 0.9);
}

#[test]
fn numbers_out_of_range_are_named() {
    let name = |phase: Phase| match phase.validate() {
        Err(OpticsError::Parameter { name, expected, .. }) => format!("{name}: {expected}"),
        other => format!("{other:?}"),
    };
    for g in [1.0, -1.0, f32::NAN] {
        assert_eq!(name(henyey_greenstein(g)), "g: -0.99 to 0.99");
        assert_eq!(name(Phase::Schlick { g }), "g: -0.99 to 0.99");
        assert_eq!(name(Phase::Hybrid { g, back: glory() }), "g: -0.99 to 0.99");
    }
    let double = |first, second, share| Phase::DoubleHenyeyGreenstein { first, second, share };
    assert_eq!(name(double(2.0, 0.0, 0.5)), "first: -0.99 to 0.99");
    assert_eq!(name(double(0.0, -2.0, 0.5)), "second: -0.99 to 0.99");
    assert_eq!(name(double(0.0, 0.0, 1.5)), "share: 0 to 1");
    assert_eq!(name(henyey_greenstein(-0.99)), "Ok(())");
    let refused = |values| PhaseTable::new(TableAngles::Theta, values).unwrap_err().to_string();
    assert!(refused(vec![[1.0; 3]]).contains("number of phase table entries is 1"));
    assert!(refused(vec![[1.0, -1.0, 1.0]; 2]).contains("phase table value is -1: expected 0 to 1e30"));
    assert!(refused(vec![[1.0, f32::NAN, 1.0]; 2]).contains("phase table value is NaN"));
    assert!(refused(vec![[1.0, 0.0, 1.0]; 2]).contains("light of a phase table's colour is 0"));
}

proptest! {
    #[test]
    fn scattered_directions_are_unit_vectors_at_their_angle(
        x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0, mu in -1.0f32..=1.0, turn in 0.0f32..1.0,
    ) {
        prop_assume!(Vec3::new(x, y, z).length() > 1e-3);
        let axis = Vec3::new(x, y, z).normalize();
        let direction = turned(axis, mu, turn);
        prop_assert!((direction.length() - 1.0).abs() < 1e-6);
        prop_assert!((direction.dot(axis) - mu).abs() < 2e-6);
    }

    #[test]
    fn values_are_finite_and_not_negative(k in 0usize..24, mu in -1.0f32..=1.0, u in 0.0f32..1.0) {
        let all = all();
        let (phase, g) = &all[k % all.len()];
        prop_assert!(phase.eval(*g, mu).iter().all(|v| v.is_finite() && *v >= 0.0));
        prop_assert!(phase.pdf(*g, phase.sample(*g, u)) > 0.0);
    }
}

#[test]
fn entries_at_uneven_cosines_are_a_phase_function() {
    // Henyey and Greenstein's lobe at angles that are close where it is steep, in no order.
    let g = 0.8f64;
    let lobe = |mu: f64| (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * mu).powf(1.5));
    let mut entries: Vec<(f64, [f32; 3])> = (0..=400)
        .map(|k| (PI * (f64::from(k) / 400.0).powi(2)).cos())
        .map(|mu| (mu, [lobe(mu) as f32 * 7.0; 3]))
        .collect();
    entries.swap(3, 300);
    let mut table = PhaseTable::of_file(TableAngles::Theta, "mie.csv").unwrap();
    assert!(table.is_unread());
    table.fill(&PhaseEntries::At(entries.clone())).unwrap();
    assert!(!table.is_unread());
    let phase = Phase::Table(table.clone());
    const COUNT: usize = 200_000;
    let (mut integral, mut mean) = (0.0, 0.0);
    for k in 0..COUNT {
        let u = (k as f32 + 0.5) / COUNT as f32;
        let mu = 2.0 * u - 1.0;
        integral += f64::from(phase.eval(0.0, mu)[0]) * 4.0 * PI / COUNT as f64;
        mean += f64::from(phase.sample(0.0, u)) / COUNT as f64;
        let expected = lobe(f64::from(mu));
        assert!((f64::from(phase.pdf(0.0, mu)) / expected - 1.0).abs() < 3e-3, "{mu}");
    }
    assert!((integral - 1.0).abs() < 1e-4, "{integral}");
    assert!((mean - g).abs() < 1e-3, "{mean}");

    let refused =
        |entries: Vec<(f64, [f32; 3])>| table.clone().fill(&PhaseEntries::At(entries)).unwrap_err().to_string();
    let one = [1.0; 3];
    assert!(
        refused(vec![(1.0, one), (0.0, one)])
            .contains("mie.csv: its cosines do not go from end to end: expected from 1 to -1")
    );
    assert!(refused(vec![(1.0, one), (0.0, one), (0.0, one), (-1.0, one)]).contains("two entries of the same angle"));
    assert!(refused(vec![(1.0, one)]).contains("2 to 65,536"));
    assert!(refused(vec![(1.0, [0.0; 3]), (-1.0, [0.0; 3])]).contains("more than 0"));
    assert!(refused(vec![(1.0, [f32::NAN; 3]), (-1.0, one)]).contains("phase table value"));
}
