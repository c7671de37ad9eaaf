//! Light that is saved is drawn with as if it had just been found, and with nothing else (G-09).

use std::sync::Arc;

use crate::common::{render, unit_volume};
use crate::illumination::{bowl, from_above, lit};
use glam::DVec3;
use pellucid_cpu::{CpuRenderer, RenderError, SavedLightError};
use pellucid_field::{Gradient, Grid, Volume, Voxels};
use pellucid_optics::{Color, Environment, SkyImage, SkyMap, SkySource};
use pellucid_scene::{
    Control, GlobalIllumination, HarmonicTransfer, Held, IlluminationBasis, IlluminationInterpolation,
    IlluminationMethod, Isovalue, Mode, PlacesOn, Scene, Stage, View,
};

fn gray() -> Environment {
    Environment::Gradient { top: Color::WHITE, bottom: Color::BLACK, intensity: 1.0 }
}

/// A thick hollow ball.
fn shell() -> Volume {
    unit_volume([32; 3], |p| 4.0 - ((p - DVec3::splat(15.5)).length() - 9.0).abs())
}

/// Two surfaces of it, both sides of which are seen.
fn through(global: GlobalIllumination, edit: impl FnOnce(&mut Scene)) -> Stage {
    lit(shell(), (0.0, 0xcccccc), global, |scene| {
        from_above(scene);
        if let Some(Mode::Isosurface(surfaces)) = scene.technique.mode_mut() {
            surfaces.isovalues[0].opacity = 0.5;
            let other = Isovalue { value: 1.25, ..surfaces.isovalues[0].clone() };
            surfaces.isovalues.push(other);
        }
        edit(scene);
    })
}

fn baked(stage: &Stage) -> Volume {
    let mut renderer = CpuRenderer::new();
    renderer.bake(stage, &Control::default()).unwrap();
    renderer.baked_light().unwrap().unwrap()
}

fn from_elsewhere(scene: &mut Scene) {
    if let View::Orbit(orbit) = &mut scene.camera.view {
        (orbit.elevation, orbit.azimuth) = (50.0, 130.0);
    }
}

fn with(global: &GlobalIllumination, light: Volume) -> GlobalIllumination {
    GlobalIllumination { baked: Held(Some(Arc::new(light))), ..global.clone() }
}

#[test]
fn saved_light_draws_the_same_picture_to_the_bit() {
    let harmonics = |bands| IlluminationBasis::Harmonics(HarmonicTransfer { bands, ..Default::default() });
    for (surfaces, basis, sides) in [
        (PlacesOn::Own, IlluminationBasis::Irradiance, 2),
        (PlacesOn::Drawn, IlluminationBasis::Irradiance, 4),
        (PlacesOn::Own, harmonics(2), 2 * 4),
        (PlacesOn::Drawn, harmonics(1), 4),
    ] {
        let global = GlobalIllumination { surfaces, basis, environment: gray(), samples: 4, ..Default::default() };
        let light = baked(&through(global.clone(), |_| {}));
        assert_eq!((light.grid().dims(), light.components()), ([32, 32, 32 * sides], 4), "{surfaces:?}, {basis:?}");
        let expected = render(&through(global.clone(), from_elsewhere));
        let mut renderer = CpuRenderer::new();
        let stage = through(with(&global, light.clone()), from_elsewhere);
        let drawn = renderer.render(&stage, &Control::default()).unwrap();
        assert!(drawn.color == expected.color, "{surfaces:?}, {basis:?}");
        // It is the light that was saved, and all of it.
        let again = renderer.baked_light().unwrap().unwrap();
        assert_eq!(again.description, light.description);
        assert!(again.voxels().as_bytes() == light.voxels().as_bytes(), "{surfaces:?}, {basis:?}");
        let Voxels::F32(values) = light.voxels() else { panic!("{:?}", light.voxels()) };
        let dimmed: Vec<f32> = values.chunks(4).flat_map(|v| [v[0] / 2.0, v[1] / 2.0, v[2] / 2.0, v[3]]).collect();
        let mut dark = Volume::with_components(*light.grid(), dimmed, 4).unwrap();
        dark.description.clone_from(&light.description);
        assert!(
            render(&through(with(&global, dark), from_elsewhere)).color != expected.color,
            "{surfaces:?}, {basis:?}"
        );
        // What a picture has found is less, and the rest is found anew.
        let mut renderer = CpuRenderer::new();
        renderer.render(&through(global.clone(), |_| {}), &Control::default()).unwrap();
        let part = renderer.baked_light().unwrap().unwrap();
        assert!(part.voxels().as_bytes() != light.voxels().as_bytes(), "{surfaces:?}, {basis:?}");
        assert!(
            render(&through(with(&global, part), from_elsewhere)).color == expected.color,
            "{surfaces:?}, {basis:?}"
        );
    }
}

#[test]
fn a_voxel_of_saved_light_is_a_place() {
    let global = GlobalIllumination { samples: 4, resolution: 0.5, ..Default::default() };
    let stage = lit(bowl(), (0.0, 0xcccccc), global, from_above);
    let light = baked(&stage);
    assert!(light.description.as_deref().unwrap().ends_with(": 0 below"), "{:?}", light.description);
    let (places, voxels) = (light.grid(), stage.volumes[0].volume.grid());
    assert_eq!(places.dims(), [21, 21, 13]);
    for (place, voxel) in places.world_corners().into_iter().zip(voxels.world_corners()) {
        assert!((place - voxel).length() < 1e-4, "{place}, {voxel}");
    }
    let numbers = |place| [0, 1, 2, 3].map(|component| light.value(place, component));
    // At the bottom of the bowl, within its wall, and far from it.
    let [r, g, b, known] = numbers([10, 10, 2]);
    // All that its four paths have found.
    assert!(known == 4.0 && r > 0.8 && r == g && g == b && r < 4.0, "{:?}", numbers([10, 10, 2]));
    assert_eq!(numbers([10, 10, 12]), [0.0; 4]);
}

/// A change of a scene, by name.
type Change<'a> = (&'a str, &'a dyn Fn(&mut Scene));

#[test]
fn light_of_other_data_and_settings_is_refused_and_of_other_views_is_not() {
    let sky = |brightness: f32| {
        let map = SkyMap::new(2, 1, vec![[1.0; 3], [brightness; 3]]).unwrap();
        let source = SkySource::File("sky.exr".into());
        Environment::Image(SkyImage { source, rotation: 0.0, intensity: 1.0, map: Some(Arc::new(map)) })
    };
    let global = GlobalIllumination { environment: sky(0.5), samples: 4, bounces: 1, ..Default::default() };
    let light = baked(&through(global.clone(), |_| {}));
    let draw = |global: &GlobalIllumination, edit: &dyn Fn(&mut Scene)| {
        let global = GlobalIllumination { file: Some("a/light.nrrd".into()), ..with(global, light.clone()) };
        CpuRenderer::new().render(&through(global, edit), &Control::default()).map(drop)
    };
    let refused = |drawn: Result<(), RenderError>, what: &str| match drawn {
        Err(RenderError::SavedLight(error @ SavedLightError::Other { .. })) => {
            let text = error.to_string();
            assert!(text.starts_with("a/light.nrrd: ") && text.contains("bake it again"), "{text}");
        }
        other => panic!("{what}: {other:?}"),
    };
    assert_eq!(draw(&global, &|_| {}), Ok(()));
    let accepted: [Change; 5] = [
        ("camera", &from_elsewhere),
        ("step", &|scene| scene.quality.step = 0.25),
        ("supersampling", &|scene| scene.quality.supersampling = 2),
        ("gradient", &|scene| scene.quality.gradient = Gradient::Sobel),
        ("opacity", &|scene| {
            if let Some(Mode::Isosurface(surfaces)) = scene.technique.mode_mut() {
                surfaces.isovalues[1].opacity = 1.0;
            }
        }),
    ];
    for (what, edit) in accepted {
        assert_eq!(draw(&global, edit), Ok(()), "{what}");
    }
    assert_eq!(
        draw(&GlobalIllumination { interpolation: IlluminationInterpolation::Cubic, ..global.clone() }, &|_| {}),
        Ok(())
    );
    // Nothing is read where no place keeps any light.
    assert_eq!(draw(&GlobalIllumination { method: IlluminationMethod::Pixels, ..global.clone() }, &|_| {}), Ok(()));
    let others: [Change; 3] = [
        ("isovalue", &|scene| {
            if let Some(Mode::Isosurface(surfaces)) = scene.technique.mode_mut() {
                surfaces.isovalues[1].value = 1.5;
            }
        }),
        ("clip", &|scene| {
            scene.clips.push(pellucid_scene::Clip::Plane { point: [3.0; 3], normal: [1.0, 0.0, 0.0] });
        }),
        ("light", &|scene| scene.lighting.lights.push(crate::common::paths::directional([0.0, 0.0, -1.0]))),
    ];
    for (what, edit) in others {
        refused(draw(&global, edit), what);
    }
    refused(draw(&GlobalIllumination { environment: sky(0.25), ..global.clone() }, &|_| {}), "sky");
    refused(draw(&GlobalIllumination { samples: 5, ..global.clone() }, &|_| {}), "samples");
    refused(draw(&GlobalIllumination { distance: Some(5.0), ..global.clone() }, &|_| {}), "distance");
    // One voxel of another value, which is nowhere near what is seen.
    let Voxels::F32(values) = shell().voxels().clone() else { panic!("{:?}", shell().voxels()) };
    let mut values = values.to_vec();
    values[0] -= 1.0;
    let other = |grid: Grid, values: Vec<f32>| {
        let global = GlobalIllumination { file: Some("a/light.nrrd".into()), ..with(&global, light.clone()) };
        let mut stage = through(global, |_| {});
        stage.volumes[0].volume = Arc::new(Volume::new(grid, values).unwrap());
        CpuRenderer::new().render(&stage, &Control::default()).map(drop)
    };
    let Voxels::F32(same) = shell().voxels().clone() else { panic!("{:?}", shell().voxels()) };
    assert_eq!(other(*shell().grid(), same.to_vec()), Ok(()));
    refused(other(*shell().grid(), values), "voxels");
    refused(other(Grid::with_spacing([32; 3], [1.0, 1.0, 1.5], [0.0; 3]).unwrap(), same.to_vec()), "spacing");
}

#[test]
fn isovalues_move_over_light_that_each_place_has_on_its_own() {
    let global = GlobalIllumination { surfaces: PlacesOn::Own, samples: 4, ..Default::default() };
    let uncolored = |global: GlobalIllumination, value: f64| {
        lit(bowl(), (value, 0xcccccc), global, |scene| {
            from_above(scene);
            if let Some(Mode::Isosurface(surfaces)) = scene.technique.mode_mut() {
                surfaces.isovalues[0].color = None;
            }
        })
    };
    let light = baked(&uncolored(global.clone(), 0.0));
    assert!(light.description.as_deref().unwrap().ends_with(": own below"), "{:?}", light.description);
    for value in [0.0, 0.75] {
        let drawn = render(&uncolored(with(&global, light.clone()), value));
        assert!(drawn.color == render(&uncolored(global.clone(), value)).color, "{value}");
    }
}

#[test]
fn what_is_no_light_is_refused() {
    let global =
        GlobalIllumination { samples: 1, bounces: 0, file: Some("light.nrrd".into()), ..GlobalIllumination::default() };
    let draw = |baked: Held| {
        let stage = through(GlobalIllumination { baked, ..global.clone() }, |_| {});
        CpuRenderer::new().render(&stage, &Control::default()).map(drop)
    };
    let unread = SavedLightError::Unread { file: "light.nrrd".into() };
    assert_eq!(draw(Held(None)), Err(unread.into()));
    let light = baked(&through(GlobalIllumination { file: None, ..global.clone() }, |_| {}));
    let grid = Grid::new([2, 2, 2]).unwrap();
    let small = Volume::with_components(grid, vec![0.0f32; 32], 4).unwrap();
    let bytes = Volume::with_components(*light.grid(), vec![0u8; light.grid().len() * 4], 4).unwrap();
    let own = light.description.as_deref().unwrap();
    let cases = [
        (small.clone(), None, "no description"),
        (small.clone(), Some("a head"), "'a head'"),
        (small, Some(own), "4 f32 at [2, 2, 2] voxels"),
        (bytes, Some(own), "4 u8 at"),
        (light.clone(), Some(&*own.replacen("1.25", "1.5", 1)), "a surface at Some(1.5)"),
    ];
    for (mut volume, description, found) in cases {
        volume.description = description.map(str::to_owned);
        match draw(Held(Some(Arc::new(volume)))) {
            Err(RenderError::SavedLight(error @ SavedLightError::Foreign { .. })) => {
                let text = error.to_string();
                assert!(text.starts_with("light.nrrd: ") && text.contains(found), "{text}");
            }
            other => panic!("{found}: {other:?}"),
        }
    }
    // Where nothing is seen, nothing is kept.
    let unseen = through(GlobalIllumination { file: None, ..global.clone() }, |scene| {
        scene.clips.push(pellucid_scene::Clip::Plane { point: [999.0; 3], normal: [1.0, 0.0, 0.0] });
    });
    let mut renderer = CpuRenderer::new();
    assert!(renderer.baked_light().unwrap().is_none());
    assert_eq!(renderer.bake(&unseen, &Control::default()).unwrap().places, 0);
    assert!(renderer.baked_light().unwrap().is_none());
}
