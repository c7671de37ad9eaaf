//! The path tracer against closed forms, quadrature, the ray caster and its own statistics.

use std::f64::consts::PI;
use std::time::{Duration, Instant};

use crate::common::paths::*;
use crate::common::{homogeneous, render, stage, transfer_function, unit_volume};
use pellucid_cpu::{CpuRenderer, RenderError};
use pellucid_optics::{
    BackLobe, Color, Environment, Light, Material, Phase, PhaseTable, Scattering, SurfaceShare, TableAngles, luminance,
};
use pellucid_scene::{Cancel, Control, Frame, Majorants, Mode, PathTrace, RayCast, Technique};

#[test]
fn a_slab_has_its_transmittance() {
    for opacity in [0.05f32, 0.2, 0.5] {
        let (_, frame) = traced(cube(8), opacity, PathTrace { samples: 256, ..PathTrace::default() }, |_| {});
        let expected = 1.0 - (1.0 - f64::from(opacity)).powi(8);
        agrees(mean(&middle(&frame), |c| f64::from(c[3])), expected, &format!("opacity {opacity}"));
        assert!(frame.color.iter().all(|c| c[..3] == [0.0; 3]));
    }
}

#[test]
fn in_even_light_nothing_that_only_scatters_can_be_seen() {
    // The white furnace: whatever the phase function, what is scattered out is scattered in.
    let rainbow = (0..32).map(|k| [1.0 + k as f32, 40.0 - k as f32, 5.0]).collect();
    let back = (0..8).map(|k| [0.1 * k as f32, 1.0, 2.0]).collect();
    let phases = [
        Phase::Isotropic,
        Phase::Rayleigh,
        Phase::HenyeyGreenstein { g: 0.8 },
        Phase::HenyeyGreenstein { g: -0.5 },
        Phase::DoubleHenyeyGreenstein { first: 0.9, second: -0.4, share: 0.7 },
        Phase::Schlick { g: 0.6 },
        Phase::Table(PhaseTable::new(TableAngles::Theta, rainbow).unwrap()),
        Phase::Hybrid { g: 0.5, back: BackLobe::new(TableAngles::Theta, back).unwrap() },
    ];
    for phase in phases {
        for majorants in [Majorants::Local, Majorants::Global] {
            let name = phase.name();
            let settings = PathTrace { samples: 128, environment: WHITE, majorants, ..PathTrace::default() };
            let (_, frame) = traced(blobs(12), 0.0, settings, |scene| {
                scene.volumes[0].transfer_function =
                    Some(transfer_function(&[(0.0, 0x336699)], &[(0.0, 0.0), (1.0, 0.6)]));
                scene.volumes[0].scattering = scattering(phase.clone(), 1.0);
            });
            for channel in 0..3 {
                let seen = mean(&frame, |c| f64::from(c[channel]) + 1.0 - f64::from(c[3]));
                agrees(seen, 1.0, &format!("{name}, {majorants:?}, channel {channel}"));
            }
            assert!(mean(&frame, |c| f64::from(c[3])).0 > 0.05, "{name}: the medium is seen");
        }
    }
    // A sky that is not even is a sky all the same: on the mean of all directions nothing changes, and
    // its two ways to be found, by chance and by choice, add up.
    let sky = Environment::Gradient { top: Color::WHITE, bottom: Color::BLACK, intensity: 1.0 };
    let settings = PathTrace { samples: 512, environment: sky, bounces: 1, ..PathTrace::default() };
    let (_, thin) = traced(cube(8), 0.001, settings, |scene| {
        scene.volumes[0].scattering = scattering(Phase::HenyeyGreenstein { g: 0.8 }, 1.0);
    });
    // Single scattering of light from the horizon on the mean: half of the albedo, in a thin medium.
    let thin = middle(&thin);
    let (covered, _) = mean(&thin, |c| f64::from(c[3]));
    let (bright, error) = mean(&thin, |c| f64::from(c[0]));
    assert!((bright / covered - 0.5).abs() < 4.0 * error / covered + 0.01, "{bright} of {covered}");
}

#[test]
fn light_that_is_scattered_once_is_the_integral_along_the_ray() {
    // A cube of side 8, looked at along +y. The sun shines from the left, or from behind, or from the eye.
    const SIDE: f64 = 8.0;
    let opacity = 0.1f32;
    let kappa = -f64::from(1.0 - opacity).ln();
    for g in [0.0f32, 0.7] {
        for (direction, mu) in [([1.0, 0.0, 0.0], 0.0), ([0.0, -1.0, 0.0], 1.0), ([0.0, 1.0, 0.0], -1.0f64)] {
            let settings = PathTrace { samples: 256, bounces: 1, ..PathTrace::default() };
            let (stage, frame) = traced(cube(8), opacity, settings, |scene| {
                scene.lighting.lights = vec![directional(direction)];
                scene.volumes[0].scattering = scattering(Phase::HenyeyGreenstein { g }, 0.8);
            });
            let g = f64::from(g);
            let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * mu).powf(1.5));
            // Each pixel has its own way to the light: the mean over its width is the mean over x.
            let (mut sum, mut squares, mut expected, mut count) = (0.0, 0.0, 0.0, 0);
            for (k, color) in frame.color.iter().enumerate() {
                let [low, high] = [0.0, 1.0].map(|side| {
                    let ray = stage.viewpoint.ray((k % 16) as f64 + side, (k / 16) as f64 + side);
                    (ray.origin.x, ray.origin.z)
                });
                if low.0 < 0.0 || high.0 > SIDE || high.1 < 0.0 || low.1 > SIDE {
                    continue;
                }
                const STEPS: usize = 200;
                let at = |from: f64, to: f64, k: usize| from + (to - from) * (k as f64 + 0.5) / STEPS as f64;
                let mut integral = 0.0;
                for i in 0..STEPS {
                    let x = at(low.0, high.0, i);
                    for j in 0..STEPS {
                        let y = at(0.0, SIDE, j);
                        let to_light = if direction[0] != 0.0 {
                            x
                        } else if mu > 0.0 {
                            SIDE - y
                        } else {
                            y
                        };
                        integral += (-kappa * (y + to_light)).exp() * kappa * SIDE / (STEPS * STEPS) as f64;
                    }
                }
                // A light of intensity 1 brings pi.
                expected += 0.8 * phase * PI * integral;
                let found = f64::from(color[0]);
                sum += found;
                squares += f64::from(frame.noise[k]).powi(2);
                count += 1;
            }
            // The luminance of white is the number itself: the pixels' own errors are those of the sum.
            let z = (sum - expected) / squares.sqrt();
            assert!(z.abs() < 4.0, "g = {g}, light along {direction:?}: {sum}, not {expected} ({z} deviations)");
            assert!(count > 100 && expected > 1.0);
        }
    }
}

#[test]
fn without_scattering_there_is_the_ray_casters_absorption_and_emission() {
    let tf = transfer_function(
        &[(0.0, 0x102040), (0.5, 0xff8000), (1.0, 0xffffff)],
        &[(0.0, 0.0), (0.1, 0.0), (0.6, 0.3), (1.0, 0.9)],
    );
    let glow = Material { emission: 1.0, ambient: 0.0, diffuse: 0.0, specular: 0.0, ..Material::default() };
    let settings = PathTrace { samples: 512, bounces: 0, ..PathTrace::default() };
    let prepared = |technique: Technique| {
        stage(blobs(20), tf.clone(), |scene| {
            scene.lighting = DARK;
            scene.volumes[0].shading = Some(true);
            scene.volumes[0].material = Some(glow);
            // A radiograph is framed by all of its values.
            scene.camera.frame = pellucid_scene::Framing::Grid;
            // Rays of the mean over each pixel, as paths are.
            scene.quality.supersampling = 8;
            scene.quality.step = 0.25;
            (scene.image.width, scene.image.height) = (32, 32);
            scene.technique = technique;
        })
    };
    let paths = render(&prepared(Technique::PathTrace(settings)));
    for mode in [Mode::Composite, Mode::XRay] {
        let rays = render(&prepared(Technique::RayCast(RayCast { mode: mode.clone() })));
        let (mut z_squared, mut count) = (0.0, 0.0);
        for (path, ray) in paths.color.iter().zip(&rays.color) {
            let (covered, expected) = (f64::from(path[3]), f64::from(ray[3]));
            if (0.02..0.98).contains(&expected) {
                z_squared += (covered - expected).powi(2) / (expected * (1.0 - expected) / 512.0);
                count += 1.0;
            }
        }
        // A chi-squared of `count` degrees: its mean is 1, its deviation sqrt(2 / count).
        let deviation = (2.0f64 / count).sqrt();
        assert!(
            count > 60.0 && (z_squared / count - 1.0).abs() < 4.0 * deviation,
            "{mode:?}: {} of {count}",
            z_squared / count
        );
        if mode == Mode::Composite {
            let (mut difference, mut squares) = (0.0, 0.0);
            for (k, (path, ray)) in paths.color.iter().zip(&rays.color).enumerate() {
                let of = |c: &[f32; 4]| f64::from(luminance([c[0], c[1], c[2]]));
                difference += of(path) - of(ray);
                squares += f64::from(paths.noise[k]).powi(2);
            }
            let z = difference / squares.sqrt();
            assert!(z.abs() < 4.0, "emission: {z} deviations");
        }
    }
}

#[test]
fn one_majorant_and_many_give_one_picture() {
    let drawn = |majorants, filter| {
        let settings = PathTrace { samples: 256, majorants, environment: WHITE, bounces: 3, ..PathTrace::default() };
        traced(blobs(24), 0.0, settings, |scene| {
            scene.volumes[0].transfer_function = Some(transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (1.0, 0.8)]));
            scene.volumes[0].scattering = scattering(Phase::HenyeyGreenstein { g: 0.5 }, 0.7);
            scene.lighting.lights = vec![directional([1.0, 0.5, 0.0])];
            scene.quality.filter = filter;
        })
        .1
    };
    for filter in [pellucid_field::Filter::Linear, pellucid_field::Filter::CATMULL_ROM] {
        let [local, global] = [Majorants::Local, Majorants::Global].map(|majorants| drawn(majorants, filter));
        let sum = |frame: &Frame| frame.color.iter().map(|c| f64::from(c[0])).sum::<f64>();
        let squares = local.noise.iter().chain(&global.noise).map(|v| f64::from(*v).powi(2)).sum::<f64>();
        let z = (sum(&local) - sum(&global)) / squares.sqrt();
        assert!(z.abs() < 4.0, "{filter:?}: {z} deviations");
        let evaluations = |frame: &Frame| frame.statistics.samples;
        assert!(
            evaluations(&local) * 2 < evaluations(&global),
            "{} evaluations and {}",
            evaluations(&local),
            evaluations(&global)
        );
    }
}

#[test]
fn paths_that_end_at_random_bring_as_much_light() {
    let drawn = |roulette| {
        let settings = PathTrace { samples: 512, roulette, environment: WHITE, ..PathTrace::default() };
        traced(cube(8), 0.5, settings, |scene| {
            scene.volumes[0].scattering = scattering(Phase::HenyeyGreenstein { g: 0.5 }, 0.8);
        })
        .1
    };
    let [early, never] = [drawn(0), drawn(100_000)];
    let sum = |frame: &Frame| frame.color.iter().map(|c| f64::from(c[0])).sum::<f64>();
    let squares = early.noise.iter().chain(&never.noise).map(|v| f64::from(*v).powi(2)).sum::<f64>();
    let z = (sum(&early) - sum(&never)) / squares.sqrt();
    assert!(z.abs() < 4.0, "{z} deviations");
    assert!(early.statistics.samples * 5 < never.statistics.samples * 4);
}

#[test]
fn the_claimed_noise_is_that_of_repeated_pictures() {
    let mut scores = Vec::new();
    let pictures: Vec<Frame> = (0..24)
        .map(|seed| {
            let settings = PathTrace { samples: 256, seed, bounces: 4, environment: WHITE, ..PathTrace::default() };
            traced(cube(4), 0.3, settings, |scene| {
                scene.volumes[0].scattering = scattering(Phase::Isotropic, 0.5);
                scene.lighting.lights = vec![directional([1.0, 1.0, 0.0])];
            })
            .1
        })
        .collect();
    for pixel in 0..pictures[0].color.len() {
        let numbers: Vec<f64> = pictures.iter().map(|frame| f64::from(frame.color[pixel][0])).collect();
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        for (frame, number) in pictures.iter().zip(&numbers) {
            if frame.noise[pixel] > 0.0 {
                scores.push((number - mean) / f64::from(frame.noise[pixel]));
            }
        }
    }
    // Around their own mean of 24 the variance is 23/24.
    let n = scores.len() as f64;
    let variance = scores.iter().map(|z| z * z).sum::<f64>() / n * 24.0 / 23.0;
    let beyond = scores.iter().filter(|z| z.abs() > 2.0).count() as f64 / n;
    assert!(n > 2000.0 && (variance - 1.0).abs() < 0.08, "{variance} of {n} scores");
    // 4.6 % of normal numbers; of means of few skewed ones about as many.
    assert!((0.03..0.065).contains(&beyond), "{beyond}");
}

#[test]
fn noise_targets_are_met_with_fewer_paths() {
    let drawn = |noise| {
        let settings = PathTrace { samples: 8192, noise, environment: WHITE, bounces: 4, ..PathTrace::default() };
        traced(cube(4), 0.3, settings, |scene| {
            scene.volumes[0].scattering = scattering(Phase::Isotropic, 0.8);
        })
        .1
    };
    let frame = drawn(0.03);
    let met = |k: &usize| f64::from(frame.noise[*k]) <= 0.03 * f64::from(frame.color[*k][0]).max(1e-3) * 1.0001;
    assert!((0..frame.color.len()).all(|k| met(&k)));
    assert!(frame.statistics.rays < drawn(0.0).statistics.rays / 3);
}

#[test]
fn surfaces_are_those_of_the_ray_caster_with_shadows() {
    // An opaque cube that is all surface, lit from the eye: the first collision is at its front, whose
    // gradient, one-sided at the border, points inwards.
    let ramp = unit_volume([9; 3], |p| p.y);
    let material = Material { diffuse: 0.8, specular: 0.0, ambient: 0.0, ..Material::default() };
    let settings = PathTrace { samples: 64, bounces: 1, ..PathTrace::default() };
    let (_, frame) = traced(ramp, 1.0, settings, |scene| {
        scene.lighting.lights = vec![directional([0.0, 1.0, 0.0])];
        scene.volumes[0].shading = Some(true);
        scene.volumes[0].material = Some(material);
        scene.volumes[0].scattering = Scattering {
            surface: SurfaceShare::Values(vec![pellucid_optics::NumberPoint::new(0.0, 1.0)]),
            ..Scattering::default()
        };
    });
    // Half of the depth of the collision is on the way in, half on the way out: at infinite extinction
    // there would be no shadow, at any extinction its mean is 1/2, as on any flat medium lit from the eye.
    agrees(mean(&middle(&frame), |c| f64::from(c[0])), 0.4, "a front lit head-on");
}

#[test]
fn surfaces_may_be_lit_in_front_of_their_own_matter() {
    // A slab, all surface, of a value that rises inwards, lit at an angle from the eye; and a wall of a voxel that
    // stands on it and throws a shadow.
    let drawn = |surface_depth, heights: std::ops::Range<f64>| {
        let volume = unit_volume([17, 13, 17], |p| match p.y {
            y if y > 5.5 => 1.0 + 0.01 * y,
            _ if p.z == 2.0 => 1.0,
            _ => 0.0,
        });
        let settings = PathTrace { samples: 256, bounces: 1, surface_depth, ..PathTrace::default() };
        let material = Material { diffuse: 0.8, specular: 0.0, ambient: 0.0, ..Material::default() };
        let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (0.5, 0.0), (0.51, 0.999)]);
        let (stage, frame) = traced(volume, 0.0, settings, |scene| {
            scene.volumes[0].transfer_function = Some(tf);
            scene.lighting.lights = vec![directional([0.0, 1.0, 0.5])];
            scene.volumes[0].shading = Some(true);
            scene.volumes[0].material = Some(material);
            let surface = SurfaceShare::Values(vec![pellucid_optics::NumberPoint::new(0.0, 1.0)]);
            scene.volumes[0].scattering = Scattering { surface, ..Scattering::default() };
        });
        let at = |k: usize| stage.viewpoint.ray((k % 16) as f64 + 0.5, (k / 16) as f64 + 0.5).origin;
        let kept = (0..256).filter(|k| (4.0..12.0).contains(&at(*k).x) && heights.contains(&at(*k).z));
        let part = Frame { color: kept.map(|k| frame.color[k]).collect(), ..Frame::default() };
        mean(&part, |c| f64::from(c[0]))
    };
    let cosine = 1.0 / 1.25f64.sqrt();
    // Depths along the eye's ray are exponential; light travels 1 / cosine of each, less what is skipped:
    // 1 - e^-k + e^-k * (share left beyond).
    let share = |k: f64| 1.0 - (-k).exp() * (1.0 - 1.0 / (1.0 + 1.0 / cosine));
    for k in [0.0f32, 1.0, 3.0] {
        agrees(drawn(k, 8.0..14.0), 0.8 * cosine * share(f64::from(k)), &format!("{k} mean free paths"));
        // Light passes a height of 5.5 over a depth of 2.75: the wall's shadow ends at 5.2.
        assert!(drawn(k, 3.2..4.8).0 < 0.02, "{k} mean free paths: {:?} in the shadow", drawn(k, 3.2..4.8));
    }
}

#[test]
fn clips_and_holes_let_light_through() {
    let holed = unit_volume([9; 3], |p| if p.x < 3.5 { f64::NAN } else { 0.0 });
    let settings = PathTrace { samples: 64, ..PathTrace::default() };
    let clip = pellucid_scene::Clip::Plane { point: [6.2, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] };
    let (stage, frame) = traced(holed, 0.9, settings, |scene| scene.clips = vec![clip]);
    for (k, color) in frame.color.iter().enumerate() {
        let [left, right] =
            [0.0, 1.0].map(|side| stage.viewpoint.ray((k % 16) as f64 + side, (k / 16) as f64 + 0.5).origin);
        // The nearest voxel of a hole is absent: it ends halfway between 3 and 4.
        if right.x < 3.5 || left.x > 6.2 {
            assert_eq!(color[3], 0.0, "{left}");
        } else if left.x > 3.5 && right.x < 6.2 && (0.5..7.5).contains(&left.z) {
            assert!(color[3] > 0.99, "{left}: {}", color[3]);
        }
    }
}

#[test]
fn the_picture_is_the_same_for_any_number_of_threads_and_another_with_another_seed() {
    let drawn = |threads, side, seed| {
        let settings = PathTrace { samples: 8, seed, environment: WHITE, ..PathTrace::default() };
        let stage = stage(blobs(16), transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (1.0, 0.8)]), |scene| {
            scene.technique = Technique::PathTrace(settings);
            (scene.image.width, scene.image.height) = (37, 23);
        });
        CpuRenderer::with_threads(threads).unwrap().with_tile_size(side).render(&stage, &Control::default()).unwrap()
    };
    let one = drawn(1, 32, 0);
    for (threads, side) in [(2, 32), (5, 7)] {
        let other = drawn(threads, side, 0);
        assert_eq!((&one.color, &one.depth), (&other.color, &other.depth));
        assert_eq!((&one.noise, &one.samples), (&other.noise, &other.samples));
    }
    assert_ne!(one.color, drawn(1, 32, 1).color);
}

#[test]
fn it_stops_within_50_ms() {
    let settings = PathTrace { samples: 1 << 20, environment: WHITE, ..PathTrace::default() };
    let stage = stage(cube(16), homogeneous(0.99), |scene| {
        scene.technique = Technique::PathTrace(settings);
        scene.volumes[0].scattering = scattering(Phase::Isotropic, 1.0);
        (scene.image.width, scene.image.height) = (256, 256);
    });
    let stops_after = || {
        let cancel = Cancel::default();
        let asked = std::thread::scope(|scope| {
            let asked = scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(100));
                cancel.cancel();
                Instant::now()
            });
            let control = Control { cancel: Some(&cancel), ..Control::default() };
            assert_eq!(CpuRenderer::new().render(&stage, &control).unwrap_err(), RenderError::Cancelled);
            asked.join().unwrap()
        });
        asked.elapsed()
    };
    // The best of some, as a busy machine may have other things to do.
    let shortest = (0..5).map(|_| stops_after()).min().unwrap();
    assert!(shortest < Duration::from_millis(50), "{shortest:?}");
}

#[test]
fn a_lens_blurs_what_is_not_in_focus() {
    // A plate across half of the view, in focus or far from it.
    let plate = || unit_volume([17; 3], |p| if p.y > 5.5 && p.y < 10.5 && p.x < 8.5 { 1.0 } else { 0.0 });
    let edge = |focus: f64, aperture: f64| {
        let settings = PathTrace { samples: 256, bounces: 0, aperture, focus: Some(focus), ..PathTrace::default() };
        let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (1.0, 0.99)]);
        let (_, frame) = traced(plate(), 0.0, settings, |scene| {
            scene.volumes[0].transfer_function = Some(tf);
        });
        // How many pixels of a row in the middle are neither covered nor free.
        (0..16).filter(|x| (0.1..0.9).contains(&frame.color[8 * 16 + x][3])).count()
    };
    let stage = stage(plate(), homogeneous(0.5), |_| {});
    let distance = 8.0 - stage.viewpoint.eye.y;
    let [sharp, focused, blurred] = [edge(distance, 0.0), edge(distance, 2.0), edge(distance + 12.0, 6.0)];
    assert!(focused <= sharp + 1 && blurred >= focused + 3, "{sharp}, {focused} and {blurred} pixels");
}

#[test]
fn few_paths_without_noise_are_nearer_to_many() {
    // A cloud, and a surface under area lights; the sky's sun makes some paths far brighter than others.
    let drawn = |surface: SurfaceShare, samples, denoise| {
        let settings = PathTrace { samples, denoise, environment: WHITE, ..PathTrace::default() };
        traced(blobs(24), 0.0, settings, |scene| {
            let opacities = [(0.0, 0.0), (0.1, 0.0), (1.0, 0.9)];
            scene.volumes[0].transfer_function = Some(transfer_function(&[(0.0, 0xc08040)], &opacities));
            scene.volumes[0].shading = Some(true);
            scene.volumes[0].material = Some(Material::default());
            scene.volumes[0].scattering = Scattering { surface, ..scattering(Phase::Isotropic, 0.8) };
            scene.lighting.lights = vec![Light { radius: 20.0, ..directional([1.0, 0.5, -0.5]) }];
            (scene.image.width, scene.image.height) = (64, 64);
        })
        .1
    };
    let gradient = pellucid_optics::GradientWeight { low: 0.0, high: 0.05 };
    for (surface, factor) in [(SurfaceShare::None, 1.8), (SurfaceShare::Gradient(gradient), 1.3)] {
        let truth = drawn(surface.clone(), 1024, false);
        let rmse = |frame: &Frame| {
            let squares = frame.color.iter().zip(&truth.color);
            let channel = |a: &[f32; 4], b: &[f32; 4]| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
            (squares.map(|(a, b)| channel(a, b)).sum::<f64>() / (3 * truth.color.len()) as f64).sqrt()
        };
        let (noisy, smooth) = (drawn(surface.clone(), 16, false), drawn(surface, 16, true));
        assert!(rmse(&smooth) * factor < rmse(&noisy), "{} to {}", rmse(&noisy), rmse(&smooth));
        let sum = |frame: &Frame| frame.color.iter().map(|c| f64::from(c[1])).sum::<f64>();
        // No light comes or goes.
        assert!((sum(&smooth) / sum(&noisy) - 1.0).abs() < 1e-5, "{} and {}", sum(&noisy), sum(&smooth));
        // Nothing else is touched.
        assert_eq!((&smooth.noise, &smooth.depth, &smooth.samples), (&noisy.noise, &noisy.depth, &noisy.samples));
    }
}

#[test]
fn every_colour_has_its_own_extinction() {
    let opacity = 0.2f32;
    let kappa = -f64::from(1.0 - opacity).ln();
    let color = Color::hex(0xffbc80);
    let factors = color.to_linear(pellucid_optics::ColorSpace::Srgb).map(f64::from);
    // Light that is emitted evenly all along a depth of 8 is what each colour absorbs of it: 1 - e^(-tau).
    let glow = Material { emission: 1.0, ambient: 0.0, diffuse: 0.0, specular: 0.0, ..Material::default() };
    let drawn = |extinction_color, settings: PathTrace, light: Option<Light>| {
        traced(cube(8), opacity, settings, |scene| {
            scene.volumes[0].shading = Some(light.is_none());
            scene.volumes[0].material = Some(glow);
            scene.volumes[0].scattering = Scattering { extinction_color, ..scattering(Phase::Isotropic, 0.8) };
            scene.lighting.lights.extend(light);
        })
        .1
    };
    let settings = PathTrace { samples: 1024, bounces: 0, ..PathTrace::default() };
    let through = factors.map(|factor| (-kappa * factor * 8.0).exp());
    let frame = middle(&drawn(Some(color), settings.clone(), None));
    for channel in 0..3 {
        agrees(mean(&frame, |c| f64::from(c[channel])), 1.0 - through[channel], &format!("channel {channel}"));
    }
    agrees(mean(&frame, |c| f64::from(c[3])), 1.0 - through.iter().sum::<f64>() / 3.0, "coverage");
    // Scattered once towards the eye, from a light behind: kappa L e^(-kappa L) of albedo / 4, in each colour.
    let single = PathTrace { samples: 2048, bounces: 1, ..PathTrace::default() };
    let frame = middle(&drawn(Some(color), single, Some(directional([0.0, -1.0, 0.0]))));
    for channel in 0..3 {
        let depth = kappa * factors[channel] * 8.0;
        let expected = 0.8 / 4.0 * depth * (-depth).exp();
        agrees(mean(&frame, |c| f64::from(c[channel])), expected, &format!("scattered, channel {channel}"));
    }
    // Whatever all colours have alike is the extinction itself: with every scattering, and a light with a size.
    let settings = PathTrace { samples: 256, environment: WHITE, ..PathTrace::default() };
    let lamp = Light { radius: 30.0, ..directional([1.0, 0.5, 0.0]) };
    let [plain, white] = [None, Some(Color::WHITE)].map(|color| drawn(color, settings.clone(), Some(lamp)));
    agree(&plain, &white, "white");
    // In even light, what only scatters is not seen in any colour.
    let (_, furnace) = traced(cube(8), opacity, settings, |scene| {
        scene.volumes[0].scattering =
            Scattering { extinction_color: Some(color), ..scattering(Phase::HenyeyGreenstein { g: 0.5 }, 1.0) };
    });
    let furnace = middle(&furnace);
    for channel in 0..3 {
        let seen = mean(&furnace, |c| f64::from(c[channel]));
        agrees(seen, 1.0 - through[channel], &format!("furnace, channel {channel}"));
    }
}

#[test]
fn a_firefly_clamp_takes_what_it_says_and_nothing_else() {
    let settings = |clamp| PathTrace { samples: 256, bounces: 1, firefly_clamp: clamp, ..PathTrace::default() };
    let sunny = |clamp| {
        traced(cube(8), 0.1, settings(clamp), |scene| {
            scene.volumes[0].scattering = scattering(Phase::Isotropic, 1.0);
            scene.lighting.lights = vec![directional([0.0, 1.0, 0.0])];
        })
        .1
    };
    let light = |frame: &Frame| frame.color.iter().map(|c| f64::from(luminance([c[0], c[1], c[2]]))).sum::<f64>();
    let free = sunny(0.0);
    assert!(light(&free) > 0.0 && free.warnings.is_empty(), "{:?}", free.warnings);
    // No path is as bright as a thousand whites: the picture is the same to the bit.
    let high = sunny(1000.0);
    assert_eq!(high.color, free.color);
    assert!(high.warnings.is_empty());
    // All are brighter than a clamp next to nothing: every one that brings light brings just that much.
    let low = sunny(1e-4);
    let share = |frame: &Frame| {
        let warning = frame.warnings.iter().map(ToString::to_string).find(|said| said.contains("firefly"));
        warning.unwrap().split_whitespace().nth(5).unwrap().parse::<f64>().unwrap()
    };
    let said = share(&low);
    let held_back = 100.0 * (1.0 - light(&low) / light(&free));
    assert!((said - held_back).abs() < 0.01, "said {said} %, held back {held_back} %");
    assert!(low.color.iter().all(|c| luminance([c[0], c[1], c[2]]) <= 1.00001e-4), "no pixel is beyond it");
    assert!(low.color.iter().zip(&free.color).all(|(low, free)| low[3] == free[3]), "coverage stays");
    // In the white furnace a path brings 1, and a clamp above that changes nothing.
    let furnace = |clamp| {
        let settings = PathTrace { samples: 64, environment: WHITE, firefly_clamp: clamp, ..PathTrace::default() };
        traced(cube(8), 0.3, settings, |scene| {
            scene.volumes[0].scattering = scattering(Phase::HenyeyGreenstein { g: 0.8 }, 1.0);
        })
        .1
    };
    // What a path through the furnace brings is 1 in the mean: none of it is lost above what any path brings, and
    // below that the loss is told.
    assert_eq!(furnace(1000.0).color, furnace(0.0).color);
    let (whole, half) = (furnace(0.0), furnace(0.5));
    assert!(half.color.iter().all(|c| luminance([c[0], c[1], c[2]]) <= 0.50001 * c[3]), "no path brings more than 0.5");
    let said = share(&half);
    let held_back = 100.0 * (1.0 - light(&half) / light(&whole));
    assert!((said - held_back).abs() < 0.01, "said {said} %, held back {held_back} %");
}
