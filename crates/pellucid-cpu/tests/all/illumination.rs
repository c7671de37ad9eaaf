//! All light that arrives at isosurfaces, against closed forms (G-06, G-07, G-15 to G-19).

use std::sync::Arc;

use crate::common::paths::directional;
use crate::common::{homogeneous, render, set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_cpu::{CpuRenderer, InstructionSet};
use pellucid_field::Volume;
use pellucid_optics::{
    Bands, Color, ColorSpace, Environment, Harmonics, Material, Shadows, SkyImage, SkyMap, SkySource,
};
use pellucid_scene::{
    Control, Frame, GlobalIllumination, HarmonicTransfer, Illumination, IlluminationBasis, IlluminationInterpolation,
    IlluminationMethod, Isosurface, Isovalue, Mode, PlacesOn, Scene, Stage, SurfaceNormals,
};

const METHODS: [IlluminationMethod; 2] = [IlluminationMethod::Lattice, IlluminationMethod::Pixels];

/// A surface of a volume, white unless it is said otherwise.
pub fn lit(
    volume: Volume,
    (level, color): (f64, u32),
    global: GlobalIllumination,
    edit: impl FnOnce(&mut Scene),
) -> Stage {
    stage(volume, homogeneous(1.0), |scene| {
        let iso = Isovalue { value: level, color: Some(Color::hex(color)), opacity: 1.0, volume: None };
        let illumination = Illumination::Global(global);
        set_mode(scene, Mode::Isosurface(Isosurface { illumination, ..Isosurface::new(vec![iso]) }));
        scene.volumes[0].shading = Some(true);
        scene.lighting.lights.clear();
        edit(scene);
    })
}

const MIDDLE: DVec3 = DVec3::splat(15.5);

/// Positive within a ball of radius 10.
fn ball(sign: f64) -> Volume {
    unit_volume([32; 3], |p| sign * (10.0 - (p - MIDDLE).length()))
}

/// The colours of pixels that meet a surface, with its position.
fn met<'a>(stage: &'a Stage, frame: &'a Frame) -> impl Iterator<Item = (DVec3, [f32; 3])> {
    let hits = frame.depth.iter().zip(&frame.color).enumerate().filter(|(_, (depth, _))| depth.is_finite());
    hits.map(|(pixel, (depth, color))| {
        let ray = stage.viewpoint.ray((pixel % 16) as f64 + 0.5, (pixel / 16) as f64 + 0.5);
        (ray.at(f64::from(*depth)), [color[0], color[1], color[2]])
    })
}

#[test]
fn a_ball_under_a_white_sky_is_white() {
    for method in METHODS {
        for normals in [SurfaceNormals::Derivative, SurfaceNormals::Differences, SurfaceNormals::Data] {
            for sign in [1.0, -1.0] {
                let global = GlobalIllumination { method, normals, samples: 16, ..Default::default() };
                let stage = lit(ball(sign), (0.0, 0xffffff), global, |_| {});
                let frame = render(&stage);
                let mut hits = 0;
                for (_, color) in met(&stage, &frame) {
                    assert!(color.iter().all(|v| (v - 1.0).abs() < 1e-5), "{method:?}, {normals:?}: {color:?}");
                    hits += 1;
                }
                assert!(hits > 60, "{hits}");
            }
        }
    }
}

fn half_bright() -> Environment {
    let map = SkyMap::new(4, 2, [[1.0; 3]; 4].into_iter().chain([[0.0; 3]; 4]).collect()).unwrap();
    let source = SkySource::File("nowhere".into());
    Environment::Image(SkyImage { source, rotation: 0.0, intensity: 1.0, map: Some(Arc::new(map)) })
}

#[test]
fn a_ball_shows_how_much_of_a_sky_each_place_sees() {
    let gradient = Environment::Gradient { top: Color::WHITE, bottom: Color::BLACK, intensity: 1.0 };
    // Of a sky that is even in the height, and of one that is bright above and dark below (E = pi (1 + cos a) / 2).
    for (environment, slope) in [(gradient, 1.0 / 3.0), (half_bright(), 0.5)] {
        let expected = |cosine: f64| 0.5 + slope * cosine;
        for method in METHODS {
            let (environment, samples) = (environment.clone(), 1024);
            let global = GlobalIllumination { method, environment, samples, ..Default::default() };
            let stage = lit(ball(1.0), (0.0, 0xffffff), global, |_| {});
            let frame = render(&stage);
            for (at, color) in met(&stage, &frame) {
                let expected = expected((at - MIDDLE).normalize().z);
                assert!(
                    (f64::from(color[0]) - expected).abs() < 0.012,
                    "{method:?} at {at}: {color:?}, not {expected}"
                );
            }
        }
    }
}

/// A block with a hemispherical hollow that is open above.
pub fn bowl() -> Volume {
    unit_volume([40, 40, 24], |p| ((p - DVec3::new(19.5, 19.5, 20.0)).length() - 16.0).min(20.0 - p.z))
}

pub fn from_above(scene: &mut Scene) {
    if let pellucid_scene::View::Orbit(orbit) = &mut scene.camera.view {
        orbit.elevation = 90.0;
    }
}

/// Light that goes to and fro in a bowl: `(1 - f) / (1 - rho f)`, wherever in it, where f is the share of the ball that is
/// there (G-07).
#[test]
fn a_bowl_is_as_bright_everywhere_as_its_own_light_makes_it() {
    let gray = 0xcccccc;
    let albedo = f64::from(Color::hex(gray).to_linear(ColorSpace::Srgb)[0]);
    let expected = |bounces: i32| (0..=bounces).map(|n| 0.5 * (0.5 * albedo).powi(n)).sum::<f64>();
    assert!((expected(64) - 0.5 / (1.0 - 0.5 * albedo)).abs() < 1e-9);
    for (method, bounces) in
        [(METHODS[1], 0), (METHODS[1], 1), (METHODS[1], 64), (METHODS[0], 0), (METHODS[0], 1), (METHODS[0], 64)]
    {
        // Half a voxel off the wall more of the sky is seen.
        let global = GlobalIllumination { method, bounces, samples: 256, offset: 0.1, ..Default::default() };
        // A clip has a sharp rim, which a grid has not.
        let ball = unit_volume([32; 3], |p| (p - MIDDLE).length() - 14.0);
        let stage = lit(ball, (0.0, gray), global, |scene| {
            from_above(scene);
            scene.clips.push(pellucid_scene::Clip::Plane { point: MIDDLE.to_array(), normal: [0.0, 0.0, -1.0] });
        });
        let frame = render(&stage);
        let (mut sum, mut count, expected) = (0.0, 0.0, albedo * expected(bounces as i32));
        for (at, color) in met(&stage, &frame) {
            if at.z < 13.0 {
                let off = f64::from(color[0]) - expected;
                assert!(off.abs() < 0.035, "{method:?}, {bounces} bounces, at {at}: {color:?}, not {expected}");
                sum += off;
                count += 1.0;
            }
        }
        assert!(count > 40.0 && f64::abs(sum / count) < 0.004, "{method:?}, {bounces} bounces: off by {}", sum / count);
    }
}

/// The same hollow as half of a hollow ball, whose other half a clip takes away, for the eye and for light.
#[test]
fn clips_let_light_in() {
    let shell = || unit_volume([32; 3], |p| (p - MIDDLE).length() - 10.0);
    let lit = |distance, clipped| {
        let global = GlobalIllumination { samples: 256, bounces: 0, distance, ..Default::default() };
        lit(shell(), (0.0, 0xffffff), global, |scene| {
            if clipped {
                let clip = pellucid_scene::Clip::Plane { point: MIDDLE.to_array(), normal: [0.0, 1.0, 0.0] };
                scene.clips.push(clip);
            } else {
                let look = pellucid_scene::LookAt {
                    position: [15.5, 12.0, 15.5],
                    target: [15.5, 20.0, 15.5],
                    up: [0.0, 0.0, 1.0],
                };
                scene.camera.view = pellucid_scene::View::LookAt(look);
                scene.camera.projection = pellucid_scene::Projection::Perspective { vertical_fov: 60.0 };
            }
        })
    };
    // Without a clip it is dark in there, but for light that nothing near holds back.
    for (distance, clipped, expected) in [(None, true, 0.5), (None, false, 0.0), (Some(0.5), false, 1.0)] {
        let stage = lit(distance, clipped);
        let frame = render(&stage);
        let mut hits = 0;
        for (at, color) in met(&stage, &frame).filter(|(at, _)| at.y > 18.0) {
            assert!((color[0] - expected).abs() < 0.04, "{distance:?}, {clipped} at {at}: {color:?}");
            hits += 1;
        }
        assert!(hits > 30, "{hits}");
    }
}

/// Without shadows nor light from elsewhere there is Lambert's law, and with shadows what shadow rays find (G-18).
#[test]
fn lights_light_as_they_do_by_themselves() {
    let sculpture = || {
        unit_volume([32; 3], |p| {
            let knob = 4.0 - (p - MIDDLE - DVec3::new(6.0, -6.0, 5.0)).length();
            f64::max(10.0 - (p - MIDDLE).length(), knob)
        })
    };
    let matte = Material { ambient: 0.0, diffuse: 1.0, specular: 0.0, ..Material::default() };
    for shadows in [false, true] {
        let method = IlluminationMethod::Pixels;
        let (environment, normals) = (Environment::Dark, SurfaceNormals::Data);
        let global = GlobalIllumination {
            method,
            environment,
            normals,
            shadows,
            bounces: 0,
            samples: 64,
            offset: 2.0,
            ..Default::default()
        };
        let edit = |scene: &mut Scene| {
            scene.lighting.lights = vec![directional([-1.0, 1.0, -0.8]), directional([0.2, 1.0, 0.3])];
            scene.lighting.ambient = 0.0;
            scene.lighting.shadows = if shadows { Shadows::Rays(Default::default()) } else { Shadows::None };
            scene.volumes[0].material = Some(matte);
        };
        let by_paths = render(&lit(sculpture(), (0.0, 0xffffff), global, edit));
        let by_lights = render(&stage(sculpture(), homogeneous(1.0), |scene| {
            let iso = Isovalue { value: 0.0, color: Some(Color::WHITE), opacity: 1.0, volume: None };
            set_mode(scene, Mode::Isosurface(Isosurface::new(vec![iso])));
            scene.volumes[0].shading = Some(true);
            edit(scene);
        }));
        let off = |(a, b): (&[f32; 4], &[f32; 4])| (a[0] - b[0]).abs();
        let offs: Vec<f32> = by_paths.color.iter().zip(&by_lights.color).map(off).collect();
        let differ = offs.iter().filter(|off| **off > 1e-4).count();
        // Shadow rays begin elsewhere at the edges of shadows.
        assert!(differ <= if shadows { 6 } else { 0 }, "shadows {shadows}: {differ} pixels, {offs:?}");
    }
}

/// Light belongs to places: what was seen before, from where, at which isovalue and by how many threads, changes no bit.
#[test]
fn light_does_not_depend_on_what_was_seen_before() {
    let prepared = |surfaces: PlacesOn, (level, azimuth, sky, clip): (f64, f64, u32, f64)| {
        let environment = Environment::Gradient { top: Color::hex(sky), bottom: Color::BLACK, intensity: 1.0 };
        let global = GlobalIllumination { environment, surfaces, samples: 8, ..Default::default() };
        lit(bowl(), (level, 0xffffff), global, |scene| {
            if let pellucid_scene::View::Orbit(orbit) = &mut scene.camera.view {
                (orbit.elevation, orbit.azimuth) = (70.0, azimuth);
            }
            scene.clips.push(pellucid_scene::Clip::Plane { point: [clip, 0.0, 0.0], normal: [1.0, 0.0, 0.0] });
        })
    };
    let cases = [
        (0.0, 0.0, 0xffffff, -1.0),
        (0.0, 40.0, 0xffffff, -1.0),
        (0.5, 40.0, 0xffffff, -1.0),
        (0.5, 40.0, 0xff8080, -1.0),
        (0.5, 40.0, 0xff8080, 10.0),
        (0.0, 0.0, 0xffffff, -1.0),
    ];
    for surfaces in [PlacesOn::Own, PlacesOn::Drawn] {
        let mut kept = CpuRenderer::with_threads(2).unwrap();
        let mut last = Vec::new();
        for case in cases {
            let stage = prepared(surfaces, case);
            let again = kept.render(&stage, &Control::default()).unwrap();
            let fresh =
                CpuRenderer::with_threads(1).unwrap().with_tile_size(8).render(&stage, &Control::default()).unwrap();
            assert!(again.color == fresh.color, "{surfaces:?}, {case:?}");
            assert!(again.color != last, "{surfaces:?}, {case:?}: as the last one");
            last = again.color;
        }
    }
}

/// A finer lattice, and more paths, are nearer to light that is followed at every place (G-15, G-16).
#[test]
fn finer_lattices_are_nearer_to_light_at_every_place() {
    let sky = Environment::Gradient { top: Color::WHITE, bottom: Color::BLACK, intensity: 1.0 };
    let drawn = |global: GlobalIllumination| {
        let global = GlobalIllumination {
            environment: sky.clone(),
            surfaces: PlacesOn::Own,
            samples: 256,
            bounces: 1,
            ..global
        };
        let stage = lit(bowl(), (0.0, 0xcccccc), global, from_above);
        let frame = render(&stage);
        met(&stage, &frame).map(|(_, color)| color[0]).collect::<Vec<_>>()
    };
    let truth = drawn(GlobalIllumination { method: IlluminationMethod::Pixels, ..Default::default() });
    let error = |resolution: f64, interpolation: IlluminationInterpolation| {
        let found = drawn(GlobalIllumination { resolution, interpolation, ..Default::default() });
        let squares = found.iter().zip(&truth).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
        (squares / truth.len() as f64).sqrt()
    };
    let by_resolution = [0.25, 0.5, 1.0].map(|resolution| error(resolution, IlluminationInterpolation::Linear));
    assert!(by_resolution[1] < by_resolution[0] && by_resolution[2] < 0.7 * by_resolution[1], "{by_resolution:?}");
    for interpolation in [IlluminationInterpolation::Nearest, IlluminationInterpolation::NearestIsovalue] {
        let nearest = error(1.0, interpolation);
        assert!(nearest > by_resolution[2] && nearest < 0.1, "{interpolation:?}: {nearest}, linear {by_resolution:?}");
    }
    let cubic = error(1.0, IlluminationInterpolation::Cubic);
    assert!(cubic < 0.05, "{cubic}");
}

/// Roughness of sampled data holds light back, unless paths start off the surface (G-06).
#[test]
fn paths_start_off_rough_surfaces() {
    let rough = || {
        let noise = |p: DVec3| ((p.x * 12.9898 + p.y * 78.233 + p.z * 37.719).sin() * 43_758.547).fract() - 0.5;
        unit_volume([32; 3], |p| 10.0 - (p - MIDDLE).length() + 0.4 * noise(p))
    };
    let mean = |offset: f64| {
        let method = IlluminationMethod::Pixels;
        let global = GlobalIllumination { method, offset, samples: 64, bounces: 0, ..Default::default() };
        let stage = lit(rough(), (0.0, 0xffffff), global, |_| {});
        let frame = render(&stage);
        let colors: Vec<f32> = met(&stage, &frame).map(|(_, color)| color[0]).collect();
        colors.iter().sum::<f32>() / colors.len() as f32
    };
    let means = [0.0, 0.5, 2.0].map(mean);
    assert!(means[0] < 0.9 && means[1] > 0.95 && means[2] > 0.995, "{means:?}");
}

#[test]
fn a_surface_without_a_colour_has_the_transfer_functions_for_its_bounces() {
    let tf = transfer_function(&[(-1.0, 0xcccccc), (1.0, 0xcccccc)], &[(0.0, 0.0)]);
    let global = GlobalIllumination { samples: 256, ..Default::default() };
    let own = lit(bowl(), (0.0, 0xcccccc), global.clone(), from_above);
    let by_function = lit(bowl(), (0.0, 0xcccccc), global, |scene| {
        from_above(scene);
        scene.volumes[0].transfer_function = Some(tf);
        if let Some(Mode::Isosurface(surfaces)) = scene.technique.mode_mut() {
            surfaces.isovalues[0].color = None;
        }
    });
    let [own, by_function] = [own, by_function].map(|stage| render(&stage).color);
    assert!(own.iter().zip(&by_function).all(|(a, b)| (a[0] - b[0]).abs() < 1e-6));
}

#[test]
fn instruction_sets_agree() {
    let global = GlobalIllumination { samples: 32, ..Default::default() };
    let stage = lit(bowl(), (0.0, 0xcccccc), global, from_above);
    let drawn = |set: InstructionSet| {
        let renderer = CpuRenderer::new().with_instructions(set).ok()?;
        Some(renderer).map(|mut renderer| renderer.render(&stage, &Control::default()).unwrap().color)
    };
    let baseline = drawn(InstructionSet::Baseline).unwrap();
    for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
        let Some(other) = drawn(set) else { continue };
        // A ray that grazes the surface may meet it or not, by rounding: one path of 32 at a few places.
        let off = |(a, b): (&[f32; 4], &[f32; 4])| f64::from((a[0] - b[0]).abs());
        let offs: Vec<f64> = other.iter().zip(&baseline).map(off).collect();
        let mean = offs.iter().sum::<f64>() / offs.len() as f64;
        assert!(mean < 1e-3 && offs.iter().all(|off| *off < 0.05), "{set:?}: {mean}, {offs:?}");
    }
}

/// Places that are asked for one by one have the light that they have when all are lit at once, bit for bit (G-09).
#[test]
fn all_places_at_once_are_what_they_are_one_by_one() {
    for surfaces in [PlacesOn::Own, PlacesOn::Drawn] {
        let global = GlobalIllumination { surfaces, samples: 4, ..Default::default() };
        let stage = lit(bowl(), (0.0, 0xcccccc), global, from_above);
        let mut renderer = CpuRenderer::new();
        assert_eq!(renderer.bake(&stage, &Control::default()).unwrap().places, 40 * 40 * 24);
        let baked = renderer.render(&stage, &Control::default()).unwrap();
        assert!(baked.color == render(&stage).color, "{surfaces:?}");
    }
}

/// Light in spherical harmonics: of a sky that has few bands it is irradiance but for the noise of paths, a sky that turns is
/// the sky turned, and of an unoccluded place it is what five bands hold (G-10 to G-13).
#[test]
fn harmonics_follow_light_that_turns_and_changes() {
    let harmonics = IlluminationBasis::Harmonics(HarmonicTransfer::default());
    let sky = |top: u32, bottom: u32| Environment::Gradient {
        top: Color::hex(top),
        bottom: Color::hex(bottom),
        intensity: 1.0,
    };
    let day =
        |rotation: f64| Environment::Image(SkyImage { source: SkySource::Day, rotation, intensity: 1.0, map: None });
    let prepared = |basis, environment| {
        let global = GlobalIllumination { basis, environment, samples: 256, bounces: 2, ..Default::default() };
        lit(bowl(), (0.0, 0xcccccc), global, from_above)
    };
    let mut kept = CpuRenderer::new();
    let mut relit =
        |environment: Environment| kept.render(&prepared(harmonics, environment), &Control::default()).unwrap().color;
    let difference = |a: &[[f32; 4]], b: &[[f32; 4]]| {
        let offs = a.iter().zip(b).map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max));
        offs.fold(0.0, f32::max)
    };
    for (top, bottom) in [(0xffffff, 0xffffff), (0xffffff, 0x000000), (0x4060ff, 0xff8020)] {
        let light = render(&prepared(IlluminationBasis::Irradiance, sky(top, bottom))).color;
        let off = difference(&relit(sky(top, bottom)), &light);
        // The same paths: what is left is the rounding of half floats, and bands that a gradient does not have.
        assert!(off < 4e-3, "{top:x} above {bottom:x}: {off}");
    }
    // Turned once more than the last, and from the start.
    relit(day(0.0));
    let turned = relit(day(70.0));
    let fresh = render(&prepared(harmonics, day(70.0))).color;
    assert!(difference(&turned, &fresh) < 1e-6);
    assert!(difference(&turned, &relit(day(0.0))) > 0.02);
    // A sun right above an open ball, by its five bands.
    let global =
        GlobalIllumination { basis: harmonics, environment: Environment::Dark, samples: 4096, ..Default::default() };
    let stage =
        lit(ball(1.0), (0.0, 0xffffff), global, |scene| scene.lighting.lights = vec![directional([0.0, 0.0, -1.0])]);
    let frame = render(&stage);
    let mut sun = Harmonics::dark(Bands::default());
    sun.add(glam::Vec3::Z, [std::f32::consts::PI; 3]);
    for (at, color) in met(&stage, &frame) {
        let expected = sun.irradiance((at - MIDDLE).normalize())[0] / std::f64::consts::PI;
        assert!((f64::from(color[0]) - expected).abs() < 0.01, "at {at}: {color:?}, not {expected}");
    }
}
