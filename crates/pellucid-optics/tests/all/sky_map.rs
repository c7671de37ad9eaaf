//! Pictures of the sky against quadrature over directions.

use std::f64::consts::PI;

use glam::Vec3;
use pellucid_optics::{Environment, OpticsError, Sky, SkyImage, SkyMap, SkySource, luminance, turned};

const WIDTH: usize = 12;
const HEIGHT: usize = 7;

/// A picture with dark texels, bright ones and a dark row.
fn map() -> SkyMap {
    let texel = |k: usize| match (k % WIDTH, k / WIDTH) {
        (_, 3) => [0.0; 3],
        (2, 1) => [40.0, 30.0, 5.0],
        (column, row) => [(column * row % 5) as f32, 0.3 * (column % 3) as f32, 0.1],
    };
    SkyMap::new(WIDTH, HEIGHT, (0..WIDTH * HEIGHT).map(texel).collect()).unwrap()
}

fn sky(rotation: f64) -> Sky {
    let map = Some(std::sync::Arc::new(map()));
    Environment::Image(SkyImage { source: SkySource::Day, rotation, intensity: 2.0, map }).resolve().unwrap().unwrap()
}

/// The integral over all directions.
fn sphere(f: impl Fn(Vec3) -> f64) -> f64 {
    const SIDE: usize = 1500;
    let at = |k: usize| (k as f32 + 0.5) / SIDE as f32;
    let directions = (0..SIDE * SIDE).map(|k| turned(Vec3::Z, 2.0 * at(k % SIDE) - 1.0, at(k / SIDE)));
    directions.map(f).sum::<f64>() * 4.0 * PI / (SIDE * SIDE) as f64
}

#[test]
fn the_density_integrates_to_one_and_estimates_are_those_of_quadrature() {
    for rotation in [0.0, 77.0] {
        let sky = sky(rotation);
        let density = sphere(|direction| f64::from(sky.pdf(direction)));
        assert!((density - 1.0).abs() < 2e-3, "{density}");
        // A weight that distinguishes directions, for every channel.
        let weight = |direction: Vec3| 1.5 + direction.dot(Vec3::new(0.3, -0.5, 0.7));
        for channel in 0..3 {
            let expected = sphere(|direction| f64::from(sky.radiance(direction)[channel] * weight(direction)));
            const SIDE: usize = 700;
            let mut mean = 0.0;
            for k in 0..SIDE * SIDE {
                let direction = sky.sample([k % SIDE, k / SIDE].map(|k| (k as f32 + 0.5) / SIDE as f32));
                let share = sky.radiance(direction)[channel] * weight(direction) / sky.pdf(direction);
                mean += f64::from(share) / (SIDE * SIDE) as f64;
            }
            assert!((mean / expected - 1.0).abs() < 5e-3, "channel {channel}: {mean}, not {expected}");
        }
    }
}

#[test]
fn texels_are_chosen_as_often_as_they_are_bright() {
    // Pearson's chi-squared over texels: their light is known exactly.
    let (sky, map) = (sky(0.0), map());
    let ring = |row: usize| (PI * row as f64 / HEIGHT as f64).cos() - (PI * (row + 1) as f64 / HEIGHT as f64).cos();
    let middle = |k: usize| {
        let theta = PI * ((k / WIDTH) as f64 + 0.5) / HEIGHT as f64;
        let turn = 2.0 * PI * ((k % WIDTH) as f64 + 0.5) / WIDTH as f64 - PI;
        glam::DVec3::new(theta.sin() * turn.sin(), theta.sin() * turn.cos(), theta.cos()).as_vec3()
    };
    let light: Vec<f64> =
        (0..WIDTH * HEIGHT).map(|k| f64::from(luminance(map.radiance(middle(k)))) * ring(k / WIDTH)).collect();
    let whole: f64 = light.iter().sum();
    const COUNT: usize = 400_000;
    let mut state = 7u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let mut found = vec![0.0; WIDTH * HEIGHT];
    for _ in 0..COUNT {
        let direction = sky.sample([random(), random()]).as_dvec3();
        let row = (direction.z.clamp(-1.0, 1.0).acos() / PI * HEIGHT as f64) as usize;
        let column = ((direction.x.atan2(direction.y) / (2.0 * PI) + 0.5) * WIDTH as f64) as usize;
        found[row.min(HEIGHT - 1) * WIDTH + column.min(WIDTH - 1)] += 1.0;
    }
    let (mut chi, mut freedom) = (0.0, 0.0);
    for (light, found) in light.iter().zip(&found) {
        let expected = light / whole * COUNT as f64;
        if expected == 0.0 {
            // But for directions that round across a side.
            assert!(*found < 20.0, "{found} directions in a dark texel");
        } else {
            chi += (found - expected).powi(2) / expected;
            freedom += 1.0;
        }
    }
    assert!(freedom > 60.0 && chi < freedom + 4.0 * (2.0f64 * freedom).sqrt(), "{chi} of {freedom}");
}

#[test]
fn the_middle_of_the_picture_is_ahead_and_its_right_half_to_the_right() {
    // Quarters of the turn in four columns, heights in two rows.
    let texels = (0..8).map(|k| [k as f32 + 1.0; 3]).collect();
    let map = SkyMap::new(4, 2, texels).unwrap();
    let seen = |x: f32, y: f32, z: f32| map.radiance(Vec3::new(x, y, z).normalize())[0] - 1.0;
    assert_eq!([seen(-0.1, 1.0, 0.5), seen(0.1, 1.0, 0.5)], [1.0, 2.0]);
    assert_eq!([seen(0.1, -1.0, 0.5), seen(-0.1, -1.0, -0.5)], [3.0, 4.0]);
    // Turned by a quarter from +x towards +y, what was on the right is ahead.
    let image = |rotation| {
        let map = Some(std::sync::Arc::new(map.clone()));
        Environment::Image(SkyImage { source: SkySource::Day, rotation, intensity: 1.0, map })
            .resolve()
            .unwrap()
            .unwrap()
    };
    let right = Vec3::new(1.0, 0.1, 0.3).normalize();
    let ahead = Vec3::new(-0.1, 1.0, 0.3).normalize();
    assert_eq!(image(90.0).radiance(ahead), image(0.0).radiance(right));
}

#[test]
fn the_built_in_day_is_brightest_at_its_sun_and_dark_pictures_are_none() {
    let image = |map| Environment::Image(SkyImage { source: SkySource::Day, rotation: 0.0, intensity: 1.0, map });
    let day = image(None).resolve().unwrap().unwrap();
    let sun = Vec3::new(0.8, -0.4, 0.6).normalize();
    assert!(luminance(day.radiance(sun)) > 100.0 && luminance(day.radiance(Vec3::Z)) < 1.0);
    assert!(luminance(day.radiance(-Vec3::Z)) < luminance(day.radiance(Vec3::Z)));
    let dark = SkyMap::new(2, 1, vec![[0.0; 3]; 2]).unwrap();
    assert_eq!(image(Some(std::sync::Arc::new(dark))).resolve(), Ok(None));
}

#[test]
fn impossible_pictures_are_refused() {
    let problem = |width, height, texels| match SkyMap::new(width, height, texels) {
        Err(OpticsError::SkyMap { problem }) => problem,
        other => panic!("{other:?}"),
    };
    assert!(problem(2, 2, vec![[0.0; 3]; 3]).contains("2 x 2 with 3 texels"));
    assert!(problem(0, 2, vec![]).contains("expected 1 to"));
    assert!(problem(usize::MAX, 2, vec![]).contains("expected 1 to"));
    assert!(problem(2, 1, vec![[0.0; 3], [1.0, -1.0, 0.0]]).contains("texel 1, 0"));
    assert!(problem(1, 2, vec![[0.0; 3], [f32::INFINITY, 0.0, 0.0]]).contains("texel 0, 1"));
}
