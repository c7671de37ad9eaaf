//! Skies and lights in harmonics against closed forms and quadrature.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use pellucid_optics::{
    Bands, Color, Environment, Harmonics, Light, LightKind, MOST_BANDS, MOST_COEFFICIENTS, ResolvedLight, Rotation,
    Sky, SkyImage, SkyMap, SkySource, Window, spherical_harmonics_f64,
};

use crate::nodes_on_sphere::{Numbers, nodes};

const MOST: Bands = Bands::ALL[MOST_BANDS - 1];

fn resolved(environment: Environment) -> Sky {
    environment.resolve().unwrap().unwrap()
}

fn image(map: Option<SkyMap>, rotation: f64, intensity: f32) -> Sky {
    let map = map.map(Arc::new);
    resolved(Environment::Image(SkyImage { source: SkySource::Day, rotation, intensity, map }))
}

fn light(kind: LightKind, radius: f64) -> ResolvedLight {
    let color = Color::hex(0xff8040);
    Light { radius, color, intensity: 3.0, ..Light::new(kind) }.resolve(DAffine3::IDENTITY).unwrap()
}

fn sun(radius: f64) -> ResolvedLight {
    light(LightKind::Directional { direction: [-0.6, 0.0, -0.8] }, radius)
}

#[track_caller]
fn alike(a: &Harmonics, b: &Harmonics, tolerance: f64) {
    assert_eq!(a.bands(), b.bands());
    for (i, (a, b)) in a.coefficients().iter().zip(b.coefficients()).enumerate() {
        assert!((0..3).all(|channel| (a[channel] - b[channel]).abs() < tolerance), "{i}: {a:?} and {b:?}");
    }
}

/// The coefficients of a sky by its radiance at that many places in every texel of a picture of this size.
fn quadrature(sky: &Sky, [width, height]: [usize; 2], fine: usize) -> [[f64; 3]; MOST_COEFFICIENTS] {
    let mut sums = [[0.0; 3]; MOST_COEFFICIENTS];
    let (columns, rows) = (width * fine, height * fine);
    for row in 0..rows {
        let side = |row: usize| PI * row as f64 / rows as f64;
        let solid_angle = 2.0 * PI / columns as f64 * (side(row).cos() - side(row + 1).cos());
        let (sine, z) = (0.5 * (side(row) + side(row + 1))).sin_cos();
        for column in 0..columns {
            let (s, c) = (2.0 * PI * (column as f64 + 0.5) / columns as f64).sin_cos();
            let direction = DVec3::new(sine * c, sine * s, z);
            let radiance = sky.radiance(direction.as_vec3());
            for (sum, value) in sums.iter_mut().zip(spherical_harmonics_f64(MOST, direction)) {
                *sum = std::array::from_fn(|i| sum[i] + value * solid_angle * f64::from(radiance[i]));
            }
        }
    }
    sums
}

#[test]
fn a_constant_sky_is_one_coefficient_and_brings_pi() {
    let white = SkyMap::new(256, 128, vec![[1.0; 3]; 256 * 128]).unwrap();
    let coarse = SkyMap::new(3, 1, vec![[1.0; 3]; 3]).unwrap();
    let constant = resolved(Environment::Constant { color: Color::WHITE, intensity: 1.0 });
    for sky in [constant, image(Some(white), 0.0, 1.0), image(Some(coarse), 33.0, 1.0)] {
        let light = Harmonics::of_sky(MOST, &sky);
        for (i, rgb) in light.coefficients().iter().enumerate() {
            let expected = if i == 0 { 2.0 * PI.sqrt() } else { 0.0 };
            assert!(rgb.iter().all(|v| (v - expected).abs() < 1e-12), "{i}: {rgb:?}");
        }
        for normal in [DVec3::Z, DVec3::new(0.48, -0.6, 0.64)] {
            assert!(light.irradiance(normal).iter().all(|v| (v - PI).abs() < 1e-12));
        }
    }
}

#[test]
fn a_picture_of_a_harmonic_is_that_harmonic() {
    // Off by the difference between a harmonic and its value in the middle of each texel.
    const SIZE: [usize; 2] = [256, 128];
    for i in 0..MOST_COEFFICIENTS {
        let texel = |k: usize| {
            let theta = PI * ((k / SIZE[0]) as f64 + 0.5) / SIZE[1] as f64;
            let (x, y) = (2.0 * PI * ((k % SIZE[0]) as f64 + 0.5) / SIZE[0] as f64 - PI).sin_cos();
            let direction = DVec3::new(theta.sin() * x, theta.sin() * y, theta.cos());
            // Light is not negative.
            [(2.0 + spherical_harmonics_f64(MOST, direction)[i]) as f32; 3]
        };
        let map = SkyMap::new(SIZE[0], SIZE[1], (0..SIZE[0] * SIZE[1]).map(texel).collect()).unwrap();
        let found = Harmonics::of_sky(MOST, &image(Some(map), 0.0, 1.0));
        for (j, rgb) in found.coefficients().iter().enumerate() {
            let expected = f64::from(u8::from(i == j)) + if j == 0 { 4.0 * PI.sqrt() } else { 0.0 };
            assert!((rgb[1] - expected).abs() < 1e-3, "{i} in {j}: {}, not {expected}", rgb[1]);
        }
    }
}

#[test]
fn a_gradient_sky_is_its_quadrature() {
    let gradient = Environment::Gradient { top: Color::hex(0x80a0ff), bottom: Color::hex(0x302010), intensity: 2.0 };
    let sky = resolved(gradient);
    let mut expected = [[0.0; 3]; MOST_COEFFICIENTS];
    for (direction, weight) in nodes() {
        let radiance = sky.radiance(direction.as_vec3());
        for (sum, value) in expected.iter_mut().zip(spherical_harmonics_f64(MOST, direction)) {
            *sum = std::array::from_fn(|i| sum[i] + weight * value * f64::from(radiance[i]));
        }
    }
    let found = Harmonics::of_sky(MOST, &sky);
    for (i, (found, expected)) in found.coefficients().iter().zip(expected).enumerate() {
        assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 1e-6), "{i}: {found:?}, not {expected:?}");
    }
}

#[test]
fn pictures_are_their_quadrature_wherever_they_are_turned_to() {
    // Each texel another colour, and in each channel another pattern, so that no mirror image goes unseen.
    let texel = |k: usize| [(k * 7 % 11) as f32, (k * k % 13) as f32, (k % 12) as f32];
    let map = || SkyMap::new(12, 6, (0..72).map(texel).collect()).unwrap();
    for (sky, size, fine, tolerance) in [
        (image(Some(map()), 0.0, 2.0), [12, 6], 40, 0.02),
        // Half a texel of the picture, so that texels end where places do.
        (image(Some(map()), 75.0, 0.5), [24, 6], 40, 0.01),
        (image(None, 0.0, 1.0), [256, 128], 3, 1e-3),
    ] {
        let expected = quadrature(&sky, size, fine);
        let found = Harmonics::of_sky(MOST, &sky);
        for (i, (found, expected)) in found.coefficients().iter().zip(expected).enumerate() {
            assert!((0..3).all(|c| (found[c] - expected[c]).abs() < tolerance), "{i}: {found:?}, not {expected:?}");
        }
    }
}

#[test]
fn turning_the_sky_is_rotating_its_harmonics() {
    for bands in Bands::ALL {
        let day = |rotation: f64| Harmonics::of_sky(bands, &image(None, rotation, 1.0));
        let turned = Rotation::new(DQuat::from_rotation_z(40f64.to_radians()));
        alike(&day(40.0), &day(0.0).rotated(&turned), 1e-6);
        assert_eq!(
            day(0.0).coefficients(),
            &Harmonics::of_sky(MOST, &image(None, 0.0, 1.0)).coefficients()[..bands.coefficients()]
        );
    }
}

#[test]
fn a_light_from_one_direction_is_its_harmonics() {
    let to_light = Vec3::new(0.6, 0.0, 0.8);
    let expected = spherical_harmonics_f64(MOST, to_light.as_dvec3().normalize());
    let mut found = Harmonics::dark(MOST);
    found.add(to_light, [1.0, 2.0, 0.5]);
    for (rgb, value) in found.coefficients().iter().zip(expected) {
        assert!((0..3).all(|c| (rgb[c] - [1.0, 2.0, 0.5][c] * value).abs() < 1e-15), "{rgb:?} for {value}");
    }
    // A light of intensity 1 brings pi.
    let mut found = Harmonics::dark(MOST);
    assert!(found.add_light(&sun(0.0)));
    let mut expected = Harmonics::dark(MOST);
    expected.add(to_light, sun(0.0).radiance().map(|v| v * std::f32::consts::PI));
    alike(&found, &expected, 1e-6);
}

#[test]
fn a_disc_is_what_paths_see_of_it() {
    for radius in [10.0, 50.0, 90.0] {
        let light = sun(radius);
        let mut found = Harmonics::dark(MOST);
        assert!(found.add_light(&light));
        let mut expected = [[0.0; 3]; MOST_COEFFICIENTS];
        const SIDE: usize = 400;
        for k in 0..SIDE * SIDE {
            let sample = light.sample(Vec3::ZERO, [k % SIDE, k / SIDE].map(|k| (k as f32 + 0.5) / SIDE as f32));
            let values = spherical_harmonics_f64(MOST, sample.incident.to_light.as_dvec3());
            for (sum, value) in expected.iter_mut().zip(values) {
                *sum = std::array::from_fn(|c| {
                    sum[c] + PI * value * f64::from(sample.incident.radiance[c]) / (SIDE * SIDE) as f64
                });
            }
        }
        for (i, (found, expected)) in found.coefficients().iter().zip(expected).enumerate() {
            assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 1e-3), "{i}: {found:?}, not {expected:?}");
        }
    }
    // A light with a place in the scene is not far away.
    let mut dark = Harmonics::dark(MOST);
    let lamp = LightKind::Point { position: [0.0, 0.0, 9.0], falloff: Default::default() };
    assert!(!dark.add_light(&light(lamp, 0.0)));
    assert_eq!(dark, Harmonics::dark(MOST));
}

#[test]
fn irradiance_is_that_of_quadrature_for_light_of_few_bands() {
    let gradient = Environment::Gradient { top: Color::WHITE, bottom: Color::BLACK, intensity: 1.0 };
    let light = Harmonics::of_sky(Bands::default(), &resolved(gradient));
    let mut numbers = Numbers(6);
    for _ in 0..20 {
        let normal = numbers.direction();
        // The mean brings pi / 2, and the slope its share of 2 pi / 3.
        let expected = PI / 2.0 + PI / 3.0 * normal.z;
        assert!((light.irradiance(normal)[0] - expected).abs() < 1e-6, "{normal}");
    }
    let mut sun = Harmonics::dark(Bands::default());
    sun.add(Vec3::Z, [1.0; 3]);
    assert!((sun.irradiance(DVec3::Z)[0] - 0.96875).abs() < 1e-12);
    let mut meridian = (0..=1000).map(|k| f64::from(k) / 500.0 - 1.0).map(|z| DVec3::new((1.0 - z * z).sqrt(), 0.0, z));
    assert!(meridian.any(|normal| sun.irradiance(normal) == [0.0; 3]), "what rings below 0 is cut");
}

#[test]
fn windows_take_waves_out_of_a_sharp_light() {
    let mut sharp = Harmonics::dark(Bands::default());
    sharp.add(Vec3::Z, [1.0; 3]);
    let [hanning, lanczos] = [Window::Hanning, Window::Lanczos].map(|window| sharp.windowed(window));
    // Opposite the light, where Legendre's polynomials are 1 and -1 in turns.
    let fifth = PI / 5.0;
    let weights: [&dyn Fn(f64) -> f64; 3] = [&|_| 1.0, &|l| (1.0 + (fifth * l).cos()) / 2.0, &|l| {
        if l == 0.0 { 1.0 } else { (fifth * l).sin() / (fifth * l) }
    }];
    for (light, weight) in [&sharp, &hanning, &lanczos].into_iter().zip(weights) {
        let term = |l: u32| (-1f64).powi(l as i32) * f64::from(2 * l + 1) / (4.0 * PI) * weight(l.into());
        let expected: f64 = (0..5).map(term).sum();
        assert!((light.radiance(DVec3::NEG_Z)[2] - expected).abs() < 1e-12);
    }
    let meridian = || (0..=1000).map(|k| f64::from(k) / 500.0 - 1.0).map(|z| DVec3::new((1.0 - z * z).sqrt(), 0.0, z));
    let wave = |light: &Harmonics| meridian().map(|at| -light.radiance(at)[0]).fold(0.0, f64::max);
    let [strong, gentle, none] = [&hanning, &lanczos, &sharp].map(wave);
    assert!(strong < gentle && gentle < none, "{strong}, {gentle}, {none}");
}
