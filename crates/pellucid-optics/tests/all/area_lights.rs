//! Lights that have a size against closed forms, quadrature and the points that stand for them.

use std::f64::consts::PI;

use glam::{DAffine3, Vec3};
use pellucid_optics::{Falloff, Light, LightKind, ResolvedLight, turned};

const PHYSICAL: Falloff = Falloff::InverseSquare { reference: 2.0 };

fn sized(kind: LightKind, radius: f64) -> ResolvedLight {
    Light { radius, ..Light::new(kind) }.resolve(DAffine3::IDENTITY).unwrap()
}

fn sun(radius: f64) -> ResolvedLight {
    sized(LightKind::Directional { direction: [0.3, 0.4, -1.0] }, radius)
}

fn ball(radius: f64) -> ResolvedLight {
    sized(LightKind::Point { position: [1.0, 0.5, 3.0], falloff: PHYSICAL }, radius)
}

fn face(width: f64, height: f64, two_sided: bool) -> ResolvedLight {
    // It shines down.
    let edges = [[width, 0.0, 0.0], [0.0, -height, 0.0]];
    sized(LightKind::Rectangle { center: [0.5, 0.2, 2.0], edges, two_sided, falloff: PHYSICAL }, 0.0)
}

fn lights() -> [ResolvedLight; 6] {
    let spot = LightKind::Spot {
        position: [0.0, 1.0, 2.0],
        direction: [0.0, -0.4, -1.0],
        inner_angle: 20.0,
        outer_angle: 60.0,
        falloff: Falloff::None,
    };
    [sun(20.0), sun(90.0), ball(0.7), sized(spot, 0.5), face(2.0, 1.0, false), face(1.0, 3.0, true)]
}

/// Evenly spread pairs of numbers in 0..1.
fn pairs(side: usize) -> impl Iterator<Item = [f32; 2]> {
    let at = move |k: usize| (k as f32 + 0.5) / side as f32;
    (0..side * side).map(move |k| [at(k % side), at(k / side)])
}

/// The integral over all directions.
fn sphere(side: usize, f: impl Fn(Vec3) -> f64) -> f64 {
    let directions = pairs(side).map(|[u, v]| turned(Vec3::Z, 2.0 * u - 1.0, v));
    directions.map(f).sum::<f64>() * 4.0 * PI / (side * side) as f64
}

#[test]
fn directions_are_as_frequent_as_they_claim() {
    // Pearson's chi-squared over 16 x 24 fields of the sphere that are equally large, by 2^18 random directions.
    const COUNT: usize = 1 << 18;
    const ROWS: usize = 16;
    const COLUMNS: usize = 24;
    for (number, light) in lights().iter().enumerate() {
        let field = |direction: Vec3| {
            let turn = f64::from(direction.y).atan2(f64::from(direction.x)) / (2.0 * PI) + 0.5;
            let height = f64::from(direction.z) * 0.5 + 0.5;
            let [row, column] = [(height, ROWS), (turn, COLUMNS)].map(|(v, n)| ((v * n as f64) as usize).min(n - 1));
            row * COLUMNS + column
        };
        let mut expected = vec![0.0; ROWS * COLUMNS];
        const SIDE: usize = 2400;
        for [u, v] in pairs(SIDE) {
            let direction = turned(Vec3::Z, 2.0 * u - 1.0, v);
            let density = light.seen(Vec3::ZERO, direction).map_or(0.0, |seen| f64::from(seen.density));
            expected[field(direction)] += density * 4.0 * PI / (SIDE * SIDE) as f64 * COUNT as f64;
        }
        let whole = expected.iter().sum::<f64>() / COUNT as f64;
        assert!((whole - 1.0).abs() < 2e-3, "light {number}: its density has the integral {whole}");
        let mut found = vec![0.0; ROWS * COLUMNS];
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        for _ in 0..COUNT {
            found[field(light.sample(Vec3::ZERO, [random(), random()]).incident.to_light)] += 1.0;
        }
        // Fields of few directions are left out, as their numbers are not normal.
        let kept = || expected.iter().zip(&found).filter(|(expected, _)| **expected > 50.0);
        let chi = kept().map(|(expected, found)| (found - expected).powi(2) / expected).sum::<f64>();
        let freedom = kept().count() as f64;
        // Four deviations, and the error of the quadrature along the outline.
        assert!(
            freedom > 4.0 && chi < freedom + 4.0 * (2.0 * freedom).sqrt() + 10.0,
            "light {number}: {chi} of {freedom}"
        );
    }
}

#[test]
fn what_is_chosen_is_what_is_seen() {
    for (number, light) in lights().iter().enumerate() {
        for at in [Vec3::ZERO, Vec3::new(0.4, -0.6, 0.3)] {
            let mut mean = 0.0;
            for u in pairs(300) {
                let sample = light.sample(at, u);
                // A weight that distinguishes directions.
                mean += f64::from(sample.incident.radiance[0] * (1.5 + sample.incident.to_light.x)) * PI / 90_000.0;
                // Edges aside, the ray meets the light there, with the density and the radiance it was chosen by.
                if u.iter().all(|v| (0.01..0.99).contains(v)) {
                    let seen = light.seen(at, sample.incident.to_light).unwrap();
                    let near = |a: f32, b: f32| a == b || (a - b).abs() < 2e-3 * b.abs();
                    assert!(near(seen.density, sample.density), "light {number}: {seen:?} and {sample:?}");
                    assert!(near(seen.distance, sample.distance), "light {number}: {seen:?} and {sample:?}");
                    let radiance = sample.incident.radiance[0] * sample.density * PI as f32;
                    assert!(near(seen.radiance[0], radiance), "light {number}: {seen:?} and {sample:?}");
                }
            }
            let whole = sphere(1500, |direction| {
                light.seen(at, direction).map_or(0.0, |seen| f64::from(seen.radiance[0] * (1.5 + direction.x)))
            });
            assert!((mean / whole - 1.0).abs() < 3e-3, "light {number}: {mean} and {whole}");
        }
    }
}

#[test]
fn a_surface_gets_what_closed_forms_say() {
    let irradiance = |light: &ResolvedLight, at: Vec3, normal: Vec3| {
        let from = pairs(400).map(|u| light.sample(at, u).incident);
        // A light of radiance 1 brings pi.
        from.map(|i| f64::from(i.radiance[0] * normal.dot(i.to_light).max(0.0))).sum::<f64>() * PI / 160_000.0
    };
    // A disc and a ball wholly above the surface light it like their centres, however large they are.
    let to_sun = sun(0.0).incident(Vec3::ZERO).to_light;
    for radius in [0.27, 5.0, 40.0] {
        let found = irradiance(&sun(radius), Vec3::ZERO, to_sun);
        assert!((found / PI - 1.0).abs() < 1e-4, "a disc of {radius} degrees: {found}");
        let found = irradiance(&sun(radius), Vec3::ZERO, Vec3::Z);
        assert!((found / PI / f64::from(to_sun.z) - 1.0).abs() < 1e-4, "a disc of {radius} degrees: {found}");
    }
    let center = Vec3::new(1.0, 0.5, 3.0);
    for radius in [0.01, 0.5, 2.5] {
        let found = irradiance(&ball(radius), Vec3::ZERO, Vec3::Z);
        let expected = PI * 4.0 / f64::from(center.length().powi(3)) * 3.0;
        assert!((found / expected - 1.0).abs() < 1e-4, "a ball of {radius}: {found}, not {expected}");
    }
    // A parallel rectangle above a point: four times that with a corner there (Howell's C-11).
    for (width, height) in [(2.0f64, 1.0f64), (0.1, 4.0), (20.0, 30.0)] {
        let distance = 2.0;
        let [a, b] = [width, height].map(|side| side / 2.0 / distance);
        let half = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
        let factor = 4.0 * (half(a, b) + half(b, a)) / (2.0 * PI);
        // Of even radiance, such that it brings pi at its reference of 2 if it is small.
        let expected = PI * factor * PI * 4.0 / (width * height);
        let found = irradiance(&face(width, height, false), Vec3::new(0.5, 0.2, 0.0), Vec3::Z);
        assert!((found / expected - 1.0).abs() < 1e-3, "{width} x {height}: {found}, not {expected}");
    }
}

#[test]
fn small_lights_are_points() {
    let at = Vec3::new(0.2, -0.1, 0.4);
    let point = LightKind::Point { position: [1.0, 0.5, 3.0], falloff: PHYSICAL };
    for (small, middle) in [
        (sun(1e-3), sun(0.0).incident(at)),
        (ball(1e-4), sized(point, 0.0).incident(at)),
        // So small that single precision has one direction for it.
        (ball(1e-12), sized(point, 0.0).incident(at)),
        (face(1e-4, 1e-4, false), face(1.0, 1.0, false).incident(at)),
    ] {
        for u in pairs(5) {
            let sample = small.sample(at, u);
            assert!((sample.incident.to_light - middle.to_light).length() < 1e-4);
            assert!((sample.incident.radiance[0] / middle.radiance[0] - 1.0).abs() < 1e-3);
        }
    }
    assert!(sun(0.0).seen(at, sun(0.0).incident(at).to_light).is_none());
    assert!(!sun(0.0).has_extent() && sun(0.1).has_extent());
}

#[test]
fn faces_shine_to_one_side_or_to_both() {
    let above = Vec3::new(0.5, 0.2, 5.0);
    let below = Vec3::new(0.5, 0.2, -1.0);
    let [one, both] = [false, true].map(|two_sided| face(1.0, 1.0, two_sided));
    assert_eq!(one.incident(above).radiance, [0.0; 3]);
    assert_eq!(one.sample(above, [0.3; 2]).incident.radiance, [0.0; 3]);
    assert!(one.seen(above, -Vec3::Z).is_none());
    assert_eq!(both.incident(above).radiance, both.incident(below).radiance);
    assert_eq!(both.incident(below).radiance, one.incident(below).radiance);
    assert!(both.seen(above, -Vec3::Z).is_some());
    // Beside it there is nothing, nor along it.
    assert!(one.seen(below, Vec3::new(0.3, 0.0, 1.0).normalize()).is_none());
    let along = both.sample(Vec3::new(3.0, 0.0, 2.0), [0.5; 2]);
    assert_eq!(along.incident.radiance, [0.0; 3]);
    let inside = both.sample(Vec3::new(0.5, 0.2, 2.0), [0.5; 2]);
    assert!(inside.incident.radiance.iter().all(|v| v.is_finite()), "{inside:?}");
}

#[test]
fn impossible_sizes_are_refused() {
    let refused =
        |kind, radius| Light { radius, ..Light::new(kind) }.resolve(DAffine3::IDENTITY).unwrap_err().to_string();
    let point = LightKind::Point { position: [0.0; 3], falloff: Falloff::None };
    assert!(refused(point, -1.0).contains("light radius is -1"));
    assert!(refused(point, f64::NAN).contains("light radius"));
    assert!(refused(LightKind::Directional { direction: [1.0, 0.0, 0.0] }, 91.0).contains("0 to 90 degrees"));
    let rectangle = |edges| LightKind::Rectangle { center: [0.0; 3], edges, two_sided: false, falloff: Falloff::None };
    assert!(refused(rectangle([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), 1.0).contains("light radius is 1"));
    for edges in [[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], [[0.0; 3]; 2], [[f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0]]] {
        assert!(refused(rectangle(edges), 0.0).contains("not parallel"), "{edges:?}");
    }
}
