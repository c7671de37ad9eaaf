//! Lights and views along axes, edges and diagonals of the box, and matter on all of its sides: light on its way has
//! the same closed forms there as anywhere (6.1, 6.3, K-03 to K-06).

use crate::common::{center, homogeneous, render, stage, unit_volume};
use glam::DVec3;
use pellucid_optics::{
    Color, ColorPoint, Light, LightKind, LightModel, Phase, PhaseNormalization, Scattering, ShadowRays, ShadowVolume,
    Shadows, srgb_encode,
};
use pellucid_scene::{
    BlurJitter, Clip, Frame, HalfAngle, InScatter, LightCorrection, Orbit, PathTrace, Projection, Scene, Stage,
    Technique, View,
};

/// Half of the sides of the box.
const HALF: DVec3 = DVec3::new(4.0, 3.0, 5.0);
const OPACITY: f64 = 0.1;
/// Pixels a side, a unit apart: some of their rays lie on sides of the box.
const PIXELS: u32 = 13;

/// Every direction to a side, an edge or a corner; zeros have both signs.
fn directions() -> Vec<[f64; 3]> {
    let parts = |k: usize| [k % 3, k / 3 % 3, k / 9].map(|part| part as f64 - 1.0);
    let all = (0..27).map(parts).filter(|direction| *direction != [0.0; 3]);
    all.flat_map(|direction| [direction, direction.map(|x| if x == 0.0 { -0.0 } else { x })]).collect()
}

/// Azimuth and elevation along every axis, and between some.
const VIEWS: [[f64; 2]; 8] =
    [[0.0, 0.0], [90.0, 0.0], [180.0, 0.0], [-90.0, 0.0], [0.0, 90.0], [0.0, -90.0], [45.0, 0.0], [90.0, 45.0]];

/// A homogeneous box around the origin, which scatters all light evenly.
fn lit(light: LightKind, [azimuth, elevation]: [f64; 2], edit: impl FnOnce(&mut Scene)) -> Stage {
    let dims = [0, 1, 2].map(|axis| 2 * HALF[axis] as usize + 1);
    let affine = glam::DAffine3::from_translation(-HALF);
    stage(crate::common::volume_of(dims, affine, |_| 0.0), homogeneous(OPACITY as f32), |scene| {
        scene.volumes[0].scattering = evenly(None);
        scene.lighting.lights = vec![Light::new(light)];
        scene.lighting.ambient = 0.0;
        scene.lighting.model = LightModel::Scattering;
        scene.camera.projection = Projection::Orthographic { height: Some(f64::from(PIXELS)) };
        scene.camera.view =
            View::Orbit(Orbit { azimuth, elevation, target: Some([0.0; 3]), distance: Some(50.0), ..Orbit::default() });
        scene.image.width = PIXELS;
        scene.image.height = PIXELS;
        scene.quality.step = 0.25;
        edit(scene);
    })
}

fn evenly(transport: Option<f64>) -> Scattering {
    let point = |through: f64| ColorPoint::new(0.0, Color::new([srgb_encode(through as f32); 3]).unwrap());
    Scattering {
        phase: Phase::Isotropic,
        phase_normalization: PhaseNormalization::Renormalised,
        transport: transport.map(|through| vec![point(through)]),
        ..Scattering::default()
    }
}

/// How far it is from a position in the box, or on a side of it, to where a direction leaves it.
fn way_out(p: DVec3, direction: DVec3) -> f64 {
    let ways = (0..3).filter(|&axis| direction[axis].abs() > 1e-9).map(|axis| {
        let side = HALF[axis] * direction[axis].signum();
        ((side - p[axis]) / direction[axis]).max(0.0)
    });
    ways.fold(f64::INFINITY, f64::min)
}

/// Colour and opacity of every pixel, by small steps in f64.
fn exact(stage: &Stage, to_light: DVec3) -> Vec<[f64; 2]> {
    const STEPS: u32 = 2000;
    let extinction = -(1.0 - OPACITY).ln();
    let pixel = |number: u32| {
        let ray = stage.viewpoint.ray(f64::from(number % PIXELS) + 0.5, f64::from(number / PIXELS) + 0.5);
        // From the plane through the middle, where the box is.
        let middle = ray.at(-ray.origin.dot(ray.direction) / ray.direction.length_squared());
        let [mut near, mut far] = [f64::NEG_INFINITY, f64::INFINITY];
        for axis in 0..3 {
            let (o, d) = (middle[axis], ray.direction[axis]);
            if d.abs() < 1e-9 {
                if o.abs() > HALF[axis] + 1e-9 {
                    return [0.0; 2];
                }
                continue;
            }
            let ends = [(-HALF[axis] - o) / d, (HALF[axis] - o) / d];
            (near, far) = (near.max(ends[0].min(ends[1])), far.min(ends[0].max(ends[1])));
        }
        if near >= far {
            return [0.0; 2];
        }
        let step = (far - near) / f64::from(STEPS);
        let light = |k: u32| {
            let t = (f64::from(k) + 0.5) * step;
            let p = (middle + ray.direction * (near + t)).clamp(-HALF, HALF);
            extinction * step * (-extinction * (t + way_out(p, to_light))).exp()
        };
        [(0..STEPS).map(light).sum(), 1.0 - (-extinction * (far - near)).exp()]
    };
    (0..PIXELS * PIXELS).map(pixel).collect()
}

/// The largest difference, and how many pixels show anything.
fn farthest(frame: &Frame, exact: &[[f64; 2]]) -> (f64, usize) {
    let apart = |(color, exact): (&[f32; 4], &[f64; 2])| {
        (f64::from(color[0]) - exact[0]).abs().max((f64::from(color[3]) - exact[1]).abs())
    };
    let pairs = frame.color.iter().zip(exact);
    (pairs.map(apart).fold(0.0, f64::max), exact.iter().filter(|exact| exact[1] > 0.0).count())
}

/// Light is held back along axes, sides and edges: on every side of the box, too, along which it may travel.
#[test]
fn aligned_lights_are_held_back() {
    for (view, kinds) in VIEWS.into_iter().zip([3, 1, 2, 1, 3, 1, 1, 2]) {
        for direction in directions() {
            let to_light = -DVec3::from_array(direction).normalize();
            let kind = LightKind::Directional { direction };
            let rays = lit(kind, view, |scene| scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 0.5 }));
            let expected = exact(&rays, to_light);
            let (apart, shown) = farthest(&render(&rays), &expected);
            assert!(apart < 1e-3 && shown > 60, "rays, {view:?}, {direction:?}: {apart}, {shown}");
            // Beside the outline that a box turns to the light, the light's picture mixes in what passed it by.
            let is_turned = direction.iter().filter(|x| **x != 0.0).count() > 1;
            let bound = if is_turned { 3e-2 } else { 1e-2 };
            if kinds >= 2 {
                let volume = ShadowVolume { resolution: 2.0 };
                let stage = lit(kind, view, |scene| scene.lighting.shadows = Shadows::Volume(volume));
                let (apart, _) = farthest(&render(&stage), &expected);
                assert!(apart < bound, "volume, {view:?}, {direction:?}: {apart}");
            }
            if kinds >= 3 {
                let settings = HalfAngle { indirect: 0.0, resolution: 96, ..HalfAngle::default() };
                let stage = lit(kind, view, |scene| scene.technique = Technique::HalfAngle(settings));
                let (apart, _) = farthest(&render(&stage), &expected);
                assert!(apart < bound, "half-angle, {view:?}, {direction:?}: {apart}");
            }
        }
    }
}

/// The same in what clips leave: the planes lie along lights and views, too.
#[test]
fn aligned_lights_are_held_back_by_what_is_left() {
    // Half of the box, cut by a box whose other sides are far away.
    let clip = Clip::Box { min: [-100.0, -100.0, 0.0], max: [100.0; 3] };
    for direction in directions() {
        let kind = LightKind::Directional { direction };
        let draw = |clips: Vec<Clip>, lower: f64| {
            let stage = lit(kind, [0.0, 0.0], |scene| {
                scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 0.5 });
                scene.clips = clips;
                scene.camera.view = View::Orbit(Orbit {
                    azimuth: 0.0,
                    elevation: 0.0,
                    target: Some([0.0, 0.0, lower]),
                    distance: Some(50.0),
                    ..Orbit::default()
                });
            });
            render(&stage)
        };
        // Rays lie half a pixel beside the plane, and along it.
        let found = draw(vec![clip], 0.5);
        let to_light = -DVec3::from_array(direction).normalize();
        let extinction = -(1.0 - OPACITY).ln();
        for column in 3..10 {
            for row in 0..6 {
                let p = DVec3::new(f64::from(column) - 6.0, 0.0, 6.5 - f64::from(row));
                if p.z.abs() > HALF.z {
                    continue;
                }
                let way = |y: f64| {
                    let p = DVec3::new(p.x, y, p.z);
                    let down = if to_light.z < -1e-9 { p.z / -to_light.z } else { f64::INFINITY };
                    way_out(p, to_light).min(down)
                };
                let light = |k: u32| {
                    let t = (f64::from(k) + 0.5) * 6e-3;
                    extinction * 6e-3 * (-extinction * (t + way(t - 3.0))).exp()
                };
                let expected: f64 = (0..1000).map(light).sum();
                let color = found.color[(row * PIXELS + column) as usize][0];
                assert!((f64::from(color) - expected).abs() < 1e-3, "{direction:?}, {p}: {color}, exact {expected}");
            }
        }
    }
}

/// Paths see what shadow rays see.
#[test]
fn paths_are_held_back_as_rays_are() {
    for direction in [[0.0, 0.0, -1.0], [-0.0, 1.0, -0.0], [1.0, 0.0, -0.0], [0.0, -1.0, 1.0], [-1.0, -1.0, 0.0]] {
        for view in [[0.0, 0.0], [90.0, 0.0], [0.0, 90.0]] {
            let kind = LightKind::Directional { direction };
            let physical = |scene: &mut Scene| scene.volumes[0].scattering = Scattering::default();
            let cast = render(&lit(kind, view, |scene| {
                physical(scene);
                scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 0.5 });
                // As paths are spread over pixels.
                scene.quality.supersampling = 8;
            }));
            let traced = render(&lit(kind, view, |scene| {
                physical(scene);
                scene.technique = Technique::PathTrace(PathTrace { samples: 256, bounces: 1, ..PathTrace::default() });
            }));
            let (mut difference, mut variance) = (0.0, 0.0);
            for ((cast, traced), noise) in cast.color.iter().zip(&traced.color).zip(&traced.noise) {
                difference += f64::from(traced[0] - cast[0]);
                variance += f64::from(*noise).powi(2);
            }
            let total: f64 = cast.color.iter().map(|color| f64::from(color[0])).sum();
            let allowed = 4.0 * variance.sqrt() + 2e-3 * total;
            assert!(total > 0.5 && difference.abs() < allowed, "{direction:?}, {view:?}: {difference} of {total}");
        }
    }
}

/// The far side of a light volume, whatever the number of its slabs: `tau L exp(-tau L)` is seen of a box lit from
/// behind.
#[test]
fn the_last_slab_is_lit_as_the_others() {
    for length in 1..=34usize {
        for resolution in [1.0, 0.3] {
            let stage = stage(unit_volume([9, length + 1, 9], |_| 1.0), homogeneous(OPACITY as f32), |scene| {
                scene.volumes[0].scattering = evenly(None);
                scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, -1.0, 0.0] })];
                scene.lighting.ambient = 0.0;
                scene.lighting.model = LightModel::Scattering;
                scene.lighting.shadows = Shadows::Volume(ShadowVolume { resolution });
                scene.quality.step = 1.0;
            });
            let depth = -(1.0 - OPACITY).ln() * length as f64;
            let (found, exact) = (f64::from(center(&render(&stage))[0]), depth * (-depth).exp());
            // Between points light is a line where it should be a curve.
            let bound = if resolution == 1.0 { 0.01 } else { 0.05 };
            assert!((found / exact - 1.0).abs() < bound, "{length} slabs, {resolution}: {found}, exact {exact}");
        }
    }
}

/// Far behind the last matter, too, light is what is left: where points are far apart, they lie there.
#[test]
fn points_behind_matter_know_its_shadow() {
    // A plate in front of a hundred slabs of emptiness, in which light volumes have points twenty voxels apart.
    let plate = |p: DVec3| if p.y < 3.0 { 1.0 } else { 0.0 };
    let tf = crate::common::transfer_function(&[(0.0, 0xffffff)], &[(0.4, 0.0), (0.5, 0.2)]);
    let draw = |resolution: f64| {
        let stage = stage(unit_volume([9, 101, 9], plate), tf.clone(), |scene| {
            scene.volumes[0].scattering = evenly(None);
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 1.0, 0.0] })];
            scene.lighting.ambient = 0.0;
            scene.lighting.model = LightModel::Scattering;
            scene.lighting.shadows = Shadows::Volume(ShadowVolume { resolution });
        });
        f64::from(center(&render(&stage))[0])
    };
    // Light falls within the plate from 1 to 0.8^2.5; between points at 0 and 20 it falls a little.
    let (through, length) = (0.8f64.powf(2.5), 2.5);
    let opacity = 1.0 - through;
    let behind = 1.0 - (1.0 - through) * length / 20.0;
    let found = draw(0.05);
    assert!(found > opacity * behind * 0.98 && found < opacity, "{found}, {opacity}, {behind}");
}

/// K-06b: light of half a slab is of second order, whatever becomes indirect light. Where nothing is absorbed, direct
/// and indirect light together are 2 at any step.
#[test]
fn half_slabs_are_of_second_order() {
    let schemes = [InScatter::Indirect, InScatter::Direct, InScatter::DirectFromMatter, InScatter::BothFromMatter];
    let length = 32.0f64;
    let tau = -(1.0f64 - 0.08).ln();
    let draw = |in_scatter, transport: f64, direction: [f64; 3], step: f64| {
        let stage = stage(unit_volume([65, 33, 65], |_| 1.0), homogeneous(0.08), |scene| {
            scene.volumes[0].scattering = evenly(Some(transport));
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction })];
            scene.lighting.ambient = 0.0;
            scene.camera.projection = Projection::Orthographic { height: Some(0.5) };
            scene.image.width = 2;
            scene.image.height = 2;
            scene.quality.step = step;
            let settings = HalfAngle { in_scatter, resolution: 64, ..HalfAngle::default() };
            scene.technique = Technique::HalfAngle(settings);
        });
        let color = render(&stage).color[0];
        (f64::from(color[0]), f64::from(color[3]))
    };
    for in_scatter in schemes {
        for direction in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]] {
            for step in [2.0, 1.0, 0.5, 0.25] {
                if in_scatter != InScatter::Indirect {
                    let (color, alpha) = draw(in_scatter, 1.0, direction, step);
                    assert!(
                        (color / alpha - 2.0).abs() < 1e-4,
                        "{in_scatter:?}, {direction:?}, {step}: {color} {alpha}"
                    );
                }
            }
        }
        // Light that came s deep: exp(-tau s) is direct, and of the rest, which loses kappa, there is this much.
        let kappa = 0.03f64;
        let light = |s: f64| {
            let gained = if in_scatter == InScatter::Indirect { 0.0 } else { 1.0 - (-(tau - kappa) * s).exp() };
            (-tau * s).exp() + (-kappa * s).exp() * (1.0 + gained)
        };
        let exact: f64 = (0..20_000)
            .map(|k| (f64::from(k) + 0.5) * length / 20_000.0)
            .map(|s| tau * (-tau * s).exp() * light(s) * length / 20_000.0)
            .sum();
        let error = |step: f64| draw(in_scatter, (-kappa).exp(), [0.0, 1.0, 0.0], step).0 - exact;
        let errors = [4.0, 2.0, 1.0].map(error);
        println!("{in_scatter:?}: {errors:?}");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((1.8..2.3).contains(&order), "{in_scatter:?}: order {order}, {errors:?}");
        }
    }
}

/// What a blur does to light that comes along an axis knows no left and right, and the finer its texels, the less it
/// changes: beside the box nothing is lost, on either side of it.
#[test]
fn blurred_light_is_alike_on_all_sides() {
    let draw = |direction: [f64; 3], resolution: u32, jitter| {
        let settings = HalfAngle { blur_angle: 40.0, resolution, jitter, ..HalfAngle::default() };
        render(&lit(LightKind::Directional { direction }, [0.0, 0.0], |scene| {
            scene.technique = Technique::HalfAngle(settings);
            scene.quality.step = 0.5;
        }))
    };
    let n = PIXELS as usize;
    for direction in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0].map(|x: f64| x * 1e-9)] {
        for resolution in [17, 24, 31, 32, 33, 40, 64] {
            let frame = draw(direction, resolution, BlurJitter::Fixed);
            for k in 0..n * n {
                let (column, row) = (k % n, k / n);
                for other in [row * n + n - 1 - column, (n - 1 - row) * n + column] {
                    let apart = (frame.color[k][0] - frame.color[other][0]).abs();
                    assert!(apart < 1e-5, "{direction:?} at {resolution}: {apart} at {column}, {row}");
                }
            }
        }
        let mean = |resolution| {
            let frame = draw(direction, resolution, BlurJitter::PerSlice);
            frame.color.iter().map(|color| f64::from(color[0])).sum::<f64>() / (n * n) as f64
        };
        let means = [64, 128, 200, 256, 400, 512].map(mean);
        println!("{means:?}");
        let end = means[5];
        for pair in means.windows(2) {
            assert!((pair[1] - end).abs() <= (pair[0] - end).abs() + 1e-4 * end, "{means:?}");
        }
        assert!((means[4] / end - 1.0).abs() < 5e-3, "{means:?}");
    }
}

/// Without the correction light is of first order, as in the book (K-06).
#[test]
fn uncorrected_light_is_of_first_order() {
    let draw = |step: f64| {
        let settings =
            HalfAngle { indirect: 0.0, correction: LightCorrection::None, resolution: 64, ..HalfAngle::default() };
        let stage = lit(LightKind::Directional { direction: [0.0, 1.0, 0.0] }, [0.0, 0.0], |scene| {
            scene.technique = Technique::HalfAngle(settings);
            scene.quality.step = step;
        });
        f64::from(center(&render(&stage))[0])
    };
    let depth = -(1.0 - OPACITY).ln() * 6.0;
    let exact = (1.0 - (-2.0 * depth).exp()) / 2.0;
    let errors = [1.0, 0.5, 0.25].map(|step| draw(step) - exact);
    assert!(errors[0] > errors[1] && errors[1] > errors[2] && errors[2] > 0.0, "{errors:?}");
    assert!((0.9..1.1).contains(&(errors[0] / errors[1]).log2()), "{errors:?}");
}
