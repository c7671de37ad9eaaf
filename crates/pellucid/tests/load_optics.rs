//! Files that the optics of a scene name.

use pellucid::io::{IoError, PngPixels, Transfer, write_exr, write_png};
use pellucid::optics::{Environment, SkyImage, SkySource, srgb_decode};
use pellucid::scene::{PathTrace, SampleSource, Scene, Source, Technique};
use pellucid::{LoadError, load_optics};

fn scene(file: &str) -> Scene {
    let image = SkyImage { source: SkySource::File(file.into()), rotation: 0.0, intensity: 1.0, map: None };
    let ball = SampleSource { name: "ball".into(), dims: Some([8; 3]), voxel_type: None };
    let settings = PathTrace { environment: Environment::Image(image), ..PathTrace::default() };
    Scene { technique: Technique::PathTrace(settings), ..Scene::of(Source::Sample(ball)) }
}

/// Radiance from straight above and from straight below.
fn ends(scene: &Scene) -> [[f32; 3]; 2] {
    let Technique::PathTrace(settings) = &scene.technique else { panic!("{:?}", scene.technique) };
    let sky = settings.environment.resolve().unwrap().unwrap();
    [1.0, -1.0].map(|z| sky.radiance(glam::Vec3::new(0.0, 0.0, z)))
}

#[test]
fn pictures_of_the_sky_are_read_as_light() {
    let folder = tempfile::tempdir().unwrap();
    let channels = [("R", [7.0f32, 0.5]), ("G", [3.0, 0.25]), ("B", [1.0, 0.125])];
    let channels: Vec<(&str, &[f32])> = channels.iter().map(|(name, values)| (*name, values.as_slice())).collect();
    write_exr(folder.path().join("sky.exr"), 1, 2, &channels).unwrap();
    let mut lit = scene("sky.exr");
    load_optics(&mut lit, folder.path()).unwrap();
    assert_eq!(ends(&lit), [[7.0, 3.0, 1.0], [0.5, 0.25, 0.125]]);

    let pixels = PngPixels::U8(&[255, 128, 0, 10, 20, 30]);
    write_png(folder.path().join("sky.png"), 1, 2, pixels, Transfer::Srgb).unwrap();
    let mut lit = scene("sky.png");
    load_optics(&mut lit, folder.path()).unwrap();
    let decoded = |bytes: [u8; 3]| bytes.map(|v| srgb_decode(f32::from(v) / 255.0));
    assert_eq!(ends(&lit), [decoded([255, 128, 0]), decoded([10, 20, 30])]);
}

#[test]
fn what_cannot_be_read_or_used_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let error = |file: &str| load_optics(&mut scene(file), folder.path()).unwrap_err();
    assert!(matches!(error("none.exr"), LoadError::Io(IoError::Io { .. })));
    write_exr(folder.path().join("dark.exr"), 1, 1, &[("R", &[-1.0]), ("G", &[0.0]), ("B", &[0.0])]).unwrap();
    let negative = error("dark.exr").to_string();
    assert!(negative.contains("dark.exr") && negative.contains("texel 0, 0"), "{negative}");
}
